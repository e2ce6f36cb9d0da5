//! libFuzzer on `gearmesh_fuzz::pair_file`.
#![no_main]

use gearmesh_fuzz::pair_file;
use libfuzzer_sys::{fuzz_mutator, fuzz_target, fuzzer_mutate};

fuzz_target!(|data: &[u8]| {
    pair_file::check(data);
});

fuzz_mutator!(|data: &mut [u8], size: usize, longest: usize, seed: u32| {
    match gearmesh_fuzz::changed(&pair_file::TARGET, &data[..size], longest, seed) {
        Some(changed) => {
            data[..changed.len()].copy_from_slice(&changed);
            changed.len()
        }
        None => fuzzer_mutate(data, size, longest),
    }
});
