//! Friction between the teeth: the laws of its coefficient in one place, and the loss that follows.
//!
//! Where teeth touch at the distance s from the pitch point along the line of action, they slide on one
//! another with omega_rel s, omega_rel the difference of both spins. Friction acts against that, across the line of action
//! in the transverse plane, with mu times the normal force. What a pose and its load say of it is gathered in
//! [`Sliding`]; what the oil and the speed say, in [`FrictionLaw`].

mod coefficient;
mod sliding;

pub use coefficient::{Coefficient, FrictionLaw, LOWEST_ROLLING_SPEED, SegmentContact};
pub use sliding::{Loss, Sliding, SlidingSums, loss_factor_of, ohlendorf};

#[cfg(test)]
use crate::gear::samples as gears;
#[cfg(test)]
#[path = "../../tests/common/fzg.rs"]
pub(crate) mod testing;
