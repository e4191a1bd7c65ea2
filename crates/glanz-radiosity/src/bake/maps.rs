//! Lookup of light at points of surfaces.

use glanz_light::Spectrum;
use glanz_scene::ParametricPoint;

use super::LightMap;
use super::lookup::SurfaceIndex;
use crate::charts::Chart;
use crate::elements::Elements;

/// All light maps of a scene, with an index.
#[derive(Debug)]
pub struct LightMaps {
    index: SurfaceIndex,
    maps: Vec<LightMap>,
}

impl LightMaps {
    /// Indexes `maps`, which [`bake`](super::bake) made of `elements`.
    #[must_use]
    pub fn new(elements: &Elements<'_>, maps: Vec<LightMap>) -> Self {
        let charts: Vec<Chart> = maps.iter().map(|map| map.chart.clone()).collect();
        Self { index: SurfaceIndex::new(elements, &charts), maps }
    }

    /// All light maps.
    #[must_use]
    pub fn as_slice(&self) -> &[LightMap] {
        &self.maps
    }

    /// Irradiance at a point in units of radiance, bilinear between texels; `None` where there is no chart.
    #[must_use]
    pub fn irradiance(&self, place: &ParametricPoint) -> Option<Spectrum> {
        let (number, texel) =
            self.index.on_chart(|number| self.maps.get(number).map(|map| &map.chart), place)?;
        let map = self.maps.get(number)?;
        if map.is_dark() {
            return Some(Spectrum::BLACK);
        }
        let [width, height] = map.chart.size.map(|n| n as usize);
        let at = |x: usize, y: usize| {
            let texel = y.min(height.saturating_sub(1)) * width + x.min(width.saturating_sub(1));
            map.irradiance.get(texel).copied().unwrap_or_default()
        };
        let low = texel.floor();
        let (share, x, y) = (texel - low, low.x.max(0.0) as usize, low.y.max(0.0) as usize);
        let row = |y| at(x, y).lerp(at(x + 1, y), share.x as f32);
        Some(row(y).lerp(row(y + 1), share.y as f32))
    }
}
