//! Stress in the tooth roots in pictures.

use gearmesh_preprocessor::contact::GearRoots;

use super::curves::through_mesh;
use super::figure::{Curve, Figure, Height, Map, charts};
use super::page::Section;
use crate::case::Case;

/// Stress of one tooth of either gear through the mesh for every case, and the fillets where it is largest at the torque
/// `nominal`.
pub fn roots(cases: &[Case], nominal: f64) -> Section {
    let curve = |case: &Case, i: usize| -> Option<Curve> {
        let teeth = case.roots.as_ref()?[i].teeth.iter();
        let stresses = teeth.map(|t| (t.position, t.tooth_pair, 1e-6 * t.largest.stress));
        Some(through_mesh(case, stresses))
    };
    let curves = |i| cases.iter().filter_map(|case| curve(case, i)).collect();
    let labels = ["mesh position of the tooth", "root stress (MPa)"];
    let mut figures = charts! {
        "Root stress of gear 1", labels, Height::FromZero(0.0) => curves(0);
        "Root stress of gear 2", labels, Height::FromZero(0.0) => curves(1);
    };
    let nominal = cases.iter().find(|case| case.input.torque == nominal);
    let gears = nominal.and_then(|case| case.roots.as_ref());
    for (i, gear) in gears.into_iter().flatten().enumerate() {
        let title = format!("Fillet of gear {} at the largest root stress", i + 1);
        let labels = ["z (mm)", "tangent (deg)", "root stress (MPa)"];
        figures.extend(fillet(gear).map(|map| Figure::map(title, labels, map)));
    }
    let note = "Largest principal stress in the fillet of one tooth of either gear on its way through the mesh, from finite elements; at 0 its \
                tooth pair touches at the pitch point at mid-face. Fillets: over the face and over the angle of the fillet's tangent \
                with the tooth's centre line (90 degrees: root circle), at the nominal torque and the mesh position where the stress is \
                largest.";
    Section::new("Tooth root stress", note, figures)
}

/// None without load.
fn fillet(gear: &GearRoots) -> Option<Map> {
    let top = 1e-6 * gear.largest()?.largest.stress;
    let rows = &gear.field;
    let z: Vec<f64> = rows.iter().map(|row| 1e3 * row[0].z).collect();
    let tangents = rows[0].iter().map(|point| point.tangent.to_degrees());
    let tangents: Vec<f64> = tangents.collect();
    let along_face = |k: usize| rows.iter().map(move |row| 1e-6 * row[k].stress);
    let values = (0..tangents.len()).flat_map(along_face);
    let map = Map::on_nodes([&z, &tangents], values, top);
    // The outermost nodes lie on the faces.
    Some(map.cut(z[0], z[z.len() - 1]))
}
