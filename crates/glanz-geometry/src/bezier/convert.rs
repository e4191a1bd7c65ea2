//! Patches over squares as patches over triangles, and back.

use glanz_math::glam::DVec4;

use super::bernstein::{binomial, elevate, mean_of_ways};
use super::net::net_index;
use super::tensor::{TensorEdge, TensorPatch};
use super::triangle::{TriangleEdge, TrianglePatch, edge_row_indices, indices};

impl TensorPatch {
    /// The halves below and above the line u + v = 1, exactly, of degree p + q.
    ///
    /// The first has its corners at (u, v) = (0, 0), (1, 0) and (0, 1), the second at (1, 1), (0, 1) and (1, 0); both
    /// are turned as the patch is. Their common border has the same bits, and so have those of two patches of the same
    /// degrees that share the control points of an edge, whatever way it is run in.
    ///
    /// # Source
    /// @goldman1987. The blossom of the triangle is the mean over all ways to give p of its p + q arguments to the
    /// blossom in u and the rest to that in v, counted here for arguments that are corners.
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
                // Arguments given to u: b of j at (1, 0), k - c of k at (0, 1), the rest of p at (0, 0).
                if let Some(a) = (p + c).checked_sub(b + k) {
                    sum += source[b * (q + 1) + c] * (binomial(j, b) * binomial(k, c) * binomial(i, a));
                }
            }
            sum / binomial(n, p)
        };
        let mut points: Vec<_> = indices(n).map(point).collect();
        // Borders step by step, each of which is the same in both directions.
        for (from, to, steps) in
            [(TensorEdge::VZero, TriangleEdge::TZero, q), (TensorEdge::UZero, TriangleEdge::SZero, p)]
        {
            let border = (0..steps).fold(self.edge(from), |border, _| elevate(&border));
            for (e, point) in edge_row_indices(n, to, 0).zip(border) {
                points[e] = point;
            }
        }
        TrianglePatch::of_means(n, source, points)
    }
}

impl TrianglePatch {
    /// The same surface over the unit square, in the same degree both ways; its border u = 0 collapses to the first
    /// corner.
    ///
    /// (u, v) there is (s, t) = (u (1 - v), u v) here. The normal is turned as that of the patch.
    ///
    /// # Source
    /// @hu2001; here as the composition with a bilinear map that has two corners in one, see
    /// [`TrianglePatch::to_quads`].
    #[must_use]
    pub fn to_degenerate_tensor(&self) -> TensorPatch {
        let n = self.degree;
        let mut points = Vec::with_capacity((n + 1) * (n + 1));
        for (i, j) in (0..=n).flat_map(|i| (0..=n).map(move |j| (i, j))) {
            // Of the i arguments at u = 1, m are at the third corner and the rest at the second.
            points.push(mean_of_ways(n, i, j, |m| self.points[net_index(i - m, m)]));
        }
        TensorPatch::of_means(n, n, &self.points, points)
    }
}
