//! A pair as its contact sees it, without the elastic model of its teeth.

use serde::{Deserialize, Serialize};

use super::error::ContactError;
use super::local_law::LocalBody;
use super::transverse::TransverseSection;
use crate::friction::FrictionLaw;
use crate::gear::{BodyOrders, PairGeometry, PairMicrogeometry, PairNumbers, PairTeeth};

/// Stations along the face of a pair whose contacts are narrow.
const MOST_STATIONS: usize = 40;

/// Stiffness of a tooth pair per length of contact line over Young's modulus, for estimates. ISO 6336-1: 14 N/(mm um) for steel.
pub const STIFFNESS_OVER_MODULUS: f64 = 0.07;

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
    /// Approach on the line of action up to which tip edges are followed, m; `reach` in files. None: from
    /// the largest torque and misalignment of the pair.
    #[serde(rename = "reach")]
    pub followed_approach: Option<f64>,
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
            followed_approach: None,
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
    /// Approach up to which tip edges are followed, m; `reach` in files.
    #[serde(rename = "reach")]
    pub followed_approach: f64,
    /// Reference length that the local contact asks for, m.
    pub reference_length: f64,
    /// Distances from the tip edges down to which the elastic models hold how teeth deflect, m.
    #[serde(default)]
    pub corner_resolution: [f64; 2],
    /// Lengths of roll at which the involutes end at the root, m.
    pub form_rolls: [f64; 2],
    /// Law of friction, on which no solution depends; `None` in files of earlier versions.
    #[serde(default)]
    pub friction: Option<FrictionLaw>,
    /// How bodies that are no solids of revolution change the compliance with their angle; the matrices are those of their mean.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bodies: Option<BodyOrders>,
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
        let numbers = PairNumbers::new(&self.geometry);
        let section = (self.section(&numbers, 0.0)).map_err(|error| error.to_string())?;
        let [first, last] = section.passage();
        let (pairs, stations) = (last.ceil() - first.floor(), self.settings.stations);
        if !(1.0..MOST_SEGMENTS).contains(&(pairs * stations as f64)) {
            return Err(format!(
                "{stations} stations of {pairs} tooth pairs: together 1 to {MOST_SEGMENTS} make sense"
            ));
        }
        if let Some(bodies) = &self.bodies {
            (bodies.check()).map_err(|(value, reason)| format!("bodies = {value}: {reason}"))?;
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

    /// How gear 1 and gear 2 deflect close to the contact.
    pub fn local_bodies(&self) -> [LocalBody; 2] {
        [0, 1].map(|i| LocalBody::new(&self.geometry.gears[i], self.corner_resolution[i]))
    }

    /// The transverse section at the deviation `center_distance_offset` (m) from the nominal centre distance.
    ///
    /// # Errors
    /// [`ContactError::OutOfMesh`] where teeth cannot meet.
    pub fn section(
        &self,
        numbers: &PairNumbers,
        center_distance_offset: f64,
    ) -> Result<TransverseSection, ContactError> {
        let center_distance = self.geometry.center_distance + center_distance_offset;
        let limit = self.followed_approach + self.teeth.largest_closing();
        let limit = self.settings.tip_corner_contact.then_some(limit);
        TransverseSection::new(numbers, center_distance, self.form_rolls, limit)
            .ok_or_else(|| self.out_of_mesh(center_distance_offset))
    }

    /// [`ContactError::OutOfMesh`] at that deviation (m).
    pub fn out_of_mesh(&self, center_distance_offset: f64) -> ContactError {
        ContactError::OutOfMesh {
            center_distance: self.geometry.center_distance + center_distance_offset,
        }
    }
}
