//! Parabolic, elliptic and spherical mirrors, exact and as facets, compared with closed forms.

use std::f64::consts::TAU;

use glanz_math::{DVec3, Ray};
use glanz_sampling::{PixelSampler, SamplerKind, warp};
use glanz_scene::Scene;
use glanz_scene::description::{GeometryDescription, ShapeDescription};

use super::revolution::MirrorProfile;
use super::room::alone;
use crate::study::{Settings, StudyError};

/// A mirror of revolution about the z axis with a closed form of its reflections.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Conic {
    /// Focal length 0.5 m, radius 1 m, apex at the origin: light from the focus leaves along the axis.
    Parabolic,
    /// Half axes 0.8 and 1 m, foci at z = +-0.6 m: light from one focus goes to the other.
    Elliptic,
    /// The lower half of a sphere of radius 1 m: light along the axis at the height h crosses it at R / (2 cos theta) from the
    /// middle, sin theta = h / R.
    Spherical,
}

const FOCAL_LENGTH: f64 = 0.5;
const ACROSS: f64 = 0.8;
/// sqrt(1 - 0.8^2).
const FOCUS: f64 = 0.6;

/// Heights of the rays at the sphere, metres: from near the axis to the last ray that crosses it before the mirror
/// (R / (2 cos theta) = R at h = 0.866 R).
pub(super) const HEIGHTS: [f64; 2] = [0.05, 0.85];

/// Representations of a mirror.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum MirrorModel {
    Quadric,
    Patches,
    /// Flat facets, about this number.
    Facets(u64),
    /// The same with interpolated normals.
    Smooth(u64),
}

impl MirrorModel {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Quadric => "quadric",
            Self::Patches => "Bézier patches",
            Self::Facets(_) => "flat facets",
            Self::Smooth(_) => "facets, interpolated normals",
        }
    }
}

/// Deviations of many rays from the closed form.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Deviation {
    pub(super) largest: f64,
    pub(super) rms: f64,
    /// Rays that met the mirror.
    pub(super) rays: u64,
    /// Rays that missed it.
    pub(super) missed: u64,
}

impl Conic {
    pub(super) const ALL: [Self; 3] = [Self::Parabolic, Self::Elliptic, Self::Spherical];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Parabolic => "parabolic",
            Self::Elliptic => "elliptic",
            Self::Spherical => "spherical",
        }
    }

    /// Name and unit of the deviations.
    pub(super) fn measure(self) -> &'static str {
        match self {
            Self::Parabolic => "angle to the axis, rad",
            Self::Elliptic => "distance from the second focus, m",
            Self::Spherical => "crossing of the axis, off by m",
        }
    }

    fn profile(self) -> MirrorProfile {
        match self {
            Self::Parabolic => MirrorProfile::parabola(FOCAL_LENGTH, 1.0),
            Self::Elliptic => MirrorProfile::ellipse(ACROSS, 1.0),
            Self::Spherical => MirrorProfile::ellipse(1.0, 1.0).first_arc(),
        }
    }

    /// A scene of the mirror alone, and the number of its triangles if it has any.
    ///
    /// # Errors
    /// None in practice: the surfaces are valid.
    pub(super) fn scene(self, model: MirrorModel) -> Result<(Scene, Option<u64>), StudyError> {
        let shape: ShapeDescription = match (model, self) {
            (MirrorModel::Quadric, Self::Parabolic) => {
                GeometryDescription::Paraboloid { radius: 1.0, z: [0.0, 0.25 / FOCAL_LENGTH], phi_max: TAU }
                    .into()
            }
            (MirrorModel::Quadric, Self::Elliptic) => {
                ShapeDescription::sphere(1.0).scaled([ACROSS, ACROSS, 1.0])
            }
            (MirrorModel::Quadric, Self::Spherical) => {
                GeometryDescription::Sphere { radius: 1.0, z: [-1.0, 0.0], phi_max: TAU }.into()
            }
            (MirrorModel::Patches, _) => self.profile().patches().into(),
            (MirrorModel::Facets(count), _) => self.profile().triangles(count, false).into(),
            (MirrorModel::Smooth(count), _) => self.profile().triangles(count, true).into(),
        };
        let triangles = match &shape.geometry {
            GeometryDescription::Triangles { indices, .. } => Some(indices.len() as u64),
            _ => None,
        };
        Ok((alone(shape)?, triangles))
    }

    /// The ray for two numbers in [0, 1).
    fn ray(self, xi: glanz_math::DVec2) -> Ray {
        let (sin, cos) = (TAU * xi.y).sin_cos();
        match self {
            Self::Parabolic => {
                // To points of equal projected area, just inside the rim, which facets cut.
                let r = 0.99 * xi.x.sqrt();
                let from = DVec3::new(0.0, 0.0, FOCAL_LENGTH);
                let to = DVec3::new(r * cos, r * sin, r * r / (4.0 * FOCAL_LENGTH));
                Ray::new(from, (to - from).normalize())
            }
            Self::Elliptic => Ray::new(DVec3::new(0.0, 0.0, FOCUS), warp::uniform_sphere(xi)),
            Self::Spherical => {
                let h = HEIGHTS[0] + (HEIGHTS[1] - HEIGHTS[0]) * xi.x;
                Ray::new(DVec3::new(h * cos, h * sin, 0.0), DVec3::NEG_Z)
            }
        }
    }

    /// Deviation of a reflected ray from the closed form.
    fn deviation(self, ray: &Ray, reflected: &Ray) -> f64 {
        let (p, d) = (reflected.origin, reflected.direction);
        match self {
            Self::Parabolic => d.truncate().length().atan2(d.z),
            Self::Elliptic => d.cross(DVec3::new(0.0, 0.0, -FOCUS) - p).length(),
            Self::Spherical => {
                let height = ray.origin.truncate().length();
                (crossing(reflected) - aberration(height)).abs()
            }
        }
    }

    /// Measures the deviations of `rays` rays.
    ///
    /// # Errors
    /// [`StudyError::Interrupted`].
    pub(super) fn deviations(
        self,
        scene: &Scene,
        rays: u32,
        settings: &Settings,
    ) -> Result<Deviation, StudyError> {
        let mut all = Deviation::default();
        let mut squares = 0.0;
        for number in 0..rays {
            if number % 4096 == 0 {
                settings.cancel.check()?;
            }
            let mut sampler = PixelSampler::new(SamplerKind::Sobol, 1, settings.seed, [0, 0], number);
            let ray = self.ray(sampler.next_2d());
            let Some(reflected) = reflect(scene, &ray) else {
                all.missed += 1;
                continue;
            };
            let off = self.deviation(&ray, &reflected);
            all.largest = all.largest.max(off);
            squares += off * off;
            all.rays += 1;
        }
        all.rms = (squares / all.rays.max(1) as f64).sqrt();
        Ok(all)
    }
}

/// Reflection of `ray` by the shading normals.
pub(super) fn reflect(scene: &Scene, ray: &Ray) -> Option<Ray> {
    let at = scene.intersect(ray, f64::INFINITY)?;
    let (d, n) = (ray.direction, at.point.shading_normal);
    Some(Ray::new(at.point.position, (d - 2.0 * n.dot(d) * n).normalize()))
}

/// Distance from the middle of the sphere at which a reflected ray comes closest to the axis, metres.
fn crossing(reflected: &Ray) -> f64 {
    let (p, d) = (reflected.origin, reflected.direction);
    let (across, along) = (p.truncate(), d.truncate());
    -(p.z - d.z * across.dot(along) / along.length_squared())
}

/// The same by the closed form, for a ray at `height` along the axis, metres.
pub(super) fn aberration(height: f64) -> f64 {
    0.5 / (1.0 - height * height).sqrt()
}

/// Crossings of the axis by rays at these heights, in a meridional plane that is neither a border of patches nor an edge of facets.
pub(super) fn crossings(scene: &Scene, heights: &[f64]) -> Vec<[f64; 2]> {
    let (sin, cos) = 1.0_f64.sin_cos();
    let at = |&h: &f64| {
        let ray = Ray::new(DVec3::new(h * cos, h * sin, 0.0), DVec3::NEG_Z);
        Some([h, crossing(&reflect(scene, &ray)?)])
    };
    heights.iter().filter_map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn exact(conic: Conic, model: MirrorModel) -> Deviation {
        let (scene, triangles) = conic.scene(model).unwrap();
        assert_eq!(triangles, None);
        let found = conic.deviations(&scene, 4000, &Settings::default()).unwrap();
        assert_eq!((found.rays, found.missed), (4000, 0), "{conic:?} {model:?}");
        found
    }

    #[test]
    fn exact_parabolic_mirror_collimates_a_point_at_its_focus() {
        for model in [MirrorModel::Quadric, MirrorModel::Patches] {
            let found = exact(Conic::Parabolic, model);
            assert!(found.largest < 1e-9, "{model:?}: {found:?}");
        }
    }

    #[test]
    fn exact_elliptic_mirror_images_focus_to_focus() {
        for model in [MirrorModel::Quadric, MirrorModel::Patches] {
            let found = exact(Conic::Elliptic, model);
            // The mirror is 2 m long.
            assert!(found.largest < 2.0 * 1e-9, "{model:?}: {found:?}");
        }
    }

    #[test]
    fn exact_spherical_mirror_has_the_aberration_of_the_closed_form() {
        // By the closed form itself: paraxial focus at R / 2; at 60 degrees the ray comes back to the sphere's lowest point.
        assert!((aberration(0.0) - 0.5).abs() < 1e-15 && (aberration(0.75_f64.sqrt()) - 1.0).abs() < 1e-15);
        for model in [MirrorModel::Quadric, MirrorModel::Patches] {
            let found = exact(Conic::Spherical, model);
            assert!(found.largest < 1e-9, "{model:?}: {found:?}");
        }
    }

    #[test]
    fn facets_of_a_parabolic_mirror_spread_the_beam_by_their_length_times_the_curvature() {
        // At its ends a facet of length l is off the normal by kappa l / 2, the ray by twice that. Along the profile
        // z = r^2 / 2 the curvature is at most 1 per metre, at the apex, where l = 1 m / 50; around the rim the sectors are
        // pi times as long, with a curvature of 1 / sqrt(2) per metre: together between 1 and 4 times 1 / 50.
        let (scene, triangles) = Conic::Parabolic.scene(MirrorModel::Facets(10_000)).unwrap();
        // 50 rings of 100 sectors.
        assert_eq!(triangles, Some(2 * 50 * 100 - 100));
        let found = Conic::Parabolic.deviations(&scene, 4000, &Settings::default()).unwrap();
        assert!((1.0 / 50.0..4.0 / 50.0).contains(&found.largest), "{found:?}");
    }
}
