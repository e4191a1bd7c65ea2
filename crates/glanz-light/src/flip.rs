//! FLIP: the visibility of the differences between two pictures to a viewer who flips between them.
//!
//! [`ldr`] compares display light (0 to 1); [`hdr`] compares scene light: it shows both pictures over the range of
//! exposures of the reference and takes the largest error of each pixel. Both give a map of errors between 0 (no visible
//! difference) and 1, and its mean.
//!
//! # Source
//! @andersson2020 (LDR), @andersson2021 (HDR); constants and the filmic display curve are those of the authors'
//! program, version 1.7, whose results the tests compare with.

mod colour;
mod filter;

use crate::compare::{CompareError, rgb_pair};
use crate::pixels::Pixels;
use colour::{hyab, lab_with_hunt, opponent_of, rgb_of_opponent};
use filter::{Kernel, blur, feature_kernels, spatial_kernels};

/// Pixels per degree of a 0.7 m wide display of 3840 pixels, seen from 0.7 m: the authors' default.
pub const PIXELS_PER_DEGREE: f64 = 3840.0 * std::f64::consts::PI / 180.0;

/// Exponent on the colour difference.
const COLOUR_EXPONENT: f64 = 0.7;
/// Fraction of the largest colour difference that is mapped to `KNEE_ERROR`.
const KNEE: f64 = 0.4;
/// Error at the knee.
const KNEE_ERROR: f64 = 0.95;
/// Exponent on the difference of edges and points.
const FEATURE_EXPONENT: f64 = 0.5;
/// Display value of the median of the reference at the highest exposure, and of its maximum at the lowest.
const TARGET: f64 = 0.85;

/// Errors of a picture, pixel by pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct FlipMap {
    /// Pixels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Error of each pixel in [0, 1], row by row from the top left.
    pub errors: Vec<f32>,
    /// Mean of the errors.
    pub mean: f64,
    /// Exposures at which the pictures were compared, in stops, ascending; the single 0 for [`ldr`].
    pub exposures: Vec<f64>,
}

/// Compares pictures of display light. Channels are clipped to [0, 1]; NaN counts as 0.
/// `pixels_per_degree`: resolution for the viewer, see [`PIXELS_PER_DEGREE`].
///
/// # Errors
/// [`CompareError::Size`], [`CompareError::NoColour`] or, if `pixels_per_degree` is not positive or
/// above a million, [`CompareError::Resolution`].
pub fn ldr(test: &Pixels, reference: &Pixels, pixels_per_degree: f64) -> Result<FlipMap, CompareError> {
    let (test, reference) = rgb_pair(test, reference)?;
    let evaluator = FlipEvaluator::try_new(reference.size, pixels_per_degree)?;
    let shown = |rgb: &[[f32; 3]]| rgb.iter().map(|p| p.map(clip)).collect::<Vec<_>>();
    let errors = evaluator.errors(&shown(&test.rgb), &shown(&reference.rgb));
    Ok(evaluator.map(errors, vec![0.0]))
}

/// Compares pictures of scene light. Negative light and NaN count as 0.
/// `pixels_per_degree`: resolution for the viewer, see [`PIXELS_PER_DEGREE`].
///
/// The exposures run from the one that shows the brightest pixel of the reference just below white to the one that
/// does so with its median. Departure: if the median is black, that of the pixels that are not black is taken; a black
/// reference is compared at exposure 0.
///
/// # Errors
/// As [`ldr`].
pub fn hdr(test: &Pixels, reference: &Pixels, pixels_per_degree: f64) -> Result<FlipMap, CompareError> {
    let (test, reference) = rgb_pair(test, reference)?;
    let evaluator = FlipEvaluator::try_new(reference.size, pixels_per_degree)?;
    let exposures = exposures(&reference.rgb);
    let mut worst = vec![0.0_f32; reference.rgb.len()];
    for &stops in &exposures {
        let gain = stops.exp2();
        let shown = |rgb: &[[f32; 3]]| rgb.iter().map(|p| p.map(|x| display(x, gain))).collect::<Vec<_>>();
        let errors = evaluator.errors(&shown(&test.rgb), &shown(&reference.rgb));
        for (worst, error) in worst.iter_mut().zip(errors) {
            *worst = worst.max(error);
        }
    }
    Ok(evaluator.map(worst, exposures))
}

fn clip(x: f32) -> f64 {
    if x > 0.0 { f64::from(x).min(1.0) } else { 0.0 }
}

/// Coefficients of the filmic display curve (a x^2 + b x) / (c x^2 + d x + e), @narkowicz2016 with input times 0.6.
const FILMIC: [f64; 5] = [0.36 * 2.51, 0.6 * 0.03, 0.36 * 2.43, 0.6 * 0.59, 0.14];

/// Display light of scene light `x` at the exposure `gain`.
fn display(x: f32, gain: f64) -> f64 {
    let [a, b, c, d, e] = FILMIC;
    let x = if x > 0.0 { f64::from(x.min(f32::MAX)) * gain } else { 0.0 };
    ((a * x * x + b * x) / (c * x * x + d * x + e)).clamp(0.0, 1.0)
}

/// Stops of each exposure, ascending (@andersson2021 section 4.1).
fn exposures(reference: &[[f32; 3]]) -> Vec<f64> {
    // The positive light that the curve maps to the target.
    let [a, b, c, d, e] = FILMIC;
    let (qa, qb, qc) = (a - TARGET * c, b - TARGET * d, -TARGET * e);
    let shown_at_target = (-qb + (qb * qb - 4.0 * qa * qc).sqrt()) / (2.0 * qa);
    let mut luminances: Vec<f64> = reference
        .iter()
        .map(|p| p.map(f64::from))
        .map(|[r, g, b]| 0.2126 * r + 0.7152 * g + 0.0722 * b)
        .map(|y| if y.is_finite() { y.max(0.0) } else { 0.0 })
        .collect();
    luminances.sort_by(f64::total_cmp);
    let median = |sorted: &[f64]| {
        // The authors take these two ranks for odd counts, too.
        let upper = sorted.get(sorted.len() / 2).copied();
        let lower = (sorted.len() / 2).checked_sub(1).and_then(|i| sorted.get(i)).copied();
        upper.map(|u| 0.5 * (u + lower.unwrap_or(u)))
    };
    let mut middle = median(&luminances).unwrap_or(0.0);
    if middle == 0.0 {
        let dark = luminances.partition_point(|&y| y == 0.0);
        middle = luminances.get(dark..).and_then(median).unwrap_or(0.0);
    }
    let brightest = luminances.last().copied().unwrap_or(0.0);
    if middle == 0.0 || brightest == 0.0 {
        return vec![0.0];
    }
    let (start, stop) = ((shown_at_target / brightest).log2(), (shown_at_target / middle).log2());
    let count = ((stop - start).ceil() as usize).max(2);
    (0..count).map(|i| start + (stop - start) * i as f64 / (count - 1) as f64).collect()
}

/// FLIP of pictures of one size at one resolution.
struct FlipEvaluator {
    width: usize,
    height: usize,
    /// Kernels of the contrast sensitivity: Y, Cx, and two whose results add up to Cz.
    spatial: [Kernel; 4],
    /// A Gaussian and its first and second derivative.
    feature: [Kernel; 3],
    /// Largest colour difference.
    largest: f64,
}

impl FlipEvaluator {
    fn try_new((width, height): (u32, u32), pixels_per_degree: f64) -> Result<Self, CompareError> {
        // Beyond this a kernel would be wider than any picture.
        if !(pixels_per_degree > 0.0 && pixels_per_degree <= 1e6) {
            return Err(CompareError::Resolution(pixels_per_degree));
        }
        let green = lab_with_hunt([0.0, 1.0, 0.0]);
        let blue = lab_with_hunt([0.0, 0.0, 1.0]);
        Ok(Self {
            width: width as usize,
            height: height as usize,
            spatial: spatial_kernels(pixels_per_degree),
            feature: feature_kernels(pixels_per_degree),
            largest: hyab(green, blue).powf(COLOUR_EXPONENT),
        })
    }

    /// The map of `errors` with their mean.
    fn map(&self, errors: Vec<f32>, exposures: Vec<f64>) -> FlipMap {
        let mean = errors.iter().map(|&e| f64::from(e)).sum::<f64>() / errors.len() as f64;
        FlipMap { width: self.width as u32, height: self.height as u32, errors, mean, exposures }
    }

    /// FLIP errors of pictures of display light in [0, 1].
    fn errors(&self, test: &[[f64; 3]], reference: &[[f64; 3]]) -> Vec<f32> {
        let (test, reference) = (planes(test), planes(reference));
        let colour = self.perceived(&test).into_iter().zip(self.perceived(&reference));
        let colour = colour.map(|(t, r)| self.redistributed(hyab(t, r).powf(COLOUR_EXPONENT)));
        let feature = self.features(&test[0]).into_iter().zip(self.features(&reference[0]));
        let feature = feature.map(|([edge_t, point_t], [edge_r, point_r])| {
            let larger = (edge_t - edge_r).abs().max((point_t - point_r).abs());
            (f64::from(larger) * std::f64::consts::FRAC_1_SQRT_2).powf(FEATURE_EXPONENT)
        });
        colour.zip(feature).map(|(colour, feature)| colour.powf(1.0 - feature) as f32).collect()
    }

    /// Colours after the eye's blur, in L*a*b* with the Hunt effect.
    fn perceived(&self, [y, cx, cz]: &[Vec<f32>; 3]) -> Vec<[f64; 3]> {
        let blur = |plane: &[f32], kernel: &Kernel| blur(plane, self.width, self.height, kernel, kernel);
        let [ky, kx, kz1, kz2] = &self.spatial;
        let (y, cx) = (blur(y, ky), blur(cx, kx));
        let (cz1, cz2) = (blur(cz, kz1), blur(cz, kz2));
        let opponent = y.iter().zip(&cx).zip(cz1.iter().zip(&cz2));
        opponent
            .map(|((&y, &cx), (&cz1, &cz2))| [y, cx, cz1 + cz2].map(f64::from))
            .map(|o| lab_with_hunt(rgb_of_opponent(o).map(|x| x.clamp(0.0, 1.0))))
            .collect()
    }

    /// Strength of edges and of points.
    fn features(&self, y: &[f32]) -> Vec<[f32; 2]> {
        let grey: Vec<f32> = y.iter().map(|y| (y + 16.0) / 116.0).collect();
        let [smooth, first, second] = &self.feature;
        let blur = |kx: &Kernel, ky: &Kernel| blur(&grey, self.width, self.height, kx, ky);
        let edge = blur(first, smooth).into_iter().zip(blur(smooth, first)).map(|(a, b)| a.hypot(b));
        let point = blur(second, smooth).into_iter().zip(blur(smooth, second)).map(|(a, b)| a.hypot(b));
        edge.zip(point).map(|(e, p)| [e, p]).collect()
    }

    /// Colour differences from 0 to `largest`, spread over [0, 1] in two linear pieces.
    fn redistributed(&self, difference: f64) -> f64 {
        let knee = KNEE * self.largest;
        if difference < knee {
            difference * KNEE_ERROR / knee
        } else {
            KNEE_ERROR + (difference - knee) / (self.largest - knee) * (1.0 - KNEE_ERROR)
        }
    }
}

/// The opponent planes Y, Cx, Cz of display light.
fn planes(rgb: &[[f64; 3]]) -> [Vec<f32>; 3] {
    let mut planes = [const { Vec::new() }; 3];
    for &pixel in rgb {
        for (plane, value) in planes.iter_mut().zip(opponent_of(pixel)) {
            plane.push(value as f32);
        }
    }
    planes
}

#[cfg(test)]
mod tests;
