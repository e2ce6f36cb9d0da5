//! Local contact: what the flanks of one segment give way close to where they touch, and how much of it the
//! elastic model of the teeth holds already.
//!
//! ```text
//! division: moves displacement from the bulk matrix, which holds it up to the reference length L of the
//!    │      elastic model, to the law until L suits the width of contact
//!    └─> law: line load over penetration, inside the flanks
//!           └─> tip_edge: the same where contact reaches a tip edge, where the tooth gives way more than a half-plane
//!                  └─> knee: the same where it reaches the start of a relief, by the
//!                            means of the gap over a contact (profile)
//! ```
//!
//! `constants` holds every threshold.

pub mod constants;
mod division;
mod knee;
mod law;
mod profile;
mod tip_edge;

pub(super) use division::{Piece, divide};
pub(super) use law::{LocalBody, LocalContact, PointLoads};
pub(super) use profile::{Break, GapProfile};
pub(super) use tip_edge::Corner;
