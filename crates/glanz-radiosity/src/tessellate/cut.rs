//! Cells of a grid that a trimming curve crosses.

use glanz_math::{DVec2, DVec3};

/// Halvings that find a curve between two points.
const HALVINGS: u32 = 48;

/// How often a chord of a curve is divided at most: parts are 2^-10 of it.
const DEPTH: u32 = 10;

/// Steps in which a curve is looked for across a chord.
const STEPS: u32 = 8;

/// Polygons of a cell that are kept, counterclockwise as the cell.
///
/// `kept`: of the corners; curves are crossed at most once between two of them. Corners in the polygons are points that are kept.
pub(super) fn cut(
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
    // Runs of kept corners, each with the points where the sides to it and from it are crossed.
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
        along(exit, entry, is_kept, position, tolerance, DEPTH, &mut polygon);
        polygon.dedup();
        if polygon.len() > 2 {
            polygons.push(polygon);
        }
    }
    polygons
}

/// The last point that is kept on the way from one that is to one that is not.
fn crossing(mut inside: DVec2, mut outside: DVec2, is_kept: &impl Fn(DVec2) -> bool) -> DVec2 {
    for _ in 0..HALVINGS {
        let middle = inside.midpoint(outside);
        if is_kept(middle) { inside = middle } else { outside = middle }
    }
    inside
}

/// Adds points of the curve between two of its points, so that chords are within `tolerance`.
fn along(
    a: DVec2,
    b: DVec2,
    is_kept: &impl Fn(DVec2) -> bool,
    position: &impl Fn(DVec2) -> Option<DVec3>,
    tolerance: f64,
    depth: u32,
    polygon: &mut Vec<DVec2>,
) {
    let Some(found) = beside(a, b, is_kept).filter(|_| depth > 0) else { return };
    let (Some(from), Some(to), Some(there)) = (position(a), position(b), position(found)) else { return };
    let way = to - from;
    let share = ((there - from).dot(way) / way.length_squared()).clamp(0.0, 1.0);
    let near = if share.is_finite() { from + share * way } else { from };
    // Where the middle is near the chord, the quarters may still not be: one more look.
    let is_near = there.distance(near) <= tolerance;
    let quarter = |p: DVec2, q: DVec2| {
        let far = beside(p, q, is_kept).and_then(position);
        far.is_none_or(|far| {
            let share = ((far - from).dot(way) / way.length_squared()).clamp(0.0, 1.0);
            far.distance(if share.is_finite() { from + share * way } else { from }) <= tolerance
        })
    };
    if is_near && quarter(a, found) && quarter(found, b) {
        return;
    }
    along(a, found, is_kept, position, tolerance, depth - 1, polygon);
    polygon.push(found);
    along(found, b, is_kept, position, tolerance, depth - 1, polygon);
}

/// A point of the curve beside the middle of a chord.
fn beside(a: DVec2, b: DVec2, is_kept: &impl Fn(DVec2) -> bool) -> Option<DVec2> {
    let (middle, across) = (a.midpoint(b), (b - a).perp());
    let here = is_kept(middle);
    let at = |step: u32, side: f64| middle + side * f64::from(step) / f64::from(STEPS) * across;
    for step in 1..=STEPS {
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

/// A polygon in triangles, by cutting off ears.
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
        // None is left if points lie on a line: then any order does.
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
