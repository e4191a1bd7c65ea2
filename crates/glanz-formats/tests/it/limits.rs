//! Limits of resources: what each reader may use, and where its end is reported.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;
use std::thread;
use std::time::{Duration, Instant};

use glanz_formats::image::{self, Format};
use glanz_formats::{Diagnostics, Options, list_files, load, load_str};
use glanz_job::{BudgetError, CancelFlag, Resource, ResourceLimits};
use glanz_light::{Pixels, Tone};

/// The reason of the end of reading `text`, with the only message.
fn end(text: &str, options: &Options) -> (BudgetError, String) {
    only(load_str("a", text, options).expect_err("reading has to end"))
}

fn only(diagnostics: Diagnostics) -> (BudgetError, String) {
    let messages = diagnostics.to_string();
    assert_eq!(diagnostics.iter().count(), 1, "{messages}");
    (diagnostics.end().unwrap_or_else(|| panic!("{messages}")), messages)
}

fn limited(change: impl FnOnce(&mut ResourceLimits)) -> Options {
    let mut options = Options::default();
    change(&mut options.limits);
    options
}

fn resource((end, _): (BudgetError, String)) -> Resource {
    match end {
        BudgetError::Limit(limit) => limit.resource,
        other => panic!("{other}"),
    }
}

/// A triangle, up to its nodes.
const GLTF: &str = "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":36,\"uri\":\"data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA\"}],\
    \"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}],\
    \"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],\"nodes\":[";

/// Files of each format with so many triangles or patches.
fn samples(count: usize) -> Vec<(&'static str, String)> {
    let repeated = |first: &str, part: &str, last: &str| format!("{first}{}{last}", part.repeat(count));
    let ply = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {count}\nproperty list uchar int vertex_indices\nend_header\n",
        3 * count
    );
    let mut faces = String::new();
    (0..count).for_each(|i| writeln!(faces, "3 {} {} {}", 3 * i, 3 * i + 1, 3 * i + 2).unwrap());
    let step = "ISO-10303-21;HEADER;FILE_SCHEMA(('AP214'));ENDSEC;DATA;\n";
    let mut points = String::new();
    (1..=count).for_each(|i| writeln!(points, "#{i}=CARTESIAN_POINT('',(0.,{i}.,1.));").unwrap());
    let mut iges = format!("{:<72}S      1\n{:<72}G      1\n", "", ",,;");
    for i in 1..=count {
        write!(
            iges,
            "{:8}{i:8}{:56}D{:07}\n{:8}{:16}{:8}{:40}D{:07}\n",
            116,
            "",
            2 * i - 1,
            116,
            "",
            1,
            "",
            2 * i
        )
        .unwrap();
    }
    (1..=count).for_each(|i| writeln!(iges, "{:<64}{:8}P{i:07}", "116,1.,2.,3.;", 2 * i - 1).unwrap());
    vec![
        ("ply", format!("{ply}{}{faces}", "0 0 0\n1 0 0\n0 1 0\n".repeat(count))),
        (
            "stl",
            repeated(
                "solid\n",
                "facet normal 0 0 0 outer loop vertex 0 0 0 vertex 1 0 0 vertex 0 1 0 endloop endfacet\n",
                "endsolid",
            ),
        ),
        ("obj", repeated("v 0 0 0\nv 1 0 0\nv 0 1 0\n", "f 1 2 3\n", "")),
        ("long obj", repeated("v 0 0 0\nv 1 0 0\nv 0 1 0\nf", " 1 2 3", "\n")),
        ("rib", repeated("", "Patch \"bilinear\" \"P\" [0 0 0  1 0 0  0 2 0  1 2 0]\n", "")),
        (
            "newell",
            repeated(
                &format!("{count}\n"),
                "1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16\n",
                &format!("16\n{}", "0 0 1\n".repeat(16)),
            ),
        ),
        ("gltf", repeated(GLTF, "{\"mesh\":0},", "{}]}")),
        ("step", format!("{step}{points}ENDSEC;END-ISO-10303-21;\n")),
        ("iges", iges),
        ("shapes", repeated("WorldBegin\n", "Shape \"sphere\"\n", "")),
        ("list", repeated("WorldBegin Shape \"trianglemesh\" \"point3 P\" [", "0 0 1 1 0 1 0 1 1\n", "]")),
        ("lights", repeated("WorldBegin\n", "LightSource \"point\"\n", "")),
        ("materials", repeated("WorldBegin\n", "Material \"matte\"\n", "")),
        ("empty objects", repeated("WorldBegin\n", "ObjectBegin \"a\" ObjectEnd\n", "")),
        ("names", repeated("WorldBegin\n", "Texture \"a\" \"float\" \"constant\" \"float value\" 1\n", "")),
    ]
}

#[test]
fn every_reader_keeps_to_the_memory() {
    for (name, text) in samples(3000) {
        let options = limited(|limits| limits.memory = 100_000);
        assert_eq!(resource(end(&text, &options)), Resource::Memory, "{name}");
    }
}

#[test]
fn every_reader_ends_with_its_time() {
    for (name, text) in samples(100) {
        let options = limited(|limits| limits.time = Duration::ZERO);
        assert_eq!(resource(end(&text, &options)), Resource::Time, "{name}");
    }
}

/// The whole takes some tenths of a second or more.
#[test]
fn every_reader_ends_soon_after_the_flag_is_raised() {
    for (name, text) in samples(60_000) {
        let options = limited(|limits| limits.memory = 1 << 40);
        let cancel = options.cancel.clone();
        let raised = thread::spawn(move || {
            thread::sleep(Duration::from_millis(5));
            cancel.cancel();
            Instant::now()
        });
        let ended = load_str("a", &text, &options);
        let late = Instant::now().saturating_duration_since(raised.join().unwrap());
        let (end, messages) = only(ended.expect_err(name));
        assert_eq!(end, BudgetError::Interrupted, "{name}");
        assert!(messages.contains("interrupted"), "{messages}");
        // Far more than is needed, for machines that do other things, too.
        assert!(late < Duration::from_millis(500), "{name}: {late:?}");
    }
}

#[test]
fn the_place_of_the_token_too_many_is_reported() {
    let text = format!("WorldBegin\n{}", "Translate 1 2 3\n".repeat(1000));
    let options = limited(|limits| limits.tokens = 1000);
    let (end, message) = end(&text, &options);
    assert!(message.starts_with("error: a:2"), "{message}");
    assert!(message.contains(": the limit of 1 000 tokens is exceeded\n"), "{message}");
    assert!(message.ends_with("  help: raise ResourceLimits::tokens\n"), "{message}");
    assert!(matches!(end, BudgetError::Limit(limit) if limit.limit == 1000));
    // One word, and four for each line.
    assert!(load_str("a", &text, &limited(|limits| limits.tokens = 4001)).is_ok());
}

#[test]
fn objects_are_shapes_instances_and_copies() {
    let text =
        "WorldBegin ObjectBegin \"a\" Shape \"sphere\" ObjectEnd\nObjectInstance \"a\" ObjectInstance \"a\"";
    assert!(load_str("a", text, &limited(|limits| limits.objects = 3)).is_ok());
    let (_, message) = end(text, &limited(|limits| limits.objects = 2));
    assert!(message.starts_with("error: a:2:35: the limit of 2 objects is exceeded\n"), "{message}");
}

#[test]
fn lights_are_objects() {
    let text = "WorldBegin LightSource \"point\" LightSource \"infinite\"\nLightSource \"distant\"";
    assert!(load_str("a", text, &limited(|limits| limits.objects = 3)).is_ok());
    let (_, message) = end(text, &limited(|limits| limits.objects = 2));
    assert!(message.starts_with("error: a:2:1: the limit of 2 objects is exceeded\n"), "{message}");
    let light = "\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[{\"type\":\"point\"}]}}";
    let node = "\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}";
    let text = format!("{GLTF}{{\"mesh\":0}},{{\"mesh\":0}},{{{node}}}],{light}}}");
    // Two instances of a shape, and the light.
    assert!(load_str("a", &text, &limited(|limits| limits.objects = 4)).is_ok());
    assert_eq!(resource(end(&text, &limited(|limits| limits.objects = 3))), Resource::Objects);
}

#[test]
fn parameters_of_shapes_give_their_memory_back() {
    let corners = "0 0 1 1 0 1 0 1 1\n".repeat(1000);
    let shape = format!("Shape \"trianglemesh\" \"point3 P\" [{corners}] \"integer indices\" [0 1 2]\n");
    let used = |count: usize| {
        let text = format!("WorldBegin\n{}", shape.repeat(count));
        load_str("a", &text, &Options::default()).unwrap().budget.used(Resource::Memory)
    };
    // 3000 corners of 24 bytes, once.
    let one = used(2) - used(1);
    assert!((72_000..100_000).contains(&one), "{one}");
}

#[test]
fn a_list_that_grows_is_taken_off_the_memory() {
    // The list has 160 kB in the end, and three times as much while it is copied.
    let text = format!("Film \"image\" \"float a\" [{}]", "1 ".repeat(20_000));
    assert_eq!(resource(end(&text, &limited(|limits| limits.memory = 300_000))), Resource::Memory);
}

/// A STEP file with an open shell of so many whole spheres.
fn step_faces(count: usize) -> String {
    let (mut faces, mut names) = (String::new(), Vec::new());
    for i in 100..100 + count {
        writeln!(faces, "#{i}=ADVANCED_FACE('',(),#10,.T.);").unwrap();
        names.push(format!("#{i}"));
    }
    format!(
        "ISO-10303-21;HEADER;FILE_SCHEMA(('AUTOMOTIVE_DESIGN'));ENDSEC;DATA;
         #1=SHAPE_REPRESENTATION('r',(#2),#50);#2=SHELL_BASED_SURFACE_MODEL('',(#3));#3=OPEN_SHELL('',({}));
         #10=SPHERICAL_SURFACE('',#11,50.);#11=AXIS2_PLACEMENT_3D('',#12,$,$);#12=CARTESIAN_POINT('',(0.,0.,0.));
         #51=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.));
         #52=(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.));
         #50=(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNIT_ASSIGNED_CONTEXT((#51,#52))REPRESENTATION_CONTEXT('',''));
         {faces}ENDSEC;END-ISO-10303-21;",
        names.join(",")
    )
}

#[test]
fn faces_of_cad_files_are_taken_off_the_budget() {
    let text = step_faces(200);
    assert!(load_str("a", &text, &Options::default()).is_ok());
    // Little more than what is reserved for the size of the file.
    let memory = 24 * text.len() as u64 + 1000;
    assert_eq!(resource(end(&text, &limited(|limits| limits.memory = memory))), Resource::Memory);
    assert_eq!(resource(end(&text, &limited(|limits| limits.objects = 199))), Resource::Objects);
}

#[test]
fn a_file_in_memory_counts_as_one_on_a_disk() {
    let loaded = load_str("a", "WorldBegin", &Options::default()).unwrap();
    assert_eq!((loaded.budget.used(Resource::Files), loaded.budget.used(Resource::Bytes)), (1, 10));
    assert_eq!(resource(end("WorldBegin", &limited(|limits| limits.bytes = 9))), Resource::Bytes);
}

#[test]
fn a_list_of_files_that_a_limit_ends_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("a.pbrt");
    std::fs::write(&scene, "WorldBegin Include \"b.pbrt\"").unwrap();
    std::fs::write(folder.path().join("b.pbrt"), "").unwrap();
    let listed = |files| list_files(&scene, &limited(|limits| limits.files = files));
    assert_eq!(listed(2).unwrap().files.len(), 2);
    assert_eq!(resource(only(listed(1).unwrap_err())), Resource::Files);
}

/// Thirty files of which each includes the next one twice: 2^30 files.
fn doubling(folder: &Path, content: &str) -> std::path::PathBuf {
    for level in 0..30 {
        let next = format!("Include \"{}.pbrt\"\n", level + 1);
        std::fs::write(folder.join(format!("{level}.pbrt")), format!("{content}{next}{next}")).unwrap();
    }
    std::fs::write(folder.join("30.pbrt"), "Identity\n").unwrap();
    folder.join("0.pbrt")
}

#[test]
fn files_that_include_each_other_again_and_again_end() {
    let folder = tempfile::tempdir().unwrap();
    let scene = doubling(folder.path(), "");
    let ended = |options: Options| only(load(&scene, &options).unwrap_err());
    let (end, message) = ended(limited(|limits| limits.files = 500));
    assert_eq!(resource((end, String::new())), Resource::Files);
    assert!(message.contains(".pbrt:1:9: the limit of 500 files is exceeded\n  1 | Include \""), "{message}");
    assert_eq!(resource(ended(limited(|limits| limits.depth = 20))), Resource::Depth);
    assert_eq!(resource(ended(limited(|limits| limits.bytes = 5_000))), Resource::Bytes);
    assert_eq!(resource(ended(limited(|limits| limits.tokens = 500))), Resource::Tokens);
    let quick = Duration::from_millis(50);
    assert_eq!(
        resource(ended(limited(|limits| (limits.time, limits.files) = (quick, 1 << 40)))),
        Resource::Time
    );
}

#[test]
fn limits_count_anew_for_each_call() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("a.pbrt");
    std::fs::write(&scene, "WorldBegin").unwrap();
    let options = limited(|limits| limits.files = 1);
    for _ in 0..3 {
        let loaded = load(&scene, &options).unwrap();
        assert_eq!(loaded.budget.used(Resource::Files), 1);
    }
    std::fs::write(&scene, "WorldBegin Include \"b.pbrt\"").unwrap();
    std::fs::write(folder.path().join("b.pbrt"), "").unwrap();
    assert_eq!(resource(only(load(&scene, &options).unwrap_err())), Resource::Files);
}

#[test]
fn a_flag_that_is_raised_before_ends_at_once() {
    let cancel = CancelFlag::default();
    cancel.cancel();
    let options = Options { cancel, ..Options::default() };
    assert_eq!(end("WorldBegin", &options).0, BudgetError::Interrupted);
}

/// Of three pictures of 1.8 MB with their levels two fit in a quarter of 16 MB, and the pixels of the third come from the temporary file.
#[test]
fn pictures_above_their_share_of_the_memory_are_in_a_file() {
    let folder = tempfile::tempdir().unwrap();
    let rgb: Vec<[f32; 3]> =
        (0..512 * 512).map(|i| [i % 7, i % 11, i % 13].map(|x| x as f32 / 16.0)).collect();
    let pixels = Pixels::try_from_rgb(512, 512, &rgb).unwrap();
    let png = image::write(&pixels, Format::Png, &Tone::default(), &BTreeMap::new()).unwrap();
    let mut text = "WorldBegin".to_owned();
    for name in ["a", "b", "c"] {
        std::fs::write(folder.path().join(format!("{name}.png")), &png).unwrap();
        text += &format!(" Texture \"{name}\" \"spectrum\" \"imagemap\" \"string filename\" \"{name}.png\"");
    }
    let scene = folder.path().join("a.pbrt");
    std::fs::write(&scene, text).unwrap();
    let pictures = [16 << 20, 1 << 30].map(|memory| {
        let loaded =
            load(&scene, &limited(|limits| limits.memory = memory)).unwrap_or_else(|end| panic!("{end}"));
        assert!(loaded.description.images[0].picture.cache().is_none());
        loaded.description.images[2].picture.clone()
    });
    assert!(
        pictures[0].cache().is_some_and(|cache| cache.file_size() > 3 << 18) && pictures[1].cache().is_none()
    );
    assert_eq!(pictures[0].to_rgb().unwrap(), pictures[1].to_rgb().unwrap());
}
