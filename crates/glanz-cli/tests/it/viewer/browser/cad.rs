//! STEP files that are opened on the page: drawn where rays meet them, without gaps between faces.
//!
//! `GLANZ_CAD_FILES` adds files (paths separated by colons), and `GLANZ_CAD_SECONDS` sets the time limit of their first pictures;
//! `cargo xtask cad` allows 3 seconds.

use std::path::{Path, PathBuf};

use super::page::Page;
use super::surfaces::compare_drawn;
use crate::viewer::server::{ViewServer, scene_file};

/// Size of the window in pixels; the bars of the page leave about 400 x 300 for the picture.
const SIZE: [u32; 2] = [400, 390];

/// Two discs of radius 20 mm and height 10 mm.
const DISCS: &str = "discs.step";

/// The same with roundings of 2 mm, tori whose patches end at the edges, and one disc behind the other.
const ROUNDED: &str = "rounded_discs.step";

/// Looks over the top of the nearer of these discs, by 5 degrees.
const OVER_TOP: &str = "(() => {
    const forward = normalize([-0.94, -0.33, -0.08]), right = normalize(cross(forward, [0, 0, 1]));
    const position = add([0.03, 0, 0.008], scale(forward, -model.camera.distance));
    return { ...model.camera, position, forward, right, up: cross(right, forward) };
})()";

/// A file of the viewer's tests.
fn sample(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../glanz-viewer/tests").join(name)
}

/// Name and bytes of a file.
fn file(path: &Path) -> (String, Vec<u8>) {
    let name = path.file_name().expect("a name").to_string_lossy().into_owned();
    (name, std::fs::read(path).unwrap_or_else(|error| panic!("{}: {error}", path.display())))
}

/// Statements of [`samples_of_background`].
const COUNT_SAMPLES: &str = "
    const { Renderer } = await import('/gl/renderer.js');
    const { decodeModel } = await import('/model.js');
    const urls = performance.getEntriesByType('resource').map(({ name }) => name);
    const model = decodeModel(await (await fetch(urls.filter((name) => name.includes('/model/')).at(-1))).arrayBuffer());
    const canvas = document.createElement('canvas');
    const renderer = new Renderer(canvas);
    renderer.setModel(model);
    const [width, height] = [1200, 900];
    const hidden = new Set(model.objects.filter(({ shared }) => !shared).map(({ leaf }) => leaf));
    const camera = CAMERA(model, await import('/linear.js'));
    const view = { camera, width, height, hidden, selected: null, exposure: 0, shading: 'normals',
        stripes: 16, curvature: 1, edges: false, isocurves: 0, net: false, section: null, maps: false, background: [0, 0, 0] };
    const drawn = (seams, shade) => {
        renderer.drawWhole({ ...view, seams, background: [shade, shade, shade] });
        const copy = document.createElement('canvas').getContext('2d');
        [copy.canvas.width, copy.canvas.height] = [width, height];
        copy.drawImage(canvas, 0, 0);
        return copy.getImageData(0, 0, width, height).data;
    };
    const { data: shown } = renderer.readNormals(view);
    const isShown = (at) => shown[4 * at + 3] > 0;
    const seen = new Set(shown.filter((_, at) => at % 4 === 3).map((number) => model.objects[number - 1]?.leaf ?? -1));
    for (const { leaf } of model.objects) if (!seen.has(leaf)) hidden.add(leaf);
    const sum = (seams) => {
        const [black, white] = [0, 1].map((shade) => drawn(seams, shade));
        let share = 0;
        for (let y = 1; y < height - 1; y++) {
            for (let x = 1; x < width - 1; x++) {
                let amid = true;
                for (let k = 0; k < 9; k++) amid &&= isShown((y + Math.floor(k / 3) - 1) * width + x + (k % 3) - 1);
                if (amid) share += (white[4 * (y * width + x)] - black[4 * (y * width + x)]) / 255;
            }
        }
        return share;
    };
    return [sum(true), sum(false)];
";

/// Draws the faces that are in sight of a camera, an expression, without those behind them and the ground, on black and on white, and counts the samples, in
/// pixels, that are of the background amid the model: with and without filled seams.
fn samples_of_background(page: &mut Page, camera: &str) -> [f64; 2] {
    let counts = page.evaluate(&format!(
        "(async () => {{
            const CAMERA = (model, {{ add, cross, normalize, scale }}) => {camera};
            {COUNT_SAMPLES}
        }})()"
    ));
    [0, 1].map(|i| counts[i].as_f64().expect("a number"))
}

#[test]
fn step_files_are_drawn_in_time_without_gaps_and_where_rays_meet_them() {
    let most: f64 = std::env::var("GLANZ_CAD_SECONDS").map_or(60.0, |text| text.parse().expect("a number"));
    let named = std::env::var("GLANZ_CAD_FILES").unwrap_or_default();
    let named: Vec<PathBuf> = named.split(':').filter(|path| !path.is_empty()).map(PathBuf::from).collect();
    if named.is_empty() {
        println!("no files in GLANZ_CAD_FILES: only discs are opened");
    }
    for path in [sample(DISCS), sample(ROUNDED)].into_iter().chain(named) {
        let served = ViewServer::start(&scene_file("teapot.pbrt"));
        let mut page = Page::open(&served.address(), SIZE);
        let (name, bytes) = file(&path);
        let [seconds, done] = page.open_file(&name, &bytes);
        println!(
            "{name}: first picture drawn after {seconds:.2} s, done by OpenGL in software after {done:.2} s"
        );
        assert!(seconds <= most, "{name} is slow: {seconds:.2} s, at most {most} s are allowed");
        let [filled, open] = samples_of_background(&mut page, "model.camera");
        println!("{name}: background through seams: {filled} pixels, {open} where they are not filled");
        assert_eq!(filled, 0.0, "{name} has gaps");
        compare_drawn(&mut page, &name, &path);
    }
}

#[test]
fn seams_of_faces_show_no_background() {
    for (name, camera) in [(DISCS, "model.camera"), (ROUNDED, "model.camera"), (ROUNDED, OVER_TOP)] {
        let served = ViewServer::start(&sample(name));
        let mut page = Page::open(&served.address(), SIZE);
        let [filled, open] = samples_of_background(&mut page, camera);
        println!("{name}: background through seams: {filled} pixels, {open} where they are not filled");
        assert!(open > 0.0, "nothing is to be filled between walls and tops");
        assert_eq!(filled, 0.0);
    }
}

#[test]
fn edges_are_picked_before_the_faces_beside_them() {
    let served = ViewServer::start(&sample(DISCS));
    let mut page = Page::open(&served.address(), SIZE);
    // The point of the top circle of the left disc that is nearest to the camera, in the window.
    let place = page.evaluate(
        "(async () => {
            const { project } = await import('/camera.js');
            const canvas = document.querySelector('canvas');
            const { camera } = window.glanz.state();
            const [x, y] = camera.position;
            const radius = 0.02 / Math.hypot(x, y);
            const size = { width: canvas.clientWidth, height: canvas.clientHeight };
            const at = project(camera, size, [x * radius, y * radius, 0.01]);
            const { left, top } = canvas.getBoundingClientRect();
            return [left + at.x, top + at.y];
        })()",
    );
    let [x, y] = [0, 1].map(|i| place[i].as_f64().expect("a number"));
    page.click([x + 1.0, y + 1.0]);
    page.until("an edge is selected", "window.glanz.state().edge !== null");
    let shown = page.evaluate("document.querySelector('#properties').textContent");
    let shown = shown.as_str().expect("text");
    for known in ["Circular edge", "125.664 mm", "20 mm", "360°", "90°", "wall, #50"] {
        assert!(shown.contains(known), "{known}: {shown}");
    }
    // Far from edges, the face is picked, with the volume of its part.
    page.click([x, y + 12.0]);
    page.until(
        "the part is measured",
        "document.querySelector('#properties').textContent.includes('Volume of disc')",
    );
    let shown = page.evaluate("document.querySelector('#properties').textContent");
    let shown = shown.as_str().expect("text");
    for known in ["#40", "cylinder", "20 mm", "12566.4 mm\u{b3}"] {
        assert!(shown.contains(known), "{known}: {shown}");
    }
    assert_eq!(page.faults(), [""; 0]);
}

#[test]
fn tiles_are_shown_under_edges_before_they_cover_the_view() {
    let served = ViewServer::start(&sample(DISCS));
    let mut page = Page::open(&served.address(), SIZE);
    // Green tiles over the left half of the view: the shares of green there, of ink there, and of what has changed on the right.
    let shares = page.evaluate(
        "(async () => {
            const { Renderer } = await import('/gl/renderer.js');
            const { TileImage } = await import('/rendered_image.js');
            const { decodeModel } = await import('/model.js');
            const urls = performance.getEntriesByType('resource').map(({ name }) => name);
            const model = decodeModel(await (await fetch(urls.filter((name) => name.includes('/model/')).at(-1))).arrayBuffer());
            const canvas = document.createElement('canvas');
            const renderer = new Renderer(canvas);
            renderer.setModel(model);
            const [width, height, half] = [800, 600, 400];
            const view = { camera: model.camera, width, height, hidden: new Set(), selected: null, exposure: 0, shading: 'normals', stripes: 16,
                curvature: 1, edges: true, edge: null, isocurves: 0, net: false, section: null, maps: false, seams: true, background: [1, 1, 1] };
            const shown = () => {
                const copy = document.createElement('canvas').getContext('2d');
                [copy.canvas.width, copy.canvas.height] = [width, height];
                copy.drawImage(canvas, 0, 0);
                return copy.getImageData(0, 0, width, height).data;
            };
            renderer.drawWhole(view);
            const before = shown();
            const image = new TileImage({ width, height });
            const pixels = new Uint16Array(3 * half * height).map((_, i) => (i % 3 === 1 ? 0x3c00 : 0));
            image.put({ x: 0, y: 0, width: half, height, pixels });
            renderer.drawWhole(view);
            renderer.drawRenderedImage(image, view);
            const after = shown();
            const count = [0, 0, 0];
            for (let at = 0; at < width * height; at++) {
                const [r, g, b] = after.subarray(4 * at, 4 * at + 3);
                if (at % width < half) {
                    if (g > 100 && r < 60 && b < 60) count[0]++;
                    else if (g < 100 && r < 60 && b < 60) count[1]++;
                } else if ([r, g, b].some((value, k) => Math.abs(value - before[4 * at + k]) > 64)) count[2]++;
            }
            return count.map((pixels) => pixels / (half * height));
        })()",
    );
    let [green, ink, changed] = [0, 1, 2].map(|i| shares[i].as_f64().expect("a number"));
    assert!(green > 0.9 && ink > 1e-4 && changed < 5e-3, "{green} {ink} {changed}");
    assert_eq!(page.faults(), [""; 0]);
}
