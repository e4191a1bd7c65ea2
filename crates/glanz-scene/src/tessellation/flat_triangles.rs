//! Triangles without height next to the border of a patch.
//!
//! A triangle between samples of a straight edge, or with two corners beside each other at a pole, covers nothing; the patch beyond the edge often has the
//! same one, so that its long side belongs to four triangles. Flipping that side leaves triangles with a height.

use std::collections::{BTreeSet, HashMap};

use glanz_math::{DVec2, DVec3};

use super::TessellationSettings;
use super::patch::MeshPatch;
use super::shared_edge::distance_to_segment;
use super::triangulation::{MeshSite, height};

/// A triangle is flat if its height is at most these parts of the deviation and of its longest side.
const FLAT: [f64; 2] = [0.1, 0.05];

/// Height over longest side of a triangle that is flat but for rounding: flips between such triangles would not end.
const LINE: f64 = 1e-9;

/// The triangles of a patch, with the sides that they share.
struct SideMap<'a> {
    sites: &'a [MeshSite],
    triangles: &'a mut [[u32; 3]],
    /// The triangle on the left of a side, from corner to corner; `None` for several.
    left: HashMap<[u64; 2], Option<usize>>,
    /// Whether sides were flipped since it was asked.
    has_changed: bool,
}

/// Flips the long sides of flat triangles, where what results is less flat and as close to the surface. Returns the largest distance of new triangles from
/// the surface, metres.
pub(super) fn flip_flat(
    patch: &MeshPatch,
    sites: &[MeshSite],
    triangles: &mut [[u32; 3]],
    settings: TessellationSettings,
) -> f64 {
    let is_flat = |corners: &[DVec3; 3]| {
        height(corners) <= FLAT[0] * settings.deviation && flatness(corners) <= FLAT[1]
    };
    let numbers = (0..triangles.len()).filter(|&i| is_flat(&points_of(sites, &triangles[i])));
    let mut flat: Vec<usize> = numbers.collect();
    let mut deviation = 0.0_f64;
    if flat.is_empty() {
        return deviation;
    }
    let mut map = SideMap { sites, triangles, left: HashMap::new(), has_changed: false };
    (0..map.triangles.len()).for_each(|i| map.add(i));
    // Of a fan of flat triangles, each round flips the outer one; each flip makes the flatter one of two triangles less flat.
    for _ in 0..=flat.len() {
        let mut waiting = BTreeSet::new();
        for number in flat {
            match map.flip(patch, number, settings.deviation) {
                Some((other, distance)) => {
                    deviation = deviation.max(distance);
                    waiting.extend([number, other].into_iter().filter(|&i| is_flat(&map.points(i))));
                }
                None => {
                    waiting.insert(number);
                }
            }
        }
        if !std::mem::take(&mut map.has_changed) {
            break;
        }
        flat = waiting.into_iter().collect();
    }
    deviation
}

/// Height over longest side.
fn flatness(corners: &[DVec3; 3]) -> f64 {
    let [a, b, c] = *corners;
    height(corners) / a.distance(b).max(b.distance(c)).max(c.distance(a)).max(f64::MIN_POSITIVE)
}

fn points_of(sites: &[MeshSite], corners: &[u32; 3]) -> [DVec3; 3] {
    corners.map(|corner| sites.get(corner as usize).map_or(DVec3::NAN, |site| site.point))
}

impl SideMap<'_> {
    fn corners(&self, number: usize) -> [u32; 3] {
        self.triangles.get(number).copied().unwrap_or_default()
    }

    fn points(&self, number: usize) -> [DVec3; 3] {
        points_of(self.sites, &self.corners(number))
    }

    /// What a corner has in common with others at the same point.
    fn key(&self, corner: u32) -> u64 {
        let vertex = self.sites.get(corner as usize).and_then(|site| site.vertex);
        vertex.map_or(u64::from(corner) | 1 << 32, u64::from)
    }

    fn sides(&self, number: usize) -> [[u64; 2]; 3] {
        let [a, b, c] = self.corners(number).map(|corner| self.key(corner));
        [[a, b], [b, c], [c, a]]
    }

    fn add(&mut self, number: usize) {
        for side in self.sides(number) {
            self.left.entry(side).and_modify(|left| *left = None).or_insert(Some(number));
        }
    }

    /// Flips the longest side of a triangle. Returns the other triangle that changed, and the distance of both from the surface.
    fn flip(&mut self, patch: &MeshPatch, number: usize, allowed: f64) -> Option<(usize, f64)> {
        let corners = self.corners(number);
        let at = self.points(number);
        let length = |i: usize| at[i].distance(at[(i + 1) % 3]);
        let longest = (0..3).max_by(|&i, &j| length(i).total_cmp(&length(j)))?;
        let [a, b, tip] = [0, 1, 2].map(|i| corners[(longest + i) % 3]);
        let other = (*self.left.get(&[self.key(b), self.key(a)])?)?;
        let [key_a, key_b] = [a, b].map(|corner| self.key(corner));
        let beyond = self.corners(other);
        let opposite = beyond.into_iter().find(|&corner| ![key_a, key_b].contains(&self.key(corner)))?;
        let ends = [self.key(tip), self.key(opposite)];
        let is_new = [ends, [ends[1], ends[0]]].iter().all(|side| !self.left.contains_key(side));
        let made = [[a, opposite, tip], [opposite, b, tip]];
        let before = [flatness(&at), flatness(&self.points(other))];
        let after = made.map(|corners| flatness(&points_of(self.sites, &corners)));
        let is_better = before[1] > LINE && after.iter().all(|&after| after > before[0].min(before[1]));
        if !is_new || ends[0] == ends[1] || other == number || !is_better || !self.faces_front(patch, &made) {
            return None;
        }
        let distance = self.distance(patch, &made, [tip, opposite]);
        if distance.is_nan() || distance > allowed {
            return None;
        }
        for side in self.sides(number).into_iter().chain(self.sides(other)) {
            if self.left.get(&side).is_some_and(|left| left.is_some()) {
                self.left.remove(&side);
            }
        }
        (self.triangles[number], self.triangles[other]) = (made[0], made[1]);
        [number, other].into_iter().for_each(|changed| self.add(changed));
        self.has_changed = true;
        Some((other, distance))
    }

    /// Whether triangles do not show their backs at any corner.
    fn faces_front(&self, patch: &MeshPatch, made: &[[u32; 3]; 2]) -> bool {
        made.iter().all(|corners| {
            let [a, b, c] = points_of(self.sites, corners);
            let normal = (b - a).cross(c - a) * if patch.flipped { -1.0 } else { 1.0 };
            corners.iter().all(|&corner| {
                self.sites.get(corner as usize).is_some_and(|site| site.normal.dot(normal) >= 0.0)
            })
        })
    }

    /// Largest distance of two triangles and the side between them from the surface, metres.
    fn distance(&self, patch: &MeshPatch, made: &[[u32; 3]; 2], side: [u32; 2]) -> f64 {
        let site = |corner: u32| self.sites.get(corner as usize).copied();
        let [Some(from), Some(to)] = side.map(site) else { return f64::NAN };
        let middle = patch.point(0.5 * (from.uv + to.uv));
        let distances = made.iter().map(|corners| {
            let [a, b, c] = points_of(self.sites, corners);
            let uv: DVec2 = corners.iter().filter_map(|&corner| site(corner)).map(|site| site.uv).sum();
            (b - a).cross(c - a).normalize_or_zero().dot(patch.point(uv / 3.0) - a).abs()
        });
        distances.fold(distance_to_segment(middle, from.point, to.point), f64::max)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use spade::Point2;

    use super::*;
    use crate::description::{GeometryDescription, ShapeDescription};

    /// Triangles over points of a patch after flips, the points, and the deviation of flipped triangles.
    fn flipped<const N: usize>(
        shape: &ShapeDescription,
        points: &[[f64; 2]],
        mut triangles: [[u32; 3]; N],
        allowed: f64,
    ) -> ([[u32; 3]; N], Vec<MeshSite>, f64) {
        let patch = &MeshPatch::of_shape(0, shape).unwrap()[0];
        let site = |(i, &[u, v]): (usize, &[f64; 2])| {
            let uv = DVec2::new(u, v);
            let (point, normal) = (patch.point(uv), patch.normal(uv));
            MeshSite { uv, at: Point2::new(u, v), vertex: Some(i as u32), point, normal }
        };
        let sites: Vec<MeshSite> = points.iter().enumerate().map(site).collect();
        let deviation =
            flip_flat(patch, &sites, &mut triangles, TessellationSettings { deviation: allowed, angle: 0.5 });
        (triangles, sites, deviation)
    }

    #[test]
    fn a_fan_of_flat_triangles_gets_heights() {
        let square = ShapeDescription::rectangle([0.0, 1.0], [0.0, 1.0]);
        // Four samples of the lower side, of which the inner ones are off it by rounding, and the upper corners.
        let off = 1e-16;
        let points = [[0.0, 0.0], [0.3, -off], [0.7, -off], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let fans =
            [[[0, 1, 3], [1, 2, 3], [0, 3, 4], [0, 4, 5]], [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]]];
        for fan in fans {
            let (triangles, sites, deviation) = flipped(&square, &points, fan, 0.1);
            let areas = triangles.map(|corners| {
                let [a, b, c] = points_of(&sites, &corners);
                0.5 * (b - a).cross(c - a).z
            });
            assert!(areas.iter().all(|area| *area > 0.1), "{triangles:?}");
            assert!(
                (areas.iter().sum::<f64>() - 1.0).abs() < 1e-12 && deviation < 1e-12,
                "{areas:?} {deviation}"
            );
        }
    }

    #[test]
    fn a_flip_away_from_the_surface_is_not_made() {
        // A quarter of a cylinder of radius 1: three samples of a line along it, and a point of the other side. New sides would run 0.29 below the surface.
        let cylinder = GeometryDescription::Cylinder { radius: 1.0, z: [0.0, 1.0], phi_max: 0.5 * PI };
        let points = [[0.0, 0.0], [0.0, 0.5], [0.0, 1.0], [1.0, 0.5]];
        let before = [[0, 2, 1], [0, 3, 2]];
        let cylinder = ShapeDescription::from(cylinder);
        let (triangles, _, deviation) = flipped(&cylinder, &points, before, 0.1);
        assert_eq!((triangles, deviation), (before, 0.0));
        let (triangles, _, deviation) = flipped(&cylinder, &points, before, 0.5);
        assert!(triangles != before && (deviation - 0.29).abs() < 0.01, "{triangles:?} {deviation}");
    }
}
