//! Shafts on bearings in static contact: how far they take the flanks apart along the face, and what that does to the contact.
//!
//! A force F_bt on the line of action at the place z of the face acts on gear 2 along n = (e sin phi, s sc cos phi, -s h tan beta_b) in
//! the axes of the carrier (docs/theory/element.md) and on gear 1 against it, at the pitch point. With displacement u, rotation theta and
//! the arm r_g of the pitch point from the axis of gear g, the flanks close there by
//!
//! closing(z) = n . [(u_1 + theta_1 x r_1) - (u_2 + theta_2 x r_2)],
//!
//! and the load on the shafts is its transpose, so that work is kept. Contact beside the pitch line, at the distance y along the path, has
//! the additional lever sigma y on the slope of the axes, as a misalignment has.
//!
//! The body of a gear moves with its shaft at every z; the shaft has the section of the body where that sits. How far teeth and body
//! deflect against the shaft is the finite-element model's, with the gear held at its bore.

mod beam;
mod clearance;
mod section;

use crate::gear::{Pair, Shaft};
use crate::static_contact::{
    ContactError, ContactResult, ContactSolver, Deflection, PositionProblem,
};
use gearmesh::contact::{Failure, Prescribed};
use gearmesh::gear::{Flank, Gear, PairGeometry};
use nalgebra::{DMatrix, DVector};

pub use beam::{AtNode, BearingLoad};
use beam::{Beam, nearest};

/// Places along the common face at which contact and shafts meet.
const STATIONS: usize = 41;
/// Change of the closing from one solve to the next at which both agree, m: a thousandth of a micrometre, and a part of its range.
const TOLERANCE: f64 = 1e-9;
const RELATIVE_TOLERANCE: f64 = 1e-5;
const MAXIMUM_ITERATIONS: usize = 60;

/// Torques over the largest at which [`misalignment_range`] tries the shafts: with clearance the largest need not be the worst.
const TRIED: [f64; 4] = [0.1, 0.3, 0.6, 1.0];
/// Parts by which, and least misalignment (rad) to which, that range is wider than what was found.
const MARGIN: f64 = 0.25;
const LEAST_MARGIN: f64 = 0.1e-3;
/// To which it is rounded outwards, rad.
const STEP: f64 = 0.01e-3;

/// The shafts of a pair under its mesh, on one flank and at one centre distance.
pub struct Shafts {
    /// Places along the face, m in gear 1's frame.
    z: Vec<f64>,
    sides: [Option<Side>; 2],
    /// Force on gear 2 per force on the line of action.
    normal: [f64; 3],
    /// sigma = s h tan beta_b.
    lean: f64,
    z_ref: f64,
    base_pitch: f64,
    /// How far a force at each place opens the flanks at every other, m/N, without clearances.
    flexibility: DMatrix<f64>,
}

struct Side {
    beam: Beam,
    /// Node of each place.
    nodes: Vec<usize>,
    /// +1 gear 1, -1 gear 2: sense of its displacement in the closing.
    sense: f64,
    /// x of the pitch point from the axis, m.
    arm: f64,
    /// Closing per rotation about the axis, m.
    turn: f64,
}

/// Shafts under a load of the mesh. Lengths on the line of action in the transverse plane, m; > 0 closes.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ShaftState {
    /// Places along the common face, m in gear 1's frame.
    pub z: Vec<f64>,
    /// What the shafts close there over mid-face: bending, torsion, and the tilt under axial forces.
    pub closing: Vec<f64>,
    /// What torsion alone closes there over mid-face.
    pub torsion: Vec<f64>,
    /// Misalignment of the axes at mid-face as the multibody element defines it, n . (a_1 - a_2), rad.
    pub misalignment: f64,
    /// How far the gears deflect at mid-face through both shafts and their bearings, torsion up to where the torques enter included.
    pub approach: f64,
    /// What each bearing bears, of gear 1 and gear 2.
    pub bearings: [Vec<BearingLoad>; 2],
    /// The axis of each shaft: z (m from the gear's own z = 0 face), and how it is displaced there.
    pub axes: [Vec<(f64, AtNode)>; 2],
}

impl ShaftState {
    /// How much less bending closes both ends of the face than its middle, m.
    pub fn bow(&self) -> f64 {
        let (last, middle) = (self.z.len() - 1, self.z.len() / 2);
        let [low, middle, high] = [0, middle, last].map(|i| self.closing[i] - self.torsion[i]);
        middle - 0.5 * (low + high)
    }

    /// How much more torsion closes the end of large z than that of small z, m.
    pub fn torsion_over_face(&self) -> f64 {
        self.torsion[self.torsion.len() - 1] - self.torsion[0]
    }

    /// The mean of `states` over a mesh cycle.
    pub fn mean(states: &[ShaftState]) -> Option<ShaftState> {
        let mut all = states.first()?.clone();
        let share = 1.0 / states.len() as f64;
        for (k, state) in states.iter().enumerate().skip(1) {
            let scale = if k + 1 == states.len() { share } else { 1.0 };
            let lists = [
                (&mut all.closing, &state.closing),
                (&mut all.torsion, &state.torsion),
            ];
            for (sums, values) in lists {
                for (sum, value) in sums.iter_mut().zip(values) {
                    *sum = scale * (*sum + value);
                }
            }
            all.misalignment = scale * (all.misalignment + state.misalignment);
            all.approach = scale * (all.approach + state.approach);
            for i in 0..2 {
                for (sum, next) in all.bearings[i].iter_mut().zip(&state.bearings[i]) {
                    sum.add_and_scale(next, scale);
                }
                for (sum, next) in all.axes[i].iter_mut().zip(&state.axes[i]) {
                    sum.1.add_and_scale(&next.1, scale);
                }
            }
        }
        Some(all)
    }
}

/// Loads of the mesh at the places along the face: force on the line of action, N, and that times sigma y, N m.
type MeshLoad = [f64; 2];

impl Shafts {
    /// The shafts `given` under the mesh of `geometry` on `flank`, `center_distance_offset` (m) from the nominal centre distance;
    /// None where neither gear has one.
    pub fn new(
        geometry: &PairGeometry,
        given: &[Option<Shaft>; 2],
        flank: Flank,
        center_distance_offset: f64,
    ) -> Option<Shafts> {
        let c = geometry.center_distance + center_distance_offset;
        let (s, e, sc) = (flank.sign(), geometry.e(), geometry.sc());
        let phi = geometry.operating_pressure_angle(c);
        let lean = s * geometry.gears[0].hand * geometry.base_helix_angle().tan();
        let (low, width) = geometry.face_overlap();
        let z: Vec<f64> = (0..STATIONS)
            .map(|i| low + width * i as f64 / (STATIONS - 1) as f64)
            .collect();
        let arms = [
            sc * geometry.operating_pitch_radius(0, c),
            sc * geometry.operating_pitch_radius(0, c) - c,
        ];
        let turns = [
            s * geometry.gears[0].base_radius(),
            s * e * geometry.gears[1].base_radius(),
        ];
        let sides = [0, 1].map(|i| {
            let gear = &geometry.gears[i];
            let own: Vec<f64> = z.iter().map(|z| z - gear.face_offset).collect();
            let beam = Beam::new(given[i].as_ref()?, gear, &own)?;
            Some(Side {
                nodes: own.iter().map(|z| nearest(&beam.z, *z)).collect(),
                beam,
                sense: [1.0, -1.0][i],
                arm: arms[i],
                turn: turns[i],
            })
        });
        if sides.iter().all(Option::is_none) {
            return None;
        }
        let mut shafts = Shafts {
            sides,
            normal: [e * phi.sin(), s * sc * phi.cos(), -lean],
            lean,
            z_ref: geometry.z_ref(),
            base_pitch: geometry.base_pitch(),
            flexibility: DMatrix::zeros(STATIONS, STATIONS),
            z,
        };
        for column in 0..STATIONS {
            let mut load = vec![[0.0; 2]; STATIONS];
            load[column][0] = 1.0;
            for side in shafts.sides.iter().flatten() {
                // Linear without clearances: then the bearings lose nothing.
                let (nodes, _) = side.beam.solve_linear(&side.loads(&shafts, &load));
                for row in 0..STATIONS {
                    let [closing, ..] = side.closing(&shafts, &nodes[side.nodes[row]]);
                    shafts.flexibility[(row, column)] -= closing;
                }
            }
        }
        Some(shafts)
    }

    /// How the shafts stand under `loads` of the mesh.
    fn under(&self, loads: &[MeshLoad]) -> ShaftState {
        let mut state = ShaftState {
            z: self.z.clone(),
            closing: vec![0.0; STATIONS],
            torsion: vec![0.0; STATIONS],
            ..ShaftState::default()
        };
        let middle = STATIONS / 2;
        for (i, side) in self.sides.iter().enumerate() {
            let Some(side) = side else { continue };
            let (nodes, bearings) = side.beam.solve(&side.loads(self, loads));
            for (place, node) in side.nodes.iter().enumerate() {
                let [closing, torsion, tilt] = side.closing(self, &nodes[*node]);
                state.closing[place] += closing;
                state.torsion[place] += torsion;
                if place == middle {
                    state.misalignment += tilt;
                }
            }
            state.bearings[i] = bearings;
            state.axes[i] = side.beam.z.iter().copied().zip(nodes).collect();
        }
        state.approach = -state.closing[middle];
        for values in [&mut state.closing, &mut state.torsion] {
            let there = values[middle];
            values.iter_mut().for_each(|value| *value -= there);
        }
        state
    }

    /// The force `force` (N) on the line of action spread evenly over the face.
    fn under_even(&self, force: f64) -> ShaftState {
        let mut shares = [[force / (STATIONS - 1) as f64, 0.0]; STATIONS];
        shares[0][0] *= 0.5;
        shares[STATIONS - 1][0] *= 0.5;
        self.under(&shares)
    }

    /// Range of the closing along the face under the torque `torque` (N m on gear 1) spread evenly over it, m.
    pub fn range(&self, geometry: &PairGeometry, torque: f64) -> f64 {
        let state = self.under_even(torque / geometry.gears[0].base_radius());
        let largest = state
            .closing
            .iter()
            .copied()
            .fold(f64::NEG_INFINITY, f64::max);
        let least = state.closing.iter().copied().fold(f64::INFINITY, f64::min);
        largest - least
    }

    /// Forces of `result` at the places, each segment's shared by the two nearest, and the length of face that bears about each, m.
    fn loads(
        &self,
        result: &ContactResult,
        mesh_position: f64,
        cos_beta_b: f64,
    ) -> (Vec<MeshLoad>, Vec<f64>) {
        let mut loads = vec![[0.0; 2]; STATIONS];
        let mut bearing = vec![0.0; STATIONS];
        let step = (self.z[STATIONS - 1] - self.z[0]) / (STATIONS - 1) as f64;
        for segment in result.segments.iter().filter(|s| s.force > 0.0) {
            let z = 0.5 * (segment.z[0] + segment.z[1]);
            let place = ((z - self.z[0]) / step).clamp(0.0, (STATIONS - 1) as f64);
            let first = (place as usize).min(STATIONS - 2);
            let y = (mesh_position + f64::from(segment.tooth_pair)) * self.base_pitch
                + self.lean * (z - self.z_ref);
            let force = cos_beta_b * segment.force;
            for (node, share) in [
                (first, 1.0 - (place - first as f64)),
                (first + 1, place - first as f64),
            ] {
                loads[node][0] += share * force;
                loads[node][1] += share * force * self.lean * y;
                bearing[node] += share * (segment.z[1] - segment.z[0]);
            }
        }
        (loads, bearing)
    }

    /// Newton's step of the closing to where the shafts would have it, `residual` away: the teeth as springs along the face, which together
    /// are as stiff as the mesh, `stiffness` (N/m), over the lengths `bearing` (m) that bear, under a constant sum of forces.
    fn step(&self, bearing: &[f64], stiffness: f64, residual: DVector<f64>) -> DVector<f64> {
        let all: f64 = bearing.iter().sum();
        if all == 0.0 {
            return residual;
        }
        let springs = DMatrix::from_fn(STATIONS, STATIONS, |i, j| {
            let own = if i == j { bearing[i] } else { 0.0 };
            stiffness / all * (own - bearing[i] * bearing[j] / all)
        });
        let mut jacobian = &self.flexibility * springs;
        // Closings count from mid-face.
        let there = jacobian.row(STATIONS / 2).into_owned();
        for mut row in jacobian.row_iter_mut() {
            row -= &there;
        }
        for i in 0..STATIONS {
            jacobian[(i, i)] += 1.0;
        }
        jacobian.lu().solve(&residual).unwrap_or(residual)
    }

    /// Contact of `problem` (of `solver` on `flank` at `mesh_position`, without deflection) under `torque` (N m on gear 1) and, with the
    /// shafts unloaded, `misalignment` (rad), in equilibrium with the shafts: their closing under the forces of the contact is that under
    /// which it was solved, to a nanometre and a hundred-thousandth of the range of the closing. `before` is a solution nearby.
    ///
    /// Newton's iteration on the closing, in which teeth deflect about as a row of springs. `problem` is left without deflection.
    ///
    /// # Errors
    /// As [`PositionProblem::solve_torque`]; [`Failure::NotConverged`] where both do not agree.
    pub fn solve(
        &self,
        solver: &ContactSolver,
        problem: &mut PositionProblem,
        at: (Flank, f64),
        [torque, misalignment]: [f64; 2],
        before: Option<(&ContactResult, &ShaftState)>,
    ) -> Result<(ContactResult, ShaftState), ContactError> {
        let cos_beta_b = solver.geometry().base_helix_angle().cos();
        let mut present = Deflection::default();
        let mut closing = before.map_or(vec![0.0; STATIONS], |(_, state)| state.closing.clone());
        let mut warm = before.map(|(result, _)| result.clone());
        let mut over_range = f64::INFINITY;
        let mut outcome = None;
        for _ in 0..MAXIMUM_ITERATIONS {
            let points = self
                .z
                .iter()
                .zip(&closing)
                .map(|(z, closing)| [*z, *closing]);
            let next = Deflection::new(points.collect())?;
            solver.deflect(problem, at, [&present, &next])?;
            present = next;
            let result = match problem.solve_torque(torque, misalignment, warm.as_ref()) {
                Ok(result) => result,
                Err(error) => {
                    outcome = Some(Err(error));
                    break;
                }
            };
            let (loads, bearing) = self.loads(&result, at.1, cos_beta_b);
            let state = self.under(&loads);
            let residual = DVector::from_fn(STATIONS, |i, _| state.closing[i] - closing[i]);
            let largest = residual.amax();
            let range = state
                .closing
                .iter()
                .fold(0.0, |most: f64, c| most.max(c.abs()));
            if largest <= TOLERANCE + RELATIVE_TOLERANCE * range {
                outcome = Some(Ok((result, state)));
                break;
            }
            over_range = largest / range;
            let step = self.step(&bearing, result.tangent.force_by_approach, residual);
            (closing.iter_mut().zip(&step)).for_each(|(c, step)| *c += step);
            warm = Some(result);
        }
        solver.deflect(problem, at, [&present, &Deflection::default()])?;
        outcome.unwrap_or_else(|| {
            let failure = Failure::NotConverged {
                iterations: MAXIMUM_ITERATIONS,
                residual: over_range,
            };
            let torque = Prescribed::Torque(torque);
            Err(problem
                .contact
                .unsolved(torque, misalignment, failure)
                .into())
        })
    }
}

impl Side {
    /// `loads` of the mesh as forces and moments on the nodes.
    fn loads(&self, shafts: &Shafts, loads: &[MeshLoad]) -> Vec<AtNode> {
        let mut all = vec![AtNode::default(); self.beam.z.len()];
        let [nx, ny, nz] = shafts.normal;
        for (node, [force, couple]) in self.nodes.iter().zip(loads) {
            let [force_on_axis, couple_on_axis] = [-self.sense * force, -self.sense * couple];
            let AtNode { linear, angular } = &mut all[*node];
            for (sum, n) in linear.iter_mut().zip(shafts.normal) {
                *sum += force_on_axis * n;
            }
            // The tilt of the axes is n_x theta_y - n_y theta_x.
            angular[0] -= couple_on_axis * ny;
            angular[1] += couple_on_axis * nx - force_on_axis * nz * self.arm;
            angular[2] -= force * self.turn;
        }
        all
    }

    /// What this shaft closes at `node`, what its torsion closes of that, m, and what it tilts in the plane of action, rad.
    fn closing(&self, shafts: &Shafts, node: &AtNode) -> [f64; 3] {
        let AtNode { linear, angular } = node;
        let [nx, ny, nz] = shafts.normal;
        let along: f64 = linear.iter().zip(shafts.normal).map(|(u, n)| u * n).sum();
        let torsion = self.turn * angular[2];
        let bending = self.sense * (along - nz * self.arm * angular[1]);
        let tilt = self.sense * (nx * angular[1] - ny * angular[0]);
        [bending + torsion, torsion, tilt]
    }
}

/// How the bearings of a shaft share force and moment on its gear, without clearances. Of two bearings that do not resist tilting this
/// is statics, and clearances change nothing.
#[derive(Debug, Clone)]
pub struct BearingShares {
    /// Of each bearing, per N along x, y and z and per N m about x and y, at mid-face on the axis.
    shares: Vec<[BearingLoad; 5]>,
    /// z of mid-face from the gear's own z = 0 face, m.
    middle: f64,
}

impl BearingShares {
    /// Of `shaft` with `gear` on it; None where the bearings do not hold it.
    pub fn new(shaft: &Shaft, gear: &Gear) -> Option<BearingShares> {
        let middle = 0.5 * gear.face_width;
        let beam = Beam::new(shaft, gear, &[middle])?;
        let node = nearest(&beam.z, middle);
        let mut shares = vec![[BearingLoad::default(); 5]; shaft.bearings.len()];
        for part in 0..5 {
            let mut loads = vec![AtNode::default(); beam.z.len()];
            match part {
                0..=2 => loads[node].linear[part] = 1.0,
                _ => loads[node].angular[part - 3] = 1.0,
            }
            let (_, bearings) = beam.solve_linear(&loads);
            for (share, bearing) in shares.iter_mut().zip(bearings) {
                share[part] = bearing;
            }
        }
        Some(BearingShares { shares, middle })
    }

    /// Radial force of each bearing, N, under `force` (N) and `moment` (N m) on the gear, about the point of its axis in its z = 0 face.
    pub fn radial_forces(
        &self,
        force: [f64; 3],
        moment: [f64; 3],
    ) -> impl Iterator<Item = f64> + '_ {
        let [fx, fy, fz] = force;
        let parts = [
            fx,
            fy,
            fz,
            moment[0] + self.middle * fy,
            moment[1] - self.middle * fx,
        ];
        self.shares.iter().map(move |share| {
            let [x, y] = [0, 1].map(|axis| {
                let of = share.iter().zip(parts);
                of.map(|(bearing, part)| bearing.linear[axis] * part)
                    .sum::<f64>()
            });
            x.hypot(y)
        })
    }
}

/// Whether the bearings of `shaft` hold it with `gear`, to the precision of numbers.
pub fn is_held(shaft: &Shaft, gear: &Gear) -> bool {
    Beam::new(shaft, gear, &[]).is_some()
}

/// The pair as its contact on shafts takes it: teeth that are cut from a shaft are held inside of the teeth and not at the ends of
/// `gear.shaft.lower` and `upper`, since the beams have all that bends and twists there.
pub fn held_by_its_shafts(pair: &Pair) -> Pair {
    let mut pair = pair.clone();
    for (gear, shaft) in pair.geometry.gears.iter_mut().zip(&pair.shafts) {
        if shaft.is_some() && gear.body.is_some_and(|body| body.is_shaft()) {
            gear.body = None;
            gear.held_radius = gear.held_radius.max(0.5 * gear.root_radius());
        }
    }
    pair
}

/// Misalignments that the shafts of `pair` cause up to its largest torque on either flank, with a margin, rad: under a load in the middle
/// of the face, as much as or more than under that of the contact, which moves to where the flanks close. None without shafts.
pub fn misalignment_range(
    geometry: &PairGeometry,
    shafts: &[Option<Shaft>; 2],
    maximum_torque: f64,
) -> Option<[f64; 2]> {
    let mut range = [0.0f64; 2];
    for flank in [Flank::Drive, Flank::Coast] {
        let shafts = Shafts::new(geometry, shafts, flank, 0.0)?;
        for part in TRIED {
            let force = part * maximum_torque / geometry.gears[0].base_radius();
            let found = shafts.under_even(force).misalignment;
            range = [range[0].min(found), range[1].max(found)];
        }
    }
    let margin = (MARGIN * (range[1] - range[0])).max(LEAST_MARGIN);
    let [low, high] =
        [range[0] - margin, range[1] + margin].map(|end| (end.abs() / STEP - 1e-6).ceil() * STEP);
    Some([-low, high])
}

/// How far the gears deflect at mid-face through shafts and bearings under the torque `torque` (N m on gear 1), on the flank on which it
/// is more, m. None without shafts.
pub fn approach(geometry: &PairGeometry, shafts: &[Option<Shaft>; 2], torque: f64) -> Option<f64> {
    let force = torque / geometry.gears[0].base_radius();
    let [drive, coast] = [Flank::Drive, Flank::Coast].map(|flank| {
        Shafts::new(geometry, shafts, flank, 0.0).map(|s| s.under_even(force).approach)
    });
    Some(drive?.abs().max(coast?.abs()))
}

#[cfg(test)]
mod tests;
