//! Triangular nets of control points, and the steps of de Casteljau's algorithm on them.

use glanz_math::glam::DVec4;

use super::triangle::Barycentric;

/// Index of the point (i, j, k) of a triangular net, which does not depend on i: row j + k, position k.
pub(super) fn net_index(j: usize, k: usize) -> usize {
    let row = j + k;
    row * (row + 1) / 2 + k
}

/// An argument of the blossom, applied by one step of de Casteljau's algorithm. All but `At` are computed symmetrically, so
/// that neighbours agree to the bit.
#[derive(Clone, Copy, Debug)]
pub(super) enum BlossomArgument {
    /// Mean of three corners.
    Centroid,
    /// Middle between two corners.
    Middle(usize, usize),
    /// A corner.
    Corner(usize),
    /// Any point; also differences of points, whose coordinates add up to 0.
    At(Barycentric),
}

impl BlossomArgument {
    fn combine(self, around: [DVec4; 3]) -> DVec4 {
        match self {
            Self::Centroid => (around[0] + around[1] + around[2]) / 3.0,
            Self::Middle(a, b) => (around[a] + around[b]) * 0.5,
            Self::Corner(a) => around[a],
            Self::At(at) => around[0] * at.r + around[1] * at.s + around[2] * at.t,
        }
    }

    /// Position in the order of application, which is the same in all nets, so that shared arguments give the same bits.
    pub(super) fn rank(self) -> usize {
        match self {
            Self::Centroid => 0,
            Self::Middle(a, b) => a + b,
            Self::At(_) => 4,
            Self::Corner(a) => 5 + a,
        }
    }
}

/// Applies one argument to a net of degree `degree`, which leaves one of the next lower degree; degree 0 becomes empty.
pub(super) fn advance(net: &mut Vec<DVec4>, degree: usize, argument: BlossomArgument) {
    reduce(net, degree, |around| argument.combine(around));
}

/// Replaces a net by its differences in the direction from the first corner to the second (1) or third (2).
pub(super) fn differences(net: &mut Vec<DVec4>, degree: usize, corner: usize) {
    reduce(net, degree, |around| around[corner] - around[0]);
}

fn reduce(net: &mut Vec<DVec4>, degree: usize, combine: impl Fn([DVec4; 3]) -> DVec4) {
    let mut e = 0;
    for d in 0..degree {
        for _ in 0..=d {
            // Only later points are read, so that the result can be stored in place.
            net[e] = combine([net[e], net[e + d + 1], net[e + d + 2]]);
            e += 1;
        }
    }
    net.truncate(e);
}

/// The net of f(a^i, b^j, c^k), where f is the blossom of `net` and (a, b, c) are the arguments.
pub(super) fn blossoms(net: &[DVec4], degree: usize, arguments: [BlossomArgument; 3]) -> Vec<DVec4> {
    let mut order = [0, 1, 2];
    order.sort_by_key(|role| arguments[*role].rank());
    let mut result = vec![DVec4::ZERO; net.len()];
    let mut counts = [0; 3];
    let mut first = net.to_vec();
    for a in 0..=degree {
        let mut second = first.clone();
        for b in 0..=degree - a {
            let mut third = second.clone();
            for left in (1..=degree - a - b).rev() {
                advance(&mut third, left, arguments[order[2]]);
            }
            counts[order[0]] = a;
            counts[order[1]] = b;
            counts[order[2]] = degree - a - b;
            result[net_index(counts[1], counts[2])] = third[0];
            advance(&mut second, degree - a - b, arguments[order[1]]);
        }
        advance(&mut first, degree - a, arguments[order[0]]);
    }
    result
}
