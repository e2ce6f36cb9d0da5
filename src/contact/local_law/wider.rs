//! Contacts wider than Hertz's law holds for: of given half-widths up to that from which on the law goes on along its tangent.

use std::f64::consts::LN_2;

use super::{Contact, Corner, LineLoad, LocalContact, NODES};

/// Half-width over the reference length from which the law goes on along its tangent: dh/dw vanishes at b = 2 L. The tangent keeps
/// the problem convex; at b = 2 L it is softer by 0.07 c w, a hundredth of the deflection of a tooth pair.
const WIDTH_OVER_REFERENCE: f64 = 1.5;

impl LocalContact {
    fn tangent_compliance(&self) -> f64 {
        self.c * (2.0 / WIDTH_OVER_REFERENCE).ln()
    }

    /// Half-width at which dh/dw has fallen to that of the tangent, m; see [`Corner::compliance`] for `line` and `added`.
    pub(super) fn tangent_half_width(&self, line: f64, added: f64) -> f64 {
        let widest = WIDTH_OVER_REFERENCE * (self.log_reference + added / self.c).exp();
        if widest <= line || self.corner.softness == 0.0 {
            return widest;
        }
        let Corner { softness, resolved } = self.corner;
        let sum = self.c * (self.log_reference + LN_2) + softness * line.max(resolved).ln()
            - self.tangent_compliance();
        (sum / (self.c + softness)).exp()
    }

    pub(super) fn contact(&self, i: usize) -> &Contact {
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
    pub(super) fn around(
        &self,
        value: f64,
        of_contact: impl Fn(&Contact) -> f64,
    ) -> Option<[&Contact; 2]> {
        let last = if self.wider.is_some() { NODES } else { 0 };
        let above = (1..=last).find(|&i| value < of_contact(self.contact(i)))?;
        Some([self.contact(above - 1), self.contact(above)])
    }

    pub(super) fn find_load_at_edge(&self) -> f64 {
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
}
