//! Random changes of files that keep much of their structure.
//!
//! Everything follows from the seed: the same files on every machine. A mutant is a file of the pool with one to six changes: of bytes in any format, of numbers, words
//! and brackets in texts, of integers of two, four and eight bytes in others.

use glanz::sampling::hash::mix64;

/// Longest mutant, bytes; longer ones are cut.
pub const LONGEST: usize = 1 << 17;

/// Longest part that is cut out, copied or repeated, bytes.
const PART: usize = 64;

/// Numbers at which readers go wrong: limits of integers and of floating point, and what is no number.
const NUMBERS: &[&str] = &[
    "0",
    "1",
    "-1",
    "2",
    "255",
    "65536",
    "2147483647",
    "2147483648",
    "4294967295",
    "4294967296",
    "9223372036854775807",
    "18446744073709551615",
    "99999999999999999999999999",
    "0.5",
    "-0.0",
    "1e-9",
    "1e-320",
    "1e9",
    "1e15",
    "1e38",
    "1e39",
    "1e300",
    "1e308",
    "1e400",
    "-1e308",
    "nan",
    "inf",
];

/// Integers at which readers go wrong, cut to their number of bytes.
const INTEGERS: &[u64] = &[
    0,
    1,
    2,
    0x7f,
    0xff,
    0x7fff,
    0xffff,
    0x1_0000,
    0xff_ffff,
    0x7fff_ffff,
    0x8000_0000,
    0xffff_fffe,
    0xffff_ffff,
    0x1_0000_0000,
    0x7fff_ffff_ffff_ffff,
    0x8000_0000_0000_0000,
    0xffff_ffff_ffff_ffff,
];

/// What the changes know of a format.
#[derive(Clone, Copy, Debug)]
pub enum Syntax {
    /// A text, with words that mean something in it.
    Text(&'static [&'static str]),
    /// Binary data, with the length of its head, in which most integers are that decide about sizes.
    Binary(usize),
}

/// A stream of random numbers: SplitMix64 (@steele2014).
#[derive(Clone, Debug)]
pub struct RandomStream(u64);

impl RandomStream {
    /// The stream of a seed.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self(mix64(seed))
    }

    /// The next 64 bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        mix64(self.0)
    }

    /// A number below `count`; 0 if that is 0.
    pub fn below(&mut self, count: usize) -> usize {
        (self.bits() % count.max(1) as u64) as usize
    }

    /// One of `values`.
    pub fn pick<'a, T>(&mut self, values: &'a [T]) -> Option<&'a T> {
        values.get(self.below(values.len()))
    }

    /// A part of at most [`PART`] bytes of so many.
    fn part(&mut self, length: usize) -> std::ops::Range<usize> {
        let start = self.below(length + 1);
        start..(start + 1 + self.below(PART)).min(length)
    }
}

/// A mutant of one of the files of `pool`; empty if there is none.
#[must_use]
pub fn mutant(pool: &[Vec<u8>], syntax: Syntax, random: &mut RandomStream) -> Vec<u8> {
    let mut bytes = random.pick(pool).cloned().unwrap_or_default();
    // Half of them have one change, and a fourth of them two, so that many are still read.
    for _ in 0..=random.bits().trailing_zeros().min(5) {
        match syntax {
            Syntax::Text(words) if random.below(2) == 0 => change_text(&mut bytes, words, random),
            Syntax::Binary(head) if random.below(2) == 0 => change_integer(&mut bytes, head, random),
            _ => change_bytes(&mut bytes, pool, random),
        }
    }
    bytes.truncate(LONGEST);
    bytes
}

/// A change that any format may suffer.
fn change_bytes(bytes: &mut Vec<u8>, pool: &[Vec<u8>], random: &mut RandomStream) {
    let part = random.part(bytes.len());
    let at = part.start;
    match random.below(12) {
        0 => bytes.truncate(at),
        1 => drop(bytes.drain(part)),
        2 => {
            let times = 1 + random.below(8);
            let copies = bytes.get(part).unwrap_or_default().repeat(times);
            insert(bytes, at, &copies);
        }
        3 => {
            let copy = bytes.get(part).unwrap_or_default().to_vec();
            let to = random.below(bytes.len() + 1);
            insert(bytes, to, &copy);
        }
        4 => {
            // The beginning of this file with the end of another.
            let other = random.pick(pool).map_or(&[][..], Vec::as_slice);
            let end = other.get(random.below(other.len() + 1)..).unwrap_or_default();
            bytes.truncate(at);
            bytes.extend_from_slice(end);
        }
        5 => {
            let byte = random.bits() as u8;
            overwrite(bytes, at, &[byte]);
        }
        6 => {
            let byte = bytes.get(at).map(|byte| byte ^ (1 << random.below(8)));
            overwrite(bytes, at, byte.as_slice());
        }
        7 => {
            let byte = random.bits() as u8;
            insert(bytes, at, &[byte]);
        }
        // Bytes of the file itself mean something in its format, and columns stay where they are.
        _ => {
            let byte = random.pick(bytes).copied();
            overwrite(bytes, at, byte.as_slice());
        }
    }
}

/// A change of a number, a word, a bracket or a block.
fn change_text(bytes: &mut Vec<u8>, words: &[&str], random: &mut RandomStream) {
    let at = random.below(bytes.len() + 1);
    match random.below(8) {
        0..3 => {
            // A limit, or another number of the file, which may refer to something.
            let other = token_from(bytes, random.below(bytes.len() + 1), is_numeric);
            let other = other.and_then(|token| bytes.get(token)).filter(|_| random.below(2) == 0);
            let limit = random.pick(NUMBERS).map_or(&b""[..], |number| number.as_bytes());
            let number = other.unwrap_or(limit).to_vec();
            if let Some(token) = token_from(bytes, at, is_numeric) {
                bytes.splice(token, number);
            }
        }
        3 | 4 => {
            let word = random.pick(words).copied().unwrap_or_default();
            match token_from(bytes, at, is_graphic).filter(|_| random.below(2) == 0) {
                Some(token) => drop(bytes.splice(token, word.bytes())),
                None => insert(bytes, at, format!("{word} ").as_bytes()),
            }
        }
        5 => {
            // Nesting, of which the depth is not always small.
            let opening = random.pick(&["[", "(", "{", "\""]).copied();
            let opening = opening.into_iter().chain(random.pick(words).copied());
            let text = opening.last().filter(|_| random.below(2) == 0).unwrap_or("[");
            let times = 1 << random.below(11);
            insert(bytes, at, format!("{text} ").repeat(times).as_bytes());
        }
        6 => {
            let behind = bytes.iter().skip(at).position(|byte| b"])}\"'".contains(byte));
            if let Some(bracket) = behind {
                bytes.remove(at + bracket);
            }
        }
        _ => {
            if let Some(token) = token_from(bytes, at, is_graphic) {
                let mut word = bytes.get(token.clone()).unwrap_or_default().to_vec();
                word.push(b' ');
                let times = 1 << random.below(9);
                insert(bytes, token.start, &word.repeat(times));
            }
        }
    }
}

/// A change of an integer: by one, or to one at which readers go wrong.
fn change_integer(bytes: &mut [u8], head: usize, random: &mut RandomStream) {
    let reach = if random.below(4) == 0 { bytes.len() } else { head.min(bytes.len()) };
    let size = [1, 2, 4, 8][random.below(4)];
    // Most are at multiples of their size.
    let at = random.below(reach) / size * size + usize::from(random.below(4) == 0);
    let Some(slot) = bytes.get_mut(at..at + size) else { return };
    let mut number = [0; 8];
    number.iter_mut().zip(slot.iter()).for_each(|(to, from)| *to = *from);
    let old = u64::from_le_bytes(number);
    let number = match random.below(6) {
        0 => old.wrapping_add(1),
        1 => old.wrapping_sub(1),
        2 => random.bits(),
        _ => random.pick(INTEGERS).copied().unwrap_or_default(),
    };
    let number = number.to_le_bytes();
    let is_reversed = random.below(2) == 0;
    slot.iter_mut().zip(number).for_each(|(to, from)| *to = from);
    if is_reversed {
        slot.reverse();
    }
}

fn insert(bytes: &mut Vec<u8>, at: usize, new: &[u8]) {
    bytes.splice(at.min(bytes.len())..at.min(bytes.len()), new.iter().copied());
}

fn overwrite(bytes: &mut [u8], at: usize, new: &[u8]) {
    bytes.iter_mut().skip(at).zip(new).for_each(|(to, from)| *to = *from);
}

fn is_numeric(byte: u8) -> bool {
    byte.is_ascii_digit() || b"+-.eE".contains(&byte)
}

fn is_graphic(byte: u8) -> bool {
    byte.is_ascii_graphic()
}

/// The first run of such bytes behind `at`.
fn token_from(bytes: &[u8], at: usize, belongs: fn(u8) -> bool) -> Option<std::ops::Range<usize>> {
    let start = at + bytes.get(at..)?.iter().position(|byte| belongs(*byte))?;
    let length = bytes.get(start..)?.iter().position(|byte| !belongs(*byte)).unwrap_or(bytes.len() - start);
    Some(start..start + length)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    const TEXT: &[u8] = b"Shape \"sphere\" \"float radius\" [ 12.5 ]";

    fn mutants(syntax: Syntax, seed: u64) -> Vec<Vec<u8>> {
        let pool = [TEXT.to_vec(), (0..200).collect()];
        let mut random = RandomStream::new(seed);
        (0..20_000).map(|_| mutant(&pool, syntax, &mut random)).collect()
    }

    #[test]
    fn mutants_follow_from_the_seed_and_hardly_repeat() {
        for syntax in [Syntax::Text(&["Material", "WorldBegin"]), Syntax::Binary(64)] {
            let first = mutants(syntax, 7);
            assert_eq!(first, mutants(syntax, 7));
            assert_ne!(first, mutants(syntax, 8));
            assert!(first.iter().all(|bytes| bytes.len() <= LONGEST));
            let different: BTreeSet<_> = first.iter().collect();
            assert!(different.len() > 10_000, "{}", different.len());
        }
    }

    #[test]
    fn texts_get_extreme_numbers_words_depth_and_lose_brackets() {
        let texts = mutants(Syntax::Text(&["Material", "WorldBegin"]), 1);
        let count = |part: &[u8]| texts.iter().filter(|t| t.windows(part.len()).any(|w| w == part)).count();
        for part in ["[ 1e308 ]", "[ nan ]", "[ 4294967296 ]", "Material ", "[ [ [ [ [ [ [ [ "] {
            assert!(count(part.as_bytes()) > 2, "{part}");
        }
        assert!(texts.iter().any(|text| text == b"Shape \"sphere\" \"float radius\" [ 12.5 "));
    }

    #[test]
    fn binary_files_get_extreme_integers_in_both_orders_of_bytes() {
        let files = mutants(Syntax::Binary(64), 1);
        let count = |part: &[u8]| files.iter().filter(|f| f.windows(part.len()).any(|w| w == part)).count();
        for part in [[0xff, 0xff, 0xff, 0x7f], [0x7f, 0xff, 0xff, 0xff]] {
            assert!(count(&part) > 2, "{part:x?}");
        }
    }

    #[test]
    fn pools_of_nothing_have_mutants() {
        let mut random = RandomStream::new(3);
        for syntax in [Syntax::Text(&[]), Syntax::Binary(0)] {
            for pool in [&[][..], &[vec![]]] {
                (0..300).for_each(|_| drop(mutant(pool, syntax, &mut random)));
            }
        }
    }
}
