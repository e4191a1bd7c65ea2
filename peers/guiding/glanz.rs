//! Exports a scene for other renderers; `compare.py` runs it and describes the comparison.
//!
//! Writes `scene.json` and one PLY file per material and light into the given folder: triangles in world space, with normals.
//! Features that renderers interpret differently are refused: only diffuse surfaces, checkerboards of two diffuse colours, mirrors,
//! and surfaces that emit on one side are exported.

mod shapes;

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufWriter, Write as _};
use std::path::Path;

use glanz_formats::{Options, load};
use glanz_light::SpectralDistribution;
use glanz_math::{DMat4, DVec2};
use glanz_scene::description::{
    CameraKind, Description, GroupDescription, MappingDescription, MaterialKind, ShapeDescription,
    SpectrumParameter, TextureKind,
};
use shapes::{Mesh, board, mesh};

type Failure = Box<dyn std::error::Error>;

/// Material and emission of a mesh, as JSON; each combination has a mesh of its own.
type Meshes = BTreeMap<String, Mesh>;

fn rgb(distribution: &SpectralDistribution) -> Result<[f32; 3], Failure> {
    match distribution {
        SpectralDistribution::Constant(value) => Ok([*value; 3]),
        SpectralDistribution::Rgb(rgb) => Ok(*rgb),
        _ => Err("a spectrum that is not three numbers".into()),
    }
}

fn constant(input: &SpectrumParameter) -> Result<[f32; 3], Failure> {
    match input {
        SpectrumParameter::Value(distribution) => rgb(distribution),
        SpectrumParameter::Texture(_) => Err("a texture where a colour is needed".into()),
    }
}

/// The two colours of a checkerboard over the whole patch, and its numbers of cells along u and v.
fn checkerboard(description: &Description, texture: usize) -> Result<([[f32; 3]; 2], [usize; 2]), Failure> {
    let TextureKind::Checkerboard { even, odd, mapping } = &description.textures[texture].kind else {
        return Err("a texture other than a checkerboard".into());
    };
    let MappingDescription::Uv { scale, offset } = mapping else {
        return Err("a checkerboard that is not over (u, v)".into());
    };
    if *offset != DVec2::ZERO || scale.fract() != DVec2::ZERO || scale.min_element() < 1.0 {
        return Err("a checkerboard with parts of fields".into());
    }
    Ok(([constant(even)?, constant(odd)?], [scale.x as usize, scale.y as usize]))
}

fn look(kind: &str, colour: [f32; 3], emission: Option<[f32; 3]>) -> String {
    let emission = emission.map_or_else(|| "null".to_owned(), |e| format!("{e:?}"));
    format!("\"kind\": \"{kind}\", \"colour\": {colour:?}, \"emission\": {emission}")
}

fn add_shape(
    description: &Description,
    shape: &ShapeDescription,
    to_world: &DMat4,
    meshes: &mut Meshes,
) -> Result<(), Failure> {
    if shape.trim.is_some() {
        return Err("a trimmed shape".into());
    }
    let emission = match &shape.emission {
        Some(light) if light.two_sided || light.power.is_some() => {
            return Err("a lamp that shines on both sides or by its power".into());
        }
        Some(light) => Some(rgb(&light.radiance)?.map(|x| x * light.scale)),
        None => None,
    };
    let to_world = *to_world * shape.to_parent;
    let mut put = |look: String, mesh: &Mesh| {
        meshes.entry(look).or_default().append(mesh, &to_world, shape.reverse_orientation);
    };
    match &description.materials[shape.material].kind {
        MaterialKind::Diffuse(diffuse) => match &diffuse.reflectance {
            SpectrumParameter::Texture(texture) => {
                let (colours, fields) = checkerboard(description, *texture)?;
                let (even, odd) = board(&shape.geometry, fields)?;
                put(look("diffuse", colours[0], emission), &even);
                put(look("diffuse", colours[1], emission), &odd);
            }
            reflectance => {
                put(look("diffuse", constant(reflectance)?, emission), &mesh(&shape.geometry)?);
            }
        },
        MaterialKind::Mirror(mirror) => {
            put(look("mirror", constant(&mirror.reflectance)?, emission), &mesh(&shape.geometry)?);
        }
        _ => return Err("a material other than diffuse and mirror".into()),
    }
    Ok(())
}

fn add_group(
    description: &Description,
    group: &GroupDescription,
    to_world: &DMat4,
    meshes: &mut Meshes,
) -> Result<(), Failure> {
    for shape in &group.shapes {
        add_shape(description, shape, to_world, meshes)
            .map_err(|e| format!("line {}: {e}", shape.location.map_or(0, |l| l.line)))?;
    }
    for instance in &group.instances {
        add_group(
            description,
            &description.groups[instance.group],
            &(*to_world * instance.to_parent),
            meshes,
        )?;
    }
    Ok(())
}

fn write_ply(path: &Path, mesh: &Mesh) -> Result<(), Failure> {
    let mut file = BufWriter::new(File::create(path)?);
    write!(file, "ply\nformat binary_little_endian 1.0\nelement vertex {}\n", mesh.positions.len())?;
    for name in ["x", "y", "z", "nx", "ny", "nz"] {
        writeln!(file, "property float {name}")?;
    }
    write!(
        file,
        "element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        mesh.triangles.len()
    )?;
    for (position, normal) in mesh.positions.iter().zip(&mesh.normals) {
        for x in position.to_array().into_iter().chain(normal.to_array()) {
            file.write_all(&(x as f32).to_le_bytes())?;
        }
    }
    for triangle in &mesh.triangles {
        file.write_all(&[3])?;
        for i in triangle {
            file.write_all(&i.to_le_bytes())?;
        }
    }
    Ok(file.flush()?)
}

fn main() -> Result<(), Failure> {
    let mut arguments = std::env::args().skip(1);
    let mut argument = || arguments.next().ok_or("usage: peer_guiding SCENE FOLDER");
    let (scene, folder) = (argument()?, argument()?);
    let folder = Path::new(&folder);
    let loaded = load(Path::new(&scene), &Options { strict: true, ..Options::default() })
        .map_err(|e| e.to_string())?;
    let description = loaded.description;
    if !description.lights.is_empty() {
        return Err("a light that is not a surface".into());
    }
    let camera = &description.camera;
    let CameraKind::Perspective { field_of_view } = camera.kind else {
        return Err("a camera without perspective".into());
    };
    if camera.lens_radius > 0.0 || camera.screen_window.is_some() || camera.aspect.is_some() {
        return Err("a camera with a lens or a window".into());
    }
    let mut meshes = Meshes::new();
    add_group(&description, &description.world, &DMat4::IDENTITY, &mut meshes)?;
    let mut file = BufWriter::new(File::create(folder.join("scene.json"))?);
    // pbrt's camera has x to the right; this is its frame, by columns.
    write!(file, "{{\n\"camera_to_world\": {:?},\n", camera.to_world.to_cols_array())?;
    writeln!(file, "\"field_of_view_degrees\": {},", field_of_view.to_degrees())?;
    write!(file, "\"max_depth\": {},\n\"meshes\": [", description.integrator.max_depth.unwrap_or(5))?;
    for (number, (look, mesh)) in meshes.iter().enumerate() {
        let name = format!("{number}.ply");
        write_ply(&folder.join(&name), mesh)?;
        let comma = if number > 0 { "," } else { "" };
        write!(file, "{comma}\n  {{\"file\": \"{name}\", \"triangles\": {}, {look}}}", mesh.triangles.len())?;
    }
    writeln!(file, "\n]\n}}")?;
    Ok(file.flush()?)
}
