//! What happens on the flanks and in the roots: pressure, load and stress of the contact solver, and the modifications as a
//! gear is inspected.

use gearmesh::contact::SegmentLoad;
use gearmesh::gear::{Flank, PairGeometry};
use gearmesh::pair::Pair;
use gearmesh_preprocessor::contact::GearRoots;

use super::curves::through_mesh;
use super::evenly;
use super::figure::{Curve, Figure, Height, Map, Patch, charts};
use super::page::Section;
use crate::case::{Case, torque_in_words};

/// Pressures below this are left white, MPa.
const VISIBLE: f64 = 1.0;
const LINE_POSITIONS: [f64; 4] = [0.0, 0.25, 0.5, 0.75];
const TRACE_POINTS: usize = 201;

/// Every loaded segment of the mesh cycle as a patch of gear `i`'s flank, as high as the contact moves from one position to the
/// next; `value` is None at a tip edge.
fn pattern(
    geometry: &PairGeometry,
    case: &Case,
    i: usize,
    value: impl Fn(&SegmentLoad) -> Option<f64>,
) -> Map {
    let gear = &geometry.gears[i];
    let half_step = 0.5 * geometry.base_pitch() / case.input.positions as f64;
    let diameter = |roll: f64| 2e3 * gear.radius_at_roll(roll);
    let segments = case
        .cycle
        .results
        .iter()
        .flat_map(|result| &result.segments);
    let seen = segments.filter(|s| s.edge.is_some() || s.pressure > VISIBLE * 1e6);
    let patch = |s: &SegmentLoad| {
        let along_face = s.z.map(|z| 1e3 * z);
        let along_profile = [-half_step, half_step].map(|step| diameter(s.roll[i] + step));
        let ends = [along_face, along_profile];
        Patch {
            node: ends.map(|[a, b]| 0.5 * (a + b)),
            ends,
            value: value(s),
        }
    };
    let patches: Vec<Patch> = seen.map(patch).collect();
    let path = geometry.path_of_contact(geometry.center_distance);
    let mut ends = [path.start, path.end]
        .map(|xi| diameter(geometry.roll_at(i, geometry.center_distance, xi)));
    ends.sort_by(f64::total_cmp);
    let margin = 0.04 * (ends[1] - ends[0]);
    let z = [gear.face_offset, gear.face_offset + gear.face_width];
    Map {
        ends: [z.map(|z| 1e3 * z), [ends[0] - margin, ends[1] + margin]],
        top: patches.iter().filter_map(|p| p.value).fold(1.0, f64::max),
        patches,
    }
}

/// Maps of both gears for each of `cases` on one common scale, titled `what` it is, gear and `load` of the case.
fn patterns(
    geometry: &PairGeometry,
    cases: &[Case],
    [what, unit]: [&str; 2],
    load: impl Fn(&Case) -> String,
    value: impl Fn(&SegmentLoad) -> Option<f64> + Copy,
) -> Vec<Figure> {
    let gears = |case| [(case, 0), (case, 1)];
    let all = cases.iter().flat_map(gears);
    let map = |(case, i)| {
        let title = format!("{what} on gear {} at {}", i + 1, load(case));
        (title, pattern(geometry, case, i, value))
    };
    let mut all: Vec<(String, Map)> = all.map(map).collect();
    let top = all.iter().map(|(_, map)| map.top).fold(0.0, f64::max);
    all.iter_mut().for_each(|(_, map)| map.top = top);
    let labels = ["z (mm)", "diameter (mm)", unit];
    let figure = |(title, map)| Figure::map(title, labels, map);
    all.into_iter().map(figure).collect()
}

/// What the flanks carry: `cases` aligned, `tilted` at the limits of the misalignment, `nominal` for the contact lines.
pub fn carried(pair: &Pair, cases: &[Case], nominal: &Case, tilted: &[Case]) -> Vec<Section> {
    let geometry = &pair.geometry;
    let cos_beta_b = geometry.base_helix_angle().cos();
    let torque = |case: &Case| torque_in_words(case.input.torque);
    let tilt = |case: &Case| format!("{:+.2} mrad", 1e3 * case.input.misalignment);
    let pressure = |s: &SegmentLoad| s.edge.is_none().then_some(1e-6 * s.pressure);
    let line_load = |s: &SegmentLoad| Some(1e-3 * s.line_load(cos_beta_b));
    let pattern = ["Contact pattern", "pressure (MPa)"];
    let distribution = ["Load distribution", "line load (N/mm)"];

    let note = "Largest pressure that each point of the flank sees over the mesh cycle. Blue: contact reaches the tip edge of this gear, or \
                of its mate where it meets the root; at a sharp edge pressure has no bound, so it is not on the scale. z: from gear 1's \
                z = 0 face.";
    let figures = patterns(geometry, cases, pattern, torque, pressure);
    let mut sections = vec![Section::new("Contact pattern", note, figures)];
    if !tilted.is_empty() {
        let heading = "Contact pattern under misalignment";
        let note =
            "At the nominal torque and the limits of the misalignment in the plane of action.";
        let figures = patterns(geometry, tilted, pattern, tilt, pressure);
        sections.push(Section::new(heading, note, figures));
    }
    let note = "Largest normal force per length of contact line that each point of the flank carries over the mesh cycle.";
    let figures = patterns(geometry, cases, distribution, torque, line_load);
    sections.push(Section::new("Load distribution", note, figures));
    let note = format!(
        "At {} and four positions of the mesh; one curve for each tooth pair in contact, up to where contact reaches a tip edge.",
        torque(nominal)
    );
    let lines = LINE_POSITIONS.map(|tau| contact_lines(nominal, tau)).into();
    let heading = "Pressure along the contact lines";
    sections.push(Section::new(heading, note, lines));
    sections
}

/// Pressure inside the flanks along z for every tooth pair in contact at the position of the cycle nearest below `tau`.
fn contact_lines(case: &Case, tau: f64) -> Figure {
    let i = (tau * case.input.positions as f64) as usize;
    let inside = |s: &&SegmentLoad| s.edge.is_none() && s.pressure > VISIBLE * 1e6;
    let segments: Vec<&SegmentLoad> = case.cycle.results[i]
        .segments
        .iter()
        .filter(inside)
        .collect();
    let curve = |segments: &[&SegmentLoad]| {
        let point = |s: &&SegmentLoad| (500.0 * (s.z[0] + s.z[1]), s.pressure * 1e-6);
        let points = segments.iter().map(point);
        Curve::new(format!("pair {}", segments[0].tooth_pair), points)
    };
    let pairs = segments.chunk_by(|a, b| a.tooth_pair == b.tooth_pair);
    let title = format!("Pressure at mesh position {}", case.cycle.mesh_position[i]);
    let (labels, height) = (["z (mm)", "pressure (MPa)"], Height::FromZero(0.0));
    Figure::lines(title, labels, height, pairs.map(curve).collect())
}

/// Profile and lead traces of each flank, as an inspection chart has them.
pub fn modifications(pair: &Pair) -> Section {
    let geometry = &pair.geometry;
    let mut figures = Vec::new();
    for (i, gear) in geometry.gears.iter().enumerate() {
        let start = geometry.active_start_roll(i, geometry.center_distance);
        let pitch = gear.roll_length(geometry.operating_pitch_radius(i, geometry.center_distance));
        let trace = |ends: [f64; 2], coordinates: &dyn Fn(f64) -> [f64; 2]| {
            let curve = |(flank, name)| {
                let m = &pair.microgeometry.flank(flank)[i];
                let along = evenly(ends[0], ends[1], TRACE_POINTS).into_iter();
                let point = |s| {
                    let [roll, z] = coordinates(s);
                    (1e3 * s, -1e6 * m.removal(gear, roll, z))
                };
                Curve::new(name, along.map(point))
            };
            let flanks = [(Flank::Drive, "drive flank"), (Flank::Coast, "coast flank")];
            let [drive, coast] = flanks.map(curve);
            match drive.points == coast.points {
                true => vec![Curve::new("both flanks", drive.points)],
                false => vec![drive, coast],
            }
        };
        let profile = trace([start, gear.tip_form_roll()], &|roll| {
            [roll, 0.5 * gear.face_width]
        });
        let lead = trace([0.0, gear.face_width], &|z| [pitch, z]);
        let number = i + 1;
        figures.extend(charts! {
            format!("Profile of gear {number}"), ["length of roll (mm)", "deviation (um)"], Height::Curves(1.0) => profile;
            format!("Lead of gear {number}"), ["z from the gear's own z = 0 face (mm)", "deviation (um)"], Height::Curves(1.0) => lead;
        });
    }
    let note = "Deviation from the involute helicoid, material removed downwards: the profile at mid-face from the start of the active \
                profile to the tip, the lead at the pitch point.";
    Section::new("Modifications as inspected (K-chart)", note, figures)
}

/// Stress of one tooth of either gear through the mesh, and the fillets where it is largest at the torque `nominal`.
pub fn roots(cases: &[Case], nominal: f64) -> Section {
    let curve = |case: &Case, i: usize| -> Option<Curve> {
        let teeth = case.roots.as_ref()?[i].teeth.iter();
        let stresses = teeth.map(|t| (t.position, t.tooth_pair, 1e-6 * t.largest.stress));
        Some(through_mesh(case, stresses))
    };
    let curves = |i| cases.iter().filter_map(|case| curve(case, i)).collect();
    let labels = ["mesh position of the tooth", "root stress (MPa)"];
    let mut figures = charts! {
        "Root stress of gear 1", labels, Height::FromZero(0.0) => curves(0);
        "Root stress of gear 2", labels, Height::FromZero(0.0) => curves(1);
    };
    let nominal = cases.iter().find(|case| case.input.torque == nominal);
    let gears = nominal.and_then(|case| case.roots.as_ref());
    for (i, gear) in gears.into_iter().flatten().enumerate() {
        let title = format!("Fillet of gear {} at the largest root stress", i + 1);
        let labels = ["z (mm)", "tangent (deg)", "root stress (MPa)"];
        figures.extend(fillet(gear).map(|map| Figure::map(title, labels, map)));
    }
    let note = "Largest principal stress in the fillet of one tooth of either gear on its way through the mesh, from finite elements; at 0 its \
                tooth pair touches at the pitch point at mid-face. Fillets: over the face and over the angle of the fillet's tangent \
                with the tooth's centre line (90 degrees: root circle), at the nominal torque and the mesh position where the stress is \
                largest.";
    Section::new("Tooth root stress", note, figures)
}

fn fillet(gear: &GearRoots) -> Option<Map> {
    let top = 1e-6 * gear.largest()?.largest.stress;
    let rows = &gear.field;
    let z: Vec<f64> = rows.iter().map(|row| 1e3 * row[0].z).collect();
    let tangents = rows[0].iter().map(|point| point.tangent.to_degrees());
    let tangents: Vec<f64> = tangents.collect();
    let along_face = |k: usize| rows.iter().map(move |row| 1e-6 * row[k].stress);
    let values = (0..tangents.len()).flat_map(along_face);
    let map = Map::on_nodes([&z, &tangents], values, top);
    // The outermost nodes lie on the faces.
    Some(map.cut(z[0], z[z.len() - 1]))
}
