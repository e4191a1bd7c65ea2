//! Shapes from CAD files.

use std::collections::{BTreeMap, HashSet};
use std::path::PathBuf;
use std::rc::Rc;

use super::{EntityState, Lowering};
use crate::cad::{CadModel, CadSettings, CadWarning, TOO_MANY_COLORS};
use crate::file_list::FileKind;
use crate::finder::spend_groups;
use crate::nearest::nearest;
use crate::pbrt::parameters::{Parameter, ParameterList, shortened};
use crate::source::{MISSING_FILE, ParseResult, Span};

/// The name of all parts that a table of materials does not name.
const OTHERS: &str = "*";

/// Largest number of names of parts in a message.
const MAX_LISTED: usize = 20;

/// A CAD file, read once, with the groups made of it.
#[derive(Debug)]
pub(crate) struct CadFile {
    /// Its name in messages.
    name: String,
    model: Rc<CadModel>,
    groups: Vec<(CadSettings, usize)>,
}

impl Lowering {
    /// Adds an instance of the parts of a CAD file.
    pub(super) fn cad_shape(&mut self, mut list: ParameterList, context: &EntityState) -> ParseResult<()> {
        let place = list.place;
        let Some((p, name)) = list.text_parameter("filename", &mut self.reporter)? else {
            let message = format!("{} has no \"string filename\"", list.subject);
            return Err(self.reporter.error(&place, "parameter-missing", message));
        };
        let path = self.cad_file(&list.subject, &p, &name)?;
        let settings = self.cad_settings(&path, &mut list, context)?;
        self.without_surface_parameters(&mut list, context, "CAD", "opaque surfaces stand in")?;
        if context.reverse_orientation {
            let message = format!(
                "{}: ReverseOrientation has no effect; normals of solids point outwards",
                list.subject
            );
            self.reporter.warning(&place, "cad-orientation", message);
        }
        let subject = std::mem::take(&mut list.subject);
        list.finish(&mut self.reporter);
        let Some(group) = self.cad_group(&path, settings, &place) else {
            let message = format!("{subject}: {name:?} shows no surface that can be read");
            return Err(self.reporter.error(&p.value_place, "step", message));
        };
        let lights = self.lights_in_groups.get(&group).copied().unwrap_or(0);
        self.check_power("step", context.emission.as_deref(), lights, &place)?;
        self.add_instance(group, &place, context)
    }

    /// Reads a file unless it is known, and returns its path.
    fn cad_file(&mut self, subject: &str, p: &Parameter, name: &str) -> ParseResult<PathBuf> {
        let missing = |this: &mut Self, problem: &dyn std::fmt::Display| {
            let message = format!("{subject}: {problem}");
            this.reporter.error(&p.value_place, MISSING_FILE, message)
        };
        let path = match self.find(name, FileKind::Cad) {
            Ok(path) => path,
            Err(fault) => return Err(missing(self, &format_args!("file {name:?} {}", fault.what()))),
        };
        if self.cad_files.contains_key(&path) {
            return Ok(path);
        }
        let (shown, bytes) =
            self.read_file(name, FileKind::Cad).map_err(|problem| missing(self, &problem))?;
        let shown = shown.display().to_string();
        let model = CadModel::read_with(&bytes, self.edges, &self.finder.budget).map_err(|error| {
            self.reporter.error(&p.value_place, "step", format!("{subject}: {shown}: {error}"))
        })?;
        for CadWarning { kind, position, message } in model.report.warnings() {
            let position = position.map(|(line, column)| format!(":{line}:{column}")).unwrap_or_default();
            let message = format!("{subject}: {shown}{position}: {message}");
            self.reporter.warning(&p.value_place, kind, message);
        }
        let file = CadFile { name: shown, model: Rc::new(model), groups: Vec::new() };
        self.cad_files.insert(path.clone(), file);
        Ok(path)
    }

    /// Selection and materials.
    fn cad_settings(
        &mut self,
        path: &PathBuf,
        list: &mut ParameterList,
        context: &EntityState,
    ) -> ParseResult<CadSettings> {
        let Some(CadFile { name, model, .. }) = self.cad_files.get(path) else {
            return Ok(CadSettings::default());
        };
        let (file, model) = (name.clone(), Rc::clone(model));
        let part = list.text_parameter("part", &mut self.reporter)?;
        if let Some((p, part)) = part.as_ref().filter(|(_, part)| !model.part_names().any(|n| n == part)) {
            let message = format!("{}: {file:?} has no part {:?}", list.subject, shortened(part));
            let help = Some(listed(part, model.part_names()));
            return Err(self.reporter.error_with_help(&p.value_place, "missing-part", message, help));
        }
        let colors = list.boolean("colors", &mut self.reporter)?;
        let (materials, others) = self.cad_materials(list, &file, &model)?;
        let others = match (others, context.material) {
            (Some(others), _) => Some(others),
            (None, material) if colors.unwrap_or(material.is_none()) => None,
            (None, Some(material)) => Some(material),
            (None, None) => Some(self.default_material(&list.place)),
        };
        let part = part.map(|(_, part)| part);
        Ok(CadSettings { part, materials, others, emission: context.emission.clone() })
    }

    /// The table of materials by the names of parts, and the material of the others.
    fn cad_materials(
        &mut self,
        list: &mut ParameterList,
        file: &str,
        model: &CadModel,
    ) -> ParseResult<(BTreeMap<String, usize>, Option<usize>)> {
        let (mut table, mut others) = (BTreeMap::new(), None);
        let Some((p, texts)) = list.texts("materials", &mut self.reporter)? else {
            return Ok((table, others));
        };
        let (pairs, rest) = texts.as_chunks::<2>();
        if !rest.is_empty() {
            let message = format!("{}: \"materials\" has {} values", list.subject, texts.len());
            let help = Some("they are pairs: the name of a part, the name of its material".to_owned());
            return Err(self.reporter.error_with_help(&p.value_place, "parameter-count", message, help));
        }
        let names: HashSet<&str> = model.names().collect();
        for [part, material] in pairs {
            if part == OTHERS {
                others.get_or_insert(self.use_material(material, &p.value_place));
            } else if names.contains(part.as_str()) {
                let material = self.use_material(material, &p.value_place);
                table.entry(part.clone()).or_insert(material);
            } else {
                let message = format!("{}: {file:?} has no part {:?}", list.subject, shortened(part));
                let help = Some(listed(part, model.part_names()));
                self.reporter.warning_with_help(&p.value_place, "missing-part", message, help);
            }
        }
        Ok((table, others))
    }

    /// The group of a file with these settings, made once; `None` if it has no surface.
    fn cad_group(&mut self, path: &PathBuf, settings: CadSettings, place: &Span) -> Option<usize> {
        let file = self.cad_files.get_mut(path)?;
        if let Some((_, group)) = file.groups.iter().find(|(known, _)| is_same(known, &settings)) {
            return Some(*group);
        }
        let first = self.description.groups.len();
        let (group, is_exhausted) = file.model.add_group(&settings, place.location, &mut self.description);
        if is_exhausted {
            self.reporter.warning(place, "cad-colors", TOO_MANY_COLORS);
        }
        // What fails is in the budget.
        let _ = spend_groups(&self.finder.budget, self.description.groups.get(first..).unwrap_or_default());
        let group = group?;
        if settings.emission.is_some() {
            // Groups contain earlier ones only.
            for (index, added) in self.description.groups.iter().enumerate().skip(first) {
                let inner = added.instances.iter().filter_map(|i| self.lights_in_groups.get(&i.group));
                let lights = inner.fold(added.shapes.len(), |sum, lights| sum.saturating_add(*lights));
                self.lights_in_groups.insert(index, lights);
            }
        }
        file.groups.push((settings, group));
        Some(group)
    }
}

/// Whether the same groups are made with both settings.
fn is_same(a: &CadSettings, b: &CadSettings) -> bool {
    let emission = match (&a.emission, &b.emission) {
        (Some(a), Some(b)) => Rc::ptr_eq(a, b),
        (a, b) => a.is_none() && b.is_none(),
    };
    emission && a.part == b.part && a.others == b.others && a.materials == b.materials
}

/// A remedy for an unknown name: the nearest of the names, and the first of them.
fn listed<'a>(name: &str, names: impl Iterator<Item = &'a str>) -> String {
    let mut known = HashSet::new();
    let names: Vec<&str> = names.filter(|name| known.insert(*name)).collect();
    let quoted: Vec<String> =
        names.iter().take(MAX_LISTED).map(|name| format!("{:?}", shortened(name))).collect();
    let more = names.len().saturating_sub(MAX_LISTED);
    let nearest = nearest(name, names).map(|n| format!("did you mean {:?}? ", shortened(n)));
    match quoted.as_slice() {
        [] => "its parts have no names".to_owned(),
        _ => {
            let more = if more > 0 { format!(" and {more} more") } else { String::new() };
            format!("{}its parts are {}{more}", nearest.unwrap_or_default(), quoted.join(", "))
        }
    }
}
