//! Quantities of the rows of a result: one description for a CSV file and a table of text.

use std::fmt::Write;

use gearmesh::words::{fixed, rounded};

/// A quantity of the rows `T`; nothing where a row has none.
pub struct Column<'a, T> {
    /// With its unit, as CSV files have it.
    pub name: String,
    value: Value<'a, T>,
    text: Option<Text>,
}

type Value<'a, T> = Box<dyn Fn(&T) -> Option<f64> + 'a>;

/// How a column stands in text.
struct Text {
    head: String,
    unit: &'static str,
    width: usize,
    /// Decimals; none: as many as the value has.
    digits: Option<usize>,
}

/// A quantity that every row has.
pub fn column<'a, T>(name: impl Into<String>, value: impl Fn(&T) -> f64 + 'a) -> Column<'a, T> {
    maybe(name, move |row| Some(value(row)))
}

/// A quantity that some rows have.
pub fn maybe<'a, T>(
    name: impl Into<String>,
    value: impl Fn(&T) -> Option<f64> + 'a,
) -> Column<'a, T> {
    Column {
        name: name.into(),
        value: Box::new(value),
        text: None,
    }
}

impl<T> Column<'_, T> {
    /// Shown in text, too, below `head` and `unit`.
    pub fn shown(
        mut self,
        head: impl Into<String>,
        unit: &'static str,
        width: usize,
        digits: Option<usize>,
    ) -> Self {
        let head = head.into();
        self.text = Some(Text {
            head,
            unit,
            width,
            digits,
        });
        self
    }

    /// The value of `row` for a CSV file, empty where there is none.
    pub fn field(&self, row: &T) -> String {
        (self.value)(row).map_or(String::new(), |value| value.to_string())
    }
}

/// The columns that are shown in text, below their heads and units.
pub fn table<T>(columns: &[Column<T>], rows: impl IntoIterator<Item = T>) -> String {
    let mut text = String::new();
    let mut line = |cell: &dyn Fn(&Column<T>, &Text) -> String| {
        let shown = columns.iter().filter_map(|c| Some((c, c.text.as_ref()?)));
        let cells = shown.map(|(c, t)| format!("{:>1$}", cell(c, t), t.width));
        let _ = writeln!(text, "{}", cells.collect::<Vec<_>>().join(" "));
    };
    line(&|_, text| text.head.clone());
    line(&|_, text| text.unit.to_owned());
    for row in rows {
        line(&|column, text| match ((column.value)(&row), text.digits) {
            (None, _) => "-".into(),
            (Some(value), Some(digits)) => fixed(value, digits),
            (Some(value), None) => rounded(value).to_string(),
        });
    }
    text
}
