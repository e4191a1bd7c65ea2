//! Recognition of files by their content, also of those that are not read, so that errors can name them.

use std::fmt;
use std::path::Path;

use crate::registry::{ModelFormat, SceneFormat};
use crate::{image, pbrt, photometry, stl};

/// What a file holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ContentKind {
    /// A scene, or a model without camera and light.
    Scene(SceneFormat),
    /// A picture.
    Picture(image::Format),
    /// The candela distribution of a luminaire, or the rays of a light source.
    Luminaire(&'static str),
    /// A file that Glanz has written for itself.
    Own(OwnFile),
    /// Another file, which is not read.
    Foreign(ForeignFile),
}

/// A file that Glanz has written for itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum OwnFile {
    /// A checkpoint of a picture.
    Film,
    /// A checkpoint of lux maps.
    Tally,
    /// Baked light, also before it is complete.
    Light,
    /// A guide of a render.
    Guide,
    /// A checkpoint of an inverse design.
    Design,
    /// Any other.
    Other,
}

/// A file that is not read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ForeignFile {
    /// Its name in messages, with an article.
    pub name: &'static str,
    /// What to do with it.
    pub remedy: ForeignRemedy,
}

/// What to do with a file that is not read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ForeignRemedy {
    /// Export surfaces from the program that wrote it, as STEP.
    ExportCad,
    /// Export meshes and materials from the program that wrote it, as glTF.
    ExportMeshes,
    /// Unpack it.
    Unpack,
    /// Load the file itself instead of the page about it.
    Download,
    /// Choose another file.
    None,
}

/// Bytes of a file in which its kind is looked for.
const HEAD: usize = 1 << 16;

/// Files that Glanz writes for itself, by their first bytes.
const OWN: [(&[u8], OwnFile); 7] = [
    (b"GLANZCKP", OwnFile::Film),
    (b"GLANZLUX", OwnFile::Tally),
    (b"GLANZLXC", OwnFile::Tally),
    (b"GLANZLGT", OwnFile::Light),
    (b"GLANZGDE", OwnFile::Guide),
    (b"GLANZOPT", OwnFile::Design),
    (b"GLANZ", OwnFile::Other),
];

/// Files that are not read, by their first bytes.
const FOREIGN: [(&[u8], &str, ForeignRemedy); 21] = [
    (b"#usda", "a USD stage", ForeignRemedy::ExportMeshes),
    (b"PXR-USDC", "a USD stage", ForeignRemedy::ExportMeshes),
    (b"BLENDER", "a file of Blender", ForeignRemedy::ExportMeshes),
    (b"Kaydara FBX", "an FBX file", ForeignRemedy::ExportMeshes),
    (b"; FBX", "an FBX file", ForeignRemedy::ExportMeshes),
    (b"Ogawa", "an Alembic file", ForeignRemedy::ExportMeshes),
    (b"#VRML", "a VRML file", ForeignRemedy::ExportMeshes),
    (b"3D Geometry File Format", "a file of Rhino (3DM)", ForeignRemedy::ExportCad),
    (b"AC10", "a DWG drawing", ForeignRemedy::ExportCad),
    (b"AutoCAD Binary DXF", "a DXF drawing", ForeignRemedy::ExportCad),
    (b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1", "a document of a CAD or office program", ForeignRemedy::ExportCad),
    (b"PK\x03\x04", "a ZIP archive", ForeignRemedy::Unpack),
    (b"\x1f\x8b", "compressed (gzip)", ForeignRemedy::Unpack),
    (b"\x28\xb5\x2f\xfd", "compressed (Zstandard)", ForeignRemedy::Unpack),
    (b"\xfd7zXZ\0", "compressed (xz)", ForeignRemedy::Unpack),
    (b"BZh", "compressed (bzip2)", ForeignRemedy::Unpack),
    (b"7z\xbc\xaf\x27\x1c", "a 7z archive", ForeignRemedy::Unpack),
    (b"Rar!", "a RAR archive", ForeignRemedy::Unpack),
    (b"version https://git-lfs", "a pointer of Git LFS to the file", ForeignRemedy::Download),
    (b"%PDF", "a PDF document", ForeignRemedy::None),
    (b"\x7fELF", "a program", ForeignRemedy::None),
];

/// Files of XML that are not read, by their first element in lower case.
const XML: [(&str, &str, ForeignRemedy); 6] = [
    ("scene", "a scene of Mitsuba (XML)", ForeignRemedy::ExportMeshes),
    ("collada", "a COLLADA file", ForeignRemedy::ExportMeshes),
    ("x3d", "an X3D file", ForeignRemedy::ExportMeshes),
    ("materialx", "materials of MaterialX (XML), without surfaces", ForeignRemedy::None),
    ("html", "a page (HTML)", ForeignRemedy::Download),
    ("svg", "a drawing (SVG)", ForeignRemedy::None),
];

/// The name of a RIB file of which nothing is read.
const RIB_WITHOUT_PATCHES: &str = "a RIB file without Patch, PatchMesh or NuPatch";

/// Requests that begin a RIB file and are no directives of pbrt.
const RIB: [&[u8]; 12] = [
    b"version",
    b"FrameBegin",
    b"Display",
    b"Projection",
    b"Format",
    b"ShadingRate",
    b"Declare",
    b"Surface",
    b"Sides",
    b"Opacity",
    b"Clipping",
    b"PixelSamples",
];

impl ContentKind {
    /// The kind of the content of a file; `None` if it is not recognised.
    #[must_use]
    pub fn of(bytes: &[u8]) -> Option<Self> {
        match SceneFormat::from_content(bytes) {
            Ok(Some(format)) => Some(Self::Scene(format)),
            Ok(None) if pbrt::begins(bytes) => Some(Self::Scene(SceneFormat::Pbrt)),
            Ok(None) => None,
            Err(kind) => kind,
        }
    }

    /// The kind of the file at `path`, by its beginning; `None` if it cannot be read or is not recognised.
    #[must_use]
    pub fn of_file(path: &Path) -> Option<Self> {
        use std::io::Read;
        // To open a pipe is to wait for its other end.
        let length = std::fs::metadata(path).ok().filter(std::fs::Metadata::is_file)?.len();
        let file = std::fs::File::open(path).ok()?;
        let mut head = Vec::new();
        file.take(HEAD as u64).read_to_end(&mut head).ok()?;
        // The size of a binary mesh is a part of its signature.
        let is_mesh = || stl::is_binary_stl(&head, length);
        match Self::of(&head) {
            // The first patch may be behind the head.
            Some(Self::Foreign(foreign))
                if foreign.name == RIB_WITHOUT_PATCHES && length > head.len() as u64 =>
            {
                Some(Self::Scene(SceneFormat::Model(ModelFormat::Rib)))
            }
            None if is_mesh() => Some(Self::Scene(SceneFormat::Model(ModelFormat::Stl))),
            kind => kind,
        }
    }

    /// The kind of a file that is no scene.
    pub(crate) fn of_other(bytes: &[u8]) -> Option<Self> {
        if let Some((_, own)) = OWN.iter().find(|(start, _)| bytes.starts_with(start)) {
            return Some(Self::Own(*own));
        }
        if let Some(format) = image::Format::from_content(bytes) {
            return Some(Self::Picture(format));
        }
        let head = bytes.get(..bytes.len().min(HEAD)).unwrap_or_default();
        if let Some(format) = photometry::recognise(head) {
            return Some(Self::Luminaire(format));
        }
        foreign(head).map(|(name, remedy)| Self::Foreign(ForeignFile { name, remedy }))
    }
}

fn foreign(head: &[u8]) -> Option<(&'static str, ForeignRemedy)> {
    if let Some((_, name, remedy)) = FOREIGN.iter().find(|(start, ..)| head.starts_with(start)) {
        return Some((name, *remedy));
    }
    let text = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(head).trim_ascii_start();
    if text.starts_with(b"<") {
        let first = first_element(text).to_ascii_lowercase();
        let first = first.strip_prefix(b"!doctype ").unwrap_or(&first).trim_ascii_start();
        let is = |name: &str| {
            let rest = first.strip_prefix(name.as_bytes());
            rest.is_some_and(|rest| !rest.first().is_some_and(u8::is_ascii_alphanumeric))
        };
        let known = XML.iter().find(|(element, ..)| is(element));
        return Some(known.map_or(("an XML file", ForeignRemedy::None), |(_, name, remedy)| (name, *remedy)));
    }
    let mut lines = text.split(|&b| b == b'\n').map(<[u8]>::trim_ascii);
    if lines.next() == Some(b"0") && lines.next() == Some(b"SECTION") {
        return Some(("a DXF drawing", ForeignRemedy::ExportCad));
    }
    let is_rib = |word: &[u8]| RIB.contains(&word);
    let mut code = text.split(|&b| b == b'\n').map(<[u8]>::trim_ascii);
    let first = code.find(|line| !line.is_empty() && !line.starts_with(b"#")).unwrap_or_default();
    let word = first.split(u8::is_ascii_whitespace).next().unwrap_or_default();
    if text.starts_with(b"##RenderMan") || is_rib(word) {
        return Some((RIB_WITHOUT_PATCHES, ForeignRemedy::None));
    }
    let is_mtl = word == b"newmtl";
    is_mtl.then_some(("a library of materials (MTL), without surfaces", ForeignRemedy::None))
}

/// What follows the `<` of the first element or declaration of XML; empty without one.
fn first_element(text: &[u8]) -> &[u8] {
    let mut rest = text;
    while let Some(start) = rest.iter().position(|&b| b == b'<') {
        let element = rest.get(start + 1..).unwrap_or_default();
        let end: &[u8] = match element {
            [b'!', b'-', b'-', ..] => b"-->",
            [b'?', ..] => b"?>",
            _ => return element,
        };
        let Some(length) = element.windows(end.len()).position(|window| window == end) else { break };
        rest = element.get(length + end.len()..).unwrap_or_default();
    }
    &[]
}

impl ModelFormat {
    /// Its name in messages, with an article.
    pub(crate) fn described(self) -> &'static str {
        match self {
            Self::Ply => "a PLY mesh",
            Self::Rib => "a RIB file",
            Self::Newell => "a list of bicubic patches",
            Self::Step => "a STEP model",
            Self::Iges => "an IGES model",
            Self::Stl => "an STL mesh",
            Self::Obj => "an OBJ model",
            Self::Gltf => "a glTF model",
        }
    }
}

impl fmt::Display for ContentKind {
    /// With an article: `a picture (PNG)`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Scene(SceneFormat::Pbrt) => "a scene in pbrt's language",
            Self::Scene(SceneFormat::Model(format)) => format.described(),
            Self::Picture(format) => return write!(f, "a picture ({format})"),
            Self::Luminaire(format) => return write!(f, "the light of a luminaire ({format})"),
            Self::Own(OwnFile::Film) => "a checkpoint of a picture",
            Self::Own(OwnFile::Tally) => "a checkpoint of lux maps",
            Self::Own(OwnFile::Light) => "baked light",
            Self::Own(OwnFile::Guide) => "a guide of a render",
            Self::Own(OwnFile::Design) => "a checkpoint of an inverse design",
            Self::Own(OwnFile::Other) => "one of Glanz's own files",
            Self::Foreign(foreign) => foreign.name,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_binary_mesh_is_named_by_the_size_of_its_file() {
        let facets = 2000_u32;
        let mut bytes = vec![0; 84 + 50 * facets as usize];
        bytes[80..84].copy_from_slice(&facets.to_le_bytes());
        assert!(bytes.len() > HEAD);
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), &bytes).unwrap();
        let stl = ContentKind::Scene(SceneFormat::Model(ModelFormat::Stl));
        assert_eq!(ContentKind::of_file(file.path()), Some(stl));
    }

    #[test]
    fn a_long_rib_file_may_have_patches_behind_its_head() {
        let file = tempfile::NamedTempFile::new().unwrap();
        let header = "##RenderMan RIB\nversion 3.03\n";
        std::fs::write(file.path(), header).unwrap();
        let foreign = ContentKind::of_file(file.path());
        assert!(matches!(foreign, Some(ContentKind::Foreign(_))), "{foreign:?}");
        std::fs::write(file.path(), format!("{header}{}", "# a comment\n".repeat(HEAD / 8))).unwrap();
        let rib = ContentKind::Scene(SceneFormat::Model(ModelFormat::Rib));
        assert_eq!(ContentKind::of_file(file.path()), Some(rib));
    }

    #[test]
    fn files_are_named_by_their_content() {
        let ldt = "Maker\n1\n1\n1\n0\n19\n5\nreport\n";
        for (bytes, name) in [
            (
                &b"<?xml version=\"1.0\"?>\n<!-- a room -->\n<scene version=\"3.0.0\">"[..],
                "a scene of Mitsuba (XML)",
            ),
            (b"\xef\xbb\xbf<scene>", "a scene of Mitsuba (XML)"),
            (b"<sceneries>", "an XML file"),
            (b"<!DOCTYPE html><html>", "a page (HTML)"),
            (b"<!-- <scene> --><html>", "a page (HTML)"),
            (b"<?xml version=\"1.0\"?><!DOCTYPE X3D PUBLIC \"x\">", "an X3D file"),
            (b"<!DOCTYPE svg>", "a drawing (SVG)"),
            (b"# made by\nnewmtl a\n", "a library of materials (MTL), without surfaces"),
            (b"newmtl a\n", "a library of materials (MTL), without surfaces"),
            (b"<COLLADA xmlns=\"x\">", "a COLLADA file"),
            (b"#usda 1.0\n", "a USD stage"),
            (b"PXR-USDC\0\0", "a USD stage"),
            (b"BLENDER-v300", "a file of Blender"),
            (b"Kaydara FBX Binary  \0", "an FBX file"),
            (b"3D Geometry File Format        7", "a file of Rhino (3DM)"),
            (b"AC1032\0\0", "a DWG drawing"),
            (b"  0\r\nSECTION\r\n  2\r\n", "a DXF drawing"),
            (b"PK\x03\x04", "a ZIP archive"),
            (b"\x1f\x8b\x08", "compressed (gzip)"),
            (b"%PDF-1.7", "a PDF document"),
            (b"##RenderMan RIB\nversion 3.03\n", "a RIB file without Patch, PatchMesh or NuPatch"),
            (
                b"# made by\nDisplay \"a.tif\" \"file\" \"rgb\"\n",
                "a RIB file without Patch, PatchMesh or NuPatch",
            ),
            (b"IESNA:LM-63-2002\n[TEST] 1\nTILT=NONE\n", "the light of a luminaire (LM-63)"),
            (ldt.as_bytes(), "the light of a luminaire (EULUMDAT)"),
            (b"TM25\x01", "the light of a luminaire (TM-25)"),
            (b"GLANZCKP\x07", "a checkpoint of a picture"),
            (b"GLANZLGT\x02", "baked light"),
            (b"qoif\0", "a picture (QOI)"),
            (b"LookAt 0 0 0 1 0 0 0 1 0", "a scene in pbrt's language"),
            (b"# a room\n\nFilm \"image\"", "a scene in pbrt's language"),
            (b"v 1 2 3\n", "an OBJ model"),
        ] {
            let kind = ContentKind::of(bytes).map(|kind| kind.to_string());
            assert_eq!(kind.as_deref(), Some(name), "{}", String::from_utf8_lossy(bytes));
        }
        for unknown in [&b"hello world"[..], b"", b"\0\0\0\0", b"Dear all,\n1\n2\n3\n"] {
            assert_eq!(ContentKind::of(unknown), None);
        }
    }
}
