//! EULUMDAT: the format of Europe, one value per line, intensities in candela per 1000 lumens of the lamps.
//!
//! A decimal comma counts as a decimal point. Values that are often missing or empty have defaults, with a warning. Intensities are
//! candela for the first set of lamps; [`Photometry::with_lamps`] selects another. For absolute photometry (a negative
//! number of lamps), the stated flux is that of the luminaire, and intensities are per 1000 lumens of it.
//!
//! # Source
//! @stockmar1990; departure: several sets of lamps are read set by set, and field by field only where the numbers do
//! not fit otherwise, since files of both kinds exist.

use glanz_light::intensity::{AngularSystem, IntensityDistribution, Symmetry};
use glanz_scene::Diagnostics;

use super::clamp_negative;
use super::error::{PhotometryError, PhotometryErrorKind};
use super::ies::ends;
use super::text::{MAX_CANDELA, NumberReader, TextCursor, decode, number};
use super::{
    EulumdatExtra, LampSet, LuminousOpening, Names, OpeningShape, Photometry, PhotometryFile,
    PhotometryFormat,
};

const METRES: f64 = 1e-3;

/// Largest number of sets of lamps, far above that of real files.
const MAX_SETS: f64 = 1000.0;

/// Reads a file.
///
/// # Errors
/// [`PhotometryError`] with its place.
pub fn read(bytes: &[u8]) -> Result<PhotometryFile, PhotometryError> {
    let mut lines = LdtReader { cursor: TextCursor::new(bytes)?, warnings: Vec::new() };
    let manufacturer = lines.text("company")?;
    let luminaire_type = lines.whole("type indicator", "0 to 3", 0.0..=3.0)? as u8;
    let symmetry = lines.whole("symmetry indicator", "0 to 4", 0.0..=4.0)? as u8;
    let planes = lines.count("C planes", 1.0)?;
    lines.number("distance of C planes")?;
    let gammas = lines.count("gamma angles", 1.0)?;
    lines.number("distance of gamma angles")?;
    let names = Names {
        manufacturer,
        report: lines.text("report number")?,
        luminaire: lines.text("luminaire name")?,
        catalog_number: lines.text("luminaire number")?,
        issued: {
            lines.text("file name")?;
            lines.text("date")?
        },
    };
    let housing =
        lines.lengths(["length of the luminaire", "width of the luminaire", "height of the luminaire"])?;
    let area = lines.lengths(["length of the luminous area", "width of the luminous area"])?;
    let side_heights = lines.lengths(["height of the luminous area"; 4])?;
    let downward_fraction = lines.number("downward flux fraction")? / 100.0;
    let light_output_ratio = lines.number("light output ratio")? / 100.0;
    let multiplier = lines.positive("conversion factor")?;
    let measurement_tilt = lines.number("tilt during measurement")?;
    let (lamps, is_absolute) = lines.lamps()?;
    let stored = StoredPlanes::of(symmetry, planes, &lines)?;
    let direct_ratios = lines.direct_ratios(planes + gammas, stored.count.saturating_mul(gammas))?;
    let distribution = lines.distribution(&stored, gammas, multiplier * lamps.flux / 1000.0)?;
    lines.end();
    let input_watts = lamps.sets.first().map_or(0.0, |set| set.watts);
    let photometry = Photometry {
        format: PhotometryFormat::Eulumdat,
        distribution,
        lamps: lamps.sets,
        multiplier,
        ballast_factor: 1.0,
        ballast_lamp_factor: 1.0,
        generation: None,
        input_watts,
        opening: opening(area, side_heights),
        names,
        keywords: Vec::new(),
        tilt: None,
        eulumdat: Some(EulumdatExtra {
            luminaire_type,
            housing: extents(housing[0], housing[1], housing[2]),
            housing_is_round: housing[1] == 0.0,
            side_heights,
            downward_fraction,
            light_output_ratio,
            measurement_tilt,
            direct_ratios,
        }),
        is_absolute,
    };
    Ok(PhotometryFile { photometry, warnings: lines.warnings })
}

/// Extents along x, y, z: the length is along y; a width of 0 means a round luminaire.
fn extents(length: f64, width: f64, height: f64) -> [f64; 3] {
    [if width == 0.0 { length } else { width }, length, height]
}

fn opening([length, width]: [f64; 2], heights: [f64; 4]) -> LuminousOpening {
    let height = heights.into_iter().fold(0.0, f64::max);
    let shape = match (length == 0.0 && width == 0.0, width == 0.0, height == 0.0) {
        (true, _, true) => OpeningShape::Point,
        (true, _, false) | (false, false, false) => OpeningShape::Box,
        (false, true, true) => OpeningShape::Ellipse,
        (false, true, false) => OpeningShape::VerticalCylinder,
        (false, false, true) => OpeningShape::Rectangle,
    };
    LuminousOpening { shape, size: extents(length, width, height) }
}

struct LdtLamps {
    sets: Vec<LampSet>,
    /// Flux of the first set.
    flux: f64,
}

/// The planes that are stored for a symmetry.
struct StoredPlanes {
    symmetry: Symmetry,
    /// Planes among the listed angles.
    listed: usize,
    /// Planes among the intensities.
    count: usize,
}

impl StoredPlanes {
    fn of(indicator: u8, listed: usize, lines: &LdtReader) -> Result<Self, PhotometryError> {
        let (symmetry, parts) = match indicator {
            0 if listed == 1 => (Symmetry::Axial, 1),
            0 => (Symmetry::None, 1),
            1 => (Symmetry::Axial, 1),
            2 => (Symmetry::AcrossY, 2),
            3 => (Symmetry::AcrossX, 2),
            _ => (Symmetry::Quadrants, 4),
        };
        if !listed.is_multiple_of(parts) {
            let allowed = "even for symmetries 2 and 3, a multiple of 4 for symmetry 4";
            return Err(lines.value_error("number of C planes", listed as f64, allowed));
        }
        let count = match symmetry {
            Symmetry::Axial => 1,
            Symmetry::None => listed,
            _ => listed / parts + 1,
        };
        Ok(Self { symmetry, listed, count })
    }

    /// The angles of the stored planes in order, those from 270 to 360 as -90 to 0; `None` if they do not cover the
    /// part that the symmetry requires.
    fn azimuths(&self, listed: &[f64]) -> Option<Vec<f64>> {
        let azimuths: Vec<f64> = match self.symmetry {
            Symmetry::AcrossX => {
                let from = listed.iter().position(|&c| c == 270.0)?;
                let turned = listed.get(from..)?.iter().map(|c| c - 360.0);
                turned.chain(listed.iter().copied().take_while(|&c| c <= 90.0)).collect()
            }
            _ => listed.get(..self.count)?.to_vec(),
        };
        let ends = (azimuths.first().copied()?, azimuths.last().copied()?);
        let fits = azimuths.len() == self.count
            && match self.symmetry {
                Symmetry::Axial => true,
                Symmetry::None => ends.0 >= 0.0 && ends.1 <= 360.0,
                Symmetry::AcrossY => ends == (0.0, 180.0),
                Symmetry::AcrossX => ends == (-90.0, 90.0),
                Symmetry::Quadrants => ends == (0.0, 90.0),
            };
        fits.then_some(azimuths)
    }
}

struct LdtReader<'a> {
    cursor: TextCursor<'a>,
    warnings: Vec<PhotometryError>,
}

impl LdtReader<'_> {
    fn text(&mut self, what: &'static str) -> Result<String, PhotometryError> {
        match self.cursor.line() {
            Some(line) => Ok(decode(line)),
            None => {
                self.cursor.last = (self.cursor.bytes.len(), 0);
                Err(self.cursor.here(PhotometryErrorKind::End(what)))
            }
        }
    }

    fn empty(&mut self, what: &'static str) {
        // The line number of every warning requires a scan of the file to that line.
        if self.warnings.len() < Diagnostics::PER_KIND {
            self.warnings.push(self.cursor.here(PhotometryErrorKind::Empty(what)));
        }
    }

    fn lengths<const N: usize>(&mut self, what: [&'static str; N]) -> Result<[f64; N], PhotometryError> {
        let mut lengths = [0.0; N];
        for (length, what) in lengths.iter_mut().zip(what) {
            *length = self.number(what)? * METRES;
            if *length < 0.0 {
                return Err(self.value_error(what, *length / METRES, "0 or more millimetres"));
            }
        }
        Ok(lengths)
    }

    fn lamps(&mut self) -> Result<(LdtLamps, bool), PhotometryError> {
        let count = self.whole("number of sets of lamps", "1 to 1000", 1.0..=MAX_SETS)? as usize;
        let at = self.cursor.last;
        let mut fields = Vec::with_capacity(6 * count);
        let mut places = Vec::with_capacity(6 * count);
        for _ in 0..6 * count {
            fields.push(self.text("data of the lamps")?);
            places.push(self.cursor.last);
        }
        let field =
            |set: usize, i: usize, by_field: bool| if by_field { i * count + set } else { set * 6 + i };
        let fits = |by_field: bool| {
            let is_number =
                |(set, i)| fields.get(field(set, i, by_field)).is_some_and(|f| numeric(f).is_some());
            (0..count).flat_map(|set| [(set, 0), (set, 2), (set, 5)]).all(is_number)
        };
        let by_field = count > 1 && !fits(false) && fits(true);
        if by_field {
            self.warnings
                .push(TextCursor { last: at, ..self.cursor.clone() }.here(PhotometryErrorKind::FieldByField));
        }
        let mut sets = Vec::with_capacity(count);
        for set in 0..count {
            let text = |i| fields.get(field(set, i, by_field)).cloned().unwrap_or_default();
            let mut number = |i, what| {
                let text = text(i);
                self.cursor.last = places.get(field(set, i, by_field)).copied().unwrap_or(at);
                if text.is_empty() {
                    self.empty(what);
                    return Ok(0.0);
                }
                let shown = text.chars().take(40).collect();
                numeric(&text)
                    .ok_or_else(|| self.cursor.here(PhotometryErrorKind::Number { what, text: shown }))
            };
            let count = number(0, "number of lamps")?;
            let watts = number(5, "watts of the lamps")?;
            let lumens = Some(number(2, "flux of the lamps")?);
            sets.push(LampSet { count, lumens, name: text(1), color: text(3), rendering: text(4), watts });
            // Only the first set is needed for the intensities, so only its flux must be above zero.
            if let [LampSet { lumens: Some(lumens), .. }] = sets[..]
                && (lumens <= 0.0 || lumens > MAX_CANDELA)
            {
                return Err(self.value_error("flux of the lamps", lumens, "more than 0"));
            }
        }
        let is_absolute = sets.first().is_some_and(|set| set.count < 0.0);
        for set in &mut sets {
            set.count = set.count.abs();
        }
        let flux = sets.first().and_then(|set| set.lumens).unwrap_or(0.0);
        Ok((LdtLamps { sets, flux }, is_absolute))
    }

    /// The ten ratios, unless exactly ten lines are missing for `angles` and `intensities`.
    fn direct_ratios(
        &mut self,
        angles: usize,
        intensities: usize,
    ) -> Result<Option<[f64; 10]>, PhotometryError> {
        self.cursor.last = (self.cursor.at.min(self.cursor.bytes.len()), 0);
        let rest = self.cursor.bytes.get(self.cursor.at..).unwrap_or_default();
        let blank = |b: &u8| b.is_ascii_whitespace() || *b == 0x1A;
        let end = rest.iter().rposition(|b| !blank(b)).map_or(0, |i| i + 1);
        let present = match rest.get(..end) {
            Some(text) if !text.is_empty() => text.iter().filter(|&&b| b == b'\n').count() + 1,
            _ => 0,
        };
        let needed = angles.saturating_add(intensities);
        if present < needed {
            let (what, declared) = ("angles and intensities", needed as f64);
            return Err(self.cursor.here(PhotometryErrorKind::Count { what, declared, room: present }));
        }
        if present == needed {
            self.warnings.push(self.cursor.here(PhotometryErrorKind::NoDirectRatios));
            return Ok(None);
        }
        let mut ratios = [0.0; 10];
        for ratio in &mut ratios {
            *ratio = self.number("direct ratio")?;
        }
        Ok(Some(ratios))
    }

    fn distribution(
        &mut self,
        planes: &StoredPlanes,
        gammas: usize,
        factor: f64,
    ) -> Result<IntensityDistribution, PhotometryError> {
        let listed = self.ascending("C angle", planes.listed)?;
        let azimuths = planes.azimuths(&listed).ok_or_else(|| {
            let (first, last) = ends(&listed);
            let allowed = "from 0 to below 360, with planes on those of the symmetry";
            self.cursor.here(PhotometryErrorKind::Range { what: "C angles", first, last, allowed })
        })?;
        let polars = self.ascending("gamma angle", gammas)?;
        let (first, last) = ends(&polars);
        if first < 0.0 || last > 180.0 {
            let (what, allowed) = ("gamma angles", "within 0 and 180");
            return Err(self.cursor.here(PhotometryErrorKind::Range { what, first, last, allowed }));
        }
        let mut candela = self.intensities(planes.count * gammas, factor)?;
        self.warnings.extend(clamp_negative(&mut candela).map(|kind| self.cursor.here(kind)));
        IntensityDistribution::try_new(AngularSystem::C, planes.symmetry, &azimuths, polars, candela)
            .map_err(|error| self.cursor.here(PhotometryErrorKind::Intensity(error)))
    }

    /// Warns about content after the last value.
    fn end(&mut self) {
        while let Some(line) = self.cursor.line() {
            if !line.is_empty() && line != [0x1A] {
                self.warnings.push(self.cursor.here(PhotometryErrorKind::Trailing));
                return;
            }
        }
    }
}

impl NumberReader for LdtReader<'_> {
    fn number(&mut self, what: &'static str) -> Result<f64, PhotometryError> {
        let line = self.text(what)?;
        if line.is_empty() {
            self.empty(what);
            return Ok(0.0);
        }
        numeric(&line).ok_or_else(|| {
            let text = line.chars().take(40).collect();
            self.cursor.here(PhotometryErrorKind::Number { what, text })
        })
    }

    fn cursor(&self) -> &TextCursor<'_> {
        &self.cursor
    }
}

/// The number at the beginning of a line, with decimal point or comma.
fn numeric(line: &str) -> Option<f64> {
    number(&line.split_whitespace().next()?.replace(',', "."))
}
