//! The range of the azimuth about the z axis.

use std::f64::consts::{FRAC_PI_2, TAU};

use glanz_math::angle::sin_cos_of_turn;
use glanz_math::rounding::gamma;
use glanz_math::{Bounds3, DVec2, DVec3};

use crate::error::{SurfaceError, positive};

/// The azimuths from 0 to `phi_max`, measured from +x to +y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct AzimuthRange {
    phi_max: f64,
}

impl AzimuthRange {
    /// Checks `phi_max`; values above 2 pi are a full turn, as in pbrt.
    pub(super) fn try_new(phi_max: f64) -> Result<Self, SurfaceError> {
        Ok(Self { phi_max: positive("phi_max", phi_max)?.min(TAU) })
    }

    /// The largest azimuth.
    pub(super) fn phi_max(self) -> f64 {
        self.phi_max
    }

    /// The azimuth of `(x, y)` as a fraction of the range; `None` outside.
    pub(super) fn parameter(self, x: f64, y: f64) -> Option<f64> {
        let phi = y.atan2(x);
        let phi = if phi < 0.0 { phi + TAU } else { phi };
        // A full turn has no border, so that rounding cannot open a gap at the seam.
        (phi <= self.phi_max || self.phi_max >= TAU).then(|| (phi / self.phi_max).min(1.0))
    }

    /// The unit vector at the fraction `u` of the range.
    pub(super) fn direction(self, u: f64) -> DVec2 {
        let (sin, cos) = sin_cos_of_turn(u * (self.phi_max / TAU));
        DVec2::new(cos, sin)
    }

    /// The unit vector from the axis towards `p`; on the axis, the unit vector at `u`.
    pub(super) fn direction_at(self, p: DVec3, u: impl FnOnce() -> f64) -> DVec2 {
        p.truncate().try_normalize().unwrap_or_else(|| self.direction(u()))
    }

    /// Derivative of a revolved point by the fraction of the range.
    pub(super) fn derivative(self, p: DVec3) -> DVec3 {
        DVec3::new(-p.y, p.x, 0.0) * self.phi_max
    }

    /// A box around all points with radius and height in the given ranges.
    pub(super) fn bounds(self, radii: [f64; 2], heights: [f64; 2]) -> Bounds3 {
        let ends = [0.0, 1.0].map(|u| self.direction(u));
        let mut flat = ends.iter().flat_map(|&e| radii.map(|r| e * r)).collect::<Vec<_>>();
        for quarter in 1..4 {
            let phi = f64::from(quarter) * FRAC_PI_2;
            if phi <= self.phi_max {
                flat.push([DVec2::Y, -DVec2::X, -DVec2::Y][quarter as usize % 4 - 1] * radii[1]);
            }
        }
        let [low, high] = heights;
        let bounds = Bounds3::from_points(flat.iter().flat_map(|p| [p.extend(low), p.extend(high)]));
        widened(bounds)
    }
}

/// The box widened by the rounding errors of points in it: refined hits are within a few units in the last place of the
/// largest coordinate.
pub(super) fn widened(bounds: Bounds3) -> Bounds3 {
    let reach = bounds.min.abs().max(bounds.max.abs()).max_element();
    bounds.expanded(gamma(64) * reach)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn azimuths_run_from_x_over_y() {
        let half = AzimuthRange::try_new(std::f64::consts::PI).unwrap();
        assert_eq!(half.parameter(1.0, 0.0), Some(0.0));
        assert_eq!(half.parameter(0.0, 2.0), Some(0.5));
        assert_eq!(half.parameter(-1.0, 0.0), Some(1.0));
        assert_eq!(half.parameter(0.0, -1.0), None);
    }

    #[test]
    fn a_full_turn_has_no_seam() {
        let full = AzimuthRange::try_new(7.0).unwrap();
        assert_eq!(full.phi_max(), TAU);
        for y in [-1e-300, -0.0, 0.0, 1e-300] {
            assert!(full.parameter(1.0, y).is_some());
        }
    }

    #[test]
    fn bounds_of_a_quarter_ring_are_its_own() {
        let quarter = AzimuthRange::try_new(FRAC_PI_2).unwrap();
        let b = quarter.bounds([1.0, 2.0], [3.0, 4.0]);
        assert!((b.min - DVec3::new(0.0, 0.0, 3.0)).abs().max_element() < 1e-13);
        assert!((b.max - DVec3::new(2.0, 2.0, 4.0)).abs().max_element() < 1e-13);
    }

    #[test]
    fn empty_negative_and_infinite_ranges_are_refused() {
        assert!(AzimuthRange::try_new(0.0).is_err());
        assert!(AzimuthRange::try_new(-1.0).is_err());
        assert!(AzimuthRange::try_new(f64::NAN).is_err());
    }
}
