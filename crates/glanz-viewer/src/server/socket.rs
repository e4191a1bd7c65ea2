//! The WebSocket connection with a page.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use axum::extract::ws::{CloseFrame, Message, WebSocket, close_code};
use glanz_formats::image::{self, Format};
use glanz_light::Tone;
use glanz_math::{DVec3, Ray};
use tokio::sync::Semaphore;
use tokio::task::{JoinSet, spawn_blocking};
use tokio::time::{Instant, MissedTickBehavior, interval, timeout};

use super::message::{MalformedRequest, PageRequest, ProgressMessage, ServerMessage};
use super::session::{Session, SessionSlot};
use super::state::AppState;
use super::viewer_scene::ViewerScene;
use crate::query;
use crate::stream::{
    LatestImage, Outbox, OutboxMessage, RenderRequest, Stream, StreamContext, StreamStatus, VisibleScene,
    file,
};

/// Largest number of queries of a page that are worked on at a time.
const MOST_WORKERS: usize = 4;

/// Largest number of queries of a page that are worked on or wait for it.
const MOST_QUERIES: usize = 64;

/// Reasons for the end of a connection.
enum ConnectionEnd {
    /// The page is gone.
    Gone,
    /// The server closes it, with a code and the reason.
    Closed(u16, &'static str),
}

/// Connection of a page with its stream.
struct PageConnection {
    app: Arc<AppState>,
    session: Arc<Session>,
    socket: WebSocket,
    outbox: Arc<Outbox>,
    picture: Arc<LatestImage>,
    visible: Arc<VisibleScene>,
    stream: Option<Stream>,
    /// Answers to come: areas and volumes may take seconds, and nothing else waits for them.
    answers: JoinSet<ServerMessage>,
    workers: Arc<Semaphore>,
    malformed: usize,
    last_sign: Instant,
}

/// Exchanges messages with a page until it disconnects, then ends its stream.
pub(crate) async fn serve_page(app: Arc<AppState>, slot: SessionSlot, socket: WebSocket) {
    let mut connection = PageConnection {
        app,
        session: Arc::clone(&slot.session),
        socket,
        outbox: Arc::default(),
        picture: Arc::default(),
        visible: Arc::default(),
        stream: None,
        answers: JoinSet::new(),
        workers: Arc::new(Semaphore::new(MOST_WORKERS)),
        malformed: 0,
        last_sign: Instant::now(),
    };
    let end = connection.run().await;
    if let Some(stream) = connection.stream.take() {
        stream.stop().await;
    }
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
        let message = self
            .session
            .with_published(|published, design| self.app.scene_message(&self.session.key, published, design));
        self.reply(ServerMessage::Scene(message)).await?;
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
                Some(Ok(answer)) = self.answers.join_next() => self.reply(answer).await?,
                message = self.outbox.next() => self.send(message_of(message)).await?,
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

    async fn reply(&mut self, answer: ServerMessage) -> Result<(), ConnectionEnd> {
        self.send(Message::text(answer.to_text())).await
    }

    /// Sends the page the message about a new scene, or closes it when the server shuts down.
    async fn send_pending(&mut self) -> Result<(), ConnectionEnd> {
        if self.app.is_closing() {
            return Err(ConnectionEnd::Closed(close_code::AWAY, "the server shuts down"));
        }
        let Some(message) = self.session.take_message() else { return Ok(()) };
        if message.model.is_some() {
            self.visible.forget();
        }
        self.reply(ServerMessage::Scene(message)).await
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
            Ok(request) => self.serve(request).await,
            Err(MalformedRequest { id, message }) => {
                self.malformed += 1;
                if self.malformed > self.app.limits.malformed_messages {
                    return Err(ConnectionEnd::Closed(close_code::POLICY, "too many messages are malformed"));
                }
                self.reply(ServerMessage::Failed { id, message }).await
            }
        }
    }

    async fn serve(&mut self, request: PageRequest) -> Result<(), ConnectionEnd> {
        match request {
            PageRequest::View { id, camera, size, hidden, integrator, denoise } => {
                self.end_stream().await;
                self.picture.clear();
                let integrator = integrator.unwrap_or(self.app.integrator);
                let request = RenderRequest { id, camera, size, hidden, integrator, denoise };
                match Stream::start(request, self.stream_context()) {
                    Ok(stream) => self.stream = Some(stream),
                    Err(error) => {
                        self.reply(ServerMessage::Failed { id, message: error.to_string() }).await?
                    }
                }
                Ok(())
            }
            PageRequest::Stop { id } => {
                // It may arrive when the next view is being rendered already.
                if self.stream.as_ref().is_some_and(|stream| stream.id() == id) {
                    self.end_stream().await;
                }
                self.reply(ServerMessage::Stopped { id }).await
            }
            PageRequest::Pick { id, origin, direction, filter } => {
                let Some(ray) = ray(origin, direction) else {
                    let message = "the ray has no direction".to_owned();
                    return self.reply(ServerMessage::Failed { id, message }).await;
                };
                let viewer_scene = self.session.published().viewer_scene;
                self.spawn_query(id, move || {
                    let ViewerScene { scene, model, .. } = &*viewer_scene;
                    let hit = query::pick(scene, model, &ray, &filter);
                    ServerMessage::Hit { id, hit: hit.map(Box::new) }
                })
                .await
            }
            PageRequest::Measure { id, leaves } => {
                let viewer_scene = self.session.published().viewer_scene;
                self.spawn_query(id, move || {
                    let measures = viewer_scene.model.measures_of(&leaves);
                    ServerMessage::Measures { id, measures }
                })
                .await
            }
            PageRequest::Save { id } => match save(id, Arc::clone(&self.picture)).await {
                Ok(bytes) => self.send(Message::binary(bytes)).await,
                Err(message) => self.reply(ServerMessage::Failed { id, message }).await,
            },
        }
    }

    /// Lets a blocking thread find an answer; other requests are served meanwhile.
    async fn spawn_query(
        &mut self,
        id: u32,
        query: impl FnOnce() -> ServerMessage + Send + 'static,
    ) -> Result<(), ConnectionEnd> {
        if self.answers.len() >= MOST_QUERIES {
            let message = format!("{MOST_QUERIES} queries are open; wait for one of their answers");
            return self.reply(ServerMessage::Failed { id, message }).await;
        }
        self.answers.spawn(answer(id, Arc::clone(&self.workers), query));
        Ok(())
    }

    /// Ends the stream; nothing of it is sent after this.
    async fn end_stream(&mut self) {
        if let Some(stream) = self.stream.take() {
            stream.stop().await;
        }
        self.outbox.clear();
    }

    fn stream_context(&self) -> StreamContext {
        let viewer_scene = self.session.published().viewer_scene;
        StreamContext {
            description: Arc::clone(&viewer_scene.description),
            scene: Arc::clone(&viewer_scene.scene),
            visible: Arc::clone(&self.visible),
            outbox: Arc::clone(&self.outbox),
            picture: Arc::clone(&self.picture),
            processors: Arc::clone(&self.app.processors),
            denoiser: match &self.app.denoiser {
                Some(denoiser) => denoiser.clone(),
                None => Err("this server does not remove noise".to_owned()),
            },
        }
    }
}

/// The ray of a request, its direction of length 1.
fn ray(origin: [f64; 3], direction: [f64; 3]) -> Option<Ray> {
    let [origin, direction] = [origin, direction].map(DVec3::from_array);
    let direction = direction.try_normalize().filter(|_| origin.is_finite())?;
    Some(Ray::new(origin, direction))
}

/// The answer to a query, once one of the workers is free for it.
async fn answer(
    id: u32,
    workers: Arc<Semaphore>,
    query: impl FnOnce() -> ServerMessage + Send + 'static,
) -> ServerMessage {
    // Nothing closes the semaphore.
    let _permit = workers.acquire().await;
    match spawn_blocking(query).await {
        Ok(answer) => answer,
        Err(error) => ServerMessage::Failed { id, message: error.to_string() },
    }
}

/// The picture so far as OpenEXR, as it is sent.
async fn save(id: u32, picture: Arc<LatestImage>) -> Result<Vec<u8>, String> {
    let Some(shot) = picture.get() else { return Err("there is no picture yet".to_owned()) };
    let mut attributes = BTreeMap::from([("samplesPerPixel".to_owned(), shot.samples.to_string())]);
    if shot.is_denoised {
        attributes.insert("denoised".to_owned(), "true".to_owned());
    }
    let write = move || {
        let bytes = image::write(&shot.pixels, Format::Exr, &Tone::default(), &attributes);
        bytes.map(|bytes| file(id, &bytes)).map_err(|error| error.to_string())
    };
    spawn_blocking(write).await.map_err(|error| error.to_string())?
}

fn message_of(message: OutboxMessage) -> Message {
    let (id, status) = match message {
        OutboxMessage::Tile(bytes) => return Message::binary(bytes),
        OutboxMessage::Status(id, status) => (id, status),
    };
    let answer = match status {
        StreamStatus::Progress { samples, noise, seconds, done } => {
            ServerMessage::Progress(ProgressMessage { id, samples, noise, seconds, done })
        }
        StreamStatus::Waiting => ServerMessage::Waiting { id },
        StreamStatus::Failed(message) => ServerMessage::Failed { id, message },
    };
    Message::text(answer.to_text())
}
