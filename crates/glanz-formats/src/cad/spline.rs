//! Splines of knots and control points as files give them.

use glanz_brep::model::{CurveVector, SplineCurve};
use glanz_geometry::SurfaceError;
use glanz_geometry::spline::NurbsSurface;
use glanz_math::DVec4;

/// The inner knots that appear more often than the degree, by the indices of the control points that begin there; a knot that appears still more
/// often has several.
fn gaps(degree: usize, knots: &[f64]) -> Vec<usize> {
    let count = knots.len().saturating_sub(degree + 1);
    (degree + 1..count).filter(|&i| knots.get(i) == knots.get(i + degree)).collect()
}

/// Indices of the control points at the ends of each gap: the last before a knot and the first behind it. Those between them act nowhere.
fn gap_ends(knots: &[f64], gaps: &[usize]) -> Vec<[usize; 2]> {
    let runs = gaps.chunk_by(|&a, &b| knots.get(a) == knots.get(b));
    runs.filter_map(|run| Some([run.first()?.checked_sub(1)?, *run.last()?])).collect()
}

/// Whether the items at the ends of some gap differ.
fn is_torn<T: PartialEq>(items: &[T], ends: &[[usize; 2]]) -> bool {
    ends.iter().any(|&[before, behind]| items.get(before) != items.get(behind))
}

/// Removes the items at some ascending indices.
fn remove_at<T>(items: &mut Vec<T>, indices: &[usize]) {
    let mut i = 0..;
    items.retain(|_| i.next().is_none_or(|i| indices.binary_search(&i).is_err()));
}

/// The spline with these knots and homogeneous control points; an inner knot may appear too often if the curve has no gap there.
///
/// # Errors
/// The reason against it.
pub(crate) fn spline_curve<P: CurveVector>(
    degree: usize,
    mut knots: Vec<f64>,
    mut points: Vec<P::Homogeneous>,
) -> Result<SplineCurve<P>, String> {
    let gaps = gaps(degree, &knots);
    if is_torn(&points, &gap_ends(&knots, &gaps)) {
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
    let (ends_u, ends_v) = (gap_ends(&knots_u, &gaps_u), gap_ends(&knots_v, &gaps_v));
    if is_torn(&net, &ends_u) || net.iter().any(|row| is_torn(row, &ends_v)) {
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

#[cfg(test)]
mod tests {
    use glanz_math::DVec3;

    use super::*;

    const KNOTS: [f64; 7] = [0.0, 0.0, 1.0, 1.0, 1.0, 2.0, 2.0];

    fn point(x: f64) -> DVec4 {
        DVec4::new(x, 0.0, 0.0, 1.0)
    }

    #[test]
    fn control_points_that_act_nowhere_make_no_gap() {
        let [a, b, idle, c] = [0.0, 1.0, 7.0, 2.0].map(point);
        let curve = spline_curve::<DVec3>(1, KNOTS.to_vec(), vec![a, b, idle, b, c]).unwrap();
        assert_eq!(
            (curve.knots().knots(), curve.control_points()),
            (&[0.0, 0.0, 1.0, 2.0, 2.0][..], &[a, b, c][..])
        );
        let row = |p: DVec4| vec![p, p + DVec4::Y];
        let net = [a, b, idle, b, c].map(row).to_vec();
        let surface = spline_surface([1, 1], [KNOTS.to_vec(), vec![0.0, 0.0, 1.0, 1.0]], net).unwrap();
        assert_eq!(surface.counts(), (3, 2));
        assert_eq!(surface.control_points(), [a, b, c].map(row).concat());
    }

    #[test]
    fn different_points_at_the_ends_of_a_gap_are_refused() {
        let [a, b, other, c] = [0.0, 1.0, 1.5, 2.0].map(point);
        // Also if the point between them, which acts nowhere, is one of them.
        for idle in [b, other] {
            assert!(spline_curve::<DVec3>(1, KNOTS.to_vec(), vec![a, b, idle, other, c]).is_err());
        }
    }
}
