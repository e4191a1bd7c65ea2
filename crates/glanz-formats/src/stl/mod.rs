//! Triangles in STL files (@stl1988), as text and binary.
//!
//! A file has no vertices that triangles share: equal corners become one vertex. Normals of facets are ignored, since they are those of the
//! corners; so are attributes of binary facets. All solids of a text make one mesh. The format has no unit.

mod binary;
mod text;

use std::collections::HashMap;

use glanz_job::{BudgetError, ResourceBudget};
use glanz_math::DVec3;

use crate::growing_memory::GrowingReservation;

/// A mesh from a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StlMesh {
    /// Vertices, all different.
    pub positions: Vec<DVec3>,
    /// Corners of the triangles, counterclockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

/// Error of reading an STL file.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{kind}")]
pub struct StlError {
    /// Line and column in bytes, from 1, of a text.
    pub place: Option<(u32, u32)>,
    /// Kind.
    pub kind: StlErrorKind,
}

/// Kinds of errors of STL files.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum StlErrorKind {
    /// Another word than the format allows here.
    #[error("{found:?} is not expected here; the format needs \"{needed}\"")]
    Word {
        /// The word.
        found: String,
        /// The words that are allowed.
        needed: &'static str,
    },
    /// The text ends within a solid.
    #[error("the file ends within a solid; it may be incomplete")]
    End,
    /// Text that is not a finite number.
    #[error("{0:?} is not a finite number")]
    Number(String),
    /// A coordinate that is infinite or not a number.
    #[error("a corner of facet {0} is not finite")]
    NotFinite(u32),
    /// Fewer facets than the header declares.
    #[error("the file has {bytes} bytes for {declared} facets, which need {needed}; it may be incomplete")]
    Size {
        /// Facets by the header.
        declared: u32,
        /// Bytes of the file.
        bytes: usize,
        /// Bytes of a file with so many facets.
        needed: u64,
    },
    /// More vertices than 32 bits can number.
    #[error("the file has more than 2^32 vertices")]
    TooMany,
    /// The budget of reading is used up.
    #[error(transparent)]
    Budget(#[from] BudgetError),
}

impl StlErrorKind {
    /// The same without a place in a text.
    fn of_file(self) -> StlError {
        StlError { place: None, kind: self }
    }
}

/// Whether the bytes are an STL file: a binary one, by its size, or a text.
pub(crate) fn is_stl(bytes: &[u8]) -> bool {
    binary::has_exact_size(bytes) || text::is_text(bytes)
}

/// Whether a file of `length` bytes that begins with `head` is a binary one, by its size.
pub(crate) fn is_binary_stl(head: &[u8], length: u64) -> bool {
    binary::has_size(head, length)
}

/// Reads the bytes of a file.
///
/// # Errors
/// [`StlError`] with its place.
pub fn read(bytes: &[u8]) -> Result<StlMesh, StlError> {
    read_with(bytes, &ResourceBudget::default())
}

/// Bytes of a vertex with its entry in a table, and of a triangle, in lists that grow.
const BYTES_PER_VERTEX: u64 = 190;
const BYTES_PER_TRIANGLE: u64 = 36;

/// As [`read`] within a budget.
///
/// # Errors
/// [`StlError`] with its place.
pub fn read_with(bytes: &[u8], budget: &ResourceBudget) -> Result<StlMesh, StlError> {
    if binary::has_exact_size(bytes) || !text::is_text(bytes) {
        binary::read(bytes, budget)
    } else {
        text::read(bytes, budget)
    }
}

/// A mesh that is read facet by facet.
struct FacetCollector<'a> {
    budget: &'a ResourceBudget,
    mesh: StlMesh,
    /// Vertices by the bits of their coordinates.
    known: HashMap<[u64; 3], u32>,
    memory: GrowingReservation,
}

impl<'a> FacetCollector<'a> {
    fn new(budget: &'a ResourceBudget) -> Self {
        Self {
            budget,
            mesh: StlMesh::default(),
            known: HashMap::new(),
            memory: GrowingReservation::new(budget),
        }
    }

    fn add(&mut self, corners: [DVec3; 3]) -> Result<(), StlErrorKind> {
        self.budget.check()?;
        // With those of this facet.
        let vertices = self.mesh.positions.len() as u64 + 3;
        let triangles = self.mesh.triangles.len() as u64 + 1;
        self.memory.reach(BYTES_PER_VERTEX * vertices + BYTES_PER_TRIANGLE * triangles)?;
        let mut triangle = [0; 3];
        for (index, corner) in triangle.iter_mut().zip(corners) {
            // Both zeros are one.
            let corner = corner + 0.0;
            let next = u32::try_from(self.mesh.positions.len()).map_err(|_| StlErrorKind::TooMany)?;
            *index = *self.known.entry(corner.to_array().map(f64::to_bits)).or_insert(next);
            if *index == next {
                self.mesh.positions.push(corner);
            }
        }
        self.mesh.triangles.push(triangle);
        Ok(())
    }
}

#[cfg(test)]
mod tests;
