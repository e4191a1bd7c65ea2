//! Scenes in more than one file.

use std::fs;
use std::path::{Path, PathBuf};

use glanz_formats::image::{self, Format};
use glanz_formats::{Diagnostics, Loaded, Options, load};
use glanz_light::{Pixels, SpectralDistribution, Tone};
use glanz_scene::description::{
    Description, GeometryDescription, ImageFilter, LightKind, SpectrumParameter, SphereMapping,
    TextureDescription, TextureKind,
};

/// A folder that goes away at the end of a test.
pub(crate) struct Folder(PathBuf);

impl Folder {
    pub(crate) fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("glanz-formats-{}-{name}", std::process::id()));
        fs::create_dir_all(path.join("parts")).unwrap();
        Self(path)
    }

    pub(crate) fn put(&self, name: &str, bytes: impl AsRef<[u8]>) -> &Self {
        fs::write(self.0.join(name), bytes).unwrap();
        self
    }

    pub(crate) fn load(&self) -> Result<Loaded, Diagnostics> {
        load(&self.0.join("scene.pbrt"), &Options::default())
    }

    /// Messages without the name of the folder.
    pub(crate) fn messages(&self, d: &Diagnostics) -> String {
        d.to_string().replace(&format!("{}/", self.0.display()), "")
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn picture(rgb: &[[f32; 3]], width: u32) -> Vec<u8> {
    let height = rgb.len() as u32 / width;
    let pixels = Pixels::try_from_rgb(width, height, rgb).unwrap();
    image::write(&pixels, Format::Pfm, &Tone::default(), &Default::default()).unwrap()
}

const TRIANGLE: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
    element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

#[test]
fn included_files_are_read_in_place_and_relative_to_the_scene() {
    let folder = Folder::new("include");
    folder
        .put("scene.pbrt", "WorldBegin\nTranslate 1 0 0\nInclude \"parts/a.pbrt\"\nShape \"sphere\"\n")
        .put("parts/a.pbrt", "Translate 1 0 0\nInclude \"parts/b.pbrt\"\n")
        .put("parts/b.pbrt", "Shape \"sphere\"\nShape \"plymesh\" \"string filename\" \"mesh.ply\"\n")
        // Beside the file that asks, which pbrt does not look at.
        .put("parts/mesh.ply", TRIANGLE);
    let loaded = folder.load().unwrap_or_else(|d| panic!("{d}"));
    let shapes = &loaded.description.world.shapes;
    assert_eq!(shapes.len(), 3);
    assert!(shapes.iter().all(|s| s.to_parent.w_axis.x == 2.0));
    assert!(
        matches!(&shapes[1].geometry, GeometryDescription::Triangles { indices, .. } if indices == &[[0, 1, 2]])
    );
    assert_eq!(loaded.description.files.len(), 3);
    let location = shapes[1].location.unwrap();
    assert_eq!((location.file.0, location.line), (2, 2));
}

#[test]
fn imported_files_change_no_state() {
    let folder = Folder::new("import");
    folder
        .put("scene.pbrt", "Film \"rgb\"\nWorldBegin\nImport \"parts/a.pbrt\"\nShape \"sphere\"\n")
        .put("parts/a.pbrt", "Translate 1 0 0\nMaterial \"dielectric\"\nShape \"sphere\"\n");
    let d = folder.load().unwrap_or_else(|d| panic!("{d}")).description;
    let x = |i: usize| d.world.shapes[i].to_parent.w_axis.x;
    assert_eq!((x(0), x(1)), (1.0, 0.0));
    assert_ne!(d.world.shapes[0].material, d.world.shapes[1].material);
}

#[test]
fn missing_and_circular_includes_are_reported_where_they_are_named() {
    let folder = Folder::new("circle");
    folder
        .put("scene.pbrt", "WorldBegin\nInclude \"parts/a.pbrt\"\n  Include \"nowhere.pbrt\"\n")
        .put("parts/a.pbrt", "# comes back\nInclude \"scene.pbrt\"\n");
    let errors = folder.load().unwrap_err();
    assert_eq!(
        folder.messages(&errors),
        "error: parts/a.pbrt:2:9: Include: file \"scene.pbrt\" includes itself\n  \
           2 | Include \"scene.pbrt\"\n    \
             |         ^^^^^^^^^^^^\n\
         error: scene.pbrt:3:11: Include: file \"nowhere.pbrt\" is not there\n  \
           3 |   Include \"nowhere.pbrt\"\n    \
             |           ^^^^^^^^^^^^^^\n  \
           help: names are relative to the folder of the scene file\n"
    );
}

#[test]
fn includes_nest_up_to_a_limit() {
    let folder = Folder::new("deep");
    folder.put("scene.pbrt", "WorldBegin\nInclude \"1.pbrt\"\n");
    for i in 1..40 {
        folder.put(&format!("{i}.pbrt"), format!("Include \"{}.pbrt\"\n", i + 1));
    }
    let errors = folder.load().unwrap_err();
    let message = folder.messages(&errors);
    assert!(
        message.starts_with("error: 32.pbrt:1:9: the limit of 32 files within one another is exceeded\n"),
        "{message}"
    );
}

#[test]
fn warnings_about_a_file_that_is_closed_still_show_its_line() {
    let folder = Folder::new("closed");
    folder
        .put("scene.pbrt", "WorldBegin\nInclude \"parts/a.pbrt\"\n")
        .put("parts/a.pbrt", "# open\n  AttributeBegin\n");
    let loaded = folder.load().unwrap();
    assert_eq!(
        folder.messages(&loaded.diagnostics),
        "warning: parts/a.pbrt:2:3: AttributeBegin is never ended\n  2 |   AttributeBegin\n    |   ^^^^^^^^^^^^^^\n"
    );
}

#[test]
fn a_mesh_is_faulted_at_its_name_and_in_its_file() {
    let folder = Folder::new("mesh");
    let scene = "WorldBegin\nShape \"plymesh\" \"string filename\" \"m.ply\"\n";
    folder.put("scene.pbrt", scene).put("m.ply", TRIANGLE.replace("3 0 1 2", "3 0 1 7"));
    let errors = folder.load().unwrap_err();
    assert_eq!(
        folder.messages(&errors),
        "error: scene.pbrt:2:35: shape \"plymesh\": m.ply:13:8: element \"face\" number 0 refers to vertex 7; there are 3\n  \
           2 | Shape \"plymesh\" \"string filename\" \"m.ply\"\n    \
             |                                   ^^^^^^^\n"
    );
}

#[test]
fn pictures_are_read_once_and_named_spectra_from_files() {
    let folder = Folder::new("picture");
    let texture = |name: &str| {
        format!(
            "Texture \"{name}\" \"color\" \"imagemap\" \"string filename\" \"p.pfm\" \"float uscale\" 2 \"string wrap\" \"clamp\"\n"
        )
    };
    let scene = format!(
        "WorldBegin\n{}{}Material \"matte\" \"spectrum Kd\" \"grey.spd\"\n",
        texture("a"),
        texture("b")
    );
    folder
        .put("scene.pbrt", scene)
        .put("p.pfm", picture(&[[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]], 2))
        .put("grey.spd", "# nm value\n700 .5\n400 .5\n");
    let d = folder.load().unwrap_or_else(|d| panic!("{d}")).description;
    assert_eq!(d.images.len(), 1);
    assert_eq!(d.images[0].picture.to_rgb().unwrap()[1], [4.0, 5.0, 6.0]);
    assert!(matches!(d.textures[1].kind, TextureKind::Image { image: 0, scale: 1.0, invert: false, .. }));
    let glanz_scene::description::MaterialKind::Diffuse(diffuse) = &d.materials[0].kind else { panic!() };
    let SpectrumParameter::Value(kd) = &diffuse.reflectance else { panic!() };
    assert!((kd.luminance() - 0.5).abs() < 1e-3);
}

/// Lights of a scene file next to the picture `sky.pfm` of that many columns and rows, whose upper half is (1, 2, 4).
fn lights_with_picture(name: &str, scene: &str, [columns, rows]: [usize; 2]) -> Description {
    let pixels: Vec<[f32; 3]> = (0..columns * rows)
        .map(|i| if 2 * i < columns * rows { [1.0, 2.0, 4.0] } else { [0.0; 3] })
        .collect();
    let folder = Folder::new(name);
    folder.put("scene.pbrt", scene).put("sky.pfm", picture(&pixels, columns as u32));
    let loaded = folder.load().unwrap_or_else(|d| panic!("{d}"));
    assert!(loaded.diagnostics.is_empty(), "{}", loaded.diagnostics);
    loaded.description
}

#[test]
fn picture_of_an_infinite_light_is_read_once_and_mapped_as_its_version_does() {
    for (name, words, size, expected) in [
        ("sky3", "\"string mapname\" \"sky.pfm\"", [4, 2], SphereMapping::LatitudeLongitude),
        (
            "sky3s",
            "\"string mapname\" \"sky.pfm\" \"color scale\" [1 1 1]",
            [4, 4],
            SphereMapping::LatitudeLongitude,
        ),
        (
            "sky4",
            "\"string filename\" \"sky.pfm\" \"float illuminance\" 1",
            [4, 2],
            SphereMapping::LatitudeLongitude,
        ),
        (
            "sky4s",
            "\"string filename\" \"sky.pfm\" \"float illuminance\" 1",
            [4, 4],
            SphereMapping::EqualArea,
        ),
    ] {
        let film = if name.starts_with("sky4") { "Film \"rgb\" " } else { "" };
        let scene =
            format!("{film}WorldBegin\nLightSource \"infinite\" {words}\nLightSource \"infinite\" {words}\n");
        let description = lights_with_picture(name, &scene, size);
        assert_eq!((description.images.len(), description.lights.len()), (1, 2));
        for light in &description.lights {
            let LightKind::ImageInfinite { image: 0, mapping } = light.kind else {
                panic!("{:?}", light.kind)
            };
            assert_eq!(mapping, expected, "{words}");
        }
    }
}

#[test]
fn pictures_of_other_lights_are_read() {
    let file = "\"string filename\" \"sky.pfm\"";
    let scene = format!(
        "WorldBegin LightSource \"projection\" {file} \"float fov\" 90 \"float power\" 3
         LightSource \"goniometric\" {file} \"float power\" 3 LightSource \"goniometric\"
         AttributeBegin AreaLightSource \"diffuse\" {file} \"bool twosided\" true Shape \"sphere\" AttributeEnd"
    );
    let description = lights_with_picture("lamps", &scene, [64, 64]);
    let [projection, goniometric, point] = &description.lights[..] else { panic!() };
    let LightKind::Projection { image: 0, field_of_view } = projection.kind else { panic!() };
    assert!((field_of_view - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
    // Half of a cube's side, a twelfth of the sphere, and half of the sphere.
    let luminance = SpectralDistribution::Rgb([1.0, 2.0, 4.0]).luminance();
    let sphere = 4.0 * std::f32::consts::PI;
    for (light, solid_angle) in [(projection, sphere / 12.0), (goniometric, sphere / 2.0)] {
        let expected = 3.0 / (solid_angle * luminance);
        assert!((light.scale / expected - 1.0).abs() < 1e-3, "{:?}: {} {expected}", light.kind, light.scale);
    }
    assert!(matches!(goniometric.kind, LightKind::Goniometric { image: 0, .. }));
    assert!(matches!(point.kind, LightKind::Point { .. }));
    let emission = description.world.shapes[0].emission.as_ref().unwrap();
    assert!(emission.image == Some(0) && emission.two_sided);
    assert_eq!(description.images.len(), 1);
}

#[test]
fn wrong_parameters_of_pictures_are_refused() {
    for (words, kind) in [
        ("\"infinite\" \"point3 portal\" [0 0 0 1 0 0 1 1 0]", "parameter-count"),
        ("\"projection\" \"string filename\" \"sky.pfm\" \"float fov\" 180", "parameter-range"),
        ("\"goniometric\" \"string filename\" \"black.pfm\" \"float power\" 1", "parameter-range"),
    ] {
        let folder = Folder::new("refused-lights");
        let scene = format!("WorldBegin LightSource {words}");
        folder.put("scene.pbrt", scene).put("sky.pfm", picture(&[[1.0; 3]; 4], 2));
        folder.put("black.pfm", picture(&[[0.0; 3]; 4], 2));
        let errors = folder.load().unwrap_err();
        assert!(errors.iter().any(|d| d.kind == kind), "{words}: {errors}");
    }
}

#[test]
fn colour_of_a_light_multiplies_its_picture_and_illuminance_counts_the_upper_half() {
    let scene = "WorldBegin LightSource \"infinite\" \"string filename\" \"sky.pfm\" \"rgb L\" [2 1 3]";
    let light = &lights_with_picture("color", scene, [4, 2]).lights[0];
    assert!(matches!(light.emission, SpectralDistribution::Rgb([2.0, 1.0, 3.0])), "{:?}", light.emission);
    let scene = format!("{scene} \"float scale\" 10 \"float illuminance\" 5");
    let light = &lights_with_picture("lux", &scene, [512, 256]).lights[0];
    // An even upper half of radiance L gives 683 pi L lx; `scale` is a factor on top.
    let lit = SpectralDistribution::Rgb([2.0, 2.0, 12.0]).luminance();
    let expected = 10.0 * 5.0 / (683.0 * std::f32::consts::PI * lit);
    assert!((light.scale / expected - 1.0).abs() < 1e-3, "{} {expected}", light.scale);
}

#[test]
fn the_fingerprint_covers_every_file_and_no_name() {
    let of = |name: &str, part: &str, bytes: &str| {
        let folder = Folder::new(name);
        let scene = "WorldBegin\nInclude \"parts/a.pbrt\"\n";
        folder.put("scene.pbrt", scene).put("parts/a.pbrt", part).put("m.ply", bytes);
        folder.load().unwrap_or_else(|d| panic!("{d}")).content_hash
    };
    let mesh = "Shape \"plymesh\" \"string filename\" \"m.ply\"";
    let first = of("hash1", mesh, TRIANGLE);
    assert_eq!(first, of("hash2", mesh, TRIANGLE));
    assert_ne!(first, of("hash3", &format!("{mesh} "), TRIANGLE));
    assert_ne!(first, of("hash4", mesh, &TRIANGLE.replace("1 0 0", "2 0 0")));
}

#[test]
fn folders_and_devices_are_not_read() {
    let folder = Folder::new("device");
    folder.put("scene.pbrt", "WorldBegin\nInclude \"parts\"\nInclude \"/dev/zero\"\n");
    let errors = folder.load().unwrap_err();
    assert_eq!(errors.iter().map(|d| d.kind).collect::<Vec<_>>(), ["missing-file", "missing-file"]);
    assert!(load(Path::new("/dev/zero"), &Options::default()).is_err());
}

#[test]
fn filters_of_pictures_are_those_of_either_version() {
    let folder = Folder::new("filters");
    let anisotropic = |most| ImageFilter::Anisotropic { most };
    for (version, text, expected) in [
        (4, "", ImageFilter::Bilinear),
        (3, "", anisotropic(8)),
        (3, "\"bool trilinear\" true", ImageFilter::Trilinear),
        (4, "\"string filter\" \"trilinear\"", ImageFilter::Trilinear),
        (4, "\"string filter\" \"ewa\"", anisotropic(8)),
        (4, "\"string filter\" \"ewa\" \"float maxanisotropy\" 3.6", anisotropic(4)),
        (4, "\"string filter\" \"ewa\" \"float maxanisotropy\" 1e9", anisotropic(16)),
        (4, "\"string filter\" \"ewa\" \"float maxanisotropy\" -1", anisotropic(1)),
        (4, "\"string filter\" \"point\"", ImageFilter::Point),
    ] {
        // Version 3 alone has the one word, version 4 the other.
        let end = if version == 3 { "WorldEnd\n" } else { "ColorSpace \"srgb\"\n" };
        folder.put("p.pfm", picture(&[[0.5; 3]], 1)).put(
            "scene.pbrt",
            format!(
                "WorldBegin\nTexture \"t\" \"color\" \"imagemap\" \"string filename\" \"p.pfm\" {text}\n{end}"
            ),
        );
        let loaded = folder.load().unwrap();
        let [TextureDescription { kind: TextureKind::Image { filter, .. }, .. }] =
            loaded.description.textures[..]
        else {
            panic!("{:?}", loaded.description.textures);
        };
        assert_eq!(filter, expected, "version {version}: {text}");
    }
}
