//! What can be said of each number of the file on its own, before any geometry is built from it.

use super::error::{Refusal, ensure, refusal};
use super::file::{Dimension, EndReliefFile, FlankFile, GearFile, Meshing, PairFile, ReliefFile};
use gearmesh::words::{number, rounded};

/// Numbers that a field may have, as the file writes them.
#[derive(Debug, Clone, Copy)]
pub(super) enum Range {
    /// Both ends included.
    Within(f64, f64),
    /// Above 0.
    UpTo(f64),
}
use Range::{UpTo, Within};

/// Checks the number at `path`, if there is one.
pub(super) fn check(
    path: &str,
    value: impl Into<Option<f64>>,
    range: Range,
) -> Result<(), Refusal> {
    let Some(value) = value.into() else {
        return Ok(());
    };
    let (limits, problem) = match range {
        // As they are shown: 0.1 * 1.5 is not quite 0.15.
        Within(low, high) => {
            let [low, high] = [low, high].map(rounded);
            ([low, high], format!("lies outside {low} to {high}"))
        }
        UpTo(high) => {
            let problem = format!("must be above 0 and at most {high}");
            ([f64::MIN_POSITIVE, high], problem)
        }
    };
    let otherwise = "give a value in that range, in the unit of the name";
    let remedy = remedy(path, value, limits, otherwise);
    ensure!(within(value, limits), path => value; "{problem}"; "{remedy}");
    Ok(())
}

fn within(value: f64, [low, high]: [f64; 2]) -> bool {
    (low..=high).contains(&value)
}

/// Checks fields of a part of the file, whose path is given with a point, or nothing: `field: range;` for each, with what
/// makes a number of another type after `via`.
macro_rules! limits {
    ($path:expr, $part:expr; $($field:ident $(via $number:path)?: $range:expr;)*) => {
        $($crate::pair::checks::check(
            &format!("{}{}", $path, stringify!($field)), $part.$field$(.map($number))?, $range,
        )?;)*
    };
}
pub(super) use limits;

/// Units in which numbers are given by mistake: how the names of fields with another unit end, that unit, the mistaken one,
/// and how many of the first it is.
const MISTAKEN: [(&str, &str, &str, f64); 10] = [
    ("_mm", "mm", "m", 1e3),
    ("_mm", "mm", "inch", 25.4),
    ("diameter_mm", "mm in diameter", "mm in radius", 2.0),
    ("_um", "um", "mm", 1e3),
    ("_deg", "deg", "rad", 180.0 / std::f64::consts::PI),
    ("_mrad", "mrad", "rad", 1e3),
    ("_gpa", "GPa", "MPa", 1e-3),
    ("_gpa", "GPa", "Pa", 1e-9),
    ("_nm", "N m", "N mm", 1e-3),
    ("_nm", "N m", "kN m", 1e3),
];

/// What a suspicious `value` of `field` is in a mistaken unit, if that lies within `expected`.
pub(super) fn meant(field: &str, value: f64, expected: [f64; 2]) -> Option<String> {
    let (_, unit, mistaken, factor) = MISTAKEN
        .iter()
        .find(|(end, .., factor)| field.ends_with(end) && within(value * factor, expected))?;
    let right = rounded((value * factor * 1e3).round() * 1e-3);
    Some(format!("{value} {mistaken} is {right} {unit}"))
}

/// Values as they are where `usual` is.
pub(super) fn about(usual: f64) -> [f64; 2] {
    [usual / 1.3, usual * 1.3]
}

/// The remedy for a `value` of `field`: as what it is [`meant`], else `otherwise`.
pub(super) fn remedy(field: &str, value: f64, expected: [f64; 2], otherwise: &str) -> String {
    meant(field, value, expected).map_or_else(
        || otherwise.to_owned(),
        |meant| format!("give it in the unit of the name: {meant}"),
    )
}

/// What a suspiciously small `value` of `field`, less than `least`, is in a mistaken unit in which it is more.
pub(super) fn suspicious(field: &str, value: f64, least: f64) -> Option<String> {
    let expected = match value > 0.0 {
        true => [least, f64::INFINITY],
        false => [f64::NEG_INFINITY, -least],
    };
    meant(field, value, expected).filter(|_| value != 0.0 && value.abs() < least)
}

/// A note on such a value.
pub(super) fn note(field: &str, value: f64, least: f64) -> Option<String> {
    let meant = suspicious(field, value, least)?;
    Some(format!(
        "`{field}` = {value} is a suspicious value: {meant}; give it in the unit of the name"
    ))
}

/// Less than this is no helix angle in degrees that teeth have, but may be one in radians.
pub(super) const LEAST_HELIX: f64 = 1.05;

/// Notes on numbers of the file that are suspiciously small.
pub(super) fn notes(file: &PairFile) -> Vec<String> {
    // The end of a range that is farther from nominal.
    let farther = |[low, high]: [f64; 2]| if high >= -low { high } else { low };
    let (o, number) = (&file.operating, |field: Option<f64>| field.unwrap_or(0.0));
    let [offset, tilt] = [o.center_distance_offset_um, o.misalignment_mrad].map(farther);
    let rows = [
        ("helix_angle_deg", number(file.helix_angle_deg), LEAST_HELIX),
        ("backlash_um", number(file.backlash_um), 1.0),
        ("operating.center_distance_offset_um", offset, 0.1),
        ("operating.misalignment_mrad", tilt, 0.02),
    ];
    let mut notes: Vec<_> = rows
        .map(|(field, value, least)| note(field, value, least))
        .into();
    for i in 0..2 {
        for (prefix, flank) in file.gear(i).flanks() {
            for (field, um, _) in amounts(&flank, 0.0) {
                notes.push(note(&in_gear(i, &format!("{prefix}{field}")), um, 0.1));
            }
        }
    }
    notes.into_iter().flatten().collect()
}

/// "gear1.<name>" or "gear2.<name>".
pub(super) fn in_gear(i: usize, name: &str) -> String {
    format!("gear{}.{name}", i + 1)
}

/// Torques on gear 1 other than 0, N m. Below, the rounding of lengths outweighs what the teeth give way.
pub const TORQUES: [f64; 2] = [1e-9, 1e9];

/// Checks every field of the file by itself.
pub(super) fn check_fields(file: &PairFile) -> Result<(), Refusal> {
    let printable = |c: char| !c.is_control() && !"/\\:*?\"<>|".contains(c);
    let name = &file.name;
    ensure!(!name.trim().is_empty() && name.chars().count() <= 100 && name.chars().all(printable),
        "name" => format!("{name:?}");
        "cannot serve as a file name";
        "give 1 to 100 characters without / \\ : * ? \" < > |");
    let module = file.normal_module_mm;
    limits! { "", file;
        // Smaller ones than any tooth has are metres.
        normal_module_mm: Within(0.02, 1000.0);
        normal_pressure_angle_deg: Within(10.0, 35.0);
        helix_angle_deg: Within(-60.0, 60.0);
        center_distance_mm: UpTo(1e5);
        backlash_um: Within(0.0, 250.0 * module);
        face_offset_mm: Within(-1e4, 1e4);
        normal_backlash_um via Dimension::middle: Within(0.0, 250.0 * module);
    }
    for i in 0..2 {
        check_gear(i, file.gear(i), module)?;
        check_amounts(i, file.gear(i), module)?;
    }
    check_held_surfaces(file)?;
    check_operating(file)
}

fn check_gear(i: usize, g: &GearFile, module: f64) -> Result<(), Refusal> {
    let gear = in_gear(i, "");
    ensure!((4..=5000).contains(&g.teeth), format!("{gear}teeth") => g.teeth;
        "lies outside 4 to 5000"; "give the number of teeth, positive for a ring, too");
    if let (Some(addendum), Some(mm)) = (g.addendum_coefficient, g.tip_diameter_mm) {
        return Err(refusal!(format!("{gear}addendum_coefficient") => addendum;
            "`tip_diameter_mm` = {mm} says the same"; "give only one of them"));
    }
    limits! { gear, g;
        profile_shift: Within(-3.0, 3.0);
        profile_shift_iso_21771: Within(-3.0, 3.0);
        ball_diameter_mm: UpTo(5.0 * module);
        face_width_mm: UpTo(1e4);
        // Beyond a hundred modules of face the elastic model outgrows memory.
        face_width_mm: Within(0.05 * module, 100.0 * module);
        tip_diameter_mm: UpTo(1e5);
        addendum_coefficient: UpTo(3.0);
        dedendum_coefficient: UpTo(3.0);
        tool_tip_radius_coefficient: Within(0.0, 1.0);
        bore_diameter_mm: UpTo(1e5);
        rim_diameter_mm: UpTo(1e5);
        youngs_modulus_gpa: UpTo(2000.0);
        poisson_ratio: Within(0.0, 0.49);
        span_teeth via f64::from: Within(1.0, f64::from(g.teeth));
        normal_tooth_thickness_mm via Dimension::middle: UpTo(1e5);
        span_measurement_mm via Dimension::middle: UpTo(1e5);
        dimension_over_balls_mm via Dimension::middle: UpTo(1e5);
        root_diameter_mm via Dimension::middle: UpTo(1e5);
    }
    Ok(())
}

/// Removal over the length of roll or of the face within which it grows, at most.
pub(super) const STEEPEST: f64 = 0.1;

/// Amounts of microgeometry: no more than a twentieth of the module, beyond which the flank is another flank and
/// no modification; those that only take material off not negative.
fn check_amounts(i: usize, g: &GearFile, module: f64) -> Result<(), Refusal> {
    let most = 50.0 * module;
    for (prefix, flank) in g.flanks() {
        let path = in_gear(i, prefix);
        for (field, um, low) in amounts(&flank, -most) {
            let problem = match um < low && low == 0.0 {
                true => "adds material".into(),
                false => format!(
                    "exceeds a twentieth of the normal module, {} um",
                    rounded(most)
                ),
            };
            ensure!(um >= low && um <= most, format!("{path}{field}") => um;
                "{problem}";
                "give the removal normal to the flank in micrometres, positive, as for a modification of the flank");
        }
        let ends = [
            ("end_relief", &flank.end_relief),
            ("lower_end_relief", &flank.lower_end_relief),
            ("upper_end_relief", &flank.upper_end_relief),
        ];
        for (field, relief) in ends {
            let Some(relief) = relief else { continue };
            let (um, mm) = (relief.amount_um, relief.length_mm);
            let field = format!("{path}{field}.length_mm");
            let (least, longest) = (1e-3 * um / STEEPEST, 0.5 * g.face_width_mm);
            ensure!(mm > 0.0 && mm <= longest, &field => mm;
                "must be above 0 and at most half of the face width, {} mm", rounded(longest);
                "shorten the end relief, or use `lead_crowning_um` over the whole face");
            ensure!(mm >= least, &field => number(mm);
                "is steeper than one in ten under {um} um: a chamfer, and no relief";
                "give at least {} mm, or a smaller amount", rounded(least));
        }
    }
    Ok(())
}

/// Field, amount in um and least amount of every modification that is given; those of either sign may go down to
/// `least`.
fn amounts(f: &FlankFile, least: f64) -> impl Iterator<Item = (&'static str, f64, f64)> {
    let profile = |relief: &Option<ReliefFile>| Some(relief.as_ref()?.amount_um);
    let end = |relief: &Option<EndReliefFile>| Some(relief.as_ref()?.amount_um);
    let rows = [
        ("tip_relief.amount_um", profile(&f.tip_relief), 0.0),
        ("root_relief.amount_um", profile(&f.root_relief), 0.0),
        ("end_relief.amount_um", end(&f.end_relief), 0.0),
        ("lower_end_relief.amount_um", end(&f.lower_end_relief), 0.0),
        ("upper_end_relief.amount_um", end(&f.upper_end_relief), 0.0),
        ("profile_crowning_um", f.profile_crowning_um, 0.0),
        ("profile_slope_um", f.profile_slope_um, least),
        ("bias_um", f.bias_um, least),
        ("lead_crowning_um", f.lead_crowning_um, 0.0),
        ("lead_slope_um", f.lead_slope_um, least),
    ];
    (rows.into_iter()).filter_map(|(field, um, least)| Some((field, um?, least)))
}

/// Bore or rim: which of them a gear may have says whether it is a ring.
fn check_held_surfaces(file: &PairFile) -> Result<(), Refusal> {
    let is_internal = file.meshing == Meshing::Internal;
    for i in 0..2 {
        let (g, mate) = (file.gear(i), file.gear(1 - i));
        let bore = g.bore_diameter_mm;
        if let Some(rim) = g.rim_diameter_mm {
            let field = in_gear(i, "rim_diameter_mm");
            ensure!(bore.is_none(), field => rim;
                "the gear has a `bore_diameter_mm`, too"; "give a bore for an external gear, a rim for a ring");
            ensure!(is_internal, field => rim;
                "both gears of an external pair are held at their bore";
                "give `bore_diameter_mm`, or say `\"meshing\": \"internal\"`");
            ensure!(mate.rim_diameter_mm.is_none(), field => rim;
                "the mate has a rim, too, and an internal pair has one ring";
                "give the external gear a `bore_diameter_mm` instead");
        }
        ensure!(file.ring() != Some(i) || bore.is_none(), in_gear(i, "bore_diameter_mm") => bore.unwrap_or(0.0);
            "the gear is the ring of this internal pair and is held at its outer rim";
            "give it `rim_diameter_mm`, or give that to the mate if that is the ring");
    }
    Ok(())
}

fn check_operating(file: &PairFile) -> Result<(), Refusal> {
    let (o, [least, most]) = (&file.operating, TORQUES);
    let nominal = o.nominal_torque_nm;
    ensure!((least..=most).contains(&nominal), "operating.nominal_torque_nm" => number(nominal);
        "lies outside {least:e} to {most:e}"; "give the torque on gear 1 in N m, above 0");
    ensure!((nominal..=most).contains(&o.maximum_torque_nm), "operating.maximum_torque_nm" => o.maximum_torque_nm;
        "is no limit above the nominal torque, {nominal}"; "give at least the nominal torque, on gear 1");
    let offset = o.center_distance_offset_um;
    for (name, [low, high], most) in [
        ("center_distance_offset_um", offset, 1e4),
        ("misalignment_mrad", o.misalignment_mrad, 20.0),
    ] {
        let (field, value) = (format!("operating.{name}"), format!("[{low}, {high}]"));
        ensure!(low <= high, field => value; "is reversed"; "give the lower end first");
        ensure!(low <= 0.0 && high >= 0.0, field => value;
            "does not contain zero, the nominal state";
            "give deviations from nominal, such as [-1.0, 1.0] or [0.0, 0.0]");
        ensure!(low >= -most && high <= most, field => value;
            "goes beyond {most} on one side"; "narrow the range; check the unit in the name");
    }
    Ok(())
}
