//! Surfaces at a distance from others.

use std::f64::consts::PI;

use glanz_geometry::SurfaceError;
use glanz_geometry::spline::{KnotVector, NurbsSurface};
use glanz_math::bspline::Knots;
use glanz_math::glam::{DAffine2, DVec4, Vec3Swizzles};
use glanz_math::{Bounds3, DVec2, DVec3};

use super::conversion::{CarrierConversion, FaceExtent, cone, other_nappe, scaling, torus};
use super::{Carrier, SplineCarrier};
use crate::error::BrepError;
use crate::model::Placement;

/// Largest number of parts in a direction of each piece of a spline whose offset is fitted.
const MAX_PARTS: usize = 64;

/// Largest number of fits: two for each halving of a piece, one for each direction, and a few.
const MAX_ROUNDS: usize = 16;

/// Parts of the sides of the box of a face whose distances from a carrier are compared.
const SIDE_PARTS: usize = 8;

/// Degree of fitted offsets in both directions: the error falls with the sixth power of the length of the parts.
const FIT_DEGREE: usize = 5;

/// Largest number of control points of a fitted offset whose basis has few.
const MAX_POINTS: usize = 1 << 12;

/// Number of control points of a fitted offset for each of its basis, at most: memory stays in proportion to the file.
const MAX_RATIO: usize = 16;

/// The carrier at a `distance` along the normals of the surface of `basis`, metres.
pub(super) fn convert(
    basis: CarrierConversion,
    distance: f64,
    extent: &FaceExtent,
) -> Result<CarrierConversion, BrepError> {
    let outward = if basis.reversed { -distance } else { distance };
    let checked = |reason: &'static str, value: f64| {
        let degenerate = value.abs() <= extent.negligible();
        if degenerate { Err(BrepError::DegenerateSurface { reason, value }) } else { Ok(value) }
    };
    let (carrier, map) = match basis.carrier {
        Carrier::Plane(placement) => {
            let origin = placement.origin + placement.z * outward;
            (Carrier::Plane(Placement { origin, ..placement }), DAffine2::IDENTITY)
        }
        Carrier::Cylinder { placement, radius } => {
            let offset = checked("radius of an offset cylinder", radius + outward)?;
            // A negative radius is the opposite side.
            let turn = if offset < 0.0 { PI } else { 0.0 };
            let map = DAffine2::from_translation(DVec2::new(turn, 0.0));
            (Carrier::Cylinder { placement, radius: offset.abs() }, map)
        }
        Carrier::Cone { placement, radius, half_angle } => {
            nearest_nappe(placement, [radius, half_angle], outward, extent)
        }
        Carrier::Sphere { placement, radius } => {
            let offset = checked("radius of an offset sphere", radius + outward)?;
            let map = if offset < 0.0 {
                scaling(DVec2::new(1.0, -1.0), DVec2::new(PI, 0.0))
            } else {
                DAffine2::IDENTITY
            };
            (Carrier::Sphere { placement, radius: offset.abs() }, map)
        }
        Carrier::Torus { placement, major_radius, minor_radius } => {
            let offset = checked("minor radius of an offset torus", minor_radius + outward)?;
            if offset.abs() >= major_radius {
                let whole = torus(placement, [major_radius, offset.abs()], true, extent)?;
                let reversed = basis.reversed != whole.reversed;
                let deviation = basis.deviation + whole.deviation;
                return Ok(CarrierConversion { reversed, deviation, ..whole });
            }
            let turn = if offset < 0.0 { PI } else { 0.0 };
            let map = DAffine2::from_translation(DVec2::new(0.0, turn));
            (Carrier::Torus { placement, major_radius, minor_radius: offset.abs() }, map)
        }
        Carrier::Spline(ref spline) => return fitted(&basis, spline, outward, extent),
    };
    let reversed = basis.reversed != (map.matrix2.determinant() < 0.0);
    let parameters = basis.parameters.map(|parameters| map * parameters);
    Ok(CarrierConversion { carrier, parameters, deviation: basis.deviation, reversed })
}

/// The offset of that nappe of a cone with this radius and half angle of which the face is one, with the map from the parameters of the
/// nappe from the apex on.
///
/// An offset keeps the side of the apex but for heights up to `|d| sin a`. There the one is taken that comes nearest to all sides of the
/// box of the face, as its edges touch them all.
fn nearest_nappe(
    placement: Placement,
    [radius, half_angle]: [f64; 2],
    outward: f64,
    extent: &FaceExtent,
) -> (Carrier, DAffine2) {
    let kept = offset_nappe(placement, [radius, half_angle], outward, extent);
    let apex = -radius / half_angle.tan();
    let Some(height) = extent.center().map(|center| placement.to_local(center).z - apex) else { return kept };
    let both = (outward * half_angle.sin()).abs();
    if height > both {
        return kept;
    }
    let other = other_nappe(placement, apex, half_angle);
    let (Carrier::Cone { placement, radius, .. }, Some(exchange)) = (other.carrier, other.parameters) else {
        return kept;
    };
    let (carrier, map) = offset_nappe(placement, [radius, half_angle], outward, extent);
    let nearer =
        height < -both || farthest_side(&carrier, &extent.bounds) < farthest_side(&kept.0, &extent.bounds);
    if nearer { (carrier, map * exchange) } else { kept }
}

/// The offset of a nappe with the map from its parameters.
fn offset_nappe(
    mut placement: Placement,
    [radius, half_angle]: [f64; 2],
    outward: f64,
    extent: &FaceExtent,
) -> (Carrier, DAffine2) {
    // The normal is (cos a, -sin a) in radius and height: r + v tan a + d cos a = r + d / cos a + (v - d sin a) tan a.
    let (sin, cos) = half_angle.sin_cos();
    let (mut offset, mut shift) = (radius + outward / cos, -outward * sin);
    if offset < 0.0 {
        let apex = -offset * cos / sin;
        placement.origin += placement.z * apex;
        shift -= apex;
        offset = 0.0;
    }
    let nappe = cone(placement, offset, half_angle, extent);
    let moved = DAffine2::from_translation(DVec2::new(0.0, shift));
    (nappe.carrier, nappe.parameters.unwrap_or(DAffine2::IDENTITY) * moved)
}

/// The largest of the distances of the sides of a box from a carrier, each at the nearest point of a grid.
fn farthest_side(carrier: &Carrier, bounds: &Bounds3) -> f64 {
    let fraction = |i: usize| i as f64 / SIDE_PARTS as f64;
    let side = |axis: usize, end: f64| {
        let points = (0..=SIDE_PARTS).flat_map(|i| (0..=SIDE_PARTS).map(move |j| [fraction(i), fraction(j)]));
        let distances = points.map(|[s, t]| {
            let mut at = DVec3::new(s, t, end);
            // The third coordinate becomes that of the axis.
            at = [at.zxy(), at.yzx(), at][axis];
            carrier.parameters(bounds.min + bounds.diagonal() * at, None).distance
        });
        distances.fold(f64::INFINITY, f64::min)
    };
    (0..3).flat_map(|axis| [side(axis, 0.0), side(axis, 1.0)]).fold(0.0, f64::max)
}

/// A spline through points of the offset of a spline, with twice the largest distance of samples between them as its deviation.
///
/// Its pieces are divided where the offset strays, in the direction in which it does, until it is within the tolerance.
fn fitted(
    basis: &CarrierConversion,
    spline: &SplineCarrier,
    distance: f64,
    extent: &FaceExtent,
) -> Result<CarrierConversion, BrepError> {
    let tolerance = extent.tolerance;
    let refused =
        |deviation| BrepError::Unfitted { shape: "offset of a spline surface", deviation, tolerance };
    let most = MAX_POINTS.max(MAX_RATIO * spline.surface().control_points().len());
    let mut parts = [spline.surface().knots_u(), spline.surface().knots_v()].map(FittedParts::new);
    let mut best = f64::INFINITY;
    for _ in 0..MAX_ROUNDS {
        let knots = [parts[0].knots()?, parts[1].knots()?];
        if knots[0].count().saturating_mul(knots[1].count()) > most {
            break;
        }
        let nodes = [knots[0].greville(), knots[1].greville()];
        let points: Option<Vec<DVec3>> =
            grid(&nodes[0], &nodes[1]).map(|uv| offset_point(spline, uv, distance)).collect();
        let points = points.ok_or_else(|| refused(f64::INFINITY))?;
        let surface = interpolated(spline, knots, &nodes, &points)?;
        let strayed = |us: &[f64], vs: &[f64]| largest_distance(&surface, spline, distance, us, vs);
        let between = [parts[0].samples(), parts[1].samples()];
        let deviation = 2.0 * strayed(between[0].as_flattened(), between[1].as_flattened());
        best = best.min(deviation);
        if deviation <= tolerance {
            let converted = SplineCarrier::try_new(&surface, tolerance)?;
            return Ok(CarrierConversion {
                carrier: Carrier::Spline(converted.carrier),
                parameters: basis.parameters.map(|parameters| converted.parameters * parameters),
                deviation: basis.deviation + deviation + converted.deviation,
                reversed: basis.reversed,
            });
        }
        // At its nodes in one direction, a spline strays by what it does in the other. Both may take half of the tolerance.
        let is_coarse = |strayed: f64| 4.0 * strayed > tolerance;
        let coarse: [Vec<bool>; 2] = [
            between[0].iter().map(|us| is_coarse(strayed(us, &nodes[1]))).collect(),
            between[1].iter().map(|vs| is_coarse(strayed(&nodes[0], vs))).collect(),
        ];
        let none = !coarse.iter().flatten().any(|is_coarse| *is_coarse);
        let mut is_divided = false;
        for (parts, coarse) in parts.iter_mut().zip(&coarse) {
            is_divided |= parts.halve(|i| none || coarse.get(i).is_some_and(|is_coarse| *is_coarse));
        }
        if !is_divided {
            break;
        }
    }
    Err(refused(best))
}

/// The parts of a fitted offset in u or v.
struct FittedParts {
    /// The ends of the pieces of the basis. There the offset is only continuous: where the curvature jumps, so does its speed.
    pieces: Vec<f64>,
    /// The ends of the parts, into which pieces are divided.
    ends: Vec<f64>,
}

impl FittedParts {
    /// Each piece is one part.
    fn new(knots: &KnotVector) -> Self {
        Self { pieces: knots.breaks(), ends: knots.breaks() }
    }

    fn knots(&self) -> Result<KnotVector, SurfaceError> {
        let is_piece = |end: &f64| self.pieces.binary_search_by(|piece| piece.total_cmp(end)).is_ok();
        let inner = self.ends.iter().skip(1).take(self.ends.len().saturating_sub(2));
        let repeated =
            inner.flat_map(|end| std::iter::repeat_n(*end, if is_piece(end) { FIT_DEGREE } else { 1 }));
        let domain = [self.ends[0], self.ends[self.ends.len() - 1]];
        KnotVector::try_new(FIT_DEGREE, Knots::clamped(FIT_DEGREE, domain, repeated))
    }

    /// Parameters inside each part.
    fn samples(&self) -> Vec<[f64; 3]> {
        self.ends
            .windows(2)
            .map(|part| [0.25, 0.5, 0.75].map(|s| part[0] + (part[1] - part[0]) * s))
            .collect()
    }

    /// Halves the parts with these numbers that are not too short. Returns whether there is one.
    fn halve(&mut self, is_chosen: impl Fn(usize) -> bool) -> bool {
        let mut middles = Vec::new();
        for (_, part) in self.ends.windows(2).enumerate().filter(|(number, _)| is_chosen(*number)) {
            let after = self.pieces.partition_point(|end| *end <= part[0]);
            let piece = self.pieces[after] - self.pieces[after - 1];
            // Parts are 1, 1 / 2, 1 / 4, ... of a piece.
            if (part[1] - part[0]) * MAX_PARTS as f64 > 1.5 * piece {
                middles.push(0.5 * (part[0] + part[1]));
            }
        }
        let halves = !middles.is_empty();
        self.ends.extend(middles);
        self.ends.sort_by(f64::total_cmp);
        halves
    }
}

/// The spline through points of the offset of a spline: with its weights, as far as the fit has their degree.
///
/// Around the axis of a turned profile P / w, its normal n turns as P does, so that the numerator w (P / w + d n) is a polynomial of the same degree.
fn interpolated(
    basis: &SplineCarrier,
    knots: [KnotVector; 2],
    [us, vs]: &[Vec<f64>; 2],
    points: &[DVec3],
) -> Result<NurbsSurface, SurfaceError> {
    let basis = basis.surface();
    if !basis.is_polynomial() {
        let weights = grid(us, vs).map(|uv| basis.homogeneous_point(uv.x, uv.y).w);
        let points: Vec<DVec4> = points.iter().zip(weights).map(|(p, w)| (*p * w).extend(w)).collect();
        let found = NurbsSurface::interpolate_homogeneous_at(knots.clone(), [us, vs], &points);
        // Of steep weights the interpolating ones may not be positive.
        if !matches!(found, Err(SurfaceError::NotPositive { .. })) {
            return found;
        }
    }
    NurbsSurface::interpolate_at(knots, [us, vs], points)
}

/// The point at a distance along the normal; `None` where there is no normal.
fn offset_point(spline: &SplineCarrier, uv: DVec2, distance: f64) -> Option<DVec3> {
    let surface = spline.surface();
    surface.normal(uv.x, uv.y).map(|normal| surface.point(uv.x, uv.y) + normal * distance)
}

fn grid(us: &[f64], vs: &[f64]) -> impl Iterator<Item = DVec2> {
    us.iter().flat_map(|u| vs.iter().map(move |v| DVec2::new(*u, *v)))
}

/// The largest distance of a surface from an offset at these parameters; infinite if there is no normal.
fn largest_distance(
    surface: &NurbsSurface,
    basis: &SplineCarrier,
    distance: f64,
    us: &[f64],
    vs: &[f64],
) -> f64 {
    let apart = grid(us, vs).map(|uv| {
        let exact = offset_point(basis, uv, distance);
        exact.map_or(f64::INFINITY, |exact| surface.point(uv.x, uv.y).distance(exact))
    });
    apart.fold(0.0, f64::max)
}
