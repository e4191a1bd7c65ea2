//! How much of the light that leaves one element meets another.
//!
//! Polygons that see each other whole exchange light by a closed form; all else is integrated over pairs of points with a ray between
//! them, on parts so small that they are far apart for their size.

use std::f64::consts::PI;

use glanz_job::{CancelFlag, Interrupted};
use glanz_math::rounding::offset_origin;
use glanz_math::{DVec3, Ray};
use glanz_scene::Scene;
use rayon::prelude::*;

use crate::elements::{Element, Elements, Node, Patch};

pub mod polygon;

/// Sum of the radii of two parts over their distance below which points stand for them.
const FAR: f64 = 0.3;

/// Share of the smaller area below which parts that touch are not divided further.
const SMALLEST: f64 = 1.0 / 256.0;

/// How often a pair of polygons is divided whose points see each other in part.
const PENUMBRA_LEVELS: u32 = 3;

/// The same for pairs of other shapes, of which either is divided.
const CURVED_PENUMBRA_LEVELS: u32 = 5;

/// Area times form factor of a pair of elements, m^2: the same both ways.
#[must_use]
pub fn exchange(elements: &Elements<'_>, a: &Element, b: &Element) -> f64 {
    exchange_counting(elements, a, b, &mut 0)
}

/// As [`exchange`]; adds the number of its shadow rays to `rays`.
pub fn exchange_counting(elements: &Elements<'_>, a: &Element, b: &Element, rays: &mut u64) -> f64 {
    match (&a.polygon, &b.polygon) {
        (Some(p), Some(q)) => match (Flat::in_front_of(a, p, b), Flat::in_front_of(b, q, a)) {
            (Some(p), Some(q)) => flat(elements.scene, &p, &q, PENUMBRA_LEVELS, rays),
            _ => 0.0,
        },
        _ => {
            let smallest = SMALLEST * a.area.min(b.area);
            let [a, b] = [a, b].map(|element| Piece::new(elements, element.patch));
            curved(elements, &a, &b, smallest, Sight::Unknown(CURVED_PENUMBRA_LEVELS), rays)
        }
    }
}

/// Form factors of all pairs that see each other.
#[derive(Clone, Debug, PartialEq)]
pub struct FormFactors {
    /// Of each element those to others, by ascending number.
    rows: Vec<Vec<(u32, f32)>>,
    rays: u64,
}

/// Of an element the light that it exchanges with those behind it in the list, and the rays that told it.
type Row = (Vec<(u32, f64)>, u64);

impl FormFactors {
    /// All of them, by all threads; memory grows with the square of the number of elements.
    ///
    /// # Errors
    /// [`Interrupted`] if `cancel` is raised, which is checked after each row.
    pub fn new(elements: &Elements<'_>, cancel: &CancelFlag) -> Result<Self, Interrupted> {
        let list = &elements.list;
        let upper: Result<Vec<Row>, Interrupted> = list
            .par_iter()
            .enumerate()
            .map(|(i, a)| {
                let others = (0_u32..).zip(list).skip(i + 1);
                let mut rays = 0;
                let row = others.filter_map(|(j, b)| {
                    let exchanged = exchange_counting(elements, a, b, &mut rays);
                    (exchanged > 0.0).then_some((j, exchanged))
                });
                let row = row.collect();
                cancel.check().map(|()| (row, rays))
            })
            .collect();
        let mut rows: Vec<Vec<(u32, f32)>> = vec![Vec::new(); list.len()];
        let mut rays = 0;
        for (i, (row, of_row)) in upper?.into_iter().enumerate() {
            rays += of_row;
            for (j, exchanged) in row {
                rows[i].push((j, (exchanged / list[i].area) as f32));
                rows[j as usize].push((i as u32, (exchanged / list[j as usize].area) as f32));
            }
        }
        rows.iter_mut().for_each(|row| row.sort_unstable_by_key(|&(j, _)| j));
        Ok(Self { rows, rays })
    }

    /// Elements that one sees, and the share of the light that it sends to each.
    #[must_use]
    pub fn row(&self, element: usize) -> &[(u32, f32)] {
        self.rows.get(element).map_or(&[], Vec::as_slice)
    }

    /// Share of the light of an element that meets any other: 1 in a closed room but for errors.
    #[must_use]
    pub fn sum(&self, element: usize) -> f64 {
        self.row(element).iter().map(|&(_, factor)| f64::from(factor)).sum()
    }

    /// Number of elements.
    #[must_use]
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Whether there are no elements.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Rays that told what sees what.
    #[must_use]
    pub fn rays(&self) -> u64 {
        self.rays
    }

    /// Memory, bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.rows.iter().map(|row| size_of_val(row.as_slice())).sum()
    }
}

/// A flat polygon.
struct Flat {
    corners: Vec<DVec3>,
    normal: DVec3,
    error: DVec3,
}

impl Flat {
    /// What is left of an element on the front of another's plane; `None` if nothing is.
    fn in_front_of(element: &Element, corners: &[DVec3], other: &Element) -> Option<Self> {
        let corners = polygon::in_front(corners, other.center.position, other.center.normal);
        let Node { normal, error, .. } = element.center;
        (corners.len() >= 3).then_some(Self { corners, normal, error })
    }

    fn middle(&self) -> DVec3 {
        self.corners.iter().sum::<DVec3>() / self.corners.len() as f64
    }

    fn area(&self) -> f64 {
        let first = self.corners.first().copied().unwrap_or_default();
        let twice: DVec3 = self.corners.windows(2).map(|pair| (pair[0] - first).cross(pair[1] - first)).sum();
        0.5 * twice.length()
    }

    /// Points inside, one towards each corner.
    fn points(&self) -> Vec<Node> {
        let middle = self.middle();
        let node = |&corner: &DVec3| Node {
            position: middle.lerp(corner, 0.55),
            normal: self.normal,
            error: self.error,
            area: 0.0,
        };
        self.corners.iter().map(node).collect()
    }

    /// As many parts as corners, between these, the middles of the sides and the middle.
    fn parts(&self) -> Vec<Self> {
        let (middle, n) = (self.middle(), self.corners.len());
        let part = |i: usize| {
            let [before, here, after] = [i + n - 1, i, i + 1].map(|i| self.corners[i % n]);
            let corners = vec![here, 0.5 * (here + after), middle, 0.5 * (before + here)];
            Self { corners, normal: self.normal, error: self.error }
        };
        (0..n).map(part).collect()
    }
}

/// Between polygons on the front of one another's planes.
fn flat(scene: &Scene, a: &Flat, b: &Flat, levels: u32, rays: &mut u64) -> f64 {
    let (from, to) = (a.points(), b.points());
    let all = from.len() * to.len();
    *rays += all as u64;
    let free = from.iter().map(|a| to.iter().filter(|b| is_free(scene, a, b)).count()).sum::<usize>();
    if free == 0 {
        return 0.0;
    }
    if free == all || levels == 0 {
        return polygon::exchange(&a.corners, &b.corners) * free as f64 / all as f64;
    }
    if a.area() >= b.area() {
        a.parts().iter().map(|part| flat(scene, part, b, levels - 1, rays)).sum()
    } else {
        b.parts().iter().map(|part| flat(scene, a, part, levels - 1, rays)).sum()
    }
}

/// A part of a surface with the points that stand for it.
struct Piece {
    patch: Patch,
    nodes: Vec<Node>,
    middle: DVec3,
    radius: f64,
    area: f64,
}

impl Piece {
    fn new(elements: &Elements<'_>, patch: Patch) -> Self {
        let nodes = elements.nodes(&patch);
        let count = nodes.len().max(1) as f64;
        let middle = nodes.iter().map(|node| node.position).sum::<DVec3>() / count;
        let reach = nodes.iter().map(|node| node.position.distance(middle)).fold(0.0, f64::max);
        // Corners are no more than twice as far from the middle as the nodes.
        Self { patch, middle, radius: 2.0 * reach, area: nodes.iter().map(|node| node.area).sum(), nodes }
    }

    fn parts(&self, elements: &Elements<'_>) -> Vec<Self> {
        let quarters = self.patch.part.quarters();
        quarters.into_iter().map(|part| Self::new(elements, Patch { part, ..self.patch })).collect()
    }
}

/// What is known of how parts see each other.
#[derive(Clone, Copy, Debug)]
enum Sight {
    /// Nothing; rays decide in so many more divisions.
    Unknown(u32),
    /// This share of the rays between them is free.
    Share(f64),
}

/// Between parts of any shape.
///
/// Parts none of whose points face one another exchange nothing: what the rims of curved ones exchange besides vanishes as they
/// grow smaller. Those all of whose points see each other are divided without further rays.
fn curved(elements: &Elements<'_>, a: &Piece, b: &Piece, smallest: f64, sight: Sight, rays: &mut u64) -> f64 {
    let (mut whole, mut seen, mut facing, mut free) = (0.0, 0.0, 0_usize, 0_usize);
    for (a, b) in a.nodes.iter().flat_map(|a| b.nodes.iter().map(move |b| (a, b))) {
        let exchanged = kernel(a, b) * a.area * b.area;
        if exchanged > 0.0 {
            facing += 1;
            whole += exchanged;
            if matches!(sight, Sight::Unknown(_)) && is_free(elements.scene, a, b) {
                free += 1;
                seen += exchanged;
            }
        }
    }
    if facing == 0 {
        return 0.0;
    }
    let all = a.nodes.len() * b.nodes.len();
    let (found, below) = match sight {
        Sight::Share(share) => (share * whole, sight),
        Sight::Unknown(levels) => {
            *rays += facing as u64;
            // Few that face one another do not tell of the rest.
            let below = match (2 * facing >= all, levels.checked_sub(1)) {
                (true, _) if free == facing => Sight::Share(1.0),
                (_, Some(levels)) => Sight::Unknown(levels),
                (_, None) => Sight::Share(free as f64 / facing as f64),
            };
            if free == 0 && facing == all {
                return 0.0;
            }
            (seen, below)
        }
    };
    let is_far = a.radius + b.radius <= FAR * a.middle.distance(b.middle);
    if is_far || a.area.min(b.area) <= smallest {
        // Points that nearly touch would see more than there is.
        return found.min(a.area.min(b.area));
    }
    if a.radius >= b.radius {
        a.parts(elements).iter().map(|part| curved(elements, part, b, smallest, below, rays)).sum()
    } else {
        b.parts(elements).iter().map(|part| curved(elements, a, part, smallest, below, rays)).sum()
    }
}

/// cos cos' / (pi r^2), per m^2; 0 where one faces away.
pub(crate) fn kernel(a: &Node, b: &Node) -> f64 {
    let way = b.position - a.position;
    let square = way.length_squared();
    let (leaves, meets) = (a.normal.dot(way), -b.normal.dot(way));
    if leaves > 0.0 && meets > 0.0 { leaves * meets / (PI * square * square) } else { 0.0 }
}

/// Whether nothing is between two points.
pub(crate) fn is_free(scene: &Scene, a: &Node, b: &Node) -> bool {
    let way = b.position - a.position;
    let from = offset_origin(a.position, a.error, a.normal, way);
    let to = offset_origin(b.position, b.error, b.normal, -way);
    !scene.occluded(&Ray::new(from, to - from), 1.0)
}

#[cfg(test)]
mod tests;
