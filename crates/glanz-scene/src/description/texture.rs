//! Textures and their pictures, and parameters that are a texture or a value.

use glanz_light::{Pixels, SpectralDistribution};
use glanz_math::{DMat4, DVec3};
use glanz_shading::texture::{FractalKind, ImageFilter, ImageWrap, MipMap, MipMapError, TextureMapping};

use super::Location;

/// A picture for textures and lights.
#[derive(Clone, Debug)]
pub struct ImageDescription {
    /// Its file.
    pub name: String,
    /// Linear values; row 0 is the top.
    pub picture: MipMap,
}

impl ImageDescription {
    /// A picture in memory.
    ///
    /// # Errors
    /// [`MipMapError::Channels`] if it has neither R, G and B nor Y.
    pub fn try_new(name: impl Into<String>, pixels: &Pixels) -> Result<Self, MipMapError> {
        Ok(Self { name: name.into(), picture: MipMap::try_new(pixels)? })
    }
}

/// A spectrum or a texture of spectra.
#[derive(Clone, Debug, PartialEq)]
pub enum SpectrumParameter {
    /// The same everywhere.
    Value(SpectralDistribution),
    /// Index into [`Description::textures`](super::Description::textures).
    Texture(usize),
}

impl From<SpectralDistribution> for SpectrumParameter {
    fn from(value: SpectralDistribution) -> Self {
        Self::Value(value)
    }
}

impl From<f32> for SpectrumParameter {
    fn from(value: f32) -> Self {
        Self::Value(value.into())
    }
}

impl From<[f32; 3]> for SpectrumParameter {
    /// Linear Rec. 709.
    fn from(rgb: [f32; 3]) -> Self {
        Self::Value(rgb.into())
    }
}

/// A number or a texture of numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FloatParameter {
    /// The same everywhere.
    Value(f32),
    /// Index into [`Description::textures`](super::Description::textures).
    Texture(usize),
}

impl From<f32> for FloatParameter {
    fn from(value: f32) -> Self {
        Self::Value(value)
    }
}

/// A texture.
#[derive(Clone, Debug)]
pub struct TextureDescription {
    /// Its name in the scene.
    pub name: String,
    /// Its kind with its parameters.
    pub kind: TextureKind,
    /// Its place in the input.
    pub location: Option<Location>,
}

/// The textures. Float textures hold their numbers as grey spectra.
#[derive(Clone, Debug)]
pub enum TextureKind {
    /// The same everywhere.
    Constant(SpectrumParameter),
    /// Product of two inputs.
    Scale(SpectrumParameter, SpectrumParameter),
    /// `(1 - amount) a + amount b`.
    Mix {
        /// Value for `amount` 0.
        a: SpectrumParameter,
        /// Value for `amount` 1.
        b: SpectrumParameter,
        /// Weight of `b`.
        amount: FloatParameter,
    },
    /// Two inputs alternating in squares.
    Checkerboard {
        /// Input in cells whose numbers have an even sum.
        even: SpectrumParameter,
        /// Input in the other cells.
        odd: SpectrumParameter,
        /// Coordinates in cells.
        mapping: MappingDescription,
    },
    /// A picture.
    Image {
        /// Index into [`Description::images`](super::Description::images).
        image: usize,
        /// Coordinates; the picture fills [0, 1]^2, (0, 0) is its lower left corner.
        mapping: MappingDescription,
        /// Values outside [0, 1]^2.
        wrap: ImageWrap,
        /// Interpolation between pixels.
        filter: ImageFilter,
        /// Factor on every value.
        scale: f32,
        /// Whether the value is 1 minus the scaled value.
        invert: bool,
    },
    /// The fractions of the coordinates as red and green.
    Uv(MappingDescription),
    /// Inputs at (0, 0), (0, 1), (1, 0) and (1, 1) with bilinear interpolation between them.
    Bilerp {
        /// The inputs at the corners.
        corners: [SpectrumParameter; 4],
        /// Coordinates in the square.
        mapping: MappingDescription,
    },
    /// Random dots.
    Dots {
        /// Input inside of dots.
        inside: SpectrumParameter,
        /// Input between them.
        outside: SpectrumParameter,
        /// Coordinates in cells, each of which has a dot or none.
        mapping: MappingDescription,
    },
    /// A sum of noise.
    Fractal {
        /// The kind of sum.
        kind: FractalKind,
        /// Coordinates; one unit is the period of the first octave.
        mapping: MappingDescription,
    },
    /// Marble, with layers along y.
    Marble {
        /// Number of octaves of the noise.
        octaves: u32,
        /// Factor between the amplitudes of octaves.
        roughness: f64,
        /// Factor on the coordinates.
        scale: f64,
        /// Factor on the displacement of layers by the noise.
        variation: f64,
        /// Coordinates.
        mapping: MappingDescription,
    },
    /// Two inputs mixed by the absolute cosine of the angle between the surface normal and a direction.
    DirectionMix {
        /// Input for the cosine 1.
        along: SpectrumParameter,
        /// Input for the cosine 0.
        across: SpectrumParameter,
        /// Direction in the world, of any length but 0.
        direction: DVec3,
    },
}

/// Mapping of a texture to surfaces, with transformations that need not be invertible.
pub type MappingDescription = TextureMapping<DMat4>;
