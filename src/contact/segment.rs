//! A piece of a contact line in the coordinates of one gear.

/// A piece of a contact line as one gear sees it, in canonical coordinates of that gear: a
/// right-handed gear whose loaded flank faces +theta ([`Segment::tooth`] counts in +theta, `z` from
/// the z = 0 face). The contact solver maps left-handed gears and the other flank onto it by mirrors.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Segment {
    /// Number of the tooth, counted in +theta from the one that touches at the pitch point at mesh
    /// position 0. Only differences matter.
    pub tooth: i32,
    /// z of both ends, m, ascending, within the face.
    pub z: [f64; 2],
    /// Length of roll (transverse) at these ends, m.
    pub roll: [f64; 2],
}
