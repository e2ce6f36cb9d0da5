//! Dimensions as drawings give them.

use gearmesh::words::rounded;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::fmt;
use std::ops::Neg;

/// A dimension of a drawing: a number, or its limits, of which the middle counts.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(untagged, try_from = "Value")]
pub enum Dimension {
    Nominal(f64),
    Limits([f64; 2]),
}

impl TryFrom<Value> for Dimension {
    type Error = String;

    fn try_from(value: Value) -> Result<Dimension, String> {
        let count = value.as_array().map_or(0, Vec::len);
        let [first, second] = [0, 1].map(|i| value.get(i)?.as_f64());
        match (value.as_f64(), count, first, second) {
            (Some(number), ..) => Ok(Dimension::Nominal(number)),
            (_, 2, Some(a), Some(b)) if a <= b => Ok(Dimension::Limits([a, b])),
            (_, 2, Some(_), Some(_)) => {
                Err(format!("`{value}`; the lower limit first is expected"))
            }
            _ => Err(format!(
                "`{value}`; a bare number or [lower, upper] is expected"
            )),
        }
    }
}

impl Dimension {
    pub fn middle(self) -> f64 {
        match self {
            Dimension::Nominal(value) => value,
            Dimension::Limits([low, high]) => 0.5 * (low + high),
        }
    }

    pub(super) fn slack(self) -> f64 {
        match self {
            Dimension::Nominal(_) => 0.0,
            Dimension::Limits([low, high]) => 0.5 * (high - low),
        }
    }
}

impl Neg for Dimension {
    type Output = Dimension;

    fn neg(self) -> Dimension {
        match self {
            Dimension::Nominal(value) => Dimension::Nominal(-value),
            Dimension::Limits([low, high]) => Dimension::Limits([-high, -low]),
        }
    }
}

impl fmt::Display for Dimension {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Dimension::Nominal(value) => write!(f, "{}", rounded(value)),
            Dimension::Limits([low, high]) => write!(f, "[{}, {}]", rounded(low), rounded(high)),
        }
    }
}
