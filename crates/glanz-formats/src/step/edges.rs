//! Vertices and edges.

use glanz_brep::model::{Curve, Edge, OrientedEdge, ParameterCurve};
use glanz_math::{DVec2, DVec3};

use super::curves::is_surface_curve;
use super::geometry::{CurveUnits, ENTITY_COST, GeometryReader, MAX_DEPTH};
use super::lowering::StepReader;
use super::part21::{Entity, EntityAttributes, Keyword, Refusal};
use super::surfaces::curve_units;

impl<'a> StepReader<'a> {
    /// The index of a vertex.
    pub(super) fn vertex(&mut self, entity: Entity<'a>, units: usize) -> Result<usize, Refusal> {
        if let Some(known) = self.vertices.get(&(entity.id(), units)) {
            return known.clone();
        }
        let vertex = self.lower_vertex(entity, units);
        self.vertices.insert((entity.id(), units), vertex.clone());
        vertex
    }

    fn lower_vertex(&mut self, entity: Entity<'a>, units: usize) -> Result<usize, Refusal> {
        if entity.keyword() != Keyword::VertexPoint {
            return Err(entity.refuse_type("vertex"));
        }
        self.geometry.spend(entity.id(), 1)?;
        let point = GeometryReader::located(entity.simple().reference(1)?, curve_units(self.units(units)))?;
        self.model.vertices.push(point);
        Ok(self.model.vertices.len() - 1)
    }

    /// An edge with the sense in which a loop runs through it; edges may be turned several times.
    pub(super) fn oriented_edge(
        &mut self,
        entity: Entity<'a>,
        units: usize,
    ) -> Result<OrientedEdge, Refusal> {
        let (mut entity, mut forward) = (entity, true);
        for _ in 0..MAX_DEPTH {
            if entity.keyword() != Keyword::OrientedEdge {
                return Ok(OrientedEdge { edge: self.edge(entity, units)?, forward });
            }
            let attributes = entity.simple();
            forward ^= !attributes.boolean(4)?;
            entity = attributes.reference(3)?;
        }
        Err(entity.refuse("oriented edges refer to one another"))
    }

    fn edge(&mut self, entity: Entity<'a>, units: usize) -> Result<usize, Refusal> {
        if let Some(known) = self.edges.get(&(entity.id(), units)) {
            return known.clone();
        }
        let edge = self.lower_edge(entity, units);
        self.edges.insert((entity.id(), units), edge.clone());
        edge
    }

    /// `EDGE_CURVE(name, start, end, curve, sense)`, or `EDGE(name, start, end)`.
    fn lower_edge(&mut self, entity: Entity<'a>, units: usize) -> Result<usize, Refusal> {
        self.geometry.spend(entity.id(), ENTITY_COST)?;
        let parts = [Keyword::RepresentationItem, Keyword::Edge, Keyword::EdgeCurve];
        let attributes = entity.attributes(&parts);
        let (mut curve, mut same_sense, mut parameter_curves) = (None, true, Vec::new());
        if entity.is(Keyword::EdgeCurve) {
            let geometry = attributes.reference(3)?;
            same_sense = attributes.boolean(4)?;
            curve =
                Some(self.geometry.curve::<DVec3>(geometry, curve_units(self.units(units)), MAX_DEPTH)?);
            parameter_curves = self.parameter_curves(geometry, units);
        } else if entity.keyword() != Keyword::Edge {
            return Err(entity.refuse_type("edge"));
        }
        let [start, end] =
            [1, 2].map(|i| attributes.reference(i).and_then(|vertex| self.vertex(vertex, units)));
        let edge =
            Edge { start: start?, end: end?, curve, same_sense, parameter_curves, entity: entity.id() };
        self.model.edges.push(edge);
        Ok(self.model.edges.len() - 1)
    }

    /// The curves in the parameters of surfaces that belong to a curve in space. Those that cannot be read are left out.
    pub(super) fn parameter_curves(&mut self, curve: Entity<'a>, units: usize) -> Vec<ParameterCurve> {
        if !curve.kinds().any(is_surface_curve) {
            return Vec::new();
        }
        let attributes = curve.attributes(&[Keyword::RepresentationItem, Keyword::SurfaceCurve]);
        let mut curves = Vec::new();
        for at in attributes.list(2).into_iter().flatten() {
            match self.parameter_curve(&attributes, at, units) {
                Ok(curve) => curves.extend(curve),
                Err(refusal) => self.mend(curve.id(), &refusal, "the parameter curve is left out"),
            }
        }
        curves
    }

    /// `PCURVE(name, surface, DEFINITIONAL_REPRESENTATION(name, (curve), context))`; `None` for a surface without a curve.
    fn parameter_curve(
        &mut self,
        attributes: &EntityAttributes<'a>,
        at: u32,
        units: usize,
    ) -> Result<Option<ParameterCurve>, Refusal> {
        let entity = attributes.reference_at(at)?;
        if !entity.is(Keyword::Pcurve) {
            return Ok(None);
        }
        let attributes = entity.attributes(&[Keyword::RepresentationItem, Keyword::Pcurve]);
        let (surface, [u, v]) = self.surface(attributes.reference(1)?, units)?;
        let representation = attributes.reference(2)?;
        let mut items = representation.simple().references(1)?;
        let item = items.next().ok_or_else(|| representation.refuse("there is no curve"))??;
        let curve_units = CurveUnits { coordinates: DVec3::new(u, v, 0.0), angle: self.units(units).angle };
        let curve: Curve<DVec2> = self.geometry.curve(item, curve_units, MAX_DEPTH)?;
        Ok(Some(ParameterCurve { surface, curve }))
    }
}
