//! libFuzzer on `gearmesh_fuzz::stored_state`.
#![no_main]

gearmesh_fuzz::libfuzzer!(stored_state);
