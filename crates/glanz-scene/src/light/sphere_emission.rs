//! Light from a picture over all directions.

use std::f64::consts::{FRAC_1_PI, PI};
use std::sync::Arc;

use glanz_light::Spectrum;
use glanz_math::{DMat3, DVec2, DVec3, SolidAnglePdf};
use glanz_sampling::discrete::PiecewiseConstant2;
use glanz_sampling::warp;

use super::{SphereImage, brightness};
use crate::description::SphereMapping;

/// Share of a picture's light above its mean below which the picture counts as even.
const EVEN: f64 = 0.01;

/// Light by direction in the world: a picture times a spectrum, with a density that is constant in each pixel, per solid angle.
#[derive(Clone, Debug)]
pub(super) struct SphereEmission {
    image: SphereImage,
    factor: Spectrum,
    /// The axes of the picture in the world; orthonormal, perhaps mirrored.
    axes: DMat3,
    /// Pixels by their mean light; `None` if it is black.
    pixels: Option<Arc<PiecewiseConstant2>>,
}

impl SphereEmission {
    /// Sampled in proportion to its light.
    pub(super) fn new(image: SphereImage, factor: Spectrum, axes: DMat3) -> Self {
        let (width, height) = (image.width(), image.height());
        let weight = |i| {
            let rgb = image.mean_of_cell(i % width, i / width).map(|x| x as f32);
            brightness(factor * Spectrum::from_rgb(rgb)) as f32
        };
        let weights = (0..width * height).map(weight).collect();
        let pixels = PiecewiseConstant2::try_new(width, height, weights, |row| image.solid_angle(row));
        Self { pixels: pixels.ok().map(Arc::new), image, factor, axes }
    }

    /// The same light, sampled in proportion to the excess over its mean (@karlik2019): where a picture is darker, BSDF sampling finds its light as
    /// well. Both densities are the same if the picture is almost even.
    pub(super) fn compensated(&self) -> Self {
        let excess = self.pixels.as_ref().and_then(|pixels| {
            let mean = pixels.sum() / (4.0 * PI);
            let excess = pixels.above(mean, |row| self.image.solid_angle(row)).ok()?;
            (excess.sum() > EVEN * pixels.sum()).then(|| Arc::new(excess))
        });
        Self { pixels: excess.or_else(|| self.pixels.clone()), ..self.clone() }
    }

    /// The mean over all directions.
    pub(super) fn mean(&self) -> Spectrum {
        self.factor * Spectrum::from_rgb(self.image.mean())
    }

    /// The light in a unit direction.
    pub(super) fn light(&self, direction: DVec3) -> Spectrum {
        self.light_of(self.axes.transpose() * direction)
    }

    fn light_of(&self, local: DVec3) -> Spectrum {
        self.factor * Spectrum::from_rgb(self.image.lookup(local))
    }

    /// A unit direction by two numbers uniform in [0, 1), with its light and its density; `None` if all is black.
    pub(super) fn sample(&self, xi: DVec2) -> Option<(DVec3, Spectrum, SolidAnglePdf)> {
        let sample = self.pixels.as_ref()?.sample(xi);
        let [_, row] = sample.cell;
        let local = match self.image.mapping() {
            SphereMapping::EqualArea => warp::equal_area_sphere(sample.point),
            SphereMapping::LatitudeLongitude => {
                // The share of the row's area that lies above.
                let share = sample.point.y * self.image.height() as f64 - row as f64;
                self.direction_in_row(row, share, sample.point.x)
            }
        };
        let pdf = self.per_solid_angle(sample.pdf, row);
        (pdf.0 > 0.0).then(|| (self.axes * local, self.light_of(local), pdf))
    }

    /// The direction at longitude 2 pi `turn` below the share `share` of a row's area.
    fn direction_in_row(&self, row: usize, share: f64, turn: f64) -> DVec3 {
        // (1 - cos) / 2 of the angle from the pole, in which a sphere has equal areas.
        let drop = |row: f64| (0.5 * PI * row / self.image.height() as f64).sin().powi(2);
        let (top, bottom) = (drop(row as f64), drop(row as f64 + 1.0));
        warp::uniform_sphere(DVec2::new(top + share.clamp(0.0, 1.0) * (bottom - top), turn))
    }

    /// The density of [`SphereEmission::sample`] in a unit direction.
    pub(super) fn pdf(&self, direction: DVec3) -> SolidAnglePdf {
        let place = self.image.mapping().place(self.axes.transpose() * direction);
        let row = (place.y * self.image.height() as f64) as usize;
        let pdf = self.pixels.as_ref().map_or(0.0, |pixels| pixels.pdf(place));
        self.per_solid_angle(pdf, row)
    }

    fn per_solid_angle(&self, pdf: f64, row: usize) -> SolidAnglePdf {
        SolidAnglePdf(match self.image.mapping() {
            SphereMapping::EqualArea => 0.25 * FRAC_1_PI * pdf,
            mapping @ SphereMapping::LatitudeLongitude => {
                let height = self.image.height();
                pdf / (height as f64 * mapping.band(row, height))
            }
        })
    }
}
