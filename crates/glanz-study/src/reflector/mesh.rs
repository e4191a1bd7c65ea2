//! Tessellation of a triangular patch.

use glanz_geometry::bezier::TrianglePatch;
use glanz_math::DVec3;
use glanz_scene::description::GeometryDescription;

/// n^2 triangles with corners on the patch at equal parameters; `smooth`: with the normals of the patch there.
pub(super) fn triangles(patch: &TrianglePatch, n: u32, smooth: bool) -> GeometryDescription {
    let (mut positions, mut normals) = (Vec::new(), Vec::new());
    for (i, j) in (0..=n).flat_map(|i| (0..=n - i).map(move |j| (i, j))) {
        let [u, v] = [i, j].map(|k| f64::from(k) / f64::from(n));
        let (point, by_u, by_v): (DVec3, DVec3, DVec3) = patch.point_and_tangents(u, v);
        positions.push(point);
        normals.push(by_u.cross(by_v).normalize_or_zero());
    }
    // Rows of n + 1, n, n - 1, ... corners.
    let corner = |i: u32, j: u32| i * (n + 1) - i * i.saturating_sub(1) / 2 + j;
    let mut indices = Vec::with_capacity((n as usize).pow(2));
    for (i, j) in (0..n).flat_map(|i| (0..n - i).map(move |j| (i, j))) {
        indices.push([corner(i, j), corner(i + 1, j), corner(i, j + 1)]);
        if i + j + 1 < n {
            indices.push([corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)]);
        }
    }
    GeometryDescription::Triangles { positions, indices, normals: smooth.then_some(normals), uvs: None }
}

#[cfg(test)]
mod tests {
    use super::super::room;
    use super::*;

    #[test]
    fn triangles_cover_the_domain_once_and_turn_as_the_patch_does() {
        // In its plane: half of the unit square.
        let flat = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let patch = TrianglePatch::try_from_points(1, &flat, None).unwrap();
        let GeometryDescription::Triangles { positions, indices, .. } = triangles(&patch, 7, false) else {
            panic!("no triangles")
        };
        assert_eq!((indices.len(), positions.len()), (49, 36));
        for t in &indices {
            let [a, b, c] = t.map(|i| positions[i as usize]);
            // All as large and turned alike: 1 / 2 in 49 parts.
            assert!((0.5 * (b - a).cross(c - a).z - 0.5 / 49.0).abs() < 1e-14);
        }
    }

    #[test]
    fn normals_are_those_of_the_patch() {
        let patch = room::mirror().unwrap();
        let GeometryDescription::Triangles { positions, indices, normals, .. } = triangles(&patch, 40, true)
        else {
            panic!("no triangles")
        };
        let normals = normals.unwrap();
        for t in &indices {
            let [a, b, c] = t.map(|i| positions[i as usize]);
            let facet = (b - a).cross(c - a).normalize();
            assert!(t.iter().all(|&i| facet.dot(normals[i as usize]) > 0.9), "{t:?}");
        }
    }
}
