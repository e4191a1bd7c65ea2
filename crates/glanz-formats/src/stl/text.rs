//! Texts: `solid`, facets with three corners each, `endsolid`; in lower or upper case.

use glanz_job::ResourceBudget;
use glanz_math::DVec3;

use super::{FacetCollector, StlError, StlErrorKind, StlMesh};
use crate::source::{line_and_column, shortened};

/// Bytes at the start of a text in which the first facet or the end of the solid is looked for.
const HEAD: usize = 4096;

/// Whether the bytes are a text: `solid`, and then facets or the end.
pub(super) fn is_text(bytes: &[u8]) -> bool {
    let mut words = Words::new(bytes.get(..bytes.len().min(HEAD)).unwrap_or_default());
    let starts = words.next().is_some_and(|word| word.is("solid"));
    words.skip_line();
    starts && words.next().is_some_and(|word| word.is("facet") || word.is("endsolid"))
}

/// The words of a text, separated by blanks.
struct Words<'a> {
    bytes: &'a [u8],
    at: usize,
}

#[derive(Clone, Copy)]
struct StlWord<'a> {
    text: &'a [u8],
    at: usize,
}

impl StlWord<'_> {
    fn is(&self, word: &str) -> bool {
        self.text.eq_ignore_ascii_case(word.as_bytes())
    }

    fn shown(&self) -> String {
        shortened(&String::from_utf8_lossy(self.text))
    }
}

impl<'a> Words<'a> {
    fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0 }
    }

    fn skip_line(&mut self) {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        self.at += rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
    }

    fn error(&self, at: usize, kind: StlErrorKind) -> StlError {
        StlError { place: Some(line_and_column(self.bytes, at)), kind }
    }

    fn needed(&mut self) -> Result<StlWord<'a>, StlError> {
        let word = self.next();
        word.ok_or_else(|| self.error(self.bytes.trim_ascii_end().len(), StlErrorKind::End))
    }

    /// Takes these words.
    fn require(&mut self, words: &[&'static str]) -> Result<(), StlError> {
        for &needed in words {
            let word = self.needed()?;
            if !word.is(needed) {
                return Err(self.error(word.at, StlErrorKind::Word { found: word.shown(), needed }));
            }
        }
        Ok(())
    }

    fn vector(&mut self) -> Result<DVec3, StlError> {
        let mut vector = DVec3::ZERO;
        for axis in 0..3 {
            let word = self.needed()?;
            let number = std::str::from_utf8(word.text).ok().and_then(|text| text.parse().ok());
            vector[axis] = number
                .filter(|x: &f64| x.is_finite())
                .ok_or_else(|| self.error(word.at, StlErrorKind::Number(word.shown())))?;
        }
        Ok(vector)
    }
}

impl<'a> Iterator for Words<'a> {
    type Item = StlWord<'a>;

    fn next(&mut self) -> Option<StlWord<'a>> {
        let rest = self.bytes.get(self.at..)?;
        let start = rest.iter().position(|b| !b.is_ascii_whitespace())?;
        let rest = rest.get(start..)?;
        let length = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        let at = self.at + start;
        self.at = at + length;
        Some(StlWord { text: rest.get(..length)?, at })
    }
}

/// Reads a text.
pub(super) fn read(bytes: &[u8], budget: &ResourceBudget) -> Result<StlMesh, StlError> {
    let mut words = Words::new(bytes);
    let mut facets = FacetCollector::new(budget);
    while let Some(word) = words.next() {
        if !word.is("solid") {
            return Err(words.error(word.at, StlErrorKind::Word { found: word.shown(), needed: "solid" }));
        }
        words.skip_line();
        loop {
            let word = words.needed()?;
            if word.is("endsolid") {
                words.skip_line();
                break;
            }
            if !word.is("facet") {
                let needed = "facet\" or \"endsolid";
                return Err(words.error(word.at, StlErrorKind::Word { found: word.shown(), needed }));
            }
            // Exporters write normals of facets without an area as NaN.
            words.require(&["normal"])?;
            (0..3).try_for_each(|_| words.needed().map(|_| ()))?;
            words.require(&["outer", "loop"])?;
            let mut corners = [DVec3::ZERO; 3];
            for corner in &mut corners {
                words.require(&["vertex"])?;
                *corner = words.vector()?;
            }
            words.require(&["endloop", "endfacet"])?;
            facets.add(corners).map_err(|kind| words.error(word.at, kind))?;
        }
    }
    Ok(facets.mesh)
}
