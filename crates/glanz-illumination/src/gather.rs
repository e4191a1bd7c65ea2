//! Light on cells, gathered by paths that start there.

use glanz_light::units::photometric;
use glanz_light::{Spectrum, Wavelengths};
use glanz_math::DVec2;
use glanz_sampling::hash::combine;
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
            let with_area = numbers.filter(|(cell, _)| receiver.areas()[*cell] > 0.0);
            cells.extend(with_area.map(|(cell, among_all)| (receiver, surface.clone(), cell, among_all)));
        }
        Self { scene, division, cells, seed: combine(seed, KEY), max_events }
    }

    /// Number of cells with area.
    pub(crate) fn len(&self) -> usize {
        self.cells.len()
    }

    /// A point of a cell where a path starts, and the area per unit of the cell's square; `None` where there is no surface.
    fn start(
        &self,
        (receiver, surface, cell, _): &(&Receiver, PlacedSurface<'_>, usize, usize),
        at: DVec2,
    ) -> Option<(Interaction, f64)> {
        let point = receiver.place(surface, *cell, at)?;
        let error = position_error(self.scene, point.position);
        Some((Interaction::on_surface(point.position, error, point.normal), point.area_element))
    }

    /// Sums of the flux of paths `first` to `end` of all replicates of a cell, lm.
    fn trace(
        &self,
        tracer: &mut IrradianceTracer<'a>,
        numbers: std::ops::Range<usize>,
        [first, end]: [u32; 2],
    ) -> Vec<(usize, [f64; REPLICATES])> {
        let cells = self.cells.get(numbers).unwrap_or_default();
        let (mut starts, mut owners) = (Vec::new(), Vec::new());
        for (slot, cell) in cells.iter().enumerate() {
            for replicate in 0..REPLICATES {
                for index in first..end {
                    let scramble = [cell.3 as u32, replicate as u32];
                    let sampler = PixelSampler::new(SamplerKind::Sobol, 1, self.seed, scramble, index);
                    if let Some((at, area)) = self.start(cell, sampler.pixel_2d()) {
                        starts.push((at, sampler, self.division.known(cell.3)));
                        owners.push((slot, replicate, area));
                    }
                }
            }
        }
        let (mut irradiance, wavelengths): (Vec<Spectrum>, _) = (Vec::new(), Wavelengths::default());
        tracer.trace(starts.into_iter(), &mut irradiance);
        let mut sums: Vec<_> = cells.iter().map(|cell| (cell.3, [0.0; REPLICATES])).collect();
        for ((slot, replicate, area), light) in owners.into_iter().zip(irradiance) {
            sums[slot].1[replicate] += area * photometric(light, &wavelengths);
        }
        sums
    }
}

impl GatheredFlux {
    /// Without paths.
    pub(crate) fn new(cells: usize) -> Self {
        Self { samples: 0, sums: vec![[0.0; REPLICATES]; cells] }
    }

    /// Paths of each replicate of each cell.
    pub(crate) fn samples(&self) -> u32 {
        self.samples
    }

    /// Number of cells.
    pub(crate) fn len(&self) -> usize {
        self.sums.len()
    }

    /// Mean flux by the paths of each replicate of a cell, lm.
    pub(crate) fn means(&self, cell: usize) -> [f64; REPLICATES] {
        let sums = self.sums.get(cell).copied().unwrap_or([0.0; REPLICATES]);
        sums.map(|sum| sum / f64::from(self.samples.max(1)))
    }

    /// Traces `count` more paths for each replicate of each cell, with all threads of the pool. `between` is called now and then with the share of
    /// the cells that are done, [0, 1]; if it returns `false`, nothing changes. Returns the number of rays.
    ///
    /// Each sum is that of the cell's paths in their order: its bits do not depend on threads.
    pub(crate) fn add(
        &mut self,
        paths: &CellPaths<'_>,
        count: u32,
        mut between: impl FnMut(f64) -> bool,
    ) -> Option<Counters> {
        let range = [self.samples, self.samples.checked_add(count)?];
        let together = (PATHS / (REPLICATES * count.max(1) as usize)).max(1);
        let starts: Vec<usize> = (0..paths.len()).step_by(together).collect();
        let (mut found, mut counters) = (Vec::with_capacity(paths.len()), Counters::default());
        let portion = 16 * rayon::current_num_threads();
        for portion in starts.chunks(portion) {
            if !between(found.len() as f64 / paths.len() as f64) {
                return None;
            }
            let trace = |&start: &usize| {
                let mut tracer = IrradianceTracer::new(paths.scene, paths.max_events);
                let sums = paths.trace(&mut tracer, start..(start + together).min(paths.len()), range);
                (sums, tracer.counters)
            };
            for (sums, rays) in portion.par_iter().map(trace).collect::<Vec<_>>() {
                found.extend(sums);
                counters.merge(rays);
            }
        }
        for (cell, sums) in found {
            if let Some(all) = self.sums.get_mut(cell) {
                all.iter_mut().zip(sums).for_each(|(all, sum)| *all += sum);
            }
        }
        self.samples = range[1];
        Some(counters)
    }

    /// Appends the number of paths, the number of cells, and their sums.
    pub(crate) fn encode(&self, encoder: &mut Encoder) {
        encoder.u32(self.samples);
        encoder.u64(self.sums.len() as u64);
        self.sums.iter().flatten().for_each(|sum| encoder.u64(sum.to_bits()));
    }

    /// Reads the output of [`GatheredFlux::encode`]; `None` if malformed.
    pub(crate) fn decode(decoder: &mut Decoder<'_>) -> Option<Self> {
        let (samples, count) = (decoder.u32()?, usize::try_from(decoder.u64()?).ok()?);
        if decoder.0.len() / (8 * REPLICATES) < count {
            return None;
        }
        let mut sums = vec![[0.0; REPLICATES]; count];
        for sum in sums.iter_mut().flatten() {
            *sum = f64::from_bits(decoder.u64()?);
        }
        Some(Self { samples, sums })
    }
}
