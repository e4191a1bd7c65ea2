//! The lights of the scene, reduced to a few simple ones.

use std::collections::HashMap;
use std::f64::consts::PI;

use glanz_geometry::FaceDomain;
use glanz_light::{Spectrum, Wavelengths};
use glanz_math::{Bounds3, DVec2, DVec3};
use glanz_scene::light::{AreaLight, PhotometricLight};
use glanz_scene::{Light, LightId, PlacedSurface, Scene};
use rayon::prelude::*;

use super::appearance::rgb;
use super::head;

/// Largest number of lights that are sent, besides the infinite one.
const MOST: usize = 32;

/// Number of samples on an emitting surface.
const PLACES: u32 = 4096;

/// A surface whose normals add up to this share of its area emits to one side.
const ONE_SIDED: f64 = 0.5;

/// A luminaire that sends less than this share of its light up emits to one side.
const UPWARDS: f64 = 0.1;

/// The brightest lights of the scene, and whether some were left out.
pub(super) fn lights(scene: &Scene, placed: &[PlacedSurface<'_>]) -> (Vec<head::ModelLight>, bool) {
    let wavelengths = Wavelengths::default();
    let bounds = scene.bounds();
    let radius = if bounds.is_empty() { 1.0 } else { 0.5 * bounds.diagonal().length() };
    let is_infinite = |light: &Light| matches!(light, Light::Infinite(_) | Light::ImageInfinite(_));
    let finite = (0..).map(LightId).zip(scene.lights()).filter(|(_, light)| !is_infinite(light));
    let mut by_power: Vec<(f32, LightId, &Light)> =
        finite.map(|(id, light)| (power(light, radius).mean(&wavelengths), id, light)).collect();
    by_power.sort_by(|a, b| b.0.total_cmp(&a.0));
    let surfaces = surfaces_of_lights(placed);
    let brightest = by_power.iter().take(MOST);
    let simple = brightest.filter_map(|&(_, id, light)| simple(light, surfaces.get(&id).copied(), bounds));
    let mut lights: Vec<head::ModelLight> = simple.map(|light| light.head(&wavelengths)).collect();
    lights.retain(emits);
    let everywhere: Spectrum = scene
        .lights()
        .iter()
        .map(|light| match light {
            Light::Infinite(light) => light.radiance(),
            Light::ImageInfinite(light) => light.mean_radiance(),
            _ => Spectrum::BLACK,
        })
        .sum();
    if !everywhere.is_black() {
        lights.push(Simple { kind: "infinite", ..Simple::of(everywhere) }.head(&wavelengths));
    }
    (lights, by_power.len() > MOST)
}

/// All lights that have a place, even if the page is not lit by them.
pub(super) fn placed_lights(scene: &Scene, placed: &[PlacedSurface<'_>]) -> Vec<head::ModelLight> {
    let wavelengths = Wavelengths::default();
    let surfaces = surfaces_of_lights(placed);
    let simple = scene.lights().par_iter().enumerate().filter_map(|(number, light)| {
        simple(light, surfaces.get(&LightId(number as u32)).copied(), scene.bounds())
    });
    let with_place = simple.filter(|light| light.kind != "distant");
    with_place.map(|light| light.head(&wavelengths)).filter(emits).collect()
}

/// The surface that emits each light of a surface; the first of its copies.
fn surfaces_of_lights<'a>(placed: &'a [PlacedSurface<'a>]) -> HashMap<LightId, &'a PlacedSurface<'a>> {
    let found = placed.iter().rev().filter_map(|surface| Some((surface.light()?, surface)));
    found.collect()
}

fn emits(light: &head::ModelLight) -> bool {
    light.intensity.iter().any(|&x| x > 0.0)
}

/// Power that a light emits into a scene of that radius, W; black if unknown.
fn power(light: &Light, radius: f64) -> Spectrum {
    match light {
        Light::Point(l) => l.power(),
        Light::Spot(l) => l.power(),
        Light::Projection(l) => l.power(),
        Light::Goniometric(l) => l.power(),
        Light::Photometric(l) => l.power(),
        Light::Rays(l) => l.power(),
        Light::Distant(l) => l.irradiance() * (PI * radius * radius) as f32,
        Light::Sun(l) => l.irradiance() * (PI * radius * radius) as f32,
        Light::PortalInfinite(l) => l.power(),
        Light::Area(l) => l.power(),
        _ => Spectrum::BLACK,
    }
}

/// The light in the form of a rasteriser; `None` for lights without a place or a direction. `surface`: that which emits it; `bounds`: those of the scene.
fn simple(light: &Light, surface: Option<&PlacedSurface<'_>>, bounds: Bounds3) -> Option<Simple> {
    Some(match light {
        Light::Point(l) => Simple { position: l.position(), range: l.range(), ..Simple::of(l.intensity()) },
        Light::Spot(l) => Simple {
            kind: "spot",
            position: l.position(),
            direction: l.axis(),
            cosines: [l.cos_inner(), l.cos_outer()],
            ..Simple::of(l.intensity(l.axis()))
        },
        Light::Projection(l) => {
            // The flux of the picture, evenly in a cone around it: 2 pi (1 - cos) sr.
            let solid_angle = 2.0 * PI * (1.0 - l.cos_corner());
            let intensity = l.power() * (1.0 / solid_angle) as f32;
            let cosines = [l.cos_corner(); 2];
            Simple {
                kind: "spot",
                position: l.position(),
                direction: l.axis(),
                cosines,
                ..Simple::of(intensity)
            }
        }
        Light::Goniometric(l) => {
            Simple { position: l.position(), ..Simple::of(l.power() * (0.25 / PI) as f32) }
        }
        Light::Photometric(l) => photometric(l),
        Light::Rays(l) => Simple { position: l.position(), ..Simple::of(l.power() * (0.25 / PI) as f32) },
        Light::Distant(l) => {
            Simple { kind: "distant", direction: -l.towards(), ..Simple::of(l.irradiance()) }
        }
        // Without the softness of its shadows.
        Light::Sun(l) => Simple { kind: "distant", direction: -l.towards(), ..Simple::of(l.irradiance()) },
        Light::Area(l) => area(l, surface?, bounds),
        _ => return None,
    })
}

/// A light of a rasteriser.
struct Simple {
    kind: &'static str,
    position: DVec3,
    direction: DVec3,
    intensity: Spectrum,
    /// Inner, outer.
    cosines: [f64; 2],
    range: Option<f64>,
}

impl Simple {
    fn of(intensity: Spectrum) -> Self {
        Self {
            kind: "point",
            position: DVec3::ZERO,
            direction: DVec3::Z,
            intensity,
            cosines: [0.0; 2],
            range: None,
        }
    }

    fn head(&self, wavelengths: &Wavelengths) -> head::ModelLight {
        let [cos_inner, cos_outer] = self.cosines;
        head::ModelLight {
            kind: self.kind,
            position: self.position.to_array(),
            direction: self.direction.to_array(),
            intensity: rgb(self.intensity, wavelengths),
            cos_inner,
            cos_outer,
            range: self.range,
        }
    }
}

/// A light with the flux of the luminaire: with a cosine distribution if it emits down only, else alike in all directions.
fn photometric(light: &PhotometricLight) -> Simple {
    let axis = light.axis();
    let (mut down, mut up) = (0.0, 0.0);
    // Directions spread evenly by the golden angle.
    const DIRECTIONS: u32 = 512;
    let frame = glanz_math::Frame::from_z(axis);
    for i in 0..DIRECTIONS {
        let (cos, turn) =
            (1.0 - 2.0 * (f64::from(i) + 0.5) / f64::from(DIRECTIONS), f64::from(i) * 2.399_963);
        let sin = (1.0 - cos * cos).sqrt();
        let direction = frame.to_world(DVec3::new(sin * turn.cos(), sin * turn.sin(), cos));
        let sum = if cos > 0.0 { &mut down } else { &mut up };
        *sum += f64::from(light.intensity(direction).max_component());
    }
    let position = light.center();
    if up < UPWARDS * (up + down) {
        // I cos over the half sphere is pi I.
        let intensity = light.power() * (1.0 / PI) as f32;
        Simple { kind: "area", position, direction: axis, ..Simple::of(intensity) }
    } else {
        Simple { position, ..Simple::of(light.power() * (0.25 / PI) as f32) }
    }
}

/// An emitting surface as one light in its middle.
fn area(light: &AreaLight, placed: &PlacedSurface<'_>, bounds: Bounds3) -> Simple {
    let (mut area, mut along, mut middle) = (0.0, DVec3::ZERO, DVec3::ZERO);
    let side = f64::from(PLACES / placed.faces().max(1)).sqrt().floor().clamp(1.0, 32.0);
    let mut add = |face: u32, uv: DVec2, share: f64| {
        let Some(found) = placed.at(face, uv, false) else { return };
        let element = found.area_element * share;
        area += element;
        along += found.at.point.normal * element;
        middle += found.at.point.position * element;
    };
    for face in 0..placed.faces() {
        match placed.face_domain(face) {
            FaceDomain::Square => {
                for (i, j) in (0..side as u32).flat_map(|i| (0..side as u32).map(move |j| (i, j))) {
                    let uv = DVec2::new(f64::from(i) + 0.5, f64::from(j) + 0.5) / side;
                    add(face, uv, 1.0 / (side * side));
                }
            }
            FaceDomain::Polygon(corners) => {
                let next = corners.iter().cycle().skip(1);
                let extent = 0.5 * corners.iter().zip(next).map(|(a, b)| a.perp_dot(*b)).sum::<f64>().abs();
                add(face, corners.iter().sum::<DVec2>() / corners.len().max(1) as f64, extent);
            }
        }
    }
    if !(area > 0.0 && area.is_finite()) {
        // No parameters: the area is unknown, and estimated from the bounds.
        let own = placed.bounds();
        let own = if own.is_finite() && !own.is_empty() { own } else { bounds };
        let quarter = 0.125 * own.surface_area();
        return Simple { position: own.center(), ..Simple::of(light.radiance() * quarter as f32) };
    }
    let position = middle / area;
    if !light.is_two_sided() && along.length() > ONE_SIDED * area {
        let intensity = light.radiance() * along.length() as f32;
        Simple { kind: "area", position, direction: along.normalize(), ..Simple::of(intensity) }
    } else {
        // pi L A over all directions.
        let sides = if light.is_two_sided() { 2.0 } else { 1.0 };
        Simple { position, ..Simple::of(light.radiance() * (0.25 * sides * area) as f32) }
    }
}
