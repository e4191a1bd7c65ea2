//! Whole spheres as light sources: the cones that they subtend, and their points.

use std::f64::consts::FRAC_1_PI;

use glanz_geometry::{AreaSample, Surface};
use glanz_math::rounding::gamma;
use glanz_math::{AreaPdf, DVec2, DVec3, SolidAnglePdf};
use glanz_sampling::warp;

use crate::object::SceneObject;

/// Relative difference of the lengths of axes up to which a map of a sphere gives a sphere.
const SIMILARITY: f64 = gamma(64);

/// The cone that a sphere subtends from outside.
pub(super) struct SphereCone {
    pub(super) center: DVec3,
    pub(super) radius: f64,
    pub(super) distance: f64,
    pub(super) axis: DVec3,
    pub(super) one_minus_cos: f64,
}

impl SphereCone {
    /// `None` inside and on the surface itself.
    pub(super) fn new(center: DVec3, radius: f64, from: DVec3) -> Option<Self> {
        let offset = center - from;
        let distance_squared = offset.length_squared();
        let sin_squared = radius * radius / distance_squared;
        if sin_squared.is_nan() || sin_squared >= 1.0 - gamma(8) {
            return None;
        }
        let distance = distance_squared.sqrt();
        let one_minus_cos = warp::one_minus_cos(sin_squared);
        Some(Self { center, radius, distance, axis: offset / distance, one_minus_cos })
    }

    pub(super) fn pdf(&self) -> SolidAnglePdf {
        warp::uniform_cone_pdf(self.one_minus_cos)
    }
}

/// A whole sphere in the world.
#[derive(Clone, Copy, Debug)]
pub(super) struct WorldSphere {
    /// Metres.
    pub(super) center: DVec3,
    pub(super) radius: f64,
    /// Bound per axis on the distance from its points to the surface, as of [`AreaSample::error`].
    error: f64,
}

impl WorldSphere {
    /// The surface of `object`, if it is a whole sphere.
    pub(super) fn new(object: &SceneObject) -> Option<Self> {
        let Surface::Sphere(sphere) = object.surface() else { return None };
        if !sphere.is_whole() {
            return None;
        }
        let (center, radius) = match object.to_parent() {
            None => (DVec3::ZERO, sphere.radius()),
            // A matrix printed with six digits makes an ellipsoid, and the cone of a sphere would miss its rim: only
            // rotations exact to roundings count. The area sampler serves the others.
            Some(to_world) => {
                (to_world.point(DVec3::ZERO), to_world.uniform_scale(SIMILARITY)? * sphere.radius())
            }
        };
        // Entries of M^T M differ from those of a similarity by the tolerance, relative to its squared scale; hence eigenvalues by three
        // times (Gershgorin), and lengths by one and a half times that. The rest of twice the tolerance bounds the roundings of the
        // inverse matrix. The next ray is transformed to the frame of the sphere and intersected with it by fewer than 32 roundings
        // of numbers no larger than the distance of its origin from that of the world, and the radius.
        let error = 2.0 * SIMILARITY * radius + gamma(32) * (center.length() + radius);
        Some(Self { center, radius, error })
    }

    /// A point uniform by area, with the normal to the inside or the outside.
    #[inline]
    pub(super) fn sample(&self, inward: bool, xi: DVec2) -> AreaSample {
        // Height by the second number, azimuth by the first, as of `Sphere`.
        let outward = warp::uniform_sphere(DVec2::new(1.0 - xi.y, xi.x));
        AreaSample {
            position: self.center + self.radius * outward,
            error: DVec3::splat(self.error),
            normal: if inward { -outward } else { outward },
            face: 0,
            pdf: AreaPdf(0.25 * FRAC_1_PI / (self.radius * self.radius)),
        }
    }
}
