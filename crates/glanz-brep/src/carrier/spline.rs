//! Rational spline surfaces as carriers: clamped, scaled to metres, with closed borders and poles.

use glanz_geometry::spline::basis::BasisFunctions;
use glanz_geometry::spline::{KnotVector, NurbsSurface};
use glanz_math::glam::{DAffine2, DMat2, DVec4};
use glanz_math::{DVec2, DVec3};

use super::{CarrierProjection, Pole, unwrapped};
use crate::error::BrepError;

/// Samples per knot interval and direction from which nearest points are searched.
const SAMPLES_PER_PIECE: usize = 3;

/// Samples from which a nearest point is searched before the search with bounds.
const STARTS: usize = 3;

/// A rational spline surface with what is known about its borders.
#[derive(Clone, Debug)]
pub struct SplineCarrier {
    surface: NurbsSurface,
    closed: [bool; 2],
    poles: Vec<Pole>,
    samples: Vec<(DVec2, DVec3)>,
    speeds: [f64; 2],
    tolerance: f64,
}

/// A spline carrier, the map from the parameters of the surface from which it was made, and the distance by which points were moved.
pub(super) struct SplineConversion {
    pub(super) carrier: SplineCarrier,
    pub(super) parameters: DAffine2,
    pub(super) deviation: f64,
}

impl SplineCarrier {
    /// The carrier of a surface. Borders of a direction that are at most `tolerance` (metres) apart are joined, and borders that are
    /// points up to the tolerance become points.
    pub(super) fn try_new(surface: &NurbsSurface, tolerance: f64) -> Result<SplineConversion, BrepError> {
        let domain = [surface.knots_u().domain(), surface.knots_v().domain()];
        let clamped = surface.restrict(domain)?;
        let mut net = BorderNet::new(&clamped);
        let lengths = net.lengths();
        for (length, reason) in lengths.into_iter().zip(["its length in u", "its length in v"]) {
            if length.is_nan() || length <= 0.0 {
                return Err(BrepError::DegenerateSurface { reason, value: length });
            }
        }
        let mut moved: f64 = 0.0;
        let mut sides = Vec::new();
        let mut closed = [false; 2];
        for axis in [0, 1] {
            // A surface that is narrower than the tolerance has no borders to tell apart.
            let wide = |axis: usize| lengths[axis] > 2.0 * tolerance;
            if let Some(gap) = net.border_gap(axis).filter(|gap| *gap <= tolerance && wide(axis)) {
                closed[axis] = true;
                moved += 0.5 * gap;
                net.join(axis);
            }
            for end in [0, 1] {
                let spread = net.border_spread(axis, end);
                if wide(1 - axis) && spread <= tolerance {
                    moved += spread;
                    sides.push((axis, end, net.collapse(axis, end)));
                }
            }
        }
        let scaled = |knots: &KnotVector, length: f64| {
            let [a, b] = knots.domain();
            let scale = length / (b - a);
            let map = |k: &f64| if *k == b { length } else { (k - a) * scale };
            KnotVector::try_new(knots.degree(), knots.knots().iter().map(map).collect())
        };
        let knots_u = scaled(clamped.knots_u(), lengths[0])?;
        let knots_v = scaled(clamped.knots_v(), lengths[1])?;
        let surface = NurbsSurface::from_knots(knots_u, knots_v, net.points)?;
        let pole = |(axis, end, point): (usize, usize, DVec3)| Pole {
            axis,
            value: [0.0, lengths[axis]][end],
            point,
        };
        let poles = sides.into_iter().map(pole).collect();
        let samples = samples(&surface);
        let scale = DVec2::new(
            lengths[0] / (domain[0][1] - domain[0][0]),
            lengths[1] / (domain[1][1] - domain[1][0]),
        );
        let start = DVec2::new(domain[0][0], domain[1][0]);
        let parameters = DAffine2::from_mat2_translation(DMat2::from_diagonal(scale), -start * scale);
        let speeds = speeds(&surface);
        let carrier = Self { surface, closed, poles, samples, speeds, tolerance };
        Ok(SplineConversion { carrier, parameters, deviation: moved })
    }

    /// The surface: clamped, with both parameters from 0 on in metres of arc length, roughly.
    #[must_use]
    pub fn surface(&self) -> &NurbsSurface {
        &self.surface
    }

    pub(super) fn domain(&self) -> [[f64; 2]; 2] {
        [self.surface.knots_u().domain(), self.surface.knots_v().domain()]
    }

    pub(crate) fn periods(&self) -> [Option<f64>; 2] {
        let domain = self.domain();
        [0, 1].map(|axis| self.closed[axis].then(|| domain[axis][1] - domain[axis][0]))
    }

    pub(super) fn poles(&self) -> Vec<Pole> {
        self.poles.clone()
    }

    /// The parameters of the domain at which the point of any parameters is.
    pub(crate) fn wrapped(&self, uv: DVec2) -> DVec2 {
        let (domain, periods) = (self.domain(), self.periods());
        let moved = |axis: usize| {
            let ([low, high], value) = (domain[axis], uv[axis]);
            match periods[axis] {
                Some(period) if value < low || value > high => low + (value - low).rem_euclid(period),
                _ => value.clamp(low, high),
            }
        };
        DVec2::new(moved(0), moved(1))
    }

    /// Degrees in u and v.
    pub(crate) fn degrees(&self) -> [usize; 2] {
        [self.surface.knots_u().degree(), self.surface.knots_v().degree()]
    }

    /// The ends of the piece in u or v (`axis` 0 or 1) that contains a parameter of the domain.
    pub(crate) fn piece(&self, axis: usize, value: f64) -> [f64; 2] {
        let knots = if axis == 0 { self.surface.knots_u() } else { self.surface.knots_v() };
        let span = knots.find_span(value);
        [knots.knots()[span], knots.knots()[span + 1]]
    }

    /// Coefficients of the powers of the differences from `uv`, a point of the domain, of numerator and weight on the piece that
    /// contains it; those of equal power of u next to each other.
    pub(crate) fn powers(&self, uv: DVec2) -> Vec<DVec4> {
        let in_u = BasisFunctions::at(self.surface.knots_u(), uv.x);
        let in_v = BasisFunctions::at(self.surface.knots_v(), uv.y);
        let ([p, q], (_, count_v)) = (self.degrees(), self.surface.counts());
        let points = self.surface.control_points();
        let mut powers = Vec::with_capacity((p + 1) * (q + 1));
        let (rows_u, rows_v) = (in_u.rows_up_to(p), in_v.rows_up_to(q));
        let mut factor_u = 1.0;
        for (k, row) in rows_u.iter().enumerate() {
            factor_u /= k.max(1) as f64;
            let along_v: Vec<DVec4> = (0..=q)
                .map(|j| {
                    let column =
                        (in_u.first()..=in_u.first() + p).map(|i| points[i * count_v + in_v.first() + j]);
                    column.zip(row).map(|(point, n)| point * *n).sum::<DVec4>()
                })
                .collect();
            let mut factor = factor_u;
            for (l, row) in rows_v.iter().enumerate() {
                factor /= l.max(1) as f64;
                let sum: DVec4 = along_v.iter().zip(row).map(|(point, n)| *point * *n).sum();
                powers.push(sum * factor);
            }
        }
        powers
    }

    /// Bounds on the lengths of the derivatives by u and v.
    ///
    /// With the numerator A and the weight w relative to the middle of the control points, `S' = (A' - S w') / w`. Derivatives of splines
    /// are at most their largest coefficient, |S| is at most the radius of the control points, w at least its smallest coefficient.
    pub(crate) fn speed_bounds(&self) -> [f64; 2] {
        self.speeds
    }

    pub(super) fn point(&self, uv: DVec2) -> DVec3 {
        let uv = self.wrapped(uv);
        self.surface.point(uv.x, uv.y)
    }

    pub(crate) fn point_and_tangents(&self, uv: DVec2) -> [DVec3; 3] {
        let uv = self.wrapped(uv);
        self.surface.tangents(uv.x, uv.y).into()
    }

    pub(super) fn normal(&self, uv: DVec2) -> Option<DVec3> {
        let uv = self.wrapped(uv);
        self.surface.normal(uv.x, uv.y)
    }

    pub(super) fn parameters(&self, point: DVec3, near: Option<DVec2>) -> CarrierProjection {
        let Some(near) = near else { return self.nearest(point) };
        let found = self.local_minimum(point, self.wrapped(near));
        let periods = self.periods();
        let uv = [0, 1].map(|axis| unwrapped(found.uv[axis], near[axis], periods[axis]));
        CarrierProjection { uv: DVec2::from(uv), distance: found.distance }
    }

    /// The least local minimum of those found from the nearest samples, moved by periods next to `near`.
    pub(crate) fn sampled_minimum(&self, point: DVec3, near: DVec2) -> CarrierProjection {
        let found = self.best_sampled(point);
        let periods = self.periods();
        let uv = [0, 1].map(|axis| unwrapped(found.uv[axis], near[axis], periods[axis]));
        CarrierProjection { uv: DVec2::from(uv), distance: found.distance }
    }

    fn best_sampled(&self, point: DVec3) -> CarrierProjection {
        let mut order: Vec<(f64, DVec2)> =
            self.samples.iter().map(|(uv, sample)| (sample.distance_squared(point), *uv)).collect();
        let count = STARTS.min(order.len());
        if count > 0 {
            order.select_nth_unstable_by(count - 1, |a, b| a.0.total_cmp(&b.0));
        }
        let searched = order.iter().take(count).map(|(_, uv)| self.local_minimum(point, *uv));
        let best = searched.min_by(|a, b| a.distance.total_cmp(&b.distance));
        best.unwrap_or(CarrierProjection { uv: DVec2::NAN, distance: f64::INFINITY })
    }

    /// The nearest of all points, or any within the tolerance.
    fn nearest(&self, point: DVec3) -> CarrierProjection {
        let best = self.best_sampled(point);
        if best.distance <= self.tolerance {
            return best;
        }
        match self.surface.closest_point(point, self.tolerance) {
            Ok(found) => CarrierProjection { uv: DVec2::new(found.u, found.v), distance: found.distance },
            Err(_) => best,
        }
    }

    /// A local minimum of the distance, also across the seams of a closed surface.
    fn local_minimum(&self, point: DVec3, start: DVec2) -> CarrierProjection {
        let (domain, periods) = (self.domain(), self.periods());
        let search = |uv: DVec2| {
            let found = self.surface.closest_point_from(point, uv.to_array(), domain);
            CarrierProjection { uv: DVec2::new(found.u, found.v), distance: found.distance }
        };
        let mut best = search(start);
        for axis in [0, 1] {
            let [low, high] = domain[axis];
            let value = best.uv[axis];
            if periods[axis].is_some() && (value == low || value == high) {
                let mut other = best.uv;
                other[axis] = if value == low { high } else { low };
                let across = search(other);
                if across.distance < best.distance {
                    best = across;
                }
            }
        }
        best
    }
}

/// Points at parameters that divide each piece of a surface.
fn samples(surface: &NurbsSurface) -> Vec<(DVec2, DVec3)> {
    let divided = |knots: &KnotVector| {
        let breaks = knots.breaks();
        let parts = SAMPLES_PER_PIECE;
        let inner = breaks.windows(2).flat_map(|pair| {
            let [a, b] = [pair[0], pair[1]];
            (0..parts).map(move |i| a + (b - a) * (i as f64 + 0.5) / parts as f64)
        });
        let ends = [breaks.first().copied(), breaks.last().copied()];
        inner.chain(ends.into_iter().flatten()).collect::<Vec<f64>>()
    };
    let (us, vs) = (divided(surface.knots_u()), divided(surface.knots_v()));
    us.iter().flat_map(|u| vs.iter().map(|v| (DVec2::new(*u, *v), surface.point(*u, *v)))).collect()
}

/// See [`SplineCarrier::speed_bounds`].
fn speeds(surface: &NurbsSurface) -> [f64; 2] {
    let bounds = surface.bounds();
    let (center, radius) = (bounds.center(), 0.5 * bounds.diagonal().length());
    let (rows, columns) = surface.counts();
    let points = surface.control_points();
    let least = points.iter().map(|p| p.w).fold(f64::INFINITY, f64::min);
    let difference = |a: usize, b: usize, knots: &KnotVector, i: usize| {
        let (p, t) = (knots.degree(), knots.knots());
        let length = t[i + p] - t[i];
        let d = points[b] - points[a];
        // A knot that is repeated degree times ends a piece: the difference there does not act.
        if length <= 0.0 {
            return 0.0;
        }
        p as f64 / length * ((d.truncate() - center * d.w).length() + radius * d.w.abs())
    };
    let mut speeds: [f64; 2] = [0.0; 2];
    for (i, j) in (0..rows).flat_map(|i| (0..columns).map(move |j| (i, j))) {
        let at = i * columns + j;
        if i > 0 {
            speeds[0] = speeds[0].max(difference(at - columns, at, surface.knots_u(), i));
        }
        if j > 0 {
            speeds[1] = speeds[1].max(difference(at - 1, at, surface.knots_v(), j));
        }
    }
    speeds.map(|speed| speed / least)
}

/// Homogeneous control points in rows of equal u.
struct BorderNet {
    points: Vec<DVec4>,
    counts: [usize; 2],
}

impl BorderNet {
    fn new(surface: &NurbsSurface) -> Self {
        let (u, v) = surface.counts();
        Self { points: surface.control_points().to_vec(), counts: [u, v] }
    }

    /// Index of the control point number `along` of the row with this number in the direction of `axis`.
    fn index(&self, axis: usize, number: usize, along: usize) -> usize {
        if axis == 0 { number * self.counts[1] + along } else { along * self.counts[1] + number }
    }

    fn position(&self, index: usize) -> DVec3 {
        let p = self.points[index];
        p.truncate() / p.w
    }

    /// The mean lengths of the control polygons in u and in v.
    fn lengths(&self) -> [f64; 2] {
        [0, 1].map(|axis| {
            let (count, across) = (self.counts[axis], self.counts[1 - axis]);
            let polygon = |along: usize| {
                let at = |i: usize| self.position(self.index(axis, i, along));
                (1..count).map(|i| at(i - 1).distance(at(i))).sum::<f64>()
            };
            (0..across).map(polygon).sum::<f64>() / across as f64
        })
    }

    /// Pairs of the control points on the first and the last border across `axis`.
    fn border_pairs(&self, axis: usize) -> impl Iterator<Item = (usize, usize)> + '_ {
        let last = self.counts[axis] - 1;
        (0..self.counts[1 - axis]).map(move |j| (self.index(axis, 0, j), self.index(axis, last, j)))
    }

    /// The largest distance of control points on the two borders across `axis`; `None` if their weights differ.
    fn border_gap(&self, axis: usize) -> Option<f64> {
        let same = |a: f64, b: f64| (a - b).abs() <= f64::EPSILON.sqrt() * a;
        let mut pairs = self.border_pairs(axis);
        pairs.try_fold(0.0, |gap: f64, (i, j)| {
            let (a, b) = (self.points[i].w, self.points[j].w);
            same(a, b).then(|| gap.max(self.position(i).distance(self.position(j))))
        })
    }

    /// Moves both borders across `axis` to their mean.
    fn join(&mut self, axis: usize) {
        let pairs: Vec<(usize, usize)> = self.border_pairs(axis).collect();
        for (i, j) in pairs {
            let mean = (self.position(i) + self.position(j)) * 0.5;
            let weight = self.points[i].w;
            let point = if self.points[i] == self.points[j] {
                self.points[i]
            } else {
                (mean * weight).extend(weight)
            };
            (self.points[i], self.points[j]) = (point, point);
        }
    }

    fn border(&self, axis: usize, end: usize) -> impl Iterator<Item = usize> + '_ {
        let number = [0, self.counts[axis] - 1][end];
        (0..self.counts[1 - axis]).map(move |j| self.index(axis, number, j))
    }

    fn border_mean(&self, axis: usize, end: usize) -> DVec3 {
        let first = self.border(axis, end).next().map_or(DVec3::ZERO, |i| self.position(i));
        let sum: DVec3 = self.border(axis, end).map(|i| self.position(i) - first).sum();
        first + sum / self.counts[1 - axis] as f64
    }

    /// The largest distance of the control points of a border from their mean.
    fn border_spread(&self, axis: usize, end: usize) -> f64 {
        let mean = self.border_mean(axis, end);
        self.border(axis, end).map(|i| self.position(i).distance(mean)).fold(0.0, f64::max)
    }

    /// Moves a border to its mean, which is returned.
    fn collapse(&mut self, axis: usize, end: usize) -> DVec3 {
        let mean = self.border_mean(axis, end);
        let border: Vec<usize> = self.border(axis, end).collect();
        for i in border {
            let weight = self.points[i].w;
            self.points[i] = (mean * weight).extend(weight);
        }
        mean
    }
}
