//! Files of baked light: what a bake has found so far, or all of it.
//!
//! | bytes | content |
//! |---|---|
//! | 8 | `GLANZLGT` |
//! | 4 | version of the format |
//! | 8 | length of the file |
//! | 1 + n, 16 | version of Glanz, fingerprint of the scene |
//! | 8, 4, 4 | texels per metre, rays, shadow rays |
//! | 1 | 0: not finished, as [`BakeState`] writes it; 1: light maps, as [`stored`] does |
//! | | that |
//! | 4 | CRC-32 (IEEE) of all before |

use std::path::Path;

use glanz_formats::ContentHash;
use glanz_formats::image::write_atomically;
use glanz_job::{IdentityMismatch, JobIdentity, current_version};
use glanz_radiosity::bake::{BakeSettings, BakeState, LightMap, stored};
use glanz_radiosity::elements::Elements;
use glanz_transport::codec::{Decoder, EnvelopeError, open, seal};

use crate::messages::Failure;

const MAGIC: &[u8; 8] = b"GLANZLGT";
const VERSION: u32 = 1;

/// What light depends on.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LightIdentity {
    /// Of Glanz.
    version: String,
    /// Fingerprint.
    scene: u128,
    pub(crate) settings: BakeSettings,
}

impl LightIdentity {
    /// Of a bake by this program.
    pub(crate) fn new(scene: u128, settings: BakeSettings) -> Self {
        Self { version: current_version(), scene, settings }
    }

    /// Whether this is light of a scene, by this program.
    ///
    /// # Errors
    /// What differs.
    fn check_scene(&self, scene: u128) -> Result<(), IdentityMismatch> {
        let wanted = Self::new(scene, self.settings);
        self.check(&wanted)
    }
}

impl JobIdentity for LightIdentity {
    const FOREIGN: &'static str = "it holds other light";

    fn fields(&self) -> Vec<(&'static str, String)> {
        let BakeSettings { density, rays, shadow_rays } = self.settings;
        vec![
            ("the Glanz version", self.version.clone()),
            ("the scene (content hash)", format!("{:032x}", self.scene)),
            ("the number of texels per metre", density.to_string()),
            ("the number of rays", rays.to_string()),
            ("the number of shadow rays", shadow_rays.to_string()),
        ]
    }
}

/// A file that was read.
#[derive(Clone, Debug)]
pub(crate) struct LightFile {
    identity: LightIdentity,
    content: Content,
    /// Fingerprint of the file.
    pub(crate) hash: u128,
}

#[derive(Clone, Debug)]
enum Content {
    Unfinished(BakeState),
    /// Light maps in bytes: only the scene tells where they lie.
    Finished(Vec<u8>),
}

/// Where a bake begins.
#[derive(Debug)]
pub(crate) enum Start {
    /// With what was found, which may be nothing.
    State(BakeState),
    /// There is nothing left to find.
    Finished(Vec<LightMap>),
}

/// Reads the file `path`.
///
/// # Errors
/// Why it cannot be read, or holds no light.
pub(crate) fn read(path: &Path) -> Result<LightFile, Failure> {
    let failure = |what: &dyn std::fmt::Display| Failure::new(format!("{}: {what}", path.display()));
    let bytes = std::fs::read(path).map_err(|error| failure(&error))?;
    let content = open(MAGIC, VERSION, &bytes).map_err(|error| match error {
        EnvelopeError::Foreign => failure(&"this is not baked light of Glanz"),
        EnvelopeError::Version(version) => {
            failure(&format!("the light has format {version}, this program reads format {VERSION}"))
        }
        error => failure(&format!("the light is damaged: {error}")),
    })?;
    let mut hash = ContentHash::default();
    hash.add_file(&bytes);
    decode(content, hash.value()).ok_or_else(|| failure(&"the light makes no sense"))
}

fn decode(content: &[u8], hash: u128) -> Option<LightFile> {
    let mut d = Decoder(content);
    let (version, scene) = (d.text()?.to_owned(), d.u128()?);
    let settings = BakeSettings { density: d.f64()?, rays: d.u32()?, shadow_rays: d.u32()? };
    let content = match d.u8()? {
        0 => Content::Unfinished(BakeState::from_bytes(d.0)?),
        1 => Content::Finished(d.0.to_vec()),
        _ => return None,
    };
    Some(LightFile { identity: LightIdentity { version, scene, settings }, content, hash })
}

impl LightFile {
    /// Where the bake `wanted` of `elements` goes on.
    ///
    /// # Errors
    /// Light of something else.
    pub(crate) fn start(
        self,
        path: &Path,
        wanted: &LightIdentity,
        elements: &Elements<'_>,
    ) -> Result<Start, Failure> {
        self.identity.check(wanted).map_err(|mismatch| {
            Failure::new(format!("{}: {mismatch}", path.display()))
                .with_help("use the scene and the settings it was begun with, or another file")
        })?;
        match self.content {
            Content::Unfinished(state) => Ok(Start::State(state)),
            Content::Finished(bytes) => {
                Ok(Start::Finished(maps(&bytes, wanted.settings.density, elements, path)?))
            }
        }
    }

    /// Refuses light of another scene than that of this fingerprint, and light that is not all there.
    ///
    /// # Errors
    /// Why.
    pub(crate) fn check(&self, path: &Path, scene: u128) -> Result<(), Failure> {
        self.identity.check_scene(scene).map_err(|mismatch| {
            Failure::new(format!("{}: {mismatch}", path.display()))
                .with_help("bake this scene with this program: glanz bake SCENE --checkpoint FILE")
        })?;
        match &self.content {
            Content::Finished(_) => Ok(()),
            Content::Unfinished(_) => {
                Err(Failure::new(format!("{}: the bake of this light is not finished", path.display()))
                    .with_help("go on with it first: glanz bake SCENE --checkpoint FILE --resume"))
            }
        }
    }

    /// Texels per metre.
    pub(crate) fn density(&self) -> f64 {
        self.identity.settings.density
    }

    /// The light maps of `elements`, after [`LightFile::check`].
    ///
    /// # Errors
    /// If they are of something else.
    pub(crate) fn maps(&self, path: &Path, elements: &Elements<'_>) -> Result<Vec<LightMap>, Failure> {
        let bytes: &[u8] = match &self.content {
            Content::Finished(bytes) => bytes,
            Content::Unfinished(_) => &[],
        };
        maps(bytes, self.identity.settings.density, elements, path)
    }
}

fn maps(bytes: &[u8], density: f64, elements: &Elements<'_>, path: &Path) -> Result<Vec<LightMap>, Failure> {
    stored::from_bytes(elements, density, bytes)
        .ok_or_else(|| Failure::new(format!("{}: the light makes no sense", path.display())))
}

/// Keeps light in a file.
#[derive(Clone, Debug)]
pub(crate) struct Keeper<'a> {
    pub(crate) path: &'a Path,
    pub(crate) identity: LightIdentity,
}

impl Keeper<'_> {
    /// Puts what was found so far into the file; until it is all there, the file keeps its old content.
    ///
    /// # Errors
    /// Why it cannot be written.
    pub(crate) fn keep_state(&self, state: &BakeState) -> Result<(), Failure> {
        self.write(0, &state.to_bytes())
    }

    /// The same with all light.
    ///
    /// # Errors
    /// Why it cannot be written.
    pub(crate) fn keep(&self, maps: &[LightMap]) -> Result<(), Failure> {
        self.write(1, &stored::to_bytes(maps))
    }

    fn write(&self, kind: u8, content: &[u8]) -> Result<(), Failure> {
        let LightIdentity { version, scene, settings } = &self.identity;
        let bytes = seal(MAGIC, VERSION, |e| {
            e.text(version);
            e.u128(*scene);
            e.f64(settings.density);
            e.u32(settings.rays);
            e.u32(settings.shadow_rays);
            e.u8(kind);
            e.0.extend_from_slice(content);
        });
        write_atomically(self.path, &bytes).map_err(|error| Failure::new(error.to_string()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn other_light_is_told_apart() {
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
