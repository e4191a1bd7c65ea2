//! Camera, lights and materials.

use std::f64::consts::PI;

use glanz_scene::description::{CameraKind, LensDescription, LensInterfaceDescription, StopShape};

use super::*;

fn close(found: &Value, expected: &[f64], accuracy: f64) -> bool {
    let found = numbers(found);
    found.len() == expected.len() && found.iter().zip(expected).all(|(a, b)| (a - b).abs() <= accuracy)
}

#[test]
fn camera_is_that_of_the_scene() {
    let text = r#"
        LookAt 1 -8 2  1 0 2  0 0 1
        Camera "perspective" "float fov" 40
        Film "rgb" "integer xresolution" 400 "integer yresolution" 200
        WorldBegin
        Translate 1 0 2
        Shape "sphere" "float radius" 2"#;
    let (_, file, _) = model(text);
    let camera = &file.head["camera"];
    assert_eq!(camera["kind"], "perspective");
    assert!(close(&camera["position"], &[1.0, -8.0, 2.0], 1e-12));
    assert!(close(&camera["forward"], &[0.0, 1.0, 0.0], 1e-12));
    assert!(close(&camera["up"], &[0.0, 0.0, 1.0], 1e-12));
    // pbrt's cameras see x to the left of what a right-handed world has there.
    assert!(close(&camera["right"], &[-1.0, 0.0, 0.0], 1e-12));
    assert!((camera["fieldOfView"].as_f64().unwrap() - 40.0_f64.to_radians()).abs() < 1e-12);
    // To the near side of the sphere.
    assert!((camera["distance"].as_f64().unwrap() - 6.0).abs() < 1e-9);
    assert!(close(&file.head["up"], &[0.0, 0.0, 1.0], 0.0));
    let mirrored = text.replacen("LookAt", "Scale -1 1 1 LookAt", 1);
    assert!(close(&model(&mirrored).1.head["camera"]["right"], &[1.0, 0.0, 0.0], 1e-12));
    // Half as tall a window: tan(20 degrees) / 2 is the new half.
    let narrow = text.replacen("40", r#"40 "float screenwindow" [-1 1 -0.5 0.5]"#, 1);
    let field = model(&narrow).1.head["camera"]["fieldOfView"].as_f64().unwrap();
    assert!((field - 2.0 * (0.5 * 20.0_f64.to_radians().tan()).atan()).abs() < 1e-12);
    assert_eq!(model(&narrow).1.head["aspect"], 2.0);
}

#[test]
fn parallel_camera_says_its_height_and_looks_at_the_middle() {
    let text = r#"
        LookAt 0 0 9  0 0 0  0 -1 0
        Camera "orthographic" "float screenwindow" [-3 3 -2 2]
        WorldBegin
        Shape "disk" "float innerradius" 0.5"#;
    let (_, file, _) = model(text);
    let camera = &file.head["camera"];
    assert_eq!((&camera["kind"], &camera["height"]), (&"orthographic".into(), &4.0.into()));
    // The ray passes the hole.
    assert!((camera["distance"].as_f64().unwrap() - 9.0).abs() < 1e-9);
    assert!(close(&file.head["up"], &[0.0, -1.0, 0.0], 0.0));
}

#[test]
fn perspective_cameras_stand_in_for_others_with_a_note() {
    for (camera, kind) in [("\"spherical\"", "spherical"), ("\"fisheye\" \"float fov\" 200", "fish-eye")] {
        let text = format!("LookAt 1 -8 2  1 0 2  0 0 1 Camera {camera} WorldBegin Shape \"sphere\"");
        let (_, file, _) = model(&text);
        assert_eq!(file.head["camera"]["kind"], "perspective");
        assert!(close(&file.head["camera"]["forward"], &[0.0, 1.0, 0.0], 1e-12));
        let note = format!("a perspective camera stands in for the {kind} camera of the scene");
        assert_eq!(file.list("notes"), [note]);
    }
}

#[test]
fn the_page_sees_the_angle_of_a_realistic_lens() {
    // A far focus: the film is at the focal length f = R / (n - 1) = 100 mm behind a thin lens, and 30 mm high.
    let interface = |curvature_radius, thickness, eta, diameter| LensInterfaceDescription {
        curvature_radius,
        thickness,
        eta,
        diameter,
    };
    let lens = LensDescription {
        interfaces: vec![interface(0.05, 1e-4, 1.5, 0.004), interface(1e9, 0.0, 1.0, 0.004)],
        aperture_diameter: 1.0,
        focus_distance: 1e6,
        stop: StopShape::Gaussian,
        relative_weights: false,
    };
    let (mut description, _) = load("Camera \"perspective\" WorldBegin Shape \"sphere\"");
    description.camera.kind = CameraKind::Realistic(Box::new(lens));
    (description.film.resolution, description.film.diagonal) = ([400, 300], 0.05);
    let scene = Scene::resolve(description.clone()).unwrap().0;
    let model = Model::try_new("test", &description, &scene, &description.files).unwrap();
    let field = File::read(&model.to_bytes().unwrap()).head["camera"]["fieldOfView"].as_f64().unwrap();
    assert!((field - 2.0 * 0.15_f64.atan()).abs() < 2e-3, "{field}");
}

#[test]
fn a_scene_without_camera_is_seen_whole() {
    let (_, file, scene) = model("WorldBegin\nTranslate 5 6 7\nShape \"box\"");
    let camera = &file.head["camera"];
    let [position, forward] =
        ["position", "forward"].map(|k| glanz_math::DVec3::from_slice(&numbers(&camera[k])));
    let half = 0.5 * camera["fieldOfView"].as_f64().unwrap();
    for corner in scene.bounds().corners() {
        let to = (corner - position).normalize();
        assert!(to.dot(forward) > half.cos());
    }
}

#[test]
fn lights_have_the_strength_of_the_scene() {
    let text = r#"
        WorldBegin
        LightSource "point" "rgb I" [1 2 3] "point3 from" [1 2 3]
        LightSource "spot" "rgb I" [10 10 10] "point3 from" [0 0 5] "point3 to" [0 0 0]
            "float coneangle" 30 "float conedeltaangle" 10
        LightSource "distant" "rgb L" [2 2 2] "point3 from" [0 0 1] "point3 to" [0 0 0]
        LightSource "infinite" "rgb L" [0.25 0.5 0.75]
        LightSource "infinite" "rgb L" [0.25 0.5 0.25]
        AttributeBegin
            AreaLightSource "diffuse" "rgb L" [5 5 5]
            Translate 0 0 9  ReverseOrientation
            Shape "disk" "float radius" 2
        AttributeEnd
        AttributeBegin
            AreaLightSource "diffuse" "rgb L" [7 7 7]
            Translate 4 5 6
            Shape "sphere" "float radius" 0.5
        AttributeEnd"#;
    let (_, file, _) = model(text);
    let lights = file.list("lights");
    let of = |kind: &str| lights.iter().filter(|light| light["kind"] == kind).collect::<Vec<_>>();
    // pi L r^2 along the axis of a Lambertian disk.
    let disk = of("area")[0];
    assert!(
        close(&disk["position"], &[0.0, 0.0, 9.0], 1e-9)
            && close(&disk["direction"], &[0.0, 0.0, -1.0], 1e-12)
    );
    assert!(close(&disk["intensity"], &[20.0 * PI; 3], 1e-2));
    // A sphere shows pi r^2 to every side.
    let points = of("point");
    let sphere = points.iter().find(|light| close(&light["position"], &[4.0, 5.0, 6.0], 1e-6)).unwrap();
    assert!(close(&sphere["intensity"], &[7.0 * PI * 0.25; 3], 1e-2));
    assert!(points.iter().any(|light| close(&light["intensity"], &[1.0, 2.0, 3.0], 1e-4)));
    let spot = of("spot")[0];
    let [inner, outer] = [20.0_f64, 30.0].map(|angle| angle.to_radians().cos());
    assert!(
        close(&spot["direction"], &[0.0, 0.0, -1.0], 1e-12) && close(&spot["intensity"], &[10.0; 3], 1e-3)
    );
    assert!((spot["cosInner"].as_f64().unwrap() - inner).abs() < 1e-12);
    assert!((spot["cosOuter"].as_f64().unwrap() - outer).abs() < 1e-12);
    assert!(close(&of("distant")[0]["direction"], &[0.0, 0.0, -1.0], 1e-12));
    // The two from everywhere are one, and the last.
    assert_eq!((lights.len(), of("infinite").len()), (6, 1));
    assert!(close(&lights[5]["intensity"], &[0.5, 1.0, 1.0], 1e-4));
    // The shapes that shine say so.
    let shining = file.list("objects").iter().filter(|object| object["light"] == true);
    for object in shining {
        let material = &file.list("materials")[number(&object["material"])];
        let radiance = if object["kind"] == "disk" { 5.0 } else { 7.0 };
        assert!(close(&material["emission"], &[radiance; 3], 1e-3));
    }
}

#[test]
fn the_brightest_lights_are_kept() {
    let lamp = |k: usize| format!("LightSource \"point\" \"rgb I\" [{k} {k} {k}]\n");
    let text = format!("WorldBegin\nShape \"sphere\"\n{}", (1..=40).map(lamp).collect::<String>());
    let (_, file, _) = model(&text);
    let dimmest =
        file.list("lights").iter().map(|light| numbers(&light["intensity"])[0]).fold(f64::INFINITY, f64::min);
    assert_eq!(file.list("lights").len(), 32);
    assert!((dimmest - 9.0).abs() < 1e-3);
    assert_eq!(file.list("notes").len(), 1);
}

#[test]
fn materials_look_like_those_of_the_scene() {
    let text = r#"
        WorldBegin
        Texture "squares" "spectrum" "checkerboard" "float uscale" 4 "float vscale" 4
            "rgb tex1" [0.8 0.4 0.2] "rgb tex2" [0.2 0.2 0.6]
        Material "diffuse" "texture reflectance" "squares"
        Shape "sphere"
        Material "dielectric" "float eta" 1.5
        Shape "sphere" "float radius" 2
        Material "mirror"
        Shape "sphere" "float radius" 3
        Material "conductor" "spectrum eta" "metal-Au-eta" "spectrum k" "metal-Au-k"
        Shape "sphere" "float radius" 4
        Material "phong" "rgb Kd" [0.5 0.3 0.1] "rgb Ks" [0.2 0.2 0.2] "float exponent" 62
        Shape "sphere" "float radius" 5"#;
    let (_, file, _) = model(text);
    let of = |k: usize| &file.list("materials")[number(&file.list("objects")[k]["material"])];
    // As many of each kind of square among the places looked at.
    assert!(close(&of(0)["base"], &[0.5, 0.3, 0.4], 1e-3), "{}", of(0));
    // ((1.5 - 1) / (1.5 + 1))^2 = 0.04.
    assert!(close(&of(1)["specular"], &[0.04; 3], 1e-5) && of(1)["opacity"].as_f64().unwrap() < 0.5);
    assert_eq!((&of(2)["kind"], &of(2)["metallic"]), (&"mirror".into(), &1.0.into()));
    let gold = numbers(&of(3)["base"]);
    assert!(of(3)["metallic"] == 1.0 && gold[0] > 0.9 && gold[2] < 0.5, "{gold:?}");
    assert!(close(&of(4)["base"], &[0.5, 0.3, 0.1], 1e-3) && close(&of(4)["specular"], &[0.2; 3], 1e-3));
    // The roughness of a microfacet lobe: sqrt(2 / (62 + 2)).
    assert_eq!(of(4)["exponent"], 62.0);
    assert!((of(4)["roughness"].as_f64().unwrap() - (1.0_f64 / 32.0).sqrt()).abs() < 1e-6);
}

#[test]
fn luminaires_keep_their_flux() {
    use std::sync::Arc;

    use glanz_light::intensity::{AngularSystem, IntensityDistribution, Symmetry};
    use glanz_math::DVec3;
    use glanz_scene::description::{LightDescription, LightKind};

    // 100 cd straight down, falling by the cosine: I_0 pi lm in all, as of a light of 100 cd along its axis. Another one shines 50 cd everywhere.
    let angles: Vec<f64> = (0..=90).map(f64::from).collect();
    let cosine: Vec<f64> = angles.iter().map(|angle| 100.0 * angle.to_radians().cos()).collect();
    let down =
        IntensityDistribution::try_new(AngularSystem::C, Symmetry::Axial, &[0.0], angles, cosine).unwrap();
    let even = IntensityDistribution::try_new(
        AngularSystem::C,
        Symmetry::Axial,
        &[0.0],
        vec![0.0, 180.0],
        vec![50.0; 2],
    )
    .unwrap();
    let (mut description, _) = load("WorldBegin\nShape \"sphere\"");
    let lamp = |distribution: IntensityDistribution, x: f64| {
        let (distribution, from) = (Arc::new(distribution), DVec3::X * x);
        LightDescription::new(LightKind::Photometric { distribution, opening: None, from }, 1.0)
    };
    description.lights = vec![lamp(down, 1.0), lamp(even, 2.0)];
    let scene = Scene::resolve(description.clone()).unwrap().0;
    let model = Model::try_new("test", &description, &scene, &[]).unwrap();
    let file = File::read(&model.to_bytes().unwrap());
    let of = |kind: &str| file.list("lights").iter().find(|light| light["kind"] == kind).unwrap();
    let (down, even) = (of("area"), of("point"));
    assert!(
        close(&down["position"], &[1.0, 0.0, 0.0], 1e-12)
            && close(&down["direction"], &[0.0, 0.0, -1.0], 1e-12)
    );
    let ratio = numbers(&down["intensity"])[0] / numbers(&even["intensity"])[0];
    assert!((ratio - 2.0).abs() < 1e-3, "{ratio}");
}
