//! Luminaires for tests.

use std::sync::Arc;

use glanz_light::intensity::{AngularSystem, IntensityDistribution, LuminousOpening, OpeningShape, Symmetry};
use glanz_math::{DMat3, DVec3};

use super::PlacedLuminaire;

/// Rotationally symmetric, candela at angles gamma in degrees.
pub(crate) fn of_gamma(gammas: Vec<f64>, candela: Vec<f64>) -> Arc<IntensityDistribution> {
    Arc::new(
        IntensityDistribution::try_new(AngularSystem::C, Symmetry::Axial, &[0.0], gammas, candela).unwrap(),
    )
}

/// The same candela in all directions.
pub(crate) fn uniform(candela: f64) -> Arc<IntensityDistribution> {
    of_gamma(vec![0.0, 180.0], vec![candela; 2])
}

/// Candela times the cosine of gamma, in steps of a quarter of a degree.
pub(crate) fn lambertian(candela: f64) -> Arc<IntensityDistribution> {
    let gammas: Vec<f64> = (0..=360).map(|i| 0.25 * f64::from(i)).collect();
    let values = gammas.iter().map(|gamma: &f64| candela * gamma.to_radians().cos().max(0.0)).collect();
    of_gamma(gammas, values)
}

/// With an opening of 0.6 m x 0.6 m that faces down.
pub(crate) fn downlight(distribution: Arc<IntensityDistribution>, position: DVec3) -> PlacedLuminaire {
    PlacedLuminaire {
        name: "luminaire 1".to_owned(),
        description: None,
        distribution,
        factor: 1.0,
        opening: LuminousOpening { shape: OpeningShape::Rectangle, size: [0.6, 0.6, 0.0] },
        position,
        axes: DMat3::IDENTITY,
    }
}
