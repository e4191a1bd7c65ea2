//! Triangles of a description, close to its surfaces and without gaps between them.
//!
//! Every edge that surfaces share is sampled once, and all of them use these very points: edges of CAD models by their number
//! ([`TrimEdgeDescription`](crate::description::TrimEdgeDescription)), borders of untrimmed patches with equal control points, and the two
//! sides of a seam. A side of the parameters that is a point (a pole) is a single vertex.
//!
//! `patch` divides shapes into surfaces over a rectangle or a triangle of parameters. `shared_edge` samples edges, `outline` makes a
//! polygon of samples of the border of each patch, within the rectangle and with the patch on its left. `triangulation` fills it: a
//! constrained Delaunay triangulation of the parameters, to which points are added until it is as close to the surface as the settings
//! demand. `edge_network` and `group` bring the steps together for the shapes of a group.
//!
//! Triangle meshes are taken over as they are.

mod closed_sides;
mod closedness;
mod edge_network;
mod flat_triangles;
mod grid;
mod group;
mod outline;
mod outline_constraints;
mod patch;
mod patch_side;
mod patch_trim;
mod polygons;
mod progress;
mod shared_edge;
#[cfg(test)]
mod tests;
mod triangle_fit;
mod triangulation;
mod vertices;

use std::f64::consts::PI;

use glanz_job::Interrupted;
use glanz_math::DVec3;
use glanz_math::glam::DMat3;
use rayon::prelude::*;

use crate::description::{Description, InstanceDescription, Location};
use crate::placed_edges::stretch;

pub use progress::TessellationProgress;

/// How close triangles are to surfaces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TessellationSettings {
    /// Largest distance of a triangle from its surface and of a chord from its edge (chordal deviation), metres in the world.
    pub deviation: f64,
    /// Largest angle between the normals of the surface at the corners of a triangle, and between consecutive chords of an edge, radians. Triangles
    /// smaller than the deviation are not divided for it.
    pub angle: f64,
}

/// Error of a tessellation.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TessellationError {
    /// The deviation is not positive.
    #[error("the deviation is {0} m; it must be positive")]
    Deviation(f64),
    /// The angle is not positive, or larger than half a turn.
    #[error("the angle is {0} radians; it must be between 0 and pi")]
    Angle(f64),
    /// The end was requested.
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
}

/// The triangles of a description.
#[derive(Clone, Debug, Default)]
pub struct SceneTessellation {
    /// Those of each group.
    pub groups: Vec<GroupMesh>,
    /// Those of the world's own shapes.
    pub world: GroupMesh,
    /// Largest distance that was measured between a triangle and its surface, or a chord and its edge, metres in the world: at the middles of triangles
    /// and of their sides, and at points along edges.
    pub deviation: f64,
    /// Shapes that are left out, or not as the settings demand.
    pub faults: Vec<TessellationFault>,
}

/// The triangles of the shapes of a group, in its frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GroupMesh {
    /// Points, metres; shapes that share an edge share its points.
    pub positions: Vec<DVec3>,
    /// One mesh per shape of the group.
    pub shapes: Vec<ShapeMesh>,
}

/// The triangles of a shape.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ShapeMesh {
    /// Vertices.
    pub vertices: Vec<MeshVertex>,
    /// Triples of vertices, counterclockwise as seen from the front.
    pub triangles: Vec<[u32; 3]>,
}

/// A vertex of a shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshVertex {
    /// Index into [`GroupMesh::positions`].
    pub position: u32,
    /// Unit normal of the surface on its front.
    pub normal: DVec3,
}

/// A shape whose triangles are missing or not as the settings demand.
#[derive(Clone, Debug, PartialEq)]
pub struct TessellationFault {
    /// Index of the group; `None` for the world.
    pub group: Option<usize>,
    /// Index of the shape in its group.
    pub shape: usize,
    /// Its place in the input.
    pub location: Option<Location>,
    /// What is wrong.
    pub kind: TessellationFaultKind,
}

/// What is wrong with the triangles of a shape.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TessellationFaultKind {
    /// It has no parameters over which triangles could be made.
    #[error("{0} is left out: its triangles are not made yet")]
    Unsupported(&'static str),
    /// It is infinite.
    #[error("an infinite plane is left out")]
    Infinite,
    /// Its description is invalid.
    #[error("it is left out: {0}")]
    Invalid(String),
    /// Chords of its border cross each other.
    #[error("chords of its border cross each other; there may be a gap")]
    CrossingBorder,
    /// It has no more points: their number is limited.
    #[error("its triangles deviate by up to {deviation} m")]
    Coarse {
        /// Largest distance that is left, metres.
        deviation: f64,
    },
}

impl TessellationFaultKind {
    /// Whether the shape has no triangles.
    #[must_use]
    pub fn is_omission(&self) -> bool {
        matches!(self, Self::Unsupported(_) | Self::Infinite | Self::Invalid(_))
    }
}

impl SceneTessellation {
    /// Triangles of all shapes of a description, of each group once.
    ///
    /// # Errors
    /// [`TessellationError`] for a setting out of range, or if `progress` is cancelled.
    pub fn try_new(
        description: &Description,
        settings: TessellationSettings,
        progress: &TessellationProgress,
    ) -> Result<Self, TessellationError> {
        let TessellationSettings { deviation, angle } = settings;
        if deviation.is_nan() || deviation <= 0.0 {
            return Err(TessellationError::Deviation(deviation));
        }
        if angle.is_nan() || angle <= 0.0 || angle > PI {
            return Err(TessellationError::Angle(angle));
        }
        progress.start(description);
        let scales = scales(description);
        let numbers: Vec<Option<usize>> = (0..description.groups.len()).map(Some).chain([None]).collect();
        let meshes: Vec<group::GroupOutcome> = numbers
            .par_iter()
            .map(|&number| {
                let shapes = number.and_then(|n| description.groups.get(n)).unwrap_or(&description.world);
                let scale = number.and_then(|n| scales.get(n)).copied().unwrap_or(1.0);
                let settings = TessellationSettings { deviation: deviation / scale, angle };
                let mut outcome = group::mesh(&shapes.shapes, settings, progress);
                outcome.deviation *= scale;
                outcome
            })
            .collect();
        progress.cancel().check()?;
        let mut whole = Self::default();
        for (number, outcome) in numbers.into_iter().zip(meshes) {
            let shapes = number.and_then(|n| description.groups.get(n)).unwrap_or(&description.world);
            whole.deviation = whole.deviation.max(outcome.deviation);
            whole.faults.extend(outcome.faults.into_iter().map(|(shape, kind)| TessellationFault {
                group: number,
                shape,
                location: shapes.shapes.get(shape).and_then(|shape| shape.location),
                kind,
            }));
            match number {
                Some(_) => whole.groups.push(outcome.mesh),
                None => whole.world = outcome.mesh,
            }
        }
        Ok(whole)
    }

    /// Number of triangles, those of a group counted once.
    #[must_use]
    pub fn triangle_count(&self) -> usize {
        let shapes = self.groups.iter().chain([&self.world]).flat_map(|group| &group.shapes);
        shapes.map(|shape| shape.triangles.len()).sum()
    }
}

/// Bounds on the factor by which lengths of each group grow in the world; 1 where the world does not show it.
fn scales(description: &Description) -> Vec<f64> {
    let mut scales = vec![0.0_f64; description.groups.len()];
    place(&mut scales, &description.world.instances, 1.0);
    // Groups contain those before them only.
    for (number, group) in description.groups.iter().enumerate().rev() {
        let outer = scales.get(number).copied().unwrap_or(1.0);
        place(&mut scales, &group.instances, outer);
    }
    let valid = |scale: f64| if scale.is_finite() && scale > 0.0 { scale } else { 1.0 };
    scales.into_iter().map(valid).collect()
}

/// Takes the instances of a group that grows by `outer` into account.
fn place(scales: &mut [f64], instances: &[InstanceDescription], outer: f64) {
    for instance in instances {
        if let Some(scale) = scales.get_mut(instance.group) {
            *scale = scale.max(outer * stretch(DMat3::from_mat4(instance.to_parent)));
        }
    }
}
