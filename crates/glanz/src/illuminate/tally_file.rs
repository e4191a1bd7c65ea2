//! Checkpoints of particle tallies.
//!
//! | bytes | content |
//! |---|---|
//! | 8 | `GLANZLUX` |
//! | 4 | version of the format |
//! | 8 | length of the file |
//! | 1 + n, 16, 16 | version of Glanz, content hashes of the scene and of the receivers |
//! | 1, 8, 8 | of directions: 0 if they are not counted, 1 for adaptive angles, 2 for the equal steps of gamma and of planes that follow, degrees; otherwise 0, 0 |
//! | 8, 4 | seed, largest depth |
//! | 8, 4, 4 | of a part: particles of the whole, number of parts, number of the part, 0 for joined parts; otherwise 0, 0, 0 |
//! | | particles and sums, as [`Tally::encode`] writes them |
//! | 4 | CRC-32 (IEEE) of all before |

use std::path::Path;

use glanz_illumination::{AngleStep, FarFieldResolution, Tally};
use glanz_job::{IdentityMismatch, JobIdentity, JobPart, current_version};
use glanz_report::number::grouped;
use glanz_transport::codec::{Decoder, Encoder, FileEnvelope};

use crate::error::{Error, FileFault};
use crate::file;

/// Envelope of the file.
const ENVELOPE: FileEnvelope = FileEnvelope {
    magic: b"GLANZLUX",
    version: 3,
    content: "the checkpoint",
    kind: "a checkpoint of illuminance",
};

/// Identity of a tally: everything that its particles depend on.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct TallyIdentity {
    /// Version of Glanz.
    pub(super) version: String,
    /// Content hash of the scene, with the walls of a room.
    pub(super) scene: u128,
    /// Content hash of the names and cells of the receivers.
    pub(super) receivers: u128,
    /// Angles by which light that leaves the scene is counted.
    pub(super) far_field: Option<FarFieldResolution>,
    pub(super) seed: u64,
    pub(super) max_depth: u32,
}

impl JobIdentity for TallyIdentity {
    const FOREIGN: &'static str = "it holds another calculation";

    fn fields(&self) -> Vec<(&'static str, String)> {
        let far_field = match self.far_field {
            None => "not counted".to_owned(),
            Some(FarFieldResolution::Adaptive) => "counted on angles that adapt to the light".to_owned(),
            Some(FarFieldResolution::Steps { gamma, plane }) => format!(
                "counted in steps of {} degrees of gamma and {} of C",
                gamma.degrees(),
                plane.degrees()
            ),
        };
        vec![
            ("the Glanz version", self.version.clone()),
            ("the scene (content hash)", format!("{:032x}", self.scene)),
            ("the list of receivers with their cells (content hash)", format!("{:032x}", self.receivers)),
            ("the far field", far_field),
            ("the seed", self.seed.to_string()),
            ("the depth", self.max_depth.to_string()),
        ]
    }
}

impl TallyIdentity {
    pub(super) fn encode(&self, encoder: &mut Encoder) {
        encoder.text(&self.version);
        encoder.u128(self.scene);
        encoder.u128(self.receivers);
        encode_resolution(self.far_field, encoder);
        encoder.u64(self.seed);
        encoder.u32(self.max_depth);
    }

    pub(super) fn decode(decoder: &mut Decoder<'_>) -> Option<Self> {
        Some(Self {
            version: decoder.text()?.to_owned(),
            scene: decoder.u128()?,
            receivers: decoder.u128()?,
            far_field: decode_resolution(decoder)?,
            seed: decoder.u64()?,
            max_depth: decoder.u32()?,
        })
    }
}

/// Division of a calculation into parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct TallyPlan {
    /// Particles of the whole.
    pub(super) particles: u64,
    /// Number of parts.
    pub(super) count: u32,
    /// The part; `None` for joined parts.
    pub(super) part: Option<JobPart>,
}

impl JobIdentity for TallyPlan {
    const FOREIGN: &'static str = TallyIdentity::FOREIGN;

    fn fields(&self) -> Vec<(&'static str, String)> {
        vec![
            ("the number of particles", grouped(self.particles)),
            ("the number of parts", self.count.to_string()),
            ("the part", self.part.map_or("joined".to_owned(), |part| part.to_string())),
        ]
    }
}

impl TallyPlan {
    fn encode(plan: Option<Self>, encoder: &mut Encoder) {
        encoder.u64(plan.map_or(0, |plan| plan.particles));
        encoder.u32(plan.map_or(0, |plan| plan.count));
        encoder.u32(plan.and_then(|plan| plan.part).map_or(0, JobPart::number));
    }

    #[expect(clippy::option_option, reason = "malformed, or without a plan")]
    fn decode(decoder: &mut Decoder<'_>) -> Option<Option<Self>> {
        let (particles, count, number) = (decoder.u64()?, decoder.u32()?, decoder.u32()?);
        match (count, number) {
            (0, 0) => Some(None),
            // Joined parts have a count only.
            _ if JobPart::try_new(number.max(1), count).is_none() => None,
            _ => Some(Some(Self { particles, count, part: JobPart::try_new(number, count) })),
        }
    }
}

/// A tally with everything that decides what it may be joined with.
#[derive(Clone, Debug)]
pub(super) struct TallyFile {
    pub(super) identity: TallyIdentity,
    /// Of a part.
    pub(super) plan: Option<TallyPlan>,
    pub(super) tally: Tally,
}

impl TallyFile {
    /// Reads the bytes of the file `path`.
    pub(super) fn from_bytes(path: &Path, bytes: &[u8]) -> Result<Self, Error> {
        let content = ENVELOPE.open(bytes).map_err(Error::of_file(path))?;
        decode(&mut Decoder(content)).ok_or_else(|| Self::senseless(path))
    }

    /// Whether the bytes of a file begin as those of a tally.
    pub(super) fn is_begun_by(bytes: &[u8]) -> bool {
        bytes.starts_with(ENVELOPE.magic)
    }

    /// The error of a file with invalid content.
    pub(super) fn senseless(path: &Path) -> Error {
        FileFault::Content(ENVELOPE.content).of(path)
    }

    /// Refuses a tally of another calculation, or of another part than `part`.
    pub(super) fn check(
        &self,
        identity: &TallyIdentity,
        part: Option<TallyPlan>,
    ) -> Result<(), IdentityMismatch> {
        self.identity.check(identity)?;
        match (self.plan, part) {
            (Some(plan), Some(part)) => plan.check(&part),
            (None, Some(part)) => Err(IdentityMismatch {
                foreign: TallyIdentity::FOREIGN,
                what: "the part",
                found: "all of it".to_owned(),
                wanted: part.part.map_or_else(String::new, |part| part.to_string()),
            }),
            _ => Ok(()),
        }
    }
}

/// Writes `tally` to the file `path`.
pub(super) fn write(
    path: &Path,
    identity: &TallyIdentity,
    plan: Option<TallyPlan>,
    tally: &Tally,
) -> Result<(), Error> {
    let bytes = ENVELOPE.seal(|encoder| {
        identity.encode(encoder);
        TallyPlan::encode(plan, encoder);
        tally.encode(encoder);
    });
    file::write(path, &bytes)
}

fn decode(decoder: &mut Decoder<'_>) -> Option<TallyFile> {
    let identity = TallyIdentity::decode(decoder)?;
    let (plan, tally) = (TallyPlan::decode(decoder)?, Tally::decode(decoder)?);
    decoder.0.is_empty().then_some(TallyFile { identity, plan, tally })
}

fn encode_resolution(resolution: Option<FarFieldResolution>, encoder: &mut Encoder) {
    let (kind, steps) = match resolution {
        None => (0, [0.0; 2]),
        Some(FarFieldResolution::Adaptive) => (1, [0.0; 2]),
        Some(FarFieldResolution::Steps { gamma, plane }) => (2, [gamma.degrees(), plane.degrees()]),
    };
    encoder.u8(kind);
    steps.into_iter().for_each(|degrees| encoder.u64(degrees.to_bits()));
}

#[expect(clippy::option_option, reason = "malformed, or without directions")]
fn decode_resolution(decoder: &mut Decoder<'_>) -> Option<Option<FarFieldResolution>> {
    let kind = decoder.u8()?;
    let steps = [f64::from_bits(decoder.u64()?), f64::from_bits(decoder.u64()?)];
    match (kind, steps.map(AngleStep::try_new)) {
        (0, _) if steps == [0.0; 2] => Some(None),
        (1, _) if steps == [0.0; 2] => Some(Some(FarFieldResolution::Adaptive)),
        (2, [Ok(gamma), Ok(plane)]) => Some(Some(FarFieldResolution::Steps { gamma, plane })),
        _ => None,
    }
}

/// The identity of a calculation by this program.
pub(super) fn identity(
    [scene, receivers]: [u128; 2],
    far_field: Option<FarFieldResolution>,
    seed: u64,
    max_depth: u32,
) -> TallyIdentity {
    TallyIdentity { version: current_version(), scene, receivers, far_field, seed, max_depth }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn resolutions_are_read_as_they_were_written() {
        let steps = |gamma, plane| {
            let [gamma, plane] = [gamma, plane].map(|degrees| AngleStep::try_new(degrees).unwrap());
            Some(FarFieldResolution::Steps { gamma, plane })
        };
        for resolution in [None, Some(FarFieldResolution::Adaptive), steps(0.5, 15.0)] {
            let mut encoder = Encoder::default();
            encode_resolution(resolution, &mut encoder);
            assert_eq!(decode_resolution(&mut Decoder(&encoder.0)), Some(resolution));
            // Neither another kind nor steps that are none.
            let changed = |at: usize, byte: u8| {
                let mut bytes = encoder.0.clone();
                bytes[at] = byte;
                decode_resolution(&mut Decoder(&bytes))
            };
            assert_eq!((changed(0, 3), changed(16, 0x7f)), (None, None));
        }
    }

    #[test]
    fn plans_with_impossible_parts_are_refused() {
        let read = |count: u32, number: u32| {
            let mut encoder = Encoder::default();
            encoder.u64(1000);
            encoder.u32(count);
            encoder.u32(number);
            TallyPlan::decode(&mut Decoder(&encoder.0))
        };
        assert_eq!(read(0, 0), Some(None));
        assert_eq!(read(3, 0), Some(Some(TallyPlan { particles: 1000, count: 3, part: None })));
        assert_eq!(read(3, 2).flatten().and_then(|plan| plan.part), JobPart::try_new(2, 3));
        for (count, number) in [(0, 1), (3, 4), (u32::MAX, 0), (u32::MAX, 1)] {
            assert_eq!(read(count, number), None, "{number}/{count}");
        }
    }
}
