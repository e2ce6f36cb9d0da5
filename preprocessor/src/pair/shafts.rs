//! Shafts on bearings: `sections`, `bearings` and what belongs to them in `shaft` of a gear.

use super::checks::{ABOVE_0, Refusals, both, check, ensure, every, in_gear, limits, refusal};
use super::file::{
    BearingFile, MM, PairFile, ShaftEnd, ShaftFile, ShaftSectionFile, UM, radius_of,
};
use crate::gear::{Bearing, Shaft, ShaftSection};
use gearmesh::gear::{Body, Gear, PairGeometry};
use gearmesh::words::{fixed, rounded};

use super::mesh::LARGEST_DEFLECTION;
use crate::shaft::{approach, is_held};

/// Most sections, and most bearings, of one shaft.
const MOST_PIECES: usize = 100;
/// Wall of a hollow section over its radius, at least: thinner ones are no beams.
const LEAST_WALL: f64 = 0.02;

/// The shafts of both gears, None where the file gives none.
pub(super) fn of_pair(
    file: &PairFile,
    geometry: &PairGeometry,
) -> Result<[Option<Shaft>; 2], Refusals> {
    let [one, two] = [0, 1].map(|i| match &file.gear(i).shaft {
        Some(given) => on_bearings(given, &geometry.gears[i], i),
        None => Ok(None),
    });
    both(one, two).map(|(one, two)| [one, two])
}

/// A note on shafts that deflect by more than teeth can follow, as one that is overhung by mistake.
pub(super) fn note(
    file: &PairFile,
    geometry: &PairGeometry,
    shafts: &[Option<Shaft>; 2],
) -> Option<String> {
    let torque = file.operating.maximum_torque_nm;
    let largest = approach(geometry, shafts, torque)?;
    let module = geometry.gears[0].normal_module;
    if largest <= LARGEST_DEFLECTION * module {
        return None;
    }
    let overhung = (0..2).filter_map(|i| {
        let (shaft, middle) = (shafts[i].as_ref()?, 0.5 * geometry.gears[i].face_width);
        let z = shaft.bearings.iter().map(|b| b.z);
        let [low, high] = [z.clone().fold(f64::INFINITY, f64::min), z.fold(f64::NEG_INFINITY, f64::max)];
        let [low_mm, high_mm, middle_mm] = [low, high, middle].map(|z| rounded(z / MM));
        (!(low..=high).contains(&middle)).then(|| {
            format!(
                "; gear {} is overhung, its middle at z {middle_mm} mm and the outermost bearings at {low_mm} and {high_mm} mm",
                i + 1
            )
        })
    });
    Some(format!(
        "under `operating.maximum_torque_nm` = {torque} shafts and bearings deflect by {} um along the line of action, {:.0} % of the \
         module; check `z_mm`, `start_mm`, diameters and stiffnesses of `shaft`{}",
        fixed(largest / UM, 0),
        100.0 * largest / module,
        overhung.collect::<String>()
    ))
}

/// Name in the file of the field `name` of the shaft of gear `i`.
fn in_shaft(i: usize, name: &str) -> String {
    in_gear(i, &format!("shaft.{name}"))
}

/// What a shaft on bearings must have.
struct Required<'a> {
    sections: &'a [ShaftSectionFile],
    start_mm: f64,
    bearings: &'a [BearingFile],
    torque_end: ShaftEnd,
}

/// None without a shaft on bearings.
fn required(given: &ShaftFile, i: usize) -> Result<Option<Required<'_>>, Refusals> {
    let path = |name: &str| in_shaft(i, name);
    let Some(sections) = &given.sections else {
        if let Some(name) = given.field_of_bearings() {
            return Err(
                refusal!(path("sections") => "none"; "`{name}` says something of a shaft on bearings";
                "give the sections of the shaft from low to high z, each with `diameter_mm` and `length_mm`, or leave `{name}` out").into(),
            );
        }
        return Ok(None);
    };
    let missing = |name: &str, remedy: &str| refusal!(path(name) => "none"; "a shaft with `sections` needs it"; "give {remedy}");
    let start_mm = given.start_mm.ok_or_else(|| {
        missing(
            "start_mm",
            "z of the lower end of the first section, from the gear's z = 0 face",
        )
    })?;
    let bearings = given.bearings.as_ref().ok_or_else(|| {
        missing(
            "bearings",
            "a list of bearings, each with `z_mm` and `radial_stiffness_n_per_um`",
        )
    })?;
    let torque_end = given.torque_end.ok_or_else(|| {
        missing(
            "torque_end",
            "the end at which the torque enters or leaves: `lower` (small z) or `upper`",
        )
    })?;
    for (name, count) in [("sections", sections.len()), ("bearings", bearings.len())] {
        ensure!((1..=MOST_PIECES).contains(&count), path(name) => count;
            "that many are no shaft"; "give 1 to {MOST_PIECES}");
    }
    Ok(Some(Required {
        sections,
        start_mm,
        bearings,
        torque_end,
    }))
}

fn on_bearings(given: &ShaftFile, gear: &Gear, i: usize) -> Result<Option<Shaft>, Refusals> {
    let path = |name: &str| in_shaft(i, name);
    let Some(required) = required(given, i)? else {
        return Ok(None);
    };
    let sections = required.sections;
    let whole = limits! { path(""), given;
        start_mm: [-1e5, 1e5];
        youngs_modulus_gpa: [ABOVE_0, 2000.0];
        poisson_ratio: [0.0, 0.49];
    };
    let pieces = every(sections.iter().enumerate().map(|(k, section)| {
        limits! { path(&format!("sections.{k}.")), section;
            diameter_mm: [ABOVE_0, 1e4];
            length_mm: [1e-3, 1e5];
            inner_diameter_mm: [0.0, (1.0 - LEAST_WALL) * section.diameter_mm];
        }
    }));
    both(whole, pieces)?;
    let hub = gear.body.filter(|body| !body.is_shaft());
    let seat = hub.map_or([0.0, gear.face_width], |body| body.hub);
    // A web that reaches down to the shaft stiffens it by itself.
    let outside = match hub {
        Some(Body {
            hub_radius,
            rim_radius,
            ..
        }) if hub_radius <= gear.held_radius => rim_radius.min(hub_radius),
        Some(body) => body.hub_radius,
        None => gear.root_radius(),
    };
    let mut shaft = Shaft {
        start: required.start_mm * MM,
        sections: (sections.iter())
            .map(|s| ShaftSection {
                radii: [s.inner_diameter_mm.unwrap_or(0.0), s.diameter_mm].map(radius_of),
                length: s.length_mm * MM,
            })
            .collect(),
        bearings: vec![],
        torque_at_upper_end: required.torque_end == ShaftEnd::Upper,
        youngs_modulus: 1e9 * given.youngs_modulus_gpa.unwrap_or(206.0),
        poisson_ratio: given.poisson_ratio.unwrap_or(0.3),
        seat,
        seat_radius: outside,
    };
    check_place(&shaft, gear, i)?;
    if let Some(mm) = given.seat_diameter_mm {
        let root = gear.root_radius();
        check(&path("seat_diameter_mm"), mm, [ABOVE_0, 2.0 * root / MM])?;
        shaft.seat_radius = radius_of(mm);
    }
    shaft.bearings = bearings(required.bearings, &shaft, i)?;
    check_freedom(&shaft, gear, i)?;
    Ok(Some(shaft))
}

/// Refuses a shaft that does not reach through the gear, or is thicker than its root there.
fn check_place(shaft: &Shaft, gear: &Gear, i: usize) -> Result<(), Refusals> {
    let path = |name: &str| in_shaft(i, name);
    let seat = shaft.seat;
    let ends = shaft.section_ends();
    let [low, high] = [ends[0], ends[ends.len() - 1]];
    let (shown_low, shown_high) = (rounded(low / MM), rounded(high / MM));
    let [first, last] = seat.map(|z| rounded(z / MM));
    // Half a micrometre is the rounding of a drawing.
    ensure!(low <= seat[0] + 0.5 * UM && seat[1] <= high + 0.5 * UM, path("start_mm") => rounded(shaft.start / MM);
        "puts the shaft at z {shown_low} to {shown_high} mm, and the gear sits at {first} to {last} mm";
        "give z of the lower end of the first section from the gear's z = 0 face, negative for a shaft that begins below it, \
         and sections that reach through the gear");
    let root = gear.root_radius();
    let sections = shaft.sections.iter().enumerate();
    for (k, section) in
        sections.filter(|(k, _)| ends[*k] < seat[1] - UM && seat[0] + UM < ends[k + 1])
    {
        ensure!(section.radii[1] <= root + 0.5 * UM, path(&format!("sections.{k}.diameter_mm")) => rounded(2.0 * section.radii[1] / MM);
            "the section lies under the teeth, whose root circle has {:.3} mm", 2.0 * root / MM;
            "give at most that diameter there, and the length beside the teeth as a section of its own");
    }
    Ok(())
}

/// The `given` bearings of `shaft`.
fn bearings(given: &[BearingFile], shaft: &Shaft, i: usize) -> Result<Vec<Bearing>, Refusals> {
    let ends = shaft.section_ends();
    let [low, high] = [ends[0], ends[ends.len() - 1]];
    let mut bearings = vec![];
    for (k, bearing) in given.iter().enumerate() {
        limits! { in_shaft(i, &format!("bearings.{k}.")), bearing;
            z_mm: [low / MM, high / MM];
            radial_stiffness_n_per_um: [1e-3, 1e6];
            axial_stiffness_n_per_um: [0.0, 1e6];
            tilt_stiffness_nm_per_mrad: [0.0, 1e6];
            radial_clearance_um: [0.0, 1e4];
        }?;
        bearings.push(Bearing {
            z: bearing.z_mm * MM,
            radial_stiffness: 1e6 * bearing.radial_stiffness_n_per_um,
            axial_stiffness: 1e6 * bearing.axial_stiffness_n_per_um.unwrap_or(0.0),
            tilt_stiffness: 1e3 * bearing.tilt_stiffness_nm_per_mrad.unwrap_or(0.0),
            free_radius: 0.5 * bearing.radial_clearance_um.unwrap_or(0.0) * UM,
        });
    }
    Ok(bearings)
}

/// Refuses bearings that leave the shaft free to move.
fn check_freedom(shaft: &Shaft, gear: &Gear, i: usize) -> Result<(), Refusals> {
    let path = || in_shaft(i, "bearings");
    let count = shaft.bearings.len();
    let ends = shaft.section_ends();
    let length = ends[ends.len() - 1] - ends[0];
    let z = shaft.bearings.iter().map(|b| b.z);
    let apart = z.clone().fold(f64::NEG_INFINITY, f64::max) - z.fold(f64::INFINITY, f64::min);
    let tilts = shaft.bearings.iter().any(|b| b.tilt_stiffness > 0.0);
    ensure!(tilts || apart > 1e-3 * length, path() => count;
        "they let the shaft tilt freely"; "give two bearings at a distance from each other, or one with `tilt_stiffness_nm_per_mrad`");
    let axial = shaft.bearings.iter().any(|b| b.axial_stiffness > 0.0);
    ensure!(axial || gear.helix_angle == 0.0, path() => count;
        "none takes the axial force of the helical teeth";
        "give the one that does its `axial_stiffness_n_per_um`");
    ensure!(is_held(shaft, gear), path() => count;
        "stiffnesses and diameters are too far apart for a solution";
        "check diameters, lengths and stiffnesses, in the units of their names");
    Ok(())
}
