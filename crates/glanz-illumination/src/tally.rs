//! Exact sums of the flux that particles carry to receivers.

use std::ops::Range;

use glanz_light::units::photometric;
use glanz_light::{Spectrum, Wavelengths};
use glanz_sampling::exact::WideSum;
use glanz_transport::{Arrival, ParticleFate, ParticlePath, ParticleRanges};

use crate::balance::FluxBalance;
use crate::division::CellDivision;
use crate::far_field::{FarField, FarFieldGrid};
use crate::lux_map::LuxMap;
use crate::lux_parts::LuxParts;
use crate::receiver::{ReceiverHit, Receivers};
use crate::replicates::{REPLICATES, ReplicateCounts, ReplicateEstimate};

/// Exact sums of the flux of one replicate's particles.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct FluxSums {
    pub(crate) cells: Vec<WideSum>,
    /// Light on the excluded sides of the receivers.
    pub(crate) other_sides: Vec<WideSum>,
    pub(crate) emitted: WideSum,
    pub(crate) absorbed_by_receivers: WideSum,
    pub(crate) absorbed_elsewhere: WideSum,
    pub(crate) escaped: WideSum,
    pub(crate) given_up: WideSum,
    /// Escaped light by direction; empty if it is not counted.
    pub(crate) bins: Vec<WideSum>,
}

impl FluxSums {
    fn new(cells: usize, receivers: usize, bins: usize) -> Self {
        let zero = WideSum::default();
        Self {
            cells: vec![zero; cells],
            other_sides: vec![zero; receivers],
            emitted: zero,
            absorbed_by_receivers: zero,
            absorbed_elsewhere: zero,
            escaped: zero,
            given_up: zero,
            bins: vec![zero; bins],
        }
    }

    fn merge(&mut self, other: &Self) {
        let lists = [
            (&mut self.cells, &other.cells),
            (&mut self.other_sides, &other.other_sides),
            (&mut self.bins, &other.bins),
        ];
        for (mine, theirs) in lists {
            mine.iter_mut().zip(theirs).for_each(|(a, b)| a.merge(*b));
        }
        self.emitted.merge(other.emitted);
        self.absorbed_by_receivers.merge(other.absorbed_by_receivers);
        self.absorbed_elsewhere.merge(other.absorbed_elsewhere);
        self.escaped.merge(other.escaped);
        self.given_up.merge(other.given_up);
    }
}

/// Sums of the flux that particles carried to the receivers of a scene, and the balance of the rest.
///
/// Sums are exact: they depend on the traced particles, not on order or threads. Each of 16 replicates of the particles has its own.
#[derive(Clone, Debug, PartialEq)]
pub struct Tally {
    pub(crate) particles: ParticleRanges,
    pub(crate) far_field: Option<FarFieldGrid>,
    /// As many as [`REPLICATES`], of the same shape.
    pub(crate) replicates: Vec<FluxSums>,
}

impl Tally {
    /// A tally without particles. `far_field`: the grid by which escaped light is counted by direction, if requested.
    #[must_use]
    pub fn new(receivers: &Receivers, far_field: Option<FarFieldGrid>) -> Self {
        let bins = far_field.as_ref().map_or(0, FarFieldGrid::bins);
        let sums = FluxSums::new(receivers.cell_count(), receivers.as_slice().len(), bins);
        Self { particles: ParticleRanges::default(), far_field, replicates: vec![sums; REPLICATES] }
    }

    /// The traced particles.
    #[must_use]
    pub fn particles(&self) -> &ParticleRanges {
        &self.particles
    }

    /// Whether it counts the light of these receivers, and escaped light by direction if `far_field`.
    #[must_use]
    pub fn fits(&self, receivers: &Receivers, far_field: bool) -> bool {
        let (count, cells, grid) = self.shape();
        (count, cells, grid.is_some()) == (receivers.as_slice().len(), receivers.cell_count(), far_field)
    }

    /// Whether two tallies have the same numbers of receivers and cells, and the same directions.
    #[must_use]
    pub fn has_shape_of(&self, other: &Self) -> bool {
        self.shape() == other.shape()
    }

    /// Numbers of receivers and cells, and the directions.
    fn shape(&self) -> (usize, usize, Option<&FarFieldGrid>) {
        let [receivers, cells] =
            self.replicates.first().map_or([0; 2], |sums| [sums.other_sides.len(), sums.cells.len()]);
        (receivers, cells, self.far_field.as_ref())
    }

    /// Adds a tally of other particles for the same receivers; the sums have the bits of one tally of all particles.
    ///
    /// # Errors
    /// The first particles that both have; this tally is then unchanged.
    pub fn merge(&mut self, other: &Self) -> Result<(), Range<u64>> {
        if let Some(shared) = self.particles.overlap(&other.particles) {
            return Err(shared);
        }
        other.particles.as_slice().iter().try_for_each(|range| self.particles.try_insert(range.clone()))?;
        self.replicates.iter_mut().zip(&other.replicates).for_each(|(mine, theirs)| mine.merge(theirs));
        Ok(())
    }

    /// Adds the sums of a replicate for the same receivers; the particles are to be inserted.
    pub(crate) fn add_sums(&mut self, replicate: usize, sums: &FluxSums) {
        if let Some(mine) = self.replicates.get_mut(replicate) {
            mine.merge(sums);
        }
    }

    /// Mean emitted flux and where it ended, lm.
    #[must_use]
    pub fn balance(&self) -> FluxBalance {
        FluxBalance {
            emitted: self.mean(|sums| sums.emitted),
            absorbed_by_receivers: self.mean(|sums| sums.absorbed_by_receivers),
            absorbed_elsewhere: self.mean(|sums| sums.absorbed_elsewhere),
            escaped: self.mean(|sums| sums.escaped),
            given_up: self.mean(|sums| sums.given_up),
        }
    }

    /// Flux that a receiver of `receivers` receives, lm.
    #[must_use]
    pub fn received(&self, receivers: &Receivers, receiver: usize) -> ReplicateEstimate {
        let cells = receivers.cells_of(receiver);
        let counts = ReplicateCounts::of(&self.particles);
        let sum = |replicate: usize| {
            let mut sum = WideSum::default();
            self.replicates[replicate]
                .cells
                .get(cells.clone())
                .unwrap_or_default()
                .iter()
                .for_each(|cell| sum.merge(*cell));
            sum.to_f64()
        };
        counts.estimate(&counts.means(sum))
    }

    /// Flux on the side of a receiver that is not counted, lm.
    #[must_use]
    pub fn on_other_side(&self, receiver: usize) -> f64 {
        self.mean(|sums| sums.other_sides.get(receiver).copied().unwrap_or_default())
    }

    /// Mean over all particles.
    fn mean(&self, sum: impl Fn(&FluxSums) -> WideSum) -> f64 {
        let mut all = WideSum::default();
        self.replicates.iter().for_each(|sums| all.merge(sum(sums)));
        if self.particles.is_empty() { 0.0 } else { all.to_f64() / self.particles.total() as f64 }
    }

    /// Illuminance on every receiver, with standard errors from the spread of the replicates.
    ///
    /// The error of a cell without particles is that of a cell with a single one.
    #[must_use]
    pub fn lux_maps(&self, receivers: &Receivers) -> Vec<LuxMap> {
        LuxParts::of_particles(self, receivers).lux_maps()
    }

    /// Sum of the particles of a replicate in a cell, lm.
    pub(crate) fn cell_sum(&self, replicate: usize, cell: usize) -> f64 {
        let sums = self.replicates.get(replicate);
        sums.and_then(|sums| sums.cells.get(cell)).map_or(0.0, |sum| sum.to_f64())
    }

    /// Whether any cell has light.
    pub(crate) fn has_light_in_cells(&self) -> bool {
        self.replicates.iter().flat_map(|sums| &sums.cells).any(|sum| *sum != WideSum::default())
    }

    /// Flux of a single particle among all, on average, lm.
    pub(crate) fn flux_of_one(&self) -> f64 {
        self.balance().emitted / self.particles.total().max(1) as f64
    }

    /// Intensities of the escaped light, if it was counted by direction.
    #[must_use]
    pub fn far_field(&self) -> Option<FarField> {
        let (grid, counts) = (self.far_field.as_ref()?, ReplicateCounts::of(&self.particles));
        let one = self.flux_of_one();
        let value = |bin: usize| {
            let sum = |replicate: usize| self.replicates[replicate].bins[bin].to_f64();
            let ReplicateEstimate { value, error, .. } = counts.estimate(&counts.means(sum));
            let solid_angle = grid.solid_angle(bin);
            (value / solid_angle, if value > 0.0 { error } else { one } / solid_angle)
        };
        let (means, errors): (Vec<f64>, _) = (0..grid.bins()).map(value).unzip();
        Some(FarField { grid: grid.clone(), candela: grid.centred(&means), errors })
    }
}

/// Adds particles, several of which are on their way, to the sums of a replicate.
pub(crate) struct ThreadTally<'a> {
    receivers: &'a Receivers,
    far_field: Option<&'a FarFieldGrid>,
    /// What other methods compute of the light in the cells.
    division: Option<CellDivision<'a>>,
    wavelengths: Wavelengths,
    sums: FluxSums,
}

impl<'a> ThreadTally<'a> {
    pub(crate) fn new(
        receivers: &'a Receivers,
        far_field: Option<&'a FarFieldGrid>,
        division: Option<CellDivision<'a>>,
    ) -> Self {
        let bins = far_field.map_or(0, FarFieldGrid::bins);
        let sums = FluxSums::new(receivers.cell_count(), receivers.as_slice().len(), bins);
        Self { receivers, far_field, division, wavelengths: Wavelengths::default(), sums }
    }

    /// The sums so far; they begin anew.
    pub(crate) fn take(&mut self) -> FluxSums {
        let Self { sums: FluxSums { cells, other_sides, bins, .. }, .. } = self;
        let empty = FluxSums::new(cells.len(), other_sides.len(), bins.len());
        std::mem::replace(&mut self.sums, empty)
    }

    fn lumens(&self, flux: Spectrum) -> f64 {
        photometric(flux, &self.wavelengths)
    }

    /// Adds the hit of a particle on a surface.
    pub(crate) fn arrival(&mut self, arrival: &Arrival) {
        let arrived = self.lumens(arrival.arrived);
        let absorbed = arrived - self.lumens(arrival.left);
        let sums = &mut self.sums;
        let Some(ReceiverHit { receiver, cell, counts }) = self.receivers.met(&arrival.at) else {
            sums.absorbed_elsewhere.add(absorbed);
            return;
        };
        sums.absorbed_by_receivers.add(absorbed);
        if counts && self.division.is_some_and(|division| !division.is_by_particles(arrival, cell)) {
            return;
        }
        let sum = if counts { sums.cells.get_mut(cell) } else { sums.other_sides.get_mut(receiver) };
        if let Some(sum) = sum {
            sum.add(arrived);
        }
    }

    /// Adds the flux of a path to the balance.
    pub(crate) fn end(&mut self, path: &ParticlePath) {
        let emitted = self.lumens(path.emitted);
        self.sums.emitted.add(emitted);
        if !path.faded.is_black() {
            let faded = self.lumens(path.faded);
            self.sums.given_up.add(faded);
        }
        match path.end {
            ParticleFate::Absorbed => {}
            ParticleFate::Escaped { ray, power } => {
                let lumens = self.lumens(power);
                self.sums.escaped.add(lumens);
                let weights = self.far_field.iter().flat_map(|grid| grid.weights(ray.direction));
                for (bin, weight) in weights.filter(|(_, weight)| *weight > 0.0) {
                    if let Some(sum) = self.sums.bins.get_mut(bin) {
                        sum.add(lumens * weight);
                    }
                }
            }
            ParticleFate::GivenUp(power) => {
                let lumens = self.lumens(power);
                self.sums.given_up.add(lumens);
            }
        }
    }
}
