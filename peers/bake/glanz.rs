//! Glanz's side of the comparison of light maps; `compare.py` runs it and describes the comparison: SCENE LIGHT DENSITY RAYS POINTS ERROR SAMPLES
//!
//! Prints one JSON object: random points of the surfaces of SCENE with their irradiance by paths (of a relative standard error of ERROR, or
//! by SAMPLES paths), and the lamps, with whether each is a flat patch. LIGHT: the finished checkpoint of a bake with DENSITY and RAYS.

#![allow(clippy::print_stdout, reason = "a program of a comparison talks to it")]

#[allow(clippy::unwrap_used, reason = "shared with a test, which may fail")]
#[path = "../../crates/glanz-cli/tests/it/bake_points.rs"]
mod bake_points;

use std::error::Error;

use bake_points::{FLATNESS, PointSettings, luminance, reference_points};
use glanz::light::Wavelengths;
use glanz::math::{DVec2, DVec3};
use glanz::radiosity::bake::LightMaps;
use glanz::radiosity::elements::{ElementSettings, Elements};
use glanz::scene::Scene;
use serde_json::{Value, json};

/// Corners and radiance of the surfaces that emit light, and whether they are flat patches.
fn lamps(scene: &Scene) -> Vec<Value> {
    let surfaces = scene.placed_surfaces();
    let lamp = |surface: &glanz::scene::PlacedSurface<'_>| {
        surface.light()?;
        let corners = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y];
        let corners = corners.map(|uv| Some(surface.at(0, uv, false)?.at.point.position.to_array()));
        let middle = DVec2::splat(0.5);
        let sides = [false, true].map(|back| {
            let at = surface.at(0, middle, back)?.at;
            let radiance = scene.emitted(&at, at.wo).to_rgb(&Wavelengths::default());
            Some(json!({ "normal": at.wo.to_array(), "radiance": radiance }))
        });
        let normals = (0..25).filter_map(|i| {
            let uv = DVec2::new(f64::from(i % 5), f64::from(i / 5)) / 4.0;
            Some(surface.at(0, uv, false)?.at.wo)
        });
        let normals: Vec<DVec3> = normals.collect();
        let is_flat = surface.faces() == 1
            && normals.len() == 25
            && normals.iter().all(|normal| normal.cross(normals[0]).length() <= FLATNESS);
        Some(json!({ "corners": corners, "sides": sides, "flat": is_flat }))
    };
    surfaces.iter().filter_map(lamp).collect()
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [file, light, density, rays, count, error, samples] = arguments.as_slice() else {
        return Err("usage: bake SCENE LIGHT DENSITY RAYS POINTS ERROR SAMPLES".into());
    };
    let density: f64 = density.parse()?;
    let bake = glanz::open(file)?.bake().density(density).rays(rays.parse()?);
    let baked = bake.checkpoint(std::path::PathBuf::from(light)).resume(true).run()?;
    let settings =
        PointSettings { count: count.parse()?, error: error.parse()?, samples: samples.parse()?, density };
    let found = reference_points(baked.scene(), &baked.maps, &settings)?;
    // Only the surfaces of the elements matter for the lookup.
    let elements = Elements::new(baked.scene(), &ElementSettings { side: 1.0 })?;
    let maps = LightMaps::new(&elements, baked.maps.clone());
    let points = found.points.iter().map(|point| {
        json!({
            "position": point.position.to_array(),
            "normal": point.normal.to_array(),
            "kind": point.kind,
            "shape": point.shape,
            "curved": point.is_curved,
            "irradiance": point.irradiance,
            "deviation": point.deviation,
            "glanz": maps.irradiance(&point.place).map(luminance),
        })
    });
    let points: Vec<Value> = points.collect();
    println!("{}", json!({ "covered": found.covered, "points": points, "lamps": lamps(baked.scene()) }));
    Ok(())
}
