//! Rim, web and hub of the file, and what a ring rests on.

use super::checks::{Range::Within, check};
use super::error::{Refusal, ensure, refusal};
use super::file::{GearFile, HeldEnds, PairFile, ShaftFile};
use super::mesh_checks::field;
use super::resolve::{MM, gear_file};
use gearmesh::gear::{Body, Gear, GearKind, Stub};
use gearmesh::words::rounded;

/// Least rim below the root circle, normal modules: less is no ring that teeth stand on.
const LEAST_RIM: f64 = 0.5;
/// Least radial length of a web and wall of a hub, and least thickness of a web, normal modules.
const LEAST_PART: f64 = 0.1;
/// Longest hub, normal modules: that of the widest face.
const LONGEST_HUB: f64 = 100.0;
/// Half a micrometre is the rounding of a drawing, mm.
const ROUNDING: f64 = 5e-4;

/// Body and foundation of gear `i`, whose teeth and held surface have been checked.
pub(super) fn complete(file: &PairFile, gear: &mut Gear, i: usize) -> Result<(), Refusal> {
    let given = gear_file(file, i);
    let foundation = given.rim_foundation_n_per_mm3;
    if gear.kind == GearKind::External {
        if let Some(stiffness) = foundation {
            return Err(refusal!(field(i, "rim_foundation_n_per_mm3") => stiffness;
                "the gear is no ring and is held at its bore"; "leave it out"));
        }
        gear.body = match &given.shaft {
            Some(shaft) => Some(self::shaft(given, shaft, gear, i)?),
            None => body(given, gear, i)?,
        };
        return Ok(());
    }
    if given.shaft.is_some() {
        return Err(refusal!(field(i, "shaft") => "a shaft"; "the gear is a ring"; "leave it out"));
    }
    if let Some((name, value)) = first_body_field(given) {
        return Err(refusal!(field(i, name) => value;
            "the gear is a ring, which has neither web nor hub";
            "give its outside by `rim_diameter_mm`, and what that rests on by `rim_foundation_n_per_mm3`"));
    }
    // From rubber to steel a hundredth of a millimetre thick.
    let meant = "the force per area and displacement of the ring's outside; leave it out for a ring that is held rigidly";
    let row = (
        "rim_foundation_n_per_mm3",
        foundation,
        Within(1e-3, 1e8),
        Some(meant.into()),
    );
    check(&field(i, ""), &[row])?;
    // N/mm³ = 1e9 N/m³.
    gear.foundation = foundation.map(|stiffness| 1e9 * stiffness);
    Ok(())
}

/// The first of the fields of rim, web and hub that is given.
fn first_body_field(g: &GearFile) -> Option<(&'static str, f64)> {
    let all = [
        ("rim_thickness_mm", g.rim_thickness_mm),
        ("web_thickness_mm", g.web_thickness_mm),
        ("web_offset_mm", g.web_offset_mm),
        ("hub_diameter_mm", g.hub_diameter_mm),
        ("hub_width_mm", g.hub_width_mm),
        ("hub_offset_mm", g.hub_offset_mm),
    ];
    all.into_iter()
        .find_map(|(name, value)| Some((name, value?)))
}

fn body(g: &GearFile, gear: &Gear, i: usize) -> Result<Option<Body>, Refusal> {
    let (Some(rim), Some(web)) = (g.rim_thickness_mm, g.web_thickness_mm) else {
        return match first_body_field(g) {
            None => Ok(None),
            Some((name, value)) => Err(refusal!(field(i, name) => value;
                "`rim_thickness_mm` and `web_thickness_mm` are not both given";
                "give both, or none of these fields for a full disc")),
        };
    };
    let (module, face) = (gear.normal_module / MM, gear.face_width / MM);
    let (root, bore) = (2.0 * gear.root_radius() / MM, 2.0 * gear.held_radius / MM);
    let [least_rim, least] = [LEAST_RIM, LEAST_PART].map(|modules| rounded(modules * module));
    ensure!(rim >= least_rim, field(i, "rim_thickness_mm") => rim;
        "is less than half a normal module, {least_rim} mm";
        "give the radial thickness from the root circle to the inside of the rim");
    ensure!(web >= least && web <= face, field(i, "web_thickness_mm") => web;
        "lies outside {least} mm (a tenth of the normal module) to the face width, {face} mm";
        "give the axial thickness of the web");
    let offset = g.web_offset_mm.unwrap_or(0.0);
    let web_z = ends(0.5 * face + offset, web);
    ensure!(encloses([0.0, face], web_z), field(i, "web_offset_mm") => offset;
        "puts the web at z {} to {} mm, beyond the face, 0 to {face} mm", rounded(web_z[0]), rounded(web_z[1]);
        "give the middle of the web less mid-face, within +-{} mm", rounded(0.5 * (face - web)));
    let (hub, hub_z) = hub(g, gear, i, web_z)?;
    let inside = root - 2.0 * rim;
    let (innermost, name, value, part) = match hub {
        Some(diameter) => (diameter, "hub_diameter_mm", diameter, "the hub"),
        None => (bore, "rim_thickness_mm", rim, "the bore"),
    };
    ensure!(inside >= innermost + 2.0 * least, field(i, name) => value;
        "the inside of the rim has the diameter {inside:.3} mm and leaves no web outside of {part} of {innermost:.3} mm";
        "choose a thinner rim or a smaller hub or bore; for a full disc leave rim, web and hub out");
    Ok(Some(Body {
        rim_radius: 0.5 * inside * MM,
        web: held_within(web_z, [0.0, face]).map(|z| z * MM),
        hub_radius: hub.map_or(gear.held_radius, |mm| 0.5 * mm * MM),
        hub: hub_z.map(|z| z * MM),
        held_ends: [false; 2],
    }))
}

/// Bore of a shaft that is called solid, over the diameter of its thinner piece: it makes the shaft 1e-4 softer.
const BORE_OF_SOLID: f64 = 0.1;

/// The shaft that the teeth of `gear` are cut from; sets its bore.
fn shaft(g: &GearFile, shaft: &ShaftFile, gear: &mut Gear, i: usize) -> Result<Body, Refusal> {
    if let Some((name, value)) = first_body_field(g) {
        return Err(refusal!(field(i, name) => value;
            "`shaft` is given, too, and its teeth are cut from it"; "give one of them"));
    }
    let module = gear.normal_module / MM;
    let [wall, longest] = [LEAST_PART, LONGEST_HUB].map(|modules| rounded(modules * module));
    let thickest = 2.0 * gear.root_radius() / MM - 2.0 * rounded(LEAST_RIM * module);
    let thinnest = g.bore_diameter_mm.unwrap_or(0.0) + 2.0 * wall;
    let pieces = [("lower", shaft.lower), ("upper", shaft.upper)];
    for (name, piece) in pieces {
        let Some(piece) = piece else { continue };
        let name = |of: &str| field(i, &format!("shaft.{name}.{of}"));
        ensure!((thinnest..=thickest).contains(&piece.diameter_mm), name("diameter_mm") => piece.diameter_mm;
            "lies outside {thinnest:.3} mm (the bore and a wall) to {thickest:.3} mm (half a normal module below the root circle)";
            "give the diameter of the shaft beside the teeth; of a thicker one give the largest that is taken");
        ensure!((wall..=longest).contains(&piece.length_mm), name("length_mm") => piece.length_mm;
            "lies outside {wall} to {longest} mm (a tenth to a hundred normal modules)";
            "give the length from the face to where the shaft of the multibody model takes over");
    }
    let held = match (shaft.held, shaft.lower, shaft.upper) {
        (Some(held), ..) => [held != HeldEnds::Upper, held != HeldEnds::Lower],
        (None, Some(_), None) => [true, false],
        (None, None, Some(_)) => [false, true],
        _ => {
            return Err(refusal!(field(i, "shaft") => "no `held`";
            "it has two pieces, or none, and no `held`";
            "say which end passes the torque on: `lower` (z < 0), `upper` or `both`"));
        }
    };
    for ((name, piece), held) in pieces.into_iter().zip(held) {
        ensure!(piece.is_some() || !held, field(i, "shaft.held") => name;
            "there is no `{name}` piece to hold"; "give its diameter_mm and length_mm, or hold the other end");
    }
    let stubs = [0, 1].map(|end| Stub {
        radius: pieces[end]
            .1
            .map_or(0.0, |piece| 0.5 * piece.diameter_mm * MM),
        length: pieces[end].1.map_or(0.0, |piece| piece.length_mm * MM),
        held: held[end],
    });
    let body = Body::shaft(stubs, gear.face_width);
    if g.bore_diameter_mm.is_none() {
        gear.held_radius = BORE_OF_SOLID * body.hub_radius;
    }
    Ok(body)
}

/// Diameter of the hub, if there is one, and z of its ends (those of the web at `web` if there is none), mm.
fn hub(
    g: &GearFile,
    gear: &Gear,
    i: usize,
    web: [f64; 2],
) -> Result<(Option<f64>, [f64; 2]), Refusal> {
    let (module, face) = (gear.normal_module / MM, gear.face_width / MM);
    let bore = 2.0 * gear.held_radius / MM;
    let [wall, longest] = [LEAST_PART, LONGEST_HUB].map(|modules| rounded(modules * module));
    let offset = g.hub_offset_mm.map(|mm| ("hub_offset_mm", mm));
    let Some(diameter) = g.hub_diameter_mm else {
        let width = g.hub_width_mm.map(|mm| ("hub_width_mm", mm));
        return match width.or(offset) {
            None => Ok((None, held_within(web, [0.0, face]))),
            Some((name, value)) => Err(refusal!(field(i, name) => value;
                "`hub_diameter_mm` is not given";
                "give it, or leave this out for a web that reaches down to the bore")),
        };
    };
    ensure!(diameter >= bore + 2.0 * wall, field(i, "hub_diameter_mm") => diameter;
        "leaves less than {wall} mm (a tenth of the normal module) of wall around the bore of {bore:.3} mm";
        "give the outer diameter of the hub, or leave it out for a web that reaches down to the bore");
    let width = g.hub_width_mm.unwrap_or(face);
    ensure!(width > 0.0 && width <= longest, field(i, "hub_width_mm") => width;
        "must be above 0 and at most a hundred normal modules, {longest} mm";
        "give the axial length over which the hub sits on the shaft");
    let ends = ends(0.5 * face + g.hub_offset_mm.unwrap_or(0.0), width);
    let (name, value) = offset.unwrap_or(("hub_width_mm", width));
    ensure!(encloses(ends, web), field(i, name) => value;
        "the web, z {} to {} mm, ends beyond the hub, z {} to {} mm",
        rounded(web[0]), rounded(web[1]), rounded(ends[0]), rounded(ends[1]);
        "choose a hub that encloses the web");
    Ok((Some(diameter), [ends[0].min(web[0]), ends[1].max(web[1])]))
}

fn ends(middle: f64, width: f64) -> [f64; 2] {
    [middle - 0.5 * width, middle + 0.5 * width]
}

fn encloses(outer: [f64; 2], z: [f64; 2]) -> bool {
    outer[0] - ROUNDING <= z[0] && z[1] <= outer[1] + ROUNDING
}

fn held_within(z: [f64; 2], outer: [f64; 2]) -> [f64; 2] {
    [z[0].max(outer[0]), z[1].min(outer[1])]
}
