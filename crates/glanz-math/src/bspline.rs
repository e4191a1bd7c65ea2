//! Knots of B-splines and the recursion for their basis functions.

/// Knots of B-splines of some degree, in ascending order.
///
/// There are `knots.len() - degree - 1` functions. The domain reaches from the knot number `degree` to the knot number
/// `count`, numbered from 0, where `count` is the number of functions. Knots outside the domain only shape the functions
/// at its ends.
#[derive(Clone, Debug, PartialEq)]
pub struct Knots {
    degree: usize,
    knots: Vec<f64>,
}

/// Knots that belong to no B-splines.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum KnotError {
    /// There are too few knots for the degree.
    #[error("there are {count} knots; at least {min} are needed")]
    TooFew {
        /// Knots given.
        count: usize,
        /// Knots needed: `2 degree + 2`.
        min: usize,
    },
    /// A knot is infinite or not a number.
    #[error("knot {position} is {value}; it must be finite")]
    NotFinite {
        /// Position of the knot.
        position: usize,
        /// Its value.
        value: f64,
    },
    /// The difference of the last and the first knot overflows.
    #[error("the range of the knots is {0}; it must be finite")]
    Range(f64),
    /// A knot is less than the one before it.
    #[error("knot {position} is {value}, less than {previous} before it; sort the knots")]
    Decrease {
        /// Position of the knot.
        position: usize,
        /// Its value.
        value: f64,
        /// The knot before it.
        previous: f64,
    },
    /// The domain is empty.
    #[error("the domain from {start} to {end} is empty")]
    EmptyDomain {
        /// Its start.
        start: f64,
        /// Its end.
        end: f64,
    },
    /// A knot is repeated too often.
    #[error("knot {value} appears {multiplicity} times; at most {max} are possible")]
    Multiplicity {
        /// Position of the first repetition that is too many.
        position: usize,
        /// The knot.
        value: f64,
        /// Number of repetitions.
        multiplicity: usize,
        /// Largest number possible.
        max: usize,
    },
}

impl Knots {
    /// The knots of B-splines of `degree` of which none is zero everywhere: a knot appears at most `degree + 1` times, and
    /// inside the domain at most `inner_multiplicity` times. With `degree` there, functions are continuous.
    ///
    /// # Errors
    /// See [`KnotError`].
    pub fn try_new(degree: usize, knots: Vec<f64>, inner_multiplicity: usize) -> Result<Self, KnotError> {
        let (count, min) = (knots.len(), 2 * degree + 2);
        if count < min {
            return Err(KnotError::TooFew { count, min });
        }
        if let Some(position) = knots.iter().position(|knot| !knot.is_finite()) {
            return Err(KnotError::NotFinite { position, value: knots[position] });
        }
        if let Some(i) = knots.windows(2).position(|pair| pair[1] < pair[0]) {
            return Err(KnotError::Decrease { position: i + 1, value: knots[i + 1], previous: knots[i] });
        }
        let range = knots[count - 1] - knots[0];
        if !range.is_finite() {
            return Err(KnotError::Range(range));
        }
        let checked = Self { degree, knots };
        let [start, end] = checked.domain();
        if start >= end {
            return Err(KnotError::EmptyDomain { start, end });
        }
        let mut first = 0;
        for (value, multiplicity) in checked.distinct() {
            let max = if value > start && value < end { inner_multiplicity } else { degree + 1 };
            if multiplicity > max {
                return Err(KnotError::Multiplicity { position: first + max, value, multiplicity, max });
            }
            first += multiplicity;
        }
        Ok(checked)
    }

    /// The knots of `degree` with these `inner` knots whose ends appear `degree + 1` times, not yet checked.
    #[must_use]
    pub fn clamped(degree: usize, [start, end]: [f64; 2], inner: impl IntoIterator<Item = f64>) -> Vec<f64> {
        let mut knots = vec![start; degree + 1];
        knots.extend(inner);
        knots.extend(std::iter::repeat_n(end, degree + 1));
        knots
    }

    /// The knots of `degree` that divide [0, 1] into equal segments, with the ends repeated `degree + 1` times, not yet
    /// checked.
    #[must_use]
    pub fn clamped_uniform(degree: usize, segments: usize) -> Vec<f64> {
        Self::clamped(degree, [0.0, 1.0], (1..segments).map(|i| i as f64 / segments as f64))
    }

    /// Degree of the functions.
    #[must_use]
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// All knots, ascending.
    #[must_use]
    pub fn knots(&self) -> &[f64] {
        &self.knots
    }

    /// Number of functions, and of control points of a spline.
    #[must_use]
    pub fn count(&self) -> usize {
        self.knots.len() - self.degree - 1
    }

    /// Smallest and largest parameter.
    #[must_use]
    pub fn domain(&self) -> [f64; 2] {
        [self.knots[self.degree], self.knots[self.count()]]
    }

    /// `u`, moved to the nearer end of the domain if it lies outside.
    #[must_use]
    pub fn clamp(&self, u: f64) -> f64 {
        let [start, end] = self.domain();
        u.clamp(start, end)
    }

    /// Whether the first and the last knot of the domain appear `degree + 1` times, so that a spline starts and ends in
    /// control points.
    #[must_use]
    pub fn is_clamped(&self) -> bool {
        let [start, end] = self.domain();
        self.knots[0] == start && self.knots[self.knots.len() - 1] == end
    }

    /// The index i of the non-empty span with `knots[i] <= u < knots[i + 1]`.
    ///
    /// The last span is closed. Parameters outside the domain get the first or the last span, NaN the first one.
    #[inline]
    #[must_use]
    pub fn find_span(&self, u: f64) -> usize {
        let [start, end] = self.domain();
        // Of the knots after the start of the domain; all earlier ones are at most `u`, all later ones above it.
        let inner = &self.knots[self.degree + 1..self.count()];
        let passed = if u >= end {
            inner.partition_point(|&k| k < end)
        } else {
            // Written so that NaN becomes the start.
            let u = if u > start { u } else { start };
            inner.partition_point(|&k| k <= u)
        };
        self.degree + passed
    }

    /// The non-empty spans, also outside the domain: index, start, end.
    pub fn spans(&self) -> impl Iterator<Item = (usize, f64, f64)> + '_ {
        self.knots.windows(2).enumerate().filter(|(_, w)| w[0] < w[1]).map(|(i, w)| (i, w[0], w[1]))
    }

    /// Number of times that `u` appears among the knots.
    #[must_use]
    pub fn multiplicity(&self, u: f64) -> usize {
        self.knots.iter().filter(|&&k| k == u).count()
    }

    /// The distinct knots with their multiplicities, ascending.
    #[must_use]
    pub fn distinct(&self) -> Vec<(f64, usize)> {
        self.knots.chunk_by(|a, b| a == b).map(|equal| (equal[0], equal.len())).collect()
    }

    /// The ends of the pieces, ascending: the distinct knots inside the domain and at its ends.
    #[must_use]
    pub fn breaks(&self) -> Vec<f64> {
        let mut breaks = self.knots[self.degree..=self.count()].to_vec();
        breaks.dedup();
        breaks
    }

    /// The knots strictly inside the domain with their repetitions, ascending.
    #[must_use]
    pub fn inner(&self) -> &[f64] {
        let [start, end] = self.domain();
        let from = self.knots.partition_point(|&k| k <= start);
        let to = self.knots.partition_point(|&k| k < end);
        &self.knots[from..to]
    }

    /// The functions of `degree`, at most that of the knots, that do not vanish on `span`: `degree + 1` numbers, then
    /// zeros. The first one belongs to function `span - degree`.
    ///
    /// Step q of the recursion, from 1 to `degree`, divides each function of degree q - 1 between two of degree q, the one
    /// that starts a knot earlier and the one that starts with it: `divide(q, value, left, right)` returns these two shares
    /// of `value`, (right - u) / (right - left) and (u - left) / (right - left) of it at the parameter u. The rounding of
    /// the shares is that of `divide`; with a parameter of its own in each step the numbers are blossoms (polar forms).
    ///
    /// # Source
    /// @piegl1997 algorithm A2.2; with differing parameters the second algorithm of @cohen1980.
    #[inline]
    #[must_use]
    pub fn recursion<const N: usize>(
        &self,
        span: usize,
        degree: usize,
        divide: impl Fn(usize, f64, f64, f64) -> [f64; 2],
    ) -> [f64; N] {
        let mut row = [0.0; N];
        row[0] = 1.0;
        for q in 1..=degree {
            self.recursion_step(span, q, &mut row, |value, left, right| divide(q, value, left, right));
        }
        row
    }

    /// Step `q` of [`Self::recursion`]: from the functions of degree q - 1 to those of degree q.
    #[inline]
    pub fn recursion_step<const N: usize>(
        &self,
        span: usize,
        q: usize,
        row: &mut [f64; N],
        divide: impl Fn(f64, f64, f64) -> [f64; 2],
    ) {
        let t = &self.knots;
        let mut rising = 0.0;
        for j in 0..q {
            let [staying, next] = divide(row[j], t[span + 1 + j - q], t[span + 1 + j]);
            row[j] = rising + staying;
            rising = next;
        }
        // Blossoms of negative numbers may rise to -0, which the sum turns into 0.
        row[q] = rising + 0.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unusable_knots_are_refused_with_position_and_value() {
        let refused = |degree, knots: &[f64]| Knots::try_new(degree, knots.to_vec(), degree + 1).unwrap_err();
        assert_eq!(refused(2, &[0.0, 0.0, 0.0, 1.0, 1.0]), KnotError::TooFew { count: 5, min: 6 });
        assert!(matches!(refused(0, &[0.0, f64::NAN, 1.0]), KnotError::NotFinite { position: 1, .. }));
        assert_eq!(refused(1, &[-1e308, 0.0, 1.0, 1e308]), KnotError::Range(f64::INFINITY));
        let decrease = KnotError::Decrease { position: 2, value: 0.5, previous: 0.6 };
        assert_eq!(refused(0, &[0.0, 0.6, 0.5, 1.0]), decrease);
        assert_eq!(refused(1, &[0.0, 1.0, 1.0, 2.0]), KnotError::EmptyDomain { start: 1.0, end: 1.0 });
        let multiplicity = KnotError::Multiplicity { position: 2, value: 0.5, multiplicity: 2, max: 1 };
        assert_eq!(refused(0, &[0.0, 0.5, 0.5, 1.0]), multiplicity);
        let discontinuous = vec![0.0, 0.0, 0.5, 0.5, 1.0, 1.0];
        assert!(Knots::try_new(1, discontinuous.clone(), 2).is_ok());
        assert!(matches!(Knots::try_new(1, discontinuous, 1), Err(KnotError::Multiplicity { max: 1, .. })));
    }

    #[test]
    fn recursion_of_one_span_gives_bernstein_polynomials() {
        let knots = Knots::try_new(3, Knots::clamped_uniform(3, 1), 3).unwrap();
        let u = 0.25;
        let shares = |_: usize, value: f64, left: f64, right: f64| {
            [(right - u) / (right - left) * value, (u - left) / (right - left) * value]
        };
        assert_eq!(knots.recursion::<5>(3, 3, shares), [27.0, 27.0, 9.0, 1.0, 0.0].map(|n| n / 64.0));
        assert_eq!(knots.recursion::<2>(3, 1, shares), [0.75, 0.25]);
    }
}
