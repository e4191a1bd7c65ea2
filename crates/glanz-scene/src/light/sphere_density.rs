//! Directions in proportion to a picture.

use std::f64::consts::{FRAC_1_PI, PI};

use glanz_math::{DVec2, DVec3, SolidAnglePdf};
use glanz_sampling::discrete::PiecewiseConstant2;
use glanz_sampling::warp;

use super::SphereImage;
use crate::description::SphereMapping;

/// Share of a picture's light above its mean below which the picture counts as even.
const EVEN: f64 = 0.01;

/// A density over all directions that is constant in each pixel of a picture, per solid angle.
#[derive(Clone, Debug)]
pub(super) struct SphereDensity {
    mapping: SphereMapping,
    height: usize,
    pixels: PiecewiseConstant2,
}

impl SphereDensity {
    /// The density proportional to `weight` of the mean value of each pixel; `None` if that is 0 everywhere.
    pub(super) fn new(image: &SphereImage, weight: impl Fn([f64; 3]) -> f32) -> Option<Self> {
        let (width, height) = (image.width(), image.height());
        let of_pixel = |i| weight(image.mean_of_cell(i % width, i / width));
        let weights = (0..width * height).map(of_pixel).collect();
        let solid_angle = |row| image.solid_angle(row);
        let pixels = PiecewiseConstant2::try_new(width, height, weights, solid_angle).ok()?;
        Some(Self { mapping: image.mapping(), height, pixels })
    }

    /// That density, and the one proportional to the excess over the mean (@karlik2019): where a picture is darker than its mean, BSDF sampling
    /// finds its light as well. Both are the same if a picture is almost even.
    pub(super) fn with_compensation(
        image: &SphereImage,
        weight: impl Fn([f64; 3]) -> f32,
    ) -> Option<[Self; 2]> {
        let complete = Self::new(image, weight)?;
        let sum = complete.pixels.sum();
        let excess = complete.pixels.above(sum / (4.0 * PI), |row| image.solid_angle(row)).ok();
        let excess = excess.filter(|excess| excess.sum() > EVEN * sum);
        let compensated = excess.map_or_else(|| complete.clone(), |pixels| Self { pixels, ..complete });
        Some([complete, compensated])
    }

    /// A unit direction by two numbers uniform in [0, 1), with its density.
    pub(super) fn sample(&self, xi: DVec2) -> (DVec3, SolidAnglePdf) {
        let sample = self.pixels.sample(xi);
        let [_, row] = sample.cell;
        let direction = match self.mapping {
            SphereMapping::EqualArea => warp::equal_area_sphere(sample.point),
            SphereMapping::LatitudeLongitude => {
                // The share of the row's area that lies above.
                let share = sample.point.y * self.height as f64 - row as f64;
                self.direction_in_row(row, share, sample.point.x)
            }
        };
        (direction, self.per_solid_angle(sample.pdf, row))
    }

    /// The direction at longitude 2 pi `turn` below the share `share` of a row's area.
    fn direction_in_row(&self, row: usize, share: f64, turn: f64) -> DVec3 {
        // (1 - cos) / 2 of the angle from the pole, in which a sphere has equal areas.
        let drop = |row: f64| (0.5 * PI * row / self.height as f64).sin().powi(2);
        let (top, bottom) = (drop(row as f64), drop(row as f64 + 1.0));
        warp::uniform_sphere(DVec2::new(top + share.clamp(0.0, 1.0) * (bottom - top), turn))
    }

    /// The density of a unit direction.
    pub(super) fn pdf(&self, direction: DVec3) -> SolidAnglePdf {
        let place = self.mapping.place(direction);
        let row = (place.y * self.height as f64) as usize;
        self.per_solid_angle(self.pixels.pdf(place), row)
    }

    fn per_solid_angle(&self, pdf: f64, row: usize) -> SolidAnglePdf {
        SolidAnglePdf(match self.mapping {
            SphereMapping::EqualArea => 0.25 * FRAC_1_PI * pdf,
            SphereMapping::LatitudeLongitude => {
                pdf / (self.height as f64 * self.mapping.band(row, self.height))
            }
        })
    }
}
