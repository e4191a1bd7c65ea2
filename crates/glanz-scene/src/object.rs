//! A surface in its place.

use glanz_geometry::{Hit, RaySurface, Surface, SurfacePoint};
use glanz_math::{AreaPdf, Bounds3, DVec2, Ray, Transform};

use crate::light::LightId;

/// A surface with its place in a group and its role in the scene.
#[derive(Clone, Debug)]
pub struct Object {
    surface: Surface,
    /// `None` where the frame of the surface is that of the group.
    to_parent: Option<Transform>,
    reversed: bool,
    pub(crate) id: u32,
    pub(crate) material: u32,
    pub(crate) light: Option<LightId>,
    /// Whether it is a mere border that light passes.
    pub(crate) passable: bool,
}

impl Object {
    pub(crate) fn new(
        surface: Surface,
        to_parent: Transform,
        reversed: bool,
        id: u32,
        material: u32,
    ) -> Self {
        let to_parent = (to_parent != Transform::IDENTITY).then_some(to_parent);
        Self { surface, to_parent, reversed, id, material, light: None, passable: false }
    }

    /// The same object one level further out.
    pub(crate) fn placed(&self, to_outer: &Transform) -> Self {
        let to_parent = to_outer.after(&self.to_parent.unwrap_or_default());
        Self { to_parent: (to_parent != Transform::IDENTITY).then_some(to_parent), ..self.clone() }
    }

    /// The surface in its own frame.
    #[must_use]
    pub fn surface(&self) -> &Surface {
        &self.surface
    }

    /// From the frame of the surface to that of the group; `None` if they are the same.
    #[must_use]
    pub fn to_parent(&self) -> Option<&Transform> {
        self.to_parent.as_ref()
    }

    /// Whether the normal is turned round.
    #[must_use]
    pub fn is_reversed(&self) -> bool {
        self.reversed
    }

    /// A box that holds the object; infinite where the object is.
    #[must_use]
    pub fn bounds(&self) -> Bounds3 {
        let bounds = self.surface.bounds();
        match &self.to_parent {
            // Products of infinity and zero are not numbers: what has no end in its own frame has none anywhere.
            Some(_) if !bounds.is_finite() && !bounds.is_empty() => {
                Bounds3 { min: glanz_math::DVec3::NEG_INFINITY, max: glanz_math::DVec3::INFINITY }
            }
            Some(to_parent) => to_parent.bounds(&bounds),
            None => bounds,
        }
    }

    /// The ray in the frame of the surface.
    fn local(&self, ray: &Ray) -> Ray {
        self.to_parent.as_ref().map_or(*ray, |t| t.inverse().ray(ray))
    }

    pub(crate) fn intersect(&self, ray: &Ray, t_max: f64) -> Option<Hit> {
        match &self.to_parent {
            None => self.surface.intersect(ray, t_max),
            Some(_) => self.surface.intersect(&self.local(ray), t_max),
        }
    }

    pub(crate) fn occluded(&self, ray: &Ray, t_max: f64) -> bool {
        if self.passable {
            return false;
        }
        match &self.to_parent {
            None => self.surface.occluded(ray, t_max),
            Some(_) => self.surface.occluded(&self.local(ray), t_max),
        }
    }

    /// The surface at a hit of this object, in the group's frame, and the density of [`Object::sample`] there if the
    /// object is a light.
    pub(crate) fn point(&self, ray: &Ray, hit: &Hit) -> (SurfacePoint, Option<AreaPdf>) {
        let local = self.surface.point(&self.local(ray), hit);
        let pdf = self
            .light
            .and_then(|_| self.surface.area_pdf(hit, &local))
            .map(|pdf| self.to_parent_pdf(pdf, &local));
        (self.to_parent_point(local), pdf)
    }

    /// Picks a point of the object by two numbers uniform in [0, 1).
    pub(crate) fn sample(&self, xi: DVec2) -> Option<(SurfacePoint, AreaPdf)> {
        let sample = self.surface.sample(xi)?;
        Some((self.to_parent_point(sample.point), self.to_parent_pdf(sample.pdf, &sample.point)))
    }

    fn to_parent_point(&self, local: SurfacePoint) -> SurfacePoint {
        let point = self.to_parent.as_ref().map_or(local, |t| local.transformed(t));
        if self.reversed { point.reversed() } else { point }
    }

    fn to_parent_pdf(&self, pdf: AreaPdf, local: &SurfacePoint) -> AreaPdf {
        self.to_parent.as_ref().map_or(pdf, |t| AreaPdf(pdf.0 / t.area_scale(local.normal)))
    }
}
