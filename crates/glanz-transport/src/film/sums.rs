//! The sums of a film: in memory, or in a file.

use std::borrow::Cow;
use std::ops::Range;
use std::sync::Arc;

use glanz_job::ScratchFile;

use super::FilmError;

/// Number of words that are converted at a time: 1 MiB.
const BLOCK: usize = 1 << 17;

/// The words of a strip take at most this part of the memory: 1 in 4.
const STRIP_DIVISOR: u64 = 4;

/// The bytes of words, of which there are eight each.
pub(crate) fn to_bytes(words: &[u64], bytes: &mut [u8]) {
    let slots = bytes.as_chunks_mut::<8>().0;
    slots.iter_mut().zip(words).for_each(|(slot, word)| *slot = word.to_le_bytes());
}

/// The words of a film.
#[derive(Clone, Debug)]
pub(super) enum FilmSums {
    Memory(Vec<u64>),
    File(SumFile),
}

/// Words in a file that has no name and ends with the program. Clones share it until one of them is changed.
#[derive(Clone, Debug)]
pub(super) struct SumFile {
    file: Arc<ScratchFile>,
    length: usize,
    /// Number of words that may be in memory at a time.
    in_memory: usize,
}

impl SumFile {
    /// A file of `length` zeros, of which `in_memory` may be in memory at a time.
    fn try_new(length: usize, in_memory: usize) -> Result<Self, FilmError> {
        Ok(Self { file: Arc::new(ScratchFile::try_new(8 * length as u64)?), length, in_memory })
    }

    fn read(&self, words: &mut [u64], start: usize) -> Result<(), FilmError> {
        let mut bytes = vec![0; 8 * BLOCK.min(words.len())];
        for (words, start) in words.chunks_mut(BLOCK).zip((start..).step_by(BLOCK)) {
            let bytes = &mut bytes[..8 * words.len()];
            self.file.read(bytes, 8 * start as u64)?;
            let read = bytes.as_chunks::<8>().0;
            words.iter_mut().zip(read).for_each(|(word, bytes)| *word = u64::from_le_bytes(*bytes));
        }
        Ok(())
    }

    fn write(&mut self, words: &[u64], start: usize) -> Result<(), FilmError> {
        if Arc::get_mut(&mut self.file).is_none() {
            *self = self.copy()?;
        }
        let mut bytes = vec![0; 8 * BLOCK.min(words.len())];
        for (words, start) in words.chunks(BLOCK).zip((start..).step_by(BLOCK)) {
            let bytes = &mut bytes[..8 * words.len()];
            to_bytes(words, bytes);
            self.file.write(bytes, 8 * start as u64)?;
        }
        Ok(())
    }

    /// A file of its own with the same words.
    fn copy(&self) -> Result<Self, FilmError> {
        let (mut copy, mut words) =
            (Self::try_new(self.length, self.in_memory)?, vec![0; BLOCK.min(self.length)]);
        for start in (0..self.length).step_by(BLOCK) {
            let words = &mut words[..BLOCK.min(self.length - start)];
            self.read(words, start)?;
            copy.write(words, start)?;
        }
        Ok(copy)
    }
}

impl FilmSums {
    /// `length` zeros, in memory if they take at most `memory` bytes, else in a file.
    pub(super) fn try_new(length: u64, memory: u64) -> Result<Self, FilmError> {
        let bytes = length.saturating_mul(8);
        let too_many = || FilmError::Memory(bytes);
        let length = usize::try_from(length).map_err(|_| too_many())?;
        if bytes > memory {
            let in_memory = usize::try_from(memory / (8 * STRIP_DIVISOR)).unwrap_or(usize::MAX);
            return Ok(Self::File(SumFile::try_new(length, in_memory)?));
        }
        let mut words = Vec::new();
        words.try_reserve_exact(length).map_err(|_| too_many())?;
        words.resize(length, 0);
        Ok(Self::Memory(words))
    }

    pub(super) fn len(&self) -> usize {
        match self {
            Self::Memory(words) => words.len(),
            Self::File(file) => file.length,
        }
    }

    /// Number of words that may be in memory at a time; `None` for all.
    pub(super) fn limit(&self) -> Option<usize> {
        match self {
            Self::Memory(_) => None,
            Self::File(file) => Some(file.in_memory),
        }
    }

    /// All words; `None` for those in a file.
    pub(super) fn in_memory(&self) -> Option<&[u64]> {
        match self {
            Self::Memory(words) => Some(words),
            Self::File(_) => None,
        }
    }

    /// As [`FilmSums::in_memory`], to change them.
    pub(super) fn in_memory_mut(&mut self) -> Option<&mut [u64]> {
        match self {
            Self::Memory(words) => Some(words),
            Self::File(_) => None,
        }
    }

    /// The words of `range`, which must lie within the film.
    pub(super) fn get(&self, range: Range<usize>) -> Result<Cow<'_, [u64]>, FilmError> {
        match self {
            Self::Memory(words) => Ok(Cow::Borrowed(words.get(range).unwrap_or_default())),
            Self::File(file) => {
                let mut words = vec![0; range.len()];
                file.read(&mut words, range.start)?;
                Ok(Cow::Owned(words))
            }
        }
    }

    /// Changes the words of `range`, which must lie within the film.
    pub(super) fn update<T>(
        &mut self,
        range: Range<usize>,
        change: impl FnOnce(&mut [u64]) -> T,
    ) -> Result<T, FilmError> {
        match self {
            Self::Memory(words) => Ok(change(words.get_mut(range).unwrap_or_default())),
            Self::File(file) => {
                let mut words = vec![0; range.len()];
                file.read(&mut words, range.start)?;
                let result = change(&mut words);
                file.write(&words, range.start)?;
                Ok(result)
            }
        }
    }

    /// Blocks of all words, in order.
    pub(super) fn blocks(&self) -> impl Iterator<Item = Result<Cow<'_, [u64]>, FilmError>> {
        (0..self.len()).step_by(BLOCK).map(|start| self.get(start..self.len().min(start + BLOCK)))
    }
}

impl PartialEq for FilmSums {
    fn eq(&self, other: &Self) -> bool {
        let is_same = |(a, b): (Result<Cow<'_, [u64]>, _>, _)| a.is_ok() && a == b;
        self.len() == other.len() && self.blocks().zip(other.blocks()).all(is_same)
    }
}

/// Sums that arrive in blocks.
#[derive(Debug)]
pub(crate) struct FilmSumsWriter {
    sums: FilmSums,
    written: usize,
}

impl FilmSumsWriter {
    /// For `length` words, in memory if they take at most `memory` bytes, else in a file. Memory is taken as they arrive.
    pub(crate) fn try_new(length: u64, memory: u64) -> Result<Self, FilmError> {
        let in_memory = length.saturating_mul(8) <= memory;
        let sums = if in_memory { FilmSums::Memory(Vec::new()) } else { FilmSums::try_new(length, memory)? };
        Ok(Self { sums, written: 0 })
    }

    /// Adds the next words.
    pub(crate) fn push(&mut self, words: impl ExactSizeIterator<Item = u64>) -> Result<(), FilmError> {
        let start = self.written;
        self.written += words.len();
        match &mut self.sums {
            FilmSums::Memory(all) => all.extend(words),
            FilmSums::File(file) => file.write(&words.collect::<Vec<_>>(), start)?,
        }
        Ok(())
    }

    /// The words of `range`, which must have been added.
    pub(crate) fn get(&self, range: Range<usize>) -> Result<Cow<'_, [u64]>, FilmError> {
        self.sums.get(range)
    }

    pub(super) fn finish(self) -> FilmSums {
        self.sums
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_in_a_file_are_those_in_memory() {
        let length = BLOCK + 1000;
        let mut stores = [u64::MAX, 0].map(|memory| FilmSums::try_new(length as u64, memory).unwrap());
        assert!(stores[0].in_memory().is_some() && stores[1].in_memory().is_none());
        for sums in &mut stores {
            assert_eq!(sums.get(5..8).unwrap().as_ref(), [0; 3]);
            for range in [0..length, BLOCK - 3..BLOCK + 4, 7..7] {
                let count = |words: &mut [u64]| {
                    words.iter_mut().enumerate().for_each(|(i, word)| *word = *word * 3 + i as u64 + 1);
                };
                sums.update(range, count).unwrap();
            }
        }
        let expected = |i: usize| {
            let once = i as u64 + 1;
            if (BLOCK - 3..BLOCK + 4).contains(&i) { once * 3 + (i - (BLOCK - 3)) as u64 + 1 } else { once }
        };
        for sums in &stores {
            assert!(sums.get(0..length).unwrap().iter().enumerate().all(|(i, word)| *word == expected(i)));
        }
        assert!(stores[0] == stores[1]);
        let mut writer = FilmSumsWriter::try_new(length as u64, 0).unwrap();
        for from in (0..length).step_by(50_000) {
            writer.push((from..length.min(from + 50_000)).map(expected)).unwrap();
        }
        assert_eq!(writer.get(3..5).unwrap().as_ref(), [expected(3), expected(4)]);
        assert!(writer.finish() == stores[1]);
    }

    #[test]
    fn clones_of_a_file_change_by_themselves() {
        let mut sums = FilmSums::try_new(10, 0).unwrap();
        let before = sums.clone();
        sums.update(3..4, |words| words[0] = 7).unwrap();
        assert_eq!(before.get(0..10).unwrap().as_ref(), [0; 10]);
        assert_eq!(sums.get(2..5).unwrap().as_ref(), [0, 7, 0]);
        assert!(sums != before && sums.clone() == sums);
    }
}
