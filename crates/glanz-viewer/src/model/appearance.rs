//! Materials in the form of a rasteriser.

use glanz_geometry::{FaceDomain, ShadingPoint};
use glanz_light::{Spectrum, Wavelengths};
use glanz_math::{DVec2, DVec3};
use glanz_scene::{PlacedSurface, Scene};
use glanz_shading::{Material, PreviewSurface, TexturePoint};

use super::head;

/// Samples along each side of a textured surface over which a material is averaged.
const PLACES: u32 = 16;

/// Largest number of faces that are sampled for this.
const MOST_FACES: usize = 64;

/// The material number `index` on `placed`, from `face` on; textures are averaged over samples of the surface.
pub(super) fn material(
    scene: &Scene,
    index: u32,
    name: &str,
    (placed, face): (&PlacedSurface<'_>, u32),
    emission: Spectrum,
) -> head::ModelMaterial {
    let wavelengths = Wavelengths::default();
    let material = scene.materials().get(index as usize);
    let previews: Vec<PreviewSurface> = places(placed, face)
        .iter()
        .filter_map(|at| {
            // Of a mixture the part with the larger weight.
            let material = scene.material_at(index as usize, at, &wavelengths, 0.5)?;
            material.preview(scene.textures(), at, &wavelengths)
        })
        .collect();
    let count = previews.len().max(1) as f64;
    let mean = |of: &dyn Fn(&PreviewSurface) -> f32| {
        (previews.iter().map(|preview| f64::from(of(preview))).sum::<f64>() / count) as f32
    };
    let color = |of: &dyn Fn(&PreviewSurface) -> Spectrum| {
        [0, 1, 2].map(|k| mean(&|preview| rgb(of(preview), &wavelengths)[k]))
    };
    let exponents: Vec<f64> = previews.iter().filter_map(|preview| preview.exponent).collect();
    let exponent = exponents.iter().sum::<f64>() / exponents.len() as f64;
    head::ModelMaterial {
        name: name.to_owned(),
        kind: material.map_or("interface", Material::kind),
        base: color(&|preview| preview.base),
        metallic: mean(&|preview| preview.metallic),
        roughness: mean(&|preview| preview.roughness),
        opacity: mean(&|preview| preview.opacity),
        specular: color(&|preview| preview.specular),
        exponent: exponent.is_finite().then_some(exponent),
        emission: rgb(emission, &wavelengths),
    }
}

/// Rec. 709, not below 0.
pub(super) fn rgb(spectrum: Spectrum, wavelengths: &Wavelengths) -> [f32; 3] {
    spectrum.to_rgb(wavelengths).map(|x| if x.is_finite() { x.max(0.0) } else { 0.0 })
}

/// Samples spread over the faces of the shape that begins with `face`.
fn places(placed: &PlacedSurface<'_>, face: u32) -> Vec<TexturePoint> {
    let shape = placed.shape(face);
    let faces: Vec<u32> = (face..placed.faces()).take_while(|&face| placed.shape(face) == shape).collect();
    let every = faces.len().div_ceil(MOST_FACES).max(1);
    let side = if faces.len() > 8 { 2 } else { PLACES };
    let grid = move |k: u32| (f64::from(k) + 0.5) / f64::from(side);
    let grid: Vec<DVec2> =
        (0..side).flat_map(|i| (0..side).map(move |j| DVec2::new(grid(i), grid(j)))).collect();
    let at = |face: u32| {
        let domain = placed.face_domain(face);
        let inside = move |uv: &DVec2| match &domain {
            FaceDomain::Square => *uv,
            // Half of the unit square is the triangle; a facet is flat and is sampled in its middle.
            FaceDomain::Polygon(corners) if corners.len() == 3 => 0.5 * *uv,
            FaceDomain::Polygon(corners) => corners.iter().sum::<DVec2>() / corners.len().max(1) as f64,
        };
        let found = grid.iter().filter_map(move |uv| placed.at(face, inside(uv), false));
        found.map(|found| found.at.point).map(texture_point).collect::<Vec<_>>()
    };
    let mut found: Vec<TexturePoint> = faces.iter().step_by(every).flat_map(|&face| at(face)).collect();
    if found.is_empty() {
        // Without parameters, or trimmed away at all samples.
        found = grid.iter().map(|&uv| TexturePoint::new(uv, uv.extend(0.0) + DVec3::ZERO)).collect();
    }
    found
}

fn texture_point(point: ShadingPoint) -> TexturePoint {
    TexturePoint::new(point.uv, point.position).with_normal(point.normal)
}
