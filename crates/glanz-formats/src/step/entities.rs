//! The entities from which reading starts, by kind.

use super::part21::{Entity, ExchangeFile, Keyword};

/// Entities in the order of their numbers.
#[derive(Debug, Default)]
pub(super) struct EntityLists<'a> {
    /// Items with their styles.
    pub(super) styled_items: Vec<Entity<'a>>,
    /// `INVISIBILITY`.
    pub(super) invisibilities: Vec<Entity<'a>>,
    /// `PRESENTATION_LAYER_ASSIGNMENT`.
    pub(super) layers: Vec<Entity<'a>>,
    /// Representations of product definitions.
    pub(super) definitions: Vec<Entity<'a>>,
    /// `PRODUCT_DEFINITION`.
    pub(super) products: Vec<Entity<'a>>,
    /// `NEXT_ASSEMBLY_USAGE_OCCURRENCE`.
    pub(super) usages: Vec<Entity<'a>>,
    /// `CONTEXT_DEPENDENT_SHAPE_REPRESENTATION`.
    pub(super) placements: Vec<Entity<'a>>,
    /// Relationships between representations.
    pub(super) relationships: Vec<Entity<'a>>,
    /// `REPRESENTATION_MAP`.
    pub(super) maps: Vec<Entity<'a>>,
    /// Representations of shapes.
    pub(super) representations: Vec<Entity<'a>>,
}

impl<'a> EntityLists<'a> {
    pub(super) fn new(file: &'a ExchangeFile<'a>) -> Self {
        let mut lists = Self::default();
        for entity in file.entities() {
            let known = entity.kinds().find(|kind| lists.list(*kind).is_some());
            if let Some(list) = known.and_then(|kind| lists.list(kind)) {
                list.push(entity);
            }
        }
        lists
    }

    fn list(&mut self, kind: Keyword) -> Option<&mut Vec<Entity<'a>>> {
        use Keyword as K;
        Some(match kind {
            K::StyledItem | K::OverRidingStyledItem | K::ContextDependentOverRidingStyledItem => {
                &mut self.styled_items
            }
            K::Invisibility => &mut self.invisibilities,
            K::PresentationLayerAssignment => &mut self.layers,
            K::ShapeDefinitionRepresentation | K::PropertyDefinitionRepresentation => &mut self.definitions,
            K::ProductDefinition | K::ProductDefinitionWithAssociatedDocuments => &mut self.products,
            K::NextAssemblyUsageOccurrence => &mut self.usages,
            K::ContextDependentShapeRepresentation => &mut self.placements,
            K::RepresentationRelationship
            | K::RepresentationRelationshipWithTransformation
            | K::ShapeRepresentationRelationship => &mut self.relationships,
            K::RepresentationMap => &mut self.maps,
            K::AdvancedBrepShapeRepresentation
            | K::CompoundShapeRepresentation
            | K::FacetedBrepShapeRepresentation
            | K::GeometricallyBoundedSurfaceShapeRepresentation
            | K::GeometricallyBoundedWireframeShapeRepresentation
            | K::EdgeBasedWireframeShapeRepresentation
            | K::ManifoldSurfaceShapeRepresentation
            | K::PlanarShapeRepresentation
            | K::ShapeRepresentation
            | K::ShapeRepresentationWithParameters
            | K::TessellatedShapeRepresentation => &mut self.representations,
            _ => return None,
        })
    }
}
