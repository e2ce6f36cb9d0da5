//! Stress in the tooth roots in pictures.

use std::sync::Arc;

use gearmesh::contact::ContactSolver;
use gearmesh::gear::Flank;
use gearmesh::pair::Pair;
use gearmesh_preprocessor::contact::{CycleInput, GearRoots, MeshCycle};
use gearmesh_preprocessor::finite_element::{RootPoint, RootStress};

use super::chart::{Curve, Height, line_chart};
use super::map::{Patch, View, map};
use super::page::Page;
use super::torque_in_words;
use crate::Error;

/// Adds the section: stress of one tooth of either gear through the mesh for every cycle (its torque, N m, first), and the
/// fillets where it is largest at the nominal torque.
pub fn roots(
    page: &mut Page,
    pair: &Pair,
    solver: &ContactSolver,
    models: &[Arc<RootStress>; 2],
    cycles: &[(f64, MeshCycle)],
) -> Result<(), Error> {
    let mut curves: [Vec<Curve>; 2] = Default::default();
    let mut nominal = None;
    for (torque, cycle) in cycles {
        let input = CycleInput {
            flank: Flank::Drive,
            torque: *torque,
            center_distance_offset: 0.0,
            misalignment: 0.0,
            positions: cycle.mesh_position.len(),
        };
        let gears = cycle.root_stress(solver, &input, models)?;
        for (curves, gear) in curves.iter_mut().zip(&gears) {
            curves.push(through_mesh(torque_in_words(*torque), cycle, gear));
        }
        if *torque == pair.operating.nominal_torque {
            nominal = Some(gears);
        }
    }
    page.section(
        "Tooth root stress",
        "Largest principal stress in the fillet of one tooth of either gear on its way through the mesh, from finite elements; at 0 its \
         tooth pair touches at the pitch point at mid-face.",
    );
    let charts = curves.iter().enumerate().map(|(i, curves)| {
        let label = format!("root stress of gear {} (MPa)", i + 1);
        line_chart(
            ["mesh position of the tooth", &label],
            Height::FromZero(0.0),
            curves,
        )
    });
    page.pictures(&charts.collect::<Result<Vec<_>, Error>>()?);
    let Some(gears) = nominal else { return Ok(()) };
    page.section(
        "Fillets at the largest root stress",
        "Largest principal stress over the face and over the angle of the fillet's tangent with the tooth's centre line (90 degrees: \
         root circle), at the nominal torque and the mesh position where it is largest.",
    );
    let maps = gears
        .iter()
        .enumerate()
        .filter_map(|(i, gear)| fillet(i, gear).transpose());
    page.pictures(&maps.collect::<Result<Vec<_>, Error>>()?);
    Ok(())
}

/// One tooth through the mesh: pair k at position tau is pair 0 at tau + k.
fn through_mesh(label: String, cycle: &MeshCycle, gear: &GearRoots) -> Curve {
    let teeth = gear.teeth.iter();
    let mut points: Vec<(f64, f64)> = teeth
        .map(|tooth| {
            let tau = cycle.mesh_position[tooth.position] + f64::from(tooth.tooth_pair);
            (tau, 1e-6 * tooth.largest.stress)
        })
        .collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    Curve { label, points }
}

/// The fillet of gear `i` where its stress is largest; None without load.
fn fillet(i: usize, gear: &GearRoots) -> Result<Option<String>, Error> {
    let rows = &gear.field;
    let Some(top) = gear.largest() else {
        return Ok(None);
    };
    let along = |rows: &[Vec<RootPoint>]| rows.iter().map(|row| 1e3 * row[0].z).collect();
    let z = cells(along(rows));
    let tangents = cells(
        rows[0]
            .iter()
            .map(|point| point.tangent.to_degrees())
            .collect(),
    );
    let mut patches = Vec::new();
    for (row, z) in rows.iter().zip(z.windows(2)) {
        for (point, tangent) in row.iter().zip(tangents.windows(2)) {
            let [z, tangent] = [[z[0], z[1]], [tangent[0], tangent[1]]];
            patches.push(Patch::rectangle(z, tangent, 1e-6 * point.stress));
        }
    }
    let view = View {
        x: z[0]..z[z.len() - 1],
        y: tangents[tangents.len() - 1]..tangents[0],
        labels: ["z (mm)", "tangent (deg)", "root stress (MPa)"],
    };
    let title = format!("Gear {}", i + 1);
    map(&title, &view, patches, 1e-6 * top.largest.stress).map(Some)
}

/// Ends of cells about `places`: halfway between them, and the outermost themselves.
fn cells(places: Vec<f64>) -> Vec<f64> {
    let mut ends = vec![places[0]];
    ends.extend(places.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])));
    ends.push(places[places.len() - 1]);
    ends
}
