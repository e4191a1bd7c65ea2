//! Exact surfaces with their picture, and meshes compared with them.

use std::time::Duration;

use glanz_geometry::SurfaceError;
use glanz_geometry::spline::NurbsSurface;
use glanz_light::Pixels;
use glanz_scene::Scene;
use glanz_scene::description::ShapeDescription;
use rayon::ThreadPool;

use super::picture::{Difference, PixelHits, description, grey_rmse, highlights, picture};
use super::surface::{Tessellation, exact_bytes, placements, wavy};
use crate::clock;
use crate::study::{Settings, StudyError};

/// Error of highlights that is not visible, grey levels.
pub(super) const LEVEL: f64 = 1.0;

/// Relative width of the interval in which the smallest sufficient number of grid lines is found.
pub(super) const NARROW: f64 = 0.02;

/// Cost of a picture, and its errors against the exact one.
#[derive(Clone, Copy, Debug)]
pub(super) struct MeshCase {
    /// Number of triangles of all surfaces; `None` for the exact ones.
    pub(super) triangles: Option<u64>,
    pub(super) build: Duration,
    pub(super) render: Duration,
    pub(super) bytes: usize,
    pub(super) difference: Difference,
    pub(super) highlight: f64,
    pub(super) whole: f64,
}

impl MeshCase {
    /// Time from control points to picture, seconds.
    pub(super) fn total(&self) -> f64 {
        (self.build + self.render).as_secs_f64()
    }
}

/// One or more surfaces with their exact picture.
pub(super) struct TessellationSetup<'a> {
    settings: &'a Settings,
    size: [u32; 2],
    pool: ThreadPool,
    surfaces: Vec<NurbsSurface>,
    pub(super) hits: PixelHits,
    pub(super) pixels: Pixels,
    pub(super) exact: MeshCase,
}

impl<'a> TessellationSetup<'a> {
    pub(super) fn new(count: usize, size: [u32; 2], settings: &'a Settings) -> Result<Self, StudyError> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
        let surfaces: Vec<NurbsSurface> =
            placements(count).iter().map(wavy).collect::<Result<_, SurfaceError>>()?;
        let make = || surfaces.iter().map(ShapeDescription::nurbs).collect();
        let (scene, build) = build(&pool, &make, size)?;
        let (pixels, render) = picture(&scene, &description(Vec::new(), size)?, settings)?;
        let hits = PixelHits::of(&scene, size, settings)?;
        let bytes = surfaces.iter().map(exact_bytes).sum::<Result<usize, SurfaceError>>()?;
        let difference = Difference::default();
        let exact =
            MeshCase { triangles: None, build, render, bytes, difference, highlight: 0.0, whole: 0.0 };
        Ok(Self { settings, size, pool, surfaces, hits, pixels, exact })
    }

    /// Measures surfaces of 2 n^2 triangles each.
    pub(super) fn triangles(&self, n: u32) -> Result<(MeshCase, Pixels), StudyError> {
        self.settings.cancel.check()?;
        let make = || self.surfaces.iter().map(|s| Tessellation::of(s, n).description()).collect();
        let (scene, build) = build(&self.pool, &make, self.size)?;
        let (pixels, render) = picture(&scene, &description(Vec::new(), self.size)?, self.settings)?;
        let hits = PixelHits::of(&scene, self.size, self.settings)?;
        drop(scene);
        let bytes = self
            .surfaces
            .iter()
            .map(|s| Tessellation::of(s, n).bytes())
            .sum::<Result<usize, SurfaceError>>()?;
        let shown = highlights(&self.hits.inner(&hits), &self.pixels, &pixels);
        let case = MeshCase {
            triangles: Some(2 * u64::from(n).pow(2) * self.surfaces.len() as u64),
            build,
            render,
            bytes,
            difference: self.hits.difference(&hits),
            highlight: grey_rmse(&self.pixels, &pixels, Some(&shown)),
            whole: grey_rmse(&self.pixels, &pixels, None),
        };
        Ok((case, pixels))
    }

    /// The smallest number of triangles with highlights within [`LEVEL`], to the accuracy [`NARROW`] in grid lines; `None` if no
    /// measured grid suffices.
    pub(super) fn smallest(&self, measured: &[(u32, MeshCase)]) -> Result<Option<MeshCase>, StudyError> {
        let good = |case: &MeshCase| case.highlight <= LEVEL;
        let Some((mut enough, mut best)) = measured.iter().find(|(_, case)| good(case)).copied() else {
            return Ok(None);
        };
        // A single cell is never enough.
        let mut few =
            measured.iter().filter(|(n, c)| !good(c) && *n < enough).map(|(n, _)| *n).max().unwrap_or(1);
        while f64::from(enough - few) > (NARROW * f64::from(enough)).max(1.0) {
            let middle = few.midpoint(enough);
            let (case, _) = self.triangles(middle)?;
            if good(&case) {
                (enough, best) = (middle, case);
            } else {
                few = middle;
            }
        }
        Ok(Some(best))
    }
}

/// The scene of the shapes of `make`, and the time of one thread to make and build it.
fn build(
    pool: &ThreadPool,
    make: &(dyn Fn() -> Vec<ShapeDescription> + Sync),
    size: [u32; 2],
) -> Result<(Scene, Duration), StudyError> {
    pool.install(|| clock::repeated(|| (), |()| Ok(Scene::resolve(description(make(), size)?)?.0)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_fall_with_the_square_of_the_grid() {
        let settings = Settings::default();
        let setup = TessellationSetup::new(1, [160, 90], &settings).unwrap();
        let (coarse, _) = setup.triangles(40).unwrap();
        let (fine, _) = setup.triangles(80).unwrap();
        // Chords and interpolated normals are off by the square of the cells' size.
        let falls = |of: fn(&MeshCase) -> f64| of(&coarse) / of(&fine);
        for ratio in [falls(|c| c.difference.normal_rms), falls(|c| c.highlight)] {
            assert!((3.0..5.0).contains(&ratio), "{ratio}");
        }
        assert!(coarse.bytes > 3 * fine.bytes / 16 && fine.bytes > 3 * coarse.bytes);
        assert!(setup.hits.coverage() > 0.2 && setup.hits.silhouette_length() > 100.0);
    }

    #[test]
    fn pictures_of_the_surface_itself_do_not_differ() {
        let settings = Settings::default();
        let setup = TessellationSetup::new(3, [96, 54], &settings).unwrap();
        let again = TessellationSetup::new(3, [96, 54], &settings).unwrap();
        assert_eq!(grey_rmse(&setup.pixels, &again.pixels, None), 0.0);
        let difference = setup.hits.difference(&again.hits);
        assert_eq!((difference.normal_max, difference.pixels), (0.0, 0));
    }

    #[test]
    fn smallest_number_is_the_border_between_enough_and_too_few() {
        let settings = Settings::default();
        let setup = TessellationSetup::new(1, [96, 54], &settings).unwrap();
        let measured: Vec<(u32, MeshCase)> = [8, 200].map(|n| (n, setup.triangles(n).unwrap().0)).to_vec();
        let best = setup.smallest(&measured).unwrap().unwrap();
        assert!(best.highlight <= LEVEL && best.highlight > 0.8 * LEVEL, "{best:?}");
        assert!(setup.smallest(&measured[..1]).unwrap().is_none());
    }
}
