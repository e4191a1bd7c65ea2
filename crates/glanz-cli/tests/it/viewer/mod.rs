//! The viewer from end to end: `glanz view` as a user starts it, its page in a real browser, and many pages at once.

mod browser;
mod devtools;
mod hands;
mod http;
mod page;
mod seen;
mod served;
mod soak;
mod surfaces;
