//! The picture depends only on scene, settings and seed.

use std::io::{BufRead, BufReader};
use std::process::Command;

use crate::command_line::support::{Folder, finish, wait_until};

#[test]
fn one_thread_and_two_give_the_same_file() {
    let folder = Folder::with_scene();
    folder.succeed("render small.pbrt -o one.exr --aov all --threads 1 -q");
    folder.succeed("render small.pbrt -o two.exr --aov all --threads 2 -q");
    assert_eq!(folder.bytes("one.exr"), folder.bytes("two.exr"));
    folder.succeed("render small.pbrt -o other.exr --aov all --seed 1 -q");
    assert_ne!(folder.bytes("one.exr"), folder.bytes("other.exr"), "the seed has no effect");
}

#[test]
fn merged_halves_are_the_whole() {
    for sampler in ["sobol", "independent", "stratified", "regular"] {
        let folder = Folder::with_scene();
        let settings = format!("--sampler {sampler} --spp 64 --size 12x9 --aov all -q");
        folder.succeed(&format!("render small.pbrt {settings} -o whole.exr"));
        folder
            .succeed(&format!("render small.pbrt {settings} --samples 0..32 --checkpoint a.glanz -o a.exr"));
        folder
            .succeed(&format!("render small.pbrt {settings} --samples 32..64 --checkpoint b.glanz -o b.exr"));
        folder.succeed("merge b.glanz a.glanz -o merged.exr --checkpoint both.glanz -q");
        assert_eq!(folder.bytes("merged.exr"), folder.bytes("whole.exr"), "{sampler}");
        assert_ne!(folder.bytes("a.exr"), folder.bytes("whole.exr"), "{sampler}");

        // The merged checkpoint equals that of a single run and can be resumed like it.
        folder
            .succeed(&format!("render small.pbrt {settings} --checkpoint both.glanz --resume -o again.exr"));
        assert_eq!(folder.bytes("again.exr"), folder.bytes("whole.exr"), "{sampler}");
    }
}

#[test]
fn halves_need_no_plan_with_the_default_sampler() {
    let folder = Folder::with_scene();
    folder.succeed("render small.pbrt --samples 0..32 --checkpoint a.glanz -o a.exr -q");
    folder.succeed("render small.pbrt --samples 32..64 --checkpoint b.glanz -o b.exr -q");
    folder.succeed("merge a.glanz b.glanz -o merged.exr -q");
    folder.succeed("render small.pbrt --spp 64 -o whole.exr -q");
    assert_eq!(folder.bytes("merged.exr"), folder.bytes("whole.exr"));
}

#[test]
fn noise_level_is_reached_resumed_and_not_merged() {
    let folder = Folder::with_scene();
    let once = folder.succeed("render small.pbrt --noise 0.05 --threads 1 --json -o once.exr").json();
    let (most, mean) = (once["samples_per_pixel"].as_u64().unwrap(), &once["mean_samples_per_pixel"]);
    assert!((48..65_536).contains(&most) && mean.as_f64().unwrap() <= most as f64, "{once}");
    assert!(once["noise"] == 0.05 && once["denoised"] == false && once["warnings"] == serde_json::json!([]));
    let part =
        folder.succeed("render small.pbrt --noise 0.05 --spp 40 --json --checkpoint part.glanz -o part.exr");
    assert!(part.stdout.contains("had not reached the noise level"), "{}", part.stdout);
    folder.succeed("render small.pbrt --noise 0.05 -q --checkpoint part.glanz --resume -o again.exr");
    assert_eq!(folder.bytes("once.exr"), folder.bytes("again.exr"));
    assert_ne!(folder.bytes("once.exr"), folder.bytes("part.exr"));
    assert!(folder.picture("once.exr").channel("Variance.G").is_some());
    folder.run("merge part.glanz part.glanz -o m.exr").refused(1, &["noise level"]);
    for (option, words) in [
        ("--noise 2", ["--noise 2: ", "0.000001"]),
        ("--noise 0.1 --integrator light", ["the integrator \"light\"", "add --integrator path"]),
    ] {
        folder.run(&format!("render small.pbrt {option} -o m.exr")).refused(2, &words);
    }
    assert!(!folder.has("m.exr"));
}

#[cfg(unix)]
#[test]
fn killed_and_resumed_is_one_run() {
    // A pass takes half a second at most, the signal comes during the first ones: most of the samples are left to do.
    const RUN: &str = "render small.pbrt --spp 2048 --size 32x24 --aov all";
    let folder = Folder::with_scene();
    folder.succeed(&format!("{RUN} -o once.exr --threads 2 -q"));
    for (signal, code) in [("TERM", 143), ("INT", 130), ("HUP", 129)] {
        // As tests run by `nohup` are, and with them the program.
        if signal == "HUP" && !glanz_terminal::interrupt::receives_hangup() {
            println!("SIGHUP is ignored here, and not tested");
            continue;
        }
        let line = format!("{RUN} --checkpoint state.glanz -o part.exr --threads 1 --json");
        let mut child = folder.start(&line);
        let mut said = String::new();
        let messages = child.stderr.take().expect("the messages");
        BufReader::new(messages).read_line(&mut said).expect("a message");
        assert!(said.starts_with("rendering small.pbrt"), "{said}");
        let sent = Command::new("kill").args([&format!("-{signal}"), &child.id().to_string()]).status();
        assert!(sent.unwrap().success(), "the program ended before the signal");
        let ran = finish(child, &line);
        assert_eq!(ran.code, Some(code), "{}{}", ran.stdout, ran.stderr);
        assert!(folder.has("part.exr") && folder.has("state.glanz"));
        let done = ran.json()["samples_per_pixel"].as_u64().unwrap();
        assert!(ran.json()["interrupted"] == true && (1..2048).contains(&done), "{}", ran.stdout);

        folder.succeed(&format!("{RUN} --checkpoint state.glanz --resume -o resumed.exr --threads 1 -q"));
        assert_eq!(folder.bytes("resumed.exr"), folder.bytes("once.exr"), "after SIG{signal}");
        folder.remove("state.glanz");
    }
}

#[test]
fn finished_checkpoint_resumed_is_a_success() {
    let folder = Folder::with_scene();
    let first = folder.succeed("render small.pbrt --checkpoint state.glanz --resume -o a.exr");
    assert!(first.stderr.contains("state.glanz"), "that there was none is said: {}", first.stderr);
    let again = folder.succeed("render small.pbrt --checkpoint state.glanz --resume -o b.exr --json");
    assert_eq!(folder.bytes("a.exr"), folder.bytes("b.exr"));
    assert_eq!(again.json()["samples"], 0, "nothing was left to do");
    assert_eq!(again.json()["samples_per_pixel"], 8);

    // More samples continue from there.
    folder.succeed("render small.pbrt --checkpoint state.glanz --resume --spp 16 -o more.exr -q");
    folder.succeed("render small.pbrt --spp 16 -o once.exr -q");
    assert_eq!(folder.bytes("more.exr"), folder.bytes("once.exr"));
}

#[test]
fn foreign_and_damaged_checkpoints_are_refused_with_the_reason() {
    let folder = Folder::with_scene();
    folder.succeed("render small.pbrt --checkpoint state.glanz -o a.exr -q");
    let state = folder.bytes("state.glanz");
    for (options, reason) in [
        ("--size 12x9", "size"),
        ("--seed 5", "seed"),
        ("--integrator whitted", "integrator"),
        ("--sampler independent", "sampler"),
        ("--aov Z", "channels"),
    ] {
        let ran =
            folder.run(&format!("render small.pbrt --checkpoint state.glanz --resume -o b.exr {options}"));
        ran.refused(1, &["state.glanz", reason]);
    }
    folder.write("small.pbrt", crate::command_line::small_scene::SCENE.replace("fov\" 35", "fov\" 36"));
    folder
        .run("render small.pbrt --checkpoint state.glanz --resume -o b.exr")
        .refused(1, &["state.glanz", "scene"]);
    folder.write("small.pbrt", crate::command_line::small_scene::SCENE);

    let mut flipped = state.clone();
    let middle = flipped.len() / 2;
    flipped[middle] ^= 0x10;
    for (bytes, reason) in [
        (flipped, "damaged"),
        (state[..state.len() - 7].to_vec(), "damaged"),
        (b"solid teapot".to_vec(), "not a checkpoint"),
        (Vec::new(), "not a checkpoint"),
    ] {
        folder.write("bad.glanz", &bytes);
        folder
            .run("render small.pbrt --checkpoint bad.glanz --resume -o b.exr")
            .refused(1, &["bad.glanz", reason]);
        folder.run("merge bad.glanz -o b.exr").refused(1, &["bad.glanz", reason]);
        assert_eq!(folder.bytes("bad.glanz"), bytes, "a refused checkpoint is left as it is");
    }
    assert!(!folder.has("b.exr"));

    // Without `--resume` an existing checkpoint is an error.
    folder
        .run("render small.pbrt --checkpoint state.glanz -o b.exr")
        .refused(1, &["state.glanz", "--resume"]);
    assert_eq!(folder.bytes("state.glanz"), state);
}

#[test]
fn parts_that_do_not_go_together_are_refused() {
    let folder = Folder::with_scene();
    folder.succeed("render small.pbrt --samples 0..4 --checkpoint a.glanz -o a.exr -q");
    folder.succeed("render small.pbrt --samples 3..6 --checkpoint b.glanz -o b.exr -q");
    folder.succeed("render small.pbrt --samples 4..6 --seed 9 --checkpoint c.glanz -o c.exr -q");
    folder.run("merge a.glanz b.glanz -o m.exr").refused(1, &["a.glanz", "b.glanz", "3", "--samples"]);
    folder.run("merge a.glanz c.glanz -o m.exr").refused(1, &["a.glanz and c.glanz", "seed", "9 in c.glanz"]);
    folder.run("merge a.glanz none.glanz -o m.exr").refused(1, &["none.glanz"]);
    assert!(!folder.has("m.exr"));
}

#[test]
fn checkpoint_appears_whole_while_rendering() {
    let folder = Folder::with_scene();
    let line = "render small.pbrt --spp 64 --checkpoint state.glanz -o a.exr -q";
    let child = folder.start(line);
    wait_until("the checkpoint", || folder.has("state.glanz"));
    assert!(folder.bytes("state.glanz").starts_with(b"GLANZ"));
    assert_eq!(finish(child, line).code, Some(0));
    assert_eq!(folder.names(), ["a.exr", "small.pbrt", "state.glanz"], "no temporary file stays");
}

#[test]
fn guided_picture_depends_on_no_threads_and_no_interruption() {
    const RUN: &str = "render small.pbrt --integrator guided --spp 40 --aov all -q";
    let folder = Folder::with_scene();
    folder.succeed(&format!("{RUN} -o one.exr --threads 1 --guide-out one.guide"));
    folder.succeed(&format!("{RUN} -o two.exr --threads 2 --guide-out two.guide"));
    assert_eq!(folder.bytes("one.exr"), folder.bytes("two.exr"));
    assert_eq!(folder.bytes("one.guide"), folder.bytes("two.guide"));
    for end in [3, 21] {
        let part = RUN.replace("--spp 40", &format!("--spp {end}"));
        folder.succeed(&format!("{part} --checkpoint c.glanz --resume -o part.exr"));
    }
    folder.succeed(&format!("{RUN} --checkpoint c.glanz --resume -o resumed.exr"));
    assert_eq!(folder.bytes("resumed.exr"), folder.bytes("one.exr"));
}

#[test]
fn parts_can_be_merged_with_one_guide_and_not_while_learning() {
    const RUN: &str = "render small.pbrt --integrator guided -q";
    let folder = Folder::with_scene();
    folder.succeed(&format!("{RUN} --spp 32 -o learnt.exr --guide-out g.guide --checkpoint learnt.glanz"));
    let fixed = format!("{RUN} --guide-in g.guide");
    folder.succeed(&format!("{fixed} --spp 16 -o whole.exr"));
    folder.succeed(&format!("{fixed} --samples 0..5 --checkpoint a.glanz -o a.exr"));
    folder.succeed(&format!("{fixed} --samples 5..16 --checkpoint b.glanz -o b.exr"));
    folder.succeed("merge b.glanz a.glanz -o merged.exr -q");
    assert_eq!(folder.bytes("merged.exr"), folder.bytes("whole.exr"));

    folder
        .run("merge a.glanz learnt.glanz -o m.exr")
        .refused(1, &["learnt.glanz", "--guide-in", "--guide-out"]);
    folder.run(&format!("{RUN} --samples 4..8 -o m.exr")).refused(2, &["--samples 4..8", "--guide-in"]);
    folder
        .run("render small.pbrt --guide-out h.guide -o m.exr")
        .refused(2, &["--guide-out", "--integrator guided"]);
    folder.run("render small.pbrt --guide-in g.guide -o m.exr").refused(2, &["--guide-in", "path"]);
    let resumed = "--checkpoint learnt.glanz --resume -o m.exr";
    folder.run(&format!("{fixed} {resumed}")).refused(1, &["learnt.glanz", "another picture"]);
    let mut flipped = folder.bytes("g.guide");
    let middle = flipped.len() / 2;
    flipped[middle] ^= 4;
    for (bytes, reason) in
        [(flipped, "damaged"), (b"solid".to_vec(), "not a guide"), (Vec::new(), "not a guide")]
    {
        folder.write("bad.guide", &bytes);
        folder.run(&format!("{RUN} --guide-in bad.guide -o m.exr")).refused(1, &["bad.guide", reason]);
    }
    assert!(!folder.has("m.exr"));
}

#[test]
fn grid_guide_is_selected_resumed_and_reused_by_the_command_line() {
    const GRID: &str = "grid=2,basis=spline1,scale=2,mixture=on,hierarchical=on";
    let run = format!("render small.pbrt --integrator guided --guide {GRID} --samplelights off -q");
    let folder = Folder::with_scene();
    folder.succeed(&format!("{run} --spp 40 -o one.exr --threads 1 --guide-out one.guide"));
    folder.succeed(&format!("{run} --spp 40 -o two.exr --threads 2 --guide-out two.guide"));
    assert_eq!(folder.bytes("one.exr"), folder.bytes("two.exr"));
    assert_eq!(folder.bytes("one.guide"), folder.bytes("two.guide"));
    for end in [5, 40] {
        folder.succeed(&format!("{run} --spp {end} --checkpoint c.glanz --resume -o resumed.exr"));
    }
    assert_eq!(folder.bytes("resumed.exr"), folder.bytes("one.exr"));
    folder
        .run(&format!("{} --spp 40 --checkpoint c.glanz --resume -o m.exr", run.replace("=on", "=off")))
        .refused(1, &["c.glanz", "another picture", "mixture=off"]);

    folder.succeed(&format!("{run} --guide-in one.guide --spp 4 -o fixed.exr"));
    assert_ne!(folder.bytes("fixed.exr"), folder.bytes("one.exr"));
    folder
        .run("render small.pbrt --integrator guided --guide-in one.guide -o m.exr")
        .refused(1, &["one.guide", "not tree", &format!("--guide {GRID}")]);
    folder.run("render small.pbrt --guide grid=4 -o m.exr").refused(2, &["--guide", "--integrator guided"]);
    folder
        .run("render small.pbrt --integrator guided --guide grid=4,basis=box -o m.exr")
        .refused(2, &["--guide", "haar, spline0"]);
    folder
        .run("render small.pbrt --integrator guided --guide grid=64,scale=6,basis=spline3 -o m.exr -q")
        .refused(1, &["grid=64", "GiB", "4 GiB", "smaller"]);
    assert!(!folder.has("m.exr"));
}

#[test]
fn spectral_pictures_are_pictures_of_their_own() {
    let folder = Folder::with_scene();
    folder.succeed("render small.pbrt --spp 4 -q -o rgb.exr --checkpoint rgb.glanz");
    for threads in [1, 2] {
        folder.succeed(&format!(
            "render small.pbrt --spp 4 -q --spectral --threads {threads} -o {threads}.exr"
        ));
    }
    assert_eq!(folder.bytes("1.exr"), folder.bytes("2.exr"));
    assert_ne!(folder.bytes("1.exr"), folder.bytes("rgb.exr"));
    folder
        .run("render small.pbrt --spp 8 -q --spectral --checkpoint rgb.glanz --resume -o m.exr")
        .refused(1, &["rgb.glanz", "another picture", "spectral"]);
}

#[test]
fn options_of_other_integrators_are_refused() {
    let folder = Folder::with_scene();
    folder
        .run("render small.pbrt --integrator whitted --samplelights off -o m.exr")
        .refused(2, &["--samplelights", "whitted"]);
    folder
        .run("render small.pbrt --integrator whitted --branching 4 -o m.exr")
        .refused(2, &["--branching 4", "whitted", "--integrator path"]);
    assert!(!folder.has("m.exr"));
}
