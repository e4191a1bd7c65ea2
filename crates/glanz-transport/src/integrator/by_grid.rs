//! Directions by the guide of document 003.

use glanz_light::Spectrum;
use glanz_math::{DVec2, DVec3};
use glanz_sampling::{mis, warp};
use glanz_scene::{Reference, Scene};

use super::Context;
use super::vertex::{Scattered, Vertex};
use super::walk::{Directions, Walk};
use crate::guide::{GridDraw, GridGuide, GridPlace, GridRecord, Training};

/// The light of one path whose directions at diffuse surfaces are drawn by `grid`; what it finds is told to `training`.
pub(super) fn radiance(
    walk: &Walk,
    light_sampling: bool,
    context: &mut Context<'_>,
    grid: &GridGuide,
    training: Option<&Training>,
) -> Spectrum {
    let records = training.map(|_| Vec::new());
    let share = if grid.settings().mixture { 0.5 } else { 1.0 };
    let (scene, wavelengths) = (context.scene, context.wavelengths);
    let mut directions = ByGrid { grid, scene, light_sampling, share, records, drawn: None, leg: None };
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
struct ByGrid<'a> {
    grid: &'a GridGuide,
    scene: &'a Scene,
    light_sampling: bool,
    /// Share of the diffuse directions that densities draw.
    share: f64,
    /// Where to note directions, if they are to be learnt from.
    records: Option<Vec<GridRecord>>,
    /// What a density has just drawn.
    drawn: Option<Drawn>,
    /// The way from the last direction that is learnt from, until it meets a surface and that scatters.
    leg: Option<Leg>,
}

/// A direction that a density has drawn: cell and function.
#[derive(Clone, Copy)]
struct Drawn {
    cell: u32,
    function: u32,
}

/// A way that is to be learnt from.
#[derive(Clone, Copy)]
struct Leg {
    from: Reference,
    pdf: f64,
    /// Radiance that came straight from the surface it met, as it was counted.
    emitted: Spectrum,
}

/// What is looked up for a vertex with a diffuse lobe.
#[derive(Clone, Copy)]
struct Diffuse {
    place: GridPlace,
    /// Probability that a density draws.
    probability: f64,
}

impl Diffuse {
    /// Density per steradian of a direction that densities draw with density `own` and the BSDF with `bsdf_pdf`.
    fn density(&self, own: f64, bsdf_pdf: f64, cosine: f64) -> f64 {
        // The BSDF lacks that share of its diffuse lobe. What is left of it is not negative but for rounding.
        let left = bsdf_pdf - self.probability * warp::cosine_hemisphere_pdf(cosine).0;
        self.probability * own + left.max(0.0)
    }
}

impl ByGrid<'_> {
    /// Light that came straight from the surface of `vertex` along `leg`, as the walk counted it.
    fn emitted(&self, leg: &Leg, vertex: &Vertex<'_>) -> Spectrum {
        let Some(id) = vertex.at.light() else { return Spectrum::BLACK };
        let emitted = self.scene.emitted(vertex.at, vertex.at.wo);
        if emitted.is_black() {
            return emitted;
        }
        let light_pdf = self.scene.light_pdf(id, &leg.from, vertex.at).0 * self.scene.light_probability(id);
        emitted * mis::power(leg.pdf, light_pdf) as f32
    }

    /// Tells the last record what came straight from the surface that its way met; `throughput`: of the way.
    fn leave_out(&mut self, emitted: Spectrum, throughput: Option<Spectrum>) {
        if let Some(record) = self.records.as_mut().and_then(|records| records.last_mut()) {
            record.left_out = Some(emitted * throughput.unwrap_or(record.beyond));
        }
    }

    /// Notes a direction.
    fn note(&mut self, drawn: Drawn, cosine: f64, light: Spectrum, beyond: Spectrum) {
        // Until the way meets a surface that scatters, all light it brings comes straight from lamps or from the sky.
        let left_out = (!self.light_sampling).then_some(Spectrum::BLACK);
        if let Some(records) = &mut self.records {
            let Drawn { cell, function } = drawn;
            records.push(GridRecord { cell, function, cosine, light, beyond, left_out });
        }
    }
}

impl Directions for ByGrid<'_> {
    /// `None` where nothing is scattered diffusely.
    type Place = Option<Diffuse>;

    fn arrive(&self, vertex: &Vertex<'_>) -> Self::Place {
        let probability = self.share * vertex.diffuse_probability();
        if probability <= 0.0 {
            return None;
        }
        Some(Diffuse { place: self.grid.place(vertex.at, vertex.normal_to_viewer())?, probability })
    }

    fn pdf(&self, place: &Self::Place, direction: DVec3, bsdf_pdf: f64) -> f64 {
        let Some(diffuse) = place else { return bsdf_pdf };
        let cosine = diffuse.place.cosine(direction);
        diffuse.density(self.grid.pdf(&diffuse.place, direction), bsdf_pdf, cosine)
    }

    fn sample(
        &mut self,
        place: &Self::Place,
        vertex: &Vertex<'_>,
        xi: DVec2,
        xi_lobe: f64,
    ) -> Option<Scattered> {
        self.drawn = None;
        if self.light_sampling
            && let Some(mut leg) = self.leg.take()
            // What is black scatters nothing: all light of the way was its own.
            && !vertex.albedo().is_black()
        {
            leg.emitted = self.emitted(&leg, vertex);
            self.leave_out(leg.emitted, None);
            self.leg = Some(leg);
        }
        let Some(diffuse) = place else { return vertex.sample(xi, xi_lobe) };
        if xi_lobe < diffuse.probability {
            let GridDraw { direction, pdf, function } = self.grid.sample(&diffuse.place, xi);
            let drawn = Drawn { cell: diffuse.place.cell, function };
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
            return Some(Scattered::drawn(direction, value, bsdf_pdf, pdf));
        }
        // What is left of the unit interval draws what is left of the diffuse lobe, then highlights.
        let scattered = vertex.sample(xi, xi_lobe)?;
        if scattered.is_delta {
            return Some(scattered);
        }
        let pdf = self.pdf(place, scattered.direction, scattered.bsdf_pdf);
        Some(scattered.with_pdf(pdf))
    }

    fn take(
        &mut self,
        _: &Self::Place,
        vertex: &Vertex<'_>,
        scattered: &Scattered,
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
            self.leg =
                Some(Leg { from: vertex.at.reference(), pdf: scattered.pdf, emitted: Spectrum::BLACK });
        }
    }
}
