//! The header of a PLY file.

use super::{PlyError, PlyErrorKind, PlyPosition};

/// Encoding of the values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PlyEncoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// A type of stored numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ScalarType {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl ScalarType {
    fn of_name(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    /// Bytes in binary files.
    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

/// One property of an element.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct PlyProperty {
    pub(super) name: String,
    /// Type of the length, if it is a list.
    pub(super) list: Option<ScalarType>,
    pub(super) scalar: ScalarType,
}

/// One element: its number of records and their properties.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct PlyElement {
    pub(super) name: String,
    pub(super) count: u64,
    pub(super) properties: Vec<PlyProperty>,
}

impl PlyElement {
    /// Smallest size of a record, bytes.
    pub(super) fn min_size(&self, encoding: PlyEncoding) -> usize {
        match encoding {
            // A digit and a blank each; the last blank of the file may be missing.
            PlyEncoding::Ascii => 2 * self.properties.len(),
            _ => self.properties.iter().map(|p| p.list.unwrap_or(p.scalar).size()).sum(),
        }
    }
}

/// The whole header.
#[derive(Clone, Debug)]
pub(super) struct PlyHeader {
    pub(super) encoding: PlyEncoding,
    pub(super) elements: Vec<PlyElement>,
    /// Offset of the data in bytes.
    pub(super) body: usize,
    /// Their line.
    pub(super) line: u32,
}

fn error(line: u32, column: u32, kind: PlyErrorKind) -> PlyError {
    PlyError { position: PlyPosition::Text { line, column }, kind }
}

/// Reads the header.
pub(super) fn parse(bytes: &[u8]) -> Result<PlyHeader, PlyError> {
    let mut offset = 0;
    let mut number = 0;
    let mut encoding = None;
    let mut elements: Vec<PlyElement> = Vec::new();
    loop {
        let rest = bytes.get(offset..).unwrap_or_default();
        number += 1;
        let Some(length) = rest.iter().position(|&b| b == b'\n') else {
            let kind = if number == 1 { PlyErrorKind::Magic } else { PlyErrorKind::HeaderEnd };
            return Err(error(number, 1, kind));
        };
        offset += length + 1;
        // Messages quote the beginning of a very long line only.
        let text = String::from_utf8_lossy(rest.get(..length.min(200)).unwrap_or_default());
        let line = text.trim_end();
        if number == 1 {
            if line != "ply" {
                return Err(error(1, 1, PlyErrorKind::Magic));
            }
            continue;
        }
        let not_understood = || error(number, 1, PlyErrorKind::HeaderLine(line.to_owned()));
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        match words[..] {
            [] | ["comment" | "obj_info", ..] => {}
            ["end_header"] => break,
            ["format", ref format @ ..] => {
                let name = format.join(" ");
                encoding = Some(match name.as_str() {
                    "ascii 1.0" => PlyEncoding::Ascii,
                    "binary_little_endian 1.0" => PlyEncoding::LittleEndian,
                    "binary_big_endian 1.0" => PlyEncoding::BigEndian,
                    _ => return Err(error(number, 8, PlyErrorKind::Format(name))),
                });
            }
            ["element", name, count] => {
                let count = count.parse().map_err(|_| not_understood())?;
                elements.push(PlyElement { name: name.to_owned(), count, properties: Vec::new() });
            }
            ["property", ref rest @ ..] => {
                let property = property(rest).ok_or_else(not_understood)?;
                elements.last_mut().ok_or_else(not_understood)?.properties.push(property);
            }
            _ => return Err(not_understood()),
        }
    }
    let encoding = encoding.ok_or_else(|| error(number, 1, PlyErrorKind::Format(String::new())))?;
    Ok(PlyHeader { encoding, elements, body: offset, line: number + 1 })
}

fn property(words: &[&str]) -> Option<PlyProperty> {
    match *words {
        ["list", count, scalar, name] => Some(PlyProperty {
            name: name.to_owned(),
            list: Some(ScalarType::of_name(count)?),
            scalar: ScalarType::of_name(scalar)?,
        }),
        [scalar, name] => {
            Some(PlyProperty { name: name.to_owned(), list: None, scalar: ScalarType::of_name(scalar)? })
        }
        _ => None,
    }
}
