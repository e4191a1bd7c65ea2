//! The viewer from end to end: `glanz view` as a user starts it, its page in a real browser, and many pages at once.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test may fail")]
#![allow(clippy::print_stdout, reason = "figures are said with `--nocapture`")]

mod browser;
mod devtools;
mod hands;
mod http;
mod page;
mod seen;
mod served;
mod soak;
mod surfaces;
