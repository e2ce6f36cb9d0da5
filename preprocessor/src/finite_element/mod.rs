//! Finite-element compliance of one gear: all teeth, rim and web down to the held surface.
//!
//! ```text
//!  gear::ToothProfile ─> outline ─> section ─> mesh ─> condensation ─> ring ─> influence
//!                        by arc     one tooth   along   Cholesky,       whole   of flank
//!                        length     sector      helix   sides left      gear    nodes
//! ```
//!
//! The result are the matrices C_k of normal displacements of the flank nodes of tooth k per unit normal load on the flank
//! nodes of tooth 0 (docs/theory/compliance.md). A [`Segment`] is a line load spread across its contact line by a smooth
//! kernel; weights f on the flank nodes give the influence f_i^T C f_j. It contains the kernel's own local displacement,
//! and [`FiniteElementCompliance::reference_lengths`] says how much, so that the sum with the Hertz contact does not depend
//! on the kernel's width.

mod cache;
mod condensation;
mod cylinder;
mod dense;
mod element;
mod error;
mod flank;
mod mesh;
mod model;
mod ring;
mod root_stress;
mod section;
mod settings;
mod uneven;

pub use cache::{CachedModel, ModelCache, Origin};
pub use error::FiniteElementError;
pub use model::{Progress, Stage, centre_line_compliance, sector_unknowns};
pub use root_stress::{RootStress, SpreadSegments};
pub use settings::{Discretization, Settings};
pub(crate) use uneven::{basis as body_basis, stiffness as body_stiffness};

use crate::compliance::{self, BeyondModel, Load, ToothCompliance};
use crate::gear::{Pair, UnevenBody, body};
use cache::Stored;
use cylinder::Cut;
use flank::{FlankGrid, Weights};
use gearmesh::contact::Segment;
use gearmesh::gear::{Flank, Gear, PairGeometry};
use gearmesh::vector::Lanes;
use model::Model;
use nalgebra::DMatrix;
use std::ops::Range;
use std::sync::Arc;
use uneven::BodyChange;

/// Progress of both gears: the number of the gear (0 or 1) in front of what [`Progress`] is called with.
type PairProgress<'a> = dyn Fn(usize, Stage, f64) -> bool + Sync + 'a;

/// Finite-element model of one gear, reduced to its loaded flank.
#[derive(Debug, Clone)]
pub struct FiniteElementCompliance {
    grid: FlankGrid,
    influence: Arc<Influence>,
    /// If the gear is cut from its body, which is no solid of revolution.
    body: Option<BodyChange>,
    plane_strain: bool,
    /// Of the base helix; plane strain alone needs it.
    cos_base_helix: f64,
    /// The gear turned end for end, if its body is another one then.
    turned: Option<Box<FiniteElementCompliance>>,
}

impl FiniteElementCompliance {
    /// Computes the model of `gear`, whose body joins its teeth as a pair file's does, or reads it from `cache` if there is one;
    /// microgeometry plays no part.
    ///
    /// # Errors
    /// [`FiniteElementError`]: no usable tooth, memory, or cancelled by `progress`.
    pub fn new(
        gear: &Gear,
        settings: &Settings,
        cache: Option<&ModelCache>,
        progress: &Progress<'_>,
    ) -> Result<(Self, Origin), FiniteElementError> {
        let one = |gear: &Gear| -> Result<(Self, Origin), FiniteElementError> {
            let model = Model::new(gear, settings)?;
            let compute = || Ok(Influence::new(&model.influence(progress)?));
            let (influence, origin) = cache::get(cache, &model, "", compute)?;
            let found = FiniteElementCompliance {
                grid: model.grid,
                influence: Arc::new(influence),
                body: None,
                plane_strain: settings.plane_strain,
                cos_base_helix: gear.base_helix_angle().cos(),
                turned: None,
            };
            Ok((found, origin))
        };
        let (mut model, mut origin) = one(gear)?;
        if let Some(gear) = body::turned(gear) {
            let (turned, of_turned) = one(&gear)?;
            // Of a gear with two models the one that was not simply read.
            if of_turned != Origin::Loaded {
                origin = of_turned;
            }
            model.turned = Some(Box::new(turned));
        }
        Ok((model, origin))
    }

    /// This model of `gear` without its `uneven_body` on that body; settings and cache as those of this model.
    fn on_body(
        &self,
        gear: &Gear,
        uneven_body: &UnevenBody,
        settings: &Settings,
        cache: Option<&ModelCache>,
        progress: &Progress<'_>,
    ) -> Result<Self, FiniteElementError> {
        let basis = uneven::basis(gear, uneven_body);
        let cut = uneven::cut_from(gear, uneven_body);
        let condensing = |share| progress(Stage::Condensation, share);
        let of_teeth = |gear: &Gear| {
            let model = Model::new(gear, settings)?;
            let basis = cylinder::Basis {
                z: gear.body.map_or(basis.z, |body| body.web),
                ..basis
            };
            let compute = || Cut::new(&basis, &model.mesh(), gear.teeth, &condensing);
            let (found, _) = cache::get(cache, &model, &format!("{basis:?} "), compute)?;
            Ok::<_, FiniteElementError>(Arc::new(found))
        };
        let own = of_teeth(&cut)?;
        let other = match body::turned(&cut) {
            Some(turned) => of_teeth(&turned)?,
            None => own.clone(),
        };
        let stiffness = uneven::stiffness(gear, uneven_body, &basis)?;
        let mut turned = self.turned.as_deref().unwrap_or(self).clone();
        turned.body = Some(BodyChange::new(gear, basis, &stiffness, other, true)?);
        Ok(FiniteElementCompliance {
            body: Some(BodyChange::new(gear, basis, &stiffness, own, false)?),
            turned: Some(Box::new(turned)),
            ..self.clone()
        })
    }

    /// `loads` on the nodes of the flank.
    fn loads(&self, segments: &[Segment], loads: &[Load]) -> Result<Vec<FlankLoad>, BeyondModel> {
        let teeth = || segments.iter().map(|s| s.tooth);
        let (first, last) = (teeth().min().unwrap_or(0), teeth().max().unwrap_or(0));
        let (distance, reach) = (last.abs_diff(first) as usize, self.influence.teeth() - 1);
        if distance > reach {
            return Err(BeyondModel { distance, reach });
        }
        let weights: Vec<Weights> = segments.iter().map(|s| self.grid.weights(s)).collect();
        let spread = |load: &Load| {
            let parts = load.iter().flat_map(|(i, force)| {
                let of_segment = weights[*i].iter();
                of_segment.map(move |(node, weight)| (*node, force * weight))
            });
            FlankLoad {
                tooth: segments[load[0].0].tooth,
                weights: parts.collect(),
            }
        };
        Ok(loads.iter().map(spread).collect())
    }

    /// What each of `rows` works on the displacements by the `wanted` ones of `columns`; zero for the others.
    fn work_between(
        &self,
        [rows, columns]: [&[FlankLoad]; 2],
        wanted: &dyn Fn(usize) -> Range<usize>,
    ) -> DMatrix<f64> {
        let mut work = DMatrix::zeros(rows.len(), columns.len());
        let of_tooth = |loads: &[FlankLoad], tooth: i32| -> Vec<usize> {
            (0..loads.len())
                .filter(|i| loads[*i].tooth == tooth)
                .collect()
        };
        let mut teeth: Vec<i32> = rows.iter().map(|load| load.tooth).collect();
        teeth.sort_unstable();
        teeth.dedup();
        for tooth in &teeth {
            for other in &teeth {
                let mut loads = of_tooth(columns, *other);
                let is_asked = |i: usize, j: usize| wanted(i).contains(&j);
                let mut observed = of_tooth(rows, *tooth);
                observed.retain(|i| loads.iter().any(|j| is_asked(*i, *j)));
                loads.retain(|j| observed.iter().any(|i| is_asked(*i, *j)));
                if loads.is_empty() {
                    continue;
                }
                let [of_rows, of_columns] = [(rows, &observed), (columns, &loads)]
                    .map(|(all, some)| some.iter().map(|i| &all[*i].weights).collect::<Vec<_>>());
                // The model holds displacements of the loaded tooth and of those after it.
                let offset = tooth.abs_diff(*other) as usize;
                let found = match tooth >= other {
                    true => self
                        .displacements(offset, &of_columns, &of_rows)
                        .transpose(),
                    false => self.displacements(offset, &of_rows, &of_columns),
                };
                for (row, i) in observed.iter().enumerate() {
                    for (column, j) in loads.iter().enumerate() {
                        if is_asked(*i, *j) {
                            work[(*i, *j)] = found[(row, column)];
                        }
                    }
                }
            }
        }
        if let Some(body) = &self.body {
            let [of_rows, of_columns] = [rows, columns].map(|loads| {
                let loads = loads.iter().map(|load| (load.tooth, &load.weights));
                body.coordinates(loads)
            });
            let change = body.work(&of_rows, &of_columns);
            for i in 0..rows.len() {
                for j in wanted(i) {
                    work[(i, j)] += change[(i, j)];
                }
            }
        }
        work
    }

    /// Displacements that the weights `observed` see, columns, by those of `loads`, rows, on a tooth `offset` teeth before.
    fn displacements(
        &self,
        offset: usize,
        loads: &[&Weights],
        observed: &[&Weights],
    ) -> DMatrix<f64> {
        let [(nodes, loads), (seen, observed)] = [loads, observed].map(compact);
        // Of the nodes, rows, by forces on each of the loaded ones.
        let mut influence = Vec::with_capacity(seen.len() * nodes.len());
        let runs = runs(&seen);
        for node in &nodes {
            let whole = self.influence.column(offset, *node);
            for run in &runs {
                let entries = whole[run.clone()].iter();
                influence.extend(entries.map(|entry| self.influence.unit * f64::from(*entry)));
            }
        }
        let influence = DMatrix::from_vec(seen.len(), nodes.len(), influence);
        let displaced = combined(&influence, &loads).transpose();
        combined(&displaced, &observed)
    }

    /// Factor of the influence of two segments in plane strain on each other beyond that of their weights.
    fn slice_factor(&self, a: &Segment, b: &Segment) -> f64 {
        // Segments act on each other as far as they lie in the same slices. The force per length of contact line is cos beta_b
        // times that per metre of depth; so is the displacement along the flank normal seen from the transverse plane, but one
        // of the two factors is left to the shorter path of the line load, as the local contact counts it.
        let overlap = (a.z[1].min(b.z[1]) - a.z[0].max(b.z[0])).max(0.0);
        let lengths = (a.z[1] - a.z[0]) * (b.z[1] - b.z[0]);
        self.cos_base_helix * overlap / lengths
    }
}

/// Forces on the nodes of the flank of one tooth; a node may come more than once.
struct FlankLoad {
    tooth: i32,
    weights: Weights,
}

impl ToothCompliance for FiniteElementCompliance {
    fn bulk(&self, segments: &[Segment]) -> Result<DMatrix<f64>, BeyondModel> {
        let alone: Vec<Load> = (0..segments.len()).map(|i| vec![(i, 1.0)]).collect();
        let loads = self.loads(segments, &alone)?;
        let mut matrix = self.work_between([&loads, &loads], &|row| 0..row + 1);
        if self.plane_strain {
            for (j, column) in segments.iter().enumerate() {
                for (i, row) in segments.iter().enumerate().skip(j) {
                    matrix[(i, j)] *= self.slice_factor(row, column);
                }
            }
        }
        matrix.fill_upper_triangle_with_lower_triangle();
        Ok(matrix)
    }

    fn at_tooth(&self, tooth: i32) -> Option<Arc<dyn ToothCompliance>> {
        let body = self.body.as_ref()?;
        let turned = self
            .turned
            .as_deref()
            .map(|turned| FiniteElementCompliance {
                body: turned.body.as_ref().map(|body| body.at_tooth(tooth)),
                ..turned.clone()
            });
        Some(Arc::new(FiniteElementCompliance {
            body: Some(body.at_tooth(tooth)),
            turned: turned.map(Box::new),
            ..self.clone()
        }))
    }

    fn work(
        &self,
        segments: &[Segment],
        [rows, columns]: [&[Load]; 2],
        wanted: &dyn Fn(usize) -> Range<usize>,
    ) -> Result<DMatrix<f64>, BeyondModel> {
        if self.plane_strain {
            // Segments act on each other slice by slice.
            return Ok(compliance::work(
                &self.bulk(segments)?,
                [rows, columns],
                wanted,
            ));
        }
        let loads = self.loads(segments, &[rows, columns].concat())?;
        let (rows, columns) = loads.split_at(rows.len());
        Ok(self.work_between([rows, columns], wanted))
    }

    fn reference_lengths(&self, segments: &[Segment]) -> Vec<f64> {
        let length = |segment| self.grid.reference_length(segment);
        segments.iter().map(length).collect()
    }

    fn turned(&self) -> Option<&dyn ToothCompliance> {
        Some(self.turned.as_deref()?)
    }

    fn corner_resolution(&self) -> f64 {
        self.grid.edge_resolution()
    }

    fn lengthwise_resolution(&self) -> f64 {
        let layers = self.grid.stations.windows(2).map(|ends| ends[1] - ends[0]);
        layers.fold(0.0, f64::max)
    }
}

/// The nodes of `weights`, ascending, and the weights with nodes counted among them.
fn compact(weights: &[&Weights]) -> (Vec<usize>, Vec<Weights>) {
    let all = || weights.iter().flat_map(|weights| weights.iter());
    let end = all().map(|(node, _)| node + 1).max().unwrap_or(0);
    let mut place = vec![0; end];
    all().for_each(|(node, _)| place[*node] = 1);
    let nodes: Vec<usize> = (0..end).filter(|node| place[*node] > 0).collect();
    for (i, node) in nodes.iter().enumerate() {
        place[*node] = i;
    }
    let counted = |weights: &&Weights| weights.iter().map(|(node, w)| (place[*node], *w)).collect();
    let counted = weights.iter().map(counted).collect();
    (nodes, counted)
}

/// The columns of `matrix` in combinations of the weights `weights`.
fn combined(matrix: &DMatrix<f64>, weights: &[Weights]) -> DMatrix<f64> {
    let n = matrix.nrows();
    let mut sums = DMatrix::zeros(n, weights.len());
    Lanes::widest().run(
        #[inline(always)]
        |_| {
            for (weights, mut sums) in weights.iter().zip(sums.column_iter_mut()) {
                let sums = sums.as_mut_slice();
                for (column, weight) in weights {
                    let column = &matrix.as_slice()[column * n..][..n];
                    for (sum, value) in sums.iter_mut().zip(column) {
                        *sum += weight * value;
                    }
                }
            }
        },
    );
    sums
}

/// The ascending `nodes` as ranges of neighbours: a contact line crosses a part of the flank.
fn runs(nodes: &[usize]) -> Vec<Range<usize>> {
    let neighbours = nodes.chunk_by(|a, b| a + 1 == *b);
    neighbours
        .map(|run| run[0]..run[run.len() - 1] + 1)
        .collect()
}

/// The unit is the largest entry over this. The largest one, a node in a corner of the flank under a load of its
/// own, is some hundred times the usual ones: these are kept to 1e-7, and segments average over many nodes.
const LARGEST_ENTRY: f64 = (1_u32 << 30) as f64;

/// Influence matrices in whole numbers of a small unit: half the memory of `f64`, a third to a sixth of it in files.
///
/// Neighbouring nodes move nearly alike, so that what is left of an entry after its neighbours in row and column
/// (`c_ij - c_i-1,j - c_i,j-1 + c_i-1,j-1`) mostly fits into one byte. A model is the same numbers whether it was
/// computed or read.
///
/// C_k, m/N (plane strain: m²/N, per force per metre of depth): rows tooth k, columns tooth 0.
#[derive(Debug, Clone, PartialEq)]
struct Influence {
    /// Of the entries, m/N.
    unit: f64,
    nodes: usize,
    entries: Vec<i32>,
}

impl Influence {
    fn new(matrices: &[DMatrix<f64>]) -> Influence {
        let entries = || matrices.iter().flat_map(|m| m.as_slice());
        let largest = entries().fold(0.0f64, |m, v| m.max(v.abs()));
        let unit = if largest > 0.0 {
            largest / LARGEST_ENTRY
        } else {
            1.0
        };
        Influence {
            unit,
            nodes: matrices.first().map_or(0, DMatrix::nrows),
            entries: entries().map(|v| (v / unit).round() as i32).collect(),
        }
    }

    fn teeth(&self) -> usize {
        self.entries.len() / (self.nodes * self.nodes).max(1)
    }

    /// Displacements of the nodes of tooth `k` by a load on `node` of tooth 0, in units.
    fn column(&self, k: usize, node: usize) -> &[i32] {
        let start = (k * self.nodes + node) * self.nodes;
        &self.entries[start..start + self.nodes]
    }
}

impl Stored for Influence {
    fn encode(&self) -> Vec<u8> {
        let mut out = self.unit.to_le_bytes().to_vec();
        out.extend((self.nodes as u64).to_le_bytes());
        let nothing = vec![0; self.nodes];
        for matrix in self.entries.chunks((self.nodes * self.nodes).max(1)) {
            let mut left = &nothing[..];
            for column in matrix.chunks(self.nodes) {
                let mut above = 0;
                for (entry, left) in column.iter().zip(left) {
                    let here = i64::from(*entry) - i64::from(*left);
                    put(here - above, &mut out);
                    above = here;
                }
                left = column;
            }
        }
        out
    }

    fn decode(mut bytes: &[u8]) -> Option<Influence> {
        let unit = f64::from_bits(word(&mut bytes)?);
        let nodes = usize::try_from(word(&mut bytes)?).ok()?;
        // Every entry takes a byte at least.
        let size = nodes.checked_mul(nodes)?;
        if size == 0 || size > bytes.len() {
            return None;
        }
        let mut entries: Vec<i32> = Vec::new();
        while !bytes.is_empty() {
            let is_first = entries.len().is_multiple_of(size);
            let mut here = 0;
            for row in entries.len()..entries.len() + nodes {
                here += take(&mut bytes)?;
                let left = if is_first { 0 } else { entries[row - nodes] };
                entries.push(i32::try_from(here + i64::from(left)).ok()?);
            }
        }
        entries.len().is_multiple_of(size).then_some(Influence {
            unit,
            nodes,
            entries,
        })
    }
}

fn word(bytes: &mut &[u8]) -> Option<u64> {
    let (head, tail) = bytes.split_first_chunk()?;
    *bytes = tail;
    Some(u64::from_le_bytes(*head))
}

/// Signed LEB128 with the sign in the lowest bit: seven bits a byte, the lowest first, the highest bit set where
/// more follow.
fn put(value: i64, out: &mut Vec<u8>) {
    let mut rest = ((value << 1) ^ (value >> 63)) as u64;
    while rest >= 0x80 {
        out.push(rest as u8 | 0x80);
        rest >>= 7;
    }
    out.push(rest as u8);
}

fn take(bytes: &mut &[u8]) -> Option<i64> {
    let mut value = 0;
    // Differences of 32-bit numbers need 34 bits and the sign.
    for shift in (0..35).step_by(7) {
        let (byte, tail) = bytes.split_first()?;
        *bytes = tail;
        value |= u64::from(byte & 0x7f) << shift;
        if byte & 0x80 == 0 {
            return Some((value >> 1) as i64 ^ -((value & 1) as i64));
        }
    }
    None
}

/// Models of gear 1 and gear 2; the same one twice when the gears are equal but for hand and axial position.
#[derive(Debug, Clone)]
pub struct PairModels<T> {
    /// One model per gear.
    pub gears: [Arc<T>; 2],
    /// Where each came from.
    pub origins: [Origin; 2],
}

/// Elastic models of both gears.
pub type PairCompliance = PairModels<FiniteElementCompliance>;

impl PairCompliance {
    /// Models of `pair` with its bodies; see [`PairCompliance::new`].
    ///
    /// # Errors
    /// As there; [`FiniteElementError::PlaneBody`] for a body that is no solid of revolution in plane strain.
    pub fn of(
        pair: &Pair,
        settings: &Settings,
        cache: Option<&ModelCache>,
        progress: &PairProgress<'_>,
    ) -> Result<PairCompliance, FiniteElementError> {
        let mut models = PairCompliance::new(&cut_pair(pair), settings, cache, progress)?;
        for (i, body) in pair.bodies.iter().enumerate() {
            if let Some(body) = body {
                let (gear, progress) = (&pair.geometry.gears[i], |stage, share| {
                    progress(i, stage, share)
                });
                let model = models.gears[i].on_body(gear, body, settings, cache, &progress)?;
                models.gears[i] = Arc::new(model);
            }
        }
        Ok(models)
    }

    /// Whether `cache` holds both models, sound or not.
    ///
    /// # Errors
    /// Those of gears that cannot be meshed.
    pub fn is_kept(
        pair: &PairGeometry,
        settings: &Settings,
        cache: &ModelCache,
    ) -> Result<bool, FiniteElementError> {
        for gear in &pair.gears {
            for gear in body::turned(gear).iter().chain([gear]) {
                if !cache.holds(&Model::new(gear, settings)?) {
                    return Ok(false);
                }
            }
        }
        Ok(true)
    }

    /// Computes both models, or reads them from the cache if there is one.
    ///
    /// # Errors
    /// Those of [`FiniteElementCompliance::new`].
    pub fn new(
        pair: &PairGeometry,
        settings: &Settings,
        cache: Option<&ModelCache>,
        progress: &PairProgress<'_>,
    ) -> Result<PairCompliance, FiniteElementError> {
        both(&pair.gears, progress, |gear, progress| {
            FiniteElementCompliance::new(gear, settings, cache, progress)
        })
    }
}

/// The geometry of `pair`, its teeth cut from bodies that are no solids of revolution.
pub(crate) fn cut_pair(pair: &Pair) -> PairGeometry {
    let mut geometry = pair.geometry.clone();
    for (gear, body) in geometry.gears.iter_mut().zip(&pair.bodies) {
        if let Some(body) = body {
            *gear = uneven::cut_from(gear, body);
        }
    }
    geometry
}

/// The maps of gear 1 and gear 2 of `pair` loaded on `flank` (of gear 1), the same one twice for equal gears; `settings` are
/// those of its compliance.
///
/// # Errors
/// Those of [`RootStress::new`].
pub fn pair_root_stress(
    pair: &PairGeometry,
    flank: Flank,
    settings: &Settings,
    cache: Option<&ModelCache>,
    progress: &PairProgress<'_>,
) -> Result<PairModels<RootStress>, FiniteElementError> {
    let settings = settings.for_root_stress();
    // As segments see them: turned end for end where they are mirrored.
    let gears = [0, 1].map(|i| {
        let turned = body::turned(&pair.gears[i]);
        let turned = turned.filter(|_| pair.is_mirrored(flank, i));
        turned.unwrap_or_else(|| pair.gears[i].clone())
    });
    both(&gears, progress, |gear, progress| {
        RootStress::new(gear, &settings, cache, progress)
    })
}

/// What `model` gives of the first and the second gear; of gears that are alike the same. Models are in canonical coordinates: hand
/// and axial position do not matter.
fn both<T>(
    gears: &[Gear; 2],
    progress: &PairProgress<'_>,
    model: impl Fn(&Gear, &Progress<'_>) -> Result<(T, Origin), FiniteElementError>,
) -> Result<PairModels<T>, FiniteElementError> {
    let one = |i: usize| {
        let found = model(&gears[i], &|stage, share| progress(i, stage, share));
        found.map(|(model, origin)| (Arc::new(model), origin))
    };
    let [first, second] = gears.each_ref().map(|gear| Gear {
        hand: 1.0,
        face_offset: 0.0,
        ..gear.clone()
    });
    let of_first = one(0)?;
    let of_second = match first == second {
        true => of_first.clone(),
        false => one(1)?,
    };
    Ok(PairModels {
        gears: [of_first.0, of_second.0],
        origins: [of_first.1, of_second.1],
    })
}

#[cfg(test)]
mod body_tests;
#[cfg(test)]
mod closure_tests;
#[cfg(test)]
mod contact_tests;
#[cfg(test)]
mod influence_tests;
#[cfg(test)]
mod tests;
