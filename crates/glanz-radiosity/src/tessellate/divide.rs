//! Number of divisions of a surface for a tolerance.

use glanz_geometry::FaceDomain;
use glanz_math::{DVec2, DVec3};
use glanz_scene::PlacedSurface;

/// Largest number of divisions along a parameter.
const MAX_DIVISIONS: u32 = 1024;

/// Smallest number of divisions of trimmed faces, since features smaller than a cell may be missed.
const MIN_TRIMMED: u32 = 32;

/// Parameters of the lines at which the distance is evaluated.
const LINES: [f64; 7] = [0.0, 0.1, 0.3, 0.5, 0.7, 0.9, 1.0];

/// Divisions along both parameters of all faces of a surface for which triangles are within `tolerance`, metres, of it; at most 1024.
///
/// Lines of the grid, sampled at several parameters, use half of the tolerance; the middles of its cells the other half.
#[must_use]
pub fn divisions(surface: &PlacedSurface<'_>, tolerance: f64) -> [u32; 2] {
    let mut found = if surface.is_trimmed() { [MIN_TRIMMED; 2] } else { [1; 2] };
    for face in 0..surface.faces() {
        if surface.face_domain(face) != FaceDomain::Square {
            continue;
        }
        let at = |u: f64, v: f64| surface.at(face, DVec2::new(u, v), false).map(|at| at.at.point.position);
        for line in LINES {
            found[0] = divisions_of_line(found[0], 0.5 * tolerance, |x| at(x, line));
            found[1] = divisions_of_line(found[1], 0.5 * tolerance, |x| at(line, x));
        }
        while found[0].max(found[1]) < MAX_DIVISIONS && largest_cell_distance(found, &at) > tolerance {
            found = found.map(|n| 2 * n);
        }
    }
    found
}

/// The smallest product of `count` and a power of two for which chords are within `tolerance` of a line.
fn divisions_of_line(mut count: u32, tolerance: f64, at: impl Fn(f64) -> Option<DVec3>) -> u32 {
    let off = |count: u32, i: u32| {
        let place = |share: f64| at((f64::from(i) + share) / f64::from(count));
        let (Some(a), Some(b)) = (place(0.0), place(1.0)) else { return 0.0 };
        let distance = |p: DVec3| distance_to_segment(p, a, b);
        [0.25, 0.5, 0.75].into_iter().filter_map(place).map(distance).fold(0.0, f64::max)
    };
    while count < MAX_DIVISIONS && (0..count).any(|i| off(count, i) > tolerance) {
        count *= 2;
    }
    count
}

/// Largest distance of the middle of a cell from its two triangles, over some of the cells.
fn largest_cell_distance([columns, rows]: [u32; 2], at: &impl Fn(f64, f64) -> Option<DVec3>) -> f64 {
    let steps = [columns, rows].map(|n| (n / 16).max(1));
    let mut most = 0.0_f64;
    for i in (0..columns).step_by(steps[0] as usize) {
        for j in (0..rows).step_by(steps[1] as usize) {
            let place = |x: f64, y: f64| {
                at((f64::from(i) + x) / f64::from(columns), (f64::from(j) + y) / f64::from(rows))
            };
            let corners = [place(0.0, 0.0), place(1.0, 0.0), place(1.0, 1.0), place(0.0, 1.0)];
            if let ([Some(a), Some(b), Some(c), Some(d)], Some(middle)) = (corners, place(0.5, 0.5)) {
                // Cells are divided from b to d.
                most = most.max(
                    distance_to_triangle(middle, [d, a, b]).min(distance_to_triangle(middle, [b, c, d])),
                );
            }
        }
    }
    most
}

/// Distance of a point from a triangle that it lies above, or else from the triangle's third side.
///
/// The distance from the corresponding point of the triangle would depend on the parameterization.
fn distance_to_triangle(point: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let normal = (b - a).cross(c - a);
    let inside =
        [[a, b], [b, c], [c, a]].into_iter().all(|[p, q]| (q - p).cross(point - p).dot(normal) >= 0.0);
    match normal.try_normalize().filter(|_| inside) {
        Some(normal) => normal.dot(point - a).abs(),
        None => distance_to_segment(point, c, a),
    }
}

fn distance_to_segment(point: DVec3, a: DVec3, b: DVec3) -> f64 {
    let chord = b - a;
    let share = ((point - a).dot(chord) / chord.length_squared()).clamp(0.0, 1.0);
    point.distance(if share.is_finite() { a + share * chord } else { a })
}
