//! Flat convex polygons.

use std::collections::HashMap;

use glanz_geometry::mesh::Mesh;
use glanz_math::DVec3;

/// Fraction of its size by which a polygon may leave its plane or turn the wrong way: the error of coordinates that are printed with ten digits.
const FLATNESS: f64 = 1e-9;

/// A flat convex polygon.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ConvexPolygon {
    corners: Vec<DVec3>,
    normal: DVec3,
    area: f64,
    center: DVec3,
    /// Distance of the centre from the nearest side.
    inner_radius: f64,
}

impl ConvexPolygon {
    /// `None` if the corners are not those of a flat convex polygon, in order.
    pub(super) fn try_new(corners: Vec<DVec3>) -> Option<Self> {
        let first = *corners.first()?;
        let sides = || corners.iter().zip(corners.iter().cycle().skip(1));
        let twice_area: DVec3 = sides().map(|(&a, &b)| (a - first).cross(b - first)).sum();
        let normal = twice_area.try_normalize()?;
        let size = corners.iter().fold(0.0, |size: f64, &c| size.max(c.distance(first)));
        let is_flat = corners.iter().all(|&c| (c - first).dot(normal).abs() <= FLATNESS * size);
        let turns = sides().zip(corners.iter().cycle().skip(2));
        // A polygon that winds twice also turns left everywhere, but its corners are not all to the left of a side.
        let is_convex = turns.clone().all(|((&a, &b), &c)| turn(a, b, c, normal) >= -FLATNESS * size * size)
            && sides()
                .all(|(&a, &b)| corners.iter().all(|&c| turn(a, b, c, normal) >= -FLATNESS * size * size));
        let center = corners.iter().sum::<DVec3>() / corners.len() as f64;
        let area = 0.5 * twice_area.length();
        let mut polygon = Self { corners, normal, area, center, inner_radius: 0.0 };
        polygon.inner_radius = polygon.depth(center).0;
        (is_flat && is_convex && polygon.inner_radius > 0.0).then_some(polygon)
    }

    /// Union of the triangles of a mesh, if it is a convex polygon and they do not overlap.
    pub(super) fn of_mesh(mesh: &Mesh, map: impl Fn(DVec3) -> DVec3) -> Option<Self> {
        // Vertices with the same position count as one.
        let mut first_at: HashMap<[u64; 3], u32> = HashMap::new();
        let numbers: Vec<u32> = (0..)
            .zip(mesh.positions())
            .map(|(i, p)| *first_at.entry((p + DVec3::ZERO).to_array().map(f64::to_bits)).or_insert(i))
            .collect();
        let mut next: HashMap<u32, u32> = HashMap::new();
        let triangles: Vec<[u32; 3]> =
            mesh.indices().iter().map(|t| t.map(|i| numbers.get(i as usize).copied().unwrap_or(i))).collect();
        let sides = || triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
        let all: std::collections::HashSet<(u32, u32)> = sides().collect();
        let mut border = 0;
        for (a, b) in sides().filter(|&(a, b)| !all.contains(&(b, a))) {
            border += 1;
            if next.insert(a, b).is_some() {
                return None;
            }
        }
        let start = *next.keys().min()?;
        let mut order = vec![start];
        while let Some(&b) = order.last().and_then(|last| next.get(last)).filter(|&&b| b != start) {
            order.push(b);
            if order.len() > border {
                return None;
            }
        }
        let corners: Option<Vec<DVec3>> = order.iter().map(|&i| mesh.position(i).map(&map)).collect();
        let polygon = Self::try_new(corners?)?;
        let area: f64 = triangles
            .iter()
            .filter_map(|t| {
                let [a, b, c] = t.map(|i| mesh.position(i).map(&map));
                Some(0.5 * (b? - a?).cross(c? - a?).length())
            })
            .sum();
        (order.len() == border && (area - polygon.area).abs() <= 1e-6 * area).then_some(polygon)
    }

    pub(super) fn corners(&self) -> &[DVec3] {
        &self.corners
    }

    /// Unit normal; seen from its side, the corners are in counterclockwise order.
    pub(super) fn normal(&self) -> DVec3 {
        self.normal
    }

    pub(super) fn center(&self) -> DVec3 {
        self.center
    }

    pub(super) fn inner_radius(&self) -> f64 {
        self.inner_radius
    }

    /// Distance of the farthest corner from the centre.
    pub(super) fn reach(&self) -> f64 {
        self.corners.iter().fold(0.0, |most: f64, c| most.max(c.distance(self.center)))
    }

    /// Distance of a point of the plane from the nearest side, negative outside, and the number of that side.
    pub(super) fn depth(&self, point: DVec3) -> (f64, u32) {
        let sides = self.corners.iter().zip(self.corners.iter().cycle().skip(1));
        let depths = (0..).zip(sides).filter_map(|(number, (&a, &b))| {
            let inwards = self.normal.cross(b - a).try_normalize()?;
            Some((inwards.dot(point - a), number))
        });
        depths.fold((f64::INFINITY, 0), |least, next| if next.0 < least.0 { next } else { least })
    }
}

fn turn(a: DVec3, b: DVec3, c: DVec3, normal: DVec3) -> f64 {
    (b - a).cross(c - b).dot(normal)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mesh(positions: &[[f64; 2]], indices: &[[u32; 3]]) -> Mesh {
        let positions = positions.iter().map(|&[x, y]| DVec3::new(x, y, 1.0)).collect();
        Mesh::try_new(positions, indices.to_vec(), None, None).unwrap()
    }

    const SQUARE: [[f64; 2]; 4] = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]];

    #[test]
    fn two_triangles_form_a_rectangle() {
        let polygon = ConvexPolygon::of_mesh(&mesh(&SQUARE, &[[0, 1, 2], [0, 2, 3]]), |p| p * 2.0).unwrap();
        assert_eq!(polygon.corners().len(), 4);
        assert_eq!((polygon.area, polygon.normal(), polygon.center().z), (8.0, DVec3::Z, 2.0));
        assert_eq!(polygon.depth(DVec3::new(1.0, 0.5, 2.0)).0, 0.5);
        assert_eq!(polygon.depth(DVec3::new(5.0, 0.5, 2.0)), (-1.0, 1));
        // Each end of the diagonal has two vertices.
        let twice = [SQUARE[0], SQUARE[1], SQUARE[2], SQUARE[0], SQUARE[2], SQUARE[3]];
        assert!(ConvexPolygon::of_mesh(&mesh(&twice, &[[0, 1, 2], [3, 4, 5]]), |p| p).is_some());
    }

    #[test]
    fn bent_concave_and_overlapping_meshes_are_refused() {
        // An arrow head, two triangles that only touch, and triangles on top of one another.
        let arrow = [[0.0, 0.0], [2.0, -1.0], [1.0, 0.0], [2.0, 1.0]];
        assert!(ConvexPolygon::of_mesh(&mesh(&arrow, &[[0, 1, 2], [0, 2, 3]]), |p| p).is_none());
        let apart = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [5.0, 5.0], [6.0, 5.0], [5.0, 6.0]];
        assert!(ConvexPolygon::of_mesh(&mesh(&apart, &[[0, 1, 2], [3, 4, 5]]), |p| p).is_none());
        assert!(ConvexPolygon::of_mesh(&mesh(&SQUARE, &[[0, 1, 2], [0, 1, 3]]), |p| p).is_none());
        let bent = vec![DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.1), DVec3::Y];
        assert!(ConvexPolygon::try_new(bent).is_none());
    }

    #[test]
    fn star_that_turns_left_everywhere_is_refused() {
        let corner = |i: u32| {
            let (sin, cos) = (f64::from(2 * i) * std::f64::consts::TAU / 5.0).sin_cos();
            DVec3::new(cos, sin, 0.0)
        };
        assert!(ConvexPolygon::try_new((0..5).map(corner).collect()).is_none());
    }
}
