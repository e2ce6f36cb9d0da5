//! The one linear map between the motions of two gears and what the law knows of them.
//!
//! A fixed station on gear 1's axis is c1; c2 is where the axis of gear 2 pierces the transverse plane of
//! gear 1 through c1; u = c2 - c1 and X = c1 + w u, w = z1/(z1 + e z2), is the operating pitch point. A pose
//! becomes [`Coordinates`] q, with (rho_i, theta_i, zeta_i) the cylindrical coordinates of X in body i:
//!
//! ```text
//! turn             x  = -(rb1/z1) [z1 theta_1 + e z2 theta_2] - h tan(beta_b) (zeta_2 - z_ref)
//! half_gap         H  = sum kappa_i rb_i (inv(rho_i) - psi_i)
//! center_distance  C  = |u|,  cos phi = |rb1 + e rb2| / C
//! misalignment     M  = -(e sin(phi) x^ + s sc cos(phi) y^) . a2, in parts even and odd in s
//! mesh_angle       theta_1 less that of the line of centres (0 or pi),   axial  lambda = axial position of c2 in gear 2
//! ```
//!
//! Both flanks s = +1, -1 share everything but signs: delta_s = s x - H is minus the sum of the signed
//! normal distances of X to both flanks over cos(beta_b). With v the velocities of both gears,
//! q' = J v ([`Map::rates`]), and slopes g of a potential by q are the loads -J^T g ([`Map::loads`]): virtual
//! work, so that what the law keeps or takes of the energy is what the gears feel. J is never
//! written out; both directions go through the same few vectors (tested to be each other's transpose).

mod slide;

pub(crate) use slide::Slide;

use super::constants::{Constants, TILT_LIMIT};
use super::error::{Body, ElementError};
use super::motion::Motion;
use super::scalar::{Scalar, angles, scaled};
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

/// Force and moment about the origin of a gear, or its velocity and angular velocity; W.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Spatial<T> {
    /// Force, N, or velocity, m/s.
    pub linear: Vector3<T>,
    /// Moment, N m, or angular velocity, rad/s.
    pub angular: Vector3<T>,
}

/// J at one pose.
pub(crate) struct Map<T> {
    /// Axes.
    a: [Vector3<T>; 2],
    /// 1 / (a1 . a2).
    per_aa: T,
    /// w = z1 / (z1 + e z2).
    w: f64,
    /// e.
    e: f64,
    /// Axial position of c1 in gear 1, m.
    station: f64,
    /// c1 - p1.
    k1: Vector3<T>,
    /// c2 - p2.
    k2: Vector3<T>,
    /// c2 - c1.
    u: Vector3<T>,
    /// a1 x u.
    across: Vector3<T>,
    /// Direction of u.
    line: Vector3<T>,
    /// Gradients by X of H ...
    even: [Vector3<T>; 2],
    /// ... and of -x, on gear 2 over e.
    odd: [Vector3<T>; 2],
    /// Gradient by X of theta_1.
    around: Vector3<T>,
    /// Gradients of both parts of M by u ...
    misalignment_u: [Vector3<T>; 2],
    /// ... by a1 (odd part alone) ...
    misalignment_a1: Vector3<T>,
    /// ... and by a2.
    misalignment_a2: [Vector3<T>; 2],
}

/// Where the gears stand.
pub(crate) enum Placed<T> {
    /// In mesh or near it: coordinates, with x before the latch and not wrapped, and the map.
    Near(Coordinates<T>, Map<T>),
    /// Out of reach: X - p1 and C.
    Far(Vector3<T>, T),
}

impl<T: Scalar> Map<T> {
    /// Coordinates and map of a pose. The station is mid-face. In the paper's formulation it is gear 1's
    /// z = 0 face, and the elongation knows rotations about the axes alone: x without helix, H fixed.
    ///
    /// # Errors
    /// Axes that do not run alike, base circles without a common tangent.
    #[inline(always)]
    pub(crate) fn place(
        k: &Constants,
        formulation: Formulation,
        [g1, g2]: &[Motion<T>; 2],
    ) -> Result<Placed<T>, ElementError> {
        let whole = formulation == Formulation::Conjugate;
        let (station, tan_beta_b) = if whole {
            (k.z_ref, k.tan_beta_b)
        } else {
            (0.0, 0.0)
        };
        let a = [g1.r.column(2).into_owned(), g2.r.column(2).into_owned()];
        let aa = a[0].dot(&a[1]);
        check::tilt(Body::Gear2, Body::Gear1, aa.re(), TILT_LIMIT)?;
        let relative = g2.p - g1.p;
        let k1 = scaled(&a[0], station);
        let per_aa = aa.recip();
        let lambda = (k1 - relative).dot(&a[0]) * per_aa;
        let k2 = a[1] * lambda;
        let u = relative + k2 - k1;
        let c = u.dot(&u).sqrt();
        let w = k.pitch_fraction;
        if check::center_distance(k, c.re())? == check::Distance::OutOfReach {
            return Ok(Placed::Far(k1 + scaled(&u, w), c));
        }
        let per_c = c.recip();
        let line = u * per_c;
        let across = a[0].cross(&u);

        // Cylindrical coordinates of X in either body.
        let rho1 = c * w.abs();
        let along = u.dot(&a[1]) * (1.0 - w);
        let arm2 = a[1] * along - scaled(&u, 1.0 - w);
        let rho2 = arm2.dot(&arm2).sqrt();
        let per_rho = [rho1.recip(), rho2.recip()];
        let radial = [scaled(&line, w.signum()), arm2 * per_rho[1]];
        // Tangent of the pressure angle at X on either gear. Tilt shortens rho_2 by its square; at
        // C = |rb1 + e rb2| that can cross the base circle.
        let tangent = [tangent(rho1 * k.per_rb[0]), tangent(rho2 * k.per_rb[1])];
        let one = T::from(1.0);
        let [theta1, theta2, phi1, phi2] = angles(
            [
                radial[0].dot(&g1.r.column(1)),
                radial[1].dot(&g2.r.column(1)),
                tangent[0],
                tangent[1],
            ],
            [
                radial[0].dot(&g1.r.column(0)),
                radial[1].dot(&g2.r.column(0)),
                one,
                one,
            ],
        );
        let half_gap = (tangent[0] - phi1) * (k.kappa[0] * k.rb[0])
            + (tangent[1] - phi2) * (k.kappa[1] * k.rb[1])
            + k.half_gap;
        let per_tooth = k.per_tooth_angle;
        let turn = (theta1 * k.z[0] + theta2 * (k.e * k.z[1]) - k.tooth_zero) * -per_tooth
            - (lambda - along - k.z_ref) * (k.hand * tan_beta_b);

        // Gradients by X.
        let hands = [k.hand, -k.e * k.hand];
        let about = [a[0].cross(&radial[0]), a[1].cross(&radial[1])];
        let cosine = [per_rho[0] * k.rb[0], per_rho[1] * k.rb[1]];
        let radial_part = |i: usize| {
            if whole {
                radial[i] * (tangent[i] * cosine[i] * k.kappa[i])
            } else {
                Vector3::zeros()
            }
        };
        let odd = |i: usize| about[i] * cosine[i] - scaled(&a[i], hands[i] * tan_beta_b);

        // M and its gradients at fixed axes, and by the axes.
        let cos_phi = per_c * k.base_sum;
        let sin_phi = (-cos_phi * cos_phi + 1.0).sqrt();
        let (alpha, beta) = (sin_phi * per_c, cos_phi * per_c);
        let (u_axial, u_across) = (u.dot(&a[1]), across.dot(&a[1]));
        let alpha_slope = (sin_phi.recip() - sin_phi * 2.0) * (per_c * per_c);
        let beta_slope = -beta * per_c * 2.0;
        let coordinates = Coordinates {
            turn,
            half_gap,
            center_distance: c,
            misalignment: [u_axial * alpha * -k.e, u_across * beta * -k.sc],
            mesh_angle: theta1 - k.behind,
            axial: lambda,
        };
        let map = Map {
            per_aa,
            w,
            e: k.e,
            station,
            k1,
            k2,
            even: [radial_part(0), radial_part(1)],
            odd: [odd(0), odd(1)],
            around: about[0] * per_rho[0],
            misalignment_u: [
                scaled(&(a[1] * alpha + line * (u_axial * alpha_slope)), -k.e),
                scaled(
                    &(a[1].cross(&a[0]) * beta + line * (u_across * beta_slope)),
                    -k.sc,
                ),
            ],
            misalignment_a1: u.cross(&a[1]) * (beta * -k.sc),
            misalignment_a2: [u * (alpha * -k.e), across * (beta * -k.sc)],
            across,
            line,
            u,
            a,
        };
        Ok(Placed::Near(coordinates, map))
    }

    /// J v: rates of the coordinates while the gears move with `v`.
    #[inline(always)]
    pub(crate) fn rates(&self, [v1, v2]: &[Spatial<T>; 2]) -> Coordinates<T> {
        let d = v2.linear + v2.angular.cross(&self.k2) - v1.linear - v1.angular.cross(&self.k1);
        let axial = -(d.dot(&self.a[0]) + v1.angular.dot(&self.across)) * self.per_aa;
        let slip = self.a[1] * axial;
        let u = d + slip;
        // Velocity of X against the material of either gear.
        let x1 = scaled(&(u - v1.angular.cross(&self.u)), self.w);
        let x2 = slip - scaled(&(u - v2.angular.cross(&self.u)), 1.0 - self.w);
        let [a1, a2] = [v1.angular.cross(&self.a[0]), v2.angular.cross(&self.a[1])];
        let [m_u, m_a2] = [&self.misalignment_u, &self.misalignment_a2];
        Coordinates {
            turn: -(self.odd[0].dot(&x1) + self.odd[1].dot(&x2) * self.e),
            half_gap: self.even[0].dot(&x1) + self.even[1].dot(&x2),
            center_distance: self.line.dot(&u),
            misalignment: [
                m_u[0].dot(&u) + m_a2[0].dot(&a2),
                m_u[1].dot(&u) + self.misalignment_a1.dot(&a1) + m_a2[1].dot(&a2),
            ],
            mesh_angle: self.around.dot(&x1),
            axial,
        }
    }

    /// -J^T `slopes`: force and moment on each gear about its own origin.
    #[inline(always)]
    pub(crate) fn loads(&self, slopes: &Coordinates<T>) -> [Spatial<T>; 2] {
        let [m_even, m_odd] = slopes.misalignment;
        let [m_u, m_a2] = [&self.misalignment_u, &self.misalignment_a2];
        let n1 = self.even[0] * slopes.half_gap - self.odd[0] * slopes.turn
            + self.around * slopes.mesh_angle;
        let n2 = self.even[1] * slopes.half_gap - self.odd[1] * (slopes.turn * self.e);
        let by_u = m_u[0] * m_even
            + m_u[1] * m_odd
            + self.line * slopes.center_distance
            + scaled(&n1, self.w)
            + scaled(&n2, self.w - 1.0);
        let by_axial = (by_u.dot(&self.a[1]) + n2.dot(&self.a[1]) + slopes.axial) * self.per_aa;
        let force = by_u - self.a[0] * by_axial;
        let couple1 = scaled(&self.u.cross(&n1), self.w) + self.across * by_axial
            - self.a[0].cross(&(self.misalignment_a1 * m_odd));
        let couple2 = scaled(&self.u.cross(&n2), self.w - 1.0)
            - self.a[1].cross(&(m_a2[0] * m_even + m_a2[1] * m_odd));
        [
            Spatial {
                linear: force,
                angular: self.k1.cross(&force) + couple1,
            },
            Spatial {
                linear: -force,
                angular: couple2 - self.k2.cross(&force),
            },
        ]
    }

    /// Without derivatives.
    pub(crate) fn re(&self) -> Map<f64> {
        let re = |v: &Vector3<T>| v.map(|x| x.re());
        let both = |v: &[Vector3<T>; 2]| [re(&v[0]), re(&v[1])];
        Map {
            a: both(&self.a),
            per_aa: self.per_aa.re(),
            w: self.w,
            e: self.e,
            station: self.station,
            k1: re(&self.k1),
            k2: re(&self.k2),
            u: re(&self.u),
            across: re(&self.across),
            line: re(&self.line),
            even: both(&self.even),
            odd: both(&self.odd),
            around: re(&self.around),
            misalignment_u: both(&self.misalignment_u),
            misalignment_a1: re(&self.misalignment_a1),
            misalignment_a2: both(&self.misalignment_a2),
        }
    }

    /// X - p1, m: the operating pitch point at the station.
    pub(crate) fn pitch_point(&self) -> Vector3<T> {
        self.k1 + scaled(&self.u, self.w)
    }

    /// Direction of gear 1's axis.
    pub(crate) fn axis(&self) -> Vector3<T> {
        self.a[0]
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

/// Tangent of the pressure angle where the radius is `ratio` times the base radius; zero inside the base circle.
#[inline(always)]
fn tangent<T: Scalar>(ratio: T) -> T {
    let square = ratio * ratio - 1.0;
    if square.re() > 0.0 {
        square.sqrt()
    } else {
        T::from(0.0)
    }
}
