//! What a file shows: bodies, sets of faces, groups, and parts that occur in it.

use std::collections::{BTreeMap, HashMap};

use glanz_brep::model::{Body, Occurrence, Part, Shell};
use glanz_math::DMat4;

use super::contents::{HIDDEN, mark_contents, mark_with_contents};
use super::entity::IgesEntity;
use super::lowering::{IgesReader, MAX_DEPTH};
use crate::cad::Refusal;

/// What has the same transformation in a part.
#[derive(Default)]
pub(super) struct PartContents {
    pub(super) bodies: Vec<Body>,
    /// Faces without a shell by the group in which they are.
    pub(super) loose_faces: BTreeMap<Option<usize>, Vec<usize>>,
    pub(super) occurrences: Vec<Occurrence>,
}

/// Groups of the file: their names, and their members by place in the directory.
pub(super) struct GroupIndex {
    names: Vec<(glanz_brep::model::EntityId, String)>,
    members: HashMap<usize, usize>,
}

/// The order in which shapes are read: what contains others is first, so that these are not shown again.
fn rank(kind: u32) -> Option<u8> {
    match kind {
        184 | 408 | 430 => Some(0),
        186 => Some(1),
        514 => Some(2),
        510 | 143 | 144 => Some(3),
        108 | 118 | 120 | 122 | 128 | 140 | 190 | 192 | 194 | 196 | 198 => Some(4),
        _ => None,
    }
}

impl<'a> IgesReader<'a> {
    /// Reads all that the file shows.
    pub(super) fn read_all(&mut self) {
        let groups = GroupIndex::new(self);
        let file = self.file;
        mark_contents(file);
        // Nor are surfaces that belong to faces, also to those that are not shown.
        for entity in file.entities() {
            let surface = match entity.kind() {
                144 | 510 => 1,
                143 => 2,
                140 => 5,
                _ => continue,
            };
            let _ = entity.optional_reference(surface);
        }
        let entities: Vec<IgesEntity<'a>> = file.entities().collect();
        let part = self.part(&entities, &groups, MAX_DEPTH, true);
        // What is shown elsewhere has been read by now.
        for (entity, reason) in std::mem::take(&mut self.unshown) {
            self.conceal(entity, reason);
        }
        let Some((part, entity)) = part.zip(entities.first().map(IgesEntity::id)) else { return };
        if let Some(part) = self.model.parts.get_mut(part) {
            part.name = file.global.product.clone();
            part.entity = entity;
        }
        self.model.roots.push(Occurrence {
            part,
            to_parent: DMat4::IDENTITY,
            name: String::new(),
            style: None,
            entity,
        });
    }

    /// The part of some entities; `None` if it is empty. `free`: whether those that belong to others are left out.
    pub(super) fn part(
        &mut self,
        entities: &[IgesEntity<'a>],
        groups: &GroupIndex,
        depth: usize,
        free: bool,
    ) -> Option<usize> {
        let mut contents: BTreeMap<i64, (IgesEntity<'a>, PartContents)> = BTreeMap::new();
        for wanted in 0..5 {
            for entity in entities.iter().copied().filter(|entity| rank(entity.kind()) == Some(wanted)) {
                if free && self.file.is_used(entity.index) {
                    continue;
                }
                self.file.mark(entity.index);
                // Surfaces that help to define others, as 2D geometry or construction.
                let helps = wanted == 4 && entity.entry.usage != 0;
                if entity.entry.hidden || helps {
                    mark_with_contents(entity);
                    self.unshown
                        .push((entity, if helps { "it is geometry for construction" } else { HIDDEN }));
                    continue;
                }
                // Instances have their matrix in their own transformation, surfaces in their points. Its sign means nothing.
                let matrix = if matches!(wanted, 0 | 4) { 0 } else { entity.entry.matrix.saturating_abs() };
                let (_, contents) =
                    contents.entry(matrix).or_insert_with(|| (entity, PartContents::default()));
                if let Err(refusal) = self.add_item(entity, groups, depth, contents) {
                    self.report.omit(entity.id(), &refusal);
                }
            }
        }
        let mut whole = PartContents::default();
        let mut first = None;
        for (matrix, (entity, contents)) in contents {
            first = first.or(Some(entity));
            if matrix == 0 {
                whole = contents;
                continue;
            }
            let placed = self.rigid_placement(entity).and_then(|to_parent| {
                let part = self.add_part(entity, contents, groups);
                part.map(|part| self.occurrence(entity, part, to_parent)).transpose()
            });
            match placed {
                Ok(occurrence) => whole.occurrences.extend(occurrence),
                Err(refusal) => self.report.omit(entity.id(), &refusal),
            }
        }
        self.add_part(first?, whole, groups)
    }

    fn add_item(
        &mut self,
        entity: IgesEntity<'a>,
        groups: &GroupIndex,
        depth: usize,
        contents: &mut PartContents,
    ) -> Result<(), Refusal> {
        let face = match entity.kind() {
            184 | 408 | 430 => {
                let occurrence = if entity.kind() == 408 {
                    self.subfigure_instance(entity, groups, depth)?
                } else {
                    self.placed_solid(entity, DMat4::IDENTITY, groups, depth)?
                };
                contents.occurrences.push(occurrence);
                return Ok(());
            }
            186 | 514 => {
                let body = if entity.kind() == 186 { self.solid(entity)? } else { self.shell_body(entity)? };
                if body.shells.iter().any(|shell| !shell.faces.is_empty()) {
                    contents.bodies.push(body);
                }
                return Ok(());
            }
            143 => self.face_of(entity, |reader| reader.bounded_surface(entity)),
            144 => self.face_of(entity, |reader| reader.trimmed_surface(entity)),
            510 => self.face_of(entity, |reader| reader.topological_face(entity)),
            _ => self.face_of(entity, |reader| reader.whole_surface(entity)),
        };
        let group = groups.members.get(&entity.index).copied();
        contents.loose_faces.entry(group).or_default().extend(face);
        Ok(())
    }

    /// The index of the part with these contents; `None` if there are none.
    pub(super) fn add_part(
        &mut self,
        entity: IgesEntity<'_>,
        contents: PartContents,
        groups: &GroupIndex,
    ) -> Option<usize> {
        let PartContents { mut bodies, loose_faces, occurrences } = contents;
        for (group, faces) in loose_faces {
            let named = group.and_then(|group| groups.names.get(group)).cloned();
            let (entity, name) = named.unwrap_or((entity.id(), String::new()));
            let faces: Vec<(usize, bool)> = faces.into_iter().map(|face| (face, false)).collect();
            if !faces.is_empty() {
                let shells = vec![Shell { faces, closed: false, entity }];
                bodies.push(Body { name, shells, entity, ..Body::default() });
            }
        }
        if bodies.is_empty() && occurrences.is_empty() {
            return None;
        }
        let part = Part { name: String::new(), bodies, occurrences, entity: entity.id() };
        self.reaches.push(&part);
        self.model.parts.push(part);
        Some(self.model.parts.len() - 1)
    }
}

impl GroupIndex {
    /// Groups of all forms; an entity that is in several belongs to the first.
    fn new(reader: &mut IgesReader<'_>) -> Self {
        let mut index = Self { names: Vec::new(), members: HashMap::new() };
        let groups = reader.file.entities().filter(|entity| entity.kind() == 402);
        for group in groups.filter(|entity| matches!(entity.form(), 1 | 7 | 14 | 15)) {
            let count = match group.list_length(1, 2, 1) {
                Ok(count) => count,
                Err(refusal) => {
                    reader.report.mend(group.id(), &refusal, "the group is left out");
                    continue;
                }
            };
            for member in (0..count).filter_map(|i| group.pointer(2 + i).ok().flatten()) {
                index.members.entry(member.index).or_insert(index.names.len());
            }
            index.names.push((group.id(), group.name(1 + count)));
        }
        index
    }
}
