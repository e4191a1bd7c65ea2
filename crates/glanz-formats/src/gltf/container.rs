//! The parts of a file: text, and in a binary file (GLB) also bytes.

use super::error::GltfError;

/// First bytes of a binary file.
const MAGIC: &[u8] = b"glTF";

/// Bytes of the header of a binary file.
const HEADER: usize = 12;

/// Bytes of the header of a chunk.
const CHUNK_HEADER: usize = 8;

/// JSON text and binary part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Container<'a> {
    pub(super) json: &'a [u8],
    pub(super) binary: Option<&'a [u8]>,
}

/// Whether these are the bytes of a file: binary, or a JSON object.
pub(crate) fn is_gltf(bytes: &[u8]) -> bool {
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    bytes.starts_with(MAGIC) || text.trim_ascii_start().starts_with(b"{")
}

fn word(bytes: &[u8], at: usize) -> Option<usize> {
    bytes.get(at..)?.first_chunk().map(|four| u32::from_le_bytes(*four) as usize)
}

/// Divides a file into its parts.
pub(super) fn split(bytes: &[u8]) -> Result<Container<'_>, GltfError> {
    if !bytes.starts_with(MAGIC) {
        return Ok(Container { json: bytes, binary: None });
    }
    let incomplete =
        || GltfError::of_file("the file ends within its header or a chunk; it may be incomplete");
    let version = word(bytes, 4).ok_or_else(incomplete)?;
    if version != 2 {
        return Err(GltfError::of_file(format!(
            "the file has version {version} of binary glTF; only 2 is read"
        )));
    }
    let length = word(bytes, 8).ok_or_else(incomplete)?;
    let bytes = bytes.get(..length).ok_or_else(incomplete)?;
    let (mut at, mut json, mut binary) = (HEADER, None, None);
    while at < bytes.len() {
        let (size, kind) = (word(bytes, at).ok_or_else(incomplete)?, bytes.get(at + 4..at + CHUNK_HEADER));
        let start = at + CHUNK_HEADER;
        let chunk = bytes.get(start..start.saturating_add(size)).ok_or_else(incomplete)?;
        match kind {
            Some(b"JSON") if json.is_none() => json = Some(chunk),
            Some(b"BIN\0") if binary.is_none() => binary = Some(chunk),
            // The format reserves other chunks.
            _ => {}
        }
        at = start + size;
    }
    let json = json.ok_or_else(|| GltfError::of_file("the file has no JSON chunk"))?;
    Ok(Container { json, binary })
}
