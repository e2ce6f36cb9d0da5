//! Limits of the command line's numbers: refused before anything is computed or memory is asked for.
//!
//! The operating point has the limits that the pair file has for its `operating` fields.

use std::fmt::Display;
use std::ops::RangeInclusive;

use gearmesh::pair::TORQUES;
use gearmesh::words::{number, shown};

use crate::Error;

/// Positions over a mesh cycle where none are asked for: the same for numbers and for pictures, so that both show the same
/// largest pressure.
pub const POSITIONS: usize = 64;

/// Refuses a number of positions that no mesh cycle needs.
pub fn positions(count: usize) -> Result<(), Error> {
    within("positions", count, 1..=100_000)
}

/// Refuses a number of samples that no study needs.
pub fn samples(count: usize) -> Result<(), Error> {
    within("samples", count, 1..=1_000_000)
}

/// Refuses more loads than results fit into memory.
pub fn cases(count: usize) -> Result<(), Error> {
    within("torque-nm times --misalignment-mrad", count, 1..=10_000)
}

/// Refuses a number of stations along the face whose influence matrix would not fit into memory.
pub fn stations(count: usize) -> Result<(), Error> {
    within("stations", count, 1..=1000)
}

/// Refuses more threads than the largest machines have cores: each takes memory and time to start.
pub fn threads(count: usize) -> Result<(), Error> {
    within("threads", count, 1..=1024)
}

/// Refuses a torque, N m, that no pair file may cover; `option` gives it, as below.
pub fn torque(option: &str, nm: f64) -> Result<(), Error> {
    let [least, most] = TORQUES;
    if nm == 0.0 || (least..=most).contains(&nm) {
        return Ok(());
    }
    let nm = number(nm);
    Err(format!("--{option} = {nm}: give 0 or a value from {least:e} to {most:e}").into())
}

/// Refuses a centre distance, um, that no pair file may cover.
pub fn center_distance_offset(option: &str, um: f64) -> Result<(), Error> {
    within(option, um, -1e4..=1e4)
}

/// Refuses a misalignment, mrad, that no pair file may cover.
pub fn misalignment(option: &str, mrad: f64) -> Result<(), Error> {
    within(option, mrad, -20.0..=20.0)
}

/// Refuses a speed of gear 1, rpm, that no gear has.
pub fn speed(rpm: f64) -> Result<(), Error> {
    within("speed-rpm", rpm, 0.0..=1e6)
}

/// Refuses an end of the axis of speeds, rpm, that no gear has or that leaves nothing to draw.
pub fn largest_speed(rpm: f64) -> Result<(), Error> {
    within("largest-speed-rpm", rpm, 1.0..=1e6)
}

/// Refuses what lies outside `range`; NaN lies outside every range.
fn within<T: PartialOrd + Display>(
    option: &str,
    value: T,
    range: RangeInclusive<T>,
) -> Result<(), Error> {
    if range.contains(&value) {
        return Ok(());
    }
    let (low, high) = range.into_inner();
    let value = shown(&value.to_string());
    Err(format!("--{option} = {value}: give a value from {low} to {high}").into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_would_exhaust_memory_is_refused_by_name() {
        let message = positions(100_000_000_000).unwrap_err().to_string();
        assert!(message.contains("--positions = 100000000000"), "{message}");
        let message = stations(1_000_000_000).unwrap_err().to_string();
        assert!(message.contains("--stations = 1000000000"), "{message}");
        let message = threads(10_000).unwrap_err().to_string();
        assert!(message.contains("--threads = 10000"), "{message}");
        assert!(positions(0).is_err() && stations(0).is_err() && threads(0).is_err());
    }

    #[test]
    fn a_torque_that_rounding_outweighs_is_refused_in_few_digits() {
        let message = torque("torque-nm", 1e-20).unwrap_err().to_string();
        assert_eq!(
            message,
            "--torque-nm = 1e-20: give 0 or a value from 1e-9 to 1e9"
        );
        assert!(torque("torque-nm", 1e-9).is_ok() && torque("torque-nm", -1e-9).is_err());
    }

    #[test]
    fn the_edges_of_the_range_are_allowed_and_nan_is_not() {
        assert!(positions(1).is_ok() && stations(1000).is_ok());
        assert!(torque("a", 0.0).is_ok() && center_distance_offset("a", -1e4).is_ok());
        assert!(misalignment("a", 20.0).is_ok());
        for refused in [torque, center_distance_offset, misalignment] {
            let message = refused("the-option", f64::NAN).unwrap_err().to_string();
            assert!(message.contains("--the-option = NaN"), "{message}");
            let message = refused("the-option", 1e300).unwrap_err().to_string();
            assert!(message.contains("--the-option = 1e300:"), "{message}");
        }
    }
}
