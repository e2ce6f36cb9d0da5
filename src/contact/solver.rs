//! The contact of one pair: settings, and the problem of every position of the mesh.

use std::sync::Arc;

use super::candidates::ContactLines;
use super::error::ContactError;
use super::position::PositionProblem;
use super::transverse::TransverseSection;
use crate::compliance::ToothCompliance;
use crate::gear::{Flank, Gear, Microgeometry, PairGeometry};
use crate::pair::Pair;

/// Stiffness of a tooth pair per length of contact line over Young's modulus, a rule of thumb (14
/// N/(mm um) for steel, ISO 6336-1): for starting values and for how far tip corners are followed.
const STIFFNESS_OVER_MODULUS: f64 = 0.07;

/// How the contact is discretised.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactSettings {
    /// Number of equal stations over the overlap of both faces.
    pub stations: usize,
    /// Whether tip corners outside the path of contact may touch.
    pub tip_corner_contact: bool,
    /// Largest approach on the line of action for which tip corners are followed, m. None: from
    /// the largest torque and misalignment of the pair.
    pub reach: Option<f64>,
}

impl Default for ContactSettings {
    fn default() -> Self {
        ContactSettings {
            stations: 40,
            tip_corner_contact: true,
            reach: None,
        }
    }
}

/// Static contact of one pair of gears.
///
/// Clones share nothing mutable; one solver serves all threads.
#[derive(Clone)]
pub struct ContactSolver {
    geometry: PairGeometry,
    microgeometry: [Microgeometry; 2],
    compliance: [Arc<dyn ToothCompliance>; 2],
    settings: ContactSettings,
    reach: f64,
}

impl ContactSolver {
    /// A solver for `pair` on the elastic models of gear 1 and gear 2.
    ///
    /// # Errors
    /// [`ContactError::Setting`] for no stations or a reach that is not positive.
    pub fn new(
        pair: &Pair,
        compliance: [Arc<dyn ToothCompliance>; 2],
        settings: ContactSettings,
    ) -> Result<ContactSolver, ContactError> {
        if settings.stations == 0 {
            return Err(ContactError::Setting {
                field: "stations",
                value: 0.0,
                remedy: "give at least 1",
            });
        }
        let reach = settings.reach.unwrap_or_else(|| default_reach(pair));
        if !(reach.is_finite() && reach > 0.0) {
            return Err(ContactError::Setting {
                field: "reach",
                value: reach,
                remedy: "give a positive length in m",
            });
        }
        Ok(ContactSolver {
            geometry: pair.geometry.clone(),
            microgeometry: pair.microgeometry,
            compliance,
            settings,
            reach,
        })
    }

    /// The pair's geometry.
    pub fn geometry(&self) -> &PairGeometry {
        &self.geometry
    }

    /// The settings it was made with.
    pub fn settings(&self) -> &ContactSettings {
        &self.settings
    }

    /// The problem at `mesh_position` (base pitches; 0: a tooth pair touches at the pitch point at
    /// mid-face) and at the deviation `center_distance_offset` (m) from the nominal centre distance. It
    /// holds the influence matrix and serves all loads and misalignments.
    ///
    /// # Errors
    /// [`ContactError::Input`] for numbers that are not finite, [`ContactError::OutOfMesh`] where teeth
    /// cannot meet.
    pub fn position(
        &self,
        flank: Flank,
        mesh_position: f64,
        center_distance_offset: f64,
    ) -> Result<PositionProblem, ContactError> {
        for (field, value) in [
            ("mesh_position", mesh_position),
            ("center_distance_offset", center_distance_offset),
        ] {
            if !value.is_finite() {
                return Err(ContactError::Input {
                    field,
                    value,
                    remedy: "give a finite number",
                });
            }
        }
        let center_distance = self.geometry.center_distance + center_distance_offset;
        let out_of_mesh = || ContactError::OutOfMesh {
            center_distance_mm: 1e3 * center_distance,
        };
        let section = TransverseSection::new(
            &self.geometry,
            center_distance,
            [0, 1].map(|i| form_roll(&self.geometry.gears[i])),
            self.settings.tip_corner_contact.then_some(self.reach),
        )
        .ok_or_else(out_of_mesh)?;
        let candidates = ContactLines {
            geometry: &self.geometry,
            microgeometry: &self.microgeometry,
            section: &section,
            flank,
            stations: self.settings.stations,
        }
        // One base pitch later everything is the same again.
        .candidates(mesh_position - mesh_position.floor());
        if candidates.is_empty() {
            return Err(out_of_mesh());
        }
        let modulus = self.geometry.gears.iter().map(|g| g.youngs_modulus);
        Ok(PositionProblem::new(
            &self.geometry,
            &self.compliance,
            candidates,
            self.settings.tip_corner_contact.then_some(self.reach),
            STIFFNESS_OVER_MODULUS * modulus.fold(f64::INFINITY, f64::min),
        ))
    }
}

/// Approach that the pair's largest load and misalignment can cause, with a margin, m.
fn default_reach(pair: &Pair) -> f64 {
    let g = &pair.geometry;
    let force = pair.operating.maximum_torque / g.gears[0].base_radius();
    let modulus = g.gears[0].youngs_modulus.min(g.gears[1].youngs_modulus);
    let width = g.face_overlap().1;
    let misalignment = pair
        .operating
        .misalignment
        .iter()
        .fold(0.0f64, |m, v| m.max(v.abs()));
    2.0 * force / (STIFFNESS_OVER_MODULUS * modulus * width) + 0.5 * misalignment * width
}

/// Length of roll at which the generated involute ends at the root, m: where the rack's straight
/// flank (ring: the fillet arc) ends.
fn form_roll(gear: &Gear) -> f64 {
    let alpha = gear.transverse_pressure_angle();
    let round = gear.tool_tip_radius_coefficient * (1.0 - gear.normal_pressure_angle.sin());
    let depth = gear.normal_module
        * (gear.dedendum_coefficient - round - gear.kappa() * gear.profile_shift);
    if gear.kappa() > 0.0 {
        // A positive floor keeps the tip edge of the mate off the base circle.
        (gear.base_radius() * alpha.tan() - depth / alpha.sin()).max(1e-3 * gear.base_radius())
    } else {
        gear.roll_length(gear.reference_radius() + depth)
    }
}
