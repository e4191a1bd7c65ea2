//! Object and normal per pixel, from the page and from rays through the pixel centres.

use glanz::math::{DVec3, Ray};
use glanz::scene::{Interaction, ParametricPoint, Scene};
use glanz::viewer::model::Model;
use serde_json::Value;

use super::page::Page;

/// Radius, in pixels, of the search for a silhouette.
const REACH: i64 = 8;

/// Objects and normals by pixel, rows from the top.
pub(crate) struct SurfacePixels {
    pub(crate) size: [usize; 2],
    /// Number of the object + 1; 0: nothing.
    objects: Vec<u32>,
    /// Unit normals on the side of the viewer.
    normals: Vec<DVec3>,
    /// Whether the surface is flat, where that is known; flat surfaces are left out of the comparison of normals.
    flat: Vec<bool>,
}

/// Differences of two pictures.
#[derive(Debug)]
pub(crate) struct Difference {
    /// Number of pixels that show the same object.
    pub(crate) same: usize,
    /// Angles between normals at the pixels of the same object that is not flat, in degrees, ascending.
    pub(crate) angles: Vec<f64>,
    /// Number of pixels that show different objects.
    pub(crate) other: usize,
    /// Largest distance of these pixels from a silhouette of either picture, in pixels; [`REACH`] + 1 if it is larger than [`REACH`].
    pub(crate) farthest: f64,
}

impl SurfacePixels {
    /// Reads the picture of the page.
    pub(crate) fn by_page(page: &mut Page) -> Self {
        let size =
            page.evaluate("window.seen = window.glanz.normals(), [window.seen.width, window.seen.height]");
        let size = [0, 1].map(|i| size[i].as_u64().expect("a size") as usize);
        let bytes = page.bytes("window.seen.data");
        let numbers: Vec<f64> = bytes
            .chunks_exact(4)
            .map(|four| f64::from(f32::from_le_bytes(four.try_into().expect("four bytes"))))
            .collect();
        let pixels = numbers.chunks_exact(4);
        assert_eq!(pixels.len(), size[0] * size[1], "four numbers per pixel");
        let (objects, normals) = pixels.map(|p| (p[3] as u32, DVec3::new(p[0], p[1], p[2]))).unzip();
        Self { size, objects, normals, flat: vec![false; size[0] * size[1]] }
    }

    /// Intersects rays from a camera of the page through the pixel centres with the scene.
    pub(crate) fn by_rays(scene: &Scene, model: &Model, camera: &Value, size: [usize; 2]) -> Self {
        let vector = |name: &str| DVec3::from([0, 1, 2].map(|i| camera[name][i].as_f64().expect("a camera")));
        let [position, right, up, forward] = ["position", "right", "up", "forward"].map(vector);
        assert_eq!(camera["kind"], "perspective");
        let slope = (0.5 * camera["fieldOfView"].as_f64().expect("an angle")).tan();
        let [width, height] = size.map(|n| n as f64);
        let mut seen = Self { size, objects: Vec::new(), normals: Vec::new(), flat: Vec::new() };
        let surfaces = scene.placed_surfaces();
        for (y, x) in (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (y as f64 + 0.5, x as f64 + 0.5))) {
            let unit = slope / width.min(height);
            let across = (2.0 * x - width) * unit * right + (height - 2.0 * y) * unit * up;
            let ray = Ray::new(position, (forward + across).normalize());
            let hit = scene.intersect_parametric(&ray, f64::INFINITY);
            let object = hit.as_ref().and_then(|(_, place)| model.object_of(place));
            seen.objects.push(object.map_or(0, |object| object + 1));
            let normal = hit.as_ref().map_or(DVec3::ZERO, |(hit, _)| hit.point.shading_normal);
            seen.normals.push(if normal.dot(ray.direction) > 0.0 { -normal } else { normal });
            let is_flat = |(hit, place): (Interaction, ParametricPoint)| {
                let surface = &surfaces[place.surface as usize];
                surface.differential(&ray, hit.t, &place).1 == [DVec3::ZERO; 2]
            };
            seen.flat.push(hit.is_none_or(is_flat));
        }
        seen
    }

    /// Compares with another picture of the same size.
    pub(crate) fn difference(&self, other: &Self) -> Difference {
        assert_eq!(self.size, other.size);
        let mut found = Difference { same: 0, angles: Vec::new(), other: 0, farthest: 0.0 };
        for i in 0..self.objects.len() {
            if self.objects[i] != other.objects[i] {
                found.other += 1;
                found.farthest = found.farthest.max(self.to_border(i)).max(other.to_border(i));
            } else if self.objects[i] > 0 {
                found.same += 1;
                if self.flat[i] || other.flat[i] {
                    continue;
                }
                let [a, b] = [self.normals[i], other.normals[i]];
                found.angles.push(a.cross(b).length().atan2(a.dot(b)).to_degrees());
            }
        }
        found.angles.sort_by(f64::total_cmp);
        found
    }

    /// Number of pixels amid a surface of the exact picture where this one shows nothing.
    pub(crate) fn uncovered(&self, exact: &Self) -> usize {
        let [width, height] = self.size.map(|n| n as i64);
        let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let amid = |x: i64, y: i64| (-1..=1).all(|i| (-1..=1).all(|j| exact.object(x + i, y + j) > 0));
        places.filter(|&(x, y)| self.object(x, y) == 0 && amid(x, y)).count()
    }

    /// The object at a pixel; outside the picture the object of the nearest pixel.
    fn object(&self, x: i64, y: i64) -> u32 {
        let [width, height] = self.size.map(|n| n as i64);
        self.objects[(y.clamp(0, height - 1) * width + x.clamp(0, width - 1)) as usize]
    }

    /// Distance of a pixel from the nearest pixel that has a neighbour with a different object.
    fn to_border(&self, pixel: usize) -> f64 {
        let [x, y] = [pixel % self.size[0], pixel / self.size[0]].map(|n| n as i64);
        let near = (-REACH..=REACH).flat_map(|i| (-REACH..=REACH).map(move |j| [i, j]));
        let is_border = |x, y| {
            let own = self.object(x, y);
            [[1, 0], [-1, 0], [0, 1], [0, -1]].iter().any(|[i, j]| self.object(x + i, y + j) != own)
        };
        let borders = near.filter(|[i, j]| is_border(x + i, y + j)).map(|[i, j]| (i as f64).hypot(j as f64));
        borders.fold(REACH as f64 + 1.0, f64::min)
    }
}

impl Difference {
    /// Share of the angles that are at most `degrees`.
    pub(crate) fn within(&self, degrees: f64) -> f64 {
        self.angles.partition_point(|&angle| angle <= degrees) as f64 / self.angles.len().max(1) as f64
    }
}

/// A picture of 20 x 10 pixels with object 1 left of column `edge` and object 2 elsewhere, and normals turned by an angle.
#[cfg(test)]
fn halves(edge: usize, degrees: f64) -> SurfacePixels {
    let size = [20, 10];
    let objects = (0..200).map(|i| if i % 20 < edge { 1 } else { 2 }).collect();
    let (sin, cos) = degrees.to_radians().sin_cos();
    SurfacePixels { size, objects, normals: vec![DVec3::new(sin, 0.0, cos); 200], flat: vec![false; 200] }
}

#[test]
fn shifted_edges_and_rotated_normals_are_detected() {
    // Three columns differ; the pixel beside the edge of one picture is the third from the edge of the other.
    let difference = halves(5, 0.0).difference(&halves(8, 2.0));
    assert_eq!([difference.same, difference.other], [170, 30]);
    assert_eq!(difference.farthest, 2.0);
    assert!((difference.angles[0] - 2.0).abs() < 1e-9, "{}", difference.angles[0]);
    assert_eq!([difference.within(1.9), difference.within(2.1)], [0.0, 1.0]);
}

#[test]
fn holes_are_counted_amid_surfaces_only() {
    let mut holed = halves(0, 0.0);
    holed.objects[107] = 0;
    assert_eq!(holed.uncovered(&halves(0, 0.0)), 1);
    // The exact picture ends at the next pixel.
    let mut smaller = halves(0, 0.0);
    smaller.objects[108] = 0;
    assert_eq!(holed.uncovered(&smaller), 0);
}

#[test]
fn pixels_without_an_edge_near_them_are_far() {
    let mut speckled = halves(0, 0.0);
    speckled.objects[107] = 0;
    // The other picture has no silhouette.
    assert_eq!(speckled.difference(&halves(0, 0.0)).farthest, 9.0);
}
