//! Tables of force and shuttling over (displacement, centre distance, misalignment, mesh position).

/// Where the table is asked, for one flank (coast flank: after mapping to its own table).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Query {
    /// Elongation on the line of action at mid-face, m; > 0 compresses.
    pub delta: f64,
    /// Actual minus nominal centre distance, m.
    pub center_distance_offset: f64,
    /// Misalignment in the plane of action, rad; > 0: more penetration at larger z.
    pub misalignment: f64,
    /// Position on the mesh cycle, in base pitches; periodic.
    pub mesh_position: f64,
}

/// Number of coordinates of a [`Query`], in the order of its fields.
pub const COORDINATES: usize = 4;

/// The potential of one flank and its derivatives by the coordinates of [`Query`] in their order
/// (delta, centre distance offset, misalignment, mesh position). All zero out of contact.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Potential {
    /// W, J.
    pub value: f64,
    /// First derivatives: F_bt = `gradient[0]`, shuttling moment F_bt (z_c - z_ref) = `gradient[2]`.
    pub gradient: [f64; COORDINATES],
    /// Second derivatives, symmetric; `hessian[0][0]` is the tangent stiffness on the line of action.
    /// Zero unless asked for.
    pub hessian: [[f64; COORDINATES]; COORDINATES],
    /// True where a coordinate lies outside the table's range (continued linearly).
    pub out_of_range: bool,
}
