//! Nested dissection of the structured mesh: the order in which nodes are eliminated.
//!
//! Elements carry integer cells (column, row, layer), and cutting along whole columns, rows or layers
//! gives straight separators. At each step every such cut that leaves at least 30 % on either side is
//! tried and the one that shares the fewest nodes is taken (George, SIAM J. Numer. Anal. 10, 1973).

use super::mesh::Mesh;
use std::ops::Range;

/// Parts of at most so many elements are not cut further.
const LEAF: usize = 4;

/// In what order the nodes of a mesh are eliminated.
pub(super) struct Elimination {
    /// All free nodes; the nodes of the sector's sides come last, first those of side 0, then of side 1, in their own
    /// order.
    pub order: Vec<usize>,
    /// The tree of separators without the sides, each part after the two that it separates.
    pub parts: Vec<Part>,
}

/// Unknowns that are eliminated together: a separator or what is not cut further.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Part {
    /// Numbers of the unknowns, as [`super::assembly::number_unknowns`] gives them by the order.
    pub unknowns: Range<usize>,
    /// Parts that this one separates.
    pub separates: Vec<usize>,
}

impl Elimination {
    /// Of the free nodes of `mesh`.
    pub fn new(mesh: &Mesh) -> Elimination {
        let mut placed = mesh.held.clone();
        mesh.hanging.keys().for_each(|node| placed[*node] = true);
        let mut dissection = Dissection {
            mesh,
            carrying: mesh.connectivity().map(|n| mesh.carrying(n)).collect(),
            placed,
            seen: vec![0; mesh.points.len()],
            stamp: 0,
            order: Vec::with_capacity(mesh.points.len()),
            parts: Vec::new(),
        };
        for node in mesh.sides.iter().flatten() {
            dissection.placed[*node] = true;
        }
        dissection.cut((0..mesh.cells.len()).collect());
        let Dissection {
            mut order, parts, ..
        } = dissection;
        order.extend(mesh.sides.iter().flatten());
        Elimination { order, parts }
    }
}

struct Dissection<'a> {
    mesh: &'a Mesh,
    /// Nodes whose unknowns each element knows.
    carrying: Vec<Vec<usize>>,
    placed: Vec<bool>,
    /// Last stamp a node was seen with; saves clearing it.
    seen: Vec<u32>,
    stamp: u32,
    order: Vec<usize>,
    parts: Vec<Part>,
}

impl Dissection<'_> {
    /// Places the nodes of `elements` that are not placed; the number of their last part.
    fn cut(&mut self, elements: Vec<usize>) -> usize {
        let best = if elements.len() > LEAF {
            self.best_cut(&elements)
        } else {
            None
        };
        let Some((axis, limit)) = best else {
            let begin = self.order.len();
            for element in elements {
                for node in &self.carrying[element] {
                    if !self.placed[*node] {
                        self.placed[*node] = true;
                        self.order.push(*node);
                    }
                }
            }
            return self.part(begin, Vec::new());
        };
        let separator = self.shared(&elements, axis, limit);
        separator.iter().for_each(|node| self.placed[*node] = true);
        let (low, high): (Vec<usize>, Vec<usize>) = elements
            .iter()
            .partition(|e| self.mesh.cells[**e][axis] < limit);
        let separates = vec![self.cut(low), self.cut(high)];
        let begin = self.order.len();
        self.order.extend(separator);
        self.part(begin, separates)
    }

    /// Makes a part of what was placed from `begin` on.
    fn part(&mut self, begin: usize, separates: Vec<usize>) -> usize {
        let d = self.mesh.dimension;
        self.parts.push(Part {
            unknowns: d * begin..d * self.order.len(),
            separates,
        });
        self.parts.len() - 1
    }

    /// Free nodes that elements below the limit share with elements above it.
    fn shared(&mut self, elements: &[usize], axis: usize, limit: i32) -> Vec<usize> {
        self.stamp += 2;
        let (below, taken) = (self.stamp, self.stamp + 1);
        let mut shared = Vec::new();
        for element in elements
            .iter()
            .filter(|e| self.mesh.cells[**e][axis] < limit)
        {
            for node in &self.carrying[*element] {
                self.seen[*node] = below;
            }
        }
        for element in elements
            .iter()
            .filter(|e| self.mesh.cells[**e][axis] >= limit)
        {
            for node in &self.carrying[*element] {
                if self.seen[*node] == below && !self.placed[*node] {
                    self.seen[*node] = taken;
                    shared.push(*node);
                }
            }
        }
        shared
    }

    fn best_cut(&mut self, elements: &[usize]) -> Option<(usize, i32)> {
        let mut best: Option<(f64, usize, i32)> = None;
        for axis in 0..3 {
            let mut keys: Vec<i32> = elements.iter().map(|e| self.mesh.cells[*e][axis]).collect();
            keys.sort_unstable();
            let limits = keys.windows(2).filter(|w| w[0] != w[1]).map(|w| w[1]);
            for limit in limits.collect::<Vec<_>>() {
                let low = keys.partition_point(|key| *key < limit);
                let share = low as f64 / elements.len() as f64;
                if (0.3..=0.7).contains(&share) {
                    let size = self.shared(elements, axis, limit).len() as f64;
                    // Equal halves are worth a slightly larger separator.
                    let cost = size * (1.0 + (share - 0.5).powi(2) * 4.0);
                    if best.is_none_or(|(least, ..)| cost < least) {
                        best = Some((cost, axis, limit));
                    }
                }
            }
        }
        best.map(|(_, axis, limit)| (axis, limit))
    }
}
