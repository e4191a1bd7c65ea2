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
    version: 1,
    content: "the checkpoint",
    kind: "a checkpoint of illuminance",
};

/// Identity of light by several methods: that of its particles, and the relative error of the integration.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct CombinedIdentity {
    pub(super) particles: TallyIdentity,
    pub(super) tolerance: f64,
}

impl JobIdentity for CombinedIdentity {
    const FOREIGN: &'static str = TallyIdentity::FOREIGN;

    fn fields(&self) -> Vec<(&'static str, String)> {
        let mut fields = self.particles.fields();
        fields.push(("the tolerance", self.tolerance.to_string()));
        fields
    }
}

/// The error of a file with invalid content.
pub(super) fn senseless(path: &Path) -> Error {
    FileFault::Content(ENVELOPE.content).of(path)
}

/// The light in the bytes of the file `path`, which is to have this identity.
pub(super) fn read(path: &Path, bytes: &[u8], identity: &CombinedIdentity) -> Result<CombinedLight, Error> {
    let mut decoder = Decoder(ENVELOPE.open(bytes).map_err(Error::of_file(path))?);
    let (found, light) = decode(&mut decoder).ok_or_else(|| senseless(path))?;
    found.check(identity).map_err(Error::of_file(path))?;
    Ok(light)
}

fn decode(decoder: &mut Decoder<'_>) -> Option<(CombinedIdentity, CombinedLight)> {
    let identity = CombinedIdentity {
        particles: TallyIdentity::decode(decoder)?,
        tolerance: f64::from_bits(decoder.u64()?),
    };
    let light = CombinedLight::decode(decoder)?;
    decoder.0.is_empty().then_some((identity, light))
}

/// Writes `light` to the file `path`.
pub(super) fn write(path: &Path, identity: &CombinedIdentity, light: &CombinedLight) -> Result<(), Error> {
    let bytes = ENVELOPE.seal(|encoder| {
        identity.particles.encode(encoder);
        encoder.u64(identity.tolerance.to_bits());
        light.encode(encoder);
    });
    file::write(path, &bytes)
}
