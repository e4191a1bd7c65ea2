//! Photometric files: the luminous intensity of luminaires by direction.
//!
//! [`ies`] reads IES LM-63 of all editions, [`ldt`] reads EULUMDAT; both return a [`Photometry`], and [`read`] recognises
//! the format. [`tm25`] reads and writes ray files. [`mod@write`] writes IES and EULUMDAT files of a distribution. Errors have line and column; harmless irregularities are
//! warnings of the same form.
//!
//! # The luminaire's frame
//!
//! Right-handed, z up, origin in the photometric centre; a luminaire in its usual position emits towards -z.
//!
//! | type | angles | direction |
//! |---|---|---|
//! | C | gamma from -z, C about z from +x to +y | (sin g cos C, sin g sin C, -cos g) |
//! | A | V up from the horizontal, H clockwise seen from above | (cos V cos H, -cos V sin H, sin V) |
//! | B | V about y from -z to +x, H out of the plane of V towards -y | (cos H sin V, -sin H, -cos H cos V) |
//!
//! The photometric horizontal of LM-63 is therefore +x in all three, and photometric zero is -z: C at gamma 0, B at (0, 0),
//! A at V = -90. The beam of a type A file, (0, 0), points along +x. In LM-63 the length of the opening is along x.
//! In EULUMDAT it is along y, because C0 is the plane across a linear luminaire
//! (by convention after CIE 121; the file does not specify it).
//!
//! ```
//! use glanz_formats::photometry;
//! use glanz_math::DVec3;
//!
//! let text = "IESNA:LM-63-2002\n[LUMINAIRE] Globe\nTILT=NONE\n\
//!     1 1000 1 2 1 1 2 -0.3 -0.3 -0.3 1 1 12\n0 180\n0\n60 60\n";
//! let globe = photometry::read(text.as_bytes())?.photometry;
//! assert_eq!(globe.intensity(DVec3::X), 60.0);
//! assert!((globe.flux() - 60.0 * 4.0 * std::f64::consts::PI).abs() < 1e-9);
//! assert_eq!(globe.header_flux(), Some(1000.0));
//! # Ok::<(), photometry::PhotometryError>(())
//! ```
//!
//! # Source
//! @lm63_2019, @lm63_2002, @stockmar1990, @cie121, @ashdown1998 for the editions before 2002.

mod description;
mod error;
pub mod ies;
pub mod ldt;
mod opening;
mod text;
mod tilt;
pub mod tm25;
pub mod write;

use glanz_math::DVec3;

pub use glanz_light::intensity::{
    AngularSystem, IntensityDistribution, LuminousOpening, OpeningShape, Symmetry,
};

pub use error::{PhotometryError, PhotometryErrorKind};
pub use tilt::{LampGeometry, Tilt};

/// Names and numbers of the luminaire. Empty where missing in the file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Names {
    /// Maker of the luminaire.
    pub manufacturer: String,
    /// The luminaire.
    pub luminaire: String,
    /// Its number in the catalogue.
    pub catalog_number: String,
    /// Number of the measurement report.
    pub report: String,
    /// Date and issuer of the file.
    pub issued: String,
}

/// Lamps of one kind in a luminaire.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LampSet {
    /// Number of lamps.
    pub count: f64,
    /// Rated flux of all lamps together in lumens; `None` for absolute photometry in LM-63.
    pub lumens: Option<f64>,
    /// Type of the lamps.
    pub name: String,
    /// Colour or colour temperature, as written.
    pub color: String,
    /// Colour rendering, as written.
    pub rendering: String,
    /// Watts of lamps and ballast.
    pub watts: f64,
}

/// The format of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PhotometryFormat {
    /// IES LM-63 with the year of the edition: 1986, 1991, 1995, 2002 or 2019.
    Ies(u16),
    /// EULUMDAT.
    Eulumdat,
}

/// Data that only EULUMDAT has.
#[derive(Clone, Debug, PartialEq)]
pub struct EulumdatExtra {
    /// Type of luminaire: 1 point with axial symmetry, 2 linear, 3 other point.
    pub luminaire_type: u8,
    /// Size of the housing along x, y and z in metres.
    pub housing: [f64; 3],
    /// Whether the housing is round.
    pub housing_is_round: bool,
    /// Height of the luminous sides towards C0, C90, C180 and C270 in metres.
    pub side_heights: [f64; 4],
    /// Fraction of the flux below the horizontal.
    pub downward_fraction: f64,
    /// Flux of the luminaire divided by the flux of its lamps.
    pub light_output_ratio: f64,
    /// Tilt of the luminaire during the measurement in degrees.
    pub measurement_tilt: f64,
    /// Direct ratios for room indices 0.6 to 5.
    pub direct_ratios: Option<[f64; 10]>,
}

/// The photometry of a luminaire, from either format.
#[derive(Clone, Debug, PartialEq)]
pub struct Photometry {
    /// Format of the file.
    pub format: PhotometryFormat,
    /// Candela by direction, with all factors below applied except those of `tilt`.
    pub distribution: IntensityDistribution,
    /// The sets of lamps: one for LM-63; for EULUMDAT the alternatives of the luminaire, of which the distribution applies to the first.
    pub lamps: Vec<LampSet>,
    /// Factor on all values of the file; included in `distribution`.
    pub multiplier: f64,
    /// Flux of the lamps with the luminaire's ballast divided by their rated flux; included in `distribution`.
    pub ballast_factor: f64,
    /// The ballast-lamp photometric factor of LM-63 up to 1991, else 1; included in `distribution`.
    pub ballast_lamp_factor: f64,
    /// File generation type of LM-63-2019.
    pub generation: Option<f64>,
    /// Electric power in watts.
    pub input_watts: f64,
    /// Luminous opening.
    pub opening: LuminousOpening,
    /// Names and numbers of the luminaire.
    pub names: Names,
    /// Keywords of LM-63 in order, with continuation lines appended; lines without a keyword have an empty one.
    pub keywords: Vec<(String, String)>,
    /// Factors by the tilt of the lamp, not applied.
    pub tilt: Option<Tilt>,
    /// Data that only EULUMDAT has.
    pub eulumdat: Option<EulumdatExtra>,
    /// Whether this is absolute photometry: the luminaire was measured as a whole and has no rated lamp flux.
    pub is_absolute: bool,
}

/// A photometry and the warnings about its file.
#[derive(Clone, Debug, PartialEq)]
pub struct PhotometryFile {
    /// The photometry.
    pub photometry: Photometry,
    /// Repairs, and content that was ignored.
    pub warnings: Vec<PhotometryError>,
}

/// Reads LM-63 or EULUMDAT, recognised by content: LM-63 has a line that begins with `TILT=`.
///
/// # Errors
/// [`PhotometryError`] with its place.
pub fn read(bytes: &[u8]) -> Result<PhotometryFile, PhotometryError> {
    if is_ies(bytes) { ies::read(bytes) } else { ldt::read(bytes) }
}

/// As [`read`], with a reader for the file that a line `TILT=name` of LM-63 names.
///
/// # Errors
/// [`PhotometryError`] with its place.
pub fn read_with(
    bytes: &[u8],
    tilt_files: &mut ies::TiltFiles<'_>,
) -> Result<PhotometryFile, PhotometryError> {
    if is_ies(bytes) { ies::read_with(bytes, tilt_files) } else { ldt::read(bytes) }
}

/// The format of the beginning of a file with the light of a luminaire; `None` if it is none.
pub(crate) fn recognise(head: &[u8]) -> Option<&'static str> {
    if head.starts_with(tm25::MAGIC) {
        return Some("TM-25");
    }
    if head.starts_with(b"IESNA") || is_ies(head) {
        return Some("LM-63");
    }
    // EULUMDAT has a company, then type, symmetry, planes with their step and intensities with theirs.
    let mut lines = head.split(|&b| b == b'\n').skip(1).map(|line| std::str::from_utf8(line).map(str::trim));
    let mut number =
        || lines.next().and_then(Result::ok).and_then(|text| text.replace(',', ".").parse::<f64>().ok());
    let numbers: Vec<f64> = std::iter::from_fn(&mut number).take(6).collect();
    let is_ldt = matches!(numbers[..], [kind, symmetry, planes, _, gammas, _]
        if [1.0, 2.0, 3.0].contains(&kind) && (0.0..=4.0).contains(&symmetry) && planes >= 1.0 && gammas >= 1.0);
    is_ldt.then_some("EULUMDAT")
}

fn is_ies(bytes: &[u8]) -> bool {
    let mut lines = bytes.split(|&b| b == b'\n').map(<[u8]>::trim_ascii_start);
    let is_tilt = |line: &[u8]| line.get(..5).is_some_and(|l| l.eq_ignore_ascii_case(b"TILT="));
    lines.any(is_tilt)
}

impl Photometry {
    /// Candela in a direction of the luminaire's frame, of any length.
    #[must_use]
    pub fn intensity(&self, direction: DVec3) -> f64 {
        self.distribution.intensity(direction)
    }

    /// Lumens by integration of the intensities; see [`IntensityDistribution::flux`].
    #[must_use]
    pub fn flux(&self) -> f64 {
        self.distribution.flux()
    }

    /// Luminous flux of the header, lm; `None` if the header has none.
    ///
    /// EULUMDAT: flux of the luminaire, which is that of the first set of lamps times the light output ratio. LM-63: flux
    /// of the lamps, which is their rated flux times the ballast factors; [`Photometry::flux`] divided by it is the luminaire's
    /// efficiency.
    #[must_use]
    pub fn header_flux(&self) -> Option<f64> {
        let lamps = self.lamps.first()?.lumens?;
        match &self.eulumdat {
            Some(extra) => Some(lamps * extra.light_output_ratio),
            None => Some(lamps * self.ballast_factor * self.ballast_lamp_factor),
        }
    }

    /// The same distribution with another flux in lumens; `None` if it has no flux that could be scaled, or `lumens` is
    /// below zero or not finite.
    #[must_use]
    pub fn scaled_to(&self, lumens: f64) -> Option<Self> {
        self.scaled_by(lumens / self.flux())
    }

    /// The same luminaire with another set of lamps of an EULUMDAT file, which becomes the first; `None` if
    /// the set does not exist or has no flux.
    #[must_use]
    pub fn with_lamps(&self, set: usize) -> Option<Self> {
        let lumens = |set: usize| self.lamps.get(set).and_then(|lamps| lamps.lumens);
        let factor = lumens(set)? / lumens(0)?;
        if !(factor.is_finite() && factor > 0.0) {
            return None;
        }
        let mut changed = self.scaled_by(factor)?;
        changed.lamps.swap(0, set);
        changed.input_watts = changed.lamps.first()?.watts;
        Some(changed)
    }

    /// The same photometry with all intensities times `factor`: dimming, maintenance, or [`Tilt::factor`]. The header is unchanged. `None` if an intensity
    /// would be negative or not finite.
    #[must_use]
    pub fn scaled_by(&self, factor: f64) -> Option<Self> {
        let distribution = self.distribution.scaled(factor)?;
        Some(Self { distribution, ..self.clone() })
    }
}

/// Sets intensities below zero, which result from measurement noise, to zero.
fn clamp_negative(candela: &mut [f64]) -> Option<PhotometryErrorKind> {
    let mut count = 0;
    for value in candela {
        if *value < 0.0 {
            *value = 0.0;
            count += 1;
        }
    }
    (count > 0).then_some(PhotometryErrorKind::Negative(count))
}

#[cfg(test)]
mod tests;
