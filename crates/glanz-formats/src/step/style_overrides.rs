//! Colours that override others: of occurrences, and of items in them.

use std::collections::HashSet;

use glanz_brep::model::{BrepModel, EntityId, StyleOverride};

use super::assembly::{MAX_ASSEMBLY_DEPTH, usage_ends, usage_path};
use super::geometry::ENTITY_COST;
use super::part21::{Entity, Keyword, Refusal};
use super::parts::PartReader;
use super::styles::ContextualColor;

/// The remedy for a style that cannot be applied.
const LEFT_OUT: &str = "the style is left out";

impl<'a> PartReader<'a, '_> {
    /// Adds to the model the colours that override those of the items of their parts.
    pub(super) fn override_styles(&mut self) {
        let model = &self.reader.model;
        let occurrences = model.parts.iter().flat_map(|part| &part.occurrences);
        let styles = &self.reader.styles;
        // A mapped item is an occurrence.
        let overriding = occurrences.filter_map(|occurrence| {
            let item = occurrence.entity;
            styles.overriding_color(item).map(|style| StyleOverride { path: vec![item], item, style })
        });
        let overriding: Vec<StyleOverride> = overriding.collect();
        self.reader.model.overrides = overriding;
        let contextual = std::mem::take(&mut self.reader.styles.contextual);
        if contextual.is_empty() {
            return;
        }
        let shown = shown_items(&self.reader.model);
        for color in contextual {
            if let Err(refusal) = self.add_contextual(&color, &shown) {
                self.reader.mend(color.style, &refusal, LEFT_OUT);
            }
        }
    }

    /// Adds a colour in each of its contexts; contexts that are inside one another are one.
    fn add_contextual(
        &mut self,
        color: &ContextualColor<'a>,
        shown: &HashSet<EntityId>,
    ) -> Result<(), Refusal> {
        let item = color.item.id();
        let is_part = self.index.owner(item).is_some() || self.index.is_product(item);
        if !is_part && !shown.contains(&item) {
            return Err(color.item.refuse("the item is not shown"));
        }
        let mut usages: Vec<Entity<'a>> = Vec::new();
        for &context in &color.contexts {
            let entity = self.reader.file.find(context.0);
            let found = entity.as_ref().map_or(&[][..], |entity| self.index.usages_of_context(entity));
            if found.is_empty() && !is_part && self.index.owner(context).is_some() {
                // The shape of a product is a context, too: that of all its occurrences. A mapped item is an occurrence itself.
                let path = if color.item.is(Keyword::MappedItem) { vec![item] } else { Vec::new() };
                self.reader.model.overrides.push(StyleOverride { path, item, style: color.color });
                continue;
            }
            if found.is_empty() {
                return Err(Refusal::new(context, "the context of the style is no occurrence"));
            }
            self.reader.geometry.spend(context, ENTITY_COST * found.len())?;
            usages.extend(found);
        }
        // Each path is taken off the budget before the next one is made.
        let mut paths = Vec::new();
        let mut add = |path: Vec<EntityId>| -> Result<(), Refusal> {
            self.reader.geometry.spend(item, ENTITY_COST + path.len())?;
            paths.push(path);
            Ok(())
        };
        match Self::nested(&usages) {
            Some(path) => add(path)?,
            None => usages.into_iter().try_for_each(|usage| add(usage_path(usage)?))?,
        }
        for path in paths {
            let last = path.last().copied().filter(|last| shown.contains(last));
            let last = last.ok_or_else(|| Refusal::new(color.style, "its occurrence is not shown"))?;
            let item = if is_part { last } else { item };
            self.reader.model.overrides.push(StyleOverride { path, item, style: color.color });
        }
        Ok(())
    }

    /// The path of several usages of which each contains the next, whichever is named first.
    fn nested(usages: &[Entity<'a>]) -> Option<Vec<EntityId>> {
        if !(2..=MAX_ASSEMBLY_DEPTH).contains(&usages.len()) {
            return None;
        }
        let mut ends: Vec<(Entity<'a>, [EntityId; 2])> = usages
            .iter()
            .map(|usage| usage_ends(*usage).ok().map(|ends| (*usage, ends)))
            .collect::<Option<_>>()?;
        if ends.first().zip(ends.get(1)).is_some_and(|((_, [parent, _]), (_, [_, child]))| parent == child) {
            ends.reverse();
        }
        let is_chain = ends
            .windows(2)
            .all(|pair| matches!(pair, [(_, [_, child]), (_, [parent, _])] if child == parent));
        // One of them may be a chain of others.
        let paths = ends.into_iter().map(|(usage, _)| usage_path(usage).ok());
        is_chain.then(|| paths.collect::<Option<Vec<_>>>())?.map(|paths| paths.concat())
    }
}

/// What a style may be about: the faces, shells, bodies and occurrences of a model.
fn shown_items(model: &BrepModel) -> HashSet<EntityId> {
    let faces = model.faces.iter().map(|face| face.entity);
    let bodies = model.parts.iter().flat_map(|part| &part.bodies);
    let bodies = bodies.flat_map(|body| body.shells.iter().map(|shell| shell.entity).chain([body.entity]));
    let occurrences = model.parts.iter().flat_map(|part| &part.occurrences);
    faces.chain(bodies).chain(occurrences.map(|occurrence| occurrence.entity)).collect()
}
