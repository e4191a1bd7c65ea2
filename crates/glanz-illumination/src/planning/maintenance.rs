//! The maintenance factor of an installation.

/// Factors by which light diminishes until maintenance, each in (0, 1].
///
/// # Source
/// @cie97, which was not available: the names and the product are common knowledge of the field. The values are those of the maker and the schedule of maintenance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MaintenanceFactors {
    /// Lamp lumen maintenance factor (LLMF): flux of an old lamp over that of a new one.
    pub lamp_lumens: f64,
    /// Lamp survival factor (LSF): share of the lamps that burn; 1 if failed ones are replaced at once.
    pub lamp_survival: f64,
    /// Luminaire maintenance factor (LMF): dirt on luminaires.
    pub luminaire: f64,
    /// Room surface maintenance factor (RMF): dirt on walls, ceiling and floor.
    pub room_surfaces: f64,
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

impl Default for MaintenanceFactors {
    /// A new installation: all 1.
    fn default() -> Self {
        Self { lamp_lumens: 1.0, lamp_survival: 1.0, luminaire: 1.0, room_surfaces: 1.0 }
    }
}

impl MaintenanceFactors {
    /// The product of its parts.
    ///
    /// # Errors
    /// [`MaintenanceError`] for a part that is not in (0, 1].
    pub fn product(&self) -> Result<f64, MaintenanceError> {
        let parts = [
            ("LLMF", self.lamp_lumens),
            ("LSF", self.lamp_survival),
            ("LMF", self.luminaire),
            ("RMF", self.room_surfaces),
        ];
        match parts.into_iter().find(|(_, value)| !(*value > 0.0 && *value <= 1.0)) {
            Some((factor, value)) => Err(MaintenanceError { factor, value }),
            None => Ok(parts.iter().map(|(_, value)| value).product()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn product_of_the_parts_and_faults_with_their_names() {
        let factors =
            MaintenanceFactors { lamp_lumens: 0.9, lamp_survival: 1.0, luminaire: 0.95, room_surfaces: 0.94 };
        assert!((factors.product().unwrap() - 0.8037).abs() < 1e-12);
        for value in [0.0, -0.5, 1.1, f64::NAN] {
            let error = MaintenanceFactors { luminaire: value, ..factors }.product().unwrap_err();
            assert!(error.to_string().starts_with("LMF is "), "{error}");
        }
    }
}
