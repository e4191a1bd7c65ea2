//! Why a picture is black.

use std::fmt;

use glanz_math::{DVec2, DVec3, Ray};
use glanz_sampling::warp::uniform_sphere;
use glanz_scene::light::Light;
use glanz_scene::{Interaction, Scene};
use glanz_transport::{Film, PixelRect};

/// Why a picture is black although its scene has lights.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Darkness {
    /// Lights without extent only, which no path meets by chance, and lights are not sampled.
    NotSampled,
    /// None of 256 rays of the camera meets a surface.
    NothingSeen,
    /// Surfaces surround the camera on all sides, and all lights are outside.
    Enclosed,
    /// No path from the camera found light.
    Unlit,
}

/// Number of rays along each side of the grid by which the camera looks, and of the directions around it.
const GRID: u32 = 16;

impl Darkness {
    /// The reason for a film without light; `None` if it has any. `samples_lights`: whether lights were sampled at hits.
    pub(super) fn of(film: &Film, scene: &Scene, samples_lights: bool) -> Option<Self> {
        // A film that cannot be read is an error when the picture is made of it.
        if !film.is_black().is_ok_and(|is_black| is_black) {
            return None;
        }
        if !samples_lights && !scene.lights().iter().any(Light::can_be_hit) {
            return Some(Self::NotSampled);
        }
        let hit = |ray: &Ray| scene.intersect(ray, f64::INFINITY);
        let fractions = || {
            let cells = (0..GRID * GRID).map(|cell| DVec2::new((cell % GRID).into(), (cell / GRID).into()));
            cells.map(|cell| (cell + 0.5) / f64::from(GRID))
        };
        let PixelRect { min, size } = film.format().crop;
        let [min, size] = [min, size].map(|[x, y]| DVec2::new(x.into(), y.into()));
        let seen = |at: DVec2| scene.camera().ray(min + at * size, DVec2::splat(0.5));
        if !fractions().filter_map(seen).any(|camera| hit(&camera.ray).is_some()) {
            return Some(Self::NothingSeen);
        }
        let eye = scene.camera().position();
        // What light passes does not enclose, and a lamp within has another fault.
        let is_wall = |at: &Interaction| at.light().is_none() && !at.is_interface(scene);
        // Lights with an extent may be within, where no path has met them.
        let points = scene.lights().iter().filter(|light| light.incident(eye).is_some()).count();
        let has_others = points + scene.infinite_lights().len() < scene.lights().len();
        let is_enclosed = !has_others
            && fractions().all(|xi| hit(&Ray::new(eye, uniform_sphere(xi))).is_some_and(|at| is_wall(&at)))
            && !scene.lights().iter().any(|light| is_seen(light, eye, scene));
        Some(if is_enclosed { Self::Enclosed } else { Self::Unlit })
    }
}

/// Whether nothing is between a point and a light without extent.
fn is_seen(light: &Light, from: DVec3, scene: &Scene) -> bool {
    let incident = light.incident(from);
    incident.is_some_and(|incident| !scene.occluded(&Ray::new(from, incident.towards), incident.distance))
}

impl fmt::Display for Darkness {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NotSampled => {
                "no path meets lights without extent by chance, and lights are not sampled; sample them, or give them an extent"
            }
            Self::NothingSeen => {
                "none of 256 rays of the camera meets a surface; check its position, its direction, and the unit of lengths"
            }
            Self::Enclosed => {
                "the camera is in a closed space that no light enters; it may be inside of a solid"
            }
            Self::Unlit => {
                "no path from the camera found light; more samples may, else check the positions of the lights, \
                 their directions, and what surrounds them"
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use glanz_math::DVec3;
    use glanz_scene::SceneBuilder;
    use glanz_scene::description::{CameraDescription, LightDescription, MaterialKind, ShapeDescription};

    use super::*;
    use crate::{LoadedScene, Warning};

    /// The warnings of a picture of a sphere of radius 1 about the origin, seen from `eye` towards `target`.
    fn warnings(
        eye: [f64; 3],
        target: [f64; 3],
        lights: &[LightDescription],
        integrator: &str,
    ) -> Vec<Warning> {
        let scene = SceneBuilder::new()
            .resolution(4, 4)
            .camera(CameraDescription::look_at(eye, target, DVec3::Z))
            .edit(|description| description.lights.extend_from_slice(lights))
            .shape(ShapeDescription::sphere(1.0), MaterialKind::diffuse(0.5));
        let scene = LoadedScene::from_description("dark", scene.describe().unwrap());
        scene.render().samples(1).integrator(integrator).run().unwrap().warnings().to_vec()
    }

    #[test]
    fn warning_of_a_black_picture_names_the_reason() {
        let lamp = |from: [f64; 3]| [LightDescription::point(from, 1.0)];
        let (outside, origin) = ([0.0, -2.0, 0.0], [0.0; 3]);
        let (front, back) = (lamp([0.0, -3.0, 0.0]), lamp([0.0, 4.0, 0.0]));
        let black = |reason| vec![Warning::Black { reason }];
        for integrator in ["path", "light", "guided", "whitted"] {
            let of = |eye, target, lights: &[_]| warnings(eye, target, lights, integrator);
            assert_eq!(of(outside, origin, &front), [], "{integrator}");
            assert_eq!(of(outside, origin, &[]), [Warning::NoLight], "{integrator}");
            assert_eq!(of(outside, [0.0, -9.0, 0.0], &front), black(Darkness::NothingSeen), "{integrator}");
            assert_eq!(of(outside, origin, &back), black(Darkness::Unlit), "{integrator}");
            assert_eq!(of([0.0, 0.5, 0.0], origin, &front), black(Darkness::Enclosed), "{integrator}");
        }
        let sky = [LightDescription::infinite(1.0)];
        assert_eq!(warnings([0.0, 0.5, 0.0], origin, &sky, "path"), black(Darkness::Enclosed));
    }
}
