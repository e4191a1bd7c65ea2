//! Rational Bézier patches as rows of numbers.

use glanz_geometry::bezier::TensorPatch;
use glanz_math::{Bounds3, DVec3};

use super::blocks::Blocks;
use super::error::{ModelError, number};

/// Set in the first word of a patch of which not all weights are 1.
const RATIONAL: u32 = 1 << 16;

/// A patch of a surface with the words of its row.
pub(super) struct PatchRow<'a> {
    pub(super) patch: &'a TensorPatch,
    /// Number of its face, as in hits.
    pub(super) number: u32,
    /// Words 4 to 11: its parameters on the surface.
    pub(super) words: Vec<f64>,
}

/// The rows of a surface's patches in the blocks.
pub(super) struct PatchRange {
    pub(super) first: usize,
    pub(super) count: usize,
    /// Middle of the control points, to which they are relative.
    pub(super) origin: DVec3,
}

impl PatchRange {
    /// Adds the patches of one surface. Weights are scaled by one factor for all, so that common borders stay bitwise equal.
    ///
    /// # Errors
    /// [`ModelError::TooMany`] control points.
    pub(super) fn add(blocks: &mut Blocks, faces: &[PatchRow<'_>]) -> Result<Self, ModelError> {
        let points = || faces.iter().flat_map(|face| face.patch.control_points());
        let bounds = Bounds3::from_points(points().map(|p| p.truncate() / p.w));
        let origin = if bounds.is_empty() { DVec3::ZERO } else { bounds.center() };
        let largest = points().fold(0.0_f64, |most, p| most.max(p.w));
        let first = blocks.patches.len();
        for face in faces {
            let control_points = face.patch.control_points();
            let (degree_u, degree_v) = face.patch.degrees();
            let plain = control_points.iter().all(|p| p.w == largest);
            let mut row = [0; 16];
            let words = [
                degree_u as u32 + 256 * degree_v as u32 + if plain { 0 } else { RATIONAL },
                number("control points", blocks.points.len())?,
                face.number,
                0,
            ];
            let parameters = face.words.iter().map(|&word| (word as f32).to_bits());
            row.iter_mut().zip(words.into_iter().chain(parameters)).for_each(|(slot, word)| *slot = word);
            blocks.patches.push(row);
            blocks.points.extend(control_points.iter().map(|p| {
                let relative = (p.truncate() - origin * p.w) / largest;
                relative.extend(p.w / largest).to_array().map(|x| x as f32)
            }));
        }
        Ok(Self { first, count: faces.len(), origin })
    }
}
