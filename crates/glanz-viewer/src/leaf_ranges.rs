//! Numbers of leaves in messages.

use std::collections::BTreeSet;

use serde::de::Error;
use serde::{Deserialize, Deserializer};

/// Largest number of leaves that a message may name: a run takes a few bytes in the message, and a number per leaf in memory.
const MOST: u64 = 1 << 20;

/// One leaf, or a run of them.
#[derive(Deserialize)]
#[serde(untagged)]
enum LeafRange {
    One(u32),
    /// First and last.
    Run([u32; 2]),
}

/// Reads a list of leaves and runs, `[3, [7, 9]]` for 3, 7, 8, 9.
///
/// # Errors
/// Those of the deserializer, a run that ends before it begins, and more than a million leaves.
pub(crate) fn leaves<'de, D: Deserializer<'de>>(deserializer: D) -> Result<BTreeSet<u32>, D::Error> {
    let mut named = BTreeSet::new();
    let mut left = MOST;
    for entry in Vec::<LeafRange>::deserialize(deserializer)? {
        let (first, last) = match entry {
            LeafRange::One(leaf) => (leaf, leaf),
            LeafRange::Run([first, last]) => (first, last),
        };
        if last < first {
            return Err(D::Error::custom(format_args!(
                "the run of leaves [{first}, {last}] ends before it begins"
            )));
        }
        // Repeated leaves count again: they cost work, too.
        left = left
            .checked_sub(u64::from(last - first) + 1)
            .ok_or_else(|| D::Error::custom(format_args!("more than {MOST} leaves are named")))?;
        named.extend(first..=last);
    }
    Ok(named)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<BTreeSet<u32>, String> {
        leaves(&mut serde_json::Deserializer::from_str(text)).map_err(|error| error.to_string())
    }

    #[test]
    fn runs_are_the_leaves_from_their_first_to_their_last() {
        assert_eq!(read("[3, [7, 9], [1, 1]]"), Ok(BTreeSet::from([1, 3, 7, 8, 9])));
        assert_eq!(read("[]"), Ok(BTreeSet::new()));
        assert_eq!(read("[4294967295]"), Ok(BTreeSet::from([u32::MAX])));
    }

    #[test]
    fn runs_that_end_early_or_never_are_refused() {
        assert!(read("[[9, 7]]").unwrap_err().contains("[9, 7]"));
        let again = "[[0, 500000], [0, 500000], [0, 500000]]";
        for text in [
            "[[0, 4294967295]]",
            "[[0, 1000000], [2000000, 3000000]]",
            again,
            "[[1, 2, 3]]",
            "[-1]",
            "[\"1\"]",
        ] {
            assert!(read(text).is_err(), "{text}");
        }
    }
}
