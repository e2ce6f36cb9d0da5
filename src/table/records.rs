//! What the tables file holds over the load besides the force: how the load slides, for friction, and stress in the tooth roots.
//!
//! Samples stand on nodes of their own ([`LoadAxes`]), over (centre distance, misalignment, force, mesh position), the last index
//! fastest. Those of [`Sliding`] are ratios to the load. Root stress is the largest over face, fillet and teeth: where another
//! tooth or end of the face takes the lead it has a kink, which the spline rounds off. It is the stress that is smooth over the load,
//! not its ratio to it: edges and misalignment gather small loads.

use super::TableError;
use super::axes::{check_axes, check_axis, check_values};
use super::block::rounded;
use super::error::refused;
use crate::accuracy::RootStressError;
use crate::friction::{FrictionLaw, Sliding};
use serde::{Deserialize, Serialize};

/// Nodes; an axis with one value is not there.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LoadAxes {
    /// Actual minus nominal centre distance.
    pub center_distance_offset_m: Vec<f64>,
    /// In the plane of action.
    pub misalignment_rad: Vec<f64>,
    /// Transverse force on the line of action. From 0 on: of effects of the load, which go on linearly beyond the largest one.
    /// From above 0 on: of ratios to it, which level out there.
    pub loa_force_n: Vec<f64>,
    /// In base pitches, periodic.
    pub mesh_position: Vec<f64>,
}

impl LoadAxes {
    /// Nodes in the order of the samples: (centre distance, misalignment, force, mesh position), the last index fastest.
    pub fn nodes(&self) -> [&[f64]; 4] {
        [
            &self.center_distance_offset_m,
            &self.misalignment_rad,
            &self.loa_force_n,
            &self.mesh_position,
        ]
    }

    /// Number of nodes along each axis, in that order.
    pub fn lengths(&self) -> [usize; 4] {
        self.nodes().map(<[f64]>::len)
    }

    /// Checks the `record` with these axes: lengths, order and finiteness of nodes and samples, and the load at which they begin.
    pub(super) fn check(
        &self,
        record: &str,
        from_zero: bool,
        drive: Columns<'_>,
        coast: Option<Columns<'_>>,
    ) -> Result<(), TableError> {
        let path = format!("{record}.axes");
        check_axes(&path, self.nodes())?;
        let (name, forces) = (format!("{path}.loa_force_n"), &self.loa_force_n);
        check_axis(&name, forces, false)?;
        if forces[0] < 0.0 || (forces[0] == 0.0) != from_zero {
            let reason = match from_zero {
                true => "effects of the load begin at 0; make the tables again",
                false => "ratios to the load need a load; make the tables again",
            };
            return refused(format!("{name}[0]"), forces[0], reason);
        }
        let length = self.lengths().iter().product();
        for (flank, columns) in [("drive", Some(drive)), ("coast", coast)] {
            for (name, values) in columns.into_iter().flatten() {
                check_values(&format!("{record}.{flank}.{name}"), values, length)?;
            }
        }
        Ok(())
    }
}

/// Name and samples of each quantity on one flank, in the order in which a [`super::LoadSpline`] gives them.
pub type Columns<'a> = Vec<(&'static str, &'a [f64])>;

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

impl SlidingSamples {
    /// From `all` samples in order, rounded to what interpolation can tell; `local`: with their weights.
    pub fn new(all: &[Sliding], local: bool) -> SlidingSamples {
        let column =
            |part: fn(&Sliding) -> f64| rounded(&all.iter().map(part).collect::<Vec<_>>(), 1e-6);
        SlidingSamples {
            share: column(|s| s.share),
            share_z_m: column(|s| s.share_z),
            distance_m: column(|s| s.distance),
            weight: local.then(|| column(|s| s.weight)),
        }
    }

    /// Name and samples of each quantity.
    pub fn columns(&self) -> Columns<'_> {
        let mut columns: Columns<'_> = vec![
            ("share", &self.share),
            ("share_z_m", &self.share_z_m),
            ("distance_m", &self.distance_m),
        ];
        columns.extend(self.weight.iter().map(|weight| ("weight", &weight[..])));
        columns
    }
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

impl RootStressSamples {
    /// From `all` samples in order, of gear 1 and gear 2, rounded to what interpolation can tell.
    pub fn new(all: &[[f64; 2]]) -> RootStressSamples {
        let gear = |k: usize| rounded(&all.iter().map(|both| both[k]).collect::<Vec<_>>(), 1e-6);
        RootStressSamples {
            gear_1_pa: gear(0),
            gear_2_pa: gear(1),
        }
    }

    /// Name and samples of each quantity.
    pub fn columns(&self) -> Columns<'_> {
        vec![
            ("gear_1_pa", &self.gear_1_pa),
            ("gear_2_pa", &self.gear_2_pa),
        ]
    }
}
