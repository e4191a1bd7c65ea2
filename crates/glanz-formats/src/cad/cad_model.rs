//! A CAD file as a part of a scene.

use std::sync::Arc;

use glanz_brep::face::{TrimmedFaces, trimmed_faces_while};
use glanz_brep::model::BrepModel;
use glanz_job::ResourceBudget;
use glanz_scene::{Description, Location};

use super::cad_report::CadReport;
use super::describe::{CadScene, CadSettings};
use super::error::CadError;
use super::report::BrepFile;
use crate::{iges, step};

/// The reason why occurrences lack their colors.
pub(crate) const TOO_MANY_COLORS: &str =
    "parts occur in too many different colors; some occurrences are shown without theirs";

/// A CAD file whose faces are trimmed, from which descriptions are made.
#[derive(Debug)]
pub(crate) struct CadModel {
    model: BrepModel,
    faces: Arc<TrimmedFaces>,
    /// The outcome for each face; without shapes.
    pub(crate) report: CadReport,
}

impl CadModel {
    /// As [`CadModel::read_with`] within the limits of the machine.
    #[cfg(test)]
    pub(crate) fn read(bytes: &[u8], with_edges: bool) -> Result<Self, CadError> {
        Self::read_with(bytes, with_edges, &ResourceBudget::default())
    }

    /// Reads a file of STEP or IGES. `with_edges`: whether descriptions made of it have edges.
    ///
    /// # Errors
    /// Those of [`step::read`] and [`iges::read`].
    pub(crate) fn read_with(
        bytes: &[u8],
        with_edges: bool,
        budget: &ResourceBudget,
    ) -> Result<Self, CadError> {
        let BrepFile { model, report } = match iges::is_iges(bytes) {
            true => iges::read_with(bytes, budget)?,
            false => step::read_with(bytes, budget)?,
        };
        let faces = trimmed_faces_while(&model, with_edges, &|| budget.check().is_ok());
        budget.check()?;
        let faces = Arc::new(faces.unwrap_or_default());
        let report = CadReport::new(&model, report, &faces);
        Ok(Self { model, faces, report })
    }

    /// Adds all of it to the world, with the colors of the file.
    pub(crate) fn into_world(self, description: &mut Description) -> CadReport {
        let settings = CadSettings::default();
        let mut scene = CadScene::new((&self.model, &self.faces), &settings, None, description);
        let (world, faces_of_world) = scene.whole();
        let is_exhausted = scene.is_exhausted();
        let shapes = scene.faces_of_groups.into_iter().chain([faces_of_world]).flatten().collect();
        let whole = (!world.name.is_empty()).then(|| world.name.clone());
        description.world.shapes.extend(world.shapes);
        description.world.instances.extend(world.instances);
        description.world.edges.extend(world.edges);
        let mut report = self.report;
        (report.shapes, report.whole) = (shapes, whole);
        if is_exhausted {
            report.reading.repairs.push_whole(TOO_MANY_COLORS);
        }
        report
    }

    /// Adds a group of what the settings select, after the groups that it contains, and returns its index; `None` if it has no surface.
    /// The second value tells whether colors are left out, because parts occur in too many ([`TOO_MANY_COLORS`]).
    pub(crate) fn add_group(
        &self,
        settings: &CadSettings,
        location: Location,
        description: &mut Description,
    ) -> (Option<usize>, bool) {
        let mut scene = CadScene::new((&self.model, &self.faces), settings, Some(location), description);
        let (group, _) = scene.whole();
        let is_exhausted = scene.is_exhausted();
        if group.shapes.is_empty() && group.instances.is_empty() {
            return (None, is_exhausted);
        }
        description.groups.push(group);
        (Some(description.groups.len() - 1), is_exhausted)
    }

    /// The names of parts and their occurrences, in the order of the file, perhaps several times.
    pub(crate) fn part_names(&self) -> impl Iterator<Item = &str> {
        let inner = self.model.parts.iter().flat_map(|part| {
            let occurrences = part.occurrences.iter().map(|occurrence| occurrence.name.as_str());
            std::iter::once(part.name.as_str()).chain(occurrences)
        });
        inner.filter(|name| !name.is_empty())
    }

    /// The names of parts, occurrences, bodies and faces.
    pub(crate) fn names(&self) -> impl Iterator<Item = &str> {
        let bodies = self.model.parts.iter().flat_map(|part| &part.bodies);
        let faces = self.model.faces.iter().map(|face| face.name.as_str());
        let inner = bodies.map(|body| body.name.as_str()).chain(faces);
        self.part_names().chain(inner.filter(|name| !name.is_empty()))
    }
}
