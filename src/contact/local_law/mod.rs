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
//! the integral of just that. Where dh/dw has fallen to that of Hertz at b = `wider::WIDTH_OVER_REFERENCE` L the
//! law goes on along its tangent.

mod corner;
mod wider;

use std::f64::consts::{FRAC_1_PI, FRAC_1_SQRT_2, FRAC_PI_2, LN_2, PI};
use std::sync::OnceLock;

use super::gap::GapProfile;
use crate::gear::Gear;
pub use corner::Corner;

/// Points of a segment, middles of equal parts, at which local contact is evaluated: its edge crosses a segment in small steps.
pub const POINTS: usize = 4;

/// Half-width over the relative radius of curvature beyond which a load is refused: 8.5 GPa between steel flanks, twice what rolling
/// bearings are allowed before a dent remains (ISO 76: 4 to 4.6 GPa).
const LARGEST_HALF_WIDTH_OVER_RADIUS: f64 = 0.15;

/// Contacts solved between the end of the law of Hertz and the tangent. Measured: line loads within 1e-3, at a relief within 5e-3.
const NODES: usize = 12;

/// How one gear deflects close to the contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LocalBody {
    /// (1 - nu²) / E, 1/Pa.
    pub plane_compliance: f64,
    /// How much more the tooth deflects at its tip edge than a half-plane.
    pub corner: Corner,
}

impl LocalBody {
    /// `gear`, whose elastic model resolves the tip corner down to the distance `resolution` (m) from the edge; zero: not at all.
    pub fn new(gear: &Gear, resolution: f64) -> LocalBody {
        let plane_compliance = gear.plane_compliance();
        let angle = FRAC_PI_2 + (gear.tip_form_roll() / gear.base_radius()).atan();
        LocalBody {
            plane_compliance,
            corner: Corner::new(angle, plane_compliance, resolution),
        }
    }
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

    /// Line load at the penetration `x` (m); none for x <= 0.
    pub fn line_load(&self, x: f64) -> LineLoad {
        if x <= 0.0 {
            return LineLoad::default();
        }
        if x < self.hertz_end.penetration {
            return self.hertz([x])[0];
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

    /// The law of Hertz at the penetrations `x` (m). Integral of h dw = w h / 2 + c w² / 8.
    #[inline]
    fn hertz<const N: usize>(&self, x: [f64; N]) -> [LineLoad; N] {
        let c = self.c;
        let v = inverse(x.map(|x| -(x.ln() + self.log_scale)));
        std::array::from_fn(|i| {
            let load = 2.0 * x[i] / (c * v[i]);
            LineLoad {
                load,
                slope: 2.0 / (c * (v[i] - 1.0)),
                energy: 0.5 * x[i] * load - 0.125 * c * load * load,
            }
        })
    }

    /// Local contact at the penetrations `x` (m) of the points.
    pub fn loads(&self, x: [f64; POINTS]) -> PointLoads {
        if x.iter().all(|&x| x <= 0.0) {
            return PointLoads::default();
        }
        // Mostly all points are alike, and laws of all of them at once take half as long as one by one.
        let is_hertz = |x: &f64| *x > 0.0 && *x < self.hertz_end.penetration;
        let each = match x.iter().all(is_hertz) {
            true => self.hertz(x),
            false => x.map(|x| self.line_load(x)),
        };
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
#[inline]
fn inverse<const N: usize>(t: [f64; N]) -> [f64; N] {
    let sigma = t.map(|t| t - 1.0);
    let root = sigma.map(f64::sqrt);
    let falling = root.map(|root| (-0.0201 * root).exp());
    let first: [f64; N] = std::array::from_fn(|i| {
        let falling = 1.0 - 0.0042 * sigma[i] * falling[i];
        let inner = 1.0 + 0.3361 * FRAC_1_SQRT_2 * root[i] / falling;
        1.0 + sigma[i] + 2.0 / 0.3361 * (1.0 - inner.recip())
    });
    let log = first.map(f64::ln);
    std::array::from_fn(|i| {
        let v = first[i];
        let z = v - log[i] - t[i];
        let q = 2.0 * (1.0 - v) * (1.0 - v + 2.0 / 3.0 * z);
        v * (1.0 + z / (1.0 - v) * (q - z) / (q - 2.0 * z))
    })
}

#[cfg(test)]
mod tests;
