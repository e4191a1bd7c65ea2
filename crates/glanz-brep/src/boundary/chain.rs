//! Joining the curves of a loop.

use super::curve::BoundaryCurve;
use super::space::{ParameterSpace, Side};
use super::{BoundaryError, BoundaryRepair};
use glanz_math::DVec2;

/// The curves of a loop, each of which ends where the next one starts. The last ends at the start of the first, moved by periods.
#[derive(Clone, Debug, PartialEq)]
pub struct BoundaryChain {
    /// The curves.
    pub curves: Vec<BoundaryCurve>,
    /// How often it goes around each period.
    pub winding: [i32; 2],
    /// Repairs that were necessary.
    pub repairs: Vec<BoundaryRepair>,
}

/// Joins the curves of a loop, which may each be displaced by periods. The face is on their left.
///
/// `tolerance`: distance in space up to which points are meant to coincide; `limit`: up to which gaps are bridged; metres.
///
/// # Errors
/// [`BoundaryError::Empty`], [`BoundaryError::OpenLoop`], [`BoundaryError::NotFinite`].
pub fn chain(
    curves: Vec<BoundaryCurve>,
    space: &ParameterSpace<'_>,
    tolerance: f64,
    limit: f64,
) -> Result<BoundaryChain, BoundaryError> {
    if !curves.iter().all(BoundaryCurve::is_finite) {
        return Err(BoundaryError::NotFinite);
    }
    let curves: Vec<BoundaryCurve> = curves.into_iter().map(|curve| space.moved_home(curve)).collect();
    if !curves.iter().all(|curve| space.spans_few_periods(curve)) {
        return Err(BoundaryError::TooLarge);
    }
    let mut joining =
        Joining { space, tolerance, limit, curves: Vec::with_capacity(curves.len()), repairs: Vec::new() };
    let mut waiting = curves.into_iter().peekable();
    let mut first = waiting.next().ok_or(BoundaryError::Empty)?;
    if let Some(second) = waiting.peek() {
        let reversed = first.clone().reversed();
        if joining.runs_against(&first, second) && !joining.runs_against(&reversed, second) {
            joining.reverse(&mut first);
        }
    }
    joining.curves.push(first);
    for mut next in waiting {
        let last = joining.last_curve();
        let reversed = next.clone().reversed();
        if joining.gap(last.end(), next.start()) > tolerance
            && joining.gap(last.end(), reversed.start()) <= tolerance
        {
            joining.reverse(&mut next);
        }
        joining.append(next)?;
    }
    let winding = joining.close()?;
    Ok(BoundaryChain { curves: joining.curves, winding, repairs: joining.repairs })
}

struct Joining<'a> {
    space: &'a ParameterSpace<'a>,
    tolerance: f64,
    limit: f64,
    curves: Vec<BoundaryCurve>,
    repairs: Vec<BoundaryRepair>,
}

impl Joining<'_> {
    fn last_curve(&self) -> BoundaryCurve {
        self.curves.last().cloned().unwrap_or_else(|| BoundaryCurve::line(DVec2::NAN, DVec2::NAN))
    }

    fn gap(&self, a: DVec2, b: DVec2) -> f64 {
        (self.space.point)(a).distance((self.space.point)(b))
    }

    /// Whether `curve` meets neither end of `next` with its end, but one of them with its start.
    fn runs_against(&self, curve: &BoundaryCurve, next: &BoundaryCurve) -> bool {
        let meets =
            |point| [next.start(), next.end()].iter().any(|&end| self.gap(point, end) <= self.tolerance);
        !meets(curve.end()) && meets(curve.start())
    }

    fn reverse(&mut self, curve: &mut BoundaryCurve) {
        *curve = curve.clone().reversed();
        self.repairs.extend(curve.edge.map(|edge| BoundaryRepair::ReversedEdge { edge }));
    }

    /// Appends a curve, moved by periods to the end of the chain.
    fn append(&mut self, next: BoundaryCurve) -> Result<(), BoundaryError> {
        let last = self.last_curve();
        let turns = self.turns(&last, &next);
        let next = next.translated(self.space.shift(turns));
        self.bridge(next.start())?;
        self.curves.push(next);
        Ok(())
    }

    /// Joins the end of the chain to its start; returns how often it went around.
    fn close(&mut self) -> Result<[i32; 2], BoundaryError> {
        let (Some(first), last) = (self.curves.first().cloned(), self.last_curve()) else {
            return Err(BoundaryError::Empty);
        };
        let turns = self.turns(&last, &first);
        self.bridge(first.start() + self.space.shift(turns))?;
        Ok(turns)
    }

    /// The periods by which `next` is to be moved to continue `last`.
    fn turns(&self, last: &BoundaryCurve, next: &BoundaryCurve) -> [i32; 2] {
        let (end, start) = (last.end(), next.start());
        let (shift, turns) = self.space.shift_towards(start, end);
        let Some(side) = self.common_pole(end, start) else { return turns };
        let along = 1 - side.0;
        let Some(period) = self.space.periods[along] else { return turns };
        // With the face on the left, the pole is passed in one direction only.
        let ahead = pole_direction(side) * (start[along] + shift[along] - end[along]);
        let rounding = f64::EPSILON.sqrt() * period;
        let seam = last.edge.is_some() && last.edge == next.edge && self.curves.len() > 1;
        let more =
            if ahead < -rounding || ahead <= rounding && seam { pole_direction(side) as i32 } else { 0 };
        let mut turns = turns;
        turns[along] += more;
        turns
    }

    /// The pole in which two points lie.
    fn common_pole(&self, a: DVec2, b: DVec2) -> Option<Side> {
        let side = self.space.pole_at(a, self.tolerance)?;
        (self.space.pole_at(b, self.tolerance) == Some(side)).then_some(side)
    }

    /// Adds what lies between the end of the chain and `start`.
    fn bridge(&mut self, start: DVec2) -> Result<(), BoundaryError> {
        let last = self.last_curve();
        let end = last.end();
        if let Some((axis, upper)) = self.common_pole(end, start) {
            // The pole itself joins them.
            let value = self.space.domain[axis][usize::from(upper)];
            let on_side = |mut point: DVec2| {
                point[axis] = value;
                point
            };
            let corners = [end, on_side(end), on_side(start), start];
            let lines = corners.windows(2).filter(|pair| pair[0] != pair[1]);
            self.curves.extend(lines.map(|pair| BoundaryCurve::line(pair[0], pair[1])));
            return Ok(());
        }
        let gap = self.gap(end, start);
        if gap > self.limit {
            return Err(BoundaryError::OpenLoop { gap, limit: self.limit });
        }
        if gap > self.tolerance {
            self.repairs.push(BoundaryRepair::BridgedGap { gap });
        }
        if end != start {
            self.curves.push(BoundaryCurve { width: last.width.max(gap), ..BoundaryCurve::line(end, start) });
        }
        Ok(())
    }
}

/// The direction, +1 or -1, in which a boundary with the face on its left passes a side.
fn pole_direction((axis, upper): Side) -> f64 {
    if (axis == 1) == upper { -1.0 } else { 1.0 }
}
