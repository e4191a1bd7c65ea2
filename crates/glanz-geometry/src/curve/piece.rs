//! Short pieces of curves.

use glanz_math::polynomial::roots;
use glanz_math::{Bounds3, DVec3, Ray};

use crate::bvh::query::HitCollector;
use crate::hit::Hit;

/// Part of its parameters by which a piece extends beyond its ends, so that rounding does not lose a ray between two pieces.
pub(super) const OVERLAP: f64 = 1e-9;

/// Part of a piece's largest coefficient below which its derivative counts as zero: above the roundings of control points up to 1e8 lengths of the piece from
/// the origin. Points of the curve with a smaller derivative are nearer than 1e-9 lengths of the piece to the one without.
const STILL: f64 = 1e-6;

/// Part of its size by which the bounds of a piece exceed it: [`OVERLAP`] extends the curve by at most three times that part of its control polygon, and
/// roundings are smaller unless coordinates are 1e9 times the size.
const MARGIN: f64 = 1e-6;

/// A part of a cubic curve with a width.
#[derive(Clone, Debug)]
pub(super) struct CurvePiece {
    /// The curve as a polynomial over [0, 1], by ascending powers.
    powers: [DVec3; 4],
    /// From the first to the last point.
    chord: DVec3,
    /// Bound on the distance of hits from the chord.
    radius: f64,
    /// Half of the width at the beginning, and its change to the end.
    half_width: [f64; 2],
    /// Parameter of the segment at the beginning, and its change to the end.
    range: [f64; 2],
    segment: u32,
    bounds: Bounds3,
}

impl CurvePiece {
    /// The part of a Bézier segment with these widths at its ends, metres, from `ends[0]` to `ends[1]`.
    pub(super) fn new(segment: u32, points: &[DVec3; 4], widths: [f64; 2], ends: [f64; 2]) -> Self {
        let [start, end] = ends;
        let points =
            [[start; 3], [start, start, end], [start, end, end], [end; 3]].map(|at| blossom(points, at));
        let [a, b, c, d] = points;
        let powers = [a, 3.0 * (b - a), 3.0 * (a - 2.0 * b + c), d - a - 3.0 * (c - b)];
        let halves = ends.map(|u| 0.5 * (widths[0] + (widths[1] - widths[0]) * u));
        let half = halves[0].max(halves[1]);
        let chord = d - a;
        let off_chord = |point: DVec3| (point - a).distance(chord * share(point - a, chord));
        let radius = (half + off_chord(b).max(off_chord(c))) * (1.0 + MARGIN);
        let box_of_points = Bounds3::from_points(points);
        let margin = DVec3::splat(half + MARGIN * (half + box_of_points.diagonal().length()));
        let bounds = Bounds3::new(box_of_points.min - margin, box_of_points.max + margin);
        let half_width = [halves[0], halves[1] - halves[0]];
        Self { powers, chord, radius, half_width, range: [start, end - start], segment, bounds }
    }

    /// A box around all points that rays can hit.
    pub(super) fn bounds(&self) -> Bounds3 {
        self.bounds
    }

    /// Adds the hits with `0 < t <= collector.end()`.
    pub(super) fn hits(&self, ray: &Ray, collector: &mut impl HitCollector) {
        let along = ray.direction / ray.direction.length_squared();
        let perpendicular = |v: DVec3| v - ray.direction * along.dot(v);
        let [start, p1, p2, p3] = self.powers;
        let start = start - ray.origin;
        let q0 = perpendicular(start);
        let chord = perpendicular(self.chord);
        if (q0 + chord * share(-q0, chord)).length_squared() > self.radius * self.radius {
            return;
        }
        let [q1, q2, q3] = [p1, p2, p3].map(perpendicular);
        // q . q' for q = q0 + q1 x + q2 x^2 + q3 x^3.
        let product = [
            q0.dot(q1),
            q1.dot(q1) + 2.0 * q0.dot(q2),
            3.0 * (q1.dot(q2) + q0.dot(q3)),
            4.0 * q1.dot(q3) + 2.0 * q2.dot(q2),
            5.0 * q2.dot(q3),
            3.0 * q3.dot(q3),
        ];
        let largest = p1.length_squared().max(p2.length_squared()).max(p3.length_squared());
        for &x in roots(&product, -OVERLAP, 1.0 + OVERLAP).iter() {
            let velocity = p1 + x * (2.0 * p2 + 3.0 * x * p3);
            // Where the curve has no direction every ray would be perpendicular to it.
            if velocity.length_squared() <= STILL * STILL * largest {
                continue;
            }
            let q = q0 + x * (q1 + x * (q2 + x * q3));
            let half = self.half_width[0] + self.half_width[1] * x;
            let distance = q.length();
            let t = along.dot(start + x * (p1 + x * (p2 + x * p3)));
            if distance > half || !(t > 0.0 && t <= collector.end()) {
                continue;
            }
            let tangent = q1 + x * (2.0 * q2 + 3.0 * x * q3);
            let side = q.cross(tangent).dot(ray.direction);
            let off_middle = if half > 0.0 { 0.5 * (distance / half).copysign(side) } else { 0.0 };
            let u = (self.range[0] + self.range[1] * x).clamp(0.0, 1.0);
            collector.add(Hit::new(t, u, 0.5 + off_middle, self.segment));
        }
    }
}

/// Part of the way along `chord`, from 0 to 1, at which it is nearest to `point`.
fn share(point: DVec3, chord: DVec3) -> f64 {
    let length = chord.length_squared();
    if length > 0.0 { (point.dot(chord) / length).clamp(0.0, 1.0) } else { 0.0 }
}

/// The blossom of a cubic Bézier curve.
fn blossom(points: &[DVec3; 4], [u, v, w]: [f64; 3]) -> DVec3 {
    let [a, b, c, d] = *points;
    let [ab, bc, cd] = [a.lerp(b, u), b.lerp(c, u), c.lerp(d, u)];
    ab.lerp(bc, v).lerp(bc.lerp(cd, v), w)
}
