//! Tables: for people (Markdown, terminal), for programs (CSV, JSON).

use std::fmt::Write;

pub use glanz_job::grouped;
use serde::ser::{Serialize, SerializeMap, SerializeSeq, Serializer};

/// Significant digits that people see; programs get all.
const DIGITS: i32 = 4;

/// What a column holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Column {
    /// Name for programs, with the unit: `time_ns`.
    pub key: &'static str,
    /// Name for people, with the unit: `time, ns`.
    pub title: &'static str,
}

/// An entry.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// A word.
    Text(String),
    /// A number of things.
    Count(u64),
    /// A measured number.
    Number(f64),
    /// A number of which every digit counts.
    Precise(f64),
    /// Not measured, or without meaning here.
    Missing,
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<u64> for Cell {
    fn from(count: u64) -> Self {
        Self::Count(count)
    }
}

impl From<f64> for Cell {
    fn from(number: f64) -> Self {
        Self::Number(number)
    }
}

impl<T: Into<Cell>> From<Option<T>> for Cell {
    fn from(value: Option<T>) -> Self {
        value.map_or(Self::Missing, Into::into)
    }
}

impl Cell {
    /// As people read it.
    #[must_use]
    pub fn shown(&self) -> String {
        match self {
            Self::Text(text) => text.clone(),
            Self::Count(count) => grouped(*count),
            Self::Precise(number) if (1e-3..1e9).contains(&number.abs()) => number.to_string(),
            Self::Number(number) | Self::Precise(number) => significant(*number),
            Self::Missing => "-".to_owned(),
        }
    }

    fn csv(&self) -> String {
        match self {
            Self::Text(text) if text.contains([',', '"', '\n']) => {
                format!("\"{}\"", text.replace('"', "\"\""))
            }
            Self::Text(text) => text.clone(),
            Self::Count(count) => count.to_string(),
            Self::Number(number) | Self::Precise(number) => number.to_string(),
            Self::Missing => String::new(),
        }
    }
}

impl Serialize for Cell {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Text(text) => serializer.serialize_str(text),
            Self::Count(count) => serializer.serialize_u64(*count),
            Self::Number(number) | Self::Precise(number) if number.is_finite() => {
                serializer.serialize_f64(*number)
            }
            Self::Number(_) | Self::Precise(_) | Self::Missing => serializer.serialize_none(),
        }
    }
}

/// Rows under named columns.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    name: &'static str,
    caption: String,
    columns: Vec<Column>,
    rows: Vec<Vec<Cell>>,
}

impl Table {
    /// An empty table; `name` is that of its CSV file, `columns` are pairs of key and title.
    #[must_use]
    pub fn new(
        name: &'static str,
        caption: impl Into<String>,
        columns: &[(&'static str, &'static str)],
    ) -> Self {
        let columns = columns.iter().map(|&(key, title)| Column { key, title }).collect();
        Self { name, caption: caption.into(), columns, rows: Vec::new() }
    }

    /// Adds a row; cells that are missing at its end stay empty, those beyond the last column are dropped.
    pub fn push(&mut self, cells: impl IntoIterator<Item = Cell>) {
        let mut row: Vec<Cell> = cells.into_iter().take(self.columns.len()).collect();
        row.resize(self.columns.len(), Cell::Missing);
        self.rows.push(row);
    }

    /// Name of the CSV file, without extension.
    #[must_use]
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// What it shows.
    #[must_use]
    pub fn caption(&self) -> &str {
        &self.caption
    }

    /// The columns.
    #[must_use]
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// The rows, as long as there are columns.
    #[must_use]
    pub fn rows(&self) -> &[Vec<Cell>] {
        &self.rows
    }

    /// As Markdown, numbers to the right.
    #[must_use]
    pub fn markdown(&self) -> String {
        let mut text = String::new();
        let titles: Vec<&str> = self.columns.iter().map(|c| c.title).collect();
        let _ = writeln!(text, "| {} |", titles.join(" | "));
        let marks: Vec<&str> =
            (0..self.columns.len()).map(|i| if self.is_text(i) { "---" } else { "---:" }).collect();
        let _ = writeln!(text, "|{}|", marks.join("|"));
        for row in &self.rows {
            let cells: Vec<String> = row.iter().map(|c| c.shown().replace('|', "\\|")).collect();
            let _ = writeln!(text, "| {} |", cells.join(" | "));
        }
        text
    }

    /// With the keys in the first line; every digit of every number.
    #[must_use]
    pub fn csv(&self) -> String {
        let keys: Vec<&str> = self.columns.iter().map(|c| c.key).collect();
        let mut text = keys.join(",") + "\n";
        for row in &self.rows {
            let cells: Vec<String> = row.iter().map(Cell::csv).collect();
            text += &(cells.join(",") + "\n");
        }
        text
    }

    /// For a terminal: columns aligned, numbers to the right.
    #[must_use]
    pub fn plain(&self) -> String {
        let titles = self.columns.iter().map(|c| c.title.to_owned()).collect();
        let body = self.rows.iter().map(|row| row.iter().map(Cell::shown).collect());
        let lines: Vec<Vec<String>> = std::iter::once(titles).chain(body).collect();
        let width = |i: usize| lines.iter().filter_map(|l| l.get(i)).map(|c| c.chars().count()).max();
        let widths: Vec<usize> = (0..self.columns.len()).filter_map(width).collect();
        let mut text = String::new();
        for line in &lines {
            let cells = line.iter().zip(&widths).enumerate().map(|(i, (cell, &width))| {
                if self.is_text(i) { format!("{cell:<width$}") } else { format!("{cell:>width$}") }
            });
            text += cells.collect::<Vec<_>>().join("  ").trim_end();
            text.push('\n');
        }
        text
    }

    fn is_text(&self, column: usize) -> bool {
        self.rows.iter().any(|row| matches!(row.get(column), Some(Cell::Text(_))))
    }
}

/// A list of rows, each an object by the columns' keys.
impl Serialize for Table {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        struct Row<'a>(&'a [Column], &'a [Cell]);
        impl Serialize for Row<'_> {
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                let mut map = serializer.serialize_map(Some(self.0.len()))?;
                for (column, cell) in self.0.iter().zip(self.1) {
                    map.serialize_entry(column.key, cell)?;
                }
                map.end()
            }
        }
        let mut list = serializer.serialize_seq(Some(self.rows.len()))?;
        for row in &self.rows {
            list.serialize_element(&Row(&self.columns, row))?;
        }
        list.end()
    }
}

/// `count` with the word for one or for several.
#[must_use]
pub fn plural(count: u64, one: &str, several: &str) -> String {
    format!("{} {}", grouped(count), if count == 1 { one } else { several })
}

/// A number to four significant digits, with a power of ten where it is very large or small.
#[must_use]
pub fn significant(number: f64) -> String {
    if number == 0.0 || !number.is_finite() {
        return number.to_string();
    }
    let exponent = number.abs().log10().floor() as i32;
    match exponent {
        -3..=6 => format!("{number:.*}", usize::try_from(DIGITS - 1 - exponent).unwrap_or(0)),
        _ => format!("{number:.2e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> Table {
        let mut table = Table::new("t", "A table", &[("who", "who"), ("time_ns", "time, ns"), ("n", "n")]);
        table.push(["a, \"b\"".into(), 1234.5678.into(), 1_000_000_u64.into()]);
        table.push(["c|d".into(), 0.5.into()]);
        table
    }

    #[test]
    fn programs_get_every_digit_and_people_four() {
        assert_eq!(table().csv(), "who,time_ns,n\n\"a, \"\"b\"\"\",1234.5678,1000000\nc|d,0.5,\n");
        assert_eq!(
            table().markdown(),
            "| who | time, ns | n |\n|---|---:|---:|\n| a, \"b\" | 1235 | 1 000 000 |\n| c\\|d | 0.5000 | - |\n"
        );
        let json = serde_json::to_value(table()).unwrap();
        assert_eq!(json[0]["time_ns"], 1234.5678);
        assert_eq!((&json[1]["n"], &json[0]["n"]), (&serde_json::Value::Null, &serde_json::json!(1_000_000)));
    }

    #[test]
    fn lines_of_a_terminal_are_aligned() {
        assert_eq!(
            table().plain(),
            "who     time, ns          n\na, \"b\"      1235  1 000 000\nc|d       0.5000          -\n"
        );
    }

    #[test]
    fn precise_numbers_keep_every_digit() {
        assert_eq!(Cell::Precise(46.012_263_655_548_77).shown(), "46.01226365554877");
        assert_eq!(Cell::Precise(-2.58e16).shown(), "-2.58e16");
        assert_eq!(
            (plural(1, "root", "roots"), plural(3, "root", "roots")),
            ("1 root".into(), "3 roots".into())
        );
    }

    #[test]
    fn numbers_keep_four_digits_whatever_their_size() {
        for (number, shown) in
            [(0.0, "0"), (0.012_345, "0.01235"), (123_456.0, "123456"), (1.5e-7, "1.50e-7"), (3e9, "3.00e9")]
        {
            assert_eq!(significant(number), shown);
        }
    }
}
