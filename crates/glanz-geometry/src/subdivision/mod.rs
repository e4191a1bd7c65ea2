//! Loop's subdivision surfaces: a control mesh of triangles, divided and moved to the limit.
//!
//! A level divides every triangle into four. Vertices in the interior move by the one-ring weights of Warren, those of a border by the
//! weights of cubic splines, so that the border depends on itself alone. After the last level all vertices are moved to where infinitely many
//! levels would take them, with the normals of the limit surface.
//!
//! # Source
//! @loop1987 with the boundary rules of @hoppe1994, as in @pharr2016 section 3.8; departures: the limit of a border is that of its cubic spline, with the
//! weights 1/6 (there 1/5), and tangents are computed from the vertices of the last level, for which their weights are derived, not from the limits of these.

mod edges;

use std::f64::consts::{PI, TAU};

use glanz_math::DVec3;

use self::edges::{EdgeTable, VertexRing};
use crate::error::{SurfaceError, finite};

/// Largest number of triangles after the last level.
const MOST_TRIANGLES: usize = 1 << 22;

/// Points of a limit surface.
#[derive(Clone, Debug, PartialEq)]
pub struct SubdividedMesh {
    /// Points of the limit surface, metres; those of the control mesh are the first, in its order.
    pub positions: Vec<DVec3>,
    /// Normals of the limit surface at the points, of any length; zero where it has none. As in pbrt they point to the side from which the corners of
    /// a triangle are seen clockwise.
    pub normals: Vec<DVec3>,
    /// Triples of points.
    pub triangles: Vec<[u32; 3]>,
}

/// The limit surface of a control mesh at the vertices of this level.
///
/// `triangles` are positions in the list of control points. Neighbours pass their common edge in opposite directions, and the triangles around a
/// vertex are one fan. Control points without a triangle stay where they are.
///
/// # Errors
/// [`SurfaceError::NotFinite`], [`SurfaceError::BadIndex`], [`SurfaceError::NotManifold`], [`SurfaceError::TooFew`] without a triangle,
/// [`SurfaceError::TooMany`] if the level has more than 4 million triangles.
pub fn loop_subdivision(
    positions: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    levels: u32,
) -> Result<SubdividedMesh, SurfaceError> {
    check(&positions, &triangles, levels)?;
    let (mut positions, mut triangles) = (positions, triangles);
    for _ in 0..levels {
        let edges = EdgeTable::try_new(&triangles, positions.len())?;
        (positions, triangles) = divided(&positions, &triangles, &edges);
    }
    let edges = EdgeTable::try_new(&triangles, positions.len())?;
    let normals = limit_normals(&positions, &triangles, &edges)?;
    let positions = weighted(&positions, &edges, limit_weight, 1.0 / 6.0);
    Ok(SubdividedMesh { positions, normals, triangles })
}

fn check(positions: &[DVec3], triangles: &[[u32; 3]], levels: u32) -> Result<(), SurfaceError> {
    for point in positions {
        finite("control point", point.element_sum())?;
    }
    if triangles.is_empty() {
        return Err(SurfaceError::TooFew { parameter: "triangles", count: 0, min: 1 });
    }
    let corners = || triangles.iter().flatten().enumerate();
    if let Some((position, &index)) = corners().find(|(_, index)| **index as usize >= positions.len()) {
        let (index, count) = (u64::from(index), positions.len());
        return Err(SurfaceError::BadIndex { parameter: "corner of triangle", position, index, count });
    }
    let count = triangles.len().saturating_mul(4_usize.saturating_pow(levels));
    if count > MOST_TRIANGLES {
        let parameter = "triangles after the last level";
        return Err(SurfaceError::TooMany { parameter, count, max: MOST_TRIANGLES });
    }
    Ok(())
}

/// Weight of each neighbour of a vertex in the interior with this number of neighbours, in the next level.
fn even_weight(valence: u32) -> f64 {
    if valence == 3 { 3.0 / 16.0 } else { 3.0 / (8.0 * f64::from(valence)) }
}

/// The same weight in the limit.
fn limit_weight(valence: u32) -> f64 {
    1.0 / (f64::from(valence) + 3.0 / (8.0 * even_weight(valence)))
}

/// The vertices as means of themselves and their neighbours: those of the interior with the weight `interior` of each neighbour, by their number, those
/// of a border with the weight `border` of each of the two on the border.
fn weighted(
    positions: &[DVec3],
    edges: &EdgeTable,
    interior: impl Fn(u32) -> f64,
    border: f64,
) -> Vec<DVec3> {
    let sums = edges.neighbor_sums(positions);
    positions
        .iter()
        .zip(sums)
        .map(|(&point, neighbors)| {
            let weight = if neighbors.is_border {
                border
            } else if neighbors.count > 0 {
                interior(neighbors.count)
            } else {
                return point;
            };
            point * (1.0 - f64::from(neighbors.count) * weight) + neighbors.sum * weight
        })
        .collect()
}

/// The next level.
fn divided(positions: &[DVec3], triangles: &[[u32; 3]], edges: &EdgeTable) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let mut points = weighted(positions, edges, even_weight, 0.125);
    let at = |vertex: u32| positions.get(vertex as usize).copied().unwrap_or_default();
    points.extend(edges.edges().iter().map(|edge| {
        let ends = at(edge.ends[0]) + at(edge.ends[1]);
        match edge.opposite {
            (a, Some(b)) => 0.375 * ends + 0.125 * (at(a) + at(b)),
            (_, None) => 0.5 * ends,
        }
    }));
    let count = positions.len() as u32;
    let divided = triangles.iter().enumerate().flat_map(|(face, &[a, b, c])| {
        let [ab, bc, ca] = edges.of_face(face).map(|edge| count + edge);
        [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
    });
    (points, divided.collect())
}

/// Normals of the limit surface at the vertices.
fn limit_normals(
    positions: &[DVec3],
    triangles: &[[u32; 3]],
    edges: &EdgeTable,
) -> Result<Vec<DVec3>, SurfaceError> {
    let at = |vertex: u32| positions.get(vertex as usize).copied().unwrap_or_default();
    let mut normals = vec![DVec3::ZERO; positions.len()];
    let mut ring = VertexRing::default();
    for (vertex, start) in edges.fan_starts().iter().enumerate() {
        let Some(corner) = *start else { continue };
        edges.ring(triangles, corner, &mut ring)?;
        let points = ring.vertices.iter().map(|&neighbor| at(neighbor));
        let tangents = if ring.is_border {
            let points: Vec<DVec3> = points.collect();
            border_tangents(at(vertex as u32), &points)
        } else {
            Some(interior_tangents(points))
        };
        if let (Some(normal), Some([s, t])) = (normals.get_mut(vertex), tangents) {
            // Rings are counterclockwise.
            *normal = t.cross(s);
        }
    }
    Ok(normals)
}

fn interior_tangents(ring: impl ExactSizeIterator<Item = DVec3>) -> [DVec3; 2] {
    let step = TAU / ring.len() as f64;
    ring.enumerate().fold([DVec3::ZERO; 2], |[s, t], (j, point)| {
        let (sin, cos) = (step * j as f64).sin_cos();
        [s + cos * point, t + sin * point]
    })
}

/// Tangents along and across a border at a vertex with these neighbours from border to border.
fn border_tangents(vertex: DVec3, ring: &[DVec3]) -> Option<[DVec3; 2]> {
    let [first, between @ .., last] = ring else { return None };
    let across = match between {
        [] => *first + *last - 2.0 * vertex,
        between => {
            // The eigenvector of the rules above, which differ from the source's at such vertices.
            let theta = PI / (between.len() + 1) as f64;
            let (cos, sum) = (theta.cos(), 1.0 / (0.5 * theta).tan());
            let inner = between.iter().zip(1..).map(|(point, k)| (f64::from(k) * theta).sin() * *point);
            inner.sum::<DVec3>() - sum / (1.0 + 2.0 * cos) * (cos * (*first + *last) + vertex)
        }
    };
    Some([*first - *last, across])
}

#[cfg(test)]
mod tests;
