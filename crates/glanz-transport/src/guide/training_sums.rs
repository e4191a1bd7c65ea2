//! Sums over the paths of a pass, from which the next guide is fitted.
//!
//! All sums are integers, so that they depend on the added records, not on the order or on threads (see
//! [`crate::exact`]). The quantum depends on the scene: 2^-20 of a typical luminance for light and 2^-24 of its square for squares.
//! Light divided by its density is clamped to 2^20 times the typical luminance, squares to the square of 2^12 times. A sum has room for
//! 2^24 and 2^16 terms of that size; because the typical luminance is about the mean, these would need 2^44 and 2^28 records. Clamped terms
//! are counted. Clamping can make a guide worse, but never a picture wrong.

use std::sync::atomic::{AtomicU64, Ordering};

use glanz_light::{Spectrum, Wavelengths};
use glanz_scene::MAX_LIGHT_GROUPS;

use super::directions::QuadtreeLeaf;
use super::mixture::{MixtureWeight, SHARES, density};
use super::record::{DirectionRecord, LightGroupRecord};

/// Largest number of quanta of one term of light, and of one of squares.
const LARGEST_LIGHT: f64 = (1_u64 << 40) as f64;
const LARGEST_SQUARE: f64 = (1_u64 << 48) as f64;
pub(crate) const LIGHT_QUANTA: f64 = (1_u64 << 20) as f64;
const MOMENT_QUANTA: f64 = (1_u64 << 24) as f64;

/// Words of a cell: number of records, sums of their light and of its square, then the second moment for each mixture weight; number of
/// light samples, then the second moment of each light group.
const CELL_WORDS: usize = LIGHT_WORDS + 1 + MAX_LIGHT_GROUPS;

/// Offset of the words of the light groups.
const LIGHT_WORDS: usize = 3 + SHARES;

/// Sums of the records of a cell, light and moments in quanta.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CellTrainingSums {
    /// Number of records.
    pub(crate) records: u64,
    /// Sums of the light of each record divided by its density, and of its square, in quanta of light.
    pub(crate) light: f64,
    pub(crate) squared_light: f64,
    /// Second moment for each mixture weight.
    pub(crate) moments: [u64; SHARES],
    /// Number of light samples.
    pub(crate) light_samples: u64,
    /// Sums of the squared luminance of the lights of a group, divided by the probability of the group.
    pub(crate) light_moments: [u64; MAX_LIGHT_GROUPS],
}

/// Sums of one pass.
#[derive(Debug)]
pub(crate) struct TrainingSums {
    /// [`CELL_WORDS`] for each cell.
    cells: Vec<AtomicU64>,
    /// Sum of the squared light divided by the density, for each leaf of the direction trees.
    leaves: Vec<AtomicU64>,
    /// Number of clamped terms.
    cut: AtomicU64,
}

fn zeros(count: usize) -> Vec<AtomicU64> {
    std::iter::repeat_with(AtomicU64::default).take(count).collect()
}

fn read(words: &[AtomicU64]) -> Vec<u64> {
    words.iter().map(|word| word.load(Ordering::Relaxed)).collect()
}

impl Clone for TrainingSums {
    fn clone(&self) -> Self {
        Self::from_words(&read(&self.cells), &read(&self.leaves), self.cut())
    }
}

impl PartialEq for TrainingSums {
    fn eq(&self, other: &Self) -> bool {
        self.to_words() == other.to_words() && self.cut() == other.cut()
    }
}

impl TrainingSums {
    /// Empty sums.
    pub(crate) fn new(cells: usize, leaves: usize) -> Self {
        Self { cells: zeros(cells * CELL_WORDS), leaves: zeros(leaves), cut: AtomicU64::new(0) }
    }

    fn from_words(cells: &[u64], leaves: &[u64], cut: u64) -> Self {
        let atomic = |words: &[u64]| words.iter().map(|&word| AtomicU64::new(word)).collect();
        Self { cells: atomic(cells), leaves: atomic(leaves), cut: AtomicU64::new(cut) }
    }

    /// The sums, those of cells first; [`TrainingSums::set_words`] restores them.
    pub(crate) fn to_words(&self) -> Vec<u64> {
        let mut words = read(&self.cells);
        words.extend(read(&self.leaves));
        words.push(self.cut());
        words
    }

    /// Number of words of [`TrainingSums::to_words`] with these numbers of cells and leaves.
    pub(crate) fn words_for(cells: usize, leaves: usize) -> usize {
        cells * CELL_WORDS + leaves + 1
    }

    /// Replaces all sums by the output of [`TrainingSums::to_words`].
    pub(crate) fn set_words(&mut self, mut words: impl Iterator<Item = u64>) {
        let mut next = || AtomicU64::new(words.next().unwrap_or_default());
        self.cells.iter_mut().chain(&mut self.leaves).for_each(|word| *word = next());
        self.cut = next();
    }

    /// Number of terms that were too large and clamped.
    pub(crate) fn cut(&self) -> u64 {
        self.cut.load(Ordering::Relaxed)
    }

    /// Adds a record; `all`: the light of the whole path. `typical`: a typical luminance, above 0.
    #[inline]
    pub(crate) fn add(
        &self,
        record: &DirectionRecord,
        all: Spectrum,
        wavelengths: &Wavelengths,
        typical: f64,
    ) {
        let words = CELL_WORDS * record.cell as usize;
        let Some([count, sum, squares, moments @ ..]) = self.cells.get(words..words + LIGHT_WORDS) else {
            return;
        };
        count.fetch_add(1, Ordering::Relaxed);
        let (arrived, went_on) = record.found(all, wavelengths);
        // Zero, negative or NaN.
        if !(arrived > 0.0 && record.pdf > 0.0) {
            return;
        }
        let light = arrived * record.cosine / record.pdf / typical;
        sum.fetch_add(self.quanta(light * LIGHT_QUANTA, LARGEST_LIGHT), Ordering::Relaxed);
        if let Some(leaf) = self.leaves.get(record.leaf as usize) {
            let square = light * light * record.pdf;
            leaf.fetch_add(self.quanta(square * MOMENT_QUANTA, LARGEST_SQUARE), Ordering::Relaxed);
        }
        squares.fetch_add(self.quanta(light * light * MOMENT_QUANTA, LARGEST_SQUARE), Ordering::Relaxed);
        // F / p is the continued luminance: F^2 / (p p_a) is its square times p / p_a.
        let relative = went_on / typical;
        let square = relative * relative * record.pdf * MOMENT_QUANTA;
        for (i, moment) in (0_u8..).zip(moments) {
            let mixed = density(MixtureWeight(i).probability(), record.guide_pdf, record.bsdf_pdf);
            if mixed > 0.0 {
                moment.fetch_add(self.quanta(square / mixed, LARGEST_SQUARE), Ordering::Relaxed);
            }
        }
    }

    /// Adds a light sample. `typical`: a typical luminance, above 0.
    #[inline]
    pub(crate) fn add_light(&self, record: &LightGroupRecord, typical: f64) {
        let words = CELL_WORDS * record.cell as usize + LIGHT_WORDS;
        let Some([count, moments @ ..]) = self.cells.get(words..words + 1 + MAX_LIGHT_GROUPS) else { return };
        count.fetch_add(1, Ordering::Relaxed);
        let relative = record.luminance / typical;
        let square = relative * relative / record.probability * MOMENT_QUANTA;
        if let Some(moment) = moments.get(record.group as usize).filter(|_| square > 0.0) {
            moment.fetch_add(self.quanta(square, LARGEST_SQUARE), Ordering::Relaxed);
        }
    }

    fn quanta(&self, term: f64, largest: f64) -> u64 {
        if term > largest {
            self.cut.fetch_add(1, Ordering::Relaxed);
        }
        // A cast from NaN gives 0.
        term.min(largest).round_ties_even() as u64
    }

    /// The best density of a leaf times its size, in any unit: the root of the integral of squared light times that size.
    ///
    /// Of all densities that are constant in each leaf, this one has the smallest second moment, the sum over all leaves of that integral
    /// divided by the density (@rath2020). For constant light in a leaf it is that light.
    pub(crate) fn weight(&self, leaf: QuadtreeLeaf) -> f64 {
        let square =
            self.leaves.get(leaf.number as usize).map_or(0.0, |word| word.load(Ordering::Relaxed) as f64);
        (square * leaf.area).sqrt()
    }

    /// Sums of the records of a cell.
    pub(crate) fn cell(&self, cell: u32) -> CellTrainingSums {
        let word = |i: usize| {
            self.cells.get(CELL_WORDS * cell as usize + i).map_or(0, |w| w.load(Ordering::Relaxed))
        };
        CellTrainingSums {
            records: word(0),
            light: word(1) as f64,
            squared_light: word(2) as f64 * (LIGHT_QUANTA * LIGHT_QUANTA / MOMENT_QUANTA),
            moments: std::array::from_fn(|i| word(i + 3)),
            light_samples: word(LIGHT_WORDS),
            light_moments: std::array::from_fn(|i| word(LIGHT_WORDS + 1 + i)),
        }
    }

    /// Records of all cells.
    pub(crate) fn records(&self) -> u64 {
        self.cells.iter().step_by(CELL_WORDS).map(|word| word.load(Ordering::Relaxed)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weight_is_the_root_of_mean_squared_light() {
        // Light of 3 and 1 alternately in leaf 0; of 2 in leaf 2 and in leaf 1, which has twice as many directions at twice the density.
        let even = 0.25 / std::f64::consts::PI;
        let sums = TrainingSums::new(1, 3);
        let add = |leaf, light: f32, pdf: f64| {
            let record = DirectionRecord {
                cell: 0,
                leaf,
                cosine: 0.5,
                guide_pdf: pdf,
                bsdf_pdf: pdf,
                pdf,
                light: Spectrum::BLACK,
                throughput: Spectrum::ONE,
                beyond: Spectrum::ONE,
                is_dispersed: false,
                next: None,
            };
            sums.add(&record, Spectrum::splat(light), &Wavelengths::default(), 1.0);
        };
        for i in 0..64 {
            add(0, if i % 2 == 0 { 3.0 } else { 1.0 }, even);
            add(1, 2.0, 2.0 * even);
            add(1, 2.0, 2.0 * even);
            add(2, 2.0, even);
        }
        let weight = |number, area| sums.weight(QuadtreeLeaf { number, share: 0.0, area });
        let even_light = weight(1, 0.25);
        assert!((weight(0, 0.25) / even_light - (5.0_f64 / 4.0).sqrt()).abs() < 1e-6);
        // The sums are integrals of squared light over a leaf, which are equal for leaves 1 and 2.
        assert!((weight(2, 0.125) / even_light - 0.5_f64.sqrt()).abs() < 1e-6);
        assert_eq!(sums.cut(), 0);
    }
}
