//! Contact of random realistic pairs, and of the smallest file of the documentation at the ends of what its fields allow:
//! none refused whose flanks steel can carry.
//!
//! `GEARMESH_SWEEP=60 cargo test --release --test contact realistic` goes through so many gear bodies, each with
//! five sets of modifications, loads and settings of the solver.

use super::*;

/// Bodies without `GEARMESH_SWEEP`.
const BODIES: usize = 3;
/// Pairs of the same bodies.
const VARIANTS: usize = 5;

/// Evenly spread numbers in [0, 1): the `n`-th of the sequence `d`.
fn draw(n: usize, d: usize) -> f64 {
    const PRIMES: [f64; 16] = [
        2.0, 3.0, 5.0, 7.0, 11.0, 13.0, 17.0, 19.0, 23.0, 29.0, 31.0, 37.0, 41.0, 43.0, 47.0, 53.0,
    ];
    (0.5 + PRIMES[d].sqrt() * (n + 1) as f64).fract()
}

/// Between `low` and `high`.
fn between(n: usize, d: usize, low: f64, high: f64) -> f64 {
    low + draw(n, d) * (high - low)
}

/// Bodies number `n`, external and internal in turns, spur ones among them.
fn bodies(n: usize) -> Value {
    let internal = n % 3 == 2;
    let helix = f64::from(n % 5 != 4) * between(n, 0, -45.0, 45.0);
    let pinion = between(n, 1, 18.0, 36.0).round();
    let mate = match internal {
        true => pinion + between(n, 2, 30.0, 60.0).round(),
        false => between(n, 2, 20.0, 70.0).round(),
    };
    let module = between(n, 3, 1.0, 5.0);
    let face = module * between(n, 4, 5.0, 11.0);
    json!({
        "name": format!("bodies {n}"),
        "meshing": if internal { "internal" } else { "external" },
        "normal_module_mm": module,
        "normal_pressure_angle_deg": if n % 4 == 3 { 17.5 } else { 20.0 },
        "helix_angle_deg": helix,
        "backlash_um": 0.03e3 * module,
        "gear1": { "teeth": pinion as u32, "face_width_mm": face, "profile_shift": between(n, 5, 0.0, 0.4) },
        "gear2": { "teeth": mate as u32, "face_width_mm": face, "profile_shift": between(n, 5, 0.0, 0.4) },
        "compliance": { "refinement": "coarse" },
    })
}

/// Pair number `v` on the bodies number `n`, and the misalignment to solve at, rad.
fn variant(n: usize, v: usize) -> Result<(Pair, f64), String> {
    let mut file = bodies(n);
    let k = VARIANTS * n + v;
    let module = number(&file["normal_module_mm"]);
    let um = |d: usize, share: f64| 1e3 * module * share * draw(k, d);
    for (gear, d) in [("gear1", 6), ("gear2", 7)] {
        file[gear]["tip_relief"] = json!({
            "amount_um": if k.is_multiple_of(4) { 0.0 } else { um(d, 0.01) },
            "shape": if k.is_multiple_of(2) { "linear" } else { "parabolic" },
        });
        file[gear]["lead_crowning_um"] = um(d + 2, 0.004).into();
        file[gear]["profile_crowning_um"] = um(d + 4, 0.002).into();
    }
    file["operating"] = json!({
        "nominal_torque_nm": 1.0, "maximum_torque_nm": 1.0,
        "center_distance_offset_um": [0.0, 0.0], "misalignment_mrad": [-2.0, 2.0],
    });
    let mut pair = pair::from_json(&file.to_string()).map_err(|error| error.to_string())?;
    // The torque at which one contact line over the face has this Hertz pressure at the pitch point.
    let (g, pressure) = (&pair.geometry, between(k, 12, 0.3e9, 2.5e9));
    let curvature = |i: usize| g.gears[i].kappa() / g.roll_at(i, g.center_distance, 0.0);
    let softness = |i: usize| (1.0 - g.gears[i].poisson_ratio.powi(2)) / g.gears[i].youngs_modulus;
    let cos = g.base_helix_angle().cos();
    let [curvature, softness] = [curvature(0) + curvature(1), softness(0) + softness(1)];
    let line_load = 0.5 * TAU * pressure.powi(2) * softness / (curvature * cos);
    let torque = line_load * g.face_overlap().1 * g.gears[0].base_radius();
    (pair.operating.nominal_torque, pair.operating.maximum_torque) = (torque, torque);
    pair.tip_corner_contact = k % 3 != 1;
    Ok((pair, between(k, 13, -2e-3, 2e-3)))
}

#[test]
fn none_is_refused_up_to_a_nominal_pressure_of_two_and_a_half_gigapascal() {
    let count = std::env::var("GEARMESH_SWEEP").map_or(BODIES, |text| text.parse().unwrap());
    let folder = tempfile::tempdir().unwrap();
    let cache = ModelCache::new(folder.path(), ModelCache::DEFAULT_LIMIT);
    let (mut solved, mut refused) = (0, Vec::new());
    let mut n = 0;
    while solved < VARIANTS * count {
        n += 1;
        assert!(n < 10 * count, "too few usable pairs");
        // Geometry that a pair file may not have.
        if variant(n, 0).is_err() {
            continue;
        }
        for v in 0..VARIANTS {
            let (pair, misalignment) = variant(n, v).unwrap();
            let mut contact = contact_settings(&pair);
            contact.stations = [contact.stations, 20, 40, 80, contact.stations][v];
            let solver = solver(&pair, &Settings::for_pair(&pair), Some(&cache), contact);
            for tau in [draw(n, 14), draw(n, 15), 0.5] {
                let result = solver.position(Flank::Drive, tau, 0.0).and_then(|p| {
                    p.solve_torque(pair.operating.maximum_torque, misalignment, None)
                });
                match result {
                    Ok(result) => assert!(result.kkt_residual < 1e-8, "{n} {v} {result:?}"),
                    Err(error) => refused.push(format!("bodies {n}, variant {v}, {tau}: {error}")),
                }
            }
            solved += 1;
        }
        if std::env::var("GEARMESH_SWEEP").is_ok() {
            println!("{solved} pairs, {} refused", refused.len());
            cache.clear().unwrap();
        }
    }
    assert!(refused.is_empty(), "{}", refused.join("\n"));
}

/// The smallest file that docs/pair-file.md shows.
fn smallest_pair() -> Value {
    let page = include_str!("../../docs/pair-file.md");
    let (_, from) = page.split_once("```json\n").expect("a file");
    serde_json::from_str(from.split_once("```").expect("its end").0).unwrap()
}

#[test]
fn the_smallest_pair_bears_its_largest_load_at_the_ends_of_what_its_fields_allow() {
    // A crowning of a twentieth of the module.
    for (field, value) in [
        ("helix_angle_deg", 45.0),
        ("helix_angle_deg", -55.0),
        ("helix_angle_deg", 60.0),
        ("bore_diameter_mm", 1.0),
        ("profile_crowning_um", 150.0),
    ] {
        let mut file = smallest_pair();
        file["compliance"] = json!({ "refinement": "coarse" });
        match field {
            "helix_angle_deg" => file[field] = value.into(),
            _ => ["gear1", "gear2"]
                .iter()
                .for_each(|gear| file[gear][field] = value.into()),
        }
        let pair = pair::from_json(&file.to_string()).unwrap();
        let settings = Settings::for_pair(&pair);
        let solver = solver(&pair, &settings, None, contact_settings(&pair));
        let operating = &pair.operating;
        for position in [0.1, 0.35, 0.6, 0.85] {
            for offset in operating.center_distance_offset {
                let problem = solver.position(Flank::Drive, position, offset).unwrap();
                for misalignment in operating.misalignment {
                    let result = problem
                        .solve_torque(operating.maximum_torque, misalignment, None)
                        .unwrap_or_else(|error| panic!("{field}: {error}"));
                    assert!(result.kkt_residual < 1e-8, "{field} {value}: {result:?}");
                }
            }
        }
    }
}
