//! Light maps in bytes, to be shown again without being made again.
//!
//! | bytes | content |
//! |---|---|
//! | 4 | charts |
//! | 1, 4 each | whether it is on the inside of a solid; texels, 0 if it is dark |
//! | 24 each | irradiance and radiance of each texel: red, green and blue |
//!
//! Numbers are little-endian. Where charts lie is not written: it follows from scene and density.

use super::LightMap;
use super::state::{put_light, take, take_light};
use crate::charts::charts;
use crate::elements::Elements;

/// Light maps in bytes.
#[must_use]
pub fn to_bytes(maps: &[LightMap]) -> Vec<u8> {
    let mut bytes = Vec::new();
    bytes.extend((maps.len() as u32).to_le_bytes());
    for map in maps {
        bytes.push(u8::from(map.is_hidden));
        bytes.extend((map.irradiance.len() as u32).to_le_bytes());
        for (&irradiance, &radiance) in map.irradiance.iter().zip(&map.radiance) {
            put_light(&mut bytes, irradiance);
            put_light(&mut bytes, radiance);
        }
    }
    bytes
}

/// Reads what [`to_bytes`] wrote of light maps that were made of `elements` with `density` texels per metre; `None` if they were not.
#[must_use]
pub fn from_bytes(elements: &Elements<'_>, density: f64, bytes: &[u8]) -> Option<Vec<LightMap>> {
    if !(density > 0.0 && density.is_finite()) {
        return None;
    }
    let mut rest = bytes;
    let charts = charts(&elements.surfaces, density);
    if u32::from_le_bytes(take(&mut rest)?) as usize != charts.len() {
        return None;
    }
    let mut maps = Vec::with_capacity(charts.len());
    for chart in charts {
        let is_hidden = take::<1>(&mut rest)? != [0];
        let count = u32::from_le_bytes(take(&mut rest)?) as usize;
        if count != 0 && count != chart.texels() || count > rest.len() {
            return None;
        }
        let mut map = LightMap { chart, irradiance: Vec::new(), radiance: Vec::new(), is_hidden };
        for _ in 0..count {
            map.irradiance.push(take_light(&mut rest)?);
            map.radiance.push(take_light(&mut rest)?);
        }
        maps.push(map);
    }
    rest.is_empty().then_some(maps)
}
