//! The scene that pages show.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use axum::body::Bytes;
use glanz_formats::{Diagnostic, Diagnostics, Options, Severity, load};
use glanz_job::{BudgetError, LimitError, Resource, ResourceBudget, ResourceLimits};
use glanz_scene::studio::add_studio;
use glanz_scene::{Description, Scene, SceneError, SceneErrorKind};

use super::label::file_name;
use super::overlay::SceneOverlay;
use crate::model::Model;

/// An immutable scene, read from a file, with the model that pages draw.
#[derive(Debug)]
pub struct ViewerScene {
    pub(crate) name: String,
    pub(crate) description: Arc<Description>,
    pub(crate) scene: Arc<Scene>,
    pub(crate) model: Model,
    /// The model as it is sent.
    pub(crate) bytes: Bytes,
    /// The files that it was read from.
    pub(crate) paths: Vec<PathBuf>,
    /// Budget of the scene, with the memory of reading and resolving it.
    pub(crate) budget: ResourceBudget,
    warnings: Diagnostics,
    is_model: bool,
}

impl ViewerScene {
    /// Reads the scene file at `path`, and builds the scene and its model with the shapes and maps of `overlay`.
    ///
    /// # Errors
    /// Diagnostics with at least one error.
    pub fn read(
        path: &Path,
        options: &Options,
        overlay: Option<&dyn SceneOverlay>,
    ) -> Result<Self, Diagnostics> {
        Self::read_beside(path, options, overlay, 0)
    }

    /// As [`ViewerScene::read`], beside other scenes that use `others` bytes of the memory that the options allow ([`ViewerScene::memory`]).
    ///
    /// # Errors
    /// As of [`ViewerScene::read`].
    pub fn read_beside(
        path: &Path,
        options: &Options,
        overlay: Option<&dyn SceneOverlay>,
        others: u64,
    ) -> Result<Self, Diagnostics> {
        let mut options = options.clone();
        options.limits.memory = options.limits.memory.saturating_sub(others);
        Self::read_within(path, &options, overlay).map_err(|diagnostics| match others {
            0 => diagnostics,
            _ => with_others(diagnostics, others),
        })
    }

    fn read_within(
        path: &Path,
        options: &Options,
        overlay: Option<&dyn SceneOverlay>,
    ) -> Result<Self, Diagnostics> {
        let loaded = load(path, &Options { edges: true, ..options.clone() })?;
        let name = file_name(path);
        let sources = &loaded.sources;
        let refuse = |location, message| {
            let mut diagnostics = Diagnostics::default();
            diagnostics.push(sources.diagnostic(Severity::Error, "scene", location, message));
            diagnostics
        };
        let mut description = loaded.description;
        if let Some(settings) = &loaded.studio {
            add_studio(&mut description, settings);
        }
        if let Some(overlay) = overlay {
            overlay.add_shapes(&mut description);
        }
        let description = Arc::new(description);
        let budget = loaded.budget.for_next_step();
        let resolved = Scene::resolve_with(Description::clone(&description), &budget);
        let (scene, repairs) = resolved.map_err(|SceneError { location, kind }| match kind {
            SceneErrorKind::Budget(end) => sources.end_of_resolving(location, end),
            kind => refuse(location, kind.to_string()),
        })?;
        let mut warnings = loaded.diagnostics;
        let severity = if options.strict { Severity::Error } else { Severity::Warning };
        for repair in repairs {
            warnings.push(sources.diagnostic(severity, "scene", repair.location, repair.message));
        }
        if warnings.has_errors() {
            return Err(warnings);
        }
        let broken = |error: crate::model::ModelError| refuse(None, error.to_string());
        let model = Model::try_new(&name, &description, &scene, &sources.names()).map_err(broken)?;
        scene.check_textures().map_err(|fault| refuse(None, fault.to_string()))?;
        let model = match loaded.cad {
            // Parts have no walls.
            Some(report) => model.with_cad(report),
            None => model.with_outer_sides(&scene),
        };
        let model = match overlay {
            Some(overlay) => {
                let with_maps = overlay.add_maps(&scene, loaded.content_hash, model);
                with_maps.map_err(|message| refuse(None, message))?
            }
            None => model,
        };
        let bytes = Bytes::from(model.to_bytes().map_err(broken)?);
        let (scene, paths) = (Arc::new(scene), sources.paths().to_vec());
        let is_model = loaded.studio.is_some();
        Ok(Self { name, description, scene, model, bytes, paths, budget, warnings, is_model })
    }

    /// Whether the file is a model, whose camera, ground and light are those of the options.
    #[must_use]
    pub fn is_model(&self) -> bool {
        self.is_model
    }

    /// Memory that reading and resolving it has used of its limit, bytes.
    #[must_use]
    pub fn memory(&self) -> u64 {
        self.budget.used(Resource::Memory)
    }

    /// Repairs and omissions.
    #[must_use]
    pub fn warnings(&self) -> &Diagnostics {
        &self.warnings
    }

    /// The files that it was read from.
    #[must_use]
    pub fn paths(&self) -> &[PathBuf] {
        &self.paths
    }
}

/// The messages about a scene that was read beside others, which use `others` bytes: the limit of the memory is that of all.
fn with_others(diagnostics: Diagnostics, others: u64) -> Diagnostics {
    let Some(LimitError { resource: Resource::Memory, limit, needed }) = diagnostics.limit() else {
        return diagnostics;
    };
    let Some(diagnostic) = diagnostics.iter().next().cloned() else { return diagnostics };
    let limit = limit.saturating_add(others);
    let needed = needed.map(|needed| needed.saturating_add(others));
    let limit = LimitError { resource: Resource::Memory, limit, needed };
    Diagnostics::of_end(Diagnostic { message: limit.to_string(), ..diagnostic }, BudgetError::Limit(limit))
}

/// Remedy for limits that only scenes have that pages open.
pub(crate) const VIEW_REMEDY: &str = "open the file by `glanz view FILE`, which has no such limit";

/// The messages about a scene that is refused, as pages show them. A limit of the program, one of its `own`, is raised by an option.
pub(crate) fn page_text(diagnostics: &Diagnostics, own: &ResourceLimits) -> String {
    let Some(limit) = diagnostics.limit() else { return diagnostics.to_string() };
    let help = if own.get(limit.resource) > limit.limit {
        VIEW_REMEDY.to_owned()
    } else {
        format!("open the file by `glanz view FILE {}`", limit.option())
    };
    let with_help =
        |diagnostic: &Diagnostic| Diagnostic { help: Some(help.clone()), ..diagnostic.clone() }.to_string();
    diagnostics.iter().map(with_help).collect()
}

/// A single error that concerns no place in a file.
pub(crate) fn refusal(name: &str, message: String) -> Diagnostics {
    let mut diagnostics = Diagnostics::default();
    let (severity, file) = (Severity::Error, name.to_owned());
    diagnostics.push(Diagnostic {
        severity,
        kind: "scene",
        file,
        location: None,
        message,
        excerpt: None,
        help: None,
    });
    diagnostics
}

#[cfg(test)]
mod tests {
    use super::*;

    const BALLS: &str = "WorldBegin\nShape \"sphere\"\nShape \"sphere\"\n";

    #[test]
    fn pages_name_the_option_that_raises_a_limit() {
        let folder = tempfile::TempDir::new().unwrap();
        let path = folder.path().join("a.pbrt");
        std::fs::write(&path, BALLS).unwrap();
        for (limits, option) in [
            (ResourceLimits { objects: 1, ..ResourceLimits::default() }, "--limit objects=2`"),
            (ResourceLimits { memory: 1, ..ResourceLimits::default() }, "--memory "),
        ] {
            let options = Options { limits, ..Options::default() };
            let refused = ViewerScene::read(&path, &options, None).unwrap_err();
            assert!(refused.limit().is_some(), "{refused}");
            let text = page_text(&refused, &options.limits);
            assert!(text.contains(&format!("help: open the file by `glanz view FILE {option}")), "{text}");
            assert!(!text.contains("ResourceLimits"), "{text}");
            // The limit of a page.
            let text = page_text(&refused, &ResourceLimits::default());
            assert!(text.contains(&format!("help: {VIEW_REMEDY}\n")), "{text}");
        }
        let refused = refusal("a.pbrt", "the file is empty".to_owned());
        assert_eq!(page_text(&refused, &ResourceLimits::default()), refused.to_string());
    }

    #[test]
    fn second_of_two_scenes_has_the_memory_that_the_first_leaves() {
        let folder = tempfile::TempDir::new().unwrap();
        let path = folder.path().join("a.pbrt");
        std::fs::write(&path, BALLS).unwrap();
        let read = |memory, others| {
            let limits = ResourceLimits { memory, ..ResourceLimits::default() };
            ViewerScene::read_beside(&path, &Options { limits, ..Options::default() }, None, others)
        };
        let memory = read(1 << 30, 0).unwrap().memory();
        assert!(memory > 0);
        // Reading takes more for a while than it keeps.
        assert_eq!(read(1 << 30, 1 << 29).unwrap().memory(), memory);
        let limit = read(1 << 30, (1 << 30) - 1).unwrap_err().limit().unwrap();
        assert_eq!((limit.resource, limit.limit), (Resource::Memory, 1 << 30));
        assert!(limit.needed.is_none_or(|needed| needed > 1 << 30));
    }
}
