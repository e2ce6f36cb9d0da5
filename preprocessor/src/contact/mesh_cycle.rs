//! Quasi-static contact over one mesh cycle: harmonics, stiffness and load along the face of it.

use std::f64::consts::TAU;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use rayon::prelude::*;

use crate::gear::Shaft;
use crate::pair::LARGEST_DEFLECTION;
use crate::static_contact::{
    ContactError, ContactResult, ContactSolver, EdgeLoad, PositionProblem, SegmentLoad,
};
use gearmesh::friction::{FrictionLaw, Sliding};
use gearmesh::gear::{Flank, Gear, PairGeometry};
use gearmesh::words::count;

use crate::shaft::{ShaftState, Shafts};

/// Loaded segments along a contact line that tell its largest pressure to some 4 %; two of them tell it 25 % too low.
pub const ENOUGH_SEGMENTS: usize = 6;

/// Pressure times the sum of (1 - nu²) / E of both flanks that leaves a dent in hardened steel: 4 GPa there (ISO 76).
const LARGEST_PRESSURE: f64 = 0.0353;

/// Flank and positions of a mesh cycle; its load is a [`LoadCase`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CycleInput {
    /// Loaded flank of gear 1.
    pub flank: Flank,
    /// Deviation from the nominal centre distance, m.
    pub center_distance_offset: f64,
    /// Number of equidistant positions, from 0 on.
    pub positions: usize,
}

impl CycleInput {
    /// Of gears with this `geometry`, m.
    pub fn center_distance(&self, geometry: &PairGeometry) -> f64 {
        geometry.center_distance + self.center_distance_offset
    }
}

/// One mesh cycle.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MeshCycle {
    /// Mesh positions i / N, base pitches.
    pub mesh_position: Vec<f64>,
    /// The solution at each.
    pub results: Vec<ContactResult>,
    /// Approach of first touch at each, m.
    pub no_load_approach: Vec<f64>,
    /// STE at each position if contact stayed where the undeformed flanks come closest, m.
    pub held_ste: Vec<f64>,
    /// How the load slides at each, every segment counted alike.
    pub sliding: Vec<Sliding>,
    /// The same with the weights of the pair's law of friction.
    pub friction: Vec<Sliding>,
    /// The shafts at each, where the gears have any.
    pub shafts: Vec<ShaftState>,
    /// Wall clock of the whole cycle, s; of cycles that were solved together their mean.
    pub solve_seconds: f64,
}

/// The load of a mesh cycle.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LoadCase {
    /// Torque on gear 1, N m, >= 0.
    pub torque: f64,
    /// Misalignment in the plane of action, rad.
    pub misalignment: f64,
}

impl LoadCase {
    /// Each of `torques` (N m) with each of `misalignments` (rad), the misalignment fastest.
    pub fn matrix(torques: &[f64], misalignments: &[f64]) -> Vec<LoadCase> {
        let mut loads = Vec::with_capacity(torques.len() * misalignments.len());
        for &torque in torques {
            for &misalignment in misalignments {
                loads.push(LoadCase {
                    torque,
                    misalignment,
                });
            }
        }
        loads
    }
}

/// What a load does at a position.
struct Solved {
    contact: ContactResult,
    shafts: Option<ShaftState>,
    /// Approach at which unloaded flanks touch, m.
    no_load_approach: f64,
    /// Approach under the load if contact stayed where undeformed flanks touch, m.
    held_approach: f64,
    /// Without friction, and with that of the pair.
    sliding: [Sliding; 2],
}

/// Solves `position` under `load`, from the solution `before` of a near load.
fn solve_at(
    solver: &ContactSolver,
    shafts: Option<&Shafts>,
    position: &mut PositionProblem,
    (flank, tau): (Flank, f64),
    load: &LoadCase,
    before: Option<&Solved>,
) -> Result<Solved, ContactError> {
    let (torque, misalignment) = (load.torque, load.misalignment);
    let (contact, shafts) = match shafts {
        Some(shafts) => {
            let warm = before.and_then(|before| Some((&before.contact, before.shafts.as_ref()?)));
            let load = [torque, misalignment];
            let (contact, state) = shafts.solve(solver, position, (flank, tau), load, warm)?;
            (contact, Some(state))
        }
        None => {
            let warm = before.map(|before| &before.contact);
            (position.solve_torque(torque, misalignment, warm)?, None)
        }
    };
    let laws = [FrictionLaw::default(), solver.friction()];
    Ok(Solved {
        shafts,
        no_load_approach: position.no_load_approach(misalignment),
        held_approach: position.approach_of_held_contact(misalignment, &contact)?,
        sliding: laws.map(|law| solver.sliding(position, &contact, &law)),
        contact,
    })
}

impl MeshCycle {
    /// Solves all positions under `load`, in parallel, without shafts.
    ///
    /// # Errors
    /// [`Input`](gearmesh::contact::ContactError::Input) for no positions, else the first error of a position.
    pub fn solve(
        solver: &ContactSolver,
        input: &CycleInput,
        load: LoadCase,
    ) -> Result<MeshCycle, ContactError> {
        let mut cycles = MeshCycle::solve_all(solver, &[None, None], input, &[load], &|_| ())?;
        cycles
            .pop()
            .ok_or_else(|| ContactError::input("load cases", 0.0, "give at least 1"))
    }

    /// Solves a cycle for each of `cases`, in their order, with each gear that has one on its shaft of
    /// `shafts`: the misalignment is then that of the unloaded shafts. The influence matrix of a position serves all cases.
    /// `progress` is told the share that is done, from any thread.
    ///
    /// # Errors
    /// As [`MeshCycle::solve`].
    pub fn solve_all(
        solver: &ContactSolver,
        shafts: &[Option<Shaft>; 2],
        input: &CycleInput,
        cases: &[LoadCase],
        progress: &(dyn Fn(f64) + Sync),
    ) -> Result<Vec<MeshCycle>, ContactError> {
        let n = input.positions;
        if n == 0 {
            let remedy = "give at least 1; 21 or more for ten harmonics";
            return Err(ContactError::input("positions", 0.0, remedy));
        }
        let begin = Instant::now();
        let mesh_position: Vec<f64> = (0..n).map(|i| i as f64 / n as f64).collect();
        let done = AtomicUsize::new(0);
        let geometry = solver.geometry();
        let shafts = Shafts::new(geometry, shafts, input.flank, input.center_distance_offset);
        let largest = cases.iter().map(|case| case.torque).fold(0.0, f64::max);
        // Where the shafts open the flanks the others approach by as much more.
        let range = (shafts.as_ref()).map_or(0.0, |s| 2.0 * s.range(geometry, largest));
        let solver = &solver
            .clone()
            .followed_to(solver.setup().followed_approach + range);
        let solved = mesh_position.par_iter().map(|tau| {
            let mut at = solver.position(input.flank, *tau, input.center_distance_offset)?;
            let mut solved: Vec<Solved> = Vec::with_capacity(cases.len());
            for case in cases {
                // The case before is a near one.
                let before = solved.last();
                let place = (input.flank, *tau);
                let found = solve_at(solver, shafts.as_ref(), &mut at, place, case, before)?;
                solved.push(found);
                let count = done.fetch_add(1, Ordering::Relaxed) + 1;
                progress(count as f64 / (n * cases.len()) as f64);
            }
            Ok(solved)
        });
        let solved = solved.collect::<Result<Vec<_>, ContactError>>()?;
        let empty = MeshCycle {
            mesh_position,
            solve_seconds: begin.elapsed().as_secs_f64() / cases.len().max(1) as f64,
            ..MeshCycle::default()
        };
        let mut cycles = vec![empty; cases.len()];
        for position in solved {
            for (cycle, found) in cycles.iter_mut().zip(position) {
                let [sliding, friction] = found.sliding;
                cycle.results.push(found.contact);
                cycle.shafts.extend(found.shafts);
                cycle.no_load_approach.push(found.no_load_approach);
                cycle.held_ste.push(found.held_approach);
                cycle.sliding.push(sliding);
                cycle.friction.push(friction);
            }
        }
        Ok(cycles)
    }

    /// STE at each position, m on the line of action at mid-face.
    pub fn ste(&self) -> Vec<f64> {
        self.results.iter().map(|r| r.approach).collect()
    }

    /// Mean STE, m.
    pub fn mean_ste(&self) -> f64 {
        self.ste().iter().sum::<f64>() / self.results.len() as f64
    }

    /// Highest minus lowest STE, m.
    pub fn peak_to_peak_ste(&self) -> f64 {
        peak_to_peak(&self.ste())
    }

    /// By how much contact that moves along the profile of bent teeth changes mean and peak-to-peak STE, over those of contact that stays;
    /// zero without load.
    pub fn share_of_bent_teeth(&self) -> [f64; 2] {
        let sum: f64 = self.held_ste.iter().sum();
        let held = [
            sum / self.held_ste.len() as f64,
            peak_to_peak(&self.held_ste),
        ];
        let free = [self.mean_ste(), self.peak_to_peak_ste()];
        [0, 1].map(|i| match held[i] > 0.0 {
            true => free[i] / held[i] - 1.0,
            false => 0.0,
        })
    }

    /// Largest Hertz pressure of the cycle inside the flanks, Pa.
    pub fn max_pressure(&self) -> f64 {
        let pressures = self.results.iter().map(|r| r.max_pressure);
        pressures.fold(0.0, f64::max)
    }

    /// Largest line load of the cycle at a tip edge, if contact reaches one.
    pub fn edge_load(&self) -> Option<EdgeLoad> {
        let loads = self.results.iter().map(|r| r.edge_load);
        loads.fold(None, EdgeLoad::larger)
    }

    /// What rests on fewer than [`ENOUGH_SEGMENTS`] loaded segments of a contact line, and comes out too low for it; None where nothing does.
    pub fn note_on_segments(&self) -> Option<String> {
        let mut fewest = ENOUGH_SEGMENTS;
        let mut values = Vec::new();
        let pressure: fn(&SegmentLoad) -> f64 = |segment| segment.pressure;
        for (value, name) in [
            (pressure, "the largest flank pressure"),
            (
                |segment| segment.edge.map_or(0.0, |edge| edge.line_load),
                "the largest line load at a tip edge",
            ),
        ] {
            let lines = self.results.iter().map(|result| &result.segments);
            let all = lines.flat_map(|line| line.iter().map(move |top| (line, top)));
            let top = all.max_by(|a, b| value(a.1).total_cmp(&value(b.1)));
            let Some((segments, top)) = top.filter(|(_, top)| value(top) > 0.0) else {
                continue;
            };
            let of_pair = segments.iter().filter(|s| s.tooth_pair == top.tooth_pair);
            let loaded = of_pair.filter(|s| s.force > 0.0).count();
            if loaded < ENOUGH_SEGMENTS {
                values.push(name);
                fewest = fewest.min(loaded);
            }
        }
        (!values.is_empty()).then(|| {
            format!(
                "{}: from only {} of a contact line ({ENOUGH_SEGMENTS} are enough), so too low; give more --stations",
                values.join(" and "),
                count(fewest, "loaded segment"),
            )
        })
    }

    /// What is beyond linear elasticity with small deflections, on teeth of `geometry`; None where nothing is.
    pub fn note_on_elasticity(&self, geometry: &PairGeometry) -> Option<String> {
        let approaches = self.results.iter().zip(&self.no_load_approach);
        let deflections = approaches.map(|(result, no_load)| result.approach - no_load);
        let deflection = deflections.fold(0.0, f64::max);
        let share = deflection / geometry.gears[0].normal_module;
        let gears = geometry.gears.each_ref();
        let compliances = gears.map(Gear::plane_compliance);
        let pressure = self.max_pressure();
        let too_soft = (share > LARGEST_DEFLECTION).then(|| {
            format!(
                "the teeth deflect by {:.0} um, {:.0} % of the module",
                1e6 * deflection,
                100.0 * share
            )
        });
        let too_hard = (pressure * (compliances[0] + compliances[1]) > LARGEST_PRESSURE)
            .then(|| format!("the flanks bear {:.0} MPa", 1e-6 * pressure));
        let both: Vec<String> = too_soft.into_iter().chain(too_hard).collect();
        (!both.is_empty()).then(|| {
            format!(
                "{}: beyond linear elasticity, from which all results are; it holds for teeth that deflect by up to {:.0} % of \
                 the module, and for pressures up to what leaves a dent (ISO 76: 4 GPa on steel)",
                both.join(" and "),
                100.0 * LARGEST_DEFLECTION
            )
        })
    }

    /// Largest KKT residual of the cycle.
    pub fn kkt_residual(&self) -> f64 {
        let residuals = self.results.iter().map(|r| r.kkt_residual);
        residuals.fold(0.0, f64::max)
    }

    /// Harmonics of the STE, m.
    pub fn harmonics(&self) -> [Option<Harmonic>; HARMONICS] {
        harmonics(&self.ste())
    }

    /// Tangent mesh stiffness dF_bt / d STE at each position, N/m in the transverse plane along the line of action.
    pub fn stiffness(&self) -> Vec<f64> {
        let results = self.results.iter();
        results.map(|r| r.tangent.force_by_approach).collect()
    }

    /// The mean of [`MeshCycle::stiffness`], N/m.
    pub fn mean_stiffness(&self) -> f64 {
        self.stiffness().iter().sum::<f64>() / self.results.len() as f64
    }

    /// Tooth pairs that bear load anywhere in the cycle, ascending.
    pub fn tooth_pairs(&self) -> Vec<i32> {
        let shares = self.results.iter().flat_map(|r| &r.load_share);
        let mut pairs: Vec<i32> = shares.filter(|s| s.1 > 0.0).map(|s| s.0).collect();
        pairs.sort_unstable();
        pairs.dedup();
        pairs
    }

    /// Load along the common face in the stations of `solver`.
    pub fn face_load(&self, solver: &ContactSolver) -> FaceLoad {
        let (low, width) = solver.geometry().face_overlap();
        // Turns normal forces into those in the transverse plane.
        let cos_base_helix = solver.geometry().base_helix_angle().cos();
        let stations = solver.settings().stations;
        let high = low + width;
        let step = (high - low) / stations as f64;
        let mut load = vec![0.0; stations];
        for segment in self.results.iter().flat_map(|result| &result.segments) {
            let middle = 0.5 * (segment.z[0] + segment.z[1]);
            let station = (middle - low) / step;
            load[(station as usize).min(stations - 1)] += segment.force * cos_base_helix;
        }
        let per_width = step * self.results.len() as f64;
        load.iter_mut().for_each(|load| *load /= per_width);
        let z = (0..stations).map(|i| low + step * (i as f64 + 0.5));
        FaceLoad {
            z: z.collect(),
            load,
        }
    }
}

pub(super) fn peak_to_peak(values: &[f64]) -> f64 {
    let lowest = values.iter().copied().fold(f64::INFINITY, f64::min);
    let highest = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    highest - lowest
}

/// Harmonics of the mesh frequency that are reported.
pub const HARMONICS: usize = 10;

/// One harmonic of a quantity over the mesh cycle: amplitude cos(2 pi order mesh_position + phase).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Harmonic {
    /// Unit of the quantity.
    pub amplitude: f64,
    /// rad, in (-pi, pi].
    pub phase: f64,
}

/// Harmonics 1 to [`HARMONICS`] of `values` at even positions over one cycle; None for those that so few
/// positions cannot tell apart (from half their number on).
pub fn harmonics(values: &[f64]) -> [Option<Harmonic>; HARMONICS] {
    let n = values.len();
    std::array::from_fn(|h| {
        let order = h + 1;
        if 2 * order >= n {
            return None;
        }
        let (mut cos, mut sin) = (0.0, 0.0);
        for (i, value) in values.iter().enumerate() {
            let angle = TAU * (order * i % n) as f64 / n as f64;
            cos += value * angle.cos();
            sin += value * angle.sin();
        }
        Some(Harmonic {
            amplitude: 2.0 / n as f64 * cos.hypot(sin),
            phase: (-sin).atan2(cos),
        })
    })
}

/// Load per face width along the face: the mean over the mesh cycle of the transverse force on the line of
/// action of all tooth pairs.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FaceLoad {
    /// Middles of the stations, m in gear 1's frame.
    pub z: Vec<f64>,
    /// N/m.
    pub load: Vec<f64>,
}

impl FaceLoad {
    /// Face load factor K_Hbeta in the sense of ISO 6336-1: the largest load per face width over the mean. 0 without
    /// load.
    pub fn face_load_factor(&self) -> f64 {
        let mean = self.load.iter().sum::<f64>() / self.load.len() as f64;
        let largest = self.load.iter().copied().fold(0.0, f64::max);
        if mean > 0.0 { largest / mean } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gearmesh::gear::GearKind;

    #[test]
    fn harmonics_rebuild_what_they_were_made_of() {
        let wave =
            |tau: f64| 3.0 + 0.5 * (TAU * tau + 0.3).cos() + 0.2 * (TAU * 10.0 * tau - 2.0).cos();
        let values: Vec<f64> = (0..32).map(|i| wave(f64::from(i) / 32.0)).collect();
        let found = harmonics(&values);
        let [first, tenth] = [found[0].unwrap(), found[9].unwrap()];
        assert!((first.amplitude - 0.5).abs() < 1e-14 && (first.phase - 0.3).abs() < 1e-13);
        assert!((tenth.amplitude - 0.2).abs() < 1e-14 && (tenth.phase + 2.0).abs() < 1e-13);
        assert!(found[1..9].iter().all(|h| h.unwrap().amplitude < 1e-14));
    }

    #[test]
    fn an_even_load_has_the_factor_one_and_a_triangle_two() {
        let of = |load: Vec<f64>| FaceLoad { z: vec![], load }.face_load_factor();
        assert_eq!(of(vec![2.0; 5]), 1.0);
        assert!((of((0..=1000).map(f64::from).collect()) - 2.0).abs() < 1e-12);
        assert_eq!(of(vec![0.0; 5]), 0.0);
    }

    #[test]
    fn deflections_and_pressures_beyond_linear_elasticity_are_said() {
        let gears = [20, 20].map(|z| crate::samples::gear(GearKind::External, z, 1.0, 0.0, 0.0));
        let geometry = PairGeometry {
            gears,
            center_distance: 80e-3,
        };
        let note = |approach: f64, no_load: f64, pressure: f64| {
            let result = ContactResult {
                approach,
                max_pressure: pressure,
                ..ContactResult::default()
            };
            let cycle = MeshCycle {
                results: vec![result],
                no_load_approach: vec![no_load],
                ..MeshCycle::default()
            };
            cycle.note_on_elasticity(&geometry)
        };
        let module = geometry.gears[0].normal_module;
        // Modifications open a gap that no load has closed.
        assert_eq!(note(0.1 * module, 0.07 * module, 3.5e9), None);
        let soft = note(0.4 * module, 0.07 * module, 3.5e9).unwrap();
        assert!(soft.contains("33 % of the module: beyond"), "{soft}");
        let hard = note(0.0, 0.0, 6e9).unwrap();
        assert!(hard.starts_with("the flanks bear 6000 MPa: "), "{hard}");
    }
}
