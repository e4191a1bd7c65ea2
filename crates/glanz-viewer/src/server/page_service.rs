//! Answers to the requests of a page about its scene: views, hits, measures, files.

use std::collections::BTreeMap;
use std::sync::Arc;

use axum::extract::ws::Message;
use glanz_formats::image::{self, Format};
use glanz_light::Tone;
use glanz_math::{DVec3, Ray};
use tokio::sync::Semaphore;
use tokio::task::{JoinSet, spawn_blocking};

use super::message::{PageRequest, ProgressMessage, ServerMessage};
use super::viewer_scene::ViewerScene;
use crate::query;
use crate::stream::{
    ImageSnapshot, IntegratorName, LatestImage, Outbox, OutboxMessage, Processors, RenderRequest,
    SharedDenoiser, Stream, StreamContext, StreamStatus, ViewDenoiser, VisibleScene, file,
};

/// Largest number of queries of a page that are worked on at a time.
const MOST_WORKERS: usize = 4;

/// Largest number of queries of a page that are worked on or wait for it.
const MOST_QUERIES: usize = 64;

/// Largest number of pictures of a page that are saved or wait for it: each keeps its pixels in memory.
const MOST_SAVES: usize = 4;

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

/// Service of one page: its stream, and its queries.
#[derive(Debug)]
pub(crate) struct PageService {
    context: ServiceContext,
    outbox: Arc<Outbox>,
    picture: Arc<LatestImage>,
    visible: Arc<VisibleScene>,
    stream: Option<Stream>,
    /// Answers to come: areas, volumes and files of pictures may take seconds, and nothing else waits for them.
    answers: JoinSet<Message>,
    workers: Arc<Semaphore>,
    saves: Arc<Semaphore>,
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
        }
    }

    /// Waits for the next message about views and queries.
    pub(crate) async fn next(&mut self) -> Message {
        tokio::select! {
            biased;
            Some(Ok(answer)) = self.answers.join_next() => answer,
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
                self.picture.clear();
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
                    text(&ServerMessage::Hit { id, hit: hit.map(Box::new) })
                })
            }
            PageRequest::Measure { id, leaves } => self.spawn_query(id, move || {
                let measures = viewer_scene.model.measures_of(&leaves);
                text(&ServerMessage::Measures { id, measures })
            }),
            PageRequest::Save { id } => {
                let Some(shot) = self.picture.get() else {
                    return Some(failed(id, "there is no picture yet".to_owned()));
                };
                let Ok(permit) = Arc::clone(&self.saves).try_acquire_owned() else {
                    let message = format!("{MOST_SAVES} pictures are being saved; wait for one of them");
                    return Some(failed(id, message));
                };
                self.spawn_query(id, move || {
                    let _permit = permit;
                    saved(id, shot)
                })
            }
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
    fn spawn_query(&mut self, id: u32, query: impl FnOnce() -> Message + Send + 'static) -> Option<Message> {
        if self.answers.len() >= MOST_QUERIES {
            let message = format!("{MOST_QUERIES} queries are open; wait for one of their answers");
            return Some(failed(id, message));
        }
        self.answers.spawn(answer(id, Arc::clone(&self.workers), query));
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
    match spawn_blocking(query).await {
        Ok(answer) => answer,
        Err(error) => failed(id, error.to_string()),
    }
}

/// A picture as OpenEXR, as it is sent.
fn saved(id: u32, shot: ImageSnapshot) -> Message {
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
    use glanz_formats::Options;
    use glanz_light::Pixels;

    use super::*;

    #[test]
    fn pictures_that_are_saved_hold_up_nothing_and_are_few_at_a_time() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.pbrt");
        std::fs::write(&path, "WorldBegin\nShape \"sphere\"\n").unwrap();
        let scene = Arc::new(ViewerScene::read(&path, &Options::default(), None).unwrap());
        let runtime = tokio::runtime::Builder::new_current_thread().build().unwrap();
        runtime.block_on(async {
            let mut service = PageService::new(ServiceContext::new(IntegratorName::Path, 1, None));
            let refusal = |id, reason: &str| Some(failed(id, reason.to_owned()));
            let reply = service.serve(PageRequest::Save { id: 1 }, &scene).await;
            assert_eq!(reply, refusal(1, "there is no picture yet"));
            service.picture.set(Arc::new(Pixels::try_from_rgb(1, 1, &[[0.5; 3]]).unwrap()), 1);
            // While no worker is free nothing is written, and requests are answered all the same.
            let workers = Arc::clone(&service.workers).acquire_many_owned(MOST_WORKERS as u32).await;
            for id in 0..MOST_SAVES as u32 {
                assert_eq!(service.serve(PageRequest::Save { id }, &scene).await, None);
            }
            let reply = service.serve(PageRequest::Save { id: 9 }, &scene).await;
            assert_eq!(reply, refusal(9, "4 pictures are being saved; wait for one of them"));
            let reply = service.serve(PageRequest::Stop { id: 10 }, &scene).await;
            assert_eq!(reply, Some(text(&ServerMessage::Stopped { id: 10 })));
            drop(workers);
            for _ in 0..MOST_SAVES {
                assert!(matches!(service.next().await, Message::Binary(_)));
            }
            assert_eq!(service.serve(PageRequest::Save { id: 11 }, &scene).await, None);
        });
    }
}
