//! Receivers divided by the parameters of their surface.

use glanz_geometry::Surface;
use glanz_geometry::freeform::Freeform;
use glanz_math::{DVec2, DVec3};
use glanz_scene::PlacedSurface;

use super::ReceiverPoint;

/// Gauss's rule with three points on [0, 1].
const NODES: [f64; 3] = [0.112_701_665_379_258_3, 0.5, 0.887_298_334_620_741_7];
const WEIGHTS: [f64; 3] = [5.0 / 18.0, 4.0 / 9.0, 5.0 / 18.0];

/// Parts per side of a cell that is partly trimmed, or whose patches are no rectangles in the parameters.
const PARTS: u32 = 32;

/// Points per direction at which lengths are measured.
const LENGTH_STEPS: u32 = 64;

/// A grid over the rectangle of a surface's parameters (u, v).
#[derive(Clone, Debug)]
pub(super) struct ParameterGrid {
    min: DVec2,
    max: DVec2,
    /// The rectangle of parameters of each face; `None` if a face is no rectangle.
    faces: Option<Vec<[DVec2; 2]>>,
    is_trimmed: bool,
}

impl ParameterGrid {
    /// `None` if the parameters start anew on every face.
    pub(super) fn try_new(placed: &PlacedSurface<'_>) -> Option<Self> {
        let is_trimmed = placed.is_trimmed();
        let unit = [DVec2::ZERO, DVec2::ONE];
        let freeform = |freeform: &Freeform| {
            let corners = |face: u32| -> Option<[DVec2; 4]> {
                let corner = |x, y| freeform.parameters(face, x, y);
                Some([corner(0.0, 0.0)?, corner(1.0, 0.0)?, corner(0.0, 1.0)?, corner(1.0, 1.0)?])
            };
            let all = (0..freeform.patch_count() as u32).filter_map(corners);
            let (mut min, mut max) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
            let mut rectangles = Some(Vec::new());
            for [a, b, c, d] in all {
                for p in [a, b, c, d] {
                    (min, max) = (min.min(p), max.max(p));
                }
                let is_rectangle = a.y == b.y && c.y == d.y && a.x == c.x && b.x == d.x;
                match (&mut rectangles, is_rectangle) {
                    (Some(list), true) => list.push([a, d]),
                    _ => rectangles = None,
                }
            }
            Self { min, max, faces: rectangles, is_trimmed }
        };
        match placed.surface() {
            Surface::Freeform(surface) => Some(freeform(surface)),
            Surface::Trimmed(trimmed) => match trimmed.surface() {
                Surface::Freeform(surface) => Some(freeform(surface)),
                inner if inner.faces() == 1 && !is_facetted(inner) => {
                    Some(Self { min: unit[0], max: unit[1], faces: Some(vec![unit]), is_trimmed })
                }
                _ => None,
            },
            inner if inner.faces() == 1 && !is_facetted(inner) => {
                Some(Self { min: unit[0], max: unit[1], faces: Some(vec![unit]), is_trimmed })
            }
            _ => None,
        }
    }

    /// Whether [`ParameterGrid::place`] finds all of the surface: not if patches share parameters, or are no rectangles in them.
    pub(super) fn has_places(&self) -> bool {
        let area = |[low, high]: &[DVec2; 2]| (*high - *low).element_product();
        let whole = (self.max - self.min).element_product();
        self.faces.as_ref().is_some_and(|faces| faces.iter().map(area).sum::<f64>() <= (1.0 + 1e-9) * whole)
    }

    /// Grid coordinates of parameters, [0, 1]^2.
    pub(super) fn share(&self, uv: DVec2) -> DVec2 {
        ((uv - self.min) / (self.max - self.min)).clamp(DVec2::ZERO, DVec2::ONE)
    }

    /// Position, normal and area per unit of (u, v).
    fn at(&self, surface: &PlacedSurface<'_>, uv: DVec2) -> Option<ReceiverPoint> {
        let faces = self.faces.as_ref()?;
        let inside = |[low, high]: &[DVec2; 2]| uv.cmpge(*low).all() && uv.cmple(*high).all();
        let face = faces.iter().position(inside)?;
        let [low, high] = *faces.get(face)?;
        let found = surface.at(face as u32, (uv - low) / (high - low), false)?;
        let area_element = found.area_element / (high - low).element_product();
        let point = &found.at.point;
        Some(ReceiverPoint { position: point.position, normal: point.normal, area_element })
    }

    pub(super) fn place(
        &self,
        surface: &PlacedSurface<'_>,
        cells: [u32; 2],
        cell: usize,
        at: DVec2,
    ) -> Option<ReceiverPoint> {
        let [nx, ny] = cells.map(|n| n as usize);
        let step = (self.max - self.min) / DVec2::new(nx as f64, ny as f64);
        let uv = self.min + (DVec2::new((cell % nx) as f64, (cell / nx) as f64) + at) * step;
        let found = self.at(surface, uv)?;
        Some(ReceiverPoint { area_element: found.area_element * step.element_product(), ..found })
    }

    /// Lengths of the lines through the middle, metres.
    pub(super) fn size(&self, surface: &PlacedSurface<'_>) -> DVec2 {
        let length = |along: fn(f64) -> DVec2| {
            let points = (0..=LENGTH_STEPS).map(|i| {
                let share = along(f64::from(i) / f64::from(LENGTH_STEPS));
                self.at(surface, self.min + share * (self.max - self.min)).map(|found| found.position)
            });
            let points: Vec<Option<DVec3>> = points.collect();
            let steps = points.windows(2).filter_map(|pair| Some(pair[0]?.distance(pair[1]?)));
            let length: f64 = steps.sum();
            if length > 0.0 { length } else { 1.0 }
        };
        DVec2::new(length(|x| DVec2::new(x, 0.5)), length(|y| DVec2::new(0.5, y)))
    }

    /// Areas and middles of the cells.
    ///
    /// Areas are those of Gauss's rule between the borders of cells and patches; where the surface is trimmed, of midpoints of the
    /// [`PARTS`] times [`PARTS`] parts of a cell; patches that are no rectangles in the parameters are sampled with the same number of parts per cell.
    pub(super) fn measure(&self, surface: &PlacedSurface<'_>, cells: [u32; 2]) -> (Vec<f64>, Vec<DVec3>) {
        let count = cells[0] as usize * cells[1] as usize;
        let mut sums = vec![(0.0, DVec3::ZERO); count];
        let mut add = |cell: usize, area: f64, position: DVec3| {
            if let Some((sum, moment)) = sums.get_mut(cell) {
                *sum += area;
                *moment += area * position;
            }
        };
        match &self.faces {
            Some(faces) => {
                for (face, rectangle) in (0..).zip(faces) {
                    self.measure_rectangle(surface, face, *rectangle, cells, &mut add);
                }
            }
            None => self.measure_askew(surface, cells, &mut add),
        }
        let middle = |(cell, (area, moment)): (usize, &(f64, DVec3))| {
            let center = self.place(surface, cells, cell, DVec2::splat(0.5)).map(|found| found.position);
            center.unwrap_or(if *area > 0.0 { *moment / *area } else { DVec3::ZERO })
        };
        let positions = sums.iter().enumerate().map(middle).collect();
        (sums.iter().map(|(area, _)| *area).collect(), positions)
    }

    fn measure_rectangle(
        &self,
        surface: &PlacedSurface<'_>,
        face: u32,
        [low, high]: [DVec2; 2],
        cells: [u32; 2],
        add: &mut impl FnMut(usize, f64, DVec3),
    ) {
        let across = self.pieces(0, low.x, high.x, cells[0]);
        let up = self.pieces(1, low.y, high.y, cells[1]);
        let parts = if self.is_trimmed { PARTS } else { 1 };
        for (j, v) in &up {
            for (i, u) in &across {
                let (from, to) = (DVec2::new(u[0], v[0]), DVec2::new(u[1], v[1]));
                let cell = j * cells[0] as usize + i;
                for (share, weight) in nodes(parts) {
                    let uv = from + share * (to - from);
                    let local = (uv - low) / (high - low);
                    if let Some(found) = surface.at(face, local, false) {
                        let part = ((to - from) / (high - low)).element_product() * weight;
                        add(cell, found.area_element * part, found.at.point.position);
                    }
                }
            }
        }
    }

    /// Measures faces that are no rectangles by points on them, each of which is assigned to its cell.
    fn measure_askew(
        &self,
        surface: &PlacedSurface<'_>,
        [nx, ny]: [u32; 2],
        add: &mut impl FnMut(usize, f64, DVec3),
    ) {
        let n = PARTS * nx.max(ny);
        for face in 0..surface.faces() {
            for k in 0..n * n {
                let local = (DVec2::new(f64::from(k % n), f64::from(k / n)) + 0.5) / f64::from(n);
                let Some(found) = surface.at(face, local, false) else { continue };
                let share = self.share(found.at.point.uv);
                let (i, j) = ((share.x * f64::from(nx)) as u32, (share.y * f64::from(ny)) as u32);
                let cell = j.min(ny - 1) as usize * nx as usize + i.min(nx - 1) as usize;
                add(cell, found.area_element / f64::from(n * n), found.at.point.position);
            }
        }
    }

    /// The intervals into which the borders of cells divide `low` to `high` along an axis, with the cell of each.
    fn pieces(&self, axis: usize, low: f64, high: f64, cells: u32) -> Vec<(usize, [f64; 2])> {
        let (min, max) = (self.min[axis], self.max[axis]);
        let border = |i: u32| min + (max - min) * (f64::from(i) / f64::from(cells));
        let piece = |i: u32| (i as usize, [border(i).max(low), border(i + 1).min(high)]);
        (0..cells).map(piece).filter(|(_, [from, to])| to > from).collect()
    }
}

/// Points in the unit square with weights that sum to 1: those of Gauss's rule if `parts` is 1, else the middles of `parts` parts per side.
fn nodes(parts: u32) -> Vec<(DVec2, f64)> {
    let grid = |n: u32| (0..n * n).map(move |k| (k % n, k / n));
    if parts == 1 {
        let at = |k: u32| (NODES[k as usize], WEIGHTS[k as usize]);
        return grid(3)
            .map(|(i, j)| {
                let ((x, wx), (y, wy)) = (at(i), at(j));
                (DVec2::new(x, y), wx * wy)
            })
            .collect();
    }
    let n = f64::from(parts);
    grid(parts).map(|(i, j)| ((DVec2::new(f64::from(i), f64::from(j)) + 0.5) / n, 1.0 / (n * n))).collect()
}

/// Whether the parameters of hits are local to a facet.
fn is_facetted(surface: &Surface) -> bool {
    matches!(surface, Surface::Mesh(_) | Surface::Triangle(_) | Surface::Polyhedron(_) | Surface::Cuboid(_))
}
