//! Random points of a mesh.

use glanz_math::{AreaPdf, DVec2, DVec3};

use super::Mesh;
use super::shading::{FlatPoint, SmoothNormal};
use crate::hit::{AreaSample, Hit, SurfaceSample};
use crate::triangle::sample_barycentric;

/// Largest number of prepared triangles, 120 bytes each: half a megabyte.
const PREPARED_LIMIT: usize = 1 << 12;

/// What random points of a mesh need, built at the first one.
#[derive(Clone, Debug)]
pub(super) struct SamplingTable {
    /// Area of the first 1, 2 ... triangles, m^2.
    areas: Vec<f64>,
    /// All triangles; empty if they are many, or if the side of a normal varies over a triangle.
    triangles: Vec<TriangleSampler>,
}

/// A triangle with the part of its points that is the same everywhere on it.
#[derive(Clone, Copy, Debug)]
struct TriangleSampler {
    corner: DVec3,
    edges: [DVec3; 2],
    error: DVec3,
    normal: DVec3,
}

impl SamplingTable {
    pub(super) fn new(mesh: &Mesh) -> Self {
        let faces = 0..mesh.indices().len() as u32;
        let mut sum = 0.0;
        let areas = faces
            .clone()
            .map(|face| {
                sum += mesh.face_area(face);
                sum
            })
            .collect();
        let few = mesh.indices().len() <= PREPARED_LIMIT;
        let triangles = few.then(|| faces.map(|face| TriangleSampler::new(mesh, face)).collect());
        Self { areas, triangles: triangles.flatten().unwrap_or_default() }
    }

    /// Area of all triangles, m^2.
    pub(super) fn area(&self) -> f64 {
        self.areas.last().copied().unwrap_or_default()
    }

    /// A random triangle with barycentric weights, and the density.
    fn sample(&self, xi: DVec2) -> Option<(Hit, AreaPdf)> {
        let areas = &self.areas;
        let total = areas.last().copied().filter(|&area| area > 0.0)?;
        let target = xi.x * total;
        // At the end of the numbers, the last triangle that has an area.
        let last = areas.partition_point(|&area| area < total);
        let face = areas.partition_point(|&area| area <= target).min(last);
        let before = face.checked_sub(1).map_or(0.0, |previous| areas[previous]);
        // The rest of the number that selected the triangle.
        let rest = ((target - before) / (areas[face] - before)).clamp(0.0, 1.0f64.next_down());
        let b = sample_barycentric(DVec2::new(rest, xi.y));
        Some((Hit { t: 0.0, u: b.x, v: b.y, face: face as u32 }, AreaPdf(1.0 / total)))
    }
}

impl TriangleSampler {
    /// `None` if normals at the vertices do not agree on the side: their weighted sum is on the side of all.
    fn new(mesh: &Mesh, face: u32) -> Option<Self> {
        let FlatPoint { error, normal, .. } = mesh.flat_point_at(face, 0.0, 0.0);
        let [p0, p1, p2] = mesh.corners(face)?;
        let triangle = Self { corner: p0, edges: [p1 - p0, p2 - p0], error, normal };
        // One without area is never sampled.
        if mesh.normals.is_none() || mesh.face_area(face) == 0.0 {
            return Some(triangle);
        }
        let corners = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)];
        let [a, b, c] = corners.map(|(u, v)| Some(mesh.smooth_normal(face, u, v, normal)?.normal));
        let normal = a.filter(|_| a == b && b == c)?;
        Some(Self { normal, ..triangle })
    }
}

impl Mesh {
    pub(super) fn sample_point(&self, xi: DVec2) -> Option<SurfaceSample> {
        let (hit, pdf) = self.sampling_table().sample(xi)?;
        Some(SurfaceSample { hit, point: self.point_at(hit.face, hit.u, hit.v), pdf })
    }

    pub(super) fn sample_area_point(&self, xi: DVec2) -> Option<AreaSample> {
        let table = self.sampling_table();
        let (Hit { u, v, face, .. }, pdf) = table.sample(xi)?;
        if let Some(TriangleSampler { corner, edges: [a, b], error, normal }) =
            table.triangles.get(face as usize)
        {
            // The operations of `flat_point_at`.
            let position = *corner + u * *a + v * *b;
            return Some(AreaSample { position, error: *error, normal: *normal, face, pdf });
        }
        let FlatPoint { position, error, normal } = self.flat_point_at(face, u, v);
        Some(AreaSample { position, error, normal: self.oriented_normal(face, u, v, normal), face, pdf })
    }

    /// The unit normal `flat` of a triangle, on the side that the normals at its vertices determine.
    fn oriented_normal(&self, face: u32, u: f64, v: f64, flat: DVec3) -> DVec3 {
        self.smooth_normal(face, u, v, flat).map_or(flat, |SmoothNormal { normal, .. }| normal)
    }
}
