//! Rays per second of every kind of surface: `cargo bench -p glanz-geometry --bench surfaces`.
//!
//! Rays start anywhere on a sphere of three sizes and aim at a point of the surface's box drawn at random, so that hits and misses
//! mix; the fraction of hits is part of the name. Only the closest hit is measured, without the point and its derivatives.

use std::f64::consts::TAU;
use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glanz_geometry::algebraic::{AlgebraicSurface, PolynomialTerm};
use glanz_geometry::bilinear::BilinearPatch;
use glanz_geometry::cuboid::Cuboid;
use glanz_geometry::polyhedron::{HalfSpace, Polyhedron};
use glanz_geometry::quadric::{
    Cone, Cylinder, Disk, Hyperboloid, Paraboloid, Plane, Sphere, TwoSheetedHyperboloid,
};
use glanz_geometry::torus::Torus;
use glanz_geometry::triangle::Triangle;
use glanz_geometry::{RaySurface, Surface, SurfaceError};
use glanz_math::{Bounds3, DVec3, Ray};

const RAYS: usize = 4096;

/// Numbers uniform in [0, 1): splitmix64.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut x = self.0;
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((x ^ (x >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn point(&mut self, bounds: &Bounds3) -> DVec3 {
        bounds.min + bounds.diagonal() * DVec3::new(self.next(), self.next(), self.next())
    }

    fn direction(&mut self) -> DVec3 {
        let (z, phi) = (1.0 - 2.0 * self.next(), TAU * self.next());
        let r = (1.0 - z * z).sqrt();
        DVec3::new(r * phi.cos(), r * phi.sin(), z)
    }
}

fn rays(bounds: &Bounds3) -> Vec<Ray> {
    let mut random = Random(1);
    let radius = 3.0 * bounds.diagonal().length();
    (0..RAYS)
        .map(|_| {
            let origin = bounds.center() + radius * random.direction();
            Ray::new(origin, (random.point(bounds) - origin).normalize())
        })
        .collect()
}

fn algebraic(terms: &[([u32; 3], f64)], reach: f64) -> Result<Surface, SurfaceError> {
    let terms: Vec<PolynomialTerm> =
        terms.iter().map(|&(exponents, coefficient)| PolynomialTerm { exponents, coefficient }).collect();
    let clip = Bounds3::new(DVec3::splat(-reach), DVec3::splat(reach));
    Ok(AlgebraicSurface::try_new(&terms, clip)?.into())
}

/// Every kind of surface except the mesh, which has its own benchmark.
fn surfaces() -> Result<Vec<(&'static str, Surface)>, SurfaceError> {
    let corner = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    let octahedron: Vec<HalfSpace> = (0..8)
        .map(|i| {
            let sign = |bit: i32| if i & bit == 0 { 1.0 } else { -1.0 };
            HalfSpace { normal: corner(sign(1), sign(2), sign(4)), distance: 1.0 }
        })
        .collect();
    Ok(vec![
        ("sphere", Sphere::try_full(1.0)?.into()),
        ("sphere, clipped", Sphere::try_new(1.0, [-0.5, 0.8], 4.0)?.into()),
        ("cylinder", Cylinder::try_new(0.5, [-1.0, 1.0], TAU)?.into()),
        ("cone", Cone::try_new(0.7, 1.5, TAU)?.into()),
        ("paraboloid", Paraboloid::try_new(1.0, [0.0, 1.0], TAU)?.into()),
        ("hyperboloid", Hyperboloid::try_new(corner(1.0, 0.0, -1.0), corner(0.2, 0.9, 1.0), TAU)?.into()),
        ("two sheets", TwoSheetedHyperboloid::try_new(0.5, 0.5, [-1.5, 1.5], TAU)?.into()),
        ("disk", Disk::try_new(0.0, 1.0, 0.2, TAU)?.into()),
        ("plane", Plane::try_new([-1.0, 1.0], [-1.0, 1.0])?.into()),
        ("torus", Torus::try_new(1.0, 0.3, TAU)?.into()),
        (
            "algebraic, degree 2",
            algebraic(&[([2, 0, 0], 1.0), ([0, 2, 0], 2.0), ([0, 0, 2], 3.0), ([0, 0, 0], -1.0)], 1.2)?,
        ),
        (
            "algebraic, degree 3",
            algebraic(&[([3, 0, 0], 1.0), ([0, 3, 0], 1.0), ([0, 0, 3], 1.0), ([0, 0, 0], -0.2)], 1.0)?,
        ),
        (
            "algebraic, degree 4",
            algebraic(
                &[
                    ([4, 0, 0], 1.0),
                    ([0, 4, 0], 1.0),
                    ([0, 0, 4], 1.0),
                    ([2, 0, 0], -5.0),
                    ([0, 2, 0], -5.0),
                    ([0, 0, 2], -5.0),
                    ([0, 0, 0], 11.8),
                ],
                2.5,
            )?,
        ),
        ("polyhedron, 8 facets", Polyhedron::try_new(&octahedron)?.into()),
        ("box", Cuboid::try_new(DVec3::NEG_ONE, DVec3::ONE)?.into()),
        (
            "triangle",
            Triangle::try_new(corner(0.0, 0.0, 0.0), corner(1.0, 0.0, 0.3), corner(0.0, 1.0, 0.6))?.into(),
        ),
        (
            "bilinear patch",
            BilinearPatch::try_new(
                corner(0.0, 0.0, 0.0),
                corner(1.0, 0.0, 0.5),
                corner(0.0, 1.0, 0.4),
                corner(1.0, 1.0, -0.2),
            )?
            .into(),
        ),
    ])
}

fn closest_hit(criterion: &mut Criterion) {
    let surfaces = match surfaces() {
        Ok(surfaces) => surfaces,
        Err(error) => unreachable!("the parameters above are possible: {error}"),
    };
    let mut group = criterion.benchmark_group("surface, closest hit");
    group.throughput(Throughput::Elements(RAYS as u64));
    for (name, surface) in surfaces {
        let rays = rays(&surface.bounds());
        let hits = rays.iter().filter(|ray| surface.intersect(ray, f64::INFINITY).is_some()).count();
        let share = 100 * hits / RAYS;
        group.bench_function(format!("{name} ({share} % hits)"), |bencher| {
            bencher.iter(|| {
                rays.iter()
                    .filter_map(|ray| surface.intersect(black_box(ray), f64::INFINITY))
                    .map(|hit| hit.t)
                    .sum::<f64>()
            });
        });
    }
    group.finish();
}

criterion_group!(benches, closest_hit);
criterion_main!(benches);
