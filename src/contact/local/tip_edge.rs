//! Local contact cut off on one side by a tip edge.
//!
//! With s the distance from the edge, the gap of the undeformed flanks there is alpha s + s² / (2 R) more than
//! at the edge. Contact reaches from the edge to s = a. The pressure between half-planes is then
//!
//! p(s) = sqrt((a - s) / s) (alpha + (s + a / 2) / R) / (pi c), c = sum of 2 (1 - nu²) / (pi E)
//!
//! (a punch with one sharp end: Johnson, Contact Mechanics, 1985, sections 2.7 and 5.1). It ends in the
//! Hertz pressure of half-width b for alpha = -b / R, a = 2 b: contact that reaches the edge, and no more.
//! So one law goes from the Hertz contact inside the flank to the edge that digs into the mate. It has
//!
//! dh / dw = sum_g c_g ln(4 L_g / a),
//!
//! the flat punch of the present width, since a is stationary, and at the corner of a tooth what [`super::corner`] adds, to
//! first order: the pressure is taken as it is between half-planes. h and w in closed form follow below.

use std::f64::consts::LN_2;

use super::constants::WIDTH_OVER_REFERENCE;
use super::corner::Corner;

/// Law of contact at a tip edge, per length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TipEdge {
    /// c, 1/Pa.
    c: f64,
    /// R, m.
    radius: f64,
    /// c and what the corner adds, 1/Pa.
    with_corner: f64,
    /// ln of the width at which dh/dw = `with_corner` (this - ln a) ends.
    log_end: f64,
    /// alpha.
    slope: f64,
    /// Width, line load and penetration at which contact reaches the edge.
    least: [f64; 3],
    /// The same where the tangent begins.
    wide: [f64; 3],
}

impl TipEdge {
    /// Law with the reference length `reference` (m), the logarithmic mean of both gears weighted with c_g, at the edge with the corner
    /// `corner`, the contact line at the distance `line` (m) from it. None where contact becomes too wide for the law
    /// before it reaches the edge.
    pub fn new(
        [c, radius, reference, slope]: [f64; 4],
        corner: Corner,
        line: f64,
    ) -> Option<TipEdge> {
        let least = (-2.0 * slope * radius).max(0.0);
        // Far inside the flank, as most strips are: the width of the tangent is a mean of 3 L and twice the distance from the
        // edge, which is the least width up to rounding.
        if least > (1.0 - 1e-9) * 2.0 * (2.0 * reference).max(corner.held(line)) {
            return None;
        }
        let with_corner = c + corner.softness;
        let mut log_end = reference.ln() + 2.0 * LN_2;
        if corner.softness > 0.0 {
            let from_edge = LN_2 + corner.held(line).ln();
            log_end = (c * log_end + corner.softness * from_edge) / with_corner;
        }
        // Where dh/dw is that of the law of Hertz at its tangent; without a corner the whole width, where that law counts by
        // half of it.
        let wide = (log_end - c / with_corner * (2.0 / WIDTH_OVER_REFERENCE).ln()).exp();
        // Not a number where the curvatures cancel: no law of an edge either.
        if !matches!(least.partial_cmp(&wide), Some(std::cmp::Ordering::Less)) {
            return None;
        }
        let mut edge = TipEdge {
            c,
            radius,
            with_corner,
            log_end,
            slope,
            least: [0.0; 3],
            wide: [0.0; 3],
        };
        if least > 0.0 {
            edge.least = edge.state(least);
        }
        edge.wide = edge.state(wide);
        Some(edge)
    }

    /// Penetration below which contact does not reach the edge, m.
    pub fn least_penetration(&self) -> f64 {
        self.least[2]
    }

    /// Line load below which contact does not reach the edge, N/m.
    pub fn least_line_load(&self) -> f64 {
        self.least[1]
    }

    /// Width of contact from which on the law goes on along its tangent, m.
    pub fn widest(&self) -> f64 {
        self.wide[0]
    }

    /// Line load (N/m) and penetration (m) of a contact of the width `a` (m) up to [`TipEdge::widest`].
    pub fn at_width(&self, a: f64) -> [f64; 2] {
        let [_, load, penetration] = self.state(a);
        [load, penetration]
    }

    /// Width, line load and penetration at the width `a`.
    fn state(&self, a: f64) -> [f64; 3] {
        let of_slope = (self.slope + 0.5 * a / self.radius) * a / (2.0 * self.c);
        let of_curvature = a * a / (8.0 * self.c * self.radius);
        // Minus the means of ln s under both parts of the pressure.
        let log = self.log_end - a.ln();
        let at_edge = self.with_corner * (of_slope * (log + 1.0) + of_curvature * (log - 0.5));
        let inside = self.slope.min(0.0);
        // Of the law of Hertz where contact just reaches the edge.
        let part = 0.25 * (1.0 + self.with_corner / self.c);
        [
            a,
            of_slope + of_curvature,
            at_edge + part * inside * inside * self.radius,
        ]
    }

    /// Compliance dh/dw at the width `a`, 1/Pa.
    fn compliance(&self, a: f64) -> f64 {
        self.with_corner * (self.log_end - a.ln())
    }

    /// Integral of the line load from the penetration at which contact reaches the edge to `x` (m), J/m.
    pub fn energy(&self, x: f64) -> f64 {
        let [wide, w_wide, x_wide] = self.wide;
        let reached = self.work(self.least[0]);
        if x < x_wide {
            return self.work(self.width(x)) - reached;
        }
        let beyond = x - x_wide;
        self.work(wide) - reached + beyond * (w_wide + 0.5 * beyond / self.compliance(wide))
    }

    /// Integral of w dh over the width from 0 to `a`, J/m. With w and dw/da of [`TipEdge::state`] and dh/dw = c' (l - ln a)
    /// the integrand is (alpha²/4 a + 9 alpha/(16 R) a² + 9/(32 R²) a³) (l - ln a) c' / c².
    fn work(&self, a: f64) -> f64 {
        if a <= 0.0 {
            return 0.0;
        }
        let log = self.log_end - a.ln();
        let (slope, curvature) = (self.slope, 1.0 / self.radius);
        let parts = [
            (2.0, 0.25 * slope * slope),
            (3.0, 9.0 / 16.0 * slope * curvature * a),
            (4.0, 9.0 / 32.0 * curvature * curvature * a * a),
        ];
        let sum: f64 = parts
            .iter()
            .map(|(n, part)| part / n * (log + 1.0 / n))
            .sum();
        a * a * sum * self.with_corner / (self.c * self.c)
    }

    /// Line load (N/m) and its derivative (Pa) at the penetration `x` (m) beyond the least one.
    pub fn line_load(&self, x: f64) -> (f64, f64) {
        let [wide, w_wide, x_wide] = self.wide;
        if x >= x_wide {
            let slope = self.compliance(wide).recip();
            return (w_wide + slope * (x - x_wide), slope);
        }
        let a = self.width(x);
        (self.state(a)[1], self.compliance(a).recip())
    }

    /// Width at the penetration `x` (m) between the least one and that where the tangent begins, m.
    fn width(&self, x: f64) -> f64 {
        let [wide, _, x_wide] = self.wide;
        let (mut low, mut high) = (self.least[0], wide);
        let share = (x - self.least[2]) / (x_wide - self.least[2]);
        let mut a = low + (high - low) * share;
        for _ in 0..100 {
            let h = self.state(a)[2];
            if h > x {
                high = a;
            } else {
                low = a;
            }
            let growth = (0.5 * self.slope + 0.75 * a / self.radius) / self.c;
            let newton = a - (h - x) / (growth * self.compliance(a));
            let inside = low < newton && newton < high;
            let next = if inside { newton } else { 0.5 * (low + high) };
            let step = (next - a).abs();
            a = next;
            // Quadratic: what a step of Newton's method leaves is the square of it.
            let enough = if inside { 1e-9 } else { 4.0 * f64::EPSILON };
            if step <= enough * a {
                break;
            }
        }
        a
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::{assert_abs_diff_eq, assert_relative_eq};
    use std::f64::consts::PI;

    const C: f64 = 4.0 * (1.0 - 0.09) / (PI * 206e9);
    const RADIUS: f64 = 8e-3;
    const REFERENCE: f64 = 0.3e-3;

    fn law(slope: f64) -> TipEdge {
        TipEdge::new([C, RADIUS, REFERENCE, slope], Corner::NONE, 0.0).unwrap()
    }

    /// Displacement of both surfaces at `x` under the stated pressure, by quadrature: s = a sin²(t) takes
    /// the singular end away, the logarithm is integrated exactly over cells of constant density in t.
    fn displacement(slope: f64, a: f64, x: f64) -> f64 {
        let n = 20_000;
        let turn = |s: f64| (s / a).sqrt().asin();
        let at = turn(x);
        let mut sum = 0.0;
        for i in 0..n {
            let h = 0.5 * PI / f64::from(n);
            let t = (f64::from(i) + 0.5) * h;
            let s = a * t.sin().powi(2);
            let density = 2.0 * a * t.cos().powi(2) * (slope + (s + 0.5 * a) / RADIUS) / (PI * C);
            let singular = if (t - at).abs() < 1e-9 {
                (0.5 * h).ln() - 1.0 + (2.0 * at).sin().abs().max(1e-30).ln() + a.ln()
            } else {
                (s - x).abs().ln()
            };
            sum += density * h * (REFERENCE.ln() - singular);
        }
        C * sum
    }

    #[test]
    fn the_flanks_touch_all_over_the_width_of_contact() {
        for slope in [0.03, 0.0, -0.005] {
            let a = 0.15e-3;
            let h = 0.5 * PI / 20_000.0;
            let edge = displacement(slope, a, 0.0);
            for steps in [3000.5, 9000.5, 15_000.5] {
                let x = a * f64::sin(steps * h).powi(2);
                let gap = slope * x + 0.5 * x * x / RADIUS;
                // The error of the quadrature is one of the displacement, not of its difference.
                let epsilon = 5e-5 * edge;
                assert_abs_diff_eq!(edge - displacement(slope, a, x), gap, epsilon = epsilon);
            }
            let [_, _, penetration] = law(slope).state(a);
            let inside = 0.5 * slope.min(0.0).powi(2) * RADIUS;
            // The midpoint rule next to the logarithm's end leaves h ln 2 of the density there: 2e-5.
            assert_relative_eq!(penetration - inside, edge, max_relative = 1e-4);
        }
    }

    #[test]
    fn contact_that_just_reaches_the_edge_is_that_of_hertz() {
        let b = 0.1e-3;
        let law = law(-b / RADIUS);
        let w = b * b / (2.0 * RADIUS * C);
        assert_relative_eq!(law.least_line_load(), w, max_relative = 1e-13);
        let hertz = C * w * ((2.0 * REFERENCE / b).ln() + 0.5);
        assert_relative_eq!(law.least_penetration(), hertz, max_relative = 1e-13);
    }

    #[test]
    fn line_load_inverts_the_penetration_and_has_its_derivative() {
        for slope in [0.05, 1e-3, 0.0, -0.01] {
            let law = law(slope);
            for a in [0.2e-3, 0.4e-3, 0.8e-3] {
                let [_, w, x] = law.state(a);
                let (found, derivative) = law.line_load(x);
                assert_relative_eq!(found, w, max_relative = 1e-11);
                let d = 1e-6 * x;
                let numeric = (law.line_load(x + d).0 - law.line_load(x - d).0) / (2.0 * d);
                assert_relative_eq!(derivative, numeric, max_relative = 1e-6);
            }
        }
    }

    #[test]
    fn an_edge_far_away_plays_no_part() {
        let far = [C, RADIUS, REFERENCE, -1.0];
        assert_eq!(TipEdge::new(far, Corner::NONE, RADIUS), None);
        assert_abs_diff_eq!(law(0.01).line_load(1e-12).0, 0.0, epsilon = 1.0);
    }
}
