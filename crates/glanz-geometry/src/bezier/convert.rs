//! Conversion of patches between squares and triangles.

use glanz_math::glam::DVec4;

use super::bernstein::{binomial, elevate, mean_over_subsets};
use super::net::net_index;
use super::tensor::{TensorEdge, TensorPatch};
use super::triangle::{TriangleEdge, TrianglePatch, edge_row_indices, indices};

impl TensorPatch {
    /// The halves below and above the line u + v = 1, exactly, of degree p + q.
    ///
    /// The first has its corners at (u, v) = (0, 0), (1, 0) and (0, 1), the second at (1, 1), (0, 1) and (1, 0); both keep
    /// the orientation of the patch. Their common border has the same bits in both, and so have the borders of two patches
    /// of the same degrees that share the control points of an edge, in either direction.
    ///
    /// # Source
    /// @goldman1987. The blossom of the triangle is the mean over all ways to choose p of its p + q arguments for the
    /// blossom in u and the rest for that in v; here the arguments are corners.
    #[must_use]
    pub fn to_triangles(&self) -> [TrianglePatch; 2] {
        let below = self.lower_triangle();
        let mut above = self.reversed_u().reversed_v().lower_triangle();
        let opposite = below.edge(TriangleEdge::RZero);
        for (e, point) in edge_row_indices(above.degree, TriangleEdge::RZero, 0).zip(opposite.iter().rev()) {
            above.points[e] = *point;
        }
        [below, above]
    }

    fn lower_triangle(&self) -> TrianglePatch {
        let (p, q) = self.degrees();
        let n = p + q;
        let source = self.control_points();
        let point = |(i, j, k): (usize, usize, usize)| {
            let mut sum = DVec4::ZERO;
            for (b, c) in (0..=j.min(p)).flat_map(|b| (0..=k.min(q)).map(move |c| (b, c))) {
                // Arguments of the blossom in u: b of j at (1, 0), k - c of k at (0, 1), the rest of p at (0, 0).
                if let Some(a) = (p + c).checked_sub(b + k) {
                    sum += source[b * (q + 1) + c] * (binomial(j, b) * binomial(k, c) * binomial(i, a));
                }
            }
            sum / binomial(n, p)
        };
        let mut points: Vec<_> = indices(n).map(point).collect();
        // Borders by single elevations, which give the same bits in both directions.
        for (from, to, steps) in
            [(TensorEdge::VZero, TriangleEdge::TZero, q), (TensorEdge::UZero, TriangleEdge::SZero, p)]
        {
            let border = (0..steps).fold(self.edge(from), |border, _| elevate(&border));
            for (e, point) in edge_row_indices(n, to, 0).zip(border) {
                points[e] = point;
            }
        }
        TrianglePatch::from_means(n, source, points)
    }
}

impl TrianglePatch {
    /// The same surface over the unit square, of the same degree in u and v; its border u = 0 collapses to the first corner.
    ///
    /// Its parameters (u, v) are (s, t) = (u (1 - v), u v) of this patch. The normal points to the same side.
    ///
    /// # Source
    /// @hu2001; here as the composition with a bilinear map of which two corners coincide, see [`TrianglePatch::to_quads`].
    #[must_use]
    pub fn to_degenerate_tensor(&self) -> TensorPatch {
        let n = self.degree;
        let mut points = Vec::with_capacity((n + 1) * (n + 1));
        for (i, j) in (0..=n).flat_map(|i| (0..=n).map(move |j| (i, j))) {
            // Of the i arguments at u = 1, m are at the third corner and the rest at the second.
            points.push(mean_over_subsets(n, i, j, |m| self.points[net_index(i - m, m)]));
        }
        TensorPatch::from_means(n, n, &self.points, points)
    }
}
