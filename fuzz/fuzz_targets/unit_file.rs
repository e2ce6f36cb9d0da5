//! libFuzzer on `gearmesh_fuzz::unit_file`.
#![no_main]

use gearmesh_fuzz::unit_file;
use libfuzzer_sys::{fuzz_mutator, fuzz_target, fuzzer_mutate};

fuzz_target!(|data: &[u8]| {
    unit_file::check(data);
});

fuzz_mutator!(|data: &mut [u8], size: usize, longest: usize, seed: u32| {
    match gearmesh_fuzz::changed(&unit_file::TARGET, &data[..size], longest, seed) {
        Some(changed) => {
            data[..changed.len()].copy_from_slice(&changed);
            changed.len()
        }
        None => fuzzer_mutate(data, size, longest),
    }
});
