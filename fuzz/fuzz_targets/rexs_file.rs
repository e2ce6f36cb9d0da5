//! libFuzzer on `gearmesh_fuzz::rexs_file`.
#![no_main]

gearmesh_fuzz::libfuzzer!(rexs_file);
