//! The opening of a thin lens.

use glanz_math::DVec2;
use glanz_sampling::warp;

use crate::description::IrisDescription;

/// The opening of a thin lens: a disk, or the regular polygon of an iris.
#[derive(Clone, Copy, Debug)]
pub struct Aperture {
    /// Distance of the corners from the middle, metres; 0 for a pinhole.
    radius: f64,
    /// Corners of the polygon; 0 for a disk.
    blades: u32,
    /// The direction of the first corner.
    turn: DVec2,
}

impl Aperture {
    /// A pinhole.
    pub const PINHOLE: Self = Self { radius: 0.0, blades: 0, turn: DVec2::X };

    /// `radius`: of the disk or the corners of the polygon, metres.
    #[must_use]
    pub fn new(radius: f64, iris: IrisDescription) -> Self {
        Self { radius, blades: iris.blades, turn: DVec2::from_angle(iris.rotation) }
    }

    /// Whether there is an opening other than a point.
    #[must_use]
    pub fn is_open(&self) -> bool {
        self.radius > 0.0
    }

    /// The point of the opening, metres, for two numbers uniform in [0, 1); uniform by area.
    #[must_use]
    pub fn point(&self, xi: DVec2) -> DVec2 {
        // Fewer than 3 corners make a disk.
        self.radius * self.turn.rotate(warp::regular_polygon(xi, self.blades))
    }
}
