//! Path tracing with directions that a guide draws.

use std::sync::Arc;

use glanz_light::Spectrum;
use glanz_math::{DVec2, DVec3};

use super::path::ByBsdf;
use super::vertex::{Scattered, Vertex};
use super::walk::{Directions, Walk};
use super::{Context, Integrator, IntegratorSettings};
use crate::guide::{Guide, Place, Record, density};

/// As [`Path`](super::Path), but at rough surfaces a guide draws some of the directions.
///
/// The guide knows where light came from in earlier passes. With a probability that is learnt too it draws the direction, otherwise
/// the BSDF does; the density of both together divides the light and is weighed against light sampling, so that the expected
/// picture is that of `path`. Where the guide gains nothing it is off. See [`crate::guide`].
#[derive(Clone, Debug)]
pub struct Guided {
    walk: Walk,
    /// A guide that does not learn; without one, that of the film's training.
    fixed: Option<Arc<Guide>>,
}

impl Guided {
    /// With the depth and the light sampling of `settings`, learning.
    #[must_use]
    pub fn new(settings: &IntegratorSettings) -> Self {
        Self { walk: Walk::new(settings), fixed: None }
    }

    /// The same, by a guide that was learnt before and does not change.
    #[must_use]
    pub fn with_guide(settings: &IntegratorSettings, guide: Arc<Guide>) -> Self {
        Self { walk: Walk::new(settings), fixed: Some(guide) }
    }
}

impl Integrator for Guided {
    fn radiance(&self, context: &mut Context<'_>) -> Spectrum {
        if let Some(guide) = &self.fixed {
            return self.walk.radiance(context, &mut ByGuide { guide, sparse: true, records: None });
        }
        let Some(training) = context.training else { return self.walk.radiance(context, &mut ByBsdf) };
        let mut records = std::mem::take(&mut context.records);
        records.clear();
        let sample = context.sampler.sample_index();
        let sparse = sample >= SPARSE_FROM && sample % 2 == 1;
        let mut directions = ByGuide { guide: training.guide(), sparse, records: Some(&mut records) };
        let light = self.walk.radiance(context, &mut directions);
        training.learn(&records, light, &context.wavelengths);
        context.records = records;
        light
    }

    fn learns(&self) -> bool {
        self.fixed.is_none()
    }
}

/// From this sample of a pixel on, vertices at which the guide is off are learnt from in every second sample only: where it did
/// not pay so far, that saves half of its cost, and it may still pay later.
const SPARSE_FROM: u32 = 16;

/// Directions that guide and BSDF draw together.
struct ByGuide<'a> {
    guide: &'a Guide,
    /// Whether to leave out vertices at which the guide is off.
    sparse: bool,
    /// Where to note them, if they are to be learnt from.
    records: Option<&'a mut Vec<Record>>,
}

impl Directions for ByGuide<'_> {
    /// `None` where all directions are delta lobes.
    type Place = Option<Place>;

    fn arrive(&self, vertex: &Vertex<'_>) -> Self::Place {
        let rough = !vertex.is_delta();
        rough.then(|| self.guide.place(vertex.at.point.position, vertex.normal_to_viewer()))
    }

    fn pdf(&self, place: &Self::Place, direction: DVec3, bsdf_pdf: f64) -> f64 {
        match place {
            Some(place) if place.probability > 0.0 => {
                density(place.probability, self.guide.pdf(place, direction).0, bsdf_pdf)
            }
            _ => bsdf_pdf,
        }
    }

    fn sample(
        &mut self,
        place: &Self::Place,
        vertex: &Vertex<'_>,
        xi: DVec2,
        xi_lobe: f64,
    ) -> Option<Scattered> {
        let Some(place) = place.as_ref().filter(|place| place.probability > 0.0) else {
            return vertex.sample(xi, xi_lobe);
        };
        let guided = place.probability;
        if xi_lobe < guided {
            let draw = self.guide.sample(place, xi)?;
            let (value, bsdf_pdf) = vertex.eval(draw.direction);
            if value.is_black() {
                return None;
            }
            let pdf = density(guided, draw.pdf, bsdf_pdf);
            return Some(Scattered {
                direction: draw.direction,
                weight: value / pdf as f32,
                bsdf_weight: value / bsdf_pdf as f32,
                bsdf_pdf,
                pdf,
                is_delta: false,
                eta_scale: 1.0,
            });
        }
        let scattered = vertex.sample(xi, (xi_lobe - guided) / (1.0 - guided))?;
        if scattered.is_delta {
            // The guide leaves delta lobes alone: they come with the probability of the BSDF.
            return Some(Scattered { weight: scattered.weight / (1.0 - guided) as f32, ..scattered });
        }
        let pdf = density(guided, self.guide.pdf(place, scattered.direction).0, scattered.bsdf_pdf);
        Some(Scattered { weight: scattered.weight * (scattered.bsdf_pdf / pdf) as f32, pdf, ..scattered })
    }

    fn take(
        &mut self,
        place: &Self::Place,
        vertex: &Vertex<'_>,
        scattered: &Scattered,
        light: Spectrum,
        throughput: Spectrum,
    ) {
        let (Some(records), Some(place)) = (&mut self.records, place) else { return };
        if scattered.is_delta || self.sparse && place.probability == 0.0 {
            return;
        }
        let (guide_pdf, leaf) = self.guide.pdf(place, scattered.direction);
        records.push(Record {
            cell: place.cell,
            leaf,
            cosine: vertex.cosine(scattered.direction).abs(),
            guide_pdf,
            bsdf_pdf: scattered.bsdf_pdf,
            pdf: scattered.pdf,
            light,
            throughput,
            beyond: throughput * scattered.weight,
        });
    }
}
