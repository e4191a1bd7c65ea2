//! Sums of one pixel.

use glanz_math::{DVec2, DVec3};

use crate::aov::{Aov, AovSet};
use crate::weighted_sums::{PassWeights, WeightedSums};
use crate::word_merge::WordMerge;
use glanz_sampling::exact::{NarrowSum, SquareSum, WideSum, fits_wide};

/// First hit of a camera ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirstHit {
    /// World position, metres.
    pub position: DVec3,
    /// Unit normal of the surface.
    pub normal: DVec3,
    /// Unit normal for shading.
    pub shading_normal: DVec3,
    /// Texture coordinates.
    pub uv: DVec2,
    /// Distance along the camera ray, metres.
    pub distance: f64,
    /// Number of the shape.
    pub object: u32,
    /// Fraction of light that the surface reflects or transmits, linear Rec. 709.
    pub albedo: [f32; 3],
}

/// One sample of a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelSample {
    /// Its number.
    pub index: u32,
    /// Linear Rec. 709 radiance.
    pub rgb: [f32; 3],
    /// Whether it lies in a negative lobe of the filter and is subtracted.
    pub negative: bool,
    /// First hit of the camera ray.
    pub first_hit: Option<FirstHit>,
}

/// Numbers of samples that were dropped or clamped.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Rejects {
    /// Samples and splats with infinite radiance or NaN, which count as black.
    pub dropped: u64,
    /// Samples and splats with a value beyond the range of the sums (2^36), which was clamped.
    pub cut: u64,
}

impl Rejects {
    /// Adds the counts of `other`.
    pub fn merge(&mut self, other: Self) {
        self.dropped = self.dropped.saturating_add(other.dropped);
        self.cut = self.cut.saturating_add(other.cut);
    }
}

/// The sums of a pixel and their positions among its words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PixelLayout {
    /// The extra channels.
    pub aovs: AovSet,
    /// Whether samples may lie in negative lobes of the filter.
    pub signed: bool,
    /// Whether samples come in passes of different variance.
    pub passes: bool,
}

impl PixelLayout {
    /// Whether the squares of samples are summed.
    fn needs_squares(&self) -> bool {
        self.passes || self.aovs.contains(Aov::Variance)
    }

    /// Number of 64 bit words of one pixel.
    #[must_use]
    pub fn words(&self) -> usize {
        self.merges().into_iter().map(WordMerge::words).sum()
    }

    /// How the sums of two pixels are merged, in the order of their words.
    pub(crate) fn merges(&self) -> Vec<WordMerge> {
        let mut merges = MergeList(Vec::new());
        PixelSums::default().visit(self, &mut merges);
        merges.0
    }
}

/// The sums of one pixel. All are exact, so that they do not depend on the order and grouping of samples.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PixelSums {
    radiance: [WideSum; 3],
    /// Number of samples in negative lobes, and their radiance (which is also part of `radiance`, with its sign).
    negative_count: u64,
    negative: [WideSum; 3],
    squares: [SquareSum; 3],
    hits: u64,
    position: [WideSum; 3],
    distance: WideSum,
    uv: [WideSum; 2],
    normal: [NarrowSum; 3],
    shading_normal: [NarrowSum; 3],
    albedo: [NarrowSum; 3],
    identity: ObjectIdSums,
    /// Radiance of finished passes, which is not in `radiance` and `squares`.
    settled: WeightedSums,
}

/// Number (high half) and shape (low half) of the lowest sample that hit a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
struct ObjectIdSums(u64);

impl Default for ObjectIdSums {
    fn default() -> Self {
        Self(u64::MAX)
    }
}

/// A visitor of the words of a pixel in their order.
trait WordAccess {
    fn word(&mut self, word: &mut u64);

    /// Visits the words of an integer.
    fn integer(&mut self, words: &mut [u64]) {
        words.iter_mut().for_each(|word| self.word(word));
    }
}

/// A list of merges, in which single words are those of which the lowest is kept.
struct MergeList(Vec<WordMerge>);

impl WordAccess for MergeList {
    fn word(&mut self, _: &mut u64) {
        self.0.push(WordMerge::Lowest);
    }

    fn integer(&mut self, words: &mut [u64]) {
        self.0.push(WordMerge::Add(words.len()));
    }
}

struct WordReader<'a>(std::slice::Iter<'a, u64>);

impl WordAccess for WordReader<'_> {
    fn word(&mut self, word: &mut u64) {
        *word = self.0.next().copied().unwrap_or_default();
    }
}

struct WordWriter<'a>(std::slice::IterMut<'a, u64>);

impl WordAccess for WordWriter<'_> {
    fn word(&mut self, word: &mut u64) {
        if let Some(slot) = self.0.next() {
            *slot = *word;
        }
    }
}

fn visit_wide<const N: usize>(sums: &mut [WideSum; N], words: &mut impl WordAccess) {
    for sum in sums {
        let mut limbs = sum.to_words();
        words.integer(&mut limbs);
        *sum = WideSum::from_words(limbs);
    }
}

fn visit_narrow(sums: &mut [NarrowSum; 3], words: &mut impl WordAccess) {
    for sum in sums {
        let mut word = sum.to_word();
        words.integer(std::slice::from_mut(&mut word));
        *sum = NarrowSum::from_word(word);
    }
}

impl PixelSums {
    /// Visits all sums in the order of the words; merging, reading and writing all use this function.
    fn visit(&mut self, layout: &PixelLayout, words: &mut impl WordAccess) {
        visit_wide(&mut self.radiance, words);
        if layout.signed {
            words.integer(std::slice::from_mut(&mut self.negative_count));
            visit_wide(&mut self.negative, words);
        }
        if layout.needs_squares() {
            for sum in &mut self.squares {
                let mut limbs = sum.to_words();
                words.integer(&mut limbs);
                *sum = SquareSum::from_words(limbs);
            }
        }
        if layout.aovs.needs_first_hit() {
            words.integer(std::slice::from_mut(&mut self.hits));
        }
        if layout.aovs.contains(Aov::Albedo) {
            visit_narrow(&mut self.albedo, words);
        }
        if layout.aovs.contains(Aov::Position) {
            visit_wide(&mut self.position, words);
        }
        if layout.aovs.contains(Aov::Normal) {
            visit_narrow(&mut self.normal, words);
        }
        if layout.aovs.contains(Aov::ShadingNormal) {
            visit_narrow(&mut self.shading_normal, words);
        }
        if layout.aovs.contains(Aov::Uv) {
            visit_wide(&mut self.uv, words);
        }
        if layout.aovs.contains(Aov::Distance) {
            visit_wide(std::array::from_mut(&mut self.distance), words);
        }
        if layout.aovs.contains(Aov::Id) {
            words.word(&mut self.identity.0);
        }
        if layout.passes {
            for value in self.settled.values_mut() {
                // Films with passes are not merged; added to no samples, the bits stay the same.
                let mut bits = value.to_bits();
                words.integer(std::slice::from_mut(&mut bits));
                *value = f64::from_bits(bits);
            }
        }
    }

    /// The sums in `words`, whose length is [`PixelLayout::words`].
    #[must_use]
    pub fn read(layout: &PixelLayout, words: &[u64]) -> Self {
        let mut sums = Self::default();
        sums.visit(layout, &mut WordReader(words.iter()));
        sums
    }

    /// Writes the sums to `words`, whose length is [`PixelLayout::words`].
    pub fn write(mut self, layout: &PixelLayout, words: &mut [u64]) {
        self.visit(layout, &mut WordWriter(words.iter_mut()));
    }

    /// Adds one sample to the sums of `layout`.
    pub fn add(&mut self, layout: &PixelLayout, sample: &PixelSample, rejects: &mut Rejects) {
        let mut rgb = sample.rgb;
        if !rgb.iter().all(|v| v.is_finite()) {
            rejects.dropped += 1;
            rgb = [0.0; 3];
        }
        let mut cut = !rgb.iter().all(|&v| fits_wide(f64::from(v)));
        for (i, value) in rgb.into_iter().enumerate() {
            let wide = f64::from(value);
            self.radiance[i].add(if sample.negative { -wide } else { wide });
            if sample.negative {
                self.negative[i].add(-wide);
            }
        }
        self.negative_count += u64::from(sample.negative);
        if layout.needs_squares() {
            self.squares.iter_mut().zip(rgb).for_each(|(sum, v)| sum.add_square(v));
        }
        if let Some(hit) = sample.first_hit.filter(|_| layout.aovs.needs_first_hit()) {
            self.add_hit(sample.index, &hit);
            cut |= !(hit.position.to_array().into_iter().all(fits_wide) && fits_wide(hit.distance));
        }
        rejects.cut += u64::from(cut);
    }

    fn add_hit(&mut self, index: u32, hit: &FirstHit) {
        self.hits += 1;
        for i in 0..3 {
            self.position[i].add(hit.position[i]);
            self.normal[i].add(hit.normal[i]);
            self.shading_normal[i].add(hit.shading_normal[i]);
            self.albedo[i].add(f64::from(hit.albedo[i]));
        }
        self.uv[0].add(hit.uv.x);
        self.uv[1].add(hit.uv.y);
        self.distance.add(hit.distance);
        self.identity.0 = self.identity.0.min(u64::from(index) << 32 | u64::from(hit.object));
    }

    /// Number of samples that hit a surface.
    pub(crate) fn hits(&self) -> u64 {
        self.hits
    }

    /// Mean and variance of the mean per band, from `count` samples in all.
    ///
    /// The mean is the sum of signed samples over the sum of signs; with a filter without negative lobes the plain mean.
    /// Where negative samples nearly cancel the others (possible with few samples only), the sum of signs is a poor divisor: it is
    /// raised to a quarter of `count`.
    ///
    /// The variance is that of independent samples, `sum (v - mean)^2 / (divisor^2) * count / (count - 1)`; the variance of stratified
    /// and Sobol points is smaller, so that this is an upper bound in practice. It is infinite for a single sample.
    #[must_use]
    pub fn radiance(&self, count: u64) -> [PixelValue; 3] {
        self.blended(&PassWeights::plain(count))
    }

    /// As [`PixelSums::radiance`], together with the finished passes.
    pub(crate) fn blended(&self, blend: &PassWeights) -> [PixelValue; 3] {
        let (divisor, bands) = self.bands(blend.count);
        self.settled.with(divisor, &bands, blend)
    }

    /// Moves the radiance to that of finished passes.
    pub(crate) fn settle(&mut self, blend: &PassWeights) {
        let (divisor, bands) = self.bands(blend.count);
        self.settled.add(divisor, &bands, blend);
        (self.radiance, self.negative, self.squares) = Default::default();
        self.negative_count = 0;
    }

    /// Estimated variance of one of the `count` samples, mean of the bands; infinite for fewer than two.
    pub(crate) fn sample_variance(&self, count: u64) -> f64 {
        if count < 2 {
            return f64::INFINITY;
        }
        let (_, bands) = self.bands(count);
        bands.iter().map(|&(_, deviation)| deviation).sum::<f64>() / (3.0 * (count - 1) as f64)
    }

    /// The sum of signs, and for each band the sum and the sum of squared deviations, of `count` samples.
    fn bands(&self, count: u64) -> (f64, [(f64, f64); 3]) {
        let n = count as f64;
        let divisor = n - 2.0 * self.negative_count as f64;
        let bands = std::array::from_fn(|i| {
            let signed = self.radiance[i].to_f64();
            let mean = if count == 0 { 0.0 } else { signed / divisor.max(0.25 * n) };
            let unsigned = signed - 2.0 * self.negative[i].to_f64();
            let deviation = self.squares[i].to_f64() - 2.0 * mean * unsigned + n * mean * mean;
            (signed, deviation.max(0.0))
        });
        (divisor, bands)
    }

    /// Means of the first hits over the samples that hit a surface; `None` if none did.
    ///
    /// The number of the shape is that of the lowest sample that hit a surface, because numbers have no mean.
    #[must_use]
    pub fn first_hit(&self) -> Option<FirstHit> {
        if self.hits == 0 {
            return None;
        }
        let scale = 1.0 / self.hits as f64;
        let wide = |s: [WideSum; 3]| DVec3::from_array(s.map(WideSum::to_f64)) * scale;
        let narrow = |s: [NarrowSum; 3]| DVec3::from_array(s.map(NarrowSum::to_f64)) * scale;
        Some(FirstHit {
            position: wide(self.position),
            normal: narrow(self.normal),
            shading_normal: narrow(self.shading_normal),
            uv: DVec2::new(self.uv[0].to_f64(), self.uv[1].to_f64()) * scale,
            distance: self.distance.to_f64() * scale,
            object: self.identity.0 as u32,
            albedo: narrow(self.albedo).to_array().map(|v| v as f32),
        })
    }
}

/// An estimate of radiance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelValue {
    /// The estimate.
    pub mean: f64,
    /// Its variance.
    pub variance: f64,
}

#[cfg(test)]
mod tests {
    use super::*;
    use glanz_sampling::exact::WIDE_LIMIT;

    fn layout(aovs: AovSet, signed: bool) -> PixelLayout {
        PixelLayout { aovs, signed, passes: false }
    }

    fn sample(index: u32, value: f32) -> PixelSample {
        PixelSample { index, rgb: [value, 2.0 * value, -value], negative: false, first_hit: None }
    }

    fn hit(object: u32) -> FirstHit {
        FirstHit {
            position: DVec3::new(1.0, 2.0, 3.0),
            normal: DVec3::Z,
            shading_normal: DVec3::X,
            uv: DVec2::new(0.25, 7.5),
            distance: 4.0,
            object,
            albedo: [0.5, 0.25, 1.0],
        }
    }

    #[test]
    fn mean_and_variance_are_those_of_the_textbook() {
        let layout = layout(AovSet::NONE.with(Aov::Variance), false);
        let (mut sums, mut rejects) = (PixelSums::default(), Rejects::default());
        // Mean of 1, 2, 3, 6 is 3; squared deviations 4 + 1 + 0 + 9 = 14; variance of the mean 14 / 3 / 4.
        for (i, v) in [1.0, 2.0, 3.0, 6.0].into_iter().enumerate() {
            sums.add(&layout, &sample(i as u32, v), &mut rejects);
        }
        let [r, g, b] = sums.radiance(4);
        assert_eq!((r.mean, g.mean, b.mean), (3.0, 6.0, -3.0));
        assert!((r.variance - 14.0 / 12.0).abs() < 1e-14);
        assert!((g.variance - 4.0 * 14.0 / 12.0).abs() < 1e-14);
        assert_eq!(rejects, Rejects::default());
    }

    #[test]
    fn constant_light_through_negative_lobes_stays_constant() {
        let layout = layout(AovSet::NONE.with(Aov::Variance), true);
        let (mut sums, mut rejects) = (PixelSums::default(), Rejects::default());
        for i in 0..10 {
            sums.add(&layout, &PixelSample { negative: i % 5 == 0, ..sample(i, 0.3) }, &mut rejects);
        }
        let value = sums.radiance(10)[0];
        assert!((value.mean - f64::from(0.3_f32)).abs() < 1e-16);
        assert!(value.variance < 1e-16);
    }

    #[test]
    fn samples_of_opposite_sign_do_not_divide_by_zero() {
        let layout = layout(AovSet::NONE, true);
        let (mut sums, mut rejects) = (PixelSums::default(), Rejects::default());
        sums.add(&layout, &sample(0, 1.0), &mut rejects);
        sums.add(&layout, &PixelSample { negative: true, ..sample(1, 0.5) }, &mut rejects);
        assert_eq!(sums.radiance(2)[0].mean, 1.0);
    }

    #[test]
    fn samples_that_are_not_finite_count_as_black_and_are_counted() {
        let layout = layout(AovSet::NONE, false);
        let (mut sums, mut rejects) = (PixelSums::default(), Rejects::default());
        sums.add(&layout, &sample(0, 4.0), &mut rejects);
        sums.add(&layout, &sample(1, f32::NAN), &mut rejects);
        sums.add(&layout, &sample(2, f32::INFINITY), &mut rejects);
        sums.add(&layout, &sample(3, f32::MAX / 4.0), &mut rejects);
        assert_eq!(rejects, Rejects { dropped: 2, cut: 1 });
        assert_eq!(sums.radiance(4)[0].mean, (4.0 + WIDE_LIMIT) / 4.0);
    }

    #[test]
    fn geometry_is_averaged_over_hits_and_the_lowest_sample_names_the_shape() {
        let layout = layout(AovSet::ALL, false);
        let (mut a, mut b, mut rejects) = (PixelSums::default(), PixelSums::default(), Rejects::default());
        a.add(&layout, &PixelSample { first_hit: Some(hit(9)), ..sample(5, 1.0) }, &mut rejects);
        a.add(&layout, &sample(0, 1.0), &mut rejects);
        b.add(&layout, &PixelSample { first_hit: Some(hit(4)), ..sample(3, 1.0) }, &mut rejects);
        let [mut words, other] = [a, b].map(|sums| {
            let mut words = vec![0; layout.words()];
            sums.write(&layout, &mut words);
            words
        });
        crate::word_merge::add_words(&layout.merges(), &mut words, &other, |word| *word);
        let a = PixelSums::read(&layout, &words);
        assert_eq!(a.first_hit(), Some(hit(4)));
        assert_eq!(PixelSums::default().first_hit(), None);
    }

    #[test]
    fn words_contain_every_sum_of_their_layout() {
        for bits in 0..=u8::MAX {
            for signed in [false, true] {
                let layout = layout(AovSet::from_bits(bits), signed);
                let (mut sums, mut rejects) = (PixelSums::default(), Rejects::default());
                for i in 0..3 {
                    let negative = signed && i == 1;
                    let one = PixelSample { first_hit: Some(hit(7)), negative, ..sample(i, 1.5) };
                    sums.add(&layout, &one, &mut rejects);
                }
                let mut words = vec![0; layout.words()];
                sums.write(&layout, &mut words);
                let back = PixelSums::read(&layout, &words);
                let mut again = vec![1; layout.words()];
                back.write(&layout, &mut again);
                assert_eq!(words, again);
                assert_eq!(back.radiance(3).map(|v| v.mean), sums.radiance(3).map(|v| v.mean));
                if layout.aovs == AovSet::ALL {
                    assert_eq!(back, sums);
                }
            }
        }
    }
}
