//! Parts that occur in others: subfigures (308) with their instances (408), solids (186) with theirs (430), and assemblies of both (184).

use glanz_brep::model::Occurrence;
use glanz_math::{DMat4, DVec3};

use super::attributes::is_rigid;
use super::contents::HIDDEN;
use super::entity::IgesEntity;
use super::lowering::{IgesReader, MAX_DEPTH};
use super::parts::{GroupIndex, PartContents};
use crate::cad::{ENTITY_COST, Refusal, invertible};

impl<'a> IgesReader<'a> {
    /// The transformation of an entity in metres.
    pub(super) fn rigid_placement(&self, entity: IgesEntity<'_>) -> Result<DMat4, Refusal> {
        self.rigid(entity, entity.matrix()?)
    }

    /// A matrix of an entity in metres, if it keeps lengths: a rotation or reflection and a translation.
    fn rigid(&self, entity: IgesEntity<'_>, matrix: DMat4) -> Result<DMat4, Refusal> {
        if !is_rigid(&matrix) {
            return Err(entity.refuse("its transformation is neither a rotation nor a reflection"));
        }
        invertible(entity.id(), self.metres() * matrix * self.metres().inverse())
    }

    /// An occurrence without name and colour, unless a scene has no coordinates for it.
    pub(super) fn occurrence(
        &self,
        entity: IgesEntity<'_>,
        part: usize,
        to_parent: DMat4,
    ) -> Result<Occurrence, Refusal> {
        let to_parent = invertible(entity.id(), to_parent)?;
        self.reaches.check(entity.id(), part, &to_parent)?;
        Ok(Occurrence { part, to_parent, name: String::new(), style: None, entity: entity.id() })
    }

    /// `DE, X, Y, Z, S`: an instance of a subfigure.
    pub(super) fn subfigure_instance(
        &mut self,
        entity: IgesEntity<'a>,
        groups: &GroupIndex,
        depth: usize,
    ) -> Result<Occurrence, Refusal> {
        self.budget.spend(entity.id(), ENTITY_COST)?;
        let definition = entity.reference(1)?;
        if definition.kind() != 308 {
            return Err(definition.refuse_kind("subfigure"));
        }
        let [x, y, z] = entity.numbers(2)?;
        let scale = if entity.len() < 5 { 1.0 } else { entity.number(5)? };
        let scale = if scale == 0.0 { 1.0 } else { scale };
        let to_parent = self.rigid_placement(entity)?
            * DMat4::from_translation(DVec3::new(x, y, z) * self.file.global.length)
            * DMat4::from_scale(DVec3::splat(scale));
        let part = self.definition(definition, groups, depth)?;
        let occurrence = self.occurrence(entity, part, to_parent)?;
        Ok(Occurrence { name: entity.name(5), style: entity.color(), ..occurrence })
    }

    /// A solid, an assembly, or `DE`: an instance of one; `outer`: the transformation that the assembly around it gives it, metres.
    pub(super) fn placed_solid(
        &mut self,
        entity: IgesEntity<'a>,
        outer: DMat4,
        groups: &GroupIndex,
        depth: usize,
    ) -> Result<Occurrence, Refusal> {
        self.budget.spend(entity.id(), ENTITY_COST)?;
        let mut to_parent = outer * self.rigid_placement(entity)?;
        let is_instance = entity.kind() == 430;
        let definition = if is_instance { entity.reference(1)? } else { entity };
        if !matches!(definition.kind(), 184 | 186) {
            return Err(definition.refuse_kind("solid"));
        }
        if is_instance {
            to_parent *= self.rigid_placement(definition)?;
        }
        let part = self.definition(definition, groups, depth)?;
        let mut occurrence = self.occurrence(entity, part, to_parent)?;
        if is_instance {
            occurrence.name = entity.name(1);
        }
        // The bodies of a solid have its colour.
        if entity.kind() != 186 {
            occurrence.style = entity.color();
        }
        Ok(occurrence)
    }

    /// The part of a subfigure, a solid or an assembly, made once.
    fn definition(
        &mut self,
        entity: IgesEntity<'a>,
        groups: &GroupIndex,
        depth: usize,
    ) -> Result<usize, Refusal> {
        match self.definitions.get(&entity.index) {
            Some(Some(known)) => return known.clone(),
            Some(None) => {
                return Err(entity.refuse(format!("the {} contains itself", definition_name(entity))));
            }
            None => {}
        }
        self.definitions.insert(entity.index, None);
        let part = self.new_definition(entity, groups, depth);
        self.definitions.insert(entity.index, Some(part.clone()));
        part
    }

    fn new_definition(
        &mut self,
        entity: IgesEntity<'a>,
        groups: &GroupIndex,
        depth: usize,
    ) -> Result<usize, Refusal> {
        let what = definition_name(entity);
        let depth = depth.checked_sub(1).ok_or_else(|| {
            entity.refuse(format!("subfigures and assemblies are nested deeper than {MAX_DEPTH} levels"))
        })?;
        self.spend(entity)?;
        let (part, name) = match entity.kind() {
            308 => self.subfigure(entity, groups, depth)?,
            184 => self.assembly(entity, groups, depth)?,
            _ => {
                let body = self.solid(entity)?;
                let name = body.name.clone();
                let is_empty = body.shells.iter().all(|shell| shell.faces.is_empty());
                let bodies = if is_empty { Vec::new() } else { vec![body] };
                (self.add_part(entity, PartContents { bodies, ..PartContents::default() }, groups), name)
            }
        };
        let part =
            part.ok_or_else(|| entity.refuse(format!("the {what} has no surface that can be read")))?;
        if let Some(part) = self.model.parts.get_mut(part) {
            part.name = name;
            part.entity = entity.id();
        }
        Ok(part)
    }

    /// `DEPTH, NAME, N, DE...`: the part of a subfigure, with its name.
    fn subfigure(
        &mut self,
        entity: IgesEntity<'a>,
        groups: &GroupIndex,
        depth: usize,
    ) -> Result<(Option<usize>, String), Refusal> {
        let count = entity.list_length(3, 4, 1)?;
        let items = (0..count).map(|i| entity.reference(4 + i)).collect::<Result<Vec<_>, _>>()?;
        Ok((self.part(&items, groups, depth, false), entity.text(2).to_owned()))
    }

    /// `N, DE..., MATRIX...`: the part of an assembly, with its name. Its own transformation places it.
    fn assembly(
        &mut self,
        entity: IgesEntity<'a>,
        groups: &GroupIndex,
        depth: usize,
    ) -> Result<(Option<usize>, String), Refusal> {
        let count = entity.list_length(1, 2, 1)?;
        let mut contents = PartContents::default();
        for i in 0..count {
            match self.assembly_item(entity, [2 + i, 2 + count + i], groups, depth) {
                Ok(occurrence) => contents.occurrences.extend(occurrence),
                Err(refusal) => self.report.omit(entity.id(), &refusal),
            }
        }
        Ok((self.add_part(entity, contents, groups), entity.name(1 + 2 * count)))
    }

    /// The item of an assembly by its parameter and by that of its transformation; `None` if the file hides it.
    fn assembly_item(
        &mut self,
        entity: IgesEntity<'a>,
        [at, matrix_at]: [usize; 2],
        groups: &GroupIndex,
        depth: usize,
    ) -> Result<Option<Occurrence>, Refusal> {
        let item = entity.reference(at)?;
        if item.entry.hidden {
            self.unshown.push((item, HIDDEN));
            return Ok(None);
        }
        let matrix = if matrix_at <= entity.len() { entity.optional_reference(matrix_at)? } else { None };
        let pointer: i64 = matrix.map_or(0, |matrix| matrix.entry.number.into());
        let outer = self.rigid(item, item.transformation(pointer)?)?;
        self.placed_solid(item, outer, groups, depth).map(Some)
    }
}

/// What an entity is that may occur several times, for messages.
fn definition_name(entity: IgesEntity<'_>) -> &'static str {
    match entity.kind() {
        308 => "subfigure",
        184 => "assembly",
        _ => "solid",
    }
}
