//! Times of the steps from a STEP file to a scene: parsing and lowering alone, edges laid onto surfaces, and surfaces with their hierarchies.
//!
//!     cargo run --release -p glanz-formats --example peer_read -- [--rounds N] FILE.step ...
//!
//! Prints the least wall-clock time of N rounds (5 by default) of each step, and bytes of the file per second of `read`, which uses one
//! thread. `faces` and `scene` use as many as RAYON_NUM_THREADS says, or as there are processors.

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use glanz_brep::face::trimmed_faces;
use glanz_formats::{Options, load, step};
use glanz_scene::Scene;

type Failure = Box<dyn std::error::Error>;

fn main() -> Result<(), Failure> {
    let (mut rounds, mut files) = (5, Vec::new());
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        if argument == "--rounds" {
            rounds = arguments.next().ok_or("--rounds needs a number")?.parse()?;
        } else {
            files.push(PathBuf::from(argument));
        }
    }
    let mut output = std::io::stdout();
    writeln!(output, "| file | MB | faces | read, ms | read, MB/s | faces, ms | scene, ms |")?;
    writeln!(output, "|---|---|---|---|---|---|---|")?;
    for file in &files {
        writeln!(output, "{}", row(file, rounds)?)?;
    }
    Ok(())
}

fn row(file: &Path, rounds: usize) -> Result<String, Failure> {
    let bytes = std::fs::read(file)?;
    let (model, read) = least(rounds, || (), |()| step::read(&bytes));
    let model = model?.model;
    let (_, faces) = least(rounds, || (), |()| trimmed_faces(&model));
    let loaded = load(file, &Options::default()).map_err(|diagnostics| diagnostics.to_string())?;
    let (scene, resolve) = least(rounds, || loaded.description.clone(), Scene::resolve);
    scene.map_err(|error| error.kind.to_string())?;
    let megabytes = bytes.len() as f64 / 1e6;
    let milliseconds = |time: Duration| time.as_secs_f64() * 1e3;
    let name = file.file_name().map(|name| name.display().to_string()).unwrap_or_default();
    Ok(format!(
        "| {name} | {megabytes:.2} | {} | {:.1} | {:.0} | {:.1} | {:.1} |",
        model.faces.len(),
        milliseconds(read),
        megabytes / read.as_secs_f64(),
        milliseconds(faces),
        milliseconds(resolve),
    ))
}

/// The least time of `work` on what `prepare` makes, which is not timed, and the last result.
fn least<I, T>(rounds: usize, prepare: impl Fn() -> I, work: impl Fn(I) -> T) -> (T, Duration) {
    let once = || {
        let input = prepare();
        let start = Instant::now();
        let result = work(input);
        (result, start.elapsed())
    };
    let first = once();
    (1..rounds).fold(first, |(_, time), _| {
        let (result, next) = once();
        (result, time.min(next))
    })
}
