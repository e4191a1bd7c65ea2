//! Curvature of a surface at a point.

use glanz_geometry::SurfacePoint;
use glanz_math::DVec3;
use serde::Serialize;

/// Sine of the angle between the derivatives of the position, squared, below which they have no plane.
const DEGENERATE: f64 = 1e-18;

/// A surface that departs from its tangent plane by less than this share of its size is flat.
const FLAT: f64 = 1e-9;

/// Curvatures at a point of a surface, 1/m: positive where it is convex on the side that its normal points to.
///
/// So a sphere with its normal outwards has `minimum = maximum = 1 / r`, and the inside of a bowl negative ones.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Curvature {
    /// The smaller principal curvature.
    pub minimum: f64,
    /// The larger principal curvature.
    pub maximum: f64,
    /// Their product, 1/m^2.
    pub gaussian: f64,
    /// Half their sum.
    pub mean: f64,
    /// The smaller of the principal radii of curvature, without sign, m; `None` where the surface is flat.
    pub radius: Option<f64>,
}

impl Curvature {
    /// The curvatures at `point` of a surface of the extent `size`, m, whose normal has the derivatives `[dn/du, dn/dv]`; `None` where its
    /// parameters degenerate, as at poles.
    ///
    /// # Source
    /// @farin2002 chapter 19; the second form from the derivatives of the normal, by Weingarten's equations.
    #[must_use]
    pub fn of(point: &SurfacePoint, [dndu, dndv]: [DVec3; 2], size: f64) -> Option<Self> {
        let SurfacePoint { dpdu, dpdv, .. } = point;
        let (e, f, g) = (dpdu.length_squared(), dpdu.dot(*dpdv), dpdv.length_squared());
        let area = dpdu.cross(*dpdv).length_squared();
        if area.is_nan() || area <= DEGENERATE * e * g {
            return None;
        }
        let (l, m, n) = (dndu.dot(*dpdu), 0.5 * (dndu.dot(*dpdv) + dndv.dot(*dpdu)), dndv.dot(*dpdv));
        let gaussian = (l * n - m * m) / area;
        let mean = 0.5 * (l * g - 2.0 * m * f + n * e) / area;
        // Rounding makes it negative where both are the same.
        let half = (mean * mean - gaussian).max(0.0).sqrt();
        let (minimum, maximum) = (mean - half, mean + half);
        let strongest = minimum.abs().max(maximum.abs());
        let curved = strongest * size > FLAT;
        let radius = curved.then(|| 1.0 / strongest);
        [minimum, maximum, gaussian].iter().all(|x| x.is_finite()).then_some(Self {
            minimum,
            maximum,
            gaussian,
            mean,
            radius,
        })
    }
}
