//! Invalid requests and messages, each of which the server must refuse.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::Duration;

use serde_json::json;
use tungstenite::Message;

use super::visitor::{Fault, Visitor, connect};
use crate::viewer::http;
use crate::viewer::http::is_timeout;

/// Requests for files that do not belong to the page.
const PATHS: [&str; 14] = [
    "/../../../../../../etc/passwd",
    "/..%2f..%2f..%2f..%2f..%2fetc%2fpasswd",
    "/%2e%2e/%2e%2e/%2e%2e/etc/passwd",
    "/ui/../../../../etc/passwd",
    "//etc/passwd",
    "/.%00./etc/passwd",
    "/main.js%00.html",
    "/..\\..\\etc\\passwd",
    "/file:///etc/passwd",
    "/model/../../../etc/passwd",
    "/model/%2e%2e%2f%2e%2e%2fetc%2fpasswd",
    "/model/0",
    "/scenes/teapot.pbrt",
    "/.git/config",
];

/// Invalid messages.
const MESSAGES: [&str; 16] = [
    "",
    "{",
    "null",
    "[]",
    "\"view\"",
    "{}",
    r#"{"type":"dance","id":1}"#,
    r#"{"type":"view","id":1}"#,
    r#"{"type":"view","id":-1,"camera":null,"size":[8,8],"hidden":[],"integrator":"path"}"#,
    r#"{"type":"pick","id":1,"origin":[0,0],"direction":[0,0,1],"hidden":[],"section":null}"#,
    r#"{"type":"pick","id":1,"origin":[0,0,0],"direction":[0,0,0],"hidden":[],"section":null}"#,
    r#"{"type":"pick","id":1,"origin":[1e999,0,0],"direction":[0,0,1],"hidden":[],"section":null}"#,
    r#"{"type":"pick","id":1,"origin":[0,0,0],"direction":[0,0,1],"hidden":["all"],"section":null}"#,
    r#"{"type":"stop"}"#,
    r#"{"type":["stop"],"id":{}}"#,
    "\u{0}\u{1}\u{2}",
];

/// A kind of misuse: its name and the function that performs it, which fails if the server accepts it.
pub(crate) type Mischief = (&'static str, fn(&str) -> Result<(), Fault>);

/// All kinds.
pub(crate) const ALL: [Mischief; 10] = [
    ("path tricks", path_tricks),
    ("messages that mean nothing", nonsense),
    ("views that cannot be", impossible_views),
    ("huge messages", huge_messages),
    ("frames against the protocol", broken_frames),
    ("other people's pages", foreign_pages),
    ("requests that are none", no_requests),
    ("files that are no scene", uploads),
    ("requests that never end", half_a_request),
    ("pages that do not listen", deaf),
];

fn path_tricks(host: &str) -> Result<(), Fault> {
    for path in PATHS {
        let answer = http::get(host, path).map_err(|error| format!("GET {path}: {error}"))?;
        if answer.status != 0 && !(400..500).contains(&answer.status) {
            return Err(format!("GET {path}: {}", answer.head));
        }
        if answer.body.windows(5).any(|five| five == b"root:") {
            return Err(format!("GET {path}: the system's own file"));
        }
    }
    Ok(())
}

fn nonsense(host: &str) -> Result<(), Fault> {
    for text in MESSAGES {
        refused(host, Message::text(text)).map_err(|fault| format!("{text:?}: {fault}"))?;
    }
    refused(host, Message::text("[".repeat(30_000))).map_err(|fault| format!("30 000 brackets: {fault}"))?;
    refused(host, Message::binary(vec![1_u8; 64])).map_err(|fault| format!("64 bytes: {fault}"))
}

fn impossible_views(host: &str) -> Result<(), Fault> {
    let camera = |scale: f64, field_of_view: f64| {
        json!({ "kind": "perspective", "position": [0, -5, 1], "right": [scale, 0, 0], "up": [0, 0, scale],
            "forward": [0, scale, 0], "fieldOfView": field_of_view, "height": 1, "distance": 5 })
    };
    let view = |camera, size| json!({ "type": "view", "id": 1, "camera": camera, "size": size, "hidden": [], "integrator": "path" });
    let good = camera(1.0, 0.5);
    let views = [
        view(good.clone(), json!([0, 0])),
        view(good.clone(), json!([-8, 8])),
        view(good.clone(), json!([4_000_000_000_u32, 4_000_000_000_u32])),
        view(good.clone(), json!([1_000_000, 1])),
        view(good, json!([1.5, 8])),
        view(camera(0.0, 0.5), json!([8, 8])),
        view(camera(1e300, 0.5), json!([8, 8])),
        view(camera(1.0, 0.0), json!([8, 8])),
        view(camera(1.0, -1.0), json!([8, 8])),
        view(camera(1.0, 7.0), json!([8, 8])),
    ];
    views.into_iter().try_for_each(|view| {
        refused(host, Message::text(view.to_string())).map_err(|fault| format!("{view}: {fault}"))
    })
}

fn huge_messages(host: &str) -> Result<(), Fault> {
    refused(host, Message::text(" ".repeat(1 << 20)))
        .map_err(|fault| format!("a mebibyte of blanks: {fault}"))?;
    // A frame with a declared length of 2^62 bytes, and a message of fragments without end.
    let endless = [0x81, 0xff, 0x40, 0, 0, 0, 0, 0, 0, 0, 1, 2, 3, 4, 5, 6];
    closed(host, &endless).map_err(|fault| format!("2^62 bytes: {fault}"))?;
    let mut parts = vec![0x01, 0x80, 0, 0, 0, 0];
    for _ in 0..64 {
        parts.extend([0x00, 0xfe, 0xff, 0xff, 0, 0, 0, 0]);
        parts.resize(parts.len() + 0xffff, b' ');
    }
    closed(host, &parts).map_err(|fault| format!("4 MiB in parts: {fault}"))
}

fn broken_frames(host: &str) -> Result<(), Fault> {
    let long_ping = [&[0x89, 0xfe, 0x00, 0x80, 0, 0, 0, 0][..], &[0; 128]].concat();
    let frames: [&[u8]; 5] = [
        // Not masked; reserved bits set; an unknown opcode; a ping of more than 125 bytes; text that is not UTF-8.
        &[0x81, 0x02, b'h', b'i'],
        &[0xf1, 0x80, 0, 0, 0, 0],
        &[0x83, 0x80, 0, 0, 0, 0],
        &long_ping,
        &[0x81, 0x82, 0, 0, 0, 0, 0xff, 0xfe],
    ];
    frames.iter().try_for_each(|frame| closed(host, frame).map_err(|fault| format!("{frame:x?}: {fault}")))
}

fn foreign_pages(host: &str) -> Result<(), Fault> {
    let upgrade = "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n\
        Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n";
    let requests = [
        "GET / HTTP/1.1\r\nHost: example.org\r\nConnection: close\r\n\r\n".to_owned(),
        format!("GET /ws HTTP/1.1\r\nHost: example.org\r\nOrigin: http://example.org\r\n{upgrade}\r\n"),
        format!("GET /ws HTTP/1.1\r\nHost: {host}\r\nOrigin: http://example.org\r\n{upgrade}\r\n"),
        format!("GET /ws HTTP/1.1\r\nHost: {host}\r\nOrigin: null\r\n{upgrade}\r\n"),
        format!(
            "POST /open HTTP/1.1\r\nHost: {host}\r\nOrigin: http://example.org\r\nContent-Length: 0\r\nConnection: close\r\n\r\n"
        ),
    ];
    requests.iter().try_for_each(|request| denied(host, request.as_bytes()))
}

fn no_requests(host: &str) -> Result<(), Fault> {
    let long = format!("GET /{} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n", "a".repeat(1 << 20));
    let many = format!("GET /missing HTTP/1.1\r\nHost: {host}\r\n{}\r\n", "X: y\r\n".repeat(10_000));
    let requests: [&[u8]; 6] = [
        long.as_bytes(),
        many.as_bytes(),
        b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03 hello",
        b"GET / HTTP/9.9\r\n\r\n",
        b"\r\n\r\n\r\n\r\nhello\r\n\r\n",
        b"DELETE / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 99999999999999999999\r\n\r\n",
    ];
    requests.iter().try_for_each(|request| denied(host, request))
}

fn uploads(host: &str) -> Result<(), Fault> {
    let visitor = Visitor::try_new(host)?;
    let session = &visitor.session;
    let post = |body: &str| {
        format!(
            "POST /open?session={session} HTTP/1.1\r\nHost: {host}\r\nOrigin: http://{host}\r\n\
             Content-Length: {}\r\nConnection: close\r\n\r\n{body}",
            body.len()
        )
    };
    let form = |name: &str, content: &str| post(&format!("[[\"{name}\",{}]]\n{content}", content.len()));
    let requests = [
        post("hello"),
        post("hello\n"),
        post("[[\"room.pbrt\",1000]]\nWorld"),
        form("room.pbrt", "this is no scene"),
        form("room.pbrt", "Include \"/etc/passwd\""),
        form("room.pbrt", "Include \"../room.pbrt\""),
        form("room.pbrt", "Include \"room.pbrt\""),
        form("notes.txt", "hello"),
        form("a.pbrt", "WorldBegin Shape \"sphere\"").replace("/open?session=", "/open?session=0"),
    ];
    requests.iter().try_for_each(|request| denied(host, request.as_bytes()))?;
    // Uploaded files stay in their own temporary folder, whatever their names.
    http::send(host, form("../glanz-escaped.pbrt", "WorldBegin Shape \"sphere\"").as_bytes())
        .map_err(|e| e.to_string())?;
    match std::env::temp_dir().join("glanz-escaped.pbrt").exists() {
        true => Err("a file outside of its folder".to_owned()),
        false => Ok(()),
    }
}

fn half_a_request(host: &str) -> Result<(), Fault> {
    let mut stream = TcpStream::connect(host).map_err(|error| error.to_string())?;
    // Single bytes at long intervals, here for a second.
    for letter in b"GET / HTTP" {
        if stream.write_all(&[*letter]).is_err() {
            break;
        }
        std::thread::sleep(Duration::from_millis(100));
    }
    Ok(())
}

fn deaf(host: &str) -> Result<(), Fault> {
    let mut visitor = Visitor::try_new(host)?;
    visitor.view([640, 480], 0.0)?;
    std::thread::sleep(Duration::from_secs(1));
    Ok(())
}

/// Sends bytes that the server must refuse or leave unanswered.
fn denied(host: &str, request: &[u8]) -> Result<(), Fault> {
    let answer = http::send(host, request);
    let start: String = String::from_utf8_lossy(request).chars().take(200).collect();
    match answer.map_err(|error| format!("{start:?}: {error}"))? {
        answer if answer.status == 0 || (400..600).contains(&answer.status) => Ok(()),
        answer => Err(format!("{start:?}: {}", answer.head)),
    }
}

/// Sends a message that the server must answer with `failed` or by closing the connection.
fn refused(host: &str, message: Message) -> Result<(), Fault> {
    let mut visitor = Visitor::try_new(host)?;
    // The server may have closed the connection before everything was sent.
    let sent = visitor.send(message);
    match visitor.await_text("an answer", |answer| answer["type"] == "failed" || answer["type"] == "hit") {
        Ok(answer) if answer["type"] == "failed" => Ok(()),
        Ok(answer) => Err(format!("answered with {answer}")),
        Err(why) if why.contains("does not come") => Err(format!("{why}; {sent:?}")),
        Err(_) => Ok(()),
    }
}

/// Sends raw bytes over a WebSocket; the server must close the connection.
fn closed(host: &str, bytes: &[u8]) -> Result<(), Fault> {
    let mut socket = connect(host)?;
    let stream = socket.get_mut();
    let _ = stream.write_all(bytes);
    stream.set_read_timeout(Some(http::PATIENCE)).map_err(|error| error.to_string())?;
    // Messages before the end of the connection are ignored.
    match std::io::copy(&mut (&*stream).take(1 << 20), &mut std::io::sink()) {
        Err(error) if is_timeout(&error) => Err("the connection stays".to_owned()),
        _ => Ok(()),
    }
}
