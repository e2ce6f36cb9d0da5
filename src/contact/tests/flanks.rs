//! Relieved flanks, pressures and what no pair may be refused for.

use super::*;
use crate::contact::closest::Flanks;
use crate::contact::local::constants::LEAST_CURVATURE;
use crate::contact::numbers::PairNumbers;
use crate::contact::transverse::TransverseSection;
use crate::gear::{Flank, ProfileRelief, ReliefShape, ToothProfile, Topography};
use approx::{assert_abs_diff_eq, assert_relative_eq};

const PAPER: &str = include_str!("../../../resources/pairs/palermo2013.json");
const UNMODIFIED: &str = include_str!("../../../resources/pairs/palermo2013-unmodified.json");
const FZG_C: &str = include_str!("../../../resources/pairs/fzg-c.json");

/// Some place along the face, m.
const Z: f64 = 7e-3;

/// The paper's pair with `amount` (m) of tip relief on both gears over the last part `share` of the path.
fn relieved(amount: f64, share: f64) -> Pair {
    let mut pair = Pair::from_json(UNMODIFIED).unwrap();
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

fn section(pair: &Pair) -> TransverseSection {
    let g = &pair.geometry;
    let forms = [0, 1].map(|i| ToothProfile::new(&g.gears[i]).unwrap().form_roll());
    TransverseSection::new(&PairNumbers::new(g), g.center_distance, forms, Some(100e-6)).unwrap()
}

#[test]
fn steeply_relieved_flanks_touch_below_the_nominal_line() {
    let pair = relieved(25e-6, 0.2);
    let (g, section) = (&pair.geometry, section(&pair));
    let path = g.path_of_contact(g.center_distance);
    let relief = pair.microgeometry.drive[0].tip_relief.unwrap();
    // Well within the relief of gear 1.
    let at = section.point(path.end - 0.03 * path.length());
    let found =
        Flanks::new(g, &section, pair.microgeometry.drive.each_ref(), at, Z).closest_point();
    let gear = &g.gears[0];
    let cos = g.base_helix_angle().cos();
    let radius = 1.0 / (1.0 / at.roll[0] + 1.0 / at.roll[1]);
    // Slope per length of flank, of the gap along the line of action.
    let theta = relief.amount / (relief.end_roll - relief.start_roll) * gear.base_radius()
        / at.roll[0]
        / cos;
    let moved = at.roll[0] - found.roll[0];
    let expected = radius * theta * gear.base_radius() / at.roll[0];
    assert!((moved / expected - 1.0).abs() < 1e-6, "{moved} {expected}");
    let nominal = relief.piece(at.roll[0]).removal / cos;
    let less = nominal - found.gap;
    assert!(
        (less / (0.5 * theta * theta * radius) - 1.0).abs() < 1e-6,
        "{less}"
    );
}

#[test]
fn the_closest_point_is_the_least_gap_of_all() {
    let mut pair = relieved(20e-6, 0.15);
    pair.microgeometry.drive[1]
        .tip_relief
        .as_mut()
        .unwrap()
        .shape = ReliefShape::Parabolic;
    let (g, section) = (&pair.geometry, section(&pair));
    let [first, last] = section.reach();
    for step in 0..=200 {
        let at = section.point(first + (last - first) * f64::from(step) / 200.0);
        let found =
            Flanks::new(g, &section, pair.microgeometry.drive.each_ref(), at, Z).closest_point();
        let curvature: f64 = at.roll.iter().map(|roll| roll.recip()).sum();
        let at_distance = |s: f64| {
            let rolls = [0, 1].map(|i| {
                let sense = [1.0, -1.0][i];
                at.roll[i] + sense * s * g.gears[i].base_radius() / at.roll[i]
            });
            let within = (0..2).all(|i| {
                let [tip, form] = section.flank_ends(i);
                rolls[i] <= tip + 1e-12 && rolls[i] >= form
            });
            let removal: f64 = (0..2)
                .map(|i| pair.microgeometry.drive[i].removal(&g.gears[i], rolls[i], Z))
                .sum();
            within.then_some(
                at.separation
                    + at.slope * s
                    + 0.5 * s * s * curvature
                    + removal / g.base_helix_angle().cos(),
            )
        };
        let least = (-2000..=2000)
            .filter_map(|s| at_distance(1e-6 * f64::from(s)))
            .fold(f64::INFINITY, f64::min);
        assert!(
            found.gap <= least + 1e-13 && found.gap > least - 2e-8,
            "{step}: {} {least}",
            found.gap
        );
        if at.separation > 0.0 {
            continue;
        }
        // The profile is the gap about that point, but for its involutes' curvature, which is that of the closest point.
        for t in [-0.2e-3, -0.05e-3, 0.05e-3, 0.2e-3] {
            let Some(gap) = at_distance(found.s + t) else {
                continue;
            };
            let along_action = found.profile.gap(t) / g.base_helix_angle().cos();
            let involutes = 0.5 * t * t * found.profile.curvature;
            assert_abs_diff_eq!(
                along_action,
                gap - found.gap,
                epsilon = 0.2 * involutes + 1e-12
            );
        }
    }
}

#[test]
fn flanks_without_profile_modifications_touch_on_the_nominal_line() {
    let pair = Pair::from_json(UNMODIFIED).unwrap();
    let section = section(&pair);
    for xi in section.reach() {
        let at = section.point(0.8 * xi);
        let found = Flanks::new(
            &pair.geometry,
            &section,
            pair.microgeometry.drive.each_ref(),
            at,
            Z,
        )
        .closest_point();
        assert_eq!((found.roll, found.gap), (at.roll, at.separation));
        assert_eq!((found.profile.slope, found.arms), (0.0, at.arms));
    }
}

fn cycle(pair: &Pair, stations: usize, torque: f64) -> MeshCycle {
    let settings = ContactSettings {
        stations,
        ..ContactSettings::for_pair(pair)
    };
    let input = CycleInput {
        flank: Flank::Drive,
        torque,
        center_distance_offset: 0.0,
        misalignment: 0.0,
        positions: 16,
    };
    MeshCycle::solve(&coarse_solver(pair, settings), &input).unwrap()
}

#[test]
fn flank_pressure_does_not_grow_with_the_number_of_stations_nor_at_tip_edges() {
    // Hertz: pressures between 800 and 1050 MPa, and some 1700 MPa.
    for (text, torque, low, high) in [
        (UNMODIFIED, 100.0, 800.0, 1100.0),
        (FZG_C, 302.0, 1500.0, 1900.0),
    ] {
        let pair = Pair::from_json(text).unwrap();
        let cycles = [20, 40, 80].map(|stations| cycle(&pair, stations, torque));
        let [_, middle, fine] = cycles.each_ref().map(|cycle| 1e-6 * cycle.max_pressure());
        assert!((low..high).contains(&middle), "{}: {middle}", pair.name);
        assert!(
            (fine / middle - 1.0).abs() < 0.03,
            "{}: {middle} {fine}",
            pair.name
        );
        assert!(cycles[1].edge_load().is_some(), "{}", pair.name);
    }
}

#[test]
fn the_largest_pressure_where_a_contact_line_crosses_the_start_of_a_relief_is_found_between_stations()
 {
    // Both reliefs start at the pitch point, which the contact line crosses at mid-face at position 0: an end of two strips, in whose
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
    let gear = |more: &str| {
        format!(
            r#"{{ {more}, "addendum_coefficient": 1.2, "dedendum_coefficient": 1.5, "tool_tip_radius_coefficient": 0.3,
                 "tip_relief": {{ "amount_um": {amount}, "start": "pitch_point", "shape": "parabolic" }} }}"#
        )
    };
    let gears = [
        r#""teeth": 23, "profile_shift": 0.3, "face_width_mm": 30.0, "bore_diameter_mm": 28.0, "lead_crowning_um": 4.0"#,
        r#""teeth": 81, "face_width_mm": 28.0, "bore_diameter_mm": 60.0"#,
    ]
    .map(gear);
    let text = format!(
        r#"{{ "name": "steep helix", "meshing": "external", "normal_module_mm": 1.75, "normal_pressure_angle_deg": 17.5,
             "helix_angle_deg": 29.5, "backlash_um": 90.0, "face_offset_mm": 1.0, "gear1": {}, "gear2": {},
             "operating": {{ "nominal_torque_nm": 150.0, "maximum_torque_nm": 300.0,
               "center_distance_offset_um": [-30.0, 60.0], "misalignment_mrad": [-1.5, 1.5] }} }}"#,
        gears[0], gears[1]
    );
    Pair::from_json(&text).unwrap()
}

#[test]
fn line_loads_at_the_tip_edges_of_a_steep_helix_do_not_depend_on_the_stations() {
    // Relief that keeps contact off the edges: the mean of a strip that reaches them is 77 and 18 N/mm. And less of it.
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
    let plain = Pair::from_json(UNMODIFIED).unwrap();
    assert!(cycle(&plain, 40, 100.0).edge_load().is_some());
    assert_eq!(cycle(&pair, 40, 100.0).edge_load(), None);
}

#[test]
fn modified_pairs_are_solved_at_every_load_of_theirs() {
    let mut steep = Pair::from_json(PAPER).unwrap();
    for gear in &mut steep.microgeometry.drive {
        gear.tip_relief.as_mut().unwrap().amount = 30e-6;
    }
    let plain = Pair::from_json(PAPER).unwrap();
    for (pair, torque) in [
        (&steep, 40.0),
        (&steep, 200.0),
        (&plain, 5.0),
        (&plain, 0.1),
    ] {
        assert!(cycle(pair, 40, torque).kkt_residual() < 1e-8);
    }
}

#[test]
fn the_smallest_pair_file_is_solved_up_to_its_limits() {
    // docs/pair-file.md
    let file = |more: &str| {
        format!(
            r#"{{ "name": "first-pair", "meshing": "external", "normal_module_mm": 3.0,
                 "normal_pressure_angle_deg": 20.0,
                 "gear1": {{ "teeth": 24, "face_width_mm": 20.0, {more} }},
                 "gear2": {{ "teeth": 36, "face_width_mm": 20.0, {more} }},
                 "operating": {{ "nominal_torque_nm": 100.0, "maximum_torque_nm": 200.0,
                   "center_distance_offset_um": [-20.0, 50.0], "misalignment_mrad": [-1.0, 1.0] }} }}"#
        )
    };
    for more in [
        r#""profile_crowning_um": 150.0"#,
        r#""bore_diameter_mm": 1.0"#,
    ] {
        let pair = Pair::from_json(&file(more)).unwrap();
        for torque in [10.0, 100.0, 200.0] {
            assert!(cycle(&pair, 40, torque).kkt_residual() < 1e-8, "{more}");
        }
    }
}

#[test]
fn a_hollow_that_fits_the_mate_leaves_a_tenth_of_the_curvature() {
    let mut pair = Pair::from_json(UNMODIFIED).unwrap();
    let section = section(&pair);
    let at = section.point(0.0);
    let curvature = |pair: &Pair| {
        let drive = pair.microgeometry.drive.each_ref();
        let found = Flanks::new(&pair.geometry, &section, drive, at, Z).closest_point();
        assert!(found.s.abs() < 1e-8, "{}", found.s);
        found.profile.curvature
    };
    let plain = curvature(&pair);
    let by_s = pair.geometry.gears[0].base_radius() / at.roll[0];
    for (part, left) in [(0.5, 0.5), (0.97, LEAST_CURVATURE)] {
        let rolls: Vec<f64> = (-20..=20)
            .map(|i| at.roll[0] + 0.03e-3 * f64::from(i))
            .collect();
        let removal = |roll: &f64| {
            let s = (roll - at.roll[0]) / by_s;
            vec![50e-6 - 0.5 * part * plain * s * s; 3]
        };
        let removals = rolls.iter().map(removal).collect();
        let grid = Topography::new(rolls, vec![0.0, 10e-3, 25e-3], removals).unwrap();
        pair.microgeometry.drive[0].topography = Some(std::sync::Arc::new(grid));
        let found = curvature(&pair) / plain;
        assert!(
            (found / left - 1.0).abs() < 1e-3,
            "{found} instead of {left}"
        );
    }
}
