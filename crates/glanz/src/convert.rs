//! Scenes as triangles, and their files.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glanz_formats::pbrt;
use glanz_formats::tessellated::{MeshMaterial, TessellatedScene, write_glb, write_obj, write_ply};
use glanz_light::{Spectrum, Wavelengths};
use glanz_math::{DMat4, DVec2, DVec3};
use glanz_scene::Description;
use glanz_scene::description::{GroupDescription, MaterialDescription};
use glanz_scene::studio::UpAxis;
use glanz_scene::tessellation::{GroupMesh, SceneTessellation, TessellationSettings};
use glanz_shading::TexturePoint;

use crate::axes::Axes;
use crate::error::{Error, FileFault};
use crate::event::Warning;
use crate::file;
use crate::loaded_scene::LoadedScene;

/// How close triangles are to surfaces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshSettings {
    /// Largest distance between triangles and surfaces (chordal deviation).
    pub deviation: ChordalDeviation,
    /// Largest angle between the normals at the corners of a triangle, radians, in (0, pi].
    pub angle: f64,
    /// Number of threads; 0 for all processors.
    pub threads: usize,
}

impl Default for MeshSettings {
    /// A thousandth of the size, 20 degrees, all processors.
    fn default() -> Self {
        Self { deviation: ChordalDeviation::OfSize(1e-3), angle: 20.0_f64.to_radians(), threads: 0 }
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

    /// Makes triangles of all shapes, without a studio; lights, camera and textures are no part of the result.
    ///
    /// # Errors
    /// [`Error::Tessellation`] for settings out of range, [`Error::Scene`] for invalid materials, [`Error::NoTriangles`],
    /// [`Error::Threads`].
    pub fn tessellate(&self, settings: &MeshSettings) -> Result<(MeshOutcome, Vec<Warning>), Error> {
        let description = self.description();
        let deviation = match settings.deviation {
            ChordalDeviation::Metres(metres) => metres,
            ChordalDeviation::OfSize(part) => {
                let size = description.bounds().diagonal().length();
                // A scene of one point has no size.
                part * if size > 0.0 && size.is_finite() { size } else { 1.0 }
            }
        };
        let threads = rayon::ThreadPoolBuilder::new().num_threads(settings.threads).build()?;
        let settings = TessellationSettings { deviation, angle: settings.angle };
        let (materials, warnings) = materials(self)?;
        let tessellation = threads.install(|| SceneTessellation::try_new(description, settings))?;
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
        Ok((outcome, warnings))
    }
}

/// The materials as a rasteriser shows them; textures are evaluated in the middle of the parameters.
fn materials(loaded: &LoadedScene) -> Result<(Vec<MeshMaterial>, Vec<Warning>), Error> {
    let (scene, warnings) = loaded.without_shapes().resolve()?;
    let wavelengths = Wavelengths::default();
    let rgb = |spectrum: Spectrum| spectrum.to_rgb(&wavelengths).map(|x| x.clamp(0.0, 1.0));
    let middle = TexturePoint::new(DVec2::splat(0.5), DVec3::ZERO);
    let material = |(number, described): (usize, &MaterialDescription)| {
        let preview = scene.materials().get(number);
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
    Ok((loaded.description().materials.iter().enumerate().map(material).collect(), warnings))
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
        let groups = self.description.groups.iter().chain([&self.description.world]);
        groups.map(|group| group.shapes.len()).sum()
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
