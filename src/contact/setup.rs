//! A pair as its contact sees it, without the elastic model of its teeth.

use serde::{Deserialize, Serialize};

use super::candidates::ContactLines;
use super::error::ContactError;
use super::local::constants::{MOST_STATIONS, STIFFNESS_OVER_MODULUS};
use super::numbers::PairNumbers;
use super::position::Limits;
use super::transverse::TransverseSection;
use crate::gear::{Flank, PairGeometry, PairMicrogeometry, PairTeeth};
use crate::table::GeometryRecord;

/// How the contact is discretised.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ContactSettings {
    /// Number of equal stations over the overlap of both faces.
    pub stations: usize,
    /// Part of what a gap changes by along a strip that local contact takes up. The bulk displacement of a strip is one number, its
    /// mean; that of the teeth follows a load that changes along the line. With 1, all of the change, forces come out too high by the square of the
    /// strips' length.
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

/// Strips of one position, more than which are no contact of a pair: ten times those of the widest face.
const MOST_STRIPS: usize = 4000;

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
        let strips = usize::try_from(pairs)
            .ok()
            .and_then(|n| n.checked_mul(stations));
        if !strips.is_some_and(|strips| (1..MOST_STRIPS).contains(&strips)) {
            return Err(format!(
                "{stations} stations of {pairs} tooth pairs: together 1 to {MOST_STRIPS} make sense"
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
            geometry: &self.geometry,
            microgeometry: self.microgeometry.flank(flank),
            section,
            flank,
            stations: self.settings.stations,
            own_share: self.settings.own_share,
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
