//! Targets with each kind of fault, by which the tests see that the program finds it.

use super::{ReadOutcome, Target};
use crate::limits;
use crate::mutation::Syntax;

const SYNTAX: Syntax = Syntax::Text(&["fault"]);

fn seeds() -> Vec<Vec<u8>> {
    vec![b"a text of some length with a number 12 in the middle and much behind it, so that there is something to drop".to_vec()]
}

/// A target that calls `$fault` for texts with the word "fault".
macro_rules! faulty {
    ($name:literal, $fault:expr) => {
        Target {
            name: $name,
            syntax: SYNTAX,
            seeds,
            run: |bytes| {
                if bytes.windows(5).any(|word| word == b"fault") {
                    ($fault)();
                }
                ReadOutcome::Read(String::new())
            },
            memory_factor: 1,
            divisor: 1,
        }
    };
}

pub(super) const TARGETS: &[Target] = &[
    faulty!("faulty-panic", || assert!(std::hint::black_box(false), "on purpose")),
    faulty!("faulty-time", || std::thread::sleep(limits::TIME + limits::TIME / 8)),
    faulty!("faulty-memory", || drop(std::hint::black_box(Vec::<u8>::with_capacity(
        limits::MEMORY + (1 << 20)
    )))),
    Target {
        name: "faulty-seeds",
        syntax: SYNTAX,
        seeds: || {
            assert!(std::hint::black_box(false), "on purpose");
            seeds()
        },
        run: |_| ReadOutcome::Read(String::new()),
        memory_factor: 1,
        divisor: 1,
    },
    Target {
        name: "faulty-start",
        syntax: SYNTAX,
        seeds: || std::process::abort(),
        run: |_| ReadOutcome::Read(String::new()),
        memory_factor: 1,
        divisor: 1,
    },
    faulty!("faulty-stack", || assert!(std::hint::black_box(deep(u64::MAX)) > 0)),
];

/// Calls itself until the stack ends.
fn deep(depth: u64) -> u64 {
    if std::hint::black_box(depth) == 0 { 0 } else { 1 + std::hint::black_box(deep(depth - 1)) }
}
