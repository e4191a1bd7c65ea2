//! Mixture weights of guide and BSDF.
//!
//! Directions have the density a g + (1 - a) b, with the density g of the guide and b of the BSDF. The records give the second
//! moment of the estimator for every `a` of a grid: the sum of F^2 / (p p_a), where p is the sampled density and p_a
//! that of `a`. The `a` with the smallest moment is selected; without a clear gain the guide stays off, which also saves its lookups.

/// Number of mixture weights: 0, 1/8 ... 7/8. The weight is never 1, so that the BSDF samples directions unknown to the guide.
pub(crate) const SHARES: usize = 8;

/// Fraction of the second moment that a guide must save to be worth its time.
const WORTHWHILE: f64 = 0.1;

/// Fraction by which a guide may increase the second moment while it is coarse.
const HARMLESS: f64 = 0.02;

/// Effective number of samples from which a guide is no longer coarse.
const RESOLVED: f64 = 1000.0;

/// Smallest effective number of samples for a choice.
const FEWEST: f64 = 16.0;

/// Number of virtual samples outside the density of the guide.
const UNSEEN: f64 = 4.0;

/// Index of a mixture weight below [`SHARES`]; the weight is an eighth of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct MixtureWeight(pub(crate) u8);

impl MixtureWeight {
    /// Equal weights of guide and BSDF, with which an untested guide begins.
    pub(crate) const HALF: Self = Self(4);

    /// Probability of sampling the guide.
    #[inline]
    pub(crate) fn probability(self) -> f64 {
        f64::from(self.0) / SHARES as f64
    }

    /// The weight with the smallest second moment; `self` if there are too few records or no light.
    ///
    /// `effective`: effective number of samples. Light that the samples missed may come from directions in which the guide
    /// has no density and the mixture has (1 - a) b: the contribution of [`UNSEEN`] such samples is added to every moment.
    pub(crate) fn better(self, effective: f64, moments: &[u64; SHARES]) -> Self {
        if effective < FEWEST || moments.iter().all(|&m| m == 0) {
            return self;
        }
        let moment = |i: u8| {
            let unseen = UNSEEN / effective * moments[0] as f64 / (1.0 - Self(i).probability());
            moments[usize::from(i)] as f64 + unseen
        };
        let best = (0..SHARES as u8).min_by(|&a, &b| moment(a).total_cmp(&moment(b))).unwrap_or(0);
        if moment(best) <= (1.0 - WORTHWHILE) * moment(0) {
            return Self(best);
        }
        // The moments are those of the guide of this pass, and the next guide is better: a coarse guide stays on unless it increases the moment.
        let harmless = moments[usize::from(self.0)] as f64 <= (1.0 + HARMLESS) * moments[0] as f64;
        if effective < RESOLVED && harmless { self } else { Self(0) }
    }
}

/// Density of the mixture with this probability of the guide.
#[inline]
pub(crate) fn density(probability: f64, guide: f64, bsdf: f64) -> f64 {
    probability * guide + (1.0 - probability) * bsdf
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Second moments, in units of 2^-20, of an integrand `f` over four equal cells of the unit interval sampled with the density
    /// `guide` (also per cell) or uniformly: sum of f^2 / p_a over the cells, exactly.
    fn moments(f: [f64; 4], guide: [f64; 4]) -> [u64; SHARES] {
        std::array::from_fn(|i| {
            let a = MixtureWeight(i as u8).probability();
            let sum: f64 = f.iter().zip(guide).map(|(f, g)| f * f / density(a, g, 1.0) / 4.0).sum();
            (sum * 1_048_576.0) as u64
        })
    }

    #[test]
    fn accurate_guide_gets_the_largest_weight() {
        assert_eq!(
            MixtureWeight(0).better(1e6, &moments([0.0, 0.0, 8.0, 0.1], [0.0, 0.0, 3.9, 0.1])),
            MixtureWeight(7)
        );
    }

    #[test]
    fn wrong_or_useless_guide_is_off() {
        assert_eq!(
            MixtureWeight::HALF.better(1e6, &moments([1.0, 1.0, 5.0, 1.0], [4.0, 0.0, 0.0, 0.0])),
            MixtureWeight(0)
        );
        // With constant light even the perfect guide, g = 1, has no gain.
        assert_eq!(MixtureWeight::HALF.better(1e6, &moments([2.0; 4], [1.0; 4])), MixtureWeight(0));
    }

    #[test]
    fn guide_that_covers_half_of_the_light_gets_a_part_of_the_weight() {
        // f is 1, 1, 0, 0 and g is 4, 0, 0, 0: the moment (1 / (1 + 3 a) + 1 / (1 - a)) / 4 is least where
        // 3 (1 - a)^2 = (1 + 3 a)^2, at a = (sqrt(3) - 1) / (sqrt(3) + 3) = 0.155, and nearest of the grid to 1/8. There it is
        // 0.4675 instead of 0.5: not worth it. With light 3 : 1 it is (9 / (1 + 3 a) + 1 / (1 - a)) / 4, least at a = 0.512.
        assert_eq!(
            MixtureWeight::HALF.better(1e6, &moments([1.0, 1.0, 0.0, 0.0], [4.0, 0.0, 0.0, 0.0])),
            MixtureWeight(0)
        );
        assert_eq!(
            MixtureWeight::HALF.better(1e6, &moments([3.0, 1.0, 0.0, 0.0], [4.0, 0.0, 0.0, 0.0])),
            MixtureWeight::HALF
        );
        assert_eq!(
            MixtureWeight(0).better(1e6, &moments([3.0, 1.0, 0.0, 0.0], [4.0, 0.0, 0.0, 0.0])),
            MixtureWeight::HALF
        );
    }

    #[test]
    fn few_records_and_darkness_keep_the_weight() {
        assert_eq!(MixtureWeight(3).better(10.0, &[9, 8, 7, 6, 5, 4, 3, 2]), MixtureWeight(3));
        assert_eq!(MixtureWeight(3).better(1e6, &[0; SHARES]), MixtureWeight(3));
    }
}
