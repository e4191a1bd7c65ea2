//! `glanz bake`.

use std::io::{BufRead, BufReader, Read};
use std::time::Duration;

use glanz::light::Pixels;

use crate::command_line::support::{Folder, finish};

/// A floor under a lamp, a ball on it and a named material.
const ROOM: &str = r#"
LookAt 0 -4 2  0 0 0.5  0 0 1
Camera "perspective" "float fov" 45
WorldBegin
AttributeBegin
  AreaLightSource "diffuse" "rgb L" [8 8 8]
  Shape "bilinearmesh" "point3 P" [-.5 -.5 2  -.5 .5 2  .5 -.5 2  .5 .5 2]
AttributeEnd
MakeNamedMaterial "sand" "string type" "diffuse" "rgb reflectance" [.5 .4 .3]
NamedMaterial "sand"
Shape "bilinearmesh" "point3 P" [-1 -1 0  1 -1 0  -1 1 0  1 1 0]
Translate 0 0 .4
Shape "sphere" "float radius" .3
"#;

/// The JSON of a model and its bytes.
fn model(bytes: &[u8]) -> (serde_json::Value, Vec<u8>) {
    assert_eq!(&bytes[..4], b"glTF");
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    (serde_json::from_slice(&bytes[20..20 + length]).unwrap(), bytes[28 + length..].to_vec())
}

fn brightest(pixels: &Pixels) -> f32 {
    pixels.to_rgb().unwrap().into_iter().flatten().fold(0.0, f32::max)
}

#[test]
fn bake_writes_a_model_with_the_light_on_it_and_the_irradiance_beside() {
    let folder = Folder::new();
    folder.write("room.pbrt", ROOM);
    let report = folder.succeed("bake room.pbrt -o room.glb --texels-per-metre 8 --json").json();
    assert_eq!(report["outputs"], serde_json::json!(["room.glb", "room.exr"]));
    assert_eq!(folder.names(), ["room.exr", "room.glb", "room.pbrt"]);
    let (document, bytes) = model(&folder.bytes("room.glb"));
    let nodes: Vec<&str> =
        document["nodes"].as_array().unwrap().iter().map(|node| node["name"].as_str().unwrap()).collect();
    assert_eq!(nodes, ["sand 1", "sand 2", "shape 0", "camera"]);
    let close = |found: &serde_json::Value, expected: f64| {
        let found = found.as_f64().unwrap();
        assert!((found - expected).abs() < 1e-6, "{found} {expected}");
    };
    // The camera is at (0, -4, 2) with z up, which is y in the model; the picture has 1280 x 720 pixels.
    let camera = &document["cameras"][0]["perspective"];
    close(&camera["yfov"], 45_f64.to_radians());
    close(&camera["aspectRatio"], 16.0 / 9.0);
    close(&document["nodes"][3]["translation"][1], 2.0);
    close(&document["nodes"][3]["translation"][2], 4.0);
    // Both sides of the floor: one lit from above, the other black because no light reaches it.
    let primitives = document["meshes"][0]["primitives"].as_array().unwrap();
    assert_eq!(primitives.len(), 2);
    assert!(report["triangles"].as_u64().unwrap() > 100);

    // The brightest irradiance is that of the top of the ball: a square of 1 m at 1.3 m height above it shines 8, and the floor adds a little.
    let irradiance = folder.picture("room.exr");
    let side = report["side"].as_u64().unwrap();
    assert_eq!(u64::from(irradiance.width()), side);
    let half = 0.5_f64;
    let slope = half / (half * half + 1.3 * 1.3_f64).sqrt();
    let expected = 8.0 * 4.0 * slope * slope.atan();
    let found = f64::from(brightest(&irradiance));
    assert!(found > 0.97 * expected && found < 1.1 * expected, "{found} {expected}");
    // The picture in the model is a PNG of the same size.
    let view = &document["bufferViews"][document["images"][0]["bufferView"].as_u64().unwrap() as usize];
    let from = view["byteOffset"].as_u64().unwrap() as usize;
    let png = &bytes[from..from + view["byteLength"].as_u64().unwrap() as usize];
    folder.write("light.png", png);
    assert_eq!(folder.picture("light.png").width(), irradiance.width());

    folder.succeed("bake room.pbrt -o eight.glb --texels-per-metre 4 --lightmap png -q");
    assert!(folder.has("eight.png") && !folder.has("eight.exr"));
}

#[test]
fn unusable_options_are_refused_before_the_bake() {
    let folder = Folder::new();
    folder.write("room.pbrt", ROOM);
    folder.run("bake room.pbrt -o room.obj").refused(2, &["room.obj", ".glb"]);
    folder.run("bake room.pbrt -o no/room.glb").refused(1, &["no"]);
    folder.run("bake none.pbrt -o room.glb").refused(1, &["none.pbrt"]);
    folder.run("bake room.pbrt -o room.glb --reconstruct spline").refused(2, &["--method radiosity"]);
    folder.run("bake room.pbrt -o room.glb --method radiosity --reconstruct cubic").refused(2, &["shepard"]);
    folder.run("bake room.pbrt -o room.glb --texels-per-metre 1e6 -q").refused(1, &["--texels-per-metre"]);
    assert_eq!(folder.names(), ["room.pbrt"]);
}

#[test]
fn bake_by_radiosity_is_the_gather_and_resumes() {
    let folder = Folder::new();
    folder.write("room.pbrt", ROOM);
    let bake = "bake room.pbrt --texels-per-metre 8 -q";
    folder.succeed(&format!("{bake} -o gather.glb"));
    let expected = folder.picture("gather.exr").to_rgb().unwrap();
    let mut pictures = Vec::new();
    for name in ["natural", "multiquadrics", "bilinear", "spline", "shepard", "constant"] {
        let line = format!("{bake} -o {name}.glb --method radiosity --reconstruct {name}");
        folder.succeed(&line);
        let found = folder.picture(&format!("{name}.exr")).to_rgb().unwrap();
        let (mut difference, mut sum) = (0.0, 0.0);
        for (a, b) in found.iter().zip(&expected) {
            difference += f64::from((a[1] - b[1]).abs());
            sum += f64::from(b[1]);
        }
        assert!(found.len() == expected.len() && difference / sum < 0.05, "{name}: {}", difference / sum);
        pictures.push(folder.bytes(&format!("{name}.exr")));
    }
    // Each interpolation gives a different light map; natural neighbours are the default.
    assert!((1..6).all(|i| pictures[..i].iter().all(|other| *other != pictures[i])));
    folder.succeed(&format!("{bake} -o two.glb --method radiosity --checkpoint room.light --threads 1"));
    assert_eq!(folder.bytes("two.exr"), pictures[0]);
    folder.run(&format!("{bake} -o three.glb --checkpoint room.light --resume")).refused(1, &["the method"]);
    folder.succeed(&format!("{bake} -o three.glb --method radiosity --checkpoint room.light --resume"));
    assert_eq!(folder.bytes("three.glb"), folder.bytes("two.glb"));
    // The renderer uses it, also for parts.
    let show = "render room.pbrt --integrator radiosity --light-in room.light --size 24x16 --spp 4 -q";
    folder.succeed(&format!("{show} -o shown.exr"));
    (1..=3).for_each(|k| drop(folder.succeed(&format!("{show} --part {k}/3 --checkpoint {k}.glanz"))));
    folder.succeed("merge 3.glanz 1.glanz 2.glanz -o merged.exr");
    assert_eq!(folder.bytes("merged.exr"), folder.bytes("shown.exr"));
}

#[test]
fn bake_warns_of_materials_treated_as_diffuse_and_of_an_omitted_camera() {
    let folder = Folder::with_scene();
    let ran = folder.succeed("bake small.pbrt -o small.glb --texels-per-metre 1");
    assert!(ran.stderr.contains("2 materials are not diffuse"), "{}", ran.stderr);
    assert!(!ran.stderr.contains("camera"), "{}", ran.stderr);
    let shifted = ROOM.replace("\"float fov\" 45", "\"float screenwindow\" [-1 .5 -1 1]");
    folder.write("room.pbrt", shifted);
    let ran = folder.succeed("bake room.pbrt -o room.glb --texels-per-metre 1");
    assert!(ran.stderr.contains("warning: a camera"), "{}", ran.stderr);
}

#[test]
fn radiosity_agrees_with_path_tracing_in_a_diffuse_room() {
    let folder = Folder::new();
    folder.write("room.pbrt", ROOM);
    let mean = |picture: &Pixels| {
        let pixels = picture.to_rgb().unwrap();
        std::array::from_fn(|i| pixels.iter().map(|rgb| f64::from(rgb[i])).sum::<f64>() / pixels.len() as f64)
    };
    let render = |integrator: &str, samples: u32, name: &str| {
        folder.succeed(&format!(
            "render room.pbrt --integrator {integrator} --size 24x16 --spp {samples} -o {name} -q"
        ));
        mean(&folder.picture(name))
    };
    let (found, expected): ([f64; 3], [f64; 3]) =
        (render("radiosity", 16, "radiosity.exr"), render("path", 256, "path.exr"));
    for (found, expected) in found.into_iter().zip(expected) {
        assert!((found / expected - 1.0).abs() < 0.02, "{found} {expected}");
    }
    // The same light maps with a camera that looks into a mirror.
    folder.write("mirror.pbrt", ROOM.replace("Translate 0 0 .4", "Material \"mirror\"\nTranslate 0 0 .4"));
    let ran = folder.succeed("render mirror.pbrt --integrator radiosity --size 24x16 --spp 4 -o mirror.exr");
    assert!(ran.stderr.contains("1 material is not diffuse"), "{}", ran.stderr);
    // Light passes clear glass; frosted glass counts as opaque.
    for (glass, warned) in [
        ("\"dielectric\"", false),
        ("\"thindielectric\"", false),
        ("\"dielectric\" \"float roughness\" .1", true),
    ] {
        folder.write(
            "glass.pbrt",
            ROOM.replace("Translate 0 0 .4", &format!("Material {glass}\nTranslate 0 0 .4")),
        );
        let ran = folder.succeed("bake glass.pbrt -o glass.glb --method radiosity --texels-per-metre 1");
        assert_eq!(ran.stderr.contains("1 material is not diffuse"), warned, "{glass}: {}", ran.stderr);
    }
}

#[test]
fn baked_light_is_kept_and_shown_again() {
    let folder = Folder::new();
    folder.write("room.pbrt", ROOM);
    let bake = "bake room.pbrt --texels-per-metre 6 --rays 64 -q";
    folder.succeed(&format!("{bake} -o one.glb --threads 1"));
    folder.succeed(&format!("{bake} -o two.glb --threads 2 --checkpoint room.light"));
    assert_eq!(folder.bytes("one.glb"), folder.bytes("two.glb"));
    assert_eq!(folder.bytes("one.exr"), folder.bytes("two.exr"));
    // Existing light maps are not changed; models are made from them.
    folder.run(&format!("{bake} -o m.glb --checkpoint room.light")).refused(1, &["room.light", "--resume"]);
    let again =
        folder.succeed(&format!("{} -o three.glb --checkpoint room.light --resume", &bake[..bake.len() - 3]));
    assert!(again.stderr.contains("all light is complete"), "{}", again.stderr);
    assert_eq!(folder.bytes("one.glb"), folder.bytes("three.glb"));

    let show = "render room.pbrt --integrator radiosity --size 12x8 --spp 4 -q --light-in room.light";
    folder.succeed(&format!("{show} -o shown.exr --checkpoint shown.glanz"));
    // Light maps of the same settings equal those that the picture would compute.
    folder.succeed("bake room.pbrt -o plain.glb --checkpoint plain.light -q");
    folder.succeed(&format!("{} -o given.exr", show.replace("room.light", "plain.light")));
    folder.succeed("render room.pbrt --integrator radiosity --size 12x8 --spp 4 -q -o made.exr --threads 2");
    assert_eq!(folder.bytes("given.exr"), folder.bytes("made.exr"));
    assert_ne!(folder.bytes("given.exr"), folder.bytes("shown.exr"));
    // Light maps of a different density give a different picture.
    folder
        .run("render room.pbrt --integrator radiosity --size 12x8 --spp 4 -q --checkpoint shown.glanz --resume -o m.exr")
        .refused(1, &["shown.glanz", "the file of light", "made anew"]);
    folder.run(&show.replace("radiosity", "path")).refused(2, &["--light-in", "--integrator radiosity"]);

    folder.write("other.pbrt", ROOM.replace(".5 .4 .3", ".5 .4 .2"));
    folder
        .run(&show.replace("room.pbrt", "other.pbrt"))
        .refused(1, &["room.light", "the scene (content hash)"]);
    let resumed = "--checkpoint room.light --resume -o m.glb -q";
    folder
        .run(&format!("bake other.pbrt --texels-per-metre 6 --rays 64 {resumed}"))
        .refused(1, &["room.light", "the scene"]);
    folder
        .run(&format!("bake room.pbrt --texels-per-metre 7 --rays 64 {resumed}"))
        .refused(1, &["room.light", "6, not 7"]);
    let mut flipped = folder.bytes("room.light");
    let middle = flipped.len() / 2;
    flipped[middle] ^= 4;
    let cut = folder.bytes("room.light")[..100].to_vec();
    for (bytes, reason) in [(flipped, "damaged"), (cut, "damaged"), (b"solid".to_vec(), "not baked light")] {
        folder.write("bad.light", &bytes);
        folder.run(&show.replace("room.light", "bad.light")).refused(1, &["bad.light", reason]);
        folder
            .run(&format!("{bake} --checkpoint bad.light --resume -o m.glb"))
            .refused(1, &["bad.light", reason]);
        assert_eq!(folder.bytes("bad.light"), bytes, "it is not touched");
    }
    assert!(!folder.has("m.glb") && !folder.has("m.exr"));
}

#[cfg(unix)]
#[test]
fn interrupted_bake_goes_on_to_the_same_bits() {
    let folder = Folder::new();
    folder.write("room.pbrt", ROOM);
    // Exit code and messages of a run interrupted this number of milliseconds after baking has begun.
    let interrupted = |line: &str, wait: u64| {
        let mut child = folder.start(line);
        let mut messages = BufReader::new(child.stderr.take().unwrap());
        let mut said = String::new();
        while !said.contains("baking ") {
            assert!(messages.read_line(&mut said).unwrap() > 0, "{said}");
        }
        std::thread::sleep(Duration::from_millis(wait));
        let id = child.id().to_string();
        assert!(std::process::Command::new("kill").args(["-INT", &id]).status().unwrap().success());
        messages.read_to_string(&mut said).unwrap();
        (finish(child, line).code, said)
    };
    let (code, said) = interrupted("bake room.pbrt --rays 65536 -o bare.glb", 100);
    assert!(code == Some(130) && said.contains("nothing was written"), "{code:?} {said}");
    assert_eq!(folder.names(), ["room.pbrt"]);

    let bake = "bake room.pbrt --texels-per-metre 12 --rays 1024";
    folder.succeed(&format!("{bake} -o whole.glb --checkpoint whole.light"));
    let parts = format!("{bake} -o parts.glb --checkpoint parts.light --resume --threads 1");
    for wait in [0, 100, 300, 900] {
        let (code, said) = interrupted(&parts, wait);
        match code {
            // A fast machine may have finished.
            Some(0) => break,
            _ => assert!(code == Some(130) && said.contains("parts.light holds"), "{code:?} {said}"),
        }
        assert!(folder.has("parts.light") && !folder.has("parts.glb") && !folder.has("parts.exr"));
        folder
            .run("render room.pbrt --integrator radiosity --light-in parts.light -o m.exr")
            .refused(1, &["parts.light", "not finished", "--resume"]);
    }
    folder.succeed(&parts);
    for (whole, parts) in
        [("whole.glb", "parts.glb"), ("whole.exr", "parts.exr"), ("whole.light", "parts.light")]
    {
        assert_eq!(folder.bytes(whole), folder.bytes(parts));
    }
}
