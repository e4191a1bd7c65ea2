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
