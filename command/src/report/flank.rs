//! What happens on the flanks: pressure and load of the contact solver, and the modifications as a gear is inspected.

use gearmesh::contact::SegmentLoad;
use gearmesh::gear::{Flank, PairGeometry};
use gearmesh::pair::Pair;

use super::figure::{Curve, Figure, Height, Map, Patch};
use super::page::Section;
use crate::case::{Case, torque_in_words};

/// Pressures below this are left white, MPa.
const VISIBLE: f64 = 1.0;
const LINE_POSITIONS: [f64; 4] = [0.0, 0.25, 0.5, 0.75];
const TRACE_POINTS: usize = 200;

/// Every loaded segment of the mesh cycle as a patch of gear `i`'s flank: as long as the segment, and as high as the
/// contact moves from one position to the next. `value` is that of a segment, None at a tip edge.
fn pattern(
    geometry: &PairGeometry,
    case: &Case,
    i: usize,
    unit: &str,
    value: impl Fn(&SegmentLoad) -> Option<f64>,
) -> Map {
    let gear = &geometry.gears[i];
    let half_step = 0.5 * geometry.base_pitch() / case.input.positions as f64;
    let diameter = |roll: f64| 2e3 * gear.radius_at_roll(roll);
    let segments = case.cycle.loads.iter().flatten();
    let seen = segments.filter(|s| s.edge.is_some() || s.pressure > VISIBLE * 1e6);
    let patch = |s: &SegmentLoad| {
        let [z0, z1] = s.z.map(|z| 1e3 * z);
        let [low, high] = [-half_step, half_step].map(|step| diameter(s.roll[i] + step));
        Patch {
            corners: [(z0, low), (z1, low), (z1, high), (z0, high)],
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
        labels: ["z (mm)", "diameter (mm)", unit].map(Into::into),
        ends: [z.map(|z| 1e3 * z), [ends[0] - margin, ends[1] + margin]],
        top: patches.iter().filter_map(|p| p.value).fold(1.0, f64::max),
        patches,
    }
}

/// Maps of both gears for each of `cases` on one common scale, titled by `title` of gear and case.
fn patterns(
    geometry: &PairGeometry,
    cases: &[Case],
    unit: &str,
    value: impl Fn(&SegmentLoad) -> Option<f64> + Copy,
    title: impl Fn(usize, &Case) -> String,
) -> Vec<Figure> {
    let gears = |case| (0..2).map(move |i| (case, i));
    let mut all: Vec<(String, Map)> = cases
        .iter()
        .flat_map(gears)
        .map(|(case, i)| (title(i + 1, case), pattern(geometry, case, i, unit, value)))
        .collect();
    let top = all.iter().map(|(_, map)| map.top).fold(0.0, f64::max);
    all.iter_mut().for_each(|(_, map)| map.top = top);
    all.into_iter()
        .map(|(title, map)| Figure::map(title, map))
        .collect()
}

/// Sections on what the flanks carry: `cases` aligned, `tilted` at the limits of the misalignment, `nominal` for the
/// contact lines.
pub fn carried(pair: &Pair, cases: &[Case], nominal: &Case, tilted: &[Case]) -> Vec<Section> {
    let geometry = &pair.geometry;
    let cos_beta_b = geometry.base_helix_angle().cos();
    let pressure = |s: &SegmentLoad| s.edge.is_none().then_some(1e-6 * s.pressure);
    let load = |s: &SegmentLoad| Some(1e-3 * s.line_load(cos_beta_b));
    let torque = |case: &Case| torque_in_words(case.input.torque);
    let note = "Largest pressure that each place of the flank sees over the mesh cycle. Blue: contact reaches the tip edge of this gear, or \
                of its mate where it meets the root; at a sharp edge pressure has no bound, so it is not on the scale. z: from gear 1's \
                z = 0 face.";
    let title = |i, case: &Case| format!("Contact pattern on gear {i} at {}", torque(case));
    let aligned = patterns(geometry, cases, "pressure (MPa)", pressure, title);
    let mut sections = vec![Section::new("Contact pattern", note, aligned)];
    if !tilted.is_empty() {
        let title = |i, case: &Case| {
            let mrad = 1e3 * case.input.misalignment;
            format!("Contact pattern on gear {i} at {mrad:+.2} mrad")
        };
        let note =
            "At the nominal torque and the limits of the misalignment in the plane of action.";
        let figures = patterns(geometry, tilted, "pressure (MPa)", pressure, title);
        sections.push(Section::new(
            "Contact pattern under misalignment",
            note,
            figures,
        ));
    }
    let title = |i, case: &Case| format!("Load distribution on gear {i} at {}", torque(case));
    let note = "Largest normal force per length of contact line that each place of the flank carries over the mesh cycle.";
    let figures = patterns(geometry, cases, "line load (N/mm)", load, title);
    sections.push(Section::new("Load distribution", note, figures));
    let note = format!(
        "At {} and four positions of the mesh; one curve for each tooth pair in contact, up to where contact reaches a tip edge.",
        torque(nominal)
    );
    let lines = LINE_POSITIONS
        .iter()
        .map(|tau| contact_lines(nominal, *tau))
        .collect();
    sections.push(Section::new(
        "Pressure along the contact lines",
        note,
        lines,
    ));
    sections
}

/// Pressure inside the flanks along z for every tooth pair in contact at the position of the cycle nearest below `tau`.
fn contact_lines(case: &Case, tau: f64) -> Figure {
    let position = (tau * case.input.positions as f64) as usize;
    let mut curves: Vec<(i32, Curve)> = Vec::new();
    let inside = case.cycle.loads[position]
        .iter()
        .filter(|s| s.edge.is_none());
    for segment in inside.filter(|s| s.pressure > VISIBLE * 1e6) {
        let point = (
            500.0 * (segment.z[0] + segment.z[1]),
            segment.pressure * 1e-6,
        );
        match curves.last_mut() {
            Some((pair, curve)) if *pair == segment.tooth_pair => curve.points.push(point),
            _ => {
                let label = format!("pair {}", segment.tooth_pair);
                curves.push((segment.tooth_pair, Curve::new(label, [point])));
            }
        }
    }
    Figure::lines(
        &format!(
            "Pressure at mesh position {}",
            case.cycle.mesh_position[position]
        ),
        ["z (mm)", "pressure (MPa)"],
        Height::FromZero(0.0),
        curves.into_iter().map(|(_, curve)| curve).collect(),
    )
}

/// Profile and lead traces of each flank, as an inspection chart has them.
pub fn modifications(pair: &Pair) -> Section {
    let geometry = &pair.geometry;
    let mut figures = Vec::new();
    for (i, gear) in geometry.gears.iter().enumerate() {
        let start = geometry.active_start_roll(i, geometry.center_distance);
        let pitch = gear.roll_length(geometry.operating_pitch_radius(i, geometry.center_distance));
        let trace = |ends: [f64; 2], removal: &dyn Fn(Flank, f64) -> f64| {
            let [drive, coast] = [(Flank::Drive, "drive flank"), (Flank::Coast, "coast flank")]
                .map(|(flank, name)| {
                    let at = |k| ends[0] + (ends[1] - ends[0]) * k as f64 / TRACE_POINTS as f64;
                    let points = (0..=TRACE_POINTS).map(at);
                    Curve::new(name, points.map(|at| (1e3 * at, -1e6 * removal(flank, at))))
                });
            match drive.points == coast.points {
                true => vec![Curve::new("both flanks", drive.points)],
                false => vec![drive, coast],
            }
        };
        let flank = |flank| &pair.microgeometry.flank(flank)[i];
        let profile = trace([start, gear.tip_form_roll()], &|of, roll| {
            flank(of).removal(gear, roll, 0.5 * gear.face_width)
        });
        let lead = trace([0.0, gear.face_width], &|of, z| {
            flank(of).removal(gear, pitch, z)
        });
        for (what, along, curves) in [
            ("Profile", "length of roll (mm)", profile),
            ("Lead", "z from the gear's own z = 0 face (mm)", lead),
        ] {
            figures.push(Figure::lines(
                &format!("{what} of gear {}", i + 1),
                [along, "deviation (um)"],
                Height::Curves(1.0),
                curves,
            ));
        }
    }
    let note = "Deviation from the involute helicoid, material removed downwards: the profile at mid-face from the start of the active \
                profile to the tip, the lead at the pitch point.";
    Section::new("Modifications as inspected (K-chart)", note, figures)
}
