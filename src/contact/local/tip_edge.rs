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
//! the flat punch of the present width, since a is stationary, and at the corner of a tooth what [`Corner`] adds, to
//! first order: the pressure is taken as it is between half-planes. h and w in closed form follow below.

use std::f64::consts::{LN_2, PI};

use super::constants::WIDTH_OVER_REFERENCE;
use super::law::{Elastic, LineLoad};
use super::profile::GapProfile;

/// Tip corner of one gear: how much more the tooth gives way close to its tip edge than a half-plane.
///
/// Flank and tip land enclose the angle phi = 90 degrees + the pressure angle at the tip. At distances beyond that of a load
/// from the edge, stress is that of a force on the apex of a wedge (Michell; Timoshenko and Goodier, Theory of Elasticity, 1951,
/// section 35), and the displacement along a force normal to the flank falls with the logarithm of the distance, as that of a
/// half-plane does, but
///
/// 1 + r = pi (phi + sin phi cos phi) / (phi² - sin² phi)
///
/// times as fast: 1.4 times at 121 degrees. So loads at the distances x and y from the edge are taken to give way to each
/// other by -r c_g ln(x + y) more than on a half-plane, c_g = 2 (1 - nu²) / (pi E). The elastic model holds this down to the
/// size of its elements there; for a contact nearer to the edge, or wider, the difference is added to the law of the local
/// contact. Contact grows by the pressure of a flat punch of its width; the mean of ln(x + y) under that is ln(2 m) within 0.22,
/// m the distance of its middle from the edge, so that
///
/// dh/dw = c ln(2 L / a) + r c_g ln(d / m),
///
/// d that of the contact line, no less than what the elements resolve. Measured (docs/theory/compliance.md): with it, single
/// transmission errors at tip edges of 20/20 teeth come within 0.4 % instead of 1 %, at a ring's edge within 0.9 % instead of 1.5 %.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Corner {
    /// r c_g, 1/Pa.
    pub softness: f64,
    /// Distance from the edge down to which the elastic model holds it, m.
    resolved: f64,
}

impl Corner {
    /// A half-plane.
    pub const NONE: Corner = Corner {
        softness: 0.0,
        resolved: 0.0,
    };

    /// The corner of the angle `angle` (rad, in the tooth) of a gear with the plane compliance (1 - nu²) / E `plane_compliance`
    /// (1/Pa), which an elastic model holds down to the distance `resolved` (m) from the edge; zero: [`Corner::NONE`].
    pub fn new(angle: f64, plane_compliance: f64, resolved: f64) -> Corner {
        if resolved <= 0.0 {
            return Corner::NONE;
        }
        let (sin, cos) = angle.sin_cos();
        let more = PI * (angle + sin * cos) / (angle * angle - sin * sin) - 1.0;
        Corner {
            softness: more * 2.0 * plane_compliance / PI,
            resolved,
        }
    }

    /// d of a contact line at the distance `line` from the edge, m.
    fn held(&self, line: f64) -> f64 {
        line.max(self.resolved)
    }

    /// dh/dw beyond that of half-planes, 1/Pa, of a contact whose middle is at the distance `middle` (m) from the edge, that of its
    /// line being `line` (m).
    pub fn compliance(&self, line: f64, middle: f64) -> f64 {
        let held = self.held(line);
        if self.softness == 0.0 || held == middle {
            return 0.0;
        }
        self.softness * (held / middle).ln()
    }
}

/// Law of contact at a tip edge, per length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TipEdge {
    /// c, 1/Pa.
    c: f64,
    /// 1 / R, 1/m.
    curvature: f64,
    /// c and what the corner adds, 1/Pa.
    with_corner: f64,
    /// ln of the width at which dh/dw = `with_corner` (this - ln a) ends.
    log_end: f64,
    /// alpha.
    slope: f64,
    /// What the law of Hertz has taken up beyond this one where contact just reaches the edge, m.
    inside: f64,
    /// Energy by the law of Hertz up to where contact reaches the edge, less that of this law, J/m.
    more_before: f64,
    /// Where contact reaches the edge.
    least: State,
    /// Where the tangent begins.
    wide: State,
}

/// Contact of one width.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct State {
    /// m.
    pub width: f64,
    /// m.
    pub penetration: f64,
    /// At this penetration; the energy with that of Hertz up to where contact reaches the edge.
    pub at: LineLoad,
}

impl TipEdge {
    /// Law at the nearest tip edge of `profile`. None where contact becomes too wide for the law before it reaches the edge.
    pub fn new(elastic: Elastic, profile: &GapProfile) -> Option<TipEdge> {
        let Elastic {
            c,
            log_reference,
            corner,
        } = elastic;
        let (slope, curvature) = (profile.edge_slope(), profile.curvature);
        let held = corner.held(profile.edge_distance());
        let least = (-2.0 * slope / curvature).max(0.0);
        // Far inside the flank, as most segments are: the width of the tangent is a mean of 3 L and twice the distance from the
        // edge, which is the least width up to rounding.
        if least > (1.0 - 1e-9) * 2.0 * (2.0 * log_reference.exp()).max(held) {
            return None;
        }
        let with_corner = c + corner.softness;
        let mut log_end = log_reference + 2.0 * LN_2;
        if corner.softness > 0.0 {
            log_end = (c * log_end + corner.softness * (LN_2 + held.ln())) / with_corner;
        }
        // Where dh/dw is that of the law of Hertz at its tangent; without a corner the whole width, where that law counts by
        // half of it.
        let wide = (log_end - c / with_corner * (2.0 / WIDTH_OVER_REFERENCE).ln()).exp();
        // NaN where the curvatures cancel: no law of an edge either.
        if least.is_nan() || wide.is_nan() || least >= wide {
            return None;
        }
        let inside = slope.min(0.0);
        let mut edge = TipEdge {
            inside: 0.25 * (1.0 + with_corner / c) * inside * inside / curvature,
            c,
            curvature,
            with_corner,
            log_end,
            slope,
            more_before: 0.0,
            least: State::default(),
            wide: State::default(),
        };
        if least > 0.0 {
            edge.least = edge.state(least);
            let State {
                penetration, at, ..
            } = edge.least;
            let hertz = 0.5 * penetration * at.load - 0.125 * c * at.load * at.load;
            edge.more_before = hertz - at.energy;
            edge.least.at.energy = hertz;
        }
        edge.wide = edge.state(wide);
        Some(edge)
    }

    /// Where contact reaches the edge.
    pub fn least(&self) -> State {
        self.least
    }

    /// Width of contact from which on the law goes on along its tangent, m.
    pub fn widest(&self) -> f64 {
        self.wide.width
    }

    /// Contact of the width `a` (m) > 0 up to [`TipEdge::widest`].
    ///
    /// With w and dw/da as here and dh/dw = c' (l - ln a), w dh is (alpha²/4 a + 9 alpha/(16 R) a² + 9/(32 R²) a³) (l - ln a) c' / c²
    /// da.
    pub fn state(&self, a: f64) -> State {
        let log = self.log_end - a.ln();
        let (slope, bend) = (self.slope, self.curvature * a);
        let per_c = self.c.recip();
        let of_slope = 0.5 * (slope + 0.5 * bend) * a * per_c;
        let of_curvature = 0.125 * a * bend * per_c;
        // Minus the means of ln s under both parts of the pressure.
        let at_edge = self.with_corner * (of_slope * (log + 1.0) + of_curvature * (log - 0.5));
        let work = 0.125 * slope * slope * (log + 1.0 / 2.0)
            + 0.1875 * slope * bend * (log + 1.0 / 3.0)
            + 0.0703125 * bend * bend * (log + 1.0 / 4.0);
        State {
            width: a,
            penetration: at_edge + self.inside,
            at: LineLoad {
                load: of_slope + of_curvature,
                slope: (self.with_corner * log).recip(),
                energy: self.more_before + a * a * work * self.with_corner * per_c * per_c,
            },
        }
    }

    /// Line load at the penetration `x` (m) beyond the least one.
    pub fn line_load(&self, x: f64) -> LineLoad {
        let wide = &self.wide;
        if x >= wide.penetration {
            return wide.at.beyond(x - wide.penetration);
        }
        // From a parabola with the slope at the least width and the other end.
        let (mut low, mut high) = (self.least.width, wide.width);
        let (way, range) = (
            x - self.least.penetration,
            wide.penetration - self.least.penetration,
        );
        let rise = |state: &State| self.growth(state.width) / state.at.slope * (high - low);
        let first = if low > 0.0 {
            rise(&self.least).min(range)
        } else {
            0.0
        };
        let second = range - first;
        let part = 2.0 * way / (first + (first * first + 4.0 * second * way).sqrt());
        let mut state = self.state(low + (high - low) * part);
        for _ in 0..100 {
            if state.penetration > x {
                high = state.width;
            } else {
                low = state.width;
            }
            // dh/da and half of its own slope over it, for a step of Halley's method.
            let growth = self.growth(state.width);
            let by_width = growth / state.at.slope;
            let bend = 0.375 * self.curvature / (self.c * growth)
                - 0.5 * self.with_corner * state.at.slope / state.width;
            let way = (x - state.penetration) / by_width;
            let halley = state.width + way / (1.0 + way * bend);
            let inside = low < halley && halley < high;
            let next = if inside { halley } else { 0.5 * (low + high) };
            let step = (next - state.width).abs();
            state = self.state(next);
            // Cubic: what a step leaves is the third power of it.
            let enough = if inside { 1e-6 } else { 4.0 * f64::EPSILON };
            if step <= enough * next {
                break;
            }
        }
        state.at
    }

    /// dw/da at the width `a`, N/m².
    fn growth(&self, a: f64) -> f64 {
        (0.5 * self.slope + 0.75 * a * self.curvature) / self.c
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::{assert_abs_diff_eq, assert_relative_eq};

    const C: f64 = 4.0 * (1.0 - 0.09) / (PI * 206e9);
    const RADIUS: f64 = 8e-3;
    const REFERENCE: f64 = 0.3e-3;

    fn elastic() -> Elastic {
        Elastic {
            c: C,
            log_reference: f64::ln(REFERENCE),
            corner: Corner::NONE,
        }
    }

    fn law(slope: f64) -> TipEdge {
        let profile = GapProfile::parabola(slope, RADIUS.recip(), [0.0, 1.0]);
        TipEdge::new(elastic(), &profile).unwrap()
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
            let penetration = law(slope).state(a).penetration;
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
        assert_relative_eq!(law.least().at.load, w, max_relative = 1e-13);
        let hertz = C * w * ((2.0 * REFERENCE / b).ln() + 0.5);
        assert_relative_eq!(law.least().penetration, hertz, max_relative = 1e-13);
    }

    #[test]
    fn line_load_inverts_the_penetration_and_has_its_derivative() {
        for slope in [0.05, 1e-3, 0.0, -0.01] {
            let law = law(slope);
            for a in [0.2e-3, 0.4e-3, 0.8e-3] {
                let State {
                    at, penetration: x, ..
                } = law.state(a);
                let found = law.line_load(x);
                assert_relative_eq!(found.load, at.load, max_relative = 1e-11);
                let d = 1e-6 * x;
                let numeric = (law.line_load(x + d).load - law.line_load(x - d).load) / (2.0 * d);
                assert_relative_eq!(found.slope, numeric, max_relative = 1e-6);
            }
        }
    }

    #[test]
    fn an_edge_far_away_plays_no_part() {
        let far = GapProfile::parabola(0.0, RADIUS.recip(), [-RADIUS, 1.0]);
        assert_eq!(TipEdge::new(elastic(), &far), None);
        assert_abs_diff_eq!(law(0.01).line_load(1e-12).load, 0.0, epsilon = 1.0);
    }

    #[test]
    fn a_half_plane_has_no_corner_and_a_quarter_plane_that_of_michell() {
        assert_abs_diff_eq!(Corner::new(PI, 4e-12, 1e-5).softness, 0.0, epsilon = 1e-24);
        // Force on the apex of a quarter-plane along one face: components of 1/sqrt(2) along the bisector and across it.
        let parts = 0.5 / (0.25 * PI + 0.5) + 0.5 / (0.25 * PI - 0.5);
        let c = 2.0 * 4e-12 / PI;
        let found = Corner::new(0.5 * PI, 4e-12, 1e-5).softness;
        assert_relative_eq!(found, c * (0.5 * PI * parts - 1.0), max_relative = 1e-12);
    }

    #[test]
    fn only_what_is_closer_to_the_edge_than_the_elements_resolve_gives_way_more() {
        let corner = Corner::new(2.1, 4e-12, 5e-5);
        assert_eq!(corner.compliance(8e-5, 8e-5), 0.0);
        assert!(corner.compliance(1e-5, 1e-5) > 0.0);
        assert!(corner.compliance(0.0, 2e-4) < 0.0);
    }
}
