//! Bodies that are no solids of revolution: `body_matrix`, `web_holes`, `rim_pins` and `rim_supports` of a gear.

use std::f64::consts::{PI, TAU};
use std::path::Path;

use crate::gear::{BodyShape, HoleCircle, UnevenBody};
use gearmesh::gear::{Gear, GearKind, PairGeometry};

use super::body_matrix::of_matrix;
use super::checks::{Refusals, both, check, ensure, in_gear, limits, refusal};
use super::file::{BodyMatrixFile, GearFile, HolesFile, MM, PairFile, SupportsFile, radius_of};

/// The bodies of both gears, None where the file gives none.
pub(super) fn of_pair(
    file: &PairFile,
    geometry: &PairGeometry,
    folder: &Path,
) -> Result<[Option<UnevenBody>; 2], Refusals> {
    let [one, two] = [0, 1].map(|i| of_gear(file.gear(i), &geometry.gears[i], i, folder));
    both(one, two).map(|(one, two)| [one, two])
}

fn of_gear(
    g: &GearFile,
    gear: &Gear,
    i: usize,
    folder: &Path,
) -> Result<Option<UnevenBody>, Refusals> {
    let all = [
        ("body_matrix", g.body_matrix.as_ref().map(Given::Matrix)),
        ("web_holes", g.web_holes.map(Given::Holes)),
        ("rim_pins", g.rim_pins.map(Given::Pins)),
        ("rim_supports", g.rim_supports.map(Given::Supports)),
    ];
    let mut all = all
        .into_iter()
        .filter_map(|(name, given)| Some((name, given?)));
    let Some((name, given)) = all.next() else {
        return Ok(None);
    };
    if let Some((other, _)) = all.next() {
        return Err(
            refusal!(in_gear(i, other) => "a body"; "`{name}` is given, too"; "give one of them")
                .into(),
        );
    }
    let is_ring = gear.kind == GearKind::Ring;
    ensure!(name == "body_matrix" || is_ring == name.starts_with("rim"), in_gear(i, name) => "a body";
        "the gear is {}", if is_ring { "a ring" } else { "no ring" };
        "give `rim_pins` or `rim_supports` for a ring, `web_holes` for another gear, `body_matrix` for either");
    let is_held = gear.foundation.is_some() || gear.body.is_some_and(|body| body.is_shaft());
    ensure!(!is_held, in_gear(i, name) => "a body";
        "`shaft` or `rim_foundation_n_per_mm3` of the gear is given, too"; "leave that out");
    let path = in_gear(i, name);
    let of_rim = |shape| UnevenBody {
        shape,
        ..ring_cylinder(gear)
    };
    let body = match given {
        Given::Matrix(matrix) => {
            ensure!(gear.body.is_none(), path => &matrix.nodes_file; "rim and web of the gear are given, too";
                "leave them out: the matrix holds all that lies beyond its nodes");
            of_matrix(matrix, gear, i, folder)?
        }
        Given::Holes(holes) => {
            let (radius, z, inner) = match gear.body {
                Some(body) => (body.rim_radius, body.web, body.hub_radius),
                None => (
                    gear.root_radius() - DEPTH * gear.normal_module,
                    [0.0, gear.face_width],
                    gear.held_radius,
                ),
            };
            let shape = BodyShape::Holes(circle(&holes, gear, &path, [inner, radius])?);
            UnevenBody { radius, z, shape }
        }
        Given::Pins(pins) => {
            let between = [ring_cylinder(gear).radius, gear.held_radius];
            of_rim(BodyShape::Pins(circle(&pins, gear, &path, between)?))
        }
        Given::Supports(supports) => of_rim(shape_of_supports(&supports, &path)?),
    };
    Ok(Some(body))
}

/// What a file gives of a body that is no solid of revolution.
enum Given<'a> {
    Matrix(&'a BodyMatrixFile),
    Holes(HolesFile),
    Pins(HolesFile),
    Supports(SupportsFile),
}

fn shape_of_supports(supports: &SupportsFile, path: &str) -> Result<BodyShape, Refusals> {
    let count = f64::from(supports.count);
    check(&format!("{path}.count"), count, [1.0, MOST_HOLES])?;
    let whole = [-360.0, 360.0];
    check(&format!("{path}.angle_deg"), supports.angle_deg, whole)?;
    let pitch = 360.0 / count;
    let widths = [0.01 * pitch, 0.95 * pitch];
    check(&format!("{path}.width_deg"), supports.width_deg, widths)?;
    Ok(BodyShape::Supports {
        count: supports.count,
        width: supports.width_deg.to_radians(),
        angle: supports.angle_deg.to_radians(),
    })
}

/// Most holes, pins or supports: as many are a web or a rim that is softer.
const MOST_HOLES: f64 = 60.0;
/// Depth of the cylinder below the roots of a disc or a ring, normal modules, where holes leave room for it.
const DEPTH: f64 = 1.25;
/// Least wall between a hole and another one, or what is below and above it, over its radius.
const LEAST_WALL: f64 = 0.1;

/// The cylinder in the wall of a ring, with an outside that is free.
fn ring_cylinder(gear: &Gear) -> UnevenBody {
    let (root, outside) = (gear.root_radius(), gear.held_radius);
    UnevenBody {
        radius: root + (DEPTH * gear.normal_module).min(0.4 * (outside - root)),
        z: [0.0, gear.face_width],
        shape: BodyShape::Supports {
            count: 1,
            width: TAU,
            angle: 0.0,
        },
    }
}

/// The holes of the field `path` between two `radii`, m.
fn circle(
    holes: &HolesFile,
    gear: &Gear,
    path: &str,
    radii: [f64; 2],
) -> Result<HoleCircle, Refusals> {
    let module = gear.normal_module / MM;
    let [inner, outer] = radii.map(|radius| 2.0 * radius / MM);
    check(
        &format!("{path}.count"),
        f64::from(holes.count),
        [1.0, MOST_HOLES],
    )?;
    limits! { format!("{path}."), holes;
        circle_diameter_mm: [inner, outer];
        diameter_mm: [0.25 * module, 0.5 * (outer - inner)];
        angle_deg: [-360.0, 360.0];
    }?;
    let (circle, hole) = (holes.circle_diameter_mm, holes.diameter_mm);
    let wall = hole * (1.0 + LEAST_WALL);
    ensure!(circle + wall <= outer && circle - wall >= inner, format!("{path}.diameter_mm") => hole;
        "reaches beyond the part for it, from {inner:.3} to {outer:.3} mm in diameter, or leaves it a wall of less than {:.3} mm", 0.5 * LEAST_WALL * hole;
        "choose smaller holes, or another `circle_diameter_mm`");
    let apart = circle * (PI / f64::from(holes.count)).sin();
    ensure!(holes.count == 1 || apart >= wall, format!("{path}.count") => holes.count;
        "the holes of {hole} mm lie {apart:.3} mm apart"; "choose fewer or smaller ones");
    Ok(HoleCircle {
        count: holes.count,
        circle_radius: radius_of(circle),
        radius: radius_of(hole),
        angle: holes.angle_deg.to_radians(),
    })
}
