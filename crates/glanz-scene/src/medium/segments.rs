//! Parts of rays in media.

use glanz_math::{DVec3, Ray};

/// A part of a ray in a medium.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MediumSegment {
    /// Ray parameter at its start.
    pub start: f64,
    /// Ray parameter at its end; may be infinite in a homogeneous medium.
    pub end: f64,
    /// A bound on the density in it, above 0.
    pub density: f32,
}

/// The parts of a ray in a medium one after the other, from its start on.
#[derive(Clone, Debug)]
pub struct MediumSegments<'a> {
    /// Ray parameters between which segments are left.
    t: f64,
    end: f64,
    /// `None` in a homogeneous medium.
    cells: Option<CellTraversal<'a>>,
}

/// A traversal of the cells of a grid over [0, 1]^3 along a ray.
///
/// # Source
/// @amanatides1987; @pharr2023 section 11.4.3 (`DDAMajorantIterator`).
#[derive(Clone, Debug)]
struct CellTraversal<'a> {
    /// Cells along each axis.
    count: usize,
    densities: &'a [f32],
    cell: [usize; 3],
    /// Ray parameters at which the next cell along each axis begins, and their steps.
    next: [f64; 3],
    step: [f64; 3],
    is_descending: [bool; 3],
}

impl<'a> MediumSegments<'a> {
    /// The whole ray up to `t_max`, with density 1.
    pub(super) fn homogeneous(t_max: f64) -> Self {
        Self { t: 0.0, end: t_max, cells: None }
    }

    /// The part of a ray in [0, 1]^3, of which `count`^3 cells have bounds `densities`, x fastest.
    pub(super) fn through_cells(ray: &Ray, t_max: f64, count: usize, densities: &'a [f32]) -> Self {
        let (mut t, mut end) = (0.0_f64, t_max);
        for axis in 0..3 {
            let (origin, direction) = (ray.origin[axis], ray.direction[axis]);
            let (a, b) = (-origin / direction, (1.0 - origin) / direction);
            if direction != 0.0 {
                (t, end) = (t.max(a.min(b)), end.min(a.max(b)));
            } else if !(0.0..=1.0).contains(&origin) {
                end = t;
            }
        }
        let start = ray.at(t);
        let axis_state = |axis: usize| {
            let (place, direction) = (start[axis] * count as f64, ray.direction[axis]);
            // Negative places become 0.
            let cell = (place as usize).min(count - 1);
            let is_descending = direction < 0.0;
            let border = (cell + usize::from(!is_descending)) as f64 / count as f64;
            if direction == 0.0 {
                return (cell, f64::INFINITY, f64::INFINITY, false);
            }
            let next = (border - ray.origin[axis]) / direction;
            (cell, next, 1.0 / (count as f64 * direction.abs()), is_descending)
        };
        let axes = [0, 1, 2].map(axis_state);
        let cells = CellTraversal {
            count,
            densities,
            cell: axes.map(|axis| axis.0),
            next: axes.map(|axis| axis.1),
            step: axes.map(|axis| axis.2),
            is_descending: axes.map(|axis| axis.3),
        };
        Self { t, end, cells: Some(cells) }
    }
}

impl CellTraversal<'_> {
    /// The bound of the current cell and the parameter at which it ends.
    fn current(&self) -> (f32, f64) {
        let [x, y, z] = self.cell;
        let density = self.densities[(z * self.count + y) * self.count + x];
        (density, DVec3::from(self.next).min_element())
    }

    /// Advances to the next cell; returns `false` outside the grid.
    fn advance(&mut self) -> bool {
        let [x, y, z] = self.next;
        let axis = if x <= y && x <= z {
            0
        } else if y <= z {
            1
        } else {
            2
        };
        self.next[axis] += self.step[axis];
        let cell = &mut self.cell[axis];
        match if self.is_descending[axis] { cell.checked_sub(1) } else { Some(*cell + 1) } {
            Some(next) if next < self.count => *cell = next,
            _ => return false,
        }
        true
    }
}

impl Iterator for MediumSegments<'_> {
    type Item = MediumSegment;

    fn next(&mut self) -> Option<MediumSegment> {
        while self.t < self.end {
            let start = self.t;
            let Some(cells) = &mut self.cells else {
                self.t = self.end;
                return Some(MediumSegment { start, end: self.end, density: 1.0 });
            };
            let (density, border) = cells.current();
            // Roundings must not lead back.
            let end = border.clamp(start, self.end);
            self.t = if cells.advance() { end } else { self.end };
            if density > 0.0 && start < end {
                return Some(MediumSegment { start, end, density });
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use glanz_sampling::hash::{combine, unit_f64};

    use super::*;

    /// Cells numbered by densities.
    fn numbered(count: usize) -> Vec<f32> {
        (0..count.pow(3)).map(|i| 1.0 + i as f32).collect()
    }

    fn cell_at(p: DVec3, count: usize) -> f32 {
        let [x, y, z] = (p * count as f64).floor().to_array().map(|x| (x.max(0.0) as usize).min(count - 1));
        1.0 + ((z * count + y) * count + x) as f32
    }

    #[test]
    fn segments_cover_the_ray_in_the_box_with_the_cells_that_it_passes() {
        let count = 4;
        let densities = numbered(count);
        for i in 0..2000 {
            let number = |k| unit_f64(combine(k, i));
            let origin = DVec3::new(number(1), number(2), number(3)) * 3.0 - 1.0;
            let mut direction = DVec3::new(number(4), number(5), number(6)) - 0.5;
            direction[(i % 4).min(2) as usize] *= f64::from(u8::from(i % 4 != 3));
            let ray = Ray::new(origin, direction);
            let t_max = 4.0 * number(7);
            let segments: Vec<_> = MediumSegments::through_cells(&ray, t_max, count, &densities).collect();
            for pair in segments.windows(2) {
                assert_eq!(pair[0].end, pair[1].start, "ray {i}");
            }
            for segment in &segments {
                let middle = ray.at(0.5 * (segment.start + segment.end));
                // Too short ones may lie on a border.
                assert!(
                    segment.end - segment.start < 1e-9 || segment.density == cell_at(middle, count),
                    "ray {i}"
                );
            }
            let length: f64 = segments.iter().map(|s| s.end - s.start).sum();
            let steps = 20_000;
            let inside = (0..steps).filter(|&k| {
                let p = ray.at((f64::from(k) + 0.5) * t_max / f64::from(steps));
                p.cmpge(DVec3::ZERO).all() && p.cmple(DVec3::ONE).all()
            });
            let expected = inside.count() as f64 * t_max / f64::from(steps);
            assert!(
                (length - expected).abs() <= 2.0 * t_max / f64::from(steps),
                "ray {i}: {length} {expected}"
            );
        }
    }

    #[test]
    fn empty_cells_are_skipped_and_a_homogeneous_medium_is_one_segment() {
        let mut densities = vec![0.0; 8];
        densities[1] = 2.0;
        let ray = Ray::new(DVec3::new(-1.0, 0.25, 0.25), DVec3::X);
        let segments: Vec<_> = MediumSegments::through_cells(&ray, f64::INFINITY, 2, &densities).collect();
        assert_eq!(segments, [MediumSegment { start: 1.5, end: 2.0, density: 2.0 }]);
        let whole: Vec<_> = MediumSegments::homogeneous(f64::INFINITY).collect();
        assert_eq!(whole, [MediumSegment { start: 0.0, end: f64::INFINITY, density: 1.0 }]);
    }
}
