//! Entities and their parameters.

use glanz_brep::model::EntityId;

use super::file::{DirectoryEntry, IgesFile};
use super::values::IgesValue;
use crate::cad::Refusal;

/// An entity of a file. Its parameters have the indices of the standard: 1 is the first behind the type.
#[derive(Clone, Copy, Debug)]
pub(super) struct IgesEntity<'a> {
    pub(super) file: &'a IgesFile,
    /// Its place in the directory.
    pub(super) index: usize,
    pub(super) entry: &'a DirectoryEntry,
}

impl<'a> IgesEntity<'a> {
    /// The number of its directory entry.
    pub(super) fn id(&self) -> EntityId {
        EntityId(self.entry.number.into())
    }

    pub(super) fn kind(&self) -> u32 {
        self.entry.kind
    }

    pub(super) fn form(&self) -> i64 {
        self.entry.form
    }

    pub(super) fn refuse(&self, reason: impl Into<String>) -> Refusal {
        Refusal::new(self.id(), reason)
    }

    /// The refusal of an entity where another kind is needed.
    pub(super) fn refuse_kind(&self, needed: &str) -> Refusal {
        let (kind, form) = (self.kind(), self.form());
        self.refuse(format!("type {kind} ({}), form {form}, is not read as a {needed}", type_name(kind)))
    }

    fn value(&self, i: usize) -> IgesValue {
        self.file.values(self.entry).get(i).copied().unwrap_or(IgesValue::Missing)
    }

    /// Number of parameters.
    pub(super) fn len(&self) -> usize {
        self.file.values(self.entry).len().saturating_sub(1)
    }

    /// A number; 0 where it is missing.
    pub(super) fn number(&self, i: usize) -> Result<f64, Refusal> {
        match self.value(i) {
            IgesValue::Number(value) => Ok(value),
            IgesValue::Missing if i <= self.len() => Ok(0.0),
            IgesValue::Missing => Err(self.refuse(format!("parameter {i} is missing"))),
            IgesValue::Text(_) | IgesValue::Invalid => {
                Err(self.refuse(format!("parameter {i} must be a number")))
            }
        }
    }

    /// Consecutive numbers.
    pub(super) fn numbers<const N: usize>(&self, first: usize) -> Result<[f64; N], Refusal> {
        let mut numbers = [0.0; N];
        for (i, number) in numbers.iter_mut().enumerate() {
            *number = self.number(first + i)?;
        }
        Ok(numbers)
    }

    /// An integer from 0 on.
    pub(super) fn count(&self, i: usize) -> Result<usize, Refusal> {
        let value = self.number(i)?;
        if value >= 0.0 && value.fract() == 0.0 && value <= f64::from(u32::MAX) {
            Ok(value as usize)
        } else {
            Err(self.refuse(format!("parameter {i} is {value}; it must be an integer from 0 on")))
        }
    }

    /// The length of a list of items of `size` parameters from `first` on, which is parameter `i`.
    pub(super) fn list_length(&self, i: usize, first: usize, size: usize) -> Result<usize, Refusal> {
        let count = self.count(i)?;
        let room = (self.len() + 1).saturating_sub(first) / size.max(1);
        if count <= room {
            Ok(count)
        } else {
            Err(self.refuse(format!("parameter {i} is {count}; there are parameters for {room}")))
        }
    }

    pub(super) fn flag(&self, i: usize) -> Result<bool, Refusal> {
        Ok(self.number(i)? != 0.0)
    }

    /// A text; empty where there is none.
    pub(super) fn text(&self, i: usize) -> &'a str {
        match self.value(i) {
            IgesValue::Text(index) => self.file.text(index),
            _ => "",
        }
    }

    /// The entity to which a parameter refers, which becomes part of this one; `None` for 0.
    pub(super) fn optional_reference(&self, i: usize) -> Result<Option<Self>, Refusal> {
        let entity = self.pointer(i)?;
        if let Some(entity) = entity {
            self.file.mark(entity.index);
        }
        Ok(entity)
    }

    /// The entity to which a parameter refers, which stands by itself; `None` for 0.
    pub(super) fn pointer(&self, i: usize) -> Result<Option<Self>, Refusal> {
        let value = self.number(i)?.abs();
        if value == 0.0 {
            return Ok(None);
        }
        let number = (value.fract() == 0.0 && value <= f64::from(u32::MAX)).then_some(value as u32);
        let entity = number.and_then(|number| self.file.entity(number));
        let missing =
            || self.refuse(format!("parameter {i} refers to directory entry {value}, which is missing"));
        entity.map(Some).ok_or_else(missing)
    }

    /// The entity to which a parameter refers.
    pub(super) fn reference(&self, i: usize) -> Result<Self, Refusal> {
        self.optional_reference(i)?.ok_or_else(|| self.refuse(format!("parameter {i} refers to no entity")))
    }

    /// The name that a property gives it, behind its `own` parameters; else its label.
    pub(super) fn name(&self, own: usize) -> String {
        self.property_name(own).unwrap_or_else(|| self.entry.label.clone())
    }

    /// Behind the parameters are two lists of references: to notes and groups, and to properties.
    fn property_name(&self, own: usize) -> Option<String> {
        let properties = own.saturating_add(2).saturating_add(self.count(own + 1).ok()?);
        let count = self.list_length(properties, properties.saturating_add(1), 1).ok()?;
        (properties + 1..=properties + count).find_map(|i| {
            let property = self.pointer(i).ok()??;
            let is_name = property.kind() == 406 && property.form() == 15;
            (is_name && !property.text(2).is_empty()).then(|| property.text(2).to_owned())
        })
    }
}

/// The name of a type, for messages.
pub(super) fn type_name(kind: u32) -> &'static str {
    match kind {
        100 => "circular arc",
        102 => "composite curve",
        104 => "conic arc",
        106 => "copious data",
        108 => "plane",
        110 => "line",
        112 => "parametric spline curve",
        114 => "parametric spline surface",
        116 => "point",
        118 => "ruled surface",
        120 => "surface of revolution",
        122 => "tabulated cylinder",
        123 => "direction",
        124 => "transformation matrix",
        125 => "flash",
        126 => "rational B-spline curve",
        128 => "rational B-spline surface",
        130 => "offset curve",
        132 => "connect point",
        134 | 136 | 138 => "finite elements",
        140 => "offset surface",
        141 => "boundary",
        142 => "curve on a surface",
        143 => "bounded surface",
        144 => "trimmed surface",
        150..=168 => "primitive solid",
        180 => "Boolean tree",
        182 => "selected component",
        184 => "solid assembly",
        186 => "manifold solid B-rep",
        190 => "plane surface",
        192 => "cylindrical surface",
        194 => "conical surface",
        196 => "spherical surface",
        198 => "toroidal surface",
        202..=230 => "annotation",
        302 => "associativity definition",
        304 => "line font",
        308 => "subfigure definition",
        402 => "associativity",
        404 => "drawing",
        406 => "property",
        408 => "subfigure instance",
        410 => "view",
        412 | 414 => "array of subfigures",
        416 => "external reference",
        430 => "solid instance",
        502 => "vertex list",
        504 => "edge list",
        508 => "loop",
        510 => "face",
        514 => "shell",
        _ => "unknown",
    }
}
