//! What leaving out an effect costs in accuracy, where it matters and where it does not.

use super::{Sampled, coarse, everything, points};
use crate::data::{Data, mean, rms};
use crate::setup::{Exact, Ranges, Setup};
use crate::{Context, Result};
use gearmesh::element::{Parameters, StiffnessModel};
use gearmesh::gear::Flank;
use gearmesh::table::{Query, Table};
use std::sync::Arc;

/// An effect, how to leave it out, and a scene where it matters and one where it does not.
struct Effect {
    name: &'static str,
    leave_out: fn(&mut Parameters),
    scenes: [(&'static str, Ranges); 2],
}

fn effects(setup: &Setup) -> [Effect; 4] {
    let operating = &setup.pair.operating;
    let nominal = operating.nominal_torque;
    let mut wide = setup.ranges(2);
    wide.torque[0] = 0.1 * nominal;
    let changed = |change: &dyn Fn(&mut Ranges)| {
        let mut ranges = wide;
        change(&mut ranges);
        ranges
    };
    let distance = operating.center_distance_offset;
    let by_distance = |share| changed(&|r| r.center_distance_offset = distance.map(|x| share * x));
    let by_tilt = |share| changed(&|r| r.misalignment = operating.misalignment.map(|x| share * x));
    let narrow = changed(&|r| r.torque = [0.99 * nominal, 1.01 * nominal]);
    let by_load = [
        ("torque from a tenth of the nominal to the maximum", wide),
        ("torque within 1 % of the nominal", narrow),
    ];
    let distances = [
        ("shafts that part by ±100 µm", by_distance(1.0)),
        ("stiff bearings, ±1 µm", by_distance(0.01)),
    ];
    let tilts = [
        ("shafts that tilt by ±3 mrad", by_tilt(1.0)),
        ("stiff shafts, ±0.003 mrad", by_tilt(0.001)),
    ];
    let effect = |name, leave_out, scenes| Effect {
        name,
        leave_out,
        scenes,
    };
    let constant = "table at all (constant stiffness instead)";
    [
        effect(
            "centre distance",
            |p| p.center_distance_effect = false,
            distances,
        ),
        effect("misalignment", |p| p.misalignment_effect = false, tilts),
        effect("load dependence", |p| p.load_dependent = false, by_load),
        effect(
            constant,
            |p| p.stiffness_model = StiffnessModel::Constant,
            by_load,
        ),
    ]
}

/// rms error of the force over the nominal one at `points`, with `parameters`, in %.
fn error(
    setup: &Setup,
    table: &Arc<Table>,
    parameters: &Parameters,
    points: &[Exact],
) -> Result<f64> {
    let errors: Vec<f64> = if parameters.stiffness_model == StiffnessModel::Constant {
        // The best constant there is for these points at the nominal torque: nominal force over mean STE.
        let torque = [setup.pair.operating.nominal_torque; 2];
        let nominal = setup.exact(
            &Ranges {
                torque,
                ..setup.ranges(2)
            },
            64,
        )?;
        let stiffness = setup.nominal_force() / mean(nominal.iter().map(|x| x.query.delta));
        let error = |x: &Exact| stiffness * x.query.delta.max(0.0) - x.force;
        points.iter().map(error).collect()
    } else {
        let cut = table.sliced(&parameters.table_effects(&setup.pair.geometry))?;
        let (flank, _) = cut.flank(Flank::Drive);
        let error = |x: &Exact| {
            let mut query: Query = x.query;
            query.center_distance_offset *= f64::from(u8::from(parameters.center_distance_effect));
            query.misalignment *= f64::from(u8::from(parameters.misalignment_effect));
            flank.evaluate(&query, false).gradient[0] - x.force
        };
        points.iter().map(error).collect()
    };
    Ok(100.0 * rms(errors) / setup.nominal_force())
}

/// rms error of the shuttling moment when it is left out, in % of nominal force times half the face.
fn moment_left_out(setup: &Setup, ranges: &Ranges, points: usize) -> Result<f64> {
    let moments = setup.exact(ranges, points)?.into_iter().map(|x| x.moment);
    Ok(100.0 * rms(moments) / (setup.nominal_force() * setup.half_face()))
}

pub fn report(context: &Context, data: &Data) -> Result<()> {
    let Sampled { setup, grid } = Sampled::of(context)?;
    let table = setup.table(grid)?;
    let all = everything(setup);
    let mut rows = vec![];
    for effect in effects(setup) {
        let mut parameters = all;
        (effect.leave_out)(&mut parameters);
        let mut row = effect.name.to_owned();
        for (scene, ranges) in &effect.scenes {
            let exact = setup.exact(ranges, points(context))?;
            let with = error(setup, &table, &all, &exact)?;
            let without = error(setup, &table, &parameters, &exact)?;
            row += &format!(" | {scene} | {with:.2} / {without:.2}");
        }
        rows.push(row);
    }
    let misalignment = setup.pair.operating.misalignment;
    let tilted = Ranges {
        misalignment,
        ..setup.ranges(2)
    };
    let spur = coarse("fzg-c")?;
    let parallel = moment_left_out(&spur, &spur.ranges(2), points(context))?;
    let tilted = moment_left_out(setup, &tilted, points(context))?;
    rows.push(format!(
        "shuttling (error of the moment) | shafts that tilt by ±3 mrad | / {tilted:.2} \
         | spur pair, parallel shafts | / {parallel:.2}"
    ));
    let head = "effect | scene where it matters | error, % | scene where it does not | error, %";
    data.table("effects", head, &rows)
}
