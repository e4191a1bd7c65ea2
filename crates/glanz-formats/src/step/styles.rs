//! Colours, transparency, layers and what is hidden.

use std::collections::{HashMap, HashSet};

use glanz_brep::model::{ColorStyle, EntityId};

use super::entities::EntityLists;
use super::lowering::is_face;
use super::part21::{Entity, EntityAttributes, Keyword, Refusal, TapeToken};
use super::report::StepReport;

/// Lists of hidden things inside one another, at most.
const MAX_DEPTH: usize = 8;

/// A colour of an item.
#[derive(Clone, Copy, Debug)]
struct ItemColor {
    color: ColorStyle,
    /// Whether it is said to override others.
    overrides: bool,
}

/// Colours, layers and visibility by the number of the item.
#[derive(Debug, Default)]
pub(super) struct StyleTable {
    colors: HashMap<EntityId, ItemColor>,
    /// Colours that hold in the context of an occurrence only, by the number of the context.
    contexts: HashMap<EntityId, ColorStyle>,
    hidden: HashSet<EntityId>,
    layers: HashMap<EntityId, usize>,
    layer_names: Vec<String>,
}

impl StyleTable {
    pub(super) fn new(lists: &EntityLists<'_>, report: &mut StepReport) -> Self {
        let mut table = Self::default();
        for item in &lists.styled_items {
            if let Err(refusal) = table.add_styled_item(*item) {
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

    /// The colour of an occurrence, by the entities that may stand for it.
    pub(super) fn context_color(&self, contexts: &[EntityId]) -> Option<ColorStyle> {
        contexts
            .iter()
            .find_map(|context| self.contexts.get(context).copied().or_else(|| self.color(*context)))
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
    fn add_styled_item(&mut self, entity: Entity<'_>) -> Result<(), Refusal> {
        use Keyword::{
            ContextDependentOverRidingStyledItem, OverRidingStyledItem, RepresentationItem, StyledItem,
        };
        let parts =
            [RepresentationItem, StyledItem, OverRidingStyledItem, ContextDependentOverRidingStyledItem];
        let attributes = entity.attributes(&parts);
        let item = attributes.reference(2)?;
        let mut color = None;
        for style in referred(&attributes, 1)? {
            let style = style?;
            let Some(found) = assignment_color(style)? else { continue };
            // OpenCascade colours occurrences by the context of the style, others by that of the item.
            if style.keyword() == Keyword::PresentationStyleByContext {
                self.add_context(item, style.simple().reference(1)?, found)?;
            } else {
                color = color.or(Some(found));
            }
        }
        let Some(color) = color else { return Ok(()) };
        if entity.is(ContextDependentOverRidingStyledItem) {
            for context in attributes.references(4)? {
                self.add_context(item, context?, color)?;
            }
            return Ok(());
        }
        let overrides = entity.is(OverRidingStyledItem);
        let known = self.colors.get(&item.id());
        if known.is_none_or(|known| overrides && !known.overrides) {
            self.colors.insert(item.id(), ItemColor { color, overrides });
        }
        Ok(())
    }

    /// Colours an item in one occurrence; one colour is possible, and none of a single face.
    fn add_context(
        &mut self,
        item: Entity<'_>,
        context: Entity<'_>,
        color: ColorStyle,
    ) -> Result<(), Refusal> {
        if is_face(item) {
            return Err(item.refuse("a single face has a colour of its own in one occurrence"));
        }
        if *self.contexts.entry(context.id()).or_insert(color) != color {
            return Err(context.refuse("the occurrence has several colours"));
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
        let list = match entity.keyword() {
            Keyword::PresentationLayerAssignment => 2,
            Keyword::Unknown => 1,
            _ => return,
        };
        // Representations of styles, whose types have many names, have a name, items and a context.
        for item in entity.simple().references(list).into_iter().flatten().flatten() {
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

/// The colour of surfaces in `PRESENTATION_STYLE_ASSIGNMENT((styles))`.
fn assignment_color(entity: Entity<'_>) -> Result<Option<ColorStyle>, Refusal> {
    if !matches!(entity.keyword(), Keyword::PresentationStyleAssignment | Keyword::PresentationStyleByContext)
    {
        return usage_color(entity);
    }
    let mut color = None;
    for style in referred(&entity.simple(), 0)? {
        color = color.or(usage_color(style?)?);
    }
    Ok(color)
}

/// The entities in a list, without its other items, such as `NULL_STYLE(.NULL.)`.
fn referred<'a>(
    attributes: &EntityAttributes<'a>,
    i: usize,
) -> Result<impl Iterator<Item = Result<Entity<'a>, Refusal>> + use<'a>, Refusal> {
    let attributes = *attributes;
    let is_reference = move |at: &u32| matches!(attributes.token(*at), TapeToken::Reference(_));
    Ok(attributes.list(i)?.filter(is_reference).map(move |at| attributes.reference_at(at)))
}

/// The colour of `SURFACE_STYLE_USAGE(side, SURFACE_SIDE_STYLE(name, (elements)))`; `None` for styles of curves and points.
fn usage_color(entity: Entity<'_>) -> Result<Option<ColorStyle>, Refusal> {
    if entity.keyword() != Keyword::SurfaceStyleUsage {
        return Ok(None);
    }
    let side = entity.simple().reference(1)?;
    if side.keyword() != Keyword::SurfaceSideStyle {
        return Ok(None);
    }
    let (mut rgb, mut transparency) = (None, 0.0);
    for element in referred(&side.simple(), 1)? {
        let element = element?;
        let attributes = element.simple();
        match element.keyword() {
            Keyword::SurfaceStyleFillArea => {
                let area = attributes.reference(0)?.simple();
                for fill in referred(&area, 1)? {
                    let fill = fill?;
                    if fill.keyword() == Keyword::FillAreaStyleColour {
                        rgb = color(fill.simple().reference(1)?)?.or(rgb);
                    }
                }
            }
            Keyword::SurfaceStyleRendering | Keyword::SurfaceStyleRenderingWithProperties => {
                rgb = rgb.or(color(attributes.reference(1)?)?);
                let properties = (attributes.len() > 2).then(|| referred(&attributes, 2)).transpose()?;
                for property in properties.into_iter().flatten() {
                    let property = property?;
                    if property.keyword() == Keyword::SurfaceStyleTransparent {
                        transparency = property.simple().number(0)?.clamp(0.0, 1.0);
                    }
                }
            }
            _ => {}
        }
    }
    Ok(rgb.map(|rgb| ColorStyle { rgb, transparency }))
}

/// Red, green and blue of `COLOUR_RGB(name, r, g, b)` or of a colour by name.
fn color(entity: Entity<'_>) -> Result<Option<[f64; 3]>, Refusal> {
    let attributes = entity.simple();
    match entity.keyword() {
        Keyword::ColourRgb => {
            let [r, g, b] = [1, 2, 3].map(|i| attributes.number(i).map(|value| value.clamp(0.0, 1.0)));
            Ok(Some([r?, g?, b?]))
        }
        Keyword::DraughtingPreDefinedColour | Keyword::PreDefinedColour => {
            let name = attributes.text(0);
            let known = NAMED_COLORS.iter().find(|(known, _)| known.eq_ignore_ascii_case(&name));
            known
                .map(|(_, rgb)| Some(*rgb))
                .ok_or_else(|| entity.refuse(format!("the colour {name:?} is unknown")))
        }
        _ => Ok(None),
    }
}

/// Colours of @iso10303-46 with a name.
const NAMED_COLORS: [(&str, [f64; 3]); 8] = [
    ("red", [1.0, 0.0, 0.0]),
    ("green", [0.0, 1.0, 0.0]),
    ("blue", [0.0, 0.0, 1.0]),
    ("yellow", [1.0, 1.0, 0.0]),
    ("magenta", [1.0, 0.0, 1.0]),
    ("cyan", [0.0, 1.0, 1.0]),
    ("black", [0.0; 3]),
    ("white", [1.0; 3]),
];
