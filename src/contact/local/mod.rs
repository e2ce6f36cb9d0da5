//! Local contact: what the flanks of one strip give way close to where they touch, and how much of it the
//! elastic model of the teeth holds already.
//!
//! ```text
//! division: moves displacement from the bulk matrix, which holds it up to the reference length L of the
//!    │      elastic model, to the law until L suits the width of contact
//!    └─> hertz: line load over penetration, inside the flanks (inverted by lambert)
//!           └─> tip_edge: the same where contact reaches a tip edge
//!                  │      (corner: how much more the tooth gives way there than a half-plane)
//!                  └─> knee: the same where it reaches the start of a relief, by the
//!                            means of the gap over a contact (profile)
//! ```
//!
//! `width` estimates how wide the contacts of a pair become, `constants` holds every threshold.

pub mod constants;
mod corner;
mod division;
mod hertz;
mod knee;
mod lambert;
mod profile;
mod tip_edge;
mod width;

pub(super) use corner::Corner;
pub(super) use division::{Piece, divide};
pub(super) use hertz::{LocalBody, LocalContact, PointLoads};
pub(super) use profile::{Break, GapProfile};
pub use width::widest_contact;
