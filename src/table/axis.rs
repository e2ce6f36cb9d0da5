//! The coordinates of a grid.

/// A coordinate of the grid, in the order of [`Axes::lengths`](super::Axes::lengths).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Axis {
    CenterDistance,
    Misalignment,
    Displacement,
    MeshPosition,
}

impl Axis {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Axis::CenterDistance => "center_distance_offset_m",
            Axis::Misalignment => "misalignment_rad",
            Axis::Displacement => "displacement_fraction",
            Axis::MeshPosition => "mesh_position",
        }
    }
}
