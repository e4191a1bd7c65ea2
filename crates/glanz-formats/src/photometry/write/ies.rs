//! Writing of LM-63 files.

use super::{Header, PhotometryWriteError, PlaneSelection, digits, one_line};
use crate::photometry::{IntensityDistribution, LuminousOpening, OpeningShape};

/// Largest number of characters of a line; the standard allows 256 with the line end.
const LINE: usize = 120;
const WORDS: usize = 200;

/// Sizes are rounded to multiples of its reciprocal, metres.
const MICROMETRES: f64 = 1e6;

/// A file of IES LM-63-2002: type C, absolute photometry (one lamp of -1 lumens), sizes in metres.
///
/// The four required keywords are always present, with `N/A` for unknown values; the total flux
/// follows `[OTHER]`, for people. Characters outside ASCII become question marks. Watts that are not a
/// finite number above 0 are written as 0.
///
/// # Errors
/// [`PhotometryWriteError`], but not [`PhotometryWriteError::Dark`].
///
/// # Source
/// @lm63_2002.
pub fn ies(distribution: &IntensityDistribution, header: &Header) -> Result<Vec<u8>, PhotometryWriteError> {
    let stored = PlaneSelection::of(distribution)?;
    let mut lines = vec!["IESNA:LM-63-2002".to_owned()];
    let names = &header.names;
    let flux = format!("Absolute photometry of {} lm", digits(distribution.flux()));
    for (keyword, words, is_owed) in [
        ("TEST", &names.report, true),
        ("TESTLAB", &header.laboratory, true),
        ("ISSUEDATE", &names.issued, true),
        ("MANUFAC", &names.manufacturer, true),
        ("LUMCAT", &names.catalog_number, false),
        ("LUMINAIRE", &names.luminaire, false),
        ("OTHER", &flux, false),
    ] {
        let words = ascii(&one_line(words, WORDS));
        if !words.is_empty() {
            lines.push(format!("[{keyword}] {words}"));
        } else if is_owed {
            lines.push(format!("[{keyword}] N/A"));
        }
    }
    lines.push("TILT=NONE".to_owned());
    let (verticals, horizontals) = (distribution.polars(), &stored.planes);
    let [width, length, height] = signs(header.opening);
    lines.push(format!("1 -1 1 {} {} 1 2 {width} {length} {height}", verticals.len(), horizontals.len()));
    let watts = if header.watts.is_finite() { header.watts.max(0.0) } else { 0.0 };
    lines.push(format!("1 1 {watts}"));
    numbers(&mut lines, verticals.iter().map(f64::to_string));
    let azimuths = distribution.azimuths();
    numbers(&mut lines, horizontals.iter().filter_map(|i| azimuths.get(*i)).map(f64::to_string));
    for plane in horizontals {
        numbers(&mut lines, distribution.plane(*plane).iter().copied().map(digits));
    }
    Ok((lines.join("\r\n") + "\r\n").into_bytes())
}

/// Numbers, wrapped to lines.
fn numbers(lines: &mut Vec<String>, numbers: impl Iterator<Item = String>) {
    let mut line = String::new();
    for number in numbers {
        if !line.is_empty() && line.len() + 1 + number.len() > LINE {
            lines.push(std::mem::take(&mut line));
        }
        if !line.is_empty() {
            line.push(' ');
        }
        line += &number;
    }
    lines.push(line);
}

fn ascii(words: &str) -> String {
    words.chars().map(|letter| if letter.is_ascii() { letter } else { '?' }).collect()
}

/// Width (along y), length (along x) and height in metres, negative where round, as in the table of 2002.
fn signs(opening: LuminousOpening) -> [f64; 3] {
    let micrometres = |metres: f64| (metres * MICROMETRES).round() / MICROMETRES;
    let [x, y, z] = opening.size.map(|size| if size.is_finite() { micrometres(size.max(0.0)) } else { 0.0 });
    match opening.shape {
        OpeningShape::Point => [0.0; 3],
        OpeningShape::Rectangle => [y, x, 0.0],
        OpeningShape::Box => [y, x, z],
        OpeningShape::Ellipse => [-y, -x, 0.0],
        OpeningShape::VerticalCylinder => [-y, -x, z],
        OpeningShape::Ellipsoid => [-y, -x, -z],
        OpeningShape::CylinderAlongX => [-y, x, -z],
        OpeningShape::CylinderAlongY => [y, -x, -z],
        OpeningShape::EllipseFacingX => [-y, 0.0, -z],
    }
}
