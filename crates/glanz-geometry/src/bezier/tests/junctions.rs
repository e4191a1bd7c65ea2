//! Continuity of two patches along a common edge.

use super::*;

#[test]
fn parts_of_one_patch_are_smooth_neighbours() {
    let mut random = Random(13);
    for rational in [false, true] {
        let patch = random.triangle(4, rational);
        let [a, _, _, middle] = patch.quarters();
        let (x, y) = (
            PatchBorder::Triangle(&a, TriangleEdge::RZero),
            PatchBorder::Triangle(&middle, TriangleEdge::RZero),
        );
        let deviation = JunctionDeviation::measure(x, y, 9);
        assert!(deviation.is_g1(1e-14, 1e-11), "{deviation:?}");
        // The middle quarter is the first one turned by half about the middle of their edge: its corner is at
        // (-1, 1, 1).
        let off = derivative_deviation(x, y, &BorderContinuation::affine(1.0, 1.0), 9);
        assert!(off < 1e-12, "{off}");
        let tensor = random.tensor(3, 2, rational);
        let (l, r) = tensor.split_u(0.25).unwrap();
        let (l, r) = (PatchBorder::Tensor(&l, TensorEdge::UOne), PatchBorder::Tensor(&r, TensorEdge::UZero));
        assert!(JunctionDeviation::measure(l, r, 9).is_g1(1e-14, 1e-11));
        assert!(derivative_deviation(l, r, &BorderContinuation::affine(3.0, 0.0), 9) < 1e-12);
        assert!(derivative_deviation(l, r, &BorderContinuation::affine(1.0, 0.0), 9) > 0.1);
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
        let (a, b) = (
            PatchBorder::Triangle(&here, TriangleEdge::TZero),
            PatchBorder::Triangle(&there, TriangleEdge::TZero),
        );
        let deviation = JunctionDeviation::measure(a, b, 5);
        assert!((deviation.angle - tilt).abs() < 1e-15 + 1e-15 * tilt, "{deviation:?}");
        assert!((deviation.position - apart).abs() < 1e-15 && deviation.undecided == 0);
        let backwards = there.mirrored();
        assert!(
            JunctionDeviation::measure(a, PatchBorder::Triangle(&backwards, TriangleEdge::SZero), 5).position
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
            let c1 = BorderContinuation::affine(0.8, 0.3);
            let g1 = BorderContinuation { across: 0.8, along_start: 0.1, along_end: 0.6 };
            for (continuation, degree) in [(c1, n), (c1, n + 1), (g1, n + 1)] {
                let b = mild(&random.triangle(degree, rational));
                let b = join(&a, edge_a, &b, edge_b, &continuation).unwrap();
                let (x, y) = (PatchBorder::Triangle(&a, edge_a), PatchBorder::Triangle(&b, edge_b));
                let deviation = JunctionDeviation::measure(x, y, 9);
                assert!(deviation.is_c0(1e-14) && deviation.is_g1(1e-14, 1e-11), "{deviation:?}");
                assert!(derivative_deviation(x, y, &continuation, 9) < 1e-12);
            }
        }
    }
}

#[test]
fn patch_over_the_neighbouring_triangle_already_has_the_c1_row() {
    // The polynomial continues: the C1 row of a neighbour over another triangle is that of the patch over that triangle.
    let patch = pumberger();
    let (across, along) = (0.5, 0.75);
    let corner = Barycentric { r: -across, s: 1.0 + across - along, t: along };
    let beyond = patch.sub_triangle([corner, Barycentric::CORNERS[2], Barycentric::CORNERS[1]]).unwrap();
    let continuation = BorderContinuation::affine(across, along);
    let joined = join(&patch, TriangleEdge::RZero, &beyond, TriangleEdge::RZero, &continuation).unwrap();
    for (a, b) in joined.control_points().iter().zip(beyond.control_points()) {
        assert!(a.distance(*b) < 1e-14);
    }
}
