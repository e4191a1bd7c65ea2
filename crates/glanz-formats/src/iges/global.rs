//! The global section: delimiters, units, scale and resolution.

use crate::cad::{EntityNote, ReadingReport};

use super::records::IgesRecord;
use super::values::{FreeText, FreeValue, ValueEnd};

/// What the global section tells about a file.
#[derive(Clone, Debug)]
pub(super) struct GlobalSection {
    /// Parameter and record delimiter.
    pub(super) delimiters: [u8; 2],
    /// Name of the product, or of the file.
    pub(super) product: String,
    /// Metres per unit of the coordinates.
    pub(super) length: f64,
    /// Distance below which points coincide, in units of the file.
    pub(super) resolution: f64,
}

/// Resolution of files that state none, in units of the file: that of OpenCascade.
const DEFAULT_RESOLUTION: f64 = 1e-4;

/// Names of units, with metres.
const UNIT_NAMES: [(&str, f64); 17] = [
    ("IN", 0.0254),
    ("INCH", 0.0254),
    ("MM", 1e-3),
    ("FT", 0.3048),
    ("FEET", 0.3048),
    ("MI", 1609.344),
    ("M", 1.0),
    ("METER", 1.0),
    ("KM", 1e3),
    ("MIL", 2.54e-5),
    ("UM", 1e-6),
    ("MICRON", 1e-6),
    ("CM", 1e-2),
    ("UIN", 2.54e-8),
    ("MILLIMETER", 1e-3),
    ("CENTIMETER", 1e-2),
    ("INCHES", 0.0254),
];

/// Metres by the flag of the unit.
fn flagged_unit(flag: f64) -> Option<f64> {
    let flags = [0.0254, 1e-3, f64::NAN, 0.3048, 1609.344, 1.0, 1e3, 2.54e-5, 1e-6, 1e-2, 2.54e-8]
        .into_iter()
        .zip(1..);
    flags.into_iter().find_map(|(unit, i)| (f64::from(i) == flag && !unit.is_nan()).then_some(unit))
}

impl GlobalSection {
    /// Reads the section; what is missing or invalid is a repair.
    pub(super) fn parse(records: &[IgesRecord<'_>], report: &mut ReadingReport) -> Self {
        let (delimiters, values) = values(records, report);
        let number = |i: usize| match values.get(i - 3) {
            Some(FreeValue::Number(value)) => Some(*value),
            _ => None,
        };
        let text = |i: usize| match values.get(i - 3) {
            Some(FreeValue::Text(text)) => text.as_str(),
            _ => "",
        };
        let mut repair = |reason: String| {
            let position = records.first().map(|record| [record.line, 1]);
            report.repairs.push_with(|| EntityNote { entity: None, position, reason });
        };
        let name = text(15).to_ascii_uppercase();
        let named = UNIT_NAMES.iter().find(|(known, _)| *known == name).map(|(_, unit)| *unit);
        let unit = number(14).and_then(flagged_unit).or(named).unwrap_or_else(|| {
            repair("no known unit of length is given; inches are taken, the default of IGES".to_owned());
            0.0254
        });
        let scale = number(13).unwrap_or(1.0);
        let scale = if scale > 0.0 && (unit / scale).is_normal() {
            scale
        } else {
            repair(format!("the scale of the model is {scale}; 1 is taken"));
            1.0
        };
        let resolution = number(19).filter(|resolution| *resolution > 0.0);
        if resolution.is_none() {
            repair(format!("no resolution is given; {DEFAULT_RESOLUTION} of the unit is taken"));
        }
        let version = number(23).map_or("IGES".to_owned(), |flag| format!("IGES, version flag {flag}"));
        report.schemas.push(version);
        let product = [text(3), text(4)].into_iter().find(|text| !text.is_empty()).unwrap_or_default();
        Self {
            delimiters,
            product: product.to_owned(),
            length: unit / scale,
            resolution: resolution.unwrap_or(DEFAULT_RESOLUTION),
        }
    }
}

/// The delimiters, and the values from the third on.
fn values(records: &[IgesRecord<'_>], report: &mut ReadingReport) -> ([u8; 2], Vec<FreeValue>) {
    let mut text = FreeText::new(records, 72, *b",;");
    for i in 0..2 {
        let start = text;
        let prefix = [text.next_byte(), text.next_byte(), text.next_byte()];
        let [parameter, record] = text.delimiters;
        let given = match prefix {
            [Some(b'1'), Some(b'H'), Some(delimiter)] if delimiter.is_ascii_punctuation() => Some(delimiter),
            _ => None,
        };
        if let Some(delimiter) = given {
            text.delimiters = if i == 0 { [delimiter, record] } else { [parameter, delimiter] };
            // Behind the value is a delimiter, the first of them already the one that is stated.
            text.next_byte();
        } else {
            text = start;
            text.next_byte();
        }
    }
    let mut values = Vec::new();
    // The section has 26 values.
    while values.len() < 64 {
        let position = text.position();
        let (value, end) = text.value();
        if let FreeValue::Invalid(reason) = value {
            let reason = reason.to_owned();
            report.faults.push_with(|| EntityNote { entity: None, position, reason });
        }
        values.push(value);
        if end != ValueEnd::Parameter {
            break;
        }
    }
    if let Some(lost) = text.lost {
        let reason = format!("record {lost} of the global section is missing; what follows is left out");
        report.faults.push_with(|| EntityNote { entity: None, position: None, reason });
    }
    (text.delimiters, values)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn global(text: &str) -> (GlobalSection, ReadingReport) {
        let mut report = ReadingReport::default();
        let records: Vec<IgesRecord<'_>> = text
            .as_bytes()
            .chunks(72)
            .zip(1..)
            .map(|(text, line)| IgesRecord { text, line, number: line })
            .collect();
        (GlobalSection::parse(&records, &mut report), report)
    }

    #[test]
    fn delimiters_units_and_scale_are_read() {
        let (section, report) = global(",,4Hpart,,,,32,38,6,308,15,,0.5,2,2HMM,1,0.01,,0.001,1.,,,11,0,;");
        assert_eq!((section.delimiters, section.product.as_str()), (*b",;", "part"));
        assert_eq!((section.length, section.resolution), (2e-3, 1e-3));
        assert_eq!(report.repairs.count() + report.faults.count(), 0);
        let (section, _) = global("1H//1H#/4Hpart//////////4./3/2HCM/1/0.01//0.5#");
        assert_eq!((section.delimiters, section.product.as_str()), (*b"/#", "part"));
        assert_eq!((section.length, section.resolution), (2.5e-3, 0.5));
    }

    #[test]
    fn lost_record_is_a_fault_and_ends_the_section() {
        let text = ",,4Hpart,,,,32,38,6,308,15,,1.,2,2HMM,1,0.01,,0.001,1.,,,11,0,;";
        let (first, last) = text.as_bytes().split_at(40);
        let record = |text, number| IgesRecord { text, line: number, number };
        let mut report = ReadingReport::default();
        let section = GlobalSection::parse(&[record(first, 1), record(last, 3)], &mut report);
        // The unit stands in front of it, the resolution behind.
        assert_eq!((section.product.as_str(), section.length, section.resolution), ("part", 1e-3, 1e-4));
        assert!(report.faults.notes()[0].reason.contains("record 2 of the global section is missing"));
        assert_eq!((report.faults.count(), report.repairs.count()), (1, 1));
    }

    #[test]
    fn what_is_missing_is_a_repair() {
        let (section, report) = global(",,4Hpart;");
        assert_eq!((section.length, section.resolution), (0.0254, 1e-4));
        assert_eq!(report.repairs.count(), 2);
    }
}
