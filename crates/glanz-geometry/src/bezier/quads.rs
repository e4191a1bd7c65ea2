//! Conversion of a triangular patch to three patches over squares.

use glanz_math::DVec2;
use glanz_math::glam::DVec4;

use super::bernstein::mean_over_subsets;
use super::net::{BlossomArgument, advance};
use super::tensor::TensorPatch;
use super::triangle::{Barycentric, TrianglePatch};

/// A quadrilateral part of a triangular patch, between a corner, the middles of its two edges and the centroid.
#[derive(Clone, Debug, PartialEq)]
pub struct TriangleQuad {
    /// Parameters (u, v) of the triangular patch at (0, 0), (1, 0), (0, 1) and (1, 1) of `patch`.
    pub corners: [DVec2; 4],
    /// The same surface over the unit square, of the same degree in u and v and with the same orientation.
    pub patch: TensorPatch,
}

impl TriangleQuad {
    /// Parameters of the triangular patch at (u, v) of `patch`: bilinear between the corners.
    #[must_use]
    pub fn triangle_parameters(&self, u: f64, v: f64) -> DVec2 {
        let [p00, p10, p01, p11] = self.corners;
        (p00 * (1.0 - u) + p10 * u) * (1.0 - v) + (p01 * (1.0 - u) + p11 * u) * v
    }
}

impl TrianglePatch {
    /// The quadrilaterals at the first, second and third corner.
    ///
    /// From its corner, u runs along the edge to the next corner and v along the edge to the last. Inner borders have the same
    /// bits in both quadrilaterals, and so have the borders of two patches that share the control points of an edge, in either
    /// direction.
    ///
    /// # Source
    /// @farin2002 chapter 17 for the blossom f of the patch. With the bilinear map q(u, v) between the corners, f(q, ..., q)
    /// is affine in each corner of each of its n arguments: the coefficient (i, j) is the mean of f over all choices of i
    /// arguments at u = 1 and j at v = 1. With m of them at both, these are `binomial(i, m) binomial(n - i, j - m)` of the
    /// `binomial(n, j)` choices for the same i. See also @derose1993.
    #[must_use]
    pub fn to_quads(&self) -> [TriangleQuad; 3] {
        [0, 1, 2].map(|corner| self.quad(corner))
    }

    fn quad(&self, corner: usize) -> TriangleQuad {
        let n = self.degree;
        let (next, last) = ((corner + 1) % 3, (corner + 2) % 3);
        let table = Blossoms::new(self, corner);
        let mut points = Vec::with_capacity((n + 1) * (n + 1));
        for (i, j) in (0..=n).flat_map(|i| (0..=n).map(move |j| (i, j))) {
            points.push(mean_over_subsets(n, i, j, |m| table.get(m, i - m, j - m)));
        }
        let at = |c: usize| Barycentric::CORNERS[c].parameters();
        let middle = |c: usize| (at(corner) + at(c)) * 0.5;
        TriangleQuad {
            corners: [at(corner), middle(next), middle(last), DVec2::splat(1.0 / 3.0)],
            patch: TensorPatch::from_means(n, n, &self.points, points),
        }
    }
}

/// Blossom values at (centroid^m, next^p, last^q, corner^(n - m - p - q)), where next and last are middles of edges.
struct Blossoms {
    /// Values per argument count: degree + 1.
    side: usize,
    values: Vec<DVec4>,
}

impl Blossoms {
    /// The arguments are applied in this order: on inner borders only the centroid and one middle occur, the same from both
    /// sides.
    fn new(patch: &TrianglePatch, corner: usize) -> Self {
        let (next, last) = ((corner + 1) % 3, (corner + 2) % 3);
        let side = patch.degree + 1;
        let mut table = Self { side, values: vec![DVec4::ZERO; side * side * side] };
        let mut centred = patch.points.clone();
        for m in 0..side {
            let mut towards_next = centred.clone();
            for p in 0..side - m {
                let mut net = towards_next.clone();
                for q in 0..side - m - p {
                    let degree = patch.degree - m - p - q;
                    let index = table.index(m, p, q);
                    table.values[index] = net[corner_index(corner, degree)];
                    advance(&mut net, degree, BlossomArgument::Middle(corner, last));
                }
                advance(&mut towards_next, patch.degree - m - p, BlossomArgument::Middle(corner, next));
            }
            advance(&mut centred, patch.degree - m, BlossomArgument::Centroid);
        }
        table
    }

    fn index(&self, m: usize, p: usize, q: usize) -> usize {
        (m * self.side + p) * self.side + q
    }

    fn get(&self, m: usize, p: usize, q: usize) -> DVec4 {
        self.values[self.index(m, p, q)]
    }
}

/// Index of a corner of a net.
fn corner_index(corner: usize, degree: usize) -> usize {
    match corner {
        0 => 0,
        1 => degree * (degree + 1) / 2,
        _ => degree * (degree + 3) / 2,
    }
}
