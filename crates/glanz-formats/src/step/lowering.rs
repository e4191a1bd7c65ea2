//! From the entities of a file to the model.

use std::collections::{HashMap, HashSet};

use glanz_brep::model::{BrepModel, EntityId};
use glanz_job::ResourceBudget;

use super::entities::EntityLists;
use super::geometry::GeometryReader;
use super::part21::{Entity, EntityAttributes, ExchangeFile, Keyword, Refusal};
use super::polygons::PolygonEdges;
use super::styles::StyleTable;
use super::units::{ContextUnits, UnitSet};
use crate::cad::{BrepFile, EntityNote, FaceCounts, ReadingReport};

/// An entity read in some units, by its number and the index of the units: what was made of it, or the reason against it.
pub(super) type LoweredEntities<T> = HashMap<(EntityId, usize), Result<T, Refusal>>;

/// The state of reading one file.
pub(super) struct StepReader<'a> {
    pub(super) file: &'a ExchangeFile<'a>,
    pub(super) lists: EntityLists<'a>,
    pub(super) styles: StyleTable<'a>,
    pub(super) geometry: GeometryReader,
    pub(super) model: BrepModel,
    pub(super) report: ReadingReport,
    /// Pairs of units, each once.
    pub(super) unit_sets: Vec<UnitSet>,
    contexts: HashMap<EntityId, usize>,
    pub(super) surfaces: LoweredEntities<(usize, [f64; 2])>,
    pub(super) vertices: LoweredEntities<usize>,
    pub(super) edges: LoweredEntities<usize>,
    pub(super) faces: LoweredEntities<usize>,
    pub(super) polygons: PolygonEdges,
    /// What the file hides, with all that it contains.
    pub(super) hidden_items: HashSet<EntityId>,
}

impl<'a> StepReader<'a> {
    pub(super) fn new(file: &'a ExchangeFile<'a>, budget: &ResourceBudget) -> Self {
        let lists = EntityLists::new(file);
        let mut report = ReadingReport { schemas: file.schemas.clone(), ..ReadingReport::default() };
        for fault in &file.faults {
            report.faults.push_with(|| EntityNote {
                entity: fault.instance.map(EntityId),
                position: Some([fault.line, fault.column]),
                reason: fault.reason.clone(),
            });
        }
        report.faults.add_uncounted(file.fault_count - file.faults.len());
        let styles = StyleTable::new(&lists, &mut report);
        Self {
            file,
            lists,
            styles,
            geometry: GeometryReader::new(file.size(), budget),
            model: BrepModel::default(),
            report,
            unit_sets: Vec::new(),
            contexts: HashMap::new(),
            surfaces: HashMap::new(),
            vertices: HashMap::new(),
            edges: HashMap::new(),
            faces: HashMap::new(),
            polygons: PolygonEdges::default(),
            hidden_items: HashSet::new(),
        }
    }

    /// Notes that an entity is not in the model.
    pub(super) fn omit(&mut self, entity: EntityId, refusal: &Refusal) {
        self.report.omit(entity, refusal);
    }

    /// Notes that an entity was mended.
    pub(super) fn mend(&mut self, entity: EntityId, refusal: &Refusal, remedy: &str) {
        self.report.mend(entity, refusal, remedy);
    }

    /// The index of the units of a representation, from its attributes: name, items, context.
    pub(super) fn representation_units(&mut self, attributes: &EntityAttributes<'a>) -> usize {
        let context = attributes.optional_reference(2).ok().flatten();
        self.context_units(context, attributes.id())
    }

    /// The index of the units of a shape without a representation: those of the first context in the file that has units.
    pub(super) fn file_units(&mut self, shape: EntityId) -> usize {
        let context = self.file.entities().find(|entity| entity.is(Keyword::GlobalUnitAssignedContext));
        if let Some(context) = context {
            let reason = format!("no representation has the shape; the units are those of {}", context.id());
            self.report.repairs.push(shape, reason);
        }
        self.context_units(context, shape)
    }

    fn context_units(&mut self, context: Option<Entity<'a>>, user: EntityId) -> usize {
        let entity = context.map_or(user, |context| context.id());
        if let Some(units) = self.contexts.get(&entity) {
            return *units;
        }
        let units = context.map_or_else(ContextUnits::default, |context| {
            ContextUnits::of_context(context, |refusal| self.mend(entity, refusal, "it is left out"))
        });
        let index = self.intern(units, entity);
        self.contexts.insert(entity, index);
        index
    }

    /// The index of a pair of units; without a unit of length, millimetres are meant, without one of angle, radians.
    fn intern(&mut self, units: ContextUnits, entity: EntityId) -> usize {
        if units.length.is_none() {
            self.report.repairs.push(entity, "no unit of length is given; millimetres are taken");
        }
        if units.angle.is_none() {
            self.report.repairs.push(entity, "no unit of angle is given; radians are taken");
        }
        self.model.uncertainty = self.model.uncertainty.max(units.uncertainty);
        self.model.length_unit = self.model.length_unit.or(units.length);
        let units = UnitSet { length: units.length.unwrap_or(1e-3), angle: units.angle.unwrap_or(1.0) };
        self.unit_sets.iter().position(|known| *known == units).unwrap_or_else(|| {
            self.unit_sets.push(units);
            self.unit_sets.len() - 1
        })
    }

    /// The units with an index.
    pub(super) fn units(&self, index: usize) -> UnitSet {
        self.unit_sets.get(index).copied().unwrap_or(UnitSet { length: 1.0, angle: 1.0 })
    }

    /// The model with the completed report.
    pub(super) fn finish(mut self) -> BrepFile {
        let mut faces = FaceCounts::default();
        let mut outcomes: HashMap<EntityId, bool> = HashMap::new();
        for ((entity, _), outcome) in &self.faces {
            *outcomes.entry(*entity).or_default() |= outcome.is_ok();
        }
        for entity in self.file.entities().filter(|entity| is_face(*entity)) {
            faces.total += 1;
            match outcomes.get(&entity.id()) {
                Some(true) => faces.read += 1,
                Some(false) => faces.refused += 1,
                None if self.hidden_items.contains(&entity.id()) => faces.hidden += 1,
                None => faces.unreachable += 1,
            }
        }
        self.report.faces = faces;
        self.report.repairs.append(self.geometry.repairs);
        BrepFile { model: self.model, report: self.report }
    }
}

/// Whether an entity is a face of its own.
pub(super) fn is_face(entity: Entity<'_>) -> bool {
    let is_face = |kind| matches!(kind, Keyword::AdvancedFace | Keyword::FaceSurface | Keyword::Face);
    entity.kinds().any(is_face)
        && !entity.kinds().any(|kind| matches!(kind, Keyword::OrientedFace | Keyword::Subface))
}
