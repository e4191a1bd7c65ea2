//! What a file shows: bodies, sets of faces, groups, and instances of subfigures.

use std::collections::{BTreeMap, HashMap};

use glanz_brep::model::{Body, Occurrence, Part, Shell};
use glanz_math::{DMat4, DVec3};

use super::entity::IgesEntity;
use super::lowering::{IgesReader, MAX_DEPTH};
use crate::cad::{ENTITY_COST, Refusal};

/// What has the same transformation in a part.
#[derive(Default)]
struct PartContents {
    bodies: Vec<Body>,
    /// Faces without a shell by the group in which they are.
    loose_faces: BTreeMap<Option<usize>, Vec<usize>>,
    occurrences: Vec<Occurrence>,
}

/// Groups of the file: their names, and their members by place in the directory.
struct GroupIndex {
    names: Vec<(glanz_brep::model::EntityId, String)>,
    members: HashMap<usize, usize>,
}

/// The order in which shapes are read: what contains others is first, so that these are not shown again.
fn rank(kind: u32) -> Option<u8> {
    match kind {
        408 => Some(0),
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
        // What a subfigure contains is shown by its instances only.
        for definition in file.entities().filter(|entity| entity.kind() == 308) {
            for i in 0..definition.list_length(3, 4, 1).unwrap_or_default() {
                let item = definition.pointer(4 + i).ok().flatten();
                if let Some(item) = item.filter(|item| !file.is_used(item.index)) {
                    mark_with_shells(item);
                }
            }
        }
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
    fn part(
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
                    self.conceal(
                        entity,
                        if helps { "it is geometry for construction" } else { "the file hides it" },
                    );
                    continue;
                }
                // Instances have their matrix in their own transformation, surfaces in their points.
                let matrix = if matches!(wanted, 0 | 4) { 0 } else { entity.entry.matrix };
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
            let placed = self.rigid_placement(entity);
            match placed {
                Ok(to_parent) => {
                    let part = self.add_part(entity, contents, groups);
                    whole.occurrences.extend(part.map(|part| Occurrence {
                        part,
                        to_parent,
                        name: String::new(),
                        style: None,
                        entity: entity.id(),
                    }));
                }
                Err(refusal) => self.report.omit(entity.id(), &refusal),
            }
        }
        self.add_part(first?, whole, groups)
    }

    /// The transformation of an entity in metres.
    fn rigid_placement(&self, entity: IgesEntity<'_>) -> Result<DMat4, Refusal> {
        let matrix = entity.rigid_matrix()?;
        let placed = self.metres() * matrix * self.metres().inverse();
        if placed.is_finite() { Ok(placed) } else { Err(entity.refuse("its transformation is not finite")) }
    }

    fn add_item(
        &mut self,
        entity: IgesEntity<'a>,
        groups: &GroupIndex,
        depth: usize,
        contents: &mut PartContents,
    ) -> Result<(), Refusal> {
        let face = match entity.kind() {
            408 => {
                contents.occurrences.extend(self.instance(entity, groups, depth)?);
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
    fn add_part(
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
        self.model.parts.push(Part { name: String::new(), bodies, occurrences, entity: entity.id() });
        Some(self.model.parts.len() - 1)
    }

    /// `DE, X, Y, Z, S`: an instance of a subfigure.
    fn instance(
        &mut self,
        entity: IgesEntity<'a>,
        groups: &GroupIndex,
        depth: usize,
    ) -> Result<Option<Occurrence>, Refusal> {
        self.budget.spend(entity.id(), ENTITY_COST)?;
        let definition = entity.reference(1)?;
        if definition.kind() != 308 {
            return Err(definition.refuse_kind("subfigure"));
        }
        let [x, y, z] = entity.numbers(2)?;
        let scale = if entity.len() < 5 { 1.0 } else { entity.number(5)? };
        let scale = if scale == 0.0 { 1.0 } else { scale };
        let placed = self.rigid_placement(entity)?
            * DMat4::from_translation(DVec3::new(x, y, z) * self.file.global.length)
            * DMat4::from_scale(DVec3::splat(scale));
        if !(placed.is_finite() && placed.determinant().is_normal()) {
            return Err(entity.refuse("the placement is not finite, or has no inverse"));
        }
        let part = match self.subfigures.get(&definition.index) {
            Some(Some(known)) => known.clone()?,
            Some(None) => return Err(definition.refuse("the subfigure contains itself")),
            None => {
                self.subfigures.insert(definition.index, None);
                let part = self.subfigure(definition, groups, depth);
                self.subfigures.insert(definition.index, Some(part.clone()));
                part?
            }
        };
        let (name, style) = (entity.name(5), entity.color());
        Ok(Some(Occurrence { part, to_parent: placed, name, style, entity: entity.id() }))
    }

    /// `DEPTH, NAME, N, DE...`: the part of a subfigure.
    fn subfigure(
        &mut self,
        entity: IgesEntity<'a>,
        groups: &GroupIndex,
        depth: usize,
    ) -> Result<usize, Refusal> {
        let depth = depth
            .checked_sub(1)
            .ok_or_else(|| entity.refuse(format!("subfigures are nested deeper than {MAX_DEPTH} levels")))?;
        self.spend(entity)?;
        let count = entity.list_length(3, 4, 1)?;
        let items = (0..count).map(|i| entity.reference(4 + i)).collect::<Result<Vec<_>, _>>()?;
        let part = self.part(&items, groups, depth, false);
        let part = part.ok_or_else(|| entity.refuse("the subfigure has no surface that can be read"))?;
        if let Some(part) = self.model.parts.get_mut(part) {
            part.name = entity.text(2).to_owned();
            part.entity = entity.id();
        }
        Ok(part)
    }

    /// Counts the faces of what is not shown.
    fn conceal(&mut self, entity: IgesEntity<'a>, reason: &str) {
        match entity.kind() {
            143 | 144 | 510 => {
                self.hide_face(entity.index, entity.id());
                let _ = entity.optional_reference(if entity.kind() == 143 { 2 } else { 1 });
            }
            186 | 514 => {
                // Of a shell that is concealed twice the faces are known.
                if !self.concealed.insert(entity.index) {
                    return;
                }
                self.report.omissions.push(entity.id(), reason);
                for child in shells_or_faces(entity) {
                    self.file.mark(child.index);
                    self.conceal(child, reason);
                }
            }
            _ => {
                self.report.omissions.push(entity.id(), reason);
                self.file.mark(entity.index);
            }
        }
    }
}

/// The shells of a solid, or the faces of a shell; nothing of other entities.
fn shells_or_faces(entity: IgesEntity<'_>) -> impl Iterator<Item = IgesEntity<'_>> {
    // The outer shell and its sense, the number of voids, and these with theirs; or the number of faces, and these with theirs.
    let (outer, list, kind) = match entity.kind() {
        186 => (Some(1), Some(3), 514),
        514 => (None, Some(1), 510),
        _ => (None, None, 0),
    };
    let behind = list.map(|i| (i, entity.list_length(i, i + 1, 2).unwrap_or_default()));
    let items = behind.into_iter().flat_map(|(i, count)| (0..count).map(move |k| i + 1 + 2 * k));
    let children = outer.into_iter().chain(items).filter_map(move |i| entity.pointer(i).ok().flatten());
    children.filter(move |child| child.kind() == kind)
}

/// Marks an entity as part of another, with the shells and faces that are inside of it.
fn mark_with_shells(entity: IgesEntity<'_>) {
    entity.file.mark(entity.index);
    // What is marked is passed once, for many solids may have the same shell.
    shells_or_faces(entity).filter(|child| !child.file.is_used(child.index)).for_each(mark_with_shells);
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
