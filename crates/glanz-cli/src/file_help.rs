//! Advice on files that are given to the wrong command.

use std::path::Path;

use glanz::formats::{ContentKind, ForeignRemedy, ModelFormat, OwnFile, SceneFormat};
use glanz_terminal::messages::CommandError;

/// The error about a file that cannot be read as what it should be, with the command that takes it if its content is known.
///
/// `fits`: whether it is what it should be, so that the error says more.
pub(crate) fn with_file_help(
    error: CommandError,
    path: &Path,
    fits: impl FnOnce(&ContentKind) -> bool,
) -> CommandError {
    match ContentKind::of_file(path).filter(|kind| !fits(kind)) {
        Some(kind) => error.with_help(help(kind, &path.display().to_string())),
        None => error,
    }
}

/// As [`with_file_help`], of an error that only tells that the file is something else: it is named.
pub(crate) fn named(
    error: CommandError,
    path: &Path,
    fits: impl FnOnce(&ContentKind) -> bool,
) -> CommandError {
    match ContentKind::of_file(path).filter(|kind| !fits(kind)) {
        Some(kind) => {
            let shown = path.display().to_string();
            CommandError { message: format!("{shown}: the file is {kind}"), ..error }
                .with_help(help(kind, &shown))
        }
        None => error,
    }
}

/// Whether the kind is a guess: any text that begins with a digit may be a list of patches.
pub(crate) fn is_guess(kind: &ContentKind) -> bool {
    *kind == ContentKind::Scene(SceneFormat::Model(ModelFormat::Newell))
}

/// What takes a file of a kind.
fn help(kind: ContentKind, file: &str) -> String {
    match kind {
        ContentKind::Scene(SceneFormat::Pbrt) => format!("render it with glanz render {file}"),
        ContentKind::Scene(_) => {
            format!("show it with glanz view {file}, or render it with glanz render {file}")
        }
        ContentKind::Picture(_) => {
            format!(
                "compare it with glanz compare {file} REFERENCE; a scene names it in Texture \"imagemap\""
            )
        }
        ContentKind::Luminaire("TM-25") => {
            "a scene names it in LightSource \"photometric\" with \"string filename\"".to_owned()
        }
        ContentKind::Luminaire(_) => format!(
            "summarise it with glanz info {file}, or plan a room with glanz illuminate --luminaire {file} --room X Y Z -o DIR"
        ),
        ContentKind::Own(OwnFile::Film) => {
            format!(
                "make a picture of it with glanz merge {file} -o PICTURE, or continue with glanz render SCENE --checkpoint {file} --resume"
            )
        }
        ContentKind::Own(OwnFile::Tally) => {
            format!(
                "continue with glanz illuminate SCENE -o DIR --checkpoint {file} --resume, or join parts with glanz merge"
            )
        }
        ContentKind::Own(OwnFile::Light) => format!("show it with glanz view SCENE --light {file}"),
        ContentKind::Own(OwnFile::Guide) => format!("use it with glanz render SCENE --guide-in {file}"),
        ContentKind::Own(OwnFile::Design) => {
            format!("continue with glanz optimize SCENE -o BETTER.pbrt --checkpoint {file} --resume")
        }
        ContentKind::Foreign(foreign) => match foreign.remedy {
            ForeignRemedy::ExportCad => "export it as STEP (.step) from the program that wrote it".to_owned(),
            ForeignRemedy::ExportMeshes => {
                "export it as glTF (.glb) from the program that wrote it".to_owned()
            }
            ForeignRemedy::Unpack => "unpack it first".to_owned(),
            ForeignRemedy::Download => "get the file itself: this only leads to it".to_owned(),
            _ => OTHER_HELP.to_owned(),
        },
        _ => OTHER_HELP.to_owned(),
    }
}

const OTHER_HELP: &str = "scenes are .pbrt; models .step, .igs, .glb, .gltf, .obj, .stl, .ply or .rib; luminaires .ies or .ldt; pictures .exr, .png or .hdr";
