//! Stability: energy, nonlinear motion with known answers, co-simulation, continuity.

pub mod continuity;
pub mod cosimulation;
pub mod energy;
pub mod experiment;
pub mod masters;
pub mod oscillator;
pub mod rattle;

use crate::Result;
use crate::setup::{Setup, shipped, shipped_at};
use gearmesh::element::{
    Element, Formulation, Inputs, Interpolation, LoadedFlank, Parameters, StiffnessModel,
};
use gearmesh::gear::PairGeometry;
use gearmesh::table::{Table, TableFile};
use gearmesh_preprocessor::gear::Refinement;
use nalgebra::{Matrix3, Rotation3, Vector3};
use std::sync::Arc;

/// Backlash of the elements on real tables, m.
const BACKLASH: f64 = 80e-6;

/// A pair with its table over all four dimensions.
pub struct Real {
    pub name: &'static str,
    pub geometry: PairGeometry,
    pub table: Arc<Table>,
}

impl Real {
    /// An external pair on its shipped table, and an internal one.
    pub fn pairs() -> Result<[Self; 2]> {
        let text = include_str!("../../../resources/tables/palermo2013.json");
        let table = Table::from_file(TableFile::from_json(text)?)?;
        let name = "palermo2013";
        let external = Self {
            name,
            geometry: shipped(name)?.geometry,
            table: Arc::new(table),
        };
        Ok([external, Self::coarse("planet-ring-27-84")?])
    }

    /// The shipped pair `name` with a table made here, on coarse finite elements and a grid that takes seconds.
    pub fn coarse(name: &'static str) -> Result<Self> {
        let setup = Setup::new(shipped_at(name, Refinement::Coarse)?, None)?;
        let table = setup.table(&setup.samples([8, 5, 9, 12])?)?;
        Ok(Self {
            name,
            geometry: setup.pair.geometry,
            table,
        })
    }

    /// The element with all effects on, undamped.
    pub fn element(
        &self,
        formulation: Formulation,
        interpolation: Interpolation,
        flank: LoadedFlank,
    ) -> Result<Element> {
        let parameters = Parameters {
            stiffness_model: StiffnessModel::Table,
            formulation,
            interpolation,
            backlash: Some(BACKLASH),
            ..undamped(flank)
        };
        Ok(Element::new(
            &self.geometry,
            &parameters,
            Some(self.table.clone()),
        )?)
    }

    /// Its backlash on the line of action, m.
    fn gap(&self) -> f64 {
        BACKLASH
            * self
                .geometry
                .operating_pressure_angle(self.geometry.center_distance)
                .cos()
    }
}

/// No damping, else the defaults.
fn undamped(loaded_flank: LoadedFlank) -> Parameters {
    Parameters {
        loaded_flank,
        damping: 0.0,
        ..Parameters::default()
    }
}

/// Rotation by `angle` about z.
fn spin(angle: f64) -> Matrix3<f64> {
    Rotation3::from_axis_angle(&Vector3::z_axis(), angle).into_inner()
}

/// Gear 1 turned by `angle`, gear 2 moved by `shift`.
fn pose(element: &Element, angle: f64, shift: Vector3<f64>) -> Inputs {
    let mut inputs = element.nominal_inputs();
    inputs.gears[0].r = spin(angle);
    inputs.gears[1].p += shift;
    inputs
}
