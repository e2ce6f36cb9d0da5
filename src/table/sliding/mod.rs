//! How the load slides over the operating range: what friction needs, beside the tables of force.
//!
//! The quantities of [`Sliding`] are ratios to the load, so that they have nodes of their own ([`LoadAxes`]).

use super::load_spline::Columns;
use super::{LoadAxes, LoadSpline, PerLoad, TableError};
use crate::friction::{FrictionLaw, Sliding};
use serde::{Deserialize, Serialize};

/// Sliding of both flanks, as the tables file holds it.
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

/// Samples of one flank over (centre distance, misalignment, force, mesh position), the last index fastest;
/// see [`Sliding`].
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

impl SlidingSamples {
    /// From `all` samples in order, rounded to what interpolation can tell; `local`: with their weights.
    pub fn new(all: &[Sliding], local: bool) -> SlidingSamples {
        let of = |part: fn(&Sliding) -> f64| {
            let values: Vec<f64> = all.iter().map(part).collect();
            super::file::rounded(&values, 1e-6)
        };
        SlidingSamples {
            share: of(|s| s.share),
            share_z_m: of(|s| s.share_z),
            distance_m: of(|s| s.distance),
            weight: local.then(|| of(|s| s.weight)),
        }
    }

    fn columns(&self) -> Columns<'_> {
        let mut all: Columns = vec![
            ("share", &self.share),
            ("share_z_m", &self.share_z_m),
            ("distance_m", &self.distance_m),
        ];
        all.extend(self.weight.iter().map(|weight| ("weight", &weight[..])));
        all
    }
}

impl FrictionRecord {
    /// Checks lengths, order and finiteness.
    ///
    /// # Errors
    /// The first defect, by field.
    pub fn check(&self) -> Result<(), TableError> {
        let coast = self.coast.as_ref().map(SlidingSamples::columns);
        let flanks = [Some(self.drive.columns()), coast];
        self.axes.check_record("friction", PerLoad::Ratio, flanks)
    }
}

impl SlidingSamples {
    /// Spline of [`Sliding::share`], `share_z`, `distance` and `weight`, as [`LoadSpline::new`].
    ///
    /// # Errors
    /// As there.
    pub fn spline(&self, axes: &LoadAxes, effects: [bool; 2]) -> Result<LoadSpline, TableError> {
        let all: Vec<&[f64]> = self.columns().into_iter().map(|c| c.1).collect();
        LoadSpline::new(axes, &all, PerLoad::Ratio, effects)
    }
}
