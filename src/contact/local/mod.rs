//! Local contact: what the flanks of one segment give way close to where they touch.
//!
//! ```text
//! law: line load over penetration, inside the flanks
//!  └─> tip_edge: the same where contact reaches a tip edge, where the tooth gives way more than a half-plane
//!       └─> knee: the same where it reaches the start of a relief, by the
//!                 means of the gap over a contact (profile)
//! ```
//!
//! `constants` holds every threshold.

pub mod constants;
mod knee;
mod law;
mod profile;
mod tip_edge;

pub(super) use law::{LocalBody, LocalContact, PointLoads};
pub(super) use profile::{Break, GapProfile};
pub(super) use tip_edge::Corner;
