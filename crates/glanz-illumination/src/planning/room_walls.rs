//! Walls of a room: the upright flat shapes at its border, and which of their faces light reaches.

use std::collections::HashSet;

use glanz_math::{DVec2, DVec3};

use super::plan_outline::{NEAR, ShapeOutline};
use super::room_shapes::{RoomShape, ShapeKey, border_distance};
use crate::receiver::holds;

/// Height of a wall, as a share of that of the room.
const WALL_HEIGHT: f64 = 0.9;

/// Least length of a wall, as a share of the smaller side of the room.
const WALL_LENGTH: f64 = 0.1;

/// Largest thickness of a wall, metres.
const THICKEST_WALL: f64 = 0.6;

/// Largest area of the top of a wall, as a share of that of the box around the room from above: small boxes are rooms, too.
const LARGEST_END: f64 = 0.5;

/// Least cosine between faces of one wall, and the share of a face that is beside others from which on they are the ones that count.
const PARALLEL: f64 = 0.999;
const SIDE_BY_SIDE: f64 = 0.5;

/// Places along the part of a face that is beside another, as shares of its length, most of which decide whether it is an outer one: some may lie in a
/// partition.
const TESTED_PLACES: [f64; 5] = [0.1, 0.3, 0.5, 0.7, 0.9];

/// Distance of points right in front of a wall, as a share of that of those in the room, which lie beyond a partition if a closet has no more depth than a wall.
const RIGHT_IN_FRONT: f64 = 0.1;

/// Largest distance of walls from the border, as a share of the smaller side of the room: walls are thick, and floors may reach below them.
const BORDER: f64 = 0.05;

/// The upright flat shapes that are long and high enough for walls of a room of this `size`, metres.
pub(super) fn tall_faces<'s, 'a>(shapes: &'s [RoomShape<'a>], size: DVec3) -> Vec<&'s RoomShape<'a>> {
    let (shorter, near) = (size.truncate().min_element(), NEAR * size.length());
    let is_tall = |shape: &&RoomShape<'_>| {
        let [from, to] = shape.outline.height;
        shape.outline.is_upright(near)
            && to - from >= WALL_HEIGHT * size.z
            && shape.outline.length() >= WALL_LENGTH * shorter
    };
    shapes.iter().filter(is_tall).collect()
}

/// Those of some tall faces that lie along closed outlines, in a room of this `size`, metres.
pub(super) fn walls<'s, 'a>(
    mut tall: Vec<&'s RoomShape<'a>>,
    border: &[Vec<DVec2>],
    size: DVec3,
) -> Vec<&'s RoomShape<'a>> {
    let largest = BORDER * size.truncate().min_element();
    tall.retain(|shape| {
        let outline = &shape.outline.outline;
        let middle = outline.iter().sum::<DVec2>() / outline.len().max(1) as f64;
        outline.iter().chain([&middle]).all(|point| border_distance(border, *point) <= largest)
    });
    tall
}

/// Level parts that are tops and undersides of walls, of shapes with several faces: boxes and meshes.
pub(super) struct WallEnds {
    /// The shapes of the walls.
    shapes: HashSet<ShapeKey>,
    /// Square metres.
    largest_area: f64,
    /// Those of floor and ceiling, metres.
    heights: [f64; 2],
}

impl WallEnds {
    /// Those of the shapes with these upright `faces`, in a room whose box has these lowest and highest corners, metres.
    pub(super) fn of(faces: &[&RoomShape<'_>], [low, high]: [DVec3; 2]) -> Self {
        let shapes = faces.iter().map(|face| face.key()).collect();
        let largest_area = LARGEST_END * (high - low).truncate().element_product();
        Self { shapes, largest_area, heights: [low.z, high.z] }
    }

    /// Whether a level part is one of them: no wider than the thickest wall, and as near to floor or ceiling as the ends of walls are. In a room of one mesh,
    /// tops of furniture are parts of the shape of the walls, too.
    pub(super) fn contains(&self, part: &RoomShape<'_>) -> bool {
        let [low, high] = self.heights;
        let [bottom, top] = part.outline.height;
        (top - low).max(high - bottom) >= WALL_HEIGHT * (high - low)
            && self.shapes.contains(&part.key())
            && part.area() <= self.largest_area
            && part.width() <= THICKEST_WALL
    }
}

/// The walls without the outer faces of those that are modelled with both: of parallel faces side by side, the one that has floor in front of it counts if the
/// other has none. `floor`: convex polygons from above, metres; without any, the floor is the box of this `size` around the `middle`.
pub(super) fn inner_walls<'s, 'a>(
    mut walls: Vec<&'s RoomShape<'a>>,
    mut floor: Vec<Vec<DVec2>>,
    middle: DVec2,
    size: DVec3,
) -> Vec<&'s RoomShape<'a>> {
    if floor.is_empty() {
        let corners = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]].map(DVec2::from);
        floor.push(corners.map(|corner| middle + corner * size.truncate()).into());
    }
    // Of equal faces, the first one counts.
    walls.sort_by(|a, b| b.outline.length().total_cmp(&a.outline.length()));
    let lines: Vec<WallSegment> = walls.iter().map(|wall| WallSegment::of(&wall.outline)).collect();
    let near = NEAR * size.length();
    let reach = (BORDER * size.truncate().min_element()).min(0.5 * THICKEST_WALL);
    let is_floor = |point: DVec2| floor.iter().any(|polygon| holds(polygon, point));
    let is_behind = |pair: &FacePair, comes_first: bool| {
        if pair.gap.length() <= near {
            return comes_first;
        }
        let inwards = reach * pair.gap.normalize_or_zero();
        let is_outer_at = |share: f64| {
            let at = pair.from + share * pair.along;
            let beyond = at + pair.gap;
            !is_floor(at - inwards)
                && is_floor(beyond + RIGHT_IN_FRONT * inwards)
                && is_floor(beyond + inwards)
        };
        2 * TESTED_PLACES.into_iter().filter(|share| is_outer_at(*share)).count() > TESTED_PLACES.len()
    };
    let is_inner = |number: usize, line: &WallSegment| {
        let others = lines.iter().enumerate().filter(|(other, _)| *other != number);
        let behind = others.filter_map(|(other, face)| {
            let pair = line.pair(face)?;
            is_behind(&pair, other < number).then_some(pair.part)
        });
        joint_length(behind.collect()) < SIDE_BY_SIDE * line.length
    };
    let kept = walls.iter().zip(&lines).enumerate().filter(|(number, (_, line))| is_inner(*number, line));
    kept.map(|(_, (wall, _))| *wall).collect()
}

/// An upright face from above.
struct WallSegment {
    /// One end, metres.
    from: DVec2,
    /// Unit direction to the other end; 0 without length.
    direction: DVec2,
    /// Metres.
    length: f64,
}

/// A face and a parallel one beside it.
struct FacePair {
    /// The part of the face that is beside the other, metres from its end.
    part: [f64; 2],
    /// One end of that part, metres.
    from: DVec2,
    /// From there to the other end of the part, metres.
    along: DVec2,
    /// From the middle of the part to the other face, metres.
    gap: DVec2,
}

impl WallSegment {
    fn of(outline: &ShapeOutline) -> Self {
        let [from, to] = outline.ends();
        Self { from, direction: (to - from).normalize_or_zero(), length: from.distance(to) }
    }

    /// This face and another one, if they may be those of one wall.
    fn pair(&self, other: &Self) -> Option<FacePair> {
        if self.direction.dot(other.direction).abs() < PARALLEL {
            return None;
        }
        let to = other.from + other.length * other.direction;
        let [a, b] = [other.from, to].map(|end| (end - self.from).dot(self.direction));
        let part = [a.min(b).max(0.0), a.max(b).min(self.length)];
        let [start, end] = part;
        let (from, along) = (self.from + start * self.direction, (end - start) * self.direction);
        let across = other.direction.perp();
        let gap = (other.from - (from + 0.5 * along)).dot(across) * across;
        (start < end && gap.length() <= THICKEST_WALL).then_some(FacePair { part, from, along, gap })
    }
}

/// Length that intervals cover together.
fn joint_length(mut intervals: Vec<[f64; 2]>) -> f64 {
    intervals.sort_by(|[a, _], [b, _]| a.total_cmp(b));
    let (mut sum, mut reached) = (0.0, f64::NEG_INFINITY);
    for [start, end] in intervals {
        sum += (end - start.max(reached)).max(0.0);
        reached = reached.max(end);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_that_overlap_count_once() {
        assert_eq!(joint_length(vec![[2.0, 3.0], [0.0, 1.0], [0.5, 1.5], [2.25, 2.5]]), 2.5);
        assert_eq!(joint_length(Vec::new()), 0.0);
    }
}
