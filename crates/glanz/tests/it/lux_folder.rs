//! Lux maps that are read again, against the tables that were written with them.

use glanz::formats::Options;
use glanz::illumination::GridResolution;
use glanz::math::{DVec3, Ray};
use glanz::scene::{HitLocation, Scene};
use glanz::viewer::model::LuxLookup;
use glanz::{IlluminateMethod, IlluminateOptions, LoadedScene, LuxFolder};

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
            assert!((f64::from(placed.smooth(&at).unwrap()) - reading.lux).abs() <= 1e-6 * reading.lux);
            cells += 1;
        }
    }
    assert_eq!(placed.cells().len(), cells);
    // The floor counts light from above only; from below, its reading is the same. Halfway between two cells, light is their mean.
    let [a, b] = [DVec3::new(1.25, 1.25, 0.0), DVec3::new(1.75, 1.25, 0.0)];
    let lux = |at: DVec3, side| placed.reading(&location(&scene, at, side)).unwrap().lux;
    assert_eq!(lux(a, DVec3::Z), lux(a, -DVec3::Z));
    let between = placed.smooth(&location(&scene, 0.5 * (a + b), DVec3::Z)).unwrap();
    assert!(
        (f64::from(between) - 0.5 * (lux(a, DVec3::Z) + lux(b, DVec3::Z))).abs() < 1e-4 * lux(a, DVec3::Z)
    );
}
