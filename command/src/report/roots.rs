//! Stress in the tooth roots in pictures.

use gearmesh_preprocessor::contact::{GearRoots, ToothRoot};

use super::figure::{Curve, Figure, Height, Map};
use super::page::Section;
use crate::case::{Case, torque_in_words};

/// Stress of one tooth of either gear through the mesh for every case, and the fillets where it is largest at the torque
/// `nominal`.
pub fn roots(cases: &[Case], nominal: f64) -> Section {
    let through_mesh = |i: usize| {
        let curves = cases.iter().filter_map(|case| through_mesh(case, i));
        Figure::lines(
            &format!("Root stress of gear {}", i + 1),
            ["mesh position of the tooth", "root stress (MPa)"],
            Height::FromZero(0.0),
            curves.collect(),
        )
    };
    let mut figures: Vec<Figure> = (0..2).map(through_mesh).collect();
    let nominal = cases.iter().find(|case| case.input.torque == nominal);
    let gears = nominal.and_then(|case| case.roots.as_ref());
    for (i, gear) in gears.into_iter().flatten().enumerate() {
        let title = format!("Fillet of gear {} at the largest root stress", i + 1);
        figures.extend(fillet(gear).map(|map| Figure::map(title, map)));
    }
    let note = "Largest principal stress in the fillet of one tooth of either gear on its way through the mesh, from finite elements; at 0 its \
                tooth pair touches at the pitch point at mid-face. Fillets: over the face and over the angle of the fillet's tangent \
                with the tooth's centre line (90 degrees: root circle), at the nominal torque and the mesh position where the stress is \
                largest.";
    Section::new("Tooth root stress", note, figures)
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

/// None without load.
fn fillet(gear: &GearRoots) -> Option<Map> {
    let top = 1e-6 * gear.largest()?.largest.stress;
    let rows = &gear.field;
    let z: Vec<f64> = rows.iter().map(|row| 1e3 * row[0].z).collect();
    let tangents = rows[0].iter().map(|point| point.tangent.to_degrees());
    let tangents: Vec<f64> = tangents.collect();
    let along_face = |k: usize| rows.iter().map(move |row| 1e-6 * row[k].stress);
    Some(Map::on_nodes(
        ["z (mm)", "tangent (deg)", "root stress (MPa)"],
        [&z, &tangents],
        (0..tangents.len()).flat_map(along_face),
        top,
    ))
}
