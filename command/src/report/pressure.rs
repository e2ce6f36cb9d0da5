//! Pressures of the contact solver, laid out for drawing.

use gearmesh::contact::{ContactSolver, SegmentLoad};
use gearmesh::gear::Flank;
use gearmesh::pair::Pair;
use rayon::prelude::*;

use super::chart::{Curve, Map, Patch, draw_map};
use crate::Error;

/// Pressures below this are left white, MPa.
const VISIBLE: f64 = 1.0;

/// What a strip carries, in the unit of its scale.
pub struct Quantity {
    unit: &'static str,
    /// Of a strip of this length, m.
    value: fn(&SegmentLoad, f64) -> f64,
    /// Whether contact at a tip edge has a value on the scale.
    at_edges: bool,
}

pub const PRESSURE: Quantity = Quantity {
    unit: "MPa",
    value: |strip, _| strip.pressure * 1e-6,
    at_edges: false,
};

pub const LINE_LOAD: Quantity = Quantity {
    unit: "N/mm",
    value: |strip, length| strip.force / length * 1e-3,
    at_edges: true,
};

/// A map of `patches` on the face of gear 1, from the lowest diameter that gear 2 reaches to the tip.
pub fn flank_map(
    pair: &Pair,
    quantity: &Quantity,
    title: String,
    patches: Vec<Patch>,
    top: f64,
) -> Result<String, Error> {
    let g = &pair.geometry;
    let gear = &g.gears[0];
    let path = g.path_of_contact(g.center_distance);
    let diameter = |xi: f64| 2e3 * gear.radius_at_roll(g.roll_at(0, g.center_distance, xi));
    let (a, b) = (diameter(path.start), diameter(path.end));
    let margin = 0.04 * (a - b).abs();
    draw_map(Map {
        title,
        x: 1e3 * gear.face_offset..1e3 * (gear.face_offset + gear.face_width),
        y: a.min(b) - margin..a.max(b) + margin,
        labels: ["z (mm)", "diameter (mm)", quantity.unit],
        patches,
        top,
    })
}

fn strips(
    solver: &ContactSolver,
    torque: f64,
    misalignment: f64,
    tau: f64,
) -> Result<Vec<SegmentLoad>, Error> {
    let problem = solver.position(Flank::Drive, tau, 0.0)?;
    let result = problem.solve_torque(torque, misalignment, None)?;
    Ok(problem.segment_loads(&result))
}

/// Every loaded strip of the mesh cycle as a patch of gear 1's flank: as long as the strip, and as high
/// as the contact moves from one position to the next.
pub fn pattern(
    solver: &ContactSolver,
    quantity: &Quantity,
    torque: f64,
    misalignment: f64,
    positions: usize,
) -> Result<Vec<Patch>, Error> {
    let geometry = solver.geometry();
    let gear = &geometry.gears[0];
    let half_step = 0.5 * geometry.base_pitch() / positions as f64;
    let diameter = |roll: f64| 2e3 * gear.radius_at_roll(roll);
    let per_cos_beta_b = 1.0 / geometry.base_helix_angle().cos();
    let patches: Result<Vec<Vec<Patch>>, String> = (0..positions)
        .into_par_iter()
        .map(|i| {
            // Errors as text: they cross threads.
            let strips = strips(solver, torque, misalignment, i as f64 / positions as f64)
                .map_err(|error| error.to_string())?;
            Ok(strips
                .iter()
                .filter(|strip| strip.edge.is_some() || strip.pressure > VISIBLE * 1e6)
                .map(|strip| {
                    let [z0, z1] = strip.z.map(|z| 1e3 * z);
                    let roll = strip.roll[0];
                    let (low, high) = (diameter(roll - half_step), diameter(roll + half_step));
                    let length = (strip.z[1] - strip.z[0]).abs() * per_cos_beta_b;
                    Patch {
                        corners: [(z0, low), (z1, low), (z1, high), (z0, high)],
                        value: (quantity.value)(strip, length),
                        apart: strip.edge.is_some() && !quantity.at_edges,
                    }
                })
                .collect())
        })
        .collect();
    Ok(patches?.into_iter().flatten().collect())
}

/// Pressure inside the flanks along z for every tooth pair in contact at the mesh position `tau`; a line ends
/// where contact reaches a tip edge.
pub fn contact_lines(solver: &ContactSolver, torque: f64, tau: f64) -> Result<Vec<Curve>, Error> {
    let mut curves: Vec<(i32, Curve)> = Vec::new();
    let strips = strips(solver, torque, 0.0, tau)?;
    for strip in strips.into_iter().filter(|strip| strip.edge.is_none()) {
        let point = (500.0 * (strip.z[0] + strip.z[1]), strip.pressure * 1e-6);
        match curves.last_mut() {
            Some((pair, curve)) if *pair == strip.tooth_pair => curve.points.push(point),
            _ => {
                let label = format!("pair {}", strip.tooth_pair);
                curves.push((strip.tooth_pair, Curve::new(label, [point])));
            }
        }
    }
    let curves = curves.into_iter().map(|(_, curve)| curve);
    Ok(curves
        .filter(|curve| curve.points.iter().any(|p| p.1 > VISIBLE))
        .collect())
}
