//! What a file hides.

use super::assembly::RelationshipEnds;
use super::bodies::{base_shell, body_kind, shells_of};
use super::lowering::{StepReader, is_face};
use super::part21::{Entity, Keyword};
use super::parts::PartReader;

/// The reason of leaving out what a file hides.
pub(super) const HIDDEN: &str = "the file hides it";

impl<'a> StepReader<'a> {
    /// Whether the file hides an item, which is reported once.
    pub(super) fn hides(&mut self, entity: Entity<'a>) -> bool {
        let base = base_shell(entity).map_or(entity, |(base, _)| base);
        if !self.styles.is_hidden(entity.id()) && !self.styles.is_hidden(base.id()) {
            return false;
        }
        if self.hide(entity) {
            self.report.omissions.push(entity.id(), HIDDEN);
        }
        true
    }

    /// Counts all that a hidden entity contains as hidden: a representation, or an item of one. Each entity is counted once;
    /// the result tells whether this one was not counted before.
    pub(super) fn hide(&mut self, entity: Entity<'a>) -> bool {
        let is_new = !self.hidden_items.contains(&entity.id());
        let mut open = vec![entity];
        while let Some(entity) = open.pop() {
            if self.hidden_items.insert(entity.id()) {
                open.extend(contents(entity));
            }
        }
        is_new
    }
}

impl<'a> PartReader<'a, '_> {
    /// Counts as hidden all that a product contains: its representations, those that are placed in them, and the products inside.
    pub(super) fn hide_product(&mut self, product: Entity<'a>) {
        let mut open = vec![product];
        while let Some(product) = open.pop() {
            if !self.reader.hidden_items.insert(product.id()) {
                continue;
            }
            let mut representations = self.index.group(product.id());
            for representation in &representations {
                self.reader.hide(*representation);
            }
            while let Some(representation) = representations.pop() {
                // Products may share a representation.
                if !self.followed.insert(representation.id()) {
                    continue;
                }
                for relationship in self.index.placed_in(representation.id()).to_vec() {
                    // One that cannot be read places nothing.
                    let Ok(RelationshipEnds { first, .. }) = RelationshipEnds::of(relationship) else {
                        continue;
                    };
                    if let Some(inner) = self.index.owner(first.id()) {
                        open.push(inner);
                    } else if !self.reader.hidden_items.contains(&first.id()) {
                        // Of what is not followed the faces count as unreachable.
                        let linked = self.index.linked(first, &mut self.reader.geometry);
                        let linked = linked.unwrap_or_default().into_iter();
                        representations.extend(linked.filter(|item| self.reader.hide(*item)));
                    }
                }
            }
            let children = self.index.usages(product.id()).into_iter();
            open.extend(children.filter_map(|usage| usage.simple().reference(4).ok()));
        }
    }
}

/// The entities in one that has faces, directly below it.
fn contents(entity: Entity<'_>) -> Vec<Entity<'_>> {
    let attributes = entity.attributes(&[Keyword::RepresentationItem, Keyword::MappedItem]);
    let all = |list| entity.simple().references(list).into_iter().flatten().flatten().collect();
    match entity.keyword() {
        _ if is_face(entity) => Vec::new(),
        _ if entity.is(Keyword::MappedItem) => {
            let source = attributes.reference(1).and_then(|map| map.simple().reference(1));
            source.into_iter().collect()
        }
        Keyword::OrientedFace | Keyword::OrientedOpenShell | Keyword::OrientedClosedShell => {
            attributes.reference(2).into_iter().collect()
        }
        Keyword::OpenShell | Keyword::ClosedShell | Keyword::ConnectedFaceSet => all(1),
        _ => match body_kind(entity) {
            Some(kind) => shells_of(entity, kind).unwrap_or_default(),
            // A representation and its items.
            None => {
                let attributes = entity.attributes(&[Keyword::Representation]);
                attributes.references(1).into_iter().flatten().flatten().collect()
            }
        },
    }
}
