//! Surfaces bounded by curves, which are faces without topology.

use glanz_brep::model::{BoundaryLoop, Edge, FaceBound, OrientedEdge};
use glanz_math::DVec3;

use super::geometry::{ENTITY_COST, MAX_DEPTH};
use super::lowering::StepReader;
use super::part21::{Entity, Keyword, Refusal};
use super::surfaces::curve_units;

impl<'a> StepReader<'a> {
    /// `CURVE_BOUNDED_SURFACE(name, surface, boundaries, implicit_outer)` as a face.
    pub(super) fn bounded_surface(&mut self, entity: Entity<'a>, units: usize) -> Result<usize, Refusal> {
        self.geometry.spend(entity.id(), ENTITY_COST)?;
        let attributes = entity.simple();
        let (surface, _) = self.surface(attributes.reference(1)?, units)?;
        let mut bounds = Vec::new();
        for boundary in attributes.references(2)? {
            bounds.push(self.boundary_curve(boundary?, units)?);
        }
        let has_border = if attributes.is_missing(3) {
            let reason = "whether its border bounds it is not given; it does where no curve does";
            self.report.repairs.push(entity.id(), reason);
            bounds.is_empty()
        } else {
            attributes.boolean(3)?
        };
        if has_border {
            bounds.push(FaceBound { boundary: BoundaryLoop::Border, outer: true, entity: entity.id() });
        }
        Ok(self.add_set_face(entity, surface, bounds))
    }

    /// `BOUNDARY_CURVE(name, segments, self_intersect)`; its vertices are the starts of its segments.
    fn boundary_curve(&mut self, entity: Entity<'a>, units: usize) -> Result<FaceBound, Refusal> {
        if !matches!(
            entity.keyword(),
            Keyword::BoundaryCurve | Keyword::OuterBoundaryCurve | Keyword::CompositeCurveOnSurface
        ) {
            return Err(entity.refuse_type("boundary of a surface"));
        }
        let segments: Vec<Entity<'a>> = entity.simple().references(1)?.collect::<Result<_, _>>()?;
        let (first, count) = (self.model.vertices.len(), segments.len());
        let mut edges = Vec::with_capacity(count);
        for (i, segment) in segments.into_iter().enumerate() {
            let (edge, forward, start) = self.boundary_segment(segment, units)?;
            let [from, to] = [first + i, first + (i + 1) % count];
            edges.push((
                if forward {
                    Edge { start: from, end: to, ..edge }
                } else {
                    Edge { start: to, end: from, ..edge }
                },
                forward,
                start,
            ));
        }
        let mut oriented = Vec::with_capacity(count);
        for (edge, forward, start) in edges {
            self.model.vertices.push(start);
            oriented.push(OrientedEdge { edge: self.model.edges.len(), forward });
            self.model.edges.push(edge);
        }
        let outer = entity.keyword() == Keyword::OuterBoundaryCurve;
        if oriented.is_empty() {
            return Err(entity.refuse("there are no segments"));
        }
        Ok(FaceBound { boundary: BoundaryLoop::Edges(oriented), outer, entity: entity.id() })
    }

    /// `COMPOSITE_CURVE_SEGMENT(transition, sense, curve)` as an edge without vertices, its sense, and the point where it starts in that sense.
    fn boundary_segment(&mut self, entity: Entity<'a>, units: usize) -> Result<(Edge, bool, DVec3), Refusal> {
        self.geometry.spend(entity.id(), ENTITY_COST)?;
        let attributes = entity.attributes(&[Keyword::CompositeCurveSegment]);
        let (forward, parent) = (attributes.boolean(1)?, attributes.reference(2)?);
        let curve = self.geometry.curve::<DVec3>(parent, curve_units(self.units(units)), MAX_DEPTH)?;
        let [start, end] = curve.domain();
        if !(start.is_finite() && end.is_finite()) {
            return Err(parent.refuse("the segment of a boundary has no ends"));
        }
        let point = curve.point(if forward { start } else { end });
        let parameter_curves = self.parameter_curves(parent, units);
        let edge = Edge {
            start: 0,
            end: 0,
            curve: Some(curve),
            same_sense: true,
            parameter_curves,
            entity: entity.id(),
        };
        Ok((edge, forward, point))
    }
}
