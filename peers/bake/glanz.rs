//! Glanz's side of the comparison of light maps; `compare.py` runs it and describes the comparison: SCENE LIGHT DENSITY RAYS POINTS ERROR SAMPLES
//! THREADS
//!
//! Prints one JSON object: random points of the surfaces of SCENE with their irradiance by paths (of a relative standard error of ERROR, or
//! by SAMPLES paths), the surfaces that emit light, with whether each is a flat patch, and the kinds of the lights that are no surfaces. LIGHT:
//! the finished checkpoint of a bake with DENSITY and RAYS. THREADS: 0 for all processors.

#![allow(clippy::print_stdout, reason = "a program of a comparison talks to it")]

#[allow(clippy::unwrap_used, reason = "shared with a test, which may fail")]
#[path = "../../crates/glanz-cli/tests/it/bake_points.rs"]
mod bake_points;

use std::collections::BTreeSet;
use std::error::Error;

use bake_points::{PointSettings, is_curved, luminance, reference_points};
use glanz::light::Wavelengths;
use glanz::math::DVec2;
use glanz::radiosity::bake::LightMaps;
use glanz::radiosity::elements::{ElementSettings, Elements};
use glanz::scene::{Light, PlacedSurface, Scene};
use serde_json::{Value, json};

/// The surfaces that emit light: the number of their shape, the radiance of both sides in the middle, and whether they are flat patches.
fn lamps(scene: &Scene) -> Vec<Value> {
    let surfaces = scene.placed_surfaces();
    let lamp = |surface: &PlacedSurface<'_>| {
        surface.light()?;
        let sides = [false, true].map(|back| {
            let at = surface.at(0, DVec2::splat(0.5), back)?.at;
            let radiance = scene.emitted(&at, at.wo).to_rgb(&Wavelengths::default());
            Some(json!({ "normal": at.wo.to_array(), "radiance": radiance }))
        });
        let is_flat = surface.faces() == 1
            && sides.iter().all(Option::is_some)
            && !is_curved(|uv| Some(surface.at(0, uv, false)?.at.wo));
        Some(json!({ "shape": surface.shape(0), "sides": sides, "flat": is_flat }))
    };
    surfaces.iter().filter_map(lamp).collect()
}

/// Kinds of the lights that are no surfaces, sorted.
fn other_lights(scene: &Scene) -> BTreeSet<&'static str> {
    let others = scene.lights().iter().filter(|light| !matches!(light, Light::Area(_)));
    others.map(Light::kind).collect()
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [file, light, density, rays, count, error, samples, threads] = arguments.as_slice() else {
        return Err("usage: bake SCENE LIGHT DENSITY RAYS POINTS ERROR SAMPLES THREADS".into());
    };
    let (density, threads): (f64, usize) = (density.parse()?, threads.parse()?);
    let bake = glanz::open(file)?.bake().density(density).rays(rays.parse()?).threads(threads);
    let baked = bake.checkpoint(std::path::PathBuf::from(light)).resume(true).run()?;
    let settings = PointSettings {
        count: count.parse()?,
        error: error.parse()?,
        samples: samples.parse()?,
        density,
        threads,
    };
    let reference = reference_points(baked.scene(), &baked.maps, &settings)?;
    // Only the surfaces of the elements matter for the lookup.
    let elements = Elements::new(baked.scene(), &ElementSettings { side: 1.0 })?;
    let maps = LightMaps::new(&elements, baked.maps.clone());
    let points = reference.points.iter().map(|point| {
        json!({
            "position": point.position.to_array(),
            "normal": point.normal.to_array(),
            "kind": point.kind,
            "shape": point.shape,
            "curved": point.is_curved,
            "lit": point.is_lit,
            "irradiance": point.irradiance,
            "deviation": point.deviation,
            "glanz": maps.irradiance(&point.place).map(luminance),
        })
    });
    let points: Vec<Value> = points.collect();
    let output = json!({
        "covered": reference.covered,
        "points": points,
        "lamps": lamps(baked.scene()),
        "other_lights": other_lights(baked.scene()),
    });
    println!("{output}");
    Ok(())
}
