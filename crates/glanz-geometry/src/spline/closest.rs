//! The point of a spline surface nearest to a given point.

use glanz_math::glam::DVec4;
use glanz_math::rounding::UNIT_ROUNDOFF;
use glanz_math::{Bounds3, DVec3};

use super::homogeneous::project;
use super::polygon::mix;
use super::surface::NurbsSurface;
use crate::bezier::Derivatives;
use crate::error::{SurfaceError, finite, positive};

/// The nearest point of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClosestPoint {
    /// Its first parameter.
    pub u: f64,
    /// Its second parameter.
    pub v: f64,
    /// Its position, metres.
    pub point: DVec3,
    /// Its distance, metres.
    pub distance: f64,
    /// Lower bound on the distance of all points of the surface, metres, up to rounding.
    pub lower_bound: f64,
}

/// Largest number of halved parts, after which the search ends with the bound reached. Where many points are equally near,
/// as from the middle of a sphere, no bound separates them.
const MAX_HALVINGS: usize = 4096;

/// Largest number of Newton steps; from a good start, four are enough.
const MAX_NEWTON_STEPS: usize = 32;

/// Relative rounding of squared distances.
const ROUNDING: f64 = 8.0 * UNIT_ROUNDOFF;

/// Part of the curvature of the squared distance without second derivatives below which that with them is not told from none: by its step,
/// all directions being equally good, the point would move far for a decrease of rounding.
const SINGULAR: f64 = 1.0 / (1_u32 << 26) as f64;

/// A step of Newton's method in the parameters.
struct NewtonStep {
    du: f64,
    dv: f64,
    /// By how much it lowers the squared distance, m^2.
    decrease: f64,
}

/// A part of a Bézier piece, with a bound on its distance.
struct PatchPart {
    /// Parameter ranges of the whole piece, in which Newton's method may move.
    piece: [[f64; 2]; 2],
    range: [[f64; 2]; 2],
    counts: [usize; 2],
    points: Vec<DVec4>,
    lower_bound: f64,
}

impl PatchPart {
    fn center(&self) -> [f64; 2] {
        self.range.map(|[a, b]| 0.5 * (a + b))
    }

    /// A lower bound on the distance from `query`: that of a box around the control points, or of the plane in front of all
    /// of them at right angles to the direction to `towards`, whichever is greater.
    fn bound(&self, query: DVec3, towards: DVec3) -> f64 {
        let points = || self.points.iter().map(|p| project(*p) - query);
        let bounds = Bounds3::from_points(points());
        let outside = bounds.min.max(-bounds.max).max(DVec3::ZERO).length();
        let direction = (towards - query).normalize_or_zero();
        points().map(|p| p.dot(direction)).fold(f64::INFINITY, f64::min).max(outside)
    }

    /// Both halves, cut across the direction in which the control polygons are longer.
    fn halves(&self) -> [Self; 2] {
        let [rows, columns] = self.counts;
        let length = |a: usize, b: usize| project(self.points[a]).distance(project(self.points[b]));
        let along_u: f64 = (0..columns)
            .map(|j| (1..rows).map(|i| length((i - 1) * columns + j, i * columns + j)).sum())
            .fold(0.0, f64::max);
        let along_v: f64 = (0..rows)
            .map(|i| (1..columns).map(|j| length(i * columns + j - 1, i * columns + j)).sum())
            .fold(0.0, f64::max);
        let cut_u = along_u >= along_v;
        let (steps, stride) = if cut_u { (rows, columns) } else { (columns, 1) };
        let starts: Vec<usize> =
            if cut_u { (0..columns).collect() } else { (0..rows).map(|i| i * columns).collect() };
        let (mut low, mut high) = (self.points.clone(), self.points.clone());
        for start in starts {
            // De Casteljau at 1/2: the first points of all levels are the lower half, the last ones the upper half.
            let at = |i: usize| start + i * stride;
            for level in 1..steps {
                low[at(level - 1)] = high[at(0)];
                for i in 0..steps - level {
                    high[at(i)] = mix(high[at(i)], high[at(i + 1)], 0.5);
                }
            }
            low[at(steps - 1)] = high[at(0)];
        }
        let axis = usize::from(!cut_u);
        let middle = self.center()[axis];
        [(low, 1), (high, 0)].map(|(points, end)| {
            let mut range = self.range;
            range[axis][end] = middle;
            Self { piece: self.piece, range, counts: self.counts, points, lower_bound: self.lower_bound }
        })
    }
}

impl NurbsSurface {
    /// The point nearest to `query`, up to a difference in distance of `tolerance` (metres).
    ///
    /// Parts of the surface are halved; those whose control points prove that they are too far away are dropped, the others
    /// are searched by Newton's method. Where very many points are equally near, the search ends early, and
    /// `distance - lower_bound` is greater than `tolerance`.
    ///
    /// # Errors
    /// [`SurfaceError::NotFinite`], [`SurfaceError::NotPositive`] for the tolerance.
    ///
    /// # Source
    /// Newton's equations: @piegl1997 section 6.1; departure: halving with bounds, which makes the minimum global.
    pub fn closest_point(&self, query: DVec3, tolerance: f64) -> Result<ClosestPoint, SurfaceError> {
        for value in query.to_array() {
            finite("query", value)?;
        }
        positive("tolerance of the distance", tolerance)?;
        let mut open: Vec<PatchPart> = Vec::new();
        let mut best: Option<([f64; 2], DVec3, f64)> = None;
        let mut add = |mut part: PatchPart, open: &mut Vec<PatchPart>| {
            let found = self.improve(query, part.center(), part.piece);
            if best.is_none_or(|(_, _, distance)| found.2 < distance) {
                best = Some(found);
            }
            let [u, v] = part.center();
            part.lower_bound = part.bound(query, self.point(u, v)).max(part.lower_bound);
            open.push(part);
            best.map_or(f64::INFINITY, |b| b.2)
        };
        let mut least = f64::INFINITY;
        for piece in self.bezier_patches()? {
            let (range, (p, q)) = ([piece.u, piece.v], piece.patch.degrees());
            let points = piece.patch.control_points().to_vec();
            let part = PatchPart { piece: range, range, counts: [p + 1, q + 1], points, lower_bound: 0.0 };
            least = add(part, &mut open);
        }
        let mut lower_bound = least;
        for _ in 0..MAX_HALVINGS {
            open.retain(|part| part.lower_bound < least - tolerance);
            let nearest =
                (0..open.len()).min_by(|a, b| open[*a].lower_bound.total_cmp(&open[*b].lower_bound));
            let Some(nearest) = nearest else { break };
            for half in open.swap_remove(nearest).halves() {
                least = add(half, &mut open);
            }
        }
        if let Some(bound) = open.iter().map(|part| part.lower_bound).min_by(f64::total_cmp) {
            lower_bound = lower_bound.min(bound);
        }
        lower_bound = lower_bound.min(least - tolerance).max(0.0);
        let ([u, v], point, distance) = best.unwrap_or(([f64::NAN; 2], DVec3::NAN, f64::INFINITY));
        Ok(ClosestPoint { u, v, point, distance, lower_bound })
    }

    /// A local minimum of the distance from `query` (metres), from the parameters `start` within `ranges` of u and v. Its lower bound is
    /// 0: other points may be nearer.
    #[must_use]
    pub fn closest_point_from(&self, query: DVec3, start: [f64; 2], ranges: [[f64; 2]; 2]) -> ClosestPoint {
        let ([u, v], point, distance) = self.improve(query, start, ranges);
        ClosestPoint { u, v, point, distance, lower_bound: 0.0 }
    }

    /// A local minimum of the distance within `ranges`, by Newton's method; each step is halved until the distance
    /// decreases, if rounding lets it.
    fn improve(&self, query: DVec3, start: [f64; 2], ranges: [[f64; 2]; 2]) -> ([f64; 2], DVec3, f64) {
        let [mut u, mut v] = start;
        let mut here = self.derivatives(u, v, 2);
        let mut point = here.at(0, 0);
        for _ in 0..MAX_NEWTON_STEPS {
            let Some(NewtonStep { du, dv, decrease }) = newton_step(&here, query, [u, v], ranges) else {
                break;
            };
            let distance2 = (point - query).length_squared();
            let at = |x: f64, d: f64, [a, b]: [f64; 2]| (x + d).clamp(a, b);
            let moved = |scale: f64| (at(u, du * scale, ranges[0]), at(v, dv * scale, ranges[1]));
            let limit = UNIT_ROUNDOFF * (u.abs() + v.abs());
            let rounding = ROUNDING * distance2.sqrt() * (distance2.sqrt() + query.abs().max_element());
            if du.abs().max(dv.abs()) <= limit || decrease <= rounding {
                // The last step: distances cannot tell whether it helps.
                let next = moved(1.0);
                let end = self.point(next.0, next.1);
                if (end - query).length_squared() <= distance2 + rounding {
                    ((u, v), point) = (next, end);
                }
                break;
            }
            let shorter = (0..MAX_NEWTON_STEPS)
                .map(|halvings| {
                    let (u, v) = moved(0.5_f64.powi(halvings as i32));
                    ((u, v), self.derivatives(u, v, 2))
                })
                .find(|(_, there)| (there.at(0, 0) - query).length_squared() < distance2);
            let Some(next) = shorter else { break };
            ((u, v), here) = next;
            point = here.at(0, 0);
        }
        ([u, v], point, point.distance(query))
    }
}

/// Newton's step for `|S - q|^2` from the derivatives up to second order, or the Gauss-Newton step where the Hessian is not positive definite or
/// nearly singular. A parameter that would leave its range stays at its end. `None` at a stationary point.
fn newton_step(d: &Derivatives, query: DVec3, [u, v]: [f64; 2], ranges: [[f64; 2]; 2]) -> Option<NewtonStep> {
    let (r, du, dv) = (d.at(0, 0) - query, d.at(1, 0), d.at(0, 1));
    let (gu, gv) = (r.dot(du), r.dot(dv));
    let held = |x: f64, g: f64, [a, b]: [f64; 2]| (x <= a && g > 0.0) || (x >= b && g < 0.0);
    let (held_u, held_v) = (held(u, gu, ranges[0]), held(v, gv, ranges[1]));
    let (e, f, g) = (du.dot(du), du.dot(dv), dv.dot(dv));
    let (a, b, c) = (e + r.dot(d.at(2, 0)), f + r.dot(d.at(1, 1)), g + r.dot(d.at(0, 2)));
    let one_parameter = |gradient: f64, newton: f64, gauss: f64| {
        let curvature = if newton > SINGULAR * gauss { newton } else { gauss };
        (gradient != 0.0 && curvature > 0.0).then(|| -gradient / curvature)
    };
    let step = |du: f64, dv: f64| NewtonStep { du, dv, decrease: -(gu * du + gv * dv) };
    let along_u = |curvature: f64| one_parameter(gu, curvature, e).map(|s| step(s, 0.0));
    let along_v = |curvature: f64| one_parameter(gv, curvature, g).map(|s| step(0.0, s));
    match (held_u, held_v) {
        (true, true) => None,
        (true, false) => along_v(c),
        (false, true) => along_u(a),
        (false, false) => {
            // Of the two curvatures relative to those without second derivatives, product over sum is at most the smaller one.
            let smaller = SINGULAR * (a * g + c * e - 2.0 * b * f);
            let newton = a > 0.0 && a * c - b * b > smaller.max(0.0);
            let (a, b, c) = if newton { (a, b, c) } else { (e, f, g) };
            let determinant = a * c - b * b;
            if determinant > 0.0 && (gu != 0.0 || gv != 0.0) {
                return Some(step((b * gv - c * gu) / determinant, (b * gu - a * gv) / determinant));
            }
            // At a pole one of the derivatives vanishes.
            along_u(a).or_else(|| along_v(c))
        }
    }
}
