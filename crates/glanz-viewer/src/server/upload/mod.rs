//! Upload of files that are dropped on a page.

mod body;
mod folder;

use std::fs::File;
use std::io;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

use axum::body::Body;
use axum::extract::{RawQuery, State};
use axum::http::StatusCode;
use axum::http::header::CONTENT_TYPE;
use axum::response::{IntoResponse, Response};
use glanz_formats::MODEL_EXTENSIONS;
use tokio::time::timeout;

use super::access_key::AccessKey;
use super::message::ServerMessage;
use super::opened_scene::{OpenedScene, SceneSlot, UploadPermits};
use super::query_value;
use super::settings::Limits;
use super::state::AppState;
use super::worker::WorkerCommand;

use self::body::UploadBody;

pub(crate) use self::folder::{FILES_FOLDER, MODEL_FILE, UploadFolder};

/// Largest depth of folders of a file.
const MAX_DEPTH: usize = 8;

/// Largest length of the name of a file or folder, bytes.
const MAX_NAME: usize = 200;

/// Errors of an upload.
#[derive(Debug)]
enum UploadError {
    /// A malformed request, or one beyond the limits.
    Request(StatusCode, String),
    /// Messages of the reader.
    Scene(String),
}

impl UploadError {
    fn bad(message: impl Into<String>) -> Self {
        Self::Request(StatusCode::BAD_REQUEST, message.into())
    }

    fn too_large(message: impl Into<String>) -> Self {
        Self::Request(StatusCode::PAYLOAD_TOO_LARGE, message.into())
    }

    fn busy(message: &str) -> Self {
        Self::Request(StatusCode::SERVICE_UNAVAILABLE, message.to_owned())
    }
}

impl From<io::Error> for UploadError {
    fn from(error: io::Error) -> Self {
        Self::Request(StatusCode::INTERNAL_SERVER_ERROR, format!("the files cannot be stored: {error}"))
    }
}

impl IntoResponse for UploadError {
    fn into_response(self) -> Response {
        match self {
            Self::Request(status, text) => (status, text).into_response(),
            Self::Scene(text) => (StatusCode::UNPROCESSABLE_ENTITY, text).into_response(),
        }
    }
}

/// Reads a scene from the uploaded files and shows it on the page that sent them.
pub(crate) async fn open(
    State(app): State<Arc<AppState>>,
    RawQuery(query): RawQuery,
    body: Body,
) -> Response {
    match receive_scene(&app, query.as_deref(), body).await {
        Ok(text) => ([(CONTENT_TYPE, "application/json")], text).into_response(),
        Err(refusal) => refusal.into_response(),
    }
}

async fn receive_scene(app: &AppState, query: Option<&str>, body: Body) -> Result<String, UploadError> {
    let session = query_value(query, "session")
        .and_then(AccessKey::parse)
        .and_then(|key| app.sessions.get(&key))
        .ok_or_else(|| UploadError::bad("?session= must be the name of an open page"))?;
    let Some(command) = &app.worker else {
        return Err(UploadError::busy("this server opens no files"));
    };
    let Ok(page) = Arc::clone(&session.uploading).try_lock_owned() else {
        return Err(UploadError::busy("the page is already opening files; wait for them"));
    };
    let Ok(upload) = Arc::clone(&app.uploads).try_acquire_owned() else {
        return Err(UploadError::busy("too many pages are opening files; try again"));
    };
    let slot = match session.scene_slot() {
        // The scene that the page shows makes room for the new one.
        Some(slot) => slot,
        None => Arc::clone(&app.opened_scenes).try_acquire_owned().map(Arc::new).map_err(|_| {
            UploadError::busy("too many pages show files that they have opened; close one of them")
        })?,
    };
    let permits = UploadPermits { _page: page, _upload: upload };
    let opened = tokio::select! {
        opened = receive_and_open(app, command, body, permits, slot) => opened?,
        () = session.gone() => return Err(UploadError::bad("the page has gone")),
    };
    let opened = Arc::new(opened);
    app.models.publish_opened(&opened);
    let message = app.opened_message(&session.key, &opened);
    session.show_opened(opened, message.clone());
    Ok(ServerMessage::Scene(message).to_text())
}

/// Receives the files and opens the scene among them.
async fn receive_and_open(
    app: &AppState,
    command: &WorkerCommand,
    body: Body,
    permits: UploadPermits,
    slot: SceneSlot,
) -> Result<OpenedScene, UploadError> {
    let folder = UploadFolder::try_new()?;
    let files = folder.files();
    let arriving = receive(UploadBody::new(body), &files, &app.limits);
    let names = timeout(app.limits.upload_time, arriving).await.map_err(|_| {
        UploadError::Request(
            StatusCode::REQUEST_TIMEOUT,
            "the upload took too long; try again, or with fewer files".to_owned(),
        )
    })??;
    OpenedScene::open(app, command, (folder, names), permits, slot).await.map_err(UploadError::Scene)
}

/// Writes the files to `folder` and returns their relative paths.
async fn receive(mut body: UploadBody, folder: &Path, limits: &Limits) -> Result<Vec<PathBuf>, UploadError> {
    let list = body.list(limits.upload_files << 10).await?;
    if list.len() > limits.upload_files {
        return Err(UploadError::too_large(format!(
            "more than {} files were dropped at once; drop fewer",
            limits.upload_files
        )));
    }
    if list.iter().fold(0, |sum: usize, (_, size)| sum.saturating_add(*size)) > limits.upload_bytes {
        return Err(UploadError::too_large(format!(
            "the files have more than {} bytes; drop fewer",
            limits.upload_bytes
        )));
    }
    let mut names: Vec<PathBuf> = Vec::new();
    for (name, size) in list {
        let Some(name) = inside(&name) else {
            return Err(UploadError::bad(format!("{name:?} is not a valid file name")));
        };
        if names.contains(&name) {
            return Err(UploadError::bad(format!("the file {:?} occurs twice", name.display())));
        }
        let path = folder.join(&name);
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder)?;
        }
        body.copy(size, &mut File::create_new(path)?).await?;
        names.push(name);
    }
    Ok(names)
}

/// The relative path that a file's name denotes; `None` if it is not valid, or leads out of the folder.
fn inside(name: &str) -> Option<PathBuf> {
    if name.contains(['\\', '\0', ':']) {
        return None;
    }
    let path = PathBuf::from(name);
    let is_plain =
        |c: Component<'_>| matches!(c, Component::Normal(part) if part.len() <= MAX_NAME && !part.is_empty());
    let depth = path.components().count();
    ((1..=MAX_DEPTH).contains(&depth) && path.components().all(is_plain) && !name.ends_with('/'))
        .then_some(path)
}

/// The scene file: the only one with the extension .pbrt, or of several the only one that contains `WorldBegin`; without such files the only model.
pub(crate) fn scene_among<'a>(folder: &Path, names: &'a [PathBuf]) -> Result<&'a Path, String> {
    let with = |extensions: &[&str]| -> Vec<&'a PathBuf> {
        let ends = |name: &&PathBuf| {
            name.extension().is_some_and(|end| extensions.iter().any(|known| end.eq_ignore_ascii_case(known)))
        };
        names.iter().filter(ends).collect()
    };
    let (scenes, models) = (with(&["pbrt"]), with(&MODEL_EXTENSIONS));
    match (scenes.as_slice(), models.as_slice()) {
        ([scene], _) => return Ok(scene),
        ([], [model]) => return Ok(model),
        ([], [_, _, ..]) => return Err("several files are models; drop one".to_owned()),
        _ => {}
    }
    let begins_world = |name: &&&PathBuf| {
        let bytes = std::fs::read(folder.join(name)).unwrap_or_default();
        bytes.split(u8::is_ascii_whitespace).any(|word| word == b"WorldBegin")
    };
    let worlds: Vec<&&PathBuf> = scenes.iter().filter(begins_world).collect();
    match (worlds.as_slice(), scenes.len()) {
        ([scene], _) => Ok(scene),
        (_, 0) => Err(format!(
            "none of the files is a scene; scenes have the extension .pbrt, models .{}",
            MODEL_EXTENSIONS.join(", .")
        )),
        (several, _) => {
            let list: Vec<String> = several.iter().map(|name| name.display().to_string()).collect();
            let which = if list.is_empty() { "none contains WorldBegin".to_owned() } else { list.join(", ") };
            Err(format!(
                "several files may be the scene ({which}); drop one together with the files that it includes"
            ))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_files_stay_in_the_folder() {
        for name in ["a.pbrt", "textures/wood.png", "a/b/c/d/e/f/g/h", ".hidden", "\u{e4} b.ply"] {
            assert_eq!(inside(name), Some(PathBuf::from(name)), "{name}");
        }
        let long = "x".repeat(MAX_NAME + 1);
        for name in [
            "",
            ".",
            "..",
            "/",
            "/etc/passwd",
            "../a",
            "a/../../b",
            "a/..",
            "C:\\a",
            "a\\b",
            "a\0",
            "a/",
            &long,
            "1/2/3/4/5/6/7/8/9",
        ] {
            assert_eq!(inside(name), None, "{name}");
        }
    }

    #[test]
    fn the_scene_is_the_file_that_begins_a_world() {
        let folder = UploadFolder::try_new().unwrap();
        let put = |name: &str, text: &str| {
            std::fs::write(folder.files().join(name), text).unwrap();
            PathBuf::from(name)
        };
        let (part, whole) =
            (put("part.pbrt", "Shape \"sphere\"\n"), put("whole.pbrt", "WorldBegin\nInclude \"part.pbrt\""));
        let (other, mesh) = (put("other.PBRT", "WorldBegin\n"), put("mesh.ply", "ply\n"));
        let among = |names: &[&PathBuf]| {
            let names: Vec<PathBuf> = names.iter().map(|name| (*name).clone()).collect();
            scene_among(&folder.files(), &names).map(Path::to_owned)
        };
        assert_eq!(among(&[&mesh, &part]), Ok(part.clone()));
        assert_eq!(among(&[&part, &mesh, &whole]), Ok(whole.clone()));
        let (picture, rib) = (put("a.png", ""), put("b.rib", ""));
        assert!(among(&[&picture]).unwrap_err().contains("none of the files"));
        assert_eq!(among(&[&mesh, &picture]), Ok(mesh.clone()));
        assert!(among(&[&mesh, &rib]).unwrap_err().contains("several files are models"));
        assert!(among(&[&other, &whole]).unwrap_err().contains("other.PBRT, whole.pbrt"));
    }
}
