//! Faces with their surfaces and boundaries.

use glanz_brep::model::{BoundaryLoop, Face, FaceBound, FaceSurface, OrientedEdge, Placement, SurfaceEntry};

use super::geometry::{ENTITY_COST, MAX_DEPTH};
use super::hidden::HIDDEN;
use super::lowering::{StepReader, is_face};
use super::part21::{Entity, Keyword, Refusal};
use super::surfaces::{ScaledSurface, curve_units};

impl<'a> StepReader<'a> {
    /// The index of a surface, and the factors from parameters of the file to its own.
    pub(super) fn surface(&mut self, entity: Entity<'a>, units: usize) -> Result<(usize, [f64; 2]), Refusal> {
        if let Some(known) = self.surfaces.get(&(entity.id(), units)) {
            return known.clone();
        }
        let surface = self.geometry.surface(entity, self.units(units), MAX_DEPTH);
        let surface =
            surface.map(|ScaledSurface { surface, scale }| (self.add_surface(surface, entity), scale));
        self.surfaces.insert((entity.id(), units), surface.clone());
        surface
    }

    pub(super) fn add_surface(&mut self, surface: FaceSurface, entity: Entity<'a>) -> usize {
        self.model.surfaces.push(SurfaceEntry { surface, entity: entity.id() });
        self.model.surfaces.len() - 1
    }

    /// The index of a face, with whether it is turned; `None` if the file hides it or it cannot be read, which is reported.
    pub(super) fn oriented_face(&mut self, entity: Entity<'a>, units: usize) -> Option<(usize, bool)> {
        match base_face(entity) {
            Ok((face, _)) if self.styles.is_hidden(face.id()) || self.styles.is_hidden(entity.id()) => {
                if self.hidden_items.insert(face.id()) {
                    self.report.omissions.push(face.id(), HIDDEN);
                }
                None
            }
            Ok((face, turned)) => self.face(face, units).map(|face| (face, turned)),
            Err(refusal) => {
                self.omit(entity.id(), &refusal);
                None
            }
        }
    }

    fn face(&mut self, entity: Entity<'a>, units: usize) -> Option<usize> {
        if let Some(known) = self.faces.get(&(entity.id(), units)) {
            return known.as_ref().ok().copied();
        }
        let face = self.lower_face(entity, units);
        if let Err(refusal) = &face {
            self.omit(entity.id(), refusal);
        }
        self.faces.insert((entity.id(), units), face.clone());
        face.ok()
    }

    /// `ADVANCED_FACE(name, bounds, surface, sense)`, or `FACE(name, bounds)` between straight edges.
    fn lower_face(&mut self, entity: Entity<'a>, units: usize) -> Result<usize, Refusal> {
        let parts = [Keyword::RepresentationItem, Keyword::Face, Keyword::FaceSurface];
        let attributes = entity.attributes(&parts);
        let name = attributes.text(0);
        self.geometry.spend(entity.id(), ENTITY_COST + name.len())?;
        let mut bounds = Vec::new();
        for bound in attributes.references(1)? {
            bounds.push(self.bound(bound?, units)?);
        }
        let (surface, same_sense) = if entity.keyword() == Keyword::Face {
            (self.plane_of(entity, &bounds)?, true)
        } else {
            let same_sense = attributes.boolean(3)?;
            (self.surface(attributes.reference(2)?, units)?.0, same_sense)
        };
        self.model.faces.push(Face {
            surface,
            same_sense,
            bounds,
            name,
            style: self.styles.color(entity.id()),
            layer: self.styles.layer(entity.id()),
            entity: entity.id(),
        });
        Ok(self.model.faces.len() - 1)
    }

    /// The plane of a face that has none: that of its largest polygon.
    fn plane_of(&mut self, entity: Entity<'a>, bounds: &[FaceBound]) -> Result<usize, Refusal> {
        let polygons = bounds.iter().filter_map(|bound| self.model.polygon(&bound.boundary));
        let plane = Placement::of_polygons(&polygons.collect::<Vec<_>>());
        let plane = plane
            .ok_or_else(|| entity.refuse("the face has neither a surface nor a polygon with an area"))?;
        Ok(self.add_surface(FaceSurface::Plane(plane), entity))
    }

    /// `FACE_BOUND(name, loop, orientation)`.
    fn bound(&mut self, entity: Entity<'a>, units: usize) -> Result<FaceBound, Refusal> {
        if !matches!(entity.keyword(), Keyword::FaceBound | Keyword::FaceOuterBound) {
            return Err(entity.refuse_type("boundary of a face"));
        }
        let attributes = entity.simple();
        let mut boundary = self.boundary_loop(attributes.reference(1)?, units)?;
        if !attributes.boolean(2)? {
            match &mut boundary {
                BoundaryLoop::Edges(edges) => {
                    edges.reverse();
                    edges.iter_mut().for_each(|edge| edge.forward ^= true);
                }
                BoundaryLoop::Vertex(_) | BoundaryLoop::Border => {}
            }
        }
        Ok(FaceBound { boundary, outer: entity.keyword() == Keyword::FaceOuterBound, entity: entity.id() })
    }

    fn boundary_loop(&mut self, entity: Entity<'a>, units: usize) -> Result<BoundaryLoop, Refusal> {
        let parts = [Keyword::RepresentationItem, Keyword::EdgeLoop, Keyword::PolyLoop, Keyword::VertexLoop];
        let attributes = entity.attributes(&parts);
        if entity.is(Keyword::EdgeLoop) {
            self.geometry.spend_items(entity.id(), attributes.list(1)?, 1)?;
            let edges: Vec<OrientedEdge> = attributes
                .references(1)?
                .map(|edge| self.oriented_edge(edge?, units))
                .collect::<Result<_, _>>()?;
            return if edges.is_empty() {
                Err(entity.refuse("the loop has no edges"))
            } else {
                Ok(BoundaryLoop::Edges(edges))
            };
        }
        if entity.is(Keyword::PolyLoop) {
            let corners = self.geometry.points(entity, curve_units(self.units(units)))?;
            return Ok(BoundaryLoop::Edges(self.polygon_edges(&corners, entity.id())?));
        }
        if entity.is(Keyword::VertexLoop) {
            return Ok(BoundaryLoop::Vertex(self.vertex(attributes.reference(1)?, units)?));
        }
        Err(entity.refuse_type("loop"))
    }
}

/// The face behind `ORIENTED_FACE(name, *, face, orientation)`, and whether it is turned.
pub(super) fn base_face(entity: Entity<'_>) -> Result<(Entity<'_>, bool), Refusal> {
    let (mut entity, mut turned) = (entity, false);
    for _ in 0..MAX_DEPTH {
        if is_face(entity) {
            return Ok((entity, turned));
        }
        if entity.keyword() != Keyword::OrientedFace {
            return Err(entity.refuse_type("face"));
        }
        let attributes = entity.simple();
        turned ^= !attributes.boolean(3)?;
        entity = attributes.reference(2)?;
    }
    Err(entity.refuse("oriented faces refer to one another"))
}
