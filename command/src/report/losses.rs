//! What friction takes, over speed and torque.

use std::f64::consts::TAU;

use gearmesh::friction::{Loss, Sliding, loss_factor_of, ohlendorf};
use gearmesh::pair::Pair;
use gearmesh::words::rounded;
use gearmesh_preprocessor::contact::MeshCycle;

use super::chart::{Curve, Height, line_chart};
use super::map::{View, cells, map};
use super::page::Page;
use crate::Error;

/// Speeds up to the largest one.
const SPEEDS: usize = 12;

/// Section on losses: `cycles`, aligned, each after its torque (N m), at speeds of gear 1 up to `largest_speed`, rpm.
pub fn losses(
    page: &mut Page,
    pair: &Pair,
    cycles: &[(f64, MeshCycle)],
    largest_speed: f64,
) -> Result<(), Error> {
    let g = &pair.geometry;
    page.section(
        "Losses over speed and torque",
        &format!(
            "Friction between the teeth alone, with the law of the coefficient that the pair file chooses, the mean over the \
             mesh cycle, up to {} rpm of gear 1; aligned. The loss factor is the share of the power that is lost at a \
             coefficient of 1: by the share of the load as it is, and with load shared evenly (Ohlendorf).",
            rounded(largest_speed)
        ),
    );
    let step = largest_speed / SPEEDS as f64;
    let speeds: Vec<f64> = (1..=SPEEDS).map(|i| step * i as f64).collect();
    let torques: Vec<f64> = cycles.iter().map(|(torque, _)| *torque).collect();
    let found: Vec<Loss> = cycles
        .iter()
        .flat_map(|(torque, cycle)| {
            speeds.iter().map(|speed| {
                Loss::new(
                    g,
                    &pair.friction,
                    [&cycle.sliding, &cycle.friction],
                    *torque,
                    speed * TAU / 60.0,
                )
            })
        })
        .collect();
    let picture = |title: &str, unit: &str, value: &dyn Fn(&Loss) -> f64| {
        let patches = cells(&speeds, &torques, found.iter().map(value));
        let top = patches.iter().map(|p| p.value).fold(0.0, f64::max);
        let view = View::over(
            [&speeds, &torques],
            ["speed of gear 1 (rpm)", "torque (N m)", unit],
        );
        map(title, &view, patches, top)
    };
    let curve = |label: &str, value: &dyn Fn(&MeshCycle) -> f64| Curve {
        label: label.into(),
        points: cycles.iter().map(|(t, cycle)| (*t, value(cycle))).collect(),
    };
    let even = ohlendorf(g, g.center_distance);
    page.pictures(&[
        picture("power lost", "W", &|loss| loss.power)?,
        picture("power lost over that transmitted", "%", &|loss| {
            100.0 * (1.0 - loss.efficiency)
        })?,
        line_chart(
            ["torque on gear 1 (N m)", "loss factor"],
            Height::FromZero(0.0),
            &[
                curve("by the load share", &|cycle| {
                    loss_factor_of(g, Sliding::mean(&cycle.sliding).distance)
                }),
                curve("Ohlendorf", &|_| even),
            ],
        )?,
    ]);
    Ok(())
}
