//! Memory of descriptions.

use super::{GeometryDescription, GroupDescription, InstanceDescription, ShapeDescription, TrimDescription};

/// Parts of a list whose length doubles when it is full: the old one, and one of twice the length.
const GROWTH: usize = 3;

fn list<T>(items: &[T]) -> u64 {
    size_of_val(items) as u64
}

fn patches(patches: &[Vec<[f64; 4]>]) -> u64 {
    list(patches) + patches.iter().map(|patch| list(patch)).sum::<u64>()
}

impl GeometryDescription {
    /// Bytes of its lists.
    fn bytes(&self) -> u64 {
        match self {
            Self::Algebraic { terms, .. } => list(terms),
            Self::Polyhedron { half_spaces } => list(half_spaces),
            Self::Triangles { positions, indices, normals, uvs } => {
                let normals = normals.as_deref().map_or(0, list);
                list(positions) + list(indices) + normals + uvs.as_deref().map_or(0, list)
            }
            Self::Bilinear { positions, indices } => list(positions) + list(indices),
            Self::Nurbs(nurbs) => list(&nurbs.knots_u) + list(&nurbs.knots_v) + list(&nurbs.points),
            Self::BezierPatches(list) => patches(&list.patches),
            Self::BezierTriangles(list) => patches(&list.patches),
            Self::Curve { points, .. } => list(points),
            _ => 0,
        }
    }
}

impl TrimDescription {
    fn bytes(&self) -> u64 {
        let curves = self.loops.iter().flat_map(|looped| &looped.curves);
        list(&self.loops)
            + curves.map(|c| size_of_val(c) as u64 + list(&c.knots) + list(&c.points)).sum::<u64>()
    }
}

impl ShapeDescription {
    /// Bytes of memory of the shape with its lists, as one of a list that grows.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        let trim = self.trim.as_ref().map_or(0, TrimDescription::bytes);
        (GROWTH * size_of::<Self>()) as u64 + self.geometry.bytes() + trim
    }
}

impl InstanceDescription {
    /// Bytes of memory of the instance, as one of a list that grows.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        (GROWTH * size_of::<Self>() + self.name.len()) as u64
    }
}

impl GroupDescription {
    /// Number of shapes and instances.
    #[must_use]
    pub fn object_count(&self) -> u64 {
        (self.shapes.len() + self.instances.len()) as u64
    }

    /// Bytes of memory of the shapes, instances and edges.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        let shapes: u64 = self.shapes.iter().map(ShapeDescription::bytes).sum();
        let instances: u64 = self.instances.iter().map(InstanceDescription::bytes).sum();
        let edges =
            self.edges.iter().map(|edge| size_of_val(edge) as u64 + list(&edge.points) + list(&edge.shapes));
        shapes + instances + edges.sum::<u64>()
    }
}
