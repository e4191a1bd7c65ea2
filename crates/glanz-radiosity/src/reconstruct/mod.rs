//! From one value per element to a picture of the light on a surface (document 003 chapter 4).
//!
//! A surface's parameters are the unit square, divided into [`Cells`] with a value each. An [`Interpolation`] makes of them a
//! function over the square, an [`Interpolant`], which can be asked at a point or put into a [`Texture`]. Cells stand for their
//! middles; *border samples* at the sides of the square give the cells there a second point ([`Border`]).
//!
//! | interpolation | samples | continuous | overshoots |
//! |---|---|---|---|
//! | [`Interpolation::Constant`] | cells | no | no |
//! | [`Interpolation::Bilinear`] | grid | itself | no |
//! | [`Interpolation::Spline`] | grid | with second derivatives | yes |
//! | [`Interpolation::Shepard`] | any | itself; slope 0 at samples for exponents above 1 | no |
//! | [`Interpolation::Multiquadrics`] | any | with all derivatives | yes |
//! | [`Interpolation::NaturalNeighbour`] | any | itself; its slope but at samples | no |
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

pub use cells::{Cell, Cells};
pub use lattice::Lattice;
pub use texture::Texture;

use bilinear::Bilinear;
use multiquadrics::Multiquadrics;
use natural::NaturalNeighbour;
use shepard::Shepard;
use spline::Spline;

/// A value at a point of the unit square; bands are red, green and blue.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Where.
    pub point: DVec2,
    /// What is there.
    pub value: DVec3,
}

/// Whether cells at the sides of the square have samples there too.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Border {
    /// Middles of cells alone: what lies beyond the outermost is extrapolated.
    Open,
    /// Each cell has samples at its sides that are sides of the square, opposite its middle, and at its corners that are corners
    /// of the square, all of its value (@pietrek2001 section 4.6).
    #[default]
    Sampled,
}

/// How values between samples are found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Interpolation {
    /// The value of the cell.
    Constant,
    /// Linear along u and v between the samples of a grid; constant beyond.
    Bilinear,
    /// Cubic splines along u, then v, without curvature at the ends; straight beyond.
    Spline,
    /// Mean of all samples, weighted by distance^-exponent (@shepard1968). 003 takes 4.
    Shepard {
        /// Above 0.
        exponent: f64,
    },
    /// Sum of (distance^2 + r^2)^exponent around all samples, r the distance to the next
    /// (@hardy1971; radii after Eck, as in 003, which takes 0.5).
    Multiquadrics {
        /// Not 0; natural numbers have no unique solution.
        exponent: f64,
    },
    /// Mean of the samples whose Voronoi cells a new sample would take from, by the areas taken (@sibson1981).
    NaturalNeighbour,
}

/// Why samples cannot be interpolated.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ReconstructError {
    /// Cells that are no grid.
    #[error("{0} interpolates grids alone, and these {1} cells are none")]
    NoGrid(&'static str, usize),
    /// An exponent that the method cannot have.
    #[error("an exponent of {1} is not possible with {0}")]
    Exponent(&'static str, f64),
    /// A sample that is not finite or outside the domain.
    #[error("sample {0} is not finite, or outside the domain")]
    Sample(usize),
    /// Two samples at one point, or none at all.
    #[error("there is no sample, or two are at one point")]
    Points,
    /// Equations without a solution.
    #[error("the system of {0} equations has no unique solution")]
    Singular(usize),
    /// Cells that do not cover the square once.
    #[error("cell {0} is empty, leaves the unit square or overlaps another, or the cells leave a gap")]
    Cells(usize),
}

/// A function over the unit square that has the values of the samples at their points.
pub trait Interpolant: Send + Sync {
    /// The value at `point`, in the unit square.
    fn value(&self, point: DVec2) -> DVec3;

    /// The values at the middles of `size[0]` x `size[1]` texels, rows of u one after the other from v = 0.
    fn texture(&self, size: [usize; 2]) -> Texture {
        Texture::from_function(size, |point| self.value(point))
    }
}

impl Interpolation {
    /// All methods with 003's exponents.
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

    /// Whether cells have to be a grid.
    #[must_use]
    pub fn needs_grid(&self) -> bool {
        matches!(self, Self::Bilinear | Self::Spline)
    }

    /// The function over `cells`.
    ///
    /// # Errors
    /// [`ReconstructError::NoGrid`] for cells that are no grid with a method that needs one, and those of
    /// [`Interpolation::of_samples`].
    pub fn of_cells(&self, cells: &Cells, border: Border) -> Result<Box<dyn Interpolant>, ReconstructError> {
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

    /// The function over the samples of a grid.
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

    /// The function over samples anywhere in the unit square.
    ///
    /// # Errors
    /// [`ReconstructError`] for samples at one point or outside, an exponent that the method cannot have, a method that
    /// needs cells or a grid.
    pub fn of_samples(&self, samples: &[Sample]) -> Result<Box<dyn Interpolant>, ReconstructError> {
        self.of_samples_within(samples, DVec2::ONE)
    }

    /// The function over samples anywhere in the rectangle from the origin to `size`, both of whose sides are at most 1.
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
        Ok(match *self {
            Self::Constant | Self::Bilinear | Self::Spline => {
                return Err(ReconstructError::NoGrid(self.name(), samples.len()));
            }
            Self::Shepard { exponent } => Box::new(Shepard::try_new(samples, exponent)?),
            Self::Multiquadrics { exponent } => Box::new(Multiquadrics::try_new(samples, exponent)?),
            Self::NaturalNeighbour => Box::new(NaturalNeighbour::try_new(samples, size)?),
        })
    }
}
