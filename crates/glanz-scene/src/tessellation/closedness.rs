//! Whether triangles enclose volumes.

use std::collections::HashMap;

use glanz_math::DVec3;

use super::GroupMesh;

impl GroupMesh {
    /// The triangles of some of the shapes, as indices into the positions.
    pub fn position_triangles<'a>(
        &'a self,
        shapes: impl IntoIterator<Item = usize> + 'a,
    ) -> impl Iterator<Item = [u32; 3]> + 'a {
        let shapes = shapes.into_iter().filter_map(|shape| self.shapes.get(shape));
        shapes.flat_map(|shape| {
            let position = |i: u32| shape.vertices.get(i as usize).map_or(u32::MAX, |vertex| vertex.position);
            shape.triangles.iter().map(move |corners| corners.map(position))
        })
    }

    /// Number of sides of triangles of some of the shapes that no other triangle runs through the other way; 0 if they are watertight.
    ///
    /// In a closed surface, each side belongs to two triangles with opposite directions.
    pub fn open_sides(&self, shapes: impl IntoIterator<Item = usize>) -> usize {
        let mut sides: HashMap<[u32; 2], i32> = HashMap::new();
        for [a, b, c] in self.position_triangles(shapes) {
            for [from, to] in [[a, b], [b, c], [c, a]] {
                let (ends, sign) = if from < to { ([from, to], 1) } else { ([to, from], -1) };
                *sides.entry(ends).or_insert(0) += sign;
            }
        }
        sides.values().map(|excess| excess.unsigned_abs() as usize).sum()
    }

    /// The volume that some of the shapes enclose, m^3; without meaning if they are not watertight.
    pub fn volume(&self, shapes: impl IntoIterator<Item = usize>) -> f64 {
        let at = |i: u32| self.positions.get(i as usize).copied().unwrap_or(DVec3::NAN);
        let origin = self.positions.first().copied().unwrap_or_default();
        let parts = self.position_triangles(shapes).map(|corners| {
            let [a, b, c] = corners.map(|i| at(i) - origin);
            a.dot(b.cross(c)) / 6.0
        });
        parts.sum()
    }

    /// The area of some of the shapes, m^2.
    pub fn area(&self, shapes: impl IntoIterator<Item = usize>) -> f64 {
        let at = |i: u32| self.positions.get(i as usize).copied().unwrap_or(DVec3::NAN);
        let parts = self.position_triangles(shapes).map(|corners| {
            let [a, b, c] = corners.map(at);
            0.5 * (b - a).cross(c - a).length()
        });
        parts.sum()
    }
}
