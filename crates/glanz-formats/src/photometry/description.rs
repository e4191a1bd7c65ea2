//! Statements of a photometric file about its luminaire, for lists of luminaires.

use std::path::Path;

use glanz_scene::description::LuminaireDescription;

use super::{LampSet, Photometry};

/// Keywords of LM-63 files with the colour temperature and the colour rendering. The standard has none; makers write these, mostly with an underscore before them.
const COLOR_KEYWORDS: [&str; 5] = ["CCT", "COLORTEMP", "COLOR_TEMP", "COLORTEMPERATURE", "COLOR_TEMPERATURE"];
const RENDERING_KEYWORDS: [&str; 4] = ["CRI", "RA", "COLORRENDERING", "COLOR_RENDERING"];

impl Photometry {
    /// The luminaire without its light, from the file at `path`; of several sets of lamps, the first counts.
    ///
    /// Colour temperature and colour rendering are those of EULUMDAT, or of keywords of LM-63 such as `[_CCT]` and `[_CRI]`.
    #[must_use]
    pub fn description(&self, path: &Path) -> LuminaireDescription {
        let file = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        let lamps = self.lamps.first();
        let stated = |value: fn(&LampSet) -> &String, keywords: &[&str]| {
            let own = lamps.map(value).filter(|text| !text.trim().is_empty());
            own.map_or_else(|| self.keyword(keywords), |text| text.trim().to_owned())
        };
        LuminaireDescription {
            file,
            maker: self.names.manufacturer.trim().to_owned(),
            name: self.names.luminaire.trim().to_owned(),
            catalog_number: self.names.catalog_number.trim().to_owned(),
            lamps: lamps.map(shown_lamps).unwrap_or_default(),
            color: stated(|set| &set.color, &COLOR_KEYWORDS),
            rendering: stated(|set| &set.rendering, &RENDERING_KEYWORDS),
            flux: self.flux(),
            watts: self.input_watts,
            opening: self.opening,
        }
    }

    /// The text of the first of these keywords of LM-63, with or without an underscore before it; empty if there is none.
    fn keyword(&self, keywords: &[&str]) -> String {
        let is_one = |name: &str| keywords.contains(&name.trim_start_matches('_'));
        let found = self.keywords.iter().find(|(name, text)| is_one(name) && !text.trim().is_empty());
        found.map_or_else(String::new, |(_, text)| text.trim().to_owned())
    }
}

/// Number and type of lamps; absolute photometry has a negative number in EULUMDAT.
fn shown_lamps(set: &LampSet) -> String {
    let (count, name) = (set.count.abs(), set.name.trim());
    match (count, name) {
        (_, "") => String::new(),
        (count, name) if count > 1.0 => format!("{count} x {name}"),
        (_, name) => name.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::photometry::read;

    fn ies(keywords: &str, lamps: &str) -> LuminaireDescription {
        let text = format!(
            "IESNA:LM-63-2002\n{keywords}TILT=NONE\n{lamps} 1 2 1 1 2 0.6 1.2 0\n1 1 36\n0 90\n0\n300 0\n"
        );
        read(text.as_bytes()).unwrap().photometry.description(Path::new("lamps/panel.ies"))
    }

    #[test]
    fn ies_keywords_give_names_lamps_and_colour() {
        let keywords = "[MANUFAC] Maker \n[LUMINAIRE] Panel\n[LUMCAT] P-600\n[LAMP] LED module\n[_CCT] 4000 K\n[CRI] >80\n";
        let panel = ies(keywords, "2 1000");
        assert_eq!(
            (panel.file.as_str(), panel.maker.as_str(), panel.name.as_str()),
            ("panel.ies", "Maker", "Panel")
        );
        assert_eq!((panel.catalog_number.as_str(), panel.lamps.as_str()), ("P-600", "2 x LED module"));
        assert_eq!((panel.color.as_str(), panel.rendering.as_str(), panel.watts), ("4000 K", ">80", 36.0));
        assert!(panel.flux > 0.0 && panel.opening.size == [1.2, 0.6, 0.0]);
        let bare = ies("[OTHER] 4000 K\n", "1 -1");
        assert_eq!((bare.color.as_str(), bare.rendering.as_str(), bare.lamps.as_str()), ("", "", ""));
    }
}
