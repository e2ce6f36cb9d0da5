//! Sweeps and grids to a stated error, on a spring whose solution is known.

use super::super::coverage::{default_axes, graded, low_load_error, measure, misalignments};
use super::super::sweep::{Position, Sample, StaticPosition};
use super::*;
use crate::samples::spur_pair;
use crate::spring::Spring;
use crate::static_contact::ContactError;
use gearmesh::contact::Prescribed;
use gearmesh::root::bisection;
use gearmesh::table::{Axis, Query};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Approach at which `force` is the one prescribed.
fn approach(prescribed: Prescribed, force: impl Fn(f64) -> f64) -> f64 {
    match prescribed {
        Prescribed::Approach(approach) => approach,
        Prescribed::Torque(torque) => {
            let target = torque / spur_pair().gears[0].base_radius();
            bisection([-1e-3, 1e-3], 80, |delta| force(delta) <= target)
        }
    }
}

const QUIET: Progress = &|_, _| ();

struct Formula;

/// At the coordinates of a query but its approach.
impl StaticPosition for Query {
    fn no_load_approach(&mut self, misalignment: f64) -> f64 {
        self.misalignment = misalignment;
        let force = |delta| Spring::potential(&Query { delta, ..*self }).gradient[0];
        approach(Prescribed::Torque(0.0), force)
    }

    fn solve(&mut self, prescribed: Prescribed, misalignment: f64) -> Result<Sample, ContactError> {
        self.misalignment = misalignment;
        let at = |delta| Spring::potential(&Query { delta, ..*self }).gradient;
        let approach = approach(prescribed, |delta| at(delta)[0]);
        let [loa_force, _, moment, _] = at(approach);
        Ok(Sample {
            approach,
            loa_force,
            moment,
            ..Sample::default()
        })
    }
}

impl StaticSource for Formula {
    fn position(&self, _: Flank, p: f64, c: f64) -> Result<Position<'_>, ContactError> {
        Ok(Box::new(Query::from([0.0, c, 0.0, p])))
    }
}

fn coverage() -> Coverage {
    Coverage {
        center_distance_offset: Some([-100e-6, 100e-6]),
        misalignment: Some([-3e-3, 3e-3]),
        nominal_torque: 10.0,
        maximum_torque: 20.0,
    }
}

#[test]
fn a_table_keeps_the_error_it_was_asked_for_at_points_of_its_own_choice_and_of_ours() {
    let (pair, coverage) = (spur_pair(), coverage());
    let misalignments = default_axes(&coverage).misalignment;
    let found = table_within(&Formula, &pair, &coverage, &misalignments, 2e-3, QUIET);
    let (grid, found) = found.unwrap();
    assert!(found.force_rms <= 2e-3, "{found:?}");
    let table = FlankTable::new(&grid, Interpolation::Spline).unwrap();
    // Other points than those `measure` draws.
    let mut random = Random::new(1);
    let (mut squares, n) = (0.0, 2000);
    for _ in 0..n {
        let mut q = coverage.draw_query(&mut random, 1.0);
        let torque = Prescribed::Torque(20.0 * random.next());
        let exact = q.solve(torque, q.misalignment).unwrap();
        q.delta = exact.approach;
        squares += (table.evaluate(&q, false).gradient[0] - exact.loa_force).powi(2);
    }
    let nominal = 10.0 / pair.gears[0].base_radius();
    let rms = f64::sqrt(squares / f64::from(n)) / nominal;
    assert!(rms < 2.5e-3, "{rms}");
    assert!((rms / found.force_rms - 1.0).abs() < 0.3, "{rms} {found:?}");
}

#[test]
fn held_out_points_have_a_value_in_every_part_of_each_range_and_share_positions() {
    let coverage = coverage();
    let held = coverage.draw(Random::new(SEED), 100, 8);
    assert_eq!(held.len(), 13);
    assert!(held.iter().all(|held| held.loads.len() == 8));
    let loads: Vec<[f64; 2]> = held.iter().flat_map(|held| held.loads.clone()).collect();
    for (values, [low, high]) in [
        (held.iter().map(|h| h.mesh_position).collect(), [0.0, 1.0]),
        (
            held.iter().map(|h| h.center_distance_offset).collect(),
            [-100e-6, 100e-6],
        ),
        (loads.iter().map(|l| l[0]).collect(), [0.0, 20.0]),
        (
            loads.iter().map(|l| l[1]).collect::<Vec<f64>>(),
            [-3e-3, 3e-3],
        ),
    ] {
        let n = values.len();
        let part = |x: &f64| ((x - low) / (high - low) * n as f64) as usize;
        let mut parts: Vec<usize> = values.iter().map(part).collect();
        assert!(!parts.is_sorted(), "in random order");
        parts.sort_unstable();
        assert_eq!(parts, (0..n).collect::<Vec<_>>());
    }
    let parallel = Coverage {
        misalignment: None,
        ..coverage
    };
    let held = parallel.draw(Random::new(SEED), 4, 1);
    assert!(held.iter().all(|held| held.loads[0][1] == 0.0));
}

#[test]
fn only_the_dimensions_asked_for_are_computed() {
    let done = AtomicUsize::new(0);
    let watched = |now, all| {
        assert!(now <= all);
        done.fetch_max(now, Ordering::Relaxed);
    };
    let axes = default_axes(&Coverage {
        center_distance_offset: None,
        ..coverage()
    });
    let grid = sweep(&Formula, Flank::Drive, &axes, 20.0, &watched).unwrap();
    grid.check("drive").unwrap();
    assert_eq!(grid.axes.present(), [false, true, true]);
    assert_eq!(done.into_inner(), 36, "columns of misalignments and loads");
}

#[test]
fn misalignments_go_on_beyond_limits_on_either_side_of_parallel_axes() {
    let nodes = |range| {
        let coverage = Coverage {
            misalignment: Some(range),
            ..coverage()
        };
        let nodes = misalignments(&Formula, &spur_pair(), &coverage).unwrap();
        assert!(nodes.windows(2).all(|w| w[0] < w[1]), "{nodes:?}");
        let inside = coverage.inside_of(&nodes);
        assert_eq!([nodes[inside.start], nodes[inside.end - 1]], range);
        [nodes[0], nodes[nodes.len() - 1]]
    };
    assert_eq!(nodes([-2e-3, 1e-3]), [1.6 * -2e-3, 1.6 * 1e-3]);
    assert_eq!(nodes([0.0, 1e-3]), [0.0, 1e-3]);
}

#[test]
fn graded_axes_keep_their_ends_and_contain_parallel_axes() {
    for grading in [0.0, 1.5, 3.0] {
        let axis = graded([-3e-3, 3e-3], 9, grading);
        assert_eq!((axis[0], axis[4], axis[8]), (-3e-3, 0.0, 3e-3));
        assert!(axis.windows(2).all(|w| w[0] < w[1]));
        let one_sided = graded([0.0, 3e-3], 5, grading);
        assert_eq!((one_sided[0], one_sided[4]), (0.0, 3e-3));
    }
}

/// Face of [`spur_pair`], m, and its stiffness over the face, N/m²: 10 N m press it together by a micrometre.
const FACE: f64 = 25e-3;
const OVER_FACE: f64 = 1e10;

/// A bed of springs over the face: tilted, one end touches first.
struct Wedge;

impl Wedge {
    /// Force and moment at an approach, m, and a misalignment, rad.
    fn loads(approach: f64, misalignment: f64) -> [f64; 2] {
        let (slope, half) = (misalignment.abs(), 0.5 * FACE);
        // From here on the springs are pressed together; this end of the face is the one that is lifted.
        let low = match approach {
            d if slope == 0.0 && d <= 0.0 => half,
            _ if slope == 0.0 => -half,
            d => (-d / slope).clamp(-half, half),
        };
        let power = |n: i32| (half.powi(n) - low.powi(n)) / f64::from(n);
        let force = approach * power(1) + slope * power(2);
        let moment = approach * power(2) + slope * power(3);
        [
            OVER_FACE * force,
            OVER_FACE * moment * misalignment.signum(),
        ]
    }
}

impl StaticPosition for Wedge {
    fn no_load_approach(&mut self, misalignment: f64) -> f64 {
        -0.5 * FACE * misalignment.abs()
    }

    fn solve(&mut self, prescribed: Prescribed, misalignment: f64) -> Result<Sample, ContactError> {
        let approach = approach(prescribed, |delta| Wedge::loads(delta, misalignment)[0]);
        let [loa_force, moment] = Wedge::loads(approach, misalignment);
        Ok(Sample {
            approach,
            loa_force,
            moment,
            ..Sample::default()
        })
    }
}

impl StaticSource for Wedge {
    fn position(&self, _: Flank, _: f64, _: f64) -> Result<Position<'_>, ContactError> {
        Ok(Box::new(Wedge))
    }
}

#[test]
fn a_tilt_far_beyond_the_deflection_of_the_teeth_still_has_a_table() {
    let pair = spur_pair();
    for range in [[-6e-3, 6e-3], [-20e-3, 20e-3], [-5e-3, 8e-3], [0.0, 10e-3]] {
        let coverage = Coverage {
            center_distance_offset: None,
            misalignment: Some(range),
            ..coverage()
        };
        let grid = |misalignment: Vec<f64>| {
            let axes = Axes {
                misalignment,
                mesh_position: vec![0.0],
                ..default_axes(&coverage)
            };
            let grid = sweep(&Wedge, Flank::Drive, &axes, 20.0, QUIET).unwrap();
            FlankTable::new(&grid, Interpolation::Spline)
        };
        let nodes = misalignments(&Wedge, &pair, &coverage).unwrap();
        assert!(range.iter().all(|end| nodes.contains(end)));
        assert!(nodes.windows(2).all(|w| w[0] < w[1]));
        let error = low_load_error(&Wedge, &pair, &coverage, &nodes).unwrap();
        assert!(error <= 0.02, "{range:?}: {error}");
        if range[0] == -range[1] {
            let usual = grid(default_axes(&coverage).misalignment);
            let is_too_coarse = matches!(
                usual,
                Err(TableError::TooCoarse {
                    axis: Axis::Misalignment,
                    ..
                })
            );
            assert!(is_too_coarse, "{range:?}");
        }
        let table = grid(nodes.clone()).unwrap();
        let found = measure(&Wedge, &pair, Flank::Drive, &coverage, &table, 500).unwrap();
        assert!(found.force_rms < 0.02, "{range:?}: {found:?}");
        let sought = table_within(&Wedge, &pair, &coverage, &nodes, 5e-3, QUIET);
        let (_, sought) = sought.unwrap();
        assert!(sought.force_rms < 5e-3, "{range:?}: {sought:?}");
    }
}

#[test]
fn a_tilt_that_teeth_follow_keeps_the_usual_misalignments() {
    let usual = default_axes(&coverage()).misalignment;
    let nodes = |coverage| misalignments(&Formula, &spur_pair(), &coverage).unwrap();
    assert_eq!(nodes(coverage()), usual);
    let parallel = Coverage {
        misalignment: None,
        ..coverage()
    };
    assert_eq!(nodes(parallel), [0.0]);
}
