//! The scene, its picture, and the hits of rays through the middles of pixels.

use std::time::Duration;

use glanz_job::Silent;
use glanz_light::{Pixels, Tone};
use glanz_math::{DVec2, DVec3};
use glanz_sampling::SamplerKind;
use glanz_scene::description::{
    CameraDescription, Description, FilterDescription, FilterKind, LightDescription, MaterialKind,
    ShapeDescription,
};
use glanz_scene::{Scene, SceneBuilder};
use glanz_transport::{Film, FilmFormat, FilmSensor, Filter, IntegratorSettings, RenderSettings, render};

use crate::clock::{Stopwatch, TimeScope};
use crate::study::{Settings, StudyError};

/// Samples per pixel of the pictures.
pub(super) const SAMPLES: u32 = 4;

/// Exponent of the highlights.
pub(super) const EXPONENT: f32 = 60.0;

/// Diffuse reflectance: radiance of the surface where it faces the light, without highlight.
const DIFFUSE: f32 = 0.15;

/// Distance along a ray beyond which two hits are on different folds of a surface, metres.
const FOLD: f64 = 0.02;

/// A scene of these surfaces: Phong's model under one light, seen at a grazing angle, so that waves hide one another.
///
/// # Errors
/// None in practice: the scene uses no names.
pub(super) fn description(
    surfaces: Vec<ShapeDescription>,
    [width, height]: [u32; 2],
) -> Result<Description, StudyError> {
    let camera = CameraDescription::look_at([0.0, -3.0, 1.15], [0.0, 0.0, -0.05], DVec3::Z);
    // Irradiance pi: a white diffuse surface that faces the light has radiance 1.
    let light = LightDescription {
        scale: std::f32::consts::PI,
        ..LightDescription::distant([0.15, 0.5, 1.0], DVec3::ZERO, 1.0)
    };
    let builder = SceneBuilder::new()
        .camera(camera.with_field_of_view(33.0_f64.to_radians()))
        .resolution(width, height)
        .shapes(surfaces, MaterialKind::phong(0.0, DIFFUSE, 0.7, EXPONENT))
        .light(light)
        .edit(|scene| {
            scene.filter = FilterDescription { kind: FilterKind::Box, radius: [0.5, 0.5] };
            scene.integrator.name = "whitted".to_owned();
        });
    Ok(builder.describe()?)
}

/// The picture of `scene` by the renderer itself with one thread, and the processor time that the render takes.
pub(super) fn picture(
    scene: &Scene,
    description: &Description,
    settings: &Settings,
) -> Result<(Pixels, Duration), StudyError> {
    let integrator = IntegratorSettings::resolve(&description.integrator)?.build();
    let film = Film::try_new(FilmFormat::plain(description.film.resolution))?;
    let render_settings = RenderSettings {
        filter: Filter::try_new(&description.filter)?,
        sensor: FilmSensor::default(),
        sampler: SamplerKind::Sobol,
        seed: settings.seed,
        samples_per_pixel: SAMPLES,
        samples: 0..SAMPLES,
        threads: 1,
        spectral: false,
        time_limit: None,
    };
    let watch = Stopwatch::start(TimeScope::Process);
    let outcome = render(scene, integrator.as_ref(), &render_settings, film, &mut Silent, &settings.cancel)?;
    let time = watch.elapsed();
    outcome.end.check()?;
    Ok((outcome.film.to_pixels()?, time))
}

/// Number of rows of a picture for which [`FOLD`] also separates folds between neighbouring pixels: it is twelve times their distance.
const FINE: u32 = 1080;

/// Hit of the ray through the middle of a pixel.
#[derive(Clone, Copy, Debug)]
struct PixelHit {
    /// Distance, metres; infinite without a hit.
    t: f64,
    normal: DVec3,
}

/// Hits of all pixels.
pub(super) struct PixelHits {
    width: usize,
    /// Difference of distances, metres, beyond which neighbouring pixels of a picture of this size are on different folds.
    fold: f64,
    pixels: Vec<PixelHit>,
}

/// Differences of a mesh from the exact surface.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Difference {
    /// Largest angle between normals of the same fold, radians.
    pub(super) normal_max: f64,
    /// Root of the mean square of these angles, radians.
    pub(super) normal_rms: f64,
    /// Number of pixels that show another fold, or only one of both surfaces.
    pub(super) pixels: u64,
    /// The same over the length of the silhouettes: their mean displacement, pixels.
    pub(super) silhouette: f64,
}

impl PixelHits {
    pub(super) fn of(scene: &Scene, size: [u32; 2], settings: &Settings) -> Result<Self, StudyError> {
        let mut pixels = Vec::with_capacity(size[0] as usize * size[1] as usize);
        for y in 0..size[1] {
            settings.cancel.check()?;
            for x in 0..size[0] {
                let film = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                let ray = scene.camera().ray(film, DVec2::ZERO);
                let hit = ray.and_then(|camera| scene.intersect(&camera.ray, f64::INFINITY));
                let miss = PixelHit { t: f64::INFINITY, normal: DVec3::ZERO };
                pixels.push(hit.map_or(miss, |at| PixelHit { t: at.t, normal: at.point.shading_normal }));
            }
        }
        // Hits of larger pixels are further apart.
        let fold = FOLD * (f64::from(FINE) / f64::from(size[1])).max(1.0);
        Ok(Self { width: size[0] as usize, fold, pixels })
    }

    /// Neighbours in a row or a column between which the surface is not continuous, times pi / 4: the length of all
    /// silhouettes, pixels (a line of length L crosses 4 L / pi borders of a grid in the mean over its directions).
    ///
    /// # Source
    /// @docarmo1976 section 1-7 (Cauchy and Crofton).
    pub(super) fn silhouette_length(&self) -> f64 {
        let rows = self.pixels.chunks(self.width).map(|row| breaks(row.iter(), self.fold));
        let columns =
            (0..self.width).map(|x| breaks(self.pixels.iter().skip(x).step_by(self.width), self.fold));
        rows.chain(columns).sum::<usize>() as f64 * std::f64::consts::FRAC_PI_4
    }

    /// Share of pixels that show a surface.
    pub(super) fn coverage(&self) -> f64 {
        let covered = self.pixels.iter().filter(|s| s.t.is_finite()).count();
        covered as f64 / self.pixels.len().max(1) as f64
    }

    pub(super) fn difference(&self, mesh: &Self) -> Difference {
        let mut difference = Difference::default();
        let (mut squares, mut count) = (0.0, 0_u64);
        for (exact, other) in self.pixels.iter().zip(&mesh.pixels) {
            if apart(exact, other, FOLD) {
                difference.pixels += 1;
            } else if exact.t.is_finite() {
                let angle = exact.normal.cross(other.normal).length().atan2(exact.normal.dot(other.normal));
                difference.normal_max = difference.normal_max.max(angle);
                squares += angle * angle;
                count += 1;
            }
        }
        difference.normal_rms = (squares / count.max(1) as f64).sqrt();
        difference.silhouette = difference.pixels as f64 / self.silhouette_length().max(1.0);
        difference
    }

    /// Mask of the pixels with comparable highlights: in a neighbourhood of 3 x 3 both show the same fold of the surface, without
    /// a silhouette.
    pub(super) fn inner(&self, mesh: &Self) -> Vec<bool> {
        let height = self.pixels.len() / self.width.max(1);
        let at = |x: usize, y: usize| {
            let i = y * self.width + x;
            self.pixels.get(i).zip(mesh.pixels.get(i))
        };
        let is_inner = |x: usize, y: usize| {
            let Some((middle, _)) = at(x, y) else { return false };
            let around = (y.saturating_sub(1)..(y + 2).min(height))
                .flat_map(|y| (x.saturating_sub(1)..(x + 2).min(self.width)).map(move |x| (x, y)));
            let mut pairs = around.filter_map(|(x, y)| at(x, y));
            middle.t.is_finite() && pairs.all(|(a, b)| !apart(a, b, FOLD) && !apart(a, middle, self.fold))
        };
        (0..height).flat_map(|y| (0..self.width).map(move |x| (x, y))).map(|(x, y)| is_inner(x, y)).collect()
    }
}

/// Breaks of the surface along a line of pixels. Where it is seen at a grazing angle, neighbours are far from each other as well,
/// but so are the next ones.
fn breaks<'a>(line: impl Iterator<Item = &'a PixelHit>, fold: f64) -> usize {
    let line: Vec<f64> = line.map(|hit| hit.t).collect();
    let step = |i: usize| {
        let (a, b) = (line.get(i)?, line.get(i + 1)?);
        (a.is_finite() && b.is_finite()).then(|| (a - b).abs())
    };
    let is_break = |i: usize| match step(i) {
        Some(here) => {
            let around = [i.checked_sub(1).and_then(step), step(i + 1)];
            here > fold && around.into_iter().flatten().all(|other| here > 4.0 * other)
        }
        // Only one of two is a hit.
        None => line.get(i).map(|t| t.is_finite()) != line.get(i + 1).map(|t| t.is_finite()),
    };
    (0..line.len().saturating_sub(1)).filter(|&i| is_break(i)).count()
}

/// Whether only one of two is a hit, or their distances differ by more than `fold`.
fn apart(a: &PixelHit, b: &PixelHit, fold: f64) -> bool {
    match (a.t.is_finite(), b.t.is_finite()) {
        (true, true) => (a.t - b.t).abs() > fold,
        (hit, other) => hit != other,
    }
}

/// Mask of the pixels of `mask` that are brighter than diffuse light alone in one of two pictures.
pub(super) fn highlights(mask: &[bool], a: &Pixels, b: &Pixels) -> Vec<bool> {
    let (a, b) = (a.to_rgb().unwrap_or_default(), b.to_rgb().unwrap_or_default());
    let bright = a.iter().zip(&b).map(|(a, b)| a[1].max(b[1]) > DIFFUSE);
    mask.iter().zip(bright).map(|(inner, bright)| *inner && bright).collect()
}

/// Root of the mean square of the difference of two pictures in grey levels of a display, [0, 255], without rounding to
/// whole levels; over the pixels of `mask`, or all; not a number if there are none.
pub(super) fn grey_rmse(a: &Pixels, b: &Pixels, mask: Option<&[bool]>) -> f64 {
    let (Some(a), Some(b)) = (a.to_rgb(), b.to_rgb()) else { return f64::NAN };
    let (mut squares, mut count) = (0.0, 0_u64);
    for (i, (a, b)) in a.into_iter().zip(b).enumerate() {
        if mask.is_none_or(|m| m.get(i) == Some(&true)) {
            squares += (level(a) - level(b)).powi(2);
            count += 1;
        }
    }
    (squares / count as f64).sqrt()
}

/// Grey level of linear light, [0, 255]; the pictures are grey, so that one channel suffices.
fn level(rgb: [f32; 3]) -> f64 {
    let shown = Tone::default().apply(rgb);
    255.0 * f64::from(glanz_light::rgb::srgb_encode(shown[1]))
}

/// The difference of two pictures, `gain` times larger, on grey.
pub(super) fn difference_picture(a: &Pixels, b: &Pixels, gain: f64) -> Result<Pixels, StudyError> {
    let (a_rgb, b_rgb) = (a.to_rgb().unwrap_or_default(), b.to_rgb().unwrap_or_default());
    let shown = a_rgb.into_iter().zip(b_rgb).map(|(a, b)| {
        let grey = 128.0 + gain * (level(b) - level(a));
        [glanz_light::rgb::srgb_decode((grey / 255.0).clamp(0.0, 1.0) as f32); 3]
    });
    Ok(Pixels::try_from_rgb(a.width(), a.height(), &shown.collect::<Vec<_>>())?)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(hits: &[(f64, DVec3)], width: usize) -> PixelHits {
        PixelHits {
            width,
            fold: FOLD,
            pixels: hits.iter().map(|&(t, normal)| PixelHit { t, normal }).collect(),
        }
    }

    #[test]
    fn grey_levels_are_those_of_the_display() {
        // 1.055 * 0.5^(1/2.4) - 0.055 = 0.735357, times 255 = 187.516.
        let picture = |v: [f32; 2]| Pixels::try_from_rgb(2, 1, &v.map(|v| [v; 3])).unwrap();
        let (a, b) = (picture([0.5, 1.0]), picture([0.0, 7.0]));
        assert!((grey_rmse(&a, &b, None) - 187.516 / 2.0_f64.sqrt()).abs() < 1e-2);
        assert!((grey_rmse(&a, &b, Some(&[true, false])) - 187.516).abs() < 1e-2);
        assert_eq!(grey_rmse(&a, &b, Some(&[false, true])), 0.0);
        // Nothing to compare is not the same as no difference.
        assert!(grey_rmse(&a, &b, Some(&[false, false])).is_nan());
    }

    #[test]
    fn highlights_are_brighter_than_diffuse_light_in_one_picture() {
        let picture = |v: [f32; 3]| Pixels::try_from_rgb(3, 1, &v.map(|v| [v; 3])).unwrap();
        let (a, b) = (picture([0.1, 0.3, 0.9]), picture([0.2, 0.1, 0.9]));
        assert_eq!(highlights(&[true, true, false], &a, &b), [true, true, false]);
        assert_eq!(highlights(&[true; 3], &a, &a), [false, true, true]);
    }

    #[test]
    fn steep_views_are_no_silhouettes_and_folds_are() {
        let line = |ts: &[f64]| {
            breaks(ts.iter().map(|&t| PixelHit { t, normal: DVec3::Z }).collect::<Vec<_>>().iter(), FOLD)
        };
        let miss = f64::INFINITY;
        assert_eq!(line(&[miss, 1.0, 1.001, 1.002, 1.9, 1.903, miss, miss]), 3);
        assert_eq!(line(&[1.0, 1.03, 1.06, 1.10, 1.15, 1.21]), 0);
        assert_eq!(line(&[miss; 3]) + line(&[1.0]) + line(&[]), 0);
    }

    #[test]
    fn angles_and_displaced_silhouettes_are_measured() {
        let turned = DVec3::new(0.0, 0.1_f64.sin(), 0.1_f64.cos());
        let miss = (f64::INFINITY, DVec3::ZERO);
        let exact = row(&[(2.0, DVec3::Z), (2.0, DVec3::Z), miss, miss], 4);
        let mesh = row(&[(2.001, turned), (2.0, DVec3::Z), (2.0, DVec3::Z), miss], 4);
        let difference = exact.difference(&mesh);
        assert!((difference.normal_max - 0.1).abs() < 1e-15);
        assert!((difference.normal_rms - 0.1 / 2.0_f64.sqrt()).abs() < 1e-15);
        assert_eq!(difference.pixels, 1);
        assert_eq!(exact.silhouette_length(), std::f64::consts::FRAC_PI_4);
        assert_eq!(exact.inner(&mesh), [true, false, false, false]);
        assert_eq!(exact.coverage(), 0.5);
    }
}
