//! Teeth and shaft together against finite elements of both, on the shaft of a textbook (`validation/reference/shaft_contact.py`).

use super::*;

fn numbers(values: &Value) -> Vec<f64> {
    values.as_array().unwrap().iter().map(number).collect()
}

#[test]
fn face_load_factor_and_misalignment_on_the_shaft_of_a_textbook_are_those_of_finite_elements() {
    let data: Value = serde_json::from_str(include_str!("../data/shaft_contact.json")).unwrap();
    let pair = pair::from_json(&data["pair"].to_string()).unwrap();
    let settings = Settings::for_pair(&pair);
    let solver = solver(&pair, &settings, None, contact_settings(&pair));
    let input = CycleInput {
        flank: Flank::Drive,
        center_distance_offset: 0.0,
        positions: 2,
    };
    let load = LoadCase {
        torque: pair.operating.nominal_torque,
        misalignment: 0.0,
    };
    let cycles = MeshCycle::solve_all(&solver, &pair.shafts, &input, &[load], &|_| ()).unwrap();
    let ends = numbers(&data["strip_ends_mm"]);
    let known = data["positions"].as_array().unwrap();
    for (i, known) in known.iter().enumerate() {
        let at = MeshCycle {
            results: vec![cycles[0].results[i].clone()],
            ..MeshCycle::default()
        };
        let found = at.face_load(&solver).face_load_factor();
        let loads = numbers(&known["face_load_n_per_mm"]);
        // Over stations as long as the program's.
        let stations = solver.settings().stations;
        let step = ends[ends.len() - 1] / stations as f64;
        let in_station = |k: usize| {
            let (low, high) = (k as f64 * step, (k + 1) as f64 * step);
            let parts = loads.iter().zip(ends.windows(2));
            let shares = parts.map(|(load, e)| load * (high.min(e[1]) - low.max(e[0])).max(0.0));
            shares.sum::<f64>() / step
        };
        let means: Vec<f64> = (0..stations).map(in_station).collect();
        let right = means.iter().copied().fold(0.0, f64::max) / mean(&means);
        assert_relative_eq!(found, right, max_relative = 0.01);
        let tilt = 1e3 * cycles[0].shafts[i].misalignment;
        assert_relative_eq!(
            tilt,
            number(&known["misalignment_mrad"]),
            max_relative = 0.03
        );
    }
}
