//! Rim, web and hub of the file, and what a ring rests on.

use super::checks::require;
use super::error::Refusal;
use super::file::{GearFile, PairFile};
use super::mesh_checks::field;
use super::resolve::{MM, gear_file};
use crate::gear::{Body, Gear, GearKind};
use crate::words::rounded;

/// Least rim below the root circle, normal modules: less is no ring that teeth stand on.
const LEAST_RIM: f64 = 0.5;
/// Least radial length of a web and wall of a hub, and least thickness of a web, normal modules.
const LEAST_PART: f64 = 0.1;
/// Longest hub, normal modules: that of the widest face.
const LONGEST_HUB: f64 = 100.0;
/// Softest and hardest foundation, N/mm³: rubber, and steel a hundredth of a millimetre thick.
const FOUNDATION: [f64; 2] = [1e-3, 1e8];

/// Body and foundation of gear `i`, whose teeth and held surface have been checked.
pub(super) fn complete(file: &PairFile, gear: &mut Gear, i: usize) -> Result<(), Refusal> {
    let given = gear_file(file, i);
    match gear.kind {
        GearKind::Ring => {
            if let Some((name, value)) = body_fields(given).into_iter().next() {
                return Err(Refusal::new(
                    field(i, name),
                    value,
                    "the gear is a ring, which has neither web nor hub",
                    "give its outside by `rim_diameter_mm`, and what that rests on by `rim_foundation_n_per_mm3`",
                ));
            }
            if let Some(stiffness) = given.rim_foundation_n_per_mm3 {
                let [least, most] = FOUNDATION;
                require(
                    (least..=most).contains(&stiffness),
                    field(i, "rim_foundation_n_per_mm3"),
                    stiffness,
                    format!("lies outside {} to {}", rounded(least), rounded(most)),
                    "give the force per area and displacement of the ring's outside in N/mm3, or leave it out for a \
                     ring that is held rigidly",
                )?;
                // N/mm³ = 1e9 N/m³.
                gear.foundation = Some(1e9 * stiffness);
            }
        }
        GearKind::External => {
            if let Some(stiffness) = given.rim_foundation_n_per_mm3 {
                return Err(Refusal::new(
                    field(i, "rim_foundation_n_per_mm3"),
                    stiffness,
                    "the gear is no ring and is held at its bore",
                    "leave it out",
                ));
            }
            gear.body = body(given, gear, i)?;
        }
    }
    Ok(())
}

/// The fields that describe rim, web and hub, as far as they are given.
fn body_fields(g: &GearFile) -> Vec<(&'static str, f64)> {
    [
        ("rim_thickness_mm", g.rim_thickness_mm),
        ("web_thickness_mm", g.web_thickness_mm),
        ("web_offset_mm", g.web_offset_mm),
        ("hub_diameter_mm", g.hub_diameter_mm),
        ("hub_width_mm", g.hub_width_mm),
        ("hub_offset_mm", g.hub_offset_mm),
    ]
    .into_iter()
    .filter_map(|(name, value)| Some((name, value?)))
    .collect()
}

fn body(g: &GearFile, gear: &Gear, i: usize) -> Result<Option<Body>, Refusal> {
    let (Some(rim), Some(web)) = (g.rim_thickness_mm, g.web_thickness_mm) else {
        return match body_fields(g).into_iter().next() {
            None => Ok(None),
            Some((name, value)) => Err(Refusal::new(
                field(i, name),
                value,
                "`rim_thickness_mm` and `web_thickness_mm` are not both given",
                "give both, or none of these fields for a full disc",
            )),
        };
    };
    let (module, face) = (gear.normal_module / MM, gear.face_width / MM);
    let (root, bore) = (2.0 * gear.root_radius() / MM, 2.0 * gear.held_radius / MM);
    let least = LEAST_PART * module;
    require(
        rim >= LEAST_RIM * module,
        field(i, "rim_thickness_mm"),
        rim,
        format!(
            "is less than half a normal module, {} mm",
            rounded(LEAST_RIM * module)
        ),
        "give the radial thickness from the root circle to the inside of the rim",
    )?;
    require(
        web >= least && web <= face,
        field(i, "web_thickness_mm"),
        web,
        format!(
            "lies outside {} mm (a tenth of the normal module) to the face width, {face} mm",
            rounded(least)
        ),
        "give the axial thickness of the web",
    )?;
    let web_middle = 0.5 * face + g.web_offset_mm.unwrap_or(0.0);
    // Half a micrometre is the rounding of a drawing.
    let within = |z: [f64; 2], outer: [f64; 2]| outer[0] - 5e-4 <= z[0] && z[1] <= outer[1] + 5e-4;
    let web_z = ends(web_middle, web);
    require(
        within(web_z, [0.0, face]),
        field(i, "web_offset_mm"),
        g.web_offset_mm.unwrap_or(0.0),
        format!(
            "puts the web at z {} to {} mm, beyond the face, 0 to {face} mm",
            rounded(web_z[0]),
            rounded(web_z[1])
        ),
        format!(
            "give the middle of the web less mid-face, within +-{} mm",
            rounded(0.5 * (face - web))
        ),
    )?;
    let (hub, hub_z) = hub(g, gear, i, web_z)?;
    let inside = root - 2.0 * rim;
    let innermost = hub.unwrap_or(bore);
    require(
        inside >= innermost + 2.0 * least,
        field(
            i,
            if hub.is_some() {
                "hub_diameter_mm"
            } else {
                "rim_thickness_mm"
            },
        ),
        hub.unwrap_or(rim),
        format!(
            "the inside of the rim has the diameter {inside:.3} mm and leaves no web outside of {} of {innermost:.3} mm",
            if hub.is_some() { "the hub" } else { "the bore" }
        ),
        "choose a thinner rim or a smaller hub or bore; for a full disc leave rim, web and hub out",
    )?;
    Ok(Some(Body {
        rim_radius: 0.5 * inside * MM,
        web: held_within(web_z, [0.0, face]).map(|z| z * MM),
        hub_radius: match hub {
            Some(mm) => 0.5 * mm * MM,
            None => gear.held_radius,
        },
        hub: hub_z.map(|z| z * MM),
    }))
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
    let Some(diameter) = g.hub_diameter_mm else {
        for (name, value) in [
            ("hub_width_mm", g.hub_width_mm),
            ("hub_offset_mm", g.hub_offset_mm),
        ] {
            if let Some(value) = value {
                return Err(Refusal::new(
                    field(i, name),
                    value,
                    "`hub_diameter_mm` is not given",
                    "give it, or leave this out for a web that reaches down to the bore",
                ));
            }
        }
        return Ok((None, held_within(web, [0.0, face])));
    };
    require(
        diameter >= bore + 2.0 * LEAST_PART * module,
        field(i, "hub_diameter_mm"),
        diameter,
        format!(
            "leaves less than {} mm (a tenth of the normal module) of wall around the bore of {bore:.3} mm",
            rounded(LEAST_PART * module)
        ),
        "give the outer diameter of the hub, or leave it out for a web that reaches down to the bore",
    )?;
    let width = g.hub_width_mm.unwrap_or(face);
    require(
        width > 0.0 && width <= LONGEST_HUB * module,
        field(i, "hub_width_mm"),
        width,
        format!(
            "must be above 0 and at most a hundred normal modules, {} mm",
            rounded(LONGEST_HUB * module)
        ),
        "give the axial length over which the hub sits on the shaft",
    )?;
    let ends = ends(0.5 * face + g.hub_offset_mm.unwrap_or(0.0), width);
    require(
        ends[0] <= web[0] + 5e-4 && web[1] <= ends[1] + 5e-4,
        field(
            i,
            if g.hub_offset_mm.is_some() {
                "hub_offset_mm"
            } else {
                "hub_width_mm"
            },
        ),
        g.hub_offset_mm.unwrap_or(width),
        format!(
            "the web, z {} to {} mm, ends beyond the hub, z {} to {} mm",
            rounded(web[0]),
            rounded(web[1]),
            rounded(ends[0]),
            rounded(ends[1])
        ),
        "choose a hub that encloses the web",
    )?;
    Ok((Some(diameter), [ends[0].min(web[0]), ends[1].max(web[1])]))
}

fn ends(middle: f64, width: f64) -> [f64; 2] {
    [middle - 0.5 * width, middle + 0.5 * width]
}

fn held_within(z: [f64; 2], outer: [f64; 2]) -> [f64; 2] {
    [z[0].max(outer[0]), z[1].min(outer[1])]
}
