//! Materials of models, by the parameters of the metallic-roughness model.

use glanz_light::SpectralDistribution;
use glanz_scene::description::{
    FloatParameter, MaterialKind, SpectrumParameter, TextureDescription, TextureKind,
};

use super::ModelReader;

/// Parameters of a surface in the metallic-roughness model (@khr_gltf section 3.9, appendix B), with extensions.
pub(crate) struct SurfaceParameters {
    /// Reflectance of what scatters and of metal, and the tint of what passes.
    pub(crate) base_color: SpectrumParameter,
    /// 1 where it is metal, 0 where not.
    pub(crate) metallic: FloatParameter,
    /// Its mean: 0 is a mirror, 1 is matt.
    pub(crate) roughness: f32,
    /// Refractive index, in [1, 1000].
    pub(crate) ior: f32,
    /// Factors of the reflection of what is not metal.
    pub(crate) specular: [f32; 3],
    /// Share of the light that passes instead of being scattered.
    pub(crate) transmission: f32,
    /// Whether it is the border of a solid rather than a thin sheet.
    pub(crate) solid: bool,
}

/// Largest exponent: in `f32`, sharper lobes cannot be distinguished from a mirror.
const MAX_EXPONENT: f32 = 1e6;

impl ModelReader {
    /// The scattering model that stands in for the parameters: glass, or a diffuse surface with a highlight.
    pub(crate) fn surface_model(&mut self, parameters: SurfaceParameters) -> MaterialKind {
        let SurfaceParameters { base_color, metallic, roughness, ior, specular, transmission, solid } =
            parameters;
        if transmission >= 0.5 {
            return match solid {
                true => MaterialKind::dielectric(ior, 1.0, base_color),
                false => MaterialKind::thin_dielectric(ior, 1.0, base_color),
            };
        }
        let normal = ((ior - 1.0) / (ior + 1.0)).powi(2);
        let reflected = specular.map(|factor| (normal * factor).min(1.0));
        let rest = 1.0 - reflected.iter().copied().fold(0.0, f32::max);
        let scattered = match &base_color {
            SpectrumParameter::Value(SpectralDistribution::Rgb(color)) => color.map(|c| c * rest).into(),
            color => self.scaled(color.clone(), rest.into()),
        };
        let diffuse = self.mixed(scattered, 0.0.into(), metallic);
        let specular = self.mixed(reflected.into(), base_color, metallic);
        MaterialKind::phong(diffuse.clone(), diffuse, specular, exponent(roughness))
    }

    /// `a` where it is no metal, `b` where it is.
    fn mixed(
        &mut self,
        a: SpectrumParameter,
        b: SpectrumParameter,
        metallic: FloatParameter,
    ) -> SpectrumParameter {
        match (metallic, &a, &b) {
            (FloatParameter::Value(0.0), ..) => a,
            (FloatParameter::Value(1.0), ..) => b,
            (
                FloatParameter::Value(m),
                SpectrumParameter::Value(SpectralDistribution::Rgb(a)),
                SpectrumParameter::Value(SpectralDistribution::Rgb(b)),
            ) => [0, 1, 2].map(|i| a[i] + m * (b[i] - a[i])).into(),
            (amount, ..) => {
                let kind = TextureKind::Mix { a, b, amount };
                SpectrumParameter::Texture(self.add_texture(String::new(), kind))
            }
        }
    }

    /// A product of two inputs.
    pub(crate) fn scaled(&mut self, a: SpectrumParameter, b: SpectrumParameter) -> SpectrumParameter {
        SpectrumParameter::Texture(self.add_texture(String::new(), TextureKind::Scale(a, b)))
    }

    /// Adds a texture and returns its index.
    pub(crate) fn add_texture(&mut self, name: String, kind: TextureKind) -> usize {
        let textures = &mut self.description.textures;
        textures.push(TextureDescription { name, kind, location: None });
        textures.len() - 1
    }
}

/// The exponent of the lobe about as wide as that of a microfacet distribution of width `roughness^2` (@walter2007 section 5.2).
pub(crate) fn exponent(roughness: f32) -> f32 {
    let alpha = roughness * roughness;
    (2.0 / (alpha * alpha) - 2.0).clamp(0.0, MAX_EXPONENT)
}
