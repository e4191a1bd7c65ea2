//! Lights of scene files by their illuminance, and lux of a receiver.

use std::path::Path;

use glanz::formats::Options;
use glanz::illumination::planning::{LightingTask, MaintenanceFactor, PlanningRequest, PlanningSettings};
use glanz::illumination::{GridResolution, LuxMap};
use glanz::{Error, IlluminateMethod, IlluminateOptions, LoadedScene, Warning};

/// A black square of 1 m x 1 m about the origin that faces up, and a light.
fn scene(light: &str) -> LoadedScene {
    let text = format!(
        "Film \"rgb\" WorldBegin LightSource {light} Material \"diffuse\" \"rgb reflectance\" [0 0 0]
         Shape \"bilinearmesh\" \"point3 P\" [-.5 -.5 0 .5 -.5 0 -.5 .5 0 .5 .5 0] \"string receiver\" \"floor\""
    );
    let folder = Some(env!("CARGO_TARGET_TMPDIR").into());
    glanz::open_str("floor.pbrt", &text, &Options { folder, ..Options::default() }).unwrap()
}

/// The map of the receiver, which is one cell.
fn floor(light: &str, method: IlluminateMethod) -> LuxMap {
    let resolution = GridResolution::Longer(1);
    let options = IlluminateOptions { resolution, method, ..IlluminateOptions::default() };
    let builder = scene(light).illuminate().options(options).particles(1 << 17);
    builder.run().unwrap().report.maps.remove(0)
}

/// Fails unless particles give the floor this illuminance, lx, within four standard errors of at most 1 %.
fn assert_lux(light: &str, expected: f64) {
    let map = floor(light, IlluminateMethod::Trace);
    let (lux, error) = (map.lux[0], map.errors[0]);
    assert!(
        (lux - expected).abs() <= 4.0 * error + 1e-4 * expected,
        "{light}: {lux} +- {error}, not {expected}"
    );
    assert!(error <= 0.01 * expected, "{light}: {lux} +- {error}");
}

const DOWN: &str = "\"point3 from\" [0 0 1] \"point3 to\" [0 0 0]";

#[test]
fn light_of_ten_thousand_lux_from_one_direction_gives_them_to_a_floor_that_faces_it() {
    for (parameters, expected) in [
        ("", 10_000.0),
        // The magnitude of the colour is replaced, `scale` is a factor.
        ("\"rgb L\" [3 1 7]", 10_000.0),
        ("\"blackbody L\" 3000 \"float scale\" .25", 2500.0),
    ] {
        let light = format!("\"distant\" {DOWN} \"float illuminance\" 10000 {parameters}");
        let lux = floor(&light, IlluminateMethod::Integrate).lux[0];
        assert!((lux / expected - 1.0).abs() < 1e-5, "{light}: {lux}");
        assert_lux(&light, expected);
        // A disk on the sky around this direction.
        assert_lux(&format!("{light} \"float angle\" 20"), expected);
    }
    let slanted = "\"distant\" \"point3 from\" [3 0 4] \"point3 to\" [0 0 0] \"float illuminance\" 10000";
    assert_lux(slanted, 8000.0);
}

#[test]
fn light_of_ten_thousand_lux_from_everywhere_gives_them_to_a_horizontal_floor() {
    assert_lux("\"infinite\" \"float illuminance\" 10000", 10_000.0);
    assert_lux("\"infinite\" \"float illuminance\" 10000 \"rgb L\" [3 1 7] \"float scale\" 2", 20_000.0);
}

#[test]
fn portal_lets_its_part_of_the_illuminance_pass() {
    // Opposed squares at the distance of their sides exchange 0.199825 of their light (@howell2011).
    let portal = "\"point3 portal\" [-.5 -.5 1  -.5 .5 1  .5 .5 1  .5 -.5 1]";
    assert_lux(&format!("\"infinite\" \"float illuminance\" 10000 {portal}"), 1998.25);
}

#[test]
fn picture_of_ten_thousand_lux_gives_them_to_a_surface_that_faces_its_z_axis() {
    // A small picture, and a large one: an upper half of a colour that fades to the right, over a lower half that a floor sees at the horizon alone. The
    // last row of the file is the top one.
    for [columns, rows] in [[8, 4], [512_u16, 256]] {
        let mut file = format!("PF\n{columns} {rows}\n-1\n").into_bytes();
        for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
            let upper = [1.0_f32, 2.0, 4.0].map(|x| x * f32::from(columns - column));
            let pixel = if 2 * row < rows { [9.0; 3] } else { upper };
            file.extend(pixel.iter().flat_map(|x| x.to_le_bytes()));
        }
        std::fs::write(Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("sky-{rows}.pfm")), file).unwrap();
        let name = format!("\"string filename\" \"sky-{rows}.pfm\"");
        let sky = format!("\"infinite\" {name} \"rgb L\" [1 3 2] \"float illuminance\" 10000");
        assert_lux(&sky, 10_000.0);
        assert_lux(&format!("{sky} \"float scale\" .5"), 5000.0);
    }
}

#[test]
fn light_of_the_sky_alone_is_not_judged() {
    let by_day = || {
        let options = IlluminateOptions { daylight: true, ..IlluminateOptions::default() };
        scene("\"distant\" \"float illuminance\" 1").illuminate().options(options).particles(100)
    };
    assert!(by_day().planning(PlanningSettings::default()).run().is_ok());
    let task = LightingTask::of_reference("34.2");
    assert!(task.is_some());
    for refused in [
        by_day().plan(PlanningRequest::default()),
        by_day().planning(PlanningSettings { task, ..PlanningSettings::default() }),
        by_day().planning(PlanningSettings {
            maintenance: MaintenanceFactor::Whole(0.8),
            ..PlanningSettings::default()
        }),
    ] {
        assert!(matches!(refused.run(), Err(Error::DaylightRating)));
    }
}

#[test]
fn light_of_a_lamp_that_leaves_the_scene_is_named_with_its_share() {
    let escaped = |light: &str, room: Option<[f64; 3]>, particles: Option<u64>| {
        let (room, resolution) = (room.map(Into::into), GridResolution::Longer(1));
        let options = IlluminateOptions { room, resolution, ..IlluminateOptions::default() };
        let builder = scene(light).illuminate().options(options);
        let outcome = match particles {
            Some(count) => builder.particles(count).run().unwrap(),
            None => builder.relative_error(0.05).run().unwrap(),
        };
        let shares = outcome.warnings.iter().filter_map(|warning| match warning {
            Warning::EscapedFlux { share, .. } => Some(*share),
            _ => None,
        });
        shares.collect::<Vec<_>>()
    };
    let lamp = "\"point\" \"point3 from\" [0 0 1] \"float power\" 100";
    // The square has the solid angle 4 atan(a b / (d sqrt(a^2 + b^2 + d^2))) of the 4 pi.
    let met = (0.25 / 1.5_f64.sqrt()).atan() / std::f64::consts::PI;
    let count = Some(1 << 16);
    // Without a number of particles, the best method for each part of the light, with as many of them at least.
    for particles in [count, None] {
        let [share] = escaped(lamp, None, particles)[..] else { panic!("one warning") };
        assert!((share - (1.0 - met)).abs() < 4e-3, "{share}, not {}", 1.0 - met);
    }
    let inside = "\"point\" \"point3 from\" [1 1 1] \"float power\" 100";
    assert!(escaped(inside, Some([2.0; 3]), count).is_empty());
    // Of daylight, most passes by.
    assert!(escaped("\"infinite\" \"float illuminance\" 100", None, count).is_empty());
}
