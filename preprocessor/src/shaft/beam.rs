//! One shaft: Timoshenko beams on bearings with radial clearance.
//!
//! A straight shaft of round sections on bearings that are alike in all radial directions bends alike in both planes through its
//! axis, and tension and torsion are apart from that. One matrix serves both planes; clearances alone tie them together.

use super::clearance::Clearances;
use super::section::{Rigidity, SAME_PLACE, shoulders};
use crate::gear::{Bearing, Shaft};
use gearmesh::gear::Gear;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// Pieces that a shaft is divided into at least, for the drawing of its deflection: under loads at its nodes the beams are exact.
const PIECES: f64 = 40.0;

/// A shaft with its bearings, held against turning at the end where the torque enters.
pub struct Beam {
    /// Nodes, m from the gear's own z = 0 face, ascending.
    pub z: Vec<f64>,
    bending: Cholesky<f64, Dyn>,
    tension: Cholesky<f64, Dyn>,
    /// Torsional rigidity G I_p of the element after each node, N m².
    torsion: Vec<f64>,
    torque_at_upper_end: bool,
    /// Each with its node.
    bearings: Vec<(usize, Bearing)>,
    /// Inverse of the deflections at the bearings (m) per radial force on them (N) in one plane, clearances closed.
    stiffness_at_bearings: DMatrix<f64>,
}

/// Forces (N) and moments (N m) on a node, or its displacements (m) and rotations (rad), in the axes of the carrier: x from gear 1 to
/// gear 2, z along the axis.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct AtNode {
    /// N, or m.
    pub linear: [f64; 3],
    /// N m, or rad.
    pub angular: [f64; 3],
}

impl AtNode {
    /// Makes this `scale` times the sum of both.
    pub(super) fn add_and_scale(&mut self, other: &AtNode, scale: f64) {
        for i in 0..3 {
            self.linear[i] = scale * (self.linear[i] + other.linear[i]);
            self.angular[i] = scale * (self.angular[i] + other.angular[i]);
        }
    }
}

/// What a bearing bears: force (N) and tilting moment (N m) of the housing on the shaft.
pub type BearingLoad = AtNode;

impl Beam {
    /// `shaft` of `gear`, with nodes at `places` (m from the gear's z = 0 face), at sections, bearings and between; None where its
    /// bearings do not hold it.
    pub fn new(shaft: &Shaft, gear: &Gear, places: &[f64]) -> Option<Beam> {
        let shoulders = shoulders(shaft);
        let ends = shoulders.iter().flat_map(|shoulder| shoulder.z);
        let z = nodes(shaft, ends.chain(places.iter().copied()));
        let count = z.len();
        let (mut bending, mut tension) = (
            DMatrix::zeros(2 * count, 2 * count),
            DMatrix::zeros(count, count),
        );
        let mut torsion = Vec::with_capacity(count - 1);
        for (i, ends) in z.windows(2).enumerate() {
            let length = ends[1] - ends[0];
            let middle = 0.5 * (ends[0] + ends[1]);
            let mut section = Rigidity::at(shaft, gear, middle);
            for shoulder in shoulders
                .iter()
                .filter(|s| s.z[0] < middle && middle < s.z[1])
            {
                section.bending /= shoulder.softer[0];
                section.shear /= shoulder.softer[1];
                section.torsion /= shoulder.softer[2];
            }
            let own = element(&section, length);
            let mut block = bending.view_mut((2 * i, 2 * i), (4, 4));
            block += own;
            let axial = section.tension / length;
            for (row, column, sign) in [(0, 0, 1.0), (0, 1, -1.0), (1, 0, -1.0), (1, 1, 1.0)] {
                tension[(i + row, i + column)] += sign * axial;
            }
            torsion.push(section.torsion);
        }
        let bearings = shaft.bearings.iter().map(|b| (nearest(&z, b.z), *b));
        let bearings: Vec<(usize, Bearing)> = bearings.collect();
        for (i, bearing) in &bearings {
            bending[(2 * i, 2 * i)] += bearing.radial_stiffness;
            bending[(2 * i + 1, 2 * i + 1)] += bearing.tilt_stiffness;
            tension[(*i, *i)] += bearing.axial_stiffness;
        }
        if bearings.iter().all(|(_, b)| b.axial_stiffness == 0.0) {
            // A spur gear, which has no axial force: any stiffness holds it.
            let (first, bearing) = bearings.first()?;
            tension[(*first, *first)] += bearing.radial_stiffness;
        }
        let bending = bending.cholesky()?;
        let mut at_bearings = DMatrix::zeros(bearings.len(), bearings.len());
        for (column, (node, _)) in bearings.iter().enumerate() {
            let mut force = DVector::zeros(2 * count);
            force[2 * node] = 1.0;
            bending.solve_mut(&mut force);
            for (row, (node, _)) in bearings.iter().enumerate() {
                at_bearings[(row, column)] = force[2 * node];
            }
        }
        Some(Beam {
            bending,
            tension: tension.cholesky()?,
            torsion,
            torque_at_upper_end: shaft.torque_at_upper_end,
            bearings,
            stiffness_at_bearings: at_bearings.try_inverse()?,
            z,
        })
    }

    /// Displacements and rotations of the nodes under `loads` on them, and what each bearing bears. The torque is taken up at
    /// its end.
    pub fn solve(&self, loads: &[AtNode]) -> (Vec<AtNode>, Vec<BearingLoad>) {
        self.solve_with(loads, |bent| self.lost_to_clearance(bent))
    }

    /// The same as if no bearing had clearance.
    pub fn solve_linear(&self, loads: &[AtNode]) -> (Vec<AtNode>, Vec<BearingLoad>) {
        self.solve_with(loads, |_| vec![[0.0; 2]; self.bearings.len()])
    }

    /// `lost` is what bearings bear less for their clearance.
    fn solve_with(
        &self,
        loads: &[AtNode],
        lost: impl Fn(&[DVector<f64>; 2]) -> Vec<[f64; 2]>,
    ) -> (Vec<AtNode>, Vec<BearingLoad>) {
        let count = self.z.len();
        // Slopes of both planes: du_x/dz is the rotation about y, du_y/dz that about x, reversed.
        let mut planes = [0, 1].map(|p| {
            DVector::from_fn(2 * count, |k, _| match (k % 2, p) {
                (0, _) => loads[k / 2].linear[p],
                (_, 0) => loads[k / 2].angular[1],
                _ => -loads[k / 2].angular[0],
            })
        });
        let mut bent = planes.each_ref().map(|load| self.bending.solve(load));
        let lost = lost(&bent);
        if lost.iter().flatten().any(|force| *force != 0.0) {
            for ((node, _), force) in self.bearings.iter().zip(&lost) {
                for (plane, force) in planes.iter_mut().zip(force) {
                    plane[2 * node] += force;
                }
            }
            bent = planes.each_ref().map(|load| self.bending.solve(load));
        }
        let axial = DVector::from_fn(count, |i, _| loads[i].linear[2]);
        let axial = self.tension.solve(&axial);
        let twist = self.twist(loads);
        let nodes: Vec<AtNode> = (0..count)
            .map(|i| AtNode {
                linear: [bent[0][2 * i], bent[1][2 * i], axial[i]],
                angular: [-bent[1][2 * i + 1], bent[0][2 * i + 1], twist[i]],
            })
            .collect();
        let bearings = self
            .bearings
            .iter()
            .zip(&lost)
            .map(|((node, bearing), lost)| {
                let AtNode { linear, angular } = nodes[*node];
                let [x, y] = [0, 1].map(|p| lost[p] - bearing.radial_stiffness * linear[p]);
                let [tilt_x, tilt_y] = [0, 1].map(|p| -bearing.tilt_stiffness * angular[p]);
                BearingLoad {
                    linear: [x, y, -bearing.axial_stiffness * linear[2]],
                    angular: [tilt_x, tilt_y, 0.0],
                }
            })
            .collect();
        (nodes, bearings)
    }

    /// Rotation of each node about the axis, rad, against the end at which the torque enters.
    fn twist(&self, loads: &[AtNode]) -> Vec<f64> {
        let count = self.z.len();
        let mut twist = vec![0.0; count];
        // Away from the held end every element passes on what enters beyond it.
        let beyond: f64 = loads.iter().map(|load| load.angular[2]).sum();
        let mut passed = beyond;
        for step in 1..count {
            let (here, before, element) = match self.torque_at_upper_end {
                false => (step, step - 1, step - 1),
                true => (count - 1 - step, count - step, count - 1 - step),
            };
            passed -= loads[before].angular[2];
            let length = self.z[element + 1] - self.z[element];
            twist[here] = twist[before] + passed * length / self.torsion[element];
        }
        twist
    }

    /// Force (N, in both planes) that each bearing bears less than it would without clearance, where the shaft would bend as `bent`.
    fn lost_to_clearance(&self, bent: &[DVector<f64>; 2]) -> Vec<[f64; 2]> {
        let count = self.bearings.len();
        let nothing = vec![[0.0; 2]; count];
        if self.bearings.iter().all(|(_, b)| b.free_radius == 0.0) {
            return nothing;
        }
        let displacements = DVector::from_fn(2 * count, |k, _| {
            bent[k / count][2 * self.bearings[k % count].0]
        });
        if displacements.norm() == 0.0 {
            return nothing;
        }
        let mut stiffness = DMatrix::zeros(2 * count, 2 * count);
        for plane in 0..2 {
            let mut block = stiffness.view_mut((plane * count, plane * count), (count, count));
            block.copy_from(&self.stiffness_at_bearings);
        }
        let bearings = self.bearings.iter().map(|(_, bearing)| *bearing).collect();
        Clearances {
            bearings,
            stiffness,
            displacements,
        }
        .lost()
    }
}

/// Ends of sections and of the seat, bearings, `places`, and as many between as a drawing needs, ascending.
fn nodes(shaft: &Shaft, places: impl Iterator<Item = f64>) -> Vec<f64> {
    let ends = shaft.section_ends();
    let (low, high) = (ends[0], ends[ends.len() - 1]);
    let mut all: Vec<f64> = (shaft.bearings.iter().map(|b| b.z))
        .chain(ends)
        .chain(shaft.seat)
        .chain(places)
        .filter(|z| (low..=high).contains(z))
        .collect();
    all.sort_by(f64::total_cmp);
    all.dedup_by(|b, a| *b - *a < SAME_PLACE);
    let longest = (high - low) / PIECES;
    let mut nodes = vec![all[0]];
    for ends in all.windows(2) {
        let pieces = ((ends[1] - ends[0]) / longest).ceil().max(1.0);
        let piece = (ends[1] - ends[0]) / pieces;
        nodes.extend((1..=pieces as usize).map(|k| match k as f64 == pieces {
            true => ends[1],
            false => ends[0] + piece * k as f64,
        }));
    }
    nodes
}

/// The node nearest to `place`.
pub fn nearest(z: &[f64], place: f64) -> usize {
    let after = z.partition_point(|z| *z < place).min(z.len() - 1);
    match after > 0 && place - z[after - 1] < z[after] - place {
        true => after - 1,
        false => after,
    }
}

/// Stiffness of a beam of the length `length` (m) by deflection and slope at both ends; exact for Timoshenko's beam.
fn element(section: &Rigidity, length: f64) -> DMatrix<f64> {
    let l = length;
    let phi = 12.0 * section.bending / (section.shear * l * l);
    let scale = section.bending / (l * l * l * (1.0 + phi));
    let (own, other) = ((4.0 + phi) * l * l, (2.0 - phi) * l * l);
    #[rustfmt::skip]
    let values = [
        12.0, 6.0 * l, -12.0, 6.0 * l,
        6.0 * l, own, -6.0 * l, other,
        -12.0, -6.0 * l, 12.0, -6.0 * l,
        6.0 * l, other, -6.0 * l, own,
    ];
    scale * DMatrix::from_row_slice(4, 4, &values)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gear::ShaftSection;
    use crate::samples;
    use approx::{assert_abs_diff_eq, assert_relative_eq};
    use gearmesh::gear::GearKind;
    use std::f64::consts::PI;

    const E: f64 = 206e9;
    const SPAN: f64 = 0.2;
    const RADIUS: f64 = 15e-3;

    fn bearing(z: f64) -> Bearing {
        Bearing {
            z,
            radial_stiffness: 2e8,
            axial_stiffness: 0.0,
            tilt_stiffness: 0.0,
            free_radius: 0.0,
        }
    }

    /// A uniform shaft from 0 to `length` on bearings at 0 and [`SPAN`], without a seat.
    fn shaft(length: f64) -> Shaft {
        Shaft {
            start: 0.0,
            sections: vec![ShaftSection {
                radii: [0.0, RADIUS],
                length,
            }],
            bearings: vec![bearing(0.0), bearing(SPAN)],
            torque_at_upper_end: false,
            youngs_modulus: E,
            poisson_ratio: 0.3,
            seat: [0.05, 0.06],
            seat_radius: 0.0,
        }
    }

    fn beam(shaft: &Shaft, places: &[f64]) -> Beam {
        let gear = samples::gear(GearKind::External, 20, 1.0, 0.0, 0.0);
        Beam::new(shaft, &gear, places).unwrap()
    }

    /// Displacement at each node and bearing loads under `load` at `z`.
    fn solved(beam: &Beam, z: f64, load: AtNode) -> (Vec<AtNode>, Vec<BearingLoad>) {
        let mut loads = vec![AtNode::default(); beam.z.len()];
        loads[nearest(&beam.z, z)] = load;
        beam.solve(&loads)
    }

    fn force(x: f64, y: f64, z: f64) -> AtNode {
        AtNode {
            linear: [x, y, z],
            ..AtNode::default()
        }
    }

    /// E I, and k G A with Cowper's 6 (1 + nu) / (7 + 6 nu).
    fn rigidities() -> [f64; 2] {
        let shear_modulus = E / 2.6;
        let factor = 7.8 / 8.8;
        [
            E * PI * RADIUS.powi(4) / 4.0,
            factor * shear_modulus * PI * RADIUS * RADIUS,
        ]
    }

    #[test]
    fn an_overhung_force_bends_span_overhang_and_bearings_as_in_closed_form() {
        let (a, p) = (0.07, 1000.0);
        let beam = beam(&shaft(SPAN + a), &[]);
        let (nodes, bearings) = solved(&beam, SPAN + a, force(p, 0.0, 0.0));
        let [bending, shear] = rigidities();
        let bent = p * a * a * (SPAN + a) / (3.0 * bending) + p * a * (1.0 + a / SPAN) / shear;
        let [far, near] = [-p * a / SPAN, p * (1.0 + a / SPAN)].map(|f| f / 2e8);
        let sprung = near + (near - far) * a / SPAN;
        assert_relative_eq!(
            nodes.last().unwrap().linear[0],
            bent + sprung,
            max_relative = 1e-9
        );
        assert_relative_eq!(bearings[0].linear[0], p * a / SPAN, max_relative = 1e-9);
        assert_relative_eq!(
            bearings[1].linear[0],
            -p * (1.0 + a / SPAN),
            max_relative = 1e-9
        );
    }

    #[test]
    fn a_force_between_two_bearings_has_the_closed_form_of_timoshenkos_beam() {
        let beam = beam(&shaft(SPAN), &[0.5 * SPAN]);
        let (nodes, _) = solved(&beam, 0.5 * SPAN, force(0.0, 1000.0, 0.0));
        let [bending, shear] = rigidities();
        let middle = SPAN.powi(3) / (48.0 * bending) + 0.25 * SPAN / shear + 0.5 / 2e8;
        let found = nodes[nearest(&beam.z, 0.5 * SPAN)];
        assert_relative_eq!(found.linear[1], 1000.0 * middle, max_relative = 1e-9);
        assert_abs_diff_eq!(found.linear[0], 0.0);
        // A slope du_y/dz turns about -x.
        let first = 1000.0 * SPAN * SPAN / (16.0 * bending);
        assert_relative_eq!(nodes[0].angular[0], -first, max_relative = 1e-9);
    }

    #[test]
    fn torque_winds_up_a_stepped_hollow_shaft_from_the_end_where_it_enters() {
        let mut stepped = shaft(0.1);
        stepped.sections.push(ShaftSection {
            radii: [5e-3, 10e-3],
            length: 0.15,
        });
        let torque = 50.0;
        let shear_modulus = E / 2.6;
        let polar = |inner: f64, outer: f64| 0.5 * PI * (outer.powi(4) - inner.powi(4));
        let load = AtNode {
            angular: [0.0, 0.0, torque],
            ..AtNode::default()
        };
        let of_first = torque * 0.1 / (shear_modulus * polar(0.0, RADIUS));
        // With the deflection of the shoulder beside the first section, q = 10 / 15.
        let q = 10.0 / 15.0f64;
        let more = 3.0 * PI / 32.0 * 10e-3 * (1.0 - 4.0 * q.powi(3) + 3.0 * q.powi(4));
        let of_second = torque * (0.08 + more) / (shear_modulus * polar(5e-3, 10e-3));
        let lower = beam(&stepped, &[0.18]);
        let (nodes, _) = solved(&lower, 0.18, load);
        let wound = of_first + of_second;
        assert_relative_eq!(
            nodes[nearest(&lower.z, 0.18)].angular[2],
            wound,
            max_relative = 1e-12
        );
        assert_relative_eq!(
            nodes.last().unwrap().angular[2],
            wound,
            max_relative = 1e-12
        );
        stepped.torque_at_upper_end = true;
        let upper = beam(&stepped, &[0.18]);
        let (nodes, _) = solved(&upper, 0.18, load);
        let wound = torque * 0.07 / (shear_modulus * polar(5e-3, 10e-3));
        assert_relative_eq!(nodes[0].angular[2], wound, max_relative = 1e-12);
    }

    #[test]
    fn bearing_forces_balance_any_load() {
        let mut held = shaft(0.25);
        held.bearings[0].axial_stiffness = 1e8;
        held.bearings[1].tilt_stiffness = 3e4;
        held.bearings[1].free_radius = 4e-6;
        let beam = beam(&held, &[0.13]);
        let load = AtNode {
            linear: [700.0, -300.0, 250.0],
            angular: [20.0, -15.0, 0.0],
        };
        let (_, bearings) = solved(&beam, 0.13, load);
        let [ax, ay, az] = load.linear;
        let mut sums = [
            ax,
            ay,
            az,
            load.angular[0] - 0.13 * ay,
            load.angular[1] + 0.13 * ax,
        ];
        for ((_, at), b) in beam.bearings.iter().zip(&bearings) {
            let [x, y, z] = b.linear;
            let part = [x, y, z, b.angular[0] - at.z * y, b.angular[1] + at.z * x];
            sums.iter_mut()
                .zip(part)
                .for_each(|(sum, part)| *sum += part);
        }
        for sum in sums {
            assert_abs_diff_eq!(sum, 0.0, epsilon = 1e-6);
        }
    }

    #[test]
    fn clearance_moves_the_shaft_by_itself_in_the_direction_of_the_force() {
        let tight = beam(&shaft(SPAN), &[0.5 * SPAN]);
        let mut loose = shaft(SPAN);
        loose
            .bearings
            .iter_mut()
            .for_each(|b| b.free_radius = 10e-6);
        let loose = beam(&loose, &[0.5 * SPAN]);
        let load = force(600.0, 800.0, 0.0);
        let [(a, _), (b, bearings)] = [&tight, &loose].map(|beam| solved(beam, 0.5 * SPAN, load));
        for (a, b) in a.iter().zip(&b) {
            assert_abs_diff_eq!(b.linear[0] - a.linear[0], 6e-6, epsilon = 1e-12);
            assert_abs_diff_eq!(b.linear[1] - a.linear[1], 8e-6, epsilon = 1e-12);
        }
        for bearing in bearings {
            assert_relative_eq!(bearing.linear[0], -300.0, max_relative = 1e-7);
        }
    }

    #[test]
    fn a_bearing_in_its_clearance_bears_nothing() {
        // Overhung: the far bearing lifts by 1e-6 m times its share, less than the clearance.
        let mut three = shaft(SPAN);
        three.bearings.push(bearing(0.1));
        three.bearings[2].free_radius = 1e-3;
        let beam = beam(&three, &[0.05]);
        let (_, bearings) = solved(&beam, 0.05, force(1000.0, 0.0, 0.0));
        assert_abs_diff_eq!(bearings[2].linear[0], 0.0, epsilon = 1e-5);
        assert_relative_eq!(bearings[0].linear[0], -750.0, max_relative = 1e-7);
    }

    #[test]
    fn the_body_of_a_gear_stiffens_the_shaft_as_a_thicker_one_does() {
        let mut seated = shaft(SPAN);
        (seated.seat, seated.seat_radius) = ([0.08, 0.12], 30e-3);
        let mut thick = shaft(0.08);
        thick.sections.push(ShaftSection {
            radii: [0.0, 30e-3],
            length: 0.04,
        });
        thick.sections.push(ShaftSection {
            radii: [0.0, RADIUS],
            length: 0.08,
        });
        let found = [seated, thick].map(|shaft| {
            let beam = beam(&shaft, &[0.1]);
            let (nodes, _) = solved(&beam, 0.1, force(1000.0, 0.0, 0.0));
            nodes[nearest(&beam.z, 0.1)].linear[0]
        });
        // Alike but for the shear factor of a ring about a cylinder.
        assert_relative_eq!(found[0], found[1], max_relative = 0.005);
    }
}
