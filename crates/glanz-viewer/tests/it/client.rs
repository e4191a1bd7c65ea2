//! Test server and test pages.

use std::fs;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::PathBuf;
use std::thread::JoinHandle;
use std::time::Duration;

use glanz_formats::Options;
use glanz_job::CancelFlag;
use glanz_viewer::server::{Limits, Server, ServerSettings, UpdateListener, ViewerScene, WorkerCommand};
use serde_json::Value;
use tempfile::TempDir;
use tungstenite::client::IntoClientRequest;
use tungstenite::{Message, WebSocket};

/// A unit ball in white light, seen from 4 m: a picture of it takes milliseconds.
pub(crate) const BALL: &str = "LookAt 0 -4 0  0 0 0  0 0 1\nCamera \"perspective\" \"float fov\" 60\nWorldBegin\n\
    LightSource \"infinite\" \"rgb L\" [1 1 1]\nShape \"sphere\"\nTranslate 0 0 3\nShape \"sphere\"\n";

/// The same sphere in a closed, nearly white room, where every path has the maximal length: an image takes minutes, a sample does not.
pub(crate) const ENDLESS: &str = "LookAt 0 -4 0  0 0 0  0 0 1\nCamera \"perspective\" \"float fov\" 60\nIntegrator \"path\" \"integer maxdepth\" 100\n\
    WorldBegin\nMaterial \"diffuse\" \"rgb reflectance\" [0.9999 0.9999 0.9999]\nShape \"sphere\"\n\
    AreaLightSource \"diffuse\" \"rgb L\" [1 1 1]\nReverseOrientation\nShape \"sphere\" \"float radius\" 9\n";

/// Longer than anything takes on a busy machine; nothing waits so long unless it fails.
pub(crate) const PATIENCE: Duration = Duration::from_secs(60);

/// A running server.
pub(crate) struct TestServer {
    pub(crate) folder: TempDir,
    /// Such as `127.0.0.1:4711`.
    pub(crate) host: String,
    /// As printed.
    pub(crate) address: String,
    cancel: CancelFlag,
    thread: Option<JoinHandle<()>>,
}

impl TestServer {
    /// Shows a scene with these settings, and opens files.
    pub(crate) fn open_with(scene: &str, settings: ServerSettings) -> Self {
        let program = env!("CARGO_BIN_EXE_glanz-viewer-worker").into();
        let worker = Some(WorkerCommand { program, arguments: vec!["2".into()] });
        Self::open_with_listener(scene, ServerSettings { worker, ..settings }, Box::new(|_, _| {}))
    }

    /// Shows a scene and opens no files.
    pub(crate) fn open_alone(scene: &str) -> Self {
        Self::open_with_listener(scene, ServerSettings::default(), Box::new(|_, _| {}))
    }

    /// Shows a scene with a listener for changes.
    pub(crate) fn open_with_listener(
        scene: &str,
        settings: ServerSettings,
        listener: UpdateListener,
    ) -> Self {
        let folder = TempDir::new().unwrap();
        let path = folder.path().join("scene.pbrt");
        fs::write(&path, scene).unwrap();
        let viewer_scene =
            ViewerScene::read(&path, &Options::default(), None).unwrap_or_else(|d| panic!("{d}"));
        let settings = ServerSettings { port: Some(0), threads: 2, ..settings };
        let server = Server::bind(&settings, &path, viewer_scene, listener).unwrap();
        let address = server.address().to_owned();
        let host = address.strip_prefix("http://").and_then(|a| a.split('/').next()).unwrap().to_owned();
        let cancel = CancelFlag::default();
        let flag = cancel.clone();
        let thread = std::thread::spawn(move || server.run(&flag).unwrap());
        Self { folder, host, address, cancel, thread: Some(thread) }
    }

    pub(crate) fn open(scene: &str) -> Self {
        Self::open_with(scene, ServerSettings::default())
    }

    pub(crate) fn open_limited(scene: &str, limits: Limits) -> Self {
        Self::open_with(scene, ServerSettings { limits, ..ServerSettings::default() })
    }

    pub(crate) fn scene(&self) -> PathBuf {
        self.folder.path().join("scene.pbrt")
    }

    /// Sends `head` (request line and headers, without the empty line) and `body`, with the right host, and takes all of the answer.
    pub(crate) fn request(&self, line: &str, headers: &[&str], body: &[u8]) -> HttpResponse {
        let host = format!("Host: {}", self.host);
        self.request_with(line, &[&[host.as_str()], headers].concat(), body)
    }

    /// The same with exactly these headers.
    pub(crate) fn request_with(&self, line: &str, headers: &[&str], body: &[u8]) -> HttpResponse {
        let mut stream = self.connect();
        let mut head = format!("{line} HTTP/1.1\r\nConnection: close\r\n");
        headers.iter().for_each(|header| head.extend([header, "\r\n"]));
        if !body.is_empty() {
            head.push_str(&format!("Content-Length: {}\r\n", body.len()));
        }
        head.push_str("\r\n");
        stream.write_all(head.as_bytes()).unwrap();
        // A server that has heard enough may not take all.
        let _ = stream.write_all(body);
        let mut bytes = Vec::new();
        let _ = stream.read_to_end(&mut bytes);
        HttpResponse::parse(&bytes)
    }

    pub(crate) fn get(&self, path: &str) -> HttpResponse {
        self.request(&format!("GET {path}"), &[], &[])
    }

    pub(crate) fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(&self.host).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        stream.set_nodelay(true).unwrap();
        stream
    }

    /// A page that has received its scene; `None` if it is not admitted.
    pub(crate) fn try_connect_page(&self) -> Option<TestPage> {
        self.try_connect_page_to("ws")
    }

    /// The same for one of two designs.
    pub(crate) fn try_connect_page_to(&self, path: &str) -> Option<TestPage> {
        let request = format!("ws://{}/{path}", self.host).into_client_request().unwrap();
        let (socket, _) = tungstenite::client(request, self.connect()).ok()?;
        let mut page = TestPage { socket, scene: Value::Null };
        page.scene = page.receive_text("scene");
        Some(page)
    }

    pub(crate) fn connect_page(&self) -> TestPage {
        self.try_connect_page().expect("the page is let in")
    }
}

impl Drop for TestServer {
    fn drop(&mut self) {
        self.cancel.cancel();
        let ended = self.thread.take().unwrap().join();
        assert!(ended.is_ok() || std::thread::panicking(), "the server has failed");
    }
}

/// Response of the server.
#[derive(Debug)]
pub(crate) struct HttpResponse {
    pub(crate) status: u16,
    /// Names in lower case.
    pub(crate) headers: Vec<(String, String)>,
    pub(crate) body: Vec<u8>,
}

impl HttpResponse {
    fn parse(bytes: &[u8]) -> Self {
        let end = bytes.windows(4).position(|w| w == b"\r\n\r\n").expect("an answer");
        let head = std::str::from_utf8(&bytes[..end]).unwrap();
        let mut lines = head.split("\r\n");
        let status = lines.next().and_then(|line| line.split(' ').nth(1)).unwrap().parse().unwrap();
        let headers = lines.filter_map(|line| line.split_once(": "));
        let headers = headers.map(|(name, value)| (name.to_lowercase(), value.to_owned())).collect();
        Self { status, headers, body: bytes[end + 4..].to_vec() }
    }

    pub(crate) fn header(&self, name: &str) -> Option<&str> {
        self.headers.iter().find(|(n, _)| n == name).map(|(_, value)| value.as_str())
    }

    pub(crate) fn text(&self) -> String {
        String::from_utf8_lossy(&self.body).into_owned()
    }
}

/// A connected page.
pub(crate) struct TestPage {
    pub(crate) socket: WebSocket<TcpStream>,
    /// The scene that it was told first.
    pub(crate) scene: Value,
}

/// A part of a picture as it was sent.
#[derive(Debug)]
pub(crate) struct ReceivedTile {
    pub(crate) id: u32,
    pub(crate) min: [u16; 2],
    pub(crate) size: [u16; 2],
    pub(crate) samples: u32,
    pub(crate) is_denoised: bool,
    /// Half floats.
    pub(crate) values: Vec<u16>,
}

/// Message received by a page.
#[derive(Debug)]
pub(crate) enum ReceivedMessage {
    Text(Value),
    Tile(ReceivedTile),
    /// A file, and the number of the request.
    File(u32, Vec<u8>),
    /// The end, with its code.
    Closed(Option<u16>),
}

impl TestPage {
    pub(crate) fn send(&mut self, text: impl ToString) {
        self.socket.send(Message::text(text.to_string())).unwrap();
    }

    pub(crate) fn receive(&mut self) -> ReceivedMessage {
        loop {
            return match self.socket.read() {
                Ok(Message::Text(text)) => {
                    ReceivedMessage::Text(serde_json::from_str(text.as_str()).unwrap())
                }
                Ok(Message::Binary(bytes)) => binary(&bytes),
                Ok(Message::Close(frame)) => ReceivedMessage::Closed(frame.map(|frame| frame.code.into())),
                Ok(_) => continue,
                Err(tungstenite::Error::Io(error)) if error.kind() == std::io::ErrorKind::WouldBlock => {
                    panic!("nothing comes from the server")
                }
                Err(_) => ReceivedMessage::Closed(None),
            };
        }
    }

    /// The next text of that type; tiles and other texts before it are passed over.
    pub(crate) fn receive_text(&mut self, kind: &str) -> Value {
        loop {
            match self.receive() {
                ReceivedMessage::Text(value) if value["type"] == kind => return value,
                ReceivedMessage::Closed(code) => panic!("closed with {code:?} while waiting for {kind}"),
                _ => {}
            }
        }
    }

    pub(crate) fn session(&self) -> &str {
        self.scene["session"].as_str().unwrap()
    }
}

fn binary(bytes: &[u8]) -> ReceivedMessage {
    let short = |at: usize| u16::from_le_bytes([bytes[at], bytes[at + 1]]);
    let long = |at: usize| u32::from(short(at)) + (u32::from(short(at + 2)) << 16);
    match bytes[0] {
        1 => {
            let values = (20..bytes.len()).step_by(2).map(short).collect();
            let (min, size) = ([short(8), short(10)], [short(12), short(14)]);
            let is_denoised = bytes[1] == 1;
            ReceivedMessage::Tile(ReceivedTile {
                id: long(4),
                min,
                size,
                samples: long(16),
                is_denoised,
                values,
            })
        }
        2 => ReceivedMessage::File(long(4), bytes[8..].to_vec()),
        kind => panic!("binary messages have no kind {kind}"),
    }
}

/// The message that asks for a view of a scene from where its own camera is.
pub(crate) fn view(id: u32, size: [u32; 2], hidden: &[u32]) -> Value {
    serde_json::json!({
        "type": "view", "id": id, "size": size, "hidden": hidden, "integrator": "path",
        "camera": {
            "kind": "perspective", "position": [0, -4, 0], "right": [1, 0, 0], "up": [0, 0, 1], "forward": [0, 1, 0],
            "fieldOfView": 1.0471975511965976, "height": 4, "distance": 4,
        },
    })
}
