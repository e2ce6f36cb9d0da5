//! The mesh of one sector, which [`super::extrusion`] makes, and the stiffness of its elements.

use super::element;
use nalgebra::DMatrix;
use std::collections::BTreeMap;

/// A node of the loaded flank and the outward unit normal there in the node's own cylindrical axes
/// (radial, circumferential, axial).
#[derive(Debug, Clone, Copy)]
pub(super) struct FlankNode {
    pub node: usize,
    pub normal: [f64; 3],
}

/// A sparse load, or functional of the displacement: (unknown, value), the unknowns numbered node by node.
pub(super) type LoadColumn = Vec<(usize, f64)>;

#[derive(Debug, Clone)]
pub(super) struct Foundation {
    /// Whether a node lies on the surface that rests on it.
    pub nodes: Vec<bool>,
    /// Stiffness per area in each direction, N/m³.
    pub stiffness: f64,
}

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
    pub held: Vec<bool>,
    /// What the held surface rests on where it is not rigid.
    pub foundation: Option<Foundation>,
    /// Nodes of both sides in the same order.
    pub sides: [Vec<usize>; 2],
    /// Nodes of the loaded flank, in the order of [`super::flank::FlankGrid`].
    pub flank: Vec<FlankNode>,
    /// Nodes of root circle and fillet beside the loaded flank, in the same order.
    pub fillet: Vec<usize>,
    /// Nodes within a side of a larger element, with the nodes of that side and their shares in the displacement
    /// (in Cartesian axes): such a node has no unknowns of its own. None of the carrying nodes hangs.
    pub hanging: BTreeMap<usize, Vec<(usize, f64)>>,
}

impl Mesh {
    /// The mesh with its held nodes on a foundation of the given stiffness (N/m³), if there is one.
    pub fn rested_on(mut self, foundation: Option<f64>) -> Mesh {
        if let Some(stiffness) = foundation {
            let free = vec![false; self.held.len()];
            let nodes = std::mem::replace(&mut self.held, free);
            self.foundation = Some(Foundation { nodes, stiffness });
        }
        self
    }

    /// Unit normal loads on the flank nodes.
    pub fn loads(&self) -> Vec<LoadColumn> {
        let unknowns = |node: usize| self.dimension * node..self.dimension * (node + 1);
        let load = |flank: &FlankNode| unknowns(flank.node).zip(flank.normal).collect();
        self.flank.iter().map(load).collect()
    }

    /// 8 (plane) or 20 (solid).
    pub fn nodes_per_element(&self) -> usize {
        if self.dimension == 2 { 8 } else { 20 }
    }

    pub fn connectivity(&self) -> impl Iterator<Item = &[usize]> {
        self.elements.chunks(self.nodes_per_element())
    }

    /// The nodes whose unknowns the element with `nodes` knows: its own and, in place of one that hangs, those that
    /// carry it; each once.
    pub fn carrying(&self, nodes: &[usize]) -> Vec<usize> {
        if !nodes.iter().any(|node| self.hanging.contains_key(node)) {
            return nodes.to_vec();
        }
        let mut all = Vec::new();
        for (carrier, _) in nodes.iter().flat_map(|node| self.carriers(*node)) {
            if !all.contains(&carrier) {
                all.push(carrier);
            }
        }
        all
    }

    /// The nodes that `node` follows, with their shares: itself unless it hangs.
    fn carriers(&self, node: usize) -> Vec<(usize, f64)> {
        let carriers = self.hanging.get(&node).cloned();
        carriers.unwrap_or_else(|| vec![(node, 1.0)])
    }

    pub fn coordinates(&self, element: &[usize]) -> Vec<[f64; 3]> {
        element.iter().map(|node| self.points[*node]).collect()
    }

    /// Nodes whose unknowns the element with `nodes` knows ([`Mesh::carrying`]), and its stiffness, N/m, with the displacements of
    /// each in its own cylindrical axes. `material`: Young's modulus, Pa, and Poisson ratio.
    pub fn stiffness(&self, nodes: &[usize], material: [f64; 2]) -> (Vec<usize>, DMatrix<f64>) {
        let x = self.coordinates(nodes);
        let (lambda, mu) = element::lame(material[0], material[1]);
        let mut k = element::stiffness(&x, lambda, mu);
        if let Some(foundation) = &self.foundation {
            let rests: Vec<bool> = nodes.iter().map(|node| foundation.nodes[*node]).collect();
            element::add_foundation(&x, &rests, foundation.stiffness, &mut k);
        }
        let carrying = self.carrying(nodes);
        if carrying != nodes {
            let shares = self.shares(nodes, &carrying);
            k = shares.tr_mul(&(k * &shares));
        }
        // Symmetric: turned columns become rows, and then they are turned, too.
        for _ in 0..2 {
            k.transpose_mut();
            for (at, node) in carrying.iter().enumerate() {
                let (sin, cos) = self.angles[*node].sin_cos();
                let first = self.dimension * at;
                let (mut x, mut y) = k.columns_range_pair_mut(first, first + 1);
                for (x, y) in x.iter_mut().zip(y.iter_mut()) {
                    (*x, *y) = (cos * *x + sin * *y, cos * *y - sin * *x);
                }
            }
        }
        (carrying, k)
    }

    /// The displacements of `nodes` by those of the nodes `carrying` them.
    fn shares(&self, nodes: &[usize], carrying: &[usize]) -> DMatrix<f64> {
        let d = self.dimension;
        let mut shares = DMatrix::zeros(d * nodes.len(), d * carrying.len());
        for (row, node) in nodes.iter().enumerate() {
            let carriers = self.carriers(*node);
            for (column, node) in carrying.iter().enumerate() {
                if let Some((_, share)) = carriers.iter().find(|(carrier, _)| carrier == node) {
                    (0..d).for_each(|i| shares[(d * row + i, d * column + i)] = *share);
                }
            }
        }
        shares
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
