//! Every command that writes, with writing that fails at every call, and with kills at any moment: files are old or new, never between, nothing stays behind,
//! and the next run ends with the same bits.
//!
//! `cargo xtask failures` makes system calls fail and kills the program at them, by strace; `GLANZ_FAILURES_CALLS` is the largest number of calls of a kind
//! that are tried, `GLANZ_FAILURES_KILLS` the number of kills at random moments per command.

use std::collections::BTreeMap;
use std::sync::LazyLock;
use std::time::{Duration, Instant};

use glanz::transport::codec::PREFIX_LENGTH;

use crate::PROGRAM;
use crate::command_line::small_scene::SCENE;
use crate::command_line::support::{Folder, ProgramOutput, finish};

/// A design of one reflector.
const DESIGN: &str = include_str!("../../../../scenes/design/bent_paraboloid.pbrt");

/// A floor under a lamp with a ball on it.
const ROOM: &str = r#"
WorldBegin
AttributeBegin
  AreaLightSource "diffuse" "rgb L" [8 8 8]
  Shape "bilinearmesh" "point3 P" [-.5 -.5 2  -.5 .5 2  .5 -.5 2  .5 .5 2]
AttributeEnd
Shape "bilinearmesh" "point3 P" [-1 -1 0  1 -1 0  -1 1 0  1 1 0]
Translate 0 0 .4
Shape "sphere" "float radius" .3
"#;

/// The content of all files by their paths.
type Content = BTreeMap<String, Vec<u8>>;

/// A command that writes.
struct Writer {
    line: &'static str,
    /// Arguments with which it is run again; it resumes.
    again: &'static str,
    /// Files that it replaces, one of each kind.
    replaces: &'static [&'static str],
}

const WRITERS: [Writer; 11] = [
    Writer {
        line: "render small.pbrt --spp 2 -o a.exr -o a.png --checkpoint a.glanz",
        again: "--resume",
        replaces: &["a.exr"],
    },
    Writer {
        line: "render small.pbrt --spp 4 --integrator guided -o g.pfm --guide-out g.guide",
        again: "",
        replaces: &["g.guide"],
    },
    Writer {
        line: "bake room.pbrt -o b.glb --texels-per-metre 2 --rays 16 --checkpoint b.glanz",
        again: "--resume",
        replaces: &["b.exr"],
    },
    Writer {
        line: "illuminate small.pbrt --room 20 20 20 --cells 2 --rays 1000 -o lux --far-field l.ldt --resolution 15 --ray-file l.tm25ray --checkpoint l.glanz",
        again: "--resume",
        replaces: &["lux/report.html", "l.ldt"],
    },
    // The folder is new.
    Writer {
        line: "illuminate small.pbrt --room 20 20 20 --cells 2 --rays 1000 -o lux2",
        again: "",
        replaces: &[],
    },
    // The film is in a file.
    Writer { line: "render small.pbrt --spp 2 -o d.exr --memory 40K", again: "", replaces: &["d.exr"] },
    Writer {
        line: "optimize design.pbrt -o better.pbrt --rays 50 --steps 3 --checkpoint o.glanz",
        again: "--resume",
        replaces: &["better.pbrt"],
    },
    Writer { line: "merge 1.glanz 2.glanz -o m.hdr --checkpoint m.glanz", again: "", replaces: &["m.hdr"] },
    Writer { line: "convert small.pbrt c.obj --tolerance 10%", again: "", replaces: &["c.mtl"] },
    Writer { line: "convert thing.ply t.pbrt", again: "", replaces: &["t.pbrt"] },
    Writer { line: "info lamp.ies --plot lamp.svg", again: "", replaces: &["lamp.svg"] },
];

impl Writer {
    fn line(&self) -> String {
        format!("{} --threads 1 -q", self.line)
            .replace("info lamp.ies --plot lamp.svg --threads 1 -q", "info lamp.ies --plot lamp.svg")
    }

    fn again(&self) -> String {
        format!("{} {}", self.line(), self.again)
    }

    /// Restores the files as they are before the command: its inputs, and old content of some of its outputs.
    fn prepare(&self, folder: &Folder, inputs: &Content) {
        restore(folder, inputs);
        for name in self.replaces {
            if let Some((inner, _)) = name.split_once('/') {
                std::fs::create_dir_all(folder.path(inner)).expect("a folder");
            }
            folder.write(name, "old");
        }
    }
}

/// Removes everything, and writes the inputs again.
fn restore(folder: &Folder, inputs: &Content) {
    for name in folder.names() {
        let path = folder.path(&name);
        let removed = if path.is_dir() { std::fs::remove_dir_all(path) } else { std::fs::remove_file(path) };
        removed.expect("a file of the test");
    }
    inputs.iter().for_each(|(name, bytes)| folder.write(name, bytes));
}

/// The files that the commands read, made once.
fn inputs() -> &'static Content {
    static INPUTS: LazyLock<Content> = LazyLock::new(new_inputs);
    &INPUTS
}

fn new_inputs() -> Content {
    let folder = Folder::with_scene();
    folder.write("design.pbrt", DESIGN);
    folder.write("room.pbrt", ROOM);
    folder.write(
        "lamp.ies",
        "IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 3 1 1 2 0 0 0 1 1 30\n0 45 90\n0\n1000 707 0\n",
    );
    for part in ["0..1", "1..2"] {
        let name = if part == "0..1" { "1.glanz" } else { "2.glanz" };
        folder.succeed(&format!("render small.pbrt --samples {part} --checkpoint {name} -o part.exr -q"));
    }
    folder.write("ball.pbrt", "WorldBegin\nShape \"sphere\"\n");
    folder.succeed("convert ball.pbrt thing.ply --tolerance 10% -q");
    let mut content = folder.content();
    content.remove("part.exr");
    assert_eq!(content["small.pbrt"], SCENE.as_bytes());
    content
}

/// Variables with which equal runs write equal files.
const DATE: (&str, &str) = ("SOURCE_DATE_EPOCH", "1700000000");

fn run(folder: &Folder, line: &str) -> ProgramOutput {
    folder.run_with(&[DATE], line)
}

/// The files after an undisturbed run.
fn undisturbed(writer: &Writer, folder: &Folder, inputs: &Content) -> Content {
    writer.prepare(folder, inputs);
    let ran = run(folder, &writer.line());
    assert_eq!(ran.code, Some(0), "{}: {}", writer.line, ran.stderr);
    folder.content()
}

/// Whether it is the name of a temporary file or a lock file.
fn is_own(name: &str) -> bool {
    name.rsplit('/').next().is_some_and(|name| name.starts_with(".glanz-"))
}

/// Checks the files after a disturbed run: every one is old or new, and files of Glanz itself are left after a kill only.
fn check(writer: &Writer, folder: &Folder, inputs: &Content, wanted: &Content, may_leave: bool, point: &str) {
    for (name, bytes) in folder.content() {
        if is_own(&name) {
            assert!(may_leave, "{}: {point} leaves {name}", writer.line);
            continue;
        }
        let is_old = inputs.get(&name).is_some_and(|old| *old == bytes)
            || writer.replaces.contains(&name.as_str()) && bytes == b"old";
        // A checkpoint may be of a part of the work, which resuming shows.
        let is_new = wanted.get(&name).is_some_and(|new| {
            *new == bytes
                || writer.again == "--resume" && name.ends_with(".glanz") && is_whole_state(&bytes)
        })
            // Reports are written once more with the facts of the ray file.
            || is_whole_report(&name, &bytes);
        assert!(is_old || is_new, "{}: {point} leaves {name} with {} bytes", writer.line, bytes.len());
    }
    inputs.iter().for_each(|(name, bytes)| assert!(folder.bytes(name) == *bytes, "{point} changes {name}"));
    for name in writer.replaces {
        assert!(folder.has(name), "{}: {point} loses {name}", writer.line);
    }
}

/// Whether these are as many bytes as the beginning of a file of Glanz says.
fn is_whole_state(bytes: &[u8]) -> bool {
    let length = bytes.get(PREFIX_LENGTH - 8..PREFIX_LENGTH);
    length.is_some_and(|length| length == (bytes.len() as u64).to_le_bytes())
}

#[test]
fn parts_of_a_state_are_not_whole() {
    let state = &inputs()["1.glanz"];
    assert!(is_whole_state(state));
    assert!((0..state.len()).all(|length| !is_whole_state(&state[..length])));
}

/// Whether these are all bytes of a report of `glanz illuminate`.
fn is_whole_report(name: &str, bytes: &[u8]) -> bool {
    match name {
        "lux/report.html" => bytes.ends_with(b"</html>\n"),
        "lux/report.json" => serde_json::from_slice::<serde_json::Value>(bytes).is_ok(),
        "lux/summary.txt" => bytes.ends_with(b"\n"),
        _ => false,
    }
}

/// Runs the command again and compares all files with those of an undisturbed run.
fn run_again(writer: &Writer, folder: &Folder, wanted: &Content, point: &str) {
    let ran = run(folder, &writer.again());
    assert_eq!(ran.code, Some(0), "{} after {point}: {}", writer.line, ran.stderr);
    let content = folder.content();
    assert!(
        content == *wanted,
        "{} after {point}: {:?}",
        writer.line,
        content
            .iter()
            .filter(|(name, bytes)| wanted.get(*name) != Some(bytes))
            .map(|(name, _)| name)
            .collect::<Vec<_>>()
    );
}

fn number(variable: &str, otherwise: u64) -> u64 {
    std::env::var(variable).map_or(otherwise, |text| text.parse().expect(variable))
}

/// The limit on the size of files cuts a block short, and fails the next: at every size until all files fit.
#[test]
fn files_that_may_grow_to_any_size_are_old_or_new() {
    let points: u64 = std::thread::scope(|scope| {
        let threads: Vec<_> =
            WRITERS.iter().map(|writer| scope.spawn(move || limited_sizes(writer))).collect();
        threads.into_iter().map(|thread| thread.join().expect("a command without losses")).sum::<u64>()
    });
    println!("{points} limits of the size of files");
}

/// Number of limits under which the command was run.
fn limited_sizes(writer: &Writer) -> u64 {
    let (folder, inputs) = (Folder::new(), inputs());
    let wanted = undisturbed(writer, &folder, inputs);
    let outputs = wanted.iter().filter(|(name, _)| !inputs.contains_key(*name));
    let largest = outputs.map(|(_, bytes)| bytes.len().div_ceil(512)).max().unwrap_or_default();
    // Sizes from nothing to the largest file, in blocks of 512 bytes.
    let steps = number("GLANZ_FAILURES_CALLS", 3).min(largest as u64);
    for step in 0..steps {
        let blocks = largest as u64 * step / steps;
        writer.prepare(&folder, inputs);
        let (name, value) = DATE;
        let script = format!("ulimit -f {blocks}; {name}={value} exec $GLANZ {}", writer.line());
        let ran = folder.run_script(&script);
        let point = format!("a limit of {blocks} blocks");
        assert_eq!(ran.code, Some(1), "{}: {point}: {}", writer.line, ran.stderr);
        assert!(ran.stderr.contains("larger than the system permits"), "{}: {}", writer.line, ran.stderr);
        check(writer, &folder, inputs, &wanted, false, &point);
        if step + 1 == steps || steps > 10 {
            run_again(writer, &folder, &wanted, &point);
        }
    }
    steps
}

/// System calls that change files, and what is done to them.
const CALLS: [&str; 10] =
    ["openat", "write", "fsync", "rename", "unlink", "fchmod", "mkdir", "flock", "fallocate", "ftruncate"];
const FAULTS: [&str; 4] = ["error=ENOSPC", "error=EIO", "error=EINTR", "signal=KILL"];

/// Every call of the system that changes files fails or is the last one, by strace.
#[test]
fn calls_that_fail_or_are_the_last_leave_files_old_or_new() {
    let most = number("GLANZ_FAILURES_CALLS", 0);
    if most == 0 {
        println!("no calls of the system are made to fail; `cargo xtask failures` does so");
        return;
    }
    let counts: Vec<u64> = std::thread::scope(|scope| {
        let run = |writer| scope.spawn(move || failing_calls(writer, inputs(), most));
        let threads: Vec<_> = WRITERS.iter().map(run).collect();
        threads.into_iter().map(|thread| thread.join().expect("a command without losses")).collect()
    });
    println!("{} points at calls of the system, nothing lost", counts.iter().sum::<u64>());
}

/// Number of points at which the command was disturbed.
fn failing_calls(writer: &Writer, inputs: &Content, most: u64) -> u64 {
    let folder = Folder::new();
    let wanted = undisturbed(writer, &folder, inputs);
    let mut points = 0;
    for (call, fault) in CALLS.iter().flat_map(|call| FAULTS.iter().map(move |fault| (call, fault))) {
        let mut count = 0;
        while count < most {
            count += 1;
            writer.prepare(&folder, inputs);
            let (log, point) = (folder.path("log"), format!("{call}:{fault}:when={count}"));
            let mut command = folder.prepared("strace");
            command.args(["-f", "-qq", "-e", "signal=none", "-o"]).arg(&log);
            command.args(["-e", &format!("trace={call}"), "-e", &format!("inject={point}"), PROGRAM]);
            command.args(writer.line().split_whitespace()).env(DATE.0, DATE.1);
            let child =
                command.spawn().unwrap_or_else(|error| panic!("strace: {error}; apt-get install strace"));
            let ran = finish(child, &point);
            let trace = String::from_utf8_lossy(&std::fs::read(&log).expect("a log of strace")).into_owned();
            std::fs::remove_file(&log).expect("the log of strace");
            let is_kill = fault.starts_with("signal");
            // Threads count for themselves: the end comes when none has so many calls.
            let is_done = if is_kill { ran.code.is_some() } else { !trace.contains("(INJECTED)") };
            assert!(!ran.stderr.contains("panicked"), "{}: {point}: {}", writer.line, ran.stderr);
            let may_leave = is_kill || *call == "unlink";
            check(writer, &folder, inputs, &wanted, may_leave, &point);
            if ran.code == Some(0) {
                let mut content = folder.content();
                content.retain(|name, _| !is_own(name));
                assert!(content == wanted, "{}: {point} is not reported: {}", writer.line, ran.stderr);
            }
            if is_done {
                assert_eq!(ran.code, Some(0), "{}: {point}: {}", writer.line, ran.stderr);
                break;
            }
            points += 1;
            run_again(writer, &folder, &wanted, &point);
        }
    }
    println!("{points} points: glanz {}", writer.line);
    points
}

/// A command that takes long, in proportion to the number in the place of N.
struct LongWriter {
    line: &'static str,
    /// A number that takes a small part of a second.
    least: u64,
}

const LONG_WRITERS: [LongWriter; 4] = [
    LongWriter { line: "render small.pbrt --spp N -o a.exr --checkpoint state", least: 64 },
    LongWriter {
        line: "bake room.pbrt -o a.glb --texels-per-metre 4 --rays N --checkpoint state",
        least: 256,
    },
    LongWriter {
        line: "illuminate small.pbrt --room 20 20 20 --cells 2 --rays N -o lux --checkpoint state",
        least: 20_000,
    },
    LongWriter { line: "optimize design.pbrt -o better.pbrt --rays N --checkpoint state", least: 200 },
];

/// Number of kills of a command, unless a variable sets it.
const FEW_KILLS: u64 = 1;

/// Most runs that end before the first checkpoint.
const MOST_EARLY_ENDS: u64 = 5;

/// Kills each command at random moments of a run of about `seconds`, so many times; few kills come when the first checkpoint is there.
fn kill_at_random(writer: &LongWriter, inputs: &Content, kills: u64, seconds: f64) {
    let folder = Folder::new();
    let mut count = writer.least;
    let (line, whole, duration) = loop {
        restore(&folder, inputs);
        let line = format!("{} --threads 1 -q", writer.line.replace('N', &count.to_string()));
        let start = Instant::now();
        assert_eq!(run(&folder, &line).code, Some(0), "{line}");
        let duration = start.elapsed();
        // A part of the time is the same for every number.
        let factor = seconds / duration.as_secs_f64();
        if factor <= 1.25 {
            break (line, folder.content(), duration);
        }
        count = (count as f64 * factor.min(8.0)).ceil() as u64;
    };
    // Nothing of the whole run, or else a missing file would not be noticed.
    restore(&folder, inputs);
    let (mut done, mut ends, mut resumable, mut seed) = (0, 0, 0, 1_u64);
    let checkpoint = folder.path("state");
    while done < kills || ends == 0 {
        // After the last kill the run goes on to its end.
        let mut command = folder.prepared(PROGRAM);
        command.args(line.split_whitespace()).arg("--resume").env(DATE.0, DATE.1);
        let mut child = command.spawn().expect("the program starts");
        if done < kills {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let random = (seed >> 40) as f64 / f64::from(1 << 24) * 1.2;
            if kills > FEW_KILLS {
                std::thread::sleep(Duration::from_secs_f64(random * duration.as_secs_f64()));
            } else {
                while !checkpoint.exists() && child.try_wait().expect("a child").is_none() {
                    std::thread::sleep(Duration::from_millis(5));
                }
            }
            // It may have ended.
            let is_running = child.try_wait().expect("a child").is_none();
            done += u64::from(is_running);
            let _ = child.kill();
            resumable += u64::from(is_running && checkpoint.exists());
        }
        let ran = finish(child, &line);
        if ran.code.is_some() {
            assert_eq!(ran.code, Some(0), "{line}: {}", ran.stderr);
            assert!(folder.content() == whole, "{line} after {done} kills: {:?}", folder.content().keys());
            ends += 1;
            assert!(kills == 0 || done > 0 || ends < MOST_EARLY_ENDS, "{line} ends before it is killed");
            restore(&folder, inputs);
        }
    }
    assert!(kills == 0 || resumable > 0, "{line}: no run was killed after its first checkpoint");
    println!(
        "{done} kills, {resumable} of them after a checkpoint, {ends} ends with the same bits, {:.1} s: glanz {line}",
        duration.as_secs_f64()
    );
}

fn killed(number: usize) {
    let kills = number_of_kills();
    kill_at_random(&LONG_WRITERS[number], inputs(), kills, if kills > FEW_KILLS { 3.0 } else { 2.0 });
}

fn number_of_kills() -> u64 {
    number("GLANZ_FAILURES_KILLS", FEW_KILLS)
}

#[test]
fn render_killed_at_any_moment_ends_with_the_same_bits() {
    killed(0);
}

#[test]
fn bake_killed_at_any_moment_ends_with_the_same_bits() {
    killed(1);
}

#[test]
fn illuminate_killed_at_any_moment_ends_with_the_same_bits() {
    killed(2);
}

#[test]
fn optimize_killed_at_any_moment_ends_with_the_same_bits() {
    killed(3);
}
