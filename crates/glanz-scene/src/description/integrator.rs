//! Sampler and integrator.

use super::{GuideSettings, Location, PhotonSettings};

/// A sampler.
#[derive(Clone, Debug, PartialEq)]
pub struct SamplerDescription {
    /// Name in the table of `glanz-sampling`.
    pub name: String,
    /// Samples per pixel.
    pub samples_per_pixel: u32,
    /// Seed.
    pub seed: u64,
}

impl Default for SamplerDescription {
    fn default() -> Self {
        Self { name: "sobol".to_owned(), samples_per_pixel: 16, seed: 0 }
    }
}

/// An integrator.
#[derive(Clone, Debug, PartialEq)]
pub struct IntegratorDescription {
    /// Name in the table of `glanz-transport`.
    pub name: String,
    /// Largest number of scattering events per path.
    pub max_depth: Option<u32>,
    /// Whether lights are sampled at every hit.
    pub light_sampling: bool,
    /// Number of rays with which `path` and `distributed` continue from the first rough surface, at least 1; `None` for their defaults.
    pub branching: Option<u32>,
    /// Guide of `guided`.
    pub guide: GuideSettings,
    /// Photons of `sppm`.
    pub photons: PhotonSettings,
    /// Whether each sample carries light at four wavelengths of its own instead of red, green and blue.
    pub spectral: bool,
    /// Its place in the input.
    pub location: Option<Location>,
}

impl IntegratorDescription {
    /// Selects the integrator `name`. Another one than before has its own default number of rays: the number was meant for the one before.
    pub fn select(&mut self, name: &str) {
        if self.name != name {
            name.clone_into(&mut self.name);
            self.branching = None;
        }
    }
}

impl Default for IntegratorDescription {
    fn default() -> Self {
        Self {
            name: "path".to_owned(),
            max_depth: None,
            light_sampling: true,
            branching: None,
            guide: GuideSettings::Tree,
            photons: PhotonSettings::default(),
            spectral: false,
            location: None,
        }
    }
}
