//! Edits of knots and degrees keep the surface.

use super::*;

fn as_surface(piece: &BezierPiece) -> NurbsSurface {
    let (p, q) = piece.patch.degrees();
    let knots = |n: usize, [a, b]: [f64; 2]| [vec![a; n + 1], vec![b; n + 1]].concat();
    let points = piece.patch.control_points().to_vec();
    NurbsSurface::try_new([p, q], [knots(p, piece.u), knots(q, piece.v)], points).unwrap()
}

#[test]
fn insertion_elevation_splitting_and_reversal_keep_the_surface() {
    for surface in [reference(), open()] {
        let inserted = surface.insert_knot(ParameterDirection::U, 0.55, 3).unwrap();
        let [c, d] = surface.knots_v().domain();
        let inserted = inserted.insert_knot(ParameterDirection::V, c + 0.9 * (d - c), 1).unwrap();
        assert_eq!(inserted.counts(), (surface.counts().0 + 3, surface.counts().1 + 1));
        assert!(distance(&inserted, &surface) < 1e-12);
        let raised = surface.elevate(ParameterDirection::U).unwrap().elevate(ParameterDirection::V).unwrap();
        assert_eq!((raised.knots_u().degree(), raised.knots_v().degree()), (4, 3));
        assert_eq!(raised.knots_u().domain(), surface.knots_u().domain());
        assert!(distance(&raised, &surface) < 1e-12, "{}", distance(&raised, &surface));
        for direction in [ParameterDirection::U, ParameterDirection::V] {
            let [a, b] = surface.knots(direction).domain();
            for cut in [a + 0.37 * (b - a), surface.knots(direction).inner()[0]] {
                let (low, high) = surface.split(direction, cut).unwrap();
                assert_eq!(
                    (low.knots(direction).domain(), high.knots(direction).domain()),
                    ([a, cut], [cut, b])
                );
                // The lower part is closed, so that both have a value at the cut.
                assert!(distance(&low, &surface) < 1e-12 && distance(&high, &surface) < 1e-12);
            }
            let turned = surface.reversed(direction).unwrap().reversed(direction).unwrap();
            assert!(distance(&turned, &surface) < 1e-12);
        }
        let backwards = surface.reversed(ParameterDirection::U).unwrap();
        let ([a, b], [c, d]) = (surface.knots_u().domain(), surface.knots_v().domain());
        for (u, v) in grid(surface.knots_u()).into_iter().zip(grid(surface.knots_v())) {
            assert!(backwards.point(a + (b - u), v).distance(surface.point(u, v)) < 1e-12);
            assert!(surface.transposed().point(v, u).distance(surface.point(u, v)) < 1e-14);
            assert!(
                surface.isocurve(ParameterDirection::U, u).unwrap().point(v).distance(surface.point(u, v))
                    < 1e-13
            );
            assert!(
                surface.isocurve(ParameterDirection::V, v).unwrap().point(u).distance(surface.point(u, v))
                    < 1e-13
            );
        }
        let part = surface.restrict([[a + 0.2 * (b - a), b], [c, c + 0.7 * (d - c)]]).unwrap();
        assert!(part.knots_u().is_clamped() && part.knots_v().is_clamped());
        assert!(distance(&part, &surface) < 1e-12);
    }
}

#[test]
fn inserted_knots_can_be_removed_and_necessary_ones_cannot() {
    for surface in [reference(), open()] {
        for direction in [ParameterDirection::U, ParameterDirection::V] {
            let [a, b] = surface.knots(direction).domain();
            let new = a + 0.81 * (b - a);
            let finer = surface.insert_knot(direction, new, 2).unwrap();
            let (once, moved) = finer.remove_knot(direction, new, 1e-12).unwrap();
            assert!(moved < 1e-12);
            let (twice, _) = once.remove_knot(direction, new, 1e-12).unwrap();
            assert_eq!(twice.knots(direction), surface.knots(direction));
            assert!(distance(&twice, &surface) < 1e-12);
            let needed = surface.knots(direction).inner()[0];
            let refused = surface.remove_knot(direction, needed, 1e-6).unwrap_err();
            let SurfaceError::KnotNeeded { deviation, .. } = refused else { panic!("{refused}") };
            if deviation.is_infinite() {
                // After removal a weight would be negative.
                continue;
            }
            let (rougher, bound) = surface.remove_knot(direction, needed, 2.0 * deviation).unwrap();
            let true_deviation = distance(&rougher, &surface);
            assert!(bound == deviation && true_deviation <= bound && true_deviation > 1e-3 * bound);
        }
        assert!(surface.remove_knot(ParameterDirection::U, 0.123, 1.0).is_err());
        assert!(surface.remove_knot(ParameterDirection::U, f64::NAN, 1.0).is_err());
    }
}

#[test]
fn pieces_are_the_surface_and_share_their_borders_to_the_last_bit() {
    for surface in [reference(), open()] {
        let pieces = surface.bezier_patches().unwrap();
        let (spans_u, spans_v) = (surface.knots_u().breaks().len() - 1, surface.knots_v().breaks().len() - 1);
        assert_eq!(pieces.len(), spans_u * spans_v);
        let (p, q) = (surface.knots_u().degree(), surface.knots_v().degree());
        let bits = |piece: &BezierPiece, i: usize, j: usize| {
            piece.patch.control_points()[i * (q + 1) + j].to_array().map(f64::to_bits)
        };
        for (index, piece) in pieces.iter().enumerate() {
            assert!(distance(&as_surface(piece), &surface) < 1e-12);
            if index % spans_v + 1 < spans_v {
                let above = &pieces[index + 1];
                assert!(piece.v[1] == above.v[0] && piece.u == above.u);
                assert!((0..=p).all(|i| bits(piece, i, q) == bits(above, i, 0)));
            }
            if let Some(right) = pieces.get(index + spans_v) {
                assert!(piece.u[1] == right.u[0] && piece.v == right.v);
                assert!((0..=q).all(|j| bits(piece, p, j) == bits(right, 0, j)));
            }
        }
    }
}

#[test]
fn weights_that_are_one_stay_exactly_one_and_planes_stay_planes() {
    let source = open();
    let plain: Vec<DVec4> =
        source.control_points().iter().map(|p| (p.truncate() / p.w).with_z(0.1).extend(1.0)).collect();
    let surface =
        NurbsSurface::from_knots(source.knots_u().clone(), source.knots_v().clone(), plain).unwrap();
    assert!(surface.is_polynomial());
    let is_plane = |points: &[DVec4]| points.iter().all(|p| p.w == 1.0 && p.z == 0.1);
    for piece in surface.bezier_patches().unwrap() {
        assert!(is_plane(piece.patch.control_points()));
    }
    let raised = surface.elevate(ParameterDirection::U).unwrap().elevate(ParameterDirection::V).unwrap();
    let cut = raised.split(ParameterDirection::U, 0.77).unwrap().0;
    let (removed, _) = surface
        .insert_knot(ParameterDirection::V, 2.5, 1)
        .and_then(|s| s.remove_knot(ParameterDirection::V, 2.5, 1e-12))
        .unwrap();
    for changed in [raised, cut, removed] {
        assert!(is_plane(changed.control_points()));
    }
}

#[test]
fn invalid_surfaces_are_refused() {
    let knots = || vec![0.0, 0.0, 1.0, 1.0];
    let with = |points: Vec<DVec4>| NurbsSurface::try_new([1, 1], [knots(), knots()], points);
    assert!(matches!(with(vec![DVec4::ONE; 3]), Err(SurfaceError::CountMismatch { expected: 4, .. })));
    for (bad, kind) in [(0.0, true), (-1.0, true), (f64::NAN, false), (f64::INFINITY, false)] {
        let refused = with(vec![DVec4::ONE, DVec4::ONE.with_w(bad), DVec4::ONE, DVec4::ONE]).unwrap_err();
        assert_eq!(matches!(refused, SurfaceError::NotPositive { .. }), kind, "{refused}");
    }
    assert!(with(vec![DVec4::ONE.with_x(f64::NAN); 4]).is_err());
    let tiny = DVec4::new(1e300, 0.0, 0.0, 1e-300);
    assert!(matches!(with(vec![tiny; 4]), Err(SurfaceError::NotFinite { .. })));
    let named = NurbsSurface::try_new([1, 1], [knots(), vec![0.0, 0.0, 1.0, f64::NAN]], vec![DVec4::ONE; 4]);
    assert!(matches!(named, Err(SurfaceError::NotFinite { parameter: "knot in v", .. })));
    let weights = NurbsSurface::try_from_points([1, 1], [knots(), knots()], &[DVec3::X; 4], Some(&[1.0; 3]));
    assert!(matches!(weights, Err(SurfaceError::CountMismatch { parameter: "weights", .. })));
    let surface = reference();
    for bad in [0.0, 1.0, -3.0, f64::NAN] {
        assert!(
            surface.split(ParameterDirection::U, bad).is_err()
                && surface.insert_knot(ParameterDirection::U, bad, 1).is_err()
        );
    }
    assert!(matches!(
        surface.insert_knot(ParameterDirection::U, 0.4, 3),
        Err(SurfaceError::KnotMultiplicity { multiplicity: 4, max: 3, .. })
    ));
    assert!(surface.insert_knot(ParameterDirection::U, 0.5, usize::MAX).is_err());
    // Parameters are clamped to the domain; NaN gives NaN, not a panic.
    assert_eq!(surface.point(-1.0, 7.0), surface.point(0.0, 1.0));
    assert!(surface.point(f64::NAN, 0.5).is_nan());
}
