//! End-to-end tests of `glanz view`: the process, its page in a browser, and many simultaneous clients.

mod browser;
mod denoising;
mod http;
mod opened_scenes;
mod server;
mod soak;
mod upload;
