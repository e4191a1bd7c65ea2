//! Arbitrary bytes as scene, mesh or texture give a result or an error with its position, never a panic or a hang.

use crate::command_line::small_scene::SCENE;
use crate::command_line::support::Folder;

/// Bytes that look like noise, the same in every run.
fn noise(length: usize) -> Vec<u8> {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 56) as u8
    };
    std::iter::repeat_with(next).take(length).collect()
}

/// Runs `render` on scene text and expects a failure that points into `bad.pbrt`.
fn refused_scene(text: impl AsRef<[u8]>, words: &[&str]) {
    let folder = Folder::new();
    folder.write("bad.pbrt", text);
    folder.run("render bad.pbrt -o a.png --spp 1").refused(1, words);
    assert!(!folder.has("a.png"));
}

#[test]
fn errors_name_file_line_and_column_and_show_the_line() {
    let scene = SCENE.replace("\"float radius\" 0.9", "\"float radius\" -0.9");
    let line = scene.lines().position(|l| l.contains("-0.9")).unwrap() + 1;
    refused_scene(&scene, &[&format!("error: bad.pbrt:{line}:"), &format!("{line} | "), "^", "-0.9"]);
}

#[test]
fn bytes_that_are_no_scene_are_refused() {
    refused_scene(noise(4096), &["bad.pbrt"]);
    refused_scene(b"\x89PNG\r\n\x1a\n", &["bad.pbrt", "PNG"]);
    refused_scene("", &["bad.pbrt", "empty"]);
    refused_scene("WorldBegin Shape \"sphere", &["bad.pbrt:1:18"]);
    refused_scene("LookAt 1 2 3\nWorldBegin", &["bad.pbrt:2:"]);
    refused_scene("\n\n   Worldbegin", &["bad.pbrt:3:4", "WorldBegin"]);
    refused_scene(SCENE.replace("Translate 2 0 -0.2", "Scale 0 1 1"), &["bad.pbrt:"]);
    refused_scene("Include \"bad.pbrt\"", &["bad.pbrt:1:"]);
}

#[test]
fn cut_scenes_end_in_a_picture_or_an_error() {
    let folder = Folder::new();
    for end in (0..SCENE.len()).step_by(97) {
        folder.write("bad.pbrt", &SCENE[..end]);
        let ran = folder.run("render bad.pbrt -o a.png --spp 1 --size 2x2");
        assert!(matches!(ran.code, Some(0 | 1)) && !ran.stderr.contains("panicked"), "{end}: {}", ran.stderr);
    }
}

#[test]
fn meshes_that_cannot_be_are_refused() {
    let folder = Folder::new();
    folder.write("bad.pbrt", "WorldBegin\nShape \"plymesh\" \"string filename\" \"mesh.ply\"\n");
    let header = |vertices: &str, faces: &str| {
        format!(
            "ply\nformat binary_little_endian 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\n\
             property float z\nelement face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
        )
    };
    for mesh in [
        noise(1000),
        Vec::new(),
        b"ply\n".to_vec(),
        header("1000000000000", "1000000000000").into_bytes(),
        header("3", "1000000000000").into_bytes(),
        header("-3", "x").into_bytes(),
        [header("3", "1").as_bytes(), &[0; 36], &[3, 0, 0, 0, 0, 1, 0, 0, 0, 9, 0, 0, 0]].concat(),
        [header("3", "1").as_bytes(), &[0; 20]].concat(),
    ] {
        folder.write("mesh.ply", &mesh);
        let ran = folder.run("render bad.pbrt -o a.png --spp 1");
        ran.refused(1, &["mesh.ply"]);
    }
}

#[test]
fn textures_that_are_no_pictures_are_named() {
    let folder = Folder::new();
    folder.write(
        "bad.pbrt",
        "WorldBegin\nTexture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"texture.png\"\n\
         Material \"diffuse\" \"texture reflectance\" \"t\"\nShape \"sphere\"\n",
    );
    for texture in [noise(500), Vec::new(), b"\x89PNG\r\n\x1a\n".to_vec()] {
        folder.write("texture.png", &texture);
        for strict in ["", "--strict"] {
            let ran = folder.run(&format!("render bad.pbrt -o a.png --size 2x2 --spp 1 {strict}"));
            assert!(
                ran.stderr.contains("bad.pbrt:2:") && ran.stderr.contains("texture.png"),
                "{}",
                ran.stderr
            );
            assert!(matches!(ran.code, Some(0 | 1)) && !ran.stderr.contains("panicked"), "{}", ran.stderr);
            assert!(strict.is_empty() || ran.code == Some(1), "{}", ran.stderr);
        }
    }
}

#[test]
fn impossible_pictures_are_refused_before_memory_is_taken() {
    refused_scene(
        SCENE.replace("xresolution\" 24", "xresolution\" 2000000000"),
        &["bad.pbrt:4:1", "2000000000"],
    );
    let folder = Folder::with_scene();
    let ran = folder.run("render small.pbrt -o a.png --spp 1 --size 4294967295x4294967295");
    ran.refused(1, &["--size 4294967295x4294967295"]);
}
