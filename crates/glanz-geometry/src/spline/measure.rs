//! Area and curvature of spline surfaces.

use glanz_math::DVec3;

use super::surface::NurbsSurface;
use crate::bezier::Derivatives;
use crate::error::{SurfaceError, positive};

/// Curvatures of a surface at a point. They are positive where it bends towards its normal: a sphere of radius r whose
/// normal points outwards has the principal curvatures -1/r.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceCurvature {
    /// Product of the principal curvatures, 1/m^2.
    pub gaussian: f64,
    /// Mean of the principal curvatures, 1/m.
    pub mean: f64,
    /// Smallest and largest curvature of a normal section, 1/m.
    pub principal: [f64; 2],
}

impl SurfaceCurvature {
    /// The curvatures at a point with these derivatives, up to second order or more; the normal is that of `dS/du x dS/dv`. `None` where
    /// the first derivatives vanish or are parallel.
    ///
    /// # Source
    /// @docarmo1976 section 3.3.
    #[must_use]
    pub fn from_derivatives(d: &Derivatives) -> Option<Self> {
        let (du, dv) = (d.at(1, 0), d.at(0, 1));
        let normal = du.cross(dv).try_normalize()?;
        Self::from_forms([du, dv], [d.at(2, 0), d.at(1, 1), d.at(0, 2)].map(|second| second.dot(normal)))
    }

    /// The curvatures at a point with the first derivatives `tangents` by u and by v, metres, where those of the unit normal are
    /// `normal_derivatives`. `None` where the tangents vanish or are parallel.
    ///
    /// # Source
    /// @docarmo1976 section 3.3.
    #[must_use]
    pub fn from_normal_derivatives(tangents: [DVec3; 2], normal_derivatives: [DVec3; 2]) -> Option<Self> {
        let ([du, dv], [nu, nv]) = (tangents, normal_derivatives);
        // Both mixed products are equal up to rounding.
        let mixed = -0.5 * (nu.dot(dv) + nv.dot(du));
        Self::from_forms(tangents, [-nu.dot(du), mixed, -nv.dot(dv)])
    }

    /// The curvatures from the tangents and the coefficients of the second fundamental form.
    fn from_forms([du, dv]: [DVec3; 2], [l, m, n]: [f64; 3]) -> Option<Self> {
        let (e, f, g) = (du.dot(du), du.dot(dv), dv.dot(dv));
        // e g - f^2 without its cancellation.
        let area2 = du.cross(dv).length_squared();
        let gaussian = (l * n - m * m) / area2;
        let mean = (e * n - 2.0 * f * m + g * l) / (2.0 * area2);
        // Negative by rounding only.
        let spread = (mean * mean - gaussian).max(0.0).sqrt();
        let all = [gaussian, mean, spread];
        let principal = [mean - spread, mean + spread];
        all.iter().all(|x| x.is_finite()).then_some(Self { gaussian, mean, principal })
    }
}

/// An area with an estimate of its error, m^2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AreaEstimate {
    /// The area.
    pub value: f64,
    /// Estimate of its error: the change by the last refinement.
    pub error: f64,
}

/// Nodes and weights of Gauss's rule with 8 points over [-1, 1]; the positive half.
pub(super) const GAUSS: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_48),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_26),
];

/// Largest number of quartered rectangles; the others are added without refinement, with their errors.
const MAX_RECTANGLES: usize = 1 << 15;

/// A rectangle of the domain with the integral of the area element over it.
struct IntegrationCell {
    u: [f64; 2],
    v: [f64; 2],
    integral: f64,
}

impl IntegrationCell {
    fn new(surface: &NurbsSurface, u: [f64; 2], v: [f64; 2]) -> Self {
        let half = |[a, b]: [f64; 2]| (0.5 * (a + b), 0.5 * (b - a));
        let ((cu, hu), (cv, hv)) = (half(u), half(v));
        let nodes = || GAUSS.iter().flat_map(|&(x, w)| [(-x, w), (x, w)]);
        let mut integral = 0.0;
        for (x, weight_u) in nodes() {
            for (y, weight_v) in nodes() {
                let (_, du, dv) = surface.tangents(cu + hu * x, cv + hv * y);
                integral += weight_u * weight_v * du.cross(dv).length();
            }
        }
        Self { u, v, integral: integral * hu * hv }
    }

    fn quarters(&self, surface: &NurbsSurface) -> [Self; 4] {
        let (mu, mv) = (0.5 * (self.u[0] + self.u[1]), 0.5 * (self.v[0] + self.v[1]));
        [(0, 0), (0, 1), (1, 0), (1, 1)].map(|(i, j)| {
            let u = if i == 0 { [self.u[0], mu] } else { [mu, self.u[1]] };
            let v = if j == 0 { [self.v[0], mv] } else { [mv, self.v[1]] };
            Self::new(surface, u, v)
        })
    }
}

impl NurbsSurface {
    /// The area, by Gauss's rule on rectangles that are quartered until the sum changes by less than `tolerance` (m^2).
    ///
    /// # Errors
    /// [`SurfaceError::NotFinite`] or [`SurfaceError::NotPositive`] for the tolerance. One that cannot be reached is not an error:
    /// see [`AreaEstimate::error`].
    ///
    /// # Source
    /// @pumberger2010 eq. 2.1.
    pub fn area(&self, tolerance: f64) -> Result<AreaEstimate, SurfaceError> {
        positive("tolerance of the area", tolerance)?;
        let ([u0, u1], [v0, v1]) = (self.knots_u().domain(), self.knots_v().domain());
        let mut open = Vec::new();
        for u in self.knots_u().breaks().windows(2) {
            for v in self.knots_v().breaks().windows(2) {
                open.push(IntegrationCell::new(self, [u[0], u[1]], [v[0], v[1]]));
            }
        }
        let limit = open.len() + MAX_RECTANGLES;
        let (mut value, mut error, mut cells) = (0.0, 0.0, 0);
        while let Some(cell) = open.pop() {
            let quarters = cell.quarters(self);
            let refined: f64 = quarters.iter().map(|q| q.integral).sum();
            let change = (refined - cell.integral).abs();
            let share = (cell.u[1] - cell.u[0]) / (u1 - u0) * ((cell.v[1] - cell.v[0]) / (v1 - v0));
            cells += 1;
            if change <= tolerance * share || cells >= limit {
                value += refined;
                error += change;
            } else {
                open.extend(quarters);
            }
        }
        Ok(AreaEstimate { value, error })
    }

    /// The curvature at (u, v); `None` where the first derivatives vanish or are parallel.
    ///
    /// # Source
    /// @docarmo1976 section 3.3.
    #[must_use]
    pub fn curvature(&self, u: f64, v: f64) -> Option<SurfaceCurvature> {
        SurfaceCurvature::from_derivatives(&self.derivatives(u, v, 2))
    }
}
