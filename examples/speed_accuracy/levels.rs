//! Which level of detail a dynamic run needs: cost and error of each against contact at run time on the finest elements.

use crate::document::{Document, Error};
use crate::driver::{
    Bearing, Freedoms, Gear, Method, STATES, Scene, Spin, gear_state, set_gear_state,
};
use crate::plot::{Series, log_log};
use crate::setting::Setting;
use crate::timing::{median, timed};
use crate::whole_element::everything;
use gearmesh::contact::{ContactFile, ContactSettings, CycleInput, MeshCycle};
use gearmesh::element::{Element, LoadedFlank, Parameters, StiffnessModel};
use gearmesh::fmi::contact_law;
use gearmesh::pair::{Pair, Refinement};
use gearmesh::table::sweep::Watch;
use gearmesh::table::{Table, TeethSweep, default_teeth_axes};
use nalgebra::{UnitQuaternion, Vector3};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Speed of gear 1, rpm, and the time of its revolution, s.
const SPEED_RPM: f64 = 1500.0;
const DURATION: f64 = 60.0 / SPEED_RPM;
/// Random operating points at which tooth pairs one by one are measured.
const POINTS: usize = 200;
/// Step of the integrator, s, and steps from one sample to the next.
const STEP: f64 = 5e-6;
const STEPS_PER_SAMPLE: usize = 4;
/// Part of the revolution that is left out of the errors: the gears have to settle.
const SETTLING: f64 = 0.1;
/// Tilt of gear 1 across the line of centres, rad.
const TILT: f64 = 0.5e-3;
/// Bearing of gear 2: N/m, N s/m, N m/rad, N m s/rad.
const BEARING: Bearing = Bearing {
    stiffness: [5e7; 3],
    damping: [1e3; 3],
    tilt_stiffness: 2e5,
    tilt_damping: 2.0,
    spin_stiffness: 0.0,
};
/// Mass, kg, and polar moment of inertia, kg m², of gear 2: those of the run-up.
const MASS: f64 = 0.8;
const INERTIA: f64 = 4.213e-4;

/// What a run shows.
struct Run {
    /// DTE, m, and z_c, m, at every sample.
    samples: Vec<[f64; 2]>,
    /// Misalignments, rad, and centre distances, m, met: least and largest.
    met: [[f64; 2]; 2],
    /// Seconds of a step, median.
    step: f64,
}

/// A level of detail.
struct Level {
    name: String,
    kind: usize,
    element: Element,
}

/// Legend of the kinds of levels.
const KINDS: [&str; 3] = ["constant", "tables", "contact"];

fn scene(setting: &Setting, element: &Element) -> Result<Scene, Error> {
    let geometry = &setting.pair.geometry;
    let operating = &setting.pair.operating;
    let speed = SPEED_RPM * std::f64::consts::TAU / 60.0;
    let [low, high] = [0.1 * operating.nominal_torque, operating.maximum_torque];
    let gear = |i: usize, spin, bearing, freedoms| Gear {
        mass: MASS,
        polar_inertia: INERTIA,
        transverse_inertia: 0.6 * INERTIA,
        center_of_mass: 0.5 * geometry.gears[i].face_width,
        origin: Vector3::new(i as f64 * geometry.center_distance, 0.0, 0.0),
        bearing,
        freedoms,
        spin,
    };
    let ramp = Spin::Torque(Arc::new(move |t: f64, _| {
        low + (high - low) * (t / DURATION)
    }));
    let gears = [
        gear(
            0,
            Spin::speed(speed),
            Bearing::default(),
            Freedoms::default(),
        ),
        gear(1, ramp, BEARING, Freedoms::ALL),
    ];
    Ok(Scene::new(element.clone(), gears)?)
}

/// Gear 1 turns at constant speed, its axis tilted; gear 2 turns with it on elastic bearings, under a torque that grows.
fn run(setting: &Setting, element: &Element) -> Result<Run, Error> {
    let scene = scene(setting, element)?;
    let ratio = {
        let [a, b] = crate::whole_element::teeth(setting);
        -setting.pair.geometry.e() * a / b
    };
    let speed = SPEED_RPM * std::f64::consts::TAU / 60.0;
    let mut state: [f64; STATES] = scene.with_spin(&scene.rest(), 1, 0.0, ratio * speed);
    let mut first = gear_state(&state, 0);
    first.q = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), TILT) * first.q;
    // Its centre stays where it is.
    set_gear_state(&mut state, 0, &first);
    let mut run = Run {
        samples: vec![],
        met: [[f64::INFINITY, f64::NEG_INFINITY]; 2],
        step: 0.0,
    };
    let mut seconds = vec![];
    let samples = (DURATION / STEP).round() as usize / STEPS_PER_SAMPLE;
    for sample in 0..samples {
        let begin = (sample * STEPS_PER_SAMPLE) as f64 * STEP;
        let (stepped, time) = timed(|| {
            (0..STEPS_PER_SAMPLE).try_fold(state, |state, n| {
                Method::RungeKutta4.step(&scene, begin + n as f64 * STEP, &state, STEP)
            })
        });
        state = stepped?;
        seconds.push(time / STEPS_PER_SAMPLE as f64);
        let t = begin + STEPS_PER_SAMPLE as f64 * STEP;
        let out = scene.contact(t, &state)?;
        if t >= SETTLING * DURATION {
            run.samples.push([out.transmission_error, out.contact_z]);
            for (met, value) in run
                .met
                .iter_mut()
                .zip([out.misalignment, out.center_distance])
            {
                *met = [met[0].min(value), met[1].max(value)];
            }
        }
    }
    run.step = median(seconds);
    Ok(run)
}

/// rms differences of the DTE and of z_c, m.
fn error(run: &Run, reference: &Run) -> [f64; 2] {
    [0, 1].map(|i| {
        let pairs = run.samples.iter().zip(&reference.samples);
        let squares: f64 = pairs.map(|(a, b)| (a[i] - b[i]).powi(2)).sum();
        (squares / run.samples.len() as f64).sqrt()
    })
}

/// The pair of `path` at `refinement` with its contact at run time, discretised as `gearmesh build` does.
fn contact(path: &str, refinement: Refinement) -> Result<(Setting, ContactFile), Error> {
    let pair = Pair {
        refinement,
        ..Pair::read(path)?
    };
    let contact = ContactSettings::for_pair(&pair);
    let setting = Setting::of(pair, contact)?;
    let file = ContactFile::new(&setting.pair, &setting.solver.clone().at_run_time())?;
    Ok((setting, file))
}

fn by_contact(setting: &Setting, file: &ContactFile) -> Result<Element, Error> {
    let parameters = Parameters {
        stiffness_model: StiffnessModel::Contact,
        loaded_flank: LoadedFlank::Drive,
        ..everything(setting)
    };
    let laws = contact_law::laws(file);
    Ok(Element::with_laws(
        &setting.pair.geometry,
        &parameters,
        &laws,
    )?)
}

/// Constant stiffness and tables; what is left out stands in their names.
fn simpler(setting: &Setting, counts: [usize; 4]) -> Result<Vec<Level>, Error> {
    let geometry = &setting.pair.geometry;
    let table = Arc::new(Table::from_file(setting.file(&setting.samples(counts)?))?);
    let four = Parameters {
        loaded_flank: LoadedFlank::Drive,
        ..everything(setting)
    };
    let three = Parameters {
        center_distance_effect: false,
        ..four
    };
    let two = Parameters {
        misalignment_effect: false,
        shuttling_effect: false,
        ..three
    };
    let one = Parameters {
        load_dependent: false,
        ..two
    };
    let mean = MeshCycle::solve(
        &setting.solver,
        &CycleInput {
            torque: setting.pair.operating.nominal_torque,
            positions: 32,
            ..crate::nominal_cycle()
        },
    )?
    .mean_ste();
    let cos = geometry
        .operating_pressure_angle(geometry.center_distance)
        .cos();
    let constant = Parameters {
        stiffness_model: StiffnessModel::Constant,
        constant_stiffness: setting.nominal_force() / mean * cos * cos,
        ..two
    };
    [
        ("constant stiffness", 0, constant),
        ("1-D table: mesh position", 1, one),
        ("2-D table: + load", 1, two),
        ("3-D table: + misalignment, shuttling", 1, three),
        ("4-D table: + centre distance", 1, four),
    ]
    .into_iter()
    .map(|(name, kind, parameters)| {
        Ok(Level {
            name: name.to_owned(),
            kind,
            element: Element::new(geometry, &parameters, Some(table.clone()))?,
        })
    })
    .collect()
}

/// Tooth pair by tooth pair, all teeth alike, on the whole range of the pair file.
fn by_teeth(setting: &Setting, contact: &ContactFile, counts: [usize; 4]) -> Result<Level, Error> {
    let coverage = setting.coverage();
    let sweep = TeethSweep {
        solver: &setting.solver,
        contact,
        coverage: &coverage,
        coast_mirrors_drive: true,
    };
    let watch = Watch {
        progress: &|_, _| (),
        cancel: &AtomicBool::new(false),
    };
    let record = sweep.record(&default_teeth_axes(&coverage), POINTS, &watch)?;
    let mut file = setting.file(&setting.samples(counts)?);
    file.teeth = Some(record);
    let parameters = Parameters {
        stiffness_model: StiffnessModel::Teeth,
        loaded_flank: LoadedFlank::Drive,
        ..everything(setting)
    };
    let table = Table::with_effects(
        Arc::new(file),
        parameters.table_effects(&setting.pair.geometry),
    )?;
    Ok(Level {
        name: "tooth pair by tooth pair".to_owned(),
        kind: 1,
        element: Element::new(&setting.pair.geometry, &parameters, Some(Arc::new(table)))?,
    })
}

/// The section, on the pair file at `path`; the last of `refinements` is the reference.
pub fn report(
    document: &mut Document,
    path: &str,
    refinements: &[(Refinement, &str)],
    counts: [usize; 4],
) -> Result<(), Error> {
    document.section("Which level do I need");
    let ((_, finest), others) = refinements.split_last().ok_or("a refinement")?;
    let mut contacts = vec![];
    for &(refinement, name) in refinements {
        contacts.push((name, contact(path, refinement)?));
    }
    let [.., (_, (best, file))] = &contacts[..] else {
        return Err("a refinement".into());
    };
    let reference = run(best, &by_contact(best, file)?)?;
    // Tables on the elements of the finest level that is not the reference.
    let (usual_name, (usual, usual_contact)) = contacts
        .get(others.len().wrapping_sub(1))
        .unwrap_or(&contacts[0]);
    let mut levels = simpler(usual, counts)?;
    levels.push(by_teeth(usual, usual_contact, counts)?);
    for (name, (setting, file)) in contacts.iter().take(others.len()) {
        levels.push(Level {
            name: format!("contact at run time, {name}"),
            kind: 2,
            element: by_contact(setting, file)?,
        });
    }

    let mut rows = vec![];
    let mut series: Vec<Series> = ["DTE, µm", "z_c, mm"]
        .iter()
        .flat_map(|what| KINDS.map(|kind| format!("{what}: {kind}")))
        .map(|label| Series {
            label,
            points: vec![],
            joined: true,
        })
        .collect();
    let mut found = vec![];
    let mut runs = vec![];
    for level in &levels {
        let run = run(best, &level.element)?;
        let [dte, z] = error(&run, &reference);
        let step = 1e6 * run.step;
        rows.push([
            level.name.clone(),
            format!("{step:.1}"),
            format!("{:.3}", 1e6 * dte),
            format!("{:.3}", 1e3 * z),
        ]);
        series[level.kind].points.push((step, 1e6 * dte));
        series[KINDS.len() + level.kind]
            .points
            .push((step, 1e3 * z));
        found.push([step, 1e6 * dte, 1e3 * z]);
        runs.push(run);
    }
    rows.push([
        format!("contact at run time, {finest} (reference)"),
        format!("{:.1}", 1e6 * reference.step),
        "–".into(),
        "–".into(),
    ]);

    let n = reference.samples.len() as f64;
    let mean = |i: usize| reference.samples.iter().map(|s| s[i]).sum::<f64>() / n;
    let swing = |i: usize| {
        let of = |fold: fn(f64, f64) -> f64, start: f64| {
            reference.samples.iter().map(|s| s[i]).fold(start, fold)
        };
        of(f64::max, f64::NEG_INFINITY) - of(f64::min, f64::INFINITY)
    };
    let operating = &best.pair.operating;
    let nominal_distance = best.pair.geometry.center_distance;
    document.paragraph(&format!(
        "One revolution of the reference pair in which everything moves: gear 1 turns at {SPEED_RPM:.0} rpm about an axis tilted \
         by {:.1} mrad, gear 2 ({MASS} kg, {INERTIA} kg m²) is carried by elastic bearings (5e7 N/m, 2e5 N m/rad) in all six \
         freedoms, and its torque rises from {:.0} to {:.0} N m. Misalignment goes from {:.2} to {:.2} mrad, the centre \
         distance from {:.0} to {:.0} µm off the nominal. Classical Runge-Kutta with steps of {:.0} µs, four evaluations \
         each; the cost is the median over the run, the host's equations of motion included. Errors are rms differences from contact at run \
         time on {finest} elements, whose DTE is {:.2} µm in the mean and swings by {:.2} µm, and whose z_c swings by {:.2} mm, \
         but for the first tenth. Tables are made on {usual_name} elements, with {} × {} × {} × {} displacements, \
         centre distances, misalignments, mesh positions; each row switches one more effect on. The constant stiffness is nominal force over mean STE.",
        1e3 * TILT,
        0.1 * operating.nominal_torque,
        operating.maximum_torque,
        1e3 * reference.met[0][0],
        1e3 * reference.met[0][1],
        1e6 * (reference.met[1][0] - nominal_distance),
        1e6 * (reference.met[1][1] - nominal_distance),
        1e6 * STEP,
        1e6 * mean(0),
        1e6 * swing(0),
        1e3 * swing(1),
        counts[0],
        counts[1],
        counts[2],
        counts[3],
    ));
    document.table(
        [
            "level",
            "a step, µs",
            "rms error of the DTE, µm",
            "of z_c, mm",
        ],
        &rows,
    );
    let svg = log_log(
        "a step, µs",
        "rms error: DTE in µm, z_c in mm",
        &series,
        &[],
    )?;
    document.plot(
        "speed-levels",
        "Cost and error of every level of detail in one dynamic run",
        &svg,
    )?;
    let [constant, one, two, three, four, teeth, ..] = found[..] else {
        return Err("six levels and more".into());
    };
    let last = found[found.len() - 1];
    // The 4-D table and contact on its own elements.
    let [_, _, _, _, table, _, .., same] = &runs[..] else {
        return Err("six levels and more".into());
    };
    let [by_table, _] = error(table, same);
    document.paragraph(&format!(
        "Rule: switch on the effects whose coordinates move, and no more. What a level leaves out sets its error, not how finely \
         it is made:\n\n\
         1. The mean torque path and slow control, noise of no interest: constant stiffness ({:.2} µm here).\n\
         2. Parallel shafts on stiff bearings: a table over the mesh position, if the load stays (here it does not: {:.2} µm), else over the load too ({:.2} µm).\n\
         3. Shafts or housings that tilt: misalignment and shuttling ({:.2} µm; z_c within {:.3} mm instead of {:.2} mm).\n\
         4. Centre distances that change by tens of micrometres: all four axes ({:.2} µm), at {:.1} µs a step against {:.1} µs of the constant stiffness. The default.\n\
         5. Teeth that differ by index errors or run-out, in runs in which the cost counts: tooth pair by tooth pair ({:.2} µm here, with teeth that are alike, at {:.1} µs a step).\n\
         6. Poses beyond the ranges of the pair file, single teeth of their own, or a check of the tables: contact at run time (here {:.3} µm on {} elements, {:.0} µs a step, {:.0} times the table). \
         It costs that much everywhere; with teeth that are alike and poses within the ranges, tables answer as well: {:.3} µm rms from contact on the same elements.",
        constant[1],
        one[1],
        two[1],
        three[1],
        three[2],
        two[2],
        four[1],
        four[0],
        constant[0],
        teeth[1],
        teeth[0],
        last[1],
        others.last().map_or("these", |(_, name)| name),
        last[0],
        last[0] / four[0],
        1e6 * by_table,
    ));
    Ok(())
}
