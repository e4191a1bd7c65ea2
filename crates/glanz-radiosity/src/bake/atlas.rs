//! Light maps side by side.

use glanz_light::Spectrum;
use glanz_math::DVec2;

use super::LightMap;
use crate::charts::{Packed, Slot, pack};

/// Texels around each chart that repeat its border, so that no filter reaches the next chart.
pub const BORDER: u32 = 2;

/// Longest side of a page.
const LONGEST: u32 = 8192;

/// Light maps in square pages.
#[derive(Clone, Debug)]
pub struct Atlas {
    /// Texels along a side of the pages.
    pub side: u32,
    /// The pages.
    pub pages: Vec<Page>,
    /// Where each light map is; `None` for those that are dark.
    pub slots: Vec<Option<Slot>>,
}

/// A page: rows of texels one after the other.
#[derive(Clone, Debug)]
pub struct Page {
    /// Irradiance, in units of radiance.
    pub irradiance: Vec<Spectrum>,
    /// Radiance that leaves.
    pub radiance: Vec<Spectrum>,
}

impl Atlas {
    /// Lays light maps out; those that are dark take no room.
    #[must_use]
    pub fn new(maps: &[LightMap]) -> Self {
        let lit: Vec<&LightMap> = maps.iter().filter(|map| !map.is_dark()).collect();
        let sizes: Vec<[u32; 2]> = lit.iter().map(|map| map.chart.size).collect();
        let Packed { side, pages, slots } = pack(&sizes, BORDER, LONGEST);
        let count = side as usize * side as usize;
        let black = || vec![Spectrum::BLACK; count];
        let mut pages: Vec<Page> = (0..if lit.is_empty() { 0 } else { pages })
            .map(|_| Page { irradiance: black(), radiance: black() })
            .collect();
        for (map, slot) in lit.iter().zip(&slots) {
            if let Some(page) = pages.get_mut(slot.page as usize) {
                put(map, slot.corner, side as usize, page);
            }
        }
        let mut slots = slots.into_iter();
        let slots = maps.iter().map(|map| if map.is_dark() { None } else { slots.next() }).collect();
        Self { side, pages, slots }
    }

    /// Coordinates on a page, (0, 0) its first corner and (1, 1) its last, of a point of a chart in texels.
    #[must_use]
    pub fn coordinates(&self, slot: &Slot, texel: DVec2) -> DVec2 {
        let corner = DVec2::new(f64::from(slot.corner[0]), f64::from(slot.corner[1]));
        (corner + texel + 0.5) / f64::from(self.side)
    }
}

fn put(map: &LightMap, corner: [u32; 2], side: usize, page: &mut Page) {
    let [width, height] = map.chart.size;
    // Corners leave room for the border.
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
