//! Faces projected onto a plane.

use std::collections::BTreeMap;

use glanz_math::DVec2;

use crate::rectangle_grid::RectangleGrid;

/// Largest number of cells per side of the grid for lookup of triangles; 1 if each of these fills the bounds of the sheet.
const COLUMNS: usize = 64;

/// Largest negative barycentric coordinate of a point that still is in a triangle, so that rounding leaves no gap between two.
const MAX_OUTSIDE: f64 = 1e-9;

/// A triangle of a face, projected onto the plane of a sheet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlatTriangle {
    /// Number of its face.
    pub face: u32,
    /// Corners in the plane, metres.
    pub corners: [DVec2; 3],
    /// Parameters of the corners.
    pub parameters: [DVec2; 3],
}

impl FlatTriangle {
    /// Parameters of a point of the plane.
    #[must_use]
    pub fn at(&self, point: DVec2) -> DVec2 {
        blend(weights(&self.corners, point), &self.parameters)
    }
}

/// Triangles in a plane that do not overlap; the lower left corner of their bounds is the origin.
#[derive(Clone, Debug)]
pub struct FlatSheet {
    triangles: Vec<FlatTriangle>,
    by_face: BTreeMap<u32, Vec<u32>>,
    grid: RectangleGrid,
    size: DVec2,
    shrink: f64,
}

impl FlatSheet {
    /// `shrink`: smallest ratio of a length in the plane to that on the faces, (0, 1].
    pub(super) fn new(mut triangles: Vec<FlatTriangle>, shrink: f64) -> Self {
        let corners = || triangles.iter().flat_map(|t| t.corners);
        let (low, high) =
            corners().fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(a, b), p| (a.min(p), b.max(p)));
        let size = high - low;
        let mut by_face: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        let mut bounds = Vec::with_capacity(triangles.len());
        for (number, triangle) in (0_u32..).zip(&mut triangles) {
            triangle.corners = triangle.corners.map(|p| p - low);
            by_face.entry(triangle.face).or_default().push(number);
            let [a, b, c] = triangle.corners;
            bounds.push([a.min(b).min(c), a.max(b).max(c)]);
        }
        // Scenes may have as many sheets as triangles, most of which need no grid.
        let is_filled = bounds.iter().all(|[min, max]| *min == DVec2::ZERO && *max == size);
        let grid = RectangleGrid::with_linear_memory(size, if is_filled { 1 } else { COLUMNS }, &bounds);
        Self { triangles, by_face, grid, size, shrink }
    }

    /// All triangles.
    #[must_use]
    pub fn triangles(&self) -> &[FlatTriangle] {
        &self.triangles
    }

    /// Numbers of the faces.
    #[must_use]
    pub fn faces(&self) -> Vec<u32> {
        self.by_face.keys().copied().collect()
    }

    /// Upper right corner of the bounds, metres.
    #[must_use]
    pub fn size(&self) -> DVec2 {
        self.size
    }

    /// Smallest ratio of a length in the plane to that on the faces, (0, 1].
    #[must_use]
    pub fn shrink(&self) -> f64 {
        self.shrink
    }

    pub(super) fn parameters(&self, point: DVec2) -> Option<(u32, DVec2)> {
        self.triangles_at(point).next().map(|triangle| (triangle.face, triangle.at(point)))
    }

    /// The triangles that contain a point.
    pub(super) fn triangles_at(&self, point: DVec2) -> impl Iterator<Item = &FlatTriangle> {
        let near = self.grid.near(point).iter().filter_map(|&i| self.triangles.get(i as usize));
        near.filter(move |triangle| weights(&triangle.corners, point).into_iter().all(|w| w >= -MAX_OUTSIDE))
    }

    pub(super) fn sheet_point(&self, face: u32, uv: DVec2) -> Option<DVec2> {
        let triangles = self.by_face.get(&face)?.iter().filter_map(|&i| self.triangles.get(i as usize));
        // All triangles of a facet have the same affine map.
        let inside = |t: &&FlatTriangle| weights(&t.parameters, uv).into_iter().all(|w| w >= -MAX_OUTSIDE);
        let triangle = triangles.clone().find(inside).or(triangles.clone().next())?;
        Some(blend(weights(&triangle.parameters, uv), &triangle.corners))
    }
}

/// Barycentric coordinates of a point.
pub(super) fn weights(corners: &[DVec2; 3], point: DVec2) -> [f64; 3] {
    let [a, b, c] = *corners;
    let area = (b - a).perp_dot(c - a);
    let (v, w) = ((point - a).perp_dot(c - a) / area, (b - a).perp_dot(point - a) / area);
    [1.0 - v - w, v, w]
}

fn blend([u, v, w]: [f64; 3], points: &[DVec2; 3]) -> DVec2 {
    u * points[0] + v * points[1] + w * points[2]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rectangle_grid::slender_triangles;

    #[test]
    fn sheets_of_a_single_triangle_or_of_two_halves_of_a_rectangle_take_little_memory() {
        let [a, b, c, d] = [DVec2::ZERO, DVec2::X * 3.0, DVec2::new(3.0, 2.0), DVec2::Y * 2.0];
        let triangle = |face, corners| FlatTriangle { face, corners, parameters: corners };
        for triangles in [vec![triangle(0, [a, b, c])], vec![triangle(0, [a, b, c]), triangle(1, [a, c, d])]]
        {
            let count = triangles.len() as u32;
            let sheet = FlatSheet::new(triangles, 1.0);
            assert_eq!(sheet.grid.lists().count(), 1);
            for i in 0..100 {
                let point =
                    DVec2::new(0.03, 0.02) * DVec2::new(f64::from(i) + 0.5, f64::from(i * 7 % 100) + 0.3);
                let is_below = point.y < 2.0 / 3.0 * point.x;
                let expected = if is_below { Some(0) } else { (count > 1).then_some(1) };
                assert_eq!(sheet.parameters(point).map(|(face, _)| face), expected);
            }
        }
    }

    #[test]
    fn sheets_of_slender_triangles_take_memory_in_proportion_to_their_number() {
        let fan = slender_triangles(3000);
        let triangle = |(face, &corners)| FlatTriangle { face, corners, parameters: corners };
        let sheet = FlatSheet::new((0..).zip(&fan).map(triangle).collect(), 1.0);
        let entries = sheet.grid.lists().map(<[u32]>::len).sum::<usize>();
        assert!(entries <= 16 * fan.len() + COLUMNS * COLUMNS, "{entries}");
        for (face, [_, b, c]) in (0..).zip(fan).step_by(7) {
            let found = sheet.parameters(0.4 * b + 0.4 * c);
            assert_eq!(found.map(|(found, _)| found), Some(face));
        }
    }
}
