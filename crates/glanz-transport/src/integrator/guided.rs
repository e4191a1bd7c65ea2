//! Path tracing with directions sampled from a guide.

use std::f64::consts::PI;
use std::sync::Arc;

use glanz_light::{Spectrum, Wavelengths};
use glanz_math::{DVec2, DVec3};
use glanz_scene::description::GuideSettings;
use glanz_scene::{LightSampleContext, MAX_LIGHT_GROUPS, Scene, SelectedLight};

use super::path::BsdfDirections;
use super::path_state::SampledDirection;
use super::path_tracer::{DirectionSampler, PathTracer, RouletteState};
use super::vertex::{ScatteredRay, Vertex};
use super::{Context, Integrator, IntegratorSettings, grid_guided, radiance_of_one};
use crate::guide::{
    DirectionRecord, GridError, Guide, GuidedVertex, LightGroupRecord, PathRecords, Training, TreeGuide,
    density,
    survival::{self, brightness},
};

/// As [`Path`](super::Path), but at rough surfaces some of the directions are sampled from a guide.
///
/// The guide holds densities of the incident light of earlier passes. With a probability that is also learnt, the direction is sampled from
/// the guide, otherwise from the BSDF; the density is that of the mixture, also in multiple importance sampling with light sampling, so
/// that the expected picture is that of `path`. Where the guide has no gain it is off. See [`crate::guide`].
#[derive(Clone, Debug)]
pub struct Guided {
    tracer: PathTracer,
    light_sampling: bool,
    /// The kind of guide to train.
    guide: GuideSettings,
    /// A fixed guide; without one, that of the film's training.
    fixed: Option<Arc<Guide>>,
}

impl Guided {
    /// A learning integrator with the depth and the light sampling of `settings`.
    #[must_use]
    pub fn new(settings: &IntegratorSettings) -> Self {
        let IntegratorSettings { light_sampling, guide, .. } = *settings;
        // Branches would share one sampler of directions, whose records are those of a single path.
        let tracer = PathTracer::new(&IntegratorSettings { branching: 1, ..*settings });
        Self { tracer, light_sampling, guide, fixed: None }
    }

    /// An integrator with a fixed guide, without training.
    #[must_use]
    pub fn with_guide(settings: &IntegratorSettings, guide: Arc<Guide>) -> Self {
        Self { fixed: Some(guide), ..Self::new(settings) }
    }

    /// The estimates with a tree as guide; the records of the paths are added to `training`.
    fn by_tree(
        &self,
        guide: &TreeGuide,
        training: Option<&Training>,
        contexts: &mut [Context<'_>],
        radiance: &mut Vec<Spectrum>,
    ) {
        let mut records: Vec<_> =
            contexts.iter_mut().map(|context| std::mem::take(&mut context.records)).collect();
        let directions = contexts.iter().zip(&mut records).map(|(context, records)| {
            records.clear();
            let sample = context.sampler.sample_index();
            let sparse = training.is_none() || sample >= SPARSE_FROM && sample % 2 == 1;
            let learns_lights = context.scene.light_group_count() > 1;
            let directions =
                GuideDirections::new(guide, sparse, training.map(|_| records), context.wavelengths);
            GuideDirections { learns_lights, ..directions }
        });
        let mut directions: Vec<_> = directions.collect();
        self.tracer.radiance(contexts, &mut directions, radiance);
        for ((context, records), light) in contexts.iter_mut().zip(records).zip(radiance) {
            if let Some(training) = training {
                training.learn(&records, *light, &context.wavelengths);
            }
            context.records = records;
        }
    }
}

impl Integrator for Guided {
    fn radiance(&self, context: &mut Context<'_>) -> Spectrum {
        radiance_of_one(self, context)
    }

    fn batch(&self) -> usize {
        self.tracer.batch()
    }

    fn radiance_batch(&self, contexts: &mut [Context<'_>], radiance: &mut Vec<Spectrum>) {
        let Some(training) = contexts.first().map(|context| context.training) else {
            radiance.clear();
            return;
        };
        let (guide, training) = match (&self.fixed, training) {
            (Some(guide), _) => (&**guide, None),
            (None, Some(training)) => (training.guide(), Some(training)),
            (None, None) => {
                let mut directions: Vec<_> = contexts.iter().map(|_| BsdfDirections).collect();
                return self.tracer.radiance(contexts, &mut directions, radiance);
            }
        };
        match guide {
            Guide::Tree(tree) => self.by_tree(tree, training, contexts, radiance),
            Guide::Grid(grid) => {
                grid_guided::radiance(&self.tracer, self.light_sampling, contexts, grid, training, radiance);
            }
        }
    }

    fn learns(&self) -> bool {
        self.fixed.is_none()
    }

    fn new_guide(&self, scene: &Scene) -> Result<Guide, GridError> {
        Guide::new(scene, &self.guide)
    }
}

/// From this sample of a pixel on, vertices at which the guide is off are recorded in every second sample only. This saves half of the
/// cost where the guide has had no gain so far, and it may still have one later.
const SPARSE_FROM: u32 = 16;

/// Direction sampler for the mixture of guide and BSDF.
struct GuideDirections<'a> {
    guide: &'a TreeGuide,
    /// Whether to skip vertices at which the guide is off.
    sparse: bool,
    /// Whether there are groups of lights to select from.
    learns_lights: bool,
    /// Target of training records, if the pass trains.
    records: Option<&'a mut PathRecords>,
    /// Density and leaf of the last direction, if the guide was evaluated.
    drawn: Option<(f64, u32)>,
    /// Expected luminance of the whole path, estimated at its first rough vertex.
    expected: Option<f64>,
    /// The last probability of survival, over the fraction of light that media have left since then.
    survival: f64,
    wavelengths: Wavelengths,
}

impl<'a> GuideDirections<'a> {
    fn new(
        guide: &'a TreeGuide,
        sparse: bool,
        records: Option<&'a mut PathRecords>,
        wavelengths: Wavelengths,
    ) -> Self {
        Self {
            guide,
            sparse,
            learns_lights: false,
            records,
            drawn: None,
            expected: None,
            survival: 1.0,
            wavelengths,
        }
    }

    /// Expected luminance of a vertex towards the viewer, without light sampling, if it is known.
    fn expectation(&self, place: &GuidedVertex, vertex: &Vertex<'_>) -> Option<f64> {
        let is_known = place.flux > 0.0 && vertex.diffuse_probability() == 1.0;
        is_known.then(|| brightness(vertex.albedo(), &self.wavelengths) * place.flux / PI)
    }
}

impl DirectionSampler for GuideDirections<'_> {
    /// `None` where all directions are delta lobes, and in media.
    type VertexData = Option<GuidedVertex>;
    const RECORDS_DIRECTIONS: bool = true;

    fn vertex_data(&self, vertex: &Vertex<'_>) -> Self::VertexData {
        // The guide's densities are those over surfaces.
        let rough = !vertex.is_delta() && !vertex.is_in_medium();
        rough.then(|| self.guide.place(vertex.at.point.position, vertex.normal_to_viewer()))
    }

    fn light_groups(
        &self,
        place: &Self::VertexData,
        scene: &Scene,
        from: &LightSampleContext,
    ) -> [f64; MAX_LIGHT_GROUPS] {
        match place {
            Some(place) if self.learns_lights => self.guide.light_groups(place).weights(scene, from),
            _ => scene.light_group_probabilities(from),
        }
    }

    fn record_light(&mut self, place: &Self::VertexData, selected: &SelectedLight, luminance: f64) {
        let (Some(records), Some(place)) = (&mut self.records, place) else { return };
        let SelectedLight { group, group_probability: probability, .. } = *selected;
        if self.learns_lights {
            // The selection within the group is part of the estimate for the group.
            let inside = selected.probability / probability;
            records.light_groups.push(LightGroupRecord {
                cell: place.cell,
                group: group as u32,
                luminance: luminance / inside,
                probability,
            });
        }
    }

    fn record_medium(&mut self, before: Spectrum, after: Spectrum) {
        self.survival *= brightness(before, &self.wavelengths) / brightness(after, &self.wavelengths);
    }

    fn pdf(&self, place: &Self::VertexData, direction: DVec3, bsdf_pdf: f64) -> f64 {
        match place {
            Some(place) if place.probability > 0.0 => {
                density(place.probability, self.guide.pdf(place, direction).0, bsdf_pdf)
            }
            _ => bsdf_pdf,
        }
    }

    fn sample(
        &mut self,
        place: &Self::VertexData,
        vertex: &Vertex<'_>,
        xi: DVec2,
        xi_lobe: f64,
    ) -> Option<ScatteredRay> {
        self.drawn = None;
        if self.records.is_some() {
            let expected = place.as_ref().and_then(|place| self.expectation(place, vertex));
            // Surviving paths also represent those that ended.
            let expected = expected.map(|expected| expected / self.survival);
            self.records.iter_mut().for_each(|records| records.expect(expected));
        }
        let Some(place) = place.as_ref().filter(|place| place.probability > 0.0) else {
            return vertex.sample(xi, xi_lobe);
        };
        let guided = place.probability;
        if xi_lobe < guided {
            let draw = self.guide.sample(place, xi)?;
            self.drawn = Some((draw.pdf, draw.leaf));
            return vertex.drawn(draw.direction, |bsdf_pdf| density(guided, draw.pdf, bsdf_pdf));
        }
        let scattered = vertex.sample(xi, (xi_lobe - guided) / (1.0 - guided))?;
        if scattered.is_delta {
            // The guide does not sample delta lobes; the BSDF samples them with its own probability.
            return Some(ScatteredRay { weight: scattered.weight / (1.0 - guided) as f32, ..scattered });
        }
        let drawn = self.guide.pdf(place, scattered.direction);
        self.drawn = Some(drawn);
        let pdf = density(guided, drawn.0, scattered.bsdf_pdf);
        Some(scattered.with_pdf(pdf))
    }

    fn survival(
        &mut self,
        place: &Self::VertexData,
        vertex: &Vertex<'_>,
        scattered: &ScatteredRay,
        state: &RouletteState,
    ) -> f64 {
        let known = place.as_ref().filter(|place| place.flux > 0.0 && !scattered.is_delta);
        let wavelengths = &self.wavelengths;
        let by_light = known.and_then(|place| {
            let path = *self.expected.get_or_insert_with(|| {
                // An estimate that treats all surfaces as diffuse.
                let own = brightness(state.before * vertex.albedo(), wavelengths) * place.flux / PI;
                survival::expected(own, self.guide.brightness)
            });
            let guide_pdf = self.drawn.map_or(scattered.bsdf_pdf, |(pdf, _)| pdf);
            let radiance = place.flux * survival::believed(guide_pdf, scattered.bsdf_pdf)
                / vertex.cosine(scattered.direction).abs();
            survival::probability(brightness(state.after, wavelengths) * radiance, path)
        });
        self.survival = by_light.unwrap_or_else(|| state.by_throughput());
        self.survival
    }

    fn record_direction(&mut self, place: &Self::VertexData, sampled: &SampledDirection, light: Spectrum) {
        let Some(records) = &mut self.records else { return };
        records.leave(light);
        let Some(place) = place else { return };
        let SampledDirection { scattered, cosine, throughput, is_dispersed, .. } = *sampled;
        if scattered.is_delta || self.sparse && place.probability == 0.0 {
            return;
        }
        let (guide_pdf, leaf) = self.drawn.unwrap_or_else(|| self.guide.pdf(place, scattered.direction));
        records.push(DirectionRecord {
            cell: place.cell,
            leaf,
            cosine,
            guide_pdf,
            bsdf_pdf: scattered.bsdf_pdf,
            pdf: scattered.pdf,
            light,
            throughput,
            beyond: throughput * scattered.weight,
            is_dispersed,
            next: None,
        });
    }
}

#[cfg(test)]
mod tests {
    use glanz_math::Bounds3;
    use glanz_scene::Interaction;
    use glanz_shading::Bsdf;
    use glanz_shading::model::Lambert;

    use super::*;

    #[test]
    fn expected_light_arrives_with_what_the_medium_on_its_way_leaves() {
        let guide = TreeGuide::new(&Bounds3 { min: DVec3::ZERO, max: DVec3::ONE });
        let at = Interaction::in_medium(DVec3::splat(0.5), 1.0, DVec3::Z);
        let vertex = Vertex::new(&at, Bsdf::Lambert(Lambert { reflectance: Spectrum::splat(0.6) }));
        let mut place = guide.place(at.point.position, DVec3::Z);
        place.flux = PI;
        let mut records = PathRecords::default();
        let mut directions = GuideDirections::new(&guide, false, Some(&mut records), Wavelengths::Rgb);
        let scattered = directions.sample(&Some(place), &vertex, DVec2::splat(0.3), 0.5).unwrap();
        let (from, throughput) = (vertex.light_sample_context(DVec3::Z), Spectrum::ONE);
        let sampled = SampledDirection { from, scattered, cosine: 1.0, throughput, is_dispersed: false };
        directions.record_direction(&Some(place), &sampled, Spectrum::BLACK);
        directions.survival = 0.5;
        directions.record_medium(Spectrum::splat(0.8), Spectrum::splat(0.4));
        directions.record_medium(Spectrum::splat(0.4), Spectrum::splat(0.2));
        directions.sample(&Some(place), &vertex, DVec2::splat(0.3), 0.5).unwrap();
        // The next vertex reflects 0.6 of the irradiance pi, over pi; half of the paths reach it, with a quarter of their light.
        let (arrived, _) = records.directions[0].found(Spectrum::BLACK, &Wavelengths::Rgb);
        assert!((arrived - 0.6 / 0.5 * 0.25).abs() < 1e-6, "{arrived}");
    }
}
