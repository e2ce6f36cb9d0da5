//! Limits of the command line's numbers: refused before anything is computed or memory is reserved.
//!
//! The operating point has the limits that the pair file has for its `operating` fields.

use std::fmt::Display;
use std::ops::RangeInclusive;
use std::str::FromStr;

use gearmesh_preprocessor::pair::{LARGEST_CENTER_DISTANCE_OFFSET, LARGEST_MISALIGNMENT, TORQUES};

/// Positions over a mesh cycle by default: the same for numbers and for pictures, so that both show the same largest pressure.
pub const POSITIONS: usize = 64;

pub const MOST_POSITIONS: usize = 100_000;

/// Misalignments, mrad, that a pair file may cover.
pub const MISALIGNMENTS: RangeInclusive<f64> = -LARGEST_MISALIGNMENT..=LARGEST_MISALIGNMENT;

/// Deviations from the nominal centre distance, um, that a pair file may cover.
pub const CENTER_DISTANCE_OFFSETS: RangeInclusive<f64> =
    -LARGEST_CENTER_DISTANCE_OFFSET..=LARGEST_CENTER_DISTANCE_OFFSET;

/// A parser of numbers within `range`; NaN lies outside every range.
pub fn within<T: FromStr + PartialOrd + Display + Clone>(
    range: RangeInclusive<T>,
) -> impl Fn(&str) -> Result<T, String> + Clone {
    move |text| check(text.parse().ok(), &range)
}

/// `value`, refused where it lies outside `range` or is none.
pub fn check<T: PartialOrd + Display>(
    value: Option<T>,
    range: &RangeInclusive<T>,
) -> Result<T, String> {
    let within = value.filter(|value| range.contains(value));
    within.ok_or_else(|| format!("give a value from {} to {}", range.start(), range.end()))
}

pub fn finite(text: &str) -> Result<f64, String> {
    let value = text.trim().parse().unwrap_or(f64::NAN);
    value
        .is_finite()
        .then_some(value)
        .ok_or_else(|| "give a finite number".to_owned())
}

pub fn positive(text: &str) -> Result<f64, String> {
    finite(text).and_then(|value| match value > 0.0 {
        true => Ok(value),
        false => Err("give a number above 0".to_owned()),
    })
}

/// A parser of torques, N m, that a pair file may cover.
pub fn torque(text: &str) -> Result<f64, String> {
    check_torque(text.parse().unwrap_or(f64::NAN))
}

/// `nm`, refused where no pair file may cover it.
pub fn check_torque(nm: f64) -> Result<f64, String> {
    let [least, most] = TORQUES;
    if nm == 0.0 || (least..=most).contains(&nm) {
        return Ok(nm);
    }
    Err(format!("give 0 or a value from {least:e} to {most:e}"))
}
