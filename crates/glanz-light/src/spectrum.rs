//! Spectral values along a path.

use std::iter::Sum;
use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub};

use crate::sampled_wavelengths::SampledWavelengths;

/// Number of lanes of a [`Spectrum`].
pub const LANES: usize = 4;

/// Meaning of the lanes of a [`Spectrum`] along one path.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
#[non_exhaustive]
pub enum Wavelengths {
    /// Three lanes hold linear Rec. 709 red, green and blue, the fourth is unused and zero.
    #[default]
    Rgb,
    /// Every lane holds the value at one wavelength.
    Sampled(SampledWavelengths),
}

/// Radiance, throughput or reflectance in [`LANES`] lanes; [`Wavelengths`] gives their meaning.
///
/// Arithmetic is lane by lane. Only this crate reads single lanes, except for the [`hero`](Self::hero).
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Spectrum(pub(crate) [f32; LANES]);

impl Spectrum {
    /// No light.
    pub const BLACK: Self = Self([0.0; LANES]);
    /// One in every lane.
    pub const ONE: Self = Self([1.0; LANES]);

    /// One in each lane in use.
    #[must_use]
    pub fn one(wavelengths: &Wavelengths) -> Self {
        match wavelengths {
            Wavelengths::Rgb => Self::from_rgb([1.0; 3]),
            Wavelengths::Sampled(_) => Self::ONE,
        }
    }

    /// The same value in every lane.
    #[must_use]
    pub const fn splat(value: f32) -> Self {
        Self([value; LANES])
    }

    /// Linear Rec. 709 values, for [`Wavelengths::Rgb`].
    #[must_use]
    pub const fn from_rgb(rgb: [f32; 3]) -> Self {
        Self([rgb[0], rgb[1], rgb[2], 0.0])
    }

    /// Linear Rec. 709 values of this spectrum; of sampled wavelengths an estimate, whose components may be negative.
    #[must_use]
    pub fn to_rgb(self, wavelengths: &Wavelengths) -> [f32; 3] {
        match wavelengths {
            Wavelengths::Rgb => [self.0[0], self.0[1], self.0[2]],
            Wavelengths::Sampled(sampled) => sampled.rgb(self),
        }
    }

    /// A reflectance or another quantity in linear Rec. 709, as a smooth spectrum at `wavelengths`.
    ///
    /// Linear, so that it commutes with interpolation; the same grey for grey.
    #[inline]
    #[must_use]
    pub fn upsampled(self, wavelengths: &Wavelengths) -> Self {
        match wavelengths {
            Wavelengths::Rgb => self,
            Wavelengths::Sampled(sampled) => sampled.upsampled(self),
        }
    }

    /// Light in linear Rec. 709, as a smooth spectrum at `wavelengths`: white is daylight D65.
    #[inline]
    #[must_use]
    pub fn upsampled_light(self, wavelengths: &Wavelengths) -> Self {
        match wavelengths {
            Wavelengths::Rgb => self,
            Wavelengths::Sampled(sampled) => sampled.upsampled(self) * sampled.daylight(),
        }
    }

    /// The value at the first of the sampled wavelengths, the hero.
    #[must_use]
    pub fn hero(self) -> f32 {
        self.0[0]
    }

    /// The hero alone, which represents all wavelengths from now on: it counts for all lanes, and the others are zero.
    ///
    /// Its own density is that of each lane, so that the mean over random wavelengths stays the same.
    ///
    /// # Source
    /// `SampledWavelengths::TerminateSecondary` of @pharr2023 section 4.5.4; departure: the values change instead of the densities, so
    /// that light which a path has gathered before keeps all lanes.
    #[must_use]
    pub fn hero_alone(self) -> Self {
        let mut alone = [0.0; LANES];
        alone[0] = LANES as f32 * self.0[0];
        Self(alone)
    }

    /// Luminance (CIE Y, Rec. 709 primaries); 1 for red, green and blue of 1.
    #[must_use]
    pub fn luminance(self, wavelengths: &Wavelengths) -> f32 {
        let [r, g, b] = self.to_rgb(wavelengths);
        0.212_639 * r + 0.715_169 * g + 0.072_192 * b
    }

    /// Whether every lane is zero.
    #[must_use]
    pub fn is_black(self) -> bool {
        self.0.iter().all(|&x| x == 0.0)
    }

    /// Whether every lane is finite.
    #[must_use]
    pub fn is_finite(self) -> bool {
        self.0.iter().all(|x| x.is_finite())
    }

    /// The largest lane.
    #[must_use]
    pub fn max_component(self) -> f32 {
        self.0.iter().fold(f32::NEG_INFINITY, |a, &b| a.max(b))
    }

    /// The mean of the lanes in use.
    #[must_use]
    pub fn mean(self, wavelengths: &Wavelengths) -> f32 {
        match wavelengths {
            Wavelengths::Rgb => (self.0[0] + self.0[1] + self.0[2]) / 3.0,
            Wavelengths::Sampled(_) => self.sum_of_lanes() / LANES as f32,
        }
    }

    /// The sum of all lanes.
    pub(crate) fn sum_of_lanes(self) -> f32 {
        self.0.iter().sum()
    }

    /// `f` in every lane.
    #[must_use]
    pub fn map(self, f: impl Fn(f32) -> f32) -> Self {
        Self(self.0.map(f))
    }

    /// `f` of the lanes of both spectra.
    #[must_use]
    pub fn zip(self, other: Self, f: impl Fn(f32, f32) -> f32) -> Self {
        Self(std::array::from_fn(|i| f(self.0[i], other.0[i])))
    }

    /// Each lane clamped to [low, high].
    #[must_use]
    pub fn clamp(self, low: f32, high: f32) -> Self {
        self.map(|x| x.clamp(low, high))
    }

    /// Square root, lane by lane.
    #[must_use]
    pub fn sqrt(self) -> Self {
        self.map(f32::sqrt)
    }

    /// `(1 - t) self + t other`.
    #[must_use]
    pub fn lerp(self, other: Self, t: f32) -> Self {
        self * (1.0 - t) + other * t
    }
}

impl Add for Spectrum {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
}

impl AddAssign for Spectrum {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Sub for Spectrum {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b)
    }
}

impl Neg for Spectrum {
    type Output = Self;
    fn neg(self) -> Self {
        self.map(|a| -a)
    }
}

impl Mul for Spectrum {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        self.zip(other, |a, b| a * b)
    }
}

impl MulAssign for Spectrum {
    fn mul_assign(&mut self, other: Self) {
        *self = *self * other;
    }
}

impl Mul<f32> for Spectrum {
    type Output = Self;
    fn mul(self, factor: f32) -> Self {
        self.map(|a| a * factor)
    }
}

impl Mul<Spectrum> for f32 {
    type Output = Spectrum;
    fn mul(self, spectrum: Spectrum) -> Spectrum {
        spectrum * self
    }
}

impl MulAssign<f32> for Spectrum {
    fn mul_assign(&mut self, factor: f32) {
        *self = *self * factor;
    }
}

impl Div<f32> for Spectrum {
    type Output = Self;
    fn div(self, divisor: f32) -> Self {
        self.map(|a| a / divisor)
    }
}

impl Sum for Spectrum {
    fn sum<I: Iterator<Item = Self>>(iter: I) -> Self {
        iter.fold(Self::BLACK, Add::add)
    }
}
