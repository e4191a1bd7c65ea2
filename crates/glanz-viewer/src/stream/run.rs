//! A view being rendered.

use std::pin::pin;
use std::sync::Arc;
use std::time::Duration;

use glanz_job::ResourceBudget;
use glanz_scene::{Description, Scene};
use glanz_transport::RenderError;
use tokio::sync::watch;
use tokio::task::{JoinHandle, spawn_blocking};
use tokio::time::timeout;

use super::cancel::StreamCancel;
use super::denoiser::SharedDenoiser;
use super::denoising::ViewDenoising;
use super::latest_image::LatestImage;
use super::outbox::{Outbox, StreamStatus};
use super::processors::{ProcessorShare, Processors};
use super::request::{RenderRequest, RenderRequestError};
use super::time_slice::{StreamView, TimeSlice, is_done};
use super::visible_scene::VisibleScene;

/// Longest pause of a view, whose film takes memory from those of other pages. Pages give their image up earlier.
const LONGEST_PAUSE: Duration = Duration::from_secs(90);

/// Context of a stream: data of its page and of the server.
#[derive(Clone, Debug)]
pub struct StreamContext {
    /// The scene that the page shows, as it was described.
    pub description: Arc<Description>,
    /// The resolved scene.
    pub scene: Arc<Scene>,
    /// Budget of the scene, with the memory of reading and resolving it.
    pub budget: ResourceBudget,
    /// Cache of the scene without hidden leaves.
    pub visible: Arc<VisibleScene>,
    /// Target of tiles and status.
    pub outbox: Arc<Outbox>,
    /// Target of the latest image.
    pub picture: Arc<LatestImage>,
    /// Shared with all streams.
    pub processors: Arc<Processors>,
    /// The denoiser of the server, or the reason why there is none.
    pub denoiser: Result<Arc<SharedDenoiser>, String>,
}

/// A view that is rendered until it is done, stopped or dropped.
#[derive(Debug)]
pub struct Stream {
    id: u32,
    cancel: Arc<StreamCancel>,
    pause: watch::Sender<bool>,
    task: JoinHandle<()>,
}

impl Stream {
    /// Starts to render `request`; must be called within a tokio runtime.
    ///
    /// # Errors
    /// [`RenderRequestError::Size`], [`RenderRequestError::Camera`], [`RenderRequestError::Denoiser`]. Later errors are reported as [`StreamStatus::Failed`].
    pub fn start(request: RenderRequest, context: StreamContext) -> Result<Self, RenderRequestError> {
        request.check()?;
        let denoiser = match (request.denoise, &context.denoiser) {
            (false, _) => None,
            (true, Ok(denoiser)) => Some(Arc::clone(denoiser)),
            (true, Err(reason)) => return Err(RenderRequestError::Denoiser(reason.clone())),
        };
        let id = request.id;
        let cancel = Arc::new(StreamCancel::default());
        let (pause, paused) = watch::channel(false);
        let task = tokio::spawn({
            let cancel = Arc::clone(&cancel);
            async move {
                let outbox = Arc::clone(&context.outbox);
                if let Err(Stop::Failed(message)) = render(request, context, denoiser, cancel, paused).await {
                    outbox.put_status(id, StreamStatus::Failed(message));
                }
            }
        });
        Ok(Self { id, cancel, pause, task })
    }

    /// The id of its view.
    #[must_use]
    pub fn id(&self) -> u32 {
        self.id
    }

    /// Pauses the stream after the current pass, or resumes it.
    pub fn pause(&self, is_paused: bool) {
        self.pause.send_replace(is_paused);
    }

    /// Ends the stream. After this returns, it adds nothing to the outbox.
    pub async fn stop(mut self) {
        self.cancel.cancel();
        // The task has no result.
        let _ = (&mut self.task).await;
    }
}

/// Ends the stream when its page disconnects.
impl Drop for Stream {
    fn drop(&mut self) {
        self.cancel.cancel();
    }
}

/// Reasons for the early end of a stream.
enum Stop {
    /// It was cancelled.
    Interrupted,
    /// It failed.
    Failed(String),
}

impl<E: std::error::Error> From<E> for Stop {
    fn from(error: E) -> Self {
        Self::Failed(error.to_string())
    }
}

/// Waits for `next` or for cancellation.
async fn unless_cancelled<T>(cancel: &StreamCancel, next: impl Future<Output = T>) -> Result<T, Stop> {
    tokio::select! {
        biased;
        () = cancel.cancelled() => Err(Stop::Interrupted),
        value = next => Ok(value),
    }
}

/// Renders a view, and removes its noise if there is a `denoiser`.
async fn render(
    request: RenderRequest,
    context: StreamContext,
    denoiser: Option<Arc<SharedDenoiser>>,
    cancel: Arc<StreamCancel>,
    paused: watch::Receiver<bool>,
) -> Result<(), Stop> {
    let StreamContext { description, scene, budget, visible, outbox, picture, processors, .. } = context;
    let id = request.id;
    let plan = request.plan(&description, processors.threads())?;
    let _memory: Option<ProcessorShare> = match processors.try_film(request.pixels()) {
        Some(share) => Some(share),
        None => {
            outbox.put_status(id, StreamStatus::Waiting);
            unless_cancelled(&cancel, processors.film(request.pixels())).await?
        }
    };
    let visible_scene = visible.scene(scene, description, request.hidden, budget.for_next_step());
    let scene = unless_cancelled(&cancel, visible_scene).await??;
    let film = plan.film()?;
    let scene = scene.with_camera(plan.camera.clone());
    let integrator = plan.integrator.build();
    let (denoising, noisy) = denoiser
        .map(|denoiser| {
            let (cancel, outbox, picture) = (Arc::clone(&cancel), Arc::clone(&outbox), Arc::clone(&picture));
            ViewDenoising::new(id, processors.threads(), denoiser, cancel, outbox, picture)
        })
        .unzip();
    let view = StreamView {
        id,
        scene,
        plan,
        integrator,
        cancel: Arc::clone(&cancel),
        paused,
        outbox,
        picture,
        processors,
        noisy,
    };
    let rendering = render_slices(view, TimeSlice { film, seconds: 0.0 });
    match denoising {
        Some(denoising) => render_denoised(rendering, denoising, &cancel).await,
        None => rendering.await,
    }
}

/// Renders and denoises side by side. A stream that is cancelled does not wait for the denoiser.
async fn render_denoised(
    rendering: impl Future<Output = Result<(), Stop>>,
    denoising: ViewDenoising,
    cancel: &StreamCancel,
) -> Result<(), Stop> {
    let (mut rendering, mut denoising) = (pin!(rendering), pin!(denoising.run()));
    tokio::select! {
        biased;
        rendered = &mut rendering => {
            if rendered.is_err() {
                cancel.cancel();
            }
            rendered?;
            unless_cancelled(cancel, denoising).await?.map_err(Stop::Failed)
        }
        denoised = &mut denoising => {
            if denoised.is_err() {
                cancel.cancel();
            }
            let rendered = rendering.await;
            denoised.map_err(Stop::Failed).and(rendered)
        }
    }
}

/// Waits while the view is paused, at most for the time `longest`.
async fn resumed(paused: &mut watch::Receiver<bool>, longest: Duration) -> Result<(), Stop> {
    let resumed = async {
        // An error if the stream is dropped, which is cancelled then.
        let _ = paused.wait_for(|is_paused| !is_paused).await;
    };
    let waited = timeout(longest, resumed).await;
    waited.map_err(|_| Stop::Failed("the view was paused for too long; begin it again".to_owned()))
}

/// Renders a view in time slices.
async fn render_slices(view: StreamView, mut slice: TimeSlice) -> Result<(), Stop> {
    let view = Arc::new(view);
    let mut paused = view.paused.clone();
    while !is_done(&slice.film) {
        unless_cancelled(&view.cancel, resumed(&mut paused, LONGEST_PAUSE)).await??;
        let permit = match view.processors.try_permit() {
            Some(permit) => Some(permit),
            None => {
                view.outbox.put_status(view.id, StreamStatus::Waiting);
                unless_cancelled(&view.cancel, view.processors.permit()).await?
            }
        };
        // Awaited even when cancelled, so that its threads end before the stream does.
        let rendered = spawn_blocking({
            let view = Arc::clone(&view);
            move || view.run_time_slice(slice)
        });
        slice = match rendered.await? {
            Ok(slice) => slice,
            Err(RenderError::Interrupted(_)) => return Err(Stop::Interrupted),
            Err(error) => return Err(error.into()),
        };
        drop(permit);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pause_ends_when_it_is_too_long() {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_time().build().unwrap();
        runtime.block_on(async {
            let (pause, mut paused) = watch::channel(true);
            let ended = resumed(&mut paused, Duration::from_millis(5)).await;
            assert!(matches!(ended, Err(Stop::Failed(message)) if message.contains("begin it again")));
            pause.send_replace(false);
            assert!(resumed(&mut paused, Duration::from_secs(60)).await.is_ok());
        });
    }
}
