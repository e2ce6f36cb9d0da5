//! Flank tolerances of ISO 1328-1:2013. The standard measures in the transverse section: slopes along the transverse base
//! tangent, pitches along the arc of a circle at mid-depth, here the reference circle. Here they stand as pair files have them: slopes normal to the flank,
//! index errors along the transverse line of action.

use gearmesh::gear::Gear;
use gearmesh::random::Random;
use gearmesh::root::bisection;

/// Finest and coarsest flank tolerance class.
pub const CLASSES: std::ops::RangeInclusive<u8> = 1..=11;

/// The tolerance of `class`, m, as the standard measures it, from that of class 5 in um: sqrt(2) per class, rounded to whole um
/// above 10, to halves above 5, else to tenths (5.2.3 of the standard).
fn tolerance(class: u8, at_five_um: f64) -> f64 {
    let um = at_five_um * 2f64.powf(0.5 * (f64::from(class) - 5.0));
    let step = match um {
        _ if um > 10.0 => 1.0,
        _ if um > 5.0 => 0.5,
        _ => 0.1,
    };
    1e-6 * ((um / step).round() * step)
}

/// Reference diameter and normal module, mm.
fn size_mm(gear: &Gear) -> [f64; 2] {
    let m = 1e3 * gear.normal_module;
    [gear.z() * m / gear.helix_angle.cos(), m]
}

/// Profile slope tolerance f_HaT of `class` times cos beta_b, m, normal to the flank: the profile slope deviation may lie
/// between it and its negative.
pub fn profile_slope(gear: &Gear, class: u8) -> f64 {
    let [d, m] = size_mm(gear);
    tolerance(class, 0.4 * m + 0.001 * d + 4.0) * gear.base_helix_angle().cos()
}

/// Helix slope tolerance f_HbT of `class` times cos beta_b, m, normal to the flank, over the whole face.
pub fn helix_slope(gear: &Gear, class: u8) -> f64 {
    let ([d, _], b) = (size_mm(gear), 1e3 * gear.face_width);
    tolerance(class, 0.05 * d.sqrt() + 0.35 * b.sqrt() + 4.0) * gear.base_helix_angle().cos()
}

/// Single pitch tolerance f_pT of `class` times cos alpha_t, m, along the line of action.
pub fn single_pitch(gear: &Gear, class: u8) -> f64 {
    let [d, m] = size_mm(gear);
    tolerance(class, 0.001 * d + 0.4 * m + 5.0) * gear.transverse_pressure_angle().cos()
}

/// Total cumulative pitch tolerance F_pT of `class` times cos alpha_t, m, along the line of action: range of the index errors
/// of all teeth.
pub fn total_pitch(gear: &Gear, class: u8) -> f64 {
    let [d, m] = size_mm(gear);
    let range = tolerance(class, 0.002 * d + 0.55 * d.sqrt() + 0.7 * m + 12.0);
    range * gear.transverse_pressure_angle().cos()
}

/// Index errors of all teeth of a gear of `class`, m, mean zero: a wave once per revolution at a random angle, as of a blank
/// that sat askew, and for each tooth a random part of half the single pitch tolerance. They use up the total cumulative or
/// the single pitch tolerance, whichever comes first. The same for the same `seed`.
pub fn random_index_errors(gear: &Gear, class: u8, seed: u32) -> Vec<f64> {
    let n = gear.teeth as usize;
    // Seeds of xorshift should have bits all over: multiplied by 2^64 over the golden ratio.
    let mut random = Random::new((u64::from(seed) + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15));
    for _ in 0..8 {
        random.next();
    }
    let phase = random.within([0.0, std::f64::consts::TAU]);
    let steps: Vec<f64> = (0..n).map(|_| random.within([-1.0, 1.0])).collect();
    let mean = steps.iter().sum::<f64>() / n as f64;
    let [single, total] = [single_pitch(gear, class), total_pitch(gear, class)];
    let largest_step = largest_pitch(&steps);
    let with = |wave: f64| -> Vec<f64> {
        let each = steps.iter().enumerate().map(|(j, step)| {
            let angle = phase + std::f64::consts::TAU * j as f64 / n as f64;
            wave * angle.sin() + 0.5 * single / largest_step * (step - mean)
        });
        each.collect()
    };
    // The range grows with the wave.
    let wave = bisection([0.0, total], 60, |wave| range(&with(wave)) < total);
    let errors = with(wave);
    let most = (single / largest_pitch(&errors)).min(total / range(&errors));
    let scale = most.min(1.0);
    errors.into_iter().map(|error| scale * error).collect()
}

/// Range of index errors.
fn range(index: &[f64]) -> f64 {
    let values = index.iter().copied();
    let largest = values.clone().fold(f64::NEG_INFINITY, f64::max);
    largest - values.fold(f64::INFINITY, f64::min)
}

/// Largest single pitch deviation.
fn largest_pitch(index: &[f64]) -> f64 {
    let last = index.last().copied().unwrap_or(0.0);
    let before = std::iter::once(&last).chain(index);
    let steps = index.iter().zip(before).map(|(x, y)| (x - y).abs());
    steps.fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples;
    use gearmesh::gear::GearKind;

    #[test]
    fn class_five_is_the_formula_and_two_classes_double_it() {
        // d = 80 mm, m_n 4, b 25: 0.4 * 4 + 0.08 + 4 = 5.68 -> 5.5; 0.447 + 1.75 + 4 = 6.197 -> 6.
        let gear = samples::gear(GearKind::External, 20, 1.0, 0.0, 0.0);
        // 11.36 -> 11; 12.39 -> 12; 4.02 -> 4.0. 0.08 + 1.6 + 5 = 6.68 -> 6.5; 0.16 + 4.919 + 2.8 + 12 = 19.88 -> 20.
        let arc = gear.normal_pressure_angle.cos();
        for (found, um) in [
            (profile_slope(&gear, 5), 5.5),
            (helix_slope(&gear, 5), 6.0),
            (profile_slope(&gear, 7), 11.0),
            (helix_slope(&gear, 7), 12.0),
            (profile_slope(&gear, 4), 4.0),
            (single_pitch(&gear, 5), 6.5 * arc),
            (total_pitch(&gear, 5), 20.0 * arc),
        ] {
            assert!((1e6 * found - um).abs() < 1e-6, "{found} {um}");
        }
    }

    #[test]
    fn a_flank_that_is_off_by_a_slope_normal_to_it_is_off_by_more_in_the_transverse_section() {
        // d = 80 mm: m_n 4 cos 30 deg; b 25: 0.4 * 3.464 + 0.08 + 4 = 5.466 -> 5.5; 6.197 -> 6; 0.08 + 1.386 + 5 = 6.466 -> 6.5.
        let beta = 30f64.to_radians();
        let spur = samples::gear(GearKind::External, 20, 1.0, 0.0, 0.0);
        let module = spur.normal_module * beta.cos();
        let gear = Gear {
            helix_angle: beta,
            normal_module: module,
            ..spur
        };
        // tan alpha_t = tan alpha_n / cos beta; sin beta_b = sin beta cos alpha_n.
        let alpha_n = gear.normal_pressure_angle;
        let base = (1.0 - (beta.sin() * alpha_n.cos()).powi(2)).sqrt();
        let arc = (alpha_n.tan() / beta.cos()).atan().cos();
        for (found, um) in [
            (profile_slope(&gear, 5), 5.5 * base),
            (helix_slope(&gear, 5), 6.0 * base),
            (single_pitch(&gear, 5), 6.5 * arc),
        ] {
            assert!((1e6 * found - um).abs() < 1e-6, "{found} {um}");
        }
    }

    #[test]
    fn random_index_errors_use_up_the_class_and_are_the_same_for_a_seed() {
        for teeth in [9, 20, 84] {
            let gear = samples::gear(GearKind::External, teeth, 1.0, 0.0, 0.0);
            for class in [3, 6, 9] {
                let errors = random_index_errors(&gear, class, 7);
                assert_eq!(errors, random_index_errors(&gear, class, 7));
                assert_ne!(errors, random_index_errors(&gear, class, 8));
                assert_eq!(errors.len(), teeth as usize);
                let uses = (range(&errors) / total_pitch(&gear, class))
                    .max(largest_pitch(&errors) / single_pitch(&gear, class));
                assert!((uses - 1.0).abs() < 1e-9, "{teeth} {class}: {uses}");
                assert!(range(&errors) <= total_pitch(&gear, class) * (1.0 + 1e-12));
                assert!(errors.iter().sum::<f64>().abs() < 1e-12);
            }
        }
    }
}
