//! The tables as the elastic law of the element.

use std::sync::Arc;

use super::report::Refusal;
use crate::element::{self, Elasticity, FlankLaws, Parameters};
use crate::gear::{Flank, PairGeometry};
use crate::table::{Effects, Interpolation, Load, Potential, Query, Table, TableFile};

/// The tables in `file`, reduced to what `parameters` switch on; one copy for all instances in the
/// process that ask for the same.
///
/// # Errors
/// An effect without its axis, by name; an interpolation that there is none of.
pub fn table(
    file: &TableFile,
    geometry: &PairGeometry,
    parameters: &Parameters,
) -> Result<Arc<Table>, Refusal> {
    let load = if parameters.load_dependent {
        Load::Variable
    } else {
        Load::Constant {
            loa_force: parameters.nominal_torque / geometry.gears[0].base_radius(),
        }
    };
    let effects = Effects {
        interpolation: match parameters.interpolation {
            element::Interpolation::Linear => Interpolation::Linear,
            element::Interpolation::Spline => Interpolation::Spline,
            element::Interpolation::Shepard => {
                return Err(Refusal::error(
                    "interpolation = shepard is not available; choose linear or spline",
                ));
            }
        },
        load,
        center_distance: parameters.center_distance_effect,
        misalignment: parameters.misalignment_effect,
        shuttling: parameters.shuttling_effect,
    };
    Table::shared(file.clone(), &effects).map_err(|error| Refusal::error(error.to_string()))
}

/// The elastic laws of both flanks.
pub fn laws(table: Arc<Table>) -> FlankLaws {
    let (_, mirrored) = table.flank(Flank::Coast);
    let law = |flank| -> Arc<dyn Elasticity> {
        let table = table.clone();
        Arc::new(FlankLaw { table, flank })
    };
    FlankLaws {
        drive: law(Flank::Drive),
        coast: (!mirrored).then(|| law(Flank::Coast)),
    }
}

/// One flank of a table.
struct FlankLaw {
    table: Arc<Table>,
    flank: Flank,
}

impl Elasticity for FlankLaw {
    fn evaluate(&self, query: &Query, want_hessian: bool) -> Potential {
        self.table.flank(self.flank).0.evaluate(query, want_hessian)
    }
}
