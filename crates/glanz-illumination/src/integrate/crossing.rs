//! Crossings of lines with the border of a region.

use glanz_math::DVec2;

use super::region::{IntegrationRect, Region};

/// Samples along each side of a rectangle.
pub(super) const GRID: usize = 4;

/// A line along one axis of a plane.
#[derive(Clone, Copy, Debug)]
pub(super) struct ScanLine {
    pub(super) part: u32,
    /// 0 or 1.
    pub(super) along: usize,
    /// The coordinate of the other axis.
    pub(super) across: f64,
}

/// Sample of a line.
#[derive(Clone, Copy, Debug)]
pub(super) struct LineSample<S> {
    pub(super) at: f64,
    pub(super) border: f64,
    branch: u32,
    /// The integrand, if the point is inside and not hidden.
    pub(super) value: Option<f64>,
    data: S,
}

impl<S> LineSample<S> {
    pub(super) fn is_inside(&self) -> bool {
        self.value.is_some()
    }
}

impl ScanLine {
    pub(super) fn place(&self, t: f64) -> DVec2 {
        if self.along == 0 { DVec2::new(t, self.across) } else { DVec2::new(self.across, t) }
    }

    pub(super) fn sample<R: Region>(&self, region: &R, t: f64) -> LineSample<R::Sample> {
        let mut sample = self.sample_border(region, t);
        sample.value = (sample.border > 0.0).then(|| region.value(self.part, &sample.data)).flatten();
        sample
    }

    /// A sample of the border function alone, without the integrand.
    fn sample_border<R: Region>(&self, region: &R, t: f64) -> LineSample<R::Sample> {
        let data = region.sample(self.part, self.place(t));
        LineSample { at: t, border: R::border(&data), branch: R::branch(&data), value: None, data }
    }

    /// Samples in ascending order, with additional ones where the border is crossed twice between two of them.
    fn with_extremes<R: Region>(
        &self,
        region: &R,
        samples: &[LineSample<R::Sample>],
    ) -> Vec<LineSample<R::Sample>> {
        let mut all = samples.to_vec();
        for three in samples.windows(3) {
            let [a, b, c] = three else { continue };
            let all_inside = a.is_inside() && b.is_inside() && c.is_inside();
            if let Some(t) = dip([a, b, c].map(|sample| sample.border)).filter(|_| all_inside) {
                let sample = self.sample(region, b.at + t * (b.at - a.at));
                if !sample.is_inside() {
                    all.push(sample);
                }
            }
        }
        for (i, pair) in samples.windows(2).enumerate() {
            let &[left, right] = pair else { continue };
            let before = i.checked_sub(1).and_then(|i| samples.get(i)).copied();
            let gap = BorderInterval { before, left, right, after: samples.get(i + 2).copied() };
            all.extend(self.tip(region, &gap, TIP_DIVISIONS));
        }
        all.sort_by(|a, b| a.at.total_cmp(&b.at));
        all
    }

    /// A point inside, between two outside.
    ///
    /// For convex emitters the border function is concave, or nearly so: it lies below the extended lines through pairs of samples. The search moves to
    /// the intersection of these lines, which is the tip itself if the border has a corner there.
    fn tip<R: Region>(
        &self,
        region: &R,
        gap: &BorderInterval<R::Sample>,
        budget: u32,
    ) -> Option<LineSample<R::Sample>> {
        let t = gap.guess().filter(|_| budget > 0)?;
        let sample = self.sample(region, t);
        if sample.is_inside() {
            return Some(sample);
        }
        let left = BorderInterval { right: sample, after: Some(gap.right), ..*gap };
        let right = BorderInterval { left: sample, before: Some(gap.left), ..*gap };
        self.tip(region, &left, budget - 1).or_else(|| self.tip(region, &right, budget - 1))
    }
}

/// Largest number of divisions of a gap in search of a tip.
const TIP_DIVISIONS: u32 = 4;

/// Two samples and their neighbours on a line.
#[derive(Clone, Copy)]
struct BorderInterval<S> {
    before: Option<LineSample<S>>,
    left: LineSample<S>,
    right: LineSample<S>,
    after: Option<LineSample<S>>,
}

impl<S: Copy> BorderInterval<S> {
    /// Position of the largest possible value of a concave function with these values, if it may be positive.
    fn guess(&self) -> Option<f64> {
        let (a, b) = (self.left.border, self.right.border);
        if !(a <= 0.0 && b <= 0.0 && a.is_finite() && b.is_finite()) {
            return None;
        }
        let slope = |from: &LineSample<S>, to: &LineSample<S>| (to.border - from.border) / (to.at - from.at);
        let width = self.right.at - self.left.at;
        let rise = self.before.map(|before| slope(&before, &self.left));
        let fall = self.after.map(|after| slope(&self.right, &after));
        let t = match (rise, fall) {
            (Some(rise), Some(fall)) => {
                // a + rise t = b - fall (width - t)
                let t = (b - fall * width - a) / (rise - fall);
                (rise > 0.0 && fall < 0.0 && a + rise * t > 0.0).then_some(t)?
            }
            (None, Some(fall)) => (b - fall * width > 0.0).then_some(0.5 * width)?,
            (Some(rise), None) => (a + rise * width > 0.0).then_some(0.5 * width)?,
            (None, None) => return None,
        };
        (t > 0.0 && t < width).then_some(self.left.at + t)
    }
}

/// Position in (-1, 1) of the minimum of the parabola through positive values at -1, 0, 1, if it is below 0 or near enough that the function may be.
fn dip([a, b, c]: [f64; 3]) -> Option<f64> {
    let (slope, bend) = (0.5 * (c - a), a - 2.0 * b + c);
    if !(bend > 0.0 && bend.is_finite()) {
        return None;
    }
    let t = -slope / bend;
    // The error of the parabola is of the third difference; an eighth of its second difference is the margin for it.
    (t.abs() < 1.0 && b + 0.5 * slope * t < 0.125 * bend).then_some(t)
}

/// Largest number of iterations for a root; bisection alone needs 50.
const MOST_STEPS: usize = 100;

/// Position at which the line leaves the region between a point inside and one outside.
pub(super) fn root<R: Region>(
    region: &R,
    line: &ScanLine,
    inside: &LineSample<R::Sample>,
    outside: &LineSample<R::Sample>,
) -> f64 {
    let width = (inside.at - outside.at).abs();
    let smooth = inside.border > 0.0 && outside.border <= 0.0 && (inside.border - outside.border).is_finite();
    if !smooth {
        return bisect(region, line, inside.at, outside.at, 1e-9 * width);
    }
    let last = illinois(region, line, inside, outside, 1e-10 * width);
    if region.value(line.part, &last.data).is_some() {
        return last.at;
    }
    // Something else ends the region before the root.
    bisect(region, line, inside.at, last.at, 1e-9 * width)
}

/// The last point known to be inside before the zero of the border function.
///
/// # Source
/// @dowell1971, with a bisection after two steps to the same side that did not halve the interval.
fn illinois<R: Region>(
    region: &R,
    line: &ScanLine,
    inside: &LineSample<R::Sample>,
    outside: &LineSample<R::Sample>,
    accuracy: f64,
) -> LineSample<R::Sample> {
    let (mut inner, mut outer) = (*inside, *outside);
    let (mut f, mut g) = (inner.border, outer.border);
    let mut same_side = 0_i32;
    for _ in 0..MOST_STEPS {
        let width = (inner.at - outer.at).abs();
        if width <= accuracy {
            break;
        }
        let secant = (inner.at * g - outer.at * f) / (g - f);
        let middle = 0.5 * (inner.at + outer.at);
        let mut t = if secant.is_finite() && same_side.abs() < 3 { secant } else { middle };
        // A step beyond the root by the accuracy lets the interval shrink from the other side.
        let towards_outer = (outer.at - inner.at).signum();
        if (t - inner.at).abs() < 0.5 * accuracy {
            t = inner.at + 0.5 * accuracy * towards_outer;
        } else if (t - outer.at).abs() < 0.5 * accuracy {
            t = outer.at - 0.5 * accuracy * towards_outer;
        }
        let sample = line.sample_border(region, t);
        if sample.border > 0.0 {
            (inner, f) = (sample, sample.border);
            same_side = same_side.max(0) + 1;
            if same_side > 1 {
                g *= 0.5;
            }
        } else if sample.border.is_finite() {
            (outer, g) = (sample, sample.border);
            same_side = same_side.min(0) - 1;
            if same_side < -1 {
                f *= 0.5;
            }
        } else {
            // The border function is not finite: bisect.
            (outer, g, same_side) = (sample, f64::NEG_INFINITY, 3);
        }
    }
    inner
}

/// The border by bisection, where only inside and outside are known.
fn bisect<R: Region>(region: &R, line: &ScanLine, inside: f64, outside: f64, accuracy: f64) -> f64 {
    let (mut inner, mut outer) = (inside, outside);
    for _ in 0..MOST_STEPS {
        if (inner - outer).abs() <= accuracy {
            break;
        }
        let middle = 0.5 * (inner + outer);
        if line.sample(region, middle).is_inside() {
            inner = middle;
        } else {
            outer = middle;
        }
    }
    0.5 * (inner + outer)
}

/// Samples on a grid over a rectangle.
pub(super) struct GridSamples<S> {
    /// Rows by the second coordinate, samples in a row by the first.
    grid: [[LineSample<S>; GRID]; GRID],
    /// Samples on the sides of the rectangle, by the axis along which a side runs, then low and high side; with extremes.
    sides: [[(ScanLine, Vec<LineSample<S>>); 2]; 2],
}

impl<S: Copy> GridSamples<S> {
    pub(super) fn take<R: Region<Sample = S>>(region: &R, part: u32, rect: &IntegrationRect) -> Self {
        let place = |axis: usize, i: usize| {
            let share = i as f64 / (GRID - 1) as f64;
            rect.min[axis] + share * rect.size()[axis]
        };
        let grid: [[LineSample<S>; GRID]; GRID] = std::array::from_fn(|j| {
            let line = ScanLine { part, along: 0, across: place(1, j) };
            std::array::from_fn(|i| line.sample(region, place(0, i)))
        });
        let side = |along: usize, end: usize| {
            let line = ScanLine { part, along, across: place(1 - along, end) };
            let samples: Vec<LineSample<S>> = (0..GRID)
                .map(|i| {
                    let sample = if along == 0 { grid[end][i] } else { grid[i][end] };
                    LineSample { at: place(along, i), ..sample }
                })
                .collect();
            let samples = line.with_extremes(region, &samples);
            (line, samples)
        };
        let sides = [0, 1].map(|along| [side(along, 0), side(along, GRID - 1)]);
        Self { grid, sides }
    }

    fn samples(&self) -> impl Iterator<Item = &LineSample<S>> {
        let sides = self.sides.iter().flatten().flat_map(|(_, samples)| samples);
        self.grid.iter().flatten().chain(sides)
    }

    pub(super) fn is_inside(&self, i: usize, j: usize) -> bool {
        self.grid[j][i].is_inside()
    }

    /// Whether all samples are inside, or all outside.
    pub(super) fn is_uniform(&self) -> bool {
        let first = self.is_inside(0, 0);
        self.samples().all(|sample| sample.is_inside() == first)
    }

    /// Mean of the integrand inside.
    pub(super) fn mean(&self) -> f64 {
        let values: Vec<f64> = self.samples().filter_map(|sample| sample.value).collect();
        values.iter().sum::<f64>() / values.len().max(1) as f64
    }

    /// Largest sampled integrand.
    pub(super) fn largest(&self) -> f64 {
        self.samples().filter_map(|sample| sample.value).fold(0.0, f64::max)
    }

    /// Fraction of the rectangle that is inside, estimated from the grid.
    pub(super) fn share(&self) -> f64 {
        let inside = self.grid.iter().flatten().filter(|sample| sample.is_inside()).count();
        inside as f64 / (GRID * GRID) as f64
    }

    /// The axis along which the border crosses every line at most once, always from the same side; of two such axes, the one with more crossings.
    pub(super) fn height(&self) -> Option<usize> {
        let of_axis = [0, 1].map(|along| {
            self.crossings(along).filter(|_| !self.follows_border_function() || self.is_monotone(along))
        });
        match of_axis {
            [Some(u), Some(v)] if u == v => Some(usize::from(self.steepness(1) > self.steepness(0))),
            [Some(u), Some(v)] => Some(usize::from(v > u)),
            [Some(_), None] => Some(0),
            [None, Some(_)] => Some(1),
            [None, None] => None,
        }
    }

    /// Whether the border is that of one smooth function, without shadow, trimming and corner.
    pub(super) fn is_smooth(&self) -> bool {
        let branch = self.grid[0][0].branch;
        self.samples().all(|sample| sample.is_inside() == (sample.border > 0.0) && sample.branch == branch)
    }

    /// Whether the border function defines the border, at least in part.
    fn follows_border_function(&self) -> bool {
        self.samples().any(|sample| sample.border <= 0.0)
    }

    /// Whether the border function is monotone along an axis; otherwise the border may turn back between two samples.
    fn is_monotone(&self, along: usize) -> bool {
        let changes = || self.changes(along).filter(|change| change.is_finite());
        let most = changes().fold(0.0, |most: f64, change| most.max(change.abs()));
        // The rounding error of a border along the axis has no sign.
        let least = 1e-9 * most;
        changes().all(|change| change >= -least) || changes().all(|change| change <= least)
    }

    /// Number of lines along an axis that the border crosses; `None` if it crosses one more than once, or lines from different sides.
    fn crossings(&self, along: usize) -> Option<usize> {
        let inner = (1..GRID - 1).map(|j| {
            let line =
                (0..GRID).map(|i| if along == 0 { self.is_inside(i, j) } else { self.is_inside(j, i) });
            line.collect::<Vec<bool>>()
        });
        let sides = self.sides[along]
            .iter()
            .map(|(_, samples)| samples.iter().map(LineSample::is_inside).collect::<Vec<bool>>());
        let (mut count, mut rises) = (0, None);
        for line in inner.chain(sides) {
            let mut changes = line.windows(2).filter(|pair| pair[0] != pair[1]);
            let Some(change) = changes.next() else { continue };
            let rise = change[1];
            if changes.next().is_some() || rises.is_some_and(|other| other != rise) {
                return None;
            }
            rises = Some(rise);
            count += 1;
        }
        Some(count)
    }

    /// Change of the border function along an axis.
    fn steepness(&self, along: usize) -> f64 {
        self.changes(along).map(f64::abs).filter(|change| change.is_finite()).sum()
    }

    /// Differences of the border function between neighbours along an axis.
    fn changes(&self, along: usize) -> impl Iterator<Item = f64> + '_ {
        let border = move |i: usize, j: usize| {
            if along == 0 { self.grid[j][i].border } else { self.grid[i][j].border }
        };
        let pairs = (0..GRID - 1).flat_map(|i| (0..GRID).map(move |j| (i, j)));
        pairs.map(move |(i, j)| border(i + 1, j) - border(i, j))
    }

    /// Crossings of the border with the two sides along an axis.
    pub(super) fn stops<R: Region<Sample = S>>(&self, region: &R, along: usize) -> Vec<f64> {
        let mut stops = Vec::new();
        for (line, samples) in &self.sides[along] {
            for pair in samples.windows(2) {
                match pair {
                    [a, b] if a.is_inside() && !b.is_inside() => stops.push(root(region, line, a, b)),
                    [a, b] if b.is_inside() && !a.is_inside() => stops.push(root(region, line, b, a)),
                    _ => {}
                }
            }
        }
        stops
    }
}
