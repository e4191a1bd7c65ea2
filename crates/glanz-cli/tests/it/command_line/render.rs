//! `glanz render` and `glanz demo`: files, messages, exit codes.

use crate::command_line::small_scene::SCENE;
use crate::command_line::support::Folder;

/// The largest difference of two pictures over R, G and B.
fn largest_difference(folder: &Folder, a: &str, b: &str) -> f32 {
    let (a, b) = (folder.picture(a).to_rgb().unwrap(), folder.picture(b).to_rgb().unwrap());
    assert_eq!(a.len(), b.len());
    a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

#[test]
fn every_format_holds_the_same_picture() {
    let folder = Folder::with_scene();
    folder.succeed("render small.pbrt -o a.exr -o a.hdr -o a.png -q");
    assert_eq!(folder.names(), ["a.exr", "a.hdr", "a.png", "small.pbrt"]);
    let linear = folder.picture("a.exr").to_rgb().unwrap();
    let brightest = linear.iter().flatten().fold(0.0_f32, |a, &b| a.max(b));
    assert!((3.0..6.0).contains(&brightest), "the lamp of radiance 4 is in sight: {brightest}");
    // RGBE counts a pixel in units of 1/256 of the power of two above its largest channel: 1/128 of that at most.
    assert!(largest_difference(&folder, "a.exr", "a.hdr") <= brightest / 128.0);
    // PNG rounds to 1/255 in sRGB, whose slope in linear light is below 2.3, after clipping to 1.
    let shown = folder.picture("a.png").to_rgb().unwrap();
    for (linear, shown) in linear.iter().flatten().zip(shown.iter().flatten()) {
        assert!(
            (linear.clamp(0.0, 1.0) - shown).abs() <= 2.3 * 0.5 / 255.0 + 1e-6,
            "{linear} shown as {shown}"
        );
    }
}

#[test]
fn scene_names_the_picture_if_nothing_else_does() {
    let folder = Folder::with_scene();
    folder.succeed("render small.pbrt --spp 1 -q");
    assert_eq!(folder.names(), ["small.exr", "small.pbrt"]);
}

#[test]
fn options_override_the_scene() {
    let folder = Folder::new();
    // A point light and no mirrors: the value at the pixel centre has no variance.
    folder.write(
        "fixed.pbrt",
        r#"LookAt 0 -6 2.5  0 0 0.8  0 0 1 Camera "perspective" Sampler "independent" Integrator "path"
        WorldBegin LightSource "point" "point3 from" [1 -2 5] "rgb I" [20 20 20] Shape "sphere""#,
    );
    let ran = folder.succeed(
        "render fixed.pbrt -o a.exr --size 10x6 --spp 3 --integrator whitted --sampler center --seed 7 --threads 1 --json",
    );
    let pixels = folder.picture("a.exr");
    assert_eq!((pixels.width(), pixels.height()), (10, 6));
    let report = ran.json();
    assert_eq!((&report["samples"], &report["threads"]), (&(10 * 6 * 3).into(), &1.into()));
    assert_eq!((&report["sampler"], &report["seed"]), (&"center".into(), &7.into()));
    // Every sample of `center` is the same here, so any number of them gives the picture of one.
    folder.succeed("render fixed.pbrt -o b.exr --size 10x6 --spp 1 --integrator whitted --sampler center -q");
    assert!(largest_difference(&folder, "a.exr", "b.exr") < 1e-5);
    folder.succeed("render fixed.pbrt -o c.exr --size 10x6 --spp 1 -q");
    assert!(
        largest_difference(&folder, "a.exr", "c.exr") > 0.01,
        "the scene's own sampler gives another picture"
    );
}

#[test]
fn extra_channels_describe_what_the_camera_sees() {
    let folder = Folder::new();
    // A parallel view along +z on a disk at z = 5 that fills the picture.
    folder.write(
        "disk.pbrt",
        r#"Camera "orthographic" Film "rgb" "integer xresolution" 4 "integer yresolution" 4
        WorldBegin LightSource "infinite" "rgb L" [1 1 1]
        Material "diffuse" "rgb reflectance" [0.25 0.5 0.75]
        Shape "disk" "float radius" 9 "float height" 5"#,
    );
    folder.succeed("render disk.pbrt -o a.exr --aov all --spp 4 -q");
    let pixels = folder.picture("a.exr");
    let channel = |name: &str| pixels.channel(name).unwrap_or_else(|| panic!("no channel {name}")).to_vec();
    for (name, value) in [
        ("Albedo.R", 0.25),
        ("Albedo.G", 0.5),
        ("Albedo.B", 0.75),
        ("P.Z", 5.0),
        ("Z", 5.0),
        ("N.X", 0.0),
        ("Ns.Y", 0.0),
        ("id", 0.0),
        // A diffuse plane under a sky of radiance 1 reflects its albedo.
        ("R", 0.25),
        ("B", 0.75),
    ] {
        for found in channel(name) {
            let bound = if name.len() == 1 && name != "Z" { 0.05 } else { 1e-6 };
            assert!((found - value).abs() <= bound, "{name} is {found}, not {value}");
        }
    }
    assert!(channel("N.Z").iter().all(|z| z.abs() == 1.0));
    assert!(channel("Variance.R").iter().all(|v| (0.0..0.01).contains(v)));
    assert!(channel("u").len() == 16 && channel("v").len() == 16);
    assert!(channel("P.X").iter().any(|&x| x < -0.5) && channel("P.X").iter().any(|&x| x > 0.5));

    folder.succeed("render disk.pbrt -o b.exr --aov Z,n --spp 1 -q");
    let names: Vec<String> = folder.picture("b.exr").channels().iter().map(|c| c.name.clone()).collect();
    assert!(names.contains(&"Z".to_owned()) && names.contains(&"N.X".to_owned()));
    assert_eq!(names.len(), 7, "{names:?}");
}

#[test]
fn report_is_one_object_with_the_figures_of_the_run() {
    let folder = Folder::with_scene();
    let ran = folder.succeed("render small.pbrt -o a.png --spp 2 --json");
    let report = ran.json();
    assert_eq!(report["outputs"], serde_json::json!(["a.png"]));
    assert_eq!(report["samples"], 24 * 18 * 2);
    assert_eq!(report["samples_per_pixel"], 2);
    assert_eq!(report["interrupted"], false);
    let number = |name: &str| report[name].as_f64().unwrap_or_else(|| panic!("{name} in {report}"));
    assert!(number("seconds") > 0.0);
    assert!(number("rays") >= number("samples"), "every sample sends a ray");
    assert!((number("rays_per_second") * number("seconds") / number("rays") - 1.0).abs() < 1e-6);
    assert!(report["warnings"].is_array());
    if cfg!(target_os = "linux") {
        assert!(number("peak_memory_bytes") > 1e6);
    }
}

#[test]
fn quiet_prints_nothing_and_otherwise_the_outputs_are_named() {
    let folder = Folder::with_scene();
    let quiet = folder.succeed("render small.pbrt -o a.png --spp 1 --quiet");
    assert_eq!((quiet.stdout.as_str(), quiet.stderr.as_str()), ("", ""));
    let plain = folder.succeed("render small.pbrt -o a.png --spp 1");
    assert_eq!(plain.stdout, "");
    assert!(plain.stderr.contains("a.png"), "{}", plain.stderr);
    assert!(!plain.stderr.contains('\x1b'), "no colours where there is no terminal");
}

#[test]
fn time_limit_ends_the_render() {
    let folder = Folder::with_scene();
    let ran = folder.succeed("render small.pbrt -o a.png --time 0.5 --json -q");
    let seconds = ran.json()["seconds"].as_f64().unwrap();
    assert!(seconds < 20.0, "{seconds}");
    assert!(ran.json()["samples_per_pixel"].as_u64().unwrap() >= 1);
    assert!(folder.has("a.png"));
}

#[test]
fn wrong_usage_is_two_and_failure_is_one() {
    let folder = Folder::with_scene();
    for line in ["", "paint", "render", "render small.pbrt --spp x", "render small.pbrt --resume", "merge a"]
    {
        let ran = folder.run(line);
        assert_eq!(ran.code, Some(2), "glanz {line}: {}", ran.stderr);
    }
    folder.run("render small.pbrt -o a.tiff").refused(2, &["a.tiff", "help:", ".exr"]);
    folder.run("render small.pbrt -o a").refused(2, &["help:"]);
    folder.run("render small.pbrt -o a.png -o a.png").refused(2, &["two outputs"]);
    folder.run("render small.pbrt --integrator photon -o a.png").refused(2, &["photon", "path", "whitted"]);
    folder.run("render small.pbrt --sampler dice -o a.png").refused(2, &["dice", "sobol"]);
    folder.run("render small.pbrt --aov beauty -o a.exr").refused(2, &["beauty", "Albedo"]);
    folder.run("render nothing.pbrt -o a.png").refused(1, &["nothing.pbrt"]);
    folder.run("render small.pbrt -o missing/a.png").refused(1, &["missing/a.png", "help:"]);
    assert_eq!(folder.names(), ["small.pbrt"], "a refused command leaves nothing behind");
    for line in ["--help", "--version", "render --help", "help merge"] {
        let ran = folder.succeed(line);
        assert!(!ran.stdout.is_empty() && ran.stderr.is_empty());
    }
}

#[test]
fn missing_denoising_library_is_refused_before_the_scene_is_rendered() {
    let folder = Folder::with_scene();
    let nowhere = folder.path("nothing").display().to_string();
    let ran = folder.run_with(&[("OIDN_DIR", &nowhere)], "render small.pbrt --denoise -o m.png");
    ran.refused(1, &["--denoise: ", "was not found", "OIDN_DIR"]);
    assert!(!folder.has("m.png"));
}

#[test]
fn strict_takes_warnings_as_errors() {
    let folder = Folder::new();
    folder.write("odd.pbrt", SCENE.replace("Material \"diffuse\"", "Material \"velvet\""));
    let lenient = folder.succeed("render odd.pbrt -o a.png --spp 1 --json");
    assert!(
        lenient.stderr.contains("warning: odd.pbrt:") && lenient.stderr.contains("velvet"),
        "{}",
        lenient.stderr
    );
    assert!(!lenient.json()["warnings"].as_array().unwrap().is_empty());
    folder.run("render odd.pbrt -o b.png --spp 1 --strict").refused(1, &["odd.pbrt:", "velvet", "^"]);
    assert!(!folder.has("b.png"));
}

#[test]
fn demo_is_rendered_as_a_scene_file_would_be() {
    let folder = Folder::new();
    let ran = folder.succeed("demo --size 32x18 --spp 1 --strict");
    assert_eq!(folder.names(), ["glanz-demo.png"]);
    assert!(ran.stderr.contains("glanz-demo.png"), "{}", ran.stderr);
    assert!(!ran.stderr.contains("warning"), "{}", ran.stderr);
    let shown = folder.picture("glanz-demo.png").to_rgb().unwrap();
    assert_eq!(shown.len(), 32 * 18);
    assert!(shown.iter().any(|p| p[0] > 0.5) && shown.iter().any(|p| p[0] < 0.1), "light and shadow");
}
