//! Materials as a rasteriser knows them.

use glanz_geometry::FaceDomain;
use glanz_light::{Spectrum, Wavelengths};
use glanz_math::{DVec2, DVec3};
use glanz_scene::{PlacedSurface, Scene};
use glanz_shading::{Bsdf, Material, TexturePoint};

use super::head;

/// Opacity of glass: enough to see that it is there.
const GLASS: f32 = 0.15;

/// Places of a textured surface along each side over which a material is averaged.
const PLACES: u32 = 16;

/// Faces of a surface that are looked at for this.
const MOST_FACES: usize = 64;

/// The material number `index` as `placed` wears it, from `face` on; textures count by their mean over some of its places.
pub(super) fn material(
    scene: &Scene,
    index: u32,
    name: &str,
    (placed, face): (&PlacedSurface<'_>, u32),
    emission: Spectrum,
) -> head::Material {
    let wavelengths = Wavelengths::default();
    let material = scene.materials().get(index as usize);
    let looks: Vec<head::Material> = places(placed, face)
        .iter()
        .filter_map(|at| look(material?, material?.bsdf(scene.textures(), at, &wavelengths), &wavelengths))
        .collect();
    let count = looks.len().max(1) as f64;
    let mean = |of: &dyn Fn(&head::Material) -> f32| {
        (looks.iter().map(|look| f64::from(of(look))).sum::<f64>() / count) as f32
    };
    let color = |of: &dyn Fn(&head::Material) -> [f32; 3]| [0, 1, 2].map(|k| mean(&|look| of(look)[k]));
    let exponents: Vec<f64> = looks.iter().filter_map(|look| look.exponent).collect();
    let exponent = exponents.iter().sum::<f64>() / exponents.len() as f64;
    head::Material {
        name: name.to_owned(),
        kind: material.map_or("interface", kind),
        base: color(&|look| look.base),
        metallic: mean(&|look| look.metallic),
        roughness: mean(&|look| look.roughness),
        opacity: mean(&|look| look.opacity),
        specular: color(&|look| look.specular),
        exponent: exponent.is_finite().then_some(exponent),
        emission: rgb(emission, &wavelengths),
    }
}

/// Rec. 709, not below 0.
pub(super) fn rgb(spectrum: Spectrum, wavelengths: &Wavelengths) -> [f32; 3] {
    spectrum.to_rgb(wavelengths).map(|x| if x.is_finite() { x.max(0.0) } else { 0.0 })
}

fn kind(material: &Material) -> &'static str {
    match material {
        Material::Diffuse { .. } => "diffuse",
        Material::Mirror { .. } => "mirror",
        Material::Conductor { .. } => "conductor",
        Material::Dielectric { thin: true, .. } => "thindielectric",
        Material::Dielectric { .. } => "dielectric",
        Material::Phong { .. } => "phong",
        _ => "interface",
    }
}

/// Places spread over the faces of the shape that `face` begins.
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
            // Half of the unit square is the triangle; a facet is flat, and its middle says as much as any place.
            FaceDomain::Polygon(corners) if corners.len() == 3 => 0.5 * *uv,
            FaceDomain::Polygon(corners) => corners.iter().sum::<DVec2>() / corners.len().max(1) as f64,
        };
        let found = grid.iter().filter_map(move |uv| placed.at(face, inside(uv), false));
        found.map(|found| TexturePoint::new(found.at.point.uv, found.at.point.position)).collect::<Vec<_>>()
    };
    let mut found: Vec<TexturePoint> = faces.iter().step_by(every).flat_map(|&face| at(face)).collect();
    if found.is_empty() {
        // Without parameters, or trimmed away where it was looked for.
        found = grid.iter().map(|&uv| TexturePoint::new(uv, uv.extend(0.0) + DVec3::ZERO)).collect();
    }
    found
}

/// What a scattering model looks like; `None` for nothing at all.
fn look(material: &Material, bsdf: Option<Bsdf>, wavelengths: &Wavelengths) -> Option<head::Material> {
    let rgb = |spectrum| rgb(spectrum, wavelengths);
    let plain = head::Material {
        name: String::new(),
        kind: "",
        base: [0.0; 3],
        metallic: 0.0,
        roughness: 1.0,
        opacity: 1.0,
        specular: [0.0; 3],
        exponent: None,
        emission: [0.0; 3],
    };
    let metal = |base| head::Material { base, metallic: 1.0, roughness: 0.0, ..plain.clone() };
    Some(match bsdf? {
        Bsdf::Black => match material {
            Material::Mirror { .. } | Material::Conductor { .. } => metal([0.0; 3]),
            _ => plain,
        },
        Bsdf::Lambert(lambert) => head::Material { base: rgb(lambert.reflectance), ..plain },
        Bsdf::Mirror(mirror) => metal(rgb(mirror.reflectance)),
        Bsdf::Conductor(conductor) => metal(rgb(conductor.reflectance_at(1.0))),
        Bsdf::Dielectric(glass) => {
            let upright = ((glass.eta - 1.0) / (glass.eta + 1.0)).powi(2);
            head::Material {
                base: rgb(glass.transmittance),
                specular: rgb(glass.reflectance * upright as f32),
                roughness: 0.0,
                opacity: GLASS,
                ..plain
            }
        }
        Bsdf::Phong(phong) => {
            let (coefficients, scale) = (phong.coefficients(), phong.energy_scale());
            head::Material {
                base: rgb(coefficients.diffuse * scale),
                specular: rgb(coefficients.specular * scale),
                exponent: Some(coefficients.exponent),
                // The width of a microfacet lobe as sharp as cos^n.
                roughness: (2.0 / (coefficients.exponent + 2.0)).sqrt() as f32,
                ..plain
            }
        }
    })
}
