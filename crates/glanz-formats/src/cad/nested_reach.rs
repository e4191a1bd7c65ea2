//! Limits of transformations inside one another.

use glanz_brep::model::{EntityId, Part};
use glanz_math::DMat4;

use super::refusal::Refusal;

/// Largest entry of a transformation, metres or a factor: beyond, a scene has no coordinates. Lengths may shrink by as much.
const FARTHEST: f64 = 1e12;

/// A transformation, unless it goes beyond the coordinates of a scene.
pub(crate) fn bounded(entity: EntityId, matrix: DMat4) -> Result<DMat4, Refusal> {
    if matrix.to_cols_array().iter().any(|entry| entry.abs() > FARTHEST) {
        let reason = format!("the transformation has an entry of more than {FARTHEST:e}");
        return Err(Refusal::new(entity, reason));
    }
    Ok(matrix)
}

/// A transformation, if it is finite, has an inverse, and does not go beyond the coordinates of a scene.
pub(crate) fn invertible(entity: EntityId, matrix: DMat4) -> Result<DMat4, Refusal> {
    let matrix = bounded(entity, matrix)?;
    if matrix.is_finite() && matrix.determinant().is_normal() && matrix.inverse().is_finite() {
        Ok(matrix)
    } else {
        Err(Refusal::new(entity, "the transformation is not finite or has no inverse"))
    }
}

/// How far transformations inside one another take what they place.
#[derive(Clone, Copy, Debug)]
struct NestedReach {
    /// Smallest and largest factor by which lengths grow.
    scales: [f64; 2],
    /// Largest distance of the origin of a frame, metres.
    distance: f64,
}

impl NestedReach {
    /// That of bodies, which no transformation places.
    const UNPLACED: Self = Self { scales: [1.0; 2], distance: 0.0 };

    /// That of what another transformation places.
    fn placed(self, matrix: &DMat4) -> Self {
        let axes = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(|axis| axis.truncate().length());
        let (smallest, largest) =
            (axes.into_iter().fold(f64::INFINITY, f64::min), axes.into_iter().fold(0.0, f64::max));
        let distance = matrix.w_axis.truncate().length() + largest * self.distance;
        Self { scales: [smallest * self.scales[0], largest * self.scales[1]], distance }
    }

    /// That of both.
    fn with(self, other: Self) -> Self {
        let [smallest, largest] = self.scales;
        let scales = [smallest.min(other.scales[0]), largest.max(other.scales[1])];
        Self { scales, distance: self.distance.max(other.distance) }
    }
}

/// How far the transformations inside of parts take what is in them, by the index of the part.
#[derive(Debug, Default)]
pub(crate) struct PartReaches(Vec<NestedReach>);

impl PartReaches {
    /// Adds the next part of a model.
    pub(crate) fn push(&mut self, part: &Part) {
        let reaches = part.occurrences.iter().map(|inner| self.placed(inner.part, &inner.to_parent));
        let reach = reaches.fold(NestedReach::UNPLACED, NestedReach::with);
        self.0.push(reach);
    }

    fn placed(&self, part: usize, to_parent: &DMat4) -> NestedReach {
        self.0.get(part).copied().unwrap_or(NestedReach::UNPLACED).placed(to_parent)
    }

    /// Refuses a transformation of a part that takes what is in it out of the reach of a scene.
    ///
    /// # Errors
    /// What is in the part would be too far away, or too small.
    pub(crate) fn check(&self, entity: EntityId, part: usize, to_parent: &DMat4) -> Result<(), Refusal> {
        let NestedReach { scales: [smallest, largest], distance } = self.placed(part, to_parent);
        if largest.max(distance) > FARTHEST {
            let reason = "with those inside, the transformation goes beyond the coordinates of a scene";
            return Err(Refusal::new(entity, reason));
        }
        if smallest < FARTHEST.recip() {
            let least = FARTHEST.recip();
            let reason = format!(
                "with those inside, the transformation shrinks lengths to less than {least:e} of them"
            );
            return Err(Refusal::new(entity, reason));
        }
        Ok(())
    }
}
