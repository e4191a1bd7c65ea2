//! `ObjectBegin`, `ObjectInstance`.

use glanz_job::Resource;
use glanz_scene::description::{GroupDescription, InstanceDescription};

use super::{EntityState, Lowering};
use crate::model::MAX_LIGHT_COPIES;
use crate::nearest::nearest;
use crate::pbrt::parameters::shortened;
use crate::source::{ParseResult, Span};

/// The object between `ObjectBegin` and `ObjectEnd`. It becomes a group at its end, after all groups that it contains.
#[derive(Debug, Default)]
pub(crate) struct OpenObject {
    pub(super) group: GroupDescription,
    /// Number of lights.
    pub(super) lights: usize,
}

impl Lowering {
    /// Target of shapes and instances.
    pub(super) fn current_group(&mut self) -> &mut GroupDescription {
        match &mut self.object {
            Some(object) => &mut object.group,
            None => &mut self.description.world,
        }
    }

    /// Begins a group that instances can refer to.
    pub(crate) fn begin_object(&mut self, name: &str, place: &Span) -> ParseResult<()> {
        if self.object.is_some() {
            let message = "ObjectBegin within another object";
            return Err(self.reporter.error(place, "nesting", message));
        }
        if self.groups.contains_key(name) {
            let message = format!(
                "object {:?} is defined again; the later definition counts from here",
                shortened(name)
            );
            self.reporter.warning(place, "object-again", message);
        }
        self.spend_entry::<GroupDescription>(name, place)?;
        let group = GroupDescription { name: name.to_owned(), ..GroupDescription::default() };
        self.object = Some(OpenObject { group, lights: 0 });
        Ok(())
    }

    /// Ends a group; only then can instances refer to it.
    pub(crate) fn end_object(&mut self) {
        if let Some(OpenObject { group, lights }) = self.object.take() {
            let index = self.description.groups.len();
            self.groups.insert(group.name.clone(), index);
            self.lights_in_groups.insert(index, lights);
            self.description.groups.push(group);
        }
    }

    /// Adds a copy of an object.
    pub(crate) fn instance(&mut self, name: &str, place: &Span, context: &EntityState) -> ParseResult<()> {
        let Some(&group) = self.groups.get(name) else {
            let message = format!("there is no object {:?}", shortened(name));
            let help =
                nearest(name, self.groups.keys().map(String::as_str)).map(|n| format!("did you mean {n:?}?"));
            return Err(self.reporter.error_with_help(place, "missing-object", message, help));
        };
        self.add_instance(group, place, context)
    }

    /// Adds a copy of a group.
    pub(super) fn add_instance(
        &mut self,
        group: usize,
        place: &Span,
        context: &EntityState,
    ) -> ParseResult<()> {
        let lights = self.lights_in_groups.get(&group).copied().unwrap_or(0);
        if lights > 0 {
            // The first instance is no copy.
            let copies = if self.lit_groups.insert(group) { 0 } else { lights };
            self.light_copies = self.light_copies.saturating_add(copies);
            let problem = if self.object.is_some() {
                "an object that emits light cannot be part of another".to_owned()
            } else if self.light_copies > MAX_LIGHT_COPIES {
                format!(
                    "instances create more than {MAX_LIGHT_COPIES} copies of lights; let fewer objects emit light"
                )
            } else {
                String::new()
            };
            if !problem.is_empty() {
                return Err(self.reporter.error(place, "instance-light", problem));
            }
        }
        let to_parent = context.ctm;
        let instance =
            InstanceDescription { name: String::new(), group, to_parent, location: Some(place.location) };
        self.reporter.spend(place, Resource::Objects, 1)?;
        self.reporter.spend(place, Resource::Memory, instance.bytes())?;
        self.current_group().instances.push(instance);
        Ok(())
    }
}
