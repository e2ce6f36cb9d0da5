//! A gear of the file on its own: teeth as its fields have them, rim, web and hub, and what a ring rests on.

use super::checks::{ABOVE_0, check, in_gear};
use super::error::{Refusal, ensure, refusal};
use super::file::{GearFile, HeldEnds, MM, Meshing, PairFile, ShaftFile};
use gearmesh::gear::{Body, Gear, GearKind, Stub};
use gearmesh::words::rounded;

/// Gear `i` with neither backlash nor a body of its own.
pub(super) fn gear(file: &PairFile, i: usize) -> Gear {
    let g = file.gear(i);
    let helix_angle = file.helix_angle_deg.unwrap_or(0.0);
    let hand1 = if helix_angle < 0.0 { -1.0 } else { 1.0 };
    // Gear 2 of an external pair has the other hand.
    let is_other = i == 1 && file.meshing == Meshing::External;
    let offset = file.face_offset_mm.filter(|_| i == 1);
    let kind = match file.ring() == Some(i) {
        true => GearKind::Ring,
        false => GearKind::External,
    };
    let mut gear = Gear {
        kind,
        teeth: g.teeth,
        hand: if is_other { -hand1 } else { hand1 },
        normal_module: file.normal_module_mm * MM,
        normal_pressure_angle: file.normal_pressure_angle_deg.to_radians(),
        helix_angle: helix_angle.abs().to_radians(),
        profile_shift: g.profile_shift.unwrap_or(0.0),
        face_width: g.face_width_mm * MM,
        face_offset: offset.unwrap_or(0.0) * MM,
        tip_radius: 0.0,
        dedendum_coefficient: g.dedendum_coefficient.unwrap_or(1.25),
        tool_tip_radius_coefficient: g.tool_tip_radius_coefficient,
        held_radius: 0.0,
        body: None,
        foundation: None,
        tooth_thinning: 0.0,
        tip_chamfer: 0.0,
        youngs_modulus: g.youngs_modulus_gpa * 1e9,
        poisson_ratio: g.poisson_ratio,
    };
    let radius = |diameter_mm: f64| 0.5 * diameter_mm * MM;
    let addendum = gear.kappa() * g.addendum_coefficient.unwrap_or(1.0);
    let tip = gear.reference_radius() + gear.normal_module * (gear.profile_shift + addendum);
    gear.tip_radius = g.tip_diameter_mm.map_or(tip, radius);
    if let Some(mm) = g.tip_form_diameter_mm {
        gear.tip_chamfer = gear.kappa() * (gear.tip_radius - radius(mm));
    }
    let root = gear.root_radius();
    let (held, usual) = match kind {
        GearKind::External => (g.bore_diameter_mm, 0.5 * root),
        GearKind::Ring => (g.rim_diameter_mm, root + 3.5 * gear.normal_module),
    };
    gear.held_radius = held.map_or(usual, radius);
    gear
}

/// Gives `gear` its body and foundation.
pub(super) fn add_body(g: &GearFile, gear: &mut Gear, i: usize) -> Result<(), Refusal> {
    let parts = [
        ("rim_thickness_mm", g.rim_thickness_mm),
        ("web_thickness_mm", g.web_thickness_mm),
        ("web_offset_mm", g.web_offset_mm),
        ("hub_diameter_mm", g.hub_diameter_mm),
        ("hub_width_mm", g.hub_width_mm),
        ("hub_offset_mm", g.hub_offset_mm),
    ];
    let first = (parts.into_iter()).find_map(|(name, value)| Some((in_gear(i, name), value?)));
    let name = "rim_foundation_n_per_mm3";
    if gear.kind == GearKind::Ring {
        ensure!(g.shaft.is_none(), in_gear(i, "shaft") => "a shaft"; "the gear is a ring"; "leave it out");
        if let Some((path, value)) = first {
            return Err(refusal!(path => value;
                "the gear is a ring, which has neither web nor hub";
                "give its outside by `rim_diameter_mm`, and what that rests on by `rim_foundation_n_per_mm3`"));
        }
        // From rubber to steel a hundredth of a millimetre thick.
        check(&in_gear(i, name), g.rim_foundation_n_per_mm3, [1e-3, 1e8])?;
        // N/mm³ = 1e9 N/m³.
        gear.foundation = g.rim_foundation_n_per_mm3.map(|stiffness| 1e9 * stiffness);
        return Ok(());
    }
    if let Some(value) = g.rim_foundation_n_per_mm3 {
        return Err(refusal!(in_gear(i, name) => value;
            "the gear is no ring and is held at its bore"; "leave it out"));
    }
    gear.body = match (first, &g.shaft, g.rim_thickness_mm, g.web_thickness_mm) {
        (None, None, ..) => None,
        (None, Some(given), ..) => Some(shaft(g, given, gear, i)?),
        (Some((path, value)), Some(_), ..) => {
            return Err(refusal!(path => value;
                "`shaft` is given, too, and its teeth are cut from it"; "give one of them"));
        }
        (_, None, Some(rim), Some(web)) => Some(body(g, gear, i, [rim, web])?),
        (Some((path, value)), ..) => {
            return Err(refusal!(path => value;
                "`rim_thickness_mm` and `web_thickness_mm` are not both given";
                "give both, or none of these fields for a full disc"));
        }
    };
    Ok(())
}

/// Least rim below the root circle, and between it and a shaft, normal modules: less is no ring that teeth stand on.
const LEAST_RIM: f64 = 0.5;
/// Least radial length of a web and wall of a hub, and least thickness of a web, normal modules.
const LEAST_PART: f64 = 0.1;
/// Longest hub, normal modules: that of the widest face.
const LONGEST_HUB: f64 = 100.0;

/// Rim, web and hub of `gear`; `rim` and `web` are their thicknesses, mm.
fn body(g: &GearFile, gear: &Gear, i: usize, [rim, web]: [f64; 2]) -> Result<Body, Refusal> {
    let (module, width) = (gear.normal_module / MM, gear.face_width / MM);
    let (root, bore) = (2.0 * gear.root_radius() / MM, 2.0 * gear.held_radius / MM);
    let [least_rim, least, longest] =
        [LEAST_RIM, LEAST_PART, LONGEST_HUB].map(|part| part * module);
    let check = |name: &str, mm: f64, range| check(&in_gear(i, name), mm, range);
    check("rim_thickness_mm", rim, [least_rim, 0.5 * root])?;
    check("web_thickness_mm", web, [least, width])?;
    let offset = g.web_offset_mm.unwrap_or(0.0);
    let (face, middle) = (Extent([0.0, width]), 0.5 * width);
    let web = Extent::about(middle + offset, web);
    ensure!(face.encloses(web), in_gear(i, "web_offset_mm") => offset;
        "puts the web at {web}, beyond the face, {face}"; "give the middle of the web less mid-face");
    let web = Extent([web.0[0].max(0.0), web.0[1].min(width)]);
    let mut hub = web;
    let inside = root - 2.0 * rim;
    let (mut innermost, mut name, mut value, mut part) =
        (bore, "rim_thickness_mm", rim, "the bore");
    let hub_width = g.hub_width_mm.map(|mm| ("hub_width_mm", mm));
    let hub_offset = g.hub_offset_mm.map(|mm| ("hub_offset_mm", mm));
    if let Some(diameter) = g.hub_diameter_mm {
        check("hub_diameter_mm", diameter, [bore + 2.0 * least, root])?;
        let length = g.hub_width_mm.unwrap_or(width);
        check("hub_width_mm", length, [ABOVE_0, longest])?;
        hub = Extent::about(middle + g.hub_offset_mm.unwrap_or(0.0), length);
        let (field, offset) = hub_offset.unwrap_or(("hub_width_mm", length));
        ensure!(hub.encloses(web), in_gear(i, field) => offset;
            "the web, {web}, ends beyond the hub, {hub}"; "choose a hub that encloses the web");
        hub = Extent([hub.0[0].min(web.0[0]), hub.0[1].max(web.0[1])]);
        (innermost, name, value, part) = (diameter, "hub_diameter_mm", diameter, "the hub");
    } else if let Some((name, value)) = hub_width.or(hub_offset) {
        return Err(refusal!(in_gear(i, name) => value;
            "`hub_diameter_mm` is not given"; "give it, or leave this out for a web that reaches down to the bore"));
    }
    ensure!(inside >= innermost + 2.0 * least, in_gear(i, name) => value;
        "the inside of the rim has the diameter {inside:.3} mm and leaves no web outside of {part} of {innermost:.3} mm";
        "choose a thinner rim or a smaller hub or bore; for a full disc leave rim, web and hub out");
    Ok(Body {
        rim_radius: 0.5 * inside * MM,
        web: web.0.map(|z| z * MM),
        hub_radius: g
            .hub_diameter_mm
            .map_or(gear.held_radius, |mm| 0.5 * mm * MM),
        hub: hub.0.map(|z| z * MM),
        held_ends: [false; 2],
    })
}

/// Bore of a shaft that is called solid, over the diameter of its thinner piece: it makes the shaft 1e-4 softer.
const BORE_OF_SOLID: f64 = 0.1;

/// The shaft that the teeth of `gear` are cut from; sets its bore.
fn shaft(g: &GearFile, shaft: &ShaftFile, gear: &mut Gear, i: usize) -> Result<Body, Refusal> {
    let module = gear.normal_module / MM;
    let [wall, longest] = [LEAST_PART, LONGEST_HUB].map(|part| part * module);
    let thickest = 2.0 * gear.root_radius() / MM - 2.0 * LEAST_RIM * module;
    let thinnest = g.bore_diameter_mm.unwrap_or(0.0) + 2.0 * wall;
    let pieces = [("lower", shaft.lower), ("upper", shaft.upper)];
    for (name, piece) in pieces {
        let Some(piece) = piece else { continue };
        let path = in_gear(i, &format!("shaft.{name}"));
        check(
            &format!("{path}.diameter_mm"),
            piece.diameter_mm,
            [thinnest, thickest],
        )?;
        check(
            &format!("{path}.length_mm"),
            piece.length_mm,
            [wall, longest],
        )?;
    }
    let held = match (shaft.held, shaft.lower, shaft.upper) {
        (Some(held), ..) => [held != HeldEnds::Upper, held != HeldEnds::Lower],
        (None, Some(_), None) => [true, false],
        (None, None, Some(_)) => [false, true],
        _ => {
            return Err(refusal!(in_gear(i, "shaft") => "no `held`";
                "it has two pieces, or none, and no `held`";
                "give the end that passes the torque on: `lower` (z < 0), `upper` or `both`"));
        }
    };
    for ((name, piece), held) in pieces.into_iter().zip(held) {
        ensure!(piece.is_some() || !held, in_gear(i, "shaft.held") => name;
            "there is no `{name}` piece to hold"; "give its diameter_mm and length_mm, or hold the other end");
    }
    let stubs = [0, 1].map(|end| Stub {
        radius: 0.5 * pieces[end].1.map_or(0.0, |piece| piece.diameter_mm) * MM,
        length: pieces[end].1.map_or(0.0, |piece| piece.length_mm) * MM,
        held: held[end],
    });
    let body = Body::shaft(stubs, gear.face_width);
    if g.bore_diameter_mm.is_none() {
        gear.held_radius = BORE_OF_SOLID * body.hub_radius;
    }
    Ok(body)
}

/// Both ends of a part along the axis, mm.
#[derive(Clone, Copy)]
struct Extent([f64; 2]);

impl Extent {
    fn about(middle: f64, width: f64) -> Extent {
        Extent([middle - 0.5 * width, middle + 0.5 * width])
    }

    /// Half a micrometre is the rounding of a drawing.
    fn encloses(self, inner: Extent) -> bool {
        self.0[0] - 5e-4 <= inner.0[0] && inner.0[1] <= self.0[1] + 5e-4
    }
}

impl std::fmt::Display for Extent {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(f, "z {} to {} mm", rounded(self.0[0]), rounded(self.0[1]))
    }
}
