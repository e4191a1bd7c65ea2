//! Light that stays: what diffuse surfaces send to one another, and the light maps that show it.

pub mod reconstruct;
