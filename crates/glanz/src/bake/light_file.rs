//! Files of baked light: the state of an unfinished bake, or all light maps.
//!
//! | bytes | content |
//! |---|---|
//! | 8 | `GLANZLGT` |
//! | 4 | version of the format |
//! | 8 | length of the file |
//! | 1 + n, 16 | version of Glanz, fingerprint of the scene |
//! | 8, 4, 4 | texels per metre, rays, shadow rays |
//! | 1 | 0: not finished, as [`BakeState::write`] writes it; 1: light maps, as [`stored`] does; plus 2 times the number of the method |
//! | 0 or 8 | exponent of the method's interpolation, if it has one |
//! | | that state or those light maps |
//! | 4 | CRC-32 (IEEE) of all before |

use std::path::{Path, PathBuf};

use glanz_job::{ContentHash, IdentityMismatch, JobIdentity, current_version};
use glanz_radiosity::bake::{BakeMethod, BakeSettings, BakeState, LightMap, stored};
use glanz_radiosity::elements::Elements;
use glanz_radiosity::reconstruct::Interpolation;
use glanz_transport::codec::{Decoder, FileEnvelope};

use crate::error::{Error, FileFault};
use crate::file;

/// Envelope of the file.
const ENVELOPE: FileEnvelope =
    FileEnvelope { magic: b"GLANZLGT", version: 2, content: "the light", kind: "baked light of Glanz" };

/// Identity of baked light: everything that it depends on.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LightIdentity {
    /// Version of Glanz.
    version: String,
    /// Content hash of the scene.
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
        let BakeSettings { density, rays, shadow_rays, mut method } = self.settings;
        let name = method.name();
        let method = exponent(&mut method).map_or(name.to_owned(), |x| format!("{name} with exponent {x}"));
        vec![
            ("the Glanz version", self.version.clone()),
            ("the scene (content hash)", format!("{:032x}", self.scene)),
            ("the number of texels per metre", density.to_string()),
            ("the number of rays", rays.to_string()),
            ("the number of shadow rays", shadow_rays.to_string()),
            ("the method", method),
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
    /// Light maps in bytes, which only the scene's elements can decode.
    Finished(Vec<u8>),
}

/// Start of a bake.
#[derive(Debug)]
pub(super) enum BakeStart {
    /// A state to resume from, possibly empty.
    State(BakeState),
    /// Finished light maps.
    Finished(Vec<LightMap>),
}

impl LightFile {
    /// Reads the file `path`.
    ///
    /// # Errors
    /// [`Error::File`].
    pub fn read(path: &Path) -> Result<Self, Error> {
        Self::from_bytes(path, &file::read(path)?)
    }

    /// Reads the bytes of the file `path`.
    pub(super) fn from_bytes(path: &Path, bytes: &[u8]) -> Result<Self, Error> {
        let content = ENVELOPE.open(bytes).map_err(Error::of_file(path))?;
        let mut hash = ContentHash::default();
        hash.add_file(bytes);
        let senseless = || FileFault::Content(ENVELOPE.content).of(path);
        let (identity, content) = decode(content).ok_or_else(senseless)?;
        Ok(Self { path: path.to_owned(), identity, content, hash: hash.value() })
    }

    /// The start of the bake `wanted` of `elements`.
    pub(super) fn start(self, wanted: &LightIdentity, elements: &Elements<'_>) -> Result<BakeStart, Error> {
        self.identity.check(wanted).map_err(Error::of_file(&self.path))?;
        match &self.content {
            LightContent::Unfinished(state) => Ok(BakeStart::State(state.clone())),
            LightContent::Finished(_) => Ok(BakeStart::Finished(self.maps(elements)?)),
        }
    }

    /// The state of a bake with its identity, unless it is finished.
    pub(super) fn into_state(self) -> Option<(LightIdentity, BakeState)> {
        match self.content {
            LightContent::Unfinished(state) => Some((self.identity, state)),
            LightContent::Finished(_) => None,
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

/// The exponent of the interpolation, which the number of a method does not tell.
fn exponent(method: &mut BakeMethod) -> Option<&mut f64> {
    match method {
        BakeMethod::Radiosity {
            reconstruction: Interpolation::Shepard { exponent } | Interpolation::Multiquadrics { exponent },
        } => Some(exponent),
        _ => None,
    }
}

fn decode(content: &[u8]) -> Option<(LightIdentity, LightContent)> {
    let mut d = Decoder(content);
    let (version, scene) = (d.text()?.to_owned(), d.u128()?);
    let (density, rays, shadow_rays, kind) = (d.f64()?, d.u32()?, d.u32()?, d.u8()?);
    let mut method = BakeMethod::from_number(kind / 2)?;
    if let Some(exponent) = exponent(&mut method) {
        *exponent = d.f64()?;
    }
    let settings = BakeSettings { density, rays, shadow_rays, method };
    let content = match kind % 2 {
        0 => LightContent::Unfinished(BakeState::from_bytes(d.0)?),
        1 => LightContent::Finished(d.0.to_vec()),
        _ => return None,
    };
    Some((LightIdentity { version, scene, settings }, content))
}

/// Writes the state of an unfinished bake to the file `path`.
pub(super) fn write_state(path: &Path, identity: &LightIdentity, state: &BakeState) -> Result<(), Error> {
    write(path, identity, 0, |bytes| state.write(bytes))
}

/// Writes all light maps to the file `path`.
pub(super) fn write_maps(path: &Path, identity: &LightIdentity, maps: &[LightMap]) -> Result<(), Error> {
    write(path, identity, 1, |bytes| bytes.extend(stored::to_bytes(maps)))
}

fn write(
    path: &Path,
    identity: &LightIdentity,
    kind: u8,
    content: impl FnOnce(&mut Vec<u8>),
) -> Result<(), Error> {
    let LightIdentity { version, scene, mut settings } = identity.clone();
    let bytes = ENVELOPE.seal(|e| {
        e.text(&version);
        e.u128(scene);
        e.f64(settings.density);
        e.u32(settings.rays);
        e.u32(settings.shadow_rays);
        e.u8(kind + 2 * settings.method.number());
        if let Some(exponent) = exponent(&mut settings.method) {
            e.f64(*exponent);
        }
        content(&mut e.0);
    });
    file::write(path, &bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn other_light_is_distinguished() {
        let settings = BakeSettings { density: 25.0, ..BakeSettings::default() };
        let identity = LightIdentity::new(7, settings);
        assert_eq!(identity.check(&identity.clone()), Ok(()));
        assert!(identity.check_scene(8).unwrap_err().to_string().contains("the scene"));
        let finer = LightIdentity::new(7, BakeSettings { density: 26.0, ..settings });
        assert!(identity.check(&finer).unwrap_err().to_string().contains("per metre is 25, not 26"));
        let older = LightIdentity { version: "0.0.0".to_owned(), ..identity.clone() };
        assert!(older.check(&identity).unwrap_err().to_string().contains("version"));
        assert_eq!(finer.check_scene(7), Ok(()));
    }

    #[test]
    fn methods_come_back_with_their_exponents() {
        let path = std::env::temp_dir().join(format!("glanz-light-file-{}", std::process::id()));
        let methods = (0..).map_while(BakeMethod::from_number);
        let shepard = BakeMethod::Radiosity { reconstruction: Interpolation::Shepard { exponent: 2.0 } };
        for method in methods.chain([shepard]) {
            let identity = LightIdentity::new(7, BakeSettings { method, ..BakeSettings::default() });
            write_state(&path, &identity, &BakeState::default()).unwrap();
            assert_eq!(LightFile::read(&path).unwrap().identity, identity);
        }
        let default = BakeMethod::from_name("shepard").unwrap();
        let other = LightIdentity::new(7, BakeSettings { method: default, ..BakeSettings::default() });
        let mismatch = LightFile::read(&path).unwrap().identity.check(&other).unwrap_err();
        assert!(mismatch.to_string().contains("the method"), "{mismatch}");
        std::fs::remove_file(&path).unwrap();
    }
}
