//! Solids and shells of faces that share their edges.

use glanz_brep::model::{Body, BoundaryLoop, Curve, Edge, FaceBound, OrientedEdge, ParameterCurve, Shell};
use glanz_math::DVec3;

use super::entity::IgesEntity;
use super::lowering::{IgesReader, MAX_DEPTH};
use super::surface_curves::LIFTED;
use super::surfaces::SurfaceLink;
use super::trimmed::{LEFT_OUT, model_parameters};
use crate::cad::{ENTITY_COST, Refusal};

impl<'a> IgesReader<'a> {
    /// `SHELL, SOF, N, (VOID, VOF)...`: a solid.
    pub(super) fn solid(&mut self, entity: IgesEntity<'a>) -> Result<Body, Refusal> {
        let voids = entity.list_length(3, 4, 2)?;
        let mut shells = vec![(entity.reference(1)?, entity.flag(2)?)];
        for i in 0..voids {
            shells.push((entity.reference(4 + 2 * i)?, entity.flag(5 + 2 * i)?));
        }
        let mut body = Body {
            name: entity.name(3 + 2 * voids),
            solid: true,
            style: entity.color(),
            layer: entity.layer(),
            entity: entity.id(),
            ..Body::default()
        };
        for (shell, forward) in shells {
            match self.shell(shell) {
                Ok(mut shell) => {
                    shell.faces.iter_mut().for_each(|(_, reversed)| *reversed ^= !forward);
                    body.shells.push(shell);
                }
                Err(refusal) => {
                    // Without one of its shells it bounds no volume.
                    body.solid = false;
                    self.report.omit(shell.id(), &refusal);
                }
            }
        }
        Ok(body)
    }

    /// A shell as a body.
    pub(super) fn shell_body(&mut self, entity: IgesEntity<'a>) -> Result<Body, Refusal> {
        let shell = self.shell(entity)?;
        let own = 1 + 2 * entity.count(1)?;
        let (style, layer) = (entity.color(), entity.layer());
        Ok(Body {
            name: entity.name(own),
            shells: vec![shell],
            solid: false,
            style,
            layer,
            entity: entity.id(),
        })
    }

    /// `N, (FACE, OF)...`; form 1 is closed.
    fn shell(&mut self, entity: IgesEntity<'a>) -> Result<Shell, Refusal> {
        if entity.kind() != 514 {
            return Err(entity.refuse_kind("shell"));
        }
        self.spend(entity)?;
        let count = entity.list_length(1, 2, 2)?;
        let mut faces = Vec::with_capacity(count);
        for i in 0..count {
            let (face, forward) = (entity.reference(2 + 2 * i)?, entity.flag(3 + 2 * i)?);
            if face.entry.hidden {
                self.hide_face(face.index, face.id());
                continue;
            }
            let face = self.face_of(face, |reader| reader.topological_face(face));
            faces.extend(face.map(|face| (face, !forward)));
        }
        let closed = entity.form() == 1 && faces.len() == count;
        Ok(Shell { faces, closed, entity: entity.id() })
    }

    /// `SURF, N, OF, LOOP...`: a face, the first loop of which may be the outer one.
    pub(super) fn topological_face(&mut self, entity: IgesEntity<'a>) -> Result<usize, Refusal> {
        if entity.kind() != 510 {
            return Err(entity.refuse_kind("face of a shell"));
        }
        let link = self.surface(entity.reference(1)?)?;
        let (count, has_outer) = (entity.list_length(2, 4, 1)?, entity.flag(3)?);
        let mut bounds = Vec::with_capacity(count);
        for i in 0..count {
            bounds.push(self.edge_loop(entity.reference(4 + i)?, &link, has_outer && i == 0)?);
        }
        self.add_face(entity, &link, bounds, 3 + count)
    }

    /// `N, (TYPE, EDGE, NDX, OF, K, (ISOP, CURV)...)...`: edges, and vertices where a boundary is a point.
    fn edge_loop(
        &mut self,
        entity: IgesEntity<'a>,
        link: &SurfaceLink,
        outer: bool,
    ) -> Result<FaceBound, Refusal> {
        if entity.kind() != 508 {
            return Err(entity.refuse_kind("loop"));
        }
        self.spend(entity)?;
        let (mut oriented, mut point) = (Vec::new(), None);
        let mut at = 2;
        for _ in 0..entity.list_length(1, 2, 5)? {
            let (is_vertex, list) = (entity.flag(at)?, entity.reference(at + 1)?);
            let (number, forward) = (entity.count(at + 2)?, entity.flag(at + 3)?);
            let curves = entity.list_length(at + 4, at + 5, 2)?;
            let mut parameter_curves = Vec::new();
            for i in 0..curves {
                match entity.optional_reference(at + 6 + 2 * i) {
                    Ok(curve) => parameter_curves.extend(curve),
                    Err(refusal) => self.report.mend(entity.id(), &refusal, LEFT_OUT),
                }
            }
            if is_vertex {
                point = Some(self.vertex(list, number)?);
            } else {
                let edge = self.edge(list, number)?;
                oriented.push(OrientedEdge { edge, forward });
                if self.model.edges.get(edge).is_some_and(|edge| edge.curve.is_none()) {
                    let all =
                        if parameter_curves.len() == curves { parameter_curves.as_slice() } else { &[] };
                    self.lift_edge(list, link, all, (edge, forward))?;
                }
                // Of several, each is only a piece of the edge, and they are not needed.
                if let (1, Some(curve)) = (curves, parameter_curves.pop()) {
                    self.add_parameter_curve(entity, curve, edge, link);
                }
            }
            at += 5 + 2 * curves;
        }
        let boundary = match (oriented.is_empty(), point) {
            (true, Some(vertex)) => BoundaryLoop::Vertex(vertex),
            (true, None) => return Err(entity.refuse("the loop has no edges")),
            (false, _) => BoundaryLoop::Edges(oriented),
        };
        Ok(FaceBound { boundary, outer, entity: entity.id() })
    }

    /// Adds the curve of an edge in the parameters of a surface; one that cannot be read is left out.
    fn add_parameter_curve(
        &mut self,
        entity: IgesEntity<'a>,
        curve: IgesEntity<'a>,
        edge: usize,
        link: &SurfaceLink,
    ) {
        match self.curves_in_parameters(curve) {
            Ok(curves) => {
                let curves = model_parameters(curves, link.parameters);
                if let (Ok([curve]), Some(edge)) =
                    (<[_; 1]>::try_from(curves), self.model.edges.get_mut(edge))
                {
                    edge.parameter_curves.push(ParameterCurve { surface: link.index, curve });
                }
            }
            Err(refusal) => self.report.mend(entity.id(), &refusal, LEFT_OUT),
        }
    }

    /// Gives an edge without a curve in space that of its curves in the parameters of a surface, which run as its loop.
    fn lift_edge(
        &mut self,
        list: IgesEntity<'a>,
        link: &SurfaceLink,
        parameter_curves: &[IgesEntity<'a>],
        (index, forward): (usize, bool),
    ) -> Result<(), Refusal> {
        let mut images = Vec::new();
        for curve in parameter_curves {
            images.extend(self.curves_in_parameters(*curve)?);
        }
        let segments = self.surface_curves(list, link, &model_parameters(images, link.parameters))?;
        let mut curves = segments.into_iter().map(|segment| (segment.curve, true));
        let curve = match (curves.next(), curves.len()) {
            (Some((only, _)), 0) => only,
            (first, _) => Curve::Composite(first.into_iter().chain(curves).collect()),
        };
        let Some(edge) = self.model.edges.get_mut(index) else { return Ok(()) };
        let vertex = |index: usize| self.model.vertices.get(index).copied().unwrap_or(DVec3::NAN);
        let [start, end] = [edge.start, edge.end].map(vertex);
        let [first, last] = curve.domain().map(|t| curve.point(t));
        let runs_back =
            first.distance(end) + last.distance(start) < first.distance(start) + last.distance(end);
        edge.same_sense = if edge.start == edge.end { forward } else { !runs_back };
        edge.curve = Some(curve);
        self.report.repairs.push(list.id(), LIFTED);
        Ok(())
    }

    /// The edge of a list, counted from 1: `N, (CURV, SVP, SV, TVP, TV)...`.
    fn edge(&mut self, list: IgesEntity<'a>, number: usize) -> Result<usize, Refusal> {
        if let Some(known) = self.edges.get(&(list.index, number)) {
            return known.clone();
        }
        let edge = self.lower_edge(list, number);
        self.edges.insert((list.index, number), edge.clone());
        edge
    }

    fn lower_edge(&mut self, list: IgesEntity<'a>, number: usize) -> Result<usize, Refusal> {
        let at = item(list, 504, number, 5)?;
        self.budget.spend(list.id(), ENTITY_COST)?;
        let curve = list.optional_reference(at)?;
        let start = self.vertex(list.reference(at + 1)?, list.count(at + 2)?)?;
        let end = self.vertex(list.reference(at + 3)?, list.count(at + 4)?)?;
        let entity = curve.map_or(list.id(), |curve| curve.id());
        let curve = curve.map(|curve| self.curve(curve, self.metres(), MAX_DEPTH)).transpose()?;
        self.model.edges.push(Edge {
            start,
            end,
            curve,
            same_sense: true,
            parameter_curves: Vec::new(),
            entity,
        });
        Ok(self.model.edges.len() - 1)
    }

    /// The vertex of a list, counted from 1: `N, (X, Y, Z)...`.
    fn vertex(&mut self, list: IgesEntity<'a>, number: usize) -> Result<usize, Refusal> {
        if let Some(known) = self.vertices.get(&(list.index, number)) {
            return known.clone();
        }
        let vertex = self.lower_vertex(list, number);
        self.vertices.insert((list.index, number), vertex.clone());
        vertex
    }

    fn lower_vertex(&mut self, list: IgesEntity<'a>, number: usize) -> Result<usize, Refusal> {
        let at = item(list, 502, number, 3)?;
        let [x, y, z] = list.numbers(at)?;
        let point = (self.metres() * list.matrix()?).transform_point3(DVec3::new(x, y, z));
        if !point.is_finite() {
            return Err(list.refuse(format!("vertex {number} is not finite")));
        }
        self.model.vertices.push(point);
        Ok(self.model.vertices.len() - 1)
    }
}

/// The first parameter of an item of a list of vertices or edges.
fn item(list: IgesEntity<'_>, kind: u32, number: usize, size: usize) -> Result<usize, Refusal> {
    if list.kind() != kind {
        return Err(list.refuse_kind(if kind == 502 { "list of vertices" } else { "list of edges" }));
    }
    let count = list.list_length(1, 2, size)?;
    match number.checked_sub(1).filter(|i| *i < count) {
        Some(i) => Ok(2 + size * i),
        None => Err(list.refuse(format!("item {number} of {count} does not exist"))),
    }
}
