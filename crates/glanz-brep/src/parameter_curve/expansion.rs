//! Curves and carriers at the arguments of jets.

use glanz_math::glam::DVec4;
use glanz_math::{DVec2, DVec3};

use super::jet::{Expansion, Jet};
use crate::carrier::{Carrier, SplineCarrier};
use crate::model::{CurveVector, Placement, SplineCurve};

/// A point of space as jets of its coordinates.
pub(super) type JetPoint = [Jet; 3];

/// Coefficients of the powers of `t - center` of numerator and weight on the piece of a spline that contains `center`.
fn powers<P: CurveVector>(curve: &SplineCurve<P>, center: f64, scale: f64) -> Vec<(P, f64)> {
    let mut factor = 1.0;
    let derivatives = curve.homogeneous_derivatives(center, curve.degree());
    let scaled = derivatives.into_iter().enumerate().map(|(k, h)| {
        if k > 0 {
            factor *= scale / k as f64;
        }
        P::split(h * factor)
    });
    scaled.collect()
}

/// `numerators / weight` where the weight is not 1.
fn quotients<T: Expansion, const N: usize>(numerators: [T; N], weight: &T) -> [T; N] {
    if weight.is_one() {
        return numerators;
    }
    let inverse = weight.inverse();
    numerators.map(|n| n.times(&inverse))
}

/// A curve of the plane on the interval [center - half, center + half] of one of its pieces.
pub(super) fn plane_curve(curve: &SplineCurve<DVec2>, center: f64, half: f64) -> [Jet; 2] {
    let powers = powers(curve, center, half);
    let of =
        |part: &dyn Fn(&(DVec2, f64)) -> f64| Jet::polynomial(&powers.iter().map(part).collect::<Vec<_>>());
    quotients([of(&|p| p.0.x), of(&|p| p.0.y)], &of(&|p| p.1))
}

/// A curve of space at a parameter that is `center` plus an argument with the value 0 at 0.
pub(super) fn space_curve<T: Expansion>(curve: &SplineCurve<DVec3>, center: f64, argument: &T) -> [T; 3] {
    let coefficients = powers(curve, center, 1.0).into_iter().map(|(p, w)| p.extend(w));
    let [x, y, z, w] = polynomials(coefficients, &powers_of(argument, curve.degree()));
    quotients([x, y, z], &w)
}

/// A curve as [`space_curve`] gives it, and its derivative by the parameter.
pub(super) fn space_curve_and_tangent<T: Expansion>(
    curve: &SplineCurve<DVec3>,
    center: f64,
    argument: &T,
) -> [[T; 3]; 2] {
    let coefficients = powers(curve, center, 1.0).into_iter().map(|(p, w)| p.extend(w));
    let slopes = coefficients.clone().enumerate().skip(1).map(|(k, h)| h * k as f64);
    let arguments = powers_of(argument, curve.degree());
    let ([x, y, z, w], [dx, dy, dz, dw]) =
        (polynomials(coefficients, &arguments), polynomials(slopes, &arguments));
    let point = quotients([x, y, z], &w);
    // The quotient rule.
    let [px, py, pz] = point.map(|p| p.times(&dw));
    [point, quotients([dx - px, dy - py, dz - pz], &w)]
}

/// The powers of an argument from the first on.
///
/// Products of functions cost more than their multiples: with Horner's rule, each polynomial in the same argument has products of its own.
fn powers_of<T: Expansion>(argument: &T, count: usize) -> Vec<T> {
    std::iter::successors(Some(*argument), |power| Some(power.times(argument))).take(count).collect()
}

/// The polynomials with these coefficients, the constant first, at an argument with these powers.
fn polynomials<T: Expansion>(coefficients: impl Iterator<Item = DVec4>, arguments: &[T]) -> [T; 4] {
    let mut sums = [T::default(); 4];
    for (k, coefficient) in coefficients.enumerate() {
        for (sum, value) in sums.iter_mut().zip(coefficient.to_array()) {
            match k.checked_sub(1).and_then(|k| arguments.get(k)) {
                Some(power) => *sum = *sum + *power * value,
                None => sum.add_constant(value),
            }
        }
    }
    sums
}

/// A carrier at parameters that are jets; a spline on the piece at their values at 0.
pub(super) fn on_carrier(carrier: &Carrier, uv: &[Jet; 2]) -> JetPoint {
    match carrier {
        Carrier::Plane(placement) => {
            let zero = Jet::default();
            placed(placement, [uv[0], uv[1], zero])
        }
        Carrier::Cylinder { placement, radius } => {
            around(placement, uv[0], Jet::polynomial(&[*radius]), uv[1])
        }
        Carrier::Cone { placement, radius, half_angle } => {
            let mut rho = uv[1] * half_angle.tan();
            rho.add_constant(*radius);
            around(placement, uv[0], rho, uv[1])
        }
        Carrier::Sphere { placement, radius } => {
            let [sin, cos] = uv[1].sin_cos();
            around(placement, uv[0], cos * *radius, sin * *radius)
        }
        Carrier::Torus { placement, major_radius, minor_radius } => {
            let [sin, cos] = uv[1].sin_cos();
            let mut rho = cos * *minor_radius;
            rho.add_constant(*major_radius);
            around(placement, uv[0], rho, sin * *minor_radius)
        }
        Carrier::Spline(spline) => on_spline(spline, uv),
    }
}

/// The point at an angle, a distance from the axis and a height.
fn around(placement: &Placement, angle: Jet, rho: Jet, height: Jet) -> JetPoint {
    let [sin, cos] = angle.sin_cos();
    placed(placement, [cos.times(&rho), sin.times(&rho), height])
}

/// The point with these coordinates in a frame.
fn placed(placement: &Placement, [x, y, z]: JetPoint) -> JetPoint {
    let coordinate = |i: usize| {
        let mut sum = x * placement.x[i] + y * placement.y[i] + z * placement.z[i];
        sum.add_constant(placement.origin[i]);
        sum
    };
    [coordinate(0), coordinate(1), coordinate(2)]
}

fn on_spline(spline: &SplineCarrier, uv: &[Jet; 2]) -> JetPoint {
    let center = spline.wrapped(DVec2::new(uv[0].center(), uv[1].center()));
    let [du, dv] = uv.map(Jet::centered);
    let [rows, columns] = spline.degrees().map(|degree| degree + 1);
    let coefficients: Vec<DVec4> = spline.powers(center);
    // Of a curve of constant u or v, all powers of the difference from it vanish but the first.
    let [rows, used] = [(du, rows), (dv, columns)].map(|(d, count)| if d.is_zero() { 1 } else { count });
    let arguments = powers_of(&dv, used - 1);
    let mut sums = [Jet::default(); 4];
    for (i, row) in coefficients.chunks_exact(columns).take(rows).rev().enumerate() {
        let row = polynomials(row.iter().copied().take(used), &arguments);
        for (sum, row) in sums.iter_mut().zip(row) {
            *sum = if i > 0 { sum.times(&du) + row } else { row };
        }
    }
    let [x, y, z, w] = sums;
    quotients([x, y, z], &w)
}
