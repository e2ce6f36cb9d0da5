//! The start of a simulation: phase zeros from the initial pose, and the poses that make no mesh, with what would be right.

use super::constants::{Constants, FLANKS};
use super::engagement::{face_overlap, is_shifted, radial_share};
use super::error::ElementError;
use super::evaluate::{Pose, evaluate, pose};
use super::law::{Law, Workspace};
use super::motion::{Inputs, Latch, Outputs};
use super::parameters::PhaseReference;
use super::scalar::{Scalar, fraction, lift, wrap};
use super::{Element, START_FORCE, check};
use crate::contact::Warm;
use crate::gear::teeth::Counts;
use crate::table::Table;
use crate::words::fixed;

/// What the tables of an element cover.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Covered {
    /// Actual minus nominal centre distance, m; `None`: the element does not look at it.
    center_distance_offset: Option<[f64; 2]>,
    /// Misalignment, rad, of the drive flank; `None`: the element does not look at it.
    misalignment: Option<[f64; 2]>,
    /// Whether the coast flank has the range mirrored.
    mirrored: bool,
}

impl Covered {
    /// Constant stiffness: looks at neither.
    pub(crate) const NOTHING: Self = Self {
        center_distance_offset: None,
        misalignment: None,
        mirrored: false,
    };

    pub(crate) fn by(table: &Table) -> Self {
        let (effects, file) = (table.effects(), table.file());
        let range = |on: bool, nodes: &[f64]| match nodes {
            [first, .., last] if on => Some([*first, *last]),
            _ => None,
        };
        let axes = &file.axes;
        Self {
            center_distance_offset: range(effects.center_distance, &axes.center_distance_offset),
            misalignment: range(effects.misalignment, &axes.misalignment),
            mirrored: file.coast.is_none(),
        }
    }

    /// Misalignments of the flank with `sign`, rad.
    fn misalignment(&self, sign: i32) -> Option<[f64; 2]> {
        let [low, high] = self.misalignment?;
        Some(if sign < 0 && self.mirrored {
            [-high, -low]
        } else {
            [low, high]
        })
    }
}

/// Multiple of the nominal centre distance that only a wrong unit brings about.
const WRONG_UNIT: f64 = 100.0;

impl Element {
    /// Phase zeros for a simulation that starts at `inputs`.
    ///
    /// # Errors
    /// A pose without meaning; with [`PhaseReference::Absolute`], teeth that overlap.
    pub fn latch(&self, inputs: &Inputs) -> Result<Latch, ElementError> {
        check::inputs(inputs, self.with_carrier())?;
        latch(self, inputs)
    }

    /// As [`Element::latch`], where `inputs` can be a mesh.
    ///
    /// # Errors
    /// As there; gears out of reach of one another, and teeth that jam with more than any load of the tables: the pose with its
    /// values and what would be right.
    pub fn start(&self, inputs: &Inputs) -> Result<Latch, ElementError> {
        let latch = self.latch(inputs)?;
        let apart = self.apart(inputs)?;
        if !apart.is_empty() {
            return Err(ElementError::NoMesh {
                reasons: apart.join("; "),
            });
        }
        let solution = evaluate::<f64>(self, &latch, inputs, false, &mut Workspace::default())?;
        let pressed = solution.mesh.map_or(0.0, |mesh| {
            let [drive, coast] = mesh.flanks.map(|flank| flank.elastic);
            drive.max(coast)
        });
        let rigid = self.rigid_jam(&solution.outputs);
        let largest_rigid = START_FORCE * self.constants.nominal_force;
        for (force, largest) in [(pressed, self.largest_force), (rigid, largest_rigid)] {
            if force > largest {
                return Err(ElementError::Jammed {
                    force_kn: 1e-3 * force,
                    largest_kn: 1e-3 * largest,
                    place: self.place(&solution.outputs),
                });
            }
        }
        Ok(latch)
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
            if let Ok(pose) = pose(self, inputs)? {
                let q = &pose.coordinates;
                if radial_share(k, q.center_distance).0 < 1.0 {
                    reasons.push(format!(
                        "centre distance {}, where little of the path of contact is left",
                        center_distance(k, q.center_distance)
                    ));
                }
                let (low, high) = faces(k, q.axial);
                if is_shifted(k, [low, high]) {
                    let [right_low, right_high] = k.common_face;
                    let [low, high, right_low, right_high] =
                        [low, high, right_low, right_high].map(|z| fixed(1e3 * z, 3));
                    reasons.push(format!(
                        "common face from z = {low} to {high} mm of gear 1, where the stiffness is that from {right_low} to \
                         {right_high} mm"
                    ));
                }
            }
            if let Some(covered) = &self.covered {
                let outside = |range: Option<[f64; 2]>, value: f64| {
                    range.is_some_and(|[low, high]| value < low || value > high)
                };
                let offset = outputs.center_distance - k.center_distance;
                if outside(covered.center_distance_offset, offset)
                    || outside(covered.misalignment(outputs.flank), outputs.misalignment)
                {
                    reasons.push(self.place(outputs));
                }
            }
        }
        Ok(reasons.join("; "))
    }

    /// Why no tooth reaches the other gear, if none does.
    fn apart(&self, inputs: &Inputs) -> Result<Vec<String>, ElementError> {
        let k = &self.constants;
        let beyond = |c: f64| {
            let limit = if k.e > 0.0 { "below" } else { "above" };
            let unit = if c > WRONG_UNIT * k.center_distance {
                ": positions are in metres"
            } else {
                ""
            };
            format!(
                "centre distance {}, in mesh {limit} {} mm{unit}",
                center_distance(k, c),
                fixed(1e3 * k.reach.none, 3)
            )
        };
        let q = match pose(self, inputs)? {
            Ok(pose) => pose.coordinates,
            Err(far) => return Ok(vec![beyond(far.center_distance)]),
        };
        let mut reasons = Vec::new();
        if radial_share(k, q.center_distance).0 <= 0.0 {
            reasons.push(beyond(q.center_distance));
        }
        let (low, high) = faces(k, q.axial);
        if high <= low {
            let at = k.z_ref - q.axial;
            reasons.push(format!(
                "gear 2's z = 0 face at z = {} mm of gear 1 (nominal {} mm), so that the faces are {} mm apart",
                fixed(1e3 * at, 3),
                fixed(1e3 * k.face_offset, 3),
                fixed(1e3 * (low - high), 3)
            ));
        }
        Ok(reasons)
    }

    /// Force on the line of action, N, with which flanks would jam at both ends of the face: rigid ones, a wedge on the mean
    /// stiffness over one half of the face. Zero where the tables know better.
    fn rigid_jam(&self, outputs: &Outputs) -> f64 {
        // Without `covered` the laws are the caller's, who knows what they look at.
        let Some(covered) = self.covered else {
            return 0.0;
        };
        let known = |[low, high]: [f64; 2]| (low..=high).contains(&outputs.misalignment);
        if covered.misalignment(outputs.flank).is_some_and(known) {
            return 0.0;
        }
        let k = &self.constants;
        let width = 2.0 / k.per_half_overlap;
        let overlap = 0.5 * (outputs.misalignment.abs() * width - k.backlash * k.cos_phi);
        0.25 * self.parameters.constant_stiffness / k.cos_phi.powi(2) * overlap.max(0.0)
    }

    /// Centre distance and misalignment of `outputs` beside what they should be.
    fn place(&self, outputs: &Outputs) -> String {
        let k = &self.constants;
        let range = |range: Option<[f64; 2]>, unit: f64, digits: usize| match range {
            Some(ends) => {
                let [low, high] = ends.map(|end| fixed(unit * end, digits));
                format!("tables {low} to {high}")
            }
            None => "right: near 0".into(),
        };
        let tilts = self.covered.and_then(|c| c.misalignment(outputs.flank));
        let mut text = format!(
            "centre distance {}, misalignment {} mrad ({})",
            center_distance(k, outputs.center_distance),
            fixed(1e3 * outputs.misalignment, 3),
            range(tilts, 1e3, 3)
        );
        if let Some(offsets) = self.covered.and_then(|c| c.center_distance_offset) {
            let offset = 1e6 * (outputs.center_distance - k.center_distance);
            text += &format!(
                ", centre distance offset {} um ({})",
                fixed(offset, 1),
                range(Some(offsets), 1e6, 1)
            );
        }
        text
    }
}

fn center_distance(k: &Constants, c: f64) -> String {
    let [c, nominal] = [c, k.center_distance].map(|c| fixed(1e3 * c, 3));
    format!("{c} mm (nominal {nominal} mm)")
}

/// Ends of the common face in gear 1's frame, m, with gear 2 at the axial position `lambda`.
fn faces(k: &Constants, lambda: f64) -> (f64, f64) {
    let [(low, _), (high, _)] = face_overlap(k, lambda);
    (low, high)
}

/// Base pitches by which the start pose stays short of contact, so that rounding does not decide whether the paper's
/// damper, which acts at once, is at work.
const ROUNDING: f64 = 2e-14;

/// The latch that `element` takes from `inputs`.
pub(crate) fn latch<T: Scalar>(
    element: &Element,
    inputs: &Inputs,
) -> Result<Latch<T>, ElementError> {
    let Ok(pose) = pose(element, inputs)? else {
        return Err(ElementError::OutOfReach);
    };
    match element.parameters.phase_reference {
        PhaseReference::FromInitialPose => from_initial_pose(element, &pose),
        PhaseReference::Absolute => absolute(element, &pose),
    }
}

/// The phases with which the pose is the one where the reference flank is about to carry.
fn from_initial_pose<T: Scalar>(
    element: &Element,
    pose: &Pose<T>,
) -> Result<Latch<T>, ElementError> {
    /// Of the central differences, m and rad: small against a tooth, large against the 1e-16 m to which the onset is
    /// known.
    const STEP: f64 = 1e-6;
    let k = &element.constants;
    let i = element.reference_flank;
    let s = FLANKS[i].sign();
    let mesh_position = element.parameters.mesh_phase / k.pitch_angle;
    let law = element.laws[i].as_ref().ok_or(ElementError::OutOfReach)?;
    // The pair of teeth 0 touches where the mesh position is 0.
    let counts = [mesh_position.floor() as i64; 2];
    let mut warm = Warm::default();
    let mut touching = |[offset, misalignment]: [f64; 2], start| {
        let at = [offset, misalignment, fraction(mesh_position)];
        onset(element, law, at, counts, start, &mut warm)
    };
    let q = [
        pose.coordinates.center_distance - k.center_distance,
        pose.misalignment(i),
    ];
    let at = q.map(T::re);
    let found = touching(at, 0.0)?;
    let mut slopes = [0.0; 2];
    for (axis, slope) in slopes.iter_mut().enumerate() {
        if !T::CARRIES || !law.follows()[axis] {
            continue;
        }
        let mut beside = |step: f64| {
            let mut x = at;
            x[axis] += step;
            touching(x, found + STEP)
        };
        *slope = (beside(STEP)? - beside(-STEP)?) / (2.0 * STEP);
    }
    let elongation = lift(found, &slopes, &q) - pose.lever * q[1];
    Ok(Latch {
        tooth_angle: (elongation + pose.coordinates.half_gap) * (s * k.tooth_angle_per)
            - pose.coordinates.turn * k.tooth_angle_per,
        mesh_position: (-pose.mesh_position(k, i) + mesh_position) * s,
    })
}

/// The largest elongation, m, at which a flank carries nothing at this centre distance offset (m), misalignment and mesh position,
/// within half a base pitch about zero, where the force rises; `start` (m) is looked at first.
///
/// Energy, force and stiffness are those of a power of the distance to the onset, the more so the nearer it is: they tell the
/// distance, so that a few evaluations are enough. Where they mislead, bisection goes on.
fn onset(
    element: &Element,
    law: &Law,
    [offset, misalignment, mesh_position]: [f64; 3],
    counts: Counts,
    start: f64,
    warm: &mut Warm,
) -> Result<f64, ElementError> {
    /// First step, m, in search of a load: reliefs are larger, so that none is met by chance far inside.
    const FIRST: f64 = 1e-6;
    /// To which the onset is found, m: a hundredth of the rounding of microns.
    const NEAR: f64 = 1e-17;
    /// Evaluations after which bisection takes over.
    const MOST: usize = 20;
    let quarter = 0.25 * element.constants.base_pitch;
    let (mut free, mut pressed) = (-quarter, quarter);
    let (mut next, mut step) = (start, FIRST);
    for tried in 0.. {
        let w = law.respond(
            [next, offset, misalignment, mesh_position],
            counts,
            false,
            warm,
        )?;
        let force = w.gradient[0];
        let guess = if force > 0.0 {
            pressed = next;
            let way = w.energy / force / (1.0 - w.energy / force * (w.stiffness / force));
            // Not a number under a law without energy.
            pressed
                - if way > 0.0 {
                    (0.99 * way).max(3.0 * NEAR)
                } else {
                    f64::NAN
                }
        } else {
            free = next;
            step *= 4.0;
            if pressed < quarter {
                pressed
            } else {
                free + step
            }
        };
        let middle = 0.5 * (free + pressed);
        // Two neighbouring numbers, or nothing but rounding of the zero between them.
        if middle == free || middle == pressed || pressed - free < 4.0 * NEAR {
            break;
        }
        let helps = free < guess && guess < pressed && tried < MOST;
        next = if helps { guess } else { middle };
    }
    Ok(free - ROUNDING * element.constants.base_pitch)
}

/// The phases of the body frames, unless the teeth overlap there by more than a load of the table brings about.
fn absolute<T: Scalar>(element: &Element, pose: &Pose<T>) -> Result<Latch<T>, ElementError> {
    let k = &element.constants;
    let latch = Latch {
        tooth_angle: T::from(0.0),
        mesh_position: T::from(0.0),
    };
    let q = &pose.coordinates;
    let per_tooth = k.per_tooth_angle;
    let x = wrap(q.turn.re() / per_tooth) * per_tooth;
    let offset = q.center_distance.re() - k.center_distance;
    let scale = element.law_scale(k.base_sum / q.center_distance.re());
    for (i, law) in element.laws.iter().enumerate() {
        let Some(law) = law else { continue };
        let s = FLANKS[i].sign();
        let misalignment = pose.misalignment(i).re();
        let delta = s * x - q.half_gap.re() + pose.lever.re() * misalignment;
        let position = fraction(pose.mesh_position(k, i).re());
        let counts = pose.counts(k, i, &latch);
        let at = [delta * scale, offset, misalignment, position];
        let warm = &mut Warm::default();
        let force = law.respond(at, counts, false, warm)?.gradient[0];
        if force > element.largest_force {
            let at = [offset, misalignment, position];
            let touching = onset(element, law, at, counts, 0.0, warm)?;
            return Err(ElementError::TeethOverlap {
                overlap_um: 1e6 * (delta - touching),
                force_kn: 1e-3 * force,
                largest_kn: 1e-3 * element.largest_force,
                turn_rad: -s * (delta - touching) / k.rb[0],
            });
        }
    }
    Ok(latch)
}
