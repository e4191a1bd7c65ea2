//! Error over samples and over time, and the speed-up of one method over another.

use glanz_light::Pixels;
use glanz_light::compare::{CompareError, RELATIVE_EPSILON, compare};

/// Errors of a picture against its reference, over all pixels and the channels R, G and B.
///
/// # Source
/// @pietrek2001 sections 3.4.1.1 and 3.4.1.2; departure: channels are compared, not grey values.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct PictureError {
    /// Root of the mean squared difference.
    pub(super) plain: f64,
    /// The same with both pictures clipped to 1, the brightest value of a display.
    pub(super) shown: f64,
}

impl PictureError {
    /// The error of `picture`.
    ///
    /// # Errors
    /// As [`compare`].
    pub(super) fn of(picture: &Pixels, reference: &Pixels) -> Result<Self, CompareError> {
        let found = compare(picture, reference, RELATIVE_EPSILON)?;
        Ok(Self { plain: found.rmse, shown: found.clipped_rmse })
    }

    /// The error in one of the two norms.
    pub(super) fn by(&self, norm: Norm) -> f64 {
        match norm {
            Norm::Plain => self.plain,
            Norm::Shown => self.shown,
        }
    }
}

/// The norms of errors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Norm {
    /// [`PictureError::plain`].
    Plain,
    /// [`PictureError::shown`].
    Shown,
}

impl Norm {
    pub(super) const ALL: [Self; 2] = [Self::Plain, Self::Shown];

    /// Name in tables.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Plain => "L2",
            Self::Shown => "modified L2",
        }
    }
}

/// A point of a convergence curve: an unfinished picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct CurvePoint {
    /// Samples of each pixel so far.
    pub(super) samples: u32,
    /// Wall time of the render loop so far, seconds.
    pub(super) wall: f64,
    /// Time of all processors so far, seconds.
    pub(super) processors: f64,
    pub(super) error: PictureError,
}

/// The clocks of a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Clock {
    /// [`CurvePoint::wall`].
    Wall,
    /// [`CurvePoint::processors`].
    Processors,
}

/// The curve of several runs of one method: root of the mean squared error, mean time. Points that are missing in one of the runs
/// are left out.
pub(super) fn combined(runs: &[Vec<CurvePoint>]) -> Vec<CurvePoint> {
    let Some(first) = runs.first() else { return Vec::new() };
    let together = |samples: u32| {
        let points: Vec<&CurvePoint> =
            runs.iter().filter_map(|run| run.iter().find(|p| p.samples == samples)).collect();
        let count = points.len() as f64;
        let mean = |value: &dyn Fn(&CurvePoint) -> f64| points.iter().map(|p| value(p)).sum::<f64>() / count;
        (points.len() == runs.len()).then(|| CurvePoint {
            samples,
            wall: mean(&|p| p.wall),
            processors: mean(&|p| p.processors),
            error: PictureError {
                plain: mean(&|p| p.error.plain.powi(2)).sqrt(),
                shown: mean(&|p| p.error.shown.powi(2)).sqrt(),
            },
        })
    };
    first.iter().filter_map(|point| together(point.samples)).collect()
}

/// Time and error of each point.
pub(super) fn over_time(points: &[CurvePoint], clock: Clock, norm: Norm) -> Vec<[f64; 2]> {
    let time = |point: &CurvePoint| match clock {
        Clock::Wall => point.wall,
        Clock::Processors => point.processors,
    };
    points.iter().map(|point| [time(point), point.error.by(norm)]).collect()
}

/// Samples and error of each point.
pub(super) fn over_samples(points: &[CurvePoint], norm: Norm) -> Vec<[f64; 2]> {
    points.iter().map(|point| [f64::from(point.samples), point.error.by(norm)]).collect()
}

/// The time from which a curve of times and errors stays at or below `error`; `None` if it does not reach that, or begins below
/// it. Interpolates linearly between logarithms.
pub(super) fn time_to(curve: &[[f64; 2]], error: f64) -> Option<f64> {
    if curve.last()?[1] > error {
        return None;
    }
    let last = curve.windows(2).rposition(|pair| pair.first().is_some_and(|[_, e]| *e >= error))?;
    let (&[t0, e0], &[t1, e1]) = (curve.get(last)?, curve.get(last + 1)?);
    let share = if e0 == e1 { 1.0 } else { (e0 / error).ln() / (e0 / e1).ln() };
    let time = t0 * (t1 / t0).powf(share);
    time.is_finite().then_some(time)
}

/// The value of a curve at `x`, interpolated linearly between logarithms; `None` outside.
pub(super) fn value_at(curve: &[[f64; 2]], x: f64) -> Option<f64> {
    let pair = curve.windows(2).find(|pair| pair.last().is_some_and(|[x1, _]| *x1 >= x))?;
    let (&[x0, y0], &[x1, y1]) = (pair.first()?, pair.last()?);
    let value = y0 * (y1 / y0).powf((x / x0).ln() / (x1 / x0).ln());
    (x >= x0 && value.is_finite()).then_some(value)
}

/// Times of two methods to the same error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SpeedUp {
    pub(super) error: f64,
    /// Of the plain method, seconds.
    pub(super) plain: f64,
    /// Of the other method, seconds.
    pub(super) other: f64,
}

impl SpeedUp {
    /// Factor by which the other method is faster.
    pub(super) fn factor(&self) -> f64 {
        self.plain / self.other
    }
}

/// `count` errors (2 or more) within the range of both curves, from the largest to the smallest at equal ratios; empty if the
/// ranges do not overlap.
pub(super) fn common_errors(plain: &[[f64; 2]], other: &[[f64; 2]], count: u32) -> Vec<f64> {
    // Noise may raise the end of a curve above earlier errors, which do not count as reached then.
    let ends = |curve: &[[f64; 2]]| Some((curve.first()?[1], curve.last()?[1]));
    let (Some((a, b)), Some((c, d))) = (ends(plain), ends(other)) else { return Vec::new() };
    let (largest, smallest) = (a.min(c), b.max(d));
    if !(smallest > 0.0 && smallest < largest && largest.is_finite()) {
        return Vec::new();
    }
    let share = |i: u32| f64::from(i) / f64::from(count.max(2) - 1);
    (0..count.max(2))
        .map(|i| match share(i) {
            1.0 => smallest,
            share => largest * (smallest / largest).powf(share),
        })
        .collect()
}

/// The times at these errors, where both curves have one.
pub(super) fn speed_ups(plain: &[[f64; 2]], other: &[[f64; 2]], errors: &[f64]) -> Vec<SpeedUp> {
    let at =
        |&error: &f64| Some(SpeedUp { error, plain: time_to(plain, error)?, other: time_to(other, error)? });
    errors.iter().filter_map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(rgb: &[[f32; 3]]) -> Pixels {
        Pixels::try_from_rgb(rgb.len() as u32, 1, rgb).unwrap()
    }

    fn close(a: f64, b: f64) -> bool {
        (a - b).abs() <= 1e-12 * b.abs()
    }

    #[test]
    fn modified_norm_does_not_see_what_a_display_does_not_show() {
        // Differences: 0.5 in one of six values, 99 in another, where both are brighter than 1.
        let reference = picture(&[[0.0, 1.0, 2.0], [0.25; 3]]);
        let other = picture(&[[0.5, 1.0, 101.0], [0.25; 3]]);
        let error = PictureError::of(&other, &reference).unwrap();
        assert!(close(error.by(Norm::Plain), ((0.25 + 99.0 * 99.0) / 6.0_f64).sqrt()));
        assert!(close(error.by(Norm::Shown), (0.25 / 6.0_f64).sqrt()));
    }

    #[test]
    fn errors_of_runs_are_averaged_as_squares() {
        let point = |samples, wall, plain| CurvePoint {
            samples,
            wall,
            processors: 2.0 * wall,
            error: PictureError { plain, shown: 0.5 * plain },
        };
        let runs = [vec![point(1, 1.0, 3.0), point(2, 2.0, 2.0)], vec![point(1, 3.0, 4.0)]];
        let all = combined(&runs);
        assert_eq!(all.len(), 1);
        assert!(close(all[0].error.plain, 12.5_f64.sqrt()) && close(all[0].error.shown, 3.125_f64.sqrt()));
        assert_eq!((all[0].wall, all[0].processors), (2.0, 4.0));
        assert_eq!(combined(&[]), Vec::new());
    }

    #[test]
    fn time_to_an_error_follows_the_power_law_between_points() {
        // error = 2 / sqrt(t), known at few times.
        let curve = [1.0, 4.0, 100.0].map(|t: f64| [t, 2.0 / t.sqrt()]);
        for t in [1.0, 1.7, 4.0, 25.0, 99.0, 100.0_f64] {
            assert!(close(time_to(&curve, 2.0 / t.sqrt()).unwrap(), t), "{t}");
        }
        assert_eq!((time_to(&curve, 2.1), time_to(&curve, 0.19), time_to(&[], 1.0)), (None, None, None));
    }

    #[test]
    fn values_between_points_follow_the_power_law() {
        let curve = [4.0, 64.0, 128.0].map(|n: f64| [n, 3.0 * n.powf(-0.7)]);
        for n in [4.0, 5.0, 64.0, 100.0, 128.0_f64] {
            assert!(close(value_at(&curve, n).unwrap(), 3.0 * n.powf(-0.7)), "{n}");
        }
        assert_eq!((value_at(&curve, 3.0), value_at(&curve, 129.0), value_at(&[], 1.0)), (None, None, None));
    }

    #[test]
    fn an_error_counts_as_reached_when_it_is_not_exceeded_any_more() {
        let curve = [[1.0, 8.0], [2.0, 2.0], [4.0, 8.0], [8.0, 2.0]];
        assert!(close(time_to(&curve, 4.0).unwrap(), 32.0_f64.sqrt()));
        let rising = [[1.0, 2.0], [2.0, 1.0], [4.0, 3.0]];
        assert_eq!(time_to(&rising, 1.5), None);
    }

    #[test]
    fn speed_ups_of_constructed_curves_are_their_ratio() {
        // The other method takes a third of the time to the same error, but pays 0.5 s before it begins.
        let times = [1.0, 2.0, 4.0, 8.0, 16.0, 32.0_f64];
        let plain: Vec<[f64; 2]> = times.iter().map(|t| [*t, t.powf(-0.5)]).collect();
        let third: Vec<[f64; 2]> = times.iter().map(|t| [t / 3.0, t.powf(-0.5)]).collect();
        let errors = common_errors(&plain, &third, 4);
        assert_eq!((errors.len(), errors[0]), (4, 1.0));
        assert!(close(errors[3], 32.0_f64.powf(-0.5)) && close(errors[1] / errors[0], errors[3] / errors[2]));
        let found = speed_ups(&plain, &third, &errors);
        assert_eq!(found.len(), 4);
        assert!(found.iter().all(|s| close(s.factor(), 3.0)), "{found:?}");
        let late: Vec<[f64; 2]> = third.iter().map(|[t, e]| [t + 0.5, *e]).collect();
        let found = speed_ups(&plain, &late, &errors);
        assert!(close(found[0].factor(), 1.0 / (1.0 / 3.0 + 0.5)) && found[0].factor() < found[3].factor());
    }

    #[test]
    fn only_errors_that_both_curves_reach_are_compared() {
        let plain = [[1.0, 1.0], [4.0, 0.25]];
        let better = [[1.0, 0.5], [4.0, 0.125]];
        let errors = common_errors(&plain, &better, 3);
        assert_eq!((errors[0], errors[2]), (0.5, 0.25));
        assert_eq!(common_errors(&plain, &[[1.0, 0.2], [4.0, 0.1]], 3), Vec::<f64>::new());
        assert_eq!(common_errors(&plain, &[], 3), Vec::<f64>::new());
    }
}
