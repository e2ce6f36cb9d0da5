//! Local contact of one segment: line load over penetration, by the gap in its normal section.
//!
//! Symbols and derivation: docs/theory/compliance.md. A contact from m - a to m + a under the line load w has
//! h = G + c w ln(2 L / a), c w = a dG/da, dG/dm = 0: of all contacts the one that carries most at the penetration h (Barber,
//! Int. J. Solids Structures 10 (1974) 5-8). So dh/dw = c ln(2 L / a) whatever the gap; [`Corner`] adds to it at a tip edge,
//! where m - a stays while a grows.
//!
//! A parabola gives the law of Hertz, with b² = kappa w = 2 c R w. Its inverse, with v = 2 h / (c w), is the root v > 1 of
//! v - ln v = t, t linear in ln h. From the width on at which contact reaches a tip edge or the start of a relief, contacts
//! of given width are solved exactly, and between them the law is the cubic through line loads and slopes. Its energy is
//! the integral of just that. Where dh/dw has fallen to that of Hertz at b = [`WIDTH_OVER_REFERENCE`] L the law goes on
//! along its tangent.

use std::f64::consts::{FRAC_1_PI, FRAC_1_SQRT_2, LN_2, PI};
use std::sync::OnceLock;

use super::gap::GapProfile;

/// Points of a segment, middles of equal parts, at which local contact is evaluated: its edge crosses a segment in small steps.
pub const POINTS: usize = 4;

/// Half-width over the reference length from which the law goes on along its tangent: dh/dw vanishes at b = 2 L. The tangent keeps
/// the problem convex; at b = 2 L it is softer by 0.07 c w, a hundredth of the deflection of a tooth pair.
const WIDTH_OVER_REFERENCE: f64 = 1.5;

/// Half-width over the relative radius of curvature beyond which a load is refused: 8.5 GPa between steel flanks, twice what rolling
/// bearings are allowed before a dent remains (ISO 76: 4 to 4.6 GPa).
const LARGEST_HALF_WIDTH_OVER_RADIUS: f64 = 0.15;

/// Contacts solved between the end of the law of Hertz and the tangent. Measured: line loads within 1e-3, at a relief within 5e-3.
const NODES: usize = 12;

/// Tip corner of one gear: how much more the tooth gives way close to its tip edge than a half-plane.
///
/// The tooth is a wedge there, 1 + r times as soft (docs/theory/compliance.md): loads at the distances x and y from the edge give
/// way to each other by -r c_g ln(x + y) more than on a half-plane. The elastic model resolves this down to the size of its
/// elements; for a contact nearer to the edge, or wider, the difference is added to the local law. The mean of ln(x + y) under
/// the pressure of a flat punch is ln(2 m) within 0.22, m the distance of its middle from the edge, so that
/// dh/dw = c ln(2 L / a) + r c_g ln(d / m), d that of the contact line, no less than what the elements resolve. Measured: single
/// transmission errors at tip edges of 20/20 teeth come within 0.4 % instead of 1 %, at a ring's edge within 0.9 instead of 1.5 %.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Corner {
    /// r c_g, 1/Pa.
    softness: f64,
    /// Distance from the edge down to which the elastic model resolves it, m.
    resolved: f64,
}

impl Corner {
    /// A half-plane.
    pub const NONE: Corner = Corner {
        softness: 0.0,
        resolved: 0.0,
    };

    /// The corner of the angle `angle` (rad, in the tooth) of a gear with the plane compliance (1 - nu²) / E `plane_compliance`
    /// (1/Pa), which an elastic model resolves down to the distance `resolved` (m) from the edge; zero: [`Corner::NONE`].
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

    /// dh/dw beyond that of half-planes, 1/Pa, of a contact whose middle is at the distance `middle` (m) from the edge, that of its
    /// line being `line` (m).
    fn compliance(&self, line: f64, middle: f64) -> f64 {
        let resolved = line.max(self.resolved);
        if self.softness == 0.0 || resolved == middle {
            return 0.0;
        }
        self.softness * (resolved / middle).ln()
    }
}

/// How one gear gives way close to the contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LocalBody {
    /// (1 - nu²) / E, 1/Pa.
    pub plane_compliance: f64,
    /// How much more the tooth gives way at its tip edge than a half-plane.
    pub corner: Corner,
}

#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LineLoad {
    /// N/m.
    pub load: f64,
    /// Its derivative by the penetration, Pa.
    pub slope: f64,
    /// Its integral over the penetration, J/m.
    pub energy: f64,
}

impl LineLoad {
    fn beyond(self, by: f64) -> LineLoad {
        LineLoad {
            load: self.load + self.slope * by,
            slope: self.slope,
            energy: self.energy + by * (self.load + 0.5 * self.slope * by),
        }
    }
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

/// Force of one segment over the approach of its two flanks that the local contact takes up.
#[derive(Debug, Clone, PartialEq)]
pub struct LocalContact {
    length: f64,
    profile: GapProfile,
    c: f64,
    /// ln L, L (m) the logarithmic mean of both gears weighted with c_g.
    log_reference: f64,
    /// Corner of the nearest tip edge.
    corner: Corner,
    /// kappa, m² per N/m.
    kappa: f64,
    /// t = -(ln h + this).
    log_scale: f64,
    /// Half-width from which on the law goes on along its tangent, m.
    widest: f64,
    hertz_end: Contact,
    /// Wider contacts, solved when they are first needed; None where only the tangent follows.
    wider: Option<Box<[OnceLock<Contact>; NODES]>>,
    load_at_edge: OnceLock<f64>,
}

#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Contact {
    /// Half-width and middle, m.
    half_width: f64,
    middle: f64,
    /// m.
    penetration: f64,
    at: LineLoad,
    /// What the corner adds to the penetration, m, and to its derivative by the line load, 1/Pa.
    by_corner: f64,
    added: f64,
    /// Mean square distance of the pressure from its middle over the line load, m² per N/m; with Hertz constant.
    spread: f64,
}

impl LocalContact {
    /// Law of a segment of `length` (m, along the contact line) between bodies with these reference lengths (m).
    pub fn new(
        bodies: &[LocalBody; 2],
        reference_lengths: [f64; 2],
        profile: &GapProfile,
        length: f64,
    ) -> LocalContact {
        let each = bodies.map(|body| 2.0 / PI * body.plane_compliance);
        let c = each[0] + each[1];
        let [first, second] = reference_lengths.map(f64::ln);
        let log_reference = (each[0] * first + each[1] * second) / c;
        let corner = bodies[profile.edge_gear()].corner;
        let kappa = 2.0 * c / profile.curvature;
        let line = profile.edge_distance();
        let added = if line > 0.0 {
            corner.compliance(line, line)
        } else {
            0.0
        };
        let mut law = LocalContact {
            length,
            profile: *profile,
            c,
            log_reference,
            corner,
            kappa,
            log_scale: (2.0 * kappa / c).ln()
                - 2.0 * (log_reference + LN_2)
                - 1.0
                - 2.0 * added / c,
            widest: 0.0,
            hertz_end: Contact::default(),
            wider: None,
            load_at_edge: OnceLock::new(),
        };
        law.widest = law.tangent_half_width(line, added);
        let first_end = line.min(profile.relief_distance());
        let a = first_end.min(law.widest);
        if a > 0.0 {
            let load = a * a / kappa;
            let compliance = law.flat_punch(a) + added;
            let penetration = load * (compliance + 0.5 * c);
            law.hertz_end = Contact {
                half_width: a,
                middle: 0.0,
                penetration,
                at: LineLoad {
                    load,
                    slope: compliance.recip(),
                    energy: 0.5 * penetration * load - 0.125 * c * load * load,
                },
                by_corner: added * load,
                added,
                spread: 0.25 * kappa,
            };
        }
        let [low, high] = profile.edges;
        law.widest = law.widest.min(0.5 * (high - low)).max(a);
        law.wider = (a < law.widest).then(Box::default);
        law
    }

    /// h / w - dh/dw of a flat punch of the half-width `a` (m): c ln(2 L / a), 1/Pa.
    fn flat_punch(&self, a: f64) -> f64 {
        self.c * (self.log_reference + LN_2 - a.ln())
    }

    fn tangent_compliance(&self) -> f64 {
        self.c * (2.0 / WIDTH_OVER_REFERENCE).ln()
    }

    /// Half-width at which dh/dw has fallen to that of the tangent, m; see [`Corner::compliance`] for `line` and `added`.
    fn tangent_half_width(&self, line: f64, added: f64) -> f64 {
        let widest = WIDTH_OVER_REFERENCE * (self.log_reference + added / self.c).exp();
        if widest <= line || self.corner.softness == 0.0 {
            return widest;
        }
        let Corner { softness, resolved } = self.corner;
        let sum = self.c * (self.log_reference + LN_2) + softness * line.max(resolved).ln()
            - self.tangent_compliance();
        (sum / (self.c + softness)).exp()
    }

    fn contact(&self, i: usize) -> &Contact {
        match (i, &self.wider) {
            (1.., Some(wider)) => wider[i - 1].get_or_init(|| self.wider_contact(i)),
            _ => &self.hertz_end,
        }
    }

    fn wider_contact(&self, i: usize) -> Contact {
        let before = self.contact(i - 1);
        let share = (i as f64 / NODES as f64).powi(2);
        let least = self.hertz_end.half_width;
        let a = least + (self.widest - least) * share;
        let onwards = match i.checked_sub(2).map(|other| self.contact(other)) {
            Some(other) => (before.middle - other.middle) / (before.half_width - other.half_width),
            None => 0.0,
        };
        let start = before.middle + onwards * (a - before.half_width);
        let middle = self.profile.middle(a, start);
        let means = self.profile.means(middle, a);
        let load = means.by_log_width / self.c;
        let compliance = self.flat_punch(a);
        // Before an edge cuts contact off, its middle is that of the line: far edges play no part.
        let line = self.profile.edge_distance();
        let most = self.tangent_compliance() - compliance;
        let added = (self.corner.compliance(line, a.max(line))).max(most.min(0.0));
        let by_corner = if before.half_width == 0.0 && line == 0.0 {
            // w rises as a does under a slope, as a² without.
            let power = 2.0 - a * self.profile.slope.abs() / means.by_log_width;
            (added + self.corner.softness / power) * load
        } else if before.half_width == 0.0 || before.added == added {
            before.by_corner + added * (load - before.at.load)
        } else {
            let rise = load - before.at.load;
            let mean_load = rise / (rise / before.at.load).ln_1p();
            before.by_corner + added * load
                - before.added * before.at.load
                - (added - before.added) * mean_load
        };
        let penetration = means.gap + load * compliance + by_corner;
        let slope = (compliance + added).recip();
        let step = penetration - before.penetration;
        let curved = step * (before.at.slope - slope) / 12.0;
        let [first, second] = means.coefficients.map(|g| g / (2.0 * self.c * load));
        Contact {
            half_width: a,
            middle,
            penetration,
            at: LineLoad {
                load,
                slope,
                energy: before.at.energy + step * (0.5 * (before.at.load + load) + curved),
            },
            by_corner,
            added,
            spread: a * a * (0.5 - second - first * first) / load,
        }
    }

    /// The contacts about `value`, by what `of_contact` says of each; `None` beyond the last one.
    fn around(&self, value: f64, of_contact: impl Fn(&Contact) -> f64) -> Option<[&Contact; 2]> {
        let last = if self.wider.is_some() { NODES } else { 0 };
        let above = (1..=last).find(|&i| value < of_contact(self.contact(i)))?;
        Some([self.contact(above - 1), self.contact(above)])
    }

    /// Line load at the penetration `x` (m); none for x <= 0.
    pub fn line_load(&self, x: f64) -> LineLoad {
        if x <= 0.0 {
            return LineLoad::default();
        }
        if x < self.hertz_end.penetration {
            return self.hertz(x);
        }
        let Some([first, second]) = self.around(x, |contact| contact.penetration) else {
            let last = self.contact(NODES);
            return last.at.beyond(x - last.penetration);
        };
        let (a, b) = (first.at, second.at);
        let step = second.penetration - first.penetration;
        let t = (x - first.penetration) / step;
        // w = w_a + s_a d + q d² + r d³, d = t step; q and r times step² and step³.
        let rise = b.load - a.load;
        let (s_a, s_b) = (step * a.slope, step * b.slope);
        let (q, r) = (3.0 * rise - 2.0 * s_a - s_b, s_a + s_b - 2.0 * rise);
        LineLoad {
            load: a.load + t * (s_a + t * (q + t * r)),
            slope: (s_a + t * (2.0 * q + 3.0 * t * r)) / step,
            energy: a.energy + step * t * (a.load + t * (s_a / 2.0 + t * (q / 3.0 + t * r / 4.0))),
        }
    }

    /// The law of Hertz. Integral of h dw = w h / 2 + c w² / 8.
    fn hertz(&self, x: f64) -> LineLoad {
        let c = self.c;
        let v = inverse(-(x.ln() + self.log_scale));
        let load = 2.0 * x / (c * v);
        LineLoad {
            load,
            slope: 2.0 / (c * (v - 1.0)),
            energy: 0.5 * x * load - 0.125 * c * load * load,
        }
    }

    /// Local contact at the penetrations `x` (m) of the points.
    pub fn loads(&self, x: [f64; POINTS]) -> PointLoads {
        let each = x.map(|x| self.line_load(x));
        PointLoads {
            forces: each.map(|at| self.length * at.load),
            slopes: each.map(|at| self.length * at.slope),
            energies: each.map(|at| self.length * at.energy),
        }
    }

    /// Largest pressure, Pa, under the line load `w`, N/m: Hertz's inside one parabola, else that of the half-ellipse of the same
    /// load and the same mean square distance from its middle. None where contact reaches a tip edge, where it has no bound.
    pub fn pressure(&self, w: f64) -> Option<f64> {
        let wider = || self.pressure_beyond_hertz(w);
        (w <= self.load_at_edge()).then(|| wider().unwrap_or(self.hertz_pressure(w)))
    }

    /// The same where contact reaches the start of a relief; None elsewhere.
    ///
    /// At a sharp kink pressure has no bound; this is what it is at one that is rounded over one to one and a quarter half-widths
    /// of the contact.
    pub fn pressure_at_relief(&self, w: f64) -> Option<f64> {
        let pressure = self.pressure_beyond_hertz(w)?;
        (w <= self.load_at_edge()).then_some(pressure)
    }

    fn pressure_beyond_hertz(&self, w: f64) -> Option<f64> {
        if self.wider.is_none() || w <= self.hertz_end.at.load {
            return None;
        }
        let spread = match self.around(w, |contact| contact.at.load) {
            None => self.contact(NODES).spread,
            Some([a, b]) => {
                let t = (w - a.at.load) / (b.at.load - a.at.load);
                a.spread + t * (b.spread - a.spread)
            }
        };
        Some(FRAC_1_PI * (w / spread).sqrt())
    }

    /// 2 w / (pi b), with b = sqrt(kappa w), of the line load `w`, N/m: Hertz pressure inside one parabola, Pa.
    pub fn hertz_pressure(&self, w: f64) -> f64 {
        2.0 / PI * (w.max(0.0) / self.kappa).sqrt()
    }

    /// Pressure, Pa, of the line load `w`, N/m, where no flank carries it: as [`LocalContact::pressure`], at a tip edge that of Hertz.
    pub fn overload(&self, w: f64) -> Option<f64> {
        // b / R = pi c p, with b² = kappa w and kappa = 2 c R.
        let most = LARGEST_HALF_WIDTH_OVER_RADIUS / (PI * self.c);
        let hertz = self.hertz_pressure(w);
        let wider = self.pressure_beyond_hertz(w);
        // Whether contact reaches an edge takes longer to find than all else.
        if hertz.max(wider.unwrap_or(0.0)) <= most {
            return None;
        }
        let pressure = self.pressure(w).unwrap_or(hertz);
        (pressure > most).then_some(pressure)
    }

    /// Line load above which contact reaches a tip edge, N/m; infinite where it becomes too wide for the law before.
    pub fn load_at_edge(&self) -> f64 {
        *self.load_at_edge.get_or_init(|| self.find_load_at_edge())
    }

    fn find_load_at_edge(&self) -> f64 {
        if self.wider.is_none() || !self.has_edge(0.0) {
            return f64::INFINITY;
        }
        let (end, distance) = (&self.hertz_end, self.profile.edge_distance());
        if end.half_width == distance {
            return end.at.load;
        }
        // Past the start of a relief: between the contacts of which the first is inside and the second cut off by the edge.
        let mut inside: Option<(&Contact, f64)> = None;
        for i in 0..=NODES {
            let contact = self.contact(i);
            if contact.half_width == 0.0 || distance > 2.0 * contact.half_width {
                continue;
            }
            let cut = self.profile.cut(contact.half_width);
            if cut > 0.0 {
                let reaching = match inside {
                    Some((before, other)) => {
                        let rise = contact.at.load - before.at.load;
                        before.at.load + rise * other / (other - cut)
                    }
                    None => self.contact(i.saturating_sub(1)).at.load,
                };
                return reaching.max(end.at.load);
            }
            inside = Some((contact, cut));
        }
        f64::INFINITY
    }

    /// How much more this law takes up under the line load `w` (N/m) than `other`, by the division between it and the bulk, m.
    pub fn takes_up_more_than(&self, other: &LocalContact, w: f64) -> f64 {
        self.c * w * (self.log_reference - other.log_reference)
    }

    /// Whether contact that moves by up to `moves` (m) may reach the start of a relief.
    pub fn has_relief(&self, moves: f64) -> bool {
        self.profile.relief_distance() < self.widest + moves
    }

    /// Whether contact that moves by up to `moves` (m) may reach a tip edge.
    pub fn has_edge(&self, moves: f64) -> bool {
        self.profile.edge_distance() < self.widest + moves
    }

    /// The gap that it is the law of.
    pub fn profile(&self) -> &GapProfile {
        &self.profile
    }

    /// Length along the contact line, m.
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
    use approx::{assert_abs_diff_eq, assert_relative_eq};

    const STEEL: f64 = (1.0 - 0.09) / 206e9;
    const C: f64 = 4.0 * STEEL / PI;
    const RADIUS: f64 = 8e-3;
    const REFERENCE: f64 = 0.3e-3;
    const LENGTH: f64 = 0.6e-3;
    const NO_RELIEF: (f64, f64, f64, f64) = (1.0, 1.0, 0.0, 0.0);

    fn law_with(profile: &GapProfile, reference_lengths: [f64; 2], corner: Corner) -> LocalContact {
        let plane_compliance = STEEL;
        let body = LocalBody {
            plane_compliance,
            corner,
        };
        LocalContact::new(&[body; 2], reference_lengths, profile, LENGTH)
    }

    fn law(profile: &GapProfile) -> LocalContact {
        law_with(profile, [REFERENCE; 2], Corner::NONE)
    }

    fn corner() -> Corner {
        Corner::new(2.1, STEEL, 0.05e-3)
    }

    fn far() -> GapProfile {
        GapProfile::parabola(0.0, RADIUS.recip(), [-1.0, 1.0])
    }

    /// A tip edge `distance` before the closest point, at which the gap has the slope `slope`.
    fn near_edge(slope: f64, distance: f64) -> GapProfile {
        GapProfile::parabola(slope, RADIUS.recip(), [-distance, 1.0])
    }

    /// Slope jumps as those of short strong reliefs, parabolas as those of short ones.
    fn relieved() -> [GapProfile; 4] {
        let new = |slope: f64, reliefs| GapProfile::relieved(slope, RADIUS.recip(), reliefs);
        [
            new(0.0, [(0.05e-3, 1.0, 0.012, 0.0), NO_RELIEF]),
            new(-0.006, [(0.0, 1.0, 0.012, 0.0), NO_RELIEF]),
            new(
                0.0,
                [(0.02e-3, 1.0, 0.006, 0.0), (-0.1e-3, -1.0, 0.01, 0.0)],
            ),
            new(
                0.0,
                [(0.06e-3, 1.0, 0.0, 60.0), (-0.08e-3, -1.0, 0.004, 30.0)],
            ),
        ]
    }

    /// Far from everything, near a tip edge, at one, dug in by it, and with reliefs without and with an edge.
    fn profiles() -> Vec<GapProfile> {
        let mut cut_off = relieved()[2];
        cut_off.edges[0] = -0.035e-3;
        let edges = [(0.0, 0.035e-3), (0.0, 0.0), (0.02, 0.0)];
        let edges = edges.map(|(slope, distance)| near_edge(slope, distance));
        [far(), cut_off]
            .into_iter()
            .chain(edges)
            .chain(relieved())
            .collect()
    }

    /// Line load, root mean square spread and largest value of the pressure at the penetration `x` (m), by pressures that are
    /// constant on `n` cells within `range` and fulfil the conditions of contact in their middles.
    fn by_cells(profile: &GapProfile, x: f64, range: [f64; 2], n: usize) -> [f64; 3] {
        let h = (range[1] - range[0]) / n as f64;
        let at = |i: usize| range[0] + (i as f64 + 0.5) * h;
        // Integral of ln(L / abs(t)) from -inf on, so that a cell is a difference.
        let primitive = |t: f64| t * (REFERENCE.ln() - t.abs().ln() + 1.0);
        let mut touches = vec![true; n];
        loop {
            let on: Vec<usize> = (0..n).filter(|&i| touches[i]).collect();
            let matrix = nalgebra::DMatrix::from_fn(on.len(), on.len(), |r, s| {
                let t = at(on[r]) - at(on[s]);
                C * (primitive(t + 0.5 * h) - primitive(t - 0.5 * h))
            });
            let right = nalgebra::DVector::from_fn(on.len(), |r, _| x - profile.gap(at(on[r])));
            let pressure = matrix.lu().solve(&right).unwrap();
            let pulls: Vec<usize> = (0..on.len()).filter(|&r| pressure[r] < 0.0).collect();
            if pulls.is_empty() {
                let load: f64 = pressure.iter().sum::<f64>() * h;
                let mean = |power: i32, from: f64| {
                    let moments = pressure.iter().zip(&on);
                    moments
                        .map(|(p, &i)| p * h * (at(i) - from).powi(power))
                        .sum::<f64>()
                        / load
                };
                let spread = (mean(2, mean(1, 0.0)) + h * h / 12.0).sqrt();
                return [load, spread, pressure.max()];
            }
            // Those that pull least may press once others are open.
            let most = pulls.iter().map(|&r| pressure[r]).fold(0.0, f64::min);
            let open = pulls.iter().filter(|&&r| pressure[r] <= 0.3 * most);
            open.for_each(|&r| touches[on[r]] = false);
        }
    }

    #[test]
    fn load_and_spread_are_those_of_pressures_cell_by_cell() {
        for profile in profiles() {
            let law = law(&profile);
            for x in [2e-6, 4e-6] {
                let range = [f64::max(-0.3e-3, profile.edges[0]), 0.3e-3];
                let [load, spread, _] = by_cells(&profile, x, range, 300);
                let found = law.line_load(x).load;
                assert_relative_eq!(found, load, max_relative = 3e-3);
                if let Some(pressure) = law.pressure(found) {
                    let half_width = 2.0 / PI * found / pressure;
                    assert_relative_eq!(half_width, 2.0 * spread, max_relative = 1e-2);
                }
            }
        }
    }

    /// With s the distance from the edge the pressure is sqrt((a - s) / s) (alpha + (s + a / 2) / R) / (pi c) (Johnson).
    #[test]
    fn contact_that_an_edge_cuts_off_is_that_of_a_punch_with_one_sharp_end() {
        for corner in [Corner::NONE, corner()] {
            for slope in [0.02, 1e-3, 0.0] {
                let law = law_with(&near_edge(slope, 0.0), [REFERENCE; 2], corner);
                for a in [0.1e-3, 0.25e-3, 0.4e-3] {
                    let bend = a / RADIUS;
                    let (of_slope, of_curvature) =
                        (0.5 * (slope + 0.5 * bend) * a / C, 0.125 * a * bend / C);
                    let sum = C + corner.softness;
                    let log_end = C * (REFERENCE * 4.0).ln() + corner.softness * f64::ln(0.1e-3);
                    let log_end = match corner.softness > 0.0 {
                        true => log_end / sum,
                        false => (REFERENCE * 4.0).ln(),
                    };
                    let log = log_end - a.ln();
                    let x = sum * (of_slope * (log + 1.0) + of_curvature * (log - 0.5));
                    let found = law.line_load(x);
                    assert_relative_eq!(found.load, of_slope + of_curvature, max_relative = 2e-3);
                    assert_relative_eq!(found.slope, (sum * log).recip(), max_relative = 2e-2);
                }
            }
        }
    }

    #[test]
    fn inside_the_flanks_the_law_is_that_of_hertz() {
        let law = law_with(&far(), [1.2e-3, 2.0e-3], Corner::NONE);
        for w in [1e-3, 1.0, 1e3, 1e5, 5e5] {
            let b = (8.0 * w * RADIUS * STEEL / PI).sqrt();
            let each = [1.2e-3, 2.0e-3].map(|l: f64| 0.5 * C * w * ((2.0 * l / b).ln() + 0.5));
            let found = law.line_load(each[0] + each[1]).load;
            assert_relative_eq!(found, w, max_relative = 1e-13);
        }
        // p = sqrt(w E* / (pi R)), 1/E* = 2 (1 - nu^2) / E.
        let p = (1e5 / (2.0 * STEEL) / (PI * RADIUS)).sqrt();
        assert_relative_eq!(law.pressure(1e5).unwrap(), p, max_relative = 1e-13);
        assert!(!law.has_edge(0.0) && !law.has_relief(0.0));
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
    fn slope_and_energy_are_derivative_and_integral_of_the_load_without_jumps() {
        for profile in profiles() {
            let law = law_with(&profile, [0.3e-3, 0.4e-3], corner());
            for x in [1e-8, 1e-6, 5e-6, 2e-5, 1e-4, 1e-3] {
                let d = 1e-4 * x;
                let [below, here, above] = [x - d, x, x + d].map(|x| law.line_load(x));
                let by_energy = (above.energy - below.energy) / (2.0 * d);
                assert_relative_eq!(here.load, by_energy, max_relative = 1e-6);
                let by_load = (above.load - below.load) / (2.0 * d);
                assert_relative_eq!(here.slope, by_load, max_relative = 1e-5);
            }
            assert_eq!(law.line_load(-1e-6), LineLoad::default());
            for at in (0..=NODES)
                .map(|i| law.contact(i).penetration)
                .filter(|x| *x > 0.0)
            {
                let [below, above] = [1.0 - 1e-9, 1.0 + 1e-9].map(|near| law.line_load(near * at));
                assert_relative_eq!(below.load, above.load, max_relative = 1e-7);
                assert_relative_eq!(below.slope, above.slope, max_relative = 1e-7);
                assert_relative_eq!(below.energy, above.energy, max_relative = 1e-7);
            }
        }
    }

    #[test]
    fn between_its_contacts_the_law_is_that_of_the_width_in_between() {
        for profile in relieved() {
            let law = law(&profile);
            let (least, last) = (law.hertz_end.half_width, law.contact(NODES).at);
            let mut m = 0.0f64;
            for step in 1..200 {
                let a = least + (law.widest - least) * f64::from(step) / 200.0;
                m = profile.middle(a, m);
                let means = profile.means(m, a);
                let load = means.by_log_width / C;
                let found = law.line_load(means.gap + load * law.flat_punch(a));
                assert_abs_diff_eq!(found.load, load, epsilon = 1e-3 * last.load);
                let exact = law.flat_punch(a).recip();
                assert_abs_diff_eq!(found.slope, exact, epsilon = 2e-2 * last.slope);
            }
        }
    }

    #[test]
    fn an_edge_behind_the_start_of_a_relief_is_reached_later() {
        let mut profile = relieved()[0];
        let [far, near] = [-1.0, -0.12e-3].map(|edge| {
            profile.edges[0] = edge;
            law(&profile)
        });
        assert_eq!(far.load_at_edge(), f64::INFINITY);
        let w = near.load_at_edge();
        assert!(w > near.contact(0).at.load && w < near.contact(NODES).at.load);
        // Past it the one without an edge carries more at the same penetration.
        let mut contacts = (0..=NODES).map(|i| near.contact(i));
        let reached = contacts.find(|contact| contact.at.load > w).unwrap();
        let [without, with] = [&far, &near].map(|law| law.line_load(2.0 * reached.penetration));
        assert!(without.load > with.load);
    }

    #[test]
    fn the_pressure_is_that_of_a_kink_rounded_over_one_to_one_and_a_quarter_half_widths() {
        let relieved = |reliefs| GapProfile::relieved(0.0, RADIUS.recip(), reliefs);
        for (at, slope) in [(0.05e-3, 0.012), (0.02e-3, 0.003), (0.0, 0.006)] {
            let sharp = law(&relieved([(at, 1.0, slope, 0.0), NO_RELIEF]));
            let w = 400e3;
            let half_width = (2.0 * C * RADIUS * w).sqrt();
            // A parabola in place of the kink, over `share` of the half-width; its pressure under w.
            let rounded = |share: f64| {
                let length = share * half_width;
                let bend = slope / length;
                let [from, to] = [at - 0.5 * length, at + 0.5 * length];
                let profile = relieved([(from, 1.0, 0.0, bend), (to, 1.0, 0.0, -bend)]);
                let [load, _, pressure] = by_cells(&profile, 4e-6, [-0.35e-3, 0.35e-3], 350);
                pressure / sharp.pressure(load).unwrap()
            };
            let [narrow, wide] = [0.9, 1.3].map(rounded);
            assert!(narrow > 1.0 && wide < 1.0, "{at} {slope}: {narrow} {wide}");
        }
    }

    #[test]
    fn overload_is_judged_on_the_pressure_that_is_reported() {
        let most = 0.15 / (4.0 * STEEL);
        let steep = [(0.0, 1.0, 0.2, 0.0), NO_RELIEF];
        let steep = GapProfile::relieved(-0.1, RADIUS.recip(), steep);
        let laws = [far(), steep].map(|profile| law_with(&profile, [0.6e-3; 2], Corner::NONE));
        let mut judged = [0; 2];
        for step in 1..200 {
            let w = 40.0 * f64::from(step) / LENGTH;
            let pressures = laws.each_ref().map(|law| law.pressure(w).unwrap());
            for (law, pressure) in laws.iter().zip(pressures) {
                assert_eq!(law.overload(w), (pressure > most).then_some(pressure));
                judged[usize::from(pressure > most)] += 1;
            }
            // The parabola alone would carry it.
            assert!(pressures[1] > pressures[0]);
        }
        assert!(judged.into_iter().all(|count| count > 20), "{judged:?}");
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
        assert_eq!(corner().compliance(8e-5, 8e-5), 0.0);
        assert!(corner().compliance(1e-5, 1e-5) > 0.0);
        assert!(corner().compliance(0.0, 2e-4) < 0.0);
    }
}
