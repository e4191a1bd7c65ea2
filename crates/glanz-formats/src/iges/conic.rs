//! Conic arcs by their equation.

use std::f64::consts::TAU;

use glanz_brep::model::Curve;
use glanz_math::{DVec2, DVec3};

use super::curves::part;
use super::entity::IgesEntity;
use crate::cad::Refusal;

/// The arc of `A x^2 + B x y + C y^2 + D x + E y + F = 0` between two points: counterclockwise on an ellipse.
pub(super) fn conic(entity: IgesEntity<'_>) -> Result<Curve<DVec3>, Refusal> {
    let [a, b, c, d, e, f, z] = entity.numbers(1)?;
    let [x1, y1, x2, y2] = entity.numbers(8)?;
    let ends = [DVec2::new(x1, y1), DVec2::new(x2, y2)];
    // Axes in which there is no term x y.
    let angle = if b == 0.0 { 0.0 } else { 0.5 * b.atan2(a - c) };
    let (sin, cos) = angle.sin_cos();
    let axes = [DVec2::new(cos, sin), DVec2::new(-sin, cos)];
    let square = |v: DVec2| a * v.x * v.x + b * v.x * v.y + c * v.y * v.y;
    let squares = axes.map(square);
    let linears = axes.map(|v| d * v.x + e * v.y);
    let size = squares[0].abs().max(squares[1].abs());
    // Of a parabola one square is rounding.
    let flat = squares.map(|square| square.abs() <= f64::EPSILON.sqrt() * size);
    let curve = match flat {
        [true, true] => None,
        [false, false] => central(axes, squares, linears, f, ends, z),
        [flat, _] => parabola(axes, squares, linears, f, usize::from(!flat), ends, z),
    };
    curve.ok_or_else(|| entity.refuse("the equation is not that of an ellipse, a hyperbola or a parabola"))
}

/// An ellipse or a hyperbola.
fn central(
    axes: [DVec2; 2],
    squares: [f64; 2],
    linears: [f64; 2],
    constant: f64,
    ends: [DVec2; 2],
    z: f64,
) -> Option<Curve<DVec3>> {
    let local = [0, 1].map(|i| -0.5 * linears[i] / squares[i]);
    let center = axes[0] * local[0] + axes[1] * local[1];
    let rest = -(constant + 0.5 * (linears[0] * local[0] + linears[1] * local[1]));
    // s0 x^2 + s1 y^2 = rest.
    let inverse = squares.map(|square| rest / square);
    let radii = inverse.map(|square| square.abs().sqrt());
    if !radii.iter().all(|radius| radius.is_normal()) {
        return None;
    }
    let spread = |v: DVec2| v.extend(0.0);
    if inverse.iter().all(|square| *square > 0.0) {
        let vectors = [axes[0] * radii[0], axes[1] * radii[1]];
        let [start, end] = ends.map(|end| {
            let p = end - center;
            (p.dot(axes[1]) / radii[1]).atan2(p.dot(axes[0]) / radii[0]).rem_euclid(TAU)
        });
        let sweep = (end - start).rem_euclid(TAU);
        let sweep = if ends[0] == ends[1] || sweep <= f64::EPSILON.sqrt() { TAU } else { sweep };
        let ellipse =
            Curve::Ellipse { center: center.extend(z), a: spread(vectors[0]), b: spread(vectors[1]) };
        return Some(part(ellipse, [start, start + sweep]));
    }
    let real = inverse.iter().position(|square| *square > 0.0)?;
    let (axis, other) = if real == 0 { (axes[0], axes[1]) } else { (axes[1], axes[0]) };
    let (radius, width) = if real == 0 { (radii[0], radii[1]) } else { (radii[1], radii[0]) };
    let side = (ends[0] - center).dot(axis).signum();
    let [start, end] = ends.map(|end| ((end - center).dot(other) / width).asinh());
    // Along the parameter from the start to the end.
    let along = if start <= end { 1.0 } else { -1.0 };
    let hyperbola = Curve::Hyperbola {
        center: center.extend(z),
        a: spread(axis * (side * radius)),
        b: spread(other * (along * width)),
    };
    (start != end).then(|| part(hyperbola, [along * start, along * end]))
}

/// A parabola whose square along axis `flat` is 0.
fn parabola(
    axes: [DVec2; 2],
    squares: [f64; 2],
    linears: [f64; 2],
    constant: f64,
    flat: usize,
    ends: [DVec2; 2],
    z: f64,
) -> Option<Curve<DVec3>> {
    let (along, across) = if flat == 0 { (axes[0], axes[1]) } else { (axes[1], axes[0]) };
    let (square, linear, linear_along) =
        if flat == 0 { (squares[1], linears[1], linears[0]) } else { (squares[0], linears[0], linears[1]) };
    // square y^2 + linear y + linear_along x + constant = 0.
    let y = -0.5 * linear / square;
    let x = -(constant + 0.5 * linear * y) / linear_along;
    let apex = along * x + across * y;
    // x - x0 = (y - y0)^2 / (4 focal).
    let focal = -linear_along / (4.0 * square);
    if !focal.is_normal() {
        return None;
    }
    let [start, end] = ends.map(|end| (end - apex).dot(across) / (2.0 * focal.abs()));
    let sense = if start <= end { 1.0 } else { -1.0 };
    let parabola = Curve::Parabola {
        apex: apex.extend(z),
        a: (along * focal).extend(0.0),
        b: (across * (sense * focal.abs())).extend(0.0),
    };
    (start != end).then(|| part(parabola, [sense * start, sense * end]))
}
