//! Intersection of rays with convex solids.

/// A crossing of a ray with a facet of a solid.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FacetCrossing {
    /// Ray parameter.
    pub(crate) t: f64,
    /// Number of the facet.
    pub(crate) facet: u32,
}

/// The interval of a ray's line inside a convex solid.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ConvexInterval {
    pub(crate) enter: FacetCrossing,
    pub(crate) leave: FacetCrossing,
}

impl ConvexInterval {
    /// The whole line, to be clipped.
    pub(crate) const LINE: Self = Self {
        enter: FacetCrossing { t: f64::NEG_INFINITY, facet: 0 },
        leave: FacetCrossing { t: f64::INFINITY, facet: 0 },
    };

    /// Clips the interval at a facet through which the line enters the solid.
    pub(crate) fn clip_start(&mut self, crossing: FacetCrossing) {
        if crossing.t > self.enter.t {
            self.enter = crossing;
        }
    }

    /// Clips the interval at a facet through which the line leaves the solid.
    pub(crate) fn clip_end(&mut self, crossing: FacetCrossing) {
        if crossing.t < self.leave.t {
            self.leave = crossing;
        }
    }

    /// Whether the interval is empty.
    pub(crate) fn is_empty(&self) -> bool {
        self.enter.t > self.leave.t
    }

    /// The first crossing with `0 < t < t_max`.
    pub(crate) fn first(&self, t_max: f64) -> Option<FacetCrossing> {
        let crossing = if self.enter.t > 0.0 { self.enter } else { self.leave };
        (crossing.t > 0.0 && crossing.t < t_max).then_some(crossing)
    }

    /// All crossings with `0 < t < t_max`, ascending.
    pub(crate) fn all(self, t_max: f64) -> impl Iterator<Item = FacetCrossing> {
        let Self { enter, leave } = self;
        let second = (leave.t > enter.t).then_some(leave);
        Some(enter).into_iter().chain(second).filter(move |crossing| crossing.t > 0.0 && crossing.t < t_max)
    }
}
