//! Light maps as bytes, for display without baking again.
//!
//! | bytes | content |
//! |---|---|
//! | 4 | charts |
//! | 1, 4 each | whether it is on the dark inside of a solid; texels, 0 if it is dark |
//! | 24 each | irradiance and radiance of each texel: red, green and blue |
//!
//! Numbers are little-endian. The geometry of charts is not written, because it follows from scene and density.

use super::LightMap;
use super::state::{read_bytes, read_light, write_light};
use crate::charts::charts;
use crate::elements::Elements;

/// Bytes of light maps.
#[must_use]
pub fn to_bytes(maps: &[LightMap]) -> Vec<u8> {
    let mut bytes = Vec::new();
    bytes.extend((maps.len() as u32).to_le_bytes());
    for map in maps {
        bytes.push(u8::from(map.is_hidden));
        bytes.extend((map.irradiance.len() as u32).to_le_bytes());
        for (&irradiance, &radiance) in map.irradiance.iter().zip(&map.radiance) {
            write_light(&mut bytes, irradiance);
            write_light(&mut bytes, radiance);
        }
    }
    bytes
}

/// Reads the bytes of [`to_bytes`] for light maps of `elements` with `density` texels per metre; `None` if they are no such light maps.
#[must_use]
pub fn from_bytes(elements: &Elements<'_>, density: f64, bytes: &[u8]) -> Option<Vec<LightMap>> {
    if !(density > 0.0 && density.is_finite()) {
        return None;
    }
    let mut rest = bytes;
    let charts = charts(&elements.surfaces, density);
    if u32::from_le_bytes(read_bytes(&mut rest)?) as usize != charts.len() {
        return None;
    }
    let mut maps = Vec::with_capacity(charts.len());
    for chart in charts {
        let is_hidden = read_bytes::<1>(&mut rest)? != [0];
        let count = u32::from_le_bytes(read_bytes(&mut rest)?) as usize;
        if count != 0 && count != chart.texels() || count > rest.len() {
            return None;
        }
        let mut map = LightMap { chart, irradiance: Vec::new(), radiance: Vec::new(), is_hidden };
        for _ in 0..count {
            map.irradiance.push(read_light(&mut rest)?);
            map.radiance.push(read_light(&mut rest)?);
        }
        maps.push(map);
    }
    rest.is_empty().then_some(maps)
}
