//! A gear pair with all that preparing its contact starts from, SI.

use serde::{Deserialize, Serialize};

use crate::friction::FrictionLaw;
use crate::gear::{BothFlanks, Microgeometry, PairGeometry, PairMicrogeometry, PairTeeth};

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
    /// What is legal but worth knowing, one sentence each.
    pub warnings: Vec<String>,
}

impl Pair {
    /// Whether the coast flank is the drive flank seen with both gears turned end for end, so that one
    /// table serves both (with M -> -M and z_c mirrored at mid-face): both flanks modified alike and the same
    /// from both ends of the face, as are both bodies, and both faces share their middle.
    pub fn coast_mirrors_drive(&self) -> bool {
        let middle = |i: usize| {
            let g = &self.geometry.gears[i];
            g.face_offset + 0.5 * g.face_width
        };
        // Faces are given to a micrometre at best.
        let shares_middle = (middle(0) - middle(1)).abs() < 1e-9;
        let BothFlanks { drive, coast } = &self.microgeometry;
        shares_middle
            && (self.geometry.gears.iter()).all(|gear| gear.turned().is_none())
            && drive == coast
            && drive.iter().all(Microgeometry::is_symmetric)
    }
}
