//! Quadrics, tori, rectangles and bilinear patches as rational Bézier patches: the same points, exactly.
//!
//! The patches are for programs that draw or write control points. A patch has its own parameters in [0, 1]; [`ParameterMap`]
//! converts them to those of the surface.
//!
//! ```
//! use glanz_geometry::quadric::Sphere;
//! use glanz_geometry::Surface;
//!
//! let sphere = Surface::from(Sphere::try_full(2.0)?);
//! let patches = sphere.rational_patches().ok_or("no sphere")?;
//! assert_eq!(patches.len(), 8);
//! assert!(patches.iter().all(|p| (p.patch.point(0.3, 0.9).length() - 2.0).abs() < 1e-15));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod parameter_map;
mod profile;
#[cfg(test)]
mod tests;

use glanz_math::glam::DVec4;
use glanz_math::{DVec2, DVec3};

pub use self::parameter_map::{ParameterMap, Reparameterization};
pub(crate) use self::profile::Profile;
use self::profile::{arc_count, direction};
use crate::bezier::TensorPatch;
use crate::surface::{RaySurface, Surface};

/// A part of a surface as a rational Bézier patch.
#[derive(Clone, Debug, PartialEq)]
pub struct RationalPatch {
    /// The patch; its normal, along dp/dx x dp/dy, is that of the surface.
    pub patch: TensorPatch,
    /// The surface's u as a function of x of the patch.
    pub u: ParameterMap,
    /// The surface's v as a function of y of the patch.
    pub v: ParameterMap,
}

impl RationalPatch {
    /// The parameters of the surface at (x, y) in the unit square of the patch.
    #[must_use]
    pub fn parameters(&self, x: f64, y: f64) -> DVec2 {
        DVec2::new(self.u.parameter(x), self.v.parameter(y))
    }
}

impl Surface {
    /// The untrimmed surface as patches; neighbours share the bits of their border.
    ///
    /// Arcs are at most 120 degrees long, and quarters of a full turn. `None` for algebraic surfaces, infinite planes, meshes and
    /// polyhedra, freeform surfaces ([`Freeform::patches`](crate::freeform::Freeform::patches) are their patches), and where
    /// numbers overflow.
    ///
    /// # Source
    /// @farin2002 chapters 12 and 16.
    #[must_use]
    pub fn rational_patches(&self) -> Option<Vec<RationalPatch>> {
        match self {
            Self::Sphere(s) => s.rational_patches(),
            Self::Cylinder(s) => s.rational_patches(),
            Self::Cone(s) => s.rational_patches(),
            Self::Paraboloid(s) => s.rational_patches(),
            Self::Hyperboloid(s) => s.rational_patches(),
            Self::TwoSheetedHyperboloid(s) => s.rational_patches(),
            Self::Disk(s) => revolved(s.phi_max(), &[s.profile()]),
            Self::Torus(s) => revolved(s.phi_max(), &s.profiles()),
            Self::Bilinear(s) => {
                let [p00, p10, p01, p11] = s.corners();
                Some(vec![bilinear([p00, p10, p01, p11], ParameterMap::UNIT, ParameterMap::UNIT)?])
            }
            Self::Plane(s) if s.area().is_finite() => {
                let bounds = s.bounds();
                let at = |x: f64, y: f64| DVec3::new(x, y, 0.0);
                let (min, max) = (bounds.min, bounds.max);
                let corners = [at(min.x, min.y), at(max.x, min.y), at(min.x, max.y), at(max.x, max.y)];
                Some(vec![bilinear(corners, ParameterMap::UNIT, ParameterMap::UNIT)?])
            }
            Self::Trimmed(s) => s.surface().rational_patches(),
            _ => None,
        }
    }
}

/// The bilinear patch with corners at (0, 0), (1, 0), (0, 1), (1, 1); `None` if they are not finite.
#[must_use]
pub fn bilinear([p00, p10, p01, p11]: [DVec3; 4], u: ParameterMap, v: ParameterMap) -> Option<RationalPatch> {
    let points = [p00, p01, p10, p11].map(|p| p.extend(1.0));
    Some(RationalPatch { patch: TensorPatch::try_new(1, 1, points.to_vec()).ok()?, u, v })
}

/// The patches of profiles revolved about the z axis by `phi_max`, radians.
pub(crate) fn revolved(phi_max: f64, profiles: &[Profile]) -> Option<Vec<RationalPatch>> {
    let count = arc_count(phi_max);
    let at = |k: f64| direction(phi_max * (k / count));
    let half = 0.5 * phi_max / count;
    let rotated = |p: &DVec4, by: DVec2| {
        let flat = by.rotate(p.truncate().truncate());
        DVec4::new(flat.x, flat.y, p.z, p.w)
    };
    let mut patches = Vec::new();
    for k in (0..count as u32).map(f64::from) {
        for profile in profiles {
            // The intersection of the tangents at both ends of the arc: farther out by 1 / cos(half), with the weight cos(half).
            let middle_point = |p: &DVec4| DVec4::new(p.x, p.y, p.z * half.cos(), p.w * half.cos());
            let (start, middle, end) = (at(k), at(k + 0.5), at(k + 1.0));
            let points = profile.points.iter().map(|p| rotated(p, start));
            let points = points.chain(profile.points.iter().map(|p| rotated(&middle_point(p), middle)));
            let points = points.chain(profile.points.iter().map(|p| rotated(p, end)));
            let patch = TensorPatch::try_new(2, profile.points.len() - 1, points.collect()).ok()?;
            let u = ParameterMap {
                ends: [k / count, (k + 1.0) / count],
                reparameterization: Reparameterization::Circular(half),
            };
            patches.push(RationalPatch { patch, u, v: profile.v });
        }
    }
    Some(patches)
}
