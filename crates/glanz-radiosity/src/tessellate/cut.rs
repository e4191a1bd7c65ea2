//! Clipping of grid cells at trimming curves.

use glanz_math::{DVec2, DVec3};

/// Bisections that locate a curve between two points.
const BISECTIONS: u32 = 48;

/// Largest number of divisions of a chord of a curve, down to 2^-10 of it.
const MAX_DEPTH: u32 = 10;

/// Steps of the search for a curve across a chord.
const SEARCH_STEPS: u32 = 8;

/// Polygons that trimming leaves of a cell, counterclockwise as the cell.
///
/// `kept`: whether each corner is kept; a curve crosses the side between two corners at most once. Vertices of the polygons are
/// points that are kept.
pub(super) fn clip_cell(
    corners: [DVec2; 4],
    kept: [bool; 4],
    is_kept: &impl Fn(DVec2) -> bool,
    position: &impl Fn(DVec2) -> Option<DVec3>,
    tolerance: f64,
) -> Vec<Vec<DVec2>> {
    if kept == [true; 4] {
        return vec![corners.to_vec()];
    }
    let mut polygons = Vec::new();
    // Sequences of kept corners, each with the points where a curve crosses the sides before and after it.
    for start in (0..4).filter(|&i| kept[i] && !kept[(i + 3) % 4]) {
        let entry = crossing(corners[start], corners[(start + 3) % 4], is_kept);
        let mut polygon = vec![entry];
        let mut i = start;
        while kept[i] {
            polygon.push(corners[i]);
            i = (i + 1) % 4;
        }
        let exit = crossing(corners[(i + 3) % 4], corners[i], is_kept);
        polygon.push(exit);
        add_curve_points(exit, entry, is_kept, position, tolerance, MAX_DEPTH, &mut polygon);
        polygon.dedup();
        if polygon.len() > 2 {
            polygons.push(polygon);
        }
    }
    polygons
}

/// The last kept point between a kept point and one that is not kept, by bisection.
fn crossing(mut inside: DVec2, mut outside: DVec2, is_kept: &impl Fn(DVec2) -> bool) -> DVec2 {
    for _ in 0..BISECTIONS {
        let middle = inside.midpoint(outside);
        if is_kept(middle) { inside = middle } else { outside = middle }
    }
    inside
}

/// Adds points of the curve between two of its points, so that chords are within `tolerance`, metres.
fn add_curve_points(
    a: DVec2,
    b: DVec2,
    is_kept: &impl Fn(DVec2) -> bool,
    position: &impl Fn(DVec2) -> Option<DVec3>,
    tolerance: f64,
    depth: u32,
    polygon: &mut Vec<DVec2>,
) {
    let Some(found) = curve_point_across(a, b, is_kept).filter(|_| depth > 0) else { return };
    let (Some(from), Some(to), Some(there)) = (position(a), position(b), position(found)) else { return };
    let chord = to - from;
    let share = ((there - from).dot(chord) / chord.length_squared()).clamp(0.0, 1.0);
    let near = if share.is_finite() { from + share * chord } else { from };
    // The quarters may be off the chord even if the middle is on it.
    let is_near = there.distance(near) <= tolerance;
    let quarter = |p: DVec2, q: DVec2| {
        let far = curve_point_across(p, q, is_kept).and_then(position);
        far.is_none_or(|far| {
            let share = ((far - from).dot(chord) / chord.length_squared()).clamp(0.0, 1.0);
            far.distance(if share.is_finite() { from + share * chord } else { from }) <= tolerance
        })
    };
    if is_near && quarter(a, found) && quarter(found, b) {
        return;
    }
    add_curve_points(a, found, is_kept, position, tolerance, depth - 1, polygon);
    polygon.push(found);
    add_curve_points(found, b, is_kept, position, tolerance, depth - 1, polygon);
}

/// The point of the curve across the middle of a chord; `None` if there is none nearby.
fn curve_point_across(a: DVec2, b: DVec2, is_kept: &impl Fn(DVec2) -> bool) -> Option<DVec2> {
    let (middle, across) = (a.midpoint(b), (b - a).perp());
    let here = is_kept(middle);
    let at = |step: u32, side: f64| middle + side * f64::from(step) / f64::from(SEARCH_STEPS) * across;
    for step in 1..=SEARCH_STEPS {
        for side in [-1.0, 1.0] {
            let there = at(step, side);
            if is_kept(there) != here {
                let before = at(step - 1, side);
                let (inside, outside) = if here { (before, there) } else { (there, before) };
                return Some(crossing(inside, outside, is_kept));
            }
        }
    }
    None
}

/// Triangulates a polygon by ear clipping.
pub(super) fn triangles(polygon: &[DVec2]) -> Vec<[usize; 3]> {
    let mut left: Vec<usize> = (0..polygon.len()).collect();
    let mut triangles = Vec::new();
    let turn = |a: usize, b: usize, c: usize| (polygon[b] - polygon[a]).perp_dot(polygon[c] - polygon[a]);
    while left.len() > 3 {
        let n = left.len();
        let corners = |i: usize| (left[(i + n - 1) % n], left[i], left[(i + 1) % n]);
        let is_ear = |&i: &usize| {
            let (a, b, c) = corners(i);
            let inside = |&p: &usize| turn(a, b, p) > 0.0 && turn(b, c, p) > 0.0 && turn(c, a, p) > 0.0;
            turn(a, b, c) > 0.0 && !left.iter().any(|p| ![a, b, c].contains(p) && inside(p))
        };
        // There is no ear only if all points are collinear; then any order is valid.
        let ear = (0..n).find(is_ear).unwrap_or(1);
        let (a, b, c) = corners(ear);
        triangles.push([a, b, c]);
        left.remove(ear);
    }
    if let [a, b, c] = left[..] {
        triangles.push([a, b, c]);
    }
    triangles
}
