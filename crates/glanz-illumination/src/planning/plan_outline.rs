//! Outlines of things from above.

use glanz_geometry::FaceDomain;
use glanz_math::{DVec2, DVec3};
use glanz_scene::PlacedSurface;

use crate::receiver::{face_corners, signed_area};

/// Points along each side of a face whose outline is sampled, and of a trimmed one, of whose border at most half of a step is lost.
const POINTS: u32 = 17;
const TRIMMED_POINTS: u32 = 129;

/// Largest number of points of all faces, apart from four for each.
const MOST_POINTS: usize = 1 << 18;

/// Thickness of a shape that counts as flat, as a share of its extent.
const FLAT: f64 = 1e-6;

/// A shape of a scene from above.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ShapeOutline {
    /// The convex outline from above, metres; two points if the shape is upright and flat.
    pub(crate) outline: Vec<DVec2>,
    /// Lowest and highest point, metres.
    pub(crate) height: [f64; 2],
    /// Middle of its box, metres.
    pub(crate) middle: DVec3,
}

impl ShapeOutline {
    /// That of some faces of a surface, of its box without faces; `None` if it is infinite.
    pub(crate) fn of(surface: &PlacedSurface<'_>, faces: &[u32]) -> Option<Self> {
        let bounds = surface.bounds();
        if bounds.is_empty() || !bounds.is_finite() {
            return None;
        }
        let sampled: Vec<DVec3> = if faces.is_empty() {
            bounds.corners().to_vec()
        } else {
            let finest = if surface.is_trimmed() { TRIMMED_POINTS } else { POINTS };
            let each = ((MOST_POINTS / faces.len()) as f64).sqrt() as u32;
            let points = faces.iter().flat_map(|&face| face_points(surface, face, each.clamp(2, finest)));
            // Of trimmed surfaces, the box is that of what is left.
            points.map(|point| point.clamp(bounds.min, bounds.max)).collect()
        };
        let first = *sampled.first()?;
        let [low, high] =
            sampled.iter().fold([first; 2], |[low, high], point| [low.min(*point), high.max(*point)]);
        let outline = convex_hull(sampled.into_iter().map(DVec3::truncate).collect());
        Some(Self { outline, height: [low.z, high.z], middle: 0.5 * (low + high) })
    }

    /// Its area from above, m^2.
    pub(crate) fn area(&self) -> f64 {
        signed_area(&self.outline).abs()
    }

    /// The longest distance of its outline from its first point, metres.
    pub(crate) fn length(&self) -> f64 {
        let first = self.outline.first().copied().unwrap_or_default();
        self.outline.iter().map(|point| point.distance(first)).fold(0.0, f64::max)
    }

    /// Whether it is horizontal and flat.
    pub(crate) fn is_level(&self) -> bool {
        self.height[1] - self.height[0] <= FLAT * self.length()
    }

    /// Whether it is upright and flat.
    pub(crate) fn is_upright(&self) -> bool {
        self.height[1] > self.height[0] && self.area() <= FLAT * self.length().powi(2)
    }
}

/// Points of a face, metres: its corners if it lies within them, else a grid of `side` times `side` points in its parameters.
pub(crate) fn face_points(surface: &PlacedSurface<'_>, face: u32, side: u32) -> Vec<DVec3> {
    let corners = face_corners(surface, face).or_else(|| match surface.face_domain(face) {
        FaceDomain::Polygon(corners) => Some(corners),
        FaceDomain::Square => None,
    });
    let parameters = corners.unwrap_or_else(|| {
        let step = |i: u32| f64::from(i) / f64::from(side.max(2) - 1);
        (0..side).flat_map(|v| (0..side).map(move |u| DVec2::new(step(u), step(v)))).collect()
    });
    let at = |uv: DVec2| surface.at(face, uv, false).map(|found| found.at.point.position);
    parameters.into_iter().filter_map(at).collect()
}

/// The convex hull of points, counterclockwise, without points on its sides; of points on a line, their ends.
///
/// # Source
/// @andrew1979: two chains of points that are sorted along x.
pub(crate) fn convex_hull(mut points: Vec<DVec2>) -> Vec<DVec2> {
    points.retain(|point| point.is_finite());
    let Some(&first) = points.first() else { return points };
    let [low, high] = points.iter().fold([first; 2], |[low, high], p| [low.min(*p), high.max(*p)]);
    // Points of a side along an axis, which differ by rounding, have to be sorted along the side.
    let near = 1e-9 * (high - low).max_element();
    for point in &mut points {
        *point = DVec2::select(point.cmple(low + near), low, *point);
        *point = DVec2::select(point.cmpge(high - near), high, *point);
    }
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    points.dedup();
    if points.len() < 3 {
        return points;
    }
    // Cross products of points on a line are not exactly 0.
    let least = 1e-12 * (high - low).length_squared();
    let chain = |points: &mut dyn Iterator<Item = DVec2>| {
        let mut chain: Vec<DVec2> = Vec::new();
        for point in points {
            while let [.., a, b] = chain.as_slice()
                && (*b - *a).perp_dot(point - *a) <= least
            {
                chain.pop();
            }
            chain.push(point);
        }
        chain.pop();
        chain
    };
    let mut hull = chain(&mut points.iter().copied());
    hull.extend(chain(&mut points.iter().rev().copied()));
    hull
}

#[cfg(test)]
mod tests {
    use super::*;
    use glanz_scene::SceneBuilder;
    use glanz_scene::description::{MaterialKind, ShapeDescription};
    use std::f64::consts::PI;

    fn outlines(shape: ShapeDescription) -> Vec<ShapeOutline> {
        let builder = SceneBuilder::new().shape(shape, MaterialKind::diffuse(0.5));
        let light = glanz_scene::description::LightDescription::infinite(1.0);
        let (scene, _) = builder.light(light).resolve().unwrap();
        let placed = scene.placed_surfaces();
        let all = placed.iter().filter_map(|surface| {
            let faces: Vec<u32> = (0..surface.faces()).collect();
            ShapeOutline::of(surface, &faces)
        });
        all.collect()
    }

    #[test]
    fn hulls_have_only_their_corners() {
        let square = [[0.0, 0.0], [2.0, 0.0], [1.0, 0.0], [2.0, 2.0], [0.0, 2.0], [1.0, 1.0], [2.0, 1.0]];
        let hull = convex_hull(square.map(DVec2::from).to_vec());
        assert_eq!(hull, [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]].map(DVec2::from));
        assert_eq!(signed_area(&hull), 4.0);
        let line = [[0.0, 0.0], [0.1, 0.3], [0.2, 0.6], [f64::NAN, 0.0]].map(DVec2::from);
        assert_eq!(convex_hull(line.to_vec()), [[0.0, 0.0], [0.2, 0.6]].map(DVec2::from));
        assert_eq!((convex_hull(Vec::new()).len(), signed_area(&[])), (0, 0.0));
    }

    #[test]
    fn turned_shapes_keep_their_length_and_area() {
        // Sines of right angles are not exactly 0, so that sides along an axis are only nearly so.
        for (turn, x, y) in [-90.0_f64, 180.0, 270.0, 450.0]
            .into_iter()
            .flat_map(|turn| [(0.1, 0.7), (-3.3, 1e3 / 7.0), (0.0, 1.0 / 3.0)].map(|(x, y)| (turn, x, y)))
        {
            let axes = glanz_math::DMat3::from_rotation_z(turn.to_radians());
            let quad = |u: DVec3, v: DVec3| {
                let [u, v] = [axes * u, axes * v].map(|side| side.to_array());
                let shape = ShapeDescription::parallelogram((axes * DVec3::new(x, y, 0.3)).to_array(), u, v);
                outlines(shape).pop().unwrap()
            };
            let floor = quad(DVec3::new(5.3, 0.0, 0.0), DVec3::new(0.0, 3.7, 0.0));
            assert!((floor.area() / (5.3 * 3.7) - 1.0).abs() < 1e-8 && floor.is_level(), "{turn} {floor:?}");
            let wall = quad(DVec3::new(0.0, 3.7, 0.0), DVec3::new(0.0, 0.0, 2.5));
            assert!((wall.length() / 3.7 - 1.0).abs() < 1e-8 && wall.is_upright(), "{turn} {wall:?}");
            assert_eq!(wall.outline.len(), 2);
        }
        // A column of points that differ by rounding, of which the first along x is in the middle.
        let rounded = [[1e-17, 0.0], [0.0, 1.0], [2e-17, 2.0], [3.0, 0.0], [3.0, 2.0]];
        assert_eq!(signed_area(&convex_hull(rounded.map(DVec2::from).to_vec())), 6.0);
    }

    #[test]
    fn shapes_are_seen_from_above() {
        let [top] =
            outlines(ShapeDescription::parallelogram([1.0, 2.0, 0.7], [2.0, 0.0, 0.0], [0.0, 1.0, 0.0]))
                .try_into()
                .unwrap();
        assert!(top.is_level() && !top.is_upright() && (top.area() - 2.0).abs() < 1e-12);
        let [wall] = outlines(ShapeDescription::parallelogram([0.0; 3], [3.0, 4.0, 0.0], [0.0, 0.0, 2.5]))
            .try_into()
            .unwrap();
        assert!(wall.is_upright() && !wall.is_level() && (wall.length() - 5.0).abs() < 1e-12);
        assert_eq!((wall.height, wall.outline.len()), ([0.0, 2.5], 2));
        // A ball is about a disk; a polygon of 16 of its points has 97 % of the area.
        let [ball] = outlines(ShapeDescription::sphere(1.0)).try_into().unwrap();
        assert!((0.97 * PI..=PI + 1e-9).contains(&ball.area()), "{}", ball.area());
        assert!(!ball.is_level() && !ball.is_upright());
        assert!(outlines(ShapeDescription::plane()).is_empty());
    }
}
