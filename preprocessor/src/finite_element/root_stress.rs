//! Stress in the tooth root as a linear map from the loads on segments of the flanks.
//!
//! A model of its own beside [`super::FiniteElementCompliance`]: the same elements, condensation and ring, refined along
//! the fillet and coarser on the flank, whose loads the root feels by their resultants. The stress at the points of the
//! fillet ([`super::fillet`]) are functionals of the displacement; carried along as columns beside the loads they give
//! the map without a backward solution (reciprocity).

use super::cache::{Stored, get};
use super::fillet::{COMPONENTS, FilletGrid};
use super::flank::{FlankGrid, Weights};
use super::mesh::{LoadColumn, Mesh};
use super::model::Model;
use super::settings::Settings;
use super::{FiniteElementError, ModelCache, Origin, Progress};
use gearmesh::compliance::{BeyondModel, Segment};
use gearmesh::gear::{Gear, GearKind};

/// Stress in the tooth roots of one gear per load on its flanks.
#[derive(Debug, Clone)]
pub struct RootStress {
    loads: FlankGrid,
    fillet: FilletGrid,
    map: Map,
    reach: usize,
    /// Distance from a load within which stress is left out of the largest one, m.
    local: f64,
    /// Tangent to the centre line at which the standards look, rad.
    tangent: f64,
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

/// Stress in the root of one tooth beside its loaded flank.
#[derive(Debug, Clone, PartialEq)]
pub struct RootField<'a> {
    fillet: &'a FilletGrid,
    tangent: f64,
    /// At each place along the face how many places along the profile, from the middle of the space, no load is beside.
    clear: Vec<usize>,
    /// Largest principal stress at each place along the face (outer) and along the profile, Pa, tension positive.
    principal: Vec<f64>,
}

/// A point of the fillet and the largest principal stress there.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RootPoint {
    /// Largest principal stress, Pa, tension positive.
    pub stress: f64,
    /// Along the face, m from the z = 0 face of the gear as [`Segment`] counts it.
    pub z: f64,
    /// Distance from the axis, m.
    pub radius: f64,
    /// Angle between the fillet's tangent plane and the tooth's centre line, rad.
    pub tangent: f64,
}

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
/// Over the normal module: distance from a load within which the stress is that of its spreading, without limit at a tip corner.
const LOCAL_OVER_MODULE: f64 = 0.45;
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
        let (fillet, stress) = FilletGrid::new(&model, &mesh);
        let (map, origin) = get(cache, &model, "root stress, ", || {
            Map::new(&model, &mesh, &stress, progress)
        })?;
        let found = RootStress {
            loads: model.grid,
            fillet,
            map,
            reach: settings.reach,
            local: LOCAL_OVER_MODULE * gear.normal_module,
            tangent: match gear.kind {
                GearKind::External => 30f64.to_radians(),
                GearKind::Ring => 60f64.to_radians(),
            },
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
        let (nodes, points) = (self.loads.len(), COMPONENTS * self.fillet.len());
        let mut stress = vec![0.0; points];
        let mut forces = vec![vec![0.0; nodes]; 2 * self.reach + 1];
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
        let columns = self.map.units.iter().zip(self.map.entries.chunks(points));
        let forces = forces.iter().flatten().zip(columns);
        for (force, (unit, column)) in forces.filter(|(force, _)| **force != 0.0) {
            let force = force * f64::from(*unit);
            for (s, c) in stress.iter_mut().zip(column) {
                *s += force * f64::from(*c);
            }
        }
        let principal = stress.chunks(COMPONENTS).map(|s| {
            let (mean, half) = (0.5 * (s[0] + s[1]), 0.5 * (s[0] - s[1]));
            mean + half.hypot(s[2])
        });
        let places = self.fillet.z.iter();
        Ok(RootField {
            fillet: &self.fillet,
            tangent: self.tangent,
            clear: places.map(|z| self.clear(*z, &beside)).collect(),
            principal: principal.collect(),
        })
    }

    /// How many places along the profile at `z` lie farther than `local` from the `loaded` segments of this tooth; at least one.
    fn clear(&self, z: f64, loaded: &[&Segment]) -> usize {
        let lowest = loaded.iter().filter_map(|segment| {
            let nearest = z.clamp(segment.z[0], segment.z[1]);
            let along = (nearest - segment.z[0]) / (segment.z[1] - segment.z[0]);
            let roll = segment.roll[0] + along * (segment.roll[1] - segment.roll[0]);
            let square = self.local.powi(2) - (z - nearest).powi(2);
            (square > 0.0).then(|| self.loads.arc(roll) - square.sqrt())
        });
        let lowest = lowest.fold(f64::INFINITY, f64::min);
        self.fillet.arcs.partition_point(|arc| *arc < lowest).max(1)
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

impl RootField<'_> {
    /// Places along the face, m.
    pub fn z(&self) -> &[f64] {
        &self.fillet.z
    }

    /// The largest principal stress at each place along the profile, from the middle of the space to the start of the
    /// involute, at the place `number` along the face.
    pub fn profile(&self, number: usize) -> impl Iterator<Item = RootPoint> {
        let fillet = self.fillet;
        let points = self.stress(number).iter().enumerate();
        points.map(move |(i, stress)| RootPoint {
            stress: *stress,
            z: fillet.z[number],
            radius: fillet.radii[i],
            tangent: fillet.tangents[i],
        })
    }

    /// Largest principal stress at the places along the profile, Pa.
    fn stress(&self, number: usize) -> &[f64] {
        let n = self.fillet.arcs.len();
        &self.principal[number * n..][..n]
    }

    /// Where the largest principal stress is largest, but for places within 0.45 normal modules of a load on the flank of this tooth: there
    /// it is local, and without limit under a corner. Between the places along the profile by a parabola.
    pub fn largest(&self) -> RootPoint {
        let places = (0..self.fillet.z.len()).map(|number| self.largest_at(number));
        places.reduce(larger).unwrap_or_default()
    }

    /// The same at the place `number` along the face.
    pub fn largest_at(&self, number: usize) -> RootPoint {
        let (stress, arcs, clear) = (self.stress(number), &self.fillet.arcs, self.clear[number]);
        let top = (0..clear).max_by(|a, b| stress[*a].total_cmp(&stress[*b]));
        let i = top.unwrap_or(0);
        if i == 0 || i + 1 == clear {
            return self.at_arc(number, arcs[i]);
        }
        let [x0, x2] = [i - 1, i + 1].map(|k| arcs[k] - arcs[i]);
        let [y0, y2] = [i - 1, i + 1].map(|k| stress[k] - stress[i]);
        // Through (0, 0): y = a x + b x²; both neighbours lie lower, so that b < 0 and the top between them.
        let b = (y0 / x0 - y2 / x2) / (x0 - x2);
        let a = y0 / x0 - b * x0;
        let away = if b < 0.0 { -0.5 * a / b } else { 0.0 };
        self.at_arc(number, arcs[i] + away)
    }

    /// Largest over the face at the place of the fillet whose tangent makes 30 degrees (ring: 60) with the centre
    /// line of the tooth, but for what [`RootField::largest`] leaves out, unless that is all of it. None if the fillet has no such place.
    pub fn at_tangent(&self) -> Option<RootPoint> {
        let (arcs, tangents) = (&self.fillet.arcs, &self.fillet.tangents);
        let holds = |i: &usize| tangents[*i] <= self.tangent && self.tangent < tangents[i - 1];
        let after = (1..arcs.len()).rev().find(holds)?;
        let t = (self.tangent - tangents[after]) / (tangents[after - 1] - tangents[after]);
        let arc = arcs[after] + t * (arcs[after - 1] - arcs[after]);
        let is_clear = |number: &usize| after < self.clear[*number];
        let anywhere = !(0..self.clear.len()).any(|number| is_clear(&number));
        let places = (0..self.clear.len()).filter(|number| anywhere || is_clear(number));
        places.map(|number| self.at_arc(number, arc)).reduce(larger)
    }

    /// Parabola through the three places nearest to `arc`.
    fn at_arc(&self, number: usize, arc: f64) -> RootPoint {
        let (fillet, arcs) = (self.fillet, &self.fillet.arcs);
        let distance = |i: &usize| (arcs[*i] - arc).abs();
        let nearest = (0..arcs.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)));
        let i = nearest.unwrap_or(0).clamp(1, arcs.len() - 2);
        let three = [i - 1, i, i + 1];
        let weights = three.map(|k| {
            let others = three.iter().filter(|o| **o != k);
            let part = others.map(|o| (arc - arcs[*o]) / (arcs[k] - arcs[*o]));
            part.product::<f64>()
        });
        let mean = |of: &[f64]| three.iter().zip(weights).map(|(k, w)| w * of[*k]).sum();
        RootPoint {
            stress: mean(self.stress(number)),
            z: fillet.z[number],
            radius: mean(&fillet.radii),
            tangent: mean(&fillet.tangents),
        }
    }
}

fn larger(a: RootPoint, b: RootPoint) -> RootPoint {
    if b.stress > a.stress { b } else { a }
}

#[cfg(test)]
#[path = "root_stress_tests.rs"]
mod tests;
