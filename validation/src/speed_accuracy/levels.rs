//! Which level of detail a dynamic run needs: cost and error of each against contact at run time on the finest elements.

use super::{PAIR, everything, ratio};
use crate::data::{Data, fixed, range, rms};
use crate::driver::{Bearing, Gear, Scene, Spin, gear_state, set_gear_state};
use crate::setup::{Setup, quiet, shipped_at, ste};
use crate::timing::{median, timed};
use crate::{Context, Result, row};
use gearmesh::contact::{ContactFile, ContactSettings};
use gearmesh::element::{Element, LoadedFlank, Parameters, StiffnessModel};
use gearmesh::pair::Refinement;
use gearmesh::table::Table;
use gearmesh_preprocessor::contact::contact_file;
use gearmesh_preprocessor::table::{TeethSweep, default_teeth_axes};
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
const BEARING: Bearing = Bearing { stiffness: [5e7; 3], damping: 1e3, tilt_stiffness: 2e5, tilt_damping: 2.0 };

/// What is met at a sample of a run.
#[derive(Clone, Copy)]
struct Sample {
    dte: f64,
    contact_z: f64,
    misalignment: f64,
    center_distance: f64,
}

/// A run, and the seconds of a step, median.
struct Run {
    samples: Vec<Sample>,
    step: f64,
}

impl Run {
    /// Gear 1 turns at constant speed, its axis tilted; gear 2 turns with it on elastic bearings, under a torque that grows.
    fn new(setup: &Setup, element: &Element) -> Result<Self> {
        let geometry = &setup.pair.geometry;
        let operating = &setup.pair.operating;
        let speed = SPEED_RPM * TAU / 60.0;
        let [low, high] = [0.1 * operating.nominal_torque, operating.maximum_torque];
        let ramp = Spin::Torque(Arc::new(move |t: f64, _| low + (high - low) * (t / DURATION)));
        let middle = |i: usize, spin| Gear {
            center_of_mass: 0.5 * geometry.gears[i].face_width,
            ..Gear::new(geometry, i, spin)
        };
        let second = Gear { bearing: Some(BEARING), ..middle(1, ramp) };
        let scene = Scene::new(element.clone(), [middle(0, Spin::speed(speed)), second])?;
        let mut state = scene.with_spin(&scene.rest(), 1, 0.0, ratio(setup) * speed);
        let mut first = gear_state(&state, 0);
        // Its centre stays where it is.
        first.q = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), TILT) * first.q;
        set_gear_state(&mut state, 0, &first);
        let (mut samples, mut seconds) = (vec![], vec![]);
        for sample in 0..(DURATION / STEP).round() as usize / STEPS_PER_SAMPLE {
            let begin = (sample * STEPS_PER_SAMPLE) as f64 * STEP;
            let (stepped, time) = timed(|| {
                (0..STEPS_PER_SAMPLE).try_fold(state, |state, n| scene.step(begin + n as f64 * STEP, &state, STEP))
            });
            state = stepped?;
            seconds.push(time / STEPS_PER_SAMPLE as f64);
            let t = begin + STEPS_PER_SAMPLE as f64 * STEP;
            let out = scene.contact(t, &state)?;
            if t >= SETTLING * DURATION {
                samples.push(Sample {
                    dte: out.transmission_error,
                    contact_z: out.contact_z,
                    misalignment: out.misalignment,
                    center_distance: out.center_distance,
                });
            }
        }
        Ok(Run { samples, step: median(seconds) })
    }

    /// rms difference of a quantity from that of another run.
    fn error(&self, reference: &Self, of: fn(&Sample) -> f64) -> f64 {
        rms(self.samples.iter().zip(&reference.samples).map(|(a, b)| of(a) - of(b)))
    }

    fn range(&self, of: fn(&Sample) -> f64) -> [f64; 2] {
        range(self.samples.iter().map(of))
    }
}

/// A level of detail.
struct Level {
    name: String,
    element: Element,
}

/// The pair at `refinement` with its contact at run time, discretised as `gearmesh build` does.
fn contact(refinement: Refinement) -> Result<(Setup, ContactFile)> {
    let pair = shipped_at(PAIR, refinement)?;
    let settings = ContactSettings::for_pair(&pair);
    let setup = Setup::new(pair, settings)?;
    let file = contact_file(&setup.pair, &setup.solver.clone().at_run_time())?;
    Ok((setup, file))
}

fn by_contact(setup: &Setup, file: &ContactFile) -> Result<Element> {
    let parameters =
        Parameters { stiffness_model: StiffnessModel::Contact, loaded_flank: LoadedFlank::Drive, ..everything(setup) };
    Ok(Element::with_contact(&setup.pair.geometry, &parameters, file, None)?)
}

/// Constant stiffness, tables with one effect more each, and tooth pair by tooth pair, all teeth alike.
fn simpler(setup: &Setup, contact: &ContactFile, counts: [usize; 4]) -> Result<Vec<Level>> {
    let geometry = &setup.pair.geometry;
    let mut file = setup.file(&setup.samples(counts)?);
    let table = Arc::new(Table::from_file(file.clone())?);
    let four = Parameters { loaded_flank: LoadedFlank::Drive, ..everything(setup) };
    let three = Parameters { center_distance_effect: false, ..four };
    let two = Parameters { misalignment_effect: false, shuttling_effect: false, ..three };
    let one = Parameters { load_dependent: false, ..two };
    let [mean_um, _] = ste(&setup.solver, setup.pair.operating.nominal_torque, 32)?;
    let cos = geometry.operating_pressure_angle(geometry.center_distance).cos();
    let constant = Parameters {
        stiffness_model: StiffnessModel::Constant,
        constant_stiffness: setup.nominal_force() / (1e-6 * mean_um) * cos * cos,
        ..two
    };
    let coverage = setup.coverage();
    let sweep = TeethSweep { solver: &setup.solver, contact, coverage: &coverage, coast_mirrors_drive: true };
    file.teeth = Some(sweep.record(&default_teeth_axes(&coverage), POINTS, &quiet())?);
    let teeth = Parameters { stiffness_model: StiffnessModel::Teeth, ..four };
    let with_teeth = Arc::new(Table::with_effects(Arc::new(file), teeth.table_effects(geometry))?);
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
        levels.push(Level { name: name.into(), element });
    }
    Ok(levels)
}

/// The chapter; contact on the finest elements is the reference.
pub fn report(context: &Context, data: &Data) -> Result<()> {
    let counts = if context.quick { [8, 5, 9, 16] } else { [12, 5, 17, 32] };
    let mut contacts = vec![("coarse", contact(Refinement::Coarse)?), ("normal", contact(Refinement::Normal)?)];
    if !context.quick {
        contacts.push(("fine", contact(Refinement::Fine)?));
    }
    let (finest, (best, file)) = contacts.pop().ok_or("no refinement")?;
    let reference = Run::new(&best, &by_contact(&best, &file)?)?;
    // Tables on the finest elements that are not the reference's.
    let (_, (usual, usual_contact)) = contacts.last().ok_or("no refinement")?;
    let mut levels = simpler(usual, usual_contact, counts)?;
    for (name, (setup, file)) in &contacts {
        let name = format!("contact at run time, {name}");
        levels.push(Level { name, element: by_contact(setup, file)? });
    }

    let mut rows = vec![];
    let mut runs = vec![];
    for level in &levels {
        let run = Run::new(&best, &level.element)?;
        let [dte, z] = [1e6 * run.error(&reference, |s| s.dte), 1e3 * run.error(&reference, |s| s.contact_z)];
        rows.push(row![level.name, fixed(1e6 * run.step, 1), fixed(dte, 3), fixed(z, 3)]);
        runs.push(run);
    }
    let name = format!("contact at run time, {finest} (reference)");
    rows.push(row![name, fixed(1e6 * reference.step, 1), "", ""]);
    // The 4-D table and contact on its own elements.
    let by_table = 1e6 * runs[4].error(&runs[runs.len() - 1], |s| s.dte);
    rows.push(row!["4-D table from contact on the same elements", "", fixed(by_table, 3), ""]);
    data.table("levels", &["level", "a step, µs", "rms error of the DTE, µm", "of z_c, mm"], &rows)?;

    let nominal = best.pair.geometry.center_distance;
    let mean = crate::data::mean(&reference.samples.iter().map(|s| s.dte).collect::<Vec<_>>());
    let [dte, z] = [reference.range(|s| s.dte), reference.range(|s| s.contact_z)];
    let [tilt, distance] = [reference.range(|s| s.misalignment), reference.range(|s| s.center_distance)];
    let between = |[low, high]: [f64; 2], scale: f64, digits: usize| {
        row![fixed(scale * low, digits), fixed(scale * high, digits)]
    };
    let rows = [
        [row!["misalignment, mrad"], between(tilt, 1e3, 2)].concat(),
        [row!["centre distance off the nominal, µm"], between(distance.map(|a| a - nominal), 1e6, 0)].concat(),
        [row!["DTE, µm"], between(dte, 1e6, 2)].concat(),
        row!["DTE, mean, µm", fixed(1e6 * mean, 2), ""],
        [row!["z_c, mm"], between(z, 1e3, 2)].concat(),
    ];
    data.table("levels-reference", &["of the reference", "from", "to"], &rows)
}
