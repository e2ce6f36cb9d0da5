//! The one linear map between the motions of two gears and what the law knows of them.
//!
//! A fixed station on gear 1's axis is c1; c2 is where the axis of gear 2 pierces the transverse plane of gear 1
//! through c1. The frame of the line of centres has its origin at c2, x along c1 -> c2, z = a1 and y = z × x. What gear 2's pose can
//! change in it are the distance C, the axial position lambda of c2 on gear 2, the components b of its axis a2, the direction gamma
//! of x about z, and the angle theta_2 of the line of centres in gear 2; theta_1 changes as gamma. If gear 2 moves against gear 1 by the
//! small twist t = (d, w) at c2, then with D = 1 - b_x²
//!
//! ```text
//! dlambda = -d_z / b_z                     db_x = b_z w_y - b_y (w_z - dgamma)
//! dC      = d_x + b_x dlambda              db_y = b_x (w_z - dgamma) - b_z w_x
//! dgamma  = (d_y + b_y dlambda) / C        dtheta_2 = -[b_z (w_z - dgamma) + b_y w_y] / D
//! ```
//!
//! X = c1 + f (c2 - c1), f = z1/(z1 + e z2), is the operating pitch point, rho_i its distance from axis i and
//! zeta_2 = lambda - (1 - f) C b_x its axial position on gear 2. A pose becomes [`Coordinates`] q:
//!
//! ```text
//! turn             x  = -(rb1/z1) [z1 theta_1 + e z2 theta_2] - h tan(beta_b) (zeta_2 - z_ref)
//! half_gap         H  = sum kappa_i rb_i (inv(rho_i) - psi_i),   rho_1 = |f| C,   rho_2 = |1 - f| C sqrt(1 - b_x²)
//! center_distance  C,   cos phi = |rb1 + e rb2| / C
//! misalignment     M  = -e sin(phi) b_x - s sc cos(phi) b_y, in parts even and odd in s
//! mesh_angle       theta_1 less that of the line of centres (0 or pi),   axial  lambda
//! ```
//!
//! Both flanks s = +1, -1 share everything but signs: delta_s = s x - H is minus the sum of the signed
//! normal distances of X to both flanks over cos(beta_b). q' = J t ([`Map::rates`]), and slopes g of a potential by q are
//! the wrench -J^T g on gear 2 ([`Map::wrench`]): virtual work, so that what the law keeps or takes of the energy is what the
//! gears feel. J is never written out: it is the few slopes of q by the scalars of the frame, times theirs by t.

use super::Formulation;
use super::constants::{Constants, behind};
use super::dual::{Scalar, angles, cross, dot, lift, part, scaled, shifted, turned};
use super::motion::{ElementError, Motion};
use nalgebra::Vector3;

/// Largest angle between the axes, rad. The misalignment enters to first order (residual C tilt^2),
/// so this is far beyond where the result is good, yet near enough to stop a wrong frame.
const TILT_LIMIT: f64 = 0.1;

/// What the law knows of a pose: the numbers themselves, their rates, or the slopes of a potential by them.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Coordinates<T> {
    /// x, part of the penetration that is odd in the flank's sign, m.
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

impl<T: Scalar> Spatial<T> {
    /// Power of this wrench on the twist `other`.
    #[inline(always)]
    pub(crate) fn power(&self, other: &Self) -> T {
        dot(&self.linear, &other.linear) + dot(&self.angular, &other.angular)
    }

    /// Adds `other` `factor` times.
    #[inline(always)]
    pub(crate) fn add(&mut self, other: &Self, factor: T) {
        for i in 0..3 {
            self.linear[i] += other.linear[i] * factor;
            self.angular[i] += other.angular[i] * factor;
        }
    }
}

/// The frame of the line of centres and J at one pose.
pub(crate) struct Map<T> {
    /// Directions of x and y, W.
    x: Vector3<T>,
    y: Vector3<T>,
    /// Direction of z, W.
    z: Vector3<f64>,
    /// From the origins of gear 1 and gear 2 to c2, W, m.
    arms: [Vector3<T>; 2],
    /// Axial position of c1 in gear 1, m.
    station: f64,
    /// C, m.
    pub c: T,
    /// Whether there is a line of action. Else the gears are out of mesh, and only `c` and the frame have a meaning.
    pub has_line_of_action: bool,
    /// lambda, m.
    lambda: T,
    /// Axis of gear 2 in the frame of the mesh.
    b: [T; 3],
    /// 1 / C, 1/m.
    per_c: T,
    /// 1 / b_z.
    per_bz: T,
    /// Of the operating transverse pressure angle.
    cos_phi: T,
    sin_phi: T,
    /// (b_y, b_z) / D: minus the slopes of theta_2 by w_y and w_z.
    spin: [T; 2],
    /// f.
    pitch_fraction: f64,
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

impl<T: Scalar> Map<T> {
    /// Map of a pose. The station is mid-face. In the paper's formulation it is gear 1's z = 0 face, and the penetration knows
    /// rotations about the axes alone: x without helix, H fixed.
    /// Errors: axes that do not run alike, base circles without a common tangent.
    #[inline(always)]
    pub(crate) fn new(
        k: &Constants,
        formulation: Formulation,
        [g1, g2]: &[Motion; 2],
    ) -> Result<Self, ElementError> {
        let whole = formulation == Formulation::Conjugate;
        let (station, tan_beta_b) = if whole {
            (k.z_ref, k.tan_beta_b)
        } else {
            (0.0, 0.0)
        };
        let z = g1.r.column(2).into_owned();
        let a2 = turned::<T>(&g2.r.column(2).into_owned(), part::ROTATION_2);
        let bz = dot(&a2, &z);
        check_tilt("gear2", "gear1", bz.re())?;
        let per_bz = bz.recip();
        let between = shifted::<T>(&(g2.p - g1.p), part::POSITION_2);
        let lambda = (-dot(&between, &z) + station) * per_bz;
        let arm_2 = scaled(&a2, lambda);
        let arm_1 = between + arm_2;
        let line = arm_1 - z.map(|e| T::from(e * station));
        let c = dot(&line, &line).sqrt();
        let per_c = c.recip();
        let x = scaled(&line, per_c);
        let y = cross(&x, &-z);
        let (bx, by) = (dot(&x, &a2), dot(&y, &a2));

        let fraction = k.pitch_fraction;
        let d = -bx * bx + 1.0;
        let per_d = d.recip();
        let cos_phi = per_c * k.base_radius_sum;
        let square = cos_phi * cos_phi;
        let sin_phi = (-square + 1.0).sqrt();
        // rho_2 sin(phi_2) over |1 - f| C. Tilt shortens rho_2 by its square; at C = |rb1 + e rb2| that can
        // cross the base circle.
        let rest = d - square;
        let root = if rest.re() > 0.0 {
            rest.sqrt()
        } else {
            T::from(0.0)
        };
        let half_gap = if whole {
            let by_rho2 = root * (k.kappa[1] * (1.0 - fraction).abs());
            [
                sin_phi * (k.kappa[0] * fraction.abs()) + by_rho2,
                -by_rho2 * c * bx * per_d,
            ]
        } else {
            [T::from(0.0); 2]
        };
        let per_cos = 1.0 / cos_phi.re();
        Ok(Self {
            x,
            y,
            z,
            arms: [arm_1, arm_2],
            station,
            c,
            has_line_of_action: k.has_line_of_action(c.re())?,
            lambda,
            b: [bx, by, bz],
            per_c,
            per_bz,
            cos_phi,
            sin_phi,
            spin: [by * per_d, bz * per_d],
            pitch_fraction: fraction,
            radii: [k.base_radius[0], k.e * k.base_radius[1]],
            helix: k.hand * tan_beta_b,
            half_gap,
            even: [bx * square * per_c / sin_phi * -k.e, sin_phi * -k.e],
            odd: [by * cos_phi * per_c * k.sc, cos_phi * -k.sc],
            tangents: [sin_phi.re() * per_cos, root.re() * per_cos],
        })
    }

    /// Coordinates at the pose `gears` of the map in the conjugate formulation, with x before the phase offset and not wrapped.
    #[inline(always)]
    pub(crate) fn coordinates(&self, k: &Constants, [g1, g2]: &[Motion; 2]) -> Coordinates<T> {
        let [bx, by, _] = self.b;
        let [ahead_1, ahead_2] = [
            self.pitch_fraction.signum(),
            (self.pitch_fraction - 1.0).signum(),
        ];
        let column = |gear: &Motion, axis: usize| gear.r.column(axis).into_owned();
        let (x1, y1) = (column(g1, 0), column(g1, 1));
        let x2 = turned::<T>(&column(g2, 0), part::ROTATION_2);
        let y2 = turned::<T>(&column(g2, 1), part::ROTATION_2);
        let [tan1, tan2] = self.tangents;
        let [theta1, theta2, phi1, phi2] = angles(
            [
                dot(&self.x, &y1) * ahead_1,
                dot(&self.x, &y2) * ahead_2,
                tan1.into(),
                tan2.into(),
            ],
            [
                dot(&self.x, &x1) * ahead_1,
                dot(&self.x, &x2) * ahead_2,
                1.0.into(),
                1.0.into(),
            ],
        );
        let gap = (tan1 - phi1.re()) * (k.kappa[0] * k.base_radius[0])
            + (tan2 - phi2.re()) * (k.kappa[1] * k.base_radius[1])
            + k.half_gap;
        Coordinates {
            turn: (theta1 * k.z[0] + theta2 * (k.e * k.z[1]) - k.tooth_zero) * -k.per_tooth_angle
                - (self.lambda - self.c * bx * (1.0 - self.pitch_fraction) - k.z_ref) * self.helix,
            half_gap: lift(gap, &self.half_gap.map(T::re), &[self.c, bx]),
            center_distance: self.c,
            misalignment: [self.even[1] * bx, self.odd[1] * by],
            mesh_angle: theta1 - behind(self.pitch_fraction),
            axial: self.lambda,
        }
    }

    /// Twist of gear 2 against gear 1 at c2 while both move as `gears`: m/s, rad/s.
    #[inline(always)]
    pub(crate) fn twist(&self, [g1, g2]: &[Motion; 2]) -> Spatial<T> {
        let w2 = shifted::<T>(&g2.w, part::SPIN_2);
        let v = shifted::<T>(&(g2.v - g1.v), part::VELOCITY_2);
        let velocity = v + cross(&w2, &self.arms[1]) + cross(&self.arms[0], &g1.w);
        let w = shifted::<T>(&(g2.w - g1.w), part::SPIN_2);
        Spatial {
            linear: self.components(&velocity),
            angular: self.components(&w),
        }
    }

    /// J `twist`: rates of the coordinates.
    #[inline(always)]
    pub(crate) fn rates(&self, twist: &Spatial<T>) -> Coordinates<T> {
        let (d, w) = (&twist.linear, &twist.angular);
        let [bx, by, bz] = self.b;
        let axial = -d.z * self.per_bz;
        let c = d.x + bx * axial;
        let gamma = (d.y + by * axial) * self.per_c;
        let spin = w.z - gamma;
        let b = [bz * w.y - by * spin, bx * spin - bz * w.x];
        let theta2 = -(self.spin[1] * spin + self.spin[0] * w.y);
        let along = (c * bx + self.c * b[0]) * (1.0 - self.pitch_fraction);
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
    pub(crate) fn wrench(&self, slopes: &Coordinates<T>) -> Spatial<T> {
        let [m_even, m_odd] = slopes.misalignment;
        let [bx, by, bz] = self.b;
        let along = slopes.turn * (self.helix * (1.0 - self.pitch_fraction));
        // Slopes by the scalars of the frame.
        let by_c = slopes.center_distance
            + bx * along
            + self.half_gap[0] * slopes.half_gap
            + self.even[0] * m_even
            + self.odd[0] * m_odd;
        let by_bx = self.c * along + self.half_gap[1] * slopes.half_gap + self.even[1] * m_even;
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

    /// Row of friction on the flank `sign`: the wrench on gear 2 by friction of unit size.
    ///
    /// In the transverse plane of gear 1 let n be the line of action, the direction of the flank's force on gear 2, and
    /// t = a1 x n. At X + s n + z a1 gear 1 slides on gear 2 with t . v12(X) - z n . w12 + s a1 . w12, v12 and w12 velocity
    /// and angular velocity of gear 1 against gear 2. With the sums over the line loads of [`crate::friction::Sliding`], `share`,
    /// `share_z` (m) and `distance` (m), sliding as friction sees it has the mean speed
    ///
    /// ```text
    /// r = share t . v12(X) - share_z n . w12 + distance a1 . w12,
    /// ```
    ///
    /// which is minus the power of this row on the twist of gear 2 against gear 1.
    #[inline(always)]
    pub(crate) fn friction_row(
        &self,
        k: &Constants,
        sign: f64,
        [share, share_z, distance]: [T; 3],
    ) -> Spatial<T> {
        let (x, y) = (self.sin_phi * k.e, self.cos_phi * (sign * k.sc));
        let force = [-y * share, x * share];
        // X - c2, mid-face, has these components along x and z.
        let (across, up) = (self.c * (self.pitch_fraction - 1.0), k.z_ref - self.station);
        Spatial {
            linear: Vector3::new(force[0], force[1], T::from(0.0)),
            angular: Vector3::new(
                -x * share_z - force[1] * up,
                force[0] * up - y * share_z,
                distance + across * force[1],
            ),
        }
    }

    /// Forces and moments on both gears about their origins, W, of the wrench `on_2` on gear 2 at c2 and its
    /// opposite on gear 1.
    #[inline(always)]
    pub(crate) fn on_gears(&self, on_2: &Spatial<T>) -> [Spatial<T>; 2] {
        let (force, moment) = (self.in_world(&on_2.linear), self.in_world(&on_2.angular));
        [
            Spatial {
                linear: -force,
                angular: -(cross(&self.arms[0], &force) + moment),
            },
            Spatial {
                linear: force,
                angular: cross(&self.arms[1], &force) + moment,
            },
        ]
    }

    #[inline(always)]
    fn in_world(&self, v: &Vector3<T>) -> Vector3<T> {
        scaled(&self.x, v.x) + scaled(&self.y, v.y) + scaled(&self.z, v.z)
    }

    #[inline(always)]
    fn components(&self, v: &Vector3<T>) -> Vector3<T> {
        Vector3::new(dot(v, &self.x), dot(v, &self.y), dot(v, &self.z))
    }

    /// From gear 1's origin to the point `arm` (m) along gear 1's axis from the operating pitch point at the station, m, W.
    #[inline(always)]
    pub(crate) fn near_pitch_point(&self, arm: T) -> Vector3<T> {
        scaled(&self.x, self.c * self.pitch_fraction) + scaled(&self.z, arm + self.station)
    }
}

/// Errors: the axes of `body` and `reference`, whose unit vectors have the product `cosine`, do not run alike.
#[inline(always)]
pub(crate) fn check_tilt(body: &str, reference: &str, cosine: f64) -> Result<(), ElementError> {
    if cosine < TILT_LIMIT.cos() {
        return Err(tilted(body, reference, cosine));
    }
    Ok(())
}

#[cold]
fn tilted(body: &str, reference: &str, cosine: f64) -> ElementError {
    let [tilt, limit] = [cosine.clamp(-1.0, 1.0).acos(), TILT_LIMIT].map(f64::to_degrees);
    ElementError::Pose(format!(
        "the axis of {body} is tilted by {tilt:.3} deg against {reference}; the element holds up to {limit:.1} deg and both z \
         axes must point alike"
    ))
}
