//! Points and derivatives.

use super::*;

/// At (u, v) = (1/3, 1/3), (1/2, 1/4), (1/8, 5/8), (0, 1/2).
const PUMBERGER: [[f64; 3]; 4] = [
    [44.0 / 9.0, 37.0 / 9.0, 169.0 / 27.0],
    [165.0 / 32.0, 147.0 / 32.0, 99.0 / 16.0],
    [1041.0 / 256.0, 879.0 / 256.0, 693.0 / 128.0],
    [9.0 / 2.0, 3.0, 11.0 / 2.0],
];

#[test]
fn patch_of_document_000_has_the_values_of_its_bernstein_form() {
    // Fractions in Python from the control points: sum 6 / (i! j! k!) r^i s^j t^k P_ijk.
    let patch = pumberger();
    for (at, value) in [
        ((1.0 / 3.0, 1.0 / 3.0), PUMBERGER[0]),
        ((0.5, 0.25), PUMBERGER[1]),
        ((0.125, 0.625), PUMBERGER[2]),
        ((0.0, 0.5), PUMBERGER[3]),
    ] {
        let value = DVec3::from_array(value);
        assert!(patch.point(at.0, at.1).distance(value) < 1e-14, "{at:?}");
        assert!(patch.de_casteljau(at.0, at.1).distance(value) < 1e-14, "{at:?}");
    }
    assert_eq!(patch.point(0.0, 0.0), DVec3::new(6.0, 3.0, 5.0));
    assert_eq!(patch.point(1.0, 0.0), DVec3::new(6.0, 6.0, 5.0));
    assert_eq!(patch.point(0.0, 1.0), DVec3::new(3.0, 3.0, 3.0));
}

#[test]
fn true_roots_of_document_000_lie_on_patch() {
    // The line of document 000's worked example: parameters of the true patch, outside of the triangle, with their points (60 digits).
    let (r, s, t) = (-0.165_121_805_889_820_87, 0.331_919_375_640_321_53, 0.833_202_430_249_499_4);
    let point = DVec3::new(3.637_389_002_774_672, 3.858_761_833_397_794_7, 4.012_947_794_626_05);
    let patch = pumberger();
    assert!(patch.point_at(Barycentric { r, s, t }).distance(point) < 1e-13);
}

#[test]
fn paraboloid_has_its_derivatives() {
    // z = x^2 + y^2 with x = u, y = v: degree 2, blossom (x1 x2 + y1 y2).
    let net = [
        [0.0, 0.0, 0.0],
        [0.5, 0.0, 0.0],
        [0.0, 0.5, 0.0],
        [1.0, 0.0, 1.0],
        [0.5, 0.5, 0.0],
        [0.0, 1.0, 1.0],
    ];
    let patch = TrianglePatch::try_from_points(2, &net.map(DVec3::from_array), None).unwrap();
    for (u, v) in triangle_grid() {
        let (p, du, dv) = patch.point_and_tangents(u, v);
        assert!(p.distance(DVec3::new(u, v, u * u + v * v)) < 1e-15);
        assert!(du.distance(DVec3::new(1.0, 0.0, 2.0 * u)) < 1e-15);
        assert!(dv.distance(DVec3::new(0.0, 1.0, 2.0 * v)) < 1e-15);
        let normal = DVec3::new(-2.0 * u, -2.0 * v, 1.0).normalize();
        assert!(patch.normal(u, v).unwrap().distance(normal) < 1e-15);
        let d = patch.derivatives(u, v, 3);
        assert_eq!(d.get(2, 0), Some(DVec3::new(0.0, 0.0, 2.0)));
        assert_eq!(d.get(1, 1), Some(DVec3::ZERO));
        assert_eq!(d.get(1, 2), Some(DVec3::ZERO));
        assert_eq!((d.order(), d.get(2, 2)), (3, None));
    }
    let blossom = |x: DVec2, y: DVec2| {
        patch.blossom(&[Barycentric::from_parameters(x), Barycentric::from_parameters(y)]).unwrap()
    };
    let (x, y) = (DVec2::new(0.3, -0.4), DVec2::new(2.0, 0.7));
    assert!((blossom(x, y).z - x.dot(y)).abs() < 1e-15 && blossom(x, y).distance(blossom(y, x)) < 1e-15);
    assert!(patch.blossom(&[Barycentric::CORNERS[0]]).is_err());
}

#[test]
fn octants_lie_on_the_unit_sphere() {
    let tensor = octant();
    let halves = tensor.to_triangles();
    for (u, v) in square_grid() {
        assert!((tensor.point(u, v).length() - 1.0).abs() < 1e-15);
        // Where the border collapses, the normal has half of the digits.
        let (p, n) = (tensor.point(u, v), tensor.normal(u, v).unwrap());
        assert!(n.distance(p) < if v == 1.0 { 1e-7 } else { 1e-14 }, "{u} {v}");
    }
    for patch in &halves {
        assert_eq!(patch.degree(), 4);
        for (u, v) in triangle_grid() {
            assert!((patch.point(u, v).length() - 1.0).abs() < 1e-14);
            for quad in patch.to_quads() {
                assert!((quad.patch.point(u, v).length() - 1.0).abs() < 1e-14);
            }
        }
    }
}

#[test]
fn closed_form_derivatives_of_a_rational_patch() {
    // The meridian u = 0 is ((1 - t^2), 0, 2 t) / (1 + t^2); with t = tan(a / 2), da/dt = 2 / (1 + t^2).
    let d = octant().derivatives(0.0, 0.5, 2);
    let (t, q) = (0.5_f64, 1.25_f64);
    let first = DVec3::new(-4.0 * t, 0.0, 2.0 * (1.0 - t * t)) / (q * q);
    let second = DVec3::new(-4.0 * (1.0 - 3.0 * t * t), 0.0, 4.0 * t * (t * t - 3.0)) / (q * q * q);
    assert!(d.get(0, 1).unwrap().distance(first) < 1e-15);
    assert!(d.get(0, 2).unwrap().distance(second) < 1e-14);
}

/// Checks each derivative of order up to 3 against central differences of the order below.
fn check_differences(derivatives: impl Fn(f64, f64) -> Derivatives, points: [(f64, f64); 3]) {
    let h = 1e-5;
    for (u, v) in points {
        let d = derivatives(u, v);
        for (k, l) in (0..3).flat_map(|k| (0..3 - k).map(move |l| (k, l))) {
            let at = |u: f64, v: f64| derivatives(u, v).get(k, l).unwrap();
            let by_u = (at(u + h, v) - at(u - h, v)) / (2.0 * h);
            let by_v = (at(u, v + h) - at(u, v - h)) / (2.0 * h);
            // The error is the third derivative of what is differenced times h^2 / 6, 2e-11 of it; for these nets it
            // exceeds the first by a few orders of magnitude.
            let scale = 1.0 + d.get(k + 1, l).unwrap().length() + d.get(k, l + 1).unwrap().length();
            assert!(by_u.distance(d.get(k + 1, l).unwrap()) < 1e-6 * scale, "{k} {l}");
            assert!(by_v.distance(d.get(k, l + 1).unwrap()) < 1e-6 * scale, "{k} {l}");
        }
    }
}

#[test]
fn derivatives_are_differences() {
    let mut random = Random(5);
    for rational in [false, true] {
        let tensor = random.tensor(3, 4, rational);
        check_differences(|u, v| tensor.derivatives(u, v, 3), [(0.1, 0.2), (0.5, 0.5), (0.9, 0.4)]);
        let triangle = random.triangle(5, rational);
        check_differences(|u, v| triangle.derivatives(u, v, 3), [(0.1, 0.2), (0.3, 0.3), (0.5, 0.4)]);
    }
}

#[test]
fn fast_tangents_and_directions_agree_with_all_derivatives() {
    let mut random = Random(6);
    for n in 1..=5 {
        let triangle = random.triangle(n, true);
        let tensor = random.tensor(n, 6 - n, true);
        let (u, v) = (0.3, 0.45);
        for (fast, all) in [
            (triangle.point_and_tangents(u, v), triangle.derivatives(u, v, 3)),
            (tensor.point_and_tangents(u, v), tensor.derivatives(u, v, 3)),
        ] {
            assert!(fast.0.distance(all.get(0, 0).unwrap()) < 1e-14);
            assert!(fast.1.distance(all.get(1, 0).unwrap()) < 1e-12);
            assert!(fast.2.distance(all.get(0, 1).unwrap()) < 1e-12);
        }
        let (a, b) = (0.7, -1.3);
        let along = triangle.directional_derivatives(u, v, DVec2::new(a, b), 3);
        let d = triangle.derivatives(u, v, 3);
        let d = |k, l| d.get(k, l).unwrap();
        let second = d(2, 0) * a * a + d(1, 1) * 2.0 * a * b + d(0, 2) * b * b;
        let third =
            d(3, 0) * a.powi(3) + (d(2, 1) * a * a * b + d(1, 2) * a * b * b) * 3.0 + d(0, 3) * b.powi(3);
        assert!(along[1].distance(d(1, 0) * a + d(0, 1) * b) < 1e-12 * (1.0 + along[1].length()));
        assert!(along[2].distance(second) < 1e-12 * (1.0 + second.length()), "{n}");
        assert!(along[3].distance(third) < 1e-11 * (1.0 + third.length()), "{n}");
    }
}
