//! Progressive rendering of what a page looks at.
//!
//! A page orders a view ([`RenderRequest`]): a camera, a size, an integrator, and what is hidden. A [`Stream`] renders it in passes, until it has
//! [`MAX_SAMPLES`] or is stopped, and puts tiles and progress into the [`Outbox`] of the page. There the newest of every tile replaces the
//! one before it: a page that is slow to fetch misses passes, and neither holds up the render nor lets anything pile up.
//!
//! All streams share the [`Processors`]: a few render at a time, the others wait for their turn. A stream that is stopped gives up within
//! a sample.

mod camera;
mod cancel;
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
pub use latest_image::LatestImage;
pub(crate) use outbox::OutboxMessage;
pub use outbox::{Outbox, StreamStatus};
pub use processors::Processors;
pub use request::{IntegratorName, MAX_SAMPLES, MAX_SIDE, RenderRequest, RenderRequestError};
pub use run::{Stream, StreamContext};
pub(crate) use tile::file;
pub use visible_scene::VisibleScene;
