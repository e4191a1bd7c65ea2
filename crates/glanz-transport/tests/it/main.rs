//! Integrators, films and the render loop, checked from outside.

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test that cannot set up its scene has failed, and prints figures to judge a failure by"
)]

mod alpha;
mod common;
mod furnace;
mod grid;
mod guided;
mod image_light;
mod light;
mod media;
mod noise;
mod particles;
mod same_bits;
mod spectral;
mod sppm;
mod stored;
mod texture_filter;
mod watched;
