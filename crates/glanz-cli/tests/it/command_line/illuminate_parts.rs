//! Parts of `glanz illuminate` and `glanz merge` of them.

use crate::command_line::support::Folder;

/// A small lamp, from which light escapes, above a room of mirrors and plates.
const LAMP: &str = r#"
WorldBegin
LightSource "point" "rgb I" [1 1 1] "point3 from" [1 1 1]
Material "conductor"
Translate 1 1 .5
Shape "disk" "float radius" .25 "string receiver" "a shelf" "integer cells" [4 4]
"#;

const LINE: &str = "illuminate lamp.pbrt --cells 4 -q --rays 20001 --far-field far.ldt";

/// The report without the lines of how long it took.
fn numbers(folder: &Folder, name: &str) -> serde_json::Value {
    let report: serde_json::Value = serde_json::from_slice(&folder.bytes(name)).unwrap();
    serde_json::json!([report["receivers"], report["flux_balance"]])
}

fn parts(folder: &Folder, count: u32) {
    for number in 1..=count {
        let threads = 1 + number % 2;
        folder.succeed(&format!(
            "{LINE} --part {number}/{count} --checkpoint {number}-{count}.lux --threads {threads}"
        ));
    }
    assert!(!folder.has("far.ldt"));
}

#[test]
fn merged_parts_give_the_files_of_one_run() {
    let folder = Folder::new();
    folder.write("lamp.pbrt", LAMP);
    for count in [1, 3, 7] {
        parts(&folder, count);
        // In any order.
        let names: Vec<String> = (1..=count).rev().map(|number| format!("{number}-{count}.lux")).collect();
        let merged =
            folder.succeed(&format!("merge {} --checkpoint whole-{count}.lux --json", names.join(" ")));
        assert_eq!(merged.json()["particles"], 20_001);
        assert_eq!(merged.json()["particle_ranges"], "0..20001");
    }
    // A tree of merges.
    folder.succeed("merge 1-7.lux 4-7.lux 7-7.lux --checkpoint group-1.lux --partial");
    folder.succeed("merge 2-7.lux 3-7.lux 5-7.lux 6-7.lux --checkpoint group-2.lux --partial");
    folder.succeed("merge group-1.lux group-2.lux --checkpoint tree.lux");
    assert_eq!(folder.bytes("tree.lux"), folder.bytes("whole-7.lux"));
    folder.succeed(&format!("{LINE} -o one --threads 1"));
    let far = folder.bytes("far.ldt");
    assert!(folder.bytes("whole-1.lux") != folder.bytes("whole-3.lux"), "the parts are stored");
    for count in [1, 3, 7] {
        let before = folder.bytes(&format!("whole-{count}.lux"));
        folder.succeed(&format!("{LINE} -o joined --checkpoint whole-{count}.lux --resume"));
        for name in ["a-shelf.csv", "a-shelf.exr", "a-shelf.png", "a-shelf.svg"] {
            assert_eq!(
                folder.bytes(&format!("joined/{name}")),
                folder.bytes(&format!("one/{name}")),
                "{count} {name}"
            );
        }
        assert_eq!(numbers(&folder, "joined/report.json"), numbers(&folder, "one/report.json"));
        assert_eq!(folder.bytes("far.ldt"), far);
        // No particle was traced.
        assert_eq!(folder.bytes(&format!("whole-{count}.lux")), before);
    }
}

#[test]
fn reports_of_equal_calculations_are_equal_where_the_date_is_fixed() {
    let folder = Folder::new();
    folder.write("lamp.pbrt", LAMP);
    let succeed = |line: &str| {
        let ran = folder.run_with(&[("SOURCE_DATE_EPOCH", "951782400")], line);
        assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    };
    parts(&folder, 3);
    succeed(&format!("{LINE} -o one --threads 1"));
    succeed(&format!("{LINE} -o two --threads 2"));
    succeed("merge 1-3.lux 2-3.lux 3-3.lux --checkpoint whole.lux");
    succeed(&format!("{LINE} -o merged --checkpoint whole.lux --resume"));
    for name in ["report.json", "report.html", "summary.txt"] {
        let one = folder.bytes(&format!("one/{name}"));
        assert!(String::from_utf8_lossy(&one).contains("2000-02-29T00:00:00Z"), "{name}");
        for other in ["two", "merged"] {
            assert!(folder.bytes(&format!("{other}/{name}")) == one, "{other}/{name}");
        }
    }
    folder.succeed(&format!("{LINE} -o now"));
    let facts = |name: &str| {
        let report: serde_json::Value = serde_json::from_slice(&folder.bytes(name)).unwrap();
        report["facts"].clone()
    };
    let (fixed, now) = (facts("one/report.json"), facts("now/report.json"));
    for key in ["seconds", "threads", "particles_per_second", "rays"] {
        assert!(fixed.get(key).is_none() && now[key].is_number(), "{key}");
    }
    assert!(now["end_utc"].as_str() > fixed["end_utc"].as_str());
}

#[test]
fn parts_that_are_missing_doubled_foreign_or_damaged_are_named() {
    let folder = Folder::new();
    folder.write("lamp.pbrt", LAMP);
    parts(&folder, 3);
    folder
        .run("merge 1-3.lux 3-3.lux --checkpoint w.lux")
        .refused(1, &["part 2/3 (particles 6 667..13 334) is missing", "--partial"]);
    folder
        .run("merge 1-3.lux 2-3.lux 1-3.lux --checkpoint w.lux")
        .refused(1, &["1-3.lux and 1-3.lux both have particles 0 to 6 666"]);
    folder.run("merge 1-3.lux 2-3.lux 3-3.lux -o w.png").refused(1, &["illuminate", "--resume"]);
    folder.succeed(&format!("{LINE} --part 2/4 --checkpoint 2-4.lux"));
    folder
        .run("merge 1-3.lux 2-4.lux --checkpoint w.lux")
        .refused(1, &["the number of parts is 3 in 1-3.lux"]);
    for (option, words) in [
        ("--seed 5", "the seed"),
        ("--max-depth 3", "the depth"),
        ("--room 2 2 2", "the scene"),
        ("--resolution 9", "the far field"),
    ] {
        folder.succeed(&format!("{LINE} {option} --part 2/3 --checkpoint other.lux"));
        folder
            .run("merge 1-3.lux other.lux --checkpoint w.lux")
            .refused(1, &["1-3.lux and other.lux", words]);
        std::fs::remove_file(folder.path("other.lux")).unwrap();
    }
    let without = LINE.replace("--far-field far.ldt", "");
    folder.succeed(&format!("{without} --part 2/3 --checkpoint other.lux"));
    folder
        .run("merge 1-3.lux other.lux --checkpoint w.lux")
        .refused(1, &["the far field is counted on angles that adapt to the light in 1-3.lux"]);
    folder.succeed(&format!("{LINE} -o one --checkpoint one.lux"));
    folder.run("merge 1-3.lux one.lux --checkpoint w.lux").refused(1, &["one.lux is no part", "--part K/N"]);
    let mut flipped = folder.bytes("2-3.lux");
    let middle = flipped.len() / 2;
    flipped[middle] ^= 1;
    folder.write("bad.lux", &flipped);
    folder.run("merge 1-3.lux bad.lux 3-3.lux --checkpoint w.lux").refused(1, &["bad.lux", "damaged"]);
    assert!(!folder.has("w.lux"));
    // What is there can be joined, and completed.
    let merged = folder.succeed("merge 1-3.lux bad.lux 3-3.lux --checkpoint w.lux --partial --json");
    let warnings = merged.json()["warnings"].to_string();
    assert!(warnings.contains("bad.lux") && warnings.contains("part 2/3"), "{warnings}");
    let loud = LINE.replace(" -q", "");
    let rest = folder.succeed(&format!("{loud} -o rest --checkpoint w.lux --resume"));
    let [line] =
        rest.stdout.lines().filter(|line| line.starts_with("particles of this run")).collect::<Vec<_>>()[..]
    else {
        panic!("{}", rest.stdout)
    };
    assert!(line.ends_with("6 667"), "{line}");
    assert_eq!(numbers(&folder, "rest/report.json"), numbers(&folder, "one/report.json"));
}

#[test]
fn part_is_resumed_as_itself_only_and_has_a_number_of_particles() {
    let folder = Folder::new();
    folder.write("lamp.pbrt", LAMP);
    let part = folder.succeed(&format!("{LINE} --part 2/3 --checkpoint 2.lux --json")).json();
    assert_eq!(part["checkpoint"], "2.lux");
    let before = folder.bytes("2.lux");
    folder.succeed(&format!("{LINE} --part 2/3 --checkpoint 2.lux --resume"));
    assert_eq!(folder.bytes("2.lux"), before);
    folder
        .run(&format!("{LINE} --part 1/3 --checkpoint 2.lux --resume"))
        .refused(1, &["2.lux", "the part is 2/3, not 1/3"]);
    let line = "illuminate lamp.pbrt --part 1/3 --checkpoint new.lux";
    folder.run(line).refused(2, &["number of samples or particles", "--rays N"]);
    folder.run(&format!("{line} --rays 9 --time 5")).refused(2, &["--time"]);
    folder.run(&format!("{line} --rays 9 --error 0.1")).refused(2, &["--error"]);
    folder.run(&format!("{line} --rays 9 --compare lamp.pbrt -o d")).refused(2, &["--compare"]);
    for method in ["integrate", "both"] {
        folder
            .run(&format!("{line} --rays 9 --method {method}"))
            .refused(2, &["the integration over mirrors is one computation", "--method"]);
    }
    folder.run("illuminate lamp.pbrt --part 1/3 --rays 9").refused(2, &["--checkpoint"]);
    folder.run("illuminate lamp.pbrt --rays 9").refused(2, &["--output"]);
    assert!(!folder.has("new.lux"));
}
