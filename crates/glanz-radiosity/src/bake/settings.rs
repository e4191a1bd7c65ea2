//! Settings, methods and errors of a bake.

use glanz_job::Interrupted;

use crate::elements::ElementError;
use crate::reconstruct::{Interpolation, ReconstructError};
use crate::solve::hierarchical::HierarchicalError;

/// Largest number of texels over all charts.
pub(super) const MAX_TEXELS: usize = 1 << 24;

/// Largest memory of the light that elements exchange, bytes.
pub(super) const MAX_LINK_BYTES: usize = 2 << 30;

/// Accuracy and method of light maps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BakeSettings {
    /// Smallest number of texels per metre, above 0.
    pub density: f64,
    /// Number of rays of a final gather from a point. The number of rays from an element does not depend on it: 256, with
    /// [`BakeMethod::Radiosity`] 128.
    pub rays: u32,
    /// Largest number of shadow rays from a texel to a light.
    pub shadow_rays: u32,
    /// Computation of indirect light.
    pub method: BakeMethod,
}

impl Default for BakeSettings {
    fn default() -> Self {
        Self { density: 50.0, rays: 512, shadow_rays: 256, method: BakeMethod::Gather }
    }
}

/// Method for the computation of indirect light.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum BakeMethod {
    /// Final gather: rays over the hemisphere from points of each chart.
    #[default]
    Gather,
    /// Hierarchical solver, with elements as large as its error bound allows: a preview in a tenth of the time. The elements of a scene
    /// that needs more of them than memory allows (about 800 000) are larger: see [`CoarseElements`].
    Radiosity {
        /// Interpolation of the light of elements on texels.
        reconstruction: Interpolation,
    },
}

impl BakeMethod {
    /// Name in messages.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Gather => "gather",
            Self::Radiosity { reconstruction } => reconstruction.name(),
        }
    }

    /// Number in files: 0 for the gather, then the interpolations in the order of [`Interpolation::ALL`].
    #[must_use]
    pub fn number(&self) -> u8 {
        (0..)
            .zip(Self::all())
            .find(|(_, method)| method.name() == self.name())
            .map_or(0, |(number, _)| number)
    }

    /// The method with a number; `None` if there is none.
    #[must_use]
    pub fn from_number(number: u8) -> Option<Self> {
        Self::all().nth(usize::from(number))
    }

    /// The method with a name; `None` if there is none.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::all().find(|method| method.name() == name)
    }

    fn all() -> impl Iterator<Item = Self> {
        let by_solver =
            Interpolation::ALL.into_iter().map(|reconstruction| Self::Radiosity { reconstruction });
        std::iter::once(Self::Gather).chain(by_solver)
    }
}

/// Elements of the hierarchical solver that are larger than its error bound requires, because more elements would take more memory than
/// allowed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoarseElements {
    /// Number of elements.
    pub count: usize,
    /// Largest error of the light between two groups of elements, relative to the flux of the scene.
    pub error: f64,
    /// The bound on `error`, which it exceeds.
    pub bound: f64,
}

/// Error of a bake.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BakeError {
    /// The number of texels per metre is not positive and finite.
    #[error("light maps have {0} texels per metre; the number must be above 0 and finite")]
    Density(f64),
    /// Texels per metre that make more texels than can be stored, and the number of these.
    #[error("{0} texels per metre make {1} texels, more than {MAX_TEXELS}; choose a lower density")]
    TooMany(f64, usize),
    /// The light that this number of elements exchange would take more memory than allowed.
    #[error(
        "light between {0} elements takes more than {gib} GiB of memory; choose longer elements or a scene with fewer faces",
        gib = MAX_LINK_BYTES >> 30
    )]
    Memory(usize),
    /// The state to resume from belongs to other elements or another method.
    #[error(
        "the saved state belongs to other elements or another method; resume with the scene and the settings that it was saved with"
    )]
    State,
    /// The light between surfaces still changes after this number of rounds.
    #[error(
        "light between surfaces still grows after {0} rounds: a closed room that absorbs nothing has no end of it; choose reflectances below 1"
    )]
    NotConverged(u32),
    /// A part of a bake with the hierarchical solver.
    #[error("the hierarchical solver is one computation, which has no parts")]
    Indivisible,
    /// The scene cannot be divided into elements.
    #[error(transparent)]
    Elements(#[from] ElementError),
    /// The interpolation refuses its exponent, or has no solution with it.
    #[error(transparent)]
    Interpolation(#[from] ReconstructError),
    /// The solver refuses its settings.
    #[error(transparent)]
    Solver(#[from] HierarchicalError),
    /// The bake was cancelled.
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
}
