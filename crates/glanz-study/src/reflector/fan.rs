//! The fan of rays of document 000 section 4.3, corrected: hits on the mirror and on the walls.

use glanz_geometry::bezier::Barycentric;
use glanz_math::{DVec3, Ray};
use glanz_scene::Scene;

use super::room::{POINT_LAMP, WALLS, WallHit, wall_hit};
use crate::newton::fan_ray;
use crate::report::Report;
use glanz_report::number::plural;
use glanz_report::{Table, TableCell};

/// Largest number of reflections of a ray.
const REFLECTIONS: u32 = 100;

/// Components of a direction below this share of its length are roundings: each is a product of two of sine and cosine, of
/// angles that have half a unit in the last place of pi of their own.
const ROUNDINGS: f64 = 4.0 * f64::EPSILON;

/// Hit of a ray on the mirror.
#[derive(Clone, Copy, Debug)]
pub(super) struct MirrorHit {
    /// Ray parameter; the fan's directions have a length of 0.1 m.
    pub(super) tau: f64,
    /// Parameters on the patch.
    pub(super) at: Barycentric,
    /// Metres.
    pub(super) point: DVec3,
    /// Unit normal on the side that the ray comes from.
    pub(super) normal: DVec3,
    /// Unit direction of the reflected ray.
    pub(super) mirrored: DVec3,
}

/// A ray of the fan.
#[derive(Clone, Copy, Debug)]
pub(super) struct FanRay {
    /// Indices of its angles, from 0.
    pub(super) nodes: [i32; 2],
    pub(super) ray: Ray,
    /// Its first hit on the mirror.
    pub(super) hit: Option<MirrorHit>,
    /// Number of reflections.
    pub(super) reflections: u32,
    /// Its end on a wall; `None` if it starts into the wall of the lamp.
    pub(super) wall_hit: Option<WallHit>,
    /// Length of its last segment, metres.
    pub(super) way: f64,
}

/// The fan of (n + 1)^2 rays, n = 2^k - 1, from [`POINT_LAMP`] at a scene of the mirror alone.
pub(super) fn fan(scene: &Scene, k: u32) -> Vec<FanRay> {
    let n = (1 << k) - 1;
    let nodes = (0..=n).flat_map(|i| (0..=n).map(move |j| [i, j]));
    nodes.map(|nodes| follow(scene, n, nodes)).collect()
}

fn follow(scene: &Scene, n: i32, nodes: [i32; 2]) -> FanRay {
    let v = fan_ray(n, nodes[0], nodes[1]).direction;
    let limit = ROUNDINGS * v.length();
    let ray =
        Ray::new(POINT_LAMP, DVec3::from_array(v.to_array().map(|x| if x.abs() < limit { 0.0 } else { x })));
    let mut traced = FanRay { nodes, ray, hit: None, reflections: 0, wall_hit: wall_hit(&ray), way: 0.0 };
    if traced.wall_hit.is_none() {
        return traced;
    }
    let (mut from, mut last) = (ray, ray);
    while let Some(at) = scene.intersect(&from, f64::INFINITY) {
        let normal = at.point.normal * -at.point.normal.dot(from.direction).signum();
        let incoming = from.direction.normalize();
        let mirrored = (incoming - 2.0 * normal.dot(incoming) * normal).normalize();
        let hit = MirrorHit {
            tau: at.t,
            at: Barycentric::from_parameters(at.point.uv),
            point: at.point.position,
            normal,
            mirrored,
        };
        traced.hit.get_or_insert(hit);
        traced.reflections += 1;
        // Lengths are measured from the point itself; only the next hit is searched from an offset point.
        last = Ray::new(at.point.position, mirrored);
        from = at.spawn(mirrored);
        if traced.reflections == REFLECTIONS {
            break;
        }
    }
    traced.wall_hit = wall_hit(&last);
    traced.way = traced.wall_hit.map_or(0.0, |end| end.t * last.direction.length());
    traced
}

const COLUMNS: [(&str, &str); 23] = [
    ("i", "i"),
    ("j", "j"),
    ("theta_rad", "theta, rad"),
    ("phi_rad", "phi, rad"),
    ("reflections", "reflections"),
    ("r", "r"),
    ("s", "s"),
    ("t", "t"),
    ("tau", "tau"),
    ("point_x_m", "point x, m"),
    ("point_y_m", "point y, m"),
    ("point_z_m", "point z, m"),
    ("normal_x", "normal x"),
    ("normal_y", "normal y"),
    ("normal_z", "normal z"),
    ("mirrored_x", "mirrored x"),
    ("mirrored_y", "mirrored y"),
    ("mirrored_z", "mirrored z"),
    ("wall", "wall"),
    ("way_m", "last way, m"),
    ("wall_x_m", "wall x, m"),
    ("wall_y_m", "wall y, m"),
    ("wall_z_m", "wall z, m"),
];

fn row(ray: &FanRay) -> Vec<TableCell> {
    let [x, y, z] = ray.ray.direction.to_array();
    let angles = [y.atan2(x), z.atan2(x.hypot(y))];
    let mut cells: Vec<TableCell> =
        ray.nodes.map(|node| TableCell::Count(u64::from(node.unsigned_abs()))).into();
    cells.extend(angles.map(TableCell::Precise));
    cells.push(u64::from(ray.reflections).into());
    match &ray.hit {
        Some(MirrorHit { tau, at, point, normal, mirrored }) => {
            cells.extend([at.r, at.s, at.t, *tau].map(TableCell::Precise));
            cells.extend(
                [point, normal, mirrored].into_iter().flat_map(|v| v.to_array()).map(TableCell::Precise),
            );
        }
        None => cells.extend(std::iter::repeat_n(TableCell::Missing, 13)),
    }
    if let Some(end) = &ray.wall_hit {
        cells.extend([WALLS[end.wall].name.into(), TableCell::Precise(ray.way)]);
        cells.extend(end.point.to_array().map(TableCell::Precise));
    }
    cells
}

/// Adds the section to the report; `rays`: the fan with k = 4.
pub(super) fn add_to(rays: &[FanRay], report: &mut Report) {
    report.heading("The fan of 256 rays (k = 4)");
    let hits = || rays.iter().filter_map(|ray| Some((ray, ray.hit.as_ref()?)));
    let outside = rays.iter().filter(|ray| ray.wall_hit.is_none()).count() as u64;
    report.paragraph(format!(
        "Of {} rays from (0, 5, 5), {} into the wall of this point; {} the mirror.",
        rays.len(),
        plural(outside, "starts", "start"),
        plural(hits().count() as u64, "meets", "meet"),
    ));
    for (ray, hit) in hits() {
        let Some(end) = &ray.wall_hit else { continue };
        report.paragraph(format!(
            "Ray (i, j) = ({}, {}) meets it at tau = {}, (r, s, t) = ({}, {}, {}), at the point {}; the normal towards the \
             lamp is {}, the reflected ray has the direction {} and reaches the {} after {} m at {}.",
            ray.nodes[0],
            ray.nodes[1],
            hit.tau,
            hit.at.r,
            hit.at.s,
            hit.at.t,
            hit.point,
            hit.normal,
            hit.mirrored,
            WALLS[end.wall].name,
            ray.way,
            end.point
        ));
    }
    let columns = [("wall", "wall"), ("direct", "rays, direct"), ("mirrored", "rays, reflected")];
    let mut counts = Table::new("fan_walls", "Ends of the rays of the fan.", &columns);
    for (number, wall) in WALLS.iter().enumerate() {
        let on = |mirrored: bool| {
            let ends = |ray: &&FanRay| ray.wall_hit.is_some_and(|end| end.wall == number);
            rays.iter().filter(ends).filter(|ray| ray.hit.is_some() == mirrored).count() as u64
        };
        counts.push([wall.name.into(), on(false).into(), on(true).into()]);
    }
    report.table(counts);
    let mut all = Table::new("fan", "All rays of the fan:", &COLUMNS);
    rays.iter().for_each(|ray| all.push(row(ray)));
    report.data(all);
    for (number, wall) in WALLS.iter().enumerate() {
        let mut table = Table::new(wall.table, format!("Rays that end on the {}:", wall.name), &COLUMNS);
        let ends = |ray: &&FanRay| ray.wall_hit.is_some_and(|end| end.wall == number);
        rays.iter().filter(ends).for_each(|ray| table.push(row(ray)));
        report.data(table);
    }
}

#[cfg(test)]
mod tests {
    use glanz_scene::description::ShapeDescription;

    use super::super::room;
    use super::*;

    #[test]
    fn one_ray_of_the_fan_meets_the_mirror_and_reaches_the_ceiling_where_the_reference_says() {
        let scene = room::alone(ShapeDescription::bezier_triangles(&[room::mirror().unwrap()])).unwrap();
        let rays = fan(&scene, 4);
        assert_eq!(rays.len(), 256);
        let hits: Vec<&FanRay> = rays.iter().filter(|ray| ray.hit.is_some()).collect();
        let [ray] = hits[..] else { panic!("{} rays hit", hits.len()) };
        assert_eq!((ray.nodes, ray.reflections), ([7, 8], 1));
        // Roots of the resultant of two plane cubics, polished to 30 digits by Newton's method.
        let MirrorHit { tau, at, point, normal, mirrored } = ray.hit.unwrap();
        for (found, expected) in [
            (tau, 43.341_790_020_607_25),
            (at.r, 0.063_797_268_237_841_51),
            (at.s, 0.354_776_787_529_589_9),
            (at.t, 0.581_425_944_232_568_5),
            (ray.way, 5.894_527_449_698_083),
        ] {
            assert!((found - expected).abs() < 1e-9, "{found} {expected}");
        }
        let end = ray.wall_hit.unwrap();
        for (found, expected) in [
            (point, [4.216_242_549_347_14, 4.103_809_980_543_923, 5.453_045_070_612_34]),
            (normal, [-0.812_378_898_193_333_8, 0.425_688_116_503_215_64, 0.398_535_008_798_637_07]),
            (mirrored, [-0.386_541_438_004_860_46, 0.505_519_162_027_622_8, 0.771_385_826_631_540_3]),
            (end.point, [1.937_763_432_581_721, 7.083_606_557_464_118, 10.0]),
        ] {
            assert!(found.distance(DVec3::from_array(expected)) < 1e-9, "{found} {expected:?}");
        }
        assert_eq!(WALLS[end.wall].name, "ceiling");
    }

    #[test]
    fn rays_that_start_into_the_wall_of_the_lamp_have_no_end_and_all_others_have_one() {
        let scene = room::alone(ShapeDescription::bezier_triangles(&[room::mirror().unwrap()])).unwrap();
        let rays = fan(&scene, 4);
        for ray in &rays {
            assert_eq!(ray.wall_hit.is_some(), ray.ray.direction.x >= 0.0, "{:?}", ray.nodes);
        }
        // theta = pi (2i - 15) / 15: |theta| < pi / 2 for i = 4 to 11. The poles j = 0, 15 go along the wall for all i.
        let ended = rays.iter().filter(|ray| ray.wall_hit.is_some()).count();
        assert_eq!(ended, 8 * 14 + 2 * 16);
        let ceiling = |ray: &&FanRay| ray.wall_hit.is_some_and(|end| end.wall == 1);
        // The poles at least.
        assert!(rays.iter().filter(ceiling).count() >= 16);
    }
}
