//! Convex polyhedra as intersections of half-spaces.

mod build;

use glanz_math::rounding::gamma;
use glanz_math::{AreaPdf, Bounds3, DVec2, DVec3, Frame, Ray};

use crate::convex::{ConvexInterval, FacetCrossing};
use crate::error::SurfaceError;
use crate::hit::{Hit, SurfacePoint, SurfaceSample};
use crate::surface::RaySurface;
use crate::triangle::sample_barycentric;

/// The points with `normal . x <= distance`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfSpace {
    /// Outward direction, of any length but zero.
    pub normal: DVec3,
    /// Distance of the plane from the origin along the normal, times the length of the normal.
    pub distance: f64,
}

/// A side of a [`Polyhedron`].
#[derive(Clone, Debug, PartialEq)]
pub struct Facet {
    plane: HalfSpace,
    /// Origin of the facet's coordinates.
    center: DVec3,
    /// Axes of the facet's coordinates.
    frame: Frame,
    corners: Vec<usize>,
    area: f64,
    /// Absolute error per axis of points on the facet.
    error: f64,
}

impl Facet {
    /// The half-space bounded by the facet; its normal has unit length and points outward.
    #[must_use]
    pub fn half_space(&self) -> HalfSpace {
        self.plane
    }

    /// Indices of the corners in [`Polyhedron::vertices`], counter-clockwise as seen from outside.
    #[must_use]
    pub fn corners(&self) -> &[usize] {
        &self.corners
    }

    /// Area, m^2.
    #[must_use]
    pub fn area(&self) -> f64 {
        self.area
    }

    /// Origin of the coordinates (u, v): the mean of the corners.
    #[must_use]
    pub fn center(&self) -> DVec3 {
        self.center
    }
}

/// A triangle of a facet, for sampling.
#[derive(Clone, Copy, Debug, PartialEq)]
struct FacetTriangle {
    facet: u32,
    corners: [DVec3; 3],
    area: f64,
}

/// A convex polyhedron with outward normals.
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
    triangles: Vec<FacetTriangle>,
    bounds: Bounds3,
    area: f64,
    volume: f64,
}

impl Polyhedron {
    /// The intersection of half-spaces.
    ///
    /// Half-spaces whose plane does not touch it, or only in an edge or a corner, are dropped; facets keep the order of the
    /// others.
    ///
    /// # Errors
    /// [`SurfaceError::NotFinite`], [`SurfaceError::NotPositive`] for a normal of length zero,
    /// [`SurfaceError::TooFew`] with fewer than four different normals, [`SurfaceError::Unbounded`], and
    /// [`SurfaceError::Degenerate`] if the intersection has no volume beyond rounding.
    pub fn try_new(half_spaces: &[HalfSpace]) -> Result<Self, SurfaceError> {
        let solid = build::intersect(half_spaces)?;
        let vertices = solid.vertices;
        let corner = |i: usize| vertices.get(i).copied().unwrap_or_default();
        let middle = vertices.iter().sum::<DVec3>() / vertices.len() as f64;
        let (mut facets, mut triangles) = (Vec::new(), Vec::new());
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
                let triangle = 0.5 * (corners[1] - first).cross(corners[2] - first).length();
                triangles.push(FacetTriangle { facet: number, corners, area: triangle });
                area += triangle;
            }
            volume += area * (plane.distance - plane.normal.dot(middle)) / 3.0;
            let reach = points.iter().fold(0.0_f64, |r, p| r.max(p.distance(center)));
            facets.push(Facet {
                plane,
                center,
                frame: Frame::from_z(plane.normal),
                corners: outline.corners,
                area,
                // Center and position have at most eight roundings each; the height above the plane, which the next ray evaluates
                // again, has four.
                error: gamma(20) * (center.length() + reach + plane.distance.abs()),
            });
        }
        let area: f64 = facets.iter().map(|f| f.area).sum();
        if volume <= 4.0 * area * solid.error {
            return Err(SurfaceError::Degenerate {
                reason: "the intersection of the half-spaces has no volume, m^3",
                value: volume,
            });
        }
        let slack = facets.iter().fold(solid.error, |a, f| a.max(f.error));
        let bounds = Bounds3::from_points(vertices.iter().copied()).expanded(slack);
        Ok(Self { facets, vertices, triangles, bounds, area, volume })
    }

    /// The facets.
    #[must_use]
    pub fn facets(&self) -> &[Facet] {
        &self.facets
    }

    /// Positions of the vertices, metres.
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

    /// The interval of the ray's line inside the polyhedron.
    fn interval(&self, ray: &Ray) -> Option<ConvexInterval> {
        if !ray.origin.is_finite() || ray.direction.is_nan() || ray.direction == DVec3::ZERO {
            return None;
        }
        let mut interval = ConvexInterval::LINE;
        for (facet, f) in (0..).zip(&self.facets) {
            let depth = f.plane.distance - f.plane.normal.dot(ray.origin);
            let speed = ray.direction.dot(f.plane.normal);
            if speed == 0.0 {
                if depth < 0.0 {
                    return None;
                }
                continue;
            }
            let crossing = FacetCrossing { t: depth / speed, facet };
            if speed < 0.0 {
                interval.clip_start(crossing);
            } else {
                interval.clip_end(crossing);
            }
            if interval.is_empty() {
                return None;
            }
        }
        Some(interval)
    }

    fn hit(&self, ray: &Ray, crossing: FacetCrossing) -> Option<Hit> {
        let facet = self.facets.get(crossing.facet as usize)?;
        let p = facet.frame.to_local(ray.at(crossing.t) - facet.center);
        Some(Hit::new(crossing.t, p.x, p.y, crossing.facet))
    }

    /// Corners of a facet in its own coordinates, in order; empty beyond the last facet.
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
        }
    }
}

impl RaySurface for Polyhedron {
    fn bounds(&self) -> Bounds3 {
        self.bounds
    }

    fn intersect(&self, ray: &Ray, t_max: f64) -> Option<Hit> {
        self.hit(ray, self.interval(ray)?.first(t_max)?)
    }

    fn occluded(&self, ray: &Ray, t_max: f64) -> bool {
        self.interval(ray).is_some_and(|interval| interval.first(t_max).is_some())
    }

    fn all_hits(&self, ray: &Ray, t_max: f64, hits: &mut Vec<Hit>) {
        let crossings = self.interval(ray).into_iter().flat_map(|interval| interval.all(t_max));
        hits.extend(crossings.filter_map(|crossing| self.hit(ray, crossing)));
    }

    /// A hit with an invalid facet number gives a point of the first facet.
    fn point(&self, _ray: &Ray, hit: &Hit) -> SurfacePoint {
        // There are at least four facets.
        let number = if (hit.face as usize) < self.facets.len() { hit.face as usize } else { 0 };
        self.point_at(&self.facets[number], hit.u, hit.v)
    }

    fn sample(&self, xi: DVec2) -> Option<SurfaceSample> {
        let mut rest = xi.x * self.area;
        let mut chosen = (self.triangles.last()?, 1.0_f64.next_down());
        for triangle in &self.triangles {
            if rest < triangle.area {
                chosen = (triangle, rest / triangle.area);
                break;
            }
            rest -= triangle.area;
        }
        let (triangle, rest) = chosen;
        let [a, b, c] = triangle.corners;
        let weights = sample_barycentric(DVec2::new(rest, xi.y));
        let facet = self.facets.get(triangle.facet as usize)?;
        let p = facet.frame.to_local(a + weights.x * (b - a) + weights.y * (c - a) - facet.center);
        Some(SurfaceSample {
            hit: Hit::new(0.0, p.x, p.y, triangle.facet),
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
