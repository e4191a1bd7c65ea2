//! Illuminance after reflection in mirrors, compared with closed forms.

use std::f64::consts::{PI, TAU};

use glanz_geometry::bezier::TrianglePatch;
use glanz_light::units::LUMINOUS_EFFICACY;
use glanz_math::{DMat4, DVec2, Ray};
use glanz_scene::SceneBuilder;
use glanz_scene::description::*;

use super::*;

pub(super) const BLACK: &str = "black";
const MIRROR: &str = "mirror";
/// Of the mirrors.
const REFLECTANCE: f64 = 0.75;
/// cd/m^2 of an emitter of radiance 1.
pub(super) const LUMINANCE: f64 = LUMINOUS_EFFICACY;

const EXACT: Tolerance = Tolerance { relative: 1e-7, absolute: 0.0 };

/// A shape with the name of its material.
pub(super) type NamedShape = (ShapeDescription, &'static str);

pub(super) fn emitter(shape: ShapeDescription) -> NamedShape {
    (shape.emitting(1.0), BLACK)
}

pub(super) fn scene(shapes: Vec<NamedShape>) -> Scene {
    scene_with(shapes, Vec::new())
}

pub(super) fn scene_with(shapes: Vec<NamedShape>, lights: Vec<LightDescription>) -> Scene {
    let materials = SceneBuilder::new()
        .material(BLACK, MaterialKind::diffuse(0.0))
        .material(MIRROR, MaterialKind::mirror(REFLECTANCE as f32));
    let builder = shapes.into_iter().fold(materials, |builder, (shape, name)| builder.shape(shape, name));
    lights.into_iter().fold(builder, SceneBuilder::light).resolve().unwrap().0
}

/// A shape that faces down instead of up, moved by `at`.
pub(super) fn turned(shape: ShapeDescription, at: [f64; 3]) -> ShapeDescription {
    shape.rotated(DVec3::X, PI).translated(at)
}

pub(super) fn disk(radius: f64) -> ShapeDescription {
    ShapeDescription::disk(radius)
}

pub(super) fn sphere(radius: f64) -> ShapeDescription {
    ShapeDescription::sphere(radius)
}

pub(super) fn rectangle(x: [f64; 2], y: [f64; 2]) -> ShapeDescription {
    ShapeDescription::rectangle(x, y)
}

pub(super) fn close(found: f64, expected: f64, relative: f64, what: &str) {
    let off = (found - expected).abs();
    assert!(
        off <= relative * expected.abs(),
        "{what}: {found} instead of {expected}, {:.1e}",
        off / expected
    );
}

/// Illuminance by a sphere wholly above the horizon: L pi (R / d)^2 cos.
fn by_sphere(center: DVec3, radius: f64, point: DVec3, normal: DVec3) -> f64 {
    let to = center - point;
    LUMINANCE * PI * radius * radius / to.length_squared() * normal.dot(to.normalize())
}

/// Illuminance by a disk parallel to the receiver at height h, with its axis at distance a (@howell2011, factor B-13 of an element beside a disk).
fn by_disk(h: f64, a: f64, radius: f64) -> f64 {
    let (h2, a2, r2) = (h * h, a * a, radius * radius);
    let root = ((h2 + a2 + r2).powi(2) - 4.0 * a2 * r2).sqrt();
    LUMINANCE * PI * 0.5 * (1.0 - (h2 + a2 - r2) / root)
}

/// Illuminance by a rectangle parallel to the receiver at height 1, from the foot of the receiver's normal to (x, y) (@howell2011, factor B-3).
fn by_corner(x: f64, y: f64) -> f64 {
    let (u, v) = ((1.0 + x * x).sqrt(), (1.0 + y * y).sqrt());
    LUMINANCE * 0.5 * (x / u * (y / u).atan() + y / v * (x / v).atan())
}

fn by_rectangle(h: f64, x: [f64; 2], y: [f64; 2]) -> f64 {
    let corner = |x: f64, y: f64| by_corner(x / h, y / h);
    corner(x[1], y[1]) - corner(x[0], y[1]) - corner(x[1], y[0]) + corner(x[0], y[0])
}

/// The plane z = 0 as a mirror from -2 m to 2 m, as surfaces of several kinds.
fn flat_mirrors() -> Vec<(&'static str, NamedShape)> {
    let corners = [(-2.0, -2.0), (2.0, -2.0), (2.0, 2.0), (-2.0, 2.0)].map(|(x, y)| DVec3::new(x, y, 0.0));
    let mesh = ShapeDescription::mesh(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]]);
    // Curved in its parameters, but flat in space.
    let patch = BezierPatchesDescription {
        degree_u: 2,
        degree_v: 1,
        patches: vec![[-2.0, 0.5, 2.0].iter().flat_map(|&x| [-2.0, 2.0].map(|y| [x, y, 0.0, 1.0])).collect()],
    };
    let lid = ShapeDescription::cuboid([-2.0, -2.0, -1.0], [2.0, 2.0, 0.0]);
    vec![
        ("plane", (rectangle([-2.0, 2.0], [-2.0, 2.0]), MIRROR)),
        ("mesh", (mesh, MIRROR)),
        ("patch", (GeometryDescription::BezierPatches(patch).into(), MIRROR)),
        ("disk", (disk(2.5), MIRROR)),
        ("box", (lid, MIRROR)),
    ]
}

#[test]
fn flat_mirror_shows_an_emitter_at_its_image() {
    // Receivers at z = 1 face down, so that they see the emitters at z = 1.5 in the mirror only, as if these were at z = -1.5.
    let emitters = [
        ("sphere", emitter(sphere(0.1).translated([0.3, 0.2, 1.5]))),
        ("disk", emitter(turned(disk(0.2), [0.3, 0.2, 1.5]))),
        ("rectangle", emitter(turned(rectangle([-0.3, 0.3], [-0.05, 0.05]), [0.3, 0.2, 1.5]))),
    ];
    for (kind, emitter) in emitters {
        for (mirror, shape) in flat_mirrors() {
            let scene = scene(vec![emitter.clone(), shape]);
            let reflections = Reflections::new(&scene).unwrap();
            for (x, y) in [(0.31, 0.22), (-0.7, 0.4), (1.1, -0.9)] {
                let point = DVec3::new(x, y, 1.0);
                let image = DVec3::new(0.3, 0.2, -1.5);
                let expected = match kind {
                    "sphere" => by_sphere(image, 0.1, point, -DVec3::Z),
                    "disk" => by_disk(2.5, (x - 0.3).hypot(y - 0.2), 0.2),
                    _ => by_rectangle(2.5, [-x, 0.6 - x], [0.15 - y, 0.25 - y]),
                };
                let found = reflections.illuminance(point, -DVec3::Z, EXACT);
                let expected = REFLECTANCE * expected;
                let what = format!("{kind} in a {mirror} from ({x}, {y}): {found:?}");
                assert_eq!(found.direct, 0.0, "{what}");
                close(found.reflected, expected, 1e-6, &what);
                let off = (found.reflected - expected).abs();
                // Spectra have seven digits.
                assert!(off <= found.error + 3e-7 * expected && found.error <= 1e-6 * expected, "{what}");
            }
        }
    }
}

#[test]
fn mirrors_reflect_by_their_opacity() {
    let reflected = |opacity: f32| {
        let mirror = rectangle([-2.0, 2.0], [-2.0, 2.0]).with_alpha(FloatParameter::Value(opacity));
        let scene = scene(vec![emitter(sphere(0.1).translated([0.3, 0.2, 1.5])), (mirror, MIRROR)]);
        Reflections::new(&scene).unwrap().illuminance(DVec3::new(0.31, 0.22, 1.0), -DVec3::Z, EXACT).reflected
    };
    let image = by_sphere(DVec3::new(0.3, 0.2, -1.5), 0.1, DVec3::new(0.31, 0.22, 1.0), -DVec3::Z);
    for opacity in [1.0, 0.25] {
        let expected = f64::from(opacity) * REFLECTANCE * image;
        close(reflected(opacity), expected, 1e-6, "reflected");
    }
}

/// Illuminance on the axis of a spherical mirror of radius `curvature` (negative: hollow) by a point of intensity 1 at distance `s` from its vertex,
/// at distance `q`: the light comes as from an image s' behind the vertex, 1/s' = 1/s + 2/curvature, and its solid angle has grown by (s / s')^2.
fn by_spherical_mirror(curvature: f64, s: f64, q: f64) -> f64 {
    let image = 1.0 / (1.0 / s + 2.0 / curvature);
    (image / s).powi(2) / (q + image).powi(2)
}

#[test]
fn spherical_mirrors_follow_their_equation() {
    // So small that the influence of its size is less than (radius / image)^2.
    let radius = 5e-4;
    let intensity = REFLECTANCE * LUMINANCE * PI * radius * radius;
    // The axis is x, where the parameters of spheres are regular. Emitter and receiver are on one side; the receiver faces the whole ball, whose
    // front hides its back.
    let zone = GeometryDescription::Sphere { radius: 10.0, z: [-1.0, 1.0], phi_max: 1.0 };
    let zone = ShapeDescription::from(zone);
    let cases = [
        ("ball", sphere(1.0), DVec3::X, 1.0, 1.0, 4.0),
        ("dish", zone.clone(), -DVec3::X, -10.0, -10.0, 3.0),
        ("dish, real image", zone, -DVec3::X, -10.0, -10.0, 8.0),
    ];
    for (what, mirror, axis, curvature, vertex, s) in cases {
        let shapes = vec![
            (mirror.transformed(DMat4::from_rotation_z(-0.5)), MIRROR),
            emitter(sphere(radius).transformed(DMat4::from_translation(axis * (vertex + s)))),
        ];
        let scene = scene(shapes);
        let reflections = Reflections::new(&scene).unwrap();
        let q = 2.0;
        let found =
            reflections.illuminance(axis * (vertex + q), -axis, Tolerance { relative: 1e-6, absolute: 0.0 });
        let expected = intensity * by_spherical_mirror(curvature, s, q);
        close(found.reflected, expected, 1e-5, what);
        assert!(found.error < 2e-6 * expected, "{what}: {found:?}");
    }
}

#[test]
fn occluders_hide_the_image() {
    let mirror = (rectangle([-2.0, 2.0], [-2.0, 2.0]), MIRROR);
    let over = emitter(turned(disk(0.4), [0.0, 0.0, 1.5]));
    let whole = LUMINANCE * REFLECTANCE * PI * 0.16 / (0.16 + 2.5 * 2.5);
    // Half of the hemisphere; and a disk on the axis, 0.75 m from the receiver, whose image in the mirror is farther away.
    let curtain = (rectangle([-1.9, 0.0], [-2.0, 2.0]).translated([0.0, 0.0, 0.5]), BLACK);
    let stop = (disk(0.05).translated([0.0, 0.0, 0.25]), BLACK);
    let ring = whole - LUMINANCE * REFLECTANCE * PI * 0.0025 / (0.0025 + 0.75 * 0.75);
    for (hider, expected) in [(curtain, 0.5 * whole), (stop, ring)] {
        let scene = scene(vec![mirror.clone(), over.clone(), hider]);
        let reflections = Reflections::new(&scene).unwrap();
        let tolerance = Tolerance { relative: 1e-3, absolute: 0.0 };
        let found = reflections.illuminance(DVec3::Z, -DVec3::Z, tolerance);
        assert!((found.reflected - expected).abs() <= found.error, "{found:?} {expected}");
        assert!(found.error <= 1e-3 * expected, "{found:?} {expected}");
    }
}

#[test]
fn trimmed_mirror_shows_what_is_left_of_the_image() {
    // Parameters of a rectangle are in [0, 1]; trimming leaves the part left of the middle.
    let corners = [[0.0, 0.0], [0.5, 0.0], [0.5, 1.0], [0.0, 1.0], [0.0, 0.0]];
    let points = corners.map(|[x, y]| [x, y, 1.0]).to_vec();
    let curve = TrimCurveDescription {
        degree: 1,
        knots: vec![0.0, 0.0, 1.0, 2.0, 3.0, 4.0, 4.0],
        points,
        width: None,
        edge: None,
    };
    let mut mirror = (rectangle([-2.0, 2.0], [-2.0, 2.0]), MIRROR);
    mirror.0.trim = Some(vec![TrimLoopDescription { curves: vec![curve] }].into());
    let scene = scene(vec![mirror, emitter(turned(disk(0.4), [0.0, 0.0, 1.5]))]);
    let reflections = Reflections::new(&scene).unwrap();
    let found = reflections.illuminance(DVec3::Z, -DVec3::Z, Tolerance { relative: 1e-3, absolute: 0.0 });
    let expected = 0.5 * LUMINANCE * REFLECTANCE * PI * 0.16 / (0.16 + 2.5 * 2.5);
    assert!((found.reflected - expected).abs() <= found.error, "{found:?} {expected}");
    assert!(found.error <= 1e-3 * expected);
}

/// Illuminance by a sphere of half angle `s`, whose centre is at the angle `w` from the normal, cut by the horizon.
///
/// # Source
/// @howell2011, a plane element and a sphere.
fn by_cut_sphere(s: f64, w: f64) -> f64 {
    let h = 1.0 / s.sin();
    let x = (h * h - 1.0).sqrt();
    let y = -x / w.tan();
    let root = (1.0 - y * y).sqrt();
    let over = (w.cos() * y.acos() - x * w.sin() * root) / (h * h);
    LUMINANCE * (over + (w.sin() * root / x).atan())
}

#[test]
fn horizon_cuts_emitters_and_their_images() {
    // A mirror on the wall x = 2 with its image of an emitter at x = 1; the receiver at the origin faces up. The emitter itself is seen too.
    let wall = DMat4::from_translation(DVec3::new(2.0, 0.0, 0.0)) * DMat4::from_rotation_y(-0.5 * PI);
    for height in [0.0, 0.05, -0.08] {
        let shapes = vec![
            (rectangle([-1.0, 1.0], [-1.0, 1.0]).transformed(wall), MIRROR),
            emitter(sphere(0.1).translated([1.0, 0.5, height])),
        ];
        let scene = scene(shapes);
        let reflections = Reflections::new(&scene).unwrap();
        let found =
            reflections.illuminance(DVec3::ZERO, DVec3::Z, Tolerance { relative: 1e-6, absolute: 0.0 });
        let seen = |x: f64| {
            let to = DVec3::new(x, 0.5, height);
            by_cut_sphere((0.1 / to.length()).asin(), to.angle_between(DVec3::Z))
        };
        close(found.direct, seen(1.0), 1e-8, "direct");
        let expected = REFLECTANCE * seen(3.0);
        assert!(
            (found.reflected - expected).abs() < 1e-6 * (found.direct + expected),
            "{found:?} {expected}"
        );
    }
}

#[test]
fn back_of_an_emitter_is_dark() {
    // Facing away from the mirror and from the receiver.
    let mirror = (rectangle([-2.0, 2.0], [-2.0, 2.0]), MIRROR);
    for form in [disk(0.2), rectangle([-0.1, 0.1], [-0.1, 0.1])] {
        let away = scene(vec![mirror.clone(), emitter(form.clone().translated([0.0, 0.0, 1.5]))]);
        let mut both = emitter(form.translated([0.0, 0.0, 1.5]));
        if let Some(emission) = &mut both.0.emission {
            emission.two_sided = true;
        }
        let both = scene(vec![mirror.clone(), both]);
        let seen = |scene: &Scene, normal| {
            Reflections::new(scene).unwrap().illuminance(DVec3::new(0.3, 0.0, 1.0), normal, EXACT)
        };
        assert_eq!(seen(&away, -DVec3::Z), IlluminanceEstimate::default());
        assert_eq!(seen(&away, DVec3::Z), IlluminanceEstimate::default());
        assert!(seen(&both, -DVec3::Z).reflected > 0.0 && seen(&both, DVec3::Z).direct > 0.0);
    }
}

/// The mirror of document 000 section 4.3, with an emitter of the given radius.
fn room(radius: f64) -> Scene {
    let patch = [
        [6.0, 3.0, 5.0],
        [6.0, 4.0, 8.0],
        [5.0, 3.0, 6.0],
        [6.0, 5.0, 6.0],
        [4.5, 4.5, 7.0],
        [4.0, 3.0, 6.0],
        [6.0, 6.0, 5.0],
        [5.0, 5.0, 6.0],
        [4.0, 4.0, 6.0],
        [3.0, 3.0, 3.0],
    ];
    let patch = TrianglePatch::try_from_points(3, &patch.map(DVec3::from_array), None).unwrap();
    let patch = ShapeDescription::bezier_triangles(&[patch]);
    let walls = ShapeDescription::cuboid([0.0; 3], [10.0; 3]);
    scene(vec![(walls, BLACK), (patch, MIRROR), emitter(sphere(radius).translated([0.25, 5.0, 5.0]))])
}

/// Illuminance after reflection in a mirror, by rays: from the point to every square of a grid over a rectangle of the plane x = 1, seen along `axis`.
/// Every ray is traced to its hit, and reflected there if the surface is a mirror.
fn by_rays(
    scene: &Scene,
    point: DVec3,
    normal: DVec3,
    axis: DVec3,
    range: [DVec2; 2],
    side: u32,
) -> (f64, [DVec2; 2]) {
    let (x, y) = axis.any_orthonormal_pair();
    let step = (range[1] - range[0]) / f64::from(side);
    let (mut sum, mut met) = (0.0, [DVec2::INFINITY, DVec2::NEG_INFINITY]);
    for k in 0..side * side {
        let at = range[0] + step * (DVec2::new(f64::from(k % side), f64::from(k / side)) + 0.5);
        let direction = (axis + x * at.x + y * at.y).normalize();
        let Some(first) = scene.intersect(&Ray::new(point + 1e-9 * normal, direction), f64::INFINITY) else {
            continue;
        };
        let n = first.point.normal;
        if !first.bsdf(scene, &Wavelengths::default()).is_some_and(|bsdf| bsdf.is_delta()) {
            continue;
        }
        let mirrored = direction - 2.0 * n * n.dot(direction);
        let second = scene.intersect(&first.spawn(mirrored), f64::INFINITY);
        if second.is_some_and(|second| second.light().is_some()) {
            // The solid angle of a square is its area times the cube of the cosine to the axis.
            let cos = direction.dot(axis);
            sum += cos.powi(3) * step.x * step.y * direction.dot(normal);
            met = [met[0].min(at - 3.0 * step), met[1].max(at + 3.0 * step)];
        }
    }
    (LUMINANCE * REFLECTANCE * sum, met)
}

#[test]
fn curved_mirror_agrees_with_rays() {
    let scene = room(0.3);
    let reflections = Reflections::new(&scene).unwrap();
    let mut seen = 0;
    for (point, normal) in [
        (DVec3::new(0.0, 3.0, 6.0), DVec3::X),
        (DVec3::new(2.0, 4.0, 10.0), -DVec3::Z),
        (DVec3::new(0.0, 6.5, 9.0), DVec3::X),
        (DVec3::new(3.0, 10.0, 8.0), -DVec3::Y),
        (DVec3::new(5.0, 0.0, 8.0), DVec3::Y),
        (DVec3::new(1.0, 4.0, 0.0), DVec3::Z),
    ] {
        let found = reflections.illuminance(point, normal, Tolerance { relative: 1e-4, absolute: 1e-6 });
        let axis = (DVec3::new(4.8, 4.2, 5.8) - point).normalize();
        let all = [DVec2::splat(-1.0), DVec2::splat(1.0)];
        let (rough, range) = by_rays(&scene, point, normal, axis, all, 200);
        if rough == 0.0 {
            assert!(found.reflected < 0.02, "{point}: {found:?}");
            continue;
        }
        let (expected, _) = by_rays(&scene, point, normal, axis, range, 300);
        // The image covers at least a thousand squares; those on its border count wholly or not at all, and most of these errors cancel.
        close(found.reflected, expected, 1e-2, &format!("{point}"));
        assert!(found.error < 2e-4 * found.total(), "{point}: {found:?}");
        seen += 1;
    }
    assert!(seen >= 2, "{seen}");
}

#[test]
fn point_lights_follow_the_cosine_law_and_have_no_image() {
    let mirror = (rectangle([-9.0, 9.0], [-9.0, 9.0]).translated([0.0, 0.0, 3.0]), MIRROR);
    let lit = scene_with(vec![mirror, (disk(0.1).translated([0.5, 0.0, 1.0]), BLACK)], vec![lit_by_point()]);
    let reflections = Reflections::new(&lit).unwrap();
    assert_eq!(reflections.unreflected().collect::<Vec<_>>(), [LightId(0)]);
    let found = reflections.illuminance(DVec3::new(0.0, 1.5, 0.0), DVec3::Z, EXACT);
    // I cos / d^2 with d = 2.5 and cos = 0.8.
    close(found.total(), LUMINANCE * 2.0 * 0.8 / 6.25, 1e-6, "point");
    assert_eq!(reflections.illuminance(DVec3::X, DVec3::Z, EXACT).total(), 0.0, "in the shadow");
    // The mean over a square around the foot: I times the solid angle of the square, 4 asin(1 / (1 + 4)) for half sides of 1 m seen from 2 m, over 4 m^2.
    let square = |uv: DVec2| Some(((2.0 * uv - 1.0).extend(0.0) * DVec3::new(-1.0, 1.0, 1.0), DVec3::Z, 4.0));
    let bare = scene_with(Vec::new(), vec![lit_by_point()]);
    let mean = Reflections::new(&bare).unwrap().cell_mean(
        square,
        Tolerance { relative: 1e-6, absolute: 0.0 },
        10_000,
    );
    let expected = LUMINANCE * 2.0 * (0.2_f64).asin();
    close(mean.mean, expected, 1e-6, "mean");
    assert!((mean.area - 4.0).abs() < 1e-12 && mean.error < 2e-6 * expected, "{mean:?}");
}

pub(super) fn lit_by_point() -> LightDescription {
    LightDescription::point([0.0, 0.0, 2.0], 2.0)
}

#[test]
fn errors_name_the_shape_that_cannot_be_integrated() {
    assert_eq!(Reflections::new(&scene(Vec::new())).err(), Some(IntegrateError::NoLight));
    let torus = ShapeDescription::torus(1.0, 0.1);
    let ring = GeometryDescription::Disk { height: 0.0, radius: 1.0, inner_radius: 0.5, phi_max: TAU };
    let mut hollow = emitter(sphere(1.0));
    hollow.0.reverse_orientation = true;
    let squeezed = DMat4::from_scale(DVec3::new(1.0, 1.0, 0.5));
    for (what, shape) in [
        ("torus", emitter(torus)),
        ("full disk", emitter(ring.into())),
        ("inwards", hollow),
        ("whole sphere", emitter(sphere(1.0).transformed(squeezed))),
    ] {
        let scene = scene(vec![shape]);
        let error = Reflections::new(&scene).err().unwrap();
        assert!(matches!(error, IntegrateError::EmitterForm { light: LightId(0), shape: 0, .. }), "{error}");
        assert!(error.to_string().contains(what), "{error}");
    }
    let sky = LightDescription::infinite(1.0);
    let error = Reflections::new(&scene_with(Vec::new(), vec![sky])).err();
    assert_eq!(error, Some(IntegrateError::Kind { light: LightId(0), kind: "infinite" }));
}
