//! Photometric files of a distribution: [`ies`] writes LM-63-2002, [`ldt`] EULUMDAT.
//!
//! Both write absolute photometry: candela of the luminaire itself, independent of the rated flux of lamps.
//! Intensities are written with eight digits, so that values change by at most 5e-8 of themselves, and those below
//! 1e-20 as 0; angles are written exactly. Symmetric parts are stored once, by the distribution's [`Symmetry`].
//!
//! ```
//! use glanz_formats::photometry::{self, write};
//!
//! let text = "IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 3 1 1 2 0 0 0 1 1 12\n0 45 90\n0\n60 50 0\n";
//! let lamp = photometry::read(text.as_bytes())?.photometry;
//! let header = write::Header { watts: 12.0, ..write::Header::default() };
//! let file = write::ldt(&lamp.distribution, &header)?;
//! let again = photometry::read(&file)?.photometry;
//! assert!((again.flux() - lamp.flux()).abs() < 1e-6 * lamp.flux());
//! assert_eq!(again.header_flux(), Some(lamp.flux()));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod ies;
mod ldt;

pub use ies::ies;
pub use ldt::ldt;

use super::{AngularSystem, IntensityDistribution, LuminousOpening, Names, Symmetry};

/// Largest intensity that the readers accept, candela.
const MOST: f64 = 1e30;

/// Header data of a photometric file.
#[derive(Clone, Debug, PartialEq)]
pub struct Header {
    /// Names and numbers of the luminaire. Line ends and other control characters become blanks, and texts are cut to the length that the
    /// format allows.
    pub names: Names,
    /// Source of the intensities: the laboratory of LM-63.
    pub laboratory: String,
    /// Luminous opening; sizes in metres.
    pub opening: LuminousOpening,
    /// Electric power in watts; 0 if unknown.
    pub watts: f64,
}

impl Default for Header {
    /// A point without a name.
    fn default() -> Self {
        Self {
            names: Names::default(),
            laboratory: String::new(),
            opening: LuminousOpening::POINT,
            watts: 0.0,
        }
    }
}

/// Errors of writing a distribution.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PhotometryWriteError {
    /// The type of the intensities; only type C is written.
    #[error("intensities of type {0:?} cannot be written, only those of type C")]
    System(AngularSystem),
    /// Planes that do not start at C0 or do not cover 360 degrees.
    #[error(
        "the planes run from C {first} to {last} degrees; they must run from 0 to 360, or be a single one"
    )]
    Planes {
        /// First azimuth, degrees.
        first: f64,
        /// Last azimuth, degrees.
        last: f64,
    },
    /// Polar angles that the formats cannot represent.
    #[error(
        "the {count} gamma angles run from {first} to {last} degrees; there must be at least 2, from 0 or 90 to 90 or 180"
    )]
    Gammas {
        /// Number.
        count: usize,
        /// First, degrees.
        first: f64,
        /// Last, degrees.
        last: f64,
    },
    /// An intensity, in candela, that is negative or too large.
    #[error("an intensity is {0} cd; it must be from 0 to 1e30")]
    Intensity(f64),
    /// A luminaire without light, for EULUMDAT, whose intensities are per lumen.
    #[error("the luminaire gives no light, which EULUMDAT cannot represent")]
    Dark,
}

/// The planes that are stored.
struct PlaneSelection {
    symmetry: Symmetry,
    /// Numbers of the planes in the distribution, in the order of the file.
    planes: Vec<usize>,
}

impl PlaneSelection {
    /// Checks the distribution and selects the planes that its symmetry needs, or all of them if the planes
    /// that bound its part are missing.
    fn of(distribution: &IntensityDistribution) -> Result<Self, PhotometryWriteError> {
        if distribution.system() != AngularSystem::C {
            return Err(PhotometryWriteError::System(distribution.system()));
        }
        let (azimuths, polars) = (distribution.azimuths(), distribution.polars());
        let ends = |angles: &[f64]| {
            (angles.first().copied().unwrap_or(f64::NAN), angles.last().copied().unwrap_or(f64::NAN))
        };
        let (first, last) = ends(polars);
        if polars.len() < 2 || ![0.0, 90.0].contains(&first) || ![90.0, 180.0].contains(&last) {
            return Err(PhotometryWriteError::Gammas { count: polars.len(), first, last });
        }
        let all = (0..azimuths.len()).flat_map(|i| distribution.plane(i));
        if let Some(value) = all.copied().find(|value| !(0.0..=MOST).contains(value)) {
            return Err(PhotometryWriteError::Intensity(value));
        }
        // A single plane represents all, too.
        if azimuths.len() == 1 || azimuths == [0.0, 360.0] {
            return Ok(Self { symmetry: Symmetry::Axial, planes: vec![0] });
        }
        let (from, to) = match distribution.symmetry() {
            Symmetry::Quadrants => (0.0, 90.0),
            Symmetry::AcrossY => (0.0, 180.0),
            Symmetry::AcrossX => (90.0, 270.0),
            Symmetry::None | Symmetry::Axial => (0.0, 360.0),
        };
        let within = |i: &usize| azimuths.get(*i).is_some_and(|c| (from..=to).contains(c));
        let planes: Vec<usize> = (0..azimuths.len()).filter(within).collect();
        let at = |i: Option<&usize>| i.and_then(|i| azimuths.get(*i)).copied();
        if (at(planes.first()), at(planes.last())) == (Some(from), Some(to)) {
            return Ok(Self { symmetry: distribution.symmetry(), planes });
        }
        let (first, last) = ends(azimuths);
        if (first, last) != (0.0, 360.0) {
            return Err(PhotometryWriteError::Planes { first, last });
        }
        Ok(Self { symmetry: Symmetry::None, planes: (0..azimuths.len()).collect() })
    }
}

/// `words` on one line of at most `most` characters.
fn one_line(words: &str, most: usize) -> String {
    let blank = |letter: char| if letter.is_control() { ' ' } else { letter };
    words.chars().map(blank).take(most).collect::<String>().trim().to_owned()
}

/// Digits of intensities, and the limit below which they are written as 0, so that no line is too long.
const DIGITS: usize = 8;
const LEAST: f64 = 1e-20;

/// An intensity with the written number of digits.
fn digits(value: f64) -> String {
    if value < LEAST {
        return "0".to_owned();
    }
    // Parsing the rounded number gives its digits without an exponent.
    let rounded: f64 = format!("{value:.*e}", DIGITS - 1).parse().unwrap_or(value);
    rounded.to_string()
}

#[cfg(test)]
mod tests;
