//! A symmetric one-dimensional function, tabulated.

/// Half of a symmetric function, over [0, 1], piecewise linear, with the integral of its magnitude.
///
/// Between nodes at a distance h, a function with second derivative below M deviates from its chord by at most
/// h^2 M / 8 (@davis1975 section 3.1); the number of nodes follows from that.
#[derive(Clone, Debug)]
pub(super) struct FilterProfile {
    /// Ascending from 0 to 1; zeros of the interpolant are nodes, so that no segment changes sign.
    nodes: Vec<ProfileNode>,
    /// Lookup table: for equal parts of the magnitude, the first node above the lower end of each.
    guide: Vec<u32>,
    net_weight: f64,
}

#[derive(Clone, Copy, Debug)]
struct ProfileNode {
    x: f64,
    /// Signed value; the magnitude has an integral of 1 over [0, 1].
    value: f64,
    /// Integral of the magnitude up to this node.
    below: f64,
}

/// Errors of tabulating a profile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ProfileError {
    /// The profile would need too many nodes.
    Resolution,
    /// The function is zero or not a number.
    Empty,
}

/// Largest distance of the profile from the function, relative to its peak.
const ACCURACY: f64 = 2e-6;
const FEWEST_SEGMENTS: usize = 64;
const MOST_SEGMENTS: usize = 1 << 20;

impl FilterProfile {
    /// Tabulates `function` on [0, 1], given a bound on its second derivative in units of its value at 0.
    pub(super) fn try_new(function: impl Fn(f64) -> f64, curvature: f64) -> Result<Self, ProfileError> {
        let needed = (curvature / (8.0 * ACCURACY)).sqrt().ceil();
        if needed.is_nan() || needed > MOST_SEGMENTS as f64 {
            return Err(ProfileError::Resolution);
        }
        // Even, so that the joint of Mitchell's pieces in the middle is a node.
        let segments = (needed as usize).max(FEWEST_SEGMENTS).next_multiple_of(2);
        let mut nodes: Vec<ProfileNode> = Vec::with_capacity(segments + 3);
        for i in 0..=segments {
            let x = i as f64 / segments as f64;
            let value = function(x);
            if let Some(&last) = nodes.last()
                && last.value * value < 0.0
            {
                let zero = last.x + (x - last.x) * (last.value / (last.value - value));
                push(&mut nodes, zero, 0.0);
            }
            push(&mut nodes, x, value);
        }
        let signed: f64 = nodes.windows(2).map(|w| 0.5 * (w[0].value + w[1].value) * (w[1].x - w[0].x)).sum();
        let total = nodes.last().map_or(0.0, |n| n.below);
        if !(total > 0.0 && total.is_finite()) {
            return Err(ProfileError::Empty);
        }
        for node in &mut nodes {
            node.value /= total;
            node.below /= total;
        }
        let one_sign = nodes.iter().all(|n| n.value >= 0.0);
        let count = nodes.len();
        let above = |share: usize| nodes.partition_point(|n| n.below <= share as f64 / count as f64) as u32;
        let guide = (0..count).map(above).collect();
        Ok(Self { nodes, guide, net_weight: if one_sign { 1.0 } else { signed / total } })
    }

    /// Integral of the function divided by that of its magnitude.
    pub(super) fn net_weight(&self) -> f64 {
        self.net_weight
    }

    /// The function at `x` in [0, 1].
    pub(super) fn density(&self, x: f64) -> f64 {
        let at = self.nodes.partition_point(|n| n.x <= x).clamp(1, self.nodes.len() - 1);
        let (a, b) = (self.nodes[at - 1], self.nodes[at]);
        a.value + (b.value - a.value) * ((x - a.x) / (b.x - a.x))
    }

    /// Inverse of the cumulative magnitude at `u` in [0, 1], and whether the function is negative there.
    pub(super) fn sample(&self, u: f64) -> (f64, bool) {
        // The lookup table gives the node or one a few before it (@chen1974).
        let share = ((u * self.guide.len() as f64) as usize).min(self.guide.len() - 1);
        let mut at = (self.guide[share] as usize).clamp(1, self.nodes.len() - 1);
        while at < self.nodes.len() - 1 && self.nodes[at].below <= u {
            at += 1;
        }
        let (a, b) = (self.nodes[at - 1], self.nodes[at]);
        let (fa, fb) = (a.value.abs(), b.value.abs());
        // With t in [0, 1] across the segment: width (fa t + (fb - fa) t^2 / 2) = u - below, solved without cancellation.
        let target = ((u - a.below) / (b.x - a.x)).max(0.0);
        let root = (fa * fa + 2.0 * (fb - fa) * target).max(0.0).sqrt();
        let t = if target == 0.0 { 0.0 } else { (2.0 * target / (fa + root)).min(1.0) };
        (a.x + (b.x - a.x) * t, a.value + b.value < 0.0)
    }
}

fn push(nodes: &mut Vec<ProfileNode>, x: f64, value: f64) {
    let below =
        nodes.last().map_or(0.0, |last| last.below + 0.5 * (last.value.abs() + value.abs()) * (x - last.x));
    nodes.push(ProfileNode { x, value, below });
}
