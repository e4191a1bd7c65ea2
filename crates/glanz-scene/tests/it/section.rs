//! Groups that are cut open.

use std::f64::consts::FRAC_PI_2;

use glanz_geometry::BoundedRay;
use glanz_math::{DMat4, DVec3, Ray};
use glanz_scene::description::*;
use glanz_scene::{Scene, SceneBuilder};

/// Number of the plane, after the shapes of both groups.
const FACES: u32 = 3;

/// A ball of radius 2 about the origin with a hollow of radius 1, and a box at x from 1.5 to 3.5, which overlaps it; cut at `normal . p = offset`.
fn cut(normal: DVec3, offset: f64) -> Scene {
    let mut description = SceneBuilder::new()
        .material("grey", MaterialKind::diffuse(0.5))
        .material("faces", MaterialKind::diffuse(0.2))
        .group("box", |group| group.shape(ShapeDescription::cuboid([-1.0; 3], [1.0; 3]), "grey"))
        .group("model", |group| {
            let balls = [ShapeDescription::sphere(2.0), ShapeDescription::sphere(1.0).reversed()];
            group.shapes(balls, "grey").instance("box", DMat4::from_translation(DVec3::new(2.5, 0.0, 0.0)))
        })
        .instance("model", DMat4::from_translation(DVec3::new(0.0, 0.0, 10.0)))
        .describe()
        .unwrap();
    description.section = Some(SectionDescription { group: 1, normal, offset, material: 1 });
    Scene::resolve(description).unwrap().0
}

/// Whether a point in the frame of the group is inside of one of the solids.
fn is_solid(p: DVec3) -> bool {
    let ball = (1.0..=2.0).contains(&p.length());
    ball || (p - DVec3::X * 2.5).abs().max_element() <= 1.0
}

#[test]
fn a_ray_onto_the_plane_hits_a_face_where_it_is_inside_of_a_solid() {
    // Everything above z = 0.5 is left out; the group is 10 above the world's origin.
    let scene = cut(DVec3::Z * 3.0, 1.5);
    for i in 0..60 {
        for j in 0..30 {
            let (x, y) = (-2.5 + 0.13 * f64::from(i), -2.21 + 0.15 * f64::from(j));
            let ray = Ray::new(DVec3::new(x, y, 20.0), DVec3::NEG_Z);
            let hit = scene.intersect(&ray, f64::INFINITY);
            let at_plane = DVec3::new(x, y, 0.5);
            assert_eq!(hit.as_ref().is_some_and(|hit| hit.id == FACES), is_solid(at_plane), "{at_plane}");
            if let Some(hit) = hit.filter(|hit| hit.id == FACES) {
                assert!((hit.t - 9.5).abs() < 1e-12 && hit.point.normal == DVec3::Z);
                // Light leaves the face into the open half, and not into the solid.
                assert!(!scene.occluded(&hit.spawn(DVec3::new(0.6, 0.0, 0.8)), f64::INFINITY));
                assert!(scene.occluded(&hit.spawn(DVec3::new(0.0, 0.6, -0.8)), f64::INFINITY));
            }
        }
    }
}

#[test]
fn nothing_is_hit_beyond_the_plane_and_everything_as_before_on_this_side() {
    // A plane that misses the model leaves all of it.
    let (whole, half) = (cut(DVec3::X, 100.0), cut(DVec3::new(0.3, -0.5, 0.8), 0.1));
    let (normal, mut faces, mut same) = (DVec3::new(0.3, -0.5, 0.8), 0, 0);
    let (mut rays, mut expected) = (Vec::new(), Vec::new());
    for i in 0..2000 {
        let turn = f64::from(i) * 2.399_963;
        let z = 1.0 - f64::from(i) / 1000.0;
        let from = 8.0 * DVec3::new(turn.cos() * (1.0 - z * z).sqrt(), turn.sin() * (1.0 - z * z).sqrt(), z);
        let towards = DVec3::new(3.0 * (0.7 * turn).sin(), (1.3 * turn).cos(), (2.1 * turn).sin());
        let ray = Ray::new(from + DVec3::Z * 10.0, (towards - from).normalize());
        let hit = half.intersect(&ray, f64::INFINITY);
        assert_eq!(half.occluded(&ray, f64::INFINITY), hit.is_some());
        let height = |t: f64| (ray.at(t) - DVec3::Z * 10.0).dot(normal) - 0.1;
        if let Some(hit) = &hit {
            assert!(height(hit.t) < 1e-9, "a hit {} beyond the plane", height(hit.t));
            faces += u32::from(hit.id == FACES);
            assert!(!half.occluded(&ray, hit.t * (1.0 - 1e-9)) && half.occluded(&ray, hit.t * (1.0 + 1e-9)));
        }
        // Rays that begin on this side and hit on this side first see no difference.
        if let Some(before) = whole.intersect(&ray, f64::INFINITY)
            && height(0.0) < 0.0
            && height(before.t) < 0.0
        {
            assert_eq!(hit.as_ref().map(|hit| (hit.t, hit.id)), Some((before.t, before.id)));
            same += 1;
        }
        rays.push(BoundedRay::from(ray));
        expected.push(hit.map(|hit| hit.t));
    }
    assert!(faces > 100 && same > 100, "{faces} {same}");
    let mut hits = Vec::new();
    half.closest_batch(&rays, &mut hits);
    assert_eq!(hits.iter().map(|hit| hit.as_ref().map(|hit| hit.t())).collect::<Vec<_>>(), expected);
    let mut occluded = Vec::new();
    half.occluded_batch(&rays, &mut occluded);
    assert!(occluded.iter().zip(&expected).all(|(occluded, hit)| *occluded == hit.is_some()));
}

#[test]
fn a_ray_inside_of_glass_leaves_through_the_face() {
    let scene = cut(DVec3::Z, 0.5);
    let ray = Ray::new(DVec3::new(1.5, 0.0, 10.0), DVec3::Z);
    let hit = scene.intersect(&ray, f64::INFINITY).unwrap();
    assert!(hit.id == FACES && (hit.t - 0.5).abs() < 1e-12);
    assert!(scene.intersect(&Ray::new(DVec3::new(0.5, 0.0, 10.0), DVec3::Z), f64::INFINITY).is_none());
}

#[test]
fn planes_without_a_direction_are_refused() {
    let mut description = SceneBuilder::new()
        .group("g", |group| group.shape(ShapeDescription::sphere(1.0), MaterialKind::diffuse(0.5)))
        .instance("g", DMat4::IDENTITY)
        .describe()
        .unwrap();
    for (normal, material) in [(DVec3::ZERO, 0), (DVec3::splat(f64::NAN), 0), (DVec3::X, 7)] {
        description.section = Some(SectionDescription { group: 0, normal, offset: 0.0, material });
        assert!(Scene::resolve(description.clone()).is_err());
    }
}

/// Boxes of the sides 2 about (0, 0, z) with their axes turned, cut at the height 1 of their own frame; with the plane as group 1.
fn boxes(heights: &[f64]) -> (Scene, DMat4) {
    let turn = DMat4::from_rotation_x(0.7)
        * DMat4::from_rotation_y(-0.4)
        * DMat4::from_translation(DVec3::splat(0.1));
    let normal = turn.transform_vector3(DVec3::Z);
    let shapes = heights
        .iter()
        .map(|&z| ShapeDescription::cuboid([-1.0; 3], [1.0; 3]).translated([0.0, 0.0, z]).transformed(turn));
    let shapes: Vec<ShapeDescription> = shapes.collect();
    let mut description = SceneBuilder::new()
        .material("grey", MaterialKind::diffuse(0.5))
        .group("boxes", |group| group.shapes(shapes, "grey"))
        .instance("boxes", DMat4::IDENTITY)
        .describe()
        .unwrap();
    let offset = normal.dot(turn.transform_point3(DVec3::Z));
    description.section = Some(SectionDescription { group: 0, normal, offset, material: 0 });
    (Scene::resolve(description).unwrap().0, turn)
}

/// Ids of what rays from above the plane and below it meet in the plane, in a raster that reaches beyond a box.
fn met_in_plane(heights: &[f64], from: f64) -> Vec<(DVec3, Option<u32>)> {
    let (scene, turn) = boxes(heights);
    let mut met = Vec::new();
    for i in -20..=20 {
        for j in -20..=20 {
            let at = DVec3::new(0.0731 * f64::from(i), 0.0717 * f64::from(j), 1.0);
            let eye = DVec3::new(0.3 * at.x, 0.1, from);
            let [eye, point] = [eye, at].map(|p| turn.transform_point3(p));
            let ray = Ray::new(eye, point - eye);
            let hit = scene.intersect(&ray, f64::INFINITY);
            let is_hit = hit.as_ref().is_some_and(|hit| hit.t < 1.0 + 1e-9);
            assert_eq!(scene.occluded(&ray, 1.0 + 1e-9), is_hit, "{at}");
            met.push((at, hit.filter(|hit| (hit.t - 1.0).abs() < 1e-9).map(|hit| hit.id)));
        }
    }
    met
}

#[test]
fn a_face_in_the_plane_is_hit_where_its_solid_ends_and_is_left_out_where_it_begins() {
    let is_inside = |p: DVec3| p.truncate().abs().max_element() < 1.0;
    for from in [9.0, 0.2] {
        for (at, id) in met_in_plane(&[0.0], from) {
            assert_eq!(id, is_inside(at).then_some(0), "the top of the box is its own face at {at}");
        }
        for (at, id) in met_in_plane(&[0.0, 2.0], from) {
            assert_eq!(id, is_inside(at).then_some(2), "between two boxes is a face of the section at {at}");
        }
        for (at, id) in met_in_plane(&[2.0], from) {
            assert_eq!(id, None, "nothing is left at {at}");
        }
    }
}

/// The edges of a cube of the side 1 whose lowest points have the height `low`. The shape 0 is its top, 1 its bottom, 2 to 5 are its sides.
fn cube_edges(low: f64) -> Vec<EdgeDescription> {
    let corner = |i: usize, height: f64| {
        let [x, y] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]][i % 4];
        DVec3::new(x, y, low + height)
    };
    let edge = |from: DVec3, to: DVec3, shapes: [usize; 2]| EdgeDescription {
        points: (0..=8).map(|i| from.lerp(to, f64::from(i) / 8.0)).collect(),
        deviation: 0.0,
        kind: EdgeKind::Line,
        length: 1.0,
        shapes: shapes.to_vec(),
        transition: EdgeTransition::Sharp,
        angle: FRAC_PI_2,
    };
    let mut edges = Vec::new();
    for i in 0..4 {
        let [side, next] = [2 + i, 2 + (i + 1) % 4];
        edges.push(edge(corner(i, 1.0), corner(i + 1, 1.0), [0, side]));
        edges.push(edge(corner(i, 0.0), corner(i + 1, 0.0), [1, side]));
        edges.push(edge(corner(i + 1, 0.0), corner(i + 1, 1.0), [side, next]));
    }
    edges
}

#[test]
fn edges_in_the_plane_are_left_with_what_is_below_it() {
    // Rounding puts points of the world above the plane or below it.
    let turn = DMat4::from_rotation_x(0.7)
        * DMat4::from_rotation_y(-0.4)
        * DMat4::from_translation(DVec3::new(0.1, 0.2, 0.3));
    let to_parent = turn * DMat4::from_scale(DVec3::splat(2.0));
    // Numbers of pieces in all, and their length, of a cube below the plane, of one above it, and of one that it cuts in the middle.
    for (low, count, length) in [(0.0, 12, 12.0), (1.0, 0, 0.0), (0.5, 8, 6.0)] {
        let group = GroupDescription { edges: cube_edges(low), ..GroupDescription::default() };
        let instances =
            vec![InstanceDescription { name: String::new(), group: 0, to_parent, location: None }];
        let description = Description {
            materials: vec![MaterialKind::diffuse(0.5).into()],
            groups: vec![group],
            world: GroupDescription { instances, ..GroupDescription::default() },
            section: Some(SectionDescription { group: 0, normal: DVec3::Z, offset: 1.0, material: 0 }),
            ..Description::default()
        };
        let (scene, _) = Scene::resolve(description).unwrap();
        let placed = scene.placed_edges();
        let pieces: Vec<Vec<DVec3>> = placed
            .iter()
            .flat_map(|group| group.edges.iter().flat_map(move |edge| group.pieces(edge)))
            .collect();
        assert_eq!(pieces.len(), count, "{low}");
        let found: f64 =
            pieces.iter().flat_map(|piece| piece.windows(2).map(|pair| pair[0].distance(pair[1]))).sum();
        assert!((found - 2.0 * length).abs() < 1e-12, "{low} {found}");
    }
}

/// A square of the side 1 in a plane, which extends beyond it by `width` as a border that overlaps those of other squares.
fn bordered_square(width: f64) -> ShapeDescription {
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0]];
    let points = corners.map(|[x, y]| [0.5 + 0.25 * x, 0.5 + 0.25 * y, 1.0]);
    let knots = vec![0.0, 0.0, 1.0, 2.0, 3.0, 4.0, 4.0];
    let curve =
        TrimCurveDescription { degree: 1, knots, points: points.to_vec(), width: Some(width), edge: None };
    let loops = vec![TrimLoopDescription { curves: vec![curve] }];
    let trim = TrimDescription { loops, scale: [2.0; 2], domain: Some([[0.0; 2], [1.0; 2]]) };
    ShapeDescription::rectangle([-1.0, 1.0], [-1.0, 1.0]).trimmed(trim).bounding(0)
}

#[test]
fn faces_that_overlap_at_the_edges_of_a_solid_count_once() {
    let width = 0.06;
    let up = bordered_square(width).translated([0.0, 0.0, 0.5]);
    let quarter = FRAC_PI_2;
    let around = (0..4).map(|k| up.clone().rotated(DVec3::X, quarter * f64::from(k)));
    let sides = [quarter, -quarter].map(|angle| up.clone().rotated(DVec3::Y, angle));
    let shapes: Vec<ShapeDescription> = around.chain(sides).collect();
    let mut description = SceneBuilder::new()
        .material("grey", MaterialKind::diffuse(0.5))
        .group("cube", |group| group.shapes(shapes, "grey"))
        .instance("cube", DMat4::IDENTITY)
        .describe()
        .unwrap();
    for height in [0.4, 0.1, -0.2, -0.35] {
        description.section =
            Some(SectionDescription { group: 0, normal: DVec3::Z, offset: height, material: 0 });
        let (scene, _) = Scene::resolve(description.clone()).unwrap();
        for i in -60..=60 {
            for j in -60..=60 {
                let (x, y) = (0.0117 * f64::from(i), 0.0119 * f64::from(j));
                let reach = x.abs().max(y.abs());
                if (reach - 0.5).abs() <= width {
                    continue;
                }
                let hit = scene.intersect(&Ray::new(DVec3::new(x, y, 3.0), DVec3::NEG_Z), f64::INFINITY);
                let on_face = hit.is_some_and(|hit| hit.id == 6);
                assert_eq!(on_face, reach < 0.5, "({x}, {y}) at {height}");
            }
        }
    }
}

#[test]
fn sections_of_groups_that_do_not_exist_are_refused() {
    let mut description = SceneBuilder::new()
        .shape(ShapeDescription::sphere(1.0), MaterialKind::diffuse(0.5))
        .describe()
        .unwrap();
    description.section = Some(SectionDescription { group: 0, normal: DVec3::X, offset: 0.0, material: 0 });
    let error = Scene::resolve(description).unwrap_err().to_string();
    assert!(error.contains("group"), "{error}");
}
