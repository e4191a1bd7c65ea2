//! Meshes in Stanford's PLY format: ascii, little and big endian binary.
//!
//! Supported are vertices (`x y z`, `nx ny nz`, and `u v`, `s t`, `texture_u texture_v` or `texture_s texture_t`), faces of
//! any number of corners (list `vertex_indices` or `vertex_index`, divided into fans of triangles) and `tristrips`. Other
//! elements and properties are skipped. Memory is bounded by the size of the input: counts that exceed the data
//! are refused before anything is allocated.
//!
//! # Source
//! @turk1994.

mod body;
mod header;

use glanz_job::{BudgetError, ResourceBudget};
use glanz_math::{DVec2, DVec3};

/// A mesh from a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlyMesh {
    /// Vertices.
    pub positions: Vec<DVec3>,
    /// One per vertex.
    pub normals: Option<Vec<DVec3>>,
    /// One per vertex.
    pub uvs: Option<Vec<DVec2>>,
    /// Corners of the triangles.
    pub triangles: Vec<[u32; 3]>,
    /// Number of faces with fewer than three corners, which were left out.
    pub skipped_faces: usize,
}

/// Position of an error in the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlyPosition {
    /// Line and column of text, from 1.
    Text {
        /// Line.
        line: u32,
        /// Column in bytes.
        column: u32,
    },
    /// Offset in bytes from the start of the file.
    Byte(usize),
}

impl std::fmt::Display for PlyPosition {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Text { line, column } => write!(f, "{line}:{column}"),
            Self::Byte(offset) => write!(f, "byte {offset}"),
        }
    }
}

/// Error of reading a PLY mesh.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{position}: {kind}")]
pub struct PlyError {
    /// Position.
    pub position: PlyPosition,
    /// Kind.
    pub kind: PlyErrorKind,
}

/// Kinds of errors of PLY files.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PlyErrorKind {
    /// The first line is not `ply`.
    #[error("not a PLY file: it does not begin with \"ply\"")]
    Magic,
    /// An invalid header line.
    #[error("the header line {0:?} is not understood")]
    HeaderLine(String),
    /// A format other than ascii or binary of version 1.0.
    #[error("the format {0:?} is not known")]
    Format(String),
    /// The file ends within the header.
    #[error("the file ends before \"end_header\"")]
    HeaderEnd,
    /// More elements than the rest of the file can contain.
    #[error("{count} elements \"{element}\" are declared; the file has {bytes} bytes left for them")]
    Count {
        /// Name of the element.
        element: String,
        /// Declared number.
        count: u64,
        /// Bytes left.
        bytes: usize,
    },
    /// The vertices have no coordinates.
    #[error("element \"vertex\" has no property \"{0}\"")]
    Coordinate(&'static str),
    /// A required element is missing.
    #[error("there is no element \"{0}\"")]
    PlyElement(&'static str),
    /// The file ends within an element.
    #[error("the file ends within element \"{element}\" number {index}")]
    Truncated {
        /// Name of the element.
        element: String,
        /// Counted from 0.
        index: u64,
    },
    /// Text that is not a number.
    #[error("{0:?} is not a number")]
    Number(String),
    /// A list with an invalid number of entries.
    #[error("a list of {0} entries")]
    ListLength(f64),
    /// A coordinate that is infinite or not a number.
    #[error("vertex {0} is not finite")]
    NotFinite(u64),
    /// A face refers to a vertex that does not exist.
    #[error("element \"{element}\" number {face} refers to vertex {index}; there are {count}")]
    Index {
        /// Name of the element.
        element: String,
        /// Counted from 0.
        face: u64,
        /// The referenced item.
        index: u32,
        /// Number of vertices.
        count: usize,
    },
    /// A face refers to a value that is not an index.
    #[error("element \"{element}\" number {face} refers to vertex {value}, which is not an index")]
    NotAnIndex {
        /// Name of the element.
        element: String,
        /// Counted from 0.
        face: u64,
        /// The referenced item.
        value: f64,
    },
    /// More vertices than 32 bits can number.
    #[error("{0} vertices are too many")]
    TooMany(u64),
    /// The budget of reading is used up.
    #[error(transparent)]
    Budget(#[from] BudgetError),
}

/// Reads a mesh from the bytes of a file.
///
/// # Errors
/// [`PlyError`] with the place in the file.
pub fn read(bytes: &[u8]) -> Result<PlyMesh, PlyError> {
    read_with(bytes, &ResourceBudget::default())
}

/// As [`read`] within a budget.
///
/// # Errors
/// [`PlyError`] with the place in the file.
pub fn read_with(bytes: &[u8], budget: &ResourceBudget) -> Result<PlyMesh, PlyError> {
    let header = header::parse(bytes)?;
    body::read(bytes, &header, budget)
}

#[cfg(test)]
mod tests {
    use glanz_job::{CancelFlag, ResourceLimits};

    use super::*;

    const ASCII: &str = "ply\nformat ascii 1.0\ncomment a square\nelement vertex 4\nproperty float x\nproperty float y\n\
        property float z\nproperty uchar red\nproperty float s\nproperty float t\nelement face 1\n\
        property uchar flag\nproperty list uchar int vertex_index\nelement note 2\nproperty int a\nend_header\n\
        0 0 0 255 0 0\n1 0 0 255 1 0\n1 1 0 255 1 1\n0 1 0 255 0 1\n7 4 0 1 2 3\n1\n2\n";

    #[test]
    fn memory_is_reserved_for_the_triangles_that_are_made() {
        let faces = 10_000;
        let mut bytes = format!(
            "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty uchar x\nproperty uchar y\nproperty uchar z\n\
             element face {faces}\nproperty list uchar uchar vertex_indices\nend_header\n"
        )
        .into_bytes();
        bytes.extend([0, 0, 0, 1, 0, 0, 0, 1, 0]);
        (0..faces).for_each(|_| bytes.extend([3, 0, 1, 2]));
        let within = |memory| {
            let limits = ResourceLimits { memory, ..ResourceLimits::default() };
            read_with(&bytes, &ResourceBudget::new(limits, CancelFlag::default()))
        };
        // 36 bytes for each of 10 000 triangles, of a file of 40 kB.
        assert!(matches!(within(300_000), Err(PlyError { kind: PlyErrorKind::Budget(_), .. })));
        assert_eq!(within(600_000).unwrap().triangles.len(), faces);
    }

    fn binary(big: bool) -> Vec<u8> {
        let name = if big { "binary_big_endian" } else { "binary_little_endian" };
        let mut out = format!(
            "ply\r\nformat {name} 1.0\r\nelement vertex 3\r\nproperty double x\r\nproperty float y\r\nproperty short z\r\n\
             property list uchar ushort extra\r\nproperty float nx\r\nproperty float ny\r\nproperty float nz\r\n\
             element face 2\r\nproperty list ushort uint vertex_indices\r\nproperty uchar c\r\nend_header\r\n"
        )
        .into_bytes();
        macro_rules! put {
            ($v:expr) => {
                out.extend(if big { $v.to_be_bytes().to_vec() } else { $v.to_le_bytes().to_vec() })
            };
        }
        for (i, (x, y, z)) in [(0.5f64, 0.25f32, -3i16), (1.0, 0.0, 2), (0.0, 1.0, 0)].into_iter().enumerate()
        {
            put!(x);
            put!(y);
            put!(z);
            out.push(i as u8);
            for k in 0..i as u16 {
                put!(k);
            }
            put!(0f32);
            put!(0f32);
            put!(1f32);
        }
        put!(3u16);
        for i in [0u32, 1, 2] {
            put!(i);
        }
        out.push(9);
        put!(2u16);
        for i in [0u32, 1] {
            put!(i);
        }
        out.push(9);
        out
    }

    #[test]
    fn ascii_square_becomes_two_triangles_and_other_properties_are_skipped() {
        let mesh = read(ASCII.as_bytes()).unwrap();
        assert_eq!(mesh.positions[2], DVec3::new(1.0, 1.0, 0.0));
        assert_eq!(mesh.uvs.unwrap()[3], DVec2::new(0.0, 1.0));
        assert_eq!(mesh.normals, None);
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
    }

    #[test]
    fn both_byte_orders_give_the_same_mesh() {
        let mesh = read(&binary(false)).unwrap();
        assert_eq!(mesh, read(&binary(true)).unwrap());
        assert_eq!(mesh.positions, [DVec3::new(0.5, 0.25, -3.0), DVec3::new(1.0, 0.0, 2.0), DVec3::Y]);
        assert_eq!(mesh.normals.unwrap(), [DVec3::Z; 3]);
        assert_eq!(mesh.triangles, [[0, 1, 2]]);
        assert_eq!(mesh.skipped_faces, 1);
    }

    #[test]
    fn strips_alternate_their_orientation_and_restart_at_minus_one() {
        let text = "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n\
            element tristrips 1\nproperty list int int vertex_indices\nend_header\n\
            0 0 0 1 0 0 0 1 0 1 1 0 2 2 0\n8 0 1 2 3 -1 2 3 4\n";
        assert_eq!(read(text.as_bytes()).unwrap().triangles, [[0, 1, 2], [2, 1, 3], [2, 3, 4]]);
    }

    #[test]
    fn errors_have_their_position() {
        let replaced = |from: &str, to: &str| ASCII.replacen(from, to, 1).into_bytes();
        for (bytes, message) in [
            (b"plx\n".to_vec(), "1:1: not a PLY file: it does not begin with \"ply\""),
            (replaced("ascii 1.0", "ascii 2.0"), "2:8: the format \"ascii 2.0\" is not known"),
            (
                replaced("property uchar red", "property octet red"),
                "8:1: the header line \"property octet red\" is not understood",
            ),
            (replaced("property float y\n", ""), "15:1: element \"vertex\" has no property \"y\""),
            (replaced("element vertex", "element vortex"), "17:1: there is no element \"vertex\""),
            (replaced("1 1 0 255", "1 l 0 255"), "19:3: \"l\" is not a number"),
            (replaced("1 1 0 255", "1 inf 0 255"), "19:3: \"inf\" is not a number"),
            (replaced("1 1 0 255", "1 1e400 0 255"), "19:18: vertex 2 is not finite"),
            (
                replaced("7 4 0 1 2 3", "7 4 0 1 2 4"),
                "21:12: element \"face\" number 0 refers to vertex 4; there are 4",
            ),
            (
                replaced("7 4 0 1 2 3", "7 4 0 1 2 -1"),
                "21:13: element \"face\" number 0 refers to vertex -1, which is not an index",
            ),
            (replaced("7 4 0 1 2 3", "7 -4 0 1 2 3"), "21:5: a list of -4 entries"),
            (replaced("7 4 0 1 2 3", "7 99 0 1 2 3"), "21:5: a list of 99 entries"),
            (
                replaced("element face 1\n", "element face 1000000000000\n"),
                "20:14: 1000000000000 elements \"face\" are declared; the file has 17 bytes left for them",
            ),
            (replaced("end_header", "end_heater"), "16:1: the header line \"end_heater\" is not understood"),
        ] {
            assert_eq!(read(&bytes).unwrap_err().to_string(), message);
        }
        let whole = binary(false);
        let body = whole.len() - 1;
        assert_eq!(
            read(&whole[..body]).unwrap_err().to_string(),
            format!("byte {body}: the file ends within element \"face\" number 1")
        );
    }

    #[test]
    fn counts_beyond_the_data_are_refused_before_allocation() {
        let text = "ply\nformat binary_little_endian 1.0\nelement vertex 18446744073709551615\nproperty float x\n\
            property float y\nproperty float z\nelement face 1\nproperty list uint int vertex_indices\nend_header\nxxxx";
        let error = read(text.as_bytes()).unwrap_err();
        assert!(matches!(error.kind, PlyErrorKind::Count { count: u64::MAX, .. }), "{error}");
        // Elements without properties have no bytes, so any number of them is accepted.
        let text = "ply\nformat ascii 1.0\nelement nothing 18446744073709551615\nelement vertex 0\nproperty float x\n\
            property float y\nproperty float z\nend_header\n";
        assert_eq!(read(text.as_bytes()).unwrap(), PlyMesh::default());
    }
}
