//! Checkpoints of illuminance by several methods.
//!
//! | bytes | content |
//! |---|---|
//! | 8 | `GLANZLXC` |
//! | 4 | version of the format |
//! | 8 | length of the file |
//! | | version of Glanz, content hashes, seed and depth as in the checkpoint of a tally |
//! | 8 | relative error of the integration |
//! | | light as [`CombinedLight::encode`] writes it |
//! | 4 | CRC-32 (IEEE) of all before |

use std::path::Path;

use glanz_illumination::CombinedLight;
use glanz_job::JobIdentity;
use glanz_transport::codec::{Decoder, FileEnvelope};

use super::tally_file::TallyIdentity;
use crate::error::{Error, FileFault};
use crate::file;

/// Envelope of the file.
const ENVELOPE: FileEnvelope = FileEnvelope {
    magic: b"GLANZLXC",
    version: 2,
    content: "the checkpoint",
    kind: "a checkpoint of illuminance",
};

/// Content of a file.
#[derive(Clone, Debug)]
pub(super) struct CombinedFile {
    /// Identity of the particles.
    pub(super) identity: TallyIdentity,
    /// Relative error of the integration; which cells were integrated depends on it, and on the time.
    pub(super) tolerance: f64,
    pub(super) light: CombinedLight,
}

/// The error of a file with invalid content.
pub(super) fn senseless(path: &Path) -> Error {
    FileFault::Content(ENVELOPE.content).of(path)
}

impl CombinedFile {
    /// Reads the bytes of the file `path`, which is to be of this calculation.
    pub(super) fn from_bytes(path: &Path, bytes: &[u8], identity: &TallyIdentity) -> Result<Self, Error> {
        let mut decoder = Decoder(ENVELOPE.open(bytes).map_err(Error::of_file(path))?);
        let file = decode(&mut decoder).ok_or_else(|| senseless(path))?;
        file.identity.check(identity).map_err(Error::of_file(path))?;
        Ok(file)
    }
}

fn decode(decoder: &mut Decoder<'_>) -> Option<CombinedFile> {
    let identity = TallyIdentity::decode(decoder)?;
    let tolerance = Some(f64::from_bits(decoder.u64()?)).filter(|tolerance| *tolerance > 0.0)?;
    let light = CombinedLight::decode(decoder)?;
    decoder.0.is_empty().then_some(CombinedFile { identity, tolerance, light })
}

/// Writes `light` to the file `path`. `tolerance`: that of the integration.
pub(super) fn write(
    path: &Path,
    identity: &TallyIdentity,
    tolerance: f64,
    light: &CombinedLight,
) -> Result<(), Error> {
    let bytes = ENVELOPE.seal(|encoder| {
        identity.encode(encoder);
        encoder.f64(tolerance);
        light.encode(encoder);
    });
    file::write(path, &bytes)
}
