//! Subdivision of triangular patches.

use super::net::{BlossomArgument, blossoms};
use super::triangle::{Barycentric, TrianglePatch};
use crate::error::SurfaceError;

impl TrianglePatch {
    /// Three parts that meet at a point, which replaces the first, second and third corner in turn.
    ///
    /// Repeated splitting does not converge to the surface, since the edges are never split: see [`TrianglePatch::quarters`].
    ///
    /// # Errors
    /// [`SurfaceError::NotPositive`] if a weight is no longer positive, which is possible for points outside the triangle.
    ///
    /// # Source
    /// @pumberger2010 algorithm 2.2.4.2; departure: the parts are all p^i_0jk with i + j + k = n, not only their borders.
    pub fn split_at(&self, at: Barycentric) -> Result<[Self; 3], SurfaceError> {
        let part = |replaced: usize| {
            let corners = [0, 1, 2]
                .map(|c| if c == replaced { BlossomArgument::At(at) } else { BlossomArgument::Corner(c) });
            Self::try_new(self.degree, self.part(corners).points)
        };
        Ok([part(0)?, part(1)?, part(2)?])
    }

    /// The four parts between the middles of the edges: at the first, second and third corner, then the middle one.
    ///
    /// All keep the orientation; the corners of the middle one are the middles of the edges opposite to the first, second and
    /// third corner. Inner borders have the same bits on both sides, and so have the borders of two patches that share the
    /// control points of an edge, in either direction.
    #[must_use]
    pub fn quarters(&self) -> [Self; 4] {
        let (ab, bc, ca) =
            (BlossomArgument::Middle(0, 1), BlossomArgument::Middle(1, 2), BlossomArgument::Middle(0, 2));
        [
            self.part([BlossomArgument::Corner(0), ab, ca]),
            self.part([ab, BlossomArgument::Corner(1), bc]),
            self.part([ca, bc, BlossomArgument::Corner(2)]),
            self.part([bc, ca, ab]),
        ]
    }

    /// The two parts on both sides of the line from the first corner to the middle of the edge r = 0: with the second, and with
    /// the third corner. Their common border has the same bits.
    #[must_use]
    pub fn halves(&self) -> [Self; 2] {
        let (a, middle) = (BlossomArgument::Corner(0), BlossomArgument::Middle(1, 2));
        [
            self.part([a, BlossomArgument::Corner(1), middle]),
            self.part([a, middle, BlossomArgument::Corner(2)]),
        ]
    }

    /// The part over a triangle in the parameter domain.
    ///
    /// # Errors
    /// [`SurfaceError::NotFinite`]; [`SurfaceError::NotPositive`] if a weight is no longer positive, which is possible for
    /// corners outside the triangle.
    pub fn sub_triangle(&self, corners: [Barycentric; 3]) -> Result<Self, SurfaceError> {
        Self::try_new(self.degree, self.part(corners.map(BlossomArgument::At)).points)
    }

    fn part(&self, corners: [BlossomArgument; 3]) -> Self {
        Self::from_means(self.degree, &self.points, blossoms(&self.points, self.degree, corners))
    }
}
