//! Stress in the tooth roots over the operating range, beside the tables of force.
//!
//! Samples have nodes of their own ([`LoadAxes`]) from no load on. Each is the largest stress over face, fillet and teeth:
//! where another tooth or end of the face takes the lead it has a kink, which the spline rounds off. It is the stress that
//! is smooth over the load, not its ratio to it: edges and misalignment gather small loads.

use super::load_spline::Columns;
use super::{LoadAxes, LoadSpline, PerLoad, TableError};
use serde::{Deserialize, Serialize};

/// Root stress of both flanks, as the tables file holds it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RootStressRecord {
    /// Nodes.
    pub axes: LoadAxes,
    /// Under load on the drive flank.
    pub drive: RootStressSamples,
    /// Under load on the coast flank, if it is not the drive flank's mirror image.
    pub coast: Option<RootStressSamples>,
    /// Error of the interpolation against the solver.
    pub interpolation_error: RootStressError,
}

/// Samples of one flank over (centre distance, misalignment, force, mesh position), the last index fastest: the
/// largest principal stress in the fillets of a gear, 0 without force.
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

impl RootStressSamples {
    /// Of gear 1 and gear 2, rounded to what interpolation can tell.
    pub fn new(all: [&[f64]; 2]) -> RootStressSamples {
        let [gear_1_pa, gear_2_pa] = all.map(|of| super::file::rounded(of, 1e-6));
        RootStressSamples {
            gear_1_pa,
            gear_2_pa,
        }
    }

    fn columns(&self) -> Columns<'_> {
        vec![
            ("gear_1_pa", &self.gear_1_pa),
            ("gear_2_pa", &self.gear_2_pa),
        ]
    }
}

impl RootStressRecord {
    /// Checks lengths, order and finiteness.
    ///
    /// # Errors
    /// The first defect, by field.
    pub fn check(&self) -> Result<(), TableError> {
        let coast = self.coast.as_ref().map(RootStressSamples::columns);
        let flanks = [Some(self.drive.columns()), coast];
        self.axes
            .check_record("root_stress", PerLoad::Effect, flanks)
    }
}

impl RootStressSamples {
    /// Spline of the stress in the roots of gear 1 and gear 2, Pa, as [`LoadSpline::new`].
    ///
    /// # Errors
    /// As there.
    pub fn spline(&self, axes: &LoadAxes, effects: [bool; 2]) -> Result<LoadSpline, TableError> {
        let gears = [&self.gear_1_pa[..], &self.gear_2_pa];
        LoadSpline::new(axes, &gears, PerLoad::Effect, effects)
    }
}
