//! Files of models.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glanz_formats::glb::{self, GlbCamera, GlbModel};
use glanz_formats::image::{self, Format};
use glanz_light::Tone;
use glanz_math::Bounds3;
use glanz_scene::Description;
use glanz_scene::description::{CameraDescription, FilmDescription};

use super::model::{ModelBuilder, pixels};
use super::model_camera;
use super::outcome::BakeOutcome;
use crate::axes::Axes;
use crate::error::{Error, FileFault};
use crate::file;

/// Default distance of triangles from the surface: metres, and relative to the diagonal of the scene.
const TOLERANCE: f64 = 0.001;
const TOLERANCE_OF_SCENE: f64 = 1.0 / 4000.0;

/// Settings of a model and its files.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModelSettings {
    /// Largest distance of triangles from the surface, metres; `None`: 0.001, or less in a small scene.
    pub tolerance: Option<f64>,
    /// Tone curve of the pictures on surfaces.
    pub tone: Tone,
    /// Format of the irradiance files.
    pub irradiance: Format,
}

impl Default for ModelSettings {
    fn default() -> Self {
        Self { tolerance: None, tone: Tone::default(), irradiance: Format::Exr }
    }
}

/// Files written by a bake.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelFiles {
    /// The files: the model, then the pages of irradiance.
    pub paths: Vec<PathBuf>,
    /// Number of triangles.
    pub triangles: usize,
    /// Largest distance of triangles from the surface, metres.
    pub tolerance: f64,
}

/// Parts of the description that a model contains.
#[derive(Clone, Debug)]
pub(super) struct ModelView {
    camera: CameraDescription,
    film: FilmDescription,
    /// For each shape, in the order of the scene file: the name of its material, with its number.
    names: Vec<String>,
}

impl ModelView {
    pub(super) fn of(description: &Description) -> Self {
        let groups = description.groups.iter().chain([&description.world]);
        let shapes = groups.flat_map(|group| &group.shapes).enumerate();
        let names = shapes.map(|(number, shape)| {
            let material = description.materials.get(shape.material).map_or("", |material| &material.name);
            if material.is_empty() { format!("shape {number}") } else { format!("{material} {number}") }
        });
        let names = names.collect();
        Self { camera: description.camera.clone(), film: description.film.clone(), names }
    }

    fn axes(&self) -> Axes {
        Axes::of_camera(&self.camera.to_world)
    }

    /// The camera of the model; `None` if models cannot represent it.
    pub(super) fn camera(&self, bounds: &Bounds3) -> Option<GlbCamera> {
        model_camera::camera(&self.camera, &self.film, self.axes(), bounds)
    }
}

impl BakeOutcome {
    /// Writes a model, binary glTF 2.0 with a picture of the light on each surface, and the irradiance beside it as OpenEXR.
    ///
    /// # Errors
    /// [`Error::File`].
    pub fn save(&self, path: impl AsRef<Path>) -> Result<ModelFiles, Error> {
        self.save_with(path, &ModelSettings::default())
    }

    /// As [`BakeOutcome::save`], with settings.
    ///
    /// # Errors
    /// [`Error::File`].
    pub fn save_with(&self, path: impl AsRef<Path>, settings: &ModelSettings) -> Result<ModelFiles, Error> {
        let path = path.as_ref();
        check_model_path(path)?;
        let tolerance = self.tolerance(settings);
        let model = self.model(settings)?;
        let bytes = glb::write(&model).map_err(Error::of_file(path))?;
        let mut paths = vec![path.to_owned()];
        paths.extend(self.save_pages(path, settings)?);
        file::write(path, &bytes)?;
        let parts = model.nodes.iter().flat_map(|node| &node.parts);
        Ok(ModelFiles { paths, triangles: parts.map(|part| part.indices.len()).sum(), tolerance })
    }

    /// The model, one node for each shape in its place.
    ///
    /// # Errors
    /// [`Error::Pixels`] if a page cannot be converted to a picture.
    pub fn model(&self, settings: &ModelSettings) -> Result<GlbModel, Error> {
        let builder = ModelBuilder {
            surfaces: &self.scene.placed_surfaces(),
            maps: &self.maps,
            atlas: &self.atlas,
            names: &self.view.names,
            axes: self.view.axes(),
            camera: self.view.camera(&self.scene.bounds()),
            tolerance: self.tolerance(settings),
            tone: settings.tone,
        };
        builder.build()
    }

    fn tolerance(&self, settings: &ModelSettings) -> f64 {
        let diagonal = self.scene.bounds().diagonal().length();
        let usual = if diagonal > 0.0 { TOLERANCE.min(TOLERANCE_OF_SCENE * diagonal) } else { TOLERANCE };
        settings.tolerance.unwrap_or(usual)
    }

    /// Writes the irradiance beside the model `path`; returns the files.
    fn save_pages(&self, path: &Path, settings: &ModelSettings) -> Result<Vec<PathBuf>, Error> {
        let mut paths = Vec::new();
        for (number, page) in self.atlas.pages.iter().enumerate() {
            let path = page_path(path, number, settings.irradiance);
            let pixels = pixels(&page.irradiance, self.atlas.side)?;
            let attributes = BTreeMap::from([("quantity".to_owned(), "irradiance".to_owned())]);
            let bytes = image::write(&pixels, settings.irradiance, &settings.tone, &attributes);
            file::write(&path, &bytes.map_err(Error::of_file(&path))?)?;
            paths.push(path);
        }
        Ok(paths)
    }
}

/// Refuses an extension that is not that of a supported model format.
///
/// # Errors
/// [`Error::File`] with [`FileFault::Extension`].
pub fn check_model_path(path: &Path) -> Result<(), Error> {
    let is_model = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("glb"));
    if is_model { Ok(()) } else { Err(FileFault::Extension("models").of(path)) }
}

/// The file of a page of light: beside the model, with its number from the second on.
#[must_use]
pub fn page_path(model: &Path, number: usize, format: Format) -> PathBuf {
    let extension = if format == Format::Png { "png" } else { "exr" };
    if number == 0 {
        return model.with_extension(extension);
    }
    let stem = model.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    model.with_file_name(format!("{stem}-{}.{extension}", number + 1))
}
