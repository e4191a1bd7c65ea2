//! Values on surfaces, looked up as the page does.

use std::sync::Arc;

use glanz_math::DVec2;
use glanz_scene::HitLocation;

use super::super::{LuxCell, LuxLookup, LuxReading, MapLabel};
use super::*;

/// Map value at a point of a patch, by linear interpolation between texel centres.
fn shown(file: &File, words: &[u32], x: f64, y: f64) -> [f64; 3] {
    let map = &file.head["maps"][0];
    let (width, height) = (number(&map["width"]), number(&map["height"]));
    let texels = file.floats(map["block"].as_str().unwrap());
    assert_eq!(texels.len(), 3 * width * height);
    let part: Vec<f64> = words[12..16].iter().map(|&word| f32::from_bits(word).into()).collect();
    let at = [(part[0] + x * part[2]) * width as f64 - 0.5, (part[1] + y * part[3]) * height as f64 - 0.5];
    let texel = |i: f64, j: f64, k: usize| texels[3 * (j as usize * width + i as usize) + k];
    let [(i, s), (j, t)] = at.map(|a| ((a + 1e-5).floor(), a - (a + 1e-5).floor()));
    [0, 1, 2].map(|k| {
        let (next_i, next_j) = ((i + 1.0).min(width as f64 - 1.0), (j + 1.0).min(height as f64 - 1.0));
        let row = |j: f64| texel(i, j, k) * (1.0 - s) + texel(next_i, j, k) * s;
        row(j) * (1.0 - t) + row(next_j) * t
    })
}

#[test]
fn values_are_shown_where_they_belong() {
    let text = r#"
        WorldBegin
        ObjectBegin "pair"
            Shape "nurbs" "integer nu" 3 "integer nv" 2 "integer uorder" 2 "integer vorder" 2
                "float uknots" [0 0 1 2 2] "float vknots" [0 0 1 1]
                "point3 P" [0 0 0  1 0 0  2 0 0   0 1 0  1 1 0  2 1 0]
            Shape "plane" "float x" [0 1] "float y" [2 5]
        ObjectEnd
        ObjectInstance "pair"
        Translate 5 0 0  ObjectInstance "pair"
        Shape "sphere"  Shape "box"
        Shape "trianglemesh" "point3 P" [0 0 0  1 0 0  0 1 0]"#;
    let (description, scene) = load(text);
    let model = Model::try_new("test", &description, &scene, &description.files).unwrap();
    // Linear in the parameters, so that interpolation is exact; nothing is known of the sphere.
    let value = |surface: u32, face: u32, uv: DVec2, _| {
        let kind = scene.placed_surfaces()[surface as usize].surface().kind();
        let numbers = [f64::from(surface) * 10.0 + f64::from(face), uv.x, 3.0 - uv.y];
        (kind != "sphere").then(|| numbers.map(|x| x as f32))
    };
    let label = MapLabel { unit: "1", is_colour: true, two_sided: false };
    let file = File::read(&model.with_map(label, &scene, 5, |_| true, value).unwrap().to_bytes().unwrap());
    let map = &file.head["maps"][0];
    assert_eq!((&map["unit"], &map["channels"]), (&"1".into(), &3.into()));
    let patches = file.words("patches");
    let mut seen = 0;
    let placed = scene.placed_surfaces();
    for (surface, object) in file.list("objects").iter().enumerate() {
        let kind = placed[surface].surface().kind();
        if kind == "sphere" || kind == "trianglemesh" {
            assert_eq!(object["map"], Value::Null, "{kind}");
            continue;
        }
        assert_eq!(object["map"], 0);
        let of = &file.list("surfaces")[number(&object["surface"])];
        let rows = patches.chunks(16).skip(number(&of["first"])).take(number(&of["count"]));
        for words in rows {
            for (x, y) in [(0.0, 0.0), (1.0, 0.0), (0.3, 0.9), (1.0, 1.0)] {
                // All these have the parameters of their patches.
                let expected = [surface as f64 * 10.0 + f64::from(words[2]), x, 3.0 - y];
                let found = shown(&file, words, x, y);
                assert!(
                    found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-4),
                    "{found:?} {expected:?}"
                );
            }
            seen += 1;
        }
    }
    // Two copies of two pieces and a rectangle, and the sides of the box.
    assert_eq!(seen, 12);
    // Sphere, box, triangle, and two copies of two.
    assert_eq!(map["largest"], 60.0);
}

#[test]
fn patches_on_a_map_keep_their_points() {
    let (description, scene) = load("WorldBegin\nShape \"sphere\"");
    let bare = Model::try_new("test", &description, &scene, &[]).unwrap();
    let before = File::read(&bare.to_bytes().unwrap());
    let label = MapLabel { unit: "", is_colour: true, two_sided: false };
    let with = bare.with_map(label, &scene, 4, |_| true, |_, _, _, _| Some([1.0; 3])).unwrap();
    let after = File::read(&with.to_bytes().unwrap());
    assert_eq!(before.words("points"), after.words("points"));
    let of = &after.list("surfaces")[number(&after.list("objects")[0]["surface"])];
    let (first, old) = (16 * number(&of["first"]), before.words("patches"));
    for (patch, old) in after.words("patches")[first..].chunks(16).zip(old.chunks(16)) {
        assert_eq!(patch[..12], old[..12]);
        assert!(patch[14] > 0 && old[14] == 0);
    }
}

#[test]
fn back_has_values_of_its_own_half_a_map_below_those_of_the_front() {
    let (description, scene) = load("WorldBegin\nShape \"box\"");
    let model = Model::try_new("test", &description, &scene, &[]).unwrap();
    let value = |_, face: u32, _, back| Some([if back { -1.0 - face as f32 } else { face as f32 }; 3]);
    let label = MapLabel { unit: "", is_colour: true, two_sided: true };
    let file = File::read(&model.with_map(label, &scene, 3, |_| true, value).unwrap().to_bytes().unwrap());
    assert_eq!(file.head["maps"][0]["sides"], 2);
    let surface = &file.list("surfaces")[number(&file.list("objects")[0]["surface"])];
    let mut seen = 0;
    for words in file.words("patches").chunks(16).skip(number(&surface["first"])) {
        let mut behind = words.to_vec();
        behind[13] = (f32::from_bits(words[13]) + 0.5).to_bits();
        for (x, y) in [(0.0, 0.0), (1.0, 0.4), (0.5, 1.0)] {
            let face = f64::from(words[2]);
            assert_eq!(shown(&file, words, x, y).map(|x| x.round()), [face; 3]);
            assert_eq!(shown(&file, &behind, x, y).map(|x| x.round()), [-1.0 - face; 3]);
        }
        seen += 1;
    }
    assert_eq!(seen, 6);
}

#[test]
fn values_at_a_trimmed_border_are_not_mixed_with_nothing() {
    let (description, scene) = load("WorldBegin\nShape \"box\"");
    let model = Model::try_new("test", &description, &scene, &[]).unwrap();
    // As if a corner were trimmed away.
    let value = |_, _, uv: DVec2, _| (uv.x + uv.y < 1.05).then_some([2.0; 3]);
    let label = MapLabel { unit: "", is_colour: true, two_sided: false };
    let file = File::read(&model.with_map(label, &scene, 9, |_| true, value).unwrap().to_bytes().unwrap());
    let texels = file.floats("map0");
    assert!(texels.iter().filter(|&&x| x == 2.0).count() >= 6 * 81 * 3, "{texels:?}");
}

/// One cell of 1 m^2 on each surface, with 100 lx times the number of the surface.
#[derive(Debug)]
struct CellOfSurface;

impl LuxLookup for CellOfSurface {
    fn reading(&self, _: &HitLocation) -> Option<LuxReading> {
        None
    }

    fn cells_on(&self, surface: u32) -> Vec<LuxCell> {
        vec![LuxCell { lux: 100.0 * surface as f32, error: 0.0, area: 1.0 }]
    }
}

/// The model of shapes with 100 lx on all that can show them.
fn lit(shapes: &str) -> File {
    let (description, scene) = load(&format!("WorldBegin\n{shapes}"));
    let model = Model::try_new("test", &description, &scene, &[]).unwrap();
    let label = MapLabel { unit: "lx", is_colour: false, two_sided: false };
    let model = model.with_map(label, &scene, 5, |_| true, |_, _, _, _| Some([100.0; 3])).unwrap();
    File::read(&model.with_lux(Arc::new(CellOfSurface)).to_bytes().unwrap())
}

const MESH_RECEIVER: &str =
    r#"Shape "trianglemesh" "string receiver" "mesh" "point3 P" [0 0 1  1 0 1  0 1 1]"#;

#[test]
fn cells_of_surfaces_that_show_illuminances_count_for_the_scale() {
    let sheet = r#"Shape "bilinearmesh" "string receiver" "sheet" "point3 P" [0 0 0  1 0 0  0 1 0  1 1 0]"#;
    let file = lit(&format!("{MESH_RECEIVER}\n{sheet}"));
    let is_shown: Vec<bool> = file.list("objects").iter().map(|object| !object["map"].is_null()).collect();
    assert_eq!(is_shown.iter().filter(|&&is_shown| is_shown).count(), 1, "{is_shown:?}");
    let surface = is_shown.iter().position(|&is_shown| is_shown).unwrap();
    assert_eq!(file.floats("luxCells"), [100.0 * surface as f64, 1.0]);
    // One number for each of 5 x 5 values.
    assert_eq!((&file.head["maps"][0]["channels"], file.floats("map0")), (&1.into(), vec![100.0; 25]));
}

#[test]
fn scenes_whose_receivers_are_all_meshes_have_an_empty_map_and_no_cells() {
    let file = lit(MESH_RECEIVER);
    assert!(file.list("objects").iter().all(|object| object["map"].is_null()));
    assert_eq!((&file.head["maps"][0]["unit"], file.floats("map0")), (&"lx".into(), vec![0.0]));
    assert!(file.floats("luxCells").is_empty());
}
