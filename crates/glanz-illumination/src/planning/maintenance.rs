//! The maintenance factor of an installation.

/// Factor by which light diminishes until maintenance, in (0, 1].
///
/// # Source
/// @cie97, which was not available: the names and the product are common knowledge of the field. The values are those of the maker and of the schedule of
/// maintenance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MaintenanceFactor {
    /// One number.
    Whole(f64),
    /// The product of four parts, each in (0, 1].
    Parts {
        /// Lamp lumen maintenance factor (LLMF): flux of an old lamp over that of a new one.
        lamp_lumens: f64,
        /// Lamp survival factor (LSF): share of the lamps that burn; 1 if failed ones are replaced at once.
        lamp_survival: f64,
        /// Luminaire maintenance factor (LMF): dirt on luminaires.
        luminaire: f64,
        /// Room surface maintenance factor (RSMF): dirt on walls, ceiling and floor.
        room_surfaces: f64,
    },
}

/// A maintenance factor is out of range.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("{factor} is {value}; a maintenance factor is above 0 and at most 1")]
pub struct MaintenanceError {
    /// The factor.
    pub factor: &'static str,
    /// Its value.
    pub value: f64,
}

impl Default for MaintenanceFactor {
    /// A new installation: 1.
    fn default() -> Self {
        Self::Whole(1.0)
    }
}

impl MaintenanceFactor {
    /// The factor.
    ///
    /// # Errors
    /// [`MaintenanceError`] for a factor or part that is not in (0, 1].
    pub fn value(&self) -> Result<f64, MaintenanceError> {
        let parts = match *self {
            Self::Whole(value) => vec![("MF", value)],
            Self::Parts { lamp_lumens, lamp_survival, luminaire, room_surfaces } => {
                vec![
                    ("LLMF", lamp_lumens),
                    ("LSF", lamp_survival),
                    ("LMF", luminaire),
                    ("RSMF", room_surfaces),
                ]
            }
        };
        match parts.iter().find(|(_, value)| !(*value > 0.0 && *value <= 1.0)) {
            Some(&(factor, value)) => Err(MaintenanceError { factor, value }),
            None => Ok(parts.iter().map(|(_, value)| value).product()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factor_is_the_product_of_its_parts_and_faults_have_their_names() {
        let of = |luminaire| MaintenanceFactor::Parts {
            lamp_lumens: 0.9,
            lamp_survival: 1.0,
            luminaire,
            room_surfaces: 0.94,
        };
        assert!((of(0.95).value().unwrap() - 0.8037).abs() < 1e-12);
        for value in [0.0, -0.5, 1.1, f64::NAN] {
            let error = of(value).value().unwrap_err().to_string();
            assert!(error.starts_with("LMF is "), "{error}");
            assert!(MaintenanceFactor::Whole(value).value().unwrap_err().to_string().starts_with("MF is "));
        }
        assert_eq!(MaintenanceFactor::default().value(), Ok(1.0));
    }
}
