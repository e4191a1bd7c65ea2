//! Curves with a width that face every ray: hair, threads, blades of grass.
//!
//! A ray meets such a curve C(u) where it passes it, as seen along the ray, perpendicular to the curve at no more than half of its width; the hit is at the
//! depth of C(u). With q(u) the part of C(u) - o that is perpendicular to the ray, these are the roots of the polynomial q . q' of degree 5, all of
//! which are found. Files: `piece` (intersection with a short piece), `ribbon` (curves that have normals of their own, as spline surfaces).
//!
//! # Source
//! @pharr2023 section 6.7; departure: roots in place of a division into line segments, so that the curve is smooth at every distance.

mod piece;
mod ribbon;
#[cfg(test)]
mod tests;

use glanz_math::{AreaPdf, Bounds3, DVec2, DVec3, Ray};

use self::piece::CurvePiece;
pub use self::ribbon::{RibbonSurface, ribbon_surface};
use crate::bvh::query::{AllHits, AnyHit, ClosestHit, HitCollector};
use crate::bvh::{BuildOptions, Bvh, BvhLeaf};
use crate::error::{SurfaceError, finite, not_negative};
use crate::hit::{Hit, SurfacePoint, SurfaceSample};
use crate::surface::RaySurface;

/// Length of a piece in widths: shorter ones have tighter boxes, longer ones are fewer.
const PIECE_WIDTHS: f64 = 8.0;

/// Largest number of pieces of a segment.
const MOST_PIECES: u32 = 8;

/// How a curve that faces every ray is shaded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CurveShading {
    /// As a flat band that faces the ray.
    Flat,
    /// As a round thread: the normal turns by 180 degrees across the width.
    Cylinder,
}

/// Cubic Bézier curves with a width, which face every ray.
///
/// `Hit::face` is the segment, `u` its parameter, and `v` runs from 0 to 1 across the width. The normal faces the origin of every ray. The error of a
/// point is the width, so that rays start beyond the curve that they leave. It has no area to sample.
#[derive(Clone, Debug)]
pub struct FacingCurve {
    segments: Vec<[DVec3; 4]>,
    /// At the beginning of the first and the end of the last segment, metres.
    widths: [f64; 2],
    shading: CurveShading,
    pieces: Vec<CurvePiece>,
    bvh: Bvh,
}

impl FacingCurve {
    /// The curve of cubic Bézier segments that share their end points: 3 n + 1 control points, metres. The width changes linearly, by
    /// the number of the segment, from the first of `widths` to the last, metres.
    ///
    /// # Errors
    /// [`SurfaceError::CountMismatch`], [`SurfaceError::NotFinite`], [`SurfaceError::Negative`] for a width,
    /// [`SurfaceError::Degenerate`] if the curve is a point or has no width.
    pub fn try_new(points: &[DVec3], widths: [f64; 2], shading: CurveShading) -> Result<Self, SurfaceError> {
        for point in points {
            finite("control point", point.element_sum())?;
        }
        for width in widths {
            not_negative("width", width)?;
        }
        if points.len() % 3 != 1 || points.len() < 4 {
            let (count, expected) = (points.len(), (points.len() / 3).max(1) * 3 + 1);
            return Err(SurfaceError::CountMismatch { parameter: "control points", count, expected });
        }
        let ends = points.iter().step_by(3).skip(1);
        let segments: Vec<[DVec3; 4]> = points
            .chunks_exact(3)
            .zip(ends)
            .map(|(start, end)| [start[0], start[1], start[2], *end])
            .collect();
        let width_at = |position| linear_width(widths, position, segments.len());
        let mut pieces = Vec::new();
        for (segment, points) in (0_u32..).zip(&segments) {
            let ends = [0, 1].map(|end| width_at(f64::from(segment + end)));
            divide(segment, points, ends, &mut pieces);
        }
        if pieces.is_empty() {
            let reason = "the curve is a point or has no width; its larger width";
            return Err(SurfaceError::Degenerate { reason, value: widths[0].max(widths[1]) });
        }
        let boxes: Vec<Bounds3> = pieces.iter().map(CurvePiece::bounds).collect();
        let bvh = Bvh::build(&boxes, &BuildOptions::default());
        Ok(Self { segments, widths, shading, pieces, bvh })
    }

    /// Control points of the segments, metres.
    #[must_use]
    pub fn segments(&self) -> &[[DVec3; 4]] {
        &self.segments
    }

    /// Width at a parameter of a segment, metres.
    #[must_use]
    pub fn width(&self, segment: u32, u: f64) -> f64 {
        linear_width(self.widths, f64::from(segment) + u, self.segments.len())
    }

    /// Adds the hits with the pieces of a leaf.
    fn leaf_hits(&self, leaf: BvhLeaf, ray: &Ray, collector: &mut impl HitCollector) {
        for &piece in self.bvh.leaf(leaf) {
            if let Some(piece) = self.pieces.get(piece as usize) {
                piece.hits(ray, collector);
            }
        }
    }

    fn collect<C: HitCollector>(&self, ray: &Ray, mut collector: C) -> C {
        let t_max = collector.end();
        self.bvh.closest(ray, t_max, |leaf, _| {
            self.leaf_hits(leaf, ray, &mut collector);
            collector.end()
        });
        collector
    }

    /// Derivative of a segment; where it vanishes, the direction from its first to its last point, as in pbrt.
    fn tangent(&self, hit: &Hit) -> DVec3 {
        let segment = self.segments.get(hit.face as usize).copied().unwrap_or_default();
        let tangent = tangent_at(segment, hit.u);
        if tangent.length_squared() > 0.0 { tangent } else { segment[3] - segment[0] }
    }
}

/// The width at `position`, counted in segments, of which there are `count`, metres.
fn linear_width([start, end]: [f64; 2], position: f64, count: usize) -> f64 {
    start + (end - start) * (position / count as f64)
}

/// The point of a cubic Bézier segment at `u`.
fn point_at([a, b, c, d]: [DVec3; 4], u: f64) -> DVec3 {
    let rest = 1.0 - u;
    a * rest.powi(3) + (b * rest + c * u) * (3.0 * u * rest) + d * u.powi(3)
}

/// The derivative of a cubic Bézier segment at `u`.
fn tangent_at([a, b, c, d]: [DVec3; 4], u: f64) -> DVec3 {
    let rest = 1.0 - u;
    3.0 * ((b - a) * rest * rest + (c - b) * 2.0 * u * rest + (d - c) * u * u)
}

/// Divides a segment into pieces, unless it is a point or has no width.
fn divide(segment: u32, points: &[DVec3; 4], widths: [f64; 2], pieces: &mut Vec<CurvePiece>) {
    let length: f64 = points.windows(2).map(|pair| pair[0].distance(pair[1])).sum();
    let width = widths[0].max(widths[1]);
    if length == 0.0 || width == 0.0 {
        return;
    }
    let count = (length / (PIECE_WIDTHS * width)).ceil().clamp(1.0, f64::from(MOST_PIECES)) as u32;
    let at = |k: u32| f64::from(k) / f64::from(count);
    pieces.extend((0..count).map(|k| CurvePiece::new(segment, points, widths, [at(k), at(k + 1)])));
}

impl RaySurface for FacingCurve {
    fn bounds(&self) -> Bounds3 {
        self.bvh.bounds()
    }

    fn intersect(&self, ray: &Ray, t_max: f64) -> Option<Hit> {
        self.collect(ray, ClosestHit::before(t_max)).hit()
    }

    fn occluded(&self, ray: &Ray, t_max: f64) -> bool {
        self.bvh.any(ray, t_max, |leaf| {
            let mut collector = AnyHit::before(t_max);
            self.leaf_hits(leaf, ray, &mut collector);
            collector.found()
        })
    }

    fn all_hits(&self, ray: &Ray, t_max: f64, hits: &mut Vec<Hit>) {
        let first = hits.len();
        self.collect(ray, AllHits { t_max, hits });
        let key = |hit: &Hit| (hit.t, hit.face, hit.u);
        if let Some(found) = hits.get_mut(first..) {
            found.sort_by(|a, b| key(a).partial_cmp(&key(b)).unwrap_or(std::cmp::Ordering::Equal));
        }
        // Where pieces meet, both may have the hit.
        let position = |hit: &Hit| f64::from(hit.face) + hit.u;
        let mut last = f64::NEG_INFINITY;
        let mut index = 0;
        hits.retain(|hit| {
            index += 1;
            if index <= first {
                return true;
            }
            let is_new = (position(hit) - last).abs() > 4.0 * piece::OVERLAP;
            last = position(hit);
            is_new
        });
    }

    fn point(&self, ray: &Ray, hit: &Hit) -> SurfacePoint {
        let direction = ray.direction.normalize();
        let dpdu = self.tangent(hit);
        let across = direction.cross(dpdu).try_normalize();
        let across = across.unwrap_or_else(|| direction.any_orthonormal_vector());
        // Perpendicular to the curve, towards the ray's origin.
        let facing = across.cross(dpdu).normalize();
        let facing = if facing.is_finite() { facing } else { -direction };
        let angle = match self.shading {
            CurveShading::Flat => 0.0,
            CurveShading::Cylinder => std::f64::consts::PI * (hit.v - 0.5),
        };
        let (sin, cos) = angle.sin_cos();
        let normal = (cos * facing + sin * across).normalize();
        let width = self.width(hit.face, hit.u);
        SurfacePoint {
            position: ray.at(hit.t),
            error: DVec3::splat(width),
            normal,
            shading_normal: normal,
            uv: DVec2::new(hit.u, hit.v),
            dpdu,
            dpdv: width * (cos * across - sin * facing),
        }
    }

    /// Always `None`: how much of it a point sees depends on the point.
    fn sample(&self, _xi: DVec2) -> Option<SurfaceSample> {
        None
    }

    fn area_pdf(&self, _hit: &Hit, _point: &SurfacePoint) -> Option<AreaPdf> {
        None
    }
}
