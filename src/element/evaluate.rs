//! From poses and velocities to loads: what both formulations share, which is all but the force map of the paper.

use super::constants::{Constants, FLANKS};
use super::engagement::engagement;
use super::error::ElementError;
use super::flank::{FlankLoad, along_approach, root_stress};
use super::friction::Rubbing;
use super::law::Workspace;
use super::map::{Coordinates, Map, Placed};
use super::motion::{Inputs, Latch, Motion, Outputs};
use super::paper::Carried;
use super::scalar::{Scalar, fraction, whole_turns, wrap};
use super::{Element, Formulation};
use crate::gear::teeth::Counts;
use nalgebra::Vector3;

/// A pose as the formulation sees it.
pub(crate) struct Pose<T> {
    /// Coordinates; x before the latch, not wrapped.
    pub coordinates: Coordinates<T>,
    /// Lever of M in the elongation that the law takes, m; zero but for the paper's (19).
    pub lever: T,
    /// Rates and generalised forces.
    pub map: Map<T>,
    /// The paper's formulation: the pose in the carrier.
    pub carried: Option<Carried<T>>,
}

/// Loads and diagnostics, and what they were made of.
pub(crate) struct Solution<T> {
    pub outputs: Outputs<T>,
    /// `None`: the gears are out of reach of one another.
    pub mesh: Option<Mesh<T>>,
}

/// What loads are made of.
pub(crate) struct Mesh<T> {
    /// The map, without derivatives.
    pub map: Map<f64>,
    pub center_distance: T,
    /// Rates of the coordinates.
    pub rates: Coordinates<T>,
    pub flanks: [FlankLoad<T>; 2],
    /// Friction of both flanks, where there is some.
    pub rubbing: [Option<Rubbing<T>>; 2],
    /// The flank that outputs show.
    pub shown: usize,
}

impl<T> Pose<T> {
    /// Mesh positions of drive and coast flank before the latch, (13).
    pub(crate) fn mesh_position(&self, k: &Constants, i: usize) -> T
    where
        T: Scalar,
    {
        self.coordinates.mesh_angle * (-FLANKS[i].sign() * k.per_pitch_angle) + k.mesh_zero[i]
    }

    /// Mesh cycles that passed on gear 1 and gear 2 under flank `i`, from the pose alone: the whole part of the mesh position,
    /// which starts anew with every turn of gear 1, and on gear 2 that less the whole turns of the tooth angle, in
    /// which both gears differ.
    pub(crate) fn counts(&self, k: &Constants, i: usize, latch: &Latch<T>) -> Counts
    where
        T: Scalar,
    {
        let s = FLANKS[i].sign();
        let position = self.mesh_position(k, i).re() + s * latch.mesh_position.re();
        let first = position.floor();
        let angle = self.coordinates.turn.re() * k.tooth_angle_per + latch.tooth_angle.re();
        let apart = s * whole_turns(angle);
        [first as i64, (first - apart) as i64]
    }

    /// Misalignment of flank `i`.
    pub(crate) fn misalignment(&self, i: usize) -> T
    where
        T: Scalar,
    {
        let [even, odd] = self.coordinates.misalignment;
        even + odd * FLANKS[i].sign()
    }
}

/// The pose of `inputs`; an inner `Err` holds the outputs of gears out of reach.
#[inline(always)]
pub(crate) fn pose<T: Scalar>(
    el: &Element,
    inputs: &Inputs,
) -> Result<Result<Pose<T>, Outputs<T>>, ElementError> {
    let k = &el.constants;
    let formulation = el.parameters.formulation;
    let far = |point, c| {
        let point = in_world(&inputs.gears[0], point);
        Ok(Err(Outputs::out_of_reach(point, c, T::from(k.z_ref))))
    };
    let map = match Map::place(k, formulation, &inputs.gears)? {
        Placed::Near(map) => map,
        Placed::Far(point, c) => return far(point, c),
    };
    match formulation {
        Formulation::Conjugate => Ok(Ok(Pose {
            coordinates: map.coordinates(k, &inputs.gears),
            lever: T::from(0.0),
            map,
            carried: None,
        })),
        Formulation::Paper => {
            let carried = Carried::new(k, inputs)?;
            Ok(Ok(Pose {
                coordinates: carried.coordinates(k),
                lever: if el.parameters.misalignment_effect {
                    carried.middle
                } else {
                    T::from(0.0)
                },
                map,
                carried: Some(carried),
            }))
        }
    }
}

/// Loads and diagnostics at `inputs`; `stiffness_slopes` as for [`Law::respond`](super::law::Law::respond).
#[inline(always)]
pub(crate) fn evaluate<T: Scalar>(
    el: &Element,
    latch: &Latch<T>,
    inputs: &Inputs,
    stiffness_slopes: bool,
    workspace: &mut Workspace,
) -> Result<Solution<T>, ElementError> {
    let k = &el.constants;
    let pose = match pose(el, inputs)? {
        Ok(pose) => pose,
        Err(outputs) => {
            return Ok(Solution {
                outputs,
                mesh: None,
            });
        }
    };
    let q = &pose.coordinates;
    let c = q.center_distance;
    let cos_phi = c.recip() * k.base_sum;
    let twist = pose.map.twist(&inputs.gears);
    let rates = pose.map.rates(&twist);
    let mesh = engagement(k, c, q.axial);
    let x = wrap(q.turn * k.tooth_angle_per + latch.tooth_angle) * k.per_tooth_angle;

    let mut out_of_range = mesh.leaving;
    // Arrays are filled by hand here: `map` over them is not always inlined.
    let unloaded = |i: usize| {
        let s = FLANKS[i].sign();
        FlankLoad::unloaded(
            s,
            x * s - q.half_gap,
            pose.misalignment(i),
            fraction(pose.mesh_position(k, i) + latch.mesh_position * s),
        )
    };
    let mut flanks = [unloaded(0), unloaded(1)];
    for (i, (flank, law)) in flanks.iter_mut().zip(&el.laws).enumerate() {
        let Some(law) = law else { continue };
        let scale = el.law_scale(cos_phi);
        let delta = flank.elongation + flank.misalignment * pose.lever;
        let counts = if law.tells_teeth_apart() {
            pose.counts(k, i, latch)
        } else {
            [0; 2]
        };
        let coordinates = [
            delta * scale,
            c - k.center_distance,
            flank.misalignment,
            flank.mesh_position,
        ];
        let response = law.respond(coordinates, counts, stiffness_slopes, &mut workspace.0[i])?;
        out_of_range |= response.out_of_range;
        flank.press(&response, &mesh);
        if flank.elastic.re() <= 0.0 {
            continue;
        }
        out_of_range |= el.have_passed(flank.elongation.re(), q.half_gap.re())?;
        flank.stiffness *= scale;
        flank.damping_arm = match el.parameters.formulation {
            Formulation::Conjugate => flank.arm,
            Formulation::Paper => pose.lever,
        };
        let approach = flank.approach(&rates);
        flank.damping = el.damper.force(flank.elastic, approach, cos_phi);
    }

    let slopes = |i: usize| {
        let f = &flanks[i];
        match pose.carried {
            None => f.all_slopes(k.per_pitch_angle),
            Some(_) => along_approach(f.sign, f.damping_arm, f.damping),
        }
    };
    let mut on_2 = pose.map.loads(&(slopes(0) + slopes(1)));

    let (index, flank) = carrying_flank(&flanks, el.reference_flank);
    let mut rubbing = [None, None];
    let mut friction_power = T::from(0.0);
    if let Some(friction) = &el.friction {
        let moving = (&twist, &rates);
        for (i, load) in flanks.iter().enumerate() {
            if load.elastic.re() <= 0.0 {
                continue;
            }
            rubbing[i] = friction.rub(k, &pose.map, c, (i, load), moving);
            if let Some(rubbing) = &rubbing[i] {
                let (against, power) = friction.loads(rubbing);
                on_2 = on_2 + against;
                friction_power += power;
            }
        }
    }
    let mut loads = pose.map.on_gears(&on_2);
    if let Some(carried) = &pose.carried {
        let elastic = carried.elastic_loads(k, &flanks);
        loads = [loads[0] + elastic[0], loads[1] + elastic[1]];
    }
    let none = [T::from(0.0); 2];
    let root_stress = match &el.root_stress {
        Some(table) => root_stress(table, k, c, &flanks),
        None => none,
    };
    let [friction_coefficient, loss_factor] = rubbing[index]
        .as_ref()
        .map_or(none, |rubbing| rubbing.shown());
    let shown = &flanks[index];
    let reference = &flanks[el.reference_flank];
    let (contact_point, contact_z) = match &pose.carried {
        None => (pose.map.beside_pitch_point(shown.arm), shown.arm + k.z_ref),
        Some(carried) => carried.contact(k, shown.arm),
    };
    let rate = rates.turn * reference.sign - rates.half_gap;
    let [drive, coast] = &flanks;
    let force = drive.force() + coast.force();
    let outputs = Outputs {
        force: [loads[0].linear, loads[1].linear],
        moment: [loads[0].angular, loads[1].angular],
        contact_point: in_world(&inputs.gears[0], contact_point),
        transmission_error: reference.elongation * c * (k.per_base_sum * reference.sign),
        transmission_error_rate: (rate * c + reference.elongation * rates.center_distance)
            * (k.per_base_sum * reference.sign),
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
        mesh: Some(Mesh {
            map: pose.map.re(),
            center_distance: c,
            rates,
            flanks,
            rubbing,
            shown: index,
        }),
    })
}

/// The point `from_origin` beyond the origin of `gear`, whose derivatives by its own motion are not asked.
fn in_world<T: Scalar>(gear: &Motion, from_origin: Vector3<T>) -> Vector3<T> {
    let [x, y, z] = from_origin.into();
    Vector3::new(x + gear.p.x, y + gear.p.y, z + gear.p.z)
}

/// Index of the flank that carries the larger elastic force and its sign; the `reference` flank and 0 where
/// none does.
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
