//! What comes from outside and is read: pair files, REXS files, tables, samples for `import`, the other files of a unit, stored states. Each has inputs to
//! start from, a way to change them that keeps their form more often than changed bytes do, and a check: the input is
//! refused with a message or gives something that works; a panic, or a result that is NaN or infinite, is a finding.
//!
//! libFuzzer drives this from fuzz/fuzz_targets, `make test` in a short form from tests/fuzz.rs.

pub mod change;
pub mod contact_file;
#[path = "../../tests/common/gears.rs"]
mod gears;
pub mod pair_file;
pub mod rexs_file;
pub mod samples;
#[path = "../../tests/common/spring.rs"]
mod spring;
pub mod stored_state;
pub mod tables;
pub mod unit_file;

use gearmesh::random::Random;

/// One kind of input.
pub struct Target {
    /// Inputs to start from, all of them accepted.
    pub seeds: fn() -> Vec<Vec<u8>>,
    /// An input changed in one to three places; those without the form, in bytes.
    pub change: fn(&[u8], &mut Random) -> Vec<u8>,
    /// Reads an input and uses what it gives; true if it was accepted. Panics are findings.
    pub check: fn(&[u8]) -> bool,
}

/// The program that runs libFuzzer on one of the modules.
#[macro_export]
macro_rules! libfuzzer {
    ($target:ident) => {
        use libfuzzer_sys::{fuzz_mutator, fuzz_target, fuzzer_mutate};

        fuzz_target!(|data: &[u8]| {
            $crate::$target::check(data);
        });

        fuzz_mutator!(|data: &mut [u8], size: usize, longest: usize, seed: u32| {
            let target = &$crate::$target::TARGET;
            match $crate::changed(target, &data[..size], longest, seed) {
                Some(changed) => {
                    data[..changed.len()].copy_from_slice(&changed);
                    changed.len()
                }
                None => fuzzer_mutate(data, size, longest),
            }
        });
    };
}

/// `data` changed as the target has it, or one of its seeds in place of nothing, if that is no longer than `longest` and
/// this is not the one time in four in which bytes are to be changed.
pub fn changed(target: &Target, data: &[u8], longest: usize, seed: u32) -> Option<Vec<u8>> {
    if seed.is_multiple_of(4) {
        return None;
    }
    let mut random = random(seed);
    // libFuzzer begins with next to nothing.
    let changed = if data.len() < 2 {
        let mut seeds = (target.seeds)();
        seeds.swap_remove(change::below(seeds.len(), &mut random))
    } else {
        (target.change)(data, &mut random)
    };
    (changed.len() <= longest).then_some(changed)
}

/// A sequence for each `seed`.
pub fn random(seed: u32) -> Random {
    let mut random = Random::new((u64::from(seed) + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15));
    // Seeds that are alike begin alike.
    for _ in 0..4 {
        random.next();
    }
    random
}

/// Whether a reader accepted its input; a refusal says in few words what is wrong.
pub fn accepted<T>(read: Result<T, String>, use_it: impl FnOnce(T)) -> bool {
    match read {
        Ok(made) => {
            use_it(made);
            true
        }
        Err(reason) => {
            assert!(!reason.is_empty() && reason.len() < 500, "{reason}");
            false
        }
    }
}
