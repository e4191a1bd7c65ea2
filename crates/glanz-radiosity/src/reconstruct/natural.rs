//! Natural neighbours.

use glanz_math::{DVec2, DVec3};
use spade::{DelaunayTriangulation, HasPosition, HierarchyHintGenerator, Point2, Triangulation};

use super::{Interpolant, ReconstructError, Sample, Texture};

/// Distance of samples on a side of the square and their images: cells may reach half of it beyond the side.
const NARROW: f64 = 1e-7;

/// Means of samples, weighted by the areas that a new sample would take from their Voronoi cells.
///
/// Cells end at the sides of the domain: each sample has an image beyond each side, and the side is where the cells of the
/// two meet. If there are samples in the corners, every point is between samples, and cells are those of the plane: then
/// linear functions are reproduced.
///
/// # Source
/// @sibson1981; @pietrek2001 section 4.5.3.
pub(super) struct NaturalNeighbour {
    /// The samples, and behind them their images.
    triangulation: Sites,
    values: Vec<DVec3>,
}

/// The triangulation finds a point from the same start whoever asked before: bits do not depend on threads.
type Sites = DelaunayTriangulation<Site, (), (), (), HierarchyHintGenerator<f64>>;

/// A point to triangulate.
struct Site {
    point: DVec2,
    /// Of the sample; images have a number that no sample has.
    index: usize,
}

impl HasPosition for Site {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        Point2::new(self.point.x, self.point.y)
    }
}

impl NaturalNeighbour {
    /// `size`: far corner of the domain.
    ///
    /// # Errors
    /// [`ReconstructError::Points`] for samples at one point.
    pub(super) fn try_new(samples: &[Sample], size: DVec2) -> Result<Self, ReconstructError> {
        let corner = |corner: DVec2| samples.iter().any(|s| s.point == corner * size);
        let closed = [DVec2::ZERO, DVec2::X, DVec2::Y, DVec2::ONE].into_iter().all(corner);
        let mut sites: Vec<Site> =
            samples.iter().enumerate().map(|(index, s)| Site { point: s.point, index }).collect();
        if !closed {
            for Sample { point, .. } in samples {
                let beyond = |x: f64, side: f64| [-x.max(NARROW), side + (side - x).max(NARROW)];
                let images = beyond(point.x, size.x).map(|u| DVec2::new(u, point.y));
                let images =
                    images.into_iter().chain(beyond(point.y, size.y).map(|v| DVec2::new(point.x, v)));
                sites.extend(images.map(|point| Site { point, index: usize::MAX }));
            }
        }
        let count = sites.len();
        let triangulation =
            Sites::bulk_load_stable(sites).ok().filter(|triangulation| triangulation.num_vertices() == count);
        let triangulation = triangulation.ok_or(ReconstructError::Points)?;
        Ok(Self { triangulation, values: samples.iter().map(|s| s.value).collect() })
    }

    /// What every edge of the triangulation adds to the texels that it matters to.
    fn edges(&self) -> impl Iterator<Item = Edge> + '_ {
        self.triangulation.undirected_edges().filter_map(|edge| {
            let edge = edge.as_directed();
            let end = |site: &Site| End { point: site.point, value: self.values.get(site.index).copied() };
            let circle =
                |face: spade::handles::FaceHandle<'_, spade::handles::PossiblyOuterTag, Site, (), (), ()>| {
                    let (middle, square) = face.as_inner()?.circumcircle();
                    Some(Circle { middle: DVec2::new(middle.x, middle.y), square })
                };
            let edge = Edge {
                ends: [end(edge.from().data()), end(edge.to().data())],
                circles: [circle(edge.face()), circle(edge.rev().face())],
            };
            // Between images nothing is to be had.
            edge.ends.iter().any(|end| end.value.is_some()).then_some(edge)
        })
    }

    fn nearest(&self, point: DVec2) -> DVec3 {
        let index =
            self.triangulation.nearest_neighbor(Point2::new(point.x, point.y)).map(|v| v.data().index);
        index.and_then(|index| self.values.get(index)).copied().unwrap_or_default()
    }
}

/// Weights and weighted values, added up.
#[derive(Clone, Copy, Debug, Default)]
struct Sum {
    weight: f64,
    value: DVec3,
}

impl Interpolant for NaturalNeighbour {
    fn value(&self, point: DVec2) -> DVec3 {
        let mut weights = Vec::new();
        self.triangulation.natural_neighbor().get_weights(Point2::new(point.x, point.y), &mut weights);
        let mut sum = Sum::default();
        for (vertex, weight) in weights {
            if let Some(&value) = self.values.get(self.triangulation.vertex(vertex).data().index) {
                sum.weight += weight;
                sum.value += weight * value;
            }
        }
        if sum.weight > 0.0 { sum.value / sum.weight } else { self.nearest(point) }
    }

    /// Not texel by texel: the areas that a point takes from the cells of its neighbours are sums over those edges of the triangulation
    /// that have a circumcircle around the point, so each edge adds its part to all texels in its circles.
    fn texture(&self, size: [usize; 2]) -> Texture {
        let mut sums = vec![Sum::default(); size[0] * size[1]];
        let scale = DVec2::new(size[0] as f64, size[1] as f64);
        for edge in self.edges() {
            let [low, high] = edge.rows(scale.y, size[1]);
            for y in low..high {
                let v = (y as f64 + 0.5) / scale.y;
                let [from, to] = edge.columns(v, scale.x, size[0]);
                let row = &mut sums[y * size[0]..(y + 1) * size[0]];
                for (x, sum) in row.iter_mut().enumerate().take(to).skip(from) {
                    edge.add(DVec2::new((x as f64 + 0.5) / scale.x, v), sum);
                }
            }
        }
        let mut sums = sums.into_iter();
        Texture::from_function(size, |point| {
            let Sum { weight, value } = sums.next().unwrap_or_default();
            let mean = value / weight;
            // At a sample there is no area to be taken.
            if weight > 0.0 && mean.is_finite() { mean } else { self.nearest(point) }
        })
    }
}

/// A sample or an image at the end of an edge.
#[derive(Clone, Copy)]
struct End {
    point: DVec2,
    /// Of a sample.
    value: Option<DVec3>,
}

/// The circle through the corners of a triangle.
#[derive(Clone, Copy)]
struct Circle {
    middle: DVec2,
    /// Square of the radius.
    square: f64,
}

impl Circle {
    fn contains(&self, point: DVec2) -> bool {
        self.middle.distance_squared(point) < self.square
    }

    /// Half its width at `distance` from the middle.
    fn half_width(&self, distance: f64) -> Option<f64> {
        let square = self.square - distance * distance;
        (square >= 0.0).then(|| square.sqrt())
    }
}

/// An edge of the triangulation with the circles of the triangles at its left and right, seen from its first end to its second.
struct Edge {
    ends: [End; 2],
    circles: [Option<Circle>; 2],
}

impl Edge {
    /// The rows of texels that its circles meet, and one more at each end.
    fn rows(&self, scale: f64, count: usize) -> [usize; 2] {
        let reach = |circle: &Circle| {
            let radius = circle.square.sqrt();
            [circle.middle.y - radius, circle.middle.y + radius]
        };
        hull(self.circles.iter().flatten().map(reach), scale, count)
    }

    /// The same of the texels in the row at `v`.
    fn columns(&self, v: f64, scale: f64, count: usize) -> [usize; 2] {
        let reach = |circle: &Circle| {
            let half = circle.half_width(v - circle.middle.y)?;
            Some([circle.middle.x - half, circle.middle.x + half])
        };
        hull(self.circles.iter().flatten().filter_map(reach), scale, count)
    }

    /// Its part in the areas that a sample at `q` takes from the cells of its ends.
    ///
    /// In the plane around q, the cell of a sample there has as corners the circumcentres of all triangles whose circumcircle holds
    /// q, which go, and those of q and each edge at their rim. What it takes from the cell of a sample p is a polygon; its sides are
    /// pieces of the old border of p's cell, each dual to an edge of the triangulation at p, and one on the bisector of p and q. The
    /// area is half the sum of the cross products of successive corners. That of the side on the bisector is a difference of what
    /// each of its ends contributes alone, since all its points are half of p away from q along p; and each end belongs to one
    /// edge at the rim. So the area is a sum over edges.
    #[inline]
    fn add(&self, q: DVec2, sum: &mut Sum) {
        let [left, right] = self.circles.map(|circle| circle.filter(|circle| circle.contains(q)));
        let [a, b] = self.ends.map(|end| end.point - q);
        let areas = match (left, right) {
            (Some(left), Some(right)) => {
                let area = 0.5 * (right.middle - q).perp_dot(left.middle - q);
                [area, -area]
            }
            (Some(left), None) => {
                let corner = circumcentre(a, b);
                let area = 0.5 * corner.perp_dot(left.middle - q);
                [area + 0.25 * a.perp_dot(corner), -area - 0.25 * b.perp_dot(corner)]
            }
            (None, Some(right)) => {
                let corner = circumcentre(a, b);
                let area = 0.5 * (right.middle - q).perp_dot(corner);
                [area - 0.25 * a.perp_dot(corner), -area + 0.25 * b.perp_dot(corner)]
            }
            (None, None) => return,
        };
        for (end, area) in self.ends.iter().zip(areas) {
            if let Some(value) = end.value {
                sum.weight += area;
                sum.value += area * value;
            }
        }
    }
}

/// The texels whose middles are in some of these intervals of [0, 1], first and end; one more on each side.
fn hull(intervals: impl Iterator<Item = [f64; 2]>, scale: f64, count: usize) -> [usize; 2] {
    let [low, high] =
        intervals.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], [c, d]| [a.min(c), b.max(d)]);
    if low > high {
        return [0, 0];
    }
    // Casts cut what is outside.
    [((low * scale - 1.5) as usize).min(count), ((high * scale + 1.5) as usize).min(count)]
}

/// The middle of the circle through the origin, `a` and `b`.
fn circumcentre(a: DVec2, b: DVec2) -> DVec2 {
    let (aa, bb) = (a.length_squared(), b.length_squared());
    DVec2::new(b.y * aa - a.y * bb, a.x * bb - b.x * aa) / (2.0 * a.perp_dot(b))
}
