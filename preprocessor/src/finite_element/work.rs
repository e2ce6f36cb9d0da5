//! The work of loads on the flanks of a gear on each other's displacements.

use std::ops::Range;

use nalgebra::DMatrix;

use super::flank::Weights;
use super::influence::Influence;
use super::uneven::BodyChange;

/// Forces on the nodes of the flank of one tooth; a node may come more than once.
pub(super) struct FlankLoad {
    pub tooth: i32,
    pub weights: Weights,
}

/// What each of `rows` works on the displacements by those `columns` that are `wanted` of it; zero for the others.
pub(super) fn work_between(
    influence: &Influence,
    body: Option<&BodyChange>,
    [rows, columns]: [&[FlankLoad]; 2],
    wanted: &[Range<usize>],
) -> DMatrix<f64> {
    let mut work = DMatrix::zeros(rows.len(), columns.len());
    let mut teeth: Vec<i32> = rows.iter().map(|load| load.tooth).collect();
    teeth.sort_unstable();
    teeth.dedup();
    for tooth in &teeth {
        for other in &teeth {
            let [mut observed, mut loads] =
                [(rows, tooth), (columns, other)].map(|(all, tooth)| {
                    let of_tooth = (0..all.len()).filter(|i| all[*i].tooth == *tooth);
                    of_tooth.collect::<Vec<_>>()
                });
            observed.retain(|i| loads.iter().any(|j| wanted[*i].contains(j)));
            loads.retain(|j| observed.iter().any(|i| wanted[*i].contains(j)));
            if loads.is_empty() {
                continue;
            }
            let [of_rows, of_columns] = [(rows, &observed), (columns, &loads)]
                .map(|(all, some)| some.iter().map(|i| &all[*i].weights).collect::<Vec<_>>());
            // The model holds displacements of the loaded tooth and of those after it.
            let offset = tooth.abs_diff(*other) as usize;
            let found = match tooth >= other {
                true => influence
                    .displacements(offset, &of_columns, &of_rows)
                    .transpose(),
                false => influence.displacements(offset, &of_rows, &of_columns),
            };
            for (row, i) in observed.iter().enumerate() {
                for (column, j) in loads.iter().enumerate() {
                    if wanted[*i].contains(j) {
                        work[(*i, *j)] = found[(row, column)];
                    }
                }
            }
        }
    }
    if let Some(body) = body {
        let [of_rows, of_columns] = [rows, columns].map(|loads| {
            let loads = loads.iter().map(|load| (load.tooth, &load.weights));
            body.coordinates(loads)
        });
        let change = body.work(&of_rows, &of_columns);
        for (i, columns) in wanted.iter().enumerate() {
            for j in columns.clone() {
                work[(i, j)] += change[(i, j)];
            }
        }
    }
    work
}
