//! The WebSocket connection with a page.

use std::sync::Arc;
use std::time::Duration;

use axum::extract::ws::{CloseFrame, Message, WebSocket, close_code};
use tokio::time::{Instant, MissedTickBehavior, interval, timeout};

use super::message::{MalformedRequest, PageRequest, SceneMessage, ServerMessage};
use super::opened_scene::OpenedScene;
use super::page_service::{PageService, failed, text};
use super::session::{Session, SessionSlot};
use super::state::AppState;

/// Reasons for the end of a connection.
enum ConnectionEnd {
    /// The page is gone.
    Gone,
    /// The server closes it, with a code and the reason.
    Closed(u16, &'static str),
}

/// Scene that answers the requests of a page.
enum ShownScene {
    /// A design of the server.
    Design,
    /// A scene that the page has opened, in its process.
    Opened(Arc<OpenedScene>),
    /// A scene whose process has ended, with the reason.
    Lost(String),
}

/// Connection of a page with its service.
struct PageConnection {
    app: Arc<AppState>,
    session: Arc<Session>,
    socket: WebSocket,
    service: PageService,
    shown: ShownScene,
    malformed: usize,
    last_sign: Instant,
}

/// Exchanges messages with a page until it disconnects, then ends its stream and the process of the scene that it has opened.
pub(crate) async fn serve_page(app: Arc<AppState>, slot: SessionSlot, socket: WebSocket) {
    let service = PageService::new(app.service.clone());
    let mut connection = PageConnection {
        app,
        session: Arc::clone(&slot.session),
        socket,
        service,
        shown: ShownScene::Design,
        malformed: 0,
        last_sign: Instant::now(),
    };
    let end = connection.run().await;
    connection.service.end_stream().await;
    if let Err(ConnectionEnd::Closed(code, reason)) = end {
        let close = Message::Close(Some(CloseFrame { code, reason: reason.into() }));
        // A page that does not receive it is disconnected already.
        let _ = timeout(Duration::from_secs(1), connection.socket.send(close)).await;
    }
}

impl PageConnection {
    async fn run(&mut self) -> Result<(), ConnectionEnd> {
        let limits = self.app.limits;
        let mut ping = interval(limits.ping_interval);
        ping.set_missed_tick_behavior(MissedTickBehavior::Delay);
        let message =
            self.app.scene_message(&self.session.key, &self.session.published(), self.session.design);
        self.send_scene(message).await?;
        loop {
            tokio::select! {
                biased;
                // Requests first: a request to stop must not wait behind the picture it is to stop.
                message = self.socket.recv() => match message {
                    Some(Ok(message)) => self.receive(message).await?,
                    Some(Err(_)) => return Err(ConnectionEnd::Closed(close_code::SIZE, "the message is too long or malformed")),
                    None => return Ok(()),
                },
                () = self.session.notify.notified() => self.send_pending().await?,
                message = next_message(&mut self.service, &self.shown) => match message {
                    Ok(message) => self.send(message).await?,
                    Err(reason) => self.lose_scene(reason).await?,
                },
                _ = ping.tick() => {
                    if self.last_sign.elapsed() > limits.silence {
                        return Err(ConnectionEnd::Gone);
                    }
                    self.send(Message::Ping(Default::default())).await?;
                }
            }
        }
    }

    async fn send(&mut self, message: Message) -> Result<(), ConnectionEnd> {
        match timeout(self.app.limits.silence, self.socket.send(message)).await {
            Ok(Ok(())) => Ok(()),
            _ => Err(ConnectionEnd::Gone),
        }
    }

    async fn send_scene(&mut self, message: SceneMessage) -> Result<(), ConnectionEnd> {
        self.send(text(&ServerMessage::Scene(message))).await
    }

    /// Sends the page the message about a new scene, or closes it when the server shuts down.
    async fn send_pending(&mut self) -> Result<(), ConnectionEnd> {
        if self.app.is_closing() {
            return Err(ConnectionEnd::Closed(close_code::AWAY, "the server shuts down"));
        }
        let Some((message, opened)) = self.session.take_message() else { return Ok(()) };
        if message.model.is_some() {
            self.service.forget_scene();
        }
        // The scene before, whose model the page may fetch until it gets the message.
        let mut before = None;
        if let Some(opened) = opened {
            // Views and queries of the scene before, whose answers the page no longer expects.
            self.service.end_stream().await;
            self.service = PageService::new(self.app.service.clone());
            before = Some(std::mem::replace(&mut self.shown, ShownScene::Opened(opened)));
        }
        let sent = self.send_scene(message).await;
        drop(before);
        sent
    }

    /// Notifies the page that the process of its scene has ended.
    async fn lose_scene(&mut self, reason: String) -> Result<(), ConnectionEnd> {
        let ShownScene::Opened(opened) = &self.shown else { return Ok(()) };
        let message = SceneMessage {
            model: None,
            error: Some(reason.clone()),
            lost: true,
            ..self.app.opened_message(&self.session.key, opened)
        };
        opened.release_slot();
        self.shown = ShownScene::Lost(reason);
        self.send_scene(message).await
    }

    async fn receive(&mut self, message: Message) -> Result<(), ConnectionEnd> {
        self.last_sign = Instant::now();
        let request = match &message {
            Message::Text(text) => PageRequest::parse(text.as_str()),
            Message::Binary(_) => {
                Err(MalformedRequest { id: 0, message: "messages must be text".to_owned() })
            }
            Message::Ping(_) | Message::Pong(_) => return Ok(()),
            Message::Close(_) => return Err(ConnectionEnd::Gone),
        };
        match request {
            Ok(request) => self.serve(request, message).await,
            Err(MalformedRequest { id, message }) => {
                self.malformed += 1;
                if self.malformed > self.app.limits.malformed_messages {
                    return Err(ConnectionEnd::Closed(close_code::POLICY, "too many messages are malformed"));
                }
                self.send(failed(id, message)).await
            }
        }
    }

    /// Serves a request, which arrived as `message`.
    async fn serve(&mut self, request: PageRequest, message: Message) -> Result<(), ConnectionEnd> {
        let reply = match &self.shown {
            ShownScene::Design => {
                let viewer_scene = self.session.published().viewer_scene;
                self.service.serve(request, &viewer_scene).await
            }
            ShownScene::Opened(opened) => {
                let is_forwarded = opened.forward(message, request.is_query());
                (!is_forwarded)
                    .then(|| failed(request.id(), "too many requests are open; wait for answers".to_owned()))
            }
            ShownScene::Lost(reason) => Some(failed(request.id(), reason.clone())),
        };
        match reply {
            Some(reply) => self.send(reply).await,
            None => Ok(()),
        }
    }
}

/// Waits for the next message for the page. The error is the reason why the process of an opened scene has ended.
async fn next_message(service: &mut PageService, shown: &ShownScene) -> Result<Message, String> {
    match shown {
        ShownScene::Design => Ok(service.next().await),
        ShownScene::Opened(opened) => opened.next().await,
        ShownScene::Lost(_) => std::future::pending().await,
    }
}
