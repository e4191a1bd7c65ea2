//! Surfaces whose crossings are known in closed form.

use super::*;
use crate::torus::Torus;
use glanz_math::rounding::offset_origin;

fn term(exponents: [u32; 3], coefficient: f64) -> PolynomialTerm {
    PolynomialTerm { exponents, coefficient }
}

/// |p - c|^2 = r^2.
fn sphere_terms(c: DVec3, r: f64) -> Vec<PolynomialTerm> {
    vec![
        term([2, 0, 0], 1.0),
        term([0, 2, 0], 1.0),
        term([0, 0, 2], 1.0),
        term([1, 0, 0], -2.0 * c.x),
        term([0, 1, 0], -2.0 * c.y),
        term([0, 0, 1], -2.0 * c.z),
        term([0, 0, 0], c.length_squared() - r * r),
    ]
}

/// (|p|^2 + R^2 - r^2)^2 = 4 R^2 (x^2 + y^2)
fn torus_terms(major: f64, minor: f64) -> Vec<PolynomialTerm> {
    let a = major * major - minor * minor;
    let b = 4.0 * major * major;
    vec![
        term([4, 0, 0], 1.0),
        term([0, 4, 0], 1.0),
        term([0, 0, 4], 1.0),
        term([2, 2, 0], 2.0),
        term([0, 2, 2], 2.0),
        term([2, 0, 2], 2.0),
        term([2, 0, 0], 2.0 * a - b),
        term([0, 2, 0], 2.0 * a - b),
        term([0, 0, 2], 2.0 * a),
        term([0, 0, 0], a * a),
    ]
}

fn cube(half: f64) -> Bounds3 {
    Bounds3::new(DVec3::splat(-half), DVec3::splat(half))
}

fn all(surface: &impl RaySurface, ray: &Ray) -> Vec<Hit> {
    let mut hits = Vec::new();
    surface.all_hits(ray, f64::INFINITY, &mut hits);
    hits
}

#[test]
fn sphere_is_hit_at_the_roots_of_the_quadratic() {
    let center = DVec3::new(3.0, -2.0, 5.0);
    let bounds = Bounds3::new(center - 2.5, center + 2.0);
    let sphere = AlgebraicSurface::try_new(&sphere_terms(center, 1.5), bounds).unwrap();
    let ray = Ray::new(center - DVec3::new(0.0, 0.9, 10.0), DVec3::Z * 2.0);
    let hits = all(&sphere, &ray);
    // Half chord sqrt(1.5^2 - 0.9^2) = 1.2.
    assert!((hits[0].t - 4.4).abs() < 1e-14 && (hits[1].t - 5.6).abs() < 1e-14);
    let point = sphere.point(&ray, &hits[0]);
    assert!((point.normal - DVec3::new(0.0, -0.6, -0.8)).length() < 1e-14);
    // Curvature 1 / r: the normal turns with the position.
    let [dndu, dndv] = sphere.normal_derivatives(&hits[0], &point);
    assert!((dndu - point.dpdu / 1.5).length() < 1e-13);
    assert!((dndv - point.dpdv / 1.5).length() < 1e-13);
    assert!(point.dpdu.dot(point.normal).abs() < 1e-14 && point.dpdu.length() > 1.0);
}

#[test]
fn quartic_and_torus_are_the_same_surface() {
    let algebraic = AlgebraicSurface::try_new(&torus_terms(2.0, 0.7), cube(3.0)).unwrap();
    let torus = Torus::try_new(2.0, 0.7, TAU).unwrap();
    let mut hits = 0;
    for i in 0..20_000 {
        let t = f64::from(i);
        let origin = DVec3::new((t * 1.1).sin(), (t * 2.3).cos(), (t * 0.7).sin()) * (1.0 + t % 9.0);
        let target = DVec3::new((t * 3.1).sin(), (t * 1.9).cos(), 0.3 * (t * 5.7).sin()) * 2.0;
        let ray = Ray::new(origin, target - origin);
        let (a, b) = (all(&algebraic, &ray), all(&torus, &ray));
        assert_eq!(a.len(), b.len(), "{ray:?}");
        for (a, b) in a.iter().zip(&b) {
            let (p, q) = (algebraic.point(&ray, a), torus.point(&ray, b));
            assert!((p.position - q.position).length() < 1e-10, "{p:?} {q:?}");
            assert!((p.normal - q.normal).length() < 1e-7);
            hits += 1;
        }
    }
    assert!(hits > 20_000);
}

#[test]
fn far_from_the_origin_the_digits_are_kept() {
    // A ball of 1 mm at 1 km. 1e6 - 1e-6 is rounded, and known to 6e-11: the radius to 3e-8 m. The surface of the
    // coefficients as they are is exact to the rounding of positions at 1 km.
    let center = DVec3::new(1000.0, 0.0, 0.0);
    let terms = sphere_terms(center, 1e-3);
    let r2 = 1e6 - terms[6].coefficient;
    let ball = AlgebraicSurface::try_new(&terms, Bounds3::new(center - 2e-3, center + 2e-3)).unwrap();
    let ray = Ray::new(center - DVec3::new(1.0, 0.0, 0.0), DVec3::X);
    let hits = all(&ball, &ray);
    assert_eq!(hits.len(), 2);
    assert!((hits[0].t - (1.0 - r2.sqrt())).abs() < 1e-12);
    assert!((hits[1].t - (1.0 + r2.sqrt())).abs() < 1e-12);
}

#[test]
fn surface_is_cut_open_where_it_leaves_the_box() {
    // The cylinder x^2 + y^2 = 1 in a box from z = 0 to 1.
    let terms = [term([2, 0, 0], 1.0), term([0, 2, 0], 1.0), term([0, 0, 0], -1.0)];
    let bounds = Bounds3::new(DVec3::new(-2.0, -2.0, 0.0), DVec3::new(2.0, 2.0, 1.0));
    let tube = AlgebraicSurface::try_new(&terms, bounds).unwrap();
    let across = |z: f64| all(&tube, &Ray::new(DVec3::new(-5.0, 0.0, z), DVec3::X)).len();
    assert_eq!((across(0.5), across(-0.1), across(1.1)), (2, 0, 0));
    assert!(all(&tube, &Ray::new(DVec3::new(0.3, 0.2, -4.0), DVec3::Z)).is_empty());
    let slanted = Ray::new(DVec3::new(-2.0, 0.0, -0.5), DVec3::new(1.0, 0.0, 0.5));
    // At x = -1 it is at z = 0, on the border; at x = 1 at z = 1.
    assert_eq!(all(&tube, &slanted).iter().map(|h| h.t).collect::<Vec<_>>(), [1.0, 3.0]);
}

#[test]
fn leaving_ray_hits_a_ball_once_from_inside_and_not_from_outside() {
    for (center, r) in [(DVec3::ZERO, 1.0), (DVec3::new(20.0, 3.0, -8.0), 0.5), (DVec3::ONE, 1e4)] {
        let ball = AlgebraicSurface::try_new(
            &sphere_terms(center, r),
            Bounds3::new(center - 1.5 * r, center + 1.2 * r),
        )
        .unwrap();
        for i in 0..10_000 {
            let t = f64::from(i);
            let n = DVec3::new((t * 1.1).sin(), (t * 2.3).cos(), (t * 0.7).sin()).normalize();
            let ray = Ray::new(center, n);
            let p = ball.point(&ray, &ball.intersect(&ray, f64::INFINITY).unwrap());
            let n = p.normal;
            let tangent = n.any_orthonormal_vector();
            let out = tangent + n * 10.0_f64.powi(-(i % 16));
            let origin = offset_origin(p.position, p.error, p.normal, out);
            assert_eq!(all(&ball, &Ray::new(origin, out)), [], "{p:?}");
            let inward = tangent - n * 10.0_f64.powi(-(i % 7));
            let origin = offset_origin(p.position, p.error, p.normal, inward);
            assert_eq!(all(&ball, &Ray::new(origin, inward)).len(), 1);
        }
    }
}

#[test]
fn singular_point_has_a_normal_and_a_small_error() {
    // The apex of the cone x^2 + y^2 = z^2.
    let terms = [term([2, 0, 0], 1.0), term([0, 2, 0], 1.0), term([0, 0, 2], -1.0)];
    let cone = AlgebraicSurface::try_new(&terms, cube(1.0)).unwrap();
    let ray = Ray::new(DVec3::new(-3.0, 0.0, 0.0), DVec3::X);
    let hits = all(&cone, &ray);
    assert_eq!(hits.len(), 1);
    let point = cone.point(&ray, &hits[0]);
    assert!((point.normal.length() - 1.0).abs() < 1e-15);
    assert!(point.position.length() < 1e-15 && point.error.max_element() < 1e-9);
    assert!(point.dpdu.is_finite() && cone.normal_derivatives(&hits[0], &point)[0].is_finite());
}

#[test]
fn constants_high_degrees_and_flat_boxes_are_refused() {
    let one = |e| [term(e, 1.0)];
    assert!(matches!(
        AlgebraicSurface::try_new(&one([0; 3]), cube(1.0)),
        Err(SurfaceError::Degenerate { .. })
    ));
    assert!(matches!(AlgebraicSurface::try_new(&[], cube(1.0)), Err(SurfaceError::Degenerate { .. })));
    let cancelled = [term([1, 0, 0], 2.0), term([1, 0, 0], -2.0), term([0; 3], 1.0)];
    assert!(matches!(AlgebraicSurface::try_new(&cancelled, cube(1.0)), Err(SurfaceError::Degenerate { .. })));
    assert_eq!(
        AlgebraicSurface::try_new(&one([2, 2, 1]), cube(1.0)),
        Err(SurfaceError::DegreeTooHigh { parameter: "the polynomial", degree: 5, max: 4 })
    );
    let flat = Bounds3::new(DVec3::ZERO, DVec3::new(1.0, 0.0, 1.0));
    assert!(matches!(
        AlgebraicSurface::try_new(&one([1, 0, 0]), flat),
        Err(SurfaceError::NotPositive { .. })
    ));
    assert!(matches!(
        AlgebraicSurface::try_new(&one([1, 0, 0]), Bounds3::EMPTY),
        Err(SurfaceError::NotFinite { .. } | SurfaceError::NotPositive { .. })
    ));
    let nan = [term([1, 0, 0], f64::NAN)];
    assert!(matches!(AlgebraicSurface::try_new(&nan, cube(1.0)), Err(SurfaceError::NotFinite { .. })));
}
