//! Models with light maps: the triangles of every chart, with their texture coordinates on the pages.

use std::collections::BTreeMap;

use glanz_formats::glb::{GlbCamera, GlbModel, GlbNode, GlbPrimitive};
use glanz_formats::image::{self, Format};
use glanz_light::{Pixels, PixelsError, Spectrum, Tone, Wavelengths};
use glanz_math::{DVec2, DVec3};
use glanz_radiosity::bake::{Atlas, LightMap};
use glanz_radiosity::tessellate::{Triangles, divisions, tessellate};
use glanz_scene::PlacedSurface;

use crate::axes::Axes;
use crate::error::Error;

/// Distance of the two sides of a surface in a model, relative to the tolerance.
const SHIFT: f64 = 0.25;

/// Builder of a model.
pub(super) struct ModelBuilder<'a> {
    pub(super) surfaces: &'a [PlacedSurface<'a>],
    pub(super) maps: &'a [LightMap],
    pub(super) atlas: &'a Atlas,
    pub(super) names: &'a [String],
    pub(super) axes: Axes,
    pub(super) camera: Option<GlbCamera>,
    /// Metres.
    pub(super) tolerance: f64,
    pub(super) tone: Tone,
}

impl ModelBuilder<'_> {
    /// The model, one node for each shape in its place.
    pub(super) fn build(&self) -> Result<GlbModel, Error> {
        let mut pictures = Vec::new();
        for page in &self.atlas.pages {
            let pixels = pixels(&page.radiance, self.atlas.side)?;
            pictures.push(image::write(&pixels, Format::Png, &self.tone, &BTreeMap::new())?);
        }
        let mut nodes: BTreeMap<(u32, u32), BTreeMap<Option<usize>, GlbPrimitive>> = BTreeMap::new();
        let mut known: BTreeMap<u32, [u32; 2]> = BTreeMap::new();
        for (number, (map, slot)) in self.maps.iter().zip(&self.atlas.slots).enumerate() {
            let chart = &map.chart;
            if map.is_hidden {
                continue;
            }
            let Some(surface) = self.surfaces.get(chart.surface as usize) else { continue };
            let divisions = *known.entry(chart.surface).or_insert_with(|| divisions(surface, self.tolerance));
            let triangles = tessellate(surface, chart, divisions, self.tolerance);
            let picture = slot.map(|slot| slot.page as usize);
            let part = nodes.entry((chart.surface, chart.shape)).or_default().entry(picture);
            let part = part.or_insert_with(|| GlbPrimitive { picture, ..GlbPrimitive::default() });
            let at = |texel: DVec2| slot.map_or(DVec2::ZERO, |slot| self.atlas.coordinates(&slot, texel));
            self.add(part, &triangles, at, self.shift(number));
        }
        let node = |((_, shape), parts): ((u32, u32), BTreeMap<Option<usize>, GlbPrimitive>)| GlbNode {
            name: self.names.get(shape as usize).cloned().unwrap_or_else(|| format!("shape {shape}")),
            parts: parts.into_values().collect(),
        };
        Ok(GlbModel { pictures, nodes: nodes.into_iter().map(node).collect(), camera: self.camera.clone() })
    }

    /// Distance by which a side is moved away from the other: programs that do not cull back faces would show coincident sides in
    /// alternation.
    fn shift(&self, number: usize) -> f64 {
        let (Some(map), Some(other)) = (self.maps.get(number), self.maps.get(number ^ 1)) else { return 0.0 };
        let moves = match (map.is_dark(), other.is_dark()) {
            (true, false) => true,
            (false, true) => false,
            _ => map.chart.back,
        };
        if moves && !other.is_hidden { SHIFT * self.tolerance } else { 0.0 }
    }

    fn add(&self, part: &mut GlbPrimitive, triangles: &Triangles, at: impl Fn(DVec2) -> DVec2, shift: f64) {
        let base = part.positions.len() as u32;
        let world = |p: DVec3| self.axes.of_point(p).as_vec3().to_array();
        let moved = triangles.positions.iter().zip(&triangles.normals).map(|(p, n)| *p + shift * *n);
        part.positions.extend(moved.map(world));
        part.normals.extend(triangles.normals.iter().copied().map(world));
        part.coordinates[0].extend(triangles.uvs.iter().map(|uv| uv.as_vec2().to_array()));
        part.coordinates[1].extend(triangles.texels.iter().map(|&texel| at(texel).as_vec2().to_array()));
        let turned = |&[a, b, c]: &[u32; 3]| {
            if self.axes.is_mirrored() {
                [base + a, base + c, base + b]
            } else {
                [base + a, base + b, base + c]
            }
        };
        part.indices.extend(triangles.indices.iter().map(turned));
    }
}

/// A page as a picture.
pub(super) fn pixels(page: &[Spectrum], side: u32) -> Result<Pixels, PixelsError> {
    let wavelengths = Wavelengths::default();
    let rgb: Vec<[f32; 3]> = page.iter().map(|light| light.to_rgb(&wavelengths)).collect();
    Pixels::try_from_rgb(side, side, &rgb)
}
