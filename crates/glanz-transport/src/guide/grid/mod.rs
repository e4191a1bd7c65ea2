//! The guide of document 003: a fixed grid of cells on each surface, each with a density over the hemisphere.
//!
//! A cell is a square of the parameters of a shape (see [`ShapeParameterization`]) on one of its sides. Its density is defined on the unit
//! square of (1 - cos theta, phi / 2 pi), an area-preserving map, in a tensor product basis; theta is measured from the shading normal on
//! the viewer's side and phi from the derivative by u. The density is fitted to the incident light times the cosine in the directions
//! sampled from it: the coefficient of function j in the dual basis is w_j times the mean over the directions sampled from function j. The
//! document's equations for two dimensions divide this by the density once more, which is an error; its tables were computed without this
//! division.
//!
//! Departures: coefficients are raised to those of a tenth of the constant density, in every basis; the bound of the document is lower by w_j
//! for functions that are not orthonormal, so that densities of splines decrease with the scale. phi is an interval here, not a
//! circle: the splines are not periodic, and a density may jump at the ends.
//!
//! # Source
//! @pietrek2001 sections 2.4 to 2.6 and 3.3.

use std::f64::consts::TAU;
use std::sync::Arc;

use glanz_math::{DVec2, DVec3, Frame};
use glanz_sampling::DensityError;
use glanz_sampling::basis::TensorBasis;
use glanz_sampling::density::{CoefficientFloor, Density, DualEstimate, TensorMultiResolution};
use glanz_sampling::multiresolution::MultiResolution;
use glanz_scene::description::{GridSettings, GuideBasis};
use glanz_scene::{Interaction, Scene, ShapeParameterization};

use super::GuideSize;

mod file;
mod sums;
#[cfg(test)]
mod tests;

pub(crate) use file::{decode_grid, decode_sums, encode_grid, encode_sums};
pub(crate) use sums::{GridRecord, GridSums};

/// Lower bound of a density as a fraction of the constant density (document 003 section 2.4.3.2).
const FLOOR: CoefficientFloor = CoefficientFloor::Constant(0.1);

/// Largest memory of a guide and its sums, bytes.
const MOST_BYTES: u64 = 4 << 30;

/// Errors of building a grid.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GridError {
    /// Too many cells, or too many functions per density.
    #[error(
        "the guide {settings} may need {:.1} GiB for {shapes} shapes, more than {:.0} GiB",
        *.bytes as f64 / GIB,
        MOST_BYTES as f64 / GIB
    )]
    Memory {
        /// The requested value.
        settings: GridSettings,
        /// Number of shapes of the scene.
        shapes: usize,
        /// The memory it may need, bytes.
        bytes: u64,
    },
    /// The basis cannot be built.
    #[error("the guide {settings}: {source}")]
    Basis {
        /// The requested value.
        settings: GridSettings,
        /// The reason.
        source: DensityError,
    },
}

/// Bytes of a GiB.
const GIB: f64 = (1_u64 << 30) as f64;

/// The density of a cell.
#[derive(Clone, Debug, PartialEq)]
struct FittedCells {
    /// The coefficients before normalisation, for files: normalising them again could change a bit.
    coefficients: Vec<f32>,
    density: Density<2>,
}

/// Densities of directions on a grid of cells.
#[derive(Clone, Debug, PartialEq)]
pub struct GridGuide {
    settings: GridSettings,
    /// The chart of each shape and the number of its first cell.
    parameterizations: Vec<Option<(ShapeParameterization, u32)>>,
    scales: Arc<TensorMultiResolution<2>>,
    /// Number of finished training passes.
    passes: u32,
    /// The constant density, for untrained cells.
    constant: Density<2>,
    /// `None` for untrained cells.
    cells: Vec<Option<Box<FittedCells>>>,
}

/// Guide data of a vertex.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GridVertex {
    pub(crate) cell: u32,
    frame: Frame,
}

impl GridVertex {
    /// The cosine between `direction` and the shading normal; 0 below the surface.
    #[inline]
    pub(crate) fn cosine(&self, direction: DVec3) -> f64 {
        self.frame.z.dot(direction).max(0.0)
    }
}

/// A direction sampled from a density.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GridSample {
    pub(crate) direction: DVec3,
    /// Density per steradian.
    pub(crate) pdf: f64,
    /// The function from which it was sampled.
    pub(crate) function: u32,
}

impl GridGuide {
    /// An untrained guide for `scene`.
    ///
    /// # Errors
    /// [`GridError::Memory`] if it may need more than 4 GiB.
    pub fn new(scene: &Scene, settings: &GridSettings) -> Result<Self, GridError> {
        Self::from_charts(scene.parameterizations(), settings, 0)
    }

    /// An untrained guide over shapes with these charts, with this number of finished passes.
    fn from_charts(
        parameterizations: Vec<Option<ShapeParameterization>>,
        settings: &GridSettings,
        passes: u32,
    ) -> Result<Self, GridError> {
        let settings = *settings;
        let scales =
            scales(&settings).map(Arc::new).map_err(|source| GridError::Basis { settings, source })?;
        let basis = |level: u32| scales.basis([level as usize; 2]);
        let finest = basis(settings.scale).map_err(|source| GridError::Basis { settings, source })?;
        let mut count = 0_u64;
        let shapes = parameterizations.len();
        let parameterizations = parameterizations
            .into_iter()
            .map(|parameterization| {
                let parameterization = parameterization?;
                let first = count;
                count += u64::from(parameterization.sheets() * settings.cells * settings.cells);
                Some((parameterization, u32::try_from(first).unwrap_or(u32::MAX)))
            })
            .collect();
        let bytes = count.saturating_mul(cell_bytes(finest.len()));
        let cells = usize::try_from(count).ok().filter(|_| bytes <= MOST_BYTES);
        let cells = cells.ok_or(GridError::Memory { settings, shapes, bytes })?;
        let level = level(&settings, passes);
        let basis = basis(level).map_err(|source| GridError::Basis { settings, source })?;
        let constant = Density::uniform(basis);
        Ok(Self { settings, parameterizations, scales, passes, constant, cells: vec![None; cells] })
    }

    /// Its settings.
    #[must_use]
    pub fn settings(&self) -> GridSettings {
        self.settings
    }

    /// Whether all passes of its settings are finished.
    pub(crate) fn is_finished(&self) -> bool {
        self.settings.passes.is_some_and(|lengths| self.passes >= lengths.count())
    }

    fn basis(&self) -> &Arc<TensorBasis<2>> {
        self.constant.basis()
    }

    /// Guide data of a vertex with this unit normal on the viewer's side; `None` on shapes outside the guide.
    #[inline]
    pub(crate) fn place(&self, at: &Interaction, normal: DVec3) -> Option<GridVertex> {
        let (parameterization, first) = self.parameterizations.get(at.id as usize)?.as_ref()?;
        let (sheet, place) = parameterization.locate(at);
        let cell = first + cell_of(self.settings.cells, sheet, place);
        Some(GridVertex { cell, frame: Frame::from_z_and_tangent(normal, parameterization.tangent(at)) })
    }

    fn density(&self, cell: u32) -> &Density<2> {
        match self.cells.get(cell as usize) {
            Some(Some(learnt)) => &learnt.density,
            _ => &self.constant,
        }
    }

    /// Samples a direction.
    #[inline]
    pub(crate) fn sample(&self, place: &GridVertex, xi: DVec2) -> GridSample {
        let sample = self.density(place.cell).sample(&xi.to_array());
        GridSample {
            direction: place.frame.to_world(to_hemisphere(sample.point)),
            pdf: sample.pdf / TAU,
            function: sample.function as u32,
        }
    }

    /// Density per steradian of `direction`; 0 below the surface.
    #[inline]
    pub(crate) fn pdf(&self, place: &GridVertex, direction: DVec3) -> f64 {
        let local = place.frame.to_local(direction);
        if local.z <= 0.0 { 0.0 } else { self.density(place.cell).pdf(&to_square(local)) / TAU }
    }

    /// Empty sums.
    pub(crate) fn sums(&self) -> GridSums {
        GridSums::new(self.cells.len(), self.basis().len())
    }

    /// The guide fitted to `sums` of this guide, and the initial sums of its pass.
    ///
    /// On the same scale the sums of all passes are kept with equal weights (document 003 section 2.4.5); on a finer scale they start anew.
    /// `growth`: ratio of the new unit of light to the old one, a power of two.
    pub(crate) fn fitted(&self, sums: &GridSums, growth: f64) -> (Self, GridSums) {
        let passes = self.passes.saturating_add(1);
        let (from, to) = (level(&self.settings, self.passes), level(&self.settings, passes));
        let mut cells: Vec<Option<Box<FittedCells>>> = Vec::with_capacity(self.cells.len());
        let finer = (from != to).then(|| self.scales.basis([to as usize; 2]).ok()).flatten();
        for (cell, old) in (0..).zip(&self.cells) {
            let new = sums.cell(cell).and_then(|words| self.learnt(&words)).or_else(|| old.clone());
            cells.push(match (&finer, new) {
                (Some(basis), Some(learnt)) => self.refined(&learnt, basis, [from, to]),
                (_, new) => new,
            });
        }
        let constant = finer.clone().map_or_else(|| self.constant.clone(), Density::uniform);
        let (settings, parameterizations, scales) =
            (self.settings, self.parameterizations.clone(), self.scales.clone());
        let guide = Self { settings, parameterizations, scales, passes, constant, cells };
        let sums = if finer.is_some() { guide.sums() } else { sums.rescaled(growth) };
        (guide, sums)
    }

    /// The density fitted to the number and light of the directions of each function; `None` without light.
    fn learnt(&self, words: &[(u64, u64)]) -> Option<Box<FittedCells>> {
        let basis = self.basis();
        let weights = basis.weights();
        let means = words.iter().map(|&(n, light)| if n > 0 { light as f64 / n as f64 } else { 0.0 });
        let mut estimate = DualEstimate {
            values: means.zip(&weights).map(|(mean, w)| mean * w).collect(),
            variances: vec![f64::INFINITY; words.len()],
            counts: words.iter().map(|&(n, _)| n).collect(),
            integral: 0.0,
            samples: words.iter().map(|&(n, _)| n).sum(),
        };
        estimate.fill_from_neighbours(basis).ok()?;
        // The functions sum to a constant, as do their inner products.
        let mean = estimate.values.iter().sum::<f64>() * basis.unit_coefficient();
        if !(mean > 0.0 && mean.is_finite()) {
            return None;
        }
        let mut approximation = estimate.values;
        basis.to_primary(&mut approximation).ok()?;
        approximation.iter_mut().for_each(|c| *c /= mean);
        FLOOR.apply(basis, &mut approximation, 1.0);
        FittedCells::new(basis, approximation.iter().map(|&c| c as f32).collect())
    }

    /// The density on the next finer level.
    fn refined(
        &self,
        learnt: &FittedCells,
        basis: &Arc<TensorBasis<2>>,
        [from, to]: [u32; 2],
    ) -> Option<Box<FittedCells>> {
        let levels = [from, to].map(|level| [level as usize; 2]);
        let refined = self.scales.refine(learnt.density.coefficients(), levels[0], levels[1]).ok()?;
        FittedCells::new(basis, refined.iter().map(|&c| c as f32).collect())
    }

    /// Its size.
    pub(crate) fn size(&self) -> GuideSize {
        let active = self.cells.iter().flatten().count();
        let functions = self.basis().len();
        let bytes = self.cells.len() as u64 * CELL_OVERHEAD + active as u64 * cell_bytes(functions);
        GuideSize { cells: self.cells.len(), active, leaves: active * functions, bytes: bytes as usize }
    }
}

impl FittedCells {
    fn new(basis: &Arc<TensorBasis<2>>, coefficients: Vec<f32>) -> Option<Box<Self>> {
        let wide = coefficients.iter().map(|&c| f64::from(c)).collect();
        let density = Density::try_new(basis.clone(), wide).ok()?;
        Some(Box::new(Self { coefficients, density }))
    }
}

/// Bytes of a cell without density, in the guide and in the sums.
const CELL_OVERHEAD: u64 = 8 + 24;

/// Largest size in bytes of a cell and its sums with densities of this number of functions: two words of sums for each function, and for
/// the density a coefficient in two precisions and a sum of probabilities for each function and each row of them.
fn cell_bytes(functions: usize) -> u64 {
    let row = (functions as f64).sqrt().ceil() as u64;
    CELL_OVERHEAD + size_of::<FittedCells>() as u64 + (2 * 8 + 8 + 4 + 8) * functions as u64 + 8 * row
}

/// The level of the densities after this number of passes.
fn level(settings: &GridSettings, passes: u32) -> u32 {
    if settings.hierarchical { passes.min(settings.scale) } else { settings.scale }
}

fn scales(settings: &GridSettings) -> Result<TensorMultiResolution<2>, DensityError> {
    let finest = settings.scale as usize;
    let analysis = match settings.basis {
        GuideBasis::Haar => MultiResolution::haar(finest)?,
        GuideBasis::Spline(degree) => MultiResolution::bspline(degree as usize, finest)?,
    };
    Ok(TensorMultiResolution::new([analysis.clone(), analysis]))
}

/// The cell of a point among those of its shape, with `n` x `n` cells on a sheet.
fn cell_of(n: u32, sheet: u32, place: DVec2) -> u32 {
    // The cast clamps negative values to 0.
    let step = |x: f64| ((x * f64::from(n)) as u32).min(n - 1);
    (sheet * n + step(place.x)) * n + step(place.y)
}

/// The direction at a point (1 - cos theta, phi / 2 pi) of the unit square.
fn to_hemisphere([x, y]: [f64; 2]) -> DVec3 {
    // sin^2 = (1 - cos) (1 + cos) without cancellation.
    let sin = (x * (2.0 - x)).max(0.0).sqrt();
    let (sin_phi, cos_phi) = (TAU * y).sin_cos();
    DVec3::new(sin * cos_phi, sin * sin_phi, 1.0 - x)
}

/// The point of the unit square of a unit direction with z >= 0.
fn to_square(direction: DVec3) -> [f64; 2] {
    let DVec3 { x, y, z } = direction;
    // 1 - z = (x^2 + y^2) / (1 + z) without cancellation.
    let turn = y.atan2(x) / TAU;
    let below_one = 1.0 - f64::EPSILON / 2.0;
    [((x * x + y * y) / (1.0 + z)).clamp(0.0, 1.0), (turn - turn.floor()).min(below_one)]
}
