//! A quadrature rule of seven points with an embedded rule of three points.

/// Nodes in [-1, 1] with their weights in Kronrod's rule of seven points, exact to degree 11, and in Gauss' rule of three points among them,
/// exact to degree 5.
///
/// # Source
/// @piessens1983; the nodes and weights of @kronrod1965.
pub(super) const NODES: [Node; 7] = [
    Node { at: -0.960_491_268_708_020_3, weight: 0.104_656_226_026_467_27, coarse: 0.0 },
    Node { at: -0.774_596_669_241_483_4, weight: 0.268_488_089_868_333_44, coarse: 5.0 / 9.0 },
    Node { at: -0.434_243_749_346_802_55, weight: 0.401_397_414_775_962_2, coarse: 0.0 },
    Node { at: 0.0, weight: 0.450_916_538_658_474_14, coarse: 8.0 / 9.0 },
    Node { at: 0.434_243_749_346_802_55, weight: 0.401_397_414_775_962_2, coarse: 0.0 },
    Node { at: 0.774_596_669_241_483_4, weight: 0.268_488_089_868_333_44, coarse: 5.0 / 9.0 },
    Node { at: 0.960_491_268_708_020_3, weight: 0.104_656_226_026_467_27, coarse: 0.0 },
];

#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    pub(super) at: f64,
    pub(super) weight: f64,
    pub(super) coarse: f64,
}

/// An integral by the rule of seven points, and by that of three.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct GaussKronrod {
    pub(super) fine: f64,
    pub(super) coarse: f64,
}

/// The integral of `f` over an interval.
pub(super) fn integral([a, b]: [f64; 2], mut f: impl FnMut(f64) -> f64) -> GaussKronrod {
    let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
    let mut pair = GaussKronrod::default();
    for node in NODES {
        let value = half * f(middle + half * node.at);
        pair.fine += node.weight * value;
        pair.coarse += node.coarse * value;
    }
    pair
}

/// Error of the fine rule from its `difference` to the coarse one, where the integrand has the size `content`.
///
/// The difference is the error of the coarse rule; the error of the fine rule is about its square for smooth integrands. The more cautious power 3/2 with a factor is
/// that of @piessens1983, with the factor 10 for these rules instead of 200. Where the rules differ by a tenth or more, as
/// at jumps, the error is the difference itself.
pub(super) fn sharpened(difference: f64, content: f64) -> f64 {
    if content <= 0.0 || difference == 0.0 {
        return difference;
    }
    let relative = difference / content;
    content * relative.min((10.0 * relative).powf(1.5))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rules_are_exact_to_their_degrees() {
        for degree in 0..=11 {
            // Integral of (x + 1/3)^n from 0 to 2.
            let exact =
                ((7.0_f64 / 3.0).powi(degree + 1) - (1.0_f64 / 3.0).powi(degree + 1)) / f64::from(degree + 1);
            let pair = integral([0.0, 2.0], |x| (x + 1.0 / 3.0).powi(degree));
            assert!((pair.fine - exact).abs() < 1e-13 * exact, "{degree}: {pair:?}");
            assert_eq!((pair.coarse - exact).abs() < 1e-13 * exact, degree <= 5, "{degree}: {pair:?}");
        }
    }

    #[test]
    fn error_at_a_jump_is_the_whole_difference() {
        assert_eq!(sharpened(0.3, 1.0), 0.3);
        assert!(sharpened(1e-5, 1.0) < 2e-6);
        assert_eq!(sharpened(0.1, 0.0), 0.1);
    }
}
