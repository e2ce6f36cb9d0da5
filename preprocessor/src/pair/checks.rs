//! Refusals, and what can be said of each number of the file on its own, before any geometry is built from it.

use super::dimension::Dimension;
use super::file::{FlankFile, GearFile, Meshing, OperatingFile, PairFile};
use gearmesh::words::{number, rounded};

/// One value that cannot be, and what to do about it.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("pair file: `{field}` = {value}: {problem}; {remedy}")]
pub struct Refusal {
    /// Path of the field, such as `gear1.teeth`.
    pub field: String,
    /// The value given, or the default that stood in for it, in the unit of the field.
    pub value: String,
    /// What is wrong with it.
    pub problem: String,
    /// What to change.
    pub remedy: String,
}

/// All refusals of a file that could be found, at least one, each of another field or value.
#[derive(Debug, Clone, PartialEq)]
pub struct Refusals(Vec<Refusal>);

/// Most refusals in one message.
const MOST_SHOWN: usize = 20;

impl Refusals {
    /// The refusals in the order in which they were found.
    pub fn all(&self) -> &[Refusal] {
        &self.0
    }

    /// Makes each of them another one.
    pub(super) fn map(self, change: impl Fn(Refusal) -> Refusal) -> Refusals {
        Refusals(self.0.into_iter().map(change).collect())
    }

    /// These and those of `more` that are new: of one field and value the first counts.
    pub(super) fn and(mut self, more: Refusals) -> Refusals {
        for refusal in more.0 {
            let mut all = self.0.iter();
            if !all.any(|known| known.field == refusal.field && known.value == refusal.value) {
                self.0.push(refusal);
            }
        }
        self
    }
}

impl From<Refusal> for Refusals {
    fn from(refusal: Refusal) -> Refusals {
        Refusals(vec![refusal])
    }
}

impl std::error::Error for Refusals {}

impl std::fmt::Display for Refusals {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        for (k, refusal) in self.0.iter().take(MOST_SHOWN).enumerate() {
            write!(f, "{}{refusal}", if k > 0 { "\n" } else { "" })?;
        }
        match self.0.len().saturating_sub(MOST_SHOWN) {
            0 => Ok(()),
            more => write!(f, "\nand {more} more"),
        }
    }
}

/// Both results, or the refusals of both.
pub(super) fn both<A, B>(
    a: Result<A, impl Into<Refusals>>,
    b: Result<B, impl Into<Refusals>>,
) -> Result<(A, B), Refusals> {
    match (a.map_err(Into::into), b.map_err(Into::into)) {
        (Ok(a), Ok(b)) => Ok((a, b)),
        (Err(a), Err(b)) => Err(a.and(b)),
        (Err(refusals), _) | (_, Err(refusals)) => Err(refusals),
    }
}

/// All results, or the refusals of all.
pub(super) fn every<T>(
    results: impl IntoIterator<Item = Result<T, impl Into<Refusals>>>,
) -> Result<Vec<T>, Refusals> {
    let mut all = Ok(Vec::new());
    for one in results {
        all = both(all, one).map(|(mut all, one)| {
            all.push(one);
            all
        });
    }
    all
}

/// The refusal of a value: field `=>` value; problem; remedy, both as for `format!`.
macro_rules! refusal {
    ($field:expr => $value:expr; $problem:literal $(, $p:expr)*; $remedy:literal $(, $r:expr)*) => {
        $crate::pair::checks::Refusal {
            field: String::from($field),
            value: gearmesh::words::shown(&($value).to_string()),
            problem: format!($problem $(, $p)*),
            remedy: format!($remedy $(, $r)*),
        }
    };
}

/// Returns the [`refusal!`] of a value unless it is fine; a comparison with NaN is not.
macro_rules! ensure {
    ($fine:expr, $($refusal:tt)*) => {
        let is_fine: bool = $fine;
        if !is_fine {
            return Err($crate::pair::checks::refusal!($($refusal)*).into());
        }
    };
}

pub(super) use {ensure, refusal};

/// The least number above 0.
pub(super) const ABOVE_0: f64 = f64::MIN_POSITIVE;

/// Checks that the number at `path`, if there is one, lies in `range`, both ends included. A range with a limit that is not a
/// number, since it follows from a field that is refused itself, is not checked.
pub(super) fn check(
    path: &str,
    value: impl Into<Option<f64>>,
    range: [f64; 2],
) -> Result<(), Refusal> {
    let has_limits = !range.iter().any(|limit| limit.is_nan());
    value
        .into()
        .filter(|_| has_limits)
        .map_or(Ok(()), |value| check_with_usual(path, value, range, range))
}

/// The same of a number that lies within `usual` in its unit.
pub(super) fn check_with_usual(
    path: &str,
    value: f64,
    range: [f64; 2],
    usual: [f64; 2],
) -> Result<(), Refusal> {
    let [low, high] = range.map(rounded);
    let problem = match range[0] == ABOVE_0 {
        true => format!("must be above 0 and at most {high}"),
        false => format!("lies outside {low} to {high}"),
    };
    let meant = meant(path, value, usual).map_or_else(String::new, |meant| format!(": {meant}"));
    // A limit as it is shown is allowed, too: 0.1 * 1.5 is not quite 0.15.
    let allowed = [low.min(range[0]), high.max(range[1])];
    // The middle of a tolerance has digits of rounding.
    ensure!(within(value, allowed), path => number(rounded(value));
        "{problem}"; "give a value in that range, in the unit of the name{meant}");
    Ok(())
}

fn within(value: f64, [low, high]: [f64; 2]) -> bool {
    (low..=high).contains(&value)
}

/// Checks fields of a part of the file, whose path is given with a point, or nothing: `field: range;` for each, with what
/// makes a number of another type after `via`. Gives the refusals of all of them.
macro_rules! limits {
    ($path:expr, $part:expr; $($field:ident $(via $number:path)?: $range:expr;)*) => {
        $crate::pair::checks::every([$($crate::pair::checks::check(
            &format!("{}{}", $path, stringify!($field)), $part.$field$(.map($number))?, $range,
        )),*])
    };
}
pub(super) use limits;

/// Units in which numbers are given by mistake: how the names of fields with another unit end, that unit, the mistaken one,
/// and how many of the first it is.
const MISTAKEN: [(&str, &str, &str, f64); 11] = [
    ("_mm", "mm", "m", 1e3),
    ("_mm", "mm", "inch", 25.4),
    ("diameter_mm", "mm in diameter", "mm in radius", 2.0),
    ("_um", "um", "mm", 1e3),
    ("_um_per_m_k", "um/(m K)", "1/K", 1e6),
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

/// The end of a range that is farther from nominal.
fn farther([low, high]: [f64; 2]) -> f64 {
    if high >= -low { high } else { low }
}

/// Notes on suspiciously small numbers: the helix angle on gear 1 (`helix`, degrees) and those of the file.
pub(super) fn notes(file: &PairFile, helix: f64) -> Vec<String> {
    let o = &file.operating;
    let offset = farther(o.center_distance_offset_um);
    let tilt = o.misalignment_mrad.map_or(0.0, farther);
    let backlash = file.backlash_um.unwrap_or(0.0);
    let housing = file.housing_thermal_expansion_um_per_m_k.unwrap_or(0.0);
    let normal_backlash = file.normal_backlash_um.map_or(0.0, Dimension::middle);
    let mut notes = vec![
        note("helix_angle_deg", helix, LEAST_HELIX),
        note("backlash_um", backlash, 1.0),
        note("normal_backlash_um", normal_backlash, 1.0),
        note("operating.center_distance_offset_um", offset, 0.1),
        note("operating.misalignment_mrad", tilt, 0.02),
        note("housing_thermal_expansion_um_per_m_k", housing, 0.1),
    ];
    for i in 0..2 {
        let expansion = file.gear(i).thermal_expansion_um_per_m_k;
        let field = in_gear(i, "thermal_expansion_um_per_m_k");
        notes.push(note(&field, expansion.unwrap_or(0.0), 0.1));
        // Stiffer than diamond: rigid, or in another unit.
        let table = &file.gear(i).youngs_modulus_over_temperature;
        let (field, modulus) = match table.iter().flatten().next() {
            Some([_, modulus]) => ("youngs_modulus_over_temperature", *modulus),
            None => (
                "youngs_modulus_gpa",
                file.gear(i).youngs_modulus_gpa.unwrap_or(0.0),
            ),
        };
        let name = in_gear(i, field);
        let doubt = meant("_gpa", modulus, [0.1, 1200.0]).filter(|_| modulus > 1200.0);
        notes.push(doubt.map(|meant| {
            format!("`{name}` = {modulus} is a suspicious value unless the gear is rigid: {meant}")
        }));
        for (prefix, flank) in file.gear(i).flanks() {
            let path = in_gear(i, prefix);
            notes.extend(
                amounts(&flank).map(|(field, um, _)| note(&format!("{path}{field}"), um, 0.1)),
            );
        }
        if let Some(errors) = &file.gear(i).tooth_errors {
            let field = in_gear(i, "tooth_errors.runout_um");
            notes.push(note(&field, errors.runout_um, 0.1));
            let flanks = [
                ("drive_flank", &errors.drive_flank),
                ("coast_flank", &errors.coast_flank),
            ];
            for (flank, index) in flanks {
                let list = index.iter().flat_map(|index| &index.cumulative_pitch_um);
                let largest = list
                    .flatten()
                    .copied()
                    .max_by(|a, b| a.abs().total_cmp(&b.abs()));
                let field = format!("tooth_errors.{flank}.cumulative_pitch_um");
                notes.push(note(&in_gear(i, &field), largest.unwrap_or(0.0), 0.1));
            }
        }
        let bearings = file.gear(i).shaft.iter().flat_map(|shaft| &shaft.bearings);
        for (k, bearing) in bearings.flatten().enumerate() {
            let field = in_gear(i, &format!("shaft.bearings.{k}.radial_clearance_um"));
            notes.push(note(
                &field,
                bearing.radial_clearance_um.unwrap_or(0.0),
                0.5,
            ));
        }
    }
    notes.into_iter().flatten().collect()
}

/// "gear1.<name>" or "gear2.<name>".
pub(super) fn in_gear(i: usize, name: &str) -> String {
    format!("gear{}.{name}", i + 1)
}

/// Torques on gear 1 other than 0, N m. Below, the rounding of lengths outweighs the deflection of the teeth.
pub const TORQUES: [f64; 2] = [1e-9, 1e9];

/// Checks every field of the file by itself.
pub(super) fn check_fields(file: &PairFile) -> Result<(), Refusals> {
    // Nothing else is measured by a module that is refused.
    let module = match within(file.normal_module_mm, MODULES) {
        true => file.normal_module_mm,
        false => f64::NAN,
    };
    let gears = (0..2).flat_map(|i| {
        let gear = file.gear(i);
        [check_gear(i, gear, module), check_amounts(i, gear, module)]
    });
    let parts = [check_name(&file.name), check_pair(file, module)];
    let rest = [
        check_held_surfaces(file).map_err(Into::into),
        check_operating(file),
    ];
    every(parts.into_iter().chain(gears).chain(rest)).map(drop)
}

fn check_name(name: &str) -> Result<(), Refusals> {
    let is_title = !name.trim().is_empty() && name.chars().count() <= 100;
    ensure!(is_title && !name.chars().any(char::is_control), "name" => format!("{name:?}");
        "is no title of one line"; "give 1 to 100 characters, no line feed or tabulator among them");
    Ok(())
}

/// Normal modules, mm. Smaller ones than any tooth has are metres.
const MODULES: [f64; 2] = [0.02, 1000.0];

/// What both gears have in common; `module` is NaN if it is refused.
fn check_pair(file: &PairFile, module: f64) -> Result<(), Refusals> {
    limits! { "", file;
        normal_module_mm: MODULES;
        normal_pressure_angle_deg: [10.0, 35.0];
        helix_angle_deg: [-60.0, 60.0];
        center_distance_mm: [ABOVE_0, 1e5];
        // Plastic and worn teeth; beyond half a module it is another centre distance.
        backlash_um: [0.0, 500.0 * module];
        face_offset_mm: [-1e4, 1e4];
        normal_backlash_um via Dimension::middle: [0.0, 500.0 * module];
    }
    .map(drop)
}

fn check_gear(i: usize, g: &GearFile, module: f64) -> Result<(), Refusals> {
    let gear = in_gear(i, "");
    let teeth = check(
        &format!("{gear}teeth"),
        f64::from(g.number_of_teeth()),
        [4.0, 5000.0],
    );
    let tip = match (g.addendum_coefficient, g.tip_diameter_mm) {
        (Some(addendum), Some(mm)) => {
            Err(refusal!(format!("{gear}addendum_coefficient") => addendum;
            "`tip_diameter_mm` = {mm} says the same"; "give only one of them"))
        }
        _ => Ok(()),
    };
    let numbers = limits! { gear, g;
        profile_shift: [-3.0, 3.0];
        profile_shift_iso_21771: [-3.0, 3.0];
        ball_diameter_mm: [ABOVE_0, 5.0 * module];
        face_width_mm: [ABOVE_0, 1e4];
        // Beyond a hundred modules of face the elastic model outgrows memory.
        face_width_mm: [0.05 * module, 100.0 * module];
        tip_diameter_mm: [ABOVE_0, 1e5];
        root_form_diameter_mm: [ABOVE_0, 1e5];
        addendum_coefficient: [ABOVE_0, 3.0];
        dedendum_coefficient: [ABOVE_0, 3.0];
        tool_tip_radius_coefficient: [0.0, 1.0];
        bore_diameter_mm: [ABOVE_0, 1e5];
        rim_diameter_mm: [ABOVE_0, 1e5];
        // A rigid mate is a thousand times as stiff as steel.
        youngs_modulus_gpa: [ABOVE_0, 1e6];
        poisson_ratio: [0.0, 0.49];
        span_teeth via f64::from: [1.0, f64::from(g.number_of_teeth())];
        normal_tooth_thickness_mm via Dimension::middle: [ABOVE_0, 1e5];
        span_measurement_mm via Dimension::middle: [ABOVE_0, 1e5];
        dimension_over_balls_mm via Dimension::middle: [ABOVE_0, 1e5];
        root_diameter_mm via Dimension::middle: [ABOVE_0, 1e5];
    };
    both(every([teeth, tip]), numbers).map(drop)
}

/// Removal over the length of roll or of the face within which it grows, at most: what is steeper is a chamfer.
pub(super) const STEEPEST: f64 = 0.1;

/// Amounts of microgeometry: at most a twentieth of the module, beyond which the flank is another one; those that only take
/// material off not negative.
fn check_amounts(i: usize, g: &GearFile, module: f64) -> Result<(), Refusals> {
    let most = 50.0 * module;
    let mut checked = Vec::new();
    for (prefix, flank) in g.flanks() {
        let path = in_gear(i, prefix);
        for (field, um, has_sign) in amounts(&flank) {
            let low = if has_sign { -most } else { 0.0 };
            checked.push(check(&format!("{path}{field}"), um, [low, most]));
        }
        for (field, relief) in flank.end_reliefs() {
            let least = (1e-3 * relief.amount_um / STEEPEST).max(ABOVE_0);
            let field = format!("{path}{field}.length_mm");
            checked.push(check(
                &field,
                relief.length_mm,
                [least, 0.5 * g.face_width_mm],
            ));
        }
    }
    every(checked).map(drop)
}

/// Field and amount in um of every modification that is given, and whether it may be of either sign.
fn amounts(f: &FlankFile) -> impl Iterator<Item = (String, f64, bool)> {
    let [tip, root] = [&f.tip_relief, &f.root_relief].map(|r| Some(r.as_ref()?.amount_um));
    let rows = [
        ("tip_relief.amount_um", tip, false),
        ("root_relief.amount_um", root, false),
        ("profile_crowning_um", f.profile_crowning_um, false),
        ("profile_slope_um", f.profile_slope_um, true),
        ("bias_um", f.bias_um, true),
        ("lead_crowning_um", f.lead_crowning_um, false),
        ("lead_slope_um", f.lead_slope_um, true),
    ];
    let rows = rows
        .into_iter()
        .filter_map(|(field, um, sign)| Some((field.into(), um?, sign)));
    rows.chain(
        f.end_reliefs()
            .map(|(field, relief)| (format!("{field}.amount_um"), relief.amount_um, false)),
    )
}

/// Bore or rim: which of them a gear may have says whether it is a ring.
fn check_held_surfaces(file: &PairFile) -> Result<(), Refusal> {
    for i in 0..2 {
        let (g, mate) = (file.gear(i), file.gear(1 - i));
        let bore = g.bore_diameter_mm;
        if let Some(rim) = g.rim_diameter_mm {
            let field = in_gear(i, "rim_diameter_mm");
            ensure!(bore.is_none(), field => rim;
                "the gear has a `bore_diameter_mm`, too"; "give a bore for an external gear, a rim for a ring");
            ensure!(file.meshing == Meshing::Internal, field => rim;
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

/// Largest misalignment of `operating`, either way, mrad.
pub const LARGEST_MISALIGNMENT: f64 = 20.0;

/// Largest deviation from the nominal centre distance of `operating`, either way, um.
pub const LARGEST_CENTER_DISTANCE_OFFSET: f64 = 1e4;

/// Refuses a range without 0 or beyond `most`.
fn check_range(field: &str, [low, high]: [f64; 2], most: f64) -> Result<(), Refusal> {
    ensure!(low <= 0.0 && high >= 0.0, field => format!("[{}, {}]", number(low), number(high));
        "is no range with the drawing's 0 in it"; "give [lowest, highest], such as [{}, {}]",
        number(low.min(high).min(0.0)), number(low.max(high).max(0.0)));
    check(field, low, [-most, 0.0])?;
    check(field, high, [0.0, most])
}

fn check_operating(file: &PairFile) -> Result<(), Refusals> {
    let o = &file.operating;
    let offset = o.center_distance_offset_um;
    let offset = check_range(
        "operating.center_distance_offset_um",
        offset,
        LARGEST_CENTER_DISTANCE_OFFSET,
    );
    let tilt = o.misalignment_mrad.map_or(Ok(()), |m| {
        check_range("operating.misalignment_mrad", m, LARGEST_MISALIGNMENT)
    });
    both(check_torques(o), every([offset, tilt])).map(drop)
}

/// Largest torque over the nominal one that a slip in its unit explains.
const USUAL_OVERLOAD: f64 = 10.0;

fn check_torques(o: &OperatingFile) -> Result<(), Refusals> {
    let ([least, most], nominal) = (TORQUES, o.nominal_torque_nm);
    ensure!((least..=most).contains(&nominal), "operating.nominal_torque_nm" => number(nominal);
        "lies outside {least:e} to {most:e}"; "give the torque on gear 1 in N m, above 0");
    let field = "operating.maximum_torque_nm";
    let maximum = o.maximum_torque_nm;
    let largest = format!(
        "give at least {}, the largest torque that is ever reached",
        number(nominal)
    );
    // A limit as it is shown is allowed, too.
    ensure!(maximum >= nominal.min(rounded(nominal)), field => number(maximum);
        "is less than `operating.nominal_torque_nm` = {}", number(nominal);
        "{}", remedy(field, maximum, [nominal, USUAL_OVERLOAD * nominal], &largest));
    Ok(check(field, maximum, [least, most])?)
}
