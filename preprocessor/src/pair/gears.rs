//! A gear of the file on its own: teeth as its fields have them, rim, web and hub, and what a ring rests on.

use super::checks::{
    ABOVE_0, Refusal, Refusals, about, check, check_with_usual, ensure, in_gear, limits, meant,
    refusal,
};
use super::file::{GearFile, HeldEnds, MM, Meshing, PairFile, ShaftFile, radius_of};
use super::temperature;
use crate::gear::body::{self, Stub};
use crate::gear::{ProfileError, ToothProfile};
use gearmesh::gear::{Body, Gear, GearKind, PairGeometry, inverse_involute};
use gearmesh::words::rounded;

/// Gear `i` with a helix angle of `helix` degrees on gear 1 and no profile shift, without circles at tip and bore
/// ([`set_circles`]), backlash and a body of its own.
pub(super) fn unshifted(file: &PairFile, i: usize, helix: f64) -> Gear {
    let g = file.gear(i);
    let hand1 = if helix < 0.0 { -1.0 } else { 1.0 };
    // Gear 2 of an external pair has the other hand.
    let is_other = i == 1 && file.meshing == Meshing::External;
    let offset = file.face_offset_mm.filter(|_| i == 1);
    Gear {
        kind: match file.ring() == Some(i) {
            true => GearKind::Ring,
            false => GearKind::External,
        },
        teeth: g.number_of_teeth(),
        hand: if is_other { -hand1 } else { hand1 },
        normal_module: file.normal_module_mm * MM,
        normal_pressure_angle: file.normal_pressure_angle_deg.to_radians(),
        helix_angle: helix.abs().to_radians(),
        profile_shift: 0.0,
        face_width: g.face_width_mm * MM,
        face_offset: offset.unwrap_or(0.0) * MM,
        tip_radius: f64::NAN,
        dedendum_coefficient: g.dedendum_coefficient.unwrap_or(1.25),
        tool_tip_radius_coefficient: g.tool_tip_radius_coefficient.unwrap_or(USUAL_ROUND),
        held_radius: f64::NAN,
        body: None,
        foundation: None,
        tooth_thinning: 0.0,
        tip_chamfer: 0.0,
        root_form_radius: None,
        youngs_modulus: temperature::youngs_modulus(file, g) * 1e9,
        poisson_ratio: g.poisson_ratio,
    }
}

/// Sets tip circle, tip form circle, and bore or outer rim.
pub(super) fn set_circles(g: &GearFile, gear: &mut Gear) {
    let addendum = gear.kappa() * g.addendum_coefficient.unwrap_or(1.0);
    let tip = gear.reference_radius() + gear.normal_module * (gear.profile_shift + addendum);
    gear.tip_radius = g.tip_diameter_mm.map_or(tip, radius_of);
    if let Some(mm) = g.tip_form_diameter_mm {
        gear.tip_chamfer = gear.kappa() * (gear.tip_radius - radius_of(mm));
    }
    gear.root_form_radius = g.root_form_diameter_mm.map(radius_of);
    let (held, usual) = match gear.kind {
        GearKind::External => (g.bore_diameter_mm, usual_bore(g, gear)),
        GearKind::Ring => (g.rim_diameter_mm, default_held_radius(gear)),
    };
    gear.held_radius = held.map_or(usual, radius_of);
}

/// Radius at which `gear` is held where its file says nothing of it, m.
pub(crate) fn default_held_radius(gear: &Gear) -> f64 {
    match gear.kind {
        GearKind::External => 0.5 * gear.root_radius(),
        GearKind::Ring => gear.root_radius() + 3.5 * gear.normal_module,
    }
}

/// Radius of the bore that nothing is said of, m: that of the shaft on bearings at mid-face, unless the teeth are cut from it, else
/// the default.
fn usual_bore(g: &GearFile, gear: &Gear) -> f64 {
    let root = gear.root_radius();
    let shaft = g.shaft.as_ref().filter(|shaft| !shaft.has_pieces());
    let diameter = shaft.and_then(|shaft| shaft.diameter_at(0.5 * g.face_width_mm));
    let radius = diameter.map(radius_of);
    radius
        .filter(|r| *r > 0.0 && *r <= root - LEAST_RIM * gear.normal_module)
        .unwrap_or_else(|| default_held_radius(gear))
}

/// Usual tip radius of a tool, normal modules.
const USUAL_ROUND: f64 = 0.38;

/// A note where the usual tip radius has no room in the tooth space of gear `i`, which then gets the largest twentieth that has.
pub(super) fn shrink_default_round(g: &GearFile, gear: &mut Gear, i: usize) -> Option<String> {
    if g.tool_tip_radius_coefficient.is_some() || !is_round_too_large(gear) {
        return None;
    }
    let smaller = (0..8).rev().map(|twentieths| Gear {
        tool_tip_radius_coefficient: f64::from(twentieths) / 20.0,
        ..gear.clone()
    });
    *gear = smaller.into_iter().find(|gear| !is_round_too_large(gear))?;
    let radius = gear.tool_tip_radius_coefficient;
    let name = in_gear(i, "tool_tip_radius_coefficient");
    Some(format!(
        "`{name}` = {radius}, as the usual {USUAL_ROUND} does not fit into the tooth space; give that of the tool"
    ))
}

fn is_round_too_large(gear: &Gear) -> bool {
    ToothProfile::new(gear) == Err(ProfileError::RoundTooLarge)
}

/// The field that sets the tip circle of gear `i`, and its value.
pub(super) fn tip_field(file: &PairFile, gear: &Gear, i: usize) -> (String, String) {
    let g = file.gear(i);
    let default = format!("{:.3} (default)", 2.0 * gear.tip_radius / MM);
    let (name, value) = match (g.tip_diameter_mm, g.addendum_coefficient) {
        (Some(mm), _) => ("tip_diameter_mm", mm.to_string()),
        (None, Some(addendum)) => ("addendum_coefficient", addendum.to_string()),
        (None, None) => ("tip_diameter_mm", default),
    };
    (in_gear(i, name), value)
}

/// Least wall between the root circle and the surface that is held, normal modules: with less the elastic model has no
/// room for its elements.
const LEAST_WALL: f64 = 0.25;
/// Smallest bore over the root diameter. About a bore held rigidly the body turns the farther the smaller it is, here
/// thousands of times as far as teeth bend; of less rounding leaves nothing.
const LEAST_BORE: f64 = 1e-3;

/// The tooth profile of gear `i`, checked against bore or rim.
pub(super) fn profile(file: &PairFile, gear: &Gear, i: usize) -> Result<ToothProfile, Refusal> {
    let profile = ToothProfile::new(gear).map_err(|error| profile_refusal(file, gear, i, error))?;
    // No more than the tip leaves of a tooth, and no less than a rounding of the file.
    ensure!((-1e-9..0.5 * gear.normal_module).contains(&gear.tip_chamfer),
        in_gear(i, "tip_form_diameter_mm") => 2.0 * gear.tip_form_radius() / MM;
        "is the end of the involute of tips with the diameter {:.3} mm", 2.0 * gear.tip_radius / MM;
        "give the diameter at which the chamfer begins, at most half a module of height from the tip diameter");
    if let Some(radius) = gear.root_form_radius {
        let [form, given, tip] =
            [profile.form_radius(), radius, gear.tip_form_radius()].map(|r| 2.0 * r / MM);
        let kappa = gear.kappa();
        // A form diameter is rounded to a hundredth of a millimetre.
        ensure!(kappa * (given - form) >= -0.01 && kappa * (tip - given) > 0.0,
            in_gear(i, "root_form_diameter_mm") => given;
            "the involute reaches from the fillet at diameter {form:.3} mm to the tip at {tip:.3} mm";
            "give the diameter between them at which the usable involute begins, or leave it out for {form:.3}");
    }
    // The held surface leaves a wall to the root circle, and is no point.
    let (root, held) = (2.0 * gear.root_radius() / MM, 2.0 * gear.held_radius / MM);
    let wall = 2.0 * LEAST_WALL * gear.normal_module / MM;
    let (name, usual, range) = match gear.kind {
        GearKind::External => ("bore", 0.5 * root, [LEAST_BORE * root, root - wall]),
        GearKind::Ring => ("rim", 1.1 * root, [root + wall, 1e5]),
    };
    let name = in_gear(i, name) + "_diameter_mm";
    check_with_usual(&name, rounded(held), range, about(usual))?;
    Ok(profile)
}

fn profile_refusal(file: &PairFile, gear: &Gear, i: usize, error: ProfileError) -> Refusal {
    let (tip, value) = tip_field(file, gear, i);
    let usual = about(2.0 * usual_tip_radius(gear) / MM);
    let given = file.gear(i).tip_diameter_mm;
    if let Some(meant) = given.and_then(|mm| meant("tip_diameter_mm", mm, usual)) {
        return refusal!(tip => value; "{error}"; "give it in the unit of the name: {meant}");
    }
    let base = 2.0 * gear.base_radius() / MM;
    match error {
        ProfileError::PointedTooth => {
            let alpha = inverse_involute(gear.half_base_angle());
            let limit = match gear.kind {
                GearKind::External => format!("below {:.3}", base / alpha.cos()),
                GearKind::Ring => "larger".into(),
            };
            refusal!(tip => value; "{error}"; "choose a tip diameter {limit} mm, or another `profile_shift`")
        }
        ProfileError::NoInvolute => {
            refusal!(tip => value; "{error}"; "check the tip diameter, `dedendum_coefficient` and `profile_shift`")
        }
        ProfileError::TipInsideBase => {
            refusal!(tip => value; "{error}"; "choose a tip diameter above {base:.3} mm, or more teeth")
        }
        ProfileError::RoundTooLarge => {
            let smaller = match gear.tool_tip_radius_coefficient > 0.0 {
                true => "a smaller radius or ",
                false => "",
            };
            refusal!(in_gear(i, "tool_tip_radius_coefficient") => gear.tool_tip_radius_coefficient;
                "{error}"; "choose {smaller}a smaller `dedendum_coefficient`")
        }
        ProfileError::RootCircle => {
            refusal!(in_gear(i, "dedendum_coefficient") => gear.dedendum_coefficient;
                "{error}"; "choose another dedendum, more teeth or another `profile_shift`")
        }
    }
}

/// Radius of tips with an addendum of one module, m.
pub(super) fn usual_tip_radius(gear: &Gear) -> f64 {
    gear.reference_radius() + gear.normal_module * (gear.profile_shift + gear.kappa())
}

/// A note on a bore that is no more than a pin hole.
pub(super) fn small_bore(geometry: &PairGeometry, i: usize) -> Option<String> {
    let gear = &geometry.gears[i];
    let [mm, root] = [gear.held_radius, gear.root_radius()].map(|radius| 2e3 * radius);
    let (name, mm) = (in_gear(i, "bore_diameter_mm"), rounded(mm));
    let other = "give the diameter of the hub at which the gear is held, or `shaft` if its teeth are cut from one";
    let meant = meant(&name, mm, about(0.5 * root)).unwrap_or_else(|| other.into());
    (gear.body.is_none() && mm < 0.02 * root)
        .then(|| format!("`{name}` = {mm} is a suspicious value: {meant}"))
}

/// What the note on gears says that are held where the file does not say.
pub const ASSUMED_HELD: &str = "assumed: the diameter at which bodies are held";

/// That note.
pub(super) fn default_held(file: &PairFile, geometry: &PairGeometry) -> Option<String> {
    let gears = geometry.gears.iter().enumerate();
    let taken = gears.filter_map(|(i, gear)| {
        let given = file.gear(i);
        let (name, value) = match gear.kind {
            GearKind::External => ("bore_diameter_mm", given.bore_diameter_mm),
            GearKind::Ring => ("rim_diameter_mm", given.rim_diameter_mm),
        };
        let is_open = value.is_none() && given.shaft.is_none() && gear.foundation.is_none();
        let held = rounded(2.0 * gear.held_radius / MM);
        is_open.then(|| format!("`{}` = {held}", in_gear(i, name)))
    });
    let taken: Vec<String> = taken.collect();
    (!taken.is_empty()).then(|| {
        format!(
            "{} {ASSUMED_HELD} decides the mean transmission error; its peak-to-peak value hardly follows",
            taken.join(" and ")
        )
    })
}

/// Gives `gear` its body and foundation.
pub(super) fn add_body(g: &GearFile, gear: &mut Gear, i: usize) -> Result<(), Refusals> {
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
                "give its outside by `rim_diameter_mm`, and what that rests on by `rim_foundation_n_per_mm3`").into());
        }
        // From rubber to steel a hundredth of a millimetre thick.
        check(&in_gear(i, name), g.rim_foundation_n_per_mm3, [1e-3, 1e8])?;
        // N/mm³ = 1e9 N/m³.
        gear.foundation = g.rim_foundation_n_per_mm3.map(|stiffness| 1e9 * stiffness);
        return Ok(());
    }
    if let Some(value) = g.rim_foundation_n_per_mm3 {
        return Err(refusal!(in_gear(i, name) => value;
            "the gear is no ring and is held at its bore"; "leave it out")
        .into());
    }
    // A shaft on bearings alone leaves the gear held at its bore.
    let cut_from = (g.shaft.as_ref())
        .filter(|shaft| shaft.has_pieces() || shaft.field_of_bearings().is_none());
    gear.body = match (first, cut_from, g.rim_thickness_mm, g.web_thickness_mm) {
        (None, None, ..) => None,
        (None, Some(given), ..) => Some(shaft(g, given, gear, i)?),
        (Some((path, value)), Some(_), ..) => {
            return Err(refusal!(path => value;
                "`shaft` is given, too, and its teeth are cut from it"; "give one of them")
            .into());
        }
        (_, None, Some(rim), Some(web)) => Some(body(g, gear, i, [rim, web])?),
        (Some((path, value)), ..) => {
            return Err(refusal!(path => value;
                "`rim_thickness_mm` and `web_thickness_mm` are not both given";
                "give both, or none of these fields for a full disc")
            .into());
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
    let (middle, offset) = (0.5 * width, g.web_offset_mm.unwrap_or(0.0));
    let (face, web) = ([0.0, width], about_middle(middle + offset, web));
    ensure!(encloses(face, web), in_gear(i, "web_offset_mm") => offset;
        "puts the web at {}, beyond the face, {}", shown(web), shown(face); "give the middle of the web less mid-face");
    let web = [web[0].max(0.0), web[1].min(width)];
    let hub_width = g.hub_width_mm.map(|mm| ("hub_width_mm", mm));
    let hub_offset = g.hub_offset_mm.map(|mm| ("hub_offset_mm", mm));
    let (mut hub, mut inner) = (web, ("rim_thickness_mm", rim, "the bore", bore));
    if let Some(diameter) = g.hub_diameter_mm {
        check("hub_diameter_mm", diameter, [bore + 2.0 * least, root])?;
        let length = g.hub_width_mm.unwrap_or(width);
        check("hub_width_mm", length, [ABOVE_0, longest])?;
        hub = about_middle(middle + g.hub_offset_mm.unwrap_or(0.0), length);
        let (field, offset) = hub_offset.unwrap_or(("hub_width_mm", length));
        ensure!(encloses(hub, web), in_gear(i, field) => offset;
            "the web, {}, ends beyond the hub, {}", shown(web), shown(hub); "choose a hub that encloses the web");
        hub = [hub[0].min(web[0]), hub[1].max(web[1])];
        inner = ("hub_diameter_mm", diameter, "the hub", diameter);
    } else if let Some((name, value)) = hub_width.or(hub_offset) {
        return Err(refusal!(in_gear(i, name) => value;
            "`hub_diameter_mm` is not given"; "give it, or leave this out for a web that reaches down to the bore"));
    }
    let (inside, (name, value, part, innermost)) = (root - 2.0 * rim, inner);
    ensure!(inside >= innermost + 2.0 * least, in_gear(i, name) => value;
        "the inside of the rim has the diameter {inside:.3} mm and leaves no web outside of {part} of {innermost:.3} mm";
        "choose a thinner rim or a smaller hub or bore; for a full disc leave rim, web and hub out");
    let hub_radius = g.hub_diameter_mm.map(radius_of);
    Ok(Body {
        rim_radius: radius_of(inside),
        web: web.map(|z| z * MM),
        hub_radius: hub_radius.unwrap_or(gear.held_radius),
        hub: hub.map(|z| z * MM),
        held_ends: [false; 2],
    })
}

/// Both ends along the axis of a part of this width.
fn about_middle(middle: f64, width: f64) -> [f64; 2] {
    [middle - 0.5 * width, middle + 0.5 * width]
}

/// Half a micrometre is the rounding of a drawing.
fn encloses(outer: [f64; 2], inner: [f64; 2]) -> bool {
    outer[0] - 5e-4 <= inner[0] && inner[1] <= outer[1] + 5e-4
}

fn shown([low, high]: [f64; 2]) -> String {
    format!("z {} to {} mm", rounded(low), rounded(high))
}

/// Bore of a shaft that is called solid, over the diameter of its thinner piece: it makes the shaft 1e-4 softer.
const BORE_OF_SOLID: f64 = 0.1;

/// The shaft that the teeth of `gear` are cut from; sets its bore.
fn shaft(g: &GearFile, shaft: &ShaftFile, gear: &mut Gear, i: usize) -> Result<Body, Refusals> {
    let module = gear.normal_module / MM;
    let [wall, longest] = [LEAST_PART, LONGEST_HUB].map(|part| part * module);
    let thickest = 2.0 * gear.root_radius() / MM - 2.0 * LEAST_RIM * module;
    let thinnest = g.bore_diameter_mm.unwrap_or(0.0) + 2.0 * wall;
    let pieces = [("lower", shaft.lower), ("upper", shaft.upper)];
    for (name, piece) in pieces {
        let Some(piece) = piece else { continue };
        limits! { in_gear(i, &format!("shaft.{name}.")), piece;
            diameter_mm: [thinnest, thickest];
            length_mm: [wall, longest];
        }?;
    }
    let held = match (shaft.held, shaft.lower, shaft.upper) {
        (Some(held), ..) => [held != HeldEnds::Upper, held != HeldEnds::Lower],
        (None, Some(_), None) => [true, false],
        (None, None, Some(_)) => [false, true],
        _ => {
            return Err(refusal!(in_gear(i, "shaft") => "no `held`";
                "it has two pieces, or none, and no `held`";
                "give the end that passes the torque on: `lower` (z < 0), `upper` or `both`")
            .into());
        }
    };
    for ((name, piece), held) in pieces.into_iter().zip(held) {
        ensure!(piece.is_some() || !held, in_gear(i, "shaft.held") => name;
            "there is no `{name}` piece to hold"; "give its diameter_mm and length_mm, or hold the other end");
    }
    let stubs = [0, 1].map(|end| Stub {
        radius: radius_of(pieces[end].1.map_or(0.0, |piece| piece.diameter_mm)),
        length: pieces[end].1.map_or(0.0, |piece| piece.length_mm) * MM,
        held: held[end],
    });
    let body = body::shaft(stubs, gear.face_width);
    if g.bore_diameter_mm.is_none() {
        gear.held_radius = BORE_OF_SOLID * body.hub_radius;
    }
    Ok(body)
}
