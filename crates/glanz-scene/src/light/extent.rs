//! Where lights are and in which directions they emit, as far as the choice between them depends on it.

use std::f64::consts::{FRAC_PI_2, PI};

use glanz_geometry::{ShadingPoint, Surface};
use glanz_math::{Bounds3, DVec2, DVec3};

use crate::object::SceneObject;

/// Place and directions of a light.
#[derive(Clone, Copy, Debug)]
pub(crate) enum LightExtent {
    /// In a box.
    Bounded(EmissionBounds),
    /// Infinitely far away, in the directions of a cone.
    Distant(DirectionCone),
}

/// Sine of the angle from which on two axes are not opposite: errors of the direction from one to the other stay below 1e-9.
const OPPOSITE: f64 = 1e-6;

/// Directions within an angle of an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DirectionCone {
    /// Unit length.
    pub(super) axis: DVec3,
    /// Radians, at most pi.
    pub(super) half_angle: f64,
}

impl DirectionCone {
    /// All directions.
    pub(crate) const ALL: Self = Self { axis: DVec3::Z, half_angle: PI };

    /// A cone that holds all of `directions`, of unit length; all directions if their sum is not finite or 0.
    fn around(directions: impl Iterator<Item = DVec3> + Clone) -> Self {
        let Some(axis) = directions.clone().sum::<DVec3>().try_normalize() else { return Self::ALL };
        Self { axis, half_angle: directions.map(|one| angle_between(axis, one)).fold(0.0, f64::max) }
    }

    /// A cone that holds both.
    ///
    /// # Source
    /// @pharr2023 section 3.8.4.
    fn union(self, other: Self) -> Self {
        let between = angle_between(self.axis, other.axis);
        if between + other.half_angle <= self.half_angle {
            return self;
        }
        if between + self.half_angle <= other.half_angle {
            return other;
        }
        let half_angle = 0.5 * (self.half_angle + between + other.half_angle);
        let across = other.axis - self.axis * self.axis.dot(other.axis);
        // Of nearly opposite axes only roundings are left, and the direction from one to the other is not known.
        let is_opposite = between > FRAC_PI_2 && across.length() < OPPOSITE;
        let across = across.try_normalize().filter(|_| !is_opposite && half_angle < PI);
        let Some(across) = across else { return Self::ALL };
        let (sin, cos) = (half_angle - self.half_angle).sin_cos();
        Self { axis: (self.axis * cos + across * sin).normalize(), half_angle }
    }
}

/// Angle between two unit vectors, radians, precise also where it is small.
fn angle_between(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b))
}

/// Bounds on place and directions of emission of one or more lights: a point of `bounds` emits within `spread` of a direction of `normals`, with the
/// cosine to it.
///
/// # Source
/// @contyestevez2018 section 4.1.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EmissionBounds {
    /// Positions, metres.
    pub(super) bounds: Bounds3,
    /// Normals of surfaces, directions of full intensity of points.
    pub(super) normals: DirectionCone,
    /// Angle from these, radians, at most pi / 2, beyond which nothing is emitted.
    pub(super) spread: f64,
    /// Whether light is emitted also opposite to these directions.
    pub(super) two_sided: bool,
    /// Distance, metres, at which all light has faded; infinite if it does not.
    pub(super) range: f64,
}

impl EmissionBounds {
    /// A point that emits in all directions.
    pub(super) fn point(position: DVec3) -> Self {
        Self::beam(position, DirectionCone::ALL, PI)
    }

    /// A point that emits fully in the directions of a cone, and less up to `outer`, radians, from its axis.
    pub(super) fn beam(position: DVec3, inner: DirectionCone, outer: f64) -> Self {
        // A spread of more than a right angle would have negative cosines.
        let spread = (outer - inner.half_angle).clamp(0.0, FRAC_PI_2);
        let normals = DirectionCone { half_angle: (outer - spread).clamp(0.0, PI), ..inner };
        let bounds = Bounds3::from_points([position]);
        Self { bounds, normals, spread, two_sided: false, range: f64::INFINITY }
    }

    /// The surface of an object of the world.
    pub(super) fn surface(object: &SceneObject, two_sided: bool) -> Self {
        let normals = normal_cone(object);
        let bounds = object.bounds();
        Self { bounds, normals, spread: FRAC_PI_2, two_sided, range: f64::INFINITY }
    }

    /// Bounds of both.
    pub(super) fn union(&self, other: &Self) -> Self {
        let mut normals = other.normals;
        if self.two_sided && other.two_sided && self.normals.axis.dot(normals.axis) < 0.0 {
            normals.axis = -normals.axis;
        }
        Self {
            bounds: self.bounds.union(other.bounds),
            normals: self.normals.union(normals),
            spread: self.spread.max(other.spread),
            two_sided: self.two_sided || other.two_sided,
            range: self.range.max(other.range),
        }
    }

    /// Integral over all directions, steradians, of the cosine of the angle beyond the cone of normals: power over the largest intensity.
    ///
    /// # Source
    /// @contyestevez2018 section 4.2.
    pub(super) fn solid_angle(&self) -> f64 {
        let inner = self.normals.half_angle;
        let outer = (inner + self.spread).min(PI);
        let fading = 2.0 * (outer - inner) * inner.sin() - (inner - 2.0 * outer).cos() + inner.cos();
        let one_side = 2.0 * PI * (1.0 - inner.cos()) + 0.5 * PI * fading;
        let both = if self.two_sided { 2.0 * one_side } else { one_side };
        both.clamp(f64::EPSILON, 4.0 * PI)
    }
}

/// A cone that holds the normals of an object on the side that emits.
fn normal_cone(object: &SceneObject) -> DirectionCone {
    let surface = object.surface();
    let corners: &[DVec2] = match surface {
        Surface::Disk(_) | Surface::Plane(_) => &[DVec2::splat(0.5)],
        // Normals at the vertices may select different sides of one triangle.
        Surface::Triangle(_) | Surface::Mesh(_) => &[DVec2::ZERO, DVec2::X, DVec2::Y],
        Surface::Bilinear(_) => &[DVec2::ZERO, DVec2::X, DVec2::Y, DVec2::ONE],
        _ => return DirectionCone::ALL,
    };
    let normals = (0..surface.faces()).flat_map(|face| corners.iter().map(move |&uv| (face, uv)));
    let normals = normals.filter_map(|(face, uv)| {
        // A degenerate face has no area, a degenerate corner no part in the sum below.
        let found = surface.at(face, uv).filter(|found| found.area_element > 0.0)?;
        let mut point = ShadingPoint::from(found.point);
        object.place(&mut point, object.attributes(face).reversed);
        Some(point.normal)
    });
    let cone = DirectionCone::around(normals);
    // The cross product of the tangents of a bilinear patch is a sum of those at its corners with weights that are not negative. Such sums stay in a
    // cone if it is convex.
    let is_convex = cone.half_angle < FRAC_PI_2;
    if is_convex || !matches!(surface, Surface::Bilinear(_)) { cone } else { DirectionCone::ALL }
}

#[cfg(test)]
mod tests {
    use glanz_sampling::hash::{combine, unit_f64};
    use glanz_sampling::warp;

    use super::*;

    /// Unit directions in any place.
    fn direction(i: u64) -> DVec3 {
        warp::uniform_sphere(DVec2::new(unit_f64(combine(1, i)), unit_f64(combine(2, i))))
    }

    #[test]
    fn solid_angles_are_those_of_closed_forms() {
        let of = |half_angle, spread, two_sided| {
            let normals = DirectionCone { axis: DVec3::Z, half_angle };
            EmissionBounds { normals, spread, two_sided, ..EmissionBounds::point(DVec3::ZERO) }.solid_angle()
        };
        // A flat surface, both of its sides, a point, a cone with a sharp border, a round surface of two sides.
        for (found, expected) in [
            (of(0.0, FRAC_PI_2, false), PI),
            (of(0.0, FRAC_PI_2, true), 2.0 * PI),
            (of(PI, FRAC_PI_2, false), 4.0 * PI),
            (of(0.7, 0.0, false), 2.0 * PI * (1.0 - 0.7_f64.cos())),
            (of(PI, FRAC_PI_2, true), 4.0 * PI),
        ] {
            assert!((found - expected).abs() < 1e-14 * expected, "{found} {expected}");
        }
        // Midpoint rule over the angle from the axis.
        for (inner, spread) in [(0.3, 0.5), (1.0, FRAC_PI_2), (2.5, 1.2)] {
            let n = 100_000;
            let step = PI / f64::from(n);
            let at = |i: u32| {
                let angle = (f64::from(i) + 0.5) * step;
                let beyond = (angle - inner).max(0.0);
                if beyond < spread { 2.0 * PI * beyond.cos() * angle.sin() * step } else { 0.0 }
            };
            let integral: f64 = (0..n).map(at).sum();
            assert!((of(inner, spread, false) - integral).abs() < 1e-4, "{inner} {spread}: {integral}");
        }
    }

    #[test]
    fn unions_of_cones_hold_both() {
        for i in 0..1000 {
            let cone = |j: u64| {
                let half_angle = PI * unit_f64(combine(3 + j, i)).powi(3);
                DirectionCone { axis: direction(2 * i + j), half_angle }
            };
            let (a, b) = (cone(0), cone(1));
            let both = a.union(b);
            assert!(both.axis.is_normalized() && both.half_angle <= PI);
            for one in [a, b] {
                let farthest = angle_between(both.axis, one.axis) + one.half_angle;
                assert!(farthest <= both.half_angle + 1e-14 || both.half_angle == PI, "{a:?} {b:?}");
            }
        }
        let (up, down) = (
            DirectionCone { axis: DVec3::Z, half_angle: 0.0 },
            DirectionCone { axis: -DVec3::Z, half_angle: 0.0 },
        );
        assert_eq!(up.union(down), DirectionCone::ALL);
        assert_eq!(up.union(up), up);
    }

    #[test]
    fn unions_of_opposite_cones_hold_both() {
        // Opposite down to roundings, as the axes of lights back to back are.
        for (i, power) in (0..2000).map(|i| (i, i as i32 % 60)) {
            let axis = direction(i);
            let other = (0.5_f64.powi(power) * direction(5000 + i) - axis).normalize();
            let [a, b] = [axis, other].map(|axis| DirectionCone { axis, half_angle: 0.0 });
            let both = a.union(b);
            assert!(both.axis.is_normalized());
            for one in [a, b] {
                let beyond = angle_between(both.axis, one.axis) - both.half_angle;
                assert!(beyond <= 1e-8, "{a:?} {b:?}: {beyond}");
            }
        }
    }

    #[test]
    fn cones_hold_the_directions_they_are_around() {
        let near = |i: u64| (DVec3::X + 0.5 * direction(i)).normalize();
        let cone = DirectionCone::around((0..100).map(near));
        let angles: Vec<f64> = (0..100).map(|i| angle_between(cone.axis, near(i))).collect();
        assert!(angles.iter().all(|&angle| angle <= cone.half_angle));
        // sin(30 degrees) = 0.5.
        assert!(angles.contains(&cone.half_angle) && cone.half_angle < 1.2 * PI / 6.0);
        assert_eq!(DirectionCone::around([DVec3::X, -DVec3::X].into_iter()), DirectionCone::ALL);
        assert_eq!(DirectionCone::around([].into_iter()), DirectionCone::ALL);
    }
}
