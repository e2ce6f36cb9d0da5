//! The mesh of one sector: the section itself (plane strain) or the section extruded along the helix.

use super::element;
use super::layers::Layers;
use super::outline::Outline;
use super::section::Section;

/// A node of the loaded flank and the outward unit normal there in the node's own cylindrical axes
/// (radial, circumferential, axial).
#[derive(Debug, Clone, Copy)]
pub(super) struct FlankNode {
    pub node: usize,
    pub normal: [f64; 3],
}

/// An elastic foundation.
#[derive(Debug, Clone)]
pub(super) struct Foundation {
    /// Whether a node lies on the surface that rests on it.
    pub nodes: Vec<bool>,
    /// Stiffness per area in each direction, N/m³.
    pub stiffness: f64,
}

/// One sector of the gear; displacements are in each node's own cylindrical axes, so that both sides of
/// the sector match without a rotation.
#[derive(Debug, Clone)]
pub(super) struct Mesh {
    /// 2: plane strain, per metre of depth; 3: solid.
    pub dimension: usize,
    /// Cartesian coordinates, m.
    pub points: Vec<[f64; 3]>,
    /// Polar angle of each node, rad.
    pub angles: Vec<f64>,
    /// Nodes of each element, [`Mesh::nodes_per_element`] at a time.
    pub elements: Vec<usize>,
    /// (column, row, layer) of each element.
    pub cells: Vec<[i32; 3]>,
    /// Whether a node is held.
    pub held: Vec<bool>,
    /// What the held surface rests on where it is not rigid.
    pub foundation: Option<Foundation>,
    /// Nodes of both sides in the same order.
    pub sides: [Vec<usize>; 2],
    /// Nodes of the loaded flank, in the order of [`super::flank::FlankGrid`].
    pub flank: Vec<FlankNode>,
    /// Nodes of root circle and fillet beside the loaded flank, in the same order.
    pub fillet: Vec<usize>,
}

impl Mesh {
    /// The plane section.
    pub fn plane(section: &Section, outline: &Outline, foundation: Option<f64>) -> Mesh {
        let mut held = vec![false; section.nodes.len()];
        section.held.iter().for_each(|node| held[*node] = true);
        Mesh {
            dimension: 2,
            points: (0..section.nodes.len())
                .map(|i| section.cartesian(i))
                .collect(),
            angles: section.nodes.iter().map(|p| p[1]).collect(),
            elements: section.quads.iter().flatten().copied().collect(),
            cells: section.cells.iter().map(|c| [c[0], c[1], 0]).collect(),
            held,
            sides: section.sides.clone(),
            flank: section
                .flank
                .iter()
                .map(|(node, arc)| {
                    let n = outline.normal(*arc);
                    FlankNode {
                        node: *node,
                        normal: [n[0], n[1], 0.0],
                    }
                })
                .collect(),
            fillet: section.fillet.iter().map(|(node, _)| *node).collect(),
            foundation: None,
        }
        .rested_on(foundation)
    }

    /// The mesh with its held nodes on a foundation of the given stiffness (N/m³), if there is one.
    fn rested_on(mut self, foundation: Option<f64>) -> Mesh {
        if let Some(stiffness) = foundation {
            let free = vec![false; self.held.len()];
            let nodes = std::mem::replace(&mut self.held, free);
            self.foundation = Some(Foundation { nodes, stiffness });
        }
        self
    }

    /// The section swept through `along`, turned by `twist` rad per metre (tan beta_b / rb; right-handed), without
    /// what lies outside of rim, web and hub.
    pub fn extruded(
        section: &Section,
        outline: &Outline,
        along: &Layers,
        twist: f64,
        foundation: Option<f64>,
    ) -> Mesh {
        let stations = &along.stations;
        let layers = stations.len() - 1;
        let in_plane = section.nodes.len();
        let mut corner = vec![usize::MAX; in_plane];
        let mut corners = 0;
        for quad in &section.quads {
            for node in &quad[..4] {
                if corner[*node] == usize::MAX {
                    corner[*node] = corners;
                    corners += 1;
                }
            }
        }
        // Planes of all nodes alternate with planes of corner nodes alone, halfway between them.
        let stride = in_plane + corners;
        let number = |node: usize, half: usize| {
            let base = (half / 2) * stride;
            if half.is_multiple_of(2) {
                base + node
            } else {
                base + in_plane + corner[node]
            }
        };
        let total = layers * stride + in_plane;
        let mut mesh = Mesh {
            dimension: 3,
            points: vec![[0.0; 3]; total],
            angles: vec![0.0; total],
            elements: Vec::with_capacity(20 * layers * section.quads.len()),
            cells: Vec::with_capacity(layers * section.quads.len()),
            held: vec![false; total],
            sides: [Vec::new(), Vec::new()],
            flank: Vec::new(),
            fillet: Vec::new(),
            foundation: None,
        };
        let halves_of_face = 2 * along.face.start..=2 * along.face.end;
        for half in 0..=2 * layers {
            let middle = half % 2 == 1;
            let low = stations[half / 2];
            let z = if middle {
                0.5 * (low + stations[half / 2 + 1])
            } else {
                low
            };
            let present = |node: &usize| !middle || corner[*node] != usize::MAX;
            for node in (0..in_plane).filter(|n| present(n)) {
                let [r, theta] = section.nodes[node];
                let angle = theta + twist * z;
                let at = number(node, half);
                mesh.points[at] = [r * angle.cos(), r * angle.sin(), z];
                mesh.angles[at] = angle;
            }
            for node in section.held.iter().filter(|n| present(n)) {
                mesh.held[number(*node, half)] = true;
            }
            for (side, nodes) in mesh.sides.iter_mut().zip(&section.sides) {
                side.extend(
                    nodes
                        .iter()
                        .filter(|n| present(n))
                        .map(|n| number(*n, half)),
                );
            }
            if !halves_of_face.contains(&half) {
                continue;
            }
            let fillet = section.fillet.iter().map(|(node, _)| node);
            mesh.fillet
                .extend(fillet.filter(|n| present(n)).map(|n| number(*n, half)));
            for (node, arc) in section.flank.iter().filter(|(n, _)| present(n)) {
                // The surface contains the helix direction (0, r twist, 1).
                let [n_r, n_t] = outline.normal(*arc);
                let n_z = -n_t * section.nodes[*node][0] * twist;
                let norm = n_z.hypot(1.0);
                mesh.flank.push(FlankNode {
                    node: number(*node, half),
                    normal: [n_r / norm, n_t / norm, n_z / norm],
                });
            }
        }
        for layer in 0..layers {
            for (quad, cell) in section.quads.iter().zip(&section.cells) {
                if !along.holds(section.part(*cell), layer) {
                    continue;
                }
                for plane in [2 * layer, 2 * layer + 2] {
                    mesh.elements.extend(quad.iter().map(|n| number(*n, plane)));
                }
                mesh.elements
                    .extend(quad[..4].iter().map(|n| number(*n, 2 * layer + 1)));
                mesh.cells.push([cell[0], cell[1], layer as i32]);
            }
        }
        if mesh.cells.len() < layers * section.quads.len() {
            mesh.drop_unused();
        }
        mesh.rested_on(foundation)
    }

    /// Takes out the nodes of elements that are not there.
    fn drop_unused(&mut self) {
        let mut used = vec![false; self.points.len()];
        self.elements.iter().for_each(|node| used[*node] = true);
        let mut count = 0;
        let number: Vec<usize> = used
            .iter()
            .map(|used| {
                count += usize::from(*used);
                count.wrapping_sub(1)
            })
            .collect();
        let mut keep = used.iter();
        self.points.retain(|_| *keep.next().unwrap_or(&false));
        let mut keep = used.iter();
        self.angles.retain(|_| *keep.next().unwrap_or(&false));
        let mut keep = used.iter();
        self.held.retain(|_| *keep.next().unwrap_or(&false));
        for nodes in &mut self.sides {
            nodes.retain(|node| used[*node]);
        }
        let sides = self.sides.iter_mut().flatten();
        let flank = self.flank.iter_mut().map(|flank| &mut flank.node);
        for node in self.elements.iter_mut().chain(sides).chain(flank) {
            *node = number[*node];
        }
    }

    /// 8 (plane) or 20 (solid).
    pub fn nodes_per_element(&self) -> usize {
        if self.dimension == 2 { 8 } else { 20 }
    }

    /// Nodes of each element.
    pub fn connectivity(&self) -> impl Iterator<Item = &[usize]> {
        self.elements.chunks(self.nodes_per_element())
    }

    /// Coordinates of the nodes of one element, m.
    pub fn coordinates(&self, element: &[usize]) -> Vec<[f64; 3]> {
        element.iter().map(|node| self.points[*node]).collect()
    }

    /// Volume (plane: area) of the mesh, and the smallest ratio of an integration point's Jacobian to
    /// the largest one of the same element: positive on a sound mesh.
    pub fn volume_and_quality(&self) -> (f64, f64) {
        let mut volume = 0.0;
        let mut quality = f64::INFINITY;
        let weights: Vec<f64> = element::integration_weights(self.dimension);
        for nodes in self.connectivity() {
            let points = element::integration_points(&self.coordinates(nodes));
            let jacobian: Vec<f64> = points
                .iter()
                .zip(&weights)
                .map(|(p, w)| p.volume / w)
                .collect();
            let largest = jacobian.iter().copied().fold(f64::MIN, f64::max);
            let smallest = jacobian.iter().copied().fold(f64::MAX, f64::min);
            volume += points.iter().map(|p| p.volume).sum::<f64>();
            quality = quality.min(smallest / largest.abs());
        }
        (volume, quality)
    }
}
