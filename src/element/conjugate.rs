//! The conjugate formulation: exact involute helicoids, the force along the exact gradient.
//!
//! A fixed station z_ref on gear 1's axis is c1; c2 is where the axis of gear 2 pierces the
//! transverse plane of gear 1 through c1; u = c2 - c1 and X = c1 + w u, w = z1/(z1 + e z2), is the
//! operating pitch point. With G_i the signed normal distance of X to the flank of gear i,
//!
//! ```text
//! G_i / cos beta_b = sigma_i [rb_i (theta_i - eta_i) - h_i zeta_i tan beta_b] + kappa_i rb_i inv(rho_i)
//! delta_s = -(G_1 + G_2) / cos beta_b,      sigma_1 = s, sigma_2 = e s,      eta_i = kappa_i sigma_i psi_i
//! ```
//!
//! where (rho_i, theta_i, zeta_i) are the cylindrical coordinates of X in body i. Both flanks share
//! everything but signs: with x = -sum of the terms in s (one pitch is 2 pi rb1 / z1) and half the gap
//! H = sum kappa_i rb_i (inv(rho_i) - psi_i),
//!
//! ```text
//! delta_s = s x - H,                        x wrapped to the nearest pitch
//! ```
//!
//! so one wrap serves both flanks and the state "in the gap" stays in one gap. Rates follow from
//! y_i, the velocity of X relative to the material of gear i; the loads are the negative transpose of
//! the same linear map (virtual work), which makes the undamped element conservative.

use super::Element;
use super::check::{self, Distance};
use super::engagement::engagement;
use super::error::{Body, ElementError};
use super::geometry::{FLANKS, TILT_LIMIT};
use super::load::{FlankLoad, carrying_flank};
use super::motion::{Inputs, Latch, Outputs};
use super::scalar::{Scalar, angles, fraction, wrap};
use nalgebra::Vector3;

/// Where the gears stand.
enum Placed<T> {
    /// In mesh or near it.
    Near(Geometry<T>),
    /// Out of reach: c1 + w u - p1 and the centre distance.
    Far(Vector3<T>, T),
}

/// Everything about the poses that both flanks share.
struct Geometry<T> {
    /// Axes.
    a: [Vector3<T>; 2],
    /// 1 / (a1 . a2).
    per_aa: T,
    /// c1 - p1.
    k1: Vector3<T>,
    /// Axial position of c2 in gear 2's frame.
    lambda: T,
    /// c2 - c1, its length and 1 / length.
    u: Vector3<T>,
    c: T,
    per_c: T,
    /// Unit vectors of the line of centres and across it.
    xh: Vector3<T>,
    yh: Vector3<T>,
    /// Radial and circumferential part of the flank normals over cos beta_b: the part even in s ...
    even: [Vector3<T>; 2],
    /// ... and the part odd in s.
    odd: [Vector3<T>; 2],
    /// Circumferential direction over rho on gear 1: gradient of theta_1 by X.
    turn: Vector3<T>,
    /// Angle of X in body 1, rad.
    theta1: T,
    /// Tooth angle 2 pi x / pitch before the latch, rad, not wrapped.
    tooth_angle: T,
    /// H, half the gap on the line of action, m.
    half_gap: T,
}

fn geometry<T: Scalar>(el: &Element, inputs: &Inputs<T>) -> Result<Placed<T>, ElementError> {
    let k = &el.constants;
    let [g1, g2] = &inputs.gears;
    let a = [g1.r.column(2).into_owned(), g2.r.column(2).into_owned()];
    let aa = a[0].dot(&a[1]);
    check::tilt(Body::Gear2, Body::Gear1, aa.re(), TILT_LIMIT)?;
    let rel = g2.p - g1.p;
    let k1 = a[0] * T::from(k.z_ref);
    let per_aa = aa.recip();
    let lambda = (k1 - rel).dot(&a[0]) * per_aa;
    let u = rel + a[1] * lambda - k1;
    let c = u.dot(&u).sqrt();
    let w = k.pitch_fraction;
    if check::center_distance(k, c.re())? == Distance::OutOfReach {
        return Ok(Placed::Far(k1 + u * T::from(w), c));
    }
    let per_c = c.recip();
    let xh = u * per_c;
    let yh = a[0].cross(&xh);

    let side = w.signum();
    let radial1 = xh * T::from(side);
    let rho1 = c * w.abs();
    let along = u.dot(&a[1]) * (1.0 - w);
    let zeta2 = lambda - along;
    let arm2 = a[1] * along - u * T::from(1.0 - w);
    let rho2 = arm2.dot(&arm2).sqrt();
    let per_rho = [rho1.recip(), rho2.recip()];
    let radial = [radial1, arm2 * per_rho[1]];

    // Tangent of the pressure angle at X on either gear. Tilt shortens rho_2 by its square; at
    // C = abs(rb1 + e rb2) that can cross the base circle.
    let tangent = [
        tangent(rho1 * (1.0 / k.rb[0])),
        tangent(rho2 * (1.0 / k.rb[1])),
    ];
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

    let hands = [k.hand, -k.e * k.hand];
    let around = [a[0].cross(&radial[0]), a[1].cross(&radial[1])];
    let cosine = [per_rho[0] * k.rb[0], per_rho[1] * k.rb[1]];
    let even = [
        radial[0] * (tangent[0] * cosine[0] * k.kappa[0]),
        radial[1] * (tangent[1] * cosine[1] * k.kappa[1]),
    ];
    let odd = [
        around[0] * cosine[0] - a[0] * T::from(hands[0] * k.tan_beta_b),
        around[1] * cosine[1] - a[1] * T::from(hands[1] * k.tan_beta_b),
    ];
    let turn = around[0] * per_rho[0];
    // sum of sigma_i/s [theta_i - h_i zeta_i tan(beta_b)/rb_i] in units of 2 pi per pitch; h2 = -e h.
    let helix = (zeta2 - k.z_ref) * (k.hand * k.tan_beta_b * k.z[0] / k.rb[0]);
    let tooth_angle = -(theta1 * k.z[0] + theta2 * (k.e * k.z[1])) - helix + k.tooth_zero;
    Ok(Placed::Near(Geometry {
        a,
        per_aa,
        k1,
        lambda,
        u,
        c,
        per_c,
        xh,
        yh,
        even,
        odd,
        turn,
        theta1,
        tooth_angle,
        half_gap,
    }))
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

/// Tooth angle, half gap in radians of it, and mesh positions without a latch.
pub(crate) fn phase(el: &Element, inputs: &Inputs) -> Result<super::latch::Phase, ElementError> {
    let k = &el.constants;
    let Placed::Near(g) = geometry(el, inputs)? else {
        return Err(ElementError::OutOfReach);
    };
    Ok(super::latch::Phase {
        tooth_angle: g.tooth_angle,
        half_gap: g.half_gap * k.z[0] / k.rb[0],
        mesh_position: mesh_positions(el, g.theta1),
    })
}

/// Positions on the mesh cycle of both flanks before the latch, (13).
fn mesh_positions<T: Scalar>(el: &Element, theta1: T) -> [T; 2] {
    let k = &el.constants;
    // theta1 here is the angle of the pitch point in the body: gamma (+ pi) - theta of the gear.
    let behind = if k.sc < 0.0 {
        std::f64::consts::PI
    } else {
        0.0
    };
    let angle = (theta1 - behind) / k.pitch_angle;
    [-angle + k.mesh_zero[0], angle + k.mesh_zero[1]]
}

/// Loads and diagnostics at `inputs`.
pub(crate) fn evaluate<T: Scalar>(
    el: &Element,
    latch: &Latch,
    inputs: &Inputs<T>,
) -> Result<Outputs<T>, ElementError> {
    let k = &el.constants;
    let [g1, g2] = &inputs.gears;
    let g = match geometry(el, inputs)? {
        Placed::Near(g) => g,
        Placed::Far(point, c) => {
            return Ok(Outputs::out_of_reach(g1.p + point, c, T::from(k.z_ref)));
        }
    };
    let zero = T::from(0.0);
    let w = k.pitch_fraction;
    let x = wrap(g.tooth_angle + latch.tooth_angle) * (k.rb[0] / k.z[0]);
    let cos_phi = g.per_c * k.base_sum;
    let sin_phi = (-cos_phi * cos_phi + 1.0).sqrt();

    // Velocities: D of c2's material against c1's, and of X against either gear's material.
    let d = g2.v + g2.w.cross(&(g.a[1] * g.lambda)) - g1.v - g1.w.cross(&g.k1);
    let tilting = g.a[0].cross(&g.u);
    let lambda_rate = -(d.dot(&g.a[0]) + g1.w.dot(&tilting)) * g.per_aa;
    let slip = g.a[1] * lambda_rate;
    let u_rate = d + slip;
    let y1 = (u_rate - g1.w.cross(&g.u)) * T::from(w);
    let y2 = slip - (u_rate - g2.w.cross(&g.u)) * T::from(1.0 - w);
    let even_rate = g.even[0].dot(&y1) + g.even[1].dot(&y2);
    let odd_rate = g.odd[0].dot(&y1) + g.odd[1].dot(&y2) * k.e;
    let c_rate = g.xh.dot(&u_rate);

    // Misalignment of flank s: M = -(e sin(phi) x + s sc cos(phi) y) . a2 and its rate.
    let tilt_x = g.xh.dot(&g.a[1]);
    let tilt_y = g.yh.dot(&g.a[1]);
    let misalignment_even = -sin_phi * tilt_x * k.e;
    let misalignment_odd = -cos_phi * tilt_y * k.sc;
    let u_axial = g.u.dot(&g.a[1]);
    let u_cross = tilting.dot(&g.a[1]);
    let alpha = sin_phi * g.per_c;
    let beta = cos_phi * g.per_c;
    let alpha_slope = (sin_phi.recip() - sin_phi * 2.0) * (g.per_c * g.per_c);
    let beta_slope = -beta * g.per_c * 2.0;
    // Gradients of M by u (even and odd in s) at fixed axes; by a1: odd; by a2: both.
    let even_u = (g.a[1] * alpha + g.xh * (u_axial * alpha_slope)) * T::from(-k.e);
    let odd_u = (g.a[1].cross(&g.a[0]) * beta + g.xh * (u_cross * beta_slope)) * T::from(-k.sc);
    let odd_a1 = g.u.cross(&g.a[1]) * (beta * -k.sc);
    let even_a2 = g.u * (alpha * -k.e);
    let odd_a2 = tilting * (beta * -k.sc);
    let a_rate = [g1.w.cross(&g.a[0]), g2.w.cross(&g.a[1])];
    let misalignment_even_rate = even_u.dot(&u_rate) + even_a2.dot(&a_rate[1]);
    let misalignment_odd_rate =
        odd_u.dot(&u_rate) + odd_a1.dot(&a_rate[0]) + odd_a2.dot(&a_rate[1]);

    let positions = mesh_positions(el, g.theta1);
    let mesh = engagement(k, g.c, g.lambda);
    let mut loads = [FlankLoad::none(zero); 2];
    let mut rates = [zero; 2];
    let mut out_of_range = mesh.leaving;
    for (i, flank) in FLANKS.iter().enumerate() {
        let s = flank.sign();
        loads[i].delta = x * s - g.half_gap;
        rates[i] = -(even_rate + odd_rate * s);
        loads[i].misalignment = misalignment_even + misalignment_odd * s;
        loads[i].mesh_position = fraction(positions[i] + s * latch.mesh_position);
        if let Some(law) = &el.laws[i] {
            let response = law.respond([
                loads[i].delta,
                g.c - k.center_distance,
                loads[i].misalignment,
                loads[i].mesh_position,
            ]);
            let tilt_rate = misalignment_even_rate + misalignment_odd_rate * s;
            out_of_range |= response.out_of_range;
            loads[i].carry(&response, &mesh, rates[i], tilt_rate, &el.damping);
        }
    }

    // Weights of the co-vectors: sums over the flanks, even and odd in s.
    let both = |f: fn(&FlankLoad<T>) -> T| {
        let [drive, coast] = [f(&loads[0]), f(&loads[1])];
        (drive + coast, drive - coast)
    };
    let (p, q) = both(|l| l.force);
    let (m_even, m_odd) = both(|l| l.tilt_moment);
    let (by_c, _) = both(|l| l.by_center_distance);
    let (_, by_position) = both(|l| l.by_mesh_position);
    let (by_axial, _) = both(|l| l.by_axial_position);

    let n1 = g.even[0] * p + g.odd[0] * q + g.turn * (by_position / k.pitch_angle);
    let n2 = g.even[1] * p + g.odd[1] * (q * k.e);
    let by_u = even_u * m_even + odd_u * m_odd + g.xh * by_c;
    let by_lambda = by_u.dot(&g.a[1]) - (n1 + n2).dot(&g.a[1]) * w + by_axial;
    let by_d = by_u - n1 * T::from(w) + n2 * T::from(1.0 - w) - g.a[0] * (by_lambda * g.per_aa);
    let by_w1 = g.u.cross(&n1) * T::from(w) - tilting * (by_lambda * g.per_aa)
        + g.a[0].cross(&(odd_a1 * m_odd));
    let by_w2 =
        g.u.cross(&n2) * T::from(w - 1.0) + g.a[1].cross(&(even_a2 * m_even + odd_a2 * m_odd));
    let force = [by_d, -by_d];
    let moment = [
        g.k1.cross(&force[0]) - by_w1,
        (g.a[1] * g.lambda).cross(&force[1]) - by_w2,
    ];

    let (index, flank) = carrying_flank(&loads, el.reference_flank);
    let shown = &loads[index];
    let axial = shown.axial_offset();
    let reference = el.reference_flank;
    let sign = FLANKS[reference].sign();
    let per_base_sum = 1.0 / k.base_sum;
    let per_loa = g.c * per_base_sum;
    let (stiffness, _) = both(|l| l.stiffness);
    Ok(Outputs {
        force,
        moment,
        contact_point: g1.p + g.k1 + g.u * T::from(w) + g.a[0] * axial,
        transmission_error: loads[reference].delta * per_loa * sign,
        transmission_error_rate: (rates[reference] * per_loa
            + loads[reference].delta * (c_rate * per_base_sum))
            * sign,
        mesh_position: shown.mesh_position,
        center_distance: g.c,
        misalignment: shown.misalignment,
        tangential_force: p * cos_phi,
        normal_force: p / k.cos_beta_b,
        stiffness: stiffness * cos_phi * cos_phi,
        contact_z: axial + k.z_ref,
        energy: loads[0].energy + loads[1].energy,
        flank,
        out_of_range,
    })
}
