//! `--progress openjd`: messages of Open Job Description on the standard output.

use std::process::Command;

use crate::command_line::support::{Folder, finish, wait_until};

/// The texts of the messages of one kind, in order. A line that is no message fails the test.
fn texts(stdout: &str, kind: &str) -> Vec<String> {
    let messages = stdout.lines().map(|line| {
        let (name, text) = line.strip_prefix("openjd_").and_then(|line| line.split_once(": ")).expect(line);
        assert!(["progress", "status", "fail"].contains(&name) && !text.is_empty(), "{line}");
        (name, text.to_owned())
    });
    messages.filter(|(name, _)| *name == kind).map(|(_, text)| text).collect()
}

#[test]
fn progress_grows_to_the_end_and_the_status_says_what_is_done() {
    let folder = Folder::with_scene();
    folder.succeed("render small.pbrt -o a.png --samples 0..4 --checkpoint a.glanz --progress openjd");
    folder.succeed("render small.pbrt -o b.png --samples 4..8 --checkpoint b.glanz -q");
    for line in [
        "render small.pbrt -o c.png --progress openjd",
        "bake small.pbrt -o c.glb --texels-per-metre 1 --progress openjd",
        "illuminate small.pbrt --room 9 9 9 -o lux --rays 2000 -q --progress openjd",
        "merge a.glanz b.glanz -o c.png --progress openjd",
        "convert small.pbrt c.ply --progress openjd",
    ] {
        let stdout = folder.succeed(line).stdout;
        if line.contains(" -q ") {
            assert_eq!(stdout, "", "{line}");
            continue;
        }
        let numbers: Vec<f64> =
            texts(&stdout, "progress").iter().map(|number| number.parse().expect(number)).collect();
        assert!(numbers.is_sorted() && numbers.iter().all(|n| (0.0..=100.0).contains(n)), "{numbers:?}");
        assert_eq!(numbers.last(), Some(&100.0), "{line}");
        assert!(texts(&stdout, "status").last().is_some_and(|text| text.contains("c.")), "{stdout}");
        assert_eq!(texts(&stdout, "fail"), [""; 0], "{line}");
    }
}

#[test]
fn failure_is_the_sentence_of_the_error() {
    let folder = Folder::with_scene();
    folder.write(
        "bad.pbrt",
        "WorldBegin\nShape \"sphere\" \"float radius\" -1\nShape \"cone\" \"float radius\" -1\n",
    );
    for (line, code) in [
        ("render none.pbrt -o a.png", 1),
        ("render bad.pbrt -o a.png -q", 1),
        ("render small.pbrt -o a.tiff", 2),
        ("render small.pbrt -o a.png --sppp 3", 2),
        ("bake small.pbrt -o a.obj", 2),
        ("merge none.glanz -o a.png", 1),
    ] {
        let ran = folder.run(&format!("{line} --progress openjd"));
        assert_eq!(ran.code, Some(code), "{line}");
        let first = ran.stderr.lines().next().and_then(|line| line.strip_prefix("error: "));
        assert_eq!(texts(&ran.stdout, "fail"), [first.expect("an error")], "{line}");
    }
    let ran = folder.run("render small.pbrt -o a.png --json --progress openjd");
    ran.refused(2, &["--json", "--progress"]);
}

#[test]
fn interruption_is_a_failure() {
    let folder = Folder::with_scene();
    let line = "render small.pbrt -o a.png --spp 1000000 --checkpoint a.glanz --progress openjd";
    let child = folder.start(line);
    wait_until("the checkpoint", || folder.has("a.glanz"));
    Command::new("kill").args(["-TERM", &child.id().to_string()]).status().expect("kill");
    let ran = finish(child, line);
    assert_eq!(ran.code, Some(143), "{}", ran.stderr);
    assert_eq!(texts(&ran.stdout, "fail"), ["interrupted by a signal"]);
}
