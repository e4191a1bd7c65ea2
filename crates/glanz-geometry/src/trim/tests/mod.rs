//! Regions against closed forms and against winding numbers of dense polygons.

mod cells;
mod curves;
mod exact;
mod slow_cells;
mod widths;
mod winding;

use std::f64::consts::TAU;

use glanz_math::{DVec2, DVec3};

use super::*;

/// SplitMix64: test cases, not statistics.
struct Random(u64);

impl Random {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// In [0, 1).
    fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 * 2.0_f64.powi(-53)
    }

    fn point(&mut self) -> DVec2 {
        DVec2::new(self.unit(), self.unit())
    }
}

const UNIT: [DVec2; 2] = [DVec2::ZERO, DVec2::ONE];

const CENTER: DVec2 = DVec2::splat(0.5);

fn at(u: f64, v: f64) -> DVec2 {
    DVec2::new(u, v)
}

fn closed(curve: TrimCurve) -> TrimLoop {
    TrimLoop::try_closed(curve, 0.0).unwrap()
}

fn circle(center: DVec2, radius: f64) -> TrimCurve {
    TrimCurve::try_circle(center, radius).unwrap()
}

fn polygon(corners: &[DVec2]) -> TrimLoop {
    closed(TrimCurve::try_polygon(corners).unwrap())
}

fn region(loops: Vec<TrimLoop>) -> TrimRegion {
    TrimRegion::try_new(loops, UNIT).unwrap()
}

/// A slow reference: the winding number of dense polygons, and the distance from them.
struct DensePolygons {
    edges: Vec<(DVec2, DVec2)>,
    /// Bound on the distance between polygons and curves.
    sag: f64,
}

impl DensePolygons {
    /// Polygons of closed curves. For short chords the curve is farthest from the chord at its middle; ten times that distance is
    /// margin enough.
    fn new(curves: &[TrimCurve], steps: u32) -> Self {
        let (mut edges, mut sag) = (Vec::new(), 0.0_f64);
        for curve in curves {
            for piece in 0..curve.piece_count() {
                let point = |i: f64| curve.point(piece, i / f64::from(steps)).unwrap();
                for i in (0..steps).map(f64::from) {
                    let (a, b) = (point(i), point(i + 1.0));
                    sag = sag.max(distance(point(i + 0.5), a, b));
                    edges.push((a, b));
                }
            }
        }
        Self { edges, sag: 10.0 * sag + 1e-12 }
    }

    /// The winding number; `None` too close to a curve.
    fn winding(&self, p: DVec2) -> Option<i32> {
        let mut winding = 0;
        for &(a, b) in &self.edges {
            let reach = self.sag + (b - a).abs().max_element();
            if (a - p).abs().max_element() <= reach && distance(p, a, b) <= self.sag {
                return None;
            }
            if (a.y > p.y) != (b.y > p.y) {
                let right = (b - a).perp_dot(p - a) > 0.0;
                winding +=
                    if b.y > a.y { i32::from(right) } else { -i32::from((a - b).perp_dot(p - b) > 0.0) };
            }
        }
        Some(winding)
    }

    fn distance(&self, p: DVec2) -> f64 {
        self.edges.iter().fold(f64::INFINITY, |d, &(a, b)| d.min(distance(p, a, b)))
    }
}

fn distance(p: DVec2, a: DVec2, b: DVec2) -> f64 {
    let length2 = (b - a).length_squared();
    let share = if length2 > 0.0 { ((p - a).dot(b - a) / length2).clamp(0.0, 1.0) } else { 0.0 };
    p.distance(a.lerp(b, share))
}

/// A random closed NURBS curve, periodic with unclamped uneven knots; `wild` from 0 to 1.
fn blob(random: &mut Random, center: DVec2, size: f64, wild: f64) -> TrimCurve {
    let (degree, count) = (2 + (random.bits() % 4) as usize, 8);
    let ring: Vec<DVec3> = (0..count)
        .map(|i| {
            let angle = TAU * (i as f64 + wild * (random.unit() - 0.5)) / count as f64;
            let radius = size * (1.0 - 0.9 * wild * random.unit());
            let w = 10.0_f64.powf(wild * (random.unit() - 0.5));
            ((center + radius * at(angle.cos(), angle.sin())) * w).extend(w)
        })
        .collect();
    let steps: Vec<f64> = (0..count).map(|_| 0.5 + random.unit()).collect();
    let mut knots = vec![0.0];
    for i in 0..count + 2 * degree {
        knots.push(knots[i] + steps[i % count]);
    }
    let points: Vec<DVec3> = (0..count + degree).map(|i| ring[i % count]).collect();
    TrimCurve::try_nurbs(degree, &knots, &points).unwrap()
}
