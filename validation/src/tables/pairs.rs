//! Random pairs as a designer would draw them, the same in every run.

use crate::Result;
use gearmesh::random::Random;
use gearmesh::words::rounded;
use gearmesh_preprocessor::gear::Pair;
use gearmesh_preprocessor::pair;
use serde_json::{Value, json};

/// Normal modules, mm.
const MODULES: [f64; 2] = [0.3, 30.0];
/// Tangential force at the nominal torque over face width and module, MPa.
const LOADS: [f64; 2] = [15.0, 60.0];
/// How far teeth deflect under a force per face width, N/(mm um): stiffness for the size of modifications.
const STIFFNESS: f64 = 18.0;
/// Largest misalignments, mrad.
const MISALIGNMENTS: [f64; 2] = [0.4, 2.5];

/// Random pair `number`: every third is a ring, every other one helical; modules, forces and misalignments even in their logarithms.
///
/// # Errors
/// What the pair file can refuse.
pub fn random(number: u64) -> Result<Pair> {
    Ok(pair::from_json(&file(number).to_string())?)
}

fn file(number: u64) -> Value {
    let mut random = Random::new((number + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15));
    // The first numbers of seeds that are near each other are near, too.
    for _ in 0..16 {
        random.next();
    }
    let (internal, helical) = (number % 3 == 2, number % 2 == 1);
    let digits = |x: f64| {
        let unit = 10f64.powf(x.abs().log10().floor() - 1.0);
        rounded((x / unit).round() * unit)
    };
    let logarithmic =
        |random: &mut Random, range: [f64; 2]| digits(random.within(range.map(f64::ln)).exp());
    let whole = |random: &mut Random, range: [f64; 2]| random.within(range).floor();
    let module = logarithmic(&mut random, MODULES);
    let z1 = whole(&mut random, [18.0, 40.0]);
    let more = if internal { [30.0, 70.0] } else { [0.0, 60.0] };
    let z2 = z1 + whole(&mut random, more);
    let helix = if helical {
        whole(&mut random, [8.0, 28.0])
    } else {
        0.0
    };
    let hand = if random.next() < 0.5 { -1.0 } else { 1.0 };
    let face = digits(module * random.within([5.0, 15.0]));
    let load = logarithmic(&mut random, LOADS);
    let radius = 0.5 * module * z1 / helix.to_radians().cos();
    let torque = digits(1e-3 * load * face * module * radius);
    // Of a pair of teeth under the nominal torque, um.
    let bent = load * module / STIFFNESS;
    let shift = digits(random.within([0.05, 0.3]));
    let relieved = random.next() < 0.5;
    let relief = digits(bent * random.within([0.3, 1.2]));
    let crowning = digits(bent * random.within([0.2, 1.5]));
    let misalignment = logarithmic(&mut random, MISALIGNMENTS);
    let closer = digits(1e3 * module * random.within([0.005, 0.02]));
    let apart = digits(1e3 * module * random.within([0.01, 0.04]));
    let gear = |teeth: f64, shift: f64, face: f64| {
        let mut gear =
            json!({ "teeth": teeth as u32, "profile_shift": shift, "face_width_mm": face });
        if relieved {
            gear["tip_relief"] =
                json!({ "amount_um": relief, "start": "pitch_point", "shape": "parabolic" });
        }
        gear
    };
    let mut gear1 = gear(z1, shift, rounded(face + digits(0.5 * module)));
    gear1["lead_crowning_um"] = json!(crowning);
    json!({
        "name": format!("random-{number}"),
        "meshing": if internal { "internal" } else { "external" },
        "normal_module_mm": module,
        "normal_pressure_angle_deg": 20.0,
        "helix_angle_deg": hand * helix,
        "backlash_um": rounded(digits(40.0 * module)),
        "gear1": gear1,
        "gear2": gear(z2, if internal { shift } else { 0.0 }, face),
        "operating": {
            "nominal_torque_nm": torque,
            "maximum_torque_nm": rounded(1.5 * torque),
            "center_distance_offset_um": [-closer, apart],
            "misalignment_mrad": [-misalignment, misalignment],
        },
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use gearmesh::gear::GearKind;

    #[test]
    fn ten_random_pairs_are_drawn_without_an_error_and_span_sizes_and_kinds() {
        let pairs: Vec<Pair> = (0..10).map(|n| random(n).unwrap()).collect();
        let gears = || pairs.iter().map(|pair| &pair.geometry.gears);
        let modules = || gears().map(|gears| 1e3 * gears[0].normal_module);
        assert!(modules().fold(f64::INFINITY, f64::min) < 1.0);
        assert!(modules().fold(0.0, f64::max) > 10.0);
        assert_eq!(gears().filter(|g| g[1].kind == GearKind::Ring).count(), 3);
        assert_eq!(gears().filter(|g| g[0].helix_angle == 0.0).count(), 5);
    }
}
