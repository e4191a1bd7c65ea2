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
        ("bake 0.pbrt -o a.glb --limit tokens=300", ["the limit of 300 tokens", "--limit tokens=600"]),
        ("optimize 0.pbrt -o a.pbrt --memory 1K", ["1 kB of memory is exceeded", "raise it with --memory"]),
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
