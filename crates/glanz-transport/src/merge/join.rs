//! The film of many files, each read once, in blocks.

use std::io::Read;
use std::sync::{Mutex, PoisonError, mpsc};
use std::thread;

use glanz_job::Interrupted;

use super::{FirstPart, MergeChecks, MergeError};
use crate::checkpoint::{Checkpoint, CheckpointError, CheckpointHead, SumReader};
use crate::film::{Film, FilmError};
use crate::identity::PictureIdentity;

/// Number of words in a block: 8 MiB.
const BLOCK: usize = 1 << 20;

/// Number of blocks that are read before the first of them is added.
const READ_AHEAD: usize = 2;

/// A film that is summed up from the files of its parts. Takes the memory of one film and a few blocks, or of two films if parts are held.
#[derive(Debug)]
pub struct FilmJoin {
    identity: PictureIdentity,
    film: Film,
    /// Memory of blocks for the next ones: on many systems, new memory costs more time than reading into it.
    spare: Mutex<Vec<Vec<u8>>>,
}

impl FilmJoin {
    /// A film without samples, for parts that have passed the checks; in a temporary file if it takes more than `memory` bytes, see [`Film::try_new_within`].
    ///
    /// # Errors
    /// [`MergeError::Empty`] without parts, [`MergeError::Film`] if memory is insufficient.
    pub fn try_new(checks: MergeChecks, memory: u64) -> Result<Self, MergeError> {
        let FirstPart { number: part, identity, edges } = checks.first.ok_or(MergeError::Empty)?;
        let film = Film::try_new_within(identity.film, memory).and_then(|film| film.with_edges(edges));
        let film = film.map_err(|error| MergeError::Film { part, error })?;
        Ok(Self { identity, film, spare: Mutex::default() })
    }

    /// Adds a part: the sums of `input`, from the first byte behind `head` on. `hold`: whether they are held in memory until the checksum of the part has
    /// been verified. `on_block` is called with the number of bytes of each block.
    ///
    /// # Errors
    /// [`CheckpointError`] for a damaged part, or if `on_block` returns an error; the film is unchanged if it was held and is in memory, else it is of no use any more.
    pub fn add(
        &mut self,
        head: &CheckpointHead,
        input: impl Read + Send,
        hold: bool,
        mut on_block: impl FnMut(u64) -> Result<(), Interrupted>,
    ) -> Result<(), CheckpointError> {
        let Self { film, spare, .. } = self;
        let spare = &*spare;
        let blocks = film.blocks(BLOCK);
        let sizes: Vec<usize> = blocks.iter().map(ExactSizeIterator::len).collect();
        let mut held = Vec::new();
        thread::scope(|scope| {
            let (sender, receiver) = mpsc::sync_channel(READ_AHEAD);
            let reading = SumReader::new(head, input);
            thread::Builder::new()
                .spawn_scoped(scope, move || read_blocks(reading, &sizes, &sender, spare))
                .map_err(|error| CheckpointError::Read(error.kind()))?;
            for block in &blocks {
                let Ok(bytes) = receiver.recv() else { break };
                let bytes: Vec<u8> = bytes?;
                on_block(bytes.len() as u64)?;
                if hold {
                    held.push(bytes);
                } else {
                    add_block(film, block.start, &bytes)?;
                    put(spare, bytes);
                }
            }
            // After the last block comes the result of the checksum.
            match receiver.recv() {
                Ok(Err(error)) => Err(error),
                _ => Ok(()),
            }
        })?;
        for (block, bytes) in blocks.iter().zip(held) {
            add_block(film, block.start, &bytes)?;
            put(spare, bytes);
        }
        Ok(film.take_samples(&head.film)?)
    }

    /// The film of all parts that were added.
    #[must_use]
    pub fn finish(self) -> Checkpoint {
        Checkpoint { identity: self.identity, film: self.film }
    }
}

fn add_block(film: &mut Film, first: usize, bytes: &[u8]) -> Result<(), FilmError> {
    film.add_sums(first, bytes.as_chunks::<8>().0, |word| u64::from_le_bytes(*word))
}

fn put(spare: &Mutex<Vec<Vec<u8>>>, block: Vec<u8>) {
    spare.lock().unwrap_or_else(PoisonError::into_inner).push(block);
}

/// Sends blocks of these numbers of words, and an error if there is one, until nobody receives them any more.
fn read_blocks(
    mut sums: SumReader<impl Read>,
    sizes: &[usize],
    sender: &mpsc::SyncSender<Result<Vec<u8>, CheckpointError>>,
    spare: &Mutex<Vec<Vec<u8>>>,
) {
    for &words in sizes {
        let mut block = spare.lock().unwrap_or_else(PoisonError::into_inner).pop().unwrap_or_default();
        let read = sums.read_words(words, &mut block);
        let failed = read.is_err();
        if sender.send(read.map(|()| block)).is_err() || failed {
            return;
        }
    }
    if let Err(error) = sums.finish() {
        let _ = sender.send(Err(error));
    }
}
