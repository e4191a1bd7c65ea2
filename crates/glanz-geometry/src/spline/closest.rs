//! The point of a spline surface that is nearest to a given one.

use glanz_math::glam::DVec4;
use glanz_math::rounding::UNIT_ROUNDOFF;
use glanz_math::{Bounds3, DVec3};

use super::homogeneous::project;
use super::polygon::mix;
use super::surface::NurbsSurface;
use crate::error::{SurfaceError, finite, positive};

/// The nearest point of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClosestPoint {
    /// Its parameters.
    pub u: f64,
    /// Its parameters.
    pub v: f64,
    /// Its position, metres.
    pub point: DVec3,
    /// Its distance, metres.
    pub distance: f64,
    /// No point of the surface is nearer than that, metres (but for rounding).
    pub at_least: f64,
}

/// After that many parts the search ends with the bound reached. Where many points are equally near, as from the
/// middle of a sphere, no bound can part them.
const MAX_PARTS: usize = 4096;

/// Newton steps; from a good start, four are enough.
const MAX_STEPS: usize = 32;

/// A part of a Bézier piece.
struct Part {
    /// The piece's ranges, in which the parameters may be improved.
    piece: [[f64; 2]; 2],
    range: [[f64; 2]; 2],
    counts: [usize; 2],
    points: Vec<DVec4>,
    at_least: f64,
}

impl Part {
    fn center(&self) -> [f64; 2] {
        self.range.map(|[a, b]| 0.5 * (a + b))
    }

    /// A bound on the distance from `query`: that of a box around the control points, or of the plane in front of
    /// them as seen towards `towards`.
    fn bound(&self, query: DVec3, towards: DVec3) -> f64 {
        let points = || self.points.iter().map(|p| project(*p) - query);
        let bounds = Bounds3::of_points(points());
        let outside = bounds.min.max(-bounds.max).max(DVec3::ZERO).length();
        let direction = (towards - query).normalize_or_zero();
        points().map(|p| p.dot(direction)).fold(f64::INFINITY, f64::min).max(outside)
    }

    /// Both halves, cut across the direction in which the control points go further.
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
            // De Casteljau at 1/2: the first points of the levels are one half, the last ones the other.
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
            Self { piece: self.piece, range, counts: self.counts, points, at_least: self.at_least }
        })
    }
}

impl NurbsSurface {
    /// The point nearest to `query`, up to a difference in distance of `tolerance` (metres).
    ///
    /// Parts of the surface are halved, those of which the control points show that they are too far away left out, the
    /// others searched by Newton's method. Where very many points are equally near, the search ends early:
    /// `distance - at_least` says what is open.
    ///
    /// # Errors
    /// A query that is not finite, a tolerance that is not positive.
    ///
    /// # Source
    /// Newton's equations: @piegl1997 section 6.1; departure: the bounds.
    pub fn closest_point(&self, query: DVec3, tolerance: f64) -> Result<ClosestPoint, SurfaceError> {
        for value in query.to_array() {
            finite("query", value)?;
        }
        positive("tolerance of the distance", tolerance)?;
        let mut open: Vec<Part> = Vec::new();
        let mut best: Option<([f64; 2], DVec3, f64)> = None;
        let mut add = |mut part: Part, open: &mut Vec<Part>| {
            let found = self.improve(query, part.center(), part.piece);
            if best.is_none_or(|(_, _, distance)| found.2 < distance) {
                best = Some(found);
            }
            let [u, v] = part.center();
            part.at_least = part.bound(query, self.point(u, v)).max(part.at_least);
            open.push(part);
            best.map_or(f64::INFINITY, |b| b.2)
        };
        let mut least = f64::INFINITY;
        for piece in self.bezier_patches()? {
            let (range, (p, q)) = ([piece.u, piece.v], piece.patch.degrees());
            let points = piece.patch.control_points().to_vec();
            let part = Part { piece: range, range, counts: [p + 1, q + 1], points, at_least: 0.0 };
            least = add(part, &mut open);
        }
        let mut at_least = least;
        for _ in 0..MAX_PARTS {
            open.retain(|part| part.at_least < least - tolerance);
            let nearest = (0..open.len()).min_by(|a, b| open[*a].at_least.total_cmp(&open[*b].at_least));
            let Some(nearest) = nearest else { break };
            for half in open.swap_remove(nearest).halves() {
                least = add(half, &mut open);
            }
        }
        if let Some(bound) = open.iter().map(|part| part.at_least).min_by(f64::total_cmp) {
            at_least = at_least.min(bound);
        }
        at_least = at_least.min(least - tolerance).max(0.0);
        let ([u, v], point, distance) = best.unwrap_or(([f64::NAN; 2], DVec3::NAN, f64::INFINITY));
        Ok(ClosestPoint { u, v, point, distance, at_least })
    }

    /// A local minimum of the distance within `ranges`, by Newton's method with steps halved until they improve.
    fn improve(&self, query: DVec3, start: [f64; 2], ranges: [[f64; 2]; 2]) -> ([f64; 2], DVec3, f64) {
        let [mut u, mut v] = start;
        let mut point = self.point(u, v);
        for _ in 0..MAX_STEPS {
            let Some((du, dv)) = self.newton_step(query, [u, v], ranges) else { break };
            let distance2 = (point - query).length_squared();
            let shorter = (0..MAX_STEPS).find_map(|halvings| {
                let scale = 0.5_f64.powi(halvings as i32);
                let at = |x: f64, d: f64, [a, b]: [f64; 2]| (x + d * scale).clamp(a, b);
                let (u, v) = (at(u, du, ranges[0]), at(v, dv, ranges[1]));
                let point = self.point(u, v);
                ((point - query).length_squared() < distance2).then_some((u, v, point))
            });
            let Some(next) = shorter else { break };
            let moved = (next.0 - u).abs().max((next.1 - v).abs());
            (u, v, point) = next;
            if moved <= UNIT_ROUNDOFF * (u.abs() + v.abs()) {
                break;
            }
        }
        ([u, v], point, point.distance(query))
    }

    /// Newton's step for `|S - q|^2`, or Gauss's where the second derivatives do not point to a minimum. A parameter
    /// at the end of its range that would leave it stands still. `None` where nothing is left to improve.
    fn newton_step(&self, query: DVec3, [u, v]: [f64; 2], ranges: [[f64; 2]; 2]) -> Option<(f64, f64)> {
        let d = self.derivatives(u, v, 2);
        let (r, du, dv) = (d.at(0, 0) - query, d.at(1, 0), d.at(0, 1));
        let (gu, gv) = (r.dot(du), r.dot(dv));
        let held = |x: f64, g: f64, [a, b]: [f64; 2]| (x <= a && g > 0.0) || (x >= b && g < 0.0);
        let (held_u, held_v) = (held(u, gu, ranges[0]), held(v, gv, ranges[1]));
        let (e, f, g) = (du.dot(du), du.dot(dv), dv.dot(dv));
        let (a, b, c) = (e + r.dot(d.at(2, 0)), f + r.dot(d.at(1, 1)), g + r.dot(d.at(0, 2)));
        let along = |gradient: f64, newton: f64, gauss: f64| {
            let curvature = if newton > 0.0 { newton } else { gauss };
            (gradient != 0.0 && curvature > 0.0).then(|| -gradient / curvature)
        };
        match (held_u, held_v) {
            (true, true) => None,
            (true, false) => along(gv, c, g).map(|s| (0.0, s)),
            (false, true) => along(gu, a, e).map(|s| (s, 0.0)),
            (false, false) => {
                let newton = a > 0.0 && a * c - b * b > 0.0;
                let (a, b, c) = if newton { (a, b, c) } else { (e, f, g) };
                let determinant = a * c - b * b;
                if determinant > 0.0 && (gu != 0.0 || gv != 0.0) {
                    return Some(((b * gv - c * gu) / determinant, (b * gu - a * gv) / determinant));
                }
                // At a pole one direction says nothing.
                along(gu, a, e).map(|s| (s, 0.0)).or_else(|| along(gv, c, g).map(|s| (0.0, s)))
            }
        }
    }
}
