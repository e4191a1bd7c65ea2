//! Faces that end at the borders of their surfaces, polygons beside their planes, and geometry that no scene takes.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glanz_geometry::spline::{KnotVector, NurbsSurface};
use glanz_math::glam::DVec4;

use super::*;
use crate::error::BrepError;

/// The face without edges on a part of a surface.
fn part(basis: FaceSurface, ranges: [[f64; 2]; 2], same_sense: [bool; 2]) -> TrimmedFace {
    let mut model = ModelBuilder::default();
    model.bounded(FaceSurface::Rectangular { basis: Box::new(basis), ranges, same_sense }, true, Vec::new());
    model.faces().remove(0)
}

#[test]
fn range_of_a_surface_without_edges_is_applied() {
    let cylinder = || FaceSurface::Cylinder { placement: WORLD, radius: 2.0 };
    let sphere = || FaceSurface::Sphere { placement: WORLD, radius: 2.0 };
    let cone = || FaceSurface::Cone { placement: WORLD, radius: 1.0, half_angle: PI / 6.0 };
    let torus =
        || FaceSurface::Torus { placement: WORLD, major_radius: 3.0, minor_radius: 1.0, select_outer: true };
    for (name, basis, ranges, area) in [
        ("plane", FaceSurface::Plane(WORLD), [[-1.0, 2.0], [3.0, 5.0]], 6.0),
        ("cylinder", cylinder(), [[0.5, 1.5], [1.0, 3.0]], 4.0),
        ("cylinder over the seam", cylinder(), [[6.0, 1.0], [1.0, 3.0]], 4.0 * (TAU - 5.0)),
        ("whole turn", cylinder(), [[0.0, TAU], [1.0, 3.0]], 4.0 * TAU),
        ("whole turn from elsewhere", cylinder(), [[1.0, 1.0 + TAU], [1.0, 3.0]], 4.0 * TAU),
        // Ends with the digits of a file, less and more than a turn apart.
        ("whole turn downwards", cylinder(), [[TAU - 2e-10, 0.0], [1.0, 3.0]], 4.0 * TAU),
        ("more than a turn downwards", cylinder(), [[TAU + 8e-10, 0.0], [1.0, 3.0]], 4.0 * TAU),
        ("cone", cone(), [[0.0, 1.0], [0.0, 2.0]], cone_area(0.0, 2.0)),
        (
            "cone to its apex",
            cone(),
            [[0.0, TAU], [-(3.0_f64.sqrt()), 0.0]],
            TAU * cone_area(-(3.0_f64.sqrt()), 0.0),
        ),
        ("sphere", sphere(), [[0.0, 1.0], [0.25, 1.0]], 4.0 * (1.0_f64.sin() - 0.25_f64.sin())),
        ("sphere to its pole", sphere(), [[0.5, 1.5], [0.0, FRAC_PI_2]], 4.0),
        ("cap", sphere(), [[0.0, TAU], [0.5, FRAC_PI_2]], 4.0 * TAU * (1.0 - 0.5_f64.sin())),
        ("whole sphere", sphere(), [[0.0, TAU], [-FRAC_PI_2, FRAC_PI_2]], 8.0 * TAU),
        ("torus", torus(), [[0.5, 2.0], [1.0, 2.0]], 1.5 * (3.0 + 2.0_f64.sin() - 1.0_f64.sin())),
        ("tube of a torus", torus(), [[0.5, 2.0], [0.0, TAU]], 1.5 * 3.0 * TAU),
        ("ring of a torus", torus(), [[0.0, TAU], [6.0, 7.0]], TAU * (3.0 + 7.0_f64.sin() - 6.0_f64.sin())),
    ] {
        let measured = part(basis, ranges, [true; 2]).measure(1e-9).area;
        assert!((measured - area).abs() <= 1e-7 * area, "{name}: {measured}, not {area}");
    }
}

/// The area of a radian of the cone of radius 1 and half angle pi / 6 between two heights: the integral of r / cos a.
fn cone_area(low: f64, high: f64) -> f64 {
    let (tan, cos) = ((PI / 6.0).tan(), (PI / 6.0).cos());
    let integral = |v: f64| v + 0.5 * v * v * tan;
    (integral(high) - integral(low)) / cos
}

#[test]
fn range_that_misses_a_turn_by_less_than_the_uncertainty_goes_around() {
    let area = |uncertainty: f64| {
        let mut model = ModelBuilder::default();
        model.0.uncertainty = uncertainty;
        let basis = Box::new(FaceSurface::Cylinder { placement: WORLD, radius: 2.0 });
        // 2.7e-5 rad, or 5.4e-5 m, short of a turn.
        let ranges = [[0.0, 6.283_158], [1.0, 3.0]];
        model.bounded(FaceSurface::Rectangular { basis, ranges, same_sense: [true; 2] }, true, Vec::new());
        trimmed_faces(&model.0).faces.remove(0).unwrap().measure(1e-9).area
    };
    assert!((area(1e-4) - 4.0 * TAU).abs() < 1e-6, "{}", area(1e-4));
    assert!((area(1e-6) - 4.0 * 6.283_158).abs() < 1e-6, "{}", area(1e-6));
}

#[test]
fn ranges_that_are_empty_or_go_beyond_a_pole_are_refused_with_the_reason() {
    let cylinder = || FaceSurface::Cylinder { placement: WORLD, radius: 2.0 };
    let sphere = || FaceSurface::Sphere { placement: WORLD, radius: 2.0 };
    // The apex is at z = -1.
    let cone = || FaceSurface::Cone { placement: WORLD, radius: 1.0, half_angle: PI / 4.0 };
    for (basis, ranges, reason) in [
        (cylinder(), [[1.0, 1.0], [1.0, 3.0]], "the range of a parameter is empty"),
        (cylinder(), [[0.0, 1.0], [3.0, 3.0]], "the range of a parameter is empty"),
        (cone(), [[0.0, 1.0], [-2.0, 2.0]], "beyond its apex or pole"),
        (sphere(), [[0.0, 1.0], [0.0, 2.0]], "beyond its apex or pole"),
    ] {
        let mut model = ModelBuilder::default();
        let basis = Box::new(basis);
        model.bounded(FaceSurface::Rectangular { basis, ranges, same_sense: [true; 2] }, true, Vec::new());
        let refusal = trimmed_faces(&model.0).faces.remove(0).unwrap_err().to_string();
        assert!(refusal.contains(reason), "{refusal}");
    }
}

#[test]
fn range_that_runs_backwards_turns_the_normal() {
    let cylinder = || FaceSurface::Cylinder { placement: WORLD, radius: 2.0 };
    let along = part(cylinder(), [[0.5, 1.5], [1.0, 3.0]], [true, true]);
    let back = part(cylinder(), [[1.5, 0.5], [1.0, 3.0]], [false, true]);
    let twice = part(cylinder(), [[1.5, 0.5], [3.0, 1.0]], [false, false]);
    for face in [&along, &back, &twice] {
        assert_close(face.measure(1e-9).area, 4.0);
    }
    assert!(!along.reversed && back.reversed && !twice.reversed);
}

#[test]
fn range_of_a_swept_curve_is_applied_where_it_needs_no_end() {
    let revolved = |curve: Curve<DVec3>| {
        let mut model = ModelBuilder::default();
        let basis =
            Box::new(FaceSurface::Revolution { curve: Box::new(curve), origin: DVec3::ZERO, axis: DVec3::Z });
        let ranges = [[0.0, 1.0], [0.0, 1.0]];
        model.bounded(FaceSurface::Rectangular { basis, ranges, same_sense: [true; 2] }, true, Vec::new());
        trimmed_faces(&model.0).faces.remove(0)
    };
    let cylinder = revolved(Curve::Line { origin: DVec3::X, direction: DVec3::Z }).unwrap();
    assert_close(cylinder.measure(1e-9).area, 1.0);
    let endless = revolved(Curve::Parabola { apex: DVec3::X, a: DVec3::X, b: DVec3::Z }).unwrap_err();
    let expected = FaceRefusal::Surface { entity: EntityId(2000), error: BrepError::UnboundedExtent };
    assert_eq!(endless, expected);
}

#[test]
fn border_of_a_bounded_surface_is_the_outer_loop_around_holes() {
    let mut model = ModelBuilder::default();
    let rim = model.circle(0.25, 0.0);
    let line = || KnotVector::try_new(1, vec![0.0, 0.0, 1.0, 1.0]).unwrap();
    let corner = |x: f64, y: f64| DVec4::new(x - 0.5, y - 0.5, 0.0, 1.0);
    let points = vec![corner(0.0, 0.0), corner(0.0, 1.0), corner(1.0, 0.0), corner(1.0, 1.0)];
    let square = NurbsSurface::from_knots(line(), line(), points).unwrap();
    let hole = BoundaryLoop::Edges(vec![OrientedEdge { edge: rim, forward: false }]);
    model.bounded(FaceSurface::Spline(square.clone()), true, vec![BoundaryLoop::Border, hole]);
    model.bounded(FaceSurface::Spline(square), true, vec![BoundaryLoop::Border]);
    let areas: Vec<f64> = model.faces().iter().map(|face| face.measure(1e-10).area).collect();
    assert_close(areas[0], 1.0 - PI / 16.0);
    assert_close(areas[1], 1.0);
}

#[test]
fn border_of_an_unbounded_surface_is_refused() {
    let mut model = ModelBuilder::default();
    model.bounded(FaceSurface::Plane(WORLD), true, vec![BoundaryLoop::Border]);
    assert!(matches!(trimmed_faces(&model.0).faces[0], Err(FaceRefusal::Surface { .. })));
}

#[test]
fn polygons_far_from_their_plane_take_their_own() {
    // A tetrahedron whose faces all name the plane z = 5, in which one of them lies and has its normal downwards.
    let [o, a, b, c] =
        [(0.0, 0.0, 5.0), (12.0, 0.0, 5.0), (2.0, 9.0, 5.0), (3.0, 2.0, 19.0)].map(DVec3::from);
    let mut model = ModelBuilder::default();
    for corners in [[o, b, a], [o, a, c], [o, c, b], [a, b, c]] {
        let polygon = model.polygon(&corners);
        model.bounded(FaceSurface::Plane(at_height(5.0)), true, vec![polygon]);
    }
    let faces: Vec<TrimmedFace> = trimmed_faces(&model.0).faces.into_iter().map(Result::unwrap).collect();
    let sum = faces.iter().map(|face| face.measure(1e-9)).fold(FaceMeasure::default(), |a, b| a + b);
    assert_close(sum.volume, 252.0);
    let area = |p: DVec3, q: DVec3, r: DVec3| 0.5 * (q - p).cross(r - p).length();
    assert_close(sum.area, area(o, a, b) + area(o, a, c) + area(o, b, c) + area(a, b, c));
    let off: Vec<f64> = faces
        .iter()
        .flat_map(|face| &face.repairs)
        .filter_map(|repair| match repair {
            FaceRepair::PolygonPlane { distance } => Some(*distance),
            _ => None,
        })
        .collect();
    assert_eq!(off, [14.0; 3]);
    assert_eq!(faces[0].repairs, [FaceRepair::TurnedPlane]);
}

#[test]
fn polygon_that_is_not_flat_turns_its_plane() {
    // Above the unit square; no plane contains it.
    let heights = [1.0, 1.01, 1.0, 1.01];
    let corners: Vec<DVec3> = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
        .iter()
        .zip(heights)
        .map(|(&(x, y), z)| DVec3::new(x, y, z))
        .collect();
    let downwards = Placement { y: DVec3::NEG_Y, z: DVec3::NEG_Z, ..at_height(1.0) };
    for (plane, same_sense) in [(downwards, true), (at_height(1.0), false)] {
        let mut model = ModelBuilder::default();
        let polygon = model.polygon(&corners);
        model.bounded(FaceSurface::Plane(plane), same_sense, vec![polygon]);
        let face = trimmed_faces(&model.0).faces.remove(0).unwrap();
        // Counter-clockwise from above: a third of the height times the area, as above the origin.
        assert_close(face.measure(1e-9).volume, 1.0 / 3.0);
        assert_eq!(face.repairs[0], FaceRepair::TurnedPlane);
        let strays = |repair: &FaceRepair| matches!(repair, FaceRepair::StrayingEdge { .. });
        assert!(!face.repairs[1..].is_empty() && face.repairs[1..].iter().all(strays), "{:?}", face.repairs);
    }
}

#[test]
fn polygon_beside_its_plane_is_repaired_up_to_a_part_of_its_size_and_refused_beyond() {
    let polygon = |height: f64| {
        let mut model = ModelBuilder::default();
        let corner = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
        // No plane contains it.
        let polygon = model.polygon(&[
            corner(0.0, 0.0, 0.0),
            corner(1.0, 0.0, height),
            corner(1.0, 1.0, 0.0),
            corner(0.0, 1.0, height),
        ]);
        model.bounded(FaceSurface::Plane(WORLD), true, vec![polygon]);
        trimmed_faces(&model.0).faces.remove(0)
    };
    let repairs = polygon(0.01).unwrap().repairs;
    assert_eq!(repairs.len(), 4, "each side ends above or below the plane");
    for repair in repairs {
        assert!(
            matches!(repair, FaceRepair::StrayingEdge { distance, .. } if (0.01..0.0101).contains(&distance)),
            "{repair:?}"
        );
    }
    let refusal = polygon(0.5).unwrap_err();
    assert!(matches!(refusal, FaceRefusal::StrayingEdge { distance, .. } if (0.5..0.51).contains(&distance)));
    assert!(matches!(polygon(f64::NAN).unwrap_err(), FaceRefusal::Edge { .. }));
}

#[test]
fn largest_polygon_tells_the_plane() {
    let square = |size: f64, x: f64| {
        let corner = |u: f64, v: f64| DVec3::new(x + u * size, v * size, 1.0);
        vec![corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0), corner(0.0, 1.0)]
    };
    let hole = square(1.0, 1.0).into_iter().rev().collect();
    let plane = Placement::of_polygons(&[hole, square(4.0, 0.0)]).unwrap();
    assert_eq!((plane.origin.z, plane.z), (1.0, DVec3::Z));
    assert!(Placement::of_polygons(&[vec![DVec3::ZERO, DVec3::X, DVec3::X * 2.0], vec![]]).is_none());
}

#[test]
fn only_loops_of_edges_without_curves_are_polygons() {
    let mut model = ModelBuilder::default();
    let corners = [DVec3::ZERO, DVec3::X, DVec3::Y];
    let polygon = model.polygon(&corners);
    assert_eq!(model.0.polygon(&polygon).as_deref(), Some(&corners[..]));
    let edge = model.circle(1.0, 0.0);
    let circle = BoundaryLoop::Edges(vec![OrientedEdge { edge, forward: true }]);
    for other in [circle, BoundaryLoop::Border, BoundaryLoop::Vertex(0)] {
        assert_eq!(model.0.polygon(&other), None);
    }
}

#[test]
fn geometry_that_no_scene_takes_is_refused_alone() {
    let mut model = ModelBuilder::default();
    model.bounded(FaceSurface::Sphere { placement: WORLD, radius: 1e20 }, true, Vec::new());
    model.bounded(FaceSurface::Sphere { placement: WORLD, radius: 1.0 }, true, Vec::new());
    let far = Placement { origin: DVec3::X * 1e200, ..WORLD };
    model.bounded(FaceSurface::Sphere { placement: far, radius: 1.0 }, true, Vec::new());
    let faces = trimmed_faces(&model.0).faces;
    assert!(faces[1].is_ok());
    for i in [0, 2] {
        assert!(matches!(faces[i], Err(FaceRefusal::Geometry(_))), "{:?}", faces[i]);
    }
}

#[test]
fn wedge_of_a_horn_torus_between_two_meridians_is_measured() {
    let mut model = ModelBuilder::default();
    let mut loops = Vec::new();
    for (turn, is_first) in [(0.0_f64, true), (0.2, false)] {
        let out = DVec3::new(turn.cos(), turn.sin(), 0.0);
        // A whole meridian in two edges, from the horn and back to it: at first down and around, then back.
        let circle = || Some(Curve::Ellipse { center: out, a: -out, b: -DVec3::Z });
        let first = model.0.vertices.len();
        model.0.vertices.extend([DVec3::ZERO, out + out * 2.0_f64.cos() * -1.0 - DVec3::Z * 2.0_f64.sin()]);
        let [down, up] = [model.edge([first, first + 1], circle()), model.edge([first + 1, first], circle())];
        // Down along the horn is along +v: the face is on the left of the second meridian, and of the first one run backwards.
        let edges = [down, up].map(|edge| OrientedEdge { edge, forward: !is_first });
        loops.extend(if is_first { [edges[1], edges[0]] } else { edges });
    }
    let surface = |gap: f64| FaceSurface::Torus {
        placement: WORLD,
        major_radius: 1.0 - gap,
        minor_radius: 1.0,
        select_outer: true,
    };
    model.0.uncertainty = 1e-5;
    for gap in [0.0, 4e-15] {
        model.bounded(surface(gap), true, vec![BoundaryLoop::Edges(loops.clone())]);
    }
    for face in trimmed_faces(&model.0).faces {
        let face = face.unwrap();
        let area = face.measure(1e-9).area;
        assert!((area - 0.2 * TAU).abs() < 1e-6, "{area}, not {}: {:?}", 0.2 * TAU, face.repairs);
    }
}
