//! Sums of pixels, merged word by word.

/// How the words of two sums become those of their union.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum WordMerge {
    /// This number of words is an integer, the lowest word first, to be added.
    Add(usize),
    /// The smaller word is kept.
    Lowest,
}

impl WordMerge {
    /// Number of words.
    pub(crate) fn words(self) -> usize {
        match self {
            Self::Add(words) => words,
            Self::Lowest => 1,
        }
    }
}

/// Merges the words of two pixels. `word`: the value of one of `theirs`.
pub(crate) fn add_words<W>(merges: &[WordMerge], mine: &mut [u64], theirs: &[W], word: impl Fn(&W) -> u64) {
    let mut words = mine.iter_mut().zip(theirs);
    for merge in merges {
        let mut carry = false;
        for (mine, theirs) in words.by_ref().take(merge.words()) {
            let theirs = word(theirs);
            *mine = match merge {
                WordMerge::Add(_) => {
                    let (sum, over) = mine.overflowing_add(theirs);
                    let (sum, carried_over) = sum.overflowing_add(u64::from(carry));
                    carry = over || carried_over;
                    sum
                }
                WordMerge::Lowest => theirs.min(*mine),
            };
        }
    }
}
