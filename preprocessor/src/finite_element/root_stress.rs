//! Stress in the tooth root as a linear map from the loads on segments of the flanks.
//!
//! A model of its own beside [`super::FiniteElementCompliance`]: the same elements, condensation and ring, refined along
//! the fillet and coarser on the flank, whose loads the root feels by their resultants. The stress at the points of the
//! fillet ([`super::fillet`]) are functionals of the displacement; carried along as columns beside the loads they give
//! the map without a backward solution (reciprocity).

use super::cache::{Stored, get};
use super::fillet;
use super::flank::{FlankGrid, Weights};
use super::mesh::{LoadColumn, Mesh};
use super::model::Model;
use super::settings::Settings;
use super::{FiniteElementError, ModelCache, Origin, Progress};
use gearmesh::compliance::{BeyondModel, Segment};
use gearmesh::contact::{CondensedRoots, Fillet, ROLLS, RootField};
use gearmesh::gear::Gear;

/// Stress in the tooth roots of one gear per load on its flanks.
#[derive(Debug, Clone)]
pub struct RootStress {
    loads: FlankGrid,
    fillet: Fillet,
    map: Map,
    reach: usize,
}

/// Stress by loads, rounded.
#[derive(Debug, Clone, PartialEq)]
struct Map {
    /// For each difference of tooth numbers (loaded tooth to root) from -reach to reach and each flank node a column: for each
    /// point of the fillet its [`COMPONENTS`], in units of the column.
    entries: Vec<i16>,
    /// Unit of each column, Pa/N (plane strain: Pa m/N).
    units: Vec<f32>,
}

impl Stored for Map {
    fn encode(&self) -> Vec<u8> {
        let mut bytes = (self.units.len() as u64).to_le_bytes().to_vec();
        bytes.extend(self.units.iter().flat_map(|unit| unit.to_le_bytes()));
        bytes.extend(self.entries.iter().flat_map(|entry| entry.to_le_bytes()));
        bytes
    }

    fn decode(bytes: &[u8]) -> Option<Map> {
        let (columns, bytes) = bytes.split_first_chunk()?;
        let columns = usize::try_from(u64::from_le_bytes(*columns)).ok()?;
        let (units, entries) = bytes.split_at_checked(columns.checked_mul(size_of::<f32>())?)?;
        let units = units.chunks_exact(4);
        let entries = entries.chunks_exact(2);
        Some(Map {
            units: units
                .map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]))
                .collect(),
            entries: entries.map(|b| i16::from_le_bytes([b[0], b[1]])).collect(),
        })
    }
}

/// Segments of one gear as loads on the nodes of its flanks.
#[derive(Debug, Clone)]
pub struct SpreadSegments(Vec<(Segment, Weights)>);

impl Settings {
    /// The same level for the stress in the root: fine along the fillet, coarse on the flank.
    #[must_use]
    pub fn for_root_stress(&self) -> Settings {
        let mut settings = *self;
        let sizes = &mut settings.discretization;
        sizes.involute_element = None;
        sizes.fillet_element = Some(sizes.flank_element * FILLET_OVER_FLANK);
        sizes.flank_element *= FLANK_OVER_FLANK;
        sizes.kernel_half_width = KERNEL_OVER_ELEMENT * sizes.flank_element;
        settings
    }
}

const FILLET_OVER_FLANK: f64 = 0.8;
const FLANK_OVER_FLANK: f64 = 1.5;
/// Units in the largest entry of a column: 2e-5 of it are the rounding.
pub(super) const LARGEST: f64 = 32_000.0;
/// Half-width of the load kernel over the element: what the kernel needs to be resolved.
const KERNEL_OVER_ELEMENT: f64 = 1.25;

impl RootStress {
    /// Computes the map of `gear`; `settings` from [`Settings::for_root_stress`].
    ///
    /// # Errors
    /// As [`super::FiniteElementCompliance::new`].
    pub fn new(
        gear: &Gear,
        settings: &Settings,
        progress: &Progress<'_>,
    ) -> Result<Self, FiniteElementError> {
        Ok(Self::cached(gear, settings, None, progress)?.0)
    }

    /// As [`RootStress::new`], by way of `cache` if there is one.
    pub(super) fn cached(
        gear: &Gear,
        settings: &Settings,
        cache: Option<&ModelCache>,
        progress: &Progress<'_>,
    ) -> Result<(Self, Origin), FiniteElementError> {
        let model = Model::new(gear, settings)?;
        let mesh = Mesh::new(&model);
        let (fillet, stress) = fillet::points(&model, &mesh);
        let (map, origin) = get(cache, &model, "root stress, ", || {
            Map::new(&model, &mesh, &stress, progress)
        })?;
        let found = RootStress {
            loads: model.grid,
            fillet,
            map,
            reach: settings.reach,
        };
        Ok((found, origin))
    }

    /// Largest difference of tooth numbers between a load and a root.
    pub fn reach(&self) -> usize {
        self.reach
    }

    /// Stress in the root of `tooth` under normal forces, N, on segments of this gear (plane strain: N per m of face).
    ///
    /// # Errors
    /// [`BeyondModel`] for a loaded segment farther away than [`RootStress::reach`].
    pub fn of_tooth(
        &self,
        tooth: i32,
        loads: &[(Segment, f64)],
    ) -> Result<RootField<'_>, BeyondModel> {
        let (segments, forces): (Vec<Segment>, Vec<f64>) = loads.iter().copied().unzip();
        self.of_tooth_under(tooth, &self.spread(&segments), &forces)
    }

    /// Segments of this gear, ready for [`RootStress::of_tooth_under`] any forces.
    pub fn spread(&self, segments: &[Segment]) -> SpreadSegments {
        let spread = |segment: &Segment| (*segment, self.loads.weights(segment));
        SpreadSegments(segments.iter().map(spread).collect())
    }

    /// As [`RootStress::of_tooth`], under the normal forces `loads`, N, on `segments`.
    ///
    /// # Errors
    /// As there.
    ///
    /// # Panics
    /// With another number of loads than of segments.
    pub fn of_tooth_under(
        &self,
        tooth: i32,
        segments: &SpreadSegments,
        loads: &[f64],
    ) -> Result<RootField<'_>, BeyondModel> {
        assert_eq!(segments.0.len(), loads.len(), "a load for each segment");
        let mut forces = vec![vec![0.0; self.loads.len()]; 2 * self.reach + 1];
        let mut beside = Vec::new();
        let loaded = segments
            .0
            .iter()
            .zip(loads)
            .filter(|(_, force)| **force != 0.0);
        for ((segment, weights), force) in loaded {
            let away = tooth - segment.tooth;
            let (distance, reach) = (away.unsigned_abs() as usize, self.reach);
            if distance > reach {
                return Err(BeyondModel { distance, reach });
            }
            if away == 0 && *force > 0.0 {
                beside.push(segment);
            }
            let forces = &mut forces[(away + reach as i32) as usize];
            for (node, weight) in weights {
                forces[*node] += weight * force;
            }
        }
        let forces = forces.iter().flatten().copied().enumerate();
        let stress = self.stress(forces.filter(|(_, force)| *force != 0.0));
        Ok(self.fillet.field(&stress, beside.into_iter()))
    }

    /// Components of the stress at all points of the fillet under the forces, N, of these columns of the map.
    fn stress(&self, forces: impl Iterator<Item = (usize, f64)>) -> Vec<f64> {
        let count = self.fillet.components();
        let mut stress = vec![0.0; count];
        for (column, force) in forces {
            let force = force * f64::from(self.map.units[column]);
            let entries = &self.map.entries[column * count..][..count];
            for (s, entry) in stress.iter_mut().zip(entries) {
                *s += force * f64::from(*entry);
            }
        }
        stress
    }

    /// The map from loads on the whole `stations` of the face, as this gear sees them, for contact at run time.
    pub fn condensed(&self, stations: &[Segment]) -> CondensedRoots {
        let middle = stations[stations.len() / 2];
        let roll_by_z = (middle.roll[1] - middle.roll[0]) / (middle.z[1] - middle.z[0]);
        let rolls = self.loads.rolls();
        let mut values = Vec::new();
        for away in 0..=2 * self.reach {
            for station in stations {
                let half = 0.5 * roll_by_z * (station.z[1] - station.z[0]);
                for i in 0..ROLLS {
                    let roll = rolls[0] + (rolls[1] - rolls[0]) * i as f64 / (ROLLS - 1) as f64;
                    let segment = Segment {
                        roll: [roll - half, roll + half],
                        ..*station
                    };
                    let forces = self.loads.weights(&segment).into_iter();
                    let first = away * self.loads.len();
                    let stress = self.stress(forces.map(|(node, weight)| (first + node, weight)));
                    values.extend(stress.into_iter().map(|s| s as f32));
                }
            }
        }
        CondensedRoots {
            fillet: self.fillet.clone(),
            reach: self.reach,
            stations: stations.len(),
            rolls,
            roll_by_z,
            values,
        }
    }
}

impl Map {
    fn new(
        model: &Model,
        mesh: &Mesh,
        stress: &[LoadColumn],
        progress: &Progress<'_>,
    ) -> Result<Map, FiniteElementError> {
        let mut columns = mesh.loads();
        let loads = columns.len();
        columns.extend_from_slice(stress);
        let reach = model.reach as i32;
        let response = model.response(mesh, &columns, loads, -reach..=reach, progress)?;
        let mut map = Map {
            entries: Vec::new(),
            units: Vec::new(),
        };
        for column in response.iter().flat_map(|tooth| tooth.column_iter()) {
            let largest = column.amax();
            let unit = if largest > 0.0 {
                largest / LARGEST
            } else {
                1.0
            };
            // The columns push outwards, flanks are pressed inwards.
            (map.entries).extend(column.iter().map(|s| (-s / unit).round() as i16));
            map.units.push(unit as f32);
        }
        Ok(map)
    }
}

#[cfg(test)]
#[path = "root_stress_tests.rs"]
mod tests;
