//! The server as its visitors see it: over the network.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test that cannot set up its server has failed"
)]

mod admission;
mod client;
mod conversation;
mod denoising;
mod opened_scenes;
mod page;
mod rendering;
mod upload;
mod watching;
