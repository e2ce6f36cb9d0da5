//! Poses that the hard cases and the scans share, and the elements they are tried on.

use crate::tables;
use gearmesh::element::{
    Element, Formulation, Inputs, Interpolation, LoadedFlank, Parameters, StiffnessModel,
};
use gearmesh::gear::PairGeometry;
use gearmesh::table::Table;
use nalgebra::{Rotation3, Vector3};
use std::sync::Arc;

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// Backlash of the elements on real tables, m.
pub const BACKLASH: f64 = 80e-6;

/// A pair with the table of its drawing.
pub struct Real {
    /// For the report.
    pub name: &'static str,
    /// The pair.
    pub geometry: PairGeometry,
    /// Its table over all four dimensions.
    pub table: Arc<Table>,
}

impl Real {
    /// An external and an internal pair.
    pub fn pairs() -> Result<[Self; 2]> {
        let (external, shipped) = tables::shipped_palermo()?;
        let (internal, made) = tables::planet_and_ring()?;
        Ok([
            Self {
                name: "palermo2013",
                geometry: external.geometry,
                table: shipped,
            },
            Self {
                name: "planet-ring-27-84",
                geometry: internal.geometry,
                table: made,
            },
        ])
    }

    /// The element with all effects on, undamped.
    pub fn element(
        &self,
        formulation: Formulation,
        interpolation: Interpolation,
        loaded_flank: LoadedFlank,
    ) -> Result<Element> {
        let parameters = Parameters {
            stiffness_model: StiffnessModel::Table,
            formulation,
            interpolation,
            backlash: Some(BACKLASH),
            ..undamped(loaded_flank)
        };
        let table = Some(self.table.clone());
        Ok(Element::new(&self.geometry, &parameters, table)?)
    }
}

/// No damping, else the defaults.
pub fn undamped(loaded_flank: LoadedFlank) -> Parameters {
    Parameters {
        loaded_flank,
        damping: 0.0,
        ..Parameters::default()
    }
}

/// Rotation by `angle` about z.
pub fn spin(angle: f64) -> nalgebra::Matrix3<f64> {
    Rotation3::from_axis_angle(&Vector3::z_axis(), angle).into_inner()
}

/// Gear 1 turned by `angle`, gear 2 moved by `shift`.
pub fn pose(element: &Element, angle: f64, shift: Vector3<f64>) -> Inputs {
    let mut inputs = element.nominal_inputs();
    inputs.gears[0].r = spin(angle);
    inputs.gears[1].p += shift;
    inputs
}

/// Angle of gear 2 over that of gear 1 in mesh.
pub fn ratio(pair: &PairGeometry) -> f64 {
    -pair.e() * pair.gears[0].z() / pair.gears[1].z()
}
