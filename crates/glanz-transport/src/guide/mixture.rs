//! Mixture weights of guide and BSDF.
//!
//! Directions have the density a g + (1 - a) b, g that of the guide and b that of the BSDF. Each record tells what the second
//! moment of the estimator would be under every `a` of a grid: the sum of F^2 / (p p_a), where p is the density that drew and p_a
//! that of `a`. The smallest is the best; without a clear gain the guide stays off, and so do its lookups.

/// Shares to choose from: 0, 1/8 ... 7/8. Never 1: what a guide does not know yet the BSDF still finds.
pub(crate) const SHARES: usize = 8;

/// Share of the second moment that a guide has to save, or it is not worth its time.
const WORTHWHILE: f64 = 0.1;

/// Share of the second moment that a guide may cost while it is coarse.
const HARMLESS: f64 = 0.02;

/// Effective samples with which a guide is no longer coarse.
const RESOLVED: f64 = 1000.0;

/// Effective samples that a choice needs.
const FEWEST: f64 = 16.0;

/// Samples that are feared to be missing.
const UNSEEN: f64 = 4.0;

/// Number of a share of [`SHARES`]; the share is an eighth of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct MixtureWeight(pub(crate) u8);

impl MixtureWeight {
    /// Guide and BSDF alike: what a guide begins with that has proved nothing yet.
    pub(crate) const HALF: Self = Self(4);

    /// Probability that the guide draws.
    #[inline]
    pub(crate) fn probability(self) -> f64 {
        f64::from(self.0) / SHARES as f64
    }

    /// The share with the least second moment; `self` if there are too few records or none brought light.
    ///
    /// `effective`: equal samples that would tell as much of the light. Light that none of them found may come from where the guide
    /// has no density, where the mixture has (1 - a) b: to every moment is added what [`UNSEEN`] samples would that were.
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
        // The moments tell of the guide of the pass, and the next one knows more: while it is still coarse, and did no harm.
        let harmless = moments[usize::from(self.0)] as f64 <= (1.0 + HARMLESS) * moments[0] as f64;
        if effective < RESOLVED && harmless { self } else { Self(0) }
    }
}

/// Density of the mixture when the guide draws with this probability.
#[inline]
pub(crate) fn density(probability: f64, guide: f64, bsdf: f64) -> f64 {
    probability * guide + (1.0 - probability) * bsdf
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Second moments, in units of 2^-20, of an integrand `f` over four equal cells of the unit interval drawn with the density
    /// `guide` (also per cell) or uniformly: sum of f^2 / p_a over the cells, exactly.
    fn moments(f: [f64; 4], guide: [f64; 4]) -> [u64; SHARES] {
        std::array::from_fn(|i| {
            let a = MixtureWeight(i as u8).probability();
            let sum: f64 = f.iter().zip(guide).map(|(f, g)| f * f / density(a, g, 1.0) / 4.0).sum();
            (sum * 1_048_576.0) as u64
        })
    }

    #[test]
    fn guide_that_knows_where_the_light_is_gets_the_largest_share() {
        assert_eq!(
            MixtureWeight(0).better(1e6, &moments([0.0, 0.0, 8.0, 0.1], [0.0, 0.0, 3.9, 0.1])),
            MixtureWeight(7)
        );
    }

    #[test]
    fn guide_that_errs_or_gains_little_is_off() {
        assert_eq!(
            MixtureWeight::HALF.better(1e6, &moments([1.0, 1.0, 5.0, 1.0], [4.0, 0.0, 0.0, 0.0])),
            MixtureWeight(0)
        );
        // Constant light: even the perfect guide, g = 1, gains nothing.
        assert_eq!(MixtureWeight::HALF.better(1e6, &moments([2.0; 4], [1.0; 4])), MixtureWeight(0));
    }

    #[test]
    fn guide_that_knows_half_shares() {
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
    fn few_records_and_darkness_change_nothing() {
        assert_eq!(MixtureWeight(3).better(10.0, &[9, 8, 7, 6, 5, 4, 3, 2]), MixtureWeight(3));
        assert_eq!(MixtureWeight(3).better(1e6, &[0; SHARES]), MixtureWeight(3));
    }
}
