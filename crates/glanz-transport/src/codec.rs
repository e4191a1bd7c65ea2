//! Encoding of little-endian numbers, and the envelope of files.

/// Length of the checksum.
pub const CRC_LENGTH: usize = 4;
/// Length of magic, version and length.
pub const PREFIX_LENGTH: usize = 20;

/// Length of a file without content.
const SHORTEST: u64 = (PREFIX_LENGTH + CRC_LENGTH) as u64;

/// Kind of file in an envelope: magic, version, length, content, checksum.
#[derive(Debug)]
pub struct FileEnvelope {
    /// First bytes.
    pub magic: &'static [u8; 8],
    /// Version of the format.
    pub version: u32,
    /// Content as messages name it, such as "the guide".
    pub content: &'static str,
    /// Kind of file as messages name it, such as "a guide of Glanz".
    pub kind: &'static str,
}

/// Errors of opening a [`FileEnvelope`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum EnvelopeError {
    /// Another magic.
    #[error("this is not {0}")]
    Foreign(&'static str),
    /// Another version.
    #[error("{content} has format {found}, this program reads format {known}")]
    Version {
        /// Content of the file.
        content: &'static str,
        /// Its format version.
        found: u32,
        /// The supported format version.
        known: u32,
    },
    /// A length that differs from the one stored in the file.
    #[error("{content} is damaged: it has {found} bytes, not {expected}")]
    Length {
        /// Content of the file.
        content: &'static str,
        /// Length stored in the file.
        expected: u64,
        /// Length of the file.
        found: u64,
    },
    /// A checksum that differs from the one stored in the file.
    #[error("{content} is damaged: its checksum is {found:08x}, not {expected:08x}")]
    Checksum {
        /// Content of the file.
        content: &'static str,
        /// Checksum stored in the file.
        expected: u32,
        /// Checksum of the file.
        found: u32,
    },
}

impl FileEnvelope {
    /// The bytes of a file: magic, version (4 bytes), total length (8 bytes), the output of `content`, and the CRC-32 (IEEE) of all
    /// preceding bytes.
    pub fn seal(&self, content: impl FnOnce(&mut Encoder)) -> Vec<u8> {
        let mut e = self.prefix(0);
        content(&mut e);
        let length = (e.0.len() + CRC_LENGTH) as u64;
        if let Some(slot) = e.0.get_mut(PREFIX_LENGTH - 8..PREFIX_LENGTH) {
            slot.copy_from_slice(&length.to_le_bytes());
        }
        let crc = crc32fast::hash(&e.0);
        e.u32(crc);
        e.0
    }

    /// The first bytes of a file of `length` bytes: magic, version and length.
    #[must_use]
    pub fn prefix(&self, length: u64) -> Encoder {
        let mut e = Encoder::default();
        e.0.extend_from_slice(self.magic);
        e.u32(self.version);
        e.u64(length);
        e
    }

    /// The length of a file that is stored in its first `bytes`, of which [`PREFIX_LENGTH`] are needed.
    ///
    /// # Errors
    /// [`EnvelopeError`] if magic or version differ, or the bytes end.
    pub fn length(&self, bytes: &[u8]) -> Result<u64, EnvelopeError> {
        let Self { magic, content, .. } = *self;
        let mut d = Decoder(bytes);
        // A file truncated within the magic is reported as truncated, not foreign, unless it is empty.
        let start = &magic[..magic.len().min(bytes.len())];
        if bytes.is_empty() || !bytes.starts_with(start) {
            return Err(EnvelopeError::Foreign(self.kind));
        }
        let (Some(_), Some(version), Some(length)) = (d.take(magic.len()), d.u32(), d.u64()) else {
            let found = bytes.len() as u64;
            return Err(EnvelopeError::Length { content, expected: SHORTEST, found });
        };
        if version != self.version {
            return Err(EnvelopeError::Version { content, found: version, known: self.version });
        }
        Ok(length)
    }

    /// The content of the output of [`FileEnvelope::seal`].
    ///
    /// # Errors
    /// [`EnvelopeError`] if magic, version, length or checksum differ.
    pub fn open<'a>(&self, bytes: &'a [u8]) -> Result<&'a [u8], EnvelopeError> {
        let content = self.content;
        let (expected, found) = (self.length(bytes)?, bytes.len() as u64);
        if expected != found {
            return Err(EnvelopeError::Length { content, expected, found });
        }
        let short = EnvelopeError::Length { content, expected: SHORTEST, found };
        let Some((rest, crc)) = bytes.split_last_chunk::<CRC_LENGTH>() else { return Err(short) };
        let (expected, found) = (u32::from_le_bytes(*crc), crc32fast::hash(rest));
        if expected != found {
            return Err(EnvelopeError::Checksum { content, expected, found });
        }
        rest.get(PREFIX_LENGTH..).ok_or(short)
    }
}

/// Encoder that appends to bytes.
#[derive(Debug, Default)]
pub struct Encoder(pub Vec<u8>);

impl Encoder {
    /// A byte.
    pub fn u8(&mut self, value: u8) {
        self.0.push(value);
    }

    /// Two bytes.
    pub fn u16(&mut self, value: u16) {
        self.0.extend_from_slice(&value.to_le_bytes());
    }

    /// Four bytes.
    pub fn u32(&mut self, value: u32) {
        self.0.extend_from_slice(&value.to_le_bytes());
    }

    /// Eight bytes.
    pub fn u64(&mut self, value: u64) {
        self.0.extend_from_slice(&value.to_le_bytes());
    }

    /// Sixteen bytes.
    pub fn u128(&mut self, value: u128) {
        self.0.extend_from_slice(&value.to_le_bytes());
    }

    /// The bits of a number.
    pub fn f64(&mut self, value: f64) {
        self.u64(value.to_bits());
    }

    /// A text of at most 255 bytes; longer text is truncated.
    pub fn text(&mut self, text: &str) {
        let bytes = &text.as_bytes()[..text.len().min(255)];
        self.0.push(bytes.len() as u8);
        self.0.extend_from_slice(bytes);
    }
}

/// Decoder that reads bytes from the front; its methods return `None` where the bytes end.
#[derive(Debug)]
pub struct Decoder<'a>(pub &'a [u8]);

impl<'a> Decoder<'a> {
    /// The next `count` bytes.
    pub fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (head, tail) = self.0.split_at_checked(count)?;
        self.0 = tail;
        Some(head)
    }

    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (head, tail) = self.0.split_first_chunk()?;
        self.0 = tail;
        Some(*head)
    }

    /// A byte.
    pub fn u8(&mut self) -> Option<u8> {
        self.array().map(u8::from_le_bytes)
    }

    /// Two bytes.
    pub fn u16(&mut self) -> Option<u16> {
        self.array().map(u16::from_le_bytes)
    }

    /// Four bytes.
    pub fn u32(&mut self) -> Option<u32> {
        self.array().map(u32::from_le_bytes)
    }

    /// Eight bytes.
    pub fn u64(&mut self) -> Option<u64> {
        self.array().map(u64::from_le_bytes)
    }

    /// Sixteen bytes.
    pub fn u128(&mut self) -> Option<u128> {
        self.array().map(u128::from_le_bytes)
    }

    /// The bits of a number.
    pub fn f64(&mut self) -> Option<f64> {
        self.u64().map(f64::from_bits)
    }

    /// Reads what [`Encoder::text`] appended.
    pub fn text(&mut self) -> Option<&'a str> {
        let length = self.u8()?;
        std::str::from_utf8(self.take(usize::from(length))?).ok()
    }
}

/// `bytes` of a file without its checksum, with corrected length and appended checksum.
#[cfg(test)]
pub(crate) fn resealed(mut bytes: Vec<u8>) -> Vec<u8> {
    let length = (bytes.len() + CRC_LENGTH) as u64;
    bytes[12..20].copy_from_slice(&length.to_le_bytes());
    let crc = crc32fast::hash(&bytes);
    bytes.extend_from_slice(&crc.to_le_bytes());
    bytes
}
