//! The paper's formulation, equations (1)-(26), with its signs and references put right.
//!
//! Everything is relative to the carrier: x along O1 -> O2 in its transverse plane, z its axis,
//! y = z × x. The elongation holds rotations and the centre distance vector's direction alone; the
//! radial and axial displacement are left out, as in the paper, though the force has both components.
//! So this law does work on closed loops; [`super::conjugate`] does not.

use super::Element;
use super::check::{self, Distance};
use super::engagement::engagement;
use super::error::{Body, ElementError};
use super::geometry::{Constants, FLANKS, TILT_LIMIT};
use super::latch::Phase;
use super::load::FlankLoad;
use super::load::carrying_flank;
use super::motion::{Inputs, Latch, Motion, Outputs};
use super::parameters::StiffnessModel;
use super::scalar::{Scalar, angles, fraction, wrap};
use nalgebra::{Matrix3, Vector3};

/// Motion of one gear relative to the carrier, in carrier axes.
struct Relative<T> {
    p: Vector3<T>,
    v: Vector3<T>,
    w: Vector3<T>,
    /// Axis of the gear.
    a: Vector3<T>,
    /// Sine and cosine, to one factor, of the rotation about the carrier's axis: the twist of the swing-twist
    /// decomposition, which a static tilt does not disturb.
    twist: [T; 2],
    /// Its rate.
    theta_rate: T,
}

fn relative<T: Scalar>(
    body: Body,
    gear: &Motion<T>,
    carrier: &Motion<T>,
) -> Result<Relative<T>, ElementError> {
    let arm = gear.p - carrier.p;
    let to_carrier: Matrix3<T> = carrier.r.transpose();
    let r = to_carrier * gear.r;
    let a = r.column(2).into_owned();
    check::tilt(body, Body::Carrier, a.z.re(), TILT_LIMIT)?;
    let w = to_carrier * (gear.w - carrier.w);
    Ok(Relative {
        p: to_carrier * arm,
        v: to_carrier * (gear.v - carrier.v - carrier.w.cross(&arm)),
        w,
        a,
        twist: [r[(1, 0)] - r[(0, 1)], r[(0, 0)] + r[(1, 1)]],
        // The twist rate lies along the half-way direction of both axes.
        theta_rate: (w.dot(&a) + w.z) / (a.z + 1.0),
    })
}

/// Where the gears stand.
enum Placed<T> {
    /// In mesh or near it.
    Near(Geometry<T>),
    /// Out of reach: pitch point at the nominal mid-face from O1, in W, and the centre distance.
    Far(Vector3<T>, T),
}

/// What the equations share.
struct Geometry<T> {
    gears: [Relative<T>; 2],
    c: T,
    xh: Vector3<T>,
    yh: Vector3<T>,
    tooth_angle: T,
    mesh_position: [T; 2],
}

fn geometry<T: Scalar>(el: &Element, inputs: &Inputs<T>) -> Result<Placed<T>, ElementError> {
    let k = &el.constants;
    let g1 = relative(Body::Gear1, &inputs.gears[0], &inputs.carrier)?;
    let g2 = relative(Body::Gear2, &inputs.gears[1], &inputs.carrier)?;
    let d = g2.p - g1.p;
    let c = (d.x * d.x + d.y * d.y).sqrt(); // (14)
    let zero = T::from(0.0);
    if check::center_distance(k, c.re())? == Distance::OutOfReach {
        let w = k.pitch_fraction;
        let point = Vector3::new(d.x * w, d.y * w, T::from(k.z_ref));
        return Ok(Placed::Far(inputs.carrier.r * point, c));
    }
    let one = T::from(1.0);
    let [theta1, theta2, gamma, _] = angles(
        [g1.twist[0], g2.twist[0], d.y, zero],
        [g1.twist[1], g2.twist[1], d.x, one],
    );
    let angle = (theta1 - gamma) / k.pitch_angle;
    Ok(Placed::Near(Geometry {
        c,
        xh: Vector3::new(d.x / c, d.y / c, zero),
        yh: Vector3::new(-d.y / c, d.x / c, zero),
        tooth_angle: (theta1 - gamma) * k.z[0]
            + (theta2 - gamma) * (k.e * k.z[1])
            + tooth_angle_zero(k),
        mesh_position: [angle + k.mesh_zero[0], -angle + k.mesh_zero[1]], // (13)
        gears: [g1, g2],
    }))
}

/// Tooth angle of the `absolute` reference at theta1 = theta2 = gamma, rad, mid-face, nominal faces.
fn tooth_angle_zero(k: &Constants) -> f64 {
    let w = k.pitch_fraction;
    let behind = |is: bool| if is { std::f64::consts::PI } else { 0.0 };
    k.tooth_zero - k.z[0] * behind(w < 0.0) - k.e * k.z[1] * behind(w < 1.0)
        + k.hand * k.face_offset * k.tan_beta_b * k.z[0] / k.rb[0]
}

/// Half the backlash as tooth angle, rad.
fn half_gap(k: &Constants) -> f64 {
    0.5 * k.backlash * k.tooth_sum / k.center_distance
}

/// Tooth angle, half gap and mesh positions without a latch.
pub(crate) fn phase(el: &Element, inputs: &Inputs) -> Result<Phase, ElementError> {
    let Placed::Near(g) = geometry(el, inputs)? else {
        return Err(ElementError::OutOfReach);
    };
    Ok(Phase {
        tooth_angle: g.tooth_angle,
        half_gap: half_gap(&el.constants),
        mesh_position: g.mesh_position,
    })
}

/// Loads and diagnostics at `inputs`.
pub(crate) fn evaluate<T: Scalar>(
    el: &Element,
    latch: &Latch,
    inputs: &Inputs<T>,
) -> Result<Outputs<T>, ElementError> {
    let k = &el.constants;
    let g = match geometry(el, inputs)? {
        Placed::Near(g) => g,
        Placed::Far(point, c) => {
            let point = inputs.gears[0].p + point;
            return Ok(Outputs::out_of_reach(point, c, T::from(k.z_ref)));
        }
    };
    let [g1, g2] = &g.gears;
    let zero = T::from(0.0);
    let radius = g.c / k.tooth_sum; // r_wi / z_i
    let cos_phi = g.c.recip() * k.base_sum; // (15)
    let sin_phi = (-cos_phi * cos_phi + 1.0).sqrt();
    let tooth_angle = wrap(g.tooth_angle + latch.tooth_angle);
    let gamma_rate = g.yh.dot(&(g2.v - g1.v)) / g.c;
    // (6), (7), measured from the line of centres.
    let tooth_rate =
        (g1.theta_rate - gamma_rate) * k.z[0] + (g2.theta_rate - gamma_rate) * (k.e * k.z[1]);
    let axial = g2.p.z - g1.p.z;
    let [b1, b2] = k.face_width;
    let low = if axial.re() > 0.0 { axial } else { zero };
    let high = if (axial + b2).re() < b1 {
        axial + b2
    } else {
        T::from(b1)
    };
    let middle = (low + high) * 0.5;
    let mesh = engagement(k, g.c, T::from(k.z_ref) - axial);

    let mut loads = [FlankLoad::none(zero); 2];
    let mut dte = [zero; 2];
    let mut dte_rate = [zero; 2];
    let mut out_of_range = mesh.leaving;
    let tilt = g1.a - g2.a;
    let tilt_rate = g1.w.cross(&g1.a) - g2.w.cross(&g2.a);
    // The paper's constant k is tangential at the actual operating pitch circle.
    let constant = el.parameters.stiffness_model == StiffnessModel::Constant;
    let scale = if constant {
        (cos_phi.recip() * k.cos_phi).powi(2)
    } else {
        T::from(1.0)
    };
    for (i, flank) in FLANKS.iter().enumerate() {
        let s = flank.sign();
        dte[i] = (tooth_angle * s - half_gap(k)) * radius; // (1)
        dte_rate[i] = tooth_rate * radius * s; // (5)
        let loa = g.xh * (sin_phi * k.e) + g.yh * (cos_phi * (s * k.sc)); // (17)
        let load = &mut loads[i];
        load.misalignment = loa.dot(&tilt); // (18)
        load.mesh_position = fraction(g.mesh_position[i] + s * latch.mesh_position);
        load.delta = dte[i] * cos_phi;
        let mut rate = dte_rate[i] * cos_phi;
        if el.parameters.misalignment_effect {
            load.delta += load.misalignment * middle; // (19)
            rate += loa.dot(&tilt_rate) * middle; // (20)
        }
        if let Some(law) = &el.laws[i] {
            let response = law.respond([
                load.delta * scale,
                g.c - k.center_distance,
                load.misalignment,
                load.mesh_position,
            ]);
            out_of_range |= response.out_of_range;
            // (8): the constant c is tangential; F_bt cos(phi) = F_tt, so c / cos^2(phi) acts here.
            load.carry_constant(
                &response,
                &mesh,
                rate / (cos_phi * cos_phi),
                el.parameters.damping,
            );
            load.stiffness *= scale;
        }
    }

    let (index, flank) = carrying_flank(&loads, el.reference_flank);
    let shown = &loads[index];
    let w = k.pitch_fraction;
    let tan_phi = sin_phi / cos_phi;
    let tan_beta_w = g.c * (k.z[0] / k.tooth_sum * k.tan_beta_per_radius);
    let to_world = &inputs.carrier.r;
    let origin = [g1.p, g2.p];
    let pitch_point = g1.p + (g.xh * g.c) * T::from(w); // (10)-(11)
    let z_hat = Vector3::new(zero, zero, T::from(1.0));
    let mut force2 = Vector3::zeros();
    let mut moments = [Vector3::zeros(); 2];
    for (load, flank) in loads.iter().zip(FLANKS) {
        let s = flank.sign();
        let direction =
            g.xh * (tan_phi * k.e) + g.yh * T::from(s * k.sc) - z_hat * (tan_beta_w * (s * k.hand)); // (9)
        let f = direction * (load.force * cos_phi);
        let point = pitch_point + z_hat * (middle + load.axial_offset()); // (12), (26)
        force2 += f;
        moments[0] -= (point - origin[0]).cross(&f);
        moments[1] += (point - origin[1]).cross(&f);
    }
    let reference = el.reference_flank;
    let sign = FLANKS[reference].sign();
    let total = loads[0].force + loads[1].force;
    let point = pitch_point + z_hat * (middle + shown.axial_offset());
    let force2 = to_world * force2;
    Ok(Outputs {
        force: [-force2, force2],
        moment: moments.map(|m| to_world * m),
        contact_point: inputs.gears[0].p + to_world * (point - g1.p),
        transmission_error: dte[reference] * sign,
        transmission_error_rate: dte_rate[reference] * sign,
        mesh_position: shown.mesh_position,
        center_distance: g.c,
        misalignment: shown.misalignment,
        tangential_force: total * cos_phi,
        normal_force: total / k.cos_beta_b,
        stiffness: (loads[0].stiffness + loads[1].stiffness) * cos_phi * cos_phi,
        contact_z: middle + shown.axial_offset(),
        energy: loads[0].energy + loads[1].energy,
        flank,
        out_of_range,
    })
}
