//! The viewer from end to end: `glanz view` as a user starts it, its page in a real browser, and many pages at once.

mod browser;
mod http;
mod server;
mod soak;
