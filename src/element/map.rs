//! The one linear map between the motions of two gears and what the law knows of them.
//!
//! In the [`LineFrame`] with C, lambda, b, theta_1, theta_2 of that place, X = c1 + w (c2 - c1), w = z1/(z1 + e z2), is
//! the operating pitch point, rho_i its distance from axis i and zeta_2 = lambda - (1 - w) C b_x its axial position on
//! gear 2. A pose becomes [`Coordinates`] q:
//!
//! ```text
//! turn             x  = -(rb1/z1) [z1 theta_1 + e z2 theta_2] - h tan(beta_b) (zeta_2 - z_ref)
//! half_gap         H  = sum kappa_i rb_i (inv(rho_i) - psi_i),   rho_1 = |w| C,   rho_2 = |1 - w| C sqrt(1 - b_x²)
//! center_distance  C,   cos phi = |rb1 + e rb2| / C
//! misalignment     M  = -e sin(phi) b_x - s sc cos(phi) b_y, in parts even and odd in s
//! mesh_angle       theta_1 less that of the line of centres (0 or pi),   axial  lambda
//! ```
//!
//! Both flanks s = +1, -1 share everything but signs: delta_s = s x - H is minus the sum of the signed
//! normal distances of X to both flanks over cos(beta_b). With t the twist of gear 2 against gear 1,
//! q' = J t ([`Map::rates`]), and slopes g of a potential by q are the wrench -J^T g on gear 2 ([`Map::loads`]):
//! virtual work, so that what the law keeps or takes of the energy is what the gears feel. J is never
//! written out: it is the few slopes of q by the scalars of the frame, times theirs by t (tested: both directions are each
//! other's transpose).

mod line_frame;
mod slide;

use line_frame::LineFrame;

use super::constants::Constants;
use super::error::ElementError;
use super::motion::Motion;
use super::scalar::{Scalar, angles, lift};
use super::{Formulation, check};
use nalgebra::Vector3;

/// What the law knows of a pose: the numbers themselves, their rates, or the slopes of a potential by them.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Coordinates<T> {
    /// x, part of the elongation that is odd in the flank's sign, m.
    pub turn: T,
    /// H, half the gap on the line of action, m.
    pub half_gap: T,
    /// C, m.
    pub center_distance: T,
    /// M, the parts even and odd in the flank's sign, rad.
    pub misalignment: [T; 2],
    /// Angle of the line of centres in body 1, gamma - theta1, rad; one pitch is one mesh cycle.
    pub mesh_angle: T,
    /// lambda, m.
    pub axial: T,
}

/// Force and moment, or velocity and angular velocity, at one point: on the gears at their origins in W, between
/// the gears on gear 2 at c2 in the frame of the line of centres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Spatial<T> {
    /// Force, N, or velocity, m/s.
    pub linear: Vector3<T>,
    /// Moment, N m, or angular velocity, rad/s.
    pub angular: Vector3<T>,
}

/// J at one pose.
pub(crate) struct Map<T> {
    frame: LineFrame<T>,
    /// 1 / C.
    per_c: T,
    /// 1 / b_z.
    per_bz: T,
    /// (b_y, b_z) / D: minus the slopes of theta_2 by w_y and w_z.
    spin: [T; 2],
    /// w = z1 / (z1 + e z2).
    w: f64,
    /// rb1 and e rb2: minus the slopes of x by theta_1 and theta_2.
    radii: [f64; 2],
    /// h tan(beta_b).
    helix: f64,
    /// Slopes of H by C and b_x.
    half_gap: [T; 2],
    /// Slopes of the even part of M by C and b_x.
    even: [T; 2],
    /// Slopes of the odd part of M by C and b_y.
    odd: [T; 2],
    /// Tangents of the pressure angle at X on either gear; zero inside the base circle.
    tangents: [f64; 2],
}

/// Where the gears stand.
pub(crate) enum Placed<T> {
    /// In mesh or near it.
    Near(Map<T>),
    /// Out of reach: X - p1, W, and C.
    Far(Vector3<T>, T),
}

impl<T: Scalar> Map<T> {
    /// Map of a pose. The station is mid-face. In the paper's formulation it is gear 1's
    /// z = 0 face, and the elongation knows rotations about the axes alone: x without helix, H fixed.
    ///
    /// # Errors
    /// Axes that do not run alike, base circles without a common tangent.
    #[inline(always)]
    pub(crate) fn place(
        k: &Constants,
        formulation: Formulation,
        gears: &[Motion; 2],
    ) -> Result<Placed<T>, ElementError> {
        let whole = formulation == Formulation::Conjugate;
        let (station, tan_beta_b) = if whole {
            (k.z_ref, k.tan_beta_b)
        } else {
            (0.0, 0.0)
        };
        let frame = LineFrame::<T>::new(gears, station)?;
        let w = k.pitch_fraction;
        let c = frame.c;
        if !check::has_line_of_action(k, c.re())? {
            let point = Vector3::new(c * w, T::from(0.0), T::from(station));
            return Ok(Placed::Far(frame.to_world(&point), c));
        }
        let per_c = c.recip();
        let [bx, by, bz] = frame.b;
        let d = -bx * bx + 1.0;
        let per_d = d.recip();
        let cos_phi = per_c * k.base_sum;
        let square = cos_phi * cos_phi;
        let sin_phi = (-square + 1.0).sqrt();
        // rho_2 sin(phi_2) over |1 - w| C. Tilt shortens rho_2 by its square; at C = |rb1 + e rb2| that can
        // cross the base circle.
        let rest = d - square;
        let root = if rest.re() > 0.0 {
            rest.sqrt()
        } else {
            T::from(0.0)
        };
        let half_gap = if whole {
            let by_rho2 = root * (k.kappa[1] * (1.0 - w).abs());
            [
                sin_phi * (k.kappa[0] * w.abs()) + by_rho2,
                -by_rho2 * c * bx * per_d,
            ]
        } else {
            [T::from(0.0); 2]
        };
        let per_cos = 1.0 / cos_phi.re();
        Ok(Placed::Near(Map {
            per_bz: bz.recip(),
            spin: [by * per_d, bz * per_d],
            w,
            radii: [k.rb[0], k.e * k.rb[1]],
            helix: k.hand * tan_beta_b,
            half_gap,
            even: [bx * square * per_c / sin_phi * -k.e, sin_phi * -k.e],
            odd: [by * cos_phi * per_c * k.sc, cos_phi * -k.sc],
            tangents: [sin_phi.re() * per_cos, root.re() * per_cos],
            per_c,
            frame,
        }))
    }

    /// Coordinates at the pose `gears` of the map in the conjugate formulation, with x before the latch and not wrapped.
    #[inline(always)]
    pub(crate) fn coordinates(&self, k: &Constants, [g1, g2]: &[Motion; 2]) -> Coordinates<T> {
        let LineFrame {
            axes: [line, ..],
            c,
            lambda,
            b: [bx, by, _],
            gamma,
            theta2,
            ..
        } = &self.frame;
        let ahead = [line * self.w.signum(), line * (self.w - 1.0).signum()];
        let [tan1, tan2] = self.tangents;
        let [angle1, angle2, phi1, phi2] = angles(
            [
                ahead[0].dot(&g1.r.column(1)),
                ahead[1].dot(&g2.r.column(1)),
                tan1,
                tan2,
            ],
            [
                ahead[0].dot(&g1.r.column(0)),
                ahead[1].dot(&g2.r.column(0)),
                1.0,
                1.0,
            ],
        );
        let theta1 = *gamma + angle1;
        let theta2 = *theta2 + angle2;
        let gap = (tan1 - phi1) * (k.kappa[0] * k.rb[0])
            + (tan2 - phi2) * (k.kappa[1] * k.rb[1])
            + k.half_gap;
        Coordinates {
            turn: (theta1 * k.z[0] + theta2 * (k.e * k.z[1]) - k.tooth_zero) * -k.per_tooth_angle
                - (*lambda - *c * *bx * (1.0 - self.w) - k.z_ref) * self.helix,
            half_gap: lift(gap, &self.half_gap.map(T::re), &[*c, *bx]),
            center_distance: *c,
            misalignment: [self.even[1] * *bx, self.odd[1] * *by],
            mesh_angle: theta1 - k.behind,
            axial: *lambda,
        }
    }

    /// Twist of gear 2 against gear 1 while both move as `gears` tell.
    #[inline(always)]
    pub(crate) fn twist(&self, gears: &[Motion; 2]) -> Spatial<T> {
        self.frame.twist(gears)
    }

    /// J `twist`: rates of the coordinates.
    #[inline(always)]
    pub(crate) fn rates(&self, twist: &Spatial<T>) -> Coordinates<T> {
        let (d, w) = (&twist.linear, &twist.angular);
        let [bx, by, bz] = self.frame.b;
        let axial = -d.z * self.per_bz;
        let c = d.x + bx * axial;
        let gamma = (d.y + by * axial) * self.per_c;
        let spin = w.z - gamma;
        let b = [bz * w.y - by * spin, bx * spin - bz * w.x];
        let theta2 = -(self.spin[1] * spin + self.spin[0] * w.y);
        let along = (c * bx + self.frame.c * b[0]) * (1.0 - self.w);
        Coordinates {
            turn: (axial - along) * -self.helix - gamma * self.radii[0] - theta2 * self.radii[1],
            half_gap: self.half_gap[0] * c + self.half_gap[1] * b[0],
            center_distance: c,
            misalignment: [
                self.even[0] * c + self.even[1] * b[0],
                self.odd[0] * c + self.odd[1] * b[1],
            ],
            mesh_angle: gamma,
            axial,
        }
    }

    /// -J^T `slopes`: wrench on gear 2.
    #[inline(always)]
    pub(crate) fn loads(&self, slopes: &Coordinates<T>) -> Spatial<T> {
        let [m_even, m_odd] = slopes.misalignment;
        let [bx, by, bz] = self.frame.b;
        let along = slopes.turn * (self.helix * (1.0 - self.w));
        // Slopes by the scalars of the frame.
        let by_c = slopes.center_distance
            + bx * along
            + self.half_gap[0] * slopes.half_gap
            + self.even[0] * m_even
            + self.odd[0] * m_odd;
        let by_bx =
            self.frame.c * along + self.half_gap[1] * slopes.half_gap + self.even[1] * m_even;
        let by_by = self.odd[1] * m_odd;
        let by_theta1 = slopes.mesh_angle - slopes.turn * self.radii[0];
        let by_theta2 = slopes.turn * -self.radii[1];
        let by_lambda = slopes.axial - slopes.turn * self.helix;
        let moment = Vector3::new(
            bz * by_by,
            self.spin[0] * by_theta2 - bz * by_bx,
            by * by_bx - bx * by_by + self.spin[1] * by_theta2,
        );
        let [x, y] = [-by_c, -(by_theta1 + moment.z) * self.per_c];
        Spatial {
            linear: Vector3::new(x, y, (by_lambda - bx * x - by * y) * self.per_bz),
            angular: moment,
        }
    }

    /// Forces and moments on both gears about their origins, W, of the wrench `on_2` on gear 2 and its opposite on gear 1.
    #[inline(always)]
    pub(crate) fn on_gears(&self, on_2: &Spatial<T>) -> [Spatial<T>; 2] {
        self.frame.loads(on_2)
    }

    /// Without derivatives.
    pub(crate) fn re(&self) -> Map<f64> {
        Map {
            frame: self.frame.re(),
            per_c: self.per_c.re(),
            per_bz: self.per_bz.re(),
            spin: self.spin.map(T::re),
            w: self.w,
            radii: self.radii,
            helix: self.helix,
            half_gap: self.half_gap.map(T::re),
            even: self.even.map(T::re),
            odd: self.odd.map(T::re),
            tangents: self.tangents,
        }
    }

    /// From gear 1's origin to the point `arm` (m) along gear 1's axis from the operating pitch point at the station, m, W.
    #[inline(always)]
    pub(crate) fn beside_pitch_point(&self, arm: T) -> Vector3<T> {
        let frame = &self.frame;
        let point = Vector3::new(frame.c * self.w, T::from(0.0), arm + frame.station);
        frame.to_world(&point)
    }
}

impl<T: Scalar> std::ops::Add for Coordinates<T> {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        let [even, odd] = self.misalignment;
        Self {
            turn: self.turn + other.turn,
            half_gap: self.half_gap + other.half_gap,
            center_distance: self.center_distance + other.center_distance,
            misalignment: [even + other.misalignment[0], odd + other.misalignment[1]],
            mesh_angle: self.mesh_angle + other.mesh_angle,
            axial: self.axial + other.axial,
        }
    }
}

impl<T: Scalar> std::ops::Add for Spatial<T> {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            linear: self.linear + other.linear,
            angular: self.angular + other.angular,
        }
    }
}
