//! Stiffness matrix of one sector, in elimination order.

use super::element;
use super::mesh::Mesh;
use rayon::prelude::*;

/// Lower triangle of a symmetric matrix in compressed columns, rows ascending.
pub(super) struct LowerTriangle {
    pub column_starts: Vec<usize>,
    pub rows: Vec<usize>,
    pub values: Vec<f64>,
}

/// Number of the first unknown of each node, `usize::MAX` for held nodes.
pub(super) fn number_unknowns(mesh: &Mesh, order: &[usize]) -> Vec<usize> {
    let mut first = vec![usize::MAX; mesh.points.len()];
    for (position, node) in order.iter().enumerate() {
        first[*node] = mesh.dimension * position;
    }
    first
}

/// Assembles the stiffness of the free nodes of `mesh`, N/m, with the unknowns numbered by `order`;
/// displacements in each node's cylindrical axes.
///
/// `material`: Young's modulus, Pa, and Poisson ratio.
pub(super) fn assemble(mesh: &Mesh, order: &[usize], material: [f64; 2]) -> LowerTriangle {
    let d = mesh.dimension;
    let per_element = mesh.nodes_per_element();
    let first = number_unknowns(mesh, order);
    let (column_starts, rows, neighbours) = pattern(mesh, order, &first);
    let mut values = vec![0.0; rows.len()];
    let (lambda, mu) = element::lame(material[0], material[1]);
    // Element matrices in parallel, a batch at a time so that few are alive; scattering is serial.
    for batch in mesh.elements.chunks(256 * per_element) {
        let matrices: Vec<(Vec<usize>, Vec<f64>)> = batch
            .par_chunks(per_element)
            .map(|nodes| cylindrical_stiffness(mesh, nodes, lambda, mu))
            .collect();
        for (nodes, k) in &matrices {
            for (a, column_node) in nodes.iter().enumerate() {
                let column = first[*column_node];
                if column == usize::MAX {
                    continue;
                }
                let list = &neighbours[column / d];
                for (b, row_node) in nodes.iter().enumerate() {
                    let row = first[*row_node];
                    if row == usize::MAX || row < column {
                        continue;
                    }
                    let place = list.partition_point(|n| *n < row / d);
                    for i in 0..d {
                        // Column i of the diagonal block starts at its own diagonal.
                        let start = column_starts[column + i] + d * place - i;
                        for m in (if place == 0 { i } else { 0 })..d {
                            values[start + m] += k[(d * a + i) * d * nodes.len() + d * b + m];
                        }
                    }
                }
            }
        }
    }
    LowerTriangle {
        column_starts,
        rows,
        values,
    }
}

type Pattern = (Vec<usize>, Vec<usize>, Vec<Vec<usize>>);

/// Column starts, rows, and for each position in the order the positions at or after it that share an
/// element, ascending.
fn pattern(mesh: &Mesh, order: &[usize], first: &[usize]) -> Pattern {
    let d = mesh.dimension;
    let mut neighbours: Vec<Vec<usize>> = vec![Vec::new(); order.len()];
    for nodes in mesh.connectivity().map(|nodes| mesh.carrying(nodes)) {
        for a in nodes.iter().map(|n| first[*n]).filter(|p| *p != usize::MAX) {
            let list = &mut neighbours[a / d];
            list.extend(
                nodes
                    .iter()
                    .map(|n| first[*n])
                    .filter(|p| *p != usize::MAX && *p >= a)
                    .map(|p| p / d),
            );
        }
    }
    let mut column_starts = Vec::with_capacity(d * order.len() + 1);
    let mut rows = Vec::new();
    column_starts.push(0);
    for list in &mut neighbours {
        list.sort_unstable();
        list.dedup();
        for i in 0..d {
            rows.extend(list.iter().flat_map(|n| d * n..d * n + d).skip(i));
            column_starts.push(rows.len());
        }
    }
    (column_starts, rows, neighbours)
}

/// Stiffness of the first element of `mesh`, as [`assemble`] takes it.
pub(super) fn first_element(mesh: &Mesh, material: [f64; 2]) -> Vec<f64> {
    let (lambda, mu) = element::lame(material[0], material[1]);
    mesh.connectivity().next().map_or(Vec::new(), |nodes| {
        cylindrical_stiffness(mesh, nodes, lambda, mu).1
    })
}

/// Nodes whose unknowns an element knows ([`Mesh::carrying`]), and its stiffness with the displacements of each in its
/// own cylindrical axes.
fn cylindrical_stiffness(
    mesh: &Mesh,
    nodes: &[usize],
    lambda: f64,
    mu: f64,
) -> (Vec<usize>, Vec<f64>) {
    let d = mesh.dimension;
    let x = mesh.coordinates(nodes);
    let mut k = element::stiffness(&x, lambda, mu);
    if let Some(foundation) = &mesh.foundation {
        let rests: Vec<bool> = nodes.iter().map(|node| foundation.nodes[*node]).collect();
        element::add_foundation(&x, &rests, foundation.stiffness, &mut k);
    }
    let carrying = mesh.carrying(nodes);
    if carrying != nodes {
        k = carried(mesh, nodes, &carrying, &k);
    }
    let size = d * carrying.len();
    let rotations = carrying.iter().map(|n| mesh.angles[*n].sin_cos());
    let rotations: Vec<(f64, f64)> = rotations.collect();
    // u_x = c u_r - s u_t, u_y = s u_r + c u_t, on rows and on columns.
    for (a, (s, c)) in rotations.iter().enumerate() {
        for row in 0..size {
            let at = row * size + d * a;
            let (x, y) = (k[at], k[at + 1]);
            k[at] = c * x + s * y;
            k[at + 1] = c * y - s * x;
        }
    }
    for (a, (s, c)) in rotations.iter().enumerate() {
        for column in 0..size {
            let at = d * a * size + column;
            let (x, y) = (k[at], k[at + size]);
            k[at] = c * x + s * y;
            k[at + size] = c * y - s * x;
        }
    }
    (carrying, k)
}

/// The stiffness `k` of an element with `nodes`, some of them hanging, felt at those that carry it.
fn carried(mesh: &Mesh, nodes: &[usize], carrying: &[usize], k: &[f64]) -> Vec<f64> {
    let d = mesh.dimension;
    let shares: Vec<Vec<(usize, f64)>> = nodes
        .iter()
        .map(|node| {
            let own = vec![(*node, 1.0)];
            let of = mesh.hanging.get(node).unwrap_or(&own);
            let place = |node: usize| carrying.iter().position(|n| *n == node);
            of.iter()
                .filter_map(|(node, share)| Some((place(*node)?, *share)))
                .collect()
        })
        .collect();
    let (size, few) = (d * carrying.len(), d * nodes.len());
    let mut out = vec![0.0; size * size];
    for (a, rows) in shares.iter().enumerate() {
        for (b, columns) in shares.iter().enumerate() {
            for (row, row_share) in rows {
                for (column, column_share) in columns {
                    let share = row_share * column_share;
                    for i in 0..d {
                        for m in 0..d {
                            out[(d * row + i) * size + d * column + m] +=
                                share * k[(d * a + i) * few + d * b + m];
                        }
                    }
                }
            }
        }
    }
    out
}
