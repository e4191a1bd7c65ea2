//! Tests of resolved scenes through the public interface.

#![allow(clippy::unwrap_used, reason = "a test that cannot make its scene has failed")]

mod alpha;
mod area_lights;
mod batch;
mod differential;
mod emission;
mod image_light;
mod light_selection;
mod limits;
mod photometric;
mod receivers;
mod scene;
mod section;
mod smooth_edges;
mod solid_forms;
mod solids;
mod surface_detail;
