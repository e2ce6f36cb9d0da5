//! libFuzzer on `gearmesh_fuzz::pair_file`.
#![no_main]

gearmesh_fuzz::libfuzzer!(pair_file);
