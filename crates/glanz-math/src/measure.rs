//! Probability densities with their measure in the type.

/// Probability per square metre of surface.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct AreaPdf(pub f64);

impl AreaPdf {
    /// The same density per steradian, seen from `distance_squared` (m^2) under `cos` to the surface normal.
    ///
    /// Infinite where the surface is seen edge-on.
    #[inline]
    #[must_use]
    pub fn to_solid_angle(self, distance_squared: f64, cos: f64) -> SolidAnglePdf {
        SolidAnglePdf(self.0 * distance_squared / cos.abs())
    }
}

/// Probability per steradian of direction.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct SolidAnglePdf(pub f64);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unit_disk_seen_from_afar_has_the_density_of_its_solid_angle() {
        // A small disk of area A at distance d, facing the viewer, spans A / d^2 steradians.
        let (area, distance) = (1e-4, 10.0);
        let pdf = AreaPdf(1.0 / area).to_solid_angle(distance * distance, 1.0);
        assert!((pdf.0 - distance * distance / area).abs() < 1e-6);
    }
}
