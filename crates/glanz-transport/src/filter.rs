//! Pixel filters, sampled by importance.
//!
//! A sample of a pixel is placed around the pixel's middle with a density proportional to the magnitude of the filter,
//! so that every sample has the same weight and belongs to one pixel alone (@ernst2006). Where the filter is negative, the
//! sample is subtracted.

use std::f64::consts::PI;
use std::ops::Range;

use glanz_math::DVec2;
use glanz_sampling::warp::concentric_disk;
use glanz_scene::description::{FilterDescription, FilterKind};

use self::profile::{FilterProfile, ProfileError};
use crate::pixel_rect::PixelRect;

mod profile;

/// Errors of building a filter.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FilterError {
    /// A radius that is not positive and finite.
    #[error("filter radius {0} x {1} must be positive and finite")]
    Radius(f64, f64),
    /// A parameter outside its range.
    #[error("filter parameter {name} is {value}; it must be {range}")]
    Parameter {
        /// Its name.
        name: &'static str,
        /// Its value.
        value: f64,
        /// The allowed values.
        range: &'static str,
    },
    /// Negative lobes that nearly cancel the rest of the filter, which would make the picture too noisy.
    #[error("the negative lobes of the filter leave {0} of its weight, less than {1}")]
    Lobes(f64, f64),
}

/// Position and weight of a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilterSample {
    /// Offset from the middle of the pixel, pixels.
    pub offset: DVec2,
    /// Whether the filter is negative there.
    pub negative: bool,
}

/// A filter about the middle of a pixel.
#[derive(Clone, Debug)]
pub struct Filter {
    radius: DVec2,
    shape: FilterShape,
    description: FilterDescription,
}

#[derive(Clone, Debug)]
enum FilterShape {
    /// Constant over the rectangle.
    Box,
    /// Product of two tents.
    Triangle,
    /// Product of two tabulated profiles over [0, 1], one per axis.
    Separable(Box<[FilterProfile; 2]>),
    /// Constant over the ellipse.
    Cylinder,
    /// `1 - max(|x|, |y|)`.
    Pyramid,
    /// `1 - sqrt(x^2 + y^2)`.
    Cone,
}

/// Smallest net weight of a filter with negative lobes, as a fraction; the noise of a pixel grows by its reciprocal.
const SMALLEST_NET_WEIGHT: f64 = 0.25;

impl Filter {
    /// The filter of `description`.
    ///
    /// Gaussian, Mitchell and sinc are tabulated as piecewise linear profiles that deviate from the formula by at most 2e-6 of
    /// the peak (the error of chords, @davis1975 section 3.1); the others are exact.
    ///
    /// # Errors
    /// [`FilterError`] for radii or parameters outside their ranges.
    ///
    /// # Source
    /// @mitchell1988; document 003 section 5.7.3; the Gaussian is lowered by its value at the border, @pharr2023 section 8.8.3.
    pub fn try_new(description: &FilterDescription) -> Result<Self, FilterError> {
        let [x, y] = description.radius;
        if !(x > 0.0 && y > 0.0 && x.is_finite() && y.is_finite()) {
            return Err(FilterError::Radius(x, y));
        }
        let shape = match description.kind {
            FilterKind::Box => FilterShape::Box,
            FilterKind::Triangle => FilterShape::Triangle,
            FilterKind::Cylinder => FilterShape::Cylinder,
            FilterKind::Pyramid => FilterShape::Pyramid,
            FilterKind::Cone => FilterShape::Cone,
            FilterKind::Gaussian { sigma } => {
                if !(sigma > 0.0 && sigma.is_finite()) {
                    return Err(FilterError::Parameter {
                        name: "sigma",
                        value: sigma,
                        range: "positive and finite",
                    });
                }
                FilterShape::Separable(Box::new([gaussian(x, sigma)?, gaussian(y, sigma)?]))
            }
            FilterKind::Sinc { tau } => {
                if !(tau > 0.0 && tau.is_finite()) {
                    return Err(FilterError::Parameter {
                        name: "tau",
                        value: tau,
                        range: "positive and finite",
                    });
                }
                FilterShape::Separable(Box::new([sinc(x, tau)?, sinc(y, tau)?]))
            }
            FilterKind::Mitchell { b, c } => {
                for (name, value) in [("B", b), ("C", c)] {
                    if !value.is_finite() {
                        return Err(FilterError::Parameter { name, value, range: "finite" });
                    }
                }
                let profile = mitchell(b, c)?;
                FilterShape::Separable(Box::new([profile.clone(), profile]))
            }
        };
        let filter = Self { radius: DVec2::new(x, y), shape, description: *description };
        let net = filter.net_weight();
        if net < SMALLEST_NET_WEIGHT {
            return Err(FilterError::Lobes(net, SMALLEST_NET_WEIGHT));
        }
        Ok(filter)
    }

    /// The description of the filter.
    #[must_use]
    pub fn description(&self) -> &FilterDescription {
        &self.description
    }

    /// Half the extent of its support, pixels.
    #[must_use]
    pub fn radius(&self) -> DVec2 {
        self.radius
    }

    /// True if it is negative anywhere.
    #[must_use]
    pub fn is_signed(&self) -> bool {
        match &self.shape {
            FilterShape::Separable(profiles) => profiles.iter().any(|p| p.net_weight() < 1.0),
            _ => false,
        }
    }

    /// Integral of the filter over that of its magnitude, in (0, 1].
    #[must_use]
    pub fn net_weight(&self) -> f64 {
        match &self.shape {
            FilterShape::Separable(profiles) => profiles.iter().map(FilterProfile::net_weight).product(),
            _ => 1.0,
        }
    }

    /// The filter at `offset` (pixels from the middle), with an integral of 1 over its support.
    #[must_use]
    pub fn evaluate(&self, offset: DVec2) -> f64 {
        self.density(offset) / self.net_weight()
    }

    /// Density per square pixel with which [`Filter::sample`] places a sample at `offset`.
    #[must_use]
    pub fn pdf(&self, offset: DVec2) -> f64 {
        self.density(offset).abs()
    }

    /// The filter, scaled so that its magnitude has an integral of 1.
    fn density(&self, offset: DVec2) -> f64 {
        let p = (offset / self.radius).abs();
        if p.max_element() > 1.0 {
            return 0.0;
        }
        let area = self.radius.x * self.radius.y;
        let value = match &self.shape {
            FilterShape::Box => 0.25,
            FilterShape::Triangle => (1.0 - p.x) * (1.0 - p.y),
            FilterShape::Separable(profiles) => profiles[0].density(p.x) * profiles[1].density(p.y) * 0.25,
            FilterShape::Cylinder if p.length_squared() <= 1.0 => std::f64::consts::FRAC_1_PI,
            FilterShape::Cylinder => 0.0,
            // Volume of a pyramid over a square of side 2, of a cone over the unit disk, both of height 1.
            FilterShape::Pyramid => (1.0 - p.max_element()) * (3.0 / 4.0),
            FilterShape::Cone => (1.0 - p.length()).max(0.0) * (3.0 * std::f64::consts::FRAC_1_PI),
        };
        value / area
    }

    /// A pixel of `pixels` whose filter reaches the film point `film`, selected by `xi`, uniform in [0, 1), and the factor for light at the
    /// point.
    ///
    /// Pixels are selected in proportion to the magnitude of their filters there; the factor is the sum of these magnitudes, with the sign
    /// of the selected one, so that each pixel receives [`Filter::evaluate`] on average. `None` if no filter reaches the point.
    #[must_use]
    pub fn pick_pixel(&self, film: DVec2, pixels: &PixelRect, xi: f64) -> Option<([u32; 2], f64)> {
        let [columns, rows] = [0, 1].map(|axis| self.reached(film, pixels, axis));
        let all = || rows.clone().flat_map(|y| columns.clone().map(move |x| [x, y]));
        let value = |pixel: [u32; 2]| {
            let middle = DVec2::new(f64::from(pixel[0]) + 0.5, f64::from(pixel[1]) + 0.5);
            self.evaluate(film - middle)
        };
        let sum: f64 = all().map(|pixel| value(pixel).abs()).sum();
        let mut rest = xi * sum;
        let mut picked = None;
        for pixel in all() {
            let own = value(pixel);
            if own != 0.0 {
                picked = Some((pixel, sum.copysign(own)));
                rest -= own.abs();
                // A remainder from rounding at the end belongs to the last pixel.
                if rest < 0.0 {
                    break;
                }
            }
        }
        picked
    }

    /// Columns or rows of `pixels` whose middles are within the radius of `film`.
    fn reached(&self, film: DVec2, pixels: &PixelRect, axis: usize) -> Range<u32> {
        let first = (film[axis] - self.radius[axis] - 0.5).ceil();
        let end = (film[axis] + self.radius[axis] - 0.5).floor() + 1.0;
        let [low, high] = [pixels.min[axis], pixels.min[axis].saturating_add(pixels.size[axis])];
        // Casts saturate at the range of u32, and map NaN to 0.
        (first as u32).max(low)..(end as u32).min(high)
    }

    /// Maps two numbers uniform in [0, 1) to a sample. (1/2, 1/2) is mapped to the middle, and neighbours to neighbours,
    /// so that well distributed numbers give well distributed samples.
    #[must_use]
    pub fn sample(&self, xi: DVec2) -> FilterSample {
        let s = 2.0 * xi - 1.0;
        let mut negative = false;
        let unit = match &self.shape {
            FilterShape::Box => s,
            FilterShape::Triangle => DVec2::new(tent(s.x), tent(s.y)),
            FilterShape::Separable(profiles) => {
                let x = profiles[0].sample(s.x.abs());
                let y = profiles[1].sample(s.y.abs());
                negative = x.1 != y.1;
                DVec2::new(x.0.copysign(s.x), y.0.copysign(s.y))
            }
            FilterShape::Cylinder => concentric_disk(xi),
            FilterShape::Pyramid => s * linear_fall(s),
            FilterShape::Cone => concentric_disk(xi) * linear_fall(s),
        };
        FilterSample { offset: unit * self.radius, negative }
    }
}

/// Maps uniform numbers in [-1, 1) to the density `1 - |x|`.
fn tent(s: f64) -> f64 {
    // 1 - sqrt(1 - |s|) without cancellation near 0.
    (s.abs() / (1.0 + (1.0 - s.abs()).sqrt())).copysign(s)
}

/// The factor by which a point of the square [-1, 1]^2 moves towards the middle so that the density decreases linearly.
///
/// The square (or disk) of radius m contains the fraction m^2 of uniform points; that of radius r contains the fraction 3 r^2 - 2 r^3 of
/// points of the required density. Equating the two, with r = 1/2 + sin(a), gives sin(3 a) = 2 m^2 - 1.
fn linear_fall(s: DVec2) -> f64 {
    let m = s.abs().max_element();
    if m == 0.0 {
        return 1.0;
    }
    let r = if m < 1e-3 {
        // The sine loses all digits to cancellation here; 3 r^2 - 2 r^3 = m^2 is r = m / sqrt(3 - 2 r), iterated: each
        // round shrinks the error by r / (3 - 2 r) < 2e-4.
        (0..5).fold(m, |r, _| m / (3.0 - 2.0 * r).sqrt())
    } else {
        0.5 + ((2.0 * m * m - 1.0).asin() / 3.0).sin()
    };
    r.clamp(0.0, 1.0) / m
}

fn gaussian(radius: f64, sigma: f64) -> Result<FilterProfile, FilterError> {
    let k = radius / sigma;
    let border = -0.5 * k * k;
    let value = |x: f64| {
        let exponent = -0.5 * k * k * x * x;
        // The difference of two numbers near 1 loses its digits to cancellation; expm1 keeps them.
        if k < 1.0 { border.exp() * (exponent - border).exp_m1() } else { exponent.exp() - border.exp() }
    };
    // The second derivative is largest in the middle: k^2, where the peak is 1 - exp(border).
    let curvature = k * k / -border.exp_m1();
    FilterProfile::try_new(value, curvature).map_err(|error| match error {
        ProfileError::Resolution => FilterError::Parameter {
            name: "sigma",
            value: sigma,
            range: "at least 1/4000 of the filter radius",
        },
        ProfileError::Empty => FilterError::Parameter {
            name: "sigma",
            value: sigma,
            range: "less than 10^100 times the filter radius",
        },
    })
}

fn mitchell(b: f64, c: f64) -> Result<FilterProfile, FilterError> {
    let value = |x: f64| {
        let x = 2.0 * x;
        if x < 1.0 {
            ((12.0 - 9.0 * b - 6.0 * c) * x + (-18.0 + 12.0 * b + 6.0 * c)) * x * x + (6.0 - 2.0 * b)
        } else {
            (((-b - 6.0 * c) * x + (6.0 * b + 30.0 * c)) * x + (-12.0 * b - 48.0 * c)) * x
                + (8.0 * b + 24.0 * c)
        }
    };
    let range = "such that the filter is positive in the middle";
    let peak = 6.0 - 2.0 * b;
    if peak <= 0.0 {
        return Err(FilterError::Parameter { name: "B", value: b, range: "below 3" });
    }
    // The second derivative is linear in each piece: its extremes are at the ends. Factor 4: x = 2 t.
    let ends = [
        2.0 * (-18.0 + 12.0 * b + 6.0 * c),
        6.0 * (12.0 - 9.0 * b - 6.0 * c) + 2.0 * (-18.0 + 12.0 * b + 6.0 * c),
        6.0 * (-b - 6.0 * c) + 2.0 * (6.0 * b + 30.0 * c),
        12.0 * (-b - 6.0 * c) + 2.0 * (6.0 * b + 30.0 * c),
    ];
    let curvature = 4.0 * ends.into_iter().map(f64::abs).fold(0.0, f64::max) / peak;
    FilterProfile::try_new(value, curvature).map_err(|_| FilterError::Parameter {
        name: "B",
        value: b,
        range,
    })
}

/// Lanczos' filter: the sine cardinal within a wider one, cut off at the radius.
fn sinc(radius: f64, tau: f64) -> Result<FilterProfile, FilterError> {
    let cardinal = |x: f64| if x == 0.0 { 1.0 } else { (PI * x).sin() / (PI * x) };
    let value = |x: f64| cardinal(radius * x) * cardinal(radius * x / tau);
    // The sine cardinal is the mean of cos(pi k x) over k in [0, 1], so that its derivatives are at most pi / 2 and pi^2 / 3.
    let curvature = (PI * radius).powi(2) * (1.0 / 3.0 + 0.5 / tau + 1.0 / (3.0 * tau * tau));
    FilterProfile::try_new(value, curvature).map_err(|_| FilterError::Parameter {
        name: "tau",
        value: tau,
        range: "larger, or the filter radius smaller",
    })
}

#[cfg(test)]
mod tests;
