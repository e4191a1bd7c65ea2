//! Search for the patch of a freeform surface over a point of its parameters.

use glanz_math::{Bounds3, DVec2, DVec3, Ray};

use crate::bvh::{BuildOptions, Bvh};
use crate::freeform::Freeform;

/// A hierarchy over the rectangles of parameters of patches.
pub(super) struct PatchIndex {
    /// Faces with their corners.
    rectangles: Vec<(u32, [DVec2; 2])>,
    /// Corners of a box around all.
    corners: [DVec2; 2],
    bvh: Bvh,
}

impl PatchIndex {
    /// The index of the patches that lie over rectangles.
    pub(super) fn new(surface: &Freeform) -> Self {
        let faces = 0..surface.patch_count() as u32;
        let rectangles: Vec<_> =
            faces.filter_map(|face| Some((face, surface.patch_rectangle(face)?))).collect();
        let flat = |[low, high]: [DVec2; 2]| Bounds3::new(low.extend(0.0), high.extend(0.0));
        let boxes: Vec<Bounds3> = rectangles.iter().map(|(_, rectangle)| flat(*rectangle)).collect();
        let corners =
            rectangles.iter().fold([DVec2::INFINITY, DVec2::NEG_INFINITY], |[a, b], (_, [low, high])| {
                [a.min(*low), b.max(*high)]
            });
        Self { rectangles, corners, bvh: Bvh::build(&boxes, &BuildOptions::default()) }
    }

    /// The patch over a point, that with the lowest number of several, and its parameters there; the nearest if none is, and `None` without any.
    pub(super) fn find(&self, uv: DVec2) -> Option<(u32, DVec2)> {
        // Rounding puts points of the border beyond it.
        let uv = uv.max(self.corners[0]).min(self.corners[1]);
        let mut found: Option<&(u32, [DVec2; 2])> = None;
        // The beginning of any ray.
        self.bvh.any(&Ray::new(uv.extend(0.0), DVec3::X), 0.0, |leaf| {
            let rectangles =
                self.bvh.leaf(leaf).iter().filter_map(|&index| self.rectangles.get(index as usize));
            let holding = rectangles.filter(|(_, [low, high])| low.cmple(uv).all() && high.cmpge(uv).all());
            found = holding.chain(found).min_by_key(|(face, _)| *face);
            false
        });
        let away = |(_, [low, high]): &&(u32, [DVec2; 2])| uv.clamp(*low, *high).distance_squared(uv);
        let nearest = || self.rectangles.iter().min_by(|a, b| away(a).total_cmp(&away(b)));
        let (face, [low, high]) = found.or_else(nearest)?;
        Some((*face, (uv.clamp(*low, *high) - low) / (high - low)))
    }
}
