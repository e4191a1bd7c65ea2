//! Checkpoints of particle tallies.
//!
//! | bytes | content |
//! |---|---|
//! | 8 | `GLANZLUX` |
//! | 4 | version of the format |
//! | 8 | length of the file |
//! | 1 + n, 16 | version of Glanz, content hash of scene and receivers |
//! | 8, 4 | seed, largest depth |
//! | | sums, as [`Tally::encode`] writes them |
//! | 4 | CRC-32 (IEEE) of all before |

use std::path::Path;

use glanz_illumination::{FarFieldGrid, Receivers, Tally};
use glanz_job::{JobIdentity, current_version};
use glanz_transport::codec::{Decoder, FileEnvelope};

use crate::error::{Error, FileFault};
use crate::file;

/// Envelope of the file.
const ENVELOPE: FileEnvelope = FileEnvelope {
    magic: b"GLANZLUX",
    version: 1,
    content: "the checkpoint",
    kind: "a checkpoint of illuminance",
};

/// Identity of a tally: everything that its particles depend on.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct TallyIdentity {
    version: String,
    scene: u128,
    seed: u64,
    max_depth: u32,
}

impl TallyIdentity {
    /// The identity of a calculation by this program; `scene`: content hash of the scene and its receivers.
    pub(super) fn new(scene: u128, seed: u64, max_depth: u32) -> Self {
        Self { version: current_version(), scene, seed, max_depth }
    }
}

impl JobIdentity for TallyIdentity {
    const FOREIGN: &'static str = "it holds another calculation";

    fn fields(&self) -> Vec<(&'static str, String)> {
        vec![
            ("the Glanz version", self.version.clone()),
            ("the scene with its receivers (content hash)", format!("{:032x}", self.scene)),
            ("the seed", self.seed.to_string()),
            ("the depth", self.max_depth.to_string()),
        ]
    }
}

/// Writes `tally` to the file `path`.
pub(super) fn write(path: &Path, identity: &TallyIdentity, tally: &Tally) -> Result<(), Error> {
    let bytes = ENVELOPE.seal(|encoder| {
        encoder.text(&identity.version);
        encoder.u128(identity.scene);
        encoder.u64(identity.seed);
        encoder.u32(identity.max_depth);
        tally.encode(encoder);
    });
    file::write(path, &bytes)
}

/// Reads a tally of the calculation `wanted` from the file `path`.
pub(super) fn read(
    path: &Path,
    wanted: &TallyIdentity,
    receivers: &Receivers,
    far_field: Option<FarFieldGrid>,
) -> Result<Tally, Error> {
    let bytes = file::read(path)?;
    let content = ENVELOPE.open(&bytes).map_err(Error::of_file(path))?;
    let mut decoder = Decoder(content);
    let senseless = || FileFault::Content(ENVELOPE.content).of(path);
    let identity = identity(&mut decoder).ok_or_else(senseless)?;
    identity.check(wanted).map_err(Error::of_file(path))?;
    Tally::decode(&mut decoder, receivers, far_field).ok_or_else(senseless)
}

fn identity(decoder: &mut Decoder<'_>) -> Option<TallyIdentity> {
    Some(TallyIdentity {
        version: decoder.text()?.to_owned(),
        scene: decoder.u128()?,
        seed: decoder.u64()?,
        max_depth: decoder.u32()?,
    })
}
