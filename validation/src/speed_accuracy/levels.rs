//! Which level of detail a dynamic run needs: cost and error of each against contact at run time on the finest elements.

use super::{PAIR, everything};
use crate::data::{Data, range, rms};
use crate::driver::{Bearing, Gear, Scene, Spin};
use crate::setup::{Setup, ratio, shipped_at, ste};
use crate::timing::{median, timed};
use crate::{Context, Result};
use gearmesh::contact::ContactFile;
use gearmesh::element::{Element, LoadedFlank, Parameters, StiffnessModel};
use gearmesh::table::Table;
use gearmesh_preprocessor::gear::Refinement;
use nalgebra::{UnitQuaternion, Vector3};
use std::f64::consts::TAU;
use std::sync::Arc;

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
/// Bearing of gear 2.
const BEARING: Bearing = Bearing {
    stiffness: [5e7; 3],
    damping: 1e3,
    tilt_stiffness: 2e5,
    tilt_damping: 2.0,
};

/// A run: what is met at every sample, m and rad, and the seconds of a step, median.
#[derive(Default)]
struct Run {
    dte: Vec<f64>,
    contact_z: Vec<f64>,
    step: f64,
}

impl Run {
    /// Gear 1 turns at constant speed, its axis tilted; gear 2 turns with it on elastic bearings, under a torque that grows.
    fn new(setup: &Setup, element: &Element) -> Result<Self> {
        let geometry = &setup.pair.geometry;
        let operating = &setup.pair.operating;
        let speed = SPEED_RPM * TAU / 60.0;
        let [low, high] = [0.1 * operating.nominal_torque, operating.maximum_torque];
        let ramp = Spin::Torque(Arc::new(move |t: f64, _| {
            low + (high - low) * (t / DURATION)
        }));
        let mut gears = [
            Gear::new(geometry, 0, Spin::speed(speed)),
            Gear::new(geometry, 1, ramp),
        ];
        for (gear, of) in gears.iter_mut().zip(&geometry.gears) {
            gear.center_of_mass = 0.5 * of.face_width;
        }
        gears[1].bearing = Some(BEARING);
        let scene = Scene::new(element.clone(), gears)?;
        let mut state = scene.with_spin(&scene.rest(), 1, 0.0, ratio(geometry) * speed);
        // Its centre stays where it is.
        let tilt = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), TILT);
        state[0].q = tilt.into_inner() * state[0].q;
        let (mut run, mut seconds) = (Run::default(), vec![]);
        for sample in 0..(DURATION / STEP).round() as usize / STEPS_PER_SAMPLE {
            let time = |n: usize| (sample * STEPS_PER_SAMPLE + n) as f64 * STEP;
            let mut steps = 0..STEPS_PER_SAMPLE;
            let (stepped, elapsed) =
                timed(|| steps.try_fold(state, |state, n| scene.step(time(n), &state, STEP)));
            state = stepped?;
            seconds.push(elapsed / STEPS_PER_SAMPLE as f64);
            let t = time(STEPS_PER_SAMPLE);
            let out = scene.contact(t, &state)?;
            if t >= SETTLING * DURATION {
                run.dte.push(out.transmission_error);
                run.contact_z.push(out.contact_z);
            }
        }
        run.step = median(seconds);
        Ok(run)
    }
}

/// rms difference of two runs' samples.
fn error(a: &[f64], b: &[f64]) -> f64 {
    rms(a.iter().zip(b).map(|(a, b)| a - b))
}

/// A level of detail by its name.
type Level = (String, Element);

/// The pair at `refinement` with its contact at run time, discretised as `gearmesh build` does.
fn contact(refinement: Refinement) -> Result<(Setup, ContactFile)> {
    let setup = Setup::new(shipped_at(PAIR, refinement)?, None)?;
    let file = setup.contact_file()?;
    Ok((setup, file))
}

fn by_contact(setup: &Setup, file: &ContactFile) -> Result<Element> {
    let parameters = Parameters {
        stiffness_model: StiffnessModel::Contact,
        loaded_flank: LoadedFlank::Drive,
        ..everything(setup)
    };
    Ok(Element::with_contact(
        &setup.pair.geometry,
        &parameters,
        file,
    )?)
}

/// Constant stiffness, tables with one effect more each, and tooth pair by tooth pair, all teeth alike.
fn simpler(setup: &Setup, contact: &ContactFile, counts: [usize; 4]) -> Result<Vec<Level>> {
    let geometry = &setup.pair.geometry;
    let mut file = setup.file(&setup.samples(counts)?);
    let table = Arc::new(Table::from_file(file.clone())?);
    let mut four = everything(setup);
    four.loaded_flank = LoadedFlank::Drive;
    let mut three = four;
    three.center_distance_effect = false;
    let mut two = three;
    (two.misalignment_effect, two.shuttling_effect) = (false, false);
    let mut one = two;
    one.load_dependent = false;
    let [mean_um, _] = ste(&setup.solver, setup.pair.operating.nominal_torque, 32)?;
    let angle = geometry.operating_pressure_angle(geometry.center_distance);
    let mut constant = two;
    constant.stiffness_model = StiffnessModel::Constant;
    constant.constant_stiffness = setup.nominal_force() / (1e-6 * mean_um) * angle.cos().powi(2);
    let mut teeth = four;
    teeth.stiffness_model = StiffnessModel::Teeth;
    file.teeth = Some(setup.teeth_record(contact, POINTS)?);
    let effects = teeth.table_effects(geometry);
    let with_teeth = Arc::new(Table::with_effects(Arc::new(file), effects)?);
    let mut levels = vec![];
    for (name, parameters, table) in [
        ("constant stiffness", constant, &table),
        ("1-D table: mesh position", one, &table),
        ("2-D table: + load", two, &table),
        ("3-D table: + misalignment, shuttling", three, &table),
        ("4-D table: + centre distance", four, &table),
        ("tooth pair by tooth pair", teeth, &with_teeth),
    ] {
        let element = Element::new(geometry, &parameters, Some(table.clone()))?;
        levels.push((name.into(), element));
    }
    Ok(levels)
}

/// The chapter; contact on the finest elements is the reference.
pub fn report(context: &Context, data: &Data) -> Result<()> {
    let counts = if context.quick {
        [8, 5, 9, 16]
    } else {
        [12, 5, 17, 32]
    };
    let refinements = [
        ("coarse", Refinement::Coarse),
        ("normal", Refinement::Normal),
        ("fine", Refinement::Fine),
    ];
    let mut contacts = vec![];
    for (name, refinement) in refinements
        .into_iter()
        .take(if context.quick { 2 } else { 3 })
    {
        contacts.push((name, contact(refinement)?));
    }
    let (finest, (best, file)) = contacts.pop().ok_or("no refinement")?;
    let reference = Run::new(&best, &by_contact(&best, &file)?)?;
    // Tables on the finest elements that are not the reference's.
    let (_, (usual, usual_contact)) = contacts.last().ok_or("no refinement")?;
    let mut levels = simpler(usual, usual_contact, counts)?;
    for (name, (setup, file)) in &contacts {
        let element = by_contact(setup, file)?;
        levels.push((format!("contact at run time, {name}"), element));
    }

    let (mut rows, mut runs) = (vec![], vec![]);
    for (name, element) in &levels {
        let run = Run::new(&best, element)?;
        let dte = 1e6 * error(&run.dte, &reference.dte);
        let z = 1e3 * error(&run.contact_z, &reference.contact_z);
        rows.push(format!(
            "{name} | {:.1} | {dte:.3} | {z:.3}",
            1e6 * run.step
        ));
        runs.push(run);
    }
    let step = 1e6 * reference.step;
    rows.push(format!(
        "contact at run time, {finest} (reference) | {step:.1} | |"
    ));
    // The 4-D table and contact on its own elements.
    let by_table = 1e6 * error(&runs[4].dte, &runs[runs.len() - 1].dte);
    rows.push(format!(
        "4-D table from contact on the same elements | | {by_table:.3} |"
    ));
    let head = "level | a step, µs | rms error of the DTE, µm | of z_c, mm";
    data.table("levels", head, &rows)?;

    let [low, high] = range(reference.dte.iter().map(|dte| 1e6 * dte));
    let row = format!("DTE, µm | {low:.2} | {high:.2}");
    data.table("levels-reference", "of the reference | from | to", &[row])
}
