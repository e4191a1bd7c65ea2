//! Patches of the parameters of a face.

use glanz_geometry::FaceDomain;
use glanz_math::DVec2;

/// Smaller abscissa of the Gauss rule with two points on [0, 1].
const GAUSS_2: f64 = 0.211_324_865_405_187_1;

/// A rectangle or a triangle of parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ParameterPatch {
    /// All parameters from `min` to `max`.
    Rectangle {
        /// Smallest u and v.
        min: DVec2,
        /// Largest u and v.
        max: DVec2,
    },
    /// The triangle with these corners.
    Triangle([DVec2; 3]),
}

impl ParameterPatch {
    /// The unit square.
    pub const SQUARE: Self = Self::Rectangle { min: DVec2::ZERO, max: DVec2::ONE };

    /// The smallest number of patches that cover a face.
    pub fn of_face(domain: &FaceDomain) -> Vec<Self> {
        match domain {
            FaceDomain::Square => vec![Self::SQUARE],
            FaceDomain::Polygon(corners) => Self::fan(corners),
        }
    }

    /// Triangles from the first corner that cover a convex polygon.
    pub(super) fn fan(corners: &[DVec2]) -> Vec<Self> {
        match corners {
            [a, rest @ ..] => rest.windows(2).map(|pair| Self::Triangle([*a, pair[0], pair[1]])).collect(),
            [] => Vec::new(),
        }
    }

    /// The four patches between the middles of its sides.
    #[must_use]
    pub fn quarters(&self) -> [Self; 4] {
        match *self {
            Self::Rectangle { min, max } => {
                let half = 0.5 * (max - min);
                [DVec2::ZERO, DVec2::X, DVec2::Y, DVec2::ONE].map(|corner| {
                    let low = min + corner * half;
                    Self::Rectangle { min: low, max: low + half }
                })
            }
            Self::Triangle([a, b, c]) => {
                let [ab, bc, ca] = [0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)];
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [bc, ca, ab]].map(Self::Triangle)
            }
        }
    }

    /// Division of a rectangle into `columns` x `rows` equal ones, row by row; a triangle is returned unchanged.
    pub fn grid(&self, columns: u32, rows: u32) -> Vec<Self> {
        let Self::Rectangle { min, max } = *self else { return vec![*self] };
        let at = |i: u32, j: u32| {
            let share = DVec2::new(f64::from(i) / f64::from(columns), f64::from(j) / f64::from(rows));
            min + share * (max - min)
        };
        let cell = |i, j| Self::Rectangle { min: at(i, j), max: at(i + 1, j + 1) };
        (0..rows).flat_map(|j| (0..columns).map(move |i| cell(i, j))).collect()
    }

    /// Its corners, in order around it.
    #[must_use]
    pub fn corners(&self) -> Vec<DVec2> {
        match *self {
            Self::Rectangle { min, max } => {
                vec![min, DVec2::new(max.x, min.y), max, DVec2::new(min.x, max.y)]
            }
            Self::Triangle(corners) => corners.to_vec(),
        }
    }

    /// Its middle: the mean of the corners.
    #[must_use]
    pub fn center(&self) -> DVec2 {
        match *self {
            Self::Rectangle { min, max } => 0.5 * (min + max),
            Self::Triangle([a, b, c]) => (a + b + c) / 3.0,
        }
    }

    /// A point that is uniform if `share` is uniform over the unit square.
    #[must_use]
    pub fn at(&self, share: DVec2) -> DVec2 {
        match *self {
            Self::Rectangle { min, max } => min + share * (max - min),
            Self::Triangle([a, b, c]) => {
                let share = if share.x + share.y > 1.0 { 1.0 - share } else { share };
                a + share.x * (b - a) + share.y * (c - a)
            }
        }
    }

    /// Its area in the parameters.
    #[must_use]
    pub fn size(&self) -> f64 {
        match *self {
            Self::Rectangle { min, max } => (max - min).element_product(),
            Self::Triangle([a, b, c]) => 0.5 * (b - a).perp_dot(c - a).abs(),
        }
    }

    /// Whether parameters are inside or on the border.
    #[must_use]
    pub fn contains(&self, uv: DVec2) -> bool {
        match *self {
            Self::Rectangle { min, max } => uv.cmpge(min).all() && uv.cmple(max).all(),
            Self::Triangle([a, b, c]) => {
                let turn = |p: DVec2, q: DVec2| (q - p).perp_dot(uv - p);
                let turns = [turn(a, b), turn(b, c), turn(c, a)];
                turns.iter().all(|&t| t >= 0.0) || turns.iter().all(|&t| t <= 0.0)
            }
        }
    }

    /// Quadrature points of equal weight, exact for polynomials of degree 3 over a rectangle (Gauss) and of degree 2 over a triangle.
    pub fn quadrature_points(&self) -> Vec<DVec2> {
        match *self {
            Self::Rectangle { min, max } => {
                let at = |x: f64, y: f64| min + DVec2::new(x, y) * (max - min);
                let (low, high) = (GAUSS_2, 1.0 - GAUSS_2);
                vec![at(low, low), at(high, low), at(low, high), at(high, high)]
            }
            Self::Triangle([a, b, c]) => {
                let third = (a + b + c) / 6.0;
                vec![third + 0.5 * a, third + 0.5 * b, third + 0.5 * c]
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn patches() -> [ParameterPatch; 2] {
        let rectangle = ParameterPatch::Rectangle { min: DVec2::new(0.2, 0.1), max: DVec2::new(0.6, 0.9) };
        [
            rectangle,
            ParameterPatch::Triangle([DVec2::new(0.1, 0.2), DVec2::new(0.9, 0.3), DVec2::new(0.4, 1.0)]),
        ]
    }

    #[test]
    fn quarters_fill_the_patch() {
        for patch in patches() {
            let quarters = patch.quarters();
            assert!((quarters.iter().map(ParameterPatch::size).sum::<f64>() - patch.size()).abs() < 1e-15);
            let mean = quarters.iter().fold(DVec2::ZERO, |sum, quarter| sum + 0.25 * quarter.center());
            assert!(mean.distance(patch.center()) < 1e-15);
            assert!(quarters.iter().all(|quarter| (quarter.size() / patch.size() - 0.25).abs() < 1e-12));
        }
    }

    #[test]
    fn middle_and_corners_belong_to_the_patch_and_points_beyond_a_corner_do_not() {
        for patch in patches() {
            let middle = patch.center();
            assert!(patch.contains(middle));
            for corner in patch.corners() {
                assert!(patch.contains(corner) && !patch.contains(corner + 0.01 * (corner - middle)));
            }
        }
    }

    #[test]
    fn quadrature_points_integrate_exactly() {
        // Second moments about the middle, from the corners: a rectangle's are a^2 / 12, a triangle's the mean of the
        // squared corners over 4.
        for patch in patches() {
            let center = patch.center();
            let points = patch.quadrature_points();
            let moment = |i: usize, j: usize| {
                points.iter().map(|&p| (p - center)[i] * (p - center)[j]).sum::<f64>() / points.len() as f64
            };
            let corners = patch.corners();
            let expected = |i: usize, j: usize| {
                let sum: f64 = corners.iter().map(|&p| (p - center)[i] * (p - center)[j]).sum();
                // Of a rectangle with half sides h: h^2 / 3, and the corners' mean is h^2.
                sum / corners.len() as f64 / if corners.len() == 4 { 3.0 } else { 4.0 }
            };
            for (i, j) in [(0, 0), (0, 1), (1, 1)] {
                assert!((moment(i, j) - expected(i, j)).abs() < 1e-15, "{patch:?} {i} {j}");
            }
        }
    }

    #[test]
    fn grid_goes_row_by_row() {
        let grid = ParameterPatch::SQUARE.grid(4, 2);
        assert_eq!(grid.len(), 8);
        assert_eq!(
            grid[5],
            ParameterPatch::Rectangle { min: DVec2::new(0.25, 0.5), max: DVec2::new(0.5, 1.0) }
        );
    }
}
