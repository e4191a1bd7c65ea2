//! Surfaces from RenderMan's scene files (RIB), text only.
//!
//! Supported are `Patch`, `PatchMesh` and `NuPatch`, `Basis`, the blocks `...Begin` and `...End`, `ReverseOrientation` and the
//! affine transformations; surfaces are in the frame of the whole file. All other requests are skipped and
//! reported, except those that would move surfaces, which are errors. Memory is bounded by the size of the input.
//!
//! ```
//! let text = r#"
//!     TransformBegin
//!     Translate 0 0 5
//!     Patch "bilinear" "P" [0 0 0  1 0 0  0 1 0  1 1 1]
//!     TransformEnd
//!     Color [1 0 0]
//! "#;
//! let file = glanz_formats::rib::read(text.as_bytes())?;
//! assert_eq!((file.patches[0].degree_u, file.patches[0].degree_v), (1, 1));
//! // Points of equal u side by side.
//! assert_eq!(file.patches[0].patches[0][3], [1.0, 1.0, 6.0, 1.0]);
//! assert_eq!(file.skipped[0].name, "Color");
//! # Ok::<(), glanz_formats::rib::RibError>(())
//! ```
//!
//! # Source
//! @renderman2000 sections 4 (attributes and transformations) and 5 (geometric primitives), appendix C (language binding
//! details).

mod error;
mod lexer;
mod state;
mod surface;
#[cfg(test)]
mod tests;

use glanz_job::ResourceBudget;
use glanz_math::{DMat4, DVec3};
use glanz_scene::description::{BezierPatchesDescription, NurbsDescription};

pub use error::{RibError, RibErrorKind};
pub use state::MAX_DEPTH;

use crate::source::line_and_column;
use lexer::{RibLexer, RibRequest, RibValue};
use state::{PatchBasis, RibBlock, RibState, rotation};

/// The surfaces of a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RibFile {
    /// Patches, grouped by degrees in the order of the first patch of each group.
    pub patches: Vec<BezierPatchesDescription>,
    /// Splines of `NuPatch`.
    pub splines: Vec<NurbsDescription>,
    /// Skipped requests, each kind with its first position.
    pub skipped: Vec<SkippedRequest>,
}

/// A kind of skipped request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SkippedRequest {
    /// Its name.
    pub name: String,
    /// Line of the first one, from 1.
    pub line: u32,
    /// Column in bytes, from 1.
    pub column: u32,
}

/// Whether a file of surfaces is RIB: it starts with a letter or a comment.
#[must_use]
pub fn is_rib(bytes: &[u8]) -> bool {
    let first = bytes.iter().find(|b| !b.is_ascii_whitespace());
    first.is_some_and(|b| b.is_ascii_alphabetic() || *b == b'#' || *b >= 0x80)
}

/// Requests that RIB has and pbrt's language does not.
const RIB_REQUESTS: [&[u8]; 4] = [b"Patch", b"PatchMesh", b"NuPatch", b"Basis"];

/// Directives that pbrt's language has and RIB does not.
const PBRT_DIRECTIVES: [&[u8]; 9] =
    [b"Shape", b"LookAt", b"Camera", b"Film", b"Sampler", b"Integrator", b"Material", b"Texture", b"Include"];

/// Whether a text is RIB with surfaces, and not pbrt's scene language: the first word that only one of them has decides.
pub(crate) fn has_surface(bytes: &[u8]) -> bool {
    let mut rest = bytes;
    while let Some((&first, after)) = rest.split_first() {
        let until = |end: u8| after.iter().position(|&b| b == end).map_or(after.len(), |i| i + 1);
        let length = match first {
            b'"' => 1 + until(b'"'),
            b'#' => 1 + until(b'\n'),
            _ if first.is_ascii_alphabetic() => {
                let length = rest.iter().position(|b| !b.is_ascii_alphanumeric()).unwrap_or(rest.len());
                let word = rest.get(..length).unwrap_or_default();
                if RIB_REQUESTS.contains(&word) || PBRT_DIRECTIVES.contains(&word) {
                    return RIB_REQUESTS.contains(&word);
                }
                length
            }
            _ => 1,
        };
        rest = rest.get(length..).unwrap_or_default();
    }
    false
}

/// Reads the surfaces of a file from its bytes.
///
/// # Errors
/// [`RibError`] with the place in the file.
pub fn read(bytes: &[u8]) -> Result<RibFile, RibError> {
    read_with(bytes, &ResourceBudget::default())
}

/// Bytes for each byte of a file: of a number such as `0`, eight in a list that grows, and a part of a point of 32.
const MEMORY_PER_BYTE: u64 = 24;

/// As [`read`] within a budget.
///
/// # Errors
/// [`RibError`] with the place in the file.
pub fn read_with(bytes: &[u8], budget: &ResourceBudget) -> Result<RibFile, RibError> {
    let mut lexer = RibLexer::new(bytes, budget);
    let needed = MEMORY_PER_BYTE.saturating_mul(bytes.len() as u64);
    let _reserved = budget.reserve(needed).map_err(|end| lexer.error(0, end.into()))?;
    let mut reader = RibReader {
        places: lexer.clone(),
        state: RibState::default(),
        open: Vec::new(),
        file: RibFile::default(),
    };
    while let Some(request) = lexer.request()? {
        reader.apply(&request, bytes)?;
    }
    match reader.open.last() {
        Some(block) => Err(lexer.error(block.at, RibErrorKind::OpenBlock(block.name))),
        None => Ok(reader.file),
    }
}

/// Largest number of reported kinds of skipped requests; there are about a hundred requests in all.
const MAX_SKIPPED: usize = 200;

/// Names of blocks, without `Begin` and `End`.
const BLOCKS: [&str; 4] = ["Transform", "Attribute", "World", "Frame"];

/// State of the reader.
struct RibReader<'a> {
    /// The text, for the positions of errors.
    places: RibLexer<'a>,
    state: RibState,
    open: Vec<RibBlock>,
    file: RibFile,
}

impl RibReader<'_> {
    fn apply(&mut self, request: &RibRequest<'_>, bytes: &[u8]) -> Result<(), RibError> {
        let block = |end: &str| BLOCKS.into_iter().find(|b| request.name.strip_suffix(end) == Some(b));
        if let Some(name) = block("Begin") {
            return self.begin(name, request.at);
        }
        if let Some(name) = block("End") {
            return self.end(name, request.at);
        }
        match request.name {
            "Identity" => self.state.to_world = DMat4::IDENTITY,
            "Transform" => self.state.to_world = self.matrix(request)?,
            "ConcatTransform" => {
                let matrix = self.matrix(request)?;
                self.state.concatenate(matrix);
            }
            "Translate" => {
                let by = DVec3::from_array(self.numbers(request)?);
                self.state.concatenate(DMat4::from_translation(by));
            }
            "Scale" => {
                let [x, y, z] = self.numbers(request)?;
                self.state.concatenate(DMat4::from_diagonal(DVec3::new(x, y, z).extend(1.0)));
            }
            "Rotate" => {
                let [degrees, x, y, z] = self.numbers(request)?;
                self.state.concatenate(rotation(degrees, DVec3::new(x, y, z)));
            }
            "ReverseOrientation" => self.state.reversed = !self.state.reversed,
            "Basis" => self.state.bases = self.bases(request)?,
            "Patch" => self.patch(request)?,
            "PatchMesh" => self.patch_mesh(request)?,
            "NuPatch" => self.nu_patch(request)?,
            // No effect on surfaces.
            "version" => {}
            "MotionBegin" | "ObjectBegin" | "SolidBegin" => {
                let kind = RibErrorKind::Unsupported(request.name.to_owned());
                return Err(self.places.error(request.at, kind));
            }
            name => self.skip(name, request.at, bytes),
        }
        Ok(())
    }

    fn begin(&mut self, name: &'static str, at: usize) -> Result<(), RibError> {
        if self.open.len() >= MAX_DEPTH {
            return Err(self.places.error(at, RibErrorKind::TooDeep));
        }
        self.open.push(RibBlock { name, at, outside: self.state });
        if name == "World" {
            // Earlier transformations place the camera.
            self.state.to_world = DMat4::IDENTITY;
        }
        Ok(())
    }

    fn end(&mut self, name: &'static str, at: usize) -> Result<(), RibError> {
        match self.open.pop() {
            Some(block) if block.name == name => {
                if name == "Transform" {
                    self.state.to_world = block.outside.to_world;
                } else {
                    self.state = block.outside;
                }
                Ok(())
            }
            open => {
                let kind = RibErrorKind::StrayEnd { name, open: open.map(|block| block.name) };
                Err(self.places.error(at, kind))
            }
        }
    }

    fn skip(&mut self, name: &str, at: usize, bytes: &[u8]) {
        let skipped = &mut self.file.skipped;
        if skipped.len() < MAX_SKIPPED && !skipped.iter().any(|s| s.name == name) {
            let (line, column) = line_and_column(bytes, at);
            let name = name.chars().take(lexer::QUOTED).collect();
            skipped.push(SkippedRequest { name, line, column });
        }
    }

    /// The numbers a request must have, with brackets or without.
    fn numbers<const N: usize>(&self, request: &RibRequest<'_>) -> Result<[f64; N], RibError> {
        let mut all = Vec::new();
        for argument in &request.arguments {
            match &argument.value {
                RibValue::Number(x) => all.push(*x),
                RibValue::Numbers(numbers) => all.extend_from_slice(numbers),
                _ => {
                    let kind =
                        RibErrorKind::RibArgument { request: request.name.to_owned(), wanted: "a number" };
                    return Err(self.places.error(argument.at, kind));
                }
            }
        }
        let found = all.len();
        <[f64; N]>::try_from(all).map_err(|_| {
            let request_name = request.name.to_owned();
            let kind = RibErrorKind::Count { request: request_name, what: "numbers", found, needed: N };
            self.places.error(request.at, kind)
        })
    }

    fn matrix(&self, request: &RibRequest<'_>) -> Result<DMat4, RibError> {
        // RIB multiplies row vectors by matrices; here the transposed matrix is multiplied by columns.
        let matrix = DMat4::from_cols_array(&self.numbers(request)?);
        let bottom = matrix.row(3).to_array();
        if bottom == [0.0, 0.0, 0.0, 1.0] {
            return Ok(matrix);
        }
        Err(self.places.error(request.at, RibErrorKind::NotAffine(bottom)))
    }

    /// The bases along u and v: a name or a matrix, then a step, twice.
    fn bases(&self, request: &RibRequest<'_>) -> Result<[PatchBasis; 2], RibError> {
        let wrong = |at: usize, wanted: &'static str| {
            self.places.error(at, RibErrorKind::RibArgument { request: request.name.to_owned(), wanted })
        };
        let mut bases = self.state.bases;
        for (axis, basis) in bases.iter_mut().enumerate() {
            let argument = |i: usize| request.arguments.get(2 * axis + i);
            let Some(kind) = argument(0) else { return Err(wrong(request.at, "two bases with their steps")) };
            *basis = match &kind.value {
                RibValue::Text(name) => PatchBasis::by_name(name),
                RibValue::Numbers(numbers) => <[f64; 16]>::try_from(numbers.as_slice()).ok().map(|m| {
                    PatchBasis::of_matrix(std::array::from_fn(|i| std::array::from_fn(|j| m[4 * i + j])))
                }),
                _ => None,
            }
            .ok_or_else(|| wrong(kind.at, state::BASIS_NAMES))?;
            let step = argument(1).map(|a| (a.at, &a.value));
            basis.step = match step {
                Some((_, RibValue::Number(x))) if (1.0..=4.0).contains(x) && x.fract() == 0.0 => *x as usize,
                other => return Err(wrong(other.map_or(request.at, |o| o.0), "a step from 1 to 4")),
            };
        }
        Ok(bases)
    }
}
