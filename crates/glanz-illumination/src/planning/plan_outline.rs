//! Outlines of things from above.

use glanz_geometry::FaceDomain;
use glanz_math::{DVec2, DVec3};
use glanz_scene::PlacedSurface;

use crate::receiver::{face_corners, signed_area};

/// Points along each side of a face whose outline is sampled, and of a trimmed one, of whose border at most half of a step is lost.
const POINTS: u32 = 17;
const TRIMMED_POINTS: u32 = 129;

/// Largest number of points of all faces, apart from four for each; of more faces than that, the outline is that of the box.
const MOST_POINTS: usize = 1 << 18;

/// Points along each side of a trimmed triangle, besides its corners.
const TRIANGLE_POINTS: u32 = 9;

/// Distance within which points are in one plane and heights are equal, as a share of the extent: coordinates of models are often rounded to a millimetre.
pub(super) const NEAR: f64 = 2e-4;

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
    /// That of some faces of a surface, of its box without faces or with very many; `None` if it is infinite.
    pub(crate) fn of(surface: &PlacedSurface<'_>, faces: &[u32]) -> Option<Self> {
        let bounds = surface.bounds();
        if bounds.is_empty() || !bounds.is_finite() {
            return None;
        }
        let sampled: Vec<DVec3> = if faces.is_empty() || faces.len() > MOST_POINTS {
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

    /// The first point of its outline, which is one of its ends, and the farthest from it, metres.
    pub(crate) fn ends(&self) -> [DVec2; 2] {
        let first = self.outline.first().copied().unwrap_or_default();
        let distance = |point: &DVec2| point.distance_squared(first);
        let farthest = self.outline.iter().copied().max_by(|a, b| distance(a).total_cmp(&distance(b)));
        [first, farthest.unwrap_or(first)]
    }

    /// The distance of its ends, metres.
    pub(crate) fn length(&self) -> f64 {
        let [first, last] = self.ends();
        first.distance(last)
    }

    /// Whether it is horizontal, and no thicker than `near`, metres.
    pub(crate) fn is_level(&self, near: f64) -> bool {
        self.height[1] - self.height[0] <= near
    }

    /// Whether it is upright, and on average no thicker than `near`, metres.
    pub(crate) fn is_upright(&self, near: f64) -> bool {
        self.height[1] - self.height[0] > near && self.area() <= near * self.length()
    }
}

/// Points of a face, metres: its corners if it lies within them, else a grid of `side` times `side` points in its parameters.
pub(crate) fn face_points(surface: &PlacedSurface<'_>, face: u32, side: u32) -> Vec<DVec3> {
    let domain = surface.face_domain(face);
    let sampled = || match &domain {
        // The corners of a trimmed triangle may be cut away.
        FaceDomain::Polygon(corners) => {
            let inside = samples(&domain, side.min(TRIANGLE_POINTS)).map(|(uv, _)| uv);
            corners.iter().copied().chain(inside).collect()
        }
        FaceDomain::Square => {
            let step = |i: u32| f64::from(i) / f64::from(side.max(2) - 1);
            (0..side).flat_map(|v| (0..side).map(move |u| DVec2::new(step(u), step(v)))).collect()
        }
    };
    let parameters: Vec<DVec2> = face_corners(surface, face).unwrap_or_else(sampled);
    let at = |uv: DVec2| surface.at(face, uv, false).map(|found| found.at.point.position);
    parameters.into_iter().filter_map(at).collect()
}

/// Parameters spread evenly over a domain, `side` times `side` of them over the square and each triangle of a polygon, with the area of the domain that each stands for.
pub(super) fn samples(domain: &FaceDomain, side: u32) -> impl Iterator<Item = (DVec2, f64)> + use<> {
    let fans: Vec<[DVec2; 3]> = match domain {
        FaceDomain::Square => Vec::new(),
        FaceDomain::Polygon(corners) => corners
            .windows(2)
            .skip(1)
            .filter_map(|pair| Some([*corners.first()?, *pair.first()?, *pair.last()?]))
            .collect(),
    };
    let share = 1.0 / f64::from(side * side);
    let at = move |i: u32| (f64::from(i) + 0.5) / f64::from(side);
    let grid: Vec<DVec2> = (0..side * side).map(|i| DVec2::new(at(i % side), at(i / side))).collect();
    let whole = fans.is_empty().then(|| grid.clone()).into_iter().flatten().map(move |uv| (uv, share));
    let parts = fans.into_iter().flat_map(move |[a, b, c]| {
        let area = 0.5 * (b - a).perp_dot(c - a).abs() * share;
        // Equal areas from the first corner on lie between the square roots.
        let place = move |at: DVec2| (a + at.x.sqrt() * ((1.0 - at.y) * (b - a) + at.y * (c - a)), area);
        grid.clone().into_iter().map(place)
    });
    whole.chain(parts)
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
    fn samples_of_a_polygon_have_its_area_and_middle() {
        let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 0.5]].map(DVec2::from).to_vec();
        for (domain, area, middle) in [
            (FaceDomain::Square, 1.0, [0.5, 0.5]),
            // Triangles of 1/2 and 1/4 about (2/3, 1/3) and (1/3, 1/2).
            (FaceDomain::Polygon(corners), 0.75, [5.0 / 9.0, 7.0 / 18.0]),
        ] {
            let all: Vec<(DVec2, f64)> = samples(&domain, 64).collect();
            let sum: f64 = all.iter().map(|(_, weight)| weight).sum();
            let mean: DVec2 = all.iter().map(|(at, weight)| *weight * *at).sum::<DVec2>() / sum;
            assert!((sum - area).abs() < 1e-12 && mean.distance(middle.into()) < 1e-3, "{sum} {mean}");
        }
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
            assert!(
                (floor.area() / (5.3 * 3.7) - 1.0).abs() < 1e-8 && floor.is_level(1e-9),
                "{turn} {floor:?}"
            );
            let wall = quad(DVec3::new(0.0, 3.7, 0.0), DVec3::new(0.0, 0.0, 2.5));
            assert!((wall.length() / 3.7 - 1.0).abs() < 1e-8 && wall.is_upright(1e-9), "{turn} {wall:?}");
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
        assert!(top.is_level(1e-9) && !top.is_upright(1e-9) && (top.area() - 2.0).abs() < 1e-12);
        let [wall] = outlines(ShapeDescription::parallelogram([0.0; 3], [3.0, 4.0, 0.0], [0.0, 0.0, 2.5]))
            .try_into()
            .unwrap();
        assert!(wall.is_upright(1e-9) && !wall.is_level(1e-9) && (wall.length() - 5.0).abs() < 1e-12);
        assert_eq!((wall.height, wall.outline.len()), ([0.0, 2.5], 2));
        // A ball is about a disk; a polygon of 16 of its points has 97 % of the area.
        let [ball] = outlines(ShapeDescription::sphere(1.0)).try_into().unwrap();
        assert!((0.97 * PI..=PI + 1e-9).contains(&ball.area()), "{}", ball.area());
        assert!(!ball.is_level(1e-2) && !ball.is_upright(1e-2));
        assert!(outlines(ShapeDescription::plane()).is_empty());
    }
}
