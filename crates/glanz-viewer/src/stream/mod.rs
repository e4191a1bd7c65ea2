//! Progressive rendering of the view of a page.
//!
//! A page requests a view ([`RenderRequest`]): a camera, a size, an integrator, and the hidden leaves. A [`Stream`] renders it in passes, until
//! it has [`MAX_SAMPLES`] or is stopped, and puts tiles and progress into the [`Outbox`] of the page. There a new version of a tile replaces
//! the one before it: a slow page misses passes, but neither delays the render nor accumulates messages.
//!
//! Where a page asks for it, a [`ViewDenoiser`] removes the noise of the image at every doubling of its samples, beside the render (`denoising`). From the
//! first denoised image on, tiles with noise are no longer sent.
//!
//! All streams share the [`Processors`]: a few render at a time, the others wait for their turn. A stopped stream ends within a sample, a
//! paused one keeps its film and renders nothing after the current pass; after a long pause it fails, so that its film is free for others.

mod camera;
mod cancel;
mod denoiser;
mod denoising;
mod latest_image;
mod noise;
mod outbox;
mod processors;
mod request;
mod run;
mod tile;
mod time_slice;
mod visible_scene;

pub use camera::{ViewCamera, ViewCameraError, ViewCameraKind};
pub use denoiser::{SharedDenoiser, ViewDenoiser};
pub use latest_image::LatestImage;
pub(crate) use outbox::OutboxMessage;
pub use outbox::{Outbox, StreamStatus};
pub use processors::Processors;
pub use request::{IntegratorName, MAX_SAMPLES, MAX_SIDE, RenderRequest, RenderRequestError};
pub use run::{Stream, StreamContext};
pub(crate) use tile::file;
pub use visible_scene::VisibleScene;
