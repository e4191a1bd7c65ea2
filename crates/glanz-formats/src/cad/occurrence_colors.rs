//! Colors that occurrences give to what is inside of them.

use std::collections::{BTreeMap, HashMap};

use glanz_brep::model::{ColorStyle, EntityId, StyleOverride};

/// A color as a key: the bits of red, green, blue and transparency.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct ColorKey([u64; 4]);

impl From<ColorStyle> for ColorKey {
    fn from(ColorStyle { rgb: [r, g, b], transparency }: ColorStyle) -> Self {
        Self([r, g, b, transparency].map(f64::to_bits))
    }
}

impl From<ColorKey> for ColorStyle {
    fn from(ColorKey(bits): ColorKey) -> Self {
        let [r, g, b, transparency] = bits.map(f64::from_bits);
        Self { rgb: [r, g, b], transparency }
    }
}

/// The overriding colors that hold inside an occurrence.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct ActiveOverrides {
    /// That of everything but single items.
    whole: Option<ColorKey>,
    items: BTreeMap<EntityId, ColorKey>,
    /// Overrides whose path goes on inside: the index, and the number of occurrences behind.
    open: Vec<(usize, usize)>,
}

impl ActiveOverrides {
    /// The number of single colors and open paths.
    pub(super) fn len(&self) -> usize {
        self.items.len() + self.open.len()
    }
}

/// The overrides of a model by the occurrence where their path starts.
#[derive(Debug)]
pub(super) struct OverrideIndex<'a> {
    overrides: &'a [StyleOverride],
    starts: HashMap<EntityId, Vec<usize>>,
    everywhere: HashMap<EntityId, ColorKey>,
}

impl<'a> OverrideIndex<'a> {
    pub(super) fn new(overrides: &'a [StyleOverride]) -> Self {
        let mut starts: HashMap<EntityId, Vec<usize>> = HashMap::new();
        let mut everywhere = HashMap::new();
        for (i, StyleOverride { path, item, style }) in overrides.iter().enumerate() {
            match path.first() {
                Some(first) => starts.entry(*first).or_default().push(i),
                None => drop(everywhere.entry(*item).or_insert(ColorKey::from(*style))),
            }
        }
        Self { overrides, starts, everywhere }
    }

    /// The color of what is the first of these items, and inside of the others, within an occurrence.
    pub(super) fn color(&self, active: &ActiveOverrides, items: [EntityId; 3]) -> Option<ColorKey> {
        let single = |colors: &dyn Fn(&EntityId) -> Option<ColorKey>| items.iter().find_map(colors);
        single(&|item| active.items.get(item).copied())
            .or(active.whole)
            .or_else(|| single(&|item| self.everywhere.get(item).copied()))
    }

    /// The number of colors and paths that [`Self::inside`] looks at.
    pub(super) fn steps(&self, outside: &ActiveOverrides, occurrence: EntityId) -> usize {
        outside.len() + self.starts.get(&occurrence).map_or(0, Vec::len)
    }

    /// What holds inside an occurrence, by what holds around it: outer occurrences before inner ones.
    pub(super) fn inside(&self, outside: &ActiveOverrides, occurrence: EntityId) -> ActiveOverrides {
        let mut inside = ActiveOverrides { open: Vec::new(), ..outside.clone() };
        inside.whole = outside.items.get(&occurrence).copied().or(outside.whole);
        // Nothing single counts any more in what has one color as a whole, other than what was single before.
        let is_whole = inside.whole.is_some();
        let starting = self.starts.get(&occurrence).into_iter().flatten().map(|&i| (i, 0));
        for (i, behind) in outside.open.iter().copied().chain(starting) {
            let Some(StyleOverride { path, item, style }) = self.overrides.get(i) else { continue };
            if path.get(behind) != Some(&occurrence) {
                continue;
            }
            if behind + 1 < path.len() {
                inside.open.push((i, behind + 1));
                continue;
            }
            let color = ColorKey::from(*style);
            if !is_whole && *item == occurrence {
                inside.whole.get_or_insert(color);
            } else if !is_whole {
                inside.items.entry(*item).or_insert(color);
            }
        }
        inside
    }
}
