//! Bounds of position and normal of a part of a mirror.
//!
//! For freeform faces the bounds are certain: a patch lies in the hull of its control points, and its normals lie in the hull of the control points of the
//! polynomial normal, whose net is computed once and halved with the patch. For all other faces they are estimates from samples on a grid, with
//! twice the largest step between neighbours as the margin for points between the samples.

use glanz_geometry::Surface;
use glanz_geometry::bezier::TensorPatch;
use glanz_math::glam::DVec4;
use glanz_math::{Bounds3, DVec2, DVec3, Transform};

use super::net::Net;
use super::region::IntegrationRect;

/// A ball that contains the points, and a cone that contains the normals or their opposites.
#[derive(Clone, Copy, Debug)]
pub(super) struct MirrorExtent {
    pub(super) center: DVec3,
    pub(super) radius: f64,
    pub(super) axis: DVec3,
    /// Half angle of the cone; pi if the normals have all directions.
    pub(super) angle: f64,
}

impl MirrorExtent {
    /// The extent of both.
    pub(super) fn union(&self, other: &Self) -> Self {
        let center = 0.5 * (self.center + other.center);
        let radius = [self, other].map(|e| e.center.distance(center) + e.radius);
        // A normal and its opposite describe the same mirror.
        let turned = if self.axis.dot(other.axis) < 0.0 { -other.axis } else { other.axis };
        let axis = (self.axis + turned).try_normalize().unwrap_or(self.axis);
        let angle =
            (self.axis.angle_between(axis) + self.angle).max(turned.angle_between(axis) + other.angle);
        Self { center, radius: radius[0].max(radius[1]), axis, angle: angle.min(std::f64::consts::PI) }
    }
}

/// Bounds of the derivatives of points and normals by each parameter: metres and radians per unit.
#[derive(Clone, Copy, Debug)]
pub(super) struct DerivativeBounds {
    pub(super) points: DVec2,
    pub(super) normals: DVec2,
}

/// A part of a face, to be halved.
pub(super) enum MirrorPart {
    Certain(MirrorPatch),
    Estimated,
}

/// A part of a freeform face in the world.
pub(super) struct MirrorPatch {
    /// Homogeneous.
    points: Net<DVec4>,
    normals: Net<DVec3>,
}

impl MirrorPatch {
    fn new(patch: &TensorPatch, to_world: &Transform) -> Self {
        let map = to_world.forward();
        let in_world = |p: &DVec4| (map.matrix3 * p.truncate() + map.translation * p.w).extend(p.w);
        let points = Net::new(patch.degrees(), patch.control_points().iter().map(in_world).collect());
        let normals = normals(&points);
        Self { points, normals }
    }

    fn quarters(&self) -> [Self; 4] {
        let (points, normals) = (self.points.quarters(), self.normals.quarters());
        let mut both = points.into_iter().zip(normals).map(|(points, normals)| Self { points, normals });
        std::array::from_fn(|_| {
            both.next().unwrap_or_else(|| Self { points: self.points.clone(), normals: self.normals.clone() })
        })
    }

    /// `size`: that of the part in the parameters of the face.
    fn bounds(&self, size: DVec2) -> (MirrorExtent, DerivativeBounds) {
        let places = || self.points.values().iter().map(|p| p.truncate() / p.w);
        let center = Bounds3::from_points(places()).center();
        let radius = places().fold(0.0, |most: f64, p| most.max(p.distance(center)));
        let longest = self.normals.values().iter().fold(0.0, |most: f64, n| most.max(n.length()));
        // A control point that is zero up to rounding has no direction.
        let proper = || self.normals.values().iter().copied().filter(|n| n.length() > 1e-13 * longest);
        let axis = proper().sum::<DVec3>().try_normalize().unwrap_or(DVec3::Z);
        let angle = proper().fold(0.0, |most: f64, n| most.max(n.angle_between(axis)));
        // The hull of directions is a cone only if they lie in a half space.
        let angle = if angle < std::f64::consts::FRAC_PI_2 { angle } else { std::f64::consts::PI };
        let shortest = self.normals.values().iter().fold(f64::INFINITY, |least, n| least.min(n.dot(axis)));
        let turn = |first: bool| self.normals.steepest(first, DVec3::length) / shortest.max(0.0);
        // S = c + X / W with X about c: S_u = (X_u - (S - c) W_u) / W.
        let lightest = self.points.values().iter().fold(f64::INFINITY, |least: f64, p| least.min(p.w));
        let about = self.points.map(|p| p - (center * p.w).extend(0.0));
        let move_by = |first: bool| {
            let (space, weight) =
                (about.steepest(first, |d| d.truncate().length()), about.steepest(first, |d| d.w.abs()));
            (space + radius * weight) / lightest
        };
        let rates = DerivativeBounds {
            points: DVec2::new(move_by(true), move_by(false)) / size,
            normals: DVec2::new(turn(true), turn(false)) / size,
        };
        (MirrorExtent { center, radius, axis, angle }, rates)
    }
}

/// Control points of a vector along the normal.
///
/// With S = X / W, S_u x S_v = (X_u W - X W_u) x (X_v W - X W_v) / W^4, whose numerator is W times
/// W X_u x X_v - W_v X_u x X - W_u X x X_v; where W is constant, X_u x X_v alone has the direction.
fn normals(points: &Net<DVec4>) -> Net<DVec3> {
    let space = points.map(DVec4::truncate);
    let weight = points.map(|p| p.w);
    let (by_u, by_v) = (space.derivative(true), space.derivative(false));
    let across = by_u.product(&by_v, DVec3::cross);
    let first = points.values().first().map_or(1.0, |p| p.w);
    if points.values().iter().all(|p| p.w == first) {
        return across;
    }
    let scaled = across.product(&weight, |n, w| n * w);
    let second = by_u.product(&space, DVec3::cross).product(&weight.derivative(false), |n, w| n * w);
    let third = space.product(&by_v, DVec3::cross).product(&weight.derivative(true), |n, w| n * w);
    scaled.minus(&second).minus(&third)
}

impl MirrorPart {
    /// A whole face.
    pub(super) fn of_face(surface: &Surface, face: u32, to_world: &Transform) -> Self {
        let surface = if let Surface::Trimmed(trimmed) = surface { trimmed.surface() } else { surface };
        match surface {
            Surface::Freeform(freeform) => match freeform.patch(face) {
                Some(piece) => Self::Certain(MirrorPatch::new(piece.patch(), to_world)),
                None => Self::Estimated,
            },
            _ => Self::Estimated,
        }
    }

    pub(super) fn quarters(&self) -> [Self; 4] {
        match self {
            Self::Certain(patch) => patch.quarters().map(Self::Certain),
            Self::Estimated => std::array::from_fn(|_| Self::Estimated),
        }
    }

    /// Its bounds over `rect`; `at` evaluates points and normals of the face.
    pub(super) fn bounds(
        &self,
        rect: &IntegrationRect,
        at: impl Fn(DVec2) -> Option<(DVec3, DVec3)>,
    ) -> (MirrorExtent, DerivativeBounds) {
        if let Self::Certain(patch) = self {
            let (extent, rates) = patch.bounds(rect.size());
            // Where a side collapses to a point, the control net does not bound the normals.
            if rates.normals.is_finite() {
                return (extent, rates);
            }
            let (_, estimated) = estimate(rect, at);
            return (extent, DerivativeBounds { points: rates.points, normals: estimated.normals });
        }
        estimate(rect, at)
    }
}

/// Samples along each side for an estimate.
const GRID: usize = 5;

fn estimate(
    rect: &IntegrationRect,
    at: impl Fn(DVec2) -> Option<(DVec3, DVec3)>,
) -> (MirrorExtent, DerivativeBounds) {
    let steps = (GRID - 1) as f64;
    let grid: Vec<Option<(DVec3, DVec3)>> = (0..GRID * GRID)
        .map(|k| at(rect.min + rect.size() * DVec2::new((k % GRID) as f64, (k / GRID) as f64) / steps))
        .collect();
    let known = || grid.iter().flatten().copied();
    let center = Bounds3::from_points(known().map(|(p, _)| p)).center();
    let axis = known().map(|(_, n)| n).sum::<DVec3>().try_normalize().unwrap_or(DVec3::Z);
    // Twice the largest steps between neighbours along u and along v.
    let largest = |next: usize, skip: fn(usize) -> bool, apart: fn(DVec3, DVec3) -> f64, normal: bool| {
        let pairs = (0..grid.len()).filter(|&k| !skip(k));
        let steps = pairs.filter_map(|k| {
            let (a, b) = (grid.get(k).copied().flatten()?, grid.get(k + next).copied().flatten()?);
            Some(if normal { apart(a.1, b.1) } else { apart(a.0, b.0) })
        });
        2.0 * steps.fold(0.0, f64::max)
    };
    let last: fn(usize) -> bool = |k| k % GRID == GRID - 1;
    let above: fn(usize) -> bool = |k| k >= GRID * (GRID - 1);
    let points =
        DVec2::new(largest(1, last, DVec3::distance, false), largest(GRID, above, DVec3::distance, false));
    let normals = DVec2::new(
        largest(1, last, DVec3::angle_between, true),
        largest(GRID, above, DVec3::angle_between, true),
    );
    // No point is farther than half a step from a sample along either parameter.
    let radius =
        known().fold(0.0, |most: f64, (p, _)| most.max(p.distance(center))) + 0.5 * points.element_sum();
    let angle =
        known().fold(0.0, |most: f64, (_, n)| most.max(n.angle_between(axis))) + 0.5 * normals.element_sum();
    let angle = if angle < std::f64::consts::FRAC_PI_2 { angle } else { std::f64::consts::PI };
    let per = steps / rect.size();
    (
        MirrorExtent { center, radius, axis, angle },
        DerivativeBounds { points: points * per, normals: normals * per },
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A patch of degrees 2 and 3 with weights, bent in both directions.
    fn patch(weighted: bool) -> TensorPatch {
        let points = (0..12).map(|k| {
            let (i, j) = (f64::from(k / 4), f64::from(k % 4));
            let w = if weighted { 1.0 + 0.3 * (i - 1.0) * (j - 1.5) + 0.4 * i } else { 1.0 };
            let p = DVec3::new(i + 0.2 * j, j - 0.1 * i * i, 0.5 * i * (2.0 - i) + 0.3 * (j - 1.0).powi(2));
            (p * w).extend(w)
        });
        TensorPatch::try_new(2, 3, points.collect()).unwrap()
    }

    #[test]
    fn bounds_contain_the_points_normals_and_derivatives_of_the_patch() {
        for weighted in [false, true] {
            let patch = patch(weighted);
            let map = Transform::translate(DVec3::new(1.0, -2.0, 0.5));
            let at = |uv: DVec2| {
                let (p, du, dv) = patch.point_and_tangents(uv.x, uv.y);
                Some((map.point(p), du.cross(dv).normalize()))
            };
            let whole = MirrorPart::Certain(MirrorPatch::new(&patch, &map));
            let [_, _, _, last] = whole.quarters();
            let quarter = IntegrationRect { min: DVec2::splat(0.5), max: DVec2::ONE };
            for (part, rect) in [
                (whole, IntegrationRect::UNIT),
                (last, quarter),
                (MirrorPart::Estimated, IntegrationRect::UNIT),
                (MirrorPart::Estimated, quarter),
            ] {
                let (extent, rates) = part.bounds(&rect, at);
                assert!(extent.angle < 1.5 && rates.normals.is_finite(), "{extent:?} {rates:?}");
                let place =
                    |k: u32| rect.min + rect.size() * DVec2::new(f64::from(k % 21), f64::from(k / 21)) / 20.0;
                for k in 0..441 {
                    let (p, n) = at(place(k)).unwrap();
                    assert!(p.distance(extent.center) <= extent.radius * (1.0 + 1e-12));
                    assert!(n.angle_between(extent.axis) <= extent.angle + 1e-7);
                    let (q, m) = at(place((k * 37 + 11) % 441)).unwrap();
                    let apart = (place(k) - place((k * 37 + 11) % 441)).abs();
                    assert!(p.distance(q) <= rates.points.dot(apart) + 1e-12);
                    assert!(n.angle_between(m) <= rates.normals.dot(apart) + 1e-7);
                }
            }
        }
    }
}
