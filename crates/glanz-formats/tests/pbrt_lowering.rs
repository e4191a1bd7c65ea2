//! What scenes say against what their descriptions hold; expected values follow from pbrt's documentation.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glanz_formats::{Loaded, Options, load_str};
use glanz_light::{SpectralDistribution, Wavelengths, named};
use glanz_math::{DMat4, DVec2, DVec3};
use glanz_scene::description::{
    CameraKind, FilterKind, FloatInput, GeometryDescription, LightKind, MaterialKind, SpectrumInput,
    SpotFalloff, TextureKind, TextureMapping,
};

fn read(text: &str) -> Loaded {
    load_str("test.pbrt", text, &Options::default()).unwrap_or_else(|d| panic!("{d}"))
}

/// Reads what must not even cause a warning.
fn read_clean(text: &str) -> Loaded {
    let loaded = read(text);
    assert!(loaded.diagnostics.is_empty(), "{}", loaded.diagnostics);
    loaded
}

fn shape(text: &str) -> GeometryDescription {
    let loaded = read_clean(&format!("WorldBegin Shape {text}"));
    loaded.description.world.shapes[0].geometry.clone()
}

fn material(text: &str) -> MaterialKind {
    read(&format!("WorldBegin Material {text}")).description.materials[0].kind.clone()
}

fn value(input: &SpectrumInput) -> [f32; 3] {
    match input {
        SpectrumInput::Value(s) => rgb(s),
        SpectrumInput::Texture(i) => panic!("texture {i}"),
    }
}

fn rgb(s: &SpectralDistribution) -> [f32; 3] {
    s.radiance(&Wavelengths::Rgb).to_rgb(&Wavelengths::Rgb)
}

fn close(a: f64, b: f64) {
    assert!((a - b).abs() <= 1e-6 * b.abs().max(1.0), "{a}, expected {b}");
}

#[test]
fn look_at_gives_the_camera_its_frame_in_the_world() {
    let text = "LookAt 1 2 -5  1 2 0  0 1 0 Camera \"perspective\" \"float fov\" 60";
    let camera = read_clean(text).description.camera;
    // Eye (1, 2, -5), looking along +z with y up: right is up x forward = +x, a pure translation.
    assert!(camera.to_world.abs_diff_eq(DMat4::from_translation(DVec3::new(1.0, 2.0, -5.0)), 1e-12));
    assert_eq!(camera.kind, CameraKind::Perspective { field_of_view: 60f64.to_radians() });
    assert_eq!((camera.lens_radius, camera.focal_distance), (0.0, 1e6));
}

#[test]
fn a_mirrored_camera_has_its_right_hand_on_the_other_side() {
    let text = "Scale -1 1 1 LookAt 0 0 -5  0 0 0  0 1 0 Camera \"perspective\"";
    let camera = read_clean(text).description.camera;
    let right = camera.to_world.transform_vector3(DVec3::X);
    assert!(right.abs_diff_eq(DVec3::NEG_X, 1e-12));
    assert!(camera.to_world.transform_vector3(DVec3::Z).abs_diff_eq(DVec3::Z, 1e-12));
    assert!(camera.to_world.transform_point3(DVec3::ZERO).abs_diff_eq(DVec3::new(0.0, 0.0, -5.0), 1e-12));
}

#[test]
fn transform_lists_columns_and_replaces_what_was() {
    let text = "Translate 9 9 9 Transform [1 0 0 0  0 1 0 0  0 0 -1 0  0 -1 6.8 1] Camera \"orthographic\"";
    let camera = read_clean(text).description.camera;
    // World to camera is (x, y - 1, 6.8 - z): the eye is at (0, 1, 6.8).
    assert!(camera.to_world.transform_point3(DVec3::ZERO).abs_diff_eq(DVec3::new(0.0, 1.0, 6.8), 1e-12));
    assert_eq!(camera.kind, CameraKind::Orthographic);
}

#[test]
fn half_a_field_of_view_and_windows_are_taken_over() {
    let text = "Camera \"perspective\" \"float halffov\" 45 \"float screenwindow\" [-2 2 -1 1] \
        \"float frameaspectratio\" 2 \"float lensradius\" .1 \"float focaldistance\" 7 \"float shutterclose\" 0";
    let camera = read_clean(text).description.camera;
    assert_eq!(camera.kind, CameraKind::Perspective { field_of_view: FRAC_PI_2 });
    assert_eq!(camera.screen_window, Some([-2.0, 2.0, -1.0, 1.0]));
    assert_eq!((camera.aspect, camera.lens_radius, camera.focal_distance), (Some(2.0), 0.1, 7.0));
}

#[test]
fn transformations_apply_from_the_last_to_the_first() {
    let text = "WorldBegin Translate 1 0 0 Rotate 90 0 0 1 Scale 2 2 2 Shape \"sphere\"";
    let to_parent = read_clean(text).description.world.shapes[0].to_parent;
    // (1, 0, 0) -> (2, 0, 0) -> (0, 2, 0) -> (1, 2, 0)
    assert!(to_parent.transform_point3(DVec3::X).abs_diff_eq(DVec3::new(1.0, 2.0, 0.0), 1e-12));
}

#[test]
fn coordinate_systems_bring_things_to_where_they_were_named() {
    let text = "LookAt 0 0 -5  0 0 0  0 1 0 Camera \"perspective\" WorldBegin \
        Translate 0 3 0 CoordinateSystem \"up\" \
        AttributeBegin CoordSysTransform \"camera\" Shape \"sphere\" AttributeEnd Shape \"sphere\" \
        TransformBegin Identity CoordSysTransform \"up\" Shape \"sphere\" CoordSysTransform \"world\" Shape \"sphere\" TransformEnd";
    let shapes = read_clean(text).description.world.shapes;
    let origins: Vec<DVec3> = shapes.iter().map(|s| s.to_parent.transform_point3(DVec3::ZERO)).collect();
    let up = DVec3::new(0.0, 3.0, 0.0);
    assert_eq!(origins, [DVec3::new(0.0, 0.0, -5.0), up, up, DVec3::ZERO]);
}

#[test]
fn silent_files_have_the_defaults_of_their_version() {
    let v3 = read_clean("Camera \"perspective\" WorldBegin WorldEnd").description;
    assert_eq!(v3.film.resolution, [640, 480]);
    assert_eq!((v3.filter.kind, v3.filter.radius), (FilterKind::Box, [0.5, 0.5]));
    let v4 = read_clean("Option \"integer seed\" 1 Camera \"perspective\" WorldBegin").description;
    assert_eq!(v4.film.resolution, [1280, 720]);
    assert_eq!((v4.filter.kind, v4.filter.radius), (FilterKind::Gaussian { sigma: 0.5 }, [1.5, 1.5]));
    for d in [v3, v4] {
        assert_eq!((d.sampler.name.as_str(), d.sampler.samples_per_pixel), ("sobol", 16));
        assert_eq!(d.camera.kind, CameraKind::Perspective { field_of_view: FRAC_PI_2 });
    }
}

#[test]
fn film_takes_size_name_and_cut() {
    let film = read_clean(
        "Film \"rgb\" \"integer xresolution\" 400 \"string filename\" \"a.exr\" \"integer pixelbounds\" [100 200 0 360]",
    )
    .description
    .film;
    assert_eq!((film.resolution, film.file_name.as_deref()), ([400, 720], Some("a.exr")));
    assert_eq!(film.crop, [0.25, 0.5, 0.0, 0.5]);
    let film = read_clean("Film \"image\" \"float cropwindow\" [.75 .25 0 1]").description.film;
    assert_eq!((film.resolution, film.crop), ([640, 480], [0.25, 0.75, 0.0, 1.0]));
}

#[test]
fn filters_of_both_versions_are_one() {
    for (text, kind, radius) in [
        (
            "\"gaussian\" \"float alpha\" 8 \"float xwidth\" 3",
            FilterKind::Gaussian { sigma: 0.25 },
            [3.0, 2.0],
        ),
        ("\"gaussian\" \"float xradius\" 3", FilterKind::Gaussian { sigma: 0.5 }, [3.0, 1.5]),
        ("\"triangle\"", FilterKind::Triangle, [2.0, 2.0]),
        ("\"mitchell\" \"float B\" 0 \"float C\" .5", FilterKind::Mitchell { b: 0.0, c: 0.5 }, [2.0, 2.0]),
        ("\"box\" \"float ywidth\" 1", FilterKind::Box, [0.5, 1.0]),
        ("\"cylinder\"", FilterKind::Cylinder, [0.5, 0.5]),
        ("\"pyramid\"", FilterKind::Pyramid, [1.0, 1.0]),
        ("\"cone\"", FilterKind::Cone, [1.0, 1.0]),
    ] {
        let filter = read_clean(&format!("PixelFilter {text}")).description.filter;
        assert_eq!((filter.kind, filter.radius), (kind, radius), "{text}");
    }
}

#[test]
fn samplers_and_integrators_have_the_names_of_the_tables() {
    for (text, name, count) in [
        ("\"halton\" \"integer pixelsamples\" 128", "sobol", 128),
        ("\"zsobol\" \"integer pixelsamples\" 3", "sobol", 3),
        ("\"random\"", "independent", 4),
        (
            "\"stratified\" \"integer xsamples\" 3 \"integer ysamples\" 5 \"bool jitter\" true",
            "stratified",
            15,
        ),
        ("\"stratified\" \"integer pixelsamples\" 64", "stratified", 64),
        ("\"regular\" \"integer xsamples\" 2 \"integer ysamples\" 2", "regular", 4),
        ("\"center\"", "center", 1),
    ] {
        let sampler = read_clean(&format!("Sampler {text}")).description.sampler;
        assert_eq!((sampler.name.as_str(), sampler.samples_per_pixel), (name, count), "{text}");
    }
    for (text, name, depth) in [
        ("Integrator \"path\"", "path", 5),
        ("Integrator \"whitted\" \"integer maxdepth\" 9", "whitted", 9),
        ("Integrator \"distributed\" \"integer branching\" 4", "distributed", 5),
        ("SurfaceIntegrator \"path\" \"integer maxdepth\" 0", "path", 0),
    ] {
        let integrator = read_clean(text).description.integrator;
        assert_eq!((integrator.name.as_str(), integrator.max_depth), (name, Some(depth)), "{text}");
    }
    assert_eq!(read("Integrator \"directlighting\"").description.integrator.name, "whitted");
    assert_eq!(read("Integrator \"bdpt\"").description.integrator.name, "path");
}

#[test]
fn quadrics_have_the_defaults_of_pbrt() {
    use GeometryDescription as G;
    assert!(matches!(
        shape("\"sphere\" \"float radius\" 2"),
        G::Sphere { radius: 2.0, z: [-2.0, 2.0], phi_max: TAU }
    ));
    assert!(matches!(shape("\"sphere\" \"float zmax\" -.5 \"float zmin\" .25 \"float phimax\" 90"),
        G::Sphere { radius: 1.0, z: [-0.5, 0.25], phi_max } if phi_max == FRAC_PI_2));
    assert!(matches!(shape("\"cylinder\""), G::Cylinder { radius: 1.0, z: [-1.0, 1.0], phi_max: TAU }));
    assert!(matches!(
        shape("\"cone\" \"float phimax\" 720"),
        G::Cone { radius: 1.0, height: 1.0, phi_max: TAU }
    ));
    assert!(matches!(shape("\"paraboloid\""), G::Paraboloid { radius: 1.0, z: [0.0, 1.0], phi_max: TAU }));
    assert!(matches!(
        shape("\"hyperboloid\""),
        G::Hyperboloid { p1: DVec3::ZERO, p2: DVec3::ONE, phi_max: TAU }
    ));
    assert!(matches!(
        shape("\"disk\" \"float innerradius\" .5"),
        G::Disk { height: 0.0, radius: 1.0, inner_radius: 0.5, phi_max: TAU }
    ));
}

#[test]
fn meshes_keep_points_corners_normals_and_coordinates() {
    let text = "\"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point3 P\" [0 0 0 1 0 0 1 1 0 0 1 0] \
        \"normal N\" [0 0 1 0 0 1 0 0 1 0 0 1] \"float st\" [0 0 1 0 1 1 0 1]";
    let GeometryDescription::Triangles { positions, indices, normals, uvs } = shape(text) else { panic!() };
    assert_eq!((positions.len(), positions[2]), (4, DVec3::new(1.0, 1.0, 0.0)));
    assert_eq!(indices, [[0, 1, 2], [0, 2, 3]]);
    assert_eq!((normals.unwrap()[3], uvs.unwrap()[1]), (DVec3::Z, DVec2::X));
    // Without indices three points are a triangle and four a bilinear patch.
    let GeometryDescription::Triangles { indices, .. } =
        shape("\"trianglemesh\" \"point P\" [0 0 0 1 0 0 0 1 0]")
    else {
        panic!()
    };
    assert_eq!(indices, [[0, 1, 2]]);
    let GeometryDescription::Bilinear { indices, .. } =
        shape("\"bilinearmesh\" \"point P\" [0 0 0 1 0 0 0 1 0 1 1 0]")
    else {
        panic!()
    };
    assert_eq!(indices, [[0, 1, 2, 3]]);
}

#[test]
fn shapes_beyond_pbrt_are_read() {
    use GeometryDescription as G;
    assert!(matches!(
        shape("\"torus\" \"float majorradius\" 3 \"float minorradius\" 1"),
        G::Torus { major_radius: 3.0, minor_radius: 1.0, phi_max: TAU }
    ));
    assert!(matches!(
        shape("\"twosheetedhyperboloid\" \"float a\" 2 \"float c\" 3"),
        G::TwoSheetedHyperboloid { a: 2.0, c: 3.0, z: [-6.0, 6.0], phi_max: TAU }
    ));
    assert!(
        matches!(shape("\"plane\""), G::Plane { x, y } if x == [f64::NEG_INFINITY, f64::INFINITY] && x == y)
    );
    assert!(matches!(shape("\"plane\" \"float x\" [-1 2]"), G::Plane { x: [-1.0, 2.0], .. }));
    assert!(matches!(shape("\"box\" \"vector3 size\" [2 4 6]"),
        G::Cuboid { min, max } if min == DVec3::new(-1.0, -2.0, -3.0) && max == -min));
    assert!(matches!(shape("\"box\" \"point3 min\" [0 5 0] \"point3 max\" [1 1 1]"),
        G::Cuboid { min, max } if min == DVec3::new(0.0, 1.0, 0.0) && max == DVec3::new(1.0, 5.0, 1.0)));
    let G::Polyhedron { half_spaces } = shape("\"polyhedron\" \"normal N\" [1 0 0 0 1 0] \"float d\" [2 3]")
    else {
        panic!()
    };
    assert_eq!(half_spaces, [(DVec3::X, 2.0), (DVec3::Y, 3.0)]);
    // x^2 y z - 2 = 0
    let text = "\"algebraic\" \"integer exponents\" [2 1 1 0 0 0] \"float coefficients\" [1 -2] \
        \"point3 clip\" [3 3 3 -3 -3 -3]";
    let G::Algebraic { terms, clip } = shape(text) else { panic!() };
    assert_eq!(terms, [([2, 1, 1], 1.0), ([0, 0, 0], -2.0)]);
    assert_eq!(clip, [DVec3::splat(-3.0), DVec3::splat(3.0)]);
}

#[test]
fn spot_lights_have_the_angles_and_falloff_of_their_version() {
    let text = |version: &str| {
        format!(
            "{version} WorldBegin LightSource \"spot\" \"rgb I\" [2 3 4] \"float coneangle\" 40 \"float conedeltaangle\" 10"
        )
    };
    for (version, expected) in
        [("Film \"image\"", SpotFalloff::Quartic), ("Film \"rgb\"", SpotFalloff::Smoothstep)]
    {
        let light = read_clean(&text(version)).description.lights.remove(0);
        let LightKind::Spot { from, to, cone_angle, inner_angle, falloff } = light.kind else { panic!() };
        assert_eq!((from, to, falloff), (DVec3::ZERO, DVec3::Z, expected));
        close(cone_angle, 40f64.to_radians());
        close(inner_angle, 30f64.to_radians());
        assert_eq!((light.emission, light.scale), (SpectralDistribution::Rgb([2.0, 3.0, 4.0]), 1.0));
    }
}

#[test]
fn black_bodies_shine_as_their_version_has_it() {
    let v3 = read_clean(
        "WorldBegin LightSource \"distant\" \"blackbody L\" [3000 1.5] \"rgb scale\" [2 2 2] WorldEnd",
    );
    let light = &v3.description.lights[0];
    assert_eq!(light.emission, SpectralDistribution::Blackbody { kelvin: 3000.0, scale: 1.5 });
    assert_eq!(light.scale, 2.0);
    let v4 =
        read_clean("Film \"rgb\" WorldBegin LightSource \"distant\" \"blackbody L\" 3000 \"float scale\" 2");
    let light = &v4.description.lights[0];
    close(f64::from(light.emission.luminance() * light.scale), 2.0);
    // The same for sampled spectra.
    let v4 = read_clean("Film \"rgb\" WorldBegin LightSource \"point\" \"spectrum I\" [400 3 700 9]");
    let light = &v4.description.lights[0];
    close(f64::from(light.emission.luminance() * light.scale), 1.0);
}

#[test]
fn power_and_illuminance_set_what_the_light_gives() {
    let light = |text: &str| {
        let loaded = read_clean(&format!("Film \"rgb\" WorldBegin LightSource {text}"));
        let light = loaded.description.lights[0].clone();
        f64::from(light.emission.luminance() * light.scale)
    };
    close(light("\"point\" \"rgb I\" [2 2 2] \"float power\" 100"), 100.0 / (4.0 * PI));
    close(light("\"point\" \"blackbody I\" 4000 \"float power\" 100 \"float scale\" 2"), 200.0 / (4.0 * PI));
    close(light("\"distant\" \"float illuminance\" 30"), 30.0);
    close(light("\"infinite\" \"float illuminance\" 30"), 30.0 / PI);
    // Cone of 60 degrees without a soft border: 2 pi (1 - 1/2) sr.
    let spot = light("\"spot\" \"float coneangle\" 60 \"float conedeltaangle\" 0 \"float power\" 10");
    close(spot, 10.0 / PI);
}

#[test]
fn coloured_scale_of_version_3_colours_the_light() {
    let loaded = read_clean("WorldBegin LightSource \"infinite\" \"rgb L\" [1 2 3] \"color scale\" [2 1 0]");
    assert_eq!(rgb(&loaded.description.lights[0].emission), [2.0, 2.0, 0.0]);
}

#[test]
fn area_lights_hold_for_the_shapes_of_their_block() {
    let text = "WorldBegin AttributeBegin AreaLightSource \"diffuse\" \"rgb L\" [4 4 4] \"bool twosided\" \"true\" \
        \"integer nsamples\" 8 Shape \"sphere\" AttributeEnd Shape \"sphere\"";
    let shapes = read_clean(text).description.world.shapes;
    let light = shapes[0].emission.as_ref().unwrap();
    assert_eq!(
        (rgb(&light.radiance), light.scale, light.two_sided, light.power),
        ([4.0; 3], 1.0, true, None)
    );
    assert!(shapes[1].emission.is_none());
    let text = "Film \"rgb\" WorldBegin AreaLightSource \"diffuse\" \"float power\" 60 \"float scale\" 2 Shape \"sphere\"";
    let shapes = read_clean(text).description.world.shapes;
    assert_eq!(shapes[0].emission.as_ref().unwrap().power, Some(120.0));
}

#[test]
fn materials_of_both_versions_are_lowered() {
    for text in ["\"matte\" \"rgb Kd\" [.1 .2 .3]", "\"diffuse\" \"rgb reflectance\" [.1 .2 .3]"] {
        let MaterialKind::Diffuse { reflectance } = material(text) else { panic!("{text}") };
        assert_eq!(value(&reflectance), [0.1, 0.2, 0.3]);
    }
    let MaterialKind::Mirror { reflectance } = material("\"mirror\"") else { panic!() };
    assert_eq!(value(&reflectance), [0.9; 3]);
    for (text, index) in [
        ("\"glass\"", 1.5),
        ("\"glass\" \"float index\" 1.3", 1.3),
        ("\"dielectric\" \"float eta\" 1.8", 1.8),
        // Linear between 500 and 700 nm: at helium's 587.5618 nm it is 1.5 + 0.1 * 87.5618 / 200.
        ("\"dielectric\" \"spectrum eta\" [500 1.5 700 1.6]", 1.543_780_9),
    ] {
        let MaterialKind::Dielectric { eta: FloatInput::Value(eta), thin: false, .. } = material(text) else {
            panic!("{text}")
        };
        close(f64::from(eta), index);
    }
    assert!(matches!(material("\"interface\""), MaterialKind::Interface));
    assert!(matches!(material("\"\""), MaterialKind::Interface));
    let MaterialKind::Phong { exponent: FloatInput::Value(n), .. } =
        material("\"phong\" \"float exponent\" 50")
    else {
        panic!()
    };
    assert_eq!(n, 50.0);
}

#[test]
fn glass_by_name_has_the_index_of_its_catalogue() {
    // n_d of Schott's data sheets.
    for (name, index) in [("glass-BK7", 1.5168), ("glass-SF11", 1.784_72)] {
        let text = format!("\"dielectric\" \"spectrum eta\" \"{name}\"");
        let MaterialKind::Dielectric { eta: FloatInput::Value(eta), .. } = material(&text) else { panic!() };
        assert!((f64::from(eta) - index).abs() < 1e-4, "{name}: {eta}");
    }
}

#[test]
fn metals_by_name_keep_their_spectrum_and_copper_is_the_default() {
    for (text, metal) in [
        ("\"conductor\"", "Cu"),
        ("\"metal\" \"float roughness\" 0", "Cu"),
        ("\"conductor\" \"spectrum eta\" \"metal-CuZn-eta\" \"spectrum k\" \"metal-CuZn-k\"", "CuZn"),
    ] {
        let MaterialKind::Conductor { eta, k } = material(text) else { panic!("{text}") };
        for (input, quantity) in [(eta, "eta"), (k, "k")] {
            let SpectrumInput::Value(spectrum) = input else { panic!("{text}") };
            assert!(matches!(spectrum, SpectralDistribution::Sampled(_)));
            assert_eq!(Some(spectrum), named::spectrum(&format!("metal-{metal}-{quantity}")));
        }
    }
}

#[test]
fn a_name_that_is_not_built_in_is_an_error_with_the_nearest_ones() {
    for (name, help) in [
        ("metal-Ag-etta", "did you mean the built-in \"metal-Ag-eta\"?"),
        ("metal-Au", "did you mean one of the built-in \"metal-Au-eta\", \"metal-Au-k\"?"),
    ] {
        let text = format!("WorldBegin Material \"conductor\" \"spectrum eta\" \"{name}\"");
        let errors = load_str("test.pbrt", &text, &Options::default()).unwrap_err();
        let found: Vec<_> = errors.iter().map(|d| (d.kind, d.help.as_deref())).collect();
        assert_eq!(found, [("missing-file", Some(help))]);
    }
}

#[test]
fn thin_glass_is_a_pane() {
    let text =
        "Film \"rgb\" WorldBegin Material \"thindielectric\" \"float eta\" 1.3 Material \"thindielectric\"";
    let materials = read_clean(text).description.materials;
    for (material, index) in materials.iter().zip([1.3, 1.5]) {
        let MaterialKind::Dielectric { eta: FloatInput::Value(eta), thin: true, .. } = material.kind else {
            panic!("{material:?}")
        };
        assert_eq!(eta, index);
    }
}

#[test]
fn metal_of_a_reflectance_reflects_that_much_straight_back() {
    let MaterialKind::Conductor { eta, k } = material("\"conductor\" \"rgb reflectance\" [.2 .5 .9]") else {
        panic!()
    };
    for (lane, r) in [0.2, 0.5, 0.9].into_iter().enumerate() {
        let (n, k) = (f64::from(value(&eta)[lane]), f64::from(value(&k)[lane]));
        // Fresnel at normal incidence: ((n - 1)^2 + k^2) / ((n + 1)^2 + k^2).
        close(((n - 1.0).powi(2) + k * k) / ((n + 1.0).powi(2) + k * k), r);
    }
}

#[test]
fn stand_ins_are_said_and_strict_refuses_them() {
    for (text, kind) in [
        ("Material \"plastic\"", "stand-in-material"),
        ("Material \"conductor\" \"float roughness\" .1", "stand-in-material"),
        ("Material \"matte\" \"float sigma\" 20", "stand-in-material"),
        ("Material \"uber\"", "stand-in-material"),
        ("Material \"hair\"", "stand-in-material"),
        ("Material \"fluff\"", "stand-in-material"),
        ("Shape \"curve\"", "stand-in-shape"),
        (
            "Shape \"loopsubdiv\" \"point P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 2]",
            "stand-in-shape",
        ),
        ("Shape \"sphere\" \"float alpha\" 0", "stand-in-alpha"),
        ("LightSource \"projection\"", "stand-in-light"),
        ("LightSource \"infinite\" \"string mapname\" \"no.exr\"", "missing-file"),
        ("Texture \"t\" \"color\" \"marble\"", "stand-in-texture"),
        ("Texture \"t\" \"color\" \"imagemap\" \"string filename\" \"no.png\"", "missing-file"),
        ("MakeNamedMedium \"fog\" \"string type\" \"homogeneous\"", "stand-in-medium"),
        ("ActiveTransform EndTime Translate 0 0 1 ActiveTransform All", "stand-in-motion"),
    ] {
        let text = format!("WorldBegin {text}");
        let loaded = read(&text);
        let kinds: Vec<_> = loaded.diagnostics.iter().map(|d| d.kind).collect();
        assert_eq!(kinds, [kind], "{text}: {}", loaded.diagnostics);
        let strict = Options { strict: true, ..Options::default() };
        let errors = load_str("test.pbrt", &text, &strict).unwrap_err();
        assert!(errors.has_errors() && errors.iter().all(|d| d.kind == kind), "{text}");
    }
}

#[test]
fn plastic_becomes_a_phong_lobe_of_equal_width() {
    let text = "\"plastic\" \"rgb Kd\" [.5 .5 .5] \"rgb Ks\" [.5 .5 .5] \"float roughness\" .1 \"bool remaproughness\" \"false\"";
    let MaterialKind::Phong { ambient, diffuse, specular, exponent: FloatInput::Value(n) } = material(text)
    else {
        panic!()
    };
    // alpha = 0.1: (2 / 0.01 - 2) / 4; the surface of index 1.5 reflects 4 %.
    close(f64::from(n), 49.5);
    assert_eq!(value(&diffuse), [0.5; 3]);
    close(f64::from(value(&specular)[0]), 0.02);
    // Light of all directions reaches the base as well.
    assert_eq!(value(&ambient), [0.5; 3]);
    let text = "\"substrate\" \"rgb Kd\" [.4 .6 .8] \"rgb Ks\" [.5 .5 .5]";
    let MaterialKind::Phong { ambient, diffuse, .. } = material(text) else { panic!() };
    assert_eq!((value(&ambient), value(&diffuse)), ([0.2, 0.3, 0.4], [0.2, 0.3, 0.4]));
}

#[test]
fn named_materials_may_come_after_their_use() {
    let text = "Film \"rgb\" WorldBegin NamedMaterial \"later\" Shape \"sphere\" \
        MakeNamedMaterial \"later\" \"string type\" \"interface\" NamedMaterial \"later\" Shape \"sphere\"";
    let d = read_clean(text).description;
    assert_eq!(d.world.shapes[0].material, d.world.shapes[1].material);
    assert!(matches!(d.materials[d.world.shapes[0].material].kind, MaterialKind::Interface));
}

#[test]
fn a_material_made_again_leaves_earlier_shapes_alone() {
    let text = "WorldBegin MakeNamedMaterial \"a\" \"string type\" \"mirror\" NamedMaterial \"a\" Shape \"sphere\" \
        MakeNamedMaterial \"a\" \"string type\" \"matte\" NamedMaterial \"a\" Shape \"sphere\"";
    let d = read_clean(text).description;
    let kind = |i: usize| &d.materials[d.world.shapes[i].material].kind;
    assert!(matches!(kind(0), MaterialKind::Mirror { .. }));
    assert!(matches!(kind(1), MaterialKind::Diffuse { .. }));
}

#[test]
fn textures_are_found_by_name_and_mapped() {
    let text = "WorldBegin Translate 1 0 0 Texture \"c\" \"color\" \"checkerboard\" \"string mapping\" \"planar\" \
        \"vector v1\" [2 0 0] \"vector v2\" [0 0 3] \"float udelta\" .5 \"rgb tex1\" [1 0 0] \
        Texture \"s\" \"color\" \"scale\" \"texture tex1\" \"c\" \"color tex2\" [.5 .5 .5] \
        Texture \"m\" \"color\" \"mix\" \"texture tex1\" \"s\" \"float amount\" .25 \
        Material \"matte\" \"texture Kd\" \"m\"";
    let d = read_clean(text).description;
    assert!(matches!(d.materials[0].kind, MaterialKind::Diffuse { reflectance: SpectrumInput::Texture(2) }));
    let TextureKind::Checkerboard { even, odd, mapping } = &d.textures[0].kind else { panic!() };
    assert_eq!((value(even), value(odd)), ([1.0, 0.0, 0.0], [0.0; 3]));
    let TextureMapping::Planar { v1, v2, offset, to_texture } = mapping else { panic!() };
    assert_eq!((*v1, *v2, *offset), (2.0 * DVec3::X, 3.0 * DVec3::Z, DVec2::new(0.5, 0.0)));
    assert_eq!(to_texture.transform_point3(DVec3::X), DVec3::ZERO);
    assert!(matches!(&d.textures[1].kind, TextureKind::Scale(SpectrumInput::Texture(0), _)));
    assert!(matches!(
        &d.textures[2].kind,
        TextureKind::Mix { a: SpectrumInput::Texture(1), amount: FloatInput::Value(0.25), .. }
    ));
}

#[test]
fn textures_of_numbers_and_colours_may_share_a_name() {
    let text = "WorldBegin Texture \"t\" \"float\" \"constant\" \"float value\" 2 Texture \"t\" \"color\" \"constant\" \
        Material \"phong\" \"texture exponent\" \"t\" \"texture Kd\" \"t\"";
    let d = read_clean(text).description;
    let MaterialKind::Phong { diffuse, exponent, .. } = &d.materials[0].kind else { panic!() };
    assert!(matches!(diffuse, SpectrumInput::Texture(1)));
    assert!(matches!(exponent, FloatInput::Texture(0)));
}

#[test]
fn instances_are_placed_by_their_own_transformation_after_the_shapes() {
    let text = "WorldBegin ObjectBegin \"ball\" Scale 2 2 2 Shape \"sphere\" ObjectEnd Translate 1 0 0 \
        ObjectInstance \"ball\" ObjectInstance \"ball\"";
    let d = read_clean(text).description;
    assert_eq!((d.groups.len(), d.groups[0].name.as_str(), d.world.shapes.len()), (1, "ball", 0));
    assert_eq!(d.groups[0].shapes[0].to_parent, DMat4::from_scale(DVec3::splat(2.0)));
    assert_eq!(d.world.instances.len(), 2);
    assert_eq!(d.world.instances[1].to_parent, DMat4::from_translation(DVec3::X));
    assert_eq!(d.world.instances[1].group, 0);
}

#[test]
fn lights_in_objects_are_kept_but_not_in_objects_of_objects() {
    let object = "WorldBegin ObjectBegin \"lamp\" AreaLightSource \"diffuse\" Shape \"sphere\" ObjectEnd";
    let d = read_clean(&format!("{object} ObjectInstance \"lamp\"")).description;
    assert!(d.groups[0].shapes[0].emission.is_some());
    let text = format!("{object} ObjectBegin \"street\" ObjectInstance \"lamp\" ObjectEnd");
    let errors = load_str("test.pbrt", &text, &Options::default()).unwrap_err();
    assert_eq!(errors.iter().map(|d| d.kind).collect::<Vec<_>>(), ["instance-light"]);
}

#[test]
fn light_outside_the_gamut_keeps_its_spectrum_and_takes_none_away_from_colours() {
    for version in ["Film \"image\"", "Film \"rgb\""] {
        let text = format!("{version} WorldBegin LightSource \"point\" \"blackbody I\" 1200");
        let light = read_clean(&text).description.lights.remove(0);
        assert_eq!(light.emission, SpectralDistribution::Blackbody { kelvin: 1200.0, scale: 1.0 });
        assert!(rgb(&light.emission)[2] < 0.0);
        if version.contains("rgb") {
            close(f64::from(light.emission.luminance() * light.scale), 1.0);
        }
    }
    let text = "WorldBegin LightSource \"point\" \"blackbody I\" 1200 \"rgb scale\" [1 2 3]";
    let light = read_clean(text).description.lights.remove(0);
    let [r, g, b] = rgb(&light.emission);
    assert!(r > g && g > 0.0 && b == 0.0);
}

#[test]
fn attributes_give_defaults_to_what_comes_in_their_block() {
    let text = "Film \"rgb\" WorldBegin AttributeBegin Attribute \"shape\" \"float radius\" 2 Shape \"sphere\" \
        Shape \"sphere\" \"float radius\" 3 AttributeEnd Shape \"sphere\"";
    let shapes = read_clean(text).description.world.shapes;
    let radius = |i: usize| match shapes[i].geometry {
        GeometryDescription::Sphere { radius, .. } => radius,
        _ => panic!(),
    };
    assert_eq!([radius(0), radius(1), radius(2)], [2.0, 3.0, 1.0]);
}

#[test]
fn normals_are_turned_by_reverse_orientation_alone() {
    let text = "WorldBegin Scale -1 1 1 Shape \"sphere\" ReverseOrientation Shape \"sphere\" ReverseOrientation Shape \"sphere\"";
    let shapes = read_clean(text).description.world.shapes;
    assert_eq!(shapes.iter().map(|s| s.reverse_orientation).collect::<Vec<_>>(), [false, true, false]);
}

#[test]
fn a_part_of_a_world_is_read_without_world_begin() {
    let loaded = read("AttributeBegin Translate 1 0 0 Shape \"sphere\" AttributeEnd");
    assert_eq!(loaded.description.world.shapes.len(), 1);
    assert_eq!(loaded.diagnostics.iter().map(|d| d.kind).collect::<Vec<_>>(), ["no-world"]);
}

#[test]
fn locations_name_the_directive() {
    let d = read_clean("WorldBegin\n  Shape \"sphere\"").description;
    let location = d.world.shapes[0].location.unwrap();
    assert_eq!((location.line, location.column, location.file.0), (2, 3, 0));
    assert_eq!(d.files, ["test.pbrt"]);
}

#[test]
fn xyz_and_wide_gamut_colours_become_rec709() {
    // The white of D65 is (1, 1, 1).
    let MaterialKind::Diffuse { reflectance } = material("\"matte\" \"xyz Kd\" [.475 .5 .5445]") else {
        panic!()
    };
    for x in value(&reflectance) {
        assert!((x - 0.5).abs() < 1e-3, "{x}");
    }
    let text = "WorldBegin ColorSpace \"rec2020\" Material \"diffuse\" \"rgb reflectance\" [.25 .25 .25]";
    let MaterialKind::Diffuse { reflectance } = read_clean(text).description.materials[0].kind.clone() else {
        panic!()
    };
    for x in value(&reflectance) {
        assert!((x - 0.25).abs() < 1e-6, "{x}");
    }
}
