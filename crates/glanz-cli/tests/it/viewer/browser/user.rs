//! Use of the page: loading, turning, picking, waiting for the rendered picture, moving, saving.

use std::path::Path;
use std::process::Command;

use glanz::formats::image;
use glanz::light::Pixels;
use serde_json::Value;

use super::page::Page;
use crate::viewer::server::{ViewServer, scene_file};
use crate::viewer::soak::process::children;

/// Size of the window in pixels; the bars of the page leave about 400 x 300 for the picture.
const SIZE: [u32; 2] = [400, 390];

/// Position of the middle of the canvas in the window.
fn middle(page: &mut Page) -> [f64; 2] {
    let place = page.evaluate(
        "(({ left, top, width, height }) => [left + width / 2, top + height / 2])
            (document.querySelector('canvas').getBoundingClientRect())",
    );
    [0, 1].map(|i| place[i].as_f64().expect("a number"))
}

fn camera(page: &mut Page) -> Value {
    page.evaluate("window.glanz.state().camera")
}

fn vector(value: &Value) -> [f64; 3] {
    [0, 1, 2].map(|i| value[i].as_f64().expect("a number"))
}

fn distance(a: &Value, b: &Value) -> f64 {
    let [a, b] = [a, b].map(vector);
    (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
}

fn picture(bytes: &[u8], name: &str) -> Pixels {
    image::read(bytes, Some(Path::new(name)), image::Encoding::Srgb).expect("a picture").pixels
}

/// Number of different pixels of two pictures; panics if their sizes differ.
fn changed(a: &[u8], b: &[u8]) -> usize {
    let [a, b] = [a, b].map(|bytes| picture(bytes, "a.png"));
    assert_eq!(a.len(), b.len());
    let [a, b] = [a, b].map(|picture| picture.to_rgb().expect("colours"));
    a.iter().zip(&b).filter(|(a, b)| a != b).count()
}

/// Waits until the picture of the current camera has this number of samples.
fn rendered(page: &mut Page, samples: u32) {
    page.until(
        "the picture is rendered",
        &format!("(window.glanz.renderStatus()?.samples ?? 0) >= {samples}"),
    );
}

#[test]
fn click_shows_the_properties_of_the_surface() {
    let served = ViewServer::start(&scene_file("teapot.pbrt"));
    let mut page = Page::open(&served.address(), SIZE);
    let [x, y] = middle(&mut page);
    page.click([x, y]);
    page.until("the properties are shown", "document.querySelector('#properties').textContent.trim() !== ''");
    let hit = page.evaluate("window.glanz.state().hit");
    let asked = "(({ clientWidth, clientHeight }) => window.glanz.pick(clientWidth / 2, clientHeight / 2))
        (document.querySelector('canvas'))";
    assert_eq!(page.evaluate(asked)["leaf"], hit["leaf"]);
    // The camera looks at the body of the teapot.
    assert_eq!(hit["degree"], serde_json::json!([3, 3]), "{hit}");
    let place = vector(&hit["point"]);
    assert!(place.iter().all(|c| c.abs() < 4.0), "{hit}");
    let normal = vector(&hit["normal"]).map(|c| c * c).iter().sum::<f64>();
    assert!((normal - 1.0).abs() < 1e-6, "{hit}");
    assert!(hit["curvature"]["radius"].as_f64().is_some_and(|r| (0.1..10.0).contains(&r)), "{hit}");
    let words = page.evaluate("document.querySelector('#properties').textContent");
    println!("properties: {words}");
    assert_eq!(page.faults(), [""; 0]);
}

#[test]
fn chosen_files_are_opened() {
    let served = ViewServer::start(&scene_file("teapot.pbrt"));
    let mut page = Page::open(&served.address(), SIZE);
    page.evaluate(
        "const chosen = new DataTransfer();
         chosen.items.add(new File(['WorldBegin\\nInclude \"\u{e4} b.pbrt\"\\n'], 'own.pbrt'));
         chosen.items.add(new File(['Shape \"sphere\"\\n'], '\u{e4} b.pbrt'));
         chosen.items.add(new File(['two lines'], 'unused\\n.txt'));
         const input = document.querySelector('#files');
         input.files = chosen.files;
         input.dispatchEvent(new Event('change'));",
    );
    page.until("the scene is shown", "document.title.includes('own.pbrt')");
    rendered(&mut page, 1);
    assert_eq!(page.faults(), [""; 0]);
    // The page learns that the process of its scene has ended, and keeps the drawing.
    for process in children(served.id()) {
        assert!(Command::new("kill").args(["-9", &process.to_string()]).status().is_ok_and(|s| s.success()));
    }
    let text = "document.querySelector('#problem-text').textContent";
    page.until("the reason is shown", &format!("{text}.includes('stopped unexpectedly')"));
    assert!(page.evaluate("document.title").as_str().is_some_and(|title| title.starts_with("own.pbrt")));
}

#[test]
fn hidden_page_renders_nothing_until_it_is_shown() {
    let served = ViewServer::start(&scene_file("teapot.pbrt"));
    let mut page = Page::open(&served.address(), SIZE);
    rendered(&mut page, 1);
    let hide = |hidden: bool| {
        format!(
            "Object.defineProperty(document, 'hidden', {{ value: {hidden}, configurable: true }});
             document.dispatchEvent(new Event('visibilitychange'));"
        )
    };
    let samples = |page: &mut Page| page.evaluate("window.glanz.renderStatus().samples").as_u64();
    page.evaluate(&hide(true));
    // The pass under way ends; on a busy machine that takes longer.
    let mut before = samples(&mut page);
    let is_paused = (0..20).any(|_| {
        page.rest(1500);
        let now = samples(&mut page);
        std::mem::replace(&mut before, now) == now
    });
    assert!(is_paused && before > Some(0), "{before:?} samples");
    page.evaluate(&hide(false));
    rendered(&mut page, before.and_then(|samples| u32::try_from(samples).ok()).map_or(u32::MAX, |n| n + 1));
    assert_eq!(page.faults(), [""; 0]);
}

#[test]
fn switch_is_disabled_with_the_reason_where_the_denoiser_is_missing() {
    let nowhere = Path::new("/nowhere");
    let served = ViewServer::start_with(&scene_file("teapot.pbrt"), &[("OIDN_DIR", nowhere)]);
    let mut page = Page::open(&served.address(), SIZE);
    let switch = "document.querySelector('#denoise')";
    assert_eq!(
        page.evaluate(&format!("[{switch}.disabled, {switch}.checked]")),
        serde_json::json!([true, false])
    );
    let reason = page.evaluate("document.querySelector('#no-denoiser').textContent");
    assert!(reason.as_str().is_some_and(|text| text.contains("OIDN_DIR")), "{reason}");
    assert_eq!(page.evaluate("document.querySelector('#denoise-row').hidden"), false);
    assert_eq!(page.faults(), [""; 0]);
}

/// Tests of the nightly run.
mod heavy {
    use super::*;

    #[test]
    fn mouse_wheel_keys_and_fingers_move_the_camera_and_the_picture() {
        let served = ViewServer::start(&scene_file("teapot.pbrt"));
        let mut page = Page::open(&served.address(), SIZE);
        let [x, y] = middle(&mut page);
        let home = camera(&mut page);
        let first = page.screenshot();

        page.drag(&[[x, y], [x + 20.0, y], [x + 40.0, y + 10.0], [x + 60.0, y + 20.0]]);
        page.rest(300);
        let turned = camera(&mut page);
        assert!(distance(&home["position"], &turned["position"]) > 0.5, "{home} {turned}");
        let second = page.screenshot();
        assert!(changed(&first, &second) > 1000, "the camera turns, the picture does not");

        page.wheel([x, y], -240.0);
        page.rest(300);
        let near = camera(&mut page);
        let way = |camera: &Value| camera["distance"].as_f64().expect("a number");
        assert!(distance(&turned["position"], &near["position"]) > 0.1, "{turned} {near}");
        assert!(way(&near) < way(&turned), "the wheel goes the wrong way: {turned} {near}");

        page.evaluate("document.querySelector('canvas').focus()");
        page.key("ArrowLeft");
        page.rest(300);
        let by_key = camera(&mut page);
        assert!(distance(&near["position"], &by_key["position"]) > 0.01, "{near} {by_key}");

        page.touch(&[vec![[x, y]], vec![[x + 30.0, y]], vec![[x + 60.0, y]]]);
        page.rest(300);
        let by_finger = camera(&mut page);
        assert!(distance(&by_key["position"], &by_finger["position"]) > 0.1, "{by_key} {by_finger}");
        assert_eq!(page.faults(), [""; 0]);
    }

    #[test]
    fn the_rendered_picture_comes_while_the_camera_rests_and_is_saved() {
        let served = ViewServer::start(&scene_file("teapot.pbrt"));
        let mut page = Page::open(&served.address(), SIZE);
        let [x, y] = middle(&mut page);
        rendered(&mut page, 1);
        let status = page.evaluate("window.glanz.renderStatus()");
        println!("rendered: {status}");

        // Moving the camera stops the rendering, and it starts again with the new camera.
        page.drag(&[[x, y], [x + 20.0, y], [x + 40.0, y]]);
        page.until("rendering stops", "typeof window.glanz.latency === 'number'");
        println!("milliseconds until rendering has stopped: {}", page.evaluate("window.glanz.latency"));
        rendered(&mut page, 2);

        let size = page
            .evaluate("[document.querySelector('canvas').width, document.querySelector('canvas').height]");
        let size = [0, 1].map(|i| size[i].as_u64().expect("a size") as u32);
        for (command, extension, magic) in
            [("savePng", "png", &b"\x89PNG"[..]), ("saveExr", "exr", &[0x76, 0x2f, 0x31, 0x01])]
        {
            let button = format!("document.querySelector('[data-command={command}]')");
            page.until("there is something to save", &format!("!{button}.disabled"));
            let (name, bytes) = page.saved(|page| {
                page.evaluate(&format!("{button}.click()"));
            });
            assert!(name.ends_with(extension), "{name}");
            assert!(bytes.starts_with(magic), "{name}: {:x?}", bytes.get(..8));
            let saved = picture(&bytes, &name);
            assert_eq!([saved.width(), saved.height()], size, "{name}");
            let colours = saved.to_rgb().expect("colours");
            let mean = colours.as_flattened().iter().sum::<f32>() / (3 * colours.len()) as f32;
            println!("{name}: {} x {} pixels, {} bytes, mean {mean}", size[0], size[1], bytes.len());
            assert!((0.01..10.0).contains(&mean), "{name} is {mean} on average");
        }
        assert_eq!(page.faults(), [""; 0]);
    }
    /// Needs the library, see `glanz_denoise::DIRECTORY_VARIABLE`.
    #[test]
    fn switch_shows_the_picture_without_noise_until_the_camera_moves() {
        let served = ViewServer::start(&scene_file("teapot.pbrt"));
        let mut page = Page::open(&served.address(), SIZE);
        rendered(&mut page, 1);
        assert!(page.evaluate("window.glanz.renderStatus().denoised").is_null());
        page.evaluate("document.querySelector('#denoise').click()");
        let is_shown = "(window.glanz.renderStatus()?.denoised ?? 0) >= 1";
        page.until("the picture is denoised", is_shown);
        page.until(
            "that is reported",
            "document.querySelector('#renderer').textContent.includes('denoised at')",
        );
        let (name, _) = page.saved(|page| {
            page.evaluate("document.querySelector('[data-command=savePng]').click()");
        });
        assert_eq!(name, "teapot.denoised.png");
        let [x, y] = middle(&mut page);
        page.drag(&[[x, y], [x + 20.0, y], [x + 40.0, y]]);
        page.until("rendering stops", "typeof window.glanz.latency === 'number'");
        println!("milliseconds until rendering has stopped: {}", page.evaluate("window.glanz.latency"));
        page.until("the picture of the new camera is denoised", is_shown);
        page.evaluate("document.querySelector('#denoise').click()");
        rendered(&mut page, 2);
        assert!(page.evaluate("window.glanz.renderStatus().denoised").is_null());
        assert_eq!(page.faults(), [""; 0]);
    }
}
