//! Picks with known results.

use std::f64::consts::PI;

use glanz_formats::registry::{Options, load_str};
use glanz_math::DVec3;

use super::*;
use crate::model::{LuxCell, LuxLookup, MapLabel};

fn modelled(text: &str) -> (Scene, Model) {
    let description = load_str("test.pbrt", text, &Options::default()).unwrap().description;
    let scene = Scene::resolve(description.clone()).unwrap().0;
    let model = Model::try_new("test", &description, &scene, &description.files).unwrap();
    (scene, model)
}

fn pick_from(scene_and_model: &(Scene, Model), origin: [f64; 3], direction: [f64; 3]) -> Option<PickResult> {
    let (scene, model) = scene_and_model;
    pick(scene, model, &Ray::new(origin.into(), direction.into()), &PickFilter::default())
}

/// Smallest and largest curvature of a shape at the first place on the way.
fn curvatures(shape: &str, origin: [f64; 3], direction: [f64; 3]) -> [f64; 2] {
    let found = pick_from(&modelled(&format!("WorldBegin\n{shape}")), origin, direction).unwrap();
    let curvature = found.curvature.unwrap();
    let [low, high] = [curvature.minimum, curvature.maximum];
    assert!((curvature.gaussian - low * high).abs() < 1e-9 * (1.0 + (low * high).abs()));
    assert!((curvature.mean - 0.5 * (low + high)).abs() < 1e-9);
    let strongest = low.abs().max(high.abs());
    assert!(curvature.radius.map_or(strongest < 1e-9, |r| (r * strongest - 1.0).abs() < 1e-9));
    [low, high]
}

fn close([a, b]: [f64; 2], [c, d]: [f64; 2]) -> bool {
    (a - c).abs() < 1e-6 && (b - d).abs() < 1e-6
}

#[test]
fn curvatures_are_those_of_closed_forms() {
    let from_x = [[10.0, 0.1, 0.2], [-1.0, 0.0, 0.0]];
    let at = |shape: &str| curvatures(shape, from_x[0], from_x[1]);
    assert!(close(at("Shape \"sphere\" \"float radius\" 2"), [0.5; 2]));
    // Reversed, it is equally convex from outside and concave from inside.
    assert!(close(at("ReverseOrientation Shape \"sphere\" \"float radius\" 2"), [0.5; 2]));
    assert!(close(at("Shape \"cylinder\" \"float radius\" 0.25"), [0.0, 4.0]));
    assert!(close(at("Rotate 90 0 1 0  Shape \"disk\" \"float radius\" 2"), [0.0; 2]));
    // So is a mirrored one.
    assert!(close(at("Scale -2 2 2  Shape \"sphere\""), [0.5; 2]));
    let inside = |shape: &str| curvatures(shape, [0.1, 0.2, 0.3], [1.0, 0.0, 0.0]);
    assert!(close(inside("Scale -2 2 2  Shape \"sphere\""), [-0.5; 2]));
    assert!(close(inside("ReverseOrientation Shape \"sphere\" \"float radius\" 2"), [-0.5; 2]));
    // Seen along x: at the outer equator, and through the hole the inner one.
    let torus = "Shape \"torus\" \"float majorradius\" 2 \"float minorradius\" 0.5";
    assert!(close(curvatures(torus, [9.0, 0.0, 0.0], [-1.0, 0.0, 0.0]), [0.4, 2.0]));
    assert!(close(curvatures(torus, [0.0; 3], [-1.0, 0.0, 0.0]), [-1.0 / 1.5, 2.0]));
    // z = x^2 - y^2 over [-1, 1]^2, its normal up: x = 2u - 1 has x^2 = 1, -1, 1 in Bernstein form.
    let saddle = r#"Shape "bezierpatch" "integer udegree" 2 "integer vdegree" 2
        "point3 P" [-1 -1 0  0 -1 -2  1 -1 0   -1 0 2  0 0 0  1 0 2   -1 1 0  0 1 -2  1 1 0]"#;
    assert!(close(curvatures(saddle, [0.0, 0.0, 5.0], [0.0, 0.0, -1.0]), [-2.0, 2.0]));
}

#[test]
fn curvatures_of_stretched_surfaces_are_those_in_the_world() {
    // An ellipsoid with half axes a = 3, b = c = 1: a / b^2 at its tip, 1 / b and b / a^2 at its waist.
    let shape = "Scale 3 1 1  Shape \"sphere\"";
    assert!(close(curvatures(shape, [9.0, 0.0, 1e-7], [-1.0, 0.0, 0.0]), [3.0; 2]));
    assert!(close(curvatures(shape, [0.0, 9.0, 0.0], [0.0, -1.0, 0.0]), [1.0 / 9.0, 1.0]));
}

#[test]
fn hits_describe_the_surface() {
    let scene = modelled(
        r#"
        WorldBegin
        MakeNamedMaterial "steel" "string type" "phong"
        NamedMaterial "steel"
        Translate 0 0 1
        Shape "nurbs" "integer nu" 4 "integer nv" 3 "integer uorder" 3 "integer vorder" 2
            "float uknots" [0 0 0 2 4 4 4] "float vknots" [0 0 1 2 2]
            "point3 P" [0 0 0  1 0 0  3 0 0  4 0 0   0 1 0  1 1 0  3 1 0  4 1 0   0 2 0  1 2 0  3 2 0  4 2 0]"#,
    );
    let found = pick_from(&scene, [3.0, 0.5, 6.0], [0.0, 0.0, -1.0]).unwrap();
    assert_eq!((found.leaf, found.object, found.kind), (0, 0, "nurbs"));
    assert_eq!((found.name.as_str(), found.material.as_str()), ("steel", "steel"));
    // Knots 0, 2, 4 and 0, 1, 2: four pieces; the points are such that parameters are coordinates.
    assert_eq!((found.degree, found.face), (Some([2, 1]), 2));
    assert!((found.area.unwrap() - 8.0).abs() < 1e-5);
    let near = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-9);
    assert!(near(&found.uv, &[3.0, 0.5]) && near(&found.point, &[3.0, 0.5, 1.0]));
    assert!(near(&found.normal, &[0.0, 0.0, 1.0]) && (found.distance - 5.0).abs() < 1e-9);
    assert_eq!(found.curvature.unwrap().radius, None);
    assert_eq!(pick_from(&scene, [9.0, 0.5, 6.0], [0.0, 0.0, -1.0]), None);
    let text = serde_json::to_value(&found).unwrap();
    assert_eq!(text["curvature"]["radius"], serde_json::Value::Null);
    assert_eq!(text["degree"], serde_json::json!([2, 1]));
}

#[test]
fn hidden_and_cut_away_places_are_passed() {
    // Balls of radius 1 about x = 0, 4 and 8.
    let (scene, model) = modelled(
        "WorldBegin\nShape \"sphere\"\nTranslate 4 0 0 Shape \"sphere\"\nTranslate 4 0 0 Shape \"sphere\"",
    );
    let ray = Ray::new(DVec3::new(-9.0, 0.1, 0.2), DVec3::X);
    let x = |hidden: &[u32], section| {
        let filter =
            PickFilter { hidden: hidden.iter().copied().collect(), section, ..PickFilter::default() };
        pick(&scene, &model, &ray, &filter).map(|hit| (hit.leaf, hit.point[0], hit.distance))
    };
    let half = (1.0 - 0.05_f64).sqrt();
    let at = |found: Option<(u32, f64, f64)>, leaf: u32, x: f64| {
        let (found_leaf, found_x, distance) = found.unwrap();
        assert!(found_leaf == leaf && (found_x - x).abs() < 1e-9 && (distance - x - 9.0).abs() < 1e-9);
    };
    at(x(&[], None), 0, -half);
    at(x(&[0], None), 1, 4.0 - half);
    at(x(&[0, 1], None), 2, 8.0 - half);
    assert_eq!(x(&[0, 1, 2], None), None);
    // x < 0 is cut away, then x < 4: the insides of the spheres are visible.
    at(x(&[], Some([-1.0, 0.0, 0.0, 0.0])), 0, half);
    at(x(&[2], Some([-2.0, 0.0, 0.0, -8.0])), 1, 4.0 + half);
    assert_eq!(x(&[], Some([1.0, 0.0, 0.0, -5.0])), None);
}

#[test]
fn area_is_that_of_the_whole_shape() {
    let area = |shape: &str| {
        let scene = modelled(&format!("WorldBegin\n{shape}"));
        let first = pick_from(&scene, [0.4, 0.3, 9.0], [0.0, 0.0, -1.0]).unwrap().area;
        // From the cache.
        assert_eq!(pick_from(&scene, [0.4, 0.3, 9.0], [0.0, 0.0, -1.0]).unwrap().area, first);
        first
    };
    let close = |found: Option<f64>, expected: f64, accuracy: f64| {
        assert!((found.unwrap() - expected).abs() <= accuracy * expected, "{found:?} {expected}");
    };
    close(area("Scale 1 2 3 Shape \"box\" \"point3 min\" [0 0 0] \"point3 max\" [1 1 1]"), 22.0, 1e-12);
    // Two patches of a list are one shape.
    let list =
        "\"point3 P\" [0 0 0  1 0 0  0 1 0  1 1 0  2 0 0  2 1 0] \"integer indices\" [0 1 2 3  1 4 3 5]";
    close(area(&format!("Shape \"bilinearmesh\" {list}")), 2.0, 1e-9);
    // Two meshes joined into one surface are two shapes.
    let triangle =
        |x: f64| format!("Shape \"trianglemesh\" \"point3 P\" [{x} 0 0  {} 0 0  {x} 2 0]\n", x + 1.0);
    close(area(&(triangle(0.0) + &triangle(5.0))), 1.0, 1e-12);
    // A disk whose parameters have a hole: u is the azimuth, v the distance towards the middle, and a rectangle cuts out a part of a ring.
    let trim = "\"float trimrectangle\" [0.5 0.5 0.75 2]";
    close(area(&format!("Shape \"disk\" \"float radius\" 2 {trim}")), 4.0 * PI - 0.25 * PI, 1e-3);
    assert_eq!(area("Shape \"plane\""), None);
}

#[test]
fn surfaces_that_light_passes_cannot_be_picked() {
    let scene = modelled(
        "WorldBegin
        Material \"interface\"
        Shape \"disk\" \"float height\" 1 \"string receiver\" \"air\"
        Material \"diffuse\"
        Shape \"disk\"",
    );
    let found = pick_from(&scene, [0.1, 0.2, 5.0], [0.0, 0.0, -1.0]).unwrap();
    assert_eq!((found.leaf, found.distance), (1, 5.0));
    assert!(!scene.1.is_seen(0) && scene.1.is_seen(1) && !scene.1.is_seen(2));
}

/// 40 lx at the left and 80 lx at the right of x = 0, on horizontal surfaces.
#[derive(Debug)]
struct TwoCells;

impl LuxLookup for TwoCells {
    fn reading(&self, at: &HitLocation) -> Option<LuxReading> {
        let right = u32::from(at.position.x > 0.0);
        let (receiver, lux) = ("plane".to_owned(), 40.0 * f64::from(1 + right));
        let reading = LuxReading { receiver, cell: [right, 0], lux, ..LuxReading::default() };
        (at.position.z.fract() == 0.0).then_some(reading)
    }

    fn cells_on(&self, _: u32) -> Vec<LuxCell> {
        vec![LuxCell { lux: 40.0, error: 0.0, area: 1.0 }, LuxCell::default()]
    }
}

#[test]
fn picks_have_the_illuminance_of_their_cell_and_meet_receivers_of_air_where_maps_are_shown() {
    let (scene, model) = modelled(
        "WorldBegin
        Material \"interface\"
        Shape \"disk\" \"float height\" 1 \"string receiver\" \"air\"
        Material \"diffuse\"
        Shape \"disk\"
        Translate 5 0 0.5
        Shape \"disk\"",
    );
    let label = MapLabel { unit: "lx", is_colour: false, two_sided: false };
    let model = model.with_map(label, &scene, 2, |_| true, |_, _, _, _| Some([40.0; 3])).unwrap();
    let model = model.with_lux(std::sync::Arc::new(TwoCells));
    let at = |x: f64, maps: bool| {
        let ray = Ray::new(DVec3::new(x, 0.2, 5.0), -DVec3::Z);
        let hit = pick(&scene, &model, &ray, &PickFilter { maps, ..PickFilter::default() }).unwrap();
        (hit.leaf, hit.lux.map(|reading| (reading.cell, reading.lux)))
    };
    assert_eq!(at(-0.1, false), (1, Some(([0, 0], 40.0))));
    assert_eq!(at(0.1, true), (0, Some(([1, 0], 80.0))));
    assert_eq!(at(5.0, true), (2, None));
}

#[test]
fn walls_seen_from_outside_are_passed_if_they_are_seen_through() {
    let (scene, model) = modelled(
        "WorldBegin
        LightSource \"point\" \"point3 from\" [2 1.5 1]
        Shape \"bilinearmesh\" \"point3 P\" [0 0 0  4 0 0  0 3 0  4 3 0]
        Shape \"bilinearmesh\" \"point3 P\" [0 0 2.5  4 0 2.5  0 3 2.5  4 3 2.5]",
    );
    let model = model.with_outer_sides(&scene);
    let z = |from: f64, direction: DVec3, see_through: bool| {
        let filter = PickFilter { see_through, ..PickFilter::default() };
        let hit = pick(&scene, &model, &Ray::new(DVec3::new(1.0, 1.0, from), direction), &filter);
        hit.map(|hit| hit.point[2])
    };
    // Through the ceiling, whose normal points up, onto the floor; from within, both are there.
    assert_eq!((z(9.0, -DVec3::Z, false), z(9.0, -DVec3::Z, true)), (Some(2.5), Some(0.0)));
    assert_eq!((z(1.0, DVec3::Z, true), z(1.0, -DVec3::Z, true)), (Some(2.5), Some(0.0)));
    assert_eq!((z(-9.0, DVec3::Z, false), z(-9.0, DVec3::Z, true)), (Some(0.0), Some(2.5)));
}

/// The two discs of radius 20 mm and height 10 mm of `tests/discs.step`, the first at the origin, the second 60 mm along x.
fn discs() -> (Scene, Model) {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/discs.step");
    let loaded = glanz_formats::load(&path, &Options::default()).unwrap();
    let description = loaded.description;
    let scene = Scene::resolve(description.clone()).unwrap().0;
    let model = Model::try_new("discs.step", &description, &scene, &[]).unwrap();
    (scene, model.with_cad(loaded.cad.unwrap()))
}

#[test]
fn a_picked_face_has_its_number_in_the_file_its_area_and_its_radius() {
    let discs = discs();
    let wall = pick_from(&discs, [-1.0, 0.0, 0.005], [1.0, 0.0, 0.0]).unwrap();
    assert_eq!((wall.name.as_str(), wall.kind, wall.entity.as_deref()), ("wall", "cylinder", Some("#40")));
    let radius = wall.dimensions.unwrap().radius.unwrap();
    assert!((radius - 0.02).abs() < 1e-12, "{radius}");
    let top = pick_from(&discs, [0.06, 0.0, 1.0], [0.0, 0.0, -1.0]).unwrap();
    // It has no name of its own.
    assert_eq!((top.name.as_str(), top.kind, top.leaf), ("#50", "plane", 4));
    assert!((top.area.unwrap() - PI * 0.02 * 0.02).abs() < 1e-9, "{:?}", top.area);
}

#[test]
fn parts_have_areas_and_volumes_in_closed_form() {
    let (_, model) = discs();
    let of = |leaves: std::ops::Range<u32>| model.measures_of(&leaves.collect());
    let (radius, height) = (0.02, 0.01);
    let (area, volume) = (2.0 * PI * radius * (radius + height), PI * radius * radius * height);
    for (leaves, copies) in [(0..3, 1.0), (3..6, 1.0), (0..6, 2.0)] {
        let measures = of(leaves.clone());
        let (found, inside) = (measures.area.unwrap(), measures.volume.unwrap());
        assert!((found / (copies * area) - 1.0).abs() < 1e-7, "{leaves:?}: {found}");
        assert!((inside / (copies * volume) - 1.0).abs() < 1e-7, "{leaves:?}: {inside}");
    }
    // Without its bottom a disc bounds no volume.
    let open = of(0..2);
    assert!(open.volume.is_none() && open.area.is_some_and(|found| found < area), "{open:?}");
    // As many faces as a disc has, of two.
    let mixed = model.measures_of(&BTreeSet::from([0, 1, 3]));
    assert!(mixed.volume.is_none() && mixed.faces == 3, "{mixed:?}");
}
