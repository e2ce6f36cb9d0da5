//! What leaving out an effect costs in accuracy, where it matters and where it does not.

use super::{Sampled, at, everything, points};
use crate::data::{Data, mean, rms};
use crate::setup::{Exact, Ranges, Setup};
use crate::{Context, Result, row};
use gearmesh::element::{Parameters, StiffnessModel};
use gearmesh::gear::Flank;
use gearmesh::pair::Refinement;
use gearmesh::table::{Query, Table};
use std::sync::Arc;

/// An effect, how to leave it out, and a scene where it matters and one where it does not.
struct Effect {
    name: &'static str,
    without: Parameters,
    scenes: [(&'static str, Ranges); 2],
}

fn effects(setup: &Setup) -> Vec<Effect> {
    let all = everything(setup);
    let operating = &setup.pair.operating;
    let nominal = operating.nominal_torque;
    let wide = Ranges { torque: [0.1 * nominal, operating.maximum_torque], ..setup.ranges(2) };
    let by_distance =
        |share: f64| Ranges { center_distance_offset: operating.center_distance_offset.map(|x| share * x), ..wide };
    let by_tilt = |share: f64| Ranges { misalignment: operating.misalignment.map(|x| share * x), ..wide };
    let by_load = [
        ("torque from a tenth of the nominal to the maximum", wide),
        ("torque within 1 % of the nominal", Ranges { torque: [0.99 * nominal, 1.01 * nominal], ..wide }),
    ];
    vec![
        Effect {
            name: "centre distance",
            without: Parameters { center_distance_effect: false, ..all },
            scenes: [("shafts that part by ±100 µm", by_distance(1.0)), ("stiff bearings, ±1 µm", by_distance(0.01))],
        },
        Effect {
            name: "misalignment",
            without: Parameters { misalignment_effect: false, ..all },
            scenes: [("shafts that tilt by ±3 mrad", by_tilt(1.0)), ("stiff shafts, ±0.003 mrad", by_tilt(0.001))],
        },
        Effect { name: "load dependence", without: Parameters { load_dependent: false, ..all }, scenes: by_load },
        Effect {
            name: "table at all (constant stiffness instead)",
            without: Parameters { stiffness_model: StiffnessModel::Constant, ..all },
            scenes: by_load,
        },
    ]
}

/// rms error of the force over the nominal one at `points`, with `parameters`, in %.
fn error(setup: &Setup, table: &Arc<Table>, parameters: &Parameters, points: &[Exact]) -> Result<f64> {
    let errors: Vec<f64> = if parameters.stiffness_model == StiffnessModel::Constant {
        // The best constant there is for these points at the nominal torque: nominal force over mean STE.
        let torque = [setup.pair.operating.nominal_torque; 2];
        let at_nominal = setup.exact(&Ranges { torque, ..setup.ranges(2) }, 64)?;
        let ste: Vec<f64> = at_nominal.iter().map(|x| x.query.delta).collect();
        let stiffness = setup.nominal_force() / mean(&ste);
        points.iter().map(|x| stiffness * x.query.delta.max(0.0) - x.force).collect()
    } else {
        let cut = table.sliced(&parameters.table_effects(&setup.pair.geometry))?;
        let (flank, _) = cut.flank(Flank::Drive);
        let [c, m] =
            [parameters.center_distance_effect, parameters.misalignment_effect].map(|on| f64::from(u8::from(on)));
        let query = |x: &Exact| Query {
            center_distance_offset: c * x.query.center_distance_offset,
            misalignment: m * x.query.misalignment,
            ..x.query
        };
        points.iter().map(|x| flank.evaluate(&query(x), false).gradient[0] - x.force).collect()
    };
    Ok(100.0 * rms(errors) / setup.nominal_force())
}

/// rms error of the shuttling moment when it is left out, in % of nominal force times half the face.
fn moment_left_out(setup: &Setup, ranges: &Ranges, points: usize) -> Result<String> {
    let moments = setup.exact(ranges, points)?.into_iter().map(|x| x.moment);
    Ok(format!(" / {:.2}", 100.0 * rms(moments) / (setup.nominal_force() * setup.half_face())))
}

pub fn report(context: &Context, data: &Data) -> Result<()> {
    let Sampled { setup, grid } = Sampled::of(context)?;
    let table = setup.table(grid)?;
    let all = everything(setup);
    let effects = effects(setup);
    let mut rows = vec![];
    for effect in &effects {
        let mut row = row![effect.name];
        for (scene, ranges) in &effect.scenes {
            let exact = setup.exact(ranges, points(context))?;
            let [with, without] = [error(setup, &table, &all, &exact)?, error(setup, &table, &effect.without, &exact)?];
            row.extend(row![scene, format!("{with:.2} / {without:.2}")]);
        }
        rows.push(row);
    }
    let tilted = Ranges { misalignment: setup.pair.operating.misalignment, ..setup.ranges(2) };
    let spur = at("fzg-c", Refinement::Coarse)?;
    rows.push(row![
        "shuttling (error of the moment)",
        "shafts that tilt by ±3 mrad",
        moment_left_out(setup, &tilted, points(context))?,
        "spur pair, parallel shafts",
        moment_left_out(&spur, &spur.ranges(2), points(context))?,
    ]);
    let head = ["effect", "scene where it matters", "error, %", "scene where it does not", "error, %"];
    data.table("effects", &head, &rows)
}
