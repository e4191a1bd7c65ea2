//! Splines of knots and control points as files give them.

use glanz_brep::model::{CurveVector, SplineCurve};
use glanz_geometry::SurfaceError;
use glanz_geometry::spline::NurbsSurface;
use glanz_math::DVec4;

/// The inner knots that appear more often than the degree, by the indices of the control points that begin there: the point before
/// each and the point itself are the two ends of a gap.
fn gaps(degree: usize, knots: &[f64]) -> Vec<usize> {
    let count = knots.len().saturating_sub(degree + 1);
    (degree + 1..count).filter(|&i| knots.get(i) == knots.get(i + degree)).collect()
}

/// Removes the items at some ascending indices.
fn remove_at<T>(items: &mut Vec<T>, indices: &[usize]) {
    let mut i = 0..;
    items.retain(|_| i.next().is_none_or(|i| indices.binary_search(&i).is_err()));
}

/// The spline with these knots and homogeneous control points; an inner knot may appear once too often if the curve has no gap there.
///
/// # Errors
/// The reason against it.
pub(crate) fn spline_curve<P: CurveVector>(
    degree: usize,
    mut knots: Vec<f64>,
    mut points: Vec<P::Homogeneous>,
) -> Result<SplineCurve<P>, String> {
    let gaps = gaps(degree, &knots);
    if gaps.iter().any(|&i| points.get(i - 1) != points.get(i)) {
        return Err("the curve has a gap at a knot".to_owned());
    }
    remove_at(&mut points, &gaps);
    remove_at(&mut knots, &gaps);
    SplineCurve::try_new(degree, knots, points).map_err(|error| error.to_string())
}

/// The surface with these knots, made clamped, and rows of constant u of homogeneous control points.
///
/// # Errors
/// The reason against it.
pub(crate) fn spline_surface(
    degrees: [usize; 2],
    [mut knots_u, mut knots_v]: [Vec<f64>; 2],
    mut net: Vec<Vec<DVec4>>,
) -> Result<NurbsSurface, String> {
    let [gaps_u, gaps_v] = [gaps(degrees[0], &knots_u), gaps(degrees[1], &knots_v)];
    let has_gap = |row: &Vec<DVec4>| gaps_v.iter().any(|&j| row.get(j - 1) != row.get(j));
    if gaps_u.iter().any(|&i| net.get(i - 1) != net.get(i)) || net.iter().any(has_gap) {
        return Err("the surface has a gap at a knot".to_owned());
    }
    remove_at(&mut knots_u, &gaps_u);
    remove_at(&mut knots_v, &gaps_v);
    remove_at(&mut net, &gaps_u);
    net.iter_mut().for_each(|row| remove_at(row, &gaps_v));
    let surface = NurbsSurface::try_new(degrees, [knots_u, knots_v], net.concat());
    surface.and_then(clamped).map_err(|error| error.to_string())
}

/// The surface with knots that are clamped to its domain.
fn clamped(surface: NurbsSurface) -> Result<NurbsSurface, SurfaceError> {
    let (u, v) = (surface.knots_u(), surface.knots_v());
    if u.is_clamped() && v.is_clamped() { Ok(surface) } else { surface.restrict([u.domain(), v.domain()]) }
}
