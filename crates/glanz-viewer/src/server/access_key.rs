//! Unguessable keys.

use std::fmt;
use std::hint::black_box;

/// 128 random bits, written as 32 hexadecimal digits: the name of a model, a session, or the token that admits.
///
/// Comparisons take constant time, so that the time does not reveal the first difference.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct AccessKey([u8; 16]);

impl AccessKey {
    /// A random key.
    ///
    /// # Errors
    /// If the system provides no random numbers.
    pub(crate) fn random() -> Result<Self, getrandom::Error> {
        let mut bytes = [0; 16];
        getrandom::fill(&mut bytes)?;
        Ok(Self(bytes))
    }

    /// The key that [`fmt::Display`] wrote.
    pub(crate) fn parse(text: &str) -> Option<Self> {
        let digits = text.as_bytes();
        if digits.len() != 32 {
            return None;
        }
        let mut bytes = [0; 16];
        for (byte, pair) in bytes.iter_mut().zip(digits.chunks_exact(2)) {
            let [high, low] = [digit(*pair.first()?)?, digit(*pair.get(1)?)?];
            *byte = high << 4 | low;
        }
        Some(Self(bytes))
    }

    /// Equality in constant time.
    pub(crate) fn is(&self, other: &Self) -> bool {
        let different = self.0.iter().zip(&other.0).fold(0, |bits, (a, b)| black_box(bits | (a ^ b)));
        black_box(different) == 0
    }
}

/// The value of a hexadecimal digit, lower case as they are written.
fn digit(byte: u8) -> Option<u8> {
    match byte {
        b'0'..=b'9' => Some(byte - b'0'),
        b'a'..=b'f' => Some(byte - b'a' + 10),
        _ => None,
    }
}

impl fmt::Display for AccessKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

/// Without its bits: it may end in a log.
impl fmt::Debug for AccessKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("AccessKey(..)")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_read_as_they_are_written_and_nothing_else_is() {
        let key = AccessKey([0, 1, 2, 0xab, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 0xff]);
        assert_eq!(key.to_string(), "000102ab0405060708090a0b0c0d0eff");
        assert_eq!(AccessKey::parse(&key.to_string()), Some(key));
        for wrong in
            ["", "00", "000102AB0405060708090a0b0c0d0eff", "000102ab0405060708090a0b0c0d0eff0", "\u{e4}"]
        {
            assert_eq!(AccessKey::parse(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn keys_that_differ_in_one_bit_are_not_the_same() {
        let key = AccessKey::random().unwrap();
        assert!(key.is(&key));
        for i in 0..128 {
            let mut other = key;
            other.0[i / 8] ^= 1 << (i % 8);
            assert!(!key.is(&other), "bit {i}");
        }
        assert!(!key.is(&AccessKey::random().unwrap()));
    }
}
