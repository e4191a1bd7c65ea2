//! Edges that patches share, and their samples.

use std::f64::consts::FRAC_PI_2;

use glanz_math::{DVec2, DVec3};

use super::TessellationSettings;
use super::patch::MeshPatch;
use super::patch_side::PatchSide;

/// What makes an edge the same for several patches.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) enum EdgeKey {
    /// The number that the description gives.
    Numbered(u32),
    /// The curve of a side.
    Side(PatchSide),
    /// An edge of one patch, or the seam of one.
    Own(usize),
}

/// An edge as a part of the border of a patch.
#[derive(Clone, Copy, Debug)]
pub(super) struct EdgeUse {
    pub(super) patch: usize,
    pub(super) place: EdgePlace,
    /// The fractions of the edge at its start and at its end.
    pub(super) range: [f64; 2],
}

/// Where a patch has an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum EdgePlace {
    /// A curve of its boundary.
    Curve {
        /// Index of the loop.
        number: usize,
        /// Index in the loop.
        curve: usize,
    },
    /// The side from a corner to the next.
    Side(usize),
}

impl EdgeUse {
    /// The parameters of the patch at `t` in [0, 1].
    pub(super) fn at(&self, patch: &MeshPatch, t: f64) -> DVec2 {
        match self.place {
            EdgePlace::Curve { number, curve } => {
                let curve = patch.trim.as_ref().and_then(|trim| trim.loops.get(number)?.get(curve));
                curve.map_or(DVec2::NAN, |curve| curve.at(t))
            }
            EdgePlace::Side(side) => {
                let corner = |i: usize| {
                    patch.corners.get(i % patch.corners.len().max(1)).copied().unwrap_or(DVec2::NAN)
                };
                let (from, to) = (corner(side), corner(side + 1));
                // Exact at both ends, and in a coordinate that both share.
                if t > 0.5 { to + (from - to) * (1.0 - t) } else { from + (to - from) * t }
            }
        }
    }

    /// Where it is smooth, in [0, 1].
    fn breaks(&self, patch: &MeshPatch) -> Vec<f64> {
        match self.place {
            EdgePlace::Curve { number, curve } => {
                let curve = patch.trim.as_ref().and_then(|trim| trim.loops.get(number)?.get(curve));
                curve.map(|curve| curve.breaks()).unwrap_or_default()
            }
            EdgePlace::Side(side) => {
                let axis = side % 2;
                let [low, high] = patch.window().map(|corner| corner[axis]);
                let inner = patch.breaks[axis].iter().map(|at| (at - low) / (high - low));
                let inner = inner.map(|at| if side < 2 { at } else { 1.0 - at });
                inner.filter(|at| *at > 0.0 && *at < 1.0).collect()
            }
        }
    }

    /// The place of a fraction of the edge.
    pub(super) fn place_of(&self, fraction: f64) -> f64 {
        let [from, to] = self.range;
        if fraction == to { 1.0 } else { (fraction - from) / (to - from) }
    }

    /// The fraction of the edge at a place.
    pub(super) fn fraction_at(&self, t: f64) -> f64 {
        let [from, to] = self.range;
        if t == 1.0 { to } else { from + (to - from) * t }
    }

    fn covers(&self, fraction: f64) -> bool {
        let [a, b] = self.range;
        (a.min(b)..=a.max(b)).contains(&fraction)
    }
}

/// An edge with its uses.
#[derive(Clone, Debug, Default)]
pub(super) struct SharedEdge {
    /// Numbers of its vertices in the description.
    pub(super) vertices: Option<[u32; 2]>,
    pub(super) uses: Vec<EdgeUse>,
    /// Fractions at which it must be sampled, ascending, with the vertex that is there, if there is one.
    pub(super) pins: Vec<(f64, Option<u32>)>,
    /// Places of some uses that belong to a pin, ascending by fraction: the index of the use, the fraction, the place.
    pub(super) pinned: Vec<(usize, f64, f64)>,
    /// Further fractions at which it is sampled.
    pub(super) divisions: Vec<f64>,
    /// Ranges of fractions in which other edges lie on it.
    pub(super) covered: Vec<[f64; 2]>,
    /// Fractions with the vertices there, ascending.
    pub(super) samples: Vec<(f64, u32)>,
    /// Largest distance of a chord from the edge, metres.
    pub(super) deviation: f64,
}

/// Evaluation of an edge.
pub(super) struct EdgeSampler<'a> {
    patches: &'a [MeshPatch],
    edge: &'a SharedEdge,
    settings: TessellationSettings,
    breaks: Vec<f64>,
}

/// Parts of the deviation below which two curves count as one.
const SAME: f64 = 1e-3;

impl<'a> EdgeSampler<'a> {
    pub(super) fn new(
        patches: &'a [MeshPatch],
        edge: &'a SharedEdge,
        settings: TessellationSettings,
    ) -> Self {
        let mut sampler = Self { patches, edge, settings, breaks: Vec::new() };
        let breaks = edge.uses.iter().filter_map(|a_use| {
            let patch = patches.get(a_use.patch)?;
            Some(a_use.breaks(patch).into_iter().map(|t| a_use.fraction_at(t)))
        });
        sampler.breaks = breaks.take(1).flatten().collect();
        sampler
    }

    fn on_use(&self, a_use: &EdgeUse, t: f64) -> DVec3 {
        self.patches.get(a_use.patch).map_or(DVec3::NAN, |patch| patch.point(a_use.at(patch, t)))
    }

    /// The point of the edge: that of the first patch that has it there, inside its parameters if possible. NaN where none has it.
    pub(super) fn point(&self, fraction: f64) -> DVec3 {
        let mut beside = DVec3::NAN;
        for a_use in self.edge.uses.iter().filter(|a_use| a_use.covers(fraction)) {
            let Some(patch) = self.patches.get(a_use.patch) else { continue };
            let uv = a_use.at(patch, a_use.place_of(fraction));
            let point = patch.point(uv);
            if point.is_finite() && patch.has(uv) {
                return point;
            }
            if !beside.is_finite() {
                beside = point;
            }
        }
        beside
    }

    /// The place of a use where it is nearest to the point of the edge at a fraction.
    pub(super) fn place(&self, number: usize, fraction: f64) -> f64 {
        let pinned = &self.edge.pinned;
        let first = pinned.partition_point(|pin| pin.1 < fraction);
        let mut here = pinned.iter().skip(first).take_while(|pin| pin.1 == fraction);
        if let Some(&(_, _, t)) = here.find(|pin| pin.0 == number) {
            return t;
        }
        let Some(a_use) = self.edge.uses.get(number) else { return 0.0 };
        let guess = a_use.place_of(fraction).clamp(0.0, 1.0);
        // Both ends belong together whatever lies between them.
        if guess == 0.0 || guess == 1.0 {
            return guess;
        }
        self.nearest(self.point(fraction), guess, |t| self.on_use(a_use, t))
    }

    /// The fraction of the edge that is nearest to the point of a use at a place.
    pub(super) fn fraction(&self, number: usize, t: f64) -> f64 {
        let Some(a_use) = self.edge.uses.get(number) else { return 0.0 };
        let guess = a_use.fraction_at(t);
        self.nearest(self.on_use(a_use, t), guess, |fraction| self.point(fraction))
    }

    /// The parameter near `guess` at which a curve over [0, 1] is nearest to a point.
    fn nearest(&self, point: DVec3, guess: f64, curve: impl Fn(f64) -> DVec3) -> f64 {
        /// Half the part of the curve that is searched, and its samples.
        const REACH: f64 = 0.2;
        const SAMPLES: u32 = 24;
        /// Halvings of the last interval.
        const STEPS: u32 = 40;
        let distance = |t: f64| curve(t).distance(point);
        if distance(guess) <= SAME * self.settings.deviation {
            return guess;
        }
        let (low, high) = ((guess - REACH).max(0.0), (guess + REACH).min(1.0));
        let at = |i: u32| low + (high - low) * f64::from(i) / f64::from(SAMPLES);
        let best = (0..=SAMPLES).min_by(|&a, &b| distance(at(a)).total_cmp(&distance(at(b)))).unwrap_or(0);
        let (mut low, mut high) = (at(best.saturating_sub(1)), at((best + 1).min(SAMPLES)));
        for _ in 0..STEPS {
            let third = (high - low) / 3.0;
            if distance(low + third) < distance(high - third) {
                high -= third;
            } else {
                low += third;
            }
        }
        let found = 0.5 * (low + high);
        if distance(found) < distance(guess) { found } else { guess }
    }

    /// Fractions of samples, ascending, from 0 to 1, and the largest distance of a chord from the edge, metres. A chord is never shorter than one half
    /// to the power of `depth` between two pins.
    pub(super) fn fractions(&self, depth: u32) -> (Vec<f64>, f64) {
        let mut ends: Vec<f64> = self.edge.pins.iter().map(|pin| pin.0).chain([0.0, 1.0]).collect();
        // Parts of one use may end where others go on.
        ends.extend(self.edge.uses.iter().flat_map(|a_use| a_use.range));
        ends.retain(|end| (0.0..=1.0).contains(end));
        ends.sort_by(f64::total_cmp);
        ends.dedup();
        let mut fractions = vec![0.0];
        let mut deviation = 0.0_f64;
        for pair in ends.windows(2) {
            let (low, high) = (pair[0], pair[1]);
            let middle = 0.5 * (low + high);
            if !self.edge.covered.iter().any(|&[a, b]| a <= middle && middle <= b) {
                deviation = deviation.max(self.divide(low, high, depth, &mut fractions));
            }
            fractions.push(high);
        }
        fractions.extend(&self.edge.divisions);
        fractions.sort_by(f64::total_cmp);
        fractions.dedup();
        (fractions, deviation)
    }

    /// Adds the samples between two fractions, and returns the largest distance of a chord from the edge, metres.
    fn divide(&self, low: f64, high: f64, depth: u32, fractions: &mut Vec<f64>) -> f64 {
        let (is_chord, distance) = self.chord(low, high);
        if is_chord || depth == 0 {
            return distance;
        }
        let middle = 0.5 * (low + high);
        let before = self.divide(low, middle, depth - 1, fractions);
        fractions.push(middle);
        before.max(self.divide(middle, high, depth - 1, fractions))
    }

    /// Whether a chord is as close to the edge as the settings demand, and its distance from it; if it is too far, that of triangles next to it as well.
    fn chord(&self, low: f64, high: f64) -> (bool, f64) {
        /// Points compared on a smooth curve, and at most.
        const POINTS: [usize; 2] = [8, 256];
        let breaks = self.breaks.iter().filter(|at| (low..high).contains(*at)).count();
        let parts = (2 * (breaks + 1)).clamp(POINTS[0], POINTS[1]);
        let points: Vec<DVec3> =
            (0..=parts).map(|i| self.point(low + (high - low) * i as f64 / parts as f64)).collect();
        let (Some(&from), Some(&to)) = (points.first(), points.last()) else { return (true, 0.0) };
        let mut steps: Vec<DVec3> = points.windows(2).map(|pair| pair[1] - pair[0]).collect();
        steps.retain(|step| *step != DVec3::ZERO);
        let length: f64 = steps.iter().map(|step| step.length()).sum();
        let TessellationSettings { deviation, angle } = self.settings;
        let turn: f64 = steps.windows(2).map(|pair| pair[0].angle_between(pair[1])).sum();
        let turn = turn * parts as f64 / (parts - 1) as f64;
        let strays = points.iter().map(|&p| distance_to_segment(p, from, to)).fold(0.0, f64::max);
        // Rounding turns curves that are points.
        if length.is_nan() || length <= f64::EPSILON * from.length() * 64.0 {
            return (true, strays);
        }
        let angle = if length <= deviation { angle.max(FRAC_PI_2) } else { angle };
        let beside = strays.max(self.image_bend(low, high));
        if beside > deviation { (false, beside) } else { (turn <= angle, strays) }
    }

    /// How much the line that is straight in the parameters of a patch bends between two fractions, metres: triangles next to the chord end there.
    fn image_bend(&self, low: f64, high: f64) -> f64 {
        const PLACES: [f64; 3] = [0.25, 0.5, 0.75];
        let curves = self.edge.uses.iter().filter(|a_use| matches!(a_use.place, EdgePlace::Curve { .. }));
        let within = curves.filter(|a_use| a_use.covers(low) && a_use.covers(high));
        let bends = within.filter_map(|a_use| {
            let patch = self.patches.get(a_use.patch)?;
            let [start, end] = [low, high].map(|fraction| a_use.at(patch, a_use.place_of(fraction)));
            let (from, to) = (patch.point(start), patch.point(end));
            let distance = |&t: &f64| distance_to_segment(patch.point(start + (end - start) * t), from, to);
            Some(PLACES.iter().map(distance).fold(0.0, f64::max))
        });
        bends.fold(0.0, f64::max)
    }
}

/// Distance of a point from a straight segment.
pub(super) fn distance_to_segment(point: DVec3, from: DVec3, to: DVec3) -> f64 {
    let along = to - from;
    let t = ((point - from).dot(along) / along.length_squared()).clamp(0.0, 1.0);
    point.distance(if t.is_nan() { from } else { from + along * t })
}
