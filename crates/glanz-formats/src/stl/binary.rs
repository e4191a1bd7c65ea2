//! Binary files: a header of 80 bytes, the number of facets, and 50 bytes for each.

use glanz_job::ResourceBudget;
use glanz_math::DVec3;

use super::{FacetCollector, StlError, StlErrorKind, StlMesh};

/// Bytes before the first facet.
const START: usize = 84;

/// Bytes of a facet: normal, three corners, and two bytes without a common meaning.
const FACET: usize = 50;

/// The number of facets by the header, and the size of a file with so many.
fn declared(bytes: &[u8]) -> Option<(u32, u64)> {
    let count = u32::from_le_bytes(*bytes.get(80..START)?.first_chunk()?);
    Some((count, START as u64 + FACET as u64 * u64::from(count)))
}

/// Whether the file has exactly the size of a binary file with facets.
pub(super) fn has_exact_size(bytes: &[u8]) -> bool {
    has_size(bytes, bytes.len() as u64)
}

/// As above, of the beginning of a file of `length` bytes.
pub(super) fn has_size(head: &[u8], length: u64) -> bool {
    declared(head).is_some_and(|(count, size)| count > 0 && size == length)
}

/// Reads a file; bytes after the last facet are ignored.
pub(super) fn read(bytes: &[u8], budget: &ResourceBudget) -> Result<StlMesh, StlError> {
    let (count, needed) = declared(bytes).unwrap_or((0, START as u64));
    if (bytes.len() as u64) < needed {
        let kind = StlErrorKind::Size { declared: count, bytes: bytes.len(), needed };
        return Err(kind.of_file());
    }
    let mut facets = FacetCollector::new(budget);
    let rest = bytes.get(START..).unwrap_or_default();
    for (number, facet) in (0..count).zip(rest.chunks_exact(FACET)) {
        let coordinate = |i: usize| {
            let four = facet.get(4 * i..).and_then(|rest| rest.first_chunk()).copied().unwrap_or_default();
            f64::from(f32::from_le_bytes(four))
        };
        let corners = [3, 6, 9].map(|i| DVec3::new(coordinate(i), coordinate(i + 1), coordinate(i + 2)));
        if !corners.iter().all(|corner| corner.is_finite()) {
            return Err(StlErrorKind::NotFinite(number).of_file());
        }
        facets.add(corners).map_err(StlErrorKind::of_file)?;
    }
    Ok(facets.mesh)
}
