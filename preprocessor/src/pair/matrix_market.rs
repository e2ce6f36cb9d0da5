//! Matrices in the exchange format of the Matrix Market (Boisvert, Pozo, Remington, NISTIR 5935, 1996).

use nalgebra::DMatrix;

/// The matrix in `text`, of at most `most` rows and columns.
///
/// # Errors
/// What is wrong with the text, to go on with after its name.
pub fn read(text: &str, most: usize) -> Result<DMatrix<f64>, String> {
    let head = text.lines().next().unwrap_or("").to_lowercase();
    let words: Vec<&str> = head.split_whitespace().collect();
    let &[
        "%%matrixmarket",
        "matrix",
        form,
        "real" | "integer" | "double",
        kind,
    ] = &words[..]
    else {
        return Err(format!(
            "begins with `{}`",
            head.chars().take(60).collect::<String>()
        ));
    };
    let (is_dense, is_symmetric) = match (form, kind) {
        ("array" | "coordinate", "general" | "symmetric") => (form == "array", kind == "symmetric"),
        _ => return Err(format!("is `{form} {kind}`")),
    };
    let lines = text.lines().enumerate().skip(1);
    let mut lines = lines.filter(|(_, line)| !line.starts_with('%') && !line.trim().is_empty());
    let size = numbers(
        lines.next().ok_or("has no size")?,
        if is_dense { 2 } else { 3 },
    )?;
    let [rows, columns] = [count(size[0])?, count(size[1])?];
    if rows.max(columns) > most {
        return Err(format!("has {rows} rows and {columns} columns"));
    }
    let mut matrix = DMatrix::zeros(rows, columns);
    let mut set = |i: usize, j: usize, value: f64| {
        matrix[(i, j)] += value;
        if is_symmetric && i != j {
            matrix[(j, i)] += value;
        }
    };
    if is_dense {
        for j in 0..columns {
            for i in if is_symmetric { j } else { 0 }..rows {
                set(i, j, numbers(lines.next().ok_or(TOO_SHORT)?, 1)?[0]);
            }
        }
    } else {
        for _ in 0..count(size[2])? {
            let entry = numbers(lines.next().ok_or(TOO_SHORT)?, 3)?;
            let [i, j] = [count(entry[0])?, count(entry[1])?];
            if !(1..=rows).contains(&i) || !(1..=columns).contains(&j) {
                return Err(format!("has an entry at row {i}, column {j}"));
            }
            if is_symmetric && j > i {
                return Err(format!(
                    "has an entry at row {i}, column {j}, above the diagonal of a `symmetric` matrix"
                ));
            }
            set(i - 1, j - 1, entry[2]);
        }
    }
    match lines.next() {
        None => Ok(matrix),
        Some(_) => Err("goes on after its last number".into()),
    }
}

const TOO_SHORT: &str = "ends too early";

/// A number of rows, columns or entries.
fn count(number: f64) -> Result<usize, String> {
    let is_whole = number >= 0.0 && number.fract() == 0.0;
    let whole = is_whole.then_some(number as usize);
    whole.ok_or_else(|| format!("has {number} where a whole number belongs"))
}

/// The `count` numbers in a `line` that stands at `place` in the text.
fn numbers((place, line): (usize, &str), count: usize) -> Result<Vec<f64>, String> {
    let found: Result<Vec<f64>, _> = line.split_whitespace().map(str::parse).collect();
    let found = found
        .ok()
        .filter(|found| found.len() == count && found.iter().all(|x| x.is_finite()));
    found.ok_or_else(|| {
        format!(
            "has `{}` in line {}, where {count} numbers belong",
            line.chars().take(60).collect::<String>(),
            place + 1
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_that_are_no_matrix_are_refused() {
        for (text, words) in [
            ("", "begins with ``"),
            (
                "%%MatrixMarket matrix coordinate complex general\n1 1 0",
                "begins with",
            ),
            (
                "%%MatrixMarket matrix coordinate real skew-symmetric\n1 1 0",
                "is `coordinate skew-symmetric`",
            ),
            ("%%MatrixMarket matrix array real general\n", "has no size"),
            (
                "%%MatrixMarket matrix array real general\n1 2\n3\n",
                "ends too early",
            ),
            (
                "%%MatrixMarket matrix array real general\n1 1\n3\n4\n",
                "goes on",
            ),
            (
                "%%MatrixMarket matrix array real general\n1 1\nNaN\n",
                "has `NaN` in line 3",
            ),
            (
                "%%MatrixMarket matrix coordinate real general\n1 1 1\n2 1 5\n",
                "an entry at row 2",
            ),
            (
                "%%MatrixMarket matrix coordinate real general\n1 1 1\n1 rubbish 1 5\n",
                "has `1 rubbish 1 5` in line 3",
            ),
            (
                "%%MatrixMarket matrix coordinate real general\n2 2 1\n1.9 1 5\n",
                "has 1.9 where a whole number belongs",
            ),
            (
                "%%MatrixMarket matrix coordinate real symmetric\n2 2 1\n1 2 5\n",
                "row 1, column 2, above the diagonal",
            ),
            (
                "%%MatrixMarket matrix coordinate real general\n1e9 1e9 1\n2 1 5\n",
                "has 1000000000 rows",
            ),
        ] {
            let found = read(text, 6000).unwrap_err();
            assert!(found.contains(words), "{text}: {found}");
        }
        let text = "%%MatrixMarket matrix array real symmetric\n2 2\n1\n2\n3\n";
        let dense = read(text, 2).unwrap();
        assert_eq!(dense, DMatrix::from_row_slice(2, 2, &[1.0, 2.0, 2.0, 3.0]));
    }
}
