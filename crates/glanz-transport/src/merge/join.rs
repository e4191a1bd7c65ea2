//! The film of many files, each read once, in blocks.

use std::io::Read;
use std::sync::{Mutex, PoisonError, mpsc};
use std::thread;

use glanz_job::Interrupted;

use super::{FirstPart, MergeChecks, MergeError};
use crate::checkpoint::{Checkpoint, CheckpointError, CheckpointHead, SumReader};
use crate::film::{Film, FilmError, FilmSumsWriter};
use crate::identity::PictureIdentity;

/// Number of words in a block: 8 MiB.
const BLOCK: usize = 1 << 20;

/// Number of blocks that are read before the first of them is added.
const READ_AHEAD: usize = 2;

/// A film that is summed up from the files of its parts. Takes the memory of one film and a few blocks, or of two films if parts are held and the film is in memory.
#[derive(Debug)]
pub struct FilmJoin {
    identity: PictureIdentity,
    film: Film,
    /// Memory that a film may take, bytes.
    memory: u64,
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
        Ok(Self { identity, film, memory, spare: Mutex::default() })
    }

    /// Adds a part: the sums of `input`, from the first byte behind `head` on. `hold`: whether they are held until the checksum of the part has
    /// been verified, in memory or, of a film in a file, in another one. `on_block` is called with the number of bytes of each block.
    ///
    /// # Errors
    /// [`CheckpointError`] for a damaged part, or if `on_block` returns an error; the film is unchanged if the part was held, else it is of no use any more.
    /// It is of no use after [`CheckpointError::Film`] either, if it is in a file.
    pub fn add(
        &mut self,
        head: &CheckpointHead,
        input: impl Read + Send,
        hold: bool,
        mut on_block: impl FnMut(u64) -> Result<(), Interrupted>,
    ) -> Result<(), CheckpointError> {
        let Self { film, memory, spare, .. } = self;
        let spare = &*spare;
        let blocks = film.blocks(BLOCK);
        let sizes: Vec<usize> = blocks.iter().map(ExactSizeIterator::len).collect();
        let mut held = match hold {
            false => None,
            true if film.is_in_file() => {
                Some(HeldSums::File(FilmSumsWriter::try_new(film.word_count() as u64, *memory)?))
            }
            true => Some(HeldSums::Memory(Vec::new())),
        };
        thread::scope(|scope| {
            let (sender, receiver) = mpsc::sync_channel(READ_AHEAD);
            let reading = SumReader::new(head, input);
            thread::Builder::new()
                .spawn_scoped(scope, move || read_blocks(reading, &sizes, &sender, spare))
                .map_err(CheckpointError::from)?;
            for block in &blocks {
                let Ok(bytes) = receiver.recv() else { break };
                let bytes: Vec<u8> = bytes?;
                on_block(bytes.len() as u64)?;
                match &mut held {
                    None => {
                        add_block(film, block.start, &bytes)?;
                        put(spare, bytes);
                    }
                    Some(HeldSums::Memory(blocks)) => blocks.push(bytes),
                    Some(HeldSums::File(sums)) => {
                        sums.push(bytes.as_chunks::<8>().0.iter().map(|word| u64::from_le_bytes(*word)))?;
                        put(spare, bytes);
                    }
                }
            }
            // After the last block comes the result of the checksum.
            match receiver.recv() {
                Ok(Err(error)) => Err(error),
                _ => Ok(()),
            }
        })?;
        match held {
            None => {}
            Some(HeldSums::Memory(held)) => {
                for (block, bytes) in blocks.iter().zip(held) {
                    add_block(film, block.start, &bytes)?;
                    put(spare, bytes);
                }
            }
            Some(HeldSums::File(sums)) => {
                for block in blocks {
                    film.add_sums(block.start, &sums.get(block)?, |word| *word)?;
                }
            }
        }
        Ok(film.take_samples(&head.film)?)
    }

    /// The film of all parts that were added.
    #[must_use]
    pub fn finish(self) -> Checkpoint {
        Checkpoint { identity: self.identity, film: self.film }
    }
}

/// The sums of a part whose checksum has not been verified.
enum HeldSums {
    /// The bytes of its blocks.
    Memory(Vec<Vec<u8>>),
    File(FilmSumsWriter),
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
