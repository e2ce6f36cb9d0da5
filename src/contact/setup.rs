//! A pair as its contact sees it, without the elastic model of its teeth.

use serde::{Deserialize, Serialize};

use super::candidates::ContactLines;
use super::error::ContactError;
use super::local::constants::{
    FEWEST_STATIONS, MOST_STATIONS, SEGMENT_OVER_WIDTH, STIFFNESS_OVER_MODULUS,
};
use super::position::Limits;
use super::transverse::{PairNumbers, TransverseSection};
use crate::gear::{Flank, PairGeometry, PairMicrogeometry, PairTeeth};
use crate::pair::{Pair, Refinement};
use crate::table::GeometryRecord;

/// How the contact is discretised.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ContactSettings {
    /// Number of equal stations over the overlap of both faces.
    pub stations: usize,
    /// Part of what a gap changes by along a segment that local contact takes up. The bulk displacement of a segment is one number, its
    /// mean; that of the teeth follows a load that changes along the line. With 1, all of the change, forces come out too high by the square of the
    /// segments' length.
    #[serde(default = "all")]
    pub own_share: f64,
    /// Whether tip corners outside the path of contact may touch.
    pub tip_corner_contact: bool,
    /// Largest approach on the line of action for which tip corners are followed, m. None: from
    /// the largest torque and misalignment of the pair.
    pub reach: Option<f64>,
}

/// Of units that know of no share.
fn all() -> f64 {
    1.0
}

impl Default for ContactSettings {
    fn default() -> Self {
        ContactSettings {
            stations: MOST_STATIONS,
            own_share: all(),
            tip_corner_contact: true,
            reach: None,
        }
    }
}

/// Elements of level coarse over those of level normal; segments shorter than the elements follow no load of
/// their own either.
const COARSE_OVER_NORMAL: f64 = 5.0 / 3.0;

impl ContactSettings {
    /// Settings for `pair`: 40 stations, or as many as leave each as long as the widest contact of the
    /// pair's loads and misalignments is wide, but at least 10; tip corners as the pair file says.
    pub fn for_pair(pair: &Pair) -> ContactSettings {
        let elements = match pair.refinement {
            Refinement::Coarse => COARSE_OVER_NORMAL,
            Refinement::Normal | Refinement::Fine => 1.0,
        };
        let least = elements * SEGMENT_OVER_WIDTH * 2.0 * widest_contact(pair);
        let (_, face) = pair.geometry.face_overlap();
        ContactSettings {
            stations: ((face / least) as usize).clamp(FEWEST_STATIONS, MOST_STATIONS),
            tip_corner_contact: pair.tip_corner_contact,
            ..ContactSettings::default()
        }
    }
}

/// Geometry, modifications and discretisation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ContactSetup {
    /// The two gears.
    pub geometry: PairGeometry,
    /// Modifications of both flanks.
    pub microgeometry: PairMicrogeometry,
    /// How teeth differ; tables hold teeth that are alike.
    #[serde(default)]
    pub teeth: PairTeeth,
    /// How the contact is discretised.
    pub settings: ContactSettings,
    /// Approach for which tip corners are followed, m.
    pub reach: f64,
    /// Reference length that the local contact asks for, m.
    pub reference_length: f64,
    /// Distances from the tip edges down to which the elastic models hold how teeth give way, m.
    #[serde(default)]
    pub corner_resolution: [f64; 2],
    /// Lengths of roll at which the involutes end at the root, m.
    pub form_rolls: [f64; 2],
}

/// Segments of one position, more than which are no contact of a pair: ten times those of the widest face.
const MOST_SEGMENTS: usize = 4000;

impl ContactSetup {
    /// Refuses what a file may hold and no solver writes.
    ///
    /// # Errors
    /// The first such field, as text.
    pub(super) fn check(&self) -> Result<(), String> {
        GeometryRecord::check(&self.geometry).map_err(|error| error.to_string())?;
        let numbers = PairNumbers::new(&self.geometry);
        let section = (self.section(&numbers, 0.0)).map_err(|error| error.to_string())?;
        let pairs = self.lines(Flank::Drive, &section).pairs(0.0, 0.0);
        let pairs = i64::from(*pairs.end()) - i64::from(*pairs.start());
        let stations = self.settings.stations;
        let segments = usize::try_from(pairs)
            .ok()
            .and_then(|n| n.checked_mul(stations));
        if !segments.is_some_and(|segments| (1..MOST_SEGMENTS).contains(&segments)) {
            return Err(format!(
                "{stations} stations of {pairs} tooth pairs: together 1 to {MOST_SEGMENTS} make sense"
            ));
        }
        for errors in [&self.teeth.drive, &self.teeth.coast] {
            for (gear, errors) in self.geometry.gears.iter().zip(errors) {
                let count = errors.index.len();
                if count != 0 && count != gear.teeth as usize {
                    return Err(format!("{count} index errors of {} teeth", gear.teeth));
                }
            }
        }
        Ok(())
    }

    /// The transverse section at the deviation `center_distance_offset` (m) from the nominal centre distance; `numbers` are the
    /// pair's.
    ///
    /// # Errors
    /// [`ContactError::OutOfMesh`] where teeth cannot meet.
    pub(super) fn section(
        &self,
        numbers: &PairNumbers,
        center_distance_offset: f64,
    ) -> Result<TransverseSection, ContactError> {
        TransverseSection::new(
            numbers,
            self.geometry.center_distance + center_distance_offset,
            self.form_rolls,
            self.settings
                .tip_corner_contact
                .then_some(self.reach + self.teeth.largest_closing()),
        )
        .ok_or_else(|| self.out_of_mesh(center_distance_offset))
    }

    pub(super) fn out_of_mesh(&self, center_distance_offset: f64) -> ContactError {
        ContactError::OutOfMesh {
            center_distance_mm: 1e3 * (self.geometry.center_distance + center_distance_offset),
        }
    }

    /// The contact lines of `flank` in `section`, all teeth alike.
    pub(super) fn lines<'a>(
        &'a self,
        flank: Flank,
        section: &'a TransverseSection,
    ) -> ContactLines<'a> {
        ContactLines {
            setup: self,
            section,
            flank,
            teeth: None,
        }
    }

    /// What holds for all loads at this centre distance.
    pub(super) fn limits(&self, center_distance_offset: f64) -> Limits {
        let modulus = self.geometry.gears.iter().map(|g| g.youngs_modulus);
        Limits {
            center_distance_offset,
            reach: self.settings.tip_corner_contact.then_some(self.reach),
            foundation: STIFFNESS_OVER_MODULUS * modulus.fold(f64::INFINITY, f64::min),
        }
    }
}

/// Estimate of the largest Hertz half-width of the pair, m: the maximum torque on one tooth pair, spread
/// over the face evenly or, with misalignment, as a triangle on an elastic foundation.
pub fn widest_contact(pair: &Pair) -> f64 {
    let g = &pair.geometry;
    let c = g.center_distance;
    let path = g.path_of_contact(c);
    let radius = (0..=20)
        .map(|i| {
            let xi = path.start + path.length() * f64::from(i) / 20.0;
            let rho = [0, 1].map(|k| g.gears[k].kappa() * g.roll_at(k, c, xi));
            1.0 / (1.0 / rho[0] + 1.0 / rho[1])
        })
        .fold(0.0, f64::max)
        / g.base_helix_angle().cos();
    let force = pair.operating.maximum_torque / g.gears[0].base_radius();
    let modulus = g
        .gears
        .iter()
        .map(|g| g.youngs_modulus)
        .fold(f64::INFINITY, f64::min);
    let misalignment = pair
        .operating
        .misalignment
        .iter()
        .fold(0.0f64, |m, v| m.max(v.abs()));
    let triangle = (2.0 * force * STIFFNESS_OVER_MODULUS * modulus * misalignment).sqrt();
    let line_load = (force / g.face_overlap().1).max(triangle);
    let softness: f64 = g
        .gears
        .iter()
        .map(|g| (1.0 - g.poisson_ratio * g.poisson_ratio) / g.youngs_modulus)
        .sum();
    (4.0 * line_load * radius * softness / std::f64::consts::PI).sqrt()
}

/// Approach that the pair's largest load and misalignment can cause, with a margin, m: twice that of a stiff
/// tooth pair, how both bodies give way, what misalignment adds at the ends of the face and of the path, and what
/// modifications take off at most.
pub(super) fn estimated_reach(pair: &Pair, form_rolls: [f64; 2]) -> f64 {
    let g = &pair.geometry;
    let force = pair.operating.maximum_torque / g.gears[0].base_radius();
    let modulus = g.gears[0].youngs_modulus.min(g.gears[1].youngs_modulus);
    let width = g.face_overlap().1;
    let [low, high] = pair.operating.misalignment.map(f64::abs);
    let (mut removal, mut bodies) = (0.0, 0.0);
    for (i, gear) in g.gears.iter().enumerate() {
        let rolls = [form_rolls[i], gear.tip_form_roll()];
        let flanks = [&pair.microgeometry.drive[i], &pair.microgeometry.coast[i]];
        let largest = flanks.map(|flank| flank.largest_removal(gear, rolls));
        removal += largest[0].max(largest[1]);
        bodies += force * gear.body_compliance();
    }
    let cos_beta_b = g.base_helix_angle().cos();
    // Force and displacement along the normal are those on the line of action over cos beta_b, the contact line
    // is the face over it.
    2.0 * force / (STIFFNESS_OVER_MODULUS * modulus * width * cos_beta_b)
        + bodies
        + 0.5 * low.max(high) * (width + g.base_helix_angle().tan() * g.base_pitch())
        + removal / cos_beta_b
}
