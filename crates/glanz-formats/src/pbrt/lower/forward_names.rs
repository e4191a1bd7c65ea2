//! Names that may be used before their definition.

use std::collections::BTreeMap;

use crate::nearest::nearest;
use crate::pbrt::parameters::shortened;
use crate::source::{Reporter, Span};

/// Indices of the values with names. If a name is used before its definition, a place in the list is reserved.
#[derive(Debug, Default)]
pub(crate) struct ForwardNames(BTreeMap<String, NamedIndex>);

#[derive(Debug)]
struct NamedIndex {
    index: usize,
    /// Span of its first use, until it is defined.
    awaited: Option<Span>,
}

impl ForwardNames {
    /// The index of the value of this name, for which `until_defined` stands in.
    pub(super) fn index_of<T>(
        &mut self,
        name: &str,
        place: &Span,
        values: &mut Vec<T>,
        until_defined: impl FnOnce() -> T,
    ) -> usize {
        if let Some(known) = self.0.get(name) {
            return known.index;
        }
        values.push(until_defined());
        let index = values.len() - 1;
        self.0.insert(name.to_owned(), NamedIndex { index, awaited: Some(*place) });
        index
    }

    /// Adds a value with a name. The next uses of the name mean it.
    pub(super) fn define<T>(&mut self, name: &str, value: T, values: &mut Vec<T>) {
        let reserved = match self.0.get(name) {
            Some(NamedIndex { index, awaited: Some(_) }) => {
                values.get_mut(*index).map(|place| (*index, place))
            }
            _ => None,
        };
        let index = match reserved {
            Some((index, place)) => {
                *place = value;
                index
            }
            None => {
                values.push(value);
                values.len() - 1
            }
        };
        self.0.insert(name.to_owned(), NamedIndex { index, awaited: None });
    }

    /// Reports the names that are used and never defined. `noun`: what they name.
    pub(super) fn report_missing(&self, noun: &str, kind: &'static str, reporter: &mut Reporter) {
        for (name, place) in self.0.iter().filter_map(|(name, value)| Some((name, value.awaited?))) {
            let defined = self.0.iter().filter(|(_, value)| value.awaited.is_none());
            let help = nearest(name, defined.map(|(name, _)| name.as_str()));
            let help = help.map(|name| format!("did you mean {name:?}?"));
            let message = format!("there is no {noun} {:?}", shortened(name));
            reporter.error_with_help(&place, kind, message, help);
        }
    }
}
