//! Participating media.

use std::sync::Arc;

use glanz_light::SpectralDistribution;
use glanz_math::{DMat4, DVec3};

use super::Location;

/// Something between surfaces that absorbs, scatters or emits light, such as fog, smoke or the inside of coloured glass.
#[derive(Clone, Debug)]
pub struct MediumDescription {
    /// Its name in the scene; empty if it has none.
    pub name: String,
    /// Absorption, 1/m.
    pub absorption: SpectralDistribution,
    /// Scattering, 1/m.
    pub scattering: SpectralDistribution,
    /// Factor on `absorption` and `scattering`.
    pub scale: f32,
    /// Asymmetry parameter: mean cosine of the scattering angle, between -1 and 1.
    pub g: f64,
    /// Radiance, W/(m^2 sr), that the medium emits where it absorbs; only without `density`.
    pub emission: SpectralDistribution,
    /// Factor on `emission`.
    pub emission_scale: f32,
    /// A factor on absorption and scattering from point to point; `None`: 1 everywhere.
    pub density: Option<DensityDescription>,
    /// Its place in the input.
    pub location: Option<Location>,
}

impl MediumDescription {
    /// The same medium everywhere, with absorption and scattering, 1/m, that scatters alike in all directions.
    #[must_use]
    pub fn new(
        absorption: impl Into<SpectralDistribution>,
        scattering: impl Into<SpectralDistribution>,
    ) -> Self {
        Self {
            name: String::new(),
            absorption: absorption.into(),
            scattering: scattering.into(),
            scale: 1.0,
            g: 0.0,
            emission: SpectralDistribution::Constant(0.0),
            emission_scale: 1.0,
            density: None,
            location: None,
        }
    }
}

/// Densities at the middles of the cells of a box, between which they are linear along each axis; outside of the grid they count as 0.
#[derive(Clone, Debug)]
pub struct DensityDescription {
    /// Number of cells along x, y and z.
    pub resolution: [u32; 3],
    /// Densities, at least 0, x fastest.
    pub values: Arc<[f32]>,
    /// Two opposite corners of the box, in the frame of the medium.
    pub corners: [DVec3; 2],
    /// Transformation from the frame of the medium to world space.
    pub to_world: DMat4,
}

/// The media on both sides of a surface, as indices into [`Description::media`](super::Description::media); `None` is empty space. If they are the
/// same, the surface lies within whatever medium is around it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SurfaceMedia {
    /// Opposite to the normal.
    pub inside: Option<usize>,
    /// On the side of the normal.
    pub outside: Option<usize>,
}
