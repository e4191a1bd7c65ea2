//! Interpolation of one value per element over a surface (document 003 chapter 4).
//!
//! The parameters of a surface are the unit square, divided into [`ParameterCells`] with a value each. An [`Interpolation`] makes them a
//! function over the square, an [`Interpolant`], which can be evaluated at points or sampled into an [`InterpolatedTexture`]. Each cell
//! is a sample at its middle; *border samples* at the sides of the square add further points ([`Border`]). Samples and grids may also
//! cover another rectangle, the *domain*, from the origin, with sides of at most 1.
//!
//! | interpolation | samples | continuous | overshoots |
//! |---|---|---|---|
//! | [`Interpolation::Constant`] | cells | no | no |
//! | [`Interpolation::Bilinear`] | grid | values | no |
//! | [`Interpolation::Spline`] | grid | values, first and second derivatives | yes |
//! | [`Interpolation::Shepard`] | any | values; slope 0 at samples for exponents above 1 | no |
//! | [`Interpolation::Multiquadrics`] | any | values, all derivatives | yes |
//! | [`Interpolation::NaturalNeighbour`] | any | values; slopes except at samples | no |
//!
//! # Source
//! @pietrek2001 chapter 4.

use glanz_math::{DVec2, DVec3};

mod bilinear;
mod cells;
mod dense;
mod lattice;
mod multiquadrics;
mod natural;
pub(crate) mod partition;
#[cfg(test)]
mod reference;
mod shepard;
mod spline;
#[cfg(test)]
mod tests;
mod texture;

pub use cells::{ParameterCell, ParameterCells};
pub use lattice::Lattice;
pub use texture::InterpolatedTexture;

use bilinear::Bilinear;
use multiquadrics::Multiquadrics;
use natural::NaturalNeighbour;
use shepard::Shepard;
use spline::Spline;

/// A value at a point of the domain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// The point.
    pub point: DVec2,
    /// Its value: red, green and blue.
    pub value: DVec3,
}

/// Samples of cells at the sides of the square.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Border {
    /// Only the middles of cells: values beyond the outermost ones are extrapolated.
    Open,
    /// Each cell also has samples with its value in the middle of its sides on the border of the square, and at its corners that are
    /// corners of the square (@pietrek2001 section 4.6).
    #[default]
    Sampled,
}

/// Method of interpolation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Interpolation {
    /// The value of the cell.
    Constant,
    /// Linear along u and v between the samples of a grid; constant beyond.
    Bilinear,
    /// Natural cubic splines along u, then v; linear beyond.
    Spline,
    /// Mean of all samples, weighted by distance^-exponent (@shepard1968); document 003 uses 4.
    Shepard {
        /// Above 0.
        exponent: f64,
    },
    /// Sum of (distance^2 + r^2)^exponent around all samples, r the distance of the nearest sample
    /// (@hardy1971; radii after Eck, as in document 003, which uses 0.5).
    Multiquadrics {
        /// Not 0; for natural numbers the equations may be singular.
        exponent: f64,
    },
    /// Mean of the samples, weighted by the areas that a new sample would take from their Voronoi cells (@sibson1981).
    NaturalNeighbour,
}

/// Error of an interpolation.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ReconstructError {
    /// A method that needs a grid, and the number of cells or samples, which form none.
    #[error(
        "the interpolation {0} needs a grid of cells, which the {1} samples are not; choose shepard, multiquadrics or natural"
    )]
    NoGrid(&'static str, usize),
    /// An invalid exponent of a method.
    #[error(
        "the exponent of {0} is {1}; it must be finite, above 0 for shepard, and not 0 for multiquadrics"
    )]
    Exponent(&'static str, f64),
    /// A sample with this number that is not finite or outside the domain.
    #[error("sample {0} is not finite or outside the domain; remove it")]
    Sample(usize),
    /// Two samples at one point, or no sample.
    #[error("there is no sample, or two are at one point; give at least one and merge those that coincide")]
    Points,
    /// Equations without a unique solution, and their number.
    #[error("the system of {0} equations has no unique solution; choose another exponent or interpolation")]
    Singular(usize),
    /// Cells that do not cover the square exactly once, and the number of the first invalid one.
    #[error(
        "cell {0} is empty, outside the unit square or overlaps another, or there is a gap; cells must cover the square once"
    )]
    Cells(usize),
}

/// An interpolating function over the domain.
pub trait Interpolant: Send + Sync {
    /// The value at a point of the domain.
    fn value(&self, point: DVec2) -> DVec3;

    /// The values at the middles of `size[0]` x `size[1]` texels of the unit square, which must be the domain.
    fn texture(&self, size: [usize; 2]) -> InterpolatedTexture {
        InterpolatedTexture::from_function(size, |point| self.value(point))
    }
}

impl Interpolation {
    /// All methods, with the exponents of document 003.
    pub const ALL: [Self; 6] = [
        Self::Constant,
        Self::Bilinear,
        Self::Spline,
        Self::Shepard { exponent: 4.0 },
        Self::Multiquadrics { exponent: 0.5 },
        Self::NaturalNeighbour,
    ];

    /// Name in tables and on the command line.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Constant => "constant",
            Self::Bilinear => "bilinear",
            Self::Spline => "spline",
            Self::Shepard { .. } => "shepard",
            Self::Multiquadrics { .. } => "multiquadrics",
            Self::NaturalNeighbour => "natural",
        }
    }

    /// Whether the method needs a grid.
    #[must_use]
    pub fn needs_grid(&self) -> bool {
        matches!(self, Self::Bilinear | Self::Spline)
    }

    /// Checks the exponent.
    ///
    /// # Errors
    /// [`ReconstructError::Exponent`] unless it is finite, above 0 for Shepard's method and not 0 for multiquadrics.
    pub fn check(&self) -> Result<(), ReconstructError> {
        match *self {
            Self::Shepard { exponent } if !(exponent > 0.0 && exponent.is_finite()) => {
                Err(ReconstructError::Exponent(self.name(), exponent))
            }
            Self::Multiquadrics { exponent } if exponent == 0.0 || !exponent.is_finite() => {
                Err(ReconstructError::Exponent(self.name(), exponent))
            }
            _ => Ok(()),
        }
    }

    /// Interpolates the values of cells.
    ///
    /// # Errors
    /// [`ReconstructError::NoGrid`] if the method needs a grid and the cells are none, and those of [`Interpolation::of_samples`].
    pub fn of_cells(
        &self,
        cells: &ParameterCells,
        border: Border,
    ) -> Result<Box<dyn Interpolant>, ReconstructError> {
        match self {
            Self::Constant => Ok(Box::new(cells.clone())),
            Self::Bilinear | Self::Spline => {
                let lattice = cells.lattice(border);
                self.of_lattice(
                    &lattice.ok_or_else(|| ReconstructError::NoGrid(self.name(), cells.as_slice().len()))?,
                )
            }
            _ => self.of_samples(&cells.samples(border)),
        }
    }

    /// Interpolates the values of a grid.
    ///
    /// # Errors
    /// Those of [`Interpolation::of_samples`].
    pub fn of_lattice(&self, lattice: &Lattice) -> Result<Box<dyn Interpolant>, ReconstructError> {
        Ok(match self {
            Self::Bilinear => Box::new(Bilinear::new(lattice)),
            Self::Spline => Box::new(Spline::new(lattice)),
            _ => return self.of_samples(&lattice.samples()),
        })
    }

    /// Interpolates samples at any points of the unit square.
    ///
    /// # Errors
    /// [`ReconstructError::Sample`] for a sample outside or not finite, [`ReconstructError::Points`] without samples or for two at one
    /// point, [`ReconstructError::Exponent`] for an invalid exponent, [`ReconstructError::Singular`] for equations without a unique
    /// solution, [`ReconstructError::NoGrid`] for a method that needs cells or a grid.
    pub fn of_samples(&self, samples: &[Sample]) -> Result<Box<dyn Interpolant>, ReconstructError> {
        self.of_samples_within(samples, DVec2::ONE)
    }

    /// Interpolates samples at any points of the domain from the origin to `size`, whose sides are at most 1.
    ///
    /// # Errors
    /// Those of [`Interpolation::of_samples`].
    pub fn of_samples_within(
        &self,
        samples: &[Sample],
        size: DVec2,
    ) -> Result<Box<dyn Interpolant>, ReconstructError> {
        let inside =
            |s: &Sample| s.point.cmpge(DVec2::ZERO).all() && s.point.cmple(size).all() && s.value.is_finite();
        if let Some(wrong) = samples.iter().position(|s| !inside(s)) {
            return Err(ReconstructError::Sample(wrong));
        }
        if samples.is_empty() {
            return Err(ReconstructError::Points);
        }
        self.check()?;
        Ok(match *self {
            Self::Constant | Self::Bilinear | Self::Spline => {
                return Err(ReconstructError::NoGrid(self.name(), samples.len()));
            }
            Self::Shepard { exponent } => Box::new(Shepard::new(samples, exponent)),
            Self::Multiquadrics { exponent } => Box::new(Multiquadrics::try_new(samples, exponent)?),
            Self::NaturalNeighbour => Box::new(NaturalNeighbour::try_new(samples, size)?),
        })
    }
}
