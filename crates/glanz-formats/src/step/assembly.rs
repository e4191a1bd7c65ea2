//! Which representations make a product, and which products it contains.

use std::collections::hash_map::Entry;
use std::collections::{HashMap, HashSet};

use glanz_brep::model::EntityId;

use super::entities::EntityLists;
use super::geometry::GeometryReader;
use super::part21::{Entity, Keyword, Refusal};

/// Parts inside one another, at most.
pub(super) const MAX_ASSEMBLY_DEPTH: usize = 64;

/// Products, their representations and the relations between them.
#[derive(Debug, Default)]
pub(super) struct AssemblyIndex<'a> {
    /// Representations by product definition, in the order of the file; then those that are linked to them.
    groups: HashMap<EntityId, Vec<Entity<'a>>>,
    /// The product definition by representation.
    owners: HashMap<EntityId, Entity<'a>>,
    /// Representations of the same shape in the same frame.
    links: HashMap<EntityId, Vec<Entity<'a>>>,
    /// Relationships with a transformation that belong to no usage, by the representation that contains the other one.
    placed: HashMap<EntityId, Vec<Entity<'a>>>,
    usages: HashMap<EntityId, Vec<Entity<'a>>>,
    /// The relationships of representations that place a usage.
    placements: HashMap<EntityId, Vec<Entity<'a>>>,
    /// Entities that stand for a usage, as contexts of its style.
    usage_contexts: HashMap<EntityId, Vec<EntityId>>,
    /// The usages for which an entity stands.
    usages_of_contexts: HashMap<EntityId, Vec<Entity<'a>>>,
    used: HashSet<EntityId>,
}

/// The two representations and the transformation of a relationship.
#[derive(Clone, Copy, Debug)]
pub(super) struct RelationshipEnds<'a> {
    pub(super) first: Entity<'a>,
    pub(super) second: Entity<'a>,
    pub(super) transformation: Option<Entity<'a>>,
}

impl<'a> RelationshipEnds<'a> {
    pub(super) fn of(entity: Entity<'a>) -> Result<Self, Refusal> {
        use Keyword::{RepresentationRelationship, RepresentationRelationshipWithTransformation};
        let attributes =
            entity.attributes(&[RepresentationRelationship, RepresentationRelationshipWithTransformation]);
        let [first, second] = [attributes.reference(2)?, attributes.reference(3)?];
        let has_transformation = entity.is(RepresentationRelationshipWithTransformation);
        let transformation = has_transformation.then(|| attributes.reference(4)).transpose()?;
        Ok(Self { first, second, transformation })
    }
}

impl<'a> AssemblyIndex<'a> {
    /// The index of a file, with the entities that cannot be read.
    pub(super) fn new(lists: &EntityLists<'a>) -> (Self, Vec<Refusal>) {
        let mut index = Self::default();
        let mut refusals = Vec::new();
        let mut placed_by_usage = HashSet::new();
        for placement in &lists.placements {
            match index.add_placement(*placement) {
                Ok(relationship) => drop(placed_by_usage.insert(relationship)),
                Err(refusal) => refusals.push(refusal),
            }
        }
        for relationship in &lists.relationships {
            if !placed_by_usage.contains(&relationship.id()) {
                refusals.extend(index.add_relationship(*relationship).err());
            }
        }
        for usage in &lists.usages {
            refusals.extend(index.add_usage(*usage).err());
        }
        for definition in &lists.definitions {
            refusals.extend(index.add_definition(*definition).err());
        }
        let mut followed = HashSet::new();
        for product in &lists.products {
            index.complete_group(*product, &mut followed);
        }
        (index, refusals)
    }

    /// `CONTEXT_DEPENDENT_SHAPE_REPRESENTATION(relationship, PRODUCT_DEFINITION_SHAPE(name, text, usage))`.
    fn add_placement(&mut self, entity: Entity<'a>) -> Result<EntityId, Refusal> {
        let attributes = entity.simple();
        let [relationship, property] = [attributes.reference(0)?, attributes.reference(1)?];
        let usage = property.simple().reference(2)?;
        for context in [relationship.id(), entity.id(), property.id()] {
            self.add_context(usage, context);
        }
        self.placements.entry(usage.id()).or_default().push(relationship);
        Ok(relationship.id())
    }

    /// Notes that an entity stands for a usage.
    fn add_context(&mut self, usage: Entity<'a>, context: EntityId) {
        self.usage_contexts.entry(usage.id()).or_default().push(context);
        let usages = self.usages_of_contexts.entry(context).or_default();
        if usages.last().is_none_or(|last| last.id() != usage.id()) {
            usages.push(usage);
        }
    }

    fn add_relationship(&mut self, entity: Entity<'a>) -> Result<(), Refusal> {
        let ends = RelationshipEnds::of(entity)?;
        if ends.transformation.is_some() {
            self.placed.entry(ends.second.id()).or_default().push(entity);
        } else {
            self.links.entry(ends.first.id()).or_default().push(ends.second);
            self.links.entry(ends.second.id()).or_default().push(ends.first);
        }
        Ok(())
    }

    /// `NEXT_ASSEMBLY_USAGE_OCCURRENCE(id, name, text, parent, child, designator)`.
    fn add_usage(&mut self, entity: Entity<'a>) -> Result<(), Refusal> {
        let attributes = entity.simple();
        let [parent, child] = [attributes.reference(3)?, attributes.reference(4)?];
        self.usages.entry(parent.id()).or_default().push(entity);
        self.used.insert(child.id());
        Ok(())
    }

    /// `SHAPE_DEFINITION_REPRESENTATION(PRODUCT_DEFINITION_SHAPE(name, text, product), representation)`.
    fn add_definition(&mut self, entity: Entity<'a>) -> Result<(), Refusal> {
        let attributes = entity.simple();
        let property = attributes.reference(0)?;
        if !property.is(Keyword::ProductDefinitionShape) {
            return Ok(());
        }
        let product = property.simple().reference(2)?;
        let representation = attributes.reference(1)?;
        if is_usage(product) {
            self.add_context(product, property.id());
            self.add_context(product, representation.id());
        }
        if !is_product(product) {
            return Ok(());
        }
        self.groups.entry(product.id()).or_default().push(representation);
        self.owners.entry(representation.id()).or_insert(product);
        Ok(())
    }

    /// Adds to the representations of a product those that are linked to them and belong to no other. `followed`: the representations whose
    /// links are known to lead to no other, as those that several products have.
    fn complete_group(&mut self, product: Entity<'a>, followed: &mut HashSet<EntityId>) {
        let Some(mut group) = self.groups.remove(&product.id()) else { return };
        let mut next = 0;
        while let Some(representation) = group.get(next) {
            let is_new = followed.insert(representation.id());
            let links = self.links.get(&representation.id()).filter(|_| is_new);
            for linked in links.into_iter().flatten() {
                if let Entry::Vacant(owner) = self.owners.entry(linked.id()) {
                    owner.insert(product);
                    group.push(*linked);
                }
            }
            next += 1;
        }
        self.groups.insert(product.id(), group);
    }

    /// The representations of a product definition.
    pub(super) fn group(&self, product: EntityId) -> Vec<Entity<'a>> {
        self.groups.get(&product).cloned().unwrap_or_default()
    }

    /// The representations with the shape of one that belongs to no product, itself first. Every link is taken off the budget, also
    /// those that lead to the same representation.
    ///
    /// # Errors
    /// Those of [`GeometryReader::spend`].
    pub(super) fn linked(
        &self,
        representation: Entity<'a>,
        geometry: &mut GeometryReader,
    ) -> Result<Vec<Entity<'a>>, Refusal> {
        let (mut group, mut known) = (vec![representation], HashSet::from([representation.id()]));
        let mut next = 0;
        while let Some(representation) = group.get(next) {
            let links = self.links.get(&representation.id()).map_or(&[][..], Vec::as_slice);
            geometry.spend(representation.id(), links.len())?;
            for linked in links {
                if !self.owners.contains_key(&linked.id()) && known.insert(linked.id()) {
                    group.push(*linked);
                }
            }
            next += 1;
        }
        Ok(group)
    }

    /// The product definition of a representation.
    pub(super) fn owner(&self, representation: EntityId) -> Option<Entity<'a>> {
        self.owners.get(&representation).copied()
    }

    /// Relationships that place other representations in this one.
    pub(super) fn placed_in(&self, representation: EntityId) -> &[Entity<'a>] {
        self.placed.get(&representation).map_or(&[], Vec::as_slice)
    }

    /// The products that a product contains.
    pub(super) fn usages(&self, product: EntityId) -> Vec<Entity<'a>> {
        self.usages.get(&product).cloned().unwrap_or_default()
    }

    /// The relationships of representations that place a usage.
    pub(super) fn placements(&self, usage: EntityId) -> &[Entity<'a>] {
        self.placements.get(&usage).map_or(&[], Vec::as_slice)
    }

    /// The entities that may be the context of the style of a usage.
    pub(super) fn style_contexts(&self, usage: EntityId) -> impl Iterator<Item = EntityId> {
        std::iter::once(usage).chain(self.usage_contexts.get(&usage).into_iter().flatten().copied())
    }

    /// The usages for which an entity stands: itself, or those of whose style it may be the context.
    pub(super) fn usages_of_context<'s>(&'s self, context: &'s Entity<'a>) -> &'s [Entity<'a>] {
        if is_usage(*context) {
            return std::slice::from_ref(context);
        }
        self.usages_of_contexts.get(&context.id()).map_or(&[], Vec::as_slice)
    }

    /// Whether it is the number of a product with a shape, or with others in it.
    pub(super) fn is_product(&self, entity: EntityId) -> bool {
        self.groups.contains_key(&entity) || self.usages.contains_key(&entity)
    }

    /// Whether a product is shown by itself: no other contains it, and it has a shape or contains others.
    pub(super) fn is_root(&self, product: EntityId) -> bool {
        !self.used.contains(&product) && self.is_product(product)
    }
}

/// Whether an entity is a product definition.
fn is_product(entity: Entity<'_>) -> bool {
    entity.is(Keyword::ProductDefinition) || entity.is(Keyword::ProductDefinitionWithAssociatedDocuments)
}

/// Whether an entity is the usage of a product in another, perhaps deep inside of it.
pub(super) fn is_usage(entity: Entity<'_>) -> bool {
    entity.is(Keyword::NextAssemblyUsageOccurrence) || entity.is(Keyword::SpecifiedHigherUsageOccurrence)
}

/// The products `[parent, child]` of a usage.
pub(super) fn usage_ends(usage: Entity<'_>) -> Result<[EntityId; 2], Refusal> {
    let attributes = usage.simple();
    Ok([attributes.reference(3)?.id(), attributes.reference(4)?.id()])
}

/// The usages inside one another for which one stands, the outer one first.
///
/// `SPECIFIED_HIGHER_USAGE_OCCURRENCE(id, name, text, parent, child, designator, upper, next)` is a usage inside another. The standard
/// wants another such usage as the upper one; some writers have it as the next one.
pub(super) fn usage_path(usage: Entity<'_>) -> Result<Vec<EntityId>, Refusal> {
    let (mut path, mut open) = (Vec::new(), vec![usage]);
    while let Some(usage) = open.pop() {
        if !usage.is(Keyword::SpecifiedHigherUsageOccurrence) {
            path.push(usage.id());
            continue;
        }
        if path.len() + open.len() >= MAX_ASSEMBLY_DEPTH {
            return Err(usage.refuse(format!("usages are nested deeper than {MAX_ASSEMBLY_DEPTH} levels")));
        }
        let attributes = usage.simple();
        let [upper, next] = [attributes.reference(6)?, attributes.reference(7)?];
        open.extend([next, upper]);
    }
    Ok(path)
}

/// The name of a product, or else its number for people.
pub(super) fn product_name(definition: Entity<'_>) -> String {
    let attributes = definition.attributes(&[Keyword::ProductDefinition]);
    let product = attributes.reference(2).and_then(|formation| formation.simple().reference(2));
    let Ok(product) = product else { return String::new() };
    let attributes = product.simple();
    let name = attributes.text(1);
    if name.is_empty() { attributes.text(0) } else { name }
}
