//! Limits of the command line's numbers: refused before anything is computed or memory is asked for.
//!
//! The operating point has the limits that the pair file has for its `operating` fields.

use std::fmt::Display;
use std::ops::RangeInclusive;

use gearmesh::words::{number, shown};
use gearmesh_preprocessor::pair::TORQUES;

use crate::Error;

/// Positions over a mesh cycle where none are asked for: the same for numbers and for pictures, so that both show the same
/// largest pressure.
pub const POSITIONS: usize = 64;

/// Most positions that any mesh cycle needs.
pub const MOST_POSITIONS: usize = 100_000;

/// Misalignments, mrad, that a pair file may cover.
pub const MISALIGNMENTS: RangeInclusive<f64> = -20.0..=20.0;

/// Deviations from the nominal centre distance, um, that a pair file may cover.
pub const CENTER_DISTANCE_OFFSETS: RangeInclusive<f64> = -1e4..=1e4;

/// Refuses a torque, N m, that no pair file may cover; `option` gives it, as below.
pub fn torque(option: &str, nm: f64) -> Result<(), Error> {
    let [least, most] = TORQUES;
    if nm == 0.0 || (least..=most).contains(&nm) {
        return Ok(());
    }
    let nm = number(nm);
    Err(format!("--{option} = {nm}: give 0 or a value from {least:e} to {most:e}").into())
}

/// Refuses what lies outside `range`; NaN lies outside every range.
pub fn within<T: PartialOrd + Display>(
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
        assert!(within("a", 1, 1..=MOST_POSITIONS).is_ok() && torque("a", 0.0).is_ok());
        assert!(within("a", -1e4, CENTER_DISTANCE_OFFSETS).is_ok());
        assert!(within("a", 20.0, MISALIGNMENTS).is_ok());
        let message = within("positions", 100_000_000_000, 1..=MOST_POSITIONS).unwrap_err();
        assert!(message.to_string().contains("--positions = 100000000000"));
        let offset = |name: &str, value| within(name, value, CENTER_DISTANCE_OFFSETS);
        let misalignment = |name: &str, value| within(name, value, MISALIGNMENTS);
        for refused in [&torque as &dyn Fn(&str, f64) -> _, &offset, &misalignment] {
            let message = refused("the-option", f64::NAN).unwrap_err().to_string();
            assert!(message.contains("--the-option = NaN"), "{message}");
            let message = refused("the-option", 1e300).unwrap_err().to_string();
            assert!(message.contains("--the-option = 1e300:"), "{message}");
        }
    }
}
