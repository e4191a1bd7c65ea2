//! Lowering of directives to a [`Description`]; one file per kind of object.

mod cad_file;
mod camera;
mod curve;
mod design;
mod disney;
mod extension;
mod file_shape;
mod film;
mod forward_names;
mod freeform;
mod image_light;
mod integrator;
mod layered_material;
mod light;
mod luminaire;
mod material;
mod material_stand_in;
mod material_sum;
mod medium;
mod mesh_file;
mod mix;
mod named;
mod object;
mod observer;
mod patch_file;
mod procedural_texture;
mod realistic_lens;
mod receiver;
mod roughness;
mod shape;
mod sky;
mod spectrum;
mod spline;
mod subdivision;
mod texture;
mod trim;

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::rc::Rc;

use glanz_job::Resource;
use glanz_math::DMat4;
use glanz_scene::Description;
use glanz_scene::description::{EmissionDescription, SurfaceMedia};
use glanz_scene::studio::{UpAxis, UpAxisError};
use glanz_shading::model::SurfaceFinish;

use crate::file_list::FileKind;
use crate::finder::{FileFinder, FindError, entry_bytes};
use crate::pbrt::color_space::ColorSpace;
use crate::pbrt::dialect::Dialect;
use crate::pbrt::parameters::{ParameterList, shortened};
use crate::source::{MISSING_FILE, ParseResult, Reporter, Span};

pub(crate) use cad_file::CadFile;
pub(crate) use film::finish_film;
pub(crate) use forward_names::ForwardNames;
pub(crate) use mesh_file::GltfFile;
pub(crate) use object::OpenObject;
pub(crate) use texture::{ImageKey, TextureNames};

/// State of the lowering.
#[derive(Debug)]
pub(crate) struct Lowering {
    pub(crate) description: Description,
    pub(crate) reporter: Reporter,
    pub(crate) dialect: Dialect,
    pub(crate) finder: FileFinder,
    /// Paths of the files being read, the innermost last; for names relative to them.
    pub(crate) reading: Vec<Option<PathBuf>>,
    /// The object to which shapes are added; `None` for the world.
    pub(crate) object: Option<OpenObject>,
    pub(crate) groups: BTreeMap<String, usize>,
    /// Number of emitting shapes, by group.
    pub(crate) lights_in_groups: BTreeMap<usize, usize>,
    /// Groups with lights that have an instance.
    pub(crate) lit_groups: BTreeSet<usize>,
    /// Number of lights created by further instances.
    pub(crate) light_copies: usize,
    pub(crate) cad_files: BTreeMap<PathBuf, CadFile>,
    pub(crate) gltf_files: BTreeMap<PathBuf, GltfFile>,
    pub(crate) materials: ForwardNames,
    pub(crate) default_material: Option<usize>,
    /// Finishes of mirrors by the text of their models, so that equal ones share their tables.
    pub(crate) finishes: BTreeMap<String, SurfaceFinish>,
    pub(crate) media: ForwardNames,
    /// Triangles of subdivided meshes so far.
    pub(crate) subdivided: usize,
    /// Number of skies so far.
    pub(crate) skies: usize,
    pub(crate) textures: TextureNames,
    pub(crate) images: BTreeMap<ImageKey, usize>,
    /// Problems of the files of pictures that cannot be decoded, or are beyond it.
    pub(crate) refused_pictures: BTreeMap<PathBuf, String>,
    pub(crate) has_film: bool,
    /// How long the shutter is open, seconds; 1 where it does not matter.
    pub(crate) shutter_time: f64,
    /// `exposuretime` of the film.
    pub(crate) exposure_time: Option<f64>,
    pub(crate) has_filter: bool,
    /// Whether the edges of CAD models are sampled.
    pub(crate) edges: bool,
    /// Upward axis of a model, to which a studio gives camera and light, with its place.
    pub(crate) studio_up: Option<(UpAxis, Span)>,
}

/// Error of a file that a parameter names.
#[derive(Clone, Debug)]
struct FileError {
    message: String,
    /// Whether the scene is not allowed to read it.
    refused: bool,
}

impl From<String> for FileError {
    fn from(message: String) -> Self {
        Self { message, refused: false }
    }
}

impl std::fmt::Display for FileError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.message)
    }
}

/// The part of the graphics state that is stored with a shape, light or texture.
#[derive(Clone, Debug)]
pub(crate) struct EntityState {
    pub(crate) ctm: DMat4,
    pub(crate) reverse_orientation: bool,
    pub(crate) material: Option<usize>,
    pub(crate) media: SurfaceMedia,
    pub(crate) emission: Option<Rc<EmissionDescription>>,
    pub(crate) color_space: ColorSpace,
}

impl Lowering {
    /// The initial state.
    pub(crate) fn new(reporter: Reporter, dialect: Dialect, finder: FileFinder) -> Self {
        Self {
            description: Description::default(),
            reporter,
            dialect,
            finder,
            reading: Vec::new(),
            object: None,
            groups: BTreeMap::new(),
            lights_in_groups: BTreeMap::new(),
            lit_groups: BTreeSet::new(),
            light_copies: 0,
            cad_files: BTreeMap::new(),
            gltf_files: BTreeMap::new(),
            materials: ForwardNames::default(),
            default_material: None,
            finishes: BTreeMap::new(),
            media: ForwardNames::default(),
            subdivided: 0,
            skies: 0,
            textures: TextureNames::default(),
            images: BTreeMap::new(),
            refused_pictures: BTreeMap::new(),
            has_film: false,
            shutter_time: 1.0,
            exposure_time: None,
            has_filter: false,
            edges: false,
            studio_up: None,
        }
    }

    /// `Option`: those of pbrt have no effect; `studio` makes the scene a model.
    pub(crate) fn option(&mut self, list: &mut ParameterList) -> ParseResult<()> {
        let Some((p, axis)) = list.text_parameter("studio", &mut self.reporter)? else { return Ok(()) };
        match axis.parse() {
            Ok(up) => self.studio_up = Some((up, p.value_place)),
            Err(UpAxisError) => {
                let message =
                    format!("Option \"studio\" is {:?}; it must be \"y\" or \"z\"", shortened(&axis));
                return Err(self.reporter.error(&p.value_place, "parameter-range", message));
            }
        }
        Ok(())
    }

    /// Takes an entry of a list of the description off the budget.
    fn spend_entry<T>(&mut self, name: &str, place: &Span) -> ParseResult<()> {
        self.reporter.spend(place, Resource::Memory, entry_bytes::<T>(name))
    }

    /// Finds a file that a parameter names.
    fn locate(&self, name: &str) -> Result<PathBuf, FindError> {
        self.finder.locate(name, self.reading.last().and_then(Option::as_deref))
    }

    /// Finds a file that a parameter names, and adds it to those of the scene.
    fn find(&mut self, name: &str, kind: FileKind) -> Result<PathBuf, FindError> {
        let asking = self.reading.last().and_then(Option::as_deref);
        self.finder.find(name, asking, kind)
    }

    /// Finds and reads a file that a parameter names, or returns the reason why not. The path is that for messages.
    fn read_file(&mut self, name: &str, kind: FileKind) -> Result<(PathBuf, Vec<u8>), FileError> {
        let path = self.find(name, kind).map_err(|fault| FileError {
            message: format!("file {name:?} {}", fault.what()),
            refused: fault == FindError::Outside,
        })?;
        match self.finder.read(&path, kind) {
            Ok(bytes) => Ok((self.finder.shown(&path).to_owned(), bytes)),
            Err(error) => Err(format!("file {name:?} cannot be read: {error}").into()),
        }
    }

    /// Reports a file that is not available: `message` states the problem, then the substitute.
    ///
    /// # Errors
    /// If the file is refused, because there is no substitute for it.
    fn without_file(&mut self, place: &Span, problem: &FileError, message: String) -> ParseResult<()> {
        if problem.refused {
            let help = Some(FindError::Outside.help().to_owned());
            let reporter = &mut self.reporter;
            return Err(reporter.error_with_help(place, MISSING_FILE, problem.message.clone(), help));
        }
        self.stand_in(place, MISSING_FILE, message);
        Ok(())
    }

    /// Reports a substitute.
    fn stand_in(&mut self, place: &Span, kind: &'static str, message: impl Into<String>) {
        self.reporter.stand_in(place, kind, message);
    }
}
