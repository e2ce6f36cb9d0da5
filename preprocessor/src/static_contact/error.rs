//! What the contact solver refuses, and why.

use thiserror::Error;

use crate::compliance::BeyondModel;
use crate::gear::ProfileError;
use gearmesh::words::rounded;

/// Errors of the contact solver.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ContactError {
    /// What a solve at run time refuses, too.
    #[error(transparent)]
    Solve(#[from] gearmesh::contact::ContactError),
    /// A gear has no usable tooth.
    #[error("no tooth to touch: {0}; check module, profile shift and tip diameter")]
    Profile(#[from] ProfileError),
    /// Teeth may touch that lie farther apart than the elastic model was computed for.
    #[error(
        "center distance offset = {} um: {model}; state it in \
         operating.center_distance_offset_um in the pair file, from which the model's reach follows, or bring \
         it nearer to zero",
        rounded(1e6 * center_distance_offset)
    )]
    BeyondModel {
        /// Deviation from the nominal centre distance, m.
        center_distance_offset: f64,
        /// What the elastic model said.
        model: BeyondModel,
    },
}

impl ContactError {
    /// A setting, load, approach, misalignment or mesh position out of its range.
    pub fn input(field: &'static str, value: f64, remedy: &'static str) -> ContactError {
        gearmesh::contact::ContactError::input(field, value, remedy).into()
    }
}
