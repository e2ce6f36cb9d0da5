//! libFuzzer on `gearmesh_fuzz::unit_file`.
#![no_main]

gearmesh_fuzz::libfuzzer!(unit_file);
