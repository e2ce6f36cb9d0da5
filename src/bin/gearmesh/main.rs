//! The command `gearmesh`.

fn main() {}
