//! Relieved flanks, pressures and what no pair may be refused for.

use super::*;

/// The paper's pair with `amount` (m) of tip relief on both gears over the last part `share` of the path.
fn relieved(amount: f64, share: f64) -> Pair {
    let mut pair = pair::from_json(UNMODIFIED).unwrap();
    let g = &pair.geometry;
    let c = g.center_distance;
    let path = g.path_of_contact(c);
    let starts = [
        path.end - share * path.length(),
        path.start + share * path.length(),
    ];
    for (i, xi) in starts.into_iter().enumerate() {
        pair.microgeometry.drive[i].tip_relief = Some(ProfileRelief {
            amount,
            start_roll: g.roll_at(i, c, xi),
            end_roll: g.gears[i].roll_length(g.gears[i].tip_radius),
            shape: ReliefShape::Linear,
        });
    }
    pair
}

fn cycle(pair: &Pair, stations: usize, torque: f64) -> MeshCycle {
    let settings = ContactSettings {
        stations,
        ..contact_settings(pair)
    };
    mesh_cycle(&coarse_solver(pair, settings), torque, 0.0, 16)
}

#[test]
fn flank_pressure_does_not_grow_with_the_number_of_stations_nor_at_tip_edges() {
    // Hertz: pressures between 800 and 1050 MPa, and some 1700 MPa.
    for (text, torque, low, high) in [
        (UNMODIFIED, 100.0, 800.0, 1100.0),
        (SPUR, 302.0, 1500.0, 1900.0),
    ] {
        let pair = pair::from_json(text).unwrap();
        let cycles = [20, 40, 80].map(|stations| cycle(&pair, stations, torque));
        let [_, middle, fine] = cycles.each_ref().map(|cycle| 1e-6 * cycle.max_pressure());
        assert!((low..high).contains(&middle), "{}: {middle}", pair.name);
        assert!((fine / middle - 1.0).abs() < 0.03, "{middle} {fine}");
        assert!(cycles[1].edge_load().is_some(), "{}", pair.name);
    }
}

#[test]
fn the_largest_pressure_where_a_contact_line_crosses_the_start_of_a_relief_is_found_between_stations()
 {
    // Both reliefs start at the pitch point, which the contact line crosses at mid-face at position 0: an end of two segments, in whose
    // middles the pressure is 11 % lower.
    let pair = relieved(12e-6, 0.5);
    let [few, many] = [20, 120].map(|stations| cycle(&pair, stations, 30.0).results);
    for (a, b) in few.iter().zip(&many) {
        assert_relative_eq!(a.max_pressure, b.max_pressure, max_relative = 0.02);
    }
}

/// A steep helical pair, each contact line of which leaves the flanks within a station or two, with `amount` (um) of tip relief on both
/// gears from the pitch point on.
fn steep_helix(amount: f64) -> Pair {
    let mut file = reduction([30.0, 28.0], 150.0);
    for gear in ["gear1", "gear2"] {
        let relief = json!({ "amount_um": amount, "start": "pitch_point", "shape": "parabolic" });
        file[gear]["tip_relief"] = relief;
    }
    pair::from_json(&file.to_string()).unwrap()
}

#[test]
fn line_loads_at_the_tip_edges_of_a_steep_helix_do_not_depend_on_the_stations() {
    // Relief that keeps contact off the edges: the mean of a segment that reaches them is 77 and 18 N/mm. And less of it.
    for (amount, stations, low, high) in [(12.0, [20, 80], 0.0, 3e3), (8.0, [40, 80], 70e3, 100e3)]
    {
        let pair = steep_helix(amount);
        let [few, many] = stations.map(|stations| {
            let edge = cycle(&pair, stations, 150.0).edge_load();
            edge.map_or(0.0, |edge| edge.line_load)
        });
        assert!((low..high).contains(&many), "{amount}: {many}");
        assert_abs_diff_eq!(few, many, epsilon = f64::max(3e3, 0.03 * many));
    }
}

#[test]
fn a_short_steep_relief_keeps_contact_off_the_tip_edges() {
    let pair = relieved(40e-6, 0.1);
    let plain = pair::from_json(UNMODIFIED).unwrap();
    assert!(cycle(&plain, 40, 100.0).edge_load().is_some());
    assert_eq!(cycle(&pair, 40, 100.0).edge_load(), None);
}

#[test]
fn modified_pairs_are_solved_at_every_load_of_theirs() {
    let plain = pair::from_json(PAPER).unwrap();
    let mut steep = plain.clone();
    for gear in &mut steep.microgeometry.drive {
        gear.tip_relief.as_mut().unwrap().amount = 30e-6;
    }
    for (pair, torques) in [(&steep, [40.0, 200.0]), (&plain, [5.0, 0.1])] {
        let residuals = torques.map(|torque| cycle(pair, 40, torque).kkt_residual());
        assert!(residuals.iter().all(|residual| *residual < 1e-8));
    }
}
