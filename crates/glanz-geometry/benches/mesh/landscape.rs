//! Meshes and rays for benchmarks, the same for Glanz and its peers.

use glanz_geometry::RaySurface;
use glanz_geometry::mesh::Mesh;
use glanz_math::rounding::offset_origin;
use glanz_math::{DVec3, Frame, Ray};

/// Numbers uniform in [0, 1): splitmix64.
pub(crate) struct Random(u64);

impl Random {
    /// The next one.
    pub(crate) fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Uniform over the unit sphere.
    pub(crate) fn direction(&mut self) -> DVec3 {
        let z = 2.0 * self.unit() - 1.0;
        let (sin, cos) = (std::f64::consts::TAU * self.unit()).sin_cos();
        let r = (1.0 - z * z).max(0.0).sqrt();
        DVec3::new(r * cos, r * sin, z)
    }
}

/// Vertices and triangles.
pub(crate) struct Model {
    /// Vertices; every coordinate is an `f32`, so that no peer gets a rounded copy.
    pub(crate) positions: Vec<DVec3>,
    /// Triangles.
    pub(crate) indices: Vec<[u32; 3]>,
}

/// A function over points of space with hills of several sizes.
fn hills(p: DVec3) -> f64 {
    (0..5)
        .map(|octave| {
            let f = 3.0 * f64::from(1 << octave);
            let phase = 1.7 * f64::from(octave);
            ((f * p.x + phase).sin() * (f * p.y - phase).cos() + (f * p.z + phase).sin()) * 0.25 / f
        })
        .sum()
}

fn to_f32(p: DVec3) -> DVec3 {
    DVec3::from_array(p.to_array().map(|x| f64::from(x as f32)))
}

/// A closed sphere of about unit radius with hills: an octahedron whose faces have `n^2` triangles each, `8 n^2` in all.
pub(crate) fn displaced_sphere(n: u32) -> Model {
    // A square sheet of (2 n + 1)^2 vertices folds over the octahedron; vertices of its rim meet in pairs.
    let side = 2 * n + 1;
    let corner = |i: u32, j: u32| {
        let (x, y) = (f64::from(i) / f64::from(n) - 1.0, f64::from(j) / f64::from(n) - 1.0);
        let z = 1.0 - x.abs() - y.abs();
        let fold = |a: f64, b: f64| (1.0 - b.abs()) * if a < 0.0 { -1.0 } else { 1.0 };
        let p = if z < 0.0 { DVec3::new(fold(x, y), fold(y, x), z) } else { DVec3::new(x, y, z) };
        let p = p.normalize();
        to_f32(p * (1.0 + hills(p)))
    };
    let mut positions = Vec::new();
    let mut indices = Vec::new();
    for j in 0..side {
        for i in 0..side {
            positions.push(corner(i, j));
        }
    }
    for j in 0..side - 1 {
        for i in 0..side - 1 {
            let [a, b] = [j * side + i, j * side + i + 1];
            let [c, d] = [a + side, b + side];
            // The diagonals follow the edges of the octahedron.
            if (i < n) == (j < n) {
                indices.extend([[a, b, c], [b, d, c]]);
            } else {
                indices.extend([[a, b, d], [a, d, c]]);
            }
        }
    }
    Model { positions, indices }
}

/// A square of hills, `2 n^2` triangles.
pub(crate) fn wavy_grid(n: u32) -> Model {
    let at = |i: u32| f64::from(i) / f64::from(n) * 2.0 - 1.0;
    let mut positions = Vec::new();
    let mut indices = Vec::new();
    for j in 0..=n {
        for i in 0..=n {
            let p = DVec3::new(at(i), at(j), 0.0);
            positions.push(to_f32(p.with_z(2.0 * hills(p))));
        }
    }
    for j in 0..n {
        for i in 0..n {
            let a = j * (n + 1) + i;
            let c = a + n + 1;
            indices.extend([[a, a + 1, c], [a + 1, c + 1, c]]);
        }
    }
    Model { positions, indices }
}

/// The rays of a camera, line by line, that sees the unit sphere.
pub(crate) fn camera_rays(width: u32, height: u32) -> Vec<Ray> {
    let eye = DVec3::new(1.2, -2.2, 1.4);
    let frame = Frame::from_z((-eye).normalize());
    let mut rays = Vec::new();
    for j in 0..height {
        for i in 0..width {
            let x = (f64::from(i) + 0.5) / f64::from(width) - 0.5;
            let y = (f64::from(j) + 0.5) / f64::from(height) - 0.5;
            rays.push(Ray::new(to_f32(eye), to_f32((frame.x * x + frame.y * y) * 0.9 + frame.z)));
        }
    }
    rays
}

/// Chords between random points of a sphere of radius 1.2.
pub(crate) fn random_rays(count: usize) -> Vec<Ray> {
    let mut random = Random(7);
    (0..count)
        .map(|_| {
            let (a, b) = (random.direction() * 1.2, random.direction() * 1.2);
            Ray::new(to_f32(a), to_f32((b - a).normalize()))
        })
        .collect()
}

/// Rays that leave the points where `rays` meet `mesh`, by the cosine of the angle to the normal.
pub(crate) fn bounced_rays(mesh: &Mesh, rays: &[Ray]) -> Vec<Ray> {
    let mut random = Random(8);
    let bounce = |ray: &Ray| {
        let hit = mesh.intersect(ray, f64::INFINITY)?;
        let point = mesh.point(ray, &hit);
        let normal = if point.normal.dot(ray.direction) < 0.0 { point.normal } else { -point.normal };
        let direction = (normal + random.direction()).try_normalize().unwrap_or(normal);
        // Far enough out that it is outside in f32 too.
        let origin = offset_origin(point.position, DVec3::splat(1e-5), normal, direction);
        Some(Ray::new(to_f32(origin), to_f32(direction)))
    };
    rays.iter().filter_map(bounce).collect()
}
