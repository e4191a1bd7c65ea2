//! The parameters of a carrier.

use glanz_math::glam::DMat2;
use glanz_math::{DVec2, DVec3};

use super::curve::BoundaryCurve;

/// The parameters of a carrier as boundaries need them, in region coordinates.
#[derive(Clone, Copy)]
pub struct ParameterSpace<'a> {
    /// Range of each coordinate; may be infinite.
    pub domain: [[f64; 2]; 2],
    /// Period of each coordinate.
    pub periods: [Option<f64>; 2],
    /// Whether the domain may begin anywhere in a periodic coordinate, as the azimuth of a surface of revolution.
    pub movable: [bool; 2],
    /// Whether the side of the domain at the lower and at the upper end of each coordinate is a single point.
    pub poles: [[bool; 2]; 2],
    /// The point of the carrier, metres.
    pub point: &'a dyn Fn(DVec2) -> DVec3,
}

/// A quarter turn of the coordinates: (x, y) -> (y, -x).
pub(super) const QUARTER_TURN: DMat2 = DMat2::from_cols_array(&[0.0, -1.0, 1.0, 0.0]);

/// A side of the domain: the coordinate that is fixed on it, and whether it is at the upper end.
pub(super) type Side = (usize, bool);

impl ParameterSpace<'_> {
    /// Whether the whole carrier is finite.
    pub(super) fn is_finite(&self) -> bool {
        (0..2).all(|axis| self.periods[axis].is_some() || self.domain[axis].iter().all(|end| end.is_finite()))
    }

    /// Whether the whole carrier has no border.
    pub(crate) fn is_closed(&self) -> bool {
        (0..2).all(|axis| self.periods[axis].is_some() || self.poles[axis] == [true; 2])
    }

    /// The pole within `tolerance` (metres) of a point.
    pub(super) fn pole_at(&self, at: DVec2, tolerance: f64) -> Option<Side> {
        let position = (self.point)(at);
        let sides = [0, 1].into_iter().flat_map(|axis| [(axis, false), (axis, true)]);
        sides.filter(|&(axis, upper)| self.poles[axis][usize::from(upper)]).find(|&(axis, upper)| {
            let mut on_side = at;
            on_side[axis] = self.domain[axis][usize::from(upper)];
            (self.point)(on_side).distance(position) <= tolerance
        })
    }

    /// The curve, moved by whole periods so that it starts in the domain.
    pub(super) fn moved_home(&self, curve: BoundaryCurve) -> BoundaryCurve {
        let start = curve.start();
        let shift = [0, 1].map(|axis| match self.periods[axis] {
            Some(period) => -((start[axis] - self.domain[axis][0]) / period).floor() * period,
            None => 0.0,
        });
        curve.translated(DVec2::from_array(shift))
    }

    /// Whether a curve that starts in the domain ends after few enough periods to count them.
    pub(super) fn spans_few_periods(&self, curve: &BoundaryCurve) -> bool {
        /// More than any thread has turns, less than numbers count.
        const MOST: f64 = 1e5;
        let [low, high] = curve.bounds();
        let spans =
            |axis: usize| self.periods[axis].is_none_or(|period| high[axis] - low[axis] < MOST * period);
        spans(0) && spans(1)
    }

    /// The displacement by whole periods that brings `from` next to `to`, and the numbers of periods.
    pub(super) fn shift_towards(&self, from: DVec2, to: DVec2) -> (DVec2, [i32; 2]) {
        let turns =
            [0, 1].map(|axis| self.periods[axis].map_or(0.0, |p| ((to[axis] - from[axis]) / p).round()));
        (self.shift(turns.map(|n| n as i32)), turns.map(|n| n as i32))
    }

    /// The displacement by numbers of periods.
    pub(super) fn shift(&self, turns: [i32; 2]) -> DVec2 {
        DVec2::from_array([0, 1].map(|axis| self.periods[axis].unwrap_or(0.0) * f64::from(turns[axis])))
    }

    /// The numbers of periods in each coordinate that bring a range `low` to `high` into a window.
    pub(super) fn turns_into(
        &self,
        axis: usize,
        [low, high]: [f64; 2],
        window: [f64; 2],
    ) -> std::ops::RangeInclusive<i32> {
        match self.periods[axis] {
            None => 0..=0,
            Some(p) => ((window[0] - high) / p).ceil() as i32..=((window[1] - low) / p).floor() as i32,
        }
    }
}
