//! Classical ray tracing.

use glanz_light::Spectrum;
use glanz_scene::{Light, LightId};
use glanz_shading::Bsdf;
use glanz_shading::model::phong::{ClassicLight, PhongCoefficients, classic, classic_ambient};

use super::vertex::Vertex;
use super::{Context, Integrator, IntegratorSettings, mirrors};

/// Classical ray tracing: direct light, perfect mirrors and refraction; no light is scattered twice by a rough surface.
///
/// - `Phong` materials are shaded as in document 001 section 3.4, with the departures of
///   [`classic`](glanz_shading::model::phong::classic). The intensity L of a light is the radiance of a white diffuse surface that faces it, irradiance / pi, so that the diffuse part is that of
///   Lambert's law; the ambient light S is that of the infinite lights, without shadows.
/// - Other rough materials are lit by every light: exactly by point and directional lights, with one random direction to each
///   area light and each infinite light, through surfaces that transmit one on either side to the same light from everywhere.
/// - Every light is tested for shadow by one ray.
/// - All directions of mirrors and glass are traced with their Fresnel weights, up to the depth limit and while
///   the weight of a ray at the viewer is at least [`SMALLEST_WEIGHT`](super::SMALLEST_WEIGHT).
#[derive(Clone, Copy, Debug)]
pub struct Whitted {
    max_depth: u32,
}

impl Whitted {
    /// With the depth of `settings`.
    #[must_use]
    pub fn new(settings: &IntegratorSettings) -> Self {
        Self { max_depth: settings.max_depth }
    }
}

impl Integrator for Whitted {
    fn radiance(&self, context: &mut Context<'_>) -> Spectrum {
        mirrors::radiance(context, self.max_depth, &|context, vertex, _| match vertex.bsdf {
            Bsdf::Phong(phong) => phong_light(context, vertex, phong.coefficients()),
            _ => direct_light(context, vertex),
        })
    }
}

fn light_ids(context: &Context<'_>) -> impl Iterator<Item = LightId> + use<> {
    (0..context.scene.lights().len() as u32).map(LightId)
}

/// Light of all lights that a rough surface scatters to the viewer.
fn direct_light(context: &mut Context<'_>, vertex: &Vertex<'_>) -> Spectrum {
    let mut behind = *vertex.at;
    behind.wo = -behind.wo;
    let mut light = Spectrum::BLACK;
    for id in light_ids(context) {
        let xi = context.sampler.next_2d();
        light += vertex.light(context, id, xi, |_, _, _| 1.0);
        // The samples of such a light lie on the side of the viewer only.
        if vertex.bsdf.transmits() && matches!(context.scene.light(id), Some(Light::Infinite(_))) {
            let sample = context.scene.sample_light(id, &behind, xi);
            if let Some((beyond, shadow)) = vertex.sampled_light(context, id, sample, |_, _, _| 1.0)
                && context.is_free(&shadow.ray, shadow.t_max)
            {
                light += beyond;
            }
        }
    }
    light
}

/// Document 001 section 3.4.
fn phong_light(context: &mut Context<'_>, vertex: &Vertex<'_>, surface: &PhongCoefficients) -> Spectrum {
    let normal = vertex.normal_to_viewer();
    let mut ambient = Spectrum::BLACK;
    let mut light = Spectrum::BLACK;
    for id in light_ids(context) {
        if let Some(Light::Infinite(infinite)) = context.scene.light(id) {
            ambient += context.light_at(id, infinite.radiance());
            continue;
        }
        let xi = context.sampler.next_2d();
        let Some(sample) = context.scene.sample_light(id, vertex.at, xi) else {
            continue;
        };
        // The surface shadows light on its back, as in `Vertex::eval`.
        let lit = vertex.at.point.normal.dot(sample.wi) * vertex.at.point.normal.dot(vertex.at.wo) > 0.0;
        let radiance = context.light_at(id, sample.radiance);
        let intensity = radiance * (std::f64::consts::FRAC_1_PI / sample.pdf.0) as f32;
        let source = ClassicLight { direction: sample.wi, diffuse: intensity, specular: intensity };
        let scattered = classic(surface, normal, vertex.at.wo, &source);
        if lit && !scattered.is_black() && context.is_free(&sample.shadow, sample.t_max) {
            light += scattered;
        }
    }
    light + classic_ambient(surface, ambient)
}
