//! The scattering models, one file each.

mod conductor;
mod dielectric;
mod lambert;
mod mirror;
pub mod phong;

pub use conductor::Conductor;
pub use dielectric::Dielectric;
pub use lambert::Lambert;
pub use mirror::Mirror;
pub use phong::Phong;
