//! Traces the rays of a surface on all processors and adds up the comparisons.

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use glanz_geometry::RaySurface;
use glanz_math::Ray;

use super::comparison::{HitFault, RayComparison, compare};
use super::rays::{Random, RayFamily};
use super::reference::solve;
use super::test_surface::TestSurface;

/// Number of rays of one task of a thread.
const RAYS_PER_TASK: u64 = 500;

/// Largest number of messages about failing rays per surface.
const MAX_MESSAGES: usize = 3;

/// Results of all rays of a surface.
#[derive(Default)]
pub struct ZooTally {
    pub rays: u64,
    pub roots: u64,
    pub groups: u64,
    pub faults: [u64; 6],
    pub position: f64,
    pub normal: f64,
    /// Undecided searches that the surface counted, in three queries per ray.
    pub undecided: u64,
    /// Undecided rays that the reference decides.
    pub unanswered: u64,
    /// Undecided rays that the reference does not decide either.
    pub undecidable: u64,
    /// Time of the library, seconds.
    library: f64,
    /// Time of the reference, seconds.
    reference: f64,
    pub messages: Vec<String>,
    /// Indices of rays during which a search was undecided, in this thread or another.
    suspects: Vec<u64>,
}

pub const HEADER: &str = "surface                              rays     roots    groups missed doubled invented place normal \
     queries undecided  position    normal lib us ref us";

impl ZooTally {
    fn add(&mut self, other: Self) {
        self.rays += other.rays;
        self.roots += other.roots;
        self.groups += other.groups;
        for (sum, count) in self.faults.iter_mut().zip(other.faults) {
            *sum += count;
        }
        self.position = self.position.max(other.position);
        self.normal = self.normal.max(other.normal);
        self.library += other.library;
        self.reference += other.reference;
        self.messages.extend(other.messages);
        self.suspects.extend(other.suspects);
        self.messages.sort();
        self.messages.truncate(MAX_MESSAGES);
    }

    fn note(&mut self, comparison: RayComparison, describe: impl Fn() -> String) {
        self.roots += comparison.roots;
        self.groups += comparison.groups;
        self.position = self.position.max(comparison.position);
        self.normal = self.normal.max(comparison.normal);
        for (fault, what) in comparison.faults {
            self.faults[HitFault::ALL.iter().position(|&f| f == fault).unwrap_or(0)] += 1;
            if self.messages.len() < MAX_MESSAGES {
                self.messages.push(format!("{fault:?}: {} {what}", describe()));
            }
        }
    }

    /// Number of faults of all kinds and of undecided searches that the reference decides.
    pub fn failures(&self) -> u64 {
        self.faults.iter().sum::<u64>() + self.unanswered
    }

    pub fn row(&self, name: &str) -> String {
        let [missed, doubled, invented, place, normal, queries] = self.faults;
        let per_ray = |seconds: f64| 1e6 * seconds / self.rays as f64;
        format!(
            "{name:34}{:9}{:10}{:10}{missed:7}{doubled:8}{invented:9}{place:6}{normal:7}{queries:8}{:10}{:10.1e}{:10.1e}{:7.2}{:7.1}",
            self.rays,
            self.roots,
            self.groups,
            self.undecided,
            self.position,
            self.normal,
            per_ray(self.library),
            per_ray(self.reference)
        )
    }
}

/// Traces `chords` random rays and `adversarial` others, the same in every run.
pub fn trace(tested: &TestSurface, chords: u64, adversarial: u64) -> ZooTally {
    let total = Mutex::new(ZooTally::default());
    let next = AtomicU64::new(0);
    let all = chords + adversarial;
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let before = tested.surface.undecided();
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                let mut own = ZooTally::default();
                loop {
                    let start = next.fetch_add(RAYS_PER_TASK, Ordering::Relaxed);
                    if start >= all {
                        break;
                    }
                    for index in start..all.min(start + RAYS_PER_TASK) {
                        trace_one(tested, index, chords, &mut own);
                    }
                }
                if let Ok(mut total) = total.lock() {
                    total.add(own);
                }
            });
        }
    });
    let mut tally = total.into_inner().unwrap_or_default();
    tally.undecided = tested.surface.undecided() - before;
    // The count is shared by all threads: each suspect is traced again alone.
    let mut suspects = std::mem::take(&mut tally.suspects);
    suspects.sort_unstable();
    for index in suspects {
        let (family, seed, ray) = ray(tested, index, chords);
        let undecided = tested.surface.undecided();
        tested.surface.all_hits(&ray, f64::INFINITY, &mut Vec::new());
        if tested.surface.undecided() > undecided {
            // A ray within the surface has infinitely many roots: an undecided search is not a fault there.
            let found = solve(&tested.patches, &ray, tested.thickness(&ray));
            tally.undecidable += u64::from(found.given_up > 0);
            tally.unanswered += u64::from(found.given_up == 0);
            let why = if found.given_up > 0 { ", also by the reference" } else { "" };
            if tally.messages.len() < 2 * MAX_MESSAGES {
                tally.messages.push(format!("Undecided{why}: {family:?} {seed} {ray:?}"));
            }
        }
    }
    tally
}

/// The ray with this index, the same in every run.
fn ray(tested: &TestSurface, index: u64, chords: u64) -> (RayFamily, u64, Ray) {
    let (family, seed) = match index.checked_sub(chords) {
        None => (RayFamily::Chord, index),
        // The seed of an adversarial ray must not depend on the number of chords.
        Some(k) => (RayFamily::ADVERSARIAL[(k % 10) as usize], k + (1 << 40)),
    };
    (family, seed, family.ray(tested, &mut Random::new(seed)))
}

fn trace_one(tested: &TestSurface, index: u64, chords: u64, tally: &mut ZooTally) {
    let (family, seed, ray) = ray(tested, index, chords);
    let mut hits = Vec::new();
    let undecided = tested.surface.undecided();
    let start = Instant::now();
    tested.surface.all_hits(&ray, f64::INFINITY, &mut hits);
    let middle = Instant::now();
    let found = solve(&tested.patches, &ray, tested.thickness(&ray));
    tally.reference += middle.elapsed().as_secs_f64();
    tally.library += (middle - start).as_secs_f64();
    tally.rays += 1;
    let describe = || format!("{family:?} {seed} {ray:?}");
    if tested.surface.undecided() > undecided && tally.suspects.len() < 100 {
        tally.suspects.push(index);
    }
    tally.note(compare(tested, &ray, &hits, &found), describe);
}
