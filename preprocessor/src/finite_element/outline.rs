//! Half a tooth in the transverse section as a curve by arc length: what the mesh needs of a gear.

use gearmesh::gear::{GearKind, ToothProfile};

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
        outline.tip_arc = outline.arc_at_roll(gear.roll_length(gear.tip_radius));
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

    /// Arc length at the length of roll `roll`, m; it also places a contact just below the form point.
    pub fn arc_at_roll(&self, roll: f64) -> f64 {
        self.kappa * (roll * roll - self.form_roll * self.form_roll) / (2.0 * self.base_radius)
    }

    pub fn space_arc(&self) -> f64 {
        self.below[self.below.len() - 1].0
    }

    fn involute(&self, arc: f64) -> Polar {
        let roll_squared =
            self.form_roll * self.form_roll + self.kappa * 2.0 * self.base_radius * arc;
        let roll = roll_squared.max(0.0).sqrt();
        let tangent = roll / self.base_radius;
        [
            roll.hypot(self.base_radius),
            self.base_half_angle - self.kappa * (tangent - tangent.atan()),
        ]
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
            let roll = ((radius - self.base_radius) * (radius + self.base_radius))
                .max(0.0)
                .sqrt();
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
        self.below
            .windows(2)
            .find(|w| {
                let (p, q) = (w[0].1, w[1].1);
                (q[0] - p[0]).abs() < half * distance(p, q)
            })
            .map_or(0.5 * self.space_arc(), |w| w[0].0)
    }
}

fn distance(p: Polar, q: Polar) -> f64 {
    (q[0] - p[0]).hypot(0.5 * (p[0] + q[0]) * (q[1] - p[1]))
}
