//! Tables of functions that have no closed form.

use super::clamp_unit;

/// Values of a function on a grid over the unit cube, interpolated linearly along each axis.
#[derive(Clone, Debug)]
pub(super) struct InterpolationTable<const N: usize> {
    /// Nodes per axis, at least 2; the last axis is contiguous.
    nodes: [usize; N],
    values: Vec<f32>,
}

impl<const N: usize> InterpolationTable<N> {
    /// Tabulates `function`, which takes a point of the unit cube, at `nodes` nodes per axis (at least 2).
    pub(super) fn new(nodes: [usize; N], function: impl Fn([f64; N]) -> f64) -> Self {
        let nodes = nodes.map(|n| n.max(2));
        let value = |index: usize| {
            let (mut rest, mut point) = (index, [0.0; N]);
            for (x, n) in point.iter_mut().zip(nodes).rev() {
                *x = (rest % n) as f64 / (n - 1) as f64;
                rest /= n;
            }
            function(point) as f32
        };
        Self { nodes, values: (0..nodes.iter().product()).map(value).collect() }
    }

    /// The value at a point, which is clamped to the unit cube; NaN counts as 0.
    pub(super) fn at(&self, point: [f64; N]) -> f64 {
        let (mut first, mut steps, mut fractions) = (0, [0; N], [0.0; N]);
        for axis in 0..N {
            let n = self.nodes[axis];
            let x = clamp_unit(point[axis]) * (n - 1) as f64;
            let below = (x as usize).min(n - 2);
            first = first * n + below;
            fractions[axis] = x - below as f64;
            steps[axis] = self.nodes[axis + 1..].iter().product();
        }
        let corner = |corner: usize| {
            let (mut index, mut weight) = (first, 1.0);
            for axis in 0..N {
                let is_above = corner >> axis & 1 == 1;
                index += if is_above { steps[axis] } else { 0 };
                weight *= if is_above { fractions[axis] } else { 1.0 - fractions[axis] };
            }
            weight * self.values.get(index).map_or(0.0, |&value| f64::from(value))
        };
        (0..1 << N).map(corner).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn multilinear_functions_are_exact_between_the_nodes() {
        let f = |[x, y, z]: [f64; 3]| 1.0 + 2.0 * x - y + 3.0 * x * y * z + 0.5 * z;
        let table = InterpolationTable::new([2, 5, 3], f);
        for point in [[0.0, 0.0, 0.0], [1.0, 1.0, 1.0], [0.3, 0.71, 0.4], [0.9, 0.25, 0.5]] {
            // Values are f32.
            assert!((table.at(point) - f(point)).abs() < 1e-6, "{point:?}");
        }
        assert!((table.at([-1.0, 2.0, 0.5]) - f([0.0, 1.0, 0.5])).abs() < 1e-6, "clamped");
        assert!((table.at([f64::NAN, 0.25, 0.5]) - f([0.0, 0.25, 0.5])).abs() < 1e-6, "not a number");
    }
}
