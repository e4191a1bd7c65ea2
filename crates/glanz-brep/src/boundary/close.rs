//! Closing loops that go around, and copies of loops over seams.

use glanz_math::DVec2;

use super::chain::BoundaryChain;
use super::curve::{BoundaryCurve, polygon, signed_area};
use super::space::{ParameterSpace, QUARTER_TURN};
use super::{BoundaryError, BoundaryRepair};

/// The boundary of a face in region coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct ClosedBoundary {
    /// Closed loops, the face on their left. None: the face is the whole window.
    pub loops: Vec<Vec<BoundaryCurve>>,
    /// The part of the domain that contains the face, with a margin: the ranges of both coordinates.
    pub window: [[f64; 2]; 2],
    /// Repairs that were necessary.
    pub repairs: Vec<BoundaryRepair>,
}

/// Largest number of control points of all copies of the loops of a face.
const MAX_POINTS: f64 = 4e6;

/// Part of the extent of a face by which its window is wider.
const MARGIN: f64 = 1.0 / 64.0;

/// Makes closed loops of the chains of a face. `width`: distance beyond its curves to which the face extends, in region coordinates.
///
/// # Errors
/// [`BoundaryError::Unbounded`], [`BoundaryError::Winding`], [`BoundaryError::Unpaired`].
pub fn close(
    chains: Vec<BoundaryChain>,
    space: &ParameterSpace<'_>,
    width: f64,
) -> Result<ClosedBoundary, BoundaryError> {
    let around = |axis: usize| chains.iter().any(|chain| chain.winding[axis] != 0);
    for BoundaryChain { winding: [u, v], .. } in &chains {
        if u.abs() > 1 || v.abs() > 1 || *u != 0 && around(1) || *v != 0 && around(0) {
            return Err(BoundaryError::Winding(*u, *v));
        }
    }
    if !around(1) {
        return close_upright(chains, space, width);
    }
    let turned_space = ParameterSpace {
        domain: [space.domain[1], [-space.domain[0][1], -space.domain[0][0]]],
        periods: [space.periods[1], space.periods[0]],
        movable: [space.movable[1], space.movable[0]],
        poles: [space.poles[1], [space.poles[0][1], space.poles[0][0]]],
        point: space.point,
    };
    let turn = |curve: &BoundaryCurve, matrix| curve.transformed(matrix, DVec2::ZERO);
    let turned = chains.into_iter().map(|chain| BoundaryChain {
        curves: chain.curves.iter().map(|curve| turn(curve, QUARTER_TURN)).collect(),
        winding: [chain.winding[1], -chain.winding[0]],
        repairs: chain.repairs,
    });
    let closed = close_upright(turned.collect(), &turned_space, width)?;
    let back =
        |chain: Vec<BoundaryCurve>| chain.iter().map(|curve| turn(curve, QUARTER_TURN.transpose())).collect();
    let [a, b] = closed.window;
    Ok(ClosedBoundary {
        loops: closed.loops.into_iter().map(back).collect(),
        window: [[-b[1], -b[0]], a],
        repairs: closed.repairs,
    })
}

/// [`close`] for chains that go around in u, if at all.
fn close_upright(
    mut chains: Vec<BoundaryChain>,
    space: &ParameterSpace<'_>,
    width: f64,
) -> Result<ClosedBoundary, BoundaryError> {
    let mut repairs: Vec<BoundaryRepair> =
        chains.iter().flat_map(|chain| chain.repairs.iter().copied()).collect();
    gather(&mut chains, space);
    let around = chains.iter().any(|chain| chain.winding[0] != 0);
    let ends = if around {
        Some(order_around(&mut chains, space, &mut repairs)?)
    } else {
        orient(&mut chains, space, &mut repairs)?;
        None
    };
    let window = window(&chains, space, width, ends);
    let turns_of = |chain: &BoundaryChain| {
        let [low, high] = bounds(&chain.curves);
        [0, 1].map(|axis| space.turns_into(axis, [low[axis] - width, high[axis] + width], window[axis]))
    };
    let (closed, open): (Vec<_>, Vec<_>) = chains.iter().partition(|chain| chain.winding[0] == 0);
    let copies = |chain: &BoundaryChain| -> f64 {
        let points: usize = chain.curves.iter().map(|curve| curve.points.len()).sum();
        turns_of(chain)
            .iter()
            .map(|turns| f64::from(*turns.end()) - f64::from(*turns.start()) + 1.0)
            .product::<f64>()
            * points as f64
    };
    if chains.iter().map(copies).sum::<f64>() > MAX_POINTS {
        return Err(BoundaryError::TooLarge);
    }
    let mut loops = Vec::new();
    for chain in closed {
        let [turns_u, turns_v] = turns_of(chain);
        for (u, v) in turns_u.flat_map(|u| turns_v.clone().map(move |v| (u, v))) {
            let shift = space.shift([u, v]);
            loops.push(chain.curves.iter().map(|curve| curve.translated(shift)).collect());
        }
    }
    // What lies below the window counts, too; all in the same numbers, so that the lowest remains the lowest.
    let rows = open.iter().map(|chain| turns_of(chain)[1].clone());
    let rows = rows.reduce(|a, b| *a.start().min(b.start())..=*a.end().max(b.end())).unwrap_or(0..=0);
    let rows = if space.periods[1].is_some() { *rows.start() - 1..=*rows.end() } else { rows };
    for chain in &open {
        loops.extend(rows.clone().map(|turns| closed_above(chain, space, turns, &window)));
    }
    if space.periods[1].is_none() && ends.is_some_and(|[lowest, _]| lowest < 0) {
        loops.push(rectangle(&window));
    }
    Ok(ClosedBoundary { loops, window, repairs })
}

/// Moves chains by periods next to the first one.
fn gather(chains: &mut [BoundaryChain], space: &ParameterSpace<'_>) {
    let center = |chain: &BoundaryChain| {
        let [low, high] = bounds(&chain.curves);
        0.5 * (low + high)
    };
    let Some((first, others)) = chains.split_first_mut() else { return };
    let [low, _] = bounds(&first.curves);
    // The first chain begins in the domain.
    let home = DVec2::new(space.domain[0][0], space.domain[1][0]);
    let shift = DVec2::from_array([0, 1].map(|axis| match space.periods[axis] {
        Some(p) if home[axis].is_finite() => -((low[axis] - home[axis]) / p).floor() * p,
        _ => 0.0,
    }));
    first.curves.iter_mut().for_each(|curve| *curve = curve.translated(shift));
    let to = center(first);
    for chain in others {
        let (shift, _) = space.shift_towards(center(chain), to);
        chain.curves.iter_mut().for_each(|curve| *curve = curve.translated(shift));
    }
}

/// Checks that the chains that go around bound one face, and orders them from below: on a surface that is periodic in v, too, the
/// lowest has the face above it. Returns the senses of the lowest and of the highest.
fn order_around(
    chains: &mut [BoundaryChain],
    space: &ParameterSpace<'_>,
    repairs: &mut Vec<BoundaryRepair>,
) -> Result<[i32; 2], BoundaryError> {
    // Loops that do not cross are in the order of their mean heights.
    let height = |chain: &BoundaryChain| {
        let corners = polygon(&chain.curves);
        let start = chain.curves.first().map(BoundaryCurve::start);
        let sides = start.iter().chain(&corners).zip(&corners);
        let (integral, length) = sides.fold((0.0, 0.0), |(integral, length), (a, b)| {
            (integral + 0.5 * (a.y + b.y) * (b.x - a.x), length + (b.x - a.x))
        });
        integral / length
    };
    if let Some(period) = space.periods[1] {
        let base = chains.iter().filter(|chain| chain.winding[0] > 0).map(height).next();
        let negative = chains.iter().filter(|chain| chain.winding[0] < 0).count();
        let base = base.ok_or(BoundaryError::Unpaired(0, negative))?;
        for chain in chains.iter_mut().filter(|chain| chain.winding[0] != 0) {
            let turns = ((height(chain) - base) / period).floor();
            let shift = DVec2::new(0.0, -turns * period);
            chain.curves.iter_mut().for_each(|curve| *curve = curve.translated(shift));
        }
    }
    let mut signs: Vec<(f64, i32)> = chains
        .iter()
        .filter(|chain| chain.winding[0] != 0)
        .map(|chain| (height(chain), chain.winding[0]))
        .collect();
    signs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let count = |sign: i32| signs.iter().filter(|(_, s)| *s == sign).count();
    if signs.windows(2).any(|pair| pair[0].1 == pair[1].1)
        || space.periods[1].is_some() && count(1) != count(-1)
    {
        return Err(BoundaryError::Unpaired(count(1), count(-1)));
    }
    let (mut first, mut last) = (signs.first().map_or(0, |s| s.1), signs.last().map_or(0, |s| s.1));
    // Beyond the loops a face ends in a pole; a border would have edges.
    let unbounded = |first: i32, last: i32| first < 0 && !space.poles[1][0] || last > 0 && !space.poles[1][1];
    if space.periods[1].is_none() && unbounded(first, last) {
        // A face between two loops whose outside is meant, or a cap towards infinity: the loops run the wrong way.
        if unbounded(-first, -last) {
            return Err(BoundaryError::Unbounded);
        }
        reverse_all(chains);
        (first, last) = (-first, -last);
        repairs.push(BoundaryRepair::ReversedBoundary);
    }
    // A face that goes around has no islands: what closes is a hole.
    for (number, chain) in chains.iter_mut().enumerate() {
        if chain.winding[0] == 0 && signed_area(&chain.curves) > 0.0 {
            reverse(chain);
            repairs.push(BoundaryRepair::ReversedLoop { number });
        }
    }
    Ok([first, last])
}

fn reverse(chain: &mut BoundaryChain) {
    chain.curves = chain.curves.drain(..).rev().map(BoundaryCurve::reversed).collect();
    chain.winding = chain.winding.map(|n| -n);
}

fn reverse_all(chains: &mut [BoundaryChain]) {
    chains.iter_mut().for_each(reverse);
}

/// Turns loops that leave an unbounded face: the largest one must run counter-clockwise and have those of the other sense inside.
fn orient(
    chains: &mut [BoundaryChain],
    space: &ParameterSpace<'_>,
    repairs: &mut Vec<BoundaryRepair>,
) -> Result<(), BoundaryError> {
    let mut areas: Vec<f64> = chains.iter().map(|chain| signed_area(&chain.curves)).collect();
    let Some(largest) = (0..areas.len()).max_by(|&a, &b| areas[a].abs().total_cmp(&areas[b].abs())) else {
        return if space.is_finite() { Ok(()) } else { Err(BoundaryError::Unbounded) };
    };
    if areas[largest] < 0.0 {
        if space.is_closed() {
            return Ok(());
        }
        // All others being holes of the other sense, the whole boundary runs the wrong way; otherwise only the outer loop does.
        if (0..areas.len()).all(|i| i == largest || areas[i] > 0.0) {
            reverse_all(chains);
            areas.iter_mut().for_each(|area| *area = -*area);
            repairs.push(BoundaryRepair::ReversedBoundary);
        } else {
            reverse(&mut chains[largest]);
            repairs.push(BoundaryRepair::ReversedLoop { number: largest });
        }
    }
    // A face has no islands: what lies inside the outer loop is a hole.
    let outer = polygon(&chains[largest].curves);
    for number in (0..chains.len()).filter(|&number| number != largest && areas[number] > 0.0) {
        let inside = chains[number].curves.first().is_some_and(|curve| encloses(&outer, curve.start()));
        if inside {
            reverse(&mut chains[number]);
            repairs.push(BoundaryRepair::ReversedLoop { number });
        }
    }
    Ok(())
}

/// Whether a closed polygon goes around a point.
fn encloses(corners: &[DVec2], point: DVec2) -> bool {
    let sides = corners.iter().zip(corners.iter().cycle().skip(1));
    let crossings = sides.filter(|(a, b)| {
        (a.y > point.y) != (b.y > point.y) && point.x < a.x + (b.x - a.x) * (point.y - a.y) / (b.y - a.y)
    });
    crossings.count() % 2 == 1
}

fn bounds(curves: &[BoundaryCurve]) -> [DVec2; 2] {
    curves
        .iter()
        .map(BoundaryCurve::bounds)
        .fold([DVec2::INFINITY, DVec2::NEG_INFINITY], |[low, high], [a, b]| [low.min(a), high.max(b)])
}

/// The part of the domain that contains the face. `ends`: the senses of the lowest and the highest loop that go around.
fn window(
    chains: &[BoundaryChain],
    space: &ParameterSpace<'_>,
    width: f64,
    ends: Option<[i32; 2]>,
) -> [[f64; 2]; 2] {
    let boxes = chains.iter().map(|chain| bounds(&chain.curves));
    let [low, high] =
        boxes.fold([DVec2::INFINITY, DVec2::NEG_INFINITY], |[low, high], [a, b]| [low.min(a), high.max(b)]);
    let extent = (high - low).max_element().max(0.0);
    let margin = width + MARGIN * extent;
    let complement = chains.iter().all(|chain| chain.winding[0] == 0)
        && chains
            .iter()
            .map(|chain| signed_area(&chain.curves))
            .max_by(|a, b| a.abs().total_cmp(&b.abs()))
            .is_none_or(|area| area < 0.0);
    let around = ends.is_some();
    [0, 1].map(|axis| {
        let [from, to] = space.domain[axis];
        let wanted = [low[axis] - margin, high[axis] + margin];
        if let Some(period) = space.periods[axis] {
            let passes_seam = wanted[0] < from || wanted[1] > from + period;
            let whole = complement
                || around
                || wanted[1] - wanted[0] >= period
                || passes_seam && !space.movable[axis];
            return match (whole, space.movable[axis]) {
                (true, true) if wanted[0].is_finite() => [low[axis], low[axis] + period],
                (true, _) => [from, from + period],
                (false, _) => wanted,
            };
        }
        if complement {
            return [from, to];
        }
        // Loops that go around may bound a face that goes on to the end of the domain.
        let [open_below, open_above] =
            ends.filter(|_| axis == 1).map_or([false; 2], |[lowest, highest]| [lowest < 0, highest > 0]);
        [if open_below { from } else { wanted[0].max(from) }, if open_above { to } else { wanted[1].min(to) }]
    })
}

/// How far beyond the window, in parts of it, curves close that are not seen.
const BEYOND: f64 = 0.25;

/// A chain that goes around, continued over the window and closed above it, moved by `turns` periods of v.
fn closed_above(
    chain: &BoundaryChain,
    space: &ParameterSpace<'_>,
    turns: i32,
    window: &[[f64; 2]; 2],
) -> Vec<BoundaryCurve> {
    let [low, high] = bounds(&chain.curves);
    let period = space.periods[0].unwrap_or(0.0);
    let size = window.map(|[from, to]| to - from);
    let all = space.turns_into(
        0,
        [low.x, high.x],
        [window[0][0] - BEYOND * size[0], window[0][1] + BEYOND * size[0]],
    );
    let sense = chain.winding[0];
    // One more at each end, since the chain may go back before it goes on; and again one more, so that the lowest loop encloses
    // the largest area, whose sense tells where the face is.
    let more = if sense > 0 { 2 } else { 1 };
    let all = *all.start() - more..=*all.end() + more;
    let copies: Vec<i32> = if sense > 0 { all.collect() } else { all.rev().collect() };
    let mut curves: Vec<BoundaryCurve> = copies
        .into_iter()
        .flat_map(|k| {
            let shift = DVec2::new(period * f64::from(k), 0.0) + space.shift([0, turns]);
            chain.curves.iter().map(move |curve| curve.translated(shift))
        })
        .collect();
    let (Some(start), Some(end)) =
        (curves.first().map(BoundaryCurve::start), curves.last().map(BoundaryCurve::end))
    else {
        return curves;
    };
    let top =
        (window[1][1] + 2.0 * BEYOND * size[1]).max(high.y + space.shift([0, turns]).y + BEYOND * size[1]);
    let corners = [end, DVec2::new(end.x, top), DVec2::new(start.x, top), start];
    curves.extend(corners.windows(2).map(|pair| BoundaryCurve::line(pair[0], pair[1])));
    curves
}

/// The window and more, counter-clockwise: larger than any loop that goes around.
fn rectangle(window: &[[f64; 2]; 2]) -> Vec<BoundaryCurve> {
    let size = window.map(|[from, to]| to - from);
    let wide = 4.0 * size[0];
    let (x, y) =
        ([window[0][0] - wide, window[0][1] + wide], [window[1][0] - size[1], window[1][1] + 4.0 * size[1]]);
    let corners = [(0, 0), (1, 0), (1, 1), (0, 1), (0, 0)].map(|(i, j)| DVec2::new(x[i], y[j]));
    corners.windows(2).map(|pair| BoundaryCurve::line(pair[0], pair[1])).collect()
}
