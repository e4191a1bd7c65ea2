//! Patches against closed forms, identities and each other.

mod junctions;
mod parts;
mod quads;
mod values;

use glanz_math::glam::DVec4;
use glanz_math::{DVec2, DVec3};

use super::junction::{derivative_deviation, join};
use super::*;
use crate::error::SurfaceError;

/// A linear congruential generator of numbers in [0, 1).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn point(&mut self, rational: bool) -> DVec4 {
        let p = DVec3::new(self.next(), self.next(), self.next()) * 2.0 - 1.0;
        // From 1/8 to 8.
        let w = if rational { (6.0 * self.next() - 3.0).exp2() } else { 1.0 };
        (p * w).extend(w)
    }

    fn triangle(&mut self, n: usize, rational: bool) -> TrianglePatch {
        let points = (0..(n + 1) * (n + 2) / 2).map(|_| self.point(rational)).collect();
        TrianglePatch::try_new(n, points).unwrap()
    }

    fn tensor(&mut self, p: usize, q: usize, rational: bool) -> TensorPatch {
        let points = (0..(p + 1) * (q + 1)).map(|_| self.point(rational)).collect();
        TensorPatch::try_new(p, q, points).unwrap()
    }
}

const EDGES: [TriangleEdge; 3] = [TriangleEdge::TZero, TriangleEdge::RZero, TriangleEdge::SZero];

/// Parameters in the triangle, corners and border included.
fn triangle_grid() -> impl Iterator<Item = (f64, f64)> {
    (0..=4).flat_map(|i| (0..=4 - i).map(move |j| (f64::from(i) / 4.0, f64::from(j) / 4.0)))
}

fn square_grid() -> impl Iterator<Item = (f64, f64)> {
    (0..=4).flat_map(|i| (0..=4).map(move |j| (f64::from(i) / 4.0, f64::from(j) / 4.0)))
}

/// Bits of the coordinates of a net, with -0 as 0.
fn bits(points: &[DVec4]) -> Vec<[u64; 4]> {
    points.iter().map(|p| p.to_array().map(|x| (x + 0.0).to_bits())).collect()
}

fn reversed(mut points: Vec<DVec4>) -> Vec<DVec4> {
    points.reverse();
    points
}

/// The cubic patch of document 000 section 4.3.
fn pumberger() -> TrianglePatch {
    let points = [
        [6.0, 3.0, 5.0], // 300
        [6.0, 4.0, 8.0], // 210
        [5.0, 3.0, 6.0], // 201
        [6.0, 5.0, 6.0], // 120
        [4.5, 4.5, 7.0], // 111
        [4.0, 3.0, 6.0], // 102
        [6.0, 6.0, 5.0], // 030
        [5.0, 5.0, 6.0], // 021
        [4.0, 4.0, 6.0], // 012
        [3.0, 3.0, 3.0], // 003
    ];
    TrianglePatch::try_from_points(3, &points.map(DVec3::from_array), None).unwrap()
}

/// An octant of the unit sphere as a tensor product of quarter circles; its border v = 1 collapses to the pole.
fn octant() -> TensorPatch {
    // A quarter circle is (1, 0), (1, 1), (0, 1) with weights 1, 1, 2, in homogeneous form (1 - t^2, 2 t, 1 + t^2).
    let quarter = [[1.0, 0.0, 1.0], [1.0, 1.0, 1.0], [0.0, 2.0, 2.0]];
    let mut points = Vec::new();
    for [c, s, w] in quarter {
        // (radius, height, weight) of the meridian times (x, y, weight) of the parallel.
        points.extend(quarter.map(|[r, z, m]| DVec4::new(c * r, s * r, w * z, w * m)));
    }
    TensorPatch::try_new(2, 2, points).unwrap()
}
