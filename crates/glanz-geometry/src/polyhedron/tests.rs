//! Platonic solids, whose areas and volumes are known, and invalid half-spaces.

use super::*;
use glanz_math::rounding::offset_origin;

fn around(normals: &[DVec3], distance: f64, center: DVec3) -> Vec<HalfSpace> {
    normals
        .iter()
        .map(|&n| {
            let normal = n.normalize();
            HalfSpace { normal, distance: distance + normal.dot(center) }
        })
        .collect()
}

fn cube() -> Vec<DVec3> {
    DVec3::AXES.iter().flat_map(|&a| [a, -a]).collect()
}

fn octahedron() -> Vec<DVec3> {
    (0..8).map(|i| DVec3::from([1, 2, 4].map(|bit| if i & bit == 0 { 1.0 } else { -1.0 }))).collect()
}

fn dodecahedron() -> Vec<DVec3> {
    let golden = f64::midpoint(1.0, 5.0_f64.sqrt());
    let mut normals = Vec::new();
    for a in [1.0, -1.0] {
        for b in [golden, -golden] {
            normals.extend([DVec3::new(0.0, a, b), DVec3::new(a, b, 0.0), DVec3::new(b, 0.0, a)]);
        }
    }
    normals
}

#[test]
fn platonic_solids_have_their_facets_areas_and_volumes() {
    // For inradius 1: volume = area / 3, and the area from the edge that belongs to the inradius.
    let sqrt3 = 3.0_f64.sqrt();
    let sqrt5 = 5.0_f64.sqrt();
    // Dodecahedron: inradius = a/2 sqrt((25 + 11 sqrt 5) / 10), area = 3 sqrt(25 + 10 sqrt 5) a^2.
    let a = 2.0 / ((25.0 + 11.0 * sqrt5) / 10.0).sqrt();
    let dodecahedral = 3.0 * (25.0 + 10.0 * sqrt5).sqrt() * a * a;
    // Octahedron: inradius = a / sqrt 6, area = 2 sqrt 3 a^2.
    for (normals, vertices, corners, area) in
        [(cube(), 8, 4, 24.0), (octahedron(), 6, 3, 12.0 * sqrt3), (dodecahedron(), 20, 5, dodecahedral)]
    {
        for center in [DVec3::ZERO, DVec3::new(3.0, -70.0, 0.2)] {
            let solid = Polyhedron::try_new(&around(&normals, 1.0, center)).unwrap();
            assert_eq!(solid.facets().len(), normals.len());
            assert_eq!(solid.vertices().len(), vertices);
            assert!(solid.facets().iter().all(|f| f.corners().len() == corners));
            assert!((solid.area() - area).abs() < 1e-12 * area);
            assert!((solid.volume() - area / 3.0).abs() < 1e-12 * area);
            for f in solid.facets() {
                let p: Vec<DVec3> = f.corners().iter().map(|&i| solid.vertices()[i]).collect();
                assert!(
                    (p[1] - p[0]).cross(p[2] - p[1]).dot(f.half_space().normal) > 0.0,
                    "counterclockwise"
                );
            }
        }
    }
}

#[test]
fn redundant_half_spaces_are_dropped() {
    let mut planes = around(&cube(), 1.0, DVec3::ZERO);
    // Far away; touching an edge; touching a corner; a duplicate; a larger duplicate.
    let diagonal = DVec3::new(1.0, 1.0, 0.0);
    planes.insert(2, HalfSpace { normal: diagonal, distance: 5.0 });
    planes.push(HalfSpace { normal: diagonal, distance: 2.0 });
    planes.push(HalfSpace { normal: DVec3::ONE, distance: 3.0 });
    planes.push(HalfSpace { normal: DVec3::X * 7.0, distance: 7.0 });
    planes.push(HalfSpace { normal: DVec3::X, distance: 8.0 });
    let solid = Polyhedron::try_new(&planes).unwrap();
    assert_eq!(solid.facets().len(), 6);
    assert_eq!(solid.facets()[0].half_space().normal, DVec3::X);
    assert_eq!(solid.facets()[5].half_space().normal, -DVec3::Z);
    assert!((solid.area() - 24.0).abs() < 1e-13);
}

#[test]
fn long_wedges_are_bounded() {
    // A roof of slope 1e-6 over the unit square: its ridge is 1e6 times as far apart as the base is wide.
    let slope = 1e-6;
    let planes = [
        HalfSpace { normal: -DVec3::Z, distance: 0.0 },
        HalfSpace { normal: DVec3::new(slope, 0.0, 1.0), distance: 1.0 },
        HalfSpace { normal: DVec3::new(-slope, 0.0, 1.0), distance: 1.0 },
        HalfSpace { normal: DVec3::Y, distance: 0.5 },
        HalfSpace { normal: -DVec3::Y, distance: 0.5 },
    ];
    let solid = Polyhedron::try_new(&planes).unwrap();
    // A prism with a triangle of base 2e6 and height 1.
    assert!((solid.volume() - 1e6).abs() < 1e-6 * 1e6);
    assert_eq!(solid.vertices().len(), 6);
}

#[test]
fn unbounded_empty_and_flat_intersections_are_refused() {
    let open = around(&cube()[..5], 1.0, DVec3::ZERO);
    match Polyhedron::try_new(&open) {
        Err(SurfaceError::Unbounded { direction }) => assert_eq!(direction, [0.0, 0.0, -1.0]),
        other => panic!("{other:?}"),
    }
    let tube: Vec<_> = around(&[DVec3::X, -DVec3::X, DVec3::Y, -DVec3::Y], 1.0, DVec3::ZERO);
    assert!(matches!(Polyhedron::try_new(&tube), Err(SurfaceError::Unbounded { .. })));
    let three = around(&[DVec3::X, -DVec3::X, DVec3::Y], 1.0, DVec3::ZERO);
    assert!(matches!(Polyhedron::try_new(&three), Err(SurfaceError::TooFew { count: 3, .. })));
    let empty = around(&cube(), -1.0, DVec3::ZERO);
    assert!(matches!(Polyhedron::try_new(&empty), Err(SurfaceError::Degenerate { .. })));
    let mut flat = around(&cube(), 1.0, DVec3::ZERO);
    flat[1].distance = -1.0;
    assert!(matches!(Polyhedron::try_new(&flat), Err(SurfaceError::Degenerate { .. })));
    let point = around(&octahedron(), 0.0, DVec3::ONE);
    assert!(matches!(Polyhedron::try_new(&point), Err(SurfaceError::Degenerate { .. })));
    let mut bad = around(&cube(), 1.0, DVec3::ZERO);
    bad[0].normal = DVec3::ZERO;
    assert!(matches!(Polyhedron::try_new(&bad), Err(SurfaceError::NotPositive { .. })));
}

#[test]
fn ray_through_the_middle_enters_and_leaves_opposite_facets() {
    let center = DVec3::new(1.0, 2.0, 3.0);
    let solid = Polyhedron::try_new(&around(&dodecahedron(), 1.0, center)).unwrap();
    for (i, f) in solid.facets().iter().enumerate() {
        let n = f.half_space().normal;
        let ray = Ray::new(center - 5.0 * n, 2.0 * n);
        let mut hits = Vec::new();
        solid.all_hits(&ray, f64::INFINITY, &mut hits);
        assert_eq!(hits.len(), 2);
        assert!((hits[0].t - 2.0).abs() < 1e-14 && (hits[1].t - 3.0).abs() < 1e-14);
        assert_eq!(hits[1].face as usize, i);
        // The facet is regular: the middle of its corners is where the ray goes through.
        assert!(hits[1].u.abs() < 1e-14 && hits[1].v.abs() < 1e-14);
        let point = solid.point(&ray, &hits[1]);
        assert!((point.position - (center + n)).length() < 1e-14);
    }
}

#[test]
fn leaving_ray_misses() {
    for (scale, center) in [(1.0, DVec3::ZERO), (1e-3, DVec3::new(100.0, -50.0, 20.0)), (1e4, DVec3::ONE)] {
        let solid = Polyhedron::try_new(&around(&dodecahedron(), scale, center)).unwrap();
        for i in 0..5000 {
            let xi =
                DVec2::new((f64::from(i) * 0.618_033_988_7).fract(), (f64::from(i) * 0.754_877_666).fract());
            let p = solid.sample(xi).unwrap().point;
            let (sin, cos) = f64::from(i).sin_cos();
            let direction = p.dpdu * sin + p.dpdv * cos + p.normal * 10.0_f64.powi(-(i % 16));
            let origin = offset_origin(p.position, p.error, p.normal, direction);
            assert_eq!(solid.intersect(&Ray::new(origin, direction), f64::INFINITY), None);
        }
    }
}

#[test]
fn samples_are_uniform_over_the_area() {
    // The mean of points uniform over the surface of a brick is its center, and each facet gets its share.
    let planes = [
        HalfSpace { normal: DVec3::X, distance: 3.0 },
        HalfSpace { normal: -DVec3::X, distance: 0.0 },
        HalfSpace { normal: DVec3::Y, distance: 2.0 },
        HalfSpace { normal: -DVec3::Y, distance: 0.0 },
        HalfSpace { normal: DVec3::Z, distance: 1.0 },
        HalfSpace { normal: -DVec3::Z, distance: 0.0 },
    ];
    let solid = Polyhedron::try_new(&planes).unwrap();
    let mut counts = [0.0; 6];
    let mut mean = DVec3::ZERO;
    let n = 220;
    for i in 0..n {
        for j in 0..n {
            let xi = (DVec2::new(f64::from(i), f64::from(j)) + 0.5) / f64::from(n);
            let sample = solid.sample(xi).unwrap();
            assert_eq!(sample.pdf, AreaPdf(1.0 / 22.0));
            counts[sample.hit.face as usize] += 1.0 / f64::from(n * n);
            mean += sample.point.position / f64::from(n * n);
        }
    }
    for (count, area) in counts.iter().zip([2.0, 2.0, 3.0, 3.0, 6.0, 6.0]) {
        assert!((count - area / 22.0).abs() < 2.0 / f64::from(n));
    }
    assert!((mean - DVec3::new(1.5, 1.0, 0.5)).length() < 0.02);
}
