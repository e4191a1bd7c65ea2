//! Convex polyhedra, as what half-spaces have in common.

mod build;

use glanz_math::rounding::gamma;
use glanz_math::{AreaPdf, Bounds3, DVec2, DVec3, Frame, Ray};

use crate::error::SurfaceError;
use crate::hit::{Hit, SurfacePoint, SurfaceSample};
use crate::surface::RaySurface;
use crate::triangle::sample_barycentric;

/// The points with `normal . x <= distance`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfSpace {
    /// Points out; of any length but zero.
    pub normal: DVec3,
    /// Distance of the plane from the origin along the normal, times its length.
    pub distance: f64,
}

/// A side of a [`Polyhedron`].
#[derive(Clone, Debug, PartialEq)]
pub struct Facet {
    plane: HalfSpace,
    /// Middle and axes of the facet's own coordinates.
    center: DVec3,
    frame: Frame,
    corners: Vec<usize>,
    area: f64,
    /// Absolute error per axis of points on the facet.
    error: f64,
}

impl Facet {
    /// The half-space that the facet bounds; its normal has unit length and points out.
    #[must_use]
    pub fn half_space(&self) -> HalfSpace {
        self.plane
    }

    /// Numbers of the corners in [`Polyhedron::vertices`], counterclockwise seen from outside.
    #[must_use]
    pub fn corners(&self) -> &[usize] {
        &self.corners
    }

    /// Area, m^2.
    #[must_use]
    pub fn area(&self) -> f64 {
        self.area
    }

    /// Where the coordinates (0, 0) are: the mean of the corners.
    #[must_use]
    pub fn center(&self) -> DVec3 {
        self.center
    }
}

/// A triangle of a facet, for picking points.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Piece {
    facet: u32,
    corners: [DVec3; 3],
    area: f64,
}

/// A convex polyhedron, its normals outward.
///
/// `face` of a hit is the number of the facet. `u` and `v` are lengths in metres in the facet's own coordinates: from
/// the mean of its corners along the tangents of [`Frame::from_z`] of its normal.
///
/// Rays are clipped against one half-space after the other.
///
/// # Source
/// @kirsch2007 (document 001), @kay1986.
#[derive(Clone, Debug, PartialEq)]
pub struct Polyhedron {
    facets: Vec<Facet>,
    vertices: Vec<DVec3>,
    pieces: Vec<Piece>,
    bounds: Bounds3,
    area: f64,
    volume: f64,
}

/// One end of a ray's way through the polyhedron.
#[derive(Clone, Copy, Debug)]
struct End {
    t: f64,
    facet: usize,
}

impl Polyhedron {
    /// What the half-spaces have in common.
    ///
    /// Half-spaces that do not touch it, or in an edge or a corner only, are dropped; facets keep the order of the
    /// rest.
    ///
    /// # Errors
    /// [`SurfaceError::NotFinite`], [`SurfaceError::NotPositive`] for a normal without length,
    /// [`SurfaceError::TooFew`] with fewer than four different normals, [`SurfaceError::Unbounded`], and
    /// [`SurfaceError::Degenerate`] if nothing, or nothing with a volume beyond rounding, is left.
    pub fn try_new(half_spaces: &[HalfSpace]) -> Result<Self, SurfaceError> {
        let solid = build::solid(half_spaces)?;
        let vertices = solid.vertices;
        let corner = |i: usize| vertices.get(i).copied().unwrap_or_default();
        let middle = vertices.iter().sum::<DVec3>() / vertices.len() as f64;
        let (mut facets, mut pieces) = (Vec::new(), Vec::new());
        let mut volume = 0.0;
        for outline in solid.outlines {
            let points: Vec<DVec3> = outline.corners.iter().map(|&i| corner(i)).collect();
            let plane = outline.plane;
            let mean = points.iter().sum::<DVec3>() / points.len() as f64;
            let center = mean - plane.normal * (plane.normal.dot(mean) - plane.distance);
            let number = u32::try_from(facets.len()).unwrap_or(u32::MAX);
            let first = points.first().copied().unwrap_or_default();
            let mut area = 0.0;
            for pair in points.windows(2).skip(1) {
                let corners =
                    [first, pair.first().copied().unwrap_or(first), pair.last().copied().unwrap_or(first)];
                let piece = 0.5 * (corners[1] - first).cross(corners[2] - first).length();
                pieces.push(Piece { facet: number, corners, area: piece });
                area += piece;
            }
            volume += area * (plane.distance - plane.normal.dot(middle)) / 3.0;
            let reach = points.iter().fold(0.0_f64, |r, p| r.max(p.distance(center)));
            facets.push(Facet {
                plane,
                center,
                frame: Frame::from_z(plane.normal),
                corners: outline.corners,
                area,
                // Center and position: eight roundings each at most; height over the plane, evaluated once more by
                // the next ray: four.
                error: gamma(20) * (center.length() + reach + plane.distance.abs()),
            });
        }
        let area: f64 = facets.iter().map(|f| f.area).sum();
        if volume <= 4.0 * area * solid.error {
            return Err(SurfaceError::Degenerate {
                reason: "the half-spaces have no volume in common, m^3",
                value: volume,
            });
        }
        let slack = facets.iter().fold(solid.error, |a, f| a.max(f.error));
        let bounds = Bounds3::from_points(vertices.iter().copied()).expanded(slack);
        Ok(Self { facets, vertices, pieces, bounds, area, volume })
    }

    /// The sides.
    #[must_use]
    pub fn facets(&self) -> &[Facet] {
        &self.facets
    }

    /// The corners, metres.
    #[must_use]
    pub fn vertices(&self) -> &[DVec3] {
        &self.vertices
    }

    /// Area of all facets, m^2.
    #[must_use]
    pub fn area(&self) -> f64 {
        self.area
    }

    /// Volume, m^3.
    #[must_use]
    pub fn volume(&self) -> f64 {
        self.volume
    }

    /// Where the line of the ray enters and leaves.
    fn ends(&self, ray: &Ray) -> Option<(End, End)> {
        if !ray.origin.is_finite() || ray.direction.is_nan() || ray.direction == DVec3::ZERO {
            return None;
        }
        let mut enter = End { t: f64::NEG_INFINITY, facet: 0 };
        let mut leave = End { t: f64::INFINITY, facet: 0 };
        for (facet, f) in self.facets.iter().enumerate() {
            let depth = f.plane.distance - f.plane.normal.dot(ray.origin);
            let speed = ray.direction.dot(f.plane.normal);
            if speed == 0.0 {
                if depth < 0.0 {
                    return None;
                }
                continue;
            }
            let t = depth / speed;
            if speed < 0.0 {
                if t > enter.t {
                    enter = End { t, facet };
                }
            } else if t < leave.t {
                leave = End { t, facet };
            }
            if enter.t > leave.t {
                return None;
            }
        }
        Some((enter, leave))
    }

    fn hit(&self, ray: &Ray, end: End) -> Option<Hit> {
        let facet = self.facets.get(end.facet)?;
        let p = facet.frame.to_local(ray.at(end.t) - facet.center);
        Some(Hit { t: end.t, u: p.x, v: p.y, face: u32::try_from(end.facet).ok()? })
    }

    /// Corners of a facet in its own coordinates, in order; none if there is no such facet.
    pub(crate) fn facet_corners(&self, facet: usize) -> impl Iterator<Item = DVec2> {
        let facet = self.facets.get(facet);
        let corner = |facet: &Facet, index: usize| {
            let p = self.vertices.get(index)?;
            Some(facet.frame.to_local(*p - facet.center).truncate())
        };
        facet.into_iter().flat_map(move |facet| facet.corners.iter().filter_map(move |&i| corner(facet, i)))
    }

    pub(crate) fn point_at(&self, facet: &Facet, u: f64, v: f64) -> SurfacePoint {
        let Frame { x, y, z } = facet.frame;
        SurfacePoint {
            position: (facet.center + u * x + v * y).clamp(self.bounds.min, self.bounds.max),
            error: DVec3::splat(facet.error),
            normal: z,
            shading_normal: z,
            uv: DVec2::new(u, v),
            dpdu: x,
            dpdv: y,
            dndu: DVec3::ZERO,
            dndv: DVec3::ZERO,
        }
    }
}

impl RaySurface for Polyhedron {
    fn bounds(&self) -> Bounds3 {
        self.bounds
    }

    fn intersect(&self, ray: &Ray, t_max: f64) -> Option<Hit> {
        let (enter, leave) = self.ends(ray)?;
        let end = if enter.t > 0.0 { enter } else { leave };
        if end.t > 0.0 && end.t < t_max { self.hit(ray, end) } else { None }
    }

    fn occluded(&self, ray: &Ray, t_max: f64) -> bool {
        self.ends(ray).is_some_and(|(enter, leave)| {
            (enter.t > 0.0 && enter.t < t_max) || (leave.t > 0.0 && leave.t < t_max)
        })
    }

    fn all_hits(&self, ray: &Ray, t_max: f64, hits: &mut Vec<Hit>) {
        let Some((enter, leave)) = self.ends(ray) else { return };
        let inside = |t: f64| t > 0.0 && t < t_max;
        if inside(enter.t) {
            hits.extend(self.hit(ray, enter));
        }
        if inside(leave.t) && leave.t > enter.t {
            hits.extend(self.hit(ray, leave));
        }
    }

    /// A hit that is none of this polyhedron gives a point of the first facet.
    fn point(&self, _ray: &Ray, hit: &Hit) -> SurfacePoint {
        // There are at least four facets.
        let number = if (hit.face as usize) < self.facets.len() { hit.face as usize } else { 0 };
        self.point_at(&self.facets[number], hit.u, hit.v)
    }

    fn sample(&self, xi: DVec2) -> Option<SurfaceSample> {
        let mut rest = xi.x * self.area;
        let mut chosen = (self.pieces.last()?, 1.0_f64.next_down());
        for piece in &self.pieces {
            if rest < piece.area {
                chosen = (piece, rest / piece.area);
                break;
            }
            rest -= piece.area;
        }
        let (piece, share) = chosen;
        let [a, b, c] = piece.corners;
        let weights = sample_barycentric(DVec2::new(share, xi.y));
        let facet = self.facets.get(piece.facet as usize)?;
        let p = facet.frame.to_local(a + weights.x * (b - a) + weights.y * (c - a) - facet.center);
        Some(SurfaceSample {
            hit: Hit { t: 0.0, u: p.x, v: p.y, face: piece.facet },
            point: self.point_at(facet, p.x, p.y),
            pdf: AreaPdf(1.0 / self.area),
        })
    }

    fn area_pdf(&self, _hit: &Hit, _point: &SurfacePoint) -> Option<AreaPdf> {
        Some(AreaPdf(1.0 / self.area))
    }
}

#[cfg(test)]
mod tests;
