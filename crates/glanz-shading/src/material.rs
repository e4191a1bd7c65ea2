//! Textured parameters of scattering models.

use std::ops::RangeInclusive;

use glanz_light::{Spectrum, Wavelengths};

use crate::bsdf::Bsdf;
use crate::model::phong::Coefficients;
use crate::model::{Conductor, Dielectric, Lambert, Mirror, Phong};
use crate::texture::{FloatInput, SpectrumInput, TextureId, TexturePoint, Textures};

/// Relative refractive indices that a dielectric may have.
const INDICES: RangeInclusive<f32> = 1e-3..=1e3;

/// What a surface is made of.
///
/// Values of textures are brought into their range where they are used, so that a [`Bsdf`] never creates
/// energy: shares of light are clamped to [0, 1], refractive indices and absorption are at least 0, what is
/// not a number is 0.
/// [`Material::check`] finds constants out of range beforehand.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Material {
    /// Lambert's law.
    Diffuse {
        /// Share of light reflected.
        reflectance: SpectrumInput,
    },
    /// Perfect mirror.
    Mirror {
        /// Share of light reflected.
        reflectance: SpectrumInput,
    },
    /// Smooth metal.
    Conductor {
        /// Refractive index relative to the surrounding medium.
        eta: SpectrumInput,
        /// Absorption coefficient.
        k: SpectrumInput,
        /// Factor on what is reflected; for plain metal 1 in all lanes in use.
        tint: SpectrumInput,
    },
    /// Smooth glass.
    Dielectric {
        /// Refractive index inside over outside, in [0.001, 1000] (far beyond any medium; squares still fit `f32`); a
        /// texture's value outside counts as 1.
        eta: FloatInput,
        /// Factor on what is reflected.
        reflectance: SpectrumInput,
        /// Factor on what is transmitted.
        transmittance: SpectrumInput,
        /// Whether it is a sheet that does not displace rays.
        thin: bool,
    },
    /// The Phong model; see [`Phong::new`] for what becomes of too much energy.
    Phong {
        /// Reaction to ambient light, only of the classical model.
        ambient: SpectrumInput,
        /// Diffuse coefficient.
        diffuse: SpectrumInput,
        /// Specular coefficient.
        specular: SpectrumInput,
        /// Sharpness of the highlight.
        exponent: FloatInput,
    },
    /// No surface at all: rays pass.
    Interface,
}

/// Why a material is not possible.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MaterialError {
    /// A parameter refers to a texture that is not there.
    #[error("{parameter} refers to a texture that does not exist")]
    Texture {
        /// Name of the parameter.
        parameter: &'static str,
    },
    /// A constant is not finite or out of range.
    #[error("{parameter} is {value}, it has to be {range}")]
    Range {
        /// Name of the parameter.
        parameter: &'static str,
        /// The value, of a spectrum the first lane out of range.
        value: f32,
        /// The range in words.
        range: &'static str,
    },
}

impl Material {
    /// What the material does at a point; `None` for [`Material::Interface`].
    #[must_use]
    pub fn bsdf(&self, textures: &Textures, at: &TexturePoint, wavelengths: &Wavelengths) -> Option<Bsdf> {
        let positive = |input: &SpectrumInput| textures.spectrum(input, at, wavelengths).map(|x| x.max(0.0));
        let share = |input: &SpectrumInput| positive(input).map(|x| x.min(1.0));
        let float = |input: &FloatInput| textures.float(input, at, wavelengths);
        let bsdf = match self {
            Self::Diffuse { reflectance } => match share(reflectance) {
                black if black.is_black() => Bsdf::Black,
                reflectance => Bsdf::Lambert(Lambert { reflectance }),
            },
            Self::Mirror { reflectance } => match share(reflectance) {
                black if black.is_black() => Bsdf::Black,
                reflectance => Bsdf::Mirror(Mirror { reflectance }),
            },
            Self::Conductor { eta, k, tint } => {
                Bsdf::Conductor(Conductor { eta: positive(eta), k: positive(k), tint: share(tint) })
            }
            Self::Dielectric { eta, reflectance, transmittance, thin } => {
                let eta = float(eta);
                Bsdf::Dielectric(Dielectric {
                    eta: if INDICES.contains(&eta) { f64::from(eta) } else { 1.0 },
                    reflectance: share(reflectance),
                    transmittance: share(transmittance),
                    thin: *thin,
                })
            }
            Self::Phong { ambient, diffuse, specular, exponent } => Bsdf::Phong(Phong::new(Coefficients {
                ambient: positive(ambient),
                diffuse: positive(diffuse),
                specular: positive(specular),
                exponent: f64::from(float(exponent)),
            })),
            Self::Interface => return None,
        };
        Some(bsdf)
    }

    /// Whether rays pass as if there were no surface.
    #[must_use]
    pub fn is_interface(&self) -> bool {
        matches!(self, Self::Interface)
    }

    /// Whether every texture exists and every constant is in its range.
    ///
    /// Shares of light above 1 are allowed (scene files hold 1.0001), they are clamped.
    ///
    /// # Errors
    /// [`MaterialError`] for the first parameter that is not possible.
    pub fn check(&self, textures: &Textures) -> Result<(), MaterialError> {
        let known = |parameter, id: TextureId| match textures.get(id) {
            Some(_) => Ok(()),
            None => Err(MaterialError::Texture { parameter }),
        };
        let spectrum = |parameter, input: &SpectrumInput| match input {
            SpectrumInput::Texture(id) => known(parameter, *id),
            SpectrumInput::Constant(value) => match first_outside(*value) {
                Some(value) => {
                    Err(MaterialError::Range { parameter, value, range: "a number of at least 0" })
                }
                None => Ok(()),
            },
        };
        let float = |parameter, input: &FloatInput, allowed: RangeInclusive<f32>, range| match input {
            FloatInput::Texture(id) => known(parameter, *id),
            FloatInput::Constant(value) if allowed.contains(value) => Ok(()),
            FloatInput::Constant(value) => Err(MaterialError::Range { parameter, value: *value, range }),
        };
        match self {
            Self::Diffuse { reflectance } | Self::Mirror { reflectance } => {
                spectrum("reflectance", reflectance)
            }
            Self::Conductor { eta, k, tint } => {
                spectrum("eta", eta)?;
                spectrum("k", k)?;
                spectrum("reflectance", tint)
            }
            Self::Dielectric { eta, reflectance, transmittance, .. } => {
                float("eta", eta, INDICES, "a number between 0.001 and 1000")?;
                spectrum("reflectance", reflectance)?;
                spectrum("transmittance", transmittance)
            }
            Self::Phong { ambient, diffuse, specular, exponent } => {
                spectrum("ambient", ambient)?;
                spectrum("diffuse", diffuse)?;
                spectrum("specular", specular)?;
                float("exponent", exponent, 0.0..=f32::MAX, "a number of at least 0")
            }
            Self::Interface => Ok(()),
        }
    }

    /// The largest sum of constant diffuse and specular coefficients, where it is above 1 and transport
    /// scales it down.
    ///
    /// For a warning; textured coefficients are not looked at.
    #[must_use]
    pub fn energy_excess(&self) -> Option<f32> {
        match self {
            Self::Phong {
                diffuse: SpectrumInput::Constant(diffuse),
                specular: SpectrumInput::Constant(specular),
                ..
            } => Some((*diffuse + *specular).max_component()).filter(|&sum| sum > 1.0),
            _ => None,
        }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::texture::Texture;
    use glanz_math::{DVec2, DVec3};

    const RGB: Wavelengths = Wavelengths::Rgb;

    fn point() -> TexturePoint {
        TexturePoint::new(DVec2::ZERO, DVec3::ZERO)
    }

    fn grey(value: f32) -> SpectrumInput {
        Spectrum::from_rgb([value; 3]).into()
    }

    #[test]
    fn reflectance_out_of_range_is_clamped() {
        let mut textures = Textures::new();
        let wild = textures.add(Texture::Constant(Spectrum::from_rgb([1.5, -0.5, f32::NAN]))).unwrap();
        let material = Material::Diffuse { reflectance: SpectrumInput::Texture(wild) };
        assert_eq!(material.check(&textures), Ok(()));
        let bsdf = material.bsdf(&textures, &point(), &RGB).unwrap();
        assert_eq!(bsdf.albedo(DVec3::Z).to_rgb(&RGB), [1.0, 0.0, 0.0]);
    }

    #[test]
    fn interface_has_no_bsdf_and_black_absorbs() {
        let textures = Textures::new();
        assert_eq!(Material::Interface.bsdf(&textures, &point(), &RGB), None);
        assert!(Material::Interface.is_interface());
        let black = Material::Diffuse { reflectance: grey(0.0) };
        assert_eq!(black.bsdf(&textures, &point(), &RGB), Some(Bsdf::Black));
    }

    #[test]
    fn impossible_constants_are_found_with_their_values() {
        let textures = Textures::new();
        let glass = |eta: f32| Material::Dielectric {
            eta: eta.into(),
            reflectance: grey(1.0),
            transmittance: grey(1.0),
            thin: false,
        };
        assert_eq!(glass(1.5).check(&textures), Ok(()));
        for eta in [0.0, -1.5, 1e-4, 1001.0, f32::INFINITY] {
            let error = MaterialError::Range {
                parameter: "eta",
                value: eta,
                range: "a number between 0.001 and 1000",
            };
            assert_eq!(glass(eta).check(&textures), Err(error));
        }
        let negative = Material::Mirror { reflectance: grey(-0.25) };
        assert!(matches!(negative.check(&textures), Err(MaterialError::Range { value: -0.25, .. })));
        let mut others = Textures::new();
        let foreign = SpectrumInput::Texture(others.add(Texture::Constant(Spectrum::ONE)).unwrap());
        let error = Material::Mirror { reflectance: foreign }.check(&textures);
        assert_eq!(error, Err(MaterialError::Texture { parameter: "reflectance" }));
    }

    #[test]
    fn phong_that_would_create_energy_says_so() {
        let phong = |diffuse, specular| Material::Phong {
            ambient: grey(0.1),
            diffuse: grey(diffuse),
            specular: grey(specular),
            exponent: 20.0.into(),
        };
        assert_eq!(phong(0.5, 0.5).energy_excess(), None);
        assert_eq!(phong(0.75, 0.5).energy_excess(), Some(1.25));
    }

    #[test]
    fn plain_metal_uses_no_lane_beyond_the_colours() {
        let gold = Material::Conductor {
            eta: Spectrum::from_rgb([0.143, 0.375, 1.442]).into(),
            k: Spectrum::from_rgb([3.983, 2.386, 1.603]).into(),
            tint: grey(1.0),
        };
        let albedo = gold.bsdf(&Textures::new(), &point(), &RGB).unwrap().albedo(DVec3::Z);
        let [r, g, b] = albedo.to_rgb(&RGB);
        assert!(r > 0.95 && g < 0.85 && b < 0.4, "gold is yellow: {r} {g} {b}");
        assert!(albedo.max_component() == r, "the fourth lane stays dark");
    }
}
