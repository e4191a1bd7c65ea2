//! Bounds of the positions and normals of a node of the hierarchy, and the points that represent it.

use std::f64::consts::{FRAC_PI_2, PI};

use glanz_math::{DVec2, DVec3};

use crate::elements::{Element, ElementPoint, Elements, ParameterPatch};
use crate::form_factor::polygon::in_front;

/// Distance of the outermost probes of a patch from its sides, relative to its size: a point on a side may lie in an adjacent surface.
const INSET: f64 = 1e-3;

/// Enlargement of the sphere and the cone around the points of a curved patch, relative to their size, for its curvature between the
/// points.
const CURVATURE_MARGIN: f64 = 0.25;

/// Largest number of probes of an element that are ends of shadow rays: its first ones.
pub(super) const CORNERS: usize = 5;

/// Quadrature points of a cluster.
const CLUSTER_POINTS: usize = 8;

/// Bounds of the positions and normals of a node, and points on it.
#[derive(Clone, Debug)]
pub(super) struct NodeExtent {
    /// Center of a bounding sphere, metres.
    pub(super) center: DVec3,
    /// Radius of the bounding sphere, metres.
    pub(super) radius: f64,
    /// Axis of a bounding cone of its normals.
    pub(super) axis: DVec3,
    /// Half the angle of that cone, [0, pi]; pi if normals have any direction.
    pub(super) spread: f64,
    /// Quadrature points.
    pub(super) points: Vec<ElementPoint>,
    /// Points at which the kernel is evaluated and shadow rays end: corners and middle, and on curved patches the middles of sides and
    /// quarters.
    pub(super) probes: Vec<ElementPoint>,
}

/// Bounds on the kernel cos cos' / (pi r^2) between two nodes, per m^2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct KernelRange {
    pub(super) low: f64,
    pub(super) high: f64,
}

impl NodeExtent {
    /// Extent of an element.
    pub(super) fn of_element(elements: &Elements<'_>, element: &Element) -> Self {
        let patch = &element.patch;
        let probe = |&uv: &DVec2| elements.point(patch, uv);
        let mut points = elements.quadrature_points(patch);
        let mut probes: Vec<ElementPoint> =
            probe_parameters(&patch.domain, element.polygon.is_some()).iter().filter_map(probe).collect();
        if probes.len() < CORNERS {
            // Trimming has removed most of them.
            probes.extend(spaced(&points, CORNERS).copied());
        }
        points = spaced(&points, CLUSTER_POINTS).copied().collect();
        let kept: f64 = points.iter().map(|point| point.area).sum();
        points.iter_mut().for_each(|point| point.area *= element.area / kept);
        if let Some(corners) = &element.polygon {
            let center = corners.iter().sum::<DVec3>() / corners.len() as f64;
            let radius = corners.iter().map(|c| c.distance(center)).fold(0.0, f64::max);
            return Self { center, radius, axis: element.center.normal, spread: 0.0, points, probes };
        }
        let all = || probes.iter().chain(&points);
        let (low, high) = all().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), node| {
            (low.min(node.position), high.max(node.position))
        });
        let center = 0.5 * (low + high);
        let reach = all().map(|point| point.position.distance(center)).fold(0.0, f64::max);
        let axis = all().map(|point| point.normal).sum::<DVec3>().normalize_or_zero();
        let spread = all().map(|node| angle(axis, node.normal)).fold(0.0, f64::max);
        let spread = if axis == DVec3::ZERO { PI } else { (spread * (1.0 + CURVATURE_MARGIN)).min(PI) };
        Self { center, radius: reach * (1.0 + CURVATURE_MARGIN), axis, spread, points, probes }
    }

    /// Extent of a cluster around those of its elements. Its points are the centers of the elements at equal steps of the area.
    pub(super) fn around(members: &[(&Self, &Element)]) -> Self {
        let (low, high) =
            members.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), (extent, _)| {
                (low.min(extent.center - extent.radius), high.max(extent.center + extent.radius))
            });
        let center = 0.5 * (low + high);
        let reach = |extent: &Self| extent.center.distance(center) + extent.radius;
        let radius = members.iter().map(|(extent, _)| reach(extent)).fold(0.0, f64::max);
        let sum: DVec3 = members.iter().map(|(extent, element)| element.area * extent.axis).sum();
        let axis = sum.normalize_or_zero();
        let opened = |extent: &Self| angle(axis, extent.axis) + extent.spread;
        let spread = members.iter().map(|(extent, _)| opened(extent)).fold(0.0, f64::max);
        let spread = if axis == DVec3::ZERO { PI } else { spread.min(PI) };
        let area: f64 = members.iter().map(|(_, element)| element.area).sum();
        let share = area / CLUSTER_POINTS as f64;
        let (mut before, mut points) = (0.0, Vec::with_capacity(CLUSTER_POINTS));
        for (_, element) in members {
            before += element.area;
            while points.len() < CLUSTER_POINTS && before >= (points.len() as f64 + 0.5) * share {
                points.push(ElementPoint { area: share, ..element.center });
            }
        }
        Self { center, radius, axis, spread, probes: points.clone(), points }
    }

    /// Bounds on the kernel between any points of two nodes, from spheres and cones.
    pub(super) fn range(&self, other: &Self) -> KernelRange {
        let direction = other.center - self.center;
        let (distance, reach) = (direction.length(), self.radius + other.radius);
        let deviation = if distance > reach { (reach / distance).asin() } else { PI };
        let cosines = |extent: &Self, direction: DVec3| {
            let (middle, off) = (angle(extent.axis, direction), extent.spread + deviation);
            let cosine = |angle: f64| if angle < FRAC_PI_2 { angle.cos() } else { 0.0 };
            if off >= PI { [0.0, 1.0] } else { [cosine(middle + off), cosine((middle - off).max(0.0))] }
        };
        let ([a, b], [c, d]) = (cosines(self, direction), cosines(other, -direction));
        if b * d == 0.0 {
            return KernelRange { low: 0.0, high: 0.0 };
        }
        let (near, far) = (distance - reach, distance + reach);
        let high = if near > 0.0 { b * d / (PI * near * near) } else { f64::INFINITY };
        KernelRange { low: a * c / (PI * far * far), high }
    }

    /// Sum of the radii over the distance of the centers; infinite if these coincide.
    pub(super) fn nearness(&self, other: &Self) -> f64 {
        let distance = self.center.distance(other.center);
        if distance > 0.0 { (self.radius + other.radius) / distance } else { f64::INFINITY }
    }
}

/// Whether a part of flat `a` lies in front of the plane of flat `b`, and conversely; `true` if one is not flat.
pub(super) fn can_face(a: &Element, b: &Element) -> bool {
    let some = |a: &Element, b: &Element| match (&a.polygon, &b.polygon) {
        (Some(corners), Some(_)) => in_front(corners, b.center.position, b.center.normal).len() >= 3,
        _ => true,
    };
    some(a, b) && some(b, a)
}

/// Corners and middle of a patch, and for a curved one the middles of its sides and quarters, moved slightly inside.
fn probe_parameters(part: &ParameterPatch, flat: bool) -> Vec<DVec2> {
    let (corners, middle) = (part.corners(), part.center());
    let mut probe_parameters: Vec<DVec2> = corners.iter().map(|corner| corner.lerp(middle, INSET)).collect();
    probe_parameters.push(middle);
    if !flat {
        let ends = corners.iter().zip(corners.iter().cycle().skip(1));
        probe_parameters.extend(ends.map(|(a, b)| a.midpoint(*b).lerp(middle, INSET)));
        // On closed surfaces, such as cylinders, corners and middles of sides coincide.
        probe_parameters.extend(part.quarters().iter().map(ParameterPatch::center));
    }
    probe_parameters
}

/// `count` of the points at equal steps, or all if they are fewer.
fn spaced(points: &[ElementPoint], count: usize) -> impl Iterator<Item = &ElementPoint> {
    let count = count.min(points.len());
    (0..count).filter_map(move |i| points.get((2 * i + 1) * points.len() / (2 * count)))
}

fn angle(a: DVec3, b: DVec3) -> f64 {
    // Unlike an arc cosine, exact for small angles.
    a.cross(b).length().atan2(a.dot(b))
}
