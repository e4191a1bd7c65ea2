//! `glanz info --files`: every file that a scene or a model needs.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use crate::command_line::small_scene::SCENE;
use crate::command_line::support::Folder;

/// A scene that names a file of every kind, in two folders beside its own.
const EVERYTHING: &str = r#"
Camera "realistic" "string lensfile" "optics/lens.dat" "float aperturediameter" 4 "float focusdistance" 5
WorldBegin
SearchPath "assets"
Include "parts/light.pbrt"
Import "parts/ground.pbrt"
Texture "wood" "spectrum" "imagemap" "string filename" "wood.png"
Texture "bump" "float" "imagemap" "string filename" "bump.png"
Material "diffuse" "texture reflectance" "wood" "string normalmap" "normals.png" "texture displacement" "bump"
Shape "plymesh" "string filename" "mesh.ply" "texture alpha" "bump"
Material "conductor" "spectrum eta" "silver.spd" "spectrum k" "silver-k.spd"
MakeNamedMaterial "gold" "string type" "conductor" "spectrum eta" "gold.spd" "spectrum k" "gold-k.spd"
NamedMaterial "gold"
Texture "paint" "spectrum" "constant" "spectrum value" "paint.spd"
Material "diffuse" "texture reflectance" "paint"
Shape "obj" "string filename" "thing.obj"
Shape "stl" "string filename" "thing.stl"
Shape "step" "string filename" "discs.step"
Shape "gltf" "string filename" "thing.gltf"
Shape "bezierpatch" "string filename" "patch.rib"
Shape "patchmesh" "string filename" "patch.txt"
"#;

const LIGHTS: &str = r#"
LightSource "infinite" "spectrum L" "sky.spd" "string filename" "sky.png"
LightSource "projection" "string filename" "slide.png"
LightSource "goniometric" "string filename" "goniometer.png"
LightSource "photometric" "string filename" "lamp.ies"
AttributeBegin
  AreaLightSource "diffuse" "string filename" "screen.png"
  Shape "bilinearmesh" "point3 P" [0 0 9  1 0 9  0 1 9  1 1 9]
AttributeEnd
"#;

const IES: &str =
    "IESNA:LM-63-2002\n[LUMINAIRE] Spot\nTILT=lamp.tlt\n1 1000 1 2 1 1 2 -0.2 -0.2 0 1 1 12\n0 90\n0\n60 0\n";

const GLTF: &str = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":1},"material":0}]}],
"materials":[{"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}],
"textures":[{"source":0}],"images":[{"uri":"paint%20work.png"},{"uri":"unused.png"}],
"buffers":[{"uri":"thing.bin","byteLength":60}],
"bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":24}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},
{"bufferView":1,"componentType":5126,"count":3,"type":"VEC2"}]}"#;

const PATCH: [[f64; 3]; 16] = {
    let mut points = [[0.0; 3]; 16];
    let mut i = 0;
    while i < 16 {
        points[i] = [(i % 4) as f64, (i / 4) as f64, 2.0];
        i += 1;
    }
    points
};

/// The files of the scene with their kinds, and the scene itself.
const FILES: [(&str, &str); 30] = [
    ("scene/everything.pbrt", "scene"),
    ("scene/parts/light.pbrt", "scene"),
    ("scene/parts/ground.pbrt", "scene"),
    ("scene/optics/lens.dat", "lens"),
    ("scene/assets/wood.png", "picture"),
    ("scene/assets/bump.png", "picture"),
    ("scene/assets/normals.png", "picture"),
    ("scene/assets/mesh.ply", "mesh"),
    ("scene/assets/silver.spd", "spectrum"),
    ("scene/assets/silver-k.spd", "spectrum"),
    ("scene/assets/gold.spd", "spectrum"),
    ("scene/assets/gold-k.spd", "spectrum"),
    ("scene/assets/paint.spd", "spectrum"),
    ("scene/assets/thing.obj", "mesh"),
    ("scene/assets/thing.stl", "mesh"),
    ("scene/assets/discs.step", "cad"),
    ("scene/assets/thing.gltf", "model"),
    ("scene/assets/thing.bin", "buffer"),
    ("scene/assets/paint work.png", "picture"),
    ("scene/assets/patch.rib", "mesh"),
    ("scene/assets/patch.txt", "mesh"),
    ("scene/assets/sky.spd", "spectrum"),
    ("scene/assets/sky.png", "picture"),
    ("scene/assets/slide.png", "picture"),
    ("scene/assets/goniometer.png", "picture"),
    ("scene/assets/lamp.ies", "luminaire"),
    ("scene/assets/lamp.tlt", "luminaire"),
    ("scene/assets/screen.png", "picture"),
    ("scene/parts/stone.pfm", "picture"),
    ("scene/parts/stone.spd", "spectrum"),
];

fn with_everything() -> Folder {
    let folder = Folder::new();
    for name in ["scene/parts", "scene/optics", "scene/assets"] {
        std::fs::create_dir_all(folder.path(name)).unwrap();
    }
    folder.write("small.pbrt", SCENE);
    folder.succeed("render small.pbrt -o square.png -o square.pfm --size 8x8 --spp 1 -q");
    let (png, pfm) = (folder.bytes("square.png"), folder.bytes("square.pfm"));
    let corners: Vec<u8> = [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0]
        .iter()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    let rib: Vec<String> = PATCH.iter().map(|p| format!("{} {} {}", p[0], p[1], p[2])).collect();
    let newell: String = PATCH.iter().map(|p| format!("{},{},{}\n", p[0], p[1], p[2])).collect();
    let indices: Vec<String> = (1..=16).map(|i| i.to_string()).collect();
    let discs = include_bytes!("../../../../glanz-viewer/tests/discs.step");
    for (name, kind) in FILES {
        let bytes: Vec<u8> = match name.rsplit('/').next().unwrap() {
            "everything.pbrt" => EVERYTHING.into(),
            "light.pbrt" => LIGHTS.into(),
            "ground.pbrt" => b"Texture \"stone\" \"spectrum\" \"imagemap\" \"string filename\" \"stone.pfm\"
                Material \"conductor\" \"spectrum eta\" \"stone.spd\" \"spectrum k\" \"stone.spd\"
                Shape \"disk\"\n"
                .into(),
            "lens.dat" => b"30 5 1.7 10\n-30 40 1 10\n".into(),
            "mesh.ply" => b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"
                .into(),
            "thing.obj" => b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".into(),
            "thing.stl" => b"solid t\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n\
                endloop\nendfacet\nendsolid t\n"
                .into(),
            "discs.step" => discs.to_vec(),
            "thing.gltf" => GLTF.into(),
            "thing.bin" => corners.clone(),
            "patch.rib" => format!("Patch \"bicubic\" \"P\" [{}]\n", rib.join(" ")).into_bytes(),
            "patch.txt" => format!("1\n{}\n16\n{newell}", indices.join(",")).into_bytes(),
            "lamp.ies" => IES.into(),
            "lamp.tlt" => b"1\n2\n0 90\n1 0.5\n".into(),
            "stone.pfm" => pfm.clone(),
            _ if kind == "spectrum" => b"400 0.2\n700 0.3\n".into(),
            _ => png.clone(),
        };
        folder.write(name, bytes);
    }
    folder
}

/// The files of `glanz info --files SCENE`, by their path relative to the folder, with their kinds and whether they exist.
fn listed(folder: &Folder, scene: &str) -> BTreeMap<String, (String, bool)> {
    let root = std::fs::canonicalize(folder.path(".")).unwrap();
    let ran = folder.run(&format!("info --files {scene} --json"));
    let json = ran.json();
    let files = json.as_array().unwrap().iter().map(|file| {
        let path = PathBuf::from(file["path"].as_str().unwrap());
        assert!(path.is_absolute());
        let exists = file["exists"] == true;
        let bytes =
            std::fs::metadata(&path).ok().filter(std::fs::Metadata::is_file).map(|metadata| metadata.len());
        assert_eq!(file["bytes"].as_u64(), bytes);
        let name = path.strip_prefix(&root).unwrap().to_str().unwrap().to_owned();
        (name, (file["kind"].as_str().unwrap().to_owned(), exists))
    });
    let files: BTreeMap<_, _> = files.collect();
    let is_complete = files.values().all(|(_, exists)| *exists);
    assert_eq!(ran.code, Some(i32::from(!is_complete)), "{}", ran.stderr);
    files
}

/// Copies the files that the text output lists, and nothing else, to an empty folder.
fn copied(folder: &Folder, scene: &str) -> Folder {
    let copy = Folder::new();
    for line in folder.succeed(&format!("info --files {scene}")).stdout.lines() {
        let target = copy.path(line);
        std::fs::create_dir_all(target.parent().unwrap()).unwrap();
        std::fs::copy(folder.path(line), target).unwrap_or_else(|error| panic!("{line}: {error}"));
    }
    copy
}

#[test]
fn files_of_every_kind_are_listed_and_are_all_that_the_scene_needs() {
    let folder = with_everything();
    let expected: BTreeMap<String, (String, bool)> =
        FILES.iter().map(|(name, kind)| ((*name).to_owned(), ((*kind).to_owned(), true))).collect();
    assert_eq!(listed(&folder, "scene/everything.pbrt"), expected);
    let copy = copied(&folder, "scene/everything.pbrt");
    copy.succeed("info scene/everything.pbrt --strict");
    // A scene by another path, and a list from within its folder.
    let lines = folder.succeed("info --files ./scene/parts/../everything.pbrt").stdout;
    assert!(lines.lines().eq(folder.succeed("info --files scene/everything.pbrt").stdout.lines()));
}

#[test]
fn files_that_are_missing_are_listed_with_those_behind_them() {
    let folder = with_everything();
    for (name, kind) in FILES.iter().skip(3) {
        let bytes = folder.bytes(name);
        folder.remove(name);
        // The place of a file that is in none of the folders is that in the folder of the scene.
        let short = name.split_once('/').unwrap().1;
        let file = Path::new(short).file_name().unwrap().to_str().unwrap();
        let place = if *kind == "lens" { short } else { file };
        let files = listed(&folder, "scene/everything.pbrt");
        assert_eq!(files.get(&format!("scene/{place}")), Some(&((*kind).to_owned(), false)), "{name}");
        // A model that is missing hides those that it names, and nothing else does.
        let hidden = match file {
            "thing.gltf" => 2,
            "lamp.ies" => 1,
            _ => 0,
        };
        // Without a buffer, all pictures count.
        let more = usize::from(file == "thing.bin");
        assert_eq!(files.len() + hidden, FILES.len() + more, "{name}");
        let ran = folder.run("info --files scene/everything.pbrt");
        assert_eq!(ran.code, Some(1), "{name}");
        assert!(
            ran.stderr.contains(&format!("warning: scene/{place}: the {kind} is missing or cannot be read")),
            "{}",
            ran.stderr
        );
        folder.write(name, bytes);
    }
    folder.write("cut.pbrt", "WorldBegin\nShape \"plymesh\" \"string filename\" \"no.ply\"\nShape \"sphere");
    let ran = folder.run("info --files cut.pbrt");
    assert!(!ran.stderr.contains("only listed"), "{}", ran.stderr);
    assert_eq!((ran.code, ran.stdout.as_str()), (Some(1), "cut.pbrt\nno.ply\n"), "{}", ran.stderr);
    assert!(ran.stderr.contains("cut.pbrt:3:"), "{}", ran.stderr);
}

#[test]
fn models_have_their_buffers_materials_and_pictures() {
    let folder = with_everything();
    folder.write("scene/thing.mtl", "newmtl a\nmap_Kd assets/wood.png\nnewmtl b\nmap_d assets/bump.png\n");
    folder.write(
        "scene/model.obj",
        "mtllib thing.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl a\nf 1/1 2/2 3/3\n",
    );
    let names = |scene: &str| listed(&folder, scene).into_keys().collect::<Vec<_>>();
    assert_eq!(
        names("scene/model.obj"),
        ["scene/assets/bump.png", "scene/assets/wood.png", "scene/model.obj", "scene/thing.mtl"]
    );
    assert_eq!(
        names("scene/assets/thing.gltf"),
        ["scene/assets/paint work.png", "scene/assets/thing.bin", "scene/assets/thing.gltf"]
    );
    assert_eq!(names("scene/assets/lamp.ies"), ["scene/assets/lamp.ies", "scene/assets/lamp.tlt"]);
    for alone in ["discs.step", "mesh.ply", "thing.stl", "patch.rib"] {
        assert_eq!(names(&format!("scene/assets/{alone}")), [format!("scene/assets/{alone}")]);
    }
    for model in ["scene/model.obj", "scene/assets/thing.gltf"] {
        copied(&folder, model).succeed(&format!("info {model} --strict"));
    }
}

#[test]
fn other_spellings_of_a_path_are_one_file_and_folders_are_none() {
    let folder = Folder::new();
    std::fs::create_dir_all(folder.path("parts")).unwrap();
    folder.write("a.spd", "400 0.2\n700 0.3\n");
    folder.write(
        "a.pbrt",
        "WorldBegin\nMaterial \"conductor\" \"spectrum eta\" \"a.spd\" \"spectrum k\" \"parts/../a.spd\"\n\
         Shape \"plymesh\" \"string filename\" \"parts\"\n",
    );
    let entry = |kind: &str, exists| (kind.to_owned(), exists);
    let expected = [
        ("a.pbrt", entry("scene", true)),
        ("a.spd", entry("spectrum", true)),
        ("parts", entry("mesh", false)),
    ];
    let expected = expected.map(|(name, entry)| (name.to_owned(), entry));
    assert_eq!(listed(&folder, "a.pbrt"), BTreeMap::from(expected));
    let ran = folder.run("info --files a.pbrt");
    assert_eq!(ran.stdout, "a.pbrt\na.spd\nparts\n");
    folder.run("info --files a.pbrt --strict").refused(2, &["--files", "--strict"]);
}

#[test]
#[cfg(unix)]
fn a_file_that_names_others_and_cannot_be_read_is_not_there() {
    use std::os::unix::fs::PermissionsExt;

    let folder = Folder::new();
    folder.write("a.pbrt", "WorldBegin\nInclude \"b.pbrt\"\n");
    folder.write("b.pbrt", "Shape \"plymesh\" \"string filename\" \"c.ply\"\n");
    let closed = std::fs::Permissions::from_mode(0o000);
    std::fs::set_permissions(folder.path("b.pbrt"), closed).unwrap();
    if std::fs::read(folder.path("b.pbrt")).is_ok() {
        // The superuser reads everything.
        return;
    }
    let ran = folder.run("info --files a.pbrt");
    assert_eq!((ran.code, ran.stdout.as_str()), (Some(1), "a.pbrt\nb.pbrt\n"));
    assert!(ran.stderr.contains("b.pbrt: the scene is missing or cannot be read"), "{}", ran.stderr);
}
