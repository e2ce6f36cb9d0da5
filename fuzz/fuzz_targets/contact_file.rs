//! libFuzzer on `gearmesh_fuzz::contact_file`.
#![no_main]

gearmesh_fuzz::libfuzzer!(contact_file);
