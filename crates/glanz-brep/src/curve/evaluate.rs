//! Points and derivatives of curves, and their domains.

use std::f64::consts::TAU;

use crate::model::{Curve, CurveVector};

/// Part of the size of a curve up to which its ends may be apart where it counts as closed: larger than what files leave open, and far
/// smaller than a gap that is meant.
const CLOSED: f64 = 1.0 / 4096.0;

impl<P: CurveVector> Curve<P> {
    /// The kind of the curve, for messages.
    #[must_use]
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Line { .. } => "line",
            Self::Ellipse { .. } => "ellipse",
            Self::Parabola { .. } => "parabola",
            Self::Hyperbola { .. } => "hyperbola",
            Self::Spline(_) => "spline",
            Self::Polyline(_) => "polyline",
            Self::Composite(_) => "composite curve",
            Self::Trimmed { .. } => "trimmed curve",
        }
    }

    /// Smallest and largest parameter; infinite on lines, parabolas and hyperbolas, a turn on ellipses.
    #[must_use]
    pub fn domain(&self) -> [f64; 2] {
        match self {
            Self::Line { .. } | Self::Parabola { .. } | Self::Hyperbola { .. } => {
                [f64::NEG_INFINITY, f64::INFINITY]
            }
            Self::Ellipse { .. } => [0.0, TAU],
            Self::Spline(spline) => spline.domain(),
            Self::Polyline(points) => [0.0, points.len().saturating_sub(1) as f64],
            Self::Composite(segments) => [0.0, segments.iter().map(|(segment, _)| segment.extent()).sum()],
            Self::Trimmed { basis, range, same_sense } => {
                let [from, to] = basis.trimmed_range(*range, *same_sense);
                if *same_sense { [from, to] } else { [-from, -to] }
            }
        }
    }

    /// Length of the domain.
    pub(super) fn extent(&self) -> f64 {
        let [start, end] = self.domain();
        end - start
    }

    /// The parameters at the start and at the end of a part that runs in a sense: they ascend, or descend where `same_sense` is false.
    /// On a closed curve the second is moved by whole turns to at most one from the first, on others they change places if need be.
    pub(crate) fn trimmed_range(&self, [from, to]: [f64; 2], same_sense: bool) -> [f64; 2] {
        let sign = if same_sense { 1.0 } else { -1.0 };
        let along = sign * (to - from);
        let turn = self.extent();
        if along > 0.0 && (along <= turn || !turn.is_finite()) {
            return [from, to];
        }
        if self.returns() {
            let part = along.rem_euclid(turn);
            // Degrees become radians with the digits that a file gives: a turn may be longer than itself.
            let whole = part <= f64::EPSILON.sqrt() * turn;
            return [from, from + sign * if whole { turn } else { part }];
        }
        if along < 0.0 { [to, from] } else { [from, to] }
    }

    /// Whether its ends meet, compared with its size. Parts of curves, and composite curves within others, count as open: their ends
    /// would be found again on each level of a nest.
    fn returns(&self) -> bool {
        let inner = |(segment, _): &(Self, bool)| segment.contains_composite();
        match self {
            Self::Ellipse { .. } => return true,
            Self::Trimmed { .. } => return false,
            Self::Composite(segments) if segments.iter().any(inner) => return false,
            _ => {}
        }
        let [start, end] = self.domain();
        if !(end - start).is_finite() {
            return false;
        }
        let first = self.point(start);
        let distance = |s: f64| first.distance_to(self.point(start + (end - start) * s));
        let size = [0.25, 0.5, 0.75].map(distance).into_iter().fold(0.0, f64::max);
        self.period(CLOSED * size).is_some()
    }

    fn contains_composite(&self) -> bool {
        match self {
            Self::Composite(_) => true,
            Self::Trimmed { basis, .. } => basis.contains_composite(),
            _ => false,
        }
    }

    /// The length of the domain if the curve is closed: if its ends are at most `tolerance` apart, and its middle is not.
    #[must_use]
    pub fn period(&self, tolerance: f64) -> Option<f64> {
        if let Self::Ellipse { .. } = self {
            return Some(TAU);
        }
        let [start, end] = self.domain();
        if !(end - start).is_finite() || end <= start {
            return None;
        }
        let first = self.point(start);
        let closed = first.distance_to(self.point(end)) <= tolerance;
        let leaves = [0.25, 0.5, 0.75].map(|s| first.distance_to(self.point(start + (end - start) * s)));
        (closed && leaves.iter().any(|distance| *distance > tolerance)).then_some(end - start)
    }

    /// `t`, moved by the length of the domain if it lies outside by more than rounding.
    fn wrap(&self, t: f64) -> f64 {
        let [start, end] = self.domain();
        let turn = end - start;
        if !turn.is_finite() || turn <= 0.0 {
            return t;
        }
        // A multiple of the rounding of a shift by the period.
        let negligible = 8.0 * f64::EPSILON * (start.abs() + end.abs());
        if t > end + negligible || t < start - negligible { start + (t - start).rem_euclid(turn) } else { t }
    }

    /// The point at parameter `t`. On a curve with a bounded domain, parameters outside of it are moved by its length, as on a
    /// closed curve.
    #[must_use]
    pub fn point(&self, t: f64) -> P {
        self.derivatives(t, 0).first().copied().unwrap_or(P::ZERO)
    }

    /// The point and its derivatives of the orders 1 to `order`; at a corner those of the part that starts there.
    #[must_use]
    pub fn derivatives(&self, t: f64, order: usize) -> Vec<P> {
        let orders = 0..=order;
        match self {
            Self::Line { origin, direction } => {
                let line = |k| match k {
                    0 => *origin + *direction * t,
                    1 => *direction,
                    _ => P::ZERO,
                };
                orders.map(line).collect()
            }
            Self::Ellipse { center, a, b } => {
                let conic = |k: usize| {
                    // Each derivative turns by a quarter; the remainder keeps the bits of sine and cosine.
                    let (sin, cos) = t.sin_cos();
                    let [x, y] = [[cos, sin], [-sin, cos], [-cos, -sin], [sin, -cos]][k % 4];
                    let radius = *a * x + *b * y;
                    if k == 0 { *center + radius } else { radius }
                };
                orders.map(conic).collect()
            }
            Self::Parabola { apex, a, b } => {
                let parabola = |k| match k {
                    0 => *apex + *a * (t * t) + *b * (2.0 * t),
                    1 => (*a * t + *b) * 2.0,
                    2 => *a * 2.0,
                    _ => P::ZERO,
                };
                orders.map(parabola).collect()
            }
            Self::Hyperbola { center, a, b } => {
                let (even, odd) = (*a * t.cosh() + *b * t.sinh(), *a * t.sinh() + *b * t.cosh());
                let hyperbola = |k| match k {
                    0 => *center + even,
                    _ if k % 2 == 0 => even,
                    _ => odd,
                };
                orders.map(hyperbola).collect()
            }
            Self::Spline(spline) => spline.derivatives(self.wrap(t), order),
            Self::Polyline(points) => polyline(points, self.wrap(t), order),
            Self::Composite(segments) => composite(segments, self.wrap(t), order),
            Self::Trimmed { basis, same_sense: true, .. } => basis.derivatives(t, order),
            Self::Trimmed { basis, .. } => alternating(basis.derivatives(-t, order)),
        }
    }
}

/// Derivatives by the negative of a parameter.
fn alternating<P: CurveVector>(derivatives: Vec<P>) -> Vec<P> {
    derivatives.into_iter().enumerate().map(|(k, d)| if k % 2 == 0 { d } else { d * -1.0 }).collect()
}

fn polyline<P: CurveVector>(points: &[P], t: f64, order: usize) -> Vec<P> {
    let last = points.len().saturating_sub(2);
    let segment = (t.max(0.0).floor() as usize).min(last);
    let Some([a, b]) = points.get(segment..segment + 2) else {
        let only = points.first().copied().unwrap_or(P::ZERO);
        return (0..=order).map(|k| if k == 0 { only } else { P::ZERO }).collect();
    };
    let t = t - segment as f64;
    let line = |k| match k {
        // Exact at both ends.
        0 if t > 0.5 => *b + (*a - *b) * (1.0 - t),
        0 => *a + (*b - *a) * t,
        1 => *b - *a,
        _ => P::ZERO,
    };
    (0..=order).map(line).collect()
}

fn composite<P: CurveVector>(segments: &[(Curve<P>, bool)], t: f64, order: usize) -> Vec<P> {
    let mut start = 0.0;
    for (i, (segment, sense)) in segments.iter().enumerate() {
        let length = segment.extent();
        if t < start + length || i + 1 == segments.len() {
            let [from, to] = segment.domain();
            let t = (t - start).min(length).max(0.0);
            return if *sense {
                segment.derivatives(from + t, order)
            } else {
                alternating(segment.derivatives(to - t, order))
            };
        }
        start += length;
    }
    vec![P::ZERO; order + 1]
}
