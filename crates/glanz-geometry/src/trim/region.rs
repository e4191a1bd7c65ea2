//! The trimmed region of a parameter domain.

use glanz_math::{DVec2, DVec3};

use super::cell_tree::{CellLookup, CellTree};
use super::curve::{TrimCurve, check_range};
use super::loops::TrimLoop;
use super::monotone::MonotonePiece;
use super::piece_table::PieceTable;
use crate::error::{SurfaceError, not_negative, positive};
use crate::hit::HitBorder;

/// Largest gap between consecutive curves of a loop, relative to the extent of all loops: coordinates are often written
/// with seven digits.
const LOOP_GAP: f64 = 1e-6;

/// Width of curves without one of their own, relative to the extent of all loops: the parameters of one point may
/// differ by this much in two faces that meet in the curve.
const WIDTH: f64 = 1e-9;

/// Width of the domain around the loops, relative to their extent.
const DOMAIN_MARGIN: f64 = 0.1;

/// Relation of a rectangle to a region.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Containment {
    /// The whole rectangle is kept.
    Inside,
    /// The whole rectangle is cut away.
    Outside,
    /// A curve crosses it, or comes so near that it might.
    Crossed,
}

/// Location of a point relative to a region.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RegionLocation {
    /// Kept, farther from every curve than its width.
    Inside,
    /// On a curve, or within the width of one on the kept side.
    InnerBorder,
    /// Kept since it is within the width of a curve, which cuts it away.
    OuterBorder,
    /// Cut away.
    Outside,
}

impl RegionLocation {
    /// The border in which a kept point lies; `None` if it is cut away.
    #[inline]
    #[must_use]
    pub fn border(self) -> Option<HitBorder> {
        match self {
            Self::Inside => Some(HitBorder::Away),
            Self::InnerBorder => Some(HitBorder::Inner),
            Self::OuterBorder => Some(HitBorder::Outer),
            Self::Outside => None,
        }
    }
}

/// Coordinates and domain of a region.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RegionSettings {
    /// Factors, > 0, from the parameters of the surface to the coordinates of the region, in which distances from curves are
    /// measured: with metres per unit of u and of v, widths are metres.
    pub scale: DVec2,
    /// Corners of the domain in the parameters of the surface; `None`: a box around the curves, widened by a tenth of its longer side.
    pub domain: Option<[DVec2; 2]>,
}

impl Default for RegionSettings {
    /// The parameters of the surface, and a box around the curves.
    fn default() -> Self {
        Self { scale: DVec2::ONE, domain: None }
    }
}

/// The part of a rectangular parameter domain on the left of closed loops.
///
/// A point is kept if its winding number is greater than zero. The winding number counts how often the loops go round the point
/// counter-clockwise; 1 is added everywhere if the domain itself is the outermost material: if the loop of the largest area
/// runs clockwise, or if there are no loops. Holes, islands and islands in holes follow from this rule. For loops that do not
/// alternate (a counter-clockwise loop directly inside another, a hole in a hole) winding numbers add up: points inside both
/// counter-clockwise loops are kept, and a doubly cut hole needs two islands to be filled. Points on a curve, and within its width,
/// are always kept, so that two faces with a common border leave no gap.
///
/// # Source
/// @markgraf2019 section 4.3; departure: the winding number, which handles both orientations and nesting, instead of
/// "trimmed if the sum is 1".
#[derive(Clone, Debug)]
pub struct TrimRegion {
    pieces: PieceTable,
    cells: CellTree,
    /// Corners, times the scale.
    domain: [DVec2; 2],
    /// From parameters to coordinates of pieces and cells.
    scale: DVec2,
    /// Winding number far outside.
    outermost: i32,
    /// See [`TrimRegion::max_width`].
    max_width: f64,
}

/// Closed loops of curves in the coordinates of a region, and the corners of its domain.
fn joined(
    loops: Vec<Vec<TrimCurve>>,
    settings: RegionSettings,
) -> Result<(Vec<TrimLoop>, [DVec2; 2]), SurfaceError> {
    if loops.iter().all(Vec::is_empty) {
        return Err(SurfaceError::TooFew { parameter: "trimming curves", count: 0, min: 1 });
    }
    let RegionSettings { scale, domain } = settings;
    for factor in scale.to_array() {
        positive("scale of a trimming region", factor)?;
    }
    let scaled = |curves: Vec<TrimCurve>| curves.into_iter().map(|curve| curve.scaled(scale)).collect();
    let loops: Vec<Vec<TrimCurve>> = loops.into_iter().map(scaled).collect();
    let [low, high] = loops
        .iter()
        .flatten()
        .map(|curve| curve.bounds)
        .fold([DVec2::INFINITY, DVec2::NEG_INFINITY], |[a, b], [low, high]| [a.min(low), b.max(high)]);
    let extent = (high - low).max_element();
    let margin = DVec2::splat(DOMAIN_MARGIN * extent);
    let domain = domain.map_or([low - margin, high + margin], |corners| corners.map(|p| p * scale));
    let trim_loop = |curves| TrimLoop::with_default_width(curves, LOOP_GAP * extent, WIDTH * extent);
    let loops: Vec<TrimLoop> = loops.into_iter().map(trim_loop).collect::<Result<_, _>>()?;
    Ok((loops, domain))
}

impl TrimRegion {
    /// The region that `loops` keep of the domain from `domain[0]` to `domain[1]`.
    ///
    /// Loops may leave the domain. Without loops, the whole domain is kept.
    ///
    /// # Errors
    /// [`SurfaceError::NotFinite`], [`SurfaceError::EmptyRange`] for the domain, [`SurfaceError::TooMany`] from 2^30 control
    /// points on.
    pub fn try_new(loops: Vec<TrimLoop>, domain: [DVec2; 2]) -> Result<Self, SurfaceError> {
        Self::with_scale(loops, domain, DVec2::ONE)
    }

    /// The region of [`TrimRegion::try_new`], of parameters times `scale`.
    fn with_scale(loops: Vec<TrimLoop>, domain: [DVec2; 2], scale: DVec2) -> Result<Self, SurfaceError> {
        let [min, max] = domain;
        check_range("domain", min, max)?;
        let largest = loops.iter().fold(0.0, |largest: f64, trim_loop| {
            // The bound is the area of a rectangle, with another rounding.
            if trim_loop.area_bound() * (1.0 + 1e-9) <= largest.abs() {
                return largest;
            }
            let area = trim_loop.approximate_area();
            if area.abs() > largest.abs() { area } else { largest }
        });
        let outermost = i32::from(loops.is_empty() || largest < 0.0);
        let pieces = PieceTable::try_new(&loops, min.abs().max(max.abs()))?;
        let cells = CellTree::try_new(&pieces, domain, outermost)?;
        let max_width = pieces.max_width();
        Ok(Self { pieces, cells, domain, scale, outermost, max_width })
    }

    /// The region that loops of curves keep, with tolerances in proportion to their extent.
    ///
    /// [`TrimRegion::try_with_settings`] in the parameters of the surface and with the domain that follows from the curves: what
    /// lies beyond is kept or not as the nearest point of the box is.
    ///
    /// # Errors
    /// Those of [`TrimRegion::try_with_settings`].
    pub fn try_from_curves(loops: Vec<Vec<TrimCurve>>) -> Result<Self, SurfaceError> {
        Self::try_with_settings(loops, RegionSettings::default())
    }

    /// The region that loops of curves, in the parameters of the surface, keep.
    ///
    /// The extent is the longer side of a box around all control points, times the scale. Consecutive curves may end and start 1e-6 of
    /// it apart, or as far as their widths together; the width of a curve is its own ([`TrimCurve::with_width`]) or 1e-9 of the extent.
    ///
    /// # Errors
    /// [`SurfaceError::TooFew`] without curves, [`SurfaceError::OpenLoop`], [`SurfaceError::CollapsedLoop`],
    /// [`SurfaceError::NotPositive`] for the scale, [`SurfaceError::NotFinite`], and those of [`TrimRegion::try_new`].
    pub fn try_with_settings(
        loops: Vec<Vec<TrimCurve>>,
        settings: RegionSettings,
    ) -> Result<Self, SurfaceError> {
        let scale = settings.scale;
        let (loops, domain) = joined(loops, settings)?;
        Self::with_scale(loops, domain, scale)
    }

    /// Checks what [`TrimRegion::try_with_settings`] checks of curves, without the tree that takes most of its time.
    ///
    /// # Errors
    /// Those of [`TrimRegion::try_with_settings`] but [`SurfaceError::TooMany`].
    pub fn check(loops: Vec<Vec<TrimCurve>>, settings: RegionSettings) -> Result<(), SurfaceError> {
        let (_, [min, max]) = joined(loops, settings)?;
        check_range("domain", min, max)
    }

    /// The region extended by all points within `tolerance` of a curve, in its coordinates.
    ///
    /// # Errors
    /// [`SurfaceError::NotFinite`], [`SurfaceError::Negative`], [`SurfaceError::TooMany`].
    pub fn with_widened_border(mut self, tolerance: f64) -> Result<Self, SurfaceError> {
        let width = not_negative("tolerance of the border", tolerance)?;
        for piece in &mut self.pieces.pieces {
            piece.width = piece.width.max(width);
        }
        let cells = CellTree::try_new(&self.pieces, self.domain, self.outermost)?;
        let max_width = self.pieces.max_width();
        Ok(Self { cells, max_width, ..self })
    }

    /// Whether the point `uv` is kept; exact except for points within rounding of a curve, which are kept.
    ///
    /// A point outside the domain, where rounding may put a hit, is clamped to it. NaN is not kept.
    #[inline]
    #[must_use]
    pub fn contains(&self, uv: DVec2) -> bool {
        self.locate(uv) != RegionLocation::Outside
    }

    /// The location of the point `uv`, as for [`TrimRegion::contains`].
    #[inline]
    #[must_use]
    pub fn locate(&self, uv: DVec2) -> RegionLocation {
        if uv.is_nan() {
            return RegionLocation::Outside;
        }
        let p = (uv * self.scale).max(self.domain[0]).min(self.domain[1]);
        match self.cells.find(p) {
            CellLookup::Uniform(true) => RegionLocation::Inside,
            CellLookup::Uniform(false) => RegionLocation::Outside,
            CellLookup::Crossed(leaf) => self.pieces.locate(leaf, self.cells.entries(leaf), p),
        }
    }

    /// The relation of the rectangle from `min` to `max`, clamped to the domain, to the region.
    ///
    /// `Inside` and `Outside` are certain, and no point of such a rectangle is in a border. A rectangle with NaN, or with `min` greater
    /// than `max`, is `Crossed`.
    #[must_use]
    pub fn classify(&self, min: DVec2, max: DVec2) -> Containment {
        if !min.cmple(max).all() {
            return Containment::Crossed;
        }
        let [low, high] = self.domain;
        let [min, max] = [min, max].map(|corner| (corner * self.scale).clamp(low, high));
        let meets = |i: u32| {
            let piece = self.pieces.pieces.get(i as usize);
            piece.is_some_and(|piece| self.pieces.touches(piece, min, max))
        };
        if self.cells.any_piece(min, max, meets) {
            Containment::Crossed
        } else if self.contains((0.5 * min + 0.5 * max) / self.scale) {
            Containment::Inside
        } else {
            Containment::Outside
        }
    }

    /// Corners of the domain, in the parameters of the surface.
    #[must_use]
    pub fn domain(&self) -> [DVec2; 2] {
        self.domain.map(|corner| corner / self.scale)
    }

    /// The winding number far outside.
    #[must_use]
    pub fn outermost(&self) -> i32 {
        self.outermost
    }

    /// The curves of all loops in the parameters of the surface, split into pieces monotone in u and in v; each ends, to the bit, where
    /// the next of its loop starts.
    pub fn monotone_pieces(&self) -> impl ExactSizeIterator<Item = MonotonePiece> + '_ {
        let per_scale = |p: DVec3| (p.truncate() / self.scale).extend(p.z);
        self.pieces.pieces.iter().map(move |piece| MonotonePiece {
            start: piece.start / self.scale,
            end: piece.end / self.scale,
            control_points: self.pieces.control_points(piece).into_iter().map(per_scale).collect(),
            width: piece.width,
        })
    }

    /// The largest width of a curve, in the coordinates of the region.
    #[must_use]
    pub fn max_width(&self) -> f64 {
        self.max_width
    }

    /// The largest width in space, metres, of the borders in which a point lies, 0 if it lies in none. `derivatives`: of the surface by u and v,
    /// metres.
    #[must_use]
    pub fn border_width(&self, uv: DVec2, [du, dv]: [DVec3; 2]) -> f64 {
        let p = (uv * self.scale).max(self.domain[0]).min(self.domain[1]);
        match self.cells.find(p) {
            CellLookup::Uniform(_) => 0.0,
            CellLookup::Crossed(leaf) => {
                let derivatives = [du / self.scale.x, dv / self.scale.y];
                self.pieces.border_width(self.cells.entries(leaf), p, derivatives)
            }
        }
    }

    /// Factors from the parameters of the surface to the coordinates of the region; see [`RegionSettings::scale`].
    #[must_use]
    pub fn scale(&self) -> DVec2 {
        self.scale
    }

    /// Numbers of pieces and cells.
    #[must_use]
    pub fn statistics(&self) -> TrimStatistics {
        let (cells, crossed_cells, entries) = self.cells.sizes();
        TrimStatistics { pieces: self.pieces.pieces.len(), cells, crossed_cells, entries }
    }
}

/// Numbers of pieces and cells of a region.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TrimStatistics {
    /// Monotone pieces of curves.
    pub pieces: usize,
    /// Cells of the hierarchy, on all levels.
    pub cells: usize,
    /// Cells that curves cross or come close to.
    pub crossed_cells: usize,
    /// Pieces in crossed cells, counted once per cell.
    pub entries: usize,
}
