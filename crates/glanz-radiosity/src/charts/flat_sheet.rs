//! Faces projected onto a plane.

use std::collections::BTreeMap;

use glanz_math::DVec2;

/// Cells per side of the grid for lookup of triangles.
const CELLS: usize = 64;

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
    cells: Vec<Vec<u32>>,
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
        let mut cells = vec![Vec::new(); CELLS * CELLS];
        for (number, triangle) in (0_u32..).zip(&mut triangles) {
            triangle.corners = triangle.corners.map(|p| p - low);
            by_face.entry(triangle.face).or_default().push(number);
            let [a, b, c] = triangle.corners.map(|p| cell(p, size));
            let range = |axis: usize| a[axis].min(b[axis]).min(c[axis])..=a[axis].max(b[axis]).max(c[axis]);
            for y in range(1) {
                for x in range(0) {
                    cells[y * CELLS + x].push(number);
                }
            }
        }
        Self { triangles, by_face, cells, size, shrink }
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
        let [x, y] = cell(point, self.size);
        let near = self.cells[y * CELLS + x].iter().filter_map(|&i| self.triangles.get(i as usize));
        near.filter(move |triangle| weights(&triangle.corners, point).into_iter().all(|w| w >= -1e-9))
    }

    pub(super) fn sheet_point(&self, face: u32, uv: DVec2) -> Option<DVec2> {
        let triangles = self.by_face.get(&face)?.iter().filter_map(|&i| self.triangles.get(i as usize));
        // All triangles of a facet have the same affine map.
        let inside = |t: &&FlatTriangle| weights(&t.parameters, uv).into_iter().all(|w| w >= -1e-9);
        let triangle = triangles.clone().find(inside).or(triangles.clone().next())?;
        Some(blend(weights(&triangle.parameters, uv), &triangle.corners))
    }
}

fn cell(point: DVec2, size: DVec2) -> [usize; 2] {
    let share = (point / size).max(DVec2::ZERO) * CELLS as f64;
    share.to_array().map(|x| (x as usize).min(CELLS - 1))
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
