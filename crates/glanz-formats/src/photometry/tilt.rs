//! Dependence of a lamp's light on its tilt.

/// Geometry of the lamp in the luminaire.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LampGeometry {
    /// Vertical, base up or down, when the luminaire points straight down.
    Vertical,
    /// Horizontal, also when the luminaire is tilted.
    Horizontal,
    /// Horizontal, and tilts with the luminaire.
    Tilting,
}

/// Factors on the intensities by the angle of the lamp.
///
/// Readers do not apply these factors, because the angle depends on the installation; apply them with
/// [`Photometry::scaled_by`](super::Photometry::scaled_by) and [`Tilt::factor`].
#[derive(Clone, Debug, PartialEq)]
pub struct Tilt {
    /// Geometry of the lamp.
    pub geometry: LampGeometry,
    /// Angles of the lamp from the position of the measurement, in degrees from 0, ascending, at least one.
    pub angles: Vec<f64>,
    /// Factors at these angles.
    pub factors: Vec<f64>,
}

impl Tilt {
    /// The factor at an angle in degrees: linear between the given angles, constant outside; only the magnitude of the angle counts.
    #[must_use]
    pub fn factor(&self, degrees: f64) -> f64 {
        let angle = degrees.abs();
        let after = self.angles.partition_point(|&a| a <= angle);
        let at = |i: usize| self.angles.get(i).copied().zip(self.factors.get(i).copied());
        match (after.checked_sub(1).and_then(at), at(after)) {
            (Some((a, f)), Some((b, g))) => f + (g - f) * (angle - a) / (b - a),
            (Some((_, f)), None) | (None, Some((_, f))) => f,
            (None, None) => 1.0,
        }
    }
}
