//! Paths of rays through a scene, advanced together from surface to surface so that their rays are batches.

use std::cell::RefCell;

use glanz_geometry::BoundedRay;
use glanz_math::Ray;

use crate::hit::SceneHit;
use crate::scene::Scene;

/// A path of rays. `C`: what the paths of a batch share.
///
/// A path must not depend on the others of its batch. The order of calls for different paths depends on the batch (some vertices are
/// completed before other paths advance): what they add to `shared` must be exact, or kept by path.
pub trait BatchedPath<C: ?Sized>: Sized {
    /// The ray under way; `None` if the path has ended. Only [`BatchedPath::advance`] may change it.
    fn ray(&self) -> Option<Ray>;

    /// Continues from the first hit of the ray, or ends. Paths that branch off are added to `branches`, each with shadow rays and a next ray
    /// of its own.
    fn advance(&mut self, shared: &mut C, hit: Option<&SceneHit>, branches: &mut Vec<Self>);

    /// Adds the shadow rays at the vertex that [`BatchedPath::advance`] reached to `rays`; also of a path that ended there.
    fn shadow_rays(&self, rays: &mut Vec<BoundedRay>) {
        let _ = rays;
    }

    /// Ends the vertex: called after every [`BatchedPath::advance`] and once for every branch, with and without shadow rays. `occluded`: for
    /// each of the shadow rays, whether something stops it.
    fn complete_vertex(&mut self, shared: &mut C, occluded: &[bool]) {
        let _ = (shared, occluded);
    }
}

/// Number of shadow rays from which on they are traced before further paths advance, so that their number is bounded where each vertex has
/// many.
const SHADOW_RAYS: usize = 1024;

thread_local! {
    /// The memory of earlier batches: getting it from the system takes as long as a part of the rays.
    static MEMORY: RefCell<PathBatchMemory> = RefCell::default();
}

/// Memory that batches reuse: a list entry per path.
#[derive(Default)]
struct PathBatchMemory {
    active: Vec<u32>,
    rays: Vec<BoundedRay>,
    hits: Vec<Option<SceneHit>>,
    shadows: ShadowBatch,
}

/// Shadow rays of several paths.
#[derive(Default)]
struct ShadowBatch {
    rays: Vec<BoundedRay>,
    occluded: Vec<bool>,
    /// Each path with the number of its rays and those before it.
    paths: Vec<(u32, usize)>,
}

impl ShadowBatch {
    /// Adds the rays of the path `index`; traces all if they are many.
    fn add<C: ?Sized, P: BatchedPath<C>>(
        &mut self,
        scene: &Scene,
        paths: &mut [P],
        index: u32,
        shared: &mut C,
    ) {
        paths[index as usize].shadow_rays(&mut self.rays);
        self.paths.push((index, self.rays.len()));
        if self.rays.len() >= SHADOW_RAYS {
            self.trace(scene, paths, shared);
        }
    }

    /// Traces the rays and completes the vertices of their paths.
    fn trace<C: ?Sized, P: BatchedPath<C>>(&mut self, scene: &Scene, paths: &mut [P], shared: &mut C) {
        if self.rays.is_empty() {
            self.occluded.clear();
        } else {
            scene.occluded_batch(&self.rays, &mut self.occluded);
        }
        let mut start = 0;
        for (index, end) in self.paths.drain(..) {
            paths[index as usize].complete_vertex(shared, &self.occluded[start..end]);
            start = end;
        }
        self.rays.clear();
    }
}

impl Scene {
    /// Traces paths to their ends; those that branch off are appended to `paths`. A thousand paths are a good number.
    pub fn trace_paths<C: ?Sized, P: BatchedPath<C>>(&self, paths: &mut Vec<P>, shared: &mut C) {
        // None is left for a batch within a batch.
        let mut memory = MEMORY.take();
        memory.trace(self, paths, shared);
        MEMORY.set(memory);
    }
}

impl PathBatchMemory {
    fn trace<C: ?Sized, P: BatchedPath<C>>(&mut self, scene: &Scene, paths: &mut Vec<P>, shared: &mut C) {
        let Self { active, rays, hits, shadows } = self;
        let mut branches = Vec::new();
        active.clear();
        active.extend(0..paths.len() as u32);
        loop {
            active.retain(|&path| paths[path as usize].ray().is_some());
            if active.is_empty() {
                return;
            }
            rays.clear();
            rays.extend(active.iter().filter_map(|&path| paths[path as usize].ray()).map(BoundedRay::from));
            scene.closest_batch(rays, hits);
            for (&path, hit) in active.iter().zip(hits.iter()) {
                paths[path as usize].advance(shared, hit.as_ref(), &mut branches);
                shadows.add(scene, paths, path, shared);
            }
            let first = paths.len() as u32;
            paths.append(&mut branches);
            for path in first..paths.len() as u32 {
                active.push(path);
                shadows.add(scene, paths, path, shared);
            }
            shadows.trace(scene, paths, shared);
        }
    }
}

#[cfg(test)]
mod tests {
    use glanz_math::DVec3;

    use super::*;
    use crate::SceneBuilder;
    use crate::description::*;

    /// A path in given directions, with many shadow rays at some of its vertices, and branches.
    #[derive(Clone, Debug, PartialEq)]
    struct Zigzag {
        number: u32,
        ray: Option<Ray>,
        steps: u32,
        shadows: Vec<Ray>,
        /// For each vertex, how many of its shadow rays were occluded.
        occluded: Vec<usize>,
        /// Parameters of the hits.
        hits: Vec<f64>,
    }

    fn direction(number: u32, step: u32) -> DVec3 {
        let x = f64::from(number * 31 + step * 7);
        DVec3::new((1.3 * x).sin(), (0.7 * x).cos(), (2.1 * x).sin())
    }

    impl Zigzag {
        fn new(number: u32) -> Self {
            let ray = Some(Ray::new(0.1 * direction(number, 99), direction(number, 0)));
            Self { number, ray, steps: 0, shadows: Vec::new(), occluded: Vec::new(), hits: Vec::new() }
        }
    }

    impl BatchedPath<()> for Zigzag {
        fn ray(&self) -> Option<Ray> {
            self.ray
        }

        fn advance(&mut self, (): &mut (), hit: Option<&SceneHit>, branches: &mut Vec<Self>) {
            let (Some(ray), Some(hit)) = (self.ray.take(), hit) else { return };
            self.hits.push(hit.t());
            self.steps += 1;
            let origin = ray.at(0.999 * hit.t());
            let count = self.number * self.steps % 5 * 300;
            let shadow = |k: u32| Ray::new(origin, 3.0 * direction(self.number + k, self.steps));
            self.shadows = (0..count).map(shadow).collect();
            if self.number.is_multiple_of(3) && self.steps == 2 {
                let ray = Some(Ray::new(origin, direction(self.number + 1, 50)));
                branches.push(Self { number: self.number + 1000, ray, ..self.clone() });
            }
            self.ray = (self.steps < 4).then(|| Ray::new(origin, direction(self.number, self.steps)));
        }

        fn shadow_rays(&self, rays: &mut Vec<BoundedRay>) {
            rays.extend(self.shadows.iter().map(|&ray| BoundedRay::new(ray, 1.0)));
        }

        fn complete_vertex(&mut self, (): &mut (), occluded: &[bool]) {
            assert_eq!(occluded.len(), self.shadows.len());
            self.occluded.push(occluded.iter().filter(|&&occluded| occluded).count());
            self.shadows.clear();
        }
    }

    #[test]
    fn paths_and_their_shadow_rays_do_not_depend_on_the_batch() {
        let grey = || MaterialKind::diffuse(0.5);
        let (scene, _) = SceneBuilder::new()
            .shape(ShapeDescription::sphere(2.0), grey())
            .shape(ShapeDescription::sphere(0.4).translated([0.9, 0.0, 0.0]), grey())
            .resolve()
            .unwrap();
        let mut together: Vec<_> = (0..300).map(Zigzag::new).collect();
        scene.trace_paths(&mut together, &mut ());
        assert!(together.len() > 350, "{}", together.len());
        let mut branches = together[300..].iter();
        let (mut shadows, mut occluded) = (0, 0);
        for number in 0..300 {
            let mut alone = vec![Zigzag::new(number)];
            scene.trace_paths(&mut alone, &mut ());
            assert_eq!(alone[0], together[number as usize]);
            assert!(alone[1..].iter().eq(branches.by_ref().take(alone.len() - 1)));
            occluded += alone[0].occluded.iter().sum::<usize>();
            shadows += (1..=alone[0].steps).map(|step| number * step % 5 * 300).sum::<u32>();
        }
        assert!(occluded > 10_000 && occluded < shadows as usize, "{occluded} of {shadows}");
        // The first vertex of a path, ray by ray.
        let ray = Zigzag::new(7).ray.unwrap();
        let t = scene.intersect(&ray, f64::INFINITY).unwrap().t;
        assert_eq!(together[7].hits[0], t);
        let single = |k: u32| scene.occluded(&Ray::new(ray.at(0.999 * t), 3.0 * direction(7 + k, 1)), 1.0);
        assert_eq!(together[7].occluded[0], (0..7 % 5 * 300).filter(|&k| single(k)).count());
    }
}
