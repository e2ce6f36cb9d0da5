//! Elastic law of one flank: from the four mesh coordinates to the derivatives of the potential.

use super::error::ElementError;
use super::scalar::{Scalar, lift};
use crate::gear::Flank;
use crate::gear::teeth::Counts;
use crate::table::{
    COORDINATES, Effects, FlankTable, Potential, Query, Table, TableError, TeethFlank,
};
use std::sync::Arc;

/// Anything that gives the potential W(delta, C, M, PMC) of a loaded flank: the interpolated table,
/// or a closed form in tests and experiments.
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

/// The elastic laws of the drive flank and the coast flank.
#[derive(Clone)]
pub struct FlankLaws {
    /// Drive flank.
    pub drive: Arc<dyn Elasticity>,
    /// Coast flank; `None`: that of the drive flank, mirrored (M -> -M, z_c - z_ref -> -(z_c - z_ref)),
    /// which is exact where the microgeometry is mirror-symmetric.
    pub coast: Option<Arc<dyn Elasticity>>,
}

impl Elasticity for FlankTable {
    #[inline]
    fn evaluate(&self, query: &Query, _: Counts, want_hessian: bool) -> Result<Potential, String> {
        Ok(FlankTable::evaluate(self, query, want_hessian))
    }
}

/// One flank of a pair's table.
struct TableFlank {
    table: Arc<Table>,
    flank: Flank,
}

impl Elasticity for TableFlank {
    #[inline]
    fn evaluate(&self, query: &Query, _: Counts, want_hessian: bool) -> Result<Potential, String> {
        Ok(self.table.flank(self.flank).0.evaluate(query, want_hessian))
    }
}

/// Tooth pairs of one flank of a pair's table.
struct TableTeeth {
    table: Arc<Table>,
    flank: Flank,
}

impl TableTeeth {
    #[inline]
    fn teeth(&self) -> Option<&TeethFlank> {
        Some(self.table.teeth(self.flank)?.0)
    }
}

impl Elasticity for TableTeeth {
    fn evaluate(
        &self,
        query: &Query,
        counts: Counts,
        want_hessian: bool,
    ) -> Result<Potential, String> {
        Ok(self.teeth().map_or(Potential::default(), |teeth| {
            teeth.evaluate(query, counts, want_hessian)
        }))
    }

    fn tells_teeth_apart(&self) -> bool {
        self.teeth().is_some_and(TeethFlank::tells_teeth_apart)
    }
}

/// Linear spring on the line of action.
struct Linear {
    /// N/m on the line of action.
    stiffness: f64,
}

impl Elasticity for Linear {
    fn evaluate(&self, query: &Query, _: Counts, _: bool) -> Result<Potential, String> {
        let mut w = Potential::default();
        if query.delta > 0.0 {
            w.gradient[0] = self.stiffness * query.delta;
            w.value = 0.5 * w.gradient[0] * query.delta;
            w.hessian[0][0] = self.stiffness;
        }
        Ok(w)
    }
}

/// Law of one flank as the formulations use it.
#[derive(Clone)]
pub(crate) struct Law {
    surface: Arc<dyn Elasticity>,
    mirrored: bool,
    tells_teeth_apart: bool,
    effects: Effects,
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
    /// Linear spring of `stiffness` N/m on the line of action.
    pub(crate) fn linear(stiffness: f64, effects: Effects) -> Self {
        Self::new(Arc::new(Linear { stiffness }), false, effects)
    }

    /// `flank` of the pair's table, with the effects that it was made for.
    pub(crate) fn of_table(table: &Arc<Table>, flank: Flank) -> Self {
        let (mirrored, effects) = (table.flank(flank).1, *table.effects());
        let table = table.clone();
        Self::new(Arc::new(TableFlank { table, flank }), mirrored, effects)
    }

    /// `flank` of the pair's table, tooth pair by tooth pair.
    ///
    /// # Errors
    /// The table was not asked for them.
    pub(crate) fn of_teeth(table: &Arc<Table>, flank: Flank) -> Result<Self, TableError> {
        let (_, mirrored) = table.teeth(flank).ok_or(TableError::MissingTeeth)?;
        let (table, effects) = (table.clone(), *table.effects());
        Ok(Self::new(
            Arc::new(TableTeeth { table, flank }),
            mirrored,
            effects,
        ))
    }

    /// Any law; `mirrored` for the coast flank of a pair whose table holds the drive flank alone.
    pub(crate) fn new(surface: Arc<dyn Elasticity>, mirrored: bool, effects: Effects) -> Self {
        Self {
            tells_teeth_apart: surface.tells_teeth_apart(),
            surface,
            mirrored,
            effects,
        }
    }

    /// Potential at the coordinates (delta, C - C_nominal, M, PMC), effects that are off left out, with the mesh cycles that
    /// passed on either gear. The derivatives of the stiffness are not numbers unless `stiffness_slopes` asks for them: under a
    /// law that does not know them they cost eight evaluations.
    ///
    /// # Errors
    /// The law has no potential there.
    #[inline]
    pub(crate) fn respond<T: Scalar>(
        &self,
        coordinates: [T; COORDINATES],
        counts: Counts,
        stiffness_slopes: bool,
    ) -> Result<Response<T>, ElementError> {
        let mut q = coordinates;
        if !self.effects.center_distance {
            q[1] = T::from(0.0);
        }
        if !self.effects.misalignment {
            q[2] = T::from(0.0);
        }
        if self.mirrored {
            q[2] = -q[2];
        }
        let at = [q[0].re(), q[1].re(), q[2].re(), q[3].re()];
        let w = self.ask(at, counts, T::CARRIES)?;
        let mut gradient = [T::from(0.0); COORDINATES];
        for (i, g) in gradient.iter_mut().enumerate() {
            *g = lift(w.gradient[i], &w.hessian[i], &q);
        }
        if self.mirrored {
            gradient[2] = -gradient[2];
        }
        if !self.effects.center_distance {
            gradient[1] = T::from(0.0);
        }
        if !self.effects.shuttling {
            gradient[2] = T::from(0.0);
        }
        let stiffness = if T::CARRIES && w.gradient[0] > 0.0 {
            let slopes = match w.stiffness_gradient {
                Some(slopes) => slopes,
                None if stiffness_slopes => self.stiffness_gradient(at, counts)?,
                None => [f64::NAN; COORDINATES],
            };
            lift(w.hessian[0][0], &slopes, &q)
        } else {
            T::from(w.hessian[0][0])
        };
        Ok(Response {
            energy: lift(w.value, &w.gradient, &q),
            gradient,
            stiffness,
            out_of_range: w.out_of_range,
        })
    }

    /// Whether it follows the centre distance and the misalignment.
    pub(crate) fn follows(&self) -> [bool; 2] {
        [self.effects.center_distance, self.effects.misalignment]
    }

    /// Whether it is to be told which teeth are in mesh.
    #[inline]
    pub(crate) fn tells_teeth_apart(&self) -> bool {
        self.tells_teeth_apart
    }

    #[inline]
    fn ask(
        &self,
        at: [f64; COORDINATES],
        counts: Counts,
        want_hessian: bool,
    ) -> Result<Potential, ElementError> {
        let w = self.surface.evaluate(&query(at), counts, want_hessian);
        w.map_err(ElementError::NoPotential)
    }

    /// Gradient of the tangent stiffness by central differences, for laws that do not know it. Only the
    /// derivative of the output `mesh.stiffness` uses it.
    fn stiffness_gradient(
        &self,
        at: [f64; COORDINATES],
        counts: Counts,
    ) -> Result<[f64; COORDINATES], ElementError> {
        const STEP: [f64; COORDINATES] = [1e-9, 1e-7, 1e-7, 1e-5];
        let mut slope = [0.0; COORDINATES];
        for (i, slope) in slope.iter_mut().enumerate() {
            let mut side = [0.0; 2];
            for (side, sign) in side.iter_mut().zip([1.0, -1.0]) {
                let mut x = at;
                x[i] += sign * STEP[i];
                *side = self.ask(x, counts, false)?.hessian[0][0];
            }
            *slope = (side[0] - side[1]) / (2.0 * STEP[i]);
        }
        Ok(slope)
    }
}

fn query(x: [f64; COORDINATES]) -> Query {
    Query {
        delta: x[0],
        center_distance_offset: x[1],
        misalignment: x[2],
        mesh_position: x[3],
    }
}
