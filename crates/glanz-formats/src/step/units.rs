//! Units and uncertainty of representation contexts.

use super::part21::{Entity, EntityAttributes, Keyword, Refusal};

/// Units of the coordinates and angles of a representation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct UnitSet {
    /// Metres.
    pub(super) length: f64,
    /// Radians.
    pub(super) angle: f64,
}

/// Units of a context, with the uncertainty of its lengths.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct ContextUnits {
    /// Metres, if there is a unit.
    pub(super) length: Option<f64>,
    /// Radians, if there is a unit.
    pub(super) angle: Option<f64>,
    /// Metres; 0 if it is not given.
    pub(super) uncertainty: f64,
}

/// The value of a unit.
#[derive(Clone, Copy, Debug, PartialEq)]
enum UnitValue {
    /// Metres.
    Length(f64),
    /// Radians.
    Angle(f64),
}

/// Units defined by units, at most.
const MAX_CONVERSIONS: usize = 8;

impl ContextUnits {
    /// The units and the uncertainty that a context assigns, without those that cannot be read, which `refused` gets.
    pub(super) fn of_context(context: Entity<'_>, mut refused: impl FnMut(&Refusal)) -> Self {
        let mut units = Self::default();
        if context.is(Keyword::GlobalUnitAssignedContext) {
            let attributes = context.attributes(&[Keyword::GlobalUnitAssignedContext]);
            let read = |unit| value(unit, MAX_CONVERSIONS);
            for_each_readable(&attributes, last(context), &mut refused, read, |unit| match unit {
                UnitValue::Length(metres) => units.length = Some(metres),
                UnitValue::Angle(radians) => units.angle = Some(radians),
            });
        }
        if context.keyword() == Keyword::Complex && context.is(Keyword::GlobalUncertaintyAssignedContext) {
            let attributes = context.attributes(&[Keyword::GlobalUncertaintyAssignedContext]);
            for_each_readable(&attributes, 0, &mut refused, uncertainty, |metres| {
                units.uncertainty = units.uncertainty.max(metres);
            });
        }
        units
    }
}

/// Reads the entities in a list, each on its own.
fn for_each_readable<'a, T>(
    attributes: &EntityAttributes<'a>,
    list: usize,
    refused: &mut impl FnMut(&Refusal),
    read: impl Fn(Entity<'a>) -> Result<Option<T>, Refusal>,
    mut take: impl FnMut(T),
) {
    match attributes.references(list) {
        Ok(entities) => {
            for entity in entities {
                match entity.and_then(&read) {
                    Ok(value) => value.into_iter().for_each(&mut take),
                    Err(refusal) => refused(&refusal),
                }
            }
        }
        Err(refusal) => refused(&refusal),
    }
}

/// The metres of a measure of uncertainty; `None` if it is not of length.
fn uncertainty(measure: Entity<'_>) -> Result<Option<f64>, Refusal> {
    let attributes = measure.attributes(&[Keyword::MeasureWithUnit, Keyword::UncertaintyMeasureWithUnit]);
    let Some(UnitValue::Length(metres)) = value(attributes.reference(1)?, MAX_CONVERSIONS)? else {
        return Ok(None);
    };
    let uncertainty = attributes.number(0)? * metres;
    if uncertainty >= 0.0 && uncertainty.is_finite() {
        Ok(Some(uncertainty))
    } else {
        Err(measure.refuse(format!("the uncertainty is {uncertainty} metres")))
    }
}

/// The index of the list of units in a context: contexts of units alone begin with identifier and type.
fn last(context: Entity<'_>) -> usize {
    if context.keyword() == Keyword::Complex { 0 } else { 2 }
}

/// The value of a unit; `None` if it is neither of length nor of angle.
fn value(unit: Entity<'_>, depth: usize) -> Result<Option<UnitValue>, Refusal> {
    if unit.is(Keyword::SiUnit) {
        return si_value(unit);
    }
    let is_wanted = unit.is(Keyword::LengthUnit) || unit.is(Keyword::PlaneAngleUnit);
    if !unit.is(Keyword::ConversionBasedUnit) || !is_wanted && unit.keyword() == Keyword::Complex {
        return if is_wanted { Err(unit.refuse_type("unit")) } else { Ok(None) };
    }
    let depth = depth.checked_sub(1).ok_or_else(|| unit.refuse("units are defined by one another"))?;
    let measure = unit.attributes(&[Keyword::NamedUnit, Keyword::ConversionBasedUnit]).reference(2)?;
    let attributes = measure.attributes(&[Keyword::MeasureWithUnit]);
    let factor = attributes.number(0)?;
    if factor.is_nan() || factor <= 0.0 {
        return Err(measure.refuse(format!("a unit is {factor} times another; it must be positive")));
    }
    let product = |unit: f64| {
        let product = factor * unit;
        let refusal = || measure.refuse(format!("the factor {factor} makes a unit too large or too small"));
        if product.is_normal() { Ok(product) } else { Err(refusal()) }
    };
    Ok(match value(attributes.reference(1)?, depth)? {
        Some(UnitValue::Length(metres)) => Some(UnitValue::Length(product(metres)?)),
        Some(UnitValue::Angle(radians)) => Some(UnitValue::Angle(product(radians)?)),
        None => None,
    })
}

/// The value of `SI_UNIT(prefix, name)`.
fn si_value(unit: Entity<'_>) -> Result<Option<UnitValue>, Refusal> {
    // A simple instance begins with the dimensions, a complex one with those of NAMED_UNIT, if they are there.
    let attributes = unit.attributes(&[Keyword::SiUnit]);
    let first = usize::from(unit.keyword() != Keyword::Complex);
    let value: fn(f64) -> UnitValue = match attributes.enumeration(first + 1) {
        Some(b"METRE") => UnitValue::Length,
        Some(b"RADIAN") => UnitValue::Angle,
        _ => return Ok(None),
    };
    if attributes.is_missing(first) {
        return Ok(Some(value(1.0)));
    }
    let prefix = attributes.enumeration(first).unwrap_or_default();
    let known = PREFIXES.iter().find(|(name, _)| name.as_bytes() == prefix);
    let (_, factor) = known.ok_or_else(|| unit.refuse("the unit has an unknown prefix"))?;
    Ok(Some(value(*factor)))
}

/// Prefixes of @iso10303-41 with their factors.
const PREFIXES: [(&str, f64); 16] = [
    ("EXA", 1e18),
    ("PETA", 1e15),
    ("TERA", 1e12),
    ("GIGA", 1e9),
    ("MEGA", 1e6),
    ("KILO", 1e3),
    ("HECTO", 1e2),
    ("DECA", 1e1),
    ("DECI", 1e-1),
    ("CENTI", 1e-2),
    ("MILLI", 1e-3),
    ("MICRO", 1e-6),
    ("NANO", 1e-9),
    ("PICO", 1e-12),
    ("FEMTO", 1e-15),
    ("ATTO", 1e-18),
];
