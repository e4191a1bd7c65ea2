//! `glanz info`, `compare`, `completions` and `man`.

use crate::command_line::support::Folder;

#[test]
fn info_counts_the_contents_of_a_scene() {
    let folder = Folder::with_scene();
    let info = folder.succeed("info small.pbrt --json").json();
    assert_eq!(info["shapes"]["sphere"], 2);
    assert_eq!(info["shapes"]["cylinder"], 1);
    assert_eq!(info["shapes"]["disk"], 2);
    assert_eq!(info["lights"].as_object().unwrap().values().map(|n| n.as_u64().unwrap()).sum::<u64>(), 3);
    assert_eq!(info["units"], "metres");
    assert_eq!(info["resolution"], serde_json::json!([24, 18]));
    // The ground reaches from -20 to 20, the light is at a height of 4.
    let corner = |name: &str, axis: usize| info["bounds"][name][axis].as_f64().unwrap();
    assert!((corner("min", 0) + 20.0).abs() < 1e-3 && (corner("max", 1) - 20.0).abs() < 1e-3);
    assert!((corner("max", 2) - 4.0).abs() < 1e-3);
    assert_eq!(info["warnings"], serde_json::json!([]));

    let text = folder.succeed("info small.pbrt").stdout;
    assert!(text.contains("sphere") && text.contains("metres"), "{text}");
    folder.run("info none.pbrt").refused(1, &["none.pbrt"]);
}

#[test]
fn compare_measures_and_judges() {
    let folder = Folder::with_scene();
    folder.succeed("render small.pbrt -o a.exr -q");
    folder.succeed("render small.pbrt -o b.exr --seed 3 -q");
    let equal = folder.succeed("compare a.exr a.exr --json --fail-above 0").json();
    for name in ["rmse", "relmse", "display_rmse", "max", "flip"] {
        assert_eq!(equal[name], 0.0, "{name}");
    }
    let differing = folder.succeed("compare a.exr b.exr --json").json();
    let measure = |name: &str| differing[name].as_f64().unwrap();
    let (a, b) = (folder.picture("a.exr").to_rgb().unwrap(), folder.picture("b.exr").to_rgb().unwrap());
    let squares: Vec<f64> =
        a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| f64::from(a - b).powi(2)).collect();
    let rmse = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
    assert!((measure("rmse") / rmse - 1.0).abs() < 1e-6);
    assert!((measure("max") - squares.iter().fold(0.0_f64, |m, &s| m.max(s)).sqrt()).abs() < 1e-6);
    assert!((0.0..=1.0).contains(&measure("flip")) && measure("relmse") > 0.0);

    for metric in ["rmse", "relmse", "display-rmse", "max", "flip"] {
        let value = measure(&metric.replace('-', "_"));
        folder.succeed(&format!("compare a.exr b.exr --metric {metric} --fail-above {}", value * 1.01));
        let ran = folder.run(&format!("compare a.exr b.exr --metric {metric} --fail-above {}", value * 0.99));
        assert_eq!(ran.code, Some(1), "{metric}: {}", ran.stderr);
    }

    folder.succeed("render small.pbrt -o small.png --size 8x6 --spp 1 -q");
    folder.run("compare a.exr small.png").refused(1, &["24", "8"]);
    folder.write("no.exr", "no picture");
    folder.run("compare a.exr no.exr").refused(1, &["no.exr"]);
    // Each picture has 432 pixels.
    folder
        .run("compare a.exr b.exr --limit pixels=500")
        .refused(1, &["b.exr: ", "the limit of 500 pixels", "raise it with --limit pixels=1000"]);
    folder.run("compare a.exr b.exr --memory 1K").refused(1, &["a.exr: ", "raise it with --memory"]);
}

#[test]
fn completions_and_manual_come_from_the_same_definition() {
    let folder = Folder::new();
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let script = folder.succeed(&format!("completions {shell}")).stdout;
        assert!(script.contains("checkpoint") && script.contains("compare"), "{shell}");
    }
    let manual = folder.succeed("man").stdout;
    assert!(manual.contains(".TH glanz") && manual.contains("render") && manual.contains("merge"));
    let manual = folder.succeed("man render").stdout;
    assert!(manual.contains("\\-\\-checkpoint") && manual.contains("SCENE"));
    folder.run("man paint").refused(2, &["paint"]);
    let help = folder.succeed("--help").stdout;
    assert!(!help.contains("completions"), "{help}");
}

#[test]
fn studies_are_named_as_a_program_of_their_own() {
    Folder::new()
        .run("study newton --out a")
        .refused(2, &["studies", "cargo run --release -p glanz-study -- newton"]);
}
