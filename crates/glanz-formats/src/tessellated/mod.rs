//! Tessellated scenes as files: PLY, Wavefront OBJ, binary glTF.
//!
//! Shapes of a group that share an edge share the vertices on it, which PLY and OBJ keep. In glTF a vertex has one normal, so that vertices on
//! sharp edges are written once for each shape, with the same bits.

mod obj;
mod ply;
mod scene;
#[cfg(test)]
mod tests;

use glanz_math::{DMat4, DVec3};
use glanz_scene::Description;
use glanz_scene::description::GroupDescription;
use glanz_scene::tessellation::{GroupMesh, SceneTessellation};

pub use obj::{ObjFiles, write_obj};
pub use ply::write_ply;
pub use scene::write_glb;

/// A description with its triangles.
#[derive(Clone, Copy, Debug)]
pub struct TessellatedScene<'a> {
    /// The name of the scene.
    pub name: &'a str,
    /// Groups, instances and materials of shapes.
    pub description: &'a Description,
    /// The triangles of its groups.
    pub tessellation: &'a SceneTessellation,
    /// For each material of the description.
    pub materials: &'a [MeshMaterial],
    /// From the world of the description to that of the file.
    pub to_file: DMat4,
}

/// A material of a mesh: metallic and roughness as in glTF 2.0.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshMaterial {
    /// Its name; may be empty.
    pub name: String,
    /// Base colour, linear Rec. 709, [0, 1].
    pub base: [f32; 3],
    /// 1 for a metal, else 0.
    pub metallic: f32,
    /// 0 for a mirror, 1 for a diffuse surface.
    pub roughness: f32,
    /// Fraction of light that passes, [0, 1].
    pub transmission: f32,
}

/// Errors of writing triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum TessellatedError {
    /// Instances of instances are too many to write them all.
    #[error("the scene has more than {0} instances of groups, which this format cannot share")]
    Instances(usize),
    /// More than the format can hold.
    #[error("the scene has more vertices or bytes than this format can hold")]
    Size,
    /// Copies of groups would make a file that is too large.
    #[error(
        "the scene has {triangles} triangles with those of all instances, which this format cannot share; at most {MAX_TRIANGLES} \
         are written: choose .glb, or a larger tolerance"
    )]
    Triangles {
        /// Number of triangles, those of instances counted each.
        triangles: usize,
    },
}

/// Largest number of instances, each of which is written.
const MAX_INSTANCES: usize = 1 << 20;

/// Largest number of triangles of a file that repeats them for each instance.
const MAX_TRIANGLES: usize = 1 << 27;

/// A copy of a group in the file.
struct PlacedGroup<'a> {
    group: &'a GroupDescription,
    mesh: &'a GroupMesh,
    to_file: DMat4,
}

impl<'a> TessellatedScene<'a> {
    fn group(&self, number: Option<usize>) -> Option<(&'a GroupDescription, &'a GroupMesh)> {
        match number {
            Some(number) => {
                Some((self.description.groups.get(number)?, self.tessellation.groups.get(number)?))
            }
            None => Some((&self.description.world, &self.tessellation.world)),
        }
    }

    /// All copies of groups with shapes, in the order of the description.
    fn placed(&self) -> Result<Vec<PlacedGroup<'a>>, TessellatedError> {
        let mut placed = Vec::new();
        let mut waiting = vec![(None, self.to_file)];
        let mut count = 0;
        while let Some((number, to_file)) = waiting.pop() {
            count += 1;
            if count > MAX_INSTANCES {
                return Err(TessellatedError::Instances(MAX_INSTANCES));
            }
            let Some((group, mesh)) = self.group(number) else { continue };
            if mesh.shapes.iter().any(|shape| !shape.triangles.is_empty()) {
                placed.push(PlacedGroup { group, mesh, to_file });
            }
            // Groups refer to those before them only, so that this ends.
            let inner = group.instances.iter().rev();
            let inner = inner.filter(|instance| number.is_none_or(|number| instance.group < number));
            waiting.extend(inner.map(|instance| (Some(instance.group), to_file * instance.to_parent)));
        }
        Ok(placed)
    }

    /// Numbers of vertices and triangles of the file, instances counted each.
    ///
    /// # Errors
    /// [`TessellatedError::Instances`], and [`TessellatedError::Triangles`] if they are more than a file can repeat.
    pub fn counts(&self) -> Result<[usize; 2], TessellatedError> {
        let placed = self.placed()?;
        let triangles =
            |mesh: &GroupMesh| mesh.shapes.iter().map(|shape| shape.triangles.len()).sum::<usize>();
        let vertices = placed.iter().map(|placed| placed.mesh.positions.len()).sum();
        let triangles = placed.iter().map(|placed| triangles(placed.mesh)).sum();
        if triangles > MAX_TRIANGLES {
            return Err(TessellatedError::Triangles { triangles });
        }
        Ok([vertices, triangles])
    }
}

impl PlacedGroup<'_> {
    fn position(&self, point: DVec3) -> DVec3 {
        self.to_file.transform_point3(point)
    }

    /// Whether triangles change their sense.
    fn is_mirrored(&self) -> bool {
        self.to_file.determinant() < 0.0
    }

    /// Corners in the sense that has the front on its left.
    fn turned(&self, [a, b, c]: [u32; 3]) -> [u32; 3] {
        if self.is_mirrored() { [a, c, b] } else { [a, b, c] }
    }
}
