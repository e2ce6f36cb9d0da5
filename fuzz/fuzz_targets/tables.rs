//! libFuzzer on `gearmesh_fuzz::tables`.
#![no_main]

gearmesh_fuzz::libfuzzer!(tables);
