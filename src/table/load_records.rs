//! What the tables file holds over the load beside the force: how the load slides, for friction, and stress in the tooth roots.
//!
//! Samples stand on nodes of their own ([`LoadAxes`]), over (centre distance, misalignment, force, mesh position), the last index
//! fastest. Those of [`Sliding`] are ratios to the load. Root stress is the largest over face, fillet and teeth: where another
//! tooth or end of the face takes the lead it has a kink, which the spline rounds off. It is the stress that is smooth over the load,
//! not its ratio to it: edges and misalignment gather small loads.

use super::file::rounded;
use super::load_spline::Columns;
use super::{LoadAxes, LoadSpline, PerLoad, TableError};
use crate::friction::{FrictionLaw, Sliding};
use serde::{Deserialize, Serialize};

/// Sliding of both flanks.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FrictionRecord {
    /// Law of the coefficient, whose weights are in the samples.
    pub law: FrictionLaw,
    /// Nodes.
    pub axes: LoadAxes,
    /// Drive flank.
    pub drive: SlidingSamples,
    /// Coast flank, if it is not the drive flank's mirror image.
    pub coast: Option<SlidingSamples>,
}

/// Samples of one flank; see [`Sliding`].
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SlidingSamples {
    /// [`Sliding::share`].
    pub share: Vec<f64>,
    /// [`Sliding::share_z`].
    pub share_z_m: Vec<f64>,
    /// [`Sliding::distance`].
    pub distance_m: Vec<f64>,
    /// [`Sliding::weight`]; null for laws of the whole mesh, where it is 1.
    pub weight: Option<Vec<f64>>,
}

/// Root stress under load on both flanks.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RootStressRecord {
    /// Nodes, from no load on.
    pub axes: LoadAxes,
    /// Drive flank.
    pub drive: RootStressSamples,
    /// Coast flank, if it is not the drive flank's mirror image.
    pub coast: Option<RootStressSamples>,
    /// Error of the interpolation against the solver.
    pub interpolation_error: RootStressError,
}

/// Samples of one flank: the largest principal stress in the fillets of a gear, 0 without force.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RootStressSamples {
    /// Of gear 1.
    pub gear_1_pa: Vec<f64>,
    /// Of gear 2.
    pub gear_2_pa: Vec<f64>,
}

/// Error at operating points that are no nodes, relative to the largest stress of the gear over the mesh cycle at
/// nominal torque, nominal centre distance and parallel axes; of both gears and flanks the larger one.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RootStressError {
    /// Number of random operating points.
    pub points: usize,
    /// Root of the mean square.
    pub rms: f64,
    /// Largest.
    pub maximum: f64,
}

impl RootStressError {
    /// Both flanks together.
    #[must_use]
    pub fn with(self, other: RootStressError) -> RootStressError {
        RootStressError {
            points: self.points + other.points,
            rms: self.rms.max(other.rms),
            maximum: self.maximum.max(other.maximum),
        }
    }
}

impl SlidingSamples {
    /// From `all` samples in order, rounded to what interpolation can tell; `local`: with their weights.
    pub fn new(all: &[Sliding], local: bool) -> SlidingSamples {
        let column = |part: fn(&Sliding) -> f64| {
            let values: Vec<f64> = all.iter().map(part).collect();
            rounded(&values, 1e-6)
        };
        SlidingSamples {
            share: column(|s| s.share),
            share_z_m: column(|s| s.share_z),
            distance_m: column(|s| s.distance),
            weight: local.then(|| column(|s| s.weight)),
        }
    }

    pub(super) fn columns(&self) -> Columns<'_> {
        let mut all: Columns = vec![
            ("share", &self.share),
            ("share_z_m", &self.share_z_m),
            ("distance_m", &self.distance_m),
        ];
        all.extend(self.weight.iter().map(|weight| ("weight", &weight[..])));
        all
    }

    /// Spline of [`Sliding::share`], `share_z`, `distance` and `weight`, as [`LoadSpline::new`].
    ///
    /// # Errors
    /// As there.
    pub fn spline(&self, axes: &LoadAxes, effects: [bool; 2]) -> Result<LoadSpline, TableError> {
        LoadSpline::new(axes, &self.columns(), PerLoad::Ratio, effects)
    }
}

impl RootStressSamples {
    /// Of gear 1 and gear 2, rounded to what interpolation can tell.
    pub fn new(all: [&[f64]; 2]) -> RootStressSamples {
        let [gear_1_pa, gear_2_pa] = all.map(|gear| rounded(gear, 1e-6));
        RootStressSamples {
            gear_1_pa,
            gear_2_pa,
        }
    }

    pub(super) fn columns(&self) -> Columns<'_> {
        vec![
            ("gear_1_pa", &self.gear_1_pa),
            ("gear_2_pa", &self.gear_2_pa),
        ]
    }

    /// Spline of the stress in the roots of gear 1 and gear 2, Pa, as [`LoadSpline::new`].
    ///
    /// # Errors
    /// As there.
    pub fn spline(&self, axes: &LoadAxes, effects: [bool; 2]) -> Result<LoadSpline, TableError> {
        LoadSpline::new(axes, &self.columns(), PerLoad::Effect, effects)
    }
}
