//! Parts: the bodies and the placed parts of products and representations.

use std::collections::{HashMap, HashSet};

use glanz_brep::model::{EntityId, Occurrence, Part};
use glanz_math::DMat4;

use super::assembly::{AssemblyIndex, MAX_ASSEMBLY_DEPTH, RelationshipEnds, product_name};
use super::bodies::is_body;
use super::geometry::ENTITY_COST;
use super::hidden::HIDDEN;
use super::lowering::StepReader;
use super::part21::{Entity, EntityAttributes, Keyword, Refusal};
use crate::cad::{PartReaches, invertible};

/// The state of the part of a product or a representation.
#[derive(Clone, Copy, Debug)]
enum PartState {
    /// It is being read; whoever needs it now is inside of it.
    Open,
    /// Its index; `None` if it is empty.
    Finished(Option<usize>),
}

/// Parts by the number of their product definition or representation.
pub(super) struct PartReader<'a, 'r> {
    pub(super) reader: &'r mut StepReader<'a>,
    pub(super) index: AssemblyIndex<'a>,
    states: HashMap<EntityId, PartState>,
    reaches: PartReaches,
    visited: HashSet<EntityId>,
    /// Hidden representations whose placed representations were hidden, too.
    pub(super) followed: HashSet<EntityId>,
}

impl<'a, 'r> PartReader<'a, 'r> {
    pub(super) fn new(reader: &'r mut StepReader<'a>) -> Self {
        let (index, refusals) = AssemblyIndex::new(&reader.lists);
        for refusal in refusals {
            reader.omit(refusal.entity, &refusal);
        }
        Self {
            reader,
            index,
            states: HashMap::new(),
            reaches: PartReaches::default(),
            visited: HashSet::new(),
            followed: HashSet::new(),
        }
    }

    /// Reads all that the file shows.
    pub(super) fn read_all(&mut self) {
        for product in std::mem::take(&mut self.reader.lists.products) {
            if self.index.is_root(product.id()) {
                let part = self.product(product, MAX_ASSEMBLY_DEPTH);
                self.add_root(product, part);
            }
        }
        let representations = std::mem::take(&mut self.reader.lists.representations);
        let shows_products = !self.reader.model.roots.is_empty();
        let maps = self.reader.lists.maps.iter().filter_map(|map| map.simple().reference(1).ok());
        let mapped: HashSet<EntityId> = maps.map(|representation| representation.id()).collect();
        for representation in representations {
            let id = representation.id();
            if self.visited.contains(&id) || self.reader.hidden_items.contains(&id) {
                continue;
            }
            if shows_products {
                if self.has_bodies(representation) {
                    let reason = "the representation belongs to no product that is shown";
                    self.reader.report.omissions.push(id, reason);
                }
            } else if !mapped.contains(&id) {
                let part = self.representation(representation, MAX_ASSEMBLY_DEPTH);
                self.add_root(representation, part);
            }
        }
        if self.reader.model.roots.is_empty() {
            self.read_bodies();
        }
        self.override_styles();
    }

    fn has_bodies(&self, representation: Entity<'a>) -> bool {
        let attributes = representation.attributes(&[Keyword::Representation]);
        attributes.references(1).into_iter().flatten().flatten().any(is_body)
    }

    fn add_root(&mut self, entity: Entity<'a>, part: Result<Option<usize>, Refusal>) {
        match part {
            Ok(Some(part)) => self.reader.model.roots.push(Occurrence {
                part,
                to_parent: DMat4::IDENTITY,
                name: String::new(),
                style: None,
                entity: entity.id(),
            }),
            Ok(None) => {}
            Err(refusal) => self.reader.omit(entity.id(), &refusal),
        }
    }

    /// Reads solids and shells of a file without any representation.
    fn read_bodies(&mut self) {
        let file = self.reader.file;
        let is_whole = |entity: &Entity<'a>| {
            use Keyword::{
                BrepWithVoids, FaceBasedSurfaceModel, FacetedBrep, ManifoldSolidBrep, ShellBasedSurfaceModel,
            };
            let whole = [
                BrepWithVoids,
                FaceBasedSurfaceModel,
                FacetedBrep,
                ManifoldSolidBrep,
                ShellBasedSurfaceModel,
            ];
            entity.kinds().any(|kind| whole.contains(&kind))
        };
        let mut wholes: Vec<Entity<'a>> = file.entities().filter(is_whole).collect();
        if wholes.is_empty() {
            let is_shell = |kind| matches!(kind, Keyword::OpenShell | Keyword::ClosedShell);
            wholes = file.entities().filter(|entity| entity.kinds().any(is_shell)).collect();
        }
        // Those in something that is hidden were counted there.
        wholes.retain(|entity| !self.reader.hidden_items.contains(&entity.id()));
        let Some(first) = wholes.first().copied() else { return };
        let units = self.reader.file_units(first.id());
        let bodies = wholes.iter().filter_map(|entity| self.reader.body(*entity, units)).collect();
        let part = self.add(Part { bodies, entity: first.id(), ..Part::default() });
        self.add_root(first, Ok(part));
    }

    /// Adds a part that is not empty.
    fn add(&mut self, part: Part) -> Option<usize> {
        if part.bodies.is_empty() && part.occurrences.is_empty() {
            return None;
        }
        self.reaches.push(&part);
        self.reader.model.parts.push(part);
        Some(self.reader.model.parts.len() - 1)
    }

    /// The part of a product definition; `None` if nothing of it is shown.
    fn product(&mut self, product: Entity<'a>, depth: usize) -> Result<Option<usize>, Refusal> {
        self.part(product, depth, |this, depth| {
            let mut part = Part { name: product_name(product), entity: product.id(), ..Part::default() };
            let mut mapped = HashSet::new();
            let group = this.index.group(product.id());
            this.add_representations(&mut part, &group, &mut mapped, depth);
            for usage in this.index.usages(product.id()) {
                match this.usage(usage, product, &mapped, depth) {
                    Ok(occurrence) => part.occurrences.extend(occurrence),
                    Err(refusal) => this.reader.omit(usage.id(), &refusal),
                }
            }
            part
        })
    }

    /// The part of a representation without a product.
    fn representation(&mut self, representation: Entity<'a>, depth: usize) -> Result<Option<usize>, Refusal> {
        if let Some(product) = self.index.owner(representation.id()) {
            return self.product(product, depth);
        }
        // Nothing is looked for once the budget is used up.
        self.reader.geometry.spend(representation.id(), 1)?;
        self.part(representation, depth, |this, depth| {
            let name = representation.attributes(&[Keyword::Representation]).text(0);
            let mut part = Part { name, entity: representation.id(), ..Part::default() };
            match this.index.linked(representation, &mut this.reader.geometry) {
                Ok(group) => this.add_representations(&mut part, &group, &mut HashSet::new(), depth),
                Err(refusal) => this.reader.omit(representation.id(), &refusal),
            }
            part
        })
    }

    /// The part of an entity, read once.
    fn part(
        &mut self,
        entity: Entity<'a>,
        depth: usize,
        read: impl FnOnce(&mut Self, usize) -> Part,
    ) -> Result<Option<usize>, Refusal> {
        match self.states.get(&entity.id()) {
            Some(PartState::Finished(part)) => return Ok(*part),
            Some(PartState::Open) => return Err(entity.refuse("it contains itself")),
            None => {}
        }
        let reason = || format!("parts are nested deeper than {MAX_ASSEMBLY_DEPTH} levels");
        let depth = depth.checked_sub(1).ok_or_else(|| entity.refuse(reason()))?;
        self.states.insert(entity.id(), PartState::Open);
        let part = read(self, depth);
        let part = self.add(part);
        self.states.insert(entity.id(), PartState::Finished(part));
        Ok(part)
    }

    /// Adds the items of representations to a part, and to `mapped` the products that they place.
    fn add_representations(
        &mut self,
        part: &mut Part,
        group: &[Entity<'a>],
        mapped: &mut HashSet<EntityId>,
        depth: usize,
    ) {
        if let Err(refusal) = self.reader.geometry.spend(part.entity, group.len()) {
            self.reader.omit(part.entity, &refusal);
            return;
        }
        let mut known = HashSet::new();
        for representation in group {
            self.visited.insert(representation.id());
            if self.reader.hides(*representation) {
                continue;
            }
            let attributes = representation.attributes(&[Keyword::Representation]);
            let first = part.bodies.len();
            for at in attributes.list(1).into_iter().flatten() {
                match attributes.reference_at(at) {
                    Ok(item) if known.insert(item.id()) => {
                        if let Err(refusal) = self.add_item(part, item, &attributes, mapped, depth) {
                            self.reader.omit(item.id(), &refusal);
                        }
                    }
                    Ok(_) => {}
                    Err(refusal) => self.reader.omit(representation.id(), &refusal),
                }
            }
            if let Some(color) = self.reader.styles.color(representation.id()) {
                for body in part.bodies.iter_mut().skip(first) {
                    body.style.get_or_insert(color);
                }
            }
            let placed = self.index.placed_in(representation.id());
            if let Err(refusal) = self.reader.geometry.spend(representation.id(), ENTITY_COST * placed.len())
            {
                self.reader.omit(representation.id(), &refusal);
                continue;
            }
            let placed = placed.to_vec();
            for relationship in placed {
                match self.placed(relationship, depth) {
                    Ok(occurrence) => part.occurrences.extend(occurrence),
                    Err(refusal) => self.reader.omit(relationship.id(), &refusal),
                }
            }
        }
    }

    /// Adds a body or a mapped item to a part; placements are no shapes, and other items are refused.
    fn add_item(
        &mut self,
        part: &mut Part,
        item: Entity<'a>,
        representation: &EntityAttributes<'a>,
        mapped: &mut HashSet<EntityId>,
        depth: usize,
    ) -> Result<(), Refusal> {
        self.reader.geometry.spend(item.id(), 1)?;
        if is_body(item) {
            let units = self.reader.representation_units(representation);
            part.bodies.extend(self.reader.body(item, units));
            return Ok(());
        }
        if item.is(Keyword::MappedItem) {
            if self.reader.hides(item) {
                return Ok(());
            }
            part.occurrences.extend(self.mapped_item(item, representation, mapped, depth)?);
            return Ok(());
        }
        match item.keyword() {
            Keyword::Axis1Placement | Keyword::Axis2Placement2d | Keyword::Axis2Placement3d => Ok(()),
            _ => {
                Err(item
                    .refuse(format!("{} is no solid, shell or surface; it is not shown", item.type_name())))
            }
        }
    }

    /// `MAPPED_ITEM(name, REPRESENTATION_MAP(origin, representation), target)`.
    fn mapped_item(
        &mut self,
        item: Entity<'a>,
        representation: &EntityAttributes<'a>,
        mapped: &mut HashSet<EntityId>,
        depth: usize,
    ) -> Result<Option<Occurrence>, Refusal> {
        let attributes = item.attributes(&[Keyword::RepresentationItem, Keyword::MappedItem]);
        let map = attributes.reference(1)?.simple();
        let [origin, source] = [map.reference(0)?, map.reference(1)?];
        let Some(part) = self.representation(source, depth)? else { return Ok(None) };
        mapped.extend(self.index.owner(source.id()).map(|product| product.id()));
        let [inner, outer] =
            [source.attributes(&[Keyword::Representation]), *representation].map(|r| self.length_unit(&r));
        let geometry = &mut self.reader.geometry;
        let to_parent = geometry.transformation(attributes.reference(2)?, outer)?
            * geometry.inverse_transformation(origin, inner)?;
        let to_parent = invertible(item.id(), to_parent)?;
        self.reaches.check(item.id(), part, &to_parent)?;
        let style = self.reader.styles.color(item.id());
        Ok(Some(Occurrence { part, to_parent, name: attributes.text(0), style, entity: item.id() }))
    }

    fn length_unit(&mut self, representation: &EntityAttributes<'a>) -> f64 {
        let units = self.reader.representation_units(representation);
        self.reader.units(units).length
    }

    /// A representation that a relationship places in another.
    fn placed(&mut self, relationship: Entity<'a>, depth: usize) -> Result<Option<Occurrence>, Refusal> {
        let ends = RelationshipEnds::of(relationship)?;
        let Some(part) = self.representation(ends.first, depth)? else { return Ok(None) };
        let to_parent = self.relationship_matrix(ends)?;
        self.reaches.check(relationship.id(), part, &to_parent)?;
        Ok(Some(Occurrence { part, to_parent, name: String::new(), style: None, entity: relationship.id() }))
    }

    /// A product that another contains; `None` if it is empty, or if the parent has placed it by mapped items.
    fn usage(
        &mut self,
        usage: Entity<'a>,
        parent: Entity<'a>,
        mapped: &HashSet<EntityId>,
        depth: usize,
    ) -> Result<Option<Occurrence>, Refusal> {
        let attributes = usage.simple();
        let child = attributes.reference(4)?;
        let placements = self.index.placements(usage.id());
        let placement = placements.first().copied();
        if placements.len() > 1 {
            self.reader
                .report
                .repairs
                .push(usage.id(), "the usage has several placements; the first one is taken");
        }
        if placement.is_none() && mapped.contains(&child.id()) {
            return Ok(None);
        }
        if self.index.style_contexts(usage.id()).any(|context| self.reader.styles.is_hidden(context)) {
            self.hide_product(child);
            return Err(usage.refuse(HIDDEN));
        }
        let Some(part) = self.product(child, depth)? else { return Ok(None) };
        let to_parent = match placement {
            Some(placement) => {
                let ends = RelationshipEnds::of(placement)?;
                let is_parent =
                    |end: Entity<'a>| self.index.owner(end.id()).is_some_and(|p| p.id() == parent.id());
                // The first end should be the part; some writers exchange them.
                let exchanged = is_parent(ends.first) && !is_parent(ends.second);
                let matrix = self.relationship_matrix(ends)?;
                if exchanged { matrix.inverse() } else { matrix }
            }
            None => {
                self.reader.report.repairs.push(usage.id(), "the usage has no placement; none is taken");
                DMat4::IDENTITY
            }
        };
        self.reaches.check(usage.id(), part, &to_parent)?;
        let (id, name) = (attributes.text(0), attributes.text(1));
        let name = if name.is_empty() { id } else { name };
        let mut contexts = self.index.style_contexts(usage.id());
        let style = contexts.find_map(|context| self.reader.styles.color(context));
        Ok(Some(Occurrence { part, to_parent, name, style, entity: usage.id() }))
    }

    /// From the frame of the first representation to that of the second.
    fn relationship_matrix(&mut self, ends: RelationshipEnds<'a>) -> Result<DMat4, Refusal> {
        let Some(transformation) = ends.transformation else { return Ok(DMat4::IDENTITY) };
        let [first, second] =
            [ends.first, ends.second].map(|r| self.length_unit(&r.attributes(&[Keyword::Representation])));
        let geometry = &mut self.reader.geometry;
        if transformation.is(Keyword::CartesianTransformationOperator3d) {
            return geometry.transformation(transformation, second);
        }
        if transformation.keyword() != Keyword::ItemDefinedTransformation {
            return Err(transformation.refuse_type("transformation"));
        }
        let attributes = transformation.simple();
        let [from, to] = [attributes.reference(2)?, attributes.reference(3)?];
        let matrix = geometry.transformation(to, second)? * geometry.inverse_transformation(from, first)?;
        invertible(transformation.id(), matrix)
    }
}
