//! Balance of the flux that the lights emit.

use serde::ser::{Serialize, SerializeStruct, Serializer};

/// Emitted flux and where it ended, in lumens, none below zero.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FluxBalance {
    /// Emitted flux.
    pub emitted: f64,
    /// Flux absorbed by receivers.
    pub absorbed_by_receivers: f64,
    /// Flux absorbed by other surfaces.
    pub absorbed_elsewhere: f64,
    /// Flux that left the scene.
    pub escaped: f64,
    /// Flux of paths that were cut off at the largest number of reflections or undecided.
    pub given_up: f64,
}

impl FluxBalance {
    /// The parts of the balance with their names, lm.
    #[must_use]
    pub fn ends(&self) -> [(&'static str, f64); 4] {
        [
            ("absorbed by receivers", self.absorbed_by_receivers),
            ("absorbed elsewhere", self.absorbed_elsewhere),
            ("escaped", self.escaped),
            ("given up", self.given_up),
        ]
    }

    /// Error of the balance as a fraction of the emitted flux: 0 if exact, infinity if light ends but none is emitted.
    #[must_use]
    pub fn closes_to(&self) -> f64 {
        let missing = (self.emitted - self.ends().iter().map(|(_, lumens)| lumens).sum::<f64>()).abs();
        if missing == 0.0 { 0.0 } else { missing / self.emitted }
    }
}

/// The fields with `_lm` behind their names, and `closes_to`.
impl Serialize for FluxBalance {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut fields = serializer.serialize_struct("FluxBalance", 6)?;
        fields.serialize_field("emitted_lm", &self.emitted)?;
        fields.serialize_field("absorbed_by_receivers_lm", &self.absorbed_by_receivers)?;
        fields.serialize_field("absorbed_elsewhere_lm", &self.absorbed_elsewhere)?;
        fields.serialize_field("escaped_lm", &self.escaped)?;
        fields.serialize_field("given_up_lm", &self.given_up)?;
        fields.serialize_field("closes_to", &self.closes_to())?;
        fields.end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn imbalance_is_a_fraction_of_the_emitted_flux() {
        let balance = FluxBalance {
            emitted: 1000.0,
            absorbed_by_receivers: 300.0,
            absorbed_elsewhere: 600.0,
            escaped: 80.0,
            given_up: 10.0,
        };
        // 1000 - 990 of 1000; an excess of 10 counts the same.
        assert_eq!(balance.closes_to(), 0.01);
        assert_eq!(FluxBalance { escaped: 100.0, ..balance }.closes_to(), 0.01);
        assert_eq!(FluxBalance { escaped: 90.0, ..balance }.closes_to(), 0.0);
        assert_eq!(FluxBalance::default().closes_to(), 0.0);
        assert_eq!(FluxBalance { emitted: 0.0, ..balance }.closes_to(), f64::INFINITY);
        let json = serde_json::to_value(balance).unwrap();
        assert_eq!((&json["escaped_lm"], &json["closes_to"]), (&80.0.into(), &0.01.into()));
    }
}
