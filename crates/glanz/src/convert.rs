//! Scenes as triangles, and their files.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::mpsc;
use std::time::{Duration, Instant};

use glanz_formats::pbrt;
use glanz_formats::tessellated::{MeshMaterial, TessellatedScene, write_glb, write_obj, write_ply};
use glanz_job::{Interrupted, JobProgress};
use glanz_light::{Spectrum, Wavelengths};
use glanz_math::{DMat4, DVec2, DVec3};
use glanz_scene::Description;
use glanz_scene::description::{GroupDescription, MaterialDescription};
use glanz_scene::studio::UpAxis;
use glanz_scene::tessellation::{GroupMesh, SceneTessellation, TessellationProgress, TessellationSettings};
use glanz_shading::TexturePoint;

use crate::axes::Axes;
use crate::error::{Error, FileFault};
use crate::event::{JobEvent, Warning};
use crate::file;
use crate::job_options::JobOptions;
use crate::loaded_scene::LoadedScene;
use crate::running_job::RunningJob;

/// How close triangles are to surfaces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshSettings {
    /// Largest distance between triangles and surfaces (chordal deviation).
    pub deviation: ChordalDeviation,
    /// Largest angle between the normals at the corners of a triangle, radians, in (0, pi].
    pub angle: f64,
}

impl Default for MeshSettings {
    /// A thousandth of the size, 20 degrees.
    fn default() -> Self {
        Self { deviation: ChordalDeviation::OfSize(1e-3), angle: 20.0_f64.to_radians() }
    }
}

/// A chordal deviation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ChordalDeviation {
    /// A length, metres.
    Metres(f64),
    /// A part of the diagonal of the scene's bounding box.
    OfSize(f64),
}

/// A scene as triangles.
#[derive(Clone, Debug)]
pub struct MeshOutcome {
    name: String,
    description: Description,
    tessellation: SceneTessellation,
    materials: Vec<MeshMaterial>,
    /// From the world to y up.
    to_model: DMat4,
    settings: TessellationSettings,
}

/// Numbers of solids: shapes of a group that the description says bound a volume together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SolidCounts {
    /// All solids, those of a group counted once.
    pub solids: usize,
    /// Those whose triangles are watertight.
    pub watertight: usize,
}

/// The formats of triangles by their extensions.
const FORMATS: [&str; 3] = ["glb", "obj", "ply"];

/// Time between two reports of progress.
const PROGRESS_INTERVAL: Duration = Duration::from_millis(500);

/// The extension of scene files.
const SCENE: &str = "pbrt";

/// Whether `path` is to be a file of exact surfaces: .pbrt. Otherwise it is one of triangles.
///
/// # Errors
/// [`Error::File`] if its extension is that of no format.
pub fn is_exact_path(path: &Path) -> Result<bool, Error> {
    let is_scene = path.extension().is_some_and(|own| own.eq_ignore_ascii_case(SCENE));
    if is_scene || extension(path).is_some() {
        return Ok(is_scene);
    }
    Err(FileFault::Extension("scenes").of(path))
}

/// The file of materials that is written beside an .obj file.
#[must_use]
pub fn material_path(path: &Path) -> Option<PathBuf> {
    (extension(path) == Some("obj")).then(|| path.with_extension("mtl"))
}

fn extension(path: &Path) -> Option<&'static str> {
    let own = path.extension()?.to_str()?.to_ascii_lowercase();
    FORMATS.into_iter().find(|format| *format == own)
}

/// The last part of a path.
fn file_name(path: &Path) -> String {
    path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned())
}

impl LoadedScene {
    /// Writes a model in the scene language: the same exact surfaces, parts, occurrences and materials, to which a render adds the same studio.
    ///
    /// # Errors
    /// [`Error::NoModel`] for a scene, [`Error::File`].
    pub fn save_exact(&self, path: impl AsRef<Path>) -> Result<(), Error> {
        let path = path.as_ref();
        let Some(studio) = self.studio_settings() else {
            return Err(Error::NoModel { name: self.name().to_owned() });
        };
        let text = pbrt::write(self.description(), studio.up.unwrap_or_default());
        file::write(path, text.map_err(Error::of_file(path))?.as_bytes())
    }

    /// Makes triangles of all shapes, without a studio; lights, camera and textures are no part of the result. Options of checkpoints have no effect.
    ///
    /// # Errors
    /// [`Error::Tessellation`] for settings out of range, [`Error::Scene`] for invalid materials, [`Error::NoTriangles`],
    /// [`Error::Threads`], [`Error::Interrupted`].
    pub fn tessellate(
        &self,
        settings: &MeshSettings,
        options: JobOptions<'_>,
    ) -> Result<(MeshOutcome, Vec<Warning>), Error> {
        let mut job = options.start();
        let description = self.description();
        let deviation = match settings.deviation {
            ChordalDeviation::Metres(metres) => metres,
            ChordalDeviation::OfSize(part) => {
                let size = description.bounds().diagonal().length();
                // A scene of one point has no size.
                part * if size > 0.0 && size.is_finite() { size } else { 1.0 }
            }
        };
        let settings = TessellationSettings { deviation, angle: settings.angle };
        let (materials, warnings) = materials(self)?;
        warnings.into_iter().for_each(|warning| job.warn(warning));
        job.emit(JobEvent::TessellationStarted { shapes: shape_count(description) });
        let tessellation = tessellation(description, settings, &mut job)?;
        if tessellation.triangle_count() == 0 {
            return Err(Error::NoTriangles { scene: self.name().to_owned() });
        }
        let to_model = match self.studio_settings() {
            Some(studio) => match studio.up.unwrap_or_default() {
                UpAxis::Y => DMat4::IDENTITY,
                UpAxis::Z => DMat4::from_cols_array_2d(&[
                    [1.0, 0.0, 0.0, 0.0],
                    [0.0, 0.0, -1.0, 0.0],
                    [0.0, 1.0, 0.0, 0.0],
                    [0.0, 0.0, 0.0, 1.0],
                ]),
            },
            None => Axes::of_camera(&description.camera.to_world).matrix(),
        };
        let outcome = MeshOutcome {
            // Files do not depend on the folder of the scene.
            name: file_name(Path::new(self.name())),
            description: description.clone(),
            tessellation,
            materials,
            to_model,
            settings,
        };
        Ok((outcome, job.warnings))
    }
}

/// The triangles, made by the threads of the job, whose sink this thread serves meanwhile.
fn tessellation(
    description: &Description,
    settings: TessellationSettings,
    job: &mut RunningJob<'_>,
) -> Result<SceneTessellation, Error> {
    let threads = rayon::ThreadPoolBuilder::new().num_threads(job.options.threads).build()?;
    let progress = TessellationProgress::new(job.options.cancel.clone());
    let start = Instant::now();
    let (ended, end) = mpsc::channel::<()>();
    let mut made = Err(Interrupted.into());
    threads.in_place_scope(|scope| {
        scope.spawn(|_| {
            // Dropped when the work ends, however it ends.
            let _ended = ended;
            made = SceneTessellation::try_new(description, settings, &progress);
        });
        while end.recv_timeout(PROGRESS_INTERVAL) == Err(mpsc::RecvTimeoutError::Timeout) {
            if let Some(sink) = &mut job.options.sink {
                sink.on_progress(&JobProgress::by_work("triangles", progress.fraction(), start.elapsed()));
            }
        }
    });
    Ok(made?)
}

/// Number of shapes, those of a group counted once.
fn shape_count(description: &Description) -> usize {
    description.groups.iter().chain([&description.world]).map(|group| group.shapes.len()).sum()
}

/// The materials as a rasteriser shows them; textures are evaluated in the middle of the parameters.
fn materials(loaded: &LoadedScene) -> Result<(Vec<MeshMaterial>, Vec<Warning>), Error> {
    let (scene, warnings) = loaded.without_shapes().resolve()?;
    let wavelengths = Wavelengths::default();
    let rgb = |spectrum: Spectrum| spectrum.to_rgb(&wavelengths).map(|x| x.clamp(0.0, 1.0));
    let middle = TexturePoint::new(DVec2::splat(0.5), DVec3::ZERO);
    let material = |(number, described): (usize, &MaterialDescription)| {
        // Of a mixture the part with the larger weight.
        let preview = scene.material_at(number, &middle, &wavelengths, 0.5);
        let preview = preview.and_then(|material| material.preview(scene.textures(), &middle, &wavelengths));
        let name = described.name.clone();
        match preview {
            Some(preview) => MeshMaterial {
                name,
                base: rgb(preview.base),
                metallic: preview.metallic,
                roughness: preview.roughness,
                transmission: 1.0 - preview.opacity,
            },
            // Light passes an interface as if there were no surface.
            None => MeshMaterial { name, base: [1.0; 3], metallic: 0.0, roughness: 1.0, transmission: 1.0 },
        }
    };
    let materials = loaded.description().materials.iter().enumerate().map(material).collect();
    scene.check_textures()?;
    Ok((materials, warnings))
}

impl MeshOutcome {
    /// The triangles, by group and shape.
    #[must_use]
    pub fn tessellation(&self) -> &SceneTessellation {
        &self.tessellation
    }

    /// The settings, with the deviation in metres.
    #[must_use]
    pub fn settings(&self) -> TessellationSettings {
        self.settings
    }

    /// Number of shapes, those of a group counted once.
    #[must_use]
    pub fn shape_count(&self) -> usize {
        shape_count(&self.description)
    }

    /// Whether the scene has lights, textures or light-emitting shapes, which files of triangles do not have.
    #[must_use]
    pub fn has_light_or_textures(&self) -> bool {
        let groups = self.description.groups.iter().chain([&self.description.world]);
        !self.description.lights.is_empty()
            || !self.description.textures.is_empty()
            || groups.flat_map(|group| &group.shapes).any(|shape| shape.emission.is_some())
    }

    /// Numbers of solids.
    #[must_use]
    pub fn solids(&self) -> SolidCounts {
        let mut counts = SolidCounts::default();
        let own = (&self.description.world, &self.tessellation.world);
        for (group, mesh) in self.description.groups.iter().zip(&self.tessellation.groups).chain([own]) {
            count_solids(group, mesh, &mut counts);
        }
        counts
    }

    /// Writes the triangles in the format of the extension: .glb (y up), .obj with .mtl beside it, or .ply; metres. Returns the files.
    ///
    /// # Errors
    /// [`Error::File`].
    pub fn save(&self, path: impl AsRef<Path>) -> Result<Vec<PathBuf>, Error> {
        let path = path.as_ref();
        let scene = TessellatedScene {
            name: &self.name,
            description: &self.description,
            tessellation: &self.tessellation,
            materials: &self.materials,
            to_file: DMat4::IDENTITY,
        };
        let mut paths = vec![path.to_owned()];
        match extension(path) {
            Some("glb") => {
                let upright = TessellatedScene { to_file: self.to_model, ..scene };
                file::write(path, &write_glb(&upright).map_err(Error::of_file(path))?)?;
            }
            Some("obj") => {
                let name = file_name(&path.with_extension("mtl"));
                let files = write_obj(&scene, &name).map_err(Error::of_file(path))?;
                let library = path.with_file_name(&files.library);
                file::write(&library, files.mtl.as_bytes())?;
                file::write(path, files.obj.as_bytes())?;
                paths.push(library);
            }
            Some(_) => file::write(path, &write_ply(&scene).map_err(Error::of_file(path))?)?,
            None => return Err(FileFault::Extension("scenes").of(path)),
        }
        Ok(paths)
    }
}

fn count_solids(group: &GroupDescription, mesh: &GroupMesh, counts: &mut SolidCounts) {
    let mut solids: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for (number, shape) in group.shapes.iter().enumerate() {
        if let Some(solid) = shape.solid {
            solids.entry(solid).or_default().push(number);
        }
    }
    counts.solids += solids.len();
    let has_triangles =
        |&shape: &usize| mesh.shapes.get(shape).is_some_and(|shape| !shape.triangles.is_empty());
    let is_watertight = |shapes: &Vec<usize>| {
        shapes.iter().all(has_triangles) && mesh.open_sides(shapes.iter().copied()) == 0
    };
    counts.watertight += solids.into_values().filter(is_watertight).count();
}

#[cfg(test)]
mod tests {
    use glanz_job::{CancelFlag, ProgressSink};
    use glanz_scene::description::ShapeDescription;

    use super::*;

    /// Cancels a job as soon as it reports progress.
    struct Stopper {
        cancel: CancelFlag,
        fractions: Vec<f64>,
    }

    impl ProgressSink for Stopper {
        fn on_progress(&mut self, progress: &JobProgress<'_>) {
            self.fractions.push(progress.fraction);
            self.cancel.cancel();
        }
    }

    #[test]
    fn a_conversion_reports_its_progress_and_ends_when_it_is_cancelled() {
        let mut description = Description::default();
        let ball = |i: u32| ShapeDescription::sphere(1.0).translated([3.0 * f64::from(i), 0.0, 0.0]);
        description.world.shapes = (0..4000).map(ball).collect();
        let scene = LoadedScene::from_description("balls", description);
        let cancel = CancelFlag::default();
        let mut stopper = Stopper { cancel: cancel.clone(), fractions: Vec::new() };
        let options = JobOptions::default().threads(1).cancel(cancel).on_progress(&mut stopper);
        let deviation = ChordalDeviation::Metres(1e-5);
        let made = scene.tessellate(&MeshSettings { deviation, ..MeshSettings::default() }, options);
        assert!(matches!(made, Err(Error::Interrupted(_))), "{made:?}");
        assert!(!stopper.fractions.is_empty() && stopper.fractions.iter().all(|f| (0.0..1.0).contains(f)));
    }
}
