//! Flank tolerances of ISO 1328-1:2013.

use super::Gear;

/// Finest and coarsest flank tolerance class.
pub const CLASSES: std::ops::RangeInclusive<u8> = 1..=11;

/// Factor of a class over class 5: sqrt(2) per class.
fn class_factor(class: u8) -> f64 {
    2f64.powf(0.5 * (f64::from(class) - 5.0))
}

/// Rounds a tolerance in um: to whole ones above 10, to halves above 5, else to tenths (5.2.3 of the standard).
fn rounded_um(um: f64) -> f64 {
    let step = if um > 10.0 {
        1.0
    } else if um > 5.0 {
        0.5
    } else {
        0.1
    };
    (um / step).round() * step
}

fn reference_diameter_mm(gear: &Gear) -> f64 {
    1e3 * gear.z() * gear.normal_module / gear.helix_angle.cos()
}

/// Profile slope tolerance f_HaT of `class`, m: the profile slope deviation may lie between it and its negative.
pub fn profile_slope(gear: &Gear, class: u8) -> f64 {
    let module = 1e3 * gear.normal_module;
    let at_five = 0.4 * module + 0.001 * reference_diameter_mm(gear) + 4.0;
    1e-6 * rounded_um(at_five * class_factor(class))
}

/// Helix slope tolerance f_HbT of `class`, m, over the whole face.
pub fn helix_slope(gear: &Gear, class: u8) -> f64 {
    let diameter = reference_diameter_mm(gear).sqrt();
    let at_five = 0.05 * diameter + 0.35 * (1e3 * gear.face_width).sqrt() + 4.0;
    1e-6 * rounded_um(at_five * class_factor(class))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gear::{GearKind, samples};

    #[test]
    fn class_five_is_the_formula_and_two_classes_double_it() {
        // d = 80 mm, m_n 4, b 25: 0.4 * 4 + 0.08 + 4 = 5.68 -> 5.5; 0.447 + 1.75 + 4 = 6.197 -> 6.
        let gear = samples::gear(GearKind::External, 20, 1.0, 0.0, 0.0);
        assert!((profile_slope(&gear, 5) - 5.5e-6).abs() < 1e-12);
        assert!((helix_slope(&gear, 5) - 6e-6).abs() < 1e-12);
        // 11.36 -> 11; 12.39 -> 12; 4.02 -> 4.0.
        assert!((profile_slope(&gear, 7) - 11e-6).abs() < 1e-12);
        assert!((helix_slope(&gear, 7) - 12e-6).abs() < 1e-12);
        assert!((profile_slope(&gear, 4) - 4.0e-6).abs() < 1e-12);
    }
}
