//! Colours of presentation styles.

use std::collections::HashMap;

use glanz_brep::model::{ColorStyle, EntityId};

use super::part21::{Entity, EntityAttributes, Keyword, Refusal, TapeToken};

/// Styles inside one another, at most.
const MAX_DEPTH: usize = 8;

/// What a style says about surfaces.
#[derive(Clone, Copy, Debug, Default)]
struct SurfaceAppearance {
    /// The colour with which they are filled.
    fill: Option<[f64; 3]>,
    /// The colour in which they are rendered.
    rendering: Option<[f64; 3]>,
    transparency: Option<f64>,
}

impl SurfaceAppearance {
    fn color(self) -> Option<ColorStyle> {
        let rgb = self.fill.or(self.rendering)?;
        Some(ColorStyle { rgb, transparency: self.transparency.unwrap_or(0.0) })
    }

    /// This one, and what it lacks of another.
    fn or(self, other: Self) -> Self {
        Self {
            fill: self.fill.or(other.fill),
            rendering: self.rendering.or(other.rendering),
            transparency: self.transparency.or(other.transparency),
        }
    }
}

/// A reader of styles, each of which is read once, however many items have it.
#[derive(Debug, Default)]
pub(super) struct ColorReader {
    known: HashMap<EntityId, Result<SurfaceAppearance, Refusal>>,
}

impl ColorReader {
    /// The colour that a style gives to surfaces; `None` for styles of curves and points.
    ///
    /// # Errors
    /// What cannot be read of it.
    pub(super) fn color(&mut self, style: Entity<'_>) -> Result<Option<ColorStyle>, Refusal> {
        Ok(self.appearance(style, MAX_DEPTH)?.color())
    }

    fn appearance(&mut self, entity: Entity<'_>, depth: usize) -> Result<SurfaceAppearance, Refusal> {
        if let Some(known) = self.known.get(&entity.id()) {
            return known.clone();
        }
        let reason = || format!("styles are nested deeper than {MAX_DEPTH} levels");
        let depth = depth.checked_sub(1).ok_or_else(|| entity.refuse(reason()))?;
        // A style inside itself adds nothing.
        self.known.insert(entity.id(), Ok(SurfaceAppearance::default()));
        let appearance = self.read(entity, depth);
        self.known.insert(entity.id(), appearance.clone());
        appearance
    }

    fn read(&mut self, entity: Entity<'_>, depth: usize) -> Result<SurfaceAppearance, Refusal> {
        let attributes = entity.simple();
        let none = SurfaceAppearance::default();
        Ok(match entity.keyword() {
            // PRESENTATION_STYLE_ASSIGNMENT((styles)).
            Keyword::PresentationStyleAssignment | Keyword::PresentationStyleByContext => {
                let mut first = none;
                for style in referred(&attributes, 0)? {
                    let style = self.appearance(style?, depth)?;
                    first = if first.color().is_some() { first } else { style };
                }
                first
            }
            // SURFACE_STYLE_USAGE(side, SURFACE_SIDE_STYLE(name, (elements))).
            Keyword::SurfaceStyleUsage => self.appearance(attributes.reference(1)?, depth)?,
            // SURFACE_STYLE_FILL_AREA(FILL_AREA_STYLE(name, (fills))).
            Keyword::SurfaceStyleFillArea => self.appearance(attributes.reference(0)?, depth)?,
            Keyword::SurfaceSideStyle | Keyword::FillAreaStyle => self.all(&attributes, 1, depth)?,
            Keyword::FillAreaStyleColour => {
                SurfaceAppearance { fill: rgb(attributes.reference(1)?)?, ..none }
            }
            // SURFACE_STYLE_RENDERING_WITH_PROPERTIES(method, colour, (properties)).
            Keyword::SurfaceStyleRendering | Keyword::SurfaceStyleRenderingWithProperties => {
                let rendering = rgb(attributes.reference(1)?)?;
                let properties = if attributes.len() > 2 { self.all(&attributes, 2, depth)? } else { none };
                SurfaceAppearance { rendering, ..properties }
            }
            Keyword::SurfaceStyleTransparent => {
                SurfaceAppearance { transparency: Some(attributes.number(0)?.clamp(0.0, 1.0)), ..none }
            }
            _ => none,
        })
    }

    /// The appearance by all elements of a list.
    fn all(
        &mut self,
        attributes: &EntityAttributes<'_>,
        list: usize,
        depth: usize,
    ) -> Result<SurfaceAppearance, Refusal> {
        referred(attributes, list)?.try_fold(SurfaceAppearance::default(), |appearance, element| {
            Ok(appearance.or(self.appearance(element?, depth)?))
        })
    }
}

/// The entities in a list, without its other items, such as `NULL_STYLE(.NULL.)`.
pub(super) fn referred<'a>(
    attributes: &EntityAttributes<'a>,
    i: usize,
) -> Result<impl Iterator<Item = Result<Entity<'a>, Refusal>> + use<'a>, Refusal> {
    let attributes = *attributes;
    let is_reference = move |at: &u32| matches!(attributes.token(*at), TapeToken::Reference(_));
    Ok(attributes.list(i)?.filter(is_reference).map(move |at| attributes.reference_at(at)))
}

/// Red, green and blue of `COLOUR_RGB(name, r, g, b)` or of a colour by name.
fn rgb(entity: Entity<'_>) -> Result<Option<[f64; 3]>, Refusal> {
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
