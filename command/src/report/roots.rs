//! Stress in the tooth roots in pictures.

use gearmesh::pair::Pair;
use gearmesh_preprocessor::contact::{GearRoots, ToothRoot};

use super::chart::{Curve, Height, Map, cells_between, draw_map, line_chart};
use super::page::Page;
use crate::Error;
use crate::case::{Case, torque_in_words};

/// Adds the section: stress of one tooth of either gear through the mesh for every case, and the fillets where it is largest
/// at the nominal torque.
pub fn roots(page: &mut Page, pair: &Pair, cases: &[Case]) -> Result<(), Error> {
    page.section(
        "Tooth root stress",
        "Largest principal stress in the fillet of one tooth of either gear on its way through the mesh, from finite elements; at 0 its \
         tooth pair touches at the pitch point at mid-face.",
    );
    let charts = (0..2).map(|i| {
        let curves: Vec<Curve> = cases
            .iter()
            .filter_map(|case| through_mesh(case, i))
            .collect();
        let label = format!("root stress of gear {} (MPa)", i + 1);
        line_chart(
            ["mesh position of the tooth", &label],
            Height::FromZero(0.0),
            &curves,
        )
    });
    page.pictures(&charts.collect::<Result<Vec<_>, Error>>()?);
    let nominal = pair.operating.nominal_torque;
    let nominal = cases.iter().find(|case| case.input.torque == nominal);
    let Some(gears) = nominal.and_then(|case| case.roots.as_ref()) else {
        return Ok(());
    };
    page.section(
        "Fillets at the largest root stress",
        "Largest principal stress over the face and over the angle of the fillet's tangent with the tooth's centre line (90 degrees: \
         root circle), at the nominal torque and the mesh position where it is largest.",
    );
    let loaded = gears
        .iter()
        .enumerate()
        .filter(|(_, gear)| gear.largest.is_some());
    let maps = loaded.map(|(i, gear)| fillet(format!("Gear {}", i + 1), gear));
    page.pictures(&maps.collect::<Result<Vec<_>, Error>>()?);
    Ok(())
}

/// One tooth of gear `i` through the mesh: pair k at position tau is pair 0 at tau + k.
fn through_mesh(case: &Case, i: usize) -> Option<Curve> {
    let teeth = case.roots.as_ref()?[i].teeth.iter();
    let point = |tooth: &ToothRoot| {
        let tau = case.cycle.mesh_position[tooth.position] + f64::from(tooth.tooth_pair);
        (tau, 1e-6 * tooth.largest.stress)
    };
    let mut points: Vec<(f64, f64)> = teeth.map(point).collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    Some(Curve::new(torque_in_words(case.input.torque), points))
}

fn fillet(title: String, gear: &GearRoots) -> Result<String, Error> {
    let rows = &gear.field;
    let z: Vec<f64> = rows.iter().map(|row| 1e3 * row[0].z).collect();
    let tangents: Vec<f64> = rows[0]
        .iter()
        .map(|point| point.tangent.to_degrees())
        .collect();
    let along_face = |k: usize| rows.iter().map(move |row| 1e-6 * row[k].stress);
    draw_map(Map::of_cells(
        title,
        [cells_between(&z), cells_between(&tangents)],
        ["z (mm)", "tangent (deg)", "root stress (MPa)"],
        (0..tangents.len()).flat_map(along_face),
        gear.largest()
            .map_or(0.0, |tooth| 1e-6 * tooth.largest.stress),
    ))
}
