//! Checkpoints of inverse designs.
//!
//! | bytes | content |
//! |---|---|
//! | 8, 4, 8 | `GLANZOPT`, version of the format, length of the file |
//! | 1 + n, 16 | version of Glanz, content hash of the scene |
//! | 8, 4, 8, 1 | number of rays, largest number of steps, seed, 1 for gradients by differences, else 0 |
//! | 4, 8, 4, 4, 1 | steps and evaluations so far, levels of distributions that do not count yet, rounds since one was added, whether the search has ended |
//! | 8, 8 n | number of displacements, and these, metres |
//! | 4 | CRC-32 (IEEE) of all before |

use std::path::Path;

use glanz_illumination::optimize::{GradientMethod, OptimizeSettings, OptimizeState};
use glanz_job::{JobIdentity, current_version};
use glanz_transport::codec::{Decoder, FileEnvelope};

use crate::error::{Error, FileFault};
use crate::file;
use crate::loaded_scene::LoadedScene;

/// Envelope of the file.
const ENVELOPE: FileEnvelope = FileEnvelope {
    magic: b"GLANZOPT",
    version: 1,
    content: "the checkpoint",
    kind: "a checkpoint of an inverse design",
};

/// Everything that a search depends on.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct StateIdentity {
    version: String,
    scene: u128,
    variables: u64,
    settings: OptimizeSettings,
}

impl StateIdentity {
    pub(super) fn new(scene: &LoadedScene, settings: &OptimizeSettings) -> Self {
        let variables = scene.description().design.variables.len() as u64;
        Self { version: current_version(), scene: scene.content_hash(), variables, settings: *settings }
    }
}

impl JobIdentity for StateIdentity {
    const FOREIGN: &'static str = "it is of another inverse design";

    fn fields(&self) -> Vec<(&'static str, String)> {
        vec![
            ("the Glanz version", self.version.clone()),
            ("the scene (content hash)", format!("{:032x}", self.scene)),
            ("the number of free numbers", self.variables.to_string()),
            ("the number of rays", self.settings.rays.to_string()),
            ("the seed", self.settings.seed.to_string()),
            ("the computation of gradients", format!("{:?}", self.settings.gradient)),
        ]
    }
}

/// The file of a state.
pub(super) struct StateFile;

impl StateFile {
    /// Writes `state` to the file `path`.
    pub(super) fn write(path: &Path, identity: &StateIdentity, state: &OptimizeState) -> Result<(), Error> {
        let bytes = ENVELOPE.seal(|encoder| {
            encoder.text(&identity.version);
            encoder.u128(identity.scene);
            encoder.u64(identity.settings.rays as u64);
            encoder.u32(identity.settings.iterations);
            encoder.u64(identity.settings.seed);
            encoder.u8((identity.settings.gradient == GradientMethod::Differences).into());
            encoder.u32(state.iterations);
            encoder.u64(state.evaluations);
            state.skipped_levels.into_iter().for_each(|number| encoder.u32(number));
            encoder.u8(state.is_complete.into());
            encoder.u64(state.displacements.len() as u64);
            state.displacements.iter().for_each(|displacement| encoder.f64(*displacement));
        });
        file::write(path, &bytes)
    }

    /// Reads the bytes of the file `path`; refuses those of another search. One that had ended at its largest number of steps continues under a larger one.
    pub(super) fn from_bytes(
        path: &Path,
        bytes: &[u8],
        wanted: &StateIdentity,
    ) -> Result<OptimizeState, Error> {
        let content = ENVELOPE.open(bytes).map_err(Error::of_file(path))?;
        let (identity, mut state) = decode(&mut Decoder(content), wanted)
            .ok_or_else(|| FileFault::Content(ENVELOPE.content).of(path))?;
        identity.check(wanted).map_err(Error::of_file(path))?;
        state.is_complete &=
            state.iterations < identity.settings.iterations || state.iterations >= wanted.settings.iterations;
        Ok(state)
    }
}

fn decode(decoder: &mut Decoder<'_>, wanted: &StateIdentity) -> Option<(StateIdentity, OptimizeState)> {
    let (version, scene) = (decoder.text()?.to_owned(), decoder.u128()?);
    let settings = OptimizeSettings {
        rays: usize::try_from(decoder.u64()?).ok()?,
        iterations: decoder.u32()?,
        seed: decoder.u64()?,
        gradient: if decoder.u8()? == 0 { GradientMethod::Adjoint } else { GradientMethod::Differences },
    };
    let (iterations, evaluations) = (decoder.u32()?, decoder.u64()?);
    let (skipped_levels, is_complete) = ([decoder.u32()?, decoder.u32()?], decoder.u8()? != 0);
    let variables = decoder.u64()?;
    let is_known = variables == wanted.variables;
    let mut displacements = Vec::new();
    while let (true, Some(displacement)) = (is_known, decoder.f64()) {
        displacements.push(displacement);
    }
    let is_whole = !is_known || displacements.len() as u64 == variables && decoder.0.is_empty();
    let state = OptimizeState { displacements, iterations, evaluations, skipped_levels, is_complete };
    is_whole.then_some((StateIdentity { version, scene, variables, settings }, state))
}
