//! A view being rendered.

use std::sync::Arc;

use glanz_scene::{Description, Scene};
use glanz_transport::RenderError;
use tokio::task::{JoinHandle, spawn_blocking};

use super::cancel::StreamCancel;
use super::latest_image::LatestImage;
use super::outbox::{Outbox, StreamStatus};
use super::processors::{ProcessorShare, Processors};
use super::request::{RenderRequest, RenderRequestError};
use super::time_slice::{StreamView, TimeSlice, is_done};
use super::visible_scene::VisibleScene;

/// Context of a stream: data of its page and of the server.
#[derive(Clone, Debug)]
pub struct StreamContext {
    /// The scene that the page shows, as it was described.
    pub description: Arc<Description>,
    /// The resolved scene.
    pub scene: Arc<Scene>,
    /// Cache of the scene without hidden leaves.
    pub visible: Arc<VisibleScene>,
    /// Target of tiles and status.
    pub outbox: Arc<Outbox>,
    /// Target of the latest image.
    pub picture: Arc<LatestImage>,
    /// Shared with all streams.
    pub processors: Arc<Processors>,
}

/// A view that is rendered until it is done, stopped or dropped.
#[derive(Debug)]
pub struct Stream {
    id: u32,
    cancel: Arc<StreamCancel>,
    task: JoinHandle<()>,
}

impl Stream {
    /// Begins to render `order`; to be called within a runtime of tokio.
    ///
    /// # Errors
    /// [`RenderRequestError::Size`], [`RenderRequestError::Camera`]. What is found out later becomes [`StreamStatus::Failed`].
    pub fn start(order: RenderRequest, surroundings: StreamContext) -> Result<Self, RenderRequestError> {
        order.check()?;
        let id = order.id;
        let cancel = Arc::new(StreamCancel::default());
        let task = tokio::spawn({
            let cancel = Arc::clone(&cancel);
            async move {
                let outbox = Arc::clone(&surroundings.outbox);
                if let Err(Stop::Failed(message)) = carry_out(order, surroundings, cancel).await {
                    outbox.put_status(id, StreamStatus::Failed(message));
                }
            }
        });
        Ok(Self { id, cancel, task })
    }

    /// The number of its view.
    #[must_use]
    pub fn id(&self) -> u32 {
        self.id
    }

    /// Ends it. When this returns, nothing more comes into the outbox.
    pub async fn stop(mut self) {
        self.cancel.cancel();
        // The task has nothing to give back.
        let _ = (&mut self.task).await;
    }
}

/// A page that leaves takes its stream with it.
impl Drop for Stream {
    fn drop(&mut self) {
        self.cancel.cancel();
    }
}

/// Reasons for the early end of a stream.
enum Stop {
    /// It was cancelled.
    Interrupted,
    /// It cannot go on.
    Failed(String),
}

impl<E: std::error::Error> From<E> for Stop {
    fn from(error: E) -> Self {
        Self::Failed(error.to_string())
    }
}

/// Waits for what comes next, or for the wish to end.
async fn unless<T>(cancel: &StreamCancel, next: impl Future<Output = T>) -> Result<T, Stop> {
    tokio::select! {
        biased;
        () = cancel.cancelled() => Err(Stop::Interrupted),
        value = next => Ok(value),
    }
}

/// Renders a view turn by turn.
async fn carry_out(
    order: RenderRequest,
    surroundings: StreamContext,
    cancel: Arc<StreamCancel>,
) -> Result<(), Stop> {
    let StreamContext { description, scene, visible, outbox, picture, processors } = surroundings;
    let id = order.id;
    let plan = order.plan(&description, processors.threads())?;
    let _memory: Option<ProcessorShare> = match processors.try_film(order.pixels()) {
        Some(share) => Some(share),
        None => {
            outbox.put_status(id, StreamStatus::Waiting);
            unless(&cancel, processors.film(order.pixels())).await?
        }
    };
    let scene = unless(&cancel, visible.scene(scene, description, order.hidden)).await??;
    let film = plan.film()?;
    let scene = scene.with_camera(plan.camera.clone());
    let integrator = plan.integrator.build();
    let view = StreamView { id, scene, plan, integrator, cancel, outbox, picture, processors };
    let (view, mut turn) = (Arc::new(view), TimeSlice { film, seconds: 0.0 });
    while !is_done(&turn.film) {
        let place = match view.processors.try_place() {
            Some(place) => Some(place),
            None => {
                view.outbox.put_status(id, StreamStatus::Waiting);
                unless(&view.cancel, view.processors.place()).await?
            }
        };
        // Not left alone when it is cancelled: its threads are gone before the stream is.
        let taken = spawn_blocking({
            let view = Arc::clone(&view);
            move || view.run_time_slice(turn)
        });
        turn = match taken.await? {
            Ok(turn) => turn,
            Err(RenderError::Interrupted(_)) => return Err(Stop::Interrupted),
            Err(error) => return Err(error.into()),
        };
        drop(place);
    }
    Ok(())
}
