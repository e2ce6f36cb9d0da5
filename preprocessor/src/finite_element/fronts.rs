//! What is where when a sector is eliminated part by part (multifrontal method: Duff, Reid, ACM Trans. Math. Software
//! 9, 1983).
//!
//! A part of the tree of separators and all that it encloses is told apart from the rest by few unknowns around it. Its
//! front is the dense matrix of its own unknowns and those around, and the loads that act in it.

use super::assembly::LowerTriangle;
use super::condensation::LoadColumn;
use super::dissection::Part;
use std::ops::Range;

/// The fronts of all parts.
pub(super) struct Fronts {
    /// In the order of the parts.
    pub fronts: Vec<Front>,
    /// Rows of the load columns: (unknown, column, value), ascending.
    entries: Vec<(usize, usize, f64)>,
    /// Entries of the Cholesky factor of the inside.
    pub factor_entries: usize,
}

/// The front of one part.
pub(super) struct Front {
    /// First unknown of the part itself.
    pub start: usize,
    /// How many there are.
    pub own: usize,
    /// Unknowns around the part and what it encloses, ascending; all are eliminated later.
    pub around: Vec<usize>,
    /// Load columns that act in the part or what it encloses, ascending.
    pub loads: Vec<usize>,
    /// Parts that this one separates, the one that needs more memory first.
    pub separates: Vec<usize>,
    /// Multiplications for the part and what it encloses.
    pub work: f64,
    /// Numbers kept at most while the part and what it encloses are eliminated.
    pub numbers: usize,
}

impl Fronts {
    /// Of the matrix `a` that is eliminated by `parts` under the load `columns`.
    pub fn new(a: &LowerTriangle, parts: &[Part], columns: &[LoadColumn]) -> Fronts {
        let mut entries: Vec<(usize, usize, f64)> = (columns.iter().enumerate())
            .flat_map(|(j, column)| column.iter().map(move |(row, value)| (*row, j, *value)))
            .collect();
        entries.sort_unstable_by_key(|(row, column, _)| (*row, *column));
        let mut fronts: Vec<Front> = Vec::with_capacity(parts.len());
        for part in parts {
            let front = Front::new(a, part, &fronts, within(&entries, part.unknowns.clone()));
            fronts.push(front);
        }
        let of_front = |f: &Front| f.own * (f.own + 1) / 2 + f.own * f.around.len();
        Fronts {
            factor_entries: fronts.iter().map(of_front).sum(),
            fronts,
            entries,
        }
    }

    /// Multiplications in all.
    pub fn work(&self) -> f64 {
        self.roots()
            .iter()
            .map(|part| self.fronts[*part].work)
            .sum()
    }

    /// Numbers kept at most at a time.
    pub fn numbers(&self) -> usize {
        let roots = self.roots();
        roots.iter().map(|part| self.fronts[*part].numbers).sum()
    }

    /// The front of the unknowns up to `end` that are not eliminated, under all `columns`.
    pub fn last(&self, end: usize, columns: usize) -> Front {
        let roots = self.roots();
        let ends = roots.iter().map(|part| self.fronts[*part].end());
        let start = ends.max().unwrap_or(0);
        Front {
            start,
            own: end - start,
            around: Vec::new(),
            loads: (0..columns).collect(),
            separates: roots,
            work: self.work(),
            numbers: self.numbers(),
        }
    }

    /// What loads are on the own unknowns of `front`: (unknown, column, value).
    pub fn entries_of(&self, front: &Front) -> &[(usize, usize, f64)] {
        within(&self.entries, front.start..front.end())
    }

    /// Parts that no other one separates.
    fn roots(&self) -> Vec<usize> {
        let mut inner = vec![false; self.fronts.len()];
        for part in self.fronts.iter().flat_map(|f| &f.separates) {
            inner[*part] = true;
        }
        (0..inner.len()).filter(|part| !inner[*part]).collect()
    }
}

/// The `entries` on the `unknowns`.
fn within(entries: &[(usize, usize, f64)], unknowns: Range<usize>) -> &[(usize, usize, f64)] {
    let at = |unknown: usize| entries.partition_point(|(row, ..)| *row < unknown);
    &entries[at(unknowns.start)..at(unknowns.end)]
}

/// Where the entries of `some` stand in `all`; both ascending.
pub(super) fn positions(all: &[usize], some: &[usize]) -> Vec<usize> {
    let mut at = 0;
    let mut place = |entry: usize| {
        while all[at] < entry {
            at += 1;
        }
        at
    };
    some.iter().map(|entry| place(*entry)).collect()
}

impl Front {
    fn new(
        a: &LowerTriangle,
        part: &Part,
        before: &[Front],
        entries: &[(usize, usize, f64)],
    ) -> Front {
        let unknowns = part.unknowns.clone();
        let mut separates = part.separates.clone();
        separates.sort_by_key(|part| std::cmp::Reverse(before[*part].numbers));
        let enclosed = || separates.iter().map(|part| &before[*part]);
        let rows = &a.rows[a.column_starts[unknowns.start]..a.column_starts[unknowns.end]];
        let all = rows.iter().chain(enclosed().flat_map(|f| &f.around));
        let mut around: Vec<usize> = all.copied().filter(|row| *row >= unknowns.end).collect();
        around.sort_unstable();
        around.dedup();
        let own_loads = entries.iter().map(|(_, column, _)| *column);
        let mut loads: Vec<usize> = own_loads
            .chain(enclosed().flat_map(|f| f.loads.iter().copied()))
            .collect();
        loads.sort_unstable();
        loads.dedup();
        let own = unknowns.len();
        let [p, b, l] = [own, around.len(), loads.len()].map(|n| n as f64);
        let work = p * p * p / 6.0 + 0.5 * p * p * (b + l) + 0.5 * p * (b + l) * (b + l);
        let mut left = 0;
        let mut numbers = 0;
        for front in enclosed() {
            numbers = numbers.max(left + front.numbers);
            left += front.left();
        }
        let mut front = Front {
            start: unknowns.start,
            own,
            around,
            loads,
            work: work + enclosed().map(|f| f.work).sum::<f64>(),
            numbers: 0,
            separates: Vec::new(),
        };
        let whole = front.left() + own * (own + front.around.len() + front.loads.len());
        front.numbers = numbers.max(left + whole);
        front.separates = separates;
        front
    }

    /// Numbers that are left when the part is eliminated.
    fn left(&self) -> usize {
        (self.around.len() + self.loads.len()) * (self.around.len() + self.loads.len())
            - self.around.len() * self.loads.len()
    }

    /// How many of its load columns are among the first `columns`.
    pub fn split(&self, columns: usize) -> usize {
        self.loads.partition_point(|column| *column < columns)
    }

    fn end(&self) -> usize {
        self.start + self.own
    }

    /// Where the unknowns around `inner`, which this part separates, stand in this front: its own ones first.
    pub fn places(&self, inner: &Front) -> Vec<usize> {
        let split = inner.around.partition_point(|row| *row < self.end());
        let (own, around) = inner.around.split_at(split);
        let own = own.iter().map(|row| row - self.start);
        let around = positions(&self.around, around);
        own.chain(around.into_iter().map(|at| self.own + at))
            .collect()
    }
}
