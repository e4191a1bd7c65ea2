//! Faces without topology: trimmed, bounded and whole surfaces.

use glanz_brep::model::{Curve, EntityId, Face, FaceBound, FaceSurface};
use glanz_math::glam::DAffine2;
use glanz_math::{DMat4, DVec2};

use super::boundary::{BoundarySegment, is_counterclockwise};
use super::entity::IgesEntity;
use super::lowering::{IgesFaceState, IgesReader, MAX_DEPTH};
use super::surface_curves::LIFTED;
use super::surfaces::{SurfaceLink, own_parameters};
use crate::cad::{ENTITY_COST, Refusal};

/// What is done about a damaged curve in parameters: the curve in space is enough.
pub(super) const LEFT_OUT: &str = "the parameter curve is left out";

impl<'a> IgesReader<'a> {
    /// The index of a face; `None` if it cannot be read, which is reported.
    pub(super) fn face_of(
        &mut self,
        entity: IgesEntity<'a>,
        lower: impl FnOnce(&mut Self) -> Result<usize, Refusal>,
    ) -> Option<usize> {
        match self.faces.get(&entity.index) {
            Some(IgesFaceState::Read(face)) => return Some(*face),
            Some(IgesFaceState::Refused | IgesFaceState::Hidden) => return None,
            None => {}
        }
        let face = lower(self);
        let state = match &face {
            Ok(face) => IgesFaceState::Read(*face),
            Err(refusal) => {
                self.report.omit(entity.id(), refusal);
                IgesFaceState::Refused
            }
        };
        self.faces.insert(entity.index, state);
        face.ok()
    }

    /// A face with its attributes; `own`: the number of its parameters.
    pub(super) fn add_face(
        &mut self,
        entity: IgesEntity<'_>,
        link: &SurfaceLink,
        bounds: Vec<FaceBound>,
        own: usize,
    ) -> Result<usize, Refusal> {
        self.budget.spend(entity.id(), ENTITY_COST)?;
        self.model.faces.push(Face {
            surface: link.index,
            same_sense: !link.reversed,
            bounds,
            name: entity.name(own),
            style: entity.color(),
            layer: entity.layer(),
            entity: entity.id(),
        });
        Ok(self.model.faces.len() - 1)
    }

    /// `PTS, N1, N2, PTO, PTI...`: a surface within an outer boundary (its border if N1 is 0), with holes.
    pub(super) fn trimmed_surface(&mut self, entity: IgesEntity<'a>) -> Result<usize, Refusal> {
        let link = self.surface(entity.reference(1)?)?;
        let holes = entity.list_length(3, 5, 1)?;
        let mut bounds = Vec::new();
        let outer = if entity.flag(2)? { entity.optional_reference(4)? } else { None };
        match outer {
            Some(outer) => bounds.push(self.curve_on_surface(outer, &link, true)?),
            None => bounds.extend(self.whole(entity, &link, holes > 0)?),
        }
        for i in 0..holes {
            bounds.push(self.curve_on_surface(entity.reference(5 + i)?, &link, false)?);
        }
        self.add_face(entity, &link, bounds, 4 + holes)
    }

    /// A surface by itself.
    pub(super) fn whole_surface(&mut self, entity: IgesEntity<'a>) -> Result<usize, Refusal> {
        let link = self.surface(entity)?;
        let bounds = if entity.kind() == 108 {
            let boundary = match entity.form() {
                1 => entity.optional_reference(5)?,
                -1 => return Err(entity.refuse("the plane is a hole of another one, which is not read")),
                _ => None,
            };
            let boundary = boundary.ok_or_else(|| entity.refuse("the plane has no boundary"))?;
            let curves = self.segments(boundary, self.metres() * entity.matrix()?, MAX_DEPTH)?;
            vec![self.bound(boundary, link.index, BoundarySegment::zip(curves, Vec::new()), false, true)?]
        } else {
            self.whole(entity, &link, false)?
        };
        self.add_face(entity, &link, bounds, own_parameters(entity)?)
    }

    /// The outer bounds of a face that ends where its surface does: none if it is all of a spline, and has no holes.
    fn whole(
        &mut self,
        entity: IgesEntity<'a>,
        link: &SurfaceLink,
        holes: bool,
    ) -> Result<Vec<FaceBound>, Refusal> {
        let surface = self.model.surfaces.get(link.index).map(|entry| &entry.surface);
        let all = match (surface, link.ranges) {
            (Some(FaceSurface::Spline(surface)), Some(ranges)) => {
                ranges == [surface.knots_u().domain(), surface.knots_v().domain()]
            }
            _ => false,
        };
        if all && !holes { Ok(Vec::new()) } else { self.border(entity, link) }
    }

    /// `CRTN, SPTR, BPTR, CPTR, PREF`: a curve by its image B in parameters and by its points C in space.
    fn curve_on_surface(
        &mut self,
        entity: IgesEntity<'a>,
        link: &SurfaceLink,
        outer: bool,
    ) -> Result<FaceBound, Refusal> {
        if entity.kind() != 142 {
            return Err(entity.refuse_kind("boundary of a trimmed surface"));
        }
        // It refers to the surface, too.
        entity.optional_reference(2)?;
        let curve = entity.optional_reference(4)?;
        let parameters = entity.optional_reference(3);
        let curves = curve.map(|curve| self.segments(curve, self.metres(), MAX_DEPTH)).transpose()?;
        let given =
            parameters.and_then(|curve| curve.map(|curve| self.curves_in_parameters(curve)).transpose());
        let given = given.unwrap_or_else(|refusal| {
            self.report.mend(entity.id(), &refusal, LEFT_OUT);
            None
        });
        let given = given.unwrap_or_default();
        let counterclockwise = is_counterclockwise(&given).unwrap_or(outer);
        let images = model_parameters(given, link.parameters);
        let curves = match curves {
            Some(curves) => curves,
            None => {
                let curves = self.surface_curves(entity, link, &images)?;
                self.report.repairs.push(entity.id(), LIFTED);
                curves
            }
        };
        let segments = BoundarySegment::zip(curves, images);
        self.bound(entity, link.index, segments, counterclockwise != outer, outer)
    }

    /// Curves in the parameters of a surface in the file.
    pub(super) fn curves_in_parameters(
        &mut self,
        entity: IgesEntity<'_>,
    ) -> Result<Vec<Curve<DVec2>>, Refusal> {
        let segments = self.segments(entity, DMat4::IDENTITY, MAX_DEPTH)?;
        let flat = segments.iter().map(|segment| segment.curve.mapped(|p| p.truncate(), DVec2::ZERO));
        flat.collect::<Option<_>>().ok_or_else(|| entity.refuse("the curve is not finite"))
    }

    /// `TYPE, SPTR, N, BDPT...`: a surface within boundaries.
    pub(super) fn bounded_surface(&mut self, entity: IgesEntity<'a>) -> Result<usize, Refusal> {
        let link = self.surface(entity.reference(2)?)?;
        let count = entity.list_length(3, 4, 1)?;
        let mut bounds = Vec::new();
        for i in 0..count {
            let boundary = entity.reference(4 + i)?;
            bounds.push(self.boundary(boundary, &link, i == 0)?);
        }
        self.add_face(entity, &link, bounds, 3 + count)
    }

    /// `TYPE, PREF, SPTR, N, (CRVPT, SENSE, K, PSCPT...)...`: curves in space with their images in parameters.
    fn boundary(
        &mut self,
        entity: IgesEntity<'a>,
        link: &SurfaceLink,
        outer: bool,
    ) -> Result<FaceBound, Refusal> {
        if entity.kind() != 141 {
            return Err(entity.refuse_kind("boundary of a bounded surface"));
        }
        entity.optional_reference(3)?;
        let mut segments = Vec::new();
        let mut loop_in_parameters: Option<Vec<Curve<DVec2>>> = Some(Vec::new());
        let mut lifted = false;
        let mut at = 5;
        for _ in 0..entity.list_length(4, 5, 3)? {
            let curve = entity.optional_reference(at)?;
            // The images run as the boundary, the curve in space may not.
            let reversed = curve.is_some() && entity.count(at + 1)? == 2;
            let given = entity.list_length(at + 2, at + 3, 1)?;
            let curves = curve.map(|curve| self.segments(curve, self.metres(), MAX_DEPTH)).transpose()?;
            let (mut parameter_curves, mut complete) = (Vec::new(), given > 0);
            for i in 0..given {
                let curve = entity.reference(at + 3 + i);
                match curve.and_then(|curve| self.curves_in_parameters(curve)) {
                    Ok(curves) => parameter_curves.extend(curves),
                    Err(refusal) => {
                        self.report.mend(entity.id(), &refusal, LEFT_OUT);
                        complete = false;
                    }
                }
            }
            if !complete {
                parameter_curves.clear();
            }
            if let Some(whole) = loop_in_parameters.as_mut().filter(|_| complete) {
                whole.extend(parameter_curves.iter().cloned());
            } else {
                loop_in_parameters = None;
            }
            let mut parameter_curves = model_parameters(parameter_curves, link.parameters);
            let mut curves = match curves {
                Some(curves) => curves,
                None => {
                    lifted = true;
                    self.surface_curves(entity, link, &parameter_curves)?
                }
            };
            // Only single ones correspond then.
            if reversed && (curves.len() > 1 || parameter_curves.len() > 1) {
                parameter_curves.clear();
            }
            if reversed {
                curves.reverse();
            }
            let part = BoundarySegment::zip(curves, parameter_curves).into_iter();
            segments.extend(part.map(|segment| BoundarySegment { reversed, ..segment }));
            at += 3 + given;
        }
        if lifted {
            self.report.repairs.push(entity.id(), LIFTED);
        }
        let counterclockwise =
            loop_in_parameters.and_then(|curves| is_counterclockwise(&curves)).unwrap_or(outer);
        self.bound(entity, link.index, segments, counterclockwise != outer, outer)
    }

    /// Notes that a face is hidden, unless it has been read.
    pub(super) fn hide_face(&mut self, index: usize, entity: EntityId) {
        if self.faces.contains_key(&index) {
            return;
        }
        self.faces.insert(index, IgesFaceState::Hidden);
        self.report.omissions.push(entity, "the file hides it");
    }
}

/// The images of curves in the parameters of the model; none where the surface has no parameters in the standard.
pub(super) fn model_parameters(curves: Vec<Curve<DVec2>>, map: Option<DAffine2>) -> Vec<Curve<DVec2>> {
    let Some(map) = map else { return Vec::new() };
    let image = |curve: &Curve<DVec2>| curve.mapped(|p| map.matrix2 * p, map.translation);
    curves.iter().map(image).collect::<Option<_>>().unwrap_or_default()
}
