//! Scenes from a few words, and what comes out of them.

use std::f64::consts::TAU;
use std::ops::Range;
use std::sync::Arc;

use glanz_job::{CancelFlag, JobEnd, Silent};
use glanz_light::SpectralDistribution;
use glanz_math::{DMat4, DVec3};
use glanz_sampling::SamplerKind;
use glanz_scene::Scene;
use glanz_scene::description::*;
use glanz_transport::{
    Aov, AovSet, Film, FilmFormat, Filter, Guide, Integrator, IntegratorSettings, PixelRect, RenderError,
    RenderOutcome, RenderSettings, render,
};

pub(crate) fn grey(value: f32) -> SpectrumInput {
    SpectrumInput::Value(SpectralDistribution::Constant(value))
}

pub(crate) fn rgb(value: [f32; 3]) -> SpectrumInput {
    SpectrumInput::Value(SpectralDistribution::Rgb(value))
}

pub(crate) fn diffuse(reflectance: f32) -> MaterialKind {
    MaterialKind::diffuse(grey(reflectance))
}

pub(crate) fn glass() -> MaterialKind {
    MaterialKind::dielectric(1.5, grey(1.0), grey(1.0))
}

pub(crate) fn sphere(radius: f64) -> GeometryDescription {
    GeometryDescription::Sphere { radius, z: [-radius, radius], phi_max: TAU }
}

pub(crate) fn disk(radius: f64) -> GeometryDescription {
    GeometryDescription::Disk { height: 0.0, radius, inner_radius: 0.0, phi_max: TAU }
}

pub(crate) fn plane() -> GeometryDescription {
    let all = [f64::NEG_INFINITY, f64::INFINITY];
    GeometryDescription::Plane { x: all, y: all }
}

pub(crate) fn cuboid(half: f64) -> GeometryDescription {
    GeometryDescription::Cuboid { min: DVec3::splat(-half), max: DVec3::splat(half) }
}

/// A rectangle with corner `o` and edges `a` and `b`, its normal along a x b.
pub(crate) fn rectangle(o: DVec3, a: DVec3, b: DVec3) -> GeometryDescription {
    let positions = vec![o, o + a, o + a + b, o + b];
    GeometryDescription::Triangles {
        positions,
        indices: vec![[0, 1, 2], [0, 2, 3]],
        normals: None,
        uvs: None,
    }
}

pub(crate) fn at(x: f64, y: f64, z: f64) -> DMat4 {
    DMat4::from_translation(DVec3::new(x, y, z))
}

/// A scene under construction.
#[derive(Clone)]
pub(crate) struct Builder(pub(crate) Description);

impl Builder {
    /// One pixel so small that everywhere in it the camera sees the same.
    pub(crate) fn one_pixel(from: DVec3, to: DVec3) -> Self {
        Self::looking(from, to, [1, 1], 1e-6)
    }

    /// `angle`: field of view, radians.
    pub(crate) fn looking(from: DVec3, to: DVec3, resolution: [u32; 2], angle: f64) -> Self {
        let forward = (to - from).normalize();
        let up = if forward.x.abs() < 0.9 { DVec3::X } else { DVec3::Y };
        let right = up.cross(forward).normalize();
        let up = forward.cross(right);
        let mut description = Description::default();
        description.camera.to_world =
            DMat4::from_cols(right.extend(0.0), up.extend(0.0), forward.extend(0.0), from.extend(1.0));
        description.camera.kind = CameraKind::Perspective { field_of_view: angle };
        description.film.resolution = resolution;
        description.filter = FilterDescription { kind: FilterKind::Box, radius: [0.5, 0.5] };
        Self(description)
    }

    pub(crate) fn shape(mut self, geometry: GeometryDescription, place: DMat4, kind: MaterialKind) -> Self {
        let material = self.0.materials.len();
        self.0.materials.push(MaterialDescription { name: String::new(), kind, location: None });
        self.0.world.shapes.push(ShapeDescription {
            geometry,
            to_parent: place,
            reverse_orientation: false,
            material,
            emission: None,
            trim: None,
            receiver: None,
            location: None,
        });
        self
    }

    /// Makes the last shape emit from its front.
    pub(crate) fn shining(mut self, radiance: [f32; 3]) -> Self {
        self.0.world.shapes.last_mut().unwrap().emission = Some(EmissionDescription {
            radiance: SpectralDistribution::Rgb(radiance),
            scale: 1.0,
            power: None,
            two_sided: false,
        });
        self
    }

    /// Turns the last shape inside out.
    pub(crate) fn reversed(mut self) -> Self {
        let shape = self.0.world.shapes.last_mut().unwrap();
        shape.reverse_orientation = !shape.reverse_orientation;
        self
    }

    pub(crate) fn light(mut self, kind: LightKind, value: f32) -> Self {
        self.0.lights.push(LightDescription {
            kind,
            emission: SpectralDistribution::Rgb([value; 3]),
            scale: 1.0,
            to_world: DMat4::IDENTITY,
            location: None,
        });
        self
    }

    pub(crate) fn point_light(self, from: DVec3, intensity: f32) -> Self {
        self.light(LightKind::Point { from, range: None }, intensity)
    }

    pub(crate) fn scene(&self) -> Scene {
        Scene::resolve(self.0.clone()).unwrap().0
    }
}

/// Render settings of a test.
#[derive(Clone)]
pub(crate) struct Run {
    pub(crate) integrator: &'static str,
    pub(crate) depth: u32,
    pub(crate) light_sampling: bool,
    pub(crate) branching: u32,
    pub(crate) guide: GuideSettings,
    pub(crate) sampler: SamplerKind,
    pub(crate) samples: Range<u32>,
    pub(crate) seed: u64,
    pub(crate) threads: usize,
    pub(crate) aovs: AovSet,
}

impl Run {
    pub(crate) fn new(integrator: &'static str, depth: u32, samples: u32) -> Self {
        Self {
            integrator,
            depth,
            light_sampling: true,
            branching: 4,
            guide: GuideSettings::Tree,
            sampler: SamplerKind::Independent,
            samples: 0..samples,
            // Three standard errors leave out one comparison in 370 by chance, and the tests make over a hundred. With
            // seed 1 one of them was outside (distributed over a shining disk, 3.7), and at 0.1 with a hundred times as
            // many samples.
            seed: 2,
            threads: 2,
            aovs: AovSet::NONE.with(Aov::Variance),
        }
    }

    /// `path`, `guided` and `distributed`, each with and without light sampling, and `light`.
    pub(crate) fn all_random(depth: u32, samples: u32) -> Vec<Self> {
        let mut runs = vec![Self::new("light", depth, samples)];
        for integrator in ["path", "guided", "distributed"] {
            for light_sampling in [true, false] {
                runs.push(Self { light_sampling, ..Self::new(integrator, depth, samples) });
            }
        }
        runs
    }

    /// All four rays, through the centre of the pixel.
    pub(crate) fn all_exact(depth: u32) -> Vec<Self> {
        let run = |name| Self { sampler: SamplerKind::Center, ..Self::new(name, depth, 2) };
        ["path", "guided", "distributed", "whitted"].map(run).to_vec()
    }

    pub(crate) fn name(&self) -> String {
        format!("{} depth {} light sampling {}", self.integrator, self.depth, self.light_sampling)
    }

    pub(crate) fn integrator_settings(&self) -> IntegratorSettings {
        IntegratorSettings::resolve(&IntegratorDescription {
            name: self.integrator.to_owned(),
            max_depth: Some(self.depth),
            light_sampling: self.light_sampling,
            branching: Some(self.branching),
            guide: self.guide,
            location: None,
        })
        .unwrap()
    }

    pub(crate) fn settings(&self, description: &Description) -> RenderSettings {
        RenderSettings {
            filter: Filter::try_new(&description.filter).unwrap(),
            sampler: self.sampler,
            seed: self.seed,
            samples_per_pixel: 64,
            samples: self.samples.clone(),
            threads: self.threads,
            time_limit: None,
        }
    }

    pub(crate) fn format(&self, description: &Description) -> FilmFormat {
        let resolution = description.film.resolution;
        FilmFormat {
            resolution,
            crop: PixelRect::from_fractions(resolution, description.film.crop).unwrap(),
            aovs: self.aovs,
            signed: Filter::try_new(&description.filter).unwrap().is_signed(),
            passes: self.integrator_settings().build().learns(),
            splats: self.integrator_settings().build().splats(),
        }
    }

    pub(crate) fn outcome(&self, builder: &Builder) -> RenderOutcome {
        self.outcome_with(builder, self.integrator_settings().build().as_ref())
    }

    pub(crate) fn outcome_with(&self, builder: &Builder, integrator: &dyn Integrator) -> RenderOutcome {
        let film = Film::try_new(self.format(&builder.0)).unwrap();
        let settings = self.settings(&builder.0);
        let stop = CancelFlag::default();
        let outcome = render(&builder.scene(), integrator, &settings, film, &mut Silent, &stop).unwrap();
        assert_eq!(outcome.end, JobEnd::Complete);
        assert_eq!(outcome.film.rejects(), Default::default());
        outcome
    }

    /// Resumes `film`, by a guide that is learnt or that one.
    pub(crate) fn resume(
        &self,
        builder: &Builder,
        film: Film,
        samples: Range<u32>,
        guide: Option<&Arc<Guide>>,
    ) -> Result<RenderOutcome, RenderError> {
        let mut settings = self.settings(&builder.0);
        settings.samples = samples;
        let integrator = match guide {
            Some(guide) => self.integrator_settings().build_with_guide(guide.clone()),
            None => self.integrator_settings().build(),
        };
        render(&builder.scene(), integrator.as_ref(), &settings, film, &mut Silent, &CancelFlag::default())
    }

    pub(crate) fn picture(&self, builder: &Builder) -> Picture {
        self.picture_of(&self.outcome(builder))
    }

    pub(crate) fn picture_of(&self, outcome: &RenderOutcome) -> Picture {
        let pixels = outcome.film.to_pixels().unwrap();
        let plane = |name: &str| pixels.channel(name).unwrap().iter().map(|&v| f64::from(v)).collect();
        Picture {
            mean: ["R", "G", "B"].map(plane),
            variance: ["Variance.R", "Variance.G", "Variance.B"].map(plane),
        }
    }
}

/// Means and their variances, by band and pixel.
pub(crate) struct Picture {
    pub(crate) mean: [Vec<f64>; 3],
    pub(crate) variance: [Vec<f64>; 3],
}

impl Picture {
    /// Mean over all pixels of one band, with its standard error.
    pub(crate) fn average(&self, band: usize) -> (f64, f64) {
        let n = self.mean[band].len() as f64;
        let sum: f64 = self.mean[band].iter().sum();
        let variance: f64 = self.variance[band].iter().sum();
        (sum / n, variance.sqrt() / n)
    }

    /// Fails unless each band's average is `expected` to within three standard errors (and 1e-6 for `f32`).
    ///
    /// `largest_error`: bound on the standard error relative to `expected`, so that the test says something.
    pub(crate) fn assert_average(&self, expected: [f64; 3], largest_error: f64, name: &str) {
        for (band, expected) in expected.into_iter().enumerate() {
            let (mean, error) = self.average(band);
            assert!(
                error <= largest_error * expected,
                "{name}: standard error {error} of {expected} is too large"
            );
            let off = (mean - expected).abs();
            assert!(off <= 3.0 * error + 1e-6 * expected, "{name}: {mean} +- {error}, not {expected}");
        }
    }

    /// Fails unless every value of every band is `expected` to the roundings of a dozen `f32` operations.
    pub(crate) fn assert_exact(&self, expected: f64, name: &str) {
        for band in &self.mean {
            for &mean in band {
                assert!((mean - expected).abs() <= 1e-6 * expected.abs(), "{name}: {mean}, not {expected}");
            }
        }
    }
}

/// Fails unless each band's average over all pixels is the same in both pictures, to within three standard errors. Returns the sum over
/// pixels and bands of the squared differences over their variances, divided by its number of terms; bands tell nearly the same. Pixels
/// without noise have to be the same.
///
/// `largest_error`: bound on the standard error of an average relative to it, so that the test says something.
pub(crate) fn assert_same(a: &Picture, b: &Picture, largest_error: f64, name: &str) -> f64 {
    let (mut squares, mut count) = (0.0, 0.0);
    for band in 0..3 {
        let ((mean, error_a), (other, error_b)) = (a.average(band), b.average(band));
        let error = error_a.hypot(error_b);
        assert!(error < largest_error * mean, "{name}: standard error {error} of {mean}");
        assert!((mean - other).abs() < 3.0 * error, "{name}: {other} +- {error_b}, not {mean} +- {error_a}");
        for i in 0..a.mean[band].len() {
            let variance = a.variance[band][i] + b.variance[band][i];
            let difference = a.mean[band][i] - b.mean[band][i];
            if variance > 0.0 {
                squares += difference.powi(2) / variance;
                count += 1.0;
            } else {
                assert!(difference.abs() < 1e-6, "{name}: {difference} in a pixel without noise");
            }
        }
    }
    squares / count
}
