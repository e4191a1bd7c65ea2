//! Lists of bicubic patches in the format of Martin Newell's teapot.
//!
//! Text without a header: the number of patches; per patch sixteen indices of control points, counted from 1; the
//! number of points; three coordinates per point. Numbers are separated by commas, blanks or line ends. Memory is
//! bounded by the size of the input.
//!
//! ```
//! let text = format!("1\n{}\n16\n{}", "1,".repeat(16), "0.5,0,2\n".repeat(16));
//! let mesh = glanz_formats::newell::read(text.as_bytes())?;
//! assert_eq!((mesh.patches, mesh.positions.len()), (vec![[0; 16]], 16));
//! # Ok::<(), glanz_formats::newell::NewellError>(())
//! ```

use glanz_job::{BudgetError, ResourceBudget};
use glanz_math::DVec3;
use glanz_scene::description::BezierPatchesDescription;

use crate::source::line_and_column;

/// Control points of a bicubic patch.
pub const POINTS: usize = 16;

/// Patches with shared control points.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NewellMesh {
    /// Control points.
    pub positions: Vec<DVec3>,
    /// Indices of the points of each patch, from 0, four rows of four in the order of the file.
    pub patches: Vec<[u32; POINTS]>,
}

/// Error of reading a list of patches, with its position.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{line}:{column}: {kind}")]
pub struct NewellError {
    /// Line, from 1.
    pub line: u32,
    /// Column in bytes, from 1.
    pub column: u32,
    /// Kind.
    pub kind: NewellErrorKind,
}

/// Kinds of errors of lists of patches.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum NewellErrorKind {
    /// The file ends too early.
    #[error("the file ends before {0}")]
    End(&'static str),
    /// Something other than the expected number.
    #[error("expected {wanted}, found {found:?}")]
    Number {
        /// The text found.
        found: String,
        /// The number expected.
        wanted: &'static str,
    },
    /// More items than the rest of the file can contain.
    #[error("{count} {what} are declared; the file has {bytes} bytes left for them")]
    Count {
        /// The items.
        what: &'static str,
        /// Declared number.
        count: u32,
        /// Bytes left.
        bytes: usize,
    },
    /// A patch refers to a point that does not exist.
    #[error("patch {patch} refers to point {index}; there are {count}, counted from 1")]
    Index {
        /// Counted from 1.
        patch: usize,
        /// The referenced item.
        index: u32,
        /// Number of points.
        count: u32,
    },
    /// A coordinate that is infinite or not a number.
    #[error("{0:?} is not finite")]
    NotFinite(String),
    /// The budget of reading is used up.
    #[error(transparent)]
    Budget(#[from] BudgetError),
    /// Text after the declared numbers.
    #[error("{0:?} follows the last point")]
    Trailing(String),
}

/// Reads a list of patches from the bytes of a file.
///
/// # Errors
/// [`NewellError`] with the place in the file.
pub fn read(bytes: &[u8]) -> Result<NewellMesh, NewellError> {
    read_with(bytes, &ResourceBudget::default())
}

/// Bytes for each byte of a file: of an index such as `1,`, four, and a point of 32.
const MEMORY_PER_BYTE: u64 = 24;

/// As [`read`] within a budget.
///
/// # Errors
/// [`NewellError`] with the place in the file.
pub fn read_with(bytes: &[u8], budget: &ResourceBudget) -> Result<NewellMesh, NewellError> {
    let mut words = TokenReader { bytes, offset: 0 };
    let needed = MEMORY_PER_BYTE.saturating_mul(bytes.len() as u64);
    let _reserved = budget.reserve(needed).map_err(|end| words.error(0, end.into()))?;
    let check = |words: &TokenReader<'_>| {
        budget.check().map_err(|end| words.error(words.offset, NewellErrorKind::Budget(end)))
    };
    let patch_count = words.count("patches", "the number of patches", POINTS)?;
    let first_index = words;
    let mut patches = Vec::with_capacity(patch_count as usize);
    for _ in 0..patch_count {
        check(&words)?;
        let mut patch = [0; POINTS];
        for index in &mut patch {
            *index = words.number("the index of a control point")?;
        }
        patches.push(patch);
    }
    let count = words.count("points", "the number of control points", 3)?;
    for (i, index) in patches.as_flattened_mut().iter_mut().enumerate() {
        match index.checked_sub(1).filter(|index| *index < count) {
            Some(from_zero) => *index = from_zero,
            None => {
                let kind = NewellErrorKind::Index { patch: i / POINTS + 1, index: *index, count };
                return Err(first_index.error_at_word(i, kind));
            }
        }
    }
    let mut positions = Vec::with_capacity(count as usize);
    for _ in 0..count {
        check(&words)?;
        let mut position = [0.0; 3];
        for x in &mut position {
            *x = words.coordinate()?;
        }
        positions.push(DVec3::from_array(position));
    }
    match words.next() {
        Some((at, word)) => Err(words.error(at, NewellErrorKind::Trailing(quoted(word)))),
        None => Ok(NewellMesh { positions, patches }),
    }
}

/// Degree of the patches.
const CUBIC: usize = 3;

/// Bicubic patches from four rows of four points each, along u. `indices`: of their points among `positions`; each must exist.
pub(crate) fn bicubic_patches(positions: &[DVec3], indices: &[[u32; POINTS]]) -> BezierPatchesDescription {
    let point = |&i: &u32| positions.get(i as usize).map(|p| p.extend(1.0).to_array());
    let patches = indices.iter().map(|patch| {
        let points: Vec<[f64; 4]> = patch.iter().filter_map(point).collect();
        transposed(&points, CUBIC + 1)
    });
    BezierPatchesDescription { degree_u: CUBIC, degree_v: CUBIC, patches: patches.collect() }
}

/// Transposes control points: the input has consecutive rows of `count_u` points along u, the result consecutive points along v.
pub(crate) fn transposed(points: &[[f64; 4]], count_u: usize) -> Vec<[f64; 4]> {
    (0..count_u).flat_map(|i| points.iter().skip(i).step_by(count_u).copied()).collect()
}

/// Largest number of characters of a word in messages.
const QUOTED: usize = 40;

fn quoted(word: &[u8]) -> String {
    String::from_utf8_lossy(word).chars().take(QUOTED).collect()
}

/// Reader of successive words.
#[derive(Clone, Copy)]
struct TokenReader<'a> {
    bytes: &'a [u8],
    offset: usize,
}

impl<'a> TokenReader<'a> {
    /// The next word and its offset.
    fn next(&mut self) -> Option<(usize, &'a [u8])> {
        let between = |b: &u8| b.is_ascii_whitespace() || *b == b',';
        let rest = self.bytes.get(self.offset..)?;
        let start = self.offset + rest.iter().position(|b| !between(b))?;
        let rest = self.bytes.get(start..)?;
        let length = rest.iter().position(between).unwrap_or(rest.len());
        self.offset = start + length;
        Some((start, rest.get(..length)?))
    }

    /// The next word as a number.
    fn parse<T: std::str::FromStr>(
        &mut self,
        wanted: &'static str,
    ) -> Result<(usize, &'a [u8], T), NewellError> {
        let Some((at, word)) = self.next() else {
            return Err(self.error(self.bytes.len(), NewellErrorKind::End(wanted)));
        };
        match std::str::from_utf8(word).ok().and_then(|text| text.parse().ok()) {
            Some(value) => Ok((at, word, value)),
            None => Err(self.error(at, NewellErrorKind::Number { found: quoted(word), wanted })),
        }
    }

    fn number(&mut self, wanted: &'static str) -> Result<u32, NewellError> {
        self.parse(wanted).map(|(_, _, value)| value)
    }

    /// Number of items of the given size that follow; an error if the file cannot contain them.
    fn count(
        &mut self,
        what: &'static str,
        wanted: &'static str,
        numbers: usize,
    ) -> Result<u32, NewellError> {
        let (at, _, count) = self.parse::<u32>(wanted)?;
        let bytes = self.bytes.len().saturating_sub(self.offset);
        // A number has at least a digit and a separator.
        if (count as usize).saturating_mul(2 * numbers) > bytes {
            return Err(self.error(at, NewellErrorKind::Count { what, count, bytes }));
        }
        Ok(count)
    }

    fn coordinate(&mut self) -> Result<f64, NewellError> {
        let (at, word, value) = self.parse::<f64>("a coordinate")?;
        if value.is_finite() {
            return Ok(value);
        }
        Err(self.error(at, NewellErrorKind::NotFinite(quoted(word))))
    }

    /// An error at the word `index` words ahead.
    fn error_at_word(mut self, index: usize, kind: NewellErrorKind) -> NewellError {
        let mut at = self.offset;
        for _ in 0..=index {
            if let Some((start, _)) = self.next() {
                at = start;
            }
        }
        self.error(at, kind)
    }

    fn error(&self, at: usize, kind: NewellErrorKind) -> NewellError {
        let (line, column) = line_and_column(self.bytes, at);
        NewellError { line, column, kind }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two patches on seventeen points (i, i / 2, -i); the second begins with the last point.
    fn text() -> String {
        let first: Vec<String> = (1..=16).map(|i| i.to_string()).collect();
        let second: Vec<String> = [17].into_iter().chain(1..=15).map(|i| i.to_string()).collect();
        let points: Vec<String> = (0..17).map(|i| format!("{i}.0,{},-{i}e0", 0.5 * f64::from(i))).collect();
        format!("2\r\n{}\r\n{}\r\n17\r\n{}\r\n", first.join(","), second.join(", "), points.join("\r\n"))
    }

    #[test]
    fn indices_start_at_one_in_the_file_and_at_zero_in_memory() {
        let mesh = read(text().as_bytes()).unwrap();
        assert_eq!(mesh.patches[0], std::array::from_fn(|i| i as u32));
        assert_eq!(mesh.patches[1], std::array::from_fn(|i| if i == 0 { 16 } else { i as u32 - 1 }));
        assert_eq!(mesh.positions.len(), 17);
        assert_eq!(mesh.positions[3], DVec3::new(3.0, 1.5, -3.0));
    }

    #[test]
    fn empty_lists_are_valid() {
        assert_eq!(read(b"0 0").unwrap(), NewellMesh::default());
    }

    #[test]
    fn errors_have_line_and_column() {
        let text = text();
        let replaced = |from: &str, to: &str| text.replacen(from, to, 1);
        for (text, message) in [
            (String::new(), "1:1: the file ends before the number of patches"),
            ("two".to_owned(), "1:1: expected the number of patches, found \"two\""),
            ("-1".to_owned(), "1:1: expected the number of patches, found \"-1\""),
            ("1\n1,2".to_owned(), "1:1: 1 patches are declared; the file has 4 bytes left for them"),
            (replaced("4,5,", "4,5.5,"), "2:9: expected the index of a control point, found \"5.5\""),
            (replaced("4,5,", "4,18,"), "2:9: patch 1 refers to point 18; there are 17, counted from 1"),
            (replaced("17, 1,", "17, 0,"), "3:5: patch 2 refers to point 0; there are 17, counted from 1"),
            (
                replaced("17\r\n", "1000000\r\n"),
                "4:1: 1000000 points are declared; the file has 236 bytes left for them",
            ),
            (replaced("3.0,1.5,", "3.0,x,"), "8:5: expected a coordinate, found \"x\""),
            (replaced("3.0,1.5,", "3.0,inf,"), "8:5: \"inf\" is not finite"),
            (replaced("3.0,1.5,", "3.0,1e999,"), "8:5: \"1e999\" is not finite"),
            (format!("{text}7"), "22:1: \"7\" follows the last point"),
            (text.trim_end().trim_end_matches("-16e0").to_owned(), "21:8: the file ends before a coordinate"),
        ] {
            assert_eq!(read(text.as_bytes()).unwrap_err().to_string(), message);
        }
    }
}
