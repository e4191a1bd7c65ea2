//! Random rays: roots that each method finds, misses and invents.

use std::time::Duration;

use glanz_geometry::{Hit, RaySurface};
use glanz_math::Ray;
use glanz_sampling::hash::{combine, unit_f64};

use super::iteration::{NewtonOutcome, StoppingCriteria, damped, general, simplified};
use super::patches::{PatchGroup, RayPatchSystem, Shape, Target};
use crate::clock::{Stopwatch, TimeScope};
use crate::study::{Settings, StudyError, StudyProgress};

/// Residual below which document 000 accepts a point as a root; absolute there, relative to the size of the patch here.
pub(super) const RESIDUAL: f64 = 1e-10;

/// Largest number of steps of an iteration; document 000 allows [`STEPS_OF_000`].
pub(super) const STEPS: u32 = 50;

/// Largest number of steps in document 000.
pub(super) const STEPS_OF_000: u32 = 10;

/// Largest distance along the ray, relative to the patch, between the end of an iteration and its root. Where a ray touches the
/// surface, a residual of [`RESIDUAL`] determines the root only to its square root.
const SAME_ROOT: f64 = 2e-5;

/// Distance from the domain that is attributed to rounding, in parameters.
const BORDER: f64 = 1e-9;

/// Rays between two checks of the cancel flag.
const BATCH: usize = 1 << 14;

/// The variants of Newton's method.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Variant {
    General,
    Simplified,
    Damped,
}

impl Variant {
    pub(super) const ALL: [Self; 3] = [Self::General, Self::Simplified, Self::Damped];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::General => "general Newton",
            Self::Simplified => "simplified Newton",
            Self::Damped => "damped Newton",
        }
    }

    /// Iterates from `start` (u, v, ray parameter) towards an intersection of patch and ray.
    pub(super) fn run(
        self,
        shape: &Shape,
        ray: &Ray,
        start: [f64; 3],
        limits: StoppingCriteria,
    ) -> NewtonOutcome<3> {
        let meeting = RayPatchSystem { shape, ray: *ray };
        match self {
            Self::General => general(&meeting, start, limits),
            Self::Simplified => simplified(&meeting, start, limits),
            Self::Damped => damped(&meeting, start, limits),
        }
    }
}

/// Counts of one variant over the rays of a group.
#[derive(Clone, Debug, Default)]
pub(super) struct VariantTally {
    /// Rays through the hull, for which an iteration was started.
    pub(super) started: u64,
    /// Iterations that ended within the residual.
    pub(super) converged: u64,
    /// Certified roots at which an iteration ended.
    pub(super) found: u64,
    /// Of these, the first root of their ray.
    pub(super) first: u64,
    /// Ends within the residual, which document 000 accepts as hits, outside of the domain or behind the ray's origin.
    pub(super) outside: u64,
    /// Ends within the residual and the domain without a certified root.
    pub(super) unknown: u64,
    /// Iterations without next step.
    pub(super) singular: u64,
    /// Steps of converged iterations, summed.
    pub(super) steps: u64,
    /// Most steps of a converged iteration.
    pub(super) most_steps: u32,
    /// Evaluations of the patch, summed over all iterations.
    pub(super) evaluations: u64,
    /// Processor time.
    pub(super) time: Duration,
    /// Roots found, by number of steps.
    pub(super) found_after: Vec<u64>,
}

/// Counts of the certified search over the rays of a group.
#[derive(Clone, Debug, Default)]
pub(super) struct CertifiedTally {
    pub(super) rays: u64,
    /// Rays that meet their patch.
    pub(super) hit: u64,
    pub(super) roots: u64,
    /// Largest distance between patch and ray at a root, relative to the patch.
    pub(super) worst: f64,
    /// Undecided leaves.
    pub(super) undecided: u64,
    /// Time for all roots, and for the first one.
    pub(super) all: Duration,
    pub(super) closest: Duration,
}

/// The rays of a group and their roots.
pub(super) struct RaySet<'a> {
    group: &'a PatchGroup,
    rays: Vec<Ray>,
    hits: Vec<Hit>,
    /// Where the roots of each ray start; one more than there are rays.
    starts: Vec<usize>,
    pub(super) truth: CertifiedTally,
}

impl<'a> RaySet<'a> {
    /// Generates `count` rays at the patches of the group in turn, and finds all their roots.
    pub(super) fn shoot(
        group: &'a PatchGroup,
        number: u64,
        count: u64,
        settings: &Settings,
    ) -> Result<Self, StudyError> {
        let key = combine(settings.seed, number);
        let rays: Vec<Ray> =
            group.targets.iter().cycle().zip(0..count).map(|(t, i)| random(t, key, i)).collect();
        let mut shots = Self {
            group,
            rays,
            hits: Vec::new(),
            starts: vec![0],
            truth: CertifiedTally { rays: count, ..CertifiedTally::default() },
        };
        let watch = Stopwatch::start(TimeScope::Thread);
        for (i, (ray, target)) in shots.rays.iter().zip(group.targets.iter().cycle()).enumerate() {
            pause(i, settings)?;
            target.search.all_hits(ray, f64::INFINITY, &mut shots.hits);
            shots.starts.push(shots.hits.len());
        }
        shots.truth.all = watch.elapsed();
        let watch = Stopwatch::start(TimeScope::Thread);
        let mut met = 0;
        for (i, (ray, target)) in shots.rays.iter().zip(group.targets.iter().cycle()).enumerate() {
            pause(i, settings)?;
            met += u64::from(target.search.intersect(ray, f64::INFINITY).is_some());
        }
        shots.truth.closest = watch.elapsed();
        shots.truth.hit = met;
        shots.truth.roots = shots.hits.len() as u64;
        shots.truth.undecided = group.targets.iter().map(|t| t.search.undecided()).sum();
        shots.truth.worst = shots.worst();
        Ok(shots)
    }

    fn each(&self) -> impl Iterator<Item = (&Ray, &'a Target, &[Hit])> {
        let roots = self.starts.windows(2).filter_map(|w| self.hits.get(w[0]..w[1]));
        let targets = self.group.targets.iter().cycle();
        self.rays.iter().zip(targets).zip(roots).map(|((ray, target), roots)| (ray, target, roots))
    }

    fn worst(&self) -> f64 {
        let off = |(ray, target, roots): (&Ray, &Target, &[Hit])| {
            let distance = |hit: &Hit| target.search.point(ray, hit).position.distance(ray.at(hit.t));
            roots.iter().map(distance).fold(0.0, f64::max) / target.size()
        };
        self.each().map(off).fold(0.0, f64::max)
    }

    /// Runs `variant` on the rays.
    pub(super) fn tally(&self, variant: Variant, settings: &Settings) -> Result<VariantTally, StudyError> {
        let mut outcomes = Vec::with_capacity(self.rays.len());
        let watch = Stopwatch::start(TimeScope::Thread);
        for (i, (ray, target, _)) in self.each().enumerate() {
            pause(i, settings)?;
            let limits = StoppingCriteria { residual: RESIDUAL * target.size(), iterations: STEPS };
            outcomes.push(target.start(ray).map(|start| variant.run(&target.shape, ray, start, limits)));
        }
        let time = watch.elapsed();
        let mut tally =
            VariantTally { time, found_after: vec![0; STEPS as usize + 1], ..VariantTally::default() };
        for ((_, target, roots), outcome) in self.each().zip(&outcomes) {
            if let Some(outcome) = outcome {
                tally.add(target, roots, outcome);
            }
        }
        Ok(tally)
    }
}

impl VariantTally {
    fn add(&mut self, target: &Target, roots: &[Hit], outcome: &NewtonOutcome<3>) {
        self.started += 1;
        self.evaluations += u64::from(outcome.iterate().evaluations);
        self.singular += u64::from(matches!(outcome, NewtonOutcome::Singular(_)));
        let Some(end) = outcome.converged() else { return };
        self.converged += 1;
        self.steps += u64::from(end.iterations);
        self.most_steps = self.most_steps.max(end.iterations);
        let [u, v, t] = end.x;
        let outside = target.shape.outside(u, v);
        let root = roots.iter().position(|hit| (hit.t - t).abs() <= SAME_ROOT * target.size());
        match root {
            Some(position) if outside <= BORDER.max(SAME_ROOT) => {
                self.found += 1;
                self.first += u64::from(position == 0);
                if let Some(count) = self.found_after.get_mut(end.iterations as usize) {
                    *count += 1;
                }
            }
            _ if outside > BORDER || t <= 0.0 => self.outside += 1,
            _ => self.unknown += 1,
        }
    }

    /// Adds the counts of `other`.
    pub(super) fn merge(&mut self, other: &Self) {
        self.started += other.started;
        self.converged += other.converged;
        self.found += other.found;
        self.first += other.first;
        self.outside += other.outside;
        self.unknown += other.unknown;
        self.singular += other.singular;
        self.steps += other.steps;
        self.most_steps = self.most_steps.max(other.most_steps);
        self.evaluations += other.evaluations;
        self.time += other.time;
        self.found_after.resize(self.found_after.len().max(other.found_after.len()), 0);
        for (sum, count) in self.found_after.iter_mut().zip(&other.found_after) {
            *sum += count;
        }
    }
}

impl CertifiedTally {
    /// Adds what was counted elsewhere.
    pub(super) fn merge(&mut self, other: &Self) {
        self.rays += other.rays;
        self.hit += other.hit;
        self.roots += other.roots;
        self.worst = self.worst.max(other.worst);
        self.undecided += other.undecided;
        self.all += other.all;
        self.closest += other.closest;
    }
}

/// The ray with this index; it depends on `key` and `index` only.
fn random(target: &Target, key: u64, index: u64) -> Ray {
    let of_ray = combine(key, index);
    target.ray(std::array::from_fn(|i| unit_f64(combine(of_ray, i as u64))))
}

fn pause(index: usize, settings: &Settings) -> Result<(), StudyError> {
    if index.is_multiple_of(BATCH) {
        settings.cancel.check()?;
    }
    Ok(())
}

/// Counts of the certified search and of the variants for all groups.
pub(super) struct Comparison {
    pub(super) groups: Vec<(&'static str, CertifiedTally, [VariantTally; 3])>,
    pub(super) truth: CertifiedTally,
    pub(super) tallies: [VariantTally; 3],
}

/// Compares the methods on `rays` rays in equal parts at the groups; progress goes from `from` to 1.
pub(super) fn compare(
    groups: &[PatchGroup],
    rays: u64,
    from: f64,
    settings: &Settings,
    progress: &mut StudyProgress<'_>,
) -> Result<Comparison, StudyError> {
    let mut all =
        Comparison { groups: Vec::new(), truth: CertifiedTally::default(), tallies: Default::default() };
    let parts = (groups.len() * (Variant::ALL.len() + 1)) as f64;
    let mut done = 0.0;
    let mut report_progress = |what: &str| {
        progress.report(from + (1.0 - from) * done / parts, what);
        done += 1.0;
    };
    for (number, group) in groups.iter().enumerate() {
        let (number, count) = (number as u64, groups.len() as u64);
        let share = rays / count + u64::from(number < rays % count);
        report_progress(&format!("{}, certified search", group.name));
        let shots = RaySet::shoot(group, number, share, settings)?;
        let mut tallies: [VariantTally; 3] = Default::default();
        for (slot, variant) in tallies.iter_mut().zip(Variant::ALL) {
            report_progress(&format!("{}, {}", group.name, variant.name()));
            *slot = shots.tally(variant, settings)?;
        }
        all.truth.merge(&shots.truth);
        for (sum, tally) in all.tallies.iter_mut().zip(&tallies) {
            sum.merge(tally);
        }
        all.groups.push((group.name, shots.truth, tallies));
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::newton::patches::groups;
    use crate::study::StudyProgress;
    use glanz_job::Silent;

    #[test]
    fn what_newton_finds_inside_is_known_to_the_certified_search() {
        let settings = Settings::default();
        let all = compare(&groups().unwrap(), 30_000, 0.0, &settings, &mut StudyProgress::new(&mut Silent))
            .unwrap();
        let CertifiedTally { rays, hit, roots, worst, undecided, .. } = all.truth;
        assert_eq!((rays, undecided), (30_000, 0));
        assert!(hit > 3_000 && roots >= hit && worst < 1e-9, "{hit} {roots} {worst}");
        for tally in &all.tallies {
            assert_eq!(tally.unknown, 0);
            assert_eq!(tally.converged, tally.found + tally.outside + tally.unknown);
            assert_eq!(tally.found_after.iter().sum::<u64>(), tally.found);
            assert!(tally.first <= tally.found && tally.found <= hit && tally.started >= hit);
        }
        // One start finds one root at most, and not always that.
        let [general, simplified, _] = &all.tallies;
        assert!(general.found > hit / 2 && general.found < roots && general.outside > 0);
        // Linear convergence takes more steps than quadratic.
        let mean = |t: &VariantTally| t.steps as f64 / t.converged as f64;
        assert!(mean(simplified) > 1.5 * mean(general));
    }

    #[test]
    fn figures_depend_on_the_seed_alone() {
        let run = |seed| {
            let settings = Settings { seed, ..Settings::default() };
            let all = compare(&groups().unwrap(), 900, 0.0, &settings, &mut StudyProgress::new(&mut Silent))
                .unwrap();
            all.tallies.map(|t| (t.started, t.found, t.outside, t.evaluations, t.found_after))
        };
        assert_eq!(run(1), run(1));
        assert_ne!(run(1), run(2));
    }
}
