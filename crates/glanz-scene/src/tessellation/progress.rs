//! The progress of a tessellation.

use std::sync::atomic::{AtomicU64, Ordering};

use glanz_job::CancelFlag;

use crate::description::{Description, GeometryDescription, ShapeDescription};

/// How much of a tessellation is done, and the request to end it; threads share it.
#[derive(Debug, Default)]
pub struct TessellationProgress {
    cancel: CancelFlag,
    done: AtomicU64,
    total: AtomicU64,
}

/// Steps of a patch: its edges are sampled, its outline is triangulated, its inside is filled.
const STEPS: u64 = 3;

/// Parts of a step that are counted.
const PARTS: u64 = 1 << 16;

impl TessellationProgress {
    /// Progress of a tessellation that ends when `cancel` is raised.
    #[must_use]
    pub fn new(cancel: CancelFlag) -> Self {
        Self { cancel, ..Self::default() }
    }

    /// Share that is done, [0, 1]. Patches count alike; how long one takes depends on its shape.
    #[must_use]
    pub fn fraction(&self) -> f64 {
        let [done, total] = [&self.done, &self.total].map(|count| count.load(Ordering::Relaxed));
        if total == 0 { 0.0 } else { (done as f64 / total as f64).min(1.0) }
    }

    /// The request to end.
    pub(super) fn cancel(&self) -> &CancelFlag {
        &self.cancel
    }

    pub(super) fn start(&self, description: &Description) {
        let groups = description.groups.iter().chain([&description.world]);
        let patches: u64 = groups.flat_map(|group| &group.shapes).map(patch_count).sum();
        self.total.store(patches.saturating_mul(STEPS * PARTS), Ordering::Relaxed);
        self.done.store(0, Ordering::Relaxed);
    }

    /// Notes that a step of this many patches is done in part: one of `parts` equal parts.
    pub(super) fn advance(&self, patches: usize, parts: usize) {
        let steps = patches as u64 * PARTS / (parts as u64).max(1);
        self.done.fetch_add(steps, Ordering::Relaxed);
    }

    /// Notes that a shape without patches is done.
    pub(super) fn skip(&self, shape: &ShapeDescription) {
        self.done.fetch_add(patch_count(shape) * STEPS * PARTS, Ordering::Relaxed);
    }
}

/// Number of patches of a shape, about.
fn patch_count(shape: &ShapeDescription) -> u64 {
    match &shape.geometry {
        GeometryDescription::BezierPatches(patches) => patches.patches.len() as u64,
        GeometryDescription::BezierTriangles(patches) => patches.patches.len() as u64,
        GeometryDescription::Bilinear { indices, .. } => indices.len() as u64,
        GeometryDescription::Cuboid { .. } => 6,
        _ => 1,
    }
}
