//! Algebraic surfaces: the zero sets of polynomials in x, y and z.

mod polynomial3;

use std::f64::consts::{PI, TAU};
use std::ops::ControlFlow;

use glanz_math::polynomial::visit_roots;
use glanz_math::rounding::{UNIT_ROUNDOFF, gamma};
use glanz_math::{AreaPdf, Bounds3, DVec2, DVec3, Ray};

use self::polynomial3::{CoefficientCube, Polynomial3, TaylorExpansion, Univariate, recenter};
use crate::cuboid::clip_to_box;
use crate::error::{SurfaceError, finite, positive};
use crate::hit::{Hit, SurfacePoint, SurfaceSample};
use crate::ray_line::RayLine;
use crate::surface::RaySurface;

/// Largest total degree of an [`AlgebraicSurface`].
pub const MAX_DEGREE: usize = 4;

/// Largest reported error of a position, in units of half the box: 2^-31.
const MAX_POSITION_ERROR: f64 = 1.0 / 2_147_483_648.0;

/// Uncertainty of a root, in units of half the box, above which it is refined: 2^-40.
const POLISH_THRESHOLD: f64 = 1.0 / 1_099_511_627_776.0;

/// The term `coefficient x^i y^j z^k` of a polynomial.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PolynomialTerm {
    /// The exponents i, j, k.
    pub exponents: [u32; 3],
    /// The coefficient; x, y and z are in metres.
    pub coefficient: f64,
}

/// The points of a box where `sum c x^i y^j z^k = 0`, of total degree at most 4.
///
/// The surface is open where it leaves the box. The normal is the direction in which the polynomial increases. `u` and `v` are
/// spherical angles about the center c of the box: `p = c + r (cos 2 pi u sin pi v, sin 2 pi u sin pi v, cos pi v)`; several
/// points may have the same parameters. The tangents are zero on the axis and where the tangent plane contains the center. At
/// points where the gradient vanishes, the normal points against the ray.
///
/// # Source
/// @hanrahan1983; departure: coefficients along the ray are relative to a point of the ray in the box.
#[derive(Clone, Debug, PartialEq)]
pub struct AlgebraicSurface {
    /// The polynomial in coordinates relative to the center of the box, in units of `scale`.
    polynomial: Polynomial3,
    bounds: Bounds3,
    center: DVec3,
    /// A power of two, metres; half the longest edge of the box is between 1/2 and 1 of it.
    scale: f64,
}

impl AlgebraicSurface {
    /// The zero set of the sum of `terms` in the box `bounds` (metres). Terms of equal exponents add up.
    ///
    /// # Errors
    /// [`SurfaceError::NotFinite`]; [`SurfaceError::NotPositive`] if the box has no volume;
    /// [`SurfaceError::DegreeTooHigh`]; [`SurfaceError::Degenerate`] if the polynomial is constant.
    pub fn try_new(terms: &[PolynomialTerm], bounds: Bounds3) -> Result<Self, SurfaceError> {
        for edge in bounds.diagonal().to_array() {
            positive("edge length of the box", edge)?;
        }
        let center = bounds.center();
        finite("center of the box", center.element_sum())?;
        let half = bounds.diagonal().max_element() * 0.5;
        let scale = half.log2().ceil().exp2();
        positive("scale of the box to the fourth power", scale.powi(4))?;
        finite("scale of the box to the fourth power", scale.powi(4))?;
        let mut cube: CoefficientCube = Default::default();
        for term in terms {
            let coefficient = finite("coefficient", term.coefficient)?;
            let total = term.exponents.iter().fold(0_u32, |a, &e| a.saturating_add(e));
            if total as usize > MAX_DEGREE {
                return Err(SurfaceError::DegreeTooHigh {
                    parameter: "the polynomial",
                    degree: total,
                    max: MAX_DEGREE as u32,
                });
            }
            let [i, j, k] = term.exponents.map(|e| e as usize);
            cube[i][j][k].0 += coefficient;
        }
        // The total degree does not change with the origin.
        let degree = total_degree(&cube);
        if degree == 0 {
            return Err(SurfaceError::Degenerate {
                reason: "the polynomial is constant, value",
                value: cube[0][0][0].0,
            });
        }
        recenter(&mut cube, center, scale);
        let largest = normalise(&mut cube);
        finite("coefficient about the center of the box", largest)?;
        Ok(Self { polynomial: Polynomial3::new(&cube, degree), bounds, center, scale })
    }

    /// The terms in coordinates relative to [`AlgebraicSurface::center`] and in units of [`AlgebraicSurface::scale`], up to a common
    /// factor. They keep their digits far from the origin.
    pub fn centered_terms(&self) -> impl Iterator<Item = PolynomialTerm> + '_ {
        self.polynomial.terms().filter(|term| term.coefficient != 0.0)
    }

    /// Center of the box, metres.
    #[must_use]
    pub fn center(&self) -> DVec3 {
        self.center
    }

    /// Unit of [`AlgebraicSurface::centered_terms`], metres: in it, half the longest edge of the box is between 1/2 and 1.
    #[must_use]
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// Visits the hits in ascending order until `visit` breaks.
    ///
    /// The polynomial along the ray is relative to the ray's origin if that lies in the box: the sign of its constant term is then
    /// that of the side on which the ray starts. Otherwise it is relative to the middle of the ray's interval in the box.
    /// Neither depends on `t_max`, so that a hit always has the same digits.
    fn visit_hits<B>(
        &self,
        ray: &Ray,
        t_max: f64,
        mut visit: impl FnMut(Hit) -> ControlFlow<B>,
    ) -> Option<B> {
        let (enter, leave) = clip_to_box(&self.bounds, ray)?;
        if leave <= 0.0 || enter >= t_max {
            return None;
        }
        let shift = if enter <= 0.0 { 0.0 } else { 0.5 * enter + 0.5 * leave };
        let line = RayLine::new(ray, shift);
        let polynomial = self.polynomial.on_line((line.origin - self.center) / self.scale, line.direction);
        let (low, high) = (line.s(enter.max(0.0)) / self.scale, line.s(leave) / self.scale);
        let mut last = 0.0;
        let end = visit_roots(&polynomial, low, high, |s| {
            let polished = line.t(self.polish(&polynomial, &line, s) * self.scale);
            // A step must not merge two roots.
            let is_distinct = polished > last || polished <= 0.0;
            let t = if is_distinct { polished } else { line.t(s * self.scale) };
            // Rounding must not move the root out of the box, beyond the end that is tested above.
            let t = t.clamp(enter, leave);
            // Two arc lengths may round to one parameter of a distant ray.
            let is_new = t > last && t < t_max;
            last = last.max(t);
            if is_new { visit(self.hit(t, line.at(line.s(t)))) } else { ControlFlow::Continue(()) }
        });
        end.break_value()
    }

    /// The root `s` of `polynomial`, refined by a Newton step with the expansion at its own point if rounding of the coefficients
    /// may have moved it by more than [`POLISH_THRESHOLD`].
    ///
    /// Near a singular point the polynomial is flat, and its value is far smaller than its coefficients.
    fn polish(&self, polynomial: &Univariate, line: &RayLine, s: f64) -> f64 {
        let (mut size, mut slope, mut value) = (0.0, 0.0, 0.0);
        for &c in polynomial.iter().rev() {
            size = size * s.abs() + c.abs();
            slope = slope * s + value;
            value = value * s + c;
        }
        let uncertainty = gamma(16) * size;
        if uncertainty <= POLISH_THRESHOLD * slope.abs() {
            return s;
        }
        let expansion = self.polynomial.expansion((line.at(s * self.scale) - self.center) / self.scale);
        let step = expansion.value / expansion.gradient.dot(line.direction);
        // The roots of tangential rays cannot be improved.
        if step.abs() * slope.abs() <= uncertainty && step.abs() <= POLISH_THRESHOLD.sqrt() {
            s - step
        } else {
            s
        }
    }

    fn hit(&self, t: f64, p: DVec3) -> Hit {
        let d = p - self.center;
        let phi = d.y.atan2(d.x);
        let u = if phi < 0.0 { (phi / TAU + 1.0).min(1.0_f64.next_down()) } else { phi / TAU };
        Hit::new(t, u, d.truncate().length().atan2(d.z) / PI, 0)
    }

    /// The point of the surface nearest to `p` (relative to the center, in units of the scale), which is on the surface up to the
    /// rounding of the root and, by `slack`, of the position on the ray.
    ///
    /// A Newton step along the gradient; at a side of the box, another step within that side. Near a singular point the step
    /// may lead away from the surface or far along it: there `p` itself is used.
    fn project(&self, p: DVec3, slack: f64) -> (DVec3, TaylorExpansion) {
        let (min, max) =
            ((self.bounds.min - self.center) / self.scale, (self.bounds.max - self.center) / self.scale);
        let mut best = p.clamp(min, max);
        let mut expansion = self.polynomial.expansion(best);
        let mut free = DVec3::ONE;
        for _ in 0..3 {
            let gradient = expansion.gradient * free;
            let step = gradient * (expansion.value / gradient.length_squared());
            if step.is_nan() || step.length() > MAX_POSITION_ERROR.max(slack) {
                break;
            }
            let moved = (best - step).clamp(min, max);
            let next = self.polynomial.expansion(moved);
            if next.value.abs() < expansion.value.abs() {
                (best, expansion) = (moved, next);
            }
            let inside = DVec3::select(moved.cmpgt(min) & moved.cmplt(max), DVec3::ONE, DVec3::ZERO);
            if inside == free {
                break;
            }
            free = inside;
        }
        (best, expansion)
    }

    /// Absolute error per axis, metres.
    ///
    /// The error of the value is the residual plus 16 roundings of the sum of the moduli of all terms, here and again for the next
    /// ray; divided by the gradient it is a distance. Where the gradient vanishes, the second derivatives bound the distance.
    /// The result is at most [`MAX_POSITION_ERROR`] of the box: within about that distance of a singular point, rays may hit the
    /// surface that they start from.
    fn error(&self, expansion: &TaylorExpansion) -> DVec3 {
        let value_error = expansion.value.abs() + 2.0 * gamma(16) * expansion.size;
        let h = expansion.hessian;
        let bend = (h.x_axis.length_squared() + h.y_axis.length_squared() + h.z_axis.length_squared()).sqrt();
        let slope = expansion.gradient.length().max((value_error * bend).sqrt());
        let off =
            if slope * MAX_POSITION_ERROR > value_error { value_error / slope } else { MAX_POSITION_ERROR };
        // The position is converted to local coordinates and back.
        let reach = self.bounds.min.abs().max(self.bounds.max.abs());
        DVec3::splat(off * self.scale + gamma(4) * self.scale) + reach * gamma(4)
    }
}

/// Largest sum of exponents of a nonzero term.
fn total_degree(cube: &CoefficientCube) -> usize {
    let mut degree = 0;
    for (i, plane) in cube.iter().enumerate() {
        for (j, line) in plane.iter().enumerate() {
            for (k, c) in line.iter().enumerate() {
                if c.0 != 0.0 {
                    degree = degree.max(i + j + k);
                }
            }
        }
    }
    degree
}

/// Multiplies by a power of two so that the largest coefficient lies in [1, 2], and returns its former value.
fn normalise(cube: &mut CoefficientCube) -> f64 {
    let largest = cube
        .iter()
        .flatten()
        .flatten()
        .fold(0.0_f64, |a, c| if c.0.is_nan() { c.0 } else { a.max(c.0.abs()) });
    if largest > 0.0 && largest.is_finite() {
        let exponent = largest.log2().floor();
        let (first, second) = ((-0.5 * exponent).floor().exp2(), (0.5 * exponent).floor().exp2());
        for c in cube.iter_mut().flatten().flatten() {
            *c = (c.0 * first / second, c.1 * first / second);
        }
    }
    largest
}

impl RaySurface for AlgebraicSurface {
    fn bounds(&self) -> Bounds3 {
        self.bounds
    }

    fn intersect(&self, ray: &Ray, t_max: f64) -> Option<Hit> {
        self.visit_hits(ray, t_max, ControlFlow::Break)
    }

    fn all_hits(&self, ray: &Ray, t_max: f64, hits: &mut Vec<Hit>) {
        let _: Option<()> = self.visit_hits(ray, t_max, |hit| {
            hits.push(hit);
            ControlFlow::Continue(())
        });
    }

    fn point(&self, ray: &Ray, hit: &Hit) -> SurfacePoint {
        let start = (RayLine::new(ray, hit.t).origin - self.center) / self.scale;
        let (local, expansion) =
            self.project(start, gamma(8) * ray.origin.distance(self.center) / self.scale);
        let normal = expansion.gradient.try_normalize().unwrap_or_else(|| -ray.direction.normalize());
        let (sin_phi, cos_phi) = (hit.u * TAU).sin_cos();
        let (sin_theta, cos_theta) = (hit.v * PI).sin_cos();
        let radius = local.length() * self.scale;
        let outward = DVec3::new(sin_theta * cos_phi, sin_theta * sin_phi, cos_theta);
        let cos = normal.dot(outward);
        let tangent = |turn: DVec3| {
            // p = c + r w with n . dp = 0: dr = -r (n . dw) / (n . w). Below the root of the roundoff, n . w is noise.
            if cos.abs() <= UNIT_ROUNDOFF.sqrt() {
                return DVec3::ZERO;
            }
            let dp = turn * radius - outward * (radius * normal.dot(turn) / cos);
            dp - normal * normal.dot(dp)
        };
        let dpdu = tangent(DVec3::new(-sin_theta * sin_phi, sin_theta * cos_phi, 0.0) * TAU);
        let dpdv = tangent(DVec3::new(cos_theta * cos_phi, cos_theta * sin_phi, -sin_theta) * PI);
        SurfacePoint {
            position: (self.center + local * self.scale).clamp(self.bounds.min, self.bounds.max),
            error: self.error(&expansion),
            normal,
            shading_normal: normal,
            uv: DVec2::new(hit.u, hit.v),
            dpdu,
            dpdv,
        }
    }

    fn normal_derivatives(&self, _hit: &Hit, point: &SurfacePoint) -> [DVec3; 2] {
        let expansion = self.polynomial.expansion((point.position - self.center) / self.scale);
        let (normal, slope) = (point.normal, expansion.gradient.length());
        [point.dpdu, point.dpdv].map(|dp| {
            let dn = expansion.hessian * (dp / self.scale);
            if slope > 0.0 { (dn - normal * normal.dot(dn)) / slope } else { DVec3::ZERO }
        })
    }

    /// Always `None`: the area has no closed form, and the parameters are not unique.
    fn sample(&self, _xi: DVec2) -> Option<SurfaceSample> {
        None
    }

    fn area_pdf(&self, _hit: &Hit, _point: &SurfacePoint) -> Option<AreaPdf> {
        None
    }
}

#[cfg(test)]
mod tests;
