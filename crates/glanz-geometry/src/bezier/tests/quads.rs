//! A triangular patch as three over squares.

use super::*;

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
