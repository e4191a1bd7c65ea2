//! `glanz optimize`.

use crate::command_line::support::Folder;

fn scene(name: &str) -> String {
    let path = format!("{}/../../scenes/design/{name}.pbrt", env!("CARGO_MANIFEST_DIR"));
    std::fs::read_to_string(path).unwrap()
}

#[test]
fn bent_paraboloid_is_found_again_and_its_light_fills_the_screen() {
    let folder = Folder::new();
    folder.write("bent.pbrt", scene("bent_paraboloid"));
    let report = folder.succeed("optimize bent.pbrt -o found.pbrt --rays 2000 --json").json();
    let angle = |key: &str| report[key][0]["angle"].as_f64().unwrap();
    assert!(angle("targets_before") > 0.02 && angle("targets") < 1e-5, "{report}");
    assert_eq!((&report["by_gradient"], &report["complete"]), (&true.into(), &true.into()));
    // The heights of the scene's comment, with all else as it was.
    let found = String::from_utf8(folder.bytes("found.pbrt")).unwrap();
    let numbers = |text: &str| -> Vec<f64> {
        let list = text.split("\"point3 P\" [").nth(1).unwrap().split(']').next().unwrap();
        list.split_whitespace().map(|word| word.parse().unwrap()).collect()
    };
    let (before, after) = (scene("bent_paraboloid"), numbers(&found));
    assert_eq!(found.split("\"point3 P\" [").next(), before.split("\"point3 P\" [").next());
    for (point, [x, y, z]) in after.as_chunks::<3>().0.iter().enumerate() {
        let inner = |i: usize| if i.is_multiple_of(3) { 1.0 } else { -1.0 / 3.0 };
        let height = 0.025 * (inner(point % 4) + inner(point / 4));
        assert!((z - height).abs() < 1e-6, "{point}: {x} {y} {z} {height}");
    }
    // Particles: the light on the mirror, the solid angle of 0.2 x 0.2 m, is on the screen, most of it within 0.2 x 0.2 m.
    let report = folder.succeed("illuminate found.pbrt --rays 200000 -o lux --json").json();
    let lit = report["designs"][0]["receivers"][0]["flux_lm"].as_f64().unwrap();
    let report = folder.succeed("illuminate bent.pbrt --rays 200000 -o bent --json").json();
    let bent = report["designs"][0]["receivers"][0]["flux_lm"].as_f64().unwrap();
    assert!(lit > 150.0 && bent < 0.1 * lit, "{lit} {bent}");
}

#[test]
fn flat_mirror_lights_a_rectangle_evenly() {
    let folder = Folder::new();
    folder.write("flat.pbrt", scene("even_rectangle"));
    folder.succeed("optimize flat.pbrt -o even.pbrt --rays 8000 --steps 150 -q");
    let report = folder.succeed("illuminate even.pbrt --rays 2000000 -o lux --json").json();
    let receiver = &report["designs"][0]["receivers"][0];
    let uniformity = receiver["u0"].as_f64();
    let flux = receiver["flux_lm"].as_f64().unwrap();
    assert!(uniformity.is_some_and(|u0| u0 > 0.8) && flux > 0.7 * 1000.0, "{receiver}");
}

#[test]
fn checkpoint_resumes_and_what_cannot_be_optimised_is_refused_with_advice() {
    let folder = Folder::new();
    folder.write("bent.pbrt", scene("bent_paraboloid"));
    let line = "optimize bent.pbrt --rays 500 -q";
    folder.succeed(&format!("{line} -o whole.pbrt --steps 90"));
    folder.succeed(&format!("{line} -o part.pbrt --steps 60 --checkpoint state"));
    folder.run(&format!("{line} -o again.pbrt --checkpoint state")).refused(1, &["state", "--resume"]);
    folder.succeed(&format!("{line} -o resumed.pbrt --steps 90 --checkpoint state --resume"));
    assert_eq!(folder.bytes("whole.pbrt"), folder.bytes("resumed.pbrt"));
    folder
        .run(&format!("{line} --seed 1 -o a.pbrt --checkpoint state --resume"))
        .refused(1, &["state", "seed"]);
    folder.run("optimize bent.pbrt -o bent.pbrt").refused(2, &["bent.pbrt", "input"]);
    folder.run("optimize bent.pbrt -o found.glb").refused(2, &["found.glb", ".pbrt"]);
    let without = |word: &str, name: &str| folder.write(name, scene("bent_paraboloid").replace(word, "# "));
    without("\"string free\"", "fixed.pbrt");
    folder.run("optimize fixed.pbrt -o a.pbrt").refused(1, &["fixed.pbrt", "string free"]);
    without("  \"string target\"", "idle.pbrt");
    folder.run("optimize idle.pbrt -o a.pbrt").refused(1, &["idle.pbrt", "string target"]);
    without("LightSource", "dark.pbrt");
    folder.run("optimize dark.pbrt -o a.pbrt").refused(1, &["dark.pbrt", "gives light"]);
}
