//! Loss by the share of the load, against loss factors of another program.

use super::*;
use crate::fzg::{FZG, c14};
use gearmesh::contact::Segment;
use gearmesh_preprocessor::compliance::{BeyondModel, ToothCompliance};
use nalgebra::DMatrix;

/// Segments that do not know of each other: where forces are prescribed, no more is asked.
struct Alone;

impl ToothCompliance for Alone {
    fn bulk(&self, segments: &[Segment]) -> Result<DMatrix<f64>, BeyondModel> {
        Ok(DMatrix::identity(segments.len(), segments.len()) * 1e-8)
    }

    fn reference_lengths(&self, segments: &[Segment]) -> Vec<f64> {
        vec![1e-3; segments.len()]
    }
}

/// Sliding of a mesh cycle under the line load that rigid teeth share: the same on all contact lines.
fn even_line_load(pair: &Pair) -> Vec<Sliding> {
    let settings = ContactSettings {
        tip_corner_contact: false,
        stations: 200,
        ..ContactSettings::default()
    };
    let solver = ContactSolver::new(pair, [Arc::new(Alone), Arc::new(Alone)], settings).unwrap();
    let cos_beta_b = pair.geometry.base_helix_angle().cos();
    (0..200)
        .map(|i| {
            let problem = solver.position(Flank::Drive, (f64::from(i) + 0.5) / 200.0, 0.0);
            let problem = problem.unwrap();
            let segments = problem.candidates().iter().map(|c| SegmentLoad {
                force: c.z[1] - c.z[0],
                ..SegmentLoad::default()
            });
            let segments: Vec<SegmentLoad> = segments.collect();
            let result = ContactResult {
                loa_force: cos_beta_b * segments.iter().map(|s| s.force).sum::<f64>(),
                segments,
                ..ContactResult::default()
            };
            solver.sliding(&problem, &result, &FrictionLaw::default())
        })
        .collect()
}

#[test]
fn loss_factors_of_rigid_teeth_are_those_of_another_program() {
    for (name, geometry, _, _, listed) in FZG.map(|data| data.pair()) {
        let sliding = even_line_load(&pair_of(geometry.clone()));
        let found = loss_factor_of(&geometry, Sliding::mean_distance(&sliding));
        let error = found / listed - 1.0;
        assert!(error.abs() < 6e-3, "{name}: {found}, listed {listed}");
        assert!(sliding.iter().all(|s| (s.weight - 1.0).abs() < 1e-12));
    }
}

#[test]
fn the_fzg_pair_loses_what_schlenks_coefficient_says() {
    let geometry = c14();
    let sliding = even_line_load(&pair_of(geometry.clone()));
    let law = FrictionLaw::schlenk(13.28e-3, [0.4e-6, 0.31e-6], 0.846);
    let spin = 1500.0 * TAU / 60.0;
    let loss = Loss::new(&geometry, &law, [&sliding, &sliding], 200.0, spin);
    assert_abs_diff_eq!(loss.coefficient, 0.0449, epsilon = 0.5e-4);
    assert_abs_diff_eq!(loss.power, 274.0, epsilon = 1.0);
    let part = 274.0 / (200.0 * spin);
    assert_abs_diff_eq!(1.0 - loss.efficiency, part, epsilon = 1e-4);
}
