//! Local contact of one strip: force over penetration in closed form.

use std::sync::OnceLock;

use super::constants::{LARGEST_HALF_WIDTH_OVER_RADIUS, WIDTH_OVER_REFERENCE};
use super::corner::Corner;
use super::knee::Knee;
use super::lambert;
use super::profile::GapProfile;
use super::tip_edge::TipEdge;
use crate::f64x4::F64x4;
/// Force of one strip over the approach of its two flanks that the local contact takes up.
///
/// The penetration under the force per length w is, summed over both gears (see
/// [`crate::compliance::ToothCompliance`]),
/// h(w) = sum_g c_g w (ln(2 L_g / b) + 1/2), c_g = 2 (1 - nu_g^2) / (pi E_g), b = sqrt(kappa w),
/// kappa = 4 rho (1/E'_1 + 1/E'_2) / pi (Hertz). h rises from zero with an infinite slope, so that its
/// inverse starts with slope zero: contact begins smoothly. With u = ln w - 2 B / c the inverse is the
/// lower branch of Lambert's W, -u e^u = y.
#[derive(Debug, Clone, PartialEq)]
pub struct LocalContact {
    /// Length of the strip along the contact line, m.
    length: f64,
    /// c_1 + c_2, 1/Pa.
    c: f64,
    /// ln(2 exp(-2 B / c) / c): turns a penetration into ln y.
    log_scale: f64,
    /// kappa, m^2 per N/m.
    kappa: f64,
    /// Relative radius of curvature where the flanks come closest, m.
    radius: f64,
    /// Penetration from which on the law goes on along its tangent, m.
    wide: f64,
    /// L (m), the logarithmic mean of both gears weighted with c_g, and its logarithm.
    reference: f64,
    log_reference: f64,
    /// Corner of the nearest tip edge.
    corner: Corner,
    /// What it adds to dh/dw inside the flank, 1/Pa.
    by_corner: f64,
    /// Takes over from the width of contact at which one side of it ends at a tip edge.
    edge: Option<TipEdge>,
    /// Takes over from both at the width of contact at which it reaches the start of a relief.
    relief: Option<Box<Relief>>,
}

/// The law where contact reaches the start of a relief, made when it is first asked for.
#[derive(Debug, Clone, PartialEq)]
struct Relief {
    profile: GapProfile,
    /// Half-width (m), line load (N/m) and penetration (m) from which on it holds.
    least: [f64; 3],
    law: OnceLock<Box<Knee>>,
}

/// Local contact at the four points of a strip.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PointLoads {
    /// Forces, N.
    pub forces: [f64; 4],
    /// Their derivatives by the penetrations, N/m.
    pub slopes: [f64; 4],
    /// Whether all of it is inside the flanks, in the range of the law of Hertz, and away from tip corners.
    pub inside: bool,
}

impl PointLoads {
    /// Force of the strip, N, and its derivative by the penetration of all points, N/m.
    #[inline(always)]
    pub fn sum(&self) -> (f64, f64) {
        let add = |p: [f64; 4]| (p[0] + p[1]) + (p[2] + p[3]);
        (add(self.forces), add(self.slopes))
    }
}

/// Local contact of the four points of a strip inside its flanks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeldContact {
    /// Sum of the energies, J.
    pub energy: f64,
    /// Its slope by the logarithm of the relative radius of curvature, the penetrations held, J.
    pub by_log_radius: f64,
    /// Its slopes by the logarithms of the reference lengths of both gears, J.
    pub by_log_length: [f64; 2],
}

/// Elastic constants and reference length of one gear at a strip.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LocalBody {
    /// (1 - nu^2) / E, 1/Pa.
    pub plane_compliance: f64,
    /// Reference length L of the local contact, m.
    pub reference_length: f64,
    /// Its tip corner.
    pub corner: Corner,
}

impl LocalContact {
    /// Law of a strip of `length` (m, along the contact line) between two bodies whose gap is `profile` in the normal
    /// section.
    pub fn new(bodies: [LocalBody; 2], profile: &GapProfile, length: f64) -> LocalContact {
        let radius = profile.curvature.recip();
        let scale = 2.0 / std::f64::consts::PI;
        let kappa =
            2.0 * scale * radius * (bodies[0].plane_compliance + bodies[1].plane_compliance);
        let c: f64 = bodies.iter().map(|g| scale * g.plane_compliance).sum();
        let weighted = bodies.map(|g| scale * g.plane_compliance * g.reference_length.ln());
        let log_reference = (weighted[0] + weighted[1]) / c;
        let reference = log_reference.exp();
        let [of_second, of_first] = profile.edges;
        let corner = bodies[usize::from(-of_second < of_first)].corner;
        let line = profile.edge_distance();
        // At the edge itself contact is never inside the flank.
        let by_corner = match line > 0.0 {
            true => corner.compliance(line, line),
            false => 0.0,
        };
        let squeezed = 2.0 * by_corner / c;
        // 2 B / c without the corner is ln(4 L² e / kappa).
        let log_scale = (2.0 * kappa / c).ln()
            - 2.0 * (log_reference + std::f64::consts::LN_2)
            - 1.0
            - squeezed;
        let widest = WIDTH_OVER_REFERENCE * reference;
        let mut wide = -u_wide() * 0.5 * c * widest * widest / kappa;
        if squeezed != 0.0 {
            wide *= squeezed.exp();
        }
        let mut law = LocalContact {
            length,
            c,
            log_scale,
            wide,
            kappa,
            radius,
            reference,
            log_reference,
            corner,
            by_corner,
            edge: TipEdge::new([c, radius, reference, profile.edge_slope()], corner, line),
            relief: None,
        };
        law.relief = law.least_at_relief(profile).map(|least| {
            Box::new(Relief {
                profile: *profile,
                least,
                law: OnceLock::new(),
            })
        });
        law
    }

    /// Half-width, line load and penetration at which contact reaches the start of a relief, if it does before it becomes too
    /// wide.
    fn least_at_relief(&self, profile: &GapProfile) -> Option<[f64; 3]> {
        let half_width = profile.room();
        if half_width >= WIDTH_OVER_REFERENCE * self.reference {
            return None;
        }
        let [load, penetration] = match &self.edge {
            Some(edge) if half_width > profile.edge_distance() => {
                // On its tangent the law of the edge knows no width.
                if 2.0 * half_width >= edge.widest() {
                    return None;
                }
                edge.at_width(2.0 * half_width)
            }
            _ if half_width == 0.0 => [0.0; 2],
            _ => {
                let load = half_width * half_width / (2.0 * self.radius * self.c);
                let log = self.log_reference + std::f64::consts::LN_2 - half_width.ln();
                [load, load * (self.c * (log + 0.5) + self.by_corner)]
            }
        };
        Some([half_width, load, penetration])
    }

    /// The law where contact reaches the start of a relief.
    fn knee<'a>(&self, relief: &'a Relief) -> &'a Knee {
        relief.law.get_or_init(|| {
            let [half_width, _, penetration] = relief.least;
            let widest = WIDTH_OVER_REFERENCE * self.reference;
            let at_edge = self.edge.map_or(widest, |edge| 0.5 * edge.widest());
            Box::new(Knee::new(
                &relief.profile,
                (self.c, self.log_reference, self.corner),
                [
                    half_width,
                    penetration,
                    self.energy_before_relief(penetration) / self.length,
                ],
                widest.min(at_edge.max(half_width)),
            ))
        })
    }

    /// The law where contact reaches the start of a relief, if it does at the penetration `x`, m.
    fn knee_at(&self, x: f64) -> Option<&Knee> {
        let relief = self.relief.as_deref()?;
        (x > relief.least[2]).then(|| self.knee(relief))
    }

    /// Penetration from which on contact is not that of a parabola, m.
    fn least_beyond(&self) -> f64 {
        let edge = self.edge.as_ref().map(TipEdge::least_penetration);
        let relief = self.relief.as_deref().map(|relief| relief.least[2]);
        let of = |least: Option<f64>| least.unwrap_or(f64::INFINITY);
        of(edge).min(of(relief))
    }

    /// Force (N) and its derivative (N/m) at the penetration `x` (m); zero for x <= 0.
    pub fn force(&self, x: f64) -> (f64, f64) {
        if x <= 0.0 {
            return (0.0, 0.0);
        }
        if let Some(law) = self.knee_at(x) {
            let [w, slope, _] = law.at(x);
            return (self.length * w, self.length * slope);
        }
        if let Some(edge) = &self.edge
            && x > edge.least_penetration()
        {
            let (w, slope) = edge.line_load(x);
            return (self.length * w, self.length * slope);
        }
        if x >= self.wide {
            let slope = self.length / self.slope_at(u_wide());
            let f_wide = self.length * 2.0 * self.wide / (self.c * -u_wide());
            return (f_wide + slope * (x - self.wide), slope);
        }
        let v = lambert::root_at(-(x.ln() + self.log_scale));
        (
            self.length * 2.0 * x / (self.c * v),
            self.length / self.slope_at(-v),
        )
    }

    /// As [`LocalContact::force`] at four points at once.
    #[inline(always)]
    pub fn loads(&self, x: [f64; 4]) -> PointLoads {
        if x.iter().all(|x| *x <= 0.0) {
            return PointLoads {
                inside: true,
                ..PointLoads::default()
            };
        }
        if let Some((force, v)) = self.within_flank(x) {
            let scale = F64x4::splat(2.0 * self.length / self.c);
            let touches = force.is(|force| force != 0.0);
            return PointLoads {
                forces: force.0,
                slopes: touches.select(scale / (v - 1.0), F64x4::ZERO).0,
                inside: self.by_corner == 0.0,
            };
        }
        let each = x.map(|x| self.force(x));
        PointLoads {
            forces: each.map(|e| e.0),
            slopes: each.map(|e| e.1),
            inside: false,
        }
    }

    /// Forces at four points (N) and -u there, of any size where there is no force; `None` where contact at one of them
    /// reaches a tip edge, is too wide, or so slight that the tabulated root ends.
    #[inline(always)]
    fn within_flank(&self, x: [f64; 4]) -> Option<(F64x4, F64x4)> {
        let limit = self.least_beyond().min(self.wide);
        if !x.iter().all(|x| *x < limit) {
            return None;
        }
        let x = F64x4(x);
        let touches = x.is(|x| x > 0.0);
        // Points that are open take any argument of the logarithm.
        let t = -(touches.select(x, F64x4::splat(0.5 * self.wide)).ln() + self.log_scale);
        if !lambert::is_held(t) {
            return None;
        }
        let v = lambert::roots_at(t);
        let scale = 2.0 * self.length / self.c;
        Some((touches.select(x / v, F64x4::ZERO) * scale, v))
    }

    /// What the forces of `loads`, at the penetrations `x`, do while the law changes and they are held; `None` unless all
    /// is inside the flanks. `plane` are the plane compliances of both gears.
    ///
    /// The slopes of the energy by a parameter at the penetration held are minus those of the complementary energy, the
    /// integral of h dw, at the force held.
    pub fn held(&self, loads: &PointLoads, x: [f64; 4], plane: [f64; 2]) -> Option<HeldContact> {
        if !loads.inside {
            return None;
        }
        let forces = loads.forces;
        let square = forces.iter().map(|f| f * f).sum::<f64>() / self.length;
        let work: f64 = forces.iter().zip(x).map(|(f, x)| f * x).sum();
        Some(HeldContact {
            energy: 0.5 * work - 0.125 * self.c * square,
            by_log_radius: 0.25 * self.c * square,
            by_log_length: plane.map(|p| -square * p / std::f64::consts::PI),
        })
    }

    /// Energy of the local contact at the penetration `x` (m), J: the integral of the force, zero for x <= 0.
    ///
    /// Within Hertz, with the line load w: integral of h dw = w h / 2 + c w² / 8.
    pub fn energy(&self, x: f64) -> f64 {
        if let Some(law) = self.knee_at(x) {
            return self.length * law.at(x)[2];
        }
        self.energy_before_relief(x)
    }

    /// As [`LocalContact::energy`] up to where contact reaches the start of a relief.
    fn energy_before_relief(&self, x: f64) -> f64 {
        if x <= 0.0 {
            return 0.0;
        }
        let hertz =
            |x: f64, force: f64| 0.5 * x * force - self.c * force * force / (8.0 * self.length);
        if let Some(edge) = &self.edge
            && x > edge.least_penetration()
        {
            let reached = edge.least_penetration();
            let force = self.length * edge.least_line_load();
            return hertz(reached, force) + self.length * edge.energy(x);
        }
        if x <= self.wide {
            return hertz(x, self.force(x).0);
        }
        let (f_wide, slope) = self.force(self.wide);
        let beyond = x - self.wide;
        hertz(self.wide, f_wide) + beyond * (f_wide + 0.5 * slope * beyond)
    }

    /// dh/dw at u.
    fn slope_at(&self, u: f64) -> f64 {
        -0.5 * self.c * (u + 1.0)
    }

    /// Pressure, Pa, of the force `f`, N, where that is more than any flank carries
    /// ([`LARGEST_HALF_WIDTH_OVER_RADIUS`]): [`LocalContact::pressure`], and where contact reaches a tip edge that of Hertz.
    pub fn overload(&self, f: f64) -> Option<f64> {
        // b / R = pi c p, with b² = kappa w and kappa = 2 c R.
        let most = LARGEST_HALF_WIDTH_OVER_RADIUS / (std::f64::consts::PI * self.c);
        let hertz = self.hertz_pressure(f);
        let w = f.max(0.0) / self.length;
        let at_relief = self.knee_under(w).map(|knee| knee.pressure(w));
        // Whether contact reaches an edge takes longer to find than all else.
        if hertz.max(at_relief.unwrap_or(0.0)) <= most {
            return None;
        }
        let pressure = self.pressure(f).unwrap_or(hertz);
        (pressure > most).then_some(pressure)
    }

    /// Law of the start of a relief that the line load `w` (N/m) reaches.
    fn knee_under(&self, w: f64) -> Option<&Knee> {
        let relief = self.relief.as_deref()?;
        (w > relief.least[1]).then(|| self.knee(relief))
    }

    /// Whether contact reaches a tip edge under the force `f`, N.
    pub fn reaches_edge(&self, f: f64) -> bool {
        let w = f / self.length;
        match self.relief.as_deref() {
            // Past the start of the relief flanks close more slowly.
            Some(relief) if relief.least[0] <= relief.profile.edge_distance() => self
                .knee_under(w)
                .is_some_and(|knee| w > knee.load_at_edge()),
            _ => self.edge.is_some_and(|edge| w > edge.least_line_load()),
        }
    }

    /// Line load above which contact reaches a tip edge, N/m; infinite where it becomes too wide for the law before.
    pub fn load_at_edge(&self) -> f64 {
        match self.relief.as_deref() {
            Some(relief) if relief.least[0] <= relief.profile.edge_distance() => {
                relief.least[1].max(self.knee(relief).load_at_edge())
            }
            _ => (self.edge).map_or(f64::INFINITY, |edge| edge.least_line_load()),
        }
    }

    /// What this law takes up under the line load `w` (N/m) more than `other` does since the displacement of the bodies is
    /// divided otherwise between it and the elastic model, m.
    pub fn takes_up_more_than(&self, other: &LocalContact, w: f64) -> f64 {
        self.c * w * (self.log_reference - other.log_reference)
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
        let bounded = !self.reaches_edge(w * self.length);
        bounded.then(|| knee.pressure(w))
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
        2.0 / std::f64::consts::PI * (f.max(0.0) / self.length / self.kappa).sqrt()
    }

    /// Length of the strip along the contact line, m.
    pub fn length(&self) -> f64 {
        self.length
    }
}

/// u at the width at which the law goes over into its tangent, for the weighted mean of the reference lengths:
/// -1 - 2 ln(2 L / b).
fn u_wide() -> f64 {
    -1.0 - 2.0 * (2.0 / WIDTH_OVER_REFERENCE).ln()
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
            assert_relative_eq!(law.force(h).0, w * 0.6e-3, max_relative = 1e-13);
        }
    }

    #[test]
    fn four_points_at_once_are_four_points() {
        let bodies = [1.2e-3, 2.0e-3].map(|reference_length| LocalBody {
            plane_compliance: STEEL,
            reference_length,
            corner: Corner::new(2.1, STEEL, 0.05e-3),
        });
        for profile in profiles() {
            let law = LocalContact::new(bodies, &profile, 0.6e-3);
            for x in [1e-22, 1e-9, 2e-6, 1e-5, 1e-4, 1e-2] {
                let points = [x, 0.3 * x, -x, 1.7 * x];
                let each = points.map(|x| law.force(x));
                let (force, slope) = law.loads(points).sum();
                let forces: f64 = each.iter().map(|e| e.0).sum();
                let slopes: f64 = each.iter().map(|e| e.1).sum();
                assert_relative_eq!(force, forces, max_relative = 1e-13);
                assert_relative_eq!(slope, slopes, max_relative = 1e-13);
            }
            assert_eq!(law.loads([-1e-6; 4]).sum(), (0.0, 0.0));
        }
    }

    #[test]
    fn held_contact_has_the_slopes_of_its_energy() {
        let at = |radius: f64, lengths: [f64; 2]| {
            let bodies = lengths.map(|reference_length| LocalBody {
                plane_compliance: STEEL,
                reference_length,
                corner: Corner::NONE,
            });
            let profile = GapProfile::parabola(0.0, radius.recip(), [-1.0, 1.0]);
            LocalContact::new(bodies, &profile, 0.6e-3)
        };
        let x = [3e-6, 5e-6, -1e-6, 2e-7];
        let energy = |law: LocalContact| -> f64 { x.iter().map(|x| law.energy(*x)).sum() };
        let lengths = [1.2e-3, 2.0e-3];
        let law = at(7e-3, lengths);
        let held = law.held(&law.loads(x), x, [STEEL; 2]).unwrap();
        assert_relative_eq!(held.energy, energy(at(7e-3, lengths)), max_relative = 1e-13);
        let h = 1e-5f64;
        let by_radius = energy(at(7e-3 * h.exp(), lengths)) - energy(at(7e-3 / h.exp(), lengths));
        assert_relative_eq!(
            held.by_log_radius,
            by_radius / (2.0 * h),
            max_relative = 1e-8
        );
        for gear in 0..2 {
            let moved = |h: f64| {
                let mut moved = lengths;
                moved[gear] *= h.exp();
                energy(at(7e-3, moved))
            };
            let slope = (moved(h) - moved(-h)) / (2.0 * h);
            assert_relative_eq!(held.by_log_length[gear], slope, max_relative = 1e-8);
        }
    }

    #[test]
    fn the_derivative_is_that_of_the_force() {
        let law = law();
        for x in [1e-9, 1e-7, 2e-6, 1e-5, 1e-3, 1e-2] {
            let d = 1e-5 * x;
            let numeric = (law.force(x + d).0 - law.force(x - d).0) / (2.0 * d);
            assert_relative_eq!(law.force(x).1, numeric, max_relative = 1e-8);
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
                let slope = (law.energy(x + d) - law.energy(x - d)) / (2.0 * d);
                assert_relative_eq!(law.force(x).0, slope, max_relative = 1e-6);
            }
            assert_eq!(law.energy(-1e-6), 0.0);
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
            let relief = law.relief.as_deref().map(|relief| relief.least[2]);
            let edge = law.edge.as_ref().map(TipEdge::least_penetration);
            for at in [relief, edge].into_iter().flatten().filter(|x| *x > 0.0) {
                let [below, above] = [1.0 - 1e-9, 1.0 + 1e-9].map(|near| near * at);
                let ([f, slope], [g, other]) = (law.force(below).into(), law.force(above).into());
                assert_relative_eq!(f, g, max_relative = 1e-7);
                assert_relative_eq!(slope, other, max_relative = 1e-7);
                let energies = [below, above].map(|x| law.energy(x));
                assert_relative_eq!(energies[0], energies[1], max_relative = 1e-7);
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
