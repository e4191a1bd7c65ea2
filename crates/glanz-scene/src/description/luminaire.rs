//! What a photometric file states about its luminaire besides the light.

use glanz_light::intensity::LuminousOpening;

/// The luminaire of a photometric file, for lists of luminaires; it has no effect on light and pictures. Texts are as written in the file, and empty where it has
/// none.
#[derive(Clone, Debug, PartialEq)]
pub struct LuminaireDescription {
    /// Name of the file, without folders.
    pub file: String,
    /// Maker.
    pub maker: String,
    /// Name.
    pub name: String,
    /// Number in the catalogue.
    pub catalog_number: String,
    /// Number and type of the lamps.
    pub lamps: String,
    /// Correlated colour temperature or colour of the light.
    pub color: String,
    /// Colour rendering.
    pub rendering: String,
    /// Luminous flux by the intensities of the file, lm.
    pub flux: f64,
    /// Electric power, watts; 0 if unknown.
    pub watts: f64,
    /// The luminous opening, also where the light leaves a point.
    pub opening: LuminousOpening,
}

impl LuminaireDescription {
    /// Its name, or else its number in the catalogue, or else the name of the file.
    #[must_use]
    pub fn label(&self) -> &str {
        let known = [&self.name, &self.catalog_number, &self.file];
        known.into_iter().find(|text| !text.trim().is_empty()).map_or("", String::as_str)
    }
}

impl Default for LuminaireDescription {
    /// A point of which nothing is known.
    fn default() -> Self {
        let [file, maker, name, catalog_number, lamps, color, rendering] = <[String; 7]>::default();
        let opening = LuminousOpening::POINT;
        Self { file, maker, name, catalog_number, lamps, color, rendering, flux: 0.0, watts: 0.0, opening }
    }
}
