//! Scenes that are resolved, checked from outside.

#![allow(clippy::unwrap_used, reason = "a test that cannot make its scene has failed")]

mod area_lights;
mod emission;
mod photometric;
mod receivers;
mod scene;
