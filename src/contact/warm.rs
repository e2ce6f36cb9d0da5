//! Where a solve at run time starts: the forces of the last one, moved on to the new pose.

/// What a solve at run time knows of the one before. It saves steps of Newton's iteration and changes the solution by no more than
/// rounding.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Warm {
    /// Approach (m), misalignment (rad) and mesh position.
    at: [f64; 3],
    /// Step of the mesh position that led there; zero where it tells no slope.
    step: f64,
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
    /// Divided difference of the last of these, from three solves; zero where there are fewer.
    bend: f64,
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
        let bent = by[2] * (by[2] + self.step);
        let moved = |known: Known| {
            known.force + super::cholesky::dot(&known.slopes, &by) + known.bend * bent
        };
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
        let tells = (TOO_NEAR..=NEAR).contains(&by[2].abs());
        let last = std::mem::take(&mut self.strips);
        let mut last = last.into_iter().peekable();
        self.strips = found
            .map(|(name, force, [by_approach, by_misalignment])| {
                while last.next_if(|(other, _)| *other < name).is_some() {}
                let before = last.next_if(|(other, _)| *other == name);
                let mut known = Known {
                    force,
                    slopes: [by_approach, by_misalignment, 0.0],
                    bend: 0.0,
                };
                let Some((_, before)) = before else {
                    return (name, known);
                };
                if tells {
                    let [a, m, position] = before.slopes;
                    // Means of the slopes at both ends: exact for parabolas.
                    let rest = force
                        - before.force
                        - 0.5 * ((a + by_approach) * by[0] + (m + by_misalignment) * by[1]);
                    known.slopes[2] = rest / by[2];
                    // Only onwards: a walk there and back tells no parabola.
                    if by[2] * self.step > 0.0 && position != 0.0 {
                        known.bend = (known.slopes[2] - position) / (by[2] + self.step);
                    }
                } else if by[2].abs() < TOO_NEAR {
                    (known.slopes[2], known.bend) = (before.slopes[2], before.bend);
                }
                (name, known)
            })
            .collect();
        if by[2].abs() >= TOO_NEAR {
            self.step = if tells { by[2] } else { 0.0 };
        }
        self.at = at;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    /// Forces at `to` after solves at the mesh positions `walk`, at which one strip carries a parabola.
    fn start(walk: &[f64], to: f64) -> f64 {
        let force = |position: f64| 100.0 + 300.0 * position + 5e4 * position * position;
        let mut warm = Warm::default();
        for position in walk {
            let found = [((0, 3), force(*position), [0.0; 2])];
            warm.keep([1e-6, 0.0, *position], found.into_iter());
        }
        let found = warm.forces([(0, 3)].into_iter(), [1e-6, 0.0, to]);
        found.unwrap()[0] / force(to)
    }

    #[test]
    fn forces_move_on_by_a_parabola() {
        assert_relative_eq!(start(&[0.0, 1e-3, 3e-3], 4e-3), 1.0, epsilon = 1e-12);
    }

    #[test]
    fn a_walk_there_and_back_stays_near() {
        assert_relative_eq!(start(&[2e-3, 3e-3, 2e-3], 1e-3), 1.0, epsilon = 2e-3);
        assert_relative_eq!(start(&[2e-3, 3e-3, 3e-3], 4e-3), 1.0, epsilon = 2e-3);
    }
}
