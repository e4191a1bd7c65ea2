//! Film and pixel filter.

use super::Location;

/// Size, crop window and sensor of the picture.
#[derive(Clone, Debug)]
pub struct FilmDescription {
    /// Width and height of the full picture, pixels.
    pub resolution: [u32; 2],
    /// The crop window as fractions: smallest and largest x, then y, from the top left.
    pub crop: [f64; 4],
    /// Length of the diagonal of the full picture on the film, metres; for [`CameraKind::Realistic`](super::CameraKind::Realistic).
    pub diagonal: f64,
    /// The sensor.
    pub sensor: SensorDescription,
    /// The file that the scene names.
    pub file_name: Option<String>,
    /// Its place in the input.
    pub location: Option<Location>,
}

impl Default for FilmDescription {
    fn default() -> Self {
        Self {
            resolution: [1280, 720],
            crop: [0.0, 1.0, 0.0, 1.0],
            diagonal: 0.035,
            sensor: SensorDescription::default(),
            file_name: None,
            location: None,
        }
    }
}

/// The sensor, which makes the values of the picture of radiance; by default it changes nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorDescription {
    /// Factor of all values: pbrt's imaging ratio.
    pub exposure: f64,
    /// Temperature of the light that the picture shows as white (D65), kelvin: CIE daylight, below 4000 K a black body. `None`: no adaptation.
    pub white_balance: Option<f64>,
    /// Limit of single samples.
    pub limit: SampleLimit,
}

impl Default for SensorDescription {
    fn default() -> Self {
        Self { exposure: 1.0, white_balance: None, limit: SampleLimit::None }
    }
}

/// Limit of single samples: brighter ones are scaled down to it, so that the picture has less noise and is darker than it should be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SampleLimit {
    /// No limit.
    None,
    /// Of the largest of red, green and blue, positive.
    Component(f64),
    /// Of the luminance, positive.
    Luminance(f64),
}

/// A pixel filter; radii in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilterDescription {
    /// Its shape.
    pub kind: FilterKind,
    /// Half the width of its support along x and y, pixels.
    pub radius: [f64; 2],
}

impl Default for FilterDescription {
    fn default() -> Self {
        Self { kind: FilterKind::Gaussian { sigma: 0.5 }, radius: [1.5, 1.5] }
    }
}

/// Shapes of pixel filters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FilterKind {
    /// Constant over a rectangle.
    Box,
    /// Linear fall along each axis; product of two tents.
    Triangle,
    /// Gaussian minus its value at the border.
    Gaussian {
        /// Standard deviation, pixels.
        sigma: f64,
    },
    /// Piecewise cubic with negative lobes.
    Mitchell {
        /// Parameter B of @mitchell1988.
        b: f64,
        /// Parameter C of @mitchell1988.
        c: f64,
    },
    /// Sine cardinal of the distance, windowed by one that is wider (Lanczos); with negative lobes.
    Sinc {
        /// Width of the window relative to that of the inner function, above 0.
        tau: f64,
    },
    /// Constant over an ellipse (document 003 section 5.7.3).
    Cylinder,
    /// Linear fall from the middle to the border of the rectangle (document 003 section 5.7.3).
    Pyramid,
    /// Linear fall from the middle to the border of the ellipse (document 003 section 5.7.3).
    Cone,
}
