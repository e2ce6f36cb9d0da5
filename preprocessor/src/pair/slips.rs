//! Slips that a number gives away: a metre taken for a millimetre, a radian for a degree, a radius for a diameter.
//!
//! Where a value is impossible anyway, its refusal says what it probably is; where it is merely odd, a note does.

use super::checks::amounts;
use super::file::PairFile;
use gearmesh::gear::PairGeometry;
use gearmesh::words::rounded;

/// A unit that is taken for the one of the field: its name, and how many of the field's unit it is.
type Slip = (&'static str, f64);

const LENGTHS: [Slip; 2] = [("m", 1e3), ("inch", 25.4)];

/// Less than this is no angle in degrees that teeth have, but may be one in radians.
const LARGEST_RADIANS: f64 = 1.05;

/// `, give ...` if `value` in one of the units of `slips` lies within a factor `spread` of `expected`, the field's
/// own unit being `unit`.
fn slip(value: f64, expected: f64, spread: f64, slips: &[Slip], unit: &str) -> Option<String> {
    let near = |scale: &f64| {
        let ratio = value * scale / expected;
        (spread.recip()..=spread).contains(&ratio)
    };
    let (name, scale) = slips.iter().find(|(_, scale)| near(scale))?;
    Some(format!(
        "{} {name} is {} {unit}",
        rounded(value),
        rounded(value * scale)
    ))
}

/// The remedy for a value: `give`, as what it is `probably` meant, else `otherwise`.
pub(super) fn remedy(probably: Option<String>, give: &str, otherwise: impl Into<String>) -> String {
    probably.map_or_else(|| otherwise.into(), |meant| format!("{give}: {meant}"))
}

/// What a length (mm) probably is of which about `expected` (mm) was to be expected.
pub(super) fn length(value: f64, expected: f64) -> Option<String> {
    slip(value, expected, 1.5, &LENGTHS, "mm")
}

/// What a diameter (mm) probably is of which about `expected` (mm) was to be expected.
pub(super) fn diameter(value: f64, expected: f64) -> Option<String> {
    let is_radius = (value * 2.0 / expected - 1.0).abs() <= 0.1;
    let twice = rounded(2.0 * value);
    let radius = || format!("{value} mm looks like the radius, the diameter is {twice} mm");
    length(value, expected).or_else(|| is_radius.then(radius))
}

/// What a normal module (mm) too small to be one probably is.
pub(super) fn module(value: f64) -> Option<String> {
    // 0.1 to 60 mm.
    slip(value, 2.5, 25.0, &LENGTHS[..1], "mm")
}

/// What a face width (mm) probably is, of a gear of this normal module (mm).
pub(super) fn face_width(value: f64, module: f64) -> Option<String> {
    slip(value, 12.0 * module, 8.0, &LENGTHS, "mm")
}

/// What an angle (degrees) probably is.
pub(super) fn degrees(value: f64) -> Option<String> {
    let is_radians = value != 0.0 && value.abs() <= LARGEST_RADIANS;
    let degrees = rounded((value.to_degrees() * 1e3).round() / 1e3);
    is_radians.then(|| format!("{value} rad is {degrees} deg"))
}

/// What a length (um) probably is.
pub(super) fn micrometres(value: f64) -> Option<String> {
    (value != 0.0 && value.abs() < 1.0)
        .then(|| format!("{value} mm is {} um", rounded(1e3 * value)))
}

/// What a Young's modulus (GPa) probably is.
pub(super) fn modulus(value: f64) -> Option<String> {
    slip(value, 100.0, 5.0, &[("MPa", 1e-3), ("Pa", 1e-9)], "GPa")
}

/// A torque at which the line load per module (N/mm2) is less than this is odd on steel teeth, which carry some
/// hundred times as much.
const ODDLY_SMALL_LOAD: f64 = 0.3e6;

/// No material carries a line load per module above this share of its Young's modulus: the root stress is three
/// times as high.
pub(super) const IMPOSSIBLE_LOAD: f64 = 0.02;

/// Transverse force on the line of action over normal module and `width` (m) of the face, Pa, at a torque on gear 1, N m.
pub(super) fn load(geometry: &PairGeometry, width: f64, torque: f64) -> f64 {
    let gear = &geometry.gears[0];
    torque / (gear.base_radius() * width * gear.normal_module)
}

/// What a torque (N m) far beyond what teeth carry probably is: one that is usual where it is N mm.
pub(super) fn torque(geometry: &PairGeometry, value: f64) -> Option<String> {
    let small = value * 1e-3;
    let usual = ODDLY_SMALL_LOAD..1e9;
    let steel = load(geometry, geometry.face_overlap().1, small);
    usual
        .contains(&steel)
        .then(|| format!("{value} N mm is {} N m", rounded(small)))
}

/// Notes on numbers that can be meant, but are odd.
pub(super) fn notes(file: &PairFile, geometry: &PairGeometry) -> Vec<String> {
    // The end of a range that is farther from nominal.
    let farther = |[low, high]: [f64; 2]| if high >= -low { high } else { low };
    let (helix, operating) = (file.helix_angle_deg.unwrap_or(0.0), &file.operating);
    let mut odd = Vec::new();
    let mut note = |field: &str, value: f64, unit: &str, doubt: String| {
        odd.push(format!("`{field}` = {value} {unit} is odd: {doubt}"));
    };
    if let Some(meant) = degrees(helix) {
        note(
            "helix_angle_deg",
            helix,
            "deg",
            format!("{meant}; the field takes degrees"),
        );
    }
    // Lengths in micrometres, and what is odd below.
    let offset = farther(operating.center_distance_offset_um);
    let backlash = file
        .backlash_um
        .map(|um| ("backlash_um".to_owned(), um, 1.0));
    let mut lengths: Vec<(String, f64, f64)> = backlash.into_iter().collect();
    for (name, gear) in [("gear1", &file.gear1), ("gear2", &file.gear2)] {
        for (prefix, flank) in gear.flanks() {
            let all = amounts(&flank, 0.0).into_iter();
            lengths.extend(all.map(|(field, um, _)| (format!("{name}.{prefix}{field}"), um, 0.1)));
        }
    }
    lengths.push(("operating.center_distance_offset_um".into(), offset, 0.1));
    for (field, um, least) in lengths {
        if let Some(meant) = micrometres(um).filter(|_| um.abs() < least) {
            note(
                &field,
                um,
                "um",
                format!("{meant}; the field takes micrometres"),
            );
        }
    }
    let mrad = farther(operating.misalignment_mrad);
    if mrad != 0.0 && mrad.abs() < 0.02 {
        let meant = rounded(1e3 * mrad);
        let doubt = format!("{mrad} rad is {meant} mrad; the field takes milliradians");
        note("operating.misalignment_mrad", mrad, "mrad", doubt);
    }
    let torque = operating.nominal_torque_nm;
    let modulus = geometry.gears.iter().map(|g| g.youngs_modulus);
    let softness = modulus.fold(f64::INFINITY, f64::min) / 206e9;
    if load(geometry, geometry.face_overlap().1, torque) < ODDLY_SMALL_LOAD * softness {
        let meant = rounded(1e3 * torque);
        let doubt = format!("{torque} kN m is {meant} N m; the field takes N m on gear 1");
        note("operating.nominal_torque_nm", torque, "N m", doubt);
    }
    for (i, gear) in geometry.gears.iter().enumerate() {
        let mm = 2e3 * gear.held_radius;
        if gear.body.is_none() && mm < 0.02 * 2e3 * gear.root_radius() {
            let doubt = match length(mm, 1e3 * gear.root_radius()) {
                Some(metres) => format!("{metres}; the field takes millimetres"),
                None => "give the diameter of the hub at which the gear is held, or `shaft` if its teeth are cut from one".into(),
            };
            let field = format!("gear{}.bore_diameter_mm", i + 1);
            note(&field, rounded(mm), "mm", doubt);
        }
    }
    odd
}
