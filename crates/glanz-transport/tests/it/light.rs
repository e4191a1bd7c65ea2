//! Paths from lights: the same picture as `path` where `path` finds the light, closed forms where it does not.
//!
//! Seeds are fixed. Averages may differ by three standard errors: one fair comparison in 370 fails, and there are some sixty. Per pixel the mean
//! of the squared difference over its variance is 1 if variances are known; the bound of 1.5 is 5 standard deviations of that mean over some
//! 100 pixels with three bands that tell the same.

use std::sync::Arc;

use std::f64::consts::{PI, TAU};

use crate::common::*;
use glanz_light::Pixels;
use glanz_light::intensity::{AngularSystem, IntensityDistribution, LuminousOpening, OpeningShape, Symmetry};
use glanz_math::{DMat4, DVec2, DVec3};
use glanz_scene::SceneBuilder;
use glanz_scene::description::*;
use glanz_transport::{Film, RenderError};

fn glossy() -> MaterialKind {
    MaterialKind::phong(0.0, 0.3, 0.6, 30.0)
}

fn mirror(reflectance: f32) -> MaterialKind {
    MaterialKind::mirror(reflectance)
}

/// A floor and a back wall, in front of them a grey and a glossy ball; no light.
fn corner() -> SceneBuilder {
    looking(DVec3::new(-3.0, 0.3, 1.2), DVec3::new(0.0, 0.0, 0.3), [12, 9], 0.9)
        .shape(rectangle(DVec3::new(-2.0, -2.0, 0.0), DVec3::X * 4.0, DVec3::Y * 4.0), diffuse(0.6))
        .shape(rectangle(DVec3::new(2.0, -2.0, 0.0), DVec3::Z * 2.0, DVec3::Y * 4.0), diffuse(0.5))
        .shape(ShapeDescription::sphere(0.4).translated([0.2, 0.6, 0.4]), diffuse(0.7))
        .shape(ShapeDescription::sphere(0.4).translated([0.0, -0.5, 0.4]), glossy())
}

/// A lamp that faces down, out of sight.
fn lamp(builder: SceneBuilder) -> SceneBuilder {
    builder.shape(
        ShapeDescription::disk(0.4)
            .rotated(DVec3::X, PI)
            .translated([-0.3, 0.0, 2.6])
            .emitting([19.0, 17.0, 13.0]),
        diffuse(0.2),
    )
}

fn lens(builder: SceneBuilder) -> SceneBuilder {
    builder.edit(|scene| (scene.camera.lens_radius, scene.camera.focal_distance) = (0.1, 2.5))
}

fn parallel(builder: SceneBuilder) -> SceneBuilder {
    builder.edit(|scene| scene.camera.kind = CameraKind::Orthographic)
}

/// The scene under a picture that is seen through a window above.
fn behind_portal(builder: SceneBuilder) -> SceneBuilder {
    let at = |x: f64, y: f64| DVec3::new(x, y, 1.9);
    let portal = [at(-1.0, -1.0), at(-1.0, 1.2), at(0.8, 1.2), at(0.8, -1.0)];
    let mapping = SphereMapping::LatitudeLongitude;
    under_picture(builder, mapping, [16, 8]).edit(|scene| {
        scene.lights[0].kind = LightKind::PortalInfinite { image: Some((0, mapping)), portal };
    })
}

/// The scene under a disk with a picture.
fn with_pictured_disk(builder: SceneBuilder) -> SceneBuilder {
    let mapping = SphereMapping::LatitudeLongitude;
    let builder = under_picture(builder, mapping, [16, 8]).edit(|scene| scene.lights.clear());
    let emission = EmissionDescription { image: Some(0), ..20.0.into() };
    let disk = ShapeDescription::disk(0.4).rotated(DVec3::X, PI).translated([-0.3, 0.0, 2.6]);
    builder.shape(disk.emitting(emission), diffuse(0.2))
}

/// The scene under a lamp with a picture that faces down.
fn with_lamp(builder: SceneBuilder, kind: LightKind) -> SceneBuilder {
    under_picture(builder, SphereMapping::LatitudeLongitude, [16, 8]).edit(|scene| {
        let to_world = DMat4::from_translation(DVec3::new(-0.3, 0.1, 2.2)) * DMat4::from_rotation_x(PI);
        scene.lights[0] = LightDescription { to_world, ..LightDescription::new(kind, 4.0) };
        // The spot would be found so rarely by scattered rays that `path` does not know its own error.
        let image = &mut scene.images[0];
        let rgb: Vec<[f32; 3]> =
            image.picture.to_rgb().unwrap().iter().map(|p| p.map(|x| x.min(0.6))).collect();
        *image = ImageDescription::try_new("dimmed", &Pixels::try_from_rgb(16, 8, &rgb).unwrap()).unwrap();
    })
}

/// Fails unless `light` and `path` make the same picture.
fn compare(name: &str, scene: &SceneBuilder, depth: u32, samples: u32, largest_error: f64) {
    let path = Run { seed: 5, ..Run::new("path", depth, samples) }.picture(scene);
    let light = Run { seed: 6, ..Run::new("light", depth, samples) }.picture(scene);
    let spread = assert_same(&path, &light, largest_error, name);
    println!("{name}: {spread:.2}, averages {:?} {:?}", path.average(1), light.average(1));
    // Bands agree: the spread of a mean over pixels is that of a chi-square of as many degrees of freedom, within three sigma.
    let pixels = path.mean[0].len() as f64;
    let largest = 1.5_f64.max(1.0 + 3.0 * (2.0 / pixels).sqrt());
    assert!(spread < largest, "{name}: mean Z^2 of pixels {spread}");
}

#[test]
fn lamps_of_every_kind_light_the_same_picture() {
    let spot = LightKind::Spot {
        from: DVec3::new(-1.0, 1.0, 2.0),
        to: DVec3::new(0.2, 0.0, 0.2),
        cone_angle: 0.6,
        inner_angle: 0.2,
        falloff: SpotFalloff::Smoothstep,
    };
    let fading = LightKind::Point { from: DVec3::new(-0.5, 0.0, 1.2), range: Some(2.5) };
    let luminaire = |opening| {
        let (polars, candela) = (vec![0.0, 60.0, 180.0], vec![4000.0, 3000.0, 500.0]);
        let all_round =
            IntensityDistribution::try_new(AngularSystem::C, Symmetry::Axial, &[0.0], polars, candela);
        let from = DVec3::new(-0.5, 0.0, 1.2);
        LightKind::Photometric { distribution: Arc::new(all_round.unwrap()), opening, from }
    };
    let plate = LuminousOpening { shape: OpeningShape::Rectangle, size: [0.4, 0.2, 0.0] };
    let distant = LightKind::Distant { from: DVec3::new(-1.0, 0.4, 2.0), to: DVec3::ZERO };
    let ball = corner()
        .shape(ShapeDescription::sphere(0.2).translated([-0.4, 0.2, 2.5]).emitting([50.0; 3]), diffuse(0.0));
    for (name, scene) in [
        ("disk", lamp(corner())),
        ("ball", ball),
        ("fading point", corner().light(LightDescription::new(fading.clone(), [3.0; 3]))),
        ("spot", corner().light(LightDescription::new(spot.clone(), [8.0; 3]))),
        ("luminaire", corner().light(LightDescription::new(luminaire(None), [1.0; 3]))),
        ("luminaire with a size", corner().light(LightDescription::new(luminaire(Some(plate)), [1.0; 3]))),
        ("distant", corner().light(LightDescription::new(distant.clone(), [2.0; 3]))),
        ("infinite", corner().light(LightDescription::infinite([0.5; 3]))),
        ("picture", under_picture(corner(), SphereMapping::LatitudeLongitude, [16, 8])),
        ("equal-area picture", under_picture(corner(), SphereMapping::EqualArea, [12, 12])),
        ("portal", behind_portal(corner())),
        ("disk with a picture", with_pictured_disk(corner())),
        ("projected picture", with_lamp(corner(), LightKind::Projection { image: 0, field_of_view: 1.5 })),
        (
            "goniometric picture",
            with_lamp(
                corner(),
                LightKind::Goniometric { image: 0, mapping: SphereMapping::LatitudeLongitude },
            ),
        ),
        (
            "all",
            lamp(corner())
                .light(LightDescription::new(fading, [2.0; 3]))
                .light(LightDescription::new(spot, [4.0; 3]))
                .light(LightDescription::new(distant, [1.0; 3]))
                .light(LightDescription::infinite([0.2; 3])),
        ),
    ] {
        // Samples of the disk do not follow its picture.
        let samples = if name == "disk with a picture" { 1600 } else { 400 };
        compare(name, &scene, 4, samples, 0.02);
    }
}

#[test]
fn lenses_and_parallel_projection_see_the_same_picture() {
    let scene = lamp(corner());
    compare("lens", &lens(scene.clone()), 4, 400, 0.02);
    compare("parallel", &parallel(scene.clone()), 4, 400, 0.02);
    compare("parallel lens", &lens(parallel(scene.clone())), 4, 400, 0.02);
    let stretch = DMat4::from_scale(DVec3::new(-1.3, 0.8, 1.1));
    let stretched = lens(scene).edit(|scene| scene.camera.to_world *= stretch);
    compare("mirrored and stretched camera", &stretched, 4, 400, 0.02);
}

/// The corner from its middle, by a camera of this kind, with a light that is not seen.
fn from_inside(kind: CameraKind, filter: FilterDescription, size: [u32; 2]) -> SceneBuilder {
    let camera = CameraDescription::look_at([-0.6, 0.1, 1.3], [0.4, 0.0, 0.5], DVec3::Z);
    let point = LightKind::Point { from: DVec3::new(-0.3, 0.4, 2.3), range: None };
    corner().light(LightDescription::new(point, [3.0; 3])).light(LightDescription::infinite([0.2; 3])).edit(
        |scene| {
            scene.camera = CameraDescription { kind, ..camera };
            scene.filter = filter;
            scene.film.resolution = size;
        },
    )
}

#[test]
fn spherical_pictures_and_fisheyes_are_the_same() {
    // Filters that reach beyond the borders of spherical pictures, where light arrives from the opposite side.
    let wide = FilterDescription { kind: FilterKind::Triangle, radius: [1.5, 1.5] };
    let mitchell =
        FilterDescription { kind: FilterKind::Mitchell { b: 1.0 / 3.0, c: 1.0 / 3.0 }, radius: [2.0, 2.0] };
    for (mapping, size) in
        [(SphericalMapping::Equirectangular, [14, 7]), (SphericalMapping::EqualArea, [9, 9])]
    {
        for filter in [wide, mitchell] {
            let scene = from_inside(CameraKind::Spherical(mapping), filter, size);
            compare(&format!("{mapping:?} {:?}", filter.kind), &scene, 3, 600, 0.02);
        }
    }
    for projection in
        [FisheyeProjection::Equidistant, FisheyeProjection::Equisolid, FisheyeProjection::Stereographic]
    {
        let kind = CameraKind::Fisheye { field_of_view: 4.0, projection };
        compare(&format!("{projection:?}"), &from_inside(kind, wide, [12, 9]), 3, 500, 0.02);
    }
}

#[test]
fn parts_of_spherical_pictures_have_the_light_of_both_sides() {
    // The first column and the first rows alone: their filters reach to the last column and over the pole.
    let wide = FilterDescription { kind: FilterKind::Box, radius: [1.5, 1.5] };
    let kind = CameraKind::Spherical(SphericalMapping::Equirectangular);
    let scene = from_inside(kind, wide, [12, 6]).edit(|scene| scene.film.crop = [0.0, 1.0 / 12.0, 0.0, 1.0]);
    compare("column", &scene, 3, 4000, 0.02);
}

#[test]
fn light_is_not_connected_through_realistic_lenses() {
    let stop = LensInterfaceDescription { curvature_radius: 0.0, thickness: 0.0, eta: 0.0, diameter: 0.005 };
    let ball =
        LensInterfaceDescription { curvature_radius: 0.05, eta: 1.5, thickness: 0.003, diameter: 0.02 };
    let back = LensInterfaceDescription { curvature_radius: -0.05, eta: 1.0, ..ball };
    let lens = LensDescription {
        interfaces: vec![ball, back, stop],
        aperture_diameter: 0.005,
        focus_distance: 2.0,
        stop: StopShape::Iris(IrisDescription::default()),
        relative_weights: false,
    };
    let filter = FilterDescription { kind: FilterKind::Box, radius: [0.5, 0.5] };
    let scene = from_inside(CameraKind::Realistic(Box::new(lens)), filter, [6, 4]);
    let run = Run::new("light", 3, 4);
    let film = Film::try_new(run.format(&scene)).unwrap();
    assert!(matches!(run.resume(&scene, film, 0..4, None), Err(RenderError::Camera)));
    // Other integrators agree on the irradiance of the film.
    let path = Run { seed: 3, ..Run::new("path", 3, 2000) }.picture(&scene);
    let distributed = Run { seed: 4, ..Run::new("distributed", 3, 1000) }.picture(&scene);
    let spread = assert_same(&path, &distributed, 0.02, "realistic");
    assert!(spread < 1.5, "{spread}");
}

#[test]
fn sensors_expose_splats_as_samples() {
    let plain = lamp(corner());
    let sensor = SensorDescription { exposure: 3.0, white_balance: Some(4500.0), limit: SampleLimit::None };
    let exposed = plain.clone().edit(|scene| scene.film.sensor = sensor);
    compare("sensor", &exposed, 4, 400, 0.02);
    // A limit far above all samples changes no bit, one below all of them holds for every pixel.
    let limited =
        |limit| plain.clone().edit(move |scene| scene.film.sensor.limit = SampleLimit::Component(limit));
    let run = Run::new("path", 3, 16);
    assert_eq!(run.picture(&limited(1e9)).mean, run.picture(&plain).mean);
    let dark = run.picture(&limited(1e-3));
    assert!(dark.mean.iter().flatten().all(|&value| value <= 1.001e-3));
}

#[test]
fn depth_means_the_same() {
    for depth in [0, 1, 2, 3] {
        // The lamp itself is seen.
        let kind = CameraKind::Perspective { field_of_view: 2.0 };
        let scene = lamp(corner()).edit(|scene| scene.camera.kind = kind);
        compare(&format!("depth {depth}"), &scene, depth, 300, 0.15);
    }
}

#[test]
fn endless_planes_and_skies_agree() {
    // Most of what is seen is beyond the sphere that rays from the sky aim at.
    let scene = looking(DVec3::new(-3.0, 0.3, 1.0), DVec3::new(0.0, 0.0, 0.3), [12, 9], 1.4)
        .shape(ShapeDescription::plane(), diffuse(0.6))
        .shape(ShapeDescription::sphere(0.4).translated([0.2, 0.6, 0.4]), mirror(0.9))
        .shape(ShapeDescription::sphere(0.4).translated([0.0, -0.5, 0.4]), glass())
        .light(LightDescription::infinite([0.6; 3]))
        .light(LightDescription::new(
            LightKind::Distant { from: DVec3::new(-1.0, 0.4, 2.0), to: DVec3::ZERO },
            [0.3; 3],
        ));
    compare("sky", &scene, 3, 400, 0.02);
}

#[test]
fn interpolated_normals_scatter_the_light_of_both_ways_alike() {
    // Octahedra with the normals of spheres: the adjoint BSDF differs from the BSDF nearly everywhere.
    let positions = vec![DVec3::X, -DVec3::X, DVec3::Y, -DVec3::Y, DVec3::Z, -DVec3::Z];
    let mut indices = Vec::new();
    for (x, y, z) in [(0, 2, 4), (0, 2, 5), (0, 3, 4), (0, 3, 5), (1, 2, 4), (1, 2, 5), (1, 3, 4), (1, 3, 5)]
    {
        indices.push(if (x + y + z) % 2 == 0 { [x, y, z] } else { [y, x, z] });
    }
    let round =
        GeometryDescription::Triangles { normals: Some(positions.clone()), positions, indices, uvs: None };
    for kind in [diffuse(0.8), glossy(), mirror(0.9)] {
        let name = format!("octahedra {kind:?}");
        let ball = |y| ShapeDescription::from(round.clone()).scaled([0.45; 3]).translated([0.1, y, 0.45]);
        let scene = lamp(
            looking(DVec3::new(-3.0, 0.3, 1.2), DVec3::new(0.0, 0.0, 0.3), [12, 9], 0.9)
                .shape(rectangle(DVec3::new(-2.0, -2.0, 0.0), DVec3::X * 4.0, DVec3::Y * 4.0), diffuse(0.6))
                .shape(ball(0.5), kind.clone())
                .shape(ball(-0.5), kind),
        );
        compare(&name, &scene, 4, 700, 0.02);
    }
}

#[test]
fn signed_filters_and_crop_windows_are_heeded() {
    let filter =
        FilterDescription { kind: FilterKind::Mitchell { b: 1.0 / 3.0, c: 1.0 / 3.0 }, radius: [2.0, 2.0] };
    let scene = lamp(corner()).edit(|scene| scene.filter = filter);
    compare("filter", &scene, 3, 600, 0.02);
    let scene = scene.edit(|scene| scene.film.crop = [0.3, 0.8, 0.2, 0.9]);
    compare("crop", &scene, 3, 1000, 0.02);
}

#[test]
fn lamps_behind_borders_and_lamps_without_sampling_agree() {
    let wrapped = lamp(corner())
        .shape(ShapeDescription::sphere(0.6).translated([-0.3, 0.0, 2.6]), MaterialKind::Interface)
        .shape(ShapeDescription::sphere(0.6).translated([0.0, -0.5, 0.4]), MaterialKind::Interface)
        .shape(ShapeDescription::sphere(0.5).translated([-3.0, 0.3, 1.2]), MaterialKind::Interface);
    compare("borders", &wrapped, 3, 400, 0.02);
    // Points on an algebraic surface cannot be sampled: a sphere by its equation.
    let square = |axis: usize| (std::array::from_fn(|i| if i == axis { 2 } else { 0 }), 1.0);
    let ball = GeometryDescription::Algebraic {
        terms: vec![square(0), square(1), square(2), ([0, 0, 0], -0.25)],
        clip: [DVec3::splat(-1.0), DVec3::splat(1.0)],
    };
    let ball = ShapeDescription::from(ball);
    let scene = corner().shape(ball.translated([-0.4, 0.5, 1.2]).emitting([3.0; 3]), diffuse(0.0));
    compare("algebraic lamp", &scene, 3, 600, 0.05);
}

#[test]
fn glass_throws_the_light_that_path_finds_by_chance() {
    let scene = looking(DVec3::new(-1.5, 0.0, 0.7), DVec3::ZERO, [10, 10], 0.5)
        .shape(ShapeDescription::disk(3.0), diffuse(0.6))
        .shape(ShapeDescription::sphere(0.4).translated([0.0, 0.0, 1.0]), glass())
        .shape(
            ShapeDescription::sphere(0.1).translated([0.3, 0.0, 3.0]).emitting([250.0, 200.0, 150.0]),
            diffuse(0.0),
        );
    let path = Run { seed: 5, ..Run::new("path", 6, 8000) }.picture(&scene);
    let light = Run { seed: 6, ..Run::new("light", 6, 1000) }.picture(&scene);
    let spread = assert_same(&path, &light, 0.05, "glass");
    assert!(spread < 1.5, "mean Z^2 of pixels {spread}");
    // With eight times the samples `path` would have an eighth of the variance if both were as good.
    let sum = |picture: &Picture| picture.variance[1].iter().sum::<f64>();
    println!("variance of path with 8 times the samples {}, of light {}", sum(&path), sum(&light));
    assert!(sum(&light) < sum(&path), "{} {}", sum(&light), sum(&path));
}

/// Means over each pixel of `radiance` on the floor z = 0, 16 x 16 points.
fn floor_picture(scene: &SceneBuilder, radiance: impl Fn(f64, f64) -> f64) -> Vec<f64> {
    plane_picture(scene, 0.0, radiance)
}

/// Means over each pixel of `radiance` on the plane z = `height`, 16 x 16 points.
pub(crate) fn plane_picture(
    scene: &SceneBuilder,
    height: f64,
    radiance: impl Fn(f64, f64) -> f64,
) -> Vec<f64> {
    let [columns, rows] = described(scene).film.resolution;
    let camera = resolved(scene).camera().clone();
    let mut means = Vec::new();
    for y in 0..rows {
        for x in 0..columns {
            let mut sum = 0.0;
            for i in 0..256 {
                let inside = (DVec2::new(f64::from(i % 16), f64::from(i / 16)) + 0.5) / 16.0;
                let ray =
                    camera.ray(DVec2::new(f64::from(x), f64::from(y)) + inside, DVec2::ZERO).unwrap().ray;
                let p = ray.at((height - ray.origin.z) / ray.direction.z);
                sum += radiance(p.x, p.y);
            }
            means.push(sum / 256.0);
        }
    }
    means
}

/// Fails unless pixels are `expected` within 4.5 standard errors each (7e-6 by chance) and 1 % of the brightest stated.
pub(crate) fn assert_pixels(picture: &Picture, expected: &[f64], name: &str) {
    let brightest = expected.iter().copied().fold(0.0, f64::max);
    for (i, &expected) in expected.iter().enumerate() {
        let (mean, error) = (picture.mean[0][i], picture.variance[0][i].sqrt());
        assert!(error < 0.02 * brightest, "{name}: pixel {i} has a standard error of {error}");
        assert!(
            (mean - expected).abs() <= 4.5 * error,
            "{name}: pixel {i} is {mean} +- {error}, not {expected}"
        );
    }
}

#[test]
fn flat_mirror_adds_the_light_of_the_image_source() {
    let (rho, reflectance, intensity, h, ceiling) = (0.5_f32, 0.8_f32, 3.0_f32, 1.0, 1.5);
    let scene = looking(DVec3::new(-2.0, 0.2, 1.2), DVec3::new(0.1, 0.0, 0.0), [6, 5], 0.6)
        .shape(ShapeDescription::disk(40.0), diffuse(rho))
        .shape(ShapeDescription::disk(200.0).translated([0.0, 0.0, ceiling]), mirror(reflectance))
        .light(LightDescription::point(DVec3::new(0.0, 0.0, h), [intensity; 3]));
    // I h / d^3 of the lamp and of its image, 2 x 1.5 - 1 = 2 above the floor. Depth 2: the mirror and the floor.
    let lit = |height: f64, x: f64, y: f64| {
        f64::from(intensity) * height / (height * height + x * x + y * y).powf(1.5)
    };
    let image = 2.0 * ceiling - h;
    let expected = floor_picture(&scene, |x, y| {
        f64::from(rho) / PI * (lit(h, x, y) + f64::from(reflectance) * lit(image, x, y))
    });
    assert_pixels(&Run::new("light", 2, 3000).picture(&scene), &expected, "flat mirror");
    // A path from the camera cannot meet a point.
    let direct = floor_picture(&scene, |x, y| f64::from(rho) / PI * lit(h, x, y));
    assert_pixels(&Run::new("path", 2, 500).picture(&scene), &direct, "flat mirror by path");
}

#[test]
fn parabolic_mirror_lights_the_floor_by_its_closed_form() {
    let (rho, reflectance, intensity, f, height) = (0.5_f32, 0.9_f32, 2.0_f32, 0.25, 2.0);
    // Apex up, at height + f; the focus at `height`. Radius 1 at a depth of r^2 / (4 f) = 1.
    let bowl = GeometryDescription::Paraboloid { radius: 1.0, z: [0.0, 1.0], phi_max: TAU };
    let scene = looking(DVec3::new(-2.0, 0.0, 1.1), DVec3::ZERO, [7, 5], 0.5)
        .shape(ShapeDescription::disk(9.0), diffuse(rho))
        .shape(
            ShapeDescription::from(bowl).rotated(DVec3::X, PI).translated([0.0, 0.0, height + f]),
            mirror(reflectance),
        )
        .light(LightDescription::point(DVec3::new(0.0, 0.0, height), [intensity; 3]));
    // The rim, 1.25 above the floor, hides the lamp from what is farther out than this.
    let edge = height / (height - 1.25);
    // A ray under the angle t to the axis meets the mirror at r = 2 f tan(t / 2) and goes down at that radius: the flux
    // 2 pi I sin t dt falls on the ring 2 pi r dr, which makes I / (f^2 (1 + r^2 / 4 f^2)^2).
    let expected = floor_picture(&scene, |x, y| {
        let r2 = x * x + y * y;
        let ring = 1.0 + r2 / (4.0 * f * f);
        let beam = if r2 < 1.0 { f64::from(reflectance) / (f * f * ring * ring) } else { 0.0 };
        let direct = height / (height * height + r2).powf(1.5);
        let lit = if r2.sqrt() < edge { direct } else { 0.0 };
        f64::from(rho) / PI * f64::from(intensity) * (beam + lit)
    });
    assert_pixels(&Run::new("light", 2, 4000).picture(&scene), &expected, "parabolic mirror");
}

#[test]
fn film_without_splats_is_refused() {
    let (run, scene) = (Run::new("light", 3, 4), lamp(corner()));
    let mut format = run.format(&scene);
    format.splats = false;
    let error = run.resume(&scene, Film::try_new(format).unwrap(), 0..4, None);
    assert!(matches!(error, Err(RenderError::Passes)));
}
