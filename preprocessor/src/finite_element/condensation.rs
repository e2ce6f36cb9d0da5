//! What is left of a sector when its inside is eliminated.
//!
//! With the unknowns of the sides s kept, those of the inside i eliminated ([`super::fronts`]), and loads F, or functionals of the
//! displacement, as further rows and columns of the stiffness K,
//!
//! ```text
//! [ K    F ]         [ S     g      ]    S stiffness of the sides, g forces of the loads on the held sides,
//! [ F^T  0 ]  gives  [ g^T  -C_held ] ,  C_held displacement along the loads with the sides held.
//! ```
//!
//! The body, of which few elements stand for a pitch ([`Section::body`](super::section::Section::body)), is not in it: it joins in each
//! harmonic of the ring ([`PeriodicBody`]). The nodes between the sides on which teeth and rim hang there are kept, too.

use super::error::FiniteElementError;
use super::fronts::{Elimination, Fronts};
use super::mesh::{LoadColumn, Mesh};
use super::periodic_body::PeriodicBody;
use super::sector_nodes::SectorNodes;
use nalgebra::DMatrix;

pub(super) struct CondensedSector {
    /// Stiffness of both sides, side 0 first, and of the nodes between them at which the body begins, N/m; lower triangle valid.
    pub sides: DMatrix<f64>,
    /// Unknowns of a side.
    pub of_side: usize,
    /// The body, if it is not in the sector.
    pub body: Option<PeriodicBody>,
    /// Forces on the held sides from each unit load column; as many rows as `sides`.
    pub side_loads: DMatrix<f64>,
    /// Displacements along the columns with the sides held, m/N: by loads, or functionals by loads where there are any.
    pub held_influence: DMatrix<f64>,
    /// Numbers kept at most at a time.
    pub numbers: usize,
}

/// Eliminates the inside of the sector `mesh` under the first `loads` of `columns`; the others are functionals that are observed
/// under them. None of them acts on the body. It may take `memory_share` of the memory that is left. `progress` is given the share done and
/// may stop the work.
pub(super) fn condense(
    mesh: &Mesh,
    columns: &[LoadColumn],
    loads: usize,
    memory_share: f64,
    progress: &(dyn Fn(f64) -> bool + Sync),
) -> Result<CondensedSector, FiniteElementError> {
    let nodes = SectorNodes::of(mesh);
    let kept = [&nodes.sides[0][..], &nodes.sides[1], &nodes.between].concat();
    let fronts = Fronts::new(
        mesh,
        nodes.moving[..mesh.body].to_vec(),
        &mesh.cells[..mesh.body],
        [nodes.inside.clone(), kept],
        columns,
        loads,
    );
    let own = fronts.root.own.len();
    let numbers = fronts.root.numbers.max((own + columns.len()).pow(2));
    check_memory(size_of::<f64>() * numbers, memory_share)?;

    let front = Elimination::<1>::new(&fronts, &|element| mesh.moved_stiffness(element), progress)
        .assembled(&fronts.root)?;
    let side_loads = front.columns.rows_range(own..).transpose();
    let mut held_influence = -front.rest;
    if loads < columns.len() {
        held_influence = held_influence.remove_rows(0, loads);
    } else {
        held_influence.fill_upper_triangle_with_lower_triangle();
    }
    Ok(CondensedSector {
        sides: front.columns.resize_vertically(own, 0.0),
        of_side: mesh.dimension * nodes.sides[0].len(),
        body: PeriodicBody::new(mesh, &nodes),
        side_loads,
        held_influence,
        numbers,
    })
}

impl CondensedSector {
    /// The sector of the mesh `other` where this is that of `own`, if the teeth are the same and the bodies alone differ.
    pub fn on_body_of(self, own: &Mesh, other: &Mesh) -> Option<CondensedSector> {
        let nodes = SectorNodes::of(other);
        let [old, new] = [SectorNodes::of(own).places(own), nodes.places(other)];
        let mut both = old.iter().zip(&new);
        let are_alike = old.len() == new.len()
            && both.all(|(a, b)| (0..3).all(|i| (a[i] - b[i]).abs() <= 1e-12));
        are_alike.then(|| CondensedSector {
            body: PeriodicBody::new(other, &nodes),
            ..self
        })
    }
}

/// Refuses work that takes `bytes` where that is more than this `share` of what the system says that it has left: one that grants more
/// ends the program later.
fn check_memory(bytes: usize, share: f64) -> Result<(), FiniteElementError> {
    let state = std::fs::read_to_string("/proc/meminfo").unwrap_or_default();
    match available(&state) {
        Some(available) if bytes as f64 > share * available as f64 => {
            Err(FiniteElementError::Memory {
                needed_gb: 1e-9 * bytes as f64,
                available_gb: 1e-9 * available as f64,
            })
        }
        _ => Ok(()),
    }
}

/// Bytes that Linux's `/proc/meminfo` says new work can take without swapping.
fn available(meminfo: &str) -> Option<usize> {
    let mut lines = meminfo.lines();
    let rest = lines.find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let kilobytes = rest.trim().strip_suffix("kB")?.trim();
    kilobytes.parse::<usize>().ok()?.checked_mul(1024)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::finite_element::model::Model;
    use crate::finite_element::tests::plane;
    use crate::gear::Refinement;
    use crate::samples;
    use gearmesh::gear::GearKind;

    #[test]
    fn parts_leave_the_schur_complement_of_the_whole_matrix() {
        let gear = samples::gear(GearKind::External, 20, 1.0, 0.0, 0.0);
        let settings = plane(Refinement::Coarse, 0);
        let mut mesh = Model::new(&gear, &settings).unwrap().mesh();
        mesh.material = [1.0, 0.3];
        // The free unknowns, those of the sides last.
        let mut apart = mesh.held.clone();
        (mesh.sides.iter().flatten()).for_each(|node| apart[*node] = true);
        let mut order: Vec<usize> = (0..apart.len()).filter(|node| !apart[*node]).collect();
        let inside = 2 * order.len();
        order.extend(mesh.sides.iter().flatten());
        let n = 2 * order.len();
        let at = |node: usize| order.iter().position(|other| *other == node);
        let mut whole = DMatrix::<f64>::zeros(n, n);
        for nodes in &mesh.elements {
            let k = mesh.stiffness(nodes);
            let rows: Vec<Option<usize>> = nodes.iter().map(|node| at(*node)).collect();
            for (i, j) in (0..k.nrows()).flat_map(|i| (0..k.nrows()).map(move |j| (i, j))) {
                if let (Some(row), Some(column)) = (rows[i / 2], rows[j / 2]) {
                    whole[(2 * row + i % 2, 2 * column + j % 2)] += k[(i, j)];
                }
            }
        }
        // Loads and functionals at single unknowns, at some that are far apart, and on the sides.
        let sparse: [&[(usize, f64)]; 5] = [
            &[(3, 1.0)],
            &[(inside / 2, 2.0), (inside - 1, -1.0)],
            &[(inside + 5, 1.0), (7, 0.5)],
            &[(inside / 3, 1.0), (11, 0.3), (n - 1, -2.0)],
            &[(inside - 2, 1.0)],
        ];
        let mut loads = DMatrix::<f64>::zeros(n, sparse.len());
        let mut columns = vec![LoadColumn::new(); sparse.len()];
        for (j, entries) in sparse.iter().enumerate() {
            for (row, value) in *entries {
                loads[(*row, j)] = *value;
                columns[j].push((2 * order[row / 2] + row % 2, *value));
            }
        }
        let inner = whole.view((0, 0), (inside, inside)).clone_owned();
        let factor = inner.cholesky().unwrap();
        let across = whole.view((inside, 0), (n - inside, inside));
        let (loads_inside, loads_sides) = (loads.rows(0, inside), loads.rows(inside, n - inside));
        let sides = whole.view((inside, inside), (n - inside, n - inside))
            - across * factor.solve(&across.transpose());
        let side_loads = loads_sides - across * factor.solve(&loads_inside);
        let held = loads_inside.transpose() * factor.solve(&loads_inside);

        let near = |found: &DMatrix<f64>, expected: &DMatrix<f64>| {
            assert!((found - expected).amax() < 1e-10 * expected.amax());
        };
        let all = condense(&mesh, &columns, columns.len(), 1.0, &|_| true).unwrap();
        near(&all.sides.lower_triangle(), &sides.lower_triangle());
        near(&all.side_loads, &side_loads);
        near(&all.held_influence, &held);
        let observed = condense(&mesh, &columns, 2, 1.0, &|_| true).unwrap();
        let held = held.view((2, 0), (3, 2)).clone_owned();
        near(&observed.held_influence, &held);
        near(&observed.side_loads, &side_loads);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn more_memory_than_there_is_is_refused_and_a_little_is_not() {
        let state = "MemTotal:       24576000 kB\nMemFree:  1 kB\nMemAvailable:   20480000 kB\n";
        assert_eq!(available(state), Some(20_971_520_000));
        assert_eq!(available(""), None);
        check_memory(1 << 20, 1.0).unwrap();
        let error = check_memory(1 << 60, 1.0).unwrap_err().to_string();
        assert!(error.contains("1152921504.6 GB"), "{error}");
    }
}
