//! Files of the wrong kind are named, with what takes them, in a few lines.

use crate::command_line::small_scene::SCENE;
use crate::command_line::support::Folder;

const PNG: &[u8] = b"\x89PNG\r\n\x1a\n";
const LDT: &str = "Maker\n1\n1\n1\n0\n19\n5\nreport\nname\n";
const STEP: &str = "ISO-10303-21;HEADER;ENDSEC;DATA;ENDSEC;END-ISO-10303-21;";

/// Name, content, and words of the error of a command that takes scenes.
const NO_SCENES: [(&str, &[u8], &[&str]); 20] = [
    ("room.xml", b"<scene version=\"3.0.0\">\n</scene>", &["a scene of Mitsuba (XML)", "export it as glTF"]),
    ("room.pbrt", b"<?xml version=\"1.0\"?>\n<scene>\n</scene>", &["a scene of Mitsuba (XML)"]),
    ("room.usda", b"#usda 1.0\n(\n)\n", &["a USD stage", "export it as glTF"]),
    ("room.usd", b"PXR-USDC\0\x08", &["a USD stage"]),
    ("room.blend", b"BLENDER-v402", &["a file of Blender", "export it as glTF"]),
    ("room.fbx", b"Kaydara FBX Binary  \0\x1a", &["an FBX file"]),
    ("part.3dm", b"3D Geometry File Format        80", &["a file of Rhino", "export it as STEP"]),
    ("part.dwg", b"AC1032\0\0", &["a DWG drawing", "export it as STEP"]),
    ("part.dxf", b"  0\nSECTION\n  2\nHEADER\n", &["a DXF drawing"]),
    ("part.step", b"<html><body>Not found</body></html>", &["a page (HTML)", "get the file itself"]),
    (
        "part.step",
        b"Dear customer,\nplease log in\n",
        &["neither a STEP model, as its name says, nor a scene"],
    ),
    ("part.glb", b"Not Found", &["neither a glTF model, as its name says"]),
    ("part.zip", b"PK\x03\x04\x14\0", &["a ZIP archive", "unpack it first"]),
    ("room.pbrt.gz", b"\x1f\x8b\x08\0", &["compressed (gzip)", "unpack it first"]),
    ("sheet.pdf", b"%PDF-1.7\n", &["a PDF document"]),
    ("a.json", b"{ \"rays\": 3 }", &["not a glTF file"]),
    (
        "a.rib",
        b"##RenderMan RIB-Structure 1.0\nDisplay \"a\" \"b\" \"rgb\"\nSphere 1 0 1 360\n",
        &["a RIB file without Patch"],
    ),
    ("a.png", PNG, &["a picture (PNG), not a scene", "glanz compare a.png"]),
    ("a.tm25ray", b"TM25\x01", &["the light of a luminaire (TM-25)", "LightSource \"photometric\""]),
    ("state", b"GLANZCKP\x07", &["a checkpoint of a picture", "glanz merge state"]),
];

/// Few lines: the fault, a place, advice.
const LINES: usize = 6;

#[test]
fn commands_for_scenes_name_other_files() {
    let folder = Folder::new();
    for (name, content, words) in NO_SCENES {
        folder.write(name, content);
        let commands =
            ["render NAME -o out.exr", "info NAME", "bake NAME -o out.glb", "illuminate NAME -o out"];
        let more = ["optimize NAME -o out.pbrt", "convert NAME out.obj", "view NAME --no-open"];
        for command in commands.into_iter().chain(more) {
            let ran = folder.run(&command.replace("NAME", name));
            ran.refused(1, words);
            assert!(ran.stderr.lines().count() <= LINES, "{command} {name}: {}", ran.stderr);
        }
    }
    for name in ["lamp.txt", "lamp.pbrt"] {
        folder.write(name, LDT);
        folder
            .run(&format!("render {name} -o out.exr"))
            .refused(1, &["(EULUMDAT)", &format!("glanz info {name}")]);
        folder.run(&format!("info {name}")).refused(1, &[&format!("{name}:")]);
    }
}

#[test]
fn info_takes_luminaires_by_their_content() {
    let folder = Folder::new();
    let data = "1 -1 1 3 1 1 2 0 0 0 1 1 30\n0 45 90\n0\n1000 707 0\n";
    folder.write("lamp.txt", format!("IESNA:LM-63-2002\nTILT=NONE\n{data}"));
    let told = folder.succeed("info lamp.txt --json").json();
    assert!(told["format"].as_str().expect("a text").contains("LM-63"));
    assert!(folder.succeed("info lamp.txt --files").stdout.contains("lamp.txt"));
    folder.write("bad.ldt", "1\nx\n");
    let ran = folder.run("info bad.ldt");
    ran.refused(1, &["bad.ldt:2:1"]);
    assert!(!ran.stderr.contains("patches"), "{}", ran.stderr);
}

#[cfg(unix)]
#[test]
fn pipes_in_place_of_files_do_not_block() {
    let folder = Folder::new();
    assert!(
        std::process::Command::new("mkfifo").arg(folder.path("pipe")).status().expect("mkfifo").success()
    );
    for command in ["render pipe -o a.png", "info pipe", "convert pipe a.obj"] {
        folder.run(command).refused(1, &["pipe: ", "not a regular file"]);
    }
}

#[test]
fn text_that_begins_with_a_digit_is_no_list_of_patches_for_certain() {
    let folder = Folder::new();
    folder.write("figures.txt", "1 2 3\n".repeat(40));
    for command in ["compare figures.txt figures.txt", "merge figures.txt -o a.exr"] {
        let ran = folder.run(command);
        assert_ne!(ran.code, Some(0), "{command}");
        assert!(ran.stderr.contains("figures.txt"), "{command}: {}", ran.stderr);
        assert!(!ran.stderr.contains("patches"), "{command}: {}", ran.stderr);
    }
}

#[test]
fn text_that_is_no_scene_has_one_error() {
    let folder = Folder::new();
    folder.write("a.txt", "Dear all,\nthese are\nmany words without any directive\nof a scene\n");
    let ran = folder.run("render a.txt -o out.exr");
    ran.refused(1, &["a.txt:1:1", "no directive of pbrt's language was found"]);
    assert!(ran.stderr.lines().count() <= LINES, "{}", ran.stderr);
}

#[test]
fn models_are_no_scenes_for_commands_that_need_light() {
    let folder = Folder::new();
    folder.write("part.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    folder.write("part.step", STEP);
    for command in
        ["bake part.obj -o a.glb", "illuminate part.obj -o a --room 1 1 1", "optimize part.obj -o a.pbrt"]
    {
        let ran = folder.run(command);
        assert_ne!(ran.code, Some(0), "{command}");
        assert!(
            ran.stderr.contains("help: ") && ran.stderr.lines().count() <= LINES,
            "{command}: {}",
            ran.stderr
        );
    }
    folder.run("bake part.step -o a.glb").refused(1, &["no surface"]);
}

#[test]
fn commands_for_other_files_name_scenes_and_each_other() {
    let folder = Folder::new();
    folder.write("scene.pbrt", SCENE);
    folder.write("scene.ldt", SCENE);
    folder.write("part.step", STEP);
    folder.write("a.png", PNG);
    folder.write("lamp.ldt", LDT);
    folder.write("state", b"GLANZLGT\x02\0\0\0");
    let scene = ["a scene in pbrt's language", "glanz render scene"];
    for (command, words) in [
        ("compare scene.pbrt a.png", scene),
        ("compare part.step a.png", ["a STEP model", "glanz view part.step"]),
        ("compare lamp.ldt a.png", ["the light of a luminaire (EULUMDAT)", "glanz info lamp.ldt"]),
        ("compare state a.png", ["baked light", "glanz view SCENE --light state"]),
        ("info scene.ldt", scene),
        ("illuminate --luminaire scene.pbrt --room 3 3 3 --grid 1x1 -o lux", scene),
        (
            "illuminate --luminaire a.png --room 3 3 3 --grid 1x1 -o lux",
            ["a picture (PNG)", "glanz compare a.png"],
        ),
        ("merge scene.pbrt -o a.exr", scene),
        ("merge a.png -o b.exr", ["a picture (PNG)", "glanz compare a.png"]),
        (
            "render scene.pbrt -o b.exr --guide-in a.png --integrator guided",
            ["a picture (PNG)", "glanz compare a.png"],
        ),
        ("render scene.pbrt -o b.exr --guide-in scene.pbrt --integrator guided", scene),
        (
            "render scene.pbrt -o b.exr --checkpoint state --resume",
            ["baked light", "glanz view SCENE --light state"],
        ),
        ("view scene.pbrt --no-open --light scene.pbrt", scene),
    ] {
        let ran = folder.run(command);
        assert!(matches!(ran.code, Some(1 | 2)), "{command}: {:?} {}", ran.code, ran.stderr);
        for word in words {
            assert!(ran.stderr.contains(word), "{command}: {word:?} is missing: {}", ran.stderr);
        }
        assert!(
            ran.stderr.lines().filter(|line| !line.starts_with("warning")).count() <= LINES,
            "{command}: {}",
            ran.stderr
        );
    }
}
