//! Imports of a spring known by formula, and refusals.

use super::*;
use crate::samples::spur_pair;
use gearmesh::table::{FlankTable, Interpolation, Query};
use std::f64::consts::TAU;

/// F = k(p) delta with k = 2e8 (1 + 0.2 cos 2 pi p) N/m, contact 1 mm above mid-face.
fn stiffness(p: f64) -> f64 {
    2e8 * (1.0 + 0.2 * (TAU * p).cos())
}

fn csv(torques: &[f64]) -> String {
    let mut text = format!("# a spring\n{}\n", COLUMNS.join(","));
    let rb = spur_pair().gears[0].base_radius();
    for t in torques {
        for i in 0..16 {
            let p = f64::from(i) / 16.0;
            text += &format!("{t},{p},0,0,{},13.5\n", 1e6 * t / rb / stiffness(p));
        }
    }
    text
}

/// What the table says at the nominal state.
fn at(table: &FlankTable, delta: f64, mesh_position: f64) -> [f64; 4] {
    let query = Query::from([delta, 0.0, 0.0, mesh_position]);
    table.evaluate(&query, false).gradient
}

const TORQUES: [f64; 10] = [0.5, 2.0, 5.0, 10.0, 20.0, 40.0, 60.0, 90.0, 130.0, 200.0];

#[test]
fn a_linear_spring_comes_back_with_its_stiffness() {
    for torques in [&TORQUES[..], &[&[0.0], &TORQUES[..]].concat()] {
        let imported = import_csv(&csv(torques), &spur_pair()).unwrap();
        assert_eq!(imported.maximum_torque, 200.0);
        let table = FlankTable::new(&imported.grid, Interpolation::Spline).unwrap();
        for i in 0..400 {
            let p = 0.618 * f64::from(i) % 1.0;
            let delta = 1e-6 + 15e-6 * f64::from(i) / 400.0;
            let [found, _, moment, _] = at(&table, delta, p);
            approx::assert_relative_eq!(found, stiffness(p) * delta, max_relative = 1e-4);
            approx::assert_abs_diff_eq!(moment / found, 1e-3, epsilon = 1e-6);
        }
    }
}

#[test]
fn the_lowest_load_node_makes_a_linear_spring_exact_beyond_the_rounded_onset() {
    let imported = import_csv(&csv(&TORQUES), &spur_pair()).unwrap();
    let grid = &imported.grid;
    let span = |p: usize| grid.top_load_approach[p] - grid.no_load_approach[p];
    let nodes = &grid.axes.displacement_fraction;
    // Nodes at a sixteenth and a quarter of the displacement at 0.5 N m.
    let smallest = 0.5 / 200.0;
    approx::assert_relative_eq!(nodes[0], smallest / 16.0, max_relative = 1e-9);
    approx::assert_relative_eq!(nodes[1], smallest / 4.0, max_relative = 1e-9);
    for p in 0..16 {
        let line = stiffness(p as f64 / 16.0) * nodes[0] * span(p);
        approx::assert_relative_eq!(grid.loa_force[p], 19.0 / 28.0 * line, max_relative = 1e-9);
    }
    let table = FlankTable::new(grid, Interpolation::Spline).unwrap();
    for p in 0..16 {
        for share in [1.0, 1.7, 4.0, 50.0, 399.0] {
            let mesh_position = p as f64 / 16.0;
            let delta = grid.no_load_approach[p] + share * nodes[1] * span(p);
            let [force, ..] = at(&table, delta, mesh_position);
            let line = stiffness(mesh_position) * share * nodes[1] * span(p);
            approx::assert_relative_eq!(force, line, max_relative = 1e-8);
        }
    }
}

#[test]
fn a_byte_order_mark_quotes_spaces_and_empty_lines_change_nothing() {
    let good = csv(&TORQUES);
    let quoted = good.replacen("torque_nm,", "\"torque_nm\", ", 1);
    let quoted = quoted.replacen("\n0.5,0,", "\r\n\r\n\"0.5\",\t0 ,", 1);
    let quoted = format!("\u{feff}{quoted}\n\n");
    let [plain, quoted] = [good, quoted].map(|text| import_csv(&text, &spur_pair()).unwrap());
    assert_eq!(plain.grid, quoted.grid);
}

#[test]
fn a_resultant_off_the_face_is_refused_with_the_face_and_one_on_its_edge_is_not() {
    let good = csv(&TORQUES);
    let with = |z: &str| import_csv(&good.replacen(",13.5", &format!(",{z}"), 1), &spur_pair());
    for z in ["-0.01", "25.2", "13500"] {
        let text = with(z).unwrap_err().to_string();
        let words = [&format!("line 3: contact_z_mm = {z}"), "0 to 25 mm"];
        assert!(words.iter().all(|w| text.contains(w)), "{text}");
    }
    for z in ["0", "25", "-0.0005", "25.0005"] {
        with(z).unwrap();
    }
}

#[test]
fn samples_that_cannot_be_a_table_are_refused_by_line_and_value() {
    let good = csv(&TORQUES);
    let refused = |text: String| import_csv(&text, &spur_pair()).unwrap_err().to_string();
    let lines: Vec<&str> = good.lines().collect();
    let without = |i: usize| {
        let mut l = lines.clone();
        l.remove(i);
        l.join("\n")
    };
    let nan = good.replacen("13.5", "nan", 1);
    #[rustfmt::skip]
    let cases = [
        (without(20), &["no sample at torque_nm = 2, mesh_position = 0.125"][..]),
        (format!("{good}{}\n", lines[5]), &["line 163", "line 6"]),
        (good.replacen("2,0,0,0,", "2,0,0,0,-1e3,1\n#", 1), &["line 19: ste_loa_um = -1000", "torque_nm = 2, mesh_position = 0,"]),
        (nan.replace('\n', "\r\n"), &["line 3: contact_z_mm = nan"]),
        (nan, &["line 3: contact_z_mm = nan"]),
        (good.replacen("mesh_position", "position", 1), &["column `position`", "each of torque_nm,mesh_position,"]),
        (good.replacen("\n0.5,", "\n-0.5,", 1), &["torque_nm = -0.5"]),
        (csv(&TORQUES[..3]), &["at least 4"]),
        (String::new(), &["column `torque_nm`"]),
        (good.replacen("13.5", "13.5,1", 1), &["line: 3,", "7 fields", "6 fields"]),
        // A number of many digits has an exponent.
        (good.replacen(",13.5\n", ",1e300\n", 1), &["contact_z_mm = 1e300 at "]),
        (good.replacen("0.5,0,", "0.5,1e-300,", 1), &["no sample at"]),
    ];
    for (text, parts) in cases {
        let error = refused(text);
        assert!(parts.iter().all(|part| error.contains(part)), "{error}");
        assert!(error.len() < 300, "{error}");
    }
}

/// The doubt about a spring whose displacements are `scale` times those of [`csv`], on axes changed by `change`.
fn doubt(scale: f64, nominal_torque: f64, change: fn(&mut Axes)) -> Result<Option<String>, String> {
    let mut imported = import_csv(&csv(&TORQUES), &spur_pair()).unwrap();
    let grid = &mut imported.grid;
    for values in [&mut grid.no_load_approach, &mut grid.top_load_approach] {
        values.iter_mut().for_each(|v| *v *= scale);
    }
    change(&mut grid.axes);
    let doubt = imported.doubt(&spur_pair(), nominal_torque);
    doubt.map_err(|error| error.to_string())
}

#[test]
fn samples_that_no_simulation_can_use_are_refused_and_odd_ones_noted() {
    assert_eq!(doubt(1.0, 200.0, |_| ()), Ok(None));
    // A spring of 0.544 of the usual stiffness, 0.07 x 206 GPa x 25 mm, twenty times as soft.
    let note = doubt(20.0, 100.0, |_| ()).unwrap().unwrap();
    assert!(note.contains("0.027 times the stiffness usual"), "{note:?}");
    // The smallest torque above 0 is 0.5 N m.
    assert_eq!(doubt(1.0, 0.5, |_| ()), Ok(None));
    let note = doubt(1.0, 0.4, |_| ()).unwrap().unwrap();
    let assumed = "above 0 is 0.5, above the nominal torque of the pair file, 0.4 N m: below it loads follow an assumed onset";
    assert!(note.contains(assumed), "{note:?}");
    let unit = "times the stiffness usual for these teeth; give the transmission error on the line of action in um, and";
    let no_change: fn(&mut Axes) = |_| ();
    let no_parallel: fn(&mut Axes) = |axes| axes.misalignment = vec![1e-3, 1.5e-3, 2e-3, 3e-3];
    let no_nominal: fn(&mut Axes) =
        |axes| axes.center_distance_offset = vec![-100e-6, -50e-6, -20e-6, -10e-6];
    let torque = "is 200, below the nominal torque of the pair file, 250 N m";
    let tilted = "misalignment_mrad runs from 1 to 3 and leaves out 0";
    let apart = "center_distance_offset_um runs from -100 to -10";
    for (scale, nominal_torque, change, text) in [
        (1.0, 250.0, no_change, torque),
        // In metres, in millimetres, in nanometres.
        (1e-6, 100.0, no_change, unit),
        (1e-3, 100.0, no_change, unit),
        (1e3, 100.0, no_change, unit),
        (1.0, 100.0, no_parallel, tilted),
        (1.0, 100.0, no_nominal, apart),
    ] {
        let error = doubt(scale, nominal_torque, change).unwrap_err();
        assert!(error.contains(text), "{error}");
    }
}

#[test]
fn two_or_three_values_of_an_axis_are_refused_by_the_column() {
    let good = csv(&TORQUES);
    let (head, rows) = good.split_at(good.find("0.5,0,0,0").unwrap());
    for (offsets, words) in [
        (
            &["-20", "0", "20"][..],
            "center_distance_offset_um has 3 values; a cubic spline needs at least 4",
        ),
        (&["-20", "0"], "or give a single one"),
    ] {
        let all = offsets.iter().map(|um| {
            let lines = rows.lines().map(|line| {
                let cells: Vec<&str> = line.split(',').collect();
                [&cells[..2], &[um], &cells[3..]].concat().join(",") + "\n"
            });
            lines.collect::<String>()
        });
        let text = head.to_owned() + &all.collect::<String>();
        let refusal = import_csv(&text, &spur_pair()).unwrap_err().to_string();
        assert!(refusal.contains(words), "{refusal}");
    }
}
