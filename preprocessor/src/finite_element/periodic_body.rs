//! The body of a gear in a harmonic of the ring: from 0.7 pitches below the roots on a few elements stand for a pitch
//! ([`Section::body`](super::section::Section::body)).
//!
//! In a harmonic one side of them is the other times a phase. So the nodes of one side and those between the sides are all there are. They
//! are eliminated in each harmonic, up to those that move teeth and rim, which takes little: few nodes divide the section of a body.

use super::error::FiniteElementError;
use super::fronts::{Elimination, Fronts};
use super::mesh::Mesh;
use super::sector_nodes::SectorNodes;
use nalgebra::{Complex, DMatrix};
use rayon::prelude::*;
use std::collections::HashMap;

/// The elements of the body in one pitch, and the order in which their nodes are eliminated.
pub(super) struct PeriodicBody {
    fronts: Fronts,
    /// Of each element, N/m.
    stiffness: Vec<DMatrix<f64>>,
    /// Whether the nodes that move each element are on side 1.
    ahead: Vec<Vec<bool>>,
    /// Those of the unknowns of a harmonic, side 0 and the nodes between, that the body shares with the sector; ascending.
    pub shared: Vec<usize>,
}

impl PeriodicBody {
    /// Of `mesh`, if it has a body.
    pub fn new(mesh: &Mesh, nodes: &SectorNodes) -> Option<PeriodicBody> {
        let moving = &nodes.moving[mesh.body..];
        if moving.is_empty() {
            return None;
        }
        let sides = mesh.sides[1].iter().zip(&mesh.sides[0]);
        let behind: HashMap<&usize, &usize> = sides.collect();
        let mut is_inside = vec![false; mesh.points.len()];
        let mut followed = Vec::new();
        for nodes in moving {
            let nodes = nodes.iter().map(|node| **behind.get(node).unwrap_or(&node));
            let nodes: Vec<usize> = nodes.collect();
            nodes
                .iter()
                .for_each(|node| is_inside[*node] = !mesh.held[*node]);
            followed.push(nodes);
        }
        let d = mesh.dimension;
        let (mut kept, mut shared) = (Vec::new(), Vec::new());
        for (place, node) in nodes.sides[0].iter().chain(&nodes.between).enumerate() {
            if std::mem::take(&mut is_inside[*node]) {
                kept.push(*node);
                shared.extend(d * place..d * (place + 1));
            }
        }
        let inside = (0..is_inside.len()).filter(|node| is_inside[*node]);
        let eliminated = [inside.collect(), kept];
        let cells = &mesh.cells[mesh.body..];
        let elements = (mesh.body..mesh.elements.len()).into_par_iter();
        let ahead = moving.iter();
        let ahead = ahead.map(|nodes| nodes.iter().map(|n| behind.contains_key(n)).collect());
        Some(PeriodicBody {
            fronts: Fronts::new(mesh, followed, cells, eliminated, &[], 0),
            stiffness: elements
                .map(|element| mesh.moved_stiffness(element))
                .collect(),
            ahead: ahead.collect(),
            shared,
        })
    }

    /// Stiffness of the shared unknowns where side 1 is `phase` times side 0, N/m: lower triangle, each column a real and an imaginary one.
    pub fn stiffness(&self, phase: Complex<f64>) -> Result<DMatrix<f64>, FiniteElementError> {
        let d = self.fronts.dimension;
        let of_element = |element: usize| {
            let real = &self.stiffness[element];
            let ahead = &self.ahead[element];
            let mut both = DMatrix::zeros(real.nrows(), 2 * real.ncols());
            for (j, column) in real.column_iter().enumerate() {
                for (i, value) in column.iter().enumerate() {
                    let factor = match (ahead[i / d], ahead[j / d]) {
                        (false, true) => phase,
                        (true, false) => phase.conj(),
                        _ => Complex::ONE,
                    };
                    both[(i, 2 * j)] = value * factor.re;
                    both[(i, 2 * j + 1)] = value * factor.im;
                }
            }
            both
        };
        let elimination = Elimination::<2>::new(&self.fronts, &of_element, &|_| true);
        Ok(elimination.assembled(&self.fronts.root)?.columns)
    }
}
