//! From half-spaces to facets.

use glanz_math::DVec3;
use glanz_math::rounding::gamma;

use super::HalfSpace;
use crate::error::SurfaceError;

/// A corner of a facet, with the half-space whose plane bounds the facet from here to the next corner.
#[derive(Clone, Copy, Debug)]
struct Corner {
    position: DVec3,
    /// Bound on the error of the position, metres.
    error: f64,
    /// `None` on the square that clipping starts from.
    edge: Option<usize>,
}

/// A facet: its half-space, of unit normal, and its corners counterclockwise seen from outside.
pub(super) struct Outline {
    pub(super) plane: HalfSpace,
    pub(super) corners: Vec<usize>,
}

/// A bounded polyhedron with volume.
pub(super) struct Solid {
    pub(super) vertices: Vec<DVec3>,
    /// Bound on the error of any vertex, metres.
    pub(super) error: f64,
    pub(super) outlines: Vec<Outline>,
}

/// The solid between the planes.
///
/// Every plane is a polygon that all others clip; what is left is a facet. Corners are solved for from their three
/// planes, not from each other, so that they lose no digits to the size of the square at the start. Half-spaces
/// whose facet has no width beyond rounding are redundant; the rest is clipped again without them.
pub(super) fn solid(half_spaces: &[HalfSpace]) -> Result<Solid, SurfaceError> {
    let mut planes = distinct(half_spaces)?;
    if let Some(direction) = open_direction(&planes) {
        return Err(SurfaceError::Unbounded { direction: direction.to_array() });
    }
    loop {
        let polygons = clip_all(&planes)?;
        let keep: Vec<bool> = polygons.iter().map(|p| has_area(p)).collect();
        if keep.iter().filter(|&&k| k).count() < 4 {
            return Err(SurfaceError::Degenerate {
                reason: "the half-spaces have no volume in common, facets",
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

/// Unit normals; of half-spaces with the same normal, the narrower one.
fn distinct(half_spaces: &[HalfSpace]) -> Result<Vec<HalfSpace>, SurfaceError> {
    let mut planes: Vec<HalfSpace> = Vec::with_capacity(half_spaces.len());
    for h in half_spaces {
        for x in h.normal.to_array() {
            crate::error::finite("normal", x)?;
        }
        crate::error::finite("distance", h.distance)?;
        let length = crate::error::positive("length of a normal", h.normal.length())?;
        let plane = HalfSpace { normal: h.normal / length, distance: h.distance / length };
        // Two normals that were normalised differ by two roundings per axis where they are meant to be the same.
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

/// A direction in which one can go on for ever, if there is one.
///
/// These directions form a cone, the solution of `n . x <= 0`. If it is more than a point, it has an extreme ray along
/// two of the planes, or holds a line along two of them, or all normals are parallel, which four distinct ones are
/// not.
fn open_direction(planes: &[HalfSpace]) -> Option<DVec3> {
    for (i, a) in planes.iter().enumerate() {
        for b in planes.iter().skip(i + 1) {
            let cross = a.normal.cross(b.normal);
            let sine = cross.length();
            if sine <= gamma(8) {
                continue;
            }
            let along = cross / sine;
            // The cross product is off by a few roundings of one.
            let tolerance = gamma(8) / sine;
            for direction in [along, -along] {
                if planes.iter().all(|p| p.normal.dot(direction) <= tolerance) {
                    return Some(direction);
                }
            }
        }
    }
    None
}

fn clip_all(planes: &[HalfSpace]) -> Result<Vec<Vec<Corner>>, SurfaceError> {
    let reach = planes.iter().fold(0.0_f64, |a, p| a.max(p.distance.abs()));
    let mut reach = if reach > 0.0 { 4.0 * reach } else { 1.0 };
    // Bounded, but by how much nobody knows before: the square grows until nothing of it is left.
    while reach.is_finite() {
        let polygons: Vec<Vec<Corner>> = (0..planes.len()).map(|i| facet(planes, i, reach)).collect();
        if polygons.iter().flatten().all(|c| c.edge.is_some()) {
            return Ok(polygons);
        }
        reach *= 64.0;
    }
    Err(SurfaceError::Unbounded { direction: [0.0; 3] })
}

/// What the other planes leave of plane `i`.
fn facet(planes: &[HalfSpace], i: usize, reach: f64) -> Vec<Corner> {
    let Some(plane) = planes.get(i) else { return Vec::new() };
    let (x, y) = plane.normal.any_orthonormal_pair();
    let center = plane.normal * plane.distance;
    let mut corners: Vec<Corner> = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
        .into_iter()
        .map(|(u, v)| Corner {
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
    corners: &[Corner],
    plane: &HalfSpace,
    j: usize,
    other: &HalfSpace,
) -> Vec<Corner> {
    // Corners that lie in the plane but for rounding stay: four and more planes may share one.
    let outside = |c: &Corner| {
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
            let (position, error) = third.and_then(|t| meet(plane, other, t)).unwrap_or_else(|| {
                let share = (height_a / (height_a - height_b)).clamp(0.0, 1.0);
                (a.position.lerp(b.position, share), a.error.max(b.error) + gamma(8) * a.position.length())
            });
            result.push(Corner { position, error, edge: if out_b { Some(j) } else { a.edge } });
        }
    }
    result
}

/// The point that three planes share, and a bound on its error.
fn meet(a: &HalfSpace, b: &HalfSpace, c: &HalfSpace) -> Option<(DVec3, f64)> {
    let (bc, ca, ab) = (b.normal.cross(c.normal), c.normal.cross(a.normal), a.normal.cross(b.normal));
    let determinant = a.normal.dot(bc);
    if determinant.abs() <= gamma(16) {
        return None;
    }
    let position = (bc * a.distance + ca * b.distance + ab * c.distance) / determinant;
    // Cramer's rule: products of unit vectors with a dozen roundings each, over the determinant.
    let size = a.distance.abs() + b.distance.abs() + c.distance.abs() + position.length();
    Some((position, gamma(16) * size / determinant.abs()))
}

fn doubled_area(corners: &[Corner]) -> f64 {
    let Some(first) = corners.first() else { return 0.0 };
    let fan = corners.windows(2).map(|w| match w {
        [a, b] => (a.position - first.position).cross(b.position - first.position),
        _ => DVec3::ZERO,
    });
    fan.sum::<DVec3>().length()
}

/// Whether a polygon is wider than the error of its corners.
fn has_area(corners: &[Corner]) -> bool {
    let Some(first) = corners.first() else { return false };
    let diameter = corners.iter().fold(0.0_f64, |d, c| d.max(c.position.distance(first.position)));
    let error = corners.iter().fold(0.0_f64, |e, c| e.max(c.error));
    corners.len() >= 3 && doubled_area(corners) > 16.0 * error * diameter
}

/// Corners that are the same point become one vertex.
fn assemble(planes: &[HalfSpace], polygons: &[Vec<Corner>]) -> Result<Solid, SurfaceError> {
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
        outlines.push(Outline { plane: *plane, corners });
    }
    let error = vertices.iter().fold(0.0_f64, |a, (_, e)| a.max(*e));
    Ok(Solid { vertices: vertices.into_iter().map(|(p, _)| p).collect(), error, outlines })
}
