//! Division of charts at thin walls.

use glanz_math::DVec2;

use super::{BLOCK_SIDE, Chart, ChartWall};

/// Smallest length of a wall within a part that divides it, texels.
const MIN_WALL_LENGTH: f64 = 2.0;

/// Smallest extent of a part on each side of a wall, texels.
pub(super) const MIN_DEPTH: f64 = 1.0;

/// Largest distance of a corner that a wall cut off from the line of the wall, texels: rounding.
const ON_LINE: f64 = 1e-9;

/// Largest number of parts of a chart; light leaks through shorter walls than those that make them.
const MAX_PARTS: usize = 64;

/// A convex polygon of a chart in texels, counterclockwise, and the walls that bound it, with the polygon on their left.
#[derive(Clone, Debug)]
struct ChartPart {
    corners: Vec<DVec2>,
    walls: Vec<ChartWall>,
}

/// Divides a chart along walls, given in its texels.
///
/// The texels of the parts are those of the chart, and their borders are borders of its blocks, so that parts agree on the light where
/// there is no wall.
pub(super) fn divide_at_walls(chart: Chart, walls: &[ChartWall]) -> Vec<Chart> {
    let last = chart.last_texel();
    let corners = vec![DVec2::ZERO, DVec2::new(last.x, 0.0), last, DVec2::new(0.0, last.y)];
    let mut parts = vec![ChartPart { corners, walls: Vec::new() }];
    for wall in walls {
        let mut next = Vec::with_capacity(parts.len());
        for (i, part) in parts.iter().enumerate() {
            let room = MAX_PARTS - next.len() - (parts.len() - i);
            match part.halves(*wall).filter(|_| room > 0) {
                Some(halves) => next.extend(halves),
                None => next.push(part.clone()),
            }
        }
        parts = next;
    }
    if parts.len() == 1 {
        return vec![chart];
    }
    parts.into_iter().map(|part| part.chart(&chart)).collect()
}

impl ChartPart {
    /// The parts on both sides of a wall; `None` if the wall does not stand on this part, or only on its border.
    fn halves(&self, wall: ChartWall) -> Option<[Self; 2]> {
        let [from, to] = wall.ends;
        let direction = (to - from).try_normalize()?;
        let off = |corner: &DVec2| direction.perp_dot(*corner - from);
        let deepest = |side: f64| self.corners.iter().map(|corner| side * off(corner)).fold(0.0, f64::max);
        if deepest(1.0) < MIN_DEPTH || deepest(-1.0) < MIN_DEPTH {
            return None;
        }
        let left = clip_left_of(&self.corners, from, to);
        // Where the line enters and leaves the part, along the wall.
        let on_line = left
            .iter()
            .filter(|corner| off(corner).abs() < ON_LINE)
            .map(|corner| direction.dot(*corner - from));
        let (low, high) = on_line.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), t| (l.min(t), h.max(t)));
        let inside = high.min(from.distance(to)) - low.max(0.0);
        let with = |corners: Vec<DVec2>, wall: ChartWall| {
            let walls = self.walls.iter().copied().chain([wall]).collect();
            Self { corners, walls }
        };
        let right = clip_left_of(&self.corners, to, from);
        // A wall that ends near the border is extended beyond it, so that no light gets round its end.
        let length = from.distance(to);
        let beyond = high - low;
        let from = if low > -MIN_DEPTH { from - beyond * direction } else { from };
        let to = if high < length + MIN_DEPTH { to + beyond * direction } else { to };
        let wall = ChartWall { ends: [from, to], ..wall };
        (inside >= MIN_WALL_LENGTH).then(|| [with(left, wall), with(right, wall.reversed())])
    }

    fn chart(&self, whole: &Chart) -> Chart {
        let (low, high) = self
            .corners
            .iter()
            .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), p| (low.min(*p), high.max(*p)));
        // One texel more than filtering needs, since the outermost texels are computed as a border.
        let block = f64::from(BLOCK_SIDE);
        let low = (((low - 1.0).floor() / block).floor() * block).max(DVec2::ZERO);
        let high = (((high + 1.0).ceil() / block).ceil() * block).min(whole.last_texel());
        let window = [whole.to_sheet(low), whole.to_sheet(high)];
        let size = (high - low + 1.0).to_array().map(|n| n as u32);
        let on_sheet =
            |wall: &ChartWall| ChartWall { ends: wall.ends.map(|end| whole.to_sheet(end)), ..*wall };
        let walls = self.walls.iter().map(on_sheet).collect();
        Chart { window, size, walls, ..whole.clone() }
    }
}

/// The part of a convex polygon to the left of the line from one point to another.
pub(crate) fn clip_left_of(corners: &[DVec2], from: DVec2, to: DVec2) -> Vec<DVec2> {
    let off = |corner: DVec2| (to - from).perp_dot(corner - from);
    let mut left = Vec::with_capacity(corners.len() + 1);
    for (&a, &b) in corners.iter().zip(corners.iter().cycle().skip(1)) {
        let (here, there) = (off(a), off(b));
        if here >= 0.0 {
            left.push(a);
        }
        if (here > 0.0 && there < 0.0) || (here < 0.0 && there > 0.0) {
            left.push(a.lerp(b, here / (here - there)));
        }
    }
    left
}
