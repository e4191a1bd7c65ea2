//! Materials.

use super::Location;
use super::texture::{FloatInput, SpectrumInput};

/// A material.
#[derive(Clone, Debug)]
pub struct MaterialDescription {
    /// Its name, if it has one.
    pub name: String,
    /// What it does with light.
    pub kind: MaterialKind,
    /// Where it was said.
    pub location: Option<Location>,
}

impl From<MaterialKind> for MaterialDescription {
    fn from(kind: MaterialKind) -> Self {
        Self { name: String::new(), kind, location: None }
    }
}

impl MaterialKind {
    /// Lambert's law, with the share of light reflected, [0, 1].
    #[must_use]
    pub fn diffuse(reflectance: impl Into<SpectrumInput>) -> Self {
        Self::Diffuse { reflectance: reflectance.into() }
    }

    /// A perfect mirror, with the share of light reflected, [0, 1].
    #[must_use]
    pub fn mirror(reflectance: impl Into<SpectrumInput>) -> Self {
        Self::Mirror { reflectance: reflectance.into() }
    }

    /// Smooth metal of refractive index `eta` and absorption coefficient `k`.
    #[must_use]
    pub fn conductor(eta: impl Into<SpectrumInput>, k: impl Into<SpectrumInput>) -> Self {
        Self::Conductor { eta: eta.into(), k: k.into() }
    }

    /// Smooth glass of refractive index `eta`, with factors on the light that it reflects and transmits.
    #[must_use]
    pub fn dielectric(
        eta: impl Into<FloatInput>,
        reflectance: impl Into<SpectrumInput>,
        transmittance: impl Into<SpectrumInput>,
    ) -> Self {
        let (eta, reflectance, transmittance) = (eta.into(), reflectance.into(), transmittance.into());
        Self::Dielectric { eta, reflectance, transmittance, thin: false }
    }

    /// The Phong model; `ambient` counts in the classical model only.
    #[must_use]
    pub fn phong(
        ambient: impl Into<SpectrumInput>,
        diffuse: impl Into<SpectrumInput>,
        specular: impl Into<SpectrumInput>,
        exponent: impl Into<FloatInput>,
    ) -> Self {
        let (ambient, diffuse, specular) = (ambient.into(), diffuse.into(), specular.into());
        Self::Phong { ambient, diffuse, specular, exponent: exponent.into() }
    }
}

/// The materials.
#[derive(Clone, Debug)]
pub enum MaterialKind {
    /// Lambert's law.
    Diffuse {
        /// Share of light reflected, [0, 1].
        reflectance: SpectrumInput,
    },
    /// Perfect mirror.
    Mirror {
        /// Share of light reflected, [0, 1].
        reflectance: SpectrumInput,
    },
    /// Smooth metal.
    Conductor {
        /// Refractive index.
        eta: SpectrumInput,
        /// Absorption coefficient.
        k: SpectrumInput,
    },
    /// Smooth glass, a solid piece or a pane.
    Dielectric {
        /// Refractive index inside over outside.
        eta: FloatInput,
        /// Factor on reflected light.
        reflectance: SpectrumInput,
        /// Factor on transmitted light.
        transmittance: SpectrumInput,
        /// Whether the surface is a pane with two faces, too thin to displace a ray, instead of the border of a solid.
        thin: bool,
    },
    /// The classical model (document 001 section 3.4).
    Phong {
        /// Ambient coefficient.
        ambient: SpectrumInput,
        /// Diffuse coefficient.
        diffuse: SpectrumInput,
        /// Specular coefficient.
        specular: SpectrumInput,
        /// Exponent of the specular lobe, >= 0.
        exponent: FloatInput,
    },
    /// No surface at all: rays pass.
    Interface,
}
