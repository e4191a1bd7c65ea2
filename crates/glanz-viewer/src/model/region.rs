//! The trimming region as a grid of cells, each with the few curve segments near it.

use glanz_geometry::trim::TrimRegion;
use glanz_math::{DVec2, DVec3};

use super::blocks::Blocks;
use super::error::{ModelError, number};
use super::head;

/// Cells along a side.
const CELLS: std::ops::RangeInclusive<usize> = 4..=256;

/// A cell lists the parts within this distance of it, in sizes of the cell, and those within whose width it is.
const MARGIN: f64 = 0.05;

/// Number of bisections for a point of a curve: down to rounding.
const HALVINGS: u32 = 60;

/// Added to winding numbers, so that they are not negative.
const WINDING_OFFSET: i32 = 128;

/// A part of a curve, monotone in both coordinates, over the unit square.
struct RegionPart {
    /// Homogeneous control points.
    points: Vec<DVec3>,
    /// The same times their binomials.
    terms: Vec<DVec3>,
    start: DVec2,
    end: DVec2,
    /// Smallest and largest v, as the shader has them: parts that meet there agree on them to the bit.
    rows: [f32; 2],
    /// +1 if v ascends along it, else -1.
    direction: i32,
    /// Points within an ellipse of these half axes around one of its points are kept: its width along u and along v.
    width: DVec2,
}

/// From one height (included) to another (not included), possibly none.
type Heights = [f32; 2];

/// A region over the unit square with its cells.
pub(super) struct Grid {
    parts: Vec<RegionPart>,
    outermost: i32,
    /// Along each side.
    cells: usize,
    domain: [DVec2; 2],
}

/// Intersection of a monotone curve segment with a column of cells.
struct Crossing {
    part: usize,
    /// Heights at which it is left of the right side and not left of the left side.
    inside: Heights,
    /// Heights between which points of the column may be near it or within its width.
    near: [f64; 2],
}

impl RegionPart {
    /// Horner's rule with powers of `t` and `1 - t`.
    ///
    /// # Source
    /// @farin2002 chapter 5.
    fn point(&self, t: f64) -> DVec2 {
        let (mut sum, mut power) = (DVec3::ZERO, 1.0);
        for &term in &self.terms {
            sum = sum * (1.0 - t) + term * power;
            power *= t;
        }
        sum.truncate() / sum.z
    }

    /// The height at which it passes `u`, the lowest or highest one beyond its ends.
    fn height(&self, u: f64) -> f64 {
        let (low, high) = (self.start.x.min(self.end.x), self.start.x.max(self.end.x));
        let (at_low, at_high) =
            if self.start.x <= self.end.x { (self.start.y, self.end.y) } else { (self.end.y, self.start.y) };
        if u <= low {
            return at_low;
        }
        if u >= high {
            return at_high;
        }
        let ascends = self.start.x < self.end.x;
        let (mut before, mut after) = (0.0, 1.0);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (before + after);
            if (self.point(middle).x < u) == ascends {
                before = middle;
            } else {
                after = middle;
            }
        }
        self.point(0.5 * (before + after)).y.clamp(self.start.y.min(self.end.y), self.start.y.max(self.end.y))
    }

    /// Heights at which it is right of the line at `u`, and at which it is not.
    fn sides(&self, u: f64) -> (Heights, Heights) {
        let [low, high] = self.rows;
        let (left, right) = (self.start.x.min(self.end.x), self.start.x.max(self.end.x));
        let none = [low, low];
        if left > u {
            return (self.rows, none);
        }
        if right <= u {
            return (none, self.rows);
        }
        let height = (self.height(u) as f32).clamp(low, high);
        // True if u grows with v.
        if (self.end.x > self.start.x) == (self.end.y > self.start.y) {
            ([height, high], [low, height])
        } else {
            ([low, height], [height, high])
        }
    }
}

impl Grid {
    /// The cells of a region; about as many as it has parts, so that each lists few.
    pub(super) fn of(region: &TrimRegion) -> Self {
        let [min, max] = region.domain();
        let scaled = |p: DVec2| (p - min) / (max - min);
        let parts: Vec<RegionPart> = region
            .monotone_pieces()
            .map(|piece| {
                let (start, end) = (scaled(piece.start), scaled(piece.end));
                let inner = |p: &DVec3| (scaled(p.truncate() / p.z) * p.z).extend(p.z);
                let mut points: Vec<DVec3> = piece.control_points.iter().map(inner).collect();
                // Exactly the start of the next segment.
                for (slot, place) in [(0, start), (points.len().saturating_sub(1), end)] {
                    if let Some(point) = points.get_mut(slot) {
                        *point = (place * point.z).extend(point.z);
                    }
                }
                let rows = [start.y.min(end.y) as f32, start.y.max(end.y) as f32];
                let terms = points.iter().zip(binomials(points.len())).map(|(p, b)| *p * b).collect();
                RegionPart {
                    points,
                    terms,
                    start,
                    end,
                    rows,
                    direction: if end.y > start.y { 1 } else { -1 },
                    width: piece.width / (region.scale() * (max - min)),
                }
            })
            .collect();
        let cells = ((2.0 * parts.len() as f64).sqrt() as usize).next_power_of_two();
        let cells = cells.clamp(*CELLS.start(), *CELLS.end());
        Self { parts, outermost: region.outermost(), cells, domain: [min, max] }
    }

    /// Adds the region to the blocks.
    ///
    /// # Errors
    /// [`ModelError::TooMany`] parts or points.
    pub(super) fn add_to(&self, blocks: &mut Blocks) -> Result<head::ModelRegion, ModelError> {
        let first_part = blocks.region_parts.len();
        self.add_parts(blocks)?;
        let first_cell = blocks.region_cells.len();
        blocks.region_cells.resize(first_cell + self.cells * self.cells, [0; 4]);
        for column in 0..self.cells {
            self.add_column(blocks, column, first_cell, first_part)?;
        }
        let [min, max] = self.domain.map(|p| p.to_array());
        Ok(head::ModelRegion { cells: [self.cells; 2], first_cell, min, max })
    }

    fn add_parts(&self, blocks: &mut Blocks) -> Result<(), ModelError> {
        for part in &self.parts {
            let first = exact("points of trimming curves", blocks.region_points.len())?;
            let (low, high) = (part.start.min(part.end), part.start.max(part.end));
            let degree = part.points.len().saturating_sub(1) as f32;
            let [bottom, top] = part.rows;
            let [width_u, width_v] = part.width.to_array().map(|width| width as f32);
            let row = [low.x as f32, bottom, high.x as f32, top, first, degree, width_u, width_v];
            blocks.region_parts.push(row);
            blocks
                .region_points
                .extend(part.points.iter().map(|p| [p.x as f32, p.y as f32, p.z as f32, 0.0]));
        }
        exact("parts of trimming curves", blocks.region_parts.len()).map(|_| ())
    }

    /// Side of cells.
    fn side(&self) -> f64 {
        1.0 / self.cells as f64
    }

    fn crossings(&self, column: usize) -> Vec<Crossing> {
        // Powers of two: exact.
        let (left, right) = (column as f64 * self.side(), (column + 1) as f64 * self.side());
        let margin = |part: &RegionPart| part.width.max(DVec2::splat(MARGIN * self.side()));
        let near = |part: &RegionPart| {
            let (low, high) = (part.start.x.min(part.end.x), part.start.x.max(part.end.x));
            let margin = margin(part).x;
            low <= right + margin && high >= left - margin
        };
        let crossing = |(number, part): (usize, &RegionPart)| {
            let (_, inside) = part.sides(right);
            // The last column has what is left of it in points of the domain only.
            let (beyond, _) = part.sides(left);
            let margin = margin(part);
            let (a, b) = (part.height(left - margin.x), part.height(right + margin.x));
            Crossing {
                part: number,
                inside: [inside[0].max(beyond[0]), inside[1].min(beyond[1])],
                near: [a.min(b) - margin.y, a.max(b) + margin.y],
            }
        };
        self.parts.iter().enumerate().filter(|(_, part)| near(part)).map(crossing).collect()
    }

    /// Winding number along the right side of a column: at the bottom, far down, and its changes by ascending height.
    fn changes(&self, column: usize) -> Vec<(f32, i32)> {
        let right = (column + 1) as f64 * self.side();
        let mut changes: Vec<(f32, i32)> = Vec::new();
        for part in &self.parts {
            let ([low, high], _) = part.sides(right);
            if low < high {
                changes.extend([(low, part.direction), (high, -part.direction)]);
            }
        }
        changes.sort_by(|a, b| a.0.total_cmp(&b.0));
        // The winding number does not change where one segment ends and the next begins.
        let runs = changes.chunk_by(|a, b| a.0 == b.0);
        let sums = runs.filter_map(|run| Some((run.first()?.0, run.iter().map(|c| c.1).sum::<i32>())));
        sums.filter(|&(_, change)| change != 0).collect()
    }

    fn add_column(
        &self,
        blocks: &mut Blocks,
        column: usize,
        first_cell: usize,
        first_part: usize,
    ) -> Result<(), ModelError> {
        let (crossings, changes) = (self.crossings(column), self.changes(column));
        let mut rows: Vec<Vec<&Crossing>> = vec![Vec::new(); self.cells];
        for crossing in &crossings {
            let row = |v: f64| (v / self.side()).floor().clamp(0.0, (self.cells - 1) as f64) as usize;
            let [low, high] = crossing.near;
            if high >= 0.0 && low <= 1.0 {
                let rows = rows.get_mut(row(low)..=row(high)).unwrap_or_default();
                rows.iter_mut().for_each(|row| row.push(crossing));
            }
        }
        let (mut winding, mut next) = (self.outermost, 0);
        for (row, near) in rows.into_iter().enumerate() {
            let (bottom, top) = ((row as f64 * self.side()) as f32, ((row + 1) as f64 * self.side()) as f32);
            while let Some(&(_, change)) = changes.get(next).filter(|(v, _)| *v <= bottom) {
                winding += change;
                next += 1;
            }
            let last = row + 1 == self.cells;
            let steps = changes.get(next..).unwrap_or_default();
            let steps = steps.iter().take_while(|(v, _)| *v < top || (last && *v == top));
            let (first_entry, first_step) = (blocks.region_entries.len(), blocks.region_steps.len());
            for crossing in near {
                let Some(part) = self.parts.get(crossing.part) else { continue };
                let [low, high] = crossing.inside;
                let number = exact("parts of trimming curves", first_part + crossing.part)?;
                // It does not cross these rows: an empty range, for every v of the shader.
                let counts = low < high && low <= top && high > bottom;
                let [low, high] = if counts { [low, high] } else { [0.0; 2] };
                blocks.region_entries.push([number, low, high, part.direction as f32]);
            }
            blocks.region_steps.extend(steps.map(|&(v, change)| [v, change as f32]));
            let winding = (winding + WINDING_OFFSET).clamp(0, 2 * WINDING_OFFSET - 1) as u32;
            let steps = number("steps of a cell", blocks.region_steps.len() - first_step)?;
            if let Some(cell) = blocks.region_cells.get_mut(first_cell + row * self.cells + column) {
                *cell = [
                    number("entries of cells", first_entry)?,
                    number("entries of a cell", blocks.region_entries.len() - first_entry)?,
                    number("steps of cells", first_step)?,
                    steps.min(0xffff) | (winding << 16),
                ];
            }
        }
        Ok(())
    }
}

/// The binomials of the degree `count - 1`.
fn binomials(count: usize) -> impl Iterator<Item = f64> {
    let next = move |b: f64, k: usize| b * (count - 1 - k) as f64 / (k + 1) as f64;
    (0..count).scan(1.0, move |b, k| {
        let this = *b;
        *b = next(this, k);
        Some(this)
    })
}

/// `count` as a single-precision number, which is exact up to 2^24.
fn exact(what: &'static str, count: usize) -> Result<f32, ModelError> {
    const MOST: u64 = 1 << f32::MANTISSA_DIGITS;
    let count = count as u64;
    if count <= MOST { Ok(count as f32) } else { Err(ModelError::TooMany { what, count, most: MOST }) }
}
