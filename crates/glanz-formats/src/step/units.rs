//! Units and uncertainty of representation contexts.

use super::part21::{Entity, Keyword, Refusal};

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
    /// The units and the uncertainty that a context assigns.
    ///
    /// # Errors
    /// A unit of length or angle that cannot be read.
    pub(super) fn of_context(context: Entity<'_>) -> Result<Self, Refusal> {
        let mut units = Self::default();
        if context.is(Keyword::GlobalUnitAssignedContext) {
            for unit in context.attributes(&[Keyword::GlobalUnitAssignedContext]).references(last(context))? {
                match value(unit?, MAX_CONVERSIONS)? {
                    Some(UnitValue::Length(metres)) => units.length = Some(metres),
                    Some(UnitValue::Angle(radians)) => units.angle = Some(radians),
                    None => {}
                }
            }
        }
        if context.keyword() == Keyword::Complex && context.is(Keyword::GlobalUncertaintyAssignedContext) {
            for measure in context.attributes(&[Keyword::GlobalUncertaintyAssignedContext]).references(0)? {
                let attributes =
                    measure?.attributes(&[Keyword::MeasureWithUnit, Keyword::UncertaintyMeasureWithUnit]);
                if let Some(UnitValue::Length(metres)) = value(attributes.reference(1)?, MAX_CONVERSIONS)? {
                    let uncertainty = attributes.number(0)? * metres;
                    units.uncertainty =
                        units.uncertainty.max(if uncertainty.is_finite() { uncertainty } else { 0.0 });
                }
            }
        }
        Ok(units)
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
    Ok(match value(attributes.reference(1)?, depth)? {
        Some(UnitValue::Length(metres)) => Some(UnitValue::Length(factor * metres)),
        Some(UnitValue::Angle(radians)) => Some(UnitValue::Angle(factor * radians)),
        None => None,
    })
}

/// The value of `SI_UNIT(prefix, name)`.
fn si_value(unit: Entity<'_>) -> Result<Option<UnitValue>, Refusal> {
    // A simple instance begins with the dimensions, a complex one with those of NAMED_UNIT, if they are there.
    let attributes = unit.attributes(&[Keyword::SiUnit]);
    let first = usize::from(unit.keyword() != Keyword::Complex);
    let factor = match attributes.enumeration(first) {
        None => 1.0,
        Some(prefix) => {
            let known = PREFIXES.iter().find(|(name, _)| name.as_bytes() == prefix);
            known.ok_or_else(|| unit.refuse("the unit has an unknown prefix"))?.1
        }
    };
    Ok(match attributes.enumeration(first + 1) {
        Some(b"METRE") => Some(UnitValue::Length(factor)),
        Some(b"RADIAN") => Some(UnitValue::Angle(factor)),
        _ => None,
    })
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
