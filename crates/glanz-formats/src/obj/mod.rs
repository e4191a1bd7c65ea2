//! Polygons and freeform surfaces in Wavefront OBJ files, and their materials in MTL files (@obj1995).
//!
//! Read are `v`, `vt`, `vn`, `vp`, `f`, `o`, `usemtl`, `mtllib`, and of freeform geometry `cstype bezier|bspline [rat]`, `deg`, `surf`, `curv2`,
//! `parm`, `trim`, `hole` and `end`; groups, smoothing groups and statements for displays are ignored, others are listed. A line that ends with `\`
//! continues on the next one. Polygons may be concave. `statement` divides a file into lines, `faces` makes triangles of polygons, `freeform` surfaces of
//! statements, `material` reads materials, and `lowering` makes a description of both files.

mod error;
mod faces;
mod freeform;
mod lowering;
mod material;
mod reader;
mod statement;
#[cfg(test)]
mod tests;

use glanz_math::{DVec2, DVec3};
use glanz_scene::description::{NurbsDescription, TrimDescription};

pub use error::{ObjError, ObjErrorKind};
pub(crate) use lowering::read_into;
pub use material::{ObjMaterial, ObjMaterials, ObjPicture, read_materials, read_materials_with};
pub use reader::{read, read_with};
pub(crate) use statement::is_obj;

/// The contents of a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ObjFile {
    /// Names of files of materials: each the rest of a line.
    pub libraries: Vec<String>,
    /// Names of materials, each once.
    pub materials: Vec<String>,
    /// Triangles, by object and material.
    pub meshes: Vec<ObjMesh>,
    /// Freeform surfaces.
    pub surfaces: Vec<ObjSurface>,
    /// What was left out: the first place of each kind, up to 100 kinds.
    pub skipped: Vec<SkippedStatement>,
}

/// Triangles with one material.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ObjMesh {
    /// Number of the material in the list of names, if it has one.
    pub material: Option<usize>,
    /// Vertices.
    pub positions: Vec<DVec3>,
    /// One per vertex; zero where the file has none. `None`: it has none at all.
    pub normals: Option<Vec<DVec3>>,
    /// One per vertex, (0, 0) the lower left corner of a picture; zero where the file has none. `None`: it has none at all.
    pub uvs: Option<Vec<DVec2>>,
    /// Corners of the triangles, counterclockwise seen from the front.
    pub triangles: Vec<[u32; 3]>,
}

/// A freeform surface with a material.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjSurface {
    /// Number of the material in the list of names, if it has one.
    pub material: Option<usize>,
    /// The surface.
    pub surface: NurbsDescription,
    /// The part that is kept.
    pub trim: Option<TrimDescription>,
}

/// A part of a file that was left out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SkippedStatement {
    /// What it is, and why.
    pub what: String,
    /// Line, from 1.
    pub line: u32,
    /// Column in bytes, from 1.
    pub column: u32,
}

/// Largest number of different messages about parts that were left out.
const MAX_SKIPPED: usize = 100;

impl SkippedStatement {
    /// Adds a message, once for all places with the same.
    fn add(skipped: &mut Vec<Self>, (line, column): (u32, u32), what: String) {
        if skipped.len() < MAX_SKIPPED && skipped.iter().all(|other| other.what != what) {
            skipped.push(Self { what, line, column });
        }
    }
}
