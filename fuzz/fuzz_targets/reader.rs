//! The entry of `cargo fuzz`: coverage-guided, by libFuzzer. The variable `GLANZ_FUZZ_TARGET` names the target.

#![no_main]

use std::sync::LazyLock;

use glanz_fuzz::targets::{Target, target};

static TARGET: LazyLock<Option<&'static Target>> =
    LazyLock::new(|| target(&std::env::var("GLANZ_FUZZ_TARGET").unwrap_or_default()));

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let target = TARGET.unwrap_or_else(|| unknown());
    (target.run)(bytes);
});

#[expect(clippy::panic, reason = "libFuzzer has no other way to end")]
fn unknown() -> ! {
    panic!("GLANZ_FUZZ_TARGET names no target; `cargo run -p glanz-fuzz -- --list` lists them")
}
