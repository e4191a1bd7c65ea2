//! Carriers against the definitions of the surfaces.

mod offset;

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, TAU};

use glanz_geometry::spline::NurbsSurface;
use glanz_math::{Bounds3, DVec2, DVec3};
use proptest::prelude::*;

use super::*;
use crate::BrepError;
use crate::model::{Curve, FaceSurface, SplineCurve};

fn placement() -> Placement {
    let x = DVec3::new(2.0, -1.0, 2.0) / 3.0;
    let y = DVec3::new(2.0, 2.0, -1.0) / 3.0;
    Placement { origin: DVec3::new(0.3, -1.2, 0.7), x, y, z: x.cross(y) }
}

fn at(x: f64, y: f64, z: f64) -> DVec3 {
    let p = placement();
    p.origin + p.vector(DVec3::new(x, y, z))
}

fn vector(x: f64, y: f64, z: f64) -> DVec3 {
    placement().vector(DVec3::new(x, y, z))
}

/// The definition of @iso10303-42, word for word; the slow twin of the conversions.
fn definition(surface: &FaceSurface, u: f64, v: f64) -> DVec3 {
    let turned = |p: DVec3, origin: DVec3, axis: DVec3| {
        let r = p - origin;
        let height = axis * r.dot(axis);
        let radial = r - height;
        origin + height + radial * u.cos() + axis.cross(radial) * u.sin()
    };
    let around = |f: &Placement, rho: f64, z: f64| f.origin + (f.x * u.cos() + f.y * u.sin()) * rho + f.z * z;
    match surface {
        FaceSurface::Plane(f) => f.origin + f.x * u + f.y * v,
        FaceSurface::Cylinder { placement, radius } => around(placement, *radius, v),
        FaceSurface::Cone { placement, radius, half_angle } => {
            around(placement, radius + v * half_angle.tan(), v)
        }
        FaceSurface::Sphere { placement, radius } => around(placement, radius * v.cos(), radius * v.sin()),
        FaceSurface::Torus { placement, major_radius, minor_radius, .. } => {
            around(placement, major_radius + minor_radius * v.cos(), minor_radius * v.sin())
        }
        FaceSurface::Spline(surface) => surface.point(u, v),
        FaceSurface::Revolution { curve, origin, axis } => turned(curve.point(v), *origin, *axis),
        FaceSurface::Extrusion { curve, direction } => curve.point(u) + *direction * v,
        FaceSurface::Offset { basis, distance } => definition(basis, u, v) + normal(basis, u, v) * *distance,
        FaceSurface::Rectangular { basis, same_sense, .. } => {
            let sign = same_sense.map(|s| if s { 1.0 } else { -1.0 });
            definition(basis, sign[0] * u, sign[1] * v)
        }
    }
}

fn normal(surface: &FaceSurface, u: f64, v: f64) -> DVec3 {
    let h = 1e-5;
    let du = definition(surface, u + h, v) - definition(surface, u - h, v);
    let dv = definition(surface, u, v + h) - definition(surface, u, v - h);
    du.cross(dv).normalize()
}

fn grid([u, v]: [[f64; 2]; 2]) -> impl Iterator<Item = (f64, f64)> {
    let mix = |[a, b]: [f64; 2], i: i32| a + (b - a) * (f64::from(i) + 0.37) / 8.0;
    (0..8).flat_map(move |i| (0..8).map(move |j| (mix(u, i), mix(v, j))))
}

/// Converts the surface for a face over ranges of u and v and checks points, normals and parameters. Returns the conversion.
fn check(surface: &FaceSurface, ranges: [[f64; 2]; 2]) -> CarrierConversion {
    let extent = Bounds3::from_points(grid(ranges).map(|(u, v)| definition(surface, u, v)));
    let converted = Carrier::try_from_surface(surface, extent, 1e-7).unwrap();
    let carrier = &converted.carrier;
    for (u, v) in grid(ranges) {
        let point = definition(surface, u, v);
        let found = carrier.parameters(point, None);
        assert!(found.distance < 1e-8, "{converted:?} at {u} {v}: {}", found.distance);
        assert!(carrier.point(found.uv).distance(point) < 1e-8);
        let sign = if converted.reversed { -1.0 } else { 1.0 };
        let expected = normal(surface, u, v) * sign;
        assert!(carrier.normal(found.uv).unwrap().distance(expected) < 1e-4, "{converted:?} at {u} {v}");
        if let Some(map) = converted.parameters {
            let uv = map.transform_point2(DVec2::new(u, v));
            assert!(carrier.point(uv).distance(point) < 1e-8, "{converted:?} at {u} {v}");
            let near = carrier.parameters(point, Some(uv + DVec2::new(0.3, 0.1)));
            assert!(near.uv.distance(uv) < 1e-6, "{converted:?}: {} {uv}", near.uv);
        }
    }
    converted
}

const PATCH: [[f64; 2]; 2] = [[0.3, 5.0], [0.2, 1.3]];

fn line(origin: DVec3, direction: DVec3) -> Box<Curve<DVec3>> {
    Box::new(Curve::Line { origin, direction })
}

fn spline_curve() -> Curve<DVec3> {
    let points = [(0.5, 0.0, 0.0, 1.0), (0.8, 0.1, 0.3, 1.0), (0.4, 0.0, 0.9, 2.0), (0.9, 0.2, 1.4, 1.0)];
    let points = points.map(|(x, y, z, w)| at(x, y, z).extend(1.0) * w).to_vec();
    Curve::Spline(SplineCurve::try_new(2, vec![0.0, 0.0, 0.0, 0.5, 1.5, 1.5, 1.5], points).unwrap())
}

/// One of each surface that is a carrier as it is.
fn elementary() -> [FaceSurface; 5] {
    let placement = placement();
    [
        FaceSurface::Plane(placement),
        FaceSurface::Cylinder { placement, radius: 0.5 },
        FaceSurface::Cone { placement, radius: 0.5, half_angle: 0.4 },
        FaceSurface::Sphere { placement, radius: 0.5 },
        FaceSurface::Torus { placement, major_radius: 0.9, minor_radius: 0.3, select_outer: true },
    ]
}

#[test]
fn elementary_surfaces_keep_their_parameters() {
    for surface in elementary() {
        let converted = check(&surface, PATCH);
        assert!(converted.deviation == 0.0 && !converted.reversed);
        assert_eq!(converted.parameters, Some(glanz_math::glam::DAffine2::IDENTITY));
    }
}

#[test]
fn faces_beyond_the_apex_lie_on_a_cone_that_is_turned() {
    let surface = FaceSurface::Cone { placement: placement(), radius: 0.5, half_angle: 0.4 };
    let converted = check(&surface, [[0.1, 2.0], [-3.0, -2.0]]);
    let Carrier::Cone { radius, .. } = converted.carrier else { panic!("{converted:?}") };
    assert_eq!(radius, 0.0);
}

#[test]
fn revolved_lines_are_cylinders_cones_and_planes() {
    let (origin, axis) = (placement().origin, placement().z);
    let revolution = |curve| FaceSurface::Revolution { curve, origin, axis };
    for rise in [2.0, -2.0] {
        let cylinder = check(&revolution(line(at(0.3, 0.4, 1.0), vector(0.0, 0.0, rise))), PATCH);
        assert!(matches!(cylinder.carrier, Carrier::Cylinder { radius, .. } if (radius - 0.5).abs() < 1e-15));
        assert_eq!(cylinder.reversed, rise < 0.0);
        for outward in [0.6, -0.1, -4.0] {
            let direction = vector(outward, 0.0, rise);
            let cone = check(&revolution(line(at(0.5, 0.0, 1.0), direction)), PATCH);
            let Carrier::Cone { half_angle, .. } = cone.carrier else { panic!("{cone:?}") };
            assert!((half_angle - (outward / rise).abs().atan()).abs() < 1e-15);
        }
    }
    for outward in [0.5, -0.5] {
        let plane = check(&revolution(line(at(1.0, 0.0, 1.0), vector(outward, 0.0, 0.0))), PATCH);
        assert!(matches!(plane.carrier, Carrier::Plane(_)) && plane.parameters.is_none());
    }
}

#[test]
fn trimmed_profiles_keep_their_own_parameters() {
    let (origin, axis) = (placement().origin, placement().z);
    let cone = line(at(0.5, 0.0, 1.0), vector(1.0, 0.0, 1.0));
    let circle =
        Curve::Ellipse { center: at(0.0, 0.0, 0.2), a: vector(0.5, 0.0, 0.0), b: vector(0.0, 0.0, 0.5) };
    let back = |basis, range| Box::new(Curve::Trimmed { basis, range, same_sense: false });
    for range in [[0.2, -0.4], [-0.6, -2.5]] {
        let surface = FaceSurface::Revolution { curve: back(cone.clone(), range), origin, axis };
        let converted = check(&surface, [[0.3, 5.0], [-range[0], -range[1]]]);
        assert!(matches!(converted.carrier, Carrier::Cone { .. }));
    }
    for range in [[1.0, -1.0], [4.0, 2.0]] {
        let surface = FaceSurface::Revolution { curve: back(Box::new(circle.clone()), range), origin, axis };
        let converted = check(&surface, [[0.3, 5.0], [-range[0], -range[1]]]);
        assert!(matches!(converted.carrier, Carrier::Sphere { .. }));
    }
    let arc =
        Curve::Ellipse { center: at(1.0, 0.0, 0.2), a: vector(0.0, 0.0, 0.5), b: vector(0.5, 0.0, 0.0) };
    let surface = FaceSurface::Revolution { curve: back(Box::new(arc), [1.0, -1.0]), origin, axis };
    assert!(matches!(check(&surface, [[0.3, 5.0], [-1.0, 1.0]]).carrier, Carrier::Torus { .. }));
}

#[test]
fn revolved_circles_are_spheres_and_tori() {
    let (origin, axis) = (placement().origin, placement().z);
    for sign in [1.0, -1.0] {
        let circle = |x: f64| {
            let (a, b) = (vector(0.3, 0.0, 0.4), vector(-0.4, 0.0, 0.3) * sign);
            Box::new(Curve::Ellipse { center: at(x, 0.0, 0.2), a, b })
        };
        let sphere = FaceSurface::Revolution { curve: circle(0.0), origin, axis };
        let converted = check(&sphere, [[0.3, 5.0], [-0.5, 0.5]]);
        assert!(matches!(converted.carrier, Carrier::Sphere { radius, .. } if (radius - 0.5).abs() < 1e-15));
        let torus = FaceSurface::Revolution { curve: circle(-0.8), origin, axis };
        let converted = check(&torus, [[0.3, 5.0], [-0.5, 0.5]]);
        assert!(
            matches!(converted.carrier, Carrier::Torus { major_radius, .. } if (major_radius - 0.8).abs() < 1e-15)
        );
    }
}

#[test]
fn other_revolutions_are_splines_with_a_period_of_one_turn() {
    let (origin, axis) = (placement().origin, placement().z);
    let profiles = [
        spline_curve(),
        // Askew: a hyperboloid.
        Curve::Line { origin: at(0.5, 0.0, 0.0), direction: vector(0.0, 0.3, 1.0) },
        Curve::Ellipse { center: at(0.5, 0.0, 0.0), a: vector(0.2, 0.0, 0.0), b: vector(0.0, 0.0, 0.3) },
        Curve::Parabola { apex: at(0.3, 0.0, 0.0), a: vector(0.4, 0.0, 0.0), b: vector(0.0, 0.0, 0.4) },
        Curve::Hyperbola { center: at(0.0, 0.0, 0.0), a: vector(0.4, 0.0, 0.0), b: vector(0.0, 0.0, 0.3) },
    ];
    for profile in profiles {
        let surface = FaceSurface::Revolution { curve: Box::new(profile), origin, axis };
        let converted = check(&surface, PATCH);
        let Carrier::Spline(spline) = &converted.carrier else { panic!("{converted:?}") };
        assert!(converted.carrier.periods()[0].is_some() && converted.parameters.is_none());
        assert!(spline.surface().control_points().len() % 9 == 0);
    }
}

#[test]
fn extrusions_are_planes_cylinders_and_splines() {
    let extrusion = |curve, direction| FaceSurface::Extrusion { curve, direction };
    let plane =
        check(&extrusion(line(at(0.0, 1.0, 0.0), vector(2.0, 0.0, 0.0)), vector(1.0, 0.0, 1.0)), PATCH);
    assert!(matches!(plane.carrier, Carrier::Plane(_)) && !plane.reversed);
    let circle = |sign: f64| Curve::Ellipse {
        center: at(0.0, 0.0, 0.2),
        a: vector(0.0, 0.5, 0.0),
        b: vector(0.5 * sign, 0.0, 0.0),
    };
    for (sign, rise) in [(1.0, 2.0), (-1.0, 2.0), (1.0, -2.0), (-1.0, -2.0)] {
        let cylinder = check(&extrusion(Box::new(circle(sign)), vector(0.0, 0.0, rise)), PATCH);
        assert!(matches!(cylinder.carrier, Carrier::Cylinder { .. }));
        assert_eq!(cylinder.reversed, sign * rise > 0.0);
        let oblique = check(&extrusion(Box::new(circle(sign)), vector(0.3, 0.0, rise)), PATCH);
        assert!(matches!(oblique.carrier, Carrier::Spline(_)) && oblique.carrier.periods()[0].is_some());
    }
    let ruled = check(&extrusion(Box::new(spline_curve()), vector(0.3, 2.0, 0.1)), [[0.1, 1.4], [-0.3, 1.3]]);
    assert!(ruled.parameters.is_some());
    let parabola =
        Curve::Parabola { apex: at(0.3, 0.0, 0.0), a: vector(0.4, 0.0, 0.0), b: vector(0.0, 0.0, 0.4) };
    assert!(check(&extrusion(Box::new(parabola), vector(0.0, 1.0, 0.0)), PATCH).parameters.is_some());
}

#[test]
fn frames_are_orthonormal_whatever_direction_they_are_given() {
    let z = DVec3::new(0.2, -0.7, 0.4).normalize();
    let across = z.any_orthonormal_vector();
    for share in [1.0, 1e-3, 1e-7, 1e-9, 1e-12, 1e-16, 0.0] {
        let frame = Placement::from_axis(DVec3::ZERO, z, (z + across * share) * 3.0);
        let products = [frame.x.dot(frame.y), frame.y.dot(frame.z), frame.z.dot(frame.x)];
        assert!(products.iter().all(|product| product.abs() < 1e-15), "{share}: {products:?}");
        assert!([frame.x, frame.y].iter().all(|axis| (axis.length() - 1.0).abs() < 1e-15));
        assert!(share < 1e-7 || frame.x.distance(across) < 1e-7);
    }
}

#[test]
fn rectangles_of_surfaces_without_edges_are_refused() {
    let basis = Box::new(FaceSurface::Sphere { placement: placement(), radius: 0.5 });
    let surface = FaceSurface::Rectangular { basis, ranges: [[0.0, 1.0]; 2], same_sense: [true; 2] };
    let refused = Carrier::try_from_surface(&surface, Bounds3::EMPTY, 1e-7).unwrap_err();
    assert_eq!(refused, BrepError::UnappliedRange);
}

#[test]
fn rectangles_run_along_their_senses() {
    let basis = Box::new(FaceSurface::Cylinder { placement: placement(), radius: 0.5 });
    for same_sense in [[true, false], [false, true], [false, false]] {
        let ranges = [[0.0, 1.0], [0.0, 1.0]];
        let converted = check(&FaceSurface::Rectangular { basis: basis.clone(), ranges, same_sense }, PATCH);
        assert_eq!(converted.reversed, same_sense[0] != same_sense[1]);
    }
}

#[test]
fn tubes_that_meet_the_axis_are_splines_with_two_poles() {
    let (placement, major_radius, minor_radius): (_, f64, f64) = (placement(), 0.3, 0.5);
    let end = (-major_radius / minor_radius).acos();
    for (select_outer, range) in [(true, [-end, end]), (false, [end, TAU - end])] {
        let surface = FaceSurface::Torus { placement, major_radius, minor_radius, select_outer };
        let inset = 0.05;
        let converted = check(&surface, [[0.0, TAU], [range[0] + inset, range[1] - inset]]);
        let poles = converted.carrier.poles();
        assert_eq!(poles.len(), 2);
        // 0.3^2 + h^2 = 0.5^2.
        let heights: Vec<f64> = poles.iter().map(|pole| placement.to_local(pole.point).z).collect();
        let sign = if select_outer { -1.0 } else { 1.0 };
        assert!((heights[0] - sign * 0.4).abs() < 1e-15 && (heights[1] + sign * 0.4).abs() < 1e-15);
        for pole in poles {
            for u in [0.0, 0.3, 1.0] {
                assert!(converted.carrier.point(DVec2::new(u, pole.value)).distance(pole.point) < 1e-15);
            }
        }
    }
}

#[test]
fn domains_poles_and_periods_are_those_of_the_surfaces() {
    let placement = placement();
    let cone = Carrier::Cone { placement, radius: 0.5, half_angle: FRAC_PI_4 };
    assert!((cone.domain()[1][0] + 0.5).abs() < 1e-15);
    assert!(cone.poles()[0].point.distance(at(0.0, 0.0, -0.5)) < 1e-15);
    let sphere = Carrier::Sphere { placement, radius: 0.5 };
    assert_eq!(sphere.domain(), [[0.0, TAU], [-FRAC_PI_2, FRAC_PI_2]]);
    assert_eq!(sphere.periods(), [Some(TAU), None]);
    assert!(sphere.poles()[1].point.distance(at(0.0, 0.0, 0.5)) < 1e-15);
    // The angle at a pole is that of the neighbour.
    let found = sphere.parameters(sphere.poles()[1].point, Some(DVec2::new(7.0, 1.0)));
    assert!((found.uv.y - FRAC_PI_2).abs() < 1e-7);
    let beyond = cone.parameters(at(0.0, 0.0, -2.0), None);
    assert!((beyond.uv.y + 0.5).abs() < 1e-15 && (beyond.distance - 1.5).abs() < 1e-15);
}

/// A quarter of a tube as a spline with parameters that are far from metres; its ends differ by `gap`.
fn closed_spline(gap: f64) -> NurbsSurface {
    let ring = [(1.0, 0.0), (1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0), (1.0, gap)];
    let points: Vec<DVec3> =
        ring.iter().flat_map(|(x, y)| [0.0, 2.0].map(|z| DVec3::new(*x, *y, z))).collect();
    let knots = [vec![5.0, 5.0, 5.0, 6.0, 7.0, 8.0, 9.0, 9.0, 9.0], vec![-100.0, -100.0, 100.0, 100.0]];
    NurbsSurface::try_from_points([2, 1], knots, &points, None).unwrap()
}

#[test]
fn closed_splines_have_a_period_in_metres() {
    let converted = check(&FaceSurface::Spline(closed_spline(0.0)), [[5.0, 9.0], [-100.0, 100.0]]);
    let period = converted.carrier.periods();
    assert!(period[1].is_none() && (period[0].unwrap() - 8.0).abs() < 1e-12, "{period:?}");
    assert_eq!(converted.carrier.domain()[1], [0.0, 2.0]);
    let carrier = &converted.carrier;
    for uv in [DVec2::new(-0.1, 0.5), DVec2::new(8.3, 1.0)] {
        let found = carrier.parameters(carrier.point(uv), Some(uv + DVec2::new(0.4, 0.1)));
        assert!(found.uv.distance(uv) < 1e-12, "{uv} {}", found.uv);
    }
}

#[test]
fn borders_within_the_tolerance_are_joined_and_the_distance_is_reported() {
    let extent = Bounds3::new(DVec3::NEG_ONE, DVec3::ONE);
    let convert =
        |gap| Carrier::try_from_surface(&FaceSurface::Spline(closed_spline(gap)), extent, 1e-6).unwrap();
    let near = convert(1e-7);
    assert!(near.carrier.periods()[0].is_some() && (near.deviation - 0.5e-7).abs() < 1e-12);
    let far = convert(1e-5);
    assert!(far.carrier.periods()[0].is_none() && far.deviation == 0.0);
}

#[test]
fn surfaces_without_area_are_refused() {
    let extent = Bounds3::new(DVec3::NEG_ONE, DVec3::ONE);
    let refused = |surface| Carrier::try_from_surface(&surface, extent, 1e-7).unwrap_err();
    let direction = vector(0.0, 0.0, 1.0);
    let along = FaceSurface::Extrusion { curve: line(at(0.0, 0.0, 0.0), direction), direction };
    assert!(matches!(refused(along), BrepError::DegenerateSurface { .. }));
    let basis = Box::new(FaceSurface::Sphere { placement: placement(), radius: 0.5 });
    assert!(matches!(
        refused(FaceSurface::Offset { basis, distance: -0.5 }),
        BrepError::DegenerateSurface { value: 0.0, .. }
    ));
    let basis = Box::new(FaceSurface::Sphere { placement: placement(), radius: 0.5 });
    let rounded = FaceSurface::Offset { basis, distance: 1e-16 - 0.5 };
    assert!(matches!(refused(rounded), BrepError::DegenerateSurface { .. }));
    let tilted = vector(1e-15, 0.0, 1.0);
    let along = FaceSurface::Extrusion { curve: line(at(0.0, 0.0, 0.0), tilted), direction };
    assert!(matches!(refused(along), BrepError::DegenerateSurface { .. }));
    let on_axis = line(at(1e-17, 0.0, 0.0), direction);
    let spindle = FaceSurface::Revolution { curve: on_axis, origin: placement().origin, axis: placement().z };
    assert!(matches!(refused(spindle), BrepError::DegenerateSurface { .. }));
    let askew = line(at(0.5, 0.0, 0.0), vector(0.0, 0.3, 1.0));
    let unbounded = FaceSurface::Revolution { curve: askew, origin: placement().origin, axis: placement().z };
    let refused = Carrier::try_from_surface(&unbounded, Bounds3::EMPTY, 1e-7).unwrap_err();
    assert_eq!(refused, BrepError::UnboundedExtent);
}

proptest! {
    #[test]
    fn parameters_of_analytic_carriers_are_those_of_the_nearest_point(
        x in -2.0..2.0, y in -2.0..2.0, z in -2.0..2.0
    ) {
        let (placement, query) = (placement(), at(x, y, z));
        let carriers = [
            Carrier::Cylinder { placement, radius: 0.5 },
            Carrier::Cone { placement, radius: 0.5, half_angle: 0.4 },
            Carrier::Sphere { placement, radius: 0.5 },
            Carrier::Torus { placement, major_radius: 0.9, minor_radius: 0.3 },
        ];
        for carrier in carriers {
            let found = carrier.parameters(query, None);
            let [low, high] = carrier.domain()[1].map(|v| v.clamp(-4.0, TAU));
            for (i, j) in (0..64).flat_map(|i| (0..=64).map(move |j| (f64::from(i), f64::from(j)))) {
                let uv = DVec2::new(i / 64.0 * TAU, low + (high - low) * j / 64.0);
                prop_assert!(found.distance <= carrier.point(uv).distance(query) + 1e-12, "{:?} {}", carrier, uv);
            }
            let [du, dv] = carrier.tangents(found.uv);
            let h = 1e-6;
            let difference = |d: DVec2| (carrier.point(found.uv + d * h) - carrier.point(found.uv - d * h)) / (2.0 * h);
            prop_assert!(du.distance(difference(DVec2::X)) < 1e-8 && dv.distance(difference(DVec2::Y)) < 1e-8);
        }
    }
}
