//! Sums of incident light per basis function of each density.
//!
//! Sums are integers in units of a small fraction of a typical luminance, as those of the tree, so that they depend on
//! the added records alone. Light is not divided by a density: a term is the incident luminance times the cosine.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};

use glanz_light::{Spectrum, Wavelengths};

use crate::guide::record::incident;

/// Units of light in a typical luminance.
const QUANTA: f64 = (1_u64 << 20) as f64;

/// Largest number of units of one term: a sum has room for 2^24 terms of that size.
const LARGEST: f64 = (1_u64 << 40) as f64;

/// A direction sampled from a density.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GridRecord {
    /// The cell of the density.
    pub(crate) cell: u32,
    /// The function from which it was sampled.
    pub(crate) function: u32,
    /// |cos| between direction and shading normal.
    pub(crate) cosine: f64,
    /// Light of the path before this vertex.
    pub(crate) light: Spectrum,
    /// Throughput beyond the vertex.
    pub(crate) beyond: Spectrum,
    /// Whether the hero alone is left in the throughput.
    pub(crate) is_dispersed: bool,
    /// Part of the light after this vertex that is excluded from training; `None`: all of it.
    pub(crate) left_out: Option<Spectrum>,
}

impl GridRecord {
    /// The incident luminance along the direction for training; `all`: the light of the whole path.
    ///
    /// A surface that scatters no red gives no information on incident red, which counts as zero.
    fn arrived(&self, all: Spectrum, wavelengths: &Wavelengths) -> f64 {
        let Some(left_out) = self.left_out else { return 0.0 };
        let found = all - self.light - left_out;
        incident(found, self.beyond, self.is_dispersed).luminance(wavelengths).into()
    }
}

/// Number and light of the directions of each function, function after function.
type CellWords = Box<[[AtomicU64; 2]]>;

/// Sums of all cells.
#[derive(Debug)]
pub(crate) struct GridSums {
    functions: usize,
    /// Empty for cells without paths.
    cells: Vec<OnceLock<CellWords>>,
}

impl Clone for GridSums {
    fn clone(&self) -> Self {
        self.rescaled(1.0)
    }
}

impl PartialEq for GridSums {
    fn eq(&self, other: &Self) -> bool {
        self.functions == other.functions
            && self.cells.len() == other.cells.len()
            && (0..self.cells.len() as u32).all(|cell| self.cell(cell) == other.cell(cell))
    }
}

impl GridSums {
    /// Empty sums.
    pub(crate) fn new(cells: usize, functions: usize) -> Self {
        Self { functions, cells: std::iter::repeat_with(OnceLock::new).take(cells).collect() }
    }

    /// Adds a record; `all`: the light of the whole path. `typical`: a typical luminance, above 0.
    pub(crate) fn add(&self, record: &GridRecord, all: Spectrum, wavelengths: &Wavelengths, typical: f64) {
        let Some(cell) = self.cells.get(record.cell as usize) else { return };
        let blank = || std::iter::repeat_with(Default::default).take(self.functions).collect();
        let Some([count, light]) = cell.get_or_init(blank).get(record.function as usize) else { return };
        count.fetch_add(1, Ordering::Relaxed);
        let term = record.arrived(all, wavelengths) * record.cosine / typical * QUANTA;
        // Negative values and NaN are not added.
        if term > 0.0 {
            light.fetch_add(term.min(LARGEST).round_ties_even() as u64, Ordering::Relaxed);
        }
    }

    /// Number and light, in units, of the directions of each function of a cell; `None` for a cell without paths.
    pub(crate) fn cell(&self, cell: u32) -> Option<Vec<(u64, u64)>> {
        let words = self.cells.get(cell as usize)?.get()?;
        Some(words.iter().map(|pair| (load(&pair[0]), load(&pair[1]))).collect())
    }

    /// Replaces the sums of a cell by the output of [`GridSums::cell`].
    pub(super) fn set_cell(&mut self, cell: u32, words: impl Iterator<Item = (u64, u64)>) {
        if let Some(slot) = self.cells.get_mut(cell as usize) {
            *slot = OnceLock::from(words.map(|(n, l)| [n, l].map(AtomicU64::new)).collect::<CellWords>());
        }
    }

    /// The same light in units larger by the factor `growth`, a power of two.
    pub(super) fn rescaled(&self, growth: f64) -> Self {
        let mut new = Self::new(self.cells.len(), self.functions);
        let scaled = |light: u64| match growth {
            1.0 => light,
            _ => (light as f64 / growth).round_ties_even() as u64,
        };
        for cell in 0..self.cells.len() as u32 {
            if let Some(words) = self.cell(cell) {
                new.set_cell(cell, words.into_iter().map(|(n, light)| (n, scaled(light))));
            }
        }
        new
    }

    /// Number of recorded directions.
    pub(crate) fn records(&self) -> u64 {
        let cells = self.cells.iter().filter_map(OnceLock::get);
        cells.flat_map(|words| words.iter()).map(|pair| load(&pair[0])).sum()
    }

    /// Number of cells, and of functions per cell.
    pub(super) fn shape(&self) -> (usize, usize) {
        (self.cells.len(), self.functions)
    }
}

fn load(word: &AtomicU64) -> u64 {
    word.load(Ordering::Relaxed)
}

#[cfg(test)]
mod tests {
    use glanz_light::SampledWavelengths;

    use super::*;

    fn record(function: u32, left_out: Option<Spectrum>) -> GridRecord {
        // The path had light 1 before; its throughput beyond the vertex is 1/8.
        GridRecord {
            cell: 1,
            function,
            cosine: 0.5,
            light: Spectrum::ONE,
            beyond: Spectrum::splat(0.125),
            is_dispersed: false,
            left_out,
        }
    }

    #[test]
    fn light_that_arrives_times_its_cosine_is_added() {
        let (sums, wavelengths) = (GridSums::new(2, 3), Wavelengths::default());
        let quanta = |light: f64| (light / 2.0 * QUANTA).round() as u64;
        let near = |found: u64, light: f64| (found as f64 / quanta(light) as f64 - 1.0).abs() < 1e-5;
        // Light of 0.75 beyond the vertex: the incident light is 6; times the cosine, 1/2, it is 3.
        sums.add(&record(2, Some(Spectrum::BLACK)), Spectrum::splat(1.75), &wavelengths, 2.0);
        // 0.25 of it, or all, came directly from a light.
        sums.add(&record(1, Some(Spectrum::splat(0.25))), Spectrum::splat(1.75), &wavelengths, 2.0);
        sums.add(&record(0, None), Spectrum::splat(1.75), &wavelengths, 2.0);
        let cell = sums.cell(1).unwrap();
        assert_eq!([cell[0], (cell[1].0, 0), (cell[2].0, 0)], [(1, 0); 3]);
        assert!(near(cell[2].1, 3.0) && near(cell[1].1, 2.0), "{cell:?}");
        assert_eq!((sums.cell(0), sums.records()), (None, 3));
    }

    #[test]
    fn hero_of_a_dispersed_path_stands_for_all_wavelengths() {
        let hero = |x: f32| Spectrum::splat(x).hero_alone();
        let record = GridRecord {
            light: Spectrum::BLACK,
            beyond: hero(0.125),
            is_dispersed: true,
            ..record(0, Some(Spectrum::BLACK))
        };
        let arrived = |i: u32| {
            let sampled = SampledWavelengths::sample((f64::from(i) + 0.5) / 256.0);
            record.arrived(hero(0.75), &Wavelengths::Sampled(sampled)) / 256.0
        };
        // Radiance 6 at all wavelengths has luminance 6.
        let mean: f64 = (0..256).map(arrived).sum();
        assert!((mean - 6.0).abs() < 0.01, "{mean}");
    }

    #[test]
    fn invalid_light_counts_as_zero_and_extremes_are_clamped() {
        let (sums, wavelengths) = (GridSums::new(2, 1), Wavelengths::default());
        for light in [f32::NAN, -5.0, 1.0] {
            sums.add(&record(0, Some(Spectrum::BLACK)), Spectrum::splat(light), &wavelengths, 1.0);
        }
        assert_eq!(sums.cell(1), Some(vec![(3, 0)]));
        sums.add(&record(0, Some(Spectrum::BLACK)), Spectrum::splat(1e30), &wavelengths, 1.0);
        assert_eq!(sums.cell(1), Some(vec![(4, 1 << 40)]));
        // Neither the cell nor the function exists.
        let outside = GridRecord { cell: 9, ..record(0, None) };
        sums.add(&outside, Spectrum::ONE, &wavelengths, 1.0);
        sums.add(&record(7, None), Spectrum::ONE, &wavelengths, 1.0);
        assert_eq!(sums.records(), 4);
    }

    #[test]
    fn larger_units_give_smaller_numbers() {
        let mut sums = GridSums::new(1, 2);
        sums.set_cell(0, [(3, 1000), (1, 6)].into_iter());
        assert_eq!(sums.rescaled(4.0).cell(0), Some(vec![(3, 250), (1, 2)]));
        assert_eq!(sums.rescaled(0.5).cell(0), Some(vec![(3, 2000), (1, 12)]));
        assert_eq!(sums.clone(), sums);
        assert_ne!(sums.rescaled(2.0), sums);
    }
}
