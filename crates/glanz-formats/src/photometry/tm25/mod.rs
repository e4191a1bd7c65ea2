//! Ray files of IES TM-25-13 (`.tm25ray`): light sources as rays, including the near field.
//!
//! [`RayReader`] reads the header first and then ray by ray, in memory that does not grow with their number; [`RayWriter`] writes in this way. All numbers are
//! little-endian with 32 bits, except for the number of rays; text is UTF-32 and ends with a zero.
//!
//! | bytes | content |
//! |---|---|
//! | 256 | file header, see below |
//! | 8 x 4 | flags: position, direction, radiant flux, wavelength, luminous flux, Stokes, tristimulus, spectrum index |
//! | 9 x 4000 | descriptions |
//! | padded to 32 | spectral tables: number of pairs, then pairs of wavelength and weight |
//! | 512 each | names of additional columns |
//! | as declared | additional text |
//! | rest | rays: x y z (mm), direction, then the columns of the flags in the order of [`RayRecord`] |
//!
//! The file header is magic `TM25`, version, creation, luminous and radiant flux, number of rays (64 bits), date (28
//! bytes), start position, spectral identifier, single, least and largest wavelength, numbers of spectral tables and of
//! additional columns, bytes of additional text, and zeros.
//!
//! # Source
//! @tm25_2013, after a reader and writer in the public domain that cite its sections (@muschaweck2019) and published
//! reports of manufacturers' files; the known ones have a radiant flux and a shared spectrum only, so the columns
//! for Stokes parameters, tristimulus values and additional items are based on this one implementation. Files of TM-25-20
//! with another version number than 2013 are refused.

mod header;
#[cfg(test)]
mod tests;
mod write;

use std::io::{BufReader, Read};

use glanz_math::DVec3;

pub use header::{RayFileHeader, SourceDescriptions, SpectralData, SpectralTable};
pub use write::RayWriter;

/// Magic number of a ray file.
pub const MAGIC: &[u8] = b"TM25";

/// Unit of positions in files, metres.
const MILLIMETRE: f64 = 1e-3;

/// Error of reading a ray file.
#[derive(Debug, thiserror::Error)]
#[error("byte {offset}: {kind}")]
pub struct Tm25Error {
    /// Offset in bytes from the start.
    pub offset: u64,
    /// Kind.
    pub kind: Tm25ErrorKind,
}

/// Kinds of errors of ray files.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Tm25ErrorKind {
    /// The magic number is missing.
    #[error("not a TM-25 ray file: it does not begin with \"TM25\"")]
    Magic,
    /// Another version than 2013.
    #[error("version {0} is not known, only 2013 is; save the rays in that version")]
    Version(i32),
    /// The file ends too early.
    #[error("the file ends within the {0}; fetch it again")]
    End(&'static str),
    /// The file ends within the rays.
    #[error("the file ends within ray {ray} of {count}; fetch it again")]
    EndOfRays {
        /// Counted from 0.
        ray: u64,
        /// Declared.
        count: u64,
    },
    /// A number out of range.
    #[error("the {what} is {value}; it must be {allowed}")]
    Value {
        /// Which number.
        what: &'static str,
        /// The value.
        value: f64,
        /// The allowed values.
        allowed: &'static str,
    },
    /// Flags that contradict one another.
    #[error("{0}")]
    Flags(&'static str),
    /// A number of a ray out of range.
    #[error("the {what} of ray {ray} is {value}; it must be {allowed}")]
    RayRecord {
        /// Counted from 0.
        ray: u64,
        /// Which number.
        what: &'static str,
        /// The value.
        value: f32,
        /// The allowed values.
        allowed: &'static str,
    },
    /// Reading failed.
    #[error(transparent)]
    Io(#[from] std::io::Error),
}

/// A ray, in the file's frame.
#[derive(Clone, Debug, PartialEq)]
pub struct RayRecord {
    /// Origin, metres.
    pub position: DVec3,
    /// Unit direction.
    pub direction: DVec3,
    /// Its radiant flux in watts.
    pub radiant_flux: Option<f32>,
    /// Its wavelength in nanometres.
    pub wavelength: Option<f32>,
    /// Its luminous flux in lumens, which is also the tristimulus value Y.
    pub luminous_flux: Option<f32>,
    /// Its polarisation.
    pub polarization: Option<Polarization>,
    /// Its tristimulus values X and Z.
    pub tristimulus: Option<[f32; 2]>,
    /// Its spectral table, counted from 0.
    pub spectrum: Option<u32>,
    /// The additional columns, named by [`RayFileHeader::additional_columns`].
    pub additional: Vec<f32>,
}

/// Stokes parameters except the first, which is the flux, and their axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Polarization {
    /// S1, S2, S3 as in the file.
    pub stokes: [f32; 3],
    /// The axis across the ray.
    pub axis: [f32; 3],
}

/// Tolerance of the length of directions, for a few rounding errors of 32 bits or of four printed digits.
const UNIT_LENGTH: f64 = 1e-3;

/// Iterator over the rays of a file; ends after the declared number, or with the first error.
#[derive(Debug)]
pub struct RayReader<R> {
    source: BufReader<R>,
    header: RayFileHeader,
    /// Buffer for the record of a ray.
    record: Vec<u8>,
    offset: u64,
    next: u64,
    has_failed: bool,
}

impl<R: Read> RayReader<R> {
    /// Reads the header.
    ///
    /// # Errors
    /// [`Tm25Error`] with its place.
    pub fn new(source: R) -> Result<Self, Tm25Error> {
        let mut source = BufReader::with_capacity(1 << 16, source);
        let (header, offset) = header::read(&mut source)?;
        let record = vec![0; header.ray_bytes()];
        Ok(Self { source, header, record, offset, next: 0, has_failed: false })
    }

    /// The header.
    #[must_use]
    pub fn header(&self) -> &RayFileHeader {
        &self.header
    }

    fn read(&mut self) -> Result<RayRecord, Tm25Error> {
        let (ray, count) = (self.next, self.header.ray_count);
        let at = self.offset;
        let fail = |kind| Tm25Error { offset: at, kind };
        self.source.read_exact(&mut self.record).map_err(|error| {
            fail(match error.kind() {
                std::io::ErrorKind::UnexpectedEof => Tm25ErrorKind::EndOfRays { ray, count },
                _ => Tm25ErrorKind::Io(error),
            })
        })?;
        self.offset += self.record.len() as u64;
        let mut columns = RayColumns { rest: &self.record, ray };
        columns.ray(&self.header).map_err(fail)
    }
}

impl<R: Read> Iterator for RayReader<R> {
    type Item = Result<RayRecord, Tm25Error>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.has_failed || self.next >= self.header.ray_count {
            return None;
        }
        let ray = self.read();
        self.next += 1;
        self.has_failed = ray.is_err();
        Some(ray)
    }
}

/// The numbers of one ray.
struct RayColumns<'a> {
    rest: &'a [u8],
    ray: u64,
}

impl RayColumns<'_> {
    fn ray(&mut self, header: &RayFileHeader) -> Result<RayRecord, Tm25ErrorKind> {
        let position = DVec3::from_array(self.finite("position")?.map(f64::from)) * MILLIMETRE;
        let direction = DVec3::from_array(self.finite("direction")?.map(f64::from));
        let length = direction.length();
        if (length - 1.0).abs() > UNIT_LENGTH {
            return Err(self.wrong("length of the direction", length as f32, "1"));
        }
        let ray = RayRecord {
            position,
            direction: direction / length,
            radiant_flux: self.positive(header.has_radiant_flux, "radiant flux")?,
            wavelength: self.positive(header.has_wavelength, "wavelength")?,
            luminous_flux: self.positive(header.has_luminous_flux, "luminous flux")?,
            polarization: if header.has_stokes {
                let stokes = self.finite("Stokes parameter")?;
                Some(Polarization { stokes, axis: self.finite("polarisation axis")? })
            } else {
                None
            },
            tristimulus: if header.has_tristimulus {
                let [x] = self.finite("tristimulus value X")?;
                let [z] = self.finite("tristimulus value Z")?;
                Some([x, z])
            } else {
                None
            },
            spectrum: self.spectrum(header)?,
            additional: (0..header.additional_columns.len()).map(|_| self.number()).collect(),
        };
        Ok(ray)
    }

    fn number(&mut self) -> f32 {
        match self.rest.split_first_chunk() {
            Some((bytes, rest)) => {
                self.rest = rest;
                f32::from_le_bytes(*bytes)
            }
            None => f32::NAN,
        }
    }

    fn finite<const N: usize>(&mut self, what: &'static str) -> Result<[f32; N], Tm25ErrorKind> {
        let mut values = [0.0; N];
        for value in &mut values {
            *value = self.number();
            if !value.is_finite() {
                return Err(self.wrong(what, *value, "finite"));
            }
        }
        Ok(values)
    }

    fn positive(&mut self, is_there: bool, what: &'static str) -> Result<Option<f32>, Tm25ErrorKind> {
        if !is_there {
            return Ok(None);
        }
        let value = self.number();
        if value.is_finite() && value >= 0.0 {
            Ok(Some(value))
        } else {
            Err(self.wrong(what, value, "finite and not below 0"))
        }
    }

    fn spectrum(&mut self, header: &RayFileHeader) -> Result<Option<u32>, Tm25ErrorKind> {
        if !header.has_spectrum_index {
            return Ok(None);
        }
        let value = self.number();
        if value.fract() == 0.0 && value >= 1.0 && value <= header.spectra.len() as f32 {
            Ok(Some(value as u32 - 1))
        } else {
            Err(self.wrong("spectrum index", value, "the number of a spectral table, from 1"))
        }
    }

    fn wrong(&self, what: &'static str, value: f32, allowed: &'static str) -> Tm25ErrorKind {
        Tm25ErrorKind::RayRecord { ray: self.ray, what, value, allowed }
    }
}
