//! Values of parameters, and lists of them.

use std::fmt::{Display, Write};

use glanz_math::{DMat4, DVec2, DVec3};

/// A text in quotation marks.
pub(super) fn quoted(text: &str) -> String {
    let mut quoted = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => quoted.extend(['\\', c]),
            '\n' => quoted.push_str("\\n"),
            '\r' => quoted.push_str("\\r"),
            '\t' => quoted.push_str("\\t"),
            _ => quoted.push(c),
        }
    }
    quoted.push('"');
    quoted
}

/// The columns of a matrix in brackets.
pub(super) fn matrix(matrix: DMat4) -> String {
    let numbers: Vec<String> = matrix.to_cols_array().iter().map(f64::to_string).collect();
    format!("[ {} ]", numbers.join(" "))
}

/// Writer of the parameters of one directive. A number that is not finite is remembered: the language has none.
pub(super) struct ParameterWriter<'a> {
    text: &'a mut String,
    finite: bool,
}

impl<'a> ParameterWriter<'a> {
    pub(super) fn new(text: &'a mut String) -> Self {
        Self { text, finite: true }
    }

    /// Ends the directive; `Err` if a number was not finite.
    pub(super) fn finish(self) -> Result<(), &'static str> {
        self.text.push('\n');
        if self.finite { Ok(()) } else { Err("it has a number that is not finite") }
    }

    fn list<T: Display>(&mut self, kind: &str, name: &str, values: impl IntoIterator<Item = T>) {
        let _ = write!(self.text, "\n  \"{kind} {name}\" [");
        for value in values {
            let _ = write!(self.text, " {value}");
        }
        self.text.push_str(" ]");
    }

    pub(super) fn floats(&mut self, name: &str, values: impl IntoIterator<Item = f64>) {
        self.typed("float", name, values);
    }

    pub(super) fn typed(&mut self, kind: &str, name: &str, values: impl IntoIterator<Item = f64>) {
        // The shortest decimal that reads back to the same bits.
        let values: Vec<f64> = values.into_iter().collect();
        self.finite &= values.iter().all(|value| value.is_finite());
        self.list(kind, name, values);
    }

    pub(super) fn float(&mut self, name: &str, value: f64) {
        self.floats(name, [value]);
    }

    /// Single precision, in as few digits as it needs.
    pub(super) fn singles(&mut self, kind: &str, name: &str, values: impl IntoIterator<Item = f32>) {
        let values: Vec<f32> = values.into_iter().collect();
        self.finite &= values.iter().all(|value| value.is_finite());
        self.list(kind, name, values);
    }

    pub(super) fn integers(&mut self, name: &str, values: impl IntoIterator<Item = i64>) {
        self.list("integer", name, values);
    }

    pub(super) fn boolean(&mut self, name: &str, value: bool) {
        self.list("bool", name, [value]);
    }

    pub(super) fn text(&mut self, name: &str, value: &str) {
        self.list("string", name, [quoted(value)]);
    }

    pub(super) fn points(&mut self, name: &str, points: impl IntoIterator<Item = DVec3>) {
        self.typed("point3", name, points.into_iter().flat_map(|point| point.to_array()));
    }

    pub(super) fn normals(&mut self, name: &str, normals: impl IntoIterator<Item = DVec3>) {
        self.typed("normal", name, normals.into_iter().flat_map(|normal| normal.to_array()));
    }

    pub(super) fn pairs(&mut self, name: &str, pairs: impl IntoIterator<Item = DVec2>) {
        self.typed("point2", name, pairs.into_iter().flat_map(|pair| pair.to_array()));
    }

    /// The largest azimuth: in degrees where that reads back to the same bits, else in radians.
    pub(super) fn azimuth(&mut self, radians: f64) {
        match degrees(radians) {
            Some(degrees) => self.float("phimax", degrees),
            None => self.float("phimaxradians", radians),
        }
    }
}

/// Degrees whose conversion gives these radians.
fn degrees(radians: f64) -> Option<f64> {
    /// Roundings of the conversion to degrees.
    const ULPS: usize = 2;
    let near = radians.to_degrees();
    let below = std::iter::successors(Some(near), |x| Some(x.next_down())).take(ULPS + 1);
    let above = std::iter::successors(Some(near), |x| Some(x.next_up())).take(ULPS + 1);
    below.chain(above).find(|degrees| degrees.to_radians() == radians)
}
