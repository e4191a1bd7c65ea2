//! The room of document 000, chapter 4: lamp, mirror and walls.

use glanz_formats::{Options, load_str};
use glanz_geometry::SurfaceError;
use glanz_geometry::bezier::TrianglePatch;
use glanz_math::{DVec3, Ray};
use glanz_scene::description::{MaterialKind, ShapeDescription};
use glanz_scene::{Description, Scene, SceneBuilder};

use crate::newton::TRUE_POINTS;
use crate::study::StudyError;

/// Side of the room, metres; one corner is the origin.
pub(super) const SIDE: f64 = 10.0;

/// Share of the light that the mirror reflects.
pub(super) const REFLECTANCE: f64 = 0.9;

/// The lamp of the scene: middle (m), radius (m), flux (lm).
pub(super) const LAMP: (DVec3, f64, f64) = (DVec3::new(0.25, 5.0, 5.0), 0.1, 1000.0);

/// The lamp of document 000, a point on a wall, metres.
pub(super) const POINT_LAMP: DVec3 = DVec3::new(0.0, 5.0, 5.0);

/// Lamp and mirror, without walls.
///
/// # Errors
/// None in practice: the scene is valid.
pub(super) fn description() -> Result<Description, StudyError> {
    let text = include_str!("../../scenes/reflector.pbrt");
    let loaded = load_str("scenes/reflector.pbrt", text, &Options::default())
        .map_err(|diagnostics| StudyError::Unreadable(diagnostics.to_string()))?;
    Ok(loaded.description)
}

/// The mirror: the cubic triangle of document 000.
///
/// # Errors
/// None in practice: the control points are valid.
pub(super) fn mirror() -> Result<TrianglePatch, SurfaceError> {
    TrianglePatch::try_from_points(3, &TRUE_POINTS.map(DVec3::from_array), None)
}

/// A scene of one mirror, alone.
///
/// # Errors
/// [`StudyError::Surface`], [`StudyError::Scene`].
pub(super) fn alone(shape: impl Into<ShapeDescription>) -> Result<Scene, StudyError> {
    Ok(SceneBuilder::new().shape(shape, material()).resolve()?.0)
}

/// The material of mirrors.
pub(super) fn material() -> MaterialKind {
    MaterialKind::mirror(REFLECTANCE as f32)
}

/// A wall of the room.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Wall {
    /// Name, that of the receiver.
    pub(super) name: &'static str,
    /// Name of the table of the fan's points on it.
    pub(super) table: &'static str,
    /// The axis perpendicular to it.
    axis: usize,
    /// Whether it is at the far end of this axis.
    is_far: bool,
}

/// All six, in the order of the receivers.
pub(super) const WALLS: [Wall; 6] = [
    Wall { name: "floor", table: "fan_floor", axis: 2, is_far: false },
    Wall { name: "ceiling", table: "fan_ceiling", axis: 2, is_far: true },
    Wall { name: "wall x=0", table: "fan_x0", axis: 0, is_far: false },
    Wall { name: "wall x=10", table: "fan_x10", axis: 0, is_far: true },
    Wall { name: "wall y=0", table: "fan_y0", axis: 1, is_far: false },
    Wall { name: "wall y=10", table: "fan_y10", axis: 1, is_far: true },
];

/// Hit of a ray on a wall.
#[derive(Clone, Copy, Debug)]
pub(super) struct WallHit {
    /// Position in [`WALLS`].
    pub(super) wall: usize,
    /// Ray parameter, > 0.
    pub(super) t: f64,
    /// Metres.
    pub(super) point: DVec3,
}

/// First hit of a ray from inside on a wall; `None` if the ray starts on a wall and leaves the room at once.
///
/// # Source
/// @pumberger2010 function `schnittbox`; departures: all six walls, of which the first ahead counts.
pub(super) fn wall_hit(ray: &Ray) -> Option<WallHit> {
    let mut first: Option<WallHit> = None;
    for (number, wall) in WALLS.iter().enumerate() {
        let (o, d) = (ray.origin[wall.axis], ray.direction[wall.axis]);
        if if wall.is_far { d <= 0.0 } else { d >= 0.0 } {
            continue;
        }
        let plane = if wall.is_far { SIDE } else { 0.0 };
        let t = (plane - o) / d;
        if first.is_none_or(|found| t < found.t) {
            let mut point = ray.at(t);
            point[wall.axis] = plane;
            first = Some(WallHit { wall: number, t, point });
        }
    }
    first.filter(|found| found.t > 0.0)
}

impl WallHit {
    /// Number of the cell of its wall, of `n` x `n`.
    pub(super) fn cell(&self, n: u32) -> usize {
        let [a, b] = match WALLS[self.wall].axis {
            0 => [self.point.y, self.point.z],
            1 => [self.point.z, self.point.x],
            _ => [self.point.x, self.point.y],
        }
        .map(|x| ((x / SIDE * f64::from(n)) as u32).min(n - 1));
        (b * n + a) as usize
    }
}

#[cfg(test)]
mod tests {
    use glanz_illumination::{GridResolution, ReceiverRequest, add_walls};

    use super::*;

    #[test]
    fn rays_end_on_the_first_wall_ahead() {
        let middle = DVec3::splat(5.0);
        for (number, d) in [
            (0, DVec3::new(0.1, 0.2, -0.3)),
            (1, DVec3::new(0.1, -0.2, 0.3)),
            (2, DVec3::new(-0.3, 0.2, 0.1)),
            (3, DVec3::new(0.3, 0.2, 0.1)),
            (4, DVec3::new(0.2, -0.3, 0.1)),
            (5, DVec3::new(0.2, 0.3, 0.1)),
        ] {
            let found = wall_hit(&Ray::new(middle, d)).unwrap();
            // 5 m at 0.3 per unit.
            assert!(found.wall == number && (found.t - 5.0 / 0.3).abs() < 1e-12, "{d}");
            assert!(found.point.distance(middle + d * 5.0 / 0.3) < 1e-12);
        }
        // From the wall x = 0: into it, along it, away from it.
        assert!(wall_hit(&Ray::new(POINT_LAMP, DVec3::new(-1.0, 0.1, 0.0))).is_none());
        assert_eq!(wall_hit(&Ray::new(POINT_LAMP, DVec3::Z)).unwrap().wall, 1);
        assert_eq!(wall_hit(&Ray::new(POINT_LAMP, DVec3::X)).unwrap().wall, 3);
    }

    #[test]
    fn the_scene_holds_the_mirror_and_the_lamp_that_are_calculated_with() {
        let mut described = description().unwrap();
        add_walls(&mut described, DVec3::splat(SIDE));
        let scene = Scene::resolve(described).unwrap().0;
        let requests = ReceiverRequest::of_scene(&scene, GridResolution::Longer(4));
        let names: Vec<&str> = requests.iter().map(|request| request.name.as_str()).collect();
        assert_eq!(names, WALLS.map(|wall| wall.name));
        // A ray through the lamp's middle meets it at its radius.
        let (middle, radius, _) = LAMP;
        let to_lamp = Ray::new(DVec3::new(0.25, 5.0, 1.0), DVec3::Z);
        let met = scene.intersect(&to_lamp, f64::INFINITY).unwrap();
        assert!((met.t - (middle.z - 1.0 - radius)).abs() < 1e-9 && met.light().is_some());
        let at = mirror().unwrap().point(0.25, 0.25);
        let down = Ray::new(at + 0.5 * DVec3::Z, DVec3::NEG_Z);
        assert!((scene.intersect(&down, f64::INFINITY).unwrap().t - 0.5).abs() < 1e-9);
    }
}
