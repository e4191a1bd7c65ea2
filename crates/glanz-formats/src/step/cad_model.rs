//! A CAD file as a part of a scene.

use glanz_brep::face::{TrimmedFaces, trimmed_faces};
use glanz_brep::model::BrepModel;
use glanz_scene::{Description, Location};

use super::cad_report::CadReport;
use super::describe::{CadScene, CadSettings};
use super::report::StepError;

/// A CAD file whose faces are trimmed, from which descriptions are made.
#[derive(Debug)]
pub(crate) struct CadModel {
    model: BrepModel,
    faces: TrimmedFaces,
    /// The outcome for each face; without shapes.
    pub(crate) report: CadReport,
}

impl CadModel {
    /// Reads a STEP file.
    ///
    /// # Errors
    /// Those of [`super::read`].
    pub(crate) fn read(bytes: &[u8]) -> Result<Self, StepError> {
        let file = super::read(bytes)?;
        let faces = trimmed_faces(&file.model);
        let report = CadReport::new(&file, &faces);
        Ok(Self { model: file.model, faces, report })
    }

    /// Adds all of it to the world, with the colors of the file.
    pub(crate) fn into_world(self, description: &mut Description) -> CadReport {
        let settings = CadSettings::default();
        let mut scene = CadScene::new((&self.model, &self.faces), &settings, None, description);
        let (world, faces_of_world) = scene.whole();
        let shapes = scene.faces_of_groups.into_iter().chain([faces_of_world]).flatten().collect();
        description.world.shapes.extend(world.shapes);
        description.world.instances.extend(world.instances);
        CadReport { shapes, ..self.report }
    }

    /// Adds a group of what the settings select, after the groups that it contains, and returns its index; `None` if it has no surface.
    pub(crate) fn add_group(
        &self,
        settings: &CadSettings,
        location: Location,
        description: &mut Description,
    ) -> Option<usize> {
        let mut scene = CadScene::new((&self.model, &self.faces), settings, Some(location), description);
        let (group, _) = scene.whole();
        if group.shapes.is_empty() && group.instances.is_empty() {
            return None;
        }
        description.groups.push(group);
        Some(description.groups.len() - 1)
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
