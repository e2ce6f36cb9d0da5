//! The body of a gear between its teeth and where it is held: its rings, the shaft it may be cut from, and estimates of how far it deflects.

use std::f64::consts::PI;

use gearmesh::gear::{Body, Gear, GearKind};

/// A ring of rectangular section about the axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Annulus {
    /// Inner and outer radius, m.
    pub radii: [f64; 2],
    /// z of both ends, m from the gear's z = 0 face.
    pub z: [f64; 2],
}

/// A piece of shaft on one side of the face.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stub {
    /// m, below the root radius of the teeth.
    pub radius: f64,
    /// From the face to its end, m; 0: there is none.
    pub length: f64,
    /// Whether the end is held: there the shaft of the multibody model takes over.
    pub held: bool,
}

/// The body as rings, from the axis outwards, that end at the radius `outer` (m) within the teeth; for a ring
/// gear the one from there to the held surface.
pub fn annuli(gear: &Gear, outer: f64) -> Vec<Annulus> {
    let face = [0.0, gear.face_width];
    let whole = |radii| Annulus { radii, z: face };
    match (gear.kind, gear.body) {
        (GearKind::Ring, _) => vec![whole([outer, gear.held_radius])],
        (_, None) => vec![whole([gear.held_radius, outer])],
        (_, Some(body)) => [
            ([gear.held_radius, body.hub_radius], body.hub),
            ([body.hub_radius, body.rim_radius], body.web),
            ([body.rim_radius, outer], face),
        ]
        .map(|(radii, z)| Annulus { radii, z })
        .into_iter()
        .filter(|ring| ring.radii[1] > ring.radii[0])
        .collect(),
    }
}

/// The gear turned end for end, where its body is another one then, by a billionth of a metre or more.
pub fn turned(gear: &Gear) -> Option<Gear> {
    let body = gear.body?;
    let turned = mirrored(&body, gear.face_width);
    let ends = body.web.iter().chain(&body.hub);
    let mut pairs = ends.zip(turned.web.iter().chain(&turned.hub));
    let is_symmetric =
        pairs.all(|(a, b)| (a - b).abs() < 1e-9) && body.held_ends == turned.held_ends;
    (!is_symmetric).then(|| Gear {
        body: Some(turned),
        ..gear.clone()
    })
}

/// Displacement of the teeth along the line of action per force there that the body causes between them and where it is
/// held, m/N: an estimate by its twist, the tilt of a web, the bending of a shaft and the foundation.
pub fn compliance(gear: &Gear) -> f64 {
    gear.base_radius().powi(2) * twist(gear) + tilt_and_foundation(gear)
}

/// Angle by which the body twists under a torque on the teeth, rad/(N m): rings in shear; a shaft by Saint-Venant's torsion
/// from mid-face to the ends that are held, and in shear outside of it.
pub fn twist(gear: &Gear) -> f64 {
    let shear_modulus = 0.5 * gear.youngs_modulus / (1.0 + gear.poisson_ratio);
    let mut annuli = annuli(gear, gear.root_radius());
    let mut torsion = 0.0;
    if let Some(body) = gear.body.filter(Body::is_shaft) {
        let [teeth, thick, thin] = [gear.root_radius(), body.rim_radius, body.hub_radius]
            .map(|radius| 0.5 * PI * (radius.powi(4) - gear.held_radius.powi(4)));
        // Of the teeth's part half a face; beyond, the radius of what reaches out there.
        let [lower, upper] = [0, 1].map(|end| {
            let [to_thick, to_thin] = [body.web[end], body.hub[end]]
                .map(|z| if end == 0 { -z } else { z - gear.face_width });
            let compliance =
                0.5 * gear.face_width / teeth + to_thick / thick + (to_thin - to_thick) / thin;
            f64::from(body.held_ends[end]) * shear_modulus / compliance
        });
        torsion = (lower + upper).recip();
        annuli.retain(|ring| ring.radii[0] >= body.rim_radius);
    }
    let shear = annuli.iter().map(|ring| {
        let ([inner, outer], [low, high]) = (ring.radii, ring.z);
        (inner.powi(-2) - outer.powi(-2)) / (4.0 * PI * shear_modulus * (high - low))
    });
    torsion + shear.sum::<f64>()
}

/// Displacement of the teeth along the line of action per force there that a web and a foundation add to the
/// twist, m/N: the tilt of the web under the axial force (a plate between two stiff discs: Timoshenko,
/// Woinowsky-Krieger, Theory of Plates and Shells, section 63), the bending of a shaft from its held ends to mid-face, and
/// the foundation. An estimate of its size.
pub fn tilt_and_foundation(gear: &Gear) -> f64 {
    let web = gear.body.filter(|body| !body.is_shaft());
    let tilt = web.map_or(0.0, |body| {
        let thickness = body.web[1] - body.web[0];
        let plate =
            gear.youngs_modulus * thickness.powi(3) / (12.0 * (1.0 - gear.poisson_ratio.powi(2)));
        let [a, b] = [body.hub_radius, body.rim_radius].map(|r| r * r);
        let lever = gear.reference_radius() * gear.base_helix_angle().tan();
        lever.powi(2) * (0.5 * (b / a).ln() - (b - a) / (b + a)) / (4.0 * PI * plate)
    });
    let bending = gear.body.filter(Body::is_shaft).map_or(0.0, |body| {
        let area_moment = 0.25 * PI * (body.hub_radius.powi(4) - gear.held_radius.powi(4));
        let middle = 0.5 * gear.face_width;
        let arms = [middle - body.hub[0], body.hub[1] - middle];
        // A cantilever; between two held ends the middle does not turn.
        let is_between = body.held_ends == [true; 2];
        let factor = if is_between { 12.0 } else { 3.0 };
        let held = (arms.iter().zip(body.held_ends)).filter(|(_, held)| *held);
        let stiffness =
            held.map(|(arm, _)| factor * gear.youngs_modulus * area_moment / arm.powi(3));
        stiffness.sum::<f64>().recip()
    });
    let foundation = gear.foundation.map_or(0.0, |stiffness| {
        let area = 2.0 * PI * gear.held_radius * gear.face_width;
        // Turned as a whole, and moved along the line of action.
        ((gear.base_radius() / gear.held_radius).powi(2) + 1.0) / (stiffness * area)
    });
    tilt + bending + foundation
}

/// The shaft that teeth of the width `face_width` (m) are cut from, with its pieces at low and at high z: solid
/// below the root circle, held at the ends that say so, its bore free.
pub fn shaft(stubs: [Stub; 2], face_width: f64) -> Body {
    let [low, high] = stubs;
    let whole = [-low.length, face_width + high.length];
    let (thin, thick) = match stubs.map(|stub| stub.length > 0.0) {
        [true, false] => (low.radius, low.radius),
        [false, true] => (high.radius, high.radius),
        _ => (low.radius.min(high.radius), low.radius.max(high.radius)),
    };
    Body {
        rim_radius: thick,
        web: match low.radius > high.radius {
            _ if thick == thin => whole,
            true => [whole[0], face_width],
            false => [0.0, whole[1]],
        },
        hub_radius: thin,
        hub: whole,
        held_ends: stubs.map(|stub| stub.held),
    }
}

/// The body seen with the face of width `face_width` (m) turned end for end.
fn mirrored(body: &Body, face_width: f64) -> Body {
    let [web, hub] = [body.web, body.hub].map(|[low, high]| [face_width - high, face_width - low]);
    let [low, high] = body.held_ends;
    Body {
        web,
        hub,
        held_ends: [high, low],
        ..*body
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples;
    use approx::assert_abs_diff_eq;

    fn webbed() -> Gear {
        Gear {
            body: Some(Body {
                rim_radius: 28e-3,
                web: [5e-3, 12e-3],
                hub_radius: 20e-3,
                hub: [-3e-3, 25e-3],
                held_ends: [false; 2],
            }),
            ..samples::gear(GearKind::External, 20, 1.0, 0.0, 0.0)
        }
    }

    #[test]
    fn mirroring_twice_gives_the_body_back_and_rings_join_from_the_held_surface_to_the_teeth() {
        let (gear, body) = (webbed(), webbed().body.unwrap());
        let turned = super::turned(&gear).unwrap().body.unwrap();
        assert_eq!(turned.hub, [0.0, 28e-3]);
        let back = mirrored(&turned, gear.face_width);
        assert_abs_diff_eq!(body.web[..], back.web[..], epsilon = 1e-15);
        assert_abs_diff_eq!(body.hub[..], back.hub[..], epsilon = 1e-15);
        let rings = annuli(&gear, 34e-3);
        assert_eq!(rings.len(), 3);
        assert_eq!(rings[0].radii[0], gear.held_radius);
        assert!(rings.windows(2).all(|w| w[0].radii[1] == w[1].radii[0]));
        assert_eq!(rings[2].radii[1], 34e-3);
        // A web that reaches the bore has no hub.
        let mut plain = gear.clone();
        plain.body.as_mut().unwrap().hub_radius = gear.held_radius;
        assert_eq!(annuli(&plain, 34e-3).len(), 2);
    }
}
