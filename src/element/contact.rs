//! From poses and velocities to loads: both flanks under load, each with its elastic force, damper and friction.
//!
//! Tables know small departures from the nominal position. Gears that are pulled apart, radially or
//! along their axes, must still end without force, and without a jump on the way. So the potential of
//! each flank is multiplied by a factor ([`Engagement`]) that is one as long as at least half of the nominal face
//! overlap and half of the path of contact (at most half a base pitch of it) are left, and zero
//! where nothing is left; between them a quintic step, C2. Its slopes enter the loads, so energy is
//! kept on the way out, too.

use super::constants::{Constants, FLANKS};
use super::dual::{Scalar, fraction, lift, whole_turns, wrap};
use super::kinematics::{Coordinates, Map};
use super::law::{Extras, Workspace};
use super::motion::{ElementError, Inputs, Motion, Outputs, PhaseOffset};
use super::paper::Carried;
use super::{Element, Formulation, Parameters};
use crate::gear::teeth::Counts;
use crate::table::{Effects, LoadJet, LoadSpline, Table};
use nalgebra::Vector3;

/// A pose as the formulation sees it.
pub(crate) struct Pose<T> {
    /// Coordinates; x before the phase offset, not wrapped.
    pub coordinates: Coordinates<T>,
    /// Lever of M in the penetration that the law takes, m; zero but for the paper's (19).
    pub lever: T,
    /// Rates and generalised forces.
    pub map: Map<T>,
    /// The paper's formulation: the pose in the carrier.
    carried: Option<Carried<T>>,
}

impl<T: Scalar> Pose<T> {
    /// Errors: axes that do not run alike, base circles without a common tangent.
    #[inline(always)]
    pub(crate) fn new(el: &Element, inputs: &Inputs) -> Result<Self, ElementError> {
        let k = &el.constants;
        let formulation = el.parameters.formulation;
        let map = Map::new(k, formulation, &inputs.gears)?;
        if formulation == Formulation::Conjugate || !map.in_reach {
            return Ok(Pose {
                coordinates: map.coordinates(k, &inputs.gears),
                lever: T::from(0.0),
                map,
                carried: None,
            });
        }
        let carried = Carried::new(k, inputs)?;
        Ok(Pose {
            coordinates: carried.coordinates(k),
            lever: if el.parameters.misalignment_effect {
                carried.middle
            } else {
                T::from(0.0)
            },
            map,
            carried: Some(carried),
        })
    }

    /// Mesh position of flank `i` before the phase offset, (13).
    #[inline(always)]
    pub(crate) fn mesh_position(&self, k: &Constants, i: usize) -> T {
        self.coordinates.mesh_angle * (-FLANKS[i].sign() / k.pitch_angle) + k.mesh_zero[i]
    }

    /// Mesh cycles that passed on gear 1 and gear 2 under flank `i`, from the pose alone: the whole part of the mesh position,
    /// which starts anew with every turn of gear 1, and on gear 2 that less the whole turns of the tooth angle, in
    /// which both gears differ.
    pub(crate) fn counts(&self, k: &Constants, i: usize, phase: &PhaseOffset<T>) -> Counts {
        let s = FLANKS[i].sign();
        let first = (self.mesh_position(k, i).re() + s * phase.mesh_position.re()).floor();
        let angle = self.coordinates.turn.re() / k.per_tooth_angle + phase.tooth_angle.re();
        [first as i64, (first - s * whole_turns(angle)) as i64]
    }

    /// Flank `i` without load, with the part `x` (m) of its penetration that is odd in its sign.
    #[inline(always)]
    fn unloaded(&self, k: &Constants, i: usize, x: T, phase: &PhaseOffset<T>) -> FlankLoad<T> {
        let sign = FLANKS[i].sign();
        let zero = T::from(0.0);
        FlankLoad {
            sign,
            penetration: x * sign - self.coordinates.half_gap,
            misalignment: self.misalignment(i),
            mesh_position: fraction(self.mesh_position(k, i) + phase.mesh_position * sign),
            elastic: zero,
            arm: zero,
            damping: zero,
            energy: zero,
            stiffness: zero,
        }
    }

    /// Misalignment of flank `i`.
    #[inline(always)]
    pub(crate) fn misalignment(&self, i: usize) -> T {
        let [even, odd] = self.coordinates.misalignment;
        even + odd * FLANKS[i].sign()
    }
}

/// Loads of one flank.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FlankLoad<T> {
    /// +1 drive, -1 coast.
    pub sign: f64,
    /// Penetration of the unmodified involutes that counts as transmission error, s x - H, m.
    pub penetration: T,
    /// Misalignment, rad.
    pub misalignment: T,
    /// Position on the mesh cycle, 0..1.
    pub mesh_position: T,
    /// Elastic force on the line of action dU/d delta, N, >= 0; zero: no contact.
    pub elastic: T,
    /// z_c - z_ref, m; zero out of contact.
    pub arm: T,
    /// Force of the damper on the line of action, N, >= -`elastic`.
    damping: T,
    /// Elastic energy U, J.
    energy: T,
    /// Elastic tangent stiffness on the line of action, N/m.
    stiffness: T,
}

impl<T: Scalar> FlankLoad<T> {
    /// Total force on the line of action, N, >= 0.
    #[inline(always)]
    pub(crate) fn force(&self) -> T {
        self.elastic + self.damping
    }

    /// The quantities of a table over elastic force, centre distance offset (m), misalignment and mesh position, without the
    /// `effects` that are off. `mirrored`: the table is that of the drive flank, and this the coast flank.
    #[inline(always)]
    pub(crate) fn tabulated<const N: usize>(
        &self,
        (table, mirrored): (&LoadSpline, bool),
        effects: &Effects,
        center_distance_offset: T,
    ) -> [T; N] {
        let zero = T::from(0.0);
        let if_on = |effect: bool, x: T| if effect { x } else { zero };
        let sign = if mirrored { -1.0 } else { 1.0 };
        let q = [
            self.elastic,
            if_on(effects.center_distance, center_distance_offset),
            if_on(effects.misalignment, self.misalignment * sign),
            self.mesh_position,
        ];
        let jets: [LoadJet; N] = table.evaluate(q.map(T::re));
        jets.map(|jet| lift(jet.value, &jet.gradient, &q))
    }
}

/// Damper on the line of action.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Damper {
    /// Rises with the elastic force: teeth that meet feel no jump. N s/m, and the force, N, from which on it
    /// acts in full.
    Rising { coefficient: f64, full_at: f64 },
    /// The constant c of the paper's (8), N s/m tangential.
    Constant { tangential: f64 },
}

impl Damper {
    /// That of the formulation.
    pub(crate) fn new(p: &Parameters, k: &Constants) -> Self {
        match p.formulation {
            Formulation::Conjugate => Damper::Rising {
                coefficient: p.damping / k.cos_phi.powi(2),
                full_at: p.damping_onset * k.nominal_force,
            },
            Formulation::Paper => Damper::Constant {
                tangential: p.damping,
            },
        }
    }

    /// Force of the damper, N, on the line of action, beside the elastic force `elastic` > 0 while the flanks approach at
    /// `rate`, m/s. It has the sign of the rate at every state, so that its power -f rate is never positive,
    /// and never pulls by more than the flanks press: the sum of both forces is >= 0.
    ///
    /// Rising: r c rate, r the cubic step of Adams' IMPACT function (MSC Software, Adams/Solver guide, "IMPACT")
    /// with force in place of penetration. Where the flanks part so fast that it would take off more than
    /// half of the elastic force, it takes off y - (y - 1/2)^2 / 2 of it in place of y, and all from y = 3/2
    /// on: the force has a continuous slope. Constant: c rate / cos^2(phi), cut off as in the paper.
    #[inline(always)]
    pub(crate) fn force<T: Scalar>(&self, elastic: T, rate: T, cos_phi: T) -> T {
        match *self {
            Damper::Rising {
                coefficient,
                full_at,
            } => {
                let share = elastic * (1.0 / full_at);
                let ramp = if share.re() < 1.0 {
                    share * share * (-share * 2.0 + 3.0)
                } else {
                    T::from(1.0)
                };
                let force = ramp * rate * coefficient;
                if force.re() >= -0.5 * elastic.re() {
                    return force;
                }
                let taken = -force / elastic;
                if taken.re() >= 1.5 {
                    return -elastic;
                }
                let beyond = taken - 0.5;
                -elastic * (taken - beyond * beyond * 0.5)
            }
            Damper::Constant { tangential } => {
                let force = rate * tangential / (cos_phi * cos_phi);
                if force.re() > -elastic.re() {
                    force
                } else {
                    -elastic
                }
            }
        }
    }
}

/// Loads and diagnostics at `inputs`, and what they were made of.
pub(crate) struct Solution<T: Scalar> {
    pub outputs: Outputs<T>,
    /// `None`: the gears are out of reach of one another.
    pub mesh: Option<Mesh<T>>,
}

/// What loads are made of.
pub(crate) struct Mesh<T> {
    /// Rates of the coordinates.
    pub rates: Coordinates<T>,
    pub flanks: [FlankLoad<T>; 2],
}

impl<T: Scalar> Solution<T> {
    /// At `inputs`; `stiffness_slopes` as for [`Law::respond`](super::law::Law::respond).
    #[inline(always)]
    pub(crate) fn new(
        el: &Element,
        phase: &PhaseOffset<T>,
        inputs: &Inputs,
        stiffness_slopes: bool,
        workspace: &mut Workspace,
    ) -> Result<Self, ElementError> {
        let k = &el.constants;
        let pose = Pose::<T>::new(el, inputs)?;
        let (q, c) = (&pose.coordinates, pose.coordinates.center_distance);
        if !pose.map.in_reach {
            let point = in_world(&inputs.gears[0], pose.map.near_pitch_point(T::from(0.0)));
            return Ok(Solution {
                outputs: Outputs {
                    contact_point: point,
                    center_distance: c,
                    contact_z: T::from(k.z_ref),
                    out_of_range: true,
                    ..Outputs::default()
                },
                mesh: None,
            });
        }
        let cos_phi = c.recip() * k.base_sum;
        let twist = pose.map.twist(&inputs.gears);
        let rates = pose.map.rates(&twist);
        let mesh = Engagement::new(k, c, q.axial);
        let x = wrap(q.turn * (1.0 / k.per_tooth_angle) + phase.tooth_angle) * k.per_tooth_angle;

        let mut out_of_range = mesh.leaving;
        let zero = T::from(0.0);
        let mut flanks = [pose.unloaded(k, 0, x, phase), pose.unloaded(k, 1, x, phase)];
        // By the coordinates, of both flanks.
        let mut slopes = Coordinates::default();
        let mut extras = [None; 2];
        for (i, (flank, law)) in flanks.iter_mut().zip(&el.laws).enumerate() {
            let Some(law) = law else { continue };
            let scale = el.law_scale(cos_phi);
            let counts = if law.tells_teeth_apart {
                pose.counts(k, i, phase)
            } else {
                [0; 2]
            };
            let coordinates = [
                (flank.penetration + flank.misalignment * pose.lever) * scale,
                c - k.center_distance,
                flank.misalignment,
                flank.mesh_position,
            ];
            let response = law.respond(
                coordinates,
                counts,
                stiffness_slopes,
                &mut workspace.0[i],
                &mut extras[i],
            )?;
            out_of_range |= response.out_of_range;
            // The potential is U = (engagement) W.
            let elastic = response.gradient[0] * mesh.factor;
            if elastic.re() <= 0.0 {
                continue;
            }
            out_of_range |= el.have_passed(flank.penetration.re(), q.half_gap.re())?;
            let s = flank.sign;
            flank.elastic = elastic;
            flank.arm = response.gradient[2] / response.gradient[0];
            flank.energy = response.energy * mesh.factor;
            flank.stiffness = response.stiffness * mesh.factor * scale;
            // The damper opposes the rate of approach, and acts along its slopes.
            let by_misalignment = match el.parameters.formulation {
                Formulation::Conjugate => flank.arm,
                Formulation::Paper => pose.lever,
            };
            let [even, odd] = rates.misalignment;
            let approach = rates.turn * s - rates.half_gap + (even + odd * s) * by_misalignment;
            flank.damping = el.damper.force(elastic, approach, cos_phi);
            let (mut force, mut moment) = (flank.damping, flank.damping * by_misalignment);
            if pose.carried.is_none() {
                force += elastic;
                moment += elastic * flank.arm;
                slopes.center_distance +=
                    response.gradient[1] * mesh.factor + response.energy * mesh.by_center_distance;
                slopes.mesh_angle += response.gradient[3] * mesh.factor * (-s / k.pitch_angle);
                slopes.axial += response.energy * mesh.by_axial_position;
            }
            slopes.turn += force * s;
            slopes.half_gap -= force;
            slopes.misalignment[0] += moment;
            slopes.misalignment[1] += moment * s;
        }

        let mut on_2 = pose.map.wrench(&slopes);
        let (index, flank) = carrying_flank(&flanks, el.reference_flank);
        let (mut friction_power, mut friction_coefficient, mut loss_factor) = (zero, zero, zero);
        if let Some(friction) = &el.friction {
            for (i, load) in flanks.iter().enumerate() {
                if load.elastic.re() <= 0.0 {
                    continue;
                }
                let spin = -rates.mesh_angle;
                let tabulated = || friction.tabulated(i, load, c - k.center_distance);
                let found = extras[i].map(|[a, b, c, d, ..]| [a, b, c, d]);
                let Some(sliding) = found.or_else(tabulated) else {
                    continue;
                };
                let found = friction.on_flank(k, &pose.map, load, sliding, &twist, spin);
                on_2.add(&found.row, found.force);
                friction_power -= found.force * found.speed;
                if i == index {
                    friction_coefficient = found.coefficient;
                    loss_factor = found.loss_factor;
                }
            }
        }
        let mut loads = pose.map.on_gears(&on_2);
        if let Some(carried) = &pose.carried {
            carried.add_elastic_loads(k, &flanks, &mut loads);
        }
        let root_stress = match (el.parameters.root_stress, &el.root_stress) {
            (false, _) => [zero; 2],
            (true, Some(table)) => tabulated_root_stress(table, k, c, &flanks),
            (true, None) => found_root_stress(&extras, mesh.factor),
        };
        let shown = &flanks[index];
        let reference = &flanks[el.reference_flank];
        let (contact_point, contact_z) = match &pose.carried {
            None => (pose.map.near_pitch_point(shown.arm), shown.arm + k.z_ref),
            Some(carried) => carried.contact(k, shown.arm),
        };
        let rate = rates.turn * reference.sign - rates.half_gap;
        let per_base_sum = reference.sign / k.base_sum;
        let [drive, coast] = &flanks;
        let force = drive.force() + coast.force();
        let outputs = Outputs {
            force: [loads[0].linear, loads[1].linear],
            moment: [loads[0].angular, loads[1].angular],
            contact_point: in_world(&inputs.gears[0], contact_point),
            transmission_error: reference.penetration * c * per_base_sum,
            transmission_error_rate: (rate * c + reference.penetration * rates.center_distance)
                * per_base_sum,
            mesh_position: shown.mesh_position,
            center_distance: c,
            misalignment: shown.misalignment,
            tangential_force: force * cos_phi,
            normal_force: force * k.per_cos_beta_b,
            stiffness: (drive.stiffness + coast.stiffness) * cos_phi * cos_phi,
            contact_z,
            energy: drive.energy + coast.energy,
            friction_power,
            friction_coefficient,
            loss_factor,
            root_stress,
            flank,
            out_of_range,
        };
        Ok(Solution {
            outputs,
            mesh: Some(Mesh { rates, flanks }),
        })
    }
}

/// The point `from_origin` beyond the origin of `gear`, whose derivatives by its own motion are not among the directions.
#[inline(always)]
fn in_world<T: Scalar>(gear: &Motion, from_origin: Vector3<T>) -> Vector3<T> {
    let [x, y, z] = from_origin.into();
    Vector3::new(x + gear.p.x, y + gear.p.y, z + gear.p.z)
}

/// Index of the flank that carries the larger elastic force and its sign; the `reference` flank and 0 where
/// none does.
#[inline(always)]
fn carrying_flank<T: Scalar>(flanks: &[FlankLoad<T>; 2], reference: usize) -> (usize, i32) {
    let [drive, coast] = [flanks[0].elastic.re(), flanks[1].elastic.re()];
    if drive <= 0.0 && coast <= 0.0 {
        (reference, 0)
    } else if drive >= coast {
        (0, 1)
    } else {
        (1, -1)
    }
}

/// Stress in the roots of gear 1 and gear 2 under the loads of both `flanks`, Pa: the larger one.
///
/// Apart from the loads, which most FMUs compute alone.
#[inline(never)]
fn tabulated_root_stress<T: Scalar>(
    table: &Table,
    k: &Constants,
    center_distance: T,
    flanks: &[FlankLoad<T>; 2],
) -> [T; 2] {
    let mut largest = [T::from(0.0); 2];
    for (load, flank) in flanks.iter().zip(FLANKS) {
        if load.elastic.re() <= 0.0 {
            continue;
        }
        let Some(stress) = table.root_stress(flank) else {
            continue;
        };
        let offset = center_distance - k.center_distance;
        let stress: [T; 2] = load.tabulated(stress, table.effects(), offset);
        for (largest, stress) in largest.iter_mut().zip(stress) {
            *largest = larger(*largest, stress);
        }
    }
    largest
}

/// The same as the sources of both flanks found it, under loads that count `factor` times.
#[inline(never)]
fn found_root_stress<T: Scalar>(extras: &[Option<Extras<T>>; 2], factor: T) -> [T; 2] {
    let stress = |i: usize| {
        let found = extras.iter().flatten().map(|extras| extras[4 + i] * factor);
        found.fold(T::from(0.0), larger)
    };
    [stress(0), stress(1)]
}

#[inline]
fn larger<T: Scalar>(a: T, b: T) -> T {
    if b.re() > a.re() { b } else { a }
}

/// How far the gears are in mesh: factor on the potential and its slopes.
struct Engagement<T> {
    /// 1 in mesh, 0 out of reach.
    factor: T,
    /// Its derivative by the centre distance, 1/m.
    by_center_distance: T,
    /// Its derivative by the axial position lambda of c2 in gear 2's frame, 1/m.
    by_axial_position: T,
    /// The factor is below one, or the gears share another part of their faces than the stiffness is for.
    leaving: bool,
}

impl<T: Scalar> Engagement<T> {
    /// At centre distance `c` with c2 at the axial position `lambda` in gear 2's frame.
    #[inline(always)]
    fn new(k: &Constants, c: T, lambda: T) -> Self {
        let (radial, radial_slope) = radial_share(k, c);
        let [(low, low_slope), (high, high_slope)] = face_overlap(k, -lambda + k.z_ref);
        let per_half = 2.0 / (k.common_face[1] - k.common_face[0]);
        let (axial, axial_slope) = step((high - low) * per_half);
        Engagement {
            factor: radial * axial,
            by_center_distance: radial_slope * axial * k.reach.per_span,
            by_axial_position: radial * axial_slope * ((high_slope - low_slope) * per_half),
            leaving: radial.re() < 1.0 || axial.re() < 1.0 || is_shifted(k, [low.re(), high.re()]),
        }
    }
}

/// Part of the common face by which its ends may move before its stiffness and its middle are another pair's.
const SHIFT: f64 = 0.05;

/// Whether the common face `ends` (gear 1's frame, m) is not that of the nominal pose, which tables and contact are for: they
/// have no axis along the gears' axes.
pub(crate) fn is_shifted(k: &Constants, ends: [f64; 2]) -> bool {
    let [low, high] = k.common_face;
    let most = SHIFT * (high - low);
    (ends[0] - low).abs() > most || (ends[1] - high).abs() > most
}

/// Share of the engagement that the centre distance `c` leaves, and its slope by c `per_span`.
#[inline(always)]
pub(crate) fn radial_share<T: Scalar>(k: &Constants, c: T) -> (T, T) {
    step((c - k.reach.none) * k.reach.per_span)
}

/// Ends of the common face in gear 1's frame, m, each with its slope by the axial position of c2 in gear 2's frame, with gear 2's
/// z = 0 face at `offset`; the first beyond the second: the faces are apart.
#[inline(always)]
pub(crate) fn face_overlap<T: Scalar>(k: &Constants, offset: T) -> [(T, f64); 2] {
    let [b1, b2] = k.face_width;
    let low = if offset.re() > 0.0 {
        (offset, -1.0)
    } else {
        (T::from(0.0), 0.0)
    };
    let high = if offset.re() + b2 < b1 {
        (offset + b2, -1.0)
    } else {
        (T::from(b1), 0.0)
    };
    [low, high]
}

/// Quintic step from 0 at 0 to 1 at 1, and its slope.
#[inline(always)]
fn step<T: Scalar>(x: T) -> (T, T) {
    if x.re() >= 1.0 {
        return (T::from(1.0), T::from(0.0));
    }
    if x.re() <= 0.0 {
        return (T::from(0.0), T::from(0.0));
    }
    let square = x * x;
    let rest = -x + 1.0;
    (
        square * x * (x * (x * 6.0 - 15.0) + 10.0),
        square * rest * rest * 30.0,
    )
}
