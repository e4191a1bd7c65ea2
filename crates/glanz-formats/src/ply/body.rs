//! Reading of the records of a PLY file.

use glanz_job::ResourceBudget;
use glanz_math::{DVec2, DVec3};

use super::header::{PlyElement, PlyEncoding, PlyHeader, ScalarType};
use super::{PlyError, PlyErrorKind, PlyMesh, PlyPosition};
use crate::growing_memory::GrowingReservation;

/// Bytes of a triangle in a list that grows: it is in the old list, and in one of twice the length.
const BYTES_PER_TRIANGLE: u64 = 36;

/// Bytes of a corner of the face being read, in such a list.
const BYTES_PER_CORNER: u64 = 12;

/// Cursor that reads successive numbers in any encoding.
struct PlyNumberReader<'a> {
    bytes: &'a [u8],
    offset: usize,
    encoding: PlyEncoding,
    line: u32,
    line_start: usize,
    budget: &'a ResourceBudget,
    memory: GrowingReservation,
    /// Bytes of the vertices so far.
    vertex_bytes: u64,
    /// Bytes of the triangles so far, and of the largest face.
    face_bytes: u64,
}

impl<'a> PlyNumberReader<'a> {
    fn remaining(&self) -> usize {
        self.bytes.len().saturating_sub(self.offset)
    }

    fn position(&self) -> PlyPosition {
        match self.encoding {
            PlyEncoding::Ascii => PlyPosition::Text {
                line: self.line,
                column: u32::try_from(self.offset - self.line_start + 1).unwrap_or(u32::MAX),
            },
            _ => PlyPosition::Byte(self.offset),
        }
    }

    fn error(&self, kind: PlyErrorKind) -> PlyError {
        PlyError { position: self.position(), kind }
    }

    /// Reserves the memory of vertices and triangles.
    fn reserve(&mut self) -> Result<(), PlyError> {
        let reached = self.memory.reach(self.vertex_bytes.saturating_add(self.face_bytes));
        reached.map_err(|end| self.error(end.into()))
    }

    /// The next number; `None` at the end of the file.
    fn number(&mut self, scalar: ScalarType) -> Result<Option<f64>, PlyError> {
        match self.encoding {
            PlyEncoding::Ascii => self.word(),
            PlyEncoding::LittleEndian => Ok(self.binary(scalar, false)),
            PlyEncoding::BigEndian => Ok(self.binary(scalar, true)),
        }
    }

    fn binary(&mut self, scalar: ScalarType, big: bool) -> Option<f64> {
        macro_rules! take {
            ($t:ty) => {{
                const SIZE: usize = size_of::<$t>();
                let raw: [u8; SIZE] = self.bytes.get(self.offset..self.offset + SIZE)?.try_into().ok()?;
                self.offset += SIZE;
                f64::from(if big { <$t>::from_be_bytes(raw) } else { <$t>::from_le_bytes(raw) })
            }};
        }
        Some(match scalar {
            ScalarType::I8 => take!(i8),
            ScalarType::U8 => take!(u8),
            ScalarType::I16 => take!(i16),
            ScalarType::U16 => take!(u16),
            ScalarType::I32 => take!(i32),
            ScalarType::U32 => take!(u32),
            ScalarType::F32 => take!(f32),
            ScalarType::F64 => take!(f64),
        })
    }

    fn word(&mut self) -> Result<Option<f64>, PlyError> {
        while let Some(&b) = self.bytes.get(self.offset) {
            if b == b'\n' {
                self.line = self.line.saturating_add(1);
                self.line_start = self.offset + 1;
            } else if !b.is_ascii_whitespace() {
                break;
            }
            self.offset += 1;
        }
        let rest = self.bytes.get(self.offset..).unwrap_or_default();
        let length = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        if length == 0 {
            return Ok(None);
        }
        let word = rest.get(..length).unwrap_or_default();
        let decimal = word.iter().all(|b| matches!(b, b'0'..=b'9' | b'.' | b'+' | b'-' | b'e' | b'E'));
        let value = std::str::from_utf8(word).ok().filter(|_| decimal).and_then(|w| w.parse().ok());
        let Some(value) = value else {
            let shown = String::from_utf8_lossy(word.get(..length.min(40)).unwrap_or_default());
            return Err(self.error(PlyErrorKind::Number(shown.into_owned())));
        };
        self.offset += length;
        Ok(Some(value))
    }
}

/// The records of one element being read.
struct RecordReader<'a, 'c> {
    cursor: &'c mut PlyNumberReader<'a>,
    element: &'c PlyElement,
}

impl<'a, 'c> RecordReader<'a, 'c> {
    /// Refuses counts for which the rest of the file has no room.
    fn new(cursor: &'c mut PlyNumberReader<'a>, element: &'c PlyElement) -> Result<Self, PlyError> {
        let size = element.min_size(cursor.encoding) as u128;
        let bytes = cursor.remaining();
        // One more byte: the blank that may be missing at the end of an ascii file.
        if u128::from(element.count) * size > bytes as u128 + 1 {
            let (element, count) = (element.name.clone(), element.count);
            return Err(cursor.error(PlyErrorKind::Count { element, count, bytes }));
        }
        Ok(Self { cursor, element })
    }

    fn number(&mut self, scalar: ScalarType, index: u64) -> Result<f64, PlyError> {
        self.cursor.budget.check().map_err(|end| self.cursor.error(end.into()))?;
        match self.cursor.number(scalar)? {
            Some(value) => Ok(value),
            None => {
                let element = self.element.name.clone();
                Err(self.cursor.error(PlyErrorKind::Truncated { element, index }))
            }
        }
    }

    /// The length of a list, checked against the rest of the file.
    fn length(&mut self, count: ScalarType, item: ScalarType, index: u64) -> Result<usize, PlyError> {
        let n = self.number(count, index)?;
        let item_size = match self.cursor.encoding {
            PlyEncoding::Ascii => 2,
            _ => item.size(),
        };
        if !(n >= 0.0 && n.fract() == 0.0) || n * item_size as f64 > self.cursor.remaining() as f64 + 1.0 {
            return Err(match self.cursor.encoding {
                PlyEncoding::Ascii => self.cursor.error(PlyErrorKind::ListLength(n)),
                _ if n >= 0.0 && n.fract() == 0.0 => {
                    let element = self.element.name.clone();
                    let position = PlyPosition::Byte(self.cursor.bytes.len());
                    PlyError { position, kind: PlyErrorKind::Truncated { element, index } }
                }
                _ => self.cursor.error(PlyErrorKind::ListLength(n)),
            });
        }
        Ok(n as usize)
    }

    fn skip(mut self) -> Result<(), PlyError> {
        let element = self.element;
        if element.properties.is_empty() {
            return Ok(());
        }
        for index in 0..element.count {
            for p in &element.properties {
                let n = match p.list {
                    Some(count) => self.length(count, p.scalar, index)?,
                    None => 1,
                };
                for _ in 0..n {
                    self.number(p.scalar, index)?;
                }
            }
        }
        Ok(())
    }
}

/// Reads everything after the header.
pub(super) fn read(bytes: &[u8], header: &PlyHeader, budget: &ResourceBudget) -> Result<PlyMesh, PlyError> {
    let mut cursor = PlyNumberReader {
        bytes,
        offset: header.body,
        encoding: header.encoding,
        line: header.line,
        line_start: header.body,
        budget,
        memory: GrowingReservation::new(budget),
        vertex_bytes: 0,
        face_bytes: 0,
    };
    if !header.elements.iter().any(|e| e.name == "vertex") {
        let position = PlyPosition::Text { line: header.line, column: 1 };
        return Err(PlyError { position, kind: PlyErrorKind::PlyElement("vertex") });
    }
    let mut mesh = PlyMesh::default();
    let mut corners = TriangleBuilder::default();
    for element in &header.elements {
        let records = RecordReader::new(&mut cursor, element)?;
        match element.name.as_str() {
            "vertex" => vertices(records, header, &mut mesh)?,
            "face" | "tristrips" => faces(records, &mut corners)?,
            _ => records.skip()?,
        }
    }
    // Faces may precede vertices, so that indices are checked at the end.
    corners.check(mesh.positions.len())?;
    mesh.triangles = corners.triangles;
    mesh.skipped_faces = corners.skipped;
    Ok(mesh)
}

/// Slot of a vertex property, in the order x y z, nx ny nz, u v.
fn vertex_slot(name: &str) -> Option<usize> {
    Some(match name {
        "x" => 0,
        "y" => 1,
        "z" => 2,
        "nx" => 3,
        "ny" => 4,
        "nz" => 5,
        "u" | "s" | "texture_u" | "texture_s" => 6,
        "v" | "t" | "texture_v" | "texture_t" => 7,
        _ => return None,
    })
}

fn vertices(
    mut records: RecordReader<'_, '_>,
    header: &PlyHeader,
    mesh: &mut PlyMesh,
) -> Result<(), PlyError> {
    let element = records.element;
    let slots: Vec<Option<usize>> = element
        .properties
        .iter()
        .map(|p| if p.list.is_none() { vertex_slot(&p.name) } else { None })
        .collect();
    let has = |slot: usize| slots.contains(&Some(slot));
    for (slot, name) in ["x", "y", "z"].into_iter().enumerate() {
        if !has(slot) {
            let position = PlyPosition::Text { line: header.line.saturating_sub(1), column: 1 };
            return Err(PlyError { position, kind: PlyErrorKind::Coordinate(name) });
        }
    }
    if element.count > u64::from(u32::MAX) {
        return Err(records.cursor.error(PlyErrorKind::TooMany(element.count)));
    }
    let (with_normals, with_uvs) = (has(3) && has(4) && has(5), has(6) && has(7));
    let each = size_of::<DVec3>()
        + if with_normals { size_of::<DVec3>() } else { 0 }
        + if with_uvs { size_of::<DVec2>() } else { 0 };
    let bytes = element.count.saturating_mul(each as u64);
    records.cursor.vertex_bytes = records.cursor.vertex_bytes.saturating_add(bytes);
    records.cursor.reserve()?;
    let count = element.count as usize;
    let mut positions = Vec::with_capacity(count);
    let mut normals = Vec::with_capacity(if with_normals { count } else { 0 });
    let mut uvs = Vec::with_capacity(if with_uvs { count } else { 0 });
    for index in 0..element.count {
        let mut values = [0.0; 8];
        for (p, slot) in element.properties.iter().zip(&slots) {
            let n = match p.list {
                Some(count) => records.length(count, p.scalar, index)?,
                None => 1,
            };
            for _ in 0..n {
                let value = records.number(p.scalar, index)?;
                if let Some(target) = slot.and_then(|s| values.get_mut(s)) {
                    *target = value;
                }
            }
        }
        if !values.iter().all(|v| v.is_finite()) {
            return Err(records.cursor.error(PlyErrorKind::NotFinite(index)));
        }
        let [x, y, z, nx, ny, nz, u, v] = values;
        positions.push(DVec3::new(x, y, z));
        if with_normals {
            normals.push(DVec3::new(nx, ny, nz));
        }
        if with_uvs {
            uvs.push(DVec2::new(u, v));
        }
    }
    mesh.positions = positions;
    mesh.normals = with_normals.then_some(normals);
    mesh.uvs = with_uvs.then_some(uvs);
    Ok(())
}

/// Triangles before the number of vertices is known.
#[derive(Default)]
struct TriangleBuilder {
    triangles: Vec<[u32; 3]>,
    skipped: usize,
    /// The largest index, with its element for the error message.
    largest: Option<(u32, u64, String, PlyPosition)>,
}

impl TriangleBuilder {
    fn check(&self, count: usize) -> Result<(), PlyError> {
        match &self.largest {
            Some((index, face, element, position)) if *index as usize >= count => Err(PlyError {
                position: *position,
                kind: PlyErrorKind::Index { element: element.clone(), face: *face, index: *index, count },
            }),
            _ => Ok(()),
        }
    }

    /// A polygon as a fan, or a strip with restarts at `u32::MAX`.
    fn add(&mut self, polygon: &[u32], strip: bool) {
        if !strip {
            match polygon {
                [first, rest @ ..] if rest.len() >= 2 => {
                    self.triangles.extend(rest.windows(2).map(|w| [*first, w[0], w[1]]));
                }
                _ => self.skipped += 1,
            }
            return;
        }
        for run in polygon.split(|&i| i == RESTART) {
            let triangles = run.windows(3).enumerate();
            self.triangles.extend(
                triangles.map(|(k, w)| if k % 2 == 0 { [w[0], w[1], w[2]] } else { [w[1], w[0], w[2]] }),
            );
        }
    }
}

/// Separator of strips; not an index, because there are fewer vertices.
const RESTART: u32 = u32::MAX;

fn faces(mut records: RecordReader<'_, '_>, corners: &mut TriangleBuilder) -> Result<(), PlyError> {
    let element = records.element;
    let strip = element.name == "tristrips";
    let is_corners = |name: &str| matches!(name, "vertex_indices" | "vertex_index" | "vertex_indexes");
    if !element.properties.iter().any(|p| p.list.is_some() && is_corners(&p.name)) {
        return records.skip();
    }
    let mut polygon = Vec::new();
    let mut largest = 0;
    for face in 0..element.count {
        for p in &element.properties {
            let n = match p.list {
                Some(count) => records.length(count, p.scalar, face)?,
                None => 1,
            };
            let wanted = p.list.is_some() && is_corners(&p.name);
            polygon.clear();
            if wanted {
                largest = largest.max(n);
                let triangles = corners.triangles.len().saturating_add(n) as u64;
                records.cursor.face_bytes = (BYTES_PER_TRIANGLE.saturating_mul(triangles))
                    .saturating_add(BYTES_PER_CORNER.saturating_mul(largest as u64));
                records.cursor.reserve()?;
            }
            for _ in 0..n {
                let value = records.number(p.scalar, face)?;
                if !wanted {
                    continue;
                }
                if strip && value == -1.0 {
                    polygon.push(RESTART);
                    continue;
                }
                if !(value >= 0.0 && value < f64::from(RESTART) && value.fract() == 0.0) {
                    let element = element.name.clone();
                    let kind = PlyErrorKind::NotAnIndex { element, face, value };
                    return Err(records.cursor.error(kind));
                }
                let index = value as u32;
                if corners.largest.as_ref().is_none_or(|l| index > l.0) {
                    let position = records.cursor.position();
                    corners.largest = Some((index, face, element.name.clone(), position));
                }
                polygon.push(index);
            }
            if wanted {
                corners.add(&polygon, strip);
            }
        }
    }
    Ok(())
}
