//! Offsets of surfaces.

use super::*;

#[test]
fn offsets_of_elementary_surfaces_are_exact() {
    let swept = [
        FaceSurface::Extrusion {
            curve: line(at(0.0, 1.0, 0.0), vector(2.0, 0.0, 0.0)),
            direction: vector(1.0, 0.0, 1.0),
        },
        FaceSurface::Revolution {
            curve: line(at(0.5, 0.0, 1.0), vector(0.2, 0.0, -2.0)),
            origin: placement().origin,
            axis: placement().z,
        },
    ];
    for basis in elementary().into_iter().chain(swept) {
        for distance in [0.1, -0.1, -0.7] {
            let surface = FaceSurface::Offset { basis: Box::new(basis.clone()), distance };
            let beyond = matches!(basis, FaceSurface::Cone { .. } | FaceSurface::Revolution { .. });
            if distance < -0.5 && beyond {
                // The offset passes the apex within the patch.
                continue;
            }
            check(&surface, [[0.3, 5.0], [0.2, 1.2]]);
        }
    }
}

#[test]
fn offsets_of_cones_lie_on_the_nappe_from_which_they_come() {
    let cone = |radius| FaceSurface::Cone { placement: placement(), radius, half_angle: FRAC_PI_4 };
    let parts = [[0.0, TAU], [0.3, 5.0]];
    for us in parts {
        // Outward, on the other side of the apex, beside it and far from it; inward beyond the apex and before it.
        for (distance, vs) in [
            (1.0, [0.1, 0.5]),
            (1.0, [0.8, 1.2]),
            (1.0, [2.0, 3.0]),
            (-1.0, [0.1, 0.5]),
            (-1.0, [2.0, 3.0]),
            (1.0, [-0.5, -0.1]),
            (-1.0, [-3.0, -2.0]),
        ] {
            for radius in [0.0, 0.25] {
                let vs = vs.map(|v| v - radius);
                check(&FaceSurface::Offset { basis: Box::new(cone(radius)), distance }, [us, vs]);
            }
        }
    }
}

#[test]
fn offsets_that_become_spindles_keep_the_orientation_of_their_basis() {
    let torus = FaceSurface::Torus {
        placement: placement(),
        major_radius: 0.5,
        minor_radius: 0.4,
        select_outer: true,
    };
    let ranges = [[0.0, 1.0], [0.0, 1.0]];
    let basis =
        Box::new(FaceSurface::Rectangular { basis: Box::new(torus), ranges, same_sense: [true, false] });
    let converted = check(&FaceSurface::Offset { basis, distance: -0.3 }, [[0.3, 5.0], [-1.0, 1.0]]);
    assert!(converted.reversed && matches!(converted.carrier, Carrier::Spline(_)));
}

#[test]
fn offsets_of_splines_are_fitted_within_the_tolerance() {
    let bases = [
        FaceSurface::Extrusion { curve: Box::new(spline_curve()), direction: vector(0.3, 2.0, 0.1) },
        FaceSurface::Revolution {
            curve: Box::new(spline_curve()),
            origin: placement().origin,
            axis: placement().z,
        },
    ];
    for basis in bases {
        let ranges = [[0.1, 0.45], [0.1, 0.45]];
        let extent = Bounds3::from_points(grid(ranges).map(|(u, v)| definition(&basis, u, v))).expanded(0.1);
        let surface = FaceSurface::Offset { basis: Box::new(basis), distance: 0.02 };
        for tolerance in [1e-4, 1e-6] {
            let converted = Carrier::try_from_surface(&surface, extent, tolerance).unwrap();
            assert!(converted.deviation <= tolerance && converted.deviation > 0.0);
            for (u, v) in grid(ranges) {
                let point = definition(&surface, u, v);
                // The definition differentiates numerically.
                let found = converted.carrier.parameters(point, None);
                assert!(
                    found.distance <= converted.deviation + 1e-9,
                    "{} {}",
                    found.distance,
                    converted.deviation
                );
                if let Some(map) = converted.parameters {
                    let there = converted.carrier.point(map.transform_point2(DVec2::new(u, v)));
                    assert!(there.distance(point) <= converted.deviation + 1e-9);
                }
            }
        }
    }
    // A fold has no normal that is continuous.
    let fold = Curve::Polyline(vec![at(0.0, 0.0, 0.0), at(1.0, 0.0, 0.0), at(1.0, 1.0, 0.0)]);
    let basis = Box::new(FaceSurface::Extrusion { curve: Box::new(fold), direction: vector(0.0, 0.0, 1.0) });
    let extent = Bounds3::new(DVec3::NEG_ONE, DVec3::ONE);
    let refused = Carrier::try_from_surface(&FaceSurface::Offset { basis, distance: 0.1 }, extent, 1e-6);
    assert!(matches!(refused, Err(BrepError::Unfitted { deviation, .. }) if deviation > 1e-3));
}

#[test]
fn offsets_of_sharp_splines_are_divided_where_they_bend() {
    // A parabola whose radius is 0.4 at its vertex, in one piece from x = -1 to 1, extruded: straight in v.
    let (radius, distance, tolerance) = (0.4, 0.05, 1e-8);
    let points = [(-1.0, 1.0), (0.0, -1.0), (1.0, 1.0)].map(|(x, y)| at(x, y / (2.0 * radius), 0.0));
    let knots = vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0];
    let curve =
        Curve::Spline(SplineCurve::try_new(2, knots, points.map(|p| p.extend(1.0)).to_vec()).unwrap());
    let basis = Box::new(FaceSurface::Extrusion { curve: Box::new(curve), direction: vector(0.0, 0.0, 1.0) });
    let extent = Bounds3::from_points([at(-1.5, -1.0, 0.0), at(1.5, 2.0, 1.0)]);
    let converted =
        Carrier::try_from_surface(&FaceSurface::Offset { basis, distance }, extent, tolerance).unwrap();
    assert!(converted.deviation <= tolerance);
    for i in 0..=100 {
        let x = f64::from(i) / 50.0 - 1.0;
        let slope = x / radius;
        let along = distance / slope.hypot(1.0);
        let exact = at(x + slope * along, x * slope / 2.0 - along, 0.3);
        assert!(converted.carrier.parameters(exact, None).distance <= converted.deviation);
    }
    let Carrier::Spline(spline) = &converted.carrier else { panic!("{converted:?}") };
    // The parabola bends most in its middle, and is divided there alone.
    let parts: Vec<f64> =
        spline.surface().knots_u().breaks().windows(2).map(|ends| ends[1] - ends[0]).collect();
    assert!(parts[parts.len() / 2] < 0.6 * parts[0], "{parts:?}");
    // No more than 64 parts along the parabola and one across.
    assert!(spline.surface().control_points().len() <= (64 + 5) * 6);
}

#[test]
fn offsets_of_turned_splines_are_divided_along_the_profile_alone() {
    // A vase of radii between 10 and 20 mm.
    let profile = [(0.012, 0.0), (0.020, 0.015), (0.010, 0.035), (0.015, 0.050)];
    let points = profile.map(|(x, z)| at(x, 0.0, z).extend(1.0)).to_vec();
    let knots = [0, 0, 0, 0, 1, 1, 1, 1].map(f64::from).to_vec();
    let curve = Box::new(Curve::Spline(SplineCurve::try_new(3, knots, points).unwrap()));
    let turned = FaceSurface::Revolution { curve, origin: DVec3::ZERO, axis: DVec3::Z };
    let extent = Bounds3::new(at(-0.02, -0.02, 0.0), at(0.02, 0.02, 0.05));
    let Carrier::Spline(spline) = Carrier::try_from_surface(&turned, extent, 1e-9).unwrap().carrier else {
        panic!("not a spline")
    };
    let (distance, tolerance) = (-0.0012, 1e-10);
    let basis = Box::new(FaceSurface::Spline(spline.surface().clone()));
    let converted =
        Carrier::try_from_surface(&FaceSurface::Offset { basis, distance }, extent, tolerance).unwrap();
    assert!(converted.deviation <= tolerance, "{}", converted.deviation);
    let Carrier::Spline(fitted) = &converted.carrier else { panic!("{converted:?}") };
    // Quarters of a circle are one part each.
    assert_eq!(fitted.surface().counts().0, 21);
    for (u, v) in grid([[0.0, 1.0], [0.0, 1.0]]) {
        let [[_, end_u], [_, end_v]] = spline.domain();
        let uv = DVec2::new(u * end_u, v * end_v);
        let exact = spline.point(uv) + spline.normal(uv).unwrap() * distance;
        assert!(converted.carrier.parameters(exact, None).distance <= converted.deviation);
    }
}
