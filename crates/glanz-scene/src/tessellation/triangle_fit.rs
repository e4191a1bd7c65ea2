//! The distance of a triangle from its surface.

use glanz_math::{DVec2, DVec3};

use super::TessellationSettings;
use super::patch::MeshPatch;
use super::shared_edge::distance_to_segment;
use super::triangulation::{MeshSite, SiteFace, height};

/// How well a triangle fits its surface.
pub(super) struct TriangleFit {
    /// Largest distance that was measured, metres.
    pub(super) deviation: f64,
    /// Where a point is to be added; `None` if it fits.
    pub(super) divide_at: Option<DVec2>,
}

impl TriangleFit {
    /// Triangles narrower than this part of the deviation may have any normal.
    const NARROW: f64 = 0.1;

    pub(super) fn new(patch: &MeshPatch, face: &SiteFace<'_>, settings: TessellationSettings) -> Self {
        let corners = face.vertices().map(|corner| *corner.data());
        let [a, b, c] = corners.map(|corner| corner.vertex);
        let mut fit = Self { deviation: 0.0, divide_at: None };
        if a.is_some() && (a == b || a == c) || b.is_some() && b == c {
            return fit;
        }
        let normal = {
            let [a, b, c] = corners.map(|corner| corner.point);
            (b - a).cross(c - a).normalize_or_zero()
        };
        let center = corners.iter().map(|corner| corner.uv).sum::<DVec2>() / 3.0;
        fit.test(center, normal.dot(patch.point(center) - corners[0].point).abs(), settings.deviation);
        let mut longest: Option<(f64, DVec2)> = None;
        for edge in face.adjacent_edges().into_iter().filter(|edge| !edge.is_constraint_edge()) {
            let [from, to] = [edge.from(), edge.to()].map(|end| *end.data());
            let middle = 0.5 * (from.uv + to.uv);
            let distance = distance_to_segment(patch.point(middle), from.point, to.point);
            fit.test(middle, distance, settings.deviation);
            let length = from.point.distance(to.point);
            if longest.is_none_or(|(most, _)| length > most) {
                longest = Some((length, middle));
            }
        }
        if fit.divide_at.is_some() {
            return fit;
        }
        let turn = |i: usize, j: usize| {
            let (a, b) = (corners[i].normal, corners[j].normal);
            if a == DVec3::ZERO || b == DVec3::ZERO { 0.0 } else { a.angle_between(b) }
        };
        let angle = turn(0, 1).max(turn(1, 2)).max(turn(2, 0));
        // A narrow triangle across the bend of the surface may even show its back. Rounding turns those that are narrower still.
        let front = if patch.flipped { -normal } else { normal };
        let height = height(&corners.map(|corner| corner.point));
        let turned = |corner: &MeshSite| corner.normal != DVec3::ZERO && corner.normal.dot(front) < 0.5;
        let folded = height > Self::NARROW * settings.deviation && corners.iter().any(turned);
        let angle = if folded { f64::INFINITY } else { angle };
        if let Some((length, middle)) = longest
            && angle > settings.angle
            && length > settings.deviation
        {
            fit.divide_at = Some(middle);
        }
        fit
    }

    /// Takes a distance at `uv` into account.
    fn test(&mut self, uv: DVec2, distance: f64, allowed: f64) {
        if distance > self.deviation {
            self.deviation = distance;
            if distance > allowed {
                self.divide_at = Some(uv);
            }
        }
    }
}
