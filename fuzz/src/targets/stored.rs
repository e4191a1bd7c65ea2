//! Files that Glanz itself writes: states of its jobs, and their results.
//!
//! They have checksums, which no mutant passes. So a case reads its bytes as they are, which fails, and again with length and checksums corrected.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

use glanz::illumination::GridResolution;
use glanz::illumination::optimize::OptimizeSettings;
use glanz::job::JobPart;
use glanz::transport::codec::{CRC_LENGTH, PREFIX_LENGTH};
use glanz::transport::{Checkpoint, Guide};
use glanz::{
    Error, IlluminateMethod, IlluminateOptions, JobOptions, LightFile, LoadedScene, LuxFolder, MergeOptions,
    MergeOutcome, RenderOptions, merge,
};

use super::{ReadOutcome, Target, of_both, unusable, with_file, with_folder};
use crate::mutation::Syntax;

/// A target of binary files.
macro_rules! stored {
    ($name:literal, $seed:expr, $run:expr, $divisor:literal) => {
        Target {
            name: $name,
            syntax: Syntax::Binary(400),
            seeds: || made($name, $seed),
            run: $run,
            memory_factor: 1000,
            divisor: $divisor,
        }
    };
}

pub(super) const TARGETS: &[Target] = &[
    stored!("checkpoint", checkpoint, |bytes| of_both(bytes, &sealed_film(bytes), film), 1),
    stored!(
        "guide",
        guide,
        |bytes| of_both(bytes, &sealed(bytes), |bytes| Guide::from_bytes(bytes).into()),
        1
    ),
    stored!("tally", tally, |bytes| of_both(bytes, &sealed(bytes), joined), 10),
    stored!("light", light, |bytes| of_both(bytes, &sealed(bytes), joined), 10),
    stored!("light-maps", light_maps, |bytes| of_both(bytes, &sealed(bytes), shown), 100),
    stored!("optimize", optimize, |bytes| of_both(bytes, &sealed(bytes), continued), 100),
    Target {
        name: "lux-report",
        syntax: Syntax::Text(&[
            "null",
            "[",
            "]",
            "{",
            "}",
            ",",
            "\"cells\": [1, 1],",
            "\"name\": \"../x\",",
            "\"receivers\": [],",
        ]),
        seeds: || made("lux-report", |_| lux_folder().and_then(|()| bytes_of("lux/report.json"))),
        run: |bytes| lux("report.json", bytes),
        memory_factor: 1000,
        divisor: 10,
    },
    Target {
        name: "lux-map",
        syntax: Syntax::Binary(500),
        seeds: || made("lux-map", |_| lux_folder().and_then(|()| bytes_of("lux/floor.exr"))),
        run: |bytes| lux("floor.exr", bytes),
        memory_factor: 20_000,
        divisor: 10,
    },
];

/// A room of one floor, which is a receiver, with a lamp and a mirror whose radius is free.
const ROOM: &str = r#"LookAt 0 0 3  0 0 0  0 1 0 Camera "perspective" "float fov" 40 Film "rgb" "integer xresolution" 6 "integer yresolution" 4 WorldBegin
AttributeBegin Material "diffuse" "rgb reflectance" [0 0 0] AreaLightSource "diffuse" "float lumens" 1000 Translate 0 0 -.05
Shape "disk" "float radius" .002 AttributeEnd
AttributeBegin Material "mirror" "rgb Kr" [1 1 1] Shape "bezierpatch" "integer udegree" 2 "integer vdegree" 2
"string free" "P" "float freerange" [-.05 .2] "integer freegroups" [0 1 0 2 3 2 0 1 0]
"point3 P" [-.1 -.1 0 0 -.1 0 .1 -.1 0 -.1 0 0 0 0 0 .1 0 0 -.1 .1 0 0 .1 0 .1 .1 0] AttributeEnd
Material "diffuse" "rgb reflectance" [.5 .4 .3] Translate 0 0 -1
Shape "plane" "float x" [-.5 .5] "float y" [-.35 .35] "string receiver" "floor" "integer cells" [4 3] "string target" "even"
"#;

thread_local! {
    static LOADED_ROOM: RefCell<Option<LoadedScene>> = const { RefCell::new(None) };
}

/// The room, which a thread reads once.
fn room() -> Result<LoadedScene, Error> {
    LOADED_ROOM.with_borrow_mut(|room| {
        if let Some(room) = room {
            return Ok(room.clone());
        }
        let folder = with_folder(std::path::Path::to_owned);
        let options = glanz::formats::Options { folder: Some(folder), ..Default::default() };
        Ok(room.insert(glanz::open_str("room", ROOM, &options)?).clone())
    })
}

/// The file that `make` writes; panics if it cannot. Files of a name are made once.
fn made(name: &'static str, make: fn(JobOptions<'_>) -> Result<Vec<u8>, Error>) -> Vec<Vec<u8>> {
    static MADE: Mutex<BTreeMap<&str, Vec<Vec<u8>>>> = Mutex::new(BTreeMap::new());
    let mut all = MADE.lock().unwrap_or_else(PoisonError::into_inner);
    let files = all.entry(name).or_insert_with(|| {
        let path = with_folder(|folder| folder.join("seed"));
        // A checkpoint of another target.
        let _ = std::fs::remove_file(&path);
        let result = make(JobOptions::default().threads(1).checkpoint(path));
        let bytes = result.unwrap_or_else(|error| unmade(name, &error.to_string()));
        if bytes.is_empty() {
            unmade(name, "it is empty");
        }
        vec![bytes]
    });
    files.clone()
}

#[expect(clippy::panic, reason = "without its seed a target tests nothing")]
fn unmade(name: &str, reason: &str) -> ! {
    panic!("the seed of {name} cannot be made: {reason}")
}

/// The bytes of a file in the folder of this thread; of the checkpoint, if `name` is "seed".
fn bytes_of(name: &str) -> Result<Vec<u8>, Error> {
    with_folder(|folder| glanz::file::read(&folder.join(name)))
}

fn render_options(integrator: &str) -> RenderOptions {
    let (integrator, samples) = (Some(integrator.to_owned()), Some(4));
    RenderOptions { integrator, size: Some([2, 2]), samples, ..RenderOptions::default() }
}

fn checkpoint(job: JobOptions<'_>) -> Result<Vec<u8>, Error> {
    room()?.render().options(render_options("path")).job(job).run()?;
    bytes_of("seed")
}

fn guide(_: JobOptions<'_>) -> Result<Vec<u8>, Error> {
    let options = RenderOptions { samples: Some(16), size: Some([6, 4]), ..render_options("guided") };
    let picture = room()?.render().options(options).threads(1).run()?;
    with_folder(|folder| picture.save_guide(folder.join("guide")))?;
    bytes_of("guide")
}

fn tally(job: JobOptions<'_>) -> Result<Vec<u8>, Error> {
    let options =
        IlluminateOptions { method: IlluminateMethod::Trace, part: JobPart::try_new(1, 1), ..lux_options() };
    room()?.illuminate().options(options).particles(200).job(job).run()?;
    bytes_of("seed")
}

fn lux_options() -> IlluminateOptions {
    let (method, resolution) = (IlluminateMethod::Integrate, GridResolution::Longer(4));
    IlluminateOptions { method, resolution, tolerance: 0.1, ..IlluminateOptions::default() }
}

fn light(job: JobOptions<'_>) -> Result<Vec<u8>, Error> {
    use glanz::radiosity::bake::BakePart;
    let Some(part) = JobPart::try_new(1, 1) else { return Ok(Vec::new()) };
    let part = BakePart { part, direct_only: true };
    room()?.bake().density(4.0).rays(4).job(job).run_part(part, None)?;
    bytes_of("seed")
}

fn light_maps(job: JobOptions<'_>) -> Result<Vec<u8>, Error> {
    room()?.bake().density(4.0).rays(4).job(job).run()?;
    bytes_of("seed")
}

const DESIGN: OptimizeSettings = OptimizeSettings {
    rays: 50,
    iterations: 1,
    seed: 0,
    gradient: glanz::illumination::optimize::GradientMethod::Adjoint,
};

fn optimize(job: JobOptions<'_>) -> Result<Vec<u8>, Error> {
    room()?.optimize().settings(DESIGN).job(job).run()?;
    bytes_of("seed")
}

/// Writes the lux maps of the room into the folder of this thread.
fn lux_folder() -> Result<(), Error> {
    with_folder(|folder| {
        if folder.join("lux").is_dir() {
            return Ok(());
        }
        room()?.illuminate().options(lux_options()).threads(1).run()?.save(folder.join("lux")).map(drop)
    })
}

/// The bytes with their length and their last checksum corrected.
fn sealed(bytes: &[u8]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    set_length(&mut bytes);
    seal_end(&mut bytes, 0..0);
    bytes
}

/// The bytes of a film with their length and both checksums corrected.
fn sealed_film(bytes: &[u8]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    set_length(&mut bytes);
    let head =
        bytes.get(PREFIX_LENGTH..).and_then(|rest| rest.first_chunk()).map(|word| u64::from_le_bytes(*word));
    let end =
        usize::try_from(head.unwrap_or_default()).unwrap_or(usize::MAX).saturating_add(PREFIX_LENGTH + 8);
    let crc = end..end.saturating_add(CRC_LENGTH);
    let sum = bytes.get(..end).map(crc32fast::hash).unwrap_or_default();
    match bytes.get_mut(crc.clone()) {
        Some(slot) => {
            slot.copy_from_slice(&sum.to_le_bytes());
            seal_end(&mut bytes, crc);
        }
        None => seal_end(&mut bytes, 0..0),
    }
    bytes
}

fn set_length(bytes: &mut [u8]) {
    let length = (bytes.len() as u64).to_le_bytes();
    bytes
        .iter_mut()
        .take(PREFIX_LENGTH)
        .skip(PREFIX_LENGTH - 8)
        .zip(length)
        .for_each(|(to, from)| *to = from);
}

/// Sets the checksum at the end, which does not count those bytes.
fn seal_end(bytes: &mut [u8], without: std::ops::Range<usize>) {
    let Some((covered, slot)) = bytes.split_last_chunk_mut::<CRC_LENGTH>() else { return };
    let mut covered = covered.to_vec();
    if without.end <= covered.len() {
        covered.drain(without);
    }
    *slot = crc32fast::hash(&covered).to_le_bytes();
}

fn film(bytes: &[u8]) -> ReadOutcome {
    let result = Checkpoint::from_bytes(bytes);
    if let Ok(checkpoint) = &result {
        // What is read is written with the same meaning.
        let written = checkpoint.to_bytes().unwrap_or_default();
        let again = Checkpoint::from_bytes(&written).map(|again| again.to_bytes().unwrap_or_default());
        assert!(again == Ok(written), "a film changes when it is written");
    }
    result.into()
}

/// Joins the only part of a job.
fn joined(bytes: &[u8]) -> ReadOutcome {
    with_file("part", bytes, |path| {
        let result = merge(
            [path],
            MergeOptions { partial: true, ..MergeOptions::default() },
            JobOptions::default().threads(1),
        );
        if let Ok(MergeOutcome::Illuminance(tally)) = &result {
            let _ = tally.tally().balance();
        }
        result.into()
    })
}

/// Shows stored light, after a look at its identity.
fn shown(bytes: &[u8]) -> ReadOutcome {
    with_file("part", bytes, |path| {
        let result = LightFile::read(path).and_then(|_| {
            let options = RenderOptions { light_input: Some(path.to_owned()), ..render_options("radiosity") };
            let picture =
                room()?.render().options(RenderOptions { samples: Some(1), ..options }).threads(1).run()?;
            picture.pixels()
        });
        if let Ok(pixels) = &result {
            assert!(
                pixels.channels().iter().flat_map(|c| &c.values).all(|v| v.is_finite()),
                "a pixel is not finite"
            );
        }
        result.into()
    })
}

/// Continues an inverse design.
fn continued(bytes: &[u8]) -> ReadOutcome {
    with_file("state", bytes, |path| {
        let job = JobOptions::default().threads(1).checkpoint(path.to_owned()).resume(true);
        room().and_then(|room| room.optimize().settings(DESIGN).job(job).run()).into()
    })
}

/// Reads lux maps, of which this file has these bytes, and places them in the room.
fn lux(name: &str, bytes: &[u8]) -> ReadOutcome {
    let result = lux_folder().and_then(|()| {
        let [whole, mutant] = with_folder(|folder| ["lux", "mutant-lux"].map(|name| folder.join(name)));
        glanz::file::make_folder(&mutant)?;
        for file in ["report.json", "floor.exr"] {
            let own = if file == name { bytes.to_vec() } else { glanz::file::read(&whole.join(file))? };
            // Not by `glanz::file::write`, which waits for the disk.
            std::fs::write(mutant.join(file), own).unwrap_or_else(|error| unusable(&error));
        }
        let maps = LuxFolder::read(&mutant)?;
        let (scene, _) = room()?.resolve()?;
        maps.place(&scene).map(drop)
    });
    result.into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[should_panic(expected = "the seed of empty cannot be made: it is empty")]
    fn empty_seeds_are_refused() {
        made("empty", |_| Ok(Vec::new()));
    }
}
