//! Answers to the requests of a page about its scene: views, hits, measures, files.

use std::collections::BTreeMap;
use std::sync::Arc;

use axum::extract::ws::Message;
use glanz_formats::image::{self, Format};
use glanz_light::Tone;
use glanz_math::{DVec3, Ray};
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio::task::{JoinSet, spawn_blocking};

use super::message::{PageRequest, ProgressMessage, ServerMessage};
use super::viewer_scene::ViewerScene;
use crate::query;
use crate::stream::{
    IntegratorName, LatestImage, Outbox, OutboxMessage, Processors, RenderRequest, SharedDenoiser, Stream,
    StreamContext, StreamStatus, ViewDenoiser, VisibleScene, file,
};

/// Largest number of queries of a page that are worked on at a time.
const MOST_WORKERS: usize = 4;

/// Largest number of queries of a page that are worked on or wait for it.
const MOST_QUERIES: usize = 64;

/// Largest number of them that save a picture: those that wait keep pictures of views that the page has left.
const MOST_SAVES: usize = 4;

const NO_PICTURE: &str = "there is no picture yet";

/// Data that the services of all pages share.
#[derive(Clone, Debug)]
pub(crate) struct ServiceContext {
    /// Default integrator.
    pub(crate) integrator: IntegratorName,
    pub(crate) processors: Arc<Processors>,
    /// As in the settings of the server.
    pub(crate) denoiser: Option<Result<Arc<SharedDenoiser>, String>>,
}

impl ServiceContext {
    /// `threads`: of a render; 0 means as many as the machine has. `denoiser`: as in the settings of the server.
    pub(crate) fn new(
        integrator: IntegratorName,
        threads: usize,
        denoiser: Option<Result<Arc<dyn ViewDenoiser>, String>>,
    ) -> Self {
        let processors = Arc::new(Processors::new(threads));
        let share = |denoiser| Arc::new(SharedDenoiser::new(denoiser));
        Self { integrator, processors, denoiser: denoiser.map(|denoiser| denoiser.map(share)) }
    }
}

/// Answer to a query.
#[derive(Debug)]
struct QueryAnswer {
    message: Message,
    /// Held until the answer is taken.
    _permits: Vec<OwnedSemaphorePermit>,
}

/// Service of one page: its stream, and its queries.
#[derive(Debug)]
pub(crate) struct PageService {
    context: ServiceContext,
    outbox: Arc<Outbox>,
    picture: Arc<LatestImage>,
    visible: Arc<VisibleScene>,
    stream: Option<Stream>,
    /// Answers to come: areas, volumes and files may take seconds, and nothing else waits for them.
    answers: JoinSet<QueryAnswer>,
    workers: Arc<Semaphore>,
    saves: Arc<Semaphore>,
    /// A single permit: one file at a time is written or waits to be sent.
    save_turn: Arc<Semaphore>,
}

impl PageService {
    /// A service without a stream.
    pub(crate) fn new(context: ServiceContext) -> Self {
        Self {
            context,
            outbox: Arc::default(),
            picture: Arc::default(),
            visible: Arc::default(),
            stream: None,
            answers: JoinSet::new(),
            workers: Arc::new(Semaphore::new(MOST_WORKERS)),
            saves: Arc::new(Semaphore::new(MOST_SAVES)),
            save_turn: Arc::new(Semaphore::new(1)),
        }
    }

    /// Waits for the next message about views and queries.
    pub(crate) async fn next(&mut self) -> Message {
        tokio::select! {
            biased;
            Some(Ok(answer)) = self.answers.join_next() => answer.message,
            message = self.outbox.next() => message_of(message),
        }
    }

    /// Serves a request about a scene. Returns the reply, unless it comes later by [`next`](Self::next) or there is none.
    pub(crate) async fn serve(
        &mut self,
        request: PageRequest,
        viewer_scene: &Arc<ViewerScene>,
    ) -> Option<Message> {
        let viewer_scene = Arc::clone(viewer_scene);
        match request {
            PageRequest::View { id, camera, size, hidden, integrator, denoise } => {
                self.end_stream().await;
                // Saves that wait are of the view before.
                self.picture = Arc::default();
                let integrator = integrator.unwrap_or(self.context.integrator);
                let request = RenderRequest { id, camera, size, hidden, integrator, denoise };
                match Stream::start(request, self.stream_context(&viewer_scene)) {
                    Ok(stream) => self.stream = Some(stream),
                    Err(error) => return Some(failed(id, error.to_string())),
                }
                None
            }
            PageRequest::Stop { id } => {
                // It may arrive when the next view is being rendered already.
                if self.stream_of(id).is_some() {
                    self.end_stream().await;
                }
                Some(text(&ServerMessage::Stopped { id }))
            }
            PageRequest::Pause { id } => {
                self.stream_of(id)?.pause(true);
                None
            }
            PageRequest::Resume { id } => {
                self.stream_of(id)?.pause(false);
                None
            }
            PageRequest::Pick { id, origin, direction, filter } => {
                let Some(ray) = ray(origin, direction) else {
                    return Some(failed(id, "the ray has no direction".to_owned()));
                };
                self.spawn_query(id, move || {
                    let ViewerScene { scene, model, .. } = &*viewer_scene;
                    let hit = query::pick(scene, model, &ray, &filter);
                    ServerMessage::Hit { id, hit: hit.map(Box::new) }
                })
            }
            PageRequest::Measure { id, leaves } => self.spawn_query(id, move || {
                let measures = viewer_scene.model.measures_of(&leaves);
                ServerMessage::Measures { id, measures }
            }),
            PageRequest::Save { id } => self.spawn_save(id),
        }
    }

    /// Prepares for requests about another scene.
    pub(crate) fn forget_scene(&self) {
        self.visible.forget();
    }

    /// Ends the stream; nothing of it is sent after this.
    pub(crate) async fn end_stream(&mut self) {
        if let Some(stream) = self.stream.take() {
            stream.stop().await;
        }
        self.outbox.clear();
    }

    /// The stream of the view `id`, if that is the current one.
    fn stream_of(&self, id: u32) -> Option<&Stream> {
        self.stream.as_ref().filter(|stream| stream.id() == id)
    }

    /// Lets a blocking thread find an answer; other requests are served meanwhile.
    fn spawn_query(
        &mut self,
        id: u32,
        query: impl FnOnce() -> ServerMessage + Send + 'static,
    ) -> Option<Message> {
        let message = answer(id, Arc::clone(&self.workers), move || text(&query()));
        self.spawn_answer(id, async move { QueryAnswer { message: message.await, _permits: Vec::new() } })
    }

    /// Lets a blocking thread write the picture of the current view once it is its turn.
    fn spawn_save(&mut self, id: u32) -> Option<Message> {
        if self.picture.get().is_none() {
            return Some(failed(id, NO_PICTURE.to_owned()));
        }
        let Ok(permit) = Arc::clone(&self.saves).try_acquire_owned() else {
            let message = format!("{MOST_SAVES} pictures are being saved; wait for one of them");
            return Some(failed(id, message));
        };
        let (turn, workers) = (Arc::clone(&self.save_turn), Arc::clone(&self.workers));
        let picture = Arc::clone(&self.picture);
        self.spawn_answer(id, async move {
            // Nothing closes the semaphore.
            let turn = turn.acquire_owned().await.ok();
            let message = answer(id, workers, move || written(id, &picture)).await;
            QueryAnswer { message, _permits: turn.into_iter().chain([permit]).collect() }
        })
    }

    /// Starts a task that answers a query, unless too many are open.
    fn spawn_answer(
        &mut self,
        id: u32,
        answer: impl Future<Output = QueryAnswer> + Send + 'static,
    ) -> Option<Message> {
        if self.answers.len() >= MOST_QUERIES {
            let message = format!("{MOST_QUERIES} queries are open; wait for one of their answers");
            return Some(failed(id, message));
        }
        self.answers.spawn(answer);
        None
    }

    fn stream_context(&self, viewer_scene: &ViewerScene) -> StreamContext {
        StreamContext {
            description: Arc::clone(&viewer_scene.description),
            scene: Arc::clone(&viewer_scene.scene),
            budget: viewer_scene.budget.clone(),
            visible: Arc::clone(&self.visible),
            outbox: Arc::clone(&self.outbox),
            picture: Arc::clone(&self.picture),
            processors: Arc::clone(&self.context.processors),
            denoiser: match &self.context.denoiser {
                Some(denoiser) => denoiser.clone(),
                None => Err("this server does not remove noise".to_owned()),
            },
        }
    }
}

/// Ends the building of a scene that nobody waits for when the page leaves.
impl Drop for PageService {
    fn drop(&mut self) {
        self.visible.abandon();
    }
}

/// A message as it is sent.
pub(crate) fn text(message: &ServerMessage) -> Message {
    Message::text(message.to_text())
}

/// The reply to a request that failed.
pub(crate) fn failed(id: u32, message: String) -> Message {
    text(&ServerMessage::Failed { id, message })
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
    query: impl FnOnce() -> Message + Send + 'static,
) -> Message {
    // Nothing closes the semaphore.
    let _permit = workers.acquire().await;
    spawn_blocking(query).await.unwrap_or_else(|error| failed(id, error.to_string()))
}

/// The picture so far as OpenEXR, as it is sent.
fn written(id: u32, picture: &LatestImage) -> Message {
    let Some(shot) = picture.get() else { return failed(id, NO_PICTURE.to_owned()) };
    let mut attributes = BTreeMap::from([("samplesPerPixel".to_owned(), shot.samples.to_string())]);
    if shot.is_denoised {
        attributes.insert("denoised".to_owned(), "true".to_owned());
    }
    match image::write(&shot.pixels, Format::Exr, &Tone::default(), &attributes) {
        Ok(bytes) => Message::binary(file(id, &bytes)),
        Err(error) => failed(id, error.to_string()),
    }
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
    text(&answer)
}

#[cfg(test)]
mod tests {
    use std::pin::pin;
    use std::task::{Context, Poll, Waker};

    use glanz_formats::Options;
    use glanz_light::Pixels;

    use super::*;

    const VIEW: &str = r#"{"type":"view","id":99,"camera":{"kind":"perspective","position":[0,0,5],"right":[1,0,0],"up":[0,1,0],"forward":[0,0,-1],"fieldOfView":1,"height":1,"distance":5},"size":[4,3],"integrator":"path"}"#;

    /// The reply to a request whose service must not wait for anything.
    fn reply(service: &mut PageService, request: &str, scene: &Arc<ViewerScene>) -> Option<Message> {
        let request = PageRequest::parse(request).unwrap();
        match pin!(service.serve(request, scene)).poll(&mut Context::from_waker(Waker::noop())) {
            Poll::Ready(reply) => reply,
            Poll::Pending => panic!("the service waits"),
        }
    }

    fn ball() -> Arc<ViewerScene> {
        let folder = tempfile::TempDir::new().unwrap();
        let path = folder.path().join("ball.pbrt");
        let text = "Camera \"perspective\"\nWorldBegin\nLightSource \"infinite\"\nShape \"sphere\"\n";
        std::fs::write(&path, text).unwrap();
        Arc::new(ViewerScene::read(&path, &Options::default(), None).unwrap_or_else(|d| panic!("{d}")))
    }

    #[test]
    fn view_does_not_wait_for_saves_of_the_view_before() {
        let scene = ball();
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
        runtime.block_on(async {
            let mut service = PageService::new(ServiceContext::new(IntegratorName::Path, 1, None));
            let pixels = Pixels::try_from_rgb(2, 1, &[[0.5; 3]; 2]).unwrap();
            service.picture.set(Arc::new(pixels), 7);
            for id in 0..MOST_SAVES {
                let save = format!(r#"{{"type":"save","id":{id}}}"#);
                assert_eq!(reply(&mut service, &save, &scene), None);
            }
            let refused = reply(&mut service, r#"{"type":"save","id":50}"#, &scene);
            let sentence = format!("{MOST_SAVES} pictures are being saved; wait for one of them");
            assert_eq!(refused, Some(failed(50, sentence)));
            assert_eq!(reply(&mut service, VIEW, &scene), None);
            // The new view has no picture, but those that wait keep theirs.
            let refused = reply(&mut service, r#"{"type":"save","id":51}"#, &scene);
            assert_eq!(refused, Some(failed(51, NO_PICTURE.to_owned())));
            let (mut saved, mut tiles) = (Vec::new(), 0);
            while saved.len() < MOST_SAVES || tiles == 0 {
                let bytes = match service.next().await {
                    Message::Binary(bytes) => bytes,
                    Message::Text(text) if text.as_str().contains("progress") => continue,
                    other => panic!("{other:?}"),
                };
                if bytes[0] == 1 {
                    tiles += 1;
                    continue;
                }
                let read = image::read(&bytes[8..], None, image::Encoding::Linear).unwrap();
                assert_eq!((read.pixels.width(), read.pixels.height()), (2, 1));
                assert_eq!(read.attributes.get("samplesPerPixel").map(String::as_str), Some("7"));
                saved.push(usize::from(bytes[4]));
            }
            saved.sort_unstable();
            assert_eq!(saved, (0..MOST_SAVES).collect::<Vec<_>>());
            assert_eq!(service.saves.available_permits(), MOST_SAVES);
            service.end_stream().await;
        });
    }
}
