//! Colours, transparency, layers and what is hidden.

use std::collections::{HashMap, HashSet};

use glanz_brep::model::{ColorStyle, EntityId};

use super::colors::{ColorReader, referred};
use super::entities::EntityLists;
use super::part21::{Entity, Keyword, Refusal};
use crate::cad::ReadingReport;

/// Lists of hidden things inside one another, at most.
const MAX_DEPTH: usize = 8;

/// A colour of an item.
#[derive(Clone, Copy, Debug)]
struct ItemColor {
    color: ColorStyle,
    /// Whether it is said to override others.
    overrides: bool,
}

/// A colour that an item has in some contexts only.
#[derive(Clone, Debug)]
pub(super) struct ContextualColor<'a> {
    /// The styled item.
    pub(super) style: EntityId,
    pub(super) item: Entity<'a>,
    /// Entities that stand for occurrences: one occurrence inside another, or several.
    pub(super) contexts: Vec<EntityId>,
    pub(super) color: ColorStyle,
}

/// Colours, layers and visibility by the number of the item.
#[derive(Debug, Default)]
pub(super) struct StyleTable<'a> {
    colors: HashMap<EntityId, ItemColor>,
    pub(super) contextual: Vec<ContextualColor<'a>>,
    hidden: HashSet<EntityId>,
    layers: HashMap<EntityId, usize>,
    layer_names: Vec<String>,
}

impl<'a> StyleTable<'a> {
    pub(super) fn new(lists: &EntityLists<'a>, report: &mut ReadingReport) -> Self {
        let mut table = Self::default();
        let mut colors = ColorReader::default();
        for item in &lists.styled_items {
            if let Err(refusal) = table.add_styled_item(*item, &mut colors) {
                report.repairs.push(
                    item.id(),
                    format!("{}: {}; the style is left out", refusal.entity, refusal.reason),
                );
            }
        }
        for layer in &lists.layers {
            let attributes = layer.simple();
            let items = attributes.references(2).into_iter().flatten().flatten();
            table.layers.extend(items.map(|item| (styled(item).id(), table.layer_names.len())));
            table.layer_names.push(attributes.text(0));
        }
        // Each hidden list is read once.
        let mut visited = HashSet::new();
        for invisibility in &lists.invisibilities {
            for item in invisibility.simple().references(0).into_iter().flatten().flatten() {
                table.hide(item, &mut visited, MAX_DEPTH);
            }
        }
        table
    }

    /// The colour of an item.
    pub(super) fn color(&self, item: EntityId) -> Option<ColorStyle> {
        self.colors.get(&item).map(|item| item.color)
    }

    /// The colour of an item that overrides those inside of it.
    pub(super) fn overriding_color(&self, item: EntityId) -> Option<ColorStyle> {
        self.colors.get(&item).filter(|item| item.overrides).map(|item| item.color)
    }

    /// Whether the file hides an item.
    pub(super) fn is_hidden(&self, item: EntityId) -> bool {
        self.hidden.contains(&item)
    }

    /// The name of the layer of an item; empty if it has none.
    pub(super) fn layer(&self, item: EntityId) -> String {
        self.layers.get(&item).and_then(|layer| self.layer_names.get(*layer)).cloned().unwrap_or_default()
    }

    /// `STYLED_ITEM(name, styles, item)`, with what it overrides and in which contexts.
    fn add_styled_item(&mut self, entity: Entity<'a>, colors: &mut ColorReader) -> Result<(), Refusal> {
        use Keyword::{
            ContextDependentOverRidingStyledItem, OverRidingStyledItem, RepresentationItem, StyledItem,
        };
        let parts =
            [RepresentationItem, StyledItem, OverRidingStyledItem, ContextDependentOverRidingStyledItem];
        let attributes = entity.attributes(&parts);
        let item = attributes.reference(2)?;
        let contextual = |contexts, color| ContextualColor { style: entity.id(), item, contexts, color };
        let mut color = None;
        for style in referred(&attributes, 1)? {
            let style = style?;
            let Some(found) = colors.color(style)? else { continue };
            // OpenCascade colours occurrences by the context of the style, others by that of the item.
            if style.keyword() == Keyword::PresentationStyleByContext {
                let context = style.simple().reference(1)?;
                self.contextual.push(contextual(vec![context.id()], found));
            } else {
                color = color.or(Some(found));
            }
        }
        let Some(color) = color else { return Ok(()) };
        if entity.is(ContextDependentOverRidingStyledItem) {
            let contexts = attributes.references(4)?.map(|context| Ok(context?.id()));
            self.contextual.push(contextual(contexts.collect::<Result<_, Refusal>>()?, color));
            return Ok(());
        }
        let overrides = entity.is(OverRidingStyledItem);
        let known = self.colors.get(&item.id());
        if known.is_none_or(|known| overrides && !known.overrides) {
            self.colors.insert(item.id(), ItemColor { color, overrides });
        }
        Ok(())
    }

    /// Hides an item, the item of a style, or all items of a layer or a representation.
    fn hide(&mut self, entity: Entity<'_>, visited: &mut HashSet<EntityId>, depth: usize) {
        if depth == 0 || !visited.insert(entity.id()) {
            return;
        }
        let entity = styled(entity);
        self.hidden.insert(entity.id());
        let attributes = entity.attributes(&[Keyword::Representation]);
        let list = match entity.keyword() {
            Keyword::PresentationLayerAssignment => 2,
            // Representations of styles, whose types have many names, have a name, items and a context.
            Keyword::Unknown | Keyword::Complex => 1,
            _ => return,
        };
        for item in attributes.references(list).into_iter().flatten().flatten() {
            self.hide(item, visited, depth - 1);
        }
    }
}

/// The item of a style; other entities as they are.
fn styled(entity: Entity<'_>) -> Entity<'_> {
    use Keyword::{
        ContextDependentOverRidingStyledItem, OverRidingStyledItem, RepresentationItem, StyledItem,
    };
    let is_style = entity
        .kinds()
        .any(|kind| matches!(kind, StyledItem | OverRidingStyledItem | ContextDependentOverRidingStyledItem));
    if !is_style {
        return entity;
    }
    entity.attributes(&[RepresentationItem, StyledItem]).reference(2).unwrap_or(entity)
}
