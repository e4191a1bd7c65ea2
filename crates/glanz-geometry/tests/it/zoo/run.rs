//! Shoots the rays at an animal on all processors and adds up the verdicts.

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use glanz_geometry::RaySurface;
use glanz_math::Ray;

use super::animal::Animal;
use super::rays::{Family, Random};
use super::reference::solve;
use super::verdict::{Fault, Verdict, judge};

/// Rays that a thread takes at once.
const SHARE: u64 = 500;

/// Failing rays that are told of each surface.
const TOLD: usize = 3;

/// What came of all rays of a surface.
#[derive(Default)]
pub struct Tally {
    pub rays: u64,
    pub roots: u64,
    pub groups: u64,
    pub faults: [u64; 6],
    pub position: f64,
    pub normal: f64,
    /// What the surface counted, in three queries per ray.
    pub undecided: u64,
    /// Rays without answer that the reference decides, and such that it does not.
    pub unanswered: u64,
    pub undecidable: u64,
    /// Seconds.
    library: f64,
    reference: f64,
    pub told: Vec<String>,
    /// Numbers of rays while which a search was undecided, in one thread or another.
    suspects: Vec<u64>,
}

pub const HEADER: &str = "surface                              rays     roots    groups missed doubled invented place normal \
     queries undecided  position    normal lib us ref us";

impl Tally {
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
        self.told.extend(other.told);
        self.suspects.extend(other.suspects);
        self.told.sort();
        self.told.truncate(TOLD);
    }

    fn note(&mut self, verdict: Verdict, tell: impl Fn() -> String) {
        self.roots += verdict.roots;
        self.groups += verdict.groups;
        self.position = self.position.max(verdict.position);
        self.normal = self.normal.max(verdict.normal);
        for (fault, what) in verdict.faults {
            self.faults[Fault::ALL.iter().position(|&f| f == fault).unwrap_or(0)] += 1;
            if self.told.len() < TOLD {
                self.told.push(format!("{fault:?}: {} {what}", tell()));
            }
        }
    }

    /// Faults of all kinds, and searches without answer.
    pub fn bad(&self) -> u64 {
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

/// Shoots `chords` random rays and `adversarial` others, the same every time.
pub fn shoot(animal: &Animal, chords: u64, adversarial: u64) -> Tally {
    let total = Mutex::new(Tally::default());
    let next = AtomicU64::new(0);
    let all = chords + adversarial;
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let before = animal.surface.undecided();
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                let mut own = Tally::default();
                loop {
                    let start = next.fetch_add(SHARE, Ordering::Relaxed);
                    if start >= all {
                        break;
                    }
                    for index in start..all.min(start + SHARE) {
                        shoot_one(animal, index, chords, &mut own);
                    }
                }
                if let Ok(mut total) = total.lock() {
                    total.add(own);
                }
            });
        }
    });
    let mut tally = total.into_inner().unwrap_or_default();
    tally.undecided = animal.surface.undecided() - before;
    // The count is one for all threads: which ray raised it is seen when it is shot alone.
    let mut suspects = std::mem::take(&mut tally.suspects);
    suspects.sort_unstable();
    for index in suspects {
        let (family, seed, ray) = ray(animal, index, chords);
        let undecided = animal.surface.undecided();
        animal.surface.all_hits(&ray, f64::INFINITY, &mut Vec::new());
        if animal.surface.undecided() > undecided {
            // A ray within the surface has no end of roots; that nothing can be decided there is no fault.
            let found = solve(&animal.patches, &ray, animal.thickness(&ray));
            tally.undecidable += u64::from(found.given_up > 0);
            tally.unanswered += u64::from(found.given_up == 0);
            let why = if found.given_up > 0 { ", by the reference neither" } else { "" };
            if tally.told.len() < 2 * TOLD {
                tally.told.push(format!("Undecided{why}: {family:?} {seed} {ray:?}"));
            }
        }
    }
    tally
}

/// The ray with this number, the same every time.
fn ray(animal: &Animal, index: u64, chords: u64) -> (Family, u64, Ray) {
    let (family, seed) = match index.checked_sub(chords) {
        None => (Family::Chord, index),
        // So that a hard ray keeps its seed, however many easy ones there are.
        Some(k) => (Family::ADVERSARIAL[(k % 10) as usize], k + (1 << 40)),
    };
    (family, seed, family.ray(animal, &mut Random::new(seed)))
}

fn shoot_one(animal: &Animal, index: u64, chords: u64, tally: &mut Tally) {
    let (family, seed, ray) = ray(animal, index, chords);
    let mut hits = Vec::new();
    let undecided = animal.surface.undecided();
    let start = Instant::now();
    animal.surface.all_hits(&ray, f64::INFINITY, &mut hits);
    let middle = Instant::now();
    let found = solve(&animal.patches, &ray, animal.thickness(&ray));
    tally.reference += middle.elapsed().as_secs_f64();
    tally.library += (middle - start).as_secs_f64();
    tally.rays += 1;
    let tell = || format!("{family:?} {seed} {ray:?}");
    if animal.surface.undecided() > undecided && tally.suspects.len() < 100 {
        tally.suspects.push(index);
    }
    tally.note(judge(animal, &ray, &hits, &found), tell);
}
