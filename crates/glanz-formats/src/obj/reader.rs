//! Reading of a file, statement by statement.

use std::collections::{BTreeMap, HashMap};

use glanz_job::ResourceBudget;
use glanz_math::{DVec2, DVec3};

use super::error::{ObjError, ObjErrorKind};
use super::faces::{self, MAX_CONCAVE};
use super::freeform::FreeformState;
use super::statement::{ObjWord, Statements};
use super::{ObjFile, ObjMesh, SkippedStatement};
use crate::growing_memory::GrowingReservation;
use crate::source::shortened;

/// Statements without an effect here.
const IGNORED: [&str; 12] = [
    "g",
    "s",
    "mg",
    "lod",
    "bevel",
    "c_interp",
    "d_interp",
    "shadow_obj",
    "trace_obj",
    "ctech",
    "stech",
    "con",
];

/// Numbers of position, texture coordinates and normal of a corner.
type Corner = (u32, Option<u32>, Option<u32>);

/// A mesh with the vertices that are known.
#[derive(Default)]
struct OpenMesh {
    mesh: ObjMesh,
    known: HashMap<Corner, u32>,
    has_normals: bool,
    has_uvs: bool,
}

/// State of the reader.
#[derive(Default)]
struct Reader {
    budget: ResourceBudget,
    file: ObjFile,
    /// Positions with their weights.
    positions: Vec<[f64; 4]>,
    uvs: Vec<DVec2>,
    normals: Vec<DVec3>,
    freeform: FreeformState,
    /// Number of the object, which separates meshes.
    object: usize,
    /// Number of the material of what follows.
    material: Option<usize>,
    /// Numbers of the names of materials.
    material_numbers: BTreeMap<String, usize>,
    meshes: Vec<OpenMesh>,
    by_material: BTreeMap<(usize, Option<usize>), usize>,
    has_colors: bool,
    /// Numbers of what is in all meshes and surfaces, and of the bytes of names.
    vertices: usize,
    triangles: usize,
    freeform_values: usize,
    names: usize,
    memory: GrowingReservation,
}

/// Reads the bytes of a file.
///
/// # Errors
/// [`ObjError`] with line and column.
pub fn read(bytes: &[u8]) -> Result<ObjFile, ObjError> {
    read_with(bytes, &ResourceBudget::default())
}

/// As [`read`] within a budget.
///
/// # Errors
/// [`ObjError`] with line and column.
pub fn read_with(bytes: &[u8], budget: &ResourceBudget) -> Result<ObjFile, ObjError> {
    let mut statements = Statements::new(bytes).within(budget);
    let (budget, memory) = (budget.clone(), GrowingReservation::new(budget));
    let freeform = FreeformState::new(bytes.len());
    let mut reader = Reader { budget, memory, freeform, ..Reader::default() };
    while statements.advance() {
        reader.check(&statements)?;
        reader.statement(&statements)?;
        reader.reserve(&statements, bytes.len())?;
    }
    reader.check(&statements)?;
    let Reader { mut file, meshes, .. } = reader;
    file.meshes = meshes.into_iter().map(OpenMesh::finish).collect();
    Ok(file)
}

impl Reader {
    fn check(&self, s: &Statements<'_>) -> Result<(), ObjError> {
        self.budget.check().map_err(|end| s.error(None, end.into()))
    }

    /// Reserves the memory of what was read so far of a file of `size` bytes: lists grow, and have a part of twice their length for a while.
    fn reserve(&mut self, s: &Statements<'_>, size: usize) -> Result<(), ObjError> {
        let points = size.saturating_sub(self.freeform.points_left());
        let lists: [(usize, u64); 9] = [
            (self.positions.len(), 96),
            (self.uvs.len(), 48),
            (self.normals.len(), 72),
            // Its entry in a table, too.
            (self.vertices, 300),
            (self.triangles, 36),
            (self.meshes.len(), 1000),
            (self.freeform_values + points, 100),
            (self.file.materials.len() + self.file.libraries.len(), 250),
            (self.names, 3),
        ];
        let bytes: u64 = lists.iter().map(|&(count, each)| each * count as u64).sum();
        self.memory.reach(bytes).map_err(|end| s.error(None, end.into()))
    }

    fn statement(&mut self, s: &Statements<'_>) -> Result<(), ObjError> {
        match s.keyword() {
            "v" => self.position(s)?,
            "vt" => self.uvs.push(s.numbers::<2>(1, 0.0)?.into()),
            "vn" => self.normals.push(s.numbers::<3>(3, 0.0)?.into()),
            "f" | "fo" => self.face(s)?,
            "o" => self.object += 1,
            "usemtl" => self.use_material(s.rest()),
            "mtllib" => {
                let name = s.rest();
                self.names += name.len();
                self.file.libraries.push(name);
            }
            ignored if IGNORED.contains(&ignored) => {}
            _ if self.freeform.statement(s, &self.positions, self.material, &mut self.file)? => {
                self.freeform_values += s.values().len();
            }
            other => self.skip(s, format!("statement {:?} is not read and skipped", shortened(other))),
        }
        Ok(())
    }

    fn skip(&mut self, s: &Statements<'_>, what: String) {
        SkippedStatement::add(&mut self.file.skipped, s.place(), what);
    }

    fn use_material(&mut self, name: String) {
        if name.is_empty() {
            self.material = None;
            return;
        }
        let next = self.file.materials.len();
        let number = *self.material_numbers.entry(name.clone()).or_insert(next);
        if number == next {
            self.names += name.len();
            self.file.materials.push(name);
        }
        self.material = Some(number);
    }

    fn position(&mut self, s: &Statements<'_>) -> Result<(), ObjError> {
        let [x, y, z, w] = s.numbers(3, 1.0)?;
        // Six numbers are a position and a colour.
        let is_colored = s.values().len() >= 6;
        if is_colored && !std::mem::replace(&mut self.has_colors, true) {
            self.skip(s, "colours of vertices are not available and left out".to_owned());
        }
        self.positions.push([x, y, z, if is_colored { 1.0 } else { w }]);
        Ok(())
    }

    fn face(&mut self, s: &Statements<'_>) -> Result<(), ObjError> {
        let words = s.at_least(3)?;
        let corners: Vec<Corner> = words.iter().map(|word| self.corner(s, word)).collect::<Result<_, _>>()?;
        let of_corner =
            |&(position, ..): &Corner| self.positions.get(position as usize).copied().unwrap_or_default();
        let points: Vec<DVec3> =
            corners.iter().map(of_corner).map(|[x, y, z, _]| DVec3::new(x, y, z)).collect();
        if points.len() > MAX_CONCAVE {
            let what = format!("a polygon of {} corners is divided as a convex one", points.len());
            self.skip(s, what);
        }
        let triangles = faces::triangles(&points);
        let next = self.meshes.len();
        let index = *self.by_material.entry((self.object, self.material)).or_insert(next);
        if index == next {
            let mesh = ObjMesh { material: self.material, ..ObjMesh::default() };
            self.meshes.push(OpenMesh { mesh, ..OpenMesh::default() });
        }
        let Some(open) = self.meshes.get_mut(index) else { return Ok(()) };
        self.triangles += triangles.len();
        let before = open.mesh.positions.len();
        let mut vertices = Vec::with_capacity(corners.len());
        for (corner, point) in corners.into_iter().zip(points) {
            let vertex = open.vertex(corner, point, &self.uvs, &self.normals);
            vertices.push(vertex.ok_or_else(|| s.error(None, ObjErrorKind::TooMany))?);
        }
        open.mesh.triangles.extend(triangles.into_iter().map(|t| t.map(|i| vertices[i])));
        self.vertices += open.mesh.positions.len() - before;
        Ok(())
    }

    /// A corner: numbers separated by slashes.
    fn corner(&self, s: &Statements<'_>, word: &ObjWord<'_>) -> Result<Corner, ObjError> {
        self.check(s)?;
        let mut parts = word.text.split('/');
        let counts = [
            ("vertex", self.positions.len()),
            ("texture vertex", self.uvs.len()),
            ("normal", self.normals.len()),
        ];
        let mut found = [None; 3];
        for (number, (what, count)) in found.iter_mut().zip(counts) {
            *number = match parts.next() {
                Some("") | None => None,
                Some(text) => Some(u32::try_from(s.index(word, text, what, count)?).unwrap_or(u32::MAX)),
            };
        }
        match (found, parts.next()) {
            ([Some(position), uv, normal], None) => Ok((position, uv, normal)),
            _ => Err(s.error(Some(word), ObjErrorKind::Corner(shortened(word.text)))),
        }
    }
}

impl OpenMesh {
    /// The vertex of a corner, which is added if it is new; `None` if there are too many.
    fn vertex(&mut self, corner: Corner, point: DVec3, uvs: &[DVec2], normals: &[DVec3]) -> Option<u32> {
        let next = u32::try_from(self.mesh.positions.len()).ok()?;
        let vertex = *self.known.entry(corner).or_insert(next);
        if vertex == next {
            let (_, uv, normal) = corner;
            self.mesh.positions.push(point);
            let uv = uv.and_then(|uv| uvs.get(uv as usize));
            let normal = normal.and_then(|normal| normals.get(normal as usize));
            self.has_uvs |= uv.is_some();
            self.has_normals |= normal.is_some();
            self.mesh.uvs.get_or_insert_default().push(uv.copied().unwrap_or_default());
            self.mesh.normals.get_or_insert_default().push(normal.copied().unwrap_or_default());
        }
        Some(vertex)
    }

    fn finish(self) -> ObjMesh {
        let Self { mut mesh, has_normals, has_uvs, .. } = self;
        mesh.normals = mesh.normals.filter(|_| has_normals);
        mesh.uvs = mesh.uvs.filter(|_| has_uvs);
        mesh
    }
}
