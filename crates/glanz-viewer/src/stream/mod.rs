//! Progressive rendering of what a page looks at.
//!
//! A page orders a view ([`Order`]): a camera, a size, an integrator, and what is hidden. A [`Stream`] renders it in passes, until it has
//! [`MAX_SAMPLES`] or is stopped, and puts tiles and progress into the [`Outbox`] of the page. There the newest of every tile replaces the
//! one before it: a page that is slow to fetch misses passes, and neither holds up the render nor lets anything pile up.
//!
//! All streams share the [`Processors`]: a few render at a time, the others wait for their turn. A stream that is stopped gives up within
//! a sample.

mod camera;
mod cancel;
mod exposure;
mod noise;
mod order;
mod outbox;
mod picture;
mod processors;
mod run;
mod tile;
mod visible;

pub use camera::{ViewCamera, ViewCameraError, ViewCameraKind};
pub use order::{IntegratorName, MAX_SAMPLES, MAX_SIDE, Order, OrderError};
pub(crate) use outbox::Parcel;
pub use outbox::{Outbox, Status};
pub use picture::Picture;
pub use processors::Processors;
pub use run::{Stream, Surroundings};
pub(crate) use tile::file;
pub use visible::Visible;
