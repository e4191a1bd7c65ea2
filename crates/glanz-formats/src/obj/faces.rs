//! Triangles of polygons.

use glanz_math::{DVec2, DVec3};

/// Largest number of corners of a polygon that may be concave: the time grows with their square, at worst with their cube.
pub(super) const MAX_CONCAVE: usize = 1024;

/// Twice the signed area of a triangle.
fn area(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

/// The corners of a polygon in a plane in which it is counterclockwise.
fn projected(corners: &[DVec3]) -> Vec<DVec2> {
    let next = corners.iter().cycle().skip(1);
    // Newell's normal: the sum of the areas over the axes.
    let normal: DVec3 = corners.iter().zip(next).map(|(a, b)| a.cross(*b - *a)).sum();
    let (x, y, direction) = match normal.abs() {
        size if size.z >= size.max_element() => (0, 1, normal.z),
        size if size.x >= size.max_element() => (1, 2, normal.x),
        _ => (2, 0, normal.y),
    };
    let sign = if direction < 0.0 { -1.0 } else { 1.0 };
    corners.iter().map(|p| DVec2::new(p[x], sign * p[y])).collect()
}

/// Triangles, as positions in the list of `corners`, that fill a polygon without crossings; it may be concave up to
/// [`MAX_CONCAVE`] corners. Others, and what is left of one that crosses itself, are fans.
pub(super) fn triangles(corners: &[DVec3]) -> Vec<[usize; 3]> {
    let count = corners.len();
    let mut triangles = Vec::with_capacity(count.saturating_sub(2));
    let mut left: Vec<usize> = (0..count).collect();
    if count > 3 && count <= MAX_CONCAVE {
        let points = projected(corners);
        // What an ear leaves behind is often the next one: a search from the start would test the same corners again.
        let mut from = 0;
        while left.len() > 3 {
            let mut candidates = (from..left.len()).chain(0..from);
            let Some(ear) = candidates.find(|&i| is_ear(&points, &left, i)) else { break };
            let [before, after] = [left.len() - 1, 1].map(|step| left[(ear + step) % left.len()]);
            triangles.push([before, left[ear], after]);
            left.remove(ear);
            from = ear.saturating_sub(1);
        }
    }
    if let [first, rest @ ..] = left.as_slice() {
        triangles.extend(rest.windows(2).map(|pair| [*first, pair[0], pair[1]]));
    }
    triangles
}

/// Whether a corner is convex, and no other corner lies in its triangle.
fn is_ear(points: &[DVec2], left: &[usize], i: usize) -> bool {
    let [a, b, c] = [left.len() - 1, 0, 1].map(|step| points[left[(i + step) % left.len()]]);
    if area(a, b, c) <= 0.0 {
        return false;
    }
    let inside = |p: DVec2| area(a, b, p) >= 0.0 && area(b, c, p) >= 0.0 && area(c, a, p) >= 0.0;
    // Corners in the same place as one of the triangle are where a bridge to a hole begins and ends.
    left.iter().map(|&k| points[k]).all(|p| p == a || p == b || p == c || !inside(p))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn total(points: &[DVec3], triangles: &[[usize; 3]]) -> (DVec3, f64) {
        triangles.iter().fold((DVec3::ZERO, 0.0), |(sum, absolute), t| {
            let [a, b, c] = t.map(|i| points[i]);
            let area = 0.5 * (b - a).cross(c - a);
            (sum + area, absolute + area.length())
        })
    }

    #[test]
    fn a_concave_polygon_is_filled_without_overlap_in_every_plane() {
        // An arrow head of area 3 * 2 / 2 - 3 * 1 / 2, and a comb of 5 teeth.
        let arrow =
            vec![DVec2::new(0.0, 0.0), DVec2::new(1.5, 1.0), DVec2::new(3.0, 0.0), DVec2::new(1.5, 2.0)];
        let mut comb = vec![DVec2::new(5.0, 1.0), DVec2::new(0.0, 1.0)];
        for tooth in 0..5 {
            let x = f64::from(tooth);
            comb.extend([
                DVec2::new(x, 0.0),
                DVec2::new(x + 0.5, 0.0),
                DVec2::new(x + 0.5, 0.5),
                DVec2::new(x + 1.0, 0.5),
            ]);
        }
        for (flat, expected) in [(arrow, 1.5), (comb, 5.0 * 0.75)] {
            for turn in 0..6 {
                let place = |p: &DVec2| match turn % 3 {
                    0 => DVec3::new(p.x, p.y, 0.3 * p.x),
                    1 => DVec3::new(0.2 * p.y, p.x, p.y),
                    _ => DVec3::new(p.y, -0.1 * p.x, p.x),
                };
                let mut points: Vec<DVec3> = flat.iter().map(place).collect();
                if turn >= 3 {
                    points.reverse();
                }
                let triangles = triangles(&points);
                assert_eq!(triangles.len(), points.len() - 2);
                let (sum, absolute) = total(&points, &triangles);
                // The planes are as steep as that: lengths across stay.
                let steepness = [1.0 + 0.09, 1.0 + 0.04, 1.0 + 0.01][turn % 3];
                assert!((sum.length() - absolute).abs() < 1e-12, "{turn}: no triangle lies on another");
                assert!((absolute - expected * f64::sqrt(steepness)).abs() < 1e-12, "{turn}: {absolute}");
            }
        }
    }

    #[test]
    fn any_corners_give_as_many_triangles() {
        let line: Vec<DVec3> = (0..10).map(|i| DVec3::X * f64::from(i)).collect();
        assert_eq!(triangles(&line).len(), 8);
        let bow = [DVec3::ZERO, DVec3::ONE, DVec3::X, DVec3::Y];
        assert_eq!(triangles(&bow).len(), 2);
        assert_eq!(triangles(&[DVec3::ZERO; MAX_CONCAVE + 1]).len(), MAX_CONCAVE - 1);
        assert!(triangles(&line[..2]).is_empty());
    }
}
