//! The constants of the local contact, each with where it comes from.

/// Half-width of contact over the reference length from which the law goes on along its tangent.
///
/// h(w) = c w (ln(2 L / b) + 1/2) has the slope c ln(2 L / b): none at b = 2 L. At 1.5 a quarter of c is left.
/// Beyond, the tangent is softer than the law by 0.07 c w at b = 2 L, a hundredth of the deflection of a
/// tooth pair, and keeps the problem convex and every iterate defined.
pub const WIDTH_OVER_REFERENCE: f64 = 1.5;

/// Half-width of contact over the relative radius of curvature beyond which a load is refused.
///
/// b / R = 2 p / E', E' = E / (2 (1 - nu²)) for equal materials: 0.15 is 8.5 GPa between steel flanks, twice
/// what rolling bearings are allowed before a dent remains (ISO 76: 4 to 4.6 GPa).
pub const LARGEST_HALF_WIDTH_OVER_RADIUS: f64 = 0.15;

/// Widths, closer together where contact first reaches the start of a relief, through which its law is followed. Measured: line loads
/// within 1e-3, at the knee within 5e-3.
pub const KNEE_NODES: usize = 10;

/// Distance over the radius of curvature on both sides of the closest point over which the second difference of a
/// topography gives its curvature: the half-width of contact b / R = 4 p (1 - nu²) / E.
pub const TOPOGRAPHY_OVER_RADIUS: f64 = 0.02;

/// Least curvature of a gap with a topography over that of the involutes. About the closest point of the flank no
/// second difference of the gap is negative, but a hollow may fit the mate all over.
pub const LEAST_CURVATURE: f64 = 0.1;

/// Reference length aimed at over the half-width of the widest contact: with [`WIDTH_OVER_REFERENCE`] the law
/// holds up to 2.25 times the line load that was estimated.
pub const REFERENCE_OVER_HERTZ: f64 = 1.0;

/// Range over which a load is smoothed along the contact line, over the layers of the elements: elements
/// know no load that alternates within a layer. Measured: least at which the bulk stays positive definite at all levels.
pub const SMOOTHING_OVER_LAYER: f64 = 1.5;

/// The same over the reference length L. A half-space under a line load of the wavelength 2 l gives way
/// by c (ln(2 l / (pi L)) - 0.577): nothing is left at l = 2.8 L.
pub const SMOOTHING_OVER_REFERENCE: f64 = 3.0;

/// Largest part of the displacement of a whole contact line under an even load that the local contact takes
/// over: the law of a line contact does not hold for lines shorter than their contact is wide.
pub const SHARE_OF_A_LINE: f64 = 0.5;

/// How far the bulk matrix may be from positive definite, over c / l: the law of local contact, at
/// least ln(2 / [`WIDTH_OVER_REFERENCE`]) of c / l, is added to it, and rounding makes the matrix of segments
/// much shorter than the elements indefinite by itself.
pub const INDEFINITE: f64 = 2e-5;

/// Part of the change of a gap along a segment that local contact takes up at run time; the bulk displacement follows the rest. Less
/// makes force and moment more exact, more the stiffness, whose error is the steps in which segments meet
/// (docs/theory/contact.md).
pub const OWN_SHARE_ALONG_SEGMENT: f64 = 0.45;

/// Stiffness of a tooth pair per length of contact line over Young's modulus: for starting values, for how
/// far tip edges are followed and for how wide contacts become. ISO 6336-1: 14 N/(mm um) for steel.
pub const STIFFNESS_OVER_MODULUS: f64 = 0.07;

/// Stations along the face of a pair whose contacts are narrow (docs/validation.md).
pub const MOST_STATIONS: usize = 40;

/// Stations at most of contact at run time (docs/theory/contact.md). Loads need no more, the pressure along the face does.
pub const RUN_TIME_STATIONS: usize = 22;

/// Least number of stations.
pub const FEWEST_STATIONS: usize = 10;

/// Least length of a station over the width of the widest contact: a shorter segment is no line contact of its own.
pub const SEGMENT_OVER_WIDTH: f64 = 1.0;
