//! Tables and samples with other numbers in them: refused with the field named, or evaluated without a panic.
//!
//! Pair files have tests of this kind beside their code. `PROPTEST_CASES` sets the number of files tried.

use std::sync::LazyLock;

use gearmesh::gear::{Flank, samples};
use gearmesh::table::samples::Spring;
use gearmesh::table::{COORDINATES, Effects, Interpolation, Load, Query, Table, TableFile};
use proptest::prelude::*;
use serde_json::Value;

/// All numbers of a JSON value.
fn numbers(value: &mut Value) -> Vec<&mut Value> {
    match value {
        Value::Number(_) => vec![value],
        Value::Array(items) => items.iter_mut().flat_map(numbers).collect(),
        Value::Object(fields) => fields.values_mut().flat_map(numbers).collect(),
        _ => Vec::new(),
    }
}

static TABLES: LazyLock<Value> = LazyLock::new(|| {
    let grid = Spring::grid([6, 4, 4, 6]);
    let pair = samples::paper_pair(1.0);
    let file = TableFile::new("spring", "a formula", &pair, [100.0, 200.0], &grid, None);
    serde_json::from_str(&file.to_json()).unwrap()
});

/// Factors near one give files that are often accepted, the others reach into the odd corners.
fn factor() -> impl Strategy<Value = f64> {
    prop_oneof![
        3 => 0.9..1.1f64,
        1 => -3.0..3.0f64,
        1 => prop::sample::select(vec![0.0, 1e-15, 1e-9, 1e-5, 1e5, 1e9, 1e-300, 1e300]),
    ]
}

/// Evaluates every level of detail that the file serves, within its range and far beyond.
fn evaluate(table: &Table) {
    for (interpolation, load) in [
        (Interpolation::Spline, Load::Variable),
        (Interpolation::Linear, Load::Variable),
        (Interpolation::Shepard, Load::Variable),
        (Interpolation::Spline, Load::Constant { loa_force: 2000.0 }),
    ] {
        let effects = Effects {
            interpolation,
            load,
            ..*table.effects()
        };
        let Ok(table) = table.sliced(&effects) else {
            continue;
        };
        let (flank, _) = table.flank(Flank::Drive);
        for i in 0..40 {
            let [a, b, c] = [7, 11, 13].map(|prime| f64::from(i % prime) / f64::from(prime - 1));
            let query = Query {
                delta: 60e-6 * (a - 0.2),
                center_distance_offset: 4e-4 * (b - 0.5),
                misalignment: 8e-3 * (c - 0.5),
                mesh_position: 3.0 * a - 1.0,
            };
            let potential = flank.evaluate(&query, true);
            let numbers = potential.gradient.iter().chain([&potential.value]);
            assert_eq!(potential.gradient.len(), COORDINATES);
            assert!(
                numbers.into_iter().all(|v| v.is_finite()),
                "{query:?} {potential:?}"
            );
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..Default::default() })]

    #[test]
    fn tables_with_other_numbers_are_refused_by_field_or_evaluated(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<bool>(), factor()), 1..4),
    ) {
        let mut json = TABLES.clone();
        for (index, in_axes, factor) in changes {
            // Axes are few numbers among many samples.
            let part = if in_axes { &mut json["axes"] } else { &mut json };
            let mut all = numbers(part);
            let place = index.index(all.len());
            let old = all[place].clone();
            let new = old.as_f64().unwrap() * factor;
            *all[place] = if old.is_u64() { Value::from(new as i64) } else { Value::from(new) };
        }
        let sealed = serde_json::from_value::<TableFile>(json).map(|mut file| {
            file.seal();
            file.to_json()
        });
        // A number that is none, or a negative one where a count stands, has no place in the file's types.
        if let Ok(text) = sealed {
            match Table::from_json(&text) {
                Ok(table) => evaluate(&table),
                Err(error) => {
                    let text = error.to_string();
                    // "field = value: reason" or "field: reason".
                    prop_assert!(text.contains(" = ") || text.contains(": "), "{text}");
                },
            }
        }
    }

    #[test]
    fn samples_with_other_numbers_are_refused_by_line_or_become_tables(
        changes in prop::collection::vec((0..4usize * 8, 0..6usize, factor()), 0..3),
        cut in any::<prop::sample::Index>(),
        whole in any::<bool>(),
    ) {
        use gearmesh::table::import::{COLUMNS, import_csv};
        let geometry = samples::spur_pair();
        let arm = geometry.gears[0].base_radius();
        let mut rows: Vec<[f64; 6]> = [10.0, 50.0, 120.0, 200.0]
            .iter()
            .flat_map(|torque| {
                (0..8).map(move |i| {
                    let approach = 1e6 * torque / arm / 2e8;
                    [*torque, f64::from(i) / 8.0, 0.0, 0.0, approach, 13.5]
                })
            })
            .collect();
        for (row, column, factor) in changes {
            rows[row][column] *= factor;
        }
        let mut text = COLUMNS.join(",") + "\n";
        for row in rows {
            text += &(row.map(|v| v.to_string()).join(",") + "\n");
        }
        if !whole {
            text.truncate(cut.index(text.len()));
        }
        match import_csv(&text, &geometry) {
            Ok(imported) => {
                let torques = [0.5 * imported.maximum_torque, imported.maximum_torque];
                let file =
                    TableFile::new("samples", "a formula", &geometry, torques, &imported.grid, None);
                if let Ok(table) = Table::from_file(file) {
                    evaluate(&table);
                }
            }
            Err(error) => prop_assert!(!error.to_string().is_empty()),
        }
    }
}
