//! Poses that make no mesh, in words: a simulation does not start from them, and the log tells of those that it comes to
//! later.

use super::constants::Constants;
use super::engagement::{face_overlap, is_shifted, radial_share};
use super::error::ElementError;
use super::evaluate::{evaluate, pose};
use super::motion::{Inputs, Latch, Outputs};
use super::{Element, START_FORCE};
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
            center_distance_offset: range(effects.center_distance, &axes.center_distance_offset_m),
            misalignment: range(effects.misalignment, &axes.misalignment_rad),
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
    /// Refuses `inputs`, with the phases of `latch`, as the start of a simulation where they can be no mesh: gears out of
    /// reach of one another, or teeth that jam with more than any load of the tables.
    ///
    /// # Errors
    /// Such a pose, with its values and what would be right; a pose without meaning.
    pub fn check_start(&self, latch: &Latch, inputs: &Inputs) -> Result<(), ElementError> {
        let apart = self.apart(inputs)?;
        if !apart.is_empty() {
            return Err(ElementError::NoMesh {
                reasons: apart.join("; "),
            });
        }
        let solution = evaluate::<f64>(self, latch, inputs, false)?;
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
        Ok(())
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
