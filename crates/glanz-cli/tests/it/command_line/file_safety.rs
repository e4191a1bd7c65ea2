//! Files survive signals, full disks, other processes and kills; scenes come from and pictures go to pipes.

use std::process::{Child, Command};

use super::small_scene::SCENE;
use super::support::{Folder, finish, wait_until};

/// A render that takes hours.
const LONG: &str = "render small.pbrt --spp 1000000 --size 32x24 --threads 1 -q";

fn kill(child: &Child) {
    let killed = Command::new("kill").args(["-9", &child.id().to_string()]).status();
    assert!(killed.expect("kill").success());
}

#[test]
fn files_of_killed_runs_are_removed_by_the_next_one_and_no_others() {
    let folder = Folder::with_scene();
    std::fs::create_dir(folder.path("lux")).expect("a folder");
    let left = [".glanz-1-0.tmp", "lux/.glanz-1-7.tmp"];
    let other = ".other-1-0.tmp";
    left.iter().chain([&other]).for_each(|name| folder.write(name, "x"));
    folder.succeed("illuminate small.pbrt --room 20 20 20 --cells 2 --rays 1000 -o lux -q");
    assert!(folder.has(left[0]) && !folder.has(left[1]), "only the folder of the results is tidied up");
    folder.succeed("render small.pbrt --spp 1 -o small.png -q");
    assert_eq!(folder.names(), [other, "lux", "small.pbrt", "small.png"]);
}

#[test]
fn second_process_on_a_checkpoint_is_refused_and_a_kill_frees_it() {
    let folder = Folder::with_scene();
    let first = folder.start(&format!("{LONG} -o a.exr --checkpoint state.glanz"));
    // The lock comes first, the first checkpoint soon.
    wait_until("a lock", || folder.names().iter().any(|name| name.ends_with(".lock")));
    let again = "render small.pbrt --spp 2 --size 32x24 -q -o b.exr --checkpoint state.glanz --resume";
    let process = format!("process {}", first.id());
    folder.run(again).refused(1, &["state.glanz", &process, "another checkpoint"]);
    wait_until("a checkpoint", || folder.has("state.glanz"));
    folder.run(again).refused(1, &["state.glanz", &process]);
    folder.run("merge state.glanz --checkpoint ./state.glanz").refused(2, &["state.glanz"]);
    folder.succeed(&again.replace("state.glanz", "other.glanz"));
    kill(&first);
    assert_eq!(finish(first, LONG).code, None);
    // Another sample count than that of the checkpoint is no fault: it has more samples than these two.
    let resumed = folder.run(&again.replace("-q", "--json"));
    assert!(
        resumed.code == Some(0) && resumed.stderr.contains("nothing is left to do"),
        "{}",
        resumed.stderr
    );
    assert_eq!(folder.names(), ["b.exr", "other.glanz", "small.pbrt", "state.glanz"]);
    let samples = resumed.json()["samples_per_pixel"].as_u64().expect("a count");
    folder.succeed(&format!("render small.pbrt --spp {samples} --size 32x24 -q -o whole.exr"));
    assert_eq!(folder.bytes("b.exr"), folder.bytes("whole.exr"));
}

#[test]
fn resuming_tells_what_is_left() {
    let folder = Folder::with_scene();
    let render =
        |count: u32| format!("render small.pbrt --spp {count} -o a.exr --checkpoint a.glanz --resume");
    folder.succeed(&render(4));
    for (count, words) in [
        (4, "it has 4 samples of each pixel, as many as are wanted; nothing is left to do"),
        (
            2,
            "it has 4 samples of each pixel, more than the 2 that are wanted; nothing is left to do, and the result has all 4",
        ),
        (6, "continuing after 4 samples of each pixel with 2 more"),
    ] {
        let said = folder.succeed(&render(count)).stderr;
        assert!(said.starts_with(&format!("a.glanz: {words}\n")), "{said}");
    }
    let timed = "render small.pbrt --time 0.01 -o a.exr --checkpoint a.glanz --resume";
    let said = folder.succeed(timed).stderr;
    assert!(said.starts_with("a.glanz: continuing after samples 0..6\n"), "{said}");
    let lux = "illuminate small.pbrt --room 20 20 20 --cells 2 -o lux --checkpoint lux.glanz --resume --rays";
    folder.succeed(&format!("{lux} 2000"));
    for (count, words) in [
        ("1000", "it has 2 000 particles, more than the 1 000 that are wanted"),
        ("3000", "continuing after 2 000 particles with 1 000 more"),
    ] {
        let said = folder.succeed(&format!("{lux} {count}")).stderr;
        assert!(said.contains(&format!("lux.glanz: {words}")), "{said}");
    }
}

#[test]
fn hangups_that_are_ignored_stay_ignored() {
    let folder = Folder::with_scene();
    let script = "trap '' HUP; $GLANZ render small.pbrt --spp 256 -o a.exr 2> said & p=$!; \
                  until grep -q rendering said; do sleep .01; done; kill -HUP $p; wait $p";
    let ran = folder.run_script(script);
    assert_eq!((ran.code, folder.has("a.exr")), (Some(0), true), "{}", ran.stderr);
}

#[test]
fn full_disks_and_large_files_have_sentences_and_cost_nothing() {
    let folder = Folder::with_scene();
    // Only Linux has a disk that is always full.
    #[cfg(target_os = "linux")]
    {
        let full = folder.run_script("$GLANZ info small.pbrt > /dev/full");
        full.refused(1, &["standard output: the disk is full", "help: free some space"]);
    }
    folder.write("a.exr", "old");
    let line = "render small.pbrt --spp 1 -q -o a.exr --checkpoint a.glanz";
    let limited = folder.run_script(&format!("ulimit -f 1; exec $GLANZ {line}"));
    limited.refused(1, &["a.exr: the file becomes larger than the system permits", "help: raise the limit"]);
    assert_eq!((folder.bytes("a.exr"), folder.names().len()), (b"old".to_vec(), 2));
    let long = "x".repeat(300);
    folder
        .run(&format!("render small.pbrt -o {long}.png"))
        .refused(1, &["too long", "choose a shorter name"]);
}

#[test]
fn closed_pipes_are_quiet() {
    let folder = Folder::with_scene();
    for command in
        ["info small.pbrt", "info small.pbrt --json", "render small.pbrt --spp 1 -q -o png:-", "help render"]
    {
        // The reader has ended before the program begins.
        let script =
            format!("{{ sleep .1; $GLANZ {command} 2> said; echo $? > code; }} | true; cat code said");
        let expected = if command.starts_with("help") { "0\n" } else { "141\n" };
        assert_eq!(folder.run_script(&script).stdout, expected, "{command}");
    }
}

#[test]
fn scene_comes_from_the_standard_input_and_picture_goes_to_the_standard_output() {
    let folder = Folder::new();
    folder.write("plain.pbrt", SCENE);
    folder.succeed("render plain.pbrt --spp 1 --size 8x6 -o wood.png -q");
    let texture = "Texture \"wood\" \"spectrum\" \"imagemap\" \"string filename\" \"wood.png\"\nMaterial \"diffuse\" \"texture reflectance\" \"wood\"\nShape \"sphere\"\n";
    folder.write("small.pbrt", format!("{SCENE}{texture}"));
    folder.succeed("render small.pbrt --spp 2 -o whole.png -q");
    // Files that the scene names are found in the current folder.
    let piped = folder.run_script("cat small.pbrt | $GLANZ render - --spp 2 -o png:- > piped.png");
    assert_eq!(folder.bytes("piped.png"), folder.bytes("whole.png"), "{}", piped.stderr);
    assert!(
        piped.stderr.contains("rendering standard input") && piped.stderr.contains("wrote standard output")
    );
    folder.run_script("$GLANZ render small.pbrt --spp 2 -o exr:- -o also.exr -q > piped.exr");
    assert_eq!(folder.bytes("piped.exr"), folder.bytes("also.exr"));
    let info = folder.run_script("$GLANZ info - --json < small.pbrt").json();
    assert_eq!((&info["scene"], &info["images"]), (&"standard input".into(), &1.into()));
    folder.run_script("$GLANZ convert - out.ply -q < small.pbrt");
    folder.succeed("convert small.pbrt whole.ply -q");
    assert_eq!(folder.bytes("out.ply"), folder.bytes("whole.ply"));
    // The model shows its format by its content.
    let model = folder.run_script("$GLANZ render - --spp 1 --size 8x6 -o model.png -q < out.ply");
    assert!(model.code == Some(0) && folder.has("model.png"), "{}", model.stderr);
    // Without a name of its own, the picture has that of the film.
    folder.run_script("$GLANZ render - --spp 1 -q < small.pbrt");
    assert!(folder.has("small.exr"));
    folder.run_script("$GLANZ render - --spp 1 --size 8x6 --turntable 2 -q < out.ply");
    assert!(folder.has("picture-1.exr") && folder.has("picture-2.exr"));
    // A file of the same name is another one.
    folder.write("-", "IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 3 1 1 2 0 0 0 1 1 30\n0 45 90\n0\n1000 707 0\n");
    assert_eq!(folder.run_script("$GLANZ info - --json < small.pbrt").json()["scene"], "standard input");
    let ran = folder.run_script("printf 'WorldBegin\\nShap' | $GLANZ render - -o a.png");
    assert!(!ran.stderr.contains("glanz info"), "{}", ran.stderr);
    for (line, words) in [
        ("$GLANZ render - -o a.png < /dev/null", ["standard input", "empty"]),
        ("printf 'WorldBegin\\nShap' | $GLANZ render - -o a.png", ["standard input:2:1", "Shap"]),
    ] {
        folder.run_script(line).refused(1, &words);
    }
    for (line, words) in [
        ("render small.pbrt -o -", ["-o -", "png:-"]),
        ("render small.pbrt -o jpg:-", ["jpg:-", "exr:-"]),
        ("render small.pbrt -o png:- --json", ["--json", "to a file"]),
        ("render small.pbrt -o png:- --progress openjd", ["--progress", "to a file"]),
        ("render small.pbrt -o png:- -o exr:-", ["standard output", "one picture"]),
        ("render out.ply -o png:- --turntable 2", ["standard output", "one picture"]),
        ("info - --files", ["--files", "standard input"]),
        ("illuminate - --compare - -o lux", ["--compare", "standard input"]),
        ("optimize - -o better.pbrt", ["optimize", "standard input"]),
        ("view - --no-open", ["view", "standard input"]),
    ] {
        let ran = folder.run(line);
        assert!(ran.code == Some(2), "{line}: {:?} {}", ran.code, ran.stderr);
        words.iter().for_each(|word| {
            assert!(ran.stderr.contains(word) || ran.stdout.contains(word), "{line}: {}", ran.stderr)
        });
    }
    // Its own file is an input, too.
    let onto = folder.run_script("$GLANZ convert - out.ply -q < out.ply");
    onto.refused(2, &["out.ply", "choose another name"]);
}
