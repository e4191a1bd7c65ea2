//! Parts of triangular patches.

use super::net::{Step, blossoms};
use super::triangle::{Barycentric, TrianglePatch};
use crate::error::SurfaceError;

impl TrianglePatch {
    /// Three parts that meet at a point, in the place of the first, second and third corner in this order.
    ///
    /// Repeated, this does not approach the surface, since the edges are never cut: see [`TrianglePatch::quarters`].
    ///
    /// # Errors
    /// [`SurfaceError::NotPositive`] if a weight becomes so, which takes a point outside.
    ///
    /// # Source
    /// @pumberger2010 algorithm 2.2.4.2; departure: the parts are all p^i_0jk with i + j + k = n and not their borders
    /// only.
    pub fn split_at(&self, at: Barycentric) -> Result<[Self; 3], SurfaceError> {
        let part = |new: usize| {
            let steps = [0, 1, 2].map(|c| if c == new { Step::At(at) } else { Step::Corner(c) });
            Self::try_new(self.degree, self.part(steps).points)
        };
        Ok([part(0)?, part(1)?, part(2)?])
    }

    /// The four parts that the middles of the edges cut off: at the first, second and third corner, then the middle one.
    ///
    /// All are turned as the patch is; the middle one's corners are the middles of the edges opposite to the first,
    /// second and third corner. Borders inside have the same bits on both sides, and so have the borders of two
    /// patches that share the control points of an edge, whatever way it is run in.
    #[must_use]
    pub fn quarters(&self) -> [Self; 4] {
        let (ab, bc, ca) = (Step::Middle(0, 1), Step::Middle(1, 2), Step::Middle(0, 2));
        [
            self.part([Step::Corner(0), ab, ca]),
            self.part([ab, Step::Corner(1), bc]),
            self.part([ca, bc, Step::Corner(2)]),
            self.part([bc, ca, ab]),
        ]
    }

    /// The two parts on the sides of the line from the first corner to the middle of the edge r = 0, with the second
    /// and with the third corner. The border of both has the same bits.
    #[must_use]
    pub fn halves(&self) -> [Self; 2] {
        let (a, middle) = (Step::Corner(0), Step::Middle(1, 2));
        [self.part([a, Step::Corner(1), middle]), self.part([a, middle, Step::Corner(2)])]
    }

    /// The part over a triangle in the parameter domain.
    ///
    /// # Errors
    /// [`SurfaceError::NotFinite`]; [`SurfaceError::NotPositive`] if a weight becomes so, which takes a corner outside.
    pub fn sub_triangle(&self, corners: [Barycentric; 3]) -> Result<Self, SurfaceError> {
        Self::try_new(self.degree, self.part(corners.map(Step::At)).points)
    }

    fn part(&self, steps: [Step; 3]) -> Self {
        Self::of_means(self.degree, &self.points, blossoms(&self.points, self.degree, steps))
    }
}
