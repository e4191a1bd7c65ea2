//! Memory of reading damaged STEP files, counted in bytes by the allocator of this program.

use glanz_formats::{Options, load_str};
use peak_alloc::PeakAlloc;
use proptest::prelude::*;
use proptest::sample::Index;
use proptest::test_runner::{RngAlgorithm, TestRng, TestRunner};

#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

/// Bytes at the peak of reading the model of a file: per byte of the file, and in any case.
const MODEL: [usize; 2] = [300, 1 << 16];

/// Bytes at the peak of making a description of a scene: per byte of the file, and in any case.
const SCENE: [usize; 2] = [2000, 1 << 20];

/// A file with faces on surfaces of all kinds, in a product that occurs twice, with colours and mapped items.
const SAMPLE: &str = include_str!("../../../fuzz/seeds/assembly.step");

/// A change of a file.
#[derive(Clone, Debug)]
enum Damage {
    /// A character in the place of another.
    Replace(Index, Index),
    /// A part that is missing.
    Remove(Index, usize),
    /// A part that appears again somewhere else.
    Copy(Index, Index, usize),
    /// A reference to another entity.
    Redirect(Index, Index),
    /// A number in the place of another.
    Number(Index, Index),
    /// A reference that is repeated in its list.
    Repeat(Index, usize),
}

/// Characters that mean something in a file.
const MEANINGFUL: &[u8] = b"#(),;='.$*/0123456789-E";

/// Numbers in strange places.
const NUMBERS: &[&str] =
    &["0.", "-1.", "1.E-9", "1.E-300", "1.E9", "1.E15", "1.E300", "1000000.", "-7.5", "1.0000001"];

fn damage() -> impl Strategy<Value = Damage> {
    let index = any::<Index>;
    prop_oneof![
        (index(), index()).prop_map(|(at, byte)| Damage::Replace(at, byte)),
        (index(), 1..100_usize).prop_map(|(at, length)| Damage::Remove(at, length)),
        (index(), index(), 1..3000_usize).prop_map(|(from, to, length)| Damage::Copy(from, to, length)),
        (index(), index()).prop_map(|(at, to)| Damage::Redirect(at, to)),
        (index(), index()).prop_map(|(at, number)| Damage::Number(at, number)),
        (index(), 1..500_usize).prop_map(|(at, count)| Damage::Repeat(at, count)),
    ]
}

/// The first part behind `from` of a character that `start` accepts and those of `others` behind it.
fn token(text: &str, from: usize, start: fn(char) -> bool, others: &str) -> Option<std::ops::Range<usize>> {
    let first = from + text.get(from..)?.find(start)?;
    let length = text.get(first + 1..)?.find(|c| !others.contains(c))?;
    Some(first..first + 1 + length)
}

fn reference(text: &str, at: usize) -> Option<std::ops::Range<usize>> {
    token(text, at, |c| c == '#', "0123456789")
}

fn damaged(mut text: String, changes: &[Damage]) -> String {
    for change in changes {
        let at = |index: &Index| index.index(text.len());
        match change {
            Damage::Replace(place, byte) => {
                let place = at(place);
                text.replace_range(place..=place, &char::from(*byte.get(MEANINGFUL)).to_string());
            }
            Damage::Remove(place, length) => {
                let start = at(place);
                let end = (start + length).min(text.len() - 1);
                text.replace_range(start..end.max(start), "");
            }
            Damage::Copy(from, to, length) => {
                let (start, to) = (at(from), at(to));
                let part = text[start..(start + length).min(text.len())].to_owned();
                text.insert_str(to, &part);
            }
            Damage::Redirect(place, to) => {
                let (place, to) = (reference(&text, at(place)), reference(&text, at(to)));
                if let (Some(place), Some(to)) = (place, to) {
                    let to = text[to].to_owned();
                    text.replace_range(place, &to);
                }
            }
            Damage::Number(place, number) => {
                let is_start = |c: char| c == '.';
                if let Some(place) = token(&text, at(place), is_start, "0123456789E-") {
                    text.replace_range(
                        place.start.saturating_sub(1)..place.end,
                        NUMBERS[number.index(NUMBERS.len())],
                    );
                }
            }
            Damage::Repeat(place, count) => {
                if let Some(place) = reference(&text, at(place)) {
                    let repeated = format!("{},", &text[place.clone()]).repeat(*count);
                    text.insert_str(place.start, &repeated);
                }
            }
        }
    }
    text
}

/// The bytes that a work on a file needs at its peak.
fn peak<T>(work: impl FnOnce() -> T) -> usize {
    let before = ALLOCATOR.current_usage();
    ALLOCATOR.reset_peak_usage();
    drop(work());
    ALLOCATOR.peak_usage() - before
}

/// The bytes that reading the model of a file, and making a scene of it, need at their peaks.
fn peaks(text: &str) -> [usize; 2] {
    [
        peak(|| glanz_formats::step::read(text.as_bytes())),
        peak(|| load_str("damaged.step", text, &Options::default())),
    ]
}

/// Number of damaged files; `GLANZ_FUZZ` multiplies it.
fn cases() -> u32 {
    100 * std::env::var("GLANZ_FUZZ").ok().and_then(|v| v.parse().ok()).unwrap_or(1)
}

#[test]
fn memory_is_in_proportion_to_the_size_of_damaged_files() {
    let whole = SAMPLE.to_owned();
    // Threads and tables are made once.
    peaks(&whole);
    let loaded =
        load_str("sample.step", &whole, &Options::default()).unwrap_or_else(|error| panic!("{error:?}"));
    let report = loaded.cad.unwrap();
    assert!(report.shapes.len() >= 20, "{report:?}");
    let config = ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(cases()) };
    // The same files in each run.
    let rng = TestRng::deterministic_rng(RngAlgorithm::ChaCha);
    let mut runner = TestRunner::new_with_rng(config, rng);
    let outcome = runner.run(&prop::collection::vec(damage(), 1..12), |changes| {
        let text = damaged(whole.clone(), &changes);
        let limits = [MODEL, SCENE].map(|[factor, constant]| factor * text.len() + constant);
        let found = peaks(&text);
        let holds = found.iter().zip(limits).all(|(found, limit)| *found <= limit);
        prop_assert!(holds, "{found:?} bytes for {} bytes", text.len());
        Ok(())
    });
    assert!(outcome.is_ok(), "{outcome:?}");
}
