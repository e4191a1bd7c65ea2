//! Directions by the guide of document 003.

use glanz_light::Spectrum;
use glanz_math::{DVec2, DVec3};
use glanz_sampling::{mis, warp};
use glanz_scene::{LightSampleContext, Scene};

use super::Context;
use super::path_tracer::{DirectionSampler, PathTracer};
use super::vertex::{ScatteredRay, Vertex};
use crate::guide::{GridGuide, GridRecord, GridSample, GridVertex, Training};

/// The light of one path whose directions at diffuse surfaces are drawn by `grid`; what it finds is told to `training`.
pub(super) fn radiance(
    walk: &PathTracer,
    light_sampling: bool,
    context: &mut Context<'_>,
    grid: &GridGuide,
    training: Option<&Training>,
) -> Spectrum {
    let records = training.map(|_| Vec::new());
    let share = if grid.settings().mixture { 0.5 } else { 1.0 };
    let (scene, wavelengths) = (context.scene, context.wavelengths);
    let mut directions =
        GridDirections { grid, scene, light_sampling, share, records, drawn: None, leg: None };
    let light = walk.radiance(context, &mut directions);
    if let (Some(training), Some(records)) = (training, &directions.records) {
        training.learn_on_grid(records, light, &wavelengths);
    }
    light
}

/// Directions that densities draw where the BSDF would draw from Lambert's lobe, always or every other time; highlights and
/// mirrors are left to the BSDF (document 003 section 3.3.2). The density of all together counts.
///
/// With light sampling, light that comes straight from a lamp is not learnt.
struct GridDirections<'a> {
    grid: &'a GridGuide,
    scene: &'a Scene,
    light_sampling: bool,
    /// Share of the diffuse directions that densities draw.
    share: f64,
    /// Target of training records, if the pass trains.
    records: Option<Vec<GridRecord>>,
    /// The sample drawn last from a density.
    drawn: Option<GridDensitySample>,
    /// The way from the last direction that is learnt from, until it meets a surface and that scatters.
    leg: Option<PathSegment>,
}

/// A direction that a density has drawn: cell and function.
#[derive(Clone, Copy)]
struct GridDensitySample {
    cell: u32,
    function: u32,
}

/// A way that is to be learnt from.
#[derive(Clone, Copy)]
struct PathSegment {
    from: LightSampleContext,
    pdf: f64,
    /// Radiance that came straight from the surface it met, as it was counted.
    emitted: Spectrum,
}

/// Guide data of a vertex with a diffuse lobe.
#[derive(Clone, Copy)]
struct DiffuseVertex {
    place: GridVertex,
    /// Probability that a density draws.
    probability: f64,
}

impl DiffuseVertex {
    /// Density per steradian of a direction that densities draw with density `own` and the BSDF with `bsdf_pdf`.
    fn density(&self, own: f64, bsdf_pdf: f64, cosine: f64) -> f64 {
        // The BSDF lacks that share of its diffuse lobe. What is left of it is not negative but for rounding.
        let left = bsdf_pdf - self.probability * warp::cosine_hemisphere_pdf(cosine).0;
        self.probability * own + left.max(0.0)
    }
}

impl GridDirections<'_> {
    /// Light that came straight from the surface of `vertex` along `leg`, as the walk counted it.
    fn emitted(&self, leg: &PathSegment, vertex: &Vertex<'_>) -> Spectrum {
        let Some(id) = vertex.at.light() else { return Spectrum::BLACK };
        let emitted = self.scene.emitted(vertex.at, vertex.at.wo);
        if emitted.is_black() {
            return emitted;
        }
        let light_pdf = self.scene.light_pdf(id, &leg.from, vertex.at).0 * self.scene.light_probability(id);
        emitted * mis::power(leg.pdf, light_pdf) as f32
    }

    /// Adds to the last record the light emitted by the surface that its ray hit; `throughput`: of the path.
    fn leave_out(&mut self, emitted: Spectrum, throughput: Option<Spectrum>) {
        if let Some(record) = self.records.as_mut().and_then(|records| records.last_mut()) {
            record.left_out = Some(emitted * throughput.unwrap_or(record.beyond));
        }
    }

    /// Notes a direction.
    fn note(&mut self, drawn: GridDensitySample, cosine: f64, light: Spectrum, beyond: Spectrum) {
        // Until the way meets a surface that scatters, all light it brings comes straight from lamps or from the sky.
        let left_out = (!self.light_sampling).then_some(Spectrum::BLACK);
        if let Some(records) = &mut self.records {
            let GridDensitySample { cell, function } = drawn;
            records.push(GridRecord { cell, function, cosine, light, beyond, left_out });
        }
    }
}

impl DirectionSampler for GridDirections<'_> {
    /// `None` where nothing is scattered diffusely.
    type VertexData = Option<DiffuseVertex>;

    fn arrive(&self, vertex: &Vertex<'_>) -> Self::VertexData {
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
            && let Some(mut leg) = self.leg.take()
            // A black surface scatters nothing: all light of the path was emitted there.
            && !vertex.albedo().is_black()
        {
            leg.emitted = self.emitted(&leg, vertex);
            self.leave_out(leg.emitted, None);
            self.leg = Some(leg);
        }
        let Some(diffuse) = place else { return vertex.sample(xi, xi_lobe) };
        if xi_lobe < diffuse.probability {
            let GridSample { direction, pdf, function } = self.grid.sample(&diffuse.place, xi);
            let drawn = GridDensitySample { cell: diffuse.place.cell, function };
            let (value, bsdf_pdf) = vertex.eval(direction);
            if value.is_black() {
                // Directions below the surface, seen by its own normal, bring nothing: that too is to be learnt.
                let normal = vertex.at.point.normal;
                if normal.dot(direction) * normal.dot(vertex.at.wo) <= 0.0 {
                    self.note(drawn, 0.0, Spectrum::BLACK, Spectrum::BLACK);
                }
                return None;
            }
            self.drawn = Some(drawn);
            let pdf = diffuse.density(pdf, bsdf_pdf, diffuse.place.cosine(direction));
            return Some(ScatteredRay::drawn(direction, value, bsdf_pdf, pdf));
        }
        // The rest of the unit interval samples the rest of the diffuse lobe, then the glossy lobes.
        let scattered = vertex.sample(xi, xi_lobe)?;
        if scattered.is_delta {
            return Some(scattered);
        }
        let pdf = self.pdf(place, scattered.direction, scattered.bsdf_pdf);
        Some(scattered.with_pdf(pdf))
    }

    fn take(
        &mut self,
        _: &Self::VertexData,
        vertex: &Vertex<'_>,
        scattered: &ScatteredRay,
        light: Spectrum,
        throughput: Spectrum,
    ) {
        if let Some(leg) = self.leg.take() {
            // Only now is it known what survival made of the throughput of the way here.
            self.leave_out(leg.emitted, Some(throughput));
        }
        let (Some(drawn), true) = (self.drawn.take(), self.records.is_some()) else { return };
        let cosine = vertex.cosine(scattered.direction).abs();
        self.note(drawn, cosine, light, throughput * scattered.weight);
        if self.light_sampling {
            self.leg = Some(PathSegment {
                from: vertex.at.light_sample_context(),
                pdf: scattered.pdf,
                emitted: Spectrum::BLACK,
            });
        }
    }
}
