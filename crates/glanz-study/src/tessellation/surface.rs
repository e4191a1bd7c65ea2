//! Wavy surfaces, and their tessellation.

use glanz_geometry::SurfaceError;
use glanz_geometry::mesh::Mesh;
use glanz_geometry::spline::{KnotVector, NurbsSurface};
use glanz_math::DVec3;
use glanz_math::glam::DVec4;
use glanz_scene::description::{GeometryDescription, ShapeDescription};

/// Control points along each side: eight by eight bicubic patches.
const POINTS: usize = 11;

const DEGREE: usize = 3;

/// Position, size and wave phase of a surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct SurfacePlacement {
    center: DVec3,
    /// Half of a side, metres.
    half: f64,
    /// Phase of the waves, radians.
    phase: f64,
}

/// One surface, or three smaller ones side by side.
pub(super) fn placements(count: usize) -> Vec<SurfacePlacement> {
    if count == 1 {
        return vec![SurfacePlacement { center: DVec3::ZERO, half: 1.0, phase: 0.0 }];
    }
    let first = -0.5 * (count - 1) as f64;
    let place = |i: usize| {
        let center = DVec3::new(0.95 * (first + i as f64), 0.1 * i as f64, 0.0);
        SurfacePlacement { center, half: 0.45, phase: 1.7 * i as f64 }
    };
    (0..count).map(place).collect()
}

/// The uniform bicubic B-spline surface of a place; u along x, v along y.
pub(super) fn wavy(place: &SurfacePlacement) -> Result<NurbsSurface, SurfaceError> {
    let knots = KnotVector::clamped_uniform(DEGREE, POINTS)?;
    let side = knots.greville();
    let span = |s: f64| 2.0 * s - 1.0;
    let [low, high] = knots.domain();
    let point = |s: f64, t: f64| {
        let (x, y) = (span((s - low) / (high - low)), span((t - low) / (high - low)));
        let z = 0.30 * (3.1 * x + place.phase).sin() * (2.7 * y).cos()
            + 0.10 * (6.0 * x - 4.0 * y + place.phase).sin();
        (place.center + place.half * DVec3::new(x, y, z)).extend(1.0)
    };
    let points: Vec<DVec4> =
        side.iter().flat_map(|&s| side.iter().map(move |&t| (s, t))).map(|(s, t)| point(s, t)).collect();
    NurbsSurface::from_knots(knots.clone(), knots, points)
}

/// Memory of the exact surface, bytes.
pub(super) fn exact_bytes(surface: &NurbsSurface) -> Result<usize, SurfaceError> {
    Ok(surface.to_freeform()?.bytes())
}

/// Triangles on a regular grid of parameters, with the surface's normals at the vertices.
#[derive(Clone, Debug)]
pub(super) struct Tessellation {
    positions: Vec<DVec3>,
    normals: Vec<DVec3>,
    indices: Vec<[u32; 3]>,
}

impl Tessellation {
    /// 2 n^2 triangles, as in document 002 section 7, with normals at the vertices.
    pub(super) fn of(surface: &NurbsSurface, n: u32) -> Self {
        let at = |[low, high]: [f64; 2], i: u32| low + (high - low) * f64::from(i) / f64::from(n);
        let (domain_u, domain_v) = (surface.knots_u().domain(), surface.knots_v().domain());
        let count = (n as usize + 1).pow(2);
        let (mut positions, mut normals) = (Vec::with_capacity(count), Vec::with_capacity(count));
        for (i, j) in (0..=n).flat_map(|i| (0..=n).map(move |j| (i, j))) {
            // One evaluation gives point and normal.
            let (point, by_u, by_v) = surface.tangents(at(domain_u, i), at(domain_v, j));
            positions.push(point);
            normals.push(by_u.cross(by_v).normalize_or_zero());
        }
        let mut indices = Vec::with_capacity(2 * (n as usize).pow(2));
        for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
            let corner = i * (n + 1) + j;
            let (along, across) = (corner + n + 1, corner + 1);
            indices.push([corner, along, along + 1]);
            indices.push([corner, along + 1, across]);
        }
        Self { positions, normals, indices }
    }

    /// The description of the mesh for a scene.
    pub(super) fn description(self) -> ShapeDescription {
        let Self { positions, normals, indices } = self;
        GeometryDescription::Triangles { positions, indices, normals: Some(normals), uvs: None }.into()
    }

    /// Memory of the mesh, bytes.
    pub(super) fn bytes(self) -> Result<usize, SurfaceError> {
        let Self { positions, normals, indices } = self;
        Ok(Mesh::try_new(positions, indices, Some(normals), None)?.bytes())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn triangles_are_twice_a_square_and_turn_as_the_surface_does() {
        let surface = wavy(&placements(1)[0]).unwrap();
        let triangles = Tessellation::of(&surface, 25);
        assert_eq!((triangles.indices.len(), triangles.positions.len()), (1250, 26 * 26));
        for t in &triangles.indices {
            let [a, b, c] = t.map(|i| triangles.positions[i as usize]);
            let normal = (b - a).cross(c - a).normalize();
            assert!(t.iter().all(|&i| normal.dot(triangles.normals[i as usize]) > 0.9));
        }
    }

    #[test]
    fn no_surface_is_steep_enough_to_shade_itself() {
        // The light of the pictures stands 60 degrees above the horizon or higher.
        for count in [1, 3] {
            for place in placements(count) {
                let triangles = Tessellation::of(&wavy(&place).unwrap(), 40);
                assert!(triangles.normals.iter().all(|n| n.z > 35.0_f64.to_radians().sin()));
            }
        }
    }
}
