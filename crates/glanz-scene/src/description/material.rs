//! Materials.

use glanz_shading::{Material, ParameterForm};

use super::Location;
use super::texture::{FloatParameter, SpectrumParameter};

/// A material.
#[derive(Clone, Debug)]
pub struct MaterialDescription {
    /// Its name, if it has one.
    pub name: String,
    /// The scattering model with its parameters.
    pub kind: MaterialKind,
    /// Its place in the input.
    pub location: Option<Location>,
}

impl From<MaterialKind> for MaterialDescription {
    fn from(kind: MaterialKind) -> Self {
        Self { name: String::new(), kind, location: None }
    }
}

/// The form of parameters in a description: spectral distributions, and textures by their index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DescriptionForm {}

impl ParameterForm for DescriptionForm {
    type Spectrum = SpectrumParameter;
    type Float = FloatParameter;
}

/// The materials. `glanz_shading::model` has a file for each.
pub type MaterialKind = Material<DescriptionForm>;
