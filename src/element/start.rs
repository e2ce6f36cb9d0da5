//! The start of a simulation: phases of the teeth from the initial pose; and in words what is wrong with a pose.

use super::constants::{Constants, FLANKS};
use super::contact::{Element, Pose, Solution};
use super::dual::{Scalar, fraction, lift};
use super::engagement::{face_overlap, is_shifted, radial_share};
use super::law::{Law, Response, Source, Workspace};
use super::motion::{ElementError, Inputs, Outputs, PhaseOffset};
use super::parameters::PhaseReference;
use crate::accuracy::is_beyond;
use crate::contact::Warm;
use crate::words::fixed;

/// Multiple of the nominal force that teeth of constant stiffness may start with.
const START_FORCE: f64 = 10.0;

/// Multiple of the nominal centre distance that only a wrong unit brings about.
const WRONG_UNIT: f64 = 100.0;

fn mm(length: f64) -> String {
    fixed(1e3 * length, 3)
}

fn is_outside(range: Option<[f64; 2]>, value: f64) -> bool {
    range.is_some_and(|range| is_beyond(range, value))
}

impl Element {
    /// Phase offsets for a simulation that starts at `inputs`.
    ///
    /// # Errors
    /// A pose without meaning, gears out of mesh.
    pub fn phase_offset(&self, inputs: &Inputs) -> Result<PhaseOffset, ElementError> {
        self.check(inputs)?;
        self.phases(inputs)
    }

    /// As [`Element::phase_offset`], where `inputs` can be a mesh.
    ///
    /// # Errors
    /// As there; teeth that jam with more than any load of the tables: the pose with its values and what would be right.
    pub fn start(&self, inputs: &Inputs) -> Result<PhaseOffset, ElementError> {
        let phase = self.phase_offset(inputs)?;
        let reasons = self.apart(inputs)?.join("; ");
        if !reasons.is_empty() {
            return Err(ElementError::Pose(format!(
                "the initial pose is no mesh: {reasons}; correct the positions of the gears, in m, or start from a pose in mesh"
            )));
        }
        let Solution { outputs, mesh } =
            Solution::new(self, &phase, inputs, false, &mut Workspace::default())?;
        let pressed = mesh.map_or(0.0, |mesh| {
            let [drive, coast] = mesh.flanks.map(|flank| flank.elastic);
            drive.max(coast)
        });
        let k = &self.constants;
        let largest_rigid = START_FORCE * k.nominal_force;
        let largest = self.table().map_or(largest_rigid, |table| {
            table.file.maximum_torque_nm / k.base_radius[0]
        });
        let rigid = self.rigid_jam(&outputs);
        for (force, largest) in [(pressed, largest), (rigid, largest_rigid)] {
            if force > largest {
                let [force, largest] = [force, largest].map(|x| fixed(1e-3 * x, 2));
                return Err(ElementError::Pose(format!(
                    "the initial pose jams the teeth with {force} kN on the line of action, where the largest load is {largest} \
                     kN: {}; correct the positions and orientations of the gears{}",
                    self.pose_in_words(&outputs),
                    self.phase_remedy(
                        outputs.transmission_error * self.line_of_action(outputs.center_distance)
                    )
                )));
            }
        }
        Ok(phase)
    }

    /// What puts the pose `inputs`, which gave `outputs`, out of range ([`Outputs::out_of_range`]), each with its value and
    /// what would be in range; empty where it is the load alone.
    ///
    /// # Errors
    /// A pose without meaning.
    pub fn out_of_range(&self, inputs: &Inputs, outputs: &Outputs) -> Result<String, ElementError> {
        let k = &self.constants;
        let mut reasons = self.apart(inputs)?;
        if reasons.is_empty() {
            let q = Pose::<f64>::new(self, inputs)?.coordinates;
            if radial_share(k, q.center_distance).0 < 1.0 {
                let found = k.center_distance_in_words(q.center_distance);
                reasons.push(format!(
                    "centre distance {found}, where little of the path of contact is left"
                ));
            }
            let ends = face_overlap(k, k.z_ref - q.axial).map(|(end, _)| end);
            if is_shifted(k, ends) {
                let ([low, high], [right_low, right_high]) = (ends.map(mm), k.common_face.map(mm));
                reasons.push(format!(
                    "common face from z = {low} to {high} mm of gear 1, where the stiffness is that from {right_low} to \
                     {right_high} mm"
                ));
            }
            let [offsets, tilts] = self.covered(outputs);
            let offset = outputs.center_distance - k.center_distance;
            if is_outside(offsets, offset) || is_outside(tilts, outputs.misalignment) {
                reasons.push(self.pose_in_words(outputs));
            }
        }
        Ok(reasons.join("; "))
    }

    /// Why the gears are out of mesh, if they are.
    fn apart(&self, inputs: &Inputs) -> Result<Vec<String>, ElementError> {
        let k = &self.constants;
        let pose = Pose::<f64>::new(self, inputs)?;
        let (c, lambda) = (pose.coordinates.center_distance, pose.coordinates.axial);
        let mut reasons = Vec::new();
        if !pose.map.has_line_of_action || radial_share(k, c).0 <= 0.0 {
            let side = if k.e > 0.0 { "below" } else { "above" };
            let unit = if c > WRONG_UNIT * k.center_distance {
                ": positions are in metres"
            } else {
                ""
            };
            let (found, limit) = (k.center_distance_in_words(c), mm(k.radial_engagement.none));
            reasons.push(format!(
                "centre distance {found}, in mesh {side} {limit} mm{unit}"
            ));
        }
        let [low, high] = face_overlap(k, k.z_ref - lambda).map(|(end, _)| end);
        if pose.map.has_line_of_action && high <= low {
            reasons.push(format!(
                "gear 2's z = 0 face at z = {} mm of gear 1 (nominal {} mm), so that the faces are {} mm apart",
                mm(k.z_ref - lambda),
                mm(k.face_offset),
                mm(low - high)
            ));
        }
        Ok(reasons)
    }

    /// Force on the line of action, N, with which flanks would jam at both ends of the face: rigid ones, a wedge on the mean
    /// stiffness over one half of the face. Zero where the tables know better.
    fn rigid_jam(&self, outputs: &Outputs) -> f64 {
        // A contact solve and the laws of a caller know better.
        let knows = |law: &Law| matches!(law.source, Source::Contact(_) | Source::Custom(_));
        if self.laws.iter().flatten().any(knows) {
            return 0.0;
        }
        let [_, tilts] = self.covered(outputs);
        if tilts.is_some() && !is_outside(tilts, outputs.misalignment) {
            return 0.0;
        }
        let k = &self.constants;
        let [low, high] = k.common_face;
        let overlap = 0.5 * (outputs.misalignment.abs() * (high - low) - k.backlash * k.cos_phi);
        0.25 * self.parameters.constant_stiffness / k.cos_phi.powi(2) * overlap.max(0.0)
    }

    /// Centre distance offsets (m) and misalignments (rad) of the flank in `outputs` that the tables cover; `None`: the element does
    /// not look at it.
    fn covered(&self, outputs: &Outputs) -> [Option<[f64; 2]>; 2] {
        let Some(table) = self.table() else {
            return [None; 2];
        };
        let (effects, file) = (&table.effects, &table.file);
        let range = |on: bool, nodes: &[f64]| match nodes {
            [first, .., last] if on => Some([*first, *last]),
            _ => None,
        };
        let mut tilts = range(effects.misalignment, &file.axes.misalignment);
        if outputs.flank < 0 && file.coast.is_none() {
            tilts = tilts.map(|[low, high]| [-high, -low]); // mirrored
        }
        let offsets = &file.axes.center_distance_offset;
        [range(effects.center_distance, offsets), tilts]
    }

    /// Centre distance and misalignment of `outputs`, and what they should be.
    fn pose_in_words(&self, outputs: &Outputs) -> String {
        let k = &self.constants;
        let [offsets, tilts] = self.covered(outputs);
        let tables = |ends: [f64; 2], unit: f64, digits: usize| {
            let [low, high] = ends.map(|end| fixed(unit * end, digits));
            format!("tables {low} to {high}")
        };
        let mut text = format!(
            "centre distance {}, misalignment {} mrad ({})",
            k.center_distance_in_words(outputs.center_distance),
            fixed(1e3 * outputs.misalignment, 3),
            tilts.map_or("right: near 0".into(), |ends| tables(ends, 1e3, 3))
        );
        if let Some(offsets) = offsets {
            let offset = fixed(1e6 * (outputs.center_distance - k.center_distance), 1);
            let range = tables(offsets, 1e6, 1);
            text += &format!(", centre distance offset {offset} um ({range})");
        }
        text
    }

    /// The phases that the pose `inputs` gives, following it with their derivatives: those of the body frames, or those with which the
    /// reference flank is about to carry. Numbers are not checked.
    pub(crate) fn phases<T: Scalar>(
        &self,
        inputs: &Inputs,
    ) -> Result<PhaseOffset<T>, ElementError> {
        let pose = Pose::<T>::new(self, inputs)?;
        if !pose.map.has_line_of_action {
            return Err(ElementError::Pose(
                "at the initial pose the gears are out of mesh; start from a pose in mesh".into(),
            ));
        }
        if self.parameters.phase_reference == PhaseReference::Absolute {
            return Ok(PhaseOffset::default());
        }
        /// Of the central differences, m and rad: small against a tooth, large against the 1e-16 m to which the onset is
        /// known.
        const STEP: f64 = 1e-6;
        /// Base pitches by which the start pose stays short of contact, so that rounding does not decide whether the paper's
        /// damper, which acts at once, is at work.
        const ROUNDING: f64 = 2e-14;
        let k = &self.constants;
        let i = self.reference_flank;
        let s = FLANKS[i].sign();
        let mesh_position = self.parameters.mesh_phase / k.pitch_angle;
        let Some(law) = &self.laws[i] else {
            return Ok(PhaseOffset::default());
        };
        // The pair of teeth 0 touches where the mesh position is 0.
        let counts = [mesh_position.floor() as i64; 2];
        let mut warm = Warm::default();
        let mut touch = |[offset, tilt]: [f64; 2], start: f64| {
            let law = |penetration: f64| {
                let q = [penetration, offset, tilt, fraction(mesh_position)];
                law.respond::<f64>(q, counts, false, &mut warm, &mut None)
            };
            onset(law, 0.25 * k.base_pitch, start)
        };
        let offset = pose.coordinates.center_distance - k.center_distance;
        let q = [offset, pose.misalignment(i)];
        let here = q.map(T::re);
        let found = touch(here, 0.0)?;
        let mut slopes = [0.0; 2];
        for (axis, slope) in slopes.iter_mut().enumerate() {
            if !T::CARRIES || !law.follows()[axis] {
                continue;
            }
            let mut side = |step: f64| {
                let mut x = here;
                x[axis] += step;
                touch(x, found + STEP)
            };
            *slope = (side(STEP)? - side(-STEP)?) / (2.0 * STEP);
        }
        let penetration = lift(found - ROUNDING * k.base_pitch, &slopes, &q) - pose.lever * q[1];
        Ok(PhaseOffset {
            tooth_angle: ((penetration + pose.coordinates.half_gap) * s - pose.coordinates.turn)
                * (1.0 / k.per_tooth_angle),
            mesh_position: (-pose.mesh_position(k, i) + mesh_position) * s,
        })
    }
}

impl Constants {
    fn center_distance_in_words(&self, c: f64) -> String {
        format!("{} mm (nominal {} mm)", mm(c), mm(self.center_distance))
    }
}

/// The largest penetration, m, at which a flank carries nothing, within `most` (m) about zero, where the force of its `law` rises;
/// `start` (m) is looked at first.
///
/// Energy, force and stiffness are those of a power of the distance to the onset, the more so the nearer it is: they tell the
/// distance, so that a few evaluations are enough. Where they mislead, bisection goes on.
fn onset(
    mut law: impl FnMut(f64) -> Result<Response<f64>, ElementError>,
    most: f64,
    start: f64,
) -> Result<f64, ElementError> {
    /// First step, m, in search of a load: reliefs are larger, so that none is met by chance far inside.
    const FIRST: f64 = 1e-6;
    /// To which the onset is found, m: a hundredth of the rounding of microns.
    const NEAR: f64 = 1e-17;
    /// Evaluations after which bisection takes over.
    const EVALUATIONS: usize = 20;
    let (mut free, mut pressed) = (-most, most);
    let (mut next, mut step) = (start, FIRST);
    for tried in 0.. {
        let w = law(next)?;
        let (force, energy) = (w.gradient[0], w.energy);
        let guess = if force > 0.0 {
            pressed = next;
            let way = energy / force / (1.0 - energy / force * (w.stiffness / force));
            match way > 0.0 {
                true => pressed - (0.99 * way).max(3.0 * NEAR),
                false => f64::NAN, // without energy: bisection
            }
        } else {
            free = next;
            step *= 4.0;
            if pressed < most { pressed } else { free + step }
        };
        let middle = 0.5 * (free + pressed);
        // Two neighbouring numbers, or nothing but rounding of the zero between them.
        if middle == free || middle == pressed || pressed - free < 4.0 * NEAR {
            break;
        }
        let helps = free < guess && guess < pressed && tried < EVALUATIONS;
        next = if helps { guess } else { middle };
    }
    Ok(free)
}
