//! Results of a room.

use glanz_light::Pixels;

use super::curve::{Clock, CurvePoint, Norm, SpeedUp, common_errors, over_time, speed_ups};
use super::method::RenderMethod;

/// Number of errors in a table of speed-ups, as in document 003.
pub(super) const ERRORS: u32 = 8;

/// Results of a method in a room.
pub(super) struct MethodOutcome {
    pub(super) method: RenderMethod,
    /// Whether lights are sampled.
    pub(super) lights: bool,
    pub(super) curve: Vec<CurvePoint>,
    /// Errors by frozen guides; samples count those learnt from.
    pub(super) frozen: Vec<CurvePoint>,
}

impl MethodOutcome {
    /// Error and time at the end of the curve.
    pub(super) fn last(&self) -> Option<&CurvePoint> {
        self.curve.last()
    }
}

/// Results of all methods in a room.
pub(super) struct RoomOutcome {
    pub(super) name: String,
    pub(super) outcomes: Vec<MethodOutcome>,
    /// Reasons for missing methods.
    pub(super) refused: Vec<String>,
    /// Samples per pixel of the reference.
    pub(super) reference_samples: u64,
    /// Pictures at equal time, side by side.
    pub(super) sheet: Option<Pixels>,
}

/// Comparison of a method with `path`, both with or both without light sampling.
pub(super) struct MethodComparison<'a> {
    pub(super) outcome: &'a MethodOutcome,
    pub(super) norm: Norm,
    /// By wall time, from the largest error to the smallest.
    pub(super) wall: Vec<SpeedUp>,
    /// The same by processor time.
    pub(super) processors: Vec<SpeedUp>,
}

impl MethodComparison<'_> {
    /// Smallest and largest factor by wall time.
    pub(super) fn range(&self) -> Option<[f64; 2]> {
        let factors = self.wall.iter().map(SpeedUp::factor);
        let range = factors.fold([f64::INFINITY, 0.0_f64], |[a, b], f| [a.min(f), b.max(f)]);
        (!self.wall.is_empty()).then_some(range)
    }

    /// Geometric mean of the factors by wall time; 0 if there are none.
    fn mean(&self) -> f64 {
        let logarithms: f64 = self.wall.iter().map(|s| s.factor().ln()).sum();
        if self.wall.is_empty() { 0.0 } else { (logarithms / self.wall.len() as f64).exp() }
    }
}

impl RoomOutcome {
    /// The outcome of the method with this key.
    pub(super) fn outcome(&self, key: &str, lights: bool) -> Option<&MethodOutcome> {
        self.outcomes.iter().find(|o| o.method.key == key && o.lights == lights)
    }

    /// The outcome of the path tracer.
    pub(super) fn path(&self, lights: bool) -> Option<&MethodOutcome> {
        self.outcome(&RenderMethod::path().key, lights)
    }

    /// Estimated upper bound of the reference's own error: that of a shorter picture by the same method, scaled by the inverse
    /// root of the number of samples.
    pub(super) fn reference_error(&self) -> Option<f64> {
        let last = self.path(true)?.last()?;
        Some(last.error.plain * (f64::from(last.samples) / self.reference_samples as f64).sqrt())
    }

    /// Comparison of `outcome` with `path`.
    pub(super) fn comparison<'a>(
        &self,
        outcome: &'a MethodOutcome,
        norm: Norm,
    ) -> Option<MethodComparison<'a>> {
        let path = self.path(outcome.lights)?;
        let line = |o: &MethodOutcome, clock| over_time(&o.curve, clock, norm);
        let errors = common_errors(&line(path, Clock::Wall), &line(outcome, Clock::Wall), ERRORS);
        let by = |clock| speed_ups(&line(path, clock), &line(outcome, clock), &errors);
        Some(MethodComparison { outcome, norm, wall: by(Clock::Wall), processors: by(Clock::Processors) })
    }

    /// All comparisons in this norm but that of `path` with itself.
    pub(super) fn comparisons(&self, norm: Norm) -> impl Iterator<Item = MethodComparison<'_>> {
        let others = self.outcomes.iter().filter(|o| o.method != RenderMethod::path());
        others.filter_map(move |outcome| self.comparison(outcome, norm))
    }

    /// The method of document 003 with the largest speed-up, by the geometric mean of its factors in the document's norm.
    pub(super) fn best_grid(&self, lights: bool) -> Option<&MethodOutcome> {
        let asked =
            |o: &MethodOutcome| o.lights == lights && o.method.grid.is_some() && o.method.passes().is_none();
        let comparisons = self.comparisons(Norm::Shown).filter(|comparison| asked(comparison.outcome));
        comparisons.max_by(|a, b| a.mean().total_cmp(&b.mean())).map(|comparison| comparison.outcome)
    }
}

/// A room `hall` in which every method takes 1, 2 and so on to 128 samples in a second for each; the errors of `path` are 1 / root of
/// the samples, those of the next method two thirds of it, of the one after two quarters, and so on.
#[cfg(test)]
pub(super) fn constructed(methods: impl Iterator<Item = RenderMethod>) -> RoomOutcome {
    use super::curve::PictureError;

    let mut outcomes = Vec::new();
    for (i, method) in methods.enumerate() {
        let scale = 2.0 / (2.0 + i as f64);
        let point = |samples: u32| {
            let (time, plain) = (f64::from(samples), scale / f64::from(samples).sqrt());
            CurvePoint {
                samples,
                wall: time,
                processors: 2.0 * time,
                error: PictureError { plain, shown: 0.5 * plain },
            }
        };
        let points = |first: u32| (first..=7).map(|power| point(1 << power)).collect::<Vec<_>>();
        for lights in [false, true] {
            let frozen = if i == 0 { Vec::new() } else { points(2) };
            outcomes.push(MethodOutcome { method: method.clone(), lights, curve: points(0), frozen });
        }
    }
    RoomOutcome { name: "hall".into(), outcomes, refused: Vec::new(), reference_samples: 12_800, sheet: None }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::guiding::method::entries;

    #[test]
    fn factors_are_those_of_the_constructed_curves() {
        let room = constructed(entries(128, false).into_iter().map(|entry| entry.method));
        // Two thirds of the error is the same error in four ninths of the time.
        for norm in Norm::ALL {
            let comparison = room.comparison(room.outcome("tree", true).unwrap(), norm).unwrap();
            let [least, most] = comparison.range().unwrap();
            assert_eq!(comparison.wall.len(), ERRORS as usize);
            assert!((least - 2.25).abs() < 1e-9 && (most - 2.25).abs() < 1e-9, "{least} {most}");
            assert!(comparison.processors.iter().all(|s| (s.factor() - 2.25).abs() < 1e-9));
        }
        let itself = room.comparison(room.path(true).unwrap(), Norm::Plain).unwrap();
        assert!((itself.range().unwrap()[1] - 1.0).abs() < 1e-12);
    }

    #[test]
    fn noise_of_the_reference_falls_with_the_root_of_its_samples() {
        let room = constructed([RenderMethod::path()].into_iter());
        assert!((room.reference_error().unwrap() - 1.0 / 12_800.0_f64.sqrt()).abs() < 1e-15);
    }

    #[test]
    fn the_best_grid_is_that_with_the_largest_factors() {
        let room = constructed(entries(128, false).into_iter().map(|entry| entry.method));
        let best = room.best_grid(false).unwrap();
        assert!(!best.lights && best.method.grid.is_some());
        // The later a method is in the list, the better it is there.
        let last = room.outcomes.iter().rfind(|o| o.method.passes().is_none()).unwrap();
        assert_eq!(best.method, last.method);
        assert!(
            constructed([RenderMethod::path(), RenderMethod::tree()].into_iter()).best_grid(true).is_none()
        );
    }
}
