//! A pair as its contact sees it, without the elastic model of its teeth.

use serde::{Deserialize, Serialize};

use super::error::ContactError;
use super::transverse::{PairNumbers, TransverseSection};
use crate::friction::FrictionLaw;
use crate::gear::{Gear, PairGeometry, PairMicrogeometry, PairTeeth};
use crate::pair::{Pair, Refinement};

/// Stations along the face: the most, of a pair whose contacts are narrow, and the fewest.
const MOST_STATIONS: usize = 40;
const FEWEST_STATIONS: usize = 10;

/// Stiffness of a tooth pair per length of contact line over Young's modulus, for estimates. ISO 6336-1: 14 N/(mm um) for steel.
pub(super) const STIFFNESS_OVER_MODULUS: f64 = 0.07;

/// How the contact is discretised.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ContactSettings {
    /// Number of equal stations over the overlap of both faces.
    pub stations: usize,
    /// Part of what a gap changes by along a segment that local contact takes up; the displacement of the teeth follows the rest,
    /// of which the bulk of a segment knows the mean alone. With 1 forces come out too high by the square of its length.
    #[serde(default = "all")]
    pub own_share: f64,
    /// Whether tip corners outside the path of contact may touch.
    pub tip_corner_contact: bool,
    /// Whether contact moves along the profile as teeth bend. A solver of a pair whose loads change the approach by less than a thousandth
    /// by that sets it to false.
    #[serde(default)]
    pub bent_teeth: bool,
    /// Largest approach on the line of action for which tip corners are followed, m. None: from
    /// the largest torque and misalignment of the pair.
    pub reach: Option<f64>,
}

fn all() -> f64 {
    1.0
}

impl Default for ContactSettings {
    fn default() -> Self {
        ContactSettings {
            stations: MOST_STATIONS,
            own_share: all(),
            tip_corner_contact: true,
            bent_teeth: true,
            reach: None,
        }
    }
}

/// Elements of level coarse over those of level normal: segments shorter than the elements follow no load of their own either.
const COARSE_OVER_NORMAL: f64 = 5.0 / 3.0;

impl ContactSettings {
    /// Settings for `pair`: 40 stations, or as many as leave each as long as the widest contact of the pair's loads and
    /// misalignments is wide, but at least 10; tip corners as the pair file says.
    pub fn for_pair(pair: &Pair) -> ContactSettings {
        let elements = match pair.refinement {
            Refinement::Coarse => COARSE_OVER_NORMAL,
            Refinement::Normal | Refinement::Fine => 1.0,
        };
        let least = elements * 2.0 * widest_contact(pair);
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
    /// Law of friction, on which no solution depends; `None` in files of earlier versions.
    #[serde(default)]
    pub friction: Option<FrictionLaw>,
}

/// Segments of one position, more than which are no contact of a pair: ten times those of the widest face.
const MOST_SEGMENTS: f64 = 4000.0;

impl ContactSetup {
    /// Refuses what a file may hold and no solver writes.
    ///
    /// # Errors
    /// The first such field, as text.
    pub(super) fn check(&self) -> Result<(), String> {
        (self.geometry.check()).map_err(|error| error.to_string())?;
        let numbers = PairNumbers::new(&self.geometry, self.corner_resolution);
        let section = (self.section(&numbers, 0.0)).map_err(|error| error.to_string())?;
        let [first, last] = section.passage();
        let (pairs, stations) = (last.ceil() - first.floor(), self.settings.stations);
        if !(1.0..MOST_SEGMENTS).contains(&(pairs * stations as f64)) {
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

    /// The transverse section at the deviation `center_distance_offset` (m) from the nominal centre distance.
    pub(super) fn section(
        &self,
        numbers: &PairNumbers,
        center_distance_offset: f64,
    ) -> Result<TransverseSection, ContactError> {
        let center_distance = self.geometry.center_distance + center_distance_offset;
        let limit = self.reach + self.teeth.largest_closing();
        let limit = self.settings.tip_corner_contact.then_some(limit);
        TransverseSection::new(numbers, center_distance, self.form_rolls, limit)
            .ok_or_else(|| self.out_of_mesh(center_distance_offset))
    }

    pub(super) fn out_of_mesh(&self, center_distance_offset: f64) -> ContactError {
        ContactError::OutOfMesh {
            center_distance: self.geometry.center_distance + center_distance_offset,
        }
    }
}

/// Estimate of the largest Hertz half-width of the pair, m: the maximum torque on one tooth pair, spread
/// over the face evenly or, with misalignment, as a triangle on an elastic foundation.
pub fn widest_contact(pair: &Pair) -> f64 {
    let g = &pair.geometry;
    let c = g.center_distance;
    let path = g.path_of_contact(c);
    let radii = (0..=20).map(|i| {
        let xi = path.start + path.length() * f64::from(i) / 20.0;
        let rho = [0, 1].map(|k| g.gears[k].kappa() * g.roll_at(k, c, xi));
        1.0 / (1.0 / rho[0] + 1.0 / rho[1])
    });
    let radius = radii.fold(0.0, f64::max) / g.base_helix_angle().cos();
    let force = pair.operating.maximum_torque / g.gears[0].base_radius();
    let modulus = g.gears[0].youngs_modulus.min(g.gears[1].youngs_modulus);
    let [low, high] = pair.operating.misalignment.map(f64::abs);
    let misalignment = low.max(high);
    let triangle = (2.0 * force * STIFFNESS_OVER_MODULUS * modulus * misalignment).sqrt();
    let line_load = (force / g.face_overlap().1).max(triangle);
    let softness = |g: &Gear| (1.0 - g.poisson_ratio * g.poisson_ratio) / g.youngs_modulus;
    let softness: f64 = g.gears.iter().map(softness).sum();
    (4.0 * line_load * radius * softness / std::f64::consts::PI).sqrt()
}

/// Approach that the pair's largest load and misalignment can cause, m: twice that of a stiff tooth pair, of the bodies, of the
/// misalignment at the ends, and what modifications take off at most.
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
    // Force and displacement along the normal are those on the line of action over cos beta_b, as the contact line is the face.
    2.0 * force / (STIFFNESS_OVER_MODULUS * modulus * width * cos_beta_b)
        + bodies
        + 0.5 * low.max(high) * (width + g.base_helix_angle().tan() * g.base_pitch())
        + removal / cos_beta_b
}

/// How far the flanks of both gears have come closer along the pitch line, on the line of action, before the load of
/// the mesh: > 0 closes, as an approach does. Straight between its points and, beyond them, on as between the
/// two outermost. Transverse sections turn with its slope, so that at the distance y from the pitch line along the path flanks
/// close by sigma y times the slope more, sigma that of the contact line. A misalignment M is the deflection M (z - z_ref); both add.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Deflection {
    /// (z in gear 1's frame, closing), m, ascending in z; none where there is no deflection.
    points: Vec<[f64; 2]>,
}

impl Deflection {
    /// Through `points`: (z in gear 1's frame, closing on the line of action), m.
    ///
    /// # Errors
    /// [`ContactError::Input`] for fewer than two points, numbers that are not finite, and z that do not ascend.
    pub fn new(points: Vec<[f64; 2]>) -> Result<Deflection, ContactError> {
        let refused = |field, value, remedy| Err(ContactError::input(field, value, remedy));
        if points.len() < 2 {
            let count = points.len() as f64;
            return refused("points of the deflection", count, "give at least 2");
        }
        if let Some(value) = points.iter().flatten().find(|v| !v.is_finite()) {
            return refused("deflection", *value, "give finite numbers");
        }
        if let Some(pair) = points.windows(2).find(|p| p[1][0] <= p[0][0]) {
            return refused("z of the deflection", pair[1][0], "let z ascend");
        }
        Ok(Deflection { points })
    }

    /// The ends of the face, `ends` (m in gear 1's frame), closed by `bow` (m) less than its middle, where the
    /// deflection is zero; parabolic.
    ///
    /// # Errors
    /// As [`Deflection::new`].
    pub fn bow(bow: f64, ends: [f64; 2]) -> Result<Deflection, ContactError> {
        const PIECES: usize = 64;
        let points = (0..=PIECES).map(|i| {
            let t = 2.0 * i as f64 / PIECES as f64 - 1.0;
            let z = 0.5 * ((1.0 - t) * ends[0] + (1.0 + t) * ends[1]);
            [z, -bow * t * t]
        });
        Deflection::new(points.collect())
    }

    /// Closing (m) on the pitch line at `z` (m in gear 1's frame), and its slope there: between the middles of two pieces the mean of
    /// theirs, so that no transverse section turns against its neighbour.
    pub fn closing(&self, z: f64) -> [f64; 2] {
        if self.points.is_empty() {
            return [0.0; 2];
        }
        let above = self.points.partition_point(|p| p[0] <= z);
        let last = above.clamp(1, self.points.len() - 1);
        let piece = |last: usize| {
            let ([z0, d0], [z1, d1]) = (self.points[last - 1], self.points[last]);
            (0.5 * (z0 + z1), (d1 - d0) / (z1 - z0))
        };
        let (middle, slope) = piece(last);
        let beside = if z < middle { last - 1 } else { last + 1 };
        let mut smooth = slope;
        if (1..self.points.len()).contains(&beside) {
            let (other, turned) = piece(beside);
            smooth += (turned - slope) * (z - middle) / (other - middle);
        }
        let [z0, d0] = self.points[last - 1];
        [d0 + slope * (z - z0), smooth]
    }

    /// Least and largest closing over the face with the ends `ends`, m, up to `beyond` (sigma y, m) beside the pitch line.
    pub fn range(&self, ends: [f64; 2], beyond: f64) -> [f64; 2] {
        let inside = (self.points.iter().map(|p| p[0])).filter(|z| ends[0] < *z && *z < ends[1]);
        let none = [f64::INFINITY, f64::NEG_INFINITY];
        (ends.into_iter().chain(inside)).fold(none, |[low, high], z| {
            let [closing, slope] = self.closing(z);
            let turned = (beyond * slope).abs();
            [low.min(closing - turned), high.max(closing + turned)]
        })
    }
}
