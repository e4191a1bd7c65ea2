//! The header of ray files.

use std::io::{ErrorKind, Read};

use super::{MAGIC, Tm25Error, Tm25ErrorKind};

/// Spectral data of the rays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SpectralData {
    /// No spectral data.
    None,
    /// All rays have this wavelength in nanometres.
    Single(f32),
    /// Each ray has its own.
    PerRay,
    /// All rays have the spectrum of the first table.
    Shared,
    /// Each ray has one of the tables.
    Indexed,
}

/// A spectrum: pairs of wavelength in nanometres and relative weight.
pub type SpectralTable = Vec<[f32; 2]>;

/// Texts about the source. Empty where missing in the file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SourceDescriptions {
    /// Name of the light source.
    pub name: String,
    /// Its maker.
    pub manufacturer: String,
    /// Creator of the model.
    pub model_creator: String,
    /// Creator of the file.
    pub file_creator: String,
    /// Measuring equipment or simulation program.
    pub equipment: String,
    /// Camera.
    pub camera: String,
    /// Operating conditions of the source.
    pub operation: String,
    /// Additional text.
    pub information: String,
    /// Reference to a description of the data.
    pub reference: String,
}

/// The header of a ray file.
#[derive(Clone, Debug, PartialEq)]
pub struct RayFileHeader {
    /// Creation method: 0 simulation, 1 measurement; some files have other numbers.
    pub creation: i32,
    /// Luminous flux of all rays, lm; `None` if not given.
    pub luminous_flux: Option<f32>,
    /// Radiant flux of all rays, W; `None` if not given.
    pub radiant_flux: Option<f32>,
    /// Number of rays, as declared.
    pub ray_count: u64,
    /// Date and time of the file, as written.
    pub date: String,
    /// The surface on which rays start, as coded by the standard.
    pub start_position: i32,
    /// Spectral data of the rays.
    pub spectral_data: SpectralData,
    /// Smallest and largest wavelength in nanometres, as written; NaN if unknown.
    pub wavelengths: [f32; 2],
    /// Rays have a radiant flux.
    pub has_radiant_flux: bool,
    /// Rays have a wavelength.
    pub has_wavelength: bool,
    /// Rays have a luminous flux.
    pub has_luminous_flux: bool,
    /// Rays have Stokes parameters.
    pub has_stokes: bool,
    /// Rays have tristimulus values.
    pub has_tristimulus: bool,
    /// Rays have the number of a spectral table.
    pub has_spectrum_index: bool,
    /// Texts about the source.
    pub descriptions: SourceDescriptions,
    /// Spectral tables.
    pub spectra: Vec<SpectralTable>,
    /// Names of additional columns.
    pub additional_columns: Vec<String>,
    /// More text.
    pub additional_text: String,
}

impl RayFileHeader {
    /// Size of the record of a ray, bytes.
    #[must_use]
    pub fn ray_bytes(&self) -> usize {
        let single =
            [self.has_radiant_flux, self.has_wavelength, self.has_luminous_flux, self.has_spectrum_index];
        let columns = 6
            + single.into_iter().filter(|&has| has).count()
            + if self.has_stokes { 6 } else { 0 }
            + if self.has_tristimulus { 2 } else { 0 }
            + self.additional_columns.len();
        4 * columns
    }
}

/// Largest numbers of spectral tables, of pairs in all of them, of additional columns and of bytes of additional text. The length of a stream
/// is unknown, so these limits bound memory for damaged counts; real files are far below.
const MAX_TABLES: i32 = 1 << 16;
const MAX_PAIRS: usize = 1 << 22;
const MAX_COLUMNS: i32 = 1 << 10;
const MAX_TEXT: i32 = 1 << 24;

/// Reads the header; returns it with its length in bytes.
pub(super) fn read(source: &mut impl Read) -> Result<(RayFileHeader, u64), Tm25Error> {
    let mut bytes = HeaderReader { source, offset: 0 };
    match bytes.header() {
        Ok(header) => Ok((header, bytes.offset)),
        Err(kind) => Err(Tm25Error { offset: bytes.offset, kind }),
    }
}

struct HeaderReader<'a, R> {
    source: &'a mut R,
    offset: u64,
}

impl<R: Read> HeaderReader<'_, R> {
    fn header(&mut self) -> Result<RayFileHeader, Tm25ErrorKind> {
        const WHERE: &str = "file header";
        if self.take::<4>("first four bytes")? != *MAGIC {
            return Err(Tm25ErrorKind::Magic);
        }
        let version = self.int(WHERE)?;
        if version != 2013 {
            return Err(Tm25ErrorKind::Version(version));
        }
        let creation = self.int(WHERE)?;
        let luminous_flux = self.flux("luminous flux")?;
        let radiant_flux = self.flux("radiant flux")?;
        let ray_count = u64::from_le_bytes(self.take(WHERE)?);
        let date = self.take::<28>(WHERE)?;
        let date = date.split(|&b| b == 0).next().unwrap_or_default();
        let date = String::from_utf8_lossy(date).trim().to_owned();
        let start_position = self.int(WHERE)?;
        let identifier = self.count("spectral data identifier", "0 to 4", 4)?;
        let wavelength = self.float(WHERE)?;
        let spectral_data = match identifier {
            0 => SpectralData::None,
            1 if wavelength.is_finite() && wavelength > 0.0 => SpectralData::Single(wavelength),
            1 => return Err(value("wavelength", wavelength, "more than 0")),
            2 => SpectralData::PerRay,
            3 => SpectralData::Shared,
            _ => SpectralData::Indexed,
        };
        let wavelengths = [self.float(WHERE)?, self.float(WHERE)?];
        let tables = self.count("number of spectral tables", "0 to 65536", MAX_TABLES)?;
        let columns = self.count("number of additional columns", "0 to 1024", MAX_COLUMNS)?;
        let text_bytes = self.count("size of the additional text", "0 to 16777216", MAX_TEXT)?;
        if matches!(spectral_data, SpectralData::Shared | SpectralData::Indexed) && tables == 0 {
            return Err(value("number of spectral tables", 0.0, "1 or more, since rays refer to them"));
        }
        self.skip(168, WHERE)?;
        let mut flags = [false; 8];
        for flag in &mut flags {
            *flag = self.count("known-data flag", "0 or 1", 1)? == 1;
        }
        check_flags(flags, spectral_data).map_err(Tm25ErrorKind::Flags)?;
        let [
            _,
            _,
            has_radiant_flux,
            has_wavelength,
            has_luminous_flux,
            has_stokes,
            has_tristimulus,
            has_spectrum_index,
        ] = flags;
        let mut description = || self.text(4000, "descriptions");
        let descriptions = SourceDescriptions {
            name: description()?,
            manufacturer: description()?,
            model_creator: description()?,
            file_creator: description()?,
            equipment: description()?,
            camera: description()?,
            operation: description()?,
            information: description()?,
            reference: description()?,
        };
        let spectra = self.spectra(tables)?;
        let additional_columns =
            (0..columns).map(|_| self.text(512, "names of additional columns")).collect::<Result<_, _>>()?;
        let additional_text = self.text(text_bytes, "additional text")?;
        Ok(RayFileHeader {
            creation,
            luminous_flux,
            radiant_flux,
            ray_count,
            date,
            start_position,
            spectral_data,
            wavelengths,
            has_radiant_flux,
            has_wavelength,
            has_luminous_flux,
            has_stokes,
            has_tristimulus,
            has_spectrum_index,
            descriptions,
            spectra,
            additional_columns,
            additional_text,
        })
    }

    fn spectra(&mut self, tables: usize) -> Result<Vec<SpectralTable>, Tm25ErrorKind> {
        const WHERE: &str = "spectral tables";
        let start = self.offset;
        let mut spectra = Vec::new();
        let mut room = MAX_PAIRS;
        for _ in 0..tables {
            let pairs = self.int(WHERE)?;
            let count = usize::try_from(pairs).ok().filter(|&n| n > 0 && n <= room);
            let count = count.ok_or_else(|| Tm25ErrorKind::Value {
                what: "number of pairs of a spectral table",
                value: f64::from(pairs),
                allowed: "1 to 4194304 in all tables",
            })?;
            room -= count;
            // Nothing is reserved: the table grows with the data.
            let mut table = SpectralTable::new();
            for _ in 0..count {
                let pair = [self.float(WHERE)?, self.float(WHERE)?];
                if !(pair[0].is_finite() && pair[0] > 0.0) {
                    return Err(value("wavelength of a spectral table", pair[0], "more than 0"));
                }
                if !(pair[1].is_finite() && pair[1] >= 0.0) {
                    return Err(value("weight of a spectral table", pair[1], "0 or more"));
                }
                table.push(pair);
            }
            spectra.push(table);
        }
        let padding = (32 - (self.offset - start) % 32) % 32;
        self.skip(padding as usize, WHERE)?;
        Ok(spectra)
    }

    fn take<const N: usize>(&mut self, what: &'static str) -> Result<[u8; N], Tm25ErrorKind> {
        let mut bytes = [0; N];
        self.fill(&mut bytes, what)?;
        Ok(bytes)
    }

    fn fill(&mut self, bytes: &mut [u8], what: &'static str) -> Result<(), Tm25ErrorKind> {
        self.source.read_exact(bytes).map_err(|error| match error.kind() {
            ErrorKind::UnexpectedEof => Tm25ErrorKind::End(what),
            _ => Tm25ErrorKind::Io(error),
        })?;
        self.offset += bytes.len() as u64;
        Ok(())
    }

    fn skip(&mut self, count: usize, what: &'static str) -> Result<(), Tm25ErrorKind> {
        (0..count).try_for_each(|_| self.take::<1>(what).map(drop))
    }

    fn int(&mut self, what: &'static str) -> Result<i32, Tm25ErrorKind> {
        Ok(i32::from_le_bytes(self.take(what)?))
    }

    fn float(&mut self, what: &'static str) -> Result<f32, Tm25ErrorKind> {
        Ok(f32::from_le_bytes(self.take(what)?))
    }

    /// A whole number from 0 to `most`.
    fn count(
        &mut self,
        what: &'static str,
        allowed: &'static str,
        most: i32,
    ) -> Result<usize, Tm25ErrorKind> {
        let count = self.int("file header")?;
        match usize::try_from(count) {
            Ok(n) if count <= most => Ok(n),
            _ => Err(Tm25ErrorKind::Value { what, value: f64::from(count), allowed }),
        }
    }

    /// A flux; NaN means unknown.
    fn flux(&mut self, what: &'static str) -> Result<Option<f32>, Tm25ErrorKind> {
        let flux = self.float("file header")?;
        if flux.is_nan() {
            Ok(None)
        } else if flux.is_finite() && flux >= 0.0 {
            Ok(Some(flux))
        } else {
            Err(value(what, flux, "0 or more, or not a number"))
        }
    }

    /// Text up to a zero in a field of this number of bytes.
    fn text(&mut self, bytes: usize, what: &'static str) -> Result<String, Tm25ErrorKind> {
        let mut text = String::new();
        let mut is_over = false;
        for _ in 0..bytes / 4 {
            let code = u32::from_le_bytes(self.take(what)?);
            is_over |= code == 0;
            if !is_over {
                text.push(char::from_u32(code).unwrap_or(char::REPLACEMENT_CHARACTER));
            }
        }
        self.skip(bytes % 4, what)?;
        Ok(text)
    }
}

fn value(what: &'static str, value: f32, allowed: &'static str) -> Tm25ErrorKind {
    Tm25ErrorKind::Value { what, value: f64::from(value), allowed }
}

/// Flags in the order of the file.
fn check_flags(flags: [bool; 8], spectral_data: SpectralData) -> Result<(), &'static str> {
    let [position, direction, radiant, wavelength, luminous, stokes, tristimulus, index] = flags;
    for (holds, otherwise) in [
        (position && direction, "rays must have a position and a direction"),
        (radiant || luminous, "rays have neither radiant nor luminous flux"),
        (
            wavelength || spectral_data != SpectralData::PerRay,
            "rays should have wavelengths, but their flag is 0",
        ),
        (
            index == (spectral_data == SpectralData::Indexed),
            "spectrum index and spectral data identifier disagree",
        ),
        (!stokes || radiant, "Stokes parameters need a radiant flux"),
        (!tristimulus || luminous, "tristimulus values need a luminous flux"),
    ] {
        if !holds {
            return Err(otherwise);
        }
    }
    Ok(())
}
