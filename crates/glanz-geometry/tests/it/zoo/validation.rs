//! The reference and the comparison against closed forms.

use glanz_geometry::RaySurface;
use glanz_math::glam::DVec4;
use glanz_math::{DVec3, Ray};

use super::collection;
use super::comparison::{HitFault, compare};
use super::patch::ReferencePatch;
use super::rays::{Random, RayFamily};
use super::reference::{DomainRelation, solve};
use super::test_surface::net;

#[test]
fn reference_finds_the_roots_of_a_sphere() {
    let ball = collection::sphere();
    let mut random = Random::new(3);
    let mut met = 0;
    for _ in 0..3000 {
        let ray = RayFamily::Chord.ray(&ball, &mut random);
        let (o, d) = (ray.origin, ray.direction);
        let (a, b, c) = (d.length_squared(), o.dot(d), o.length_squared() - 1.0);
        let discriminant = b * b - a * c;
        let found = solve(&ball.patches, &ray, 1e-14);
        let inside = found.roots.iter().filter(|(_, relation)| *relation == DomainRelation::Inside);
        let mut t: Vec<_> = inside.map(|(bounds, _)| bounds.t).collect();
        t.sort_by(|x, y| x.low.total_cmp(&y.low));
        if discriminant < 0.0 {
            assert!(t.is_empty() && found.clusters.is_empty(), "{ray:?}");
        } else {
            met += 1;
            let expected = [-1.0, 1.0].map(|side| (side * discriminant.sqrt() - b) / a);
            assert_eq!(t.len(), 2, "{ray:?} {found:?}");
            // The equation is rounded as well.
            let off = 1e-13 / discriminant.sqrt() * a.sqrt().max(1.0 / a);
            assert!(
                t.iter().zip(expected).all(|(t, x)| t.widened(off).contains(x)),
                "{ray:?} {t:?} {expected:?}"
            );
        }
    }
    assert!(met > 1000);
}

#[test]
fn reference_finds_all_roots_of_a_polynomial_with_given_roots() {
    // z = (u - 1/8) (u - 1/2) (u - 3/4) over the unit square, every control point dyadic: rays along x in the plane z = 0
    // meet it exactly there. With c_i = blossom of the product: (mean over orders of the arguments).
    let roots = [0.125, 0.5, 0.75];
    let blossom = |x: [f64; 3]| {
        let orders = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
        orders.iter().map(|o| (0..3).map(|k| x[o[k]] - roots[k]).product::<f64>()).sum::<f64>() / 6.0
    };
    let heights: [f64; 4] = std::array::from_fn(|k| 6.0 * blossom(std::array::from_fn(|i| f64::from(i < k))));
    // x must be linear in u: multiples of 1/3 are rounded, so the patch is three wide.
    let points = net((3, 1), |u, v| {
        let k = (3.0 * u).round();
        DVec4::new(k, v, (heights[k as usize] * 64.0).round() / 64.0, 1.0)
    });
    assert!(heights.iter().all(|h| (h * 64.0 - (h * 64.0).round()).abs() < 1e-12), "{heights:?}");
    let patch = ReferencePatch::new((3, 1), points);
    for y in [0.25, 0.7] {
        let ray = Ray::new(DVec3::new(-1.0, y, 0.0), DVec3::new(0.5, 0.0, 0.0));
        let found = solve(std::slice::from_ref(&patch), &ray, 1e-14);
        assert_eq!((found.roots.len(), found.clusters.len()), (3, 0));
        for root in roots {
            let holds = |(bounds, relation): &(super::reference::RootBox, DomainRelation)| {
                *relation == DomainRelation::Inside
                    && bounds.u.contains(root)
                    && bounds.v.contains(y)
                    && bounds.t.contains(6.0 * root + 2.0)
            };
            assert_eq!(found.roots.iter().filter(|r| holds(r)).count(), 1, "{root} {found:?}");
        }
    }
    // Along the border v = 0 it is neither certainly inside nor outside.
    let ray = Ray::new(DVec3::new(-1.0, 0.0, 0.0), DVec3::X);
    let found = solve(std::slice::from_ref(&patch), &ray, 1e-14);
    assert!(
        found.roots.len() == 3 && found.roots.iter().all(|(_, relation)| *relation == DomainRelation::Border)
    );
    let ray = Ray::new(DVec3::new(-1.0, -1e-10, 0.0), DVec3::X);
    assert!(solve(&[patch], &ray, 1e-14).roots.is_empty());
}

#[test]
fn tangencies_and_collapsed_edges_are_clusters() {
    // z = -x^2 over [-1, 1] x [0, 1].
    let points = net((2, 1), |u, v| DVec4::new(2.0 * u - 1.0, v, if u == 0.5 { 1.0 } else { -1.0 }, 1.0));
    let patch = ReferencePatch::new((2, 1), points);
    let along =
        |z: f64| solve(std::slice::from_ref(&patch), &Ray::new(DVec3::new(-3.0, 0.3, z), DVec3::X), 1e-14);
    let touching = along(0.0);
    assert!(touching.roots.is_empty() && !touching.clusters.is_empty());
    assert!(touching.clusters.iter().all(|c| c.u.width() < 1e-5 && c.v.width() < 1e-5), "{touching:?}");
    let above = along(1e-12);
    assert!(above.roots.is_empty() && above.clusters.is_empty(), "{above:?}");
    for depth in [1e-3, 1e-6, 1e-10] {
        let below = along(-depth);
        assert_eq!((below.roots.len(), below.clusters.len()), (2, 0), "{depth}");
        let (x, t) = (f64::sqrt(depth), |k: usize| below.roots[k].0.t);
        assert!(t(0).overlaps(t(0)) && (t(0).middle() - t(1).middle()).abs() > 1.99 * x);
    }
    let ball = collection::sphere();
    let pole = Ray::new(DVec3::new(0.3, 0.1, 3.0), DVec3::new(-0.3, -0.1, -2.0));
    let found = solve(&ball.patches, &pole, 1e-14);
    assert!(!found.clusters.is_empty() && found.cells < 20_000, "{} cells", found.cells);
}

#[test]
fn eighteen_roots_are_all_found() {
    let tested = collection::eighteen();
    let ray = Ray::new(DVec3::new(0.0, 0.0, 3.0), DVec3::NEG_Z);
    let found = solve(&tested.patches, &ray, tested.thickness(&ray));
    assert_eq!((found.roots.len(), found.clusters.len()), (18, 0));
    let mut hits = Vec::new();
    tested.surface.all_hits(&ray, f64::INFINITY, &mut hits);
    assert_eq!(hits.len(), 18);
    assert!(compare(&tested, &ray, &hits, &found).faults.is_empty());
}

#[test]
fn comparison_reports_missed_doubled_and_invented_roots() {
    let tested = collection::eighteen();
    let ray = Ray::new(DVec3::new(0.0, 0.0, 3.0), DVec3::NEG_Z);
    let found = solve(&tested.patches, &ray, tested.thickness(&ray));
    let mut hits = Vec::new();
    tested.surface.all_hits(&ray, f64::INFINITY, &mut hits);
    let faults = |hits: &[glanz_geometry::Hit]| -> Vec<HitFault> {
        compare(&tested, &ray, hits, &found).faults.into_iter().map(|(fault, _)| fault).collect()
    };
    let mut fewer = hits.clone();
    fewer.remove(7);
    assert_eq!(faults(&fewer), [HitFault::Missed]);
    let mut more = hits.clone();
    more.insert(7, hits[7]);
    assert_eq!(faults(&more), [HitFault::Doubled]);
    let mut moved = hits.clone();
    moved[7].t += 1e-3;
    assert!(
        [HitFault::Missed, HitFault::Invented, HitFault::Position].iter().all(|f| faults(&moved).contains(f))
    );
    // Through the border of two patches of the sphere, and through its pole: one hit each, not none, not two.
    let ball = collection::sphere();
    for target in [DVec3::X, DVec3::Z, DVec3::new(0.6, 0.8, 0.0)] {
        let ray =
            Ray::new(target * 3.0 + DVec3::new(0.3, 0.2, 0.1), -target * 2.0 - DVec3::new(0.3, 0.2, 0.1));
        let found = solve(&ball.patches, &ray, ball.thickness(&ray));
        let mut hits = Vec::new();
        ball.surface.all_hits(&ray, f64::INFINITY, &mut hits);
        let faults = |hits: &[glanz_geometry::Hit]| -> Vec<HitFault> {
            let of_roots = [HitFault::Missed, HitFault::Doubled, HitFault::Invented];
            let all = compare(&ball, &ray, hits, &found).faults.into_iter().map(|(fault, _)| fault);
            all.filter(|fault| of_roots.contains(fault)).collect()
        };
        assert_eq!((hits.len(), faults(&hits)), (2, vec![]), "{target}");
        assert_eq!(faults(&hits[1..]), [HitFault::Missed], "{target}");
        assert_eq!(faults(&[hits[0], hits[0], hits[1]]), [HitFault::Doubled], "{target}");
    }
}
