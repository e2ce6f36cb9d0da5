//! Slips that a number gives away: a metre taken for a millimetre, a radian for a degree, a radius for a diameter.
//!
//! Where a value is impossible anyway, its refusal says what it probably is; where it is merely odd, a note does.

use super::checks::amounts;
use super::file::PairFile;
use crate::gear::PairGeometry;
use crate::words::rounded;

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

/// What a length or diameter (mm) probably is of which about `expected` (mm) was to be expected.
pub(super) fn length(value: f64, expected: f64) -> Option<String> {
    slip(value, expected, 1.5, &LENGTHS, "mm")
}

/// What a diameter (mm) probably is of which about `expected` (mm) was to be expected.
pub(super) fn diameter(value: f64, expected: f64) -> Option<String> {
    length(value, expected).or_else(|| {
        (value * 2.0 / expected - 1.0).abs().le(&0.1).then(|| {
            format!(
                "{value} mm looks like the radius, the diameter is {} mm",
                rounded(2.0 * value)
            )
        })
    })
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
    is_radians.then(|| {
        format!(
            "{value} rad is {} deg",
            rounded((value.to_degrees() * 1e3).round() / 1e3)
        )
    })
}

/// What a Young's modulus (GPa) probably is.
pub(super) fn modulus(value: f64) -> Option<String> {
    slip(
        value,
        100.0,
        5.0,
        &[("MPa", 1e-3), ("Pa", 1e-9), ("N/mm2", 1e-3)],
        "GPa",
    )
}

/// A torque at which the line load per module (N/mm2) is less than this is odd on steel teeth, which carry some
/// hundred times as much.
const ODDLY_SMALL_LOAD: f64 = 0.3e6;

/// No material carries a line load per module above this share of its Young's modulus: the root stress is three
/// times as high.
pub(super) const IMPOSSIBLE_LOAD: f64 = 0.02;

/// Transverse force on the line of action over face width and normal module, Pa, at a torque on gear 1, N m.
pub(super) fn load(geometry: &PairGeometry, torque: f64) -> f64 {
    let gear = &geometry.gears[0];
    torque / (gear.base_radius() * geometry.face_overlap().1 * gear.normal_module)
}

/// What a torque (N m) far beyond what teeth carry probably is.
pub(super) fn torque(geometry: &PairGeometry, value: f64) -> Option<String> {
    let steel = load(geometry, value * 1e-3);
    (steel < 1e9).then(|| format!("{value} N mm is {} N m", rounded(value * 1e-3)))
}

/// Notes on numbers that can be meant, but are odd.
pub(super) fn notes(file: &PairFile, geometry: &PairGeometry) -> Vec<String> {
    let mut out = Vec::new();
    let mut note = |field: String, value: f64, unit: &str, doubt: String| {
        out.push(format!("`{field}` = {value} {unit} is odd: {doubt}"));
    };
    if let Some(radians) = degrees(file.helix_angle_deg) {
        let doubt = format!("{radians}; the field takes degrees");
        note("helix_angle_deg".into(), file.helix_angle_deg, "deg", doubt);
    }
    let mut small = |field: String, um: f64| {
        if um != 0.0 && um.abs() < 0.1 {
            let doubt = format!(
                "{um} mm is {} um; the field takes micrometres",
                rounded(1e3 * um)
            );
            note(field, um, "um", doubt);
        }
    };
    if let Some(um) = file.backlash_um {
        small("backlash_um".into(), um);
    }
    for (name, gear) in [("gear1", &file.gear1), ("gear2", &file.gear2)] {
        for (prefix, flank) in gear.flanks() {
            for (field, um, _) in amounts(&flank, 0.0) {
                small(format!("{name}.{prefix}{field}"), um);
            }
        }
    }
    let offsets = file.operating.center_distance_offset_um;
    let largest = |range: [f64; 2]| {
        if range[1] >= -range[0] {
            range[1]
        } else {
            range[0]
        }
    };
    if largest(offsets).abs() < 1.0 {
        small(
            "operating.center_distance_offset_um".into(),
            largest(offsets),
        );
    }
    let mrad = largest(file.operating.misalignment_mrad);
    if mrad != 0.0 && mrad.abs() < 0.02 {
        let doubt = format!(
            "{mrad} rad is {} mrad; the field takes milliradians",
            rounded(1e3 * mrad)
        );
        note("operating.misalignment_mrad".into(), mrad, "mrad", doubt);
    }
    let torque = file.operating.nominal_torque_nm;
    let modulus = geometry.gears.iter().map(|g| g.youngs_modulus);
    let softness = modulus.fold(f64::INFINITY, f64::min) / 206e9;
    if load(geometry, torque) < ODDLY_SMALL_LOAD * softness {
        let doubt = format!(
            "{torque} kN m is {} N m; the field takes N m on gear 1",
            rounded(1e3 * torque)
        );
        note("operating.nominal_torque_nm".into(), torque, "N m", doubt);
    }
    for (i, gear) in geometry.gears.iter().enumerate() {
        let mm = 2e3 * gear.held_radius;
        if mm < 0.02 * 2e3 * gear.root_radius() {
            let doubt = match length(mm, 1e3 * gear.root_radius()) {
                Some(metres) => format!("{metres}; the field takes millimetres"),
                None => "give the diameter of the hub or shaft at which the gear is held".into(),
            };
            note(
                format!("gear{}.bore_diameter_mm", i + 1),
                rounded(mm),
                "mm",
                doubt,
            );
        }
    }
    out
}
