//! Edges along which one parameter is constant.

use glanz_geometry::spline::{KnotVector, ParameterDirection, polygon};
use glanz_math::DVec2;
use glanz_math::glam::DVec4;
use glanz_math::rounding::gamma;

use super::deviation::{ENOUGH, SHARPNESS, deviation};
use super::fit::EdgeProjector;
use super::interval::largest;
use super::size::{OPERATIONS, evaluation_size, spline_size};
use super::{EdgeParameterCurve, ParameterCurveSource};
use crate::carrier::Carrier;
use crate::model::SplineCurve;

/// Number of pieces up to which an isoparametric curve and an edge are compared piece by piece; their division takes time of its square.
const MOST_PIECES: usize = 1024;

/// The straight line of constant u or v that is the edge as nearly as the carrier allows; `None` if there is none. On borders the line is exactly there.
pub(super) fn parameter_curve(projector: &EdgeProjector<'_>) -> Option<EdgeParameterCurve> {
    let [first, inner @ .., last] = projector.samples.as_slice() else { return None };
    let poles = projector.edge.domain().map(|t| projector.pole(t));
    (0..2).find_map(|axis| {
        // In a pole the parameter that is not fixed there is not defined.
        let undefined = |pole: Option<(usize, f64)>| pole.is_some_and(|(fixed, _)| fixed != axis);
        let mut all = inner.to_vec();
        all.extend(
            [(*first, poles[0]), (*last, poles[1])]
                .into_iter()
                .filter(|(_, pole)| !undefined(*pole))
                .map(|(uv, _)| uv),
        );
        let value = constant(projector, &all, axis)?;
        let ends = [(*first, poles[0]), (*last, poles[1])].map(|(mut uv, pole)| {
            if let Some((fixed, value)) = pole {
                uv[fixed] = value;
            }
            uv[axis] = value;
            uv
        });
        let curve = SplineCurve::line(ends[0], ends[1], [0.0, 1.0]).ok()?;
        let deviation = line_deviation(projector, &curve, axis, value);
        (deviation <= projector.limit()).then_some(EdgeParameterCurve {
            curve,
            deviation,
            source: ParameterCurveSource::Exact,
        })
    })
}

/// The value of a parameter that is the same at all points within the tolerance: that of a border if it is there, else the mean.
fn constant(projector: &EdgeProjector<'_>, points: &[DVec2], axis: usize) -> Option<f64> {
    let first = points.first()?[axis];
    let mean = first + points.iter().map(|uv| uv[axis] - first).sum::<f64>() / points.len() as f64;
    let speed = largest(points.iter().map(|uv| projector.carrier.tangents(*uv)[axis].length()));
    let near = |value: f64| points.iter().all(|uv| (uv[axis] - value).abs() * speed <= projector.limit());
    if !near(mean) {
        return None;
    }
    // Other surfaces have no border but their poles.
    let has_border = matches!(projector.carrier, Carrier::Spline(_))
        || projector.carrier.poles().iter().any(|pole| pole.axis == axis);
    if !has_border {
        return Some(mean);
    }
    // Of a seam, the side on which the points are.
    let [low, high] = projector.carrier.domain()[axis];
    let period = projector.carrier.periods()[axis].unwrap_or(0.0);
    let turns = if period > 0.0 { ((mean - low) / period).round() * period } else { 0.0 };
    Some([low + turns, high].into_iter().find(|border| border.is_finite() && near(*border)).unwrap_or(mean))
}

/// Bound on the distance between an isoparametric curve of the carrier and the edge, metres. `curve`: the line; `value`: of its parameter `axis`.
fn line_deviation(projector: &EdgeProjector<'_>, curve: &SplineCurve<DVec2>, axis: usize, value: f64) -> f64 {
    let bound = piecewise_bound(projector, curve, axis, value).unwrap_or(f64::INFINITY);
    let enough = (SHARPNESS * projector.stray).max(ENOUGH * projector.tolerance);
    // Beyond the tolerance a sharper one may show another curve to be the better one.
    if bound <= enough.min(projector.tolerance) {
        return bound;
    }
    let searched = deviation(projector.carrier, curve, projector.edge, false, projector.tolerance);
    if searched < bound { searched } else { bound }
}

/// Bound on the distance, metres, between an isoparametric curve of a spline and the edge, of which each piece corresponds to one of the other;
/// `None` where their numbers differ or the line leaves the domain. `curve`: the line; `value`: of its parameter `axis`.
fn piecewise_bound(
    projector: &EdgeProjector<'_>,
    curve: &SplineCurve<DVec2>,
    axis: usize,
    value: f64,
) -> Option<f64> {
    let Carrier::Spline(spline) = projector.carrier else { return None };
    let ends = curve.domain().map(|t| curve.point(t)[1 - axis]);
    // Beyond a seam the surface has no knots.
    let [first, last] = projector.carrier.domain()[axis];
    if !(first..=last).contains(&value) {
        return None;
    }
    let fixed = [ParameterDirection::U, ParameterDirection::V][axis];
    let line = spline.surface().isocurve(fixed, value).ok()?;
    let line = line.restrict([ends[0].min(ends[1]), ends[0].max(ends[1])]).ok()?;
    let edge = if ends[0] > ends[1] { &projector.edge.reversed().ok()? } else { projector.edge };
    let counts = [line.knots(), edge.knots()].map(|knots| knots.breaks().len());
    if counts[0] != counts[1] || counts[0] > MOST_PIECES {
        return None;
    }
    let degree = line.knots().degree().max(edge.degree());
    let line = bezier_points(line.knots(), line.control_points(), degree)?;
    let edge = bezier_points(edge.knots(), edge.control_points(), degree)?;
    // Neighbours share a point.
    let pieces = (0..line.len().saturating_sub(1)).step_by(degree);
    let bounds = pieces.map(|i| Some(piece_bound(line.get(i..=i + degree)?, edge.get(i..=i + degree)?)));
    let bound = largest(bounds.collect::<Option<Vec<f64>>>()?);
    let rounding = gamma(OPERATIONS) * evaluation_size(projector.carrier, curve, spline_size(projector.edge));
    Some(bound + rounding)
}

/// The Bézier points of the pieces of a curve, elevated to `degree`; neighbours share one.
fn bezier_points(knots: &KnotVector, points: &[DVec4], degree: usize) -> Option<Vec<DVec4>> {
    let lower = knots.degree();
    let (_, mut points) = polygon::bezier(knots, points).ok()?;
    // Piece by piece: elevation of a spline would extrapolate.
    for p in lower..degree {
        let pieces = (points.len() - 1) / p;
        let mut raised = Vec::with_capacity(pieces * (p + 1) + 1);
        raised.extend(points.first());
        for piece in points.windows(p + 1).step_by(p) {
            let inner = piece.windows(2).zip(1..);
            raised.extend(inner.map(|(pair, i)| {
                let share = f64::from(i) / (p + 1) as f64;
                pair[0] * share + pair[1] * (1.0 - share)
            }));
            raised.extend(piece.last());
        }
        points = raised;
    }
    Some(points)
}

/// Bound on the distance of two rational Bézier curves at corresponding parameters, metres.
///
/// Multiplying weight i by c^i changes only the parameter of a curve; c is chosen so that the ratio of the last weights equals that of the first. With curves A / a and
/// B / b, the difference is `(A - B) / a - (B / b) (a - b) / a`, bounded by the Bézier points of its numerators.
///
/// # Source
/// @farin2002 section 13.5 (reparametrisation).
fn piece_bound(line: &[DVec4], edge: &[DVec4]) -> f64 {
    let ([first, .., last], [start, .., end]) = (line, edge) else { return f64::INFINITY };
    let ratio = ((last.w / first.w) / (end.w / start.w)).powf(((line.len() - 1) as f64).recip());
    let mut factor = first.w / start.w;
    let center = start.truncate() / start.w;
    let [mut apart, mut weights, mut reach, mut least]: [f64; 4] = [0.0, 0.0, 0.0, f64::INFINITY];
    for (a, b) in line.iter().zip(edge) {
        let b = *b * factor;
        factor *= ratio;
        let [from, to] = [a, &b].map(|p| p.truncate() - center * p.w);
        apart = largest([apart, from.distance(to)]);
        weights = largest([weights, (a.w - b.w).abs()]);
        reach = largest([reach, to.length() / b.w]);
        least = least.min(a.w);
    }
    (apart + reach * weights) / least
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_1_SQRT_2, PI};

    use glanz_geometry::spline::NurbsSurface;
    use glanz_math::{Bounds3, DVec3};

    use super::*;
    use crate::model::FaceSurface;

    /// An arc of this angle about the origin, from X on, whose weights are multiplied by `first c^i`.
    fn arc(radius: f64, angle: f64, [first, c]: [f64; 2]) -> Vec<DVec4> {
        let at = |angle: f64| DVec3::new(angle.cos(), angle.sin(), 0.0) * radius;
        let half = 0.5 * angle;
        let points = [(at(0.0), 1.0), (at(half) / half.cos(), half.cos()), (at(angle), 1.0)];
        let weights = [first, first * c, first * c * c];
        points
            .into_iter()
            .zip(weights)
            .map(|((p, w), factor)| (p * (w * factor)).extend(w * factor))
            .collect()
    }

    #[test]
    fn bound_of_concentric_arcs_is_the_distance_of_their_corners() {
        for angle in [PI / 6.0, PI / 3.0, PI / 2.0] {
            for (distance, c) in [(0.0, 3.0), (1e-3, 1.0), (1e-3, 0.25)] {
                let bound = piece_bound(&arc(1.0, angle, [1.0; 2]), &arc(1.0 + distance, angle, [2.0, c]));
                // Numerators are w times the distance of the corner, over the least weight.
                let expected = distance / (0.5 * angle).cos();
                assert!((bound - expected).abs() < 1e-14, "{bound} for {expected}");
            }
        }
    }

    #[test]
    fn bound_of_arcs_with_other_weights_is_at_least_their_distance() {
        let (angle, middle) = (PI / 2.0, FRAC_1_SQRT_2);
        let mut ellipse = arc(1.0, angle, [1.0; 2]);
        ellipse[1] *= 0.75 / middle;
        // At 1/2, the corner counts with the share w / (1 + w), and is 1 / sqrt 2 from the chord.
        let depth = |w: f64| w / (1.0 + w) * FRAC_1_SQRT_2;
        let (bound, distance) =
            (piece_bound(&arc(1.0, angle, [1.0; 2]), &ellipse), depth(0.75) - depth(middle));
        assert!((distance..20.0 * distance).contains(&bound), "{bound} for {distance}");
    }

    /// A cylinder of radius 1 and height 2 over a closed turn in u, of four pieces.
    fn cylinder() -> Carrier {
        let quarters = (0..4).flat_map(|i| {
            let turn = glanz_math::glam::DMat3::from_rotation_z(f64::from(i) * PI / 2.0);
            let points = arc(1.0, PI / 2.0, [1.0; 2]).into_iter();
            points.take(2).map(move |p| (turn * p.truncate()).extend(p.w))
        });
        let ring: Vec<DVec4> = quarters.chain([DVec4::new(1.0, 0.0, 0.0, 1.0)]).collect();
        let points = ring.iter().flat_map(|p| [*p, DVec4::new(p.x, p.y, 2.0 * p.w, p.w)]);
        let knots = [0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 4.0, 4.0, 4.0].to_vec();
        let surface =
            NurbsSurface::try_new([2, 1], [knots, vec![0.0, 0.0, 1.0, 1.0]], points.collect()).unwrap();
        let extent = Bounds3::new(DVec3::new(-2.0, -2.0, 0.0), DVec3::new(2.0, 2.0, 2.0));
        Carrier::try_from_surface(&FaceSurface::Spline(surface), extent, 1e-9).unwrap().carrier
    }

    fn spline(degree: usize, knots: &[f64], points: Vec<DVec4>) -> SplineCurve<DVec3> {
        SplineCurve::from_knots(KnotVector::try_new(degree, knots.to_vec()).unwrap(), points).unwrap()
    }

    #[test]
    fn edges_with_the_pieces_of_the_surface_are_compared_by_control_points() {
        let carrier = cylinder();
        let quarter_of =
            |weights| spline(2, &[0.0, 0.0, 0.0, 1.0, 1.0, 1.0], arc(1.0 + 1e-7, PI / 2.0, weights));
        let quarter = quarter_of([2.0, 0.5]);
        // Elevation before a change of parameter makes other control points.
        let raised = quarter_of([1.0, 1.0]).elevated(4).unwrap();
        let reversed = raised.reversed().unwrap();
        let side = [0.0, 2.0].map(|z| DVec4::new(1.0, 0.0, z, 1.0)).to_vec();
        let side = spline(1, &[5.0, 5.0, 6.0, 6.0], side);
        let bound_of = |edge: &SplineCurve<DVec3>, from: DVec2, to: DVec2, axis: usize| {
            // The parameters of the carrier are lengths of control polygons: 2 for a quarter and for the height.
            let [from, to] = [from, to].map(|end| end * 2.0);
            let curve = SplineCurve::line(from, to, [0.0, 1.0]).unwrap();
            let projector = EdgeProjector::new(&carrier, edge, 1e-6);
            piecewise_bound(&projector, &curve, axis, from[axis])
        };
        // The corner of a quarter is farther by sqrt 2; after elevation, control points are nearer to the curve.
        for (edge, [from, to], most) in
            [(&quarter, [0.0, 1.0], 1.42), (&raised, [0.0, 1.0], 1.25), (&reversed, [1.0, 0.0], 1.25)]
        {
            let bound = bound_of(edge, DVec2::new(from, 0.0), DVec2::new(to, 0.0), 1);
            assert!(bound.is_some_and(|bound| (1.0..most).contains(&(bound / 1e-7))), "{bound:?}");
        }
        let bound = bound_of(&side, DVec2::ZERO, DVec2::Y, 0);
        assert!(bound.is_some_and(|bound| bound < 1e-12), "{bound:?}");
        // Beyond the seam there are no knots.
        let bound = bound_of(&side, DVec2::new(4.5, 0.0), DVec2::new(4.5, 1.0), 0);
        assert_eq!(bound, None);
        let bound = bound_of(&quarter, DVec2::new(3.5, 0.0), DVec2::new(4.5, 0.0), 1);
        assert_eq!(bound, None);
    }
}
