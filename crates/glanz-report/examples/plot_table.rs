//! Plots columns of a CSV table over its first one, on logarithmic axes:
//! `cargo run -p glanz-report --example plot_table -- TITLE X_AXIS Y_AXIS COLUMN=NAME ... < TABLE > PLOT.svg`.

use std::error::Error;
use std::io::{Read, Write};

use glanz_report::{Axis, Plot, Series};

/// A series of the points of one column.
fn series(header: &[&str], rows: &[Vec<f64>], column: &str) -> Result<Series, Box<dyn Error>> {
    let (column, name) = column.split_once('=').unwrap_or((column, column));
    let found = header.iter().position(|name| *name == column);
    let index = found.ok_or_else(|| format!("no column {column}; the table has {}", header.join(", ")))?;
    let points = rows.iter().filter_map(|row| Some([*row.first()?, *row.get(index)?]));
    Ok(Series { name: name.into(), points: points.collect() })
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [title, x, y, columns @ ..] = arguments.as_slice() else {
        return Err("expected TITLE X_AXIS Y_AXIS COLUMN=NAME ...".into());
    };
    let mut table = String::new();
    std::io::stdin().read_to_string(&mut table)?;
    let mut lines = table.lines();
    let header: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
    let row = |line: &str| line.split(',').map(str::parse).collect::<Result<Vec<f64>, _>>();
    let rows: Vec<Vec<f64>> = lines.map(row).collect::<Result<_, _>>()?;
    let plot = Plot {
        title: title.clone(),
        x: Axis::logarithmic(x.as_str()),
        y: Axis::logarithmic(y.as_str()),
        series: columns.iter().map(|column| series(&header, &rows, column)).collect::<Result<_, _>>()?,
        reference_lines: Vec::new(),
    };
    Ok(std::io::stdout().write_all(plot.svg().as_bytes())?)
}
