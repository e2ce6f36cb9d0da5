//! Contact that reaches the start of a relief: line load over penetration where the gap is no parabola.
//!
//! Two half-planes that touch from m - a to m + a, with G(m, a) the mean gap under the pressure of a flat punch of that
//! width, give way by
//!
//! h = G + c w ln(2 L / a), c w = a dG/da, dG/dm = 0,
//!
//! c = sum of 2 (1 - nu²) / (pi E): of all contacts the one that carries most at the penetration h (Barber, Int. J.
//! Solids Structures 10 (1974) 5-8). The parabola gives the law of Hertz. At a tip edge m - a stays there while a
//! grows, and pressure has no bound (Johnson, Contact Mechanics, 1985, sections 2.7 and 5.1). Whatever the gap,
//!
//! dh/dw = c ln(2 L / a),
//!
//! since m and a are stationary; at the corner of a tooth [`super::tip_edge::Corner`] adds to it. The law is followed through contacts of
//! given width, exact there, between them the cubic
//! through line loads and slopes; its energy is the integral of just that.

use std::sync::OnceLock;

use super::constants::{KNEE_NODES, WIDTH_OVER_REFERENCE};
use super::law::{Elastic, LineLoad};
use super::profile::GapProfile;

/// Line load over penetration from the width on at which contact reaches the start of a relief. Its nodes are found when
/// they are first asked for: few loads reach the wide ones.
#[derive(Debug, Clone, PartialEq)]
pub struct Knee {
    elastic: Elastic,
    profile: GapProfile,
    onset: Onset,
    /// Largest half-width, m.
    widest: f64,
    nodes: [OnceLock<Node>; KNEE_NODES + 1],
    at_edge: OnceLock<f64>,
}

/// Where contact reaches the start of a relief.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Onset {
    /// m.
    pub half_width: f64,
    /// N/m.
    pub load: f64,
    /// m.
    pub penetration: f64,
    /// Integral of the load over the penetration, J/m.
    pub energy: f64,
}

/// One width of contact.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Node {
    /// Half-width and middle of the contact, m.
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

impl Knee {
    /// Law of the gap `profile` from `onset` up to the half-width `widest` (m).
    pub fn new(elastic: Elastic, profile: &GapProfile, onset: Onset, widest: f64) -> Knee {
        let [low, high] = profile.edges;
        Knee {
            elastic,
            profile: *profile,
            onset,
            widest: widest.min(0.5 * (high - low)),
            nodes: Default::default(),
            at_edge: OnceLock::new(),
        }
    }

    /// From where on the law holds.
    pub fn onset(&self) -> Onset {
        self.onset
    }

    /// Whether contact reaches the relief before a tip edge.
    pub fn is_inside(&self) -> bool {
        self.onset.half_width <= self.profile.edge_distance()
    }

    fn node(&self, i: usize) -> &Node {
        self.nodes[i].get_or_init(|| self.found(i))
    }

    /// Node `i` from those before it.
    fn found(&self, i: usize) -> Node {
        let Onset {
            half_width: least,
            penetration: reached,
            energy,
            ..
        } = self.onset;
        let share = i as f64 / KNEE_NODES as f64;
        let a = least + (self.widest - least) * share * share.sqrt();
        let mut node = Node {
            half_width: a,
            at: LineLoad {
                energy,
                ..LineLoad::default()
            },
            ..Node::default()
        };
        if a == 0.0 {
            return node;
        }
        let [low, high] = self.profile.edges;
        let before = i.checked_sub(1).map(|before| self.node(before));
        // Up to the first width contact is that of a parabola, about the closest point or from the edge.
        node.middle = match before {
            None => 0.0f64.max(low + a).min(high - a),
            Some(before) => {
                let other = i.checked_sub(2).map(|other| self.node(other));
                let onwards = other.map_or(0.0, |other| {
                    (before.middle - other.middle) / (before.half_width - other.half_width)
                });
                let start = before.middle + onwards * (a - before.half_width);
                self.profile.middle(a, start)
            }
        };
        let means = self.profile.means(node.middle, a);
        let (c, corner) = (self.elastic.c, &self.elastic.corner);
        let load = means.by_log_width / c;
        let compliance = self.elastic.flat_punch(a);
        let flat = means.gap + load * compliance;
        // From where on an edge cuts contact off, its middle; before, that of the line, so that far edges play no part.
        let line = self.profile.edge_distance();
        // No softer than the tangent of the law of Hertz.
        let most = c * (2.0 / WIDTH_OVER_REFERENCE).ln() - compliance;
        let added = corner.compliance(line, a.max(line)).max(most.min(0.0));
        node.added = added;
        node.by_corner = match before {
            None => reached - flat,
            // From nothing on, at an edge w rises as a does.
            Some(before) if before.half_width == 0.0 && line == 0.0 => {
                (added + corner.softness) * load
            }
            Some(before) if before.half_width == 0.0 || before.added == added => {
                before.by_corner + added * (load - before.at.load)
            }
            // What is added changes with ln a, and between widths ln w does so, too.
            Some(before) => {
                let rise = load - before.at.load;
                let more = rise / (rise / before.at.load).ln_1p();
                before.by_corner + added * load
                    - before.added * before.at.load
                    - (added - before.added) * more
            }
        };
        node.penetration = flat + node.by_corner;
        node.at.load = load;
        node.at.slope = (compliance + added).recip();
        let [first, second] = means.coefficients.map(|g| g / (2.0 * c * load));
        node.spread = a * a * (0.5 - second - first * first) / load;
        if let Some(Node {
            penetration, at, ..
        }) = before
        {
            let step = node.penetration - penetration;
            let curved = step * (at.slope - node.at.slope) / 12.0;
            node.at.energy = at.energy + step * (0.5 * (at.load + load) + curved);
        }
        node
    }

    /// Line load from which on contact reaches a tip edge, N/m.
    pub fn load_at_edge(&self) -> f64 {
        *self.at_edge.get_or_init(|| {
            // Load and how far the contact is cut off by an edge, of the width before.
            let mut before: Option<(f64, f64)> = None;
            for i in 0..=KNEE_NODES {
                let (half_width, load) = (self.node(i).half_width, self.node(i).at.load);
                if half_width == 0.0 || self.profile.edge_distance() > 2.0 * half_width {
                    continue;
                }
                let cut = self.profile.cut(half_width);
                if cut > 0.0 {
                    let reaching = match before {
                        Some((other_load, other)) => {
                            other_load + (load - other_load) * other / (other - cut)
                        }
                        None => self.node(i.saturating_sub(1)).at.load,
                    };
                    return reaching.max(self.onset.load);
                }
                before = Some((load, cut));
            }
            f64::INFINITY
        })
    }

    /// The nodes about `value` of a node; `None` beyond the last one.
    fn around(&self, value: f64, of_node: impl Fn(&Node) -> f64) -> Option<[&Node; 2]> {
        let above = (1..=KNEE_NODES).find(|&i| value < of_node(self.node(i)))?;
        Some([self.node(above - 1), self.node(above)])
    }

    /// Line load at the penetration `x` (m), not below that of the onset.
    pub fn line_load(&self, x: f64) -> LineLoad {
        let Some([first, second]) = self.around(x, |node| node.penetration) else {
            let last = self.node(KNEE_NODES);
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

    /// Largest pressure under the line load `w` (N/m), Pa: that of the half-ellipse of the same load and the same mean square
    /// distance from its middle. At a sharp kink pressure has no bound; this is what it is at one that is rounded over one
    /// to one and a quarter half-widths of the contact.
    pub fn pressure(&self, w: f64) -> f64 {
        let spread = match self.around(w, |node| node.at.load) {
            None => self.node(KNEE_NODES).spread,
            Some([a, b]) => {
                let t = (w - a.at.load) / (b.at.load - a.at.load);
                a.spread + t * (b.spread - a.spread)
            }
        };
        std::f64::consts::FRAC_1_PI * (w / spread).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::super::profile::Break;
    use super::super::tip_edge::{Corner, TipEdge};
    use super::*;
    use approx::{assert_abs_diff_eq, assert_relative_eq};
    use std::f64::consts::PI;

    const C: f64 = 4.0 * (1.0 - 0.09) / (PI * 206e9);
    const RADIUS: f64 = 8e-3;
    const REFERENCE: f64 = 0.3e-3;
    const WIDEST: f64 = 1.5 * REFERENCE;

    /// The law from the width on at which contact leaves the parabola.
    fn law(profile: &GapProfile) -> Knee {
        let b = profile.room();
        let w = 0.5 * b * b * profile.curvature / C;
        let h = if b > 0.0 {
            C * w * ((2.0 * REFERENCE / b).ln() + 0.5)
        } else {
            0.0
        };
        let onset = Onset {
            half_width: b,
            load: w,
            penetration: h,
            energy: 0.5 * w * h - 0.125 * C * w * w,
        };
        Knee::new(elastic(Corner::NONE), profile, onset, WIDEST)
    }

    fn elastic(corner: Corner) -> Elastic {
        Elastic {
            c: C,
            log_reference: f64::ln(REFERENCE),
            corner,
        }
    }

    /// Kinks as those of short strong reliefs, parabolas as those of short ones.
    fn relieved() -> [GapProfile; 4] {
        let new = |slope: f64, reliefs| GapProfile::relieved(slope, RADIUS.recip(), reliefs);
        let none = (1.0, 1.0, 0.0, 0.0);
        [
            new(0.0, [(0.05e-3, 1.0, 0.012, 0.0), none]),
            new(-0.006, [(0.0, 1.0, 0.012, 0.0), none]),
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

    /// Line load, root mean square spread and largest value of the pressure at the penetration `x` (m), by pressures that are constant on
    /// `n` cells within `range` and fulfil the conditions of contact in their middles.
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
                    let of = |(p, &i): (&f64, &usize)| p * h * (at(i) - from).powi(power);
                    pressure.iter().zip(&on).map(of).sum::<f64>() / load
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
        for profile in relieved() {
            let law = law(&profile);
            for x in [2e-6, 4e-6] {
                let [low, high]: [f64; 2] = [-0.3e-3, 0.3e-3];
                let range = [low.max(profile.edges[0]), high];
                let [load, spread, _] = by_cells(&profile, x, range, 300);
                let found = law.line_load(x).load;
                assert_relative_eq!(found, load, max_relative = 3e-3);
                let half_width = 2.0 / PI * found / law.pressure(found);
                assert_relative_eq!(half_width, 2.0 * spread, max_relative = 1e-2);
            }
        }
    }

    #[test]
    fn the_pressure_is_that_of_a_kink_rounded_over_one_to_one_and_a_quarter_half_widths() {
        for (at, slope) in [(0.05e-3, 0.012), (0.02e-3, 0.003), (0.0, 0.006)] {
            let none = (1.0, 1.0, 0.0, 0.0);
            let relieved = |reliefs| GapProfile::relieved(0.0, RADIUS.recip(), reliefs);
            let sharp = law(&relieved([(at, 1.0, slope, 0.0), none]));
            let w = 400e3;
            let half_width = (2.0 * C * RADIUS * w).sqrt();
            // A parabola in place of the kink, over `share` of the half-width; its pressure under w.
            let rounded = |share: f64| {
                let length = share * half_width;
                let bend = slope / length;
                let [from, to] = [at - 0.5 * length, at + 0.5 * length];
                let profile = relieved([(from, 1.0, 0.0, bend), (to, 1.0, 0.0, -bend)]);
                let [load, _, pressure] = by_cells(&profile, 4e-6, [-0.35e-3, 0.35e-3], 350);
                pressure / sharp.pressure(load)
            };
            let [narrow, wide] = [0.9, 1.3].map(rounded);
            assert!(narrow > 1.0 && wide < 1.0, "{at} {slope}: {narrow} {wide}");
        }
    }

    #[test]
    fn between_its_nodes_the_law_is_that_of_the_width_in_between() {
        for profile in relieved() {
            let law = law(&profile);
            let mut m = 0.0f64;
            for step in 1..200 {
                let a = profile.room() + (WIDEST - profile.room()) * f64::from(step) / 200.0;
                m = profile.middle(a, m);
                let means = profile.means(m, a);
                let load = means.by_log_width / C;
                let x = means.gap + C * load * (2.0 * REFERENCE / a).ln();
                let LineLoad {
                    load: found, slope, ..
                } = law.line_load(x);
                let last = law.node(KNEE_NODES).at;
                assert_abs_diff_eq!(found, load, epsilon = 1e-3 * last.load);
                let exact = (C * (2.0 * REFERENCE / a).ln()).recip();
                assert_abs_diff_eq!(slope, exact, epsilon = 2e-2 * last.slope);
            }
        }
    }

    #[test]
    fn a_kink_that_is_none_leaves_a_contact_at_an_edge_as_it_is() {
        let corner = Corner::new(2.1, 0.25 * PI * C, 0.05e-3);
        for (slope, corner) in [
            (0.02, Corner::NONE),
            (0.0, Corner::NONE),
            (0.02, corner),
            (0.0, corner),
        ] {
            let mut profile = GapProfile::parabola(slope, RADIUS.recip(), [0.0, 1.0]);
            let kink = Break {
                at: 0.3e-3,
                side: 1.0,
                slope: 1e-12,
                curvature: 0.0,
            };
            profile.add(0, kink);
            let edge = TipEdge::new(elastic(corner), &profile).unwrap();
            let least = profile.room();
            let state = edge.state(2.0 * least);
            let onset = Onset {
                half_width: least,
                load: state.at.load,
                penetration: state.penetration,
                energy: edge.line_load(state.penetration).energy,
            };
            let widest = WIDEST.min(0.5 * edge.widest());
            let knee = Knee::new(elastic(corner), &profile, onset, widest);
            assert_relative_eq!(knee.node(0).at.load, state.at.load, max_relative = 1e-9);
            for x in [1.0, 1.3, 2.0, 5.0].map(|times| times * state.penetration) {
                let (found, known) = (knee.line_load(x), edge.line_load(x));
                assert_relative_eq!(found.load, known.load, max_relative = 2e-3);
                assert_relative_eq!(found.energy, known.energy, max_relative = 2e-3);
            }
        }
    }

    #[test]
    fn an_edge_behind_a_kink_is_reached_later() {
        let mut profile = relieved()[0];
        let [far, near] = [-1.0, -0.12e-3].map(|edge| {
            profile.edges[0] = edge;
            law(&profile)
        });
        assert_eq!(far.load_at_edge(), f64::INFINITY);
        let w = near.load_at_edge();
        // Little short of it both agree; the one without an edge goes on to carry more at the same penetration.
        let reached = (0..=KNEE_NODES)
            .map(|i| near.node(i))
            .find(|node| node.at.load > w)
            .unwrap();
        assert!(w > near.node(0).at.load && w < near.node(KNEE_NODES).at.load);
        let [without, with] = [&far, &near].map(|law| law.line_load(2.0 * reached.penetration));
        assert!(without.load > with.load);
    }
}
