//! The sums of a checkpoint, read and written in blocks.

use std::io::{self, Read, Write};

use crc32fast::Hasher;

use crate::film::{Film, to_bytes};

use super::{CheckpointError, CheckpointHead, ENVELOPE, damaged, read_bytes};
use crate::codec::{CRC_LENGTH, EnvelopeError};

/// Number of words in a block: 1 MiB.
pub(super) const BLOCK: usize = 1 << 17;

/// Writes the sums of `film`, and the checksum of the file. `crc`: that of the head.
pub(super) fn write(film: &Film, mut crc: Hasher, out: &mut dyn Write) -> io::Result<()> {
    let mut block = Vec::new();
    for words in film.word_blocks() {
        let words = words.map_err(io::Error::other)?;
        block.resize(8 * words.len(), 0);
        to_bytes(&words, &mut block);
        let bytes = &block[..8 * words.len()];
        crc.update(bytes);
        out.write_all(bytes)?;
    }
    out.write_all(&crc.finalize().to_le_bytes())
}

/// Reader of the sums behind a head.
pub(crate) struct SumReader<R> {
    input: R,
    crc: Hasher,
    /// Bytes of the file read so far, and all of it.
    read: u64,
    length: u64,
}

impl<R: Read> SumReader<R> {
    /// A reader of `input`, from the first byte behind `head` on.
    pub(crate) fn new(head: &CheckpointHead, input: R) -> Self {
        let crc = Hasher::new_with_initial(head.crc);
        Self { input, crc, read: head.before_sums, length: head.length }
    }

    /// Replaces the content of `block` by the next `count` words.
    pub(crate) fn read_words(&mut self, count: usize, block: &mut Vec<u8>) -> Result<(), CheckpointError> {
        block.clear();
        let complete = read_bytes(&mut self.input, 8 * count, block)?;
        self.read += block.len() as u64;
        if !complete {
            return Err(damaged(self.length, self.read));
        }
        self.crc.update(block);
        Ok(())
    }

    /// Checks the end of the file.
    pub(crate) fn finish(mut self) -> Result<(), CheckpointError> {
        let mut end = Vec::new();
        // One byte more would not belong to the file.
        read_bytes(&mut self.input, CRC_LENGTH + 1, &mut end)?;
        let Ok(stored) = <[u8; CRC_LENGTH]>::try_from(end.as_slice()) else {
            return Err(damaged(self.length, self.read + end.len() as u64));
        };
        let (expected, found) = (u32::from_le_bytes(stored), self.crc.finalize());
        match expected == found {
            true => Ok(()),
            false => Err(EnvelopeError::Checksum { content: ENVELOPE.content, expected, found }.into()),
        }
    }
}
