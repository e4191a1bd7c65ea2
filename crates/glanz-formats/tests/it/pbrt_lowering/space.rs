//! Camera, transformations and instances.

use super::*;

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
fn transform_lists_columns_and_replaces_the_current_transformation() {
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
fn cameras_of_all_kinds_have_the_parameters_of_pbrt() {
    let kind = |text: &str| read_clean(&format!("Camera {text}")).description.camera.kind;
    assert_eq!(kind("\"environment\""), CameraKind::Spherical(SphericalMapping::Equirectangular));
    assert_eq!(kind("\"spherical\""), CameraKind::Spherical(SphericalMapping::EqualArea));
    assert_eq!(
        kind("\"spherical\" \"string mapping\" \"equirectangular\""),
        CameraKind::Spherical(SphericalMapping::Equirectangular)
    );
    let projection = FisheyeProjection::Equidistant;
    assert_eq!(kind("\"fisheye\""), CameraKind::Fisheye { field_of_view: PI, projection });
    let projection = FisheyeProjection::Stereographic;
    assert_eq!(
        kind("\"fisheye\" \"string projection\" \"stereographic\" \"float fov\" 270"),
        CameraKind::Fisheye { field_of_view: 1.5 * PI, projection }
    );
    let text =
        "Camera \"perspective\" \"float lensradius\" 1 \"integer blades\" 7 \"float bladerotation\" 90";
    let iris = read_clean(text).description.camera.iris;
    assert_eq!(iris, IrisDescription { blades: 7, rotation: FRAC_PI_2 });
    for (text, told) in [
        ("Camera \"spherical\" \"string mapping\" \"cube\"", "\"equalarea\" or \"equirectangular\""),
        ("Camera \"fisheye\" \"string projection\" \"pinhole\"", "\"equisolid\""),
        ("Camera \"fisheye\" \"float fov\" 361", "at most 360"),
        ("Camera \"perspective\" \"integer blades\" 2", "3 or more"),
        ("Camera \"realistic\"", "lensfile"),
        ("Camera \"realistic\" \"string lensfile\" \"no.dat\"", "no.dat"),
        ("Film \"rgb\" Camera \"perspective\" \"float shutterclose\" 0", "close later"),
    ] {
        let errors = load_str("test.pbrt", text, &Options::default()).unwrap_err().to_string();
        assert!(errors.contains(told), "{text}: {errors}");
    }
}

#[test]
fn lenses_are_read_from_their_files() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("lens.dat");
    std::fs::write(&file, "# radius thickness eta aperture\n35 2.5 1.6 20\n0 4 0 9 # stop\n-20 30 1 18\n")
        .unwrap();
    let options = Options { folder: Some(folder.path().to_owned()), ..Options::default() };
    let read = |text: &str| load_str("test.pbrt", text, &options).unwrap();
    let lens = |text: &str| match read(text).description.camera.kind {
        CameraKind::Realistic(lens) => *lens,
        other => panic!("{other:?}"),
    };
    let text = "Camera \"realistic\" \"string lensfile\" \"lens.dat\" \"float aperturediameter\" 4 \
        \"float focusdistance\" 2 \"string aperture\" \"star\"";
    let found = lens(&format!("Film \"rgb\" \"float diagonal\" 50 {text}"));
    let row = |curvature_radius, thickness, eta, diameter| LensInterfaceDescription {
        curvature_radius,
        thickness,
        eta,
        diameter,
    };
    let expected = [row(0.035, 0.0025, 1.6, 0.02), row(0.0, 0.004, 0.0, 0.009), row(-0.02, 0.03, 1.0, 0.018)];
    assert_eq!(found.interfaces.len(), 3);
    for (found, expected) in found.interfaces.iter().zip(expected) {
        close(found.curvature_radius, expected.curvature_radius);
        close(found.thickness, expected.thickness);
        close(found.diameter, expected.diameter);
        assert_eq!(found.eta, expected.eta);
    }
    assert_eq!((found.aperture_diameter, found.focus_distance), (0.004, 2.0));
    assert_eq!((found.stop, found.relative_weights), (StopShape::Star, false));
    // pbrt's version 3 weighs relative to the middle of the film unless told otherwise.
    assert!(lens(text).relative_weights);
    assert!(!lens(&format!("{text} \"bool simpleweighting\" false")).relative_weights);
    // Version 4 exposes for the time of the shutter in any case, version 3 where the picture is irradiance.
    let exposure = |text: &str| read(text).description.film.sensor.exposure;
    let shutter = format!("{text} \"float shutterclose\" .5");
    assert_eq!(exposure(&shutter), 1.0);
    assert_eq!(exposure(&format!("{shutter} \"bool simpleweighting\" false")), 0.5);
    assert_eq!(exposure(&format!("Film \"rgb\" {shutter}")), 0.5);
    assert_eq!(exposure(&format!("Film \"rgb\" {shutter} \"bool simpleweighting\" true")), 0.5);
    std::fs::write(&file, "35 2.5 1.6\n").unwrap();
    let error = load_str("test.pbrt", text, &options).unwrap_err().to_string();
    assert!(error.contains("has 3 numbers"), "{error}");
    std::fs::write(&file, "35 2.5 1.6 wide\n").unwrap();
    let error = load_str("test.pbrt", text, &options).unwrap_err().to_string();
    assert!(error.contains("lens.dat:1:12"), "{error}");
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
