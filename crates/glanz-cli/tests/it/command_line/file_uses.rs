//! No file is used in two ways: an output is neither an input nor another output, by any of its names.

use super::small_scene::SCENE;
use super::support::Folder;

/// Runs commands that would destroy a file, and expects a refusal that names it, and all files as they were.
fn refused(folder: &Folder, lines: &[(&str, &str)]) {
    let before = folder.content();
    for (line, file) in lines {
        folder.run(line).refused(2, &[file, "choose another name"]);
        assert!(folder.content() == before, "glanz {line} changes files");
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
            ("bake small.pbrt -o a.glb --checkpoint a-2.exr", "a-2.exr"),
            ("demo -q --spp 1 --size 8x6 -o a.exr --checkpoint a.exr", "a.exr"),
            ("demo -q --spp 1 --size 8x6 --checkpoint glanz-demo.png", "glanz-demo.png"),
            ("optimize small.pbrt -o a.pbrt --checkpoint a.pbrt", "a.pbrt"),
            ("illuminate small.pbrt -o . --far-field a.ldt --far-field ./a.ldt", "a.ldt"),
            // Before the work, which would take days.
            (
                "illuminate small.pbrt --room 9 9 9 --rays 9000000000000 -o . --checkpoint report.json -q",
                "report.json",
            ),
            (
                "illuminate small.pbrt --room 9 9 9 --method both -o . --checkpoint wall-x=9-integrated.csv -q",
                "wall-x=9-integrated.csv",
            ),
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
    std::fs::hard_link(folder.path("floor.png"), folder.path("hard.png")).expect("a link");
    let second_page = textured.replace("floor.png", "floor-2.png");
    folder.write("floor-2.png", folder.bytes("floor.png"));
    folder.write("two.pbrt", format!("{SCENE}{second_page}"));
    folder.write("thing.obj", "mtllib thing.mtl\nusemtl red\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    folder.write("thing.mtl", "newmtl red\nKd 1 0 0\n");
    folder.write("other.obj", "mtllib red.mtl\nusemtl red\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    folder.write("red.mtl", "newmtl red\nKd 1 0 0\n");
    folder.write("lamp.ldt", "");
    std::fs::create_dir(folder.path("a")).expect("a folder");
    std::fs::hard_link(folder.path("inner.pbrt"), folder.path("a/report.html")).expect("a link");
    refused(
        &folder,
        &[
            ("render scene.pbrt --spp 1 -o floor.png", "floor.png"),
            #[cfg(unix)]
            ("render scene.pbrt --spp 1 -o link.png", "link.png"),
            #[cfg(unix)]
            ("render scene.pbrt --spp 1 -o hard.png", "hard.png"),
            ("bake scene.pbrt -o floor.glb --lightmap png", "floor.png"),
            ("bake two.pbrt -o floor.glb --lightmap png", "floor-2.png"),
            (
                "bake scene.pbrt --part 1/2 --light-in part.glanz --checkpoint part.glanz --resume",
                "part.glanz",
            ),
            (
                "render scene.pbrt -o a.png --light-in part.glanz --checkpoint part.glanz --resume",
                "part.glanz",
            ),
            (
                "render scene.pbrt -o a.png --guide-in part.glanz --checkpoint part.glanz --resume",
                "part.glanz",
            ),
            ("render scene.pbrt --part 1/2 --checkpoint inner.pbrt --resume", "inner.pbrt"),
            ("render thing.obj -o turn.png --turntable 2 --light-in turn-2.png", "turn-2.png"),
            ("optimize scene.pbrt -o scene.pbrt", "scene.pbrt"),
            ("optimize scene.pbrt -o inner.pbrt", "inner.pbrt"),
            ("convert thing.obj thing.obj", "thing.obj"),
            // The materials of red.obj would be written to red.mtl.
            ("convert other.obj red.obj", "red.mtl"),
            ("info lamp.ldt --plot lamp.ldt", "lamp.ldt"),
            (
                "illuminate --room 4 4 3 --luminaire lamp.ldt --grid 1x1 -o . --checkpoint lamp.ldt --resume",
                "lamp.ldt",
            ),
            #[cfg(unix)]
            (
                "illuminate scene.pbrt --compare two.pbrt --room 9 9 9 --rays 9000000000000 -o . -q",
                "report.html",
            ),
            // Also of the second scene, before the first is calculated.
            #[cfg(unix)]
            (
                "illuminate two.pbrt --compare scene.pbrt --room 9 9 9 --rays 9000000000000 -o . -q",
                "report.html",
            ),
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
