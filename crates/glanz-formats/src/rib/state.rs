//! State that applies to the following surfaces: transformation, orientation and bases.

use glanz_math::{DMat4, DVec3};

/// Largest depth of nested blocks.
pub const MAX_DEPTH: usize = 1_000;

/// A part of the file between `...Begin` and `...End`.
#[derive(Clone, Copy, Debug)]
pub(super) struct RibBlock {
    /// Its directive, without `Begin`.
    pub(super) name: &'static str,
    /// Offset of its start.
    pub(super) at: usize,
    /// The state before it.
    pub(super) outside: RibState,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct RibState {
    pub(super) to_world: DMat4,
    /// Whether front and back of surfaces are exchanged.
    pub(super) reversed: bool,
    /// Along u and along v.
    pub(super) bases: [PatchBasis; 2],
}

impl Default for RibState {
    fn default() -> Self {
        let bezier = PatchBasis { to_bezier: None, step: 3 };
        Self { to_world: DMat4::IDENTITY, reversed: false, bases: [bezier; 2] }
    }
}

impl RibState {
    /// Multiplies the current transformation by one that is applied first to the following surfaces.
    pub(super) fn concatenate(&mut self, matrix: DMat4) {
        self.to_world *= matrix;
    }

    /// Whether patches must be reversed to preserve their front, because a reflection exchanges front and back.
    pub(super) fn turns(&self) -> bool {
        (self.to_world.determinant() < 0.0) != self.reversed
    }
}

/// A rotation about an axis by degrees; the identity without an axis.
pub(super) fn rotation(degrees: f64, axis: DVec3) -> DMat4 {
    axis.try_normalize().map_or(DMat4::IDENTITY, |axis| DMat4::from_axis_angle(axis, degrees.to_radians()))
}

/// Basis of a cubic, which defines the meaning of its four control points.
#[derive(Clone, Copy, Debug)]
pub(super) struct PatchBasis {
    /// Weights of the points for three times each Bézier point, by row, and a common divisor; `None` for
    /// Bézier points.
    to_bezier: Option<([[f64; 4]; 4], f64)>,
    /// Step in points from one patch of a mesh to the next.
    pub(super) step: usize,
}

/// Rows for the coefficients of t^3, t^2, t and 1, common divisor, step.
type BasisTable = (&'static str, [[f64; 4]; 4], f64, usize);

const BEZIER: [[f64; 4]; 4] =
    [[-1.0, 3.0, -3.0, 1.0], [3.0, -6.0, 3.0, 0.0], [-3.0, 3.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]];

const BASES: [BasisTable; 5] = [
    ("bezier", BEZIER, 1.0, 3),
    (
        "b-spline",
        [[-1.0, 3.0, -3.0, 1.0], [3.0, -6.0, 3.0, 0.0], [-3.0, 0.0, 3.0, 0.0], [1.0, 4.0, 1.0, 0.0]],
        6.0,
        1,
    ),
    (
        "catmull-rom",
        [[-1.0, 3.0, -3.0, 1.0], [2.0, -5.0, 4.0, -1.0], [-1.0, 0.0, 1.0, 0.0], [0.0, 2.0, 0.0, 0.0]],
        2.0,
        1,
    ),
    (
        "hermite",
        [[2.0, 1.0, -2.0, 1.0], [-3.0, -2.0, 3.0, -1.0], [0.0, 1.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]],
        1.0,
        2,
    ),
    (
        "power",
        [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]],
        1.0,
        4,
    ),
];

impl PatchBasis {
    /// The basis of this name, with its usual step.
    pub(super) fn by_name(name: &[u8]) -> Option<Self> {
        let (_, rows, divisor, step) = BASES.iter().find(|(known, ..)| known.as_bytes() == name)?;
        Some(Self::new(*rows, *divisor, *step))
    }

    /// The basis of a matrix: its rows are for t^3, t^2, t and 1, its columns for the points.
    pub(super) fn of_matrix(rows: [[f64; 4]; 4]) -> Self {
        Self::new(rows, 1.0, 3)
    }

    fn new(rows: [[f64; 4]; 4], divisor: f64, step: usize) -> Self {
        if rows == BEZIER {
            return Self { to_bezier: None, step };
        }
        // A polynomial with the coefficients a3, a2, a1, a0 has the Bézier points a0, a0 + a1 / 3,
        // a0 + 2 a1 / 3 + a2 / 3 and a0 + a1 + a2 + a3. Multiplied by three, the factors are integers, and adjacent patches have
        // the same bits along their common border.
        const OF_POWERS: [[f64; 4]; 4] =
            [[0.0, 0.0, 0.0, 3.0], [0.0, 0.0, 1.0, 3.0], [0.0, 1.0, 2.0, 3.0], [3.0, 3.0, 3.0, 3.0]];
        let entry = |i: usize, j: usize| (0..4).map(|k| OF_POWERS[i][k] * rows[k][j]).sum();
        let weights = std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)));
        Self { to_bezier: Some((weights, 3.0 * divisor)), step }
    }

    /// Converts four points of four numbers each to Bézier points.
    pub(super) fn to_bezier(self, points: [[f64; 4]; 4]) -> [[f64; 4]; 4] {
        let Some((weights, divisor)) = self.to_bezier else { return points };
        let sum = |i: usize, x: usize| (0..4).map(|j| weights[i][j] * points[j][x]).sum::<f64>();
        std::array::from_fn(|i| std::array::from_fn(|x| sum(i, x) / divisor))
    }
}

/// Accepted spellings of a basis.
pub(super) const BASIS_NAMES: &str =
    "sixteen numbers or \"bezier\", \"b-spline\", \"catmull-rom\", \"hermite\" or \"power\"";
