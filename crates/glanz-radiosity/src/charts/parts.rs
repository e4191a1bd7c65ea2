//! Parts of charts, on both sides of thin walls.

use glanz_math::DVec2;

use super::{BLOCK, Chart};

/// Length of a wall within a part from which it parts it further, texels.
const LONG: f64 = 2.0;

/// What has to be left of a part on both sides, texels.
const DEEP: f64 = 1.0;

/// Parts of a chart, at most: shorter walls than those that make them leak.
const PARTS: usize = 64;

/// A convex polygon of a chart in texels, counterclockwise, and the walls that bound it: it is to the left of their lines.
#[derive(Clone, Debug)]
struct Part {
    corners: Vec<DVec2>,
    walls: Vec<[DVec2; 2]>,
}

/// A chart parted along the lines of walls, given in its texels.
///
/// Texels of the parts are texels of the chart, and begin and end with its blocks: where no wall is, parts agree on the light.
pub(super) fn parted(chart: Chart, walls: &[[DVec2; 2]]) -> Vec<Chart> {
    let last = chart.last();
    let corners = vec![DVec2::ZERO, DVec2::new(last.x, 0.0), last, DVec2::new(0.0, last.y)];
    let mut parts = vec![Part { corners, walls: Vec::new() }];
    for wall in walls {
        let mut next = Vec::with_capacity(parts.len());
        for (i, part) in parts.iter().enumerate() {
            let room = PARTS - next.len() - (parts.len() - i);
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

impl Part {
    /// What is on both sides of a wall; `None` if it does not stand on this part, or on its border.
    fn halves(&self, [from, to]: [DVec2; 2]) -> Option<[Self; 2]> {
        let way = (to - from).try_normalize()?;
        let off = |corner: &DVec2| way.perp_dot(*corner - from);
        let deepest = |side: f64| self.corners.iter().map(|corner| side * off(corner)).fold(0.0, f64::max);
        if deepest(1.0) < DEEP || deepest(-1.0) < DEEP {
            return None;
        }
        let left = left_of(&self.corners, from, to);
        // Where the line enters and leaves the part, along the wall.
        let on_line =
            left.iter().filter(|corner| off(corner).abs() < 1e-9).map(|corner| way.dot(*corner - from));
        let (low, high) = on_line.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), t| (l.min(t), h.max(t)));
        let inside = high.min(from.distance(to)) - low.max(0.0);
        let with = |corners: Vec<DVec2>, wall: [DVec2; 2]| {
            let walls = self.walls.iter().copied().chain([wall]).collect();
            Self { corners, walls }
        };
        let right = left_of(&self.corners, to, from);
        // What ends at the border has nothing to go round.
        let length = from.distance(to);
        let beyond = high - low;
        let from = if low > -DEEP { from - beyond * way } else { from };
        let to = if high < length + DEEP { to + beyond * way } else { to };
        (inside >= LONG).then(|| [with(left, [from, to]), with(right, [to, from])])
    }

    fn chart(&self, whole: &Chart) -> Chart {
        let (low, high) = self
            .corners
            .iter()
            .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), p| (low.min(*p), high.max(*p)));
        // A texel more than filtering needs: the outermost are those of a border.
        let block = f64::from(BLOCK);
        let low = (((low - 1.0).floor() / block).floor() * block).max(DVec2::ZERO);
        let high = (((high + 1.0).ceil() / block).ceil() * block).min(whole.last());
        let window = [whole.to_sheet(low), whole.to_sheet(high)];
        let size = (high - low + 1.0).to_array().map(|n| n as u32);
        let walls = self.walls.iter().map(|wall| wall.map(|end| whole.to_sheet(end))).collect();
        Chart { window, size, walls, ..whole.clone() }
    }
}

/// What of a convex polygon is left of the line from one point to another.
pub(crate) fn left_of(corners: &[DVec2], from: DVec2, to: DVec2) -> Vec<DVec2> {
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
