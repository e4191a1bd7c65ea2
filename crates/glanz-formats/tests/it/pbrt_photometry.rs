//! Photometric files and ray files of the lights of scenes.

use glanz_formats::Loaded;
use glanz_light::SpectralDistribution;
use glanz_light::intensity::{IntensityDistribution, LuminousOpening, OpeningShape};
use glanz_math::DVec3;
use glanz_scene::description::LightKind;

use crate::pbrt_files::Folder;

/// Tilt data: half at 90 degrees. A circle of 0.2 m; 60 cd down, 0 from the horizontal on.
const IES: &str = "IESNA:LM-63-2002\n[LUMINAIRE] Spot\nTILT=INCLUDE\n1\n2\n0 90\n1 0.5\n1 1000 1 2 1 1 2 -0.2 -0.2 0 1 1 12\n0 90\n0\n60 0\n";

/// 100 cd per 1000 lm everywhere below the horizontal, with lamps of 1000 or of 3000 lm.
fn ldt() -> String {
    let mut lines = vec!["Maker", "1", "1", "1", "0", "2", "90", "report", "name", "number", "file", "date"];
    // Housing, opening and its sides, in mm; shares, factor and tilt; sets of lamps.
    lines.extend(["100", "0", "50", "0", "0", "0", "0", "0", "0", "100", "62.8", "1", "0", "2"]);
    lines.extend(["1", "lamp", "1000", "3000", "80", "10", "1", "lamp", "3000", "3000", "80", "30"]);
    lines.extend(["0"; 10]);
    lines.extend(["0", "0", "90", "100", "100"]);
    lines.join("\r\n")
}

fn luminaire(loaded: &Loaded) -> (&IntensityDistribution, Option<LuminousOpening>) {
    match &loaded.description.lights[0].kind {
        LightKind::Photometric { distribution, opening, .. } => (distribution, *opening),
        other => panic!("{other:?}"),
    }
}

#[test]
fn photometric_lights_have_the_candela_of_their_file() {
    let folder = Folder::new("luminaire");
    folder.put("lamp.ies", IES).put("parts/lamp.ldt", ldt());
    let read = |parameters: &str| {
        let text = format!("WorldBegin\nTranslate 0 0 3\nLightSource \"photometric\" {parameters}\n");
        let loaded = folder.put("scene.pbrt", text).load().unwrap_or_else(|d| panic!("{d}"));
        assert!(loaded.diagnostics.is_empty(), "{}", loaded.diagnostics);
        loaded
    };
    let down = |loaded: &Loaded| luminaire(loaded).0.intensity(DVec3::NEG_Z);
    let ies = "\"string filename\" \"lamp.ies\"";
    let plain = read(&format!("{ies} \"rgb color\" [ 4 2 1 ] \"float scale\" 0.5 \"point3 from\" [ 1 2 3 ]"));
    assert_eq!(down(&plain), 60.0);
    let light = &plain.description.lights[0];
    assert_eq!((&light.emission, light.scale), (&SpectralDistribution::Rgb([4.0, 2.0, 1.0]), 0.5));
    assert!(matches!(light.kind, LightKind::Photometric { from, .. } if from == DVec3::new(1.0, 2.0, 3.0)));
    assert_eq!(light.to_world.w_axis.truncate(), DVec3::new(0.0, 0.0, 3.0));
    assert_eq!(luminaire(&plain).1, None);
    assert_eq!(down(&read(&format!("{ies} \"float tilt\" -90"))), 30.0);
    // Linear from 60 cd to 0 over [0, pi / 2] is 60 times 2 pi (1 - 2 / pi) lm.
    let lumens = 120.0 * (std::f64::consts::PI - 2.0);
    let doubled = read(&format!("{ies} \"float tilt\" 90 \"float lumens\" {}", 2.0 * lumens));
    assert!((down(&doubled) / 120.0 - 1.0).abs() < 1e-12);
    let area = read(&format!("{ies} \"string as\" \"area\""));
    assert_eq!(
        luminaire(&area).1,
        Some(LuminousOpening { shape: OpeningShape::Ellipse, size: [0.2, 0.2, 0.0] })
    );
    let ldt = "\"string filename\" \"parts/lamp.ldt\"";
    let (first, second) = (read(ldt), read(&format!("{ldt} \"integer lamps\" 1")));
    assert!((down(&first) - 100.0).abs() < 1e-12 && (down(&second) - 300.0).abs() < 1e-12);
    // What the file holds is part of the fingerprint.
    let before = read(ies).content_hash;
    folder.put("lamp.ies", IES.replace("60 0", "61 0"));
    assert_ne!(read(ies).content_hash, before);
}

#[test]
fn errors_of_photometric_lights_have_a_position() {
    let folder = Folder::new("luminaires");
    folder.put("lamp.ies", IES).put("bad.ies", IES.replace("60 0", "60 x")).put("lamp.ldt", ldt());
    folder.put("dark.ies", IES.replace("60 0", "0 0").replace("-0.2 -0.2", "0 0"));
    let messages = |parameters: &str| {
        let text = format!("WorldBegin\nLightSource \"photometric\" {parameters}\n");
        match folder.put("scene.pbrt", text).load() {
            Ok(loaded) => folder.messages(&loaded.diagnostics),
            Err(errors) => folder.messages(&errors),
        }
    };
    let ies = "\"string filename\" \"lamp.ies\"";
    for (parameters, expected) in [
        (String::new(), "error: scene.pbrt:2:1: light \"photometric\" has no \"string filename\""),
        (
            "\"string filename\" \"no.ies\"".to_owned(),
            "error: scene.pbrt:2:45: light \"photometric\": file \"no.ies\" is not there",
        ),
        (
            "\"string filename\" \"bad.ies\"".to_owned(),
            "error: scene.pbrt:2:45: light \"photometric\": bad.ies:11:4: \"x\" is not a number; the",
        ),
        (
            format!("{ies} \"integer lamps\" 1"),
            "error: scene.pbrt:2:72: light \"photometric\": there is no set of lamps 1 with a flux; the file has 1",
        ),
        (
            format!("{ies} \"float lumens\" -1"),
            "error: scene.pbrt:2:71: light \"photometric\": -1 lm cannot be had from this luminaire",
        ),
        (
            format!("{ies} \"string as\" \"lamp\""),
            "error: scene.pbrt:2:68: light \"photometric\": \"lamp\" is not known as \"as\"",
        ),
        (
            "\"string filename\" \"lamp.ldt\" \"float tilt\" 30".to_owned(),
            "warning: scene.pbrt:2:69: light \"photometric\": its file has no tilt data",
        ),
        (
            "\"string filename\" \"dark.ies\" \"string as\" \"area\"".to_owned(),
            "warning: scene.pbrt:2:45: light \"photometric\": \"dark.ies\" has no light",
        ),
        (
            "\"string filename\" \"lamp.ldt\" \"string as\" \"area\"".to_owned(),
            "warning: scene.pbrt:2:68: light \"photometric\": its file states no size; a point stands in",
        ),
    ] {
        let found = messages(&parameters);
        assert!(found.starts_with(expected), "{found}\n{expected}");
    }
}

/// A TM-25 file of rays with a start in mm, a direction and watts; with a luminous flux in the header.
fn tm25(count: u64, lumens: f32, rays: &[[f32; 7]]) -> Vec<u8> {
    let mut out = b"TM25".to_vec();
    out.extend([2013_i32, 0].map(i32::to_le_bytes).as_flattened());
    out.extend([lumens, 4.0].map(f32::to_le_bytes).as_flattened());
    out.extend(count.to_le_bytes());
    out.resize(256, 0);
    // Position, direction, radiant flux.
    out.extend([1_i32, 1, 1, 0, 0, 0, 0, 0].map(i32::to_le_bytes).as_flattened());
    out.resize(256 + 32 + 9 * 4000, 0);
    out.extend(rays.iter().flatten().flat_map(|v| v.to_le_bytes()));
    out
}

#[test]
fn rays_of_a_file_share_its_luminous_flux() {
    let folder = Folder::new("rays");
    let rays = [[1000.0, 0.0, 500.0, 0.0, 0.0, 1.0, 1.0], [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 3.0]];
    folder.put("stated.tm25ray", tm25(2, 800.0, &rays)).put("silent.tm25ray", tm25(2, f32::NAN, &rays));
    folder.put("cut.tm25ray", tm25(3, 800.0, &rays)).put("huge.tm25ray", tm25(20_000_001, 800.0, &rays));
    let read = |parameters: &str| {
        let text = format!("WorldBegin\nLightSource \"photometric\" \"string filename\" {parameters}\n");
        folder.put("scene.pbrt", text).load()
    };
    for (parameters, expected) in [
        ("\"stated.tm25ray\"", [200.0, 600.0]),
        ("\"stated.tm25ray\" \"float lumens\" 4", [1.0, 3.0]),
        ("\"silent.tm25ray\" \"float lumens\" 4", [1.0, 3.0]),
    ] {
        let loaded = read(parameters).unwrap_or_else(|d| panic!("{d}"));
        let LightKind::Rays { rays, .. } = &loaded.description.lights[0].kind else { panic!() };
        assert_eq!([rays[0].lumens, rays[1].lumens], expected);
        assert_eq!((rays[0].origin, rays[0].direction), ([1.0, 0.0, 0.5], [0.0, 0.0, 1.0]));
    }
    for (parameters, expected) in [
        ("\"silent.tm25ray\"", "silent.tm25ray states no luminous flux"),
        ("\"cut.tm25ray\"", "cut.tm25ray: byte 36344: the file ends within ray 2 of 3"),
        ("\"huge.tm25ray\"", "huge.tm25ray: it has 20000001 rays, at most 20000000 can be used"),
    ] {
        let found = folder.messages(&read(parameters).unwrap_err());
        let expected = format!("error: scene.pbrt:2:45: light \"photometric\": {expected}");
        assert!(found.starts_with(&expected), "{found}");
    }
}
