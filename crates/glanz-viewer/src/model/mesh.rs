//! Triangles: meshes, surfaces of flat facets, and tubes around curves.

use std::collections::HashMap;
use std::f64::consts::TAU;
use std::ops::Range;

use glanz_geometry::Surface;
use glanz_geometry::curve::FacingCurve;
use glanz_geometry::mesh::Mesh;
use glanz_geometry::triangle::unit_normal;
use glanz_math::{Bounds3, DVec3};

use super::error::{ModelError, number};
use super::head;
use super::surfaces::{BuiltSurface, Surfaces};

/// Parts of a segment of a curve, and sides of the tube that stands for it.
const CURVE_STEPS: u32 = 8;
const TUBE_SIDES: u32 = 6;

/// Sine of the angle to a curve from which a direction has a part across it that is more than rounding.
const LEAST_SINE: f64 = 1e-3;

/// Triangles of one surface, in its own frame.
#[derive(Default)]
struct MeshBuilder {
    positions: Vec<DVec3>,
    normals: Vec<DVec3>,
    indices: Vec<[u32; 3]>,
}

impl MeshBuilder {
    fn vertex(&mut self, position: DVec3, normal: DVec3) -> Result<u32, ModelError> {
        self.positions.push(position);
        self.normals.push(normal);
        number("vertices", self.positions.len() - 1)
    }
}

impl Surfaces {
    /// The triangles `faces` of a mesh. Those without normals at their vertices have vertices of their own.
    pub(super) fn mesh(&mut self, mesh: &Mesh, faces: Range<usize>) -> Result<BuiltSurface, ModelError> {
        let mut triangles = MeshBuilder::default();
        let mut shared: HashMap<u32, u32> = HashMap::new();
        for corners in mesh.indices().get(faces).unwrap_or_default() {
            let [Some(a), Some(b), Some(c)] = corners.map(|i| mesh.position(i)) else {
                continue;
            };
            // A triangle without an area is never met by rays either.
            let Some(flat) = unit_normal(a, b, c) else { continue };
            let given = corners.map(|i| mesh.normal(i).and_then(DVec3::try_normalize));
            let mut indices = [0; 3];
            if let [Some(na), Some(nb), Some(nc)] = given {
                let corner = corners.iter().zip([(a, na), (b, nb), (c, nc)]);
                for (slot, (&vertex, (position, normal))) in indices.iter_mut().zip(corner) {
                    *slot = match shared.get(&vertex) {
                        Some(&known) => known,
                        None => triangles.vertex(position, normal)?,
                    };
                    shared.insert(vertex, *slot);
                }
            } else {
                for (slot, position) in indices.iter_mut().zip([a, b, c]) {
                    *slot = triangles.vertex(position, flat)?;
                }
            }
            triangles.indices.push(indices);
        }
        self.push_mesh(&triangles)
    }

    /// A surface of flat facets.
    pub(super) fn flat(&mut self, surface: &Surface) -> Result<BuiltSurface, ModelError> {
        let mut triangles = MeshBuilder::default();
        for face in 0..surface.faces() {
            let corners = surface.face_domain(face).corners();
            let mut first = None;
            for corner in corners {
                let Some(at) = surface.untrimmed_at(face, corner) else { continue };
                let vertex = triangles.vertex(at.position, at.normal)?;
                let first = *first.get_or_insert(vertex);
                if vertex >= first + 2 {
                    triangles.indices.push([first, vertex - 1, vertex]);
                }
            }
        }
        self.push_mesh(&triangles)
    }

    /// A tube around a curve that faces every ray.
    pub(super) fn tube(&mut self, curve: &FacingCurve) -> Result<BuiltSurface, ModelError> {
        let mut triangles = MeshBuilder::default();
        let mut side = DVec3::X;
        for (number, &[a, b, c, d]) in (0..).zip(curve.segments()) {
            for step in 0..=CURVE_STEPS {
                let u = f64::from(step) / f64::from(CURVE_STEPS);
                let [ab, bc, cd] = [a.lerp(b, u), b.lerp(c, u), c.lerp(d, u)];
                let [before, after] = [ab.lerp(bc, u), bc.lerp(cd, u)];
                let along = (after - before).try_normalize().or_else(|| (d - a).try_normalize());
                let along = along.unwrap_or(DVec3::Z);
                // The nearest side to the one before, so that the tube is not twisted.
                let across = side.reject_from_normalized(along);
                side = match across.length() > LEAST_SINE {
                    true => across.normalize(),
                    false => along.any_orthonormal_vector(),
                };
                let center = before.lerp(after, u);
                for corner in 0..TUBE_SIDES {
                    let (sin, cos) = (TAU * f64::from(corner) / f64::from(TUBE_SIDES)).sin_cos();
                    let normal = cos * side + sin * along.cross(side);
                    let vertex = triangles.vertex(center + 0.5 * curve.width(number, u) * normal, normal)?;
                    if step > 0 {
                        let next = if corner + 1 < TUBE_SIDES { vertex + 1 } else { vertex + 1 - TUBE_SIDES };
                        let [below, next_below] = [vertex, next].map(|vertex| vertex - TUBE_SIDES);
                        triangles.indices.extend([[below, next_below, vertex], [next_below, next, vertex]]);
                    }
                }
            }
        }
        self.push_mesh(&triangles)
    }

    fn push_mesh(&mut self, triangles: &MeshBuilder) -> Result<BuiltSurface, ModelError> {
        let blocks = &mut self.blocks;
        let bounds = Bounds3::from_points(triangles.positions.iter().copied());
        let origin = if bounds.is_empty() { DVec3::ZERO } else { bounds.center() };
        let (first_vertex, first_triangle) = (blocks.positions.len(), blocks.indices.len());
        let single = |v: DVec3| v.to_array().map(|x| x as f32);
        blocks.positions.extend(triangles.positions.iter().map(|&p| single(p - origin)));
        blocks.normals.extend(triangles.normals.iter().map(|&n| single(n)));
        blocks.indices.extend(&triangles.indices);
        number("indices of triangles", 3 * blocks.indices.len())?;
        self.head.push(head::ModelSurface::Mesh {
            first_vertex,
            vertices: triangles.positions.len(),
            first_index: 3 * first_triangle,
            indices: 3 * triangles.indices.len(),
            origin: origin.to_array(),
        });
        Ok(BuiltSurface { surface: self.head.len() - 1, origin, unit: 1.0 })
    }
}
