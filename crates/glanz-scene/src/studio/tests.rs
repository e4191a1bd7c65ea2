use glanz_math::{Bounds3, DMat4, DVec2, DVec3};

use super::*;
use crate::description::{CameraDescription, MaterialKind, ShapeDescription};
use crate::{Camera, Scene, SceneBuilder};

/// Numbers in [0, 1), the same in every run.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    fn point(&mut self) -> DVec3 {
        DVec3::new(self.next(), self.next(), self.next()) * 2.0 - 1.0
    }
}

fn model(points: &[DVec3]) -> Description {
    let triangles = (1..points.len() as u32 - 1).map(|i| [0, i, i + 1]).collect();
    SceneBuilder::new()
        .shape(ShapeDescription::mesh(points.to_vec(), triangles), MaterialKind::diffuse(0.5))
        .describe()
        .unwrap()
}

/// The places of points in the picture, as fractions of its width and height from the top left.
fn projected(description: &Description, points: &[DVec3]) -> Vec<DVec2> {
    let camera = Camera::try_new(&description.camera, &description.film).unwrap();
    let size = description.film.resolution.map(f64::from);
    let project = |&point| camera.project(point, DVec2::ZERO).unwrap().film / DVec2::from(size);
    points.iter().map(project).collect()
}

#[test]
fn all_of_a_model_is_in_the_picture_and_fills_it() {
    let mut numbers = Numbers(1);
    for view in StudioView::ALL {
        for up in [UpAxis::Y, UpAxis::Z] {
            for resolution in [[640, 360], [360, 640], [500, 500], [1000, 100], [64, 1000], [1, 1]] {
                let scale = 10f64.powf(6.0 * numbers.next() - 3.0);
                let stretch = DVec3::new(numbers.next(), numbers.next(), numbers.next()) + 0.01;
                let middle = scale * 3.0 * numbers.point();
                let points: Vec<DVec3> =
                    (0..20).map(|_| middle + scale * stretch * numbers.point()).collect();
                let mut description = model(&points);
                description.film.resolution = resolution;
                let settings = StudioSettings { view: Some(view), up: Some(up), ..StudioSettings::default() };
                add_studio(&mut description, &settings);
                let seen = projected(&description, &points);
                let low = seen.iter().copied().fold(DVec2::INFINITY, DVec2::min);
                let high = seen.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max);
                // Five per cent of half the picture, but for rounding.
                let inside = low.min_element() > 0.025 - 1e-9 && high.max_element() < 0.975 + 1e-9;
                assert!(inside, "{view:?} {up:?} {resolution:?}: {low} {high}");
                let aspect = f64::from(resolution[0]) / f64::from(resolution[1]);
                let camera = description.camera.to_world.inverse();
                let depth = |point: &DVec3| camera.transform_point3(*point).z;
                let nearest = points.iter().map(depth).fold(f64::INFINITY, f64::min);
                // A camera that is as near as it may be, to a model that is long along the view, is the exception.
                let is_free =
                    nearest > 0.501 * Bounds3::from_points(points.iter().copied()).diagonal().length();
                if is_free && (0.5..2.0).contains(&aspect) {
                    let filled = (high - low).max_element();
                    assert!(filled > 0.949, "{view:?} {up:?} {resolution:?}: only {filled} of the picture");
                }
            }
        }
    }
}

#[test]
fn views_show_the_side_that_they_are_named_after_and_do_not_mirror_it() {
    // In the order of right, up and towards the viewer.
    let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
    for (up, view, axes) in [
        (UpAxis::Z, StudioView::Front, [x, z, -y]),
        (UpAxis::Z, StudioView::Back, [-x, z, y]),
        (UpAxis::Z, StudioView::Right, [y, z, x]),
        (UpAxis::Z, StudioView::Left, [-y, z, -x]),
        (UpAxis::Z, StudioView::Top, [x, y, z]),
        (UpAxis::Z, StudioView::Bottom, [x, -y, -z]),
        (UpAxis::Y, StudioView::Front, [x, y, z]),
        (UpAxis::Y, StudioView::Back, [-x, y, -z]),
        (UpAxis::Y, StudioView::Right, [-z, y, x]),
        (UpAxis::Y, StudioView::Left, [z, y, -x]),
        (UpAxis::Y, StudioView::Top, [x, -z, y]),
        (UpAxis::Y, StudioView::Bottom, [x, z, -y]),
    ] {
        let mut description = model(&Bounds3::new(-DVec3::ONE, DVec3::ONE).corners());
        let settings = StudioSettings { view: Some(view), up: Some(up), ..StudioSettings::default() };
        add_studio(&mut description, &settings);
        let [right, above, viewer] = axes;
        let seen = projected(&description, &[DVec3::ZERO, right, above]);
        let off = (seen[1] - seen[0]).y.abs().max((seen[2] - seen[0]).x.abs());
        assert!(seen[1].x > seen[0].x + 0.1 && seen[2].y < seen[0].y - 0.1 && off < 1e-9, "{view:?} {up:?}");
        let eye = description.camera.to_world.w_axis.truncate();
        assert!(eye.dot(viewer) > 2.0, "{view:?} {up:?} sees from {eye}");
    }
    let mut description = model(&Bounds3::new(-DVec3::ONE, DVec3::ONE).corners());
    add_studio(&mut description, &StudioSettings::default());
    let eye = description.camera.to_world.w_axis.truncate();
    assert!(eye.x > 1.0 && eye.y < -1.0 && eye.z > 1.0, "three quarters are seen from {eye}");
    let seen = projected(&description, &[DVec3::ZERO, x, y, z]);
    assert!(seen[1].x > seen[0].x && seen[2].x > seen[0].x && seen[3].y < seen[0].y);
    assert!(seen[1].y > seen[0].y && seen[2].y < seen[0].y, "+x comes nearer and +y goes away");
}

#[test]
fn the_ground_is_below_the_model_and_never_before_it() {
    let mut numbers = Numbers(2);
    for view in StudioView::ALL {
        for up in [UpAxis::Y, UpAxis::Z] {
            let points: Vec<DVec3> = (0..12).map(|_| numbers.point() * DVec3::new(1.0, 0.3, 0.02)).collect();
            let mut description = model(&points);
            let settings = StudioSettings { view: Some(view), up: Some(up), ..StudioSettings::default() };
            add_studio(&mut description, &settings);
            assert_eq!(description.world.shapes.len() == 1, view == StudioView::Bottom);
            let (scene, _) = Scene::resolve(description).unwrap();
            for point in points {
                let film = scene.camera().project(point, DVec2::ZERO).unwrap().film;
                let hit = scene.intersect(&scene.camera().ray(film, DVec2::ZERO).unwrap().ray, f64::INFINITY);
                let distance = (point - scene.camera().ray(film, DVec2::ZERO).unwrap().ray.origin).length();
                assert!(hit.is_none_or(|hit| hit.id == 0 || hit.t > distance), "{view:?} {up:?}");
            }
        }
    }
}

#[test]
fn without_a_ground_there_is_none() {
    let mut description = model(&Bounds3::new(-DVec3::ONE, DVec3::ONE).corners());
    add_studio(&mut description, &StudioSettings { ground: false, ..StudioSettings::default() });
    assert_eq!(description.world.shapes.len(), 1);
}

#[test]
fn a_point_a_line_and_nothing_have_pictures() {
    for points in [vec![DVec3::ONE; 3], vec![DVec3::ZERO, DVec3::Y, DVec3::Y * 2.0], Vec::new()] {
        for view in StudioView::ALL {
            let world = crate::description::GroupDescription {
                shapes: vec![ShapeDescription::mesh(points.clone(), Vec::new())],
                ..Default::default()
            };
            let mut description = Description { world, ..Description::default() };
            add_studio(&mut description, &StudioSettings { view: Some(view), ..StudioSettings::default() });
            assert!(description.camera.to_world.is_finite());
            Camera::try_new(&description.camera, &description.film).unwrap();
            if !points.is_empty() {
                let seen = projected(&description, &points);
                assert!(seen.iter().all(|p| p.min_element() > 0.0 && p.max_element() < 1.0), "{seen:?}");
            }
        }
    }
}

#[test]
fn a_material_replaces_those_of_all_groups() {
    let red = || MaterialKind::diffuse([1.0, 0.0, 0.0]);
    let mut description = SceneBuilder::new()
        .shape(ShapeDescription::sphere(1.0), red())
        .group("g", |group| group.shape(ShapeDescription::sphere(1.0), red()))
        .instance("g", DMat4::IDENTITY)
        .describe()
        .unwrap();
    let settings = StudioSettings { material: Some(StudioMaterial::Gold), ..StudioSettings::default() };
    add_studio(&mut description, &settings);
    assert_eq!(description.materials[0].kind, StudioMaterial::Gold.kind());
    let group = description.groups.iter().flat_map(|group| &group.shapes);
    assert!(group.chain(&description.world.shapes[..1]).all(|shape| shape.material == 0));
}

#[test]
fn a_turntable_keeps_the_model_in_the_picture_and_its_distance() {
    let mut numbers = Numbers(3);
    for view in StudioView::ALL {
        let points: Vec<DVec3> = (0..20).map(|_| numbers.point() * DVec3::new(3.0, 1.0, 0.5)).collect();
        let middle = Bounds3::from_points(points.iter().copied()).center();
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        let mut distances = Vec::new();
        for number in 0..24 {
            let mut description = model(&points);
            let turntable = Some(TurntableFrame { number, count: 24 });
            let settings = StudioSettings { view: Some(view), turntable, ..StudioSettings::default() };
            add_studio(&mut description, &settings);
            let seen = projected(&description, &points);
            low = seen.iter().copied().fold(low, DVec2::min);
            high = seen.iter().copied().fold(high, DVec2::max);
            distances.push(description.camera.to_world.w_axis.truncate().distance(middle));
        }
        assert!(
            low.min_element() > 0.025 - 1e-9 && high.max_element() < 0.975 + 1e-9,
            "{view:?} {low} {high}"
        );
        assert!((high - low).max_element() > 0.9, "{view:?} {low} {high}: 24 frames miss little of the turn");
        let off = distances.iter().map(|distance| (distance / distances[0] - 1.0).abs()).fold(0.0, f64::max);
        assert!(off < 1e-12, "{view:?} {distances:?}");
    }
}

#[test]
fn a_turntable_goes_to_the_right_and_begins_at_the_view() {
    let eye = |turntable| {
        let mut description = model(&Bounds3::new(-DVec3::ONE, DVec3::ONE).corners());
        let settings =
            StudioSettings { view: Some(StudioView::Front), turntable, ..StudioSettings::default() };
        add_studio(&mut description, &settings);
        description.camera.to_world.w_axis.truncate().normalize()
    };
    let frame = |number| eye(Some(TurntableFrame { number, count: 4 }));
    assert!(frame(0).distance(eye(None)) < 1e-12 && frame(0).distance(DVec3::NEG_Y) < 1e-12);
    assert!(frame(1).distance(DVec3::X) < 1e-12 && frame(2).distance(DVec3::Y) < 1e-12);
}

#[test]
fn a_studio_adds_only_what_a_model_lacks() {
    let own = CameraDescription::look_at([0.0, 0.0, 5.0], [0.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    let furnished = |own_camera: bool, own_light: bool, view: Option<StudioView>| {
        let mut description = model(&[DVec3::ZERO, DVec3::X, DVec3::Y]);
        description.camera = own.clone();
        let settings =
            StudioSettings { own_camera, own_light, view, up: Some(UpAxis::Y), ..StudioSettings::default() };
        add_studio(&mut description, &settings);
        let is_own = description.camera.to_world == own.to_world;
        (is_own, description.lights.len(), description.world.shapes.len(), description.backdrop.is_some())
    };
    let front = Some(StudioView::Front);
    // Four lights, and the ground beside the shape of the model.
    assert_eq!(furnished(false, false, None), (false, 4, 2, true));
    assert_eq!(furnished(true, false, None), (true, 4, 2, true));
    assert_eq!(furnished(true, false, front), (false, 4, 2, true));
    assert_eq!(furnished(false, true, None), (false, 0, 1, false));
    let settings = StudioSettings { own_camera: true, own_light: true, ..StudioSettings::default() };
    assert!(settings.is_superfluous());
    assert!(!StudioSettings { view: front, ..settings.clone() }.is_superfluous());
    assert!(!StudioSettings { own_light: false, ..settings }.is_superfluous());
}
