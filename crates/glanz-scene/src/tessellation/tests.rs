mod crossing;
mod progress;

use std::f64::consts::{PI, TAU};

use glanz_math::DMat4;

use super::*;
use crate::description::{
    BezierPatchesDescription, GeometryDescription, GroupDescription, NurbsDescription, ShapeDescription,
    TrimCurveDescription, TrimDescription, TrimEdgeDescription, TrimLoopDescription,
};

fn settings(deviation: f64) -> TessellationSettings {
    TessellationSettings { deviation, angle: 0.5 }
}

fn tessellate(shapes: Vec<ShapeDescription>, deviation: f64) -> (GroupMesh, f64) {
    let world = GroupDescription { shapes, ..GroupDescription::default() };
    let description = Description { world, ..Description::default() };
    let made =
        SceneTessellation::try_new(&description, settings(deviation), &TessellationProgress::default())
            .unwrap();
    assert_eq!(made.faults, vec![]);
    (made.world, made.deviation)
}

/// The mesh is watertight, its triangles and normals face outwards, and its volume is close to the exact one.
fn assert_closed(shapes: Vec<ShapeDescription>, deviation: f64, volume: f64, area: f64) -> GroupMesh {
    let count = shapes.len();
    let (mesh, measured) = tessellate(shapes, deviation);
    assert_eq!(mesh.open_sides(0..count), 0);
    assert!(measured <= deviation, "{measured}");
    let (v, a) = (mesh.volume(0..count), mesh.area(0..count));
    // The triangles lie in a shell of this thickness around the surface.
    assert!((v - volume).abs() <= deviation * area, "{v} {volume}");
    assert!((a - area).abs() <= 4.0 * deviation * area / volume.cbrt(), "{a} {area}");
    for shape in &mesh.shapes {
        for corners in &shape.triangles {
            let [a, b, c] = corners.map(|i| shape.vertices[i as usize]);
            let [p, q, r] = [a, b, c].map(|vertex| mesh.positions[vertex.position as usize]);
            let flat = (q - p).cross(r - p).normalize();
            for vertex in [a, b, c] {
                assert!((vertex.normal.length() - 1.0).abs() < 1e-9);
                assert!(vertex.normal.dot(flat) > 0.5, "{} {flat}", vertex.normal);
            }
        }
    }
    mesh
}

/// A straight curve that is a part of an edge.
fn part(from: [f64; 2], to: [f64; 2], edge: (u32, [u32; 2], [f64; 2])) -> TrimCurveDescription {
    let (edge, vertices, range) = edge;
    TrimCurveDescription {
        degree: 1,
        knots: vec![0.0, 0.0, 1.0, 1.0],
        points: [from, to].map(|[u, v]| [u, v, 1.0]).to_vec(),
        width: Some(1e-9),
        edge: Some(TrimEdgeDescription { edge, vertices, range }),
    }
}

/// A circle in the unit square, counterclockwise or not, that starts at the right.
fn circle(center: [f64; 2], radius: [f64; 2], forward: bool) -> TrimCurveDescription {
    let half = 0.5_f64.sqrt();
    let around = [[1, 0], [1, 1], [0, 1], [-1, 1], [-1, 0], [-1, -1], [0, -1], [1, -1], [1, 0]]
        .map(|p| p.map(f64::from));
    let mut points: Vec<[f64; 3]> = around
        .iter()
        .enumerate()
        .map(|(i, p)| {
            let w = if i % 2 == 0 { 1.0 } else { half };
            [w * (center[0] + radius[0] * p[0]), w * (center[1] + radius[1] * p[1]), w]
        })
        .collect();
    if !forward {
        points.reverse();
    }
    let knots = [0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4].map(f64::from).to_vec();
    TrimCurveDescription { degree: 2, knots, points, width: Some(1e-9), edge: None }
}

fn numbered(mut curve: TrimCurveDescription, edge: u32, forward: bool) -> TrimCurveDescription {
    let range = if forward { [0.0, 1.0] } else { [1.0, 0.0] };
    curve.edge = Some(TrimEdgeDescription { edge, vertices: [edge, edge], range });
    curve
}

fn trim(loops: Vec<Vec<TrimCurveDescription>>) -> TrimDescription {
    let loops: Vec<_> = loops.into_iter().map(|curves| TrimLoopDescription { curves }).collect();
    TrimDescription { domain: Some([[0.0; 2], [1.0; 2]]), ..TrimDescription::from(loops) }
}

#[test]
fn spheres_and_tori_are_closed_and_their_volumes_converge() {
    for deviation in [0.1, 0.01, 0.001] {
        assert_closed(vec![ShapeDescription::sphere(1.0)], deviation, 4.0 / 3.0 * PI, 4.0 * PI);
        assert_closed(
            vec![ShapeDescription::torus(2.0, 0.7)],
            deviation,
            TAU * PI * 2.0 * 0.49,
            TAU * TAU * 1.4,
        );
    }
}

#[test]
fn numbers_of_triangles_grow_as_the_inverse_of_the_deviation() {
    let count = |deviation: f64| {
        let (mesh, _) = tessellate(vec![ShapeDescription::sphere(1.0)], deviation);
        mesh.shapes[0].triangles.len() as f64
    };
    let (coarse, fine) = (count(4e-3), count(2e-4));
    assert!(coarse < 4000.0 && (10.0..40.0).contains(&(fine / coarse)), "{coarse} {fine}");
}

#[test]
fn triangles_are_within_the_deviation_at_many_points() {
    let deviation = 2e-3;
    let (mesh, _) = tessellate(vec![ShapeDescription::torus(2.0, 0.7)], deviation);
    let mut worst = 0.0_f64;
    for corners in mesh.position_triangles([0]) {
        let [a, b, c] = corners.map(|i| mesh.positions[i as usize]);
        for (i, j) in (0..=6).flat_map(|i| (0..=6 - i).map(move |j| (i, j))) {
            let p = a + (b - a) * f64::from(i) / 6.0 + (c - a) * f64::from(j) / 6.0;
            worst = worst.max(((p.truncate().length() - 2.0).hypot(p.z) - 0.7).abs());
        }
    }
    assert!(worst <= 1.3 * deviation && worst > 0.3 * deviation, "{worst}");
}

#[test]
fn boxes_and_polyhedra_are_closed() {
    let cuboid = ShapeDescription::cuboid([0.0; 3], [1.0, 2.0, 3.0]);
    assert_eq!(assert_closed(vec![cuboid.clone()], 0.01, 6.0, 22.0).positions.len(), 8);
    let mirrored = cuboid.scaled([-1.0, 1.0, 1.0]);
    assert_eq!(assert_closed(vec![mirrored], 0.01, 6.0, 22.0).position_triangles([0]).count(), 12);
    let axes = [DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_X, DVec3::NEG_Y, DVec3::NEG_Z];
    let half_spaces = axes.map(|axis| (axis, 1.0)).to_vec();
    assert_closed(vec![GeometryDescription::Polyhedron { half_spaces }.into()], 0.01, 8.0, 24.0);
}

/// A tube of radius 1 from z = 0 to 3 and two disks, with their edges: 0 below, 1 above, and seams where the file has them.
fn tube(hole: Option<[f64; 2]>, seam: bool) -> Vec<ShapeDescription> {
    let (below, above) = ((0, [0, 0]), (1, [1, 1]));
    let forward = [0.0, 1.0];
    let mut loops = if seam {
        let joint = (2, [0, 1]);
        vec![vec![
            part([0.0, 0.0], [1.0, 0.0], (below.0, below.1, forward)),
            part([1.0, 0.0], [1.0, 1.0], (joint.0, joint.1, forward)),
            part([1.0, 1.0], [0.0, 1.0], (above.0, above.1, [1.0, 0.0])),
            part([0.0, 1.0], [0.0, 0.0], (joint.0, joint.1, [1.0, 0.0])),
        ]]
    } else {
        // Closed outside of the domain, with copies on both sides.
        let line = |x: f64, y: f64, edge: u32| part([x, y], [x + 1.0, y], (edge, [edge, edge], forward));
        let bare = |from: [f64; 2], to: [f64; 2]| TrimCurveDescription {
            edge: None,
            ..part(from, to, (0, [0, 0], forward))
        };
        let mut curves: Vec<_> = (-1..=1).map(|i| line(f64::from(i), 0.0, 0)).collect();
        curves.extend([bare([2.0, 0.0], [2.0, 1.0])]);
        curves.extend(
            (-1..=1)
                .rev()
                .map(|i| part([f64::from(i) + 1.0, 1.0], [f64::from(i), 1.0], (1, [1, 1], [1.0, 0.0]))),
        );
        curves.push(bare([-1.0, 1.0], [-1.0, 0.0]));
        vec![curves]
    };
    if let Some([u, v]) = hole {
        // Copies over the seam.
        for shift in [-1.0, 0.0, 1.0] {
            loops.push(vec![numbered(circle([u + shift, v], [0.1, 0.2], false), 5, true)]);
        }
    }
    let tube = ShapeDescription::cylinder(1.0, [0.0, 3.0]).trimmed(trim(loops));
    let disk = |edge: u32, z: f64, forward: bool| {
        let rim = numbered(circle([0.5, 0.5], [0.5, 0.5], true), edge, forward);
        ShapeDescription::rectangle([-1.0, 1.0], [-1.0, 1.0])
            .transformed(if forward {
                DMat4::IDENTITY
            } else {
                DMat4::from_cols_array(&[
                    1.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 1.0,
                ])
            })
            .trimmed(trim(vec![vec![rim]]))
            .translated([0.0, 0.0, z])
    };
    vec![tube, disk(0, 0.0, false), disk(1, 3.0, true)]
}

#[test]
fn a_cylinder_of_three_faces_is_closed_with_and_without_a_seam() {
    for seam in [true, false] {
        for deviation in [0.2, 0.01, 1e-4] {
            let mesh = assert_closed(tube(None, seam), deviation, 3.0 * PI, 8.0 * PI);
            if deviation == 0.01 {
                // No points inside: the sides of the tube are straight.
                assert!(mesh.positions.len() < 80, "{}", mesh.positions.len());
            }
        }
    }
}

#[test]
fn holes_across_the_seam_leave_only_their_rim_open() {
    for (u, v) in [(0.5, 0.5), (0.03, 0.5), (0.95, 0.4), (0.0, 0.5)] {
        for seam in [true, false] {
            if seam && !(0.1..=0.9).contains(&u) {
                continue;
            }
            let deviation = 1e-3;
            let (mesh, measured) = tessellate(tube(Some([u, v]), seam), deviation);
            let open = mesh.open_sides(0..3);
            // Chords of the rim: a circle of parameters of this size.
            assert!((20..200).contains(&open), "{u} {v} {seam}: {open}");
            assert!(measured <= deviation);
            let area = TAU * 3.0 * (1.0 - PI * 0.1 * 0.2) + TAU;
            let found = mesh.area(0..3);
            assert!((found - area).abs() < 2e-3 * area, "{u} {v} {seam}: {found} {area}");
        }
    }
}

#[test]
fn patches_with_common_borders_are_joined_whichever_way_they_run() {
    // The faces of a cube blown up by moving the middles of their borders and faces outwards.
    let bulge = |p: DVec3| {
        let zeros = p.to_array().iter().filter(|x| **x == 0.0).count();
        p * [1.0, 1.3, 1.8, 1.0][zeros]
    };
    let mut patches = Vec::new();
    for axis in 0..3 {
        for sign in [-1.0, 1.0] {
            let mut points = Vec::new();
            for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
                let (a, b) = (f64::from(i) - 1.0, (f64::from(j) - 1.0) * sign);
                let mut p = DVec3::ZERO;
                (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (sign, a, b);
                points.push(bulge(p).extend(1.0).to_array());
            }
            patches.push(points);
        }
    }
    let patches = BezierPatchesDescription { degree_u: 2, degree_v: 2, patches };
    let shape = ShapeDescription::from(GeometryDescription::BezierPatches(patches));
    let (fine, _) = tessellate(vec![shape.clone()], 1e-5);
    assert_closed(vec![shape], 1e-2, fine.volume([0]), fine.area([0]));
    assert_eq!(fine.open_sides([0]), 0);
}

#[test]
fn curved_surfaces_of_every_kind_have_their_area() {
    let cases = [
        (ShapeDescription::disk(2.0), 4.0 * PI),
        (GeometryDescription::Cone { radius: 1.0, height: 2.0, phi_max: TAU }.into(), PI * 5.0_f64.sqrt()),
        (
            GeometryDescription::Paraboloid { radius: 1.0, z: [0.0, 1.0], phi_max: TAU }.into(),
            PI / 6.0 * (5.0_f64.powf(1.5) - 1.0),
        ),
        (GeometryDescription::Sphere { radius: 1.0, z: [-0.5, 1.0], phi_max: 2.0 }.into(), 3.0),
    ];
    for (shape, area) in cases {
        let (mesh, measured) = tessellate(vec![shape], 1e-4);
        assert!((mesh.area([0]) - area).abs() < 2e-3, "{} {area}", mesh.area([0]));
        assert!(measured <= 1e-4);
    }
}

#[test]
fn what_has_no_triangles_is_reported() {
    let clip = [DVec3::NEG_ONE, DVec3::ONE];
    let shapes = vec![
        GeometryDescription::Algebraic { terms: vec![([1, 0, 0], 1.0)], clip }.into(),
        ShapeDescription::plane(),
        ShapeDescription::sphere(-1.0),
        ShapeDescription::sphere(1.0),
    ];
    let world = GroupDescription { shapes, ..GroupDescription::default() };
    let description = Description { world, ..Description::default() };
    let made =
        SceneTessellation::try_new(&description, settings(0.1), &TessellationProgress::default()).unwrap();
    let kinds: Vec<_> = made.faults.iter().map(|fault| (fault.shape, fault.kind.is_omission())).collect();
    assert_eq!(kinds, [(0, true), (1, true), (2, true)]);
    assert!(!made.world.shapes[3].triangles.is_empty());
    for wrong in [0.0, -1.0, f64::NAN] {
        let settings = TessellationSettings { deviation: wrong, angle: 0.5 };
        assert!(
            SceneTessellation::try_new(&description, settings, &TessellationProgress::default()).is_err()
        );
    }
}

#[test]
fn groups_are_as_fine_as_their_largest_instance() {
    let ball = GroupDescription { shapes: vec![ShapeDescription::sphere(1.0)], ..Default::default() };
    let count = |scale: f64| {
        let instance = InstanceDescription {
            name: String::new(),
            group: 0,
            to_parent: DMat4::from_scale(DVec3::splat(scale)),
            location: None,
        };
        let world = GroupDescription { instances: vec![instance], ..Default::default() };
        let description = Description { groups: vec![ball.clone()], world, ..Description::default() };
        let made = SceneTessellation::try_new(&description, settings(1e-3), &TessellationProgress::default())
            .unwrap();
        assert!(made.deviation <= 1e-3);
        made.triangle_count()
    };
    // As the scale, since the deviation grows as the square of the chord.
    assert!(count(16.0) > 8 * count(1.0));
}

#[test]
fn ends_that_no_part_of_an_edge_reaches_leave_the_neighbours_whole() {
    let mut shapes = tube(None, true);
    for l in &mut shapes[0].trim.as_mut().unwrap().loops {
        for edge in l.curves.iter_mut().filter_map(|curve| curve.edge.as_mut()).filter(|edge| edge.edge == 2)
        {
            edge.range = edge.range.map(|fraction| 0.4 * fraction);
        }
    }
    let (mesh, _) = tessellate(shapes, 0.01);
    assert!(mesh.positions.iter().all(|point| point.is_finite()));
    assert_eq!(mesh.open_sides(0..3), 0);
}

#[test]
fn parts_of_edges_without_length_are_curves_of_their_own() {
    let mut shapes = tube(None, true);
    let edge = shapes[1].trim.as_mut().unwrap().loops[0].curves[0].edge.as_mut().unwrap();
    edge.range = [0.3, 0.3];
    let (mesh, measured) = tessellate(shapes, 0.01);
    assert!(mesh.positions.iter().all(|point| point.is_finite()) && measured <= 0.01);
    assert!((mesh.area([1]) - PI).abs() < 0.1, "{}", mesh.area([1]));
}

#[test]
fn splines_with_common_borders_are_joined_whichever_way_they_run() {
    use crate::description::NurbsDescription;
    // Two strips on both sides of a curve with a knot whose complement is not exact.
    let strip = |side: f64, forward: bool| {
        let along = [0.0, 0.2, 0.9, 1.0];
        let heights = [0.0, 0.5, -0.4, 0.1];
        let order: Vec<usize> = if forward { (0..4).collect() } else { (0..4).rev().collect() };
        let rows = order
            .into_iter()
            .flat_map(|i| [[along[i], 0.0, heights[i], 1.0], [along[i], side, heights[i], 1.0]]);
        let knot = if forward { 0.1 } else { 0.9 };
        ShapeDescription::from(GeometryDescription::Nurbs(NurbsDescription {
            degree_u: 2,
            degree_v: 1,
            knots_u: vec![0.0, 0.0, 0.0, knot, 1.0, 1.0, 1.0],
            knots_v: vec![0.0, 0.0, 1.0, 1.0],
            points: rows.collect(),
            domain: None,
        }))
    };
    let (mesh, _) = tessellate(vec![strip(1.0, true), strip(-1.0, false)], 1e-3);
    let alone = |shape: ShapeDescription| tessellate(vec![shape], 1e-3).0.positions.len();
    let common = mesh.positions.iter().filter(|point| point.y == 0.0).count();
    let apart = alone(strip(1.0, true)) + alone(strip(-1.0, false));
    assert!(common > 4 && mesh.positions.len() == apart - common, "{common} {apart}");
}

#[test]
fn the_deviation_is_that_of_chords_where_surfaces_are_flat() {
    let disc = ShapeDescription::rectangle([-1.0, 1.0], [-1.0, 1.0])
        .trimmed(trim(vec![vec![circle([0.5; 2], [0.4; 2], true)]]));
    for deviation in [0.01, 1e-3] {
        let (_, measured) = tessellate(vec![disc.clone()], deviation);
        // Halved chords deviate by a quarter.
        assert!((0.2 * deviation..=deviation).contains(&measured), "{measured} of {deviation}");
    }
}

/// z = u^2 for u from 0 to 1, and z = 4 + u from there to 2, over x = u, y = v in [0, 1].
fn step() -> ShapeDescription {
    let profile = [(0.0, 0.0), (0.5, 0.0), (1.0, 1.0), (1.0, 5.0), (1.5, 5.5), (2.0, 6.0)];
    let points = profile.into_iter().flat_map(|(x, z)| [0.0, 1.0].map(|y| [x, y, z, 1.0])).collect();
    ShapeDescription::from(GeometryDescription::Nurbs(NurbsDescription {
        degree_u: 2,
        degree_v: 1,
        knots_u: [0, 0, 0, 1, 1, 1, 2, 2, 2].map(f64::from).to_vec(),
        knots_v: [0, 0, 1, 1].map(f64::from).to_vec(),
        points,
        domain: None,
    }))
}

#[test]
fn a_surface_that_jumps_has_no_triangles_between_its_pieces() {
    let (mesh, deviation) = tessellate(vec![step()], 1e-3);
    assert!(deviation <= 1e-3, "{deviation}");
    for corners in mesh.position_triangles([0]) {
        let heights = corners.map(|i| mesh.positions[i as usize].z);
        assert!(heights.iter().all(|z| *z < 2.0) || heights.iter().all(|z| *z > 4.0), "{heights:?}");
    }
    // The parabola's length: sqrt(5) / 2 + asinh(2) / 4, the line's sqrt(2); one wide.
    let expected = 5.0_f64.sqrt() / 2.0 + 2.0_f64.asinh() / 4.0 + 2.0_f64.sqrt();
    let area = mesh.area(0..1);
    assert!((area - expected).abs() < 0.01 * expected, "{area} {expected}");
}

#[test]
fn a_trimmed_surface_that_jumps_is_refused() {
    let shape =
        ShapeDescription { trim: Some(trim(vec![vec![circle([0.5, 0.5], [0.3, 0.3], true)]])), ..step() };
    assert!(matches!(
        patch::MeshPatch::of_shape(0, &shape),
        Err(TessellationFaultKind::Unsupported("a trimmed surface that jumps"))
    ));
}
