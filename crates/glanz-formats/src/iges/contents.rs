//! Which entities are inside of others, and are shown only there.

use std::collections::{HashSet, VecDeque};

use super::entity::IgesEntity;
use super::file::IgesFile;
use super::lowering::IgesReader;

/// The reason of leaving out what a file hides.
pub(super) const HIDDEN: &str = "the file hides it";

/// The items of an assembly, the solid of an instance, the shells of a solid, or the faces of a shell; nothing of other entities.
fn contents(entity: IgesEntity<'_>) -> impl Iterator<Item = IgesEntity<'_>> {
    let parent = entity.kind();
    // The parameter of one, that of the length of a list behind it, and the parameters of each item: a shell and a face have senses.
    let (one, list, size) = match parent {
        184 => (None, Some(1), 1),
        186 => (Some(1), Some(3), 2),
        430 => (Some(1), None, 1),
        514 => (None, Some(1), 2),
        _ => (None, None, 1),
    };
    let behind = list.map(|i| (i, entity.list_length(i, i + 1, size).unwrap_or_default()));
    let items = behind.into_iter().flat_map(move |(i, count)| (0..count).map(move |k| i + 1 + size * k));
    let children = one.into_iter().chain(items).filter_map(move |i| entity.pointer(i).ok().flatten());
    children.filter(move |child| {
        matches!((parent, child.kind()), (184, 184 | 186 | 430) | (430, 184 | 186) | (186, 514) | (514, 510))
    })
}

/// Marks an entity as part of another, with all that is inside of it.
pub(super) fn mark_with_contents(entity: IgesEntity<'_>) {
    entity.file.mark(entity.index);
    let mut open = vec![entity];
    while let Some(entity) = open.pop() {
        // What is marked is passed once, for many solids may have the same shell.
        for child in contents(entity).filter(|child| !child.file.is_used(child.index)) {
            child.file.mark(child.index);
            open.push(child);
        }
    }
}

/// Marks what is inside of subfigures, assemblies and instances. Of assemblies that are only inside one another the first is not marked: it is
/// shown, and refused where it contains itself.
pub(super) fn mark_contents(file: &IgesFile) {
    let is_free = |entity: &IgesEntity<'_>| !file.is_used(entity.index);
    for definition in file.entities().filter(|entity| entity.kind() == 308) {
        for i in 0..definition.list_length(3, 4, 1).unwrap_or_default() {
            definition.pointer(4 + i).ok().flatten().filter(is_free).into_iter().for_each(mark_with_contents);
        }
    }
    let wholes = file.entities().filter(|entity| matches!(entity.kind(), 184 | 430));
    let wholes: Vec<IgesEntity<'_>> = wholes.filter(is_free).collect();
    for whole in &wholes {
        contents(*whole).filter(is_free).for_each(mark_with_contents);
    }
    let (outer, inner): (Vec<_>, Vec<_>) = wholes.into_iter().partition(is_free);
    let mut reached = HashSet::new();
    for whole in outer.into_iter().chain(inner) {
        if !reached.insert(whole.index) {
            continue;
        }
        file.unmark(whole.index);
        let mut open = vec![whole];
        while let Some(whole) = open.pop() {
            open.extend(contents(whole).filter(|child| reached.insert(child.index)));
        }
    }
}

impl<'a> IgesReader<'a> {
    /// Counts the faces of what is not shown, other than those that are shown elsewhere.
    pub(super) fn conceal(&mut self, entity: IgesEntity<'a>, reason: &str) {
        let mut open = VecDeque::from([entity]);
        while let Some(entity) = open.pop_front() {
            match entity.kind() {
                143 | 144 | 510 => self.hide_face(entity.index, entity.id()),
                184 | 186 | 430 | 514 => {
                    let is_shown = self.definitions.contains_key(&entity.index);
                    // Of what is concealed twice the faces are known.
                    if !is_shown && self.concealed.insert(entity.index) {
                        self.report.omissions.push(entity.id(), reason);
                        open.extend(contents(entity));
                    }
                }
                _ => self.report.omissions.push(entity.id(), reason),
            }
        }
    }
}
