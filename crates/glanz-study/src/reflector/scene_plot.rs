//! The room as a line drawing: hull, mirror, rays and their ends.

use glanz_geometry::SurfaceError;
use glanz_math::DVec3;
use glanz_report::{Svg, hexadecimal};

use super::fan::FanRay;
use super::room::{POINT_LAMP, SIDE, WALLS, mirror};
use crate::newton::{Hull, TRUE_POINTS};

/// Pixels.
const SIZE: [f64; 2] = [900.0, 800.0];

/// Frame of the drawing: left, top, right, bottom; pixels.
const FRAME: [f64; 4] = [70.0, 60.0, 860.0, 700.0];

/// Directions to the viewer: azimuth from x to y, and height above the floor; radians.
const FROM: [f64; 2] = [-1.02, 0.42];

/// Facets along an edge of the drawn mirror, and parts of a ray, each sorted by depth.
const FACETS: u32 = 16;
const PARTS: u32 = 12;

/// Colours: the walls' edges, direct rays, rays reflected by the mirror, the hull.
const EDGE: &str = "#444444";
const DIRECT: &str = "#8a8a8a";
const MIRRORED: &str = "#d55e00";
const HULL: &str = "#0072b2";

/// A parallel projection: the axes of the picture plane and the direction to the viewer, unit vectors.
struct ParallelProjection {
    right: DVec3,
    up: DVec3,
    towards: DVec3,
    scale: f64,
    middle: [f64; 2],
}

impl ParallelProjection {
    fn new() -> Self {
        let ((sin_a, cos_a), (sin_h, cos_h)) = (FROM[0].sin_cos(), FROM[1].sin_cos());
        let towards = DVec3::new(cos_a * cos_h, sin_a * cos_h, sin_h);
        let right = DVec3::Z.cross(towards).normalize();
        let up = towards.cross(right);
        let extent = |axis: DVec3| SIDE * axis.abs().element_sum();
        let [left, top, far, bottom] = FRAME;
        let scale = ((far - left) / extent(right)).min((bottom - top) / extent(up));
        Self { right, up, towards, scale, middle: [0.5 * (left + far), 0.5 * (top + bottom)] }
    }

    fn place(&self, p: DVec3) -> [f64; 2] {
        let from_middle = p - DVec3::splat(0.5 * SIDE);
        let [x, y] = [self.right, self.up].map(|axis| self.scale * axis.dot(from_middle));
        [self.middle[0] + x, self.middle[1] - y]
    }

    fn nearness(&self, p: DVec3) -> f64 {
        self.towards.dot(p)
    }
}

/// The elements of the drawing, each with its depth: nearer elements hide those behind.
struct Drawing {
    view: ParallelProjection,
    parts: Vec<(f64, Svg)>,
}

impl Drawing {
    fn line(&mut self, a: DVec3, b: DVec3, parts: u32, colour: &str, attributes: &str) {
        for part in 0..parts {
            let [from, to] = [part, part + 1].map(|k| a.lerp(b, f64::from(k) / f64::from(parts)));
            let mut svg = Svg::fragment();
            svg.line(&[self.view.place(from), self.view.place(to)], colour, attributes);
            self.parts.push((self.view.nearness(0.5 * (from + to)), svg));
        }
    }

    fn polygon(&mut self, corners: &[DVec3], fill: &str) {
        let places: Vec<[f64; 2]> = corners.iter().map(|p| self.view.place(*p)).collect();
        let middle = corners.iter().sum::<DVec3>() / corners.len().max(1) as f64;
        // A seam of the same colour: between polygons that only touch, paper shows through.
        let mut svg = Svg::fragment();
        svg.polygon(&places, &format!("fill=\"{fill}\" stroke=\"{fill}\" stroke-width=\"0.6\""));
        self.parts.push((self.view.nearness(middle), svg));
    }

    fn dot(&mut self, at: DVec3, radius: f64, attributes: &str) {
        let mut svg = Svg::fragment();
        svg.circle(self.view.place(at), radius, attributes);
        self.parts.push((self.view.nearness(at), svg));
    }
}

/// The drawing as the text of an SVG file. `coarse`: a fan of which all rays are drawn, those that miss the mirror faintly;
/// `dense`: a fan of which only rays that the mirror reflects are drawn.
///
/// # Errors
/// None in practice: the mirror is valid.
pub(super) fn drawing(coarse: &[FanRay], dense: &[FanRay]) -> Result<String, SurfaceError> {
    let mut drawing = Drawing { view: ParallelProjection::new(), parts: Vec::new() };
    add_room(&mut drawing);
    add_hull(&mut drawing);
    add_mirror(&mut drawing)?;
    for ray in coarse.iter().filter(|ray| ray.hit.is_none()) {
        if let Some(end) = &ray.wall_hit {
            drawing.line(
                ray.ray.origin,
                end.point,
                PARTS,
                DIRECT,
                "stroke-width=\"0.5\" stroke-opacity=\"0.35\"",
            );
            drawing.dot(end.point, 1.8, &format!("fill=\"{DIRECT}\" fill-opacity=\"0.7\""));
        }
    }
    let mut ends = [0_usize; WALLS.len()];
    let hits = || dense.iter().filter_map(|ray| Some((ray.hit.as_ref()?, ray.wall_hit.as_ref()?)));
    for (number, (hit, end)) in hits().enumerate() {
        ends[end.wall] += 1;
        drawing.dot(end.point, 1.7, &format!("fill=\"{MIRRORED}\" fill-opacity=\"0.8\""));
        // Every spot, but a line only for some: hundreds of them hide the mirror.
        if number % 6 == 0 {
            drawing.line(
                hit.point,
                end.point,
                PARTS,
                MIRRORED,
                "stroke-width=\"0.6\" stroke-opacity=\"0.5\"",
            );
        }
    }
    for ray in coarse {
        if let (Some(hit), Some(end)) = (&ray.hit, &ray.wall_hit) {
            drawing.line(ray.ray.origin, hit.point, PARTS, "black", "stroke-width=\"1.6\"");
            drawing.line(hit.point, end.point, PARTS, "black", "stroke-width=\"1.6\"");
            drawing.dot(end.point, 4.0, "fill=\"black\"");
        }
    }
    drawing.dot(POINT_LAMP, 6.0, "fill=\"#e69f00\" stroke=\"black\"");
    drawing.parts.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut svg = Svg::new(SIZE, "A room of 10 m with a lamp, a curved mirror and rays");
    svg.text([24.0, 30.0], "start", "font-size=\"16\"", "The room of document 000, its mirror and its rays");
    for (_, part) in &drawing.parts {
        svg.append(part);
    }
    add_axes(&drawing.view, &mut svg);
    add_legend(&mut svg, &ends);
    Ok(svg.finish())
}

fn add_room(drawing: &mut Drawing) {
    let corner = |bits: u32| {
        SIDE * DVec3::new(f64::from(bits & 1), f64::from(bits >> 1 & 1), f64::from(bits >> 2 & 1))
    };
    for bits in 0..8_u32 {
        for axis in [1, 2, 4].into_iter().filter(|axis| bits & axis == 0) {
            drawing.line(corner(bits), corner(bits | axis), PARTS, EDGE, "stroke-width=\"1\"");
        }
    }
}

fn add_hull(drawing: &mut Drawing) {
    let points = TRUE_POINTS.map(DVec3::from_array);
    let hull = Hull::of(&points);
    for [a, b] in hull.edges(&points) {
        drawing.line(a, b, PARTS, HULL, "stroke-width=\"1.2\" stroke-dasharray=\"4 3\"");
    }
    for point in points {
        drawing.dot(point, 2.6, &format!("fill=\"{HULL}\""));
    }
}

/// The mirror as facets, brighter where it faces a light above the viewer's left shoulder.
fn add_mirror(drawing: &mut Drawing) -> Result<(), SurfaceError> {
    let patch = mirror()?;
    let light = (drawing.view.towards + 0.5 * drawing.view.up - 0.5 * drawing.view.right).normalize();
    let at = |i: u32, j: u32| patch.point(f64::from(i) / f64::from(FACETS), f64::from(j) / f64::from(FACETS));
    for (i, j) in (0..FACETS).flat_map(|i| (0..FACETS - i).map(move |j| (i, j))) {
        let mut facet = |corners: [DVec3; 3]| {
            let [a, b, c] = corners;
            let shade = (b - a).cross(c - a).normalize_or_zero().dot(light).abs();
            let grey = 90.0 + 150.0 * shade;
            let colour = [0.80 * grey, 0.93 * grey, grey].map(|x| x.min(255.0) as u8);
            drawing.polygon(&corners, &hexadecimal(colour));
        };
        facet([at(i, j), at(i + 1, j), at(i, j + 1)]);
        if i + j + 1 < FACETS {
            facet([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    Ok(())
}

/// Metres along the edges of the room that are nearest to the lower border of the picture.
fn add_axes(view: &ParallelProjection, svg: &mut Svg) {
    // The corner of each axis' edge, and which way labels stand off it.
    let edges = [
        ("x", DVec3::new(0.0, 0.0, 0.0), DVec3::X, DVec3::NEG_Y),
        ("y", DVec3::new(SIDE, 0.0, 0.0), DVec3::Y, DVec3::X),
        ("z", DVec3::new(0.0, 0.0, 0.0), DVec3::Z, DVec3::NEG_X),
    ];
    for (name, corner, along, off) in edges {
        for metres in (0..=10).step_by(2) {
            let at = corner + f64::from(metres) * along;
            svg.line(&[view.place(at), view.place(at + 0.2 * off)], EDGE, "stroke-width=\"1\"");
            let [x, y] = view.place(at + 0.6 * off);
            svg.text([x, y + 4.5], "middle", "", &metres.to_string());
        }
        let [x, y] = view.place(corner + 0.5 * SIDE * along + 1.5 * off);
        svg.text([x, y + 4.5], "middle", "font-size=\"15\"", &format!("{name}, m"));
    }
}

fn add_legend(svg: &mut Svg, ends: &[usize; WALLS.len()]) {
    let spots: Vec<String> = WALLS
        .iter()
        .zip(ends)
        .filter(|(_, count)| **count > 0)
        .map(|(wall, count)| format!("{} {count}", wall.name))
        .collect();
    let spots = if spots.is_empty() { "none".to_owned() } else { spots.join(", ") };
    let top = FRAME[3] + 28.0;
    let rows = [
        (DIRECT, "rays of the fan with k = 4 that miss the mirror, and their ends".to_owned()),
        ("black", "the one that hits it".to_owned()),
        (MIRRORED, format!("k = 7, reflected by the mirror, and their ends: {spots}")),
        (HULL, "convex hull of the control points".to_owned()),
    ];
    for (number, (colour, words)) in rows.iter().enumerate() {
        let y = top + 18.0 * number as f64;
        svg.line(&[[24.0, y], [54.0, y]], colour, "");
        svg.text([62.0, y + 4.5], "start", "", words);
    }
    svg.circle([600.0, top], 6.0, "fill=\"#e69f00\" stroke=\"black\"");
    svg.text([614.0, top + 4.5], "start", "", "lamp");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_whole_room_is_within_the_frame_and_nearer_things_come_last() {
        let view = ParallelProjection::new();
        for bits in 0..8_u32 {
            let p = SIDE * DVec3::new(f64::from(bits & 1), f64::from(bits >> 1 & 1), f64::from(bits >> 2));
            let [x, y] = view.place(p);
            assert!((FRAME[0] - 1e-9..=FRAME[2] + 1e-9).contains(&x), "{p} {x}");
            assert!((FRAME[1] - 1e-9..=FRAME[3] + 1e-9).contains(&y), "{p} {y}");
        }
        // Up is up, and moving towards the viewer changes nothing but the nearness.
        assert!(view.place(DVec3::Z)[1] < view.place(DVec3::ZERO)[1]);
        let [a, b] = [DVec3::ONE, DVec3::ONE + view.towards];
        assert!((view.place(a)[0] - view.place(b)[0]).abs() < 1e-9);
        assert!((view.nearness(b) - view.nearness(a) - 1.0).abs() < 1e-12);
    }
}
