//! Glanz's side of the comparison of viewers; `compare.js` runs it and describes the comparison: SCENE FOLDER TOLERANCE
//!
//! Writes the model of the page (`model`), and a tessellation of the same surfaces as other viewers create it on loading: triangles
//! within TOLERANCE metres, with the surfaces' normals at their vertices (`mesh`: positions, normals, triples of vertices, little-endian
//! in 32 bits). Prints the numbers of vertices and triangles, and the triangles of each object, as a line of JSON. Untrimmed patches
//! have the smallest number of cells within the tolerance, other surfaces are divided as for light maps.

#![allow(clippy::print_stdout, reason = "a program of a comparison talks to it")]

#[path = "../freeform/tessellate.rs"]
mod tessellate;

use std::error::Error;
use std::fs::File;
use std::io::{BufWriter, Write as _};
use std::path::Path;

use glanz::formats::{Options, load};
use glanz::geometry::Surface;
use glanz::math::{DVec2, DVec3};
use glanz::radiosity::charts::charts;
use glanz::radiosity::tessellate as radiosity;
use glanz::scene::{ParametricPoint, PlacedSurface, Scene};
use glanz::viewer::model::Model;
use serde_json::json;
use tessellate::{Deviation, Mesh, fewest_cells};

/// Texels per metre of charts, which are not used here.
const DENSITY: f64 = 1.0;

/// Triangles and their objects.
struct Part {
    object: Option<u32>,
    mesh: Mesh,
}

/// The triangles of untrimmed patches; `None` for other surfaces.
fn of_patches(placed: &PlacedSurface<'_>, tolerance: f64) -> Option<Mesh> {
    let Surface::Freeform(freeform) = placed.surface() else { return None };
    if freeform.is_trimmed() {
        return None;
    }
    // Normals are those of the surface, so that the angles of triangles do not matter.
    let bounds = Deviation { chord: tolerance, normal: f64::INFINITY, facet: f64::INFINITY };
    let pieces: Vec<_> = freeform.patches().collect();
    let cells: Vec<_> = pieces.iter().map(|piece| fewest_cells(piece.patch(), &bounds)).collect();
    let mut mesh = tessellate::tessellate(&pieces, &cells, None);
    let to_world = placed.to_world();
    let wide = |v: &[f32; 3]| DVec3::from(v.map(f64::from));
    for position in &mut mesh.positions {
        *position = to_world.point(wide(position)).as_vec3().to_array();
    }
    for normal in &mut mesh.normals {
        *normal = to_world.normal(wide(normal)).normalize_or_zero().as_vec3().to_array();
    }
    // Viewers determine the side by the order of corners, which has no meaning in these triangles.
    let Mesh { positions, normals, triangles } = &mut mesh;
    for corners in triangles {
        let [a, b, c] = corners.map(|i| wide(&positions[i as usize]));
        let normal: DVec3 = corners.iter().map(|&i| wide(&normals[i as usize])).sum();
        if (b - a).cross(c - a).dot(normal) < 0.0 {
            corners.swap(1, 2);
        }
    }
    Some(mesh)
}

fn parts(scene: &Scene, model: &Model, tolerance: f64) -> Vec<Part> {
    let surfaces = scene.placed_surfaces();
    let object =
        |surface| model.object_of(&ParametricPoint { surface, face: 0, back: false, uv: DVec2::splat(0.5) });
    let mut parts = Vec::new();
    let mut others = Vec::new();
    for (number, placed) in (0..).zip(&surfaces) {
        match of_patches(placed, tolerance) {
            Some(mesh) => parts.push(Part { object: object(number), mesh }),
            None => others.push(number),
        }
    }
    // Charts of many patches would take long.
    let rest: Vec<_> = others.iter().filter_map(|&number| surfaces.get(number as usize).cloned()).collect();
    for chart in charts(&rest, DENSITY).iter().filter(|chart| !chart.back) {
        let surface = &rest[chart.surface as usize];
        let triangles =
            radiosity::tessellate(surface, chart, radiosity::divisions(surface, tolerance), tolerance);
        let narrow = |v: &DVec3| v.as_vec3().to_array();
        let mesh = Mesh {
            positions: triangles.positions.iter().map(narrow).collect(),
            normals: triangles.normals.iter().map(narrow).collect(),
            triangles: triangles.indices,
        };
        parts.push(Part { object: object(others[chart.surface as usize]), mesh });
    }
    parts
}

fn write(path: &Path, parts: &[Part]) -> std::io::Result<()> {
    let mut file = BufWriter::new(File::create(path)?);
    let all = || parts.iter().map(|part| &part.mesh);
    let positions = all().flat_map(|mesh| mesh.positions.as_flattened());
    for x in positions.chain(all().flat_map(|mesh| mesh.normals.as_flattened())) {
        file.write_all(&x.to_le_bytes())?;
    }
    let mut first = 0;
    for mesh in all() {
        for i in mesh.triangles.as_flattened() {
            file.write_all(&(first + i).to_le_bytes())?;
        }
        first += mesh.positions.len() as u32;
    }
    file.flush()
}

fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [file, folder, tolerance] = words.as_slice() else {
        return Err("SCENE FOLDER TOLERANCE".into());
    };
    let (file, folder) = (Path::new(file), Path::new(folder));
    let description = load(file, &Options::default()).map_err(|error| error.to_string())?.description;
    let (scene, _) = Scene::resolve(description.clone())?;
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    let model = Model::try_new(&name, &description, &scene, &[])?;
    std::fs::write(folder.join("model"), model.to_bytes()?)?;
    let parts = parts(&scene, &model, tolerance.parse()?);
    write(&folder.join("mesh"), &parts)?;
    let objects =
        parts.iter().map(|part| json!({ "object": part.object, "triangles": part.mesh.triangles.len() }));
    let about = json!({
        "vertices": parts.iter().map(|part| part.mesh.positions.len()).sum::<usize>(),
        "triangles": parts.iter().map(|part| part.mesh.triangles.len()).sum::<usize>(),
        "parts": objects.collect::<Vec<_>>(),
    });
    println!("{about}");
    Ok(())
}
