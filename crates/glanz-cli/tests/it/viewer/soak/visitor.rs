//! A client that speaks the page's protocol without a browser.

use std::net::TcpStream;
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use tungstenite::client::IntoClientRequest;
use tungstenite::http::HeaderValue;
use tungstenite::protocol::WebSocketConfig;
use tungstenite::{Message, WebSocket, client::client_with_config};

use crate::viewer::http;
use crate::viewer::http::is_timeout;

/// The error message of a failed visit.
pub(crate) type Fault = String;

/// A connection that uses the protocol of the page.
pub(crate) struct Visitor {
    pub(crate) socket: WebSocket<TcpStream>,
    /// The camera of the scene.
    pub(crate) camera: Value,
    /// Identifier of the connection, required for uploads.
    pub(crate) session: String,
    id: u64,
    /// Number of tiles received.
    pub(crate) tiles: u64,
}

impl Visitor {
    /// Loads page and model, and connects.
    ///
    /// # Errors
    /// A response other than the expected one.
    pub(crate) fn try_new(host: &str) -> Result<Self, Fault> {
        for path in ["/", "/main.js"] {
            let answer = http::get(host, path).map_err(|error| format!("GET {path}: {error}"))?;
            if answer.status != 200 {
                return Err(format!("GET {path}: {}", answer.head));
            }
        }
        let mut visitor =
            Self { socket: connect(host)?, camera: Value::Null, session: String::new(), id: 0, tiles: 0 };
        let scene = visitor.await_text("a scene", |message| message["type"] == "scene")?;
        visitor.session = scene["session"].as_str().unwrap_or_default().to_owned();
        let path = scene["model"].as_str().ok_or_else(|| format!("no model: {scene}"))?;
        let model = http::get(host, path).map_err(|error| format!("GET {path}: {error}"))?;
        visitor.camera =
            camera(&model.body).ok_or_else(|| format!("GET {path}: no model: {}", model.head))?;
        Ok(visitor)
    }

    /// Starts rendering a view turned by an angle about the vertical axis; returns the number of the view.
    pub(crate) fn view(&mut self, size: [u32; 2], angle: f64) -> Result<u64, Fault> {
        let (sin, cos) = angle.sin_cos();
        let mut camera = self.camera.clone();
        for name in ["position", "right", "up", "forward"] {
            let [x, y, z] = [0, 1, 2].map(|i| camera[name][i].as_f64().unwrap_or(0.0));
            camera[name] = json!([cos * x - sin * y, sin * x + cos * y, z]);
        }
        self.request(
            json!({ "type": "view", "camera": camera, "size": size, "hidden": [], "integrator": "path" }),
        )
    }

    /// Stops rendering a view; returns the time until the server confirmed it.
    pub(crate) fn stop(&mut self, view: u64) -> Result<Duration, Fault> {
        let start = Instant::now();
        self.send(Message::text(json!({ "type": "stop", "id": view }).to_string()))?;
        self.await_text("the end of rendering", |message| {
            message["type"] == "stopped" && message["id"] == view
        })?;
        Ok(start.elapsed())
    }

    /// Picks at the middle of the image of the scene's camera; returns whether an object was hit.
    pub(crate) fn pick(&mut self) -> Result<bool, Fault> {
        let (origin, direction) = (self.camera["position"].clone(), self.camera["forward"].clone());
        let pick = json!({ "type": "pick", "origin": origin, "direction": direction, "hidden": [], "section": null });
        let id = self.request(pick)?;
        let hit = self.await_text("a hit", |message| message["type"] == "hit" && message["id"] == id)?;
        Ok(!hit["hit"].is_null())
    }

    /// Requests the current picture of a view; returns its bytes.
    pub(crate) fn save(&mut self, view: u64) -> Result<Vec<u8>, Fault> {
        self.await_text("a pass", |message| message["type"] == "progress" && message["id"] == view)?;
        let id = self.request(json!({ "type": "save" }))?;
        self.until("a file", |message| match message {
            Message::Binary(bytes) if number(bytes).0 == 2 && number(bytes).1 == id => {
                Some(bytes.get(8..).unwrap_or_default().to_vec())
            }
            _ => None,
        })
    }

    /// Receives messages until a tile of this view arrives.
    pub(crate) fn await_tile(&mut self, view: u64) -> Result<(), Fault> {
        let is_tile = |m: &Message| matches!(m, Message::Binary(bytes) if number(bytes) == (1, view));
        self.until("a tile", |message| is_tile(message).then_some(()))
    }

    /// Sends a request with a new number.
    pub(crate) fn request(&mut self, mut request: Value) -> Result<u64, Fault> {
        self.id += 1;
        request["id"] = self.id.into();
        self.send(Message::text(request.to_string()))?;
        Ok(self.id)
    }

    /// Sends any message.
    pub(crate) fn send(&mut self, message: Message) -> Result<(), Fault> {
        self.socket.send(message).map_err(|error| format!("sending: {error}"))
    }

    /// The next text that `wanted` accepts; other messages are processed.
    pub(crate) fn await_text(
        &mut self,
        what: &str,
        is_wanted: impl Fn(&Value) -> bool,
    ) -> Result<Value, Fault> {
        self.until(what, |message| text_of(message).filter(&is_wanted))
    }

    /// The next message that `wanted` accepts; `failed` is an error unless `wanted` accepts it.
    fn until<T>(&mut self, what: &str, wanted: impl Fn(&Message) -> Option<T>) -> Result<T, Fault> {
        let start = Instant::now();
        while start.elapsed() < http::PATIENCE {
            match self.socket.read() {
                Ok(message) => {
                    if let Message::Binary(bytes) = &message {
                        self.tiles += u64::from(number(bytes).0 == 1);
                    }
                    if let Some(found) = wanted(&message) {
                        return Ok(found);
                    }
                    if let Some(failed) = text_of(&message).filter(|text| text["type"] == "failed") {
                        return Err(format!("waiting for {what}: {failed}"));
                    }
                }
                Err(tungstenite::Error::Io(error)) if is_timeout(&error) => {}
                Err(error) => return Err(format!("waiting for {what}: {error}")),
            }
        }
        Err(format!("{what} does not come in {} s", http::PATIENCE.as_secs()))
    }
}

/// Parses a text message.
pub(crate) fn text_of(message: &Message) -> Option<Value> {
    let Message::Text(text) = message else { return None };
    serde_json::from_str(text).ok()
}

/// The kind of a binary message, and the number of the request that it answers.
fn number(bytes: &[u8]) -> (u8, u64) {
    let kind = bytes.first().copied().unwrap_or(0);
    let id = bytes.get(4..8).and_then(|four| four.try_into().ok()).map_or(0, u32::from_le_bytes);
    (kind, u64::from(id))
}

/// The camera of a model.
fn camera(model: &[u8]) -> Option<Value> {
    let length = u32::from_le_bytes(model.get(8..12)?.try_into().ok()?);
    let text = model.get(16..16 + length as usize)?;
    let mut about: Value = serde_json::from_slice(text).ok()?;
    Some(about["camera"].take())
}

/// Opens a WebSocket with the origin of the page, before any message.
pub(crate) fn connect(host: &str) -> Result<WebSocket<TcpStream>, Fault> {
    let complaint = |error: &dyn std::fmt::Display| format!("connecting: {error}");
    let stream = TcpStream::connect(host).map_err(|error| complaint(&error))?;
    stream.set_read_timeout(Some(http::PATIENCE)).map_err(|error| complaint(&error))?;
    stream.set_write_timeout(Some(http::PATIENCE)).map_err(|error| complaint(&error))?;
    let mut request = format!("ws://{host}/ws").into_client_request().map_err(|error| complaint(&error))?;
    let origin = HeaderValue::from_str(&format!("http://{host}")).map_err(|error| complaint(&error))?;
    request.headers_mut().insert("origin", origin);
    let sizes = WebSocketConfig::default().max_message_size(Some(256 << 20)).max_frame_size(Some(256 << 20));
    let (socket, _) = client_with_config(request, stream, Some(sizes)).map_err(|error| complaint(&error))?;
    // From here on the time-outs are short, and the deadline is checked after each.
    socket.get_ref().set_read_timeout(Some(Duration::from_millis(500))).map_err(|error| complaint(&error))?;
    Ok(socket)
}
