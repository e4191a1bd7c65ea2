//! How much light a luminaire sends in which direction: candela over directions.
//!
//! [`Distribution`] holds intensities as a goniophotometer measures them, [`Opening`] the size of what shines. Readers of photometric files fill
//! them, lights of scenes send what they say.
//!
//! # The luminaire's frame
//!
//! Right-handed, z up, origin in the photometric centre; a luminaire mounted as usual shines towards -z.
//!
//! | type | angles | direction |
//! |---|---|---|
//! | C | gamma from -z, C about z from +x to +y | (sin g cos C, sin g sin C, -cos g) |
//! | A | V up from the horizontal, H clockwise seen from above | (cos V cos H, -cos V sin H, sin V) |
//! | B | V about y from -z to +x, H out of the plane of V towards -y | (cos H sin V, -sin H, -cos H cos V) |
//!
//! ```
//! use glanz_light::intensity::{AngularSystem, Distribution, Symmetry};
//! use glanz_math::DVec3;
//!
//! // 100 cd straight down, 0 at the horizontal, alike all round.
//! let (polars, candela) = (vec![0.0, 90.0], vec![100.0, 0.0]);
//! let lamp = Distribution::try_new(AngularSystem::C, Symmetry::Axial, &[0.0], polars, candela)?;
//! assert_eq!(lamp.intensity(DVec3::NEG_Z), 100.0);
//! assert!((lamp.intensity(DVec3::new(1.0, 0.0, -1.0)) - 50.0).abs() < 1e-12);
//! # Ok::<(), glanz_light::intensity::IntensityError>(())
//! ```

mod distribution;
mod opening;
mod pick;

pub use distribution::{AngularSystem, Distribution, IntensityError, Symmetry};
pub use opening::{Opening, OpeningShape};
