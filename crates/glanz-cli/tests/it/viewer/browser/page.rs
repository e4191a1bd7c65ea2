//! A page in the browser: evaluation of expressions, input events, screenshots and console messages.

use std::path::Path;
use std::time::{Duration, Instant};

use data_encoding::BASE64;
use serde_json::{Value, json};

use super::process::Browser;

/// Time limit for a condition.
const PATIENCE: Duration = Duration::from_secs(120);

/// A page of the viewer.
pub(crate) struct Page {
    browser: Browser,
    session: String,
}

impl Page {
    /// Opens an address in a window of this size in pixels, and waits until the page has drawn its first picture.
    pub(crate) fn open(address: &str, size: [u32; 2]) -> Self {
        let mut page = Self::navigate(address, size);
        page.until("the page's scripts run", "typeof window.glanz === 'object'");
        page.evaluate("window.glanz.ready.then(() => true)");
        page
    }

    /// Opens a file without scripts in a window of this size in pixels.
    pub(crate) fn document(path: &Path, size: [u32; 2]) -> Self {
        let mut page = Self::navigate(&format!("file://{}", path.display()), size);
        page.until(
            "the document is there",
            "document.readyState === 'complete' && location.protocol === 'file:'",
        );
        page
    }

    fn navigate(address: &str, size: [u32; 2]) -> Self {
        let mut browser = Browser::start();
        let target = browser.devtools.call(None, "Target.createTarget", json!({ "url": "about:blank" }));
        let attach = json!({ "targetId": target["targetId"], "flatten": true });
        let session = browser.devtools.call(None, "Target.attachToTarget", attach);
        let session = session["sessionId"].as_str().expect("a session").to_owned();
        let mut page = Self { browser, session };
        for domain in ["Page", "Runtime", "Log", "Network"] {
            page.call(&format!("{domain}.enable"), json!({}));
        }
        let [width, height] = size;
        let screen = json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": false });
        page.call("Emulation.setDeviceMetricsOverride", screen);
        // Animations would make the pictures depend on the time.
        let still = json!({ "features": [{ "name": "prefers-reduced-motion", "value": "reduce" }] });
        page.call("Emulation.setEmulatedMedia", still);
        page.call("Page.navigate", json!({ "url": address }));
        page
    }

    /// The value of an expression; a promise is awaited.
    pub(crate) fn evaluate(&mut self, expression: &str) -> Value {
        let ask = json!({ "expression": expression, "awaitPromise": true, "returnByValue": true });
        let mut answer = self.call("Runtime.evaluate", ask);
        if let Some(fault) = answer.get("exceptionDetails") {
            panic!("{expression}: {}\n{}", fault["exception"]["description"], self.console().join("\n"));
        }
        answer["result"]["value"].take()
    }

    /// The bytes of an expression whose value is a promise of a typed array.
    pub(crate) fn bytes(&mut self, expression: &str) -> Vec<u8> {
        let encode = "const bytes = new Uint8Array(array.buffer, array.byteOffset, array.byteLength);
            let text = '';
            for (let i = 0; i < bytes.length; i += 32768) text += String.fromCharCode(...bytes.subarray(i, i + 32768));
            return btoa(text);";
        let text =
            self.evaluate(&format!("(async () => {{ const array = await ({expression}); {encode} }})()"));
        BASE64.decode(text.as_str().expect("text").as_bytes()).expect("base 64")
    }

    /// Waits until an expression is true.
    pub(crate) fn until(&mut self, what: &str, expression: &str) {
        let start = Instant::now();
        while self.evaluate(expression) != true {
            assert!(start.elapsed() < PATIENCE, "waited for nothing: {what}\n{}", self.console().join("\n"));
            self.rest(20);
        }
    }

    /// Waits for a number of milliseconds.
    pub(crate) fn rest(&mut self, milliseconds: u64) {
        self.browser.devtools.wait(Duration::from_millis(milliseconds));
    }

    /// Presses the left button, moves along positions in the window, and releases it.
    pub(crate) fn drag(&mut self, places: &[[f64; 2]]) {
        let (Some(first), Some(last)) = (places.first(), places.last()) else { return };
        self.mouse("mouseMoved", *first, 0);
        self.mouse("mousePressed", *first, 1);
        for place in places.iter().skip(1) {
            self.mouse("mouseMoved", *place, 1);
        }
        self.mouse("mouseReleased", *last, 0);
    }

    /// Clicks at a position in the window.
    pub(crate) fn click(&mut self, place: [f64; 2]) {
        self.drag(&[place]);
    }

    fn mouse(&mut self, kind: &str, [x, y]: [f64; 2], buttons: u32) {
        let button = if kind == "mouseMoved" && buttons == 0 { "none" } else { "left" };
        let event =
            json!({ "type": kind, "x": x, "y": y, "button": button, "buttons": buttons, "clickCount": 1 });
        self.call("Input.dispatchMouseEvent", event);
    }

    /// Moves the pointer to a position in the window.
    pub(crate) fn hover(&mut self, place: [f64; 2]) {
        self.mouse("mouseMoved", place, 0);
    }

    /// Turns the wheel at a position; `delta`: positive towards the user.
    pub(crate) fn wheel(&mut self, [x, y]: [f64; 2], delta: f64) {
        let event = json!({ "type": "mouseWheel", "x": x, "y": y, "deltaX": 0, "deltaY": delta });
        self.call("Input.dispatchMouseEvent", event);
    }

    /// Presses and releases a key, by its name in scripts (`a`, `ArrowLeft`).
    pub(crate) fn key(&mut self, name: &str) {
        let text = if name.chars().count() == 1 { name } else { "" };
        for kind in ["keyDown", "keyUp"] {
            let text = if kind == "keyDown" { text } else { "" };
            self.call("Input.dispatchKeyEvent", json!({ "type": kind, "key": name, "text": text }));
        }
    }

    /// A touch gesture: each element holds the positions of all fingers at one time.
    pub(crate) fn touch(&mut self, moments: &[Vec<[f64; 2]>]) {
        for (i, fingers) in moments.iter().enumerate() {
            let kind = if i == 0 { "touchStart" } else { "touchMove" };
            let points: Vec<Value> =
                fingers.iter().enumerate().map(|(id, [x, y])| json!({ "x": x, "y": y, "id": id })).collect();
            self.call("Input.dispatchTouchEvent", json!({ "type": kind, "touchPoints": points }));
        }
        self.call("Input.dispatchTouchEvent", json!({ "type": "touchEnd", "touchPoints": [] }));
    }

    /// Opens a file as if it were chosen, and returns the seconds until its first picture is drawn, and until the graphics card, here a program, has done so.
    pub(crate) fn open_file(&mut self, name: &str, bytes: &[u8]) -> [f64; 2] {
        let (content, quoted) = (BASE64.encode(bytes), json!(name).to_string());
        let open = format!(
            "(async () => {{
                const bytes = Uint8Array.from(atob('{content}'), (c) => c.charCodeAt(0));
                const chosen = new DataTransfer();
                chosen.items.add(new File([bytes], {quoted}));
                const input = document.querySelector('#files');
                const start = performance.now();
                input.files = chosen.files;
                input.dispatchEvent(new Event('change'));
                const isDrawn = () => {{
                    const {{ scene, frame }} = window.glanz.state();
                    // A rendered image that covers all may come before the last program for drawing.
                    const isWhole = frame?.pending === 0 || window.glanz.renderStatus()?.covered;
                    return scene === {quoted} && document.title.startsWith({quoted}) && isWhole;
                }};
                while (!isDrawn()) {{
                    if (document.querySelector('#problem').open) return document.querySelector('#problem-text').textContent;
                    await new Promise((resolve) => setTimeout(resolve, 5));
                }}
                const drawn = performance.now() - start;
                const gl = document.querySelector('#view').getContext('webgl2');
                const done = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
                gl.flush();
                // Without blocking the page, whose connection would be given up.
                while (gl.clientWaitSync(done, 0, 0) === gl.TIMEOUT_EXPIRED) await new Promise((resolve) => setTimeout(resolve, 5));
                return [drawn / 1000, (performance.now() - start) / 1000];
            }})()"
        );
        let seconds = self.evaluate(&open);
        [0, 1].map(|i| seconds[i].as_f64().unwrap_or_else(|| panic!("{name}: {seconds}")))
    }

    /// A screenshot of the window as PNG.
    pub(crate) fn screenshot(&mut self) -> Vec<u8> {
        let picture = self.call("Page.captureScreenshot", json!({ "format": "png" }));
        BASE64.decode(picture["data"].as_str().expect("text").as_bytes()).expect("base 64")
    }

    /// Name and bytes of the file that the page saves after `action`.
    pub(crate) fn saved(&mut self, action: impl FnOnce(&mut Self)) -> (String, Vec<u8>) {
        let folder = self.browser.downloads();
        std::fs::create_dir_all(&folder).expect("a folder");
        let allow = json!({ "behavior": "allow", "downloadPath": folder.display().to_string(), "eventsEnabled": true });
        self.browser.devtools.call(None, "Browser.setDownloadBehavior", allow);
        let before = self.browser.devtools.events().len();
        action(self);
        let start = Instant::now();
        loop {
            assert!(start.elapsed() < PATIENCE, "nothing is saved\n{}", self.console().join("\n"));
            self.rest(20);
            let events = self.browser.devtools.events().get(before..).unwrap_or_default();
            let is_done = |event: &Value| event["params"]["state"] == "completed";
            let name = |event: &Value| event["params"]["suggestedFilename"].as_str().map(str::to_owned);
            // No other event has these fields.
            if let (true, Some(name)) = (events.iter().any(is_done), events.iter().find_map(name)) {
                let bytes = std::fs::read(folder.join(&name)).expect("the saved file");
                return (name, bytes);
            }
        }
    }

    /// All console messages, uncaught exceptions and log entries of the page.
    pub(crate) fn console(&self) -> Vec<String> {
        let own = self.browser.devtools.events().iter().filter(|event| event["sessionId"] == *self.session);
        own.filter_map(|event| {
            let parameters = &event["params"];
            match event["method"].as_str()? {
                "Runtime.consoleAPICalled" => {
                    let words: Vec<String> = parameters["args"].as_array()?.iter().map(said).collect();
                    Some(format!("{}: {}", parameters["type"].as_str()?, words.join(" ")))
                }
                "Runtime.exceptionThrown" => {
                    let fault = &parameters["exceptionDetails"];
                    Some(format!("error: {} {}", fault["text"], fault["exception"]["description"]))
                }
                "Log.entryAdded" => {
                    let entry = &parameters["entry"];
                    Some(format!("{}: {} {}", entry["level"].as_str()?, entry["text"], entry["url"]))
                }
                _ => None,
            }
        })
        .collect()
    }

    /// The errors and failed assertions among the console messages.
    pub(crate) fn faults(&self) -> Vec<String> {
        let mut faults = self.console();
        faults.retain(|line| line.starts_with("error") || line.starts_with("assert"));
        faults
    }

    pub(super) fn call(&mut self, method: &str, parameters: Value) -> Value {
        let session = self.session.clone();
        self.browser.devtools.call(Some(&session), method, parameters)
    }
}

/// An argument of a console message.
fn said(argument: &Value) -> String {
    match (&argument["value"], &argument["description"]) {
        (Value::String(text), _) | (Value::Null, Value::String(text)) => text.clone(),
        (value, _) => value.to_string(),
    }
}
