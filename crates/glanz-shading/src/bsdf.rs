//! What a point of a surface does with light, in its local frame.

use glanz_light::Spectrum;
use glanz_math::{DVec2, DVec3, SolidAnglePdf};

use crate::model::{Conductor, Dielectric, Lambert, Mirror, Phong};

/// What travels along a path.
///
/// Radiance changes by the squared ratio of refractive indices when light is refracted, importance does not.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TransportMode {
    /// The path starts at the camera and gathers radiance.
    Radiance,
    /// The path starts at a light and carries flux.
    Importance,
}

/// How widely a lobe scatters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Spread {
    /// Over the whole hemisphere.
    Diffuse,
    /// Around one direction.
    Glossy,
    /// Into a single direction: a delta distribution.
    Specular,
}

/// The part of a BSDF that a sample was drawn from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Lobe {
    /// How widely it scatters.
    pub spread: Spread,
    /// Whether it leads to the other side of the surface.
    pub transmission: bool,
}

impl Lobe {
    /// Lambert's.
    pub const DIFFUSE: Self = Self { spread: Spread::Diffuse, transmission: false };
    /// A highlight.
    pub const GLOSSY: Self = Self { spread: Spread::Glossy, transmission: false };
    /// A mirror image.
    pub const SPECULAR_REFLECTION: Self = Self { spread: Spread::Specular, transmission: false };
    /// A refracted image.
    pub const SPECULAR_TRANSMISSION: Self = Self { spread: Spread::Specular, transmission: true };

    /// Whether it scatters into a single direction.
    #[must_use]
    pub fn is_delta(self) -> bool {
        self.spread == Spread::Specular
    }
}

/// A direction drawn from a BSDF.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BsdfSample {
    /// Where to go on, away from the surface; unit length.
    pub wi: DVec3,
    /// `f |cos| / pdf`, what the throughput is multiplied by; for a delta lobe its share over the probability of its choice.
    pub weight: Spectrum,
    /// `f |cos|` as of [`Bsdf::eval`]; black for a delta lobe.
    pub value: Spectrum,
    /// Density of `wi` as of [`Bsdf::pdf`]; infinite for a delta lobe, so that multiple importance sampling
    /// gives it all.
    pub pdf: SolidAnglePdf,
    /// The lobe it comes from.
    pub lobe: Lobe,
    /// What undoes the change of radiance by refraction: (eta_i / eta_o)^2 with `TransportMode::Radiance`, else 1.
    ///
    /// Russian roulette should look at the throughput times the product of these, or it kills paths inside glass.
    pub eta_scale: f32,
}

impl BsdfSample {
    /// A sample of a delta lobe.
    pub(crate) fn delta(wi: DVec3, weight: Spectrum, lobe: Lobe) -> Self {
        Self { wi, weight, value: Spectrum::BLACK, pdf: SolidAnglePdf(f64::INFINITY), lobe, eta_scale: 1.0 }
    }
}

/// The closed set of scattering models. `tests/it/contract.rs` runs over all of them.
///
/// The frame: z is the shading normal, all directions have unit length and point away from the surface.
/// Reflecting models do the same on both sides; only [`Dielectric`] has an inside (z < 0) and an outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bsdf {
    /// Absorbs everything.
    Black,
    /// Lambert's law.
    Lambert(Lambert),
    /// Perfect mirror.
    Mirror(Mirror),
    /// Smooth metal.
    Conductor(Conductor),
    /// Smooth glass.
    Dielectric(Dielectric),
    /// Modified Phong model.
    Phong(Phong),
}

impl Bsdf {
    /// `f |cos theta_i|` without delta lobes, per steradian.
    #[must_use]
    pub fn eval(&self, wo: DVec3, wi: DVec3) -> Spectrum {
        match self {
            Self::Lambert(model) => model.eval(wo, wi),
            Self::Phong(model) => model.eval(wo, wi),
            Self::Black | Self::Mirror(_) | Self::Conductor(_) | Self::Dielectric(_) => Spectrum::BLACK,
        }
    }

    /// The density with which [`Bsdf::sample`] draws `wi`, without delta lobes.
    #[must_use]
    pub fn pdf(&self, wo: DVec3, wi: DVec3) -> SolidAnglePdf {
        match self {
            Self::Lambert(model) => model.pdf(wo, wi),
            Self::Phong(model) => model.pdf(wo, wi),
            Self::Black | Self::Mirror(_) | Self::Conductor(_) | Self::Dielectric(_) => SolidAnglePdf(0.0),
        }
    }

    /// Draws a direction; `None` where nothing is scattered.
    ///
    /// `xi` chooses the direction within a lobe, `xi_lobe` the lobe; all in [0, 1).
    #[must_use]
    pub fn sample(&self, wo: DVec3, xi: DVec2, xi_lobe: f64, mode: TransportMode) -> Option<BsdfSample> {
        match self {
            Self::Black => None,
            Self::Lambert(model) => model.sample(wo, xi),
            Self::Mirror(model) => model.sample(wo),
            Self::Conductor(model) => model.sample(wo),
            Self::Dielectric(model) => model.sample(wo, xi_lobe, mode),
            Self::Phong(model) => model.sample(wo, xi, xi_lobe),
        }
    }

    /// Probability with which [`Bsdf::sample`] draws from Lambert's lobe, by the cosine: that it does where `xi_lobe` is less.
    #[inline]
    #[must_use]
    pub fn diffuse_probability(&self) -> f64 {
        match self {
            Self::Lambert(_) => 1.0,
            Self::Phong(model) => model.diffuse_probability(),
            Self::Black | Self::Mirror(_) | Self::Conductor(_) | Self::Dielectric(_) => 0.0,
        }
    }

    /// All delta lobes, each with the whole share of light it carries as weight: for those who follow every one.
    ///
    /// Reflection comes first, then transmission; black ones are left out.
    #[must_use]
    pub fn delta_branches(&self, wo: DVec3, mode: TransportMode) -> [Option<BsdfSample>; 2] {
        let only = |sample: Option<BsdfSample>| [sample.filter(|s| !s.weight.is_black()), None];
        match self {
            Self::Black | Self::Lambert(_) | Self::Phong(_) => [None; 2],
            Self::Mirror(model) => only(model.sample(wo)),
            Self::Conductor(model) => only(model.sample(wo)),
            Self::Dielectric(model) => model.branches(wo, mode),
        }
    }

    /// Whether there are only delta lobes: [`Bsdf::eval`] is black everywhere, and lights need not be sampled.
    #[must_use]
    pub fn is_delta(&self) -> bool {
        match self {
            Self::Black | Self::Lambert(_) | Self::Phong(_) => false,
            Self::Mirror(_) | Self::Conductor(_) | Self::Dielectric(_) => true,
        }
    }

    /// Share of the light from `wo` that is scattered into all directions; by reciprocity also what a white sky
    /// gives back. For pictures of the albedo.
    #[must_use]
    pub fn albedo(&self, wo: DVec3) -> Spectrum {
        match self {
            Self::Black => Spectrum::BLACK,
            Self::Lambert(model) => model.reflectance,
            Self::Mirror(model) => model.reflectance,
            Self::Conductor(model) => model.reflectance_at(wo.z),
            Self::Dielectric(model) => model.albedo(wo),
            Self::Phong(model) => model.albedo(wo),
        }
    }
}

/// Whether both directions are strictly on one side of the surface.
#[inline]
pub(crate) fn same_side(wo: DVec3, wi: DVec3) -> bool {
    wo.z * wi.z > 0.0
}
