//! Files of parts.

use std::fmt;
use std::fs::File;
use std::io::{Cursor, Read};
use std::path::{Path, PathBuf};

use glanz_transport::codec::EnvelopeError;

use super::JoinError;
use crate::error::{Error, FileFault};

/// Kind of job whose parts are joined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PartKind {
    /// Films, parts of a picture.
    Picture,
    /// Tallies of particles, parts of a calculation of illuminance.
    Illuminance,
    /// Baked light.
    Light,
}

impl PartKind {
    /// All kinds with the first bytes of their files.
    const MAGICS: [(Self, &'static [u8; 8]); 3] =
        [(Self::Picture, b"GLANZCKP"), (Self::Illuminance, b"GLANZLUX"), (Self::Light, b"GLANZLGT")];
}

impl fmt::Display for PartKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Picture => "picture",
            Self::Illuminance => "illuminance",
            Self::Light => "light",
        })
    }
}

/// The file of a part, of which the first bytes are read. A pipe, which can be read once only, stays open.
#[derive(Debug)]
pub(crate) struct PartFile {
    pub(crate) path: PathBuf,
    pub(super) kind: PartKind,
    start: Vec<u8>,
    pipe: Option<File>,
}

impl PartFile {
    /// Opens the file `path`, which is a checkpoint of one of the kinds.
    pub(super) fn open(path: &Path) -> Result<Self, Error> {
        let opened = File::open(path).and_then(|mut file| {
            let mut start = Vec::new();
            file.by_ref().take(8).read_to_end(&mut start)?;
            let is_file = file.metadata()?.is_file();
            Ok((start, Some(file).filter(|_| !is_file)))
        });
        let (start, pipe) = opened.map_err(Error::of_file(path))?;
        let kind = PartKind::MAGICS.into_iter().find(|(_, magic)| start == *magic).map(|(kind, _)| kind);
        let kind = kind
            .ok_or_else(|| FileFault::Envelope(EnvelopeError::Foreign("a checkpoint of Glanz")).of(path))?;
        Ok(Self { path: path.to_owned(), kind, start, pipe })
    }

    /// A reader of the whole file, and its length, if it is no pipe.
    pub(super) fn reader(self) -> Result<(PartInput, Option<u64>), Error> {
        let Self { path, start, pipe, .. } = self;
        match pipe {
            Some(pipe) => Ok((Box::new(Cursor::new(start).chain(pipe)), None)),
            None => {
                let opened = File::open(&path).and_then(|file| Ok((file.metadata()?.len(), file)));
                let (length, file) = opened.map_err(Error::of_file(&path))?;
                Ok((Box::new(file), Some(length)))
            }
        }
    }

    /// The bytes of the whole file.
    pub(crate) fn bytes(self) -> Result<Vec<u8>, Error> {
        let path = self.path.clone();
        let (mut reader, _) = self.reader()?;
        let mut bytes = Vec::new();
        reader.read_to_end(&mut bytes).map_err(Error::of_file(&path))?;
        Ok(bytes)
    }
}

/// Reader of the file of a part.
pub(super) type PartInput = Box<dyn Read + Send>;

/// The kind of all parts.
pub(super) fn common_kind(parts: &[PartFile]) -> Result<PartKind, JoinError> {
    let (first, others) = parts.split_first().ok_or(JoinError::Empty)?;
    match others.iter().find(|part| part.kind != first.kind) {
        Some(part) => Err(JoinError::Kinds {
            parts: [first.path.clone(), part.path.clone()],
            kinds: [first.kind, part.kind],
        }),
        None => Ok(first.kind),
    }
}
