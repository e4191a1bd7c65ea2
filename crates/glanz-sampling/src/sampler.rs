//! The random numbers of one sample of one pixel.

use glanz_math::DVec2;

use crate::hash::{combine, permute, unit_f64};
use crate::sequence::owen::{ScrambledSobol, unit};

/// Sampling patterns of pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum SamplerKind {
    /// Owen-scrambled Sobol' points, one sequence per pixel.
    #[default]
    Sobol,
    /// Independent uniform numbers.
    Independent,
    /// One random point per cell of a grid (document 003 section 5.7.3, `UVSamplerJittered`).
    Stratified,
    /// The middle of each cell of a grid over the pixel (document 003 section 5.7.3, `UVSamplerRegular`); all other dimensions as
    /// [`SamplerKind::Stratified`].
    Regular,
    /// The middle of the pixel (document 003 section 5.7.3, `UVSamplerDirect`); all other dimensions as
    /// [`SamplerKind::Sobol`].
    Center,
}

impl SamplerKind {
    /// All kinds.
    pub const ALL: [Self; 5] =
        [Self::Sobol, Self::Independent, Self::Stratified, Self::Regular, Self::Center];

    /// Name in scene files and on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Sobol => "sobol",
            Self::Independent => "independent",
            Self::Stratified => "stratified",
            Self::Regular => "regular",
            Self::Center => "center",
        }
    }

    /// The kind with the given name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|k| k.name() == name)
    }
}

/// Generates the numbers of one sample of one pixel, one dimension after the other.
///
/// A small value without shared state: the numbers depend only on the arguments of [`PixelSampler::new`] and on the dimension.
/// Samples may be taken in any order and grouping; the first `n` of more samples equal `n` samples alone (for
/// [`SamplerKind::Stratified`] and [`SamplerKind::Regular`] the grid depends on `samples_per_pixel`, which must be the
/// same).
#[derive(Clone, Copy, Debug)]
pub struct PixelSampler {
    kind: SamplerKind,
    /// Number of cells along each side of the grid of the stratified kinds.
    side: u32,
    /// Number of strata of a single number in the stratified kinds.
    strata: u32,
    key: u64,
    index: u32,
    dimension: u32,
}

/// Dimensions 0 and 1 belong to [`PixelSampler::pixel_2d`].
const FIRST_DIMENSION: u32 = 2;

impl PixelSampler {
    /// The sampler of sample `sample_index` of `pixel`.
    ///
    /// `samples_per_pixel`: the planned number, 0 counts as 1; more samples than planned are allowed. If it is not a square, some
    /// cells of the grids of the stratified kinds stay empty, different ones in each pixel.
    #[must_use]
    pub fn new(
        kind: SamplerKind,
        samples_per_pixel: u32,
        seed: u64,
        pixel: [u32; 2],
        sample_index: u32,
    ) -> Self {
        let strata = samples_per_pixel.max(1);
        // ceil(sqrt(n)), but at most 65535, whose square fits in 32 bits.
        let floor = strata.isqrt();
        let side = if floor * floor == strata { floor } else { floor + 1 }.min(0xffff);
        let pixel = u64::from(pixel[1]) << 32 | u64::from(pixel[0]);
        let key = combine(combine(seed, 0), pixel);
        Self { kind, side, strata, key, index: sample_index, dimension: FIRST_DIMENSION }
    }

    /// Position of the sample in the pixel's square [0, 1)^2; does not advance the dimension.
    #[must_use]
    pub fn pixel_2d(&self) -> DVec2 {
        match self.kind {
            SamplerKind::Center => DVec2::splat(0.5),
            SamplerKind::Regular => self.cell(0).0,
            _ => self.point(0),
        }
    }

    /// The next number, in [0, 1).
    #[inline]
    pub fn next_1d(&mut self) -> f64 {
        let d = self.dimension;
        self.dimension = d.wrapping_add(1);
        match self.kind {
            SamplerKind::Sobol | SamplerKind::Center => {
                unit(self.sobol(d).coordinate(self.index.reverse_bits(), (d % 4) as usize))
            }
            SamplerKind::Independent => unit_f64(combine(self.request_key(d), u64::from(self.index))),
            SamplerKind::Stratified | SamplerKind::Regular => {
                let (round, position) = (self.index / self.strata, self.index % self.strata);
                let key = combine(self.request_key(d), u64::from(round));
                let jitter = unit_f64(combine(key, u64::from(position)));
                below_one((f64::from(permute(position, self.strata, key)) + jitter) / f64::from(self.strata))
            }
        }
    }

    /// The next two numbers, in [0, 1)^2, well distributed jointly; starts at an even dimension.
    #[inline]
    pub fn next_2d(&mut self) -> DVec2 {
        let d = self.dimension.wrapping_add(self.dimension & 1);
        self.dimension = d.wrapping_add(2);
        self.point(d)
    }

    /// Advances to the next group of four dimensions.
    ///
    /// The numbers of one group are jointly well distributed, those of different groups are independent. Decisions that belong
    /// together (a lobe and a direction in it, a light and a point on it) should use one group: [`PixelSampler::next_2d`] first,
    /// then up to two times [`PixelSampler::next_1d`]. In two groups, they converge no faster than with independent numbers.
    pub fn begin_group(&mut self) {
        self.dimension = self.dimension.wrapping_add(3) & !3;
    }

    /// The numbers of the next group: those of [`PixelSampler::begin_group`], then [`PixelSampler::next_2d`] and two times
    /// [`PixelSampler::next_1d`], at less cost.
    #[inline]
    pub fn next_group(&mut self) -> [f64; 4] {
        self.begin_group();
        if let SamplerKind::Sobol | SamplerKind::Center = self.kind {
            let d = self.dimension;
            self.dimension = d.wrapping_add(4);
            return self.sobol(d).point(self.index.reverse_bits()).map(unit);
        }
        let pair = self.next_2d();
        [pair.x, pair.y, self.next_1d(), self.next_1d()]
    }

    /// The numbers of the next group of this sample and of the `count - 1` samples after it: those of [`PixelSampler::next_group`], at less
    /// cost. `groups` is replaced; the dimension stays.
    pub fn groups_of_samples(&self, count: u32, groups: &mut Vec<[f64; 4]>) {
        let mut first = *self;
        first.begin_group();
        let indices = (0..count).map(|offset| self.index.wrapping_add(offset));
        groups.clear();
        if let SamplerKind::Sobol | SamplerKind::Center = self.kind {
            let sobol = first.sobol(first.dimension);
            groups.extend(indices.map(|index| sobol.point(index.reverse_bits()).map(unit)));
        } else {
            groups.extend(indices.map(|index| first.with_index(index).next_group()));
        }
    }

    /// The dimension of the next number.
    #[must_use]
    pub fn dimension(&self) -> u32 {
        self.dimension
    }

    /// Continues at `dimension`, so that later numbers do not depend on how many were used before.
    ///
    /// Dimensions 0 and 1 are those of [`PixelSampler::pixel_2d`].
    pub fn skip_to_dimension(&mut self, dimension: u32) {
        self.dimension = dimension;
    }

    /// The sampler of another sample of the pixel, at the same dimension.
    #[must_use]
    pub fn with_index(self, index: u32) -> Self {
        Self { index, ..self }
    }

    /// The index of the sample.
    #[must_use]
    pub fn sample_index(&self) -> u32 {
        self.index
    }

    /// The point in the even dimension `d` and the next one.
    #[inline]
    fn point(&self, d: u32) -> DVec2 {
        match self.kind {
            SamplerKind::Sobol | SamplerKind::Center => {
                let [x, y] = self.sobol(d).pair(self.index.reverse_bits(), (d / 2 % 2) as usize);
                DVec2::new(unit(x), unit(y))
            }
            SamplerKind::Independent => {
                let x = combine(self.request_key(d), u64::from(self.index));
                DVec2::new(unit_f64(x), unit_f64(combine(x, 1)))
            }
            SamplerKind::Stratified | SamplerKind::Regular => {
                let (middle, key) = self.cell(d);
                let x = combine(key, u64::from(self.index));
                let jitter = DVec2::new(unit_f64(x), unit_f64(combine(x, 1))) - 0.5;
                let p = middle + jitter / f64::from(self.side);
                DVec2::new(below_one(p.x), below_one(p.y))
            }
        }
    }

    /// Middle of this sample's cell in the grid of dimension `d`, and the key of this pass over the grid.
    ///
    /// The order of the cells is different in each pixel and dimension.
    fn cell(&self, d: u32) -> (DVec2, u64) {
        let cells = self.side * self.side;
        let key = combine(self.request_key(d), u64::from(self.index / cells));
        let cell = permute(self.index % cells, cells, key);
        let corner = DVec2::new(f64::from(cell % self.side), f64::from(cell / self.side));
        ((corner + 0.5) / f64::from(self.side), key)
    }

    #[inline]
    fn request_key(&self, dimension: u32) -> u64 {
        combine(self.key, u64::from(dimension))
    }

    /// The copy of the sequence for `dimension`: one for every four dimensions.
    #[inline]
    fn sobol(&self, dimension: u32) -> ScrambledSobol {
        ScrambledSobol::new(self.request_key(dimension / 4))
    }
}

/// Rounding may carry (n - 1 + jitter) / n up to 1.
#[inline]
fn below_one(x: f64) -> f64 {
    x.clamp(0.0, 1.0 - f64::EPSILON / 2.0)
}
