//! Reflection of road surfaces: tables of reduced luminance coefficients.

use std::f64::consts::PI;

/// An r-table: reduced luminance coefficients r = q cos^3 epsilon, 1/sr, by the angle beta and tan epsilon. Between its entries it is bilinear, beyond them 0.
#[derive(Clone, Debug, PartialEq)]
pub struct RoadSurface {
    /// Degrees, ascending within [0, 180].
    betas: Vec<f64>,
    /// Ascending, from 0.
    tangents: Vec<f64>,
    /// Row by row: a row for each tangent.
    coefficients: Vec<f64>,
}

/// Errors of a file of an r-table.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{line}:{column}: {fault}")]
pub struct RTableError {
    /// Line, from 1.
    pub line: usize,
    /// Column of the number, from 1.
    pub column: usize,
    /// The fault and its remedy.
    pub fault: String,
}

/// Largest number of entries: tables have hundreds.
const ENTRIES_LIMIT: usize = 1 << 16;

impl RoadSurface {
    /// Reads a text. Its first line has a word, such as `tan`, and the angles beta in degrees; each other line has a tan epsilon and the coefficients for these angles, times 10,000 as
    /// standards print them. Numbers are separated by spaces, tabs, semicolons or commas; `#` begins a comment.
    ///
    /// # Errors
    /// [`RTableError`] with the place of the first number that is wrong or missing.
    pub fn read(text: &str) -> Result<Self, RTableError> {
        let mut lines = text.lines().enumerate().filter_map(|(number, line)| {
            let line = line.split('#').next().unwrap_or_default();
            let words = words(line);
            (!words.is_empty()).then_some((number + 1, line.len() + 1, words))
        });
        let error = |line: usize, column: usize, fault: String| RTableError { line, column, fault };
        let missing = || error(1, 1, "there is no table; the first line names the angles beta".to_owned());
        let (line, end, head) = lines.next().ok_or_else(missing)?;
        let betas = numbers(line, head.get(1..).unwrap_or_default(), "angle beta", 180.0)?;
        if betas.len() < 2 || betas.first() != Some(&0.0) {
            let fault = "the angles beta must be at least two and begin at 0 degrees".to_owned();
            return Err(error(line, end, fault));
        }
        let (mut tangents, mut coefficients): (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
        for (line, end, words) in lines {
            let row = words.get(..1).unwrap_or_default();
            let tangent = numbers(line, row, "tan epsilon", f64::MAX)?.first().copied().unwrap_or_default();
            let last = tangents.last().copied();
            if last.is_some_and(|last| tangent <= last) || (last.is_none() && tangent != 0.0) {
                let fault = format!("tan epsilon is {tangent}; the rows must begin at 0 and ascend");
                return Err(error(line, 1, fault));
            }
            let entries = words.get(1..).unwrap_or_default();
            if entries.len() != betas.len() {
                let fault =
                    format!("there are {} coefficients for {} angles beta", entries.len(), betas.len());
                return Err(error(line, end, fault));
            }
            for (column, word) in entries {
                let value: f64 = word.parse().unwrap_or(f64::NAN);
                if !(value >= 0.0 && value.is_finite()) {
                    let fault = format!("\"{word}\" is no coefficient; it must be a number from 0");
                    return Err(error(line, *column, fault));
                }
                coefficients.push(value * 1e-4);
            }
            tangents.push(tangent);
            if coefficients.len() > ENTRIES_LIMIT {
                return Err(error(line, 1, format!("a table has at most {ENTRIES_LIMIT} coefficients")));
            }
        }
        if tangents.len() < 2 {
            return Err(error(line, end, "at least two rows must follow, from tan epsilon 0 on".to_owned()));
        }
        Ok(Self { betas, tangents, coefficients })
    }

    /// Reduced luminance coefficient, 1/sr; `beta`: degrees, of which the amount counts.
    #[must_use]
    pub fn coefficient(&self, beta: f64, tangent: f64) -> f64 {
        let (Some((i, u)), Some((j, v))) = (place(&self.betas, beta.abs()), place(&self.tangents, tangent))
        else {
            return 0.0;
        };
        let at = |j: usize, i: usize| self.entry(j, i);
        let row = |j: usize| at(j, i) * (1.0 - u) + at(j, i + 1) * u;
        row(j) * (1.0 - v) + row(j + 1) * v
    }

    fn entry(&self, row: usize, column: usize) -> f64 {
        self.coefficients.get(row * self.betas.len() + column).copied().unwrap_or(0.0)
    }

    /// Average luminance coefficient Q0, 1/sr: the mean of q over the solid angle of the entries above 0.
    ///
    /// As q d omega = r t dt d beta with t = tan epsilon, it is computed by a fine midpoint rule on the bilinear table.
    #[must_use]
    pub fn average_coefficient(&self) -> f64 {
        let (mut light, mut angle) = (0.0, 0.0);
        for (j, t) in self.tangents.windows(2).enumerate() {
            for (i, b) in self.betas.windows(2).enumerate() {
                if self
                    .entry(j, i)
                    .max(self.entry(j, i + 1))
                    .max(self.entry(j + 1, i))
                    .max(self.entry(j + 1, i + 1))
                    == 0.0
                {
                    continue;
                }
                let steps = 16;
                for (m, n) in (0..steps).flat_map(|m| (0..steps).map(move |n| (m, n))) {
                    let [u, v] = [m, n].map(|k| (f64::from(k) + 0.5) / f64::from(steps));
                    let (tangent, beta) = (t[0] + (t[1] - t[0]) * u, b[0] + (b[1] - b[0]) * v);
                    let area = tangent * (t[1] - t[0]) * (b[1] - b[0]);
                    light += self.coefficient(beta, tangent) * area;
                    angle += (1.0 + tangent * tangent).powf(-1.5) * area;
                }
            }
        }
        if angle > 0.0 { light / angle } else { 0.0 }
    }

    /// Specular factor S1: r at beta 0 and tan epsilon 2 over r straight down; `None` if that is 0.
    #[must_use]
    pub fn specular_factor(&self) -> Option<f64> {
        let down = self.coefficient(0.0, 0.0);
        (down > 0.0).then(|| self.coefficient(0.0, 2.0) / down)
    }

    /// A surface that reflects diffusely, up to tan epsilon 12, of this reflectance: q = reflectance / pi.
    #[must_use]
    pub fn diffuse(reflectance: f64) -> Self {
        let betas = vec![0.0, 180.0];
        let tangents: Vec<f64> = (0..=480).map(|i| 0.025 * f64::from(i)).collect();
        let coefficient = |tangent: &f64| reflectance / PI * (1.0 + tangent * tangent).powf(-1.5);
        let coefficients = tangents.iter().flat_map(|tangent| [coefficient(tangent); 2]).collect();
        Self { betas, tangents, coefficients }
    }
}

/// Words of a line with their columns, from 1.
fn words(line: &str) -> Vec<(usize, &str)> {
    let separators = [' ', '\t', ';', ','];
    let mut words = Vec::new();
    let mut column = 1;
    for word in line.split(separators) {
        if !word.trim().is_empty() {
            words.push((column, word.trim()));
        }
        column += word.chars().count() + 1;
    }
    words
}

/// Ascending numbers from 0 to `most`.
fn numbers(line: usize, words: &[(usize, &str)], what: &str, most: f64) -> Result<Vec<f64>, RTableError> {
    let mut numbers: Vec<f64> = Vec::new();
    for &(column, word) in words {
        let value: f64 = word.parse().unwrap_or(f64::NAN);
        if !(value >= 0.0 && value <= most) || numbers.last().is_some_and(|last| value <= *last) {
            let range = if most < f64::MAX { format!(" to {most}") } else { String::new() };
            let fault =
                format!("\"{word}\" is no {what}; it must be a number from 0{range}, and they must ascend");
            return Err(RTableError { line, column, fault });
        }
        numbers.push(value);
    }
    Ok(numbers)
}

/// Index of the interval that holds `value`, and its position there; `None` outside.
fn place(ends: &[f64], value: f64) -> Option<(usize, f64)> {
    let last = ends.last()?;
    // Angles that are computed from directions may exceed 180 degrees by rounding.
    let value = if value > *last && value <= *last + 1e-9 { *last } else { value };
    if !(value >= *ends.first()? && value <= *last) {
        return None;
    }
    let i = ends.partition_point(|end| *end <= value).saturating_sub(1).min(ends.len().checked_sub(2)?);
    let pair = ends.get(i..i + 2)?;
    Some((i, (value - pair[0]) / (pair[1] - pair[0])))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TABLE: &str = "# made up\ntan 0 90 180\n0 300 300 300\n1; 100; 60; 80  # numbers\n\n2\t40\t0\t0\n";

    #[test]
    fn entries_are_interpolated_and_light_from_beyond_them_is_none() {
        let surface = RoadSurface::read(TABLE).unwrap();
        let near = |found: f64, expected: f64| assert!((found - 1e-4 * expected).abs() < 1e-15, "{found}");
        near(surface.coefficient(0.0, 0.0), 300.0);
        near(surface.coefficient(90.0, 1.0), 60.0);
        near(surface.coefficient(-90.0, 1.0), 60.0);
        near(surface.coefficient(45.0, 1.0), 80.0);
        near(surface.coefficient(45.0, 1.5), 0.5 * (80.0 + 20.0));
        near(surface.coefficient(180.0 + 1e-10, 1.0), 80.0);
        near(surface.coefficient(0.0, 2.0), 40.0);
        assert_eq!((surface.coefficient(0.0, 2.1), surface.coefficient(0.0, f64::NAN)), (0.0, 0.0));
        assert!((surface.specular_factor().unwrap() - 40.0 / 300.0).abs() < 1e-12);
    }

    #[test]
    fn average_coefficient_of_a_diffuse_surface_is_its_reflectance_over_pi() {
        let surface = RoadSurface::diffuse(0.22);
        assert!((surface.average_coefficient() * PI / 0.22 - 1.0).abs() < 1e-3);
        // r falls by cos^3 of atan 2.
        assert!((surface.specular_factor().unwrap() - 5.0_f64.powf(-1.5)).abs() < 1e-4);
    }

    #[test]
    fn faults_are_reported_with_line_and_column() {
        for (text, place, part) in [
            ("", (1, 1), "there is no table"),
            ("tan 0 x\n", (1, 7), "\"x\" is no angle beta"),
            ("tan 0 190\n", (1, 7), "from 0 to 180"),
            ("tan 5 10\n", (1, 9), "begin at 0"),
            ("tan 0 180\n0 1 1\n", (1, 10), "two rows"),
            ("tan 0 180\n0 1 1\n0 1 1\n", (3, 1), "ascend"),
            ("tan 0 180\n1 1 1\n", (2, 1), "begin at 0"),
            ("tan 0 180\n0 1\n", (2, 4), "1 coefficients for 2"),
            ("# R\ntan 0 180\n0 1 -1\n", (3, 5), "\"-1\" is no coefficient"),
            ("tan 0 180\n0 1 inf\n", (2, 5), "\"inf\""),
        ] {
            let error = RoadSurface::read(text).unwrap_err();
            assert_eq!((error.line, error.column), place, "{text}: {error}");
            assert!(error.fault.contains(part), "{error}");
        }
    }
}
