//! What a report shows, section by section: transmission error, stiffness and losses over the mesh cycle and over the operating
//! range, the modifications as a gear is inspected, pressure and load on the flanks, stress in the roots.

use gearmesh::friction::{FrictionLaw, Loss, ohlendorf};
use gearmesh::gear::{Flank, GearKind, PairGeometry};
use gearmesh::words::rounded;
use gearmesh_preprocessor::gear::Pair;
use gearmesh_preprocessor::gear::ToothProfile;
use gearmesh_preprocessor::static_contact::{ContactResult, ContactSolver, SegmentLoad};

use crate::case::{Case, Variant, torque_in_words};
use crate::error::Result;
use crate::page::{Curve, Figure, Height, Map, Patch, Section, charts};

/// Positions over a mesh cycle of the survey: enough for five harmonics and within a few per cent of the peak-to-peak value.
pub const POSITIONS: usize = 24;
const HARMONICS: usize = 3;
/// Least height of an axis of transmission errors, um: what lies below is rounding and the solver's tolerance.
const LEAST_ERROR: f64 = 1e-3;
/// Least height of the axis of the contact's position, over the face width.
const LEAST_WAY: f64 = 0.1;

const TORQUE: &str = "torque on gear 1 (N m)";
const MISALIGNMENT: &str = "misalignment (mrad)";
const POSITION: &str = "mesh position";

/// Pressures below this are left white, MPa.
const VISIBLE: f64 = 1.0;
const LINE_POSITIONS: [f64; 4] = [0.0, 0.25, 0.5, 0.75];
const TRACE_POINTS: usize = 201;

/// Loads at which every variant is shown: those of the operating range of the reported pair.
pub struct Loads {
    pub nominal: f64,
    /// Torques of the curves over the mesh cycle, N m.
    pub torques: Vec<f64>,
    pub survey: Vec<f64>,
    /// Misalignments over their range, rad; empty where there is none.
    pub tilts: Vec<f64>,
    pub speeds: Vec<f64>,
}

pub fn evenly(low: f64, high: f64, count: usize) -> Vec<f64> {
    let step = (high - low) / (count as f64 - 1.0);
    (0..count).map(|i| low + step * i as f64).collect()
}

/// A quantity over the mesh cycle, a curve for every load; the first point is repeated at 1.
fn over_cycle(cases: &[Case], value: impl Fn(&Case, &ContactResult) -> f64) -> Vec<Curve> {
    let mut curves = Vec::new();
    for case in cases {
        let results = &case.cycle.results;
        let results = results.iter().chain(results.first());
        let values = results.map(|result| value(case, result));
        let positions = case.cycle.mesh_position.iter().copied().chain([1.0]);
        // Torques of a survey have no end of digits.
        let torque = format!("{:.3e}", case.load.torque).parse();
        let torque = torque.unwrap_or(case.load.torque);
        curves.push(Curve::new(torque_in_words(torque), positions.zip(values)));
    }
    curves
}

/// What is looked at first.
pub fn overview(cases: &[Case]) -> Section {
    let figures = charts! {
        "Static transmission error about its mean", [POSITION, "STE less its mean (um)"], Height::Curves(LEAST_ERROR)
            => over_cycle(cases, |c, r| 1e6 * (r.approach - c.cycle.mean_ste()));
    };
    let note = "STE: static transmission error on the line of action at mid-face. At mesh position 0 a tooth pair touches at the pitch \
                point; so it is drawn in the transverse section.";
    Section::new("Overview", note, figures)
}

/// The teeth at mesh position 0 in the transverse section at mid-face, seen along the axes, gear 1 on the left. Origin: the pitch
/// point; x from the axis of gear 1 to it.
pub fn teeth_in_mesh(geometry: &PairGeometry) -> Vec<Figure> {
    let c = geometry.center_distance;
    let phi = geometry.operating_pressure_angle(c);
    let path = geometry.path_of_contact(c);
    let mut curves: Vec<Curve> = (0..2)
        .filter_map(|i| {
            let points = outline(geometry, i)?;
            Some(Curve::new(format!("gear {}", i + 1), points))
        })
        .collect();
    let ends = [path.start, path.end].map(|xi| (1e3 * xi * phi.sin(), 1e3 * xi * phi.cos()));
    curves.push(Curve::new("path of contact", ends));
    charts! { "Teeth in mesh", ["x from the pitch point (mm)", "y (mm)"], Height::ToScale => curves; }
}

/// Outline of the teeth of gear `i` next to the pitch point, mm, in the frame of [`teeth_in_mesh`]; None where the gear has no
/// usable profile.
fn outline(geometry: &PairGeometry, i: usize) -> Option<Vec<(f64, f64)>> {
    /// Teeth to either side of the one in contact.
    const TEETH: i32 = 1;
    const POINTS: usize = 12;
    let gear = &geometry.gears[i];
    let profile = ToothProfile::new(gear).ok()?;
    let pitch_radius = geometry.operating_pitch_radius(i, geometry.center_distance);
    let half_tooth = profile
        .point_on_flank(gear.roll_length(pitch_radius))
        .angle();
    // The drive flank of gear 1 faces +y and that of gear 2 -y.
    let middle = if i == 0 { -half_tooth } else { half_tooth };
    // Gear 2 of an external pair lies on the right.
    let side = if i == 1 && geometry.ring().is_none() {
        -1.0
    } else {
        1.0
    };
    let half: Vec<[f64; 2]> = std::iter::once([gear.root_radius(), profile.half_pitch()])
        .chain(evenly(0.0, 1.0, POINTS).into_iter().map(|t| {
            let point = profile.fillet(t);
            [point.radius(), point.angle()]
        }))
        .chain(
            evenly(
                profile.form_roll(),
                gear.roll_length(gear.tip_radius),
                POINTS,
            )
            .into_iter()
            .map(|roll| {
                let point = profile.point_on_flank(roll);
                [point.radius(), point.angle()]
            }),
        )
        .collect();
    let points = (-TEETH..=TEETH).flat_map(|n| {
        let centre = middle + f64::from(n) * 2.0 * profile.half_pitch();
        let low = half.iter().map(move |[r, angle]| (*r, centre - angle));
        let high = half
            .iter()
            .rev()
            .map(move |[r, angle]| (*r, centre + angle));
        low.chain(high).collect::<Vec<_>>()
    });
    Some(
        points
            .map(|(r, angle)| {
                let x = side * (r * angle.cos() - pitch_radius);
                (1e3 * x, 1e3 * r * angle.sin())
            })
            .collect(),
    )
}

pub fn cycle(variant: &Variant, cases: &[Case]) -> Section {
    let least_way = LEAST_WAY * 1e3 * variant.geometry().face_overlap().1;
    let mut figures = charts! {
        "Mesh stiffness", [POSITION, "stiffness (N/um)"], Height::FromZero(0.0)
            => over_cycle(cases, |_, r| 1e-6 * r.tangent.force_by_approach);
        "Contact position along the face", [POSITION, "z_c (mm)"], Height::Curves(least_way)
            => over_cycle(cases, |_, r| 1e3 * r.contact_z);
    };
    if let Variant::Pair(..) = variant {
        figures.extend(charts! {
            "Load share of one tooth pair", [POSITION, "share of the load"], Height::FromZero(0.0)
                => cases.iter().map(load_share).collect();
        });
    }
    let note = "Stiffness: tangent, dF/d(STE), on the line of action. z_c: axial position of the resultant force, from gear 1's z = 0 \
                face. The load share is that of the tooth pair that touches at the pitch point at mesh position 0, from the start of \
                its contact to the end.";
    Section::new("Over the mesh cycle", note, figures)
}

fn load_share(case: &Case) -> Curve {
    let shares = case.cycle.results.iter().enumerate().flat_map(|(i, r)| {
        let shares = r.load_share.iter();
        shares.map(move |&(pair, share)| (i, pair, share))
    });
    let curve = through_mesh(case, shares);
    // Keep one point without load at either side.
    let all = curve.points.len();
    let mut loaded = (0..all).filter(|i| curve.points[*i].1 > 0.0);
    let (first, last) = (loaded.clone().next(), loaded.next_back());
    let start = first.unwrap_or(0).saturating_sub(1);
    let points = curve.points[start..all.min(last.unwrap_or(all) + 2)].to_vec();
    Curve { points, ..curve }
}

/// Values of one tooth pair through the mesh: pair k at position tau is pair 0 at tau + k.
pub fn through_mesh(case: &Case, values: impl Iterator<Item = (usize, i32, f64)>) -> Curve {
    let positions = &case.cycle.mesh_position;
    let points = values.map(|(i, pair, value)| (positions[i] + f64::from(pair), value));
    let mut curve = Curve::new(torque_in_words(case.load.torque), points);
    curve.points.sort_by(|a, b| a.0.total_cmp(&b.0));
    curve
}

/// Peak-to-peak value and harmonics of each of `cases` over `x`; in um, or of the harmonics alone in dB.
fn amplitudes(variant: &Variant, x: &[f64], cases: &[Case], in_db: bool) -> Vec<Curve> {
    let teeth = variant.geometry().gears[0].teeth as usize;
    let mut curves = Vec::new();
    for h in 1..=HARMONICS {
        let values = cases.iter().map(|case| {
            let amplitude = case.cycle.harmonics()[h - 1].map_or(f64::NAN, |h| 1e6 * h.amplitude);
            match in_db {
                true => 20.0 * amplitude.log10(),
                false => amplitude,
            }
        });
        let points = x.iter().copied().zip(values);
        curves.push(Curve::new(format!("order {}", h * teeth), points));
    }
    if !in_db {
        let values = cases.iter().map(|case| 1e6 * case.cycle.peak_to_peak_ste());
        curves.push(Curve::new("peak to peak", x.iter().copied().zip(values)));
    }
    curves
}

pub fn torque(variant: &Variant, loads: &Loads, survey: &[Case]) -> Section {
    let mut figures = charts! {
        "Orders of the STE over torque", [TORQUE, "amplitude (um)"], Height::FromZero(LEAST_ERROR)
            => amplitudes(variant, &loads.survey, survey, false);
        "Orders of the STE over torque in dB", [TORQUE, "amplitude (dB re 1 um)"], Height::Curves(1.0)
            => amplitudes(variant, &loads.survey, survey, true);
    };
    // Overlap evens the curves of helical pairs out: beside their means nothing of them would be seen.
    let is_helical = variant.geometry().overlap_ratio() > 0.0;
    let label = if is_helical {
        "STE less its mean (um)"
    } else {
        "STE (um)"
    };
    figures.extend(charts! {
        "Harris map", [POSITION, label], Height::Curves(LEAST_ERROR) => over_cycle(survey, |c, r| {
            let mean = if is_helical { c.cycle.mean_ste() } else { 0.0 };
            1e6 * (r.approach - mean)
        });
    });
    let note = "Aligned, on the line of action. Orders are those of gear 1: its number of teeth is the mesh frequency, twice that its second \
                harmonic. Harris map: STE over the mesh cycle for torques up to the largest, of helical pairs less the mean of each torque.";
    Section::new("Over torque", note, figures)
}

pub fn misalignment(variant: &Variant, loads: &Loads) -> Result<Section> {
    let mrad: Vec<f64> = loads.tilts.iter().map(|m| 1e3 * m).collect();
    let tilted = variant.cases(&[loads.nominal], &loads.tilts, POSITIONS)?;
    let all = variant.cases(&loads.survey, &loads.tilts, POSITIONS)?;
    let swings = all.iter().map(|case| 1e6 * case.cycle.peak_to_peak_ste());
    let figures = charts! {
        "Orders of the STE over misalignment", [MISALIGNMENT, "amplitude (um)"], Height::FromZero(LEAST_ERROR)
            => amplitudes(variant, &mrad, &tilted, false);
        "Peak-to-peak STE over misalignment and torque", [MISALIGNMENT, TORQUE, "p-p STE (um)"]
            => Map::on_nodes([&mrad, &loads.survey], swings, LEAST_ERROR);
    };
    let torque = torque_in_words(loads.nominal);
    let note = format!("Misalignment in the plane of action. The orders are those at {torque}.");
    Ok(Section::new("Over misalignment", note, figures))
}

pub fn losses(pair: &Pair, solver: &ContactSolver, loads: &Loads, survey: &[Case]) -> Section {
    // A constant coefficient loses the same share at every speed.
    let speeds: &[f64] = match pair.friction {
        FrictionLaw::Constant { .. } => &loads.speeds[loads.speeds.len() - 1..],
        _ => &loads.speeds,
    };
    let even = ohlendorf(&pair.geometry, pair.geometry.center_distance);
    let figures = charts! {
        "Power lost", [TORQUE, "power lost (W)"], Height::FromZero(0.0)
            => loss_over_torque(pair, survey, &loads.speeds, |loss| loss.power);
        "Power lost over that transmitted", [TORQUE, "power lost (%)"], Height::FromZero(0.0)
            => loss_over_torque(pair, survey, speeds, |loss| 100.0 * (1.0 - loss.efficiency));
        "Loss factor", [TORQUE, "loss factor"], Height::FromZero(0.0) => vec![
            Curve::new("by the load share", survey.iter().map(|case| (case.load.torque, case.loss_factor(solver)))),
            Curve::new("Ohlendorf", survey.iter().map(|case| (case.load.torque, even))),
        ];
    };
    let note = format!(
        "Friction between the teeth alone, the mean over the mesh cycle, aligned. Coefficient of friction: {}. The loss factor is the share \
         of the power that is lost at a coefficient of 1: by the share of the load as it is, and with load shared evenly (Ohlendorf).",
        pair.friction
    );
    Section::new("Losses over torque", note, figures)
}

/// A part of the loss over the torque of the `survey`, a curve for each of `speeds` of gear 1, rpm.
fn loss_over_torque(
    pair: &Pair,
    survey: &[Case],
    speeds: &[f64],
    part: fn(&Loss) -> f64,
) -> Vec<Curve> {
    speeds
        .iter()
        .map(|rpm| {
            let losses = survey.iter().map(|case| part(&case.loss(pair, *rpm)));
            let torques = survey.iter().map(|case| case.load.torque);
            Curve::new(format!("{} rpm", rounded(*rpm)), torques.zip(losses))
        })
        .collect()
}

/// Maps of both gears for each of `cases` on one common scale, titled `what` it is, gear and `load` of the case. Every loaded
/// segment of the mesh cycle is a patch, as high as the contact moves from one position to the next; `value` is None at a tip edge.
fn patterns(
    geometry: &PairGeometry,
    cases: &[Case],
    [what, unit]: [&str; 2],
    load: impl Fn(&Case) -> String,
    value: impl Fn(&SegmentLoad) -> Option<f64>,
) -> Vec<Figure> {
    let c = geometry.center_distance;
    let path = geometry.path_of_contact(c);
    let mut maps = Vec::new();
    for (case, i) in cases.iter().flat_map(|case| [(case, 0), (case, 1)]) {
        let gear = &geometry.gears[i];
        let half_step = 0.5 * geometry.base_pitch() / case.input.positions as f64;
        let diameter = |roll: f64| 2e3 * gear.radius_at_roll(roll);
        let segments = (case.cycle.results.iter()).flat_map(|result| &result.segments);
        let seen = segments.filter(|s| s.edge.is_some() || s.pressure > VISIBLE * 1e6);
        let mut ends = [path.start, path.end].map(|xi| diameter(geometry.roll_at(i, c, xi)));
        ends.sort_by(f64::total_cmp);
        let margin = 0.06 * (ends[1] - ends[0]);
        let z = [gear.face_offset, gear.face_offset + gear.face_width];
        let ends = [z.map(|z| 1e3 * z), [ends[0] - margin, ends[1] + margin]];
        let title = format!("{what} on gear {} at {}", i + 1, load(case));
        let end_names = match gear.kind {
            GearKind::External => ["root", "tip"],
            GearKind::Ring => ["tip", "root"],
        };
        let patches: Vec<Patch> = seen
            .map(|s| {
                let along_profile = [-half_step, half_step].map(|step| diameter(s.roll[i] + step));
                Patch::new([s.z.map(|z| 1e3 * z), along_profile], value(s))
            })
            .collect();
        maps.push((title, ends, end_names, patches));
    }
    let patches = maps.iter().flat_map(|(.., patches)| patches);
    let top = patches.filter_map(|p| p.value).fold(1.0, f64::max);
    let labels = ["z (mm)", "diameter (mm)", unit];
    maps.into_iter().flat_map(|(title, ends, end_names, patches)| charts! { title, labels => Map { ends, end_names, patches, top }; }).collect()
}

/// Title and unit of the maps of pressure.
const PATTERN: [&str; 2] = ["Contact pattern", "pressure (MPa)"];

pub const PATTERN_NOTE: &str = "Contact pattern: largest pressure that each point of the flank sees over the mesh cycle. Blue: contact reaches the tip \
    edge of this gear, or of its mate where it meets the root; at a sharp edge pressure has no bound, so it is not on the scale. z: \
    from gear 1's z = 0 face.";

/// Contact pattern of both gears for each of `cases`, titled by the `load` of the case.
pub fn contact_patterns(
    geometry: &PairGeometry,
    cases: &[Case],
    load: impl Fn(&Case) -> String,
) -> Vec<Figure> {
    patterns(geometry, cases, PATTERN, load, |s| {
        s.edge.is_none().then_some(1e-6 * s.pressure)
    })
}

/// What the flanks carry: `cases` aligned at other torques than the nominal one, `tilted` at the limits of the misalignment, `nominal` for load distribution and contact
/// lines.
pub fn carried(pair: &Pair, cases: &[Case], nominal: &Case, tilted: &[Case]) -> Vec<Section> {
    let geometry = &pair.geometry;
    let cos_beta_b = geometry.base_helix_angle().cos();
    let distribution = ["Load distribution", "line load (N/mm)"];

    let mut sections = Vec::new();
    if !cases.is_empty() {
        let heading = "Contact pattern at other torques";
        let figures = contact_patterns(geometry, cases, Case::torque_in_words);
        sections.push(Section::new(heading, PATTERN_NOTE, figures));
    }
    if !tilted.is_empty() {
        let heading = "Contact pattern under misalignment";
        let note =
            "At the nominal torque and the limits of the misalignment in the plane of action.";
        let figures = contact_patterns(geometry, tilted, |case| {
            format!("{:+.2} mrad", 1e3 * case.load.misalignment)
        });
        sections.push(Section::new(heading, note, figures));
    }
    let note = "Largest normal force per length of contact line that each point of the flank carries over the mesh cycle.";
    let figures = patterns(
        geometry,
        std::slice::from_ref(nominal),
        distribution,
        Case::torque_in_words,
        |s| Some(1e-3 * s.line_load(cos_beta_b)),
    );
    sections.push(Section::new("Load distribution", note, figures));
    let note = format!(
        "At {} and four positions of the mesh; one curve for each tooth pair in contact, up to where contact reaches a tip edge.",
        nominal.torque_in_words()
    );
    let lines = LINE_POSITIONS.map(|tau| contact_lines(nominal, tau));
    let heading = "Pressure along the contact lines";
    sections.push(Section::new(heading, note, lines.concat()));
    sections
}

/// Pressure inside the flanks along z for every tooth pair in contact at the position of the cycle nearest below `tau`.
fn contact_lines(case: &Case, tau: f64) -> Vec<Figure> {
    let i = (tau * case.input.positions as f64) as usize;
    let segments: Vec<&SegmentLoad> = case.cycle.results[i]
        .segments
        .iter()
        .filter(|s| s.edge.is_none() && s.pressure > VISIBLE * 1e6)
        .collect();
    let mut curves = Vec::new();
    for pair in segments.chunk_by(|a, b| a.tooth_pair == b.tooth_pair) {
        let points = pair
            .iter()
            .map(|s| (500.0 * (s.z[0] + s.z[1]), s.pressure * 1e-6));
        curves.push(Curve::new(format!("pair {}", pair[0].tooth_pair), points));
    }
    let position = case.cycle.mesh_position[i];
    charts! {
        format!("Pressure at mesh position {position}"), ["z (mm)", "pressure (MPa)"], Height::FromZero(0.0)
            => curves;
    }
}

pub fn modifications(pair: &Pair) -> Section {
    let geometry = &pair.geometry;
    let mut figures = Vec::new();
    for (i, gear) in geometry.gears.iter().enumerate() {
        let start = geometry.active_start_roll(i, geometry.center_distance);
        let pitch = gear.roll_length(geometry.operating_pitch_radius(i, geometry.center_distance));
        let middle = 0.5 * gear.face_width;
        let profile = trace(pair, i, [start, gear.tip_form_roll()], |roll| {
            [roll, middle]
        });
        let lead = trace(pair, i, [0.0, gear.face_width], |z| [pitch, z]);
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

/// Deviation of the flanks of gear `i` from `ends[0]` to `ends[1]` of a coordinate, m, with roll length and z of its points; one curve
/// where both flanks are alike.
fn trace(pair: &Pair, i: usize, ends: [f64; 2], place: impl Fn(f64) -> [f64; 2]) -> Vec<Curve> {
    let gear = &pair.geometry.gears[i];
    let flanks = [(Flank::Drive, "drive flank"), (Flank::Coast, "coast flank")];
    let [drive, coast] = flanks.map(|(flank, name)| {
        let m = &pair.microgeometry.flank(flank)[i];
        let along = evenly(ends[0], ends[1], TRACE_POINTS).into_iter();
        let points = along.map(|s| {
            let [roll, z] = place(s);
            (1e3 * s, -1e6 * m.removal(gear, roll, z))
        });
        Curve::new(name, points)
    });
    match drive.points == coast.points {
        true => vec![Curve::new("both flanks", drive.points)],
        false => vec![drive, coast],
    }
}

/// Stress of one tooth of either gear through the mesh, and the fillets where it is largest at the torque `nominal`.
pub fn roots(cases: &[Case], nominal: f64) -> Section {
    let mut curves = [vec![], vec![]];
    for case in cases {
        for (gear, curves) in case.roots.iter().flatten().zip(&mut curves) {
            let teeth = gear.teeth.iter();
            let stresses = teeth.map(|t| (t.position, t.tooth_pair, 1e-6 * t.largest.stress));
            curves.push(through_mesh(case, stresses));
        }
    }
    let [first, second] = curves;
    let labels = ["mesh position of the tooth", "root stress (MPa)"];
    let mut figures = charts! {
        "Root stress of gear 1", labels, Height::FromZero(0.0) => first;
        "Root stress of gear 2", labels, Height::FromZero(0.0) => second;
    };
    let nominal = cases.iter().find(|case| case.load.torque == nominal);
    let gears = nominal.and_then(|case| case.roots.as_ref());
    for (i, gear) in gears.into_iter().flatten().enumerate() {
        let Some(largest) = gear.largest() else {
            continue;
        };
        let rows = &gear.field;
        let z: Vec<f64> = rows.iter().map(|row| 1e3 * row[0].z).collect();
        let tangents = rows[0].iter().map(|point| point.tangent.to_degrees());
        let tangents: Vec<f64> = tangents.collect();
        let values =
            (0..tangents.len()).flat_map(|k| rows.iter().map(move |row| 1e-6 * row[k].stress));
        let map = Map::on_nodes([&z, &tangents], values, 1e-6 * largest.largest.stress);
        // The outermost nodes lie on the faces.
        let map = map.cut(z[0], z[z.len() - 1]);
        figures.extend(charts! {
            format!("Fillet of gear {} at the largest root stress", i + 1), ["z (mm)", "tangent (deg)", "root stress (MPa)"] => map;
        });
    }
    let note = "Largest principal stress in the fillet of one tooth of either gear on its way through the mesh, from finite elements; at 0 its \
                tooth pair touches at the pitch point at mid-face. Fillets: over the face and over the angle of the fillet's tangent \
                with the tooth's centre line (90 degrees: root circle), at the nominal torque and the mesh position where the stress is \
                largest.";
    Section::new("Tooth root stress", note, figures)
}
