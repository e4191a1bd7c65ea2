//! `glanz bake`: from a scene to a model with light maps.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Instant;

use glanz_formats::glb;
use glanz_formats::image::{self, Format, write_atomically};
use glanz_light::Tone;
use glanz_radiosity::bake::{Atlas, BakeSettings, BakeState};
use glanz_radiosity::elements::Elements;
use serde::Serialize;

use crate::Ending;
use crate::arguments::{BakeArguments, LightMapName};
use crate::baking;
use crate::checkpoint_file;
use crate::interrupt;
use crate::light_file::{self, Keeper, LightIdentity, Start};
use crate::light_maps::{self, Axes, Making};
use crate::messages::{Failure, Messages};
use crate::outputs;
use crate::report::{self, duration, plural};
use crate::scene_file::{Input, SceneFile};
use crate::view;

/// Distance of triangles from the surface: metres, and per the diagonal of the scene.
const TOLERANCE: f64 = 0.001;
const TOLERANCE_OF_SCENE: f64 = 1.0 / 4000.0;

/// What `--json` prints.
#[derive(Serialize)]
struct Report {
    scene: String,
    outputs: Vec<String>,
    charts: usize,
    dark_charts: usize,
    texels: usize,
    side: u32,
    pages: usize,
    elements: usize,
    triangles: usize,
    tolerance: f64,
    checkpoint: Option<String>,
    seconds: f64,
    peak_memory_bytes: Option<u64>,
    warnings: Vec<String>,
}

/// Bakes the scene file.
///
/// # Errors
/// Why there is no model.
pub(crate) fn run(arguments: &BakeArguments, messages: Messages) -> Result<Ending, Failure> {
    let cancel = interrupt::listen()?;
    let output = &arguments.output;
    if !output.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("glb")) {
        return Err(Failure::usage(format!("{}: no format for models has this extension", output.display()))
            .with_help("models are written as .glb"));
    }
    outputs::check_writable(output)?;
    checkpoint_file::check(arguments.checkpoint.as_deref(), arguments.resume)?;
    baking::use_threads(arguments.threads)?;
    let mut file = SceneFile::read(&Input::File(&arguments.scene), arguments.strict, messages)?;
    let names = light_maps::names(&file.description);
    let (camera, film) = (file.description.camera.clone(), file.description.film.clone());
    let axes = Axes::of_camera(&camera.to_world);
    let scene = file.resolve(arguments.strict, messages)?;
    let start = Instant::now();
    let camera = view::camera(&camera, &film, axes, &scene.bounds());
    if camera.is_none() {
        let what = "a camera whose picture is off the middle, slanted or mirrored is not in the model";
        file.warn(what, messages);
    }
    let diagonal = scene.bounds().diagonal().length();
    let elements = baking::elements(&scene, arguments.texels_per_metre, &mut file, messages)?;
    messages.note(&format!(
        "baking {}: {} texels per metre, {}",
        arguments.scene.display(),
        arguments.texels_per_metre,
        plural(elements.list.len() as u64, "element", "elements")
    ));
    let settings =
        BakeSettings { density: arguments.texels_per_metre, rays: arguments.rays, ..BakeSettings::default() };
    let identity = LightIdentity::new(file.content_hash, settings);
    let keeper = arguments.checkpoint.as_deref().map(|path| Keeper { path, identity });
    let maps = match start_of(keeper.as_ref(), &elements, messages)? {
        Start::Finished(maps) => maps,
        Start::State(state) => {
            match baking::baked(state, &elements, &settings, keeper.as_ref(), messages, &cancel)? {
                Some(maps) => maps,
                None => {
                    messages.note(&ended(keeper.as_ref()));
                    return Ok(Ending::Interrupted);
                }
            }
        }
    };
    let coarse = maps.iter().filter(|map| map.chart.is_coarse && !map.is_dark()).count();
    if coarse > 0 {
        let charts = plural(coarse as u64, "chart has", "charts have");
        file.warn(&format!("{charts} fewer texels than asked for: 4096 along a side is the most"), messages);
    }

    let atlas = Atlas::new(&maps);
    let tolerance = arguments.tolerance.unwrap_or_else(|| {
        if diagonal > 0.0 { TOLERANCE.min(TOLERANCE_OF_SCENE * diagonal) } else { TOLERANCE }
    });
    let tone = outputs::tone(arguments.exposure, arguments.tone);
    let surfaces = &elements.surfaces;
    let making =
        Making { surfaces, maps: &maps, atlas: &atlas, names: &names, axes, camera, tolerance, tone };
    let model = making.model().map_err(|error| Failure::new(format!("the model: {error}")))?;
    let bytes = glb::write(&model).map_err(|error| Failure::new(format!("{}: {error}", output.display())))?;
    let mut written = write_pages(&atlas, output, arguments.lightmap, &tone)?;
    write_atomically(output, &bytes).map_err(|error| Failure::new(error.to_string()))?;
    written.insert(0, output.display().to_string());

    let triangles = model.nodes.iter().flat_map(|node| &node.parts).map(|part| part.indices.len()).sum();
    let report = Report {
        scene: arguments.scene.display().to_string(),
        outputs: written,
        charts: maps.len(),
        dark_charts: maps.iter().filter(|map| map.is_dark()).count(),
        texels: maps.iter().map(|map| map.irradiance.len()).sum(),
        side: atlas.side,
        pages: atlas.pages.len(),
        elements: elements.list.len(),
        triangles,
        tolerance,
        checkpoint: arguments.checkpoint.as_ref().map(|path| path.display().to_string()),
        seconds: start.elapsed().as_secs_f64(),
        peak_memory_bytes: report::peak_memory_bytes(),
        warnings: file.into_warnings(),
    };
    messages.note(&format!(
        "wrote {}: {} of light in {} of {} x {}, {}, in {}",
        report.outputs.join(", "),
        plural(report.texels as u64, "texel", "texels"),
        plural(report.pages as u64, "page", "pages"),
        report.side,
        report.side,
        plural(report.triangles as u64, "triangle", "triangles"),
        duration(report.seconds),
    ));
    if arguments.talk.json {
        report::print(&report)?;
    }
    Ok(Ending::Done)
}

/// Where the bake begins: with the checkpoint, if there is one.
fn start_of(
    keeper: Option<&Keeper<'_>>,
    elements: &Elements<'_>,
    messages: Messages,
) -> Result<Start, Failure> {
    let anew = || Start::State(BakeState::default());
    let Some(Keeper { path, identity }) = keeper else { return Ok(anew()) };
    // Without --resume it is refused if it exists.
    if !path.exists() {
        return Ok(anew());
    }
    let start = light_file::read(path)?.start(path, identity, elements)?;
    let path = path.display();
    messages.note(&match &start {
        Start::Finished(_) => format!("{path}: all light is there"),
        Start::State(state) if state.is_empty() => format!("{path}: there is no light yet"),
        Start::State(state) => {
            let places = plural(state.places() as u64, "place", "places");
            format!("{path}: going on with indirect light at {places}")
        }
    });
    Ok(start)
}

/// What is there after an interruption.
fn ended(keeper: Option<&Keeper<'_>>) -> String {
    match keeper {
        Some(Keeper { path, .. }) => {
            let path = path.display();
            format!("interrupted; {path} keeps what was found, the same command with --resume goes on")
        }
        None => "interrupted; nothing was written".to_owned(),
    }
}

/// Writes the irradiance beside the model; returns the names of the files.
fn write_pages(
    atlas: &Atlas,
    output: &Path,
    lightmap: LightMapName,
    tone: &Tone,
) -> Result<Vec<String>, Failure> {
    let (format, extension) = match lightmap {
        LightMapName::Exr => (Format::Exr, "exr"),
        LightMapName::Png => (Format::Png, "png"),
    };
    let mut names = Vec::new();
    for (number, page) in atlas.pages.iter().enumerate() {
        let path = page_path(output, number, extension);
        let pixels = light_maps::pixels(&page.irradiance, atlas.side)
            .map_err(|error| Failure::new(error.to_string()))?;
        let attributes = BTreeMap::from([("quantity".to_owned(), "irradiance".to_owned())]);
        let bytes = image::write(&pixels, format, tone, &attributes)
            .map_err(|error| Failure::new(format!("{}: {error}", path.display())))?;
        write_atomically(&path, &bytes).map_err(|error| Failure::new(error.to_string()))?;
        names.push(path.display().to_string());
    }
    Ok(names)
}

/// The file of a page: beside the model, with its number from the second on.
fn page_path(output: &Path, number: usize, extension: &str) -> PathBuf {
    if number == 0 {
        return output.with_extension(extension);
    }
    let stem = output.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    output.with_file_name(format!("{stem}-{}.{extension}", number + 1))
}
