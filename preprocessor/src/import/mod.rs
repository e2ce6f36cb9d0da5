//! Files of other programs as input of this one.

pub mod rexs;
