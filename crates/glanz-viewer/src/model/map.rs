//! Maps of values on surfaces: illuminance or baked light.

use glanz_math::DVec2;
use glanz_math::glam::Vec3;
use glanz_radiosity::bake::filled;
use glanz_scene::Scene;

use super::error::ModelError;
use super::visible_patches::{VisiblePatch, visible_patches};
use super::{Model, head};

/// Largest number of texels along a side of a map; every graphics card supports it.
const LARGEST: usize = 4096;

/// Texels of a map beyond which patches get fewer values: 2048 x 2048 steps between them, and one more value along each side of up to 32 x 32 patches.
const MOST_TEXELS: usize = 2080 * 2080;

/// Words of a patch that locate its tile in the map.
const WORDS: std::ops::Range<usize> = 12..16;

/// What the values of a map are.
#[derive(Clone, Copy, Debug)]
pub struct MapLabel<'a> {
    /// Such as "lx".
    pub unit: &'a str,
    /// Whether values are colours; otherwise they are numbers, the first of each three.
    pub is_colour: bool,
    /// Whether the two sides of surfaces have different values.
    pub two_sided: bool,
}

/// Values of one side of a patch, row by row along its x.
type SideValues = Vec<[f32; 3]>;

/// Values of one patch: of its front, and of its back if the map has two sides.
struct MapTile {
    object: usize,
    /// Number of the patch among those of its surface.
    patch: usize,
    sides: Vec<SideValues>,
}

/// Places of the tiles of a map: those of the fronts from the first row on, then those of the backs.
struct MapLayout {
    columns: usize,
    /// Rows of the tiles of one side.
    rows: usize,
    sides: usize,
}

impl MapLayout {
    fn new(tiles: usize, sides: usize) -> Self {
        let columns = ((tiles * sides) as f64).sqrt().ceil().max(1.0) as usize;
        Self { columns, rows: tiles.div_ceil(columns).max(1), sides }
    }

    /// Column and row of a tile.
    fn place(&self, slot: usize, side: usize) -> [usize; 2] {
        [slot % self.columns, slot / self.columns + side * self.rows]
    }
}

impl Model {
    /// The model with values on its surfaces.
    ///
    /// `value`: the value at parameters of a face of a surface, by its number in [`Scene::placed_surfaces`], on its back or its front;
    /// parameters are those of [`PlacedSurface::at`](glanz_scene::PlacedSurface::at); `None` where it is unknown, such as where the
    /// surface is trimmed away: known values beside it are repeated there. Surfaces without any known value get no map, nor do those that
    /// are sent as triangles or polynomials; a map that no surface has is sent without its values. `has_values`: whether a surface may have
    /// known values, by its number. `side`: values along each side of a patch, at least 2; fewer if very many patches may have values. `scene`: that of the model.
    ///
    /// # Errors
    /// [`ModelError::TooMany`] patches for one map.
    pub fn with_map(
        mut self,
        label: MapLabel<'_>,
        scene: &Scene,
        side: usize,
        has_values: impl Fn(u32) -> bool,
        value: impl Fn(u32, u32, DVec2, bool) -> Option<[f32; 3]>,
    ) -> Result<Self, ModelError> {
        let backs = if label.two_sided { &[false, true][..] } else { &[false] };
        let placed = scene.placed_surfaces();
        // Only meshes have several objects.
        let objects = (0..).zip(placed.iter().zip(&self.objects)).filter_map(|(number, (surface, parts))| {
            let [(_, object)] = parts.as_slice() else { return None };
            let patches = self.patch_count(self.head.objects.get(*object as usize)?.surface);
            has_values(number).then_some((number, surface, *object as usize, patches))
        });
        let objects: Vec<_> = objects.collect();
        let count = objects.iter().map(|(.., patches)| patches).sum();
        let side = side_of(side, count, &MapLayout::new(count, backs.len()))?;
        let mut tiles = Vec::new();
        for (number, surface, object, patches) in objects {
            let visible = visible_patches(surface, scene.bounds()).unwrap_or_default();
            if patches == visible.len() {
                let sampled = sampled(&visible, side, backs, |face, uv, back| value(number, face, uv, back));
                let own = |(patch, sides)| MapTile { object, patch, sides };
                tiles.extend(sampled.into_iter().flatten().enumerate().map(own));
            }
        }
        self.add_map(label, side, &MapLayout::new(tiles.len(), backs.len()), &tiles);
        Ok(self)
    }

    fn patch_count(&self, surface: usize) -> usize {
        match self.head.surfaces.get(surface) {
            Some(head::ModelSurface::Patches { count, .. }) => *count,
            _ => 0,
        }
    }

    fn add_map(&mut self, label: MapLabel<'_>, side: usize, layout: &MapLayout, tiles: &[MapTile]) {
        // A map that nothing shows tells the page only that there is light to be read.
        let side = if tiles.is_empty() { 1 } else { side };
        let (width, height) = (layout.columns * side, layout.sides * layout.rows * side);
        let channels = if label.is_colour { 3 } else { 1 };
        let mut texels = vec![0.0; channels * width * height];
        let number = self.head.maps.len();
        let mut last = None;
        for (slot, tile) in tiles.iter().enumerate() {
            if last != Some(tile.object) {
                self.own_patches(tile.object, number);
                last = Some(tile.object);
            }
            for (number, values) in tile.sides.iter().enumerate() {
                let [x, y] = layout.place(slot, number).map(|at| at * side);
                for (row, values) in values.chunks(side).enumerate() {
                    let start = channels * ((y + row) * width + x);
                    let numbers = values.iter().flat_map(|value| value.iter().take(channels));
                    let texels = texels.iter_mut().skip(start);
                    texels.zip(numbers).for_each(|(texel, number)| *texel = *number);
                }
            }
            // From the middle of the first texel to that of the last: filtering never reaches a neighbouring tile.
            let [x, y] = layout.place(slot, 0).map(|at| at * side);
            let shares = [(x, width), (y, height)];
            let begins = shares.map(|(at, size)| (at as f64 + 0.5) / size as f64);
            let sizes = shares.map(|(_, size)| (side - 1) as f64 / size as f64);
            let words = begins.into_iter().chain(sizes).map(|share| (share as f32).to_bits());
            if let Some(row) = self.patch_of(tile) {
                row.iter_mut().zip(words).for_each(|(slot, word)| *slot = word);
            }
        }
        let largest = texels.iter().fold(0.0, |most: f32, x| most.max(*x));
        self.head.maps.push(head::ModelMap {
            unit: label.unit.to_owned(),
            block: format!("map{number}"),
            width,
            height,
            sides: layout.sides,
            channels,
            largest,
        });
        self.blocks.maps.push(texels);
    }

    /// Gives an object patches of its own on the same control points, because other instances of its surface show other values.
    fn own_patches(&mut self, object: usize, map: usize) {
        let Some(object) = self.head.objects.get_mut(object) else { return };
        object.map = Some(map);
        let Some(head::ModelSurface::Patches { first, count, origin, region, mapping }) =
            self.head.surfaces.get(object.surface)
        else {
            return;
        };
        let copy = head::ModelSurface::Patches {
            first: self.blocks.patches.len(),
            count: *count,
            origin: *origin,
            region: *region,
            mapping: *mapping,
        };
        let range = *first..*first + *count;
        if range.end <= self.blocks.patches.len() {
            self.blocks.patches.extend_from_within(range);
        }
        object.surface = self.head.surfaces.len();
        self.head.surfaces.push(copy);
    }

    fn patch_of(&mut self, tile: &MapTile) -> Option<&mut [u32]> {
        let surface = self.head.objects.get(tile.object)?.surface;
        let Some(head::ModelSurface::Patches { first, .. }) = self.head.surfaces.get(surface) else {
            return None;
        };
        self.blocks.patches.get_mut(first + tile.patch)?.get_mut(WORDS)
    }
}

/// Values along the side of a patch, such that all patches fit into a map. Fewer values are, if they can be, some of those that there would be otherwise,
/// so that they stay at the borders of cells.
fn side_of(side: usize, count: usize, layout: &MapLayout) -> Result<usize, ModelError> {
    let rows = layout.sides * layout.rows;
    let widest = LARGEST / layout.columns.max(rows);
    if widest < 2 {
        let most = ((LARGEST / 2) * (LARGEST / 2) / layout.sides) as u64;
        return Err(ModelError::TooMany { what: "patches that show values", count: count as u64, most });
    }
    let most = widest.min((MOST_TEXELS / (layout.columns * rows)).isqrt()).max(2);
    let mut steps = side.max(2) - 1;
    while steps >= most && steps.is_multiple_of(2) {
        steps /= 2;
    }
    Ok((steps + 1).min(most))
}

/// The values of the sides of each patch; `None` if no value is known.
fn sampled(
    patches: &[VisiblePatch],
    side: usize,
    backs: &[bool],
    value: impl Fn(u32, DVec2, bool) -> Option<[f32; 3]>,
) -> Option<Vec<Vec<SideValues>>> {
    let mut known = false;
    let at = |k: usize| k as f64 / (side - 1) as f64;
    let mut values = Vec::with_capacity(patches.len());
    for patch in patches {
        let mut of_side = |&back: &bool| {
            let grid = (0..side).flat_map(|row| (0..side).map(move |column| (at(column), at(row))));
            let found: Vec<Option<Vec3>> = grid
                .map(|(x, y)| value(patch.face, patch.parameters.of_face(x, y), back).map(Vec3::from))
                .collect();
            known |= found.iter().any(Option::is_some);
            filled(found, [side, side]).into_iter().map(|value| value.to_array()).collect()
        };
        values.push(backs.iter().map(&mut of_side).collect());
    }
    known.then_some(values)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fewer_values_are_some_of_those_on_cells() {
        let side = |side, tiles, sides| side_of(side, tiles, &MapLayout::new(tiles, sides)).unwrap();
        // Two values for each of 512, 256 and 128 cells, and one more.
        assert_eq!([1, 4, 5, 16, 17].map(|tiles| side(1025, tiles, 1)), [1025, 1025, 513, 513, 257]);
        assert_eq!([16, 17].map(|tiles| side(513, tiles, 1)), [513, 257]);
        assert_eq!([64, 65].map(|tiles| side(257, tiles, 1)), [257, 129]);
        assert_eq!([2, 3].map(|tiles| side(1025, tiles, 2)), [1025, 513]);
        // 66 steps can be halved once, 65 cannot, and 33 x 33 patches have up to 63 values.
        assert_eq!([67, 66, 63].map(|wanted| side(wanted, 33 * 33, 1)), [34, 63, 63]);
        let most = (LARGEST / 2) * (LARGEST / 2);
        assert_eq!(side(65, most, 1), 2);
        assert!(side_of(65, most + 1, &MapLayout::new(most + 1, 1)).is_err());
    }
}
