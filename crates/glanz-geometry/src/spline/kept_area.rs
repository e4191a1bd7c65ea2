//! The area of the part of a spline surface that trimming curves keep.

use std::cell::Cell;

use super::measure::{AreaEstimate, GAUSS};
use super::surface::NurbsSurface;
use crate::error::{SurfaceError, positive};
use crate::trim::{MonotonePiece, TrimRegion};

/// Deepest halving of strips and of the parts of rows.
const MAX_DEPTH: u32 = 24;

/// Number of area elements after which ranges are not halved any more; they are added with their errors.
const MAX_ELEMENTS: u32 = 1 << 22;

/// How many times more accurate rows are than the whole, so that their errors do not divide strips.
const ROWS: f64 = 8.0;

impl NurbsSurface {
    /// The area of the part that `region` keeps, its curves taken without their widths.
    ///
    /// The domain is divided at inner knots and at the ends of monotone pieces of curves into strips of v, so that no loop is too small to
    /// be seen. Gauss's rule over v adds rows, and over u the area elements between the curves that a row crosses; both are halved until
    /// their sums change by less than `tolerance` (m^2) in all.
    ///
    /// # Errors
    /// [`SurfaceError::NotFinite`] or [`SurfaceError::NotPositive`] for the tolerance. One that cannot be reached is not an error:
    /// see [`AreaEstimate::error`].
    pub fn kept_area(&self, region: &TrimRegion, tolerance: f64) -> Result<AreaEstimate, SurfaceError> {
        positive("tolerance of the area", tolerance)?;
        let [v0, v1] = self.knots_v().domain();
        // Rows have no length along pieces that run along u.
        let mut pieces: Vec<_> =
            region.monotone_pieces().filter(|piece| piece.start.y != piece.end.y).collect();
        let range = |piece: &MonotonePiece| [piece.start.y.min(piece.end.y), piece.start.y.max(piece.end.y)];
        let mut breaks: Vec<f64> = pieces.iter().flat_map(range).filter(|v| (v0..v1).contains(v)).collect();
        breaks.extend(self.knots_v().breaks());
        breaks.sort_by(f64::total_cmp);
        breaks.dedup();
        pieces.sort_by(|a, b| range(b)[0].total_cmp(&range(a)[0]));
        let row_tolerance = tolerance / (ROWS * (v1 - v0));
        let mut rows = TrimmedRows {
            surface: self,
            crossed: Vec::new(),
            outermost: region.outermost(),
            tolerance: row_tolerance,
            elements: Cell::new(0),
        };
        let mut sum = AreaEstimate { value: 0.0, error: 0.0 };
        for strip in breaks.windows(2) {
            let (low, height) = (strip[0], strip[1] - strip[0]);
            rows.crossed.retain(|piece| range(piece)[1] > low);
            while let Some(piece) = pieces.pop_if(|piece| range(piece)[0] <= low) {
                rows.crossed.extend((range(&piece)[1] > low).then_some(piece));
            }
            // v is a smooth step, so that square roots where curves turn become smooth.
            let strip =
                |s: f64| rows.row(low + height * s * s * (3.0 - 2.0 * s)).times(6.0 * height * s * (1.0 - s));
            let rule = |range: [f64; 2]| gauss(range, strip);
            let share = height / (v1 - v0);
            sum = sum.plus(rows.halved(&rule, [0.0, 1.0], rule([0.0, 1.0]), tolerance * share, MAX_DEPTH));
        }
        Ok(sum)
    }
}

/// The integrals over the kept parts of lines v = const.
struct TrimmedRows<'a> {
    surface: &'a NurbsSurface,
    /// The pieces of curves that rows of the strip cross.
    crossed: Vec<MonotonePiece>,
    /// Winding number far outside.
    outermost: i32,
    /// Largest error of a row, m^2 per unit of v.
    tolerance: f64,
    /// Number of area elements so far.
    elements: Cell<u32>,
}

impl TrimmedRows<'_> {
    fn row(&self, v: f64) -> AreaEstimate {
        let mut crossings: Vec<(f64, i32)> = self
            .crossed
            .iter()
            .map(|piece| (crossing(piece, v), if piece.end.y > piece.start.y { -1 } else { 1 }))
            .collect();
        crossings.sort_by(|a, b| a.0.total_cmp(&b.0));
        crossings.push((f64::INFINITY, 0));
        let mut sum = AreaEstimate { value: 0.0, error: 0.0 };
        let (mut from, mut winding) = (f64::NEG_INFINITY, self.outermost);
        for (to, step) in crossings {
            if winding > 0 {
                sum = sum.plus(self.part(v, [from, to]));
            }
            (from, winding) = (to, winding + step);
        }
        sum
    }

    /// The integral over a range of u.
    fn part(&self, v: f64, [from, to]: [f64; 2]) -> AreaEstimate {
        let element = |u: f64| {
            self.elements.set(self.elements.get().saturating_add(1));
            let (_, du, dv) = self.surface.tangents(u, v);
            AreaEstimate { value: du.cross(dv).length(), error: 0.0 }
        };
        let rule = |range: [f64; 2]| gauss(range, element);
        let [u0, u1] = self.surface.knots_u().domain();
        let mut sum = AreaEstimate { value: 0.0, error: 0.0 };
        for span in self.surface.knots_u().breaks().windows(2) {
            let range = [span[0].max(from), span[1].min(to)];
            if range[0] < range[1] {
                let share = (range[1] - range[0]) / (u1 - u0);
                sum = sum.plus(self.halved(&rule, range, rule(range), self.tolerance * share, MAX_DEPTH));
            }
        }
        sum
    }

    /// The integral by `rule`, of which `whole` is that over the range, halved until it changes by at most `tolerance`.
    fn halved(
        &self,
        rule: &impl Fn([f64; 2]) -> AreaEstimate,
        [a, b]: [f64; 2],
        whole: AreaEstimate,
        tolerance: f64,
        depth: u32,
    ) -> AreaEstimate {
        let middle = 0.5 * (a + b);
        let halves = [[a, middle], [middle, b]];
        let [low, high] = halves.map(rule);
        let both = low.plus(high);
        let change = (both.value - whole.value).abs();
        if change > tolerance.max(4.0 * f64::EPSILON * both.value)
            && depth > 0
            && self.elements.get() < MAX_ELEMENTS
        {
            let half = |range, part| self.halved(rule, range, part, 0.5 * tolerance, depth - 1);
            return half(halves[0], low).plus(half(halves[1], high));
        }
        AreaEstimate { value: both.value, error: both.error + change }
    }
}

/// Where a piece crosses a line v = const that lies between its ends.
fn crossing(piece: &MonotonePiece, v: f64) -> f64 {
    let (start, end) = (piece.start, piece.end);
    if piece.control_points.len() == 2 {
        return start.x + (end.x - start.x) * ((v - start.y) / (end.y - start.y));
    }
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..f64::MANTISSA_DIGITS {
        let t = 0.5 * (low + high);
        *(if (piece.point(t).y < v) == (start.y < end.y) { &mut low } else { &mut high }) = t;
    }
    piece.point(0.5 * (low + high)).x
}

/// The integral of `f` by one rule of eight points.
fn gauss([a, b]: [f64; 2], f: impl Fn(f64) -> AreaEstimate) -> AreaEstimate {
    let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
    GAUSS.iter().fold(AreaEstimate { value: 0.0, error: 0.0 }, |sum, &(x, weight)| {
        let pair = f(middle - half * x).plus(f(middle + half * x));
        sum.plus(pair.times(weight * half))
    })
}

impl AreaEstimate {
    fn plus(self, other: Self) -> Self {
        Self { value: self.value + other.value, error: self.error + other.error }
    }

    fn times(self, factor: f64) -> Self {
        Self { value: self.value * factor, error: self.error * factor }
    }
}
