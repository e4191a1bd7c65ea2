//! The JSON part of a file, with the place of each value for messages.

use std::fmt;
use std::sync::LazyLock;

use glanz_job::ResourceBudget;
use serde_json::{Map, Value};

use super::error::GltfError;
use crate::budget_reader::BudgetReader;

/// A JSON pointer (RFC 6901) that is only written when a message needs it.
#[derive(Clone, Copy, Debug)]
pub(super) struct JsonPath<'a> {
    parent: Option<&'a JsonPath<'a>>,
    key: JsonKey<'a>,
}

#[derive(Clone, Copy, Debug)]
enum JsonKey<'a> {
    Root,
    Name(&'a str),
    Index(usize),
}

impl fmt::Display for JsonPath<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(parent) = self.parent {
            write!(f, "{parent}")?;
        }
        match self.key {
            JsonKey::Root => Ok(()),
            JsonKey::Name(name) => write!(f, "/{}", name.replace('~', "~0").replace('/', "~1")),
            JsonKey::Index(index) => write!(f, "/{index}"),
        }
    }
}

/// An object of the file with its place.
#[derive(Clone, Copy, Debug)]
pub(super) struct JsonObject<'a> {
    object: &'a Map<String, Value>,
    path: &'a JsonPath<'a>,
}

/// An object that the file leaves out where all of its members have defaults.
static EMPTY: LazyLock<Map<String, Value>> = LazyLock::new(Map::new);

impl JsonPath<'static> {
    /// The whole document.
    pub(super) const ROOT: Self = Self { parent: None, key: JsonKey::Root };
}

impl<'a> JsonPath<'a> {
    /// A member of the object here.
    pub(super) fn name(&'a self, name: &'a str) -> JsonPath<'a> {
        JsonPath { parent: Some(self), key: JsonKey::Name(name) }
    }

    /// An element of the list here.
    pub(super) fn index(&'a self, index: usize) -> JsonPath<'a> {
        JsonPath { parent: Some(self), key: JsonKey::Index(index) }
    }

    /// An error about the value here.
    pub(super) fn error(&self, message: impl Into<String>) -> GltfError {
        GltfError { pointer: Some(self.to_string()), message: message.into() }
    }
}

/// The kind of a value, for messages.
fn kind(value: &Value) -> &'static str {
    match value {
        Value::Null => "null",
        Value::Bool(_) => "a truth value",
        Value::Number(_) => "a number",
        Value::String(_) => "a text",
        Value::Array(_) => "a list",
        Value::Object(_) => "an object",
    }
}

fn wrong(path: &JsonPath<'_>, value: &Value, needed: &str) -> GltfError {
    path.error(format!("this is {}; the format needs {needed}", kind(value)))
}

impl<'a> JsonObject<'a> {
    /// The object at a place.
    pub(super) fn try_new(value: &'a Value, path: &'a JsonPath<'a>) -> Result<Self, GltfError> {
        let object = value.as_object().ok_or_else(|| wrong(path, value, "an object"))?;
        Ok(Self { object, path })
    }

    /// Its place.
    pub(super) fn path(&self) -> &'a JsonPath<'a> {
        self.path
    }

    /// Whether it has a member of this name.
    pub(super) fn has(&self, name: &str) -> bool {
        self.object.contains_key(name)
    }

    /// An error about a member.
    pub(super) fn error(&self, name: &str, message: impl Into<String>) -> GltfError {
        self.path.name(name).error(message)
    }

    /// An error about the object.
    pub(super) fn fault(&self, message: impl Into<String>) -> GltfError {
        self.path.error(message)
    }

    fn member<T>(
        &self,
        name: &str,
        needed: &str,
        convert: impl FnOnce(&'a Value) -> Option<T>,
    ) -> Result<Option<T>, GltfError> {
        let Some(value) = self.object.get(name) else { return Ok(None) };
        convert(value).map(Some).ok_or_else(|| wrong(&self.path.name(name), value, needed))
    }

    /// A member that must be there.
    fn required<T>(&self, name: &str, found: Option<T>) -> Result<T, GltfError> {
        found.ok_or_else(|| self.fault(format!("{name:?} is missing")))
    }

    pub(super) fn text(&self, name: &str) -> Result<Option<&'a str>, GltfError> {
        self.member(name, "a text", Value::as_str)
    }

    /// The name of the object; empty if it has none.
    pub(super) fn own_name(&self) -> String {
        self.text("name").ok().flatten().unwrap_or_default().to_owned()
    }

    pub(super) fn boolean(&self, name: &str) -> Result<bool, GltfError> {
        Ok(self.member(name, "true or false", Value::as_bool)?.unwrap_or(false))
    }

    pub(super) fn number(&self, name: &str) -> Result<Option<f64>, GltfError> {
        self.member(name, "a number", Value::as_f64)
    }

    /// A number in [0, 1].
    pub(super) fn fraction(&self, name: &str, default: f64) -> Result<f64, GltfError> {
        let x = self.number(name)?.unwrap_or(default);
        if (0.0..=1.0).contains(&x) {
            Ok(x)
        } else {
            Err(self.error(name, format!("{x} is not between 0 and 1")))
        }
    }

    /// A number of at least 0.
    pub(super) fn positive(&self, name: &str, default: f64) -> Result<f64, GltfError> {
        let x = self.number(name)?.unwrap_or(default);
        if x >= 0.0 { Ok(x) } else { Err(self.error(name, format!("{x} is negative"))) }
    }

    /// A number that must be there.
    pub(super) fn required_number(&self, name: &str) -> Result<f64, GltfError> {
        self.required(name, self.number(name)?)
    }

    /// A whole number of at least 0.
    pub(super) fn count(&self, name: &str) -> Result<Option<usize>, GltfError> {
        let whole = |value: &Value| {
            let float = || value.as_f64().filter(|x| x.fract() == 0.0 && (0.0..9e15).contains(x));
            value.as_u64().or_else(|| float().map(|x| x as u64)).and_then(|n| usize::try_from(n).ok())
        };
        self.member(name, "a whole number of at least 0", whole)
    }

    /// As above, and it must be there.
    pub(super) fn required_count(&self, name: &str) -> Result<usize, GltfError> {
        self.required(name, self.count(name)?)
    }

    /// `N` numbers.
    pub(super) fn numbers<const N: usize>(&self, name: &str) -> Result<Option<[f64; N]>, GltfError> {
        self.member(name, &format!("a list of {N} numbers"), |value| {
            let list = value.as_array().filter(|list| list.len() == N)?;
            let mut numbers = [0.0; N];
            for (number, value) in numbers.iter_mut().zip(list) {
                *number = value.as_f64()?;
            }
            Some(numbers)
        })
    }

    /// Non-negative numbers, such as a color.
    pub(super) fn color<const N: usize>(&self, name: &str) -> Result<Option<[f64; N]>, GltfError> {
        let color = self.numbers::<N>(name)?;
        if color.is_some_and(|color| !color.iter().all(|x| *x >= 0.0)) {
            return Err(self.error(name, "a colour has no negative numbers"));
        }
        Ok(color)
    }

    /// A list; empty if it is missing.
    pub(super) fn list(&self, name: &str) -> Result<&'a [Value], GltfError> {
        Ok(self.member(name, "a list", Value::as_array)?.map_or(&[], Vec::as_slice))
    }

    /// An object; `f` gets it with its place, or `None` if it is missing.
    pub(super) fn object<T>(
        &self,
        name: &str,
        f: impl FnOnce(Option<JsonObject<'_>>) -> Result<T, GltfError>,
    ) -> Result<T, GltfError> {
        let path = self.path.name(name);
        match self.object.get(name) {
            Some(value) => f(Some(JsonObject::try_new(value, &path)?)),
            None => f(None),
        }
    }

    /// As above, with an empty object for a missing one.
    pub(super) fn object_or_empty<T>(
        &self,
        name: &str,
        f: impl FnOnce(JsonObject<'_>) -> Result<T, GltfError>,
    ) -> Result<T, GltfError> {
        let path = self.path.name(name);
        self.object(name, |found| f(found.unwrap_or(JsonObject { object: &EMPTY, path: &path })))
    }

    /// The extension `name` of the object; `f` gets `None` if it has none.
    pub(super) fn extension<T>(
        &self,
        name: &str,
        f: impl FnOnce(Option<JsonObject<'_>>) -> Result<T, GltfError>,
    ) -> Result<T, GltfError> {
        self.object_or_empty("extensions", |extensions| extensions.object(name, f))
    }

    /// Names of the members.
    pub(super) fn names(&self) -> impl Iterator<Item = &'a str> + use<'a> {
        self.object.keys().map(String::as_str)
    }
}

/// Bytes of a text that takes some time to read.
const LONG_TEXT: usize = 1 << 20;

/// The document.
#[derive(Debug)]
pub(super) struct Document {
    root: Value,
}

impl Document {
    /// Parses the text; one of megabytes in steps, between which the budget may end it.
    pub(super) fn parse(text: &[u8], budget: &ResourceBudget) -> Result<Self, serde_json::Error> {
        // Some programs write a byte order mark.
        let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text);
        let root = match text.len() {
            // A slice is read twice as fast.
            0..LONG_TEXT => serde_json::from_slice(text)?,
            _ => serde_json::from_reader(BudgetReader::new(text, budget))?,
        };
        Ok(Self { root })
    }

    /// The whole as an object.
    pub(super) fn root(&self) -> Result<JsonObject<'_>, GltfError> {
        JsonObject::try_new(&self.root, &JsonPath::ROOT)
    }

    /// Number of elements of a list at the root.
    pub(super) fn length(&self, list: &str) -> usize {
        self.root.get(list).and_then(Value::as_array).map_or(0, Vec::len)
    }

    /// Element `index` of a list at the root, which the value at `from` names.
    pub(super) fn element<T>(
        &self,
        list: &'static str,
        index: usize,
        from: &JsonPath<'_>,
        f: impl FnOnce(JsonObject<'_>) -> Result<T, GltfError>,
    ) -> Result<T, GltfError> {
        let found = self.root.get(list).and_then(|list| list.get(index));
        let Some(value) = found else {
            let count = self.length(list);
            return Err(from.error(format!("element {index} of \"{list}\" does not exist; it has {count}")));
        };
        let root = JsonPath::ROOT;
        let path = root.name(list);
        let path = path.index(index);
        f(JsonObject::try_new(value, &path)?)
    }
}
