//! Parts of a picture: rendered by number, joined, named where they are missing, damaged or foreign.

use std::process::Command;

use crate::command_line::support::{Folder, finish};

impl Folder {
    /// Renders small parts 1 to `count` with these options into `part-K.glanz`, and returns their names.
    fn render_parts(&self, options: &str, count: u32) -> Vec<String> {
        let parts = (1..=count).map(|k| {
            let name = format!("part-{k}.glanz");
            self.succeed(&format!("render small.pbrt {options} --part {k}/{count} --checkpoint {name} -q"));
            name
        });
        parts.collect()
    }
}

const SMALL: &str = "--spp 8 --size 12x9 --aov all";

#[test]
fn numbered_parts_are_one_run_for_every_way_of_rendering() {
    let folder = Folder::with_scene();
    folder.succeed(
        "render small.pbrt --integrator guided --spp 16 --size 12x9 -o g.exr --guide-out g.guide -q",
    );
    for options in [
        "",
        "--integrator light",
        "--integrator sppm",
        "--integrator guided --guide-in g.guide",
        "--integrator distributed --spectral",
        "--sampler stratified",
    ] {
        let options = format!("{SMALL} {options}");
        folder.succeed(&format!("render small.pbrt {options} -o whole.exr --checkpoint one.glanz -q"));
        for count in [1, 3, 7] {
            let before = folder.names();
            let parts = folder.render_parts(&options, count);
            assert_eq!(folder.names().len(), before.len() + parts.len(), "a part makes no picture");
            folder.succeed(&format!("merge {} -o merged.exr --checkpoint whole.glanz -q", parts.join(" ")));
            assert_eq!(folder.bytes("merged.exr"), folder.bytes("whole.exr"), "{options}");
            assert_eq!(folder.bytes("whole.glanz"), folder.bytes("one.glanz"), "{options}");
            parts.iter().for_each(|part| folder.remove(part));
            folder.remove("merged.exr");
            folder.remove("whole.glanz");
        }
        folder.remove("one.glanz");
    }
}

#[test]
fn parts_are_resumed_and_their_limits_named() {
    let folder = Folder::with_scene();
    folder.succeed(&format!("render small.pbrt {SMALL} --part 2/3 --checkpoint p.glanz -o p.exr -q"));
    assert!(folder.has("p.exr"), "a picture that was asked for is written");
    let again =
        folder.succeed(&format!("render small.pbrt {SMALL} --part 2/3 --checkpoint p.glanz --resume --json"));
    assert_eq!((&again.json()["samples"], &again.json()["sample_ranges"]), (&0.into(), &"2..5".into()));
    // A range is divided as well: half of four samples.
    let range = format!("render small.pbrt {SMALL} --samples 20..24 --part 2/2 --checkpoint r.glanz --json");
    assert_eq!(folder.succeed(&range).json()["sample_ranges"], "22..24");
    for (options, words) in [
        ("--part 1/9", ["--part 1/9: the samples 0..8", "8 parts"]),
        ("--part 1/2 --integrator guided", ["--guide-out", "--guide-in"]),
        ("--part 1/2 --time 3", ["--part", "--time"]),
        ("--part 1/2 --noise 0.1", ["--part", "--noise"]),
        ("--part 0/2", ["K/N", "3/16"]),
    ] {
        let line = format!("render small.pbrt --spp 8 {options} --checkpoint x.glanz");
        let line = if options.contains("--time") { line.replace("--spp 8", "") } else { line };
        folder.run(&line).refused(2, &words);
    }
    folder.run("render small.pbrt --part 1/2").refused(2, &["--checkpoint"]);
    assert!(!folder.has("x.glanz"));
}

#[test]
fn missing_parts_are_named_or_rendered_later() {
    let folder = Folder::with_scene();
    folder.succeed(&format!("render small.pbrt {SMALL} -o whole.exr -q"));
    let parts = folder.render_parts(SMALL, 4);
    let [first, second, _, last] = &parts[..] else { panic!("four parts") };
    let some = format!("merge {last} {first} {second}");
    let sentence = "part 3/4 (samples 4..6) is missing";
    folder.run(&format!("{some} -o m.exr --checkpoint m.glanz")).refused(1, &[sentence, "--partial"]);
    folder.run(&format!("{some} none.glanz -o m.exr")).refused(1, &["none.glanz"]);
    assert!(!folder.has("m.exr") && !folder.has("m.glanz"));

    let ran = folder.succeed(&format!("{some} none.glanz -o m.exr --checkpoint m.glanz --partial --json"));
    assert!(ran.stderr.contains(&format!("warning: {sentence}")), "{}", ran.stderr);
    assert!(ran.stderr.contains("warning: none.glanz: "), "{}", ran.stderr);
    let report = ran.json();
    assert_eq!((&report["kind"], &report["parts"]), (&"picture".into(), &3.into()));
    assert_eq!((&report["samples"], &report["missing"][0]), (&"0..4, 6..8".into(), &sentence.into()));
    assert_ne!(folder.bytes("m.exr"), folder.bytes("whole.exr"));

    // What is missing is rendered into the joined checkpoint, as a part or with the whole, or joined with it.
    let joined = folder.bytes("m.glanz");
    for options in ["--part 3/4", ""] {
        folder.write("m.glanz", &joined);
        let line =
            format!("render small.pbrt {SMALL} {options} --checkpoint m.glanz --resume -o r.exr --json");
        assert_eq!(folder.succeed(&line).json()["samples"], 2 * 12 * 9);
        assert_eq!(folder.bytes("r.exr"), folder.bytes("whole.exr"), "{options}");
    }
    folder.write("m.glanz", &joined);
    folder.succeed("merge m.glanz part-3.glanz -o r.exr");
    assert_eq!(folder.bytes("r.exr"), folder.bytes("whole.exr"));
}

#[test]
fn merges_of_merges_are_one_run() {
    let folder = Folder::with_scene();
    folder.succeed(&format!("render small.pbrt {SMALL} -o whole.exr -q"));
    let parts = folder.render_parts(SMALL, 4);
    for (group, parts) in ["a", "b"].into_iter().zip(parts.chunks(2)) {
        folder.succeed(&format!("merge {} --checkpoint {group}.glanz --partial -q", parts.join(" ")));
    }
    folder.run("merge a.glanz -o tree.exr").refused(1, &["part 3/4 (samples 4..6) is missing; part 4/4"]);
    // Also with the film in a file.
    folder.succeed("merge b.glanz a.glanz -o tree.exr -q --memory 1K");
    assert_eq!(folder.bytes("tree.exr"), folder.bytes("whole.exr"));
}

#[test]
fn damaged_parts_are_named_or_left_out() {
    let folder = Folder::with_scene();
    let parts = folder.render_parts(SMALL, 3);
    let others = format!("{} {}", parts[2], parts[0]);
    folder.succeed(&format!("merge {others} -o rest.exr --partial -q"));
    let part = folder.bytes(&parts[1]);
    let mut damaged = Vec::new();
    // Magic, version, length, identity, the middle of the sums, and the checksum.
    for at in [3, 8, 12, 20, 60, part.len() / 2, part.len() - 2] {
        let mut bytes = part.clone();
        bytes[at] ^= 1;
        damaged.push(bytes);
    }
    damaged.extend([0, 6, 50, part.len() - 1].map(|end| part[..end].to_vec()));
    damaged.push([part.as_slice(), b"x"].concat());
    for bytes in damaged {
        folder.write("bad.glanz", &bytes);
        let line = format!("merge {} bad.glanz {} -o m.exr --checkpoint m.glanz", parts[2], parts[0]);
        folder.run(&line).refused(1, &["error: bad.glanz: "]);
        assert!(!folder.has("m.exr") && !folder.has("m.glanz"));
        let ran = folder.succeed(&format!("{line} --partial"));
        assert!(ran.stderr.contains("warning: bad.glanz: "), "{}", ran.stderr);
        assert!(ran.stderr.contains("part 2/3 (samples 2..5) is missing"), "{}", ran.stderr);
        assert_eq!(folder.bytes("m.exr"), folder.bytes("rest.exr"));
        folder.remove("m.exr");
        folder.remove("m.glanz");
    }
    let ran = folder.run("merge none.glanz bad.glanz -o m.exr --partial -q");
    ran.refused(1, &["no parts"]);
}

#[test]
fn foreign_parts_and_parts_given_twice_are_named_also_without_the_missing_ones() {
    let folder = Folder::with_scene();
    let parts = folder.render_parts(SMALL, 2);
    let [first, second] = &parts[..] else { panic!("two parts") };
    std::fs::copy(folder.path(first), folder.path("again.glanz")).unwrap();
    let scene = crate::command_line::small_scene::SCENE.replace("fov\" 35", "fov\" 36");
    folder.write("other.pbrt", scene);
    folder.succeed(&format!("render other.pbrt {SMALL} --part 2/2 --checkpoint other.glanz -q"));
    folder.write("tally.glanz", b"GLANZLUX and more");
    for partial in ["", "--partial"] {
        let run = |parts: &str| folder.run(&format!("merge {parts} -o m.exr {partial}"));
        let twice = [first, "again.glanz both have samples 0 to 3"];
        run(&format!("{first} {second} again.glanz")).refused(1, &twice);
        run(&format!("{first} {first}")).refused(1, &["both have samples 0 to 3"]);
        run(&format!("{first} other.glanz")).refused(1, &[first, "other.glanz", "the scene", "same scene"]);
        run(&format!("{first} tally.glanz")).refused(1, &[first, "tally.glanz", "illuminance", "each kind"]);
        run("tally.glanz").refused(1, &["illuminance", "--checkpoint WHOLE", "glanz illuminate"]);
        assert!(!folder.has("m.exr"));
    }
}

#[cfg(unix)]
#[test]
fn parts_are_read_from_pipes_and_interrupted_merges_write_nothing() {
    let folder = Folder::with_scene();
    folder.succeed(&format!("render small.pbrt {SMALL} -o whole.exr -q"));
    let parts = folder.render_parts(SMALL, 2);
    let feed = |parts: &[String], interrupted: Option<u32>| {
        parts.iter().for_each(|part| {
            let (bytes, pipe) = (folder.bytes(part), folder.path(&format!("{part}.pipe")));
            std::thread::spawn(move || {
                use std::io::Write;
                // Waits for the reader.
                let mut pipe = std::fs::File::create(pipe).unwrap();
                if let Some(id) = interrupted {
                    let kill = Command::new("kill").args(["-INT", &id.to_string()]).status();
                    assert!(kill.unwrap().success());
                }
                // An interrupted merge may have ended.
                let _ = pipe.write_all(&bytes);
            });
        });
    };
    let pipes: Vec<String> = parts.iter().map(|part| format!("{part}.pipe")).collect();
    for pipe in &pipes {
        assert!(Command::new("mkfifo").arg(folder.path(pipe)).status().unwrap().success());
    }
    for partial in ["", "--partial"] {
        let line = format!("merge {} -o m.exr {partial}", pipes.join(" "));
        let child = folder.start(&line);
        feed(&parts, None);
        let ran = finish(child, &line);
        assert_eq!(ran.code, Some(0), "{}", ran.stderr);
        assert_eq!(folder.bytes("m.exr"), folder.bytes("whole.exr"));
        folder.remove("m.exr");
    }
    let line = format!("merge {} {} -o m.exr --checkpoint m.glanz", pipes[0], parts[1]);
    let child = folder.start(&line);
    feed(&parts[..1], Some(child.id()));
    let ran = finish(child, &line);
    assert_eq!(ran.code, Some(130), "{}", ran.stderr);
    assert!(ran.stderr.contains("nothing was written"), "{}", ran.stderr);
    assert!(!folder.has("m.exr") && !folder.has("m.glanz"));
}
