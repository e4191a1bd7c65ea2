//! Parameters of materials in the form of a description and of shading.

use std::fmt::Debug;
use std::ops::RangeInclusive;

use glanz_light::{SpectralDistribution, Spectrum, Wavelengths};

use crate::texture::{FloatInput, SpectrumInput, TexturePoint, Textures};

/// A form of the parameters of materials: [`ShadingForm`], or that of a scene description.
pub trait ParameterForm {
    /// A spectrum, or a texture of spectra.
    type Spectrum: Clone + Debug + PartialEq;
    /// A number, or a texture of numbers.
    type Float: Clone + Debug + PartialEq;
}

/// The form for shading: constants, and textures of [`Textures`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShadingForm {}

impl ParameterForm for ShadingForm {
    type Spectrum = SpectrumInput;
    type Float = FloatInput;
}

/// An error in the parameters of a material.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MaterialError {
    /// A parameter refers to a texture that does not exist.
    #[error("{parameter} refers to a texture that does not exist; add the texture")]
    Texture {
        /// Name of the parameter.
        parameter: &'static str,
    },
    /// A constant is not finite or out of range.
    #[error("{parameter} is {value}; it must be {range}")]
    Range {
        /// Name of the parameter.
        parameter: &'static str,
        /// The value, of a spectrum the first lane out of range.
        value: f32,
        /// The range in words.
        range: &'static str,
    },
    /// A surface finish is given for a surface with facets.
    #[error("a finish needs a smooth surface; leave out the roughness or the finish")]
    RoughFinish,
}

/// Converts parameters of another form to [`ShadingForm`]. Materials call the checked conversions.
pub trait ParameterResolver<P: ParameterForm> {
    /// Converts a fraction of light; `None` if its texture does not exist.
    fn fraction_input(&self, input: &P::Spectrum) -> Option<SpectrumInput>;

    /// Converts a spectrum without upper bound; `None` if its texture does not exist.
    fn spectrum_input(&self, input: &P::Spectrum) -> Option<SpectrumInput>;

    /// Converts a number; `None` if its texture does not exist.
    fn float_input(&self, input: &P::Float) -> Option<FloatInput>;

    /// A fraction of light. Constants above 1 are allowed (scene files hold 1.0001): they are clamped where they are used. Of a spectrum by wavelength the
    /// colour is checked; negative samples, which measurements have, count as 0 where it is used.
    ///
    /// # Errors
    /// [`MaterialError::Texture`] for a texture that does not exist, [`MaterialError::Range`] for a constant that is negative or not finite.
    fn fraction(&self, parameter: &'static str, input: &P::Spectrum) -> Result<SpectrumInput, MaterialError> {
        checked_spectrum(parameter, self.fraction_input(input))
    }

    /// A spectrum of numbers of at least 0, such as refractive indices; of one by wavelength as for [`ParameterResolver::fraction`].
    ///
    /// # Errors
    /// As for [`ParameterResolver::fraction`].
    fn spectrum(&self, parameter: &'static str, input: &P::Spectrum) -> Result<SpectrumInput, MaterialError> {
        checked_spectrum(parameter, self.spectrum_input(input))
    }

    /// A number in `allowed`, which `range` describes.
    ///
    /// # Errors
    /// [`MaterialError::Texture`] for a texture that does not exist, [`MaterialError::Range`] for a constant out of range.
    fn float(
        &self,
        parameter: &'static str,
        input: &P::Float,
        allowed: RangeInclusive<f32>,
        range: &'static str,
    ) -> Result<FloatInput, MaterialError> {
        match self.float_input(input).ok_or(MaterialError::Texture { parameter })? {
            FloatInput::Constant(value) if !allowed.contains(&value) => {
                Err(MaterialError::Range { parameter, value, range })
            }
            input => Ok(input),
        }
    }
}

/// Checks only that textures exist.
impl ParameterResolver<ShadingForm> for Textures {
    fn fraction_input(&self, input: &SpectrumInput) -> Option<SpectrumInput> {
        self.spectrum_input(input)
    }

    fn spectrum_input(&self, input: &SpectrumInput) -> Option<SpectrumInput> {
        match input {
            SpectrumInput::Texture(id) => self.get(*id).map(|_| input.clone()),
            SpectrumInput::Constant(_) | SpectrumInput::Spectral(_) => Some(input.clone()),
        }
    }

    fn float_input(&self, input: &FloatInput) -> Option<FloatInput> {
        match input {
            FloatInput::Texture(id) => self.get(*id).map(|_| *input),
            FloatInput::Constant(_) => Some(*input),
        }
    }
}

fn checked_spectrum(
    parameter: &'static str,
    input: Option<SpectrumInput>,
) -> Result<SpectrumInput, MaterialError> {
    let input = input.ok_or(MaterialError::Texture { parameter })?;
    let outside = match &input {
        SpectrumInput::Constant(value) => first_outside(*value),
        SpectrumInput::Spectral(constant) => first_outside(constant.rgb),
        SpectrumInput::Texture(_) => None,
    };
    match outside {
        Some(value) => Err(MaterialError::Range { parameter, value, range: "a number of at least 0" }),
        None => Ok(input),
    }
}

/// The first lane that is negative or not finite.
fn first_outside(value: Spectrum) -> Option<f32> {
    let found = std::cell::Cell::new(None);
    let _ = value.map(|x| {
        if found.get().is_none() && !(x.is_finite() && x >= 0.0) {
            found.set(Some(x));
        }
        x
    });
    found.get()
}

/// Evaluates the parameters of materials at a point.
///
/// Values of textures are clamped to their range, so that a BSDF never creates energy.
#[derive(Clone, Copy, Debug)]
pub struct TextureEvaluator<'a> {
    textures: &'a Textures,
    at: &'a TexturePoint,
    wavelengths: &'a Wavelengths,
}

impl<'a> TextureEvaluator<'a> {
    /// `textures`: those that the parameters refer to.
    #[must_use]
    pub fn new(textures: &'a Textures, at: &'a TexturePoint, wavelengths: &'a Wavelengths) -> Self {
        Self { textures, at, wavelengths }
    }

    /// A fraction of light, clamped to [0, 1]; NaN becomes 0.
    #[must_use]
    pub fn fraction(&self, input: &SpectrumInput) -> Spectrum {
        self.spectrum(input).map(|x| x.min(1.0))
    }

    /// A spectrum clamped to at least 0; NaN becomes 0.
    #[must_use]
    pub fn spectrum(&self, input: &SpectrumInput) -> Spectrum {
        self.textures.spectrum(input, self.at, self.wavelengths).map(|x| x.max(0.0))
    }

    /// The largest component of a spectrum that has the value `here` at these wavelengths; for a colour the largest in RGB, which does not depend on
    /// the wavelengths of a path. `value` evaluates the spectrum at the wavelengths of its argument.
    #[must_use]
    pub fn largest(&self, here: Spectrum, value: impl Fn(&Self) -> Spectrum) -> f32 {
        let in_rgb = Self { wavelengths: &Wavelengths::Rgb, ..*self };
        match self.wavelengths {
            Wavelengths::Rgb => here.max_component(),
            // A spectrum by wavelength can exceed its colour.
            _ => here.max_component().max(value(&in_rgb).max_component()),
        }
    }

    /// A number, not clamped.
    #[must_use]
    pub fn float(&self, input: &FloatInput) -> f32 {
        self.textures.float(input, self.at)
    }

    /// The refractive index at the hero of sampled wavelengths, at which alone light can continue; `None` for RGB.
    #[must_use]
    pub fn hero_index(&self, dispersion: &SpectralDistribution) -> Option<f32> {
        let is_sampled = matches!(self.wavelengths, Wavelengths::Sampled(_));
        is_sampled.then(|| dispersion.unbounded(self.wavelengths).hero())
    }

    /// 1 in the lanes in use, 0 in others.
    #[must_use]
    pub fn white(&self) -> Spectrum {
        Spectrum::one(self.wavelengths)
    }
}
