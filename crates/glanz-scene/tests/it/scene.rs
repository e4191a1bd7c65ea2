//! Facts about resolved scenes, from closed forms.

use std::f64::consts::{PI, TAU};

use glanz_light::{SpectralDistribution, Wavelengths};
use glanz_math::{DMat4, DVec2, DVec3, Ray};
use glanz_scene::description::*;
use glanz_scene::{Camera, Interaction, Light, LightId, Scene, SceneBuilder, SceneError, SceneErrorKind};
use glanz_shading::TransportMode;

const HERE: Location = Location { file: FileId(0), line: 7, column: 3 };

fn located(shape: ShapeDescription) -> ShapeDescription {
    ShapeDescription { location: Some(HERE), ..shape }
}

fn shining(shape: ShapeDescription) -> ShapeDescription {
    shape.emitting([2.0; 3])
}

fn unit_sphere() -> ShapeDescription {
    ShapeDescription::sphere(1.0)
}

/// The unit square in z = 0 as a mesh, its normal along +z.
fn square() -> ShapeDescription {
    let corners = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]];
    let positions = corners.iter().map(|&[x, y]| DVec3::new(x, y, 0.0)).collect();
    ShapeDescription::mesh(positions, vec![[0, 1, 2], [0, 2, 3]])
}

fn grey() -> MaterialKind {
    MaterialKind::diffuse(0.5)
}

fn with_shapes<const N: usize>(shapes: [ShapeDescription; N]) -> SceneBuilder {
    SceneBuilder::new().shapes(shapes, grey())
}

fn resolve(builder: SceneBuilder) -> Scene {
    builder.resolve().unwrap().0
}

fn error(builder: SceneBuilder) -> SceneError {
    builder.resolve().unwrap_err()
}

/// A point of a small disk at the origin on the side of -z, away from lights at z > 0.
fn observer(scene: &Scene) -> Interaction {
    scene.intersect(&Ray::new(DVec3::new(0.0, 0.0, -3.0), DVec3::Z), f64::INFINITY).unwrap()
}

fn translate(x: f64, y: f64, z: f64) -> DMat4 {
    DMat4::from_translation(DVec3::new(x, y, z))
}

#[test]
fn ray_hits_a_nested_instance_in_its_place() {
    let inner = |group: SceneBuilder| group.shape(unit_sphere().translated(DVec3::Z), grey());
    let outer = |group: SceneBuilder| group.instance("inner", DMat4::from_scale(DVec3::splat(2.0)));
    let builder = SceneBuilder::new().group("inner", inner).group("outer", outer);
    let scene = resolve(builder.instance("outer", translate(5.0, 0.0, 0.0)));
    // The sphere about (0, 0, 1) grows to radius 2 about (0, 0, 2) and moves to (5, 0, 2).
    let hit = scene.intersect(&Ray::new(DVec3::new(0.0, 0.0, 2.0), DVec3::X), f64::INFINITY).unwrap();
    assert!((hit.t - 3.0).abs() < 1e-12);
    assert!((hit.point.position - DVec3::new(3.0, 0.0, 2.0)).length() < 1e-12);
    assert!((hit.point.normal + DVec3::X).length() < 1e-12);
    assert!((hit.wo + DVec3::X).length() < 1e-15);
    assert!(scene.occluded(&Ray::new(DVec3::new(0.0, 0.0, 2.0), DVec3::X), 3.1));
    assert!(!scene.occluded(&Ray::new(DVec3::new(0.0, 0.0, 2.0), DVec3::X), 2.9));
    let statistics = scene.statistics();
    assert_eq!((statistics.groups, statistics.instances, statistics.surfaces["sphere"]), (2, 2, 1));
}

#[test]
fn every_instance_of_an_emissive_shape_is_a_light() {
    let shapes = [shining(unit_sphere()), ShapeDescription::disk(3.0)];
    let builder = SceneBuilder::new().group("lamp", |group| group.shapes(shapes, grey()));
    let place = |builder: SceneBuilder, x| builder.instance("lamp", translate(x, 0.0, 0.0));
    let scene = resolve([-10.0, 10.0].into_iter().fold(builder, place));
    assert_eq!(scene.lights().len(), 2);
    for (x, light) in [(-10.0, LightId(0)), (10.0, LightId(1))] {
        let hit = scene.intersect(&Ray::new(DVec3::new(x, 0.0, 5.0), -DVec3::Z), f64::INFINITY).unwrap();
        assert_eq!(hit.light(), Some(light));
        assert_eq!(scene.emitted(&hit, hit.wo).max_component(), 2.0);
        let beside =
            scene.intersect(&Ray::new(DVec3::new(x + 2.0, 0.0, 5.0), -DVec3::Z), f64::INFINITY).unwrap();
        assert_eq!(beside.light(), None);
    }
}

/// The middles of the fields of a grid.
fn grid(n: u32) -> impl Iterator<Item = DVec2> {
    (0..n * n).map(move |i| (DVec2::new(f64::from(i % n), f64::from(i / n)) + 0.5) / f64::from(n))
}

/// Mean of 1 / pdf over a grid of samples: the solid angle that the light fills.
fn solid_angle(scene: &Scene, from: &Interaction, n: u32) -> f64 {
    let mut sum = 0.0;
    for xi in grid(n) {
        if let Some(sample) = scene.sample_light(LightId(0), from, xi) {
            assert!((sample.wi.length() - 1.0).abs() < 1e-12);
            sum += 1.0 / sample.pdf.0;
            check_sample_against_hit(scene, from, &sample);
        }
    }
    sum / f64::from(n * n)
}

/// The ray towards the sample meets the light, with the density that was stated, and nothing before it.
fn check_sample_against_hit(scene: &Scene, from: &Interaction, sample: &glanz_scene::LightSample) {
    assert!(!scene.occluded(&sample.shadow, sample.t_max), "{sample:?}");
    // At the rim a ray within rounding may pass by.
    if let Some(hit) = scene.intersect(&from.spawn(sample.wi), f64::INFINITY) {
        let pdf = scene.light_pdf(LightId(0), &from.light_sample_context(), &hit);
        assert!((pdf.0 / sample.pdf.0 - 1.0).abs() < 1e-5, "{pdf:?} {sample:?}");
        if let (Some(of_hit), Some(of_sample)) = (hit.area_pdf(), sample.area_pdf) {
            assert!((of_hit.0 / of_sample.0 - 1.0).abs() < 1e-5, "{of_hit:?} {sample:?}");
        }
    }
}

#[test]
fn light_samples_fill_the_solid_angle_of_the_light() {
    // The observer at the origin is seen from below, the light is behind it at z = 4: light samples ignore cosines.
    let h: f64 = 4.0;
    let down = translate(0.0, 0.0, h) * DMat4::from_rotation_x(PI);
    let stretched = translate(0.0, 0.0, h) * DMat4::from_scale(DVec3::new(1.0, 1.0, 2.0));
    let of_cone = |sin: f64| TAU * (1.0 - (1.0 - sin * sin).sqrt());
    // An ellipsoid with half axes 1, 1, 2 on the axis seen from distance 4: shrink z by 2; a sphere of radius 1 at 2,
    // whose cone has tan = 1 / sqrt(3) there and 1 / (2 sqrt 3) here.
    let tan: f64 = 1.0 / (2.0 * 3.0_f64.sqrt());
    let of_ellipsoid = of_cone(tan / (1.0 + tan * tan).sqrt());
    let square_solid_angle = 4.0 * (0.25 / (h * (h * h + 0.5).sqrt())).atan();
    let of_disk = |r: f64| TAU * (1.0 - h / (h * h + r * r).sqrt());
    for (name, light, expected, tolerance) in [
        ("sphere", unit_sphere().translated([0.0, 0.0, h]), of_cone(1.0 / h), 1e-12),
        ("ellipsoid", unit_sphere().transformed(stretched), of_ellipsoid, 0.02),
        ("disk", ShapeDescription::disk(1.5).transformed(down), of_disk(1.5), 1e-3),
        ("square", square().transformed(down), square_solid_angle, 1e-3),
    ] {
        let scene = resolve(with_shapes([ShapeDescription::disk(0.1), shining(light)]));
        let from = observer(&scene);
        let found = solid_angle(&scene, &from, 128);
        assert!((found / expected - 1.0).abs() < tolerance, "{name}: {found} instead of {expected}");
    }
}

#[test]
fn flat_lights_are_sampled_by_solid_angle_from_near() {
    // Squares of side 2 parallel to the observer, at half their height and less.
    for h in [0.5, 0.01_f64] {
        let down = translate(0.0, 0.0, h) * DMat4::from_rotation_x(PI);
        let parallelogram =
            ShapeDescription::parallelogram([-1.0, -1.0, 0.0], DVec3::X * 2.0, DVec3::Y * 2.0);
        let mesh = square().scaled([2.0, 2.0, 1.0]);
        let cuboid = ShapeDescription::cuboid([-1.0, -1.0, h], [1.0, 1.0, 3.0]);
        // Its sampling by area is not uniform.
        let stretched = translate(0.0, 0.0, h) * DMat4::from_scale(DVec3::new(2.0, 2.0, 5.0));
        let mirrored = translate(0.0, 0.0, h) * DMat4::from_scale(DVec3::new(2.0, 2.0, -1.0));
        let unit_cuboid = ShapeDescription::cuboid([-0.5, -0.5, 0.0], [0.5, 0.5, 1.0]);
        let solid_angle_of_square = 4.0 * (1.0 / (h * (h * h + 2.0).sqrt())).atan();
        // Howell's configuration factor C-11 of a corner, times pi, four times.
        let slant = (h * h + 1.0).sqrt();
        let irradiance = 4.0 / slant * (1.0 / slant).atan();
        for (name, light) in [
            ("parallelogram", parallelogram.transformed(down)),
            ("mesh", mesh.transformed(down)),
            ("cuboid", cuboid),
            ("stretched cuboid", unit_cuboid.transformed(stretched)),
            ("mirrored mesh", square().transformed(mirrored)),
        ] {
            let scene = resolve(with_shapes([ShapeDescription::disk(1e-3), shining(light)]));
            let from = observer(&scene);
            let found = solid_angle(&scene, &from, 64);
            assert!((found / solid_angle_of_square - 1.0).abs() < 1e-9, "{name}, {h}: {found}");
            let cosines = grid(64).filter_map(|xi| {
                let sample = scene.sample_light(LightId(0), &from, xi)?;
                Some(sample.wi.z.abs() / sample.pdf.0)
            });
            let found = cosines.sum::<f64>() / 4096.0;
            assert!((found / irradiance - 1.0).abs() < 1e-3, "{name}, {h}: {found} {irradiance}");
        }
    }
}

#[test]
fn sphere_light_around_the_observer_fills_every_direction() {
    let light = shining(unit_sphere().scaled([2.0; 3]).reversed());
    let scene = resolve(with_shapes([ShapeDescription::disk(0.1), light]));
    let ray = Ray::new(DVec3::new(0.0, 0.0, -1.0), DVec3::Z);
    let from = scene.intersect(&ray, f64::INFINITY).unwrap();
    let found = solid_angle(&scene, &from, 64);
    assert!((found / (2.0 * TAU) - 1.0).abs() < 1e-3, "{found}");
}

#[test]
fn power_replaces_the_magnitude_of_the_radiance() {
    let emission = EmissionDescription { power: Some(EmissionPower::Watts(90.0)), ..[2.0; 3].into() };
    let scene = resolve(with_shapes([ShapeDescription::disk(1.0).scaled([3.0; 3]).emitting(emission)]));
    let Light::Area(light) = &scene.lights()[0] else { panic!("not an area light") };
    // Power = pi L A, A = pi 3^2.
    let hit = scene.intersect(&Ray::new(DVec3::new(1.0, 1.0, 5.0), -DVec3::Z), f64::INFINITY).unwrap();
    let radiance = scene.emitted(&hit, hit.wo).luminance(&Wavelengths::default());
    let back = scene.intersect(&Ray::new(DVec3::new(1.0, 1.0, -5.0), DVec3::Z), f64::INFINITY).unwrap();
    assert!((f64::from(radiance) / (90.0 / (PI * PI * 9.0)) - 1.0).abs() < 1e-3, "{radiance}");
    assert!((light.area().unwrap() / (PI * 9.0) - 1.0).abs() < 1e-3);
    assert!(scene.emitted(&back, back.wo).is_black());
}

#[test]
fn mirrored_meshes_keep_their_outside_outside() {
    for (scale, reversed) in [(1.0, false), (-1.0, false), (1.0, true), (-1.0, true)] {
        let square = square().scaled([scale, 1.0, 1.0]);
        let scene = resolve(with_shapes([if reversed { square.reversed() } else { square }]));
        let hit = scene.intersect(&Ray::new(DVec3::new(0.1, 0.2, 1.0), -DVec3::Z), f64::INFINITY).unwrap();
        let expected = if reversed { -DVec3::Z } else { DVec3::Z };
        assert_eq!(hit.point.normal, expected, "scale {scale}, reversed {reversed}");
    }
}

#[test]
fn small_meshes_keep_number_material_and_side_when_joined() {
    let mut builder =
        SceneBuilder::new().material("grey", grey()).material("black", MaterialKind::diffuse(0.0));
    for i in 0..6 {
        // A light among them keeps its own number.
        if i == 3 {
            builder = builder.shape(shining(square()).translated([6.0, 2.0, 0.0]), "grey");
        }
        let square = square().translated([2.0 * f64::from(i), 0.0, 0.0]);
        builder = if i % 2 == 1 {
            builder.shape(square.reversed(), "black")
        } else {
            builder.shape(square, "grey")
        };
    }
    let scene = resolve(builder);
    assert_eq!(scene.statistics().surfaces["trianglemesh"], 7);
    for i in 0..6_u32 {
        let ray = Ray::new(DVec3::new(2.0 * f64::from(i) + 0.25, 0.125, 1.0), -DVec3::Z);
        let hit = scene.intersect(&ray, f64::INFINITY).unwrap();
        assert_eq!(hit.id, if i < 3 { i } else { i + 1 });
        assert_eq!(hit.point.normal.z, if i % 2 == 1 { -1.0 } else { 1.0 });
        let bsdf = hit.bsdf(&scene, &Wavelengths::default()).unwrap();
        assert_eq!(bsdf.albedo(DVec3::Z).is_black(), i % 2 == 1);
        assert_eq!(hit.light(), None);
    }
    let ray = Ray::new(DVec3::new(6.0, 2.0, 1.0), -DVec3::Z);
    let hit = scene.intersect(&ray, f64::INFINITY).unwrap();
    assert_eq!((hit.id, hit.light()), (3, Some(LightId(0))));
    let from = scene.intersect(&Ray::new(DVec3::new(0.25, 0.125, 1.0), -DVec3::Z), f64::INFINITY).unwrap();
    assert!(scene.light_pdf(LightId(0), &from.light_sample_context(), &hit).0 >= 0.0);
}

#[test]
fn infinite_plane_is_hit_beside_bounded_shapes() {
    let plane = ShapeDescription::plane().translated([0.0, 0.0, -1.0]);
    let scene = resolve(with_shapes([unit_sphere(), plane]));
    let far = scene.intersect(&Ray::new(DVec3::new(1e6, 0.0, 9.0), -DVec3::Z), f64::INFINITY).unwrap();
    assert_eq!((far.t, far.id), (10.0, 1));
    let near = scene.intersect(&Ray::new(DVec3::new(0.0, 0.0, 9.0), -DVec3::Z), f64::INFINITY).unwrap();
    assert_eq!((near.t, near.id), (8.0, 0));
    assert!(scene.bounds().is_finite());
}

#[test]
fn infinite_light_samples_follow_the_cosine_on_the_side_of_the_viewer() {
    let light = LightDescription { scale: 3.0, ..LightDescription::infinite(1.0) };
    let scene = resolve(with_shapes([ShapeDescription::disk(1.0)]).light(light));
    let from = observer(&scene);
    let sample = scene.sample_light(scene.infinite_lights()[0], &from, DVec2::new(0.3, 0.6)).unwrap();
    assert!(sample.wi.z < 0.0);
    assert!((sample.pdf.0 - -sample.wi.z / PI).abs() < 1e-12);
    assert!((sample.radiance.luminance(&Wavelengths::default()) - 3.0).abs() < 0.01);
    assert!(
        (scene.environment_radiance(&sample.shadow, &Wavelengths::Rgb).max_component()
            / sample.radiance.max_component()
            - 1.0)
            .abs()
            < 1e-6
    );
}

#[test]
fn infinite_light_samples_are_uniform_in_media() {
    let scene = resolve(with_shapes([ShapeDescription::disk(1.0)]).light(LightDescription::infinite(1.0)));
    let (from, light) = (Interaction::in_medium(DVec3::ONE, 1.0, DVec3::Z), scene.infinite_lights()[0]);
    let (side, mut mean, mut squares) = (16, DVec3::ZERO, DVec3::ZERO);
    for i in 0..side * side {
        let xi = (DVec2::new(f64::from(i % side), f64::from(i / side)) + 0.5) / f64::from(side);
        let sample = scene.sample_light(light, &from, xi).unwrap();
        let pdf = scene.infinite_pdf(light, &from.light_sample_context(), sample.wi);
        assert!(sample.pdf == pdf && (pdf.0 * 4.0 * PI - 1.0).abs() < 1e-12, "{pdf:?}");
        mean += sample.wi / f64::from(side * side);
        squares += sample.wi * sample.wi / f64::from(side * side);
    }
    assert!(mean.length() < 1e-9 && squares.abs_diff_eq(DVec3::splat(1.0 / 3.0), 2e-3), "{mean} {squares}");
}

#[test]
fn faults_are_reported_with_their_location() {
    let singular = error(with_shapes([located(unit_sphere().transformed(DMat4::ZERO))]));
    assert_eq!(singular.location, Some(HERE));
    assert!(matches!(singular.kind, SceneErrorKind::Transform { what: "shape", .. }));

    let mut no_material = with_shapes([unit_sphere()]).describe().unwrap();
    no_material.materials.clear();
    assert!(matches!(error(no_material.into()).kind, SceneErrorKind::Reference { .. }));

    let negative = GeometryDescription::Sphere { radius: -1.0, z: [-1.0, 1.0], phi_max: TAU };
    let negative = error(with_shapes([negative.into()]));
    assert!(matches!(negative.kind, SceneErrorKind::Surface(_)), "{negative}");

    let huge = error(with_shapes([unit_sphere().scaled([1e31; 3])]));
    assert!(matches!(huge.kind, SceneErrorKind::Range { .. }));

    let mut deep = SceneBuilder::new().group("0", |group| group.shape(unit_sphere(), grey()));
    for level in 1..20 {
        let inner = (level - 1).to_string();
        deep = deep.group(level.to_string(), |group| group.instance(&inner, DMat4::IDENTITY));
    }
    assert!(matches!(error(deep).kind, SceneErrorKind::Nesting(_)));

    // 512 copies of the group before on each of 7 levels: 2^63 surfaces.
    let mut many = SceneBuilder::new().group("0", |group| group.shape(unit_sphere(), grey()));
    for level in 1..8 {
        let inner = (level - 1).to_string();
        many = many.group(level.to_string(), |group| {
            (0..512).fold(group, |group, _| group.instance(&inner, DMat4::IDENTITY))
        });
    }
    assert!(matches!(error(many).kind, SceneErrorKind::TooManyCopies));
}

#[test]
fn degenerate_triangles_are_left_out_with_a_warning() {
    let mut square = located(square());
    if let GeometryDescription::Triangles { indices, .. } = &mut square.geometry {
        indices.push([1, 1, 2]);
    }
    let (scene, warnings) = with_shapes([square]).resolve().unwrap();
    assert_eq!(scene.statistics().triangles, 2);
    assert_eq!(warnings.len(), 1);
    assert_eq!(warnings[0].location, Some(HERE));
}

#[test]
fn patches_without_area_are_counted_in_a_warning() {
    let patch = |x: f64, height: f64| {
        [[0.0, 0.0], [0.0, height], [1.0, 0.0], [1.0, height]].map(|[u, y]| [x + u, y, 0.0, 1.0]).to_vec()
    };
    let patches = |heights: [f64; 3]| {
        let patches = [0.0, 1.0, 2.0].into_iter().zip(heights).map(|(x, height)| patch(x, height)).collect();
        let patches = BezierPatchesDescription { degree_u: 1, degree_v: 1, patches };
        located(GeometryDescription::BezierPatches(patches).into())
    };
    let (_, warnings) = with_shapes([patches([1.0, 0.0, 1.0])]).resolve().unwrap();
    assert_eq!(warnings.len(), 1);
    assert_eq!(warnings[0].location, Some(HERE));
    assert_eq!(warnings[0].message, "1 of 3 patches has parts without area, which no ray meets");
    assert!(with_shapes([patches([1.0; 3])]).resolve().unwrap().1.is_empty());
}

#[test]
fn spectra_outside_the_gamut_are_clipped_and_negative_light_is_refused() {
    let infinite = |emission: SpectralDistribution, scale: f32| {
        let light = LightDescription { scale, location: Some(HERE), ..LightDescription::infinite(emission) };
        SceneBuilder::new().light(light)
    };
    let ember = SpectralDistribution::try_blackbody(1200.0, 1.0).unwrap();
    let laser = SpectralDistribution::try_sampled(vec![(500.0, 0.0), (505.0, 9.0), (510.0, 0.0)]).unwrap();
    for (spectrum, negative) in [(&ember, 2), (&laser, 0)] {
        let colour = spectrum.radiance(&Wavelengths::Rgb).to_rgb(&Wavelengths::Rgb);
        assert!(colour[negative] < 0.0);
        let scene = resolve(infinite(spectrum.clone(), 2.0));
        let Some(Light::Infinite(light)) = scene.lights().first() else { unreachable!() };
        assert_eq!(light.radiance().to_rgb(&Wavelengths::Rgb), colour.map(|x| 2.0 * x.max(0.0)));
    }
    let dark = SpectralDistribution::try_sampled(vec![(500.0, -1.0)]).unwrap();
    let cold = SpectralDistribution::try_blackbody(3000.0, -1.0).unwrap();
    let colour = SpectralDistribution::Rgb([1.0, 1.0, -0.1]);
    for (emission, scale) in [(ember, -1.0), (dark, 1.0), (cold, 1.0), (colour, 1.0)] {
        let error = error(infinite(emission, scale));
        assert_eq!(error.location, Some(HERE));
        assert!(matches!(error.kind, SceneErrorKind::Range { .. }), "{error:?}");
    }
}

#[test]
fn thin_glass_lets_a_ray_straight_through() {
    let sine = 0.6;
    // A pane does not deflect the ray, a solid refracts it.
    let (pane, solid) =
        (MaterialKind::thin_dielectric(1.5, 1.0, 1.0), MaterialKind::dielectric(1.5, 1.0, 1.0));
    for (kind, sine_inside) in [(pane, sine), (solid, sine / 1.5)] {
        let scene = resolve(SceneBuilder::new().shape(ShapeDescription::disk(1.0), kind));
        let hit = observer(&scene);
        let bsdf = hit.bsdf(&scene, &Wavelengths::default()).unwrap();
        let wo = DVec3::new(sine, 0.0, 0.8);
        let branches = bsdf.delta_branches(wo, TransportMode::Radiance);
        let through = branches.iter().flatten().find(|branch| branch.wi.z < 0.0).unwrap();
        assert!((through.wi.x + sine_inside).abs() < 1e-6, "{:?}", through.wi);
    }
}

#[test]
fn with_camera_shares_the_scene() {
    let scene = resolve(with_shapes([shining(unit_sphere())]));
    let film = FilmDescription { resolution: [2, 2], ..FilmDescription::default() };
    let to_world = DMat4::from_translation(DVec3::new(0.0, 0.0, -5.0));
    let camera = CameraDescription { to_world, ..CameraDescription::default() };
    let other = scene.with_camera(Camera::try_new(&camera, &film).unwrap());
    let [here, there] = [&scene, &other].map(|s| s.camera().ray(DVec2::ONE, DVec2::ZERO).unwrap().ray);
    assert_eq!((here.origin, there.origin), (DVec3::ZERO, DVec3::new(0.0, 0.0, -5.0)));
    // The sphere about the origin ends 4 m in front of the other camera. Lists at the same address are one list.
    assert_eq!(other.intersect(&there, f64::INFINITY).map(|hit| hit.t), Some(4.0));
    assert!(
        std::ptr::eq(scene.lights(), other.lights()) && std::ptr::eq(scene.materials(), other.materials())
    );
    assert_eq!(scene.bounds(), other.bounds());
}
