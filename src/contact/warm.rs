//! Where a solve at run time starts: the forces of the last one, moved on to the new pose.

/// What a solve at run time knows of the one before. It saves steps of Newton's iteration and changes the solution by no more than
/// rounding.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Warm {
    /// Approach (m), misalignment (rad) and mesh position.
    at: [f64; 3],
    strips: Vec<(SinceStart, Known)>,
}

/// A strip by tooth pair, counted from the start, and station.
pub(super) type SinceStart = (i64, usize);

/// What is known of the force on a strip.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct Known {
    /// N.
    force: f64,
    /// Its slopes by approach, misalignment and, from one solve to the next, mesh position.
    slopes: [f64; 3],
}

/// Steps of the mesh position over which forces change evenly enough to be told from their last change.
const NEAR: f64 = 0.02;

/// Steps too small to tell a slope from.
const TOO_NEAR: f64 = 1e-6;

impl Warm {
    /// Forgets all.
    pub(super) fn clear(&mut self) {
        *self = Warm::default();
    }

    /// Forces on the strips `names`, ascending, to start from at the approach, misalignment and mesh position `at`; `None` where nothing is
    /// known.
    pub(super) fn forces(
        &self,
        names: impl Iterator<Item = SinceStart>,
        at: [f64; 3],
    ) -> Option<Vec<f64>> {
        let mut by = [0, 1, 2].map(|axis| at[axis] - self.at[axis]);
        if by[2].abs() > NEAR {
            by[2] = 0.0;
        }
        let moved = |known: Known| known.force + super::cholesky::dot(&known.slopes, &by);
        let mut known = self.strips.iter().peekable();
        let forces = names.map(|name| {
            while known.next_if(|(other, _)| *other < name).is_some() {}
            let here = known.next_if(|(other, _)| *other == name);
            here.map_or(0.0, |(_, known)| moved(*known).max(0.0))
        });
        (!self.strips.is_empty()).then(|| forces.collect())
    }

    /// Keeps what was found at `at`: strips that carry, ascending, their forces and slopes by approach and misalignment.
    pub(super) fn keep(
        &mut self,
        at: [f64; 3],
        found: impl Iterator<Item = (SinceStart, f64, [f64; 2])>,
    ) {
        let by = [0, 1, 2].map(|axis| at[axis] - self.at[axis]);
        let last = std::mem::take(&mut self.strips);
        let mut last = last.into_iter().peekable();
        self.strips = found
            .map(|(name, force, [by_approach, by_misalignment])| {
                while last.next_if(|(other, _)| *other < name).is_some() {}
                let before = last.next_if(|(other, _)| *other == name);
                let by_position = before.map_or(0.0, |(_, before)| {
                    let [a, m, position] = before.slopes;
                    let rest = force - before.force - a * by[0] - m * by[1];
                    match by[2].abs() {
                        step if step < TOO_NEAR => position,
                        step if step > NEAR => 0.0,
                        _ => rest / by[2],
                    }
                });
                let slopes = [by_approach, by_misalignment, by_position];
                (name, Known { force, slopes })
            })
            .collect();
        self.at = at;
    }
}
