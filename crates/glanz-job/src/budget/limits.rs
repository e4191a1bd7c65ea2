//! Limits of resources, with their names.

use std::error::Error;
use std::fmt;
use std::time::Duration;

use super::machine;
use crate::grouped;

/// A resource that a job uses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum Resource {
    /// Bytes of memory.
    Memory,
    /// Bytes of the files that are read.
    Bytes,
    /// Files that are read, one that is included often each time.
    Files,
    /// Files that include one another.
    Depth,
    /// Words, numbers and brackets of scene files, after inclusion.
    Tokens,
    /// Shapes, instances and lights.
    Objects,
    /// Pixels of pictures that are decoded.
    Pixels,
    /// Time of reading, and as much again of preparing the scene for rays.
    Time,
}

impl Resource {
    /// All of them, in the order of their numbers.
    pub const ALL: [Self; 8] = [
        Self::Memory,
        Self::Bytes,
        Self::Files,
        Self::Depth,
        Self::Tokens,
        Self::Objects,
        Self::Pixels,
        Self::Time,
    ];

    /// Its name: that of the field of [`ResourceLimits`].
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Memory => "memory",
            Self::Bytes => "bytes",
            Self::Files => "files",
            Self::Depth => "depth",
            Self::Tokens => "tokens",
            Self::Objects => "objects",
            Self::Pixels => "pixels",
            Self::Time => "time",
        }
    }

    /// An amount with its unit, for messages.
    pub(super) fn amount(self, amount: u64) -> String {
        let count = grouped(amount);
        let s = if amount == 1 { "" } else { "s" };
        match self {
            Self::Memory => format!("{} of memory", readable_bytes(amount)),
            Self::Bytes => format!("{} of files", readable_bytes(amount)),
            Self::Files => format!("{count} file{s}"),
            Self::Depth => format!("{count} file{s} within one another"),
            Self::Tokens => format!("{count} token{s}"),
            Self::Objects => format!("{count} object{s}"),
            Self::Pixels => format!("{count} pixel{s}"),
            Self::Time => format!("{} s", Duration::from_millis(amount).as_secs_f64()),
        }
    }

    /// A round value of at least `amount`, as [`ResourceLimits::set`] reads it.
    pub(super) fn value_above(self, amount: u64) -> String {
        match self {
            Self::Memory | Self::Bytes => {
                let (unit, suffix) = [(1_u64 << 30, "G"), (1 << 20, "M"), (1 << 10, "K")]
                    .into_iter()
                    .find(|(unit, _)| amount > 4 * unit)
                    .unwrap_or((1 << 10, "K"));
                format!("{}{suffix}", amount.div_ceil(unit))
            }
            Self::Time => format!("{}s", amount.div_ceil(1000)),
            _ if amount >= 100_000 => {
                // The first digit, rounded up.
                let power = amount.ilog10();
                let first = amount.div_ceil(10_u64.pow(power));
                if first == 10 { format!("1e{}", power + 1) } else { format!("{first}e{power}") }
            }
            _ => amount.to_string(),
        }
    }
}

/// Limits of what a job may use.
///
/// The defaults allow whatever fits the machine.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ResourceLimits {
    /// Bytes of memory, as far as readers and the scene account for it: pictures, meshes, surfaces, parameters. Default: three quarters of what is available when the process first asks,
    /// of the machine or of the control groups around the process, where cached files count as free; 4 GiB where neither can be asked, as on systems other than Linux.
    pub memory: u64,
    /// Bytes of the files that are read. Default: 2^40.
    pub bytes: u64,
    /// Files that are read; one that is included often counts each time. Default: 100 000.
    pub files: u64,
    /// Files that include one another. Default: 32.
    pub depth: u64,
    /// Words, numbers and brackets of scene files, after inclusion. Default: 10^11.
    pub tokens: u64,
    /// Shapes, instances and lights, patches and copies of lights included. Default: 10^9.
    pub objects: u64,
    /// Pixels of all pictures that are decoded. Default: 2 * 10^10, which are a thousand pictures of 4472 x 4472.
    pub pixels: u64,
    /// Time of reading, and as much again of preparing the scene. Default: one hour.
    pub time: Duration,
}

impl Default for ResourceLimits {
    fn default() -> Self {
        Self {
            memory: machine::available_memory().map_or(4 << 30, |bytes| bytes / 4 * 3),
            bytes: 1 << 40,
            files: 100_000,
            depth: 32,
            tokens: 100_000_000_000,
            objects: 1_000_000_000,
            pixels: 20_000_000_000,
            time: Duration::from_secs(3600),
        }
    }
}

impl ResourceLimits {
    /// The limit of a resource: bytes, a count or milliseconds.
    #[must_use]
    pub fn get(&self, resource: Resource) -> u64 {
        match resource {
            Resource::Memory => self.memory,
            Resource::Bytes => self.bytes,
            Resource::Files => self.files,
            Resource::Depth => self.depth,
            Resource::Tokens => self.tokens,
            Resource::Objects => self.objects,
            Resource::Pixels => self.pixels,
            Resource::Time => u64::try_from(self.time.as_millis()).unwrap_or(u64::MAX),
        }
    }

    /// Sets a limit by a text: a size such as `512M` for memory and bytes, seconds such as `30s` or `0.5` for the time, a count such as `1e9` for the others.
    ///
    /// # Errors
    /// [`LimitValueError`] if the text is none of them.
    pub fn set(&mut self, resource: Resource, text: &str) -> Result<(), LimitValueError> {
        let field = match resource {
            Resource::Memory => &mut self.memory,
            Resource::Bytes => &mut self.bytes,
            Resource::Files => &mut self.files,
            Resource::Depth => &mut self.depth,
            Resource::Tokens => &mut self.tokens,
            Resource::Objects => &mut self.objects,
            Resource::Pixels => &mut self.pixels,
            Resource::Time => {
                let seconds = text.strip_suffix('s').unwrap_or(text).parse().ok().filter(|s: &f64| *s > 0.0);
                let time = seconds.and_then(|seconds| Duration::try_from_secs_f64(seconds).ok());
                self.time = time.ok_or(LimitValueError::Time)?;
                return Ok(());
            }
        };
        *field = match resource {
            Resource::Memory | Resource::Bytes => byte_size(text)?,
            _ => count(text).ok_or(LimitValueError::Count)?,
        };
        Ok(())
    }
}

/// A text that is no value of a limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LimitValueError {
    /// No size in bytes.
    Size,
    /// No count.
    Count,
    /// No time.
    Time,
}

impl fmt::Display for LimitValueError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Size => "it must be a size such as 2G, 512M or 64K",
            Self::Count => "it must be a count such as 1000 or 2e9",
            Self::Time => "it must be a time above 0 such as 30s",
        })
    }
}

impl Error for LimitValueError {}

/// Bytes from a text: a number, perhaps with `K`, `M`, `G` or `T` for powers of 1024, perhaps with `B` or `iB` behind.
///
/// # Errors
/// [`LimitValueError::Size`] for any other text, and for 0.
pub fn byte_size(text: &str) -> Result<u64, LimitValueError> {
    let upper = text.trim().to_ascii_uppercase();
    let bare = upper.strip_suffix("IB").or_else(|| upper.strip_suffix('B')).unwrap_or(&upper);
    let (number, shift) = [('K', 10), ('M', 20), ('G', 30), ('T', 40)]
        .into_iter()
        .find_map(|(suffix, shift)| Some((bare.strip_suffix(suffix)?, shift)))
        .unwrap_or((bare, 0));
    whole(number, (1_u64 << shift) as f64).ok_or(LimitValueError::Size)
}

fn count(text: &str) -> Option<u64> {
    whole(text.trim(), 1.0)
}

/// `text` times `unit`, if it is at least 1 and fits.
fn whole(text: &str, unit: f64) -> Option<u64> {
    if !text.starts_with(|c: char| c.is_ascii_digit() || c == '.') {
        return None;
    }
    let value = text.trim_end().parse::<f64>().ok()? * unit;
    (1.0..1.8e19).contains(&value).then_some(value as u64)
}

/// Bytes with two or three digits and a unit: `3.4 GiB`.
fn readable_bytes(bytes: u64) -> String {
    let units = [(1_u64 << 40, "TiB"), (1 << 30, "GiB"), (1 << 20, "MiB"), (1 << 10, "KiB")];
    match units.into_iter().find(|(unit, _)| bytes >= *unit) {
        Some((unit, name)) => {
            let value = bytes as f64 / unit as f64;
            if value < 10.0 && value.fract() > 0.0 {
                format!("{value:.1} {name}")
            } else {
                format!("{value:.0} {name}")
            }
        }
        None if bytes == 1 => "1 byte".to_owned(),
        None => format!("{bytes} bytes"),
    }
}
