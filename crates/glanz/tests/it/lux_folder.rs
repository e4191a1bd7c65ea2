//! Lux maps that are read again, against the tables that were written with them.

use glanz::formats::Options;
use glanz::illumination::GridResolution;
use glanz::math::{DVec3, Ray};
use glanz::scene::{HitLocation, Scene};
use glanz::viewer::model::{LuxLookup, Model};
use glanz::viewer::server::SceneOverlay;
use glanz::{IlluminateMethod, IlluminateOptions, LightOverlay, LoadedScene, LuxFolder};

/// A floor of 4 m x 3 m with a wall that counts light on both of its sides, under a lamp.
fn scene() -> LoadedScene {
    let text = "Film \"rgb\" WorldBegin LightSource \"point\" \"point3 from\" [1 1 2]
        Material \"diffuse\" \"rgb reflectance\" [0 0 0]
        Shape \"bilinearmesh\" \"point3 P\" [0 0 0 4 0 0 0 3 0 4 3 0] \"string receiver\" \"floor\"
        Shape \"bilinearmesh\" \"point3 P\" [4 0 0 4 3 0 4 0 2 4 3 2] \"string receiver\" \"wall\" \"string receiverside\" \"both\"";
    let folder = Some(env!("CARGO_TARGET_TMPDIR").into());
    glanz::open_str("room.pbrt", text, &Options { folder, ..Options::default() }).unwrap()
}

/// The point of the scene before `position`, from `side` of it.
fn location(scene: &Scene, position: DVec3, side: DVec3) -> HitLocation {
    let (hit, place) = scene.intersect_parametric(&Ray::new(position + 0.1 * side, -side), 1.0).unwrap();
    HitLocation::new(&hit, place)
}

#[test]
fn readings_are_those_of_the_tables() {
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("lux-folder");
    let options = IlluminateOptions {
        resolution: GridResolution::Longer(8),
        method: IlluminateMethod::Integrate,
        ..IlluminateOptions::default()
    };
    scene().illuminate().options(options).run().unwrap().save(&folder).unwrap();
    let (scene, _) = scene().resolve().unwrap();
    let placed = LuxFolder::read(&folder).unwrap().place(&scene).unwrap();
    assert!(placed.is_two_sided());
    let report: serde_json::Value =
        serde_json::from_slice(&std::fs::read(folder.join("report.json")).unwrap()).unwrap();
    let mut cells = 0;
    for (number, (file, name, side)) in [
        ("floor", "floor", DVec3::Z),
        ("wall-front", "wall front", DVec3::X),
        ("wall-back", "wall back", -DVec3::X),
    ]
    .into_iter()
    .enumerate()
    {
        let table = std::fs::read_to_string(folder.join(format!("{file}.csv"))).unwrap();
        let summary = &report["receivers"][number];
        for line in table.lines().skip(1) {
            let row: Vec<f64> = line.split(',').map(|word| word.parse().unwrap()).collect();
            let at = location(&scene, DVec3::new(row[2], row[3], row[4]), side);
            let reading = placed.reading(&at).unwrap();
            assert_eq!((reading.receiver.as_str(), reading.cell.map(f64::from)), (name, [row[0], row[1]]));
            assert_eq!((reading.lux, reading.lux > 0.0), (f64::from(row[6] as f32), name != "wall front"));
            let error = f64::from(row[7] as f32);
            assert_eq!(reading.relative_error, (reading.lux > 0.0).then(|| error / reading.lux));
            assert_eq!(reading.mean, summary["mean_lux"].as_f64().unwrap());
            assert_eq!(
                [reading.minimum, reading.maximum],
                ["minimum_lux", "maximum_lux"].map(|key| summary[key].as_f64().unwrap())
            );
            // In the middle of a cell, its own value is the interpolated one.
            assert!((f64::from(placed.interpolated(&at).unwrap()) - reading.lux).abs() <= 1e-6 * reading.lux);
            cells += 1;
        }
    }
    assert_eq!((0..2).map(|surface| placed.cells_on(surface).len()).sum::<usize>(), cells);
    assert!(placed.cells_on(2).is_empty() && placed.is_on(1) && !placed.is_on(2));
    // The floor counts light from above only; from below, its reading is the same. Halfway between two cells, light is their mean.
    let [a, b] = [DVec3::new(1.25, 1.25, 0.0), DVec3::new(1.75, 1.25, 0.0)];
    let lux = |at: DVec3, side| placed.reading(&location(&scene, at, side)).unwrap().lux;
    assert_eq!(lux(a, DVec3::Z), lux(a, -DVec3::Z));
    let between = placed.interpolated(&location(&scene, 0.5 * (a + b), DVec3::Z)).unwrap();
    assert!(
        (f64::from(between) - 0.5 * (lux(a, DVec3::Z) + lux(b, DVec3::Z))).abs() < 1e-4 * lux(a, DVec3::Z)
    );
}

#[test]
fn a_single_bright_cell_is_drawn_as_bright_as_it_is() {
    // 64 x 64 cells of 62.5 mm; the lamp is 20 mm above the middle of one of them.
    let text = "Film \"rgb\" WorldBegin LightSource \"point\" \"point3 from\" [1.28125 0.96875 0.02]
        Material \"diffuse\" \"rgb reflectance\" [0 0 0]
        Shape \"bilinearmesh\" \"point3 P\" [0 0 0 4 0 0 0 4 0 4 4 0] \"string receiver\" \"floor\"
        Shape \"sphere\" \"float radius\" 0.1";
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("bright-cell");
    std::fs::create_dir_all(&folder).unwrap();
    let (scene, lux) = (folder.join("bright.pbrt"), folder.join("lux"));
    std::fs::write(&scene, text).unwrap();
    let options = IlluminateOptions {
        resolution: GridResolution::Longer(64),
        method: IlluminateMethod::Integrate,
        ..IlluminateOptions::default()
    };
    glanz::open(&scene).unwrap().illuminate().options(options).run().unwrap().save(&lux).unwrap();
    let report: serde_json::Value =
        serde_json::from_slice(&std::fs::read(lux.join("report.json")).unwrap()).unwrap();
    // The path has no name at its end.
    std::fs::create_dir_all(lux.join("inner")).unwrap();
    let overlay = LightOverlay::default().lux(lux.join("inner/..")).unwrap();
    let drawn = || {
        let loaded = glanz::formats::load(&scene, &Options::default()).unwrap();
        let (description, names) = (loaded.description, loaded.sources.names());
        let scene = Scene::resolve(description.clone()).unwrap().0;
        let model = Model::try_new("bright", &description, &scene, &names).unwrap();
        let bytes = overlay.add_maps(&scene, loaded.content_hash, model).unwrap().to_bytes().unwrap();
        let length = u32::from_le_bytes(bytes[8..12].try_into().unwrap()) as usize;
        serde_json::from_slice::<serde_json::Value>(&bytes[16..16 + length]).unwrap()
    };
    let head = drawn();
    let [largest, maximum] = [&head["maps"][0]["largest"], &report["receivers"][0]["maximum_lux"]];
    let [largest, maximum] = [largest, maximum].map(|number| number.as_f64().unwrap());
    assert!((largest / maximum - 1.0).abs() < 1e-6, "{largest} instead of {maximum}");
    assert_eq!(head["notes"].as_array().unwrap().len(), 0, "{}", head["notes"]);
    // The page is told of light that is not that of the scene.
    std::fs::write(&scene, text.replace("0.02]", "0.5]")).unwrap();
    let notes = drawn()["notes"].to_string();
    assert!(notes.contains("the lux maps in lux were computed for other content"), "{notes}");
    // New maps of the folder are not those that are drawn.
    glanz::open(&scene).unwrap().illuminate().options(options).run().unwrap().save(&lux).unwrap();
    assert_eq!(drawn()["notes"].to_string(), notes);
}
