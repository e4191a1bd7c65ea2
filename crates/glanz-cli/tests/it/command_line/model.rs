//! Models, which have no camera and light of their own.

use crate::command_line::small_scene::SCENE;
use crate::command_line::support::Folder;

/// The corners of a box with a tower at +x, +y; in metres times `unit`.
fn tower(unit: f64) -> String {
    let mut vertices = String::new();
    for [size, height] in [[1.0, 0.5], [0.4, 1.5]] {
        for i in 0..8 {
            let side = |bit: i32, from: f64| if i & bit == 0 { from } else { 1.0 };
            let z = if i & 4 == 0 { 0.0 } else { height };
            let at = [side(1, 1.0 - size) * unit, side(2, 1.0 - size) * unit, z * unit];
            vertices += &format!("{} {} {}\n", at[0], at[1], at[2]);
        }
    }
    let mut faces = String::new();
    for first in [0, 8] {
        for face in [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]] {
            let [a, b, c, d] = face.map(|corner| corner + first);
            faces += &format!("4 {a} {b} {c} {d}\n");
        }
    }
    format!(
        "ply\nformat ascii 1.0\nelement vertex 16\nproperty double x\nproperty double y\nproperty double z\n\
         element face 12\nproperty list uchar int vertex_indices\nend_header\n{vertices}{faces}"
    )
}

fn with_model() -> Folder {
    let folder = Folder::new();
    folder.write("tower.ply", tower(1.0));
    folder
}

/// Mean absolute difference of two pictures.
fn difference(folder: &Folder, a: &str, b: &str) -> f32 {
    let (a, b) = (folder.picture(a).to_rgb().unwrap(), folder.picture(b).to_rgb().unwrap());
    let sum: f32 = a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| (a - b).abs()).sum();
    sum / (3 * a.len()) as f32
}

#[test]
fn a_model_has_a_picture_with_the_defaults_of_models() {
    let folder = with_model();
    let report = folder.succeed("render tower.ply --size 32x18 --up z --json -q").json();
    assert_eq!(folder.names(), ["tower.exr", "tower.ply"]);
    assert_eq!((&report["samples_per_pixel"], &report["warnings"]), (&64.into(), &serde_json::json!([])));
    let pixels = folder.picture("tower.exr").to_rgb().unwrap();
    let grey = pixels.iter().map(|p| p[1]);
    assert!(grey.clone().all(|x| x > 0.02 && x < 1.2), "nothing is black or burnt out");
    let (low, high) = (grey.clone().fold(f32::MAX, f32::min), grey.fold(0.0, f32::max));
    assert!(high - low > 0.3, "light and shadow: {low} to {high}");
}

#[test]
fn the_picture_of_a_model_does_not_depend_on_its_unit() {
    let folder = with_model();
    for (name, unit) in [("micro", 1e-6), ("kilo", 1e3), ("binary", 1.0 / 1024.0)] {
        folder.write(&format!("{name}.ply"), tower(unit));
    }
    for name in ["tower", "micro", "kilo", "binary"] {
        folder.succeed(&format!("render {name}.ply -o {name}.exr --size 48x27 --spp 16 --up z -q"));
    }
    // Powers of two round alike; other units move a few samples over edges.
    assert_eq!(difference(&folder, "tower.exr", "binary.exr"), 0.0);
    for name in ["micro.exr", "kilo.exr"] {
        let difference = difference(&folder, "tower.exr", name);
        assert!(difference < 2e-3, "{name}: {difference}");
    }
}

#[test]
fn the_ground_looks_like_the_background_where_no_shadow_falls() {
    let folder = with_model();
    let linear = |byte: f32| ((byte / 255.0 + 0.055) / 1.055).powf(2.4);
    for (view, color, bytes) in [("front", "#d6d6d6", [214.0; 3]), ("iso", "#3264c8", [50.0, 100.0, 200.0])] {
        let line = format!(
            "render tower.ply -o a.exr --up z --size 120x12 --spp 256 --view {view} --background {color}"
        );
        folder.succeed(&format!("{line} -q"));
        let picture = folder.picture("a.exr").to_rgb().unwrap();
        let background = bytes.map(linear);
        for row in 0..12 {
            // Far to the left: from the front, the ground begins half way down.
            let columns = &picture[row * 120..row * 120 + 4];
            for channel in 0..3 {
                let mean = columns.iter().map(|p| p[channel]).sum::<f32>() / 4.0;
                let ratio = mean / background[channel];
                assert!((ratio - 1.0).abs() < 0.03, "{view} row {row} channel {channel}: {ratio}");
            }
        }
    }
}

#[test]
fn options_of_models_change_the_picture() {
    let folder = with_model();
    folder.succeed("render tower.ply -o a.exr --size 32x18 --spp 4 --up z -q");
    for option in
        ["--view back", "--view top", "--background white", "--ground off", "--material gold", "--up y"]
    {
        folder.succeed(
            &format!("render tower.ply -o b.exr --size 32x18 --spp 4 --up z {option} -q")
                .replace("--up z --up y", "--up y"),
        );
        assert!(difference(&folder, "a.exr", "b.exr") > 0.01, "{option} has no effect");
    }
}

#[test]
fn checkpoints_of_other_views_are_refused() {
    let folder = with_model();
    folder.succeed("render tower.ply -o a.png --size 8x8 --spp 2 --checkpoint c --view top -q");
    folder.succeed("render tower.ply -o a.png --size 8x8 --spp 2 --checkpoint c --view top --resume -q");
    let ran = folder.run("render tower.ply -o a.png --size 8x8 --spp 2 --checkpoint c --view front --resume");
    ran.refused(1, &["c:"]);
}

#[test]
fn rib_and_lists_of_patches_are_models() {
    let folder = Folder::new();
    folder.write("a.rib", "Patch \"bilinear\" \"P\" [0 0 0  1 0 0  0 1 1  1 1 1]\n");
    folder.succeed("render a.rib -o a.exr --size 16x9 --spp 1 -q");
    let info = folder.run("info a.rib --json").json();
    for (corner, expected) in [("min", 0.0), ("max", 1.0)] {
        let corner = info["bounds"][corner].as_array().unwrap();
        // Bounds contain the rounding of the patches.
        assert!(corner.iter().all(|x| (x.as_f64().unwrap() - expected).abs() < 1e-13), "{info}");
    }
    assert_eq!(info["lights"], serde_json::json!({}), "the summary is that of the model alone");
}

#[test]
fn what_models_lack_is_said() {
    let folder = with_model();
    folder.run("bake tower.ply -o a.glb").refused(1, &["tower.ply", "no lights", "help:"]);
    folder.run("illuminate tower.ply -o lux --room 1 1 1").refused(1, &["tower.ply", "no lights", "help:"]);
    folder.run("render tower.ply --view sideways").refused(2, &["sideways", "front", "iso"]);
    folder.run("render tower.ply --up x").refused(2, &["--up", "y or z"]);
    folder.run("render tower.ply --material wood").refused(2, &["wood", "steel", "plastic:#rrggbb"]);
    folder.run("render tower.ply --background #12").refused(2, &["#12", "#rrggbb"]);
    folder.write("small.pbrt", SCENE);
    let ran = folder.succeed("render small.pbrt -o a.png --spp 1 --view top --material gold");
    assert!(ran.stderr.contains("warning: --view, --material"), "{}", ran.stderr);
}

#[test]
fn a_turntable_writes_its_frames() {
    let folder = with_model();
    folder.succeed("render tower.ply -o a.png -o a.exr --turntable 4 --size 24x18 --spp 4 --up z -q");
    let expected: Vec<String> = (1..=4)
        .flat_map(|i| [format!("a-{i}.exr"), format!("a-{i}.png")])
        .chain(["tower.ply".to_owned()])
        .collect();
    assert_eq!(folder.names(), expected);
    for (a, b) in [("a-1.exr", "a-2.exr"), ("a-2.exr", "a-3.exr"), ("a-1.exr", "a-4.exr")] {
        assert!(difference(&folder, a, b) > 0.005, "{a} is {b}");
    }
    folder.write("small.pbrt", SCENE);
    folder.run("render small.pbrt -o a.png --turntable 4").refused(2, &["--turntable", "small.pbrt"]);
    folder.run("render tower.ply -o a.png --turntable 1").refused(2, &["--turntable"]);
    folder.run("render tower.ply -o a.png --turntable 4 --json").refused(2, &["--turntable", "--json"]);
}

#[test]
fn a_section_shows_marked_faces() {
    let folder = with_model();
    let line = "render tower.ply --size 32x18 --spp 16 --up z --view front -q";
    // The tower takes the upper right quarter of the picture, the box the lower half; the plane cuts both, and is seen from the front.
    let orange = |options: &str| {
        folder.succeed(&format!("{line} -o a.exr {options}"));
        let picture = folder.picture("a.exr").to_rgb().unwrap();
        picture.iter().filter(|[r, g, b]| *r > 2.0 * g && *r > 3.0 * b).count()
    };
    assert_eq!(orange(""), 0);
    assert_eq!(orange("--section z=10"), 0, "the plane misses the model");
    let of_axis = orange("--section y=80%");
    assert!(of_axis > 40, "{of_axis}");
    // What is left out faces the viewer, at -y.
    assert_eq!(of_axis, orange("--section 0,-2,0,-1.6"));
    folder.run("render tower.ply --section w=1").refused(2, &["w=1", "50%"]);
    folder.write("small.pbrt", SCENE);
    folder.run("render small.pbrt -o a.png --section x=0").refused(2, &["--section", "small.pbrt"]);
}

/// A cube of polygons with the side 1 mm, as a STEP file.
fn cube() -> String {
    let mut data = String::new();
    for i in 0..8 {
        let [x, y, z] = [i & 1, i >> 1 & 1, i >> 2 & 1];
        data += &format!("#{}=CARTESIAN_POINT('',({x}.,{y}.,{z}.));", 40 + i);
    }
    let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    for (i, [a, b, c, d]) in sides.into_iter().enumerate() {
        let [a, b, c, d] = [a, b, c, d].map(|corner| corner + 40);
        data +=
            &format!("#{}=FACE('',(#{}));#{}=FACE_OUTER_BOUND('',#{},.T.);", 10 + i, 20 + i, 20 + i, 30 + i);
        data += &format!("#{}=POLY_LOOP('',(#{a},#{b},#{c},#{d}));", 30 + i);
    }
    format!(
        "ISO-10303-21;HEADER;FILE_SCHEMA(('AUTOMOTIVE_DESIGN'));ENDSEC;DATA;
        #1=FACETED_BREP('cube',#2);#2=CLOSED_SHELL('',(#10,#11,#12,#13,#14,#15));
        #4=FACETED_BREP_SHAPE_REPRESENTATION('r',(#1),#910);
        #900=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.));
        #910=(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNIT_ASSIGNED_CONTEXT((#900))REPRESENTATION_CONTEXT('',''));
        {data}ENDSEC;END-ISO-10303-21;"
    )
}

#[test]
fn info_counts_the_omissions_that_it_does_not_list() {
    let folder = Folder::new();
    // A thousand are stored.
    let points: String =
        (2000..3300).map(|number| format!("#{number}=CARTESIAN_POINT('',(0.,0.,0.));")).collect();
    let items: String = (2000..3300).map(|number| format!(",#{number}")).collect();
    let text = cube().replace("(#1)", &format!("(#1{items})")).replace("#900=", &format!("{points}#900="));
    folder.write("points.step", text);
    let text = folder.succeed("info -v points.step").stdout;
    let omitted: Vec<&str> = text.lines().filter(|line| line.starts_with("omitted")).collect();
    assert_eq!(omitted.len(), 1001, "{text}");
    assert!(omitted[1000].contains("300 more"), "{}", omitted[1000]);
}

#[test]
fn edges_are_drawn_over_cad_models() {
    let folder = Folder::new();
    folder.write("cube.step", cube());
    let line = "render cube.step --size 64x36 --view front --material plastic:white --ground off -q";
    // Seen from the front, four edges bound a square that fills 90 % of the height.
    let dark = |options: &str| {
        folder.succeed(&format!("{line} --spp 4 -o a.exr {options}"));
        let pixels = folder.picture("a.exr").to_rgb().unwrap();
        pixels.iter().filter(|[r, ..]| *r < 0.1).count()
    };
    assert_eq!(dark(""), 0);
    let (thin, wide) = (dark("--edges=1"), dark("--edges=3"));
    // Sides of 32 pixels.
    assert!((115..=140).contains(&thin) && (365..=400).contains(&wide), "{thin} {wide}");
    let cut = dark("--edges=3 --section z=50%");
    assert!(cut < wide && cut > wide / 3, "{cut} of {wide}");
    // Parts of the samples have the same edges, and are joined to the bits of the whole.
    folder.succeed(&format!("{line} --edges --spp 4 -o whole.exr"));
    for (name, part) in [("first", "1/2"), ("second", "2/2")] {
        folder.succeed(&format!("{line} --edges --spp 4 --part {part} --checkpoint {name}.glanz"));
    }
    folder.succeed("merge first.glanz second.glanz -o joined.exr");
    assert_eq!(folder.bytes("whole.exr"), folder.bytes("joined.exr"));
    folder.succeed(&format!("{line} --spp 4 --samples 2..4 --checkpoint plain.glanz -o plain.exr"));
    let words = ["plain.glanz cannot be joined with first.glanz", "differ in edges", "the same --edges"];
    folder.run("merge first.glanz plain.glanz -o m.exr").refused(1, &words);
    folder.write("small.pbrt", SCENE);
    let ran = folder.succeed("render small.pbrt -o a.png --spp 1 --edges");
    assert!(ran.stderr.contains("warning: no edges are drawn"), "{}", ran.stderr);
    folder.run("render cube.step -o a.png --edges=0").refused(2, &["--edges", "above 0"]);
}
