//! Opacity of surfaces that are there only in part.
//!
//! A surface of opacity a stops a ray at a point with probability a; otherwise the ray continues to the next hit as if there were none. The
//! decision is a hash of the ray and the hit: it does not depend on threads, batches or the order of the search, and a ray that is
//! traced again meets the same surfaces. Textures of opacity are read at the hit alone: their mean over the footprint of a ray would stop as many
//! rays, with the same variance.

use std::sync::Arc;

use glanz_geometry::{Hit, RaySurface, SurfaceLocation};
use glanz_math::Ray;
use glanz_sampling::hash::{combine, unit_f64};
use glanz_shading::Textures;
use glanz_shading::texture::{FloatInput, TexturePoint};

use crate::object::SceneObject;
use crate::scene::SceneGroup;

/// What a ray searches for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RayKind {
    /// The first hit.
    Closest,
    /// Any hit.
    Shadow,
}

/// The opacity of an object.
#[derive(Clone, Debug)]
pub(crate) struct AlphaTest {
    pub(crate) textures: Arc<Textures>,
    pub(crate) opacity: FloatInput,
    /// Factor for shadow rays.
    pub(crate) shadow: FloatInput,
}

impl AlphaTest {
    /// Whether it is opaque for all rays.
    pub(crate) fn is_opaque(&self) -> bool {
        let is_one = |input: &FloatInput| matches!(input, FloatInput::Constant(x) if *x >= 1.0);
        is_one(&self.opacity) && is_one(&self.shadow)
    }

    /// Whether no ray hits it.
    pub(crate) fn is_absent(&self) -> bool {
        matches!(self.opacity, FloatInput::Constant(x) if x <= 0.0)
    }

    /// The opacity at a point, in [0, 1].
    pub(crate) fn opacity(&self, at: &TexturePoint, kind: RayKind) -> f64 {
        let value = |input| {
            let value = self.textures.float(input, at);
            // Not `clamp`, which keeps NaN.
            if value > 0.0 { f64::from(value.min(1.0)) } else { 0.0 }
        };
        match kind {
            RayKind::Closest => value(&self.opacity),
            RayKind::Shadow => value(&self.opacity) * value(&self.shadow),
        }
    }
}

/// A number in [0, 1) by the bits of a ray and of a hit with an object. The parameters of the surface do not tell apart what lies one behind the other:
/// parallel rays have the same on equal squares.
fn threshold(ray: &Ray, object: u32, hit: &Hit) -> f64 {
    let (o, d) = (ray.origin, ray.direction);
    let numbers = [o.x, o.y, o.z, d.x, d.y, d.z, hit.t, hit.u, hit.v];
    let key = combine(u64::from(object), u64::from(hit.face));
    unit_f64(numbers.iter().fold(key, |key, x| combine(key, x.to_bits())))
}

impl SceneObject {
    /// The opacity at a hit with the ray that is `local` in the frame of the surface.
    pub(crate) fn opacity(&self, local: &Ray, hit: &Hit, kind: RayKind) -> f64 {
        let Some(alpha) = &self.alpha else { return 1.0 };
        let SurfaceLocation { position, normal, uv } = self.surface().location(local, hit);
        let (position, normal) = match self.to_parent() {
            Some(to_parent) => (to_parent.point(position), to_parent.normal(normal)),
            None => (position, normal),
        };
        let at = TexturePoint::new(uv, position).with_normal(normal.normalize_or_zero());
        alpha.opacity(&at, kind)
    }
}

impl SceneGroup {
    /// The first hit of a ray with an object of the group that stops it. `first`: the first of all that count.
    #[cold]
    pub(crate) fn opaque_hit(
        &self,
        object: u32,
        ray: &Ray,
        t_max: f64,
        first: Hit,
        kind: RayKind,
    ) -> Option<Hit> {
        let surface = &self.objects[object as usize];
        let local = surface.local(ray);
        let stops = |hit: &Hit| threshold(ray, object, hit) < surface.opacity(&local, hit, kind);
        if stops(&first) {
            return Some(first);
        }
        let mut hits = Vec::new();
        match surface.solid {
            Some(solid) => self.counting_hits(object, solid, ray, t_max, &mut hits),
            None => surface.surface().all_hits(&local, t_max, &mut hits),
        }
        hits.into_iter().find(|hit| hit.t > first.t && stops(hit))
    }
}

#[cfg(test)]
mod tests {
    use crate::SceneBuilder;
    use crate::description::*;

    #[test]
    fn a_solid_of_which_rays_pass_a_face_is_open() {
        let disk = |z: f64| ShapeDescription::disk(1.0).translated([0.0, 0.0, z]).bounding(1);
        let absent = |shape: ShapeDescription| shape.with_alpha(FloatParameter::Value(0.0));
        for (last, bounds) in [
            (disk(1.0).emitting(1.0), true),
            (absent(disk(1.0)), false),
            (absent(disk(1.0).emitting(1.0)), false),
        ] {
            let grey = || MaterialKind::diffuse(0.5);
            let builder = SceneBuilder::new().shape(disk(0.0), grey()).shape(last, grey());
            let (scene, _) = builder.resolve().unwrap();
            assert!(scene.world().objects.iter().all(|object| object.solid.is_some() == bounds));
        }
    }
}
