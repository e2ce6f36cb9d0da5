//! Bodies that are no solids of revolution ([`super::cylinder`]): their stiffness, and what it changes in the influences of loads.

use super::cache::Stored;
use super::cylinder::{Basis, Cut};
use super::error::FiniteElementError;
use super::flank::Weights;
use super::mesh::{Hole, Layers, Mesh};
use super::outline::Outline;
use super::section::Section;
use super::settings::{Discretization, graded_from_both, halved};
use crate::gear::{BodyShape, HoleCircle, Refinement, ToothProfile, UnevenBody};
use gearmesh::gear::{Body, Gear};
use nalgebra::DMatrix;
use std::f64::consts::TAU;
use std::sync::Arc;

/// The gear with a foundation in place of `body`.
pub(super) fn cut_from(gear: &Gear, body: &UnevenBody) -> Gear {
    Gear {
        held_radius: body.radius,
        foundation: Some(basis(gear, body).foundation(gear)),
        body: Some(Body {
            rim_radius: body.radius,
            web: body.z,
            hub_radius: body.radius,
            hub: body.z,
            held_ends: [false; 2],
        }),
        ..gear.clone()
    }
}

/// The basis in which `body` joins the rim of `gear`.
pub fn basis(gear: &Gear, body: &UnevenBody) -> Basis {
    let basis = Basis::new(gear, body.radius, body.z);
    match &body.shape {
        BodyShape::Nodes(nodes) => Basis {
            orders: basis.orders.min(nodes.orders),
            polynomials: basis.polynomials.min(nodes.stations),
            ..basis
        },
        _ => basis,
    }
}

/// Stiffness of the `body` of `gear` in `basis`, N/m.
///
/// # Errors
/// A body of finite elements that takes more memory than there is, or is not held.
pub fn stiffness(
    gear: &Gear,
    body: &UnevenBody,
    basis: &Basis,
) -> Result<DMatrix<f64>, FiniteElementError> {
    let pattern = match &body.shape {
        BodyShape::Nodes(nodes) => return Ok(basis.projected(&nodes.points, &nodes.stiffness)),
        BodyShape::Holes(circle) => Pattern::of_circle(circle, false),
        BodyShape::Pins(circle) => Pattern::of_circle(circle, true),
        BodyShape::Supports {
            count,
            width,
            angle,
        } => Pattern {
            count: *count,
            angle: *angle,
            what: Feature::Support(*width),
        },
    };
    let mesh = pattern.mesh(gear, basis)?;
    let mut stiffness = basis.stiffness(&mesh, pattern.count, basis.foundation(gear))?;
    // Symmetric: turned rows become columns, and then they are turned, too.
    for _ in 0..2 {
        basis.turn(stiffness.as_view_mut(), pattern.angle);
        stiffness.transpose_mut();
    }
    Ok(stiffness)
}

/// Elements in the radius of a hole, and in the width of a support or its distance from the cylinder.
pub(super) const ELEMENTS: f64 = 5.0;
/// Radii of a hole or pin within which elements about its middle do not grow.
pub(super) const FINE: f64 = 1.1;
/// Growth of the elements beyond.
pub(super) const GROWTH: f64 = 1.6;

/// What comes again all around a body.
struct Pattern {
    count: u32,
    /// Where one of it lies, rad.
    angle: f64,
    what: Feature,
}

#[derive(Clone, Copy)]
enum Feature {
    /// A hole, or a pin in it.
    Hole(Hole),
    /// A part of this width, rad, of the surface below, held.
    Support(f64),
}

impl Pattern {
    fn of_circle(circle: &HoleCircle, pin: bool) -> Pattern {
        Pattern {
            count: circle.count,
            angle: circle.angle,
            what: Feature::Hole(Hole {
                middle: [circle.circle_radius, 0.0],
                radius: circle.radius,
                pin,
            }),
        }
    }

    /// Mesh of a sector of the body of `gear`, about one hole or support at angle 0, its cylinder, that of `basis`, on a foundation.
    fn mesh(&self, gear: &Gear, basis: &Basis) -> Result<Mesh, FiniteElementError> {
        let (radius, held) = (basis.radius, gear.held_radius);
        let foundation = basis.foundation(gear);
        let half_sector = 0.5 * TAU / f64::from(self.count);
        // Radii and angles between which elements are fine.
        let (size, radii, half_angle) = match self.what {
            Feature::Hole(hole) => {
                let ([middle, _], around) = (hole.middle, FINE * hole.radius);
                let radii = [middle - around, middle + around];
                (hole.radius, radii, around / middle)
            }
            Feature::Support(width) => {
                let size = (width * held).min((radius - held).abs());
                (size, [held; 2], 0.5 * width)
            }
        };
        let fine = (size / ELEMENTS).min(gear.normal_module);
        // Along the largest element a wave of the highest order turns by a radian.
        let largest = fine.max(radius / basis.orders as f64);
        let per_angle = 0.5 * (radius + held);
        let angles = ends_about(
            [-half_sector, half_sector],
            [-half_angle, half_angle],
            [fine, largest].map(|size| size / per_angle),
        );
        let outline = Outline::new(&ToothProfile::new(gear)?);
        let is_bore_held = matches!(self.what, Feature::Hole(hole) if !hole.pin);
        // Straight: round bodies are the same along any helix.
        let gear = Gear {
            helix_angle: 0.0,
            foundation: (!is_bore_held).then_some(foundation),
            ..gear.clone()
        };
        let section = Section::of_body(&gear, radius, &halved(&angles), |part| {
            ends_about(part, radii, [fine, largest])
        });
        // Through a web the coarse ones are too few.
        let refinement = match gear.body {
            Some(_) => Refinement::Normal,
            None => Refinement::Coarse,
        };
        let layers = Layers::new(&gear, &Discretization::of(refinement));
        let mut mesh = Mesh::new(&gear, &outline, &section, Some(&layers));
        let is_on =
            |point: &[f64; 3], radius: f64| (point[0].hypot(point[1]) / radius - 1.0).abs() < 1e-9;
        match self.what {
            Feature::Hole(hole) => mesh.hole = Some(hole),
            Feature::Support(_) => {
                let places = mesh.points.iter().zip(&mesh.angles);
                let rests = places
                    .map(|(point, angle)| is_on(point, held) && angle.abs() < half_angle + 1e-9);
                mesh.held = rests.collect();
            }
        }
        mesh.on_held_surface = mesh
            .points
            .iter()
            .map(|point| is_on(point, radius))
            .collect();
        mesh.foundation = Some(foundation);
        Ok(mesh)
    }
}

/// Ends of elements from `from` to `to`, whose sizes are `fine` within `near` and grow away from it up to `largest`.
fn ends_about([from, to]: [f64; 2], near: [f64; 2], [fine, largest]: [f64; 2]) -> Vec<f64> {
    let mut near = near.map(|x| x.clamp(from.min(to), from.max(to)));
    if from > to {
        near.reverse();
    }
    let mut ends = vec![from];
    let parts = [
        ([from, near[0]], [largest, fine], largest),
        (near, [fine; 2], fine),
        ([near[1], to], [fine, largest], largest),
    ];
    for ([low, high], sizes, largest) in parts.into_iter().filter(|([a, b], ..)| a != b) {
        let parts = graded_from_both((high - low).abs(), sizes, GROWTH, largest);
        ends.extend(parts[1..].iter().map(|t| low + t * (high - low)));
    }
    ends
}

/// Change of the influences of teeth on a foundation by the body that takes its place.
#[derive(Debug, Clone)]
pub(super) struct BodyChange {
    basis: Basis,
    teeth: u32,
    cut: Arc<Cut>,
    /// D of the body as it stands, in canonical coordinates of the gear.
    whole: Arc<DMatrix<f64>>,
    /// Its mean over all angles.
    mean: Arc<DMatrix<f64>>,
    /// Angle of tooth 0, rad.
    origin: f64,
    /// Which tooth is tooth 0 of segments; None: the mean of all.
    first: Option<i32>,
}

impl BodyChange {
    /// By a body of this `stiffness` (N/m, in `basis`) under the teeth of `gear` that are `cut` from it, seen in a mirror of z if it `is_mirrored`.
    pub fn new(
        gear: &Gear,
        basis: Basis,
        stiffness: &DMatrix<f64>,
        cut: Arc<Cut>,
        is_mirrored: bool,
    ) -> Result<BodyChange, FiniteElementError> {
        // Right-handed, its loaded flank facing +theta: `PairGeometry::is_mirrored`.
        let sense = if is_mirrored { -gear.hand } else { gear.hand };
        let stiffness = basis.mirrored(stiffness, sense < 0.0, is_mirrored);
        let whole = cut.change(&stiffness, basis.foundation(gear))?;
        let half_pitch = 0.5 * TAU / gear.z();
        Ok(BodyChange {
            basis,
            teeth: gear.teeth,
            cut,
            mean: Arc::new(basis.mean(&whole)),
            whole: Arc::new(whole),
            // Body +x is the middle of a space of a ring.
            origin: if gear.kappa() < 0.0 {
                -sense * half_pitch
            } else {
                0.0
            },
            first: None,
        })
    }

    pub fn at_tooth(&self, first: i32) -> BodyChange {
        BodyChange {
            first: Some(first),
            ..self.clone()
        }
    }

    /// Coordinates of the cylinder, turned to the body, under `loads`: the tooth and weights on its flank nodes of each.
    pub fn coordinates<'l>(
        &self,
        loads: impl ExactSizeIterator<Item = (i32, &'l Weights)>,
    ) -> DMatrix<f64> {
        let mut coordinates = DMatrix::zeros(self.basis.len(), loads.len());
        for (j, (tooth, weights)) in loads.enumerate() {
            let mut column = coordinates.columns_range_mut(j..=j);
            for (node, weight) in weights {
                let of_node = self.cut.by_flank.column(*node);
                column.zip_apply(&of_node, |sum, value| *sum += weight * value);
            }
            let tooth = tooth + self.first.unwrap_or(0);
            let angle = TAU * f64::from(tooth) / f64::from(self.teeth);
            self.basis.turn(column, angle + self.origin);
        }
        coordinates
    }

    /// What the change of the body adds to the work of loads with the coordinates `rows` on displacements by those with `columns`, m N.
    pub fn work(&self, rows: &DMatrix<f64>, columns: &DMatrix<f64>) -> DMatrix<f64> {
        let change = match self.first {
            Some(_) => &*self.whole,
            None => &*self.mean,
        };
        rows.transpose() * (change * columns)
    }

    /// What the body turned on to each of `teeth` adds beyond its mean to the work of loads with these `coordinates`, those of
    /// [`BodyChange::coordinates`] in the mean, on the displacements by each other, m N.
    pub fn beyond_mean(&self, coordinates: &DMatrix<f64>, teeth: &[i32]) -> Vec<DMatrix<f64>> {
        let beyond = &*self.whole - &*self.mean;
        let works = teeth.iter().map(|tooth| {
            let mut turned = coordinates.clone();
            let angle = TAU * f64::from(*tooth) / f64::from(self.teeth);
            self.basis.turn(turned.as_view_mut(), angle);
            turned.transpose() * (&beyond * &turned)
        });
        works.collect()
    }
}

/// The stiffness of a body, as [`stiffness`] gives it.
impl Stored for DMatrix<f64> {
    fn encode(&self) -> Vec<u8> {
        self.iter().flat_map(|x| x.to_le_bytes()).collect()
    }

    fn decode(bytes: &[u8]) -> Option<DMatrix<f64>> {
        let (words, rest) = bytes.as_chunks::<8>();
        let size = words.len().isqrt();
        let is_square = rest.is_empty() && size * size == words.len();
        is_square.then(|| {
            DMatrix::from_iterator(size, size, words.iter().map(|x| f64::from_le_bytes(*x)))
        })
    }
}

impl Stored for Cut {
    fn encode(&self) -> Vec<u8> {
        let size = [self.by_flank.nrows(), self.by_flank.ncols()];
        let size = size.into_iter().flat_map(|n| (n as u64).to_le_bytes());
        let numbers = self.by_flank.iter().chain(self.compliance.iter());
        size.chain(numbers.flat_map(|x| x.to_le_bytes())).collect()
    }

    fn decode(bytes: &[u8]) -> Option<Cut> {
        let words = bytes.as_chunks::<8>();
        let words = (words.1.is_empty()).then_some(words.0)?;
        let ([rows, columns], numbers) = words.split_first_chunk()?;
        let [rows, columns] = [rows, columns].map(|n| u64::from_le_bytes(*n) as usize);
        let count = rows.checked_mul(columns)?;
        let size = count.checked_add(rows.checked_mul(rows)?)?;
        let numbers: Vec<f64> = numbers.iter().map(|x| f64::from_le_bytes(*x)).collect();
        (numbers.len() == size).then(|| Cut {
            by_flank: DMatrix::from_column_slice(rows, columns, &numbers[..count]),
            compliance: DMatrix::from_column_slice(rows, rows, &numbers[count..]),
        })
    }
}

#[cfg(test)]
#[path = "uneven_tests.rs"]
mod tests;
