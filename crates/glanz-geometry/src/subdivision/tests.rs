use super::*;

/// A pyramid over a regular polygon with this many sides, closed by a second apex below if `is_closed`.
fn pyramid(sides: u32, is_closed: bool) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let at = |k: u32| {
        let (sin, cos) = (TAU * f64::from(k) / f64::from(sides)).sin_cos();
        DVec3::new(cos, sin, 0.1 * f64::from(k % 2))
    };
    let mut positions: Vec<DVec3> = (0..sides).map(at).collect();
    positions.extend([DVec3::new(0.2, 0.1, 1.0), DVec3::new(0.0, 0.1, -0.7)]);
    let around = |k: u32| (k, (k + 1) % sides);
    let mut triangles: Vec<[u32; 3]> = (0..sides).map(around).map(|(a, b)| [a, b, sides]).collect();
    if is_closed {
        triangles.extend((0..sides).map(around).map(|(a, b)| [b, a, sides + 1]));
    }
    (positions, triangles)
}

fn subdivide((positions, triangles): (Vec<DVec3>, Vec<[u32; 3]>), levels: u32) -> SubdividedMesh {
    loop_subdivision(positions, triangles, levels).unwrap()
}

#[test]
fn limits_and_normals_do_not_depend_on_the_level() {
    // A point of the control mesh stays a vertex of all levels; its limit is one point with one tangent plane. Apices of
    // valences 3 to 9, and on the open pyramid borders of valence 3.
    for sides in 3..10 {
        for is_closed in [true, false] {
            let mesh = pyramid(sides, is_closed);
            let used = mesh.0.len() - usize::from(!is_closed);
            let [coarse, fine] = [0, 3].map(|levels| subdivide(mesh.clone(), levels));
            for vertex in 0..used {
                let apart = coarse.positions[vertex].distance(fine.positions[vertex]);
                assert!(apart < 1e-14, "{sides} {vertex}: {apart}");
                if is_closed || vertex == sides as usize {
                    let [a, b] = [&coarse, &fine].map(|mesh| mesh.normals[vertex].normalize());
                    assert!(a.distance(b) < 1e-11, "{sides} {vertex}: {a} {b}");
                }
            }
        }
    }
}

#[test]
fn limit_of_a_regular_vertex_is_that_of_the_quartic_box_spline() {
    // The box spline of three directions, each twice, is 1/2 at its middle and 1/12 at its six neighbours.
    let (positions, triangles) = pyramid(6, false);
    let limit = subdivide((positions.clone(), triangles), 0).positions[6];
    let expected = 0.5 * positions[6] + positions[..6].iter().sum::<DVec3>() / 12.0;
    assert!(limit.distance(expected) < 1e-15);
}

#[test]
fn border_is_the_cubic_spline_of_its_own_points() {
    // A uniform cubic B-spline: 1/6, 2/3, 1/6 at knots, (1, 23, 23, 1) / 48 between them; the apex has no part in it.
    let mesh = pyramid(7, false);
    let border = |k: usize| mesh.0[k % 7];
    let at_knot = (border(2) + 4.0 * border(3) + border(4)) / 6.0;
    let between = (border(2) + 23.0 * (border(3) + border(4)) + border(5)) / 48.0;
    let limit = subdivide(mesh.clone(), 1);
    assert!(limit.positions[3].distance(at_knot) < 1e-15);
    assert!(limit.positions.iter().any(|point| point.distance(between) < 1e-15));
}

#[test]
fn normals_of_a_plane_are_its_own_and_point_where_corners_are_clockwise() {
    // Borders of valence 2, 3, 4 and 5, and a vertex in the interior.
    let positions = [
        (0.0, 0.0),
        (1.0, 0.0),
        (2.0, 0.0),
        (0.0, 1.0),
        (1.1, 0.9),
        (2.0, 1.0),
        (0.0, 2.0),
        (1.0, 2.0),
        (2.0, 2.0),
    ];
    let positions: Vec<DVec3> = positions.iter().map(|&(x, y)| DVec3::new(x, y, 0.5)).collect();
    let triangles =
        vec![[0, 1, 4], [0, 4, 3], [1, 2, 4], [2, 5, 4], [3, 4, 7], [3, 7, 6], [4, 5, 7], [5, 8, 7]];
    for levels in [0, 1, 3] {
        let mesh = subdivide((positions.clone(), triangles.clone()), levels);
        assert!(mesh.positions.iter().all(|p| (p.z - 0.5).abs() < 1e-14));
        for normal in &mesh.normals {
            assert!(normal.normalize().distance(-DVec3::Z) < 1e-12, "{levels}: {normal}");
        }
    }
}

#[test]
fn a_level_has_four_times_as_many_triangles_and_no_new_border() {
    let (positions, triangles) = pyramid(5, true);
    let mesh = subdivide((positions, triangles), 2);
    assert_eq!(mesh.triangles.len(), 160);
    // Euler: V - E + F = 2 with 2 E = 3 F.
    assert_eq!(mesh.positions.len(), 2 + 160 / 2);
    let edges = EdgeTable::try_new(&mesh.triangles, mesh.positions.len()).unwrap();
    assert!(edges.edges().iter().all(|edge| edge.opposite.1.is_some()));
}

#[test]
fn meshes_that_are_no_surface_are_refused() {
    let points = || pyramid(4, true).0;
    let refused = |triangles: Vec<[u32; 3]>| loop_subdivision(points(), triangles, 1);
    for triangles in [
        vec![[0, 1, 4], [1, 0, 5], [0, 1, 2]],
        vec![[0, 1, 4], [0, 1, 5]],
        vec![[0, 0, 1]],
        // Two triangles that touch at a vertex.
        vec![[0, 1, 2], [0, 3, 4]],
    ] {
        assert!(matches!(refused(triangles), Err(SurfaceError::NotManifold { .. })));
    }
    assert!(matches!(refused(vec![[0, 1, 9]]), Err(SurfaceError::BadIndex { index: 9, count: 6, .. })));
    assert!(matches!(refused(Vec::new()), Err(SurfaceError::TooFew { .. })));
    let (positions, triangles) = pyramid(4, true);
    assert!(matches!(loop_subdivision(positions, triangles, 40), Err(SurfaceError::TooMany { .. })));
}

#[test]
fn normals_at_a_border_do_not_depend_on_the_level() {
    // Fans of 1 to 8 triangles around vertex 0, whose border bends out of the plane.
    for count in 1..=8_u32 {
        let rim = (0..=count).map(|k| {
            let (sin, cos) = (PI * f64::from(k) / f64::from(count)).sin_cos();
            DVec3::new(cos, sin, 0.3 * f64::from(k * k % 3))
        });
        let positions: Vec<DVec3> = [DVec3::ZERO].into_iter().chain(rim).collect();
        let triangles: Vec<[u32; 3]> = (1..=count).map(|k| [0, k, k + 1]).collect();
        let normal =
            |levels| subdivide((positions.clone(), triangles.clone()), levels).normals[0].normalize();
        let [a, b] = [0, 3].map(normal);
        assert!(a.distance(b) < 1e-9, "{count}: {a} {b}");
    }
}
