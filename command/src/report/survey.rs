//! Transmission error over torque and over misalignment.

use gearmesh::contact::{ContactError, ContactSolver};
use gearmesh::gear::Flank;
use gearmesh::pair::Pair;
use gearmesh_preprocessor::contact::{CycleInput, LoadCase, MeshCycle};

use super::chart::{Curve, Height, line_chart};
use super::map::{View, cells, map};
use super::page::Page;
use super::torque_in_words;
use crate::Error;

/// Torques up to the largest one.
const TORQUES: usize = 12;
/// Misalignments over the range of the pair file.
const MISALIGNMENTS: usize = 9;
/// Positions over a mesh cycle: enough for five harmonics and within a few per cent of the peak-to-peak value.
const POSITIONS: usize = 24;
/// Harmonics that are drawn.
const HARMONICS: usize = 3;
/// Least top of a scale, um.
const LEAST_TOP: f64 = 1e-3;

/// Mesh cycles of the drive flank, one for each of `cases`.
pub fn cycles(
    solver: &ContactSolver,
    cases: &[LoadCase],
    positions: usize,
) -> Result<Vec<MeshCycle>, ContactError> {
    let input = CycleInput {
        flank: Flank::Drive,
        torque: 0.0,
        center_distance_offset: 0.0,
        misalignment: 0.0,
        positions,
    };
    MeshCycle::solve_all(solver, &input, cases, &|_| {})
}

/// `count` values evenly from `low` to `high`.
fn evenly(low: f64, high: f64, count: usize) -> Vec<f64> {
    let step = (high - low) / (count - 1) as f64;
    (0..count).map(|i| low + step * i as f64).collect()
}

/// Peak-to-peak value and harmonics of each cycle, um, over `at`.
fn amplitudes(at: &[f64], cycles: &[MeshCycle]) -> Vec<Curve> {
    let curve = |label: String, value: &dyn Fn(&MeshCycle) -> f64| Curve {
        label,
        points: at
            .iter()
            .zip(cycles)
            .map(|(at, cycle)| (*at, 1e6 * value(cycle)))
            .collect(),
    };
    let mut curves = vec![curve("peak to peak".into(), &MeshCycle::peak_to_peak_ste)];
    curves.extend((0..HARMONICS).map(|h| {
        curve(format!("harmonic {}", h + 1), &|c: &MeshCycle| {
            c.harmonics()[h].map_or(f64::NAN, |h| h.amplitude)
        })
    }));
    curves
}

/// Sections on the transmission error over the range of operation. Returns the aligned mesh cycles, each after its
/// torque, N m.
pub fn survey(
    page: &mut Page,
    pair: &Pair,
    solver: &ContactSolver,
) -> Result<Vec<(f64, MeshCycle)>, Error> {
    let operating = &pair.operating;
    let largest = operating.maximum_torque;
    let torques = evenly(largest / TORQUES as f64, largest, TORQUES);
    page.section(
        "Transmission error over torque",
        "Peak-to-peak value and amplitudes of the harmonics of the mesh frequency, aligned, on the line of action.",
    );
    let case = |torque: f64, misalignment: f64| LoadCase {
        torque,
        misalignment,
    };
    let aligned: Vec<LoadCase> = torques.iter().map(|torque| case(*torque, 0.0)).collect();
    let aligned = cycles(solver, &aligned, POSITIONS)?;
    let chart = |x: &str, curves: &[Curve]| {
        line_chart(
            [x, "amplitude of the STE (um)"],
            Height::FromZero(LEAST_TOP),
            curves,
        )
    };
    page.pictures(&[chart(
        "torque on gear 1 (N m)",
        &amplitudes(&torques, &aligned),
    )?]);

    let [low, high] = operating.misalignment;
    let aligned = torques.iter().copied().zip(aligned).collect();
    if low == high {
        return Ok(aligned);
    }
    let tilts = evenly(low, high, MISALIGNMENTS);
    let mrad: Vec<f64> = tilts.iter().map(|m| 1e3 * m).collect();
    page.section(
        "Transmission error over misalignment",
        &format!(
            "First at {}, then the peak-to-peak value over torque and misalignment in the plane of action.",
            torque_in_words(operating.nominal_torque)
        ),
    );
    // The nominal torque first, then every torque of the map.
    let all: Vec<LoadCase> = [operating.nominal_torque]
        .iter()
        .chain(&torques)
        .flat_map(|torque| tilts.iter().map(|m| case(*torque, *m)))
        .collect();
    let all = cycles(solver, &all, POSITIONS)?;
    let (tilted, mapped) = all.split_at(tilts.len());
    let patches = cells(
        &mrad,
        &torques,
        mapped.iter().map(|cycle| 1e6 * cycle.peak_to_peak_ste()),
    );
    let top = patches.iter().map(|p| p.value).fold(LEAST_TOP, f64::max);
    let view = View::over(
        [&mrad, &torques],
        ["misalignment (mrad)", "torque (N m)", "um"],
    );
    page.pictures(&[
        chart("misalignment (mrad)", &amplitudes(&mrad, tilted))?,
        map("peak-to-peak STE", &view, patches, top)?,
    ]);
    Ok(aligned)
}
