//! Homogeneous control points, and derivatives of the curves and surfaces that they project to.

use glanz_math::glam::DVec4;
use glanz_math::rounding::{UNIT_ROUNDOFF, gamma};
use glanz_math::{Bounds3, DVec3};

use super::bernstein::{self, binomial};
use crate::error::{SurfaceError, finite, positive};

/// Largest degree, per direction, of a patch; rays intersect patches of degrees up to [`crate::freeform::MAX_DEGREE`].
pub const MAX_DEGREE: usize = bernstein::NET_DEGREE;

/// Checks that `degree` is from 1 to [`MAX_DEGREE`].
pub(super) fn checked_degree(parameter: &'static str, degree: usize) -> Result<(), SurfaceError> {
    positive(parameter, degree as f64)?;
    if degree > MAX_DEGREE {
        let (value, max) = (degree as f64, MAX_DEGREE as f64);
        return Err(SurfaceError::OutOfRange { parameter, value, min: 1.0, max });
    }
    Ok(())
}

/// Checks that there are `expected` points, that they and their projections are finite and their weights positive.
pub(crate) fn check_points(points: &[DVec4], expected: usize) -> Result<(), SurfaceError> {
    if points.len() != expected {
        let parameter = "control points";
        return Err(SurfaceError::CountMismatch { parameter, count: points.len(), expected });
    }
    for point in points {
        positive("weight", point.w)?;
        for value in point.truncate().to_array() {
            finite("control point", value)?;
            finite("control point over its weight", value / point.w)?;
        }
    }
    Ok(())
}

/// The homogeneous point (w x, w y, w z, w).
pub(super) fn homogeneous_point(point: DVec3, weight: f64) -> DVec4 {
    (point * weight).extend(weight)
}

/// The point (x, y, z) of (w x, w y, w z, w).
#[inline]
pub(crate) fn project(point: DVec4) -> DVec3 {
    point.truncate() / point.w
}

/// Homogeneous points from points and weights; without weights, all weights are 1.
pub(crate) fn homogeneous_points(
    points: &[DVec3],
    weights: Option<&[f64]>,
) -> Result<Vec<DVec4>, SurfaceError> {
    let Some(weights) = weights else { return Ok(points.iter().map(|p| p.extend(1.0)).collect()) };
    if weights.len() != points.len() {
        let (count, expected) = (weights.len(), points.len());
        return Err(SurfaceError::CountMismatch { parameter: "weights", count, expected });
    }
    Ok(points.iter().zip(weights).map(|(p, w)| homogeneous_point(*p, *w)).collect())
}

/// Whether any two weights differ.
pub(super) fn is_rational(points: &[DVec4]) -> bool {
    points.windows(2).any(|pair| matches!(pair, [a, b] if a.w != b.w))
}

/// `points`, which are means of `source`; weights that are all equal in `source` are made exactly equal to them.
pub(super) fn keep_weight(source: &[DVec4], mut points: Vec<DVec4>) -> Vec<DVec4> {
    if let (Some(first), false) = (source.first(), is_rational(source)) {
        points.iter_mut().for_each(|p| p.w = first.w);
    }
    points
}

/// A box around the control points, which also contains the patch.
pub(super) fn bounds(points: &[DVec4]) -> Bounds3 {
    let bounds = Bounds3::from_points(points.iter().map(|p| project(*p)));
    if points.iter().all(|p| p.w == 1.0) {
        return bounds;
    }
    // The divisions by the weights round once.
    bounds.expanded(gamma(2) * bounds.min.abs().max(bounds.max.abs()).max_element())
}

/// The unit normal along dp/du x dp/dv at `at`, or, where the product vanishes, at a nearby point towards one of `inner`.
///
/// `tangents` returns the point and its derivatives. A product below rounding noise counts as zero: both derivatives are up
/// to `degree` times as long as the patch and carry a few roundings per step of the evaluation.
pub(super) fn normal(
    (points, degree): (&[DVec4], usize),
    at: (f64, f64),
    inner: [(f64, f64); 2],
    tangents: impl Fn(f64, f64) -> (DVec3, DVec3, DVec3),
) -> Option<DVec3> {
    let size = bounds(points).diagonal().length() * degree as f64;
    let noise = gamma(8) * degree as f64 * size * size;
    let step = UNIT_ROUNDOFF.sqrt();
    let next = inner.map(|(x, y)| (at.0 + (x - at.0) * step, at.1 + (y - at.1) * step));
    [at, next[0], next[1]].into_iter().find_map(|(u, v)| {
        let (_, du, dv) = tangents(u, v);
        let n = du.cross(dv);
        if n.length() > noise { n.try_normalize() } else { None }
    })
}

/// Partial derivatives of a surface at one point, up to a total order.
#[derive(Clone, Debug, PartialEq)]
pub struct Derivatives {
    order: usize,
    /// Derivatives by total order, then by the order in v.
    values: Vec<DVec3>,
}

impl Derivatives {
    /// Derivatives of the projected surface from those of its homogeneous form, by Leibniz' rule for `w s = a`.
    ///
    /// `homogeneous`: the derivative of order k in u and l in v at [`derivative_index`] (k, l).
    ///
    /// # Source
    /// @farin2002 section 13.6; @markgraf2019 eq. 22.
    pub(crate) fn project(order: usize, homogeneous: &[DVec4]) -> Self {
        let mut values: Vec<DVec3> = Vec::with_capacity(homogeneous.len());
        let weight = homogeneous.first().map_or(1.0, |a| a.w);
        for total in 0..=order {
            for l in 0..=total {
                let k = total - l;
                let mut value = homogeneous[derivative_index(k, l)].truncate();
                for (a, b) in (0..=k).flat_map(|a| (0..=l).map(move |b| (a, b))).skip(1) {
                    let factor = binomial(k, a) * binomial(l, b) * homogeneous[derivative_index(a, b)].w;
                    value -= values[derivative_index(k - a, l - b)] * factor;
                }
                values.push(value / weight);
            }
        }
        Self { order, values }
    }

    /// Highest total order.
    #[must_use]
    pub fn order(&self) -> usize {
        self.order
    }

    /// The k-th derivative in u of the l-th in v, metres per parameter^(k + l); `None` if k + l exceeds the order.
    #[must_use]
    pub fn get(&self, k: usize, l: usize) -> Option<DVec3> {
        if k.saturating_add(l) > self.order { None } else { self.values.get(derivative_index(k, l)).copied() }
    }

    /// [`Derivatives::get`] for orders that are known to be present.
    pub(crate) fn at(&self, k: usize, l: usize) -> DVec3 {
        self.get(k, l).unwrap_or(DVec3::ZERO)
    }
}

/// Index of the derivative of order k in u and l in v.
pub(crate) fn derivative_index(k: usize, l: usize) -> usize {
    (k + l) * (k + l + 1) / 2 + l
}

/// Derivatives of a projected curve from those of its homogeneous form, both ascending in order.
///
/// # Source
/// @markgraf2019 eq. 14.
pub(crate) fn project_derivatives(homogeneous: &[DVec4]) -> Vec<DVec3> {
    let weight = homogeneous.first().map_or(1.0, |a| a.w);
    let mut values: Vec<DVec3> = Vec::with_capacity(homogeneous.len());
    for (k, a) in homogeneous.iter().enumerate() {
        let known = (1..=k).map(|m| values[k - m] * (binomial(k, m) * homogeneous[m].w)).sum::<DVec3>();
        values.push((a.truncate() - known) / weight);
    }
    values
}
