//! Triangle meshes.
//!
//! A [`Mesh`] owns its hierarchy and lays its triangles out in the order of the leaves, four to a block. The test is that
//! of [`crate::triangle::ShearedRay`] bit by bit, so that a ray cannot slip through an edge or a vertex that triangles
//! share, whatever the instruction set. Files: `vector_list` (values at vertices), `block` (the triangles),
//! `query` (closest, any and all hits), `stream` and `ray_lanes` (batches of rays), `shading` (the surface at a hit),
//! `sampling` (random points).

mod block;
mod query;
mod ray_lanes;
mod sampling;
mod shading;
mod stream;
#[cfg(test)]
mod tests;
mod vector_list;

use std::sync::OnceLock;

use glanz_math::rounding::gamma;
use glanz_math::{AreaPdf, Bounds3, DVec2, DVec3, Ray};

use self::block::{LANES, TriangleBlocks};
use self::query::MeshQuery;
use self::sampling::SamplingTable;
use self::shading::PreparedTriangle;
use self::stream::MeshBatch;
use self::vector_list::VectorList;
use crate::batch::BoundedRay;
use crate::bvh::query::{AllHits, AnyHit, ClosestHit, HitCollector};
use crate::bvh::{BuildOptions, Bvh, BvhStatistics, PARALLEL_CHUNK, parallel_map};
use crate::error::{SurfaceError, finite};
use crate::hit::{AreaSample, Hit, ShadingPoint, SurfacePoint, SurfaceSample};
use crate::surface::RaySurface;
use crate::triangle::unit_normal;

/// Cost of testing a block of triangles relative to that of testing a node, measured with `benches/mesh`.
const BLOCK_COST: f32 = 1.0;

/// Largest number of triangles that are stored with their normals and error bounds, 120 bytes each: those of joined walls and furniture,
/// whose points would cost more than the search for hits.
const PREPARED_LIMIT: usize = 1 << 10;

/// Triangles that share vertices.
///
/// `Hit::face` is the position of the triangle in the list of indices, `u` and `v` are the barycentric weights of its
/// second and third vertex. The normal is that of `(p1 - p0) x (p2 - p0)`, or its opposite if the shading normals
/// are on that side.
#[derive(Clone, Debug)]
pub struct Mesh {
    positions: VectorList<DVec3>,
    indices: Vec<[u32; 3]>,
    normals: Option<VectorList<DVec3>>,
    uvs: Option<VectorList<DVec2>>,
    degenerate: usize,
    bvh: Bvh,
    blocks: TriangleBlocks,
    /// All triangles of a mesh of up to [`PREPARED_LIMIT`]; else empty.
    prepared: Vec<PreparedTriangle>,
    /// Built when a random point or the area is first needed.
    sampling_table: OnceLock<SamplingTable>,
}

impl Mesh {
    /// A mesh of the triangles `indices` (positions in the list of vertices) over vertices at `positions` (metres).
    ///
    /// `normals` (of any length, zero meaning that of the triangle) and `uvs` belong to the vertices. Triangles without
    /// an area beyond rounding ([`unit_normal`]) are never hit nor sampled, and counted: [`Mesh::degenerate`].
    ///
    /// # Errors
    /// [`SurfaceError::NotFinite`] if a coordinate is not finite, [`SurfaceError::BadIndex`],
    /// [`SurfaceError::CountMismatch`] if there are not as many normals or texture coordinates as vertices,
    /// [`SurfaceError::Degenerate`] if no triangle has an area.
    pub fn try_new(
        positions: Vec<DVec3>,
        indices: Vec<[u32; 3]>,
        normals: Option<Vec<DVec3>>,
        uvs: Option<Vec<DVec2>>,
    ) -> Result<Self, SurfaceError> {
        let count = positions.len();
        check_list("vertex normals", normals.as_deref(), count, DVec3::is_finite, |n| n.to_array().to_vec())?;
        check_list("texture coordinates", uvs.as_deref(), count, DVec2::is_finite, |c| {
            c.to_array().to_vec()
        })?;
        check_list("vertex positions", Some(&positions), count, DVec3::is_finite, |p| p.to_array().to_vec())?;
        check_indices(&indices, count)?;
        let boxes = triangle_boxes(&positions, &indices);
        let degenerate = boxes.iter().filter(|b| b.is_empty()).count();
        if degenerate == boxes.len() {
            return Err(SurfaceError::Degenerate {
                reason: "no triangle has three corners apart, triangles",
                value: boxes.len() as f64,
            });
        }
        let options = BuildOptions { max_leaf: LANES, block: LANES, leaf_cost: BLOCK_COST };
        // Before the tree takes its memory.
        let positions = VectorList::new(positions);
        let mut bvh = Bvh::build_over(boxes, &options);
        let blocks = TriangleBlocks::new(&positions, &indices, &bvh);
        bvh.forget_items();
        let (normals, uvs) = (normals.map(VectorList::new), uvs.map(VectorList::new));
        let (prepared, sampling_table) = (Vec::new(), OnceLock::new());
        let mut mesh =
            Self { positions, indices, normals, uvs, degenerate, bvh, blocks, prepared, sampling_table };
        if mesh.indices.len() <= PREPARED_LIMIT {
            let faces = 0..mesh.indices.len() as u32;
            let corners = faces.map(|face| mesh.corners(face).unwrap_or_default());
            mesh.prepared = corners.map(PreparedTriangle::new).collect();
        }
        Ok(mesh)
    }

    /// Number of vertices.
    #[must_use]
    pub fn vertex_count(&self) -> usize {
        self.positions.len()
    }

    /// Vertices, metres.
    pub fn positions(&self) -> impl Iterator<Item = DVec3> + '_ {
        self.positions.iter()
    }

    /// The vertex of this number, metres; `None` from [`Mesh::vertex_count`] on.
    #[must_use]
    pub fn position(&self, vertex: u32) -> Option<DVec3> {
        self.positions.get(vertex)
    }

    /// Triangles, as positions in the list of vertices; degenerate ones included.
    #[must_use]
    pub fn indices(&self) -> &[[u32; 3]] {
        &self.indices
    }

    /// Normals at the vertices, as they were given.
    #[must_use]
    pub fn normals(&self) -> Option<impl Iterator<Item = DVec3> + '_> {
        self.normals.as_ref().map(VectorList::iter)
    }

    /// The normal at a vertex, as it was given.
    #[must_use]
    pub fn normal(&self, vertex: u32) -> Option<DVec3> {
        self.normals.as_ref()?.get(vertex)
    }

    /// Texture coordinates at the vertices.
    #[must_use]
    pub fn uvs(&self) -> Option<impl Iterator<Item = DVec2> + '_> {
        self.uvs.as_ref().map(VectorList::iter)
    }

    /// Number of triangles that have no area and are therefore never hit.
    #[must_use]
    pub fn degenerate(&self) -> usize {
        self.degenerate
    }

    /// Area of all triangles, m^2.
    #[must_use]
    pub fn area(&self) -> f64 {
        self.sampling_table().area()
    }

    /// Size and expected cost of the hierarchy.
    #[must_use]
    pub fn statistics(&self) -> BvhStatistics {
        self.bvh.statistics()
    }

    /// Memory of vertices, triangles and hierarchy, bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.positions.bytes()
            + size_of_val(&*self.indices)
            + self.normals.as_ref().map_or(0, VectorList::bytes)
            + self.uvs.as_ref().map_or(0, VectorList::bytes)
            + self.blocks.bytes()
            + size_of_val(&*self.prepared)
            + self.statistics().bytes
    }

    fn query<C: HitCollector>(&self, ray: &Ray, collector: C) -> C {
        self.bvh.isa().run(MeshQuery { mesh: self, ray, collector })
    }

    fn corners(&self, face: u32) -> Option<[DVec3; 3]> {
        self.at_corners(Some(&self.positions), face)
    }

    /// Area of a triangle, m^2; 0 if it is degenerate.
    pub(crate) fn face_area(&self, face: u32) -> f64 {
        let area = |[a, b, c]: [DVec3; 3]| unit_normal(a, b, c).map(|_| 0.5 * (b - a).cross(c - a).length());
        self.corners(face).and_then(area).unwrap_or_default()
    }

    #[inline]
    fn sampling_table(&self) -> &SamplingTable {
        self.sampling_table.get_or_init(|| SamplingTable::new(self))
    }
}

/// Checks a list that has an entry per vertex.
fn check_list<T: Copy>(
    parameter: &'static str,
    list: Option<&[T]>,
    expected: usize,
    is_finite: impl Fn(T) -> bool,
    numbers: impl Fn(&T) -> Vec<f64>,
) -> Result<(), SurfaceError> {
    let Some(list) = list else { return Ok(()) };
    if list.len() != expected {
        return Err(SurfaceError::CountMismatch { parameter, count: list.len(), expected });
    }
    match list.iter().find(|&&entry| !is_finite(entry)) {
        Some(bad) => numbers(bad).into_iter().try_for_each(|x| finite(parameter, x).map(|_| ())),
        None => Ok(()),
    }
}

fn check_indices(indices: &[[u32; 3]], count: usize) -> Result<(), SurfaceError> {
    // Half of 2^32, so that a bit distinguishes leaves from nodes.
    const MOST: usize = 1 << 31;
    if indices.is_empty() {
        return Err(SurfaceError::TooFew { parameter: "triangles", count: 0, min: 1 });
    }
    if indices.len() > MOST {
        return Err(SurfaceError::OutOfRange {
            parameter: "number of triangles",
            value: indices.len() as f64,
            min: 1.0,
            max: MOST as f64,
        });
    }
    let bad = |i: &u32| *i as usize >= count;
    match indices.as_flattened().iter().position(bad) {
        Some(position) => Err(SurfaceError::BadIndex {
            parameter: "vertex index",
            position,
            index: u64::from(indices.as_flattened()[position]),
            count,
        }),
        None => Ok(()),
    }
}

/// The box of every triangle; empty, and so left out of the hierarchy, if the triangle is degenerate.
fn triangle_boxes(positions: &[DVec3], indices: &[[u32; 3]]) -> Vec<Bounds3> {
    let bounds = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|i| positions[i as usize]);
        match unit_normal(a, b, c) {
            Some(_) => Bounds3::from_points([a, b, c]),
            None => Bounds3::EMPTY,
        }
    };
    parallel_map(indices, PARALLEL_CHUNK, bounds)
}

impl RaySurface for Mesh {
    fn bounds(&self) -> Bounds3 {
        // A point of a triangle is a sum of its corners, with their roundings.
        let bounds = self.bvh.bounds();
        let rounding = bounds.min.abs().max(bounds.max.abs()) * gamma(8);
        Bounds3 { min: bounds.min - rounding, max: bounds.max + rounding }
    }

    fn intersect(&self, ray: &Ray, t_max: f64) -> Option<Hit> {
        self.query(ray, ClosestHit::before(t_max)).hit()
    }

    fn occluded(&self, ray: &Ray, t_max: f64) -> bool {
        self.query(ray, AnyHit::before(t_max)).found()
    }

    fn closest_batch(&self, rays: &[BoundedRay], hits: &mut Vec<Option<Hit>>) {
        let mut collectors: Vec<_> = rays.iter().map(|ray| ClosestHit::before(ray.t_max)).collect();
        self.bvh.isa().run(MeshBatch { mesh: self, rays, collectors: &mut collectors });
        hits.clear();
        hits.extend(collectors.into_iter().map(ClosestHit::hit));
    }

    fn occluded_batch(&self, rays: &[BoundedRay], occluded: &mut Vec<bool>) {
        let mut collectors: Vec<_> = rays.iter().map(|ray| AnyHit::before(ray.t_max)).collect();
        self.bvh.isa().run(MeshBatch { mesh: self, rays, collectors: &mut collectors });
        occluded.clear();
        occluded.extend(collectors.into_iter().map(AnyHit::found));
    }

    fn all_hits(&self, ray: &Ray, t_max: f64, hits: &mut Vec<Hit>) {
        let start = hits.len();
        self.query(ray, AllHits { t_max, hits });
        let Some(new) = hits.get_mut(start..) else { return };
        new.sort_unstable_by(|a, b| a.t.total_cmp(&b.t).then(a.face.cmp(&b.face)));
        self.drop_repeated(start, hits);
    }

    fn point(&self, _ray: &Ray, hit: &Hit) -> SurfacePoint {
        self.point_at(hit.face, hit.u, hit.v)
    }

    #[inline]
    fn shading_point(&self, _ray: &Ray, hit: &Hit) -> ShadingPoint {
        self.shading_point_at(hit.face, hit.u, hit.v)
    }

    fn normal_derivatives(&self, hit: &Hit, point: &SurfacePoint) -> [DVec3; 2] {
        self.normal_derivatives_at(hit.face, hit.u, hit.v, point.shading_normal)
    }

    fn uv_rates(&self, hit: &Hit) -> [DVec2; 2] {
        self.uv_rates_at(hit.face)
    }

    fn sample(&self, xi: DVec2) -> Option<SurfaceSample> {
        self.sample_point(xi)
    }

    #[inline]
    fn sample_area(&self, xi: DVec2) -> Option<AreaSample> {
        self.sample_area_point(xi)
    }

    fn area_pdf(&self, _hit: &Hit, _point: &SurfacePoint) -> Option<AreaPdf> {
        let area = self.area();
        (area > 0.0).then(|| AreaPdf(1.0 / area))
    }
}
