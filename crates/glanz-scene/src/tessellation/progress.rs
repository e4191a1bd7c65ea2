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

/// A step of the work on a patch.
#[derive(Clone, Copy, Debug)]
pub(super) enum PatchStep {
    /// Its edges are sampled.
    Edges,
    /// Its outline is triangulated.
    Outline,
    /// Its inside is filled.
    Filling,
}

impl PatchStep {
    /// Units of a patch.
    const UNITS: u64 = 1 << 32;

    /// Units of the step, about its share of the time on CAD models.
    fn units(self) -> u64 {
        match self {
            Self::Edges => Self::UNITS / 4,
            Self::Outline => Self::UNITS / 8,
            Self::Filling => Self::UNITS - Self::UNITS / 4 - Self::UNITS / 8,
        }
    }
}

impl TessellationProgress {
    /// Progress of a tessellation that ends when `cancel` is raised.
    #[must_use]
    pub fn new(cancel: CancelFlag) -> Self {
        Self { cancel, ..Self::default() }
    }

    /// Share that is done, [0, 1]. Patches count alike; how long one takes depends on its shape.
    #[must_use]
    pub fn fraction(&self) -> f64 {
        let [done, total] = self.counts();
        if total == 0 { 0.0 } else { (done as f64 / total as f64).min(1.0) }
    }

    /// Units that are done, and all.
    pub(super) fn counts(&self) -> [u64; 2] {
        [&self.done, &self.total].map(|count| count.load(Ordering::Relaxed))
    }

    /// The request to end.
    pub(super) fn cancel(&self) -> &CancelFlag {
        &self.cancel
    }

    pub(super) fn is_cancelled(&self) -> bool {
        self.cancel.is_cancelled()
    }

    pub(super) fn start(&self, description: &Description) {
        let groups = description.groups.iter().chain([&description.world]);
        let patches: u64 = groups.flat_map(|group| &group.shapes).map(patch_count).sum();
        self.total.store(patches.saturating_mul(PatchStep::UNITS), Ordering::Relaxed);
        self.done.store(0, Ordering::Relaxed);
    }

    /// Notes that a step of this many patches is done in part: one of `parts` equal parts.
    pub(super) fn advance(&self, step: PatchStep, patches: usize, parts: usize) {
        let done = patches as u64 * step.units() / (parts as u64).max(1);
        self.done.fetch_add(done, Ordering::Relaxed);
    }

    /// Notes that a shape without patches is done.
    pub(super) fn skip(&self, shape: &ShapeDescription) {
        self.done.fetch_add(patch_count(shape) * PatchStep::UNITS, Ordering::Relaxed);
    }
}

/// Number of patches of a shape.
fn patch_count(shape: &ShapeDescription) -> u64 {
    match &shape.geometry {
        GeometryDescription::BezierPatches(patches) => patches.patches.len() as u64,
        GeometryDescription::BezierTriangles(patches) => patches.patches.len() as u64,
        GeometryDescription::Bilinear { indices, .. } => indices.len() as u64,
        GeometryDescription::Cuboid { .. } => 6,
        _ => 1,
    }
}
