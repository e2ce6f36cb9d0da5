//! The mesh of one sector: its section, its tip edge enlarged, and the flank unrolled.

use crate::Result;
use gearmesh::gear::Gear;
use gearmesh_preprocessor::finite_element::SectorMesh;
use plotters::prelude::*;

const PANEL: u32 = 380;

/// A part of the plane and the polylines in it; the bold ones are the loaded flank.
struct Panel<'a> {
    title: &'a str,
    x: [f64; 2],
    y: [f64; 2],
    thin: &'a [Vec<(f64, f64)>],
    bold: &'a [(f64, f64)],
}

/// Three panels side by side, in millimetres.
pub fn draw(mesh: &SectorMesh, gear: &Gear) -> Result<String> {
    // The tooth upright: its centre line along y.
    let nodes: Vec<(f64, f64)> = mesh.nodes.iter().map(|[x, y]| (1e3 * y, 1e3 * x)).collect();
    let path = |indices: &[usize]| -> Vec<(f64, f64)> { indices.iter().map(|&n| nodes[n]).collect() };
    // Sides through their middle nodes.
    let side = |e: &[usize; 8]| path(&[e[0], e[4], e[1], e[5], e[2], e[6], e[3], e[7], e[0]]);
    let elements: Vec<_> = mesh.elements.iter().map(side).collect();
    let flank = path(&mesh.flank);
    let [x, y] = [crate::page::range(nodes.iter().map(|n| n.0)), crate::page::range(nodes.iter().map(|n| n.1))];
    let (tip, size) = (flank[flank.len() - 1], 450.0 * gear.normal_module);

    // The flank unrolled: arc length up, face to the right.
    let mut arcs = vec![0.0];
    for pair in flank.windows(2) {
        arcs.push(arcs[arcs.len() - 1] + (pair[1].0 - pair[0].0).hypot(pair[1].1 - pair[0].1));
    }
    let (face, top) = (1e3 * gear.face_width, arcs[arcs.len() - 1]);
    let layers = mesh.stations.iter().map(|z| vec![(1e3 * z, 0.0), (1e3 * z, top)]);
    let rows = arcs.iter().step_by(2).map(|&arc| vec![(0.0, arc), (face, arc)]);
    let unrolled: Vec<_> = layers.chain(rows).collect();

    let panels = [
        Panel { title: "section of one sector", x, y, thin: &elements, bold: &flank },
        Panel {
            title: "tip edge, enlarged",
            x: [tip.0 - 0.75 * size, tip.0 + 0.25 * size],
            y: [tip.1 - 0.9 * size, tip.1 + 0.1 * size],
            thin: &elements,
            bold: &flank,
        },
        Panel {
            title: "flank from fillet to tip, over the face",
            x: [0.0, face],
            y: [0.0, face],
            thin: &unrolled,
            bold: &[],
        },
    ];
    let mut svg = String::new();
    {
        let area = SVGBackend::with_string(&mut svg, (3 * PANEL, PANEL + 40)).into_drawing_area();
        area.fill(&WHITE)?;
        for (panel, area) in panels.iter().zip(area.split_evenly((1, 3))) {
            // As wide as high, so that angles are true.
            let half = 0.52 * (panel.x[1] - panel.x[0]).max(panel.y[1] - panel.y[0]);
            let around = |[low, high]: [f64; 2]| 0.5 * (low + high) - half..0.5 * (low + high) + half;
            let mut chart = ChartBuilder::on(&area)
                .caption(panel.title, ("sans-serif", 14))
                .margin(8)
                .build_cartesian_2d(around(panel.x), around(panel.y))?;
            let inside = |line: &&Vec<(f64, f64)>| {
                line.iter().all(|p| around(panel.x).contains(&p.0) && around(panel.y).contains(&p.1))
            };
            let thin = panel.thin.iter().filter(inside).map(|line| PathElement::new(line.clone(), BLACK.mix(0.7)));
            chart.draw_series(thin)?;
            let bold = panel.bold.iter().copied().filter(|p| inside(&&vec![*p]));
            chart.draw_series(LineSeries::new(bold, RED.stroke_width(2)))?;
        }
        area.present()?;
    }
    Ok(svg)
}
