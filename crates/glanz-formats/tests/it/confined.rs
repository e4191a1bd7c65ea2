//! Scenes that may read their own folder only.

use std::fs;
use std::path::Path;

use glanz_formats::{Diagnostics, Loaded, Options, load};
use tempfile::TempDir;

const TRIANGLE: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
    element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

/// A folder `inside` with a folder `parts`, and beside it files that are nobody's business.
fn house() -> TempDir {
    let house = TempDir::new().unwrap();
    fs::create_dir_all(house.path().join("inside/parts")).unwrap();
    for name in
        ["secret", "secret.pbrt", "secret.ply", "secret.png", "secret.spd", "secret.ies", "secret.rib"]
    {
        fs::write(house.path().join(name), "Shape \"sphere\"\n").unwrap();
    }
    house
}

fn read(house: &TempDir, scene: &str) -> Result<Loaded, Diagnostics> {
    let path = house.path().join("inside/scene.pbrt");
    fs::write(&path, scene).unwrap();
    load(&path, &Options { confined: true, ..Options::default() })
}

/// Everything that names a file; `{}` is the name.
const NAMES_A_FILE: [&str; 12] = [
    "Include \"{}\"",
    "Import \"{}\"",
    "Shape \"plymesh\" \"string filename\" \"{}\"",
    "Shape \"bezierpatch\" \"string filename\" \"{}\"",
    "Shape \"patchmesh\" \"string filename\" \"{}\"",
    "Shape \"step\" \"string filename\" \"{}\"",
    "Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"{}\"",
    "LightSource \"infinite\" \"string filename\" \"{}\"",
    "LightSource \"photometric\" \"string filename\" \"{}\"",
    "Material \"conductor\" \"spectrum eta\" \"{}\"",
    "LightSource \"point\" \"spectrum I\" \"{}\"",
    "SearchPath \"{}\"",
];

#[test]
fn names_that_lead_outside_are_refused_with_their_position() {
    let house = house();
    let absolute = house.path().join("secret").display().to_string();
    for pattern in NAMES_A_FILE {
        for name in ["../secret", "parts/../../secret", "..", "/etc/passwd", "..\\\\secret", &absolute] {
            let scene = format!("WorldBegin\n  {}\n", pattern.replace("{}", name));
            let Err(diagnostics) = read(&house, &scene) else { panic!("{scene} is read") };
            let text = diagnostics.to_string();
            assert!(text.contains("is outside the folder of the scene"), "{scene}{text}");
            assert!(text.starts_with("error: scene.pbrt:2:"), "{scene}{text}");
        }
    }
}

#[cfg(unix)]
#[test]
fn links_that_lead_out_are_refused() {
    let house = house();
    let inside = house.path().join("inside");
    std::os::unix::fs::symlink(house.path().join("secret"), inside.join("file")).unwrap();
    std::os::unix::fs::symlink(house.path(), inside.join("folder")).unwrap();
    fs::write(inside.join("parts/ball.pbrt"), "Shape \"sphere\"\n").unwrap();
    std::os::unix::fs::symlink(inside.join("parts/ball.pbrt"), inside.join("fine.pbrt")).unwrap();
    for pattern in NAMES_A_FILE.iter().filter(|pattern| !pattern.starts_with("SearchPath")) {
        for name in ["file", "folder/secret"] {
            let scene = format!("WorldBegin\n  {}\n", pattern.replace("{}", name));
            let Err(diagnostics) = read(&house, &scene) else { panic!("{scene} is read") };
            assert!(diagnostics.to_string().contains("is outside the folder of the scene"), "{diagnostics}");
        }
    }
    let via = "SearchPath \"folder\"\nWorldBegin\nInclude \"secret\"\n";
    assert!(read(&house, via).unwrap_err().to_string().contains("\"secret\" is outside the folder"));
    assert_eq!(
        read(&house, "WorldBegin\nInclude \"fine.pbrt\"\n").unwrap().description.world.shapes.len(),
        1
    );
    let scene = inside.join("linked.pbrt");
    std::os::unix::fs::symlink(house.path().join("secret"), &scene).unwrap();
    let error = load(&scene, &Options { confined: true, ..Options::default() }).unwrap_err();
    assert!(error.to_string().contains("the file is outside the folder of the scene"), "{error}");
}

#[test]
fn files_inside_are_read_and_named_relative_to_the_folder() {
    let house = house();
    let inside = house.path().join("inside");
    fs::write(inside.join("parts/mesh.ply"), TRIANGLE).unwrap();
    fs::write(inside.join("parts/a.pbrt"), "Shape \"plymesh\" \"string filename\" \"mesh.ply\"\nShape\n")
        .unwrap();
    let error = read(&house, "WorldBegin\nInclude \"./parts/a.pbrt\"\n").unwrap_err().to_string();
    let place = Path::new("parts").join("a.pbrt");
    assert!(error.starts_with(&format!("error: {}:2:1: ", place.display())), "{error}");
    fs::write(inside.join("parts/a.pbrt"), "Shape \"plymesh\" \"string filename\" \"mesh.ply\"\n").unwrap();
    let loaded = read(&house, "WorldBegin\nInclude \"parts/a.pbrt\"\n").unwrap();
    assert_eq!(loaded.description.world.shapes.len(), 1);
    // Files above are looked for where nothing confines the scene.
    let scene = "WorldBegin\nInclude \"secret.pbrt\"\n";
    assert!(read(&house, scene).unwrap_err().to_string().contains("\"secret.pbrt\" is not there"));
    assert!(load(&inside.join("scene.pbrt"), &Options::default()).is_ok());
}

#[test]
fn sources_list_the_files_of_a_scene() {
    let house = house();
    let inside = house.path().join("inside");
    fs::write(inside.join("parts/mesh.ply"), TRIANGLE).unwrap();
    fs::write(inside.join("parts/glow.spd"), "400 1\n700 2\n").unwrap();
    let include = "Shape \"plymesh\" \"string filename\" \"mesh.ply\"\n\
        LightSource \"point\" \"spectrum I\" \"parts/glow.spd\"\n";
    fs::write(inside.join("parts/a.pbrt"), include).unwrap();
    let loaded = read(&house, "WorldBegin\nInclude \"parts/a.pbrt\"\nInclude \"parts/a.pbrt\"\n").unwrap();
    let expected =
        ["parts/a.pbrt", "parts/glow.spd", "parts/mesh.ply", "scene.pbrt"].map(|name| inside.join(name));
    assert_eq!(loaded.sources.paths(), expected);
}

#[test]
fn models_that_name_files_outside_are_refused() {
    let house = house();
    let gltf = |uri: &str| {
        format!("{{\"asset\":{{\"version\":\"2.0\"}},\"buffers\":[{{\"byteLength\":1,\"uri\":\"{uri}\"}}]}}")
    };
    let obj = |name: &str| format!("mtllib {name}\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    for text in
        [gltf("../secret"), gltf("%2e%2e/secret"), gltf("/etc/passwd"), obj("../secret"), obj("/etc/passwd")]
    {
        let Err(diagnostics) = read(&house, &text) else { panic!("{text} is read") };
        let message = diagnostics.to_string();
        assert!(message.contains("is outside the folder of the scene"), "{text}: {message}");
    }
}
