//! Buffers, their views, and the bytes behind addresses (URIs): in the file itself or in a file beside it.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::rc::Rc;

use data_encoding::BASE64_NOPAD;
use glanz_job::MemoryReservation;

use super::error::GltfError;
use super::json::{Document, JsonObject, JsonPath};
use crate::file_list::FileKind;
use crate::model::ModelReader;

/// The compression of buffer views that is not read, and the remedy.
const MESHOPT: &str = "EXT_meshopt_compression";
pub(super) const MESHOPT_HELP: &str =
    "compression by meshoptimizer is not read; convert the file first: gltfpack -i FILE -o plain.glb";

/// The bytes of all buffers.
#[derive(Debug)]
pub(super) struct Buffers<'a> {
    buffers: Vec<BufferBytes<'a>>,
    /// Bytes of all of them; those that they share count once.
    size: usize,
    /// Memory of those that are not a part of the file.
    _memory: Vec<MemoryReservation>,
}

#[derive(Clone, Debug)]
enum BufferBytes<'a> {
    /// The binary part of the file.
    Chunk(&'a [u8]),
    /// Bytes of an address.
    Address(Rc<[u8]>),
    /// None: the space of compressed views.
    Missing,
}

/// A part of a buffer.
#[derive(Clone, Copy, Debug)]
pub(super) struct BufferView<'a> {
    pub(super) bytes: &'a [u8],
    /// Bytes from one element to the next, if they are not packed.
    pub(super) stride: Option<usize>,
}

impl<'a> Buffers<'a> {
    /// Reads all buffers.
    pub(super) fn read(
        document: &Document,
        binary: Option<&'a [u8]>,
        reader: &mut ModelReader,
    ) -> Result<Self, GltfError> {
        let mut known: BTreeMap<PathBuf, Rc<[u8]>> = BTreeMap::new();
        let (mut buffers, mut memory) = (Vec::new(), Vec::new());
        for index in 0..document.length("buffers") {
            let read = |buffer: JsonObject<'_>| {
                let length = buffer.required_count("byteLength")?;
                let bytes = match (buffer.text("uri")?, binary) {
                    (Some(uri), _) => {
                        let problem = |problem| buffer.error("uri", problem);
                        let key = address_key(uri, reader).map_err(problem)?;
                        BufferBytes::Address(match known.get(&key) {
                            Some(bytes) => Rc::clone(bytes),
                            None => {
                                let bytes: Rc<[u8]> =
                                    read_address(uri, reader, FileKind::Buffer).map_err(problem)?.into();
                                let reserved = reader.finder.budget.reserve(bytes.len() as u64);
                                memory.push(reserved.map_err(|end| problem(end.to_string()))?);
                                known.insert(key, Rc::clone(&bytes));
                                bytes
                            }
                        })
                    }
                    (None, Some(chunk)) if index == 0 => BufferBytes::Chunk(chunk),
                    (None, _) => return Ok(BufferBytes::Missing),
                };
                let found = bytes.get().len();
                if found < length {
                    let message =
                        format!("the buffer has {found} bytes instead of {length}; it may be incomplete");
                    return Err(buffer.fault(message));
                }
                Ok(bytes)
            };
            buffers.push(document.element("buffers", index, &JsonPath::ROOT, read)?);
        }
        let addressed: usize = known.values().map(|bytes| bytes.len()).sum();
        Ok(Self { buffers, size: addressed + binary.map_or(0, <[u8]>::len), _memory: memory })
    }

    /// Number of bytes of all buffers; those that they share count once.
    pub(super) fn size(&self) -> usize {
        self.size
    }

    /// The view with this number, which the value at `from` names.
    pub(super) fn view(
        &self,
        document: &Document,
        index: usize,
        from: &JsonPath<'_>,
    ) -> Result<BufferView<'_>, GltfError> {
        document.element("bufferViews", index, from, |view| {
            let buffer = view.required_count("buffer")?;
            let Some(bytes) = self.buffers.get(buffer) else {
                let count = self.buffers.len();
                return Err(
                    view.error("buffer", format!("buffer {buffer} does not exist; there are {count}"))
                );
            };
            if matches!(bytes, BufferBytes::Missing) {
                let compressed = view.extension(MESHOPT, |found| Ok(found.is_some()))?;
                let missing = "the buffer has neither an address nor bytes in the file";
                return Err(view.error("buffer", if compressed { MESHOPT_HELP } else { missing }));
            }
            let (start, length) =
                (view.count("byteOffset")?.unwrap_or(0), view.required_count("byteLength")?);
            let all = bytes.get();
            let Some(bytes) = start.checked_add(length).and_then(|end| all.get(start..end)) else {
                let message = format!(
                    "{length} bytes from {start} on are more than buffer {buffer} has, which are {}",
                    all.len()
                );
                return Err(view.fault(message));
            };
            Ok(BufferView { bytes, stride: view.count("byteStride")?.filter(|&stride| stride > 0) })
        })
    }
}

impl BufferBytes<'_> {
    fn get(&self) -> &[u8] {
        match self {
            Self::Chunk(bytes) => bytes,
            Self::Address(bytes) => bytes,
            Self::Missing => &[],
        }
    }
}

/// What an address names: data, or a file, the same for all of its names.
fn address_key(uri: &str, reader: &ModelReader) -> Result<PathBuf, String> {
    if uri.starts_with("data:") {
        return Ok(uri.into());
    }
    reader.real_path(&file_name(uri)?).map_err(|(problem, _)| problem)
}

/// The bytes at an address, or the problem.
pub(super) fn read_address(uri: &str, reader: &mut ModelReader, kind: FileKind) -> Result<Vec<u8>, String> {
    if let Some(data) = uri.strip_prefix("data:") {
        let text = data.split_once(";base64,").ok_or("data in an address must be in base 64")?.1;
        let text = text.trim_end_matches('=').as_bytes();
        return BASE64_NOPAD.decode(text).map_err(|error| format!("the data is not base 64: {error}"));
    }
    reader.read_file(&file_name(uri)?, kind).map_err(|(problem, _)| problem)
}

/// Adds the files of all buffers and pictures to those that the model needs, for a list of a model of which a buffer is not there.
pub(super) fn name_files(document: &Document, reader: &mut ModelReader) -> Result<(), GltfError> {
    for (list, kind) in [("buffers", FileKind::Buffer), ("images", FileKind::Picture)] {
        for index in 0..document.length(list) {
            document.element(list, index, &JsonPath::ROOT, |element| {
                let uri = element.text("uri")?.filter(|uri| !uri.starts_with("data:"));
                if let Some(name) = uri.and_then(|uri| file_name(uri).ok()) {
                    reader.name_file(&name, kind);
                }
                Ok(())
            })?;
        }
    }
    Ok(())
}

/// The name of a file by its address.
fn file_name(uri: &str) -> Result<Cow<'_, str>, String> {
    match uri.split_once("://") {
        Some((scheme, _)) => {
            Err(format!("addresses with {scheme:?} are not read; save the file beside the model"))
        }
        None => Ok(without_escapes(uri)),
    }
}

/// An address with bytes for escapes such as `%20`.
fn without_escapes(uri: &str) -> Cow<'_, str> {
    if !uri.contains('%') {
        return uri.into();
    }
    let (bytes, mut out) = (uri.as_bytes(), Vec::with_capacity(uri.len()));
    let mut at = 0;
    while let Some(&byte) = bytes.get(at) {
        let digit = |i: usize| bytes.get(at + i).and_then(|&b| char::from(b).to_digit(16));
        match (byte, digit(1), digit(2)) {
            (b'%', Some(high), Some(low)) => {
                out.push((16 * high + low) as u8);
                at += 3;
            }
            _ => {
                out.push(byte);
                at += 1;
            }
        }
    }
    String::from_utf8_lossy(&out).into_owned().into()
}
