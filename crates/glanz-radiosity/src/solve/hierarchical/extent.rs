//! Where a node of the hierarchy lies, which ways it faces, and the few places that stand for it.

use std::f64::consts::{FRAC_PI_2, PI};

use glanz_math::{DVec2, DVec3};

use crate::elements::{Element, Elements, Node, Part};
use crate::form_factor::polygon::in_front;

/// How far the outermost places of a part stand back from its sides, per its size: a place right on a side may lie in the surface
/// that stands there.
const STAND_BACK: f64 = 1e-3;

/// What is added to the sphere and the cone around the places of a curved part, per their size: it bends between them too.
const BEND: f64 = 0.25;

/// Places of a node from which rays start, at most: these are its first.
pub(super) const CORNERS: usize = 5;

/// Places that stand for a cluster.
const CLUSTER: usize = 8;

/// Position and directions of a node.
#[derive(Clone, Debug)]
pub(super) struct Extent {
    /// Middle of a sphere around it.
    pub(super) center: DVec3,
    /// Radius of that sphere.
    pub(super) radius: f64,
    /// Axis of a cone around its normals.
    pub(super) axis: DVec3,
    /// Half the angle of that cone; pi if it says nothing.
    pub(super) spread: f64,
    /// Places with areas that integrate over it.
    pub(super) nodes: Vec<Node>,
    /// Places at which the kernel is looked at and rays begin: corners, middle, and of curved parts middles of sides and quarters.
    pub(super) probes: Vec<Node>,
}

/// Smallest and largest cos cos' / (pi r^2) between two nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Range {
    pub(super) low: f64,
    pub(super) high: f64,
}

impl Extent {
    /// Of an element.
    pub(super) fn of_element(elements: &Elements<'_>, element: &Element) -> Self {
        let patch = &element.patch;
        let place = |&uv: &DVec2| elements.place(patch, uv);
        let mut nodes = elements.nodes(patch);
        let mut probes: Vec<Node> =
            places(&patch.part, element.polygon.is_some()).iter().filter_map(place).collect();
        if probes.len() < CORNERS {
            // Trimming has cut most of them away.
            probes.extend(spaced(&nodes, CORNERS).copied());
        }
        nodes = spaced(&nodes, CLUSTER).copied().collect();
        let kept: f64 = nodes.iter().map(|node| node.area).sum();
        nodes.iter_mut().for_each(|node| node.area *= element.area / kept);
        if let Some(corners) = &element.polygon {
            let center = corners.iter().sum::<DVec3>() / corners.len() as f64;
            let radius = corners.iter().map(|c| c.distance(center)).fold(0.0, f64::max);
            return Self { center, radius, axis: element.center.normal, spread: 0.0, nodes, probes };
        }
        let all = || probes.iter().chain(&nodes);
        let (low, high) = all().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), node| {
            (low.min(node.position), high.max(node.position))
        });
        let center = 0.5 * (low + high);
        let reach = all().map(|node| node.position.distance(center)).fold(0.0, f64::max);
        let axis = all().map(|node| node.normal).sum::<DVec3>().normalize_or_zero();
        let spread = all().map(|node| angle(axis, node.normal)).fold(0.0, f64::max);
        let spread = if axis == DVec3::ZERO { PI } else { (spread * (1.0 + BEND)).min(PI) };
        Self { center, radius: reach * (1.0 + BEND), axis, spread, nodes, probes }
    }

    /// Of a cluster: around the extents of its elements, which are also asked for places in the middle of equal shares of the area.
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
        let share = area / CLUSTER as f64;
        let (mut before, mut nodes) = (0.0, Vec::with_capacity(CLUSTER));
        for (_, element) in members {
            before += element.area;
            while nodes.len() < CLUSTER && before >= (nodes.len() as f64 + 0.5) * share {
                nodes.push(Node { area: share, ..element.center });
            }
        }
        Self { center, radius, axis, spread, probes: nodes.clone(), nodes }
    }

    /// Bounds on the kernel between any place of one and any place of the other, from spheres and cones.
    pub(super) fn range(&self, other: &Self) -> Range {
        let way = other.center - self.center;
        let (distance, reach) = (way.length(), self.radius + other.radius);
        let turn = if distance > reach { (reach / distance).asin() } else { PI };
        let cosines = |extent: &Self, way: DVec3| {
            let (middle, off) = (angle(extent.axis, way), extent.spread + turn);
            let cosine = |angle: f64| if angle < FRAC_PI_2 { angle.cos() } else { 0.0 };
            if off >= PI { [0.0, 1.0] } else { [cosine(middle + off), cosine((middle - off).max(0.0))] }
        };
        let ([a, b], [c, d]) = (cosines(self, way), cosines(other, -way));
        if b * d == 0.0 {
            return Range { low: 0.0, high: 0.0 };
        }
        let (near, far) = (distance - reach, distance + reach);
        let high = if near > 0.0 { b * d / (PI * near * near) } else { f64::INFINITY };
        Range { low: a * c / (PI * far * far), high }
    }

    /// Sum of the radii over the distance of the middles: infinite where they coincide.
    pub(super) fn nearness(&self, other: &Self) -> f64 {
        let distance = self.center.distance(other.center);
        if distance > 0.0 { (self.radius + other.radius) / distance } else { f64::INFINITY }
    }
}

/// Whether something of flat `a` lies before the plane of flat `b` and the other way round; `true` if one is not flat.
pub(super) fn can_face(a: &Element, b: &Element) -> bool {
    let some = |a: &Element, b: &Element| match (&a.polygon, &b.polygon) {
        (Some(corners), Some(_)) => in_front(corners, b.center.position, b.center.normal).len() >= 3,
        _ => true,
    };
    some(a, b) && some(b, a)
}

/// Corners and middle of a part, and of one that bends the middles of its sides and quarters, all but a little inside.
fn places(part: &Part, flat: bool) -> Vec<DVec2> {
    let (corners, middle) = (part.corners(), part.center());
    let mut places: Vec<DVec2> = corners.iter().map(|corner| corner.lerp(middle, STAND_BACK)).collect();
    places.push(middle);
    if !flat {
        let ends = corners.iter().zip(corners.iter().cycle().skip(1));
        places.extend(ends.map(|(a, b)| a.midpoint(*b).lerp(middle, STAND_BACK)));
        // Corners and middles may be few places only of what is closed, as of a cylinder.
        places.extend(part.quarters().iter().map(Part::center));
    }
    places
}

/// `count` of them at equal steps, or all if they are fewer.
fn spaced(nodes: &[Node], count: usize) -> impl Iterator<Item = &Node> {
    let count = count.min(nodes.len());
    (0..count).filter_map(move |i| nodes.get((2 * i + 1) * nodes.len() / (2 * count)))
}

fn angle(a: DVec3, b: DVec3) -> f64 {
    // Exact for small angles too, which an arc cosine is not.
    a.cross(b).length().atan2(a.dot(b))
}
