//! Luminous intensity of luminaires, candela over directions.
//!
//! [`IntensityDistribution`] holds intensities as a goniophotometer measures them, [`LuminousOpening`] the shape and size of the
//! light-emitting part. Readers of photometric files make both, photometric lights of scenes emit by them.
//!
//! # The luminaire's frame
//!
//! Right-handed, z up, origin in the photometric centre; a ceiling luminaire shines towards -z.
//!
//! | type | angles | direction |
//! |---|---|---|
//! | C | gamma from -z, C about z from +x to +y | (sin g cos C, sin g sin C, -cos g) |
//! | A | V up from the horizontal, H clockwise seen from above | (cos V cos H, -cos V sin H, sin V) |
//! | B | V about y from -z to +x, H out of the plane of V towards -y | (cos H sin V, -sin H, -cos H cos V) |
//!
//! ```
//! use glanz_light::intensity::{AngularSystem, IntensityDistribution, Symmetry};
//! use glanz_math::DVec3;
//!
//! // 100 cd straight down, 0 at the horizontal, rotationally symmetric.
//! let (polars, candela) = (vec![0.0, 90.0], vec![100.0, 0.0]);
//! let luminaire = IntensityDistribution::try_new(AngularSystem::C, Symmetry::Axial, &[0.0], polars, candela)?;
//! assert_eq!(luminaire.intensity(DVec3::NEG_Z), 100.0);
//! assert!((luminaire.intensity(DVec3::new(1.0, 0.0, -1.0)) - 50.0).abs() < 1e-12);
//! # Ok::<(), glanz_light::intensity::IntensityError>(())
//! ```

mod beam;
mod distribution;
mod opening;
mod sample;

pub use beam::Beam;
pub use distribution::{AngularSystem, IntensityDistribution, IntensityError, Symmetry, zonal_integral};
pub use opening::{LuminousOpening, OpeningShape};
