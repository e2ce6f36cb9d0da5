//! Tables: refused by field, or numbers at every level of detail, within their range and far beyond.

use std::collections::BTreeMap;

use super::spring::Spring;
use gearmesh::friction::FrictionLaw;
use gearmesh::gear::Flank;
use gearmesh::table::{
    Effects, FrictionRecord, GearTeethRecord, Interpolation, InterpolationError, Load, LoadAxes,
    LoadJet, Potential, Query, RootStressError, RootStressRecord, RootStressSamples,
    SlidingSamples, Table, TableError, TableFile, TeethRecord,
};

use super::{Target, change, gears};

/// A formula over all axes with everything a table may hold, and tables of a solver.
pub const TARGET: Target = Target {
    seeds: || {
        vec![
            formula([4, 4, 4, 4]).to_json().into_bytes(),
            formula([8, 1, 1, 6]).to_json().into_bytes(),
            include_bytes!("../../examples/drivelines/pairs/spur-50-50.tables.json").to_vec(),
        ]
    },
    change: change::json,
    check,
};

/// A spring by formula with friction, root stress and tooth pairs one by one beside it.
pub fn formula(counts: [usize; 4]) -> TableFile {
    let grid = Spring::grid(counts);
    let pair = gears::paper_pair(1.0);
    let mut file = TableFile::new("spring", "a formula", &pair, [100.0, 200.0], &grid, None);
    let axes = |forces: [f64; 4]| LoadAxes {
        center_distance_offset_m: grid.axes.center_distance_offset.clone(),
        misalignment_rad: grid.axes.misalignment.clone(),
        loa_force_n: forces.to_vec(),
        mesh_position: grid.axes.mesh_position.clone(),
    };
    let ratios = axes([500.0, 1000.0, 2000.0, 5000.0]);
    let effects = axes([0.0, 1000.0, 2000.0, 5000.0]);
    let count: usize = ratios.lengths().iter().product();
    let values = |scale: f64| (0..count).map(|i| scale * (1.0 + (i % 7) as f64)).collect();
    file.friction = Some(FrictionRecord {
        law: FrictionLaw::XuKahraman {
            dynamic_viscosity_pa_s: 0.05,
            roughness_rms_m: 0.4e-6,
        },
        axes: ratios,
        drive: SlidingSamples {
            share: values(0.1),
            share_z_m: values(1e-3),
            distance_m: values(1e-3),
            weight: Some(values(0.5)),
        },
        coast: None,
    });
    file.root_stress = Some(RootStressRecord {
        axes: effects,
        drive: RootStressSamples {
            gear_1_pa: values(1e7),
            gear_2_pa: values(2e7),
        },
        coast: None,
        interpolation_error: RootStressError::default(),
    });
    file.teeth = Some(TeethRecord {
        axes: file.axes.clone(),
        first_place: -1.0,
        last_place: 1.2,
        coupling_m_per_n: vec![vec![1e-10]],
        drive: file.drive.clone(),
        coast: None,
        coast_coupling_m_per_n: None,
        drive_errors: [1.0, 0.0].map(|share| GearTeethRecord {
            index_m: (0..20).map(|i| 1e-6 * share * f64::from(i % 7)).collect(),
            runout_m: 10e-6 * (1.0 - share),
            runout_angle_rad: 0.3,
        }),
        coast_errors: Default::default(),
        friction: None,
        error: InterpolationError::default(),
    });
    file.solver = BTreeMap::new();
    file.seal();
    file
}

/// See [`Target::check`]. The checksum is put right: whoever means harm can do that, too.
pub fn check(data: &[u8]) -> bool {
    if let Ok(text) = str::from_utf8(data)
        && let Err(error) = TableFile::from_json(text)
    {
        report(&error);
    }
    // A number that is none, or a negative one where a count stands, has no place in the file's types.
    match serde_json::from_slice::<TableFile>(data) {
        Ok(mut file) => {
            file.seal();
            told(TableFile::from_json(&file.to_json())).is_some_and(check_file)
        }
        Err(_) => false,
    }
}

/// A refusal names what is wrong, "field = value: reason" or "field: reason", and can be read.
pub fn report(error: &TableError) {
    let message = error.to_string();
    assert!(
        message.contains(" = ") || message.contains(": "),
        "{message}"
    );
    assert!(message.len() < 500, "{message}");
}

/// What was made, if it was; else its refusal is looked at.
fn told<T>(made: Result<T, TableError>) -> Option<T> {
    made.inspect_err(report).ok()
}

/// Whether tables can be made of the file; they are evaluated.
pub fn check_file(file: TableFile) -> bool {
    let table = told(Table::from_file(file));
    table.is_some_and(|table| {
        evaluate(&table);
        true
    })
}

/// Every level of detail that the file serves.
fn evaluate(table: &Table) {
    let file = &table.file;
    for (interpolation, load) in [
        (Interpolation::Spline, Load::Variable),
        (Interpolation::Linear, Load::Variable),
        (Interpolation::Shepard, Load::Variable),
        (Interpolation::Spline, Load::Constant { loa_force: 2000.0 }),
    ] {
        let effects = Effects {
            interpolation,
            load,
            friction: file.friction.is_some(),
            root_stress: file.root_stress.is_some(),
            teeth: file.teeth.is_some(),
            ..table.effects
        };
        let Some(table) = told(Table::with_effects(file.clone(), effects)) else {
            continue;
        };
        for flank in [Flank::Drive, Flank::Coast] {
            for i in 0..40 {
                let [a, b, c] =
                    [7, 11, 13].map(|prime| f64::from(i % prime) / f64::from(prime - 1));
                evaluate_at(
                    &table,
                    flank,
                    &Query {
                        delta: 60e-6 * (a - 0.2),
                        center_distance_offset: 4e-4 * (b - 0.5),
                        misalignment: 8e-3 * (c - 0.5),
                        mesh_position: 3.0 * a - 1.0,
                    },
                );
            }
        }
    }
}

fn evaluate_at(table: &Table, flank: Flank, query: &Query) {
    let teeth = table
        .teeth(flank)
        .map(|(teeth, _)| teeth.evaluate(query, [3, -5], true));
    if let Some(potential) = teeth {
        finite_potential(query, &potential);
    }
    let potential = table.flank(flank).0.evaluate(query, true);
    finite_potential(query, &potential);
    let load = [
        potential.gradient[0].max(0.0),
        query.center_distance_offset,
        query.misalignment,
        query.mesh_position,
    ];
    let finite = |jets: &[LoadJet]| {
        let all_finite = |jet: &LoadJet| {
            jet.gradient
                .iter()
                .chain([&jet.value])
                .all(|v| v.is_finite())
        };
        assert!(jets.iter().all(all_finite), "{load:?} {jets:?}");
    };
    if let Some((sliding, _)) = table.sliding(flank) {
        finite(&sliding.evaluate::<4>(load));
    }
    if let Some((stress, _)) = table.root_stress(flank) {
        finite(&stress.evaluate::<2>(load));
    }
}

fn finite_potential(query: &Query, potential: &Potential) {
    let hessian = potential.hessian.iter().flatten();
    let numbers = potential
        .gradient
        .iter()
        .chain(hessian)
        .chain([&potential.value]);
    assert!(
        numbers.into_iter().all(|v| v.is_finite()),
        "{query:?} {potential:?}"
    );
}
