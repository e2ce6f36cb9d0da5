//! Transmission error over torque and over misalignment, and what friction takes.

use gearmesh::contact::{ContactError, ContactSolver};
use gearmesh::friction::{Loss, ohlendorf};
use gearmesh::gear::Flank;
use gearmesh::pair::Pair;
use gearmesh::words::rounded;
use gearmesh_preprocessor::contact::{CycleInput, LoadCase};

use super::chart::{Curve, Height, Map, cells_around, draw_map, line_chart};
use super::page::Page;
use crate::Error;
use crate::case::{Case, torque_in_words};

/// Torques up to the largest one, and speeds.
const TORQUES: usize = 12;
const SPEEDS: usize = 12;
const MISALIGNMENTS: usize = 9;
/// Positions over a mesh cycle: enough for five harmonics and within a few per cent of the peak-to-peak value.
const POSITIONS: usize = 24;
const HARMONICS: usize = 3;
/// Least top of a scale, um.
const LEAST_TOP: f64 = 1e-3;

/// Mesh cycles of the drive flank for each of `torques` (N m) with each of `misalignments` (rad).
pub fn cases(
    solver: &ContactSolver,
    torques: &[f64],
    misalignments: &[f64],
    positions: usize,
) -> Result<Vec<Case>, ContactError> {
    let input = CycleInput {
        flank: Flank::Drive,
        torque: 0.0,
        center_distance_offset: 0.0,
        misalignment: 0.0,
        positions,
    };
    let at_torque = |&torque| {
        misalignments.iter().map(move |&misalignment| LoadCase {
            torque,
            misalignment,
        })
    };
    let loads: Vec<LoadCase> = torques.iter().flat_map(at_torque).collect();
    Case::solve_all(solver, &input, &loads, &|_| {})
}

fn evenly(low: f64, high: f64, count: usize) -> Vec<f64> {
    let step = (high - low) / (count - 1) as f64;
    (0..count).map(|i| low + step * i as f64).collect()
}

/// Peak-to-peak value and harmonics of each case, um, over `places`, which `label` names.
fn amplitudes(label: &str, places: &[f64], cases: &[Case]) -> Result<String, Error> {
    let curve = |name: String, value: &dyn Fn(&Case) -> f64| {
        let values = cases.iter().map(|case| 1e6 * value(case));
        Curve::new(name, places.iter().copied().zip(values))
    };
    let mut curves = vec![curve("peak to peak".into(), &|c| {
        c.cycle.peak_to_peak_ste()
    })];
    curves.extend((0..HARMONICS).map(|h| {
        let amplitude = |c: &Case| c.cycle.harmonics()[h].map_or(f64::NAN, |h| h.amplitude);
        curve(format!("harmonic {}", h + 1), &amplitude)
    }));
    let labels = [label, "amplitude of the STE (um)"];
    line_chart(labels, Height::FromZero(LEAST_TOP), &curves)
}

/// Sections on the transmission error over the range of operation, and on losses at speeds of gear 1 up to
/// `largest_speed`, rpm.
pub fn survey(
    page: &mut Page,
    pair: &Pair,
    solver: &ContactSolver,
    largest_speed: f64,
) -> Result<(), Error> {
    let operating = &pair.operating;
    let largest = operating.maximum_torque;
    let torques = evenly(largest / TORQUES as f64, largest, TORQUES);
    page.section(
        "Transmission error over torque",
        "Peak-to-peak value and amplitudes of the harmonics of the mesh frequency, aligned, on the line of action.",
    );
    let aligned = cases(solver, &torques, &[0.0], POSITIONS)?;
    page.pictures(&[amplitudes("torque on gear 1 (N m)", &torques, &aligned)?]);

    let [low, high] = operating.misalignment;
    if low < high {
        let tilts = evenly(low, high, MISALIGNMENTS);
        let mrad: Vec<f64> = tilts.iter().map(|m| 1e3 * m).collect();
        let nominal = operating.nominal_torque;
        page.section(
            "Transmission error over misalignment",
            &format!(
                "First at {}, then the peak-to-peak value over torque and misalignment in the plane of action.",
                torque_in_words(nominal)
            ),
        );
        let tilted = cases(solver, &[nominal], &tilts, POSITIONS)?;
        let all = cases(solver, &torques, &tilts, POSITIONS)?;
        let map = Map::of_cells(
            "peak-to-peak STE",
            [cells_around(&mrad), cells_around(&torques)],
            ["misalignment (mrad)", "torque (N m)", "um"],
            all.iter().map(|case| 1e6 * case.cycle.peak_to_peak_ste()),
            LEAST_TOP,
        );
        page.pictures(&[
            amplitudes("misalignment (mrad)", &mrad, &tilted)?,
            draw_map(map)?,
        ]);
    }
    losses(page, pair, solver, &aligned, largest_speed)
}

/// Section on what friction takes in the cases `aligned`, over their torques.
fn losses(
    page: &mut Page,
    pair: &Pair,
    solver: &ContactSolver,
    aligned: &[Case],
    largest_speed: f64,
) -> Result<(), Error> {
    page.section(
        "Losses over speed and torque",
        &format!(
            "Friction between the teeth alone, with the law of the coefficient that the pair file chooses, the mean over the \
             mesh cycle, up to {} rpm of gear 1; aligned. The loss factor is the share of the power that is lost at a \
             coefficient of 1: by the share of the load as it is, and with load shared evenly (Ohlendorf).",
            rounded(largest_speed)
        ),
    );
    let speeds = evenly(largest_speed / SPEEDS as f64, largest_speed, SPEEDS);
    let torques: Vec<f64> = aligned.iter().map(|case| case.input.torque).collect();
    let map = |title: &str, unit: &str, value: fn(&Loss) -> f64| {
        let at_torque = |case: &Case| {
            speeds
                .iter()
                .map(|rpm| value(&case.loss(pair, *rpm)))
                .collect::<Vec<f64>>()
        };
        draw_map(Map::of_cells(
            title,
            [cells_around(&speeds), cells_around(&torques)],
            ["speed of gear 1 (rpm)", "torque (N m)", unit],
            aligned.iter().flat_map(at_torque),
            0.0,
        ))
    };
    let even = ohlendorf(&pair.geometry, pair.geometry.center_distance);
    let factor = aligned
        .iter()
        .map(|case| (case.input.torque, case.loss_factor(solver)));
    page.pictures(&[
        map("power lost", "W", |loss| loss.power)?,
        map("power lost over that transmitted", "%", |loss| {
            100.0 * (1.0 - loss.efficiency)
        })?,
        line_chart(
            ["torque on gear 1 (N m)", "loss factor"],
            Height::FromZero(0.0),
            &[
                Curve::new("by the load share", factor),
                Curve::new("Ohlendorf", torques.iter().map(|torque| (*torque, even))),
            ],
        )?,
    ]);
    Ok(())
}
