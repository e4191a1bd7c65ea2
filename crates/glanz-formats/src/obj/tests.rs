use std::path::Path;

use glanz_math::{DVec2, DVec3};
use glanz_scene::description::{
    FloatParameter, GeometryDescription, ImageWrap, MappingDescription, MaterialKind, SpectrumParameter,
    TextureKind,
};
use glanz_shading::model::PrincipledMaterial;

use super::*;
use crate::registry::{Loaded, Options, load, load_str};

fn parsed(text: &str) -> ObjFile {
    read(text.as_bytes()).unwrap_or_else(|error| panic!("{error}"))
}

fn message(text: &str) -> String {
    read(text.as_bytes()).unwrap_err().to_string()
}

/// A model beside a file of materials and a picture.
fn with_materials(mtl: &str, obj: &str) -> Loaded {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).unwrap();
    write("a b.mtl", mtl.as_bytes());
    write("m.png", &crate::image::write_srgb8(1, 1, &[[255, 0, 0]]).unwrap());
    write("m.obj", format!("mtllib a b.mtl\n{obj}").as_bytes());
    load(&folder.path().join("m.obj"), &Options::default()).unwrap_or_else(|error| panic!("{error}"))
}

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

#[test]
fn polygons_share_their_vertices_and_numbers_may_be_negative() {
    let file = parsed(&format!("# a square\n{SQUARE}f 1 2 3 4\nf -1 -2 \\\n  -3\n"));
    let [mesh] = &file.meshes[..] else { panic!("{file:?}") };
    assert_eq!(
        mesh.positions,
        [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[x, y]| DVec3::new(f64::from(x), f64::from(y), 0.0))
    );
    // The ear at the first corner, then the rest; and 4, 3, 2 by their numbers from the end.
    assert_eq!(mesh.triangles, [[3, 0, 1], [1, 2, 3], [3, 2, 1]]);
    assert!(mesh.normals.is_none() && mesh.uvs.is_none() && mesh.material.is_none());
}

#[test]
fn corners_with_other_normals_or_coordinates_are_other_vertices() {
    let file = parsed(&format!("{SQUARE}vt 0.5\nvt 1 0.25 0\nvn 0 0 2\nf 1/1 2/2/1 3//-1\nf 1 2/2/1 4\n"));
    let [mesh] = &file.meshes[..] else { panic!("{file:?}") };
    assert_eq!(mesh.triangles, [[0, 1, 2], [3, 1, 4]]);
    let uv = |u: f64, v: f64| DVec2::new(u, v);
    assert_eq!(
        mesh.uvs.as_deref().unwrap(),
        [uv(0.5, 0.0), uv(1.0, 0.25), DVec2::ZERO, DVec2::ZERO, DVec2::ZERO]
    );
    let up = DVec3::new(0.0, 0.0, 2.0);
    assert_eq!(mesh.normals.as_deref().unwrap(), [DVec3::ZERO, up, up, DVec3::ZERO, DVec3::ZERO]);
}

#[test]
fn objects_and_materials_divide_a_file_and_groups_do_not() {
    let text = "o a\nusemtl red\ng x\nf 1 2 3\ng y\nf 1 3 4\nusemtl dark blue\nf 1 2 4\nusemtl red\nf 2 3 4\no b\nf 1 2 3\n";
    let file = parsed(&format!("{SQUARE}{text}"));
    let found: Vec<_> =
        file.meshes.iter().map(|mesh| (mesh.material.unwrap(), mesh.triangles.len())).collect();
    assert_eq!(
        (found, file.materials),
        (vec![(0, 3), (1, 1), (0, 1)], vec!["red".to_owned(), "dark blue".to_owned()])
    );
}

#[test]
fn a_surface_lists_its_points_with_u_first() {
    let points: String = (0..6).map(|i| format!("v {} {} 0 {}\n", i % 2, i / 2, i + 1)).collect();
    let text = |kind: &str, rest: &str| {
        format!("{points}cstype {kind}\ndeg 1 2\nsurf 0 1 0 2 1 2 3 4 5 6\n{rest}end\n")
    };
    let file = parsed(&text("rat bspline", "parm u 0 0 1 1\nparm v 0 0 0 2 2 2\n"));
    let [ObjSurface { surface, trim: None, .. }] = &file.surfaces[..] else { panic!("{file:?}") };
    assert_eq!((surface.degree_u, surface.degree_v, surface.domain), (1, 2, None));
    // Homogeneous, with v first: points 1, 3, 5, then 2, 4, 6.
    let expected = [[0, 0, 1], [0, 3, 3], [0, 10, 5], [2, 0, 2], [4, 4, 4], [6, 12, 6]];
    assert_eq!(surface.points, expected.map(|[x, y, w]| [f64::from(x), f64::from(y), 0.0, f64::from(w)]));
    let bezier = parsed(&text("bezier", "parm u 0 1\nparm v 0 2\n"));
    let [ObjSurface { surface, .. }] = &bezier.surfaces[..] else { panic!("{bezier:?}") };
    assert_eq!(
        (surface.knots_u.as_slice(), surface.knots_v.as_slice()),
        (&[0.0, 0.0, 1.0, 1.0][..], &[0.0, 0.0, 0.0, 2.0, 2.0, 2.0][..])
    );
    assert_eq!(surface.points[1], [0.0, 1.0, 0.0, 1.0], "without weights");
    let part = parsed(&text("bspline", "parm u 0 0 1 1\nparm v -1 -1 -1 2 2 2\n"));
    assert_eq!(part.surfaces[0].surface.domain, Some([[0.0, 1.0], [0.0, 2.0]]));
}

#[test]
fn a_surface_is_trimmed_by_curves_of_its_parameters() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvp 0.1 0.1\nvp 0.9 0.1\nvp 0.5 0.9\ncstype bspline\ndeg 1\n\
        curv2 1 2 3 1\nparm u 0 0 1 2 3 3\nend\ndeg 1 1\nsurf 0 1 0 1 1 2 3 4\nparm u 0 0 1 1\nparm v 0 0 1 1\n";
    let file = parsed(&format!("{text}trim 0 3 1\nend\n"));
    let loops = &file.surfaces[0].trim.as_ref().unwrap().loops;
    assert_eq!((loops.len(), loops[0].curves.len()), (1, 1));
    assert_eq!(loops[0].curves[0].points[2], [0.5, 0.9, 1.0]);
    let part = parsed(&format!("{text}trim 0 2 1\nend\n"));
    assert!(
        part.surfaces[0].trim.is_none() && part.skipped[0].what.contains("a part of a curve"),
        "{part:?}"
    );
}

#[test]
fn materials_have_colours_highlights_pictures_and_light() {
    let mtl = "newmtl plain\nKd 0.5 0.25 0\nillum 1\nKs 1 1 1\nnewmtl shiny\nKd 0.5 0.5 0.5\nKs 0.25 0.25 0.25\nNs 50\nnewmtl bright\nKd 0.8 0.8 0.8\n\
        Ks 0.8 0.8 0.8\nillum 2\nnewmtl glass\nillum 7\nNi 1.25\nTf 0.5 1 1\nnewmtl lamp\nKe 2 4 6\nnewmtl painted\nKd 0.5 1 1\n\
        map_Kd -s 1 1 1 -clamp on m.png\nnewmtl metal\nPm 1\nPr 1\nKd 1 0.5 0\nnewmtl odd\nd 0.5\nTr 0.25\nmap_Bump m.png\n";
    let faces: String = ["plain", "shiny", "bright", "glass", "lamp", "painted", "metal", "odd", "unknown"]
        .map(|name| format!("usemtl {name}\nf 1 2 3\n"))
        .concat();
    let loaded = with_materials(mtl, &format!("{SQUARE}{faces}"));
    let description = &loaded.description;
    let kind = |shape: usize| &description.materials[description.world.shapes[shape].material].kind;
    assert_eq!(*kind(0), MaterialKind::diffuse([0.5, 0.25, 0.0]), "model 1 has no highlight");
    let phong = |d: f32, s: f32, n: f32| MaterialKind::phong([d; 3], [d; 3], [s; 3], n);
    // 50 about the half vector is 50 / 4 about the mirrored direction: cos(a / 2)^50 and cos(a)^12.5 are both about exp(-50 a^2 / 8).
    assert_eq!(*kind(1), phong(0.5, 0.25, 12.5));
    // No more than all light; the exponent of roughness 1/2 is 2 / (1/4)^2 - 2.
    assert_eq!(*kind(2), phong(0.5, 0.5, 7.5));
    assert_eq!(*kind(3), MaterialKind::dielectric(1.25, 1.0, [0.5, 1.0, 1.0]));
    let emission = description.world.shapes[4].emission.clone().unwrap();
    assert_eq!(SpectrumParameter::Value(emission.radiance), [2.0, 4.0, 6.0].into());
    assert!(matches!(kind(5), MaterialKind::Diffuse(_)));
    let [picture, scaled] = &description.textures[..] else { panic!() };
    assert!(matches!(picture.kind, TextureKind::Image { image: 0, .. }) && picture.name == "m.png");
    assert!(matches!(&scaled.kind, TextureKind::Scale(_, factor) if *factor == [0.5, 1.0, 1.0].into()));
    let metal = PrincipledMaterial { metallic: 1.0.into(), ..PrincipledMaterial::new([1.0, 0.5, 0.0], 1.0) };
    assert_eq!(*kind(6), MaterialKind::Principled(metal));
    let alpha = |shape: usize| description.world.shapes[shape].alpha.map(|alpha| alpha.opacity);
    assert_eq!((alpha(0), alpha(7)), (None, Some(0.5.into())), "\"d\" goes before \"Tr\"");
    assert_eq!(description.world.shapes[8].material, 0, "grey");
    let warnings = loaded.diagnostics.to_string();
    for part in [
        "a b.mtl:29:1: statement \"map_Bump\" is not read",
        "material \"unknown\" does not exist; grey stands in",
    ] {
        assert!(warnings.contains(part), "{part}: {warnings}");
    }
}

#[test]
fn pictures_of_light_and_opacity_have_the_coordinates_of_the_surface() {
    let mtl = "newmtl lamp\nKe 2 4 6\nmap_Ke m.png\nTr 0.5\nmap_d m.png\n";
    let uvs = "vt 5 -2\nvt 5.5 -2\nvt 5 -1.5\nvt 7 0\n";
    let faces = "usemtl lamp\nf 1/1 2/2 3/3\n";
    let loaded = with_materials(mtl, &format!("{SQUARE}{uvs}{faces}"));
    assert_eq!(loaded.diagnostics.to_string(), "");
    let (description, shape) = (&loaded.description, &loaded.description.world.shapes[0]);
    let emission = shape.emission.as_ref().unwrap();
    assert_eq!(SpectrumParameter::Value(emission.radiance.clone()), [2.0, 4.0, 6.0].into());
    assert_eq!(description.images[emission.image.unwrap()].picture.to_rgb().unwrap()[0][0], 1.0);
    let GeometryDescription::Triangles { uvs: Some(found), .. } = &shape.geometry else { panic!() };
    assert_eq!(found[..], [[0.0, 0.0], [0.5, 0.0], [0.0, 0.5]].map(DVec2::from), "moved by whole pictures");
    // Without alpha, brightness counts: the green of red is 0.
    let Some(FloatParameter::Texture(scaled)) = shape.alpha.map(|alpha| alpha.opacity) else { panic!() };
    let TextureKind::Scale(SpectrumParameter::Texture(picture), factor) = &description.textures[scaled].kind
    else {
        panic!()
    };
    assert_eq!(*factor, 0.5.into());
    let TextureKind::Image { image, .. } = description.textures[*picture].kind else { panic!() };
    assert_eq!(description.images[image].picture.to_rgb().unwrap(), [[0.0; 3]]);
    let loaded = with_materials(mtl, &format!("{SQUARE}{uvs}usemtl lamp\nf 1/1 2/2 3/4\n"));
    assert!(
        loaded
            .diagnostics
            .to_string()
            .contains("material \"lamp\": the picture of emitted light does not repeat")
    );
}

#[test]
fn a_missing_file_of_materials_has_a_substitute_and_a_bad_one_is_an_error() {
    let loaded =
        load_str("m", &format!("mtllib x.mtl y.mtl\n{SQUARE}usemtl a\nf 1 2 3\n"), &Options::default())
            .unwrap();
    let warnings = loaded.diagnostics.to_string();
    assert!(warnings.contains("warning: m: file \"x.mtl y.mtl\" is not there;"), "{warnings}");
    let error = read_materials(b"newmtl a\nKd 1 1 x\n").unwrap_err().to_string();
    assert_eq!(error, "2:8: \"x\" is not a finite number");
    assert_eq!(
        read_materials(b"Kd 1 1 1\n").unwrap_err().to_string(),
        "1:1: \"Kd\" precedes the first \"newmtl\""
    );
}

#[test]
fn errors_have_line_and_column() {
    for (text, expected) in [
        ("v 1 2", "1:1: \"v\" has 2 values; it needs at least 3"),
        ("v 1 2 nan", "1:7: \"nan\" is not a finite number"),
        ("v 1 2 3\nf 1 1 2", "2:7: vertex 2 does not exist; 1 precede this line"),
        ("v 1 2 3\nf 1 1 0", "2:7: vertex 0 does not exist; 1 precede this line"),
        ("v 1 2 3\nf 1 1 -2", "2:7: vertex -2 does not exist; 1 precede this line"),
        ("v 1 2 3\nf 1 1/1 1", "2:5: texture vertex 1 does not exist; 0 precede this line"),
        ("v 1 2 3\nf 1 1 \\\n 1/2/3/4", "3:2: texture vertex 2 does not exist; 0 precede this line"),
        ("v 1 2 3\nf 1 1 a", "2:7: \"a\" is not a vertex; corners are written as 1, 1/2, 1//3 or 1/2/3"),
        ("v 1 2 3\nf 1 1 //", "2:7: \"//\" is not a vertex; corners are written as 1, 1/2, 1//3 or 1/2/3"),
        ("deg 0", "1:5: the degree is 0; it must be at least 1 and at most 100"),
        (
            "v 1 2 3\ndeg 1\nsurf 0 1 0 1 1\nparm u 0 1 0",
            "4:12: parameters must not decrease, but 0 follows 1",
        ),
        (
            "v 1 2 3\ndeg 1\nsurf 0 1 0 1 1\nparm u 0 0 1\nend",
            "5:1: 3 parameters along u are too few for degree 1",
        ),
        (
            "v 1 2 3\ndeg 1\nsurf 0 1 0 1 1\nparm u 0 0 1 1\nparm v 0 0 1 1\nend",
            "6:1: the surface has 1 points; its degrees and parameters need 2 times 2",
        ),
        (
            "v 1 2 3\ndeg 1\nsurf 0 2 0 1 1 1 1 1\nparm u 0 0 1 1\nparm v 0 0 1 1\nend",
            "6:1: the range from 0 to 2 is empty, or outside the parameters",
        ),
    ] {
        assert_eq!(message(text), expected, "{text}");
    }
}

#[test]
fn files_are_recognised_by_their_first_statement() {
    for text in ["# Blender\n\nmtllib a.mtl\n", "v 0 0 0", "o x", "g default\n", "\u{feff}# x\nv 0 0 0"] {
        assert!(is_obj(text.as_bytes()), "{text}");
    }
    assert!(is_obj(format!("v 0 0 0{}", " 1".repeat(100_000)).as_bytes()));
    for text in ["", "# v 0 0 0", "v", "Shape \"sphere\"", "WorldBegin", "32\n1,2", "{ \"asset\": 1 }"] {
        assert!(!is_obj(text.as_bytes()), "{text}");
    }
}

#[test]
fn the_frame_of_the_description_is_that_of_the_file() {
    let loaded = load_str("m", &format!("{SQUARE}f 1 2 3 4\n"), &Options::default()).unwrap();
    let bounds = loaded.description.bounds();
    assert_eq!((bounds.min, bounds.max), (DVec3::ZERO, DVec3::new(1.0, 1.0, 0.0)));
    assert!(matches!(loaded.description.world.shapes[0].geometry, GeometryDescription::Triangles { .. }));
    assert!(
        load_str("m", "o x\n", &Options::default())
            .unwrap_err()
            .to_string()
            .contains("no faces and no surfaces")
    );
    assert!(load(Path::new("no.obj"), &Options::default()).is_err());
}

#[test]
fn curves_in_space_and_surfaces_that_are_not_read_have_no_number_among_trimming_curves() {
    let skipped =
        "cstype cardinal\nsurf 0 1 0 1 1\nend\ncstype bspline\ndeg 1\ncurv 0 1 1 2\nparm u 0 0 1 1\nend\n";
    let file = parsed(&format!(
        "{SQUARE}vp 0.1 0.1\nvp 0.9 0.1\nvp 0.5 0.9\n{skipped}curv2 1 2 3 1\nparm u 0 0 1 2 3 3\nend\n\
         deg 1 1\nsurf 0 1 0 1 1 2 4 3\nparm u 0 0 1 1\nparm v 0 0 1 1\ntrim 0 3 1\nend\n"
    ));
    assert_eq!(file.surfaces[0].trim.as_ref().unwrap().loops[0].curves[0].points[2], [0.5, 0.9, 1.0]);
    // A trimming curve that is not read has one.
    let other = "vp 0 0\ncstype cardinal\ncurv2 1 1\nend\ncstype bspline\ndeg 1 1\n";
    let surface = "surf 0 1 0 1 1 2 4 3\nparm u 0 0 1 1\nparm v 0 0 1 1\ntrim 0 3 1\nend\n";
    assert!(parsed(&format!("{SQUARE}{other}{surface}")).surfaces[0].trim.is_none());
}

#[test]
fn parts_that_are_left_out_are_named_once_with_their_first_place() {
    let file = parsed(&format!("# {}\n{}call a.obj\n", "x".repeat(100_000), "l 1 2\n".repeat(200_000)));
    let found: Vec<_> = file.skipped.iter().map(|s| (s.what.as_str(), s.line, s.column)).collect();
    let what = |name: &str| format!("statement \"{name}\" is not read and skipped");
    assert_eq!(found, [(what("l").as_str(), 2, 1), (what("call").as_str(), 200_002, 1)]);
}

#[test]
fn names_may_contain_number_signs_and_letters_of_latin_1() {
    let text = [
        SQUARE.as_bytes(),
        b"usemtl Material #1\nf 1 2 3 # a face\nusemtl gr\xfcn\nf 1 2 3\nusemtl gr\xe4n\nf 1 2 3\n",
    ];
    let file = read(&text.concat()).unwrap();
    assert_eq!(file.materials, ["Material #1", "gr\u{fc}n", "gr\u{e4}n"]);
    let file = parsed("\u{feff}mtllib a.mtl\n");
    assert_eq!((file.libraries, file.skipped), (vec!["a.mtl".to_owned()], vec![]));
}

#[test]
fn pictures_are_scaled_shifted_and_clamped() {
    let mtl = "newmtl a\nmap_Kd -cc on -s 2 3 1 -o 0.5 -clamp on my m.png\nmap_Ke -mm 0 2 m.png\n";
    let file = read_materials(mtl.as_bytes()).unwrap();
    let expected =
        ObjPicture { file: "my m.png".to_owned(), scale: [2.0, 3.0], offset: [0.5, 0.0], clamped: true };
    assert_eq!(file.materials[0].diffuse_map, Some(expected));
    assert!(file.skipped[0].what.contains("option \"-mm\""), "{file:?}");
    let mtl = "newmtl a\nmap_Kd -s 2 3 -o 0.5 0.25 -clamp on m.png\nmap_Ke m.png\n";
    let loaded = with_materials(mtl, &format!("{SQUARE}usemtl a\nf 1 2 3\n"));
    let TextureKind::Image { mapping, wrap, .. } = &loaded.description.textures[0].kind else { panic!() };
    let expected = MappingDescription::Uv { scale: DVec2::new(2.0, 3.0), offset: DVec2::new(0.5, 0.25) };
    assert_eq!((mapping, *wrap), (&expected, ImageWrap::Clamp));
    // Without `Ke`, the picture counts alone.
    let emission = loaded.description.world.shapes[0].emission.clone().unwrap();
    assert_eq!(SpectrumParameter::Value(emission.radiance), [1.0; 3].into());
    assert_eq!(loaded.description.images[emission.image.unwrap()].name, "m.png");
}

#[test]
fn a_file_of_materials_is_read_once_whatever_its_names() {
    let loaded = with_materials(
        "newmtl a\nKd 1 0 0\n",
        &format!("mtllib ./a b.mtl\nmtllib a b.mtl\n{SQUARE}usemtl a\nf 1 2 3\n"),
    );
    // The grey one and that of the file.
    assert_eq!(loaded.description.materials.len(), 2);
}

#[test]
fn curves_that_all_loops_share_are_refused() {
    // Hundred times 91 points, in some 2000 bytes.
    let knots: String = (0..=90).map(|knot| format!(" {knot}")).collect();
    let text = format!(
        "{SQUARE}vp 0.1 0.1\nvp 0.9 0.1\nvp 0.5 0.9\ncstype bspline\ndeg 1\ncurv2{} 1\nparm u 0{knots} 90\nend\ndeg 1 1\n\
         surf 0 1 0 1 1 2 4 3\nparm u 0 0 1 1\nparm v 0 0 1 1\n",
        " 1 2 3".repeat(30)
    );
    assert_eq!(
        parsed(&format!("{text}trim 0 90 1\nhole 0 90 1\nend\n")).surfaces[0]
            .trim
            .as_ref()
            .unwrap()
            .loops
            .len(),
        2
    );
    let error = message(&format!("{text}trim{}\nend\n", " 0 90 1".repeat(100)));
    assert!(
        error.ends_with("trimming loops use the same curves too often; give each loop its own curves"),
        "{error}"
    );
}
