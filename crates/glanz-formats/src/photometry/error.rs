//! Errors and warnings of photometric files, with their positions.

use glanz_light::intensity::IntensityError;
use glanz_scene::Location;
use glanz_scene::description::FileId;
use glanz_scene::diagnostic::{Diagnostic, Excerpt, Severity};

/// An error or a warning at a position of a photometric file.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{line}:{column}: {kind}")]
pub struct PhotometryError {
    /// Line, from 1.
    pub line: u32,
    /// Column in bytes, from 1.
    pub column: u32,
    /// Bytes at fault.
    pub length: usize,
    /// Kind.
    pub kind: PhotometryErrorKind,
}

/// Kinds of errors and warnings.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PhotometryErrorKind {
    /// The text is encoded with two bytes per character.
    #[error("the file is UTF-16 text")]
    Utf16,
    /// The file has no line `TILT=`.
    #[error("there is no line that begins with \"TILT=\"")]
    NoTilt,
    /// A first line with an unknown edition of LM-63.
    #[error("the edition {0:?} of LM-63 is unknown; the file is read as that of 2019")]
    Edition(String),
    /// Tilt data in another file that cannot be read.
    #[error("the tilt data in {name:?} cannot be read: {reason}")]
    TiltFile {
        /// Its name.
        name: String,
        /// The reason.
        reason: String,
    },
    /// The file ends too early.
    #[error("the file ends before the {0}")]
    End(&'static str),
    /// Text that is not a finite number.
    #[error("{text:?} is not a number; the {what} is expected here")]
    Number {
        /// The expected item.
        what: &'static str,
        /// The text found.
        text: String,
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
    /// More declared numbers than the file can contain.
    #[error("{declared} {what} are declared; the file has room for {room}")]
    Count {
        /// Of what.
        what: &'static str,
        /// Declared.
        declared: f64,
        /// The number for which the file has room.
        room: usize,
    },
    /// Angles that do not ascend.
    #[error("the {what} must ascend, but {second} follows {first}")]
    Order {
        /// Which angles.
        what: &'static str,
        /// One angle.
        first: f64,
        /// The next.
        second: f64,
    },
    /// Angles over an invalid range.
    #[error("the {what} run from {first} to {last}; they must run {allowed}")]
    Range {
        /// Which angles.
        what: &'static str,
        /// First angle.
        first: f64,
        /// Last angle.
        last: f64,
        /// The allowed ranges.
        allowed: &'static str,
    },
    /// An intensity below zero, taken as zero.
    #[error("{0} intensities are below zero; taken as zero")]
    Negative(usize),
    /// The planes do not close the circle.
    #[error("the last plane is at {0} degrees; the first one is taken again at 360")]
    Open(f64),
    /// The planes at 0 and at 360 degrees are one and the same, yet differ.
    #[error("the planes at 0 and at 360 degrees differ; that at 0 is used")]
    Seam,
    /// Angles and intensities that do not form a distribution.
    #[error(transparent)]
    Intensity(#[from] IntensityError),
    /// A luminous opening whose signs are undefined.
    #[error("a luminous opening of {0} by {1} by {2} is undefined; it is taken as a box")]
    Opening(f64, f64, f64),
    /// A factor that the edition reserves for future use.
    #[error("the field for future use is {0}, not 1; it is ignored")]
    FutureUse(f64),
    /// Numbers after the last one.
    #[error("there is more after the last intensity; it is ignored")]
    Trailing,
    /// An empty line in place of a number, taken as zero.
    #[error("the line of the {0} is empty; it is taken as zero")]
    Empty(&'static str),
    /// The ten direct ratios are missing.
    #[error("the ten direct ratios are missing")]
    NoDirectRatios,
    /// Sets of lamps are listed field by field.
    #[error("the sets of lamps are listed field by field, not set by set")]
    FieldByField,
}

impl PhotometryErrorKind {
    /// Remedy.
    #[must_use]
    pub fn help(&self) -> Option<&'static str> {
        Some(match self {
            Self::Utf16 => "save it as plain ASCII, Latin-1 or UTF-8",
            Self::NoTilt => "an IES file has a line TILT=NONE, TILT=INCLUDE or TILT=name before its numbers",
            Self::TiltFile { .. } => "put its four records behind a line TILT=INCLUDE",
            Self::End(_) => "the file is cut short, or a count is too large: fetch it again",
            Self::Number { .. } => "a value before it may be missing or one too many",
            Self::Count { .. } => "check the count, or fetch the file again",
            Self::Value { .. } | Self::Order { .. } | Self::Range { .. } => {
                "check this line against the maker's data, or ask the maker for a valid file"
            }
            _ => return None,
        })
    }
}

impl PhotometryError {
    /// The error as a diagnostic with its line.
    ///
    /// `file`: its name as the user would write it; `bytes`: what was read.
    #[must_use]
    pub fn diagnostic(&self, severity: Severity, file: &str, bytes: &[u8]) -> Diagnostic {
        let line = bytes.split(|&b| b == b'\n').nth(self.line.saturating_sub(1) as usize).unwrap_or_default();
        let line = line.strip_suffix(b"\r").unwrap_or(line);
        let offset = self.column.saturating_sub(1) as usize;
        Diagnostic {
            severity,
            kind: "photometry",
            file: file.to_owned(),
            location: Some(Location { file: FileId(0), line: self.line, column: self.column }),
            message: self.kind.to_string(),
            excerpt: Some(Excerpt::of_line(self.line, line, offset, self.length)),
            help: self.kind.help().map(str::to_owned),
        }
    }
}
