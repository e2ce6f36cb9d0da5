//! What is left of a sector when its inside is eliminated.
//!
//! The elements are cut in two again and again (nested dissection: George, SIAM J. Numer. Anal. 10, 1973). Elements carry
//! integer cells (column, row, layer), and cuts along whole columns, rows or layers share few nodes. From the smallest parts
//! upwards the unknowns that a part does not share with others are eliminated in a dense matrix, its front (multifrontal
//! method: Duff, Reid, ACM Trans. Math. Software 9, 1983).
//!
//! Loads F, and functionals of the displacement, are further rows and columns of the stiffness K. With the sides s of the
//! sector kept, its inside i eliminated,
//!
//! ```text
//! [ K    F ]         [ S     g      ]    S stiffness of the sides, g forces of the loads on the held sides,
//! [ F^T  0 ]  gives  [ g^T  -C_held ] ,  C_held displacement along the loads with the sides held.
//! ```
//!
//! No factor is kept: no backward solution is needed.

use super::dense::eliminate;
use super::error::FiniteElementError;
use super::mesh::{LoadColumn, Mesh};
use nalgebra::DMatrix;
use std::ops::Range;
use std::sync::{Mutex, PoisonError};

pub(super) struct CondensedSector {
    /// Stiffness of both sides, side 0 first, N/m; lower triangle valid.
    pub sides: DMatrix<f64>,
    /// Forces on the held sides from each unit load column; as many rows as `sides`.
    pub side_loads: DMatrix<f64>,
    /// Displacements along the columns with the sides held, m/N: by loads, or functionals by loads where there are any.
    pub held_influence: DMatrix<f64>,
    /// Numbers kept at most at a time.
    pub numbers: usize,
    /// How fast displacements of each unknown of a side fade with the order of a harmonic ([`fading`]).
    pub fading: Vec<f64>,
}

/// Parts of at most so many elements are not cut further.
const LEAF: usize = 4;
/// Parts of less than this share of all the work are eliminated next to others.
const SHARE_OF_A_THREAD: f64 = 0.1;
/// Multiplications below which a part is not worth a task of its own.
const TASK: f64 = 1e8;

/// Eliminates the inside of the sector `mesh` under the first `loads` of `columns`; the others are functionals that are observed
/// under them. `progress` is given the share done and may stop the work.
pub(super) fn condense(
    mesh: &Mesh,
    columns: &[LoadColumn],
    loads: usize,
    progress: &(dyn Fn(f64) -> bool + Sync),
) -> Result<CondensedSector, FiniteElementError> {
    let d = mesh.dimension;
    let mut work = Condensation {
        mesh,
        cells: cells(mesh),
        places: vec![NONE; mesh.points.len()],
        entries: Vec::new(),
        functionals: 0,
        work: 0.0,
        progress,
        done: Mutex::new(0.0),
    };
    let inside = inside(mesh);
    let count = inside.len();
    let part = work.cut((0..mesh.cells.len()).collect(), inside, 0);
    let sides: Vec<usize> = mesh.sides.iter().flatten().copied().collect();
    let own = d * count..d * (count + sides.len());
    work.place(sides, count);
    for (j, column) in columns.iter().enumerate() {
        for (unknown, value) in column {
            let place = work.places[unknown / d];
            if place != NONE {
                let entry = (d * place + unknown % d, own.end + j, *value);
                work.entries.push(entry);
            }
        }
    }
    (work.entries).sort_by_key(|(unknown, column, _)| (*unknown, *column));
    work.functionals = own.end + loads;
    let mut root = Part {
        inner: vec![part],
        own: own.clone(),
        ..Part::default()
    };
    work.count(&mut root);
    work.work = root.inner[0].work;
    root.kept = (own.end..own.end + columns.len()).collect();
    root.symmetric = loads;
    let numbers = root.numbers.max((own.len() + columns.len()).pow(2));
    check_memory(size_of::<f64>() * numbers)?;

    let front = work.assembled(&root)?;
    let side_loads = front.columns.rows_range(own.len()..).transpose();
    let mut held_influence = -front.rest;
    if loads < columns.len() {
        held_influence = held_influence.remove_rows(0, loads);
    } else {
        held_influence.fill_upper_triangle_with_lower_triangle();
    }
    Ok(CondensedSector {
        sides: front.columns.resize_vertically(own.len(), 0.0),
        side_loads,
        held_influence,
        numbers,
        fading: fading(mesh),
    })
}

/// For each unknown of a side a rate c: in a harmonic of the order n loads on the teeth move it by about e^{-c (n - 1)} of what they move the
/// root. Towards the axis (of a ring away from it) displacements of a disc go as r^{n - 1}, and along a cylinder of the radius R
/// beyond the face they fade faster than e^{-(n - 1) z / R}.
fn fading(mesh: &Mesh) -> Vec<f64> {
    let places = mesh.fillet.iter().map(|node| mesh.radius_and_z(*node));
    let Some([root, _]) = places.clone().next() else {
        return vec![0.0; mesh.dimension * mesh.sides[0].len()];
    };
    let [low, high] = places.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], [_, z]| {
        [low.min(z), high.max(z)]
    });
    let mut rates = Vec::new();
    for node in &mesh.sides[0] {
        let [radius, z] = mesh.radius_and_z(*node);
        let beyond = (low - z).max(z - high).max(0.0);
        let rate = (root / radius).ln().abs() + beyond / root;
        rates.extend(vec![rate; mesh.dimension]);
    }
    rates
}

/// Elements that are taken together, and their unknowns, numbered in the order of elimination: the inside, the sides of the
/// sector, then the columns.
#[derive(Default)]
struct Part {
    elements: Vec<usize>,
    inner: Vec<Part>,
    /// Unknowns that are eliminated with this part.
    own: Range<usize>,
    /// Unknowns that it shares with others, and columns that act in it; ascending.
    kept: Vec<usize>,
    /// How many of `kept` are no functionals.
    symmetric: usize,
    /// Multiplications for the part and its inner ones.
    work: f64,
    numbers: usize,
}

impl Part {
    fn row(&self, number: usize) -> usize {
        if number < self.own.end {
            return number - self.own.start;
        }
        self.own.len() + self.kept.partition_point(|kept| *kept < number)
    }

    fn left(&self) -> usize {
        self.kept.len() * self.symmetric
    }
}

/// Place of a held node.
const NONE: usize = usize::MAX;

/// Lowest and highest cell of the elements of each node, by axis.
fn cells(mesh: &Mesh) -> Vec<[[i32; 2]; 3]> {
    let mut cells = vec![[[i32::MAX, i32::MIN]; 3]; mesh.points.len()];
    for (nodes, cell) in mesh.elements.iter().zip(&mesh.cells) {
        for node in nodes {
            for ([low, high], cell) in cells[*node].iter_mut().zip(cell) {
                (*low, *high) = (*cell.min(low), *cell.max(high));
            }
        }
    }
    cells
}

/// The free nodes without those of the sides.
fn inside(mesh: &Mesh) -> Vec<usize> {
    let mut apart = mesh.held.clone();
    (mesh.sides.iter().flatten()).for_each(|node| apart[*node] = true);
    (0..apart.len()).filter(|node| !apart[*node]).collect()
}

struct Condensation<'a> {
    mesh: &'a Mesh,
    cells: Vec<[[i32; 2]; 3]>,
    /// Place of each node in the order of elimination.
    places: Vec<usize>,
    /// (unknown, column, value) of all loads and functionals, ascending.
    entries: Vec<(usize, usize, f64)>,
    /// Number of the first functional.
    functionals: usize,
    work: f64,
    progress: &'a (dyn Fn(f64) -> bool + Sync),
    done: Mutex<f64>,
}

/// The dense matrix of a part, lower triangle: the columns of its own unknowns, and the others without functionals.
struct Front {
    columns: DMatrix<f64>,
    rest: DMatrix<f64>,
}

impl Condensation<'_> {
    /// Gives the `nodes` that `elements` alone know their places from `first` on.
    fn cut(&mut self, elements: Vec<usize>, nodes: Vec<usize>, first: usize) -> Part {
        let d = self.mesh.dimension;
        let end = first + nodes.len();
        let Some((axis, limit)) = self.best_cut(&elements, &nodes) else {
            self.place(nodes, first);
            return Part {
                elements,
                own: d * first..d * end,
                ..Part::default()
            };
        };
        let (below, rest): (Vec<usize>, Vec<usize>) =
            (nodes.into_iter()).partition(|node| self.cells[*node][axis][1] < limit);
        let (above, between): (Vec<usize>, Vec<usize>) =
            (rest.into_iter()).partition(|node| limit <= self.cells[*node][axis][0]);
        let (low, high): (Vec<usize>, Vec<usize>) =
            (elements.into_iter()).partition(|element| self.mesh.cells[*element][axis] < limit);
        let (second, begin) = (first + below.len(), end - between.len());
        self.place(between, begin);
        Part {
            inner: vec![self.cut(low, below, first), self.cut(high, above, second)],
            own: d * begin..d * end,
            ..Part::default()
        }
    }

    fn place(&mut self, nodes: Vec<usize>, first: usize) {
        for (place, node) in (first..).zip(nodes) {
            self.places[node] = place;
        }
    }

    /// Axis and first cell above the cut with the fewest `nodes` between the halves, of those that leave at least 30 % of
    /// `elements` on either side; None if there are too few elements.
    fn best_cut(&self, elements: &[usize], nodes: &[usize]) -> Option<(usize, i32)> {
        if elements.len() <= LEAF {
            return None;
        }
        let mut best: Option<(f64, usize, i32)> = None;
        for axis in 0..3 {
            let mut cells: Vec<i32> = elements.iter().map(|e| self.mesh.cells[*e][axis]).collect();
            cells.sort_unstable();
            for limit in cells.chunk_by(|a, b| a == b).map(|same| same[0]) {
                let share = cells.partition_point(|cell| *cell < limit) as f64 / cells.len() as f64;
                if !(0.3..=0.7).contains(&share) {
                    continue;
                }
                let cells = nodes.iter().map(|node| self.cells[*node][axis]);
                let between = cells.filter(|[low, high]| *low < limit && limit <= *high);
                let cost = between.count() as f64 * (1.0 + (share - 0.5).powi(2) * 4.0);
                if best.is_none_or(|(least, ..)| cost < least) {
                    best = Some((cost, axis, limit));
                }
            }
        }
        best.map(|(_, axis, limit)| (axis, limit))
    }

    fn unknowns(&self, nodes: &[usize]) -> impl Iterator<Item = Option<usize>> {
        let d = self.mesh.dimension;
        let places = nodes.iter().map(|node| self.places[*node]);
        places.flat_map(move |place| (0..d).map(move |i| (place != NONE).then(|| d * place + i)))
    }

    fn entries(&self, part: &Part) -> &[(usize, usize, f64)] {
        let [start, end] = [part.own.start, part.own.end]
            .map(|own| (self.entries).partition_point(|(unknown, ..)| *unknown < own));
        &self.entries[start..end]
    }

    fn count(&self, part: &mut Part) {
        part.inner.iter_mut().for_each(|inner| self.count(inner));
        let elements = part.elements.iter();
        let nodes = elements.flat_map(|element| &self.mesh.elements[*element]);
        let nodes: Vec<usize> = nodes.copied().collect();
        let columns = self.entries(part).iter().map(|(_, column, _)| *column);
        let inner = part.inner.iter().flat_map(|inner| &inner.kept).copied();
        let all = self.unknowns(&nodes).flatten().chain(columns).chain(inner);
        let mut kept: Vec<usize> = all.filter(|number| *number >= part.own.end).collect();
        kept.sort_unstable();
        kept.dedup();
        part.symmetric = kept.partition_point(|number| *number < self.functionals);
        part.kept = kept;
        let [own, kept] = [part.own.len(), part.kept.len()].map(|n| n as f64);
        part.work = own * own * own / 6.0 + 0.5 * own * kept * (own + kept);
        let mut left = 0;
        for inner in &part.inner {
            part.work += inner.work;
            part.numbers = part.numbers.max(left + inner.numbers);
            left += inner.left();
        }
        let front = part.left() + part.own.len() * (part.own.len() + part.kept.len());
        part.numbers = part.numbers.max(left + front);
    }

    /// What `part` leaves to those around it: the lower triangle of its kept rows, without the columns of functionals.
    fn eliminated(&self, part: &Part) -> Result<DMatrix<f64>, FiniteElementError> {
        let mut front = self.assembled(part)?;
        eliminate::<1>(&mut front.columns, &mut front.rest)?;
        let inner: f64 = part.inner.iter().map(|inner| inner.work).sum();
        let mut done = self.done.lock().unwrap_or_else(PoisonError::into_inner);
        *done += part.work - inner;
        let goes_on = (self.progress)(*done / self.work);
        let left = goes_on.then_some(front.rest);
        left.ok_or(FiniteElementError::Cancelled)
    }

    fn assembled(&self, part: &Part) -> Result<Front, FiniteElementError> {
        let small = SHARE_OF_A_THREAD * self.work;
        let left: Vec<DMatrix<f64>> = match &part.inner[..] {
            [first, second] if part.work > TASK && first.work < small && second.work < small => {
                let both = rayon::join(|| self.eliminated(first), || self.eliminated(second));
                vec![both.0?, both.1?]
            }
            inner => {
                (inner.iter().map(|inner| self.eliminated(inner))).collect::<Result<_, _>>()?
            }
        };
        let (own, kept) = (part.own.len(), part.kept.len());
        let mut front = Front {
            columns: DMatrix::zeros(own + kept, own),
            rest: DMatrix::zeros(kept, part.symmetric),
        };
        for (inner, left) in part.inner.iter().zip(left) {
            let rows = inner.kept.iter().map(|number| part.row(*number));
            front.add(&rows.zip(0..).collect::<Vec<_>>(), &left);
        }
        for element in &part.elements {
            let nodes = &self.mesh.elements[*element];
            let stiffness = self.mesh.stiffness(nodes);
            let numbers = self.unknowns(nodes).zip(0..);
            let mut rows: Vec<(usize, usize)> = numbers
                .filter_map(|(number, at)| Some((part.row(number?), at)))
                .collect();
            rows.sort_unstable();
            front.add(&rows, &stiffness);
        }
        for (unknown, column, value) in self.entries(part) {
            front.columns[(part.row(*column), unknown - part.own.start)] += value;
        }
        Ok(front)
    }
}

impl Front {
    /// Adds the lower triangle of `matrix`; `rows` are its rows here, ascending, and there.
    fn add(&mut self, rows: &[(usize, usize)], matrix: &DMatrix<f64>) {
        let own = self.columns.ncols();
        for (at, (column, j)) in rows.iter().enumerate() {
            if *j >= matrix.ncols() {
                continue;
            }
            let (mut into, above) = match column.checked_sub(own) {
                None => (self.columns.column_mut(*column), 0),
                Some(column) => (self.rest.column_mut(column), own),
            };
            let from = matrix.column(*j);
            for (row, i) in &rows[at..] {
                into[row - above] += from[*i];
            }
        }
    }
}

/// Refuses work that takes `bytes` where the system says that it has less left: one that grants more ends the program later.
fn check_memory(bytes: usize) -> Result<(), FiniteElementError> {
    let state = std::fs::read_to_string("/proc/meminfo").unwrap_or_default();
    match available(&state) {
        Some(available) if bytes > available => Err(FiniteElementError::Memory {
            needed_gb: 1e-9 * bytes as f64,
            available_gb: 1e-9 * available as f64,
        }),
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
        let mut order = inside(&mesh);
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
        let all = condense(&mesh, &columns, columns.len(), &|_| true).unwrap();
        near(&all.sides.lower_triangle(), &sides.lower_triangle());
        near(&all.side_loads, &side_loads);
        near(&all.held_influence, &held);
        let observed = condense(&mesh, &columns, 2, &|_| true).unwrap();
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
        check_memory(1 << 20).unwrap();
        let error = check_memory(1 << 60).unwrap_err().to_string();
        assert!(error.contains("1152921504.6 GB"), "{error}");
    }
}
