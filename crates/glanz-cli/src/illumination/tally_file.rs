//! Files of what particles brought, to go on from.
//!
//! | bytes | content |
//! |---|---|
//! | 8 | `GLANZLUX` |
//! | 4 | version of the format |
//! | 8 | length of the file |
//! | 1 + n, 16 | version of Glanz, fingerprint of scene and receivers |
//! | 8, 4 | seed, largest depth |
//! | | sums, as [`Tally::encode`] writes them |
//! | 4 | CRC-32 (IEEE) of all before |

use std::path::Path;

use glanz_formats::image::write_atomically;
use glanz_illumination::{FarFieldGrid, Receivers, Tally};
use glanz_job::{JobIdentity, current_version};
use glanz_transport::codec::{Decoder, EnvelopeError, open, seal};

use crate::messages::Failure;

const MAGIC: &[u8; 8] = b"GLANZLUX";
const VERSION: u32 = 1;

/// What particles depend on.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct TallyIdentity {
    version: String,
    scene: u128,
    seed: u64,
    max_depth: u32,
}

impl TallyIdentity {
    /// Of a calculation by this program; `scene`: fingerprint of the scene and its receivers.
    pub(crate) fn new(scene: u128, seed: u64, max_depth: u32) -> Self {
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

/// Puts `tally` into the file `path`; until it is all there, the file keeps its old content.
///
/// # Errors
/// Why the file cannot be written.
pub(crate) fn write(path: &Path, identity: &TallyIdentity, tally: &Tally) -> Result<(), Failure> {
    let bytes = seal(MAGIC, VERSION, |encoder| {
        encoder.text(&identity.version);
        encoder.u128(identity.scene);
        encoder.u64(identity.seed);
        encoder.u32(identity.max_depth);
        tally.encode(encoder);
    });
    write_atomically(path, &bytes).map_err(|error| Failure::new(error.to_string()))
}

/// Reads the file `path`.
///
/// # Errors
/// Why it cannot be read, or is no tally of this calculation.
pub(crate) fn read(
    path: &Path,
    wanted: &TallyIdentity,
    receivers: &Receivers,
    far_field: Option<FarFieldGrid>,
) -> Result<Tally, Failure> {
    let failure = |what: &dyn std::fmt::Display| Failure::new(format!("{}: {what}", path.display()));
    let bytes = std::fs::read(path).map_err(|error| failure(&error))?;
    let content = open(MAGIC, VERSION, &bytes).map_err(|error| match error {
        EnvelopeError::Foreign => failure(&"this is no checkpoint of glanz illuminate"),
        EnvelopeError::Version(version) => {
            failure(&format!("the checkpoint has format {version}, this program reads format {VERSION}"))
        }
        error => failure(&format!("the checkpoint is damaged: {error}")),
    })?;
    let mut decoder = Decoder(content);
    let senseless = || failure(&"the checkpoint makes no sense");
    let identity = |decoder: &mut Decoder<'_>| {
        Some(TallyIdentity {
            version: decoder.text()?.to_owned(),
            scene: decoder.u128()?,
            seed: decoder.u64()?,
            max_depth: decoder.u32()?,
        })
    };
    identity(&mut decoder).ok_or_else(senseless)?.check(wanted).map_err(|mismatch| failure(&mismatch))?;
    Tally::decode(&mut decoder, receivers, far_field).ok_or_else(senseless)
}
