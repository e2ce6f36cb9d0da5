//! From poses and velocities to loads: both flanks under load, each with its elastic force, damper and friction.

use super::constants::{Constants, FLANKS};
use super::dual::{Scalar, fraction, whole_turns, wrap};
use super::engagement::Engagement;
use super::flank::FlankLoad;
use super::friction::Friction;
use super::kinematics::{Coordinates, Map, Spatial};
use super::law::{Law, Secondary, Workspace};
use super::motion::{ElementError, Inputs, Motion, Outputs, PhaseOffset};
use super::paper::Carried;
use super::{Formulation, LoadedFlank, Parameters, PhaseReference, StiffnessModel};
use crate::contact::Warm;
use crate::gear::teeth::Counts;
use crate::table::Table;
use nalgebra::Vector3;
use std::sync::Arc;

/// The contact element of one gear pair. Immutable: instances can share it between threads.
#[derive(Clone)]
pub struct Element {
    pub(super) constants: Constants,
    pub(super) parameters: Parameters,
    pub(super) laws: [Option<Law>; 2],
    pub(super) friction: Option<Friction>,
    /// Index of the flank that phases and transmission error refer to.
    pub(super) reference_flank: usize,
}

impl Element {
    /// The table of its laws, if they are on one.
    #[inline(always)]
    pub(super) fn table(&self) -> Option<&Arc<Table>> {
        self.laws.iter().flatten().find_map(Law::table)
    }

    /// Whether a flank is pressed by more than half of what fits between the gap and the tooth behind: no load does that,
    /// and twice as far the tooth behind pushes the other way.
    /// Errors: it is, and one flank alone can carry: the gears have turned back through the flank that is missing.
    fn have_passed(&self, penetration: f64, half_gap: f64) -> Result<bool, ElementError> {
        let limit = 0.5 * (0.5 * self.constants.base_pitch - half_gap);
        let passed = penetration > limit;
        if passed && self.parameters.loaded_flank != LoadedFlank::Both {
            let (flank, sign) = match self.parameters.loaded_flank {
                LoadedFlank::Coast => ("coast", -1.0),
                _ => ("drive", 1.0),
            };
            return Err(ElementError::Pose(format!(
                "loadedFlank = {flank}: the teeth overlap by {:.3} mm on the line of action; nothing holds the gears when they turn \
                 back from this flank, and they have come to the tooth behind: set loadedFlank = both{}",
                1e3 * penetration,
                self.phase_remedy(sign * penetration)
            )));
        }
        Ok(passed)
    }

    /// Force of the damper, N, on the line of action, beside the elastic force `elastic` > 0 while the flanks approach at
    /// `rate`, m/s. It has the sign of the rate at every state, so that its power -f rate is never positive,
    /// and never pulls by more than the flanks press: the sum of both forces is >= 0.
    ///
    /// Conjugate: r c rate, r the cubic step of Adams' IMPACT function (MSC Software, Adams/Solver guide, "IMPACT")
    /// with force in place of penetration, so that teeth that meet feel no jump. Where the flanks part so fast that it would take
    /// off more than half of the elastic force, it takes off y - (y - 1/2)^2 / 2 of it in place of y, and all from y = 3/2
    /// on: the force has a continuous slope. Paper: the constant c of (8), c rate / cos^2(phi), cut off.
    #[inline(always)]
    pub(super) fn damping<T: Scalar>(&self, elastic: T, rate: T, cos_phi: T) -> T {
        let (p, k) = (&self.parameters, &self.constants);
        if p.formulation == Formulation::Paper {
            let force = rate * p.damping / (cos_phi * cos_phi);
            return if force.re() > -elastic.re() {
                force
            } else {
                -elastic
            };
        }
        let share = elastic * (1.0 / (p.damping_onset * k.nominal_force));
        let ramp = if share.re() < 1.0 {
            share * share * (-share * 2.0 + 3.0)
        } else {
            T::from(1.0)
        };
        let force = ramp * rate * (p.damping / k.cos_phi.powi(2));
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

    /// Displacement that a law takes over the penetration: the paper's constant k is tangential at the actual pitch circle.
    #[inline(always)]
    fn displacement_factor<T: Scalar>(&self, cos_phi: T) -> T {
        let (formulation, model) = (self.parameters.formulation, self.parameters.stiffness_model);
        match (formulation, model) {
            (Formulation::Paper, StiffnessModel::Constant) => {
                let ratio = cos_phi.recip() * self.constants.cos_phi;
                ratio * ratio
            }
            _ => T::from(1.0),
        }
    }

    /// What else helps teeth that stand where the body frames say and overlap on the line of action, by `x` (m) in the turn of gear 1.
    pub(super) fn phase_remedy(&self, x: f64) -> String {
        let turn = -x / self.constants.base_radius[0];
        match self.parameters.phase_reference {
            PhaseReference::FromInitialPose => String::new(),
            PhaseReference::Absolute => {
                format!(", turn gear 1 by {turn:+.3e} rad, or set phaseReference = fromInitialPose")
            }
        }
    }
}

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
        if formulation == Formulation::Conjugate || !map.has_line_of_action {
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
        FlankLoad {
            sign,
            penetration: x * sign - self.coordinates.half_gap,
            misalignment: self.misalignment(i),
            mesh_position: fraction(self.mesh_position(k, i) + phase.mesh_position * sign),
            ..FlankLoad::default()
        }
    }

    /// Misalignment of flank `i`.
    #[inline(always)]
    pub(crate) fn misalignment(&self, i: usize) -> T {
        let [even, odd] = self.coordinates.misalignment;
        even + odd * FLANKS[i].sign()
    }
}

/// Loads and diagnostics at a pose, and what they were made of.
pub(crate) struct Solution<T: Scalar> {
    pub outputs: Outputs<T>,
    /// `None`: the gears are out of mesh.
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
        let pose = Pose::<T>::new(el, inputs)?;
        if !pose.map.has_line_of_action {
            return Ok(Self::out_of_mesh(el, inputs, &pose));
        }
        let mut mating = Mating::new(el, phase, inputs, &pose);
        for i in 0..2 {
            mating.press(i, phase, stiffness_slopes, &mut workspace.0[i])?;
        }
        let mut on_2 = pose.map.wrench(&mating.slopes);
        let rubbing = mating.rub(&mut on_2);
        let outputs = mating.outputs(&on_2, &rubbing, inputs);
        Ok(Self {
            outputs,
            mesh: Some(Mesh {
                rates: mating.rates,
                flanks: mating.flanks,
            }),
        })
    }

    /// Of gears out of mesh.
    #[inline(always)]
    fn out_of_mesh(el: &Element, inputs: &Inputs, pose: &Pose<T>) -> Self {
        let point = pose.map.near_pitch_point(T::from(0.0));
        Self {
            outputs: Outputs {
                contact_point: in_world(&inputs.gears[0], point),
                center_distance: pose.coordinates.center_distance,
                contact_z: T::from(el.constants.z_ref),
                out_of_range: true,
                ..Outputs::default()
            },
            mesh: None,
        }
    }
}

/// The gears at a pose in mesh, on the way to their loads.
struct Mating<'e, T> {
    el: &'e Element,
    pose: &'e Pose<T>,
    /// Twist of gear 2 against gear 1 at c2.
    twist: Spatial<T>,
    /// Rates of the coordinates.
    rates: Coordinates<T>,
    engagement: Engagement<T>,
    /// Of the working pressure angle.
    cos_phi: T,
    flanks: [FlankLoad<T>; 2],
    /// What the law of each flank finds beside its potential.
    secondary: [Option<Secondary<T>>; 2],
    /// Of the potential and the dampers by the coordinates, of both flanks.
    slopes: Coordinates<T>,
    /// Either flank sees the misalignment with its own sign, and a table may cover more of one sign than of the other.
    beyond_table: [bool; 2],
    out_of_range: bool,
}

impl<'e, T: Scalar> Mating<'e, T> {
    /// At `pose`, with both flanks still without load.
    #[inline(always)]
    fn new(el: &'e Element, phase: &PhaseOffset<T>, inputs: &Inputs, pose: &'e Pose<T>) -> Self {
        let (k, q) = (&el.constants, &pose.coordinates);
        let twist = pose.map.twist(&inputs.gears);
        let engagement = Engagement::new(k, q.center_distance, q.axial);
        let turn = wrap(q.turn * (1.0 / k.per_tooth_angle) + phase.tooth_angle);
        let x = turn * k.per_tooth_angle;
        let flanks = [pose.unloaded(k, 0, x, phase), pose.unloaded(k, 1, x, phase)];
        Self {
            el,
            rates: pose.map.rates(&twist),
            twist,
            cos_phi: q.center_distance.recip() * k.base_radius_sum,
            flanks,
            secondary: [None; 2],
            slopes: Coordinates::default(),
            beyond_table: [false; 2],
            out_of_range: engagement.leaving,
            engagement,
            pose,
        }
    }

    /// Elastic force and damper of flank `i`.
    /// Errors: its law has no potential there; see [`Element::have_passed`].
    #[inline(always)]
    fn press(
        &mut self,
        i: usize,
        phase: &PhaseOffset<T>,
        stiffness_slopes: bool,
        warm: &mut Warm,
    ) -> Result<(), ElementError> {
        let (el, pose, engagement) = (self.el, self.pose, &self.engagement);
        let (k, q) = (&el.constants, &pose.coordinates);
        let Some(law) = &el.laws[i] else {
            return Ok(());
        };
        let flank = &mut self.flanks[i];
        let counts = if law.tells_teeth_apart {
            pose.counts(k, i, phase)
        } else {
            [0; 2]
        };
        let scale = el.displacement_factor(self.cos_phi);
        let coordinates = [
            (flank.penetration + flank.misalignment * pose.lever) * scale,
            q.center_distance - k.center_distance,
            flank.misalignment,
            flank.mesh_position,
        ];
        let secondary = &mut self.secondary[i];
        let response = law.respond(coordinates, counts, stiffness_slopes, warm, secondary)?;
        self.beyond_table[i] = response.out_of_range;
        // The potential is U = (engagement) W.
        let elastic = response.gradient[0] * engagement.factor;
        if elastic.re() <= 0.0 {
            return Ok(());
        }
        self.out_of_range |= el.have_passed(flank.penetration.re(), q.half_gap.re())?;
        let s = flank.sign;
        flank.elastic = elastic;
        flank.arm = response.gradient[2] / response.gradient[0];
        flank.energy = response.energy * engagement.factor;
        flank.stiffness = response.stiffness * engagement.factor * scale;
        // The damper opposes the rate of approach, and acts along its slopes.
        let by_misalignment = match el.parameters.formulation {
            Formulation::Conjugate => flank.arm,
            Formulation::Paper => pose.lever,
        };
        let [even, odd] = self.rates.misalignment;
        let approach =
            self.rates.turn * s - self.rates.half_gap + (even + odd * s) * by_misalignment;
        flank.damping = el.damping(elastic, approach, self.cos_phi);
        let (mut force, mut moment) = (flank.damping, flank.damping * by_misalignment);
        let slopes = &mut self.slopes;
        // The paper's elastic force is no gradient: `Carried` has it.
        if pose.carried.is_none() {
            force += elastic;
            moment += elastic * flank.arm;
            slopes.center_distance += response.gradient[1] * engagement.factor
                + response.energy * engagement.by_center_distance;
            slopes.mesh_angle += response.gradient[3] * engagement.factor * (-s / k.pitch_angle);
            slopes.axial += response.energy * engagement.by_axial_position;
        }
        slopes.turn += force * s;
        slopes.half_gap -= force;
        slopes.misalignment[0] += moment;
        slopes.misalignment[1] += moment * s;
        Ok(())
    }

    /// Friction of both flanks, added to the wrench `on_2` on gear 2.
    #[inline(always)]
    fn rub(&self, on_2: &mut Spatial<T>) -> Rubbing<T> {
        let mut rubbing = Rubbing::default();
        let Some(friction) = &self.el.friction else {
            return rubbing;
        };
        let k = &self.el.constants;
        let offset = self.pose.coordinates.center_distance - k.center_distance;
        let (index, _) = carrying_flank(&self.flanks, self.el.reference_flank);
        for (i, load) in self.flanks.iter().enumerate() {
            if load.elastic.re() <= 0.0 {
                continue;
            }
            let tabulated = || load.sliding(self.el.table()?, FLANKS[i], offset);
            let solved = self.secondary[i].map(|secondary| secondary.sliding);
            let Some(sliding) = solved.or_else(tabulated) else {
                continue;
            };
            let spin = -self.rates.mesh_angle;
            let on_flank = friction.on_flank(k, &self.pose.map, load, sliding, &self.twist, spin);
            on_2.add(&on_flank.row, on_flank.force);
            rubbing.power -= on_flank.force * on_flank.speed;
            if i == index {
                rubbing.coefficient = on_flank.coefficient;
                rubbing.loss_factor = on_flank.loss_factor;
            }
        }
        rubbing
    }

    /// Loads and diagnostics with the wrench `on_2` on gear 2, which is that of friction, too.
    #[inline(always)]
    fn outputs(&self, on_2: &Spatial<T>, rubbing: &Rubbing<T>, inputs: &Inputs) -> Outputs<T> {
        let (el, pose, flanks) = (self.el, self.pose, &self.flanks);
        let (k, c) = (&el.constants, pose.coordinates.center_distance);
        let (index, flank) = carrying_flank(flanks, el.reference_flank);
        // A flank that carries nothing says nothing about the loads.
        let counts = |i: usize| i == index || flanks[i].elastic.re() > 0.0;
        let beyond_table = (0..2).any(|i| self.beyond_table[i] && counts(i));
        let mut loads = pose.map.on_gears(on_2);
        if let Some(carried) = &pose.carried {
            carried.add_elastic_loads(k, flanks, &mut loads);
        }
        let root_stress = match el.parameters.root_stress {
            true => self.root_stress(),
            false => [T::from(0.0); 2],
        };
        let shown = &flanks[index];
        let reference = &flanks[el.reference_flank];
        let (contact_point, contact_z) = match &pose.carried {
            None => (pose.map.near_pitch_point(shown.arm), shown.arm + k.z_ref),
            Some(carried) => carried.contact(k, shown.arm),
        };
        let rate = self.rates.turn * reference.sign - self.rates.half_gap;
        let per_base_sum = reference.sign / k.base_radius_sum;
        let [drive, coast] = flanks;
        let force = drive.force() + coast.force();
        Outputs {
            force: [loads[0].linear, loads[1].linear],
            moment: [loads[0].angular, loads[1].angular],
            contact_point: in_world(&inputs.gears[0], contact_point),
            transmission_error: reference.penetration * c * per_base_sum,
            transmission_error_rate: (rate * c
                + reference.penetration * self.rates.center_distance)
                * per_base_sum,
            mesh_position: shown.mesh_position,
            center_distance: c,
            misalignment: shown.misalignment,
            tangential_force: force * self.cos_phi,
            normal_force: force * k.per_cos_beta_b,
            stiffness: (drive.stiffness + coast.stiffness) * self.cos_phi * self.cos_phi,
            contact_z,
            energy: drive.energy + coast.energy,
            friction_power: rubbing.power,
            friction_coefficient: rubbing.coefficient,
            loss_factor: rubbing.loss_factor,
            root_stress,
            flank,
            out_of_range: self.out_of_range || beyond_table,
        }
    }

    /// Stress in the roots of gear 1 and gear 2 under the loads of both flanks, Pa: the larger one.
    ///
    /// Apart from the loads, which most FMUs compute alone.
    #[inline(never)]
    fn root_stress(&self) -> [T; 2] {
        let offset = self.pose.coordinates.center_distance - self.el.constants.center_distance;
        let factor = self.engagement.factor;
        let mut largest = [T::from(0.0); 2];
        for (i, load) in self.flanks.iter().enumerate() {
            if load.elastic.re() <= 0.0 {
                continue;
            }
            let stress = match self.el.table() {
                Some(table) => (table.root_stress(FLANKS[i])).map(|s| load.tabulated(s, offset)),
                None => self.secondary[i].map(|found| found.root_stress.map(|s| s * factor)),
            };
            for (largest, stress) in largest.iter_mut().zip(stress.into_iter().flatten()) {
                if stress.re() > largest.re() {
                    *largest = stress;
                }
            }
        }
        largest
    }
}

/// What friction does; zero without load or where it is off.
#[derive(Default)]
struct Rubbing<T> {
    /// Of both flanks on both gears, W, <= 0.
    power: T,
    /// Coefficient in force on the flank that carries more.
    coefficient: T,
    /// Of that flank.
    loss_factor: T,
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
