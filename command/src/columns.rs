//! Quantities of the rows of a result: one description for CSV files, JSON, and tables and listings of text.

use gearmesh::words::{fixed, rounded, shown, shown_in_full};
use serde_json::{Map, Value};

use crate::error::Result;

/// A quantity of the rows `T`.
pub struct Column<'a, T> {
    /// With its unit, as CSV and JSON have it; empty where text alone has the quantity.
    pub name: String,
    /// Null where a row has none.
    pub value: Box<dyn Fn(&T) -> Value + Sync + 'a>,
    /// What text calls it; empty where text does not have it.
    pub head: String,
    pub unit: &'static str,
    /// Decimals in text; None: as many as the value has.
    digits: Option<usize>,
}

/// Columns of the rows of a type, `|row: &Type| "name" => value;` for each; between name and arrow
/// `[head, unit, decimals]` where text has it, too.
macro_rules! columns {
    (|$row:tt: $type:ty| $($name:expr $(, [$head:expr, $unit:expr, $digits:expr])? => $value:expr;)*) => {{
        // Not every value takes all that a row has.
        #[allow(unused_variables)]
        let columns = vec![
            $($crate::columns::Column::new($name, move |$row: $type| $value.into())$(.shown($head, $unit, $digits))?),*
        ];
        columns
    }};
}
pub(crate) use columns;

impl<'a, T> Column<'a, T> {
    pub fn new(name: impl Into<String>, value: impl Fn(&T) -> Value + Sync + 'a) -> Self {
        Column {
            name: name.into(),
            value: Box::new(value),
            head: String::new(),
            unit: "",
            digits: None,
        }
    }

    pub fn shown(
        mut self,
        head: impl Into<String>,
        unit: &'static str,
        digits: impl Into<Option<usize>>,
    ) -> Self {
        (self.head, self.unit, self.digits) = (head.into(), unit, digits.into());
        self
    }

    pub fn number(&self, row: &T) -> Option<f64> {
        (self.value)(row).as_f64()
    }

    /// The value of `row` for a CSV file, empty where there is none.
    pub fn field(&self, row: &T) -> String {
        match (self.value)(row) {
            Value::Null => String::new(),
            Value::String(text) => text,
            Value::Number(n) if n.is_f64() => n.as_f64().map_or(String::new(), |n| n.to_string()),
            value => value.to_string(),
        }
    }

    fn in_words(&self, row: &T) -> String {
        let value = (self.value)(row);
        match (value.as_f64(), self.digits) {
            (None, _) => value.as_str().unwrap_or("-").to_owned(),
            (Some(value), Some(digits)) if value.abs() >= 1e6 => format!("{value:.digits$e}"),
            (Some(value), Some(digits)) => fixed(value, digits),
            (Some(value), None) => rounded(value).to_string(),
        }
    }
}

fn in_text<'c, T>(columns: &'c [Column<T>]) -> impl Iterator<Item = &'c Column<'c, T>> {
    columns.iter().filter(|column| !column.head.is_empty())
}

fn named<'c, T>(columns: &'c [Column<T>]) -> impl Iterator<Item = &'c Column<'c, T>> {
    columns.iter().filter(|column| !column.name.is_empty())
}

/// The lines of a table: heads, units, and one for each of `rows`.
pub fn lines<T>(columns: &[Column<T>], rows: impl IntoIterator<Item = T>) -> Vec<Vec<String>> {
    let heads = in_text(columns).map(|column| column.head.clone()).collect();
    let units = in_text(columns).map(|column| column.unit.into()).collect();
    let lines = [heads, units].into_iter();
    lines
        .chain(
            rows.into_iter()
                .map(|row| in_text(columns).map(|c| c.in_words(&row)).collect()),
        )
        .collect()
}

pub fn table<T>(columns: &[Column<T>], rows: impl IntoIterator<Item = T>) -> String {
    let lines = lines(columns, rows);
    let mut widths = vec![9; lines[0].len()];
    for line in &lines {
        for (width, cell) in widths.iter_mut().zip(line) {
            *width = cell.chars().count().max(*width);
        }
    }
    let mut text = String::new();
    for line in &lines {
        // The line of units is left out where there are none.
        if line.iter().any(|cell| !cell.is_empty()) {
            let cells = line.iter().zip(&widths);
            let cells: Vec<String> = cells.map(|(c, width)| format!("{c:>width$}")).collect();
            text += cells.join(" ").trim_end();
            text.push('\n');
        }
    }
    text
}

pub fn list<T>(rows: &mut Listing, columns: &[Column<T>], row: &T) {
    for column in in_text(columns) {
        let words = format!("{} {}", column.in_words(row), column.unit);
        rows.row(&column.head, words.trim_end());
    }
}

pub fn object<T>(columns: &[Column<T>], row: &T) -> Map<String, Value> {
    named(columns)
        .map(|c| (c.name.clone(), (c.value)(row)))
        .collect()
}

/// A JSON object with a list over `rows` for every column.
pub fn lists<T>(columns: &[Column<T>], rows: &[T]) -> Map<String, Value> {
    named(columns)
        .map(|column| {
            let values = rows.iter().map(|row| (column.value)(row));
            (column.name.clone(), values.collect())
        })
        .collect()
}

/// A CSV file: a line for each of the `rows` of every group, after the `keys` of that group.
pub fn csv<'g, G, T, Rows: IntoIterator<Item = T>>(
    keys: &[Column<&'g G>],
    columns: &[Column<T>],
    groups: &'g [G],
    rows: impl Fn(&'g G) -> Rows,
) -> Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let names = keys.iter().map(|key| &key.name);
    writer.write_record(names.chain(named(columns).map(|column| &column.name)))?;
    for group in groups {
        let keys: Vec<String> = keys.iter().map(|key| key.field(&group)).collect();
        for row in rows(group) {
            let fields = named(columns).map(|column| column.field(&row));
            writer.write_record(keys.iter().cloned().chain(fields))?;
        }
    }
    Ok(writer.into_inner()?)
}

/// Adds rows `name => format, values;` to a [`Listing`].
macro_rules! rows {
    ($rows:expr; $($name:expr => $format:literal $(, $value:expr)*;)*) => {{
        $($rows.row($name, format!($format $(, $value)*));)*
    }};
}
pub(crate) use rows;

/// Lines of `name  value unit` with the values aligned.
#[derive(Debug, Default)]
pub struct Listing {
    rows: Vec<(String, String)>,
}

impl Listing {
    pub fn row(&mut self, name: impl AsRef<str>, value: impl AsRef<str>) {
        // Either may come from a file that somebody else wrote.
        let row = (shown(name.as_ref()), shown_in_full(value.as_ref()));
        self.rows.push(row);
    }

    /// As JSON, value by name.
    pub fn object(&self) -> Map<String, Value> {
        self.rows
            .iter()
            .map(|(name, value)| (name.clone(), Value::from(value.as_str())))
            .collect()
    }

    pub fn joined(&self, rows: &str, columns: &str) -> String {
        self.rows
            .iter()
            .map(|(name, value)| format!("{name}{columns}{value}"))
            .collect::<Vec<_>>()
            .join(rows)
    }
}

impl std::fmt::Display for Listing {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let widths = self.rows.iter().map(|(name, _)| name.chars().count());
        let width = widths.max().unwrap_or(0);
        for (name, value) in &self.rows {
            writeln!(f, "  {name:width$}  {value}")?;
        }
        Ok(())
    }
}
