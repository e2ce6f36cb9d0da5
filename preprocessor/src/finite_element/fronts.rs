//! Elimination of unknowns of many elements, part by part.
//!
//! The elements are cut in two again and again (nested dissection: George, SIAM J. Numer. Anal. 10, 1973). Elements carry
//! integer cells (column, row, layer), and cuts along whole columns, rows or layers share few nodes. From the smallest parts
//! upwards the unknowns that a part does not share with others are eliminated in a dense matrix, its front (multifrontal
//! method: Duff, Reid, ACM Trans. Math. Software 9, 1983). No factor is kept: no backward solution is needed.

use super::dense::eliminate;
use super::error::FiniteElementError;
use super::mesh::{LoadColumn, Mesh};
use nalgebra::DMatrix;
use std::ops::Range;
use std::sync::{Mutex, PoisonError};

/// Parts of at most so many elements are not cut further.
const LEAF: usize = 4;
/// Parts of less than this share of all the work are eliminated next to others.
const SHARE_OF_A_THREAD: f64 = 0.1;
/// Multiplications below which a part is not worth a task of its own.
const TASK: f64 = 1e8;

/// Elements that are taken together, and their unknowns, numbered in the order of elimination: the inside, the sides of the
/// sector, then the columns.
#[derive(Default)]
pub(super) struct Part {
    elements: Vec<usize>,
    inner: Vec<Part>,
    /// Unknowns that are eliminated with this part.
    pub own: Range<usize>,
    /// Unknowns that it shares with others, and columns that act in it; ascending.
    kept: Vec<usize>,
    /// How many of `kept` are no functionals.
    symmetric: usize,
    /// Multiplications for the part and its inner ones.
    work: f64,
    /// Numbers kept at most at a time.
    pub numbers: usize,
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

/// Place of a node that is not moved.
const NONE: usize = usize::MAX;

/// Lowest and highest cell of the elements of each of so many nodes, by axis.
fn cells_of_nodes(count: usize, nodes: &[Vec<usize>], cells: &[[i32; 3]]) -> Vec<[[i32; 2]; 3]> {
    let mut of_nodes = vec![[[i32::MAX, i32::MIN]; 3]; count];
    for (nodes, cell) in nodes.iter().zip(cells) {
        for node in nodes {
            for ([low, high], cell) in of_nodes[*node].iter_mut().zip(cell) {
                (*low, *high) = (*cell.min(low), *cell.max(high));
            }
        }
    }
    of_nodes
}

/// The order in which elements are taken together and unknowns eliminated.
pub(super) struct Fronts {
    pub dimension: usize,
    /// The nodes that move each element.
    nodes: Vec<Vec<usize>>,
    /// Place of each node in the order of elimination.
    places: Vec<usize>,
    /// (unknown, column, value) of all loads and functionals, ascending.
    entries: Vec<(usize, usize, f64)>,
    /// Number of the first functional.
    functionals: usize,
    /// All elements, with what is kept as its own unknowns.
    pub root: Part,
}

impl Fronts {
    /// For elements of `mesh` in `cells` that `nodes` move: the nodes `inside` are eliminated, those `kept` are not. All but the first `loads` of
    /// `columns` are functionals.
    pub fn new(
        mesh: &Mesh,
        nodes: Vec<Vec<usize>>,
        cells: &[[i32; 3]],
        [inside, kept]: [Vec<usize>; 2],
        columns: &[LoadColumn],
        loads: usize,
    ) -> Fronts {
        let d = mesh.dimension;
        let count = inside.len();
        let own = d * count..d * (count + kept.len());
        let mut dissection = Dissection {
            dimension: d,
            of_nodes: cells_of_nodes(mesh.points.len(), &nodes, cells),
            cells,
            places: vec![NONE; mesh.points.len()],
        };
        let part = dissection.part((0..cells.len()).collect(), inside, 0);
        dissection.place(kept, count);
        let places = dissection.places;
        let mut entries = Vec::new();
        for (j, column) in columns.iter().enumerate() {
            for (unknown, value) in column {
                let place = places[unknown / d];
                if place != NONE {
                    entries.push((d * place + unknown % d, own.end + j, *value));
                }
            }
        }
        entries.sort_by_key(|(unknown, column, _)| (*unknown, *column));
        let mut fronts = Fronts {
            dimension: d,
            nodes,
            places,
            entries,
            functionals: own.end + loads,
            root: Part::default(),
        };
        let mut root = Part {
            inner: vec![part],
            own: own.clone(),
            ..Part::default()
        };
        fronts.count(&mut root);
        root.work = root.inner[0].work;
        root.kept = (own.end..own.end + columns.len()).collect();
        root.symmetric = loads;
        fronts.root = root;
        fronts
    }

    fn unknowns(&self, nodes: &[usize]) -> impl Iterator<Item = Option<usize>> {
        let d = self.dimension;
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
        let nodes = elements.flat_map(|element| &self.nodes[*element]);
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
}

/// Cuts elements in two again and again.
struct Dissection<'a> {
    dimension: usize,
    /// Of the elements: (column, row, layer).
    cells: &'a [[i32; 3]],
    of_nodes: Vec<[[i32; 2]; 3]>,
    places: Vec<usize>,
}

impl Dissection<'_> {
    /// Gives the `nodes` that `elements` alone know their places from `first` on.
    fn part(&mut self, elements: Vec<usize>, nodes: Vec<usize>, first: usize) -> Part {
        let d = self.dimension;
        let end = first + nodes.len();
        let Some((axis, limit)) = self.best(&elements, &nodes) else {
            self.place(nodes, first);
            return Part {
                elements,
                own: d * first..d * end,
                ..Part::default()
            };
        };
        let (below, rest): (Vec<usize>, Vec<usize>) =
            (nodes.into_iter()).partition(|node| self.of_nodes[*node][axis][1] < limit);
        let (above, between): (Vec<usize>, Vec<usize>) =
            (rest.into_iter()).partition(|node| limit <= self.of_nodes[*node][axis][0]);
        let (low, high): (Vec<usize>, Vec<usize>) =
            (elements.into_iter()).partition(|element| self.cells[*element][axis] < limit);
        let (second, begin) = (first + below.len(), end - between.len());
        self.place(between, begin);
        Part {
            inner: vec![self.part(low, below, first), self.part(high, above, second)],
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
    fn best(&self, elements: &[usize], nodes: &[usize]) -> Option<(usize, i32)> {
        if elements.len() <= LEAF {
            return None;
        }
        let mut best: Option<(f64, usize, i32)> = None;
        for axis in 0..3 {
            let mut cells: Vec<i32> = elements.iter().map(|e| self.cells[*e][axis]).collect();
            cells.sort_unstable();
            for limit in cells.chunk_by(|a, b| a == b).map(|same| same[0]) {
                let share = cells.partition_point(|cell| *cell < limit) as f64 / cells.len() as f64;
                if !(0.3..=0.7).contains(&share) {
                    continue;
                }
                let cells = nodes.iter().map(|node| self.of_nodes[*node][axis]);
                let between = cells.filter(|[low, high]| *low < limit && limit <= *high);
                let cost = between.count() as f64 * (1.0 + (share - 0.5).powi(2) * 4.0);
                if best.is_none_or(|(least, ..)| cost < least) {
                    best = Some((cost, axis, limit));
                }
            }
        }
        best.map(|(_, axis, limit)| (axis, limit))
    }
}

/// The dense matrix of a part, lower triangle: the columns of its own unknowns, and the others without functionals. As in
/// [`eliminate`], each column is `W` columns.
pub(super) struct Front<const W: usize> {
    pub columns: DMatrix<f64>,
    pub rest: DMatrix<f64>,
}

/// An elimination in the order of its fronts, of real matrices (`W` = 1) or Hermitian ones (2).
pub(super) struct Elimination<'a, const W: usize> {
    fronts: &'a Fronts,
    /// Of an element, by the nodes that move it.
    stiffness: &'a (dyn Fn(usize) -> DMatrix<f64> + Sync),
    progress: &'a (dyn Fn(f64) -> bool + Sync),
    done: Mutex<f64>,
}

impl<'a, const W: usize> Elimination<'a, W> {
    /// Of elements of this `stiffness`, each by the nodes that move it; columns as in [`eliminate`]. `progress` is given the share done and may stop the work.
    pub fn new(
        fronts: &'a Fronts,
        stiffness: &'a (dyn Fn(usize) -> DMatrix<f64> + Sync),
        progress: &'a (dyn Fn(f64) -> bool + Sync),
    ) -> Self {
        Elimination {
            fronts,
            stiffness,
            progress,
            done: Mutex::new(0.0),
        }
    }

    /// What `part` leaves to those around it: the lower triangle of its kept rows, without the columns of functionals.
    fn eliminated(&self, part: &Part) -> Result<DMatrix<f64>, FiniteElementError> {
        let mut front = self.assembled(part)?;
        eliminate::<W>(&mut front.columns, &mut front.rest)?;
        let inner: f64 = part.inner.iter().map(|inner| inner.work).sum();
        let mut done = self.done.lock().unwrap_or_else(PoisonError::into_inner);
        *done += part.work - inner;
        let goes_on = (self.progress)(*done / self.fronts.root.work);
        let left = goes_on.then_some(front.rest);
        left.ok_or(FiniteElementError::Cancelled)
    }

    /// The matrix of `part` after elimination of its inner ones: of the root what is left when the inside is eliminated.
    pub fn assembled(&self, part: &Part) -> Result<Front<W>, FiniteElementError> {
        let fronts = self.fronts;
        let small = SHARE_OF_A_THREAD * fronts.root.work;
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
        let mut front = Front::<W> {
            columns: DMatrix::zeros(own + kept, W * own),
            rest: DMatrix::zeros(kept, W * part.symmetric),
        };
        for (inner, left) in part.inner.iter().zip(left) {
            let rows = inner.kept.iter().map(|number| part.row(*number));
            front.add(&rows.zip(0..).collect::<Vec<_>>(), &left);
        }
        for element in &part.elements {
            let numbers = fronts.unknowns(&fronts.nodes[*element]).zip(0..);
            let mut rows: Vec<(usize, usize)> = numbers
                .filter_map(|(number, at)| Some((part.row(number?), at)))
                .collect();
            rows.sort_unstable();
            front.add(&rows, &(self.stiffness)(*element));
        }
        for (unknown, column, value) in fronts.entries(part) {
            front.columns[(part.row(*column), W * (unknown - part.own.start))] += value;
        }
        Ok(front)
    }
}

impl<const W: usize> Front<W> {
    /// Adds the lower triangle of `matrix`; `rows` are its rows here, ascending, and there.
    fn add(&mut self, rows: &[(usize, usize)], matrix: &DMatrix<f64>) {
        let own = self.columns.ncols() / W;
        // Rows that follow on each other in both.
        let runs = rows.chunk_by(|a, b| (a.0 + 1, a.1 + 1) == (b.0, b.1));
        let runs: Vec<_> = runs.collect();
        for (number, run) in runs.iter().enumerate() {
            for (at, (column, j)) in run.iter().enumerate() {
                if W * *j >= matrix.ncols() {
                    continue;
                }
                for part in 0..W {
                    let (matrix_of, column, above) = match column.checked_sub(own) {
                        None => (&mut self.columns, *column, 0),
                        Some(column) => (&mut self.rest, column, own),
                    };
                    let height = matrix_of.nrows();
                    let into =
                        &mut matrix_of.as_mut_slice()[(W * column + part) * height..][..height];
                    let from =
                        &matrix.as_slice()[(W * j + part) * matrix.nrows()..][..matrix.nrows()];
                    for rows in
                        std::iter::once(&run[at..]).chain(runs[number + 1..].iter().copied())
                    {
                        let (row, i) = rows[0];
                        let into = into[row - above..].iter_mut().zip(&from[i..]);
                        into.take(rows.len()).for_each(|(into, from)| *into += from);
                    }
                }
            }
        }
    }
}
