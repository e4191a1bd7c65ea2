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

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn integers_are_added_with_their_carry_and_the_lowest_word_is_kept(
            a in any::<[u64; 4]>(), b in any::<[u64; 4]>(), full in any::<bool>(),
        ) {
            // Half of the cases carry from the first word to the third.
            let a = if full { [u64::MAX, u64::MAX, a[2], a[3]] } else { a };
            let mut sum = a;
            add_words(&[WordMerge::Add(3), WordMerge::Lowest], &mut sum, &b, |word| *word);
            let low = |words: &[u64; 4]| u128::from(words[0]) | u128::from(words[1]) << 64;
            let (expected, carry) = low(&a).overflowing_add(low(&b));
            prop_assert_eq!(low(&sum), expected);
            prop_assert_eq!(sum[2], a[2].wrapping_add(b[2]).wrapping_add(u64::from(carry)));
            prop_assert_eq!(sum[3], a[3].min(b[3]));
        }
    }
}
