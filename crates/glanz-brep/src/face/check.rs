//! Whether a scene takes what a face is made of.

use glanz_geometry::quadric::{Cone, Cylinder, Plane, Sphere};
use glanz_geometry::torus::Torus;
use glanz_geometry::trim::{RegionSettings, TrimCurve, TrimRegion};
use glanz_geometry::{RaySurface, Surface, SurfaceError};
use glanz_math::{Bounds3, DVec2, DVec3};

use super::geometry::FaceGeometry;
use super::trim::TrimmedFace;
use crate::boundary::BoundaryCurve;
use crate::model::CurveVector;

/// Largest coordinate of a face, metres: a scene takes up to 1e30, after the placement of the part.
const FARTHEST: f64 = 1e15;

impl TrimmedFace {
    /// Checks surface and boundary as their constructors in `glanz-geometry` do, without the trees that these build.
    ///
    /// # Errors
    /// Those of the constructors; [`SurfaceError::OutOfRange`] for a coordinate.
    pub(super) fn check(&self) -> Result<(), SurfaceError> {
        let bounds = self.geometry.checked_bounds()?;
        let corners = [bounds.min, bounds.max].map(|corner| corner.abs().max_element());
        let value = corners[0].max(corners[1]) + self.to_part.w_axis.truncate().abs().max_element();
        if value.is_nan() || value > FARTHEST {
            let parameter = "the largest coordinate";
            return Err(SurfaceError::OutOfRange { parameter, value, min: 0.0, max: FARTHEST });
        }
        let Some(trim) = &self.trim else { return Ok(()) };
        let curve = |curve: &BoundaryCurve| {
            TrimCurve::try_nurbs(curve.degree, &curve.knots, &curve.points)?.with_width(curve.width)
        };
        let loops: Result<Vec<Vec<TrimCurve>>, SurfaceError> =
            trim.loops.iter().map(|curves| curves.iter().map(curve).collect()).collect();
        let [u, v] = trim.domain;
        let domain = Some([DVec2::new(u[0], v[0]), DVec2::new(u[1], v[1])]);
        TrimRegion::check(loops?, RegionSettings { scale: trim.scale, domain })
    }
}

impl FaceGeometry {
    /// A box around the surface, if it can be constructed.
    fn checked_bounds(&self) -> Result<Bounds3, SurfaceError> {
        let surface: Surface = match *self {
            Self::Plane { x, y } => Plane::try_new(x, y)?.into(),
            Self::Cylinder { radius, z, phi_max } => Cylinder::try_new(radius, z, phi_max)?.into(),
            Self::Cone { radius, height, phi_max } => Cone::try_new(radius, height, phi_max)?.into(),
            Self::Sphere { radius, z, phi_max } => Sphere::try_new(radius, z, phi_max)?.into(),
            Self::Torus { major_radius, minor_radius, phi_max } => {
                Torus::try_new(major_radius, minor_radius, phi_max)?.into()
            }
            Self::Spline(ref surface) => {
                surface.surface_patches()?;
                let points = surface.control_points().iter().map(|&point| DVec3::project(point));
                let bounds = Bounds3::from_points(points);
                let value = bounds.diagonal().length();
                if !(value > 0.0 && value.is_finite()) {
                    return Err(SurfaceError::Degenerate { reason: "extent of its control points", value });
                }
                return Ok(bounds);
            }
        };
        Ok(surface.bounds())
    }
}
