//! Random points of a mesh.

use glanz_math::{AreaPdf, DVec2, DVec3};

use super::Mesh;
use super::shading::{FlatPoint, SmoothNormal};
use crate::hit::{AreaSample, Hit, SurfaceSample};
use crate::triangle::sample_barycentric;

/// Table for random points of a mesh, built at the first one.
#[derive(Clone, Debug)]
pub(super) struct SamplingTable {
    /// Area of the first 1, 2 ... triangles, m^2.
    areas: Vec<f64>,
    /// The last triangle that has an area.
    last: usize,
    /// For each triangle, the side of its normal on which the normals at its vertices are, 1 or -1; 0 if they are on both. Empty without
    /// normals at the vertices.
    sides: Vec<i8>,
}

impl SamplingTable {
    pub(super) fn new(mesh: &Mesh) -> Self {
        let faces = 0..mesh.indices().len() as u32;
        let mut sum = 0.0;
        let areas: Vec<f64> = faces
            .clone()
            .map(|face| {
                sum += mesh.face_area(face);
                sum
            })
            .collect();
        let sides = mesh.normals.iter().flat_map(|_| faces.clone().map(|face| side(mesh, face))).collect();
        Self { last: areas.partition_point(|&area| area < sum), areas, sides }
    }

    /// Area of all triangles, m^2.
    pub(super) fn area(&self) -> f64 {
        self.areas.last().copied().unwrap_or_default()
    }

    /// A random triangle with barycentric weights, and the density.
    #[inline]
    fn sample(&self, xi: DVec2) -> Option<(Hit, AreaPdf)> {
        let areas = &self.areas;
        let total = areas.last().copied().filter(|&area| area > 0.0)?;
        let target = xi.x * total;
        // At the end of the numbers, the last triangle that has an area.
        let face = areas.partition_point(|&area| area <= target).min(self.last);
        let before = face.checked_sub(1).map_or(0.0, |previous| areas[previous]);
        // The rest of the number that selected the triangle.
        let rest = ((target - before) / (areas[face] - before)).clamp(0.0, 1.0f64.next_down());
        let b = sample_barycentric(DVec2::new(rest, xi.y));
        Some((Hit::new(0.0, b.x, b.y, face as u32), AreaPdf(1.0 / total)))
    }
}

/// The side of a triangle's normal on which the normals at its vertices are, and so all interpolated ones; 0 if they are on both, or on
/// none.
fn side(mesh: &Mesh, face: u32) -> i8 {
    let flat = mesh.flat_point_at(face, 0.0, 0.0).normal;
    let corners = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)];
    let [a, b, c] = corners.map(|(u, v)| {
        mesh.smooth_normal(face, u, v, flat)
            .map_or(0, |smooth| if smooth.normal.dot(flat) > 0.0 { 1 } else { -1 })
    });
    if a == b && b == c { a } else { 0 }
}

impl Mesh {
    pub(super) fn sample_point(&self, xi: DVec2) -> Option<SurfaceSample> {
        let (hit, pdf) = self.sampling_table().sample(xi)?;
        Some(SurfaceSample { hit, point: self.point_at(hit.face, hit.u, hit.v), pdf })
    }

    #[inline]
    pub(super) fn sample_area_point(&self, xi: DVec2) -> Option<AreaSample> {
        let table = self.sampling_table();
        let (Hit { u, v, face, .. }, pdf) = table.sample(xi)?;
        let FlatPoint { position, error, normal: flat } = self.flat_point_at(face, u, v);
        let normal = match table.sides.get(face as usize) {
            None => flat,
            // The side varies over the triangle.
            Some(0) => self.oriented_normal(face, u, v, flat),
            Some(&side) => flat * f64::from(side),
        };
        Some(AreaSample { position, error, normal, face, pdf })
    }

    /// The unit normal `flat` of a triangle, on the side that the normals at its vertices determine.
    fn oriented_normal(&self, face: u32, u: f64, v: f64, flat: DVec3) -> DVec3 {
        self.smooth_normal(face, u, v, flat).map_or(flat, |SmoothNormal { normal, .. }| normal)
    }
}
