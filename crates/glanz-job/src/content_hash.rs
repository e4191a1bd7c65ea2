//! Hash of all files of a scene.

/// FNV-1a with 128 bits (@fnv), fed with each file's length and bytes in the order of reading.
///
/// Equal on every machine and in every version, because checkpoints store it. File names do not enter it, so a scene may move. It
/// detects accidental changes, not attacks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ContentHash(u128);

impl Default for ContentHash {
    fn default() -> Self {
        Self(0x6c62_272e_07bb_0142_62b8_2175_6295_c58d)
    }
}

impl ContentHash {
    const PRIME: u128 = 0x0000_0000_0100_0000_0000_0000_0000_013b;

    /// Adds a file. Its length goes first, so that bytes cannot move from one file to the next unseen.
    pub fn add_file(&mut self, bytes: &[u8]) {
        self.add(&(bytes.len() as u64).to_le_bytes());
        self.add(bytes);
    }

    /// Adds bytes without their length.
    pub fn add(&mut self, bytes: &[u8]) {
        self.0 = bytes.iter().fold(self.0, |h, &b| (h ^ u128::from(b)).wrapping_mul(Self::PRIME));
    }

    /// The hash so far.
    #[must_use]
    pub fn value(&self) -> u128 {
        self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_the_published_function() {
        // Test vectors of FNV-1a 128: the empty text and "a".
        let mut hash = ContentHash::default();
        assert_eq!(hash.value(), 0x6c62272e07bb014262b821756295c58d);
        hash.add(b"a");
        assert_eq!(hash.value(), 0xd228cb696f1a8caf78912b704e4a8964);
    }

    #[test]
    fn moving_a_byte_to_the_next_file_changes_it() {
        let of = |files: [&[u8]; 2]| {
            let mut hash = ContentHash::default();
            files.iter().for_each(|f| hash.add_file(f));
            hash.value()
        };
        assert_ne!(of([b"ab", b"c"]), of([b"a", b"bc"]));
    }
}
