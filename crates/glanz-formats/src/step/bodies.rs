//! Solids, shells and sets of faces.

use glanz_brep::model::{Body, Face, FaceBound, FaceSurface, Shell};

use super::geometry::{ENTITY_COST, MAX_DEPTH};
use super::hidden::HIDDEN;
use super::lowering::{StepReader, is_face};
use super::part21::{Entity, Keyword, Refusal};
use super::polygons::PolygonEdges;

/// The kinds of shape items.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum BodyKind {
    Solid,
    /// A list of shells.
    Shells,
    /// A shell by itself.
    Shell,
    /// A face by itself.
    Face,
    /// Points, curves and surfaces.
    Set,
}

/// The kind of a shape item; `None` of others.
pub(super) fn body_kind(entity: Entity<'_>) -> Option<BodyKind> {
    if is_face(entity) || entity.keyword() == Keyword::OrientedFace {
        return Some(BodyKind::Face);
    }
    entity.kinds().find_map(|kind| match kind {
        Keyword::ManifoldSolidBrep | Keyword::FacetedBrep | Keyword::BrepWithVoids => Some(BodyKind::Solid),
        Keyword::ShellBasedSurfaceModel | Keyword::FaceBasedSurfaceModel => Some(BodyKind::Shells),
        Keyword::OpenShell
        | Keyword::ClosedShell
        | Keyword::ConnectedFaceSet
        | Keyword::OrientedOpenShell
        | Keyword::OrientedClosedShell => Some(BodyKind::Shell),
        Keyword::GeometricSet => Some(BodyKind::Set),
        _ => None,
    })
}

/// Whether an entity is a solid, a shell, or another item with faces.
pub(super) fn is_body(entity: Entity<'_>) -> bool {
    body_kind(entity).is_some()
}

/// The shells of a body, the outer one of a solid first.
pub(super) fn shells_of<'a>(entity: Entity<'a>, kind: BodyKind) -> Result<Vec<Entity<'a>>, Refusal> {
    let parts = [Keyword::RepresentationItem, Keyword::ManifoldSolidBrep, Keyword::BrepWithVoids];
    let attributes = entity.attributes(&parts);
    match kind {
        BodyKind::Solid => {
            let mut shells = vec![attributes.reference(1)?];
            if entity.is(Keyword::BrepWithVoids) {
                for void in attributes.references(2)? {
                    shells.push(void?);
                }
            }
            Ok(shells)
        }
        BodyKind::Shells => entity.simple().references(1)?.collect(),
        BodyKind::Shell => Ok(vec![entity]),
        BodyKind::Face | BodyKind::Set => Ok(Vec::new()),
    }
}

/// A shell behind its orientations, and whether it is turned.
pub(super) fn base_shell(entity: Entity<'_>) -> Result<(Entity<'_>, bool), Refusal> {
    let (mut entity, mut turned) = (entity, false);
    for _ in 0..MAX_DEPTH {
        match entity.keyword() {
            Keyword::OpenShell | Keyword::ClosedShell | Keyword::ConnectedFaceSet => {
                return Ok((entity, turned));
            }
            Keyword::OrientedOpenShell | Keyword::OrientedClosedShell => {
                let attributes = entity.simple();
                turned ^= !attributes.boolean(3)?;
                entity = attributes.reference(2)?;
            }
            _ => return Err(entity.refuse_type("shell")),
        }
    }
    Err(entity.refuse("oriented shells refer to one another"))
}

impl<'a> StepReader<'a> {
    /// A body; `None` if it is hidden, or nothing of it can be read, which is reported.
    pub(super) fn body(&mut self, entity: Entity<'a>, units: usize) -> Option<Body> {
        let kind = body_kind(entity)?;
        if self.hides(entity) {
            return None;
        }
        // Parts have frames of their own, in which equal coordinates are no common corner.
        self.polygons = PolygonEdges::default();
        let mut body = Body {
            name: entity.attributes(&[Keyword::RepresentationItem]).text(0),
            solid: kind == BodyKind::Solid,
            style: self.styles.color(entity.id()),
            layer: self.styles.layer(entity.id()),
            entity: entity.id(),
            ..Body::default()
        };
        match kind {
            BodyKind::Face => {
                let faces = self.oriented_face(entity, units).into_iter().collect();
                body.shells.push(Shell { faces, closed: false, entity: entity.id() });
            }
            BodyKind::Set => body.shells.push(self.surface_set(entity, units)),
            _ => match shells_of(entity, kind) {
                Ok(shells) => {
                    let count = shells.len();
                    for shell in shells {
                        if self.hides(shell) {
                            continue;
                        }
                        match self.shell(shell, units) {
                            Ok(shell) => body.shells.push(shell),
                            Err(refusal) => self.omit(shell.id(), &refusal),
                        }
                    }
                    // Without one of its shells it bounds another volume.
                    body.solid &= body.shells.len() == count;
                }
                Err(refusal) => self.omit(entity.id(), &refusal),
            },
        }
        body.shells.retain(|shell| !shell.faces.is_empty());
        (!body.shells.is_empty()).then_some(body)
    }

    fn shell(&mut self, entity: Entity<'a>, units: usize) -> Result<Shell, Refusal> {
        let (base, turned) = base_shell(entity)?;
        let attributes = base.simple();
        let count = self.geometry.spend_items(entity.id(), attributes.list(1)?, ENTITY_COST)?;
        let mut faces = Vec::with_capacity(count);
        for face in attributes.references(1)? {
            match face {
                Ok(face) => faces.extend(self.oriented_face(face, units)),
                Err(refusal) => self.omit(base.id(), &refusal),
            }
        }
        faces.iter_mut().for_each(|(_, reversed)| *reversed ^= turned);
        if let Some(color) = self.styles.color(base.id()).or_else(|| self.styles.color(entity.id())) {
            for (face, _) in &faces {
                if let Some(Face { style, .. }) = self.model.faces.get_mut(*face) {
                    style.get_or_insert(color);
                }
            }
        }
        let closed = base.keyword() == Keyword::ClosedShell && faces.len() == count;
        Ok(Shell { faces, closed, entity: base.id() })
    }

    /// The bounded surfaces of a `GEOMETRIC_SET` as faces.
    fn surface_set(&mut self, entity: Entity<'a>, units: usize) -> Shell {
        let mut shell = Shell { faces: Vec::new(), closed: false, entity: entity.id() };
        let attributes = entity.simple();
        for at in attributes.list(1).into_iter().flatten() {
            let face = attributes.reference_at(at).and_then(|item| self.whole_surface(item, units));
            match face {
                Ok(face) => shell.faces.push((face, false)),
                Err(refusal) => self.omit(entity.id(), &refusal),
            }
        }
        shell
    }

    /// A face that is the whole of a surface, or of the part inside of its boundary curves.
    fn whole_surface(&mut self, entity: Entity<'a>, units: usize) -> Result<usize, Refusal> {
        if self.styles.is_hidden(entity.id()) {
            return Err(entity.refuse(HIDDEN));
        }
        if entity.keyword() == Keyword::CurveBoundedSurface {
            return self.bounded_surface(entity, units);
        }
        let (surface, _) = self.surface(entity, units)?;
        let entry = self.model.surfaces.get(surface).map(|entry| &entry.surface);
        let is_bounded = matches!(
            entry,
            Some(
                FaceSurface::Spline(_)
                    | FaceSurface::Sphere { .. }
                    | FaceSurface::Torus { .. }
                    | FaceSurface::Rectangular { .. }
            )
        );
        if !is_bounded {
            return Err(entity.refuse("the surface has no boundary"));
        }
        self.geometry.spend(entity.id(), ENTITY_COST)?;
        Ok(self.add_set_face(entity, surface, Vec::new()))
    }

    /// Adds a face for a surface of a set.
    pub(super) fn add_set_face(
        &mut self,
        entity: Entity<'a>,
        surface: usize,
        bounds: Vec<FaceBound>,
    ) -> usize {
        self.model.faces.push(Face {
            surface,
            same_sense: true,
            bounds,
            name: entity.simple().text(0),
            style: self.styles.color(entity.id()),
            layer: self.styles.layer(entity.id()),
            entity: entity.id(),
        });
        self.model.faces.len() - 1
    }
}
