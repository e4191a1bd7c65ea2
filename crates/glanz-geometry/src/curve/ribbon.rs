//! Curves with normals of their own, as spline surfaces.

use std::f64::consts::FRAC_PI_2;

use glanz_math::DVec3;

use super::{point_at, tangent_at};
use crate::error::{SurfaceError, finite, not_negative};

/// Largest distance between the edges of a ribbon and their splines, in parts of its width.
const EDGE_TOLERANCE: f64 = 1e-5;

/// Largest number of halvings of a segment.
const MOST_HALVINGS: u32 = 8;

/// Sine of the angle below which normals count as parallel: the error of linear interpolation between them is below its square.
const PARALLEL: f64 = 1e-9;

/// A spline surface of degree 3 along a curve and of degree 1 across.
#[derive(Clone, Debug, PartialEq)]
pub struct RibbonSurface {
    /// Knots along the curve, from 0 to 1.
    pub knots: Vec<f64>,
    /// Control points along the curve on the sides v = 0 and v = 1, metres.
    pub points: Vec<[DVec3; 2]>,
}

/// A cubic Bézier segment whose width spreads in the direction N x C' at every point.
struct Ribbon {
    points: [DVec3; 4],
    widths: [f64; 2],
    normals: [DVec3; 2],
    /// Angle between the normals, radians.
    angle: f64,
}

/// Both edges, and their derivatives by u.
type Edges = [[DVec3; 2]; 2];

/// The ribbon along a cubic Bézier segment (metres), with the widths (metres) and normals (of any length) at its ends. Between them the normal turns evenly, opposite ones not at all, and the
/// ribbon is perpendicular to the part of it that is perpendicular to the curve: the normal of the surface.
///
/// The edges are splines that depart from it by at most 1e-5 of the width, save where the normal is parallel to the curve, so that it has no
/// direction, and where the curve turns within 1/256 of it: there the edges are straight.
///
/// # Errors
/// [`SurfaceError::NotFinite`], [`SurfaceError::Negative`] for a width, [`SurfaceError::Degenerate`] if the curve is a point or has no width, or a normal
/// is zero.
pub fn ribbon_surface(
    points: [DVec3; 4],
    widths: [f64; 2],
    normals: [DVec3; 2],
) -> Result<RibbonSurface, SurfaceError> {
    for vector in points.iter().chain(&normals) {
        finite("control point or normal", vector.element_sum())?;
    }
    for width in widths {
        not_negative("width", width)?;
    }
    let degenerate = |reason, value| SurfaceError::Degenerate { reason, value };
    if points.iter().all(|&p| p == points[0]) || widths == [0.0; 2] {
        return Err(degenerate(
            "the ribbon is a point or has no width; its larger width",
            widths[0].max(widths[1]),
        ));
    }
    let [Some(start), Some(end)] = normals.map(DVec3::try_normalize) else {
        return Err(degenerate("a normal of the ribbon is zero", 0.0));
    };
    // The arc cosine of the product would lose half of the digits where normals are parallel or opposite.
    let angle = start.cross(end).length().atan2(start.dot(end));
    // Opposite normals turn to no side; a ribbon is the same from both.
    let are_opposite = angle > FRAC_PI_2 && angle.sin() < PARALLEL;
    let (end, angle) = if are_opposite { (start, 0.0) } else { (end, angle) };
    let ribbon = Ribbon { points, widths, normals: [start, end], angle };
    let first = ribbon.edges(0.0);
    let mut surface = RibbonSurface { knots: vec![0.0; 4], points: vec![first[0]] };
    ribbon.append([0.0, 1.0], [&first, &ribbon.edges(1.0)], MOST_HALVINGS, &mut surface);
    surface.knots.push(1.0);
    Ok(surface)
}

impl Ribbon {
    fn edges(&self, u: f64) -> Edges {
        let [a, b, c, d] = self.points;
        let rest = 1.0 - u;
        let (center, tangent) = (point_at(self.points, u), tangent_at(self.points, u));
        let bend = 6.0 * ((a - 2.0 * b + c) * rest + (b - 2.0 * c + d) * u);
        let (normal, turn) = self.normal(u);
        let (direction, direction_change) = if tangent.length_squared() > 0.0 {
            (tangent, bend)
        } else if bend.length_squared() > 0.0 {
            // The limit of the derivative over the distance of the parameter, which changes by half of the third derivative.
            let side = if u < 0.5 { 1.0 } else { -1.0 };
            (side * bend, side * 3.0 * (d - 3.0 * c + 3.0 * b - a))
        } else {
            (d - a, DVec3::ZERO)
        };
        let across = normal.cross(direction);
        let length = across.length();
        let (unit, change) = if length > 0.0 {
            let change = (turn.cross(direction) + normal.cross(direction_change)) / length;
            let unit = across / length;
            (unit, change - unit * unit.dot(change))
        } else {
            (DVec3::ZERO, DVec3::ZERO)
        };
        let half = 0.5 * (self.widths[0] * rest + self.widths[1] * u);
        let half_change = 0.5 * (self.widths[1] - self.widths[0]);
        let (side, side_change) = (half * unit, half_change * unit + half * change);
        [[center - side, center + side], [tangent - side_change, tangent + side_change]]
    }

    /// The normal and its derivative.
    fn normal(&self, u: f64) -> (DVec3, DVec3) {
        let [start, end] = self.normals;
        let sin = self.angle.sin();
        if sin < PARALLEL {
            return (start.lerp(end, u), end - start);
        }
        let weight = |u: f64| (u * self.angle).sin() / sin;
        let slope = |u: f64| (u * self.angle).cos() * self.angle / sin;
        (start * weight(1.0 - u) + end * weight(u), end * slope(u) - start * slope(1.0 - u))
    }

    /// Appends cubic pieces with the edges' points and derivatives at their ends.
    fn append(&self, [start, end]: [f64; 2], ends: [&Edges; 2], halvings: u32, surface: &mut RibbonSurface) {
        let third = (end - start) / 3.0;
        let [[from, leave], [to, arrive]] = ends;
        let mut controls = [0, 1].map(|side| {
            [from[side], from[side] + third * leave[side], to[side] - third * arrive[side], to[side]]
        });
        let exact = [0.25, 0.5, 0.75].map(|share| (share, self.edges(start + (end - start) * share)));
        let deviation = |controls: &[[DVec3; 4]; 2]| {
            let off = |(share, edges): &(f64, Edges)| {
                let [left, right] =
                    [0, 1].map(|side| point_at(controls[side], *share).distance(edges[0][side]));
                left.max(right)
            };
            exact.iter().map(off).fold(0.0, f64::max)
        };
        let smooth = deviation(&controls);
        if smooth > EDGE_TOLERANCE * self.widths[0].max(self.widths[1]) {
            if halvings > 0 {
                let (half, middle) = (0.5 * (start + end), &exact[1].1);
                self.append([start, half], [ends[0], middle], halvings - 1, surface);
                self.append([half, end], [middle, ends[1]], halvings - 1, surface);
                return;
            }
            // Where an edge turns within the last piece, its derivative at the turn leads far away.
            let straight =
                [0, 1].map(|side| [0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0].map(|t| from[side].lerp(to[side], t)));
            if deviation(&straight) < smooth {
                controls = straight;
            }
        }
        surface.points.extend([1, 2, 3].map(|k| controls.map(|side| side[k])));
        surface.knots.extend([end; 3]);
    }
}
