//! Film and pixel filter.

use super::Location;

/// Size and crop window of the picture.
#[derive(Clone, Debug)]
pub struct FilmDescription {
    /// Width and height of the full picture, pixels.
    pub resolution: [u32; 2],
    /// The crop window as fractions: smallest and largest x, then y, from the top left.
    pub crop: [f64; 4],
    /// The file that the scene names.
    pub file_name: Option<String>,
    /// Its place in the input.
    pub location: Option<Location>,
}

impl Default for FilmDescription {
    fn default() -> Self {
        Self { resolution: [1280, 720], crop: [0.0, 1.0, 0.0, 1.0], file_name: None, location: None }
    }
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
    /// Constant over an ellipse (document 003 section 5.7.3).
    Cylinder,
    /// Linear fall from the middle to the border of the rectangle (document 003 section 5.7.3).
    Pyramid,
    /// Linear fall from the middle to the border of the ellipse (document 003 section 5.7.3).
    Cone,
}
