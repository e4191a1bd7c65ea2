//! The files of the page, embedded in the program.
//!
//! Only the files of the table are served: a request never becomes a path on disk.

use axum::http::header::{CACHE_CONTROL, CONTENT_TYPE, ETAG, HeaderMap, IF_NONE_MATCH};
use axum::http::{StatusCode, Uri};
use axum::response::{IntoResponse, Response};
use glanz_job::ContentHash;

/// A file of the page.
#[derive(Clone, Copy, Debug)]
struct PageFile {
    /// Path in the request, without the leading slash.
    path: &'static str,
    bytes: &'static [u8],
}

/// Files of the folder `web`, by their paths in it.
macro_rules! files {
    ($($path:literal),* $(,)?) => {
        &[$(PageFile { path: $path, bytes: include_bytes!(concat!("../../web/", $path)) }),*]
    };
}

/// All of them; a test compares the table with the folder.
static FILES: &[PageFile] = files![
    "adaptive_resolution.js",
    "camera.js",
    "colours.js",
    "commands.js",
    "edge_picking.js",
    "gl/algebraic.js",
    "gl/control_nets.js",
    "gl/data_texture.js",
    "gl/deviation.js",
    "gl/edge_lines.js",
    "gl/evaluation.js",
    "gl/frame.js",
    "gl/grid_levels.js",
    "gl/grids.js",
    "gl/lights.js",
    "gl/meshes.js",
    "gl/patch_bounds.js",
    "gl/patch_shader.js",
    "gl/patches.js",
    "gl/programs.js",
    "gl/render_targets.js",
    "gl/rendered_image_texture.js",
    "gl/renderer.js",
    "gl/scene.js",
    "gl/scene_tables.js",
    "gl/shading.js",
    "gl/shading_modes.js",
    "gl/shadows.js",
    "gl/subpatches.js",
    "gl/surface_boxes.js",
    "gl/trimming.js",
    "icon.svg",
    "index.html",
    "leaf_bounds.js",
    "linear.js",
    "lux_scale.js",
    "main.js",
    "model.js",
    "page.js",
    "picker.js",
    "rendered_image.js",
    "scene_parts.js",
    "scripting.js",
    "second_design.js",
    "session.js",
    "settings.js",
    "style.css",
    "transition.js",
    "ui/dom.js",
    "ui/files.js",
    "ui/key_bindings.js",
    "ui/legend.js",
    "ui/measure_tool.js",
    "ui/panels.js",
    "ui/pointer_controls.js",
    "ui/properties_panel.js",
    "ui/scene_tree.js",
    "ui/settings_panel.js",
    "ui/status_bar.js",
    "ui/storage.js",
    "ui/theme.js",
    "ui/tree.css",
    "ui/units.js",
    "ui/view.css",
    "viewpoint.js",
];

/// The file served for the root path.
const INDEX: &str = "index.html";

/// Media type by file extension.
fn content_type(path: &str) -> Option<&'static str> {
    Some(match path.rsplit_once('.')?.1 {
        "html" => "text/html; charset=utf-8",
        "js" => "text/javascript; charset=utf-8",
        "css" => "text/css; charset=utf-8",
        "svg" => "image/svg+xml",
        "png" => "image/png",
        "json" | "webmanifest" => "application/json",
        "glsl" | "txt" => "text/plain; charset=utf-8",
        _ => return None,
    })
}

/// Serves a file of the page with an entity tag for revalidation.
pub(crate) async fn serve(uri: Uri, headers: HeaderMap) -> Response {
    let path = uri.path().strip_prefix('/').unwrap_or_default();
    if path == "favicon.ico" {
        // Browsers request it whether or not the page has one, and log an error if it is missing.
        return StatusCode::NO_CONTENT.into_response();
    }
    let path = if path.is_empty() { INDEX } else { path };
    let file = FILES.iter().find(|file| file.path == path);
    let Some((file, kind)) = file.and_then(|file| Some((file, content_type(file.path)?))) else {
        return (StatusCode::NOT_FOUND, "there is no such file").into_response();
    };
    let mut hash = ContentHash::default();
    hash.add_file(file.bytes);
    let tag = format!("\"{:032x}\"", hash.value());
    let known = headers.get_all(IF_NONE_MATCH).iter().filter_map(|value| value.to_str().ok());
    let is_known = known.flat_map(|value| value.split(',')).any(|t| t.trim().trim_start_matches("W/") == tag);
    let about = [(ETAG, tag), (CACHE_CONTROL, "no-cache".to_owned())];
    if is_known {
        return (StatusCode::NOT_MODIFIED, about).into_response();
    }
    (about, [(CONTENT_TYPE, kind)], file.bytes).into_response()
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::path::Path;

    use super::*;

    /// Paths of all files below `folder`, with `prefix` in front.
    fn walk(folder: &Path, prefix: &str, found: &mut BTreeSet<String>) {
        for entry in std::fs::read_dir(folder).unwrap() {
            let entry = entry.unwrap();
            let path = format!("{prefix}{}", entry.file_name().to_str().unwrap());
            if entry.file_type().unwrap().is_dir() {
                walk(&entry.path(), &format!("{path}/"), found);
            } else {
                found.insert(path);
            }
        }
    }

    #[test]
    fn the_table_has_every_file_of_the_page_and_no_other() {
        let mut found = BTreeSet::new();
        walk(&Path::new(env!("CARGO_MANIFEST_DIR")).join("web"), "", &mut found);
        let listed: BTreeSet<String> = FILES.iter().map(|file| file.path.to_owned()).collect();
        assert_eq!(listed, found, "put the files of web/ into the table FILES");
        assert_eq!(listed.len(), FILES.len());
    }

    #[test]
    fn every_file_has_a_type() {
        assert!(FILES.iter().all(|file| content_type(file.path).is_some()));
    }
}
