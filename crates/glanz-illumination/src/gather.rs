//! Light on cells, gathered by paths that start there.

use std::ops::Range;
use std::sync::{Mutex, PoisonError};

use glanz_light::Wavelengths;
use glanz_light::units::photometric;
use glanz_math::DVec2;
use glanz_sampling::hash::{combine, unit_f64};
use glanz_sampling::{PixelSampler, SamplerKind};
use glanz_scene::{Interaction, PlacedSurface, Scene};
use glanz_transport::codec::{Decoder, Encoder};
use glanz_transport::{Counters, IrradianceTracer};
use rayon::prelude::*;

use crate::division::CellDivision;
use crate::integrate::position_error;
use crate::receiver::{Receiver, Receivers};
use crate::replicates::REPLICATES;

/// Distinguishes the numbers of paths from those of particles of the same seed.
const KEY: u64 = 0x6761_7468;

/// Points that are drawn in a flat cell until one is on the surface.
const ATTEMPTS: u64 = 1 << 10;

/// Paths that a thread traces together, at least as many as a cell has.
const PATHS: usize = 1 << 11;

/// Flux on cells, estimated by paths from points of the cells. Replicate r of a cell has points and directions of its own from a scrambled Sobol'
/// sequence.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct GatheredFlux {
    /// Paths of each replicate of each cell.
    samples: u32,
    /// Sums over the paths of a cell's replicates, lm.
    sums: Vec<[f64; REPLICATES]>,
    /// Largest illuminance by a single path, lx.
    largest: f64,
}

/// The cells of receivers, and the division of their light.
pub(crate) struct CellPaths<'a> {
    scene: &'a Scene,
    division: CellDivision<'a>,
    /// Each cell with area: its receiver and surface, and its number there and among all.
    cells: Vec<(&'a Receiver, PlacedSurface<'a>, usize, usize)>,
    seed: u64,
    max_events: u32,
}

impl<'a> CellPaths<'a> {
    /// `max_events`: largest number of surfaces that light reaches on its way.
    pub(crate) fn new(
        scene: &'a Scene,
        receivers: &'a Receivers,
        division: CellDivision<'a>,
        seed: u64,
        max_events: u32,
    ) -> Self {
        let placed = scene.placed_surfaces();
        let mut cells = Vec::new();
        for (number, receiver) in receivers.as_slice().iter().enumerate() {
            let Some(surface) = placed.get(receiver.surface() as usize) else { continue };
            let numbers = receivers.cells_of(number).enumerate();
            let with_area =
                numbers.filter(|(cell, _)| receiver.areas()[*cell] > 0.0 && receiver.has_places(*cell));
            cells.extend(with_area.map(|(cell, among_all)| (receiver, surface.clone(), cell, among_all)));
        }
        Self { scene, division, cells, seed: combine(seed, KEY), max_events }
    }

    /// Number of cells with area.
    pub(crate) fn len(&self) -> usize {
        self.cells.len()
    }

    /// A point of a cell where a path starts, and the area that it stands for; `None` where there is no surface.
    ///
    /// Of a flat cell that the surface fills in part, points are drawn until one is on it.
    fn start(
        &self,
        (receiver, surface, cell, among_all): &(&Receiver, PlacedSurface<'_>, usize, usize),
        sampler: &PixelSampler,
    ) -> Option<(Interaction, f64)> {
        let even = receiver.even_area(*cell);
        let key = combine(self.seed, (*among_all as u64) << 32 | u64::from(sampler.sample_index()));
        let drawn = |attempt: u64| [0, 1].map(|axis| unit_f64(combine(key, 2 * attempt + axis)));
        let further = (0..even.map_or(0, |_| ATTEMPTS)).map(|attempt| DVec2::from_array(drawn(attempt)));
        let places = std::iter::once(sampler.pixel_2d()).chain(further);
        let point = places.into_iter().find_map(|at| receiver.place(surface, *cell, at))?;
        let error = position_error(self.scene, point.position);
        let area = even.unwrap_or(point.area_element);
        Some((Interaction::on_surface(point.position, error, point.normal), area))
    }

    /// Sums of the flux of paths `first` to `end` of all replicates of cells, lm, and the largest illuminance by a single path, lx.
    fn trace(
        &self,
        tracer: &mut IrradianceTracer<'a>,
        numbers: Range<usize>,
        [first, end]: [u32; 2],
    ) -> (Vec<(usize, [f64; REPLICATES])>, f64) {
        let cells = self.cells.get(numbers).unwrap_or_default();
        let mut sums: Vec<_> = cells.iter().map(|cell| (cell.3, [0.0; REPLICATES])).collect();
        let mut largest = 0.0_f64;
        let together = (PATHS / REPLICATES).max(1) as u32;
        for first in (first..end).step_by(together as usize) {
            let end = end.min(first.saturating_add(together));
            largest = largest.max(self.trace_together(tracer, cells, [first, end], &mut sums));
        }
        (sums, largest)
    }

    /// Adds paths to the sums of cells; returns the largest illuminance by one of them.
    fn trace_together(
        &self,
        tracer: &mut IrradianceTracer<'a>,
        cells: &[(&Receiver, PlacedSurface<'_>, usize, usize)],
        [first, end]: [u32; 2],
        sums: &mut [(usize, [f64; REPLICATES])],
    ) -> f64 {
        let mut owners = Vec::with_capacity(PATHS);
        let slots = cells.iter().enumerate();
        let replicates = slots.flat_map(|slot| (0..REPLICATES).map(move |replicate| (slot, replicate)));
        let paths = replicates.flat_map(|slot| (first..end).map(move |index| (slot, index)));
        let starts = paths.filter_map(|(((slot, cell), replicate), index)| {
            let scramble = [cell.3 as u32, replicate as u32];
            let sampler = PixelSampler::new(SamplerKind::Sobol, 1, self.seed, scramble, index);
            let (at, area) = self.start(cell, &sampler)?;
            owners.push((slot, replicate, area));
            Some((at, sampler, self.division.known(cell.3)))
        });
        let (irradiance, wavelengths) = (tracer.trace(starts), Wavelengths::default());
        let mut largest = 0.0_f64;
        for ((slot, replicate, area), &light) in owners.into_iter().zip(irradiance) {
            let lux = photometric(light, &wavelengths);
            sums[slot].1[replicate] += area * lux;
            largest = largest.max(lux);
        }
        largest
    }
}

impl GatheredFlux {
    /// Without paths.
    pub(crate) fn new(cells: usize) -> Self {
        Self { samples: 0, sums: vec![[0.0; REPLICATES]; cells], largest: 0.0 }
    }

    /// Paths of each replicate of each cell.
    pub(crate) fn samples(&self) -> u32 {
        self.samples
    }

    /// Number of cells.
    pub(crate) fn len(&self) -> usize {
        self.sums.len()
    }

    /// Illuminance of a cell that one of its paths finds, at most, lx; 0 without paths.
    pub(crate) fn illuminance_of_one(&self) -> f64 {
        self.largest / (REPLICATES as f64 * f64::from(self.samples.max(1)))
    }

    /// Mean flux by the paths of each replicate of a cell, lm.
    pub(crate) fn means(&self, cell: usize) -> [f64; REPLICATES] {
        let sums = self.sums.get(cell).copied().unwrap_or([0.0; REPLICATES]);
        sums.map(|sum| sum / f64::from(self.samples.max(1)))
    }

    /// Traces `count` more paths for each replicate of each cell, with all threads of `pool`. `between` is called now and then with the share of
    /// the cells that are done, [0, 1]; if it returns `false`, nothing changes. Returns the number of rays.
    ///
    /// Each sum is that of the cell's paths in their order: its bits do not depend on threads.
    pub(crate) fn add(
        &mut self,
        pool: &rayon::ThreadPool,
        paths: &CellPaths<'_>,
        count: u32,
        mut between: impl FnMut(f64) -> bool,
    ) -> Option<Counters> {
        let range = [self.samples, self.samples.checked_add(count)?];
        let together = (PATHS / (REPLICATES * count.max(1) as usize)).max(1);
        let starts: Vec<usize> = (0..paths.len()).step_by(together).collect();
        let (mut found, mut counters) = (Vec::with_capacity(paths.len()), Counters::default());
        let mut largest = self.largest;
        let portion = 16 * pool.current_num_threads();
        // Tracers that wait for cells, with their memory.
        let tracers = Mutex::new(Vec::new());
        let waiting = || tracers.lock().unwrap_or_else(PoisonError::into_inner);
        for portion in starts.chunks(portion) {
            if !between(found.len() as f64 / paths.len() as f64) {
                return None;
            }
            let trace = |&start: &usize| {
                let idle = waiting().pop();
                let mut tracer = idle.unwrap_or_else(|| IrradianceTracer::new(paths.scene, paths.max_events));
                let found = paths.trace(&mut tracer, start..(start + together).min(paths.len()), range);
                waiting().push(tracer);
                found
            };
            let traced: Vec<_> = pool.install(|| portion.par_iter().map(trace).collect());
            for (sums, brightest) in traced {
                found.extend(sums);
                largest = largest.max(brightest);
            }
        }
        waiting().iter().for_each(|tracer| counters.merge(tracer.counters));
        for (cell, sums) in found {
            if let Some(all) = self.sums.get_mut(cell) {
                all.iter_mut().zip(sums).for_each(|(all, sum)| *all += sum);
            }
        }
        (self.samples, self.largest) = (range[1], largest);
        Some(counters)
    }

    /// Appends the number of paths, the largest illuminance by one, the number of cells, and their sums.
    pub(crate) fn encode(&self, encoder: &mut Encoder) {
        encoder.u32(self.samples);
        encoder.f64(self.largest);
        encoder.u64(self.sums.len() as u64);
        self.sums.iter().flatten().for_each(|sum| encoder.u64(sum.to_bits()));
    }

    /// Reads the output of [`GatheredFlux::encode`]; `None` if malformed.
    pub(crate) fn decode(decoder: &mut Decoder<'_>) -> Option<Self> {
        let (samples, largest) = (decoder.u32()?, f64::from_bits(decoder.u64()?));
        let count = usize::try_from(decoder.u64()?).ok()?;
        if decoder.0.len() / (8 * REPLICATES) < count {
            return None;
        }
        let mut sums = vec![[0.0; REPLICATES]; count];
        for sum in sums.iter_mut().flatten() {
            *sum = f64::from_bits(decoder.u64()?);
        }
        Some(Self { samples, sums, largest })
    }
}
