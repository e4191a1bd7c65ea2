#![doc = include_str!("../README.md")]

pub mod bake;
pub mod charts;
#[cfg(test)]
mod circle;
pub mod elements;
pub mod form_factor;
pub mod reconstruct;
mod rectangle_grid;
#[cfg(test)]
mod scenes;
pub mod solve;
pub mod tessellate;
