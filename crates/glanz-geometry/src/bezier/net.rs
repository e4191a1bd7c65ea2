//! Triangular nets of control points, and the steps of de Casteljau's algorithm on them.

use glanz_math::glam::DVec4;

use super::triangle::Barycentric;

/// Where the point (i, j, k) of a triangular net stands, whatever i: row j + k, place k.
pub(super) fn net_index(j: usize, k: usize) -> usize {
    let row = j + k;
    row * (row + 1) / 2 + k
}

/// An argument of the blossom. Those with a name are exact where arithmetic is, so that neighbours agree to the bit.
#[derive(Clone, Copy, Debug)]
pub(super) enum Step {
    /// Mean of three corners.
    Centroid,
    /// Middle between two corners.
    Middle(usize, usize),
    /// A corner.
    Corner(usize),
    /// Anything else; also differences, the coordinates of which add up to 0.
    At(Barycentric),
}

impl Step {
    fn combine(self, around: [DVec4; 3]) -> DVec4 {
        match self {
            Self::Centroid => (around[0] + around[1] + around[2]) / 3.0,
            Self::Middle(a, b) => (around[a] + around[b]) * 0.5,
            Self::Corner(a) => around[a],
            Self::At(at) => around[0] * at.r + around[1] * at.s + around[2] * at.t,
        }
    }

    /// In which order steps are to be taken, so that nets that share some get the same bits from them.
    pub(super) fn rank(self) -> usize {
        match self {
            Self::Centroid => 0,
            Self::Middle(a, b) => a + b,
            Self::At(_) => 4,
            Self::Corner(a) => 5 + a,
        }
    }
}

/// Replaces a net of degree `degree` by that of one degree less which the step leaves; nothing is left of degree 0.
pub(super) fn advance(net: &mut Vec<DVec4>, degree: usize, step: Step) {
    reduce(net, degree, |around| step.combine(around));
}

/// Replaces a net by its differences in the direction of the second (1) or third (2) corner from the first.
pub(super) fn differences(net: &mut Vec<DVec4>, degree: usize, corner: usize) {
    reduce(net, degree, |around| around[corner] - around[0]);
}

fn reduce(net: &mut Vec<DVec4>, degree: usize, combine: impl Fn([DVec4; 3]) -> DVec4) {
    let mut e = 0;
    for d in 0..degree {
        for _ in 0..=d {
            // Later points only, so that the result can take the place.
            net[e] = combine([net[e], net[e + d + 1], net[e + d + 2]]);
            e += 1;
        }
    }
    net.truncate(e);
}

/// The net of f(a^i, b^j, c^k), f the blossom of `net` and (a, b, c) the steps.
pub(super) fn blossoms(net: &[DVec4], degree: usize, steps: [Step; 3]) -> Vec<DVec4> {
    let mut order = [0, 1, 2];
    order.sort_by_key(|role| steps[*role].rank());
    let mut result = vec![DVec4::ZERO; net.len()];
    let mut counts = [0; 3];
    let mut first = net.to_vec();
    for a in 0..=degree {
        let mut second = first.clone();
        for b in 0..=degree - a {
            let mut third = second.clone();
            for left in (1..=degree - a - b).rev() {
                advance(&mut third, left, steps[order[2]]);
            }
            counts[order[0]] = a;
            counts[order[1]] = b;
            counts[order[2]] = degree - a - b;
            result[net_index(counts[1], counts[2])] = third[0];
            advance(&mut second, degree - a - b, steps[order[1]]);
        }
        advance(&mut first, degree - a, steps[order[0]]);
    }
    result
}
