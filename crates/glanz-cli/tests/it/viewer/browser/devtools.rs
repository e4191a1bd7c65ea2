//! The DevTools protocol: commands and events as JSON over a WebSocket.

use std::net::TcpStream;
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use tungstenite::client::client_with_config;
use tungstenite::protocol::WebSocketConfig;
use tungstenite::{Error, Message, WebSocket};

use crate::viewer::http::is_timeout;

/// Time limit for a response, which may need a picture drawn in software while other tests run.
const PATIENCE: Duration = Duration::from_secs(120);

/// Largest size of a message in bytes; a picture is one message.
const LARGEST: usize = 256 << 20;

/// A connection to a browser.
pub(crate) struct DevTools {
    socket: WebSocket<TcpStream>,
    last: u64,
    events: Vec<Value>,
}

impl DevTools {
    /// Connects to `ws://127.0.0.1:port` + `path`.
    pub(crate) fn connect(port: u16, path: &str) -> Self {
        let stream = TcpStream::connect(("127.0.0.1", port)).expect("the browser listens");
        stream.set_read_timeout(Some(PATIENCE)).expect("a timeout");
        stream.set_nodelay(true).expect("a connection");
        let sizes = WebSocketConfig::default().max_message_size(Some(LARGEST)).max_frame_size(Some(LARGEST));
        let address = format!("ws://127.0.0.1:{port}{path}");
        let (socket, _) = client_with_config(address, stream, Some(sizes)).expect("the browser speaks");
        // From here on the time-outs are short, so that waiting for events does not block.
        socket.get_ref().set_read_timeout(Some(Duration::from_millis(100))).expect("a timeout");
        Self { socket, last: 0, events: Vec::new() }
    }

    /// The result of a command. `session`: the session of a page, or none for the browser itself.
    pub(crate) fn call(&mut self, session: Option<&str>, method: &str, parameters: Value) -> Value {
        self.last += 1;
        let id = self.last;
        let mut command = json!({ "id": id, "method": method, "params": parameters });
        if let Some(session) = session {
            command["sessionId"] = session.into();
        }
        self.socket.send(Message::text(command.to_string())).expect("the browser is there");
        let start = Instant::now();
        while start.elapsed() < PATIENCE {
            let Some(mut message) = self.read() else { continue };
            if message["id"] != id {
                continue;
            }
            if let Some(error) = message.get("error") {
                panic!("{method}: {error}");
            }
            return message["result"].take();
        }
        panic!("{method} is not answered");
    }

    /// Receives messages for about `time`.
    pub(crate) fn wait(&mut self, time: Duration) {
        let start = Instant::now();
        while start.elapsed() < time {
            self.read();
        }
    }

    /// The events of all pages so far.
    pub(crate) fn events(&self) -> &[Value] {
        &self.events
    }

    /// The next response, if one arrives before the time-out. Events are stored.
    fn read(&mut self) -> Option<Value> {
        match self.socket.read() {
            Ok(Message::Text(text)) => {
                let message: Value = serde_json::from_str(&text).expect("JSON");
                if message.get("method").is_some() {
                    self.events.push(message);
                    return None;
                }
                Some(message)
            }
            Ok(_) => None,
            Err(Error::Io(error)) if is_timeout(&error) => None,
            Err(error) => panic!("the browser is gone: {error}"),
        }
    }
}
