//! Widths of curves in region coordinates.

use glanz_geometry::spline::KnotVector;
use glanz_geometry::trim::scale_across;
use glanz_math::DVec2;

use crate::boundary::BoundaryCurve;
use crate::carrier::Carrier;
use crate::model::SplineCurve;

/// Largest ratio by which the width of a curve grows where parameters are dense, as next to a pole.
const MAX_STRETCH: f64 = 1e3;

/// Ratio of the stretches on a curve up to which it has one width.
const VARIATION: f64 = 4.0;

/// Largest ratio of the stretches at neighbouring samples; widths are larger by it, as the stretch varies between samples.
const STEP: f64 = 1.25;

/// Halvings between samples, at most: each halves the distance from a pole.
const MOST_HALVINGS: u32 = 12;

/// Least number of parts of a curve between whose ends it is sampled.
const SAMPLES: usize = 16;

/// Most samples at knots, with one more for each chord; of more crossings, only one in so many is one.
const MOST_KNOTS: u64 = 4096;

/// Most parts of a curve with widths of their own; a meridian with the largest ratio of stretches has fewer than a dozen.
const MOST_PARTS: usize = 64;

/// A curve on a carrier, in region coordinates: parameters times `metric`.
pub(super) struct StretchedCurve<'a> {
    carrier: &'a Carrier,
    metric: DVec2,
    curve: &'a BoundaryCurve,
    /// Parameters of the curve, ascending, with the stretches there.
    samples: Vec<(f64, f64)>,
}

/// The knots of a spline in one parameter, numbered from that at the start of its domain on.
struct PeriodicKnots<'a> {
    /// Those of the domain; some repeat.
    knots: &'a [f64],
    /// The length after which they repeat.
    period: Option<f64>,
}

impl<'a> PeriodicKnots<'a> {
    fn new(knots: &'a KnotVector, period: Option<f64>) -> Self {
        Self { knots: knots.knots().get(knots.degree()..=knots.count()).unwrap_or_default(), period }
    }

    /// The number of the first knot that is not below a value; with `above`, of the first above it.
    fn first(&self, value: f64, above: bool) -> i64 {
        let count_in = |knots: &[f64], value: f64| {
            knots.partition_point(|knot| *knot < value || above && *knot == value) as i64
        };
        let (Some(period), [start, .., _]) = (self.period, self.knots) else {
            return count_in(self.knots, value);
        };
        let whole = &self.knots[..self.knots.len() - 1];
        // Of far more turns than a curve has, numbers would overflow.
        let turns = ((value - start) / period).floor().clamp(-1e9, 1e9);
        turns as i64 * whole.len() as i64 + count_in(whole, value - turns * period)
    }

    fn at(&self, number: i64) -> f64 {
        let Some(period) = self.period else {
            return self.knots.get(number as usize).copied().unwrap_or(f64::NAN);
        };
        let count = self.knots.len() as i64 - 1;
        let knot = self.knots.get(number.rem_euclid(count) as usize).copied().unwrap_or(f64::NAN);
        knot + number.div_euclid(count) as f64 * period
    }
}

/// A curve with a width in region coordinates.
pub(super) struct WidenedCurve {
    pub(super) curve: BoundaryCurve,
    /// The largest distance on the surface, metres, that the width amounts to at samples along the curve; between them it may be larger.
    pub(super) distance: f64,
}

impl<'a> StretchedCurve<'a> {
    pub(super) fn new(carrier: &'a Carrier, metric: DVec2, curve: &'a BoundaryCurve) -> Self {
        let mut stretched = Self { carrier, metric, curve, samples: Vec::new() };
        let spans = curve.spans();
        let parts = SAMPLES.div_ceil(spans.len().max(1));
        let inner = |[low, high]: [f64; 2]| {
            let at =
                move |i: usize| if i == parts { high } else { low + (high - low) * i as f64 / parts as f64 };
            (1..=parts).map(at)
        };
        let Some(first) = spans.first().map(|span| span[0]) else { return stretched };
        let places: Vec<f64> = [first].into_iter().chain(spans.into_iter().flat_map(inner)).collect();
        let mut start = (first, stretched.at(first));
        stretched.samples.push(start);
        for t in stretched.with_knots(&places).into_iter().skip(1) {
            let end = (t, stretched.at(t));
            stretched.refine([start, end], MOST_HALVINGS);
            start = end;
        }
        stretched
    }

    /// Places on the curve with those between them where it crosses knots of a spline, on which a narrow place may begin and end.
    fn with_knots(&self, places: &[f64]) -> Vec<f64> {
        let mut all = places.to_vec();
        let Carrier::Spline(spline) = self.carrier else { return all };
        // A curve without a width may stretch as it likes.
        if self.curve.width <= 0.0 {
            return all;
        }
        let (surface, periods) = (spline.surface(), spline.periods());
        let knots = [surface.knots_u(), surface.knots_v()];
        let knots = [0, 1].map(|axis| PeriodicKnots::new(knots[axis], periods[axis]));
        let points: Vec<DVec2> =
            places.iter().map(|t| self.curve.point_and_derivative(*t).0 / self.metric).collect();
        // On each chord, the numbers of the knots of each axis that it crosses.
        let chords = || places.windows(2).zip(points.windows(2));
        let crossed = |ends: &[DVec2], axis: usize| {
            let (a, b) = (ends[0][axis], ends[1][axis]);
            knots[axis].first(a.min(b), true)..knots[axis].first(a.max(b), false)
        };
        let lengths = chords().flat_map(|(_, ends)| [0, 1].map(|axis| crossed(ends, axis)));
        let total: u64 = lengths.map(|range| (range.end - range.start).max(0) as u64).sum();
        let step = usize::try_from(total.div_ceil(MOST_KNOTS)).unwrap_or(usize::MAX).max(1);
        for (places, ends) in chords() {
            for axis in [0, 1] {
                let (a, b) = (ends[0][axis], ends[1][axis]);
                let fractions = crossed(ends, axis).step_by(step).map(|i| (knots[axis].at(i) - a) / (b - a));
                all.extend(fractions.map(|fraction| places[0] + (places[1] - places[0]) * fraction));
            }
        }
        let [low, high] = [places[0], places[places.len() - 1]];
        all.retain(|t| (low..=high).contains(t));
        all.sort_by(f64::total_cmp);
        all.dedup();
        all
    }

    /// How much longer a small distance across the curve is in region coordinates than on the surface; less than 1 where parameters are sparse.
    fn at(&self, t: f64) -> f64 {
        let (at, along) = self.curve.point_and_derivative(t);
        let [du, dv] = self.carrier.tangents(at / self.metric);
        let scale = scale_across([du / self.metric.x, dv / self.metric.y], along);
        if scale.is_nan() { 1.0 } else { scale.recip().clamp(MAX_STRETCH.recip(), MAX_STRETCH) }
    }

    /// Adds samples behind the first end, up to the second.
    fn refine(&mut self, [start, end]: [(f64, f64); 2], halvings: u32) {
        let middle = 0.5 * (start.0 + end.0);
        // Where parameters are sparse, widths do not change.
        let [a, b] = [start.1.max(1.0), end.1.max(1.0)];
        if halvings > 0 && a.max(b) > STEP * a.min(b) && middle > start.0 && middle < end.0 {
            let middle = (middle, self.at(middle));
            self.refine([start, middle], halvings - 1);
            self.refine([middle, end], halvings - 1);
        } else {
            self.samples.push(end);
        }
    }

    /// The largest stretch, at least 1.
    fn largest(&self) -> f64 {
        STEP * self.samples.iter().map(|sample| sample.1).fold(1.0, f64::max)
    }

    /// The curve with widths in region coordinates, at most `limit`, that amount to its width on the surface: one part, or several on each of
    /// which the stretch varies by at most [`VARIATION`]. It stays one where no width exceeds `unseen`; metres. `fraction`: that of the edge at a
    /// point in region coordinates.
    pub(super) fn widened(
        &self,
        limit: f64,
        unseen: f64,
        fraction: impl Fn(DVec2) -> Option<f64>,
    ) -> Vec<WidenedCurve> {
        let distance = self.curve.width;
        let mut parts = Vec::new();
        if distance * self.largest() > unseen {
            parts = self.parts(fraction).unwrap_or_default();
        }
        if parts.is_empty() {
            parts.push((self.curve.clone(), [0, self.samples.len().saturating_sub(1)]));
        }
        let widened = parts.into_iter().map(|(curve, [first, last])| {
            let stretches = self.samples.get(first..=last).unwrap_or_default().iter().map(|sample| sample.1);
            let (least, most) = stretches.fold((f64::INFINITY, 1.0), |(a, b), s| (s.min(a), s.max(b)));
            let width = (STEP * most * distance).min(limit);
            WidenedCurve { curve: BoundaryCurve { width, ..curve }, distance: width / least.min(most) }
        });
        widened.collect()
    }

    /// The first samples of parts on which the stretch varies by at most this ratio.
    fn cuts(&self, variation: f64) -> Vec<usize> {
        let mut cuts = vec![0];
        let (mut least, mut most) = (f64::INFINITY, 0.0_f64);
        // Widths never shrink, so that smaller stretches need no parts of their own.
        let stretches: Vec<f64> = self.samples.iter().map(|sample| sample.1.max(1.0)).collect();
        for (i, pair) in stretches.windows(2).enumerate() {
            let [before, stretch] = [pair[0], pair[1]];
            (least, most) = (least.min(before).min(stretch), most.max(before).max(stretch));
            if most > variation * least && cuts.last().is_some_and(|cut| *cut < i) {
                cuts.push(i);
                (least, most) = (before.min(stretch), before.max(stretch));
            }
        }
        cuts
    }

    /// Parts of the curve, with their first and last sample; `None` if it need not or cannot be divided.
    fn parts(&self, fraction: impl Fn(DVec2) -> Option<f64>) -> Option<Vec<(BoundaryCurve, [usize; 2])>> {
        let mut variation = VARIATION;
        let mut cuts = self.cuts(variation);
        while cuts.len() > MOST_PARTS {
            variation *= VARIATION;
            cuts = self.cuts(variation);
        }
        if cuts.len() == 1 {
            return None;
        }
        cuts.push(self.samples.len() - 1);
        let knots = KnotVector::try_new(self.curve.degree, self.curve.knots.clone()).ok()?;
        let spline = SplineCurve::<DVec2>::from_knots(knots, self.curve.points.clone()).ok()?;
        let [start, end] = self.curve.range;
        let mut from = start;
        let mut parts: Vec<(BoundaryCurve, [usize; 2])> = Vec::with_capacity(cuts.len());
        for (k, pair) in cuts.windows(2).enumerate() {
            let ends = [self.samples.get(pair[0])?.0, self.samples.get(pair[1])?.0];
            let part = spline.restrict(ends).ok()?;
            let mut points = part.control_points().to_vec();
            // Each part starts, to the bit, where the one before ends.
            if let Some(before) = parts.last().and_then(|(curve, _)| curve.points.last()) {
                *points.first_mut()? = *before;
            }
            let to = if k + 2 == cuts.len() {
                end
            } else {
                fraction(self.curve.point_and_derivative(ends[1]).0).unwrap_or(end)
            };
            // On a closed edge a point near its ends may have the fraction of either.
            let to = if start <= end { to.clamp(from, end) } else { to.clamp(end, from) };
            let knots = part.knots().knots().to_vec();
            parts.push((
                BoundaryCurve { knots, points, range: [from, to], ..self.curve.clone() },
                [pair[0], pair[1]],
            ));
            from = to;
        }
        Some(parts)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use glanz_geometry::spline::NurbsSurface;
    use glanz_math::glam::DVec4;
    use glanz_math::{Bounds3, DVec3};

    use super::*;
    use crate::model::{FaceSurface, Placement};

    const DISTANCE: f64 = 1e-6;

    /// A sphere of radius 1, and a line in its parameters whose width is [`DISTANCE`] on the surface, widened.
    fn widened(from: DVec2, to: DVec2) -> Vec<WidenedCurve> {
        let placement = Placement { origin: DVec3::ZERO, x: DVec3::X, y: DVec3::Y, z: DVec3::Z };
        let carrier = Carrier::Sphere { placement, radius: 1.0 };
        let curve = BoundaryCurve { width: DISTANCE, edge: Some(0), ..BoundaryCurve::line(from, to) };
        let stretched = StretchedCurve::new(&carrier, DVec2::ONE, &curve);
        stretched.widened(0.02, 1e-9, |at| Some((at - from).length() / (to - from).length()))
    }

    #[test]
    fn distance_on_the_surface_is_larger_where_parameters_are_sparse() {
        // x = u^2: at its end, a step in u is twice as long on the surface.
        let points = [0.0, 0.0, 1.0].into_iter().flat_map(|x| [0.0, 1.0].map(|y| DVec4::new(x, y, 0.0, 1.0)));
        let knots = [vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0], vec![0.0, 0.0, 1.0, 1.0]];
        let surface = FaceSurface::Spline(NurbsSurface::try_new([2, 1], knots, points.collect()).unwrap());
        let extent = Bounds3::new(DVec3::ZERO, DVec3::new(1.0, 1.0, 0.0));
        let carrier = Carrier::try_from_surface(&surface, extent, 1e-9).unwrap().carrier;
        let curve = BoundaryCurve { width: DISTANCE, ..BoundaryCurve::line(DVec2::X, DVec2::ONE) };
        let stretched = StretchedCurve::new(&carrier, DVec2::ONE, &curve);
        let [part] = <[WidenedCurve; 1]>::try_from(stretched.widened(0.02, 1e-9, |_| None)).ok().unwrap();
        assert_eq!(part.curve.width, STEP * DISTANCE);
        assert!((part.distance / part.curve.width - 2.0).abs() < 1e-12, "{}", part.distance);
    }

    /// The middle line of a flat ribbon whose widths at equal steps are given, widened, and the step of its parameters. Those across the ribbon are dense
    /// where it is narrow.
    fn along_ribbon(widths: &[f64]) -> (Vec<WidenedCurve>, f64) {
        let last = widths.len() - 1;
        let at = |x: f64| {
            let points = widths.iter().enumerate();
            points.map(move |(i, width)| DVec4::new(x * width, i as f64 / last as f64, 0.0, 1.0))
        };
        let points = [-0.5, 0.5].into_iter().flat_map(at).collect();
        let along = [0].into_iter().chain(0..=last).chain([last]).map(|i| i as f64).collect();
        let surface = NurbsSurface::try_new([1, 1], [vec![0.0, 0.0, 1.0, 1.0], along], points).unwrap();
        let extent = Bounds3::new(DVec3::new(-0.5, 0.0, 0.0), DVec3::new(0.5, 1.0, 0.0));
        let carrier = Carrier::try_from_surface(&FaceSurface::Spline(surface), extent, 1e-9).unwrap().carrier;
        let [[_, across], [start, end]] = carrier.domain();
        let line = BoundaryCurve::line(DVec2::new(0.5 * across, start), DVec2::new(0.5 * across, end));
        let curve = BoundaryCurve { width: DISTANCE, edge: Some(0), ..line };
        let parts =
            StretchedCurve::new(&carrier, DVec2::ONE, &curve).widened(0.02, 1e-9, |at| Some(at.y / end));
        (parts, end / last as f64)
    }

    #[test]
    fn a_narrow_place_at_a_knot_between_samples_is_found() {
        let mut widths = [1.0; 129];
        widths[68] = 1e-2;
        let (parts, step) = along_ribbon(&widths);
        let narrow = |part: &&WidenedCurve| {
            let [low, high] = part.curve.bounds().map(|corner| corner.y / step);
            low <= 68.0 && high >= 68.0
        };
        let width = parts.iter().filter(narrow).map(|part| part.curve.width).fold(0.0, f64::max);
        assert!(width > 50.0 * DISTANCE, "{width}");
        let ends = [&parts[0], &parts[parts.len() - 1]].map(|part| part.curve.width);
        assert!(ends.iter().all(|width| *width <= STEP * VARIATION * DISTANCE), "{ends:?}");
    }

    #[test]
    fn a_ribbon_of_many_waves_has_few_parts_that_are_wide_enough() {
        let widths: Vec<f64> = (0..=400).map(|i| if i % 2 == 0 { 1.0 } else { 1e-2 }).collect();
        let (parts, _) = along_ribbon(&widths);
        assert!(parts.len() <= MOST_PARTS, "{}", parts.len());
        assert!(parts.iter().all(|part| part.curve.width > 50.0 * DISTANCE));
    }

    #[test]
    fn knots_repeat_after_a_period() {
        let knots = PeriodicKnots { knots: &[0.0, 1.0, 3.0, 4.0], period: Some(4.0) };
        let all: Vec<f64> = (-4..5).map(|i| knots.at(i)).collect();
        assert_eq!(all, [-5.0, -4.0, -3.0, -1.0, 0.0, 1.0, 3.0, 4.0, 5.0]);
        for (i, value) in (-4..).zip(&all) {
            assert_eq!([false, true].map(|above| knots.first(*value, above)), [i, i + 1], "{value}");
        }
        let once = PeriodicKnots { period: None, ..knots };
        assert_eq!([-1.0, 0.0, 2.0, 9.0].map(|value| once.first(value, false)), [0, 0, 2, 4]);
    }

    #[test]
    fn a_narrow_place_behind_many_knots_is_found() {
        // Each wave takes several samples.
        let mut widths: Vec<f64> = (0..=3000).map(|i| if i % 2 == 0 { 1.0 } else { 0.6 }).collect();
        widths[2901] = 1e-2;
        let (parts, step) = along_ribbon(&widths);
        let near = |part: &&WidenedCurve| part.curve.bounds()[1].y > 2900.0 * step;
        let width = parts.iter().filter(near).map(|part| part.curve.width).fold(0.0, f64::max);
        assert!(width > 50.0 * DISTANCE, "{width}");
    }

    #[test]
    fn meridians_get_wider_towards_their_pole_and_parallels_do_not() {
        let parts = widened(DVec2::ZERO, DVec2::new(0.0, FRAC_PI_2));
        // Stretches from 1 to MAX_STRETCH, with a part per factor of VARIATION: their logarithms are 10 and 2.
        assert!((5..12).contains(&parts.len()), "{}", parts.len());
        assert_eq!((parts[0].curve.range[0], parts.last().unwrap().curve.range[1]), (0.0, 1.0));
        for pair in parts.windows(2) {
            assert_eq!(pair[0].curve.end(), pair[1].curve.start());
            assert_eq!(pair[0].curve.range[1], pair[1].curve.range[0]);
            assert!(pair[0].curve.width < pair[1].curve.width);
        }
        for WidenedCurve { curve, distance } in &parts {
            for i in 0..=10 {
                let v = curve.start().lerp(curve.end(), f64::from(i) / 10.0).y;
                // Parallels are shorter by cos v.
                let on_surface = curve.width * v.cos();
                assert!(on_surface <= 1.01 * distance, "{v} {on_surface} {distance}");
                assert!(on_surface >= DISTANCE.min(1e3 * DISTANCE * v.cos()), "{v} {on_surface}");
            }
            assert!(*distance < 8.0 * DISTANCE, "{distance}");
            assert!((curve.range[1] - curve.end().y / FRAC_PI_2).abs() < 1e-12);
        }
        // A parallel next to the pole.
        let parts = widened(DVec2::new(0.0, 1.57), DVec2::new(3.0, 1.57));
        assert!(parts.len() == 1 && parts[0].curve.width < 1.3 * DISTANCE, "{}", parts[0].curve.width);
    }
}
