//! The mesh of one sector, the section swept along the helix, and the stiffness of its elements.

use super::element;
use super::model::Model;
use nalgebra::DMatrix;
use std::collections::{HashMap, HashSet};

/// A node of the loaded flank and the outward unit normal there in the node's own cylindrical axes
/// (radial, circumferential, axial).
#[derive(Debug, Clone, Copy)]
pub(super) struct FlankNode {
    pub node: usize,
    pub normal: [f64; 3],
}

/// A sparse load, or functional of the displacement: (unknown, value), the unknowns numbered node by node.
pub(super) type LoadColumn = Vec<(usize, f64)>;

/// One sector of the gear; displacements are in each node's own cylindrical axes, so that both sides of
/// the sector match without a rotation.
#[derive(Debug, Clone, Default)]
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
    /// Rigidly held nodes.
    pub held: Vec<bool>,
    /// Stiffness (N/m³, in each direction) of what the surface of certain nodes rests on, if it does.
    pub foundation: Option<(f64, HashSet<usize>)>,
    /// Free nodes of both sides in the same order.
    pub sides: [Vec<usize>; 2],
    /// Nodes of the loaded flank, in the order of [`super::flank::FlankGrid`].
    pub flank: Vec<FlankNode>,
    /// Nodes of root circle and fillet next to the loaded flank, in the same order.
    pub fillet: Vec<usize>,
}

/// The mesh while it grows: its nodes by node of the section and half layer.
struct Sweep<'a> {
    model: &'a Model,
    stations: &'a [f64],
    twist: f64,
    numbers: HashMap<(usize, usize), usize>,
    mesh: Mesh,
}

impl Sweep<'_> {
    /// Number of the node `node` of the section after `half` layers; a new one if there is none yet.
    fn number(&mut self, node: usize, half: usize) -> usize {
        let z = 0.5 * (self.stations[half / 2] + self.stations[half.div_ceil(2)]);
        *self.numbers.entry((node, half)).or_insert_with(|| {
            let Model {
                gear,
                section,
                layers,
                ..
            } = self.model;
            let mesh = &mut self.mesh;
            let [r, theta] = section.nodes[node];
            let angle = theta + self.twist * z;
            let number = mesh.points.len();
            mesh.points.push([r * angle.cos(), r * angle.sin(), z]);
            mesh.angles.push(angle);
            let at_end = half.is_multiple_of(2)
                && layers
                    .as_ref()
                    .is_some_and(|layers| layers.is_held(half / 2));
            let rests = section.held.binary_search(&node).is_ok();
            mesh.held.push(at_end || rests && gear.foundation.is_none());
            if let (true, Some((_, nodes))) = (rests, &mut mesh.foundation) {
                nodes.insert(number);
            }
            number
        })
    }

    fn add_elements(&mut self) {
        let section = &self.model.section;
        for (quad, cell) in section.quads.iter().zip(&section.cells) {
            let Some(layers) = &self.model.layers else {
                let nodes = quad.map(|node| self.number(node, 0));
                self.mesh.elements.extend(nodes);
                self.mesh.cells.push([cell[0], cell[1], 0]);
                continue;
            };
            let width = section.width(*cell);
            for layer in (0..self.stations.len() - 1).filter(|i| layers.holds(width, *i)) {
                for (nodes, half) in [(&quad[..], 0), (&quad[..], 2), (&quad[..4], 1)] {
                    for node in nodes {
                        let number = self.number(*node, 2 * layer + half);
                        self.mesh.elements.push(number);
                    }
                }
                self.mesh.cells.push([cell[0], cell[1], layer as i32]);
            }
        }
    }

    fn find_sides(&mut self) {
        let [left, right] = &self.model.section.sides;
        let twins: HashMap<_, _> = left.iter().zip(right).collect();
        let mut all: Vec<_> = self.numbers.iter().collect();
        all.sort_unstable_by_key(|(_, number)| **number);
        for ((node, half), number) in all {
            if let (Some(twin), false) = (twins.get(node), self.mesh.held[*number]) {
                self.mesh.sides[0].push(*number);
                self.mesh.sides[1].push(self.numbers[&(**twin, *half)]);
            }
        }
    }

    fn find_surface(&mut self) {
        let Model {
            outline,
            section,
            layers,
            ..
        } = self.model;
        let face = layers.as_ref().map_or(0..0, |layers| layers.face.clone());
        for half in 2 * face.start..=2 * face.end {
            let number = |node: usize| self.numbers.get(&(node, half)).copied();
            let fillet = section.fillet.iter().map(|(node, _)| *node);
            self.mesh.fillet.extend(fillet.filter_map(number));
            for (node, arc) in &section.flank {
                let Some(number) = number(*node) else {
                    continue;
                };
                // The surface contains the helix direction (0, r twist, 1).
                let [n_r, n_t] = outline.normal(*arc);
                let n_z = -n_t * section.nodes[*node][0] * self.twist;
                let norm = n_z.hypot(1.0);
                self.mesh.flank.push(FlankNode {
                    node: number,
                    normal: [n_r / norm, n_t / norm, n_z / norm],
                });
            }
        }
    }
}

impl Mesh {
    /// The section of `model` itself for plane strain, or swept through its layers along the helix without what lies outside of
    /// rim, web and hub.
    pub fn new(model: &Model) -> Mesh {
        let layers = model.layers.as_ref();
        let mut sweep = Sweep {
            model,
            stations: layers.map_or(&[0.0], |layers| &layers.stations),
            twist: layers.map_or(0.0, |_| model.twist()),
            numbers: HashMap::new(),
            mesh: Mesh {
                dimension: if layers.is_some() { 3 } else { 2 },
                foundation: (model.gear.foundation).map(|stiffness| (stiffness, HashSet::new())),
                ..Mesh::default()
            },
        };
        sweep.add_elements();
        sweep.find_sides();
        sweep.find_surface();
        sweep.mesh
    }

    /// Unit normal loads on the flank nodes.
    pub fn loads(&self) -> Vec<LoadColumn> {
        let unknowns = |node: usize| self.dimension * node..self.dimension * (node + 1);
        let load = |flank: &FlankNode| unknowns(flank.node).zip(flank.normal).collect();
        self.flank.iter().map(load).collect()
    }

    pub fn nodes_per_element(&self) -> usize {
        if self.dimension == 2 { 8 } else { 20 }
    }

    pub fn connectivity(&self) -> impl Iterator<Item = &[usize]> {
        self.elements.chunks(self.nodes_per_element())
    }

    /// Nodes of the element with this number.
    pub fn nodes(&self, element: usize) -> &[usize] {
        let size = self.nodes_per_element();
        &self.elements[size * element..size * (element + 1)]
    }

    pub fn coordinates(&self, element: &[usize]) -> Vec<[f64; 3]> {
        element.iter().map(|node| self.points[*node]).collect()
    }

    /// Stiffness of the element with `nodes`, N/m, the displacements of each in its own cylindrical axes. `material`: Young's
    /// modulus, Pa, and Poisson ratio.
    pub fn stiffness(&self, nodes: &[usize], material: [f64; 2]) -> DMatrix<f64> {
        let x = self.coordinates(nodes);
        let (lambda, mu) = element::lame(material[0], material[1]);
        let mut k = element::stiffness(&x, lambda, mu);
        if let Some((stiffness, surface)) = &self.foundation {
            let rests: Vec<bool> = nodes.iter().map(|node| surface.contains(node)).collect();
            element::add_foundation(&x, &rests, *stiffness, &mut k);
        }
        // Symmetric: turned columns become rows, and then they are turned, too.
        for _ in 0..2 {
            k.transpose_mut();
            for (first, node) in nodes.iter().enumerate() {
                let (sin, cos) = self.angles[*node].sin_cos();
                let first = self.dimension * first;
                let (mut x, mut y) = k.columns_range_pair_mut(first, first + 1);
                for (x, y) in x.iter_mut().zip(y.iter_mut()) {
                    (*x, *y) = (cos * *x + sin * *y, cos * *y - sin * *x);
                }
            }
        }
        k
    }

    /// Volume (plane: area) of the mesh, and the smallest ratio of an integration point's Jacobian to
    /// the largest one of the same element: positive on a sound mesh.
    pub fn volume_and_quality(&self) -> (f64, f64) {
        let mut volume = 0.0;
        let mut quality = f64::INFINITY;
        for nodes in self.connectivity() {
            let points = element::integration_points(&self.coordinates(nodes));
            let jacobians = || points.iter().map(|point| point.jacobian);
            let largest = jacobians().fold(f64::MIN, f64::max);
            let smallest = jacobians().fold(f64::MAX, f64::min);
            volume += points.iter().map(|point| point.volume).sum::<f64>();
            quality = quality.min(smallest / largest.abs());
        }
        (volume, quality)
    }
}
