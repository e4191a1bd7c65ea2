//! The part of a surface on which a face lies, where the whole surface passes through itself.

use glanz_math::DVec3;

use super::bounded_edge::{BoundedEdge, loop_points};
use super::outcome::FaceRepair;
use crate::model::{BoundaryLoop, BrepModel, Curve, Face, FaceSurface, OrientedEdge};

/// Largest distance of the points of a curve from the middle of the edges of a face, relative to that of the edges, up to which the face may need it.
const REACH: f64 = 1.125;

/// Parts of an edge between which it is sampled.
const EDGE_PARTS: u32 = 4;

/// Samples inside each part of a profile.
const PROFILE_SAMPLES: u32 = 4;

/// Most crossings at which a profile is divided, more than any reflector has: each part is compared with the edges of each face.
const MOST_CROSSINGS: usize = 16;

/// Most places at which a curve changes its side of the axis that are tested: beside the axis, each is searched in vain.
const MOST_CHANGES: usize = 1024;

/// Of a torus whose tube meets the axis, and of a curve that is turned about an axis which it crosses, the part on which the edges lie.
///
/// Files often give the other part of such a torus, and whole conics as the profiles of reflectors. `repairs` receives
/// [`FaceRepair::WholeProfile`] where a profile stays whole.
pub(super) fn part_with_edges(
    surface: &FaceSurface,
    model: &BrepModel,
    edges: &[BoundedEdge],
    face: &Face,
    repairs: &mut Vec<FaceRepair>,
) -> FaceSurface {
    match surface {
        FaceSurface::Torus { minor_radius, major_radius, .. } if minor_radius >= major_radius => {
            part_of_torus(surface, &EdgeSamples::new(model, edges, face).points, model.uncertainty)
        }
        FaceSurface::Revolution { curve, origin, axis } => {
            let samples = EdgeSamples::new(model, edges, face);
            let profile = CrossingProfile::try_new(curve, [*origin, *axis], &samples, model.uncertainty);
            let profile = profile.unwrap_or_else(|repair| {
                repairs.push(repair);
                None
            });
            let range = profile.and_then(|profile| profile.part(&samples, face.same_sense));
            let Some(range) = range else { return surface.clone() };
            let curve = Box::new(Curve::Trimmed { basis: curve.clone(), range, same_sense: true });
            FaceSurface::Revolution { curve, origin: *origin, axis: *axis }
        }
        _ => surface.clone(),
    }
}

/// What the edges of a face tell of the part of its surface.
#[derive(Default)]
struct EdgeSamples {
    /// Points of the edges, metres.
    points: Vec<DVec3>,
    /// Of each edge, points inside of it, the middle first.
    inner: Vec<[DVec3; 3]>,
    /// The parameters v that the file gives to the middles of edges.
    parameters: Vec<f64>,
    /// Area of the loops seen along each axis, where they run counter-clockwise, square metres: roughly.
    area: DVec3,
}

impl EdgeSamples {
    fn new(model: &BrepModel, edges: &[BoundedEdge], face: &Face) -> Self {
        let mut samples = Self::default();
        for bound in &face.bounds {
            let BoundaryLoop::Edges(oriented) = &bound.boundary else { continue };
            for &OrientedEdge { edge: number, .. } in oriented {
                let (Some(edge), Some(bounded)) = (model.edges.get(number), edges.get(number)) else {
                    continue;
                };
                let Ok(curve) = &bounded.curve else { continue };
                samples.inner.push([0.5, 0.25, 0.75].map(|at| curve.point(at)));
                let given = edge.parameter_curves.iter().filter(|given| given.surface == face.surface);
                let heights = given.map(|given| given.curve.point(curve.parameter(0.5)).y);
                samples.parameters.extend(heights.filter(|v| v.is_finite()));
            }
            let around = loop_points(edges, oriented, EDGE_PARTS);
            let sides = around.iter().zip(around.iter().cycle().skip(1));
            samples.area += 0.5 * sides.map(|(a, b)| a.cross(*b)).sum::<DVec3>();
            samples.points.extend(around);
        }
        samples
    }
}

/// Of a torus whose tube meets the axis, the part on which points lie.
fn part_of_torus(surface: &FaceSurface, points: &[DVec3], uncertainty: f64) -> FaceSurface {
    let FaceSurface::Torus { placement, major_radius, minor_radius, .. } = *surface else {
        return surface.clone();
    };
    // The outer part is where the distance from the axis grows with that from the tube's circle on the near side.
    let outside = |point: &DVec3| {
        let p = *point - placement.origin;
        let (z, rho) = (p.dot(placement.z), (p - placement.z * p.dot(placement.z)).length());
        let outer = (rho - major_radius).hypot(z) - minor_radius;
        let inner = (rho + major_radius).hypot(z) - minor_radius;
        outer.abs() - inner.abs()
    };
    let balance = points.iter().map(outside).max_by(|a, b| a.abs().total_cmp(&b.abs()));
    match balance {
        Some(balance) if balance.abs() > uncertainty => {
            FaceSurface::Torus { placement, major_radius, minor_radius, select_outer: balance < 0.0 }
        }
        _ => surface.clone(),
    }
}

/// A curve that crosses the axis about which it is turned.
struct CrossingProfile<'a> {
    curve: &'a Curve<DVec3>,
    origin: DVec3,
    axis: DVec3,
    /// Unit vector across the axis, in the plane of the curve.
    across: DVec3,
    /// The ranges of parameters between crossings, ascending; of a closed curve the last may pass its seam.
    parts: Vec<[f64; 2]>,
    /// Length of the domain of a closed curve.
    period: Option<f64>,
}

impl<'a> CrossingProfile<'a> {
    /// `None` if the curve does not cross the axis, up to `tolerance` (metres), within reach of the edges.
    ///
    /// # Errors
    /// [`FaceRepair::WholeProfile`] if it crosses the axis too often.
    fn try_new(
        curve: &'a Curve<DVec3>,
        [origin, axis]: [DVec3; 2],
        EdgeSamples { points, .. }: &EdgeSamples,
        tolerance: f64,
    ) -> Result<Option<Self>, FaceRepair> {
        let domain = curve.domain();
        let range = if domain.iter().all(|t| t.is_finite()) {
            domain
        } else {
            let heights = points.iter().map(|p| (*p - origin).dot(axis));
            let (low, high) =
                heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), z| (a.min(z), b.max(z)));
            // A turn does not change the distance from a point of the axis.
            let middle = origin + axis * (0.5 * (low + high));
            let reach = points.iter().map(|p| p.distance(middle)).fold(0.0, f64::max);
            curve.range_near(middle, REACH * reach + tolerance)
        };
        if !(range[0] < range[1] && range.iter().all(|t| t.is_finite())) {
            return Ok(None);
        }
        let samples = curve.samples(range);
        let radial = |t: f64| (curve.point(t) - origin).reject_from(axis);
        let farthest = samples.iter().map(|t| radial(*t)).max_by(|a, b| a.length().total_cmp(&b.length()));
        let farthest = farthest.unwrap_or_default();
        let Some(across) = farthest.try_normalize() else { return Ok(None) };
        let period = curve.period(tolerance);
        let mut profile = Self { curve, origin, axis, across, parts: Vec::new(), period };
        let far: Vec<(f64, f64)> = samples
            .into_iter()
            .map(|t| (t, profile.signed_radius(t)))
            .filter(|(_, radius)| radius.abs() > tolerance)
            .collect();
        let changes = far.windows(2).filter(|pair| (pair[0].1 < 0.0) != (pair[1].1 < 0.0));
        // A curve askew to the axis changes its side beside it.
        let on_axis = tolerance.max(f64::EPSILON.sqrt() * farthest.length());
        let is_many = changes.clone().nth(MOST_CHANGES).is_some();
        let crossings: Vec<f64> = changes
            .take(MOST_CHANGES)
            .map(|pair| profile.crossing([pair[0].0, pair[1].0]))
            .filter(|t| radial(*t).length() <= on_axis)
            .take(MOST_CROSSINGS + 1)
            .collect();
        if is_many || crossings.len() > MOST_CROSSINGS {
            return Err(FaceRepair::WholeProfile);
        }
        let (Some(&first), Some(&last)) = (crossings.first(), crossings.last()) else { return Ok(None) };
        let ends: Vec<f64> = [range[0]].into_iter().chain(crossings).chain([range[1]]).collect();
        profile.parts = ends.windows(2).map(|pair| [pair[0], pair[1]]).collect();
        if let Some(period) = period.filter(|_| profile.signed_radius(range[0]).abs() > tolerance) {
            profile.parts.remove(0);
            profile.parts.pop();
            profile.parts.push([last, first + period]);
        }
        Ok(Some(profile))
    }

    /// Distance of a point of the curve from the axis, on one of its sides negative, metres.
    fn signed_radius(&self, t: f64) -> f64 {
        (self.curve.point(t) - self.origin).dot(self.across)
    }

    /// The parameter between two on different sides of the axis at which the curve crosses it.
    fn crossing(&self, [mut low, mut high]: [f64; 2]) -> f64 {
        let is_below = |t: f64| self.signed_radius(t) < 0.0;
        let below = is_below(low);
        loop {
            let middle = low + 0.5 * (high - low);
            if !(middle > low && middle < high) {
                return middle;
            }
            *(if is_below(middle) == below { &mut low } else { &mut high }) = middle;
        }
    }

    /// The part in which most edges lie that have a parameter in the file or lie on the curve before it is turned; else the part that is nearest to
    /// all when it is turned; of parts that mirror one another, that on which the face has its loops on the right side; else the last.
    ///
    /// Without edges, a part that makes the whole surface; `None` if there is none.
    fn part(&self, samples: &EdgeSamples, same_sense: bool) -> Option<[f64; 2]> {
        let has_edges = !samples.points.is_empty();
        let inside = if has_edges { Vec::new() } else { self.points() };
        let points = if has_edges { &samples.points } else { &inside };
        let size = points.iter().map(|point| point.distance(self.origin)).fold(0.0, f64::max);
        let accuracy = (f64::EPSILON.sqrt() * size).max(f64::MIN_POSITIVE);
        let parameters = self.parameters(samples, accuracy);
        let beyond = |[from, to]: [f64; 2], t: f64| (from - t).max(t - to).max(0.0);
        let is_in =
            |part: [f64; 2], t: f64| self.parts.iter().all(|other| beyond(part, t) <= beyond(*other, t));
        let scores = self.parts.iter().map(|&part| {
            let inside = parameters.iter().filter(|t| is_in(part, **t)).count();
            // Parts that mirror one another are equally far, up to rounding.
            let distance = (self.distance(part, points) / accuracy).round();
            // Where the distance from the axis grows with v, the surface has its normal against the axis.
            let growth = self.signed_radius(part[1]).abs() - self.signed_radius(part[0]).abs();
            // From axis to axis it is rounding.
            let growth = if growth.abs() <= accuracy { 0.0 } else { growth };
            let along = if same_sense { -growth } else { growth } * samples.area.dot(self.axis);
            (inside, -distance, along > 0.0, part)
        });
        let best =
            scores.reduce(
                |best, next| {
                    if (next.0, next.1, next.2) >= (best.0, best.1, best.2) { next } else { best }
                },
            );
        best.filter(|(_, distance, ..)| has_edges || *distance == 0.0).map(|(.., part)| part)
    }

    /// The parameters of edges that have one in the file or lie on the curve. `accuracy`: distance up to which they do, metres.
    fn parameters(&self, samples: &EdgeSamples, accuracy: f64) -> Vec<f64> {
        let (Some([start, _]), Some([_, end])) = (self.parts.first(), self.parts.last()) else {
            return Vec::new();
        };
        let nearest = |point: DVec3| self.curve.closest_in(point, [*start, *end]);
        let is_on = |point: &DVec3| self.curve.point(nearest(*point)).distance(*point) <= accuracy;
        let on_curve =
            samples.inner.iter().filter(|points| points.iter().all(is_on)).map(|points| nearest(points[0]));
        let wrapped = |t: &f64| self.period.map_or(*t, |period| start + (t - start).rem_euclid(period));
        samples.parameters.iter().map(wrapped).chain(on_curve).collect()
    }

    /// Points inside the parts.
    fn points(&self) -> Vec<DVec3> {
        let fraction = |i: u32| (f64::from(i) + 0.5) / f64::from(PROFILE_SAMPLES);
        let at = |[from, to]: [f64; 2]| (0..PROFILE_SAMPLES).map(move |i| from + (to - from) * fraction(i));
        self.parts.iter().flat_map(|part| at(*part)).map(|t| self.curve.point(t)).collect()
    }

    /// The largest distance of a point from a part that is turned about the axis, metres.
    fn distance(&self, part: [f64; 2], points: &[DVec3]) -> f64 {
        let side = self.signed_radius(0.5 * (part[0] + part[1])).signum();
        let distance = |point: &DVec3| {
            let height = (*point - self.origin).dot(self.axis);
            let radius = (*point - self.origin).reject_from(self.axis).length();
            let turned = self.origin + self.axis * height + self.across * (side * radius);
            self.curve.point(self.curve.closest_in(turned, part)).distance(turned)
        };
        points.iter().map(distance).fold(0.0, f64::max)
    }
}
