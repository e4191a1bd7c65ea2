//! Participating media.

use glanz_scene::Scene;
use glanz_scene::description::{MediumDescription, SurfaceMedia};

use super::*;

/// The first medium of a text.
fn medium(text: &str) -> MediumDescription {
    let text = format!("WorldBegin MakeNamedMedium \"m\" \"string type\" {text}");
    read_clean(&text).description.media[0].clone()
}

fn coefficients(medium: &MediumDescription) -> [[f32; 3]; 2] {
    [&medium.absorption, &medium.scattering].map(|d| d.unbounded(&Wavelengths::Rgb).to_rgb(&Wavelengths::Rgb))
}

#[test]
fn media_have_the_parameters_and_defaults_of_pbrt() {
    let milk = [[0.0011, 0.0024, 0.014], [2.55, 3.21, 3.77]];
    let plain = medium("\"homogeneous\"");
    assert_eq!((coefficients(&plain), plain.scale, plain.g), (milk, 1.0, 0.0));
    assert!(plain.density.is_none());
    let v4 = read_clean("Film \"rgb\" WorldBegin MakeNamedMedium \"m\" \"string type\" \"homogeneous\"");
    assert_eq!(coefficients(&v4.description.media[0]), [[1.0; 3]; 2]);
    let fog = medium(
        "\"homogeneous\" \"rgb sigma_a\" [.1 .2 .3] \"spectrum sigma_s\" [400 2 700 2] \"float scale\" 5 \"float g\" -.5 \
         \"rgb Le\" [1 2 3] \"float Lescale\" 7",
    );
    assert_eq!((coefficients(&fog)[0], fog.scale, fog.g), ([0.1, 0.2, 0.3], 5.0, -0.5));
    coefficients(&fog)[1].into_iter().for_each(|x| close(f64::from(x), 2.0));
    assert_eq!((rgb(&fog.emission), fog.emission_scale), ([1.0, 2.0, 3.0], 7.0));
    // Version 4 divides black bodies by their luminance (HomogeneousMedium::Create), version 3 has none.
    let lava = "WorldBegin MakeNamedMedium \"m\" \"string type\" \"homogeneous\" \"blackbody Le\" 3000 \"float Lescale\" 7";
    let lava = read_clean(&format!("Film \"rgb\" {lava}")).description.media[0].clone();
    close(f64::from(lava.emission.luminance() * lava.emission_scale), 7.0);
    for (kind, defaults) in [("uniformgrid", [[1.0; 3]; 2]), ("heterogeneous", milk)] {
        let smoke = medium(&format!(
            "\"{kind}\" \"integer nx\" 3 \"integer nz\" 2 \"float density\" [0 1 2 3 4 5] \"point3 p1\" [3 4 5]"
        ));
        assert_eq!(coefficients(&smoke), defaults);
        let grid = smoke.density.unwrap();
        assert_eq!((grid.resolution, &*grid.values), ([3, 1, 2], &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0][..]));
        assert_eq!(grid.corners, [DVec3::ZERO, DVec3::new(3.0, 4.0, 5.0)]);
    }
}

#[test]
fn shapes_and_the_camera_take_the_media_of_the_interface() {
    let text = r#"Film "rgb" MediumInterface "" "air" Camera "perspective"
        MakeNamedMedium "air" "string type" "homogeneous"
        WorldBegin
        Shape "sphere"
        AttributeBegin
            Translate 1 0 0
            MakeNamedMedium "smoke" "string type" "uniformgrid" "float density" 1
            MediumInterface "smoke" "air" Shape "sphere"
            MediumInterface "later" Shape "sphere"
        AttributeEnd
        MakeNamedMedium "later" "string type" "homogeneous" "float g" 0.25
        MediumInterface "" Shape "sphere""#;
    let d = read_clean(text).description;
    let at = |name: &str| d.media.iter().position(|medium| medium.name == name);
    let [air, smoke, later] = ["air", "smoke", "later"].map(at);
    assert!(air.is_some() && smoke.is_some() && later.is_some());
    assert_eq!(d.camera_medium, air);
    let media: Vec<_> = d.world.shapes.iter().map(|shape| shape.media).collect();
    let expected = [(None, air), (smoke, air), (later, later), (None, None)];
    assert_eq!(media, expected.map(|(inside, outside)| SurfaceMedia { inside, outside }));
    assert_eq!(d.media[later.unwrap()].g, 0.25);
    let grid = d.media[smoke.unwrap()].density.as_ref().unwrap();
    assert_eq!(grid.to_world, DMat4::from_translation(DVec3::X));
}

#[test]
fn media_that_are_not_available_are_reported() {
    for text in [
        "MakeNamedMedium \"m\" \"string type\" \"cloud\"",
        "MakeNamedMedium \"m\" \"string type\" \"nanovdb\" \"string filename\" \"no.nvdb\"",
        "MakeNamedMedium \"m\" \"string type\" \"rgbgrid\"",
        "MakeNamedMedium \"m\" \"string type\" \"homogeneous\" \"string preset\" \"Skin1\"",
        "MakeNamedMedium \"m\" \"string type\" \"heterogeneous\" \"string preset\" \"Skin1\" \"float density\" 1",
        "MakeNamedMedium \"m\" \"string type\" \"uniformgrid\" \"float density\" 1 \"float temperature\" 1000",
        "Volume \"homogeneous\" \"color sigma_a\" [1 1 1]",
    ] {
        let kinds: Vec<_> = read(&format!("WorldBegin {text}")).diagnostics.iter().map(|d| d.kind).collect();
        assert_eq!(kinds, ["stand-in-medium"], "{text}");
    }
}

#[test]
fn faults_of_media_are_errors_with_their_place() {
    for (text, place, message) in [
        ("MakeNamedMedium \"m\"", "1:12", "medium \"m\" has no \"string type\""),
        ("MediumInterface \"mist\" \"\" Shape \"sphere\"", "1:28", "there is no medium \"mist\""),
        ("MakeNamedMedium \"m\" \"string type\" \"uniformgrid\"", "1:12", "has no \"float density\""),
        (
            "MakeNamedMedium \"m\" \"string type\" \"uniformgrid\" \"integer nx\" 2 \"float density\" [1 2 3]",
            "1:92",
            "3 densities are not nx 2 times ny 1 times nz 1",
        ),
        (
            "MakeNamedMedium \"m\" \"string type\" \"uniformgrid\" \"integer nx\" 2147483647 \"integer ny\" 2147483647 \
             \"integer nz\" 2147483647 \"float density\" [1]",
            "1:",
            "1 densities are not nx 2147483647",
        ),
    ] {
        let errors =
            load_str("m", &format!("WorldBegin {text}"), &Options::default()).unwrap_err().to_string();
        assert!(errors.contains(&format!("m:{place}")) && errors.contains(message), "{errors}");
    }
    for (text, message) in [
        ("\"homogeneous\" \"float g\" 1", "medium: g is 1; it must be between -1 and 1"),
        ("\"homogeneous\" \"float scale\" -1", "medium: absorption"),
        ("\"homogeneous\" \"float sigma_s\" 1e38 \"float scale\" 10", "medium: scattering"),
        ("\"uniformgrid\" \"float density\" -1", "medium: density is -1; it must be finite and not negative"),
        (
            "\"uniformgrid\" \"float density\" 1 \"point3 p1\" [0 1 1]",
            "medium: size of the box from p0 to p1",
        ),
    ] {
        let read = read_clean(&format!("WorldBegin MakeNamedMedium \"m\" \"string type\" {text}"));
        let error = Scene::resolve(read.description).unwrap_err();
        assert!(error.to_string().contains(message), "{error}");
        assert_eq!(error.location.map(|at| (at.line, at.column)), Some((1, 12)));
    }
}
