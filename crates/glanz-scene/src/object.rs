//! Surfaces with their place in a group.

use glanz_geometry::{AreaSample, BoundedRay, EdgeTubes, Hit, RaySurface, ShadingPoint, Surface};
use glanz_math::{AreaPdf, Bounds3, DVec2, DVec3, Ray, Transform};

use std::sync::Arc;

use crate::alpha::AlphaTest;
use crate::light::LightId;
use crate::medium::MediumInterface;
use crate::parameterization::ShapeParameterization;

/// Attributes of a shape besides its surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ShapeAttributes {
    /// Number in the order of the scene file.
    pub(crate) id: u32,
    pub(crate) material: u32,
    pub(crate) media: MediumInterface,
    /// Whether the normal is reversed.
    pub(crate) reversed: bool,
    /// Whether the material has a [`SurfaceDetail`](crate::surface_detail::SurfaceDetail).
    pub(crate) has_detail: bool,
}

/// A shape that was joined with others into one mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct JoinedShape {
    /// Its faces begin here and end where those of the next shape begin.
    pub(crate) first_face: u32,
    pub(crate) attributes: ShapeAttributes,
}

/// A surface with its place in a group and its attributes in the scene.
#[derive(Clone, Debug)]
pub struct SceneObject {
    surface: Surface,
    /// `None` if the frame of the surface is that of the group.
    to_parent: Option<Transform>,
    attributes: ShapeAttributes,
    /// The shapes that the surface was joined from, by ascending faces; `None` if it is one shape.
    shapes: Option<Arc<[JoinedShape]>>,
    pub(crate) light: Option<LightId>,
    /// The solid of its group that it bounds.
    pub(crate) solid: Option<u32>,
    /// Where rays may pass between the object and its neighbours in the solid.
    tubes: Option<Arc<EdgeTubes>>,
    /// Whether it is an interface, which light passes.
    pub(crate) passable: bool,
    /// The opacity, unless it is opaque everywhere.
    pub(crate) alpha: Option<Arc<AlphaTest>>,
}

impl SceneObject {
    pub(crate) fn new(surface: Surface, to_parent: Transform, attributes: ShapeAttributes) -> Self {
        let to_parent = (to_parent != Transform::IDENTITY).then_some(to_parent);
        Self {
            surface,
            to_parent,
            attributes,
            shapes: None,
            light: None,
            solid: None,
            tubes: None,
            passable: false,
            alpha: None,
        }
    }

    /// The same object as a part of the boundary of a solid.
    pub(crate) fn bounding(self, solid: u32) -> Self {
        let tubes = self.surface.edge_tubes().map(Arc::new);
        Self { solid: Some(solid), tubes, ..self }
    }

    /// Makes it bound no solid.
    pub(crate) fn release(&mut self) {
        (self.solid, self.tubes) = (None, None);
    }

    /// Where rays may pass between the object and its neighbours in the solid, in the frame of the surface.
    pub(crate) fn tubes(&self) -> Option<&EdgeTubes> {
        self.tubes.as_deref()
    }

    /// Tells whether the material has a detail.
    pub(crate) fn set_detail(&mut self, has_detail: bool) {
        self.attributes.has_detail = has_detail;
    }

    /// Several shapes as one surface.
    pub(crate) fn joined(surface: Surface, shapes: Vec<JoinedShape>, first: ShapeAttributes) -> Self {
        Self { shapes: Some(shapes.into()), ..Self::new(surface, Transform::IDENTITY, first) }
    }

    /// Number of shapes in the object.
    pub(crate) fn shape_count(&self) -> usize {
        self.shapes.as_ref().map_or(1, |shapes| shapes.len())
    }

    /// The attributes of the shape that `face` of the surface belongs to.
    #[inline]
    pub(crate) fn attributes(&self, face: u32) -> ShapeAttributes {
        let Some(shapes) = &self.shapes else { return self.attributes };
        let after = shapes.partition_point(|shape| shape.first_face <= face);
        shapes.get(after.wrapping_sub(1)).map_or(self.attributes, |shape| shape.attributes)
    }

    /// The shapes of the object with their parameterizations.
    pub(crate) fn parameterizations(&self) -> Vec<(u32, ShapeParameterization)> {
        let Some(shapes) = &self.shapes else {
            return vec![(self.attributes.id, ShapeParameterization::of(&self.surface))];
        };
        let ends = shapes.iter().skip(1).map(|shape| shape.first_face).chain([u32::MAX]);
        let parameterizations = shapes.iter().zip(ends);
        parameterizations
            .map(|(shape, end)| {
                (shape.attributes.id, ShapeParameterization::of_faces(&self.surface, shape.first_face..end))
            })
            .collect()
    }

    /// The same object in the frame of an outer group, where it bounds no solid.
    pub(crate) fn placed(&self, to_outer: &Transform) -> Self {
        let to_parent = to_outer.after(&self.to_parent.unwrap_or_default());
        Self {
            to_parent: (to_parent != Transform::IDENTITY).then_some(to_parent),
            solid: None,
            tubes: None,
            ..self.clone()
        }
    }

    /// The surface in its own frame.
    #[must_use]
    pub fn surface(&self) -> &Surface {
        &self.surface
    }

    /// Transformation from the frame of the surface to that of the group; `None` if they are the same.
    #[must_use]
    pub fn to_parent(&self) -> Option<&Transform> {
        self.to_parent.as_ref()
    }

    /// Whether the normal is reversed.
    #[must_use]
    pub fn is_reversed(&self) -> bool {
        self.attributes.reversed
    }

    /// A box that holds the object and its tubes; infinite where the object is.
    #[must_use]
    pub fn bounds(&self) -> Bounds3 {
        let bounds = self.surface.bounds();
        let bounds = self.tubes.as_ref().map_or(bounds, |tubes| bounds.union(tubes.bounds()));
        match &self.to_parent {
            // Products of infinity and zero are not numbers: an object that is infinite in its own frame is so in every frame.
            Some(_) if !bounds.is_finite() && !bounds.is_empty() => {
                Bounds3 { min: DVec3::NEG_INFINITY, max: DVec3::INFINITY }
            }
            Some(to_parent) => to_parent.bounds(&bounds),
            None => bounds,
        }
    }

    /// Whether no ray hits it.
    pub(crate) fn is_absent(&self) -> bool {
        self.alpha.as_ref().is_some_and(|alpha| alpha.is_absent())
    }

    /// Whether some hits do not count: in the border of a trimming curve where the solid has no border, or where the object is transparent.
    pub(crate) fn has_optional_hits(&self) -> bool {
        self.alpha.is_some() || self.solid.is_some() && self.surface.trim_region().is_some()
    }

    /// The ray in the frame of the surface.
    #[inline]
    pub(crate) fn local(&self, ray: &Ray) -> Ray {
        self.to_parent.as_ref().map_or(*ray, |t| t.inverse().ray(ray))
    }

    pub(crate) fn intersect(&self, ray: &Ray, t_max: f64) -> Option<Hit> {
        match &self.to_parent {
            None => self.surface.intersect(ray, t_max),
            Some(_) => self.surface.intersect(&self.local(ray), t_max),
        }
    }

    /// The closest hit of each ray, which [`SceneObject::local`] has moved to the frame of the surface.
    pub(crate) fn closest_batch(&self, local: &[BoundedRay], hits: &mut Vec<Option<Hit>>) {
        self.surface.closest_batch(local, hits);
    }

    /// Whether the object stops each ray, which [`SceneObject::local`] has moved to the frame of the surface.
    pub(crate) fn occluded_batch(&self, local: &[BoundedRay], occluded: &mut Vec<bool>) {
        if self.passable {
            occluded.clear();
            occluded.resize(local.len(), false);
        } else {
            self.surface.occluded_batch(local, occluded);
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

    /// The surface at a hit of this object in its own frame, in which the ray is `local`.
    #[inline]
    pub(crate) fn own_point(&self, local: &Ray, hit: &Hit) -> ShadingPoint {
        match &self.surface {
            // Inlined, since the result would be copied in as much time as it is computed.
            Surface::Mesh(mesh) => mesh.shading_point(local, hit),
            surface => surface.shading_point(local, hit),
        }
    }

    /// The density of [`SceneObject::sample`] at a hit of the ray that is `local` in the own frame, if the object is a light.
    #[inline]
    pub(crate) fn area_pdf(&self, local: &Ray, hit: &Hit) -> Option<AreaPdf> {
        self.light?;
        let point = self.surface.point(local, hit);
        let pdf = self.surface.area_pdf(hit, &point)?;
        Some(self.to_parent.as_ref().map_or(pdf, |t| AreaPdf(pdf.0 / t.area_scale(point.normal))))
    }

    /// Moves a point from the own frame to that of the group.
    #[inline]
    pub(crate) fn place(&self, point: &mut ShadingPoint, reversed: bool) {
        if let Some(to_parent) = &self.to_parent {
            *point = point.transformed(to_parent);
        }
        if reversed {
            (point.normal, point.shading_normal) = (-point.normal, -point.shading_normal);
        }
    }

    /// Samples a point of the object by two numbers uniform in [0, 1).
    #[inline]
    pub(crate) fn sample(&self, xi: DVec2) -> Option<AreaSample> {
        let mut sample = match &self.surface {
            // Inlined, as in `own_point`.
            Surface::Mesh(mesh) => mesh.sample_area(xi)?,
            surface => surface.sample_area(xi)?,
        };
        self.place_sample(&mut sample);
        Some(sample)
    }

    /// The point of [`SceneObject::sample`] with its texture coordinates.
    pub(crate) fn sample_with_uv(&self, xi: DVec2) -> Option<(AreaSample, DVec2)> {
        let sample = self.surface.sample(xi)?;
        let uv = sample.point.uv;
        let mut sample = AreaSample::from(sample);
        self.place_sample(&mut sample);
        Some((sample, uv))
    }

    /// Moves a sample from the own frame to that of the group.
    #[inline]
    pub(crate) fn place_sample(&self, sample: &mut AreaSample) {
        if let Some(to_parent) = &self.to_parent {
            *sample = sample.transformed(to_parent);
        }
        if self.attributes(sample.face).reversed {
            sample.normal = -sample.normal;
        }
    }
}
