//! Intersection of half-spaces.

use glanz_math::DVec3;
use glanz_math::rounding::gamma;

use super::HalfSpace;
use crate::error::SurfaceError;

/// A corner of a facet, and the half-space whose plane bounds the facet between this corner and the next.
#[derive(Clone, Copy, Debug)]
struct FacetCorner {
    position: DVec3,
    /// Bound on the error of the position, metres.
    error: f64,
    /// Number of that half-space; `None` for the initial square.
    edge: Option<usize>,
}

/// A facet: its half-space with unit normal, and the indices of its corners, counter-clockwise as seen from outside.
pub(super) struct FacetOutline {
    pub(super) plane: HalfSpace,
    pub(super) corners: Vec<usize>,
}

/// A bounded polyhedron with volume.
pub(super) struct ConvexSolid {
    pub(super) vertices: Vec<DVec3>,
    /// Bound on the error of any vertex, metres.
    pub(super) error: f64,
    pub(super) outlines: Vec<FacetOutline>,
}

/// The intersection of half-spaces.
///
/// On every plane, a large square is clipped by all other half-spaces; the remaining polygon is a facet. Corners are computed
/// from their three planes, not from other corners, so that the size of the initial square costs no digits. Half-spaces whose
/// facet is not wider than rounding are redundant; the others are clipped again without them.
pub(super) fn intersect(half_spaces: &[HalfSpace]) -> Result<ConvexSolid, SurfaceError> {
    let mut planes = distinct(half_spaces)?;
    if let Some(direction) = open_direction(&planes) {
        return Err(SurfaceError::Unbounded { direction: direction.to_array() });
    }
    loop {
        let polygons = clip_all(&planes)?;
        let keep: Vec<bool> = polygons.iter().map(|p| has_area(p)).collect();
        if keep.iter().filter(|&&k| k).count() < 4 {
            return Err(SurfaceError::Degenerate {
                reason: "the intersection of the half-spaces has no volume, facets",
                value: keep.iter().filter(|&&k| k).count() as f64,
            });
        }
        if keep.iter().all(|&k| k) {
            return assemble(&planes, &polygons);
        }
        let mut kept = keep.iter();
        planes.retain(|_| kept.next().copied().unwrap_or(false));
    }
}

/// The half-spaces with unit normals; of those with the same normal, the smallest.
fn distinct(half_spaces: &[HalfSpace]) -> Result<Vec<HalfSpace>, SurfaceError> {
    let mut planes: Vec<HalfSpace> = Vec::with_capacity(half_spaces.len());
    for h in half_spaces {
        for x in h.normal.to_array() {
            crate::error::finite("normal", x)?;
        }
        crate::error::finite("distance", h.distance)?;
        let length = crate::error::positive("length of a normal", h.normal.length())?;
        let plane = HalfSpace { normal: h.normal / length, distance: h.distance / length };
        // Normals that are meant to be equal differ by up to two roundings per axis after normalization.
        match planes.iter_mut().find(|p| p.normal.distance(plane.normal) <= gamma(4)) {
            Some(same) => same.distance = same.distance.min(plane.distance),
            None => planes.push(plane),
        }
    }
    if planes.len() < 4 {
        return Err(SurfaceError::TooFew {
            parameter: "half-spaces of different normals",
            count: planes.len(),
            min: 4,
        });
    }
    Ok(planes)
}

/// A direction in which the intersection is unbounded, if there is one.
///
/// These directions form the cone of solutions of `n . x <= 0`. If it is more than a point, it has an extreme ray in two of the
/// planes, or contains the line of two of them, or all normals are parallel, which four distinct ones are not.
fn open_direction(planes: &[HalfSpace]) -> Option<DVec3> {
    for (i, a) in planes.iter().enumerate() {
        for b in planes.iter().skip(i + 1) {
            let cross = a.normal.cross(b.normal);
            let sine = cross.length();
            if sine <= gamma(8) {
                continue;
            }
            let axis = cross / sine;
            // The cross product is off by a few roundings of one.
            let tolerance = gamma(8) / sine;
            for direction in [axis, -axis] {
                if planes.iter().all(|p| p.normal.dot(direction) <= tolerance) {
                    return Some(direction);
                }
            }
        }
    }
    None
}

fn clip_all(planes: &[HalfSpace]) -> Result<Vec<Vec<FacetCorner>>, SurfaceError> {
    let reach = planes.iter().fold(0.0_f64, |a, p| a.max(p.distance.abs()));
    let mut reach = if reach > 0.0 { 4.0 * reach } else { 1.0 };
    // The size of the intersection is not known in advance: the initial square grows until no corner of it remains.
    while reach.is_finite() {
        let polygons: Vec<Vec<FacetCorner>> = (0..planes.len()).map(|i| facet(planes, i, reach)).collect();
        if polygons.iter().flatten().all(|c| c.edge.is_some()) {
            return Ok(polygons);
        }
        reach *= 64.0;
    }
    Err(SurfaceError::Unbounded { direction: [0.0; 3] })
}

/// The polygon that the other half-spaces leave of plane `i`.
fn facet(planes: &[HalfSpace], i: usize, reach: f64) -> Vec<FacetCorner> {
    let Some(plane) = planes.get(i) else { return Vec::new() };
    let (x, y) = plane.normal.any_orthonormal_pair();
    let center = plane.normal * plane.distance;
    let mut corners: Vec<FacetCorner> = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
        .into_iter()
        .map(|(u, v)| FacetCorner {
            position: center + (x * u + y * v) * reach,
            error: reach * gamma(8),
            edge: None,
        })
        .collect();
    for (j, other) in planes.iter().enumerate() {
        if j != i {
            corners = clip(planes, &corners, plane, j, other);
        }
    }
    corners
}

/// The part of a polygon in `plane` that lies in the half-space `other`, number `j`.
fn clip(
    planes: &[HalfSpace],
    corners: &[FacetCorner],
    plane: &HalfSpace,
    j: usize,
    other: &HalfSpace,
) -> Vec<FacetCorner> {
    // Corners within rounding of the plane are kept: four and more planes may share a corner.
    let outside = |c: &FacetCorner| {
        let height = other.normal.dot(c.position) - other.distance;
        (height, height > c.error + gamma(8) * (c.position.length() + other.distance.abs()))
    };
    let mut result = Vec::with_capacity(corners.len() + 1);
    for (k, a) in corners.iter().enumerate() {
        let Some(b) = corners.get((k + 1) % corners.len()) else { continue };
        let ((height_a, out_a), (height_b, out_b)) = (outside(a), outside(b));
        if !out_a {
            result.push(*a);
        }
        if out_a != out_b {
            let third = a.edge.and_then(|e| planes.get(e));
            let (position, error) = third.and_then(|t| common_point(plane, other, t)).unwrap_or_else(|| {
                let fraction = (height_a / (height_a - height_b)).clamp(0.0, 1.0);
                (a.position.lerp(b.position, fraction), a.error.max(b.error) + gamma(8) * a.position.length())
            });
            result.push(FacetCorner { position, error, edge: if out_b { Some(j) } else { a.edge } });
        }
    }
    result
}

/// The common point of three planes, and a bound on its error.
fn common_point(a: &HalfSpace, b: &HalfSpace, c: &HalfSpace) -> Option<(DVec3, f64)> {
    let (bc, ca, ab) = (b.normal.cross(c.normal), c.normal.cross(a.normal), a.normal.cross(b.normal));
    let determinant = a.normal.dot(bc);
    if determinant.abs() <= gamma(16) {
        return None;
    }
    let position = (bc * a.distance + ca * b.distance + ab * c.distance) / determinant;
    // Cramer's rule: products of unit vectors with a dozen roundings each, divided by the determinant.
    let size = a.distance.abs() + b.distance.abs() + c.distance.abs() + position.length();
    Some((position, gamma(16) * size / determinant.abs()))
}

fn doubled_area(corners: &[FacetCorner]) -> f64 {
    let Some(first) = corners.first() else { return 0.0 };
    let fan = corners.windows(2).map(|w| match w {
        [a, b] => (a.position - first.position).cross(b.position - first.position),
        _ => DVec3::ZERO,
    });
    fan.sum::<DVec3>().length()
}

/// Whether a polygon is wider than the error of its corners.
fn has_area(corners: &[FacetCorner]) -> bool {
    let Some(first) = corners.first() else { return false };
    let diameter = corners.iter().fold(0.0_f64, |d, c| d.max(c.position.distance(first.position)));
    let error = corners.iter().fold(0.0_f64, |e, c| e.max(c.error));
    corners.len() >= 3 && doubled_area(corners) > 16.0 * error * diameter
}

/// The solid, with corners at the same position merged into vertices.
fn assemble(planes: &[HalfSpace], polygons: &[Vec<FacetCorner>]) -> Result<ConvexSolid, SurfaceError> {
    let mut vertices: Vec<(DVec3, f64)> = Vec::new();
    let mut outlines = Vec::with_capacity(planes.len());
    for (plane, polygon) in planes.iter().zip(polygons) {
        let mut corners: Vec<usize> = Vec::with_capacity(polygon.len());
        for c in polygon {
            let known = vertices.iter().position(|(p, e)| p.distance(c.position) <= 2.0 * (e + c.error));
            let index = known.unwrap_or(vertices.len());
            if known.is_none() {
                vertices.push((c.position, c.error));
            }
            if corners.last() != Some(&index) {
                corners.push(index);
            }
        }
        if corners.len() > 1 && corners.first() == corners.last() {
            corners.pop();
        }
        if corners.len() < 3 {
            return Err(SurfaceError::Degenerate {
                reason: "a facet is narrower than rounding, corners",
                value: corners.len() as f64,
            });
        }
        outlines.push(FacetOutline { plane: *plane, corners });
    }
    let error = vertices.iter().fold(0.0_f64, |a, (_, e)| a.max(*e));
    Ok(ConvexSolid { vertices: vertices.into_iter().map(|(p, _)| p).collect(), error, outlines })
}
