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
