//! Accuracy of hits on surfaces of any size at any place.

use glanz_geometry::bezier::TensorPatch;
use glanz_geometry::freeform::{Freeform, SurfacePatch};
use glanz_geometry::{BoundedRay, Hit, RaySurface, SurfaceError};
use glanz_math::glam::DVec4;
use glanz_math::{DVec3, Ray};

/// A number between -1 and 1 that is a multiple of 2^-16: sums with multiples of 2^-16 up to 2^36 are exact.
fn grid(seed: u32) -> f64 {
    let x = seed.wrapping_mul(0x9e37_79b9) ^ (seed.wrapping_mul(0x85eb_ca6b) >> 13);
    f64::from((x >> 8) as u16) / 32768.0 - 1.0
}

/// Control points of about unit size, on the grid; with weights 1 or 2.
fn net((p, q): (usize, usize), rational: bool) -> Vec<DVec4> {
    let point = |k: usize| {
        let (i, j) = (k / (q + 1), k % (q + 1));
        let round = |x: f64| (x * 1024.0).round() / 1024.0;
        let (x, y) = (round(i as f64 / p as f64 - 0.5), round(j as f64 / q as f64 - 0.5));
        let w = if rational && (i + j) % 2 == 1 { 2.0 } else { 1.0 };
        DVec3::new(x, y, 0.25 * grid(k as u32 + 7)).extend(w)
    };
    (0..(p + 1) * (q + 1)).map(point).collect()
}

/// The surface of these points times `size` and moved by `offset`, whose coordinates are exact.
fn surface(degrees: (usize, usize), net: &[DVec4], size: f64, offset: DVec3) -> Freeform {
    let points = net.iter().map(|p| ((p.truncate() * size + offset) * p.w).extend(p.w));
    let patch = TensorPatch::try_new(degrees.0, degrees.1, points.collect()).unwrap();
    Freeform::try_new(vec![SurfacePatch::over_rectangle(patch, [0.0, 1.0], [0.0, 1.0]).unwrap()]).unwrap()
}

/// The point of a net by de Casteljau's algorithm.
fn point((p, q): (usize, usize), net: &[DVec4], u: f64, v: f64) -> DVec3 {
    let row = |points: Vec<DVec4>, x: f64| {
        let mut points = points;
        while points.len() > 1 {
            points = points.windows(2).map(|pair| pair[0] * (1.0 - x) + pair[1] * x).collect();
        }
        points[0]
    };
    let homogeneous = |p: &DVec4| (p.truncate() * p.w).extend(p.w);
    let rows = (0..=p).map(|i| row(net[i * (q + 1)..(i + 1) * (q + 1)].iter().map(homogeneous).collect(), v));
    let h = row(rows.collect(), u);
    h.truncate() / h.w
}

#[test]
fn hits_are_accurate_at_any_place_and_of_any_size() {
    let mut worst = [0.0_f64; 2];
    for (degrees, rational) in [((3, 3), false), ((3, 2), true), ((5, 4), false), ((6, 3), true)] {
        let net = net(degrees, rational);
        // Powers of two near 1e-6, 1 and 1e6; and near 0, 1e3 and 1e6 sizes, in no special direction.
        for size in [2.0_f64.powi(-20), 1.0, 2.0_f64.powi(20)] {
            for distance in [0.0, 1024.0, 1_048_576.0] {
                let offset = DVec3::new(1.0, -0.75, 0.375) * (distance * size);
                let surface = surface(degrees, &net, size, offset);
                let (mut rays, mut hits) = (Vec::new(), 0);
                for k in 0..200_u32 {
                    let near = |s: u32| DVec3::new(grid(s), grid(s + 1), grid(s + 2));
                    let target = near(6 * k + 1) * 0.4;
                    // From close by, and from the origin of the coordinates.
                    let from = if k % 2 == 0 { near(6 * k + 4) * 3.0 } else { -offset / size };
                    let (start, direction) = (from * size + offset, (target - from) * size);
                    let ray = Ray::new(start, direction);
                    rays.push(BoundedRay::from(ray));
                    let Some(Hit { t, u, v, .. }) = surface.intersect(&ray, f64::INFINITY) else { continue };
                    hits += 1;
                    // In units of the size about the offset, where every number is exact up to its own rounding.
                    let found = point(degrees, &net, u, v);
                    let along = (target - from).normalize();
                    let off = (found - target).cross(along).length();
                    let ahead = (found - target).dot(along) - (t - 1.0) * (target - from).length();
                    let position = surface.point(&ray, &Hit::new(t, u, v, 0));
                    let placed = (position.position - offset).distance(found * size) / size;
                    worst = [worst[0].max(off), worst[1].max(placed)];
                    // The ray parameter itself has 53 bits.
                    let length = (target - from).length();
                    assert!(
                        off < 1e-9 && ahead.abs() < 1e-9 + 4.0 * f64::EPSILON * length,
                        "{degrees:?} {size} {distance}: {off:e} {ahead:e}"
                    );
                    assert!(
                        placed < 1e-9 && placed * size <= position.error.length(),
                        "{degrees:?} {size} {distance}: {placed:e}"
                    );
                }
                assert!(hits > 40, "{hits}");
                assert_eq!(surface.undecided(), 0);
                let mut batch = Vec::new();
                surface.closest_batch(&rays, &mut batch);
                for (bounded, hit) in rays.iter().zip(batch) {
                    assert_eq!(hit, surface.intersect(&bounded.ray, f64::INFINITY));
                }
            }
        }
    }
    println!("off the ray by up to {:e}, position by {:e} of the size", worst[0], worst[1]);
}

#[test]
fn control_points_of_far_surfaces_are_kept() {
    let net = net((3, 3), false);
    let offset = DVec3::new(1e7, 0.3, -2e7);
    let patch: Vec<DVec4> = net.iter().map(|p| (p.truncate() * 0.1 + offset).extend(1.0)).collect();
    let tensor = TensorPatch::try_new(3, 3, patch.clone()).unwrap();
    let placed = SurfacePatch::over_rectangle(tensor, [0.0, 1.0], [0.0, 1.0]).unwrap();
    let surface = Freeform::try_new(vec![placed]).unwrap();
    assert_eq!(surface.patch(0).unwrap().patch().control_points(), patch);
    assert!(surface.bounds().min.distance(offset) < 1.0);
}

#[test]
fn sizes_that_overflow_are_refused() {
    let net = net((3, 3), false);
    let scaled = |size: f64| {
        let points = net.iter().map(|p| (p.truncate() * size).extend(1.0));
        let patch = TensorPatch::try_new(3, 3, points.collect()).unwrap();
        Freeform::try_new(vec![SurfacePatch::over_rectangle(patch, [0.0, 1.0], [0.0, 1.0]).unwrap()])
    };
    for size in [1e-25, 1e-200, 1e19, 1e160] {
        let refused = scaled(size);
        assert!(matches!(refused, Err(SurfaceError::OutOfRange { .. })), "{size:e}");
    }
    for size in [1e-17, 1e17] {
        let surface = scaled(size).unwrap();
        let ray = Ray::new(DVec3::new(0.1, 0.05, 3.0) * size, DVec3::NEG_Z);
        assert!(surface.intersect(&ray, f64::INFINITY).is_some(), "{size}");
    }
}
