//! Exact sums of the flux that particles carry to receivers.

use std::ops::Range;

use glanz_light::units::photometric;
use glanz_light::{Spectrum, Wavelengths};
use glanz_sampling::exact::{SquareSum, WideSum};
use glanz_transport::{Arrival, ParticleFate, ParticlePath, ParticleRanges};

use crate::balance::FluxBalance;
use crate::far_field::{FarField, FarFieldGrid};
use crate::lux_map::LuxMap;
use crate::receiver::{ReceiverHit, Receivers};

/// Sum and sum of squares of the contributions of single particles, lm.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct TallySums {
    pub(crate) sum: WideSum,
    pub(crate) squares: SquareSum,
}

impl TallySums {
    /// The sums of a single contribution.
    fn of(lumens: f64) -> Self {
        // The value is rounded once for both sums: the square is that of the rounded value.
        let lumens = lumens as f32;
        Self { sum: WideSum::of(f64::from(lumens)), squares: SquareSum::of_square(lumens) }
    }

    #[inline]
    fn merge(&mut self, other: &Self) {
        self.sum.merge(other.sum);
        self.squares.merge(other.squares);
    }

    /// Mean over `particles` particles, most of which may contribute nothing, and its standard error.
    pub(crate) fn mean(&self, particles: u64) -> (f64, f64) {
        if particles == 0 {
            return (0.0, 0.0);
        }
        let n = particles as f64;
        let mean = self.sum.to_f64() / n;
        let variance = (self.squares.to_f64() / n - mean * mean).max(0.0);
        (mean, (variance / (n - 1.0).max(1.0)).sqrt())
    }
}

/// Sums of the flux that particles carried to the receivers of a scene, and the balance of the rest.
///
/// Sums are exact: they depend on the traced particles, not on order or threads. The contributions of a particle that hits a cell several
/// times count as one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Tally {
    pub(crate) particles: ParticleRanges,
    pub(crate) cells: Vec<TallySums>,
    /// Sums over all cells of each receiver.
    pub(crate) receivers: Vec<TallySums>,
    /// Light on the excluded sides of the receivers.
    pub(crate) other_sides: Vec<WideSum>,
    pub(crate) emitted: WideSum,
    pub(crate) absorbed_by_receivers: WideSum,
    pub(crate) absorbed_elsewhere: WideSum,
    pub(crate) escaped: WideSum,
    pub(crate) given_up: WideSum,
    pub(crate) far_field: Option<FarFieldSums>,
}

/// Escaped light by direction.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct FarFieldSums {
    pub(crate) grid: FarFieldGrid,
    pub(crate) bins: Vec<TallySums>,
}

impl Tally {
    /// A tally without particles. `far_field`: the grid by which escaped light is counted by direction, if requested.
    #[must_use]
    pub fn new(receivers: &Receivers, far_field: Option<FarFieldGrid>) -> Self {
        let zero = WideSum::default();
        let count = receivers.as_slice().len();
        Self {
            particles: ParticleRanges::default(),
            cells: vec![TallySums::default(); receivers.cell_count()],
            receivers: vec![TallySums::default(); count],
            other_sides: vec![zero; count],
            emitted: zero,
            absorbed_by_receivers: zero,
            absorbed_elsewhere: zero,
            escaped: zero,
            given_up: zero,
            far_field: far_field
                .map(|grid| FarFieldSums { bins: vec![TallySums::default(); grid.bins()], grid }),
        }
    }

    /// The traced particles.
    #[must_use]
    pub fn particles(&self) -> &ParticleRanges {
        &self.particles
    }

    /// Whether it counts the light of these receivers and directions.
    #[must_use]
    pub fn fits(&self, receivers: &Receivers, far_field: Option<FarFieldGrid>) -> bool {
        self.shape() == (receivers.as_slice().len(), receivers.cell_count(), far_field)
    }

    /// Whether two tallies have the same numbers of receivers and cells, and the same directions.
    #[must_use]
    pub fn has_shape_of(&self, other: &Self) -> bool {
        self.shape() == other.shape()
    }

    /// Numbers of receivers and cells, and the directions.
    fn shape(&self) -> (usize, usize, Option<FarFieldGrid>) {
        (self.receivers.len(), self.cells.len(), self.far_field.as_ref().map(|sums| sums.grid))
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
        self.add_sums(other);
        Ok(())
    }

    /// Adds the sums of a tally for the same receivers.
    pub(crate) fn add_sums(&mut self, other: &Self) {
        let pairs = [(&mut self.cells, &other.cells), (&mut self.receivers, &other.receivers)];
        for (mine, theirs) in pairs {
            mine.iter_mut().zip(theirs).for_each(|(a, b)| a.merge(b));
        }
        self.other_sides.iter_mut().zip(&other.other_sides).for_each(|(a, b)| a.merge(*b));
        self.emitted.merge(other.emitted);
        self.absorbed_by_receivers.merge(other.absorbed_by_receivers);
        self.absorbed_elsewhere.merge(other.absorbed_elsewhere);
        self.escaped.merge(other.escaped);
        self.given_up.merge(other.given_up);
        if let (Some(mine), Some(theirs)) = (&mut self.far_field, &other.far_field) {
            mine.bins.iter_mut().zip(&theirs.bins).for_each(|(a, b)| a.merge(b));
        }
    }

    /// Mean emitted flux and where it ended, lm.
    #[must_use]
    pub fn balance(&self) -> FluxBalance {
        let mean = |sum| self.mean(sum);
        FluxBalance {
            emitted: mean(self.emitted),
            absorbed_by_receivers: mean(self.absorbed_by_receivers),
            absorbed_elsewhere: mean(self.absorbed_elsewhere),
            escaped: mean(self.escaped),
            given_up: mean(self.given_up),
        }
    }

    /// Flux that a receiver receives, and its standard error, lm.
    #[must_use]
    pub fn received(&self, receiver: usize) -> (f64, f64) {
        self.receivers.get(receiver).map_or((0.0, 0.0), |sums| sums.mean(self.particles.total()))
    }

    /// Flux on the side of a receiver that is not counted, lm.
    #[must_use]
    pub fn on_other_side(&self, receiver: usize) -> f64 {
        let sum = self.other_sides.get(receiver).copied().unwrap_or_default();
        self.mean(sum)
    }

    /// Mean over all particles.
    fn mean(&self, sum: WideSum) -> f64 {
        if self.particles.is_empty() { 0.0 } else { sum.to_f64() / self.particles.total() as f64 }
    }

    /// Illuminance on every receiver.
    ///
    /// Errors are the standard errors of the same number of independent particles. The particles come from a sequence that distributes them better, so
    /// that the actual errors are smaller. The error of a cell without particles is that of a cell with a single one.
    #[must_use]
    pub fn lux_maps(&self, receivers: &Receivers) -> Vec<LuxMap> {
        let particles = self.particles.total();
        let one = self.balance().emitted / particles.max(1) as f64;
        let map = |(number, receiver): (usize, &crate::receiver::Receiver)| {
            let sums = self.cells.get(receivers.cells_of(number)).unwrap_or_default();
            let value = |(sums, &area): (&TallySums, &f64)| {
                if area <= 0.0 {
                    return (0.0, 0.0);
                }
                let (lumens, error) = sums.mean(particles);
                (lumens / area, if lumens > 0.0 { error } else { one } / area)
            };
            let (lux, errors) = sums.iter().zip(receiver.areas()).map(value).unzip();
            LuxMap {
                name: receiver.name().to_owned(),
                cells: receiver.cells(),
                size: receiver.size().to_array(),
                positions: receiver.positions().to_vec(),
                areas: receiver.areas().to_vec(),
                lux,
                errors,
            }
        };
        receivers.as_slice().iter().enumerate().map(map).collect()
    }

    /// Intensities of the escaped light, if it was counted by direction.
    #[must_use]
    pub fn far_field(&self) -> Option<FarField> {
        let (far_field, particles) = (self.far_field.as_ref()?, self.particles.total());
        let value = |(bin, sums): (usize, &TallySums)| {
            let (lumens, error) = sums.mean(particles);
            let solid_angle = far_field.grid.solid_angle(bin);
            (lumens / solid_angle, error / solid_angle)
        };
        let (candela, errors) = far_field.bins.iter().enumerate().map(value).unzip();
        Some(FarField { grid: far_field.grid, candela, errors })
    }
}

/// Light that a particle carried to a cell.
#[derive(Clone, Copy, Debug)]
struct Contribution {
    /// Number among the particles on their way.
    particle: u32,
    receiver: u32,
    cell: usize,
    lumens: f64,
}

/// The sums of one contribution. Many particles bring the same light, so that the sums of the last one are kept.
#[derive(Default)]
struct TallyTerm {
    lumens: f64,
    sums: TallySums,
}

impl TallyTerm {
    /// The sums of contributions that count as one.
    #[inline]
    fn of(&mut self, same: &[Contribution]) -> &TallySums {
        let lumens = match same {
            [one] => one.lumens,
            _ => same.iter().map(|one| one.lumens).sum(),
        };
        if lumens != self.lumens {
            *self = Self { lumens, sums: TallySums::of(lumens) };
        }
        &self.sums
    }
}

/// Adds particles, several of which are on their way, to the sums of a tally.
pub(crate) struct ThreadTally<'a> {
    receivers: &'a Receivers,
    wavelengths: Wavelengths,
    tally: Tally,
    /// Contributions of the particles on their way, in the order of the arrivals.
    contributions: Vec<Contribution>,
}

impl<'a> ThreadTally<'a> {
    pub(crate) fn new(receivers: &'a Receivers, far_field: Option<FarFieldGrid>) -> Self {
        let (wavelengths, tally) = (Wavelengths::default(), Tally::new(receivers, far_field));
        Self { receivers, wavelengths, tally, contributions: Vec::new() }
    }

    /// The sums; the tally does not know of which particles.
    pub(crate) fn into_tally(self) -> Tally {
        self.tally
    }

    fn lumens(&self, flux: Spectrum) -> f64 {
        photometric(flux, &self.wavelengths)
    }

    /// Adds the hit of a particle, by its number among those on their way, on a surface.
    pub(crate) fn arrival(&mut self, particle: usize, arrival: &Arrival) {
        let arrived = self.lumens(arrival.arrived);
        let absorbed = arrived - self.lumens(arrival.left);
        let Some(ReceiverHit { receiver, cell, counts }) = self.receivers.met(&arrival.at) else {
            self.tally.absorbed_elsewhere.add(absorbed);
            return;
        };
        self.tally.absorbed_by_receivers.add(absorbed);
        if counts {
            let (particle, receiver) = (particle as u32, receiver as u32);
            self.contributions.push(Contribution { particle, receiver, cell, lumens: arrived });
        } else if let Some(sum) = self.tally.other_sides.get_mut(receiver) {
            sum.add(arrived);
        }
    }

    /// Ends all particles on their way, given by their paths; `None` for those that were not emitted.
    pub(crate) fn end(&mut self, paths: impl Iterator<Item = Option<ParticlePath>>) {
        paths.flatten().for_each(|path| self.add_path(&path));
        self.settle();
    }

    /// Adds the flux of a path to the balance.
    fn add_path(&mut self, path: &ParticlePath) {
        let emitted = self.lumens(path.emitted);
        self.tally.emitted.add(emitted);
        if !path.faded.is_black() {
            let faded = self.lumens(path.faded);
            self.tally.given_up.add(faded);
        }
        match path.end {
            ParticleFate::Absorbed => {}
            ParticleFate::Escaped { ray, power } => {
                let lumens = self.lumens(power);
                self.tally.escaped.add(lumens);
                if let Some(far_field) = &mut self.tally.far_field
                    && let Some(sums) = far_field.bins.get_mut(far_field.grid.bin(ray.direction))
                {
                    sums.merge(&TallySums::of(lumens));
                }
            }
            ParticleFate::GivenUp(power) => {
                let lumens = self.lumens(power);
                self.tally.given_up.add(lumens);
            }
        }
    }

    /// Adds the contributions of all particles, cell by cell and receiver by receiver: those of one particle to the same cell, or receiver,
    /// count as one.
    fn settle(&mut self) {
        let Self { tally, contributions, .. } = self;
        // Stable, so that the sums do not depend on the other particles. Particles that arrived once are sorted already.
        contributions.sort_by_key(|one| (one.particle, one.cell));
        // Short loops, so that the processor waits for the memory of several cells at a time.
        let mut term = TallyTerm::default();
        for same in contributions.chunk_by(|a, b| a.particle == b.particle && a.cell == b.cell) {
            tally.cells[same[0].cell].merge(term.of(same));
        }
        // Cells of one receiver are consecutive.
        for same in contributions.chunk_by(|a, b| a.particle == b.particle && a.receiver == b.receiver) {
            tally.receivers[same[0].receiver as usize].merge(term.of(same));
        }
        contributions.clear();
    }
}
