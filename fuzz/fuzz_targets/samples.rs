//! libFuzzer on `gearmesh_fuzz::samples`.
#![no_main]

gearmesh_fuzz::libfuzzer!(samples);
