//! Parts and other forms of the same patch, and invalid nets.

use super::*;

#[test]
fn weights_that_are_all_one_stay_one() {
    let mut random = Random(4);
    for n in 1..=9 {
        let one = |points: &[DVec4]| points.iter().all(|p| p.w == 1.0);
        let triangle = random.triangle(n, false);
        assert!(!triangle.is_rational() && random.triangle(n, true).is_rational());
        assert!(triangle.to_quads().iter().all(|q| one(q.patch.control_points())));
        assert!(triangle.quarters().iter().all(|q| one(q.control_points())));
        assert!(one(triangle.elevated().control_points()));
        assert!(one(triangle.to_degenerate_tensor().control_points()));
        let tensor = random.tensor(n, n + 1, false);
        assert!(tensor.to_triangles().iter().all(|t| one(t.control_points())));
        let (a, b) = tensor.split_u(0.3).unwrap();
        assert!(one(a.control_points()) && one(b.elevated_v().control_points()));
        assert!(one(tensor.sub_rectangle(0.1..0.7, 0.3..0.9).unwrap().control_points()));
    }
    // The same holds for another common weight.
    let points = random.triangle(4, false).control_points().iter().map(|p| *p * 0.7).collect();
    let heavy = TrianglePatch::try_new(4, points).unwrap();
    assert!(heavy.to_quads().iter().flat_map(|q| q.patch.control_points()).all(|p| p.w == 0.7));
}

#[test]
fn parts_of_a_triangle_keep_the_surface() {
    let mut random = Random(7);
    for n in 1..=6 {
        let patch = random.triangle(n, n % 2 == 0);
        let corner = Barycentric::CORNERS.map(Barycentric::parameters);
        let [a, b, c] = corner;
        let (ab, bc, ca) = ((a + b) * 0.5, (b + c) * 0.5, (c + a) * 0.5);
        let center = DVec2::new(0.2, 0.5);
        let at = Barycentric::from_parameters(center);
        let three = patch.split_at(at).unwrap();
        let quarters = patch.quarters();
        let halves = patch.halves();
        let inner = [DVec2::new(0.1, 0.1), DVec2::new(0.7, 0.2), DVec2::new(0.3, 0.6)];
        let sub = patch.sub_triangle(inner.map(Barycentric::from_parameters)).unwrap();
        let parts = [
            (&three[0], [center, b, c]),
            (&three[1], [a, center, c]),
            (&three[2], [a, b, center]),
            (&quarters[0], [a, ab, ca]),
            (&quarters[1], [ab, b, bc]),
            (&quarters[2], [ca, bc, c]),
            (&quarters[3], [bc, ca, ab]),
            (&halves[0], [a, b, bc]),
            (&halves[1], [a, bc, c]),
            (&sub, inner),
        ];
        for (number, (part, [a, b, c])) in parts.iter().enumerate() {
            for (u, v) in triangle_grid() {
                let at = *a * (1.0 - u - v) + *b * u + *c * v;
                let off = part.point(u, v).distance(patch.point(at.x, at.y));
                assert!(off < 1e-13, "degree {n}, part {number}: {off}");
            }
        }
    }
}

#[test]
fn quarters_meet_in_the_same_bits() {
    let mut random = Random(8);
    for n in 1..=6 {
        let patch = random.triangle(n, true);
        let [a, b, c, middle] = patch.quarters();
        for (outer, inner) in [
            (a.edge(TriangleEdge::RZero), middle.edge(TriangleEdge::RZero)),
            (b.edge(TriangleEdge::SZero), middle.edge(TriangleEdge::SZero)),
            (c.edge(TriangleEdge::TZero), middle.edge(TriangleEdge::TZero)),
        ] {
            assert_eq!(bits(&outer), bits(&reversed(inner)));
        }
        let [left, right] = patch.halves();
        assert_eq!(bits(&left.edge(TriangleEdge::SZero)), bits(&reversed(right.edge(TriangleEdge::TZero))));
        // Quarters, quadrilaterals and halves of a square meet too.
        let first = a.edge(TriangleEdge::TZero);
        assert_eq!(bits(&first), bits(&patch.to_quads()[0].patch.edge(TensorEdge::VZero)));
        let square = patch.to_degenerate_tensor();
        assert_eq!(
            bits(&square.halves_u().0.edge(TensorEdge::VZero)),
            bits(&first),
            "u = 0 is the first corner"
        );
    }
}

#[test]
fn centroid_splits_leave_edges_whole() {
    // Erratum to proposition 2.2.4.3 of document 000: the child's edge net is the parent's.
    let patch = pumberger();
    let third = 1.0 / 3.0;
    let [first, ..] = patch.split_at(Barycentric { r: third, s: third, t: third }).unwrap();
    assert_eq!(first.edge(TriangleEdge::RZero), patch.edge(TriangleEdge::RZero));
}

#[test]
fn parts_of_a_tensor_keep_the_surface_and_meet() {
    let mut random = Random(9);
    for (p, q) in [(1, 1), (2, 3), (4, 2), (5, 5)] {
        let patch = random.tensor(p, q, p != 2);
        let check = |part: &TensorPatch, u0: f64, u1: f64, v0: f64, v1: f64| {
            for (u, v) in square_grid() {
                let ought = patch.point(u0 + (u1 - u0) * u, v0 + (v1 - v0) * v);
                assert!(part.point(u, v).distance(ought) < 1e-13);
            }
        };
        let (a, b) = patch.split_u(0.3).unwrap();
        check(&a, 0.0, 0.3, 0.0, 1.0);
        check(&b, 0.3, 1.0, 0.0, 1.0);
        assert_eq!(bits(&a.edge(TensorEdge::UOne)), bits(&reversed(b.edge(TensorEdge::UZero))));
        let (a, b) = patch.halves_v();
        check(&a, 0.0, 1.0, 0.0, 0.5);
        check(&b, 0.0, 1.0, 0.5, 1.0);
        // Run backwards, a patch is cut into the same bits.
        let (d, c) = patch.reversed_v().halves_v();
        assert_eq!((bits(a.control_points()), b), (bits(c.reversed_v().control_points()), d.reversed_v()));
        let left = patch.sub_rectangle(0.1..0.4, 0.2..0.7).unwrap();
        let right = patch.sub_rectangle(0.4..0.9, 0.2..0.7).unwrap();
        check(&left, 0.1, 0.4, 0.2, 0.7);
        assert_eq!(bits(&left.edge(TensorEdge::UOne)), bits(&reversed(right.edge(TensorEdge::UZero))));
        check(&patch.elevated_u().elevated_v(), 0.0, 1.0, 0.0, 1.0);
        check(&patch.reversed_u(), 1.0, 0.0, 0.0, 1.0);
        check(&patch.reversed_v(), 0.0, 1.0, 1.0, 0.0);
        assert!(patch.transposed().point(0.2, 0.7).distance(patch.point(0.7, 0.2)) < 1e-14);
        for (u, v) in square_grid() {
            assert!(patch.bounds().expanded(1e-14).contains(patch.point(u, v)));
        }
    }
}

#[test]
fn patch_over_a_square_is_two_triangles() {
    let mut random = Random(10);
    for (p, q) in [(1, 1), (2, 3), (3, 1), (4, 4)] {
        let patch = random.tensor(p, q, true);
        let [below, above] = patch.to_triangles();
        assert_eq!((below.degree(), above.degree()), (p + q, p + q));
        for (u, v) in triangle_grid() {
            assert!(below.point(u, v).distance(patch.point(u, v)) < 1e-13);
            assert!(above.point(u, v).distance(patch.point(1.0 - u, 1.0 - v)) < 1e-13);
        }
        assert_eq!(bits(&below.edge(TriangleEdge::RZero)), bits(&reversed(above.edge(TriangleEdge::RZero))));
    }
}

#[test]
fn patch_over_a_triangle_is_a_square_with_a_collapsed_border() {
    let mut random = Random(11);
    for n in 1..=6 {
        let patch = random.triangle(n, true);
        let square = patch.to_degenerate_tensor();
        for (u, v) in square_grid() {
            assert!(square.point(u, v).distance(patch.point(u * (1.0 - v), u * v)) < 1e-13);
        }
        assert!(square.edge(TensorEdge::UZero).iter().all(|p| p.distance(patch.control_points()[0]) < 1e-15));
    }
}

#[test]
fn elevation_and_renumbering_keep_the_triangle() {
    let mut random = Random(12);
    for n in 1..=6 {
        let patch = random.triangle(n, true);
        for (u, v) in triangle_grid() {
            let p = patch.point(u, v);
            assert!(patch.elevated().elevated().point(u, v).distance(p) < 1e-13);
            assert!(patch.mirrored().point(v, u).distance(p) < 1e-13);
            // The first corner there is the second here.
            assert!(patch.rotated().point(v, 1.0 - u - v).distance(p) < 1e-13);
            assert!(patch.de_casteljau(u, v).distance(p) < 1e-13);
            assert!(patch.bounds().expanded(1e-14).contains(p));
        }
        let mut counts = triangle::indices(n);
        assert!((0..).zip(&mut counts).all(|(e, (i, j, k))| patch.index(i, j, k) == Some(e)));
        assert_eq!((patch.index(n, 1, 0), patch.index(usize::MAX, 1, 0)), (None, None));
    }
}

#[test]
fn invalid_nets_are_refused() {
    let net = |w: f64, x: f64| vec![DVec4::new(x, 0.0, 0.0, w); 4];
    let errors = [
        TensorPatch::try_new(1, 1, net(0.0, 1.0)),
        TensorPatch::try_new(1, 1, net(-1.0, 1.0)),
        TensorPatch::try_new(1, 1, net(1.0, f64::NAN)),
        TensorPatch::try_new(1, 1, net(f64::INFINITY, 1.0)),
        TensorPatch::try_new(1, 1, net(1e-300, 1e300)),
        TensorPatch::try_new(0, 3, net(1.0, 1.0)),
        TensorPatch::try_new(usize::MAX, usize::MAX, net(1.0, 1.0)),
        TensorPatch::try_new(1, 2, net(1.0, 1.0)),
    ];
    assert!(errors.iter().all(Result::is_err), "{errors:?}");
    assert!(TrianglePatch::try_new(1, net(1.0, 1.0)).is_err());
    assert!(TrianglePatch::try_new(0, Vec::new()).is_err());
    let points = [DVec3::ZERO, DVec3::X, DVec3::Y];
    let error = TrianglePatch::try_from_points(1, &points, Some(&[1.0]));
    assert_eq!(error, Err(SurfaceError::CountMismatch { parameter: "weights", count: 1, expected: 3 }));
    let patch = octant();
    assert!(patch.split_u(1.5).is_err() && patch.split_v(f64::NAN).is_err());
    assert!(patch.sub_rectangle(0.5..0.5, 0.0..1.0).is_err());
    assert!(patch.sub_rectangle(0.0..1.0, 0.0..1.1).is_err());
    let outside = Barycentric { r: 3.0, s: 0.0, t: -2.0 };
    let rational = TrianglePatch::try_from_points(1, &points, Some(&[1.0, 1.0, 5.0])).unwrap();
    assert!(matches!(rational.split_at(outside), Err(SurfaceError::NotPositive { .. })));
}
