//! IES LM-63: the format of North America, in its editions of 1986, 1991, 1995, 2002 and 2019.
//!
//! A line with the edition (none in 1986), lines `[KEYWORD] text`, a line `TILT=`, then numbers over any number of
//! lines with blanks, commas or line ends between them. Text may be ASCII, UTF-8 or Windows-1252.
//!
//! | type | horizontal angles | symmetry |
//! |---|---|---|
//! | C | 0; 0 to 90; 0 to 180; 90 to 270; 0 to 360 | axial; quadrants; across y; across x; none |
//! | A, B | 0 to 90; from below 0 | across y; none |
//!
//! Vertical angles are never mirrored: outside those given there is no light.
//!
//! # Source
//! @lm63_2019, @lm63_2002; @ashdown1998 for the earlier editions.

use glanz_light::intensity::{AngularSystem, IntensityDistribution, IntensityError, Symmetry};

use super::clamp_negative;
use super::error::{PhotometryError, PhotometryErrorKind};
use super::opening::from_signs;
use super::text::{NumberReader, TextCursor, decode};
use super::{
    LampGeometry, LampSet, LuminousOpening, Names, OpeningShape, Photometry, PhotometryFile,
    PhotometryFormat, Tilt,
};

/// Reader of the file that a line `TILT=name` names: returns its bytes, or the reason why it cannot be read.
pub type TiltFiles<'a> = dyn FnMut(&str) -> Result<Vec<u8>, String> + 'a;

/// Reads a file whose tilt data, if any, are in the file itself.
///
/// # Errors
/// [`PhotometryError`] with its place.
pub fn read(bytes: &[u8]) -> Result<PhotometryFile, PhotometryError> {
    read_with(bytes, &mut |_| Err("other files cannot be read here".to_owned()))
}

/// As [`read`], with a reader for the file that a line `TILT=name` names.
///
/// # Errors
/// [`PhotometryError`] with its place.
pub fn read_with(bytes: &[u8], tilt_files: &mut TiltFiles) -> Result<PhotometryFile, PhotometryError> {
    let mut cursor = TextCursor::new(bytes)?;
    let mut warnings = Vec::new();
    let head = IesHeader::read(&mut cursor, &mut warnings)?;
    let tilt = match head.tilt.to_ascii_uppercase().as_str() {
        "NONE" => None,
        "INCLUDE" => Some(read_tilt(&mut cursor)?),
        _ => Some(tilt_of_file(&head.tilt, &cursor, tilt_files)?),
    };
    let lamps = LampFields::read(&mut cursor, head.year, &mut warnings)?;
    let values = IesValues::read(&mut cursor, &lamps, &mut warnings)?;
    if cursor.has_more() {
        let mut behind = cursor.clone();
        let _ = behind.number("end");
        warnings.push(behind.here(PhotometryErrorKind::Trailing));
    }
    let distribution = values
        .distribution(lamps.system)
        .map_err(|error| cursor.here(PhotometryErrorKind::Intensity(error)))?;
    let is_absolute = lamps.lumens < 0.0;
    let set = LampSet {
        count: lamps.count,
        lumens: (!is_absolute).then_some(lamps.lumens * lamps.count),
        name: head.value("LAMP"),
        watts: lamps.watts,
        ..LampSet::default()
    };
    let names = Names {
        manufacturer: head.value("MANUFAC"),
        luminaire: head.value("LUMINAIRE"),
        catalog_number: head.value("LUMCAT"),
        report: head.value("TEST"),
        issued: head.value("ISSUEDATE"),
    };
    let photometry = Photometry {
        format: PhotometryFormat::Ies(head.year),
        distribution,
        lamps: vec![set],
        multiplier: lamps.multiplier,
        ballast_factor: lamps.ballast,
        ballast_lamp_factor: lamps.ballast_lamp,
        generation: lamps.generation,
        input_watts: lamps.watts,
        opening: lamps.opening,
        names,
        keywords: head.keywords,
        tilt,
        eulumdat: None,
        is_absolute,
    };
    Ok(PhotometryFile { photometry, warnings })
}

/// The lines before the numbers.
struct IesHeader {
    year: u16,
    keywords: Vec<(String, String)>,
    /// Value of `TILT=`.
    tilt: String,
}

impl IesHeader {
    fn read(cursor: &mut TextCursor, warnings: &mut Vec<PhotometryError>) -> Result<Self, PhotometryError> {
        let mut head = Self { year: 1986, keywords: Vec::new(), tilt: String::new() };
        let mut is_first = true;
        while let Some(line) = cursor.line() {
            if line.is_empty() {
                continue;
            }
            let is_edition = std::mem::take(&mut is_first) && starts_with(line, b"IES");
            if is_edition {
                head.year = edition(line).unwrap_or_else(|| {
                    let shown = decode(line.get(..line.len().min(40)).unwrap_or_default());
                    warnings.push(cursor.here(PhotometryErrorKind::Edition(shown)));
                    2019
                });
            } else if starts_with(line, b"TILT=") {
                head.tilt = decode(line.get(5..).unwrap_or_default()).trim().to_owned();
                return Ok(head);
            } else {
                head.add(&decode(line));
            }
        }
        Err(cursor.here(PhotometryErrorKind::NoTilt))
    }

    fn add(&mut self, line: &str) {
        let keyword = line.strip_prefix('[').and_then(|l| l.split_once(']'));
        let (keyword, text) = keyword.map_or((String::new(), line), |(k, t)| (k.to_ascii_uppercase(), t));
        match self.keywords.last_mut() {
            Some((_, before)) if keyword == "MORE" => {
                before.push('\n');
                before.push_str(text.trim());
            }
            _ => self.keywords.push((keyword, text.trim().to_owned())),
        }
    }

    fn value(&self, keyword: &str) -> String {
        self.keywords.iter().find(|(k, _)| k == keyword).map_or_else(String::new, |(_, v)| v.clone())
    }
}

fn starts_with(line: &[u8], word: &[u8]) -> bool {
    line.get(..word.len()).is_some_and(|l| l.eq_ignore_ascii_case(word))
}

fn edition(line: &[u8]) -> Option<u16> {
    let line = decode(line).to_ascii_uppercase();
    let tag = line.split_whitespace().next()?;
    Some(match tag {
        "IESNA86" | "IESNA:LM-63-1986" => 1986,
        "IESNA91" | "IESNA:LM-63-1991" => 1991,
        "IESNA:LM-63-1995" | "IESNA:LM-63-95" => 1995,
        "IESNA:LM-63-2002" | "IESNA:LM-63-02" => 2002,
        "IES:LM-63-2019" | "IESNA:LM-63-2019" | "IES:LM-63-19" => 2019,
        _ => return None,
    })
}

fn read_tilt(cursor: &mut TextCursor) -> Result<Tilt, PhotometryError> {
    let geometry = match cursor.whole("lamp-to-luminaire geometry", "1, 2 or 3", 1.0..=3.0)? {
        1.0 => LampGeometry::Vertical,
        2.0 => LampGeometry::Horizontal,
        _ => LampGeometry::Tilting,
    };
    let count = cursor.count("tilt angles", 1.0)?;
    cursor.check_room("tilt angles", 2 * count)?;
    let angles = cursor.ascending("tilt angle", count)?;
    let factors = (0..count).map(|_| cursor.number("tilt factor")).collect::<Result<_, _>>()?;
    Ok(Tilt { geometry, angles, factors })
}

fn tilt_of_file(
    name: &str,
    cursor: &TextCursor,
    tilt_files: &mut TiltFiles,
) -> Result<Tilt, PhotometryError> {
    let read = |bytes: Vec<u8>| {
        TextCursor::new(&bytes).and_then(|mut c| read_tilt(&mut c)).map_err(|fault| fault.to_string())
    };
    tilt_files(name).and_then(read).map_err(|reason| {
        let name = name.chars().take(200).collect();
        cursor.here(PhotometryErrorKind::TiltFile { name, reason })
    })
}

/// The thirteen numbers before the angles.
struct LampFields {
    count: f64,
    lumens: f64,
    multiplier: f64,
    verticals: usize,
    horizontals: usize,
    system: AngularSystem,
    opening: LuminousOpening,
    ballast: f64,
    ballast_lamp: f64,
    generation: Option<f64>,
    watts: f64,
}

impl LampFields {
    fn read(
        cursor: &mut TextCursor,
        year: u16,
        warnings: &mut Vec<PhotometryError>,
    ) -> Result<Self, PhotometryError> {
        let lamp_count = cursor.number("number of lamps")?;
        if lamp_count < 0.0 {
            return Err(cursor.value_error("number of lamps", lamp_count, "0 or more"));
        }
        let lumens = cursor.number("lumens per lamp")?;
        let multiplier = cursor.positive("candela multiplier")?;
        let verticals = cursor.count("vertical angles", 2.0)?;
        let horizontals = cursor.count("horizontal angles", 1.0)?;
        cursor.check_room("intensities", verticals.saturating_mul(horizontals))?;
        let system = match cursor.whole("photometric type", "1 (C), 2 (B) or 3 (A)", 1.0..=3.0)? {
            1.0 => AngularSystem::C,
            2.0 => AngularSystem::B,
            _ => AngularSystem::A,
        };
        let unit = cursor.whole("unit", "1 (feet) or 2 (metres)", 1.0..=2.0)?;
        let metres = if unit == 1.0 { 0.3048 } else { 1.0 };
        let width = cursor.number("width of the opening")?;
        let length = cursor.number("length of the opening")?;
        let height = cursor.number("height of the opening")?;
        let opening = from_signs(width, length, height, metres, year <= 1995).unwrap_or_else(|| {
            warnings.push(cursor.here(PhotometryErrorKind::Opening(width, length, height)));
            let size = [length, width, height].map(|v| v.abs() * metres);
            LuminousOpening { shape: OpeningShape::Box, size }
        });
        let ballast = cursor.positive("ballast factor")?;
        let code = cursor.number("ballast-lamp photometric factor")?;
        let (mut ballast_lamp, mut generation) = (1.0, None);
        match year {
            1986 | 1991 if code > 0.0 => ballast_lamp = code,
            // Since 2019 the field is the generation type; from 1995 until then it was reserved for future use.
            2019 => generation = Some(code),
            _ if code != 1.0 => warnings.push(cursor.here(PhotometryErrorKind::FutureUse(code))),
            _ => {}
        }
        let watts = cursor.number("input watts")?;
        Ok(Self {
            count: lamp_count,
            lumens,
            multiplier,
            verticals,
            horizontals,
            system,
            opening,
            ballast,
            ballast_lamp,
            generation,
            watts,
        })
    }
}

/// Angles and intensities of the file, with factors applied.
struct IesValues {
    verticals: Vec<f64>,
    horizontals: Vec<f64>,
    symmetry: Symmetry,
    candela: Vec<f64>,
}

impl IesValues {
    fn read(
        cursor: &mut TextCursor,
        lamps: &LampFields,
        warnings: &mut Vec<PhotometryError>,
    ) -> Result<Self, PhotometryError> {
        let verticals = cursor.ascending("vertical angle", lamps.verticals)?;
        let (first, last) = ends(&verticals);
        let (least, most, allowed) = match lamps.system {
            AngularSystem::C => (0.0, 180.0, "within 0 and 180"),
            AngularSystem::A | AngularSystem::B => (-90.0, 90.0, "within -90 and 90"),
        };
        if first < least || last > most {
            return Err(cursor.here(PhotometryErrorKind::Range {
                what: "vertical angles",
                first,
                last,
                allowed,
            }));
        }
        let horizontals = cursor.ascending("horizontal angle", lamps.horizontals)?;
        let symmetry = symmetry(lamps.system, &horizontals).map_err(|allowed| {
            let (first, last) = ends(&horizontals);
            cursor.here(PhotometryErrorKind::Range { what: "horizontal angles", first, last, allowed })
        })?;
        let (_, last) = ends(&horizontals);
        if lamps.system == AngularSystem::C && symmetry == Symmetry::None && last < 360.0 {
            warnings.push(cursor.here(PhotometryErrorKind::Open(last)));
        }
        let factor = lamps.multiplier * lamps.ballast * lamps.ballast_lamp;
        let n = verticals.len();
        let mut candela = cursor.intensities(n * horizontals.len(), factor)?;
        warnings.extend(clamp_negative(&mut candela).map(|kind| cursor.here(kind)));
        if lamps.system == AngularSystem::C
            && last == 360.0
            && candela.get(..n) != candela.get(candela.len().saturating_sub(n)..)
        {
            warnings.push(cursor.here(PhotometryErrorKind::Seam));
        }
        Ok(Self { verticals, horizontals, symmetry, candela })
    }

    fn distribution(self, system: AngularSystem) -> Result<IntensityDistribution, IntensityError> {
        let Self { verticals, horizontals, symmetry, candela } = self;
        let from_pole = |angles: &[f64]| angles.iter().map(|a| a + 90.0).collect::<Vec<f64>>();
        match system {
            AngularSystem::C => {
                IntensityDistribution::try_new(system, symmetry, &horizontals, verticals, candela)
            }
            AngularSystem::A => {
                IntensityDistribution::try_new(system, symmetry, &horizontals, from_pole(&verticals), candela)
            }
            AngularSystem::B => {
                // In type B, the horizontal angles are measured towards the axis, so they become polar angles.
                let mut columns: Vec<(f64, usize)> = horizontals.iter().copied().zip(0..).collect();
                if symmetry == Symmetry::AcrossY {
                    let mirrored = columns.iter().filter(|(h, _)| *h > 0.0).map(|&(h, i)| (-h, i));
                    columns = mirrored.rev().chain(columns.iter().copied()).collect();
                }
                let n = verticals.len();
                let across = |v: usize| {
                    let candela = &candela;
                    columns.iter().map(move |&(_, h)| candela.get(h * n + v).copied().unwrap_or(0.0))
                };
                let turned = (0..n).flat_map(across).collect();
                let polars: Vec<f64> = columns.iter().map(|(h, _)| h + 90.0).collect();
                IntensityDistribution::try_new(system, symmetry, &verticals, polars, turned)
            }
        }
    }
}

/// Symmetry from the range of the horizontal angles, or the valid ranges.
fn symmetry(system: AngularSystem, horizontals: &[f64]) -> Result<Symmetry, &'static str> {
    let (first, last) = ends(horizontals);
    if system != AngularSystem::C {
        return match (first, last) {
            (0.0, 90.0) => Ok(Symmetry::AcrossY),
            _ if first >= -90.0 && last <= 90.0 && first < 0.0 && last > first => Ok(Symmetry::None),
            _ => Err("0 to 90 or -90 to 90 for types A and B"),
        };
    }
    if horizontals.len() == 1 {
        return Ok(Symmetry::Axial);
    }
    let widest = horizontals.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
    match (first, last) {
        (0.0, 90.0) => Ok(Symmetry::Quadrants),
        (0.0, 180.0) => Ok(Symmetry::AcrossY),
        (90.0, 270.0) => Ok(Symmetry::AcrossX),
        (0.0, 360.0) => Ok(Symmetry::None),
        // Not allowed, but it occurs: the plane at 360 is omitted.
        (0.0, last) if last < 360.0 && 360.0 - last <= 1.5 * widest => Ok(Symmetry::None),
        _ => Err("0 to 0, 90, 180 or 360, or 90 to 270 for type C"),
    }
}

pub(super) fn ends(angles: &[f64]) -> (f64, f64) {
    (angles.first().copied().unwrap_or(0.0), angles.last().copied().unwrap_or(0.0))
}
