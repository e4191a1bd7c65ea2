//! The scene that pages show.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use axum::body::Bytes;
use glanz_formats::{Diagnostic, Diagnostics, Options, Severity, load};
use glanz_job::{Resource, ResourceBudget};
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
    /// What reading has used, for scenes of parts of it.
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
        let resolved = Scene::resolve_with(Description::clone(&description), &loaded.budget.for_next_step());
        let (scene, repairs) = resolved.map_err(|SceneError { location, kind }| match kind {
            SceneErrorKind::Budget(end) => {
                let help = end.help();
                let plain = sources.diagnostic(Severity::Error, "limit", location, end.to_string());
                Diagnostics::of_end(Diagnostic { help, ..plain }, end)
            }
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
        let budget = loaded.budget;
        Ok(Self { name, description, scene, model, bytes, paths, budget, warnings, is_model })
    }

    /// Whether the file is a model, whose camera, ground and light are those of the options.
    #[must_use]
    pub fn is_model(&self) -> bool {
        self.is_model
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

/// The messages about a scene that is refused, as pages show them: what raises a limit is an option of the program.
pub(crate) fn page_text(diagnostics: &Diagnostics) -> String {
    let Some(limit) = diagnostics.limit() else { return diagnostics.to_string() };
    let value = limit.suggestion();
    let option = match limit.resource {
        Resource::Memory => format!("--memory {value}"),
        resource => format!("--limit {}={value}", resource.name()),
    };
    let help = format!("open the file by `glanz view FILE {option}`");
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
    use glanz_job::ResourceLimits;

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
            let text = page_text(&refused);
            assert!(text.contains(&format!("help: open the file by `glanz view FILE {option}")), "{text}");
            assert!(!text.contains("ResourceLimits"), "{text}");
        }
        let refused = refusal("a.pbrt", "the file is empty".to_owned());
        assert_eq!(page_text(&refused), refused.to_string());
    }
}
