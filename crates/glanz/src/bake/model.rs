//! Models with light maps: the triangles of every chart, with their texture coordinates on the pages.

use std::collections::BTreeMap;
use std::sync::Arc;

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
        let shifts =
            self.maps.chunk_by(|a, b| Arc::ptr_eq(&a.chart.sheet, &b.chart.sheet)).flat_map(|maps| {
                let of_sides =
                    moved_sides(maps).map(|moves| if moves { SHIFT * self.tolerance } else { 0.0 });
                maps.iter().map(move |map| if map.chart.back { of_sides[1] } else { of_sides[0] })
            });
        for ((map, slot), shift) in self.maps.iter().zip(&self.atlas.slots).zip(shifts) {
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
            self.add(part, &triangles, at, shift);
        }
        let node = |((_, shape), parts): ((u32, u32), BTreeMap<Option<usize>, GlbPrimitive>)| GlbNode {
            name: self.names.get(shape as usize).cloned().unwrap_or_else(|| format!("shape {shape}")),
            parts: parts.into_values().collect(),
        };
        Ok(GlbModel { pictures, nodes: nodes.into_iter().map(node).collect(), camera: self.camera.clone() })
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

/// Whether the front and the back of a sheet are moved away from each other: programs that do not cull back faces would show coincident sides
/// in alternation. `maps`: those of the sheet.
fn moved_sides(maps: &[LightMap]) -> [bool; 2] {
    let all = |back: bool, condition: fn(&LightMap) -> bool| {
        maps.iter().filter(|map| map.chart.back == back).all(condition)
    };
    [false, true].map(|back| {
        let moves = match (all(back, LightMap::is_dark), all(!back, LightMap::is_dark)) {
            (true, false) => true,
            (false, true) => false,
            _ => back,
        };
        moves && !all(!back, |map| map.is_hidden)
    })
}

/// A page as a picture.
pub(super) fn pixels(page: &[Spectrum], side: u32) -> Result<Pixels, PixelsError> {
    let wavelengths = Wavelengths::default();
    let rgb: Vec<[f32; 3]> = page.iter().map(|light| light.to_rgb(&wavelengths)).collect();
    Pixels::try_from_rgb(side, side, &rgb)
}

#[cfg(test)]
mod tests {
    use glanz_job::{CancelFlag, Silent};
    use glanz_radiosity::bake::{BakeSettings, bake};
    use glanz_radiosity::elements::{ElementSettings, Elements};
    use glanz_scene::SceneBuilder;
    use glanz_scene::description::{LightDescription, LightKind, MaterialKind, ShapeDescription};

    use super::*;

    #[test]
    fn one_side_of_a_floor_that_a_wall_divides_is_moved() {
        let grey = || MaterialKind::diffuse(0.5);
        let sheet = ShapeDescription::parallelogram(DVec3::X, DVec3::Y * 2.0, DVec3::Z);
        let scene = SceneBuilder::new()
            .shape(ShapeDescription::parallelogram(DVec3::ZERO, DVec3::X * 2.0, DVec3::Y * 2.0), grey())
            .shape(sheet, grey())
            .light(LightDescription::new(
                LightKind::Point { from: DVec3::new(0.5, 1.0, 1.5), range: None },
                1.0,
            ))
            .resolve()
            .unwrap()
            .0;
        let elements = Elements::new(&scene, &ElementSettings { side: 1.0 }).unwrap();
        let settings = BakeSettings { density: 5.0, rays: 16, shadow_rays: 4, ..BakeSettings::default() };
        let maps = bake(&elements, &settings, &mut Silent, &CancelFlag::default()).unwrap().maps;
        let floor: Vec<LightMap> = maps.into_iter().filter(|map| map.chart.surface == 0).collect();
        assert_eq!(floor.iter().map(|map| map.chart.back).collect::<Vec<_>>(), [false, false, true]);
        // The lower side is dark.
        assert_eq!(moved_sides(&floor), [false, true]);
        let sheets = floor.chunk_by(|a, b| Arc::ptr_eq(&a.chart.sheet, &b.chart.sheet));
        assert_eq!(sheets.count(), 1);
    }
}
