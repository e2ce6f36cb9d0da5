//! Two discs that an FMU couples, swept slowly up in speed and down again: resonances, jumps, and what the teeth carry.
//!
//! Both discs turn freely about fixed axes. The drive brings the mean torque and what speeds the discs up, so that the teeth carry
//! the same mean torque at every speed. The FMU steps first and predicts its loads; the discs move exactly under loads that are
//! constant over a step.

mod analysis;
#[cfg(test)]
mod tests;

use std::f64::consts::TAU;
use std::sync::Arc;

use crate::package::{Driven, SEQUENTIAL, TABLE, TEETH};
use crate::shaft::BearingShares;
use gearmesh::contact::ContactFile;
use gearmesh::fmi::Refusal;
use gearmesh::fmi::resources::{Resources, UnitFile};
use gearmesh::fmi::variables::{VARIABLES, index};
use gearmesh::table::TableFile;

/// What is swept.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sweep {
    /// Moment of inertia of each gear with all that turns with it, about its axis, kg m². Infinite: it turns as imposed; not both.
    pub inertia: [f64; 2],
    /// Damping ratio of both discs on the mean mesh stiffness, >= 0; sets `damping` of the FMU.
    pub damping_ratio: f64,
    /// Mean torque on gear 1, N m: > 0 on the drive flank, < 0 on the coast flank.
    pub torque: f64,
    /// Lowest and highest speed of gear 1, rad/s, >= 0.
    pub speeds: [f64; 2],
    /// Time of each way, s. None: twenty decay times pass while the mesh frequency crosses the width of the resonance.
    pub duration: Option<f64>,
    /// Communication step, s. None: 0.07 rad of the natural frequency, or a twentieth of the shortest mesh cycle; where teeth part, the
    /// end of the upper branch is within a percent then.
    pub step: Option<f64>,
}

/// Signals over one way, evenly spaced in time; SI.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct History {
    /// Since the start of this way, s.
    pub time: Vec<f64>,
    /// Angle and speed of gear 1, rad and rad/s.
    pub angle: Vec<f64>,
    /// rad/s.
    pub speed: Vec<f64>,
    /// `mesh.transmissionError`, m, on the operating pitch circle.
    pub transmission_error: Vec<f64>,
    /// `mesh.tangentialForce`, N.
    pub tangential_force: Vec<f64>,
    /// Angular acceleration of both gears without the mean one, rad/s².
    pub acceleration: [Vec<f64>; 2],
    /// `mesh.outOfRange`: pose or load outside the range of the tables.
    pub out_of_range: Vec<bool>,
    /// Radial force of each bearing of both gears, N, where their shafts are known.
    pub bearing_force: [Vec<Vec<f64>>; 2],
}

/// Both ways, and what they were made with.
#[derive(Debug, Clone, PartialEq)]
pub struct RunUp {
    /// From the lowest speed to the highest.
    pub up: History,
    /// Back, from where the run-up ended.
    pub down: History,
    /// Of both discs on the mean tangent stiffness at nominal torque, Hz.
    pub natural_frequency: f64,
    /// Speed of gear 1 at which the mesh frequency is that one, rad/s.
    pub resonance_speed: f64,
    /// Mesh damping, tangential, N s/m.
    pub damping: f64,
    /// Communication step and time of each way, s.
    pub step: f64,
    /// s.
    pub duration: f64,
}

const STEP_ANGLE: f64 = 0.07;
const STEPS_PER_CYCLE: f64 = 20.0;
/// Largest step, rad of the natural frequency. Where teeth part, the largest swings are off by 2 to 5 % at 0.46 rad and by 11 to 30 % at 0.77.
const LARGEST_STEP_ANGLE: f64 = 0.5;
/// Largest number of steps of both ways together: a quarter of an hour, and some gigabytes.
const MOST_STEPS: f64 = 1e8;

impl Sweep {
    /// Speed of gear 1, rad/s, at which the mesh frequency meets the natural frequency of both discs on `constantStiffness`, the mean
    /// tangent stiffness at nominal torque.
    pub fn resonance_speed(&self, unit: &UnitFile) -> f64 {
        self.frequency(unit) / unit.geometry.gears[0].z()
    }

    /// That natural frequency, rad/s.
    fn frequency(&self, unit: &UnitFile) -> f64 {
        let geometry = &unit.geometry;
        let pitch = [0, 1].map(|i| geometry.operating_pitch_radius(i, geometry.center_distance));
        (unit.start(&VARIABLES[index::CONSTANT_STIFFNESS]) / self.reduced_mass(pitch)).sqrt()
    }

    /// Of both discs turning against one another, at these `radii`, m, in kg.
    fn reduced_mass(&self, radii: [f64; 2]) -> f64 {
        1.0 / (0..2)
            .map(|i| radii[i].powi(2) / self.inertia[i])
            .sum::<f64>()
    }

    /// Sweeps an FMU of these resources; `progress` gets the share that is done. The bearings of `shafts` hold at each time the loads of
    /// the mesh; masses that move across the axes are left out.
    ///
    /// # Errors
    /// Numbers out of range, and poses that the FMU refuses, with its reason.
    pub fn run(
        &self,
        unit: &UnitFile,
        tables: Option<&TableFile>,
        contact: Option<&ContactFile>,
        shafts: [Option<BearingShares>; 2],
        progress: &dyn Fn(f64),
    ) -> Result<RunUp, Refusal> {
        let geometry = &unit.geometry;
        let pitch = [0, 1].map(|i| geometry.operating_pitch_radius(i, geometry.center_distance));
        let base = [0, 1].map(|i| geometry.gears[i].base_radius());
        let stiffness = unit.start(&VARIABLES[index::CONSTANT_STIFFNESS]);
        let omega = self.frequency(unit);
        let z1 = geometry.gears[0].z();
        let [low, high] = self.speeds;
        let duration = match self.duration {
            Some(duration) => duration,
            None => 20.0 / (2.0 * (self.damping_ratio * omega).powi(2)) * (high - low) * z1,
        };
        let usual = (STEP_ANGLE / omega).min(TAU / (STEPS_PER_CYCLE * high * z1));
        let step = self.step.unwrap_or(usual);
        let damping = 2.0 * self.damping_ratio * (stiffness * self.reduced_mass(pitch)).sqrt();
        // Constant stiffness and contact at run time have no largest torque.
        let model = unit.start(&VARIABLES[index::STIFFNESS_MODEL]);
        let followed = tables.filter(|_| [TABLE, TEETH].contains(&model));
        let largest_torque = followed.map_or(f64::INFINITY, |tables| tables.maximum_torque_nm);
        self.check([duration, step], omega, largest_torque)?;

        let mut unit = unit.clone();
        unit.starts.extend(
            [
                (index::COUPLING, SEQUENTIAL),
                (index::DAMPING, damping),
                (index::EFFECTIVE_MASS, self.reduced_mass(base)),
            ]
            .map(|(i, value)| (VARIABLES[i].name.to_owned(), value)),
        );
        let resources = Resources::new(unit, tables.cloned(), contact.cloned());
        let resources = resources.map_err(Refusal::error)?;
        let mut discs = Discs::new(&Arc::new(resources), self, stiffness, pitch, step)?;
        discs.shafts = shafts;
        // The start is an equilibrium of the mean stiffness alone.
        let settle = match self.damping_ratio > 0.0 {
            true => duration.min(8.0 / (self.damping_ratio * omega)),
            false => 0.0,
        };
        discs.sweep([low, low], settle, &|_| {})?;
        let up = discs.sweep([low, high], duration, &|share| progress(0.5 * share))?;
        let down = discs.sweep([high, low], duration, &|share| progress(0.5 + 0.5 * share))?;
        Ok(RunUp {
            up,
            down,
            natural_frequency: omega / TAU,
            resonance_speed: omega / z1,
            damping,
            step,
            duration,
        })
    }

    /// Refuses what cannot be swept, the tables ending at `largest_torque`, N m, and the natural frequency being `omega`, rad/s.
    fn check(
        &self,
        [duration, step]: [f64; 2],
        omega: f64,
        largest_torque: f64,
    ) -> Result<(), Refusal> {
        let [one, two] = self.inertia;
        if !(one > 0.0 && two > 0.0 && one.min(two).is_finite()) {
            return refused(format!(
                "moments of inertia {one} and {two} kg m2: give two numbers > 0, of which one may be infinite"
            ));
        }
        let [low, high] = self.speeds;
        if !(low >= 0.0 && low < high && high.is_finite()) {
            return refused(format!(
                "speeds {low} to {high} rad/s: give the lowest, 0 or more, and a higher one"
            ));
        }
        if !(self.torque != 0.0 && self.torque.is_finite()) {
            return refused(format!(
                "torque {} N m: give a number other than 0",
                self.torque
            ));
        }
        if self.torque.abs() > largest_torque {
            return refused(format!(
                "torque {} N m: the tables end at {largest_torque} N m; give no more, or build them for it (`operating.maximum_torque_nm`)",
                self.torque
            ));
        }
        if !(self.damping_ratio >= 0.0 && self.damping_ratio < 1.0) {
            return refused(format!(
                "damping ratio {}: give a number from 0 to below 1",
                self.damping_ratio
            ));
        }
        if !(duration > 0.0 && duration.is_finite()) {
            return refused(format!(
                "time of each way {duration} s: without damping nothing decays, give a time > 0"
            ));
        }
        if !(step > 0.0 && step < duration) {
            return refused(format!(
                "step {step} s: give a step > 0 and below the time of each way, {duration} s"
            ));
        }
        let angle = omega * step;
        if angle > LARGEST_STEP_ANGLE {
            return refused(format!(
                "step {step} s: it is {angle:.2} rad of the natural frequency; where teeth part, swings are off by 5 % at \
                 {LARGEST_STEP_ANGLE} rad and by up to 30 % at 0.8; give {:.1e} s at most",
                // Two digits, rounded up, stay below the limit.
                0.95 * LARGEST_STEP_ANGLE / omega
            ));
        }
        if 2.0 * duration / step > MOST_STEPS {
            return refused(format!(
                "{:.2e} steps of {step:.2e} s: give less time for each way, or lower speeds",
                2.0 * duration / step
            ));
        }
        Ok(())
    }
}

/// What decides the variable `name` in a sweep, whatever its start value is; None where the start value counts.
pub fn decided_by(name: &str) -> Option<&'static str> {
    let of = |i: usize| VARIABLES[i].name;
    if name == of(index::DAMPING) {
        return Some("the damping ratio decides it; give --damping-ratio");
    }
    if name == of(index::EFFECTIVE_MASS) {
        return Some("the moments of inertia decide it; give --inertia-kg-m2");
    }
    if name == of(index::COUPLING) {
        return Some("the sweep sets it to sequential, as the FMU steps first; leave it out");
    }
    let is_rate = [".velocity[", ".angularVelocity["]
        .iter()
        .any(|part| name.contains(part));
    is_rate.then_some("the sweep sets how bodies move; leave it out, and give --speed-rpm")
}

/// Two discs on an FMU; their state is angle and rate of each beside the mean motion.
struct Discs {
    driven: Driven,
    inverse_inertia: [f64; 2],
    torque: [f64; 2],
    /// Turn of gear 2 for a turn of gear 1.
    ratio: f64,
    step: f64,
    /// Of gear 1 in its mean motion, rad.
    angle: f64,
    offset: [f64; 2],
    rate: [f64; 2],
    shafts: [Option<BearingShares>; 2],
}

/// Force and moment on each gear.
const WRENCHES: [[usize; 6]; 2] = {
    use index::*;
    [
        [
            GEAR1_FORCE_1,
            GEAR1_FORCE_2,
            GEAR1_FORCE_3,
            GEAR1_MOMENT_1,
            GEAR1_MOMENT_2,
            GEAR1_MOMENT_3,
        ],
        [
            GEAR2_FORCE_1,
            GEAR2_FORCE_2,
            GEAR2_FORCE_3,
            GEAR2_MOMENT_1,
            GEAR2_MOMENT_2,
            GEAR2_MOMENT_3,
        ],
    ]
};

impl Discs {
    fn new(
        resources: &Arc<Resources>,
        sweep: &Sweep,
        stiffness: f64,
        pitch: [f64; 2],
        step: f64,
    ) -> Result<Self, Refusal> {
        let geometry = &resources.unit.geometry;
        let ratio = -geometry.e() * geometry.gears[0].z() / geometry.gears[1].z();
        let approach = sweep.torque / pitch[0] / stiffness;
        let offset = match sweep.inertia[1].is_finite() {
            true => [0.0, -approach / pitch[1] * ratio.signum()],
            false => [approach / pitch[0], 0.0],
        };
        Ok(Self {
            driven: Driven::new(resources)?,
            inverse_inertia: sweep.inertia.map(f64::recip),
            torque: [sweep.torque, -sweep.torque / ratio],
            ratio,
            step,
            angle: 0.0,
            offset,
            rate: [0.0; 2],
            shafts: [None, None],
        })
    }

    /// Evenly from one of `speeds` to the other, rad/s.
    fn sweep(
        &mut self,
        speeds: [f64; 2],
        duration: f64,
        progress: &dyn Fn(f64),
    ) -> Result<History, Refusal> {
        const REPORTS: usize = 200;
        let step = self.step;
        let count = (duration / step).round() as usize;
        let change = (speeds[1] - speeds[0]) / (count.max(1) as f64 * step);
        let mean = |time: f64| {
            let angle = time * (speeds[0] + 0.5 * change * time);
            (angle, speeds[0] + change * time)
        };
        let mut history = History::default();
        for n in 0..count {
            if n % (count / REPORTS).max(1) == 0 {
                progress(n as f64 / count as f64);
            }
            let time = n as f64 * step;
            let (turned, speed) = mean(time);
            let angle = self.angle + turned;
            let angles = [angle + self.offset[0], self.ratio * angle + self.offset[1]];
            let rates = [speed + self.rate[0], self.ratio * speed + self.rate[1]];
            self.driven.turn(angles, rates)?;
            let unit = &mut self.driven.unit;
            unit.do_step(unit.time(), step)?;
            let [moment1, moment2, error, force, out] = self.driven.read([
                index::GEAR1_MOMENT_3,
                index::GEAR2_MOMENT_3,
                index::MESH_TRANSMISSION_ERROR,
                index::MESH_TANGENTIAL_FORCE,
                index::MESH_OUT_OF_RANGE,
            ])?;
            let moments = [moment1, moment2];
            for (gear, shaft) in self.shafts.iter().enumerate() {
                let Some(shaft) = shaft else { continue };
                let [fx, fy, fz, mx, my, mz] = self.driven.read(WRENCHES[gear])?;
                let forces = shaft.radial_forces([fx, fy, fz], [mx, my, mz]);
                let of_gear = &mut history.bearing_force[gear];
                for (bearing, force) in forces.enumerate() {
                    if of_gear.len() == bearing {
                        of_gear.push(Vec::with_capacity(count));
                    }
                    of_gear[bearing].push(force);
                }
            }
            history.time.push(time);
            history.angle.push(angles[0]);
            history.speed.push(rates[0]);
            history.transmission_error.push(error);
            history.tangential_force.push(force);
            history.out_of_range.push(out != 0.0);
            for (i, moment) in moments.into_iter().enumerate() {
                let acceleration = (self.torque[i] + moment) * self.inverse_inertia[i];
                history.acceleration[i].push(acceleration);
                self.offset[i] += step * (self.rate[i] + 0.5 * step * acceleration);
                self.rate[i] += step * acceleration;
            }
        }
        self.angle += mean(count as f64 * step).0;
        Ok(history)
    }
}

fn refused(reason: String) -> Result<(), Refusal> {
    Err(Refusal::error(reason))
}
