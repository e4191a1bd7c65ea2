//! Hits of rays with the objects of a scene.

use glanz_geometry::Hit;

use crate::scene::MAX_NESTING;

/// Indices of the instances that lead to an object, from the innermost outwards.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct InstancePath {
    instances: [u32; MAX_NESTING],
    pub(crate) length: usize,
}

impl InstancePath {
    fn push(&mut self, instance: u32) {
        if let Some(slot) = self.instances.get_mut(self.length) {
            *slot = instance;
            self.length += 1;
        }
    }

    pub(crate) fn outermost_first(&self) -> impl Iterator<Item = u32> + '_ {
        self.instances[..self.length].iter().rev().copied()
    }
}

/// The hit of a ray with an object of a scene; [`Scene::interaction`](crate::Scene::interaction) computes the point.
#[derive(Clone, Copy, Debug)]
pub struct SceneHit {
    pub(crate) hit: Hit,
    pub(crate) object: u32,
    pub(crate) path: InstancePath,
}

impl SceneHit {
    /// A hit with an object of the group itself.
    pub(crate) fn new(hit: Hit, object: u32) -> Self {
        Self { hit, object, path: InstancePath::default() }
    }

    /// Ray parameter of the hit.
    #[must_use]
    pub fn t(&self) -> f64 {
        self.hit.t
    }

    /// The hit, seen from the group of the instance in which it lies.
    pub(crate) fn within(mut self, instance: u32) -> Self {
        self.path.push(instance);
        self
    }
}

/// The nearest hit of a ray so far, with the primitives of one group. Of hits at the same parameter, that with the primitive of the
/// lowest number counts, whatever the order in which they are found.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NearestHit {
    /// Its parameter, or the end of the ray.
    pub(crate) t: f64,
    pub(crate) hit: Option<SceneHit>,
    primitive: usize,
}

impl NearestHit {
    /// None yet, for a ray that ends at `t_max`.
    pub(crate) fn before(t_max: f64) -> Self {
        Self { t: t_max, hit: None, primitive: usize::MAX }
    }

    /// The end up to which hits with further primitives count.
    pub(crate) fn end(&self) -> f64 {
        if self.hit.is_some() { self.t.next_up() } else { self.t }
    }

    /// Takes the hit with a primitive if it comes first.
    pub(crate) fn offer(&mut self, found: SceneHit, primitive: usize) {
        let t = found.hit.t;
        if t < self.t || t == self.t && primitive < self.primitive {
            *self = Self { t, hit: Some(found), primitive };
        }
    }
}
