//! Flanks that come closer along the face before the load of the mesh.

use super::error::ContactError;

/// How far the flanks of both gears have come closer along the pitch line, on the line of action, before the load of
/// the mesh: > 0 closes, as an approach does. Straight between its points and, beyond them, on as between the
/// two outermost. Transverse sections turn with its slope, so that at the distance y from the pitch line along the path flanks
/// close by sigma y times the slope more, sigma that of the contact line. A misalignment M is the deflection M (z - z_ref); both add.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Deflection {
    /// (z in gear 1's frame, closing), m, ascending in z; none where there is no deflection.
    points: Vec<[f64; 2]>,
}

impl Deflection {
    /// Through `points`: (z in gear 1's frame, closing on the line of action), m.
    ///
    /// # Errors
    /// [`Input`](gearmesh::contact::ContactError::Input) for fewer than two points, numbers that are not finite, and z that do not ascend.
    pub fn new(points: Vec<[f64; 2]>) -> Result<Deflection, ContactError> {
        if points.len() < 2 {
            let count = points.len() as f64;
            let field = "points of the deflection";
            return Err(ContactError::input(field, count, "give at least 2"));
        }
        if let Some(value) = points.iter().flatten().find(|v| !v.is_finite()) {
            return Err(ContactError::input(
                "deflection",
                *value,
                "give finite numbers",
            ));
        }
        if let Some(pair) = points.windows(2).find(|p| p[1][0] <= p[0][0]) {
            let field = "z of the deflection";
            return Err(ContactError::input(field, pair[1][0], "let z ascend"));
        }
        Ok(Deflection { points })
    }

    /// The ends of the face, `ends` (m in gear 1's frame), closed by `bow` (m) less than its middle, where the
    /// deflection is zero; parabolic.
    ///
    /// # Errors
    /// As [`Deflection::new`].
    pub fn bow(bow: f64, ends: [f64; 2]) -> Result<Deflection, ContactError> {
        const PIECES: usize = 64;
        let points = (0..=PIECES).map(|i| {
            let t = 2.0 * i as f64 / PIECES as f64 - 1.0;
            let z = 0.5 * ((1.0 - t) * ends[0] + (1.0 + t) * ends[1]);
            [z, -bow * t * t]
        });
        Deflection::new(points.collect())
    }

    /// Closing (m) on the pitch line at `z` (m in gear 1's frame), and its slope there: between the middles of two pieces the mean of
    /// theirs, so that no transverse section turns against its neighbour.
    pub fn closing(&self, z: f64) -> [f64; 2] {
        if self.points.is_empty() {
            return [0.0; 2];
        }
        let above = self.points.partition_point(|p| p[0] <= z);
        let last = above.clamp(1, self.points.len() - 1);
        let (middle, slope) = self.piece(last);
        let beside = if z < middle { last - 1 } else { last + 1 };
        let mut smooth = slope;
        if (1..self.points.len()).contains(&beside) {
            let (other, turned) = self.piece(beside);
            smooth += (turned - slope) * (z - middle) / (other - middle);
        }
        let [z0, d0] = self.points[last - 1];
        [d0 + slope * (z - z0), smooth]
    }

    /// Middle (m) and slope of the piece that ends at the point `last`.
    fn piece(&self, last: usize) -> (f64, f64) {
        let ([z0, d0], [z1, d1]) = (self.points[last - 1], self.points[last]);
        (0.5 * (z0 + z1), (d1 - d0) / (z1 - z0))
    }

    /// Least and largest closing over the face with the ends `ends`, m, up to `beyond` (sigma y, m) beside the pitch line.
    pub fn range(&self, ends: [f64; 2], beyond: f64) -> [f64; 2] {
        let inside = (self.points.iter().map(|p| p[0])).filter(|z| ends[0] < *z && *z < ends[1]);
        let none = [f64::INFINITY, f64::NEG_INFINITY];
        (ends.into_iter().chain(inside)).fold(none, |[low, high], z| {
            let [closing, slope] = self.closing(z);
            let turned = (beyond * slope).abs();
            [low.min(closing - turned), high.max(closing + turned)]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn a_deflection_is_straight_through_and_beyond_its_points_and_turns_smoothly_from_piece_to_piece()
     {
        let curve = Deflection::new(vec![[0.0, 1e-6], [10e-3, 3e-6], [20e-3, 2e-6]]).unwrap();
        for (z, closing, slope) in [
            (0.0, 1.0, 200.0),
            (5e-3, 2.0, 200.0),
            (10e-3, 3.0, 50.0),
            (15e-3, 2.5, -100.0),
            (30e-3, 1.0, -100.0),
            (-5e-3, 0.0, 200.0),
        ] {
            let found = curve.closing(z).map(|value| 1e6 * value);
            assert_abs_diff_eq!(found[..], [closing, slope][..], epsilon = 1e-9);
        }
        for (beyond, range) in [(0.0, [1.0, 3.0]), (2e-3, [0.6, 3.1])] {
            let found = curve.range([0.0, 20e-3], beyond).map(|value| 1e6 * value);
            assert_abs_diff_eq!(found[..], range[..], epsilon = 1e-9);
        }
        assert_eq!(Deflection::default().closing(1.0), [0.0; 2]);
        // A bow is zero in the middle and opens the ends.
        let bow = Deflection::bow(4e-6, [2e-3, 22e-3]).unwrap();
        for (z, closing) in [(2e-3, -4.0), (12e-3, 0.0), (17e-3, -1.0), (22e-3, -4.0)] {
            assert_abs_diff_eq!(1e6 * bow.closing(z)[0], closing, epsilon = 1e-9);
        }
        for points in [
            vec![[0.0, 0.0]],
            vec![[0.0, 0.0], [0.0, 1.0]],
            vec![[0.0, 0.0], [1.0, f64::NAN]],
        ] {
            let refused = Deflection::new(points);
            assert!(matches!(
                refused,
                Err(ContactError::Solve(
                    gearmesh::contact::ContactError::Input { .. }
                ))
            ));
        }
    }
}
