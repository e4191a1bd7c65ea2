//! Hits of rays with the objects of a scene.

use glanz_geometry::Hit;

/// The hit of a ray with a surface of a scene; [`Scene::interaction`](crate::Scene::interaction) computes the point.
#[derive(Clone, Copy, Debug)]
pub struct SceneHit {
    pub(crate) hit: Hit,
    /// The number of the surface in [`Scene::placed_surfaces`](crate::Scene::placed_surfaces), or in the group in which the hit lies.
    pub(crate) surface: u64,
}

impl SceneHit {
    /// A hit with an object of the group itself.
    pub(crate) fn new(hit: Hit, object: u32) -> Self {
        Self { hit, surface: object.into() }
    }

    /// Ray parameter of the hit.
    #[must_use]
    pub fn t(&self) -> f64 {
        self.hit.t
    }

    /// The hit, seen from the group of the instance in which it lies, with the number of surfaces before those of the instance.
    pub(crate) fn within(self, before: u64) -> Self {
        Self { surface: before + self.surface, ..self }
    }
}

/// The nearest hit of a ray so far, with the primitives of one group. Of hits at the same parameter, that with the primitive of the
/// lowest number counts, whatever the order in which they are found.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NearestHit {
    /// At the end of the ray, if there is none yet.
    found: SceneHit,
    /// [`NONE`] if there is none yet.
    primitive: u32,
}

/// A number of no primitive.
const NONE: u32 = u32::MAX;

impl NearestHit {
    /// None yet, for a ray that ends at `t_max`.
    pub(crate) fn before(t_max: f64) -> Self {
        let end = Hit::new(t_max, 0.0, 0.0, 0);
        Self { found: SceneHit { hit: end, surface: 0 }, primitive: NONE }
    }

    /// The hit.
    pub(crate) fn hit(&self) -> Option<SceneHit> {
        (self.primitive != NONE).then_some(self.found)
    }

    /// Its parameter, or the end of the ray.
    pub(crate) fn t(&self) -> f64 {
        self.found.hit.t
    }

    /// The end up to which hits with further primitives count.
    pub(crate) fn end(&self) -> f64 {
        if self.primitive == NONE { self.t() } else { self.t().next_up() }
    }

    /// Takes the hit with a primitive, by its number in the group, if it comes first.
    pub(crate) fn offer(&mut self, found: SceneHit, primitive: usize) {
        let (t, primitive) = (found.hit.t, primitive as u32);
        if t < self.t() || t == self.t() && primitive < self.primitive {
            *self = Self { found, primitive };
        }
    }
}
