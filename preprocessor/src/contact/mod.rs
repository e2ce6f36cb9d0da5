//! What static contact says over a mesh cycle, in the tooth roots, and condensed for a solve at run time.

mod condense;
mod mesh_cycle;
mod root_stress;

pub use condense::{condensed_flank, condensed_roots, contact_file};
pub use mesh_cycle::{
    CycleInput, ENOUGH_SEGMENTS, FaceLoad, HARMONICS, Harmonic, LoadCase, MeshCycle, harmonics,
};
pub use root_stress::{GearRoots, PositionRoots, ToothRoot};
