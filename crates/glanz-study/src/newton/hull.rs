//! The convex hull of a few points as half-spaces, and clipping of rays to it.

use glanz_math::{DVec3, Ray};

/// Share of the extent within which a point counts as lying on a plane: roundings of cross products of coordinates that
/// are as large as the extent, with a margin. The hull may only come out larger by that much.
const FLAT: f64 = 1e-12;

/// Planes with all points on their inner side: `normal . p <= offset`.
#[derive(Clone, Debug)]
pub(crate) struct Hull {
    planes: Vec<(DVec3, f64)>,
}

impl Hull {
    /// The hull of `points`, by trying all planes through three of them: n^4 steps for n points, of which there are 16 at
    /// most here. Points in a plane have a flat hull.
    pub(crate) fn of(points: &[DVec3]) -> Self {
        let extent = points.iter().flat_map(|p| points.iter().map(|q| p.distance(*q))).fold(0.0, f64::max);
        let mut planes: Vec<(DVec3, f64)> = Vec::new();
        for (i, &a) in points.iter().enumerate() {
            for (j, &b) in points.iter().enumerate().skip(i + 1) {
                for &c in points.iter().skip(j + 1) {
                    let cross = (b - a).cross(c - a);
                    if cross.length() <= FLAT * extent * extent {
                        continue;
                    }
                    let normal = cross.normalize();
                    for normal in [normal, -normal] {
                        let offset = points.iter().map(|p| normal.dot(*p - a)).fold(0.0, f64::max);
                        let at = normal.dot(a) + offset;
                        let known = planes.iter().any(|(n, o)| {
                            n.dot(normal) > 1.0 - FLAT && (o - at).abs() <= 8.0 * FLAT * extent
                        });
                        if offset <= 8.0 * FLAT * extent && !known {
                            // A flat hull must not be empty by rounding.
                            planes.push((normal, at + FLAT * extent));
                        }
                    }
                }
            }
        }
        Self { planes }
    }

    /// The edges between `points`, those of [`Hull::of`]: pairs that two planes share. Points on an edge beside its ends part it.
    pub(crate) fn edges(&self, points: &[DVec3]) -> Vec<[DVec3; 2]> {
        let extent = points.iter().flat_map(|p| points.iter().map(|q| p.distance(*q))).fold(0.0, f64::max);
        let on = |(normal, offset): &(DVec3, f64), p: DVec3| {
            (normal.dot(p) - offset).abs() <= 16.0 * FLAT * extent
        };
        let mut edges: Vec<[DVec3; 2]> = Vec::new();
        for (i, &a) in points.iter().enumerate() {
            for &b in points.iter().skip(i + 1) {
                let shared = self.planes.iter().filter(|plane| on(plane, a) && on(plane, b)).count();
                let parted = points.iter().any(|&p| {
                    let share = (p - a).dot(b - a) / (b - a).length_squared();
                    share > FLAT && share < 1.0 - FLAT && p.distance(a.lerp(b, share)) <= 16.0 * FLAT * extent
                });
                if shared >= 2 && !parted {
                    edges.push([a, b]);
                }
            }
        }
        edges
    }

    /// The interval of ray parameters, none negative, inside; `None` if the ray misses.
    pub(super) fn clip(&self, ray: &Ray) -> Option<[f64; 2]> {
        let (mut near, mut far) = (0.0_f64, f64::INFINITY);
        for (normal, offset) in &self.planes {
            let (height, slope) = (offset - normal.dot(ray.origin), normal.dot(ray.direction));
            if slope > 0.0 {
                far = far.min(height / slope);
            } else if slope < 0.0 {
                near = near.max(height / slope);
            } else if height < 0.0 {
                return None;
            }
        }
        (near <= far && far.is_finite()).then_some([near, far])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hull_of_a_cube_and_inner_points_is_its_six_planes() {
        let mut points: Vec<DVec3> = (0..8_u32)
            .map(|i| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)))
            .collect();
        points.push(DVec3::splat(0.5));
        points.push(DVec3::new(0.5, 0.5, 1.0));
        let hull = Hull::of(&points);
        assert_eq!(hull.planes.len(), 6);
        let ray = Ray::new(DVec3::new(-2.0, 0.25, 0.75), DVec3::X);
        let near = |found: Option<[f64; 2]>, [a, b]: [f64; 2]| {
            found.is_some_and(|[c, d]| (a - c).abs() < 1e-11 && (b - d).abs() < 1e-11)
        };
        assert!(near(hull.clip(&ray), [2.0, 3.0]));
        assert_eq!(hull.clip(&Ray::new(ray.origin, DVec3::Y)), None);
        assert_eq!(hull.clip(&Ray::new(ray.origin, DVec3::NEG_X)), None);
        assert!(near(hull.clip(&Ray::new(DVec3::splat(0.5), DVec3::X)), [0.0, 0.5]));
        let edges = hull.edges(&points);
        assert_eq!(edges.len(), 12);
        assert!(edges.iter().all(|[a, b]| (a.distance(*b) - 1.0).abs() < 1e-15));
    }

    #[test]
    fn flat_hull_is_met() {
        let (a, b) = (DVec3::new(0.3, 0.1, 0.7), DVec3::new(-0.2, 0.9, 0.1));
        let points: Vec<DVec3> =
            (0..16_u32).map(|i| a * f64::from(i % 4) / 3.0 + b * f64::from(i / 4) / 3.0).collect();
        let hull = Hull::of(&points);
        for i in 1..20 {
            let inside = a * (f64::from(i) * 0.618).fract() + b * (f64::from(i) * 0.755).fract();
            let ray = Ray::new(DVec3::new(1.0, 1.0, -2.0), inside - DVec3::new(1.0, 1.0, -2.0));
            assert!(
                hull.clip(&ray).is_some_and(|[near, far]| (near - 1.0).abs() < 1e-9 && far - near < 1e-9)
            );
        }
    }

    #[test]
    fn hull_of_the_patch_of_document_000_has_twelve_faces_on_eight_vertices() {
        // A polyhedron of triangles with 8 vertices has 2 * 8 - 4 = 12 faces, the number that the program of @pumberger2010 assumes for
        // every patch; coplanar triangles share a plane here.
        let shape = crate::newton::patches::reflector(crate::newton::patches::TRUE_POINTS).unwrap();
        let hull = Hull::of(&shape.points());
        let corners = shape.points().into_iter().filter(|p| {
            let on = hull.planes.iter().filter(|(n, o)| (n.dot(*p) - o).abs() < 1e-9).count();
            on >= 3
        });
        assert_eq!(corners.count(), 8);
        assert!((6..=12).contains(&hull.planes.len()), "{}", hull.planes.len());
    }
}
