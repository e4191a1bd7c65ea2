//! The format of a film.

use glanz_job::ScratchFileError;
use glanz_light::PixelsError;
use glanz_sampling::exact::MAX_TERMS;

use crate::aov::{Aov, AovSet};
use crate::noise::NoiseLevel;
use crate::pixel::PixelLayout;
use crate::pixel_rect::PixelRect;
use crate::ranges::OverlapError;
use crate::splat::SplatLayout;

/// Errors of creating or merging films.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FilmError {
    /// Width or height is zero, or there are more than 2^31 pixels.
    #[error("the picture has {0} x {1} pixels; it must have 1 to 2^31")]
    Size(u32, u32),
    /// A crop window that is empty or extends beyond the picture.
    #[error("the crop window {window:?} is empty or extends beyond the picture of {} x {} pixels", .resolution[0], .resolution[1])]
    Crop {
        /// Smallest and largest x, then y.
        window: [f64; 4],
        /// Width and height of the full picture.
        resolution: [u32; 2],
    },
    /// A noise level for samples whose variance is not known, or depends on other pixels.
    #[error("a noise level needs the channel of the variance, and an integrator without passes and splats")]
    Noise,
    /// The sums do not fit in memory.
    #[error("there is no memory for a film of {0} bytes")]
    Memory(u64),
    /// The sums take more memory than they may, and cannot be in a file.
    #[error(
        "the film needs {} MB of memory, and {} MB may be used; raise the limit, choose a smaller picture, or leave out the noise level, denoising and \
         integrators that learn or connect light to the film",
        .needed.div_ceil(1_000_000), .limit / 1_000_000
    )]
    Limit {
        /// Memory of the film, bytes.
        needed: u64,
        /// Memory that it may take, bytes.
        limit: u64,
    },
    /// The temporary file of the sums or of the scene's pictures failed.
    #[error(transparent)]
    File(#[from] ScratchFileError),
    /// The picture cannot be made of the film.
    #[error(transparent)]
    Pixels(#[from] PixelsError),
    /// Lines along edges that are drawn for other pixels.
    #[error(
        "the edges are drawn for {} x {} pixels from {:?} on, the film has {} x {} from {:?} on; draw them for the film",
        .drawn.size[0], .drawn.size[1], .drawn.min, .crop.size[0], .crop.size[1], .crop.min
    )]
    Edges {
        /// The pixels of the lines.
        drawn: PixelRect,
        /// The pixels of the film.
        crop: PixelRect,
    },
    /// Two films of different pictures.
    #[error("the films differ in {0}")]
    Layout(&'static str),
    /// Two films with common samples.
    #[error(transparent)]
    Overlap(#[from] OverlapError),
    /// A film whose samples depend on earlier ones, which cannot be merged.
    #[error("its samples depend on earlier ones")]
    Ordered,
    /// More samples than the sums can hold exactly.
    #[error("{0} samples per pixel are more than the {MAX_TERMS} a film can hold")]
    Samples(u64),
}

/// Format of a film: its pixels and the sums of each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FilmFormat {
    /// Width and height of the full picture.
    pub resolution: [u32; 2],
    /// The part that is rendered.
    pub crop: PixelRect,
    /// Extra channels.
    pub aovs: AovSet,
    /// Whether the filter has negative lobes.
    pub signed: bool,
    /// Whether samples come in passes of different variance, from an integrator that
    /// [learns](crate::Integrator::learns).
    pub passes: bool,
    /// Whether the integrator [splats](crate::Integrator::splats).
    pub splats: bool,
    /// The noise at which tiles take no more samples, which needs [`Aov::Variance`], and neither passes nor splats; `None`: all take the same.
    pub noise: Option<NoiseLevel>,
}

impl FilmFormat {
    /// The whole picture without extra channels, for a filter without negative lobes.
    #[must_use]
    pub const fn plain(resolution: [u32; 2]) -> Self {
        Self {
            resolution,
            crop: PixelRect::full(resolution),
            aovs: AovSet::NONE,
            signed: false,
            passes: false,
            splats: false,
            noise: None,
        }
    }

    /// Whether samples depend on earlier ones, so that they are taken in order and parts cannot be merged.
    #[must_use]
    pub fn is_ordered(&self) -> bool {
        self.passes || self.noise.is_some()
    }

    /// Whether the sums may be in a file: if no integrator needs those of all pixels at a time.
    #[must_use]
    pub fn fits_in_file(&self) -> bool {
        !self.passes && !self.splats && self.noise.is_none()
    }

    /// Checks that a film of this format needs at most this memory, bytes, or may be in a file.
    ///
    /// # Errors
    /// [`FilmError::Limit`], and those of [`FilmFormat::words`].
    pub fn check_memory(&self, limit: u64) -> Result<(), FilmError> {
        let needed = self.words()?.saturating_mul(8);
        if needed > limit && !self.fits_in_file() { Err(FilmError::Limit { needed, limit }) } else { Ok(()) }
    }

    /// The sums of each pixel.
    #[must_use]
    pub fn layout(&self) -> PixelLayout {
        PixelLayout { aovs: self.aovs, signed: self.signed, passes: self.passes }
    }

    /// The sums of the light splatted to each pixel.
    pub(crate) fn splat_layout(&self) -> SplatLayout {
        SplatLayout { squares: self.aovs.contains(Aov::Variance) }
    }

    /// Number of 64 bit words that a film of this format holds.
    ///
    /// # Errors
    /// [`FilmError::Size`], [`FilmError::Crop`] and [`FilmError::Noise`] as [`Film::try_new`](super::Film::try_new).
    pub fn words(&self) -> Result<u64, FilmError> {
        let [width, height] = self.crop.size;
        if self.crop.is_empty() || self.crop.len() > 1 << 31 {
            return Err(FilmError::Size(width, height));
        }
        let inside = (0..2).all(|i| {
            self.crop.min[i].checked_add(self.crop.size[i]).is_some_and(|end| end <= self.resolution[i])
        });
        if !inside {
            let [x, y] = self.crop.min.map(f64::from);
            let window = [x, x + f64::from(width), y, y + f64::from(height)];
            return Err(FilmError::Crop { window, resolution: self.resolution });
        }
        if self.noise.is_some() && (!self.aovs.contains(Aov::Variance) || self.passes || self.splats) {
            return Err(FilmError::Noise);
        }
        let splats = if self.splats { self.splat_layout().words() } else { 0 };
        Ok(self.crop.len() * (self.layout().words() + splats) as u64)
    }
}
