//! A checked gear pair, and what follows from its drawing alone: generated teeth, bodies, flank tolerances.

pub mod body;
mod pair;
mod profile;
pub mod tolerance;

pub use pair::{
    Bearing, BodyShape, HoleCircle, NodalStiffness, Operating, Pair, Refinement, Shaft,
    ShaftSection, UnevenBody,
};
#[cfg(test)]
pub(crate) use profile::tests::half_thickness_angle;
pub use profile::{ProfileError, ProfilePoint, ToothProfile, protuberance_form_radius};
