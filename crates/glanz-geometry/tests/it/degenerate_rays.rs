//! Rays with NaN, infinite origins or zero directions hit nothing and never cause a panic.

use std::f64::consts::TAU;

use glanz_geometry::RaySurface;
use glanz_geometry::algebraic::{AlgebraicSurface, PolynomialTerm};
use glanz_geometry::bilinear::BilinearPatch;
use glanz_geometry::cuboid::Cuboid;
use glanz_geometry::polyhedron::{HalfSpace, Polyhedron};
use glanz_geometry::torus::Torus;
use glanz_geometry::triangle::Triangle;
use glanz_math::{Bounds3, DVec3, Ray};

fn surfaces() -> Vec<(&'static str, Box<dyn RaySurface>)> {
    let (o, x, y) = (DVec3::ZERO, DVec3::X, DVec3::Y);
    let terms = [([4, 0, 0], 1.0), ([0, 4, 0], 1.0), ([0, 0, 2], 1.0), ([0; 3], -0.5)]
        .map(|(exponents, coefficient)| PolynomialTerm { exponents, coefficient });
    let planes: Vec<HalfSpace> = DVec3::AXES
        .into_iter()
        .flat_map(|a| [a, -a])
        .map(|normal| HalfSpace { normal, distance: 1.0 })
        .collect();
    vec![
        ("torus", Box::new(Torus::try_new(1.0, 0.4, TAU).unwrap())),
        (
            "algebraic",
            Box::new(AlgebraicSurface::try_new(&terms, Bounds3::new(-DVec3::ONE, DVec3::ONE)).unwrap()),
        ),
        ("cuboid", Box::new(Cuboid::try_new(-DVec3::ONE, DVec3::ONE).unwrap())),
        ("polyhedron", Box::new(Polyhedron::try_new(&planes).unwrap())),
        ("triangle", Box::new(Triangle::try_new(o, x, y).unwrap())),
        ("bilinear", Box::new(BilinearPatch::try_new(o, x, y, x + y + DVec3::Z).unwrap())),
    ]
}

#[test]
fn degenerate_rays_hit_nothing_and_extreme_ones_give_finite_hits() {
    let values = [
        0.0,
        -0.0,
        0.3,
        1.0,
        -1.0,
        1e-300,
        -1e-320,
        1e200,
        f64::MAX,
        f64::INFINITY,
        -f64::INFINITY,
        f64::NAN,
    ];
    // Every 37th combination of six coordinates out of these values.
    let total = values.len().pow(6);
    for (name, surface) in surfaces() {
        let mut hits = Vec::new();
        for number in (0..total).step_by(37) {
            let mut rest = number;
            let mut next = || {
                let value = values[rest % values.len()];
                rest /= values.len();
                value
            };
            let ray = Ray::new(DVec3::new(next(), next(), next()), DVec3::new(next(), next(), next()));
            hits.clear();
            surface.all_hits(&ray, f64::INFINITY, &mut hits);
            let first = surface.intersect(&ray, f64::INFINITY);
            let degenerate =
                !ray.origin.is_finite() || ray.direction.is_nan() || ray.direction == DVec3::ZERO;
            assert!(!degenerate || (hits.is_empty() && first.is_none()), "{name}: {hits:?} on {ray:?}");
            for hit in hits.iter().chain(&first) {
                assert!(hit.t > 0.0 && hit.u.is_finite() && hit.v.is_finite(), "{name}: {hit:?} on {ray:?}");
                let point = surface.point(&ray, hit);
                assert!((point.normal.length() - 1.0).abs() < 1e-12, "{name}: {point:?} on {ray:?}");
                assert!(
                    point.position.is_finite() && point.error.is_finite(),
                    "{name}: {point:?} on {ray:?}"
                );
            }
        }
    }
}
