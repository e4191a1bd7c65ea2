//! Files of baked light: what a bake has found so far, or all of it.
//!
//! | bytes | content |
//! |---|---|
//! | 8 | `GLANZLGT` |
//! | 4 | version of the format |
//! | 8 | length of the file |
//! | 1 + n, 16 | version of Glanz, fingerprint of the scene |
//! | 8, 4, 4 | texels per metre, rays, shadow rays |
//! | 1 | 0: not finished, as [`BakeState`] writes it; 1: light maps, as [`stored`] does; plus 2 times the number of the method |
//! | | that |
//! | 4 | CRC-32 (IEEE) of all before |

use std::path::{Path, PathBuf};

use glanz_job::{ContentHash, IdentityMismatch, JobIdentity, current_version};
use glanz_radiosity::bake::{BakeMethod, BakeSettings, BakeState, LightMap, stored};
use glanz_radiosity::elements::Elements;
use glanz_transport::codec::{Decoder, FileEnvelope};

use crate::error::{Error, FileFault};
use crate::file;

/// The file.
const ENVELOPE: FileEnvelope =
    FileEnvelope { magic: b"GLANZLGT", version: 1, content: "the light", kind: "baked light of Glanz" };

/// What light depends on.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LightIdentity {
    /// Of Glanz.
    version: String,
    /// Fingerprint.
    scene: u128,
    settings: BakeSettings,
}

impl LightIdentity {
    /// Of a bake by this program.
    pub(super) fn new(scene: u128, settings: BakeSettings) -> Self {
        Self { version: current_version(), scene, settings }
    }

    /// Checks that this is light of a scene, by this program.
    fn check_scene(&self, scene: u128) -> Result<(), IdentityMismatch> {
        self.check(&Self::new(scene, self.settings))
    }
}

impl JobIdentity for LightIdentity {
    const FOREIGN: &'static str = "it holds other light";

    fn fields(&self) -> Vec<(&'static str, String)> {
        let BakeSettings { density, rays, shadow_rays, method } = self.settings;
        vec![
            ("the Glanz version", self.version.clone()),
            ("the scene (content hash)", format!("{:032x}", self.scene)),
            ("the number of texels per metre", density.to_string()),
            ("the number of rays", rays.to_string()),
            ("the number of shadow rays", shadow_rays.to_string()),
            ("the method", method.name().to_owned()),
        ]
    }
}

/// Baked light that was read from a file.
#[derive(Clone, Debug)]
pub struct LightFile {
    path: PathBuf,
    identity: LightIdentity,
    content: LightContent,
    /// Fingerprint of the file.
    pub(crate) hash: u128,
}

#[derive(Clone, Debug)]
enum LightContent {
    Unfinished(BakeState),
    /// Light maps in bytes: only the scene tells where they lie.
    Finished(Vec<u8>),
}

/// Where a bake begins.
#[derive(Debug)]
pub(super) enum BakeStart {
    /// With what was found, which may be nothing.
    State(BakeState),
    /// There is nothing left to find.
    Finished(Vec<LightMap>),
}

impl LightFile {
    /// Reads the file `path`.
    ///
    /// # Errors
    /// [`Error::File`].
    pub fn read(path: &Path) -> Result<Self, Error> {
        let bytes = file::read(path)?;
        let content = ENVELOPE.open(&bytes).map_err(Error::of_file(path))?;
        let mut hash = ContentHash::default();
        hash.add_file(&bytes);
        let senseless = || FileFault::Content(ENVELOPE.content).of(path);
        let (identity, content) = decode(content).ok_or_else(senseless)?;
        Ok(Self { path: path.to_owned(), identity, content, hash: hash.value() })
    }

    /// Where the bake `wanted` of `elements` resumes.
    pub(super) fn start(self, wanted: &LightIdentity, elements: &Elements<'_>) -> Result<BakeStart, Error> {
        self.identity.check(wanted).map_err(Error::of_file(&self.path))?;
        match &self.content {
            LightContent::Unfinished(state) => Ok(BakeStart::State(state.clone())),
            LightContent::Finished(_) => Ok(BakeStart::Finished(self.maps(elements)?)),
        }
    }

    /// Refuses light of another scene than that of this fingerprint, and light of which a part is missing.
    ///
    /// # Errors
    /// [`Error::File`] with [`FileFault::OtherLight`] or [`FileFault::UnfinishedLight`].
    pub fn check(&self, scene: u128) -> Result<(), Error> {
        let checked = self.identity.check_scene(scene);
        checked.map_err(|mismatch| FileFault::OtherLight(mismatch).of(&self.path))?;
        match &self.content {
            LightContent::Finished(_) => Ok(()),
            LightContent::Unfinished(_) => Err(FileFault::UnfinishedLight.of(&self.path)),
        }
    }

    /// Texels per metre.
    #[must_use]
    pub fn density(&self) -> f64 {
        self.identity.settings.density
    }

    /// The light maps of `elements`, after [`LightFile::check`].
    ///
    /// # Errors
    /// [`Error::File`] if they are of something else.
    pub fn maps(&self, elements: &Elements<'_>) -> Result<Vec<LightMap>, Error> {
        let bytes: &[u8] = match &self.content {
            LightContent::Finished(bytes) => bytes,
            LightContent::Unfinished(_) => &[],
        };
        stored::from_bytes(elements, self.density(), bytes)
            .ok_or_else(|| FileFault::Content(ENVELOPE.content).of(&self.path))
    }
}

fn decode(content: &[u8]) -> Option<(LightIdentity, LightContent)> {
    let mut d = Decoder(content);
    let (version, scene) = (d.text()?.to_owned(), d.u128()?);
    let (density, rays, shadow_rays, kind) = (d.f64()?, d.u32()?, d.u32()?, d.u8()?);
    let settings = BakeSettings { density, rays, shadow_rays, method: BakeMethod::from_number(kind / 2)? };
    let content = match kind % 2 {
        0 => LightContent::Unfinished(BakeState::from_bytes(d.0)?),
        1 => LightContent::Finished(d.0.to_vec()),
        _ => return None,
    };
    Some((LightIdentity { version, scene, settings }, content))
}

/// Writes what was found so far to the file `path`.
pub(super) fn write_state(path: &Path, identity: &LightIdentity, state: &BakeState) -> Result<(), Error> {
    write(path, identity, 0, &state.to_bytes())
}

/// Writes all light maps to the file `path`.
pub(super) fn write_maps(path: &Path, identity: &LightIdentity, maps: &[LightMap]) -> Result<(), Error> {
    write(path, identity, 1, &stored::to_bytes(maps))
}

fn write(path: &Path, identity: &LightIdentity, kind: u8, content: &[u8]) -> Result<(), Error> {
    let LightIdentity { version, scene, settings } = identity;
    let bytes = ENVELOPE.seal(|e| {
        e.text(version);
        e.u128(*scene);
        e.f64(settings.density);
        e.u32(settings.rays);
        e.u32(settings.shadow_rays);
        e.u8(kind + 2 * settings.method.number());
        e.0.extend_from_slice(content);
    });
    file::write(path, &bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn other_light_is_distinguished() {
        let settings = BakeSettings::default();
        let identity = LightIdentity::new(7, settings);
        assert_eq!(identity.check(&identity.clone()), Ok(()));
        assert!(identity.check_scene(8).unwrap_err().to_string().contains("the scene"));
        let finer = LightIdentity::new(7, BakeSettings { density: 26.0, ..settings });
        assert!(identity.check(&finer).unwrap_err().to_string().contains("per metre is 25, not 26"));
        let older = LightIdentity { version: "0.0.0".to_owned(), ..identity.clone() };
        assert!(older.check(&identity).unwrap_err().to_string().contains("version"));
        assert_eq!(finer.check_scene(7), Ok(()));
    }
}
