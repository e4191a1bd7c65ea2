//! Wavefront OBJ with its materials.

use std::fmt::Write;

use glanz_math::{DVec3, Transform};

use super::{MeshMaterial, PlacedGroup, TessellatedError, TessellatedScene};

/// An OBJ file and the MTL file that it names.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjFiles {
    /// Positions, normals and triangles.
    pub obj: String,
    /// Materials.
    pub mtl: String,
    /// The name under which the OBJ file refers to them: without blanks, which separate names there.
    pub library: String,
}

/// The scene as an OBJ file; `library`: name of the MTL file. Copies of groups are objects of their own.
///
/// # Errors
/// [`TessellatedError`].
pub fn write_obj(scene: &TessellatedScene<'_>, library: &str) -> Result<ObjFiles, TessellatedError> {
    scene.counts()?;
    let (names, library) = (material_names(scene.materials), word(library));
    let mut obj = format!("# Glanz {}, metres\nmtllib {library}\n", env!("CARGO_PKG_VERSION"));
    let (mut positions, mut normals) = (1, 1);
    for (number, group) in scene.placed()?.iter().enumerate() {
        let name = if group.group.name.is_empty() { scene.name } else { &group.group.name };
        // Writing to a text cannot fail.
        let _ = writeln!(obj, "o {}.{}", word(name), number + 1);
        for &point in &group.mesh.positions {
            let [x, y, z] = group.position(point).to_array();
            let _ = writeln!(obj, "v {x} {y} {z}");
        }
        normals += add_shapes(&mut obj, group, &names, [positions, normals]);
        positions += group.mesh.positions.len();
    }
    let mut mtl = String::new();
    for (name, material) in names.iter().zip(scene.materials) {
        add_material(&mut mtl, name, material);
    }
    Ok(ObjFiles { obj, mtl, library })
}

/// Adds normals and triangles; the numbers of the group's first position and of its first normal are given. Returns the number of normals.
fn add_shapes(obj: &mut String, group: &PlacedGroup<'_>, names: &[String], first: [usize; 2]) -> usize {
    let transform = Transform::try_from_matrix(group.to_file).unwrap_or_default();
    let mut count = 0;
    let mut material = None;
    for (description, shape) in group.group.shapes.iter().zip(&group.mesh.shapes) {
        if material != Some(description.material) {
            material = Some(description.material);
            if let Some(name) = names.get(description.material) {
                let _ = writeln!(obj, "usemtl {name}");
            }
        }
        for vertex in &shape.vertices {
            let [x, y, z]: [f64; 3] = transform.normal(vertex.normal).normalize_or(DVec3::Z).into();
            let _ = writeln!(obj, "vn {} {} {}", x as f32, y as f32, z as f32);
        }
        for &corners in &shape.triangles {
            obj.push('f');
            for i in group.turned(corners) {
                let position = shape.vertices.get(i as usize).map_or(0, |vertex| vertex.position);
                let _ = write!(obj, " {}//{}", first[0] + position as usize, first[1] + count + i as usize);
            }
            obj.push('\n');
        }
        count += shape.vertices.len();
    }
    count
}

/// A name without blanks and control characters.
fn word(name: &str) -> String {
    let letter = |c: char| if c.is_whitespace() || c.is_control() || c == '#' { '_' } else { c };
    name.chars().map(letter).collect()
}

/// Names that differ.
fn material_names(materials: &[MeshMaterial]) -> Vec<String> {
    let name = |(number, material): (usize, &MeshMaterial)| {
        if material.name.is_empty() {
            format!("material.{}", number + 1)
        } else {
            format!("{}.{}", word(&material.name), number + 1)
        }
    };
    materials.iter().enumerate().map(name).collect()
}

/// The Phong model resembles a material; the physically based terms are those that Blender and others read.
fn add_material(mtl: &mut String, name: &str, material: &MeshMaterial) {
    let [r, g, b] = material.base;
    let MeshMaterial { metallic, roughness, transmission, .. } = *material;
    let specular = metallic.max(0.04);
    // Exponent of the highlight that resembles the roughness, as Blender converts it.
    let exponent = (1.0 - roughness) * (1.0 - roughness) * 1000.0;
    let _ = write!(
        mtl,
        "newmtl {name}\nKd {r} {g} {b}\nKs {specular} {specular} {specular}\nNs {exponent}\nd {}\n\
         Pm {metallic}\nPr {roughness}\nillum 2\n\n",
        1.0 - transmission,
    );
}
