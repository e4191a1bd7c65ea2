//! The program `glanz-study` from end to end, at sizes that take a second.

use crate::support::{Folder, finish, wait_until};

#[test]
fn studies_are_listed_with_one_line_each() {
    let folder = Folder::new();
    let ran = folder.succeed("");
    let names: Vec<&str> =
        ran.stdout.lines().filter_map(|line| line.split("  ").next()).map(str::trim).collect();
    assert!(names.contains(&"newton") && names.contains(&"tessellation"), "{}", ran.stdout);
    let listed = folder.succeed("--json").json();
    assert_eq!(listed.as_array().unwrap().len(), names.len());
    assert_eq!(listed[0]["name"], names[0]);
    assert!(folder.names().is_empty());
}

#[test]
fn study_newton_writes_a_report_determined_by_its_seed() {
    let folder = Folder::new();
    let json = folder.succeed("newton --out a --rays 3000 --json -q").json();
    assert_eq!(json["study"], "newton");
    for file in json["files"].as_array().unwrap() {
        assert!(folder.has(&format!("a/{}", file.as_str().unwrap())), "{file}");
    }
    // The published line misses, on the patch of document 000 it gives the published root.
    let example = json["tables"]["example"].as_array().unwrap();
    let published =
        example.iter().find(|row| row["start"] == "of 000" && row["method"] == "general Newton").unwrap();
    assert!((published["tau"].as_f64().unwrap() - 46.012_263_655_548_77).abs() < 1e-12);
    assert_eq!(published["inside"], "no");
    let fan = json["tables"]["fan"].as_array().unwrap();
    assert!(fan.iter().any(|row| row["method"] == "certified search" && row["inside"] == 1));

    let report = String::from_utf8(folder.bytes("a/report.md")).unwrap();
    assert!(report.contains("3 000 rays") && report.contains("](found.svg)"), "{report}");
    let row = &json["summary"][0];
    assert_eq!(
        row["found"].as_u64().unwrap() + row["missed"].as_u64().unwrap(),
        row["roots"].as_u64().unwrap()
    );

    let again = folder.succeed("newton --out b --rays 3000 --json").json();
    assert_eq!(folder.bytes("a/found.svg"), folder.bytes("b/found.svg"));
    assert_eq!(folder.bytes("a/example.csv"), folder.bytes("b/example.csv"));
    for key in ["found", "wrong_outside", "steps_mean", "evaluations_per_ray"] {
        assert_eq!(again["summary"][0][key], json["summary"][0][key], "{key}");
    }
    let other = folder.succeed("newton --out b --rays 3000 --seed 5");
    assert_ne!(folder.bytes("a/found.svg"), folder.bytes("b/found.svg"));
    assert!(
        other.stdout.contains("certified") && other.stderr.contains("wrote"),
        "{}{}",
        other.stdout,
        other.stderr
    );
}

#[test]
fn study_tessellation_compares_triangles_with_the_exact_surface() {
    let folder = Folder::new();
    let line = "tessellation --out t --size 96x54 --triangles 200,5000 --json -q";
    let json = folder.succeed(line).json();
    let rows = json["summary"].as_array().unwrap();
    assert_eq!(rows.len(), 6);
    let error = |row: usize, key: &str| rows[row][key].as_f64().unwrap();
    for key in ["normal_max_deg", "highlight_rmse"] {
        assert!(error(1, key) > 4.0 * error(2, key), "{key}");
    }
    assert!(rows[0]["highlight_rmse"].is_null() && rows[0]["triangles"].is_null());
    assert!(rows.iter().all(|row| row["memory_mb"].as_f64().unwrap() > 0.0));
    assert_eq!(folder.picture("t/exact_1.png").width(), 96);
    assert!(folder.has("t/error_time.svg") && folder.has("t/difference_3.png"));
}

#[test]
fn study_guiding_measures_a_room_and_resumes_from_its_cache() {
    let folder = Folder::new();
    folder.write(
        "box.pbrt",
        r#"LookAt 0 -.9 0  0 1 0  0 0 1  Camera "perspective" "float fov" 75  Integrator "path" "integer maxdepth" 4
           WorldBegin  Material "diffuse"  Shape "box" "point3 min" [ -1 -1 -1 ] "point3 max" [ 1 1 1 ]
           AreaLightSource "diffuse" "rgb L" [ 5 5 5 ]  Shape "sphere" "float radius" .3"#,
    );
    let line = "guiding --out g --rooms box.pbrt --size 12x8 --samples 8 --references 32 --time 0.02 --threads 1 --json -q";
    let json = folder.succeed(line).json();
    let summary = json["summary"].as_array().unwrap();
    assert_eq!((&summary[0]["method"], &summary[0]["light_sampling"]), (&"path".into(), &"no".into()));
    assert!(summary.iter().all(|row| row["samples"] == 8 && row["modified_l2"].as_f64().unwrap() > 0.0));
    assert!(
        folder.has("g/time_bases_box_chance.svg") && folder.picture("g/equal_time_box.png").width() > 900
    );
    assert_eq!(folder.succeed(line).json()["tables"], json["tables"]);
}

#[test]
fn study_reconstruction_makes_textures_of_elements() {
    let folder = Folder::new();
    let json = folder.succeed("reconstruction --out r --size 32x32 --json -q").json();
    assert_eq!(json["summary"].as_array().unwrap().len(), 12);
    // A step on borders of elements is kept by constant values alone.
    let on = json["tables"]["table_f_5"].as_array().unwrap();
    let error = |row: usize| on[row]["l2"].as_f64().unwrap();
    assert!(error(0) < 0.5 * error(1), "{on:?}");
    assert!(folder.has("r/step_natural.svg") && folder.picture("r/border_f_31.png").width() > 32);
}

#[test]
fn study_solvers_fits_exponents_in_a_room() {
    let folder = Folder::new();
    folder.write(
        "box.pbrt",
        r#"WorldBegin  Material "diffuse"  Shape "box" "point3 min" [ -1 -1 -1 ] "point3 max" [ 1 1 1 ]
           AreaLightSource "diffuse" "rgb L" [ 5 5 5 ]
           Shape "bilinearmesh" "point3 P" [ -.4 0 .8  -.4 .8 .8  .4 0 .8  .4 .8 .8 ]"#,
    );
    let json = folder.succeed("solvers --out s --rooms box.pbrt --elements 120 --json -q").json();
    let summary = json["summary"].as_array().unwrap();
    assert_eq!(summary.len(), 3);
    assert!(summary.iter().all(|row| row["room"] == "box" && row["rays_exponent"].as_f64().unwrap() > 0.5));
    assert!(folder.has("s/time_box.svg") && folder.has("s/convergence_box.svg"));
}

#[test]
fn wrong_usage_is_reported_before_the_work() {
    let folder = Folder::new();
    folder.run("newton --out a --size 8x8").refused(2, &["newton", "--size"]);
    folder.run("newton --out a --rooms open").refused(2, &["newton", "--rooms"]);
    folder.run("newton --out a --elements 9").refused(2, &["newton", "--elements"]);
    folder.run("guiding --out a --samples 12").refused(2, &["samples", "12", "power of two"]);
    folder.run("guiding --out a --rooms cellar").refused(2, &["rooms", "cellar.pbrt"]);
    folder
        .run("tessellation --out a --triangles 1251")
        .refused(2, &["triangles", "1251", "twice the square"]);
    folder.write("taken", "no folder");
    folder.run("newton --out taken").refused(1, &["taken"]);
}

#[cfg(unix)]
#[test]
fn an_interrupted_study_exits_with_130_and_leaves_no_report() {
    let folder = Folder::new();
    let line = "newton --out a --rays 6000000";
    let child = folder.start(line);
    // The folder is made when signals are listened to.
    wait_until("the folder", || folder.has("a"));
    let id = child.id().to_string();
    assert!(std::process::Command::new("kill").args(["-INT", &id]).status().unwrap().success());
    let ran = finish(child, line);
    assert_eq!(ran.code, Some(130), "{}", ran.stderr);
    assert!(ran.stderr.contains("nothing was written") && !folder.has("a/report.md"));
}
