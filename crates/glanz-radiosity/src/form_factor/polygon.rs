//! Form factors of polygons that are entirely visible to each other, in closed form along their edges.
//!
//! By Stokes' theorem the double integral over two polygons becomes one over their edges, of the logarithm of the distance
//! (@goral1984 section 5, after Sparrow 1963). The inner integral has a closed form; the outer one uses a Gauss rule, as it is
//! smooth except at common corners, towards which the steps are graded.

use std::f64::consts::PI;

use glanz_math::DVec3;

/// Gauss rule with eight points on [-1, 1]: positive abscissae with their weights.
const GAUSS: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_5),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_3),
];

/// Ends of the steps along an edge that another edge approaches, [0, 1].
const GRADED: [f64; 9] = [0.0, 1e-4, 3e-3, 0.05, 0.5, 0.95, 1.0 - 3e-3, 1.0 - 1e-4, 1.0];

/// Distance of edges, relative to the longer one, below which they count as close.
const CLOSE: f64 = 1.0;

/// The form factor from `a` to `b` times the area of `a`, m^2.
///
/// Corners are counterclockwise seen from the side that emits or receives; each polygon lies in front of the other's plane (see
/// [`in_front`]).
#[must_use]
pub fn exchange(a: &[DVec3], b: &[DVec3]) -> f64 {
    // The unit of length cancels around a closed polygon; one of the size of the distance avoids cancellation of digits.
    let unit = match (a, b) {
        ([p, ..], [q, ..]) => p.distance(*q),
        _ => return 0.0,
    };
    let unit = if unit > 0.0 { unit } else { 1.0 };
    let mut sum = 0.0;
    for (p, q) in edges(a) {
        for (r, s) in edges(b) {
            let cosine = (q - p).dot(s - r);
            if cosine != 0.0 {
                sum += cosine * mean_logarithm([p, q], [r, s], unit);
            }
        }
    }
    (sum / (2.0 * PI)).max(0.0)
}

/// The form factor, [0, 1], from a point with a unit normal to a polygon in front of its plane, by Lambert's formula: the projected
/// angles of the sides.
///
/// Corners are counterclockwise seen from the point.
#[must_use]
pub fn from_point(point: DVec3, normal: DVec3, polygon: &[DVec3]) -> f64 {
    let side = |(p, q): (DVec3, DVec3)| {
        let (p, q) = (p - point, q - point);
        let across = p.cross(q);
        let sine = across.length();
        if sine > 0.0 { sine.atan2(p.dot(q)) * across.dot(normal) / sine } else { 0.0 }
    };
    (-edges(polygon).map(side).sum::<f64>() / (2.0 * PI)).clamp(0.0, 1.0)
}

/// The part of a polygon in front of the plane through `point` with a unit normal; empty if nothing is.
#[must_use]
pub fn in_front(polygon: &[DVec3], point: DVec3, normal: DVec3) -> Vec<DVec3> {
    let reach = polygon.iter().map(|p| p.distance(point)).fold(0.0, f64::max);
    // Corners within rounding of the plane lie in it.
    let height = |p: DVec3| {
        let h = (p - point).dot(normal);
        if h.abs() <= 1e-10 * reach { 0.0 } else { h }
    };
    if polygon.iter().all(|&p| height(p) <= 0.0) {
        return Vec::new();
    }
    let mut kept = Vec::new();
    for (p, q) in edges(polygon) {
        let (h, k) = (height(p), height(q));
        if h >= 0.0 {
            kept.push(p);
        }
        if h * k < 0.0 {
            kept.push(p.lerp(q, h / (h - k)));
        }
    }
    kept
}

fn edges(polygon: &[DVec3]) -> impl Iterator<Item = (DVec3, DVec3)> {
    polygon.iter().zip(polygon.iter().cycle().skip(1)).map(|(&p, &q)| (p, q))
}

/// Mean of ln(|x - y| / unit) over x on one segment and y on the other.
fn mean_logarithm(a: [DVec3; 2], b: [DVec3; 2], unit: f64) -> f64 {
    let along = b[1] - b[0];
    let length = along.length();
    let inner = |share: f64| {
        let from = b[0] - a[0].lerp(a[1], share);
        // Coordinates along the segment and across it.
        let low = from.dot(along) / length;
        let high = low + length;
        let across = (from - along * (low / length)).length();
        (antiderivative(high, across) - antiderivative(low, across)) / length
    };
    let panel = |low: f64, high: f64| {
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
        let pair = |(x, weight): (f64, f64)| weight * (inner(middle - half * x) + inner(middle + half * x));
        half * GAUSS.map(pair).iter().sum::<f64>()
    };
    let reach = length.max(a[0].distance(a[1]));
    // A lower bound on the distance of the edges: that of the middles less half the lengths.
    let apart = (0.5 * (a[0] + a[1])).distance(0.5 * (b[0] + b[1])) - 0.5 * (length + a[0].distance(a[1]));
    let mean = if apart > CLOSE * reach {
        panel(0.0, 1.0)
    } else {
        GRADED.windows(2).map(|ends| panel(ends[0], ends[1])).sum()
    };
    mean - unit.ln()
}

/// Antiderivative of ln sqrt(x^2 + h^2) with respect to x.
fn antiderivative(x: f64, h: f64) -> f64 {
    let square = x * x + h * h;
    if square == 0.0 {
        return 0.0;
    }
    let turn = if h > 0.0 { h * (x / h).atan() } else { 0.0 };
    0.5 * x * square.ln() - x + turn
}
