//! Light that stays: what diffuse surfaces send to one another, and the light maps that show it.

pub mod bake;
pub mod charts;
pub mod elements;
pub mod form_factor;
pub mod reconstruct;
#[cfg(test)]
mod scenes;
pub mod solve;
pub mod tessellate;
