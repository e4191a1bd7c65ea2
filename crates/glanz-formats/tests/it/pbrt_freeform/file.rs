//! Patches from files.

use std::path::{Path, PathBuf};

use glanz_formats::{Diagnostics, Loaded, Options, load};

use super::*;

#[test]
fn the_teapot_has_thirty_two_patches() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/teapot.pbrt");
    let loaded =
        load(&path, &Options { strict: true, ..Options::default() }).unwrap_or_else(|d| panic!("{d}"));
    assert!(loaded.diagnostics.is_empty(), "{}", loaded.diagnostics);
    assert_eq!(loaded.description.film.resolution, [960, 540]);
    let patches: Vec<_> = loaded
        .description
        .world
        .shapes
        .iter()
        .filter_map(|s| match &s.geometry {
            GeometryDescription::BezierPatches(b) => Some(b),
            _ => None,
        })
        .collect();
    assert_eq!((patches.len(), patches[0].patches.len()), (1, 32));
    // The rim begins at (1.4, 0, 2.4), and all of it stands on z = 0, 3.15 high.
    assert_eq!(patches[0].patches[0][0], [1.4, 0.0, 2.4, 1.0]);
    let z = || patches[0].patches.iter().flatten().map(|p| p[2]);
    assert_eq!((z().fold(f64::INFINITY, f64::min), z().fold(0.0, f64::max)), (0.0, 3.15));
}

/// Reads a scene beside a file of patches.
fn with_file(tag: &str, file: (&str, &str), scene: &str) -> (Result<Loaded, Diagnostics>, PathBuf) {
    let folder = std::env::temp_dir().join(format!("glanz-formats-{}-{tag}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join(file.0), file.1).unwrap();
    let path = folder.join("scene.pbrt");
    std::fs::write(&path, scene).unwrap();
    let found = load(&path, &Options::default());
    std::fs::remove_dir_all(&folder).unwrap();
    (found, folder)
}

/// What is said about it, without the folder.
fn said(messages: impl ToString, folder: &Path) -> String {
    messages.to_string().replace(&format!("{}/", folder.display()), "")
}

#[test]
fn errors_of_a_list_of_patches_have_a_position_in_it() {
    let list = format!("1\n{}2\n1\n0,0,0\n", "1,".repeat(15));
    let scene = "WorldBegin\nShape \"patchmesh\" \"string filename\" \"a.txt\"\n";
    let (found, folder) = with_file("newell", ("a.txt", &list), scene);
    assert_eq!(
        said(found.unwrap_err(), &folder),
        "error: scene.pbrt:2:37: shape \"patchmesh\": a.txt:2:31: patch 1 refers to point 2; there are 1, counted from 1\n  \
           2 | Shape \"patchmesh\" \"string filename\" \"a.txt\"\n    \
             |                                     ^^^^^^^\n"
    );
}

/// Patches of two kinds and a spline.
const MIXED: &str = "Color [1 0 0]\nPatch \"bilinear\" \"P\" [0 0 0 1 0 0 0 1 0 1 1 0]\n\
    NuPatch 2 2 [0 0 1 1] 0 1 2 2 [0 0 1 1] 0 1 \"P\" [0 0 1 1 0 1 0 1 1 1 1 1]\nColor [0 0 1]\n";

#[test]
fn a_rib_file_is_a_shape_for_each_kind_of_its_surfaces() {
    let scene = "WorldBegin\nTranslate 1 2 3\nShape \"bezierpatch\" \"string filename\" \"a.rib\"\n";
    let (found, folder) = with_file("rib", ("a.rib", MIXED), scene);
    let loaded = found.unwrap();
    let shapes = &loaded.description.world.shapes;
    assert!(matches!(&shapes[0].geometry, GeometryDescription::BezierPatches(b) if b.patches.len() == 1));
    assert!(
        matches!(&shapes[1].geometry, GeometryDescription::Nurbs(n) if n.points[3] == [1.0, 1.0, 1.0, 1.0])
    );
    assert!(shapes.iter().all(|s| s.to_parent.w_axis.truncate().to_array() == [1.0, 2.0, 3.0]));
    assert_eq!(
        said(loaded.diagnostics, &folder),
        "warning: scene.pbrt:3:39: shape \"bezierpatch\": a.rib:1:1: request \"Color\" is not read and skipped\n  \
           3 | Shape \"bezierpatch\" \"string filename\" \"a.rib\"\n    \
             |                                       ^^^^^^^\n"
    );
}

#[test]
fn surfaces_of_a_rib_file_do_not_share_the_power_of_a_light() {
    let scene = "WorldBegin\nAreaLightSource \"diffuse\" \"float power\" 5\n\
        Shape \"bezierpatch\" \"string filename\" \"a.rib\"\n";
    let (found, folder) = with_file("rib-power", ("a.rib", MIXED), scene);
    let messages = said(found.unwrap_err(), &folder);
    let expected =
        "error: scene.pbrt:3:1: shape \"bezierpatch\": it has 2 surfaces, which cannot share one power";
    assert!(messages.contains(expected), "{messages}");
}

#[test]
fn errors_of_a_rib_file_have_a_position_in_it_and_a_remedy() {
    let scene = "WorldBegin\nShape \"patchmesh\" \"string filename\" \"a.rib\"\n";
    let (found, folder) = with_file("rib-wrong", ("a.rib", "AttributeBegin\nMotionBegin [0 1]"), scene);
    assert_eq!(
        said(found.unwrap_err(), &folder),
        "error: scene.pbrt:2:37: shape \"patchmesh\": a.rib:2:1: MotionBegin is not supported; surfaces in it would have \
         wrong positions\n  \
           2 | Shape \"patchmesh\" \"string filename\" \"a.rib\"\n    \
             |                                     ^^^^^^^\n  \
           help: write the file without motion, objects and solids\n"
    );
    let (found, folder) = with_file("rib-empty", ("a.rib", "version 3"), scene);
    assert!(said(found.unwrap_err(), &folder).contains("a.rib: the file has no Patch, PatchMesh or NuPatch"));
}
