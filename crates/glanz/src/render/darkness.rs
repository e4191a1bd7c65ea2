//! Why a picture is black.

use std::fmt;

use glanz_light::Wavelengths;
use glanz_math::{DVec2, DVec3, Ray};
use glanz_sampling::warp::uniform_sphere;
use glanz_scene::light::Light;
use glanz_scene::{Interaction, Scene};
use glanz_shading::{Bsdf, TransportMode};
use glanz_transport::{Film, PixelRect};

/// Why a picture is black although its scene has lights.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Darkness {
    /// Lights without extent only, which no path meets by chance, and lights are not sampled.
    NotSampled,
    /// None of 256 rays of the camera meets a surface.
    NothingSeen,
    /// Surfaces that no light passes surround the camera on all sides, and it sees no light.
    Enclosed,
    /// No path from the camera found light.
    Unlit,
}

/// Number of rays along each side of the grid by which the camera looks, and of the directions around it.
const GRID: u32 = 16;

/// Largest number of surfaces that are followed on the way to a light.
const MOST_SURFACES: usize = 64;

impl Darkness {
    /// The reason for a film without light; `None` if it has any, or no samples. `samples_lights`: whether lights were sampled at hits.
    pub(super) fn of(film: &Film, scene: &Scene, samples_lights: bool) -> Option<Self> {
        // A film that cannot be read is an error when the picture is made of it.
        let is_black = !film.samples().is_empty() && film.is_black().is_ok_and(|is_black| is_black);
        is_black.then(|| Self::of_black(film.format().crop, scene, samples_lights))
    }

    /// The reason for a black film of the pixels `crop`.
    fn of_black(crop: PixelRect, scene: &Scene, samples_lights: bool) -> Self {
        let lights = scene.lights();
        // Without any, media emit.
        if !samples_lights && !lights.is_empty() && !lights.iter().any(Light::can_be_hit) {
            return Self::NotSampled;
        }
        let hit = |ray: &Ray| scene.intersect(ray, f64::INFINITY);
        let fractions = || {
            let cells = (0..GRID * GRID).map(|cell| DVec2::new((cell % GRID).into(), (cell / GRID).into()));
            cells.map(|cell| (cell + 0.5) / f64::from(GRID))
        };
        let PixelRect { min, size } = crop;
        let [min, size] = [min, size].map(|[x, y]| DVec2::new(x.into(), y.into()));
        let seen = |at: DVec2| scene.camera().ray(min + at * size, DVec2::splat(0.5));
        if !fractions().filter_map(seen).any(|camera| hit(&camera.ray).is_some()) {
            return Self::NothingSeen;
        }
        let eye = scene.camera().position();
        // What light passes does not enclose, and a lamp within has another fault.
        let is_wall = |at: &Interaction| at.light().is_none() && !is_passed(at, scene);
        // Lights with an extent may be within, where no path has met them.
        let points = lights.iter().filter(|light| light.incident(eye).is_some()).count();
        let has_others = points + scene.infinite_lights().len() < lights.len();
        let is_enclosed = !has_others
            && fractions().all(|xi| hit(&Ray::new(eye, uniform_sphere(xi))).is_some_and(|at| is_wall(&at)))
            && !lights.iter().any(|light| is_seen(light, eye, scene));
        if is_enclosed { Self::Enclosed } else { Self::Unlit }
    }
}

/// Whether light passes the surface at a point.
fn is_passed(at: &Interaction, scene: &Scene) -> bool {
    let transmits = |bsdf: Bsdf<'_>| {
        // Along the normal, where no glass reflects all light.
        let branches = bsdf.delta_branches(DVec3::Z, TransportMode::Radiance);
        bsdf.transmits() || branches.iter().flatten().any(|branch| branch.lobe.transmission)
    };
    at.bsdf(scene, &Wavelengths::Rgb).is_none_or(transmits)
}

/// Whether nothing but what light passes is between a point and a light without extent.
fn is_seen(light: &Light, from: DVec3, scene: &Scene) -> bool {
    let Some(incident) = light.incident(from) else { return false };
    let (mut ray, mut left) = (Ray::new(from, incident.towards), incident.distance);
    for _ in 0..MOST_SURFACES {
        let Some(at) = scene.intersect(&ray, left) else { return true };
        if !is_passed(&at, scene) {
            return false;
        }
        left -= at.t;
        ray = at.spawn(incident.towards);
    }
    // A light behind more of them may be seen.
    true
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
                "surfaces surround the camera, and it sees no light; it may be inside of a solid, or in a room without a lamp"
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
    use glanz_transport::FilmFormat;

    use super::*;
    use crate::{LoadedScene, Warning};

    /// The warnings of a picture of a sphere of radius 1 about the origin, seen from `eye` towards `target`.
    fn warnings(
        eye: [f64; 3],
        target: [f64; 3],
        lights: &[LightDescription],
        integrator: &str,
    ) -> Vec<Warning> {
        let scene = scene_from(eye, target)
            .edit(|description| description.lights.extend_from_slice(lights))
            .shape(ShapeDescription::sphere(1.0), MaterialKind::diffuse(0.5));
        warnings_of(scene, integrator)
    }

    fn scene_from(eye: [f64; 3], target: [f64; 3]) -> SceneBuilder {
        SceneBuilder::new().resolution(4, 4).camera(CameraDescription::look_at(eye, target, DVec3::Z))
    }

    fn warnings_of(scene: SceneBuilder, integrator: &str) -> Vec<Warning> {
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

    #[test]
    fn lamp_in_a_bulb_is_in_the_room_and_one_round_the_corner_is_not_seen() {
        let bulb = || {
            scene_from([0.0, -0.7, 0.0], [0.0, -2.0, 0.0])
                .light(LightDescription::point([0.0; 3], 1.0))
                .shape(ShapeDescription::sphere(1.0), MaterialKind::diffuse(0.5))
                .shape(ShapeDescription::sphere(0.3), MaterialKind::dielectric(1.5, 1.0, 1.0))
        };
        for integrator in ["path", "whitted"] {
            let expected = [Warning::Black { reason: Darkness::Unlit }];
            assert_eq!(warnings_of(bulb(), integrator), expected, "{integrator}");
        }
        // A wall at x = 0 leaves open what is beyond y = 1.
        let wall = ShapeDescription::parallelogram([0.0, -3.0, -3.0], DVec3::Y * 4.0, DVec3::Z * 6.0);
        let room = scene_from([-1.0, -1.0, 0.0], [-2.0, -1.0, 0.0])
            .light(LightDescription::point([1.0, -1.0, 0.0], 1.0))
            .shape(ShapeDescription::cuboid([-2.0; 3], [2.0; 3]), MaterialKind::diffuse(0.5))
            .shape(wall, MaterialKind::diffuse(0.5));
        assert_eq!(warnings_of(room, "whitted"), [Warning::Black { reason: Darkness::Enclosed }]);
    }

    #[test]
    fn films_without_samples_are_not_black_and_media_alone_are_not_sampled() {
        let scene = scene_from([0.0, -2.0, 0.0], [0.0; 3])
            .shape(ShapeDescription::sphere(1.0), MaterialKind::diffuse(0.5));
        let (scene, _) = scene.resolve().unwrap();
        let film = Film::try_new(FilmFormat::plain([4, 4])).unwrap();
        assert_eq!(Darkness::of(&film, &scene, true), None);
        assert_eq!(Darkness::of_black(film.format().crop, &scene, false), Darkness::Unlit);
    }
}
