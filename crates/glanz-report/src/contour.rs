//! Contours by marching squares.

use std::collections::{BTreeMap, BTreeSet};

/// A line along which a field has one value.
#[derive(Clone, Debug, PartialEq)]
pub struct Contour {
    /// The vertices of a polyline; the last one of a closed contour repeats the first.
    pub points: Vec<[f64; 2]>,
    /// Whether the line is closed; an open one ends at the border of the grid or of the known values.
    pub is_closed: bool,
}

/// Values at the vertices of a rectangular grid.
#[derive(Clone, Copy, Debug)]
pub struct ContourGrid<'a> {
    /// Positions of the columns, ascending.
    pub xs: &'a [f64],
    /// Positions of the rows, ascending.
    pub ys: &'a [f64],
    /// Row by row, one per vertex; `None` where the value is unknown.
    pub values: &'a [Option<f64>],
}

/// Number of an edge of the grid: twice the number of the vertex it begins at, plus 1 if it goes up a column rather than
/// along a row.
type GridEdge = usize;

impl ContourGrid<'_> {
    /// The contours at `level`. Every point lies on an edge between two vertices, where the linear interpolation
    /// of their values is `level`. Squares with an unknown value have no contour.
    ///
    /// In a square whose opposite corners lie on one side of the level and the other two on the other side, the mean of
    /// all four decides which pair is connected, so that contours neither cross nor touch.
    ///
    /// # Source
    /// Marching squares, the plane case of @lorensen1987; the rule for saddles is that of @nielson1991 with the mean
    /// in place of the saddle's value.
    #[must_use]
    pub fn contours(&self, level: f64) -> Vec<Contour> {
        let links = self.links(level);
        let mut visited = BTreeSet::new();
        let mut contours = Vec::new();
        // Open contours first, from their ends, so that only closed ones are left.
        let ends = links.iter().filter(|(_, [_, second])| second.is_none());
        for (&start, _) in ends.chain(&links) {
            if !visited.insert(start) {
                continue;
            }
            let mut path = vec![start];
            let mut next = start;
            while let Some(following) =
                links.get(&next).and_then(|to| to.iter().flatten().find(|edge| visited.insert(**edge)))
            {
                path.push(*following);
                next = *following;
            }
            let is_closed = links.get(&start).is_some_and(|to| to[1].is_some());
            let back = is_closed.then_some(start);
            let points = path.into_iter().chain(back).filter_map(|edge| self.crossing(edge, level)).collect();
            contours.push(Contour { points, is_closed });
        }
        contours
    }

    /// Number of straight segments of the contours at `level`.
    #[must_use]
    pub fn segment_count(&self, level: f64) -> usize {
        self.squares().map(|square| self.segments(square, level).into_iter().flatten().count()).sum()
    }

    fn squares(&self) -> impl Iterator<Item = [usize; 2]> {
        let columns = self.xs.len().saturating_sub(1);
        (0..self.ys.len().saturating_sub(1)).flat_map(move |y| (0..columns).map(move |x| [x, y]))
    }

    fn at(&self, [x, y]: [usize; 2]) -> Option<f64> {
        self.values.get(y * self.xs.len() + x).copied().flatten()
    }

    /// The segments in a square, each between two edges.
    fn segments(&self, [x, y]: [usize; 2], level: f64) -> [Option<[GridEdge; 2]>; 2] {
        let corners = [[x, y], [x + 1, y], [x + 1, y + 1], [x, y + 1]].map(|corner| self.at(corner));
        let [Some(a), Some(b), Some(c), Some(d)] = corners else { return [None; 2] };
        let along = |x: usize, y: usize| 2 * (y * self.xs.len() + x);
        let (bottom, top) = (along(x, y), along(x, y + 1));
        let (left, right) = (along(x, y) + 1, along(x + 1, y) + 1);
        let [a_above, b_above, c_above, d_above] = [a, b, c, d].map(|value| value >= level);
        if a_above == c_above && b_above == d_above && a_above != b_above {
            let middle_above = 0.25 * a + 0.25 * b + 0.25 * c + 0.25 * d >= level;
            return if middle_above == a_above {
                [Some([bottom, right]), Some([left, top])]
            } else {
                [Some([bottom, left]), Some([right, top])]
            };
        }
        let sides = [
            (bottom, a_above != b_above),
            (right, b_above != c_above),
            (top, c_above != d_above),
            (left, d_above != a_above),
        ];
        let mut crossed = sides.into_iter().filter(|(_, is_crossed)| *is_crossed).map(|(side, _)| side);
        [crossed.next().zip(crossed.next()).map(|(from, to)| [from, to]), None]
    }

    /// For each edge that contours cross, the edges that segments connect it with.
    fn links(&self, level: f64) -> BTreeMap<GridEdge, [Option<GridEdge>; 2]> {
        let mut links: BTreeMap<GridEdge, [Option<GridEdge>; 2]> = BTreeMap::new();
        for [from, to] in self.squares().flat_map(|square| self.segments(square, level)).flatten() {
            for (one, other) in [(from, to), (to, from)] {
                let known = links.entry(one).or_default();
                // At most two squares share an edge, so there is always room.
                known[usize::from(known[0].is_some())] = Some(other);
            }
        }
        links
    }

    fn crossing(&self, edge: GridEdge, level: f64) -> Option<[f64; 2]> {
        let (vertex, upwards) = (edge / 2, edge % 2);
        let columns = self.xs.len().max(1);
        let from = [vertex % columns, vertex / columns];
        let to = [from[0] + 1 - upwards, from[1] + upwards];
        let (a, b) = (self.at(from)?, self.at(to)?);
        let part = ((level - a) / (b - a)).clamp(0.0, 1.0);
        let position = |[x, y]: [usize; 2]| Some([*self.xs.get(x)?, *self.ys.get(y)?]);
        let (from, to) = (position(from)?, position(to)?);
        Some([0, 1].map(|axis| from[axis] + part * (to[axis] - from[axis])))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn line(count: usize, from: f64, to: f64) -> Vec<f64> {
        (0..count).map(|i| from + (to - from) * i as f64 / (count - 1) as f64).collect()
    }

    fn grid<T>(xs: &[f64], ys: &[f64], f: impl Fn(f64, f64) -> T) -> Vec<T> {
        ys.iter().flat_map(|&y| xs.iter().map(|&x| f(x, y)).collect::<Vec<_>>()).collect()
    }

    #[test]
    fn contours_of_a_point_source_are_circles_of_the_closed_form_radius() {
        // 1000 cd at 2 m: E = 1000 * 2 / (4 + r^2)^1.5, so r = sqrt((2000 / E)^(2/3) - 4).
        let xs = line(201, -5.0, 5.0);
        let values = grid(&xs, &xs, |x, y| Some(2000.0 / (4.0 + x * x + y * y).powf(1.5)));
        let grid = ContourGrid { xs: &xs, ys: &xs, values: &values };
        for level in [20.0_f64, 50.0, 100.0, 200.0, 240.0] {
            let radius = ((2000.0 / level).powf(2.0 / 3.0) - 4.0).sqrt();
            let contours = grid.contours(level);
            assert_eq!(contours.len(), 1);
            assert!(contours[0].is_closed);
            assert_eq!(contours[0].points.first(), contours[0].points.last());
            for [x, y] in &contours[0].points {
                // Linear interpolation over h = 0.05 is off by at most h^2 / 8 times the second derivative, of at most
                // 3 E(0) / h0^2 = 187.5, over the slope, of at least 0.19 lx/m per lx at these levels' radii.
                let off = x.hypot(*y) - radius;
                let slope = 3.0 * radius * level / (4.0 + radius * radius);
                assert!(off.abs() < 0.05 * 0.05 / 8.0 * 187.5 / slope, "{level}: {off}");
            }
        }
        assert_eq!(grid.contours(250.1), []);
    }

    #[test]
    fn a_contour_that_leaves_the_grid_is_open() {
        let (xs, ys) = (line(4, 0.0, 3.0), line(3, 0.0, 2.0));
        let values = grid(&xs, &ys, |x, _| Some(x));
        let contours = ContourGrid { xs: &xs, ys: &ys, values: &values }.contours(1.25);
        let expected = Contour { points: vec![[1.25, 0.0], [1.25, 1.0], [1.25, 2.0]], is_closed: false };
        assert_eq!(contours, [expected]);
    }

    #[test]
    fn the_mean_decides_at_a_saddle() {
        let xs = [0.0, 1.0];
        let lines = |values: [f64; 4], level: f64| {
            let values = values.map(Some);
            ContourGrid { xs: &xs, ys: &xs, values: &values }.contours(level)
        };
        // 4 at two opposite corners, 0 at the others; the mean is 2.
        let low = lines([4.0, 0.0, 0.0, 4.0], 1.0);
        let high = lines([4.0, 0.0, 0.0, 4.0], 3.0);
        assert_eq!((low.len(), high.len()), (2, 2));
        // Below the mean the zeros at (1, 0) and (0, 1) are cut off, above it the fours at (0, 0) and (1, 1).
        assert_eq!(low[0].points, [[0.75, 0.0], [1.0, 0.25]]);
        assert_eq!(high[0].points, [[0.25, 0.0], [0.0, 0.25]]);
    }

    #[test]
    fn there_is_no_contour_beside_what_is_missing() {
        let (xs, ys) = (line(5, 0.0, 4.0), line(3, 0.0, 2.0));
        let values = grid(&xs, &ys, |x, y| (x != 2.0 || y != 2.0).then_some(y));
        let contours = ContourGrid { xs: &xs, ys: &ys, values: &values }.contours(1.5);
        let ends: Vec<[f64; 2]> = contours.iter().map(|c| *c.points.last().unwrap()).collect();
        assert_eq!((contours.len(), ends), (2, vec![[1.0, 1.5], [4.0, 1.5]]));
        assert_eq!(ContourGrid { xs: &xs, ys: &[], values: &[] }.contours(1.0), []);
        assert_eq!(ContourGrid { xs: &xs, ys: &ys, values: &[] }.contours(1.0), []);
    }

    proptest! {
        #[test]
        fn every_point_has_the_level_and_no_line_ends_inside(
            values in prop::collection::vec(0_u8..6, 63),
            level in prop::sample::select(vec![0.5, 1.0, 2.25, 3.0, 4.9]),
        ) {
            let (xs, ys) = (line(9, 0.0, 8.0), line(7, 0.0, 6.0));
            let known: Vec<Option<f64>> = values.iter().map(|v| Some(f64::from(*v))).collect();
            let grid = ContourGrid { xs: &xs, ys: &ys, values: &known };
            let contours = grid.contours(level);
            let bilinear = |x: f64, y: f64| {
                let at = |x: f64, y: f64| f64::from(values[y as usize * 9 + x as usize]);
                let row = |y: f64| at(x.floor(), y) * (1.0 - x.fract()) + at(x.ceil(), y) * x.fract();
                row(y.floor()) * (1.0 - y.fract()) + row(y.ceil()) * y.fract()
            };
            let mut segment_count = 0;
            for contour in &contours {
                segment_count += contour.points.len() - 1;
                for [x, y] in &contour.points {
                    prop_assert!((bilinear(*x, *y) - level).abs() < 1e-12);
                }
                let (first, last) = (contour.points[0], *contour.points.last().unwrap());
                let on_border = |[x, y]: [f64; 2]| x == 0.0 || y == 0.0 || x == 8.0 || y == 6.0;
                let ends_well = if contour.is_closed { first == last } else { on_border(first) && on_border(last) };
                prop_assert!(ends_well);
            }
            prop_assert_eq!(segment_count, grid.segment_count(level));
        }
    }
}
