//! Natural neighbour interpolation.

use std::collections::HashSet;

use glanz_math::{DVec2, DVec3};
use spade::{DelaunayTriangulation, HasPosition, HierarchyHintGenerator, Point2, Triangulation};

use super::{Interpolant, InterpolatedTexture, ReconstructError, Sample};

/// Distance between samples on a side of the domain and their mirror images: cells may extend half of it beyond the side.
const MIN_IMAGE_DISTANCE: f64 = 1e-7;

/// Means of samples, weighted by the areas that a new sample would take from their Voronoi cells.
///
/// Cells end at the sides of the domain, because each sample has a mirror image beyond each side. If there are samples in all corners,
/// every point is between samples and no images are needed: then cells are those of the plane, and linear functions are reproduced.
///
/// # Source
/// @sibson1981; @pietrek2001 section 4.5.3.
pub(super) struct NaturalNeighbour {
    /// The samples, followed by their images.
    triangulation: Sites,
    values: Vec<DVec3>,
}

/// Triangulation whose point location starts independently of earlier queries, so that results do not depend on threads.
type Sites = DelaunayTriangulation<Site, (), (), (), HierarchyHintGenerator<f64>>;

/// A point to triangulate.
struct Site {
    point: DVec2,
    /// Index of the sample; `usize::MAX` for images.
    index: usize,
}

impl HasPosition for Site {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        Point2::new(self.point.x, self.point.y)
    }
}

impl NaturalNeighbour {
    /// `size`: upper right corner of the domain.
    ///
    /// # Errors
    /// [`ReconstructError::Points`] for samples at one point.
    pub(super) fn try_new(samples: &[Sample], size: DVec2) -> Result<Self, ReconstructError> {
        let corner = |corner: DVec2| samples.iter().any(|s| s.point == corner * size);
        let closed = [DVec2::ZERO, DVec2::X, DVec2::Y, DVec2::ONE].into_iter().all(corner);
        let mut sites: Vec<Site> =
            samples.iter().enumerate().map(|(index, s)| Site { point: s.point, index }).collect();
        if !closed {
            // Samples that are equally near to a side have one image.
            let mut known = HashSet::new();
            for Sample { point, .. } in samples {
                let beyond = |x: f64, side: f64| {
                    [-x.max(MIN_IMAGE_DISTANCE), side + (side - x).max(MIN_IMAGE_DISTANCE)]
                };
                let images = beyond(point.x, size.x).map(|u| DVec2::new(u, point.y));
                let images =
                    images.into_iter().chain(beyond(point.y, size.y).map(|v| DVec2::new(point.x, v)));
                let images = images.filter(|image| known.insert((*image + 0.0).to_array().map(f64::to_bits)));
                sites.extend(images.map(|point| Site { point, index: usize::MAX }));
            }
        }
        let count = sites.len();
        let triangulation =
            Sites::bulk_load_stable(sites).ok().filter(|triangulation| triangulation.num_vertices() == count);
        let triangulation = triangulation.ok_or(ReconstructError::Points)?;
        Ok(Self { triangulation, values: samples.iter().map(|s| s.value).collect() })
    }

    /// All edges of the triangulation with an end that is a sample.
    fn edges(&self) -> impl Iterator<Item = DelaunayEdge> + '_ {
        self.triangulation.undirected_edges().filter_map(|edge| {
            let edge = edge.as_directed();
            let end =
                |site: &Site| EdgeEnd { point: site.point, value: self.values.get(site.index).copied() };
            let circle =
                |face: spade::handles::FaceHandle<'_, spade::handles::PossiblyOuterTag, Site, (), (), ()>| {
                    let (middle, square) = face.as_inner()?.circumcircle();
                    Some(Circumcircle { middle: DVec2::new(middle.x, middle.y), square })
                };
            let edge = DelaunayEdge {
                ends: [end(edge.from().data()), end(edge.to().data())],
                circles: [circle(edge.face()), circle(edge.rev().face())],
            };
            // Edges between images have no weight.
            edge.ends.iter().any(|end| end.value.is_some()).then_some(edge)
        })
    }

    fn nearest(&self, point: DVec2) -> DVec3 {
        let index =
            self.triangulation.nearest_neighbor(Point2::new(point.x, point.y)).map(|v| v.data().index);
        index.and_then(|index| self.values.get(index)).copied().unwrap_or_default()
    }
}

/// Sums of weights and of weighted values.
#[derive(Clone, Copy, Debug, Default)]
struct WeightSum {
    weight: f64,
    value: DVec3,
}

impl Interpolant for NaturalNeighbour {
    fn value(&self, point: DVec2) -> DVec3 {
        let mut weights = Vec::new();
        self.triangulation.natural_neighbor().get_weights(Point2::new(point.x, point.y), &mut weights);
        let mut sum = WeightSum::default();
        for (vertex, weight) in weights {
            if let Some(&value) = self.values.get(self.triangulation.vertex(vertex).data().index) {
                sum.weight += weight;
                sum.value += weight * value;
            }
        }
        if sum.weight > 0.0 { sum.value / sum.weight } else { self.nearest(point) }
    }

    /// Computed edge by edge instead of texel by texel: the areas that a point takes from the cells of its neighbours are sums over the edges
    /// of the triangulation with a circumcircle around the point, so each edge contributes to all texels in its circles.
    fn texture(&self, size: [usize; 2]) -> InterpolatedTexture {
        let mut sums = vec![WeightSum::default(); size[0] * size[1]];
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
        InterpolatedTexture::from_function(size, |point| {
            let WeightSum { weight, value } = sums.next().unwrap_or_default();
            let mean = value / weight;
            // At a sample all areas are 0.
            if weight > 0.0 && mean.is_finite() { mean } else { self.nearest(point) }
        })
    }
}

/// A sample or an image at the end of an edge.
#[derive(Clone, Copy)]
struct EdgeEnd {
    point: DVec2,
    /// Value of the sample; `None` for an image.
    value: Option<DVec3>,
}

/// Circumcircle of a triangle.
#[derive(Clone, Copy)]
struct Circumcircle {
    middle: DVec2,
    /// Square of the radius.
    square: f64,
}

impl Circumcircle {
    fn contains(&self, point: DVec2) -> bool {
        self.middle.distance_squared(point) < self.square
    }

    /// Half the chord at `distance` from the middle; `None` beyond the circle.
    fn half_width(&self, distance: f64) -> Option<f64> {
        let square = self.square - distance * distance;
        (square >= 0.0).then(|| square.sqrt())
    }
}

/// An edge of the triangulation, with the circumcircles of the triangles on its left and right.
struct DelaunayEdge {
    ends: [EdgeEnd; 2],
    circles: [Option<Circumcircle>; 2],
}

impl DelaunayEdge {
    /// Range of the rows of texels that its circles overlap, with one more at each end.
    fn rows(&self, scale: f64, count: usize) -> [usize; 2] {
        let reach = |circle: &Circumcircle| {
            let radius = circle.square.sqrt();
            [circle.middle.y - radius, circle.middle.y + radius]
        };
        hull(self.circles.iter().flatten().map(reach), scale, count)
    }

    /// The same for the texels in the row at `v`.
    fn columns(&self, v: f64, scale: f64, count: usize) -> [usize; 2] {
        let reach = |circle: &Circumcircle| {
            let half = circle.half_width(v - circle.middle.y)?;
            Some([circle.middle.x - half, circle.middle.x + half])
        };
        hull(self.circles.iter().flatten().filter_map(reach), scale, count)
    }

    /// Adds the edge's contribution to the areas that a sample at `q` takes from the cells of its ends.
    ///
    /// Relative to q: a new sample at q removes all triangles whose circumcircle contains q; the corners of its cell are the circumcentres of
    /// q and each edge of their boundary. The area taken from the cell of a sample p is a polygon; its sides are
    /// pieces of the old border of p's cell, each dual to an edge of the triangulation at p, and one side on the bisector of p and q. The
    /// area is half the sum of the cross products of successive corners. The product for the side on the bisector is a difference of
    /// terms that depend on one of its ends each, since all its points have the distance |p| / 2 from q along p; and each end belongs to
    /// one edge of the boundary. The area is therefore a sum over edges.
    #[inline]
    fn add(&self, q: DVec2, sum: &mut WeightSum) {
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

/// Range of the texels whose middles are in one of the intervals of [0, 1], with one more on each side.
fn hull(intervals: impl Iterator<Item = [f64; 2]>, scale: f64, count: usize) -> [usize; 2] {
    let [low, high] =
        intervals.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], [c, d]| [a.min(c), b.max(d)]);
    if low > high {
        return [0, 0];
    }
    // Casts saturate numbers out of range.
    [((low * scale - 1.5) as usize).min(count), ((high * scale + 1.5) as usize).min(count)]
}

/// Center of the circle through the origin, `a` and `b`.
fn circumcentre(a: DVec2, b: DVec2) -> DVec2 {
    let (aa, bb) = (a.length_squared(), b.length_squared());
    DVec2::new(b.y * aa - a.y * bb, a.x * bb - b.x * aa) / (2.0 * a.perp_dot(b))
}
