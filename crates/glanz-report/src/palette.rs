//! Sequences of colours.

/// A sequence of colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Palette {
    /// From dark violet to bright yellow; equal steps look equal, in grey and to colour-blind eyes too (@smith2015).
    Viridis,
    /// From blue through grey to red, for values below and above a reference (@moreland2009).
    CoolWarm,
}

/// sRGB bytes at equal distances. Straight lines between them are within 3 (viridis) and 5 (cool-warm) steps of 255 of
/// the 256 published colours.
const VIRIDIS: [[u8; 3]; 33] = [
    [68, 1, 84],
    [71, 13, 96],
    [72, 24, 106],
    [72, 35, 116],
    [71, 45, 123],
    [69, 55, 129],
    [66, 64, 134],
    [62, 73, 137],
    [59, 82, 139],
    [55, 91, 141],
    [51, 99, 141],
    [47, 107, 142],
    [44, 114, 142],
    [41, 122, 142],
    [38, 130, 142],
    [35, 137, 142],
    [33, 145, 140],
    [31, 152, 139],
    [31, 160, 136],
    [34, 167, 133],
    [40, 174, 128],
    [50, 182, 122],
    [63, 188, 115],
    [78, 195, 107],
    [94, 201, 98],
    [112, 207, 87],
    [132, 212, 75],
    [152, 216, 62],
    [173, 220, 48],
    [194, 223, 35],
    [216, 226, 25],
    [236, 229, 27],
    [253, 231, 37],
];
const COOL_WARM: [[u8; 3]; 33] = [
    [59, 76, 192],
    [68, 90, 204],
    [78, 104, 216],
    [88, 117, 225],
    [98, 130, 234],
    [108, 143, 241],
    [119, 154, 247],
    [130, 166, 251],
    [141, 176, 254],
    [152, 185, 255],
    [163, 194, 254],
    [174, 201, 252],
    [185, 208, 249],
    [195, 213, 244],
    [204, 217, 237],
    [213, 219, 229],
    [221, 220, 220],
    [229, 216, 209],
    [236, 211, 197],
    [241, 204, 184],
    [245, 196, 172],
    [247, 186, 159],
    [247, 176, 147],
    [246, 165, 134],
    [244, 152, 122],
    [240, 139, 110],
    [235, 125, 98],
    [228, 110, 86],
    [221, 95, 75],
    [212, 78, 65],
    [202, 59, 55],
    [190, 36, 46],
    [180, 4, 38],
];

impl Palette {
    /// The sRGB bytes at `position` in [0, 1]; positions outside have the colour of the nearer end, NaN that of 0.
    #[must_use]
    pub fn colour(self, position: f64) -> [u8; 3] {
        let table = match self {
            Self::Viridis => &VIRIDIS,
            Self::CoolWarm => &COOL_WARM,
        };
        // Clamping keeps NaN; casting NaN gives 0, and so does taking the larger.
        let along = position.clamp(0.0, 1.0) * (table.len() - 1) as f64;
        let index = (along as usize).min(table.len() - 2);
        let part = (along - index as f64).max(0.0);
        let (from, to) = (table[index], table[index + 1]);
        let mut colour = [0; 3];
        for (channel, value) in colour.iter_mut().enumerate() {
            *value = (f64::from(from[channel]) * (1.0 - part) + f64::from(to[channel]) * part).round() as u8;
        }
        colour
    }
}

/// A colour in the notation of HTML and SVG.
#[must_use]
pub fn hexadecimal([r, g, b]: [u8; 3]) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// Black or white, whichever has the larger contrast ratio on a colour: white below the luminance Y at which both are equal, (1 + 0.05) / (Y + 0.05) = (Y + 0.05) / 0.05.
#[must_use]
pub fn contrasting(colour: [u8; 3]) -> &'static str {
    let linear = colour.map(|byte| f64::from(glanz_light::rgb::srgb_decode(f32::from(byte) / 255.0)));
    let turning = (1.05_f64 * 0.05).sqrt() - 0.05;
    if glanz_light::rgb::luminance(linear) < turning { "#ffffff" } else { "#000000" }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_the_published_ones_at_known_places() {
        // Of the published table of 256: numbers 0, 51, 204 and 255, of which 51 and 204 lie between ours.
        let near = |place: f64, published: [u8; 3]| {
            let colour = Palette::Viridis.colour(place);
            let off = (0..3).map(|i| colour[i].abs_diff(published[i])).max();
            assert!(off <= Some(3), "{place}: {colour:?}");
        };
        near(0.0, [0x44, 0x01, 0x54]);
        near(0.2, [0x41, 0x44, 0x87]);
        near(0.8, [0x7a, 0xd1, 0x51]);
        near(1.0, [0xfd, 0xe7, 0x25]);
        assert_eq!(Palette::CoolWarm.colour(0.5), [221, 220, 220]);
        assert_eq!(Palette::Viridis.colour(f64::NAN), Palette::Viridis.colour(-7.0));
        assert_eq!(Palette::Viridis.colour(f64::INFINITY), [253, 231, 37]);
    }

    #[test]
    fn luminance_of_viridis_only_grows() {
        let luminance = |i: u32| {
            let colour = Palette::Viridis.colour(f64::from(i) / 64.0);
            let linear = colour.map(|b| f64::from(glanz_light::rgb::srgb_decode(f32::from(b) / 255.0)));
            glanz_light::rgb::luminance(linear)
        };
        assert!((0..64).all(|i| luminance(i) < luminance(i + 1)));
        assert_eq!(
            (contrasting(Palette::Viridis.colour(0.0)), contrasting(Palette::Viridis.colour(1.0))),
            ("#ffffff", "#000000")
        );
    }
}
