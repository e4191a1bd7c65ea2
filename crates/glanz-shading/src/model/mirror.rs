//! Reflection in one direction, or with a surface finish around it.

use glanz_light::Spectrum;
use glanz_math::{DVec2, DVec3, SolidAnglePdf};

use super::finish::SurfaceFinish;
use super::{Material, MaterialModel, TexturedModel};
use crate::bsdf::{BsdfModel, BsdfSample, Lobe, TransportMode, both_above};
use crate::parameter::{MaterialError, ParameterForm, ParameterResolver, ShadingForm, TextureEvaluator};
use crate::preview::PreviewSurface;

/// A mirror with the same reflectance at every angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mirror<'a> {
    /// Fraction of light reflected, [0, 1].
    pub reflectance: Spectrum,
    /// Finish of the surface; `None` if it is perfect.
    pub finish: Option<&'a SurfaceFinish>,
}

impl BsdfModel for Mirror<'_> {
    const LOBES: &'static [Lobe] = &[Lobe::SPECULAR_REFLECTION, Lobe::GLOSSY];

    fn eval(&self, wo: DVec3, wi: DVec3) -> Spectrum {
        match (self.finish, both_above(wo, wi)) {
            (Some(finish), Some([wo, wi])) => self.reflectance * finish.value(wo, wi) as f32,
            _ => Spectrum::BLACK,
        }
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> SolidAnglePdf {
        SolidAnglePdf(match (self.finish, both_above(wo, wi)) {
            (Some(finish), Some([wo, wi])) => finish.pdf(wo, wi),
            _ => 0.0,
        })
    }

    /// The mirrored direction, or one of scattered light.
    fn sample(&self, wo: DVec3, xi: DVec2, xi_lobe: f64, mode: TransportMode) -> Option<BsdfSample> {
        match self.finish {
            Some(finish) => finish.sample(self, self.reflectance, wo, (xi, xi_lobe), mode),
            None => (wo.z != 0.0).then(|| mirror_image(wo, self.reflectance)),
        }
    }

    fn is_delta(&self) -> bool {
        self.finish.is_none()
    }

    fn delta_branches(&self, wo: DVec3, _: TransportMode) -> [Option<BsdfSample>; 2] {
        let image = || (wo.z != 0.0 && !self.is_black()).then(|| mirror_image(wo, self.reflectance));
        [self.finish.map_or_else(image, |finish| finish.mirror_image(self.reflectance, wo)), None]
    }

    fn albedo(&self, _: DVec3) -> Spectrum {
        self.reflectance
    }

    fn is_black(&self) -> bool {
        self.reflectance.is_black()
    }

    fn preview(&self) -> PreviewSurface {
        PreviewSurface::metal(self.reflectance)
    }
}

/// `wo` rotated by half a turn about z.
pub(super) fn mirrored(wo: DVec3) -> DVec3 {
    DVec3::new(-wo.x, -wo.y, wo.z)
}

/// The mirrored direction, of this weight.
pub(super) fn mirror_image(wo: DVec3, weight: Spectrum) -> BsdfSample {
    BsdfSample::delta(mirrored(wo), weight, Lobe::SPECULAR_REFLECTION)
}

/// The material of [`Mirror`].
#[derive(Clone, Debug, PartialEq)]
pub struct MirrorMaterial<P: ParameterForm = ShadingForm> {
    /// Fraction of light reflected, [0, 1].
    pub reflectance: P::Spectrum,
    /// Finish of the surface; `None` if it is perfect.
    pub finish: Option<SurfaceFinish>,
}

impl<P: ParameterForm> MaterialModel<P> for MirrorMaterial<P> {
    type Textured = MirrorMaterial;

    fn kind(&self) -> &'static str {
        "mirror"
    }

    fn resolve<R: ParameterResolver<P>>(&self, resolver: &R) -> Result<MirrorMaterial, MaterialError> {
        Ok(MirrorMaterial {
            reflectance: resolver.fraction("reflectance", &self.reflectance)?,
            finish: self.finish.clone().filter(|finish| finish.total_scatter() > 0.0),
        })
    }
}

impl TexturedModel for MirrorMaterial {
    type Bsdf<'a> = Mirror<'a>;

    fn bsdf(&self, at: &TextureEvaluator<'_>) -> Mirror<'_> {
        Mirror { reflectance: at.fraction(&self.reflectance), finish: self.finish.as_ref() }
    }
}

impl<P: ParameterForm> Material<P> {
    /// A perfect mirror, with the fraction of light reflected, [0, 1].
    #[must_use]
    pub fn mirror(reflectance: impl Into<P::Spectrum>) -> Self {
        Self::Mirror(MirrorMaterial { reflectance: reflectance.into(), finish: None })
    }
}
