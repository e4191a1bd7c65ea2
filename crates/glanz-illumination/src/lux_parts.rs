//! Illuminance of cells as the sum of parts from several methods.

use crate::gather::GatheredFlux;
use crate::lux_map::{LuxMap, LuxStatistics};
use crate::receiver::{Receiver, Receivers, SMALLEST_SHARE};
use crate::replicates::{REPLICATES, ReplicateCounts, ReplicateEstimate, with_bound};
use crate::tally::Tally;

/// Illuminance of a cell by integration.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct IntegratedLux {
    /// Mean over the cell, lx.
    pub lux: f64,
    /// Estimated bound on its error, lx.
    pub error: f64,
    /// Whether the error is within the tolerance.
    pub converged: bool,
}

/// The parts of the light on the cells of receivers.
pub(crate) struct LuxParts<'a> {
    pub(crate) receivers: &'a Receivers,
    /// Of all cells of all receivers; empty if nothing is integrated.
    pub(crate) integrated: &'a [IntegratedLux],
    pub(crate) gathered: Option<&'a GatheredFlux>,
    pub(crate) tally: &'a Tally,
    /// Whether a cell without particles may have their light nevertheless.
    pub(crate) may_be_uncounted: bool,
    /// Methods whose errors count.
    pub(crate) errors: ErrorSources,
}

/// Choice of the methods whose errors count.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ErrorSources {
    pub(crate) integration: bool,
    pub(crate) paths: bool,
    pub(crate) particles: bool,
}

impl ErrorSources {
    pub(crate) const ALL: Self = Self { integration: true, paths: true, particles: true };
    pub(crate) const PATHS: Self = Self { integration: false, paths: true, particles: false };
    pub(crate) const PARTICLES: Self = Self { integration: false, paths: false, particles: true };
}

/// Illuminance of a cell.
#[derive(Clone, Copy, Debug, Default)]
struct CellLux {
    /// Its area, m^2; 0 where nothing is left of the surface.
    area: f64,
    /// Means of the replicates, lx.
    means: [f64; REPLICATES],
    /// Mean, lx, its standard error, and the bound of what is integrated.
    lux: f64,
    error: f64,
    bound: f64,
    /// Upper limit of the light of particles of which none was counted, lx; 0 elsewhere.
    uncounted_limit: f64,
}

/// Upper 97.5 % limit of the expected number of particles of which none was counted.
const UNCOUNTED: f64 = 3.7;

impl<'a> LuxParts<'a> {
    /// All light by particles.
    pub(crate) fn of_particles(tally: &'a Tally, receivers: &'a Receivers) -> Self {
        Self {
            receivers,
            integrated: &[],
            gathered: None,
            tally,
            may_be_uncounted: true,
            errors: ErrorSources::ALL,
        }
    }

    /// Numbers of particles by which the means of replicates are weighted.
    fn counts(&self) -> ReplicateCounts {
        if self.tally.particles().is_empty() && self.gathered.is_some() {
            ReplicateCounts::EQUAL
        } else {
            ReplicateCounts::of(self.tally.particles())
        }
    }

    /// The cells of a receiver, by their numbers in it. Cells without area are black.
    fn cells(&self, number: usize) -> impl Iterator<Item = CellLux> + '_ {
        let (counts, of_tally) = (self.counts(), ReplicateCounts::of(self.tally.particles()));
        let errors = self.errors;
        let flux_of_one =
            if self.may_be_uncounted && errors.particles { self.tally.flux_of_one() } else { 0.0 };
        let kept = |varies: bool, means: [f64; REPLICATES]| {
            if varies { means } else { [means.iter().sum::<f64>() / REPLICATES as f64; REPLICATES] }
        };
        let areas = self.receivers.as_slice().get(number).map_or(&[][..], Receiver::areas);
        self.receivers.cells_of(number).zip(areas).map(move |(cell, &area)| {
            if area <= 0.0 {
                return CellLux::default();
            }
            let by_particles = of_tally.means(|replicate| self.tally.cell_sum(replicate, cell));
            let is_uncounted = by_particles == [0.0; REPLICATES];
            let by_particles = kept(errors.particles, by_particles);
            let gathered = self.gathered.map_or([0.0; REPLICATES], |gathered| gathered.means(cell));
            let is_unlit = errors.paths && gathered == [0.0; REPLICATES];
            let gathered = kept(errors.paths, gathered);
            let IntegratedLux { lux: base, error: bound, .. } =
                self.integrated.get(cell).copied().unwrap_or_default();
            let means = std::array::from_fn(|r| base + (by_particles[r] + gathered[r]) / area);
            let ReplicateEstimate { value: lux, error, .. } = counts.estimate(&means);
            // Without replicates that differ there is no spread, nor infinity for a single one.
            let spread = if means == [means[0]; REPLICATES] { 0.0 } else { error };
            let uncounted = if is_uncounted { flux_of_one / area } else { 0.0 };
            let unlit =
                if is_unlit { self.gathered.map_or(0.0, GatheredFlux::illuminance_of_one) } else { 0.0 };
            let bound = if errors.integration { bound } else { 0.0 };
            let uncounted_limit = UNCOUNTED * uncounted;
            CellLux {
                area,
                means,
                lux,
                error: with_bound(spread + uncounted + unlit, bound),
                bound,
                uncounted_limit,
            }
        })
    }

    /// Mean over a receiver, and the bound of what is integrated, lx.
    fn mean(&self, cells: &[CellLux]) -> (ReplicateEstimate, f64) {
        let area: f64 = cells.iter().map(|cell| cell.area).sum();
        let over = |value: &dyn Fn(&CellLux) -> f64| {
            cells.iter().map(|cell| cell.area * value(cell)).sum::<f64>() / area
        };
        let means = std::array::from_fn(|replicate| over(&|cell| cell.means[replicate]));
        (self.counts().estimate(&means), over(&|cell| cell.bound))
    }

    /// Illuminance on every receiver, with standard errors from the spread of the replicates and the bounds of what is integrated.
    pub(crate) fn lux_maps(&self) -> Vec<LuxMap> {
        let counts = self.counts();
        let map = |(number, receiver): (usize, &Receiver)| {
            let cells: Vec<CellLux> = self.cells(number).collect();
            let lit = || cells.iter().filter(|cell| cell.area > 0.0);
            let means = || lit().map(|cell| &cell.means);
            let (mean, bound_of_mean) = self.mean(&cells);
            let bound = lit().fold(0.0, |largest: f64, cell| largest.max(cell.bound));
            let extremes = counts.smallest(means()).zip(counts.largest(means()));
            let extremes = extremes.map(|(mut minimum, maximum)| {
                // The least is at most that of the cell whose limit is lowest.
                let limits = lit().map(|cell| cell.uncounted_limit).filter(|limit| *limit > 0.0);
                let limit = limits.fold(f64::INFINITY, f64::min);
                if limit.is_finite() {
                    minimum.interval[1] += limit;
                }
                (minimum, maximum)
            });
            let statistics = extremes.map(|(minimum, maximum)| LuxStatistics {
                minimum: minimum.widened(bound),
                mean: mean.widened(bound_of_mean),
                maximum: maximum.widened(bound),
            });
            LuxMap { statistics, ..LuxMap::of(receiver, cells.iter().map(|cell| (cell.lux, cell.error))) }
        };
        self.receivers.as_slice().iter().enumerate().map(map).collect()
    }

    /// The largest relative error of the brightest cell, of the darkest cell and of the mean of any receiver that light comes to; infinity if it
    /// comes to none and none leaves the scene. That of the darkest cell is relative to a tenth of the mean at least: a cell in full shadow would never be known. Slivers of cells
    /// do not count.
    pub(crate) fn worst_error(&self) -> f64 {
        let mut worst = None;
        for number in 0..self.receivers.as_slice().len() {
            let cells: Vec<CellLux> = self.cells(number).filter(|cell| cell.area > 0.0).collect();
            let (mean, bound) = self.mean(&cells);
            let largest = cells.iter().fold(0.0, |largest: f64, cell| largest.max(cell.area));
            if cells.is_empty() || mean.value.is_nan() || mean.value <= 0.0 {
                continue;
            }
            let by_lux = |a: &&CellLux, b: &&CellLux| a.lux.total_cmp(&b.lux);
            let relative = |cell: Option<&CellLux>, least: f64| {
                cell.map_or(0.0, |cell| cell.error / cell.lux.max(least))
            };
            let whole = || cells.iter().filter(|cell| cell.area >= SMALLEST_SHARE * largest);
            let brightest = relative(whole().max_by(by_lux), 0.0);
            let darkest = relative(whole().min_by(by_lux), 0.1 * mean.value);
            let of_receiver = brightest.max(darkest).max(with_bound(mean.error, bound) / mean.value);
            worst = Some(f64::max(worst.unwrap_or(0.0), of_receiver));
        }
        worst.unwrap_or_else(|| self.peak_error())
    }

    /// The relative standard error of the peak of the light that leaves the scene; infinity if none does, or it is not counted.
    fn peak_error(&self) -> f64 {
        let summary = self.tally.far_field().and_then(|far| far.summary());
        summary.map_or(f64::INFINITY, |far| far.peak_error / far.peak)
    }
}
