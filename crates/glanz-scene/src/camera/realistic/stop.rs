//! The opening of a stop.

use std::f64::consts::{E, PI, TAU};
use std::sync::Arc;

use glanz_math::DVec2;

use crate::description::{IrisDescription, StopShape};

/// The opening of a stop, in units of its radius. Its transmittance has the integral of a disk.
#[derive(Clone, Debug)]
pub(super) enum LensStop {
    Disk,
    Gaussian,
    /// Corners of a polygon, and the transmittance inside.
    Polygon(Arc<[DVec2]>, f64),
}

impl LensStop {
    /// A disk.
    pub(super) const DISK: Self = Self::Disk;

    /// The opening of this shape.
    ///
    /// # Source
    /// pbrt-v4, camera `realistic`, whose pictures of apertures these are.
    pub(super) fn new(shape: StopShape) -> Self {
        let regular = |count: u32, radius: f64, first: f64| {
            (0..count)
                .map(|k| radius * DVec2::from_angle(first + TAU * f64::from(k) / f64::from(count)))
                .collect::<Arc<[DVec2]>>()
        };
        match shape {
            StopShape::Iris(IrisDescription { blades: 0..3, .. }) => Self::Disk,
            StopShape::Iris(IrisDescription { blades, rotation }) => {
                Self::polygon(regular(blades, 1.0, rotation))
            }
            StopShape::Gaussian => Self::Gaussian,
            StopShape::Square => Self::polygon(regular(4, 0.5_f64.sqrt(), 0.25 * PI)),
            StopShape::Pentagon => Self::polygon(regular(5, 0.8, -0.5 * PI)),
            StopShape::Star => {
                // The inner corners of a pentagram.
                let inner = (0.4 * PI).cos() / (0.2 * PI).cos();
                let corner = |k: u32| {
                    let radius = if k % 2 == 1 { 1.0 } else { inner };
                    radius * DVec2::from_angle(0.2 * PI * f64::from(k))
                };
                Self::polygon((0..10).map(corner).collect())
            }
        }
    }

    fn polygon(corners: Arc<[DVec2]>) -> Self {
        let area: f64 = edges(&corners).map(|[a, b]| 0.5 * a.perp_dot(b)).sum();
        Self::Polygon(corners, PI / area)
    }

    /// Transmittance at a point; 0 outside the unit disk.
    pub(super) fn transmittance(&self, at: DVec2) -> f64 {
        let squared = at.length_squared();
        match self {
            _ if squared.is_nan() || squared > 1.0 => 0.0,
            Self::Disk => 1.0,
            // Over the disk, exp(-r^2) - 1/e has the integral pi (1 - 2/e).
            Self::Gaussian => ((-squared).exp() - 1.0 / E) / (1.0 - 2.0 / E),
            Self::Polygon(corners, inside) => {
                // Crossings of the horizontal ray from the point.
                let crossed = edges(corners).filter(|[a, b]| {
                    (a.y > at.y) != (b.y > at.y) && at.x < a.x + (at.y - a.y) / (b.y - a.y) * (b.x - a.x)
                });
                if crossed.count() % 2 == 1 { *inside } else { 0.0 }
            }
        }
    }
}

/// The edges of a polygon.
fn edges(corners: &[DVec2]) -> impl Iterator<Item = [DVec2; 2]> + '_ {
    corners.iter().zip(corners.iter().cycle().skip(1)).map(|(&a, &b)| [a, b])
}
