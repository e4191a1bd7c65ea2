//! Curves in space that are given by curves in the parameters of surfaces alone.

use glanz_brep::model::{Curve, CurveVector, FaceSurface, SplineCurve};
use glanz_math::glam::DQuat;
use glanz_math::{DVec2, DVec3};

use super::border::isoline;
use super::curves::CurveSegment;
use super::entity::IgesEntity;
use super::lowering::IgesReader;
use super::surfaces::SurfaceLink;
use crate::cad::Refusal;

/// What is done about a missing curve in space.
pub(super) const LIFTED: &str =
    "there is no curve in space; the surface and the curves in its parameters give it";

/// Distance of a fitted curve from the surface, relative to the size of the curve: less than what faces are trimmed to.
const ACCURACY: f64 = 1e-8;

/// Part of the range of a parameter by which a curve may leave its surface.
const BEYOND: f64 = 1e-3;

/// Equal pieces of a conic to begin with.
const CONIC_PIECES: usize = 8;

/// Pieces to begin with, at most, for the patches of a surface that a curve may cross.
const MAX_PATCHES: usize = 64;

/// Times that a piece is halved, at most: at a kink of the surface it becomes as short as rounding.
const MAX_HALVINGS: u32 = 24;

/// Pieces of a fitted curve, at most, for each to begin with.
const MAX_PIECES: usize = 32;

impl IgesReader<'_> {
    /// The curves in space of curves in the parameters of a surface of the model, one for each.
    pub(super) fn surface_curves(
        &mut self,
        entity: IgesEntity<'_>,
        link: &SurfaceLink,
        curves: &[Curve<DVec2>],
    ) -> Result<Vec<CurveSegment>, Refusal> {
        let surface = self.model.surfaces.get(link.index).filter(|_| !curves.is_empty());
        let surface = &surface
            .ok_or_else(|| {
                entity.refuse(match link.parameters {
                    Some(_) => "there is neither a curve in space nor one in the parameters of its surface",
                    None => {
                        "there is no curve in space, and curves in the parameters of its surface are not read"
                    }
                })
            })?
            .surface;
        let mut segments = Vec::with_capacity(curves.len());
        for curve in curves {
            // Each takes time in proportion to the curve that makes the surface, of which it may be a copy.
            self.budget.spend(entity.id(), generatrix_size(surface))?;
            let curve = surface_curve(surface, curve).ok_or_else(|| {
                entity.refuse("the curve in parameters leaves its surface, or is not finite")
            })?;
            if let Curve::Spline(spline) = &curve {
                self.budget.spend(entity.id(), spline.control_points().len())?;
            }
            segments.push(CurveSegment { curve, entity: entity.id() });
        }
        Ok(segments)
    }
}

/// The curve in space of a curve in the parameters of a surface: exact along lines of a constant parameter, else fitted. `None` if it leaves the
/// surface, or is not finite.
fn surface_curve(surface: &FaceSurface, curve: &Curve<DVec2>) -> Option<Curve<DVec3>> {
    exact(surface, curve).or_else(|| Some(Curve::Spline(fitted(surface, curve)?)))
}

/// The curve of a straight line along which one parameter is constant.
fn exact(surface: &FaceSurface, curve: &Curve<DVec2>) -> Option<Curve<DVec3>> {
    let is_straight = match curve {
        Curve::Trimmed { basis, .. } => matches!(basis.as_ref(), Curve::Line { .. }),
        Curve::Spline(spline) => spline.control_points().len() == 2,
        Curve::Polyline(points) => points.len() == 2,
        _ => false,
    };
    let [start, end] = curve.domain().map(|t| curve.point(t));
    let fixed = [0, 1].into_iter().find(|axis| is_straight && start[*axis] == end[*axis])?;
    let [from, to] = [start, end].map(|point| point[1 - fixed]);
    if from == to {
        return None;
    }
    let line = isoline(surface, fixed, start[fixed], [from.min(to), from.max(to)])?;
    if from < to {
        return Some(line);
    }
    let [first, last] = line.domain();
    Some(Curve::Trimmed { basis: Box::new(line), range: [last, first], same_sense: false })
}

/// The point of a surface with parameters in the standard, which are clamped to its range. `None` beyond it.
fn point(surface: &FaceSurface, uv: DVec2) -> Option<DVec3> {
    let point = match surface {
        FaceSurface::Extrusion { curve, direction } => {
            curve.point(clamped(uv.x, curve.domain())?) + *direction * uv.y
        }
        FaceSurface::Revolution { curve, origin, axis } => {
            let point = curve.point(clamped(uv.y, curve.domain())?);
            *origin + DQuat::from_axis_angle(*axis, uv.x) * (point - *origin)
        }
        FaceSurface::Spline(surface) => {
            let u = clamped(uv.x, surface.knots_u().domain())?;
            surface.point(u, clamped(uv.y, surface.knots_v().domain())?)
        }
        FaceSurface::Offset { basis, distance } => match basis.as_ref() {
            FaceSurface::Spline(spline) => point(basis, uv)? + spline.normal(uv.x, uv.y)? * *distance,
            _ => return None,
        },
        _ => return None,
    };
    point.is_finite().then_some(point)
}

fn clamped(value: f64, [low, high]: [f64; 2]) -> Option<f64> {
    let slack = BEYOND * (high - low);
    (value >= low - slack && value <= high + slack).then(|| value.max(low).min(high))
}

/// The number of patches of a surface along both parameters.
fn patches(surface: &FaceSurface) -> usize {
    match surface {
        FaceSurface::Spline(surface) => {
            let (u, v) = surface.counts();
            u + v - surface.knots_u().degree() - surface.knots_v().degree()
        }
        FaceSurface::Offset { basis, .. } => patches(basis),
        FaceSurface::Extrusion { curve, .. } | FaceSurface::Revolution { curve, .. } => {
            CONIC_PIECES.max(breaks(curve).len())
        }
        _ => 1,
    }
}

/// The number of control points of the curve that makes a surface.
fn generatrix_size(surface: &FaceSurface) -> usize {
    match surface {
        FaceSurface::Extrusion { curve, .. } | FaceSurface::Revolution { curve, .. } => curve_size(curve),
        _ => 0,
    }
}

fn curve_size(curve: &Curve<DVec3>) -> usize {
    match curve {
        Curve::Spline(spline) => spline.control_points().len(),
        Curve::Polyline(points) => points.len(),
        Curve::Composite(segments) => segments.iter().map(|(segment, _)| curve_size(segment)).sum(),
        Curve::Trimmed { basis, .. } => curve_size(basis),
        _ => 1,
    }
}

/// Parameters of a curve between which it is smooth, ascending, from its start to its end.
fn breaks<P: CurveVector>(curve: &Curve<P>) -> Vec<f64> {
    let [start, end] = curve.domain();
    let basis = match curve {
        Curve::Trimmed { basis, same_sense: true, .. } => basis.as_ref(),
        other => other,
    };
    let inner: Vec<f64> = match basis {
        Curve::Line { .. } => Vec::new(),
        Curve::Spline(spline) => spline.knots().knots().to_vec(),
        Curve::Polyline(points) => (0..points.len()).map(|i| i as f64).collect(),
        _ => (1..CONIC_PIECES).map(|i| inside([start, end], i as f64 / CONIC_PIECES as f64)).collect(),
    };
    let inner = inner.into_iter().filter(|t| *t > start && *t < end);
    let mut breaks: Vec<f64> = [start].into_iter().chain(inner).chain([end]).collect();
    breaks.dedup();
    breaks
}

/// A piece of a curve, with its points at the thirds of its range.
struct CubicPiece {
    range: [f64; 2],
    points: [DVec3; 4],
    halvings: u32,
}

/// The cubic spline with the parameters of a curve on a surface. `None` if the curve leaves the surface, or is not finite.
fn fitted(surface: &FaceSurface, curve: &Curve<DVec2>) -> Option<SplineCurve<DVec3>> {
    let at = |t: f64| point(surface, curve.point(t));
    let breaks = breaks(curve);
    let smooth = breaks.len().saturating_sub(1).max(1);
    let parts = patches(surface).min(MAX_PATCHES).div_ceil(smooth);
    let piece = |range: [f64; 2], halvings| {
        let points =
            [at(range[0])?, at(inside(range, 1.0 / 3.0))?, at(inside(range, 2.0 / 3.0))?, at(range[1])?];
        Some(CubicPiece { range, points, halvings })
    };
    // The last one is the first along the curve.
    let mut open = Vec::with_capacity(smooth * parts);
    for pair in breaks.windows(2).rev() {
        let [from, to] = <[f64; 2]>::try_from(pair).ok()?;
        let end = |i: usize| if i == parts { to } else { inside([from, to], i as f64 / parts as f64) };
        for i in (0..parts).rev() {
            open.push(piece([end(i), end(i + 1)], 0)?);
        }
    }
    let first = open.last()?.points[0];
    let size = open.iter().flat_map(|piece| piece.points).map(|p| p.distance(first)).fold(0.0, f64::max);
    let most = MAX_PIECES * open.len();
    let (mut knots, mut controls) = (vec![breaks.first().copied()?; 4], vec![first.extend(1.0)]);
    let mut count = open.len();
    while let Some(CubicPiece { range, points, halvings }) = open.pop() {
        let [a, b, c, d] = points;
        // The polynomial through the four points.
        let bezier = [
            a,
            (a * -5.0 + b * 18.0 - c * 9.0 + d * 2.0) / 6.0,
            (a * 2.0 - b * 9.0 + c * 18.0 - d * 5.0) / 6.0,
            d,
        ];
        let mut error: f64 = 0.0;
        for s in [1.0 / 6.0, 0.5, 5.0 / 6.0] {
            error = error.max(at(inside(range, s))?.distance(cubic(&bezier, s)));
        }
        let middle = inside(range, 0.5);
        let can_halve = halvings < MAX_HALVINGS && count < most && range[0] < middle && middle < range[1];
        if error > ACCURACY * size && can_halve {
            open.push(piece([middle, range[1]], halvings + 1)?);
            open.push(piece([range[0], middle], halvings + 1)?);
            count += 1;
            continue;
        }
        controls.extend(bezier.into_iter().skip(1).map(|point| point.extend(1.0)));
        knots.extend([range[1]; 3]);
    }
    knots.extend(breaks.last());
    SplineCurve::try_new(3, knots, controls).ok()
}

/// The parameter at a fraction of a range.
fn inside([from, to]: [f64; 2], fraction: f64) -> f64 {
    from + (to - from) * fraction
}

/// The point of a Bezier curve.
fn cubic([a, b, c, d]: &[DVec3; 4], s: f64) -> DVec3 {
    let r = 1.0 - s;
    *a * (r * r * r) + *b * (3.0 * r * r * s) + *c * (3.0 * r * s * s) + *d * (s * s * s)
}
