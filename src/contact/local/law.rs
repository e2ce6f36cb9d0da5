//! Local contact of one segment: force over penetration.
//!
//! The penetration under the line load w is, summed over both gears (see [`crate::compliance::ToothCompliance`]),
//!
//! h(w) = sum_g c_g w (ln(2 L_g / b) + 1/2), c_g = 2 (1 - nu_g²) / (pi E_g), b = sqrt(kappa w),
//!
//! kappa = 4 R (1/E'_1 + 1/E'_2) / pi (Hertz). h rises from zero with an infinite slope, so that its inverse starts with
//! slope zero: contact begins smoothly. With v = 2 h / (c w) the inverse is the root v > 1 of v - ln v = t, t linear in ln h.
//! Beyond a half-width of [`WIDTH_OVER_REFERENCE`] L the law goes on along its tangent. At tip edges [`TipEdge`], at the start
//! of reliefs [`Knee`] takes over.

use std::f64::consts::{FRAC_1_SQRT_2, LN_2, PI};

use super::constants::{LARGEST_HALF_WIDTH_OVER_RADIUS, WIDTH_OVER_REFERENCE};
use super::knee::{Knee, Onset};
use super::profile::GapProfile;
use super::tip_edge::{Corner, TipEdge};
use crate::contact::candidates::POINTS;

/// Force of one segment over the approach of its two flanks that the local contact takes up.
#[derive(Debug, Clone, PartialEq)]
pub struct LocalContact {
    /// Length of the segment along the contact line, m.
    length: f64,
    elastic: Elastic,
    /// kappa, m² per N/m.
    kappa: f64,
    /// t = -(ln h + this).
    log_scale: f64,
    /// Penetration from which on the law goes on along its tangent, m.
    wide: f64,
    /// Takes over from the width of contact at which one side of it ends at a tip edge.
    edge: Option<TipEdge>,
    /// Takes over from both at the width of contact at which it reaches the start of a relief.
    relief: Option<Box<Knee>>,
}

/// Elastic constants and reference length of one gear at a segment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LocalBody {
    /// (1 - nu²) / E, 1/Pa.
    pub plane_compliance: f64,
    /// Reference length L of the local contact, m.
    pub reference_length: f64,
    /// Its tip corner.
    pub corner: Corner,
}

/// What the laws of a segment share.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Elastic {
    /// c_1 + c_2, 1/Pa.
    pub c: f64,
    /// ln L, L (m) the logarithmic mean of both gears weighted with c_g.
    pub log_reference: f64,
    /// Corner of the nearest tip edge.
    pub corner: Corner,
}

/// Line load at a penetration.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LineLoad {
    /// N/m.
    pub load: f64,
    /// Its derivative by the penetration, Pa.
    pub slope: f64,
    /// Its integral over the penetration, J/m.
    pub energy: f64,
}

/// Local contact at the points of a segment.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PointLoads {
    /// Forces, N.
    pub forces: [f64; POINTS],
    /// Their derivatives by the penetrations, N/m.
    pub slopes: [f64; POINTS],
    /// Their integrals over the penetrations, J.
    pub energies: [f64; POINTS],
}

impl Elastic {
    /// h / w - dh/dw of the corner of a flat punch of the half-width `a` (m): c ln(2 L / a), 1/Pa.
    pub fn flat_punch(&self, a: f64) -> f64 {
        self.c * (self.log_reference + LN_2 - a.ln())
    }
}

impl LineLoad {
    /// By `by` (m) deeper along the tangent.
    pub fn beyond(self, by: f64) -> LineLoad {
        LineLoad {
            load: self.load + self.slope * by,
            slope: self.slope,
            energy: self.energy + by * (self.load + 0.5 * self.slope * by),
        }
    }
}

impl PointLoads {
    /// Force of the segment, N.
    pub fn force(&self) -> f64 {
        self.forces.iter().sum()
    }

    /// Derivative of the force by the penetration of all points, N/m.
    pub fn slope(&self) -> f64 {
        self.slopes.iter().sum()
    }

    /// Energy of the local contact, J.
    pub fn energy(&self) -> f64 {
        self.energies.iter().sum()
    }
}

impl LocalContact {
    /// Law of a segment of `length` (m, along the contact line) between two bodies whose gap is `profile` in the normal
    /// section.
    pub fn new(bodies: [LocalBody; 2], profile: &GapProfile, length: f64) -> LocalContact {
        let each = bodies.map(|body| 2.0 / PI * body.plane_compliance);
        let c = each[0] + each[1];
        let [first, second] = bodies.map(|body| body.reference_length.ln());
        let elastic = Elastic {
            c,
            log_reference: (each[0] * first + each[1] * second) / c,
            corner: bodies[profile.edge_gear()].corner,
        };
        let kappa = 2.0 * c / profile.curvature;
        // What the corner adds to dh/dw over c / 2; at the edge itself contact is never inside the flank.
        let line = profile.edge_distance();
        let by_corner = match line > 0.0 {
            true => 2.0 * elastic.corner.compliance(line, line) / c,
            false => 0.0,
        };
        // v = t + ln v at the half-width at which the tangent begins.
        let widest = WIDTH_OVER_REFERENCE * elastic.log_reference.exp();
        let v_wide = 1.0 + 2.0 * (2.0 / WIDTH_OVER_REFERENCE).ln();
        let mut law = LocalContact {
            length,
            elastic,
            kappa,
            log_scale: (2.0 * kappa / c).ln()
                - 2.0 * (elastic.log_reference + LN_2)
                - 1.0
                - by_corner,
            wide: 0.5 * v_wide * c * widest * widest / kappa * by_corner.exp(),
            edge: TipEdge::new(elastic, profile),
            relief: None,
        };
        law.relief = law
            .relief(profile, 0.5 * c * by_corner, widest)
            .map(Box::new);
        law
    }

    /// The law from where contact reaches the start of a relief, if it does before its half-width is `widest` (m); `by_corner` is
    /// what the corner adds to dh/dw, 1/Pa.
    fn relief(&self, profile: &GapProfile, by_corner: f64, widest: f64) -> Option<Knee> {
        let half_width = profile.room();
        if half_width >= widest {
            return None;
        }
        let (load, penetration) = match &self.edge {
            Some(edge) if half_width > profile.edge_distance() => {
                // On its tangent the law of the edge knows no width.
                if 2.0 * half_width >= edge.widest() {
                    return None;
                }
                let state = edge.state(2.0 * half_width);
                (state.at.load, state.penetration)
            }
            _ if half_width == 0.0 => (0.0, 0.0),
            _ => {
                let Elastic { c, .. } = self.elastic;
                let load = half_width * half_width / self.kappa;
                let each = self.elastic.flat_punch(half_width) + 0.5 * c + by_corner;
                (load, load * each)
            }
        };
        let at_edge = self.edge.map_or(widest, |edge| 0.5 * edge.widest());
        let onset = Onset {
            half_width,
            load,
            penetration,
            energy: self.before_relief(penetration).energy,
        };
        let widest = widest.min(at_edge.max(half_width));
        Some(Knee::new(self.elastic, profile, onset, widest))
    }

    /// Line load at the penetration `x` (m); none for x <= 0.
    pub fn line_load(&self, x: f64) -> LineLoad {
        match &self.relief {
            Some(knee) if x > knee.onset().penetration => knee.line_load(x),
            _ => self.before_relief(x),
        }
    }

    /// As [`LocalContact::line_load`] up to where contact reaches the start of a relief.
    fn before_relief(&self, x: f64) -> LineLoad {
        if x <= 0.0 {
            return LineLoad::default();
        }
        match &self.edge {
            Some(edge) if x > edge.least().penetration => edge.line_load(x),
            _ if x > self.wide => self.hertz(self.wide).beyond(x - self.wide),
            _ => self.hertz(x),
        }
    }

    /// The law of Hertz. Integral of h dw = w h / 2 + c w² / 8.
    fn hertz(&self, x: f64) -> LineLoad {
        let c = self.elastic.c;
        let v = inverse(-(x.ln() + self.log_scale));
        let load = 2.0 * x / (c * v);
        LineLoad {
            load,
            slope: 2.0 / (c * (v - 1.0)),
            energy: 0.5 * x * load - 0.125 * c * load * load,
        }
    }

    /// Local contact at the penetrations `x` (m) of the points of a segment.
    pub fn loads(&self, x: [f64; POINTS]) -> PointLoads {
        let each = x.map(|x| self.line_load(x));
        PointLoads {
            forces: each.map(|at| self.length * at.load),
            slopes: each.map(|at| self.length * at.slope),
            energies: each.map(|at| self.length * at.energy),
        }
    }

    /// Pressure, Pa, of the force `f`, N, where that is more than any flank carries
    /// ([`LARGEST_HALF_WIDTH_OVER_RADIUS`]): [`LocalContact::pressure`], and where contact reaches a tip edge that of Hertz.
    pub fn overload(&self, f: f64) -> Option<f64> {
        // b / R = pi c p, with b² = kappa w and kappa = 2 c R.
        let most = LARGEST_HALF_WIDTH_OVER_RADIUS / (PI * self.elastic.c);
        let hertz = self.hertz_pressure(f);
        let w = f.max(0.0) / self.length;
        let at_relief = self.knee_under(w).map(|knee| knee.pressure(w));
        // Whether contact reaches an edge takes longer to find than all else.
        if hertz.max(at_relief.unwrap_or(0.0)) <= most {
            return None;
        }
        self.pressure(f)
            .or(Some(hertz))
            .filter(|pressure| *pressure > most)
    }

    /// Law of the start of a relief that the line load `w` (N/m) reaches.
    fn knee_under(&self, w: f64) -> Option<&Knee> {
        self.relief.as_deref().filter(|knee| w > knee.onset().load)
    }

    /// Whether contact reaches a tip edge under the force `f`, N.
    pub fn reaches_edge(&self, f: f64) -> bool {
        f / self.length > self.load_at_edge()
    }

    /// Line load above which contact reaches a tip edge, N/m; infinite where it becomes too wide for the law before.
    pub fn load_at_edge(&self) -> f64 {
        match self.relief.as_deref() {
            // Past the start of the relief flanks close more slowly.
            Some(knee) if knee.is_inside() => knee.load_at_edge(),
            _ => (self.edge).map_or(f64::INFINITY, |edge| edge.least().at.load),
        }
    }

    /// What this law takes up under the line load `w` (N/m) more than `other` does since the displacement of the bodies is
    /// divided otherwise between it and the elastic model, m.
    pub fn takes_up_more_than(&self, other: &LocalContact, w: f64) -> f64 {
        self.elastic.c * w * (self.elastic.log_reference - other.elastic.log_reference)
    }

    /// Largest pressure, Pa, under the force `f`, N: Hertz's inside one parabola, else [`Knee::pressure`]. None where
    /// contact reaches a tip edge, where it has no bound.
    pub fn pressure(&self, f: f64) -> Option<f64> {
        if self.reaches_edge(f) {
            return None;
        }
        let at_relief = self.pressure_at_relief(f.max(0.0) / self.length);
        Some(at_relief.unwrap_or(self.hertz_pressure(f)))
    }

    /// As [`LocalContact::pressure`] under the line load `w` (N/m), where contact reaches the start of a relief and no tip edge.
    pub fn pressure_at_relief(&self, w: f64) -> Option<f64> {
        let knee = self.knee_under(w)?;
        (w <= self.load_at_edge()).then(|| knee.pressure(w))
    }

    /// Whether contact may reach the start of a relief.
    pub fn has_relief(&self) -> bool {
        self.relief.is_some()
    }

    /// Whether contact may reach a tip edge.
    pub fn has_edge(&self) -> bool {
        self.edge.is_some()
    }

    /// 2 w / (pi b), with b = sqrt(kappa w), of the force `f`, N: Hertz pressure inside one parabola, Pa.
    pub fn hertz_pressure(&self, f: f64) -> f64 {
        2.0 / PI * (f.max(0.0) / self.length / self.kappa).sqrt()
    }

    /// Length of the segment along the contact line, m.
    pub fn length(&self) -> f64 {
        self.length
    }
}

/// The root v > 1 of v - ln v = t for t > 1.1: v = -W(-e^-t), W the lower branch of Lambert's function.
///
/// Within 3e-4 by Barry, Culligan-Hensley, Barry (1995), Real values of the W-function, ACM Transactions on Mathematical
/// Software 21, 161-171; one step of fourth order (Fritsch, Shafer, Crowley (1973), Communications of the ACM 16, 123-124)
/// leaves rounding.
fn inverse(t: f64) -> f64 {
    let sigma = t - 1.0;
    let root = sigma.sqrt();
    let falling = 1.0 - 0.0042 * sigma * (-0.0201 * root).exp();
    let inner = 1.0 + 0.3361 * FRAC_1_SQRT_2 * root / falling;
    let v = 1.0 + sigma + 2.0 / 0.3361 * (1.0 - inner.recip());
    let z = v - v.ln() - t;
    let q = 2.0 * (1.0 - v) * (1.0 - v + 2.0 / 3.0 * z);
    v * (1.0 + z / (1.0 - v) * (q - z) / (q - 2.0 * z))
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    const STEEL: f64 = (1.0 - 0.09) / 206e9;

    #[test]
    fn overload_is_judged_on_the_pressure_that_is_reported() {
        let law = |profile: &GapProfile| {
            let body = LocalBody {
                plane_compliance: STEEL,
                reference_length: 0.6e-3,
                corner: Corner::NONE,
            };
            LocalContact::new([body; 2], profile, 1e-3)
        };
        let most = 0.15 / (4.0 * STEEL);
        let plain = law(&far());
        let steep = [(0.0, 1.0, 0.2, 0.0), (1.0, 1.0, 0.0, 0.0)];
        let steep = law(&GapProfile::relieved(-0.1, 1.0 / 7e-3, steep));
        let mut judged = [0; 2];
        for step in 1..200 {
            let f = 60.0 * f64::from(step);
            for law in [&plain, &steep] {
                let pressure = law.pressure(f).unwrap();
                assert_eq!(law.overload(f), (pressure > most).then_some(pressure));
                judged[usize::from(pressure > most)] += 1;
            }
            // The parabola alone would carry it.
            assert!(steep.pressure(f) > plain.pressure(f));
        }
        assert!(judged[0] > 100 && judged[1] > 100, "{judged:?}");
    }

    /// Parabola of the radius 7 mm, far from edges.
    fn far() -> GapProfile {
        GapProfile::parabola(0.0, 1.0 / 7e-3, [-1.0, 1.0])
    }

    /// Far from everything, near a tip edge, at one, dug in by it, and with reliefs on both sides.
    fn profiles() -> [GapProfile; 7] {
        let edge = |slope: f64, low: f64| GapProfile::parabola(slope, 1.0 / 7e-3, [low, 1.0]);
        let relieved = |slope: f64, at: f64| {
            let reliefs = [(at, 1.0, 0.015, 0.0), (-0.11e-3, -1.0, 0.0, 40.0)];
            GapProfile::relieved(slope, 1.0 / 7e-3, reliefs)
        };
        let mut near_edge = relieved(0.0, 0.05e-3);
        near_edge.edges[0] = -35e-6;
        [
            far(),
            edge(0.0, -35e-6),
            edge(0.0, 0.0),
            edge(0.02, 0.0),
            relieved(0.0, 0.05e-3),
            relieved(-0.004, 0.0),
            near_edge,
        ]
    }

    fn law() -> LocalContact {
        let body = |reference_length| LocalBody {
            plane_compliance: STEEL,
            reference_length,
            corner: Corner::NONE,
        };
        LocalContact::new([body(1.2e-3), body(2.0e-3)], &far(), 0.6e-3)
    }

    #[test]
    fn the_inverse_satisfies_the_stated_law() {
        let law = law();
        for w in [1e-3, 1.0, 1e3, 1e5, 5e5] {
            let b = (4.0 * w * 7e-3 * 2.0 * STEEL / std::f64::consts::PI).sqrt();
            let h: f64 = [1.2e-3, 2.0e-3]
                .iter()
                .map(|l| 2.0 * STEEL / std::f64::consts::PI * w * ((2.0 * l / b).ln() + 0.5))
                .sum();
            assert_relative_eq!(law.line_load(h).load, w, max_relative = 1e-13);
        }
    }

    #[test]
    fn the_inverse_satisfies_its_equation_all_over_the_range() {
        for i in 0..20_000 {
            let t = 1.1 + 60.0 * f64::from(i) / 20_000.0;
            let v = inverse(t);
            let error = (v - v.ln() - t) / (1.0 - v.recip());
            assert!(error.abs() < 1e-13 * v, "{t}: {v} {error}");
        }
    }

    #[test]
    fn the_derivative_is_that_of_the_force() {
        let law = law();
        for x in [1e-9, 1e-7, 2e-6, 1e-5, 1e-3, 1e-2] {
            let d = 1e-5 * x;
            let load = |x| law.line_load(x).load;
            let numeric = (load(x + d) - load(x - d)) / (2.0 * d);
            assert_relative_eq!(law.line_load(x).slope, numeric, max_relative = 1e-8);
        }
    }

    #[test]
    fn the_energy_is_the_integral_of_the_force() {
        let bodies = [1.2e-3, 2.0e-3].map(|reference_length| LocalBody {
            plane_compliance: STEEL,
            reference_length,
            corner: Corner::new(2.1, STEEL, 0.05e-3),
        });
        for profile in profiles() {
            let law = LocalContact::new(bodies, &profile, 0.6e-3);
            for x in [1e-8, 1e-6, 5e-6, 2e-5, 1e-4, 1e-3] {
                let d = 1e-4 * x;
                let energy = |x| law.line_load(x).energy;
                let slope = (energy(x + d) - energy(x - d)) / (2.0 * d);
                assert_relative_eq!(law.line_load(x).load, slope, max_relative = 1e-6);
            }
            assert_eq!(law.line_load(-1e-6).energy, 0.0);
        }
    }

    #[test]
    fn one_law_goes_over_into_the_next() {
        let bodies = [0.3e-3, 0.4e-3].map(|reference_length| LocalBody {
            plane_compliance: STEEL,
            reference_length,
            corner: Corner::new(2.1, STEEL, 0.05e-3),
        });
        for profile in profiles() {
            let law = LocalContact::new(bodies, &profile, 0.6e-3);
            let relief = law.relief.as_deref().map(|knee| knee.onset().penetration);
            let edge = law.edge.as_ref().map(|edge| edge.least().penetration);
            for at in [relief, edge].into_iter().flatten().filter(|x| *x > 0.0) {
                let [below, above] = [1.0 - 1e-9, 1.0 + 1e-9].map(|near| near * at);
                let [below, above] = [below, above].map(|x| law.line_load(x));
                assert_relative_eq!(below.load, above.load, max_relative = 1e-7);
                assert_relative_eq!(below.slope, above.slope, max_relative = 1e-7);
                assert_relative_eq!(below.energy, above.energy, max_relative = 1e-7);
            }
        }
    }

    #[test]
    fn pressure_is_that_of_hertz_for_two_cylinders() {
        // p = sqrt(w E* / (pi R)), 1/E* = 2 (1 - nu^2) / E.
        let p = (1e5 / (2.0 * STEEL) / (std::f64::consts::PI * 7e-3)).sqrt();
        assert_relative_eq!(
            law().pressure(1e5 * 0.6e-3).unwrap(),
            p,
            max_relative = 1e-13
        );
    }
}
