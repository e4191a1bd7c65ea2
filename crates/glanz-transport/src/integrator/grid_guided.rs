//! Path tracing with the guide of document 003.

use glanz_light::{Spectrum, Wavelengths};
use glanz_math::{DVec2, DVec3};
use glanz_sampling::{mis, warp};
use glanz_scene::{LightSampleContext, Scene};

use super::Context;
use super::path_state::SampledDirection;
use super::path_tracer::{DirectionSampler, PathTracer};
use super::vertex::{ScatteredRay, Vertex};
use crate::guide::{GridGuide, GridRecord, GridSample, GridVertex, Training};

/// The light of paths whose directions at diffuse surfaces are sampled from `grid`; their records are added to `training`.
pub(super) fn radiance(
    tracer: &PathTracer,
    light_sampling: bool,
    contexts: &mut [Context<'_>],
    grid: &GridGuide,
    training: Option<&Training>,
    radiance: &mut Vec<Spectrum>,
) {
    let share = if grid.settings().mixture { 0.5 } else { 1.0 };
    let directions = contexts.iter().map(|context| {
        let (scene, records) = (context.scene, training.map(|_| Vec::new()));
        let wavelengths = context.wavelengths;
        GridDirections {
            grid,
            scene,
            wavelengths,
            light_sampling,
            share,
            records,
            drawn: None,
            segment: None,
        }
    });
    let mut directions: Vec<_> = directions.collect();
    tracer.radiance(contexts, &mut directions, radiance);
    let Some(training) = training else { return };
    for ((context, directions), light) in contexts.iter().zip(&directions).zip(radiance) {
        if let Some(records) = &directions.records {
            training.learn_on_grid(records, *light, &context.wavelengths);
        }
    }
}

/// Direction sampler that replaces the BSDF's samples of Lambert's lobe by those of the grid's densities, always or every other time;
/// highlights and mirrors are sampled by the BSDF (document 003 section 3.3.2). The density of a direction is that of the mixture.
///
/// With light sampling, direct light is excluded from training.
struct GridDirections<'a> {
    grid: &'a GridGuide,
    scene: &'a Scene,
    wavelengths: Wavelengths,
    light_sampling: bool,
    /// Fraction of the diffuse directions that are sampled from densities.
    share: f64,
    /// Target of training records, if the pass trains.
    records: Option<Vec<GridRecord>>,
    /// The last sample from a density.
    drawn: Option<GridDensitySample>,
    /// The segment along the last recorded direction, until it reaches a scattering surface.
    segment: Option<PathSegment>,
}

/// Cell and function from which a direction was sampled.
#[derive(Clone, Copy)]
struct GridDensitySample {
    cell: u32,
    function: u32,
}

/// A segment of a path that is used for training.
#[derive(Clone, Copy)]
struct PathSegment {
    from: LightSampleContext,
    pdf: f64,
    /// Radiance emitted by the surface that it hit, with its weight.
    emitted: Spectrum,
}

/// Guide data of a vertex with a diffuse lobe.
#[derive(Clone, Copy)]
struct DiffuseVertex {
    place: GridVertex,
    /// Probability of sampling the density.
    probability: f64,
}

impl DiffuseVertex {
    /// Density per steradian of a direction in the mixture of the guide, with density `own`, and the BSDF, with `bsdf_pdf`.
    fn density(&self, own: f64, bsdf_pdf: f64, cosine: f64) -> f64 {
        // The guide replaces this fraction of the BSDF's diffuse lobe. The remainder is not negative except for rounding.
        let left = bsdf_pdf - self.probability * warp::cosine_hemisphere_pdf(cosine).0;
        self.probability * own + left.max(0.0)
    }
}

impl GridDirections<'_> {
    /// Light emitted by the surface of `vertex` along `segment`, with the weight that the path tracer gave it.
    fn emitted(&self, segment: &PathSegment, vertex: &Vertex<'_>) -> Spectrum {
        let Some(id) = vertex.at.light() else { return Spectrum::BLACK };
        let emitted = self.scene.emitted(vertex.at, vertex.at.wo);
        let emitted = self.scene.light_at(id, emitted, &self.wavelengths);
        if emitted.is_black() {
            return emitted;
        }
        let light_pdf = self.scene.light_pdf(id, &segment.from, vertex.at).0
            * self.scene.light_probability(id, &segment.from);
        emitted * mis::power(segment.pdf, light_pdf) as f32
    }

    /// Adds to the last record the light emitted by the surface that its ray hit; `throughput`: of the path.
    fn leave_out(&mut self, emitted: Spectrum, throughput: Option<Spectrum>) {
        if let Some(record) = self.records.as_mut().and_then(|records| records.last_mut()) {
            record.left_out = Some(emitted * throughput.unwrap_or(record.beyond));
        }
    }

    /// Records a direction.
    fn note(
        &mut self,
        drawn: GridDensitySample,
        cosine: f64,
        light: Spectrum,
        beyond: Spectrum,
        is_dispersed: bool,
    ) {
        // Before the segment reaches a scattering surface, all its light comes directly from lights or from the sky.
        let left_out = (!self.light_sampling).then_some(Spectrum::BLACK);
        if let Some(records) = &mut self.records {
            let GridDensitySample { cell, function } = drawn;
            records.push(GridRecord { cell, function, cosine, light, beyond, is_dispersed, left_out });
        }
    }
}

impl DirectionSampler for GridDirections<'_> {
    /// `None` where there is no diffuse scattering.
    type VertexData = Option<DiffuseVertex>;
    const RECORDS_DIRECTIONS: bool = true;

    fn vertex_data(&self, vertex: &Vertex<'_>) -> Self::VertexData {
        let probability = self.share * vertex.diffuse_probability();
        if probability <= 0.0 {
            return None;
        }
        Some(DiffuseVertex { place: self.grid.place(vertex.at, vertex.normal_to_viewer())?, probability })
    }

    fn pdf(&self, place: &Self::VertexData, direction: DVec3, bsdf_pdf: f64) -> f64 {
        let Some(diffuse) = place else { return bsdf_pdf };
        let cosine = diffuse.place.cosine(direction);
        diffuse.density(self.grid.pdf(&diffuse.place, direction), bsdf_pdf, cosine)
    }

    fn sample(
        &mut self,
        place: &Self::VertexData,
        vertex: &Vertex<'_>,
        xi: DVec2,
        xi_lobe: f64,
    ) -> Option<ScatteredRay> {
        self.drawn = None;
        if self.light_sampling
            && let Some(mut segment) = self.segment.take()
            // A black surface scatters nothing: all light of the path was emitted there.
            && !vertex.is_black()
        {
            segment.emitted = self.emitted(&segment, vertex);
            self.leave_out(segment.emitted, None);
            self.segment = Some(segment);
        }
        let Some(diffuse) = place else { return vertex.sample(xi, xi_lobe) };
        if xi_lobe < diffuse.probability {
            let GridSample { direction, pdf, function } = self.grid.sample(&diffuse.place, xi);
            let drawn = GridDensitySample { cell: diffuse.place.cell, function };
            let scattered = vertex
                .drawn(direction, |bsdf_pdf| diffuse.density(pdf, bsdf_pdf, diffuse.place.cosine(direction)));
            if scattered.is_some() {
                self.drawn = Some(drawn);
                return scattered;
            }
            // Directions below the geometric surface carry no light, which is also recorded.
            let normal = vertex.at.point.normal;
            if normal.dot(direction) * normal.dot(vertex.at.wo) <= 0.0 {
                self.note(drawn, 0.0, Spectrum::BLACK, Spectrum::BLACK, false);
            }
            return None;
        }
        // The rest of the unit interval samples the rest of the diffuse lobe, then the glossy lobes.
        let scattered = vertex.sample(xi, xi_lobe)?;
        if scattered.is_delta {
            return Some(scattered);
        }
        let pdf = self.pdf(place, scattered.direction, scattered.bsdf_pdf);
        Some(scattered.with_pdf(pdf))
    }

    fn record_direction(&mut self, _: &Self::VertexData, sampled: &SampledDirection, light: Spectrum) {
        let SampledDirection { from, scattered, cosine, throughput, is_dispersed } = *sampled;
        if let Some(segment) = self.segment.take() {
            // Only now is the throughput after Russian roulette known.
            self.leave_out(segment.emitted, Some(throughput));
        }
        let (Some(drawn), true) = (self.drawn.take(), self.records.is_some()) else { return };
        self.note(drawn, cosine, light, throughput * scattered.weight, is_dispersed);
        if self.light_sampling {
            self.segment = Some(PathSegment { from, pdf: scattered.pdf, emitted: Spectrum::BLACK });
        }
    }
}
