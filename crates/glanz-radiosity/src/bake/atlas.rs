//! Pages of light maps.

use glanz_light::Spectrum;
use glanz_math::DVec2;

use super::LightMap;
use crate::charts::{AtlasSlot, Packing, pack};

/// Width of the margin around each chart, texels, which repeats its border so that filters do not reach the next chart.
pub const BORDER: u32 = 2;

/// Longest side of a page, texels.
const MAX_SIDE: u32 = 8192;

/// Square pages with the texels of light maps.
#[derive(Clone, Debug)]
pub struct Atlas {
    /// Side of the pages, texels.
    pub side: u32,
    /// The pages.
    pub pages: Vec<AtlasPage>,
    /// Location of each light map; `None` for those that are dark.
    pub slots: Vec<Option<AtlasSlot>>,
}

/// Texels of a page, row by row.
#[derive(Clone, Debug)]
pub struct AtlasPage {
    /// Irradiance of each texel, in units of radiance.
    pub irradiance: Vec<Spectrum>,
    /// Radiance that leaves each texel.
    pub radiance: Vec<Spectrum>,
}

impl Atlas {
    /// Packs light maps; dark ones take no space.
    #[must_use]
    pub fn new(maps: &[LightMap]) -> Self {
        let lit: Vec<&LightMap> = maps.iter().filter(|map| !map.is_dark()).collect();
        let sizes: Vec<[u32; 2]> = lit.iter().map(|map| map.chart.size).collect();
        let Packing { side, pages, slots } = pack(&sizes, BORDER, MAX_SIDE);
        let count = side as usize * side as usize;
        let black = || vec![Spectrum::BLACK; count];
        let mut pages: Vec<AtlasPage> = (0..if lit.is_empty() { 0 } else { pages })
            .map(|_| AtlasPage { irradiance: black(), radiance: black() })
            .collect();
        for (map, slot) in lit.iter().zip(&slots) {
            if let Some(page) = pages.get_mut(slot.page as usize) {
                copy_to_page(map, slot.corner, side as usize, page);
            }
        }
        let mut slots = slots.into_iter();
        let slots = maps.iter().map(|map| if map.is_dark() { None } else { slots.next() }).collect();
        Self { side, pages, slots }
    }

    /// Coordinates on a page, from (0, 0) in its first corner to (1, 1) in its last, of a point of a chart in texels.
    #[must_use]
    pub fn coordinates(&self, slot: &AtlasSlot, texel: DVec2) -> DVec2 {
        let corner = DVec2::new(f64::from(slot.corner[0]), f64::from(slot.corner[1]));
        (corner + texel + 0.5) / f64::from(self.side)
    }
}

fn copy_to_page(map: &LightMap, corner: [u32; 2], side: usize, page: &mut AtlasPage) {
    let [width, height] = map.chart.size;
    // The corners of slots leave space for the margin.
    for y in 0..height + 2 * BORDER {
        for x in 0..width + 2 * BORDER {
            let inside = |n: u32, size: u32| n.saturating_sub(BORDER).min(size - 1) as usize;
            let from = inside(y, height) * width as usize + inside(x, width);
            let to = (corner[1] + y - BORDER) as usize * side + (corner[0] + x - BORDER) as usize;
            page.irradiance[to] = map.irradiance[from];
            page.radiance[to] = map.radiance[from];
        }
    }
}
