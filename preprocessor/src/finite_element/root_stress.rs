//! Stress in the tooth root as a linear map from the loads on segments of the flanks.
//!
//! The same elements, condensation and ring as for compliance, refined along the fillet and coarser on the flank, whose
//! loads the root feels by their resultants. The stresses at the points of the fillet are functionals of the displacement;
//! carried along as columns beside the loads they give the map without a backward solution (reciprocity).
//!
//! Nothing acts on the fillet, so that the stress there is plane and follows from the strain in the tangent plane. Strains
//! are taken at the two Gauss points of every element along the profile, where the derivatives of quadratic displacements
//! converge fastest (Zienkiewicz, Taylor, The Finite Element Method, vol. 1, section 14.2), in the middle of every layer,
//! and at both faces by the straight line through the Gauss points of the outermost layers.

use super::cache::{Stored, get};
use super::element::{place_and_tangents, shape};
use super::flank::{FlankGrid, Weights, face_nodes};
use super::mesh::{LoadColumn, Mesh, twist};
use super::model::Model;
use super::{FiniteElementError, ModelCache, Origin, Progress, Settings};
use crate::compliance::BeyondModel;
use gearmesh::contact::Segment;
use gearmesh::contact::{COMPONENTS, CondensedRoots, Fillet, ROLLS, RootField};
use gearmesh::gear::{Gear, GearKind};
use nalgebra::Vector3;

/// Stress in the tooth roots of one gear per load on its flanks.
#[derive(Debug, Clone)]
pub struct RootStress {
    loads: FlankGrid,
    fillet: Fillet,
    map: Map,
    /// Largest difference of tooth numbers between a load and a root.
    reach: usize,
    /// In plane strain the cosine of the base helix angle.
    plane: Option<f64>,
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
    /// Computes the map of `gear`, or reads it from `cache` if there is one; `settings` from [`Settings::for_root_stress`].
    ///
    /// # Errors
    /// As [`super::FiniteElementCompliance::new`].
    pub fn new(
        gear: &Gear,
        settings: &Settings,
        cache: Option<&ModelCache>,
        progress: &Progress<'_>,
    ) -> Result<(Self, Origin), FiniteElementError> {
        let model = Model::new(gear, settings)?;
        let mesh = model.mesh();
        let (fillet, stress) = points(&model, &mesh);
        let (map, origin) = get(cache, &model, "root stress, ", || {
            Map::new(&model, &mesh, &stress, progress)
        })?;
        let found = RootStress {
            loads: model.grid,
            fillet,
            map,
            reach: settings.reach,
            plane: (settings.plane_strain).then(|| gear.base_helix_angle().cos()),
        };
        Ok((found, origin))
    }

    /// Segments of this gear, ready for [`RootStress::of_tooth`] under any forces.
    pub fn spread(&self, segments: &[Segment]) -> SpreadSegments {
        let segments = segments.iter();
        SpreadSegments(
            segments
                .map(|segment| (*segment, self.loads.weights(segment)))
                .collect(),
        )
    }

    /// Stress in the root of `tooth` under the normal forces `loads`, N, on `segments`. In plane strain every loaded segment of the
    /// tooth stands for a slice of its own, which feels the line loads in it and no others.
    ///
    /// # Errors
    /// [`BeyondModel`] for a loaded segment on a tooth farther away than [`Settings::reach`].
    ///
    /// # Panics
    /// With another number of loads than of segments.
    pub fn of_tooth(
        &self,
        tooth: i32,
        segments: &SpreadSegments,
        loads: &[f64],
    ) -> Result<RootField<'_>, BeyondModel> {
        assert_eq!(segments.0.len(), loads.len(), "a load for each segment");
        let all = segments.0.iter().zip(loads);
        let loaded: Vec<_> = all.filter(|(_, force)| **force != 0.0).collect();
        for ((segment, _), _) in &loaded {
            let (distance, reach) = (tooth.abs_diff(segment.tooth) as usize, self.reach);
            if distance > reach {
                return Err(BeyondModel { distance, reach });
            }
        }
        // Under the share of every force that `share` says.
        let stress = |share: &dyn Fn(&Segment) -> f64| {
            let mut forces = vec![0.0; self.loads.len() * (2 * self.reach + 1)];
            for ((segment, weights), force) in &loaded {
                let away = tooth - segment.tooth;
                let first = (away + self.reach as i32) as usize * self.loads.len();
                let force = *force * share(segment);
                for (node, weight) in weights {
                    forces[first + node] += weight * force;
                }
            }
            let forces = forces.into_iter().enumerate();
            self.stress(forces.filter(|(_, force)| *force != 0.0))
        };
        let on_tooth = loaded
            .iter()
            .filter(|((s, _), f)| s.tooth == tooth && **f > 0.0);
        let beside: Vec<&Segment> = on_tooth.map(|((segment, _), _)| segment).collect();
        let Some(cos_base_helix) = self.plane else {
            let field = self.fillet.field(&stress(&|_| 1.0), beside.into_iter());
            return Ok(field);
        };
        let slices = match beside.is_empty() {
            true => loaded.iter().map(|((segment, _), _)| segment).collect(),
            false => beside.clone(),
        };
        let mut components = Vec::new();
        for slice in &slices {
            components.extend(stress(&|s| {
                let overlap = (s.z[1].min(slice.z[1]) - s.z[0].max(slice.z[0])).max(0.0);
                let lengths = (s.z[1] - s.z[0]) * (slice.z[1] - slice.z[0]);
                // Transverse force per length of the axis.
                cos_base_helix * overlap / lengths
            }));
        }
        let z = slices.iter().map(|slice| 0.5 * (slice.z[0] + slice.z[1]));
        Ok((self.fillet).field_at(z.collect(), &components, beside.into_iter()))
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
        let columns = [&mesh.loads[..], stress].concat();
        let (loads, reach) = (mesh.loads.len(), model.reach as i32);
        let response = model.response(mesh, &columns, loads, -reach..=reach, progress)?;
        let (mut entries, mut units) = (Vec::new(), Vec::new());
        for column in response.iter().flat_map(|tooth| tooth.column_iter()) {
            let unit = match column.amax() {
                0.0 => 1.0,
                largest => largest / LARGEST,
            };
            // The columns push outwards, flanks are pressed inwards.
            entries.extend(column.iter().map(|s| (-s / unit).round() as i16));
            units.push(unit as f32);
        }
        Ok(Map { entries, units })
    }
}

/// 1/sqrt(3), abscissa of the two-point Gauss rule.
const GAUSS2: f64 = 0.577_350_269_189_625_8;

/// Over the normal module: distance from a load within which the stress is that of its spreading, without limit at a tip corner.
const LOCAL_OVER_MODULE: f64 = 0.45;

struct Place {
    layer: usize,
    /// m.
    z: f64,
    /// Points zeta of the layer, and their shares in the stress here.
    shares: Vec<(f64, f64)>,
}

impl Place {
    fn new(layer: usize, z: f64, shares: Vec<(f64, f64)>) -> Place {
        Place { layer, z, shares }
    }

    /// Both faces and the middles of the layers between `stations`; the station itself in plane strain.
    fn along(stations: &[f64]) -> Vec<Place> {
        let layers = stations.len() - 1;
        if layers == 0 {
            return vec![Place::new(0, stations[0], vec![(-1.0, 1.0)])];
        }
        // On the straight line through both Gauss points, at zeta = -1 or 1.
        let near = 0.5 * (1.0 + 1.0 / GAUSS2);
        let far = 1.0 - near;
        let first = vec![(-GAUSS2, near), (GAUSS2, far)];
        let mut places = vec![Place::new(0, stations[0], first)];
        for (layer, ends) in stations.windows(2).enumerate() {
            places.push(Place::new(
                layer,
                0.5 * (ends[0] + ends[1]),
                vec![(0.0, 1.0)],
            ));
        }
        let last = vec![(-GAUSS2, far), (GAUSS2, near)];
        places.push(Place::new(layers - 1, stations[layers], last));
        places
    }
}

/// A point of the face of an element.
struct FacePoint {
    place: Vector3<f64>,
    normal: Vector3<f64>,
    /// Stress by the displacements.
    stress: [LoadColumn; COMPONENTS],
}

/// Points on the fillet, and the stress at each: those of a place along the face in a row, [`COMPONENTS`] of a point together.
fn points(model: &Model, mesh: &Mesh) -> (Fillet, Vec<LoadColumn>) {
    let fillet = &model.section.fillet;
    let mut grid = Fillet {
        form_roll: model.grid.form_roll,
        arc_per_roll_squared: model.grid.arc_per_roll_squared,
        local: LOCAL_OVER_MODULE * model.gear.normal_module,
        standard_tangent: match model.gear.kind {
            GearKind::External => 30f64.to_radians(),
            GearKind::Ring => 60f64.to_radians(),
        },
        ..Fillet::default()
    };
    let mut columns = Vec::new();
    for (number, place) in Place::along(&model.grid.stations).iter().enumerate() {
        grid.z.push(place.z);
        for element in 0..fillet.len() / 2 {
            for xi in [-GAUSS2, GAUSS2] {
                let mut stress: [LoadColumn; COMPONENTS] = Default::default();
                for (at, (zeta, share)) in place.shares.iter().enumerate() {
                    let point = FacePoint::new(model, mesh, [element, place.layer], [xi, *zeta]);
                    if number == 0 && at == 0 {
                        grid.radii.push(point.place.x.hypot(point.place.y));
                        // The normal's part along the tooth's centre line, which turns along z.
                        let (sin, cos) = (twist(&model.gear) * point.place.z).sin_cos();
                        let across = (point.normal.x * cos + point.normal.y * sin).abs();
                        grid.tangents.push(across.min(1.0).asin());
                        let [low, mid, high] = [0, 1, 2].map(|i| fillet[2 * element + i].1);
                        let curved = 0.5 * (low - 2.0 * mid + high) * xi * xi;
                        grid.arcs.push(mid + 0.5 * (high - low) * xi + curved);
                    }
                    for (column, part) in stress.iter_mut().zip(point.stress) {
                        column.extend(part.iter().map(|(unknown, f)| (*unknown, share * f)));
                    }
                }
                columns.extend(stress);
            }
        }
    }
    (grid, columns)
}

impl FacePoint {
    fn new(
        model: &Model,
        mesh: &Mesh,
        [element, layer]: [usize; 2],
        [xi, zeta]: [f64; 2],
    ) -> FacePoint {
        let plane = mesh.dimension == 2;
        let nodes = face_nodes(model.section.fillet.len() / 2, element, layer, plane);
        let (nodes, shapes): (Vec<usize>, Vec<_>) = nodes
            .map(|(node, c)| (mesh.fillet[node], shape(2, c, &[xi, zeta, 0.0])))
            .unzip();
        let (place, [profile, helix, _]) = place_and_tangents(&shapes, &mesh.coordinates(&nodes));
        let helix = if plane { Vector3::z() } else { helix };
        // Orthonormal in the tangent plane: b along the helix, s across it.
        let helix_length = helix.norm();
        let b = helix / helix_length;
        let lean = profile.dot(&b);
        let s = profile - lean * b;
        let length = s.norm();
        let s = s / length;
        let [youngs_modulus, nu] = mesh.material;
        let stiff = youngs_modulus / (1.0 - nu * nu);
        let shear = youngs_modulus / (2.0 * (1.0 + nu));
        let mut stress: [LoadColumn; COMPONENTS] = Default::default();
        for (node, (_, slope)) in nodes.into_iter().zip(shapes) {
            // Derivatives along s and b; those along z vanish in plane strain.
            let d_b = if plane { 0.0 } else { slope[1] / helix_length };
            let d_s = (slope[0] - lean * d_b) / length;
            let (sin, cos) = mesh.angles[node].sin_cos();
            let axes = [[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]].map(Vector3::from);
            for (d, axis) in axes.iter().enumerate().take(mesh.dimension) {
                let (u_s, u_b) = (axis.dot(&s), axis.dot(&b));
                let (e_s, e_b) = (d_s * u_s, d_b * u_b);
                let unknown = mesh.dimension * node + d;
                stress[0].push((unknown, stiff * (e_s + nu * e_b)));
                stress[1].push((unknown, stiff * (e_b + nu * e_s)));
                stress[2].push((unknown, shear * (d_b * u_s + d_s * u_b)));
            }
        }
        FacePoint {
            place,
            normal: s.cross(&b),
            stress,
        }
    }
}

#[cfg(test)]
#[path = "root_stress_tests.rs"]
mod tests;
