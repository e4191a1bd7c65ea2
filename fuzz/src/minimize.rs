//! Smaller files with the same fault.

use std::time::{Duration, Instant};

/// Longest time for one file; files that take long to fail are made less small.
const TIME: Duration = Duration::from_secs(40);

/// The smallest file that `fails` that was found by dropping parts of `bytes`, which fails.
///
/// Parts are dropped one after the other, from halves down to single bytes, as long as there is time.
pub fn minimize(mut bytes: Vec<u8>, mut fails: impl FnMut(&[u8]) -> bool) -> Vec<u8> {
    let start = Instant::now();
    let mut part = bytes.len().div_ceil(2);
    while part > 0 {
        let mut at = 0;
        let mut is_smaller = false;
        while at < bytes.len() {
            if start.elapsed() > TIME {
                return bytes;
            }
            let end = (at + part).min(bytes.len());
            let without = [bytes.get(..at), bytes.get(end..)].map(Option::unwrap_or_default).concat();
            if fails(&without) {
                bytes = without;
                is_smaller = true;
            } else {
                at = end;
            }
        }
        // What is left of a part may have become superfluous.
        if !is_smaller || part > 1 {
            part /= 2;
        }
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_needed_is_left() {
        let has = |bytes: &[u8], word: &[u8]| bytes.windows(word.len()).any(|part| part == word);
        let text = b"some words before, the fault, others, and a second one at the end".to_vec();
        let mut tries = 0;
        let smallest = minimize(text, |bytes| {
            tries += 1;
            has(bytes, b"fault") && has(bytes, b"second")
        });
        assert_eq!(smallest, b"faultsecond");
        assert!(tries < 400, "{tries}");
    }

    #[test]
    fn empty_files_end() {
        assert_eq!(minimize(Vec::new(), |_| true), b"");
        assert_eq!(minimize(vec![1, 2, 3], |_| true), b"");
    }
}
