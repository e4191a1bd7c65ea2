//! The camera and lights.

use super::*;

#[test]
fn a_camera_looks_along_minus_z_and_makes_the_picture_as_wide_as_it_is() {
    let file = |camera: Value| {
        let mut file = with_material(json!({}), json!({ "cameras": [camera] }));
        file["nodes"] = json!([{ "mesh": 0 }, { "camera": 0, "translation": [1, 2, 3], "scale": [5, 5, 5] }]);
        file
    };
    let loaded = load(&file(
        json!({ "type": "perspective", "perspective": { "yfov": 1.0, "aspectRatio": 0.5, "znear": 1 } }),
    ));
    let camera = &loaded.description.camera;
    // Half as wide as high: tan(w / 2) = tan(1 / 2) / 2.
    let CameraKind::Perspective { field_of_view } = camera.kind else { panic!() };
    assert!(((0.5 * field_of_view).tan() - 0.5 * 0.5_f64.tan()).abs() < 1e-12);
    // As many pixels as 1280 x 720: sqrt(921600 / 0.5) = 1357.6.
    assert_eq!(loaded.description.film.resolution, [679, 1358]);
    assert_eq!(camera.to_world.transform_vector3(DVec3::Z), DVec3::NEG_Z);
    assert_eq!(camera.to_world.transform_vector3(DVec3::X), DVec3::X);
    assert_eq!(camera.to_world.transform_point3(DVec3::Y), DVec3::new(1.0, 3.0, 3.0));
    let studio = loaded.studio.unwrap();
    assert!(studio.own_camera && !studio.own_light);
    let loaded = load(&file(
        json!({ "type": "orthographic", "orthographic": { "xmag": 3, "ymag": 1.5, "znear": 1, "zfar": 2 } }),
    ));
    assert_eq!(loaded.description.camera.screen_window, Some([-3.0, 3.0, -1.5, 1.5]));
    assert_eq!(loaded.description.camera.kind, CameraKind::Orthographic);
}

#[test]
fn lights_shine_along_minus_z_with_watts_of_their_lumens() {
    let lights = json!([
        { "type": "point", "intensity": 683, "color": [1, 0.5, 0] },
        { "type": "directional" },
        { "type": "spot", "spot": { "innerConeAngle": 0.25, "outerConeAngle": 0.5 } },
    ]);
    let mut file = with_material(json!({ "emissiveFactor": [1, 1, 1] }), json!({}));
    file["extensions"] = json!({ "KHR_lights_punctual": { "lights": lights } });
    let light = |number: u32| json!({ "translation": [1, 2, 3], "extensions": { "KHR_lights_punctual": { "light": number } } });
    file["nodes"] = json!([{ "mesh": 0 }, light(0), light(1), light(2)]);
    let loaded = load(&file);
    assert!(loaded.studio.unwrap().own_light);
    let [point, directional, spot] = &loaded.description.lights[..] else { panic!() };
    assert_eq!(point.emission, SpectralDistribution::Rgb([683.0, 341.5, 0.0]));
    assert!((f64::from(point.scale) * 683.0 - 1.0).abs() < 1e-6, "683 lm are a watt of white");
    assert!(
        matches!(point.kind, LightKind::Point { from, range: None } if from == DVec3::new(1.0, 2.0, 3.0))
    );
    assert!(matches!(directional.kind, LightKind::Distant { from: DVec3::ZERO, to: DVec3::NEG_Z }));
    let LightKind::Spot { to, cone_angle: 0.5, inner_angle: 0.25, .. } = spot.kind else { panic!() };
    assert_eq!(to, DVec3::new(1.0, 2.0, 2.0));
    // In a file with lights, emission is in nits, too.
    let emission = loaded.description.world.shapes[0].emission.clone().unwrap();
    assert_eq!((emission.scale, emission.two_sided), (point.scale, false));
    // Lights that no node has do not count: the studio's stand in.
    file["nodes"] = json!([{ "mesh": 0 }]);
    let loaded = load(&file);
    assert_eq!(loaded.description.world.shapes[0].emission.clone().unwrap().scale, 1.0);
    assert!(!loaded.studio.unwrap().own_light);
}
