//! Lux maps on the page, against their tables and closed forms.

use std::f64::consts::FRAC_PI_8;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use glanz::formats::image;
use glanz::light::Pixels;
use serde_json::{Value, json};

use super::page::Page;
use crate::command_line::support::Folder;
use crate::viewer::server::ViewServer;

/// Size of the window in pixels.
const SIZE: [u32; 2] = [1100, 700];

/// Height of the light over the floor, metres.
const HEIGHT: f64 = 2.0;

/// A black room of 4 m x 4 m x 2.5 m about the z axis with a light at its axis: the floor has lux E0 / (1 + (r / h)^2)^(3/2). The ceiling's normal points out of
/// the room, and a wall is a mesh. Nothing hides the floor from the light.
fn room(power: f64) -> String {
    format!(
        r#"LookAt 0 -1.5 1  0 0 0.5  0 0 1
        Camera "perspective" "float fov" 70
        Film "rgb" "integer xresolution" 400 "integer yresolution" 300
        WorldBegin
        LightSource "point" "point3 from" [0 0 {HEIGHT}] "float power" {power}
        Material "diffuse" "rgb reflectance" [0 0 0]
        Shape "bilinearmesh" "string receiver" "floor" "point3 P" [-2 -2 0  2 -2 0  -2 2 0  2 2 0]
        Shape "bilinearmesh" "point3 P" [-2 -2 2.5  2 -2 2.5  -2 2 2.5  2 2 2.5]
        Shape "bilinearmesh" "point3 P" [-2 -2 0  -2 2 0  -2 -2 2.5  -2 2 2.5]
        Shape "bilinearmesh" "point3 P" [2 2 0  2 -2 0  2 2 2.5  2 -2 2.5]
        Shape "bilinearmesh" "point3 P" [-2 2 0  2 2 0  -2 2 2.5  2 2 2.5]
        Shape "trianglemesh" "point3 P" [-2 -2 0  2 -2 0  2 -2 2.5  -2 -2 2.5] "integer indices" [0 2 1  0 3 2]"#
    )
}

/// A row of the table of the floor.
struct FloorCell {
    place: [f64; 2],
    area: f64,
    lux: f64,
}

/// Computes lux maps of rooms of the folder; returns where they are.
fn illuminate(folder: &Folder, scenes: &str) -> PathBuf {
    folder.succeed(&format!("illuminate {scenes} -o lux --cells 64 --method integrate --quiet"));
    folder.path("lux")
}

fn table(lux: &Path) -> Vec<FloorCell> {
    let text = std::fs::read_to_string(lux.join("floor.csv")).expect("a table");
    let row = |line: &str| {
        let row: Vec<f64> = line.split(',').map(|word| word.parse().expect("a number")).collect();
        FloorCell { place: [row[2], row[3]], area: row[5], lux: row[6] }
    };
    text.lines().skip(1).map(row).collect()
}

/// Cameras outside of the room.
const FROM_ABOVE: &str = "position: [0, 0, 9], right: [1, 0, 0], up: [0, 1, 0], forward: [0, 0, -1]";
const FROM_THE_FRONT: &str = "position: [0, -9, 1], right: [1, 0, 0], up: [0, 0, 1], forward: [0, 1, 0]";

/// Sets an orthographic camera with 100 pixels to the metre.
fn look(page: &mut Page, camera: &str) {
    page.evaluate(&format!(
        "(() => {{
            const {{ clientWidth, clientHeight }} = document.querySelector('#view');
            window.glanz.setCamera({{ kind: 'orthographic', {camera}, fieldOfView: 1, height: Math.min(clientWidth, clientHeight) / 100, distance: 9 }});
        }})()",
    ));
    drawn(page);
}

/// Waits until what was changed is drawn.
fn drawn(page: &mut Page) {
    page.until("the page draws", "window.glanz.state().frame?.pending === 0");
    page.evaluate(
        "new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(() => resolve(true))))",
    );
    page.rest(600);
}

/// Position in the window of a place of the floor, in one of the canvases.
fn on_floor(page: &mut Page, canvas: &str, [x, y]: [f64; 2]) -> [f64; 2] {
    let middle = page.evaluate(&format!(
        "(({{ left, top, width, height }}) => [left + width / 2, top + height / 2])(document.querySelector('{canvas}').getBoundingClientRect())"
    ));
    let [left, top] = [0, 1].map(|i| middle[i].as_f64().expect("a number"));
    [left + 100.0 * x, top - 100.0 * y]
}

fn picture(page: &mut Page) -> Pixels {
    image::read(&page.screenshot(), Some(Path::new("a.png")), image::Encoding::Srgb)
        .expect("a picture")
        .pixels
}

/// Red, green and blue of the screenshot at a position, linear.
fn colour(picture: &Pixels, [x, y]: [f64; 2]) -> [f32; 3] {
    let number = y as usize * picture.width() as usize + x as usize;
    picture.to_rgb().expect("colours")[number]
}

/// An illuminance of a table as the page shows it: four digits of the single-precision number.
fn shown(page: &mut Page, lux: f64) -> String {
    let number = page.evaluate(&format!("String(Number(({}).toPrecision(4)))", lux as f32));
    format!("{} lx", number.as_str().expect("a text"))
}

fn set(page: &mut Page, id: &str, value: &Value) {
    page.evaluate(&format!(
        "(() => {{
            const control = document.querySelector('#{id}');
            if (control.type === 'checkbox') control.checked = {value}; else control.value = {value};
            control.dispatchEvent(new Event('input', {{ bubbles: true }}));
        }})()"
    ));
}

#[test]
fn lux_maps_are_read_scaled_and_drawn_as_their_tables_say() {
    let folder = Folder::new();
    folder.write("room.pbrt", room(10.0));
    let lux = illuminate(&folder, "room.pbrt");
    let scene = folder.path("room.pbrt");
    let cells = table(&lux);
    let served = ViewServer::start_with_arguments(&scene, &["--lux".as_ref(), lux.as_os_str()], &[]);
    let mut page = Page::open(&served.address(), SIZE);
    look(&mut page, FROM_ABOVE);

    // The ceiling, seen from outside, is left out: what is picked is the floor below it, unless it is switched off.
    let settings = page.evaluate("window.glanz.state().settings");
    assert_eq!((&settings["seeThrough"], &settings["maps"]), (&json!(true), &json!(true)));
    let cell = cells.iter().find(|cell| cell.place[0] > 0.7 && cell.place[1] > -0.9).expect("a cell");
    let place = on_floor(&mut page, "#view", cell.place);
    page.click(place);
    page.until("something is picked", "window.glanz.state().hit !== null");
    let hit = page.evaluate("window.glanz.state().hit");
    page.key("Escape");
    assert_eq!(
        (hit["lux"]["receiver"].as_str(), hit["lux"]["lux"].as_f64().map(|lux| lux as f32)),
        (Some("floor"), Some(cell.lux as f32))
    );
    for (camera, axis, [near, far]) in [(FROM_ABOVE, 2, [2.5, 0.0]), (FROM_THE_FRONT, 1, [-2.0, 2.0])] {
        look(&mut page, camera);
        // In the middle: by the drawing, and by a ray.
        let middle = |page: &mut Page| {
            page.rest(300);
            let [drawn, hit] = [
                "(({ data, width, height }) => data[4 * (width * (height >> 1) + (width >> 1)) + 3] - 1)(window.glanz.normals())",
                "(({ clientWidth, clientHeight }) => window.glanz.pick(clientWidth / 2, clientHeight / 2))(document.querySelector('#view'))",
            ]
            .map(|what| page.evaluate(what));
            assert_eq!(drawn.as_f64(), hit["object"].as_f64(), "{hit}");
            hit["point"][axis].as_f64().expect("a number")
        };
        let open = middle(&mut page);
        page.key("w");
        let closed = middle(&mut page);
        page.key("w");
        assert!((open - far).abs() < 1e-9 && (closed - near).abs() < 1e-9, "{camera}: {open}, {closed}");
    }
    look(&mut page, FROM_ABOVE);

    // Under the cursor, and in the properties.
    page.hover(place);
    let expected = shown(&mut page, cell.lux);
    page.until("the illuminance is shown", "document.querySelector('#cursor').textContent.includes(' lx')");
    let cursor = page.evaluate("document.querySelector('#cursor').textContent");
    assert!(cursor.as_str().is_some_and(|text| text.starts_with(&expected)), "{cursor}, not {expected}");
    page.click(place);
    page.until(
        "the receiver is shown",
        "document.querySelector('#properties').textContent.includes('Receiver')",
    );
    let words = page.evaluate("document.querySelector('#properties').textContent");
    assert!(words.as_str().is_some_and(|text| text.contains(&expected) && text.contains("floor")), "{words}");
    page.key("Escape");

    // Percentiles of the area.
    set(&mut page, "lux-scale", &json!("percentile"));
    set(&mut page, "lux-tail", &json!("5"));
    let mut sorted: Vec<(f64, f64)> = cells.iter().map(|cell| (cell.lux, cell.area)).collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let whole: f64 = sorted.iter().map(|(_, area)| area).sum();
    let scale = page.evaluate("window.glanz.state().lux.scale");
    for (end, share) in [("low", 0.05), ("high", 0.95)] {
        let sums = sorted.iter().scan(0.0, |sum, (lux, area)| {
            *sum += area;
            Some((*sum, lux))
        });
        let expected = sums.skip_while(|(sum, _)| *sum < share * whole).map(|(_, lux)| lux).next();
        let (expected, found) = (expected.expect("a cell"), scale[end].as_f64().expect("a number"));
        // Cells of nearly equal illuminance may be in another order in single precision.
        assert!((found / expected - 1.0).abs() < 1e-4, "{end}: {found}, not {expected}");
    }
    set(&mut page, "lux-scale", &json!("linear"));

    // The line of the illuminance at 1 m from the axis is a circle of 100 pixels.
    let top = cells.iter().fold(0.0, |most: f64, cell| most.max(cell.lux));
    let nearest = 0.5_f64.hypot(0.5) * 4.0 / 64.0;
    let on_axis = top * (1.0 + (nearest / HEIGHT).powi(2)).powf(1.5);
    let level = on_axis / (1.0 + (1.0 / HEIGHT).powi(2)).powf(1.5);
    let without = picture(&mut page);
    set(&mut page, "isolux", &json!(true));
    set(&mut page, "isolux-levels", &json!(format!("{level:.6}")));
    drawn(&mut page);
    let with = picture(&mut page);
    let [x, y] = on_floor(&mut page, "#view", [0.0, 0.0]);
    let (plain, lined) = (without.to_rgb().expect("colours"), with.to_rgb().expect("colours"));
    for turn in 0..16 {
        let (sin, cos) = (0.1 + f64::from(turn) * FRAC_PI_8).sin_cos();
        let mut differing = Vec::new();
        for step in 0..400 {
            let radius = 0.6 + 0.002 * f64::from(step);
            let [x, y] = [x + 100.0 * radius * cos, y - 100.0 * radius * sin];
            let number = y as usize * with.width() as usize + x as usize;
            if plain[number] != lined[number] {
                differing.push(radius);
            }
        }
        let (first, last) = (differing.first().expect("a line"), differing.last().expect("a line"));
        // As wide as 2.5 pixels at most, and half a pixel on each side, along which a pixel has one colour.
        assert!(last - first < 0.045, "{turn}: {first} {last}");
        assert!((0.5 * (first + last) - 1.0).abs() < 0.01, "{turn}: {first} {last}");
    }
    let legend = page.evaluate("document.querySelector('#legend').textContent");
    assert!(legend.as_str().is_some_and(|text| text.contains("Lines: ")), "{legend}");
    set(&mut page, "isolux-levels", &json!("many"));
    let error = page.evaluate("document.querySelector('#isolux-error').textContent");
    assert!(error.as_str().is_some_and(|text| text.contains("\"many\" is no illuminance")), "{error}");
    assert_eq!(page.faults(), [""; 0]);
}

#[test]
fn two_designs_have_one_camera_and_one_scale_and_show_their_difference() {
    let folder = Folder::new();
    folder.write("a.pbrt", room(10.0));
    folder.write("b.pbrt", room(7.0));
    let lux = illuminate(&folder, "a.pbrt --compare b.pbrt");
    let [a, b] = ["a.pbrt", "b.pbrt"].map(|name| folder.path(name));
    let [first, second] = ["a", "b"].map(|name| table(&lux.join(name)));
    let arguments: [&OsStr; 4] = ["--compare".as_ref(), b.as_os_str(), "--lux".as_ref(), lux.as_os_str()];
    let served = ViewServer::start_with_arguments(&a, &arguments, &[]);
    let mut page = Page::open(&served.address(), SIZE);
    page.until("the second design is there", "window.glanz.state().second === 'b.pbrt'");
    look(&mut page, FROM_ABOVE);
    let heights =
        "['main', '#view', 'canvas.second'].map((name) => document.querySelector(name).clientHeight)";
    let heights = page.evaluate(heights);
    assert!(heights[0] == heights[1] && heights[0] == heights[2], "{heights}");
    // The brighter one decides the scale.
    let most = first.iter().fold(0.0, |most: f64, cell| most.max(cell.lux));
    assert_eq!(
        page.evaluate("Math.fround(window.glanz.state().lux.scale.high)").as_f64().map(|lux| lux as f32),
        Some(most as f32)
    );
    let number = first.iter().position(|cell| cell.place[0] > 0.3 && cell.place[1] > 0.2).expect("a cell");
    let (lux_a, lux_b) = (first[number].lux, second[number].lux);
    assert!((lux_b / lux_a - 0.7).abs() < 1e-4);
    let [text_a, text_b] = [lux_a, lux_b].map(|lux| shown(&mut page, lux));
    for canvas in ["#view", "canvas.second"] {
        let place = on_floor(&mut page, canvas, first[number].place);
        page.hover(place);
        page.until("both are shown", "document.querySelector('#cursor').textContent.includes('B − A')");
        let cursor = page.evaluate("document.querySelector('#cursor').textContent");
        let cursor = cursor.as_str().expect("a text");
        assert!(cursor.contains(&format!("A {text_a}")), "{cursor}, not {lux_a}");
        assert!(
            cursor.contains(&format!("B {text_b}")) && cursor.contains("(−30 %)"),
            "{cursor}, not {lux_b}"
        );
        page.hover([5.0, 5.0]);
        page.until("nothing is shown", "document.querySelector('#cursor').textContent === ''");
    }
    // The same colours mean the same: where the first has 0.7 of its largest value, the second, seen at the axis, has its own largest one.
    let shown = picture(&mut page);
    let radius = HEIGHT * (0.7_f64.powf(-2.0 / 3.0) - 1.0).sqrt();
    let places = [("#view", [0.0, 0.0]), ("#view", [radius, 0.0]), ("canvas.second", [0.0, 0.0])];
    let [brightest, left, right] = places.map(|(canvas, at)| {
        let place = on_floor(&mut page, canvas, at);
        colour(&shown, place)
    });
    let difference =
        |a: [f32; 3], b: [f32; 3]| a.iter().zip(b).fold(0.0, |most, (a, b)| (a - b).abs().max(most));
    assert!(difference(left, right) < 0.02, "{left:?} {right:?}");
    // Yellow and green: without maps, all would be black.
    assert!(difference(brightest, left) > 0.3, "{brightest:?} {left:?}");
    // A turn of the second turns the first.
    let before = page.evaluate("window.glanz.state().camera.right");
    let [x, y] = on_floor(&mut page, "canvas.second", [0.5, 0.5]);
    page.drag(&[[x, y], [x + 30.0, y + 30.0], [x + 60.0, y + 40.0]]);
    assert_ne!(page.evaluate("window.glanz.state().camera.right"), before);
    assert_eq!(page.faults(), [""; 0]);
}
