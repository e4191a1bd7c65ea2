//! Tables: for people (Markdown, HTML, terminal), for programs (CSV, JSON).

use std::fmt::Write;

use serde::ser::{Serialize, SerializeMap, SerializeSeq, Serializer};

use crate::number::{grouped, significant};
use crate::svg::escaped;

/// `words` with control characters replaced, so that they cannot control a terminal.
#[must_use]
pub fn printable(words: &str) -> String {
    words.chars().map(|letter| if letter.is_control() { '\u{fffd}' } else { letter }).collect()
}

/// The names of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Column {
    /// Name for programs, with the unit: `time_ns`.
    pub key: &'static str,
    /// Name for people, with the unit: `time, ns`.
    pub title: &'static str,
}

/// An entry of a table.
#[derive(Clone, Debug, PartialEq)]
pub enum TableCell {
    /// A word.
    Text(String),
    /// A whole number.
    Count(u64),
    /// A measured number.
    Number(f64),
    /// A number of which every digit counts.
    Precise(f64),
    /// Not measured, or without meaning in this row.
    Missing,
}

impl From<&str> for TableCell {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<u64> for TableCell {
    fn from(count: u64) -> Self {
        Self::Count(count)
    }
}

impl From<f64> for TableCell {
    fn from(number: f64) -> Self {
        Self::Number(number)
    }
}

impl<T: Into<TableCell>> From<Option<T>> for TableCell {
    fn from(value: Option<T>) -> Self {
        value.map_or(Self::Missing, Into::into)
    }
}

impl TableCell {
    /// The entry as people read it.
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

impl Serialize for TableCell {
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
    rows: Vec<Vec<TableCell>>,
}

impl Table {
    /// An empty table. `name`: that of its CSV file; `columns`: pairs of key and title.
    #[must_use]
    pub fn new(
        name: &'static str,
        caption: impl Into<String>,
        columns: &[(&'static str, &'static str)],
    ) -> Self {
        let columns = columns.iter().map(|&(key, title)| Column { key, title }).collect();
        Self { name, caption: caption.into(), columns, rows: Vec::new() }
    }

    /// Adds a row. A row that is too short ends with missing entries; entries beyond the last column are dropped.
    pub fn push(&mut self, cells: impl IntoIterator<Item = TableCell>) {
        let mut row: Vec<TableCell> = cells.into_iter().take(self.columns.len()).collect();
        row.resize(self.columns.len(), TableCell::Missing);
        self.rows.push(row);
    }

    /// Name of the CSV file, without extension.
    #[must_use]
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// A sentence on what the table shows.
    #[must_use]
    pub fn caption(&self) -> &str {
        &self.caption
    }

    /// The columns.
    #[must_use]
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// The rows; each has as many entries as the table has columns.
    #[must_use]
    pub fn rows(&self) -> &[Vec<TableCell>] {
        &self.rows
    }

    /// The table in Markdown, numbers right-aligned.
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

    /// Comma-separated values: the keys in the first line, then a line per row with every digit of every number.
    #[must_use]
    pub fn csv(&self) -> String {
        let keys: Vec<&str> = self.columns.iter().map(|c| c.key).collect();
        let mut text = keys.join(",") + "\n";
        for row in &self.rows {
            let cells: Vec<String> = row.iter().map(TableCell::csv).collect();
            text += &(cells.join(",") + "\n");
        }
        text
    }

    /// The table for a terminal: columns aligned, numbers right-aligned.
    #[must_use]
    pub fn plain(&self) -> String {
        let titles = self.columns.iter().map(|c| c.title.to_owned()).collect();
        let body = self.rows.iter().map(|row| row.iter().map(TableCell::shown).collect());
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

    /// The table in HTML with its caption, numbers of class `number`, in a `div` of class `wide`. Without titles of columns, except that of the first, which the caption
    /// stands for, there is no line of titles.
    #[must_use]
    pub fn html(&self) -> String {
        let class = |column: usize| if self.is_number(column) { " class=\"number\"" } else { "" };
        let heads = self.columns.iter().enumerate();
        let head: String =
            heads.map(|(i, c)| format!("<th scope=\"col\"{}>{}</th>", class(i), escaped(c.title))).collect();
        let row = |cells: &Vec<TableCell>| -> String {
            let cells = cells.iter().enumerate();
            cells.map(|(i, cell)| format!("<td{}>{}</td>", class(i), escaped(&cell.shown()))).collect()
        };
        let rows: String = self.rows.iter().map(|cells| format!("<tr>{}</tr>\n", row(cells))).collect();
        let has_titles =
            self.columns.len() < 2 || self.columns.iter().skip(1).any(|column| !column.title.is_empty());
        let head = if has_titles { format!("<thead><tr>{head}</tr></thead>\n") } else { String::new() };
        let caption = escaped(&self.caption);
        format!(
            "<div class=\"wide\"><table>\n<caption>{caption}</caption>\n{head}<tbody>\n{rows}</tbody>\n\
             </table></div>\n"
        )
    }

    fn is_text(&self, column: usize) -> bool {
        self.rows.iter().any(|row| matches!(row.get(column), Some(TableCell::Text(_))))
    }

    fn is_number(&self, column: usize) -> bool {
        let mut cells = self.rows.iter().filter_map(|row| row.get(column));
        cells.any(|cell| matches!(cell, TableCell::Number(_) | TableCell::Count(_) | TableCell::Precise(_)))
    }
}

/// A list of rows, each an object with the columns' keys.
impl Serialize for Table {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        struct TableRow<'a>(&'a [Column], &'a [TableCell]);
        impl Serialize for TableRow<'_> {
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
            list.serialize_element(&TableRow(&self.columns, row))?;
        }
        list.end()
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
    fn lists_of_facts_have_no_line_of_titles() {
        let mut facts = Table::new("facts", "Facts & figures", &[("fact", "facts"), ("value", "")]);
        facts.push(["<a>".into(), 1.0.into()]);
        let html = facts.html();
        assert!(
            !html.contains("<thead>")
                && html.contains("<caption>Facts &amp; figures</caption>")
                && html.contains("&lt;a&gt;")
        );
        assert!(table().html().contains("<thead><tr><th scope=\"col\">who</th>"));
        let mut list = Table::new("list", "", &[("name", "name")]);
        list.push(["a".into()]);
        assert!(list.html().contains("<thead>"));
    }

    #[test]
    fn precise_numbers_keep_every_digit() {
        assert_eq!(TableCell::Precise(46.012_263_655_548_77).shown(), "46.01226365554877");
        assert_eq!(TableCell::Precise(-2.58e16).shown(), "-2.58e16");
    }
}
