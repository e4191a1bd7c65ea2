//! One tube around a part of a trimming curve.

use glanz_math::{Bounds3, DVec2, DVec3, Ray};

/// The points within a radius of a straight segment, which is close to a part of a trimming curve.
#[derive(Clone, Copy, Debug)]
pub(super) struct EdgeTube {
    pub(super) start: DVec3,
    pub(super) along: DVec3,
    pub(super) radius: f64,
    pub(super) face: u32,
    /// Parameters of hits at both ends.
    pub(super) parameters: [DVec2; 2],
}

/// Where a line is nearest to the axis of a tube that it passes through.
#[derive(Clone, Copy, Debug)]
pub(super) struct TubeApproach {
    /// Parameter of the line.
    pub(super) t: f64,
    /// Position along the axis, from 0 to 1.
    pub(super) s: f64,
    pub(super) distance: f64,
}

impl EdgeTube {
    pub(super) fn bounds(&self) -> Bounds3 {
        Bounds3::new(self.start, self.end()).expanded(self.radius)
    }

    pub(super) fn end(&self) -> DVec3 {
        self.start + self.along
    }

    pub(super) fn contains(&self, point: DVec3) -> bool {
        let offset = point - self.start;
        let s = (offset.dot(self.along) / self.along.length_squared()).clamp(0.0, 1.0);
        let axis = if s.is_finite() { s * self.along } else { DVec3::ZERO };
        offset.distance(axis) <= self.radius
    }

    /// Where a line is nearest to the axis; `None` if the line does not pass through the tube.
    pub(super) fn approach(&self, line: &Ray) -> Option<TubeApproach> {
        let (d, e, offset) = (line.direction, self.along, self.start - line.origin);
        let (dd, de, ee) = (d.length_squared(), d.dot(e), e.length_squared());
        let between = ((de * d.dot(offset) - dd * e.dot(offset)) / (dd * ee - de * de)).clamp(0.0, 1.0);
        // Of almost parallel lines, where the quotient is inaccurate, an end is near.
        let candidates = [between, 0.0, 1.0].into_iter().filter(|s| s.is_finite()).map(|s| {
            let q = offset + s * e;
            let t = d.dot(q) / dd;
            TubeApproach { t, s, distance: (q - t * d).length() }
        });
        let nearest = candidates.min_by(|a, b| a.distance.total_cmp(&b.distance));
        nearest.filter(|nearest| nearest.distance <= self.radius)
    }

    /// The range of parameters, around the nearest point, outside of which the line is certainly not in the tube.
    pub(super) fn range(&self, line: &Ray, nearest: &TubeApproach) -> [f64; 2] {
        let (length, along) = (line.direction.length(), self.along.length());
        let sine = line.direction.cross(self.along).length() / (length * along);
        // A line parallel to the tube has no sine, and one without length is a sphere.
        let across = (2.0 * self.radius / sine).min(2.0 * self.radius + along);
        let reach = if across.is_nan() { 2.0 * self.radius } else { across } / length;
        [nearest.t - reach, nearest.t + reach]
    }
}
