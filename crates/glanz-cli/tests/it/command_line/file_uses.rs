//! No file is used in two ways: an output is neither an input nor another output, by any of its names.

use super::small_scene::SCENE;
use super::support::Folder;

/// Runs commands that would destroy a file, and expects a refusal that names it, and all files as they were.
fn refused(folder: &Folder, lines: &[(&str, &str)]) {
    let state = || folder.names().into_iter().map(|name| (folder.bytes(&name), name)).collect::<Vec<_>>();
    let before = state();
    for (line, file) in lines {
        folder.run(line).refused(2, &[file, "choose another name"]);
        assert!(state() == before, "glanz {line} changes files");
    }
}

#[test]
fn outputs_are_not_other_outputs() {
    let folder = Folder::with_scene();
    refused(
        &folder,
        &[
            ("render small.pbrt --spp 1 -o a.exr --checkpoint a.exr", "a.exr"),
            ("render small.pbrt --spp 1 -o a.exr --checkpoint ./a.exr", "a.exr"),
            ("render small.pbrt --spp 1 -o a.exr -o ./a.exr", "a.exr"),
            ("render small.pbrt --spp 1 --checkpoint small.exr", "small.exr"),
            ("render small.pbrt --spp 1 --integrator guided -o a.exr --guide-out a.exr", "a.exr"),
            ("bake small.pbrt -o a.glb --checkpoint a.glb", "a.glb"),
            ("bake small.pbrt -o a.glb --checkpoint a.exr", "a.exr"),
        ],
    );
}

#[test]
fn outputs_are_not_inputs() {
    let folder = Folder::new();
    folder.write("plain.pbrt", SCENE);
    folder.succeed("render plain.pbrt --spp 1 --samples 0..1 -o floor.png --checkpoint part.glanz");
    let textured = "Texture \"wood\" \"spectrum\" \"imagemap\" \"string filename\" \"floor.png\"\nMaterial \"diffuse\" \"texture reflectance\" \"wood\"\n";
    folder.write("inner.pbrt", "Shape \"sphere\"\n");
    folder.write("scene.pbrt", format!("{SCENE}{textured}Include \"inner.pbrt\"\n"));
    #[cfg(unix)]
    std::os::unix::fs::symlink(folder.path("floor.png"), folder.path("link.png")).expect("a link");
    refused(
        &folder,
        &[
            ("render scene.pbrt --spp 1 -o floor.png", "floor.png"),
            #[cfg(unix)]
            ("render scene.pbrt --spp 1 -o link.png", "link.png"),
            ("bake scene.pbrt -o floor.glb --lightmap png", "floor.png"),
            ("render scene.pbrt --spp 1 -o a.png --checkpoint scene.pbrt --resume", "scene.pbrt"),
            ("render scene.pbrt --spp 1 --integrator guided -o a.png --guide-out inner.pbrt", "inner.pbrt"),
            ("bake scene.pbrt -o a.glb --checkpoint inner.pbrt --resume", "inner.pbrt"),
            ("illuminate scene.pbrt -o lux --checkpoint inner.pbrt --resume", "inner.pbrt"),
            // The room has a receiver of this name.
            ("illuminate scene.pbrt --room 20 20 20 --cells 2 --rays 1000 -o . -q", "floor.png"),
            ("merge part.glanz -o a.exr --checkpoint part.glanz", "part.glanz"),
        ],
    );
}
