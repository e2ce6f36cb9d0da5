//! The mesh of one sector as SVG, drawn from its nodes.

use gearmesh::compliance::finite_element::SectorMesh;
use gearmesh::gear::Gear;
use std::fmt::Write;

/// Height of the picture, px.
const HEIGHT: f64 = 620.0;
const MARGIN: f64 = 20.0;

/// A window onto the plane.
struct View {
    /// Corner of the window that lies lower left, m.
    origin: [f64; 2],
    /// px per m.
    scale: f64,
    /// Left edge in the picture, px.
    left: f64,
}

impl View {
    /// y up to px down.
    fn place(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [
            self.left + self.scale * (x - self.origin[0]),
            HEIGHT - MARGIN - self.scale * (y - self.origin[1]),
        ]
    }
}

/// Section, tip edge and layers.
pub fn draw(mesh: &SectorMesh, gear: &Gear) -> String {
    // The tooth upright: its centre line along y.
    let nodes: Vec<[f64; 2]> = mesh.nodes.iter().map(|[x, y]| [*y, *x]).collect();
    let range = |axis: usize| {
        nodes.iter().fold([f64::MAX, f64::MIN], |r, p| {
            [r[0].min(p[axis]), r[1].max(p[axis])]
        })
    };
    let (x, y) = (range(0), range(1));
    let usable = HEIGHT - 2.0 * MARGIN;
    let whole = View {
        origin: [x[0], y[0]],
        scale: usable / (y[1] - y[0]),
        left: MARGIN,
    };
    let first_width = whole.scale * (x[1] - x[0]);

    let module = gear.normal_module;
    let tip = nodes[mesh.flank[mesh.flank.len() - 1]];
    let size = 0.45 * module;
    let enlarged = View {
        origin: [tip[0] - 0.75 * size, tip[1] - 0.9 * size],
        scale: 340.0 / size,
        left: first_width + 3.0 * MARGIN,
    };
    let mut svg = String::new();
    let flank_left = enlarged.left + 340.0 + 2.0 * MARGIN;
    let flank_scale = 320.0 / gear.face_width;
    let width = flank_left + 320.0 + MARGIN;
    let _ = writeln!(
        svg,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {HEIGHT}\" width=\"{width:.0}\" \
         height=\"{HEIGHT}\" fill=\"none\" stroke=\"#335\" stroke-width=\"0.6\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"white\" stroke=\"none\"/>\n\
         <clipPath id=\"edge\"><rect x=\"{:.1}\" y=\"{:.1}\" width=\"340\" height=\"340\"/></clipPath>",
        enlarged.left,
        HEIGHT - MARGIN - 340.0,
    );
    section(&mut svg, mesh, &nodes, &whole, "");
    section(
        &mut svg,
        mesh,
        &nodes,
        &enlarged,
        " clip-path=\"url(#edge)\"",
    );

    // The flank unrolled: arc length up, face to the right.
    let mut arcs = vec![0.0];
    for pair in mesh.flank.windows(2) {
        let [p, q] = [pair[0], pair[1]].map(|n| nodes[n]);
        arcs.push(arcs[arcs.len() - 1] + (q[0] - p[0]).hypot(q[1] - p[1]));
    }
    let ends: Vec<f64> = arcs.iter().step_by(2).copied().collect();
    let top = ends[ends.len() - 1] * flank_scale;
    let _ = write!(svg, "<path d=\"");
    for z in &mesh.stations {
        let at = flank_left + flank_scale * z;
        let _ = write!(
            svg,
            "M{at:.1} {:.1}V{:.1}",
            HEIGHT - MARGIN,
            HEIGHT - MARGIN - top
        );
    }
    for arc in &ends {
        let y = HEIGHT - MARGIN - flank_scale * arc;
        let _ = write!(svg, "M{flank_left:.1} {y:.1}h320");
    }
    svg.push_str(
        "\"/>\n<g fill=\"#333\" stroke=\"none\" font-family=\"sans-serif\" font-size=\"13\">\n",
    );
    let labels = [
        (enlarged.left, HEIGHT - MARGIN - 350.0, "tip edge, enlarged"),
        (
            flank_left,
            HEIGHT - MARGIN - top - 10.0,
            "flank from fillet (bottom) to tip, over the face",
        ),
    ];
    for (x, y, text) in labels {
        let _ = writeln!(svg, "<text x=\"{x:.0}\" y=\"{y:.0}\">{text}</text>");
    }
    svg.push_str("</g>\n</svg>\n");
    svg
}

/// All elements, sides through their middle nodes, and the loaded flank.
fn section(svg: &mut String, mesh: &SectorMesh, nodes: &[[f64; 2]], view: &View, attribute: &str) {
    let at = |node: usize| view.place(nodes[node]);
    let _ = write!(svg, "<g{attribute}><path d=\"");
    for element in &mesh.elements {
        let [x, y] = at(element[0]);
        let _ = write!(svg, "M{x:.1} {y:.1}");
        for side in 0..4 {
            for node in [element[4 + side], element[(side + 1) % 4]] {
                let [x, y] = at(node);
                let _ = write!(svg, "L{x:.1} {y:.1}");
            }
        }
    }
    svg.push_str("\"/><path stroke=\"#c40\" stroke-width=\"2\" d=\"");
    for (i, node) in mesh.flank.iter().enumerate() {
        let [x, y] = at(*node);
        let _ = write!(svg, "{}{x:.1} {y:.1}", if i == 0 { 'M' } else { 'L' });
    }
    svg.push_str("\"/></g>\n");
}
