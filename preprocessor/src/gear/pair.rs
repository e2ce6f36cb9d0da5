//! A gear pair with all that preparing its contact starts from, SI.

use std::sync::Arc;

use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

use super::body;
use gearmesh::contact::STIFFNESS_OVER_MODULUS;
use gearmesh::friction::FrictionLaw;
use gearmesh::gear::{BothFlanks, Gear, Microgeometry, PairGeometry, PairMicrogeometry, PairTeeth};

/// Fineness of the finite-element model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[allow(missing_docs)]
pub enum Refinement {
    Coarse,
    #[default]
    Normal,
    /// For convergence studies.
    Fine,
}

/// Loads and deviations that tables are to cover.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Operating {
    /// Nominal torque on gear 1, N m, > 0.
    pub nominal_torque: f64,
    /// Highest torque on gear 1, N m, >= nominal.
    pub maximum_torque: f64,
    /// Lowest (<= 0) and highest (>= 0) deviation from the nominal centre distance, m.
    pub center_distance_offset: [f64; 2],
    /// Lowest (<= 0) and highest (>= 0) misalignment in the plane of action, rad.
    pub misalignment: [f64; 2],
}

/// The shaft of a gear on its bearings. z counts from the gear's own z = 0 face, m.
#[derive(Debug, Clone, PartialEq)]
pub struct Shaft {
    /// Where the first section begins, m.
    pub start: f64,
    /// From low to high z, at least one.
    pub sections: Vec<ShaftSection>,
    /// At least one.
    pub bearings: Vec<Bearing>,
    /// Whether the torque enters at the end of high z, else at that of low z.
    pub torque_at_upper_end: bool,
    /// Young's modulus of the shaft, Pa.
    pub youngs_modulus: f64,
    /// Poisson ratio of the shaft.
    pub poisson_ratio: f64,
    /// Where the body of the gear stiffens the shaft, m.
    pub seat: [f64; 2],
    /// Radius up to which it does, m.
    pub seat_radius: f64,
}

/// A cylindrical piece of a [`Shaft`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShaftSection {
    /// Inner (0: solid) and outer radius, m.
    pub radii: [f64; 2],
    /// m.
    pub length: f64,
}

/// A bearing of a [`Shaft`], alike in all radial directions. The housing is rigid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bearing {
    /// m from the gear's z = 0 face.
    pub z: f64,
    /// N/m, > 0.
    pub radial_stiffness: f64,
    /// N/m, >= 0, in both senses.
    pub axial_stiffness: f64,
    /// Against tilting about any radial axis, N m/rad, >= 0.
    pub tilt_stiffness: f64,
    /// How far the shaft moves radially from the middle before it bears, m: half of the radial internal clearance of ISO 5753-1.
    pub free_radius: f64,
}

impl Shaft {
    /// Ends of all sections, m, ascending.
    pub fn section_ends(&self) -> Vec<f64> {
        let mut ends = vec![self.start];
        for section in &self.sections {
            ends.push(ends[ends.len() - 1] + section.length);
        }
        ends
    }

    /// Inner and outer radius at `z`, m; beyond its ends those of the outermost section.
    pub fn radii_at(&self, z: f64) -> [f64; 2] {
        let ends = self.section_ends();
        let section = ends[1..].partition_point(|end| *end < z);
        self.sections[section.min(self.sections.len() - 1)].radii
    }
}

/// A body that is no solid of revolution: what holds teeth and rim at a cylinder below the teeth (of a ring outside of them).
///
/// Angles count from body +x in +theta, z from the gear's z = 0 face.
#[derive(Debug, Clone, PartialEq)]
pub struct UnevenBody {
    /// Radius of the cylinder, m.
    pub radius: f64,
    /// Ends of the cylinder along the axis, m.
    pub z: [f64; 2],
    /// What it is.
    pub shape: BodyShape,
}

/// What an [`UnevenBody`] is.
#[derive(Debug, Clone, PartialEq)]
pub enum BodyShape {
    /// Its stiffness at nodes on the cylinder.
    Nodes(Arc<NodalStiffness>),
    /// Web and hub of the gear with round holes through the web.
    Holes(HoleCircle),
    /// The rest of a ring, its outside free, held all over the cross-sections of pins or bolts through it.
    Pins(HoleCircle),
    /// The rest of a ring, held over parts of its outside.
    Supports {
        /// At equal distances.
        count: u32,
        /// Of each, rad.
        width: f64,
        /// Where the middle of one of them lies, rad.
        angle: f64,
    },
}

/// Equal round holes at equal distances on a circle about the axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HoleCircle {
    /// Number of holes.
    pub count: u32,
    /// Radius of the circle through their middles, m.
    pub circle_radius: f64,
    /// Radius of each, m.
    pub radius: f64,
    /// Where the middle of one of them lies, rad.
    pub angle: f64,
}

/// Stiffness of a body at nodes on a cylinder, its supports included.
#[derive(Debug, Clone, PartialEq)]
pub struct NodalStiffness {
    /// The nodes, m.
    pub points: Vec<[f64; 3]>,
    /// Symmetric and positive definite, N/m; the displacements of a node along x, y and z follow each other.
    pub stiffness: DMatrix<f64>,
    /// Highest harmonic of the angle that the nodes resolve.
    pub orders: usize,
    /// Number of their places along the axis.
    pub stations: usize,
}

/// A gear pair that has passed all checks, SI.
#[derive(Debug, Clone, PartialEq)]
pub struct Pair {
    /// Name for files and titles.
    pub name: String,
    /// The two gears and their centre distance.
    pub geometry: PairGeometry,
    /// Modifications of both flanks of gear 1 and gear 2.
    pub microgeometry: PairMicrogeometry,
    /// Teeth that differ from each other; static contact and tables take them as all alike.
    pub teeth: PairTeeth,
    /// Loads and deviations to be covered.
    pub operating: Operating,
    /// Fineness of the finite elements.
    pub refinement: Refinement,
    /// Whether contact of tip corners outside the path of contact is counted.
    pub tip_corner_contact: bool,
    /// Law of the coefficient of friction.
    pub friction: FrictionLaw,
    /// Shafts of gear 1 and gear 2 on their bearings. Static analyses alone know them: tables end at the gears.
    pub shafts: [Option<Shaft>; 2],
    /// Bodies of gear 1 and gear 2 that are no solids of revolution. Tables and contact at run time have their mean over all angles, and what
    /// they change with the angle beside it.
    pub bodies: [Option<UnevenBody>; 2],
    /// What is legal but worth knowing, one sentence each.
    pub warnings: Vec<String>,
}

impl Pair {
    /// Whether the coast flank is the drive flank seen with both gears turned end for end, so that one
    /// table serves both (with M -> -M and z_c mirrored at mid-face): both flanks modified alike, and all the same from both ends.
    pub fn coast_mirrors_drive(&self) -> bool {
        let BothFlanks { drive, coast } = &self.microgeometry;
        drive == coast && self.is_same_from_both_ends()
    }

    /// Whether mid-face mirrors the pair: at the misalignment -M the force is that at M, its moment the opposite one. The mirror image of
    /// a helical tooth has the other hand.
    pub fn is_mirrored_at_mid_face(&self) -> bool {
        self.geometry.base_helix_angle() == 0.0 && self.is_same_from_both_ends()
    }

    /// Whether flanks and bodies are the same from both ends of the face, whose middle both gears share.
    fn is_same_from_both_ends(&self) -> bool {
        let gears = self.geometry.gears.each_ref();
        let middles = gears.map(|gear| gear.face_offset + 0.5 * gear.face_width);
        // Faces are given to a micrometre at best.
        let shares_middle = (middles[0] - middles[1]).abs() < 1e-9;
        let BothFlanks { drive, coast } = &self.microgeometry;
        let are_even = self.bodies.iter().all(Option::is_none);
        (shares_middle && are_even)
            && (self.geometry.gears.iter()).all(|gear| body::turned(gear).is_none())
            && drive.iter().chain(coast).all(Microgeometry::is_symmetric)
    }

    /// Estimate of the largest Hertz half-width of the pair, m: the maximum torque on one tooth pair, spread
    /// over the face evenly or, with misalignment, as a triangle on an elastic foundation.
    pub fn largest_half_width(&self) -> f64 {
        let g = &self.geometry;
        let c = g.center_distance;
        let path = g.path_of_contact(c);
        let radii = (0..=20).map(|i| {
            let xi = path.start + path.length() * f64::from(i) / 20.0;
            let rho = [0, 1].map(|k| g.gears[k].kappa() * g.roll_at(k, c, xi));
            1.0 / (1.0 / rho[0] + 1.0 / rho[1])
        });
        let radius = radii.fold(0.0, f64::max) / g.base_helix_angle().cos();
        let force = self.operating.maximum_torque / g.gears[0].base_radius();
        let modulus = g.gears[0].youngs_modulus.min(g.gears[1].youngs_modulus);
        let [low, high] = self.operating.misalignment.map(f64::abs);
        let misalignment = low.max(high);
        let triangle = (2.0 * force * STIFFNESS_OVER_MODULUS * modulus * misalignment).sqrt();
        let line_load = (force / g.face_overlap().1).max(triangle);
        let softness: f64 = g.gears.iter().map(Gear::plane_compliance).sum();
        (4.0 * line_load * radius * softness / std::f64::consts::PI).sqrt()
    }
}
