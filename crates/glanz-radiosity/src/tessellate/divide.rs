//! How finely a surface is divided.

use glanz_geometry::FaceDomain;
use glanz_math::{DVec2, DVec3};
use glanz_scene::PlacedSurface;

/// Divisions along a parameter at most.
const MOST: u32 = 1024;

/// Divisions of trimmed faces at least: what is smaller than a cell may be missed.
const TRIMMED: u32 = 32;

/// Lines of parameters that are looked at.
const LINES: [f64; 7] = [0.0, 0.1, 0.3, 0.5, 0.7, 0.9, 1.0];

/// Divisions along both parameters of all faces of a surface with which triangles are within `tolerance`, metres; 1024 at most.
///
/// Half of the tolerance is for the lines of the grid, which are looked at in several places; the other half for the middles of its
/// cells.
#[must_use]
pub fn divisions(surface: &PlacedSurface<'_>, tolerance: f64) -> [u32; 2] {
    let mut found = if surface.is_trimmed() { [TRIMMED; 2] } else { [1; 2] };
    for face in 0..surface.faces() {
        if surface.face_domain(face) != FaceDomain::Square {
            continue;
        }
        let at = |u: f64, v: f64| surface.at(face, DVec2::new(u, v), false).map(|at| at.at.point.position);
        for line in LINES {
            found[0] = straight(found[0], 0.5 * tolerance, |x| at(x, line));
            found[1] = straight(found[1], 0.5 * tolerance, |x| at(line, x));
        }
        while found[0].max(found[1]) < MOST && bulge(found, &at) > tolerance {
            found = found.map(|n| 2 * n);
        }
    }
    found
}

/// The smallest of `count` times a power of two with which chords are within `tolerance` of a line.
fn straight(mut count: u32, tolerance: f64, at: impl Fn(f64) -> Option<DVec3>) -> u32 {
    let off = |count: u32, i: u32| {
        let place = |share: f64| at((f64::from(i) + share) / f64::from(count));
        let (Some(a), Some(b)) = (place(0.0), place(1.0)) else { return 0.0 };
        let distance = |p: DVec3| to_segment(p, a, b);
        [0.25, 0.5, 0.75].into_iter().filter_map(place).map(distance).fold(0.0, f64::max)
    };
    while count < MOST && (0..count).any(|i| off(count, i) > tolerance) {
        count *= 2;
    }
    count
}

/// Largest distance of the middle of a cell from its two triangles, over some of the cells.
fn bulge([columns, rows]: [u32; 2], at: &impl Fn(f64, f64) -> Option<DVec3>) -> f64 {
    let steps = [columns, rows].map(|n| (n / 16).max(1));
    let mut most = 0.0_f64;
    for i in (0..columns).step_by(steps[0] as usize) {
        for j in (0..rows).step_by(steps[1] as usize) {
            let place = |x: f64, y: f64| {
                at((f64::from(i) + x) / f64::from(columns), (f64::from(j) + y) / f64::from(rows))
            };
            let corners = [place(0.0, 0.0), place(1.0, 0.0), place(1.0, 1.0), place(0.0, 1.0)];
            if let ([Some(a), Some(b), Some(c), Some(d)], Some(middle)) = (corners, place(0.5, 0.5)) {
                // As cells are cut: from b to d.
                most = most.max(above(middle, [d, a, b]).min(above(middle, [b, c, d])));
            }
        }
    }
    most
}

/// Distance of a point from a triangle it lies above, or else from the triangle's third side.
///
/// Parameters need not run evenly: where the middle lies along the surface does not count.
fn above(point: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let normal = (b - a).cross(c - a);
    let inside =
        [[a, b], [b, c], [c, a]].into_iter().all(|[p, q]| (q - p).cross(point - p).dot(normal) >= 0.0);
    match normal.try_normalize().filter(|_| inside) {
        Some(normal) => normal.dot(point - a).abs(),
        None => to_segment(point, c, a),
    }
}

fn to_segment(point: DVec3, a: DVec3, b: DVec3) -> f64 {
    let way = b - a;
    let share = ((point - a).dot(way) / way.length_squared()).clamp(0.0, 1.0);
    point.distance(if share.is_finite() { a + share * way } else { a })
}
