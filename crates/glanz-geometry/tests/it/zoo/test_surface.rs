//! Surfaces under test.

use glanz_geometry::bezier::{TensorPatch, TrianglePatch};
use glanz_geometry::freeform::{Freeform, SurfacePatch};
use glanz_math::glam::DVec4;
use glanz_math::{DVec3, Ray};

use super::patch::ReferencePatch;

/// A surface of the library, and its patches in the form of the reference.
pub struct TestSurface {
    pub name: String,
    pub surface: Freeform,
    /// Patches in the order of `Hit::face`.
    pub patches: Vec<ReferencePatch>,
    /// Centre of a ball around the control points.
    pub center: DVec3,
    /// Radius of the ball, metres; accuracies are relative to it.
    pub size: f64,
    /// Largest coordinate of a control point.
    reach: f64,
    /// Whether the parameters of the pieces have the orientation of those of their patches.
    pub oriented: bool,
}

impl TestSurface {
    pub fn new(name: impl Into<String>, pieces: Vec<SurfacePatch>, oriented: bool) -> Self {
        let patches: Vec<ReferencePatch> = pieces
            .iter()
            .map(|piece| {
                ReferencePatch::new(piece.patch().degrees(), piece.patch().control_points().to_vec())
            })
            .collect();
        let points = || patches.iter().flat_map(|patch| &patch.points).map(|p| p.truncate() / p.w);
        let low = points().fold(DVec3::INFINITY, DVec3::min);
        let high = points().fold(DVec3::NEG_INFINITY, DVec3::max);
        let center = 0.5 * (low + high);
        let size = points().map(|p| p.distance(center)).fold(0.0, f64::max);
        let reach = low.abs().max(high.abs()).max_element();
        Self {
            name: name.into(),
            surface: Freeform::try_new(pieces).unwrap(),
            patches,
            center,
            size,
            reach,
            oriented,
        }
    }

    /// Patches of these degrees and homogeneous control points.
    pub fn of_nets(name: impl Into<String>, nets: Vec<((usize, usize), Vec<DVec4>)>) -> Self {
        let piece = |((p, q), points): ((usize, usize), Vec<DVec4>)| {
            let patch = TensorPatch::try_new(p, q, points).unwrap();
            SurfacePatch::over_rectangle(patch, [0.0, 1.0], [0.0, 1.0]).unwrap()
        };
        Self::new(name, nets.into_iter().map(piece).collect(), true)
    }

    /// One patch with the control point (w x, w y, w z, w) of (i, j), both as fractions of the degree.
    pub fn tensor(
        name: impl Into<String>,
        degrees: (usize, usize),
        point: impl FnMut(f64, f64) -> DVec4,
    ) -> Self {
        Self::of_nets(name, vec![(degrees, net(degrees, point))])
    }

    /// Triangular patches with their degrees.
    pub fn triangles(name: impl Into<String>, patches: Vec<(usize, Vec<DVec4>)>) -> Self {
        let pieces = patches.into_iter().flat_map(|(degree, points)| {
            let patch = TrianglePatch::try_new(degree, points.clone()).unwrap();
            let quads = patch.to_quads();
            // The quadrilaterals must be the triangle, by its own scheme of de Casteljau.
            for quad in &quads {
                for (u, v) in [(0.0, 0.0), (0.3, 0.6), (1.0, 1.0), (0.9, 0.1)] {
                    let at = quad.triangle_parameters(u, v);
                    let expected = triangle_point(degree, &points, [1.0 - at.x - at.y, at.x, at.y]);
                    let net = quad.patch.control_points().to_vec();
                    let [found, ..] = ReferencePatch::new(quad.patch.degrees(), net).tangent(u, v);
                    assert!(found.distance(expected) < 1e-13 * (1.0 + expected.length()));
                }
            }
            quads.map(|quad| SurfacePatch::over_quad(quad.patch, quad.corners).unwrap())
        });
        let pieces = pieces.collect();
        Self::new(name, pieces, false)
    }

    /// Radius of the bundle of parallel rays that must have the same roots, metres.
    ///
    /// The search has a few roundings per degree, relative to the coordinates of the surface and of the ray, and accepts roots
    /// with a few times that error.
    pub fn thickness(&self, ray: &Ray) -> f64 {
        let degrees = self.patches.iter().map(|patch| patch.degrees.0 + patch.degrees.1).max().unwrap_or(0);
        let roundings = 16 * (4 * degrees + 24);
        roundings as f64 * (0.5 * f64::EPSILON) * (self.reach + ray.origin.abs().max_element())
    }
}

/// The net of a patch: the point (i, j), both as fractions of the degree, at i (q + 1) + j.
pub fn net((p, q): (usize, usize), mut point: impl FnMut(f64, f64) -> DVec4) -> Vec<DVec4> {
    let mut points = Vec::new();
    for i in 0..=p {
        for j in 0..=q {
            points.push(point(i as f64 / p as f64, j as f64 / q as f64));
        }
    }
    points
}

/// The point of a triangular patch at barycentric coordinates. Control points in the order of the library: i descending,
/// then j.
fn triangle_point(degree: usize, points: &[DVec4], [r, s, t]: [f64; 3]) -> DVec3 {
    let index = |n: usize, i: usize, j: usize| (n - i) * (n - i + 1) / 2 + (n - i - j);
    let mut work = points.to_vec();
    for n in (0..degree).rev() {
        let mut next = vec![DVec4::ZERO; (n + 1) * (n + 2) / 2];
        for i in 0..=n {
            for j in 0..=n - i {
                next[index(n, i, j)] = work[index(n + 1, i + 1, j)] * r
                    + work[index(n + 1, i, j + 1)] * s
                    + work[index(n + 1, i, j)] * t;
            }
        }
        work = next;
    }
    work[0].truncate() / work[0].w
}
