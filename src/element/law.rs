//! Elastic law of one flank: from the four mesh coordinates to the derivatives of the potential.

use super::bodies::Bodies;
use super::dual::{Scalar, lift};
use super::motion::ElementError;
use crate::contact::{ContactError, ContactFile, RuntimeContact, Warm};
use crate::friction::Sliding;
use crate::gear::teeth::Counts;
use crate::gear::{Flank, TurningBodies};
use crate::table::{COORDINATES, Effects, FlankTable, Potential, Query, Table, TeethFlank};
use std::sync::Arc;

/// A law of a caller for [`super::Element::with_laws`]: the potential W(delta, C, M, PMC) of a loaded flank, say a closed
/// form in tests and experiments.
///
/// `W` is zero, with all derivatives, while the flank does not touch; `Query` is in the flank's own
/// sense (coast tables: M > 0 still means more penetration at larger z).
pub trait Elasticity: Send + Sync {
    /// Potential, first derivatives and `hessian[0][0]`, the tangent stiffness, at `query`; the other
    /// second derivatives only if `want_hessian`. `counts` are the mesh cycles that passed on gear 1 and gear 2 since the pair of
    /// teeth 0, zero unless [`Elasticity::tells_teeth_apart`].
    ///
    /// # Errors
    /// Why there is none, as text.
    fn evaluate(
        &self,
        query: &Query,
        counts: Counts,
        want_hessian: bool,
    ) -> Result<Potential, String>;

    /// Whether it tells teeth apart and wants their counts.
    fn tells_teeth_apart(&self) -> bool {
        false
    }
}

impl Elasticity for FlankTable {
    #[inline]
    fn evaluate(&self, query: &Query, _: Counts, want_hessian: bool) -> Result<Potential, String> {
        Ok(FlankTable::evaluate(self, query, want_hessian))
    }
}

/// What gives the potential of one flank.
#[derive(Clone)]
pub(crate) enum Source {
    /// Spring of this stiffness on the line of action, N/m.
    Linear(f64),
    /// A flank of the pair's table.
    Table(Arc<Table>, Flank),
    /// The same, tooth pair by tooth pair.
    Teeth(Arc<Table>, Box<TeethFlank>),
    /// A static contact solve.
    Contact(Arc<RuntimeContact>),
    /// That of a caller.
    Custom(Arc<dyn Elasticity>),
}

/// Where the next evaluation of an element starts from: the contact forces of the last one, by flank. It saves time and changes
/// results by no more than rounding. Whoever evaluates in a loop keeps one.
#[derive(Debug, Clone, Default)]
pub struct Workspace(pub(crate) [Warm; 2]);

/// Law of one flank as the formulations use it.
#[derive(Clone)]
pub(crate) struct Law {
    pub source: Source,
    /// Whether it needs to know which teeth are in mesh.
    pub tells_teeth_apart: bool,
    /// Factors on the coordinates: 0 where the effect is off, -1 on the misalignment of a mirrored flank.
    coordinate_factors: [f64; COORDINATES],
    /// Likewise on the gradient.
    gradient_factors: [f64; COORDINATES],
    /// Whether its source finds [`Secondary`] results, and they are not off.
    finds_secondary: bool,
    /// -1 on axial positions of a mirrored flank.
    axial_factor: f64,
    /// Bodies whose compliance changes with their angle, if they have an effect.
    bodies: Option<Bodies>,
}

/// What a source may find beside the potential.
#[derive(Clone, Copy, Default)]
pub(crate) struct Secondary<T> {
    /// Share, axial share (m), distance (m) and weight of [`Sliding`].
    pub sliding: [T; 4],
    /// Stress in the roots of gear 1 and gear 2, Pa.
    pub root_stress: [T; 2],
}

/// Numbers of [`Secondary`].
const SECONDARY: usize = 6;

impl<T: Copy> Secondary<T> {
    fn to_array(self) -> [T; SECONDARY] {
        let ([share, axial, distance, weight], [first, second]) = (self.sliding, self.root_stress);
        [share, axial, distance, weight, first, second]
    }

    fn from_array([share, axial, distance, weight, first, second]: [T; SECONDARY]) -> Self {
        Self {
            sliding: [share, axial, distance, weight],
            root_stress: [first, second],
        }
    }
}

/// Secondary results as a source finds them.
pub(super) struct Found {
    secondary: Secondary<f64>,
    /// Slopes by each coordinate, as far as second derivatives of the potential brought them along.
    slopes: [Option<[f64; SECONDARY]>; COORDINATES],
}

/// Derivatives of the potential, as numbers that carry derivatives on.
pub(crate) struct Response<T> {
    /// W, J.
    pub energy: T,
    /// dW/d(delta, C, M, PMC): `[0]` is F_bt, `[2]` is F_bt (z_c - z_ref).
    pub gradient: [T; COORDINATES],
    /// Tangent stiffness on the line of action, N/m.
    pub stiffness: T,
    /// A coordinate lies outside the table.
    pub out_of_range: bool,
}

impl Law {
    /// Effects that are off leave out their coordinate; `mirrored`: the source is that of the other flank.
    pub(crate) fn new(source: Source, mirrored: bool, effects: Effects) -> Self {
        let sign = if mirrored { -1.0 } else { 1.0 };
        let if_on = |effect: bool, factor: f64| if effect { factor } else { 0.0 };
        let by_distance = if_on(effects.center_distance, 1.0);
        Self {
            tells_teeth_apart: match &source {
                Source::Linear(_) | Source::Table(..) => false,
                Source::Teeth(_, teeth) => teeth.tells_teeth_apart(),
                Source::Contact(_) => true,
                Source::Custom(law) => law.tells_teeth_apart(),
            },
            coordinate_factors: [1.0, by_distance, if_on(effects.misalignment, sign), 1.0],
            gradient_factors: [1.0, by_distance, if_on(effects.shuttling, sign), 1.0],
            finds_secondary: match source {
                Source::Teeth(..) => effects.friction,
                Source::Contact(_) => effects.friction || effects.root_stress,
                _ => false,
            },
            axial_factor: sign,
            bodies: None,
            source,
        }
    }

    /// The same with the bodies `turning` in series, which know their angle by the teeth in mesh.
    #[must_use]
    pub(crate) fn on_bodies(mut self, turning: TurningBodies) -> Self {
        let [_, _, misalignment, _] = self.coordinate_factors;
        self.tells_teeth_apart = true;
        self.bodies = Some(Bodies {
            turning: Arc::new(turning),
            factors: [misalignment, misalignment.abs()],
        });
        self
    }

    /// `flank` of the pair's table, with the effects that it was made for.
    pub(crate) fn on_table(table: &Arc<Table>, flank: Flank) -> Self {
        let (source, mirrored) = match table.teeth(flank) {
            Some((teeth, mirrored)) => {
                let teeth = Box::new(teeth.clone());
                (Source::Teeth(table.clone(), teeth), mirrored)
            }
            None => (Source::Table(table.clone(), flank), table.flank(flank).1),
        };
        Self::new(source, mirrored, table.effects)
    }

    /// The table that it is on.
    #[inline(always)]
    pub(crate) fn table(&self) -> Option<&Arc<Table>> {
        match &self.source {
            Source::Table(table, _) | Source::Teeth(table, _) => Some(table),
            _ => None,
        }
    }

    /// `flank` of `file`, or the drive flank mirrored where that is all it holds.
    pub(crate) fn contact(file: &ContactFile, flank: Flank, effects: Effects) -> Self {
        let own = file.flank(flank);
        let mirrored = own.is_none();
        let drive = || file.flank(Flank::Drive).expect("every file has it");
        let mut contact = own.unwrap_or_else(drive);
        if effects.friction {
            contact = contact.with_friction();
        }
        if effects.root_stress {
            contact = contact.with_root_stress();
        }
        Self::new(Source::Contact(Arc::new(contact)), mirrored, effects)
    }

    /// Potential at the coordinates (delta, C - C_nominal, M, PMC) with the mesh cycles that
    /// passed on either gear. The derivatives of the stiffness are NaN unless `stiffness_slopes` asks for them: they cost
    /// two evaluations. `secondary` results are written under load alone, and not where they stand in a table or are off.
    /// Errors: the law has no potential there.
    #[inline(always)]
    pub(crate) fn respond<T: Scalar>(
        &self,
        coordinates: [T; COORDINATES],
        counts: Counts,
        stiffness_slopes: bool,
        warm: &mut Warm,
        secondary: &mut Option<Secondary<T>>,
    ) -> Result<Response<T>, ElementError> {
        let mut q = coordinates;
        for (q, factor) in q.iter_mut().zip(self.coordinate_factors) {
            *q = *q * factor;
        }
        let at = [q[0].re(), q[1].re(), q[2].re(), q[3].re()];
        let w = match self.finds_secondary {
            true => self.potential_and_secondary(at, &q, counts, warm, secondary)?,
            false => self.potential(at, counts, T::CARRIES, warm, &mut None)?,
        };
        let mut gradient = q;
        for (i, g) in gradient.iter_mut().enumerate() {
            *g = lift(w.gradient[i], &w.hessian[i], &q) * self.gradient_factors[i];
        }
        let slopes = if !T::CARRIES || w.gradient[0] <= 0.0 {
            [0.0; COORDINATES]
        } else if stiffness_slopes {
            self.stiffness_gradient(at, counts, warm)?
        } else {
            [f64::NAN; COORDINATES]
        };
        Ok(Response {
            energy: lift(w.value, &w.gradient, &q),
            gradient,
            stiffness: lift(w.hessian[0][0], &slopes, &q),
            out_of_range: w.out_of_range,
        })
    }

    /// Whether it follows the centre distance and the misalignment.
    pub(crate) fn follows(&self) -> [bool; 2] {
        [1, 2].map(|i| self.coordinate_factors[i] != 0.0)
    }

    /// The potential at the coordinates `at`, and the secondary results under load. Where `q`, the same coordinates as numbers, carries
    /// derivatives, results get slopes, too: those that their source does not know by central differences.
    #[inline(never)]
    fn potential_and_secondary<T: Scalar>(
        &self,
        at: [f64; COORDINATES],
        q: &[T; COORDINATES],
        counts: Counts,
        warm: &mut Warm,
        secondary: &mut Option<Secondary<T>>,
    ) -> Result<Potential, ElementError> {
        let mut found = None;
        let w = self.potential(at, counts, T::CARRIES, warm, &mut found)?;
        let Some(found) = found.filter(|_| w.gradient[0] > 0.0) else {
            return Ok(w);
        };
        // By quantity and coordinate.
        let mut slopes = [[0.0; COORDINATES]; SECONDARY];
        for axis in (0..COORDINATES).filter(|_| T::CARRIES) {
            let by_axis = match found.slopes[axis] {
                Some(slopes) => slopes,
                None => central_difference(at, axis, STEP[axis], |x| {
                    let mut there = None;
                    self.potential(x, counts, false, warm, &mut there)?;
                    let there = there.map(|there: Found| there.secondary);
                    Ok::<_, ElementError>(there.unwrap_or_default().to_array())
                })?,
            };
            for (slopes, slope) in slopes.iter_mut().zip(by_axis) {
                slopes[axis] = slope;
            }
        }
        let values = found.secondary.to_array();
        let lifted = std::array::from_fn(|i| lift(values[i], &slopes[i], q));
        let secondary = secondary.insert(Secondary::from_array(lifted));
        secondary.sliding[1] = secondary.sliding[1] * self.axial_factor;
        Ok(w)
    }

    #[inline]
    pub(super) fn potential(
        &self,
        at: [f64; COORDINATES],
        counts: Counts,
        want_hessian: bool,
        warm: &mut Warm,
        found: &mut Option<Found>,
    ) -> Result<Potential, ElementError> {
        let Some(bodies) = &self.bodies else {
            return self.of_source(at, counts, want_hessian, warm, found);
        };
        // Contact at run time has the second derivatives that a balance takes without more ado.
        let want_hessian = want_hessian || !matches!(self.source, Source::Contact(_));
        let balanced = bodies.in_series(at, counts, |at| {
            self.of_source(at, counts, want_hessian, warm, found)
        })?;
        if let Some(found) = found {
            // Known where the mean body stands, not by the coordinates.
            found.slopes = [None; COORDINATES];
        }
        Ok(balanced)
    }

    /// [`Law::potential`] of the mean body.
    #[inline(always)]
    fn of_source(
        &self,
        at: [f64; COORDINATES],
        counts: Counts,
        want_hessian: bool,
        warm: &mut Warm,
        found: &mut Option<Found>,
    ) -> Result<Potential, ElementError> {
        let query = Query::from(at);
        Ok(match &self.source {
            Source::Linear(stiffness) => {
                let (mut w, delta) = (Potential::default(), query.delta);
                if delta > 0.0 {
                    w.gradient[0] = stiffness * delta;
                    w.value = 0.5 * w.gradient[0] * delta;
                    w.hessian[0][0] = *stiffness;
                }
                w
            }
            Source::Table(table, flank) => table.flank(*flank).0.evaluate(&query, want_hessian),
            Source::Teeth(_, teeth) => {
                let (potential, sliding) = teeth.evaluate_sliding(&query, counts, want_hessian);
                if self.finds_secondary {
                    *found = Some(Found {
                        secondary: secondary(sliding, [0.0; 2]),
                        slopes: [None; COORDINATES],
                    });
                }
                potential
            }
            Source::Contact(contact) => {
                let solved = solved_potential(contact, at, counts, want_hessian, warm, found);
                solved.map_err(|error| {
                    let reason = format!("stiffnessModel = contact finds no loads: {error}");
                    ElementError::Law(reason)
                })?
            }
            Source::Custom(law) => law
                .evaluate(&query, counts, want_hessian)
                .map_err(ElementError::Law)?,
        })
    }

    /// Gradient of the tangent stiffness by central differences: of second derivatives over the approach, but of a contact
    /// solve, whose second derivatives are differences themselves, of the stiffness over each coordinate.
    fn stiffness_gradient(
        &self,
        at: [f64; COORDINATES],
        counts: Counts,
        warm: &mut Warm,
    ) -> Result<[f64; COORDINATES], ElementError> {
        let is_contact = matches!(self.source, Source::Contact(_));
        let mut slopes = |axis: usize| {
            central_difference(at, axis, STEP[axis], |x| {
                let there = self.potential(x, counts, !is_contact, warm, &mut None)?;
                Ok::<_, ElementError>(there.hessian[0])
            })
        };
        let mut gradient = slopes(0)?;
        if is_contact {
            for (axis, slope) in gradient.iter_mut().enumerate().skip(1) {
                *slope = slopes(axis)?[0];
            }
        }
        Ok(gradient)
    }
}

/// Steps of central differences by approach, centre distance, misalignment and mesh position.
const STEP: [f64; COORDINATES] = [1e-9, 1e-7, 1e-7, 1e-5];

/// Slopes of the numbers `f` by the coordinate `axis`.
fn central_difference<const K: usize, E>(
    at: [f64; COORDINATES],
    axis: usize,
    step: f64,
    mut f: impl FnMut([f64; COORDINATES]) -> Result<[f64; K], E>,
) -> Result<[f64; K], E> {
    let mut side = |step: f64| {
        let mut x = at;
        x[axis] += step;
        f(x)
    };
    let (up, down) = (side(step)?, side(-step)?);
    Ok(std::array::from_fn(|i| (up[i] - down[i]) / (2.0 * step)))
}

/// The potential of a static contact solve at the coordinates `at`, and what it finds beside.
/// Errors: no solve succeeds.
fn solved_potential(
    contact: &RuntimeContact,
    at: [f64; COORDINATES],
    counts: Counts,
    want_hessian: bool,
    warm: &mut Warm,
    found: &mut Option<Found>,
) -> Result<Potential, ContactError> {
    /// Of the central differences of the slopes by centre distance, m, and by mesh position.
    const STEPS: [(usize, f64); 2] = [(1, 1e-7), (3, 1e-4)];
    let here = contact.potential(at, counts, warm)?;
    let mut out = Potential {
        value: here.energy,
        gradient: here.gradient,
        out_of_range: here.out_of_range,
        ..Potential::default()
    };
    let hessian = &mut out.hessian;
    hessian[0][0] = here.tangent.force_by_approach;
    hessian[0][2] = here.tangent.force_by_misalignment;
    hessian[2][0] = here.tangent.force_by_misalignment;
    hessian[2][2] = here.tangent.moment_by_misalignment;
    let found = found.insert(Found {
        secondary: secondary(here.sliding, here.root_stress),
        slopes: [None; COORDINATES],
    });
    if !want_hessian || here.gradient[0] == 0.0 {
        return Ok(out);
    }
    for (axis, step) in STEPS {
        let [a, b, c, d, slopes @ ..] = central_difference(at, axis, step, |x| {
            let w = contact.potential(x, counts, warm)?;
            let [a, b, c, d] = w.gradient;
            let [e, f, g, h, i, j] = secondary(w.sliding, w.root_stress).to_array();
            Ok::<_, ContactError>([a, b, c, d, e, f, g, h, i, j])
        })?;
        found.slopes[axis] = Some(slopes);
        for (i, slope) in [a, b, c, d].into_iter().enumerate() {
            // Both mixed slopes of both axes are found: the last one counts for either.
            out.hessian[i][axis] = slope;
            out.hessian[axis][i] = slope;
        }
    }
    Ok(out)
}

fn secondary(sliding: Sliding, root_stress: [f64; 2]) -> Secondary<f64> {
    Secondary {
        sliding: sliding.to_array(),
        root_stress,
    }
}
