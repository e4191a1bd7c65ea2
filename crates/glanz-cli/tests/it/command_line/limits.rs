//! Limits of reading, and its end by a signal.

use std::time::{Duration, Instant};

use crate::command_line::small_scene::SCENE;
use crate::command_line::support::{Folder, finish};

/// Files of which each includes the next one twice: 2^30 files.
fn endless() -> Folder {
    let folder = Folder::new();
    for level in 0..30 {
        let next = format!("Include \"{}.pbrt\"\n", level + 1);
        folder.write(&format!("{level}.pbrt"), format!("{next}{next}"));
    }
    folder.write("30.pbrt", "Identity\n");
    folder
}

#[test]
fn limits_are_named_with_the_option_that_raises_them() {
    let folder = endless();
    for (command, words) in [
        (
            "info 0.pbrt --limit files=300",
            ["the limit of 300 files is exceeded", "raise it with --limit files=600"],
        ),
        (
            "render 0.pbrt -o a.exr --limit depth=9",
            ["9 files within one another", "raise it with --limit depth=18"],
        ),
        (
            "convert 0.pbrt a.obj --limit time=0.05s --limit files=1e9",
            ["the limit of 0.05 s", "--limit time=1s"],
        ),
        (
            "info 0.pbrt --files --limit files=300",
            ["the limit of 300 files is exceeded", "raise it with --limit files=600"],
        ),
        ("bake 0.pbrt -o a.glb --limit tokens=300", ["the limit of 300 tokens", "--limit tokens=600"]),
        ("optimize 0.pbrt -o a.pbrt --memory 1K", ["1 KiB of memory is exceeded", "raise it with --memory"]),
    ] {
        let ran = folder.run(command);
        ran.refused(1, &words);
        assert!(
            ran.stderr.contains(".pbrt:") && ran.stderr.lines().count() <= 5,
            "{command}: {}",
            ran.stderr
        );
    }
    for wrong in ["--limit files", "--limit files=x", "--limit rays=3", "--memory much", "--limit time=0"] {
        folder.run(&format!("info 0.pbrt {wrong}")).refused(2, &["error: invalid value"]);
    }
}

#[test]
fn preparing_a_scene_keeps_to_the_limits() {
    let folder = Folder::new();
    let grid = "ObjectBegin \"a\" AreaLightSource \"diffuse\" Shape \"sphere\" ObjectEnd\n";
    let copies = "ObjectInstance \"a\" ".repeat(1000);
    folder.write("many.pbrt", SCENE.replace("WorldBegin", &format!("WorldBegin\n{grid}{copies}")));
    // A thousand instances are read, and each has a light of its own.
    folder
        .run("render many.pbrt -o a.exr --size 2x2 --spp 1 --limit objects=1500")
        .refused(1, &["many.pbrt:", "1 500 objects"]);
    folder.succeed("render many.pbrt -o a.exr --size 2x2 --spp 1 --limit objects=5000 -q");
}

#[test]
fn films_beyond_the_memory_name_a_limit_that_suffices() {
    let folder = Folder::with_scene();
    let line = "render small.pbrt --integrator guided --size 300x200 --spp 1 -q -o a.exr --memory";
    let ran = folder.run(&format!("{line} 1M"));
    ran.refused(1, &["the film needs", "help: raise it with --memory", "--size"]);
    let rest = ran.stderr.split_once("--memory ").expect("advice").1;
    let advised = rest.split_once(',').expect("a comma").0;
    folder.succeed(&format!("{line} {advised}"));
}

#[cfg(unix)]
#[test]
fn standard_input_has_limits_and_ends_with_a_signal() {
    let folder = Folder::new();
    for (limit, words) in [
        ("--limit bytes=1000", ["standard input: the limit of 1000 bytes", "raise it with --limit bytes=2K"]),
        ("--memory 4K", ["standard input: the limit of 4 KiB of memory", "raise it with --memory 8K"]),
    ] {
        folder.run_script(&format!("yes | $GLANZ info - {limit}")).refused(1, &words);
    }
    // The other end of the pipe is open, and nobody writes.
    let script = "mkfifo pipe; $GLANZ info - < pipe & p=$!; exec 3> pipe; sleep 1; kill -TERM $p; wait $p";
    let ran = folder.run_script(script);
    assert!(ran.code == Some(143) && ran.stderr.contains("interrupted"), "{:?} {}", ran.code, ran.stderr);
    let script = "$GLANZ info - --limit time=0.5s < pipe & p=$!; exec 3> pipe; wait $p";
    folder
        .run_script(script)
        .refused(1, &["standard input: the limit of 0.5 s", "raise it with --limit time=1s"]);
}

#[cfg(target_os = "linux")]
#[test]
fn pictures_and_luminaires_keep_to_the_limits() {
    let folder = Folder::new();
    folder.write(
        "lamp.ies",
        "IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 3 1 1 2 0 0 0 1 1 30\n0 45 90\n0\n1000 707 0\n",
    );
    folder.run("info lamp.ies --limit bytes=10").refused(1, &["lamp.ies: ", "raise it with --limit bytes="]);
    folder.run("info lamp.ies --memory 10").refused(1, &["lamp.ies: ", "raise it with --memory"]);
    folder.run("info lamp.ies --files --limit bytes=10").refused(1, &["raise it with --limit bytes="]);
    folder.succeed("info lamp.ies --limit bytes=1K");
    folder.write("tilted.ies", "IESNA:LM-63-2002\nTILT=lamp.tlt\n");
    folder.write("lamp.tlt", " ".repeat(2000));
    folder
        .run("info tilted.ies --files --limit bytes=1K")
        .refused(1, &["tilted.ies: the limit of", "raise it with --limit bytes="]);
    assert!(folder.run("info tilted.ies --files --limit bytes=4K").stdout.contains("lamp.tlt"));
    let road = "road lamp.ies --spacing 25 --height 8";
    folder
        .run(&format!("{road} --limit bytes=10"))
        .refused(1, &["lamp.ies: the limit of", "raise it with --limit bytes="]);
    folder.run(&format!("{road} --memory 10")).refused(1, &["lamp.ies: ", "raise it with --memory"]);
    folder.succeed(&format!("{road} --limit bytes=1K --memory 1G"));
    // They have no end, and no other end.
    assert!(
        std::process::Command::new("mkfifo").arg(folder.path("pipe.ies")).status().expect("mkfifo").success()
    );
    for command in ["compare /dev/zero pipe.ies", "compare pipe.ies a.exr", "info pipe.ies"] {
        folder.run(command).refused(1, &["not a regular file"]);
    }
}

#[cfg(unix)]
#[test]
fn a_signal_ends_reading() {
    let folder = endless();
    for command in ["render 0.pbrt -o a.exr", "info 0.pbrt", "convert 0.pbrt a.obj", "view 0.pbrt --no-open"]
    {
        let line = format!("{command} --limit files=1e12");
        let child = folder.start(&line);
        std::thread::sleep(Duration::from_millis(300));
        let signalled = Instant::now();
        let killed = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status();
        assert!(killed.expect("kill runs").success(), "{line}");
        let ran = finish(child, &line);
        assert_eq!(ran.code, Some(130), "{line}: {}", ran.stderr);
        assert!(ran.stderr.contains("interrupted"), "{line}: {}", ran.stderr);
        assert!(signalled.elapsed() < Duration::from_secs(2), "{line}");
    }
}
