//! Ruled surfaces.

use glanz_brep::model::{Curve, FaceSurface, SplineCurve};
use glanz_geometry::SurfaceError;
use glanz_geometry::spline::{NurbsCurve, NurbsSurface};
use glanz_math::{DMat4, DVec3};

use super::entity::IgesEntity;
use super::lowering::{IgesReader, MAX_DEPTH};
use super::surfaces::IgesSurface;
use crate::cad::Refusal;

/// Knots that curves may take over from one another, at most: each takes time in proportion to the curve.
const MAX_INSERTED: usize = 512;

/// Difference of knots over [0, 1] that comes from rounding.
const SAME_KNOT: f64 = 1e-12;

/// Difference of weights and of squared radii, relative, up to which they are the same but for rounding in the file.
const SAME: f64 = 1e-6;

/// A curve with its spline over [0, 1], in the order of the rulings.
struct RuledSide {
    curve: Curve<DVec3>,
    spline: SplineCurve<DVec3>,
}

impl IgesReader<'_> {
    /// `C1, C2, DIRFLG, DEVFLG`: straight lines between points of two curves with equal relative lengths (form 0) or parameters (form 1).
    pub(super) fn ruled(&mut self, entity: IgesEntity<'_>, outer: DMat4) -> Result<IgesSurface, Refusal> {
        let (first, second) = (self.ruled_side(entity, 1, outer)?, self.ruled_side(entity, 2, outer)?);
        let spline =
            snapped(&second.spline, &first.spline).map_err(|error| entity.refuse(error.to_string()))?;
        let second = RuledSide { spline, ..second };
        // Arcs have angles as parameters, which their splines have only at the knots; with equal knots and weights both differ alike.
        let keeps_parameters = has_own_parameters(&first.curve) && has_own_parameters(&second.curve);
        let alike =
            is_arc(&first.curve) && is_arc(&second.curve) && has_same_form(&first.spline, &second.spline);
        if !keeps_parameters && !alike {
            return Err(entity.refuse(
                "a ruled surface between a conic and another curve, or one of another angle, is not read",
            ));
        }
        let (surface, same_weights) = self.ruled_spline(entity, &first.spline, &second.spline)?;
        let (surface, ranges) = (FaceSurface::Spline(surface), Some([[0.0, 1.0]; 2]));
        if keeps_parameters && same_weights {
            Ok(IgesSurface::same(surface, ranges))
        } else {
            Ok(IgesSurface { ranges, ..IgesSurface::without_parameters(surface) })
        }
    }

    /// The curve of parameter `i`.
    fn ruled_side(&mut self, entity: IgesEntity<'_>, i: usize, outer: DMat4) -> Result<RuledSide, Refusal> {
        let curve = self.curve(entity.reference(i)?, outer, MAX_DEPTH)?;
        if entity.form() == 0 && !is_by_length(&curve) {
            return Err(entity.refuse(
                "a ruled surface of form 0 between curves that are neither straight nor circular is not read",
            ));
        }
        let reversed = i == 2 && entity.flag(3)?;
        let spline = curve.to_spline(curve.domain()).map_err(|error| entity.refuse(error.to_string()))?;
        let spline = if reversed { spline.reversed() } else { Ok(spline) };
        let spline = spline.and_then(|spline| spline.over([0.0, 1.0]));
        let spline = spline.map_err(|error| entity.refuse(error.to_string()))?;
        Ok(RuledSide { curve, spline })
    }

    /// The surface between two splines over [0, 1], and whether their weights are the same but for a factor, without which the second
    /// parameter is no longer linear.
    fn ruled_spline(
        &mut self,
        entity: IgesEntity<'_>,
        first: &SplineCurve<DVec3>,
        second: &SplineCurve<DVec3>,
    ) -> Result<(NurbsSurface, bool), Refusal> {
        let fault = |error: SurfaceError| entity.refuse(error.to_string());
        let degree = first.degree().max(second.degree());
        let elevated = |side: &SplineCurve<DVec3>| {
            let side = side.elevated(degree)?;
            NurbsCurve::from_knots(side.knots().clone(), side.control_points().to_vec())
        };
        let (mut first, mut second) = (elevated(first).map_err(fault)?, elevated(second).map_err(fault)?);
        let distinct = [first.knots().distinct(), second.knots().distinct()];
        let (to_first, to_second) =
            (missing(&distinct[0], &distinct[1]), missing(&distinct[1], &distinct[0]));
        if to_first.len() + to_second.len() > MAX_INSERTED {
            return Err(entity.refuse(format!(
                "the curves of the ruled surface have more than {MAX_INSERTED} different knots"
            )));
        }
        // Degree and knots may make many control points of few in the file.
        let inserted: usize = to_first.iter().map(|(_, count)| count).sum();
        self.budget.spend(entity.id(), 2 * (first.control_points().len() + inserted))?;
        for (knot, count) in to_first {
            first = first.insert_knot(knot, count).map_err(fault)?;
        }
        for (knot, count) in to_second {
            second = second.insert_knot(knot, count).map_err(fault)?;
        }
        let pairs = || first.control_points().iter().zip(second.control_points());
        let ratios: Vec<f64> = pairs().map(|(a, b)| b.w / a.w).collect();
        let ratio = ratios.first().copied().unwrap_or(1.0);
        let same_weights = ratios.iter().all(|other| (other / ratio - 1.0).abs() <= SAME);
        let points = pairs().flat_map(|(a, b)| [*a, *b * (1.0 / ratio)]);
        let knots = [first.knots().knots().to_vec(), vec![0.0, 0.0, 1.0, 1.0]];
        let surface = NurbsSurface::try_new([degree, 1], knots, points.collect()).map_err(fault)?;
        Ok((surface, same_weights))
    }
}

/// Whether the parameter of a curve is in proportion to its length.
fn is_by_length(curve: &Curve<DVec3>) -> bool {
    match curve {
        Curve::Line { .. } => true,
        // A line without a length, too.
        Curve::Polyline(points) => points.len() == 2,
        Curve::Ellipse { a, b, .. } => {
            let (square, slack) = (a.length_squared(), SAME * a.length_squared());
            (b.length_squared() - square).abs() <= slack && a.dot(*b).abs() <= slack
        }
        Curve::Trimmed { basis, .. } => is_by_length(basis),
        _ => false,
    }
}

/// Whether the spline of a curve has its parameters.
fn has_own_parameters(curve: &Curve<DVec3>) -> bool {
    match curve {
        Curve::Line { .. } | Curve::Parabola { .. } | Curve::Spline(_) | Curve::Polyline(_) => true,
        Curve::Trimmed { basis, .. } => has_own_parameters(basis),
        Curve::Composite(segments) => segments.iter().all(|(segment, _)| has_own_parameters(segment)),
        Curve::Ellipse { .. } | Curve::Hyperbola { .. } => false,
    }
}

/// Whether a curve is an arc of a circle or an ellipse.
fn is_arc(curve: &Curve<DVec3>) -> bool {
    match curve {
        Curve::Ellipse { .. } => true,
        Curve::Trimmed { basis, .. } => is_arc(basis),
        _ => false,
    }
}

/// A spline whose knots are those of another where they differ by rounding: else they would have pieces without a length.
fn snapped(
    spline: &SplineCurve<DVec3>,
    other: &SplineCurve<DVec3>,
) -> Result<SplineCurve<DVec3>, SurfaceError> {
    let others = other.knots().knots();
    let snap = |knot: &f64| {
        let at = others.partition_point(|other| *other < *knot - SAME_KNOT);
        others.get(at).copied().filter(|other| *other <= *knot + SAME_KNOT).unwrap_or(*knot)
    };
    let knots = spline.knots().knots().iter().map(snap).collect();
    SplineCurve::try_new(spline.degree(), knots, spline.control_points().to_vec())
}

/// Whether two splines have the same degree, knots and weights.
fn has_same_form(a: &SplineCurve<DVec3>, b: &SplineCurve<DVec3>) -> bool {
    let (points_a, points_b) = (a.control_points(), b.control_points());
    a.knots() == b.knots() && points_a.iter().zip(points_b).all(|(a, b)| (a.w - b.w).abs() <= SAME)
}

/// The knots of the second list that are missing in the first, with their numbers; both ascend.
fn missing(own: &[(f64, usize)], other: &[(f64, usize)]) -> Vec<(f64, usize)> {
    let mut rest = own.iter().peekable();
    let mut more = Vec::new();
    for &(knot, count) in other {
        while rest.next_if(|(own, _)| *own < knot).is_some() {}
        let known = rest.peek().filter(|(own, _)| *own == knot).map_or(0, |(_, count)| *count);
        if count > known {
            more.push((knot, count - known));
        }
    }
    more
}
