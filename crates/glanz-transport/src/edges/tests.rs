//! Lines over pictures with known ones.

use std::f64::consts::TAU;

use glanz_geometry::DVec3;
use glanz_job::{CancelFlag, Interrupted, JobProgress, ProgressSink, Silent};
use glanz_math::{DMat4, DVec2};
use glanz_scene::Scene;
use glanz_scene::description::{
    CameraDescription, CameraKind, Description, EdgeDescription, EdgeKind, EdgeTransition, GroupDescription,
    InstanceDescription, SectionDescription, ShapeDescription,
};
use glanz_scene::description::{FilmDescription, FisheyeProjection, MaterialKind, SphericalMapping};

use super::film_curve::{FilmCurves, FilmPoint};
use super::{EdgeLayer, EdgeStyle};
use crate::film::FilmFormat;
use crate::pixel_rect::PixelRect;

const STYLE: EdgeStyle = EdgeStyle { width: 1.5, color: [0.0; 3] };

/// 64 x 64 pixels of the side 1/32 m: the camera looks along +z at the square from -1 to 1.
const SIDE: u32 = 64;

fn line(from: DVec3, to: DVec3) -> EdgeDescription {
    EdgeDescription {
        points: vec![from, to],
        deviation: 0.0,
        kind: EdgeKind::Line,
        length: from.distance(to),
        shapes: vec![0],
        transition: EdgeTransition::Border,
        angle: 0.0,
    }
}

fn described(kind: CameraKind, shapes: Vec<ShapeDescription>, edges: Vec<EdgeDescription>) -> Description {
    Description {
        camera: CameraDescription {
            kind,
            to_world: DMat4::from_translation(DVec3::NEG_Z * 4.0),
            ..CameraDescription::default()
        },
        film: FilmDescription { resolution: [SIDE; 2], ..FilmDescription::default() },
        materials: vec![MaterialKind::diffuse(0.5).into()],
        world: GroupDescription { shapes, edges, ..GroupDescription::default() },
        ..Description::default()
    }
}

fn layer(description: Description, crop: PixelRect) -> EdgeLayer {
    let format = FilmFormat { crop, ..FilmFormat::plain([SIDE; 2]) };
    let (scene, _) = Scene::resolve(description).unwrap();
    EdgeLayer::draw(&scene, &format, STYLE, &mut Silent, &CancelFlag::default()).unwrap()
}

fn drawn(shapes: Vec<ShapeDescription>, edges: Vec<EdgeDescription>) -> EdgeLayer {
    layer(described(CameraKind::Orthographic, shapes, edges), PixelRect::full([SIDE; 2]))
}

/// Covered share of a pixel.
fn share(layer: &EdgeLayer, x: u32, y: u32) -> f64 {
    f64::from(layer.coverage[(y * SIDE + x) as usize]) / 255.0
}

/// Sum of the shares in a column.
fn column(layer: &EdgeLayer, x: u32) -> f64 {
    (0..SIDE).map(|y| share(layer, x, y)).sum()
}

#[test]
fn a_line_covers_its_width_in_every_column() {
    // Slopes up to 1/8 change the width across a column by less than a percent.
    for slope in [0.0, 0.05, 0.125] {
        let edge = line(DVec3::new(-0.9, -0.9 * slope, 0.0), DVec3::new(0.9, 0.9 * slope, 0.0));
        let layer = drawn(Vec::new(), vec![edge]);
        for x in 6..58 {
            assert!((column(&layer, x) - 1.5).abs() < 0.05, "{slope} {x} {}", column(&layer, x));
        }
        assert_eq!(column(&layer, 1) + column(&layer, 62), 0.0);
    }
}

#[test]
fn what_lies_in_front_hides_a_line_to_the_pixel() {
    // The right half, half a metre before the line.
    let wall = ShapeDescription::rectangle([0.0, 2.0], [-2.0, 2.0]).translated([0.0, 0.0, -0.5]);
    let edge = line(DVec3::new(-0.9, 0.01, 0.0), DVec3::new(0.9, 0.01, 0.0));
    let layer = drawn(vec![wall], vec![edge]);
    assert!((6..31).all(|x| (column(&layer, x) - 1.5).abs() < 0.05));
    assert!(
        (34..64).all(|x| column(&layer, x) == 0.0),
        "the line ends half of its width after the wall begins"
    );
}

#[test]
fn thin_walls_hide_what_is_behind_them() {
    // A tenth of a millimetre is a three-hundredth of a pixel; a line's share of its width is a tenth.
    for (thickness, hidden) in [(0.01, true), (0.004, true), (1e-4, false)] {
        let wall = ShapeDescription::rectangle([-2.0, 2.0], [-2.0, 2.0]).translated([0.0, 0.0, -thickness]);
        let edge = line(DVec3::new(-0.9, 0.01, 0.0), DVec3::new(0.9, 0.01, 0.0));
        assert_eq!(column(&drawn(vec![wall], vec![edge]), 30) == 0.0, hidden, "{thickness}");
    }
}

#[test]
fn faces_beside_an_edge_do_not_hide_it_however_flat_they_are_seen() {
    // Faces through the line, inclined against the line of sight by less and less, on both sides.
    for slope in [1.0, 30.0, 1000.0] {
        for side in [-1.0, 1.0] {
            let corner = DVec3::NEG_X * 2.0;
            let depth = DVec3::new(0.0, side, side * slope);
            let face = ShapeDescription::parallelogram(corner - depth, DVec3::X * 4.0, 2.0 * depth);
            let edge = line(DVec3::new(-0.9, 1e-9, 0.0), DVec3::new(0.9, -1e-9, 0.0));
            let layer = drawn(vec![face], vec![edge]);
            assert!((6..58).all(|x| (column(&layer, x) - 1.5).abs() < 0.05), "{slope} {side}");
        }
    }
}

#[test]
fn a_cylinder_hides_half_of_its_rims() {
    // Its axis is y: the front half of a rim lies before the side, the back half behind it. Seen from a little above.
    let rim = |y: f64, front: bool| {
        let points = (0..=90).map(|i| {
            let angle = std::f64::consts::PI * f64::from(i) / 90.0;
            DVec3::new(0.5 * angle.cos(), y, if front { -0.5 } else { 0.5 } * angle.sin())
        });
        EdgeDescription { points: points.collect(), deviation: 1e-4, ..line(DVec3::ZERO, DVec3::X) }
    };
    let side = ShapeDescription::cylinder(0.5, [-0.5, 0.5]).rotated(DVec3::X, -std::f64::consts::FRAC_PI_2);
    let seen = |edge: EdgeDescription| {
        let mut description = described(CameraKind::Orthographic, vec![side.clone()], vec![edge]);
        description.camera.to_world = DMat4::from_rotation_x(0.3) * description.camera.to_world;
        let layer = layer(description, PixelRect::full([SIDE; 2]));
        (18..46).map(|x| column(&layer, x)).fold(f64::INFINITY, f64::min)
    };
    assert!(seen(rim(-0.5, true)) > 1.4 && seen(rim(0.5, true)) > 1.4);
    let back = [seen(rim(-0.5, false)), seen(rim(0.5, false))];
    assert!(back.contains(&0.0), "{back:?}: the side hides one of them");
}

#[test]
fn the_layer_of_a_part_is_a_part_of_the_layer() {
    let edge = line(DVec3::new(-3.0, 0.7, 0.0), DVec3::new(2.0, -0.9, 9.0));
    let perspective = CameraKind::Perspective { field_of_view: 0.6 };
    let description = described(perspective, vec![ShapeDescription::sphere(0.4)], vec![edge]);
    let whole = layer(description.clone(), PixelRect::full([SIDE; 2]));
    assert!(whole.coverage.iter().any(|&share| share > 200));
    let crop = PixelRect { min: [10, 20], size: [30, 17] };
    let part = layer(description, crop);
    for (pixel, [x, y]) in crop.pixels().enumerate() {
        assert_eq!(part.coverage[pixel], whole.coverage[(y * SIDE + x) as usize], "{x} {y}");
    }
}

#[test]
fn edges_are_placed_and_cut_with_their_group() {
    let group = GroupDescription {
        edges: vec![line(DVec3::new(-0.9, 0.0, 0.0), DVec3::new(0.9, 0.0, 0.0))],
        ..GroupDescription::default()
    };
    let mut description = described(CameraKind::Orthographic, Vec::new(), Vec::new());
    description.groups.push(group);
    let to_parent = DMat4::from_translation(DVec3::Y * 0.5);
    description.world.instances.push(InstanceDescription {
        name: String::new(),
        group: 0,
        to_parent,
        location: None,
    });
    let whole = layer(description.clone(), PixelRect::full([SIDE; 2]));
    assert!((6..58).all(|x| (column(&whole, x) - 1.5).abs() < 0.05));
    assert!((0..SIDE).all(|x| share(&whole, x, 32) == 0.0), "the copy is half a metre higher");
    description.section = Some(SectionDescription { group: 0, normal: DVec3::X, offset: 0.0, material: 0 });
    let cut = layer(description, PixelRect::full([SIDE; 2]));
    assert!((6..30).all(|x| (column(&cut, x) - 1.5).abs() < 0.05));
    assert!((34..64).all(|x| column(&cut, x) == 0.0));
}

#[test]
fn smooth_edges_and_seams_are_not_drawn() {
    for transition in [EdgeTransition::Smooth, EdgeTransition::Seam] {
        let edge = EdgeDescription { transition, ..line(DVec3::NEG_X, DVec3::X) };
        assert!(drawn(Vec::new(), vec![edge]).coverage.iter().all(|&share| share == 0));
    }
}

#[test]
fn lines_that_begin_behind_the_camera_are_drawn_in_front_of_it() {
    let edge = line(DVec3::new(0.3, 0.2, -9.0), DVec3::new(0.0, 0.0, 1e6));
    let perspective = CameraKind::Perspective { field_of_view: 1.0 };
    let layer = layer(described(perspective, Vec::new(), vec![edge]), PixelRect::full([SIDE; 2]));
    // From the vanishing point in the middle to the right border.
    assert!((33..63).all(|x| column(&layer, x) > 1.0));
}

#[test]
fn lines_are_bent_by_fisheyes_and_cross_the_borders_of_spherical_pictures() {
    // A line 4 m in front, 4 m long on either side: at (x, 0, 4) from the camera the angle is atan(x / 4), which an equidistant projection of
    // 2 radians shows at 32 atan(x / 4) pixels from the middle; its neighbour 1 m higher is bent.
    let edges = vec![
        line(DVec3::new(-4.0, 0.0, 0.0), DVec3::new(4.0, 0.0, 0.0)),
        line(DVec3::new(-4.0, 1.0, 0.0), DVec3::new(4.0, 1.0, 0.0)),
    ];
    let kind = CameraKind::Fisheye { field_of_view: 2.0, projection: FisheyeProjection::Equidistant };
    let picture = layer(described(kind, Vec::new(), edges), PixelRect::full([SIDE; 2]));
    let reach = 32.0 * 1.0_f64.atan();
    for x in 0..SIDE {
        let offset = (f64::from(x) + 0.5 - 32.0).abs();
        if offset < reach - 2.0 {
            // Two lines, of which the upper one is inclined, so that it covers more of a column.
            assert!(column(&picture, x) > 2.9, "{x} {}", column(&picture, x));
        }
        if offset > reach + 2.0 {
            assert_eq!(column(&picture, x), 0.0, "{x}");
        }
    }
    // The point (0, 1, 4) is at atan(1 / 4); the ends (4, 1, 4) at atan(sqrt(17) / 4) in the direction (4, 1).
    let height = |film: f64| share(&picture, 32, (32.0 - film) as u32);
    assert!(height(32.0 * 0.25_f64.atan()) > 0.5);
    let end = 32.0 * (17.0_f64.sqrt() / 4.0).atan() * DVec2::new(4.0, 1.0).normalize();
    let near = share(&picture, (32.0 + end.x - 1.5) as u32, (32.0 - end.y) as u32);
    assert!(near > 0.3, "{near}");
    // The same lines behind the camera, across the borders of an equirectangular picture: +x is its border.
    let kind = CameraKind::Spherical(SphericalMapping::Equirectangular);
    let edge = line(DVec3::new(4.0, 0.0, -8.0), DVec3::new(4.0, 0.0, 0.0));
    let picture = layer(described(kind, Vec::new(), vec![edge]), PixelRect::full([SIDE; 2]));
    // 45 degrees on both sides are an eighth of the width.
    for x in (0..7).chain(57..64) {
        assert!((column(&picture, x) - 1.5).abs() < 0.1, "{x}");
    }
    assert!((10..54).all(|x| column(&picture, x) == 0.0));
}

/// A ball of radius 1/2, cut through its middle across the line of sight: a circle of 16 pixels radius about the middle.
fn cut_ball() -> Description {
    let ball =
        GroupDescription { shapes: vec![ShapeDescription::sphere(0.5)], ..GroupDescription::default() };
    let mut description = described(CameraKind::Orthographic, Vec::new(), Vec::new());
    description.groups.push(ball);
    description.world.instances.push(InstanceDescription {
        name: String::new(),
        group: 0,
        to_parent: DMat4::IDENTITY,
        location: None,
    });
    description.section =
        Some(SectionDescription { group: 0, normal: DVec3::NEG_Z, offset: 0.0, material: 0 });
    description
}

#[test]
fn faces_of_a_section_have_outlines() {
    let description = cut_ball();
    let whole = layer(description.clone(), PixelRect::full([SIDE; 2]));
    let area: f64 = whole.coverage.iter().map(|&share| f64::from(share) / 255.0).sum();
    assert!((area - 1.5 * TAU * 16.0).abs() < 4.0, "{area}");
    for (pixel, [x, y]) in PixelRect::full([SIDE; 2]).pixels().enumerate() {
        let distance = (f64::from(x) + 0.5 - 32.0).hypot(f64::from(y) + 0.5 - 32.0);
        assert!(whole.coverage[pixel] == 0 || (distance - 16.0).abs() < 1.5, "{x} {y}");
    }
    let crop = PixelRect { min: [10, 20], size: [30, 17] };
    let part = layer(description, crop);
    for (pixel, [x, y]) in crop.pixels().enumerate() {
        assert_eq!(part.coverage[pixel], whole.coverage[(y * SIDE + x) as usize], "{x} {y}");
    }
}

/// Cancels a job in a phase.
struct PhaseCanceller {
    phase: &'static str,
    cancel: CancelFlag,
}

impl ProgressSink for PhaseCanceller {
    fn on_progress(&mut self, progress: &JobProgress<'_>) {
        if progress.phase == self.phase {
            self.cancel.cancel();
        }
    }
}

#[test]
fn drawing_is_cancelled_in_each_phase() {
    let mut description = cut_ball();
    description.world.edges.push(line(DVec3::NEG_X, DVec3::X));
    let (scene, _) = Scene::resolve(description).unwrap();
    for phase in ["edges", "outline of the section"] {
        let cancel = CancelFlag::default();
        let mut sink = PhaseCanceller { phase, cancel: cancel.clone() };
        let drawn = EdgeLayer::draw(&scene, &FilmFormat::plain([SIDE; 2]), STYLE, &mut sink, &cancel);
        assert_eq!(drawn, Err(Interrupted), "{phase}");
    }
}

#[test]
fn points_on_the_film_are_as_many_as_its_pixels_need() {
    let (scene, _) = Scene::resolve(described(CameraKind::Orthographic, Vec::new(), Vec::new())).unwrap();
    let curves = FilmCurves::new(scene.camera(), [SIDE; 2], STYLE.width);
    // Circles of 20 000 points with these radii, pixels. Two steps in a row together have at least a quarter of a pixel.
    for radius in [1e-3_f64, 16.0] {
        let points = (0..=20_000).map(|i| {
            let angle = TAU * f64::from(i) / 20_000.0;
            radius / 32.0 * DVec3::new(angle.cos(), angle.sin(), 0.0)
        });
        let found = curves.project(&points.collect::<Vec<DVec3>>());
        assert_eq!(found.len(), 1);
        let is_step = |pair: &[FilmPoint]| pair[0].film.distance(pair[1].film) <= 1.0;
        assert!(found[0].windows(2).all(is_step));
        let most = 2.0 + TAU * radius / 0.125;
        assert!((2.0..=most).contains(&(found[0].len() as f64)), "{radius} {}", found[0].len());
    }
}
