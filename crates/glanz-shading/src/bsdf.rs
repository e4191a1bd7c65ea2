//! Scattering of light at a point of a surface, in its local frame.

use glanz_light::Spectrum;
use glanz_math::{DVec2, DVec3, SolidAnglePdf};
use glanz_sampling::sequence::{owen, sobol};

use crate::preview::PreviewSurface;

/// The quantity that is transported along a path.
///
/// Radiance changes by the squared ratio of refractive indices when light is refracted, importance does not.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TransportMode {
    /// The path starts at the camera and gathers radiance.
    Radiance,
    /// The path starts at a light and carries flux.
    Importance,
}

/// Angular width of a lobe.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Spread {
    /// Over the whole hemisphere.
    Diffuse,
    /// Around one direction.
    Glossy,
    /// Into a single direction: a delta distribution.
    Specular,
}

/// A part of a BSDF that samples are drawn from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Lobe {
    /// Angular width.
    pub spread: Spread,
    /// Whether it leads to the other side of the surface.
    pub transmission: bool,
}

impl Lobe {
    /// Diffuse reflection.
    pub const DIFFUSE: Self = Self { spread: Spread::Diffuse, transmission: false };
    /// Diffuse transmission.
    pub const DIFFUSE_TRANSMISSION: Self = Self { spread: Spread::Diffuse, transmission: true };
    /// A highlight.
    pub const GLOSSY: Self = Self { spread: Spread::Glossy, transmission: false };
    /// A blurred refracted image.
    pub const GLOSSY_TRANSMISSION: Self = Self { spread: Spread::Glossy, transmission: true };
    /// A mirror image.
    pub const SPECULAR_REFLECTION: Self = Self { spread: Spread::Specular, transmission: false };
    /// A refracted image.
    pub const SPECULAR_TRANSMISSION: Self = Self { spread: Spread::Specular, transmission: true };

    /// All kinds.
    pub const ALL: &'static [Self] = &[
        Self::DIFFUSE,
        Self::DIFFUSE_TRANSMISSION,
        Self::GLOSSY,
        Self::GLOSSY_TRANSMISSION,
        Self::SPECULAR_REFLECTION,
        Self::SPECULAR_TRANSMISSION,
    ];

    /// Whether it scatters into a single direction.
    #[must_use]
    pub fn is_delta(self) -> bool {
        self.spread == Spread::Specular
    }
}

/// A direction drawn from a BSDF.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BsdfSample {
    /// The sampled direction, away from the surface; unit length.
    pub wi: DVec3,
    /// `f |cos| / pdf`, the factor on the throughput; for a delta lobe its reflectance or transmittance over the probability of its
    /// selection.
    pub weight: Spectrum,
    /// `f |cos|` as of [`BsdfModel::eval`], with the factor of refraction for importance; black for a delta lobe.
    pub value: Spectrum,
    /// Density of `wi` as of [`BsdfModel::pdf`]; infinite for a delta lobe, so that multiple importance sampling
    /// gives it all the weight.
    pub pdf: SolidAnglePdf,
    /// The lobe it was drawn from.
    pub lobe: Lobe,
    /// The factor that undoes the change of radiance by refraction: (eta_i / eta_o)^2 with `TransportMode::Radiance`, else 1.
    ///
    /// Russian roulette should use the throughput times the product of these, or it ends paths inside glass.
    pub eta_scale: f32,
}

impl BsdfSample {
    /// A sample of a delta lobe.
    pub(crate) fn delta(wi: DVec3, weight: Spectrum, lobe: Lobe) -> Self {
        Self { wi, weight, value: Spectrum::BLACK, pdf: SolidAnglePdf(f64::INFINITY), lobe, eta_scale: 1.0 }
    }

    /// The sample of the direction `wi`, by the value and the density that `model` states for it; `None` where it scatters nothing.
    pub(crate) fn of_direction<M: BsdfModel>(
        model: &M,
        [wo, wi]: [DVec3; 2],
        lobe: Lobe,
        mode: TransportMode,
    ) -> Option<Self> {
        let (value, pdf) = (model.eval(wo, wi), model.pdf(wo, wi));
        if !(pdf.0 > 0.0 && pdf.0.is_finite()) || value.is_black() {
            return None;
        }
        let weight = value.map(|x| (f64::from(x) / pdf.0) as f32);
        let scale = model.eta_scale(wo, wi);
        Some(match mode {
            TransportMode::Radiance => Self { wi, weight, value, pdf, lobe, eta_scale: scale },
            TransportMode::Importance => {
                Self { wi, weight: weight * scale, value: value * scale, pdf, lobe, eta_scale: 1.0 }
            }
        })
    }
}

/// A scattering model at a point. `tests/it/contract.rs` runs over all of them.
///
/// The frame: z is the shading normal, all directions have unit length and point away from the surface.
/// Reflecting models do the same on both sides; only [`Dielectric`](crate::model::Dielectric) and models with a part of it have an inside (z < 0) and an
/// outside.
/// The tangents x and y are those of the surface's parameters if the model is anisotropic, else any.
///
/// A model has to state its lobes and draw samples. The other methods have defaults: those of an isotropic model with delta lobes only,
/// and an estimate of the albedo.
pub trait BsdfModel {
    /// The lobes that [`BsdfModel::sample`] may draw from.
    const LOBES: &'static [Lobe];

    /// Draws a direction; `None` where nothing is scattered.
    ///
    /// `xi` selects the direction within a lobe, `xi_lobe` the lobe; all in [0, 1).
    fn sample(&self, wo: DVec3, xi: DVec2, xi_lobe: f64, mode: TransportMode) -> Option<BsdfSample>;

    /// `f |cos theta_i|` without delta lobes, per steradian: the factor on radiance from `wi` that continues to `wo`.
    fn eval(&self, _wo: DVec3, _wi: DVec3) -> Spectrum {
        Spectrum::BLACK
    }

    /// The density with which [`BsdfModel::sample`] draws `wi`, without delta lobes.
    fn pdf(&self, _wo: DVec3, _wi: DVec3) -> SolidAnglePdf {
        SolidAnglePdf(0.0)
    }

    /// Whether there are only delta lobes: [`BsdfModel::eval`] is black everywhere, and lights need not be sampled.
    fn is_delta(&self) -> bool {
        !Self::LOBES.is_empty() && Self::LOBES.iter().all(|lobe| lobe.is_delta())
    }

    /// Whether the model holds for the hero of sampled wavelengths alone: light at the others ends here.
    fn is_dispersive(&self) -> bool {
        false
    }

    /// Whether scattering depends on the tangents.
    fn is_anisotropic(&self) -> bool {
        false
    }

    /// Whether [`BsdfModel::eval`] can lead to the other side of the surface.
    fn transmits(&self) -> bool {
        Self::LOBES.iter().any(|lobe| lobe.transmission && !lobe.is_delta())
    }

    /// The factor as of [`BsdfSample::eta_scale`] of [`BsdfModel::eval`].
    fn eta_scale(&self, _wo: DVec3, _wi: DVec3) -> f32 {
        1.0
    }

    /// All delta lobes, each with the whole fraction of light it carries as weight, to follow every one of them.
    ///
    /// Reflection comes first, then transmission; black ones are left out. The default is for models without delta lobes and for those of a
    /// single lobe.
    fn delta_branches(&self, wo: DVec3, mode: TransportMode) -> [Option<BsdfSample>; 2] {
        let only =
            || self.sample(wo, DVec2::splat(0.5), 0.5, mode).filter(|sample| !sample.weight.is_black());
        [if self.is_delta() { only() } else { None }, None]
    }

    /// Probability with which [`BsdfModel::sample`] draws by the cosine to the normal from [`Lobe::DIFFUSE`]: it does so where `xi_lobe`
    /// is less.
    fn diffuse_probability(&self, _wo: DVec3) -> f64 {
        0.0
    }

    /// Fraction of the light from `wo` that is scattered into all directions; by reciprocity also the radiance under a white sky.
    ///
    /// The default is the mean weight of 64 samples.
    fn albedo(&self, wo: DVec3) -> Spectrum {
        estimated_albedo(self, wo)
    }

    /// The fraction of the light from `wo` that is scattered to its own side; of clear glass without other lobes the albedo.
    fn reflected(&self, wo: DVec3) -> Spectrum {
        if self.is_delta() || !Self::LOBES.iter().any(|lobe| lobe.transmission) {
            self.albedo(wo)
        } else {
            mean_weight(self, wo, |sample| !sample.lobe.transmission)
        }
    }

    /// Whether everything is absorbed, so that no lights need to be sampled.
    fn is_black(&self) -> bool {
        false
    }

    /// The appearance in a rasteriser.
    fn preview(&self) -> PreviewSurface {
        let albedo = self.albedo(DVec3::Z);
        if self.is_delta() { PreviewSurface::metal(albedo) } else { PreviewSurface::diffuse(albedo) }
    }
}

impl<M: BsdfModel> BsdfModel for Box<M> {
    const LOBES: &'static [Lobe] = M::LOBES;

    fn sample(&self, wo: DVec3, xi: DVec2, xi_lobe: f64, mode: TransportMode) -> Option<BsdfSample> {
        (**self).sample(wo, xi, xi_lobe, mode)
    }

    fn eval(&self, wo: DVec3, wi: DVec3) -> Spectrum {
        (**self).eval(wo, wi)
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> SolidAnglePdf {
        (**self).pdf(wo, wi)
    }

    fn is_delta(&self) -> bool {
        (**self).is_delta()
    }

    fn is_dispersive(&self) -> bool {
        (**self).is_dispersive()
    }

    fn is_anisotropic(&self) -> bool {
        (**self).is_anisotropic()
    }

    fn transmits(&self) -> bool {
        (**self).transmits()
    }

    fn eta_scale(&self, wo: DVec3, wi: DVec3) -> f32 {
        (**self).eta_scale(wo, wi)
    }

    fn delta_branches(&self, wo: DVec3, mode: TransportMode) -> [Option<BsdfSample>; 2] {
        (**self).delta_branches(wo, mode)
    }

    fn diffuse_probability(&self, wo: DVec3) -> f64 {
        (**self).diffuse_probability(wo)
    }

    fn albedo(&self, wo: DVec3) -> Spectrum {
        (**self).albedo(wo)
    }

    fn reflected(&self, wo: DVec3) -> Spectrum {
        (**self).reflected(wo)
    }

    fn is_black(&self) -> bool {
        (**self).is_black()
    }

    fn preview(&self) -> PreviewSurface {
        (**self).preview()
    }
}

/// The mean weight of 64 Sobol' points, in flux: without the change of radiance by refraction.
pub(crate) fn estimated_albedo<M: BsdfModel + ?Sized>(model: &M, wo: DVec3) -> Spectrum {
    mean_weight(model, wo, |_| true)
}

/// The part of the mean weight that is due to samples that `counts`.
fn mean_weight<M: BsdfModel + ?Sized>(
    model: &M,
    wo: DVec3,
    counts: impl Fn(&BsdfSample) -> bool,
) -> Spectrum {
    const COUNT: u32 = 64;
    let weight = |i| {
        // Each coordinate takes the multiples of 1 / 64 once: the middles of the steps have less error.
        let [x, y, lobe] =
            [0, 1, 2].map(|dimension| owen::unit(sobol::coordinate(i, dimension)) + 0.5 / f64::from(COUNT));
        let sample = model.sample(wo, DVec2::new(x, y), lobe, TransportMode::Importance);
        sample.filter(&counts).map(|sample| sample.weight)
    };
    let sum: Spectrum = (0..COUNT).filter_map(weight).sum();
    (sum * (1.0 / COUNT as f32)).map(|x| x.min(1.0))
}

/// Both directions, mirrored so that `wo` is above; `None` if `wo` is along the surface.
#[inline]
pub(crate) fn upper_side(wo: DVec3, wi: DVec3) -> Option<[DVec3; 2]> {
    let sign = 1.0_f64.copysign(wo.z);
    let up = |w: DVec3| DVec3::new(w.x, w.y, w.z * sign);
    (wo.z != 0.0).then(|| [up(wo), up(wi)])
}

/// Both directions, mirrored so that they are above; `None` unless they are strictly on one side of the surface.
#[inline]
pub(crate) fn both_above(wo: DVec3, wi: DVec3) -> Option<[DVec3; 2]> {
    if same_side(wo, wi) { upper_side(wo, wi) } else { None }
}

/// `wi` for `wo` above, mirrored for `wo` as it is.
#[inline]
pub(crate) fn to_side_of(wo: DVec3, wi: DVec3) -> DVec3 {
    DVec3::new(wi.x, wi.y, wi.z * 1.0_f64.copysign(wo.z))
}

/// Whether both directions are strictly on one side of the surface.
#[inline]
pub(crate) fn same_side(wo: DVec3, wi: DVec3) -> bool {
    wo.z * wi.z > 0.0
}
