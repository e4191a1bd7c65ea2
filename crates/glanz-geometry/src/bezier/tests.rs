use glanz_math::glam::DVec4;
use glanz_math::{DVec2, DVec3};

use super::junction::{derivative_deviation, joined};
use super::*;
use crate::error::SurfaceError;

/// Numbers in [0, 1), the same in every run.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn point(&mut self, rational: bool) -> DVec4 {
        let p = DVec3::new(self.next(), self.next(), self.next()) * 2.0 - 1.0;
        // From 1/8 to 8.
        let w = if rational { (6.0 * self.next() - 3.0).exp2() } else { 1.0 };
        (p * w).extend(w)
    }

    fn triangle(&mut self, n: usize, rational: bool) -> TrianglePatch {
        let points = (0..(n + 1) * (n + 2) / 2).map(|_| self.point(rational)).collect();
        TrianglePatch::try_new(n, points).unwrap()
    }

    fn tensor(&mut self, p: usize, q: usize, rational: bool) -> TensorPatch {
        let points = (0..(p + 1) * (q + 1)).map(|_| self.point(rational)).collect();
        TensorPatch::try_new(p, q, points).unwrap()
    }
}

const EDGES: [TriangleEdge; 3] = [TriangleEdge::TZero, TriangleEdge::RZero, TriangleEdge::SZero];

/// Parameters in the triangle, corners and border included.
fn triangle_grid() -> impl Iterator<Item = (f64, f64)> {
    (0..=4).flat_map(|i| (0..=4 - i).map(move |j| (f64::from(i) / 4.0, f64::from(j) / 4.0)))
}

fn square_grid() -> impl Iterator<Item = (f64, f64)> {
    (0..=4).flat_map(|i| (0..=4).map(move |j| (f64::from(i) / 4.0, f64::from(j) / 4.0)))
}

/// Bits of a net, -0 and 0 being the same.
fn bits(points: &[DVec4]) -> Vec<[u64; 4]> {
    points.iter().map(|p| p.to_array().map(|x| (x + 0.0).to_bits())).collect()
}

fn reversed(mut points: Vec<DVec4>) -> Vec<DVec4> {
    points.reverse();
    points
}

/// The cubic patch of document 000 section 4.3 (`A.control_points` of the reference values).
fn pumberger() -> TrianglePatch {
    let points = [
        [6.0, 3.0, 5.0], // 300
        [6.0, 4.0, 8.0], // 210
        [5.0, 3.0, 6.0], // 201
        [6.0, 5.0, 6.0], // 120
        [4.5, 4.5, 7.0], // 111
        [4.0, 3.0, 6.0], // 102
        [6.0, 6.0, 5.0], // 030
        [5.0, 5.0, 6.0], // 021
        [4.0, 4.0, 6.0], // 012
        [3.0, 3.0, 3.0], // 003
    ];
    TrianglePatch::try_from_points(3, &points.map(DVec3::from_array), None).unwrap()
}

/// An octant of the unit sphere as (q(u), q(v)) tensor of quarter circles, its border v = 1 collapsed to the pole.
fn octant() -> TensorPatch {
    // A quarter circle is (1, 0), (1, 1), (0, 1) with weights 1, 1, 2, in homogeneous form (1 - t^2, 2 t, 1 + t^2).
    let quarter = [[1.0, 0.0, 1.0], [1.0, 1.0, 1.0], [0.0, 2.0, 2.0]];
    let mut points = Vec::new();
    for [c, s, w] in quarter {
        // (radius, height, weight) of the meridian times (x, y, weight) of the parallel.
        points.extend(quarter.map(|[r, z, m]| DVec4::new(c * r, s * r, w * z, w * m)));
    }
    TensorPatch::try_new(2, 2, points).unwrap()
}

#[test]
fn quads_are_the_patch_composed_with_a_bilinear_map() {
    let mut random = Random(1);
    for (n, rational) in (1..=7).flat_map(|n| [(n, false), (n, true)]) {
        let patch = random.triangle(n, rational);
        for quad in patch.to_quads() {
            assert_eq!(quad.patch.degrees(), (n, n));
            for (u, v) in square_grid() {
                let at = quad.triangle_parameters(u, v);
                let (is, ought) = (quad.patch.point(u, v), patch.point(at.x, at.y));
                assert!(is.distance(ought) < 1e-13, "{n} {rational} {u} {v}: {}", is.distance(ought));
                if let (Some(a), Some(b)) = (quad.patch.normal(u, v), patch.normal(at.x, at.y)) {
                    assert!(a.dot(b) > 0.999, "turned over at {u} {v}");
                }
            }
        }
    }
}

#[test]
fn quads_of_extreme_weights_keep_the_surface() {
    let mut random = Random(15);
    for n in 1..=7 {
        let plain = random.triangle(n, false);
        let points: Vec<_> = plain.control_points().iter().map(|p| p.truncate()).collect();
        // From 1e-3 to 1e3.
        let weights: Vec<_> = points.iter().map(|_| 10.0_f64.powf(6.0 * random.next() - 3.0)).collect();
        let patch = TrianglePatch::try_from_points(n, &points, Some(&weights)).unwrap();
        for quad in patch.to_quads() {
            for (u, v) in square_grid() {
                let at = quad.triangle_parameters(u, v);
                // A rounding of the parameters moves the point by up to 1e3 n as much: 1e-12 at most.
                assert!(quad.patch.point(u, v).distance(patch.point(at.x, at.y)) < 1e-12);
            }
        }
    }
}

#[test]
fn quads_meet_in_the_same_bits() {
    let mut random = Random(2);
    for (n, rational) in (1..=7).flat_map(|n| [(n, false), (n, true)]) {
        let quads = random.triangle(n, rational).to_quads();
        for i in 0..3 {
            // From the middle of the edge to the centroid, and back in the next quadrilateral.
            let here = quads[i].patch.edge(TensorEdge::UOne);
            let next = quads[(i + 1) % 3].patch.edge(TensorEdge::VOne);
            assert_eq!(bits(&here), bits(&reversed(next)), "{n} {i}");
        }
    }
}

/// A patch with the control points of `edge` of `patch` on its edge `other`, run the other way or mirrored.
fn neighbours(patch: &TrianglePatch, random: &mut Random) -> Vec<(usize, TriangleEdge, TrianglePatch)> {
    let n = patch.degree();
    let mut found = Vec::new();
    for (number, edge) in EDGES.iter().enumerate() {
        for other in EDGES {
            let mut points: Vec<_> = random.triangle(n, true).control_points().to_vec();
            let shared = patch.edge(*edge);
            for (e, point) in triangle::edge_row_indices(n, other, 0).zip(shared.iter().rev()) {
                points[e] = *point;
            }
            found.push((number, other, TrianglePatch::try_new(n, points).unwrap()));
        }
    }
    found
}

#[test]
fn quads_of_neighbours_meet_in_the_same_bits() {
    let mut random = Random(3);
    for n in 1..=7 {
        let patch = random.triangle(n, n % 2 == 0);
        let quads = patch.to_quads();
        for (edge, other, neighbour) in neighbours(&patch, &mut random) {
            let number = EDGES.iter().position(|e| *e == other).unwrap();
            let theirs = neighbour.to_quads();
            // The first half of our edge is the second half of theirs, and the other way round.
            let first = quads[edge].patch.edge(TensorEdge::VZero);
            let second = quads[(edge + 1) % 3].patch.edge(TensorEdge::UZero);
            let their_first = theirs[number].patch.edge(TensorEdge::VZero);
            let their_second = theirs[(number + 1) % 3].patch.edge(TensorEdge::UZero);
            assert_eq!(bits(&first), bits(&reversed(their_second)));
            assert_eq!(bits(&second), bits(&reversed(their_first)));
            // A mirrored neighbour runs the edge the same way.
            let mirrored = neighbour.mirrored().to_quads();
            let turned = [2, 1, 0][number];
            assert_eq!(bits(&first), bits(&mirrored[turned].patch.edge(TensorEdge::VZero)));
        }
    }
}

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
    // `A.worked_line`: parameters of the true patch, outside of the triangle, with their points (60 digits).
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
        patch.blossom(&[Barycentric::of_parameters(x), Barycentric::of_parameters(y)]).unwrap()
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

#[test]
fn parts_of_a_triangle_keep_the_surface() {
    let mut random = Random(7);
    for n in 1..=6 {
        let patch = random.triangle(n, n % 2 == 0);
        let corner = Barycentric::CORNERS.map(Barycentric::parameters);
        let [a, b, c] = corner;
        let (ab, bc, ca) = ((a + b) * 0.5, (b + c) * 0.5, (c + a) * 0.5);
        let center = DVec2::new(0.2, 0.5);
        let at = Barycentric::of_parameters(center);
        let three = patch.split_at(at).unwrap();
        let quarters = patch.quarters();
        let halves = patch.halves();
        let inner = [DVec2::new(0.1, 0.1), DVec2::new(0.7, 0.2), DVec2::new(0.3, 0.6)];
        let sub = patch.sub_triangle(inner.map(Barycentric::of_parameters)).unwrap();
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
fn parts_of_one_patch_are_smooth_neighbours() {
    let mut random = Random(13);
    for rational in [false, true] {
        let patch = random.triangle(4, rational);
        let [a, _, _, middle] = patch.quarters();
        let (x, y) =
            (Border::Triangle(&a, TriangleEdge::RZero), Border::Triangle(&middle, TriangleEdge::RZero));
        let met = Junction::measured(x, y, 9);
        assert!(met.is_g1(1e-14, 1e-11), "{met:?}");
        // The middle quarter is the first one turned by half about the middle of their edge: its corner is at
        // (-1, 1, 1).
        let off = derivative_deviation(x, y, &Continuation::affine(1.0, 1.0), 9);
        assert!(off < 1e-12, "{off}");
        let tensor = random.tensor(3, 2, rational);
        let (l, r) = tensor.split_u(0.25).unwrap();
        let (l, r) = (Border::Tensor(&l, TensorEdge::UOne), Border::Tensor(&r, TensorEdge::UZero));
        assert!(Junction::measured(l, r, 9).is_g1(1e-14, 1e-11));
        assert!(derivative_deviation(l, r, &Continuation::affine(3.0, 0.0), 9) < 1e-12);
        assert!(derivative_deviation(l, r, &Continuation::affine(1.0, 0.0), 9) > 0.1);
    }
}

#[test]
fn measured_angle_is_that_between_the_planes() {
    // Two triangles over the x axis, the second one raised by 0.3 rad, or folded back by pi.
    let flat = |y: DVec3, turned: bool| {
        let (a, b) = if turned { (DVec3::X, DVec3::ZERO) } else { (DVec3::ZERO, DVec3::X) };
        TrianglePatch::try_from_points(1, &[a, b, y], None).unwrap()
    };
    let here = flat(DVec3::new(0.2, 1.0, 0.0), false);
    for (tilt, apart) in [(0.3_f64, 0.0), (0.0, 0.01), (std::f64::consts::PI, 0.0), (1e-9, 0.0)] {
        let there = flat(DVec3::new(0.5, -tilt.cos(), tilt.sin()), true);
        let points: Vec<_> =
            there.control_points().iter().map(|p| p.truncate() + DVec3::new(0.0, 0.0, apart)).collect();
        let there = TrianglePatch::try_from_points(1, &points, None).unwrap();
        let (a, b) =
            (Border::Triangle(&here, TriangleEdge::TZero), Border::Triangle(&there, TriangleEdge::TZero));
        let met = Junction::measured(a, b, 5);
        assert!((met.angle - tilt).abs() < 1e-15 + 1e-15 * tilt, "{met:?}");
        assert!((met.position - apart).abs() < 1e-15 && met.undecided == 0);
        let backwards = there.mirrored();
        assert!(
            Junction::measured(a, Border::Triangle(&backwards, TriangleEdge::SZero), 5).position
                < 1e-15 + apart
        );
    }
}

#[test]
fn joined_neighbours_are_c1_or_g1() {
    let mut random = Random(14);
    // Weights near 1, so that the continued ones are positive.
    let mild = |patch: &TrianglePatch| {
        let points: Vec<_> = patch.control_points().iter().map(|p| p.truncate() / p.w).collect();
        let weights: Vec<_> = patch.control_points().iter().map(|p| p.w.powf(0.1)).collect();
        TrianglePatch::try_from_points(patch.degree(), &points, Some(&weights)).unwrap()
    };
    for (n, rational) in [(2, false), (3, true), (5, false), (4, true)] {
        let a = mild(&random.triangle(n, rational));
        for (edge_a, edge_b) in EDGES.iter().flat_map(|a| EDGES.map(|b| (*a, b))) {
            let c1 = Continuation::affine(0.8, 0.3);
            let g1 = Continuation { across: 0.8, along_start: 0.1, along_end: 0.6 };
            for (way, degree) in [(c1, n), (c1, n + 1), (g1, n + 1)] {
                let b = mild(&random.triangle(degree, rational));
                let b = joined(&a, edge_a, &b, edge_b, &way).unwrap();
                let (x, y) = (Border::Triangle(&a, edge_a), Border::Triangle(&b, edge_b));
                let met = Junction::measured(x, y, 9);
                assert!(met.is_c0(1e-14) && met.is_g1(1e-14, 1e-11), "{met:?}");
                assert!(derivative_deviation(x, y, &way, 9) < 1e-12);
            }
        }
    }
}

#[test]
fn whole_net_continued_by_its_blossom_keeps_its_first_row() {
    // The polynomial goes on: the C1 row of a neighbour with its corner at b is that of the patch over that triangle.
    let patch = pumberger();
    let (across, along) = (0.5, 0.75);
    let corner = Barycentric { r: -across, s: 1.0 + across - along, t: along };
    let beyond = patch.sub_triangle([corner, Barycentric::CORNERS[2], Barycentric::CORNERS[1]]).unwrap();
    let way = Continuation::affine(across, along);
    let joined = joined(&patch, TriangleEdge::RZero, &beyond, TriangleEdge::RZero, &way).unwrap();
    for (a, b) in joined.control_points().iter().zip(beyond.control_points()) {
        assert!(a.distance(*b) < 1e-14);
    }
}

#[test]
fn wrong_nets_are_refused() {
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
