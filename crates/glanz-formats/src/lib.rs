#![doc = include_str!("../README.md")]
//!
//! # Modules
//! [`registry`] recognises a scene by content and reads it: [`load`] gives a
//! [`Description`](glanz_scene::Description), which `glanz-scene` resolves to a scene, and [`Diagnostics`]
//! with positions in the input. [`pbrt`] is the scene language, [`ply`], [`obj`] and [`stl`] read meshes, [`newell`] and [`rib`] lists of
//! patches, [`photometry`] the light of luminaires, [`step`] and [`iges`] CAD models (with [`cad`]), [`image`] reads and writes pictures, [`glb`] writes models with light, [`tessellated`] triangles. Any bytes give a result or an error, without a panic or an endless loop, and without
//! more memory than the size of the input justifies.

mod budget_reader;
pub mod cad;
mod content_kind;
mod file_list;
mod finder;
pub mod glb;
mod gltf;
mod growing_memory;
pub mod iges;
pub mod image;
mod model;
mod nearest;
pub mod newell;
pub mod obj;
pub mod pbrt;
pub mod photometry;
pub mod ply;
pub mod registry;
pub mod rib;
pub mod source;
pub mod step;
pub mod stl;
pub mod tessellated;

pub use content_kind::{ContentKind, ForeignFile, ForeignRemedy, OwnFile};
pub use file_list::{FileKind, SceneFile, SceneFileList};
pub use finder::read_file;
pub use glanz_scene::{Diagnostic, Diagnostics, Severity};
pub use photometry::Photometry;
pub use registry::{
    Loaded, MODEL_EXTENSIONS, ModelFormat, Options, SceneFormat, list_files, load, load_bytes, load_str,
};
pub use source::Sources;
