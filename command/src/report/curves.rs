//! Transmission error, stiffness and losses over the mesh cycle and over the operating range.

use gearmesh::contact::{ContactResult, ContactSolver};
use gearmesh::friction::{Loss, ohlendorf};
use gearmesh::pair::Pair;

use super::page::{Curve, Height, Map, Section, charts};
use super::{Loads, Variant};
use crate::Result;
use crate::case::{Case, torque_in_words};

/// Positions over a mesh cycle of the survey: enough for five harmonics and within a few per cent of the peak-to-peak value.
const POSITIONS: usize = 24;
const HARMONICS: usize = 3;
/// Least height of an axis of transmission errors, um: what lies below is rounding and the solver's tolerance.
const LEAST_ERROR: f64 = 1e-3;
/// Least height of the axis of the contact's position, over the face width.
const LEAST_WAY: f64 = 0.1;

const TORQUE: &str = "torque on gear 1 (N m)";
const MISALIGNMENT: &str = "misalignment (mrad)";
const SPEED: &str = "speed of gear 1 (rpm)";
const POSITION: &str = "mesh position";

/// A quantity over the mesh cycle, a curve for every load; the first point is repeated at 1.
fn over_cycle(cases: &[Case], value: impl Fn(&Case, &ContactResult) -> f64) -> Vec<Curve> {
    let curve = |case: &Case| {
        let results = &case.cycle.results;
        let results = results.iter().chain(results.first());
        let values = results.map(|result| value(case, result));
        let positions = case.cycle.mesh_position.iter().copied().chain([1.0]);
        // Torques of a survey have no end of digits.
        let torque = format!("{:.3e}", case.input.torque).parse();
        let torque = torque.unwrap_or(case.input.torque);
        Curve::new(torque_in_words(torque), positions.zip(values))
    };
    cases.iter().map(curve).collect()
}

pub fn cycle(variant: &Variant, cases: &[Case]) -> Section {
    let least_way = LEAST_WAY * 1e3 * variant.geometry().face_overlap().1;
    let mut figures = charts! {
        "Static transmission error about its mean", [POSITION, "STE less its mean (um)"], Height::Curves(LEAST_ERROR)
            => over_cycle(cases, |c, r| 1e6 * (r.approach - c.cycle.mean_ste()));
        "Mesh stiffness", [POSITION, "stiffness (N/um)"], Height::FromZero(0.0)
            => over_cycle(cases, |_, r| 1e-6 * r.tangent.force_by_approach);
        "Contact position along the face", [POSITION, "z_c (mm)"], Height::Curves(least_way)
            => over_cycle(cases, |_, r| 1e3 * r.contact_z);
    };
    if let Variant::Pair(..) = variant {
        figures.extend(charts! {
            "Load share of one tooth pair", [POSITION, "share of the load"], Height::FromZero(0.0)
                => cases.iter().map(load_share).collect();
        });
    }
    let note = "STE: on the line of action at mid-face; the table below has the mean. At mesh position 0 a tooth pair touches at the \
                pitch point; the load share is that of this pair from the start of its contact to the end. Stiffness: tangent, \
                dF/d(STE), on the line of action. z_c: axial position of the resultant force, from gear 1's z = 0 face.";
    Section::new("Over the mesh cycle", note, figures)
}

/// Share of one tooth pair as it moves through the mesh.
fn load_share(case: &Case) -> Curve {
    let shares = case.cycle.results.iter().enumerate().flat_map(|(i, r)| {
        let shares = r.load_share.iter();
        shares.map(move |&(pair, share)| (i, pair, share))
    });
    let curve = through_mesh(case, shares);
    // Keep one point without load at either side.
    let is_loaded = |p: &(f64, f64)| p.1 > 0.0;
    let all = curve.points.len();
    let first = curve.points.iter().position(is_loaded).unwrap_or(0);
    let last = curve.points.iter().rposition(is_loaded).unwrap_or(all);
    let points = curve.points[first.saturating_sub(1)..all.min(last + 2)].to_vec();
    Curve { points, ..curve }
}

/// Values of one tooth pair through the mesh: pair k at position tau is pair 0 at tau + k.
pub fn through_mesh(case: &Case, values: impl Iterator<Item = (usize, i32, f64)>) -> Curve {
    let position = |i: usize, pair| case.cycle.mesh_position[i] + f64::from(pair);
    let points = values.map(|(i, pair, value)| (position(i, pair), value));
    let mut curve = Curve::new(torque_in_words(case.input.torque), points);
    curve.points.sort_by(|a, b| a.0.total_cmp(&b.0));
    curve
}

/// Peak-to-peak value and harmonics of each of `cases` over `x`; in um, or of the harmonics alone in dB.
fn amplitudes(variant: &Variant, x: &[f64], cases: &[Case], in_db: bool) -> Vec<Curve> {
    let teeth = variant.geometry().gears[0].teeth as usize;
    let scale = |um: f64| if in_db { 20.0 * um.log10() } else { um };
    let curve = |label: String, value: &dyn Fn(&Case) -> f64| {
        let values = cases.iter().map(|case| scale(1e6 * value(case)));
        Curve::new(label, x.iter().copied().zip(values))
    };
    let harmonic = |h: usize| {
        let amplitude = |c: &Case| c.cycle.harmonics()[h - 1].map_or(f64::NAN, |h| h.amplitude);
        curve(format!("order {}", h * teeth), &amplitude)
    };
    let mut curves: Vec<Curve> = (1..=HARMONICS).map(harmonic).collect();
    let swing = |case: &Case| case.cycle.peak_to_peak_ste();
    curves.extend((!in_db).then(|| curve("peak to peak".into(), &swing)));
    curves
}

pub fn torque(variant: &Variant, loads: &Loads) -> Result<Section> {
    let cases = variant.cases(&loads.survey, &[0.0], POSITIONS)?;
    let figures = charts! {
        "Orders of the STE over torque", [TORQUE, "amplitude (um)"], Height::FromZero(LEAST_ERROR)
            => amplitudes(variant, &loads.survey, &cases, false);
        "Orders of the STE over torque in dB", [TORQUE, "amplitude (dB re 1 um)"], Height::Curves(1.0)
            => amplitudes(variant, &loads.survey, &cases, true);
        "Harris map", [POSITION, "STE (um)"], Height::Curves(LEAST_ERROR)
            => over_cycle(&cases, |_, r| 1e6 * r.approach);
    };
    let note = "Aligned, on the line of action. Orders are those of gear 1: its number of teeth is the mesh frequency, twice that its second \
                harmonic. Harris map: the whole STE over the mesh cycle for torques up to the largest.";
    Ok(Section::new("Over torque", note, figures))
}

pub fn misalignment(variant: &Variant, loads: &Loads) -> Result<Section> {
    let mrad: Vec<f64> = loads.tilts.iter().map(|m| 1e3 * m).collect();
    let tilted = variant.cases(&[loads.nominal], &loads.tilts, POSITIONS)?;
    let all = variant.cases(&loads.survey, &loads.tilts, POSITIONS)?;
    let swings = all.iter().map(|case| 1e6 * case.cycle.peak_to_peak_ste());
    let figures = charts! {
        "Orders of the STE over misalignment", [MISALIGNMENT, "amplitude (um)"], Height::FromZero(LEAST_ERROR)
            => amplitudes(variant, &mrad, &tilted, false);
        "Peak-to-peak STE over misalignment and torque", [MISALIGNMENT, TORQUE, "p-p STE (um)"]
            => Map::on_nodes([&mrad, &loads.survey], swings, LEAST_ERROR);
    };
    let torque = torque_in_words(loads.nominal);
    let note = format!("Misalignment in the plane of action. The orders are those at {torque}.");
    Ok(Section::new("Over misalignment", note, figures))
}

pub fn losses(pair: &Pair, solver: &ContactSolver, loads: &Loads) -> Result<Section> {
    let cases = Variant::Pair(solver, None).cases(&loads.survey, &[0.0], POSITIONS)?;
    let map = |value: fn(&Loss) -> f64| {
        let at_torque = |case: &Case| -> Vec<f64> {
            let speeds = loads.speeds.iter();
            speeds.map(|rpm| value(&case.loss(pair, *rpm))).collect()
        };
        let values = cases.iter().flat_map(at_torque);
        Map::on_nodes([&loads.speeds, &loads.survey], values, 0.0)
    };
    let over_torque = |label, value: &dyn Fn(&Case) -> f64| {
        let points = cases.iter().map(|case| (case.input.torque, value(case)));
        Curve::new(label, points)
    };
    let even = ohlendorf(&pair.geometry, pair.geometry.center_distance);
    let figures = charts! {
        "Power lost", [SPEED, TORQUE, "W"] => map(|loss| loss.power);
        "Power lost over that transmitted", [SPEED, TORQUE, "%"] => map(|loss| 100.0 * (1.0 - loss.efficiency));
        "Loss factor", [TORQUE, "loss factor"], Height::FromZero(0.0) => vec![
            over_torque("by the load share", &|case| case.loss_factor(solver)),
            over_torque("Ohlendorf", &|_| even),
        ];
    };
    let note = "Friction between the teeth alone, with the law of the coefficient that the pair file chooses, the mean over the mesh \
                cycle; aligned. The loss factor is the share of the power that is lost at a coefficient of 1: by the share of the load \
                as it is, and with load shared evenly (Ohlendorf).";
    Ok(Section::new("Losses over speed and torque", note, figures))
}
