//! How the load slides over the operating range: what friction needs, beside the tables of force.
//!
//! The quantities of [`Sliding`] are ratios to the load and change slowly with it, so that they have nodes of
//! their own: load, centre distance, misalignment, mesh position. One cubic spline serves every interpolation of
//! the force, for the force itself is a coordinate here.

mod interpolant;
#[cfg(feature = "preprocess")]
mod sweep;

pub use interpolant::{SlidingJet, SlidingTable};
#[cfg(feature = "preprocess")]
pub use sweep::{default_sliding_axes, sweep_sliding};

use super::TableError;
use super::check::{check_axis, check_mesh_position, check_values, too_few};
use crate::friction::{FrictionLaw, Sliding};
use serde::{Deserialize, Serialize};

/// Sliding of both flanks, as the tables file holds it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FrictionRecord {
    /// Law of the coefficient, whose weights are in the samples.
    pub law: FrictionLaw,
    /// Nodes.
    pub axes: SlidingAxes,
    /// Drive flank.
    pub drive: SlidingSamples,
    /// Coast flank, if it is not the drive flank's mirror image.
    pub coast: Option<SlidingSamples>,
}

/// Nodes; an axis with one value is not there.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SlidingAxes {
    /// Actual minus nominal centre distance.
    pub center_distance_offset_m: Vec<f64>,
    /// In the plane of action.
    pub misalignment_rad: Vec<f64>,
    /// Transverse force on the line of action, > 0.
    pub loa_force_n: Vec<f64>,
    /// In base pitches, periodic.
    pub mesh_position: Vec<f64>,
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

impl SlidingAxes {
    /// Lengths in the order of the samples.
    pub fn lengths(&self) -> [usize; 4] {
        [
            self.center_distance_offset_m.len(),
            self.misalignment_rad.len(),
            self.loa_force_n.len(),
            self.mesh_position.len(),
        ]
    }
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

    fn check(&self, flank: &str, length: usize) -> Result<(), TableError> {
        let named = |name: &str| format!("friction.{flank}.{name}");
        check_values(&named("share"), &self.share, length)?;
        check_values(&named("share_z_m"), &self.share_z_m, length)?;
        check_values(&named("distance_m"), &self.distance_m, length)?;
        match &self.weight {
            Some(weight) => check_values(&named("weight"), weight, length),
            None => Ok(()),
        }
    }
}

impl FrictionRecord {
    /// Checks lengths, order and finiteness.
    ///
    /// # Errors
    /// The first defect, by field.
    pub fn check(&self) -> Result<(), TableError> {
        let axes = &self.axes;
        for (name, nodes) in [
            ("center_distance_offset_m", &axes.center_distance_offset_m),
            ("misalignment_rad", &axes.misalignment_rad),
            ("loa_force_n", &axes.loa_force_n),
            ("mesh_position", &axes.mesh_position),
        ] {
            check_axis(name, nodes)?;
        }
        check_mesh_position(&axes.mesh_position)?;
        let forces = &axes.loa_force_n;
        if forces.len() < 4 {
            return Err(too_few("loa_force_n", forces.len()));
        }
        if forces[0] <= 0.0 {
            return Err(TableError::field(
                "friction.axes.loa_force_n[0]",
                forces[0],
                "nothing slides without a load",
                "make the tables again",
            ));
        }
        let length = axes.lengths().iter().product();
        self.drive.check("drive", length)?;
        match &self.coast {
            Some(coast) => coast.check("coast", length),
            None => Ok(()),
        }
    }
}
