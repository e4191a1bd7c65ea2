//! Intersection with many rays.

use std::sync::atomic::{AtomicUsize, Ordering};

use glanz::geometry::{BoundedRay, DVec3, Hit, Ray, RaySurface, Surface, SurfacePoint};
use numpy::{IntoPyArray, PyArrayDyn, PyArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rayon::prelude::*;

use super::definition::SurfaceState;
use super::hits::{AllHits, RayHits};
use crate::arguments::value_error;
use crate::float_array::{FloatArray, array, zeros};

/// Rays that one thread searches at once.
const BLOCK: usize = 4096;

/// Rays of which one thread collects all hits at once.
const ROOTS_BLOCK: usize = 512;

/// Rays after which signals are handled.
const RAYS_AT_ONCE: usize = 1 << 19;

/// Rays as numbers.
struct RayArrays<'a> {
    origins: &'a [f64],
    directions: &'a [f64],
    /// One per ray, or one for all.
    ends: &'a [f64],
    /// Position of the first invalid ray.
    invalid: AtomicUsize,
}

impl RayArrays<'_> {
    fn count(&self) -> usize {
        self.origins.len() / 3
    }

    /// The ray at `index`; one that meets nothing if it is invalid, which is noted.
    fn ray(&self, index: usize) -> BoundedRay {
        let origin = DVec3::from_slice(&self.origins[3 * index..]);
        let direction = DVec3::from_slice(&self.directions[3 * index..]);
        let t_max = if let [one] = self.ends { *one } else { self.ends[index] };
        if origin.is_finite() && direction.is_finite() && direction != DVec3::ZERO && !t_max.is_nan() {
            BoundedRay::new(Ray::new(origin, direction), t_max)
        } else {
            self.invalid.fetch_min(index, Ordering::Relaxed);
            BoundedRay::new(Ray::new(DVec3::ZERO, DVec3::X), f64::NEG_INFINITY)
        }
    }

    /// The error of the first invalid ray, if there is one.
    fn check(&self) -> PyResult<()> {
        let index = self.invalid.load(Ordering::Relaxed);
        if index == usize::MAX {
            return Ok(());
        }
        let [origin, direction] =
            [self.origins, self.directions].map(|all| DVec3::from_slice(&all[3 * index..]));
        let (origin, direction) = (origin.to_array(), direction.to_array());
        Err(PyValueError::new_err(format!(
            "ray {index} has the origin {origin:?} and the direction {direction:?}; coordinates must be finite, the \
             direction must not be zero, and t_max must be a number"
        )))
    }
}

/// The arrays of a block, reused by the next one.
#[derive(Default)]
struct BatchScratch {
    rays: Vec<BoundedRay>,
    hits: Vec<Option<Hit>>,
    met_rays: Vec<Ray>,
    met: Vec<Hit>,
    points: Vec<SurfacePoint>,
}

/// Places of the results of a block.
struct HitRows<'a> {
    hit: &'a mut [bool],
    distance: &'a mut [f64],
    uv: &'a mut [f64],
    normal: &'a mut [f64],
}

/// Results of one ray among all hits.
struct RootRow {
    ray: i64,
    hit: Hit,
    point: SurfacePoint,
}

/// Number of searches of a surface that were given up.
fn undecided(surface: &Surface) -> u64 {
    if let Surface::Freeform(freeform) = surface { freeform.undecided() } else { 0 }
}

/// The closest hits, or all hits, of rays.
///
/// # Errors
/// `ValueError` for the arrays, invalid rays, and surfaces that cannot be prepared for rays; `MemoryError`, `KeyboardInterrupt`.
pub(super) fn intersect<'py>(
    state: &SurfaceState,
    [origins, directions]: [&Bound<'py, PyAny>; 2],
    all_roots: bool,
    t_max: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let py = origins.py();
    let [origins, directions] =
        [FloatArray::new("origins", origins)?, FloatArray::new("directions", directions)?];
    let numbers = origins.of_shape(&[0, 3], "N x 3")?;
    let count = numbers.len() / 3;
    if origins.shape() != directions.shape() {
        directions.of_shape(&[0, 3], "N x 3")?;
        let given = directions.shape()[0];
        return Err(PyValueError::new_err(format!(
            "there are {count} origins and {given} directions; give as many"
        )));
    }
    let ends = t_max.map(|ends| FloatArray::new("t_max", ends)).transpose()?;
    let ends = match &ends {
        None => &[f64::INFINITY][..],
        Some(ends) if ends.shape().is_empty() => ends.values()?,
        Some(ends) if ends.shape() == [count] => ends.values()?,
        Some(ends) => ends.of_length(count, "one number, or one per ray")?,
    };
    let directions = directions.values()?;
    let rays = RayArrays { origins: numbers, directions, ends, invalid: AtomicUsize::new(usize::MAX) };
    let surface = py.detach(|| state.for_rays()).map_err(value_error)?;
    let before = undecided(surface);
    let mut open = zeros::<bool>(py, &[count])?;
    if all_roots {
        let rows = all_hits(py, state, surface, &rays)?;
        rays.check()?;
        if undecided(surface) > before {
            open = undecided_rays(py, state, surface, &rays, true)?;
        }
        return Ok(root_arrays(py, count, &rows, open)?.into_bound(py).into_any());
    }
    let hits = closest_hits(py, state, surface, &rays, open.clone())?;
    rays.check()?;
    if undecided(surface) > before {
        open = undecided_rays(py, state, surface, &rays, false)?;
    }
    Ok(Bound::new(py, RayHits { undecided: open.unbind(), ..hits })?.into_any())
}

/// The closest hit of each ray.
fn closest_hits(
    py: Python<'_>,
    state: &SurfaceState,
    surface: &Surface,
    rays: &RayArrays<'_>,
    undecided: Bound<'_, PyArrayDyn<bool>>,
) -> PyResult<RayHits> {
    let count = rays.count();
    let (hit, distance) = (zeros::<bool>(py, &[count])?, zeros::<f64>(py, &[count])?);
    let (uv, normal) = (zeros::<f64>(py, &[count, 2])?, zeros::<f64>(py, &[count, 3])?);
    let (mut hits, mut distances) = (hit.try_readwrite()?, distance.try_readwrite()?);
    let (mut uvs, mut normals) = (uv.try_readwrite()?, normal.try_readwrite()?);
    let parts =
        hits.as_slice_mut()?.chunks_mut(RAYS_AT_ONCE).zip(distances.as_slice_mut()?.chunks_mut(RAYS_AT_ONCE));
    let parts = parts.zip(uvs.as_slice_mut()?.chunks_mut(2 * RAYS_AT_ONCE));
    let parts = parts.zip(normals.as_slice_mut()?.chunks_mut(3 * RAYS_AT_ONCE));
    for (part, (((hit, distance), uv), normal)) in parts.enumerate() {
        py.check_signals()?;
        py.detach(|| {
            let _shared = state.searches.read();
            let blocks = hit.par_chunks_mut(BLOCK).zip(distance.par_chunks_mut(BLOCK));
            let blocks = blocks.zip(uv.par_chunks_mut(2 * BLOCK)).zip(normal.par_chunks_mut(3 * BLOCK));
            blocks.enumerate().for_each_init(
                BatchScratch::default,
                |scratch, (block, (((hit, distance), uv), normal))| {
                    let first = part * RAYS_AT_ONCE + block * BLOCK;
                    scratch.closest_hits(surface, rays, first, HitRows { hit, distance, uv, normal });
                },
            );
        });
    }
    drop((hits, distances, uvs, normals));
    Ok(RayHits {
        hit: hit.unbind(),
        distance: distance.unbind(),
        uv: uv.unbind(),
        normal: normal.unbind(),
        undecided: undecided.unbind(),
    })
}

impl BatchScratch {
    /// Writes the closest hits of the rays from `first` on.
    fn closest_hits(&mut self, surface: &Surface, rays: &RayArrays<'_>, first: usize, rows: HitRows<'_>) {
        let HitRows { hit, distance, uv, normal } = rows;
        self.rays.clear();
        self.rays.extend((first..first + hit.len()).map(|index| rays.ray(index)));
        surface.closest_batch(&self.rays, &mut self.hits);
        self.met.clear();
        self.met.extend(self.hits.iter().flatten());
        self.met_rays.clear();
        let met = self.rays.iter().zip(&self.hits).filter(|(_, hit)| hit.is_some());
        self.met_rays.extend(met.map(|(ray, _)| ray.ray));
        surface.point_batch(&self.met_rays, &self.met, &mut self.points);
        let mut points = self.points.iter();
        let places = hit.iter_mut().zip(distance).zip(uv.chunks_exact_mut(2)).zip(normal.chunks_exact_mut(3));
        for (found, (((hit, distance), uv), normal)) in self.hits.iter().zip(places) {
            match found.as_ref().and_then(|found| Some((found, points.next()?))) {
                Some((found, point)) => {
                    (*hit, *distance) = (true, found.t);
                    uv.copy_from_slice(&point.uv.to_array());
                    normal.copy_from_slice(&point.normal.to_array());
                }
                None => {
                    *distance = f64::INFINITY;
                    uv.fill(f64::NAN);
                    normal.fill(f64::NAN);
                }
            }
        }
    }
}

/// All hits of each ray, in the order of rays.
fn all_hits(
    py: Python<'_>,
    state: &SurfaceState,
    surface: &Surface,
    rays: &RayArrays<'_>,
) -> PyResult<Vec<RootRow>> {
    let mut rows = Vec::new();
    for start in (0..rays.count()).step_by(RAYS_AT_ONCE) {
        py.check_signals()?;
        let end = rays.count().min(start + RAYS_AT_ONCE);
        let parts = py.detach(|| {
            let _shared = state.searches.read();
            let firsts: Vec<usize> = (start..end).step_by(ROOTS_BLOCK).collect();
            let block = |first: &usize| {
                let (mut rows, mut hits) = (Vec::new(), Vec::new());
                for index in *first..end.min(first + ROOTS_BLOCK) {
                    let BoundedRay { ray, t_max } = rays.ray(index);
                    hits.clear();
                    surface.all_hits(&ray, t_max, &mut hits);
                    rows.extend(hits.iter().map(|hit| RootRow {
                        ray: index as i64,
                        hit: *hit,
                        point: surface.point(&ray, hit),
                    }));
                }
                rows
            };
            firsts.par_iter().map(block).collect::<Vec<_>>()
        });
        parts.into_iter().for_each(|part| rows.extend(part));
    }
    Ok(rows)
}

/// All hits as arrays.
fn root_arrays<'py>(
    py: Python<'py>,
    count: usize,
    rows: &[RootRow],
    undecided: Bound<'py, PyArrayDyn<bool>>,
) -> PyResult<Py<AllHits>> {
    let mut offsets = vec![0_i64; count + 1];
    for row in rows {
        if let Some(end) = offsets.get_mut(row.ray as usize + 1) {
            *end += 1;
        }
    }
    let mut sum = 0;
    for offset in &mut offsets {
        sum += *offset;
        *offset = sum;
    }
    let numbers = |width: usize, of: fn(&RootRow) -> &[f64]| {
        array(py, &[rows.len(), width], rows.iter().flat_map(of).copied())
    };
    let all = AllHits {
        offsets: offsets.into_pyarray(py).unbind(),
        ray: rows.iter().map(|row| row.ray).collect::<Vec<_>>().into_pyarray(py).unbind(),
        distance: rows.iter().map(|row| row.hit.t).collect::<Vec<_>>().into_pyarray(py).unbind(),
        uv: numbers(2, |row| row.point.uv.as_ref())?.unbind(),
        normal: numbers(3, |row| row.point.normal.as_ref())?.unbind(),
        undecided: undecided.unbind(),
    };
    Py::new(py, all)
}

/// The rays whose searches give up; there are hardly ever any. In blocks that have some, rays are searched one by one, while no other
/// thread searches the surface.
fn undecided_rays<'py>(
    py: Python<'py>,
    state: &SurfaceState,
    surface: &Surface,
    rays: &RayArrays<'_>,
    all: bool,
) -> PyResult<Bound<'py, PyArrayDyn<bool>>> {
    let array = zeros::<bool>(py, &[rays.count()])?;
    let mut places = array.try_readwrite()?;
    for (block, places) in places.as_slice_mut()?.chunks_mut(BLOCK).enumerate() {
        py.check_signals()?;
        py.detach(|| {
            let search = |hits: &mut Vec<Hit>, i: usize| {
                let BoundedRay { ray, t_max } = rays.ray(block * BLOCK + i);
                if all {
                    hits.clear();
                    surface.all_hits(&ray, t_max, hits);
                } else {
                    let _ = surface.intersect(&ray, t_max);
                }
            };
            let _alone = state.searches.write();
            let before = undecided(surface);
            (0..places.len()).into_par_iter().for_each_init(Vec::new, search);
            if undecided(surface) == before {
                return;
            }
            let mut hits = Vec::new();
            for (i, place) in places.iter_mut().enumerate() {
                let before = undecided(surface);
                search(&mut hits, i);
                *place = undecided(surface) > before;
            }
        });
    }
    drop(places);
    Ok(array)
}
