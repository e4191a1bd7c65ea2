//! `glanz illuminate`.

use std::process::{Command, Stdio};

use glanz_formats::photometry::tm25::RayReader;
use glanz_math::DVec3;

use crate::PROGRAM;
use crate::command_line::support::{Folder, finish};

/// A point light of 1 cd in the middle of a room of 2 x 2 x 2 m, a small mirror, and a shelf that transmits light.
const LAMP: &str = r#"
WorldBegin
LightSource "point" "rgb I" [.0014641288 .0014641288 .0014641288] "point3 from" [1 1 1]
"#;

const SHELF: &str = r#"
Material "interface"
Translate 1 1 .5
Shape "disk" "float radius" .25 "string receiver" "a shelf" "integer cells" [4 4] "string receiverside" "front"
"#;

/// Numbers of a column of a CSV file.
fn column(text: &str, name: &str) -> Vec<f64> {
    let mut lines = text.lines();
    let at = lines.next().unwrap().split(',').position(|head| head.starts_with(name)).unwrap();
    lines.map(|line| line.split(',').nth(at).unwrap().parse().unwrap()).collect()
}

fn text(folder: &Folder, name: &str) -> String {
    String::from_utf8(folder.bytes(name)).unwrap()
}

#[test]
fn room_is_lit_as_a_point_lights_it_and_all_is_written() {
    let folder = Folder::new();
    folder.write("lamp.pbrt", [LAMP, SHELF].concat());
    let report =
        folder.succeed("illuminate lamp.pbrt --room 2 2 2 --cells 8 --rays 200000 -o lux --json").json();
    let design = &report["designs"][0];
    let receivers = design["receivers"].as_array().unwrap();
    let names: Vec<&str> = receivers.iter().map(|r| r["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["a shelf", "floor", "ceiling", "wall x=0", "wall x=2", "wall y=0", "wall y=2"]);
    // A sixth of 4 pi lm on every wall: the shelf blocks nothing.
    for receiver in &receivers[1..] {
        let flux = receiver["flux_lm"].as_f64().unwrap();
        assert!((flux / (4.0 * std::f64::consts::PI / 6.0) - 1.0).abs() < 0.01, "{receiver}");
        assert_eq!(receiver["cells"], serde_json::json!([8, 8]));
    }
    let balance = &design["flux_balance"];
    assert!(balance["closes_to"].as_f64().unwrap() < 1e-6);
    assert!((balance["emitted_lm"].as_f64().unwrap() - 4.0 * std::f64::consts::PI).abs() < 1e-4);
    for name in ["report.html", "report.json", "summary.txt"] {
        assert!(folder.has(&format!("lux/{name}")), "{name}");
    }
    for name in ["a-shelf", "floor", "wall-x=2"] {
        for extension in ["csv", "exr", "png", "svg"] {
            assert!(folder.has(&format!("lux/{name}.{extension}")), "{name}.{extension}");
        }
    }
    // 1 lx below the light, within the errors.
    let floor = text(&folder, "lux/floor.csv");
    let (lux, error) = (column(&floor, "illuminance"), column(&floor, "standard"));
    let (x, y) = (column(&floor, "x_m"), column(&floor, "y_m"));
    for cell in 0..64 {
        let r2 = (x[cell] - 1.0).powi(2) + (y[cell] - 1.0).powi(2);
        // The mean over the cell equals the value at its centre within 1 %.
        let expected = (1.0 + r2).powf(-1.5);
        assert!((lux[cell] - expected).abs() < 4.0 * error[cell] + 0.01, "{cell}: {} {expected}", lux[cell]);
    }
    let picture = folder.picture("lux/floor.exr");
    assert_eq!((picture.width(), picture.height()), (8, 8));
}

#[test]
fn reports_state_program_scene_settings_date_and_machine_in_their_types() {
    let folder = Folder::new();
    folder.write("lamp.pbrt", LAMP);
    let line = "illuminate lamp.pbrt --room 2 2 2.25 --cells 2 --method both --rays 5000 --error 1e-6 --tolerance 0.05 \
        --seed 7 --max-depth 9 --threads 2 -o lux --json";
    let facts = folder.succeed(line).json()["designs"][0]["facts"].take();
    let written: serde_json::Value = serde_json::from_slice(&folder.bytes("lux/report.json")).unwrap();
    assert_eq!(written["facts"], facts);
    let settings = serde_json::json!({
        "glanz_version": env!("CARGO_PKG_VERSION"), "scene": "lamp.pbrt", "method": "both", "cells_along_longer_side": 2,
        "room_m": [2.0, 2.0, 2.25], "relative_tolerance": 0.05, "goal_particles": 5000, "goal_relative_error": 1e-6,
        "seed": 7, "max_depth": 9, "far_field": false, "particles": 5000, "integrated_cells": 24, "scattering_materials": 1,
        "threads": 2, "complete": true,
    });
    for (key, value) in settings.as_object().unwrap() {
        assert_eq!(facts[key], *value, "{key}");
    }
    for key in ["seconds", "particles_per_second", "rays_per_second", "cells_per_second", "relative_error"] {
        assert!(facts[key].as_f64().unwrap() > 0.0, "{key}");
    }
    assert!(facts["rays"].as_u64().unwrap() >= 5000);
    let hash = facts["scene_content_hash"].as_str().unwrap();
    assert!(hash.len() == 32 && hash.bytes().all(|digit| digit.is_ascii_hexdigit()), "{hash}");
    // Dates of ISO 8601 sort as texts.
    let date = facts["end_utc"].as_str().unwrap();
    assert!(date.len() == 20 && date > "2020-01-01T00:00:00Z" && date < "3000", "{date}");
    if std::fs::read_to_string("/proc/cpuinfo").is_ok_and(|text| text.contains("model name")) {
        assert!(facts["processor"].as_str().is_some_and(|name| !name.is_empty()));
    }
    // People read the same.
    for name in ["lux/summary.txt", "lux/report.html"] {
        let report = text(&folder, name);
        for words in ["Glanz version", "lamp.pbrt", hash, "2 x 2 x 2.25 m", "5.000 %", "5 000", date] {
            assert!(report.contains(words), "{words} is not in {name}");
        }
    }
    folder.succeed("illuminate lamp.pbrt --room 2 2 2 --texel 0.5 --rays 100 --time 60 -o lux -q");
    let written: serde_json::Value = serde_json::from_slice(&folder.bytes("lux/report.json")).unwrap();
    let facts = &written["facts"];
    assert_eq!(
        [&facts["cell_m"], &facts["goal_seconds"], &facts["scene_content_hash"]],
        [&serde_json::json!(0.5), &serde_json::json!(60.0), &serde_json::json!(hash)]
    );
    assert!(facts.get("relative_tolerance").is_none() && facts.get("cells_along_longer_side").is_none());
}

#[test]
fn methods_agree_and_designs_are_compared() {
    let folder = Folder::new();
    let lamp = r#"
WorldBegin
AttributeBegin
  AreaLightSource "diffuse" "rgb L" [1 1 1]
  Translate 1 1 1.5
  Shape "sphere" "float radius" .1
AttributeEnd
Material "mirror" "rgb Kr" [.8 .8 .8]
"#;
    let mirror = |radius: &str| {
        format!("{lamp}\nTranslate 0.5 1 1\nRotate 60 0 1 0\nShape \"disk\" \"float radius\" {radius}\n")
    };
    folder.write("one.pbrt", mirror(".3"));
    folder.write("two.pbrt", mirror(".4"));
    let both = "illuminate one.pbrt --room 2 2 2 --cells 2 -q";
    let report = folder.succeed(&format!("{both} --rays 300000 -o both --method both --json")).json();
    let facts = &report["designs"][0]["facts"];
    assert_eq!([&facts["compared_cells"], &facts["cells_apart"]], [24, 0], "{facts}");
    assert!(facts["relative_flux_difference"].as_f64().unwrap().abs() < 0.01, "{facts}");
    assert!(folder.has("both/floor.csv") && folder.has("both/floor-integrated.csv"));

    let ran = folder
        .succeed("illuminate one.pbrt --compare two.pbrt --room 2 2 2 --cells 4 --error 0.05 -o designs");
    assert!(ran.stdout.contains("change") && ran.stdout.contains("wall x=2"), "{}", ran.stdout);
    for name in ["comparison.html", "comparison.txt", "a/report.html", "b/report.html", "b/floor.svg"] {
        assert!(folder.has(&format!("designs/{name}")), "{name}");
    }
}

#[test]
fn integration_names_materials_that_scatter() {
    let folder = Folder::new();
    let parts = |material: &str| {
        format!("{LAMP}Material {material}\nTranslate 1 1 .5\nShape \"sphere\" \"float radius\" .1")
    };
    for (material, scatters) in [
        ("\"mirror\"", false),
        ("\"mirror\" \"string finish\" \"gaussian\" \"float sigma\" .01", true),
        ("\"conductor\"", false),
        ("\"conductor\" \"float roughness\" .1", true),
        ("\"dielectric\"", false),
        ("\"dielectric\" \"float roughness\" .1", true),
        ("\"thindielectric\"", false),
        ("\"coateddiffuse\"", true),
        ("\"diffusetransmission\"", true),
        ("\"principled\"", true),
        ("\"matte\"", true),
    ] {
        folder.write("ball.pbrt", parts(material));
        let line = "illuminate ball.pbrt --room 2 2 2 --cells 1 -q -o ball --method integrate --json";
        let report = folder.succeed(line).json();
        let left_out = &report["designs"][0]["facts"]["scattering_materials"];
        // The walls of the room are one more.
        assert_eq!(*left_out, if scatters { 2 } else { 1 }, "{material}");
    }
}

#[test]
fn resumed_tally_has_the_same_bits() {
    let folder = Folder::new();
    folder.write("lamp.pbrt", LAMP);
    let line = "illuminate lamp.pbrt --room 2 2 2 --cells 4 -q";
    folder.succeed(&format!("{line} --rays 30000 -o whole --threads 1"));
    folder.succeed(&format!("{line} --rays 10000 -o part --checkpoint kept"));
    folder.run(&format!("{line} --rays 30000 -o parts --checkpoint kept")).refused(1, &["kept", "--resume"]);
    folder.succeed(&format!("{line} --rays 30000 -o parts --checkpoint kept --resume --threads 2"));
    assert_eq!(folder.bytes("whole/floor.csv"), folder.bytes("parts/floor.csv"));
    assert_ne!(folder.bytes("whole/floor.csv"), folder.bytes("part/floor.csv"));
    folder
        .run(&format!("{line} --seed 1 --rays 30000 -o parts --checkpoint kept --resume"))
        .refused(1, &["kept", "the seed is 0, not 1"]);
    folder
        .run(
            "illuminate lamp.pbrt --room 2 2 3 --cells 4 --rays 40000 -o parts --checkpoint kept --resume -q",
        )
        .refused(1, &["kept", "content hash"]);
    let mut flipped = folder.bytes("kept");
    let middle = flipped.len() / 2;
    flipped[middle] ^= 1;
    folder.write("kept", &flipped);
    folder.run(&format!("{line} --rays 40000 -o parts --checkpoint kept --resume")).refused(1, &["damaged"]);
}

#[test]
fn unusable_scenes_and_options_are_refused_with_advice() {
    let folder = Folder::new();
    folder.write("lamp.pbrt", LAMP);
    folder.write("dark.pbrt", "WorldBegin\nShape \"disk\" \"string receiver\" \"desk\"\n");
    let endless = "WorldBegin\nLightSource \"point\"\nShape \"plane\" \"string receiver\" \"sea\"\n";
    folder.write("endless.pbrt", endless);
    folder.run("illuminate lamp.pbrt -o lux").refused(1, &["nothing in this scene receives light", "--room"]);
    folder.run("illuminate dark.pbrt -o lux").refused(1, &["nothing in this scene gives light"]);
    folder.run("illuminate endless.pbrt -o lux").refused(1, &["sea", "no end"]);
    folder.run("illuminate lamp.pbrt --room 2 2 -o lux").refused(2, &["--room"]);
    folder.run("illuminate lamp.pbrt --room 2 2 0 -o lux").refused(2, &["above 0"]);
    folder.run("illuminate lamp.pbrt --far-field lamp.txt -o lux").refused(2, &["lamp.txt", ".ldt"]);
    folder.run("illuminate lamp.pbrt --room 2 2 2 --error 1e-9 -o lux").refused(2, &["--error"]);
}

#[test]
fn light_on_the_other_side_causes_a_warning() {
    let folder = Folder::new();
    let shelf = SHELF.replace("\"string receiverside\" \"front\"", "\"string receiverside\" \"back\"");
    folder.write("lamp.pbrt", [LAMP, &shelf].concat());
    let ran = folder.succeed("illuminate lamp.pbrt --rays 10000 -o lux");
    assert!(ran.stderr.contains("\"a shelf\"") && ran.stderr.contains("receiverside"), "{}", ran.stderr);
}

#[test]
fn narrow_beams_are_shown_by_default_and_reported_with_large_steps() {
    let folder = Folder::new();
    // A beam of 2 degrees.
    let spot = r#"
WorldBegin
LightSource "spot" "point3 to" [0 0 -1] "float coneangle" 1 "float conedeltaangle" 0
"#;
    folder.write("spot.pbrt", spot);
    let spot = folder.succeed("illuminate spot.pbrt --rays 500000 -o lux --far-field spot.ies");
    assert!(!spot.stderr.contains("too far"), "{}", spot.stderr);
    let told = folder.succeed("info spot.ies --json").json();
    let number = |value: &serde_json::Value| value.as_f64().unwrap();
    assert!((number(&told["beam_angle_degrees"][1]) - 2.0).abs() < 0.08, "{told}");
    assert!(number(&told["peak_direction_degrees"][1]) < 1.05, "{told}");
    let spot =
        folder.succeed("illuminate spot.pbrt --rays 500000 -o lux --far-field spot.ies --resolution 5x15");
    assert!(spot.stderr.contains("5.000 degrees apart, too far"), "{}", spot.stderr);
    let told = folder.succeed("info spot.ies --json").json();
    assert_eq!((&told["planes"], &told["gammas"]), (&25.into(), &37.into()));
    folder
        .run("illuminate spot.pbrt -o lux --far-field spot.ies --resolution 0.05")
        .refused(2, &["--resolution", "0.1 to 90"]);
    folder
        .run("illuminate spot.pbrt -o lux --far-field spot.ies --resolution 5xC")
        .refused(2, &["--resolution", "2.5x15"]);
    folder.run("illuminate spot.pbrt -o lux --resolution 1").refused(2, &["--far-field"]);
}

#[test]
fn far_field_of_a_lamp_is_written_as_photometric_files() {
    let folder = Folder::new();
    let lamp = r#"
WorldBegin
AreaLightSource "diffuse" "rgb L" [1 1 1]
Rotate 180 1 0 0
Shape "disk" "float radius" .1
"#;
    folder.write("lamp.pbrt", lamp);
    folder.succeed("illuminate lamp.pbrt --rays 1000000 -o lux --far-field lamp.ldt --far-field lamp.ies -q");
    // pi L A 683 lm of a plate of radius 0.1 m, all of it below.
    let flux = std::f64::consts::PI.powi(2) * 0.01 * 683.0;
    for name in ["lamp.ldt", "lamp.ies"] {
        let told = folder.succeed(&format!("info {name} --json")).json();
        let found = told["flux_lm"].as_f64().unwrap();
        assert!((found / flux - 1.0).abs() < 0.01, "{name}: {found}, not {flux}");
        let peak = told["peak_cd"].as_f64().unwrap();
        assert!((peak / (flux / std::f64::consts::PI) - 1.0).abs() < 0.08, "{name}: {peak}");
        // The file has the figures of the report.
        let report: serde_json::Value = serde_json::from_str(&text(&folder, "lux/report.json")).unwrap();
        let far = &report["far_field"];
        for (of_file, of_report) in [
            (found, &far["flux_lm"]),
            (found, &report["flux_balance"]["escaped_lm"]),
            (peak, &far["peak_cd"]),
        ] {
            assert!(
                (of_file / of_report.as_f64().unwrap() - 1.0).abs() < 1e-6,
                "{name}: {of_file}, {of_report}"
            );
        }
        for (key, number) in [("beam_angle_degrees", 120.0), ("field_angle_degrees", 168.5)] {
            let angle = told[key][0].as_f64().unwrap();
            assert!((angle - number).abs() < 4.0, "{name}: {key} {angle}");
        }
    }
    let summary = text(&folder, "lux/summary.txt");
    assert!(summary.contains("light that leaves the scene") && summary.contains("beam angle"), "{summary}");
    assert!(text(&folder, "lux/report.html").contains("C90"));
    let told = folder.succeed("info lamp.ldt --plot lamp.svg").stdout;
    assert!(told.contains("EULUMDAT") && told.contains("120 degrees in C0-C180"), "{told}");
    assert!(text(&folder, "lamp.svg").starts_with("<svg"));
    folder.write("bad.ldt", "maker\nx\n");
    folder.run("info bad.ldt").refused(1, &["bad.ldt:2:1"]);
    folder.run("info lamp.pbrt --plot lamp.svg").refused(2, &["--plot", ".ldt"]);
}

#[test]
fn rays_that_leave_a_scene_are_a_light_of_another() {
    let folder = Folder::new();
    let lamp = r#"
WorldBegin
AttributeBegin
  AreaLightSource "diffuse" "rgb L" [100 100 100]
  Translate 0 0 -.3
  Shape "disk" "float radius" .05
AttributeEnd
Material "mirror" "string finish" "gaussian" "float sigma" .05
Rotate 180 1 0 0
Shape "paraboloid" "float radius" .6 "float zmax" .3
"#;
    folder.write("lamp.pbrt", lamp);
    let steps = "--resolution 10x30 -q --json";
    let line = "illuminate lamp.pbrt --rays 200000 -o lux --ray-file lamp.tm25ray --far-field lamp.ldt";
    let report = folder.succeed(&format!("{line} {steps}")).json();
    let (facts, field) = (&report["designs"][0]["facts"], &report["designs"][0]["far_field"]);
    let number = |value: &serde_json::Value| value.as_f64().unwrap_or_else(|| panic!("{value}"));
    let outputs = report["outputs"].as_array().unwrap();
    assert!(outputs.iter().any(|output| output.as_str().is_some_and(|name| name.ends_with("lamp.tm25ray"))));
    let bytes = folder.bytes("lamp.tm25ray");
    let count = facts["ray_file_rays"].as_u64().unwrap();
    assert_eq!(bytes.len() as u64, 36_288 + 28 * count);
    let flux = number(&field["flux_lm"]);
    assert!((number(&facts["ray_file_lm"]) / flux - 1.0).abs() < 1e-6, "{facts} {field}");
    // All light of the lamp, which shines upwards within the rim, meets the mirror, and leaves it downwards.
    let rays = RayReader::new(&bytes[..]).unwrap();
    assert_eq!(rays.header().ray_count, count);
    let mut lumens = 0.0;
    for ray in rays.map(Result::unwrap) {
        let DVec3 { x, y, z } = ray.position;
        let above = z + 0.3 * (x * x + y * y) / 0.36;
        assert!(above.abs() < 1e-6 && ray.direction.z < 0.0, "{ray:?}");
        lumens += f64::from(ray.luminous_flux.unwrap());
    }
    assert!((lumens / flux - 1.0).abs() < 1e-6, "{lumens} {flux}");
    folder
        .write("rays.pbrt", "WorldBegin\nLightSource \"photometric\" \"string filename\" \"lamp.tm25ray\"\n");
    let again = format!("illuminate rays.pbrt --rays 400000 -o again --far-field again.ldt {steps}");
    let again = folder.succeed(&again).json()["designs"][0]["far_field"].clone();
    assert!((number(&again["flux_lm"]) / flux - 1.0).abs() < 1e-5, "{field} {again}");
    assert!((number(&again["peak_cd"]) / number(&field["peak_cd"]) - 1.0).abs() < 0.03, "{field} {again}");
    // The lamp is in the focus: the beam goes straight down, to the step of gamma.
    for far in [field, &again] {
        assert!(number(&far["peak_direction_degrees"][1]) < 10.5, "{far}");
    }

    let start = "illuminate lamp.pbrt -o lux --ray-file";
    folder.run(&format!("{start} lamp.tm25ray")).refused(2, &["--rays"]);
    folder.run(&format!("{start} lamp.rays --rays 9")).refused(2, &["lamp.rays", ".tm25ray"]);
    folder
        .run(&format!("{start} lamp.tm25ray --rays 9 --method integrate"))
        .refused(2, &["ray file", "--method"]);
    folder
        .run("illuminate lamp.pbrt --ray-file lamp.tm25ray --rays 9 --part 1/2 --checkpoint part")
        .refused(2, &["--part"]);
    folder
        .write("own.pbrt", "WorldBegin\nLightSource \"photometric\" \"string filename\" \"lamp.tm25ray\"\n");
    folder
        .run("illuminate own.pbrt -o lux --ray-file lamp.tm25ray --rays 9")
        .refused(2, &["lamp.tm25ray", "input"]);
    assert_eq!(folder.bytes("lamp.tm25ray"), bytes);
}

#[test]
fn scene_that_no_light_leaves_keeps_an_old_ray_file() {
    let folder = Folder::new();
    folder.write("lamp.pbrt", LAMP);
    folder.write("lamp.tm25ray", "old");
    let line =
        "illuminate lamp.pbrt --room 2 2 2 --cells 2 -o lux --rays 1000 --ray-file lamp.tm25ray --json";
    let ran = folder.succeed(line);
    assert!(
        ran.stderr.contains("no light leaves the scene") && ran.stderr.contains("--room"),
        "{}",
        ran.stderr
    );
    assert_eq!(folder.bytes("lamp.tm25ray"), b"old");
    assert_eq!(folder.names(), ["lamp.pbrt", "lamp.tm25ray", "lux"]);
    let report = ran.json();
    assert_eq!(report["designs"][0]["facts"]["ray_file_rays"], 0);
    let outputs = report["outputs"].as_array().unwrap();
    assert!(outputs.iter().all(|output| output != "lamp.tm25ray"), "{report}");
}

#[cfg(unix)]
#[test]
fn pipe_is_refused_as_a_ray_file() {
    let folder = Folder::new();
    folder.write("lamp.pbrt", LAMP);
    assert!(Command::new("mkfifo").arg(folder.path("lamp.tm25ray")).status().unwrap().success());
    let line = "illuminate lamp.pbrt -o lux --rays 9 --ray-file lamp.tm25ray";
    folder.run(line).refused(2, &["lamp.tm25ray", "pipe"]);
    assert!(!folder.has("lux"));
}

#[cfg(unix)]
#[test]
fn error_of_a_ray_file_does_not_cost_the_lux_results() {
    let folder = Folder::new();
    folder.write("lamp.pbrt", [LAMP, SHELF].concat());
    let line = "illuminate lamp.pbrt -o lux --rays 100000 --ray-file lamp.tm25ray -q --json";
    // Files of at most 1 MiB, in blocks of 512 bytes; rays of 28 bytes have more.
    let shell = ["-c", "trap '' XFSZ; ulimit -f 2048; exec \"$0\" \"$@\"", PROGRAM];
    let mut command = Command::new("sh");
    command.args(shell).args(line.split_whitespace()).current_dir(folder.path(""));
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    let ran = finish(command.spawn().unwrap(), line);
    ran.refused(1, &["lamp.tm25ray", "the other results are saved: lux/report.html and 6 more files"]);
    assert_eq!(folder.names(), ["lamp.pbrt", "lux"]);
    let report: serde_json::Value = serde_json::from_slice(&folder.bytes("lux/report.json")).unwrap();
    assert_eq!(report["receivers"][0]["name"], "a shelf");
    assert_eq!(ran.json()["designs"][0]["receivers"], report["receivers"]);
    let report = folder.succeed(line).json();
    let saved: serde_json::Value = serde_json::from_slice(&folder.bytes("lux/report.json")).unwrap();
    assert_eq!(saved["facts"]["ray_file_rays"], report["designs"][0]["facts"]["ray_file_rays"]);
    assert!(saved["facts"]["ray_file_rays"].as_u64().is_some_and(|count| count > 50_000), "{saved}");
}
