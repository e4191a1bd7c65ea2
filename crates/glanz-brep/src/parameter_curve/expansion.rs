//! Curves and carriers at the arguments of jets.

use glanz_math::glam::DVec4;
use glanz_math::{DVec2, DVec3};

use super::jet::{Expansion, Jet};
use crate::carrier::{Carrier, SplineCarrier};
use crate::model::{CurveVector, Placement, SplineCurve};

/// A point of space as jets of its coordinates.
pub(super) type JetPoint = [Jet; 3];

/// Coefficients of the powers of `t - center` of numerator and weight on the piece of a spline that contains `center`.
fn coefficients<P: CurveVector>(curve: &SplineCurve<P>, center: f64, scale: f64) -> Vec<(P, f64)> {
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
    let coefficients = coefficients(curve, center, half);
    let of = |part: &dyn Fn(&(DVec2, f64)) -> f64| {
        Jet::polynomial(&coefficients.iter().map(part).collect::<Vec<_>>())
    };
    quotients([of(&|p| p.0.x), of(&|p| p.0.y)], &of(&|p| p.1))
}

/// A curve of space at a parameter that is `center` plus an argument with the value 0 at 0.
pub(super) fn space_curve<T: Expansion>(curve: &SplineCurve<DVec3>, center: f64, argument: &T) -> [T; 3] {
    let coefficients = coefficients(curve, center, 1.0).into_iter().map(|(p, w)| p.extend(w));
    let [x, y, z, w] = polynomials(coefficients, &powers_of(argument, curve.degree()));
    quotients([x, y, z], &w)
}

/// A curve as [`space_curve`] gives it, and its derivative by the parameter.
pub(super) fn space_curve_and_tangent<T: Expansion>(
    curve: &SplineCurve<DVec3>,
    center: f64,
    argument: &T,
) -> [[T; 3]; 2] {
    let coefficients = coefficients(curve, center, 1.0).into_iter().map(|(p, w)| p.extend(w));
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
    let mut powers: Vec<T> = Vec::with_capacity(count);
    for _ in 0..count {
        powers.push(powers.last().map_or(*argument, |power| power.times(argument)));
    }
    powers
}

/// The polynomials with these coefficients, the constant first, at an argument with these powers; further powers are taken to vanish.
fn polynomials<T: Expansion>(mut coefficients: impl Iterator<Item = DVec4>, arguments: &[T]) -> [T; 4] {
    let mut sums = [T::default(); 4];
    let constants = coefficients.next().unwrap_or_default().to_array();
    sums.iter_mut().zip(constants).for_each(|(sum, constant)| sum.add_constant(constant));
    for (coefficient, power) in coefficients.zip(arguments) {
        for (sum, value) in sums.iter_mut().zip(coefficient.to_array()) {
            *sum = *sum + *power * value;
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
    // Of a curve of constant u or v, all powers of the difference from it vanish but that of order 0.
    let [rows, used] = [(du, rows), (dv, columns)].map(|(d, count)| if d.is_zero() { 1 } else { count });
    let arguments = powers_of(&dv, used - 1);
    let mut sums = [Jet::default(); 4];
    for (i, row) in coefficients.chunks_exact(columns).take(rows).rev().enumerate() {
        let row = polynomials(row.iter().copied(), &arguments);
        for (sum, row) in sums.iter_mut().zip(row) {
            *sum = if i > 0 { sum.times(&du) + row } else { row };
        }
    }
    let [x, y, z, w] = sums;
    quotients([x, y, z], &w)
}

#[cfg(test)]
mod tests {
    use glanz_geometry::spline::KnotVector;

    use super::super::jet::{ORDER, TaylorSeries};
    use super::*;

    /// A rational cubic of three spans.
    fn curve() -> SplineCurve<DVec3> {
        let knots = [0.0, 0.0, 0.0, 0.0, 1.0, 2.0, 3.0, 3.0, 3.0, 3.0];
        let points =
            [[0.0, 0.0, 1.0, 1.0], [1.0, 2.0, 0.5, 2.0], [3.0, -1.0, 0.0, 1.5], [4.0, 1.0, 1.0, 1.0]]
                .into_iter()
                .chain([[5.0, 0.0, 2.0, 0.75], [6.0, 3.0, 0.0, 1.0]]);
        let points = points.map(|[x, y, z, w]| DVec4::new(x * w, y * w, z * w, w)).collect();
        SplineCurve::from_knots(KnotVector::try_new(3, knots.to_vec()).unwrap(), points).unwrap()
    }

    #[test]
    fn curves_at_jets_contain_their_points() {
        let curve = curve();
        // t = 1.5 + x / 4 + x^2 / 8 stays in the middle span.
        let [argument, at] = [[0.0, 0.25, 0.125], [1.5, 0.25, 0.125]];
        let jets = space_curve(&curve, at[0], &Jet::polynomial(&argument));
        let [series, tangent] = space_curve_and_tangent(&curve, at[0], &TaylorSeries::polynomial(&argument));
        for i in -10..=10 {
            let x = f64::from(i) / 10.0;
            let [point, along] = [0, 1].map(|k| curve.derivatives(at[0] + at[1] * x + at[2] * x * x, 1)[k]);
            for axis in 0..3 {
                let jet = &jets[axis];
                let sum = (0..ORDER).rev().fold(0.0, |sum, k| sum * x + jet.middles.0[k]);
                assert!((point[axis] - sum).abs() <= jet.magnitude(ORDER) + 1e-14, "{x} {axis}");
                assert_eq!(jet.middles.0, series[axis].0);
            }
            let sum = |series: TaylorSeries| series.0.iter().rev().fold(0.0, |sum, a| sum * x + a);
            if x.abs() < 0.25 {
                // The terms that are left out are of the order of 4^-10.
                assert!(DVec3::from(tangent.map(sum)).distance(along) < 1e-5, "{x}");
            }
        }
        // The remainder is much smaller than the curve.
        assert!(jets.iter().all(|jet| jet.magnitude(ORDER) < 0.1), "{jets:?}");
    }
}
