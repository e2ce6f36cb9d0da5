//! The outline of the loaded half of a tooth by its arc length.

use crate::gear::ToothProfile;
use gearmesh::gear::GearKind;

/// A point of the outline in polar coordinates about the tooth's centre line: radius m, angle rad.
pub(super) type Polar = [f64; 2];

/// Chords that stand for the fillet and for the root circle beside it; 400 leave 1e-6 of its radius.
const FILLET_STEPS: u32 = 400;
const ROOT_STEPS: u32 = 20;

/// The loaded half of a tooth: involute from the form point to the tip, fillet from the form point
/// to the root circle, root circle to the middle of the space.
///
/// The arc length s is zero at the form point, positive on the involute, negative below. On the
/// involute s = (roll² - roll_form²) / (2 rb).
#[derive(Debug, Clone)]
pub(super) struct Outline {
    /// +1 external teeth, -1 ring.
    pub kappa: f64,
    pub base_radius: f64,
    pub form_roll: f64,
    pub tip_arc: f64,
    base_half_angle: f64,
    /// From the form point to the middle of the space, with the arc length (<= 0) of each point.
    below: Vec<(f64, Polar)>,
}

impl Outline {
    pub fn new(profile: &ToothProfile) -> Outline {
        let gear = profile.gear();
        let half_pitch = profile.half_pitch();
        let base_half_angle = match gear.kind {
            GearKind::External => gear.half_base_angle(),
            GearKind::Ring => half_pitch - gear.half_base_angle(),
        };
        let mut outline = Outline {
            kappa: gear.kappa(),
            base_radius: gear.base_radius(),
            form_roll: profile.form_roll(),
            tip_arc: 0.0,
            base_half_angle,
            below: Vec::new(),
        };
        let (tip, form) = (gear.roll_length(gear.tip_radius), outline.form_roll);
        outline.tip_arc = outline.kappa * (tip * tip - form * form) / (2.0 * outline.base_radius);
        let fillet = (0..FILLET_STEPS).rev().map(|i| {
            let point = profile.fillet(f64::from(i) / f64::from(FILLET_STEPS));
            [point.radius(), point.angle()]
        });
        let (from, land) = (profile.root_angle(), half_pitch - profile.root_angle());
        let root_land = (1..=ROOT_STEPS).map(|i| {
            let share = f64::from(i) / f64::from(ROOT_STEPS);
            [gear.root_radius(), from + land * share]
        });
        let mut arc = 0.0;
        let mut last = outline.involute(0.0);
        outline.below.push((0.0, last));
        for point in fillet.chain(root_land) {
            let step = distance(last, point);
            if step > 1e-9 * gear.normal_module {
                arc -= step;
                last = point;
                outline.below.push((arc, point));
            }
        }
        // The boundary of the sector must lie exactly in the middle of the space.
        if let Some(end) = outline.below.last_mut() {
            end.1[1] = half_pitch;
        }
        outline
    }

    pub fn space_arc(&self) -> f64 {
        self.below[self.below.len() - 1].0
    }

    /// Least radius of curvature of the fillet, m: of the circles through points some degrees apart.
    pub fn sharpest(&self) -> f64 {
        let points = self.below.iter().step_by(FILLET_STEPS as usize / 50);
        let points: Vec<Polar> = points.map(|(_, point)| *point).collect();
        let radii = points.windows(3).map(|p| {
            let [a, b, c] = [[0, 1], [1, 2], [2, 0]].map(|[i, j]| distance(p[i], p[j]));
            let [x, y] = [1, 2].map(|i| {
                let turn = p[i][1] - p[0][1];
                [p[i][0] * turn.cos() - p[0][0], p[i][0] * turn.sin()]
            });
            a * b * c / (2.0 * (x[0] * y[1] - x[1] * y[0]).abs())
        });
        radii.fold(f64::INFINITY, f64::min)
    }

    fn involute(&self, arc: f64) -> Polar {
        let (rb, form) = (self.base_radius, self.form_roll);
        let roll = (form * form + self.kappa * 2.0 * rb * arc).max(0.0).sqrt();
        let tangent = roll / rb;
        let angle = self.base_half_angle - self.kappa * (tangent - tangent.atan());
        [roll.hypot(rb), angle]
    }

    /// Point at the arc length `arc`, m, between the middle of the space and the tip.
    pub fn point(&self, arc: f64) -> Polar {
        if arc >= 0.0 {
            return self.involute(arc);
        }
        let after = self.below.partition_point(|(s, _)| *s > arc);
        let after = after.clamp(1, self.below.len() - 1);
        let ((s0, p0), (s1, p1)) = (self.below[after - 1], self.below[after]);
        let t = (arc - s0) / (s1 - s0);
        [p0[0] + t * (p1[0] - p0[0]), p0[1] + t * (p1[1] - p0[1])]
    }

    /// Outward unit normal in the transverse section, (radial, circumferential), at `arc`.
    pub fn normal(&self, arc: f64) -> [f64; 2] {
        if arc >= 0.0 {
            let [radius, _] = self.involute(arc);
            let squared = (radius - self.base_radius) * (radius + self.base_radius);
            let roll = squared.max(0.0).sqrt();
            return [self.kappa * roll / radius, self.base_radius / radius];
        }
        let step = (1e-3 * self.tip_arc).min(-arc);
        let (low, high) = (self.point(arc - step), self.point(arc + step));
        let mid = 0.5 * (low[0] + high[0]);
        let (dr, dt) = (high[0] - low[0], mid * (high[1] - low[1]));
        let length = dr.hypot(dt);
        // Turned from the tangent towards the outside: +theta where the tangent runs to the tip.
        [-self.kappa * dt / length, self.kappa * dr / length]
    }

    /// Arc length (negative) of the point of the fillet where its tangent has turned halfway from the
    /// radial to the circumferential direction.
    pub fn fillet_middle(&self) -> f64 {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let turned = self.below.windows(2).find(|w| {
            let (p, q) = (w[0].1, w[1].1);
            (q[0] - p[0]).abs() < half * distance(p, q)
        });
        turned.map_or(0.5 * self.space_arc(), |w| w[0].0)
    }
}

fn distance(p: Polar, q: Polar) -> f64 {
    (q[0] - p[0]).hypot(0.5 * (p[0] + q[0]) * (q[1] - p[1]))
}
