//! Splines against reference values, closed forms and identities.

mod curve;
mod edit;
mod jump;
mod reference;
mod shapes;

use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2, PI};

use glanz_math::DVec3;
use glanz_math::glam::DVec4;

use super::*;
use crate::SurfaceError;

/// Knots of the surface with published values, degrees 3 and 2.
const KNOTS_U: [f64; 10] = [0.0, 0.0, 0.0, 0.0, 0.4, 0.7, 1.0, 1.0, 1.0, 1.0];
const KNOTS_V: [f64; 8] = [0.0, 0.0, 0.0, 0.35, 0.6, 1.0, 1.0, 1.0];
/// z of the control points (i, j, z), i = 0 to 5, j = 0 to 4.
const HEIGHTS: [[f64; 5]; 6] = [
    [0.0, 0.0, 0.0, 0.0, 0.0],
    [0.783_327, 0.599_121, 0.13314, -0.39546, -0.738_068],
    [0.973_848, 0.74484, 0.165_522, -0.491_643, -0.917_581],
    [0.42738, 0.326_878, 0.072_641, -0.215_761, -0.402_687],
    [-0.44252, -0.338_458, -0.075_214, 0.223_405, 0.416_953],
    [-0.97753, -0.747_656, -0.166_148, 0.493_502, 0.921_051],
];
const WEIGHTS: [[f64; 5]; 6] = [
    [1.0, 1.166_667, 1.333_333, 1.5, 1.0],
    [1.5, 1.0, 1.166_667, 1.333_333, 1.5],
    [1.333_333, 1.5, 1.0, 1.166_667, 1.333_333],
    [1.166_667, 1.333_333, 1.5, 1.0, 1.166_667],
    [1.0, 1.166_667, 1.333_333, 1.5, 1.0],
    [1.5, 1.0, 1.166_667, 1.333_333, 1.5],
];

fn reference() -> NurbsSurface {
    let at = |i: usize, j: usize| DVec3::new(i as f64, j as f64, HEIGHTS[i][j]);
    let points: Vec<DVec3> = (0..6).flat_map(|i| (0..5).map(move |j| at(i, j))).collect();
    let weights = Some(WEIGHTS.as_flattened());
    NurbsSurface::try_from_points([3, 2], [KNOTS_U.to_vec(), KNOTS_V.to_vec()], &points, weights).unwrap()
}

/// A rational surface with unclamped knots, some of them double.
fn open() -> NurbsSurface {
    let knots_u = vec![-1.3, -0.5, -0.2, 0.0, 0.4, 0.4, 1.0, 1.7, 2.0, 2.2, 3.1];
    let knots_v = vec![0.0, 1.0, 1.5, 2.0, 2.0, 3.0, 3.5, 4.0];
    let point = |i: usize, j: usize| {
        let (x, y) = (i as f64, j as f64);
        let w = 1.0 + 0.5 * (1.7 * x + 2.3 * y).sin();
        DVec4::new(x, y, (x * y * 0.3).cos(), 1.0) * w
    };
    let points = (0..7).flat_map(|i| (0..5).map(move |j| point(i, j))).collect();
    NurbsSurface::try_new([3, 2], [knots_u, knots_v], points).unwrap()
}

/// An eighth of the unit sphere as a rational biquadratic: v climbs from the equator to the pole.
fn octant() -> NurbsSurface {
    let arc = [(1.0, 0.0, 1.0), (1.0, 1.0, FRAC_1_SQRT_2), (0.0, 1.0, 1.0)];
    let knots = || vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0];
    let points = arc.iter().flat_map(|&(x, y, wu)| {
        arc.iter().map(move |&(r, z, wv)| DVec3::new(r * x, r * y, z).extend(1.0) * (wu * wv))
    });
    NurbsSurface::try_new([2, 2], [knots(), knots()], points.collect()).unwrap()
}

/// Parameters over the closed domain, knots included.
fn grid(knots: &KnotVector) -> Vec<f64> {
    let [a, b] = knots.domain();
    (0..=16).map(|i| a + (b - a) * f64::from(i) / 16.0).chain(knots.breaks()).collect()
}

/// The largest distance between the points of `part` and of `whole` at the parameters of `part`.
fn distance(part: &NurbsSurface, whole: &NurbsSurface) -> f64 {
    let mut largest: f64 = 0.0;
    for u in grid(part.knots_u()) {
        for v in grid(part.knots_v()) {
            largest = largest.max(part.point(u, v).distance(whole.point(u, v)));
        }
    }
    largest
}
