//! The conversation with a page.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::Duration;

use axum::extract::ws::{CloseFrame, Message, WebSocket, close_code};
use glanz_formats::image::{self, Format};
use glanz_light::Tone;
use glanz_math::{DVec3, Ray};
use tokio::task::spawn_blocking;
use tokio::time::{Instant, MissedTickBehavior, interval, timeout};

use super::house::House;
use super::message::{Answer, Malformed, Progress, Request};
use super::session::{Seat, Session};
use super::shown::Shown;
use crate::query;
use crate::stream::{Order, Outbox, Parcel, Picture, Status, Stream, Surroundings, Visible, file};

/// Why a conversation ends.
enum End {
    /// The page is gone.
    Gone,
    /// It is sent away, with a code and the reason.
    SentAway(u16, &'static str),
}

/// What a page has going.
struct Conversation {
    house: Arc<House>,
    session: Arc<Session>,
    socket: WebSocket,
    outbox: Arc<Outbox>,
    picture: Arc<Picture>,
    visible: Arc<Visible>,
    stream: Option<Stream>,
    malformed: usize,
    last_sign: Instant,
}

/// Speaks with a page until it goes; what was rendered for it ends then.
pub(crate) async fn converse(house: Arc<House>, seat: Seat, socket: WebSocket) {
    let mut conversation = Conversation {
        house,
        session: Arc::clone(&seat.session),
        socket,
        outbox: Arc::default(),
        picture: Arc::default(),
        visible: Arc::default(),
        stream: None,
        malformed: 0,
        last_sign: Instant::now(),
    };
    let end = conversation.run().await;
    if let Some(stream) = conversation.stream.take() {
        stream.stop().await;
    }
    if let Err(End::SentAway(code, reason)) = end {
        let farewell = Message::Close(Some(CloseFrame { code, reason: reason.into() }));
        // Who does not take it is gone anyway.
        let _ = timeout(Duration::from_secs(1), conversation.socket.send(farewell)).await;
    }
}

impl Conversation {
    async fn run(&mut self) -> Result<(), End> {
        let limits = self.house.limits;
        let mut ping = interval(limits.ping_interval);
        ping.set_missed_tick_behavior(MissedTickBehavior::Delay);
        let posted = self.session.posted();
        self.say(Answer::Scene(self.house.news(&self.session.key, &posted))).await?;
        loop {
            tokio::select! {
                biased;
                // Requests first: the wish to stop must not wait behind the picture that it is about.
                message = self.socket.recv() => match message {
                    Some(Ok(message)) => self.hear(message).await?,
                    Some(Err(_)) => return Err(End::SentAway(close_code::SIZE, "the message is too long or broken")),
                    None => return Ok(()),
                },
                () = self.session.news.notified() => self.tell().await?,
                parcel = self.outbox.next() => self.send(message_of(parcel)).await?,
                _ = ping.tick() => {
                    if self.last_sign.elapsed() > limits.silence {
                        return Err(End::Gone);
                    }
                    self.send(Message::Ping(Default::default())).await?;
                }
            }
        }
    }

    async fn send(&mut self, message: Message) -> Result<(), End> {
        match timeout(self.house.limits.silence, self.socket.send(message)).await {
            Ok(Ok(())) => Ok(()),
            _ => Err(End::Gone),
        }
    }

    async fn say(&mut self, answer: Answer) -> Result<(), End> {
        self.send(Message::text(answer.to_text())).await
    }

    /// Tells the page of another scene, or that the server ends.
    async fn tell(&mut self) -> Result<(), End> {
        if self.house.is_closing() {
            return Err(End::SentAway(close_code::AWAY, "the server ends"));
        }
        let Some(news) = self.session.take_news() else { return Ok(()) };
        if news.model.is_some() {
            self.visible.forget();
        }
        self.say(Answer::Scene(news)).await
    }

    async fn hear(&mut self, message: Message) -> Result<(), End> {
        self.last_sign = Instant::now();
        let request = match &message {
            Message::Text(text) => Request::parse(text.as_str()),
            Message::Binary(_) => Err(Malformed { id: 0, message: "messages are texts".to_owned() }),
            Message::Ping(_) | Message::Pong(_) => return Ok(()),
            Message::Close(_) => return Err(End::Gone),
        };
        match request {
            Ok(request) => self.serve(request).await,
            Err(Malformed { id, message }) => {
                self.malformed += 1;
                if self.malformed > self.house.limits.malformed_messages {
                    return Err(End::SentAway(close_code::POLICY, "too many messages are not understood"));
                }
                self.say(Answer::Failed { id, message }).await
            }
        }
    }

    async fn serve(&mut self, request: Request) -> Result<(), End> {
        match request {
            Request::View { id, camera, size, hidden, integrator } => {
                self.end_stream().await;
                self.picture.clear();
                let integrator = integrator.unwrap_or(self.house.integrator);
                let order = Order { id, camera, size, hidden, integrator };
                match Stream::start(order, self.surroundings()) {
                    Ok(stream) => self.stream = Some(stream),
                    Err(error) => self.say(Answer::Failed { id, message: error.to_string() }).await?,
                }
                Ok(())
            }
            Request::Stop { id } => {
                // It may come late, when the next view is rendered already.
                if self.stream.as_ref().is_some_and(|stream| stream.id() == id) {
                    self.end_stream().await;
                }
                self.say(Answer::Stopped { id }).await
            }
            Request::Pick { id, origin, direction, hidden, section } => {
                let shown = self.session.posted().shown;
                let answer = match ray(origin, direction) {
                    Some(ray) => find(id, shown, ray, hidden, section).await,
                    None => Answer::Failed { id, message: "the ray has no direction".to_owned() },
                };
                self.say(answer).await
            }
            Request::Save { id } => match save(id, Arc::clone(&self.picture)).await {
                Ok(bytes) => self.send(Message::binary(bytes)).await,
                Err(message) => self.say(Answer::Failed { id, message }).await,
            },
        }
    }

    /// Ends what is rendered; nothing of it is sent after this.
    async fn end_stream(&mut self) {
        if let Some(stream) = self.stream.take() {
            stream.stop().await;
        }
        self.outbox.clear();
    }

    fn surroundings(&self) -> Surroundings {
        let shown = self.session.posted().shown;
        Surroundings {
            description: Arc::clone(&shown.description),
            scene: Arc::clone(&shown.scene),
            visible: Arc::clone(&self.visible),
            outbox: Arc::clone(&self.outbox),
            picture: Arc::clone(&self.picture),
            processors: Arc::clone(&self.house.processors),
        }
    }
}

/// The ray of a request, its direction of length 1.
fn ray(origin: [f64; 3], direction: [f64; 3]) -> Option<Ray> {
    let [origin, direction] = [origin, direction].map(DVec3::from_array);
    let direction = direction.try_normalize().filter(|_| origin.is_finite())?;
    Some(Ray::new(origin, direction))
}

/// What a ray meets. Areas may take a while the first time: others are served meanwhile.
async fn find(
    id: u32,
    shown: Arc<Shown>,
    ray: Ray,
    hidden: BTreeSet<u32>,
    section: Option<[f64; 4]>,
) -> Answer {
    let look = move || query::pick(&shown.scene, &shown.model, &ray, &hidden, section);
    match spawn_blocking(look).await {
        Ok(hit) => Answer::Hit { id, hit: hit.map(Box::new) },
        Err(error) => Answer::Failed { id, message: error.to_string() },
    }
}

/// The picture so far as OpenEXR, as it is sent.
async fn save(id: u32, picture: Arc<Picture>) -> Result<Vec<u8>, String> {
    let Some(shot) = picture.get() else { return Err("there is no picture yet".to_owned()) };
    let attributes = [("samplesPerPixel".to_owned(), shot.samples.to_string())].into();
    let write = move || {
        let bytes = image::write(&shot.pixels, Format::Exr, &Tone::default(), &attributes);
        bytes.map(|bytes| file(id, &bytes)).map_err(|error| error.to_string())
    };
    spawn_blocking(write).await.map_err(|error| error.to_string())?
}

fn message_of(parcel: Parcel) -> Message {
    let (id, status) = match parcel {
        Parcel::Tile(bytes) => return Message::binary(bytes),
        Parcel::Status(id, status) => (id, status),
    };
    let answer = match status {
        Status::Progress { samples, noise, seconds, done } => {
            Answer::Progress(Progress { id, samples, noise, seconds, done })
        }
        Status::Waiting => Answer::Waiting { id },
        Status::Failed(message) => Answer::Failed { id, message },
    };
    Message::text(answer.to_text())
}
