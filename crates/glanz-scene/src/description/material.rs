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
    /// Detail that changes the shading normal.
    pub surface_detail: Option<SurfaceDetailDescription>,
    /// Its place in the input.
    pub location: Option<Location>,
}

/// Detail of a surface that is too fine for its geometry: it changes the normal for shading, not the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SurfaceDetailDescription {
    /// The height above the surface along its normal, metres.
    Bump(FloatParameter),
    /// Index into [`Description::images`](super::Description::images) of a picture of normals: red, green and blue from 0 to 1 are the components from
    /// -1 to 1 along the derivative of the position by u, across it and along the normal.
    NormalMap(usize),
}

impl From<MaterialKind> for MaterialDescription {
    fn from(kind: MaterialKind) -> Self {
        Self { name: String::new(), kind, surface_detail: None, location: None }
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
